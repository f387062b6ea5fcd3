"""Reaction of the ideal joint P1 over a turn, and the speeds at which the reaction passes through zero."""

from __future__ import annotations

import itertools
import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from nine_bar_study.case import Case
from nine_bar_study.run import StudyRun

from flexmb.statics.inverse_dynamics import inverse_dynamics

if TYPE_CHECKING:
    import xarray as xr

SPEEDS = (1.0, 2.0)
"""Two speeds over pi [rad/s] that determine the static and the dynamic part."""

POINTS = 240
FINER = 20
"""Intervals between two points in the search for sign changes, by the trigonometric series."""

ROUNDING = 1e-12
"""Zero of a cross product, relative to the largest cross product."""


class Crossing(NamedTuple):
    """Speed at which the reaction is zero at an instant of the turn.

    Parameters
    ----------
    speed : over pi [rad/s].
    angle : angle of crank 4 at the instant, from the start [rad].
    """

    speed: float
    angle: float


def reaction(case: Case, points: int = POINTS) -> StudyRun:
    """Run of the static and the dynamic part of the reaction at P1 of the ideal mechanism.

    The cranks turn at the constant speed w.  The reaction is F = S + w^2 D at each angle of the cranks.  S balances the
    weight, and w^2 D the inertia of the bodies.
    """
    name = "reaction" + (f"-{case.label}" if case.label else "") + ("" if points == POINTS else f"-{points}")
    return StudyRun(name, measure_reaction, case, (("points", points),), 0.003 * len(SPEEDS) * points)


def measure_reaction(case: Case, *, points: int) -> xr.Dataset:
    """Static and dynamic part of the reaction at P1, by inverse dynamics.

    Returns
    -------
    xarray.Dataset : over "angle" (angle of crank 4 from the start [rad]) and "axis" (x, y): `static` [N] and `dynamic`
        [N s^2].
    """
    import dataclasses

    import xarray

    angle = np.arange(points) * (2.0 * math.pi / points)
    force = []
    for speed in SPEEDS:
        mechanism = dataclasses.replace(case, model="ideal", speed=speed).mechanism()
        force.append(inverse_dynamics(mechanism, angle / (math.pi * speed)).forces["P1"][:, :2])
    squares = [(math.pi * speed) ** 2 for speed in SPEEDS]
    dynamic = (force[1] - force[0]) / (squares[1] - squares[0])
    columns = {
        "static": (("angle", "axis"), force[0] - squares[0] * dynamic, {"units": "N"}),
        "dynamic": (("angle", "axis"), dynamic, {"units": "N s^2"}),
    }
    axes = {"angle": ("angle", angle, {"units": "rad"}), "axis": ["x", "y"]}
    return xarray.Dataset(columns, coords=axes, attrs={"case": case.name})


def crossings(static: np.ndarray, dynamic: np.ndarray) -> list[Crossing]:
    """Speeds w at which S + w^2 D = 0 at an angle of the turn, ascending.

    The hodograph of the reaction runs through the origin at isolated speeds.  At these speeds S and D are parallel,
    S x D = 0, and opposed, S . D < 0, and w^2 = |S| / |D|.  The zeros of the trigonometric series of the cross product
    are computed to round-off.

    Parameters
    ----------
    static, dynamic : (n, 2) S [N] and D [N s^2] at n evenly spaced angles of a turn.
    """
    from scipy.optimize import brentq

    coefficients = np.fft.rfft(np.hstack([static, dynamic]), axis=0)
    count = len(static)

    def at(angle: float) -> np.ndarray:
        values: np.ndarray = _series(coefficients, count, np.array([angle]))[0]
        return values

    def cross(angle: float) -> float:
        sx, sy, dx, dy = at(angle)
        return float(sx * dy - sy * dx)

    values = _finer(np.hstack([static, dynamic]), FINER)
    product = values[:, 0] * values[:, 3] - values[:, 1] * values[:, 2]
    product[np.abs(product) <= ROUNDING * np.abs(product).max()] = 0.0
    fine = np.linspace(0.0, 2.0 * math.pi, len(values) + 1)
    angles = [float(fine[k]) for k in np.flatnonzero(product == 0.0)]
    changes = np.flatnonzero(product * np.roll(product, -1) < 0.0)
    angles.extend(brentq(cross, fine[k], fine[k + 1], xtol=1e-13) for k in changes)
    found = []
    for angle in angles:
        sx, sy, dx, dy = at(angle)
        if sx * dx + sy * dy < 0.0:
            found.append(Crossing(math.sqrt(math.hypot(sx, sy) / math.hypot(dx, dy)) / math.pi, angle))
    return sorted(found)


def _series(coefficients: np.ndarray, count: int, angles: np.ndarray) -> np.ndarray:
    """Values (k, m) of a trigonometric series of n points at angles (k,), from coefficients (n // 2 + 1, m)."""
    orders = np.arange(len(coefficients))
    weight = np.where((orders == 0) | (2 * orders == count), 1.0, 2.0) / count
    return np.real(np.exp(1j * np.outer(angles, orders)) @ (weight[:, None] * coefficients))


class Turning(NamedTuple):
    """Reaction over one turn at one speed.

    Parameters
    ----------
    least : smallest reaction in the turn [N].
    angle : angle of crank 4 at the smallest reaction [rad].
    turns : revolutions of the direction of the reaction in a turn, counter-clockwise positive.
    swing : range of the continuous direction of the reaction in the turn [rad].
    fastest : largest derivative of the direction by the angle of the crank [rad/rad].
    """

    least: float
    angle: float
    turns: int
    swing: float
    fastest: float


def turning(static: np.ndarray, dynamic: np.ndarray, speed: float) -> Turning:
    """Smallest reaction in a turn, and rotation of its direction.

    Parameters
    ----------
    static, dynamic : (n, 2) S [N] and D [N s^2] at n evenly spaced angles of a turn.
    speed : over pi [rad/s].
    """
    force = static + (math.pi * speed) ** 2 * dynamic
    fine = _finer(force, 5 * FINER)
    angles = np.arange(len(fine)) * (2.0 * math.pi / len(fine))
    size = np.hypot(*fine.T)
    direction = np.unwrap(np.arctan2(fine[:, 1], fine[:, 0]), period=2.0 * math.pi)
    closed = np.append(direction, direction[-1] + _wrapped(direction[0] - direction[-1]))
    change = np.diff(closed) / (angles[1] - angles[0])
    k = int(size.argmin())
    turns = round((closed[-1] - closed[0]) / (2.0 * math.pi))
    return Turning(float(size[k]), float(angles[k]), turns, float(np.ptp(closed)), float(np.abs(change).max()))


def reversal(static: np.ndarray, dynamic: np.ndarray, highest: float = 4.0) -> float:
    """Smallest speed over pi [rad/s] at which the reaction reverses its direction in the turn; NaN without a reversal.

    At the reversal the component of the reaction along its mean over the turn is zero at one angle.  Above this speed
    the journal cannot stay on one side of the bearing.  The component across the mean may be different from zero.

    Parameters
    ----------
    static, dynamic : (n, 2) S [N] and D [N s^2] at n evenly spaced angles of a turn.
    highest : upper limit of the search, over pi [rad/s].
    """
    from scipy.optimize import brentq

    fine = _finer(np.hstack([static, dynamic]), FINER)

    def least(speed: float) -> float:
        force = fine[:, :2] + (math.pi * speed) ** 2 * fine[:, 2:]
        mean = force.mean(axis=0)
        return float((force @ mean).min() / math.hypot(*mean))

    speeds = np.linspace(0.25, highest, round((highest - 0.25) / 0.05) + 1)
    for low, high in itertools.pairwise(speeds):
        if least(low) > 0.0 >= least(high):
            return float(brentq(least, low, high, xtol=1e-9))
    return math.nan


def _finer(values: np.ndarray, factor: int) -> np.ndarray:
    """Values (factor n, m) of the trigonometric series of (n, m) values."""
    coefficients, count = np.fft.rfft(values, axis=0), len(values)
    if count % 2 == 0:
        coefficients[-1] *= 0.5
    return factor * np.fft.irfft(coefficients, n=factor * count, axis=0)


def _wrapped(angle: float) -> float:
    return math.remainder(angle, 2.0 * math.pi)
