"""One implicit step: predictor, Newton iterations on positions, velocities and multipliers together."""

import math

from flexmb.integrate.arrays import (
    GEAR_GUPTA_LEIMKUHLER,
    NEWTON_FAILED,
    NOT_FINITE,
    POSITION,
    RUNNING,
    SINGULAR,
    Options,
)
from flexmb.integrate.held import STILL, first_hold, free_gap, outcome
from flexmb.integrate.predict import ORDER, compare, forget_past, predict
from flexmb.integrate.reuse import (
    AGE,
    CHECK,
    EXPECTED,
    FAIR,
    FIRST,
    LEFT,
    MEASURE_AGAIN,
    REGULAR,
    RUBBING,
    SINCE,
    STALE_ITERATIONS,
    THETA,
    UNSEEN,
    WEAK,
    believed,
    forget_factors,
    may_serve,
    measured,
    note_factors,
    rubbing,
    served,
    slopes_changed,
)
from flexmb.kernels import compiled
from flexmb.solve.lu import HELD, HOLD, THRESHOLD, factor, first_held, left_over, solve, weakest
from flexmb.solve.substitute import solve_two
from flexmb.system.evaluate import evaluate, evaluate_accepted

ROUND_OFF = 1e-14
"""Corrections below this part of the coordinates are round-off."""

EPSILON = 1e-15
"""Round-off of a gap relative to the largest coordinate."""


@compiled
def starting(options):
    """Numbers of the first step.

    x stands for the acceleration at a time Delta h later, Delta = alpha_m - alpha_f.  With x0 = a0 the multipliers
    would begin with an error of first order.  x0 = a0 + Delta (a1 - a0) turns the method into a plain Newmark step with
    gamma = 1/2, beta = (1 + Delta^2)/4, whatever its own numbers; after it `lead` sets x.
    """
    o, delta = options, options.alpha_m - options.alpha_f
    return Options(
        0.0,
        0.0,
        0.25 * (1.0 + delta * delta),
        0.5,
        o.form,
        o.tolerance,
        o.iterations,
        o.length,
        o.adaptive,
        o.error,
        o.h_min,
        o.h_max,
        o.t_end,
        o.save_interval,
    )


@compiled
def lead(n, options, flow, trial):
    """The auxiliary acceleration at the end of the first step."""
    for i in range(n):
        trial.x[i] = trial.a[i] + (options.alpha_m - options.alpha_f) * (trial.a[i] - flow.a[i])


@compiled
def implicit_step(tables, address, lu, h, ratio, options, flow, trial, work, record):
    """Try a step of size h; RUNNING when it converged, else the code of the failure.

    While old factors serve, the residual is all that is evaluated, and where the iteration is expected to end it is
    evaluated together with the energies: if the correction then is small enough that state is the accepted one.
    Otherwise each iteration has its own matrix, and its factors then try to serve a last iteration as old ones.
    record.count[9] says whether the energies have been evaluated.
    """
    n, m = tables.sizes.n_q, tables.sizes.n_c
    t, habits = flow.clock[0] + h, flow.habits
    kv = options.gamma / (options.beta * h)
    kx = 1.0 / (options.beta * h * h)
    ka = (1.0 - options.alpha_m) / (1.0 - options.alpha_f) * kx
    if flow.clock[4] == 0.0:
        forget_past(habits)
        forget_factors(habits)
    order = int(habits[ORDER])
    predict(n, m, h, ratio, order, options, flow, trial)
    old, checks, turn = may_serve(kv, ka, flow), True, habits[SINCE] >= MEASURE_AGAIN
    last, same, part, reach, hold = math.inf, math.inf, 1.0, math.inf, first_hold(flow)
    fresh, stale, begun = 0, 0, 0
    for iteration in range(options.iterations):
        if fresh == 0:
            accounted = old and iteration >= habits[EXPECTED] + (1.0 if turn else 0.0)
        else:
            accounted = old and stale >= habits[CHECK]
        if accounted:
            compare(n, h, flow, trial)
            evaluate_accepted(
                tables, address, t, h, trial.q, trial.v, trial.a, trial.lam, flow.z, trial.mean_v, trial.lag, work
            )
        else:
            evaluate(tables, address, t, h, trial.q, trial.v, trial.a, trial.lam, flow.z, 1.0, kv, ka, not old, work)
        record.count[3] += 1
        if old and slopes_changed(flow, work):
            old, checks = False, False
            continue
        right_sides(n, m, kv, options, trial, work)
        if not old:
            forget_factors(habits)
            lost = factor(lu, work.lu, trial.seen, THRESHOLD, n, hold)
            record.count[4] += 1
            if lost >= 0:
                record.count[6] = lost
                return SINGULAR if math.isfinite(trial.b.sum()) else NOT_FINITE
            if lost == HELD and opens(tables, lu, h, options, flow, trial, work):
                if hold == THRESHOLD:  # they contradict the others
                    record.count[6] = first_held(lu, trial.seen)
                    return SINGULAR
                hold = THRESHOLD  # they say something of their own
                continue
            if lost == HELD and hold == HOLD:
                hold = STILL  # until the step ends, though the correction may lead away from the singular position
            if lost != HELD and hold == HOLD:
                note_factors(kv, ka, weakest(lu, work.lu, trial.seen, n) if m > 0 else 1.0, flow, work)
            fresh, stale = fresh + 1, 0
        correction(m, lu, options, trial, work)
        record.count[10] += 1
        if not old:
            part, reach = shortened(n, fresh - 1, part, reach, trial)
        size = correct(tables, h, kv, kx, ka, part, options, trial, record) / part
        record.count[2] += 1
        least, unseen = 0.1 * record.extreme[7], RUBBING if rubbing(work) else UNSEEN
        left, unseen = max(min(LEFT, unseen), least), max(unseen, least)
        if old:
            theta = measured(size, same, habits) if same < math.inf else habits[THETA]
            seen = size <= unseen
            done = seen if same < math.inf else seen and believed(size, habits)
            done = done or (same < math.inf and theta <= FAIR and size * theta <= left * (1.0 - theta))
            if iteration == 0:
                habits[FIRST] = size
            if done:
                if fresh == 0:
                    served(iteration + 1, seen, turn, habits)
                else:
                    habits[CHECK] = float(stale if seen else stale + 1)
                record.count[8], record.count[9] = 0, 1 if accounted and seen else 0
                return RUNNING
            stale += 1
            if not (size < math.inf and (same == math.inf or (theta <= FAIR and size * theta**3 <= left))):
                old = False
            if stale >= STALE_ITERATIONS:
                old = False
            if not old:
                checks = False
                if not size < last:
                    order = 0
                    predict(n, m, h, ratio, order, options, flow, trial)
                    size = math.inf
            last = same = size
            continue
        if not math.isfinite(size):
            if order == 0:
                return NOT_FINITE
            begun = 1
        small = size <= (1.0 if fresh > 1 else unseen) or (
            part == 1.0 and fresh > 1 and size < last and size * size / (last - size) <= 1.0
        )
        if small or (fresh > 2 and size > 0.1 * last and only_noise(n, m, lu, trial, work, record)):
            record.count[8] = outcome(lost == HELD, hold == THRESHOLD, flow)
            record.count[9] = 0
            return RUNNING
        if reach == math.inf and fresh > 4 and size > 2.0 * last:
            if order == 0:
                return NEWTON_FAILED
            begun = 1
        if begun == 1:
            order, fresh, part, begun = 0, 0, 1.0, 0
            predict(n, m, h, ratio, order, options, flow, trial)
            size = math.inf
        last = same = size
        old = (
            checks
            and part == 1.0
            and reach == math.inf
            and habits[AGE] == 1.0
            and habits[WEAK] >= REGULAR
            and size < math.inf
        )
    return NEWTON_FAILED


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
def correction(m, lu, options, trial, work):
    """trial.d: the correction; trial.e: the shift of positions that closes the joints."""
    if m > 0 and options.form == GEAR_GUPTA_LEIMKUHLER:
        solve_two(lu, work.lu, trial.b, trial.c, trial.d, trial.e, trial.pair)
    else:
        solve(lu, work.lu, trial.b, trial.d, trial.y)


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
    far = 1.0
    for i in range(n):
        far = max(far, abs(trial.q[i]))
    angle = math.sqrt(weakest(lu, work.lu, trial.seen, n)) if m > 0 else 1.0
    return record.extreme[2] <= record.extreme[3] + EPSILON * far / angle


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
def correct(tables, h, kv, kx, ka, part, options, trial, record):
    """Add `part` of the correction; its size relative to what is wanted, the largest of lengths and angles."""
    n, m = tables.sizes.n_q, tables.sizes.n_c
    moved_x, moved_t, fast_x, fast_t, far_x, far_t, total = 0.0, 0.0, 0.0, 0.0, options.length, 1.0, 0.0
    shifted = m > 0 and options.form == GEAR_GUPTA_LEIMKUHLER
    for i in range(n):
        d = part * trial.d[i]
        shift = part * trial.e[i] if shifted else 0.0
        trial.q[i] += d + shift
        trial.shift[i] += shift
        trial.v[i] += kv * d
        trial.x[i] += kx * d
        trial.a[i] += ka * d
        trial.before[i] = trial.d[i]
        move = abs(d) + abs(shift)
        total += move
        if tables.kind[i] == 0:
            moved_x, fast_x = max(moved_x, move), max(fast_x, abs(trial.a[i]))
            far_x = max(far_x, abs(trial.q[i]))
        else:
            moved_t, fast_t = max(moved_t, move), max(fast_t, abs(trial.a[i]))
            far_t = max(far_t, abs(trial.q[i]))
    if not math.isfinite(total):
        return math.inf
    for i in range(m):
        trial.lam[i] += part * trial.d[n + i]
    wanted_x = options.tolerance * h * h * fast_x + ROUND_OFF * far_x
    wanted_t = options.tolerance * h * h * fast_t + ROUND_OFF * far_t
    if moved_x / wanted_x > moved_t / wanted_t:
        record.extreme[2], record.extreme[3], record.extreme[7] = moved_x, wanted_x, ROUND_OFF * far_x / wanted_x
    else:
        record.extreme[2], record.extreme[3], record.extreme[7] = moved_t, wanted_t, ROUND_OFF * far_t / wanted_t
    return max(moved_x / wanted_x, moved_t / wanted_t)
