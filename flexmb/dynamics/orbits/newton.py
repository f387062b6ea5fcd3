"""Newton's method on passes over the period, alone or along a branch."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from flexmb.dynamics.orbits.shooting import Pass, Shooting

HALVINGS = 8
"""How often a correction that makes the gaps larger is halved."""

SMALLEST_SINGULAR = 1e-12
"""Directions that the equations hardly see (an orbit among a family of them), against the others; they stay."""

LARGEST_STRETCH = 0.3
"""A correction changes an unknown period by at most this part of it."""


@dataclass(frozen=True)
class Direction:
    """A direction in the space of starts, period and parameter, or a point of it.

    Parameters
    ----------
    starts : (M, size).
    period : its part of the period [s].
    value : its part of the parameter.
    """

    starts: np.ndarray
    period: float
    value: float


@dataclass(frozen=True)
class Plane:
    """The points u with <normal, u - through> = 0: where a step along a branch looks for the next orbit.

    Parameters
    ----------
    normal : direction of the step.
    through : the point predicted.
    lengths : what counts as 1 of states, period, parameter.
    small : difference of the parameter from which derivatives are taken.
    """

    normal: Direction
    through: Direction
    lengths: tuple[float, float, float]
    small: float

    def row(self, shooting: Shooting, one: Pass) -> tuple[np.ndarray, float, float, float]:
        """Coefficients of y (M d,), of period and parameter, and how far the pass is from the plane."""
        x, t, p = self.lengths
        wide = self.normal.starts * shooting.space.weights / x**2
        away = np.array([shooting.space.difference(a, b) for a, b in zip(one.starts, self.through.starts, strict=True)])
        by_y = np.einsum("js,jsd->jd", wide, one.bases).ravel()
        by_period, by_value = self.normal.period / t**2, self.normal.value / p**2
        off = by_period * (one.period - self.through.period) + by_value * (one.value - self.through.value)
        return by_y, by_period, by_value, float((wide * away).sum() + off)


@dataclass(frozen=True)
class Found:
    """What Newton's method came to.

    Parameters
    ----------
    last : the last pass; None if not one could be made.
    misses : gaps of the passes as parts of the size of the states, one an iteration.
    ok : whether the last is small enough.
    status : what happened, in a sentence.
    """

    last: Pass | None
    misses: tuple[float, ...]
    ok: bool
    status: str


def correct(
    shooting: Shooting,
    starts: np.ndarray,
    period: float,
    value: float,
    *,
    tolerance: float,
    iterations: int,
    plane: Plane | None = None,
) -> Found:
    """Starts (M, size), period and, on a plane, parameter with which the motion comes back to where it began."""
    one = shooting.run(starts, period, value)
    if one is None:
        return Found(None, (), False, f"The first pass failed: {shooting.status}")
    misses = [_part(shooting, one)]
    while misses[-1] > tolerance or (plane is not None and abs(plane.row(shooting, one)[3]) > 1e-6):
        if len(misses) > iterations:
            text = f"Not converged after {iterations} iterations: {misses[-1]:.3g} of the state does not come back"
            return Found(one, tuple(misses), False, f"{text}, wanted {tolerance:g}. Give a better guess, or settle=.")
        step = _step(shooting, one, plane)
        if step is None:
            return Found(one, tuple(misses), False, f"A derivative by the parameter failed: {shooting.status}")
        following = _damped(one.miss, shooting, lambda s, one=one, step=step: _tried(shooting, one, step, s), tolerance)
        if following is None:
            text = f"No correction brings the motion nearer to its start; {misses[-1]:.3g} of the state does not"
            return Found(
                one, tuple(misses), False, f"{text} come back, wanted {tolerance:g}. Give a better guess, or settle=."
            )
        one = following
        misses.append(_part(shooting, one))
    return Found(one, tuple(misses), True, f"Converged after {len(misses) - 1} iterations.")


def _part(shooting: Shooting, one: Pass) -> float:
    """The gaps as a part of the largest state met."""
    return one.miss / shooting.scale if shooting.scale > 0.0 else 0.0


def extended(shooting: Shooting, one: Pass, small: float | None) -> np.ndarray | None:
    """(rows, unknowns) matrix of gaps and phase by y, period (autonomous) and parameter (`small` given)."""
    J = one.matrix()
    rows, d = len(J), one.gaps.shape[1]
    if shooting.autonomous:
        J = np.hstack([J, one.rates.reshape(-1, 1)])
        phase = np.zeros(J.shape[1])
        phase[:d] = one.drift / max(float(np.linalg.norm(one.drift)), 1e-300)
        J = np.vstack([J, phase])
    if small is not None:
        column = np.zeros((len(J), 1))
        column[:rows, 0] = shooting.by_parameter(one, small).ravel()
        if not np.isfinite(column).all():
            return None
        J = np.hstack([J, column])
    return J


def _step(shooting: Shooting, one: Pass, plane: Plane | None) -> np.ndarray | None:
    """Newton's correction of (y, period, parameter)."""
    J = extended(shooting, one, None if plane is None else plane.small)
    if J is None:
        return None
    right = np.zeros(len(J))
    right[: one.gaps.size] = -one.gaps.ravel()
    if plane is not None:
        by_y, by_period, by_value, off = plane.row(shooting, one)
        row = np.concatenate([by_y, [by_period] if shooting.autonomous else [], [by_value]])
        J, right = np.vstack([J, row]), np.append(right, -off)
    return solved(J, right)


def solved(J: np.ndarray, right: np.ndarray) -> np.ndarray:
    """x with J x = right, of least length where J does not say; columns and rows are scaled first."""
    if J.size == 0:
        return np.zeros(J.shape[1])
    across = np.linalg.norm(J, axis=0)
    across[across == 0.0] = 1.0
    down = np.linalg.norm(J / across, axis=1)
    down[down == 0.0] = 1.0
    x = np.linalg.lstsq(J / across / down[:, None], right / down, rcond=SMALLEST_SINGULAR)[0]
    return np.asarray(x / across)


def _tried(shooting: Shooting, one: Pass, step: np.ndarray, factor: float) -> Pass | None:
    """The pass after a part of a correction."""
    n = one.gaps.size
    period, value = one.period, one.value
    if shooting.autonomous:
        factor = min(factor, LARGEST_STRETCH * period / max(abs(step[n]), 1e-300))
        period += factor * step[n]
    if len(step) > n + shooting.autonomous:
        value += factor * step[-1]
        if not shooting.autonomous and shooting.set_value(value):
            period = shooting.period
    return shooting.run(shooting.moved(one, factor * step[:n].reshape(one.gaps.shape)), period, value)


def _damped(miss: float, shooting: Shooting, tried: Callable[[float], Pass | None], tolerance: float) -> Pass | None:
    """The first of the passes after 1, 1/2, 1/4 ... of a correction whose gaps are smaller; None if there is none.

    Gaps at round-off need not become smaller.
    """
    factor = 1.0
    for _ in range(HALVINGS):
        found = tried(factor)
        if found is not None and (found.miss < (1.0 - 0.1 * factor) * miss or found.miss <= tolerance * shooting.scale):
            return found
        factor *= 0.5
    return None
