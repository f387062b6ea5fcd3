"""Sinusoidal motion."""

from __future__ import annotations

import math
from dataclasses import dataclass

from flexmb import checks
from flexmb.kernels import drive_kernel
from flexmb.model.law import CHORDS_OF_A_SINE, Motion


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
