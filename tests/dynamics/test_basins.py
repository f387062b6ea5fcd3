"""Basins of attraction: exact ones, the one of a known attractor, workers, bad input."""

import math
import runpy
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import flexmb as fm
from flexmb.dynamics.basins import basin
from flexmb.dynamics.systems.given import Map
from flexmb.errors import InputError

flows = runpy.run_path(str(Path(__file__).parent / "flows.py"))


def newton(z):
    """Newton's method for z^3 = 1."""
    w = complex(*z)
    w = w - (w**3 - 1) / (3 * w**2)
    return [w.real, w.imag]


@pytest.fixture(scope="module")
def roots():
    values = np.linspace(-1.5, 1.5, 24)
    return basin(Map(newton, [1.0, 0.5]), ("x0", values), ("x1", values), bound=1e9)  # Newton throws far


@pytest.mark.slow
def test_newtons_method_comes_to_the_three_roots(roots):
    found = {complex(*np.round(a[-1], 6)) for a in roots.attractors}
    exact = {complex(*np.round([math.cos(k), math.sin(k)], 6)) for k in (0.0, 2 * math.pi / 3, -2 * math.pi / 3)}
    assert found == exact
    assert roots.periods == (1, 1, 1)
    assert (roots.number > 0).all()
    # the grid is mirrored in the real axis: so are the basins
    mirror = {roots.number[i, j]: roots.number[-1 - i, j] for i in range(24) for j in range(24)}
    assert all(mirror[roots.number[i, j]] == roots.number[-1 - i, j] for i in range(24) for j in range(24))
    assert sum(roots.fractions.values()) == pytest.approx(1.0)
    # on the real axis beyond 1/2^(1/3) all come to 1
    assert len({roots.number[12, j] for j in range(20, 24)}) == 1


def test_two_wells_share_the_plane_by_symmetry():
    # x'' + 0.5 x' - x + x^3 = 0: (x, v) -> (-x, -v) exchanges the wells
    flow = flows["duffing"](d=0.5, beta=1.0, F=0.0, W=1.0, k=-1.0)
    values = np.linspace(-1.5, 1.5, 6)
    found = basin(flow, ("x", values), ("v", values), period=2.0, tolerance=1e-3)
    assert found.periods == (1, 1)
    np.testing.assert_allclose(sorted(a[-1][0] for a in found.attractors), [-1.0, 1.0], atol=1e-3)
    np.testing.assert_array_equal(found.number, 3 - found.number[::-1, ::-1])
    # at rest inside a well the motion stays there
    right = 1 + int(np.argmax([a[-1][0] for a in found.attractors]))
    energy = 0.5 * values[:, None] ** 2 - 0.5 * values**2 + 0.25 * values**4
    assert (found.number[(energy < 0) & (values > 0)[None, :]] == right).all()


@pytest.mark.slow
def test_turns_of_a_rotor_are_no_distance():
    """A pendulum that a torque turns round is not lost, however small the grid is."""
    body = fm.RigidBody("rotor", at=(0.0, -0.3), mass=1.0, inertia=0.01)
    hinge = fm.Revolute("hinge", fm.GROUND, body, at=(0.0, 0.0))
    brake = fm.TorsionSpring("brake", fm.GROUND, body, stiffness=0.0, damping=0.16)
    parts = [body, hinge, brake, fm.Torque("torque", body, 2.0)]
    flow = fm.chaos.MechanismFlow(fm.Mechanism("rotor", parts, gravity=(0.0, -0.5)), period=0.5)
    found = basin(flow, ("rotor.theta", [-1e-3, 1e-3]), ("rotor.omega", [0.0]), longest=200)
    assert (found.number == 1).all()
    assert np.ptp(found.attractors[0][:, flow.state_names["rotor.theta"]]) > 100.0


@pytest.mark.slow
def test_henon_has_one_attractor_and_a_way_out():
    henon = Map(lambda x, a, b: [1 - a * x[0] * x[0] + x[1], b * x[0]], [0.0, 0.0], parameters={"a": 1.4, "b": 0.3})
    found = basin(henon, ("x0", np.linspace(-2, 2, 14)), ("x1", np.linspace(-2, 2, 14)), longest=300)
    assert found.periods == (0,)
    assert set(np.unique(found.number)) == {-1, 1}
    # Henon 1976: a quadrilateral that is mapped into itself
    corners = np.array([[-1.33, 0.42], [1.32, 0.133], [1.245, -0.14], [-1.06, -0.5]])
    X, Y = np.meshgrid(found.x, found.y)
    inside = np.ones(X.shape, dtype=bool)
    for (x0, y0), (x1, y1) in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        inside &= (x1 - x0) * (Y - y0) - (y1 - y0) * (X - x0) < 0
    assert inside.sum() >= 5
    assert (found.number[inside] == 1).all()


def test_orbits_of_other_periods_are_told_apart():
    # the logistic map at 3.2 has an orbit of period 2, x and y apart: in step or out of step
    pair = Map(lambda x: [3.2 * x[0] * (1 - x[0]), 3.2 * x[1] * (1 - x[1])], [0.3, 0.4])
    found = basin(pair, ("x0", [0.2, 0.45, 0.6]), ("x1", [0.2, 0.45]))
    assert found.periods == (2, 2)
    for points in found.attractors:
        root = math.sqrt(4.2 * 0.2)
        low, high = (4.2 - root) / 6.4, (4.2 + root) / 6.4
        np.testing.assert_allclose(np.sort(points, axis=0), [[low, low], [high, high]], atol=1e-4)


def test_creeping_motions_are_undecided():
    creeping = Map(lambda x: [x[0] - 1e-3 * x[0] ** 3, 0.5 * x[1]], [1.0, 1.0])
    found = basin(creeping, ("x0", [0.8, 1.0]), ("x1", [0.0, 1.0]), longest=60, tolerance=1e-6)
    assert (found.number == 0).all()
    assert "4 are undecided" in found.status


@pytest.mark.parametrize("pool", [pytest.param(ThreadPoolExecutor, marks=pytest.mark.slow), ProcessPoolExecutor])
def test_workers_change_nothing(roots, pool):
    if pool is ProcessPoolExecutor:
        system = Map(np.cos, [0.3, 0.4])  # it can be pickled
        axes = ("x0", [0.0, 1.0, 2.0]), ("x1", [-1.0, 1.0])
    else:
        system, axes = Map(newton, [1.0, 0.5]), (("x0", roots.x), ("x1", roots.y))
    alone = basin(system, *axes, bound=1e9)
    with pool(2) as executor:
        shared = basin(system, *axes, bound=1e9, executor=executor, workers=2)
    np.testing.assert_array_equal(shared.number, alone.number)
    np.testing.assert_array_equal(shared.taken, alone.taken)
    for a, b in zip(shared.attractors, alone.attractors, strict=True):
        np.testing.assert_array_equal(a, b)
    np.testing.assert_array_equal(basin(system, *axes, bound=1e9, executor=3).number, alone.number)


def test_dataset_of_a_basin(roots):
    data = roots.to_dataset()
    assert dict(data.sizes) == {"x0": 24, "x1": 24, "attractor": 3, "point": 1, "coordinate": 2}
    assert data["number"].dims == ("x1", "x0")
    assert data["repeats"].values.tolist() == [1, 1, 1]


@pytest.mark.parametrize(
    ("x", "y", "options", "words"),
    [
        (("x2", [0, 1]), ("x1", [0, 1]), {}, "x is 'x2'"),
        (("x0", [0, 1]), ("x0", [0, 1]), {}, "they must be two numbers"),
        (("x0", []), ("x1", [0, 1]), {}, r"shape \(0,\)"),
        (("x0", ["a"]), ("x1", [0, 1]), {}, "they must be numbers"),
        ((0, [0, 1]), (2, [0, 1]), {}, "the numbers 0 to 1"),
        ("x0", ("x1", [0, 1]), {}, r"must be a pair \(name, values\)"),
        (("x0", [0, 1]), ("x1", [0, 1]), {"longest": 10}, "must be above settle"),
        (("x0", [0, 1]), ("x1", [0, 1]), {"tolerance": -1.0}, "tolerance is -1"),
        (("x0", [0, 1]), ("x1", [0, 1]), {"period": 1.0}, "counts iterations"),
    ],
)
def test_what_is_refused(x, y, options, words):
    with pytest.raises(InputError, match=words):
        basin(Map(np.cos, [0.3, 0.4]), x, y, **options)
