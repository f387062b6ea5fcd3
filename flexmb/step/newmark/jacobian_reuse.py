"""Factors of earlier iterations and steps: when they may serve, and what is learnt of them.

A correction with old factors leaves theta times the error that was there, where theta is the ratio of successive
corrections with the same factors (E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, section IV.8).
That is no bound where the old matrix is much stiffer than the true one, since all corrections are then too small and
alike.  So a contact or friction whose slopes have changed asks for a new matrix before any correction is believed, and
theta is measured anew every few steps.
"""

import math

from flexmb.compiled.record_type import copy_numbers
from flexmb.kernels import compiled, copy

LONGEST_PAUSE = 15.0

OLDEST, MOST_EXTRA, OTHER_STEP = 25.0, 3.0, 0.2
"""Factors that served so many steps, cost so many iterations, or have coefficients that differ so much, go."""

REGULAR = 1e-2
"""Smallest relative pivot of a constraint with which factors may serve again: near singular positions rows are watched
in every iteration."""

MEASURE_AGAIN = 8.0
"""Steps after which theta is measured anew."""

GOOD, FAIR = 0.1, 0.3
"""Theta with which one correction may be believed, and with which iterations go on."""

ALIKE = 0.5
"""Largest relative change of a slope of a contact or friction law."""

GROWN = 3.0
"""A first correction so much larger than that of the step before is not believed alone."""

STALE_ITERATIONS = 4

LEFT = 1e-4
"""Error that a step may be left with, as theta estimates it, relative to what is wanted of corrections.  It is smaller
than 1 because what is left of G v = 0 comes back in the accelerations of the next step, over h, and because it has the
same direction in every step: 1e-3 left the N-four-bar 6e-7 m away after 10 s, and saved nothing."""

PART_OF_NOISE = 0.01
"""The same relative to round-off of corrections, where that is more.  Round-off has no direction, but what theta leaves
has the same one in every step: with steps of 0.1 ms, 1e-15 m are an acceleration of 1e-7 m/s^2 that stays missing."""

UNSEEN = 0.05
"""Last correction after which forces and energies are not evaluated again; those of joints follow the multipliers."""

RUBBING = 1e-4
"""The same where a contact is closed or a joint has friction: their forces do not follow."""


@compiled
def may_serve(kv, ka, flow, reuse):
    """Whether the factors of earlier steps may serve one with these coefficients."""
    if reuse.wait > 0.0:
        reuse.wait -= 1.0
        return False
    if reuse.age == 0.0 or reuse.age > OLDEST or reuse.extra >= MOST_EXTRA or reuse.weak < REGULAR:
        return False
    alike = abs(kv - reuse.kv) <= OTHER_STEP * abs(kv) and abs(ka - reuse.ka) <= OTHER_STEP * abs(ka)
    return alike and flow.clock.held_steps <= 0.0


@compiled
def forget_factors(reuse):
    """There are none, or they must not be used."""
    reuse.age = 0.0


@compiled
def note_factors(kv, ka, weak, trial, work):
    """New factors are at hand."""
    reuse = trial.reuse
    reuse.fresh = 1.0
    reuse.age, reuse.kv, reuse.ka, reuse.weak = 1.0, kv, ka, weak
    reuse.extra, reuse.best = 0.0, 0.0
    for k in range(trial.slopes.shape[0]):
        copy(work.slopes[k], trial.slopes[k])


@compiled
def begin_trial(flow, trial):
    """A trial step begins with what the accepted ones taught; a rejected one leaves no trace."""
    copy_numbers(flow.prediction, trial.prediction)
    copy_numbers(flow.reuse, trial.reuse)
    trial.reuse.fresh = 0.0
    for k in range(trial.slopes.shape[0]):
        copy(flow.slopes[k], trial.slopes[k])
    if flow.clock.last == 0.0:
        forget_factors(trial.reuse)


@compiled
def keep_trial(flow, trial, work):
    """The trial step is accepted."""
    if trial.reuse.fresh > 0.0 and trial.reuse.age > 0.0:
        copy(work.lu, flow.factors)
        for k in range(trial.slopes.shape[0]):
            copy(trial.slopes[k], flow.slopes[k])
    copy_numbers(trial.prediction, flow.prediction)
    copy_numbers(trial.reuse, flow.reuse)


@compiled
def slopes_changed(trial, work):
    """Whether a contact or friction law has another stiffness than in the matrix that was factored."""
    for k in range(trial.slopes.shape[0]):
        for i in range(4):
            old, new = trial.slopes[k, i], work.slopes[k, i]
            if abs(new - old) > ALIKE * max(abs(new), abs(old)):
                return True
    return False


@compiled
def rubbing(slopes):
    """Whether a contact is closed or a joint has friction."""
    total = 0.0
    for k in range(slopes.shape[0]):
        for i in range(4):
            total = max(total, abs(slopes[k, i]))
    return total > 0.0


@compiled
def may_check(reuse):
    """Whether factors that are new in this step may serve its further iterations."""
    return reuse.age == 1.0 and reuse.weak >= REGULAR


@compiled
def refused(fresh, reuse):
    """Old factors were of no use; if of an earlier step, the next steps begin with new ones, more of them each time."""
    if fresh == 0:
        reuse.pause = min(2.0 * reuse.pause + 1.0, LONGEST_PAUSE)
        reuse.wait = reuse.pause


@compiled
def bounds(noise, work):
    """What the last correction may be for the state before it to be taken, and what error may be left.

    noise : round-off of corrections.  Two returns: with one the machine code of a step takes a tenth longer.
    """
    if rubbing(work.slopes):
        return max(RUBBING, noise), max(LEFT, PART_OF_NOISE * noise)
    return max(UNSEEN, noise), max(LEFT, PART_OF_NOISE * noise)


@compiled
def touching(tables, work):
    """Whether contacts are closed and no joint has friction, which depends on its multipliers."""
    n = tables.contacts.kernel.shape[0]
    return n > 0 and tables.sizes.gripped == 0 and rubbing(work.slopes)


@compiled
def judged(size, same, unseen, left, noise, reuse):
    """Whether a correction with old factors is the last, whether the state before it will do, and whether to go on.

    same : size of the correction before it with the same factors, inf for none.
    """
    seen = size <= unseen
    if same == math.inf:
        return seen and believed(size, reuse) and size * reuse.theta <= left, seen, size < math.inf
    theta = measured(size, same, reuse)
    if theta > FAIR and size <= noise:  # it gets no smaller
        return True, seen, True
    if size <= left or (theta <= FAIR and size * theta <= left * (1.0 - theta)):
        return True, seen, True
    return False, seen, theta <= FAIR and size * theta**3 <= left


@compiled
def believed(size, reuse):
    """Whether a first correction below what is wanted may be the last one."""
    grown = size > 1e-3 and size > GROWN * reuse.first
    return reuse.theta <= GOOD and reuse.since < MEASURE_AGAIN and not grown


@compiled
def measured(size, last, reuse):
    """The ratio of two corrections with the same factors; noted."""
    theta = size / last if last > 0.0 else 0.0
    reuse.theta = min(theta, GOOD) if size <= 0.05 else theta  # round-off says nothing of the factors
    reuse.since = 0.0
    return theta


@compiled
def served(fresh, stale, seen, turn, reuse):
    """A step is done, its last `stale` iterations and one more with old factors, `fresh` before them with new ones.

    seen : the state of the last evaluation was the accepted one.  turn : theta was due to be measured, which takes an
    iteration more.
    """
    reuse.since += 1.0
    if fresh > 0:
        reuse.check = float(stale if seen else stale + 1)
        return
    used = float(stale if turn and stale > 0 else stale + 1)
    if reuse.best == 0.0:
        reuse.best = used
    reuse.extra += max(used - reuse.best, 0.0)
    reuse.age += 1.0
    reuse.pause = 0.0
    if not turn:
        reuse.expected = float(stale if seen else stale + 1)
