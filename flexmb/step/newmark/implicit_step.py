"""One implicit step: predictor, Newton iterations on positions, velocities and multipliers together."""

import math

from flexmb.kernels import compiled, part_of
from flexmb.linalg.lu import HELD, HOLD, THRESHOLD, factor, first_held, left_over, solve, weakest
from flexmb.linalg.substitute import solve_two
from flexmb.state.options import GEAR_GUPTA_LEIMKUHLER, POSITION
from flexmb.state.record import ALL_KNOWN, JOINTS_KNOWN, NEWTON_FAILED, NOT_FINITE, NOTHING_KNOWN, RUNNING, SINGULAR
from flexmb.step.newmark.jacobian_reuse import (
    MEASURE_AGAIN,
    STALE_ITERATIONS,
    begin_trial,
    bounds,
    forget_factors,
    judged,
    may_check,
    may_serve,
    note_factors,
    refused,
    rubbing,
    served,
    slopes_changed,
    touching,
)
from flexmb.step.newmark.predictor import close_ahead, compare, forget_past, predict
from flexmb.step.newmark.redundant_constraints import STILL, first_hold, free_gap, outcome
from flexmb.system.evaluate import evaluate, evaluate_accepted

ROUND_OFF = 1e-14
"""Corrections below this part of the coordinates are round-off."""

CHEAP = 60
"""Unknowns up to which a matrix and its factors cost little more than a residual: where forces of contact or friction
bend within a step, each iteration then has its own."""

BENDS = 300.0
"""Size of a correction, relative to what is wanted, up to which such forces are straight enough for its factors to
serve the next one.  Larger ones gain nothing more, and leave errors of 1e-9 of an impact."""

FIRST_TURN = 6.3
"""Angles up to here have round-off like that of 1 rad: how a mechanism is turned at the start should not count."""

OF_GAPS = 0.1
"""Round-off of a gap relative to that of corrections."""

AGAIN = -1
"""What `new_factors` returns when rows must not be held."""


@compiled
def lead(n, options, flow, trial):
    """The auxiliary acceleration at the end of the first step."""
    for i in range(n):
        trial.x[i] = trial.a[i] + (options.regular.alpha_m - options.regular.alpha_f) * (trial.a[i] - flow.a[i])


@compiled
def implicit_step(tables, address, lu, h, ratio, scheme, options, flow, trial, work, record):  # noqa: PLR0912, PLR0915 - one loop
    """Try a step of size h; RUNNING when it converged, else the code of the failure.

    Solved for q1, v1, a1, x1 and lam1, with Newmark's relations

        q1 = q0 + h v0 + h^2 ((1/2 - beta) x0 + beta x1) + e,   v1 = v0 + h ((1 - gamma) x0 + gamma x1),
        (1 - alpha_m) x1 + alpha_m x0 = (1 - alpha_f) a1 + alpha_f a0,

    are the equations of motion, the joints in velocities and, by the shift e = -S^-1 G^T mu, in positions:

        r(q1, v1, a1, t1) + G^T lam1 = 0,   G v1 + g_t = 0,   g(q1, t1) = 0.

    A correction dq changes v1 by kv dq, kv = gamma/(beta h); x1 by kx dq, kx = 1/(beta h^2); and a1 by ka dq,
    ka = (1 - alpha_m)/(1 - alpha_f) kx.  Newton's matrix is S = [[K + H + kv C + ka M, G^T], [G, 0]].

    While old factors serve, the residual is all that is evaluated, and where the iteration is expected to end it is
    evaluated together with the energies: if the correction then is small enough that state is the accepted one.
    Otherwise each iteration has its own matrix, and its factors then try to serve a last iteration as old ones.
    record.count.known says what is known of the state it ends with.
    """
    n, m = tables.sizes.n_q, tables.sizes.n_c
    t, reuse = flow.clock.t + h, trial.reuse
    kv = scheme.gamma / (scheme.beta * h)
    kx = 1.0 / (scheme.beta * h * h)
    ka = (1.0 - scheme.alpha_m) / (1.0 - scheme.alpha_f) * kx
    begin_trial(flow, trial)
    if flow.clock.last == 0.0:
        forget_past(trial.prediction)
    cheap = n + m <= CHEAP
    order, turn = trial.prediction.order, reuse.since >= MEASURE_AGAIN
    old = may_serve(kv, ka, flow, reuse) and not (cheap and rubbing(trial.slopes))
    predict(n, m, h, ratio, order, scheme, flow, trial)
    if old and m > 0 and order > 0 and options.form == GEAR_GUPTA_LEIMKUHLER:
        close_ahead(n, m, lu, h, order, flow, trial)
    last, same, part, reach, hold, lost = math.inf, math.inf, 1.0, math.inf, first_hold(flow), -1
    fresh, stale, checks, wanted_x, wanted_t = 0, 0, True, 0.0, 0.0
    for _ in range(options.iterations):
        accounted = old and stale >= (reuse.check if fresh > 0 else reuse.expected + (1.0 if turn else 0.0))
        accounted = accounted and not touching(tables, work)
        look(tables, address, t, h, kv, ka, old, accounted, flow, trial, work)
        record.count.evaluations += 1
        if old and slopes_changed(trial, work):
            old, checks = False, fresh == 0
            refused(fresh, reuse)
            continue
        right_sides(n, m, kv, options, trial, work)
        if not old:
            code, lost, hold = new_factors(tables, lu, h, kv, ka, hold, options, flow, trial, work, record)
            if code == AGAIN:
                continue
            if code != RUNNING:
                return code
            fresh, stale = fresh + 1, 0
        correction(m, lu, flow.factors if old and fresh == 0 else work.lu, options, trial)
        if not old:
            part, reach = shortened(n, fresh - 1, part, reach, trial)
        size = correct(tables, h, kv, kx, ka, part, options, trial, record) / part
        if not (alike(wanted_x, record.step.wanted_length) and alike(wanted_t, record.step.wanted_angle)):
            last = same = math.inf  # two sizes with different measures say no ratio
        wanted_x, wanted_t = record.step.wanted_length, record.step.wanted_angle
        record.count.iterations += 1
        record.count.solves += 1
        noise = 0.1 * record.step.round_off
        unseen, left = bounds(noise, work)
        if old:
            done, seen, good = judged(size, same, unseen, left, noise, reuse)
            if fresh == 0 and stale == 0:
                reuse.first = size
            if done:
                served(fresh, stale, seen, turn, reuse)
                record.count.outcome, record.count.known = 0, known(tables, accounted and seen, size, work)
                return RUNNING
            stale += 1
            if not good or stale >= STALE_ITERATIONS:
                old, checks = False, fresh == 0
                refused(fresh, reuse)
                if not size < last:  # they led away
                    order, size = 0, math.inf
                    predict(n, m, h, ratio, order, scheme, flow, trial)
            last = same = size
            continue
        small = size <= (1.0 if fresh > 1 else unseen)
        small = small or (part == 1.0 and fresh > 1 and size < last < math.inf and size * size / (last - size) <= 1.0)
        if small or (fresh > 2 and size > 0.1 * last and only_noise(n, m, lu, trial, work, record)):
            record.count.outcome = outcome(lost == HELD, hold == THRESHOLD, flow)
            record.count.known = known(tables, False, size, work)
            return RUNNING
        if not math.isfinite(size) or (reach == math.inf and fresh > 4 and size > 2.0 * last):
            if order == 0:
                return NEWTON_FAILED if math.isfinite(size) else NOT_FINITE
            order, fresh, part, size = 0, 0, 1.0, math.inf  # the prediction may have been too bold
            predict(n, m, h, ratio, order, scheme, flow, trial)
        last = same = size
        old = checks and part == 1.0 and reach == math.inf and size < math.inf and may_check(reuse)
        old = old and not (cheap and size > BENDS and rubbing(work.slopes))
    return NEWTON_FAILED


@compiled
def known(tables, seen, size, work):
    """What is known of the state that a step ends with: all of it, or what its joints are made of, or nothing.

    size : of the last correction.  What is wanted of corrections is a millionth of the way h^2 a, and G moves by no
    more; where contacts are closed they and the energies alone are asked for again.
    """
    if seen:
        return ALL_KNOWN
    return JOINTS_KNOWN if size <= 1.0 and touching(tables, work) else NOTHING_KNOWN


@compiled
def alike(before, now):
    """Whether two numbers differ by less than a factor of 2."""
    return 0.5 * before <= now <= 2.0 * before


@compiled
def look(tables, address, t, h, kv, ka, old, accounted, flow, trial, work):
    """Evaluate the trial state: with energies if it is `accounted` for, else with a matrix unless factors are `old`."""
    if accounted:
        compare(tables.sizes.n_q, h, flow, trial)
        evaluate_accepted(
            tables, address, t, h, trial.q, trial.v, trial.a, trial.lam, flow.z, trial.mean_v, trial.lag, work
        )
    else:
        evaluate(tables, address, t, h, trial.q, trial.v, trial.a, trial.lam, flow.z, 1.0, kv, ka, not old, work)


@compiled
def new_factors(tables, lu, h, kv, ka, hold, options, flow, trial, work, record):
    """Factor the matrix of the last evaluation: a code, what `factor` said, and with what it may hold rows from now.

    AGAIN : held rows say something of their own, so the matrix is to be evaluated and factored again.
    """
    n = tables.sizes.n_q
    forget_factors(trial.reuse)
    lost = factor(lu, work.lu, trial.seen, THRESHOLD, n, hold)
    record.count.factorisations += 1
    if lost >= 0:
        record.count.lost = lost
        return (SINGULAR if math.isfinite(trial.b.sum()) else NOT_FINITE), lost, hold
    if lost == HELD and opens(tables, lu, h, options, flow, trial, work):
        if hold == THRESHOLD:  # they contradict the others
            record.count.lost = first_held(lu, trial.seen)
            return SINGULAR, lost, hold
        return AGAIN, lost, THRESHOLD
    if lost == HELD and hold == HOLD:
        return (
            RUNNING,
            lost,
            STILL,
        )  # until the step ends, though the correction may lead away from the singular position
    if lost != HELD and hold == HOLD:
        weak = weakest(lu, work.lu, trial.seen, n) if tables.sizes.n_c > 0 else 1.0
        note_factors(kv, ka, weak, trial, work)
    return RUNNING, lost, hold


@compiled
def right_sides(n, m, kv, options, trial, work):
    """trial.b: the residual; trial.c: what closes the joints beside that, since G d is the lower half of trial.b."""
    for i in range(n):
        trial.b[i] = -(work.r[i] + work.Gl[i])
        trial.c[i] = 0.0
    for i in range(m):
        trial.b[n + i] = -work.g[i] if options.form == POSITION else -work.gv[i] / kv
        trial.c[n + i] = -work.g[i] - trial.b[n + i]


@compiled
def correction(m, lu, values, options, trial):
    """trial.d: the correction; trial.e: the shift of positions that closes the joints."""
    if m > 0 and options.form == GEAR_GUPTA_LEIMKUHLER:
        solve_two(lu, values, trial.b, trial.c, trial.d, trial.e, trial.pair)
    else:
        solve(lu, values, trial.b, trial.d, trial.y)


@compiled
def opens(tables, lu, h, options, flow, trial, work):
    """Whether the correction would leave a gap in rows that are held."""
    n = tables.sizes.n_q
    left = left_over(lu, work.lu, trial.seen, trial.b, trial.y)
    if options.form == GEAR_GUPTA_LEIMKUHLER:
        trial.e[:] = 0.0
        for i in range(tables.sizes.n_c):
            trial.e[n + i] = -work.g[i]
        left = max(left, left_over(lu, work.lu, trial.seen, trial.e, trial.y))
    return left > free_gap(tables, h, options, flow, trial.a)


@compiled
def only_noise(n, m, lu, trial, work, record):
    """Whether a correction that does not get smaller is round-off of the gaps, divided by the angle of two rows."""
    angle = math.sqrt(weakest(lu, work.lu, trial.seen, n)) if m > 0 else 1.0
    return record.step.correction <= record.step.wanted * (1.0 + OF_GAPS * record.step.round_off / angle)


@compiled
def shortened(n, iteration, part, reach, trial):
    """Part of the correction in trial.d, and how far it may reach: no limit until corrections turn back.

    Where friction changes its sign, full steps jump to and fro between its branches for ever.  A correction that turns
    back shows that the solution lies within the step before it: from then on no step is longer than half of the last
    one, until full corrections stay within that bound.  This is Newton's method safeguarded by halving of an interval.
    """
    if iteration < 2:
        return 1.0, math.inf
    along, before, now = 0.0, 0.0, 0.0
    for i in range(n):
        along += trial.d[i] * trial.before[i]
        before += trial.before[i] * trial.before[i]
        now += trial.d[i] * trial.d[i]
    if along < 0.0:
        reach = 0.5 * part * math.sqrt(before)
    elif part < 1.0:
        reach *= 0.5
    now = math.sqrt(now)
    return (1.0 if now <= reach else reach / now), reach


@compiled
def _move(i, part, shifted, kv, kx, ka, trial):
    """Correct coordinate i and its derivatives by parts of the correction and of the shift; both moves."""
    d, shift = part * trial.d[i], shifted * trial.e[i] if shifted > 0.0 else 0.0
    trial.q[i] += d + shift
    trial.v[i] += kv * d
    trial.x[i] += kx * d
    trial.a[i] += ka * d
    trial.before[i] = trial.d[i]
    return d, shift


@compiled
def correct(tables, h, kv, kx, ka, part, options, trial, record):
    """Add `part` of the correction; its size relative to what is wanted, the largest of ways and angles of nodes."""
    n, m = tables.sizes.n_q, tables.sizes.n_c
    way, turn, shift_x, shift_t, fast_x, fast_t, total = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    far_x, far_t = options.length**2, 1.0
    shifted = part if m > 0 and options.form == GEAR_GUPTA_LEIMKUHLER else 0.0
    for i in range(0, n, 3):  # x, y, theta of a node
        dx, sx = _move(i, part, shifted, kv, kx, ka, trial)
        dy, sy = _move(i + 1, part, shifted, kv, kx, ka, trial)
        dt, st = _move(i + 2, part, shifted, kv, kx, ka, trial)
        q, a = part_of(trial.q, i, i + 3), part_of(trial.a, i, i + 3)
        near, near_s = dx * dx + dy * dy, sx * sx + sy * sy
        total += near + near_s + abs(dt) + abs(st)
        way, turn, shift_x, shift_t = max(near, way), max(turn, abs(dt)), max(near_s, shift_x), max(shift_t, abs(st))
        fast_x, fast_t = max(a[0] * a[0] + a[1] * a[1], fast_x), max(fast_t, abs(a[2]))
        far_x, far_t = max(q[0] * q[0] + q[1] * q[1], far_x), max(far_t, abs(q[2]) - FIRST_TURN)
    moved_x, moved_t = math.sqrt(way) + math.sqrt(shift_x), turn + shift_t
    fast_x, far_x = math.sqrt(fast_x), math.sqrt(far_x)
    if not math.isfinite(total):
        return math.inf
    for i in range(m):
        trial.lam[i] += part * trial.d[n + i]
        trial.gaps[i] += part * trial.c[n + i]
    wanted_x = options.tolerance * h * h * fast_x + ROUND_OFF * far_x
    wanted_t = options.tolerance * h * h * fast_t + ROUND_OFF * far_t
    record.step.wanted_length, record.step.wanted_angle = wanted_x, wanted_t
    if moved_x / wanted_x > moved_t / wanted_t:
        record.step.correction, record.step.wanted, record.step.round_off = (
            moved_x,
            wanted_x,
            ROUND_OFF * far_x / wanted_x,
        )
    else:
        record.step.correction, record.step.wanted, record.step.round_off = (
            moved_t,
            wanted_t,
            ROUND_OFF * far_t / wanted_t,
        )
    return max(moved_x / wanted_x, moved_t / wanted_t)
