"""Possible units of exponents that are published without a unit."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from nine_bar_study.samples import SAMPLES

NEAR = 2.0
"""Largest ratio of comparable values."""

READINGS: dict[str, Callable[[float], float]] = {
    "1/s": lambda period: 1.0,
    "bit/s (base 2)": lambda period: math.log(2.0),
    "a period": lambda period: 1.0 / period,
    "a period, base 2": lambda period: math.log(2.0) / period,
    f"a sample of {SAMPLES} a period": lambda period: SAMPLES / period,
    f"a sample of {SAMPLES} a period, base 2": lambda period: SAMPLES * math.log(2.0) / period,
}
"""Functions of the period [s] that return the factor from a unit to 1/s, base e, by unit."""

Ratios = dict[str, tuple[list[float], list[float]]]
"""Ratios of published values to exponents of the system, and to estimates, by unit."""


def ratios(cases: Sequence[Sequence[tuple[float, float, float, float]]]) -> Ratios:
    """Ratios of published to computed exponents for each unit.

    Parameters
    ----------
    cases : rows (published value, period [s], exponent of the system [1/s], estimate [1/s]) of each case.
    """
    rows = [row for case in cases for row in case]
    return {
        reading: (
            [value * factor(period) / system for value, period, system, _ in rows],
            [value * factor(period) / estimate for value, period, _, estimate in rows if math.isfinite(estimate)],
        )
        for reading, factor in READINGS.items()
    }


def comparable(found: Ratios) -> list[str]:
    """Units in which all ratios to the exponents of the system, or to the estimates, are from 0.5 to 2."""
    return [
        reading
        for reading, kinds in found.items()
        if any(kind and all(1.0 / NEAR <= ratio <= NEAR for ratio in kind) for kind in kinds)
    ]
