"""Arguments that several ready mechanisms share: friction, motion of a crank, a pin with or without clearance."""

import numpy as np

from flexmb import checks
from flexmb.errors import InputError
from flexmb.model.law import FrictionLaw, Motion, NormalLaw
from flexmb.model.part import Body, Joint
from flexmb.parts.contact.friction import Frictionless, ModifiedCoulomb
from flexmb.parts.drives.motions import ConstantSpeed, Ramp
from flexmb.parts.joints.revolute import Revolute
from flexmb.parts.joints.revolute_clearance import RevoluteClearance

Point = tuple[float, float]


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
    name: str,
    first: Body,
    second: Body,
    at: Point,
    clearance: float | None,
    bearing_radius: float,
    normal: NormalLaw,
    friction: FrictionLaw,
) -> Joint:
    """A revolute joint at a point [m], with clearance [m] if it is given; the journal belongs to the second body."""
    if clearance is None:
        return Revolute(name, first, second, at=at)
    return RevoluteClearance(
        name, first, second, at=at, clearance=clearance, bearing_radius=bearing_radius, normal=normal, friction=friction
    )


def check_flag(owner: str, name: str, value: object) -> bool:
    """`value` if it is True or False; a number there is probably meant for another argument."""
    if not isinstance(value, bool):
        raise InputError(f"{owner}: {name} is {value!r}; it must be True or False.")
    return value


def angles(owner: str, name: str, value: object) -> Point:
    """An argument of two angles [rad]."""
    if not isinstance(value, (tuple, list, np.ndarray)) or len(value) != 2:
        raise InputError(f"{owner}: {name} is {value!r}; it must be two angles in rad, e.g. (0.0, 0.0).")
    first, second = value
    return checks.number(owner, f"{name}[0]", first, "rad"), checks.number(owner, f"{name}[1]", second, "rad")
