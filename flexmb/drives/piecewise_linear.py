"""Straight lines between points in time, as the history of a load."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from flexmb.drives.points import checked_points
from flexmb.kernels import drive_kernel
from flexmb.model.law import Motion


@drive_kernel
def piecewise_linear_kernel(p, t):
    """Linear between points, constant outside; p = (t_0 .. t_n-1, s_0 .. s_n-1)."""
    n = p.shape[0] // 2
    low, high = 0, n - 1
    if t < p[low]:
        return p[n + low], 0.0, 0.0
    if t >= p[high]:
        return p[n + high], 0.0, 0.0
    while high - low > 1:
        middle = (low + high) // 2
        if p[middle] <= t:
            low = middle
        else:
            high = middle
    rate = (p[n + high] - p[n + low]) / (p[high] - p[low])
    return p[n + low] + rate * (t - p[low]), rate, 0.0


@dataclass(frozen=True)
class PiecewiseLinear(Motion):
    """Straight lines between points, before the first and after the last one constant.

    Parameters
    ----------
    times : increasing instants [s], at least 2.
    values : the factor at these instants.

    Raises
    ------
    InputError : too few points, times that do not increase, values that are not finite.

    Notes
    -----
    The rate jumps at the points, so the motion can be the history of a load but cannot drive a joint, which would need
    an infinite force; `Table` is smooth.  A run ends a step at each point.

    Examples
    --------
    A triangle of 1 s:

    >>> PiecewiseLinear((0.0, 0.5, 1.0), (0.0, 1.0, 0.0)).breaks(10.0)
    (0.5, 1.0)
    """

    times: Sequence[float]
    values: Sequence[float]

    kernel = piecewise_linear_kernel
    is_smooth = swings = False

    def __post_init__(self) -> None:
        super().__post_init__()
        times, values = checked_points("PiecewiseLinear", self.times, self.values, 2)
        object.__setattr__(self, "times", times)
        object.__setattr__(self, "values", values)

    def parameters(self) -> tuple[float, ...]:
        """Times, then values."""
        return *self.times, *self.values

    def breaks(self, t_end: float) -> tuple[float, ...]:
        """The points."""
        return tuple(t for t in self.times if 0.0 < t <= t_end)
