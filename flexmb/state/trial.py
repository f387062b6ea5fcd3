"""The state that a step tries, and vectors of its linear system."""

from __future__ import annotations

import numpy as np

from flexmb.compiled.records import Flags, Matrix, Record, Vector
from flexmb.program.program import Program
from flexmb.state.flow import Prediction, Reuse
from flexmb.system.templates import fresh


class Bounds(Record, frozen=True):
    """Numbers of the step control at contacts.

    rtol : tolerance of velocities;  least_speed : least speed that it is relative to [m/s]
    impact_steps : steps of an impact at least;  flight : how much more the error of positions counts in free flight
    """

    rtol: float
    least_speed: float
    impact_steps: float
    flight: float


class Trial(Record):
    """The state that a step tries, and vectors of the linear system.

    free : (number of redundant rows, n_c) orthonormal multipliers without effect
    rigid : (n_q,) coordinates of rigid bodies
    c, pair : second right side, and workspace for two;  before : (n_q + n_c,) last correction
    gaps : (n_c,) what the shifts of this step close in all
    prediction, reuse, slopes : what those of `Flow` become if the step is accepted
    """

    bounds: Bounds
    prediction: Prediction
    reuse: Reuse
    q: Vector
    v: Vector
    a: Vector
    x: Vector
    lam: Vector
    mean_v: Vector
    lag: Vector
    b: Vector
    d: Vector
    e: Vector
    seen: Vector
    y: Vector
    free: Matrix
    rigid: Flags
    c: Vector
    pair: Vector
    before: Vector
    gaps: Vector
    slopes: Matrix


def new_trial(program: Program, redundant: int = 0, bounds: tuple[float, ...] = (1.0, 1.0, 1.0, 1.0)) -> Trial:
    """Work vectors; `redundant` rows more than the joints need, `bounds` of the step control."""
    given = Bounds(*bounds)
    return fresh(program, ("trial", redundant), lambda: _blank_trial(program, redundant, given), bounds=given)


def _blank_trial(program: Program, redundant: int, bounds: Bounds) -> Trial:
    n, m = program.n_q + 3, program.n_c
    total = program.n_q + m
    vectors = dict.fromkeys(("q", "v", "a", "x", "mean_v", "lag"), n) | dict.fromkeys(("lam", "gaps"), m)
    vectors |= dict.fromkeys(("b", "c", "d", "e", "seen", "y", "before"), total)
    return Trial(
        **vectors,
        pair=2 * total,
        free=(redundant, m),
        rigid=rigid_coordinates(program),
        bounds=bounds,
        prediction=Prediction.zeros(),
        reuse=Reuse.zeros(),
        slopes=(len(program.tables.contacts.kernel) + len(program.tables.constraints.kernel), 4),
    )


def rigid_coordinates(program: Program) -> np.ndarray:
    """Whether each coordinate (n_q,) is one of a rigid body."""
    body = program.drawn.body[::3]
    return np.repeat(np.bincount(body)[body] == 1, 3)
