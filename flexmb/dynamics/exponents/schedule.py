"""When a system is looked at for its exponents, and what small differences grow by until then."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmb.dynamics.systems.as_dynamics import clock
from flexmb.dynamics.systems.continuous_flow import ContinuousFlow
from flexmb.dynamics.systems.dynamics import Dynamics, orthonormalise

TOO_MUCH = 1e4
"""Growth, or spread of growths, between two looks at the vectors; where that is usual one looks twice as often."""
FAR_TOO_MUCH = 1e6
"""Spread from which the way since the last look is gone once more in halves: the shortest vector is hardly known."""
LOST = 1e-13
"""What is left of a vector when the others are taken away, below which it is their round-off."""
MOST_LOOKS = 4096


@dataclass
class Schedule:
    """When a system is looked at.

    Parameters
    ----------
    system : what is advanced: a map, or a flow.
    unit : time from one point to the next [s]; of a map 1 iteration.
    skip, count : points before counting begins, and those that count.
    is_flow : whether the time between points can be divided.
    is_section : whether the points are those of a section or a map.
    looks : how often between two points the vectors are made orthonormal.
    trouble : what the system itself does not know to have failed.
    """

    system: Dynamics
    unit: float
    skip: int
    count: int
    is_flow: bool
    is_section: bool
    looks: int = 1
    trouble: str = ""

    def __post_init__(self) -> None:
        self.origin, self.records = self.system.time, self.system.records

    def go(self, system: Dynamics, number: int, part: float = 1.0, tangents: np.ndarray | None = None) -> bool:
        """Bring `system`, which stands beyond the point before, up to the `number`-th point, or part of the way."""
        if not self.is_flow:
            return system.advance(1, tangents)
        return system.advance(self.origin + (number - 1 + part) * self.unit - system.time, tangents)

    def one_period(self, number: int, W: np.ndarray | None, weights: np.ndarray) -> np.ndarray | None:
        """Logarithms (k,) of the growth of vectors W (size, k) up to the next point; None: it could not be reached."""
        if W is None:
            return np.zeros(0) if self.go(self.system, number) else None
        logs, looks, wide = np.zeros(W.shape[1]), self.looks, 0
        for look in range(1, looks + 1):
            found = self._carried(number, (look - 1) / looks, look / looks, W, weights)
            if found is None:
                return None
            logs += found
            wide += found.max(initial=0.0) - found.min(initial=0.0) > np.log(TOO_MUCH)
        if self.is_flow and 4 * wide >= looks:  # a single impact is divided where it is, and not the whole period
            self.looks = min(2 * looks, MOST_LOOKS)
        return logs

    def _carried(self, number: int, begin: float, end: float, W: np.ndarray, weights: np.ndarray) -> np.ndarray | None:
        """Logarithms (k,) of the growth from one part of the way to another, which is divided where need be."""
        system = self.system
        kept = (system.snapshot(), W.copy()) if isinstance(system, ContinuousFlow) and self.is_flow else None
        reached = self.go(system, number, end, W)
        whole = lengths_of(W, weights)
        lengths = orthonormalise(W, weights) if reached else np.full(W.shape[1], np.nan)
        W[self.records] = 0.0  # they would grow beyond all numbers where the rest of a vector shrinks
        good = bool(np.isfinite(lengths).all() and np.isfinite(W).all())
        spread = lengths.max() / max(min(lengths.min(), 1.0), 1e-300) if good else np.inf
        if kept is not None and spread > FAR_TOO_MUCH and end - begin > 1.0 / MOST_LOOKS:
            return self._in_halves(number, (begin, end), kept, W, weights)
        if not reached:
            return None
        if not good or (lengths < LOST * whole).any():
            what = "are not finite" if not good else "cannot be told apart any more"
            text = f"The tangent vectors {what} at {clock(system):.6g}"
            self.trouble = f"{text}." if not good else f"{text}. Ask for fewer exponents (count=)."
            return None
        with np.errstate(divide="ignore"):
            return np.log(lengths)

    def _in_halves(
        self, number: int, part: tuple[float, float], kept: tuple, W: np.ndarray, weights: np.ndarray
    ) -> np.ndarray | None:
        """What `_carried` returns, of a part of the way that is gone once more from what was kept of its begin."""
        system, (begin, end) = self.system, part
        if not isinstance(system, ContinuousFlow):
            return None
        if not system.ok:  # is it the motion that fails, or are only the vectors too long?
            system.restore(kept[0])
            if not self.go(system, number, end):
                return None
        system.restore(kept[0])
        W[:] = kept[1]
        middle = 0.5 * (begin + end)
        first = self._carried(number, begin, middle, W, weights)
        second = None if first is None else self._carried(number, middle, end, W, weights)
        return None if first is None or second is None else first + second


def lengths_of(W: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Lengths (k,) of the columns of W (size, k) in the weights, even where their squares are no numbers any more."""
    counted = weights > 0.0
    largest = np.abs(W[counted]).max(axis=0, initial=0.0)
    some = np.where(largest > 0.0, largest, 1.0)
    with np.errstate(invalid="ignore", over="ignore"):
        return np.asarray(largest * np.sqrt(weights[counted] @ (W[counted] / some) ** 2))
