"""Null vectors of large sparse matrices agree with singular values, and need no dense matrix."""

import numpy as np
import pytest
import scipy.sparse as sp

from flexmb.engine.linalg.large import DENSE_COLUMNS, null_vector


def chain(n, ends):
    """Stiffness (n, n) of springs in a row, `ends` of which are held, with stiffnesses over six powers of ten."""
    stiffness = 10.0 ** np.linspace(-3.0, 3.0, n + 1)
    stiffness[0] = 0.0 if ends < 1 else stiffness[0]
    stiffness[-1] = 0.0 if ends < 2 else stiffness[-1]
    K = sp.diags_array([-stiffness[1:-1], stiffness[:-1] + stiffness[1:], -stiffness[1:-1]], offsets=[-1, 0, 1])
    scale = sp.diags_array(1.0 / np.sqrt(K.diagonal()))
    return (scale @ K @ scale).tocsr()


@pytest.mark.parametrize("n", [20, DENSE_COLUMNS, DENSE_COLUMNS + 1, 3000])
@pytest.mark.parametrize("ends", [0, 1, 2])
def test_a_row_of_springs_is_free_without_supports(n, ends):
    B = chain(n, ends)
    x = null_vector(B)
    assert (x is None) == (ends > 0)
    if x is not None:
        assert np.linalg.norm(x) == pytest.approx(1.0, rel=1e-12)
        assert np.abs(B @ x).max() < 1e-13


@pytest.mark.parametrize(("size", "is_free"), [(1e-11, False), (1e-15, True), (0.0, True)])
def test_the_limit_lies_between_soft_and_free(size, is_free):
    """A coordinate that is held by 1e-11 of the others' stiffness is held; one at the round-off is not."""
    n = 400
    values = np.ones(n)
    values[137] = size
    x = null_vector(sp.diags_array(values).tocsr())
    assert (x is not None) == is_free
    if x is not None:
        assert np.abs(x).argmax() == 137


def test_rows_of_constraints_hold_what_stiffness_leaves_free():
    free = chain(500, 0)
    held = sp.coo_array(([1.0], ([0], [250])), shape=(1, 500)).tocsr()
    assert null_vector(sp.vstack([free, held])) is None
    assert null_vector(sp.vstack([free, 0.0 * held])) is not None


def test_of_several_free_motions_one_is_found():
    B = sp.block_diag([chain(200, 0), chain(200, 0), chain(200, 2)]).tocsr()
    x = null_vector(B)
    assert x is not None
    assert np.abs(B @ x).max() < 1e-13
    assert np.abs(x[400:]).max() < 1e-6
