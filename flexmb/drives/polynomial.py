"""Motion given by a polynomial in time."""

from collections.abc import Sequence
from dataclasses import dataclass

from flexmb import checks
from flexmb.errors import InputError
from flexmb.kernels import drive_kernel
from flexmb.model.law import Motion


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
