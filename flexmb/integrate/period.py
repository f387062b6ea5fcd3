"""The common period of the drives."""

from __future__ import annotations

import math
from fractions import Fraction

from flexmb.errors import InputError
from flexmb.program.program import Program


def common_period(program: Program) -> float:
    """The shortest time after which all drives are where they were [s].

    Raises
    ------
    InputError : no periodic drive, or periods without a small common multiple.
    """
    known = [p for p in program.periods if p is not None]
    if not known:
        raise InputError(f"Mechanism {program.name!r} has no periodic drive; give t_end= instead of periods=.")
    base = known[0]
    turns = 1
    for period in known[1:]:
        ratio = Fraction(base / period).limit_denominator(64)
        if ratio == 0 or abs(float(ratio) - base / period) > 1e-9 * base / period:
            raise InputError(
                f"Mechanism {program.name!r}: the periods of its drives, {base:g} s and {period:g} s, "
                "have no small common multiple; give t_end= instead of periods=."
            )
        turns = math.lcm(turns, ratio.denominator)
    return base * turns
