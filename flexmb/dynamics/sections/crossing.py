"""Crossings: instants at which a signal crosses a level, located within a step of a flow to round-off."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from flexmb.dynamics.systems.dynamics import ContinuousFlow

ROUNDS = 200  # largest number of trials of a search for a crossing
HALVINGS = 40  # largest number of halvings of a step in the search for a point before a crossing
DOWN, UP = -1, 1  # directions of a crossing, and sides of the level
# Height of the cubic's minimum, over the lower end of the step, below which the step is searched for two crossings.
CLOSE = 0.1


class Bracket(NamedTuple):
    """Times between which a crossing lies [s], counted from a snapshot with tangent vectors (size, k) or None."""

    # The height before the crossing, at the time `near`, is `value`.
    before: Any
    tangents: np.ndarray | None
    near: float
    value: float
    far: float


@dataclass
class Height:
    """Height of a signal over a level, and the side of the level before a crossing."""

    flow: ContinuousFlow
    value: Callable[[], float]  # function that returns the present height
    # function that returns the rate of the height [1/s]; None: the rate is costly, and two crossings in one step may be
    # missed
    rate: Callable[[], float] | None
    side: int  # UP or DOWN

    def at(self, before: Any, duration: float) -> float:
        """Height a time [s] after a snapshot; the flow stays there."""
        self.flow.restore(before)
        self.flow.advance(duration)
        return self.value()

    def left(self, value: float) -> bool:
        """Whether a height `value` lies on the other side of the level; a height of 0 does not."""
        return value * self.side < 0.0


def stride(height: Height, limit: float, tangents: np.ndarray | None) -> Bracket | None:
    """Advance the flow by one step, up to `limit` [s]; returns the bracket of a crossing in that step, or None."""
    # A step that ends with a jump is searched up to the jump, and then for a crossing by it. After a failure the flow
    # has the status. Tangent vectors (size, k) are advanced in place.
    flow, saved = height.flow, None if tangents is None else tangents.copy()
    before, start, old = flow.snapshot(), flow.time, height.value()
    old_rate = None if height.rate is None else height.rate()
    if not flow.take_step(limit, tangents):
        return None
    size, inner = flow.time - start, flow.before_jump()
    if inner is None:
        return _within(height, Bracket(before, saved, 0.0, old, size), old_rate)
    after = flow.snapshot()
    flow.restore(inner)
    short = size - 16.0 * float(np.spacing(flow.time))  # a time before the jump
    found = _within(height, Bracket(before, saved, 0.0, old, short), old_rate) if short > 0.0 else None
    flow.restore(after)
    return found or (Bracket(before, saved, 0.0, old, size) if height.left(height.value()) else None)


def _within(height: Height, step: Bracket, old_rate: float | None) -> Bracket | None:
    """Bracket of a crossing in a step, at whose end the flow stands."""
    # A step whose ends lie on the same side is examined if the cubic through heights and rates at both ends comes near
    # the level.
    old, new, side = step.value, height.value(), height.side
    if height.left(new):
        near, value = _point_before(height, step.before, step.far) if height.left(old) else (0.0, old)
        return step._replace(near=near, value=value)
    dip = None
    if height.rate is not None and old_rate is not None and not height.left(old):
        dip = turning_point(side * old, side * old_rate, side * new, side * height.rate(), step.far)
    if dip is None:
        return None
    after = height.flow.snapshot()
    inside = height.at(step.before, dip)
    height.flow.restore(after)
    return step._replace(far=dip) if height.left(inside) else None


def locate(height: Height, bracket: Bracket) -> float:
    """Put the flow on the crossing; returns the time from the snapshot to the crossing [s]."""
    # The crossing is the first time after it that the clock of the flow can represent. Regula falsi with the Illinois
    # modification, and bisection every fourth time (M. Dowell, P. Jarratt, BIT 11 (1971) 168). Each trial is a step of
    # the flow from the snapshot, so the result is a point of the flow and not of an interpolation.
    flow, before = height.flow, bracket.before
    flow.restore(before)
    a, b, fa = bracket.near, bracket.far, bracket.value
    least = 4.0 * float(np.spacing(abs(flow.time) + b))
    fb, moved_last = height.at(before, b), 0
    for count in range(ROUNDS):
        if height.left(fb) or not flow.ok:
            break  # a step with tangent vectors may end a little later than a step without
        b += 2.0**count * max(1e-9 * bracket.far, least)
        fb = height.at(before, b)
    for count in range(ROUNDS):
        if b - a <= least or b <= flow.shortest or not flow.ok:
            break
        x = 0.5 * (a + b) if count % 4 == 3 or fa == fb else b - fb * (b - a) / (fb - fa)
        x = min(max(x, a + 0.5 * least, flow.shortest), b - 0.5 * least)
        value = height.at(before, x)
        if height.left(value):
            b, fb, fa, moved_last = x, value, 0.5 * fa if moved_last == DOWN else fa, DOWN
        else:
            a, fa, fb, moved_last = x, value, 0.5 * fb if moved_last == UP else fb, UP
    if flow.ok:
        height.at(before, b)
    return b


def carry(flow: ContinuousFlow, bracket: Bracket, duration: float, tangents: np.ndarray) -> None:
    """Advance `tangents` (size, k) from the snapshot of a bracket to the present state of the flow, on the crossing."""
    # `duration` is the time from the snapshot to the crossing [s].
    point = flow.snapshot()
    tangents[:] = bracket.tangents
    flow.restore(bracket.before)
    if flow.advance(duration, tangents):
        flow.restore(point)


def turning_point(f0: float, r0: float, f1: float, r1: float, size: float) -> float | None:
    """Time of the minimum of a cubic in a step of `size` [s], if the minimum comes near the level; else None."""
    # f0, f1 are heights > 0 at both ends of the step, r0, r1 their rates.
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


def _point_before(height: Height, before: Any, size: float) -> tuple[float, float]:
    """A time before the crossing [s], and the height there, for a step whose ends lie both on the other side."""
    # Such a step begins with an impact. Without such a time the begin of the step is returned.
    time = size
    for _ in range(HALVINGS):
        time *= 0.5
        value = height.at(before, time)
        if not height.left(value):
            return time, value
    return 0.0, 0.0
