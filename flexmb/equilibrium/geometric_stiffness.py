"""Geometric stiffness along a motion: the slope of the stiffness, less that by turning and bowing of elements.

A pencil K0 + s K1 is linear in s, but an element that turns by s phi has the stiffness R K R^T.  Its first term,
phi (S K - K S), couples stretching with bending; without the terms of s^2, which take its effect back, it makes a
cantilever under a force across it buckle.  Classical linear buckling, which counts stresses alone, has no such terms.
Bowing of beam elements and shortening of reduced bodies have the like: with deformations e(q), K = A^T D A of
A = de/dq has the slope A'^T D A + A^T D A', to which no stress belongs.
Equation (8.4) of docs/theory/equilibrium.md.
"""

from __future__ import annotations

import math

import numpy as np
import scipy.sparse as sp

from flexmb.beams.chord import AXIAL, B11, B12, B22, BOW11, BOW12, BOW22, LENGTH, OFFSET1, OFFSET2, PARAMETERS
from flexmb.bodies.flexible_body import FlexibleBody
from flexmb.equilibrium.carrying import contact_stiffness
from flexmb.model.mechanism import Mechanism
from flexmb.program.compiler import compile as compile_mechanism
from flexmb.program.program import Program
from flexmb.reduction.craig_bampton import frame_weights
from flexmb.reduction.reduced import Reduced
from flexmb.reduction.superelement import Superelement
from flexmb.system.state_evaluation import StateEvaluation
from flexmb.system.turns import COORDINATES, add_turns

FLAT = 1e-9
"""Determinant of the second moments of points over the square of their trace, up to which they lie on a line."""

ENDS = ((2, OFFSET1), (5, OFFSET2))
"""Places of the rotations of a beam element among its coordinates, and of their offsets among its parameters."""

PATH_STRIDE = 1e-3
"""Difference along the prestress path between two evaluations of K, relative to the size of the mechanism."""


def geometric_stiffness(
    mechanism: Mechanism, system: StateEvaluation, q: np.ndarray, lam: np.ndarray, path: np.ndarray
) -> sp.csc_matrix:
    """Stiffness (n_q, n_q) by the stresses and multipliers that grow along a path, at the rate of its parameter s.

    `q` (n_q,) and `lam` (n_c,) belong to s = 0, `path` (n_q + n_c,) are rates of coordinates and multipliers.  A
    contact that carries at s = 0 adds the stiffness of its growing force alone.
    """
    by_contacts = contact_stiffness(system.at(q, lam=lam, weights=(1.0, 0.0, 0.0)), path[: system.program.n_q])
    if len(system.program.names.contacts):
        system = StateEvaluation(compile_mechanism(mechanism, closed=True))
    program = system.program
    u, rate = path[: program.n_q], path[program.n_q :]
    sizes = np.where(program.tables.kind == 1, program.length, 1.0)
    size = np.abs(u * sizes).max()
    h = PATH_STRIDE * program.length / size if size else 1.0  # rigid bodies do not move: K is linear in the multipliers

    def stiffness(k: int) -> sp.csc_matrix:
        return system.at(q + k * h * u, lam=lam + k * h * rate, weights=(1.0, 0.0, 0.0)).block()

    slope = 8.0 * (stiffness(1) - stiffness(-1)) - (stiffness(2) - stiffness(-2))
    slope = slope / (12.0 * h) + by_contacts
    if not size:
        return slope.tocsc()
    turned = _turns(mechanism, system, q, u, h) + _bowed(mechanism, program, q, u)
    bodies = [body for body in mechanism.bodies if isinstance(body, Reduced)]
    return sum((_bent(body, program, q, u, h) for body in bodies), slope - turned).tocsc()


def _turns(mechanism: Mechanism, system: StateEvaluation, q: np.ndarray, u: np.ndarray, stride: float) -> sp.csc_matrix:
    """Sum of phi (S K - K S) over all elements except reduced bodies."""
    program, work = system.program, system.work
    behind, here, ahead, still, size = (np.zeros(program.n_q + COORDINATES) for _ in range(5))
    own = slice(0, program.n_q)
    behind[own], here[own], ahead[own] = q - stride * u, q, q + stride * u
    size[:] = 1.0
    size[own] = np.where(program.tables.kind == 1, program.length, 1.0)
    reduced = {body.name for body in mechanism.bodies if isinstance(body, Reduced)}
    bodies, E = {body.name for body in mechanism.bodies}, program.tables.elements
    given = np.full(len(E.p), np.nan)
    for e, part in enumerate(program.names.elements):
        if part in bodies:
            dofs = E.dofs[E.dof[e] : E.dof[e + 1]]
            x = dofs[dofs % COORDINATES == 0]
            given[e] = 0.0 if part in reduced else _mean_turn(q[x], q[x + 1], u[x], u[x + 1])
    room, spare, z = np.zeros(len(work.Kl)), np.zeros(len(work.Kl)), np.array(program.reference.z)
    add_turns(program.tables, program.addresses, behind, here, ahead, still, stride, z, size, given, room, spare, work)
    return system.block()


def _mean_turn(x: np.ndarray, y: np.ndarray, ux: np.ndarray, uy: np.ndarray) -> float:
    """Rotation of points by their displacements: of the best affine motion, or of the line that they lie on."""
    place, moved = (np.column_stack(pair) - np.mean(pair, axis=1) for pair in ((x, y), (ux, uy)))
    square = place.T @ place
    if np.linalg.det(square) > FLAT * np.trace(square) ** 2:
        gradient = np.linalg.solve(square, place.T @ moved)
        return float(0.5 * (gradient[0, 1] - gradient[1, 0]))
    size = np.trace(square)
    return float((place[:, 0] @ moved[:, 1] - place[:, 1] @ moved[:, 0]) / size) if size > 0.0 else 0.0


def _bowed(mechanism: Mechanism, program: Program, q: np.ndarray, u: np.ndarray) -> sp.csc_matrix:
    """B'^T D B + B^T D B' of all beam elements but for turning: B, their deformations (e, u1, u2) by the coordinates.

    The slope of e is that by bowing; the slope of u1 and u2, that of the turn of the chord, dy/l, by its shortening.
    """
    E = program.tables.elements
    beams = {body.name for body in mechanism.bodies if isinstance(body, FlexibleBody)}
    own = [e for e, part in enumerate(program.names.elements) if part in beams and np.diff(E.p[e]) == PARAMETERS]
    if not own:
        return sp.csc_matrix((program.n_q, program.n_q))
    p = np.array([program.tables.p[slice(*E.p[e])] for e in own]).T
    dofs = np.array([E.dofs[E.dof[e] : E.dof[e + 1]] for e in own])
    place, moved = q[dofs], u[dofs]
    dx, dy = place[:, 3] - place[:, 0], place[:, 4] - place[:, 1]
    length, none = np.hypot(dx, dy), np.zeros(len(own))
    c, s = dx / length, dy / length
    along, turn = np.stack([-c, -s, none, c, s, none], 1), np.stack([s, -c, none, -s, c, none], 1) / length[:, None]
    first, second = np.eye(6)[2] - turn, np.eye(6)[5] - turn
    alpha = np.arctan2(dy, dx)
    bent = [np.remainder(place[:, k] - alpha + p[offset] + np.pi, 2.0 * np.pi) - np.pi for k, offset in ENDS]

    def by_bowing(x1: np.ndarray, x2: np.ndarray) -> np.ndarray:
        g1 = p[LENGTH] / 30.0 * (2.0 * p[BOW11] * x1 - p[BOW12] * x2)
        g2 = p[LENGTH] / 30.0 * (2.0 * p[BOW22] * x2 - p[BOW12] * x1)
        return np.asarray(g1[:, None] * first + g2[:, None] * second)

    shorter = ((along * moved).sum(axis=1) / length)[:, None] * turn
    moments = (p[B11] + p[B12])[:, None] * first + (p[B12] + p[B22])[:, None] * second
    along = along + by_bowing(*bent)
    slope = p[AXIAL][:, None] * by_bowing((first * moved).sum(axis=1), (second * moved).sum(axis=1))
    blocks = slope[:, :, None] * along[:, None, :] + shorter[:, :, None] * moments[:, None, :]
    blocks += blocks.transpose(0, 2, 1)
    rows, columns = np.repeat(dofs, 6, axis=1), np.tile(dofs, (1, 6))
    return sp.csc_matrix((blocks.ravel(), (rows.ravel(), columns.ravel())), shape=(program.n_q, program.n_q))


def _bent(body: Reduced, program: Program, q: np.ndarray, u: np.ndarray, stride: float) -> sp.csc_matrix:
    """-(A'^T K A + A^T K A') of a reduced body (n_q, n_q): A, its deformations by its coordinates, and the slope A'."""
    nodes, K = body.element.nodes, body.element.matrices["K"]
    first = program.names.coordinates.index(f"{body.name}.{nodes[0].name}.x")
    own = slice(first, first + COORDINATES * len(nodes))
    ahead, behind = (_deformations(body.element, q[own] + h * u[own]) for h in (stride, -stride))
    half = _deformations(body.element, q[own]).T @ K @ (ahead - behind) / (2.0 * stride)
    found = sp.lil_matrix((program.n_q, program.n_q))
    found[own, own] = -(half + half.T)
    return found.tocsc()


def _deformations(element: Superelement, q: np.ndarray) -> np.ndarray:
    """A (n, n): changes of the deformation with its shortening, d + c(d), by the coordinates q (n,)."""
    nodes, pins, n = element.nodes, element.pins, len(q)
    place = q.reshape(-1, COORDINATES)
    drawn = np.array([(node.x, node.y, node.theta) for node in nodes])
    gradient = np.zeros(n)
    if element.by_pin:
        angle, gradient[COORDINATES - 1] = float(place[0, 2] - drawn[0, 2]), 1.0
    else:
        weights = frame_weights(nodes[:pins])
        whole = complex((weights @ (1.0, -1.0j)) @ (place[:pins, :2] @ (1.0, 1.0j)))
        turns = (weights @ (1.0, -1.0j)) / whole
        angle = float(np.angle(whole))
        gradient.reshape(-1, COORDINATES)[:pins, :2] = np.column_stack([turns.imag, turns.real])
    c, s = math.cos(angle), math.sin(angle)
    T = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    seen = place @ T.T
    u = np.column_stack([-seen[:, 1], seen[:, 0], np.ones(len(seen))]).ravel()
    rates = np.kron(np.eye(len(nodes)), T) - np.outer(u, gradient)
    d = seen - drawn - (0.0, 0.0, angle)
    d[:, :2] -= d[0, :2]
    found = rates.copy()
    for along in element.directions:
        found += np.outer(along[0], (along[1:] @ d.ravel()) @ rates)
    return found
