"""Linear buckling: load factors at which a structure loses its stiffness, and whether they can be trusted.

A pencil K0 + s K1 is linear in s, but an element that turns by s phi has the stiffness R K R^T.  Its first term,
phi (S K - K S), couples stretching with bending; without the terms of s^2, which take its effect back, it makes a
cantilever under a force across it buckle.  Classical linear buckling, which counts stresses alone, has no such terms.
Bowing of beam elements and shortening of reduced bodies have the like: with deformations e(q), K = A^T D A of
A = de/dq has the slope A'^T D A + A^T D A', to which no stress belongs.

Whether the stiffness falls in proportion to the loads, the equilibrium at s = f/2 tells by its compliance c(s): the
factor s/(1 - c0/c(s)) is f where the structure keeps its shape until it buckles, another one where it bends before.
Equations (8.4) and (8.5) of docs/theory/equilibrium.md.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmb import arguments, checks, display
from flexmb.elastic.beams import corotational
from flexmb.elastic.reduced.bases import frame_weights
from flexmb.elastic.reduced.reduced import Reduced
from flexmb.elastic.reduced.superelement import Superelement
from flexmb.engine.linalg.large import negative_eigenvalues, solver
from flexmb.engine.system.evaluate import COORDINATES, add_turns
from flexmb.engine.system.state_evaluation import StateEvaluation
from flexmb.errors import FlexmbError, InputError, SolveError
from flexmb.findings.finding import Finding, found, sentences
from flexmb.late import scipy, sp
from flexmb.model.contributions import ElementContribution, SignalContribution
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import Body, refuse_controllers
from flexmb.parts.bodies.flexible_links import FlexibleBody
from flexmb.program.compiler import compile as compile_mechanism
from flexmb.program.program import Program, resolve
from flexmb.statics import equilibrium
from flexmb.statics.eigen import DENSE_COORDINATES, is_stable, largest_of, largest_of_pencil, moves_most, null_space
from flexmb.statics.start.consistent import check_independent

# Geometric stiffness along a motion: the slope of the stiffness, less that by turning and bowing of elements

FLAT = 1e-9  # determinant of the second moments of points over their trace squared, up to which they lie on a line
# Places of the rotations of a beam element among its coordinates, and of their offsets among its parameters.
ENDS = ((2, corotational.OFFSET1), (5, corotational.OFFSET2))
PATH_STRIDE = 1e-3  # difference along the prestress path between two evaluations of K, over the mechanism's size


def geometric_stiffness(
    mechanism: Mechanism, system: StateEvaluation, q: np.ndarray, lam: np.ndarray, path: np.ndarray
) -> sp.csc_matrix:
    """Stiffness (n_q, n_q) by the stresses and multipliers that grow along a path, at the rate of its parameter s."""
    # `q` (n_q,) and `lam` (n_c,) belong to s = 0, `path` (n_q + n_c,) are rates of coordinates and multipliers. A
    # contact that carries at s = 0 adds the stiffness of its growing force alone.
    system.at(q, lam=lam, weights=(1.0, 0.0, 0.0))
    by_contacts = equilibrium.contact_stiffness(system, path[: system.program.n_q])
    if len(system.program.names.contacts):
        system = StateEvaluation(compile_mechanism(mechanism, closed=True))
    program = system.program
    u, rate = path[: program.n_q], path[program.n_q :]
    size = np.abs(u * (program.length / program.sizes)).max()
    h = PATH_STRIDE * program.length / size if size else 1.0  # rigid bodies do not move: K is linear in the multipliers

    def stiffness(k: int) -> sp.csc_matrix:
        return system.at(q + k * h * u, lam=lam + k * h * rate, weights=(1.0, 0.0, 0.0)).block()

    slope = 8.0 * (stiffness(1) - stiffness(-1)) - (stiffness(2) - stiffness(-2))
    slope = slope / (12.0 * h) + by_contacts
    if not size:
        return slope.tocsc()
    bent = sp.lil_matrix((program.n_q, program.n_q))
    # A'^T K A + A^T K A' of each reduced body: A, its deformations by its coordinates, and the slope A'
    for body in (one for one in mechanism.bodies if isinstance(one, Reduced)):
        nodes, K = body.element.nodes, body.element.matrices["K"]
        first = program.names.coordinates.index(f"{body.name}.{nodes[0].name}.x")
        own = slice(first, first + COORDINATES * len(nodes))
        ahead, behind = (_deformations(body.element, q[own] + step * u[own]) for step in (h, -h))
        half = _deformations(body.element, q[own]).T @ K @ (ahead - behind) / (2.0 * h)
        bent[own, own] = half + half.T
    return (slope - (_turns(mechanism, system, q, u, h) + _bowed(mechanism, program, q, u)) - bent).tocsc()


def _turns(mechanism: Mechanism, system: StateEvaluation, q: np.ndarray, u: np.ndarray, stride: float) -> sp.csc_matrix:
    """Sum of phi (S K - K S) over all elements except reduced bodies."""
    program, work = system.program, system.work
    behind, here, ahead, still, size = (np.zeros(program.n_q + COORDINATES) for _ in range(5))
    own = slice(0, program.n_q)
    behind[own], here[own], ahead[own] = q - stride * u, q, q + stride * u
    size[:] = 1.0
    size[own] = program.length / program.sizes
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
    """B'^T D B + B^T D B' of all beam elements but for turning: B, their deformations (e, u1, u2) by coordinates."""
    # The slope of e is that by bowing; the slope of u1 and u2, that of the turn of the chord, dy/l, by its shortening.
    E = program.tables.elements
    beams = {body.name for body in mechanism.bodies if isinstance(body, FlexibleBody)}
    named = enumerate(program.names.elements)
    own = [e for e, part in named if part in beams and np.diff(E.p[e]) == corotational.PARAMETERS]
    if not own:
        return sp.csc_matrix((program.n_q, program.n_q))
    p = np.array([program.tables.p[slice(*E.p[e])] for e in own]).T
    dofs = np.array([E.dofs[E.dof[e] : E.dof[e + 1]] for e in own])
    place, moved = q[dofs], u[dofs]
    dx, dy = place[:, 3] - place[:, 0], place[:, 4] - place[:, 1]
    length, none = np.hypot(dx, dy), np.zeros(len(own))
    c, s = dx / length, dy / length
    along, turn = np.stack([-c, -s, none, c, s, none], 1), np.stack([s, -c, none, -s, c, none], 1) / length[:, None]
    first, second, alpha = np.eye(6)[2] - turn, np.eye(6)[5] - turn, np.arctan2(dy, dx)
    bent = [np.remainder(place[:, k] - alpha + p[offset] + np.pi, 2.0 * np.pi) - np.pi for k, offset in ENDS]

    def by_bowing(x1: np.ndarray, x2: np.ndarray) -> np.ndarray:
        g1 = p[corotational.LENGTH] / 30.0 * (2.0 * p[corotational.BOW11] * x1 - p[corotational.BOW12] * x2)
        g2 = p[corotational.LENGTH] / 30.0 * (2.0 * p[corotational.BOW22] * x2 - p[corotational.BOW12] * x1)
        return np.asarray(g1[:, None] * first + g2[:, None] * second)

    shorter = ((along * moved).sum(axis=1) / length)[:, None] * turn
    both, other = p[corotational.B11] + p[corotational.B12], p[corotational.B12] + p[corotational.B22]
    moments = both[:, None] * first + other[:, None] * second
    along = along + by_bowing(*bent)
    slope = p[corotational.AXIAL][:, None] * by_bowing((first * moved).sum(axis=1), (second * moved).sum(axis=1))
    blocks = slope[:, :, None] * along[:, None, :] + shorter[:, :, None] * moments[:, None, :]
    blocks += blocks.transpose(0, 2, 1)
    rows, columns = np.repeat(dofs, 6, axis=1), np.tile(dofs, (1, 6))
    return sp.csc_matrix((blocks.ravel(), (rows.ravel(), columns.ravel())), shape=(program.n_q, program.n_q))


def _deformations(element: Superelement, q: np.ndarray) -> np.ndarray:
    """A (n, n): changes of the deformation with its shortening, d + c(d), by the coordinates q (n,)."""
    nodes, pins, n = element.nodes, element.pins, len(q)
    place, drawn = q.reshape(-1, COORDINATES), np.array([(node.x, node.y, node.theta) for node in nodes])
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


TRUSTED = 0.1  # difference of a load factor from that under half of it, over the factor, up to which it counts
SMALL_MOVEMENT = 0.1  # movement under half of a load factor, over the size (or rad), up to which it counts
LOAD_STEPS = (1, 4)  # numbers of load steps with which the equilibrium is sought, until one finds it
MOST_ITERATIONS = 15  # Newton iterations of a load step at most
FOUND_STEP = 1e-9  # Newton step relative to the size of the mechanism, below which an equilibrium is found
LONGEST_STEP = 0.5  # Newton step relative to the size of the mechanism (or rad), to which longer ones are cut


@dataclass(frozen=True, eq=False)
class LoadPath:
    """Growing loads on a structure, to first order s (force + stiffness (q - q0))."""

    program: Program  # the structure without loads
    system: StateEvaluation
    start: tuple[np.ndarray, np.ndarray]  # coordinates (n_q,) and multipliers (n_c,) without loads
    force: np.ndarray  # (n_q,) residual of the loads at factor 1 there
    stiffness: sp.csc_matrix  # (n_q, n_q) their stiffness there

    def tangent(self, q: np.ndarray, lam: np.ndarray, s: float) -> tuple[sp.csc_matrix, sp.csr_matrix]:
        """Tangent stiffness (n_q, n_q) under s times the loads and G (n_c, n_q) at coordinates and multipliers."""
        self.system.at(q, lam=lam, weights=(1.0, 0.0, 0.0))
        return (self.system.block() + s * self.stiffness).tocsc(), self.system.jacobian

    def equilibrium(self, s: float) -> tuple[np.ndarray, np.ndarray] | None:
        """Coordinates (n_q,) and multipliers (n_c,) under s times the loads; None where none is found."""
        for steps in LOAD_STEPS:
            q, lam = self.start
            for share in np.arange(1, steps + 1) / steps:
                found = self._newton(q, lam, float(share * s))
                if found is None:
                    break
                q, lam = found
            else:
                return q, lam
        return None

    def solve_held(self, K: Any, G: Any, b: np.ndarray, c: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """x (n_q,) and multipliers y (n_c,) of K x + G^T y = b, G x = c; `RuntimeError` for a singular matrix."""
        scale = abs(K).max()
        A = sp.block_array([[K / scale, G.T], [G, None]]).tocsc()
        found = solver(A, self.program.symbolic.order)(np.append(b / scale, c))
        return found[: len(b)], scale * found[len(b) :]

    def _newton(self, q: np.ndarray, lam: np.ndarray, s: float) -> tuple[np.ndarray, np.ndarray] | None:
        """Coordinates and multipliers under s times the loads, by Newton's method."""
        program, start = self.program, self.start[0]
        for _ in range(MOST_ITERATIONS):
            K, G = self.tangent(q, lam, s)
            rest = self.system.force + self.system.constraint_force + s * (self.force + self.stiffness @ (q - start))
            d, change = self.solve_held(K, G, -rest, -self.system.residual)
            longest = float(np.abs(d / program.sizes).max())
            if not math.isfinite(longest):
                return None
            part = min(1.0, LONGEST_STEP / longest) if longest else 1.0
            q, lam = q + part * d, lam + part * change
            if longest <= FOUND_STEP:
                return q, lam
        return None


def factor_from_half(path: LoadPath, factor: float, shape: np.ndarray) -> tuple[float, float]:
    """The load factor f' of a shape (n_q,), and how far the structure moves, under half of the linear `factor`."""
    # The factor is inf where the stiffness against the shape does not fall. The movement is the largest rotation [rad]
    # or displacement over the size of the mechanism. Both are nan without an equilibrium.
    program, s, start = path.program, 0.5 * factor, path.start[0]
    try:
        K, G = path.tangent(*path.start, 0.0)
        pushed, found = K @ shape, path.equilibrium(s)
        if found is None:
            return math.nan, math.nan
        answer, _ = path.solve_held(*path.tangent(*found, s), pushed, np.zeros(G.shape[0]))
    except (FlexmbError, RuntimeError):
        return math.nan, math.nan
    lost = 1.0 - float(pushed @ shape) / float(pushed @ answer)
    return s / lost if lost > 0.0 else math.inf, float((np.abs(found[0] - start) / program.sizes).max())


def doubts(factor: float, from_half: float, moved: float) -> tuple[Finding, ...]:
    """Finding on a first load factor that the equilibrium under half of it does not confirm."""
    if abs(from_half - factor) <= TRUSTED * factor and moved <= SMALL_MOVEMENT:
        return ()
    if math.isnan(from_half):
        seen = "no equilibrium was found under half of these loads"
    else:
        share = 100.0 * 0.5 * factor / from_half
        seen = f"under half of these loads the stiffness against the shape is {share:.3g} % lower, in place of 50 %"
        seen += f", and the structure moves by {moved:.2g} of its size (or rad)"
    text = f"The load factor {factor:.6g} is no buckling load to rely on: {seen}, since it bends before it buckles."
    remedy = "Look for the load at which static_equilibrium(...) is no longer stable."
    return (found("bending-load", (), text, remedy, factor=factor, from_half=from_half, moved=moved),)


ASYMMETRY = 1e-6  # asymmetry of dK/ds over its largest entry, up to which it is that of differences
MISSED = 1e-6  # residual of an eigenvalue and its vector, relative to their product, up to which they are found
REMEDY = "Give them pretension if they are to count."  # sentence on contacts that are left out
EIGENVALUE_ROUND_OFF = 1e-9  # eigenvalue 1/s relative to the largest, below which it is round-off


@dataclass(frozen=True)
class Buckling:
    """Critical load factors and shapes; `print(buckling)` shows a table.

    Parameters
    ----------
    factors : (n,) factors on all loads at which the stiffness is lost: first those > 0, ascending, then those < 0 (all
        loads reversed), nearest to zero first.
    shapes : (n_q, n) buckling shapes, largest entry 1, rotations counted with the size of the model.
    names : (n_q,) names of the coordinates.
    aliases : other names of nodes.
    moves : (n,) name of the coordinate that each shape moves most.
    from_half : the first factor > 0 found again from the equilibrium under half of it, with large displacements: about
        the same where the structure keeps its shape until it buckles; inf where its stiffness does not fall; nan
        without an equilibrium or a factor > 0.
    findings : one where the two differ by more than a tenth, or the structure moves by more than a tenth of its size
        (or rad) under half of the factor, so that the factors cannot be relied on.
    left_out : names of contacts that do not carry without the loads, and so count as open.
    """

    factors: np.ndarray
    shapes: np.ndarray
    names: tuple[str, ...]
    aliases: dict[str, str]
    moves: tuple[str, ...]
    from_half: float = math.nan
    findings: tuple[Finding, ...] = ()
    left_out: tuple[str, ...] = ()

    @property
    def notes(self) -> tuple[str, ...]:
        """Sentences of the findings."""
        return sentences(self.findings)

    def shape(self, mode: int, name: str) -> float:
        """Amplitude of a coordinate, `name` "column.node3.y", in the shape of the number `mode`, from 0."""
        if not 0 <= checks.count("Buckling", "mode", mode, 0) < len(self.factors):
            raise InputError(f"Buckling: mode is {mode}; there are shapes 0 to {len(self.factors) - 1}.")
        place = resolve(name, self.aliases)
        return float(self.shapes[self.names.index(checks.one_of("Buckling", "coordinate", place, self.names)), mode])

    def __repr__(self) -> str:
        doubt = " (not to be relied on, see notes)" if self.notes else ""
        return f"Buckling: load factors {', '.join(f'{factor:.6g}' for factor in self.factors) or 'none'}{doubt}"

    def _repr_html_(self) -> str:
        rows = [(k, f"{f:.6g}", moves) for k, (f, moves) in enumerate(zip(self.factors, self.moves, strict=True))]
        table = display.table(rows, ("shape", "load factor", "moves most"))
        return display.page("Buckling", "", table, display.texts(self._remarks()))

    def __str__(self) -> str:
        """A table: number, factor, where it moves most; the notes; contacts that are left out."""
        rows = ["shape  load factor  moves most"]
        rows += [f"{k:5d}  {f:11.6g}  {self.moves[k]}" for k, f in enumerate(self.factors)]
        return "\n".join([*rows, *self._remarks()])

    def _remarks(self) -> tuple[str, ...]:
        return (*self.notes, *equilibrium.left_out_texts(self.left_out, REMEDY))


@arguments.checked
def buckling(mechanism: Mechanism, count: int = 4) -> Buckling:
    """Critical factors of the loads applied, when all of them grow together, gravity included.

    Loads are gravity and every part that is no body and whose elements keep no energy: `Force`, `Torque`, and elements
    of one's own without an energy kernel.  Springs belong to the structure, and so do cables, stops and other contacts
    that carry without the loads, such as guys under pretension, with their tangent stiffness; open ones are left out.
    Clearance joints are taken as ideal, drives are held.

    Equations (8.3) to (8.5) of docs/theory/equilibrium.md.

    Parameters
    ----------
    mechanism : the structure with its loads; closed and, but for contacts under pretension, free of stress in the
        reference configuration without them.
    count : number of factors > 0 and of factors < 0 at most.

    Raises
    ------
    InputError : no load; a structure with stress or open joints in the reference configuration without its loads;
        follower loads, whose stiffness is not symmetric.
    SolveError : a motion that nothing resists (named); the eigensolver did not converge.
    ModelError, AssemblyError : redundant joints (named), always or in the reference configuration.

    Notes
    -----
    With the displacements u and multipliers of the linear answer to the loads, K1 is the stiffness that its stresses,
    multipliers and loads add, per factor; (K0 + s K1) x = 0 with G x = 0.  Elements that only turn with u add nothing
    (`flexmb.statics.buckling`).
    Right for structures that carry their loads by normal forces and move little until they buckle.  What bends before
    may have no buckling load at all, such as a cantilever under a force across it.  So the first factor > 0 is compared
    with that of the equilibrium under half of it, equation (8.5); where they differ by more than a tenth, or the
    movement is no small one, `notes` says so, and `static_equilibrium(...).stable` finds the load.  Not for loads that
    make a structure flutter.  Thick struts of corotated plane bodies lack a part of the shear correction: 0.8 % too
    high at length over height 16, 2.8 % at 8.
    Source: R. D. Cook, D. S. Malkus, M. E. Plesha, R. J. Witt, Concepts and Applications of Finite Element Analysis,
    4th ed., Wiley 2002, chapter 18.
    """
    count = checks.count("buckling", "count", count)
    if not isinstance(mechanism, Mechanism):
        raise InputError(f"buckling: {mechanism!r} is not a Mechanism.")
    refuse_controllers(mechanism, "buckling", "loads that depend on the motion have no factor at which they buckle")
    kept = []  # without loads, which are no bodies and have elements that keep no energy beside signals
    for part in mechanism.parts:
        given = () if isinstance(part, Body) else mechanism.contributions_of(part)
        forces = [one for one in given if not isinstance(one, SignalContribution)]
        if not forces or any(not isinstance(one, ElementContribution) or one.energy is not None for one in forces):
            kept.append(part)
    bare = mechanism.with_loads(kept, (0.0, 0.0))
    program, loaded = (compile_mechanism(m, closed=True, touching=True) for m in (bare, mechanism))
    system = StateEvaluation(program)
    force, K_load = _loads(system, StateEvaluation(loaded), np.array(program.reference.q))
    if not np.abs(force).any():
        raise InputError(f"buckling: mechanism {mechanism.name!r} has no load. Add a Force, a Torque, or gravity.")
    q, lam = _without_loads(bare, program, system)
    force, K_load = _loads(system, StateEvaluation(loaded), q)
    K, G = system.at(q, lam=lam, weights=(1.0, 0.0, 0.0)).block(), system.jacobian
    left_out = equilibrium.open_contacts(system)
    path = system.solve(np.append(-force, np.zeros(program.n_c)), f"buckling of {program.name!r}")
    solve = _dense if program.n_q <= DENSE_COORDINATES else _sparse
    factors, x = solve(program, K, (geometric_stiffness(bare, system, q, lam, path) + K_load).tocsc(), G, count)
    x = x / np.abs(x * (program.length / program.sizes)[:, None]).max(axis=0, initial=0.0)
    names = program.names
    moves = tuple(moves_most(names.coordinates, program.length, shape) for shape in x.T)
    half, findings = math.nan, tuple[Finding, ...]()
    if len(factors) and factors[0] > 0.0:
        half, moved = factor_from_half(LoadPath(program, system, (q, lam), force, K_load), float(factors[0]), x[:, 0])
        findings = doubts(float(factors[0]), half, moved)
    return Buckling(factors, x, names.coordinates, names.aliases, moves, half, findings, left_out)


def _loads(system: StateEvaluation, loaded: StateEvaluation, q: np.ndarray) -> tuple[np.ndarray, sp.csc_matrix]:
    """Residual (n_q,) and stiffness (n_q, n_q) of the loads alone at coordinates q (n_q,)."""
    for one in (system, loaded):
        one.at(q, weights=(1.0, 0.0, 0.0))
    return loaded.force - system.force, (loaded.block() - system.block()).tocsc()


def _without_loads(bare: Mechanism, program: Program, system: StateEvaluation) -> tuple[np.ndarray, np.ndarray]:
    """Coordinates (n_q,), multipliers (n_c,) without loads: as drawn, where it must rest, or as contacts carry."""
    if len(program.names.contacts):
        q, lam, _ = equilibrium.at_rest(bare, program, system, 1, equilibrium.Spin(0.0, (0.0, 0.0)))
        if equilibrium.carries(system.at(q, lam=lam)).any():
            return q, lam
    q = np.array(program.reference.q)
    check_independent(program, q)
    if free := equilibrium.unresisted(program, system, q):
        raise SolveError(equilibrium.free_motion_error(program, free))
    system.at(q, weights=(1.0, 0.0, 0.0))
    step = system.solve(-np.append(system.force, system.residual), f"buckling of {program.name!r}")[: program.n_q]
    step = np.abs(step) / program.sizes
    if step.max() > 1e-9:
        text = f"buckling: without its loads mechanism {program.name!r} does not rest in the reference configuration;"
        text += f" it would move {program.names.coordinates[int(step.argmax())]!r} most."
        raise InputError(f"{text} Draw it closed, with springs at their free length.")
    return q, np.zeros(program.n_c)


def _dense(program: Program, K: Any, K_path: Any, G: Any, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Factors and shapes by a dense eigensolver on the null space of G."""
    Z = null_space(G.toarray())
    k, k_path = Z.T @ (K @ Z), Z.T @ (K_path @ Z)
    if np.abs(k_path - k_path.T).max(initial=0.0) > ASYMMETRY * np.abs(k_path).max(initial=0.0):
        text = f"buckling: the loads of mechanism {program.name!r} follow its motion, so its stiffness is not symmetric"
        text += " and it may flutter before it buckles."
        raise InputError(f"{text} Use modes(at=static_equilibrium(...)) at growing loads.")
    try:
        inverse, y = scipy.linalg.eigh(-(k_path + k_path.T) / 2.0, (k + k.T) / 2.0)
    except scipy.linalg.LinAlgError as error:
        raise SolveError(_unstable(program)) from error
    places = _order(inverse, count)
    return 1.0 / inverse[places], Z @ y[:, places]


def _sparse(program: Program, K: Any, K_path: Any, G: Any, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Factors and shapes from the largest eigenvalues of -K^-1 dK/ds with G x = 0."""
    n, m, scale, order = K.shape[0], G.shape[0], abs(K).max(), program.symbolic.order
    solve = solver(sp.block_array([[K / scale, G.T], [G, None]]).tocsc(), order)

    def held(force: np.ndarray) -> np.ndarray:
        """K^-1 on the null space of G."""
        return solve(np.append(force / scale, np.zeros(m)))[:n]

    def beyond(inverse: float) -> int | None:
        """Number of factors between 0 and 1/inverse."""
        return negative_eigenvalues(K + K_path / inverse, G, order)

    def inverses(x: np.ndarray) -> np.ndarray:
        """1/s times x, on the null space of G."""
        return -held(K_path @ x)

    symmetric = abs(K_path - K_path.T).max() <= ASYMMETRY * abs(K_path).max()
    if symmetric and is_stable(program, K, G) is False:
        raise SolveError(_unstable(program))
    try:
        inverse, x = np.zeros(1), np.full((n, 1), np.nan)
        if symmetric:
            inverse, x = largest_of_pencil((K_path + K_path.T) / -2.0, (K + K.T) / 2.0, held, count, beyond)
        # loads of low rank leave Lanczos' method too few vectors: the other one then finds them
        off = [np.abs(inverses(v) - w * v).max() / np.abs(w * v).max() for w, v in zip(inverse, x.T, strict=True)]
        if not (symmetric and max(off) <= MISSED and (x * (K @ x)).sum(axis=0).min() > 0.0):
            inverse, x = largest_of(inverses, n, min(4 * count + 4, n // 4))
    except (sp.linalg.ArpackNoConvergence, RuntimeError) as error:
        raise SolveError(f"buckling: the eigensolver did not converge ({error}). Ask for fewer factors.") from error
    if np.abs(inverse.imag).max() > 1e-6 * np.abs(inverse).max():
        raise SolveError(_unstable(program))
    places = _order(inverse.real, count)
    return 1.0 / inverse.real[places], x[:, places].real


def _unstable(program: Program) -> str:
    text = f"buckling: mechanism {program.name!r} without its loads is not stable in the reference configuration,"
    return f"{text} or its loads follow its motion; no load factors exist."


def _order(inverse: np.ndarray, count: int) -> np.ndarray:
    """Places of the chosen 1/s: s > 0 ascending, then s < 0 from zero down."""
    real = np.abs(inverse) > EIGENVALUE_ROUND_OFF * np.abs(inverse).max(initial=0.0)
    up, down = np.flatnonzero(real & (inverse > 0.0)), np.flatnonzero(real & (inverse < 0.0))
    up, down = up[np.argsort(-inverse[up])][:count], down[np.argsort(inverse[down])][:count]
    return np.concatenate([up, down])
