"""Rigid bodies, bars between two points, particles, and the inertia of nodes."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from flexmb import checks, kernels, planar
from flexmb.errors import InputError, ModelError
from flexmb.fields import Rule, between, field, point, positive, record, several, vector
from flexmb.findings.finding import Finding, found
from flexmb.model import contributions as pieces
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import Body, Joint
from flexmb.model.shape import Point, RigidShape, Shapes
from flexmb.places import ARM1_X, ARM1_Y, ARM2_X, ARM2_Y, NORMAL_X, NORMAL_Y


@kernels.element_kernel
def node_mass_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    """Rigid body at its centre of mass (x, y, theta): r = m (a - g), J alpha."""
    m, J, gx, gy = p
    r[0], r[1], r[2] = m * (a[0] - gx), m * (a[1] - gy), J * a[2]
    M[0, 0], M[1, 1], M[2, 2] = m, m, J


@kernels.energy_kernel
def node_mass_energy(p, t, q, v):
    """Potential energy of gravity alone."""
    m, J, gx, gy = p
    return 0.0, -m * (gx * q[0] + gy * q[1]), 0.0


@kernels.damping_kernel
def undamped(p, t, q, v, w):
    """No power."""
    return 0.0, 0.0


def node_mass(part: str, node: str, mass: float, inertia: float, gravity: Point) -> pieces.ElementContribution:
    """Contribution of a rigid mass `mass` [kg] with moment of inertia `inertia` [kg m^2] at a node."""
    return pieces.ElementContribution(
        part, node_mass_kernel, pieces.node_coordinates(part, node), (mass, inertia, *gravity), energy=node_mass_energy,
        damping=undamped, diagonal=True, is_mass=True,
    )  # fmt: skip


@kernels.element_kernel
def mean_mass_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    """Mass at the mean of n points, q = (x1, y1, x2, y2, ...): T = m/2 |mean velocity|^2."""
    m, gx, gy = p
    share_out(m, -gx, -gy, a, r)
    n = q.shape[0] // 2
    for i in range(n):
        for j in range(n):
            M[2 * i, 2 * j], M[2 * i + 1, 2 * j + 1] = m / (n * n), m / (n * n)


@kernels.compiled
def mean(x):
    """Mean of n points."""
    n = x.shape[0] // 2
    a, b = 0.0, 0.0
    for i in range(n):
        a += x[2 * i] / n
        b += x[2 * i + 1] / n
    return a, b


@kernels.compiled
def share_out(m, bx, by, x, r):
    """m (mean of x + b), shared equally by n points."""
    n = x.shape[0] // 2
    cx, cy = mean(x)
    for i in range(n):
        r[2 * i], r[2 * i + 1] = m / n * (cx + bx), m / n * (cy + by)


@kernels.force_kernel
def mean_mass_force(p, t, h, q, v, a, z, r, z_new):
    """Residual r (2 n,) alone."""
    m, gx, gy = p
    share_out(m, -gx, -gy, a, r)


@kernels.compiled
def mean_weight(p, q):
    """Potential energy of gravity of a mass at the mean of n points."""
    x, y = mean(q)
    m, gx, gy = p
    return -m * (gx * x + gy * y)


@kernels.energy_kernel
def mean_mass_energy(p, t, q, v):
    """Potential energy of gravity alone."""
    return 0.0, mean_weight(p, q), 0.0


@kernels.account_kernel
def mean_mass_account(p, t, h, q, v, a, y, z, r, Mv, My, z_new):
    """r, M v, M y (2 n,); energies as `mean_mass_energy` gives them."""
    m, gx, gy = p
    share_out(m, -gx, -gy, a, r)
    share_out(m, 0.0, 0.0, v, Mv)
    share_out(m, 0.0, 0.0, y, My)
    return 0.0, mean_weight(p, q), 0.0


MEAN_MASS = pieces.ElementKernels(
    mean_mass_kernel, mean_mass_energy, mean_mass_force, None, mean_mass_account, undamped
)


def mean_mass(part: str, nodes: Sequence[str], mass: float, gravity: Point) -> pieces.ElementContribution:
    """Contribution of a point mass [kg] held at the mean position of several nodes."""
    coordinates = tuple(c for node in nodes for c in pieces.node_coordinates(part, node)[:2])
    return MEAN_MASS.contribution(part, coordinates, (mass, *gravity))


SAME_POINT = 1e-9  # distance from the particle, over its distance from the origin (at least 1 m), that counts as 0
MANY_PARTS = 500  # number of parts of a mechanism above which compiled kernels are called, a hundred times as fast
NO_MOMENT = 1e-9  # moment on a particle over the largest force [m], or change by its rotation, that counts as round-off


@kernels.constraint_kernel
def held_rotation_kernel(p, t, q, v, lam, g, G, g_t, gamma, H):
    """theta = 0."""
    g[0], G[0, 0] = q[0], 1.0


@record
class PointMass(Body):
    """A particle: a mass at a point, with x and y and without rotation.

    A constraint equation of its own holds its theta at 0, so the equations of motion stay regular, and a particle has
    two degrees of freedom.  Parts may hold, push or tie the point; a part that turns it is refused.

    Raises
    ------
    InputError : a mass that is not > 0, values that are not finite; when a part is attached beside the point.
    ModelError : a part of the mechanism that needs the rotation of the particle: `Fixed`, `Prismatic`, a drive of its
        pin, torques, torsion springs, gears, friction.

    Notes
    -----
    A bead on a wire is a `PinSlot` from the wire to the particle; a rod to the particle is a `Revolute` or a
    `couplings.Distance`.
    """

    at: Point = field("the point", "m", point)
    mass: float = field("mass", "kg", positive)
    velocity: tuple[float, float] | None = field(
        "(vx, vy) at the start; None: as joints and drives impose, with least kinetic energy",
        "m/s", vector, default=None,
    )  # fmt: skip

    def nodes(self) -> tuple[pieces.Node, ...]:
        return (pieces.Node("", *self.at, 0.0),)

    def attach(self, owner: str, point: Point) -> pieces.Attachment:
        apart = planar.distance(self.at, point)
        if apart > SAME_POINT * max(1.0, *map(abs, self.at)):
            text = f"{owner}: the point ({point[0]:g}, {point[1]:g}) lies {apart:g} m beside {self.label},"
            raise InputError(f"{text} which is one point. Give its point, or use a RigidBody.")
        return pieces.Attachment(self.name, "", (0.0, 0.0))

    def start_velocity(self) -> tuple[float, float, float] | None:
        return None if self.velocity is None else (*self.velocity, 0.0)

    def contributions(self, mechanism: Mechanism) -> Sequence[pieces.Contribution]:
        """The mass, and the constraint equation of the rotation that does not exist."""
        theta = pieces.node_coordinates(self.name, "")[2:]
        held = pieces.ConstraintContribution(self.name, held_rotation_kernel, theta, (), 1, is_drive=True)
        # any moment of inertia will do
        return [node_mass(self.name, "", self.mass, self.mass, mechanism.gravity), held]

    def validate(self, mechanism: Mechanism) -> None:
        """Refuse parts that need the rotation of the particle."""
        for part, contribution, place in mechanism.acting_on((self.name, "", 2)):
            if turns(mechanism, contribution, place):
                text = f"{part.label} needs the rotation of {self.label}, which has none."
                text += " Use a RigidBody, or a part that holds the point alone: Revolute without drive and friction,"
                raise ModelError(f"{text} PinSlot from another body, couplings.Distance, SpringDamper, Force.")

    def shapes(self, mechanism: Mechanism) -> Shapes:  # noqa: ARG002 - the point alone
        return (RigidShape(self.name, "", (((0.0, 0.0), (0.0, 0.0)),)),)


def turns(mechanism: Mechanism, contribution: Any, place: int) -> bool:
    """Whether a contribution acts on its coordinate with the number `place` in the reference configuration."""
    nodes = {key: mechanism.body(key[0]).node(key[1]) for key in {c[:2] for c in contribution.coordinates}}
    poses = {name: (node.x, node.y, node.theta) for name, node in nodes.items()}
    q = np.array([poses[part, name][axis] for part, name, axis in contribution.coordinates])
    p, n = np.array(contribution.p, dtype=float), len(q)
    if isinstance(contribution, pieces.ConstraintContribution):
        m = contribution.rows
        G, H = np.zeros((m, n)), np.zeros((n, n))
        contribution.kernel(p, 0.0, q, np.zeros(n), np.ones(m), np.zeros(m), G, np.zeros(m), np.zeros(m), H)
        return contribution.joint_friction is not None or _any(G[:, place], G) or _any(H[:, place], G, H)
    if isinstance(contribution, pieces.ElementContribution):
        z, r, A = np.array(contribution.history, dtype=float), np.zeros(n), np.zeros((3, n, n))
        kernel = contribution.kernel.dispatcher if len(mechanism.parts) > MANY_PARTS else contribution.kernel
        kernel(p, 0.0, 0.0, q, np.zeros(n), np.zeros(n), z, r, A[0], A[1], A[2], z.copy())
        if not (r[place] or A[:, place].any() or A[:, :, place].any()):
            return False
        return _any(r[place : place + 1], r) or any(_any([*B[:, place], *B[place]], B) for B in A)
    # Whether normal or friction force of a contact has a moment about a node
    out, z = np.zeros(kernels.GAP_SIZE), np.array(contribution.friction.history(), dtype=float)
    contribution.gap(p, q, np.zeros(6), out)
    friction = np.array(contribution.friction.parameters(), dtype=float)
    force = contribution.friction.kernel(friction, 1e-3, 1.0, 1.0, z, z.copy())[0]
    ax, ay = (out[ARM1_X], out[ARM1_Y]) if place == 2 else (out[ARM2_X], out[ARM2_Y])
    return bool(force != 0.0 or abs(ax * out[NORMAL_Y] - ay * out[NORMAL_X]) > NO_MOMENT * math.hypot(ax, ay))


def _any(values: Any, *others: np.ndarray) -> bool:
    """Whether one of some values is more than round-off of others."""
    size = max(float(np.abs(other).max(initial=0.0)) for other in others)
    return bool(np.abs(np.array(values)).max(initial=0.0) > NO_MOMENT * size)


def checked_velocity(label: str, name: str, velocity: Any, *_: str) -> tuple[float, float, float]:
    """A start velocity (vx, vy, omega) as floats, or `InputError`."""
    try:
        vx, vy, omega = velocity
    except (TypeError, ValueError):
        raise InputError(f"{label}: velocity is {velocity!r}; it must be (vx, vy, omega).") from None
    parts = (vx, "m/s"), (vy, "m/s"), (omega, "rad/s")
    x, y, turn = (checks.number(label, f"velocity[{k}]", value, unit) for k, (value, unit) in enumerate(parts))
    return x, y, turn


@record
class Bar(Body):
    """Base of bodies between two points of the reference configuration."""

    formerly = (("at", "start", "0.3"), ("to", "end", "0.3"))
    start: Point = field("one end", "m", point)
    end: Point = field("the other end", "m", point)

    def __post_init__(self) -> None:
        super().__post_init__()
        if planar.distance(self.start, self.end) <= 0.0:
            raise InputError(f"{self.label}: start and end are both {self.start}; a link must have a length > 0 m.")

    @property
    def bar_ends(self) -> tuple[Point, ...]:
        return self.start, self.end

    @property
    def length(self) -> float:
        """Distance of the ends in the reference configuration [m]."""
        return planar.distance(self.start, self.end)

    @property
    def angle(self) -> float:
        """Direction of the axis in the reference configuration [rad]."""
        return math.atan2(self.end[1] - self.start[1], self.end[0] - self.start[0])


@record
class RigidBody(Body):
    """A rigid body with its node at the centre of mass.

    Raises
    ------
    InputError : mass or inertia not > 0, values that are not finite.
    """

    formerly = (("angle", "theta", "0.3"),)
    at: Point = field("centre of mass", "m", point)
    mass: float = field("mass", "kg", positive)
    inertia: float = field("moment of inertia about the centre of mass", "kg m^2", positive)
    theta: float = field("rotation in the reference configuration", "rad", default=0.0)
    velocity: tuple[float, float, float] | None = field(
        "(vx, vy, omega) at the start; None: as the drives impose, with least kinetic energy",
        rule=Rule(checked_velocity), default=None,
    )  # fmt: skip
    outline: Sequence[Point] = field(
        "polyline in pictures, or lines to joints", "m", several(point, "points"), default=()
    )

    def nodes(self) -> tuple[pieces.Node, ...]:
        return (pieces.Node("", *self.at, self.theta),)

    def attach(self, owner: str, point: Point) -> pieces.Attachment:  # noqa: ARG002 - any point of the plane will do
        return pieces.Attachment(self.name, "", planar.to_frame(self.at, self.theta, point))

    def contributions(self, mechanism: Mechanism) -> Sequence[pieces.Contribution]:
        return [node_mass(self.name, "", self.mass, self.inertia, mechanism.gravity)]

    def shapes(self, mechanism: Mechanism) -> Shapes:
        """The outline, or a star from the centre of mass to the joints."""
        if self.outline:
            outline = tuple(planar.to_frame(self.at, self.theta, p) for p in self.outline)
            lines: tuple[tuple[Point, ...], ...] = (outline,)
        else:
            joints = (p for p in mechanism.parts if isinstance(p, Joint) and self.name in p.references())
            held = [end.offset for joint in joints for end in joint.ends(mechanism) if end.part == self.name]
            lines = tuple(((0.0, 0.0), p) for p in held if p != (0.0, 0.0)) or (((0.0, 0.0), (0.0, 0.0)),)
        return (RigidShape(self.name, "", lines),)


MASSLESS = 1e-8  # mass of a massless link over the smallest mass of the other bodies [1]
AXIS_TOLERANCE = 1e-3  # distance from the axis over the length [1] up to which a point counts as one of the axis
GYRATIONS = (0.02, 3.0)  # radius of gyration over the length of a link, least and largest, that goes without a finding
BEYOND_END = 1.0  # distance of a joint from the nearer end of its link, over the length, up to which it is not odd


@record
class RigidLink(Bar):
    """A rigid bar; theta is the direction from `start` to `end`, counted from +X.

    Raises
    ------
    InputError : start equals end, mass or inertia not > 0, centre outside [0, 1]; when a joint is off the axis.
    ModelError : when a run starts, a massless link that can move without moving a mass.

    Notes
    -----
    A massless link has MASSLESS times the smallest mass of the other bodies, so that equations of motion stay regular.
    """

    mass: float = field("mass, > 0; 0 with inertia 0 for a massless link", "kg")
    inertia: float = field("moment of inertia about the centre of mass, > 0; 0 for a massless link", "kg m^2")
    centre: float = field("of mass, from start (0) to end (1)", rule=between(0.0, 1.0), default=0.5)
    velocity: tuple[float, float, float] | None = field(
        "(vx, vy, omega) of the centre of mass at the start; None: as the drives impose",
        rule=Rule(checked_velocity), default=None,
    )  # fmt: skip

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.is_massless:
            checks.positive(self.label, "mass", self.mass, "kg")
            checks.positive(self.label, "inertia", self.inertia, "kg m^2")

    @property
    def is_massless(self) -> bool:
        return self.mass == 0.0 and self.inertia == 0.0

    def nodes(self) -> tuple[pieces.Node, ...]:
        x, y = planar.from_frame(self.start, self.angle, (self.centre * self.length, 0.0))
        return (pieces.Node("", x, y, self.angle),)

    def attach(self, owner: str, point: Point) -> pieces.Attachment:
        """A point of the axis (also beyond the ends)."""
        node = self.nodes()[0]
        along, across = planar.to_frame((node.x, node.y), self.angle, point)
        if abs(across) > AXIS_TOLERANCE * self.length:
            text = f"{owner}: the point ({point[0]:g}, {point[1]:g})"
            text += f" lies {abs(across):g} m off the axis of {self.label}."
            raise InputError(f"{text} Move the point onto the axis, or use RigidBody for a body with joints anywhere.")
        return pieces.Attachment(self.name, "", (along, across))

    def contributions(self, mechanism: Mechanism) -> Sequence[pieces.Contribution]:
        mass, inertia = self.mass, self.inertia
        if self.is_massless:
            mass = MASSLESS * min((body.total_mass() for body in mechanism.bodies if not body.is_massless), default=1.0)
            inertia = mass * self.length * self.length / 12.0
        return [node_mass(self.name, "", mass, inertia, mechanism.gravity)]

    def findings_before(self, mechanism: Mechanism) -> Iterator[Finding]:
        """Findings on an odd radius of gyration, and on joints far beyond the ends."""
        radius = 0.0 if self.is_massless else math.sqrt(self.inertia / self.mass)
        if not self.is_massless and not GYRATIONS[0] <= radius / self.length <= GYRATIONS[1]:
            text = f"{self.label} has a radius of gyration of {radius:.4g} m and a length of"
            text += f" {self.length:.4g} m (mass {self.mass:.4g} kg, inertia {self.inertia:.4g} kg m^2)."
            slender = self.mass * self.length * self.length / 12.0
            remedy = f"A slender bar of this mass has an inertia of {slender:.4g} kg m^2."
            yield found("odd-units", (self.name,), text, remedy, radius=radius, length=self.length)
        for joint in mechanism.parts:
            if isinstance(joint, Joint) and self.name in joint.references() and joint.at is not None:
                along = planar.to_frame(self.start, self.angle, joint.at)[0]
                beyond = max(-along, along - self.length)
                if beyond > BEYOND_END * self.length:
                    text = f"The joint {joint.name!r} lies {beyond:.4g} m beyond the end of {self.label}"
                    text += f" ({self.length:.4g} m long)."
                    parts = (joint.name, self.name)
                    yield found("far-joint", parts, text, "Check the points of both.", distance=beyond)

    def shapes(self, mechanism: Mechanism) -> Shapes:  # noqa: ARG002 - the bar alone
        before, after = self.centre * self.length, (1.0 - self.centre) * self.length
        return (RigidShape(self.name, "", (((-before, 0.0), (after, 0.0)),)),)
