"""Connections of the bodies: groups of connected bodies, and groups without connection to the ground."""

from __future__ import annotations

import math

from flexmb.bodies.bar import Bar
from flexmb.display.text import quoted
from flexmb.doctor.finding import NOTE, Finding, found
from flexmb.drives.drive import Drive
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import GROUND, Body, Joint

SAME_POINT = 1e-6
"""Distance of two points over the length of the longest link, below which they are one."""


def groups_of_bodies(mechanism: Mechanism) -> list[tuple[str, ...]]:
    """Names of bodies in groups that joints, springs, contacts or elements connect; the ground is a body, too."""
    above = {name: name for name in (GROUND.name, *(body.name for body in mechanism.bodies))}

    def root(name: str) -> str:
        while above[name] != name:
            above[name] = above[above[name]]
            name = above[name]
        return name

    for part in mechanism.parts:
        if isinstance(part, (Body, Drive)):
            continue
        ends = [name for name in part.references() if name in above]
        for name in ends[1:]:
            above[root(name)] = root(ends[0])
    groups: dict[str, list[str]] = {}
    for name in above:
        groups.setdefault(root(name), []).append(name)
    return [tuple(group) for group in groups.values()]


def free_bodies(mechanism: Mechanism) -> list[Finding]:
    """Groups of bodies that nothing connects to the ground; a mechanism that floats as a whole is only noted."""
    groups = groups_of_bodies(mechanism)
    loose = [group for group in groups if GROUND.name not in group]
    findings = []
    for group in loose:
        several = len(group) > 1
        text = f"{quoted(group)} {'are' if several else 'is'} connected to nothing else: free in x, y and rotation."
        remedy = "Connect it by a joint, a spring or a contact, or leave it out, unless it shall fly."
        item = found("free-body", group, text, remedy)
        if len(loose) == 1 and len(groups) == 2 and not _is_held(mechanism, groups):
            item = Finding(item.code, item.parts, item.text, "", NOTE)
        findings.append(item)
    return findings


def _is_held(mechanism: Mechanism, groups: list[tuple[str, ...]]) -> bool:
    """Whether some body is connected to the ground."""
    grounded = next(group for group in groups if GROUND.name in group)
    return len(grounded) > 1 or len(mechanism.bodies) == 0


def left_out_links(mechanism: Mechanism) -> list[Finding]:
    """Links that end at a joint of two other bodies and are joined to nothing there: the joint has the wrong body."""
    joints = [part for part in mechanism.parts if isinstance(part, Joint) and part.at is not None]
    others = [part for part in mechanism.parts if not isinstance(part, (Body, Drive)) and part not in joints]
    held = {name for part in others if len(part.references()) > 1 for name in part.references()}
    bars = [body for body in mechanism.bodies if isinstance(body, Bar)]
    near, findings = SAME_POINT * max((math.dist(bar.start, bar.end) for bar in bars), default=0.0), []
    ends = [(body, point) for body in bars if body.name not in held for point in (body.start, body.end)]
    for bar, end in ends:
        here = [joint for joint in joints if math.dist(joint.at, end) <= near]
        if not here or any(bar.name in joint.references() for joint in here):
            continue
        two = [body for body in (here[0].first, here[0].second) if isinstance(body, Body)]
        wrong = [repr(body.name) for body in two if not _has_point(body, end, near)] or ["one of them"]
        text = f"{here[0].label} joins {quoted([b.name for b in two])} at ({end[0]:.4g}, {end[1]:.4g}) m, where"
        remedy = f"Was {bar.name!r} meant in place of {' or '.join(wrong)}?"
        text = f"{text} {bar.label} ends, joined to nothing."
        findings.append(found("left-out-link", (here[0].name, bar.name), text, remedy))
    return findings


def _has_point(body: Body, point: tuple[float, float], near: float) -> bool:
    """Whether a body has an end or a node within a distance of a point [m]."""
    ends = (body.start, body.end) if isinstance(body, Bar) else ()
    return any(math.dist(own, point) <= near for own in (*ends, *((node.x, node.y) for node in body.nodes())))
