"""The arrays that the compiled loops work on, and the codes of their endings."""

from __future__ import annotations

import numpy as np

from flexmb.compiled.records import Flags, Integers, Matrix, Record, Vector
from flexmb.program.program import Program
from flexmb.program.signals import CONTACT_PENETRATION
from flexmb.system.templates import fresh
from flexmb.system.work import load_forces

RUNNING, DONE, BUFFER_FULL, NEWTON_FAILED, SINGULAR, NOT_FINITE, STEP_TOO_SMALL = range(7)
ENERGY_MISSING, ENERGY_MADE, ENERGY_LOST = 20, 21, 22

GEAR_GUPTA_LEIMKUHLER, POSITION, VELOCITY = range(3)
NEVER = 1e300
"""A save interval of a run that saves nothing, an error that refuses no step."""

FORMS = {"gear-gupta-leimkuhler": GEAR_GUPTA_LEIMKUHLER, "position": POSITION, "velocity": VELOCITY}

NOTHING_KNOWN, ALL_KNOWN, JOINTS_KNOWN = range(3)
"""What the last evaluation of a step says of the state it ends with: nothing, all, or the rows of its joints alone."""

PAST_STATES = 3
"""Accepted states that a prediction looks back to."""

EPISODE, EPISODE_ROW, IMPACT = 7, 11, 3
"""Numbers of a running episode of contact, of one that is written down (see `touch`), of one to come (`landing`)."""


class Clock(Record):
    """Time and sizes of steps.

    t : time [s]
    size, brake : step that errors allow [s], and within contacts (0: no other)
    again : step to try after a contact had a trial refused [s] (0: none)
    last : last step [s]; 0: the next one is a first step
    refused : refused trials of the next step
    speed : largest speed so far, which the tolerance is relative to [m/s]
    held_steps : steps without a break in which rows were held; -1: rows that look dependent are always needed
    saving_from, saved : when saving began [s] (-1: not yet), and instants of its grid that are saved
    """

    t: float
    size: float
    saving_from: float
    saved: float
    last: float
    held_steps: float
    speed: float
    brake: float
    again: float
    refused: float


class Account(Record):
    """Numbers of the account of energies beside the energies themselves.

    start : energy that was stored at the start [J];  damping_power : power of dampers at the last state [W]
    steps : steps so far;  round_off : of all works [J]
    through_contacts, lost_in_contacts : energy that went through contacts; what steps lost there [J]
    put_in : energy in motion and strain at the start and all that drives and loads moved since [J]
    level, fallen : gravity at the start and its largest change [J]
    limit : largest part of the energies that may be missing
    """

    start: float
    damping_power: float
    steps: float
    through_contacts: float
    lost_in_contacts: float
    round_off: float
    put_in: float
    level: float
    fallen: float
    limit: float


class Prediction(Record):
    """State of the predictor.

    order : of the polynomial that predicts the next step
    known : states in `Flow.past`
    before, earlier : the two steps before the last one [s]
    """

    order: int
    known: int
    before: float
    earlier: float


class Reuse(Record):
    """State of the factors of the iteration matrix that may serve again.

    age : steps that they served; 0: there are none
    kv, ka : coefficients that they were made with
    theta, since : ratio of successive corrections when last measured, and steps since
    extra, best : iterations beyond the best step's since they were made, and iterations of that step
    weak : smallest relative pivot of a constraint
    first : size of the last first correction
    expected, check : iteration that is expected to be the last; the same counted from new factors on
    wait, pause : steps to begin with new factors since old ones were refused, and how many the last time
    fresh : 1 if the trial step has made factors
    """

    age: float
    kv: float
    ka: float
    theta: float
    since: float
    extra: float
    best: float
    weak: float
    first: float
    expected: float
    check: float
    wait: float
    pause: float
    fresh: float


class Flow(Record):
    """The accepted state, changed in place: everything that a restart needs.

    q, v, a : (n_q + 3,), a the true acceleration
    x : auxiliary acceleration of the generalised-alpha family;  lam : (n_c,);  z : (n_z,)
    ledger : energies in the order of the signals;  memory : powers and forces at the last state, for the ledger
    episodes : (contacts, EPISODE) what the running episode of each contact holds so far (see `touch`)
    impacts : (contacts, IMPACT) steps of each contact (see `landing`)
    momentum : (n_q + 3,) M v
    past : (PAST_STATES, n_q + n_c) accelerations and multipliers of the states before, newest first
    missed : (PAST_STATES + 1,) what each order of prediction missed by, older steps fading
    gaps : (PAST_STATES + 1, n_c) what the shifts of the last steps closed in all, over h^3, newest first
    factors : last L and U of an accepted step;  slopes : `Work.slopes` they were made with
    """

    clock: Clock
    account: Account
    prediction: Prediction
    reuse: Reuse
    q: Vector
    v: Vector
    a: Vector
    x: Vector
    lam: Vector
    z: Vector
    ledger: Vector
    memory: Vector
    episodes: Matrix
    past: Matrix
    missed: Vector
    factors: Vector
    slopes: Matrix
    impacts: Matrix
    momentum: Vector
    gaps: Matrix


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


class Coefficients(Record, frozen=True):
    """Numbers of a step of the Newmark family, see `Newmark`."""

    alpha_m: float
    alpha_f: float
    beta: float
    gamma: float


class Options(Record, frozen=True):
    """Numbers of method and step control.

    regular, first : coefficients of all steps, and of those that begin anew
    """

    regular: Coefficients
    first: Coefficients
    form: int
    tolerance: float  # Newton: part of h^2 |a|
    iterations: int
    length: float  # size of the mechanism [m]
    adaptive: bool
    error: float  # accepted error of a step [m]
    h_min: float
    h_max: float
    t_end: float
    save_interval: float  # 0: every step


class Counters(Record):
    """Counters of a run, and codes of its last step.

    steps, rejected, iterations, evaluations, factorisations, solves : of the run so far
    rows, episodes : instants and episodes of contact in the buffers
    lost : unknown whose pivot was lost
    held_steps : steps with held multipliers;  outcome : of the last step (see `held`)
    known : what is known of the trial state (`ALL_KNOWN`, ...)
    contact : 1 + the contact that had the last trial refused
    """

    steps: int
    rejected: int
    iterations: int
    evaluations: int
    factorisations: int
    rows: int
    lost: int
    held_steps: int
    outcome: int
    known: int
    solves: int
    contact: int
    episodes: int


class StepReport(Record):
    """Sizes of steps and of Newton's corrections.

    smallest, largest : accepted steps [s];  began, size : of the last one [s];  refused : last refused one [s]
    correction, wanted : last correction, and what was wanted of it, of lengths [m] or of angles
    wanted_length, wanted_angle : what was wanted of both [m, rad];  round_off : the part of round-off in `wanted`
    first_held : first instant with held multipliers [s]
    """

    smallest: float
    largest: float
    correction: float
    wanted: float
    began: float
    size: float
    first_held: float
    round_off: float
    refused: float
    wanted_length: float
    wanted_angle: float


class RunRecord(Record):
    """What the loop writes: saved instants, peaks, counters.

    held : (n_c,) rows whose multipliers were not unique
    peak : largest absolute values; largest positive ones where one_sided (a penetration is negative in free flight)
    episodes : (rows, EPISODE_ROW) episodes of contact that ended (see `touch`)
    values : (rows, n_s) signals that are saved;  kept : (n_s,) their places among all, empty: all are
    between : all signals at an instant inside a step; empty where all are saved
    """

    count: Counters
    step: StepReport
    times: Vector
    values: Matrix
    kept: Integers
    between: Vector
    old: Vector
    new: Vector
    peak: Vector
    peak_time: Vector
    one_sided: Flags
    held: Flags
    episodes: Matrix


PRESSED, BY_NORMAL = range(2)
(BY_FRICTION,) = range(7, 8)
CONTACT_MEMORY = 13
"""Numbers of `Flow.memory` of every contact: normal force, six generalised forces of it, six of friction.  After them
(motion, force) of every constraint row, (friction force, slip) of every constraint, forces of loads."""


def new_flow(program: Program) -> Flow:
    """A state of zeros."""
    return fresh(program, "flow", lambda: _blank_flow(program))


def _blank_flow(program: Program) -> Flow:
    n, m = program.n_q + 3, program.n_c
    n_k, n_g = len(program.tables.contacts.kernel), len(program.tables.constraints.kernel)
    return Flow(
        clock=Clock.zeros(),
        account=Account.zeros(),
        prediction=Prediction.zeros(),
        reuse=Reuse.zeros(),
        missed=PAST_STATES + 1,
        q=n,
        v=n,
        a=n,
        x=n,
        lam=m,
        z=program.tables.sizes.n_z,
        ledger=11,
        memory=CONTACT_MEMORY * n_k + 2 * m + 2 * n_g + load_forces(program),
        episodes=(n_k, EPISODE),
        past=(PAST_STATES, program.n_q + m),
        factors=program.symbolic.size,
        slopes=(n_k + n_g, 4),
        impacts=(n_k, IMPACT),
        momentum=n,
        gaps=(PAST_STATES + 1, m),
    )


def new_trial(program: Program, redundant: int = 0, bounds: tuple[float, ...] = (1.0, 1.0, 1.0, 1.0)) -> Trial:
    """Work vectors; `redundant` rows more than the joints need, `bounds` of the step control (see `landing`)."""
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


def new_record(program: Program, rows: int, kept: np.ndarray | None = None) -> RunRecord:
    """Buffers for `rows` instants of the signals `kept` (places; None: all), and for episodes that end meanwhile."""
    if kept is None or len(kept) == program.tables.sizes.n_y:
        return fresh(program, ("record", rows), lambda: _blank_record(program, rows, None))
    return _blank_record(program, rows, kept)


def _blank_record(program: Program, rows: int, kept: np.ndarray | None) -> RunRecord:
    n_y = program.tables.sizes.n_y
    one_sided = np.zeros(n_y, dtype=np.bool_)
    one_sided[program.tables.contacts.out + CONTACT_PENETRATION] = True
    return RunRecord(
        times=rows,
        values=(rows, n_y if kept is None else len(kept)),
        kept=np.zeros(0, dtype=np.int64) if kept is None else kept,
        between=0 if kept is None else n_y,
        **dict.fromkeys(("old", "new", "peak", "peak_time"), n_y),
        one_sided=one_sided,
        count=Counters.zeros(),
        step=StepReport(np.inf, *(0.0,) * 10),
        held=program.n_c,
        episodes=(rows + len(program.tables.contacts.kernel), EPISODE_ROW),
    )
