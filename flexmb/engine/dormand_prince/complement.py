"""Accelerations and projections of rigid bodies by the complement of their masses, S = G M^-1 G^T.

With a constant diagonal M the equations M a + G^T lam = -r, G a = gamma become

    S lam = -(G M^-1 r + gamma),   a = -M^-1 (r + G^T lam).

S has the rows of the constraints as unknowns.  Two joints are coupled where a body carries both, so S of a chain is
block tridiagonal.  Equation (4.21) of docs/theory/integrators.md.
"""

import math
from collections import defaultdict
from collections.abc import Iterator
from itertools import combinations_with_replacement

import numpy as np

from flexmb.engine.compiled.arrays import matrix_view, part_of
from flexmb.engine.compiled.records import Integers, IntegerTable, Record, Vector
from flexmb.engine.linalg.lu import LU, backward, backward_two, tables
from flexmb.engine.linalg.ordering import elimination_order
from flexmb.engine.linalg.symbolic import symbolic
from flexmb.engine.system.state_evaluation import StateEvaluation
from flexmb.engine.system.work import new_from_template
from flexmb.errors import KernelError
from flexmb.kernels import compiled
from flexmb.program.program import Constraints, Program


# Factors U^T D^-1 U of a symmetric A, without pivoting: half of the work of `lu`, of whose layout the rows of U alone
# are filled and used. The diagonal of U is kept inverted.
@compiled
def factor_symmetric(sym, lu, seen, least):
    """Factor A, whose upper entries in the order of elimination are in lu; whether all pivots are large enough."""
    # sym : LU; lu : (size,); seen : (n,) largest terms summed up to pivots, filled; a pivot is over `least` times that.
    for s in range(len(sym.starts) - 1):
        w, at = sym.starts[s + 1] - sym.starts[s], sym.value_ptr[s]
        for k in range(w):
            seen[sym.starts[s] + k] = abs(lu[at + k * (w + sym.row_ptr[s + 1] - sym.row_ptr[s] + 1)])
    for s in range(len(sym.starts) - 1):
        at, w, u = sym.value_ptr[s], sym.starts[s + 1] - sym.starts[s], sym.row_ptr[s + 1] - sym.row_ptr[s]
        own = part_of(seen, sym.starts[s], sym.starts[s + 1])
        below = part_of(sym.rows, sym.row_ptr[s], sym.row_ptr[s + 1])
        targets, length = part_of(sym.targets, sym.target_ptr[s], sym.target_ptr[s + 1]), w + u
        for k in range(w):
            row = part_of(lu, at + k * length, at + (k + 1) * length)
            if not least * own[k] < row[k] < math.inf:  # false for nan, too
                return False
            inverse = 1.0 / row[k]
            row[k] = inverse
            for i in range(k + 1, w):
                left, other = row[i] * inverse, part_of(lu, at + i * length, at + (i + 1) * length)
                own[i] = max(own[i], abs(left * row[i]))
                for j in range(i, length):
                    other[j] -= left * row[j]
        if w == 2 and u == 2:
            _update_2(lu, at, 2, seen, below, targets)
        elif w == 2:
            _update_2(lu, at, u, seen, below, targets)
        else:
            _update(lu, at, w, u, seen, below, targets)
    return True


@compiled
def _update(lu, at, w, u, seen, below, targets):
    """Subtract the products of a panel from the upper entries below it."""
    length = w + u
    for i in range(u):
        goal, term = part_of(targets, i * u, (i + 1) * u), 0.0
        for k in range(w):
            row = part_of(lu, at + k * length, at + (k + 1) * length)
            left = row[w + i] * row[k]
            term += left * row[w + i]
            for j in range(i, u):
                lu[goal[j]] -= left * row[w + j]
        seen[below[i]] = max(seen[below[i]], abs(term))


@compiled
def _update_2(lu, at, u, seen, below, targets):
    """`_update` for two pivots."""
    a, b = part_of(lu, at + 2, at + 2 + u), part_of(lu, at + 4 + u, at + 4 + 2 * u)
    p, q = lu[at], lu[at + 3 + u]
    for i in range(u):
        x, y, goal = a[i] * p, b[i] * q, part_of(targets, i * u, (i + 1) * u)
        seen[below[i]] = max(seen[below[i]], abs(x * a[i] + y * b[i]))
        for j in range(i, u):
            lu[goal[j]] -= x * a[j] + y * b[j]


@compiled
def solve_symmetric(sym, lu, rhs, x, y):
    """A x = rhs with the factors; sym : LU; rhs, x : (n,), may be one array; y : (n,) workspace."""
    into = sym.into
    for k in range(len(into)):
        y[k] = rhs[into[k]]
    for s in range(len(sym.starts) - 1):
        at, w, u = sym.value_ptr[s], sym.starts[s + 1] - sym.starts[s], sym.row_ptr[s + 1] - sym.row_ptr[s]
        own, below = part_of(y, sym.starts[s], sym.starts[s + 1]), part_of(sym.rows, sym.row_ptr[s], sym.row_ptr[s + 1])
        if w == 2:
            a, b = part_of(lu, at, at + 2 + u), part_of(lu, at + 2 + u, at + 4 + 2 * u)
            p = own[0] * a[0]
            own[1] -= a[1] * p
            q = own[1] * b[1]
            for i in range(u):
                y[below[i]] -= a[2 + i] * p + b[2 + i] * q
            continue
        for k in range(w):
            row = part_of(lu, at + k * (w + u), at + (k + 1) * (w + u))
            known = own[k] * row[k]
            for i in range(k + 1, w):
                own[i] -= row[i] * known
            for i in range(u):
                y[below[i]] -= row[w + i] * known
    backward(sym.starts, sym.row_ptr, sym.rows, sym.value_ptr, lu, y)
    for k in range(len(into)):
        x[into[k]] = y[k]


@compiled
def solve_symmetric_two(sym, lu, b, c, x, z, pair):
    """A x = b and A z = c with the factors; sym : LU; b, c, x, z : (n,); pair : (2 n,) workspace."""
    into = sym.into
    y = matrix_view(pair, len(into), 2)
    for k in range(len(into)):
        y[k, 0], y[k, 1] = b[into[k]], c[into[k]]
    for s in range(len(sym.starts) - 1):
        at, w, u = sym.value_ptr[s], sym.starts[s + 1] - sym.starts[s], sym.row_ptr[s + 1] - sym.row_ptr[s]
        first, below = sym.starts[s], part_of(sym.rows, sym.row_ptr[s], sym.row_ptr[s + 1])
        for k in range(w):
            row = part_of(lu, at + k * (w + u), at + (k + 1) * (w + u))
            p, q = y[first + k, 0] * row[k], y[first + k, 1] * row[k]
            for i in range(k + 1, w):
                y[first + i, 0] -= row[i] * p
                y[first + i, 1] -= row[i] * q
            for i in range(u):
                y[below[i], 0] -= row[w + i] * p
                y[below[i], 1] -= row[w + i] * q
    backward_two(sym.starts, sym.row_ptr, sym.rows, sym.value_ptr, lu, pair)
    for k in range(len(into)):
        x[into[k]], z[into[k]] = y[k, 0], y[k, 1]


# Columns of `Complement.pairs`: where both constraints have their G, its columns and rows; where the coordinates that
# they share and the positions of their block begin.
FIRST_G, FIRST_COLUMNS, FIRST_ROWS, SECOND_G, SECOND_COLUMNS, SECOND_ROWS, SHARED, SHARED_END, POSITION = range(9)
FIRST_COLUMN, SECOND_COLUMN, COORDINATE = range(3)  # places in threes of `Complement.common`
OTHER_POSE = 0.1  # movement to a second pose over the size of each coordinate, at which M must be the same


class Complement(Record):
    """S of a program: pattern, values or factors, vectors."""

    usable: int  # 1 if M is diagonal and constant, else 0
    lu: LU  # pattern of the factors
    values: Vector  # (size,) S, or its factors
    pairs: IntegerTable  # (pairs, 9) pairs of constraints that share coordinates
    common: Integers  # (3 k,) these coordinates
    positions: Integers  # of the entries of each pair, row by row, in the upper half of S
    flexibility: Vector  # (n_q + 3,) diagonal of M^-1 [1/kg, 1/(kg m^2)], 0 for the ground
    rhs: Vector  # rhs, x, y, scratch, seen: (n_c,)
    x: Vector
    y: Vector
    scratch: Vector
    seen: Vector
    pair: Vector  # (2 n_c,)


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
    away, found = OTHER_POSE * program.sizes * np.cos(np.arange(n)), []
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
    first, second = (np.concatenate([b[k].ravel() for b in blocks] or [np.zeros(0, int)]) for k in range(2))
    pattern = symbolic(m, first, second, order)
    table: list[tuple[int, ...]] = []
    shared: list[tuple[int, int, int]] = []
    positions, place, number = [np.zeros(0, dtype=np.int64)], np.argsort(order), 0
    for (c, d, common), (i, j) in zip(pairs, blocks, strict=True):
        ends = [(C.pos_g[k], C.dof[k + 1] - C.dof[k], C.row[k + 1] - C.row[k]) for k in (c, d)]
        table.append((*ends[0], *ends[1], len(shared), len(shared) + len(common), number))
        shared += common
        number += i.size
        low, high = np.where(place[i] <= place[j], (i, j), (j, i))
        at = pattern.positions(low, high)
        positions.append(np.where((c == d) & (place[i] > place[j]), pattern.dummy, at).ravel())
    return Complement(
        usable=int(usable), lu=tables(pattern), values=pattern.size,
        pairs=np.array(table, dtype=np.int64).reshape(-1, POSITION + 1),
        common=np.array(shared, dtype=np.int64).ravel(), positions=np.concatenate(positions), flexibility=n + 3,
        **dict.fromkeys(("rhs", "x", "y", "scratch", "seen"), m), pair=2 * m,
    )  # fmt: skip


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
    """Factor S with the rows G of an evaluation; whether no pivot is lost or that of a row to be held."""
    values = S.values
    values[:] = 0.0
    for k in range(S.pairs.shape[0]):
        rows, columns, at = S.pairs[k, FIRST_ROWS], S.pairs[k, SECOND_ROWS], S.pairs[k, POSITION]
        if rows == 2 and columns == 2:  # two pins: numbers that are known let the compiler unroll
            add_pins(S, G, k)
        else:
            add_pair(S, G, k, rows, columns, part_of(S.positions, at, at + rows * columns))
    return factor_symmetric(S.lu, values, S.seen, hold)


@compiled
def add_pair(S, G, k, rows, columns, positions):
    """Add the block of pair k to S."""
    a, p = S.pairs[k, FIRST_G], S.pairs[k, FIRST_COLUMNS]
    b, q = S.pairs[k, SECOND_G], S.pairs[k, SECOND_COLUMNS]
    for s in range(S.pairs[k, SHARED], S.pairs[k, SHARED_END]):
        own = part_of(S.common, 3 * s, 3 * s + 3)
        x, y, inverse = a + own[FIRST_COLUMN], b + own[SECOND_COLUMN], S.flexibility[own[COORDINATE]]
        for i in range(rows):
            left = G[x + i * p] * inverse
            for j in range(columns):
                S.values[positions[i * columns + j]] += left * G[y + j * q]


@compiled
def add_pins(S, G, k):
    """`add_pair` of two pins, in registers."""
    a, p, b, q = S.pairs[k, FIRST_G], S.pairs[k, FIRST_COLUMNS], S.pairs[k, SECOND_G], S.pairs[k, SECOND_COLUMNS]
    xx = xy = yx = yy = 0.0
    for s in range(S.pairs[k, SHARED], S.pairs[k, SHARED_END]):
        own = part_of(S.common, 3 * s, 3 * s + 3)
        i, j, inverse = a + own[FIRST_COLUMN], b + own[SECOND_COLUMN], S.flexibility[own[COORDINATE]]
        x, y, u, v = G[i] * inverse, G[i + p] * inverse, G[j], G[j + q]
        xx, xy, yx, yy = xx + x * u, xy + x * v, yx + y * u, yy + y * v
    to = part_of(S.positions, S.pairs[k, POSITION], S.pairs[k, POSITION] + 4)
    for place, entry in enumerate((xx, xy, yx, yy)):
        S.values[to[place]] = entry


@compiled
def accelerate_by_complement(tables, trial, work, S):
    """Set trial.a and trial.lam by the factors of S and an evaluation at a = 0; whether they are finite."""
    C, inverse, a, total = tables.constraints, S.flexibility, trial.a, 0.0
    for i in range(inverse.shape[0]):  # with the ground, which forces without bounds leave at nan
        a[i] = -inverse[i] * work.r[i]
    for c in range(C.kernel.shape[0]):
        n, m = C.dof[c + 1] - C.dof[c], C.row[c + 1] - C.row[c]
        if n == 6 and m == 2:
            find_rates(C, c, 6, 2, work, a, S.rhs)
        else:
            find_rates(C, c, n, m, work, a, S.rhs)
    solve_symmetric(S.lu, S.values, S.rhs, trial.lam, S.scratch)
    take_forces(C, inverse, work.G, trial.lam, a)
    for i in range(tables.sizes.n_q):
        total += a[i]
    return math.isfinite(total)


@compiled
def find_rates(C, c, n, m, work, a, rates):
    """Set the rows of constraint c in `rates` to G a - gamma."""
    dofs, G = part_of(C.dofs, C.dof[c], C.dof[c + 1]), part_of(work.G, C.pos_g[c], C.pos_g[c + 1])
    for i in range(m):
        rate = -work.gamma[C.row[c] + i]
        for j in range(n):
            rate += G[i * n + j] * a[dofs[j]]
        rates[C.row[c] + i] = rate


@compiled
def take_forces(C, inverse, G, lam, a):
    """Subtract M^-1 G^T lam from a (n_q + 3,)."""
    for c in range(C.kernel.shape[0]):
        n, m = C.dof[c + 1] - C.dof[c], C.row[c + 1] - C.row[c]
        if n == 6 and m == 2:
            _take_force(C, c, 6, 2, inverse, G, lam, a)
        else:
            _take_force(C, c, n, m, inverse, G, lam, a)


@compiled
def _take_force(C, c, n, m, inverse, G, lam, a):
    """`take_forces` of constraint c."""
    dofs, own = part_of(C.dofs, C.dof[c], C.dof[c + 1]), part_of(G, C.pos_g[c], C.pos_g[c + 1])
    for j in range(n):
        force = 0.0
        for i in range(m):
            force += own[i * n + j] * lam[C.row[c] + i]
        a[dofs[j]] -= inverse[dofs[j]] * force


@compiled
def project_by_complement(tables, trial, work, S, dq):
    """Shift trial.q and trial.v onto the constraints of the last evaluation; the largest shift; dq : (n_q + 3,)."""
    C, largest = tables.constraints, 0.0
    solve_symmetric_two(S.lu, S.values, work.g, work.gv, S.x, S.y, S.pair)
    dq[:] = 0.0
    take_forces(C, S.flexibility, work.G, S.x, dq)
    take_forces(C, S.flexibility, work.G, S.y, trial.v)
    for i in range(tables.sizes.n_q):
        trial.q[i] += dq[i]
        largest = max(largest, abs(dq[i]))
    return largest if math.isfinite(largest) else math.inf
