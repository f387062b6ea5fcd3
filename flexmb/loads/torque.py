"""A constant torque on a body."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from flexmb import checks
from flexmb.kernels import element_kernel
from flexmb.loads.force import check_loaded
from flexmb.model.part import Part
from flexmb.model.pieces import ElementPiece, Piece

if TYPE_CHECKING:
    from flexmb.model.mechanism import Mechanism


@element_kernel
def torque_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    """Torque on one theta."""
    r[0] = -p[0]


@dataclass(frozen=True)
class Torque(Part):
    """A constant torque on a body, or on one node of a flexible one.

    Parameters
    ----------
    name : the load's name.
    body : the body it acts on.
    torque : counter-clockwise [N m].
    at : point of the drawn pose [m] whose node takes the torque; None: the body's main node.

    Raises
    ------
    ModelError : a torque on the ground.
    """

    body: Part
    torque: float
    at: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        check_loaded(self)
        if self.at is not None:
            object.__setattr__(self, "at", checks.point(self.label, "at", self.at))

    def pieces(self, mechanism: Mechanism) -> Sequence[Piece]:
        """One element on theta of the node."""
        body = mechanism.body(self.body.name, self.label)
        node = body.main if self.at is None else body.attach(self.label, self.at).node
        return [ElementPiece(self.name, torque_kernel, ((body.name, node, 2),), (self.torque,))]
