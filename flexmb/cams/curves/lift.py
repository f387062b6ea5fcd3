"""Lift law of a follower over a turn of its cam."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from flexmb import arguments, checks
from flexmb.display.shown import Shown
from flexmb.errors import InputError

ORDERS = 5
"""Number of derivatives of a lift, from the lift itself on."""

POLYNOMIALS = {"3-4-5": (0.0, 0.0, 0.0, 10.0, -15.0, 6.0), "4-5-6-7": (0.0, 0.0, 0.0, 0.0, 35.0, -84.0, 70.0, -20.0)}
"""Coefficients of the normalised laws x(u), from the constant on."""

LAWS = ("cycloidal", *POLYNOMIALS, "harmonic")
"""Names of the laws."""


@dataclass(frozen=True)
class Lift(arguments.Checked, Shown):
    """Lift of a follower over the cam angle: stations, joined by a law of rise and fall.

    Parameters
    ----------
    stations : (angle, lift) with increasing cam angles [rad] within a turn and lifts [m, or rad of an oscillating
        follower]; equal lifts of neighbours are a dwell.  The last station is followed by the first one, a turn later.
    law : "cycloidal", u - sin(2 pi u)/(2 pi); "3-4-5" or "4-5-6-7", polynomials with these powers; "harmonic",
        (1 - cos(pi u))/2, whose acceleration jumps at dwells.

    Raises
    ------
    InputError : fewer than two stations, angles that do not increase or span a turn, an unknown law.

    Notes
    -----
    Source: R. L. Norton, Cam Design and Manufacturing Handbook, 2nd ed., Industrial Press 2009, ch. 2 and 3.

    Examples
    --------
    >>> lift = Lift(((0.0, 0.0), (1.0, 0.01), (2.0, 0.01), (3.0, 0.0)), law="cycloidal")
    >>> lift.at(0.5)[0]
    0.005
    """

    stations: tuple[tuple[float, float], ...]
    law: str = "cycloidal"

    def __post_init__(self) -> None:
        given = checks.sequence("Lift", "stations", self.stations, "pairs (angle, lift)")
        stations = tuple(checks.point("Lift", f"stations[{k}]", s, "rad and m") for k, s in enumerate(given))
        checks.one_of("Lift", "law", self.law, LAWS)
        if len(stations) < 2:
            raise InputError(f"Lift: {len(stations)} stations; give at least two, e.g. ((0.0, 0.0), (1.0, 0.01)).")
        angles = [angle for angle, _ in stations]
        for k, (before, after) in enumerate(pairwise([*angles, angles[0] + 2.0 * math.pi])):
            if after <= before:
                raise InputError(
                    f"Lift: the angle of station {k} is {before:g} rad and that of the next one {after:g} rad; angles "
                    "must increase and span less than a turn (2 pi) in all."
                )
        object.__setattr__(self, "stations", stations)

    def intervals(self) -> list[tuple[float, float, float, float]]:
        """Angles at both ends [rad] and lifts at both ends of each interval."""
        (first, lift), turn = self.stations[0], 2.0 * math.pi
        return [(a, b, s, e) for (a, s), (b, e) in pairwise([*self.stations, (first + turn, lift)])]

    def at(self, angle: float) -> tuple[float, float, float]:
        """Lift and two derivatives by the cam angle [m, m/rad, m/rad^2]."""
        first = self.stations[0][0]
        inside = first + (checks.number("Lift", "angle", angle, "rad") - first) % (2.0 * math.pi)
        piece = next((p for p in self.intervals() if inside <= p[1]), self.intervals()[-1])
        values = self.derivatives(piece, np.array([inside]))
        return float(values[0, 0]), float(values[1, 0]), float(values[2, 0])

    def derivatives(self, piece: Any, angles: np.ndarray) -> np.ndarray:
        """Lift and its derivatives (ORDERS, n) at `angles` [rad] within an interval.

        Parameters
        ----------
        piece : angles and lifts at both ends of the interval.
        angles : (n,) cam angles [rad].
        """
        begin, end, low, high = piece
        span = end - begin
        found: np.ndarray = (high - low) * normalised(self.law, (angles - begin) / span)
        found /= span ** np.arange(ORDERS)[:, None]
        found[0] += low
        return found


def normalised(law: str, u: np.ndarray) -> np.ndarray:
    """A law from 0 to 1 over u from 0 to 1, and its derivatives (ORDERS, n)."""
    if law in POLYNOMIALS:
        return np.array(
            [
                sum(c * math.perm(k, order) * u ** (k - order) for k, c in enumerate(POLYNOMIALS[law]) if k >= order)
                for order in range(ORDERS)
            ]
        )
    turn = math.pi if law == "harmonic" else 2.0 * math.pi
    waves = [turn**order * np.sin(turn * u + 0.5 * math.pi * order) for order in range(ORDERS)]
    if law == "harmonic":
        cosines = [-0.5 * turn**order * np.sin(turn * u + 0.5 * math.pi * (order + 1)) for order in range(ORDERS)]
        cosines[0] = cosines[0] + 0.5
        return np.array(cosines)
    found = [-wave / turn for wave in waves]
    found[0] = found[0] + u
    found[1] = found[1] + 1.0
    return np.array(found)
