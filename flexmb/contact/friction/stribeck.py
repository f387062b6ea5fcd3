"""Stribeck friction, smoothed at rest."""

import math
from dataclasses import dataclass

from flexmb import checks
from flexmb.contact.friction.creep import first_balance, static_not_below_kinetic
from flexmb.contact.friction.creep import load_ratio as checked_ratio
from flexmb.errors import InputError
from flexmb.kernels import friction_law
from flexmb.model.law import FrictionLaw


@friction_law
def stribeck_kernel(p, h, slip, N, z, z_new):
    """T = -N [(mu_k + (mu_s - mu_k) exp(-|slip/vs|^n)) tanh(slip/v0) + c slip]."""
    mu_s, mu_k, vs, v0, n, c = p
    s = abs(slip) / vs
    power = s**n
    fall = (mu_s - mu_k) * math.exp(-power)
    c0 = math.tanh(slip / v0)
    mu = (mu_k + fall) * c0 + c * slip
    by_speed = -n * fall * (power / s if s > 0.0 else 0.0) / vs
    slope = by_speed * abs(c0) + (mu_k + fall) * (1.0 - c0 * c0) / v0 + c
    return -mu * N, -slope * N, -mu


@dataclass(frozen=True)
class Stribeck(FrictionLaw):
    """Friction that falls from static to kinetic with the slip speed, and may rise again.

    T = -N {[mu_k + (mu_s - mu_k) exp(-|slip/v_s|^n)] tanh(slip/v0) + c slip}.

    Equation (5.14) of docs/theory/contact.md.

    Parameters
    ----------
    static : mu_s >= mu_k.
    kinetic : mu_k >= 0.
    stribeck_speed : v_s, slip speed of the fall [m/s], > 0.
    v0 : slip speed of the rise from rest [m/s], 0 < v0 < stribeck_speed.
    exponent : n >= 1; 2 gives a bell, 1 an exponential.
    viscous : c >= 0 [s/m], of the part that rises with the slip; in proportion to N, so it ends with the contact.

    Raises
    ------
    InputError : a negative coefficient, static < kinetic, a speed <= 0, v0 >= stribeck_speed, exponent < 1.

    Notes
    -----
    Nothing sticks: the contact creeps under load at the speed that `creep_speed` finds, v0 artanh(r) when v0 << v_s.
    The largest force stays below mu_s N, by (v0/v_s)^n and more: choose v0 ten times below v_s.
    Source: L. C. Bo, D. Pavelescu, The friction-speed relation and its influence on the critical velocity of
    stick-slip motion, Wear 82 (1982) 277-289, for the curve; B. Armstrong-Helouvry, P. Dupont, C. Canudas de Wit, A
    survey of models, analysis tools and compensation methods for the control of machines with friction, Automatica 30
    (1994) 1083-1138; tanh for the sign as in S. Andersson, A. Soderberg, S. Bjorklund, Tribology International 40
    (2007) 580-587.
    """

    static: float
    kinetic: float
    stribeck_speed: float = 1e-2
    v0: float = 1e-3
    exponent: float = 2.0
    viscous: float = 0.0

    kernel = stribeck_kernel

    def __post_init__(self) -> None:
        super().__post_init__()
        static_not_below_kinetic("Stribeck", self.static, self.kinetic)
        checks.positive("Stribeck", "stribeck_speed", self.stribeck_speed, "m/s")
        checks.positive("Stribeck", "v0", self.v0, "m/s")
        checks.between(
            "Stribeck", "v0", self.v0, 0.0, math.nextafter(self.stribeck_speed, 0.0), "m/s",
            "Friction must rise faster than it falls; choose v0 ten times below stribeck_speed.",
        )  # fmt: skip
        checks.not_negative("Stribeck", "viscous", self.viscous, "s/m")
        if self.exponent < 1.0:
            raise InputError(f"Stribeck: exponent is {self.exponent:g}; it must be >= 1, or the slope has no bound.")

    def creep_speed(self, load_ratio: float) -> float:
        """Slip speed [m/s] that balances the tangential load `load_ratio` mu_s N; inf where no speed of creep does."""
        r = checked_ratio("Stribeck", load_ratio)
        return first_balance(self, r * self.static, 3.0 * self.stribeck_speed)
