"""Motion at constant speed."""

import math
from dataclasses import dataclass

from flexmb.kernels import drive_kernel
from flexmb.model.law import Motion


@drive_kernel
def constant_speed_kernel(p, t):
    """s = w t."""
    (w,) = p
    return w * t, w, 0.0


@dataclass(frozen=True)
class ConstantSpeed(Motion):
    """s = speed t.

    Parameters
    ----------
    speed : rad/s for an angle, m/s for a travel.
    """

    speed: float

    kernel = constant_speed_kernel
    swings = False

    @property
    def period(self) -> float | None:
        """Time of one turn [s]."""
        return 2.0 * math.pi / abs(self.speed) if self.speed else None
