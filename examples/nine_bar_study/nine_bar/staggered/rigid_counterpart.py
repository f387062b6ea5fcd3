"""Rigid counterpart of a mechanism: rigid bodies of equal mass, centre and inertia in place of flexible bodies."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmb.errors import InputError
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import Joint, Part
from flexmb.parts.bodies.flexible_links import FlexibleFrame, FlexibleLink
from flexmb.parts.bodies.rigid import RigidBody, RigidLink

Flexible = FlexibleLink | FlexibleFrame

KNOWN = (RigidBody, RigidLink, FlexibleLink, FlexibleFrame)


def rigid_twin(owner: str, mechanism: Mechanism) -> Mechanism:
    """Rigid counterpart of a mechanism in its reference configuration; the bodies keep their names.

    Raises
    ------
    InputError : a body of an unknown kind; a field of initial displacement or velocity; friction in an ideal joint; an
        element with a history; a spring or bushing on a flexible body.
    """
    for body in mechanism.bodies:
        if not isinstance(body, KNOWN):
            text = f"{owner}: {body.label} has no rigid counterpart"
            raise InputError(f"{text}; bodies must be RigidBody, RigidLink, FlexibleLink or FlexibleFrame.")
    flexible = {body.name: body for body in mechanism.bodies if isinstance(body, Flexible)}
    parts = tuple(_replaced(owner, part, flexible) for part in mechanism.parts)
    contributions = mechanism.contributions()
    for constraint in contributions.constraints:
        if constraint.joint_friction is not None and not constraint.rubs_closed:
            text = f"{owner}: {mechanism.find(constraint.part).label} has friction, which depends on the joint's force"
            raise InputError(f"{text}. Leave the friction out, or use a Newmark method.")
    for element in contributions.elements:
        if element.history:
            text = f"{owner}: {mechanism.find(element.part).label} has a force with a history"
            raise InputError(f"{text}, which only one of the two models would know. Use a Newmark method.")
        held = next((name for name, _, _ in element.coordinates if name in flexible), None)
        if element.energy is not None and element.part not in flexible and held is not None:
            text = (
                f"{owner}: {mechanism.find(element.part).label} acts on the flexible body {held!r}, whose deformation "
                "it would ignore"
            )
            raise InputError(f"{text}. Connect it to rigid bodies, or use a Newmark method.")
    return replace(mechanism, parts=parts)


def _replaced(owner: str, part: Part, flexible: dict[str, Flexible]) -> Part:
    """Part of the rigid counterpart in place of a part of the mechanism."""
    if part.name in flexible:
        return _rigid(owner, flexible[part.name])
    if isinstance(part, Joint) and part.at is None and part.second.name in flexible:
        body = flexible[part.second.name]
        node = body.node(body.main)
        return replace(part, at=(node.x, node.y))
    return part


def _rigid(owner: str, body: Flexible) -> RigidBody:
    """Rigid counterpart of a flexible body, with the angle of its main node."""
    velocity = body.start_velocity()
    for name, field in (("velocity", velocity), ("displacement", body.start_displacement())):
        if field is not None and np.ndim(field) == 2:
            text = f"{owner}: {body.label} has a field of {name}; its elastic motion starts from rest"
            raise InputError(f"{text}. Leave it out, or use a Newmark method.")
    node, own = body.node(body.main), body.properties()
    if velocity is not None:
        vx, vy, omega = (float(x) for x in np.asarray(velocity))
        dx, dy = own.centre[0] - node.x, own.centre[1] - node.y
        velocity = (vx - omega * dy, vy + omega * dx, omega)
    return RigidBody(body.name, own.centre, own.mass, own.inertia, theta=node.theta, velocity=velocity)
