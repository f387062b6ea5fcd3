"""Meaning of exponents and of the evidence of a verdict in words, for tables."""

from __future__ import annotations

import numpy as np

MEANING = {
    "zero_one": "0-1 test: 0 regular, 1 chaotic",
    "separation": "separation of neighbours: 0 stay together, 1 part",
    "k": "points of the cycle",
    "since": "first point on the cycle",
    "shrink": "factor by which steps shrink from point to point",
    "level": "change of the means between the halves, in deviations",
    "loudness": "change of the deviations between the halves",
    "swelling": "change of the amplitude, first to last quarter",
    "drift": "step by which a signal moves on from point to point",
    "doublings": "doublings of the bands, as far as the points can show",
    "bands": "parts of the section that are visited in turn",
    "signals": "signals on which the verdict rests",
    "points": "points, one a period",
}
"""Meaning of the evidence of a verdict, by name."""


def meaning_of(value: float, error: float, period: float) -> str:
    """Meaning of an exponent [1/s] with an error (NaN: unknown), in words; `period` [s] lies between two points."""
    if not np.isfinite(value):
        return "none was found"
    if not np.isfinite(error):
        return "without an error: take more periods"
    if abs(value) <= error:
        return "zero within its error: neighbours keep their distance"
    time = 1.0 / abs(value)
    length = f"a factor e in {time:.3g} s ({time / period:.3g} periods)"
    return f"neighbours part by {length}" if value > 0.0 else f"neighbours come nearer by {length}"
