"""Constant matrices of a reduced body, and the parameters of its element."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import scipy.linalg as la

from flexmb.model.contributions import Node
from flexmb.reduction.craig_bampton import Basis, frame_weights, require_room, rigid_motions
from flexmb.reduction.kernel import BY_PIN, COUNT, FIRST, HEAD
from flexmb.reduction.load_kernels import ANGLE, KIND, STIFFENS

Array = npt.NDArray[np.float64]

ROUND_OFF = 1e-10
"""Part of the largest shortening that counts as round-off."""


@dataclass(frozen=True, eq=False)
class Superelement:
    """Matrices of the kernel (`flexmb.reduction.kernel`), in the axes of the reference configuration.

    Parameters
    ----------
    nodes : pins and nodes of vibrations.
    pins : number of pins.
    by_pin : whether the frame is that of the first pin.
    damping : stiffness-proportional damping time [s].
    mass : total mass [kg].
    moment : (2,) int rho X [kg m].
    mean : (2, n) int rho Psi [kg].
    matrices : M, G, H, P, K, and D of modal and mass-proportional damping (n, n each).
    centrifugal : (n, n) Kc, zeros without stiffening.
    directions : (k, n + 1, n) directions in which bending shortens the body, as few as there can be, each above its Q;
        a straight beam has one, its axis, however it lies.
    """

    nodes: tuple[Node, ...]
    pins: int
    by_pin: bool
    damping: float
    mass: float
    moment: Array
    mean: Array
    matrices: dict[str, Array]
    centrifugal: Array
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

    def load_head(self, kind: float, angle: float, *, stiffens: bool) -> tuple[float, ...]:
        """Parameters before the poses, of a load (`flexmb.reduction.load_kernels`).

        `angle` is that of the axes in which its forces are given [rad]; `stiffens`: its geometric stiffness is among
        the parameters.
        """
        head = [0.0] * HEAD
        head[COUNT], head[BY_PIN], head[KIND], head[ANGLE] = 3.0 * len(self.nodes), float(self.by_pin), kind, angle
        head[STIFFENS] = float(stiffens)
        return tuple(head)

    def frequencies(self, count: int) -> Array:
        """Lowest frequencies of the free body, without rigid motions (at most `count`) [Hz]."""
        squares = la.eigh(self.matrices["K"], self.matrices["M"], eigvals_only=True)[3:]
        return np.asarray(np.sqrt(np.maximum(squares[:count], 0.0)) / (2.0 * math.pi))


def superelement(
    found: Basis,
    damping: float,
    *,
    stiffening: bool,
    ratios: float | tuple[float, ...] = 0.0,
    mass_damping: float = 0.0,
) -> Superelement:
    """Matrices of a reduced body.

    `damping` is a stiffness-proportional time [s], `mass_damping` a mass-proportional rate [1/s]; `ratios` are damping
    ratios of the vibrations of the free body, from the lowest, one number those of all.  With `stiffening` bending is
    stiffened by forces of the pins and by rotation.  More coordinates than the kernel can take are refused.
    """
    n = found.shapes.shape[1]
    require_room(found.model, n - found.model.count)
    matrices, mass, moment, mean = _inertia(found)
    free = rigid_motions(found.nodes)
    K = _without(free, found.shapes.T @ (found.model.stiffness @ found.shapes))
    D = _modal_damping(matrices["M"], K, ratios) + mass_damping * _from_first_node(matrices["M"], free)
    matrices |= {"K": K, "D": D}
    zero = np.zeros((n, n))
    centrifugal, shortening = _stiffening(found, K, free) if stiffening else (zero, np.zeros((0, n, n)))
    pins, along = len(found.model.pins), _directions(found, shortening)
    return Superelement(found.nodes, pins, found.by_pin, damping, mass, moment, mean, matrices, centrifugal, along)


def _inertia(found: Basis) -> tuple[dict[str, Array], float, Array, Array]:
    """M, G, H, P; mass; int rho X; int rho Psi."""
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
        "M": mx.T @ x + my.T @ y + mt.T @ turns,
        "G": x.T @ wx + y.T @ wy + turns.T @ wt,
        "H": phi_x.T @ wx + phi_y.T @ wy + phi_t.T @ wt,
        "P": -x.T @ wy + y.T @ wx,
    }
    for name in "MH":
        matrices[name] = 0.5 * (matrices[name] + matrices[name].T)
    total = np.asarray(Ms.sum(axis=0)).ravel()
    mean = np.stack([total @ x, total @ y])
    return matrices, float(total.sum()), total @ model.points, mean


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


def _from_first_node(M: Array, free: Array) -> Array:
    """Mass matrix of motions against the first node: its forces are in balance."""
    against = np.eye(len(M))
    against[:, :2] -= free[:, :2]
    return np.asarray(against.T @ M @ against)


def _modal_damping(M: Array, K: Array, ratios: float | tuple[float, ...]) -> Array:
    """Damping matrix that gives the vibrations of the free body their damping ratios."""
    given = np.atleast_1d(np.asarray(ratios, dtype=float))
    if not given.any():
        return np.zeros_like(K)
    squares, shapes = la.eigh(K, M)
    squares, shapes = squares[3:], shapes[:, 3:]
    zeta = np.full(len(squares), given[0]) if np.ndim(ratios) == 0 else np.zeros(len(squares))
    if np.ndim(ratios):
        zeta[: len(given)] = given[: len(squares)]
    loads = M @ shapes
    damping: Array = (loads * (2.0 * zeta * np.sqrt(squares))) @ loads.T
    return damping


def _stiffening(found: Basis, K: Array, free: Array) -> tuple[Array, Array]:
    """Kc of centrifugal forces about the first pin, and Q of the forces of the pins and of the own inertia.

    With static shapes of inertia or loads, Q of all coordinates; Kc is of the stress that these leave.
    """
    model, n, m = found.model, len(K), found.model.count
    first = np.array([model.pins[0].x, model.pins[0].y])
    centrifugal = stiffness_under(found, model.force_of(model.points - first))
    inner = found.shapes[:, m:] if found.loaded else found.shapes[:, :0]
    static = np.hstack([found.shapes[:, :m] + found.shapes[:, m:] @ found.followed, inner])[:, FIRST:]
    if not static.shape[1]:
        return centrifugal, np.zeros((0, n, n))
    stiff = np.stack([_seen(found, column, free) for column in static.T])
    flexible = np.linalg.inv(static.T @ (model.stiffness @ static))
    return centrifugal, np.einsum("ab,bij->aij", flexible, stiff)


def _directions(found: Basis, shortening: Array) -> Array:
    """(k, n + 1, n) directions of Q (m, n, n) of the coordinates from the second pin on, each above its matrix.

    Added nodes go along with the pins, so amplitudes stay as they are.
    """
    m, n, _ = shortening.shape
    pins = found.model.count
    if not shortening.any():
        return np.zeros((0, n + 1, n))
    U, sizes, V = la.svd(shortening.reshape(m, n * n), full_matrices=False)
    kept = sizes > ROUND_OFF * sizes[0]
    along = np.zeros((int(kept.sum()), n))
    along[:, FIRST : FIRST + m] = (U[:, kept] * sizes[kept]).T
    along[:, pins:] += along[:, :pins] @ found.followed.T
    return np.concatenate([along[:, None], V[kept].reshape(-1, n, n)], axis=1)


def stiffness_under(found: Basis, force: Array) -> Array:
    """Geometric stiffness (n, n) of forces (N,) [N] with all pins held, without that of the kept static shapes."""
    z, m = found.static(force), found.model.count
    if found.loaded:
        inner = found.shapes[:, m:]
        of_inner = found.model.stiffness @ inner
        z -= inner @ np.linalg.solve(inner.T @ of_inner, of_inner.T @ z)
    return _seen(found, z, rigid_motions(found.nodes))


def _seen(found: Basis, z: Array, free: Array) -> Array:
    """Geometric stiffness (n, n) of the stress of displacements (N,), without round-off on translations."""
    return _without(free[:, :2], found.shapes.T @ (found.model.stress_stiffness(z) @ found.shapes))
