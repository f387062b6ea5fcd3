"""Starts from rest to a constant speed."""

from __future__ import annotations

import math
from dataclasses import dataclass

from flexmb import checks
from flexmb.docstrings import documented
from flexmb.kernels import drive_kernel
from flexmb.model.law import Motion


@drive_kernel
def ramp_kernel(p, t):
    """s_dot = w x^3 (10 - 15 x + 6 x^2) with x = t/T, then w."""
    w, T = p
    if t >= T:
        return w * (t - 0.5 * T), w, 0.0
    if t <= 0.0:
        return 0.0, 0.0, 0.0
    x = t / T
    s = w * T * x**4 * (2.5 - 3.0 * x + x * x)
    return s, w * x**3 * (10.0 - 15.0 * x + 6.0 * x * x), w / T * 30.0 * x * x * (1.0 - x) ** 2


@drive_kernel
def cycloidal_ramp_kernel(p, t):
    """s_ddot = w/T (1 - cos(2 pi t/T)), then 0."""
    w, T = p
    if t >= T:
        return w * (t - 0.5 * T), w, 0.0
    if t <= 0.0:
        return 0.0, 0.0, 0.0
    k = 2.0 * math.pi / T
    # 1 - cos without the cancellation of small t
    bend = 2.0 * math.sin(0.5 * k * t) ** 2
    return w / T * (0.5 * t * t - bend / (k * k)), w / T * (t - math.sin(k * t) / k), w / T * bend


@dataclass(frozen=True)
class SpinUp(Motion):
    """Base of motions from rest to a constant speed.

    Parameters
    ----------
    speed : final speed w, rad/s for an angle, m/s for a travel.
    time : duration T of the start [s], > 0.

    Raises
    ------
    InputError : a time that is not > 0.
    """

    swings = False

    speed: float
    time: float

    def __post_init__(self) -> None:
        super().__post_init__()
        checks.positive(type(self).__name__, "time", self.time, "s")

    @property
    def period(self) -> float | None:
        """Time of one turn at full speed [s]."""
        return 2.0 * math.pi / abs(self.speed) if self.speed else None


@documented
class Ramp(SpinUp):
    """From rest to `speed` within `time`, with continuous acceleration and jerk-free ends.

    s_dot = w x^3 (10 - 15 x + 6 x^2) with x = t/T up to T, then w
    """

    kernel = ramp_kernel


@documented
class CycloidalRamp(SpinUp):
    """From rest to `speed` within `time`; the acceleration is a full wave 1 - cos and vanishes at both ends.

        s = (w/T) [t^2/2 + (T/2 pi)^2 (cos(2 pi t/T) - 1)] up to T, then w (t - T/2)

    Notes
    -----
    Acceleration and its rate are continuous.  Source: the spin-up manoeuvre of J. C. Simo, L. Vu-Quoc, On the dynamics
    of flexible beams under large overall motions, part II, J. Applied Mechanics 53 (1986) 855-863.
    """

    kernel = cycloidal_ramp_kernel
