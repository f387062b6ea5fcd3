"""The part of the examination that costs next to nothing: laws, motions, numbers that look like other units."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from functools import cache
from typing import Any

from flexmb.errors import FlexmbError
from flexmb.fields import fields_of
from flexmb.findings.finding import Finding, found
from flexmb.model.law import FrictionLaw, Law, Motion, NormalLaw
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import GROUND, Joint, Part
from flexmb.parts.drives.drive import Drive

# Findings on numbers that look as if degrees, rpm or another sign were meant, of `check` and of runs

FASTEST = 2e4
"""Angular speed of a drive above which there is a remark [rad/s]."""

LARGEST_ACCELERATION = 1e5
"""Centripetal acceleration of a joint on a driven body above which there is a remark [m/s^2]; pistons of racing engines
reach 0.9e5."""

TURN, FINEST_PART, SAME = 2.0 * math.pi, math.pi / 24.0, 1e-6
"""Angle up to which degrees cannot be told from rad [rad]; angle of which larger ones are multiples, when meant in rad
[rad]; error of such a multiple [1]."""

STANDARD_GRAVITY = 9.80665


def implausible_findings(mechanism: Mechanism) -> list[Finding]:
    """Findings on speeds, angles and gravity as declared."""
    findings = []
    if mechanism.gravity[1] > abs(mechanism.gravity[0]):
        text = (
            f"Gravity points upwards, Y is up: gravity is ({mechanism.gravity[0]:g}, {mechanism.gravity[1]:g}) m/s^2."
        )
        findings.append(found("upward-gravity", (), text, "Downwards it is gravity=(0, -9.81)."))
    for part in mechanism.parts:
        findings += _speeds(mechanism, part) if isinstance(part, Drive) else ()
        for name, value in _angles(part):
            shares = value / FINEST_PART
            if not TURN < abs(value) < math.inf or abs(shares - round(shares)) <= SAME:
                continue
            joint = vars(part).get("joint", "")
            if joint is None or (joint and not _turns(mechanism, joint)):  # travels
                continue
            text = f"{part.label}: {name} is {value:.4g} rad, {value / TURN:.3g} turns."
            remedy = (
                f"Angles are in rad: {value:.4g} degrees are math.radians({value:.4g}) = {math.radians(value):.4g} rad."
            )
            findings.append(found("odd-units", (part.name,), text, remedy, angle=value))
    return findings


def _angles(part: Part) -> Iterator[tuple[str, float]]:
    """Numbers of a part, of its motion and of the target of a controller that are angles by their unit."""
    motion, target = vars(part).get("motion"), vars(part).get("target")
    owners: list[Any] = [part, motion] if isinstance(motion, Motion) else [part]
    for owner in owners:
        kind: Any = type(owner)
        for name in _angle_fields(kind):
            value = vars(owner).get(name)
            if isinstance(value, float | int):
                yield name if owner is part else f"motion.{name}", float(value)
    if isinstance(target, float | int) and str(vars(part).get("measure")).endswith((".angle", ".theta")):
        yield "target", float(target)


@cache
def _angle_fields(kind: type) -> tuple[str, ...]:
    """Fields in rad, or in rad or m as their joint has it."""
    return tuple(field.name for field in fields_of(kind) if field.unit in ("rad", "rad or m"))


def _turns(mechanism: Mechanism, joint: Part | str) -> bool:
    """Whether a joint has an angle that can be driven."""
    part = mechanism.find(joint)
    try:
        row = part.drive_contribution(mechanism) if isinstance(part, Joint) else None
    except FlexmbError:
        return False
    return row is not None and row.drive_units[0] == "rad"


def _speeds(mechanism: Mechanism, part: Drive) -> Iterator[Finding]:
    """A finding on a drive that turns too fast for the joints on its bodies."""
    joint, speed = mechanism.find(part.joint), vars(part.motion).get("speed")
    if not isinstance(speed, float | int) or not isinstance(joint, Joint):
        return
    driven = {joint.first.name, joint.second.name} - {GROUND.name}
    joints = [one for one in mechanism.parts if isinstance(one, Joint) and one.at is not None]
    near = [one for one in joints if joint.at is not None and {one.first.name, one.second.name} & driven]
    arms = [math.dist(joint.at, one.at) for one in near]
    arm = max(arms, default=0.0)
    acceleration = speed * speed * arm
    if (abs(speed) > FASTEST or acceleration > LARGEST_ACCELERATION) and _turns(mechanism, joint):
        text = f"{part.label} turns at {speed:.4g} rad/s, {speed * 30.0 / math.pi:.4g} rpm"
        more = f": at {arm:.3g} m from the joint that is {acceleration / STANDARD_GRAVITY:.3g} g" if arm else ""
        remedy = f"Speeds are in rad/s: 2 pi/60 times those in rpm; {speed:.4g} rpm are {speed * math.pi / 30.0:.4g}."
        yield found("odd-units", (part.name,), f"{text}{more}.", remedy, speed=speed, acceleration=acceleration)


# The part of the examination that costs next to nothing: laws and motions of users, tables, linear cells, numbers

REMEMBERED = 512
"""Number of laws whose findings are remembered: a sweep declares the same ones again and again."""

TRIED_GAP = 1e-4
"""Size of the gaps at which normal laws are tried [m]."""

_TRIED: dict[type, bool] = {}
"""Whether values of a class are tried."""

_KNOWN: dict[tuple[str, Law], tuple[Finding, ...]] = {}
"""Findings by part and law."""


def cheap_findings(mechanism: Mechanism) -> list[Finding]:
    """Findings on users' laws and motions, on tables, linear cells, and on implausible speeds and angles.

    flexmb's own laws are known to keep their signs.
    """
    findings = implausible_findings(mechanism)
    for part in mechanism.parts:
        for value in vars(part).values():
            kind = type(value)
            if kind not in _TRIED:
                _TRIED[kind] = _is_tried(kind)
            if _TRIED[kind]:
                findings += _remembered(part.name, value)
    if "flexmb.elastic.planes.plane_body" in sys.modules:  # no body has a mesh before it is imported, which takes long
        from flexmb.findings.loads import coarse_cells

        findings += coarse_cells(mechanism)
    return findings


def _is_tried(kind: type) -> bool:
    """Whether a class is one of tables, or of laws and motions that are not flexmb's own."""
    if not issubclass(kind, Law):
        return False
    ours = kind.kernel.function.__module__.partition(".")[0] == "flexmb"
    return not ours or (kind.__module__, kind.__name__) == ("flexmb.parts.drives.tables", "Table")


def _remembered(name: str, law: Law) -> tuple[Finding, ...]:
    """Findings on a law; of a law with arrays they are not remembered."""
    try:
        found = _KNOWN.get((name, law))
    except TypeError:
        return _of_law(name, law)
    if found is None:
        if len(_KNOWN) >= REMEMBERED:
            _KNOWN.clear()
        found = _KNOWN[name, law] = _of_law(name, law)
    return found


def _of_law(name: str, law: Law) -> tuple[Finding, ...]:
    """Findings on one law or motion of a part."""
    from flexmb.findings.laws import friction_sign, normal_sign, overshoot, wrong_rates
    from flexmb.parts.drives.tables import Table

    if isinstance(law, Table):
        return tuple(overshoot(name, law))
    if isinstance(law, Motion):
        return tuple(wrong_rates(name, law))
    if isinstance(law, NormalLaw):
        return tuple(normal_sign(name, law, TRIED_GAP))
    return tuple(friction_sign(name, law)) if isinstance(law, FrictionLaw) else ()
