"""Memory of the reduction: sparse matrices are never lists of rows."""

import tracemalloc

import numpy as np
import pytest

import flexmb as fm
from flexmb.elastic.reduced.models import model_of

STEEL = fm.Material(young=2.07e11, density=7850.0, poisson=0.3)


@pytest.mark.slow
@pytest.mark.parametrize("size", [4e-3, 2e-3])
def test_geometric_stiffness_takes_a_few_times_its_own_size(size):
    """Lists of rows take 50 bytes more for each entry, which are 1.2 GB of a body of 200,000 nodes."""
    mesh = fm.meshes.link_with_eyes(length=0.12, eye=0.02, hole=0.01, width=0.02, size=size)
    body = fm.PlaneBody("rod", mesh, start=(0.0, 0.0), end=(0.12, 0.0), thickness=0.01, material=STEEL)
    model = model_of(body, body.pins)
    z = np.cos(np.arange(model.shape.shape[1]))
    found = model.stress_stiffness(z)
    tracemalloc.start()
    model.stress_stiffness(z)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    own = found.data.nbytes + found.indices.nbytes + found.indptr.nbytes
    assert peak <= 6.0 * own
