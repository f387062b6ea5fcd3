"""The rigid twin of a mechanism: every flexible body replaced by the rigid one of the same mass, centre and inertia."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmb.bodies.flexible_frame import FlexibleFrame
from flexmb.bodies.flexible_link import FlexibleLink
from flexmb.bodies.rigid_body import RigidBody
from flexmb.bodies.rigid_link import RigidLink
from flexmb.errors import InputError
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import Joint, Part

Flexible = FlexibleLink | FlexibleFrame

KNOWN = (RigidBody, RigidLink, FlexibleLink, FlexibleFrame)


def rigid_twin(owner: str, mechanism: Mechanism) -> Mechanism:
    """The mechanism with rigid bodies in the places of flexible ones, under the same names, in the drawn pose.

    Parameters
    ----------
    owner : who asks, for messages.
    mechanism : what is replaced body by body.

    Raises
    ------
    InputError : a body of another kind; fields of displacement or velocity; friction in an ideal joint; a part whose
        forces remember; a spring or bushing on a flexible body, which would not feel its deformation.
    """
    for body in mechanism.bodies:
        if not isinstance(body, KNOWN):
            text = f"{owner}: {body.label} has no rigid twin"
            raise InputError(f"{text}; bodies must be RigidBody, RigidLink, FlexibleLink or FlexibleFrame.")
    flexible = {body.name: body for body in mechanism.bodies if isinstance(body, Flexible)}
    parts = tuple(_replaced(owner, part, flexible) for part in mechanism.parts)
    contributions = mechanism.contributions()
    for constraint in contributions.constraints:
        if constraint.joint_friction is not None:
            text = f"{owner}: {mechanism.find(constraint.part).label} has friction, which depends on the joint's force"
            raise InputError(f"{text}. Leave the friction out, or use a Newmark method.")
    for element in contributions.elements:
        if element.history:
            text = f"{owner}: {mechanism.find(element.part).label} has a force that remembers"
            raise InputError(f"{text}, which is not known to both models. Use a Newmark method.")
        held = next((name for name, _, _ in element.coordinates if name in flexible), None)
        if element.energy is not None and element.part not in flexible and held is not None:
            text = (
                f"{owner}: {mechanism.find(element.part).label} acts on {held!r}, whose deformation it would not feel"
            )
            raise InputError(f"{text}. Connect it to rigid bodies, or use a Newmark method.")
    return replace(mechanism, parts=parts)


def _replaced(owner: str, part: Part, flexible: dict[str, Flexible]) -> Part:
    """The part as it stands in the twin."""
    if part.name in flexible:
        return _rigid(owner, flexible[part.name])
    if isinstance(part, Joint) and part.at is None and part.second.name in flexible:
        body = flexible[part.second.name]
        node = body.node(body.main)
        return replace(part, at=(node.x, node.y))
    return part


def _rigid(owner: str, body: Flexible) -> RigidBody:
    """The rigid twin of a flexible body; its angle is that of the body's main node."""
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
    return RigidBody(body.name, own.centre, own.mass, own.inertia, angle=node.theta, velocity=velocity)
