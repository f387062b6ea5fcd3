"""Motion given by points in time."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from flexmb import checks
from flexmb.drives.points import checked_points
from flexmb.errors import InputError
from flexmb.kernels import drive_kernel
from flexmb.model.law import CHORD, Motion, swing_of

COUNT, PERIODIC, TIMES = range(3)
CUBIC, SQUARE, LINEAR, CONSTANT = range(4)
"""Places at the beginning of p, see `table_kernel`, and of the coefficients of a piece."""


@drive_kernel
def table_kernel(p, t):
    """Piecewise cubic; p = (n, periodic, t_0 .. t_n-1, c3 c2 c1 c0 of each of n - 1 pieces, growth over the table)."""
    n = int(p[COUNT])
    low, high = 0, n - 1
    contributions = TIMES + n
    growth = contributions + 4 * high
    first, last = p[TIMES], p[TIMES + high]
    rest = 0.0
    if p[PERIODIC] > 0.0:
        turns = np.floor((t - first) / (last - first))
        t -= turns * (last - first)
        rest = turns * p[growth]
    while high - low > 1:
        middle = (low + high) // 2
        if p[TIMES + middle] <= t:
            low = middle
        else:
            high = middle
    k = contributions + 4 * low
    x = min(max(t, first), last) - p[TIMES + low]
    beyond = t - min(max(t, first), last)  # outside the table the motion goes on at the speed of the end
    c3, c2, c1, c0 = p[k + CUBIC], p[k + SQUARE], p[k + LINEAR], p[k + CONSTANT]
    v = (3.0 * c3 * x + 2.0 * c2) * x + c1
    a = 6.0 * c3 * x + 2.0 * c2 if beyond == 0.0 else 0.0
    return ((c3 * x + c2) * x + c1) * x + c0 + v * beyond + rest, v, a


@dataclass(frozen=True)
class Table(Motion):
    """Cubic spline through points, continuous in acceleration.

    Parameters
    ----------
    times : increasing instants [s], at least 4.
    values : the motion at these instants [rad or m].
    periodic : whether the table is repeated; the motion may grow by values[-1] - values[0] a period.
    slopes : speeds at the first and the last instant [rad/s or m/s] (clamped spline); (0, 0) begins and ends at rest.
        None: the third derivative does not jump at the second point and the last but one (not-a-knot spline).

    Raises
    ------
    InputError : too few points, times that do not increase, values or slopes that are not finite, slopes of a
        repeated table.

    Notes
    -----
    Outside a table that is not repeated the motion goes on at the speed of its end; the acceleration jumps there, so a
    run ends a step at that instant.  Inside, the acceleration has kinks at the points; methods of second order keep
    their order there.
    """

    times: Sequence[float]
    values: Sequence[float]
    periodic: bool = False
    slopes: tuple[float, float] | None = None

    kernel = table_kernel

    def __post_init__(self) -> None:
        super().__post_init__()
        times, values = checked_points("Table", self.times, self.values, 4)
        object.__setattr__(self, "times", times)
        object.__setattr__(self, "values", values)
        if self.slopes is None:
            return
        given = checks.sequence("Table", "slopes", self.slopes, "two numbers")
        if len(given) != 2:
            raise InputError(f"Table: slopes is {self.slopes!r}; give two speeds, e.g. (0.0, 0.0).")
        slopes = tuple(checks.number("Table", f"slopes[{k}]", slope, "rad/s or m/s") for k, slope in enumerate(given))
        object.__setattr__(self, "slopes", slopes)
        if self.periodic:
            raise InputError("Table: slopes are given, but a table that is repeated has no ends. Leave slopes out.")

    def parameters(self) -> tuple[float, ...]:
        """Number of points, periodicity, times, coefficients, growth over the table."""
        t, s = np.array(self.times), np.array(self.values)
        growth = float(s[-1] - s[0])
        if self.periodic:
            slope = growth / (t[-1] - t[0])
            straight = s[0] + slope * (t - t[0])
            wave = s - straight
            wave[-1] = wave[0]
            c = CubicSpline(t, wave, bc_type="periodic").c.copy()
            c[2] += slope
            c[3] += straight[:-1]
        else:
            ends = "not-a-knot" if self.slopes is None else tuple((1, slope) for slope in self.slopes)
            c = CubicSpline(t, s, bc_type=ends).c
        return (float(len(t)), float(self.periodic), *t.tolist(), *c.T.ravel().tolist(), growth)

    def breaks(self, t_end: float) -> tuple[float, ...]:
        """Begin and end of a table that is not repeated; the end lies just after its last instant."""
        ends = (self.times[0], self.times[-1] + 4.0 * float(np.spacing(abs(self.times[-1]))))
        return () if self.periodic else tuple(t for t in ends if 0.0 < t <= t_end)

    @property
    def period(self) -> float | None:
        """Length of a repeated table [s]."""
        return self.times[-1] - self.times[0] if self.periodic else None

    def longest_chord(self, begin: float, end: float) -> float:  # noqa: ARG002 - the same at all times
        """Least distance of the points that are left when as many are left out as the swing allows."""
        times, values, stride = np.array(self.times), np.array(self.values), len(self.times) - 1
        while True:
            kept = np.union1d(np.arange(0, len(times), stride), len(times) - 1)
            missed = np.abs(np.interp(times, times[kept], values[kept]) - values).max()
            if stride == 1 or missed <= CHORD * swing_of(times, values):
                return float(np.diff(times[kept]).max() if len(kept) < 3 else np.diff(times[kept[:-1]]).min())
            stride = (stride + 1) // 2
