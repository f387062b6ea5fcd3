"""Step of Radau's method with three stages: prediction, Newton iteration, projection, error estimate.

Constraints hold in velocities at the stages (index 2).  At the end of the step positions and velocities are projected
onto the constraints; accelerations and multipliers follow from the equations of motion.  All are of order 5.
"""

import math

import flexmb.engine.energy as entries
from flexmb.engine.compiled.arrays import part_of
from flexmb.engine.energy import contact_losses, count_step, update_balance, update_residual
from flexmb.engine.linalg.lu import factor_complex, multiply, solve, solve_complex, solve_two
from flexmb.engine.newmark.error_control import LEAST_STATE, find_speeds, in_free_flight, largest_error, state_scale
from flexmb.engine.newmark.implicit_step import ANGLE_ALLOWANCE, LEAST_CORRECTION, ROUND_OFF, STATE_ROUND_OFF
from flexmb.engine.newmark.jacobian_reuse import factor_without_redundant, initial_hold, take_least_norm
from flexmb.engine.radau import collocation as radau
from flexmb.engine.radau.collocation import LAST, MIDDLE, STAGES, C
from flexmb.engine.state.record import NEWTON_FAILED, NOT_FINITE, RUNNING, SINGULAR
from flexmb.engine.step.acceptance import adopt_trial, report_step
from flexmb.engine.step.contact_events import note_passed_contacts, update_episodes
from flexmb.engine.step.runge_kutta import accelerate, project_state
from flexmb.engine.system import work as columns
from flexmb.engine.system.constraints import call_joint_friction, call_joint_load, report_forces
from flexmb.engine.system.contacts import call_friction, jacobians
from flexmb.engine.system.elements import evaluate_energies
from flexmb.engine.system.evaluate import evaluate, evaluate_accepted
from flexmb.engine.system.work import gather
from flexmb.kernels import compiled, copy
from flexmb.places import FRICTION_FORCE, GAP_RATE, LOAD, NORMAL_FORCE, SLIDING, SLIP, TANGENTIAL
from flexmb.program.program import BEGIN, END, FRICTION_Z, LOAD_KERNEL, Z_END

MOST_ITERATIONS = 16  # number of Newton iterations of a step at most
# Error factor theta/(1 - theta) and number of iterations, above which the next step factors new matrices.
REFACTOR_RATE, REFACTOR_ITERATIONS = 0.02, 4
# Error that Newton's iteration may leave, over rtol^(1/2) times the accepted error of a step.
# The error of the method is much less than the accepted error, the more so the smaller rtol is.
ITERATION_FRACTION = 0.1
# Projection shift relative to the size of the mechanism: up to the first round-off, up to the second if it gets no
# smaller (angles of short links), above the third large.
CLOSED_SHIFT, STALLED_SHIFT, LARGE_SHIFT = 1e-14, 1e-12, 1e-4
# Tolerance of corrections relative to h^2 |a|: for fixed steps, and the least one for all steps.
FIXED_STEP_TOLERANCE, LEAST_TOLERANCE = 1e-10, 1e-15
# Contraction rate above which corrections that are round-off of the coordinates do not get smaller.
# Many corrections get much smaller: round-off of the positions counts only with stiff forces.
STALLED_RATE = 0.3
LEAST_RATE = 1e-2  # least error factor of the first iteration of a step, which is not measured in this step


@compiled
def radau_step(tables, address, lu, h, options, flow, trial, work, record, R):
    """Try a step of size h; RUNNING if Newton's iteration converged, else the code of the failure."""
    # Unknowns are Q_i, V_i, A_i, lam_i of the stages at t_i = t + c_i h. Equations of motion and constraints in
    # velocities hold at the stages,
    #     r(t_i, Q_i, V_i, A_i) + G^T lam_i = 0,   G V_i + g_t = 0,
    #     V_i = v0 + h sum_j a_ij A_j,   Q_i = q0 + h sum_j a_ij V_j.
    # Equations (4.15) and (4.16) of docs/theory/integrators.md.
    for attempt in range(3):  # with accelerations extrapolated, constant, 0
        extrapolate = attempt == 0 and R.step.last > 0.0
        if attempt == 1 and R.step.last == 0.0:
            continue
        predict_stages(tables.sizes.n_q, tables.sizes.n_c, h, extrapolate, 0.0 if attempt == 2 else 1.0, flow, R)
        if R.step.factored_size != h or not extrapolate:
            code = factor_matrices(tables, address, lu, h, flow, trial, work, record, R)
            if code != RUNNING:
                return code
        code = newton_iterations(tables, address, lu, h, options, flow, trial, work, record, R)
        if code == RUNNING or (code != NEWTON_FAILED and not extrapolate):
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
    """Factor [[K + s C + s^2 M, G^T], [G, 0]] at the middle stage for both eigenvalues s of D/h."""
    # G and G^T stand in the real and in the imaginary part of the complex matrix: there they are multiplied by 1 + i.
    # Equation (4.17) of docs/theory/integrators.md.
    n, past = tables.sizes.n_q, C[MIDDLE] * h
    t, Q, V, A, L = flow.clock.t + past, R.Q[MIDDLE], R.V[MIDDLE], R.A[MIDDLE], R.L[MIDDLE]
    s, a, b = radau.REAL / h, radau.PAIR_RE / h, radau.PAIR_IM / h
    for system in range(3):
        kq = 0.0 if system == 2 else 1.0
        kv = s if system == 0 else (a if system == 1 else b)
        ka = s * s if system == 0 else (a * a - b * b if system == 1 else 2.0 * a * b)
        evaluate(tables, address, t, past, Q, V, A, L, flow.z, kq, kv, ka, True, work)
        copy(work.lu, R.real if system == 0 else (R.re if system == 1 else R.im))
    evaluate(tables, address, t, past, Q, V, A, L, flow.z, 0.0, s, s * s, True, work)
    copy(work.lu, R.inertia)
    record.count.evaluations += 4
    record.count.factorisations += 2
    R.step.factored_size = 0.0
    lost = factor_without_redundant(lu, R.real, initial_hold(flow), n, trial)
    if lost < 0:
        lost = factor_complex(lu, R.re, R.im, trial.pivot_scale)
    if lost >= 0:
        record.count.lost_pivot = lost
        return SINGULAR
    R.step.factored_size = h
    return RUNNING


@compiled
def close_joints(tables, address, lu, t, h, options, flow, trial, work, record, R):
    """Project positions and velocities at the end of the step onto the constraints, with least kinetic energy."""
    # `runge_kutta.project_state` takes over for a large shift or redundant constraints.
    n, m, last = tables.sizes.n_q, tables.sizes.n_c, math.inf
    for iteration in range(STAGES):
        q, v, still, first = trial.q, trial.v, R.zero, iteration == 0
        evaluate(tables, address, t, h, q, v, still, trial.lam, flow.z, 0.0, 0.0, 1.0, first, work)
        record.count.evaluations += 1
        if first:
            record.count.factorisations += 1
            if factor_without_redundant(lu, work.lu, initial_hold(flow), n, trial) != -1:
                break
        R.x[:] = R.y[:] = 0.0
        for i in range(m):
            R.x[n + i], R.y[n + i] = -work.g[i], -work.gv[i]
        solve_two(lu, work.lu, R.x, R.y, R.x, R.y, R.pair)
        largest = 0.0
        for i in range(n):
            trial.q[i] += R.x[i]
            trial.v[i] += R.y[i]
            largest = max(largest, abs(R.x[i]))
        if is_closed(largest, last, options.length):
            return RUNNING
        if not largest <= LARGE_SHIFT * options.length:
            break
        last = largest
    return project_state(tables, address, lu, t, h, options, flow, trial, work, record, R)


@compiled
def is_closed(shift, last, length):
    """Whether a shift is round-off: small, or not much smaller than the one before, `last`."""
    return shift <= CLOSED_SHIFT * length or STALLED_RATE * last < shift <= STALLED_SHIFT * length


@compiled
def predict_stages(n, m, h, extrapolate, share, flow, R):
    """Predict the stages: with extrapolated accelerations and multipliers, or with constant ones, times `share`."""
    # Accelerations of light bodies in stiff films may be errors of velocities over a step.
    for stage in range(STAGES):
        w0, w1, w2, w3 = cubic_weights(1.0 + C[stage] * h / R.step.last) if extrapolate else (0.0, 0.0, 0.0, 1.0)
        A, L = R.A[stage], R.L[stage]
        for i in range(n):
            A[i] = share * flow.a[i]
            if extrapolate:
                A[i] = w0 * R.past[0, i] + w1 * R.past[1, i] + w2 * R.past[2, i] + w3 * R.past[3, i]
        for i in range(m):
            L[i] = flow.lam[i]
            if extrapolate:
                L[i] = w0 * R.past_lam[0, i] + w1 * R.past_lam[1, i] + w2 * R.past_lam[2, i] + w3 * R.past_lam[3, i]
    for stage in range(STAGES):
        reach_stage(n, stage, h, flow.q, flow.v, R.A, R.Q[stage], R.V[stage])


@compiled
def reach_stage(n, stage, h, q, v, A, Q, V):
    """Set positions Q and velocities V of a stage by the state q, v at the start and accelerations A of all stages."""
    for i in range(n):
        once, twice = 0.0, 0.0
        for k in range(STAGES):
            once += radau.ONCE[stage][k] * A[k, i]
            twice += radau.TWICE[stage][k] * A[k, i]
        V[i] = v[i] + h * once
        Q[i] = q[i] + h * (C[stage] * v[i] + h * twice)


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
    s, a, b = radau.REAL / h, radau.PAIR_RE / h, radau.PAIR_IM / h
    (d0, d1, d2), (x0, x1, x2), (y0, y1, y2) = radau.TO_REAL, radau.TO_RE, radau.TO_IM
    for i in range(n + m):
        r0, r1, r2 = R.b[0, i], R.b[1, i], R.b[2, i]
        R.d[i], R.x[i] = d0 * r0 + d1 * r1 + d2 * r2, x0 * r0 + x1 * r1 + x2 * r2
        R.y[i] = y0 * r0 + y1 * r1 + y2 * r2
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
        own, along, across = radau.FROM_REAL[stage], radau.FROM_RE[stage], radau.FROM_IM[stage]
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
    way, iteration, fast, far_x, far_t, total = 0.0, 0.0, 0.0, options.length**2, 1.0, 0.0
    for stage in range(STAGES):
        for i in range(0, tables.sizes.n_b, 3):  # x, y, theta of a node
            d, q, a = part_of(R.b[stage], i, i + 3), part_of(R.Q[stage], i, i + 3), part_of(R.A[stage], i, i + 3)
            near = d[0] * d[0] + d[1] * d[1]
            total += near + abs(d[2])
            way, iteration = max(way, near), max(iteration, abs(d[2]))
            fast = max(fast, math.sqrt(a[0] * a[0] + a[1] * a[1]), options.length * abs(a[2]))
            far_x, far_t = max(far_x, q[0] * q[0] + q[1] * q[1]), max(far_t, abs(q[2]) - ANGLE_ALLOWANCE)
    of_states, of_round_off = 0.0, 0.0
    if tables.sizes.n_q > tables.sizes.n_b:
        of_states, of_round_off = state_corrections(tables, h, options, flow, trial, R)
    total += of_states
    if not math.isfinite(total):
        return math.inf, 0.0
    wanted = FIXED_STEP_TOLERANCE * h * h * fast
    if options.adaptive:
        rtol, speed = trial.control.rtol, math.inf
        for g in range(flow.largest_speeds.shape[0]):
            speed = min(speed, max(flow.largest_speeds[g], trial.control.least_speed))
        wanted = ITERATION_FRACTION * math.sqrt(rtol) * min(options.error, h * rtol * speed)
    round_x, round_t = ROUND_OFF * math.sqrt(far_x), ROUND_OFF * far_t
    wanted += LEAST_TOLERANCE * h * h * fast + LEAST_CORRECTION
    wanted_x, wanted_t = wanted, wanted / options.length
    of_x, of_t, step = math.sqrt(way) / wanted_x, iteration / wanted_t, record.report
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
def radau_error(tables, address, lu, h, options, flow, trial, work, record, R):
    """Estimated error of positions and velocities over the accepted error."""
    # The estimate is of third order, the method of fifth: with 0.1 rtol^(2/3) in place of rtol in the estimate, the
    # errors of a run are proportional to rtol. x = (f0 + sum ESTIMATE_i Z_i/h)/s is the difference to a formula of
    # third order. (K + s C + s^2 M)^-1 (s C + s^2 M) x, of velocities without s C, keeps its components that are not
    # stiff and satisfy the constraints: strong damping makes velocities stiff, but not positions, which creep.
    # Positions and velocities count as in `newmark.error_control.error_ratio`.
    # The error of friction with a history, of second order in a run, counts by rtol itself.
    # Equation (4.18) of docs/theory/integrators.md.
    n, m, s = tables.sizes.n_q, tables.sizes.n_c, radau.REAL / h
    for i in range(n):
        q, v = 0.0, 0.0
        for k in range(STAGES):
            q += radau.ESTIMATE[k] * (R.Q[k, i] - flow.q[i])
            v += radau.ESTIMATE[k] * (R.V[k, i] - flow.v[i])
        R.d[i], R.of_v[i] = (flow.v[i] + q / h) / s, (flow.a[i] + v / h) / s
    for i in range(n, n + m):
        R.d[i] = 0.0
    multiply(lu, R.inertia, R.d, R.x)
    # M of_v, with the masses at the start of the step.
    evaluate_energies(tables, address, flow.clock.t, h, flow.q, R.of_v, flow.a, R.zero, R.zero, flow.z, work)
    for i in range(n):  # states of controls have the mass 1
        R.y[i] = (work.momentum[i] if i < tables.sizes.n_b else R.of_v[i]) * (s * s)
    loose = 0.1 * trial.control.rtol ** (-1.0 / 3.0)
    if has_friction_history(tables):
        add_history_error(tables, address, h, s * s * h * loose, flow, work, record, R)
    for i in range(n, n + m):
        R.x[i], R.y[i] = 0.0, 0.0
    solve_two(lu, R.real, R.x, R.y, R.x, R.y, R.pair)
    of_q = 1.0 / (loose * options.error)
    find_speeds(tables.sizes.n_b, options, flow, trial)
    if in_free_flight(tables, flow):
        of_q *= trial.control.flight_weight
    worst = largest_error(tables, of_q, loose * trial.control.rtol, R.x, R.y, trial.a, False, options, flow, trial)
    return worst if math.isfinite(worst) else math.inf


@compiled
def add_history_error(tables, address, h, weight, flow, work, record, R):
    """Add to R.y errors of friction with histories: `weight` times the force by two shorter steps less that by one."""
    # A friction law with a history is integrated over the step by its own rule, of low order.
    K, J, t, half = tables.contacts, tables.constraints, flow.clock.t, C[MIDDLE] * h
    Q, V, A, L, middle = R.Q[MIDDLE], R.V[MIDDLE], R.A[MIDDLE], R.L[MIDDLE], R.between.z
    evaluate(tables, address, t + half, half, Q, V, A, L, flow.z, 1.0, 0.0, 0.0, False, work)
    copy(work.z_new, middle)
    Q, V, A, L = R.Q[LAST], R.V[LAST], R.A[LAST], R.L[LAST]
    evaluate(tables, address, t + h, h, Q, V, A, L, flow.z, 1.0, 0.0, 0.0, False, work)
    record.count.evaluations += 2
    for c in range(K.kernel.shape[0]):
        if K.z[c, Z_END] > K.z[c, FRICTION_Z]:
            out, S = work.contact[c], work.contact_scratch
            T, _, _ = call_friction(tables, address, c, h - half, out[SLIP], out[NORMAL_FORCE], middle, work.z_new)
            jacobians(out, S)
            for i in range(6):
                R.y[K.dofs[6 * c + i]] += weight * S[TANGENTIAL, i] * (T - out[FRICTION_FORCE])
    for c in range(work.joint_friction.shape[0]):
        if J.joint_friction_z[c, END] > J.joint_friction_z[c, BEGIN]:
            n, out, own = J.dof[c + 1] - J.dof[c], work.joint_friction_out, work.joint_friction[c]
            gather(Q, J.dofs, J.dof[c], n, work.ql)
            call_joint_load(tables, address, c, n, L, work)
            slip, first = own[columns.JOINT_SLIP], own[columns.JOINT_FRICTION_FORCE]
            T, _, _ = call_joint_friction(tables, address, c, h - half, slip, out[LOAD], middle, work.z_new)
            for i in range(6):
                R.y[J.dofs[J.dof[c] + i]] += weight * out[SLIDING + i] * (T - first)


@compiled
def has_friction_history(tables):
    """Whether a friction law has a history."""
    K, J = tables.contacts, tables.constraints
    for c in range(K.kernel.shape[0]):
        if K.z[c, Z_END] > K.z[c, FRICTION_Z]:
            return True
    for c in range(J.joint_friction_z.shape[0]):  # noqa: SIM110 - compiled
        if J.joint_friction_z[c, END] > J.joint_friction_z[c, BEGIN]:
            return True
    return False


# Difference between computed and interpolated accelerations within a step relative to the largest, up to which the
# computed ones are used: with stiff forces, they are the error of the interpolated positions times the stiffness.
ACCELERATION_MISMATCH = 0.01
# Change of the computed accelerations by other interpolated positions, relative to the difference above, up to which
# they are used nevertheless: a drive, cam or load has a kink within the step, which no interpolation follows.
INSENSITIVE = 0.1


@compiled
def add_works(tables, address, lu, h, options, flow, trial, work, record, R):
    """Fill R.works and R.losses; the last evaluation is that of the trial state."""
    # Works of dampers, contacts and loads by Radau's quadrature over the stages. Works of drives and of friction in
    # joints by Simpson's rule with the middle of the step, since multipliers at the stages are of third order.
    W, Q, V, A, L = R.works, R.Q[LAST], R.V[LAST], R.A[LAST], R.L[LAST]
    W.drives = W.loads = W.joints = W.damping = W.supplied = W.joints_size = 0.0
    R.losses[:, :] = R.rates[:, :] = 0.0
    copy(trial.q, Q)
    copy(trial.v, V)
    copy(trial.a, A)
    copy(trial.lam, L)
    t = flow.clock.t
    start, end, other = R.rates[radau.AT_START], R.rates[radau.AT_END], R.rates[radau.ELSEWHERE]
    if has_work(tables, flow):
        add_powers(tables, address, t, 0.0, 0.0, h / 6.0, flow.q, flow.v, flow.a, flow.lam, flow, work, R, start)
        for stage in range(LAST):
            q, v, a, lam = R.Q[stage], R.V[stage], R.A[stage], R.L[stage]
            elapsed, weight = C[stage] * h, radau.WEIGHTS[stage] * h
            add_powers(tables, address, t + elapsed, elapsed, weight, 0.0, q, v, a, lam, flow, work, R, other)
        find_between(tables, address, lu, t, 0.5, h, Q, V, A, L, options, flow, trial, work, record, R)
        q, v, a, lam, elapsed = trial.q, trial.v, trial.a, trial.lam, 0.5 * h
        add_powers(tables, address, t + elapsed, elapsed, 0.0, h / 1.5, q, v, a, lam, flow, work, R, other)
        copy(Q, trial.q)
        copy(V, trial.v)
        copy(A, trial.a)
        copy(L, trial.lam)
        record.count.evaluations += 4
    add_powers(tables, address, t + h, h, radau.WEIGHTS[LAST] * h, h / 6.0, Q, V, A, L, flow, work, R, end)
    record.count.evaluations += 1


@compiled
def find_between(tables, address, lu, t, s, h, q1, v1, a1, lam1, options, flow, trial, work, record, R):
    """Set the trial state to the state at fraction s of the step from R.old to q1, ..., which began at t."""
    # Accelerations and multipliers satisfy the equations of motion. Interpolated ones (through both ends and the
    # stages) are used where these differ much, and depend much on how positions are interpolated.
    n, m, n_b, old = tables.sizes.n_q, tables.sizes.n_c, tables.sizes.n_b, R.old
    quintic(n, s, h, old, q1, v1, trial, a1)
    w0, w1, w2, w3 = cubic_weights(s)
    for i in range(m):
        R.lam[i] = w0 * old.lam[i] + w1 * R.past_lam[1, i] + w2 * R.past_lam[2, i] + w3 * lam1[i]
        trial.lam[i] = R.lam[i]
    code = accelerate(tables, address, lu, t + s * h, s, h, R.zero, options, flow, trial, work, record, R)
    apart, largest = 0.0, 0.0
    for i in range(n):
        a = w0 * old.a[i] + w1 * R.past[1, i] + w2 * R.past[2, i] + w3 * a1[i]
        size = (options.length if tables.kind[i] == 1 else 1.0) if i < n_b else 0.0
        apart, largest = max(apart, size * abs(trial.a[i] - a)), max(largest, size * max(abs(old.a[i]), abs(a1[i])))
        R.of_q[i], R.of_v[i] = a, trial.a[i]
    if code == RUNNING and apart <= ACCELERATION_MISMATCH * largest:
        take_least_norm(tables, lu, trial, work, record)
        return
    changed = 0.0
    for end in range(2):
        quintic(n, s, h, old, q1, v1, trial, a1)
        leave_out_acceleration(n, s, h, end, old, q1, v1, a1, trial)
        if code == RUNNING:
            code = accelerate(tables, address, lu, t + s * h, s, h, R.zero, options, flow, trial, work, record, R)
        for i in range(n_b):
            changed = max(changed, (options.length if tables.kind[i] == 1 else 1.0) * abs(trial.a[i] - R.of_v[i]))
    quintic(n, s, h, old, q1, v1, trial, a1)
    copy(R.lam, trial.lam)
    if code == RUNNING and changed <= INSENSITIVE * apart:
        accelerate(tables, address, lu, t + s * h, s, h, R.zero, options, flow, trial, work, record, R)
        take_least_norm(tables, lu, trial, work, record)
    else:
        copy(R.of_q, trial.a)
        collocate(n, s, h, old, q1, v1, trial, R)


@compiled
def collocate(n, s, h, old, q, v, trial, R):
    """Set trial positions and velocities at fraction s of the step: cubics through start, stages and end."""
    # They satisfy the equations of motion at the stages, so that stiff forces are those of the stages.
    w0, w1, w2, w3 = cubic_weights(s)
    for i in range(n):
        trial.q[i], trial.v[i] = w0 * old.q[i] + w3 * q[i], w0 * old.v[i] + w3 * v[i]
    for stage in range(LAST):
        reach_stage(n, stage, h, old.q, old.v, R.past[1:], R.of_q, R.of_v)
        w = w1 if stage == 0 else w2
        for i in range(n):
            trial.q[i] += w * R.of_q[i]
            trial.v[i] += w * R.of_v[i]


@compiled
def leave_out_acceleration(n, s, h, end, old, q, v, a, trial):
    """Take from the quintic its part by the acceleration at the start (end = 0) or at the end of the step (1)."""
    for i in range(n):
        rise, v0, v1 = (q[i] - old.q[i]) / h, old.v[i], v[i]
        if end == 0:
            part = 0.5 * h * old.a[i] - (3.0 * rise - 2.0 * v0 - v1)
            trial.q[i] -= h * part * s * s * (1.0 - s) ** 3
            trial.v[i] -= part * s * (1.0 - s) ** 2 * (2.0 - 5.0 * s)
        else:
            part = 0.5 * h * a[i] - (v0 + 2.0 * v1 - 3.0 * rise)
            trial.q[i] -= h * part * s**3 * (1.0 - s) ** 2
            trial.v[i] -= part * s * s * (1.0 - s) * (3.0 - 5.0 * s)


@compiled
def add_powers(tables, address, t, elapsed, forces, joints, q, v, a, lam, flow, work, R, rates):
    """Add the powers of a state at time t to `rates` [W], and, times weights [s], to the works."""
    # forces : weight of dampers, contacts and loads [s];  joints : weight of drives and friction in joints [s]
    evaluate_accepted(tables, address, t, elapsed, q, v, a, lam, flow.z, R.zero, R.zero, work)
    report_forces(tables, lam, work)
    add_known_powers(tables, forces, joints, v, work, R, rates)


@compiled
def add_known_powers(tables, forces, joints, v, work, R, rates):
    """`add_powers` of the state of the last evaluation."""
    W = R.works
    W.damping += forces * work.power.damping
    rates[entries.DAMPING] += work.power.damping
    for row in range(work.drive.shape[0]):
        if tables.constraints.motion[row] >= 0:
            power = work.drive[row, columns.MOTION_RATE] * work.drive[row, columns.DRIVE_FORCE]
            W.drives += joints * power
            rates[entries.DRIVE] += power
            W.supplied += joints * abs(power)
    for c in range(work.joint_friction.shape[0]):
        if tables.constraints.joint_friction[c, LOAD_KERNEL] >= 0:
            power = work.joint_friction[c, columns.JOINT_FRICTION_FORCE] * work.joint_friction[c, columns.JOINT_SLIP]
            W.joints -= joints * power
            rates[entries.FRICTION] -= power
            W.joints_size += joints * abs(power)
    for c in range(R.losses.shape[0]):
        contact = work.contact[c]
        normal, friction = contact[NORMAL_FORCE] * contact[GAP_RATE], contact[FRICTION_FORCE] * contact[SLIP]
        R.losses[c, columns.LOSS_NORMAL] -= forces * normal
        R.losses[c, columns.LOSS_FRICTION] -= forces * friction
        R.losses[c, columns.LOSS_IMPULSE] += forces * contact[NORMAL_FORCE]
        rates[entries.CONTACT] -= normal
        rates[entries.FRICTION] -= friction
    E, place, power = tables.elements, 0, 0.0  # loads: elements without energies of their own
    for e in range(E.p.shape[0]):
        if E.energy[e] < 0:
            for i in range(E.dof[e], E.dof[e + 1]):
                power += work.load[place] * v[E.dofs[i]]
                place += 1
    W.loads += forces * power
    rates[entries.LOAD] += power
    W.supplied += forces * abs(power)


@compiled
def has_work(tables, flow):
    """Whether the mechanism has drives, contacts, friction in joints, dampers or loads."""
    C, E = tables.constraints, tables.elements
    if tables.contacts.kernel.shape[0] > 0 or tables.sizes.has_joint_friction or flow.balance.damping_power != 0.0:
        return True
    for row in range(C.motion.shape[0]):
        if C.motion[row] >= 0:
            return True
    for e in range(E.p.shape[0]):  # noqa: SIM110 - compiled
        if E.energy[e] < 0 or E.factor[e] >= 0:
            return True
    return False


@compiled
def accept_works(tables, address, h, options, flow, trial, work, record, R):
    """Make the trial state the accepted one: `acceptance.accept`, with the works and losses of R."""
    contact_losses(tables, address, 0.0, flow, trial.q, trial.v, work)
    turned = abs(R.works.damping) + R.works.joints_size + R.works.supplied
    for c in range(R.losses.shape[0]):
        normal, friction = R.losses[c, columns.LOSS_NORMAL], R.losses[c, columns.LOSS_FRICTION]
        work.loss[c, columns.LOSS_NORMAL], work.loss[c, columns.LOSS_FRICTION] = normal, friction
        work.loss[c, columns.LOSS_IMPULSE] = R.losses[c, columns.LOSS_IMPULSE]
        turned += abs(normal) + abs(friction)
    update_episodes(tables, h, options, flow, work, record)
    update_ledger(tables, address, flow.clock.t + h, turned, flow, trial, work, R)
    if not options.adaptive:
        note_passed_contacts(tables, address, h, options, flow, trial, work, record)
    adopt_trial(h, flow, trial, work, record)
    report_step(tables, address, True, flow, work, record)


@compiled
def update_ledger(tables, address, t, turned, flow, trial, work, R):
    """Update the ledger to the trial state; `turned`: absolute works of the step [J]."""
    ledger, balance, W, power = flow.ledger, flow.balance, R.works, work.power
    turned += abs(power.kinetic - ledger[entries.KINETIC]) + abs(power.strain - ledger[entries.STRAIN])
    turned += abs(power.gravity - ledger[entries.GRAVITY])
    ledger[entries.DRIVE] += W.drives
    ledger[entries.LOAD] += W.loads
    ledger[entries.FRICTION] += W.joints
    ledger[entries.DAMPING] += W.damping
    ledger[entries.TURNED_OVER] += 0.5 * turned
    balance.supplied += W.supplied
    power.algorithm = 0.0
    count_step(tables, trial.q, balance, work)
    update_balance(tables, address, t, 0.0, flow.q, flow.v, trial.q, trial.v, ledger, balance, flow.memory, work)
    copy(work.momentum, flow.momentum)


@compiled
def complete_ledger(flow, work, ledger):
    """Set the energies of the state that was evaluated last in a ledger, and the residual."""
    power = work.power
    ledger[entries.KINETIC], ledger[entries.STRAIN] = power.kinetic, power.strain
    ledger[entries.GRAVITY] = power.gravity
    update_residual(ledger, flow.balance)


@compiled
def keep_state(flow, old):
    """Copy the accepted state, at the start of a step."""
    copy(flow.q, old.q)
    copy(flow.v, old.v)
    copy(flow.a, old.a)
    copy(flow.z, old.z)
    copy(flow.lam, old.lam)
    copy(flow.ledger, old.ledger)


@compiled
def quintic(n, s, h, old, q, v, trial, a):
    """Set trial positions and velocities at fraction s of the step from `old` to q, v, a: Hermite's polynomial."""
    for i in range(n):
        rise = (q[i] - old.q[i]) / h
        v0, v1, a0, a1 = old.v[i], v[i], h * old.a[i], h * a[i]
        c3 = 10.0 * rise - 6.0 * v0 - 4.0 * v1 - 1.5 * a0 + 0.5 * a1
        c4 = -15.0 * rise + 8.0 * v0 + 7.0 * v1 + 1.5 * a0 - a1
        c5 = 6.0 * rise - 3.0 * (v0 + v1) + 0.5 * (a1 - a0)
        trial.q[i] = old.q[i] + h * s * (v0 + s * (0.5 * a0 + s * (c3 + s * (c4 + s * c5))))
        trial.v[i] = v0 + s * (a0 + s * (3.0 * c3 + s * (4.0 * c4 + s * 5.0 * c5)))
        trial.a[i] = (1.0 - s) * old.a[i] + s * a[i]
