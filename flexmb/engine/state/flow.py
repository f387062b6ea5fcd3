"""Accepted state of a run, which a restart holds beside signals, fingerprint, numbers of the method; trial state."""

import numpy as np

from flexmb.engine.compiled.records import Flags, Integers, Matrix, Record, Vector
from flexmb.engine.system.work import from_template, load_forces, new_from_template, slopes_rows
from flexmb.program.program import Program, body_groups

PAST_STATES = 3  # number of states before the accepted one that the predictor keeps
EPISODE_SIZE = 7  # number of columns of `Flow.episodes` (`engine/step/contact_events.py`)
EPISODE_ROW_SIZE = 11  # number of columns of `RunRecord.episodes` (`engine/step/contact_events.py`)
IMPACT_SIZE = 3  # number of columns of `Flow.impacts` (`engine/step/contact_events.py`)
MEMORY_NORMAL, MEMORY_BY_NORMAL = range(2)
(MEMORY_BY_FRICTION,) = range(7, 8)
# Numbers of `Flow.memory` for each contact: normal force [N], six generalised forces of it, six of friction.
# After the contacts follow, for every constraint equation, motion and force; for every constraint, friction force and
# slip; then the forces of loads.
CONTACT_MEMORY_SIZE = 13


class Clock(Record):
    """Time, step sizes, and counters of the step control."""

    t: float  # time [s]
    step_size: float  # step that the error estimate allows, or the fixed step [s]
    save_start: float  # time at which saving began [s]; -1: saving has not begun
    saved_instants: float  # number of saved instants of the save grid
    # last accepted step [s]; 0: the next step has none before it (start, jump, impact), a starting step
    last_step: float
    held_steps: float  # number of successive steps with held multipliers; -1: only rows whose pivot is lost are held
    contact_step: float  # smaller step within an impact [s]; 0: no impact
    retry_step: float  # step to try after a trial that missed a contact event [s]; 0: no such trial
    rejected_trials: float  # rejected trials since the last accepted step
    jump: float  # time of a located jump of a control law, the first of those near to one another [s]
    jumps: float  # number of located jumps near to that one


class EnergyBalance(Record):
    """Sums and limits of the balance of energies, beside the energies in `Flow.ledger`."""

    stored_at_start: float  # energy stored at the start [J]
    damping_power: float  # power of dampers at the accepted state [W]
    steps: float  # number of accepted steps
    through_contacts: float  # energy that passed through contacts, without signs [J]
    lost_in_contacts: float  # energy that the steps dissipated in contacts beyond the contact laws [J]
    round_off: float  # round-off of all works [J]
    supplied: float  # kinetic and strain energy at the start, plus all works of drives and loads without signs [J]
    gravity_at_start: float  # potential of gravity at the start [J]
    gravity_change: float  # largest change of the potential of gravity since the start [J]
    residual_limit: float  # largest accepted residual relative to the scale of energies
    # kinetic energy that bodies without connection to the others kept all the time [J], which hides their errors
    idle: float


class Predictor(Record, limits={"order": (-2, PAST_STATES), "past_states": (0, PAST_STATES + 1)}):
    """State of the predictor."""

    order: int  # order of the polynomial that predicts the next step
    past_states: int  # number of valid rows of `Flow.past`
    second_last_step: float  # second_last_step, third_last_step: sizes of the two steps before the last one [s]
    third_last_step: float


class JacobianReuse(Record):
    """State of the factors of the iteration matrix, on which their reuse depends."""

    age: float  # number of steps that used the factors; 0: no factors
    kv: float  # kv, ka: coefficients of damping and mass in the factored matrix [1/s, 1/s^2]
    ka: float
    contraction: float  # contraction rate theta when last measured
    steps_since_measured: float  # steps since that measurement
    extra_iterations: float  # sum over the steps of iterations beyond those of the best step
    best_iterations: float  # iterations of the best step with these factors
    smallest_pivot: float  # smallest relative pivot of a constraint
    first_correction: float  # size of the first correction of the last step, over its tolerance
    expected_last: float  # number of the iteration that is expected to converge with factors of an earlier step
    expected_last_fresh: float  # the same number with factors of this step
    suspended_steps: float  # number of coming steps without reuse
    last_suspension: float  # number of steps without reuse after the last failure
    refactored: float  # 1 if the trial step factored its matrix
    round_off: float  # size of the last correction that was round-off, over its tolerance


class Flow(Record):
    """Accepted state of a run, changed in place."""

    clock: Clock
    balance: EnergyBalance
    predictor: Predictor
    reuse: JacobianReuse
    q: Vector  # q, v, a: (n_q + 3,) coordinates, velocities, true accelerations; the last three belong to the ground
    v: Vector
    a: Vector
    x: Vector  # (n_q + 3,) auxiliary acceleration of generalised-alpha
    lam: Vector  # (n_c,) multipliers
    z: Vector  # (n_z,) histories of contact and friction laws
    ledger: Vector  # energies in the order of the energy signals [J]
    memory: Vector  # powers and forces of the accepted state, for the balance of energies
    episodes: Matrix  # (contacts, EPISODE_SIZE) running contact intervals (`engine/step/contact_events.py`)
    past: Matrix  # (PAST_STATES, n_q + n_c) accelerations and multipliers of earlier states, newest first
    prediction_errors: Vector  # (PAST_STATES + 1,) error of the prediction of each order, with fading memory
    factors: Vector  # factors L and U of an accepted step
    slopes: Matrix  # slopes of the contact and friction laws in that matrix, as `Work.slopes`
    impacts: Matrix  # (contacts, IMPACT_SIZE) steps for impacts (`engine/step/contact_events.py`)
    momentum: Vector  # (n_q + 3,) M v
    # (PAST_STATES + 1, n_c) gaps that the position shifts of the last steps closed, over h^3, newest first
    projected_gaps: Matrix
    # (groups,) largest speed so far of each group of connected bodies, scale of the tolerance of velocities [m/s]
    largest_speeds: Vector
    largest_states: Vector  # (n_q - n_b,) largest absolute values so far of the states of controls


@from_template
def new_flow(program: Program) -> Flow:
    """A state of zeros for a compiled mechanism."""
    n, m = program.n_q + 3, program.n_c
    n_k, n_g = len(program.tables.contacts.kernel), len(program.tables.constraints.kernel)
    return Flow(
        clock=Clock.zeros(), balance=EnergyBalance.zeros(), predictor=Predictor.zeros(), reuse=JacobianReuse.zeros(),
        prediction_errors=PAST_STATES + 1, **dict.fromkeys(("q", "v", "a", "x", "momentum"), n), lam=m,
        z=program.tables.sizes.n_z, ledger=11,
        memory=CONTACT_MEMORY_SIZE * n_k + 2 * m + 3 * n_g + load_forces(program), episodes=(n_k, EPISODE_SIZE),
        past=(PAST_STATES, program.n_q + m), factors=program.symbolic.size, slopes=(n_k + n_g, 4),
        impacts=(n_k, IMPACT_SIZE), projected_gaps=(PAST_STATES + 1, m),
        largest_speeds=int(body_groups(program).max(initial=-1)) + 1,
        largest_states=program.n_q - program.tables.sizes.n_b,
    )  # fmt: skip


class StepControl(Record, frozen=True):
    """Numbers of the step control, in addition to `Options`."""

    rtol: float  # tolerance of velocities relative to the largest speed
    least_speed: float  # least speed to which that tolerance is relative [m/s]
    impact_steps: float  # least number of steps of an impact
    onset: float  # factor of the time between the ends of steps and onsets or separations
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
    q_within: Vector  # q_within, v_within: (n_q + 3,) coordinates and velocities within the step
    v_within: Vector
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
    program: Program, redundant: int = 0, control: tuple[float, ...] = (1.0, 1.0, 1.0, 1.0),
    left_out: tuple[int, ...] = (),
) -> Trial:  # fmt: skip
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
    states = dict.fromkeys(("q", "v", "a", "x", "mean_v", "newmark_residual", "q_within", "v_within"), n)
    states |= dict.fromkeys(("lam", "projected_gaps"), m)
    vectors = ("rhs", "gap_rhs", "solution", "shift", "pivot_scale", "scratch", "last_correction")
    return Trial(
        **states, **dict.fromkeys(vectors, total), scratch_pair=2 * total, free_multipliers=(redundant, m),
        left_out=np.zeros(left_out, dtype=np.int64), left_out_pivots=np.zeros(left_out, dtype=np.int64),
        rigid=rigid_coordinates(program), groups=groups[: program.n_q],
        contact_groups=np.maximum(*groups[program.tables.contacts.dofs.astype(np.int64).reshape(-1, 6)[:, ::3].T]),
        speeds=int(groups.max(initial=-1)) + 1, control=control, predictor=Predictor.zeros(),
        reuse=JacobianReuse.zeros(), newton=NewtonIteration.zeros(),
        slopes=(slopes_rows(program), 4),
    )  # fmt: skip


def rigid_coordinates(program: Program) -> np.ndarray:
    """Whether each coordinate (n_q,) belongs to a rigid body."""
    body = program.reference.body[::3]
    return np.repeat(np.bincount(body)[body] == 1, 3)
