"""Smooth start from rest to a constant speed."""

import math
from dataclasses import dataclass

from flexmb import checks
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


@dataclass(frozen=True)
class Ramp(Motion):
    """From rest to `speed` within `time`, with continuous acceleration and jerk-free ends.

    Parameters
    ----------
    speed : final speed, rad/s for an angle, m/s for a travel.
    time : duration of the start [s], > 0.

    Raises
    ------
    InputError : a time that is not > 0.
    """

    speed: float
    time: float

    kernel = ramp_kernel

    def __post_init__(self) -> None:
        super().__post_init__()
        checks.positive("Ramp", "time", self.time, "s")

    @property
    def period(self) -> float | None:
        """Time of one turn at full speed [s]."""
        return 2.0 * math.pi / abs(self.speed) if self.speed else None
