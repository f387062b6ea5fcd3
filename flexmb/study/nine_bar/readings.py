"""Units in which exponents that are printed without one may be meant."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from flexmb.study.samples import SAMPLES

NEAR = 2.0
"""Factor within which values count as comparable."""

READINGS: dict[str, Callable[[float], float]] = {
    "1/s": lambda period: 1.0,
    "bit/s (base 2)": lambda period: math.log(2.0),
    "a period": lambda period: 1.0 / period,
    "a period, base 2": lambda period: math.log(2.0) / period,
    f"a sample of {SAMPLES} a period": lambda period: SAMPLES / period,
    f"a sample of {SAMPLES} a period, base 2": lambda period: SAMPLES * math.log(2.0) / period,
}
"""From the period [s] what a printed value must be multiplied with to be in 1/s, base e."""

Ratios = dict[str, tuple[list[float], list[float]]]
"""By reading: of printed values over exponents of systems, and over estimates."""


def ratios(cases: Sequence[Sequence[tuple[float, float, float, float]]]) -> Ratios:
    """Printed values over ours, for each reading.

    Parameters
    ----------
    cases : for each case rows of (printed value, period [s], exponent of the system [1/s], estimate [1/s]).
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
    """Readings in which all printed values are within a factor 2 of one kind of ours.

    Parameters
    ----------
    found : of `ratios`.
    """
    return [
        reading
        for reading, kinds in found.items()
        if any(kind and all(1.0 / NEAR <= ratio <= NEAR for ratio in kind) for kind in kinds)
    ]
