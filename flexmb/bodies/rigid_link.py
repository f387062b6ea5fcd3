"""A rigid bar between two points."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from flexmb import checks, planar
from flexmb.bodies.bar import Bar
from flexmb.bodies.inertia import node_mass
from flexmb.bodies.rigid_body import checked_velocity
from flexmb.errors import InputError
from flexmb.model.contributions import Attachment, Contribution, Node
from flexmb.model.shape import RigidShape, Shapes

if TYPE_CHECKING:
    from flexmb.model.mechanism import Mechanism

Point = tuple[float, float]
MASSLESS = 1e-8
"""Mass of a massless link over the smallest mass of the other bodies [1]."""

AXIS_TOLERANCE = 1e-3
"""Distance from the axis over the length [1] up to which a point counts as one of the axis."""


@dataclass(frozen=True)
class RigidLink(Bar):
    """A rigid bar; theta is the direction from `start` to `end`, counted from +X.

    Parameters
    ----------
    name : the link's name.
    start, end : its ends in the reference configuration [m].
    mass : mass [kg], > 0; 0 with inertia 0 for a massless link.
    inertia : moment of inertia about the centre of mass [kg m^2], > 0; 0 for a massless link.
    centre : place of the centre of mass between start (0) and end (1).
    velocity : (vx, vy, omega) of the centre of mass at the start; None: as the drives impose.

    Raises
    ------
    InputError : start equals end, mass or inertia not > 0, centre outside [0, 1]; when a joint is off the axis.
    ModelError : when a run starts, a massless link that can move without moving a mass.

    Notes
    -----
    A massless link has MASSLESS times the smallest mass of the other bodies, so that equations of motion stay regular.
    """

    mass: float
    inertia: float
    centre: float = 0.5
    velocity: tuple[float, float, float] | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.is_massless:
            checks.positive(self.label, "mass", self.mass, "kg")
            checks.positive(self.label, "inertia", self.inertia, "kg m^2")
        checks.between(self.label, "centre", self.centre, 0.0, 1.0)
        object.__setattr__(self, "velocity", checked_velocity(self.label, self.velocity))

    @property
    def is_massless(self) -> bool:
        """Whether the link has neither mass nor moment of inertia."""
        return self.mass == 0.0 and self.inertia == 0.0

    def nodes(self) -> tuple[Node, ...]:
        """The node at the centre of mass."""
        x, y = planar.from_frame(self.start, self.angle, (self.centre * self.length, 0.0))
        return (Node("", x, y, self.angle),)

    def attach(self, owner: str, point: Point) -> Attachment:
        """A point of the axis (also beyond the ends)."""
        node = self.nodes()[0]
        along, across = planar.to_frame((node.x, node.y), self.angle, point)
        if abs(across) > AXIS_TOLERANCE * self.length:
            raise InputError(
                f"{owner}: the point ({point[0]:g}, {point[1]:g}) lies {abs(across):g} m off the axis of {self.label}. "
                "Move the point onto the axis, or use RigidBody for a body with joints anywhere."
            )
        return Attachment(self.name, "", (along, across))

    def start_velocity(self) -> tuple[float, float, float] | None:
        """The declared start velocity."""
        return self.velocity

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        """One element: mass and moment of inertia of the body."""
        mass, inertia = self.mass, self.inertia
        if self.is_massless:
            mass = MASSLESS * min((body.total_mass() for body in mechanism.bodies if not body.is_massless), default=1.0)
            inertia = mass * self.length * self.length / 12.0
        return [node_mass(self.name, "", mass, inertia, mechanism.gravity)]

    def total_mass(self) -> float:
        """The mass [kg]."""
        return self.mass

    def shapes(self, mechanism: Mechanism) -> Shapes:  # noqa: ARG002 - the bar alone
        """The bar."""
        before, after = self.centre * self.length, (1.0 - self.centre) * self.length
        return (RigidShape(self.name, "", (((-before, 0.0), (after, 0.0)),)),)
