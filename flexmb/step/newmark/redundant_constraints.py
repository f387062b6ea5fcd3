"""Redundant constraints: rows of G that depend on others, at a singular position or in every pose.

Holding a row leaves it out of the linear system of a step: its multiplier keeps the value of the last step.  The other
rows close the joint, too, if the row is redundant; `allowed_gap` bounds the gap that it may open otherwise.
"""

import math

from flexmb.kernels import compiled
from flexmb.linalg.lu import HELD_PIVOT, LOST_PIVOT, null_vector

CLOSED_GAP = 1e-10
"""Largest gap of a held row, relative to the size of the mechanism."""

OPENING_FRACTION = 0.1
"""Largest gap of a held row relative to h^2 a, in the first steps at a singular position.

A row that is needed opens by all of h^2 a, a redundant one by its square.
"""

HOLD_WITHIN_STEP = 1e-4
"""Relative pivot below which a row is held in the later iterations of a step that holds rows."""

PASSING_STEPS = 3
"""Number of steps at most in which large steps pass a singular position."""

EFFECT_LIMIT = 1e-3
"""Entry of a multiplier vector u with G^T u = 0 relative to its largest, above which a joint is named as redundant."""


@compiled
def initial_hold(flow):
    """Relative pivot of a constraint below which a step holds its row, at first."""
    return HELD_PIVOT if flow.clock.held_steps >= 0.0 else LOST_PIVOT


@compiled
def held_code(held, strict, flow):
    """Code of a step: 1 if rows are held at its end, plus 2 if held rows turned out to be needed (`strict`)."""
    return (1 if held else 0) + (2 if strict and flow.clock.held_steps >= 0.0 else 0)


@compiled
def allowed_gap(tables, h, options, flow, a):
    """Largest gap that held rows may open in the present step; a : (n_q,) accelerations."""
    if flow.clock.held_steps >= PASSING_STEPS or flow.clock.held_steps < 0.0:
        return CLOSED_GAP * options.length
    largest = 0.0
    for k in range(0, tables.sizes.n_b, 3):
        largest = max(largest, math.sqrt(a[k] ** 2 + a[k + 1] ** 2), options.length * abs(a[k + 2]))
    return CLOSED_GAP * options.length + OPENING_FRACTION * min(h * h * largest, 0.01 * options.length)


@compiled
def update_held_multipliers(tables, lu, t, flow, trial, work, record):
    """After an accepted step: record time and joints of held rows; choose multipliers of least norm.

    Every held row stands for a vector of multipliers u with G^T u = 0.  If there are as many as rows of
    trial.free_multipliers (joints that are redundant in every pose), they are made orthonormal there, and their
    components are removed from the multipliers.  `Clock.held_steps` counts the successive steps that held more rows, or
    found held rows needed.  It becomes -1, for the rest of the run, in a model whose rows are always needed.
    """
    held, needed = record.count.held_code % 2 == 1, record.count.held_code >= 2
    total = 0
    for place in range(trial.pivot_scale.shape[0]):
        if held and trial.pivot_scale[place] < 0.0:
            total += 1
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
    """Orthonormalise the multipliers in trial.shift into row `row` of trial.free_multipliers; remove their component.

    Gram-Schmidt, done twice against round-off.
    """
    for k in range(2 * row):
        along = 0.0
        for i in range(m):
            along += trial.free_multipliers[k % row, i] * trial.shift[n + i]
        for i in range(m):
            trial.shift[n + i] -= along * trial.free_multipliers[k % row, i]
    square = 0.0
    for i in range(m):
        square += trial.shift[n + i] * trial.shift[n + i]
    component = 0.0
    for i in range(m):
        trial.free_multipliers[row, i] = trial.shift[n + i] / square**0.5
        component += trial.free_multipliers[row, i] * trial.lam[i]
    for i in range(m):
        trial.lam[i] -= component * trial.free_multipliers[row, i]
