"""Step of the method of Dormand and Prince: stages, error estimate, projection, works, states within the step.

The accelerations of (1.11) make an ordinary differential equation of positions and velocities without constraints.
Works of drives, dampers and loads are sums over its stages, of the same order.  At the end of the step positions and
velocities are projected onto the constraints.  Equation (4.19) of docs/theory/integrators.md.
"""

import math

from flexmb.engine.dormand_prince.complement import accelerate_by_complement, factor_complement, project_by_complement
from flexmb.engine.dormand_prince.tableau import ALL_STAGES, END, STEP_STAGES
from flexmb.engine.energy import GRAVITY, KINETIC, STRAIN, update_residual
from flexmb.engine.newmark.error_control import find_speeds, state_scale
from flexmb.engine.newmark.jacobian_reuse import initial_hold, record_held_rows
from flexmb.engine.radau.step import CLOSED_SHIFT, LARGE_SHIFT, add_powers, close_joints, has_work
from flexmb.engine.state.record import NOT_FINITE, RUNNING
from flexmb.engine.step.runge_kutta import accelerate, project_state
from flexmb.engine.system.evaluate import evaluate
from flexmb.kernels import compiled, copy

PROJECTIONS = 3  # number of projections with the same factors at most

THIRD_ORDER_SHARE = 0.01
"""Weight of the square of the error estimate of order 3 beside that of order 5 (Hairer, II.10)."""

FIRST_WEIGHTED = 5  # number of the first stage after the start of a step that has a weight

# Accelerations of a state, and its projection


@compiled
def find_accelerations(tables, address, lu, t, fraction, h, options, flow, trial, work, record, R):
    """Solve for accelerations and multipliers at the trial positions and velocities; RUNNING, or a code."""
    if R.complement.usable == 1:
        q, v, still = trial.q, trial.v, R.zero
        evaluate(tables, address, t, fraction * h, q, v, still, trial.lam, flow.z, 0.0, 0.0, 0.0, False, work)
        record.count.evaluations += 1
        record.count.factorisations += 1
        if factor_complement(R.complement, work.G, initial_hold(flow)):
            record.count.held_code = 0
            return RUNNING if accelerate_by_complement(tables, trial, work, R.complement) else NOT_FINITE
    return accelerate(tables, address, lu, t, fraction, h, R.zero, options, flow, trial, work, record, R)


@compiled
def project(tables, address, lu, t, h, options, flow, trial, work, record, R):
    """Project the trial positions and velocities onto the constraints, with least kinetic energy."""
    if tables.sizes.n_c == 0:
        return RUNNING
    if R.complement.usable == 0:
        return close_joints(tables, address, lu, t, h, options, flow, trial, work, record, R)
    for iteration in range(PROJECTIONS):
        q, v, still = trial.q, trial.v, R.zero
        evaluate(tables, address, t, h, q, v, still, trial.lam, flow.z, 0.0, 0.0, 0.0, False, work)
        record.count.evaluations += 1
        if iteration == 0:
            record.count.factorisations += 1
            if not factor_complement(R.complement, work.G, initial_hold(flow)):
                break
        largest = project_by_complement(tables, trial, work, R.complement, R.error_q)
        if largest <= CLOSED_SHIFT * options.length:
            return RUNNING
        if not largest <= LARGE_SHIFT * options.length:
            break
    return project_state(tables, address, lu, t, h, options, flow, trial, work, record, R)


# Stages and error estimate


@compiled
def start_step(h, flow, R):
    """Store the start of a step, which is its first stage."""
    old = R.old
    R.span.start, R.span.size, R.span.dense = flow.clock.t, h, 0
    copy(flow.q, old.q)
    copy(flow.v, old.v)
    copy(flow.a, old.a)
    copy(flow.z, old.z)
    copy(flow.lam, old.lam)
    copy(flow.ledger, old.ledger)
    copy(flow.q, R.Q[0])
    copy(flow.v, R.V[0])
    copy(flow.a, R.A[0])
    copy(flow.lam, R.L[0])


@compiled
def sum_stages(n, weights, h, R, of_q, of_v):
    """Set of_q and of_v to h times the weighted sums of velocities and accelerations of the stages."""
    of_q[:] = 0.0
    of_v[:] = 0.0
    for stage in range(weights.shape[0]):
        w = h * weights[stage]
        if w != 0.0:
            V, A = R.V[stage], R.A[stage]
            for i in range(n):
                of_q[i] += w * V[i]
                of_v[i] += w * A[i]


@compiled
def place_stage(n, stage, h, R, q, v):
    """Set q and v to those of a stage."""
    sum_stages(n, R.tableau[stage, :stage], h, R, q, v)
    for i in range(n):
        q[i] += R.old.q[i]
        v[i] += R.old.v[i]


@compiled
def find_stages(tables, address, lu, first, end, options, flow, trial, work, record, R):
    """Find the stages `first` to `end` - 1 of the step that R has begun; RUNNING, or a code."""
    n, h = tables.sizes.n_q, R.span.size
    for stage in range(first, end):
        c = R.instants[stage]
        place_stage(n, stage, h, R, trial.q, trial.v)
        code = find_accelerations(
            tables, address, lu, R.span.start + c * h, c, h, options, flow, trial, work, record, R
        )
        if code != RUNNING:
            return code
        copy(trial.q, R.Q[stage])
        copy(trial.v, R.V[stage])
        copy(trial.a, R.A[stage])
        copy(trial.lam, R.L[stage])
    return RUNNING


@compiled
def try_step(tables, address, lu, h, options, flow, trial, work, record, R):
    """Try a step of size h; a code, and the error over the accepted one, which is finite if all stages are.

    A step of too large an error is not projected.
    """
    start_step(h, flow, R)
    copy(flow.lam, trial.lam)
    code = find_stages(tables, address, lu, 1, STEP_STAGES, options, flow, trial, work, record, R)
    if code != RUNNING:
        return code, math.inf
    place_stage(tables.sizes.n_q, END, h, R, trial.q, trial.v)
    error = step_error(tables, h, options, flow, trial, R) if options.adaptive else 0.0
    if not error <= 1.0:
        return (RUNNING if error < math.inf else NOT_FINITE), error
    t = flow.clock.t + h
    code = project(tables, address, lu, t, h, options, flow, trial, work, record, R)
    if code == RUNNING:
        code = find_accelerations(tables, address, lu, t, 1.0, h, options, flow, trial, work, record, R)
    copy(trial.a, trial.x)
    return code, error


@compiled
def step_error(tables, h, options, flow, trial, R):
    """Estimated error of positions and velocities over the accepted error.

    Errors e5 and e3 of formulas of order 5 and 3 give e5^2 / (e5^2 + 0.01 e3^2)^(1/2), which falls with h^8.

    Equation (4.20) of docs/theory/integrators.md.
    """
    find_speeds(tables.sizes.n_b, options, flow, trial)
    fifth = error_size(tables, R.errors[0], h, options, flow, trial, R)
    third = error_size(tables, R.errors[1], h, options, flow, trial, R)
    whole = math.sqrt(fifth * fifth + THIRD_ORDER_SHARE * third * third)
    error = fifth * fifth / whole if whole > 0.0 else 0.0
    return error if math.isfinite(whole) else math.inf


@compiled
def error_size(tables, weights, h, options, flow, trial, R):
    """Largest error of all nodes, by weights of the stages, over the accepted error."""
    n, n_b, of_q, of_v, worst, all_ = tables.sizes.n_q, tables.sizes.n_b, R.error_q, R.error_v, 0.0, 0.0
    sum_stages(n, weights, h, R, of_q, of_v)
    by_q, length = 1.0 / options.error, options.length
    for k in range(0, n_b, 3):
        by_v = 1.0 / (trial.control.rtol * trial.speeds[trial.groups[k]])
        worst = max(worst, by_q * math.sqrt(of_q[k] ** 2 + of_q[k + 1] ** 2), length * by_q * abs(of_q[k + 2]))
        worst = max(worst, by_v * math.sqrt(of_v[k] ** 2 + of_v[k + 1] ** 2), length * by_v * abs(of_v[k + 2]))
    for i in range(n_b, n):
        scale = state_scale(tables, i, trial.v[i], R.A[STEP_STAGES - 1, i], options, flow)
        worst = max(worst, abs(of_v[i]) / (trial.control.rtol * scale))
    for i in range(n):
        all_ += of_q[i] + of_v[i]
    return worst if math.isfinite(all_) else math.inf


# Works of a step, and states within it


@compiled
def add_works(tables, address, h, flow, trial, work, record, R):
    """Fill R.works and the rates of the ledger at the stages; the last evaluation is that of the trial state."""
    W, t, rates = R.works, flow.clock.t, R.rates
    W.drives = W.loads = W.joints = W.damping = W.supplied = W.joints_size = 0.0
    rates[:, :] = 0.0
    if has_work(tables, flow):
        for stage in range(STEP_STAGES):
            if stage == 0 or stage >= FIRST_WEIGHTED:
                add_stage(tables, address, stage, h * R.tableau[END, stage], flow, work, R)
                record.count.evaluations += 1
    q, v, a, lam = trial.q, trial.v, trial.a, trial.lam
    add_powers(tables, address, t + h, h, 0.0, 0.0, q, v, a, lam, flow, work, R, rates[END])
    record.count.evaluations += 1


@compiled
def add_stage(tables, address, stage, weight, flow, work, R):
    """Add the powers of a stage to its rates, and times a weight [s] to the works."""
    elapsed, q, v, a, lam = R.instants[stage] * R.span.size, R.Q[stage], R.V[stage], R.A[stage], R.L[stage]
    t = R.span.start + elapsed
    add_powers(tables, address, t, elapsed, weight, weight, q, v, a, lam, flow, work, R, R.rates[stage])


@compiled
def find_dense_output(tables, address, lu, options, flow, trial, work, record, R):
    """Find the stages and coefficients of the dense output of the last step, which is accepted."""
    n, h, old = tables.sizes.n_q, R.span.size, R.old
    copy(flow.q, R.Q[END])
    copy(flow.v, R.V[END])
    copy(flow.a, R.A[END])
    copy(flow.lam, R.L[END])
    code = find_stages(tables, address, lu, END + 1, ALL_STAGES, options, flow, trial, work, record, R)
    if has_work(tables, flow):
        for stage in range(END + 1, ALL_STAGES):
            add_stage(tables, address, stage, 0.0, flow, work, R)
    last = R.of_q.shape[0] - R.weights.shape[0]
    for k in range(R.weights.shape[0]):
        sum_stages(n, R.weights[k], h, R, R.of_q[last + k], R.of_v[last + k])
        for i in range(old.ledger.shape[0]):
            R.of_ledger[last + k, i] = 0.0
            for stage in range(ALL_STAGES):
                R.of_ledger[last + k, i] += h * R.weights[k, stage] * R.rates[stage, i]
    for i in range(n):
        first_coefficients(i, flow.q[i] - old.q[i], h * old.v[i], h * flow.v[i], R.of_q)
        first_coefficients(i, flow.v[i] - old.v[i], h * old.a[i], h * flow.a[i], R.of_v)
    for i in range(old.ledger.shape[0]):
        rise = flow.ledger[i] - old.ledger[i]
        first_coefficients(i, rise, h * R.rates[0, i], h * R.rates[END, i], R.of_ledger)
    R.span.dense = 1
    return code


@compiled
def first_coefficients(i, rise, begin, end, F):
    """First three coefficients of number i, by its rise and its slopes at both ends."""
    F[0, i], F[1, i], F[2, i] = rise, begin - rise, 2.0 * rise - begin - end


@compiled
def interpolate(n, s, start, F, target):
    """Set target to the dense output at fraction s: start + s (F0 + (1 - s) (F1 + s (F2 + (1 - s) ...)))."""
    last = F.shape[0] - 1
    for i in range(n):
        value = 0.0
        for k in range(last, -1, -1):
            value = (value + F[k, i]) * (s if k % 2 == 0 else 1.0 - s)
        target[i] = start[i] + value


@compiled
def find_between(tables, address, lu, s, options, flow, trial, work, record, R):
    """Set the trial state to that at fraction s of the last step: dense output, projected; and its ledger."""
    n, h, now = tables.sizes.n_q, R.span.size, R.between
    interpolate(n, s, R.old.q, R.of_q, trial.q)
    interpolate(n, s, R.old.v, R.of_v, trial.v)
    interpolate(now.ledger.shape[0], s, R.old.ledger, R.of_ledger, now.ledger)
    t = R.span.start + s * h
    code = project(tables, address, lu, t, s * h, options, flow, trial, work, record, R)
    if code == RUNNING:
        code = find_accelerations(tables, address, lu, t, s, h, options, flow, trial, work, record, R)
    held = 0
    if record.count.held_code % 2 == 1:
        for place in range(trial.pivot_scale.shape[0]):
            held += 1 if trial.pivot_scale[place] < 0.0 else 0
    if 0 < held == trial.free_multipliers.shape[0]:  # redundant joints: their forces of least norm
        record_held_rows(n, tables.sizes.n_c, lu, True, trial, work, record)
    return code


@compiled
def complete_ledger(flow, work, ledger):
    """Set the energies of the state that was evaluated last in a ledger, and the residual."""
    power = work.power
    ledger[KINETIC], ledger[STRAIN], ledger[GRAVITY] = power.kinetic, power.strain, power.gravity
    update_residual(ledger, flow.balance)
