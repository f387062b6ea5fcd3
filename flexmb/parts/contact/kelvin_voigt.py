"""Normal law of Kelvin and Voigt: a spring beside a damper."""

from __future__ import annotations

import math
from typing import Self

from flexmb import checks
from flexmb.errors import InputError
from flexmb.fields import field, not_negative, positive, record
from flexmb.kernels import normal_law
from flexmb.model.law import NormalLaw
from flexmb.parts.contact import validity
from flexmb.parts.contact.onset import reference_speed


@normal_law
def kelvin_voigt_kernel(p, h, gap, gap_rate, z, z_new):
    """N = K depth + C s depth_rate, never pulling; s grows from 0 to 1 over the depth `ramp`."""
    K, C, ramp = p
    reference_speed(h, gap, gap_rate, 0.0, False, 1.0, z, z_new)
    if gap >= 0.0:
        validity.keep_extremes(0.0, 0.0, 0.0, 0.0, z, z_new)
        return 0.0, 0.0, 0.0
    s, s_depth = 1.0, 0.0
    if -gap < ramp:
        x = -gap / ramp
        s, s_depth = x * x * (3.0 - 2.0 * x), 6.0 * x * (1.0 - x) / ramp
    N = -K * gap - C * s * gap_rate
    if N <= 0.0:
        validity.keep_extremes(-gap, 0.0, -N, 0.0, z, z_new)
        return 0.0, 0.0, 0.0
    validity.keep_extremes(-gap, N, 0.0, 0.0, z, z_new)
    return N, -K + C * s_depth * gap_rate, -C * s


@record
class KelvinVoigt(NormalLaw):
    """Linear spring beside a linear damper, N = K depth + C depth_rate, cut at zero so that it never pulls.

    Equation (5.10) of docs/theory/contact.md.

    Raises
    ------
    InputError : values out of range.

    Notes
    -----
    The force jumps by C times the approach speed at the onset.  Newton's method does not converge on a jump, so fixed
    steps can end a run there.  Error-controlled steps pass the jump; a `ramp` of several steps removes it: up to that
    depth the damper force grows as 3 x^2 - 2 x^3 of x = depth/ramp.
    The restitution depends on the mass: `for_restitution` and `delivered_restitution` hold for a free impact of a
    reduced mass, without ramp.
    Source: W. Goldsmith, Impact: The Theory and Physical Behaviour of Colliding Solids, Edward Arnold 1960, for the
    law; the cut at zero is that of any contact without adhesion.
    """

    stiffness: float = field("K", "N/m", positive)
    damping: float = field("C", "N s/m", not_negative)
    ramp: float = field("depth over which the damper force grows; 0: it acts at once", "m", not_negative, default=0.0)

    kernel = kelvin_voigt_kernel

    @classmethod
    def for_restitution(cls, stiffness: float, restitution: float, mass: float) -> Self:
        """The law, without ramp, whose free impacts return `restitution`.

        Parameters
        ----------
        stiffness : K [N/m], > 0.
        restitution : e, in (0, 1].
        mass : reduced mass m1 m2/(m1 + m2) of the two bodies [kg], > 0.
        """
        name = "KelvinVoigt.for_restitution"
        K, m = checks.positive(name, "stiffness", stiffness, "N/m"), checks.positive(name, "mass", mass, "kg")
        e = checks.between(name, "restitution", checks.positive(name, "restitution", restitution), 0.0, 1.0)
        low, high = 0.0, 1.0
        while _restitution(high) > e:
            low, high = high, 2.0 * high
        while low < 0.5 * (low + high) < high:
            zeta = 0.5 * (low + high)
            low, high = (zeta, high) if _restitution(zeta) > e else (low, zeta)
        return cls(K, 2.0 * low * math.sqrt(K * m))

    def delivered_restitution(self, mass: float) -> float:
        """The restitution of a free impact of the reduced `mass` [kg]; exact, for a law without ramp.

        With zeta = C/(2 sqrt(K m)) = cos(theta), the force falls to zero at the angle 2 theta and from there on the
        bodies fly apart: e = exp(-2 theta cot(theta)); for zeta = cosh(theta) > 1, e = exp(-2 theta coth(theta)).

        Equation (5.11) of docs/theory/contact.md.
        """
        m = checks.positive("KelvinVoigt", "mass", mass, "kg")
        if self.ramp > 0.0:
            text = f"KelvinVoigt: ramp is {self.ramp:g} m; with a ramp the restitution depends on the speed"
            raise InputError(f"{text}. Ask the law with ramp=0, and simulate for the difference.")
        return _restitution(self.damping / (2.0 * math.sqrt(self.stiffness * m)))

    def history(self) -> tuple[float, ...]:
        return validity.HISTORY_WITH_EXTREMES


def _restitution(zeta: float) -> float:
    """e for the damping ratio zeta >= 0, with the force cut at zero."""
    if zeta == 1.0:
        return math.exp(-2.0)
    if zeta < 1.0:
        theta = math.acos(zeta)
        return math.exp(-2.0 * theta / math.tan(theta))
    theta = math.acosh(zeta)
    return math.exp(-2.0 * theta / math.tanh(theta))
