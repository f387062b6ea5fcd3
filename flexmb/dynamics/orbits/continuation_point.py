"""Points of a branch with the test functions of events, and the location of an event between two points."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from flexmb.dynamics.orbits.branch import BranchPoint
from flexmb.dynamics.orbits.floquet import GRAZING
from flexmb.dynamics.orbits.orbit_newton import Direction

LOCATED = 1e-9
"""Precision of an event: fraction of a step, or of the test function."""

Tests = dict[str, float]


@dataclass(frozen=True)
class ContinuationPoint:
    """An orbit on a branch, the direction of the branch there, and the test functions of events.

    Parameters
    ----------
    ahead : direction of the branch.
    tests : values of the test functions, whose signs change at events.
    touches : number of closures of each gap.
    iterations : number of corrections.
    """

    point: BranchPoint
    ahead: Direction
    tests: Tests
    touches: dict[str, int]
    iterations: int

    def test(self, name: str, old: ContinuationPoint) -> float:
        """Value of a test function; for grazing its sign changes with the number of closures since an earlier point."""
        value = self.tests.get(name, np.nan)
        if not name.startswith(GRAZING):
            return value
        return abs(value) if self.touches.get(name) == old.touches.get(name) else -abs(value)


def signed_volume(J: np.ndarray, u: np.ndarray, units: np.ndarray) -> float:
    """Sign of the determinant of J with the direction u as last row, times the smallest singular value.

    It vanishes where branches cross.  J holds derivatives of gaps and phase by the unknowns; `units` (columns,) are
    scales of the unknowns, and the first one scales the gaps.
    """
    ahead = u / units
    whole = np.vstack([J * units / units[0], ahead / np.linalg.norm(ahead)])
    return float(np.linalg.slogdet(whole)[0] * np.linalg.svd(whole, compute_uv=False)[-1])


def root(
    make: Callable[[float], ContinuationPoint | None],
    low: tuple[float, ContinuationPoint],
    high: tuple[float, ContinuationPoint],
    test: Callable[[ContinuationPoint], float],
) -> tuple[float, ContinuationPoint]:
    """Position and orbit between two points at which a test function vanishes, by bracketed secants (Illinois).

    Without an orbit at a trial, as beyond the grazing of rigid surfaces, the root is sought before the trial.  `make`
    returns the orbit at a position, or None; `low` and `high` are positions and orbits at the ends of the bracket.
    """
    (a, one), (b, other) = low, high
    fa, fb = test(one), test(other)
    width, largest = abs(b - a), max(abs(fa), abs(fb))
    best = (a, one) if abs(fa) < abs(fb) else (b, other)
    for _ in range(40):
        s = (a * fb - b * fa) / (fb - fa)
        middle = make(s)
        f = test(middle) if middle is not None else np.nan
        f = -fa if np.isnan(f) else f
        if middle is not None and abs(f) < abs(test(best[1])):
            best = (s, middle)
        if abs(f) <= LOCATED * largest or abs(b - a) <= LOCATED * width:
            break
        if f * fb < 0.0:
            a, fa = b, fb
        else:
            fa *= 0.5
        b, fb = s, f
    return best
