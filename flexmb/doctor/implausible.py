"""Numbers that look as if degrees, rpm or a wrong sign were meant, told before a run and by the run itself."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cache

from flexmb.checks import declared_fields
from flexmb.docstrings import parameters, units
from flexmb.doctor.finding import Finding, found
from flexmb.drives.drive import Drive
from flexmb.errors import FlexmbError
from flexmb.model.contributions import ConstraintContribution
from flexmb.model.law import Motion
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import Joint, Part

FASTEST = 2e4
"""Angular speed of a drive above which there is a remark [rad/s]."""

LARGEST_ACCELERATION = 1e5
"""Centripetal acceleration of the end of a driven body above which there is a remark [m/s^2]: pistons of racing engines
reach 0.9e5."""

TURN = 2.0 * math.pi
"""Angle up to which a number in degrees cannot be told from one in rad [rad]."""

FINEST_PART = math.pi / 24.0
"""Angle of which angles beyond a turn are multiples, when they are meant in rad [rad]."""

SAME = 1e-6
"""Difference of two angles up to which they are equal, relative to `FINEST_PART`."""

STANDARD_GRAVITY = 9.80665


def implausible_findings(mechanism: Mechanism) -> list[Finding]:
    """Findings on speeds, angles and gravity as declared.

    Parameters
    ----------
    mechanism : the mechanism.
    """
    findings = [*_upward_gravity(mechanism)]
    for part in mechanism.parts:
        if isinstance(part, Drive):
            findings += _speeds(mechanism, part)
        findings += [_in_degrees(part, name, value) for name, value in _angles(mechanism, part) if is_in_degrees(value)]
    return findings


def is_in_degrees(angle: float) -> bool:
    """Whether an angle [rad] is beyond a turn and no simple part of pi, as 60 is and 20 pi is not."""
    parts = angle / FINEST_PART
    return TURN < abs(angle) < math.inf and abs(parts - round(parts)) > SAME


def _in_degrees(part: Part, name: str, value: float) -> Finding:
    turns = value / TURN
    text = f"{part.label}: {name} is {value:.4g} rad, {turns:.3g} turns."
    remedy = f"Angles are in rad: {value:.4g} degrees are {math.radians(value):.4g} rad, math.radians({value:.4g})."
    return found("odd-units", (part.name,), text, remedy, angle=value)


def _angles(mechanism: Mechanism, part: Part) -> Iterator[tuple[str, float]]:
    """Numbers of a part, of its motion and of the target of a controller that are angles by their documented unit."""
    turns, joint = True, getattr(part, "joint", None)
    if joint in mechanism:
        turns = _drive_units(mechanism, joint) == "rad"
    for owner, before in ((part, ""), (getattr(part, "motion", None), "motion.")):
        for name in _angle_fields(type(owner)) if turns and owner is not None else ():
            value = getattr(owner, name)
            if isinstance(value, float | int):
                yield before + name, float(value)
    target = getattr(part, "target", None)
    if isinstance(target, float | int) and str(getattr(part, "measure", "")).endswith((".angle", ".theta")):
        yield "target", float(target)


@cache
def _angle_fields(kind: type) -> tuple[str, ...]:
    """Fields whose first unit in the docstring is rad; amplitudes and means of motions have the unit of their joint."""
    texts, named = parameters(kind), ("amplitude", "mean") if issubclass(kind, Motion) else ()
    names = [name for name, _ in declared_fields(kind)]
    return tuple(name for name in names if name in named or units(texts.get(name, ""))[:1] == ["rad"])


def _drive_units(mechanism: Mechanism, joint: str) -> str:
    """Unit of the coordinate of a joint that can be driven; "" for another part."""
    part = mechanism.find(joint)
    try:
        row: ConstraintContribution | None = part.drive_contribution(mechanism) if isinstance(part, Joint) else None
    except FlexmbError:
        return ""
    return row.drive_units[0] if row is not None else ""


def _speeds(mechanism: Mechanism, part: Drive) -> Iterator[Finding]:
    """A finding on a drive that turns too fast for its body."""
    joint, speed = mechanism.find(part.joint), getattr(part.motion, "speed", None)
    if not isinstance(speed, float | int) or not isinstance(joint, Joint):
        return
    if _drive_units(mechanism, part.joint) != "rad":
        return
    arm = max(arm_of(mechanism, joint, body.name) for body in (joint.first, joint.second))
    acceleration = speed * speed * arm
    if abs(speed) > FASTEST or acceleration > LARGEST_ACCELERATION:
        text = f"{part.label} turns at {speed:.4g} rad/s, {speed * 30.0 / math.pi:.4g} rpm"
        more = f": at {arm:.3g} m from the joint that is {acceleration / STANDARD_GRAVITY:.3g} g" if arm else ""
        remedy = f"Speeds are in rad/s: 2 pi/60 times those in rpm; {speed:.4g} rpm are {speed * math.pi / 30.0:.4g}."
        yield found("odd-units", (part.name,), f"{text}{more}.", remedy, speed=speed, acceleration=acceleration)


def arm_of(mechanism: Mechanism, joint: Joint, name: str) -> float:
    """Largest distance of the joints on a body from one of them [m]; 0 for the ground.

    Parameters
    ----------
    mechanism : the mechanism.
    joint : the joint.
    name : name of the body.
    """
    on = [one for one in mechanism.parts if isinstance(one, Joint) and name in (one.first.name, one.second.name)]
    is_moving = any(body.name == name for body in mechanism.bodies)
    return max((math.dist(joint.at, one.at) for one in on if one.at is not None), default=0.0) if is_moving else 0.0


def _upward_gravity(mechanism: Mechanism) -> Iterator[Finding]:
    """A finding on gravity that points upwards."""
    if mechanism.gravity[1] > abs(mechanism.gravity[0]):
        text = f"Gravity points upwards: ({mechanism.gravity[0]:g}, {mechanism.gravity[1]:g}) m/s^2; Y is up."
        yield found("upward-gravity", (), text, "Downwards it is gravity=(0, -9.81).", gravity=mechanism.gravity[1])
