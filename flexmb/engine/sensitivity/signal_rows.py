"""Derivatives of signals: at instants within steps, and at the ends of all steps.

A signal is a function of the state and of the numbers of the parts.  It is evaluated at the state plus and minus a
small part of the differences that the steps carry, with the numbers moved by the same part of their direction.
Instants are fixed: a neighbour that is late (time shift tau) is taken where it is at that instant.  Rows of steps keep
the time shift beside the derivatives, so that integrals over a row of steps can be differenced with their limits.

Equation (14.6) of docs/theory/design.md.
"""

import numpy as np

from flexmb.engine.compiled.records import Integers, Matrix, Record, Vector
from flexmb.engine.energy import GRAVITY, KINETIC, STRAIN
from flexmb.engine.radau.collocation import StateVectors, state_vectors
from flexmb.engine.sensitivity.parameters import move_numbers
from flexmb.engine.step.acceptance import END_OF_STEP, PAST_OF_QUADRATIC, interpolate_state
from flexmb.engine.system.constraints import report_forces
from flexmb.engine.system.evaluate import evaluate_accepted
from flexmb.engine.system.outputs import write_outputs
from flexmb.engine.system.work import Work, workspace
from flexmb.kernels import compiled, copy
from flexmb.program.program import COMMON_Z, LAST_GAP, PHASE, Program

# Differences of positions and of velocities for derivatives of signals, relative to size and speed of the mechanism.
# Friction turns round within a thousandth of the speed or less.
SMALL_WAY, SMALL_SPEED = 1e-6, 1e-7
# Difference of a penetration relative to it, and the least part of the other differences that it may ask for.
PART_OF_PENETRATION = 1e-3
PART_OF_GAP = 0.5  # difference of the gap of an open contact relative to it, so that no difference crosses the onset
STEP_ROWS = 512  # number of steps whose rows the buffer holds


class RowNumbers(Record):
    """Numbers of the instants and of the steps whose rows are written."""

    instants: int
    steps: int


class SignalRows(Record):
    """Rows of m signals and of their derivatives by k differences, and room for their evaluation."""

    number: RowNumbers
    probe: Work
    places: Integers  # (m,) places of the signals
    evaluated: bool  # whether one of them is no coordinate, velocity or acceleration
    every: bool  # whether the rows of steps are wanted
    due: Vector  # (n,) instants [s]
    slopes: Matrix  # (n, k m) derivatives at these instants
    times: Vector  # times, sizes: (rows,) ends and sizes of steps [s]
    sizes: Vector
    step_values: Matrix  # (rows, m)
    step_slopes: Matrix  # (rows, k m)
    shifts: Matrix  # (rows, k) time shifts [s]
    q0: Matrix  # q0, v0, a0, lam0, z0: differences (k, ..) at the start of the step
    v0: Matrix
    a0: Matrix
    lam0: Matrix
    z0: Matrix
    a_past: Matrix  # a_past, lam_past: at the start of that before
    lam_past: Matrix
    change: StateVectors  # change, state: a difference at an instant, and a state
    state: StateVectors
    y: Vector  # (n_y,) its signals
    now: Matrix  # (k, m) derivatives at the present state
    found: Vector  # (m,) of one difference
    pair: Matrix  # (2, m) signals at both sides


def signal_rows(
    program: Program, k: int, places: np.ndarray | None = None, due: np.ndarray | None = None, *, every: bool = False
) -> SignalRows:
    """Rows of the signals at `places` by k differences at the instants `due` [s], and at `every` step."""
    places = np.zeros(0, dtype=np.int64) if places is None else places
    due, m, n, n_z = np.zeros(0) if due is None else due, len(places), program.n_q + 3, program.tables.sizes.n_z
    rows = STEP_ROWS if every else 0
    return SignalRows(
        number=RowNumbers(0, 0), probe=workspace(program), places=places,
        evaluated=bool(np.any(places >= 3 * program.n_q)), every=every, due=due, slopes=(len(due), k * m),
        **dict.fromkeys(("times", "sizes"), rows), step_values=(rows, m), step_slopes=(rows, k * m), shifts=(rows, k),
        **dict.fromkeys(("q0", "v0", "a0", "a_past"), (k, n)), **dict.fromkeys(("lam0", "lam_past"), (k, program.n_c)),
        z0=(k, n_z), change=state_vectors(program), state=state_vectors(program), y=program.tables.sizes.n_y,
        now=(k, m), found=m, pair=(2, m),
    )  # fmt: skip


@compiled
def keep_differences(n, T):
    """Keep the differences at the start of a step; multipliers are behind the n positions in T.u."""
    R = T.rows
    for j in range(R.q0.shape[0]):
        copy(R.a0[j], R.a_past[j])
        copy(R.lam0[j], R.lam_past[j])
        copy(T.q[j], R.q0[j])
        copy(T.v[j], R.v0[j])
        copy(T.a[j], R.a0[j])
        copy(T.z[j], R.z0[j])
        for i in range(R.lam0.shape[1]):
            R.lam0[j, i] = T.u[j, n + i]


@compiled
def write_rows(tables, address, h, options, flow, trial, record, T):
    """Write the rows of the instants within the last step, of size h, and of its end."""
    R, t, row = T.rows, flow.clock.t, T.rows.number.steps
    while R.number.instants < R.due.shape[0] and R.due[R.number.instants] <= t + (1.0 - END_OF_STEP) * h:
        due, place = R.due[R.number.instants], R.number.instants
        s = min(max(1.0 - (t - due) / h, 0.0), 1.0)
        _take_state(tables.sizes.n_q, s, h, flow, trial, record)
        for j in range(T.q.shape[0]):
            _difference_at(tables.sizes.n_q, s, h, flow, record, j, T)
            _slopes(tables, address, due, s * h, 0.0, T.tau[j], options, flow, trial, record, j, T)
            for i in range(R.places.shape[0]):
                R.slopes[place, j * R.places.shape[0] + i] = R.found[i]
        R.number.instants += 1
    if not R.every:
        return
    _take_state(tables.sizes.n_q, 1.0, h, flow, trial, record)
    for j in range(T.q.shape[0]):
        _difference_at_end(tables.sizes.n_q, j, T)
        _slopes(tables, address, t, h, T.tau[j], 0.0, options, flow, trial, record, j, T)
        for i in range(R.places.shape[0]):
            R.step_slopes[row, j * R.places.shape[0] + i] = R.found[i]
        R.shifts[row, j] = T.tau[j]
    R.times[row], R.sizes[row] = t, h
    for i in range(R.places.shape[0]):
        R.step_values[row, i] = record.signals[R.places[i]]
    R.number.steps += 1


@compiled
def find_slopes_now(tables, address, options, flow, trial, record, T):
    """Set R.now to the derivatives at the present state, from which a step starts."""
    R = T.rows
    copy(flow.z, record.last_z)
    _take_state(tables.sizes.n_q, 1.0, 1.0, flow, trial, record)
    for j in range(T.q.shape[0]):
        copy(T.z[j], R.z0[j])
        _difference_at_end(tables.sizes.n_q, j, T)
        _slopes(tables, address, flow.clock.t, 0.0, 0.0, 0.0, options, flow, trial, record, j, T)
        copy(R.found, R.now[j])


@compiled
def _take_state(n, s, h, flow, trial, record):
    """State at fraction s of the last step, in `trial`."""
    if s < END_OF_STEP:
        interpolate_state(n, s, h, flow, trial, record)
        return
    copy(flow.q, trial.q)
    copy(flow.v, trial.v)
    copy(flow.a, trial.a)
    copy(flow.lam, trial.lam)


@compiled
def _difference_at_end(n, j, T):
    """Difference j at the end of the step, in R.change, as the neighbour arrives there."""
    R = T.rows
    for i in range(n):
        R.change.q[i], R.change.v[i], R.change.a[i] = T.q[j, i], T.v[j, i], T.a[j, i]
    for i in range(R.change.lam.shape[0]):
        R.change.lam[i] = T.u[j, n + i]
    copy(R.z0[j], R.change.z)


@compiled
def _difference_at(n, s, h, flow, record, j, T):
    """Difference j at fraction s of the last step, at the same instant: that of `interpolate_state`, less tau rates."""
    R, D, tau, old, new, past = T.rows, T.rows.change, T.tau[j], record.last_signals, record.signals, flow.past
    f0, f1 = (1.0 + 2.0 * s) * (1.0 - s) ** 2, s * s * (3.0 - 2.0 * s)
    d0, d1 = h * s * (1.0 - s) ** 2, h * s * s * (s - 1.0)
    before, bow, bent = 1.0, 0.0, 0.0
    if flow.predictor.past_states >= PAST_OF_QUADRATIC:
        before = flow.predictor.second_last_step
        bow, bent = s * (s - 1.0) * h * h / (h + before), (2.0 * s - 1.0) * h / (h + before)
    p0, p1 = 6.0 * s * (s - 1.0) / h, 6.0 * s * (1.0 - s) / h
    e0, e1 = (1.0 - s) * (1.0 - 3.0 * s), s * (3.0 * s - 2.0)
    for i in range(n):
        q0, q1, v0, v1 = R.q0[j, i], T.q[j, i], R.v0[j, i], T.v[j, i]
        a0, a1, ap = R.a0[j, i], T.a[j, i], R.a_past[j, i]
        D.q[i] = f0 * q0 + f1 * q1 + d0 * v0 + d1 * v1
        D.v[i] = f0 * v0 + f1 * v1 + d0 * a0 + d1 * a1
        D.a[i] = (1.0 - s) * a0 + s * a1 + bow * ((a1 - a0) / h - (a0 - ap) / before)
        if tau != 0.0:
            q0, q1, v0, v1 = old[i], new[i], old[n + i], new[n + i]
            a0, a1, ap = old[2 * n + i], new[2 * n + i], past[1, i]
            D.q[i] -= tau * (p0 * q0 + p1 * q1 + e0 * v0 + e1 * v1)
            D.v[i] -= tau * (p0 * v0 + p1 * v1 + e0 * a0 + e1 * a1)
            D.a[i] -= tau * ((a1 - a0) / h + bent * ((a1 - a0) / h - (a0 - ap) / before))
    for i in range(D.lam.shape[0]):
        l0, l1, lp = R.lam0[j, i], T.u[j, n + i], R.lam_past[j, i]
        D.lam[i] = (1.0 - s) * l0 + s * l1 + bow * ((l1 - l0) / h - (l0 - lp) / before)
        if tau != 0.0:
            l0, l1, lp = record.last_lam[i], flow.lam[i], past[1, n + i]
            D.lam[i] -= tau * ((l1 - l0) / h + bent * ((l1 - l0) / h - (l0 - lp) / before))
    copy(R.z0[j], D.z)


@compiled
def _slopes(tables, address, t, elapsed, later, shorter, options, flow, trial, record, j, T):
    """Derivatives of the signals along R.change at the state in `trial`, in R.found."""
    # later, shorter : rates of the time t [s] and, reversed, of the time since the histories z
    R, n, m, eps = T.rows, tables.sizes.n_q, T.rows.places.shape[0], 1.0
    if R.evaluated:
        eps = _difference_size(tables, options, flow, j, T)
        for side in range(2):
            e = eps if side == 0 else -eps
            _evaluate(tables, address, t + e * later, elapsed - e * shorter, e, flow, trial, record, j, T)
            for i in range(m):
                R.pair[side, i] = R.y[R.places[i]]
        if j < T.by.step.shape[0]:
            move_numbers(tables, T.by, j, 0.0)
    for i in range(m):
        place = R.places[i]
        if place < n:
            R.found[i] = R.change.q[place]
        elif place < 2 * n:
            R.found[i] = R.change.v[place - n]
        elif place < 3 * n:
            R.found[i] = R.change.a[place - 2 * n]
        else:
            R.found[i] = (R.pair[0, i] - R.pair[1, i]) / (2.0 * eps)


@compiled
def _difference_size(tables, options, flow, j, T):
    """Part of difference j that moves coordinates, speeds and penetrations by a small part, and closes no gap."""
    R, n, far, fast, speed = T.rows, tables.sizes.n_q, 0.0, 0.0, 0.0
    for i in range(flow.largest_speeds.shape[0]):
        speed = max(speed, flow.largest_speeds[i] / options.length)
    for i in range(n):
        size = 1.0 if tables.kind[i] == 1 else options.length
        far, fast = max(far, abs(R.change.q[i]) / size), max(fast, abs(R.change.v[i]) / size)
        speed = max(speed, abs(flow.v[i]) / size)
    eps = SMALL_WAY / max(far, 1e-300)
    if speed > 0.0:
        eps = min(eps, SMALL_SPEED * speed / max(fast, 1e-300))
    if j < T.by.step.shape[0]:
        eps = min(eps, T.by.step[j])
    least = PART_OF_PENETRATION * eps
    for c in range(tables.contacts.kernel.shape[0]):
        k = tables.contacts.z[c, COMMON_Z]
        moved = abs(T.z[j, k + LAST_GAP])
        part = PART_OF_PENETRATION if flow.z[k + PHASE] != 0.0 else PART_OF_GAP
        if eps * moved > part * abs(flow.z[k + LAST_GAP]):
            eps = max(part * abs(flow.z[k + LAST_GAP]) / moved, least)
    return eps


@compiled
def _evaluate(tables, address, t, elapsed, e, flow, trial, record, j, T):
    """All signals at the state in `trial` plus e times the difference R.change, in R.y."""
    R, S, D, by, n, energy = T.rows, T.rows.state, T.rows.change, T.by, tables.sizes.n_q, tables.sizes.energy
    if j < by.step.shape[0]:
        move_numbers(tables, by, j, e)
    for i in range(n):
        S.q[i], S.v[i] = trial.q[i] + e * D.q[i], trial.v[i] + e * D.v[i]
        S.a[i] = trial.a[i] + e * D.a[i]
    for i in range(S.lam.shape[0]):
        S.lam[i] = trial.lam[i] + e * D.lam[i]
    for i in range(S.z.shape[0]):
        S.z[i] = record.last_z[i] + e * D.z[i]
    evaluate_accepted(by.varied, address, t, elapsed, S.q, S.v, S.a, S.lam, S.z, S.v, S.a, R.probe)
    report_forces(by.varied, S.lam, R.probe)
    write_outputs(by.varied, address, t, S.q, S.v, S.a, R.probe, flow.ledger, record.peak, True, R.y)
    power = R.probe.power
    R.y[energy + KINETIC], R.y[energy + STRAIN], R.y[energy + GRAVITY] = power.kinetic, power.strain, power.gravity
