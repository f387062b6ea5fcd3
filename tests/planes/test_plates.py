"""Plates of any straight outline with holes: area, shapes of triangles, stress around a hole, bad input."""

import math

import numpy as np
import pytest
from scipy.sparse.linalg import spsolve

from flexmb.elastic.meshes.mesh import PlaneMesh, jacobians
from flexmb.elastic.meshes.outlines import plate_with_holes
from flexmb.elastic.planes.cells import matrices
from flexmb.elastic.planes.loads import edge_load
from flexmb.elastic.planes.stress import stress_operator
from flexmb.errors import InputError
from flexmb.model.law import Material

ROCKER = [(-0.02, -0.02), (0.25, -0.02), (0.16, 0.2), (0.1, 0.2)]
HOLES = {"A": ((0.01, 0.005), 0.01), "B": ((0.22, 0.0), 0.01), "C": ((0.13, 0.18), 0.012)}
ANGLE = [(0, 0), (0.1, 0), (0.1, 0.03), (0.03, 0.03), (0.03, 0.1), (0, 0.1)]


def quality(mesh: PlaneMesh) -> np.ndarray:
    """Area over that of the equilateral triangle with the same mean square of its sides."""
    corners = mesh.points[mesh.cells[:, :3]]
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = 0.5 * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
    return 4 * math.sqrt(3) * area / (sides**2).sum(axis=1)


@pytest.mark.slow
@pytest.mark.parametrize("size", [0.012, 0.008, pytest.param(0.004, marks=pytest.mark.slow)])
@pytest.mark.parametrize("turn", [0.0, 0.3])
@pytest.mark.parametrize("kind", ["tri6", "tri3"])
def test_a_rocker_has_even_triangles_and_its_area(size, turn, kind):
    c, s = math.cos(turn), math.sin(turn)
    outline = [(c * x - s * y, s * x + c * y) for x, y in ROCKER]
    holes = {name: ((c * x - s * y, s * x + c * y), r) for name, ((x, y), r) in HOLES.items()}
    mesh = plate_with_holes(outline, holes, size, kind)
    assert mesh.kind == kind
    exact = 0.5 * (0.27 + 0.06) * 0.22 - math.pi * (2 * 0.01**2 + 0.012**2)
    assert mesh.area == pytest.approx(exact, rel=2e-5 if kind == "tri6" else 4e-3)
    assert quality(mesh).min() > (0.1 if size == 0.012 else 0.45)  # walls of 7 mm
    assert quality(mesh).mean() > 0.93
    assert mesh.holes == ("A", "B", "C")
    for name, (centre, radius) in holes.items():
        assert mesh.centre_of(name) == pytest.approx(centre, abs=1e-14)
        np.testing.assert_allclose(np.linalg.norm(mesh.points[mesh.sets[name]] - centre, axis=1), radius, rtol=1e-12)


@pytest.mark.parametrize("fillet", [0.004, 0.0149, [0, 0.01, 0, 0.02, 0.015, 0.015]], ids=str)
@pytest.mark.parametrize("size", [0.008, pytest.param(0.003, marks=pytest.mark.slow)])
def test_fillets_change_the_area_by_their_corners(fillet, size):
    """Square corners: (1 - pi/4) r^2 each, less at five of them, more at the inner one; either way round."""
    radii = np.broadcast_to(fillet, 6)
    exact = 0.1 * 0.03 + 0.07 * 0.03 + (1 - math.pi / 4) * (radii**2 @ [-1, -1, -1, 1, -1, -1])
    for outline, given in ((ANGLE, fillet), (ANGLE[::-1], fillet if np.ndim(fillet) == 0 else fillet[::-1])):
        mesh = plate_with_holes(outline, {}, size, fillet=given)
        assert mesh.area == pytest.approx(exact, rel=3e-5)
        J = jacobians(mesh.points, mesh.cells, mesh.kind)
        assert (J.min(axis=1) / J.max(axis=1)).min() > 0.3


def test_fillets_round_a_triangle_to_a_belt_about_three_circles():
    """Area of a triangle inset by r, of its rim, and of one circle; arcs meet where an edge is used up."""
    r, side = 0.02, 0.2
    height = side * math.sqrt(3) / 2
    inner = side - 2 * r * math.sqrt(3)
    mesh = plate_with_holes([(0, 0), (side, 0), (side / 2, height)], {}, 0.01, fillet=r)
    assert mesh.area == pytest.approx(inner**2 * math.sqrt(3) / 4 + 3 * inner * r + math.pi * r * r, rel=1e-5)
    disc = plate_with_holes([(0, 0), (0.1, 0), (0.1, 0.1), (0, 0.1)], {}, 0.02, fillet=0.05)
    assert disc.area == pytest.approx(math.pi * 0.05**2, rel=1e-4)


@pytest.mark.parametrize(
    ("fillet", "words"),
    [
        (0.02, r"fillets of 0.02 and 0.02 m at corners 1 and 2 take 0.04 m .* 0.75 times these radii at most"),
        ([0.01, 0.01], "fillet has 2 radii, the outline 6 corners"),
        (-0.01, "fillet is -0.01 m"),
        ("round", "fillet is 'round'"),
    ],
)
def test_fillets_that_do_not_fit_are_refused(fillet, words):
    with pytest.raises(InputError, match=words):
        plate_with_holes(ANGLE, {}, 0.005, fillet=fillet)


def test_an_angle_with_an_inner_corner_either_way_round():
    for outline in (ANGLE, ANGLE[::-1]):
        mesh = plate_with_holes(outline, {"a": ((0.08, 0.015), 0.006), "b": ((0.015, 0.08), 0.006)}, 0.004)
        assert mesh.area == pytest.approx(0.0051 - 2 * math.pi * 0.006**2, rel=1e-5)
        assert quality(mesh).min() > 0.45
        assert len(mesh.loops) == 3


@pytest.mark.slow
def test_stress_beside_a_hole_is_three_times_that_far_away():
    """Kirsch: 3 in an infinite plate; Heywood's formula 2 + (1 - d/W)^3 of the net stress for d/W = 0.1: 3.03 gross."""
    steel = Material(2.1e11, 7850.0, 0.3)
    mesh = plate_with_holes([(-0.15, -0.1), (0.15, -0.1), (0.15, 0.1), (-0.15, 0.1)], {"hole": ((0, 0), 0.01)}, 0.0035)
    x, y = mesh.points.T
    sets = {
        "left": np.flatnonzero(x < -0.15 + 1e-9),
        "right": np.flatnonzero(x > 0.15 - 1e-9),
        "hole": mesh.sets["hole"],
    }
    mesh = PlaneMesh(mesh.points, mesh.cells, mesh.kind, sets)
    load = edge_load(mesh, "right", (1e6, 0.0), 0.01) + edge_load(mesh, "left", (-1e6, 0.0), 0.01)
    held = [2 * sets["hole"][0], 2 * np.argmax(x) + 1, 2 * np.argmin(x) + 1]
    free = np.setdiff1d(np.arange(len(load)), held)
    K = matrices(mesh, steel, 0.01).stiffness
    u = np.zeros(len(load))
    u[free] = spsolve(K[free][:, free].tocsc(), load[free])
    stress = (stress_operator(mesh, steel) @ u).reshape(-1, 4)[:, 0]
    hole = mesh.sets["hole"]
    heywood = (2 + 0.9**3) / 0.9
    assert stress[hole].max() == pytest.approx(1e6 * heywood, rel=0.03)
    far = np.hypot(x - 0.1, y) < 0.02
    assert stress[far].mean() == pytest.approx(1e6, rel=0.02)


@pytest.mark.parametrize(
    ("outline", "holes", "words"),
    [
        (ROCKER[:2], {}, "outline has 2 corners"),
        ("round", {}, "outline is 'round'"),
        ([ROCKER[0], ROCKER[2], ROCKER[1], ROCKER[3]], {}, "edges 0 and 2 of the outline cross|edges 1 and 3"),
        (ROCKER, {"A": ((0.5, 0.0), 0.01)}, "hole 'A' does not lie inside of the outline"),
        (ROCKER, {"A": ((0.01, -0.015), 0.01)}, "hole 'A' does not lie inside"),
        (ROCKER, {"A": ((0.1, 0.0), 0.01), "B": ((0.11, 0.0), 0.01)}, "holes 'A' and 'B' overlap"),
        (ROCKER, {"A": ((0.1, 0.0), 0.0)}, "radius of 'A' is 0 m"),
        (ROCKER, {"A": (0.1, 0.0, 0.01)}, r"must be \(\(x, y\), radius\)"),
        (ROCKER, {"A": ((0.1, -0.0099), 0.01)}, r"the boundary is narrow at \(.*Take a smaller size"),
    ],
)
def test_bad_input_is_refused(outline, holes, words):
    with pytest.raises(InputError, match=words):
        plate_with_holes(outline, holes, 0.008)


def test_quadrilaterals_are_not_offered():
    with pytest.raises(InputError, match="kind is 'quad9'"):
        plate_with_holes(ROCKER, HOLES, 0.01, "quad9")


def test_fork_has_two_edges_on_one_line():
    """Two prongs whose ends lie on one line are no crossing; prongs that overlap on that line are one."""
    fork = [(0.0, 0.0), (0.01, 0.0), (0.01, 0.05), (0.012, 0.05), (0.012, 0.0), (0.02, 0.0), (0.02, 0.06), (0.0, 0.06)]
    mesh = plate_with_holes(fork, {"A": ((0.005, 0.03), 0.002)}, 0.002)
    area = matrices(mesh, Material(2.1e11, 1.0, 0.3), 1.0).rigid_properties[0]
    assert area == pytest.approx(0.02 * 0.06 - 0.002 * 0.05 - np.pi * 0.002**2, rel=1e-3)
    overlapping = [*fork[:4], (0.005, 0.05), (0.005, 0.0), *fork[5:]]
    with pytest.raises(InputError, match="cross"):
        plate_with_holes(overlapping, {}, 0.002)
