"""The common period of the drives."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np

from flexmb.errors import InputError
from flexmb.program.program import Program


def common_period(program: Program) -> float:
    """The shortest time after which all drives are where they were [s]; refused where there is none."""
    known = [p for p in program.periods if p is not None]
    if not known:
        raise InputError(f"Mechanism {program.name!r} has no periodic drive; give t_end= instead of periods=.")
    apart = clash(program)
    if apart is not None:
        raise InputError(
            f"Mechanism {program.name!r}: the periods of its drives, {apart[0]:g} s and {apart[1]:g} s, "
            "have no small common multiple; give t_end= instead of periods=."
        )
    return known[0] * math.lcm(*(_ratio(known[0], period).denominator for period in known))


def clash(program: Program) -> tuple[float, float] | None:
    """Two periods of drives without a small common multiple [s], or None."""
    known = [p for p in program.periods if p is not None]
    for period in known[1:]:
        ratio = known[0] / period
        near = _ratio(known[0], period)
        if near == 0 or abs(float(near) - ratio) > 1e-9 * ratio:
            return known[0], period
    return None


def _ratio(first: float, second: float) -> Fraction:
    """The fraction of small numbers nearest to the ratio of two periods."""
    return Fraction(first / second).limit_denominator(64)


def just_before(instant: float) -> float:
    """Instant before `instant` by a few units of round-off; `t + h` cannot round beyond it."""
    return float(instant - 4.0 * np.spacing(instant))
