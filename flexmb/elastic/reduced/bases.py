"""Craig-Bampton bases: static shapes of the pins, and vibrations with all pins held.

Every third of the vibrations makes a node (x, y, theta) of the reduced body: two amplitudes are displacements of the
node against the mean of the pins, the third is its rotation against that of the first pin.  So rigid motions are those
of nodes, and the basis holds them.  Shortening takes the added nodes along with the pins.

On request a node for the static shapes of the own inertia comes first.  The static shape of a steady rotation about the
first pin and those of given loads precede the vibrations, which then have no static part of these.
Source: R. R. Craig, M. C. C. Bampton, AIAA J. 6 (1968) 1313.  Equations (12.17) to (12.21) of docs/theory/reduced.md.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import scipy.linalg as la

from flexmb import planar
from flexmb.elastic.planes.cells import factored, lowest
from flexmb.elastic.reduced.kernel import MOST
from flexmb.errors import InputError
from flexmb.model.contributions import Node
from flexmb.model.shape import MeshShape
from flexmb.planar import Array, Indices

Sparse: TypeAlias = Any  # sparse matrix of scipy, which has no types


@dataclass(frozen=True, eq=False)
class ElasticModel:
    """Small displacements of an elastic body."""

    label: str  # class and name of the body, for messages
    # (P) nodes where other parts are attached; the first 3 P displacements are x, y and rotation of these
    pins: tuple[Node, ...]
    stiffness: Sparse  # (N, N) symmetric, 0 for rigid motions [N/m]
    points: Array  # (S, 2) reference positions of the points whose displacements carry the mass [m]
    shape: Sparse  # (2 S, N) displacements x0, y0, x1, y1, ... of the points
    mass: Sparse  # (S, S) symmetric; kinetic energy = 1/2 v_x mass v_x + 1/2 v_y mass v_y [kg]
    turn_shape: Sparse  # (R, N) rotations that carry moments of inertia
    turn_inertia: Sparse  # (R, R) symmetric [kg m^2]
    # (N,) displacements -> (N, N) geometric stiffness of the stress of these displacements [N/m]
    stress_stiffness: Callable[[Array], Sparse]
    damping: float = 0.0  # stiffness-proportional damping time [s]
    origin: tuple[float, float] = (0.0, 0.0)  # of the axes of the model in the reference configuration [m]
    direction: float = 0.0  # of these axes there [rad]
    # mesh that shows the body, with places in the axes of the model, without what moves it
    drawn: MeshShape | None = None
    drawn_by: Sparse | None = None  # (2 points, N) displacements of its points
    # (N, n) displacements -> (nodes, 4, n) sx, sy, txy, sz at the nodes [Pa]; None: unknown
    stresses: Callable[[Array], Array] | None = None
    mass_damping: float = 0.0  # mass-proportional damping rate [1/s]

    def placed(self, nodes: Sequence[Node]) -> tuple[Node, ...]:
        """Nodes, given in the axes of the model, in the reference configuration."""
        turn = self.direction
        return tuple(Node(n.name, *planar.from_frame(self.origin, turn, (n.x, n.y)), n.theta + turn) for n in nodes)

    @property
    def count(self) -> int:
        """Number of the displacements of pins."""
        return 3 * len(self.pins)

    def mass_matrix(self) -> Sparse:
        """Consistent mass (N, N) [kg, kg m, kg m^2]."""
        x, y = self.shape[0::2], self.shape[1::2]
        turns = self.turn_shape.T @ self.turn_inertia @ self.turn_shape
        return (x.T @ self.mass @ x + y.T @ self.mass @ y + turns).tocsc()

    def force_of(self, field: Array) -> Array:
        """Forces (N,) of an acceleration field -field (S, 2) of all points [N]."""
        loads = np.empty(self.shape.shape[0])
        loads[0::2], loads[1::2] = self.mass @ field[:, 0], self.mass @ field[:, 1]
        return np.asarray(self.shape.T @ loads)


DENSE = 60  # number of inner displacements up to which all vibrations are computed by a dense solver
RIGID = 3  # motions of a rigid body
FIRST_TRIAL = 12  # number of vibrations that are computed first where all up to a frequency are kept
LEAST_PIVOT = 1e-13  # smallest pivot over the largest one [1] of a body whose inside is held by its pins
LEAST_SHARE = 1e-10  # least strain energy that other shapes leave of a static shape, over its own [1]
TIE = 0.01  # part by which the last displacement counts less than the first where shapes get their signs [1]
NEARLY = 1e-6  # the same of combinations, below which vibrations are whole, beside what they leave of static shapes


@dataclass(frozen=True, eq=False)
class Basis:
    """Shapes of a reduced body."""

    model: ElasticModel
    # pins, the node of static shapes of inertia, if there is one, then a node for every three vibrations
    nodes: tuple[Node, ...]
    shapes: Array  # (N, n) displacements of the model by those of the nodes
    held: Array  # frequencies with all pins held of the kept vibrations, and of the next one, if there is one [Hz]
    solve_inner: Callable[[Array], Array]  # solves K_ii x = b for one b (N - 3 P,) or several
    by_pin: bool  # whether the frame of the body is that of its first pin
    followed: Array  # (k, 3 P) rigid motion of the added nodes by the displacements of the pins
    vibrations: int  # number of vibrations that are kept

    @property
    def loaded(self) -> int:
        """Number of static shapes of inertia and of loads."""
        return int(self.shapes.shape[1]) - self.model.count - self.vibrations

    def static(self, force: Array) -> Array:
        """Displacements (N,) under forces (N,) with all pins held."""
        m, z = self.model.count, np.zeros(len(force))
        z[m:] = self.solve_inner(force[m:])
        return z


def basis(model: ElasticModel, modes: int, up_to: float | None, *, by_pin: bool, own: Indices, loads: Array) -> Basis:
    """Craig-Bampton basis of a body, with `modes` vibrations at least, all pins held."""
    # With the shapes of loads a multiple of three modes is kept; with `up_to` all vibrations up to this frequency [Hz].
    # `by_pin`: the frame is that of the first pin; `own`: numbers of the `inertia_loads`, and `loads`: forces (N, L),
    # whose static shapes are kept, but for those of inertia that the other shapes hold; those of loads are refused.
    m, K, M = model.count, model.stiffness.tocsc(), model.mass_matrix()
    inner = K.shape[0] - m
    solve = _solver(model, K[m:, m:]) if inner else np.zeros_like
    weights = loads[:, :0]
    if len(own):  # without the rotation where it bends as the others do, or has no room
        every = np.stack(list(inertia_loads(model).values()), axis=1)
        work = every[m:].T @ solve(every[m:])
        rest = work[3, 3] - work[3, :3] @ np.linalg.lstsq(work[:3, :3], work[:3, 3], rcond=LEAST_SHARE)[0]
        turns = rest > LEAST_SHARE * work[3, 3] and inner - modes - loads.shape[1] > RIGID
        weights = every[:, [k for k in own if k < RIGID or turns]]
    forces, inertia = np.hstack([weights, loads]), weights.shape[1] > 0
    static_shapes = forces.shape[1]
    if modes + static_shapes > inner - inner % 3:
        besides = f", {static_shapes} for static shapes of inertia and loads" if static_shapes else ""
        text = f"{model.label}: modes is {modes}, but the body has {inner} inner displacements, of"
        raise InputError(f"{text} which modes take three at a time{besides}. Keep fewer modes, or take more elements.")
    require_room(model, _in_threes(modes, static_shapes) + static_shapes)
    static = np.vstack([np.eye(m), -solve(K[m:, :m].toarray())]) if inner else np.eye(m)
    count = _in_threes(modes, static_shapes) + 1 if up_to is None else FIRST_TRIAL
    omega, phi = _vibrations(model, K[m:, m:], M[m:, m:], count, up_to, solve)
    kept = _in_threes(modes if up_to is None else int(np.sum(omega <= 2.0 * math.pi * up_to)), static_shapes)
    while kept > len(omega):
        kept -= 3
    inside = phi[:, :kept]
    if static_shapes:
        inside, spare = _with_static(model, K[m:, m:], inside, solve(forces[m:]), weights.shape[1])
        if spare is not None:
            return basis(model, modes, up_to, by_pin=by_pin, own=np.delete(own, spare), loads=loads)
    full = np.vstack([np.zeros((m, inside.shape[1])), inside])
    x, y = (float(np.mean([getattr(pin, axis) for pin in model.pins])) for axis in "xy")
    names = [*(["inertia"] if inertia else []), *(f"modes{k + 1}" for k in range(inside.shape[1] // 3 - inertia))]
    added = tuple(Node(name, x, y, model.pins[0].theta) for name in names)
    scaled, rigid = full * _amplitudes(model, full), followed(model.pins, len(added))
    shapes = np.hstack([static - scaled @ rigid, scaled])
    return Basis(model, (*model.pins, *added), shapes, omega[: kept + 1] / (2.0 * math.pi), solve, by_pin, rigid, kept)


def _in_threes(modes: int, static_shapes: int) -> int:
    """Number of vibrations, at least `modes`, that make a multiple of three with the static shapes."""
    return 3 * math.ceil((modes + static_shapes) / 3) - static_shapes


def inertia_loads(model: ElasticModel) -> dict[str, Array]:
    """Forces (N,) of unit accelerations along x, along y and about the first pin, and of a turn about it at 1 rad/s."""
    arms = model.points - np.array([model.pins[0].x, model.pins[0].y])
    one, zero = np.ones(len(arms)), np.zeros(len(arms))
    along_x, along_y = np.stack([one, zero], axis=1), np.stack([zero, one], axis=1)
    about = np.stack([-arms[:, 1], arms[:, 0]], axis=1)
    fields = {"acceleration along x": along_x, "acceleration along y": along_y, "angular acceleration": about}
    return {name: model.force_of(field) for name, field in {**fields, "rotation": arms}.items()}


def _with_static(model: ElasticModel, K: Sparse, phi: Array, shapes: Array, own: int) -> tuple[Array, int | None]:
    """(n, s + k) static shapes (n, s), then vibrations (n, k) without their static part; number of a spare shape."""
    sizes, lengths = (np.sqrt(np.einsum("ij,ij->j", some, K @ some)) for some in (shapes, phi))
    unit = shapes / np.where(sizes, sizes, 1.0)
    rest = phi - unit @ np.linalg.lstsq(unit.T @ (K @ unit), unit.T @ (K @ phi), rcond=None)[0]
    first = np.asarray(np.hstack([unit, rest / lengths]))
    least = la.eigvalsh(first.T @ (K @ first))[0]
    if least > NEARLY:
        return first, None
    # And what vibrations leave of the static shapes, by Gram and Schmidt; those of loads first, since they are kept.
    together, order = phi / lengths, [*range(own, len(sizes)), *range(own)]
    for k in order:
        left = unit[:, k]
        for _ in range(2):  # again, against round-off
            left = left - together @ (together.T @ (K @ left))
        if (share := float(left @ (K @ left))) > LEAST_SHARE:
            together = np.column_stack([together, left / math.sqrt(share)])
        elif least > LEAST_SHARE or k < own:
            return first, (None if least > LEAST_SHARE else k)
    if together.shape[1] == rest.shape[1] + len(sizes):
        return together[:, [*(rest.shape[1] + np.argsort(order)), *range(rest.shape[1])]], None
    text = f"{model.label}: static shapes are none (loads on rigid pins alone, of size 0), or combinations of each"
    raise InputError(f"{text} other or of the modes. Keep fewer modes, leave out such loads, or take more elements.")


def require_room(model: ElasticModel, modes: int) -> None:
    """Refuse more coordinates than the kernel can take."""
    if model.count + modes > MOST:
        text = f"{model.label}: {model.count} coordinates of pins and {modes} or more modes are more than {MOST}."
        raise InputError(f"{text} Keep fewer modes, or join it at fewer pins.")


def _solver(model: ElasticModel, K: Sparse) -> Callable[[Array], Array]:
    """Solver of K_ii x = b."""
    try:
        factors = factored(K)
    except RuntimeError as error:
        raise InputError(_not_held(model)) from error
    size = np.abs(factors.U.diagonal())
    if not size.min() > LEAST_PIVOT * size.max():
        raise InputError(_not_held(model))
    return lambda b: np.asarray(factors.solve(np.ascontiguousarray(b)))


def _not_held(model: ElasticModel) -> str:
    """Message of a body whose inside moves without force while its pins stand still."""
    text = f"{model.label}: with its pins held ({', '.join(repr(pin.name) for pin in model.pins)}) a piece"
    return f"{text} of the body can still move without force. Connect all its pieces, or give a pin to each."


def _vibrations(
    model: ElasticModel, K: Sparse, M: Sparse, count: int, up_to: float | None, solve: Callable[[Array], Array]
) -> tuple[Array, Array]:
    """Angular frequencies and shapes with all pins held, ascending; at least `count`, and one above `up_to`."""
    n = K.shape[0]
    if up_to is not None and n > DENSE:
        require_room(model, count // 2)  # what was not enough
    if n <= DENSE or count >= n - 1:
        squares, shapes = la.eigh(K.toarray(), M.toarray()) if n else (np.zeros(0), np.zeros((0, 0)))
        return np.sqrt(np.maximum(squares, 0.0)), shapes
    squares, shapes = lowest(K, M, count, solve=solve)
    omega = np.sqrt(squares)
    if up_to is not None and omega[-1] <= 2.0 * math.pi * up_to:
        return _vibrations(model, K, M, min(2 * count, n), up_to, solve)
    return omega, shapes


def _amplitudes(model: ElasticModel, phi: Array) -> Array:
    """Factors of shapes (N, k): the largest displacement is 1, or the size of the body for every third one."""
    if not phi.shape[1]:
        return np.ones(0)
    moved = np.asarray(model.shape @ phi)
    largest = np.sqrt((moved[0::2] ** 2 + moved[1::2] ** 2).max(axis=0))
    size = np.ptp(model.points, axis=0).max()
    sizes = np.abs(moved) * np.linspace(1.0, 1.0 - TIE, len(moved))[:, None]  # so equal ones have one sign, always
    signs = np.sign(moved[sizes.argmax(axis=0), np.arange(phi.shape[1])])
    return np.asarray(signs * np.where(np.arange(phi.shape[1]) % 3 == 2, size, 1.0) / largest)


def frame_weights(pins: tuple[Node, ...]) -> Array:
    """A (P, 2) of the angle of the frame: positions of the pins less their mean [m]."""
    places = np.array([(pin.x, pin.y) for pin in pins])
    return np.asarray(places - places.mean(axis=0))


def rigid_motions(nodes: tuple[Node, ...]) -> Array:
    """(n, 3) displacements of nodes when all move by 1 along x, along y, and by a turn of 1 about the origin."""
    motions = np.zeros((3 * len(nodes), 3))
    motions[0::3, 0] = motions[1::3, 1] = motions[2::3, 2] = 1.0
    motions[0::3, 2], motions[1::3, 2] = [-node.y for node in nodes], [node.x for node in nodes]
    return motions


def followed(pins: tuple[Node, ...], added: int) -> Array:
    """R (k, 3 P): rigid motion of added nodes in the middle of the pins: their mean, rotation of the first one."""
    mean = np.tile(np.diag([1.0, 1.0, 0.0]) / len(pins), len(pins))
    mean[2, 2] = 1.0
    return np.tile(mean, (added, 1))
