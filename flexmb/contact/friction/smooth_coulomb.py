"""Coulomb friction smoothed by a hyperbolic tangent."""

import math
from dataclasses import dataclass

from flexmb import checks
from flexmb.contact.friction.creep import load_ratio as checked_ratio
from flexmb.kernels import friction_law
from flexmb.model.law import FrictionLaw


@friction_law
def smooth_coulomb_kernel(p, h, slip, N, z, z_new):
    """T = -mu N tanh(slip / v0)."""
    mu, v0 = p
    return -mu * N * math.tanh(slip / v0)


@dataclass(frozen=True)
class SmoothCoulomb(FrictionLaw):
    """Coulomb friction without a corner, T = -mu N tanh(slip/v0).

    Parameters
    ----------
    coefficient : mu >= 0.
    v0 : slip speed at which 76 % of mu N are reached [m/s], > 0.

    Raises
    ------
    InputError : a negative coefficient, v0 <= 0.

    Notes
    -----
    Nothing sticks: under a tangential load of r mu N, r < 1, the contact creeps at v0 artanh(r).  For sliding, and
    where slow creep does not matter; not for stick-slip, since static and kinetic friction are the same.
    Source: the family of smooth Coulomb laws in F. Marques, P. Flores, J. C. Pimenta Claro,
    H. M. Lankarani, A survey and comparison of several friction force models for dynamic analysis of multibody
    mechanical systems, Nonlinear Dynamics 86 (2016) 1407-1443.
    """

    coefficient: float
    v0: float = 1e-3

    kernel = smooth_coulomb_kernel

    def __post_init__(self) -> None:
        super().__post_init__()
        checks.not_negative("SmoothCoulomb", "coefficient", self.coefficient)
        checks.positive("SmoothCoulomb", "v0", self.v0, "m/s")

    def creep_speed(self, load_ratio: float) -> float:
        """Slip speed [m/s] that balances the tangential load `load_ratio` mu N; inf where no speed does."""
        r = checked_ratio("SmoothCoulomb", load_ratio)
        return self.v0 * math.atanh(r) if r < 1.0 else math.inf
