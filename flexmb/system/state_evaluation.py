"""Evaluation of a program at one state, for solvers in Python: forces, residuals, matrices."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from flexmb.errors import USER_ERRORS, KernelError, SolveError
from flexmb.linalg import lu
from flexmb.linalg.dense import solve_dense
from flexmb.linalg.dense_or_sparse import DENSE_UNKNOWNS
from flexmb.linalg.pivoting import PivotingSolver
from flexmb.program.program import Program
from flexmb.system.evaluate import evaluate
from flexmb.system.failed_kernels import Instant, failed_kernel
from flexmb.system.work import Work, workspace

if TYPE_CHECKING:
    import scipy.sparse as sp


Vector = Sequence[float] | np.ndarray

UNPIVOTED_UNKNOWNS = 10_000
"""Number of unknowns above which a linear system is first solved without pivoting, in a sixth of the time."""

MOST_REFINEMENTS, REFINED_RESIDUAL = 4, 1e-11
"""Number of refinements at most, and their residual relative to the right-hand side."""


class StateEvaluation:
    """Evaluation of a program at one state; returned arrays are copies.

    Parameters
    ----------
    program : the compiled mechanism.
    work : workspace of the program, which is overwritten; None: a new one.
    """

    def __init__(self, program: Program, work: Work | None = None) -> None:
        self.program = program
        self.work: Work = work or workspace(program)
        self._pattern = program.symbolic
        self.small = self._pattern.n <= DENSE_UNKNOWNS
        self._instant: Instant | None = None

    @cached_property
    def _solver(self) -> PivotingSolver:
        return PivotingSolver(self._pattern)

    def at(
        self,
        q: Vector,
        v: Vector | None = None,
        a: Vector | None = None,
        lam: Vector | None = None,
        *,
        t: float = 0.0,
        z: Vector | None = None,
        weights: Vector = (0.0, 0.0, 0.0),
    ) -> StateEvaluation:
        """Evaluate at a state (n_q,); `weights`: factors of stiffness, damping and mass in the matrix.

        The last three entries of arrays with n_q + 3 entries are the motion of the ground, else at rest.

        Raises
        ------
        KernelError : a kernel of a part raises an exception at this state.
        """
        n, m = self.program.n_q, self.program.n_c
        state = _padded(q, n), _padded(v, n), _padded(a, n)
        lam = np.zeros(m) if lam is None else np.ascontiguousarray(lam, dtype=float)
        z = self.program.reference.z if z is None else z
        z = np.array(z)
        tables, address = self.program.tables, self.program.addresses
        self._instant = Instant(float(t), 0.0, *state, lam, z)
        try:
            evaluate(tables, address, float(t), 0.0, *state, lam, z, *map(float, weights), True, self.work)
        except USER_ERRORS as error:
            self.refuse_failed_kernel(error)
            raise
        return self

    def refuse_failed_kernel(self, error: Exception | None = None) -> None:
        """Raise `KernelError` if a kernel raises or is not finite at the state that was evaluated last."""
        failed = None if self._instant is None else failed_kernel(self.program, [self._instant])
        if failed is not None:
            raise KernelError(str(failed)) from error

    @property
    def force(self) -> np.ndarray:
        """Residual r (n_q,): inertia less applied forces, without constraint forces."""
        return self.work.r[: self.program.n_q].copy()

    @property
    def constraint_force(self) -> np.ndarray:
        """G^T lam (n_q,)."""
        return self.work.Gl[: self.program.n_q].copy()

    @property
    def residual(self) -> np.ndarray:
        """g (n_c,)."""
        return self.work.g.copy()

    @property
    def velocity_residual(self) -> np.ndarray:
        """G v + g_t (n_c,)."""
        return self.work.gv.copy()

    @property
    def gamma(self) -> np.ndarray:
        """Right side of G a = gamma (n_c,)."""
        return self.work.gamma.copy()

    @property
    def matrix(self) -> sp.csc_matrix:
        """[[weighted K, C, M, G^T], [G, 0]] (n, n)."""
        import scipy.sparse as sp  # noqa: PLC0415 - large models alone need it, and it takes long to import

        pattern = self._pattern
        values = self.work.lu[pattern.places]
        return sp.csc_matrix((values, (pattern.a_rows, pattern.a_cols)), shape=(pattern.n, pattern.n))

    @property
    def dense(self) -> np.ndarray:
        """`matrix` as a plain array."""
        pattern = self._pattern
        A = np.zeros((pattern.n, pattern.n))
        A[pattern.a_rows, pattern.a_cols] = self.work.lu[pattern.places]
        return A

    def block(self) -> sp.csc_matrix:
        """The upper left block (n_q, n_q) of the matrix."""
        n = self.program.n_q
        return self.matrix[:n, :n].tocsc()

    @property
    def jacobian(self) -> sp.csr_matrix:
        """G (n_c, n_q)."""
        n = self.program.n_q
        return self.matrix.tocsr()[n:, :n]

    @property
    def blocks(self) -> tuple[np.ndarray, np.ndarray] | tuple[sp.csc_matrix, sp.csr_matrix]:
        """`block()` and `jacobian`; plain arrays for at most DENSE_UNKNOWNS unknowns (see `dense_or_sparse.py`)."""
        n = self.program.n_q
        if self.small:
            A = self.dense
            return A[:n, :n], A[n:, :n]
        A = self.matrix.tocsr()
        return A[:n, :n].tocsc(), A[n:, :n]

    def solve(self, b: np.ndarray, purpose: str) -> np.ndarray:
        """Solve with the present matrix, with pivoting.

        Raises
        ------
        SolveError : a singular matrix.
        KernelError : a kernel that is not finite at this state.
        """
        found = self._without_pivoting(b) if self._pattern.n > UNPIVOTED_UNKNOWNS else None
        if found is not None:
            return found
        try:
            return solve_dense(self.dense, b) if self.small else self._solver.factor(self.work.lu).solve(b)
        except SolveError as error:
            self.refuse_failed_kernel(error)
            raise SolveError(f"{purpose}: {error}") from error

    def _without_pivoting(self, b: np.ndarray) -> np.ndarray | None:
        """Solve by the factors of the time loop with iterative refinement; None if more than round-off remains."""
        n, sym, values = self._pattern.n, lu.tables(self._pattern), self.work.lu.copy()
        seen, x, left, shift, spare = (np.zeros(n) for _ in range(5))
        if lu.factor(sym, values, seen, lu.LOST_PIVOT) >= 0:
            return None
        size = np.abs(b).max(initial=0.0)
        for _ in range(MOST_REFINEMENTS):
            lu.multiply(sym, self.work.lu, x, left)
            left = b - left
            if np.abs(left).max(initial=0.0) <= REFINED_RESIDUAL * size:
                return x
            lu.solve(sym, values, left, shift, spare)
            x += shift
        return None

    def mass(self, q: np.ndarray) -> sp.csc_matrix:
        """M (n_q, n_q) at positions q."""
        return self.at(q, weights=(0.0, 0.0, 1.0)).block()


def _padded(x: Vector | None, n: int) -> np.ndarray:
    full = np.zeros(n + 3)
    if x is not None:
        full[: len(x)] = x
    return full
