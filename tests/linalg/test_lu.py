"""Sparse solver: against dense LAPACK, on matrices of which the answer is known, and its pattern as such."""

import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flexmb.engine.linalg.dense import PivotingSolver
from flexmb.engine.linalg.lu import (
    LOST_PIVOT,
    ROWS_HELD,
    factor,
    factor_complex,
    multiply,
    null_vector,
    solve,
    solve_complex,
    tables,
)
from flexmb.engine.linalg.ordering import elimination_order
from flexmb.engine.linalg.symbolic import Symbolic, symbolic
from flexmb.errors import InputError, SolveError


class Frame:
    """Nodes of three coordinates, elements of two nodes, joints of one to three rows; values are random."""

    def __init__(self, nodes, elements, joints, seed=0, stiffness=1.0):
        """Elements: pairs of nodes; joints: (number of rows, nodes), -1 for the ground."""
        self.rng, self.stiffness = np.random.default_rng(seed), stiffness
        self.blocks = [[3 * k, 3 * k + 1, 3 * k + 2] for k in range(nodes)]
        self.n = self.n_q = 3 * nodes
        self.last = [False] * nodes
        self.edges = [tuple(pair) for pair in elements]
        self.rows, self.cols, self.numbers = [], [], []
        for k in range(nodes):
            self._add(self.blocks[k], self.blocks[k], self._dominant(3))
        for a, b in elements:
            both = self.blocks[a] + self.blocks[b]
            self._add(both, both, self._dominant(6))
        for count, ends in joints:
            self._add_joint(count, [k for k in ends if k >= 0])

    def _dominant(self, size):
        """Unsymmetric, with a positive definite symmetric part: diagonal 2 size against row sums below size."""
        return self.stiffness * (self.rng.uniform(-1, 1, (size, size)) + 2 * size * np.eye(size))

    def _add_joint(self, count, ends):
        rows = list(range(self.n, self.n + count))
        G = self.rng.uniform(-1, 1, (count, 3 * len(ends)))
        if count == 2:
            G[0, 1::3] = G[1, 0::3] = 0.0  # as in a revolute joint: x and theta, y and theta
        nodes = [unknown for k in ends for unknown in self.blocks[k]]
        self._add(rows, nodes, G)
        self._add(nodes, rows, G.T)
        self.edges.append((*ends, len(self.blocks)))
        self.blocks.append(rows)
        self.last.append(True)
        self.n += count

    def _add(self, rows, cols, block):
        i, j = np.nonzero(block)
        self.rows += [rows[k] for k in i]
        self.cols += [cols[k] for k in j]
        self.numbers += block[i, j].tolist()

    def pattern(self):
        order = elimination_order(self.blocks, self.edges, self.last)
        return symbolic(self.n, self.rows, self.cols, order)

    def values(self, pattern):
        values = np.zeros(pattern.size)
        np.add.at(values, pattern.positions(self.rows, self.cols), self.numbers)
        return values

    def dense(self):
        A = np.zeros((self.n, self.n))
        np.add.at(A, (self.rows, self.cols), self.numbers)
        return A


def chain(links, elements, **options):
    """Links of some elements, joined by revolute joints, the first one at the ground."""
    size = elements + 1
    beams = [(k, k + 1) for link in range(links) for k in range(link * size, link * size + elements)]
    joints = [(2, (link * size - 1, link * size)) for link in range(1, links)]
    return Frame(links * size, beams, [(2, (-1, 0)), *joints], **options)


def tree(**options):
    """A body with four arms, two of which branch; hinges, a slider and a weld."""
    joints = [(2, (0, 1)), (2, (0, 2)), (1, (0, 3)), (3, (0, 4)), (2, (4, 5)), (2, (4, 6)), (2, (1, 7)), (1, (-1, 0))]
    return Frame(8, [], joints, **options)


def loop(**options):
    """A four-bar with flexible rods, closed over the ground."""
    joints = [(2, (-1, 0)), (2, (2, 3)), (2, (5, 6)), (2, (8, -1))]
    return Frame(9, [(0, 1), (1, 2), (3, 4), (4, 5), (6, 7), (7, 8)], joints, **options)


def nested_loops(**options):
    """Two loops that share a side, and a beam that is connected to nothing."""
    sides = [(2, (0, 1)), (2, (1, 2)), (2, (2, 3)), (2, (3, 0)), (2, (2, 4)), (2, (4, 5)), (2, (5, 3)), (3, (-1, 0))]
    return Frame(8, [(6, 7)], sides, **options)


def body_alone(**options):
    return Frame(1, [], [], **options)


FRAMES = {
    "chain of rigid links": lambda **o: chain(3, 0, **o),
    "chain of beams": lambda **o: chain(9, 4, **o),
    "one long beam": lambda **o: chain(1, 60, **o),
    "tree": tree,
    "loop": loop,
    "nested loops": nested_loops,
    "body alone": body_alone,
}


def solved(pattern, values, b):
    """(status of `factor`, x)."""
    sym, lu, work, x = tables(pattern), values.copy(), np.empty(pattern.n), np.empty(pattern.n)
    status = factor(sym, lu, work, LOST_PIVOT)
    solve(sym, lu, b, x, work)
    return status, x


def relative(x, exact):
    return np.max(np.abs(x - exact)) / np.max(np.abs(exact))


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("name", FRAMES)
def test_agrees_with_lapack(name, seed):
    frame = FRAMES[name](seed=seed)
    pattern = frame.pattern()
    b = np.random.default_rng(seed).normal(size=frame.n)
    status, x = solved(pattern, frame.values(pattern), b)
    assert status == -1
    assert relative(x, np.linalg.solve(frame.dense(), b)) < 1e-10


@pytest.mark.parametrize("stiffness", [1e-8, 1e16])
def test_units_of_the_stiffness_do_not_matter(stiffness):
    """A soft or stiff S beside the same G: pivots of joints are G S^-1 G^T, 1e-16 beside entries of size 1."""
    frame = chain(4, 3, stiffness=stiffness)
    pattern = frame.pattern()
    b = np.r_[stiffness * np.ones(frame.n_q), np.ones(frame.n - frame.n_q)]
    status, x = solved(pattern, frame.values(pattern), b)
    scale = np.r_[np.ones(frame.n_q), np.full(frame.n - frame.n_q, stiffness)]
    reference = chain(4, 3)  # S x + G^T lam = 1 with S of size 1: the same x, lam scaled
    exact = scale * np.linalg.solve(reference.dense(), np.ones(frame.n))
    assert status == -1
    assert relative(x[: frame.n_q], exact[: frame.n_q]) < 1e-10
    assert relative(x[frame.n_q :], exact[frame.n_q :]) < 1e-10


def test_hand_calculation():
    """m a + lam = f, a = gamma with m = 2, f = 10, gamma = 3: lam = 4."""
    pattern = symbolic(2, [0, 0], [0, 1], elimination_order([[0], [1]], [(0, 1)], [False, True]))
    values = np.zeros(pattern.size)
    values[pattern.positions([0, 0, 1], [0, 1, 0])] = [2.0, 1.0, 1.0]
    status, x = solved(pattern, values, np.array([10.0, 3.0]))
    assert status == -1
    assert x.tolist() == [3.0, 4.0]


def test_solution_may_overwrite_the_right_hand_side():
    frame = loop()
    pattern = frame.pattern()
    sym, lu, work, b = tables(pattern), frame.values(pattern), np.empty(frame.n), np.ones(frame.n)
    assert factor(sym, lu, work, LOST_PIVOT) == -1
    solve(sym, lu, b, b, work)
    np.testing.assert_allclose(frame.dense() @ b, 1.0, rtol=0, atol=1e-10)


@pytest.mark.parametrize("name", FRAMES)
def test_multiply(name):
    frame = FRAMES[name]()
    pattern = frame.pattern()
    x, y = np.random.default_rng(5).normal(size=frame.n), np.full(frame.n, 7.0)
    multiply(tables(pattern), frame.values(pattern), x, y)
    np.testing.assert_allclose(y, frame.dense() @ x, rtol=0, atol=1e-12)


def with_double_joint(stiffness=1.0):
    """A loop whose second joint is there twice: row for row the same G."""
    frame = loop(stiffness=stiffness)
    original, copy, nodes = frame.blocks[10], [frame.n, frame.n + 1], [2, 3]
    of_joint = [k for k, row in enumerate(frame.rows) if row in original]
    G = [(frame.rows[k] - original[0], frame.cols[k], frame.numbers[k]) for k in of_joint]
    for row, col, number in G:
        frame.rows += [copy[row], col]
        frame.cols += [col, copy[row]]
        frame.numbers += [number, number]
    frame.edges.append((*nodes, len(frame.blocks)))
    frame.blocks.append(copy)
    frame.last.append(True)
    frame.n += 2
    return frame


@pytest.mark.parametrize("stiffness", [1e-8, 1.0, 1e12])
def test_redundant_joint_is_reported_by_one_of_its_rows(stiffness):
    frame = with_double_joint(stiffness)
    pattern = frame.pattern()
    lu, seen = frame.values(pattern), np.empty(frame.n)
    lost = factor(tables(pattern), lu, seen, LOST_PIVOT)
    assert lost in frame.blocks[10] + frame.blocks[-1]


@pytest.mark.parametrize("stiffness", [1e-8, 1.0, 1e12])
def test_redundant_joint_is_held_when_asked_for(stiffness):
    """Its rows are left out, and still hold, since they repeat others; what `dependence` gives is without effect."""
    frame = with_double_joint(stiffness)
    pattern = frame.pattern()
    sym, lu, seen = tables(pattern), frame.values(pattern), np.empty(frame.n)
    assert factor(sym, lu, seen, LOST_PIVOT, frame.n_q) == ROWS_HELD
    assert (seen < 0.0).sum() == 2
    A = frame.dense()
    scale = np.r_[np.ones(frame.n_q), np.full(frame.n - frame.n_q, stiffness)]
    b = A @ (scale * np.random.default_rng(1).normal(size=frame.n))
    x, y = np.empty(frame.n), np.empty(frame.n)
    solve(sym, lu, b, x, y)
    assert np.abs(A @ x - b).max() < 1e-10 * np.abs(b).max()
    for s in range(len(sym.starts) - 1):
        for k in range(sym.starts[s + 1] - sym.starts[s]):
            if seen[sym.starts[s] + k] < 0.0:
                null_vector(sym, lu, s, k, b, x, y)
                assert np.abs(x).max() >= 1.0
                assert np.abs(A @ x).max() < 1e-10 * np.abs(x).max() * max(stiffness, 1.0)


def test_unknown_without_any_entry_is_reported():
    frame = body_alone()
    pattern = symbolic(4, frame.rows, frame.cols, [0, 1, 2, 3])
    assert factor(tables(pattern), frame.values(pattern), np.empty(4), LOST_PIVOT) == 3


@pytest.mark.parametrize("fault", [np.nan, np.inf, -np.inf])
def test_pivot_that_is_not_finite_is_reported(fault):
    frame = chain(2, 2)
    pattern = frame.pattern()
    for unknown in range(frame.n_q):
        values = frame.values(pattern)
        values[pattern.positions(unknown, unknown)] = fault
        assert factor(tables(pattern), values, np.empty(frame.n), LOST_PIVOT) == unknown


def test_dummy_slot_changes_nothing():
    frame = tree()
    pattern = frame.pattern()
    at = pattern.positions([-1, 0, -1, 3], [2, -1, -1, 3])
    assert at[:3].tolist() == [pattern.dummy] * 3
    assert at[3] != pattern.dummy
    values = frame.values(pattern)
    b = np.ones(frame.n)
    _, x = solved(pattern, values, b)
    values[pattern.dummy] = np.nan
    status, same = solved(pattern, values, b)
    assert status == -1
    assert same.tolist() == x.tolist()


def test_ground_may_stand_in_the_pattern():
    frame = loop()
    order = elimination_order(frame.blocks, frame.edges, frame.last)
    with_ground = symbolic(frame.n, [*frame.rows, -1, 0, -3], [*frame.cols, 0, -1, -1], order)
    assert with_ground.targets.tolist() == frame.pattern().targets.tolist()


def test_every_entry_has_its_own_position():
    pattern = nested_loops().pattern()
    at = pattern.positions(pattern.a_rows, pattern.a_cols)
    assert len(set(at.tolist())) == len(at)
    assert at.min() >= 0
    assert at.max() < pattern.dummy


def graphs():
    """Random frames: up to 12 nodes, any elements and joints between them."""
    return st.integers(1, 12).flatmap(
        lambda nodes: st.builds(
            lambda elements, joints: Frame(nodes, [p for p in elements if p[0] != p[1]], joints),
            st.lists(st.tuples(st.integers(0, nodes - 1), st.integers(0, nodes - 1)), max_size=15),
            st.lists(
                st.tuples(st.integers(1, 2), st.sets(st.integers(0, nodes - 1), min_size=1, max_size=3)), max_size=8
            ),
        )
    )


@settings(max_examples=40)
@given(graphs())
def test_constraints_come_after_their_coordinates(frame):
    order = elimination_order(frame.blocks, frame.edges, frame.last).tolist()
    assert sorted(order) == list(range(frame.n))
    place = {unknown: k for k, unknown in enumerate(order)}
    for edge in frame.edges:
        joints = [place[u] for b in edge if frame.last[b] for u in frame.blocks[b]]
        nodes = [place[u] for b in edge if not frame.last[b] for u in frame.blocks[b]]
        assert not joints or min(joints) > max(nodes)


@given(graphs())
def test_stored_pattern_holds_the_factors(frame):
    """No update is lost: the solution is right whenever no joint is redundant."""
    pattern = frame.pattern()
    A, b = frame.dense(), np.arange(1.0, frame.n + 1)
    status, x = solved(pattern, frame.values(pattern), b)
    if np.linalg.cond(A) < 1e6:
        assert status == -1
        assert relative(x, np.linalg.solve(A, b)) < 1e-9


def test_fill_of_a_chain_is_linear():
    """Neighbouring nodes only: a panel of three has at most two neighbours, so at most 3 (3 + 2 * 6) values."""
    for elements in (40, 400, 4000):
        pattern = chain(1, elements).pattern()
        assert pattern.size / pattern.n <= 15
        assert len(pattern.targets) / pattern.n <= 12


@given(graphs())
def test_updates_go_where_their_entries_are(frame):
    """Positions that are found by a walk through each panel are those that `positions` searches for."""
    pattern = frame.pattern()
    for s, t in enumerate(pattern.target_ptr[:-1]):
        below = pattern.order[pattern.rows[pattern.row_ptr[s] : pattern.row_ptr[s + 1]]]
        searched = pattern.positions(below[:, None], below[None, :])
        assert pattern.targets[t : t + searched.size].tolist() == searched.ravel().tolist()


def test_factors_that_no_memory_holds_are_refused(monkeypatch):
    """A lattice of 10 x 10 nodes takes some 20 kB for the places of its updates."""
    edges = [(i, i + 1) for i in range(100) if i % 10 < 9] + [(i, i + 10) for i in range(90)]
    rows, cols = (np.array([edge[k] for edge in edges]) for k in range(2))
    pattern = symbolic(100, rows, cols, np.arange(100))
    monkeypatch.setattr("os.sysconf", lambda _: 50, raising=False)  # 2500 bytes
    with pytest.raises(SolveError, match=r"factors of 100 unknowns take .* GB of memory"):
        _ = pattern.targets
    monkeypatch.undo()
    assert len(pattern.targets) == pattern.target_ptr[-1]


def test_postorder_keeps_families_together():
    """The arms of a star are eliminated one after the other, each from its tip, the hub last."""
    arms = [[(0, 1), (1, 2), (2, 3)], [(0, 4), (4, 5), (5, 6)]]
    frame = Frame(7, arms[0] + arms[1], [])
    order = elimination_order(frame.blocks, frame.edges, frame.last)
    blocks = (order[::3] // 3).tolist()
    sides = [1 if k in (1, 2, 3) else 2 for k in blocks if k]
    assert sides == sorted(sides)


def test_two_runs_give_the_same():
    first, second = nested_loops().pattern(), nested_loops().pattern()
    for one, other in zip(tables(first).as_dict().values(), tables(second).as_dict().values(), strict=True):
        assert one.tolist() == other.tolist()


def test_pickle():
    frame = loop()
    pattern = frame.pattern()
    copy = pickle.loads(pickle.dumps(pattern))  # noqa: S301 (its own)
    assert isinstance(copy, Symbolic)
    for before, after in zip(tables(pattern).as_dict().values(), tables(copy).as_dict().values(), strict=True):
        assert after.tolist() == before.tolist()
        assert after.dtype == before.dtype
        assert not after.flags.writeable
    assert copy.positions(frame.rows, frame.cols).tolist() == pattern.positions(frame.rows, frame.cols).tolist()


def test_arrays_are_read_only():
    pattern = loop().pattern()
    with pytest.raises(ValueError, match="read-only"):
        pattern.rows[0] = 1


@pytest.mark.parametrize(
    ("blocks", "edges", "last", "message"),
    [
        ([[0], [1]], [], [False], "last has 1 entries for 2 blocks"),
        ([[0], [0]], [], [False, False], "unknown 0 stands in two blocks"),
        ([[0], [2]], [], [False, False], "unknown 2 comes where 1 is missing"),
        ([[0], [1]], [(0, -1)], [False, False], "edge (0, -1) names block -1; there are blocks 0 .. 1"),
    ],
)
def test_wrong_blocks_are_refused(blocks, edges, last, message):
    with pytest.raises(InputError) as caught:
        elimination_order(blocks, edges, last)
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((2, [0], [1], [0, 0]), "order is no permutation of 0 .. 1"),
        ((2, [0], [2], [0, 1]), "unknown 2 is not there"),
        ((2, [0, 1], [1], [0, 1]), "2 rows and 1 cols"),
    ],
)
def test_wrong_patterns_are_refused(arguments, message):
    with pytest.raises(InputError) as caught:
        symbolic(*arguments)
    assert message in str(caught.value)


def test_entry_outside_the_pattern_is_refused():
    pattern = chain(1, 3).pattern()
    with pytest.raises(InputError, match=r"entry \(0, 9\) is not in the pattern"):
        pattern.positions([0, 0], [3, 9])


def test_nothing_to_solve():
    pattern = symbolic(0, [], [], elimination_order([], [], []))
    status, x = solved(pattern, np.zeros(pattern.size), np.zeros(0))
    assert (status, x.size, pattern.size) == (-1, 0, 1)


# The solver with pivoting


@pytest.mark.parametrize("stiffness", [1e-8, 1.0, 1e10])
@pytest.mark.parametrize("name", FRAMES)
def test_pivoting_solver_agrees_with_lapack(name, stiffness):
    frame = FRAMES[name](stiffness=stiffness)
    pattern = frame.pattern()
    x = np.r_[np.ones(frame.n_q), np.full(frame.n - frame.n_q, stiffness)]
    found = PivotingSolver(pattern).factor(frame.values(pattern)).solve(frame.dense() @ x)
    np.testing.assert_allclose(found, x, rtol=1e-10)


def test_pivoting_solver_needs_no_stiffness():
    """No mass and no stiffness: S = 0 and as many joint rows as coordinates, so x = G^-1 b2."""
    G = np.array([[1.0, 0.0, 0.5], [0.0, 1.0, 2.0], [0.0, 0.0, 4.0]])
    i, j = np.nonzero(G)
    pattern = symbolic(6, i + 3, j, np.arange(6))
    values = np.zeros(pattern.size)
    values[pattern.positions(i + 3, j)] = values[pattern.positions(j, i + 3)] = G[i, j]
    assert factor(tables(pattern), values.copy(), np.empty(6), LOST_PIVOT) == 0
    x = PivotingSolver(pattern).factor(values).solve(np.array([0.0, 0.0, 0.0, 2.0, 5.0, 8.0]))
    np.testing.assert_allclose(x, [1.0, 1.0, 2.0, 0.0, 0.0, 0.0], atol=1e-14)


def test_pivoting_solver_reports_a_redundant_joint():
    frame = with_double_joint()
    pattern = frame.pattern()
    b = np.random.default_rng(3).normal(size=frame.n)  # asks the two equal rows for different things
    with pytest.raises(SolveError, match=r"the 37 x 37 matrix is singular .* joints that hold the same motion"):
        PivotingSolver(pattern).factor(frame.values(pattern)).solve(b)


def test_pivoting_solver_reports_an_empty_row():
    pattern = symbolic(2, [0], [0], [0, 1])
    values = np.zeros(pattern.size)
    values[pattern.positions(0, 0)] = 1.0
    with pytest.raises(SolveError, match="the 2 x 2 matrix is singular"):
        PivotingSolver(pattern).factor(values)


def test_pivoting_solver_names_the_entry_that_is_not_finite():
    frame = chain(1, 1)
    pattern = frame.pattern()
    values = frame.values(pattern)
    values[pattern.positions(2, 4)] = np.nan
    with pytest.raises(SolveError, match=r"entry \(2, 4\) of the matrix is nan"):
        PivotingSolver(pattern).factor(values)


# Complex matrices, for pairs of stages of implicit Runge-Kutta methods.


@pytest.mark.parametrize("case", [lambda s: chain(3, 2, seed=s), lambda s: tree(seed=s), lambda s: loop(seed=s)])
def test_complex_solutions_are_those_of_numpy(case):
    real, imaginary = case(1), case(2)
    pattern = real.pattern()
    re, im = real.values(pattern), imaginary.values(pattern)
    A = real.dense() + 1j * imaginary.dense()
    rng = np.random.default_rng(3)
    b = rng.normal(size=real.n) + 1j * rng.normal(size=real.n)
    x, y = b.real.copy(), b.imag.copy()
    sym = tables(pattern)
    assert factor_complex(sym, re, im, np.ones(real.n)) == -1
    solve_complex(sym, re, im, x, y, np.zeros(2 * real.n))
    assert np.abs(A @ (x + 1j * y) - b).max() < 1e-11 * np.abs(b).max()


def test_a_lost_pivot_of_a_complex_matrix_is_named():
    case = chain(2, 1, seed=1)
    pattern = case.pattern()
    zeros = np.zeros(pattern.size)
    assert factor_complex(tables(pattern), zeros, zeros.copy(), np.ones(case.n)) >= 0
