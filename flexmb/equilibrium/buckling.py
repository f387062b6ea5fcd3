"""Linear buckling: the factors by which all loads must grow until a structure loses its stiffness."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp
from scipy.sparse.linalg import ArpackNoConvergence

from flexmb import arguments, checks
from flexmb.display import html
from flexmb.equilibrium.carrying import carries, left_out_text, open_contacts
from flexmb.equilibrium.eigen import DENSE_COORDINATES, largest_of, largest_of_pencil
from flexmb.equilibrium.free_motions import moves_most, null_space
from flexmb.equilibrium.geometric_stiffness import geometric_stiffness
from flexmb.equilibrium.half_load import LoadPath, factor_from_half, trust_note
from flexmb.equilibrium.stability import is_stable
from flexmb.equilibrium.statics import at_rest, refuse_free_motion
from flexmb.equilibrium.steady_rotation import Spin
from flexmb.errors import InputError, SolveError
from flexmb.linalg.bordered import negative_eigenvalues, solver
from flexmb.model.contributions import ElementContribution, SignalContribution
from flexmb.model.controller import refuse_controllers
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import Body, Part
from flexmb.program.compiler import compile as compile_mechanism
from flexmb.program.program import Program, resolve
from flexmb.system.state_evaluation import StateEvaluation

ASYMMETRY = 1e-6
"""Asymmetry of dK/ds over its largest entry, up to which it is that of differences."""

MISSED = 1e-6
"""Residual of an eigenvalue and its vector, relative to their product, up to which they are found."""

REMEDY = "Give them pretension if they are to count."
"""Sentence on contacts that are left out."""

EIGENVALUE_ROUND_OFF = 1e-9
"""Eigenvalue 1/s relative to the largest, below which it is round-off."""


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
    notes : a sentence where the two differ by more than a tenth, or the structure moves by more than a tenth of its
        size (or rad) under half of the factor, so that the factors cannot be relied on.
    left_out : names of contacts that do not carry without the loads, and so count as open.
    """

    factors: np.ndarray
    shapes: np.ndarray
    names: tuple[str, ...]
    aliases: dict[str, str]
    moves: tuple[str, ...]
    from_half: float = math.nan
    notes: tuple[str, ...] = ()
    left_out: tuple[str, ...] = ()

    def shape(self, mode: int, name: str) -> float:
        """Amplitude of a coordinate in a shape.

        Parameters
        ----------
        mode : number of the shape, from 0.
        name : the coordinate, e.g. "column.node3.y".
        """
        if not 0 <= checks.count("Buckling", "mode", mode, 0) < len(self.factors):
            raise InputError(f"Buckling: mode is {mode}; there are shapes 0 to {len(self.factors) - 1}.")
        place = resolve(name, self.aliases)
        return float(self.shapes[self.names.index(checks.one_of("Buckling", "coordinate", place, self.names)), mode])

    def __repr__(self) -> str:
        doubt = " (not to be relied on, see notes)" if self.notes else ""
        return f"Buckling: load factors {', '.join(f'{factor:.6g}' for factor in self.factors) or 'none'}{doubt}"

    def _repr_html_(self) -> str:
        rows = [(k, f"{f:.6g}", moves) for k, (f, moves) in enumerate(zip(self.factors, self.moves, strict=True))]
        table = html.table(rows, ("shape", "load factor", "moves most"))
        remarks = self._remarks()
        return html.page("Buckling", "", table, html.texts(remarks) if remarks else "")

    def __str__(self) -> str:
        """A table: number, factor, where it moves most; the notes; contacts that are left out."""
        rows = ["shape  load factor  moves most"]
        rows += [f"{k:5d}  {f:11.6g}  {self.moves[k]}" for k, f in enumerate(self.factors)]
        return "\n".join([*rows, *self._remarks()])

    def _remarks(self) -> tuple[str, ...]:
        return (*self.notes, *([left_out_text(self.left_out, REMEDY)] if self.left_out else []))


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

    Notes
    -----
    With the displacements u and multipliers of the linear answer to the loads, K1 is the stiffness that its stresses,
    multipliers and loads add, per factor; (K0 + s K1) x = 0 with G x = 0.  Elements that only turn with u add nothing
    (`flexmb.equilibrium.geometric_stiffness`).
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
    bare = unloaded(mechanism)
    program, loaded = (compile_mechanism(m, closed=True, touching=True) for m in (bare, mechanism))
    system = StateEvaluation(program)
    force, K_load = _loads(system, StateEvaluation(loaded), np.array(program.reference.q))
    if not np.abs(force).any():
        raise InputError(f"buckling: mechanism {mechanism.name!r} has no load. Add a Force, a Torque, or gravity.")
    q, lam = _without_loads(bare, program, system)
    force, K_load = _loads(system, StateEvaluation(loaded), q)
    K, G = system.at(q, lam=lam, weights=(1.0, 0.0, 0.0)).block(), system.jacobian
    left_out = open_contacts(system)
    path = system.solve(np.append(-force, np.zeros(program.n_c)), f"buckling of {program.name!r}")
    K_path = (geometric_stiffness(bare, system, q, lam, path) + K_load).tocsc()
    solve = _dense if program.n_q <= DENSE_COORDINATES else _sparse
    factors, x = solve(program, K, K_path, G, count)
    x = x / np.abs(x * _sizes(program)[:, None]).max(axis=0, initial=0.0)
    names = program.names
    moves = tuple(moves_most(names.coordinates, program.length, shape) for shape in x.T)
    if not (len(factors) and factors[0] > 0.0):
        return Buckling(factors, x, names.coordinates, names.aliases, moves, left_out=left_out)
    first = float(factors[0])
    half, moved = factor_from_half(LoadPath(program, system, (q, lam), force, K_load), first, x[:, 0])
    notes = tuple(filter(None, [trust_note(first, half, moved)]))
    return Buckling(factors, x, names.coordinates, names.aliases, moves, half, notes, left_out)


def _loads(system: StateEvaluation, loaded: StateEvaluation, q: np.ndarray) -> tuple[np.ndarray, sp.csc_matrix]:
    """Residual (n_q,) and stiffness (n_q, n_q) of the loads alone at coordinates q (n_q,)."""
    for one in (system, loaded):
        one.at(q, weights=(1.0, 0.0, 0.0))
    return loaded.force - system.force, (loaded.block() - system.block()).tocsc()


def _without_loads(bare: Mechanism, program: Program, system: StateEvaluation) -> tuple[np.ndarray, np.ndarray]:
    """Coordinates (n_q,), multipliers (n_c,) without loads: the reference configuration, or where contacts carry."""
    if len(program.names.contacts):
        q, lam, _ = at_rest(bare, program, system, 1, Spin(0.0, (0.0, 0.0)))
        if carries(system.at(q, lam=lam)).any():
            return q, lam
    q = np.array(program.reference.q)
    refuse_free_motion(program, system, q)
    _refuse_stress(program, system, q)
    return q, np.zeros(program.n_c)


def unloaded(mechanism: Mechanism) -> Mechanism:
    """The mechanism without gravity and without the parts that are loads."""
    return mechanism.with_loads([part for part in mechanism.parts if not is_load(part, mechanism)], (0.0, 0.0))


def is_load(part: Part, mechanism: Mechanism) -> bool:
    """Whether a part is no body and has elements, none of which keeps energy, beside signals alone."""
    found = () if isinstance(part, Body) else mechanism.contributions_of(part)
    forces = [one for one in found if not isinstance(one, SignalContribution)]
    return bool(forces) and all(isinstance(one, ElementContribution) and one.energy is None for one in forces)


def _refuse_stress(program: Program, system: StateEvaluation, q: np.ndarray) -> None:
    """Refuse a structure that forces or open joints would move from its reference configuration without loads."""
    system.at(q, weights=(1.0, 0.0, 0.0))
    step = system.solve(-np.append(system.force, system.residual), f"buckling of {program.name!r}")[: program.n_q]
    step = np.abs(step) * _sizes(program) / program.length
    if step.max() > 1e-9:
        raise InputError(
            f"buckling: without its loads mechanism {program.name!r} does not rest in the reference configuration; "
            f"it would move {program.names.coordinates[int(step.argmax())]!r} most. "
            "Draw it closed, with springs at their free length."
        )


def _sizes(program: Program) -> np.ndarray:
    """Factors (n_q,) that turn coordinates into lengths [m]."""
    return np.where(program.tables.kind == 1, program.length, 1.0)


def _dense(program: Program, K: Any, K_path: Any, G: Any, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Factors and shapes by a dense eigensolver on the null space of G."""
    Z = null_space(G.toarray())
    k, k_path = Z.T @ (K @ Z), Z.T @ (K_path @ Z)
    scale = np.abs(k_path).max(initial=0.0)
    if np.abs(k_path - k_path.T).max(initial=0.0) > ASYMMETRY * scale:
        raise InputError(
            f"buckling: the loads of mechanism {program.name!r} follow its motion, so its stiffness is not symmetric "
            f"and it may flutter before it buckles. Use modes(at=static_equilibrium(...)) at growing loads."
        )
    try:
        inverse, y = la.eigh(-(k_path + k_path.T) / 2.0, (k + k.T) / 2.0)
    except la.LinAlgError as error:
        raise SolveError(_unstable(program)) from error
    places = _order(inverse, count)
    return 1.0 / inverse[places], Z @ y[:, places]


def _sparse(program: Program, K: Any, K_path: Any, G: Any, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Factors and shapes from the largest eigenvalues of -K^-1 dK/ds with G x = 0."""
    n, m = K.shape[0], G.shape[0]
    scale, order = abs(K).max(), program.symbolic.order
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

    wanted = min(4 * count + 4, n // 4)
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
            inverse, x = largest_of(inverses, n, wanted)
    except (ArpackNoConvergence, RuntimeError) as error:
        raise SolveError(f"buckling: the eigensolver did not converge ({error}). Ask for fewer factors.") from error
    if np.abs(inverse.imag).max() > 1e-6 * np.abs(inverse).max():
        raise SolveError(_unstable(program))
    places = _order(inverse.real, count)
    return 1.0 / inverse.real[places], x[:, places].real


def _unstable(program: Program) -> str:
    return (
        f"buckling: mechanism {program.name!r} without its loads is not stable in the reference configuration, "
        "or its loads follow its motion; no load factors exist."
    )


def _order(inverse: np.ndarray, count: int) -> np.ndarray:
    """Places of the chosen 1/s: s > 0 ascending, then s < 0 from zero down."""
    real = np.abs(inverse) > EIGENVALUE_ROUND_OFF * np.abs(inverse).max(initial=0.0)
    up, down = np.flatnonzero(real & (inverse > 0.0)), np.flatnonzero(real & (inverse < 0.0))
    up, down = up[np.argsort(-inverse[up])][:count], down[np.argsort(inverse[down])][:count]
    return np.concatenate([up, down])
