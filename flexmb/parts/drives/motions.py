"""Motions by formulas: constant speed, ramps, sines, polynomials."""

from __future__ import annotations

import math
from collections.abc import Sequence

from flexmb.errors import InputError
from flexmb.fields import field, number, positive, record, several, variant
from flexmb.kernels import drive_kernel
from flexmb.model.law import CHORDS_OF_A_SINE, Motion


@drive_kernel
def constant_speed_kernel(p, t):
    """s = w t."""
    (w,) = p
    return w * t, w, 0.0


@record
class ConstantSpeed(Motion):
    """s = speed t."""

    speed: float = field("speed of an angle or a travel", "rad/s or m/s")

    kernel = constant_speed_kernel
    swings = False

    @property
    def period(self) -> float | None:
        return 2.0 * math.pi / abs(self.speed) if self.speed else None


# Sinusoidal motion
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


# Motion given by a polynomial in time
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
class SpinUp(Motion):
    """Base of motions from rest to a constant speed.

    Raises
    ------
    InputError : a time that is not > 0.
    """

    swings = False

    speed: float = field("final speed w of an angle or a travel", "rad/s or m/s")
    time: float = field("duration T of the start", "s", positive)

    @property
    def period(self) -> float | None:
        return 2.0 * math.pi / abs(self.speed) if self.speed else None


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
