"""A force of constant size and direction on a point of a body."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from flexmb import checks
from flexmb.errors import ModelError
from flexmb.kernels import element_kernel
from flexmb.model.part import GROUND, Part
from flexmb.model.pieces import ElementPiece, Piece

if TYPE_CHECKING:
    from flexmb.model.mechanism import Mechanism


@element_kernel
def force_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    """Dead force (fx, fy) at the point s of a node (x, y, theta)."""
    fx, fy, sx, sy = p
    c, s = math.cos(q[2]), math.sin(q[2])
    bx, by = c * sx - s * sy, s * sx + c * sy
    r[0] = -fx
    r[1] = -fy
    r[2] = -(bx * fy - by * fx)
    K[2, 2] = by * fy + bx * fx


@dataclass(frozen=True)
class Force(Part):
    """A dead force: constant in size and direction, its point moves with the body.

    Parameters
    ----------
    name : the load's name.
    body : the body it acts on.
    at : its point in the drawn pose [m].
    force : (fx, fy) [N].

    Raises
    ------
    ModelError : a force on the ground.
    """

    body: Part
    at: tuple[float, float]
    force: tuple[float, float]

    def __post_init__(self) -> None:
        super().__post_init__()
        check_loaded(self)
        object.__setattr__(self, "at", checks.point(self.label, "at", self.at))
        object.__setattr__(self, "force", checks.point(self.label, "force", self.force, "N"))

    def pieces(self, mechanism: Mechanism) -> Sequence[Piece]:
        """One element on the node that carries the point."""
        end = mechanism.body(self.body.name, self.label).attach(self.label, self.at)
        return [ElementPiece(self.name, force_kernel, end.coordinates, (*self.force, *end.offset))]


def check_loaded(load) -> None:
    """A load acts on a body, not on the ground."""
    if load.body.name == GROUND.name:
        raise ModelError(f"{load.label} acts on the ground, which cannot move. Give a moving body.")
