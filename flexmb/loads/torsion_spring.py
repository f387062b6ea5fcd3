"""Linear spring and damper between the rotations of two bodies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from typing import TYPE_CHECKING

from flexmb import checks
from flexmb.kernels import element_kernel, energy_kernel
from flexmb.model.part import Part
from flexmb.model.pieces import ElementPiece, Piece

if TYPE_CHECKING:
    from flexmb.model.mechanism import Mechanism


@element_kernel
def torsion_spring_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    """M = k (theta2 - theta1 - angle0) + d (omega2 - omega1); q = (theta1, theta2)."""
    k, d, angle = p
    moment = k * (q[1] - q[0] - angle) + d * (v[1] - v[0])
    r[0] = -moment
    r[1] = moment
    for i in range(2):
        for j in range(2):
            sign = 1.0 if i == j else -1.0
            K[i, j] = sign * k
            C[i, j] = sign * d


@energy_kernel
def torsion_spring_energy(p, t, q, v):
    """Energy of the spring, power of the damper."""
    k, d, angle = p
    return 0.5 * k * (q[1] - q[0] - angle) ** 2, 0.0, d * (v[1] - v[0]) ** 2


@dataclass(frozen=True)
class TorsionSpring(Part):
    """Linear torsion spring and damper between two bodies.

    Parameters
    ----------
    name : the part's name.
    first, second : the bodies; `GROUND` is the frame.
    stiffness : k [N m/rad], >= 0.
    damping : d [N m s/rad], >= 0.
    rest_angle : relative rotation without moment [rad], counted from the drawn pose.
    at : point of the drawn pose [m] whose nodes are connected; None: the main nodes.

    Raises
    ------
    InputError : negative stiffness or damping.
    """

    first: Part
    second: Part
    _: KW_ONLY
    stiffness: float
    damping: float = 0.0
    rest_angle: float = 0.0
    at: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        checks.not_negative(self.label, "stiffness", self.stiffness, "N m/rad")
        checks.not_negative(self.label, "damping", self.damping, "N m s/rad")
        if self.at is not None:
            object.__setattr__(self, "at", checks.point(self.label, "at", self.at))

    def pieces(self, mechanism: Mechanism) -> Sequence[Piece]:
        """One element on two angles."""
        coordinates, angle = [], self.rest_angle
        for part, sign in ((self.first, -1.0), (self.second, 1.0)):
            body = mechanism.body(part.name, self.label)
            node = body.main if self.at is None else body.attach(self.label, self.at).node
            coordinates.append((body.name, node, 2))
            angle += sign * body.node(node).theta
        p = (self.stiffness, self.damping, angle)
        piece = ElementPiece(self.name, torsion_spring_kernel, tuple(coordinates), p, energy=torsion_spring_energy)
        return [piece]
