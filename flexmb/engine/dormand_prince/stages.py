"""Coefficients of the method of Dormand and Prince of order 8(5,3), with its dense output of order 7; work arrays.

Sources: E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd ed., Springer 1993,
II.5 (method), II.6 (dense output) and II.10 (error estimate); the numbers are those of their code DOP853.
"""

from __future__ import annotations

import numpy as np

from flexmb.engine.compiled.records import Matrix, Record, Vector
from flexmb.engine.dormand_prince.complement import Complement, complement
from flexmb.engine.radau.collocation import StateVectors, Works, state_vectors
from flexmb.engine.system.work import new_from_template
from flexmb.program.program import Program

# Number of stages of a step, and with the end of the step and the three stages of the dense output.
STEP_STAGES, ALL_STAGES = 12, 16
# Numbers of the stages that are the start and the end of the step.
START, END = 0, STEP_STAGES
# Rows of `ERRORS`.
FIFTH, THIRD = range(2)

# Weights a_ij of each stage, by the number j of an earlier stage; row 12 has the weights of the step.
_ROWS: tuple[dict[int, float], ...] = (
    {},
    {0: 0.05260015195876773},
    {0: 0.0197250569845379, 1: 0.0591751709536137},
    {0: 0.02958758547680685, 2: 0.08876275643042054},
    {0: 0.2413651341592667, 2: -0.8845494793282861, 3: 0.924834003261792},
    {0: 0.037037037037037035, 3: 0.17082860872947386, 4: 0.12546768756682242},
    {0: 0.037109375, 3: 0.17025221101954405, 4: 0.06021653898045596, 5: -0.017578125},
    {0: 0.03709200011850479, 3: 0.17038392571223998, 4: 0.10726203044637328, 5: -0.015319437748624402,
     6: 0.008273789163814023},
    {0: 0.6241109587160757, 3: -3.3608926294469414, 4: -0.868219346841726, 5: 27.59209969944671, 6: 20.154067550477894,
     7: -43.48988418106996},
    {0: 0.47766253643826434, 3: -2.4881146199716677, 4: -0.590290826836843, 5: 21.230051448181193,
     6: 15.279233632882423, 7: -33.28821096898486, 8: -0.020331201708508627},
    {0: -0.9371424300859873, 3: 5.186372428844064, 4: 1.0914373489967295, 5: -8.149787010746927, 6: -18.52006565999696,
     7: 22.739487099350505, 8: 2.4936055526796523, 9: -3.0467644718982196},
    {0: 2.273310147516538, 3: -10.53449546673725, 4: -2.0008720582248625, 5: -17.9589318631188, 6: 27.94888452941996,
     7: -2.8589982771350235, 8: -8.87285693353063, 9: 12.360567175794303, 10: 0.6433927460157636},
    {0: 0.054293734116568765, 5: 4.450312892752409, 6: 1.8915178993145003, 7: -5.801203960010585,
     8: 0.3111643669578199, 9: -0.1521609496625161, 10: 0.20136540080403034, 11: 0.04471061572777259},
    {0: 0.056167502283047954, 6: 0.25350021021662483, 7: -0.2462390374708025, 8: -0.12419142326381637,
     9: 0.15329179827876568, 10: 0.00820105229563469, 11: 0.007567897660545699, 12: -0.008298},
    {0: 0.03183464816350214, 5: 0.028300909672366776, 6: 0.053541988307438566, 7: -0.05492374857139099,
     10: -0.00010834732869724932, 11: 0.0003825710908356584, 12: -0.00034046500868740456, 13: 0.1413124436746325},
    {0: -0.42889630158379194, 5: -4.697621415361164, 6: 7.683421196062599, 7: 4.06898981839711, 8: 0.3567271874552811,
     12: -0.0013990241651590145, 13: 2.9475147891527724, 14: -9.15095847217987},
)  # fmt: skip

# Weights of the error estimate of order 5.
_FIFTH = {0: 0.01312004499419488, 5: -1.2251564463762044, 6: -0.4957589496572502, 7: 1.6643771824549864,
 8: -0.35032884874997366, 9: 0.3341791187130175, 10: 0.08192320648511571, 11: -0.022355307863886294}  # fmt: skip

# Weights of a formula of order 3, whose difference is the other error estimate.
_THIRD = {0: 0.2440944881889764, 8: 0.7338466882816118, 11: 0.022058823529411766}

# Weights of the last four coefficients of the dense output.
_DENSE = (
    {0: -8.428938276109013, 5: 0.5667149535193777, 6: -3.0689499459498917, 7: 2.38466765651207, 8: 2.117034582445028,
     9: -0.871391583777973, 10: 2.2404374302607883, 11: 0.6315787787694688, 12: -0.08899033645133331,
     13: 18.148505520854727, 14: -9.194632392478356, 15: -4.436036387594894},
    {0: 10.427508642579134, 5: 242.28349177525817, 6: 165.20045171727028, 7: -374.5467547226902,
     8: -22.113666853125306, 9: 7.733432668472264, 10: -30.674084731089398, 11: -9.332130526430229,
     12: 15.697238121770845, 13: -31.139403219565178, 14: -9.35292435884448, 15: 35.81684148639408},
    {0: 19.985053242002433, 5: -387.0373087493518, 6: -189.17813819516758, 7: 527.8081592054236, 8: -11.57390253995963,
     9: 6.8812326946963, 10: -1.0006050966910838, 11: 0.7777137798053443, 12: -2.778205752353508,
     13: -60.19669523126412, 14: 84.32040550667716, 15: 11.99229113618279},
    {0: -25.69393346270375, 5: -154.18974869023643, 6: -231.5293791760455, 7: 357.6391179106141, 8: 93.40532418362432,
     9: -37.45832313645163, 10: 104.0996495089623, 11: 29.8402934266605, 12: -43.53345659001114, 13: 96.32455395918828,
     14: -39.17726167561544, 15: -149.72683625798564},
)  # fmt: skip


def _array(rows: tuple[dict[int, float], ...], columns: int) -> np.ndarray:
    return np.array([[row.get(k, 0.0) for k in range(columns)] for row in rows])


A = _array(_ROWS, ALL_STAGES)
# Weights (16, 16) of the stages f_i = f(t + C_i h, y0 + h sum_j A_ij f_j).
C = np.minimum(A.sum(axis=1), 1.0)
ERRORS = _array((_FIFTH, _THIRD), STEP_STAGES)
# Weights (2, 12) of the error estimates of order 5 and 3.
ERRORS[THIRD] = A[END, :STEP_STAGES] - ERRORS[THIRD]
# Weights (4, 16) of the dense output.
DENSE_WEIGHTS = _array(_DENSE, ALL_STAGES)


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
    tableau: Matrix  # tableau, instants, errors, weights: `A`, `C`, `ERRORS` and `DENSE_WEIGHTS` of the method
    instants: Vector
    errors: Matrix
    weights: Matrix
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
    n, m = program.n_q + 3, program.n_c
    return Stages(
        span=Span.zeros(), complement=complement(program), works=Works.zeros(), old=state_vectors(program),
        between=state_vectors(program), tableau=A, instants=C, errors=ERRORS, weights=DENSE_WEIGHTS,
        **dict.fromkeys(("Q", "V", "A"), (ALL_STAGES, n)), L=(ALL_STAGES, m), rates=(ALL_STAGES, LEDGER),
        **dict.fromkeys(("of_q", "of_v"), (DENSE, n)), of_ledger=(DENSE, LEDGER),
        **dict.fromkeys(("error_q", "error_v", "zero"), n), **dict.fromkeys(("x", "y"), program.n_q + m),
        pair=2 * (program.n_q + m), losses=(0, 2), signals=program.tables.sizes.n_y,
    )  # fmt: skip
