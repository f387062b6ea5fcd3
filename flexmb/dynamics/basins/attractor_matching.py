"""Motions watched once a period: whether they repeat themselves, and which of them do the same."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmb.dynamics.systems.dynamics import Dynamics
from flexmb.errors import AssemblyError, SolveError

KEPT = 128
"""Section points by which an attractor that does not repeat itself is recognised."""

CLOSE = 0.1
"""Two sets of points that do not repeat themselves are one if they lie this near to one another, against their size."""

SAME = 1e-6
"""Rounds that differ by less than this part of the tolerance do not differ."""

LOST, UNDECIDED = -1, 0


@dataclass(frozen=True)
class Rules:
    """How long and how closely a motion is watched; see `basin`.

    Parameters
    ----------
    base : period [s, or iterations].
    origin : time at which motions begin.
    settle, longest : periods before a motion may be called settled, and after which it is given up.
    repeats : largest number of periods of an attractor that repeats itself.
    tolerance : of a repetition, as a part of the size of the grid's states.
    size : that size.
    bound : states longer than this are lost.
    weights, angle : of the state.
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
        """Length below which states are the same."""
        return self.tolerance * self.size

    def away(self, points: np.ndarray, other: np.ndarray) -> np.ndarray:
        """Lengths (n,) of the differences of points (n, size) from another one, whole turns taken away."""
        d = points - other
        d[:, self.angle] -= 2.0 * np.pi * np.round(d[:, self.angle] / (2.0 * np.pi))
        return np.asarray(np.sqrt((d * d) @ self.weights))


Track = tuple[np.ndarray, int, int]
"""Points by which the motion is known, the number of periods in which it repeats itself (0: not, -1: lost), periods
taken."""


def tracks_of(system: Dynamics, starts: np.ndarray, rules: Rules) -> list[Track]:
    """What becomes of the motions from these starts (n, size)."""
    return [_track(system, start, rules) for start in starts]


def _track(system: Dynamics, start: np.ndarray, rules: Rules) -> Track:
    """Watch one motion until it repeats itself, ends, or the time is over.

    It is judged every `settle` periods, and a repetition counts if it is still there the next time: motions that pass
    an orbit that does not attract seem to repeat themselves for a while.
    """
    nothing = start[None, :][:0]
    try:
        system.reset(start, time=rules.origin)
    except (AssemblyError, SolveError):
        return nothing, LOST, 0
    step = rules.base if system.unit == "s" else round(rules.base)
    points: list[np.ndarray] = [system.state()]
    seen, after = 0, 0  # periods of a repetition that was seen, and when
    for n in range(1, rules.longest + 1):
        if not system.advance(step):
            return nothing, LOST, n
        points.append(system.state())
        if not np.sqrt(rules.weights @ points[-1] ** 2) <= rules.bound:
            return nothing, LOST, n
        if n % rules.settle:
            continue
        if seen and rules.away(points[n - (n - after) % seen][None, :], points[after])[0] <= 2.0 * rules.close:
            return np.array(points[-seen:]), seen, after
        seen, after = _repeats(points, rules), n
    return np.array(points[-KEPT:]), 0, rules.longest


def _repeats(points: list[np.ndarray], rules: Rules) -> int:
    """The number of periods after which the points come back; 0: they do not, or are still far from where they lead.

    Rounds that differ by d1, d0 the time before, are d1 r/(1 - r), r = d1/d0, from their limit.
    """
    last = np.array(points[-3 * rules.repeats :])
    back = rules.away(last[:-1][::-1], last[-1])
    for k in range(1, len(last) // 3 + 1):
        if back[k - 1] > rules.close:
            continue
        now, before, first = last[-k:], last[-2 * k : -k], last[-3 * k : -2 * k]
        d1, d0 = _apart(now, before, rules), _apart(before, first, rules)
        if d1 <= SAME * rules.close or (d1 < d0 and d1 * d1 <= rules.close * (d0 - d1)):
            parts = [m for m in range(1, k) if k % m == 0]  # a spiral comes nearer to itself after some turns
            return next((m for m in parts if _apart(now, last[-k - m : -m], rules) <= 3.0 * rules.close), k)
    return 0


def _apart(points: np.ndarray, others: np.ndarray, rules: Rules) -> float:
    """Largest distance of points from others, pair by pair."""
    return max(float(rules.away(one[None, :], other)[0]) for one, other in zip(points, others, strict=True))


def sorted_out(
    tracks: list[np.ndarray], repeats: list[int], rules: Rules
) -> tuple[np.ndarray, tuple[np.ndarray, ...], tuple[int, ...]]:
    """Numbers of the attractors of all motions, their points and periods."""
    number = np.zeros(len(tracks), dtype=np.int64)
    known: list[tuple[np.ndarray, int]] = []
    for i, (points, k) in enumerate(zip(tracks, repeats, strict=True)):
        if k == LOST:
            number[i] = LOST
            continue
        if k == 0 and not _same(points[: len(points) // 2], points[len(points) // 2 :], 0, rules):
            continue  # it still creeps somewhere
        for j, (other, again) in enumerate(known):
            if again == k and _same(points, other, k, rules):
                number[i] = j + 1
                break
        else:
            known.append((points, k))
            number[i] = len(known)
    return number, tuple(points for points, _ in known), tuple(k for _, k in known)


def _same(points: np.ndarray, other: np.ndarray, repeats: int, rules: Rules) -> bool:
    """Whether two motions are on one attractor: all points of the one near points of the other, and vice versa."""
    table = np.array([rules.away(other, p) for p in points])
    if repeats:
        return bool(max(table.min(axis=1).max(), table.min(axis=0).max()) <= 10.0 * rules.close)
    size = min(float(np.sqrt(((s - s.mean(axis=0)) ** 2 @ rules.weights).max())) for s in (points, other))
    return bool(max(np.median(table.min(axis=1)), np.median(table.min(axis=0))) <= CLOSE * size)
