"""Slip speed at which a friction law balances a load."""

import math
from collections.abc import Callable

from flexmb import checks
from flexmb.errors import InputError
from flexmb.model.law import FrictionLaw

SCANNED = 4000
"""Number of speeds at which a law is evaluated before bisection finds its balance with the load to round-off."""


def load_ratio(owner: str, value: object) -> float:
    """`value` as a load relative to mu_s N, >= 0; `owner` names the law in messages."""
    return checks.not_negative(owner, "load_ratio", value)


def static_not_below_kinetic(owner: str, static: float, kinetic: float) -> None:
    """Refuse a `static` coefficient below the `kinetic` one, and negative ones; `owner` names the law."""
    checks.not_negative(owner, "kinetic", kinetic)
    checks.not_negative(owner, "static", static)
    if static < kinetic:
        raise InputError(
            f"{owner}: static is {static:g}; it must be >= kinetic = {kinetic:g}. Did you exchange the two?"
        )


def first_balance(law: FrictionLaw, wanted: float, fastest: float) -> float:
    """The smallest slip speed [m/s], up to `fastest`, at which a law without history gives `wanted` N; else inf."""

    def balance(speed: float) -> float:
        force, _, _ = law.kernel.python(law.parameters(), 0.0, speed, 1.0, (), ())
        return float(-force - wanted)

    if wanted <= 0.0:
        return 0.0
    low = 0.0
    for k in range(1, SCANNED + 1):
        high = fastest * k / SCANNED
        if balance(high) >= 0.0:
            return _halved(balance, low, high)
        low = high
    return math.inf


def _halved(balance: Callable[[float], float], low: float, high: float) -> float:
    """Slip speed between `low` and `high` at which `balance` changes its sign."""
    for _ in range(200):
        middle = 0.5 * (low + high)
        if middle in (low, high):
            break
        if balance(middle) >= 0.0:
            high = middle
        else:
            low = middle
    return high
