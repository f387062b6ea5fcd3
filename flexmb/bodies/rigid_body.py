"""Rigid body with its node at the centre of mass."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, cast

from flexmb import checks, planar
from flexmb.bodies.inertia import node_mass
from flexmb.errors import InputError
from flexmb.model.contributions import Attachment, Contribution, Node
from flexmb.model.part import Body, Joint
from flexmb.model.shape import RigidShape, Shapes

if TYPE_CHECKING:
    from flexmb.model.mechanism import Mechanism

Point = tuple[float, float]


@dataclass(frozen=True)
class RigidBody(Body):
    """A rigid body with its node at the centre of mass.

    Parameters
    ----------
    name : the body's name.
    at : centre of mass in the reference configuration [m].
    mass : mass [kg], > 0.
    inertia : moment of inertia about the centre of mass [kg m^2], > 0.
    theta : rotation in the reference configuration [rad].
    velocity : (vx, vy, omega) at the start [m/s, rad/s]; None: as the drives impose, with least kinetic energy.
    outline : points of a polyline in the reference configuration [m], for pictures; empty: a line to every joint.

    Raises
    ------
    InputError : mass or inertia not > 0, values that are not finite.
    """

    formerly = (("angle", "theta"),)
    at: Point
    mass: float
    inertia: float
    theta: float = 0.0
    velocity: tuple[float, float, float] | None = None
    outline: Sequence[Point] = ()

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "at", checks.point(self.label, "at", self.at))
        given = checks.sequence(self.label, "outline", self.outline, "points")
        outline = tuple(checks.point(self.label, f"outline[{i}]", p) for i, p in enumerate(given))
        object.__setattr__(self, "outline", outline)
        checks.positive(self.label, "mass", self.mass, "kg")
        checks.positive(self.label, "inertia", self.inertia, "kg m^2")
        object.__setattr__(self, "velocity", checked_velocity(self.label, self.velocity))

    def nodes(self) -> tuple[Node, ...]:
        """The node at the centre of mass."""
        return (Node("", *self.at, self.theta),)

    def attach(self, owner: str, point: Point) -> Attachment:  # noqa: ARG002 - any point of the plane will do
        """Every point of the plane may belong to a rigid body."""
        return Attachment(self.name, "", planar.to_frame(self.at, self.theta, point))

    def start_velocity(self) -> tuple[float, float, float] | None:
        """The declared start velocity."""
        return self.velocity

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        """One element: mass and moment of inertia of the body."""
        return [node_mass(self.name, "", self.mass, self.inertia, mechanism.gravity)]

    def total_mass(self) -> float:
        """The mass [kg]."""
        return self.mass

    def shapes(self, mechanism: Mechanism) -> Shapes:
        """The outline, or a star from the centre of mass to the joints."""
        if self.outline:
            lines: tuple[tuple[Point, ...], ...] = (
                tuple(planar.to_frame(self.at, self.theta, p) for p in self.outline),
            )
        else:
            held = held_points(self, mechanism)
            lines = tuple(((0.0, 0.0), p) for p in held if p != (0.0, 0.0)) or (((0.0, 0.0), (0.0, 0.0)),)
        return (RigidShape(self.name, "", lines),)


def held_points(body: Body, mechanism: Mechanism) -> list[Point]:
    """Points at which joints hold a body, in the frame of its node."""
    joints = (p for p in mechanism.parts if isinstance(p, Joint) and body.name in p.references())
    return [end.offset for joint in joints for end in joint.ends(mechanism) if end.part == body.name]


def checked_velocity(label: str, velocity: object) -> tuple[float, float, float] | None:
    """A start velocity (vx, vy, omega) as floats, or None."""
    if velocity is None:
        return None
    try:
        vx, vy, omega = cast("tuple[object, object, object]", velocity)
    except (TypeError, ValueError):
        raise InputError(f"{label}: velocity is {velocity!r}; it must be (vx, vy, omega).") from None
    return (
        checks.number(label, "velocity[0]", vx, "m/s"),
        checks.number(label, "velocity[1]", vy, "m/s"),
        checks.number(label, "velocity[2]", omega, "rad/s"),
    )
