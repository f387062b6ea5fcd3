"""Particles, and the inertia of nodes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from flexmb import planar
from flexmb.errors import InputError, ModelError
from flexmb.fields import field, point, positive, record, vector
from flexmb.kernels import (
    GAP_SIZE,
    account_kernel,
    compiled,
    constraint_kernel,
    damping_kernel,
    element_kernel,
    energy_kernel,
    force_kernel,
    tangent_kernel,
)
from flexmb.model.contributions import (
    Attachment,
    ConstraintContribution,
    ContactContribution,
    Contribution,
    ElementContribution,
    Node,
    node_coordinates,
)
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import Body
from flexmb.model.shape import Point, RigidShape, Shapes
from flexmb.places import ARM1_X, ARM1_Y, ARM2_X, ARM2_Y, NORMAL_X, NORMAL_Y, packed

# Mass and moment of inertia of a node, and of a point between nodes: kernels and pieces

MASS, INERTIA, GRAVITY_X, GRAVITY_Y = range(4)  # parameters p of the mass of a node


@element_kernel
def node_mass_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    """Rigid body at its centre of mass (x, y, theta): r = m (a - g), J alpha."""
    node_force(p, a, r)
    M[0, 0] = p[MASS]
    M[1, 1] = p[MASS]
    M[2, 2] = p[INERTIA]


@compiled
def node_force(p, a, r):
    """r (3,) of a rigid body."""
    m, J, gx, gy = p
    r[0] = m * (a[0] - gx)
    r[1] = m * (a[1] - gy)
    r[2] = J * a[2]


@force_kernel
def node_mass_force(p, t, h, q, v, a, z, r, z_new):
    """Residual r (3,) alone."""
    node_force(p, a, r)


@tangent_kernel
def node_mass_tangent(p, t, h, q, v, a, z, kq, kv, ka, r, A, z_new):
    """r (3,) and ka M, a diagonal."""
    node_force(p, a, r)
    A[0, 0] = ka * p[MASS]
    A[1, 1] = ka * p[MASS]
    A[2, 2] = ka * p[INERTIA]


@compiled
def node_weight(p, q):
    """Potential energy of gravity of a rigid body."""
    return -p[MASS] * (p[GRAVITY_X] * q[0] + p[GRAVITY_Y] * q[1])


@energy_kernel
def node_mass_energy(p, t, q, v):
    """Potential energy of gravity alone."""
    return 0.0, node_weight(p, q), 0.0


@damping_kernel
def undamped(p, t, q, v, w):
    """No power."""
    return 0.0, 0.0


@account_kernel
def node_mass_account(p, t, h, q, v, a, y, z, r, Mv, My, z_new):
    """r, M v, M y (3,); energies as `node_mass_energy` gives them."""
    node_force(p, a, r)
    for x, Mx in ((v, Mv), (y, My)):
        Mx[0] = p[MASS] * x[0]
        Mx[1] = p[MASS] * x[1]
        Mx[2] = p[INERTIA] * x[2]
    return 0.0, node_weight(p, q), 0.0


def node_mass(part: str, node: str, mass: float, inertia: float, gravity: Point) -> ElementContribution:
    """Contribution of a rigid mass `mass` [kg] with moment of inertia `inertia` [kg m^2] at a node."""
    gx, gy = gravity
    p = packed({MASS: mass, INERTIA: inertia, GRAVITY_X: gx, GRAVITY_Y: gy})
    dofs = node_coordinates(part, node)
    return ElementContribution(
        part,
        node_mass_kernel,
        dofs,
        p,
        energy=node_mass_energy,
        force=node_mass_force,
        tangent=node_mass_tangent,
        account=node_mass_account,
        damping=undamped,
        diagonal=True,
    )


@element_kernel
def mean_mass_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    """Mass at the mean of n points, q = (x1, y1, x2, y2, ...): T = m/2 |mean velocity|^2."""
    m, gx, gy = p
    share_out(m, -gx, -gy, a, r)
    n = q.shape[0] // 2
    for i in range(n):
        for j in range(n):
            M[2 * i, 2 * j] = m / (n * n)
            M[2 * i + 1, 2 * j + 1] = m / (n * n)


@compiled
def mean(x):
    """Mean of n points."""
    n = x.shape[0] // 2
    a, b = 0.0, 0.0
    for i in range(n):
        a += x[2 * i] / n
        b += x[2 * i + 1] / n
    return a, b


@compiled
def share_out(m, bx, by, x, r):
    """m (mean of x + b), shared equally by n points."""
    n = x.shape[0] // 2
    cx, cy = mean(x)
    for i in range(n):
        r[2 * i] = m / n * (cx + bx)
        r[2 * i + 1] = m / n * (cy + by)


@force_kernel
def mean_mass_force(p, t, h, q, v, a, z, r, z_new):
    """Residual r (2 n,) alone."""
    m, gx, gy = p
    share_out(m, -gx, -gy, a, r)


@compiled
def mean_weight(p, q):
    """Potential energy of gravity of a mass at the mean of n points."""
    x, y = mean(q)
    m, gx, gy = p
    return -m * (gx * x + gy * y)


@energy_kernel
def mean_mass_energy(p, t, q, v):
    """Potential energy of gravity alone."""
    return 0.0, mean_weight(p, q), 0.0


@account_kernel
def mean_mass_account(p, t, h, q, v, a, y, z, r, Mv, My, z_new):
    """r, M v, M y (2 n,); energies as `mean_mass_energy` gives them."""
    m, gx, gy = p
    share_out(m, -gx, -gy, a, r)
    share_out(m, 0.0, 0.0, v, Mv)
    share_out(m, 0.0, 0.0, y, My)
    return 0.0, mean_weight(p, q), 0.0


def mean_mass(part: str, nodes: Sequence[str], mass: float, gravity: Point) -> ElementContribution:
    """Contribution of a point mass [kg] held at the mean position of several nodes."""
    coordinates = tuple(c for node in nodes for c in node_coordinates(part, node)[:2])
    return ElementContribution(
        part,
        mean_mass_kernel,
        coordinates,
        (mass, *gravity),
        energy=mean_mass_energy,
        force=mean_mass_force,
        account=mean_mass_account,
        damping=undamped,
    )


SAME_POINT = 1e-9  # distance from the particle, over its distance from the origin (at least 1 m), that counts as 0
MANY_PARTS = 500  # number of parts of a mechanism above which compiled kernels are called, a hundred times as fast
NO_MOMENT = 1e-9  # moment on a particle over the largest force [m], or change by its rotation, that counts as round-off


@constraint_kernel
def held_rotation_kernel(p, t, q, v, lam, g, G, g_t, gamma, H):
    """theta = 0."""
    g[0] = q[0]
    G[0, 0] = 1.0


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
        "m/s",
        vector,
        default=None,
    )

    def nodes(self) -> tuple[Node, ...]:
        """The node at the point."""
        return (Node("", *self.at, 0.0),)

    def attach(self, owner: str, point: Point) -> Attachment:
        """The point itself."""
        apart = planar.distance(self.at, point)
        if apart > SAME_POINT * max(1.0, *map(abs, self.at)):
            text = f"{owner}: the point ({point[0]:g}, {point[1]:g}) lies {apart:g} m beside {self.label},"
            raise InputError(f"{text} which is one point. Give its point, or use a RigidBody.")
        return Attachment(self.name, "", (0.0, 0.0))

    def start_velocity(self) -> tuple[float, float, float] | None:
        """The declared start velocity, without rotation."""
        return None if self.velocity is None else (*self.velocity, 0.0)

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        """The mass, and the constraint equation of the rotation that does not exist."""
        theta = node_coordinates(self.name, "")[2:]
        held = ConstraintContribution(self.name, held_rotation_kernel, theta, (), 1, is_drive=True)
        # any moment of inertia will do
        return [node_mass(self.name, "", self.mass, self.mass, mechanism.gravity), held]

    def total_mass(self) -> float:
        """The mass [kg]."""
        return self.mass

    def validate(self, mechanism: Mechanism) -> None:
        """Refuse parts that need the rotation of the particle."""
        for part, contribution, place in mechanism.acting_on((self.name, "", 2)):
            if turns(mechanism, contribution, place):
                text = f"{part.label} needs the rotation of {self.label}, which has none."
                text += " Use a RigidBody, or a part that holds the point alone: Revolute without drive and friction,"
                raise ModelError(f"{text} PinSlot from another body, couplings.Distance, SpringDamper, Force.")

    def shapes(self, mechanism: Mechanism) -> Shapes:  # noqa: ARG002 - the point alone
        """The point."""
        return (RigidShape(self.name, "", (((0.0, 0.0), (0.0, 0.0)),)),)


def turns(mechanism: Mechanism, contribution: Any, place: int) -> bool:
    """Whether a contribution acts on its coordinate with the number `place` in the reference configuration."""
    q, p = _pose_of(mechanism, contribution), np.array(contribution.p, dtype=float)
    n = len(q)
    if isinstance(contribution, ConstraintContribution):
        m = contribution.rows
        G, H = np.zeros((m, n)), np.zeros((n, n))
        contribution.kernel(p, 0.0, q, np.zeros(n), np.ones(m), np.zeros(m), G, np.zeros(m), np.zeros(m), H)
        return contribution.joint_friction is not None or _any(G[:, place], G) or _any(H[:, place], G, H)
    if isinstance(contribution, ElementContribution):
        z, r, A = np.array(contribution.history, dtype=float), np.zeros(n), np.zeros((3, n, n))
        kernel = contribution.kernel.dispatcher if len(mechanism.parts) > MANY_PARTS else contribution.kernel
        kernel(p, 0.0, 0.0, q, np.zeros(n), np.zeros(n), z, r, A[0], A[1], A[2], z.copy())
        if not (r[place] or A[:, place].any() or A[:, :, place].any()):
            return False
        return _any(r[place : place + 1], r) or any(_any([*B[:, place], *B[place]], B) for B in A)
    return _has_moment(contribution, p, q, place)


def _pose_of(mechanism: Mechanism, contribution: Any) -> np.ndarray:
    """Coordinates (n,) of a contribution in the reference configuration."""
    found: dict[tuple[str, str], tuple[float, float, float]] = {}
    q = []
    for part, name, axis in contribution.coordinates:
        pose = found.get((part, name))
        if pose is None:
            node = mechanism.body(part).node(name)
            pose = found[part, name] = node.x, node.y, node.theta
        q.append(pose[axis])
    return np.array(q)


def _has_moment(contact: ContactContribution, p: np.ndarray, q: np.ndarray, place: int) -> bool:
    """Whether normal or friction force of a contact has a moment about a node."""
    out, z = np.zeros(GAP_SIZE), np.array(contact.friction.history(), dtype=float)
    contact.gap(p, q, np.zeros(6), out)
    friction = np.array(contact.friction.parameters(), dtype=float)
    force = contact.friction.kernel(friction, 1e-3, 1.0, 1.0, z, z.copy())[0]
    ax, ay = (out[ARM1_X], out[ARM1_Y]) if place == 2 else (out[ARM2_X], out[ARM2_Y])
    moment = ax * out[NORMAL_Y] - ay * out[NORMAL_X]
    return bool(force != 0.0 or abs(moment) > NO_MOMENT * math.hypot(ax, ay))


def _any(values: Any, *others: np.ndarray) -> bool:
    """Whether one of some values is more than round-off of others."""
    size = max(float(np.abs(other).max(initial=0.0)) for other in others)
    return bool(np.abs(np.array(values)).max(initial=0.0) > NO_MOMENT * size)
