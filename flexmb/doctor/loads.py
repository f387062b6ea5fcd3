"""Loads as declared, at rest: stress of flexible bodies, buckling, penetration of contacts."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from flexmb.bodies.flexible import beam_elements
from flexmb.bodies.flexible_body import FlexibleBody
from flexmb.doctor.dimensions import materials_of, size_of
from flexmb.doctor.finding import Finding, found
from flexmb.doctor.motions import values_of
from flexmb.drives.drive import Drive
from flexmb.equilibrium.buckling import buckling
from flexmb.equilibrium.found import Equilibrium
from flexmb.equilibrium.statics import static_equilibrium
from flexmb.errors import FlexmbError
from flexmb.joints.revolute import Revolute
from flexmb.joints.revolute_clearance import RevoluteClearance
from flexmb.loads.force import Force
from flexmb.loads.torque import Torque
from flexmb.model.contributions import AXES, SignalContribution
from flexmb.model.law import Motion, NormalLaw
from flexmb.model.mechanism import Mechanism
from flexmb.planes.plane_body import PlaneBody
from flexmb.reduction.reduced import Reduced

LARGEST_STRAIN = 0.02
"""Strain of a flexible body above which linear elasticity is no longer meant."""

SAFE_LOAD = 2.0
"""Buckling factor below which there is a remark."""

DEEP = 0.2
"""Penetration under the loads at rest and in motion, over the radius, above which a contact is too soft."""

TRIES = 60
"""Number of halvings by which the penetration of a force is found."""


def load_findings(mechanism: Mechanism, free: int) -> list[Finding]:
    """Findings on a mechanism under its loads; statics are computed if drives prescribe all motions (`free` is 0)."""
    findings = _soft_contacts(mechanism)
    bodies = [body for body in mechanism.bodies if isinstance(body, FlexibleBody | PlaneBody | Reduced)]
    loaded = any(mechanism.gravity) or any(isinstance(part, (Force, Torque)) for part in mechanism.parts)
    if free or not bodies or not loaded:
        return findings
    ideal = with_ideal_joints(mechanism)
    if any(getattr(part, "clearance", None) is not None for part in ideal.parts):
        return findings
    try:
        at_rest = static_equilibrium(ideal)
    except FlexmbError as error:
        findings.append(found("no-statics", (), f"The loads at rest were not examined: {error}"))
    else:
        findings += _strains(ideal, at_rest, bodies)
    return [*findings, *_buckling(ideal)]


def with_ideal_joints(mechanism: Mechanism) -> Mechanism:
    """The mechanism with ideal revolute joints in place of revolute joints with clearance."""
    parts = [
        Revolute(part.name, part.first, part.second, part.at) if isinstance(part, RevoluteClearance) else part
        for part in mechanism.parts
    ]
    return replace(mechanism, parts=tuple(parts))


def _strains(
    mechanism: Mechanism, at_rest: Equilibrium, bodies: list[FlexibleBody | PlaneBody | Reduced]
) -> list[Finding]:
    """Findings on flexible bodies that yield or strain by much under the loads at rest."""
    findings = []
    for body in bodies:
        materials = materials_of(body)
        young = min(material.young for material in materials)
        if isinstance(body, FlexibleBody):
            strain = largest_strain(body, at_rest)
            stress = strain * young
        else:
            stress = largest_stress(body, mechanism, at_rest)
            strain = stress / young
        limits = [material.yield_stress for material in materials if material.yield_stress is not None]
        limit = min(limits) if len(limits) == len(materials) else None
        text = f"Under the loads at rest {body.label} strains by {strain:.3g} ({stress:.3g} Pa)"
        remedy = "Reduce the loads, or give a stronger section; flexible bodies are linear elastic."
        numbers = {"strain": strain, "stress": stress}
        if limit is not None and stress > limit:
            findings.append(found("overload", (body.name,), f"{text}; it yields at {limit:.3g} Pa.", remedy, **numbers))
        elif strain > LARGEST_STRAIN:
            findings.append(found("overload", (body.name,), f"{text}; no small strain.", remedy, **numbers))
    return findings


def largest_stress(body: PlaneBody | Reduced, mechanism: Mechanism, pose: Equilibrium) -> float:
    """Largest stress of a body in a pose [Pa], as its signal `von_mises` gives it; 0 where a section has no height."""
    try:
        seeking = replace(body, stress=True)
    except FlexmbError:  # a general section, whose outer fibres are unknown
        return 0.0
    signals = [one for one in seeking.contributions(mechanism) if isinstance(one, SignalContribution)]
    for signal in signals:
        if signal.place:
            q = np.array([pose[f"{part}.{node}.{AXES[axis]}"] for part, node, axis in signal.coordinates])
            still, p = np.zeros(len(q)), np.array(signal.p, dtype=float)
            return float(signal.kernel.dispatcher(p, 0.0, q, still, still, -np.inf)[0])
    return 0.0


def largest_strain(body: FlexibleBody, pose: Equilibrium) -> float:
    """Largest strain of a flexible body in a pose."""
    nodes, largest = {node.name: node for node in body.nodes()}, 0.0
    for beam in body.beams:
        x, y, theta = (
            np.array([[pose[f"{body.name}.{name}.{axis}"] for name in beam.nodes]]) for axis in ("x", "y", "theta")
        )
        largest = max(largest, float(beam_elements(beam, nodes).strains(x, y, theta).max()))
    return largest


def _buckling(ideal: Mechanism) -> list[Finding]:
    """Findings on a structure near its buckling load."""
    try:
        found_loads = buckling(ideal, count=1)
    except FlexmbError:
        return []
    positive = [float(f) for f in found_loads.factors if f > 0.0]
    if not positive or min(positive) >= SAFE_LOAD or found_loads.notes:
        return []
    text = (
        f"The loads are 1/{min(positive):.3g} of the buckling load."
        if min(positive) >= 1.0
        else (f"The loads are {1.0 / min(positive):.3g} times the buckling load.")
    )
    code = "near-buckling" if min(positive) >= 1.0 else "buckled"
    return [found(code, (), text, "Reduce the loads, or stiffen the slender beams.", factor=min(positive))]


def _soft_contacts(mechanism: Mechanism) -> list[Finding]:
    """Findings on contacts into which weight and declared forces press by much of the radius."""
    load = typical_load(mechanism)
    findings = []
    for part in mechanism.parts:
        if not isinstance(part, RevoluteClearance) or load == 0.0:
            continue
        law = part.normal.for_radii(part.bearing_radius, part.bearing_radius - part.clearance)
        depth = penetration(law, load, part.bearing_radius)
        if depth > DEEP * part.bearing_radius:
            text = (
                f"A force of {load:.4g} N, of weights and loads, presses the journal of {part.label} into its bearing"
            )
            text = f"{text} by {'more than ' if math.isinf(depth) else ''}{min(depth, part.bearing_radius):.4g} m"
            text = f"{text}; the radius is {part.bearing_radius:.4g} m."
            remedy = "If it shall not be so soft: stiffness is in N/m^n, multiply one in N/mm^1.5 by 3.16e4."
            numbers = {"force": load, "penetration": min(depth, part.bearing_radius)}
            findings.append(found("soft-contact", (part.name,), text, remedy, **numbers))
    return findings


def typical_load(mechanism: Mechanism) -> float:
    """Sum of weights, declared forces, and inertia forces of all masses on half of the mechanism's size [N]."""
    mass = sum(getattr(body, "mass", None) or 0.0 for body in mechanism.bodies)
    forces = sum(math.hypot(*part.force) for part in mechanism.parts if isinstance(part, Force))
    speeds = [abs(rate_at_start(part.motion)) for part in mechanism.parts if isinstance(part, Drive)]
    inertia = 0.5 * size_of(mechanism) * max(speeds, default=0.0) ** 2
    return float(mass * (math.hypot(*mechanism.gravity) + inertia) + forces)


def rate_at_start(motion: Motion) -> float:
    """Rate of a motion at t = 0 [rad/s, m/s]."""
    return float(motion.kernel(np.array(motion.parameters(), dtype=float), 0.0)[1])


def penetration(law: NormalLaw, force: float, radius: float) -> float:
    """Depth at which a normal law carries a force [m]; inf where the radius is not enough."""
    p = np.array(law.parameters(), dtype=float)

    def force_at(depth: float) -> float:
        z = np.array(law.history(), dtype=float)
        return float(values_of(law.kernel, p, 1e-5, -depth, 0.0, z, z.copy())[0])

    low, high = 0.0, radius
    if force_at(high) < force:
        return math.inf
    for _ in range(TRIES):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if force_at(middle) < force else (low, middle)
    return high
