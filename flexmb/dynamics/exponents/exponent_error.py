"""Errors of Lyapunov exponents: the error of one record, and the difference of a second run."""

from __future__ import annotations

import numpy as np

BLOCKS, FEWEST_BLOCKS = 20, 9
"""Number of blocks whose means are compared; the smallest number of blocks, of two entries each, in short records."""

POWER = 3.0
"""Exponent of the power of time up to which algebraic growth of distances is not taken for exponential growth."""

LATE = float(np.log(20.0 / 11.0))
"""Logarithm of the ratio of the times at the end and in the middle of a record whose first tenth was left out."""

LOGS = 4.0
"""Round-off of each logarithm, in units of round-off of a number near 1; sqrt(n) units are added for a sum of n."""

WITHIN = 2.0
"""Multiple of the error up to which two exponents count as equal."""


def error_of(logs: np.ndarray, times: np.ndarray) -> float:
    """Standard deviation of sum(logs) / sum(times), both (n,); NaN for too few entries or an entry that is not finite.

    The largest of four errors:

    - the error of block averages (`block_error`): fluctuations of a stationary motion;
    - the difference between the last half and the whole record, if it exceeds twice the error of the blocks: vectors
      that still turn, or a motion that still changes;
    - round-off: 4 + sqrt(n) units of each logarithm, added up;
    - the exponent itself, if neighbours part over the last half by no more than the third power of time (a factor of
      6): log(t) / t is above zero in any finite record.

    `logs` are logarithms of growth, `times` the durations of the growth.
    """
    blocks = block_error(logs, times)
    if not np.isfinite(blocks):
        return float("nan")
    value, half = logs.sum() / times.sum(), len(logs) // 2
    late = float(logs[half:].sum())
    changed = abs(late / times[half:].sum() - value)
    unit = (LOGS + np.sqrt(len(logs))) * np.finfo(float).eps
    round_off = unit * np.maximum(np.abs(logs), 1.0).sum() / times.sum()
    algebraic = value + round_off if value > 0.0 and late <= POWER * LATE else 0.0
    return float(max(blocks, changed if changed > WITHIN * blocks else 0.0, round_off, algebraic))


def block_error(logs: np.ndarray, times: np.ndarray) -> float:
    """Standard deviation of sum(logs) / sum(times), both (n,), from blocks; NaN below 18 entries.

    Twenty blocks of equal numbers of entries (fewer blocks, of two entries, in short records).  The deviations of their
    sums from the mean rate are nearly independent.  A correlation r > 0 between neighbouring blocks increases the
    variance by (1 + r) / (1 - r), the factor for correlations that decay as r^k.

    Equation (9.5) of docs/theory/exponents.md.
    """
    count = min(BLOCKS, len(logs) // 2)
    if count < FEWEST_BLOCKS or not np.isfinite(logs).all():
        return float("nan")
    size = len(logs) // count
    n = size * count
    logs, times = logs[-n:], times[-n:]
    rest = (logs - logs.sum() / times.sum() * times).reshape(count, size).sum(axis=1)
    spread = float(rest @ rest)
    r = float(rest[1:] @ rest[:-1]) / spread if spread > 0.0 else 0.0
    wider = (1.0 + r) / (1.0 - r) if r > 0.0 else 1.0
    return float(np.sqrt(wider * spread * count / (count - 1.0)) / times.sum())


def combined(values: np.ndarray, errors: np.ndarray, others: np.ndarray, other_errors: np.ndarray) -> np.ndarray:
    """Errors (k,) of exponents l with errors s after a second run with exponents l' and errors s'.

    sqrt(s^2 + e^2), with the error s of the record and the difference e = |l - l'| of both runs.  e counts only if it
    exceeds twice the errors of both, sqrt(s^2 + s'^2): fluctuations of the second run are no error of the first one.

    Equation (9.6) of docs/theory/exponents.md.  Entries of the second run that are not finite add nothing.
    """
    with np.errstate(invalid="ignore"):
        difference, both = np.abs(values - others), np.hypot(errors, np.nan_to_num(other_errors))
    counts = np.isfinite(difference) & (difference > WITHIN * both)
    return np.asarray(np.hypot(errors, np.where(counts, difference, 0.0)))


def outgrown(value: float, span: float) -> float:
    """Excess of an exponent over the largest one that agrees with a stay of `span` on a cycle; 0: the exponent agrees.

    Every period of the motion adds round-off, which grows to the size of the motion, by a factor 1/eps, within `span`
    at the soonest.  An exponent above log(1/eps) / span therefore contradicts the motion.

    Equation (9.7) of docs/theory/exponents.md.
    """
    limit = -np.log(np.finfo(float).eps) / span if span > 0.0 else np.inf
    return float(max(value - limit, 0.0))
