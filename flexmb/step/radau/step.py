"""Step of Radau's method with three stages: prediction, Newton iteration, projection, error estimate.

Constraints hold in velocities at the stages (index 2).  At the end of the step positions and velocities are projected
onto the constraints; accelerations and multipliers follow from the equations of motion.  All are of order 5.
"""

import math

from flexmb.compiled.views import part_of
from flexmb.kernels import compiled, copy
from flexmb.linalg.complex_lu import factor_complex, solve_complex
from flexmb.linalg.lu import LOST_PIVOT, factor
from flexmb.linalg.substitute import solve, solve_two
from flexmb.state.record import NEWTON_FAILED, NOT_FINITE, RUNNING, SINGULAR
from flexmb.step.newmark.error_control import LEAST_STATE, find_speeds, in_free_flight, state_scale
from flexmb.step.newmark.newton_correction import ANGLE_ALLOWANCE, ROUND_OFF, STATE_ROUND_OFF
from flexmb.step.newmark.redundant_constraints import initial_hold
from flexmb.step.radau.collocation import (
    ESTIMATE,
    FROM_IM,
    FROM_RE,
    FROM_REAL,
    LAST,
    MIDDLE,
    ONCE,
    PAIR_IM,
    PAIR_RE,
    REAL,
    STAGES,
    TO_IM,
    TO_RE,
    TO_REAL,
    TWICE,
    C,
)
from flexmb.step.runge_kutta import accelerate, project_state
from flexmb.system.elements import evaluate_energies
from flexmb.system.evaluate import evaluate

MOST_ITERATIONS = 16
"""Number of Newton iterations of a step at most."""

REFACTOR_RATE, REFACTOR_ITERATIONS = 0.02, 4
"""Error factor theta/(1 - theta) and number of iterations, above which the next step factors new matrices."""

ITERATION_FRACTION = 0.1
"""Error that Newton's iteration may leave, over rtol^(1/2) times the accepted error of a step.

The error of the method is much less than the accepted error, the more so the smaller rtol is.
"""

CLOSED_SHIFT, LARGE_SHIFT = 1e-14, 1e-4
"""Projection shift relative to the size of the mechanism: up to the first round-off, above the second large."""

FIXED_STEP_TOLERANCE, LEAST_TOLERANCE = 1e-10, 1e-15
"""Tolerance of corrections relative to h^2 |a|: for fixed steps, and the least one for all steps."""

STALLED_RATE = 0.3
"""Contraction rate above which corrections that are round-off of the coordinates do not get smaller.

Many corrections get much smaller: round-off of the positions counts only with stiff forces.
"""

LEAST_RATE = 1e-2
"""Least error factor of the first iteration of a step, which is not measured in this step."""


@compiled
def radau_step(tables, address, lu, h, options, flow, trial, work, record, R):
    """Try a step of size h; RUNNING if Newton's iteration converged, else the code of the failure.

    Unknowns are Q_i, V_i, A_i, lam_i of the stages at t_i = t + c_i h.  Equations of motion and constraints in
    velocities hold at the stages,

        r(t_i, Q_i, V_i, A_i) + G^T lam_i = 0,   G V_i + g_t = 0,
        V_i = v0 + h sum_j a_ij A_j,   Q_i = q0 + h sum_j a_ij V_j.

    Equations (4.15) and (4.16) of docs/theory/integrators.md.
    """
    code = NEWTON_FAILED
    for attempt in range(2):
        extrapolate = attempt == 0 and R.step.last > 0.0
        predict_stages(tables.sizes.n_q, tables.sizes.n_c, h, extrapolate, flow, R)
        if R.step.factored_size != h or not extrapolate:
            code = factor_matrices(tables, address, lu, h, flow, trial, work, record, R)
            if code != RUNNING:
                return code
        code = newton_iterations(tables, address, lu, h, options, flow, trial, work, record, R)
        if code == RUNNING or not extrapolate:
            break
    if code != RUNNING:
        R.step.factored_size = 0.0
        return code
    copy(R.Q[LAST], trial.q)
    copy(R.V[LAST], trial.v)
    copy(R.L[LAST], trial.lam)
    t = flow.clock.t + h
    if tables.sizes.n_c > 0:
        code = close_joints(tables, address, lu, t, h, options, flow, trial, work, record, R)
        if code != RUNNING:
            return code
    code = accelerate(tables, address, lu, t, 1.0, h, R.zero, options, flow, trial, work, record, R)
    copy(trial.a, trial.x)
    return code


@compiled
def factor_matrices(tables, address, lu, h, flow, trial, work, record, R):
    """Factor [[K + s C + s^2 M, G^T], [G, 0]] at the middle stage for both eigenvalues s of D/h.

    G and G^T stand in the real and in the imaginary part of the complex matrix: there they are multiplied by 1 + i.

    Equation (4.17) of docs/theory/integrators.md.
    """
    n, past = tables.sizes.n_q, C[MIDDLE] * h
    t, Q, V, A, L = flow.clock.t + past, R.Q[MIDDLE], R.V[MIDDLE], R.A[MIDDLE], R.L[MIDDLE]
    s, a, b = REAL / h, PAIR_RE / h, PAIR_IM / h
    for system in range(3):
        kq = 0.0 if system == 2 else 1.0
        kv = s if system == 0 else (a if system == 1 else b)
        ka = s * s if system == 0 else (a * a - b * b if system == 1 else 2.0 * a * b)
        evaluate(tables, address, t, past, Q, V, A, L, flow.z, kq, kv, ka, True, work)
        copy(work.lu, R.real if system == 0 else (R.re if system == 1 else R.im))
    record.count.evaluations += 3
    record.count.factorisations += 2
    R.step.factored_size = 0.0
    lost = factor(lu, R.real, trial.pivot_scale, LOST_PIVOT, n, initial_hold(flow))
    if lost < 0:
        lost = factor_complex(lu, R.re, R.im, trial.pivot_scale)
    if lost >= 0:
        record.count.lost_pivot = lost
        return SINGULAR
    R.step.factored_size = h
    return RUNNING


@compiled
def close_joints(tables, address, lu, t, h, options, flow, trial, work, record, R):
    """Project positions and velocities at the end of the step onto the constraints, with least kinetic energy.

    `runge_kutta.project_state` takes over for a large shift or redundant constraints.
    """
    n, m = tables.sizes.n_q, tables.sizes.n_c
    for iteration in range(STAGES):
        evaluate(
            tables, address, t, h, trial.q, trial.v, R.zero, trial.lam, flow.z, 0.0, 0.0, 1.0, iteration == 0, work
        )
        record.count.evaluations += 1
        if iteration == 0:
            record.count.factorisations += 1
            if factor(lu, work.lu, trial.pivot_scale, LOST_PIVOT, n, initial_hold(flow)) != -1:
                break
        R.x[:] = 0.0
        R.y[:] = 0.0
        for i in range(m):
            R.x[n + i], R.y[n + i] = -work.g[i], -work.gv[i]
        solve_two(lu, work.lu, R.x, R.y, R.x, R.y, R.pair)
        largest = 0.0
        for i in range(n):
            trial.q[i] += R.x[i]
            trial.v[i] += R.y[i]
            largest = max(largest, abs(R.x[i]))
        if largest <= CLOSED_SHIFT * options.length:
            return RUNNING
        if not largest <= LARGE_SHIFT * options.length:
            break
    return project_state(tables, address, lu, t, h, options, flow, trial, work, record, R)


@compiled
def predict_stages(n, m, h, extrapolate, flow, R):
    """Predict the stages: with extrapolated accelerations and multipliers, or with constant ones."""
    for stage in range(STAGES):
        w0, w1, w2, w3 = cubic_weights(1.0 + C[stage] * h / R.step.last) if extrapolate else (0.0, 0.0, 0.0, 1.0)
        A, L = R.A[stage], R.L[stage]
        for i in range(n):
            A[i] = flow.a[i]
            if extrapolate:
                A[i] = w0 * R.past[0, i] + w1 * R.past[1, i] + w2 * R.past[2, i] + w3 * R.past[3, i]
        for i in range(m):
            L[i] = flow.lam[i]
            if extrapolate:
                L[i] = w0 * R.past_lam[0, i] + w1 * R.past_lam[1, i] + w2 * R.past_lam[2, i] + w3 * R.past_lam[3, i]
    for stage in range(STAGES):
        Q, V = R.Q[stage], R.V[stage]
        for i in range(n):
            once, twice = 0.0, 0.0
            for k in range(STAGES):
                once += ONCE[stage][k] * R.A[k, i]
                twice += TWICE[stage][k] * R.A[k, i]
            V[i] = flow.v[i] + h * once
            Q[i] = flow.q[i] + h * (C[stage] * flow.v[i] + h * twice)


@compiled
def cubic_weights(s):
    """Lagrange weights at s of the cubic through values at 0, c_1, c_2, 1."""
    x0, x1, x2, x3 = s, s - C[0], s - C[1], s - 1.0
    return (
        x1 * x2 * x3 / (-C[0] * C[1]),
        x0 * x2 * x3 / (C[0] * (C[0] - C[1]) * (C[0] - 1.0)),
        x0 * x1 * x3 / (C[1] * (C[1] - C[0]) * (C[1] - 1.0)),
        x0 * x1 * x2 / ((1.0 - C[0]) * (1.0 - C[1])),
    )


@compiled
def newton_iterations(tables, address, lu, h, options, flow, trial, work, record, R):
    """Newton's iteration on all stages; RUNNING if the estimated remaining error is within the tolerance."""
    last, rate = math.inf, max(R.step.error_factor, LEAST_RATE) ** 0.8
    for iteration in range(MOST_ITERATIONS):
        residuals(tables, address, h, flow, work, record, R)
        size, noise = apply_correction(tables, lu, h, options, flow, trial, record, R)
        if not math.isfinite(size):
            return NOT_FINITE
        if iteration > 0:
            theta = size / last if last > 0.0 else 0.0
            if size > noise and (theta >= 2.0 or (theta >= 0.95 and iteration > 2)):
                return NEWTON_FAILED
            rate = theta / max(1.0 - theta, 0.05)
            if size <= noise and theta > STALLED_RATE:
                rate = 0.0
        if rate * size <= 1.0:
            R.step.error_factor, R.step.iterations = rate, iteration + 1
            if rate > REFACTOR_RATE or iteration >= REFACTOR_ITERATIONS:
                R.step.factored_size = 0.0
            return RUNNING
        last = size
    return NEWTON_FAILED


@compiled
def residuals(tables, address, h, flow, work, record, R):
    """Fill R.b: negative residuals of the equations of motion and of the constraints in velocities, for each stage."""
    n, m = tables.sizes.n_q, tables.sizes.n_c
    for stage in range(STAGES):
        elapsed = C[stage] * h
        Q, V, A, L = R.Q[stage], R.V[stage], R.A[stage], R.L[stage]
        evaluate(tables, address, flow.clock.t + elapsed, elapsed, Q, V, A, L, flow.z, 1.0, 0.0, 0.0, False, work)
        for i in range(n):
            R.b[stage, i] = -(work.r[i] + work.Gl[i])
        for i in range(m):
            R.b[stage, n + i] = -work.gv[i]
    record.count.evaluations += STAGES
    record.count.iterations += 1
    record.count.solves += 2


@compiled
def apply_correction(tables, lu, h, options, flow, trial, record, R):
    """Correct all stages; return the sizes of the correction and of its round-off over the tolerance."""
    n, m = tables.sizes.n_q, tables.sizes.n_c
    s, a, b = REAL / h, PAIR_RE / h, PAIR_IM / h
    to_d, to_x, to_y = TO_REAL, TO_RE, TO_IM
    for i in range(n + m):
        r0, r1, r2 = R.b[0, i], R.b[1, i], R.b[2, i]
        R.d[i] = to_d[0] * r0 + to_d[1] * r1 + to_d[2] * r2
        R.x[i] = to_x[0] * r0 + to_x[1] * r1 + to_x[2] * r2
        R.y[i] = to_y[0] * r0 + to_y[1] * r1 + to_y[2] * r2
    for i in range(n, n + m):  # G w = -g'/s; in the complex system (1 + i) G
        R.d[i] /= s
        x, y, square = R.x[i], R.y[i], a * a + b * b
        p, q = (x * a + y * b) / square, (y * a - x * b) / square
        R.x[i], R.y[i] = p - q, p + q
    solve(lu, R.real, R.d, R.d, R.pair)
    solve_complex(lu, R.re, R.im, R.x, R.y, R.pair)
    for i in range(n, n + m):
        x, y = R.x[i], R.y[i]
        R.x[i], R.y[i] = x - y, x + y
    for stage in range(STAGES):
        own, along, across = FROM_REAL[stage], FROM_RE[stage], FROM_IM[stage]
        Q, V, A, L = R.Q[stage], R.V[stage], R.A[stage], R.L[stage]
        for i in range(n):
            d, x, y = R.d[i], R.x[i], R.y[i]
            dq = own * d + along * x - across * y
            d, x, y = s * d, a * x - b * y, a * y + b * x
            V[i] += own * d + along * x - across * y
            d, x, y = s * d, a * x - b * y, a * y + b * x
            A[i] += own * d + along * x - across * y
            Q[i] += dq
            R.b[stage, i] = dq
        for i in range(m):
            L[i] += own * R.d[n + i] + along * R.x[n + i] - across * R.y[n + i]
    return correction_size(tables, h, options, flow, trial, record, R)


@compiled
def correction_size(tables, h, options, flow, trial, record, R):
    """Size of the correction, the largest of all nodes, and of its round-off; both over the tolerance."""
    way, iteration, fast, far_x, far_t = 0.0, 0.0, 0.0, options.length**2, 1.0
    total = 0.0
    for stage in range(STAGES):
        for i in range(0, tables.sizes.n_b, 3):  # x, y, theta of a node
            d, q, a = part_of(R.b[stage], i, i + 3), part_of(R.Q[stage], i, i + 3), part_of(R.A[stage], i, i + 3)
            near = d[0] * d[0] + d[1] * d[1]
            total += near + abs(d[2])
            way, iteration = max(way, near), max(iteration, abs(d[2]))
            fast = max(fast, math.sqrt(a[0] * a[0] + a[1] * a[1]), options.length * abs(a[2]))
            far_x, far_t = max(far_x, q[0] * q[0] + q[1] * q[1]), max(far_t, abs(q[2]) - ANGLE_ALLOWANCE)
    if tables.sizes.n_q > tables.sizes.n_b:
        of_states, of_round_off = state_corrections(tables, h, options, flow, trial, R)
        total += of_states
    else:
        of_states, of_round_off = 0.0, 0.0
    if not math.isfinite(total):
        return math.inf, 0.0
    wanted = FIXED_STEP_TOLERANCE * h * h * fast
    if options.adaptive:
        rtol, speed = trial.control.rtol, math.inf
        for g in range(flow.largest_speeds.shape[0]):
            speed = min(speed, max(flow.largest_speeds[g], trial.control.least_speed))
        wanted = ITERATION_FRACTION * math.sqrt(rtol) * min(options.error, h * rtol * speed)
    round_x, round_t = ROUND_OFF * math.sqrt(far_x), ROUND_OFF * far_t
    wanted += LEAST_TOLERANCE * h * h * fast
    wanted_x, wanted_t = wanted, wanted / options.length
    of_x, of_t = math.sqrt(way) / wanted_x, iteration / wanted_t
    step = record.report
    step.correction, step.tolerance = (math.sqrt(way), wanted_x) if of_x > of_t else (iteration, wanted_t)
    step.length_tolerance, step.angle_tolerance = wanted_x, wanted_t
    return max(of_x, of_t, of_states), 2.0 * max(round_x / wanted_x, round_t / wanted_t, of_round_off)


@compiled
def state_corrections(tables, h, options, flow, trial, R):
    """Size of the correction of the states of controls, and of its round-off; both over the tolerance."""
    worst, noise = 0.0, 0.0
    for stage in range(STAGES):
        for i in range(tables.sizes.n_b, tables.sizes.n_q):
            scale = state_scale(tables, i, R.V[stage, i], R.A[stage, i], options, flow)
            wanted = (FIXED_STEP_TOLERANCE if not options.adaptive else 0.0) * h * h * abs(R.A[stage, i])
            if options.adaptive:
                wanted = ITERATION_FRACTION * trial.control.rtol**1.5 * h * scale
            wanted += LEAST_TOLERANCE * h * h * abs(R.A[stage, i]) + LEAST_STATE
            worst = max(worst, abs(R.b[stage, i]) / wanted)
            noise = max(noise, STATE_ROUND_OFF * h * scale / wanted)
    return worst, noise


@compiled
def radau_error(tables, address, lu, h, options, flow, trial, work, R):
    """Estimated error of positions and velocities over the accepted error.

    The estimate is of third order, the method of fifth: with 0.1 rtol^(2/3) in place of rtol in the estimate, the
    errors of a run are proportional to rtol.
    x = (f0 + sum ESTIMATE_i Z_i/h)/s is the difference to a formula of third order.  (K + s C + s^2 M)^-1 s^2 M x keeps
    its components that are not stiff and satisfy the constraints.  Positions and velocities count as in
    `newmark.error_control.error_ratio`.

    Equation (4.18) of docs/theory/integrators.md.
    """
    n, m, s = tables.sizes.n_q, tables.sizes.n_c, REAL / h
    for i in range(n):
        q, v = 0.0, 0.0
        for k in range(STAGES):
            q += ESTIMATE[k] * (R.Q[k, i] - flow.q[i])
            v += ESTIMATE[k] * (R.V[k, i] - flow.v[i])
        R.of_q[i], R.of_v[i] = (flow.v[i] + q / h) / s, (flow.a[i] + v / h) / s
    times_mass(tables, address, h, R.of_q, flow, work, R.x, R)
    times_mass(tables, address, h, R.of_v, flow, work, R.y, R)
    for i in range(n):
        R.x[i], R.y[i] = s * s * R.x[i], s * s * R.y[i]
    for i in range(n, n + m):
        R.x[i], R.y[i] = 0.0, 0.0
    solve_two(lu, R.real, R.x, R.y, R.x, R.y, R.pair)
    loose = 0.1 * trial.control.rtol ** (-1.0 / 3.0)
    of_q = 1.0 / (loose * options.error)
    find_speeds(tables.sizes.n_b, options, flow, trial)
    if in_free_flight(tables, flow):
        of_q *= trial.control.flight_weight
    worst = 0.0
    for k in range(0, tables.sizes.n_b, 3):
        worst = max(worst, of_q * math.sqrt(R.x[k] ** 2 + R.x[k + 1] ** 2), options.length * of_q * abs(R.x[k + 2]))
        if trial.rigid[k]:
            of_v = 1.0 / (loose * trial.control.rtol * trial.speeds[trial.groups[k]])
            worst = max(worst, of_v * math.sqrt(R.y[k] ** 2 + R.y[k + 1] ** 2), options.length * of_v * abs(R.y[k + 2]))
    for i in range(tables.sizes.n_b, n):
        scale = state_scale(tables, i, trial.v[i], trial.a[i], options, flow)
        worst = max(worst, abs(R.y[i]) / (loose * trial.control.rtol * scale))
    return worst if math.isfinite(worst) else math.inf


@compiled
def times_mass(tables, address, h, x, flow, work, target, R):
    """Set target[:n_q] = M x, with the masses at the start of the step."""
    evaluate_energies(tables, address, flow.clock.t, h, flow.q, x, flow.a, R.zero, R.zero, flow.z, work)
    for i in range(tables.sizes.n_b):
        target[i] = work.momentum[i]
    for i in range(tables.sizes.n_b, tables.sizes.n_q):  # states of controls
        target[i] = x[i]
