"""Accelerations and projections of rigid bodies by the complement of their masses, S = G M^-1 G^T.

With a constant diagonal M the equations M a + G^T lam = -r, G a = gamma become

    S lam = -(G M^-1 r + gamma),   a = -M^-1 (r + G^T lam).

S has the rows of the constraints as unknowns.  Two joints are coupled where a body carries both, so S of a chain is
block tridiagonal.  Equation (1.11) of docs/theory/equations_of_motion.md.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator
from itertools import combinations_with_replacement

import numpy as np

from flexmb.engine.compiled.arrays import part_of
from flexmb.engine.compiled.records import Integers, IntegerTable, Record, Vector
from flexmb.engine.linalg.lu import LOST_PIVOT, LU, factor, solve, solve_two, tables
from flexmb.engine.linalg.ordering import elimination_order
from flexmb.engine.linalg.symbolic import symbolic
from flexmb.engine.system.state_evaluation import StateEvaluation
from flexmb.engine.system.work import new_from_template
from flexmb.errors import KernelError
from flexmb.kernels import compiled
from flexmb.program.program import Constraints, Program

FIRST_G, FIRST_COLUMNS, FIRST_ROWS, SECOND_G, SECOND_COLUMNS, SECOND_ROWS, SHARED, SHARED_END, POSITION = range(9)
"""Columns of `Complement.pairs`: where both constraints have their G, its columns and rows; where the coordinates that
they share and the positions of their block begin."""

FIRST_COLUMN, SECOND_COLUMN, COORDINATE = range(3)  # columns of `Complement.shared`

OTHER_POSE = 0.1  # movement to a second pose over the size of each coordinate, at which M must be the same


class Complement(Record):
    """S of a program: pattern, values or factors, vectors.

    usable : 1 if M is diagonal and constant, else 0
    lu : pattern of the factors;  values : (size,) S, or its factors
    pairs : (pairs, 9) pairs of constraints that share coordinates;  shared : (k, 3) these coordinates
    positions : of the entries of each pair, row by row, then the mirrored ones
    flexibility : (n_q + 3,) diagonal of M^-1 [1/kg, 1/(kg m^2)], 0 for the ground
    rhs, x, y, scratch, seen : (n_c,);  pair : (2 n_c,)
    """

    usable: int
    lu: LU
    values: Vector
    pairs: IntegerTable
    shared: IntegerTable
    positions: Integers
    flexibility: Vector
    rhs: Vector
    x: Vector
    y: Vector
    scratch: Vector
    seen: Vector
    pair: Vector


# Pattern of S, and the masses of a program


def complement(program: Program) -> Complement:
    """S of a compiled mechanism; not usable where M is not diagonal and constant, or joints have friction."""
    sizes, inverse = program.tables.sizes, inverse_masses(program)
    if inverse is None or sizes.has_joint_friction or len(program.tables.controls.kernel) > 0:
        return new_from_template(program, "no complement", lambda: _of_pattern(program, usable=False))
    found = new_from_template(program, "complement", lambda: _of_pattern(program, usable=True))
    found.flexibility[: program.n_q] = inverse
    return found


def inverse_masses(program: Program) -> np.ndarray | None:
    """Diagonal (n_q,) of M^-1; None where M is not diagonal, not positive or not the same in two poses."""
    n, pattern, evaluation = program.n_q, program.symbolic, StateEvaluation(program)
    rows, columns = pattern.a_rows, pattern.a_cols
    own, diagonal = (rows < n) & (columns < n), rows == columns
    away = OTHER_POSE * program.sizes * np.cos(np.arange(n))
    found = []
    for q, v, t in ((program.reference.q, 0.0 * away, 0.0), (program.reference.q + away, away, 1.0)):
        try:
            M = evaluation.at(q, v, t=t, weights=(0.0, 0.0, 1.0)).work.lu[pattern.places]
        except KernelError:
            return None
        if M[own & ~diagonal].any():
            return None
        found.append(M[own & diagonal][np.argsort(rows[own & diagonal])])
    first, second = found
    return 1.0 / first if np.array_equal(first, second) and (first > 0.0).all() else None


def _of_pattern(program: Program, *, usable: bool) -> Complement:
    C, n, m = program.tables.constraints, program.n_q, program.n_c if usable else 0
    pairs = list(_pairs(C, n)) if usable else []
    rows = [np.arange(C.row[c], C.row[c + 1]) for c in range(len(C.kernel))] if usable else []
    order = elimination_order([list(r) for r in rows], [(c, d) for c, d, _ in pairs], [False] * len(rows))
    blocks = [np.meshgrid(rows[c], rows[d], indexing="ij") for c, d, _ in pairs]
    entries = [np.concatenate([b[k].ravel() for b in blocks] or [np.zeros(0, int)]) for k in range(2)]
    pattern = symbolic(m, *entries, order)
    table, shared, positions = [], [], []
    for (c, d, common), (i, j) in zip(pairs, blocks, strict=True):
        ends = [(C.pos_g[k], C.dof[k + 1] - C.dof[k], C.row[k + 1] - C.row[k]) for k in (c, d)]
        table.append((*ends[0], *ends[1], len(shared), len(shared) + len(common), sum(map(len, positions))))
        shared += common
        mirrored = np.full(i.size, pattern.dummy) if c == d else pattern.positions(j.ravel(), i.ravel())
        positions.append(np.concatenate([pattern.positions(i.ravel(), j.ravel()), mirrored]))
    return Complement(
        usable=int(usable),
        lu=tables(pattern),
        values=pattern.size,
        pairs=np.array(table, dtype=np.int64).reshape(-1, POSITION + 1),
        shared=np.array(shared, dtype=np.int64).reshape(-1, COORDINATE + 1),
        positions=np.concatenate([*positions, np.zeros(0, int)]).astype(np.int64),
        flexibility=n + 3,
        **dict.fromkeys(("rhs", "x", "y", "scratch", "seen"), m),
        pair=2 * m,
    )


def _pairs(C: Constraints, n: int) -> Iterator[tuple[int, int, list[tuple[int, int, int]]]]:
    """Pairs of constraints that share coordinates, each with itself, too, and the columns of both for each of these."""
    found: dict[tuple[int, int], list[tuple[int, int, int]]] = defaultdict(list)
    holders: dict[int, list[tuple[int, int]]] = defaultdict(list)
    for c in range(len(C.kernel)):
        for column, dof in enumerate(C.dofs[C.dof[c] : C.dof[c + 1]].astype(int)):
            if dof < n:
                holders[int(dof)].append((c, column))
    for dof, own in holders.items():
        for (c, i), (d, j) in combinations_with_replacement(own, 2):
            found[c, d].append((i, j, dof))
            if c == d and i != j:
                found[c, d].append((j, i, dof))
    yield from ((c, d, common) for (c, d), common in found.items())


# S of a pose and its factors; accelerations, multipliers and projections with them


@compiled
def factor_complement(S, G, hold):
    """Factor S with the rows G of an evaluation; -1 if no row is held and no pivot lost, see `linalg.lu.factor`."""
    values, inverse, positions = S.values, S.flexibility, S.positions
    values[:] = 0.0
    for k in range(S.pairs.shape[0]):
        a, p, rows = S.pairs[k, FIRST_G], S.pairs[k, FIRST_COLUMNS], S.pairs[k, FIRST_ROWS]
        b, q, columns = S.pairs[k, SECOND_G], S.pairs[k, SECOND_COLUMNS], S.pairs[k, SECOND_ROWS]
        begin, end, at = S.pairs[k, SHARED], S.pairs[k, SHARED_END], S.pairs[k, POSITION]
        here = part_of(positions, at, at + rows * columns)
        there = part_of(positions, at + rows * columns, at + 2 * rows * columns)
        for i in range(rows):
            for j in range(columns):
                total = 0.0
                for s in range(begin, end):
                    x, y = S.shared[s, FIRST_COLUMN], S.shared[s, SECOND_COLUMN]
                    total += G[a + i * p + x] * inverse[S.shared[s, COORDINATE]] * G[b + j * q + y]
                values[here[i * columns + j]] += total
                values[there[i * columns + j]] += total
    return factor(S.lu, values, S.seen, LOST_PIVOT, 0, hold)


@compiled
def accelerate_by_complement(tables, trial, work, S):
    """Set trial.a and trial.lam with the factors of S and the last evaluation, made at a = 0; whether they are finite."""
    C, inverse, a, total = tables.constraints, S.flexibility, trial.a, 0.0
    for i in range(tables.sizes.n_q):
        a[i] = -inverse[i] * work.r[i]
    for c in range(C.kernel.shape[0]):
        n, first = C.dof[c + 1] - C.dof[c], C.pos_g[c]
        dofs = part_of(C.dofs, C.dof[c], C.dof[c + 1])
        for row in range(C.row[c], C.row[c + 1]):
            rate, at = -work.gamma[row], first + (row - C.row[c]) * n
            for j in range(n):
                rate += work.G[at + j] * a[dofs[j]]
            S.rhs[row] = rate
    solve(S.lu, S.values, S.rhs, trial.lam, S.scratch)
    take_forces(C, inverse, work.G, trial.lam, a)
    for i in range(tables.sizes.n_q):
        total += a[i]
    return math.isfinite(total)


@compiled
def take_forces(C, inverse, G, lam, a):
    """Subtract M^-1 G^T lam from a (n_q + 3,)."""
    for c in range(C.kernel.shape[0]):
        n, first, begin = C.dof[c + 1] - C.dof[c], C.pos_g[c], C.row[c]
        dofs = part_of(C.dofs, C.dof[c], C.dof[c + 1])
        for j in range(n):
            force = 0.0
            for row in range(begin, C.row[c + 1]):
                force += G[first + (row - begin) * n + j] * lam[row]
            a[dofs[j]] -= inverse[dofs[j]] * force


@compiled
def project_by_complement(tables, trial, work, S, dq):
    """Shift trial.q and trial.v onto the constraints of the last evaluation; the largest shift; dq : (n_q + 3,)."""
    C, largest = tables.constraints, 0.0
    solve_two(S.lu, S.values, work.g, work.gv, S.x, S.y, S.pair)
    dq[:] = 0.0
    take_forces(C, S.flexibility, work.G, S.x, dq)
    take_forces(C, S.flexibility, work.G, S.y, trial.v)
    for i in range(tables.sizes.n_q):
        trial.q[i] += dq[i]
        largest = max(largest, abs(dq[i]))
    return largest if math.isfinite(largest) else math.inf
