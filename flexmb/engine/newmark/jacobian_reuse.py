"""Convergence of Newton's iteration, reuse of factors of its matrix, rows of constraints that depend on others.

Holding a row leaves it out of the linear system of a step: its multiplier keeps the value of the last step.  The other
rows close the joint, too, if the row is redundant; `allowed_gap` bounds the gap that it may open otherwise.

A correction with reused factors leaves an error of theta/(1 - theta) times the correction.  The contraction rate theta
is the ratio of successive corrections with the same factors (E. Hairer, G. Wanner, Solving Ordinary Differential
Equations II, section IV.8).  The estimate fails where the factored matrix is much stiffer than the true one, since all
corrections are then too small and alike.  So a changed slope of a contact or friction law asks for a new matrix before
any correction is accepted, and theta is measured again every few steps.
"""

import math

from flexmb.engine.compiled.arrays import part_of
from flexmb.engine.compiled.records import copy_numbers
from flexmb.engine.linalg.lu import HELD_PIVOT, LOST_PIVOT, ROWS_HELD, factor, null_vector, smallest_pivot
from flexmb.kernels import compiled, copy

# Redundant constraints: rows of G that depend on others, at a singular position or in every pose

CLOSED_GAP = 1e-10  # largest gap of a held row, relative to the size of the mechanism
# Largest gap of a held row relative to h^2 a, in the first steps at a singular position.
# A row that is needed opens by all of h^2 a, a redundant one by its square.
OPENING_FRACTION = 0.1
HOLD_WITHIN_STEP = 1e-4  # relative pivot below which a row is held in the later iterations of a step that holds rows
ENDLESS_PIVOT = 1e150  # pivot of a row that is redundant in every pose
SINGULAR_PIVOT = 1e-4  # relative pivot of another row, below which a position is near a singular one: a sine of 0.01
PASSING_STEPS = 3  # number of steps at most in which large steps pass a singular position
# Entry of a multiplier vector u with G^T u = 0 relative to its largest, above which a joint is named as redundant.
EFFECT_LIMIT = 1e-3


@compiled
def initial_hold(flow):
    """Relative pivot of a constraint below which a step holds its row, at first."""
    return HELD_PIVOT if flow.clock.held_steps >= 0.0 else LOST_PIVOT


@compiled
def factor_without_redundant(lu, values, hold, n, trial):
    """`factor`, in which the rows that are redundant in every pose are held, whatever their pivots are."""
    # Near a singular position the round-off in their pivots is larger than the pivots of rows that are needed, and that
    # in their residuals larger than any gap, so that these are not looked at there.
    places, pivots = trial.left_out, trial.left_out_pivots
    for k in range(pivots.shape[0]):
        values[pivots[k]] = ENDLESS_PIVOT
    lost = factor(lu, values, trial.pivot_scale, LOST_PIVOT, n, hold)
    if lost >= 0 or places.shape[0] == 0:
        return lost
    near = smallest_pivot(lu, values, trial.pivot_scale, n) < SINGULAR_PIVOT
    for k in range(places.shape[0]):
        values[pivots[k]] = 0.0
        trial.pivot_scale[places[k]] = -math.inf if near else -1.0
    return ROWS_HELD


@compiled
def held_code(held, strict, flow):
    """Code of a step: 1 if rows are held at its end, plus 2 if held rows turned out to be needed (`strict`)."""
    return (1 if held else 0) + (2 if strict and flow.clock.held_steps >= 0.0 else 0)


@compiled
def allowed_gap(tables, h, options, flow, a, redundant):
    """Largest gap that held rows may open in the present step; a : (n_q,) accelerations."""
    # `redundant` : the held rows are redundant in every pose.
    if not redundant and (flow.clock.held_steps >= PASSING_STEPS or flow.clock.held_steps < 0.0):
        return CLOSED_GAP * options.length
    largest = 0.0
    for k in range(0, tables.sizes.n_b, 3):
        largest = max(largest, math.sqrt(a[k] ** 2 + a[k + 1] ** 2), options.length * abs(a[k + 2]))
    return CLOSED_GAP * options.length + OPENING_FRACTION * min(h * h * largest, 0.01 * options.length)


@compiled
def update_held_multipliers(tables, lu, t, flow, trial, work, record):
    """After an accepted step: record time and joints of held rows; choose multipliers of least norm."""
    # Every held row stands for a vector of multipliers u with G^T u = 0. If there are as many as rows of
    # trial.free_multipliers (joints that are redundant in every pose), they are made orthonormal there, and their
    # components are removed from the multipliers. `Clock.held_steps` counts the successive steps that held more rows,
    # or found held rows needed. It becomes -1, for the rest of the run, in a model whose rows are always needed.
    held, needed = record.count.held_code % 2 == 1, record.count.held_code >= 2
    total = number_of_held(trial) if held else 0
    if needed and not held and flow.clock.held_steps >= PASSING_STEPS:
        flow.clock.held_steps = -1.0
    elif flow.clock.held_steps >= 0.0:
        beyond = needed or total > trial.free_multipliers.shape[0]
        flow.clock.held_steps = flow.clock.held_steps + 1.0 if beyond else 0.0
    if held:
        if record.count.held_steps == 0:
            record.report.first_held_time = t
        record.count.held_steps += 1
        least_norm = total == trial.free_multipliers.shape[0]
        record_held_rows(tables.sizes.n_q, tables.sizes.n_c, lu, least_norm, trial, work, record)


@compiled
def number_of_held(trial):
    """Number of rows that the last factorisation held."""
    held = 0
    for place in range(trial.pivot_scale.shape[0]):
        held += 1 if trial.pivot_scale[place] < 0.0 else 0
    return held


@compiled
def take_least_norm(tables, lu, trial, work, record):
    """Choose multipliers of least norm for a state within a step, after its factorisation."""
    if 0 < number_of_held(trial) == trial.free_multipliers.shape[0]:  # joints that are redundant in every pose
        record_held_rows(tables.sizes.n_q, tables.sizes.n_c, lu, True, trial, work, record)


@compiled
def record_held_rows(n, m, lu, least_norm, trial, work, record):
    """Record the constraint equations whose multipliers are not unique; `least_norm`: choose them of least norm."""
    number = 0
    for s in range(len(lu.starts) - 1):
        for k in range(lu.starts[s + 1] - lu.starts[s]):
            if trial.pivot_scale[lu.starts[s] + k] > 0.0:
                continue
            null_vector(lu, work.lu, s, k, trial.rhs, trial.shift, trial.scratch)
            largest = 0.0
            for i in range(m):
                largest = max(largest, abs(trial.shift[n + i]))
            for i in range(m):
                if abs(trial.shift[n + i]) > EFFECT_LIMIT * largest:
                    record.held_rows[i] = True
            if least_norm:
                remove_component(n, m, number, trial)
                number += 1


@compiled
def remove_component(n, m, row, trial):
    """Orthonormalise the multipliers in trial.shift into `row` of trial.free_multipliers; remove their component."""
    # Gram-Schmidt, done twice against round-off: a multiplier between steps may have been 1e12 times its component.
    found, own = part_of(trial.shift, n, n + m), trial.free_multipliers[row]
    for k in range(2 * row):
        remove_along(trial.free_multipliers[k % row], found)
    square = 0.0
    for i in range(m):
        square += found[i] * found[i]
    for i in range(m):
        own[i] = found[i] / square**0.5
    for _ in range(2):
        remove_along(own, trial.lam)


@compiled
def remove_along(u, x):
    """Remove the component of x along u, a vector of length 1."""
    component = 0.0
    for i in range(u.shape[0]):
        component += u[i] * x[i]
    for i in range(u.shape[0]):
        x[i] -= component * u[i]


# Number of unknowns up to which every iteration with a closed contact or joint friction factors its own matrix.
# Matrix and factors then cost little more than a residual.
SMALL_SYSTEM = 60
LONGEST_SUSPENSION = 15.0  # number of steps for which reuse is suspended at most
OLDEST_FACTORS = 25.0  # number of steps after which factors are discarded
# Number of iterations beyond those of the best step, summed over steps, after which factors are discarded.
MOST_EXTRA_ITERATIONS = 3.0
COEFFICIENT_CHANGE = 0.2  # relative change of a coefficient kv or ka, above which factors are discarded
# Smallest relative pivot of a constraint with which factors are reused.
# Near singular positions every iteration factors its own matrix, in which redundant rows are found.
REGULAR_PIVOT = 1e-2
MEASURING_INTERVAL = 8.0  # number of steps after which the contraction rate is measured again
GOOD_CONTRACTION = 0.1  # contraction rate up to which a single correction may end an iteration
FAIR_CONTRACTION = 0.3  # contraction rate up to which an iteration with reused factors continues
# Relative change of a slope of a contact or friction law, above which the iteration needs a new matrix.
SLOPE_CHANGE = 0.5
ROUND_OFF_SPREAD = 5.0  # correction that may be round-off over one that was seen to be
# First correction over that of the step before, above which a single correction does not end the iteration.
CORRECTION_GROWTH = 3.0
MOST_REUSE_ITERATIONS = 4  # number of iterations with reused factors at most
# Error that may remain, as theta estimates it, over the tolerance of corrections.
# It is smaller than 1 because the rest of G v = 0 returns, over h, in the accelerations of the next step, in the same
# direction in every step: 1e-3 left the N-four-bar 6e-7 m away after 10 s, and saved nothing.
REMAINING_ERROR = 1e-4
# Error that may remain over the round-off of corrections, where that is more than `REMAINING_ERROR` allows.
# Round-off has no direction; the remaining error has the same direction in every step: with steps of 0.1 ms, 1e-15 m
# are an acceleration of 1e-7 m/s^2 that stays missing.
REMAINING_ROUND_OFF = 0.01
# Last correction over its tolerance, after which forces and energies are not evaluated again.
NEGLIGIBLE_CORRECTION = 0.05
# Last correction over its tolerance, after which the same holds with a closed contact or friction in a joint.
NEGLIGIBLE_WITH_FRICTION = 1e-4


@compiled
def may_reuse(kv, ka, flow, reuse):
    """Whether the factors of earlier steps are reused in a step with coefficients kv and ka; counts a suspension."""
    if reuse.suspended_steps > 0.0:
        reuse.suspended_steps -= 1.0
        return False
    if reuse.age == 0.0 or reuse.age > OLDEST_FACTORS or reuse.extra_iterations >= MOST_EXTRA_ITERATIONS:
        return False
    if reuse.smallest_pivot < REGULAR_PIVOT:
        return False
    same_kv = abs(kv - reuse.kv) <= COEFFICIENT_CHANGE * abs(kv)
    same_ka = abs(ka - reuse.ka) <= COEFFICIENT_CHANGE * abs(ka)
    return same_kv and same_ka and flow.clock.held_steps <= 0.0


@compiled
def discard_factors(reuse):
    """Discard the factors."""
    reuse.age = 0.0


@compiled
def adopt_factors(flow, trial, work):
    """Adopt factors and states of predictor and reuse of an accepted trial."""
    if trial.reuse.refactored > 0.0 and trial.reuse.age > 0.0:
        if not takes_own_matrices(trial.rhs.shape[0], trial.slopes):  # else no later step reuses them
            copy(work.lu, flow.factors)
        for k in range(trial.slopes.shape[0]):
            copy(trial.slopes[k], flow.slopes[k])
    copy_numbers(trial.predictor, flow.predictor)
    copy_numbers(trial.reuse, flow.reuse)


@compiled
def slopes_changed(trial, work):
    """Whether a slope of a contact or friction law differs from that in the factored matrix."""
    for k in range(trial.slopes.shape[0]):
        for i in range(4):
            old, new = trial.slopes[k, i], work.slopes[k, i]
            if abs(new - old) > SLOPE_CHANGE * max(abs(new), abs(old)):
                return True
    return False


@compiled
def has_contact_or_friction(slopes):
    """Whether a contact is closed or a joint has friction."""
    total = 0.0
    for k in range(slopes.shape[0]):
        for i in range(4):
            total = max(total, abs(slopes[k, i]))
    return total > 0.0


@compiled
def takes_own_matrices(unknowns, slopes):
    """Whether each iteration factors its own matrix, at these slopes of contacts and friction."""
    return unknowns <= SMALL_SYSTEM and has_contact_or_friction(slopes)


@compiled
def has_contact_alone(tables, work):
    """Whether a contact is closed and no joint has friction, which would depend on the multipliers."""
    n = tables.contacts.kernel.shape[0]
    return n > 0 and tables.sizes.has_joint_friction == 0 and has_contact_or_friction(work.slopes)


@compiled
def convergence_limits(noise, work):
    """Last correction that is negligible, and error that may remain, both over the tolerance; noise: round-off."""
    if has_contact_or_friction(work.slopes):  # two returns: with one the machine code of a step takes a tenth longer
        return max(NEGLIGIBLE_WITH_FRICTION, noise), max(REMAINING_ERROR, REMAINING_ROUND_OFF * noise)
    return max(NEGLIGIBLE_CORRECTION, noise), max(REMAINING_ERROR, REMAINING_ROUND_OFF * noise)


@compiled
def convergence_test(size, last_size, negligible, remaining, noise, own, reuse):
    """Test a correction with reused factors: converged, correction negligible, iteration contracting."""
    # size, last_size : this correction and the one before with the same factors, over the tolerance; inf: none before.
    # own : whether the factors are of this step and no law has a slope. Corrections within the tolerance that get no
    # smaller are round-off then; their size tells that of factors of earlier steps.
    small = size <= negligible
    if last_size == math.inf:
        grown = size > 1e-3 and size > CORRECTION_GROWTH * reuse.first_correction
        known = reuse.contraction <= GOOD_CONTRACTION and reuse.steps_since_measured < MEASURING_INTERVAL
        enough = small and known and not grown and size * reuse.contraction <= remaining
        return enough, small, size < math.inf
    theta = size / last_size if last_size > 0.0 else 0.0  # contraction rate
    reuse.contraction = min(theta, GOOD_CONTRACTION) if size <= 0.05 else theta  # small ones are round-off
    reuse.steps_since_measured = 0.0
    if own and size <= 1.0:
        reuse.round_off = size if theta > FAIR_CONTRACTION else min(size, reuse.round_off)
    level = max(noise, min(1.0, ROUND_OFF_SPREAD * reuse.round_off))
    if theta > FAIR_CONTRACTION and size <= level:  # round-off: corrections get no smaller
        reuse.contraction = min(theta, GOOD_CONTRACTION)
        return True, True, True
    if size <= remaining or (theta <= FAIR_CONTRACTION and size * theta <= remaining * (1.0 - theta)):
        return True, small, True
    return False, small, theta <= FAIR_CONTRACTION and (size * theta**3 <= remaining or size <= level)


@compiled
def update_reuse(factorisations, reused, evaluated, measuring, reuse):
    """Count a step that converged with reused factors, and expect the next one to take as many iterations."""
    # factorisations: matrices factored in this step;  reused: iterations with the last factors before the last one
    # evaluated: whether the state of the last evaluation is the accepted one
    # measuring: whether the contraction rate was due to be measured, which takes one more iteration
    reuse.steps_since_measured += 1.0
    if factorisations > 0:
        reuse.expected_last_fresh = float(reused if evaluated else reused + 1)
        return
    used = float(reused if measuring and reused > 0 else reused + 1)
    if reuse.best_iterations == 0.0:
        reuse.best_iterations = used
    reuse.extra_iterations += max(used - reuse.best_iterations, 0.0)
    reuse.age += 1.0
    reuse.last_suspension = 0.0
    if not measuring:
        reuse.expected_last = float(reused if evaluated else reused + 1)
