"""Names, units and places of the signals that a run reports.

The vector of signals holds q, v, a of all coordinates, then constraints, contacts, relative rotations, measured
signals, controls, and energies.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from flexmb.model.contributions import ConstraintContribution, Contributions, RowMotion, SignalContribution
from flexmb.model.mechanism import Mechanism
from flexmb.model.signal import Signals

COORDINATE_SIGNALS = (
    (("x", "m"), ("y", "m"), ("theta", "rad")), (("vx", "m/s"), ("vy", "m/s"), ("omega", "rad/s")),
    (("ax", "m/s2"), ("ay", "m/s2"), ("alpha", "rad/s2")),
)  # fmt: skip
ANGLE_SIGNALS = (("angle", "rad"), ("omega", "rad/s"))
FORCE_SIGNALS = (("fx", "N"), ("fy", "N"), ("force", "N"))
CONTACT_SIGNALS = (
    ("ex", "m"), ("ey", "m"), ("vex", "m/s"), ("vey", "m/s"), ("penetration", "m"), ("penetration_rate", "m/s"),
    ("normal_force", "N"), ("friction_force", "N"), ("fx", "N"), ("fy", "N"), ("force", "N"), ("mode", ""),
)  # fmt: skip
# Names and units of coordinate, velocity and acceleration of a state of a control, by its name and unit.
STATE_SIGNALS = (("{}_integral", "{} s"), ("{}", "{}"), ("{}_rate", "{}/s"))
CONTACT_PENETRATION = [name for name, _ in CONTACT_SIGNALS].index("penetration")
ENERGY_SIGNALS = (
    "kinetic", "strain", "gravity", "drive_work", "load_work", "dissipated_contact", "dissipated_friction",
    "dissipated_damping", "dissipated_algorithm", "residual", "turned_over",
)  # fmt: skip


@dataclass(frozen=True)
class Layout:
    """All signals; the first of constraints, contacts, relative rotations, measured ones, controls and energies."""

    signals: Signals
    constraints: tuple[int, ...]
    contacts: tuple[int, ...]
    angles: tuple[int, ...]
    measured: tuple[int, ...]
    controls: tuple[int, ...]
    energy: int


def force_signals(contribution: ConstraintContribution) -> tuple[tuple[str, str], ...]:
    """Signals of a joint's force on its second body and of its friction; of a coupling its friction alone."""
    if contribution.is_drive:
        return ()
    told = contribution.joint_friction.signal if contribution.joint_friction else ("", "")
    friction = (told,) if told[0] else ()
    if contribution.reactions:
        return friction
    moment = (("moment", "N m"),) if contribution.moment_row >= 0 else ()
    return (*FORCE_SIGNALS, *moment, *friction)


def motion_signals(driven: RowMotion) -> tuple[tuple[str, str], ...]:
    """Signals of a driven row: coordinate, rate, force, power."""
    unit, force = driven.units
    if not driven.name:
        value, load = ("angle", "torque") if unit == "rad" else ("travel", "force")
        return (value, unit), ("speed", f"{unit}/s"), (load, force), ("power", "W")
    kind = "torque" if unit == "rad" else "force"
    names = (driven.name, f"{driven.name}_rate", f"{driven.name}_{kind}", f"{driven.name}_power")
    return tuple(zip(names, (unit, f"{unit}/s", force, "W"), strict=True))


def kernel_signals(contribution: SignalContribution) -> tuple[tuple[str, str], ...]:
    """Signal of a kernel, and that of its place."""
    own = (contribution.name, contribution.units)
    return (own, (contribution.place, "")) if contribution.place else (own,)


def constraint_signals(contribution: ConstraintContribution) -> tuple[tuple[str, str], ...]:
    """Signals of a constraint: the force of a joint, the motions of its driven rows, its own reactions."""
    motions = (signal for driven in contribution.motions for signal in motion_signals(driven))
    reactions = ((reaction.name, reaction.units) for reaction in contribution.reactions)
    return (*force_signals(contribution), *motions, *reactions)


def layout(contributions: Contributions, coordinate_names: tuple[str, ...], n_b: int | None = None) -> Layout:
    """Signals of a mechanism; n_b: number of coordinates of bodies, before the states of controls; None: all."""
    n_b = len(coordinate_names) if n_b is None else n_b
    stems = [name.rpartition(".")[0] for name in coordinate_names[:n_b:3]]
    pairs = ((c.part, zip(c.states, c.state_units, strict=True)) for c in contributions.controls)
    given = {f"{part}.{state}": unit for part, own in pairs for state, unit in own}
    states = [(name, given.get(name, "")) for name in coordinate_names[n_b:]]
    names, units = [], []
    for level, (name_of, unit_of) in zip(COORDINATE_SIGNALS, STATE_SIGNALS, strict=True):
        names += [f"{stem}.{name}" for stem in stems for name, _ in level]
        names += [name_of.format(name) for name, _ in states]
        units += [unit for _ in stems for _, unit in level]
        units += [unit_of.format(unit).strip() for _, unit in states]

    def more(owner: str, found: Sequence[tuple[str, str]]) -> int:
        first = len(names)
        names.extend([f"{owner}.{name}" for name, _ in found])
        units.extend([unit for _, unit in found])
        return first

    constraints = tuple([more(one.part, constraint_signals(one)) for one in contributions.constraints])
    contacts = tuple([more(contribution.label, CONTACT_SIGNALS) for contribution in contributions.contacts])
    angles = tuple([more(contribution.part, ANGLE_SIGNALS) for contribution in contributions.angles])
    measured = tuple([more(contribution.part, kernel_signals(contribution)) for contribution in contributions.signals])
    controls = []
    for control in contributions.controls:  # its outputs; of a sampled one its states before them
        own = zip(control.states, control.state_units, strict=True) if control.is_sampled else ()
        controls.append(more(control.part, [*own, *zip(control.outputs, control.output_units, strict=True)]))
    energy = more("energy", [(name, "J") for name in ENERGY_SIGNALS])
    return Layout(Signals(names, units), constraints, contacts, angles, measured, tuple(controls), energy)


def aliases(mechanism: Mechanism) -> dict[str, str]:
    """Other names of nodes: "rod" and "rod.start" for "rod.node4" and "rod.node0"."""
    found = {}
    for body in mechanism.bodies:
        if body.main:
            found[body.name] = f"{body.name}.{body.main}"
        for alias, node in body.aliases.items():
            found[f"{body.name}.{alias}"] = f"{body.name}.{node}"
    return found
