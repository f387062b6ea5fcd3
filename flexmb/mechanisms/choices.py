"""Loop closure in closed form, and arguments that several ready mechanisms share: friction, crank motion, pin."""

import math

import numpy as np

from flexmb import checks
from flexmb.errors import AssemblyError, InputError
from flexmb.model.law import FrictionLaw, Motion, NormalLaw
from flexmb.model.part import Body, Joint
from flexmb.parts.contact.friction import Frictionless, ModifiedCoulomb
from flexmb.parts.drives.motions import ConstantSpeed, Ramp
from flexmb.parts.joints.revolute import Revolute, RevoluteClearance

Point = tuple[float, float]
LEFT, RIGHT = 1.0, -1.0  # side of a corner, seen in the direction from the first point to the second


def at_angle(start: Point, length: float, angle: float) -> Point:
    """The point at a distance [m] and direction, from +X [rad], from another point."""
    return start[0] + length * math.cos(angle), start[1] + length * math.sin(angle)


def corner(loop: str, first: Point, r1: float, second: Point, r2: float, side: float) -> Point:
    """The point at distances r1 and r2 [m] from two points, on the side LEFT or RIGHT; `loop` is named in messages."""
    dx, dy = second[0] - first[0], second[1] - first[1]
    d = math.hypot(dx, dy)
    if d > r1 + r2:
        text = f"{loop} cannot close: its ends are {d:.4g} m apart,"
        text += f" the links between them reach {r1 + r2:.4g} m, {d - r1 - r2:.4g} m too little."
        raise AssemblyError(f"{text} Start at other crank angles, or change the lengths.")
    if d < abs(r1 - r2) or d == 0.0:
        text = f"{loop} cannot close: its ends are {d:.4g} m apart, the links between them,"
        text += f" {r1:.4g} and {r2:.4g} m long, keep them at least {abs(r1 - r2):.4g} m apart."
        raise AssemblyError(f"{text} Start at other crank angles, or change the lengths.")
    along = (d * d + r1 * r1 - r2 * r2) / (2.0 * d)
    across = side * math.sqrt(max(r1 * r1 - along * along, 0.0))
    ux, uy = dx / d, dy / d
    return first[0] + along * ux - across * uy, first[1] + along * uy + across * ux


def on_line(loop: str, start: Point, length: float, height: float, direction: float) -> Point:
    """The point of the line y = `height` [m] at a distance from a point, towards +X (direction 1) or -X (-1)."""
    away = abs(height - start[1])
    if away > length:
        text = f"{loop} cannot close: the rod of {length:.4g} m starts {away:.4g} m beside the line of the slider,"
        text += f" {away - length:.4g} m too far."
        raise AssemblyError(f"{text} Start at other crank angles, or change the lengths.")
    return start[0] + direction * math.sqrt(length * length - away * away), height


def box(centre: Point, width: float, height: float) -> tuple[Point, ...]:
    """Outline of a rectangle, closed."""
    (x, y), a, b = centre, 0.5 * width, 0.5 * height
    return ((x - a, y - b), (x + a, y - b), (x + a, y + b), (x - a, y + b), (x - a, y - b))


def friction_law(owner: str, friction: str | FrictionLaw | None, coulomb: ModifiedCoulomb) -> FrictionLaw:
    """The law for an argument `friction`: None, "coulomb" for the law of the data of mechanism `owner`, or a law."""
    if friction is None:
        return Frictionless()
    if friction == "coulomb":
        return coulomb
    if isinstance(friction, FrictionLaw):
        return friction
    text = f"{owner}: friction is {friction!r};"
    raise InputError(f"{text} it must be 'coulomb', a friction law, or None for no friction.")


def crank_motion(owner: str, speed: float, ramp: float | None) -> Motion:
    """Motion of a crank of the mechanism `owner` at a speed [rad/s] from the start, or after a ramp [s] from rest."""
    if ramp is None:
        return ConstantSpeed(checks.number(owner, "speed", speed, "rad/s"))
    checks.positive(owner, "ramp", ramp, "s", "For constant speed from the start on leave it out.")
    return Ramp(checks.number(owner, "speed", speed, "rad/s"), ramp)


def pin(
    name: str, first: Body, second: Body, at: Point, clearance: float | None, bearing_radius: float,
    normal: NormalLaw, friction: FrictionLaw,
) -> Joint:  # fmt: skip
    """A revolute joint at a point [m], with clearance [m] if it is given; the journal belongs to the second body."""
    if clearance is None:
        return Revolute(name, first, second, at=at)
    return RevoluteClearance(
        name, first, second, at=at, clearance=clearance, bearing_radius=bearing_radius, normal=normal, friction=friction
    )


def angles(owner: str, name: str, value: object) -> Point:
    """An argument of two angles [rad]."""
    if not isinstance(value, (tuple, list, np.ndarray)) or len(value) != 2:
        raise InputError(f"{owner}: {name} is {value!r}; it must be two angles in rad, e.g. (0.0, 0.0).")
    first, second = value
    return checks.number(owner, f"{name}[0]", first, "rad"), checks.number(owner, f"{name}[1]", second, "rad")
