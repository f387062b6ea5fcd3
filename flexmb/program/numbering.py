"""Numbers of coordinates and unknowns, the elimination order of the matrix, names, units and places of signals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import chain, pairwise
from typing import Any

import numpy as np

from flexmb.model import contributions as model
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import GROUND
from flexmb.model.signal import Signals

ONE_PLACE = 1e-9  # extent of nodes over their distance from the origin, up to which they lie in one place
UNUSED = ("unused1", "unused2")  # names of coordinates that fill up the states of a control to threes


@dataclass(frozen=True, eq=False)
class Lists:
    """Lists of whole numbers, one behind the other in `values`; list k is values[ptr[k] : ptr[k + 1]]."""

    ptr: np.ndarray
    values: np.ndarray

    @staticmethod
    def of(lists: Sequence[Sequence[int]]) -> Lists:
        """These lists."""
        lengths = np.fromiter(map(len, lists), dtype=np.int64, count=len(lists))
        ptr = np.concatenate([[0], np.cumsum(lengths)]).astype(np.int64)
        return Lists(ptr, np.fromiter(chain.from_iterable(lists), dtype=np.int64, count=int(ptr[-1])))


class Numbering:
    """Numbers of the coordinates of a mechanism: three a node, in the order of declaration, bodies before controls."""

    def __init__(self, mechanism: Mechanism, *, controls: bool = True) -> None:
        bodies = mechanism.nodes()
        self.n_b = 3 * len(bodies)
        # controller, node and names of three states at a time of controllers without sampling; missing ones stay 0
        self._states: list[tuple[str, model.Node, tuple[str, ...]]] = []
        for control in [controller.control() for controller in mechanism.controllers] if controls else ():
            for k in range(0, 0 if control.sample is not None else len(control.states), 3):
                names = (*control.states[k : k + 3], *UNUSED)[:3]
                self._states.append((control.part, model.Node(state_node(k), 0.0, 0.0, 0.0), names))
        self.nodes: tuple[tuple[str, model.Node], ...] = (*bodies, *((part, node) for part, node, _ in self._states))
        self.of_body: dict[str, tuple[int, int]] = {}  # where the coordinates of each body begin and end
        for k, (part, _) in enumerate(self.nodes):
            self.of_body[part] = self.of_body.get(part, (3 * k, 0))[0], 3 * k + 3
        self.n_q = 3 * len(self.nodes)
        named = [(part, node.name) for part, node in self.nodes]
        every = [(part, node, axis) for part, node in (*named, (GROUND.name, "")) for axis in (0, 1, 2)]
        self._number: dict[model.Coordinate, int] = dict(zip(every, range(len(every)), strict=True))
        self._lists: dict[int, tuple[Sequence[Any], Lists]] = {}

    def dofs(self, coordinates: Sequence[model.Coordinate]) -> list[int]:
        """Numbers of coordinates; the ground's are n_q, n_q + 1, n_q + 2."""
        return [self._number[c] for c in coordinates]

    def lists(self, contributions: Sequence[Any]) -> Lists:
        """Numbers of the `coordinates` of each piece, remembered for the same sequence of pieces."""
        if id(contributions) not in self._lists:
            number = self._number.__getitem__
            numbers = [list(map(number, contribution.coordinates)) for contribution in contributions]
            self._lists[id(contributions)] = (contributions, Lists.of(numbers))
        return self._lists[id(contributions)][1]

    def names(self) -> tuple[str, ...]:
        """Names of the coordinates: of bodies by node and axis, of controls by state."""
        stems = [f"{part}.{node.name}" if node.name else part for part, node in self.nodes[: self.n_b // 3]]
        states = [f"{part}.{name}" for part, _, names in self._states for name in names]
        return (*[f"{stem}.{axis}" for stem in stems for axis in model.AXES], *states)

    def pose(self) -> np.ndarray:
        """Coordinates of the reference configuration (n_q,) [m, rad]."""
        return np.array([x for _, n in self.nodes for x in (n.x, n.y, n.theta)], dtype=float)

    @cached_property
    def extent(self) -> float:
        """Extent of the nodes in the reference configuration [m]; of one place its distance from the origin, or 1."""
        points = self.pose()[: self.n_b].reshape(-1, 3)[:, :2]
        end = points[np.argmax(np.hypot(*(points - points.mean(axis=0)).T))]
        extent, distance = float(np.hypot(*(points - end).T).max()), float(np.hypot(*points.T).max())
        return (extent if extent > ONE_PLACE * distance else distance) or 1.0


def state_node(state: int) -> str:
    """Name of the node that holds a state of a control, by the number of the state."""
    return f"states{state // 3}"


def state_coordinates(control: model.ControlContribution) -> tuple[model.Coordinate, ...]:
    """Coordinates of the states of a control, in threes; none of a sampled one."""
    nodes = range(0, 0 if control.sample is not None else len(control.states), 3)
    return tuple((control.part, state_node(k), axis) for k in nodes for axis in (0, 1, 2))


def blocks_and_edges(
    contributions: model.Contributions, number: Numbering
) -> tuple[list[range], list[tuple[int, ...]], list[bool]]:
    """Blocks of unknowns (nodes, then constraints), groups of coupled blocks, and which blocks are constraints."""
    n_nodes = number.n_q // 3
    blocks = [range(3 * k, 3 * k + 3) for k in range(n_nodes)]
    groups = (contributions.elements, contributions.contacts, contributions.constraints)
    touched = [nodes for group in groups for nodes in _nodes_of(number.lists(group), n_nodes)]
    free, row = len(touched) - len(contributions.constraints), number.n_q
    touched += _nodes_of(Lists.of([number.dofs(control.touched) for control in contributions.controls]), n_nodes)
    for k, contribution in enumerate(contributions.constraints):
        touched[free + k] = (*touched[free + k], n_nodes + k)
        blocks.append(range(row, row + contribution.rows))
        row += contribution.rows
    return blocks, touched, [False] * n_nodes + [True] * len(contributions.constraints)


def _nodes_of(dofs: Lists, ground: int) -> list[tuple[int, ...]]:
    """The nodes that each piece stands on, ascending, without that of the ground."""
    nodes, bounds = (dofs.values // 3).tolist(), dofs.ptr.tolist()
    found = []
    for begin, end in pairwise(bounds):
        own = sorted(set(nodes[begin:end]))
        found.append(tuple(own[:-1] if own and own[-1] == ground else own))
    return found


# The vector of signals holds q, v, a of all coordinates, then constraints, contacts, relative rotations, measured
# signals, controls, and energies.

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


def force_signals(contribution: model.ConstraintContribution) -> tuple[tuple[str, str], ...]:
    """Signals of a joint's force on its second body and of its friction; of a coupling its friction alone."""
    if contribution.is_drive:
        return ()
    told = contribution.joint_friction.signal if contribution.joint_friction else ("", "")
    friction = (told,) if told[0] else ()
    if contribution.reactions:
        return friction
    moment = (("moment", "N m"),) if contribution.moment_row >= 0 else ()
    return (*FORCE_SIGNALS, *moment, *friction)


def kernel_signals(contribution: model.SignalContribution) -> tuple[tuple[str, str], ...]:
    """Signal of a kernel, and that of its place."""
    own = (contribution.name, contribution.units)
    return (own, (contribution.place, "")) if contribution.place else (own,)


def constraint_signals(contribution: model.ConstraintContribution) -> tuple[tuple[str, str], ...]:
    """Signals of a constraint: the force of a joint, the motions of its driven rows, its own reactions."""
    motions: list[tuple[str, str]] = []
    for driven in contribution.motions:  # coordinate, rate, force, power
        unit, force = driven.units
        value, load = ("angle", "torque") if unit == "rad" else ("travel", "force")
        names = [value, "speed", load, "power"]
        if driven.name:
            names = [driven.name, *(f"{driven.name}_{end}" for end in ("rate", load, "power"))]
        motions += zip(names, (unit, f"{unit}/s", force, "W"), strict=True)
    reactions = ((reaction.name, reaction.units) for reaction in contribution.reactions)
    return (*force_signals(contribution), *motions, *reactions)


def layout(contributions: model.Contributions, coordinate_names: tuple[str, ...], n_b: int | None = None) -> Layout:
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
