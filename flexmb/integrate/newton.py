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
from flexmb.kernels import compiled, copy
from flexmb.solve.lu import HELD, HOLD, THRESHOLD, factor, first_held, left_over, solve, weakest
from flexmb.system.evaluate import evaluate

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
def predict(n, h, ratio, options, flow, trial):
    """Start values of the step: constant true acceleration."""
    am, af, beta, gamma = options.alpha_m, options.alpha_f, options.beta, options.gamma
    for i in range(n):
        x0 = flow.a[i] + ratio * (flow.x[i] - flow.a[i])
        a1 = flow.a[i]
        x1 = ((1.0 - af) * a1 + af * flow.a[i] - am * x0) / (1.0 - am)
        trial.a[i], trial.x[i] = a1, x1
        trial.q[i] = flow.q[i] + h * flow.v[i] + h * h * ((0.5 - beta) * x0 + beta * x1)
        trial.v[i] = flow.v[i] + h * ((1.0 - gamma) * x0 + gamma * x1)
    copy(flow.lam, trial.lam)


@compiled
def implicit_step(tables, address, lu, h, ratio, options, flow, trial, work, record):
    """Try a step of size h; RUNNING when it converged, else the code of the failure."""
    n, m = tables.sizes.n_q, tables.sizes.n_c
    t = flow.clock[0] + h
    am, af, beta, gamma = options.alpha_m, options.alpha_f, options.beta, options.gamma
    kv = gamma / (beta * h)
    kx = 1.0 / (beta * h * h)
    ka = (1.0 - am) / (1.0 - af) * kx
    predict(n, h, ratio, options, flow, trial)
    last, part, reach, hold = math.inf, 1.0, math.inf, first_hold(flow)
    for iteration in range(options.iterations):
        evaluate(tables, address, t, h, trial.q, trial.v, trial.a, trial.lam, flow.z, 1.0, kv, ka, True, work)
        record.count[3] += 1
        for i in range(n):
            trial.b[i] = -(work.r[i] + work.Gl[i])
        for i in range(m):
            trial.b[n + i] = -work.g[i] if options.form == POSITION else -work.gv[i] / kv
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
        solve(lu, work.lu, trial.b, trial.d, trial.y)
        if m > 0 and options.form == GEAR_GUPTA_LEIMKUHLER:
            project(n, m, lu, trial, work)
        part, reach = shortened(n, iteration, part, reach, trial)
        size = correct(tables, h, kv, kx, ka, part, options, trial, record) / part
        record.count[2] += 1
        if not math.isfinite(size):
            return NOT_FINITE
        small = size <= 1.0 or (part == 1.0 and iteration > 0 and size < last and size * size / (last - size) <= 1.0)
        if small or (iteration > 1 and size > 0.1 * last and only_noise(n, m, lu, trial, work, record)):
            record.count[8] = outcome(lost == HELD, hold == THRESHOLD, flow)
            return RUNNING
        if reach == math.inf and iteration > 3 and size > 2.0 * last:
            return NEWTON_FAILED
        last = size
    return NEWTON_FAILED


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
    along, before, now = 0.0, 0.0, 0.0
    for i in range(n):
        along += trial.d[i] * trial.lag[i]
        before += trial.lag[i] * trial.lag[i]
        now += trial.d[i] * trial.d[i]
        trial.lag[i] = trial.d[i]
    if iteration < 2:
        return 1.0, math.inf
    if along < 0.0:
        reach = 0.5 * part * math.sqrt(before)
    elif part < 1.0:
        reach *= 0.5
    now = math.sqrt(now)
    return (1.0 if now <= reach else reach / now), reach


@compiled
def project(n, m, lu, trial, work):
    """trial.e: the shift of positions that closes the joints, beside the correction in trial.d."""
    for i in range(n):
        trial.b[i] = 0.0
    for i in range(m):
        trial.b[n + i] = -work.g[i] - trial.b[n + i]  # G d is the old right side
    solve(lu, work.lu, trial.b, trial.e, trial.y)


@compiled
def correct(tables, h, kv, kx, ka, part, options, trial, record):
    """Add `part` of the correction; its size relative to what is wanted, the largest of lengths and angles."""
    n, m = tables.sizes.n_q, tables.sizes.n_c
    moved_x, moved_t, fast_x, fast_t, far_x, far_t = 0.0, 0.0, 0.0, 0.0, options.length, 1.0
    shifted = m > 0 and options.form == GEAR_GUPTA_LEIMKUHLER
    for i in range(n):
        d = part * trial.d[i]
        shift = part * trial.e[i] if shifted else 0.0
        trial.q[i] += d + shift
        trial.v[i] += kv * d
        trial.x[i] += kx * d
        trial.a[i] += ka * d
        move = abs(d) + abs(shift)
        if tables.kind[i] == 0:
            moved_x, fast_x = max(moved_x, move), max(fast_x, abs(trial.a[i]))
            far_x = max(far_x, abs(trial.q[i]))
        else:
            moved_t, fast_t = max(moved_t, move), max(fast_t, abs(trial.a[i]))
            far_t = max(far_t, abs(trial.q[i]))
        if not math.isfinite(move):
            return math.inf
    for i in range(m):
        trial.lam[i] += part * trial.d[n + i]
    wanted_x = options.tolerance * h * h * fast_x + ROUND_OFF * far_x
    wanted_t = options.tolerance * h * h * fast_t + ROUND_OFF * far_t
    if moved_x / wanted_x > moved_t / wanted_t:
        record.extreme[2], record.extreme[3] = moved_x, wanted_x
    else:
        record.extreme[2], record.extreme[3] = moved_t, wanted_t
    return max(moved_x / wanted_x, moved_t / wanted_t)
