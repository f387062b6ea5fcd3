"""Friction law of Bengisu and Akay."""

import math
from dataclasses import dataclass

from flexmb import checks
from flexmb.contact.friction.creep import load_ratio as checked_ratio
from flexmb.contact.friction.creep import static_not_below_kinetic
from flexmb.kernels import friction_law
from flexmb.model.law import FrictionLaw


@friction_law
def bengisu_akay_kernel(p, h, slip, N, z, z_new):
    """|T| = N mu(|slip|): a parabola up to (v0, mu_s), then an exponential down to mu_k."""
    mu_s, mu_k, v0, xi = p
    v = abs(slip)
    if v <= v0:
        left = 1.0 - v / v0
        mu = mu_s * (1.0 - left * left)
        slope = 2.0 * mu_s * left / v0
    else:
        fall = (mu_s - mu_k) * math.exp(-xi * (v - v0))
        mu = mu_k + fall
        slope = -xi * fall
    signed = math.copysign(mu, slip)
    return -signed * N, -slope * N, -signed


@dataclass(frozen=True)
class BengisuAkay(FrictionLaw):
    """Static friction reached on a parabola at v0, falling to kinetic friction exponentially.

    |T| / N = mu_s [1 - (|slip|/v0 - 1)^2] up to v0, mu_k + (mu_s - mu_k) exp(-xi (|slip| - v0)) beyond.

    Parameters
    ----------
    static : mu_s >= mu_k.
    kinetic : mu_k >= 0.
    v0 : slip speed at which mu_s is reached [m/s], > 0.
    decay : xi [s/m], > 0, rate of the fall from mu_s to mu_k.

    Raises
    ------
    InputError : a negative coefficient, static < kinetic, v0 or decay <= 0.

    Notes
    -----
    Nothing sticks: under a tangential load of r mu_s N, r <= 1, the contact creeps at v0 [1 - sqrt(1 - r)].
    The falling branch is a negative damping that drives stick-slip; steps must stay below 2 m / [xi (mu_s - mu_k) N]
    where a mass m passes through it, or a step has more than one solution.
    Source: M. T. Bengisu, A. Akay, Stability of friction-induced vibrations in multi-degree-of-freedom systems, Journal
    of Sound and Vibration 171 (1994) 557-570; F. Marques et al., Nonlinear Dynamics 86 (2016) 1407-1443.
    """

    static: float
    kinetic: float
    v0: float = 1e-3
    decay: float = 1e3

    kernel = bengisu_akay_kernel

    def __post_init__(self) -> None:
        super().__post_init__()
        static_not_below_kinetic("BengisuAkay", self.static, self.kinetic)
        checks.positive("BengisuAkay", "v0", self.v0, "m/s")
        checks.positive("BengisuAkay", "decay", self.decay, "s/m")

    def creep_speed(self, load_ratio: float) -> float:
        """Slip speed [m/s] that balances the tangential load `load_ratio` mu_s N; inf where no speed does."""
        r = checked_ratio("BengisuAkay", load_ratio)
        return self.v0 * (1.0 - math.sqrt(1.0 - r)) if r <= 1.0 else math.inf
