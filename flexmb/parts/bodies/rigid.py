"""Rigid bodies, and bars between two points."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

from flexmb import checks, planar
from flexmb.errors import InputError
from flexmb.fields import Rule, between, field, point, positive, record, several
from flexmb.findings.finding import Finding, found
from flexmb.model.contributions import Attachment, Contribution, Node
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import Body, Joint
from flexmb.model.shape import RigidShape, Shapes
from flexmb.parts.bodies.point_mass import node_mass

Point = tuple[float, float]


def checked_velocity(label: str, name: str, velocity: Any, *_: str) -> tuple[float, float, float]:
    """A start velocity (vx, vy, omega) as floats, or `InputError`."""
    try:
        vx, vy, omega = velocity
    except (TypeError, ValueError):
        raise InputError(f"{label}: velocity is {velocity!r}; it must be (vx, vy, omega).") from None
    parts = (vx, "m/s"), (vy, "m/s"), (omega, "rad/s")
    x, y, turn = (checks.number(label, f"velocity[{k}]", value, unit) for k, (value, unit) in enumerate(parts))
    return x, y, turn


@record
class Bar(Body):
    """Base of bodies between two points of the reference configuration."""

    formerly = (("at", "start", "0.3"), ("to", "end", "0.3"))
    start: Point = field("one end", "m", point)
    end: Point = field("the other end", "m", point)

    def __post_init__(self) -> None:
        super().__post_init__()
        if planar.distance(self.start, self.end) <= 0.0:
            raise InputError(f"{self.label}: start and end are both {self.start}; a link must have a length > 0 m.")

    @property
    def bar_ends(self) -> tuple[Point, ...]:
        return self.start, self.end

    @property
    def length(self) -> float:
        """Distance of the ends in the reference configuration [m]."""
        return planar.distance(self.start, self.end)

    @property
    def angle(self) -> float:
        """Direction of the axis in the reference configuration [rad]."""
        return math.atan2(self.end[1] - self.start[1], self.end[0] - self.start[0])


@record
class RigidBody(Body):
    """A rigid body with its node at the centre of mass.

    Raises
    ------
    InputError : mass or inertia not > 0, values that are not finite.
    """

    formerly = (("angle", "theta", "0.3"),)
    at: Point = field("centre of mass", "m", point)
    mass: float = field("mass", "kg", positive)
    inertia: float = field("moment of inertia about the centre of mass", "kg m^2", positive)
    theta: float = field("rotation in the reference configuration", "rad", default=0.0)
    velocity: tuple[float, float, float] | None = field(
        "(vx, vy, omega) at the start; None: as the drives impose, with least kinetic energy",
        rule=Rule(checked_velocity),
        default=None,
    )
    outline: Sequence[Point] = field(
        "polyline in pictures, or lines to joints", "m", several(point, "points"), default=()
    )

    def nodes(self) -> tuple[Node, ...]:
        return (Node("", *self.at, self.theta),)

    def attach(self, owner: str, point: Point) -> Attachment:  # noqa: ARG002 - any point of the plane will do
        return Attachment(self.name, "", planar.to_frame(self.at, self.theta, point))

    def start_velocity(self) -> tuple[float, float, float] | None:
        return self.velocity

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        return [node_mass(self.name, "", self.mass, self.inertia, mechanism.gravity)]

    def total_mass(self) -> float:
        return self.mass

    def shapes(self, mechanism: Mechanism) -> Shapes:
        """The outline, or a star from the centre of mass to the joints."""
        if self.outline:
            outline = tuple(planar.to_frame(self.at, self.theta, p) for p in self.outline)
            lines: tuple[tuple[Point, ...], ...] = (outline,)
        else:
            held = held_points(self, mechanism)
            lines = tuple(((0.0, 0.0), p) for p in held if p != (0.0, 0.0)) or (((0.0, 0.0), (0.0, 0.0)),)
        return (RigidShape(self.name, "", lines),)


def held_points(body: Body, mechanism: Mechanism) -> list[Point]:
    """Points at which joints hold a body, in the frame of its node."""
    joints = (p for p in mechanism.parts if isinstance(p, Joint) and body.name in p.references())
    return [end.offset for joint in joints for end in joint.ends(mechanism) if end.part == body.name]


MASSLESS = 1e-8  # mass of a massless link over the smallest mass of the other bodies [1]
AXIS_TOLERANCE = 1e-3  # distance from the axis over the length [1] up to which a point counts as one of the axis
GYRATIONS = (0.02, 3.0)  # radius of gyration over the length of a link, least and largest, that goes without a finding
BEYOND_END = 1.0  # distance of a joint from the nearer end of its link, over the length, up to which it is not odd


@record
class RigidLink(Bar):
    """A rigid bar; theta is the direction from `start` to `end`, counted from +X.

    Raises
    ------
    InputError : start equals end, mass or inertia not > 0, centre outside [0, 1]; when a joint is off the axis.
    ModelError : when a run starts, a massless link that can move without moving a mass.

    Notes
    -----
    A massless link has MASSLESS times the smallest mass of the other bodies, so that equations of motion stay regular.
    """

    mass: float = field("mass, > 0; 0 with inertia 0 for a massless link", "kg")
    inertia: float = field("moment of inertia about the centre of mass, > 0; 0 for a massless link", "kg m^2")
    centre: float = field("of mass, from start (0) to end (1)", rule=between(0.0, 1.0), default=0.5)
    velocity: tuple[float, float, float] | None = field(
        "(vx, vy, omega) of the centre of mass at the start; None: as the drives impose",
        rule=Rule(checked_velocity),
        default=None,
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.is_massless:
            checks.positive(self.label, "mass", self.mass, "kg")
            checks.positive(self.label, "inertia", self.inertia, "kg m^2")

    @property
    def is_massless(self) -> bool:
        return self.mass == 0.0 and self.inertia == 0.0

    def nodes(self) -> tuple[Node, ...]:
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
        return self.velocity

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        mass, inertia = self.mass, self.inertia
        if self.is_massless:
            mass = MASSLESS * min((body.total_mass() for body in mechanism.bodies if not body.is_massless), default=1.0)
            inertia = mass * self.length * self.length / 12.0
        return [node_mass(self.name, "", mass, inertia, mechanism.gravity)]

    def total_mass(self) -> float:
        return self.mass

    def findings_before(self, mechanism: Mechanism) -> Iterator[Finding]:
        """Findings on an odd radius of gyration, and on joints far beyond the ends."""
        radius = 0.0 if self.is_massless else math.sqrt(self.inertia / self.mass)
        if not self.is_massless and not GYRATIONS[0] <= radius / self.length <= GYRATIONS[1]:
            text = (
                f"{self.label} has a radius of gyration of {radius:.4g} m and a length of {self.length:.4g} m "
                f"(mass {self.mass:.4g} kg, inertia {self.inertia:.4g} kg m^2)."
            )
            slender = self.mass * self.length * self.length / 12.0
            remedy = f"A slender bar of this mass has an inertia of {slender:.4g} kg m^2."
            yield found("odd-units", (self.name,), text, remedy, radius=radius, length=self.length)
        for joint in mechanism.parts:
            if isinstance(joint, Joint) and self.name in joint.references() and joint.at is not None:
                along = planar.to_frame(self.start, self.angle, joint.at)[0]
                beyond = max(-along, along - self.length)
                if beyond > BEYOND_END * self.length:
                    text = f"The joint {joint.name!r} lies {beyond:.4g} m beyond the end of {self.label}"
                    text += f" ({self.length:.4g} m long)."
                    parts = (joint.name, self.name)
                    yield found("far-joint", parts, text, "Check the points of both.", distance=beyond)

    def shapes(self, mechanism: Mechanism) -> Shapes:  # noqa: ARG002 - the bar alone
        before, after = self.centre * self.length, (1.0 - self.centre) * self.length
        return (RigidShape(self.name, "", (((-before, 0.0), (after, 0.0)),)),)
