"""Friction law of Threlfall."""

import math
from dataclasses import dataclass

from flexmb import checks
from flexmb.contact.friction.creep import load_ratio as checked_ratio
from flexmb.kernels import friction_law
from flexmb.model.law import FrictionLaw


@friction_law
def threlfall_kernel(p, h, slip, N, z, z_new):
    """T = -mu N (1 - exp(-3 |slip| / v0)) sign(slip)."""
    mu, v0 = p
    short = -math.expm1(-3.0 * abs(slip) / v0)
    c = math.copysign(short, slip)
    return -mu * N * c, -3.0 * mu * N * (1.0 - short) / v0, -mu * c


@dataclass(frozen=True)
class Threlfall(FrictionLaw):
    """Coulomb friction that rises exponentially with the slip speed, T = -mu N (1 - exp(-3 |slip|/v0)) sign(slip).

    Parameters
    ----------
    coefficient : mu >= 0.
    v0 : slip speed at which 95 % of mu N are reached [m/s], > 0.

    Raises
    ------
    InputError : a negative coefficient, v0 <= 0.

    Notes
    -----
    Nothing sticks: under a tangential load of r mu N, r < 1, the contact creeps at -(v0/3) ln(1 - r).  The slope is
    continuous through zero slip, its derivative is not.  The surveys hold the force at 0.95 mu N above v0; here the
    exponential goes on to mu N, without a corner.
    Source: D. C. Threlfall, The inclusion of Coulomb friction in mechanisms programs with particular reference to DRAM,
    Mechanism and Machine Theory 13 (1978) 475-483; F. Marques et al., Nonlinear Dynamics 86 (2016) 1407-1443.
    """

    coefficient: float
    v0: float = 1e-3

    kernel = threlfall_kernel

    def __post_init__(self) -> None:
        super().__post_init__()
        checks.not_negative("Threlfall", "coefficient", self.coefficient)
        checks.positive("Threlfall", "v0", self.v0, "m/s")

    def creep_speed(self, load_ratio: float) -> float:
        """Slip speed [m/s] that balances the tangential load `load_ratio` mu N; inf where no speed does."""
        r = checked_ratio("Threlfall", load_ratio)
        return -self.v0 / 3.0 * math.log1p(-r) if r < 1.0 else math.inf
