"""Grazing: signals sampled over an orbit, and the turning points of gaps nearest to contact."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flexmb import checks
from flexmb.dynamics.systems.dynamics import Dynamics
from flexmb.dynamics.systems.mechanism_flow import MechanismFlow

SAMPLES = 200
"""Default number of samples in a period."""

FINER = 32
"""Number of samples in each of the two refinements of a minimum."""

SHARP = 0.3
"""Ratio of the rises beside a minimum in both refinements above which the minimum is an impact."""

PENETRATION = "penetration"


def gap_signals(system: Dynamics, asked: str | None, label: str) -> dict[str, tuple[int, float]]:
    """Number and sign of the signals that measure gaps (> 0: open), by name; None: signals of all contacts."""
    if asked is not None:
        return {asked: (system.names.index(checks.one_of(label, "grazing", asked, system.names)), 1.0)}
    if not isinstance(system, MechanismFlow):
        return {}
    wanted = [f"{contact}.{PENETRATION}" for contact in system.program.names.contacts]
    return {name: (system.names.index(name), -1.0) for name in wanted if name in system.names}


def sampled(system: Dynamics, duration: float, count: int) -> tuple[np.ndarray, np.ndarray, list[np.ndarray]]:
    """Times (n,), signals (n, names) and states from the present state on; `count` + 1 of them, fewer after a failure.

    The duration is in seconds or iterations; a map gives every iteration.
    """
    flow = system.unit == "s"
    count = count if flow else round(duration)
    begin = system.time
    times, values, states = [begin], [system.observe()], [system.state()]
    for k in range(count):
        ahead = begin + duration * (k + 1) / count - system.time
        if not system.advance(ahead if flow else 1):
            break
        times.append(begin + duration * (k + 1) / count)
        values.append(system.observe())
        states.append(system.state())
    return np.array(times), np.array(values), states


def closest_approaches(
    system: Dynamics,
    gaps: dict[str, tuple[int, float]],
    orbit: tuple[np.ndarray, np.ndarray, Sequence[np.ndarray]],
) -> dict[str, tuple[float, float, int]]:
    """For each gap on an orbit: its turning point nearest to 0 [m], its travel [m], and the number of its closures.

    > 0: the surfaces just miss each other; < 0: they just touch.  Turning points are located between the samples.
    Sharp minima, as at rebounds of rigid surfaces, do not count; NaN: no turning point.  The system is advanced;
    `orbit` is a result of `sampled`.
    """
    times, values, states = orbit
    approaches = {}
    for name, (place, sign) in gaps.items():
        gap = sign * values[:, place]
        nearest, closures = np.nan, 0
        for k in range(1, len(gap)):
            next_value = gap[k + 1] if k + 1 < len(gap) else gap[1]  # the orbit is closed
            if not (gap[k] <= gap[k - 1] and gap[k] < next_value):
                continue
            rise = max(gap[k - 1], next_value) - gap[k]
            if not np.isnan(nearest) and abs(gap[k]) - rise > abs(nearest):
                closures += int(gap[k] < 0.0)
                continue  # no smaller turning point is possible here
            least = _turning_point(system, (times[k - 1], 2.0 * times[k] - times[k - 1]), states[k - 1], place, sign)
            closures += int(not least > 0.0)  # a sharp one is an impact
            if not np.isnan(least) and (np.isnan(nearest) or abs(least) < abs(nearest)):
                nearest = least
        approaches[name] = (float(nearest), float(np.ptp(gap)), closures)
    return approaches


def _turning_point(system: Dynamics, span: tuple[float, float], state: np.ndarray, place: int, sign: float) -> float:
    """Smallest gap in a short time span from a state; NaN for a sharp minimum."""
    slopes, least = [], np.nan
    for _ in range(2):
        system.reset(state, time=span[0])
        times, values, states = sampled(system, span[1] - span[0], FINER)
        if len(times) <= FINER:
            return np.nan
        gap = sign * values[:, place]
        k = min(max(int(gap.argmin()), 1), FINER - 1)
        least = float(gap[k])
        slopes.append(max(gap[k - 1], gap[k + 1]) - least)
        state, span = states[k - 1], (times[k - 1], times[k + 1])
    # spans shrink by FINER/2: the rise beside a smooth minimum shrinks by the square of this, beside an edge by FINER/2
    return np.nan if slopes[1] > SHARP * slopes[0] / (FINER / 2.0) else least
