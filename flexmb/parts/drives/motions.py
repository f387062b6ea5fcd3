"""Motions by formulas and by points in time; each is a `Motion` of `model/law.py`."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from flexmb import checks
from flexmb.errors import InputError, ModelError
from flexmb.fields import field, instance, number, positive, record, several, two, variant
from flexmb.findings.finding import Finding, found
from flexmb.kernels import drive_kernel
from flexmb.late import scipy
from flexmb.model.contributions import ConstraintContribution, Contribution, RowMotion
from flexmb.model.law import CHORD, CHORDS_OF_A_SINE, Motion, swing_of
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import GROUND, Joint, Part, WatchedMotion


@drive_kernel
def constant_speed_kernel(p, t):
    """s = w t."""
    (w,) = p
    return w * t, w, 0.0


@record
class Turning(Motion):
    """Base of motions that end at a constant speed."""

    speed: float = field("speed of an angle or a travel", "rad/s or m/s")

    swings = False

    @property
    def period(self) -> float | None:
        return 2.0 * math.pi / abs(self.speed) if self.speed else None


@variant
class ConstantSpeed(Turning):
    """s = speed t."""

    kernel = constant_speed_kernel


@drive_kernel
def harmonic_kernel(p, t):
    """s = m + A sin(w t + phi)."""
    A, w, phi, m = p
    c, s = math.cos(w * t + phi), math.sin(w * t + phi)
    return m + A * s, A * w * c, -A * w * w * s


@record
class Harmonic(Motion):
    """s = mean + amplitude sin(2 pi frequency t + phase).

    Raises
    ------
    InputError : a frequency that is not > 0.

    Notes
    -----
    A drive counts the motion from the reference configuration: at t = 0 the joint stands at mean + amplitude sin(phase)
    and has the speed of the motion.

    Examples
    --------
    >>> Harmonic(0.1, frequency=4.0).period
    0.25
    """

    amplitude: float = field("largest deviation from the mean; a number for the factor of a load", "rad or m")
    frequency: float = field("cycles a second; an angular speed divided by 2 pi", "Hz", positive)
    phase: float = field("angle at t = 0; pi/2 makes a cosine", "rad", default=0.0)
    mean: float = field("mean value", "rad or m", default=0.0)

    kernel = harmonic_kernel

    def parameters(self) -> tuple[float, ...]:
        """Amplitude, angular speed [rad/s], phase, mean."""
        return self.amplitude, 2.0 * math.pi * self.frequency, self.phase, self.mean

    @property
    def period(self) -> float | None:
        return 1.0 / self.frequency

    def longest_chord(self, begin: float, end: float) -> float:  # noqa: ARG002 - the same at all times
        """A twentieth of a cycle."""
        return 1.0 / (CHORDS_OF_A_SINE * self.frequency) if self.amplitude else math.inf


@drive_kernel
def polynomial_kernel(p, t):
    """s = p0 + p1 t + p2 t^2 + ... by Horner's rule."""
    s, v, half_a = 0.0, 0.0, 0.0
    for k in range(p.shape[0] - 1, -1, -1):
        half_a = half_a * t + v
        v = v * t + s
        s = s * t + p[k]
    return s, v, 2.0 * half_a


@record
class Polynomial(Motion):
    """s = c0 + c1 t + c2 t^2 + ...

    Raises
    ------
    InputError : no coefficient, or one that is not finite.
    """

    coefficients: Sequence[float] = field("c0, c1, ... of t^k; rad or m over s^k", rule=several(number, "numbers"))

    kernel = polynomial_kernel
    swings = False

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.coefficients:
            raise InputError("Polynomial: coefficients is empty; give at least one, e.g. (0.0, 6.28).")

    def parameters(self) -> tuple[float, ...]:
        return tuple(self.coefficients)


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


@record
class SpinUp(Turning):
    """Base of motions from rest to a constant speed.

    Raises
    ------
    InputError : a time that is not > 0.
    """

    speed: float = field("final speed w of an angle or a travel", "rad/s or m/s")
    time: float = field("duration T of the start", "s", positive)


@variant
class Ramp(SpinUp):
    """From rest to `speed` within `time`, with continuous acceleration and jerk-free ends.

    s_dot = w x^3 (10 - 15 x + 6 x^2) with x = t/T up to T, then w
    """

    kernel = ramp_kernel


@variant
class CycloidalRamp(SpinUp):
    """From rest to `speed` within `time`; the acceleration is a full wave 1 - cos and vanishes at both ends.

        s = (w/T) [t^2/2 + (T/2 pi)^2 (cos(2 pi t/T) - 1)] up to T, then w (t - T/2)

    Notes
    -----
    Acceleration and its rate are continuous.  Source: the spin-up manoeuvre of J. C. Simo, L. Vu-Quoc, On the dynamics
    of flexible beams under large overall motions, part II, J. Applied Mechanics 53 (1986) 855-863.
    """

    kernel = cycloidal_ramp_kernel


MOST_OVERSHOOT = 0.1  # share of a table's range by which its spline may pass its points, or go on after its end, untold


@record
class Points(Motion):
    """Base of motions and histories through points in time."""

    times: Sequence[float] = field("increasing instants, at least 2, of a `Table` 4", "s", several(number, "numbers"))
    values: Sequence[float] = field("the factor at these instants", rule=several(number, "numbers"))

    fewest = 2  # number of points at least

    def __post_init__(self) -> None:
        super().__post_init__()
        owner, count = type(self).__name__, len(self.times)
        if count < self.fewest or count != len(self.values):
            text = f"{owner}: {count} times and {len(self.values)} values;"
            raise InputError(f"{text} give at least {self.fewest} of each, equally many.")
        if any(b <= a for a, b in pairwise(self.times)):
            raise InputError(f"{owner}: times do not increase; sort them and remove duplicates.")


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


@record
class PiecewiseLinear(Points):
    """Straight lines between points, before the first and after the last one constant.

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

    kernel = piecewise_linear_kernel
    is_smooth = swings = False

    def parameters(self) -> tuple[float, ...]:
        return *self.times, *self.values

    def breaks(self, t_end: float) -> tuple[float, ...]:
        return tuple(t for t in self.times if 0.0 < t <= t_end)


@drive_kernel
def pulse_kernel(p, t):
    """s = value for start <= t < end."""
    value, start, end = p
    return (value if start <= t < end else 0.0), 0.0, 0.0


SHORTEST_PULSE = 4e-12  # shortest length of a pulse over its end, four times the round-off of an end of a run


@record
class Pulse(Motion):
    """s = value for start <= t < end, else 0: a load that is switched on and off.

    Raises
    ------
    InputError : an end that does not lie after the start.

    Notes
    -----
    The value jumps, so a pulse can be the history of a load but cannot drive a joint.  A run ends a step at each jump
    and starts anew there, so the method keeps its order.

    Examples
    --------
    >>> Pulse(2.0, start=1.0, end=3.0).breaks(10.0)
    (1.0, 3.0)
    """

    value: float = field("the factor from start to end", default=1.0)
    start: float = field("first instant; 0: from the beginning", "s", default=0.0)
    end: float | None = field("end of the pulse, > start; None: no end", "s", default=None)

    kernel = pulse_kernel
    is_smooth = swings = False

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.end is not None and self.end - self.start <= SHORTEST_PULSE * max(self.end, 0.0):
            text = f"Pulse: end is {self.end!r} s; it must be > start = {self.start!r} s"
            raise InputError(f"{text}, by {SHORTEST_PULSE:g} of it at least: steps cannot part such times.")

    def parameters(self) -> tuple[float, ...]:
        """Value, start, end (infinity: no end)."""
        return self.value, self.start, math.inf if self.end is None else self.end

    def breaks(self, t_end: float) -> tuple[float, ...]:
        return tuple(t for t in self.parameters()[1:] if 0.0 < t <= t_end)


COUNT, PERIODIC, TIMES = range(3)
# Places at the beginning of p, see `table_kernel`, and of the coefficients of a piece.
CUBIC, SQUARE, LINEAR, CONSTANT = range(4)


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
    k, x = contributions + 4 * low, min(max(t, first), last) - p[TIMES + low]
    beyond = t - min(max(t, first), last)  # outside the table the motion goes on at the speed of the end
    c3, c2, c1, c0 = p[k + CUBIC], p[k + SQUARE], p[k + LINEAR], p[k + CONSTANT]
    v = (3.0 * c3 * x + 2.0 * c2) * x + c1
    a = 6.0 * c3 * x + 2.0 * c2 if beyond == 0.0 else 0.0
    return ((c3 * x + c2) * x + c1) * x + c0 + v * beyond + rest, v, a


@record
class Table(Points):
    """Cubic spline through points, continuous in acceleration.

    Raises
    ------
    InputError : too few points, times that do not increase, values or slopes that are not finite, slopes of a
        repeated table.

    Notes
    -----
    With slopes it is a clamped spline; (0, 0) begins and ends at rest.  Without, the third derivative does not jump at
    the second point and the last but one (not-a-knot spline).  A repeated motion may grow by values[-1] - values[0] a
    period.  Outside a table that is not repeated the motion goes on at the speed of its end; the acceleration jumps
    there, so a run ends a step at that instant.  Inside, the acceleration has kinks at the points; methods of second
    order keep their order there.
    """

    values: Sequence[float] = field("the motion at these instants", "rad or m", several(number, "numbers"))
    periodic: bool = field("whether the table is repeated", default=False)
    slopes: tuple[float, float] | None = field(
        "speeds at both ends", "rad/s or m/s", two(number, "numbers", "two speeds, e.g. (0.0, 0.0)"), default=None
    )

    kernel = table_kernel
    fewest = 4

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.slopes is not None and self.periodic:
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
            c = scipy.interpolate.CubicSpline(t, wave, bc_type="periodic").c.copy()
            c[2] += slope
            c[3] += straight[:-1]
        else:
            ends = "not-a-knot" if self.slopes is None else tuple((1, slope) for slope in self.slopes)
            c = scipy.interpolate.CubicSpline(t, s, bc_type=ends).c
        return (float(len(t)), float(self.periodic), *t.tolist(), *c.T.ravel().tolist(), growth)

    def findings(self, part: str) -> Iterator[Finding]:
        """Finding on a spline that leaves the range of two neighbouring points by much."""
        times, values, p = self.times, np.array(self.values), np.array(self.parameters(), dtype=float)
        whole, worst, at = float(np.ptp(values)), 0.0, 0
        for k, ends in enumerate(pairwise(times)):
            between = [self.kernel(p, float(t))[0] for t in np.linspace(*ends, 12)[1:-1]]
            low, high = sorted((values[k], values[k + 1]))
            beyond = max(max(between) - high, low - min(between))
            if beyond > worst:
                worst, at = float(beyond), k
        if whole > 0.0 and worst > MOST_OVERSHOOT * whole:
            text = f"The table of {part!r} overshoots its points by {worst:.4g} between t = {times[at]:.6g}"
            text += f" and {times[at + 1]:.6g} s, where they differ by {abs(values[at + 1] - values[at]):.4g}."
            remedy = "Give points of nearly even distance, or use PiecewiseLinear for loads and CycloidalRamp for "
            remedy += "drives."
            yield found("overshooting-table", (part,), text, remedy, time=times[at], overshoot=worst)

    def findings_beyond(self, part: str, t: float) -> Iterator[Finding]:
        """Finding on a part that went on by much since its table ended."""
        values, p = np.array(self.values), np.array(self.parameters(), dtype=float)
        value = float(self.kernel(p, t)[0])
        if t > self.times[-1] and not self.periodic and abs(value - values[-1]) > MOST_OVERSHOOT * np.ptp(values):
            text = f"The table of {part!r} ends at t = {self.times[-1]:.6g} s with {values[-1]:.4g}; it went on at its"
            text += f" last slope to {value:.4g} at t = {t:.6g} s."
            remedy = "Give points up to the end of the run or slopes=(..., 0.0); PiecewiseLinear, for loads, stays"
            yield found("short-table", (part,), text, f"{remedy} at its last value.", time=t, value=value)

    def breaks(self, t_end: float) -> tuple[float, ...]:
        """Begin and end of a table that is not repeated; the end lies just after its last instant."""
        ends = (self.times[0], self.times[-1] + 4.0 * float(np.spacing(abs(self.times[-1]))))
        return () if self.periodic else tuple(t for t in ends if 0.0 < t <= t_end)

    @property
    def period(self) -> float | None:
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


FASTEST = 2e4  # angular speed of a drive above which there is a finding [rad/s]
# Centripetal acceleration of a joint on a driven body above which there is one [m/s^2]; pistons of racing engines reach
# 0.9e5.
LARGEST_ACCELERATION = 1e5
STANDARD_GRAVITY = 9.80665


@record
class Drive(Part):
    """Prescribed angle of a revolute joint, or travel of a prismatic one, counted from the reference configuration.

    Signals: angle [rad], speed [rad/s], torque (on the second body) [N m], power [W]; of a prismatic joint travel [m],
    speed [m/s], force (on the second body) [N], power [W].

    Equation (1.6) of docs/theory/equations_of_motion.md.

    Raises
    ------
    ModelError : no such joint, a joint that cannot be driven, or one that is driven already.
    InputError : an object that is no motion, or a motion that jumps.
    """

    by_name = ("joint",)
    joint: Part | str = field("the joint, or its name")
    motion: Motion = field("the motion", rule=instance(Motion, "a motion, e.g. ConstantSpeed(6.28)"))

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.motion.is_smooth:
            text = f"{self.label}: motion is {type(self.motion).__name__}(...), whose value or speed jumps;"
            text += " a joint would need an infinite force to follow. Drive it with Table, Ramp, CycloidalRamp"
            raise InputError(f"{text} or Harmonic; a motion that jumps can be the history of a Force or Torque.")

    def validate(self, mechanism: Mechanism) -> None:
        """Check that the joint exists, can be driven, and is driven once."""
        self._measure(mechanism)
        same = [part for part in mechanism.parts if isinstance(part, Drive) and part.joint == self.joint]
        if len(same) > 1 and same[0].name == self.name:  # told once
            labels, word = " and ".join(part.label for part in same), "both" if len(same) == 2 else "all"
            raise ModelError(f"{labels} {word} drive joint {self.joint!r}. Keep one of them.")

    def findings_before(self, mechanism: Mechanism) -> Iterator[Finding]:
        """Finding on a drive that turns too fast for the joints on its bodies."""
        joint, speed = mechanism.find(self.joint), vars(self.motion).get("speed")
        if not isinstance(speed, float | int) or not isinstance(joint, Joint):
            return
        driven = {joint.first.name, joint.second.name} - {GROUND.name}
        joints = [one for one in mechanism.parts if isinstance(one, Joint) and one.at is not None]
        near = [one for one in joints if joint.at is not None and {one.first.name, one.second.name} & driven]
        arm = max((math.dist(joint.at, one.at) for one in near), default=0.0)
        acceleration = speed * speed * arm
        if (abs(speed) > FASTEST or acceleration > LARGEST_ACCELERATION) and joint.can_be_turned(mechanism):
            text = f"{self.label} turns at {speed:.4g} rad/s, {speed * 30.0 / math.pi:.4g} rpm"
            text += f": at {arm:.3g} m from the joint that is {acceleration / STANDARD_GRAVITY:.3g} g" if arm else ""
            right = speed * math.pi / 30.0
            remedy = f"Speeds are in rad/s: 2 pi/60 times those in rpm; {speed:.4g} rpm are {right:.4g}."
            yield found("odd-units", (self.name,), f"{text}.", remedy, speed=speed, acceleration=acceleration)

    def findings_after(self, mechanism: Mechanism, motion: WatchedMotion) -> Iterator[Finding]:  # noqa: ARG002 - the same
        """The findings of `findings_before`: a run may begin without an examination."""
        return self.findings_before(mechanism)

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        measure = self._measure(mechanism)
        motion = RowMotion(measure.rows - 1, self.motion, units=measure.drive_units)
        return [replace(measure, part=self.name, motions=(motion,))]

    def _measure(self, mechanism: Mechanism) -> ConstraintContribution:
        if self.joint not in (*mechanism.names, GROUND.name):
            text = f"{self.label} drives joint {self.joint!r}, but mechanism {mechanism.name!r} has no such part."
            raise ModelError(f"{text} {self._drivable(mechanism)}")
        part = mechanism.find(self.joint)
        contribution = part.drive_contribution(mechanism) if isinstance(part, Joint) else None
        if contribution is None:
            text = f"{self.label}: {part.label} cannot be driven. Drive the angle of a"
            raise ModelError(f"{text} Revolute or the travel of a Prismatic. {self._drivable(mechanism)}")
        return contribution

    def _drivable(self, mechanism: Mechanism) -> str:
        """Hint with the joints that a drive can prescribe."""
        joints = [part for part in mechanism.parts if isinstance(part, Joint)]
        names = [part.name for part in joints if type(part).drive_contribution is not Joint.drive_contribution]
        return checks.did_you_mean(self.joint, names, what="Joints that can be driven") if names else ""
