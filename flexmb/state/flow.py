"""The accepted state of a run: everything that a restart needs."""

from __future__ import annotations

from flexmb.compiled.records import Matrix, Record, Vector
from flexmb.program.program import Program
from flexmb.system.templates import fresh
from flexmb.system.work import load_forces

PAST_STATES = 3
"""Accepted states that a prediction looks back to."""

EPISODE, EPISODE_ROW, IMPACT = 7, 11, 3
"""Numbers of a running contact interval, of one that is written down (`step/contact_log.py`), and of an impact
(`step/contact_events.py`)."""


PRESSED, BY_NORMAL = range(2)
(BY_FRICTION,) = range(7, 8)
CONTACT_MEMORY = 13
"""Numbers of `Flow.memory` of every contact: normal force, six generalised forces of it, six of friction.  After them
(motion, force) of every constraint row, (friction force, slip) of every constraint, forces of loads."""


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
    episodes : (contacts, EPISODE) what the running episode of each contact holds so far (`step/contact_log.py`)
    impacts : (contacts, IMPACT) steps of each contact (`step/contact_events.py`)
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
