"""Work arrays of the method of Dormand and Prince of order 8(5,3), with its coefficients.

Sources: E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd ed., Springer 1993,
II.5 (method), II.6 (dense output of order 7) and II.10 (error estimate); the numbers are those of their code DOP853.
"""

from __future__ import annotations

import numpy as np

from flexmb.engine.compiled.records import Matrix, Record, Vector
from flexmb.engine.dormand_prince.complement import Complement, complement
from flexmb.engine.radau.collocation import StateVectors, Works, state_vectors
from flexmb.engine.system.work import new_from_template
from flexmb.late import scipy
from flexmb.program.program import Program

# Number of stages of a step, and with the end of the step and the three stages of the dense output.
STEP_STAGES, ALL_STAGES = 12, 16
# Numbers of the stages that are the start and the end of the step.
START, END = 0, STEP_STAGES
FIFTH, THIRD = range(2)  # rows of `Stages.errors`

LEDGER = 11  # number of the energies of a ledger
DENSE = 7  # number of coefficients of the dense output


class Span(Record):
    """Start and size of the last step [s]; 1 with its dense output, 1 where the state is of another method."""

    start: float
    size: float
    dense: int
    foreign: int


class Stages(Record):
    """Stages of a step, and its workspace."""

    span: Span
    complement: Complement
    works: Works
    old: StateVectors  # old, between: start of the last step, and an instant within it
    between: StateVectors
    tableau: Matrix  # (16, 16) weights of the stages f_i = f(t + C_i h, y0 + h sum_j A_ij f_j); row 12: of the step
    instants: Vector  # (16,) C
    errors: Matrix  # (2, 12) weights of the error estimates of order 5 and 3
    weights: Matrix  # (4, 16) weights of the last four coefficients of the dense output
    Q: Matrix  # Q, V, A: (16, n_q + 3) positions, velocities and accelerations of the stages
    V: Matrix
    A: Matrix
    L: Matrix  # (16, n_c) multipliers
    rates: Matrix  # (16, 11) rates of the ledger at the stages [W]
    of_q: Matrix  # of_q, of_v, of_ledger: (7, ...) coefficients of the dense output
    of_v: Matrix
    of_ledger: Matrix
    error_q: Vector  # error_q, error_v: (n_q + 3,) errors, and other sums over the stages
    error_v: Vector
    x: Vector  # x, y: (n_q + n_c,), pair : (2 (n_q + n_c),)
    y: Vector
    pair: Vector
    losses: Matrix  # (0, 2) none, since there are no contacts
    zero: Vector  # (n_q + 3,)
    signals: Vector  # (n_y,) at an instant within


def new_stages(program: Program) -> Stages:
    """Work arrays for a compiled mechanism."""
    return new_from_template(program, "stages", lambda: _zero_stages(program), complement=complement(program))


def _zero_stages(program: Program) -> Stages:
    n, m, method = program.n_q + 3, program.n_c, scipy.integrate.DOP853
    A = np.zeros((ALL_STAGES, ALL_STAGES))
    A[:END, :END], A[END, :END], A[END + 1 :] = method.A, method.B, method.A_EXTRA
    return Stages(
        span=Span.zeros(), complement=complement(program), works=Works.zeros(), old=state_vectors(program),
        between=state_vectors(program), tableau=A, instants=np.minimum(A.sum(axis=1), 1.0),
        errors=np.array([method.E5[:STEP_STAGES], method.E3[:STEP_STAGES]]), weights=method.D.copy(),
        **dict.fromkeys(("Q", "V", "A"), (ALL_STAGES, n)), L=(ALL_STAGES, m), rates=(ALL_STAGES, LEDGER),
        **dict.fromkeys(("of_q", "of_v"), (DENSE, n)), of_ledger=(DENSE, LEDGER),
        **dict.fromkeys(("error_q", "error_v", "zero"), n), **dict.fromkeys(("x", "y"), program.n_q + m),
        pair=2 * (program.n_q + m), losses=(0, 2), signals=program.tables.sizes.n_y,
    )  # fmt: skip
