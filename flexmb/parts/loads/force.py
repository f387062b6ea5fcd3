"""Forces on points and torques on bodies, dead or following, constant or changing in time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import KW_ONLY, replace

from flexmb import planar
from flexmb.errors import ModelError
from flexmb.fields import field, instance, point, record, vector
from flexmb.kernels import compiled, element_kernel, signal_kernel
from flexmb.model.contributions import MULTIPLIES, Contribution, ElementContribution, signal_contributions
from flexmb.model.law import Motion
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import GROUND, Part
from flexmb.model.shape import ArrowShape, Shapes


@compiled
def put_line_force(F, nx, ny, ax, ay, bx, by, r):
    """r (6,) of a tension F along (nx, ny), the direction from the first point to the second."""
    r[0], r[1], r[2] = -F * nx, -F * ny, F * (nx * ay - ny * ax)
    r[3], r[4], r[5] = F * nx, F * ny, F * (ny * bx - nx * by)


FORCE_SIGNALS = (("fx", "N"), ("fy", "N"), ("force", "N"), ("power", "W"))  # with units, in the order of `force_signal`


@element_kernel
def dead_force_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    """Dead force (fx, fy) at the point s of a node (x, y, theta)."""
    fx, fy, sx, sy = p
    c, s = math.cos(q[2]), math.sin(q[2])
    bx, by = c * sx - s * sy, s * sx + c * sy
    r[0], r[1] = -fx, -fy
    r[2], K[2, 2] = -(bx * fy - by * fx), by * fy + bx * fx


@element_kernel
def follower_force_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    """Force with the components (f1, f2) in the frame of a node (x, y, theta), at its point s."""
    f1, f2, sx, sy = p
    c, s = math.cos(q[2]), math.sin(q[2])
    fx, fy = c * f1 - s * f2, s * f1 + c * f2
    r[0], r[1] = -fx, -fy
    r[2] = -(sx * f2 - sy * f1)  # arm and force turn together
    K[0, 2] = fy
    K[1, 2] = -fx


@signal_kernel
def force_signal(p, t, q, v, a):
    """By its number: 0 fx, 1 fy, 2 size, 3 power; p: force, point, whether it follows the node, number."""
    f1, f2, sx, sy, follows, number = p
    which, c, s = int(number), math.cos(q[2]), math.sin(q[2])
    fx, fy = (c * f1 - s * f2, s * f1 + c * f2) if follows > 0.0 else (f1, f2)
    if which < 2:
        return fx if which == 0 else fy
    if which == 2:
        return math.sqrt(fx * fx + fy * fy)
    bx, by = c * sx - s * sy, s * sx + c * sy
    return fx * (v[0] - v[2] * by) + fy * (v[1] + v[2] * bx)


# Rule of the history of a load.
HISTORY = instance(Motion, "a motion whose value multiplies the load, e.g. Pulse(end=0.1), or None for a constant load")


@record
class Force(Part):
    """A force on a point that moves with a body: dead (of constant direction in the plane), or a follower.

    Signals: fx, fy [N], force (its size times the value of `history`) [N], power [W].

    Raises
    ------
    ModelError : a force on the ground.
    InputError : a history that is no motion, a follower that is neither True nor False.

    Notes
    -----
    The tangent of a follower force is not symmetric: the force has no potential and can feed a vibration (flutter), so
    `modes` refuses such a load.  Static equilibrium takes the history at t = 0.
    """

    body: Part = field("the loaded body")
    at: tuple[float, float] = field("point of application; of a flexible body a node", "m", point)
    force: tuple[float, float] = field("(fx, fy) in the reference configuration", "N", vector)
    _: KW_ONLY
    history: Motion | None = field("motion whose value multiplies the force", rule=HISTORY, default=None)
    follower: bool = field(
        "whether the direction turns with the node that carries the point (a thrust, a jet)",
        rule=instance(bool, "True (the direction turns with the body) or False (it stays)"), default=False,
    )  # fmt: skip

    def __post_init__(self) -> None:
        super().__post_init__()
        check_loaded(self, self.body)

    @property
    def declared_load(self) -> float:
        return math.hypot(*self.force)

    def share(self, part: float) -> Force:
        return replace(self, force=(part * self.force[0], part * self.force[1])) if self.follower else self

    def shapes(self, mechanism: Mechanism) -> Shapes:
        body = mechanism.body(self.body.name, self.label)
        end, direction = body.attach(self.label, self.at), self.force
        if direction == (0.0, 0.0):
            return ()
        if self.follower:
            direction = planar.to_frame((0.0, 0.0), body.node(end.node).theta, direction)
        return (ArrowShape(self.name, end.place, direction, self.follower),)

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        body = mechanism.body(self.body.name, self.label)
        end = body.attach(self.label, self.at)
        kernel, force = dead_force_kernel, self.force
        if self.follower:
            kernel, force = follower_force_kernel, planar.to_frame((0.0, 0.0), body.node(end.node).theta, self.force)
        place, p = end.coordinates, (*force, *end.offset)
        own = (*p, float(self.follower))
        signals = signal_contributions(self.name, force_signal, FORCE_SIGNALS, place, own, use_of_factor=MULTIPLIES)
        return [ElementContribution(self.name, kernel, place, p, factor=self.history), *signals]


def check_loaded(load: Part, body: Part) -> None:
    """Refuse a load on the ground."""
    if body.name == GROUND.name:
        raise ModelError(f"{load.label} acts on the ground, which cannot move. Give a moving body.")


TORQUE_SIGNALS = (("torque", "N m"), ("power", "W"))  # signals with their units, in the order of `torque_signal`


@element_kernel
def torque_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    """Torque on one theta."""
    (torque,) = p
    r[0] = -torque


@signal_kernel
def torque_signal(p, t, q, v, a):
    """By its number: 0 torque, 1 power."""
    torque, number = p
    return torque if number == 0.0 else torque * v[0]


@record
class Torque(Part):
    """A torque on a body, or on one node of a flexible one (an end moment of a beam).

    Signals: torque (times the value of `history`) [N m], power [W].

    Raises
    ------
    ModelError : a torque on the ground.
    InputError : a history that is no motion.

    Notes
    -----
    Static equilibrium takes the history at t = 0.
    """

    body: Part = field("the loaded body")
    torque: float = field("counter-clockwise", "N m")
    at: tuple[float, float] | None = field("point whose node takes it; None: main node", "m", point, default=None)
    _: KW_ONLY
    history: Motion | None = field("motion whose value multiplies the torque", rule=HISTORY, default=None)

    def __post_init__(self) -> None:
        super().__post_init__()
        check_loaded(self, self.body)

    @property
    def declared_load(self) -> float:
        return 0.0

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        body = mechanism.body(self.body.name, self.label)
        theta = ((body.name, body.main if self.at is None else body.attach(self.label, self.at).node, 2),)
        p = (self.torque,)
        signals = signal_contributions(self.name, torque_signal, TORQUE_SIGNALS, theta, p, use_of_factor=MULTIPLIES)
        return [ElementContribution(self.name, torque_kernel, theta, p, factor=self.history), *signals]
