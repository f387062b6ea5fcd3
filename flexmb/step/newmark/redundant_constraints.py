"""Joints that repeat one another, at a singular position or always: what a step with held rows leaves behind."""

import math

from flexmb.kernels import compiled
from flexmb.linalg.lu import HOLD, THRESHOLD, dependence

CLOSED = 1e-10
"""Gap of a row that may be held, relative to the size of the mechanism."""

ASIDE = 0.1
"""The same relative to the way h^2 a, in the first steps: a row that is needed opens by all of it, one that repeats the
others by its square."""

STILL = 1e-4
"""What HOLD becomes within a step in which rows are held."""

PASSING = 3
"""Steps at most that one passes a singular position with when they are large."""

PART = 1e-3
"""Entry of a vector of multipliers without effect, relative to its largest, above which its joint has part in it."""


@compiled
def first_hold(flow):
    """What a step begins to hold rows with."""
    return HOLD if flow.clock.held_steps >= 0.0 else THRESHOLD


@compiled
def outcome(held, strict, flow):
    """Of a step, for `settle`: 1 when rows were held at its end, plus 2 when some were held and then needed."""
    return (1 if held else 0) + (2 if strict and flow.clock.held_steps >= 0.0 else 0)


@compiled
def free_gap(tables, h, options, flow, a):
    """Largest gap with which rows may be held in the present step; a : accelerations."""
    if flow.clock.held_steps >= PASSING or flow.clock.held_steps < 0.0:
        return CLOSED * options.length
    fast = 0.0
    for k in range(0, tables.sizes.n_q, 3):
        fast = max(fast, math.sqrt(a[k] ** 2 + a[k + 1] ** 2), options.length * abs(a[k + 2]))
    return CLOSED * options.length + ASIDE * min(h * h * fast, 0.01 * options.length)


@compiled
def settle(tables, lu, t, flow, trial, work, record):
    """After a good step: note the instant and the rows whose multipliers are not unique; take those of least norm.

    Every held row stands for a set of multipliers u without effect, G^T u = 0.  Where they are as many as the rows of
    trial.free, they are made orthonormal there and taken out of the multipliers.  `held_steps` of the clock counts the
    steps without a break in which more rows than these were held, or were needed after all; it becomes -1, for good, in
    a model whose rows are always needed: then only those are held whose pivot is lost.
    """
    held, needed = record.count.outcome % 2 == 1, record.count.outcome >= 2
    total = 0
    for place in range(trial.seen.shape[0]):
        if held and trial.seen[place] < 0.0:
            total += 1
    if needed and not held and flow.clock.held_steps >= PASSING:
        flow.clock.held_steps = -1.0
    elif flow.clock.held_steps >= 0.0:
        flow.clock.held_steps = flow.clock.held_steps + 1.0 if needed or total > trial.free.shape[0] else 0.0
    if held:
        if record.count.held_steps == 0:
            record.step.first_held = t
        record.count.held_steps += 1
        note_rows(tables.sizes.n_q, tables.sizes.n_c, lu, total == trial.free.shape[0], trial, work, record)


@compiled
def note_rows(n, m, lu, least, trial, work, record):
    """Note the rows whose multipliers are not unique; if `least`, take the multipliers of least norm."""
    found = 0
    for s in range(len(lu.starts) - 1):
        for k in range(lu.starts[s + 1] - lu.starts[s]):
            if trial.seen[lu.starts[s] + k] > 0.0:
                continue
            dependence(lu, work.lu, s, k, trial.b, trial.e, trial.y)
            largest = 0.0
            for i in range(m):
                largest = max(largest, abs(trial.e[n + i]))
            for i in range(m):
                if abs(trial.e[n + i]) > PART * largest:
                    record.held[i] = True
            if least:
                take_out(n, m, found, trial)
                found += 1


@compiled
def take_out(n, m, found, trial):
    """Make the forces in trial.e row `found` of the orthonormal trial.free; remove their part of the multipliers."""
    for k in range(2 * found):  # twice: round-off of the first time
        along = 0.0
        for i in range(m):
            along += trial.free[k % found, i] * trial.e[n + i]
        for i in range(m):
            trial.e[n + i] -= along * trial.free[k % found, i]
    square = 0.0
    for i in range(m):
        square += trial.e[n + i] * trial.e[n + i]
    part = 0.0
    for i in range(m):
        trial.free[found, i] = trial.e[n + i] / square**0.5
        part += trial.free[found, i] * trial.lam[i]
    for i in range(m):
        trial.lam[i] -= part * trial.free[found, i]
