"""Motions by formulas: constant speed, ramps, sines, polynomials."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from flexmb import checks
from flexmb.docstrings import documented
from flexmb.errors import InputError
from flexmb.kernels import drive_kernel
from flexmb.model.law import CHORDS_OF_A_SINE, Motion

# Motion at constant speed


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


# Sinusoidal motion


@drive_kernel
def harmonic_kernel(p, t):
    """s = m + A sin(w t + phi)."""
    A, w, phi, m = p
    c, s = math.cos(w * t + phi), math.sin(w * t + phi)
    return m + A * s, A * w * c, -A * w * w * s


@dataclass(frozen=True)
class Harmonic(Motion):
    """s = mean + amplitude sin(2 pi frequency t + phase).

    Parameters
    ----------
    amplitude : largest deviation from the mean, rad for an angle, m for a travel, a number for the factor of a load.
    frequency : cycles a second [Hz], > 0; an angular speed divided by 2 pi.
    phase : angle at t = 0 [rad]; pi/2 makes a cosine.
    mean : middle, in the unit of the amplitude.

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

    amplitude: float
    frequency: float
    phase: float = 0.0
    mean: float = 0.0

    kernel = harmonic_kernel

    def __post_init__(self) -> None:
        super().__post_init__()
        checks.positive("Harmonic", "frequency", self.frequency, "Hz")

    def parameters(self) -> tuple[float, ...]:
        """Amplitude, angular speed [rad/s], phase, mean."""
        return self.amplitude, 2.0 * math.pi * self.frequency, self.phase, self.mean

    @property
    def period(self) -> float | None:
        """One cycle [s]."""
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


@dataclass(frozen=True)
class Polynomial(Motion):
    """s = c0 + c1 t + c2 t^2 + ...

    Parameters
    ----------
    coefficients : c0, c1, ... [rad or m, over s^k].

    Raises
    ------
    InputError : no coefficient, or one that is not finite.
    """

    coefficients: Sequence[float]

    kernel = polynomial_kernel
    swings = False

    def __post_init__(self) -> None:
        super().__post_init__()
        given = checks.sequence("Polynomial", "coefficients", self.coefficients, "numbers")
        values = tuple(checks.number("Polynomial", f"coefficients[{i}]", c) for i, c in enumerate(given))
        if not values:
            raise InputError("Polynomial: coefficients is empty; give at least one, e.g. (0.0, 6.28).")
        object.__setattr__(self, "coefficients", values)

    def parameters(self) -> tuple[float, ...]:
        """The coefficients."""
        return tuple(self.coefficients)


# Starts from rest to a constant speed


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
