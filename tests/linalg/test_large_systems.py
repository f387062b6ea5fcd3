"""Large systems: order of elimination, factors that are kept, signs of eigenvalues of bordered matrices."""

import numpy as np
import pytest
import scipy.linalg as la
import scipy.sparse as sp

from flexmb.engine.linalg import ordering
from flexmb.engine.linalg.dense import PivotingSolver
from flexmb.engine.linalg.large import KeptFactors, is_regular, negative_eigenvalues, solver
from flexmb.engine.linalg.ordering import elimination_order
from flexmb.engine.linalg.symbolic import symbolic
from flexmb.errors import SolveError


class Grid:
    """A square grid of nodes with two unknowns, coupled in cells; constraints of one row hold pairs of nodes."""

    def __init__(self, side, held=()):
        count = side * side
        nodes = np.arange(count).reshape(side, side)
        cells = np.stack([nodes[:-1, :-1], nodes[:-1, 1:], nodes[1:, :-1], nodes[1:, 1:]], axis=-1).reshape(-1, 4)
        self.edges = [tuple(cell) for cell in cells.tolist()]
        self.edges += [(*pair, count + k) for k, pair in enumerate(held)]
        self.blocks = [range(2 * k, 2 * k + 2) for k in range(count)]
        self.blocks += [range(2 * count + k, 2 * count + k + 1) for k in range(len(held))]
        self.last = [False] * count + [True] * len(held)
        self.n, self.count = 2 * count + len(held), count

    def pattern(self):
        rows, cols = [], []
        for edge in self.edges:
            unknowns = np.concatenate([np.array(self.blocks[k]) for k in edge])
            rows.append(np.repeat(unknowns, len(unknowns)))
            cols.append(np.tile(unknowns, len(unknowns)))
        order = elimination_order(self.blocks, self.edges, self.last)
        return symbolic(self.n, np.concatenate(rows), np.concatenate(cols), order)

    def matrix(self, pattern, seed):
        """A symmetric matrix (n, n), positive on the coordinates."""
        rng = np.random.default_rng(seed)
        A = sp.csr_array((rng.normal(size=len(pattern.a_rows)), (pattern.a_rows, pattern.a_cols)), shape=(self.n,) * 2)
        A = (A + A.T).tolil()
        A[2 * self.count :, 2 * self.count :] = 0.0
        diagonal = np.where(np.arange(self.n) < 2 * self.count, 40.0, 0.0)
        return (A + sp.diags_array(diagonal)).tocsr()


def values_of(pattern, A):
    values = np.zeros(pattern.size)
    values[pattern.places] = np.asarray(A[pattern.a_rows, pattern.a_cols]).ravel()
    return values


def test_a_large_graph_fills_no_more_and_its_constraints_wait(monkeypatch):
    grid = Grid(34, held=[(0, 5), (100, 900), (1100,)])
    assert len(grid.blocks) > ordering.LARGE_GRAPH
    large = grid.pattern()
    place = np.argsort(large.order)
    for edge in grid.edges[-3:]:
        *nodes, row = edge
        assert place[grid.blocks[row][0]] > max(place[grid.blocks[k]].max() for k in nodes)
    monkeypatch.setattr(ordering, "LARGE_GRAPH", len(grid.blocks))
    assert large.size <= 1.02 * grid.pattern().size


def test_a_large_graph_without_edges():
    count = ordering.LARGE_GRAPH + 1
    order = elimination_order([[k] for k in range(count)], [], [k % 2 == 0 for k in range(count)])
    assert sorted(order.tolist()) == list(range(count))


def test_factors_serve_the_next_matrices():
    grid = Grid(12, held=[(0, 5), (70, 100)])
    pattern = grid.pattern()
    A, change = grid.matrix(pattern, 1), grid.matrix(pattern, 2)
    solver_, b = KeptFactors(pattern), np.cos(np.arange(grid.n))
    for share, factored in ((0.0, 1), (1e-4, 1), (1e-3, 1), (5.0, 2), (5.001, 2)):
        values = values_of(pattern, A + share * change)
        x = solver_.factor(values).solve(b)
        assert x == pytest.approx(PivotingSolver(pattern).factor(values).solve(b), rel=1e-11, abs=1e-13)
        assert solver_.factored == factored
    rough = solver_.factor(values_of(pattern, A + 5.1 * change)).solve(b, 1e-3)
    assert rough == pytest.approx(solver_.solve(b), rel=1e-2, abs=1e-4)


def test_kept_factors_refuse_a_singular_matrix():
    grid = Grid(8, held=[(0, 5), (0, 5)])
    pattern = grid.pattern()
    A = grid.matrix(pattern, 1).toarray()
    A[-1], A[:, -1] = A[-2], A[:, -2]
    A = sp.csr_array(A)
    good = KeptFactors(pattern).factor(values_of(pattern, grid.matrix(pattern, 1)))
    good.solve(np.ones(grid.n))
    for one in (KeptFactors(pattern), good):
        with pytest.raises(SolveError, match="singular"):
            one.factor(values_of(pattern, A)).solve(np.ones(grid.n))
        assert not one.is_regular()
    assert good.factor(values_of(pattern, grid.matrix(pattern, 1))).is_regular()
    with pytest.raises(SolveError, match="must be finite"):
        good.factor(np.full(pattern.size, np.nan))


@pytest.mark.parametrize("shift", [0.0, 20.0, 41.0, 80.0])
@pytest.mark.parametrize("repeated", [False, True])
def test_signs_of_eigenvalues_on_the_null_space(shift, repeated):
    """Beside a dense eigensolver; coordinates without stiffness of their own are held by constraints."""
    grid = Grid(7, held=[(0, 5), (30, 41), (30, 41), (48,)])
    pattern = grid.pattern()
    A, n = grid.matrix(pattern, 3).toarray(), 2 * grid.count
    A[96:98, :n], A[:n, 96:98] = 0.0, 0.0
    A[-1, 97] = A[97, -1] = 0.0
    A[-1, 96] = A[96, -1] = 1.0
    A[97, 97] = 1.0
    if repeated:
        A[-2], A[:, -2] = A[-3], A[:, -3]
    A = sp.csr_array(A)
    K, G = A[:n, :n] - shift * sp.eye_array(n), A[n:, :n]
    Z = la.null_space(G.toarray())
    expected = int((la.eigvalsh(Z.T @ (K @ Z)) < 0.0).sum())
    assert negative_eigenvalues(K, G, pattern.order) == expected
    assert is_regular(K, G, pattern.order) is not repeated


def test_solver_with_rows_beyond_its_order():
    grid = Grid(6, held=[(0, 5)])
    pattern = grid.pattern()
    A = grid.matrix(pattern, 4)
    row = sp.csr_array(np.ones((1, grid.n)))
    whole = sp.block_array([[A, row.T], [row, None]]).tocsc()
    b = np.arange(grid.n + 1.0)
    assert whole @ solver(whole, pattern.order)(b) == pytest.approx(b, abs=1e-10)
