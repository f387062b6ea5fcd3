"""No friction."""

from dataclasses import dataclass

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
