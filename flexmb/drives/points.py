"""Checks of points in time that give a motion."""

from itertools import pairwise

from flexmb import checks
from flexmb.errors import InputError


def checked_points(owner: str, times: object, values: object, least: int) -> tuple[tuple[float, ...], ...]:
    """Times [s] and values as tuples of floats: `least` points at least, increasing times, finite values."""
    given = [checks.sequence(owner, name, x, "numbers") for name, x in (("times", times), ("values", values))]
    instants = tuple(checks.number(owner, f"times[{i}]", t, "s") for i, t in enumerate(given[0]))
    numbers = tuple(checks.number(owner, f"values[{i}]", v) for i, v in enumerate(given[1]))
    if len(instants) < least or len(instants) != len(numbers):
        raise InputError(
            f"{owner}: {len(instants)} times and {len(numbers)} values; give at least {least} of each, equally many."
        )
    if any(b <= a for a, b in pairwise(instants)):
        raise InputError(f"{owner}: times do not increase; sort them and remove duplicates.")
    return instants, numbers
