"""What the ready mechanisms offer by a word or a number: friction, motion of a crank, a pin with or without play."""

from __future__ import annotations

from flexmb import checks
from flexmb.contact.friction.frictionless import Frictionless
from flexmb.contact.friction.modified_coulomb import ModifiedCoulomb
from flexmb.drives.constant_speed import ConstantSpeed
from flexmb.drives.ramp import Ramp
from flexmb.errors import InputError
from flexmb.joints.revolute import Revolute
from flexmb.joints.revolute_clearance import RevoluteClearance
from flexmb.model.law import FrictionLaw, Motion, NormalLaw
from flexmb.model.part import Body, Joint

Point = tuple[float, float]
Friction = str | FrictionLaw | None


def friction_law(owner: str, friction: Friction, coulomb: ModifiedCoulomb) -> FrictionLaw:
    """The law that `friction` means: None, "coulomb" for the mechanism's own numbers, or a law itself."""
    if friction is None:
        return Frictionless()
    if friction == "coulomb":
        return coulomb
    if isinstance(friction, FrictionLaw):
        return friction
    raise InputError(
        f"{owner}: friction is {friction!r}; it must be 'coulomb', a friction law, or None for no friction."
    )


def crank_motion(owner: str, speed: float, ramp: float | None) -> Motion:
    """Constant speed from the start on, or within `ramp` seconds from rest."""
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
    """A revolute joint, with play when `clearance` is given."""
    if clearance is None:
        return Revolute(name, first, second, at=at)
    play = {"clearance": clearance, "bearing_radius": bearing_radius, "normal": normal, "friction": friction}
    return RevoluteClearance(name, first, second, at=at, **play)


def check_flag(owner: str, name: str, value: object) -> bool:
    """`value` as True or False, or `InputError`: a number there is probably meant for another argument."""
    if not isinstance(value, bool):
        raise InputError(f"{owner}: {name} is {value!r}; it must be True or False.")
    return value


def angles(owner: str, name: str, value: object) -> Point:
    """Two angles [rad], or `InputError`."""
    try:
        first, second = value  # type: ignore[misc]
    except (TypeError, ValueError):
        raise InputError(f"{owner}: {name} is {value!r}; it must be two angles in rad, e.g. (0.0, 0.0).") from None
    return checks.number(owner, f"{name}[0]", first, "rad"), checks.number(owner, f"{name}[1]", second, "rad")
