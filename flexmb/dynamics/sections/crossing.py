"""Where a height over a level changes its sign: found within a step of a flow, to round-off."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmb.dynamics.systems.continuous_flow import ContinuousFlow

ROUNDS = 200
HALVINGS = 40
DOWN, UP = -1, 1
CLOSE = 0.1
"""Part of the lower end of a step below which its cubic must dip to be looked at more closely; it is not the flow."""


@dataclass(frozen=True)
class Bracket:
    """A crossing lies between two times after a snapshot.

    Parameters
    ----------
    before : snapshot of the flow at its step's begin.
    tangents : (size, k) tangent vectors there, or None.
    near, value : time after it [s] at which the height is on its old side, and the height there.
    far : time after it [s] at which the height is on the other side.
    """

    before: Any
    tangents: np.ndarray | None
    near: float
    value: float
    far: float


@dataclass
class Height:
    """A height over a level, and the side on which it is.

    Parameters
    ----------
    flow : the flow.
    value : the height of the flow's present state.
    rate : its rate [1/s], or None where that costs too much; then a touch between two steps may be missed.
    side : UP or DOWN.
    """

    flow: ContinuousFlow
    value: Callable[[], float]
    rate: Callable[[], float] | None
    side: int

    def at(self, before: Any, duration: float) -> float:
        """The height some time after a snapshot; the flow stands there."""
        self.flow.restore(before)
        self.flow.advance(duration)
        return self.value()

    def left(self, value: float) -> bool:
        """Whether a height is on the other side; one that lies on the level is not."""
        return value * self.side < 0.0


def stride(height: Height, limit: float, tangents: np.ndarray | None) -> Bracket | None:
    """Take one step of the flow; where in it the height leaves its side, or None.

    A step whose ends lie on the same side is looked at more closely if the cubic through heights and rates at its ends
    comes near the level in between.  If the flow could not go on, it says so itself.
    """
    flow, kept = height.flow, None if tangents is None else tangents.copy()
    before, start, old = flow.snapshot(), flow.time, height.value()
    was = None if height.rate is None else height.rate()
    if not flow.take_step(limit, tangents):
        return None
    size, new = flow.time - start, height.value()
    if height.left(new):
        near = _still_there(height, before, size) if height.left(old) else (0.0, old)
        return Bracket(before, kept, *near, size)
    dip = None
    if height.rate is not None and was is not None and not height.left(old):
        side = height.side
        dip = turning_point(side * old, side * was, side * new, side * height.rate(), size)
    if dip is None:
        return None
    after = flow.snapshot()
    inside = height.at(before, dip)
    flow.restore(after)
    return Bracket(before, kept, 0.0, old, dip) if height.left(inside) else None


def locate(height: Height, bracket: Bracket) -> float:
    """Put the flow on the crossing; the time from the snapshot to there [s].

    It is the first time beyond the crossing that the flow's clock can tell.  Regula falsi as in Illinois, with
    bisection every fourth time (M. Dowell, P. Jarratt, BIT 11 (1971) 168); each trial is a step of the flow from the
    snapshot, so what is found is a point of the flow and not of an interpolation.
    """
    flow, before = height.flow, bracket.before
    flow.restore(before)
    a, b, fa = bracket.near, bracket.far, bracket.value
    least = 4.0 * float(np.spacing(abs(flow.time) + b))
    fb, kept = height.at(before, b), 0
    for count in range(ROUNDS):
        if height.left(fb) or not flow.ok:
            break  # a step with tangent vectors may have come a little further than the one without
        b += 2.0**count * max(1e-9 * bracket.far, least)
        fb = height.at(before, b)
    for count in range(ROUNDS):
        if b - a <= least or b <= flow.shortest or not flow.ok:
            break
        x = 0.5 * (a + b) if count % 4 == 3 or fa == fb else b - fb * (b - a) / (fb - fa)
        x = min(max(x, a + 0.5 * least, flow.shortest), b - 0.5 * least)
        value = height.at(before, x)
        if height.left(value):
            b, fb, fa, kept = x, value, 0.5 * fa if kept == DOWN else fa, DOWN
        else:
            a, fa, fb, kept = x, value, 0.5 * fb if kept == UP else fb, UP
    if flow.ok:
        height.at(before, b)
    return b


def carry(flow: ContinuousFlow, bracket: Bracket, duration: float, tangents: np.ndarray) -> None:
    """Bring `tangents` from the bracket's snapshot to where the flow stands, `duration` [s] later."""
    point = flow.snapshot()
    tangents[:] = bracket.tangents
    flow.restore(bracket.before)
    if flow.advance(duration, tangents):
        flow.restore(point)


def turning_point(f0: float, r0: float, f1: float, r1: float, size: float) -> float | None:
    """Where the cubic with these heights > 0 and rates at the ends of a step is lowest, if that is near the level."""
    if not r0 < 0.0 < r1:
        return None
    # f(s) = f0 + r0 s + c s^2 + d s^3
    c = (3.0 * (f1 - f0) / size - 2.0 * r0 - r1) / size
    d = (r0 + r1 - 2.0 * (f1 - f0) / size) / size**2
    below = c + np.sqrt(c * c - 3.0 * r0 * d) if c * c >= 3.0 * r0 * d else 0.0
    s = -r0 / below if below > 0.0 else 0.5 * size
    if not 0.0 < s < size:
        return None
    lowest = f0 + s * (r0 + s * (c + s * d))
    return float(s) if lowest < CLOSE * min(f0, f1) else None


def _still_there(height: Height, before: Any, size: float) -> tuple[float, float]:
    """A time after the snapshot at which the height is on its side, and the height, though it is at neither end.

    So it is just after an impact.  If there is none the begin itself is returned.
    """
    time = size
    for _ in range(HALVINGS):
        time *= 0.5
        value = height.at(before, time)
        if not height.left(value):
            return time, value
    return 0.0, 0.0
