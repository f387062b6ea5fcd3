"""Mass, centre of mass and momenta over a run, from the masses that the equations of motion hold."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flexmb import arguments, checks
from flexmb.display.text import counted
from flexmb.errors import InputError
from flexmb.model.mechanism import Mechanism
from flexmb.program.compiler import compile as compile_mechanism
from flexmb.program.program import Program
from flexmb.results.signal_names import SAVED_KEY
from flexmb.results.solution import Solution
from flexmb.system.state_evaluation import StateEvaluation


@dataclass(frozen=True)
class Momentum:
    """Mass and momenta at n instants.

    Parameters
    ----------
    time : (n,) instants [s].
    mass : the mass [kg].
    centre : (n, 2) centre of mass [m].
    linear : (n, 2) linear momentum [kg m/s].
    angular : (n,) angular momentum about the origin [kg m^2/s].
    """

    time: np.ndarray
    mass: float
    centre: np.ndarray
    linear: np.ndarray
    angular: np.ndarray

    def __repr__(self) -> str:
        span = f", {self.time[0]:.6g} to {self.time[-1]:.6g} s" if len(self.time) else ""
        return f"Momentum of {self.mass:.6g} kg at {counted(len(self.time), 'instant')}{span}"


@arguments.checked
def momentum(mechanism: Mechanism, solution: Solution, bodies: Sequence[str] | None = None) -> Momentum:
    """Centre of mass, linear and angular momentum of bodies at the saved instants of a solution.

    Parameters
    ----------
    mechanism : the mechanism that was simulated.
    solution : its solution.
    bodies : names of the bodies that are counted together; None: all.

    Raises
    ------
    InputError : the name of no body, no body at all, a solution of another mechanism.

    Notes
    -----
    With the mass matrix M(q) and rigid motions e_x, e_y, e_theta (about the origin) of the bodies, the momenta are
    e^T M v, the mass is e_x^T M e_x, and m (-y, x) of the centre of mass are e_x^T M e_theta and e_y^T M e_theta: the
    consistent mass of beams and their bosses are counted, not masses on the nodes.
    Mass that couples bodies (elements of one's own) is counted where velocities of the chosen bodies feel it.
    """
    program = compile_mechanism(mechanism)
    label = f"momentum {mechanism.name!r}"
    if not isinstance(solution, Solution):
        raise InputError(f"{label}: solution is {solution!r}; it must be what simulate(...) or load(...) returns.")
    names = program.names.bodies if bodies is None else checks.sequence(label, "bodies", bodies, "names")
    for name in names:
        checks.one_of(label, "body", name, program.names.bodies)
    if not names:
        raise InputError(f"{label}: bodies is empty; name at least one, or leave it out for all.")
    n_b = program.tables.sizes.n_b
    places = _places_of_motion(label, solution, program)
    owners = np.asarray([*program.names.bodies, *[""] * (program.n_q - n_b)])
    q, v = np.zeros((2, program.n_q))  # states of controls have no momentum
    chosen = np.isin(owners[np.asarray(program.reference.body[::3])], names)
    system, rows = StateEvaluation(program), []
    for values in solution.values:
        q[:n_b], v[:n_b] = values[places[:n_b]], values[places[n_b:]]
        rigid = motions(q, chosen)
        M = system.mass(q)
        rows.append(np.concatenate([rigid.T @ (M @ v), (rigid.T @ (M @ rigid))[:2].ravel()]))
    found = np.array(rows).reshape(-1, 9)
    mass = float(found[0, 3]) if len(found) else 0.0
    centre = np.stack([found[:, 8], -found[:, 5]], axis=1) / (mass or 1.0)
    return Momentum(np.asarray(solution.time), mass, centre, found[:, :2], found[:, 2])


def _places_of_motion(label: str, solution: Solution, program: Program) -> np.ndarray:
    """Places of positions and velocities of bodies (2 n_b,) among the signals of the solution."""
    known, places = program.names.signals, solution.signals.places
    if not set(solution.names) <= known.places.keys() or (
        SAVED_KEY not in solution.model and len(places) < len(program.reported)
    ):
        raise InputError(f"{label}: the solution of {solution.name!r} has other signals. Give that of this mechanism.")
    n, n_b = program.n_q, program.tables.sizes.n_b
    needed = (*known.names[:n_b], *known.names[n : n + n_b])
    missing = [name for name in needed if name not in places]
    if missing:
        text = f"{label}: {len(missing)} positions and velocities were not saved, the first is {missing[0]!r}"
        raise InputError(f"{text}. Add them to simulate(..., signals=[...]), or leave it out to save all.")
    return np.array([places[name] for name in needed])


def motions(q: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    """Velocities (n_q, 3) of the chosen nodes when they move as one rigid body along X, along Y, about the origin."""
    basis = np.zeros((len(q), 3))
    on = chosen.astype(float)
    basis[0::3, 0], basis[1::3, 1], basis[2::3, 2] = on, on, on
    basis[0::3, 2], basis[1::3, 2] = -on * q[1::3], on * q[0::3]
    return basis
