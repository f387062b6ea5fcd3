"""Newton's method for the gaps of multiple shooting, at a fixed parameter or on a branch."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from flexmb.dynamics.orbits.shooting import Shooting, ShootingRun

HALVINGS = 8  # largest number of halvings of a correction that increases the gaps
# Singular value, over the largest one, below which a direction is not corrected (an orbit within a family).
SMALLEST_SINGULAR = 1e-12
LARGEST_STRETCH = 0.3  # largest change of an unknown period in one correction, over the period


class Direction(NamedTuple):
    """A vector in the space of starts (M, size), period [s] and parameter."""

    starts: np.ndarray
    period: float
    value: float


@dataclass(frozen=True)
class ArclengthPlane:
    """The plane <normal, u - through> = 0 on which a step of pseudo-arclength continuation seeks the next orbit."""

    normal: Direction  # direction of the step
    through: Direction  # predicted point
    lengths: tuple[float, float, float]  # scales of states, period and parameter
    small: float  # difference of the parameter for derivatives

    def row(self, shooting: Shooting, run: ShootingRun) -> tuple[np.ndarray, float, float, float]:
        """Coefficients of y (M d,), of the period and of the parameter, and distance of a run from the plane."""
        x, t, p = self.lengths
        weighted = self.normal.starts * shooting.space.weights / x**2
        distance = shooting.space.difference(run.starts, self.through.starts)
        of_states = np.einsum("js,jsd->jd", weighted, run.bases).ravel()
        of_period, of_value = self.normal.period / t**2, self.normal.value / p**2
        offset = of_period * (run.period - self.through.period) + of_value * (run.value - self.through.value)
        return of_states, of_period, of_value, float((weighted * distance).sum() + offset)


class NewtonResult(NamedTuple):
    """Result of Newton's method: the last run over the period (None: no run succeeded), and how it ended."""

    # The residuals, one an iteration, are gaps over the size of the states.
    last: ShootingRun | None
    residuals: tuple[float, ...]
    ok: bool
    status: str


def correct(
    shooting: Shooting, starts: np.ndarray, period: float, value: float, *, tolerance: float, iterations: int,
    plane: ArclengthPlane | None = None,
) -> NewtonResult:  # fmt: skip
    """Periodic orbit by Newton's method, from starts (M, size), a period and a parameter (NaN: no parameter)."""
    # The tolerance is the largest gap over the size of the states; `plane` is the equation for an unknown parameter,
    # None if it is fixed.
    run = shooting.run(starts, period, value)
    if run is None:
        return NewtonResult(None, (), False, f"The first run over the period failed: {shooting.status}")
    residuals, failed = [_relative_miss(shooting, run)], ""
    while residuals[-1] > tolerance or (plane is not None and abs(plane.row(shooting, run)[3]) > 1e-6):
        advice = f"wanted {tolerance:g}. Give a better guess, or settle=."
        if len(residuals) > iterations:
            failed = f"Not converged after {iterations} iterations: {residuals[-1]:.3g} of the state does not return"
            failed = f"{failed}, {advice}"
            break
        J = extended(shooting, run, None if plane is None else plane.small)
        if J is None:
            failed = f"A derivative by the parameter failed: {shooting.status}"
            break
        right = np.zeros(len(J))
        right[: run.gaps.size] = -run.gaps.ravel()
        if plane is not None:
            of_states, of_period, of_value, offset = plane.row(shooting, run)
            row = np.concatenate([of_states, [of_period] if shooting.autonomous else [], [of_value]])
            J, right = np.vstack([J, row]), np.append(right, -offset)
        next_run = _damped_step(shooting, run, solved(J, right), tolerance)
        if next_run is None:
            failed = f"No correction reduces the residual; {residuals[-1]:.3g} of the state does not return, {advice}"
            break
        run = next_run
        residuals.append(_relative_miss(shooting, run))
    status = failed or f"Converged after {len(residuals) - 1} iterations."
    return NewtonResult(run, tuple(residuals), not failed, status)


def _relative_miss(shooting: Shooting, run: ShootingRun) -> float:
    """Length of the gaps over the length of the largest state so far."""
    return run.miss / shooting.scale if shooting.scale > 0.0 else 0.0


def extended(shooting: Shooting, run: ShootingRun, small: float | None) -> np.ndarray | None:
    """Matrix (rows, unknowns) of gaps and phase condition by y, the period of autonomous flows, and the parameter."""
    # `small` is the difference of the parameter for derivatives; None: the parameter is fixed.
    J = run.matrix()
    rows, d = len(J), run.gaps.shape[1]
    if shooting.autonomous:
        J = np.hstack([J, run.rates.reshape(-1, 1)])
        phase = np.zeros(J.shape[1])
        phase[:d] = run.drift / max(float(np.linalg.norm(run.drift)), 1e-300)
        J = np.vstack([J, phase])
    if small is not None:
        column = np.zeros((len(J), 1))
        column[:rows, 0] = shooting.by_parameter(run, small).ravel()
        if not np.isfinite(column).all():
            return None
        J = np.hstack([J, column])
    return J


def solved(J: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Solution of J x = right, of least length for a singular J (rows, unknowns); columns and rows are scaled first."""
    if J.size == 0:
        return np.zeros(J.shape[1])
    column_scales = np.linalg.norm(J, axis=0)
    column_scales[column_scales == 0.0] = 1.0
    row_scales = np.linalg.norm(J / column_scales, axis=1)
    row_scales[row_scales == 0.0] = 1.0
    x = np.linalg.lstsq(J / column_scales / row_scales[:, None], right / row_scales, rcond=SMALLEST_SINGULAR)[0]
    return np.asarray(x / column_scales)


def _damped_step(shooting: Shooting, run: ShootingRun, step: np.ndarray, tolerance: float) -> ShootingRun | None:
    """First run after 1, 1/2, 1/4, ... of a correction of (y, period, parameter) whose gaps are smaller, or None."""
    # Gaps within the tolerance need not become smaller.
    factor, n = 1.0, run.gaps.size
    for _ in range(HALVINGS):
        period, value, part = run.period, run.value, factor
        if shooting.autonomous:
            part = min(part, LARGEST_STRETCH * period / max(abs(step[n]), 1e-300))
            period += part * step[n]
        if len(step) > n + shooting.autonomous:
            value += part * step[-1]
            if not shooting.autonomous and shooting.set_value(value):
                period = shooting.period
        trial = shooting.run(shooting.moved(run, part * step[:n].reshape(run.gaps.shape)), period, value)
        smaller = (1.0 - 0.1 * factor) * run.miss
        if trial is not None and (trial.miss < smaller or trial.miss <= tolerance * shooting.scale):
            return trial
        factor *= 0.5
    return None
