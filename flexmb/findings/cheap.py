"""The part of the examination that costs next to nothing: laws, motions, numbers that look like other units."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cache
from typing import Any

from flexmb.fields import fields_of
from flexmb.findings.finding import Finding, found
from flexmb.model.law import FrictionLaw, Law, Motion, NormalLaw
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import Joint, Part

# Findings on numbers that look as if degrees, rpm or another sign were meant, of `check` and of runs

TURN, FINEST_PART, SAME = 2.0 * math.pi, math.pi / 24.0, 1e-6
"""Angle up to which degrees cannot be told from rad [rad]; angle of which larger ones are multiples, when meant in rad
[rad]; error of such a multiple [1]."""


def implausible_findings(mechanism: Mechanism) -> list[Finding]:
    """Findings on angles and gravity as declared."""
    findings = []
    if mechanism.gravity[1] > abs(mechanism.gravity[0]):
        text = (
            f"Gravity points upwards, Y is up: gravity is ({mechanism.gravity[0]:g}, {mechanism.gravity[1]:g}) m/s^2."
        )
        findings.append(found("upward-gravity", (), text, "Downwards it is gravity=(0, -9.81)."))
    for part in mechanism.parts:
        for name, value in _angles(part):
            shares = value / FINEST_PART
            if not TURN < abs(value) < math.inf or abs(shares - round(shares)) <= SAME:
                continue
            joint = vars(part).get("joint", "")
            held = mechanism.find(joint) if joint else None
            if joint is None or (joint and not (isinstance(held, Joint) and held.can_be_turned(mechanism))):  # travels
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


# The part of the examination that costs next to nothing: laws and motions of users, tables, numbers

REMEMBERED = 512
"""Number of laws whose findings are remembered: a sweep declares the same ones again and again."""

TRIED_GAP = 1e-4
"""Size of the gaps at which normal laws are tried [m]."""

_TRIED: dict[type, bool] = {}
"""Whether values of a class are tried."""

_KNOWN: dict[tuple[str, Law], tuple[Finding, ...]] = {}
"""Findings by part and law."""


def cheap_findings(mechanism: Mechanism) -> list[Finding]:
    """Findings on users' laws and motions, on tables, and on implausible angles and gravity.

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
    return findings


def _is_tried(kind: type) -> bool:
    """Whether a class is one of laws and motions that are not flexmb's own, or that have findings on their numbers."""
    if not issubclass(kind, Law):
        return False
    ours = kind.kernel.function.__module__.partition(".")[0] == "flexmb"
    return not ours or kind.findings is not Law.findings


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
    from flexmb.findings.laws import friction_sign, is_ours, normal_sign, wrong_rates

    own = tuple(law.findings(name))
    if is_ours(law.kernel):
        return own
    if isinstance(law, Motion):
        return (*own, *wrong_rates(name, law))
    if isinstance(law, NormalLaw):
        return (*own, *normal_sign(name, law, TRIED_GAP))
    return (*own, *friction_sign(name, law)) if isinstance(law, FrictionLaw) else own
