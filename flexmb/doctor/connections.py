"""Connections of the bodies: groups of connected bodies, and groups without connection to the ground."""

from __future__ import annotations

from flexmb.display.text import quoted
from flexmb.doctor.finding import NOTE, Finding, found
from flexmb.drives.drive import Drive
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import GROUND, Body


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
