"""Error that a run accumulates in vibrations: phase and amplitude that the steps lose, also under drives and loads.

The modes about some saved states say how much of the elastic energy is that of a vibration
(`flexmb.equilibrium.vibrations`), and the method's own factor how much of it the steps shift.
"""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

import numpy as np

from flexmb.bodies.flexible_body import FlexibleBody
from flexmb.errors import FlexmbError
from flexmb.joints.bushing import Bushing
from flexmb.loads.spring_damper import SpringDamper
from flexmb.loads.torsion_spring import TorsionSpring
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import Element
from flexmb.program.program import Program
from flexmb.run.dispersion import Loss, loss_of
from flexmb.run.watch import Saved, saved_columns
from flexmb.step.method import Method

if TYPE_CHECKING:
    from flexmb.equilibrium.vibrations import LinearModes, State

ELASTIC = (FlexibleBody, SpringDamper, TorsionSpring, Bushing, Element)
"""Parts that can hold a vibration, beside those of MESHED."""

MESHED = (("flexmb.reduction.reduced", "Reduced"), ("flexmb.planes.plane_body", "PlaneBody"))
"""Modules of further ones, which are imported where there are such bodies, and names of their classes."""

MOST_UNKNOWNS = 400
"""Number of coordinates above which modes would take too long."""

POSES, POSES_OF_LARGE, AROUND = 6, 2, (-2, -1, 0, 1)
"""Number of poses that are looked at, also of large models, and saved instants around each, by their distance."""

LARGE = 150
"""Number of coordinates of a large model."""

FEWEST_INSTANTS = 12
"""Number of saved instants below which energies are not known."""

ENERGY_SHARE = 0.01
"""Share of the elastic energy of the motion above which a mode matters."""

DECAY = 0.1
"""Energy in the last third of a run over that in the first one, below which a vibration has died out."""

PART_OF_STEP = 0.1
"""Time of the differences along the motion, relative to a step."""

UNRESOLVED = 1.0
"""Angular frequency times step above which a vibration is not resolved."""

LOST_PHASE, LOST_AMPLITUDE = 0.1, 2e-3
"""Phase [rad] and share of the amplitude that may be lost without a remark."""


def vibration_remarks(
    mechanism: Mechanism, program: Program, saved: Saved, method: Method, steps: int, begun: float, end: float
) -> list[str]:
    """Remarks on the fastest vibration that carries energy, where the steps lose a part of it that matters.

    For mechanisms with flexible bodies or springs and without contacts, all of whose coordinates were saved.

    Parameters
    ----------
    mechanism, program : the mechanism, and its program.
    saved : results of the run.
    method : method of integration.
    steps : number of steps.
    begun, end : instants at which these steps begin and end [s].
    """
    if steps < 1 or loss_of(method, 1.0, 1.0, 1.0) is None:
        return []
    states, span = _states(mechanism, program, saved), end - begun
    if not states:
        return []
    from flexmb.equilibrium.vibrations import energies_of_modes

    try:
        energies, modes = energies_of_modes(program, states, PART_OF_STEP * span / steps)
    except (FlexmbError, np.linalg.LinAlgError):  # no modes: the run has said why
        return []
    for k in range(energies.shape[2])[::-1]:
        share, decayed = share_of(energies, k)
        found = _loss(method, modes, k, span, steps) if share > ENERGY_SHARE else None
        if found is None or (decayed and found.amplitude < 0.5):
            continue
        if abs(found.phase) < LOST_PHASE and abs(found.amplitude) < LOST_AMPLITUDE:
            continue
        moves = _moves(program, modes, k)
        return [_remark(float(modes.omega[k]), moves, share, found, driven=bool(program.drives or program.motions))]
    begins = saved.fixed_step is not None and states[0].t == begun
    return _unresolved_start(program, energies, modes, saved.fixed_step or 0.0) if begins else []


def _unresolved_start(program: Program, energies: np.ndarray, modes: LinearModes, h: float) -> list[str]:
    """Remark on a vibration with which a run begins, where fixed steps of size h [s] are too long for its period."""
    whole = float(energies[:, 0].sum(axis=1).mean())
    begun = 0.5 * energies[0, 2]  # y less what slow loads give is -y''/omega^2
    coarse = np.flatnonzero((modes.omega[: len(begun)] * h > UNRESOLVED) & (begun > ENERGY_SHARE * whole))
    if not len(coarse):
        return []
    k = int(coarse[np.argmax(begun[coarse])])
    period = 2.0 * np.pi / float(modes.omega[k])
    moves = _moves(program, modes, k)
    return [
        f"The run begins with a vibration of {1.0 / period:.4g} Hz (mostly {moves}), {h / period:.2g} of whose period "
        f"is one step of {h:.3g} s: its peaks are not resolved. Take steps of {period / 20.0:.1g} s, Adaptive(), or a "
        "drive that starts softly."
    ]


def _remark(omega: float, moves: str, share: float, lost: Loss, *, driven: bool) -> str:
    """Remark on a vibration; `driven`: beside a motion by drives or loads."""
    energy = "elastic energy of the motion" if driven else "energy of vibration"
    verb = "lose" if lost.amplitude >= 0.0 else "add"
    return (
        f"The vibration of {omega / (2.0 * np.pi):.4g} Hz (mostly {moves}) carries {100.0 * min(share, 1.0):.3g} % "
        f"of the {energy}; until the end the steps lose some {abs(lost.phase):.2g} rad of its phase and {verb} "
        f"{100.0 * abs(lost.amplitude):.3g} % of its amplitude. A smaller rtol or step, or RadauIIA(), loses less."
    )


def _moves(program: Program, modes: LinearModes, k: int) -> str:
    """Name of the coordinate that mode k moves most."""
    from flexmb.equilibrium.free_motions import moves_most

    return moves_most(program.names.coordinates, program.length, modes.shapes[:, k])


def _loss(method: Method, modes: LinearModes, k: int, span: float, steps: int) -> Loss | None:
    """Loss of mode k in the time that its damping lets it remember."""
    memory = min(1.0, 1.0 / max(float(modes.decay[k]) * span, 1e-300))
    return loss_of(method, float(modes.omega[k]), span / steps, memory * steps)


def _states(mechanism: Mechanism, program: Program, saved: Saved) -> list[State]:
    """Saved states at uneven distances; none where there is nothing elastic, or where not all was saved."""
    few = program.n_q <= MOST_UNKNOWNS and not program.names.contacts
    count = len(saved.time)
    if not few or count < FEWEST_INSTANTS or not any(isinstance(part, _elastic()) for part in mechanism.parts):
        return []
    names = [name.rpartition(".") for name in program.names.coordinates[: program.tables.sizes.n_b]]
    columns = [saved_columns(saved, [f"{part}.{kind[axis]}" for part, _, axis in names]) for kind in KINDS]
    if None in columns:
        return []
    poses = np.arange(POSES if program.n_q < LARGE else POSES_OF_LARGE)
    anchors = 2 + (poses + poses * 0.618034 % 1.0) / len(poses) * (count - 4)
    rows = np.unique(anchors.astype(int)[:, None] + np.array(AROUND))
    from flexmb.equilibrium.vibrations import State

    return [State(float(saved.time[k]), *(saved.values[k, where] for where in columns)) for k in rows]


def _elastic() -> tuple[type, ...]:
    """Classes of parts that can hold a vibration."""
    return (*ELASTIC, *(vars(sys.modules[module])[name] for module, name in MESHED if module in sys.modules))


KINDS = (
    {"x": "x", "y": "y", "theta": "theta"},
    {"x": "vx", "y": "vy", "theta": "omega"},
    {"x": "ax", "y": "ay", "theta": "alpha"},
)
"""Names of coordinates, velocities and accelerations by the name of the coordinate."""


def share_of(energies: np.ndarray, k: int) -> tuple[float, bool]:
    """Largest share of a mode in the elastic energy of the motion in a third of the run, and whether it dies out.

    Parameters
    ----------
    energies : (states, 3, modes) as of `energies_of_modes`.
    k : number of the mode.
    """
    whole = float(energies[:, 0].sum(axis=1).mean())
    thirds = [float(third[:, :, k].mean(axis=0).min()) for third in np.array_split(energies, 3)]
    return max(thirds) / whole if whole > 0.0 else 0.0, thirds[-1] < DECAY * thirds[0]
