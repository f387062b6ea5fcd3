"""Two right-hand sides in one pass are two solutions, whatever the widths of the panels."""

import numpy as np
import pytest

from flexmb.engine.linalg.lu import LOST_PIVOT, factor, solve, solve_two, tables
from flexmb.engine.linalg.symbolic import symbolic


@pytest.mark.parametrize("n", [1, 2, 3, 4, 5, 17])
@pytest.mark.parametrize("band", [1, 2, 4])
def test_both_solutions_fulfil_their_equations(n, band):
    random = np.random.default_rng(10 * n + band)
    A = random.uniform(-1.0, 1.0, (n, n)) + 2.0 * (band + 1) * np.eye(n)
    A[np.abs(np.subtract.outer(np.arange(n), np.arange(n))) > band] = 0.0
    i, j = np.nonzero(A)
    pattern = symbolic(n, i, j, np.arange(n))
    values = np.zeros(pattern.size)
    values[pattern.positions(i, j)] = A[i, j]
    sym = tables(pattern)
    assert factor(sym, values, np.zeros(n), LOST_PIVOT) == -1
    b, c = random.uniform(-1.0, 1.0, (2, n))
    x, z, y = np.zeros(n), np.zeros(n), np.zeros(n)
    solve_two(sym, values, b, c, x, z, np.zeros(2 * n))
    np.testing.assert_allclose(A @ x, b, rtol=0.0, atol=1e-14)
    np.testing.assert_allclose(A @ z, c, rtol=0.0, atol=1e-14)
    solve(sym, values, b, x, y)
    np.testing.assert_allclose(A @ x, b, rtol=0.0, atol=1e-14)
