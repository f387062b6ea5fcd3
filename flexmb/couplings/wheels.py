"""Two wheels that turn one another: base of gears and belts."""

from __future__ import annotations

import math
from dataclasses import KW_ONLY, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from flexmb import checks, planar
from flexmb.couplings.linear import angle_of, angles_contribution
from flexmb.couplings.rolling import Push, rolling_kernel
from flexmb.errors import InputError, ModelError
from flexmb.joints.pin_slot import PinSlot
from flexmb.joints.prismatic import Guide
from flexmb.kernels import Kernel
from flexmb.model.contributions import Attachment, ConstraintContribution, Coordinate, JointFriction, Reaction
from flexmb.model.part import GROUND, Joint, Part
from flexmb.model.shape import CircleShape, Shapes

if TYPE_CHECKING:
    from flexmb.model.mechanism import Mechanism
    from flexmb.model.watched_motion import WatchedMotion

Point = tuple[float, float]

FITS = 1e-3
"""Difference of the distance of the axes from the sum of the pitch radii, relative to it, that still fits."""

COAXIAL = 1e-9
"""Distance of two centres relative to their radii, below which they are one: a gearbox with shafts in line."""


@dataclass(frozen=True)
class Wheels(Part):
    """Base of pairs of wheels that turn one another.

    Parameters
    ----------
    name : name of the pair.
    first, second : the wheels.
    arm : body that carries the axes; `GROUND` for fixed axes.
    centres : centres of both wheels in the reference configuration [m]; None, also for one of them: the pin between
        wheel and arm, else the centre of mass; of the ground a pin of the arm.

    Raises
    ------
    InputError : centres that are no points.
    ModelError : a wheel that turns itself.
    """

    first: Part
    second: Part
    _: KW_ONLY
    arm: Part = GROUND
    centres: Any = None

    def __post_init__(self) -> None:
        super().__post_init__()
        names = (self.first.name, self.second.name)
        if names[0] == names[1] or (self.arm.name != GROUND.name and self.arm.name in names):
            raise ModelError(f"{self.label} couples a body with itself; give different bodies as wheels and arm.")
        if self.centres is not None:
            given = checks.sequence(self.label, "centres", self.centres, "two points")
            if len(given) != 2:
                raise InputError(f"{self.label}: centres is {self.centres!r}; give two points, one of them or None.")
            points = (None if c is None else checks.point(self.label, "centres", c) for c in given)
            object.__setattr__(self, "centres", tuple(points))

    def _distances(self, mechanism: Mechanism, motion: WatchedMotion) -> np.ndarray:
        """Distances (n,) of both centres at the poses of a motion [m]."""
        first, second = (motion.point(mount.place) for mount in self._mounts(mechanism))
        return np.asarray(np.hypot(*(second - first).T))

    def _axes(self, mechanism: Mechanism) -> list[Point]:
        """Centres of both wheels in the reference configuration [m]."""
        wheels = self.first, self.second
        given = list(self.centres or (None, None))
        found: list[Any] = [
            c or (w.name != GROUND.name and self._axis(mechanism, w)) for c, w in zip(given, wheels, strict=True)
        ]
        other, apart = found[0] or found[1], getattr(self, "distance", None)
        if not all(found):  # the ground, whose centre is a pin of the arm
            pins = sorted(_pins(mechanism, self.arm), key=lambda joint: GROUND.name not in _names(joint))
            fits = [p.at for p in pins if apart and abs(planar.distance(p.at, other) - apart) <= FITS * apart]
            found = [point or (fits and fits[0]) for point in found]
        if not all(found):
            raise ModelError(
                f"{self.label}: one wheel is the ground, which has no centre. Give distance= of the axes and a pin of "
                "the arm at its centre, or centres=."
            )
        return found

    def _axis(self, mechanism: Mechanism, wheel: Part) -> Point:
        """Pin between a wheel and the arm, or one that they share with a third body; else the centre of mass."""
        pins, arm = _pins(mechanism, wheel), [pin.at for pin in _pins(mechanism, self.arm)]
        for pin in sorted(pins, key=lambda joint: self.arm.name not in _names(joint)):
            if self.arm.name in _names(pin) or pin.at in arm:
                return pin.at
        body = mechanism.body(wheel.name, self.label)
        node = body.node(body.main)
        return node.x, node.y

    def _mounts(self, mechanism: Mechanism) -> list[Attachment]:
        """Centres of both wheels as points of their bodies."""
        wheels = zip((self.first, self.second), self._axes(mechanism), strict=True)
        return [mechanism.body(wheel.name, self.label).attach(self.label, centre) for wheel, centre in wheels]

    def _circles(self, mechanism: Mechanism, radii: Point) -> Shapes:
        """Pitch circles with the radii [m] about the centres of the wheels that move."""
        mounts = zip(self._mounts(mechanism), radii, strict=True)
        return tuple(CircleShape(self.name, m.place, radius) for m, radius in mounts if m.part != GROUND.name)

    def _rolling(
        self, mechanism: Mechanism, radii: Point, along: tuple[Kernel, tuple[float, ...]] | None
    ) -> ConstraintContribution:
        """Equation r1 theta1 + r2 theta2 - (r1 + r2) phi = constant, with the direction phi of the line of centres.

        radii : of the wheels [m], negative for a wheel that turns with the first one;  along : kernel of the force
        along the line of centres, and its parameters behind the points
        """
        (first, second), ((x1, y1), (x2, y2)) = self._mounts(mechanism), self._axes(mechanism)
        if math.hypot(x2 - x1, y2 - y1) <= COAXIAL * (abs(radii[0]) + abs(radii[1])):
            return self._coaxial(mechanism, radii)
        coordinates: tuple[Coordinate, ...] = (*first.coordinates, *second.coordinates)
        offsets, phi, drawn = (*first.offset, *second.offset), math.atan2(y2 - y1, x2 - x1), 0.0
        if self.arm.name != GROUND.name:
            arm, drawn = angle_of(mechanism, self.arm.name, self.label)
            coordinates = (*coordinates, arm)
        turns = [mechanism.body(m.part).node(m.node).theta for m in (first, second)]
        value = radii[0] * turns[0] + radii[1] * turns[1] - sum(radii) * phi
        push = JointFriction(along[0], (*offsets, *along[1]), Push(), ("", "")) if along else None
        p, told = (*radii, *offsets, phi - drawn, value), _reactions(radii, -1 if second.part == GROUND.name else 5)
        return ConstraintContribution(self.name, rolling_kernel, coordinates, p, 1, joint_friction=push, reactions=told)

    def _coaxial(self, mechanism: Mechanism, radii: Point) -> ConstraintContribution:
        """Relation with the angle of the arm for phi: shafts in line, whose casing takes the difference of torques."""
        factors, angles = {}, {}
        for part, radius in zip((self.first, self.second, self.arm), (*radii, -sum(radii)), strict=True):
            coordinate, angle = angle_of(mechanism, part.name, self.label)
            if part.name != GROUND.name:  # the angle of the ground is 0
                factors[coordinate], angles[coordinate] = radius, angle
        second = angle_of(mechanism, self.second.name, self.label)[0]
        told = _reactions(radii, list(factors).index(second) if second in factors else -1)
        return angles_contribution(self.name, factors, angles, told)


def _reactions(radii: Point, place: int) -> tuple[Reaction, ...]:
    """Tangential force, torques on both wheels, power of the second wheel, whose angle stands at `place`."""
    return (
        Reaction("force", "N", 0, 1.0),
        Reaction("first_torque", "N m", 0, radii[0]),
        Reaction("second_torque", "N m", 0, radii[1]),
        Reaction("power", "W", 0, radii[1] if place >= 0 else 0.0, place),
    )


def _pins(mechanism: Mechanism, body: Part) -> list[Joint]:
    """Joints of a body at a point about which it may turn."""
    joints = (part for part in mechanism.parts if isinstance(part, Joint) and not isinstance(part, Guide | PinSlot))
    return [joint for joint in joints if joint.kind != "fixed" and body.name in _names(joint)]


def _names(joint: Joint) -> tuple[str, str]:
    """Names of the bodies of a joint."""
    return joint.first.name, joint.second.name
