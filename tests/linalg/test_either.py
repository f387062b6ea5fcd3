"""Small models with plain arrays: the same start as with sparse matrices, and the same refusals."""

import math

import numpy as np
import pytest
import scipy.sparse as sp

import flexmb as fm
from flexmb.engine.linalg.dense import bordered_solution, plain, scaled_rows, solve_dense, stacked
from flexmb.engine.linalg.rank import surplus_rows
from flexmb.engine.system import state_evaluation as system
from flexmb.errors import AssemblyError, ModelError, SolveError
from flexmb.statics.start import consistent as rigid
from flexmb.statics.start.consistent import consistent_start, degrees_of_freedom


def thrown():
    """A free rod of beams, turned and thrown, with a hinged rigid body that a drive does not hold."""
    steel = fm.Material(young=2.1e11, density=7850.0)
    section = fm.Rectangle(width=0.02, height=0.004)
    bob = fm.RigidBody("bob", (0.0, 0.0), mass=1.0, inertia=0.1, velocity=(0.3, 0.2, 1.5))
    rod = fm.FlexibleLink("rod", (0.5, 0.0), (1.0, 0.2), section=section, material=steel, elements=3)
    return fm.Mechanism("thrown", (bob, rod, fm.Revolute("P", bob, rod, (0.5, 0.0))), gravity=(0.0, -9.81))


MECHANISMS = {
    "worn": lambda: fm.mechanisms.slider_crank(clearance=2e-4, friction="coulomb", start=0.3),
    "flexible": lambda: fm.mechanisms.slider_crank(flexible=True, elements=4, start=0.3),
    "nine-bar": lambda: fm.mechanisms.nine_bar(2.0 * math.pi, clearance=1e-4),
    "thrown": thrown,
}


def start(mechanism, *, limit, monkeypatch):
    monkeypatch.setattr(system, "DENSE_UNKNOWNS", limit)
    monkeypatch.setattr(rigid, "DENSE_UNKNOWNS", limit)
    program = fm.compile(mechanism)
    found = consistent_start(mechanism, program)
    freedom = degrees_of_freedom(fm.compile(mechanism, closed=True), found.q)
    return found, freedom


@pytest.mark.parametrize("name", MECHANISMS)
def test_plain_arrays_start_where_sparse_matrices_do(name, monkeypatch):
    mechanism = MECHANISMS[name]()
    small, freedom = start(mechanism, limit=10_000, monkeypatch=monkeypatch)
    large, same = start(mechanism, limit=0, monkeypatch=monkeypatch)
    assert freedom == same
    for field in ("q", "v", "a", "lam"):
        one, other = getattr(small, field), getattr(large, field)
        assert np.abs(other).max() > 0.0 or field in ("lam", "v")
        np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-9 * np.abs(other).max(), err_msg=field)


def parallel():
    """Three parallel cranks of one coupler: one joint more than the motion needs, in every pose."""
    cranks = [fm.RigidLink(f"crank{k}", (float(k), 0.0), (k + 0.3, 0.4), 1.0, 0.02) for k in range(3)]
    coupler = fm.RigidLink("coupler", (0.3, 0.4), (2.3, 0.4), 2.0, 0.7)
    joints = []
    for k, link in enumerate(cranks):
        joints.append(fm.Revolute(f"O{k}", fm.GROUND, link, (float(k), 0.0)))
        joints.append(fm.Revolute(f"A{k}", link, coupler, (k + 0.3, 0.4)))
    drive = fm.Drive("motor", "O0", fm.ConstantSpeed(2.0))
    return fm.Mechanism("parallel", (*cranks, coupler, *joints, drive), gravity=(0.0, -9.81))


@pytest.mark.parametrize("limit", [0, 10_000], ids=["sparse", "plain"])
def test_joints_that_repeat_one_another(limit, monkeypatch):
    """All move alike: cranks of length 0.5 at 2 rad/s, a coupler that translates; supports carry the whole weight."""
    monkeypatch.setattr(system, "DENSE_UNKNOWNS", limit)
    monkeypatch.setattr(rigid, "DENSE_UNKNOWNS", limit)
    mechanism = parallel()
    program = fm.compile(mechanism)
    with pytest.raises(ModelError, match="over-constrained by 1 row"):
        consistent_start(mechanism, program)
    found = consistent_start(mechanism, program, redundant=True)
    assert found.redundant == 1
    coupler = slice(9, 12)
    np.testing.assert_allclose(found.v[coupler], [-0.8, 0.6, 0.0], atol=1e-12)  # 2 rad/s across (0.3, 0.4)
    np.testing.assert_allclose(found.a[coupler], [-1.2, -1.6, 0.0], atol=1e-10)  # -4/s2 of (0.3, 0.4)


@pytest.mark.parametrize("limit", [0, 10_000], ids=["sparse", "plain"])
def test_a_velocity_that_the_joints_forbid(limit, monkeypatch):
    monkeypatch.setattr(system, "DENSE_UNKNOWNS", limit)
    monkeypatch.setattr(rigid, "DENSE_UNKNOWNS", limit)
    rod = fm.RigidLink("rod", (0.0, 0.0), (1.0, 0.0), 1.0, 0.1, velocity=(1.0, 0.0, 0.0))
    mechanism = fm.Mechanism("m", (rod, fm.Revolute("O", fm.GROUND, rod, (0.0, 0.0))))
    with pytest.raises(AssemblyError, match=r"largest violation 1 m/s or rad/s at 'O'"):
        consistent_start(mechanism, fm.compile(mechanism))


def test_rank_of_rows_with_a_repeated_one():
    G = np.array([[1.0, 0.0, 2.0, 0.0], [0.0, 1e-6, 0.0, 0.0], [1e3, 0.0, 2e3, 0.0]])
    for matrix in (G, sp.csr_matrix(G)):
        assert surplus_rows(matrix) in ((0,), (2,))  # they say the same
    assert surplus_rows(G[:2]) == surplus_rows(sp.csr_matrix(G[:2])) == ()
    assert surplus_rows(np.zeros((2, 3))) == (0, 1)
    assert surplus_rows(np.zeros((0, 3))) == ()


def test_borders():
    """min x^2 + 2 y^2 with x + y = 3: x = 2, y = 1, multiplier -4 of the doubled energy."""
    S, A = np.diag([2.0, 4.0]), np.array([[1.0, 1.0]])
    for convert in (np.asarray, sp.csc_matrix):
        x = bordered_solution(convert(S), convert(A), np.array([0.0, 0.0, 3.0]))
        np.testing.assert_allclose(x, [2.0, 1.0, -4.0], rtol=1e-14)
        twice = stacked(convert(A), scaled_rows(np.array([2.0]), convert(A)))
        np.testing.assert_array_equal(plain(twice), [[1.0, 1.0], [2.0, 2.0]])
        assert bordered_solution(convert(np.zeros((2, 2))), convert(A), np.ones(3)) is None


def test_dense_solution_of_badly_scaled_equations():
    """[[2, 1], [1, 1]] x = [4, 3] has x = [1, 2]; rows times 1e12 and 1e-9, columns times 1e-5 and 1e7."""
    A = np.array([[1e12], [1e-9]]) * np.array([[2.0, 1.0], [1.0, 1.0]]) * np.array([1e-5, 1e7])
    b = np.array([1e12, 1e-9]) * np.array([4.0, 3.0])
    np.testing.assert_allclose(solve_dense(A, b), [1e5, 2e-7], rtol=1e-14)


def test_dense_refusals():
    with pytest.raises(SolveError, match="2 x 2 matrix is singular"):
        solve_dense(np.array([[1.0, 2.0], [2.0, 4.0]]), np.array([1.0, 0.0]))
    third = np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.0]])  # singular, but not for a computer
    with pytest.raises(SolveError, match="3 x 3 matrix is singular"):
        solve_dense(third, np.array([1.0, 0.0, 0.0]))
    with pytest.raises(SolveError, match=r"entry \(1, 0\) of the matrix is nan"):
        solve_dense(np.array([[1.0, 2.0], [math.nan, 4.0]]), np.ones(2))
