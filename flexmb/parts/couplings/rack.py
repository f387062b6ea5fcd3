"""Rack and pinion; a wheel that rolls on a straight track."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from flexmb.errors import ModelError
from flexmb.fields import between, directed, field, point, record
from flexmb.findings.finding import Finding, found
from flexmb.kernels import constraint_kernel
from flexmb.model.contributions import ConstraintContribution, Contribution, JointFriction, Reaction
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import GROUND, Part, WatchedMotion
from flexmb.parts.couplings.wheels import STANDARD_PRESSURE_ANGLE, Push, rack_pressure
from flexmb.parts.joints.prismatic import direction_row

PARTED = 0.05  # error of the distance of the pinion from the pitch line over its radius, above which there is a remark


@constraint_kernel
def rack_kernel(p, t, q, v, lam, g, G, g_t, gamma, H):
    """Travel of the pinion's centre along the rack, plus signed radius times relative angle, is constant."""
    ux, uy, s1x, s1y, s2x, s2y, radius, value = p
    direction_row(ux, uy, s1x, s1y, s2x, s2y, q, v, lam, 0, g, G, gamma, H)
    g[0] += radius * (q[5] - q[2]) - value
    G[0, 2] -= radius
    G[0, 5] += radius


@record
class Rack(Part):
    """Ideal rack and pinion, or a wheel that rolls on a straight track without slipping; both may move.

    Signals: force (on the pinion, along the rack) [N], torque (on the pinion, about its centre, against that of the
    force) [N m]; power (of both, given to the pinion) [W].

    Raises
    ------
    InputError : a pressure angle out of range.
    ModelError : a pitch line through the centre of the pinion, or a pinion that is its own rack.

    Notes
    -----
    The radius is the distance of the centre from the pitch line in the reference configuration.  A joint or guide must
    keep that distance: the part only couples rotation and travel.  The force F along the rack acts at the pitch point
    and presses the pinion off the rack with |F| tan(alpha), in either direction of F.
    """

    pinion: Part = field("the wheel; its centre of mass is the centre of its pitch circle")
    rack: Part = field("the rack or track; `GROUND` for a fixed one")
    at: tuple[float, float] = field("a point of the pitch line of the rack", "m", point)
    along: tuple[float, float] = field("direction of the pitch line", rule=directed, default=(1.0, 0.0))
    pressure_angle: float = field(
        "alpha of the teeth; 0: it rolls", "rad", between(0.0, 0.25 * math.pi), default=STANDARD_PRESSURE_ANGLE
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.pinion.name in (self.rack.name, GROUND.name):
            text = f"{self.label}: the pinion is {self.pinion.name!r};"
            raise ModelError(f"{text} give a moving body other than the rack.")

    def radius(self, mechanism: Mechanism) -> float:
        """Radius of the pitch circle in a `mechanism` [m]; < 0 for a pinion to the right of the direction of its rack.

        Raises
        ------
        ModelError : a pitch line through the centre of the pinion.
        """
        body = mechanism.body(self.pinion.name, self.label)
        node = body.node(body.main)
        ux, uy = self.along
        across = (ux * (node.y - self.at[1]) - uy * (node.x - self.at[0])) / math.hypot(ux, uy)
        if across == 0.0:
            text = f"{self.label}: the pitch line through {self.at} passes the centre of {self.pinion.name!r}"
            raise ModelError(f"{text}, so the pinion has no radius. Move the line to the pitch point.")
        return across

    def findings_after(self, mechanism: Mechanism, motion: WatchedMotion) -> Iterator[Finding]:
        """Finding on a pinion that leaves the pitch line."""
        pinion, rack = (mechanism.body(part.name, self.label) for part in (self.pinion, self.rack))
        end, node = rack.attach(self.label, self.at), pinion.node(pinion.main)
        radius, turned = self.radius(mechanism), rack.node(end.node).theta
        theta = motion.pose(rack.name, end.node)[:, 2]
        dx, dy = (motion.point((pinion.name, node.name, (0.0, 0.0))) - motion.point(end.place)).T
        angle = math.atan2(self.along[1], self.along[0]) - turned + theta
        across = np.cos(angle) * dy - np.sin(angle) * dx
        k = int(np.argmax(np.abs(across - radius)))
        if abs(across[k] - radius) > PARTED * abs(radius):
            text = (
                f"At t = {motion.times[k]:.6g} s the centre of {self.pinion.name!r} is {abs(across[k]):.4g} m from the "
                f"pitch line of {self.label}, whose radius is {abs(radius):.4g} m."
            )
            remedy, numbers = "Hold the distance by a joint or guide.", {"distance": across[k], "radius": radius}
            yield found("unreal-motion", (self.name,), text, remedy, time=motion.times[k], **numbers)

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        pinion, rack = (mechanism.body(part.name, self.label) for part in (self.pinion, self.rack))
        end, node = rack.attach(self.label, self.at), pinion.node(pinion.main)
        turned = rack.node(end.node).theta
        direction = math.atan2(self.along[1], self.along[0])
        radius = self.radius(mechanism)
        travel = math.cos(direction) * (node.x - self.at[0]) + math.sin(direction) * (node.y - self.at[1])
        value = travel + radius * (node.theta - turned)
        u = math.cos(direction - turned), math.sin(direction - turned)
        coordinates = (*end.coordinates, *((pinion.name, pinion.main, axis) for axis in (0, 1, 2)))
        power = Reaction("power", "W", on=(3, 4, 5), power=True)
        reactions = (Reaction("force", "N", 0, 1.0), Reaction("torque", "N m", 0, radius), power)
        p = (*u, *end.offset, 0.0, 0.0, radius, value)
        off = math.copysign(math.tan(self.pressure_angle), radius)
        push = JointFriction(rack_pressure, (-u[1], u[0], *p[2:6], off), Push(), ("", ""))
        piece = ConstraintContribution(self.name, rack_kernel, coordinates, p, 1, reactions=reactions)
        return [replace(piece, joint_friction=push) if off else piece]
