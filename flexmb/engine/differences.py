"""Central differences in place of the derivatives of a law that returns its force alone: five calls of the law."""

from types import FunctionType
from typing import Any

DIFFERENCE = 6e-6  # difference of a number for the derivative of a force, by its size: the cube root of round-off
# Least differences of gaps [m], of gap rates and slips [m/s], of normal forces [N].
LEAST_GAP, LEAST_SPEED, LEAST_LOAD = 1e-16, 1e-9, 1e-12
force: Any = None  # the law, in the copies of the next two functions
Triple = tuple[float, float, float]


def _normal(p: Any, h: float, gap: float, gap_rate: float, z: Any, z_new: Any) -> Triple:
    """N of a law, and its derivatives; the value comes last, so that z_new is its own."""
    s, w = DIFFERENCE * abs(gap) + LEAST_GAP, DIFFERENCE * abs(gap_rate) + LEAST_SPEED
    shallow, deep, slow, fast = gap + s, gap - s, gap_rate - w, gap_rate + w
    by_gap = (force(p, h, shallow, gap_rate, z, z_new) - force(p, h, deep, gap_rate, z, z_new)) / (shallow - deep)
    by_rate = (force(p, h, gap, fast, z, z_new) - force(p, h, gap, slow, z, z_new)) / (fast - slow)
    return 1.0 * force(p, h, gap, gap_rate, z, z_new), by_gap, by_rate


def _friction(p: Any, h: float, slip: float, N: float, z: Any, z_new: Any) -> Triple:
    """T of a law, and its derivatives; normal forces stay >= 0."""
    w, s = DIFFERENCE * abs(slip) + LEAST_SPEED, DIFFERENCE * abs(N) + LEAST_LOAD
    slow, fast, light, heavy = slip - w, slip + w, max(N - s, 0.0), N + s
    by_slip = (force(p, h, fast, N, z, z_new) - force(p, h, slow, N, z, z_new)) / (fast - slow)
    by_load = (force(p, h, slip, heavy, z, z_new) - force(p, h, slip, light, z, z_new)) / (heavy - light)
    return 1.0 * force(p, h, slip, N, z, z_new), by_slip, by_load


# Functions of differences, by the name of the contract of a law.
BY_CONTRACT = {"normal": _normal, "friction": _friction}


def with_differences(contract: str, function: Any, law: Any) -> Any:
    """Force and derivatives of `law`: `function`, or its compiled form, beside which the machine code is kept."""
    template, place = BY_CONTRACT[contract], function.__code__
    code = template.__code__.replace(co_filename=place.co_filename, co_firstlineno=place.co_firstlineno)
    made = FunctionType(code, {**globals(), "force": law})
    made.__module__, made.__qualname__ = function.__module__, f"{function.__qualname__}.differences"
    return made
