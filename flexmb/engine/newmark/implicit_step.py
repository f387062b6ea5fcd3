"""Implicit step of the Newmark family: predictor, modified Newton iteration, convergence test.

A step runs through these functions in this order:

    start_iteration       predicted state; decision whether factors of an earlier step are reused
    evaluate_trial        residual; with the iteration matrix, or with the energies
    factor_matrix         factors of a new iteration matrix; redundant constraints
    residual_vectors      right side: minus the residual, gaps of the constraints
    solve_correction      correction of q, v, a, x, lam, and position shift
    apply_correction      corrected state; size of the correction over its tolerance
    after_reused_factors  convergence test and contraction rate with factors of an earlier matrix
    after_own_factors     convergence test with factors of the present matrix
"""

import math

from flexmb.engine.compiled.arrays import part_of
from flexmb.engine.compiled.records import copy_numbers
from flexmb.engine.linalg import lu as elimination
from flexmb.engine.newmark import jacobian_reuse, predictor
from flexmb.engine.state import record as codes
from flexmb.engine.system.evaluate import evaluate, evaluate_accepted
from flexmb.kernels import compiled, copy

# Correction of a Newton iteration: right-hand sides, solution, damping, size over the tolerance

ROUND_OFF = 1e-14  # correction relative to the coordinates, below which it is round-off
LEAST_CORRECTION = 1e-300  # least tolerance of a correction, for states of a control and motions that stay 0
# Correction of the state of a control relative to its size, below which it is round-off of its law.
STATE_ROUND_OFF = 1e-12
# Angle [rad] up to which round-off is that of 1 rad, so that the pose of a mechanism at the start does not count.
ANGLE_ALLOWANCE = 6.3
# Round-off of angles by that of places far from the origin, over these places in lengths of the mechanism.
FAR_ALLOWANCE = 0.1
GAP_ROUND_OFF = 0.1  # round-off of a gap relative to that of corrections
FORCE_ROUND_OFF = 10.0  # round-off of a correction by that of forces of stiff bodies, over that of the coordinates


@compiled
def residual_vectors(n, m, kv, options, trial, work):
    """Fill trial.rhs, the negative residual, and trial.gap_rhs, the gaps that the correction itself leaves open."""
    # The lower half of trial.rhs is G d of the correction d, so that gap_rhs = -g - G d.
    for i in range(n):
        trial.rhs[i], trial.gap_rhs[i] = -(work.r[i] + work.Gl[i]), 0.0
    for i in range(m):
        trial.rhs[n + i] = -work.g[i] if options.form == codes.POSITION else -work.gv[i] / kv
        trial.gap_rhs[n + i] = -work.g[i] - trial.rhs[n + i]


@compiled
def solve_correction(m, lu, values, options, trial):
    """Solve for trial.solution, the correction, and trial.shift, the position shift; values: factors."""
    if m > 0 and options.form == codes.GEAR_GUPTA_LEIMKUHLER:
        elimination.solve_two(lu, values, trial.rhs, trial.gap_rhs, trial.solution, trial.shift, trial.scratch_pair)
    else:
        elimination.solve(lu, values, trial.rhs, trial.solution, trial.scratch)


@compiled
def damping_factor(n, trial, work):
    """Set trial.newton.fraction, the applied fraction of the correction, and trial.newton.reach, its largest length."""
    # Where friction changes its sign, full corrections alternate between its branches for ever. A correction that turns
    # back shows that the solution lies within the one before it: from then on no correction is longer than half of the
    # last one, until full corrections stay within that bound. This is Newton's method safeguarded by bisection.
    newton = trial.newton
    if newton.factorisations < 3:
        newton.fraction, newton.reach = 1.0, math.inf
        return
    along, before, now, push = 0.0, 0.0, 0.0, 0.0
    for i in range(n):
        along += trial.solution[i] * trial.last_correction[i]
        before += trial.last_correction[i] * trial.last_correction[i]
        now += trial.solution[i] * trial.solution[i]
        push += trial.solution[i] * trial.rhs[i]
    falls = push < 0.0 and newton.reach < math.inf and jacobian_reuse.has_contact_or_friction(work.slopes)
    sign = -1.0 if falls else 1.0  # friction that falls within the step makes d.A d < 0: d leads away
    if sign * newton.fraction * along < 0.0:
        newton.reach = 0.5 * abs(newton.fraction) * math.sqrt(before)
    elif newton.fraction < 1.0:
        newton.reach *= 0.5
    now = math.sqrt(now)
    newton.fraction = sign if now <= newton.reach else sign * newton.reach / now


@compiled
def apply_correction(tables, h, kv, kx, ka, fraction, options, trial, record):
    """Add a fraction of the correction to the trial state; return its size over the tolerance."""
    # The size is the largest over all nodes, of displacements [m] and of rotations [rad], shift included. Tolerances
    # are `options.tolerance` times h^2 times the largest acceleration, plus the round-off of the coordinates.
    # Equation (4.10) of docs/theory/integrators.md.
    n, m, report = tables.sizes.n_q, tables.sizes.n_c, record.report
    way, turn, shift_x, shift_t, fast_x, fast_t, total = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    far_x, far_t = options.length**2, 1.0
    shifted = fraction if m > 0 and options.form == codes.GEAR_GUPTA_LEIMKUHLER else 0.0
    for i in range(0, tables.sizes.n_b, 3):  # x, y, theta of a node
        dx, sx = _correct_coordinate(i, fraction, shifted, kv, kx, ka, trial)
        dy, sy = _correct_coordinate(i + 1, fraction, shifted, kv, kx, ka, trial)
        dt, st = _correct_coordinate(i + 2, fraction, shifted, kv, kx, ka, trial)
        q, a = part_of(trial.q, i, i + 3), part_of(trial.a, i, i + 3)
        near, near_s = dx * dx + dy * dy, sx * sx + sy * sy
        total += near + near_s + abs(dt) + abs(st)
        way, turn, shift_x, shift_t = max(near, way), max(turn, abs(dt)), max(near_s, shift_x), max(shift_t, abs(st))
        fast_x, fast_t = max(a[0] * a[0] + a[1] * a[1], fast_x), max(fast_t, abs(a[2]))
        far_x, far_t = max(q[0] * q[0] + q[1] * q[1], far_x), max(far_t, abs(q[2]) - ANGLE_ALLOWANCE)
    moved_x, moved_t = math.sqrt(way) + math.sqrt(shift_x), turn + shift_t
    fast_x, far_x = math.sqrt(fast_x), math.sqrt(far_x)
    far_t, of_states = max(far_t, FAR_ALLOWANCE * far_x / options.length), 0.0
    if n > tables.sizes.n_b:
        of_states = correct_states(tables, h, kv, kx, ka, fraction, shifted, options, trial)
    if not math.isfinite(total + of_states):
        return math.inf
    for i in range(m):
        trial.lam[i] += fraction * trial.solution[n + i]
        trial.projected_gaps[i] += fraction * trial.gap_rhs[n + i]
    wanted_x = options.tolerance * min(h * h * fast_x, options.length) + ROUND_OFF * far_x
    wanted_t = options.tolerance * min(h * h * fast_t, 1.0) + ROUND_OFF * far_t
    report.length_tolerance, report.angle_tolerance = wanted_x, wanted_t
    if moved_x / wanted_x > moved_t / wanted_t:
        report.correction, report.tolerance, report.round_off = moved_x, wanted_x, ROUND_OFF * far_x / wanted_x
    else:
        report.correction, report.tolerance, report.round_off = moved_t, wanted_t, ROUND_OFF * far_t / wanted_t
    return max(moved_x / wanted_x, moved_t / wanted_t, of_states)


@compiled
def correct_states(tables, h, kv, kx, ka, fraction, shifted, options, trial):
    """Add a fraction of the correction to the states of controls; return its size over the tolerance."""
    # A correction d changes a state by kv d. Tolerances are those of coordinates: `options.tolerance` times h^2 times
    # the rate of the state, plus round-off of the state in a step.
    worst = 0.0
    for i in range(tables.sizes.n_b, tables.sizes.n_q):
        d, _ = _correct_coordinate(i, fraction, shifted, kv, kx, ka, trial)
        wanted = options.tolerance * h * h * abs(trial.a[i]) + h * STATE_ROUND_OFF * abs(trial.v[i])
        size = abs(d) / max(wanted, LEAST_CORRECTION)
        worst = max(worst, size) if math.isfinite(size) else math.inf
    return worst


@compiled
def _correct_coordinate(i, fraction, shifted, kv, kx, ka, trial):
    """Correct coordinate i and its derivatives by fractions of correction and shift; return both displacements."""
    d, shift = fraction * trial.solution[i], shifted * trial.shift[i] if shifted > 0.0 else 0.0
    trial.q[i] += d + shift
    trial.v[i] += kv * d
    trial.x[i] += kx * d
    trial.a[i] += ka * d
    trial.last_correction[i] = trial.solution[i]
    return d, shift


# Correction over its tolerance, up to which contact and friction are linear enough for reused factors.
# Larger ones gain nothing more, and leave errors of 1e-9 of an impact.
NONLINEAR_CORRECTION = 300.0
# Correction over its round-off, below which the correction is noise; and contraction rate above which noise stalls.
ROUND_OFF_FRACTION = 0.1
# Codes inside a step: further iteration; second evaluation, because held rows are not redundant.
CONTINUE, EVALUATE_AGAIN = -1, -2


@compiled
def implicit_step(tables, address, lu, h, ratio, scheme, options, flow, trial, work, record):
    """Try a step of size h; RUNNING if Newton's iteration converged, else the code of the failure."""
    # Unknowns are q1, v1, a1, x1, lam1 at the end of the step. Equations of motion and constraints hold there,
    #     r(t1, q1, v1, a1) + G^T lam1 = 0,   G v1 + g_t = 0,   g(t1, q1) = 0,
    # with the relations of Newmark and of generalised-alpha, with ratio = h / (last step) for x0,
    #     q1 = q0 + h v0 + h^2 ((1/2 - beta) x0 + beta x1) + e,   v1 = v0 + h ((1 - gamma) x0 + gamma x1),
    #     (1 - alpha_m) x1 + alpha_m x0 = (1 - alpha_f) a1 + alpha_f a0.
    # The position shift e = -S^-1 G^T mu closes the joints in positions and in velocities at once (Gear, Gupta,
    # Leimkuhler). A correction dq changes v1 by kv dq, x1 by kx dq, a1 by ka dq (`newmark_coefficients`), so that the
    # iteration matrix is
    #     A = [[S, G^T], [G, 0]],   S = K + H + kv C + ka M,   A [dq, dlam] = -[r + G^T lam, (G v + g_t)/kv].
    # The iteration is a modified Newton iteration: while factors of an earlier matrix are reused, residuals alone are
    # evaluated. The last expected evaluation includes the energies, so that the accepted state needs no further one.
    # record.count.evaluated says how much of the trial state is evaluated at the end.
    # Equations (4.1), (4.2), (4.7) and (4.9) of docs/theory/integrators.md.
    n, m = tables.sizes.n_q, tables.sizes.n_c
    t, newton, report = flow.clock.t + h, trial.newton, record.report
    kv, kx, ka = newmark_coefficients(h, scheme)
    start_iteration(tables, lu, h, ratio, kv, ka, scheme, options, flow, trial)
    for _ in range(options.iterations):
        with_energies = energies_wanted(tables, trial, work)
        evaluate_trial(tables, address, t, h, kv, ka, with_energies, flow, trial, work)
        record.count.evaluations += 1
        if newton.reusing and jacobian_reuse.slopes_changed(trial, work):
            stop_reuse(trial)
            continue
        residual_vectors(n, m, kv, options, trial, work)
        if not newton.reusing:
            code = factor_matrix(tables, lu, h, kv, ka, options, flow, trial, work, record)
            if code == EVALUATE_AGAIN:
                continue
            if code != codes.RUNNING:
                return code
        old_factors = newton.reusing and newton.factorisations == 0
        solve_correction(m, lu, flow.factors if old_factors else work.lu, options, trial)
        if not newton.reusing:
            damping_factor(tables.sizes.n_b, trial, work)
        length, angle = report.length_tolerance, report.angle_tolerance
        size = apply_correction(tables, h, kv, kx, ka, newton.fraction, options, trial, record) / abs(newton.fraction)
        same = 0.5 * length <= report.length_tolerance <= 2.0 * length
        if not (same and 0.5 * angle <= report.angle_tolerance <= 2.0 * angle):
            newton.last_size = math.inf  # sizes over different tolerances have no ratio
        record.count.iterations += 1
        record.count.solves += 1
        if newton.reusing:
            code = after_reused_factors(tables, h, ratio, size, with_energies, scheme, flow, trial, work, record)
        else:
            code = after_own_factors(tables, lu, h, ratio, size, scheme, options, flow, trial, work, record)
        if code != CONTINUE:
            return code
    return codes.NEWTON_FAILED


@compiled
def newmark_coefficients(h, scheme):
    """Derivatives kv, kx, ka of velocities, auxiliary and true accelerations by coordinates at the end of a step."""
    # kv = gamma/(beta h) [1/s],   kx = 1/(beta h^2) [1/s^2],   ka = (1 - alpha_m)/(1 - alpha_f) kx [1/s^2].
    # Equation (4.8) of docs/theory/integrators.md.
    kx = 1.0 / (scheme.beta * h * h)
    return scheme.gamma / (scheme.beta * h), kx, (1.0 - scheme.alpha_m) / (1.0 - scheme.alpha_f) * kx


@compiled
def start_iteration(tables, lu, h, ratio, kv, ka, scheme, options, flow, trial):
    """Predict the trial state, and decide whether the factors of an earlier step are reused."""
    n, m, newton, reuse = tables.sizes.n_q, tables.sizes.n_c, trial.newton, trial.reuse
    # The states of predictor and reuse are copied into the trial, so that a rejected step changes nothing.
    copy_numbers(flow.predictor, trial.predictor)
    copy_numbers(flow.reuse, reuse)
    reuse.refactored = 0.0
    for k in range(trial.slopes.shape[0]):
        copy(flow.slopes[k], trial.slopes[k])
    if flow.clock.last_step == 0.0:
        jacobian_reuse.discard_factors(reuse)
        predictor.restart_predictor(trial.predictor)
    newton.order = trial.predictor.order
    newton.measuring = reuse.steps_since_measured >= jacobian_reuse.MEASURING_INTERVAL
    own = jacobian_reuse.takes_own_matrices(n + m, trial.slopes)
    newton.reusing = jacobian_reuse.may_reuse(kv, ka, flow, reuse) and not own
    newton.may_reuse, newton.factorisations, newton.reused, newton.held = True, 0, 0, -1
    newton.last_size, newton.fraction, newton.reach = math.inf, 1.0, math.inf
    newton.hold = jacobian_reuse.initial_hold(flow)
    predictor.predict(n, m, h, ratio, newton.order, scheme, flow, trial)
    if predictor.leaps(tables.sizes.n_b, h, options, flow, trial):
        newton.order = predictor.COASTING
        predictor.predict_without_accelerations(n, m, h, ratio, predictor.COASTING, scheme, flow, trial)
        if predictor.leaps(tables.sizes.n_b, 0.0, options, flow, trial):
            newton.order = predictor.STANDING
            predictor.predict_without_accelerations(n, m, h, ratio, predictor.STANDING, scheme, flow, trial)
    if newton.reusing and m > 0 and newton.order > 0 and options.form == codes.GEAR_GUPTA_LEIMKUHLER:
        predictor.project_prediction(n, m, lu, h, newton.order, flow, trial)


@compiled
def energies_wanted(tables, trial, work):
    """Whether the next evaluation includes the energies, since its iteration is expected to be the last one."""
    newton, reuse = trial.newton, trial.reuse
    expected = reuse.expected_last + (1.0 if newton.measuring else 0.0)
    if newton.factorisations > 0:
        expected = reuse.expected_last_fresh
    return newton.reusing and newton.reused >= expected and not jacobian_reuse.has_contact_alone(tables, work)


@compiled
def evaluate_trial(tables, address, t, h, kv, ka, with_energies, flow, trial, work):
    """Evaluate the trial state: with energies, or with the iteration matrix unless factors are reused."""
    q, v, a, lam = trial.q, trial.v, trial.a, trial.lam
    if with_energies:
        predictor.find_newmark_residual(tables.sizes.n_q, h, flow, trial)
        evaluate_accepted(tables, address, t, h, q, v, a, lam, flow.z, trial.mean_v, trial.newmark_residual, work)
    else:
        evaluate(tables, address, t, h, q, v, a, lam, flow.z, 1.0, kv, ka, not trial.newton.reusing, work)


@compiled
def factor_matrix(tables, lu, h, kv, ka, options, flow, trial, work, record):
    """Factor the matrix of the last evaluation; RUNNING, EVALUATE_AGAIN, or the code of a failure."""
    # EVALUATE_AGAIN : held rows are not redundant, since their joints would open; the matrix must be evaluated and
    # factored again with fewer held rows.
    n, newton = tables.sizes.n_q, trial.newton
    jacobian_reuse.discard_factors(trial.reuse)
    # At first all rows that look redundant are held, so that multipliers stay calm while a singular position is passed.
    if newton.hold == elimination.LOST_PIVOT:
        newton.held = jacobian_reuse.factor_without_redundant(lu, work.lu, newton.hold, n, trial)
    else:
        newton.held = elimination.factor(lu, work.lu, trial.pivot_scale, elimination.LOST_PIVOT, n, newton.hold)
    record.count.factorisations += 1
    if newton.held >= 0:
        record.count.lost_pivot = newton.held
        return codes.SINGULAR if math.isfinite(trial.rhs.sum()) else codes.NOT_FINITE
    redundant = trial.left_out.shape[0] if newton.hold != elimination.LOST_PIVOT else 0
    if redundant > 0 and jacobian_reuse.number_of_held(trial) < redundant:
        newton.hold = elimination.LOST_PIVOT
        return EVALUATE_AGAIN
    if newton.held == elimination.ROWS_HELD and held_rows_open(tables, lu, h, options, flow, trial, work):
        if newton.hold == elimination.LOST_PIVOT:  # the rows contradict the others
            record.count.lost_pivot = elimination.first_held_row(lu, trial.pivot_scale)
            return codes.SINGULAR
        newton.hold = elimination.LOST_PIVOT
        return EVALUATE_AGAIN
    if newton.held == elimination.ROWS_HELD and newton.hold == elimination.HELD_PIVOT:
        newton.hold = jacobian_reuse.HOLD_WITHIN_STEP  # though corrections may lead away from the singular position
    elif newton.held != elimination.ROWS_HELD and newton.hold == elimination.HELD_PIVOT:
        pivot = elimination.smallest_pivot(lu, work.lu, trial.pivot_scale, n) if tables.sizes.n_c > 0 else 1.0
        pivot *= max(1.0, jacobian_reuse.REGULAR_PIVOT * tables.sizes.n_c)  # some 2/n of a straight chain of n links
        reuse = trial.reuse  # of the factors in work.lu
        reuse.refactored, reuse.age, reuse.kv, reuse.ka, reuse.smallest_pivot = 1.0, 1.0, kv, ka, pivot
        reuse.extra_iterations, reuse.best_iterations = 0.0, 0.0
        for k in range(trial.slopes.shape[0]):
            copy(work.slopes[k], trial.slopes[k])
    newton.factorisations += 1
    newton.reused = 0
    return codes.RUNNING


@compiled
def held_rows_open(tables, lu, h, options, flow, trial, work):
    """Whether the correction would leave too large a gap in held rows."""
    left = elimination.held_residual(lu, work.lu, trial.pivot_scale, trial.rhs, trial.scratch)
    if options.form == codes.GEAR_GUPTA_LEIMKUHLER:
        trial.shift[:] = 0.0
        for i in range(tables.sizes.n_c):
            trial.shift[tables.sizes.n_q + i] = -work.g[i]
        left = max(left, elimination.held_residual(lu, work.lu, trial.pivot_scale, trial.shift, trial.scratch))
    redundant = trial.newton.hold == elimination.LOST_PIVOT and trial.left_out.shape[0] > 0
    return left > jacobian_reuse.allowed_gap(tables, h, options, flow, trial.a, redundant)


@compiled
def stop_reuse(trial):
    """Let the next iteration factor its own matrix; without reuse in the next steps if old factors failed."""
    newton, reuse = trial.newton, trial.reuse
    newton.reusing, newton.may_reuse = False, newton.factorisations == 0
    if newton.factorisations == 0:  # factors of an earlier step failed: longer after each failure
        reuse.last_suspension = min(2.0 * reuse.last_suspension + 1.0, jacobian_reuse.LONGEST_SUSPENSION)
        reuse.suspended_steps = reuse.last_suspension


@compiled
def restart_iteration(tables, h, ratio, order, scheme, flow, trial):
    """Predict the trial state again: with constant accelerations (order 0), or without any."""
    trial.newton.order, trial.newton.last_size = order, math.inf
    n, m = tables.sizes.n_q, tables.sizes.n_c
    if order == 0:
        predictor.predict(n, m, h, ratio, 0, scheme, flow, trial)
    else:
        predictor.predict_without_accelerations(n, m, h, ratio, order, scheme, flow, trial)


@compiled
def after_reused_factors(tables, h, ratio, size, with_energies, scheme, flow, trial, work, record):
    """Convergence test of a correction with reused factors; RUNNING or CONTINUE.  `size`: over the tolerance."""
    newton, reuse, noise = trial.newton, trial.reuse, ROUND_OFF_FRACTION * record.report.round_off
    negligible, remaining = jacobian_reuse.convergence_limits(noise, work)
    own = newton.factorisations > 0 and not jacobian_reuse.has_contact_or_friction(work.slopes)
    converged, evaluated, contracting = jacobian_reuse.convergence_test(
        size, newton.last_size, negligible, remaining, noise, own, reuse
    )
    if newton.factorisations == 0 and newton.reused == 0:
        reuse.first_correction = size
    if converged:
        jacobian_reuse.update_reuse(newton.factorisations, newton.reused, evaluated, newton.measuring, reuse)
        record.count.held_code = 0
        record.count.evaluated = evaluation_code(tables, with_energies and evaluated, size, work)
        return codes.RUNNING
    diverging = not size < newton.last_size
    newton.reused += 1
    newton.last_size = size
    if not contracting or newton.reused >= jacobian_reuse.MOST_REUSE_ITERATIONS:
        stop_reuse(trial)
        if diverging:
            restart_iteration(tables, h, ratio, min(newton.order, 0), scheme, flow, trial)
    return CONTINUE


@compiled
def after_own_factors(tables, lu, h, ratio, size, scheme, options, flow, trial, work, record):
    """Convergence test of a correction with the present matrix; RUNNING, CONTINUE, or the code of a failure."""
    # Converged: a small first correction; a full correction within the tolerance; one whose successors, by the ratio of
    # the last two, add up to less than the tolerance; or one that is round-off.
    n, m, newton, reuse = tables.sizes.n_q, tables.sizes.n_c, trial.newton, trial.reuse
    last, number = newton.last_size, newton.factorisations
    negligible, _ = jacobian_reuse.convergence_limits(ROUND_OFF_FRACTION * record.report.round_off, work)
    converged = size <= (1.0 if number > 1 else negligible)
    if newton.fraction == 1.0 and number > 1 and size < last < math.inf:
        converged = converged or size * size / (last - size) <= 1.0
    if not converged and number > 2 and size > ROUND_OFF_FRACTION * last:
        # A correction that stalls may be round-off of forces, or of gaps over the angle between constraint rows.
        report, angle = record.report, 1.0
        if m > 0:
            angle = math.sqrt(elimination.smallest_pivot(lu, work.lu, trial.pivot_scale, n))
        allowed = max(1.0 + GAP_ROUND_OFF * report.round_off / angle, FORCE_ROUND_OFF * report.round_off)
        # A shortened correction ends no iteration where friction may fall, but fixed steps have no shorter ones to try.
        whole = size if options.adaptive and jacobian_reuse.has_contact_or_friction(work.slopes) else 0.0
        converged = report.correction <= report.tolerance * allowed and whole <= max(allowed, NONLINEAR_CORRECTION)
    if converged:
        held, strict = newton.held == elimination.ROWS_HELD, newton.hold == elimination.LOST_PIVOT
        record.count.held_code = jacobian_reuse.held_code(held, strict, flow)
        record.count.evaluated = evaluation_code(tables, False, size, work)
        return codes.RUNNING
    newton.last_size = size
    if not math.isfinite(size) or (newton.reach == math.inf and number > 4 and size > 2.0 * last):
        if newton.order == predictor.STANDING or (options.adaptive and newton.order <= 0):
            return codes.NEWTON_FAILED if math.isfinite(size) else codes.NOT_FINITE
        newton.factorisations, newton.fraction = 0, 1.0
        restart_iteration(tables, h, ratio, min(newton.order - 1, 0), scheme, flow, trial)
    undamped = newton.fraction == 1.0 and newton.reach == math.inf and newton.last_size < math.inf
    nonlinear = newton.last_size > NONLINEAR_CORRECTION and jacobian_reuse.takes_own_matrices(n + m, work.slopes)
    fresh = reuse.age == 1.0 and reuse.smallest_pivot >= jacobian_reuse.REGULAR_PIVOT
    newton.reusing = newton.may_reuse and undamped and fresh and not nonlinear
    return CONTINUE


@compiled
def evaluation_code(tables, evaluated, size, work):
    """Code of the evaluation of the converged state; `size`: last correction over its tolerance."""
    # A correction within the tolerance, a millionth of h^2 a, moves G by no more than that. With closed contacts,
    # forces of contacts and energies are then evaluated once more, and constraints are not.
    if evaluated:
        return codes.EVALUATED
    alone = size <= 1.0 and jacobian_reuse.has_contact_alone(tables, work)
    return codes.JOINTS_EVALUATED if alone else codes.NOT_EVALUATED
