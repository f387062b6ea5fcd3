"""Coefficients and work arrays of Radau's method with three stages (Radau IIA, order 5).

Stages lie at t + c_i h.  With the matrix A of the method and its inverse D, positions Q_i, rates V_i, A_i satisfy

    h V_i = sum_j D_ij (Q_j - q0),   h A_i = sum_j D_ij (V_j - v0).

D has a real eigenvalue and a complex pair; in its eigenvectors the linear system of the three stages splits into a real
and a complex one.  Source: E. Hairer, G. Wanner, Solving Ordinary Differential Equations II (1996), IV.5 and IV.8.
"""

import numpy as np

from flexmb.engine.compiled.records import Matrix, Record, Vector
from flexmb.program.program import Program

STAGES = 3
# Numbers of stages.
MIDDLE, LAST = 1, 2
AT_START, AT_END, ELSEWHERE = range(3)  # rows of `Collocation.rates`
_ROOT = 6.0**0.5
_C = np.array([(4.0 - _ROOT) / 10.0, (4.0 + _ROOT) / 10.0, 1.0])
_A = np.array(
    [
        [(88.0 - 7.0 * _ROOT) / 360.0, (296.0 - 169.0 * _ROOT) / 1800.0, (-2.0 + 3.0 * _ROOT) / 225.0],
        [(296.0 + 169.0 * _ROOT) / 1800.0, (88.0 + 7.0 * _ROOT) / 360.0, (-2.0 - 3.0 * _ROOT) / 225.0],
        [(16.0 - _ROOT) / 36.0, (16.0 + _ROOT) / 36.0, 1.0 / 9.0],
    ]
)
_VALUES, _VECTORS = np.linalg.eig(np.linalg.inv(_A))
_ORDER = [int(np.argmin(abs(_VALUES.imag))), int(np.argmax(_VALUES.imag))]
_INVERSE = np.linalg.inv(_VECTORS)


def _numbers(array: np.ndarray) -> tuple[float, ...]:
    return tuple(float(x) for x in array)


C, WEIGHTS = _numbers(_C), _numbers(_A[2])
# Coefficients of V_i = v0 + h sum ONCE_ij A_j and Q_i = q0 + c_i h v0 + h^2 sum TWICE_ij A_j.
ONCE, TWICE = tuple(map(_numbers, _A)), tuple(map(_numbers, _A @ _A))
REAL = float(_VALUES[_ORDER[0]].real)
# Eigenvalues of D: REAL, and PAIR_RE + i PAIR_IM with its conjugate.
PAIR_RE, PAIR_IM = float(_VALUES[_ORDER[1]].real), float(_VALUES[_ORDER[1]].imag)
TO_REAL, FROM_REAL = _numbers(_INVERSE[_ORDER[0]].real), _numbers(_VECTORS[:, _ORDER[0]].real)
TO_RE, TO_IM = _numbers(_INVERSE[_ORDER[1]].real), _numbers(_INVERSE[_ORDER[1]].imag)
# Transformation into the eigenvectors and back: w = TO . Q, Q_i = FROM_REAL_i w_1 + Re((a_i + i b_i) w_2).
FROM_RE, FROM_IM = _numbers(2.0 * _VECTORS[:, _ORDER[1]].real), _numbers(2.0 * _VECTORS[:, _ORDER[1]].imag)
# Weights of the stages in the error estimate of third order.
ESTIMATE = (-(13.0 + 7.0 * _ROOT) / 3.0, (-13.0 + 7.0 * _ROOT) / 3.0, -1.0 / 3.0)


class StageStep(Record):
    """Step sizes and Newton iteration of Radau's method."""

    last: float  # last accepted step [s]; 0: the next step is a starting step
    factored_size: float  # step size of the factored matrices [s]; 0: no factors
    error_factor: float  # theta/(1 - theta) with the contraction rate theta of Newton's iteration
    iterations: int  # Newton iterations of the last step
    start: float  # start, size: start and size of the last accepted step [s]
    size: float


class Works(Record):
    """Works of a step [J]; `supplied` and `joints_size` without signs."""

    drives: float
    loads: float
    joints: float
    damping: float
    supplied: float
    joints_size: float


class StateVectors(Record):
    """A state with its ledger: at the start of a step, or at an instant within it."""

    q: Vector
    v: Vector
    a: Vector
    z: Vector
    lam: Vector
    ledger: Vector


def state_vectors(program: Program) -> StateVectors:
    """A state of zeros."""
    n, n_z = program.n_q + 3, program.tables.sizes.n_z
    return StateVectors(q=n, v=n, a=n, z=n_z, lam=program.n_c, ledger=11)


class Collocation(Record):
    """State and workspace of Radau's method; a restart needs `RESTART_ARRAYS`."""

    step: StageStep
    # past, past_lam: (4, n_q + 3), (4, n_c) accelerations and multipliers at 0, c_1, c_2, 1 of the last step
    past: Matrix
    past_lam: Matrix
    works: Works
    old: StateVectors  # old, between: state and ledger at the start of the last step, and at an instant within it
    between: StateVectors
    Q: Matrix  # Q, V, A, L: (3, ...) positions, velocities, accelerations, multipliers of the stages
    V: Matrix
    A: Matrix
    L: Matrix
    b: Matrix  # (3, n) right sides
    real: Vector  # real, re, im: (size,) factors
    re: Vector
    im: Vector
    inertia: Vector  # (size,) s C + s^2 M of the real system
    d: Vector  # d, x, y: (n,), pair : (2 n,) solutions, workspace
    x: Vector
    y: Vector
    pair: Vector
    of_q: Vector  # of_q, of_v: (n_q + 3,) estimated errors
    of_v: Vector
    losses: Matrix  # (contacts, 3) normal and tangential [J], impulses [N s]
    zero: Vector  # (n_q + 3,)
    rates: Matrix  # (3, 11) rates of the ledger at both ends of the step [W], and elsewhere
    lam: Vector  # (n_c,) multipliers
    signals: Vector  # (n_y,) at an instant within it


def collocation(program: Program) -> Collocation:
    """Arrays for a compiled mechanism."""
    n, m, size = program.n_q + 3, program.n_c, program.symbolic.size
    total = program.n_q + m
    return Collocation(
        step=StageStep(0.0, 0.0, 0.0, 0, 0.0, 0.0), past=(STAGES + 1, n), past_lam=(STAGES + 1, m),
        works=Works(*(0.0,) * 6), old=state_vectors(program), between=state_vectors(program),
        **dict.fromkeys(("Q", "V", "A"), (STAGES, n)), L=(STAGES, m), b=(STAGES, total),
        **dict.fromkeys(("real", "re", "im", "inertia"), size), **dict.fromkeys(("d", "x", "y"), total), pair=2 * total,
        **dict.fromkeys(("of_q", "of_v", "zero"), n), losses=(len(program.tables.contacts.kernel), 3), rates=(3, 11),
        lam=m, signals=program.tables.sizes.n_y,
    )  # fmt: skip
