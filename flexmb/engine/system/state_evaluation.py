"""Evaluation of a program at one state, for solvers in Python: forces, residuals, matrices."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from flexmb.engine.linalg.dense import DENSE_UNKNOWNS, PivotingSolver, solve_dense
from flexmb.engine.linalg.kept_factors import KeptFactors
from flexmb.engine.system.evaluate import evaluate
from flexmb.engine.system.failed_kernels import Instant, failed_kernel
from flexmb.engine.system.work import Work, workspace
from flexmb.errors import USER_ERRORS, KernelError, SolveError
from flexmb.program.program import Program

if TYPE_CHECKING:
    import scipy.sparse as sp

Vector = Sequence[float] | np.ndarray

LARGE_UNKNOWNS = 1000
"""Number of unknowns above which the factors of a matrix are kept for the next ones."""


class StateEvaluation:
    """Evaluation of a program at one state, in a workspace that is overwritten; returned arrays are copies."""

    def __init__(self, program: Program, work: Work | None = None) -> None:
        self.program = program
        self.work: Work = work or workspace(program)
        self._pattern = program.symbolic
        self.small = self._pattern.n <= DENSE_UNKNOWNS
        self._instant: Instant | None = None

    @cached_property
    def _solver(self) -> PivotingSolver:
        return (KeptFactors if self._pattern.n > LARGE_UNKNOWNS else PivotingSolver)(self._pattern)

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
            raise KernelError(failed.text) from error

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
        """`block()` and `jacobian`; plain arrays for at most DENSE_UNKNOWNS unknowns (see `engine/linalg/dense.py`)."""
        n = self.program.n_q
        if self.small:
            A = self.dense
            return A[:n, :n], A[n:, :n]
        A = self.matrix.tocsr()
        return A[:n, :n].tocsc(), A[n:, :n]

    def solve(self, b: np.ndarray, purpose: str, accuracy: float = 0.0) -> np.ndarray:
        """Solve with the present matrix, with pivoting, for a right-hand side (n,).

        `accuracy` is the error of the solution that suffices, relative to its largest entry; 0: round-off.
        """
        try:
            if self.small:
                return solve_dense(self.dense, b)
            solver = self._solver.factor(self.work.lu)
            return solver.solve(b, accuracy) if isinstance(solver, KeptFactors) else solver.solve(b)
        except SolveError as error:
            self.refuse_failed_kernel(error)
            raise SolveError(f"{purpose}: {error}") from error

    def is_regular(self) -> bool:
        """Whether the present matrix maps no vector to round-off beyond doubt; False for a small one without a look."""
        if self._pattern.n <= LARGE_UNKNOWNS:
            return False
        solver = self._solver.factor(self.work.lu)
        return isinstance(solver, KeptFactors) and solver.is_regular()

    def mass(self, q: np.ndarray) -> sp.csc_matrix:
        """M (n_q, n_q) at positions q."""
        return self.at(q, weights=(0.0, 0.0, 1.0)).block()


def _padded(x: Vector | None, n: int) -> np.ndarray:
    full = np.zeros(n + 3)
    if x is not None:
        full[: len(x)] = x
    return full
