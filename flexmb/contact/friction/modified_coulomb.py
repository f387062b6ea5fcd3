"""Modified Coulomb friction of Ambrosio."""

import math
from dataclasses import dataclass

from flexmb import checks
from flexmb.contact.friction.creep import load_ratio as checked_ratio
from flexmb.errors import InputError
from flexmb.kernels import friction_law
from flexmb.model.law import FrictionLaw


@friction_law
def modified_coulomb_kernel(p, h, slip, N, z, z_new):
    """T = -mu cd N sign(slip); cd rises from 0 at |slip| = v0 to 1 at v1."""
    mu, v0, v1 = p
    speed = abs(slip)
    if speed <= v0:
        return 0.0, 0.0, 0.0
    sign = 1.0 if slip > 0.0 else -1.0
    if speed >= v1:
        return -mu * N * sign, 0.0, -mu * sign
    cd = (speed - v0) / (v1 - v0)
    return -mu * cd * N * sign, -mu * N / (v1 - v0), -mu * cd * sign


@dataclass(frozen=True)
class ModifiedCoulomb(FrictionLaw):
    """Coulomb friction that rises from nothing at the slip speed v0 to mu N at v1.

    Equation (5.13) of docs/theory/contact.md.

    Parameters
    ----------
    coefficient : mu >= 0.
    v0, v1 : slip speeds [m/s], 0 <= v0 < v1.

    Raises
    ------
    InputError : a negative coefficient, v0 >= v1.

    Notes
    -----
    There is no force below v0, so nothing sticks: under a tangential load of r mu N, 0 < r <= 1, the contact creeps at
    v0 + r (v1 - v0).
    Source: J. Ambrosio, in W. Schiehlen (ed.), Virtual Nonlinear Multibody Systems, Kluwer 2003, 57-81;
    equations (7)-(8) of Chen et al., Nonlinear Dynamics (2018).
    """

    coefficient: float
    v0: float = 1e-4
    v1: float = 1e-3

    kernel = modified_coulomb_kernel

    def __post_init__(self) -> None:
        super().__post_init__()
        checks.not_negative("ModifiedCoulomb", "coefficient", self.coefficient)
        checks.not_negative("ModifiedCoulomb", "v0", self.v0, "m/s")
        if self.v1 <= self.v0:
            raise InputError(f"ModifiedCoulomb: v1 is {self.v1:g} m/s; it must be > v0 = {self.v0:g} m/s.")

    def creep_speed(self, load_ratio: float) -> float:
        """Slip speed [m/s] that balances the tangential load `load_ratio` mu N; inf where no speed does."""
        r = checked_ratio("ModifiedCoulomb", load_ratio)
        if r == 0.0:
            return 0.0
        return self.v0 + r * (self.v1 - self.v0) if r <= 1.0 else math.inf
