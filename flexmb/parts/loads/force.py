"""Forces, torques, springs and dampers: on points and bodies, between points and between rotations."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import KW_ONLY, replace
from numbers import Real
from typing import Any

import numpy as np

from flexmb import checks, planar
from flexmb.errors import InputError, ModelError
from flexmb.fields import Rule, field, instance, not_negative, point, record, vector
from flexmb.kernels import compiled, element_kernel, signal_kernel
from flexmb.model import contributions as pieces
from flexmb.model.law import Motion
from flexmb.model.massless import massless
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import GROUND, Part, PointToPoint
from flexmb.model.shape import DAMPER, SPRING, ArrowShape, LineShape, Shapes
from flexmb.parts.joints.contact_point import arms_of
from flexmb.places import packed


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

    def contributions(self, mechanism: Mechanism) -> Sequence[pieces.Contribution]:
        body = mechanism.body(self.body.name, self.label)
        end = body.attach(self.label, self.at)
        kernel, force = dead_force_kernel, self.force
        if self.follower:
            kernel, force = follower_force_kernel, planar.to_frame((0.0, 0.0), body.node(end.node).theta, self.force)
        place, p = end.coordinates, (*force, *end.offset)
        own = self.name, force_signal, FORCE_SIGNALS, place, (*p, float(self.follower))
        signals = pieces.signal_contributions(*own, use_of_factor=pieces.MULTIPLIES)
        return [pieces.ElementContribution(self.name, kernel, place, p, factor=self.history), *signals]


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

    def contributions(self, mechanism: Mechanism) -> Sequence[pieces.Contribution]:
        body = mechanism.body(self.body.name, self.label)
        theta = ((body.name, body.main if self.at is None else body.attach(self.label, self.at).node, 2),)
        own = theta, (self.torque,)
        told = pieces.MULTIPLIES
        signals = pieces.signal_contributions(self.name, torque_signal, TORQUE_SIGNALS, *own, use_of_factor=told)
        return [pieces.ElementContribution(self.name, torque_kernel, *own, factor=self.history), *signals]


# Springs whose rest length or rest angle moves: the force by which the moving end differs from a fixed one
@element_kernel
def line_pull_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    """Tension F of constant size along the line of two points; q (6,)."""
    F, s1x, s1y, s2x, s2y = p
    ax, ay, bx, by, dx, dy = arms_of(s1x, s1y, s2x, s2y, q)
    l = (dx * dx + dy * dy) ** 0.5
    if l == 0.0:
        return  # no direction: no force
    nx, ny = dx / l, dy / l
    put_line_force(F, nx, ny, ax, ay, bx, by, r)
    across = (ny, -nx, -nx * ax - ny * ay, -ny, nx, nx * bx + ny * by)  # derivatives of the direction, times l
    for i in range(6):
        for j in range(6):
            K[i, j] += F / l * across[i] * across[j]
    K[2, 2] += F * (nx * ax + ny * ay)
    K[5, 5] -= F * (nx * bx + ny * by)


@element_kernel
def couple_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    """Constant moment M between two rotations, with the sign of a spring that is turned by M/k; q (2,)."""
    (moment,) = p
    r[0] = -moment
    r[1] = moment


def rest_at_start(label: str, name: str, rest: Any) -> float:
    """Rest length [m] or angle [rad] at t = 0 of a number or of a motion, which must be finite there."""
    if not isinstance(rest, Motion):
        return float(rest)
    value = float(rest.kernel(np.array(rest.parameters(), dtype=float), 0.0)[0])
    if not np.isfinite(value):
        raise InputError(f"{label}: {name} is {value} at t = 0; its motion must be finite there.")
    return value


def checked_rest(label: str, name: str, rest: Any, unit: str, _: str) -> float | Motion:
    """A rest length or rest angle: a number or a motion."""
    if isinstance(rest, Motion):
        return rest
    if isinstance(rest, Real) and not isinstance(rest, bool):
        return checks.number(label, name, rest, unit)
    text = f"{label}: {name} is {rest!r}; it must be a number in {unit}, or a motion whose value it is, e.g."
    raise InputError(f"{text} Harmonic(0.01, frequency=2.0, mean=0.2).")


def moving_end(
    part: str, kernel: Any, coordinates: tuple[pieces.Coordinate, ...], stiffness: float, rest: Any, start: float,
    more: tuple[float, ...],
) -> list[pieces.ElementContribution]:  # fmt: skip
    """Loads -k rest(t) and k rest(0), which make a spring with the rest length rest(0) one whose rest length moves."""
    # k is `stiffness`; `kernel` is that of a force of constant size, which is its first parameter, followed by `more`.
    # With a number for `rest` nothing moves; `start` is its value at t = 0.
    if not isinstance(rest, Motion) or stiffness == 0.0:
        return []
    found = [pieces.ElementContribution(part, kernel, coordinates, (-stiffness, *more), factor=rest)]
    if start != 0.0:
        found.append(pieces.ElementContribution(part, kernel, coordinates, (stiffness * start, *more)))
    return found


# Parameters p: k, d, l0, and the points in the frames of their nodes; number of the signal.
STIFFNESS, DAMPING, FREE_LENGTH, OFFSET1_X, OFFSET1_Y, OFFSET2_X, OFFSET2_Y, CHOSEN = range(8)
# Signals with their units, in the order of `spring_damper_signal`.
SPRING_SIGNALS = (("length", "m"), ("rate", "m/s"), ("force", "N"), ("energy", "J"))


@compiled
def stretched(p, q, v):
    """Length, its rate, direction and arms; without a length there is no direction and no rate."""
    ax, ay, bx, by, dx, dy = arms_of(p[OFFSET1_X], p[OFFSET1_Y], p[OFFSET2_X], p[OFFSET2_Y], q)
    l = math.sqrt(dx * dx + dy * dy)
    if l == 0.0:
        return l, 0.0, 0.0, 0.0, ax, ay, bx, by
    nx, ny = dx / l, dy / l
    rate = nx * (v[3] - by * v[5] - v[0] + ay * v[2]) + ny * (v[4] + bx * v[5] - v[1] - ax * v[2])
    return l, rate, nx, ny, ax, ay, bx, by


@compiled
def energies(p, l, rate):
    """Energy of the spring, no weight, power of the damper."""
    return 0.5 * p[STIFFNESS] * (l - p[FREE_LENGTH]) ** 2, 0.0, p[DAMPING] * rate * rate


@compiled
def put_force(p, q, v, r):
    """r (6,); energy of the spring, no weight, power of the damper."""
    l, rate, nx, ny, ax, ay, bx, by = stretched(p, q, v)
    put_line_force(p[STIFFNESS] * (l - p[FREE_LENGTH]) + p[DAMPING] * rate, nx, ny, ax, ay, bx, by, r)
    return energies(p, l, rate)


@element_kernel
def spring_damper_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    """F = k (l - l0) + d l_dot along the line of the points; q (6,)."""
    k, d, l0 = p[STIFFNESS], p[DAMPING], p[FREE_LENGTH]
    l, rate, nx, ny, ax, ay, bx, by = stretched(p, q, v)
    if l == 0.0:
        return  # no direction: no force
    put_force(p, q, v, r)
    jx, jy = (-1.0, 0.0, ay, 1.0, 0.0, -by), (0.0, -1.0, -ax, 0.0, 1.0, bx)  # columns of d(dx, dy)/dq
    spin = 0.0
    for i in range(6):
        spin += (-ny * jx[i] + nx * jy[i]) * v[i]
    F = k * (l - l0) + d * rate
    # d(l_dot)/dq = spin/l * (t . J) + n . d(J v)/dq, the latter only through the arms
    turn1, turn2 = (nx * ax + ny * ay) * v[2], -(nx * bx + ny * by) * v[5]
    for i in range(6):
        Jn, Jt = nx * jx[i] + ny * jy[i], -ny * jx[i] + nx * jy[i]
        rate_q = spin * Jt / l
        if i == 2:
            rate_q += turn1
        elif i == 5:
            rate_q += turn2
        for j in range(6):
            Jnj, Jtj = nx * jx[j] + ny * jy[j], -ny * jx[j] + nx * jy[j]
            K[j, i] += Jnj * (k * Jn + d * rate_q) + F / l * Jtj * Jt
            C[j, i] += d * Jnj * Jn
    K[2, 2] += F * (nx * ax + ny * ay)
    K[5, 5] -= F * (nx * bx + ny * by)


SPRING_DAMPER = massless("SPRING_DAMPER", globals(), spring_damper_kernel)


@signal_kernel
def spring_damper_signal(p, t, q, v, a):
    """`CHOSEN`: 0 length, 1 its rate, 2 tension of spring and damper, 3 energy of the spring."""
    l, rate, _, _, _, _, _, _ = stretched(p, q, v)
    which = int(p[CHOSEN])
    if which < 2:
        return l if which == 0 else rate
    if which == 2:
        return p[STIFFNESS] * (l - p[FREE_LENGTH]) + p[DAMPING] * rate
    strain, _, _ = energies(p, l, rate)
    return strain


@record
class SpringDamper(PointToPoint):
    """Linear spring and damper between a point of one body and a point of another.

    Signals: length [m], rate (of the length) [m/s], force (tension of spring and damper; negative: pressure) [N],
    energy (of the spring, where its free length is no motion) [J].

    Raises
    ------
    InputError : negative values; points that coincide without a free length; a free length of another kind.

    Notes
    -----
    The free length may be a motion: its value at each time, as of a spring whose far end an actuator moves.
    With a free length that moves, the energy of the spring is counted with the free length at t = 0, and the rest of
    its force as a load: the work of the load is the actuator's, less what the spring holds more than is counted.
    """

    _: KW_ONLY
    stiffness: float = field("k", "N/m", not_negative)
    damping: float = field("d", "N s/m", not_negative, default=0.0)
    free_length: float | Motion | None = field("without force; None: as drawn", "m", Rule(checked_rest), default=None)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.free_length is not None:
            length = rest_at_start(self.label, "free_length", self.free_length)
            checks.not_negative(self.label, "free_length", length, "m")
        if planar.distance(self.at, self.to) == 0.0:
            raise InputError(f"{self.label}: both points are {self.at}; a spring without length has no direction.")

    def shapes(self, mechanism: Mechanism) -> Shapes:
        first, second = self.ends(mechanism)
        return (LineShape(self.name, SPRING if self.stiffness > 0.0 else DAMPER, first.place, second.place),)

    def contributions(self, mechanism: Mechanism) -> Sequence[pieces.Contribution]:
        """One element and four signals; with a free length that moves two loads more, and no energy."""
        ends = self.ends(mechanism)
        rest = planar.distance(self.at, self.to) if self.free_length is None else self.free_length
        length = rest_at_start(self.label, "free_length", rest)
        laws = {STIFFNESS: self.stiffness, DAMPING: self.damping, FREE_LENGTH: length}
        p = packed(laws | dict(enumerate(ends.offsets, OFFSET1_X)))
        element = SPRING_DAMPER.contribution(self.name, ends.coordinates, p)
        moving = moving_end(self.name, line_pull_kernel, ends.coordinates, self.stiffness, rest, length, ends.offsets)
        signals = pieces.signal_contributions(self.name, spring_damper_signal, SPRING_SIGNALS, ends.coordinates, p)
        if moving:  # the force counts from the length 0
            size, rate, force, _ = signals
            whole = (*force.p[:FREE_LENGTH], 0.0, *force.p[FREE_LENGTH + 1 :])
            signals = [size, rate, replace(force, p=whole, use_of_factor=pieces.ADDS)]
        return [element, *moving, *signals]


# Signals with their units, in the order of `torsion_spring_signal`.
TORSION_SIGNALS = (("angle", "rad"), ("rate", "rad/s"), ("torque", "N m"), ("energy", "J"))


@compiled
def put_moment(p, q, v, r):
    """r (2,); energy of the spring, no weight, power of the damper."""
    k, d, angle = p
    turn, rate = q[1] - q[0] - angle, v[1] - v[0]
    moment = k * turn + d * rate
    r[0] = -moment
    r[1] = moment
    return 0.5 * k * turn * turn, 0.0, d * rate * rate


@element_kernel
def torsion_spring_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    """M = k (theta2 - theta1 - angle0) + d (omega2 - omega1); q = (theta1, theta2)."""
    k, d, _ = p
    put_moment(p, q, v, r)
    for i in range(2):
        for j in range(2):
            sign = 1.0 if i == j else -1.0
            K[i, j], C[i, j] = sign * k, sign * d


TORSION_SPRING = massless("TORSION_SPRING", {**globals(), "put_force": put_moment}, torsion_spring_kernel)


@signal_kernel
def torsion_spring_signal(p, t, q, v, a):
    """By its number: 0 relative rotation, 1 its rate, 2 torque on the second body, 3 energy of the spring."""
    k, d, angle, drawn, number = p
    which, turn, rate = int(number), q[1] - q[0] - angle, v[1] - v[0]
    if which < 2:
        return q[1] - q[0] - drawn if which == 0 else rate
    return -k * turn - d * rate if which == 2 else 0.5 * k * turn * turn


@record
class TorsionSpring(Part):
    """Linear torsion spring and damper between two bodies.

    Signals: angle (of the second body against the first, 0 in the reference configuration) [rad], rate [rad/s], torque
    (of spring and damper, on the second body) [N m], energy (of the spring, where its rest angle is no motion) [J].

    Raises
    ------
    InputError : negative stiffness or damping, a rest angle that is neither a number nor a motion.

    Notes
    -----
    The rest angle counts from the reference configuration.  It may be a motion, as of a spring whose far end an
    actuator turns.  With a rest angle that moves, the energy of the spring is counted with the rest angle at t = 0, and
    the rest of its moment as a load: the work of the load is the actuator's, less what the spring holds more than is
    counted.
    """

    formerly = (("rest_angle", "free_angle", "0.3"),)
    first: Part = field("first body; `GROUND` is the frame")
    second: Part = field("second body")
    _: KW_ONLY
    stiffness: float = field("k", "N m/rad", not_negative)
    damping: float = field("d", "N m s/rad", not_negative, default=0.0)
    free_angle: float | Motion = field("relative rotation without moment", "rad", Rule(checked_rest), default=0.0)
    at: tuple[float, float] | None = field("point whose nodes it ties; None: main nodes", "m", point, default=None)

    def __post_init__(self) -> None:
        super().__post_init__()
        rest_at_start(self.label, "free_angle", self.free_angle)

    def contributions(self, mechanism: Mechanism) -> Sequence[pieces.Contribution]:
        """One element on two angles and four signals; with a rest angle that moves two loads more, and no energy."""
        rest = rest_at_start(self.label, "free_angle", self.free_angle)
        coordinates, drawn = [], 0.0
        for part, sign in ((self.first, -1.0), (self.second, 1.0)):
            body = mechanism.body(part.name, self.label)
            node = body.main if self.at is None else body.attach(self.label, self.at).node
            coordinates.append((body.name, node, 2))
            drawn += sign * body.node(node).theta
        p, pair = (self.stiffness, self.damping, rest + drawn), tuple(coordinates)
        element = TORSION_SPRING.contribution(self.name, pair, p)
        moving = moving_end(self.name, couple_kernel, pair, self.stiffness, self.free_angle, rest, ())
        signals = pieces.signal_contributions(self.name, torsion_spring_signal, TORSION_SIGNALS, pair, (*p, drawn))
        if moving:
            angle, rate, torque, _ = signals
            counted = (self.stiffness, self.damping, drawn, *torque.p[3:])
            signals = [angle, rate, replace(torque, p=counted, use_of_factor=pieces.SUBTRACTS)]
        return [element, *moving, *signals]
