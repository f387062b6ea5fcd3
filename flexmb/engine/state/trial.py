"""Trial state of a step, and the vectors of its linear system."""

from __future__ import annotations

import numpy as np

from flexmb.engine.compiled.records import Flags, Integers, Matrix, Record, Vector
from flexmb.engine.state.flow import JacobianReuse, Predictor
from flexmb.engine.system.work import new_from_template
from flexmb.program.program import Program, body_groups


class StepControl(Record, frozen=True):
    """Numbers of the step control, in addition to `Options`."""

    rtol: float  # tolerance of velocities relative to the largest speed
    least_speed: float  # least speed to which that tolerance is relative [m/s]
    impact_steps: float  # least number of steps of an impact
    flight_weight: float  # factor of the error of positions in free flight


class NewtonIteration(Record):
    """State of the Newton iteration of a trial step."""

    order: int  # order of the prediction from which the iteration started
    reusing: bool  # whether the correction comes from factors of an earlier iteration or step
    may_reuse: bool  # whether factors of this step may serve further iterations
    measuring: bool  # whether the contraction rate is due to be measured in this step
    factorisations: int  # matrices factored in this step
    reused: int  # corrections with the present factors
    last_size: float  # size of the last correction over its tolerance; inf: no comparable one
    fraction: float  # fraction of the correction that is applied; less than 1: damped
    reach: float  # largest length of a damped correction; inf: not damped
    hold: float  # relative pivot of a constraint below which its row is held
    held: int  # result of the last factorisation (`linalg.lu.factor`)


class Trial(Record):
    """Trial state of a step, and the vectors of its linear system."""

    control: StepControl
    predictor: Predictor  # predictor, reuse, slopes: the same fields of `Flow` after this step, if it is accepted
    reuse: JacobianReuse
    newton: NewtonIteration  # state of the Newton iteration
    q: Vector  # q, v, a, x, lam: the state at the end of the step, as in `Flow`
    v: Vector
    a: Vector
    x: Vector
    lam: Vector
    mean_v: Vector  # (n_q + 3,) (q1 - q0)/h
    newmark_residual: Vector  # (n_q + 3,) h (a0 + a1)/2 - (v1 - v0)
    rhs: Vector  # rhs, gap_rhs: (n_q + n_c,) right-hand sides of the corrections and of the position shift
    solution: Vector  # (n_q + n_c,) Newton's correction of coordinates and multipliers
    shift: Vector  # (n_q + n_c,) position shift that closes the joints (Gear, Gupta, Leimkuhler)
    pivot_scale: Vector  # (n_q + n_c,) largest term summed up to each pivot; negative for a held row
    scratch: Vector  # scratch, scratch_pair: (n_q + n_c,), (2 (n_q + n_c),) workspaces of the solver
    free_multipliers: Matrix  # (redundant rows, n_c) orthonormal multipliers u with G^T u = 0
    left_out: Integers  # places in `pivot_scale` of rows that every factorisation holds
    left_out_pivots: Integers  # places of their pivots in the factors
    rigid: Flags  # (n_q,) whether a coordinate belongs to a rigid body
    gap_rhs: Vector
    scratch_pair: Vector
    last_correction: Vector  # (n_q + n_c,) correction of the iteration before
    projected_gaps: Vector  # (n_c,) gaps that the position shifts of this step close in all
    slopes: Matrix
    groups: Integers  # (n_q,) group of connected bodies of each coordinate
    contact_groups: Integers  # (contacts,) group of each contact
    speeds: Vector  # (groups,) largest speeds of the run up to the trial state [m/s], as `Flow.largest_speeds`


def new_trial(
    program: Program,
    redundant: int = 0,
    control: tuple[float, ...] = (1.0, 1.0, 1.0, 1.0),
    left_out: tuple[int, ...] = (),
) -> Trial:
    """A trial state of zeros; `redundant`: number of redundant constraint equations, `control`: see `StepControl`."""
    # `left_out` : numbers of constraint equations that every factorisation holds.
    given, key = StepControl(*control), ("trial", redundant, len(left_out))
    new = new_from_template(program, key, lambda: _zero_trial(program, redundant, given, len(left_out)), control=given)
    if left_out:
        unknowns = program.n_q + np.array(left_out, dtype=np.int64)
        new.left_out[:] = np.argsort(program.symbolic.order)[unknowns]
        new.left_out_pivots[:] = program.symbolic.positions(unknowns, unknowns)
    return new


def _zero_trial(program: Program, redundant: int, control: StepControl, left_out: int) -> Trial:
    n, m = program.n_q + 3, program.n_c
    total, groups = program.n_q + m, body_groups(program)
    states = dict.fromkeys(("q", "v", "a", "x", "mean_v", "newmark_residual"), n)
    states |= dict.fromkeys(("lam", "projected_gaps"), m)
    vectors = ("rhs", "gap_rhs", "solution", "shift", "pivot_scale", "scratch", "last_correction")
    return Trial(
        **states,
        **dict.fromkeys(vectors, total),
        scratch_pair=2 * total,
        free_multipliers=(redundant, m),
        left_out=np.zeros(left_out, dtype=np.int64),
        left_out_pivots=np.zeros(left_out, dtype=np.int64),
        rigid=rigid_coordinates(program),
        groups=groups[: program.n_q],
        contact_groups=np.maximum(*groups[program.tables.contacts.dofs.astype(np.int64).reshape(-1, 6)[:, ::3].T]),
        speeds=int(groups.max(initial=-1)) + 1,
        control=control,
        predictor=Predictor.zeros(),
        reuse=JacobianReuse.zeros(),
        newton=NewtonIteration.zeros(),
        slopes=(len(program.tables.contacts.kernel) + len(program.tables.constraints.kernel), 4),
    )


def rigid_coordinates(program: Program) -> np.ndarray:
    """Whether each coordinate (n_q,) belongs to a rigid body."""
    body = program.reference.body[::3]
    return np.repeat(np.bincount(body)[body] == 1, 3)
