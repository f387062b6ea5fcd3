"""Dimensions and numbers as declared: sizes, clearances, beams, materials, units."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from flexmb.elastic.beams.section import Section
from flexmb.elastic.meshes.mesh import STRESS, by_region
from flexmb.elastic.planes.plane_body import PlaneBody
from flexmb.elastic.reduced.reduced import Reduced
from flexmb.errors import InputError
from flexmb.findings.cheap import implausible_findings
from flexmb.findings.finding import Finding, found
from flexmb.model.law import Material
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import Body, Joint
from flexmb.parts.bodies.flexible_body import FlexibleBody
from flexmb.parts.bodies.rigid import Bar, RigidLink

LARGEST_SIZE, SMALLEST_SIZE = 20.0, 1e-4
"""Largest and smallest size of the largest body that goes without a remark [m]."""

FAR = 1e3
"""Distance from the origin relative to the size of the mechanism, above which there is a remark: coordinates then lose
three digits and more, and above some 1e4 Newton's method does not reach its tolerance any more."""

WAVE_SPEEDS = (10.0, 25e3)
"""Speed of sound in a bar, sqrt(E/rho), least and largest [m/s]: gels have 10, diamond has 17,000."""

YIELD_STRAINS = (1e-5, 1.0)
"""Yield stress over Young's modulus, least and largest."""

GRAVITIES = (1.0, 30.0)
"""Acceleration of gravity, where there is any, least and largest [m/s^2]."""

GYRATIONS = (0.02, 3.0)
"""Radius of gyration over the length of a link, least and largest."""

BEYOND_END = 1.0
"""Distance of a joint from the nearer end of its link, relative to its length, up to which it is not odd."""

LARGE_CLEARANCE = 0.2
"""Clearance over the radius or length beside it, above which there is a remark."""

LEAST_SLENDERNESS = 5.0
"""Length of a beam over its height, below which shear cannot be left out."""


def dimension_findings(mechanism: Mechanism) -> list[Finding]:
    """Findings on the numbers of all parts."""
    return [
        *_sizes(mechanism),
        *_place(mechanism),
        *_gravity(mechanism),
        *_links(mechanism),
        *_materials(mechanism),
        *implausible_findings(mechanism),
        *_clearances(mechanism),
        *_beams(mechanism),
        *_plates(mechanism),
    ]


def size_of(mechanism: Mechanism, body: Body | None = None) -> float:
    """Largest extent of nodes and joints, of the mechanism or of one body [m]."""
    bodies = mechanism.bodies if body is None else (body,)
    points = [(node.x, node.y) for one in bodies for node in _full(one).nodes()]
    points += [point for one in bodies if isinstance(one, Bar) for point in (one.start, one.end)]
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


def _place(mechanism: Mechanism) -> Iterator[Finding]:
    size = size_of(mechanism)
    farthest = max((max(abs(node.x), abs(node.y)) for body in mechanism.bodies for node in body.nodes()), default=0.0)
    if farthest > FAR * size > 0.0:
        text = f"The mechanism is {size:.4g} m large and lies {farthest:.4g} m from the origin: its coordinates lose"
        remedy = "Subtract the place of one joint from all points."
        yield found("far-origin", (), f"{text} {math.log10(farthest / size):.0f} digits.", remedy, distance=farthest)


def _gravity(mechanism: Mechanism) -> Iterator[Finding]:
    g = math.hypot(*mechanism.gravity)
    if g > 0.0 and not GRAVITIES[0] <= g <= GRAVITIES[1]:
        text = f"Gravity is {g:.4g} m/s^2."
        yield found("odd-units", (), text, "On Earth it is 9.81 m/s^2: gravity=(0, -9.81).", gravity=g)


def _links(mechanism: Mechanism) -> Iterator[Finding]:
    for body in mechanism.bodies:
        if not isinstance(body, RigidLink):
            continue
        radius = 0.0 if body.is_massless else math.sqrt(body.inertia / body.mass)
        if not body.is_massless and not GYRATIONS[0] <= radius / body.length <= GYRATIONS[1]:
            text = (
                f"{body.label} has a radius of gyration of {radius:.4g} m and a length of {body.length:.4g} m "
                f"(mass {body.mass:.4g} kg, inertia {body.inertia:.4g} kg m^2)"
            )
            slender = body.mass * body.length * body.length / 12.0
            remedy = f"A slender bar of this mass has an inertia of {slender:.4g} kg m^2."
            yield found("odd-units", (body.name,), f"{text}.", remedy, radius=radius, length=body.length)
        for part in mechanism.parts:
            if isinstance(part, Joint) and body.name in (part.first.name, part.second.name) and part.at is not None:
                yield from _far(body, part.name, part.at)


def _far(body: RigidLink, joint: str, at: tuple[float, float]) -> Iterator[Finding]:
    along = ((at[0] - body.start[0]) * (body.end[0] - body.start[0])) / body.length
    along += ((at[1] - body.start[1]) * (body.end[1] - body.start[1])) / body.length
    beyond = max(-along, along - body.length)
    if beyond > BEYOND_END * body.length:
        text = f"The joint {joint!r} lies {beyond:.4g} m beyond the end of {body.label} ({body.length:.4g} m long)."
        yield found("far-joint", (joint, body.name), text, "Check the points of both.", distance=beyond)


def _materials(mechanism: Mechanism) -> Iterator[Finding]:
    for part in mechanism.parts:
        for material in materials_of(part):
            speed = math.sqrt(material.young / material.density)
            if not WAVE_SPEEDS[0] <= speed <= WAVE_SPEEDS[1]:
                text = f"In the material of {part.name!r} sound travels at {speed:.4g} m/s (Young's modulus"
                text = f"{text} {material.young:.4g} Pa, density {material.density:.4g} kg/m^3)."
                yield found("odd-units", (part.name,), text, "Steel has 2.1e11 Pa and 7850 kg/m^3.", speed=speed)
            strain = (material.yield_stress or 1e-3 * material.young) / material.young
            if not YIELD_STRAINS[0] <= strain <= YIELD_STRAINS[1]:
                text = (
                    f"The material of {part.name!r} yields at {material.yield_stress:.4g} Pa, a strain of {strain:.3g}."
                )
                yield found("odd-units", (part.name,), text, "Steel yields at some 3e8 Pa.", strain=strain)


def materials_of(owner: object, depth: int = 2) -> list[Material]:
    """Materials among the fields of a part, of its laws, and of the body that is reduced."""
    found_here: list[Material] = materials_of(owner.body, depth) if isinstance(owner, Reduced) else []
    for value in vars(owner).values():
        for item in _flat(value):
            if isinstance(item, Material):
                found_here.append(item)
            elif depth > 1 and type(item).__module__.startswith("flexmb.parts.contact"):
                found_here += materials_of(item, depth - 1)
    return list(dict.fromkeys(found_here))


def _full(body: Body) -> Body:
    """The body that is reduced, or the body itself."""
    return body.body if isinstance(body, Reduced) else body


def _flat(value: object) -> Iterator[object]:
    """The items of a tuple and of tuples in it, or the value itself."""
    if isinstance(value, tuple):
        for item in value:
            yield from _flat(item)
    else:
        yield value


def _plates(mechanism: Mechanism) -> Iterator[Finding]:
    for part in mechanism.bodies:
        body = _full(part)
        if isinstance(body, PlaneBody) and body.state == STRESS:
            thickness = max(value for _, value in by_region(body.label, "thickness", body.thickness))
            if thickness > body.mesh.size:
                text = f"{body.label} is {thickness:.4g} m thick and {body.mesh.size:.4g} m large."
                remedy = "Thickness is in m. Bodies thicker than large are closer to plane strain: state='strain'."
                yield found("odd-units", (part.name,), text, remedy, thickness=thickness)


def _clearances(mechanism: Mechanism) -> Iterator[Finding]:
    lengths = {body.name: body.length for body in mechanism.bodies if isinstance(body, RigidLink)}
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


def _beams(mechanism: Mechanism) -> Iterator[Finding]:
    for part in mechanism.bodies:
        body = _full(part)
        if not isinstance(body, FlexibleBody) or body.shear is not False:
            continue
        height = max(2.0 * outer_fibre(beam.section) for beam in body.beams)
        points = np.array([(node.x, node.y) for node in body.nodes()])
        length = float(np.hypot(*np.ptp(points, axis=0)))
        if length < LEAST_SLENDERNESS * height:
            text = f"{body.label} is {length:.4g} m long and {height:.4g} m high: no slender beam."
            remedy = "Take a rigid body, or shear=True; the bending of this one would lack its shear."
            yield found("stubby-beam", (part.name,), text, remedy, length=length, height=height)


def outer_fibre(section: Section) -> float:
    """Largest distance of the outer fibre [m]; where it is unknown that of a rectangle of the same A and I."""
    places = np.array([0.0, 0.5, 1.0])
    try:
        return float(np.max(section.outer_fibre_at(places)))
    except InputError:
        return float(np.max(np.sqrt(3.0 * section.second_moment_at(places) / section.area_at(places))))
