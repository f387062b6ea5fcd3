"""Natural frequencies and modes of the linearised mechanism."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp
from scipy.sparse.linalg import ArpackNoConvergence, eigsh

from flexmb import checks
from flexmb.errors import InputError, SolveError
from flexmb.model.mechanism import Mechanism
from flexmb.program.compiler import compile as compile_mechanism
from flexmb.program.program import Program, resolve
from flexmb.solve.assemble import close_loops
from flexmb.solve.statics import Equilibrium
from flexmb.solve.system import System

DENSE = 1500
"""Up to so many coordinates all modes are computed by a dense eigensolver."""

ASYMMETRY = 1e-11
"""A difference of stiffnesses beyond the diagonal, over the largest, that is more than round-off."""

RIGID = 1e-6
"""Frequencies below this part of the largest one computed are those of rigid motions."""


@dataclass(frozen=True)
class Modes:
    """Undamped modes about a pose, drives held fast.

    Parameters
    ----------
    frequencies : (n,) natural frequencies [Hz], ascending; 0 for a rigid motion, negative for an unstable one
        (-sqrt(|omega^2|)/2 pi).
    shapes : (n_q, n) mode shapes, normalised to x^T M x = 1.
    names : (n_q,) names of the coordinates.
    aliases : other names of nodes.
    rigid : number of modes at zero frequency.
    """

    frequencies: np.ndarray
    shapes: np.ndarray
    names: tuple[str, ...]
    aliases: dict[str, str]
    rigid: int

    def shape(self, mode: int, name: str) -> float:
        """Amplitude of a coordinate in a mode.

        Parameters
        ----------
        mode : number of the mode, from 0.
        name : the coordinate, e.g. "rod.node3.y".
        """
        if not 0 <= mode < self.shapes.shape[1]:
            raise InputError(f"Modes: mode is {mode}; there are modes 0 to {self.shapes.shape[1] - 1}.")
        place = resolve(name, self.aliases)
        return float(self.shapes[self.names.index(checks.one_of("Modes", "coordinate", place, self.names)), mode])


def modes(mechanism: Mechanism, count: int = 10, at: Equilibrium | None = None) -> Modes:
    """Natural frequencies and modes of small motions about the drawn pose, or about a static equilibrium.

    Clearance joints are taken as ideal, drives hold their position.  Stiffness is that of the pose, geometric and load
    stiffness included when `at` is given.

    Parameters
    ----------
    mechanism : the mechanism.
    count : number of modes, lowest first.
    at : a static equilibrium of the same mechanism (with ideal joints).

    Raises
    ------
    InputError : an equilibrium of another model.
    SolveError : the eigensolver did not converge; a stiffness that is not symmetric, as follower forces make it.
    """
    checks.count("modes", "count", count)
    program = compile_mechanism(mechanism, closed=True)
    system = System(program)
    if at is None:
        q, lam = close_loops(program, {})[0], None
    else:
        if len(at.q) != program.n_q or len(at.lam) != program.n_c:
            raise InputError(
                f"modes: the equilibrium has {len(at.q)} coordinates, the model {program.n_q}. Use its own."
            )
        q, lam = at.q, at.lam
    M = system.mass(q)
    K = system.at(q, lam=lam, weights=(1.0, 0.0, 0.0)).block()
    refuse_asymmetry(program, K)
    G = system.jacobian
    solve = _dense if program.n_q <= DENSE else _sparse
    squares, shapes = solve(K, M, G, count)
    reference = np.abs(squares).max(initial=0.0)
    squares = np.where(np.abs(squares) <= RIGID**2 * reference, 0.0, squares)
    frequencies = np.sign(squares) * np.sqrt(np.abs(squares)) / (2.0 * np.pi)
    rigid = int((squares == 0.0).sum())
    return Modes(frequencies[:count], shapes[:, :count], program.names.coordinates, program.names.aliases, rigid)


def refuse_asymmetry(program: Program, K: sp.csc_matrix) -> None:
    """`SolveError` for forces without a potential: their modes are complex, and may grow."""
    difference = sp.coo_array(abs(K - K.T))
    worst = int(difference.data.argmax()) if difference.nnz else -1
    if worst < 0 or difference.data[worst] <= ASYMMETRY * abs(K).max():
        return
    row, column = (program.names.coordinates[int(k[worst])] for k in (difference.row, difference.col))
    raise SolveError(
        f"modes: the stiffness of mechanism {program.name!r} is not symmetric between {row!r} and {column!r}, so it "
        "has no real modes. A follower force does this: give modes a dead one, or simulate to see whether it flutters."
    )


def _dense(K: sp.csc_matrix, M: sp.csc_matrix, G: sp.csr_matrix, _count: int) -> tuple[np.ndarray, np.ndarray]:
    """All eigenvalues on the null space of G."""
    Z = la.null_space(G.toarray(), rcond=1e-10) if G.shape[0] else np.eye(K.shape[0])
    if Z.shape[1] == 0:
        return np.zeros(0), np.zeros((K.shape[0], 0))
    k, m = Z.T @ K @ Z, Z.T @ M @ Z
    try:
        squares, y = la.eigh((k + k.T) / 2.0, (m + m.T) / 2.0)
    except la.LinAlgError as error:
        raise SolveError("modes: a motion without mass; give every body and node some mass and inertia.") from error
    return squares, Z @ y


def _sparse(K: sp.csc_matrix, M: sp.csc_matrix, G: sp.csr_matrix, count: int) -> tuple[np.ndarray, np.ndarray]:
    """The lowest eigenvalues by shift and invert of the bordered matrices."""
    n, m = K.shape[0], G.shape[0]
    scale = abs(K).max()
    A = sp.block_array([[(K + K.T) / 2.0, scale * G.T], [scale * G, None]]).tocsc()
    B = sp.block_diag([M, sp.csc_matrix((m, m))]).tocsc()
    shift = -1e-6 * scale / abs(M).max()
    try:
        squares, x = eigsh(A, k=min(count, n - m - 1), M=B, sigma=shift, which="LM", v0=np.ones(n + m))
    except (ArpackNoConvergence, RuntimeError) as error:
        raise SolveError(f"modes: the eigensolver did not converge ({error}). Ask for fewer modes.") from error
    order = np.argsort(squares)
    return squares[order], x[:n, order]
