"""Particle: a mass without rotation."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from flexmb import checks, planar
from flexmb.bodies.inertia import node_mass
from flexmb.errors import InputError, ModelError
from flexmb.kernels import GAP_SIZE, constraint_kernel
from flexmb.model.contributions import (
    Attachment,
    ConstraintContribution,
    ContactContribution,
    Contribution,
    ElementContribution,
    Node,
    node_coordinates,
)
from flexmb.model.part import Body
from flexmb.model.shape import Point, RigidShape, Shapes
from flexmb.places import ARM1_X, ARM1_Y, ARM2_X, ARM2_Y, NORMAL_X, NORMAL_Y

if TYPE_CHECKING:
    from flexmb.model.mechanism import Mechanism

SAME_POINT = 1e-9
"""Distance from the particle, relative to its distance from the origin (1 m at least), that counts as 0."""

MANY_PARTS = 500
"""Number of parts of a mechanism above which compiled kernels are called, which are a hundred times as fast."""

NO_MOMENT = 1e-9
"""Moment on a particle over the largest force [m], or change by its rotation, that counts as round-off."""


@constraint_kernel
def held_rotation_kernel(p, t, q, v, lam, g, G, g_t, gamma, H):
    """theta = 0."""
    g[0] = q[0]
    G[0, 0] = 1.0


@dataclass(frozen=True)
class PointMass(Body):
    """A particle: a mass at a point, with x and y and without rotation.

    A constraint equation of its own holds its theta at 0, so the equations of motion stay regular, and a particle has
    two degrees of freedom.  Parts may hold, push or tie the point; a part that turns it is refused.

    Parameters
    ----------
    name : the particle's name.
    at : the point in the reference configuration [m].
    mass : mass [kg], > 0.
    velocity : (vx, vy) at the start [m/s]; None: as joints and drives impose, with least kinetic energy.

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

    at: Point
    mass: float
    velocity: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "at", checks.point(self.label, "at", self.at))
        checks.positive(self.label, "mass", self.mass, "kg")
        if self.velocity is not None:
            object.__setattr__(self, "velocity", checks.point(self.label, "velocity", self.velocity, "m/s"))

    def nodes(self) -> tuple[Node, ...]:
        """The node at the point."""
        return (Node("", *self.at, 0.0),)

    def attach(self, owner: str, point: Point) -> Attachment:
        """The point itself."""
        apart = planar.distance(self.at, point)
        if apart > SAME_POINT * max(1.0, *map(abs, self.at)):
            raise InputError(
                f"{owner}: the point ({point[0]:g}, {point[1]:g}) lies {apart:g} m beside {self.label}, which is one "
                "point. Give its point, or use a RigidBody."
            )
        return Attachment(self.name, "", (0.0, 0.0))

    def start_velocity(self) -> tuple[float, float, float] | None:
        """The declared start velocity, without rotation."""
        return None if self.velocity is None else (*self.velocity, 0.0)

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        """The mass, and the constraint equation of the rotation that does not exist."""
        theta = node_coordinates(self.name, "")[2:]
        held = ConstraintContribution(self.name, held_rotation_kernel, theta, (), 1, is_drive=True)
        return [
            node_mass(self.name, "", self.mass, self.mass, mechanism.gravity),
            held,
        ]  # any moment of inertia will do

    def total_mass(self) -> float:
        """The mass [kg]."""
        return self.mass

    def validate(self, mechanism: Mechanism) -> None:
        """Refuse parts that need the rotation of the particle."""
        for part, contribution, place in mechanism.acting_on((self.name, "", 2)):
            if turns(mechanism, contribution, place):
                raise ModelError(
                    f"{part.label} needs the rotation of {self.label}, which has none. Use a RigidBody, or a part that "
                    "holds the point alone: Revolute without drive and friction, PinSlot from another body, "
                    "couplings.Distance, SpringDamper, Force."
                )

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
