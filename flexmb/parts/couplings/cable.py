"""Cables and massless rods: two points that keep their distance, or come nearer only."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import KW_ONLY

import numpy as np

from flexmb import planar
from flexmb.errors import InputError, ModelError
from flexmb.fields import Rule, field, positive, record, vector
from flexmb.findings.finding import Finding, found
from flexmb.kernels import compiled, constraint_kernel
from flexmb.model.contributions import (
    ConstraintContribution,
    ContactContribution,
    Contribution,
    Ends,
    Reaction,
    SignalContribution,
)
from flexmb.model.law import NormalLaw
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import Part, PointToPoint, WatchedMotion, refuse_one_body
from flexmb.model.shape import CABLE, ROD, CircleShape, LineShape, Shapes
from flexmb.parts.contact.friction import Frictionless
from flexmb.parts.joints.contact_point import arms_of, dot
from flexmb.parts.joints.revolute import drawn_theta
from flexmb.parts.joints.stop import NO_CLEARANCE, own_stiffness, strand, strand_gap_kernel, strand_length

FIRST_ANGLE, SECOND_ANGLE = 2, 5  # places of the angles of two nodes among their coordinates


@compiled
def line_between(s1x, s1y, s2x, s2y, q):
    """Line from a point of the first node to one of the second: length, direction e; derivatives by q (6,)."""
    # With d = x2 + R2 s2 - x1 - R1 s1 these are along = e . dd/dq, that of the length, and across = n . dd/dq with n =
    # (-ey, ex), that of the angle times the length. Second derivatives of the length are across across^T/length, of the
    # angle -(along across^T + across along^T)/length^2; besides, by (2, 2) and (5, 5), -across and along/length.
    ax, ay, bx, by, dx, dy = arms_of(s1x, s1y, s2x, s2y, q)
    size = math.sqrt(dx * dx + dy * dy)
    ex, ey = dx / size, dy / size
    along = (-ex, -ey, ex * ay - ey * ax, ex, ey, ey * bx - ex * by)
    return size, ex, ey, along, (ey, -ex, -ey * ay - ex * ax, -ey, ex, ex * bx + ey * by)


@compiled
def add_bending(k, size, across, H):
    """H += k times the second derivatives of the length of a line."""
    for i in range(6):
        for j in range(6):
            H[i, j] += k * across[i] * across[j] / size
    H[2, 2] -= k * across[FIRST_ANGLE]
    H[5, 5] -= k * across[SECOND_ANGLE]


@constraint_kernel
def distance_kernel(p, t, q, v, lam, g, G, g_t, gamma, H):
    """g = |d| - length with d = x2 + R2 s2 - x1 - R1 s1; q (6,)."""
    s1x, s1y, s2x, s2y, length = p
    size, _, _, along, across = line_between(s1x, s1y, s2x, s2y, q)
    g[0] = size - length
    for i in range(6):
        G[0, i] = along[i]
    turn = dot(across, v)
    gamma[0] = -turn * turn / size + across[FIRST_ANGLE] * v[2] * v[2] + across[SECOND_ANGLE] * v[5] * v[5]
    add_bending(lam[0], size, across, H)


@record
class Distance(PointToPoint):
    """Massless rigid rod with a pin at each end: two points of two bodies keep their distance.

    Signals: force (tension of the rod; negative: pressure) [N].

    Raises
    ------
    InputError : points that coincide: such a rod is a revolute joint.
    ModelError : a rod from a body to itself.
    """

    def __post_init__(self) -> None:
        super().__post_init__()
        if planar.distance(self.at, self.to) == 0.0:
            raise InputError(f"{self.label}: both points are {self.at}; a rod needs a length. Use Revolute(...).")
        refuse_one_body(self)

    def shapes(self, mechanism: Mechanism) -> Shapes:
        first, second = self.ends(mechanism)
        return (LineShape(self.name, ROD, first.place, second.place),)

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        ends, tension = self.ends(mechanism), Reaction("force", "N", 0, -1.0)
        own = (*ends.offsets, planar.distance(self.at, self.to)), 1, ends.second.coordinates
        return [ConstraintContribution(self.name, distance_kernel, ends.coordinates, *own, reactions=(tension,))]


def rounds(part: Part, motion: WatchedMotion, ends: Ends, R: float, drawn: np.ndarray, hint: str) -> Iterator[Finding]:
    """Finding on a line between two points, or a tangent of circles about them, that leaves half a turn."""
    d = np.vstack([drawn, motion.point(ends.second.place) - motion.point(ends.first.place)])
    angle = np.arctan2(d[:, 1], d[:, 0]) - np.arcsin(np.clip(R / np.hypot(*d.T), -1.0, 1.0))
    turn = np.abs(np.unwrap(angle) - angle[0])
    if (k := int(np.argmax(turn > math.pi))) > 0:
        text = f"At t = {(when := motion.times[k - 1]):.6g} s {part.label} has turned by more than half a turn;"
        yield found("unreal-motion", (part.name,), f"{text} it does not count turns.", hint, wrong=True, time=when)


LARGE_STRETCH = 0.2  # elongation over length above which there is a remark


@record
class Cable(PointToPoint):
    """Cable, rope or chain without mass between two points or drums: slack it does nothing, taut it pulls.

    A contact whose gap is the slack and whose penetration is the elongation.  A drum winds R theta of the cable up, and
    is pulled at the tangent of the strand, which moves with drum and load; a radius > 0 winds up while the drum turns
    counter-clockwise, < 0 clockwise.  With a free length below the distance of the points it starts under tension.  The
    law of a linear cable is `KelvinVoigt(K, damping)` with K = E A / free_length [N/m].

    Signals: distance of the points (free length between drums) [m], and those of a contact (see `RevoluteClearance`):
    penetration (elongation) [m], normal_force (tension) [N], fx, fy, force (on the second body) [N], mode (0 slack, 1
    jerk, 2 taut); ex, ey from the first point to the second [m].

    Raises
    ------
    InputError : a length that is not > 0, an object that is no normal law, a law whose stiffness depends on the radii
        of a joint.
    ModelError : a cable from a body to itself; drums that overlap.

    Notes
    -----
    Static equilibrium, modes of prestressed structures and runs take the tension of the start into account.  The ledger
    counts energy that a contact holds as dissipated until it is given back, so `energy.dissipated_contact` falls below
    zero where tension of the start is released.  No mass and no bending stiffness: not for sag and not for waves in
    long cables.

    A pulley is a wheel with two cables, one wound on and one off it, so tensions differ by its inertia and friction; it
    may move, and the cable does not slip on it.  The stiffness does not change with the wound length,
    and the strand may turn by less than half a turn from the direction in which it is drawn.
    """

    formerly = (("length", "free_length", "0.3"),)
    _: KW_ONLY
    free_length: float | None = field("length without tension; None: of the points", "m", positive, default=None)
    normal: NormalLaw = field("tension over elongation", rule=Rule(own_stiffness))
    radii: tuple[float, float] = field("radii of both drums, see above; 0: a point", "m", vector, default=(0.0, 0.0))

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.free_length is None and planar.distance(self.at, self.to) == 0.0:
            text = f"{self.label}: both points are {self.at}, so the cable needs a length."
            raise InputError(f"{text} Give free_length= in m.")
        refuse_one_body(self, "ties {} to")

    @property
    def slack_length(self) -> float:
        """Length without tension [m]."""
        return self._drawn()[2] if self.free_length is None else self.free_length

    def _drawn(self) -> tuple[float, float, float]:
        """Direction and free length of the strand in the reference configuration."""
        ux, uy, size, _ = strand(sum(self.radii), self.to[0] - self.at[0], self.to[1] - self.at[1])
        return ux, uy, size

    def shapes(self, mechanism: Mechanism) -> Shapes:
        ends = self.ends(mechanism)
        drums = (CircleShape(self.name, e.place, abs(r)) for e, r in zip(ends, self.radii, strict=True) if r)
        return (LineShape(self.name, CABLE, ends[0].place, ends[1].place), *drums)

    def findings_after(self, mechanism: Mechanism, motion: WatchedMotion) -> Iterator[Finding]:
        """Findings on an elongation that no cable bears, and on a strand that goes round."""
        (stretch, when), length = motion.peak(f"{self.name}.penetration"), self.slack_length
        if stretch > LARGE_STRETCH * length:
            text = f"At t = {when:.6g} s {self.label} is stretched by {stretch:.4g} m, its length is {length:.4g} m."
            remedy = "The stiffness of a cable is E A/length, in N/m."
            yield found("unreal-motion", (self.name,), text, remedy, time=when, stretch=stretch, length=length)
        if R := sum(self.radii):
            drawn, hint = np.subtract(self.to, self.at), "Draw it in the middle of its way."
            yield from rounds(self, motion, self.ends(mechanism), R, drawn, hint)

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        ends = self.ends(mechanism)
        coordinates, offsets = ends.coordinates, ends.offsets
        ux, uy, size = self._drawn()
        if any(self.radii) and size == 0.0:
            raise ModelError(f"{self.label}: its drums overlap, so there is no strand between them. Move one of them.")
        turns = [drawn_theta(mechanism, end) for end in ends]
        period = 2.0 * math.pi * abs(sum(self.radii))
        wound = self.radii[0] * turns[0] + self.radii[1] * turns[1]
        p = (NO_CLEARANCE, 1.0, self.slack_length + wound, *offsets, *self.radii, math.atan2(uy, ux))
        laws, least = (self.normal, Frictionless()), abs(sum(self.radii))
        contact = ContactContribution(self.name, strand_gap_kernel, coordinates, p, *laws, period=period)
        return [contact, SignalContribution(self.name, "distance", "m", strand_length, coordinates, (*offsets, least))]
