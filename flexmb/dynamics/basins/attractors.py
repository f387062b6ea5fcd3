"""Attractors of motions that are observed once a period: repetition, and comparison with known attractors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmb.dynamics.systems.dynamics import Dynamics
from flexmb.errors import AssemblyError, SolveError

KEPT = 128
"""Number of section points that represent an attractor without repetition."""

CLOSE = 0.1
"""Distance of two sets of points without repetition, over their size, below which they are one attractor."""

SAME = 1e-6
"""Difference of two rounds, over the tolerance, below which they are equal."""

LOST, UNDECIDED = -1, 0
"""Numbers of motions that ended, and of motions whose attractor is unknown."""


@dataclass(frozen=True)
class Rules:
    """Limits and tolerances of the observation of motions; see `basin`.

    Parameters
    ----------
    base : period [s, or iterations].
    origin : start time of the motions.
    settle, longest : number of periods between two judgements, and largest number of periods.
    repeats : largest number of periods after which an attractor repeats itself.
    tolerance : tolerance of a repetition, over the size of the grid.
    size : size of the grid of states.
    bound : length of a state above which a motion is lost.
    weights, angle : weights (size,) of a state; entries that are angles.
    """

    base: float
    origin: float
    settle: int
    longest: int
    repeats: int
    tolerance: float
    size: float
    bound: float
    weights: np.ndarray
    angle: np.ndarray

    @property
    def close(self) -> float:
        """Distance of two states below which they are equal."""
        return self.tolerance * self.size

    def away(self, points: np.ndarray, other: np.ndarray) -> np.ndarray:
        """Distances (n,) of points (n, size) from another point (size,), without whole turns."""
        d = points - other
        d[:, self.angle] -= 2.0 * np.pi * np.round(d[:, self.angle] / (2.0 * np.pi))
        return np.asarray(np.sqrt((d * d) @ self.weights))


Track = tuple[np.ndarray, int, int]
"""Points that represent a motion, its number of periods until repetition (0: none, -1: lost), and periods computed."""


def tracks_of(system: Dynamics, starts: np.ndarray, rules: Rules) -> list[Track]:
    """Points and repetitions of the motions from start states (n, size); the system is advanced."""
    return [_track(system, start, rules) for start in starts]


def _track(system: Dynamics, start: np.ndarray, rules: Rules) -> Track:
    """Observe one motion until it repeats itself, ends, or reaches the largest number of periods.

    It is judged every `settle` periods.  A repetition counts if it is still there at the next judgement, because
    motions near an unstable orbit seem to repeat themselves for a while.
    """
    nothing = start[None, :][:0]
    try:
        system.reset(start, time=rules.origin)
    except (AssemblyError, SolveError):
        return nothing, LOST, 0
    step = rules.base if system.unit == "s" else round(rules.base)
    points: list[np.ndarray] = [system.state()]
    repetition, since = 0, 0  # periods of a repetition at the last judgement, and the time of that judgement
    for n in range(1, rules.longest + 1):
        if not system.advance(step):
            return nothing, LOST, n
        points.append(system.state())
        if not np.sqrt(rules.weights @ points[-1] ** 2) <= rules.bound:
            return nothing, LOST, n
        if n % rules.settle:
            continue
        again = points[n - (n - since) % repetition][None, :] if repetition else None
        if again is not None and rules.away(again, points[since])[0] <= 2.0 * rules.close:
            return np.array(points[-repetition:]), repetition, since
        repetition, since = _repeats(points, rules), n
    return np.array(points[-KEPT:]), 0, rules.longest


def _repeats(points: list[np.ndarray], rules: Rules) -> int:
    """Number of periods after which the points return; 0: no return, or points still far from their limit.

    Rounds that differ by d1, and by d0 the time before, are d1 r/(1 - r), r = d1/d0, from their limit.
    """
    last = np.array(points[-3 * rules.repeats :])
    back = rules.away(last[:-1][::-1], last[-1])
    for k in range(1, len(last) // 3 + 1):
        if back[k - 1] > rules.close:
            continue
        now, before, first = last[-k:], last[-2 * k : -k], last[-3 * k : -2 * k]
        d1, d0 = _apart(now, before, rules), _apart(before, first, rules)
        if d1 <= SAME * rules.close or (d1 < d0 and d1 * d1 <= rules.close * (d0 - d1)):
            divisors = [m for m in range(1, k) if k % m == 0]  # a spiral comes nearer to itself after some turns
            return next((m for m in divisors if _apart(now, last[-k - m : -m], rules) <= 3.0 * rules.close), k)
    return 0


def _apart(points: np.ndarray, others: np.ndarray, rules: Rules) -> float:
    """Largest distance of points from others, pair by pair."""
    return max(float(rules.away(one[None, :], other)[0]) for one, other in zip(points, others, strict=True))


def matched_attractors(
    tracks: list[np.ndarray], repeats: list[int], rules: Rules
) -> tuple[np.ndarray, tuple[np.ndarray, ...], tuple[int, ...]]:
    """Numbers of the attractors of all motions, by their points and periods; points and periods of the attractors."""
    number = np.zeros(len(tracks), dtype=np.int64)
    known: list[tuple[np.ndarray, int]] = []
    for i, (points, k) in enumerate(zip(tracks, repeats, strict=True)):
        if k == LOST:
            number[i] = LOST
            continue
        if k == 0 and not _same(points[: len(points) // 2], points[len(points) // 2 :], 0, rules):
            continue  # a transient
        for j, (other, again) in enumerate(known):
            if again == k and _same(points, other, k, rules):
                number[i] = j + 1
                break
        else:
            known.append((points, k))
            number[i] = len(known)
    return number, tuple(points for points, _ in known), tuple(k for _, k in known)


def _same(points: np.ndarray, other: np.ndarray, repeats: int, rules: Rules) -> bool:
    """Whether two motions are on one attractor: the points of each lie near points of the other."""
    table = np.array([rules.away(other, p) for p in points])
    if repeats:
        return bool(max(table.min(axis=1).max(), table.min(axis=0).max()) <= 10.0 * rules.close)
    size = min(float(np.sqrt(((s - s.mean(axis=0)) ** 2 @ rules.weights).max())) for s in (points, other))
    return bool(max(np.median(table.min(axis=1)), np.median(table.min(axis=0))) <= CLOSE * size)
