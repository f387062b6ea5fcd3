"""Arguments that several ready mechanisms share: friction, motion of a crank, a pin with or without clearance."""

from __future__ import annotations

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
    """The friction law for an argument `friction`.

    Parameters
    ----------
    owner : name of the mechanism, for messages.
    friction : None, "coulomb" for the law of the mechanism's own data, or a law.
    coulomb : the law of the mechanism's own data.

    Raises
    ------
    InputError : another argument.
    """
    if friction is None:
        return Frictionless()
    if friction == "coulomb":
        return coulomb
    if isinstance(friction, FrictionLaw):
        return friction
    text = f"{owner}: friction is {friction!r};"
    raise InputError(f"{text} it must be 'coulomb', a friction law, or None for no friction.")


def crank_motion(owner: str, speed: float, ramp: float | None) -> Motion:
    """Prescribed motion of a crank: constant speed from the start, or after a ramp from rest.

    Parameters
    ----------
    owner : name of the mechanism, for messages.
    speed : speed [rad/s].
    ramp : duration of the ramp [s]; None: no ramp.

    Raises
    ------
    InputError : a speed that is no number, a ramp that is not > 0.
    """
    if ramp is None:
        return ConstantSpeed(checks.number(owner, "speed", speed, "rad/s"))
    checks.positive(owner, "ramp", ramp, "s", "For constant speed from the start on leave it out.")
    return Ramp(checks.number(owner, "speed", speed, "rad/s"), ramp)


def pin(
    name: str, first: Body, second: Body, at: Point, clearance: float | None, bearing_radius: float,
    normal: NormalLaw, friction: FrictionLaw,
) -> Joint:  # fmt: skip
    """A revolute joint, with clearance if it is given.

    Parameters
    ----------
    name : name of the joint.
    first, second : bodies with the bearing and with the journal.
    at : position of the joint [m].
    clearance : clearance [m]; None: ideal joint.
    bearing_radius : radius of the bearing [m].
    normal, friction : laws of the contact.
    """
    if clearance is None:
        return Revolute(name, first, second, at=at)
    return RevoluteClearance(
        name, first, second, at=at, clearance=clearance, bearing_radius=bearing_radius, normal=normal, friction=friction
    )


def check_flag(owner: str, name: str, value: object) -> bool:
    """`value` if it is True or False; a number there is probably meant for another argument.

    Parameters
    ----------
    owner, name : names of the mechanism and of the argument, for messages.
    value : the argument of a user.

    Raises
    ------
    InputError : another value.
    """
    if not isinstance(value, bool):
        raise InputError(f"{owner}: {name} is {value!r}; it must be True or False.")
    return value


def angles(owner: str, name: str, value: object) -> Point:
    """Two angles [rad].

    Parameters
    ----------
    owner, name : names of the mechanism and of the argument, for messages.
    value : the argument of a user.

    Raises
    ------
    InputError : another value than two numbers.
    """
    if not isinstance(value, (tuple, list, np.ndarray)) or len(value) != 2:
        raise InputError(f"{owner}: {name} is {value!r}; it must be two angles in rad, e.g. (0.0, 0.0).")
    first, second = value
    return checks.number(owner, f"{name}[0]", first, "rad"), checks.number(owner, f"{name}[1]", second, "rad")
