"""Matrices of a reduced body (mass, stiffness, geometric stiffness K_G: `_reduced_stiffness`), loads on its mesh.

In the axes of the frame the forces on the points of the body are c0 f + c1 J f, plus A d for a load that follows edges;
N = c0 N0 + c1 N1 is the geometric stiffness of their stress with all pins held.
Equations (12.22) to (12.24) of docs/theory/reduced.md.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import scipy.linalg as la

from flexmb import checks
from flexmb.elastic.planes.loads import POWER, SIGNALS, NodalLoad
from flexmb.elastic.planes.plane_body import MeshBody
from flexmb.elastic.reduced import kernel
from flexmb.elastic.reduced.bases import Basis, frame_weights, require_room, rigid_motions
from flexmb.engine.compiled.arrays import block_of, part_of, row_of, stack_matrix
from flexmb.errors import InputError
from flexmb.kernels import element_kernel, fast, signal_kernel
from flexmb.model.contributions import MULTIPLIES, Contribution, ElementContribution, Node, signal_contributions
from flexmb.model.law import Motion
from flexmb.parts.loads.mesh_loads import MeshLoad
from flexmb.planar import Array

if TYPE_CHECKING:
    from flexmb.elastic.reduced.reduced import Reduced

# Kind of a load, angle of its axes, whether it has a geometric stiffness, in place of other parameters of the body.
KIND, ANGLE, STIFFENS = 3, 4, 5
DEAD, FOLLOWER, EDGES = 0.0, 1.0, 2.0  # kinds of loads
# Vectors (n) behind poses and weights of the frame: Psi' f, Psi' J f, Phi' f, Phi' J f; their number.
# Matrices (n, n) follow: N0 and N1 if the load has a geometric stiffness, Psi' A and Phi' A with edges.
OF_F, OF_JF, TURN_F, TURN_JF, VECTORS = range(5)
# Rows of the second scratch matrix: F and Phi' of the forces, their changes with the angle of (c0, c1), dm/dd, N d and
# its change with that angle, work; their number.
FORCE, ON_TURN, D_FORCE, D_TURN, BY_D, ND, ND_CHANGE, WORK, ROWS = range(9)
second_scratch = stack_matrix(ROWS, kernel.MOST)


@fast
def vector(p, k):
    """Index in p of the first entry of a vector of the load."""
    return kernel.HEAD + (2 + k) * int(p[kernel.COUNT])


@fast
def matrix(p, k):
    """Index in p of the first entry of a matrix (n, n): of N0 and N1, or of Psi' A and Phi' A behind them."""
    n = int(p[kernel.COUNT])
    return vector(p, VECTORS) + k * n * n


@fast
def edge_matrices(p):
    """Number of the matrix Psi' A."""
    return 2 if p[STIFFENS] != 0.0 else 0


@fast
def directions(p, q, angle):
    """c0 and c1."""
    if p[KIND] == EDGES:
        return 1.0, 0.0
    beta = p[ANGLE] - angle if p[KIND] == DEAD else q[2] - angle
    return math.cos(beta), math.sin(beta)


@fast
def combined(p, c0, c1, x, y):
    """Fill F, Phi' of the forces, N d and its change; return m."""
    n = int(p[kernel.COUNT])
    d, u, force, on_turn = row_of(x, kernel.D, n), row_of(x, kernel.U, n), row_of(y, FORCE, n), row_of(y, ON_TURN, n)
    nd, change, work = row_of(y, ND, n), row_of(y, ND_CHANGE, n), row_of(y, WORK, n)
    f, jf, turn_f, turn_jf = vector(p, OF_F), vector(p, OF_JF), vector(p, TURN_F), vector(p, TURN_JF)
    for i in range(n):
        force[i], on_turn[i] = c0 * p[f + i] + c1 * p[jf + i], c0 * p[turn_f + i] + c1 * p[turn_jf + i]
        nd[i], change[i] = 0.0, 0.0
    if p[KIND] == EDGES:
        at = edge_matrices(p)
        kernel.times(block_of(p, matrix(p, at), n, n), d, work)
        kernel.add(1.0, work, force)
        kernel.times(block_of(p, matrix(p, at + 1), n, n), d, work)
        kernel.add(1.0, work, on_turn)
    if p[STIFFENS] != 0.0:
        kernel.times(block_of(p, matrix(p, 0), n, n), d, nd)
        kernel.times(block_of(p, matrix(p, 1), n, n), d, work)
        for i in range(n):
            nd[i], change[i] = c0 * nd[i] + c1 * work[i], c0 * work[i] - c1 * nd[i]
        kernel.add(-1.0, nd, force)
    return kernel.dot(d, on_turn) + kernel.dot(u, nd)


@fast
def load_force(p, q, x, y, r):
    """Residual r (n,); F + g m is left in FORCE.  Cosine and sine of the frame, c0, c1 and m are returned."""
    c, s, angle, size = kernel.frame_of(p, q)
    n = kernel.deformation(p, q, c, s, angle, x)
    c0, c1 = directions(p, q, angle)
    m = combined(p, c0, c1, x, y)
    kernel.gradient(p, 1.0 / size, x)
    force = row_of(y, FORCE, n)
    kernel.add(m, row_of(x, kernel.G, n), force)
    kernel.from_frame(c, s, force, part_of(r, 0, n))
    for i in range(n):
        r[i] = -r[i]
    return c, s, c0, c1, m


@fast
def changes(p, c0, c1, x, y):
    """Fill changes of F and of Phi' of the forces with the angle of (c0, c1), and dm/dd."""
    n = int(p[kernel.COUNT])
    d, on_turn = row_of(x, kernel.D, n), row_of(y, ON_TURN, n)
    by_d, change = row_of(y, BY_D, n), row_of(y, ND_CHANGE, n)
    f, jf, turn_f, turn_jf = vector(p, OF_F), vector(p, OF_JF), vector(p, TURN_F), vector(p, TURN_JF)
    for i in range(n):
        y[D_FORCE, i] = c0 * p[jf + i] - c1 * p[f + i] - change[i]
        y[D_TURN, i] = c0 * p[turn_jf + i] - c1 * p[turn_f + i]
        by_d[i] = on_turn[i]
    if p[KIND] == EDGES:
        C = block_of(p, matrix(p, edge_matrices(p) + 1), n, n)
        for j in range(n):
            for i in range(n):
                by_d[j] += C[i, j] * d[i]
    if p[STIFFENS] != 0.0:
        nu, quarter = row_of(y, WORK, n), row_of(y, ON_TURN, n)
        of_stiffness(p, c0, c1, row_of(x, kernel.U, n), nu, quarter)
        kernel.turned(row_of(y, ND, n), quarter)
        for j in range(n):
            by_d[j] += nu[j] - quarter[j]


@fast
def of_stiffness(p, c0, c1, vector_in, target, work):
    """Set target = N x."""
    n = target.shape[0]
    kernel.times(block_of(p, matrix(p, 0), n, n), vector_in, target)
    kernel.times(block_of(p, matrix(p, 1), n, n), vector_in, work)
    for i in range(n):
        target[i] = c0 * target[i] + c1 * work[i]


@element_kernel
def reduced_load_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    """Load on the mesh of a reduced body; q, r (n,), K (n, n)."""
    x, y = kernel.scratch(), second_scratch()
    c, s, c0, c1, m = load_force(p, q, x, y, r)
    changes(p, c0, c1, x, y)
    n, kind, stiffens, at = int(p[kernel.COUNT]), p[KIND], p[STIFFENS] != 0.0, edge_matrices(p)
    d, u, g = row_of(x, kernel.D, n), row_of(x, kernel.U, n), row_of(x, kernel.G, n)
    sf, by_d, bu, work = row_of(y, ON_TURN, n), row_of(y, BY_D, n), row_of(y, ND, n), row_of(y, WORK, n)
    kernel.turned(row_of(y, FORCE, n), sf)
    for i in range(n):
        bu[i] = 0.0
    if stiffens:
        of_stiffness(p, c0, c1, u, bu, work)
    for i in range(n):
        sf[i] += bu[i]
    if kind == EDGES:
        kernel.times(block_of(p, matrix(p, at), n, n), u, bu)
        kernel.add(-1.0, bu, sf)
    by_angle = kernel.dot(d, row_of(y, D_TURN, n)) + kernel.dot(u, row_of(y, ND_CHANGE, n))
    by_u, curved = kernel.dot(u, by_d), 0.0 if p[kernel.BY_PIN] != 0.0 else m
    for j in range(n):
        turn = 0.0 if kind == EDGES else -g[j]
        if kind == FOLLOWER and j == 2:
            turn += 1.0
        dm = turn * by_angle + by_d[j] - by_u * g[j] - curve(g, j, curved)
        for i in range(n):
            K[i, j] = -(turn * y[D_FORCE, i] + sf[i] * g[j] + g[i] * dm)
    add_matrices(p, c0, c1, K)
    kernel.to_world(c, s, K)


@fast
def add_matrices(p, c0, c1, K):
    """Add N - Psi' A to K."""
    n = K.shape[0]
    if p[KIND] == EDGES:
        B = block_of(p, matrix(p, edge_matrices(p)), n, n)
        for i in range(n):
            for j in range(n):
                K[i, j] -= B[i, j]
    if p[STIFFENS] != 0.0:
        N0, N1 = block_of(p, matrix(p, 0), n, n), block_of(p, matrix(p, 1), n, n)
        for i in range(n):
            for j in range(n):
                K[i, j] += c0 * N0[i, j] + c1 * N1[i, j]


@fast
def curve(g, i, m):
    """Entry i of -m S g, the derivative of the size of the sum behind theta_f, over that sum and times m."""
    if i % 3 == 0:
        return m * g[i + 1]
    return -m * g[i - 1] if i % 3 == 1 else 0.0


@signal_kernel
def reduced_load_signal(p, t, q, v, a):
    """Force along x or y, or power; p: that of the element, then the number of the signal."""
    y, n, last = second_scratch(), int(p[kernel.COUNT]), p.shape[0] - 1
    number = int(p[last])
    r, found = row_of(y, D_FORCE, n), 0.0
    load_force(p, q, kernel.scratch(), y, r)
    for i in range(0, n, 3):
        if number == POWER:
            found -= r[i] * v[i] + r[i + 1] * v[i + 1] + r[i + 2] * v[i + 2]
        else:
            found -= r[i + number]
    return found


# Constant matrices of a reduced body, and the parameters of its element

ROUND_OFF = 1e-10  # part of the largest shortening that counts as round-off


@dataclass(frozen=True, eq=False)
class Superelement:
    """Matrices of the kernel (`flexmb.elastic.reduced.kernel`), in the axes of the reference configuration."""

    nodes: tuple[Node, ...]  # pins and nodes of vibrations
    pins: int  # number of pins
    by_pin: bool  # whether the frame is that of the first pin
    damping: float  # stiffness-proportional damping time [s]
    mass: float  # total mass [kg]
    moment: Array  # (2,) int rho X [kg m]
    mean: Array  # (2, n) int rho Psi [kg]
    matrices: dict[str, Array]  # M, G, H, P, K, and D of modal and mass-proportional damping (n, n each)
    centrifugal: Array  # (n, n) Kc, zeros without stiffening
    # (k, n + 1, n) directions in which bending shortens the body, as few as there can be, each above its Q; a straight
    # beam has one, its axis, however it lies
    directions: Array

    def parameters(self, gravity: tuple[float, float]) -> tuple[float, ...]:
        """Parameters p of the kernel."""
        n = 3 * len(self.nodes)
        M, G, H, P, K, D = (self.matrices[name] for name in "MGHPKD")
        flags = float(self.by_pin), float(D.any())
        head = (n, len(self.directions), *flags, self.damping, *gravity, self.mass, *self.moment)
        centrifugal = self.centrifugal
        blocks = [*self.frame_parameters(), self.mean, M, G, H, P + centrifugal, centrifugal, K, D]
        blocks += [block for l in self.directions for block in (l[0], K @ l[0], D @ l[0], l[1:])]
        return (*map(float, head), *np.concatenate([block.ravel() for block in blocks]).tolist())

    def frame_parameters(self) -> tuple[Array, Array]:
        """Poses (n / 3, 3) of the undeformed body, and weights of the frame of the same shape."""
        poses = np.array([(node.x, node.y, node.theta) for node in self.nodes])
        weights = np.zeros_like(poses)
        if not self.by_pin:
            weights[: self.pins, :2] = frame_weights(self.nodes[: self.pins])
        return poses, weights

    def frequencies(self, count: int) -> Array:
        """Lowest frequencies of the free body, without rigid motions (at most `count`) [Hz]."""
        squares = la.eigh(self.matrices["K"], self.matrices["M"], eigvals_only=True)[3:]
        return np.asarray(np.sqrt(np.maximum(squares[:count], 0.0)) / (2.0 * math.pi))


def superelement(
    found: Basis, damping: float, *, stiffening: bool, ratios: float | tuple[float, ...], mass_damping: float
) -> Superelement:
    """Matrices of a reduced body."""
    # `damping` is a stiffness-proportional time [s], `mass_damping` a mass-proportional rate [1/s]; `ratios` are
    # damping ratios of the vibrations of the free body, from the lowest, one number those of all. With `stiffening`
    # bending is stiffened by forces of the pins and by rotation. More coordinates than the kernel can take are refused.
    n = found.shapes.shape[1]
    require_room(found.model, n - found.model.count)
    # M, G, H, P; mass; int rho X; int rho Psi
    model, shapes = found.model, found.shapes
    moved = np.asarray(model.shape @ shapes)
    x, y, Ms = moved[0::2], moved[1::2], model.mass
    # Phi = J Psi - Psi S
    phi_x, phi_y = -y - quarter_turned(x), x - quarter_turned(y)
    turns = np.asarray(model.turn_shape @ shapes)
    phi_t, Jt = -quarter_turned(turns), model.turn_inertia
    mx, my, mt = Ms @ x, Ms @ y, Jt @ turns
    wx, wy, wt = Ms @ phi_x, Ms @ phi_y, Jt @ phi_t
    matrices = {
        "M": mx.T @ x + my.T @ y + mt.T @ turns, "G": x.T @ wx + y.T @ wy + turns.T @ wt,
        "H": phi_x.T @ wx + phi_y.T @ wy + phi_t.T @ wt, "P": -x.T @ wy + y.T @ wx,
    }  # fmt: skip
    for name in "MH":
        matrices[name] = 0.5 * (matrices[name] + matrices[name].T)
    total = np.asarray(Ms.sum(axis=0)).ravel()
    mean = np.stack([total @ x, total @ y])
    mass, moment = float(total.sum()), total @ model.points
    free = rigid_motions(found.nodes)
    K = _without(free, found.shapes.T @ (found.model.stiffness @ found.shapes))
    against = np.eye(len(K))  # motions against the first node, whose inertia forces are in balance
    against[:, :2] -= free[:, :2]
    D, given = np.zeros_like(K), np.atleast_1d(np.asarray(ratios, dtype=float))
    if given.any():  # the vibrations of the free body have these damping ratios
        squares, modes = (part[..., 3:] for part in la.eigh(K, matrices["M"]))
        zeta = np.full(len(squares), given[0] if np.ndim(ratios) == 0 else 0.0)
        if np.ndim(ratios):
            zeta[: len(given)] = given[: len(squares)]
        loads = matrices["M"] @ modes
        D += (loads * (2.0 * zeta * np.sqrt(squares))) @ loads.T
    matrices |= {"K": K, "D": D + mass_damping * (against.T @ matrices["M"] @ against)}
    centrifugal, shortening = _stiffening(found, K, free) if stiffening else (np.zeros((n, n)), np.zeros((0, n, n)))
    pins, along = len(found.model.pins), _directions(found, shortening)
    return Superelement(found.nodes, pins, found.by_pin, damping, mass, moment, mean, matrices, centrifugal, along)


def quarter_turned(rows: Array) -> Array:
    """rows S, with S the quarter turn of the translations of each node."""
    turned = np.zeros_like(rows)
    turned[:, 0::3], turned[:, 1::3] = rows[:, 1::3], -rows[:, 0::3]
    return turned


def _without(free: Array, A: Array) -> Array:
    """The symmetric A without the round-off that acts on free motions."""
    Q = np.linalg.qr(free)[0]
    left = np.eye(len(A)) - Q @ Q.T
    clean: Array = left @ (0.5 * (A + A.T)) @ left
    return 0.5 * (clean + clean.T)


def _stiffening(found: Basis, K: Array, free: Array) -> tuple[Array, Array]:
    """Geometric stiffness: Kc of centrifugal forces about the first pin at unit speed, and Q of unit forces."""
    # Q_a is that of a unit force along the static shape a, 1/2 d Q_a d the shortening there. With static shapes of
    # inertia or loads, Q of all coordinates; Kc is of the stress that these leave.
    # Equation (12.10) of docs/theory/reduced.md.
    model, n, m = found.model, len(K), found.model.count
    centrifugal = stiffness_under(found, model.force_of(model.points - np.array([model.pins[0].x, model.pins[0].y])))
    inner = found.shapes[:, m:] if found.loaded else found.shapes[:, :0]
    static = np.hstack([found.shapes[:, :m] + found.shapes[:, m:] @ found.followed, inner])[:, kernel.FIRST :]
    if not static.shape[1]:
        return centrifugal, np.zeros((0, n, n))
    stiff = np.stack([_reduced_stiffness(found, column, free) for column in static.T])
    return centrifugal, np.einsum("ab,bij->aij", np.linalg.inv(static.T @ (model.stiffness @ static)), stiff)


def _directions(found: Basis, shortening: Array) -> Array:
    """(k, n + 1, n) directions of Q (m, n, n) of the coordinates from the second pin on, each above its matrix."""
    # Added nodes go along with the pins, so amplitudes stay as they are.
    m, n, _ = shortening.shape
    pins = found.model.count
    if not shortening.any():
        return np.zeros((0, n + 1, n))
    U, sizes, V = la.svd(shortening.reshape(m, n * n), full_matrices=False)
    kept = sizes > ROUND_OFF * sizes[0]
    along = np.zeros((int(kept.sum()), n))
    along[:, kernel.FIRST : kernel.FIRST + m] = (U[:, kept] * sizes[kept]).T
    along[:, pins:] += along[:, :pins] @ found.followed.T
    return np.concatenate([along[:, None], V[kept].reshape(-1, n, n)], axis=1)


def stiffness_under(found: Basis, force: Array) -> Array:
    """Geometric stiffness (n, n) of forces (N,) [N] with all pins held, without that of the kept static shapes."""
    z, m = found.static(force), found.model.count
    if found.loaded:
        inner = found.shapes[:, m:]
        of_inner = found.model.stiffness @ inner
        z -= inner @ np.linalg.solve(inner.T @ of_inner, of_inner.T @ z)
    return _reduced_stiffness(found, z, rigid_motions(found.nodes))


def _reduced_stiffness(found: Basis, z: Array, free: Array) -> Array:
    """K_G (n, n) of the stress of displacements (N,), by `stress_stiffness` of models.py, less round-off."""
    return _without(free[:, :2], found.shapes.T @ (found.model.stress_stiffness(z) @ found.shapes))


def load_contributions(body: Reduced, name: str, load: NodalLoad, history: Motion | None) -> list[Contribution]:
    """Element and signals of a load, times the motion `history`; with stiffening its stress counts."""
    found, coordinates = body.basis, body.coordinates
    kind = EDGES if load.edges else FOLLOWER if load.follower else DEAD
    shapes = np.asarray(found.model.shape @ found.shapes)  # Psi at the points
    turning = _quarter(shapes) - quarter_turned(shapes)  # Phi
    f = load.forces.ravel()
    both = f, _quarter(f) if kind != EDGES else np.zeros_like(f)
    blocks = [*body.element.frame_parameters(), *(shapes.T @ g for g in both), *(turning.T @ g for g in both)]
    if body.stiffening:
        none = np.zeros((found.shapes.shape[1],) * 2)
        blocks += [stiffness_under(found, found.model.shape.T @ g) if g.any() else none for g in both]
    if load.edges:
        moved = load.edges.matrix(len(f)) @ shapes
        blocks += [shapes.T @ moved, turning.T @ moved]
    head = [0.0] * kernel.HEAD
    head[kernel.COUNT], head[kernel.BY_PIN], head[KIND] = float(shapes.shape[1]), float(body.element.by_pin), kind
    head[ANGLE], head[STIFFENS] = found.model.direction, float(body.stiffening)
    p = (*head, *np.concatenate([np.ravel(block) for block in blocks]).tolist())
    signals = signal_contributions(name, reduced_load_signal, SIGNALS, coordinates, p, use_of_factor=MULTIPLIES)
    return [ElementContribution(name, reduced_load_kernel, coordinates, p, factor=history), *signals]


def checked_loads(body: MeshBody, given: object) -> tuple[MeshLoad, ...]:
    """Loads whose static shapes a reduced body keeps, a sequence of loads on the mesh of this body."""
    loads = checks.sequence(body.label, "load_shapes", given, "loads such as loads.EdgePressure")
    for load in loads:
        if not isinstance(load, MeshLoad):
            text = f"{body.label}: load_shapes holds {load!r}; it must hold loads on the mesh of a body"
            raise InputError(f"{text}, such as loads.EdgePressure.")
        if load.body.name != body.name:
            text = f"{body.label}: load_shapes holds {load.label}, which acts on {load.body.label}"
            raise InputError(f"{text}. Leave it out, or give the load this body.")
        load.plane_of(body)
    return loads


def left_out(body: Reduced, force: Array) -> tuple[float, float]:
    """Strain energy [J] of forces (N,) [N] on the model with all pins held, and its part without the kept shapes."""
    found, m = body.basis, body.basis.model.count
    kept, whole = (found.shapes.T @ force)[m:], 0.5 * float(found.static(force) @ force)
    return whole, whole - 0.5 * float(kept @ np.linalg.solve(body.element.matrices["K"][m:, m:], kept))


def _quarter(rows: Array) -> Array:
    """J times vectors x0, y0, x1, y1, ... along the first axis."""
    turned = np.empty_like(rows)
    turned[0::2], turned[1::2] = -rows[1::2], rows[0::2]
    return turned
