"""Dimensions and numbers as declared: sizes, clearances, materials, angles, units; parts answer for themselves."""

import math
from collections.abc import Iterator
from functools import cache
from typing import Any

import numpy as np

from flexmb.fields import fields_of
from flexmb.findings.finding import Finding, found
from flexmb.model.law import Motion
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import Body, Joint, Part

LARGEST_SIZE, SMALLEST_SIZE = 20.0, 1e-4  # largest and smallest size of the largest body that goes without a remark [m]
# Distance from the origin relative to the size of the mechanism, above which there is a remark: coordinates then lose
# three digits and more, and above some 1e4 Newton's method does not reach its tolerance any more.
FAR = 1e3
WAVE_SPEEDS = (10.0, 25e3)  # speed of sound in a bar, sqrt(E/rho), least and largest [m/s]: gels 10, diamond 17,000
YIELD_STRAINS = (1e-5, 1.0)  # yield stress over Young's modulus, least and largest
GRAVITIES = (1.0, 30.0)  # acceleration of gravity, where there is any, least and largest [m/s^2]
LARGE_CLEARANCE = 0.2  # clearance over the radius or length beside it, above which there is a remark


def dimension_findings(mechanism: Mechanism) -> list[Finding]:
    """Findings on the numbers of all parts."""
    own = [finding for part in mechanism.parts for finding in part.answers("findings_before", mechanism)]
    sizes = [*_sizes(mechanism), *_materials(mechanism)]
    return [*sizes, *implausible_findings(mechanism), *_clearances(mechanism), *own]


def size_of(mechanism: Mechanism, body: Body | None = None) -> float:
    """Largest extent of nodes and joints, of the mechanism or of one body [m]."""
    bodies = mechanism.bodies if body is None else (body,)
    points = [(node.x, node.y) for one in bodies for node in one.whole_body.nodes()]
    points += [point for one in bodies for point in one.bar_ends]
    names = {one.name for one in bodies}
    joints = (part for part in mechanism.parts if isinstance(part, Joint) and part.at is not None)
    points += [joint.at for joint in joints if names & {joint.first.name, joint.second.name}]
    return float(np.ptp(np.array(points), axis=0).max()) if points else 0.0


def _sizes(mechanism: Mechanism) -> Iterator[Finding]:
    sizes = {body.name: size_of(mechanism, body) for body in mechanism.bodies}
    name = max(sizes, key=lambda name: sizes[name], default="")
    size = sizes.get(name, 0.0)
    if size > LARGEST_SIZE or 0.0 < size < SMALLEST_SIZE:
        text = f"The largest body, {name!r}, is {size:.4g} m long."
        yield found("odd-units", (name,), text, "Lengths are in m: a length in mm is divided by 1000.", size=size)
    size = size_of(mechanism)
    farthest = max((max(abs(node.x), abs(node.y)) for body in mechanism.bodies for node in body.nodes()), default=0.0)
    if farthest > FAR * size > 0.0:
        text = f"The mechanism is {size:.4g} m large and lies {farthest:.4g} m from the origin: its coordinates lose"
        remedy = "Subtract the place of one joint from all points."
        yield found("far-origin", (), f"{text} {math.log10(farthest / size):.0f} digits.", remedy, distance=farthest)
    g = math.hypot(*mechanism.gravity)
    if g > 0.0 and not GRAVITIES[0] <= g <= GRAVITIES[1]:
        text = f"Gravity is {g:.4g} m/s^2."
        yield found("odd-units", (), text, "On Earth it is 9.81 m/s^2: gravity=(0, -9.81).", gravity=g)


def _materials(mechanism: Mechanism) -> Iterator[Finding]:
    for part in mechanism.parts:
        for material in part.all_materials:
            speed = math.sqrt(material.young / material.density)
            if not WAVE_SPEEDS[0] <= speed <= WAVE_SPEEDS[1]:
                text = f"In the material of {part.name!r} sound travels at {speed:.4g} m/s (Young's modulus"
                text = f"{text} {material.young:.4g} Pa, density {material.density:.4g} kg/m^3)."
                yield found("odd-units", (part.name,), text, "Steel has 2.1e11 Pa and 7850 kg/m^3.", speed=speed)
            strain = (material.yield_stress or 1e-3 * material.young) / material.young
            if not YIELD_STRAINS[0] <= strain <= YIELD_STRAINS[1]:
                limit = material.yield_stress
                text = f"The material of {part.name!r} yields at {limit:.4g} Pa, a strain of {strain:.3g}."
                yield found("odd-units", (part.name,), text, "Steel yields at some 3e8 Pa.", strain=strain)


def _clearances(mechanism: Mechanism) -> Iterator[Finding]:
    bars = (body for body in mechanism.bodies if body.bar_ends and not body.is_elastic)
    lengths = {bar.name: math.dist(*bar.bar_ends) for bar in bars}
    for part in mechanism.parts:
        clearance = getattr(part, "clearance", None)
        if not isinstance(part, Joint) or not isinstance(clearance, float):
            continue
        radius = getattr(part, "bearing_radius", None) or getattr(part, "pin_radius", None)
        beside = [("radius", radius)] if isinstance(radius, float) else []
        beside += [(f"length of {n}", lengths[n]) for n in (part.first.name, part.second.name) if n in lengths]
        for word, length in beside:
            if clearance > LARGE_CLEARANCE * length:
                text = f"{part.label} has a clearance of {clearance:.4g} m beside a {word} of {length:.4g} m."
                remedy = "Laws of contact suppose a small clearance; its unit is m."
                yield found("large-clearance", (part.name,), text, remedy, clearance=clearance, length=length)
                break


# Findings on numbers that look as if degrees, rpm or another sign were meant, of `check` and of runs

# Angle up to which degrees cannot be told from rad [rad]; angle of which larger ones are multiples, when meant in rad
# [rad]; error of such a multiple [1].
TURN, FINEST_PART, SAME = 2.0 * math.pi, math.pi / 24.0, 1e-6


def implausible_findings(mechanism: Mechanism) -> list[Finding]:
    """Findings on angles and gravity as declared."""
    findings = []
    if mechanism.gravity[1] > abs(mechanism.gravity[0]):
        gx, gy = mechanism.gravity
        text = f"Gravity points upwards, Y is up: gravity is ({gx:g}, {gy:g}) m/s^2."
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
            angle = math.radians(value)
            remedy = f"Angles are in rad: {value:.4g} degrees are math.radians({value:.4g}) = {angle:.4g} rad."
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
