"""Step of the method of Dormand and Prince: stages, error estimate, projection, works, states within the step.

The accelerations of (1.11) make an ordinary differential equation of positions and velocities without constraints.
Works of drives, dampers and loads are sums over its stages, of the same order.  At the end of the step positions and
velocities are projected onto the constraints.  Equation (4.19) of docs/theory/integrators.md.

Sources: E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd ed., Springer 1993,
II.5 (method), II.6 (dense output of order 7) and II.10 (error estimate); the numbers are those of their code DOP853.
"""

import math
from functools import partial

import numpy as np

from flexmb.engine.compiled.records import Matrix, Record, Vector
from flexmb.engine.dormand_prince import complement as masses
from flexmb.engine.dormand_prince import tree as trees
from flexmb.engine.energy import gap_within
from flexmb.engine.newmark.error_control import CONTACT_TRIALS, find_speeds, in_free_flight, largest_error, meets_events
from flexmb.engine.newmark.jacobian_reuse import initial_hold, take_least_norm
from flexmb.engine.radau.collocation import StateVectors, Works, state_vectors
from flexmb.engine.radau.step import (
    LARGE_SHIFT,
    add_known_powers,
    add_powers,
    close_joints,
    has_work,
    is_closed,
    keep_state,
)
from flexmb.engine.state.record import ASKED, NOT_FINITE, RUNNING
from flexmb.engine.step.contact_events import PEAK_DEPTH, PEAK_FORCE
from flexmb.engine.step.runge_kutta import accelerate, project_state
from flexmb.engine.system.constraints import add_constraints
from flexmb.engine.system.contacts import add_contacts, call_normal
from flexmb.engine.system.elements import add_elements
from flexmb.engine.system.evaluate import evaluate
from flexmb.engine.system.outputs import NORMAL_SIGNAL, PENETRATION
from flexmb.engine.system.work import DRIVE_FORCE, new_from_template, turn_nodes
from flexmb.kernels import compiled, copy
from flexmb.late import scipy
from flexmb.places import GAP, GAP_RATE, NORMAL_FORCE
from flexmb.program.program import COMMON_Z, LAST_FORCE, LAST_GAP_RATE, Program

PROJECTIONS = 6  # number of projections of a state at most
OLD_FACTORS_RATE = 1e-2  # shift over the one before, above which the next projection has factors of its own
# Weight of the square of the error estimate of order 3 beside that of order 5 (Hairer, II.10).
THIRD_ORDER_SHARE = 0.01
FIRST_WEIGHTED = 5  # number of the first stage after the start of a step that has a weight
# Largest force of a contact in a step over the largest so far, from which all signals are evaluated there: joint forces
# may have their peaks with it.
CREST_SHARE = 0.5
AT_CREST = 0.05  # fraction of a step from a crest to its end, up to which stop conditions see the crest
CREST_LOOKS = 12  # number of thirds (halves) by which the place of a largest force (depth) is enclosed
WILD_ERROR = 100.0  # error over the accepted one, above which the end of a trial tells nothing of events
# Number of stages of a step, and with the end of the step and the three stages of the dense output.
STEP_STAGES, ALL_STAGES = 12, 16
# Numbers of the stages that are the start and the end of the step, and of the first one that a step computes.
START, FIRST, END = 0, 1, STEP_STAGES
FIFTH, THIRD = range(2)  # rows of `Stages.errors`
LEDGER = 11  # number of the energies of a ledger
DENSE = 7  # number of coefficients of the dense output


class Span(Record):
    """Start and size of the last step [s]; 1 with its dense output, 1 where the state is of another method."""

    start: float
    size: float
    dense: int
    foreign: int


class Stages(Record):
    """Stages of a step, and its workspace."""

    span: Span
    plain: int  # 1 where evaluations for accelerations tell all powers: elements are masses, and no joint has friction
    complement: masses.Complement
    tree: trees.Tree
    works: Works
    old: StateVectors  # old, between: start of the last step, and an instant within it
    between: StateVectors
    tableau: Matrix  # (16, 16) weights of the stages f_i = f(t + C_i h, y0 + h sum_j A_ij f_j); row 12: of the step
    instants: Vector  # (16,) C
    errors: Matrix  # (2, 12) weights of the error estimates of order 5 and 3
    weights: Matrix  # (4, 16) weights of the last four coefficients of the dense output
    Q: Matrix  # Q, V, A: (16, n_q + 3) positions, velocities and accelerations of the stages
    V: Matrix
    A: Matrix
    L: Matrix  # (16, n_c) multipliers
    rates: Matrix  # (16, 11) rates of the ledger at the stages [W]
    of_q: Matrix  # of_q, of_v, of_ledger: (7, ...) coefficients of the dense output
    of_v: Matrix
    of_ledger: Matrix
    error_q: Vector  # error_q, error_v: (n_q + 3,) errors, and other sums over the stages
    error_v: Vector
    x: Vector  # x, y: (n_q + n_c,), pair : (2 (n_q + n_c),)
    y: Vector
    pair: Vector
    losses: Matrix  # (contacts, 3) losses of a step, see `LOSS_NORMAL`
    crests: Vector  # (2 contacts,) fractions of the last step with new peaks of normal forces and depths, 0: none
    zero: Vector  # (n_q + 3,)
    signals: Vector  # (n_y,) at an instant within


def new_stages(program: Program) -> Stages:
    """Work arrays for a compiled mechanism."""
    own = masses.complement(program)
    own_tree = trees.tree(program, own)
    plain = int(own.usable == 1 and (program.tables.elements.mass > 0).all())
    make = partial(_stages, program, own, own_tree, plain)
    return new_from_template(program, ("stages", plain), make, complement=own, tree=own_tree)


def _stages(program: Program, complement: masses.Complement, tree: trees.Tree, plain: int) -> Stages:
    n, m, method = program.n_q + 3, program.n_c, scipy.integrate.DOP853
    A = np.zeros((ALL_STAGES, ALL_STAGES))
    A[:END, :END], A[END, :END], A[END + 1 :] = method.A, method.B, method.A_EXTRA
    return Stages(
        span=Span.zeros(), plain=plain, complement=complement, tree=tree, works=Works.zeros(),
        old=state_vectors(program), between=state_vectors(program), tableau=A, instants=np.minimum(A.sum(axis=1), 1.0),
        errors=np.array([method.E5[:STEP_STAGES], method.E3[:STEP_STAGES]]), weights=method.D.copy(),
        **dict.fromkeys(("Q", "V", "A"), (ALL_STAGES, n)), L=(ALL_STAGES, m), rates=(ALL_STAGES, LEDGER),
        **dict.fromkeys(("of_q", "of_v"), (DENSE, n)), of_ledger=(DENSE, LEDGER),
        **dict.fromkeys(("error_q", "error_v", "zero"), n), **dict.fromkeys(("x", "y"), program.n_q + m),
        pair=2 * (program.n_q + m), losses=(len(program.tables.contacts.kernel), 3),
        crests=2 * len(program.tables.contacts.kernel), signals=program.tables.sizes.n_y,
    )  # fmt: skip


@compiled
def find_accelerations(tables, address, lu, t, fraction, h, options, flow, trial, work, record, D):
    """Solve for accelerations and multipliers at the trial positions and velocities; RUNNING, or a code."""
    if D.tree.usable == 1:
        work.r[:] = 0.0
        q, v, still = trial.q, trial.v, D.zero
        add_elements(tables, address, t, fraction * h, q, v, still, flow.z, 0.0, 0.0, 0.0, False, work)
        turn_nodes(tables, q, work)
        add_contacts(tables, address, t, fraction * h, q, v, flow.z, 0.0, 0.0, False, work)
        record.count.evaluations += 1
        record.count.held_code = 0
        return RUNNING if trees.accelerate_by_tree(tables, trial, work, D.tree) else NOT_FINITE
    if D.complement.usable == 1 and trial.left_out.shape[0] == 0:
        q, v, still = trial.q, trial.v, D.zero
        evaluate(tables, address, t, fraction * h, q, v, still, trial.lam, flow.z, 0.0, 0.0, 0.0, False, work)
        record.count.evaluations += 1
        record.count.factorisations += 1
        if masses.factor_complement(D.complement, work.G, initial_hold(flow)):
            record.count.held_code = 0
            return RUNNING if masses.accelerate_by_complement(tables, trial, work, D.complement) else NOT_FINITE
    return accelerate(tables, address, lu, t, fraction, h, D.zero, options, flow, trial, work, record, D)


@compiled
def project(tables, address, lu, t, h, options, flow, trial, work, record, D):
    """Project the trial positions and velocities onto the constraints, with least kinetic energy, or by the angles."""
    if tables.sizes.n_c == 0:
        return RUNNING
    if D.tree.usable == 1:
        trees.place_by_tree(tables, trial, D.tree)
        return RUNNING
    if D.complement.usable == 0 or trial.left_out.shape[0] > 0:
        return close_joints(tables, address, lu, t, h, options, flow, trial, work, record, D)
    old, last = False, math.inf
    for _ in range(PROJECTIONS):
        turn_nodes(tables, trial.q, work)
        add_constraints(tables, address, t, h, trial.q, trial.v, trial.lam, flow.z, 0.0, 0.0, False, work)
        record.count.evaluations += 1
        if not old:
            record.count.factorisations += 1
            if not masses.factor_complement(D.complement, work.G, initial_hold(flow)):
                break
        largest = masses.project_by_complement(tables, trial, work, D.complement, D.error_q)
        if is_closed(largest, last, options.length):
            return RUNNING
        if not largest <= LARGE_SHIFT * options.length:
            break
        old, last = largest < OLD_FACTORS_RATE * last, largest
    return project_state(tables, address, lu, t, h, options, flow, trial, work, record, D)


@compiled
def sum_stages(n, weights, h, D, of_q, of_v):
    """Set of_q and of_v to h times the weighted sums of velocities and accelerations of the stages."""
    of_q[:] = of_v[:] = 0.0
    for stage in range(weights.shape[0]):
        w = h * weights[stage]
        if w != 0.0:
            V, A = D.V[stage], D.A[stage]
            for i in range(n):
                of_q[i] += w * V[i]
                of_v[i] += w * A[i]


@compiled
def place_stage(n, stage, h, D, q, v):
    """Set q and v to positions and velocities of a stage."""
    sum_stages(n, D.tableau[stage, :stage], h, D, q, v)
    for i in range(n):
        q[i] += D.old.q[i]
        v[i] += D.old.v[i]


@compiled
def find_stages(tables, address, lu, first, end, options, flow, trial, work, record, D):
    """Find the stages `first` to `end` - 1 of the step that D has begun; RUNNING, or a code."""
    n, h = tables.sizes.n_q, D.span.size
    for stage in range(first, end):
        c = D.instants[stage]
        place_stage(n, stage, h, D, trial.q, trial.v)
        t = D.span.start + c * h
        code = find_accelerations(tables, address, lu, t, c, h, options, flow, trial, work, record, D)
        if code != RUNNING:
            return code
        copy(trial.q, D.Q[stage])
        copy(trial.v, D.V[stage])
        copy(trial.a, D.A[stage])
        copy(trial.lam, D.L[stage])
        if D.plain == 1 and D.tableau[END, stage] != 0.0:
            weight = h * D.tableau[END, stage]
            for k in range(trial.lam.shape[0]):
                work.drive[k, DRIVE_FORCE] = -trial.lam[k]
            add_known_powers(tables, weight, weight, trial.v, work, D, D.rates[stage])
    return RUNNING


@compiled
def try_step(tables, address, lu, h, options, flow, trial, work, record, D):
    """Try a step of size h; a code, and its error over the accepted one, finite if all stages are; -1: missed."""
    # A step of too large an error, or past a contact event, is not projected.
    # The start of the step is its first stage.
    D.span.start, D.span.size, D.span.dense = flow.clock.t, h, 0
    keep_state(flow, D.old)
    copy(flow.q, D.Q[START])
    copy(flow.v, D.V[START])
    copy(flow.a, D.A[START])
    copy(flow.lam, D.L[START])
    copy(flow.lam, trial.lam)
    W = D.works
    W.drives = W.loads = W.joints = W.damping = W.supplied = W.joints_size = 0.0
    D.losses[:, :] = D.rates[:, :] = 0.0
    code = find_stages(tables, address, lu, FIRST, END, options, flow, trial, work, record, D)
    if code != RUNNING:
        return code, math.inf
    place_stage(tables.sizes.n_q, END, h, D, trial.q, trial.v)
    error = 0.0
    if options.adaptive:
        # Errors e5 and e3 of formulas of order 5 and 3 give e5^2 / (e5^2 + 0.01 e3^2)^(1/2), which falls with h^8.
        # Equation (4.20) of docs/theory/integrators.md.
        find_speeds(tables.sizes.n_b, options, flow, trial)
        fifth = error_size(tables, D.errors[FIFTH], h, options, flow, trial, D)
        third = error_size(tables, D.errors[THIRD], h, options, flow, trial, D)
        whole = math.sqrt(fifth * fifth + THIRD_ORDER_SHARE * third * third)
        error = math.inf if not math.isfinite(whole) else (fifth * fifth / whole if whole > 0.0 else 0.0)
        Q, V, C = D.Q[FIRST:END], D.V[FIRST:END], D.instants[FIRST:]
        if error <= WILD_ERROR and not meets_events(
            tables, address, RUNNING, h, Q, V, C, options, flow, trial, work, record
        ):
            return RUNNING, -1.0
    if not error <= 1.0:
        return (RUNNING if error < math.inf else NOT_FINITE), error
    t = flow.clock.t + h
    code = project(tables, address, lu, t, h, options, flow, trial, work, record, D)
    if code == RUNNING:
        code = find_accelerations(tables, address, lu, t, 1.0, h, options, flow, trial, work, record, D)
    copy(trial.a, trial.x)
    if code == RUNNING and hides_crest(tables, address, h, options, flow, trial, work, record, D):
        return RUNNING, -1.0
    return code, error


@compiled
def error_size(tables, weights, h, options, flow, trial, D):
    """Largest error of all nodes, by weights of the stages, over the accepted error."""
    n, x, y, total = tables.sizes.n_q, D.error_q, D.error_v, 0.0
    sum_stages(n, weights, h, D, x, y)
    rtol, a = trial.control.rtol, D.A[STEP_STAGES - 1]
    of_q = (trial.control.flight_weight if in_free_flight(tables, flow) else 1.0) / options.error
    worst = largest_error(tables, of_q, rtol, x, y, a, True, options, flow, trial)
    for i in range(n):
        total += x[i] + y[i]
    return worst if math.isfinite(total) else math.inf


@compiled
def add_works(tables, address, h, flow, trial, work, record, D):
    """Complete D.works and the rates of the ledger at the stages; the last evaluation is that of the trial state."""
    t, rates = flow.clock.t, D.rates
    if has_work(tables, flow):
        for stage in range(STEP_STAGES):
            if stage == START or (stage >= FIRST_WEIGHTED and D.plain == 0):
                add_stage(tables, address, stage, h * D.tableau[END, stage], flow, work, D)
                record.count.evaluations += 1
    q, v, a, lam = trial.q, trial.v, trial.a, trial.lam
    add_powers(tables, address, t + h, h, 0.0, 0.0, q, v, a, lam, flow, work, D, rates[END])
    record.count.evaluations += 1


@compiled
def add_stage(tables, address, stage, weight, flow, work, D):
    """Add the powers of a stage to its rates, and times a weight [s] to the works."""
    elapsed, q, v, a, lam = D.instants[stage] * D.span.size, D.Q[stage], D.V[stage], D.A[stage], D.L[stage]
    t = D.span.start + elapsed
    add_powers(tables, address, t, elapsed, weight, weight, q, v, a, lam, flow, work, D, D.rates[stage])


@compiled
def hides_crest(tables, address, h, options, flow, trial, work, record, D):
    """Whether stop conditions, which look at ends of steps, would not see a crest; the next trial ends there."""
    find_crests(tables, address, h, flow, trial, work, record, D)
    for s in D.crests:
        looks = options.adaptive and AT_CREST < s < 1.0 - AT_CREST and flow.clock.rejected_trials < CONTACT_TRIALS
        if looks and record.levels[:, ASKED].sum() > 0.0:
            flow.clock.retry_step, record.count.rejecting_contact = s * h, 0
            return True
    return False


@compiled
def find_crests(tables, address, h, flow, trial, work, record, D):
    """Fill D.crests; peaks of contact intervals.  The last evaluation is that of the trial state."""
    # Steps are long beside an impact. The quintic path between both states tells where the force is largest.
    K, gap = tables.contacts, work.gap
    for c in range(K.kernel.shape[0]):
        deepest, rate0, rate1 = 2 * c + 1, flow.z[K.z[c, COMMON_Z] + LAST_GAP_RATE], work.contact[c, GAP_RATE]
        D.crests[2 * c], D.crests[deepest], low, high = 0.0, 0.0, 0.0, 1.0
        begin, end = flow.z[K.z[c, COMMON_Z] + LAST_FORCE], work.contact[c, NORMAL_FORCE]
        if begin + end == 0.0:
            continue
        if rate0 < 0.0 < rate1:
            for _ in range(CREST_LOOKS):
                s = 0.5 * (low + high)
                gap_within(tables, address, c, s, h, flow, trial.q, trial.v, work, trial.a)
                low, high = (s, high) if gap[GAP_RATE] < 0.0 else (low, s)
            low, high = 0.0, 1.0
            flow.episodes[c, PEAK_DEPTH] = max(flow.episodes[c, PEAK_DEPTH], -gap[GAP])
            D.crests[deepest] = s if record.peak[K.out[c] + PENETRATION] < -gap[GAP] else 0.0
        if not 4.0 * force_within(tables, address, c, 0.5, h, flow, trial, work) > begin + end + 2.0 * max(begin, end):
            continue  # the parabola rises or falls all over the step
        for _ in range(CREST_LOOKS):
            s, t = low + (high - low) / 3.0, high - (high - low) / 3.0
            later = force_within(tables, address, c, t, h, flow, trial, work)
            low, high = (s, high) if force_within(tables, address, c, s, h, flow, trial, work) < later else (low, t)
        s = 0.5 * (low + high)
        N = force_within(tables, address, c, s, h, flow, trial, work)
        flow.episodes[c, PEAK_FORCE] = max(flow.episodes[c, PEAK_FORCE], N)
        D.crests[2 * c] = s if CREST_SHARE * record.peak[K.out[c] + NORMAL_SIGNAL] < N else 0.0


@compiled
def force_within(tables, address, c, s, h, flow, trial, work):
    """Normal force of contact c at fraction s of the quintic path from the state to the trial state [N]."""
    gap_within(tables, address, c, s, h, flow, trial.q, trial.v, work, trial.a)
    N, _, _ = call_normal(tables, address, c, s * h, work.gap[GAP], work.gap[GAP_RATE], flow.z, work.z_between)
    return N


@compiled
def find_dense_output(tables, address, lu, options, flow, trial, work, record, D):
    """Find the stages and coefficients of the dense output of the last step, which is accepted."""
    n, h, old = tables.sizes.n_q, D.span.size, D.old
    copy(flow.q, D.Q[END])
    copy(flow.v, D.V[END])
    copy(flow.a, D.A[END])
    copy(flow.lam, D.L[END])
    code = find_stages(tables, address, lu, END + 1, ALL_STAGES, options, flow, trial, work, record, D)
    if has_work(tables, flow):
        for stage in range(END + 1, ALL_STAGES):
            add_stage(tables, address, stage, 0.0, flow, work, D)
    last = D.of_q.shape[0] - D.weights.shape[0]
    for k in range(D.weights.shape[0]):
        sum_stages(n, D.weights[k], h, D, D.of_q[last + k], D.of_v[last + k])
        for i in range(old.ledger.shape[0]):
            D.of_ledger[last + k, i] = 0.0
            for stage in range(ALL_STAGES):
                D.of_ledger[last + k, i] += h * D.weights[k, stage] * D.rates[stage, i]
    for i in range(n):
        first_coefficients(i, flow.q[i] - old.q[i], h * old.v[i], h * flow.v[i], D.of_q)
        first_coefficients(i, flow.v[i] - old.v[i], h * old.a[i], h * flow.a[i], D.of_v)
    for i in range(old.ledger.shape[0]):
        first_coefficients(i, flow.ledger[i] - old.ledger[i], h * D.rates[START, i], h * D.rates[END, i], D.of_ledger)
    D.span.dense = 1
    return code


@compiled
def first_coefficients(i, rise, begin, end, F):
    """First three coefficients of number i, by its rise and its slopes at both ends."""
    F[0, i], F[1, i], F[2, i] = rise, begin - rise, 2.0 * rise - begin - end


@compiled
def interpolate(n, s, start, F, target):
    """Set target to the dense output at fraction s: start + s (F0 + (1 - s) (F1 + s (F2 + (1 - s) ...)))."""
    for i in range(n):
        value = 0.0
        for k in range(F.shape[0] - 1, -1, -1):
            value = (value + F[k, i]) * (s if k % 2 == 0 else 1.0 - s)
        target[i] = start[i] + value


@compiled
def find_between(tables, address, lu, s, options, flow, trial, work, record, D):
    """Set the trial state to that at fraction s of the last step: dense output, projected; and its ledger."""
    n, h, now = tables.sizes.n_q, D.span.size, D.between
    interpolate(n, s, D.old.q, D.of_q, trial.q)
    interpolate(n, s, D.old.v, D.of_v, trial.v)
    interpolate(now.ledger.shape[0], s, D.old.ledger, D.of_ledger, now.ledger)
    t = D.span.start + s * h
    code = project(tables, address, lu, t, s * h, options, flow, trial, work, record, D)
    if code == RUNNING:
        code = find_accelerations(tables, address, lu, t, s, h, options, flow, trial, work, record, D)
    if record.count.held_code % 2 == 1:
        take_least_norm(tables, lu, trial, work, record)
    return code
