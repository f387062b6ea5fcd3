"""The arrays that the compiled loops work on, and the codes of their endings."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from flexmb.program.program import Program
from flexmb.program.signals import CONTACT_PENETRATION
from flexmb.system.work import load_forces

RUNNING, DONE, BUFFER_FULL, NEWTON_FAILED, SINGULAR, NOT_FINITE, STEP_TOO_SMALL = range(7)
ENERGY_MISSING, ENERGY_MADE, ENERGY_LOST = 20, 21, 22

GEAR_GUPTA_LEIMKUHLER, POSITION, VELOCITY = range(3)
NEVER = 1e300
"""A save interval of a run that saves nothing, an error that refuses no step."""

FORMS = {"gear-gupta-leimkuhler": GEAR_GUPTA_LEIMKUHLER, "position": POSITION, "velocity": VELOCITY}

NOTHING_KNOWN, ALL_KNOWN, JOINTS_KNOWN = range(3)
"""What the last evaluation of a step says of the state it ends with: nothing, all, or the rows of its joints alone."""

PAST_STATES, HABITS = 3, 22
"""Accepted states that a prediction looks back to, and numbers of `Flow.habits`."""

EPISODE, EPISODE_ROW, IMPACT = 7, 11, 3
"""Numbers of a running episode of contact, of one that is written down (see `touch`), of one to come (`landing`)."""


class Flow(NamedTuple):
    """The accepted state, changed in place: everything that a restart needs.

    clock : t, proposed step, start of saving (-1: not begun), number of saved instants, last step, steps
        without a break in which rows were held, or -1 (see `settle`); for the step control: largest speed so far,
        step that errors allow within contacts (0: no other), step to try after a refused one (0: none), refused
        trials of the next step
    q, v, a : (n_q + 3,), a the true acceleration
    x : auxiliary acceleration of the generalised-alpha family;  lam : (n_c,);  z : (n_z,)
    ledger : energies in the order of the signals;  memory : powers and forces at the last state, for the ledger
    episodes : (contacts, EPISODE) what the running episode of each contact holds so far (see `touch`)
    impacts : (contacts, IMPACT) steps of each contact (see `landing`)
    momentum : (n_q + 3,) M v
    past : (PAST_STATES, n_q + n_c) accelerations and multipliers of the states before, newest first
    gaps : (PAST_STATES + 1, n_c) what the shifts of the last steps closed in all, over h^3, newest first
    habits : (HABITS,) what prediction and reuse of factors learnt from the steps before (see `habits`)
    factors : last L and U of an accepted step;  slopes : `Work.slopes` they were made with
    """

    clock: np.ndarray
    q: np.ndarray
    v: np.ndarray
    a: np.ndarray
    x: np.ndarray
    lam: np.ndarray
    z: np.ndarray
    ledger: np.ndarray
    memory: np.ndarray
    episodes: np.ndarray
    past: np.ndarray
    habits: np.ndarray
    factors: np.ndarray
    slopes: np.ndarray
    impacts: np.ndarray
    momentum: np.ndarray
    gaps: np.ndarray


class Trial(NamedTuple):
    """The state that a step tries, and vectors of the linear system.

    free : (number of redundant rows, n_c) orthonormal multipliers without effect
    rigid : (n_q,) coordinates of rigid bodies;  bounds : (4,) numbers of the step control (see `landing`)
    c, pair : second right side, and workspace for two;  before : (n_q + n_c,) last correction
    gaps : (n_c,) what the shifts of this step close in all
    habits, slopes : what those of `Flow` become if the step is accepted
    """

    q: np.ndarray
    v: np.ndarray
    a: np.ndarray
    x: np.ndarray
    lam: np.ndarray
    mean_v: np.ndarray
    lag: np.ndarray
    b: np.ndarray
    d: np.ndarray
    e: np.ndarray
    seen: np.ndarray
    y: np.ndarray
    free: np.ndarray
    rigid: np.ndarray
    bounds: np.ndarray
    c: np.ndarray
    pair: np.ndarray
    before: np.ndarray
    gaps: np.ndarray
    habits: np.ndarray
    slopes: np.ndarray


class Options(NamedTuple):
    """Numbers of method and step control."""

    alpha_m: float
    alpha_f: float
    beta: float
    gamma: float
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


class Record(NamedTuple):
    """What the loop writes: saved instants, peaks, counters.

    count : steps, rejected, Newton iterations, evaluations, factorisations, rows in the buffer, lost unknown,
        steps with held multipliers, `outcome` of the last step, what is known of the trial state, solves,
        1 + contact that had the last trial refused
    extreme : smallest and largest step, last Newton correction, wanted correction, begin and size of the last step,
        first instant with held multipliers, round-off in the last wanted correction, size of the last trial that was
        refused, wanted corrections of lengths and of angles
    held : (n_c,) rows whose multipliers were not unique
    peak : largest absolute values; largest positive ones where one_sided (a penetration is negative in free flight)
    episodes, ended : (rows, EPISODE_ROW) episodes of contact that ended, and (1,) how many (see `touch`)
    """

    times: np.ndarray
    values: np.ndarray
    old: np.ndarray
    new: np.ndarray
    peak: np.ndarray
    peak_time: np.ndarray
    one_sided: np.ndarray
    count: np.ndarray
    extreme: np.ndarray
    held: np.ndarray
    episodes: np.ndarray
    ended: np.ndarray


MEMORY_HEAD, CONTACT_MEMORY = 10, 13
"""Numbers of the ledger itself (see `ledger`); then of every contact normal force and twelve generalised forces,
(motion, force) of every constraint row, (friction force, slip) of every constraint, forces of elements that are
loads."""


def new_flow(program: Program) -> Flow:
    """A state of zeros."""
    n, m = program.n_q + 3, program.n_c
    n_k, n_g = len(program.tables.contacts.kernel), len(program.tables.constraints.kernel)
    memory = np.zeros(MEMORY_HEAD + CONTACT_MEMORY * n_k + 2 * m + 2 * n_g + load_forces(program))
    return Flow(
        np.zeros(10),
        *(np.zeros(n) for _ in range(4)),
        np.zeros(m),
        np.zeros(program.tables.sizes.n_z),
        np.zeros(11),
        memory,
        np.zeros((n_k, EPISODE)),
        np.zeros((PAST_STATES, program.n_q + m)),
        np.zeros(HABITS),
        np.zeros(program.symbolic.size),
        np.zeros((n_k + n_g, 4)),
        np.zeros((n_k, IMPACT)),
        np.zeros(n),
        np.zeros((PAST_STATES + 1, m)),
    )


def new_trial(program: Program, redundant: int = 0, bounds: tuple[float, ...] = (1.0, 1.0, 1.0, 1.0)) -> Trial:
    """Work vectors; `redundant` rows more than the joints need, `bounds` of the step control (see `landing`)."""
    n, m = program.n_q + 3, program.n_c
    total = program.n_q + m
    return Trial(
        *(np.zeros(n) for _ in range(4)),
        np.zeros(m),
        np.zeros(n),
        np.zeros(n),
        *(np.zeros(total) for _ in range(5)),
        np.zeros((redundant, m)),
        rigid_coordinates(program),
        np.array(bounds),
        np.zeros(total),
        np.zeros(2 * total),
        np.zeros(total),
        np.zeros(m),
        np.zeros(HABITS),
        np.zeros((len(program.tables.contacts.kernel) + len(program.tables.constraints.kernel), 4)),
    )


def rigid_coordinates(program: Program) -> np.ndarray:
    """Whether each coordinate (n_q,) is one of a rigid body."""
    body = program.drawn.body[::3]
    return np.repeat(np.bincount(body)[body] == 1, 3)


def new_record(program: Program, rows: int) -> Record:
    """Buffers for `rows` saved instants, and for as many episodes beside those that one step may end."""
    n_y = program.tables.sizes.n_y
    one_sided = np.zeros(n_y, dtype=np.bool_)
    one_sided[program.tables.contacts.out + CONTACT_PENETRATION] = True
    return Record(
        np.zeros(rows),
        np.zeros((rows, n_y)),
        np.zeros(n_y),
        np.zeros(n_y),
        np.zeros(n_y),
        np.zeros(n_y),
        one_sided,
        np.zeros(12, dtype=np.int64),
        np.array([np.inf, *np.zeros(10)]),
        np.zeros(program.n_c, dtype=np.bool_),
        np.zeros((rows + len(program.tables.contacts.kernel), EPISODE_ROW)),
        np.zeros(1, dtype=np.int64),
    )
