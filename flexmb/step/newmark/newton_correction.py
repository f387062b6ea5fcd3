"""Correction of a Newton iteration: right-hand sides, solution, damping, size over the tolerance."""

import math

from flexmb.compiled.views import part_of
from flexmb.kernels import compiled
from flexmb.linalg.lu import smallest_pivot
from flexmb.linalg.substitute import solve, solve_two
from flexmb.state.options import GEAR_GUPTA_LEIMKUHLER, POSITION

ROUND_OFF = 1e-14
"""Correction relative to the coordinates, below which it is round-off."""

LEAST_CORRECTION = 1e-300
"""Least tolerance of a correction of the state of a control, for states that stay 0."""

STATE_ROUND_OFF = 1e-12
"""Correction of the state of a control relative to its size, below which it is round-off of its law."""

ANGLE_ALLOWANCE = 6.3
"""Angle [rad] up to which round-off is that of 1 rad, so that the pose of a mechanism at the start does not count."""

GAP_ROUND_OFF = 0.1
"""Round-off of a gap relative to that of corrections."""


@compiled
def residual_vectors(n, m, kv, options, trial, work):
    """Fill trial.rhs, the negative residual, and trial.gap_rhs, the gaps that the correction itself leaves open.

    The lower half of trial.rhs is G d of the correction d, so that gap_rhs = -g - G d.
    """
    for i in range(n):
        trial.rhs[i] = -(work.r[i] + work.Gl[i])
        trial.gap_rhs[i] = 0.0
    for i in range(m):
        trial.rhs[n + i] = -work.g[i] if options.form == POSITION else -work.gv[i] / kv
        trial.gap_rhs[n + i] = -work.g[i] - trial.rhs[n + i]


@compiled
def solve_correction(m, lu, values, options, trial):
    """Solve for trial.solution, the correction, and trial.shift, the position shift; values: factors."""
    if m > 0 and options.form == GEAR_GUPTA_LEIMKUHLER:
        solve_two(lu, values, trial.rhs, trial.gap_rhs, trial.solution, trial.shift, trial.scratch_pair)
    else:
        solve(lu, values, trial.rhs, trial.solution, trial.scratch)


@compiled
def damping_factor(n, trial):
    """Set trial.newton.fraction, the applied fraction of the correction, and trial.newton.reach, its largest length.

    Where friction changes its sign, full corrections alternate between its branches for ever.  A correction that turns
    back shows that the solution lies within the one before it: from then on no correction is longer than half of the
    last one, until full corrections stay within that bound.  This is Newton's method safeguarded by bisection.
    """
    newton = trial.newton
    if newton.factorisations < 3:
        newton.fraction, newton.reach = 1.0, math.inf
        return
    along, before, now = 0.0, 0.0, 0.0
    for i in range(n):
        along += trial.solution[i] * trial.last_correction[i]
        before += trial.last_correction[i] * trial.last_correction[i]
        now += trial.solution[i] * trial.solution[i]
    if along < 0.0:
        newton.reach = 0.5 * newton.fraction * math.sqrt(before)
    elif newton.fraction < 1.0:
        newton.reach *= 0.5
    now = math.sqrt(now)
    newton.fraction = 1.0 if now <= newton.reach else newton.reach / now


@compiled
def apply_correction(tables, h, kv, kx, ka, fraction, options, trial, record):
    """Add a fraction of the correction to the trial state; return its size over the tolerance.

    The size is the largest over all nodes, of displacements [m] and of rotations [rad], shift included.  Tolerances
    are `options.tolerance` times h^2 times the largest acceleration, plus the round-off of the coordinates.

    Equation (4.10) of docs/theory/integrators.md.
    """
    n, m, report = tables.sizes.n_q, tables.sizes.n_c, record.report
    way, turn, shift_x, shift_t, fast_x, fast_t, total = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    far_x, far_t = options.length**2, 1.0
    shifted = fraction if m > 0 and options.form == GEAR_GUPTA_LEIMKUHLER else 0.0
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
    of_states = 0.0
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
    """Add a fraction of the correction to the states of controls; return its size over the tolerance.

    A correction d changes a state by kv d.  Tolerances are those of coordinates: `options.tolerance` times h^2 times
    the rate of the state, plus round-off of the state in a step.
    """
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


@compiled
def within_factor_two(before, now):
    """Whether two numbers differ by less than a factor of 2."""
    return 0.5 * before <= now <= 2.0 * before


@compiled
def is_round_off(n, m, lu, trial, work, record):
    """Whether the last correction is round-off of the gaps over the angle between two constraint rows."""
    angle = math.sqrt(smallest_pivot(lu, work.lu, trial.pivot_scale, n)) if m > 0 else 1.0
    report = record.report
    return report.correction <= report.tolerance * (1.0 + GAP_ROUND_OFF * report.round_off / angle)
