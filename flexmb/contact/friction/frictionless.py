"""Contact without friction."""

import math
from dataclasses import dataclass

from flexmb.contact.friction.creep import load_ratio as checked_ratio
from flexmb.kernels import friction_law
from flexmb.model.law import FrictionLaw


@friction_law
def frictionless_kernel(p, h, slip, N, z, z_new):
    """T = 0."""
    return 0.0, 0.0, 0.0


@dataclass(frozen=True)
class Frictionless(FrictionLaw):
    """Surfaces without friction."""

    kernel = frictionless_kernel

    def creep_speed(self, load_ratio: float) -> float:
        """Slip speed [m/s] that balances a tangential load of `load_ratio` times nothing: 0 at rest, inf above."""
        return math.inf if checked_ratio("Frictionless", load_ratio) > 0.0 else 0.0
