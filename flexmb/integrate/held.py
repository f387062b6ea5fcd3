"""Joints that repeat one another, at a singular position or always: what a step with held rows leaves behind."""

from flexmb.kernels import compiled
from flexmb.solve.lu import dependence

CLOSED = 1e-10
"""Gap of a row that may be held, relative to the size of the mechanism."""

PART = 1e-3
"""Entry of a vector of multipliers without effect, relative to its largest, above which its joint has part in it."""


@compiled
def keep_held(lu, n, m, t, trial, work, record):
    """Note the instant, and the rows whose multipliers are not unique; take the multipliers of least norm.

    Every held row stands for a set of multipliers u without effect, G^T u = 0.  As many of them as trial.free has rows,
    made orthonormal there, are taken out of the multipliers.
    """
    if record.count[7] == 0:
        record.extreme[6] = t
    record.count[7] += 1
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
            if found < trial.free.shape[0]:
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
