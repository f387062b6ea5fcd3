"""Ideal revolute joint, its angle, and the rigid connection."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import KW_ONLY, replace

from flexmb.fields import field, not_negative, positive, record
from flexmb.kernels import compiled, constraint_kernel
from flexmb.model.contributions import (
    AngleContribution,
    Attachment,
    ConstraintContribution,
    Contribution,
    JointFriction,
)
from flexmb.model.law import FrictionLaw
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import Joint
from flexmb.parts.joints.contact_point import JOINT_FRICTION, check_friction, journal_friction


@compiled
def coincide(s1x, s1y, s2x, s2y, q, v, lam, g, G, gamma, H):
    """Constraint equations 0 and 1: g = x2 + R2 s2 - x1 - R1 s1 in X and Y."""
    # Equations (1.4) and (1.5) of docs/theory/equations_of_motion.md.
    c1, d1 = math.cos(q[2]), math.sin(q[2])
    c2, d2 = math.cos(q[5]), math.sin(q[5])
    ax, ay = c1 * s1x - d1 * s1y, d1 * s1x + c1 * s1y
    bx, by = c2 * s2x - d2 * s2y, d2 * s2x + c2 * s2y
    g[0] = q[3] + bx - q[0] - ax
    g[1] = q[4] + by - q[1] - ay
    G[0, 0] = -1.0
    G[0, 2] = ay
    G[0, 3] = 1.0
    G[0, 5] = -by
    G[1, 1] = -1.0
    G[1, 2] = -ax
    G[1, 4] = 1.0
    G[1, 5] = bx
    w1, w2 = v[2] * v[2], v[5] * v[5]
    gamma[0] = bx * w2 - ax * w1
    gamma[1] = by * w2 - ay * w1
    H[2, 2] = lam[0] * ax + lam[1] * ay
    H[5, 5] = -lam[0] * bx - lam[1] * by


AT_PIN, BY_ANGLES = ((0, 2, 3, 5), (1, 2, 4, 5)), ((2, 2), (5, 5))  # entries of G and H that `coincide` writes


@constraint_kernel
def coincidence_kernel(p, t, q, v, lam, g, G, g_t, gamma, H):
    """Two points of two nodes coincide."""
    s1x, s1y, s2x, s2y = p
    coincide(s1x, s1y, s2x, s2y, q, v, lam, g, G, gamma, H)


@constraint_kernel
def weld_kernel(p, t, q, v, lam, g, G, g_t, gamma, H):
    """Two points of two nodes coincide and the relative rotation stays."""
    s1x, s1y, s2x, s2y, angle = p
    coincide(s1x, s1y, s2x, s2y, q, v, lam, g, G, gamma, H)
    g[2] = q[5] - q[2] - angle
    G[2, 2] = -1.0
    G[2, 5] = 1.0


@constraint_kernel
def angle_kernel(p, t, q, v, lam, g, G, g_t, gamma, H):
    """Relative rotation of two nodes: g = theta2 - theta1 - angle; q = (theta1, theta2)."""
    (angle,) = p
    g[0] = q[1] - q[0] - angle
    G[0, 0] = -1.0
    G[0, 1] = 1.0


def drawn_angle(mechanism: Mechanism, ends: tuple[Attachment, Attachment]) -> float:
    """theta2 - theta1 of the nodes that a joint holds, in the reference configuration."""
    first, second = (mechanism.body(end.part).node(end.node).theta for end in ends)
    return second - first


def angle_contribution(part: str, mechanism: Mechanism, ends: tuple[Attachment, Attachment]) -> AngleContribution:
    """Relative rotation of the second body against the first, 0 in the reference configuration, and its rate."""
    first, second = ends
    pair = (first.part, first.node, 2), (second.part, second.node, 2)
    return AngleContribution(part, pair, (drawn_angle(mechanism, ends),))


def coincidence_piece(
    part: str, ends: tuple[Attachment, Attachment], *, holds: str = "always"
) -> ConstraintContribution:
    """The two constraint equations of a revolute joint."""
    first, second = ends
    coordinates = (*first.coordinates, *second.coordinates)
    p = (*first.offset, *second.offset)
    return ConstraintContribution(
        part, coincidence_kernel, coordinates, p, 2, second.coordinates, holds=holds, columns=AT_PIN, curved=BY_ANGLES
    )


@record
class Revolute(Joint):
    """Ideal revolute joint (pin) between two bodies.

    Signals: fx, fy, force (on the second body) [N]; angle (of the second body against the first, 0 in the reference
    configuration) [rad], omega [rad/s]; with friction also friction_torque (on the second body) [N m].

    Raises
    ------
    InputError : friction without radius, or a radius without friction.

    Notes
    -----
    With friction N is the joint's force, and the slip radius (omega2 - omega1).
    The torque of a sliding Coulomb pin is mu radius |force| (the circle of friction has the radius mu radius; exactly
    mu/sqrt(1 + mu^2) radius, since fx and fy are the joint's force without the friction on its surface).
    """

    _: KW_ONLY
    friction: FrictionLaw | None = field("law of friction of the pin", rule=JOINT_FRICTION, default=None)
    radius: float | None = field("radius of the pin, with friction", "m", positive, default=None)
    preload: float = field("further normal load, with friction", "N", not_negative, default=0.0)

    kind = "revolute"

    def __post_init__(self) -> None:
        super().__post_init__()
        check_friction(self, "radius")

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        ends = self.ends(mechanism)
        contribution, angle = coincidence_piece(self.name, ends), angle_contribution(self.name, mechanism, ends)
        if self.friction is None or self.radius is None:
            return [contribution, angle]
        p, signal = (self.radius, self.preload), ("friction_torque", "N m")
        friction = JointFriction(journal_friction, p, self.friction, signal, self.radius)
        return [replace(contribution, joint_friction=friction), angle]

    def drive_contribution(self, mechanism: Mechanism) -> ConstraintContribution | None:
        ends = self.ends(mechanism)
        coordinates = tuple(end.coordinates[2] for end in ends)
        p = (drawn_angle(mechanism, ends),)
        return ConstraintContribution(self.name, angle_kernel, coordinates, p, 1, is_drive=True, curved=())


@record
class Fixed(Joint):
    """Rigid connection of two bodies at a point.

    Signals: fx, fy, force (on the second body) [N], moment (on the second body, about the point) [N m].
    """

    kind = "fixed"
    holds_point = False

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        first, second = ends = self.ends(mechanism)
        coordinates = (*first.coordinates, *second.coordinates)
        p = (*first.offset, *second.offset, drawn_angle(mechanism, ends))
        return [
            ConstraintContribution(
                self.name,
                weld_kernel,
                coordinates,
                p,
                3,
                second=second.coordinates,
                moment_row=2,
                columns=(*AT_PIN, (2, 5)),
                curved=BY_ANGLES,
            )
        ]
