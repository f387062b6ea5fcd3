"""Errors of Lyapunov exponents: what one record leaves open, and what a second run adds to it."""

from __future__ import annotations

import numpy as np

BLOCKS, FEWEST_BLOCKS = 20, 9
"""Blocks whose means are compared, and the fewest, of two entries each, in short records."""

POWER = 3.0
"""Neighbours that part like this power of time are told from none that part exponentially by nothing in the record."""

LATE = float(np.log(20.0 / 11.0))
"""Logarithm of the time at the end over that in the middle of a record whose first tenth was left out."""

LOGS = 4.0
"""Units of round-off of each logarithm, and of a number below 1; their sum has as many more as the root of their
number."""

WITHIN = 2.0
"""Two exponents that differ by less than this multiple of their errors do not differ."""


def error_of(logs: np.ndarray, times: np.ndarray) -> float:
    """One standard deviation of sum(logs) / sum(times), both (n,); NaN for too few entries or one that is not finite.

    The largest of four:

    - that of block averages (`block_error`): the fluctuations of a stationary motion;
    - the difference between the last half and the whole, where it is above twice that of the blocks: vectors that still
      turn, a motion that still changes;
    - round-off: 4 + sqrt(n) units of each logarithm, which add up at the worst;
    - the exponent itself, if over the last half neighbours part by no more than the third power of time makes, a factor
      of 6: log(t) / t is above zero in any finite record.

    Parameters
    ----------
    logs : logarithms of growth.
    times : how long each of them took.
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

    Twenty blocks (in short records fewer, of two entries) of equal numbers of entries make what is left of each block,
    the mean rate taken away, nearly independent.  What correlation r > 0 is left between neighbours makes the variance
    (1 + r) / (1 - r) times as large, as it is where correlations fall off as r^k.

    Parameters
    ----------
    logs, times : see `error_of`.
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


def combined(values: np.ndarray, errors: np.ndarray, others: np.ndarray, theirs: np.ndarray) -> np.ndarray:
    """Errors (k,) of exponents that a second run was made for.

    sqrt(s^2 + e^2): s the error of the record; e = |l - l'|, what the second run differs by, where that is above twice
    the errors of both, sqrt(s^2 + s'^2), else 0: its own fluctuations are no error of the first one.

    Parameters
    ----------
    values, errors : exponents l and errors s of the first run.
    others, theirs : l' and s' of the second one; what is not finite there adds nothing.
    """
    with np.errstate(invalid="ignore"):
        apart, both = np.abs(values - others), np.hypot(errors, np.nan_to_num(theirs))
    counts = np.isfinite(apart) & (apart > WITHIN * both)
    return np.asarray(np.hypot(errors, np.where(counts, apart, 0.0)))


def outgrown(value: float, span: float) -> float:
    """By how much an exponent is too large for a motion that stays on its cycle; 0: it may be right.

    Steps in time make round-off in every period, which may grow to the size of the motion, by 1/eps, in `span` at the
    soonest.  So an exponent above log(1/eps) / span contradicts the motion by what it lies above that.

    Parameters
    ----------
    value : the largest exponent.
    span : how long the motion was seen to stay on the cycle.
    """
    limit = -np.log(np.finfo(float).eps) / span if span > 0.0 else np.inf
    return float(max(value - limit, 0.0))
