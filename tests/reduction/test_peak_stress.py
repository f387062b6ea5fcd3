"""Search for the largest stress of a reduced body, which leaves out groups of nodes, against all nodes."""

import numpy as np
import pytest

import flexmb as fm
from flexmb.elastic.reduced.peak_stress import LANES, groups_of, peak_stress_kernel
from flexmb.results.drawing import Surface

STEEL = fm.Material(young=2.1e11, density=7850.0, poisson=0.3)


@pytest.mark.slow
@pytest.mark.parametrize("state", ["stress", pytest.param("strain", marks=pytest.mark.slow)])
def test_the_search_finds_the_largest_stress_of_all_nodes(state):
    """At deformations of all sizes and shapes, also of single coordinates, in any pose of the body."""
    mesh = fm.meshes.link_with_eyes(length=0.12, eye=0.02, hole=0.01, width=0.02, size=0.005)
    rod = fm.PlaneBody("rod", mesh, at=(0.3, -0.2), angle=0.7, thickness=0.01, material=STEEL, state=state)
    small = fm.Reduced(rod, modes=6)
    mechanism = fm.Mechanism("rod", [small])
    (signal,) = mechanism.contributions().signals
    (shape,) = small.shapes(mechanism)
    reference = np.array([(node.x, node.y, node.theta) for node in small.nodes()])
    random, p, zero = np.random.default_rng(7), np.array(signal.p), np.zeros(reference.size)
    places = set()
    for k in range(100):
        turn, (x, y) = random.uniform(-3.0, 3.0), random.uniform(-1.0, 1.0, 2)
        moved = reference + 10.0 ** random.uniform(-7.0, -3.0) * random.normal(size=reference.shape)
        if k < reference.size:
            moved = reference.copy()
            moved.flat[k] += 1e-4
        c, s = np.cos(turn), np.sin(turn)
        q = np.column_stack([x + c * moved[:, 0] - s * moved[:, 1], y + s * moved[:, 0] + c * moved[:, 1]])
        q = np.column_stack([q, moved[:, 2] + turn])
        largest, node = peak_stress_kernel.dispatcher(p, 0.0, q.ravel(), zero, zero, -1.0)
        assert peak_stress_kernel.dispatcher(p, 0.0, q.ravel(), zero, zero, 0.999 * largest) == (largest, node)
        assert peak_stress_kernel.dispatcher(p, 0.0, q.ravel(), zero, zero, 1.001 * largest)[0] <= 1.001 * largest
        (own,) = Surface("rod", shape, np.zeros((1, 0, 2)), q[None]).von_mises
        assert largest == pytest.approx(own.max(), rel=1e-8, abs=1.0)
        assert own[int(node)] == pytest.approx(own.max(), rel=1e-8, abs=1.0)
        places.add(int(node))
    assert len(places) > 10


def test_peaks_are_those_of_all_steps_and_saved_values_are_exact():
    """Between saved instants, values that are no new peak are left out."""
    mesh = fm.meshes.link_with_eyes(length=0.12, eye=0.02, hole=0.01, width=0.02, size=0.01)
    rod = fm.PlaneBody("rod", mesh, start=(0.05, 0.0), end=(0.17, 0.0), thickness=0.01, material=STEEL)
    mechanism = fm.mechanisms.slider_crank(clearance=1e-4).with_part(fm.Reduced(rod, modes=3))
    few, every = (fm.simulate(mechanism, t_end=0.004, save=save) for save in (20, "steps"))
    assert few.stats.steps == every.stats.steps
    peak, same = (sol.peak("rod.von_mises") for sol in (few, every))
    assert (peak.value, peak.time, peak.place) == (same.value, same.time, same.place)
    assert peak.value > few.array("rod.von_mises").max()
    level = 0.6 * peak.value
    stopped = fm.simulate(mechanism, t_end=0.004, save=2, stop=fm.when("rod.von_mises", above=level))
    assert stopped.array("rod.von_mises")[-1] == pytest.approx(level, rel=1e-3)
    assert stopped.time[-1] <= every.time[every.array("rod.von_mises") > level][0]
    stress = few.stress("rod", times=few.time)["von_mises"]
    np.testing.assert_allclose(few.array("rod.von_mises")[1:], stress.max("place")[1:], rtol=1e-9)


@pytest.mark.parametrize("count", [1, LANES, LANES + 1, 5 * LANES, 1000])
def test_each_node_is_in_one_group(count):
    groups = groups_of(np.random.default_rng(3).normal(size=(count, 4, 6)))
    assert len(groups) == -(-count // LANES)
    assert np.array_equal(np.unique(groups), np.arange(count))
    assert groups.size - count == sum(len(group) - len(set(group)) for group in groups.tolist())
