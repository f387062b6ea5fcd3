"""Signals over an orbit, and how closely surfaces come to touching on it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flexmb import checks
from flexmb.dynamics.systems.dynamics import Dynamics
from flexmb.dynamics.systems.mechanism_flow import MechanismFlow

SAMPLES = 200
"""Of a period, where nothing else is asked for."""

FINER = 32
"""A minimum between samples is looked for at so many points, twice."""

SHARP = 0.3
"""A minimum whose slopes do not fall when it is seen FINER times closer is an impact, not a turning point."""

PENETRATION = "penetration"


def gap_signals(system: Dynamics, asked: str | None, label: str) -> dict[str, tuple[int, float]]:
    """Place and sign of the signals that tell a gap (> 0: open), by name; of a mechanism those of all its contacts."""
    if asked is not None:
        return {asked: (system.names.index(checks.one_of(label, "grazing", asked, system.names)), 1.0)}
    if not isinstance(system, MechanismFlow):
        return {}
    wanted = [f"{contact}.{PENETRATION}" for contact in system.program.names.contacts]
    return {name: (system.names.index(name), -1.0) for name in wanted if name in system.names}


def sampled(system: Dynamics, duration: float, count: int) -> tuple[np.ndarray, np.ndarray, list[np.ndarray]]:
    """Times (n,), signals (n, names) and states from here on, `count` + 1 of them, fewer if it cannot go on.

    Maps give each iteration.
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
    """Of each gap on a sampled orbit: its turning point nearest to 0 [m], its travel [m], and how often it closes.

    > 0: the surfaces just miss each other there; < 0: they just touch.  Turning points are looked for between the
    samples.  Sharp minima, rebounds of surfaces that do not yield, are left out; NaN where no other one is found.
    """
    times, values, states = orbit
    found = {}
    for name, (place, sign) in gaps.items():
        gap = sign * values[:, place]
        best, touches = np.nan, 0
        for k in range(1, len(gap)):
            following = gap[k + 1] if k + 1 < len(gap) else gap[1]  # it begins anew
            if not (gap[k] <= gap[k - 1] and gap[k] < following):
                continue
            room = max(gap[k - 1], following) - gap[k]
            if not np.isnan(best) and abs(gap[k]) - room > abs(best):
                touches += int(gap[k] < 0.0)
                continue  # it cannot come nearer
            least = _turning_point(system, (times[k - 1], 2.0 * times[k] - times[k - 1]), states[k - 1], place, sign)
            touches += int(not least > 0.0)  # a sharp one is an impact
            if not np.isnan(least) and (np.isnan(best) or abs(least) < abs(best)):
                best = least
        found[name] = (float(best), float(np.ptp(gap)), touches)
    return found


def _turning_point(system: Dynamics, span: tuple[float, float], state: np.ndarray, place: int, sign: float) -> float:
    """The smallest gap in a short span that begins with that state; NaN if it is a sharp one."""
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
    # spans shrink by FINER/2: the rise beside a parabola's minimum by the square of that, beside an edge by it alone
    return np.nan if slopes[1] > SHARP * slopes[0] / (FINER / 2.0) else least
