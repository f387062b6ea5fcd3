"""Meshes of common outlines: areas, nodes on circles, shapes of cells, bad input."""

import math

import numpy as np
import pytest

from flexmb.elastic.meshes.mesh import PlaneMesh, jacobians
from flexmb.elastic.meshes.outlines import crank_web, link_with_eyes, plate_with_holes, rectangle, ring
from flexmb.errors import InputError

KINDS = ("tri3", "tri6", "quad4", "quad9")


def link_area(length: float, R: float, r: float, w: float) -> float:
    """Area of two discs with holes and a straight bar between them."""
    half = 0.5 * w
    segment = R * R * math.asin(half / R) + half * math.sqrt(R * R - half * half)
    return 2 * math.pi * (R * R - r * r) + w * length - 2 * segment


def filled_area(R: float, w: float, f: float) -> float:
    """Area that fillets of the radius f add to a link: four pieces between circle, shank and arc."""
    half = 0.5 * w
    run, start = math.sqrt((R + f) ** 2 - (half + f) ** 2), math.asin(half / R)
    end = math.atan2(half + f, run)
    corners = np.array([(0, 0), (R * math.cos(start), half), (run, half), (run, half + f)])
    ahead = np.roll(corners, -1, axis=0)
    polygon = 0.5 * float(np.sum(corners[:, 0] * ahead[:, 1] - corners[:, 1] * ahead[:, 0]))
    return 4.0 * (polygon - 0.5 * R * R * (end - start) - 0.5 * f * f * (0.5 * math.pi - end))


def shape_of_worst_cell(mesh: PlaneMesh) -> float:
    """Least over largest Jacobian determinant of a cell, the worst of all cells."""
    J = jacobians(mesh.points, mesh.cells, mesh.kind)
    return float((J.min(axis=1) / J.max(axis=1)).min())


@pytest.mark.quick(4)
@pytest.mark.parametrize("kind", ["tri6", "quad9"])
@pytest.mark.parametrize("width", [0.004, 0.014, 0.02, 0.0285, 0.03])
def test_area_of_a_link_converges_with_order_four(kind, width):
    exact = link_area(0.12, 0.015, 0.008, width)
    errors = [abs(link_with_eyes(0.12, 0.015, 0.008, width, size, kind).area / exact - 1) for size in (0.006, 0.003)]
    assert errors[1] < 3e-5
    assert errors[0] > 5.0 * errors[1]


@pytest.mark.quick(12)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("hole", [0.3, pytest.param(0.6, marks=pytest.mark.slow), 0.9])
@pytest.mark.parametrize(
    "width",
    [0.2, 0.6, pytest.param(0.7, marks=pytest.mark.slow), 0.75, pytest.param(0.8, marks=pytest.mark.slow), 0.95, 1.0],
)
@pytest.mark.parametrize("size", [0.1, 0.5])
def test_links_of_all_proportions_have_sound_cells(kind, hole, width, size):
    mesh = link_with_eyes(4.0, 1.0, hole, 2 * width, size, kind)
    assert shape_of_worst_cell(mesh) > (0.05 if mesh.cell_kind.is_quadratic else 0.15)
    assert mesh.holes == ("start", "end")
    for name, x in (("start", 0.0), ("end", 4.0)):
        assert mesh.centre_of(name) == (x, 0.0)
        np.testing.assert_allclose(np.hypot(*(mesh.points[mesh.sets[name]] - [x, 0.0]).T), hole, rtol=1e-12)


@pytest.mark.parametrize(("width", "fillet"), [(0.004, 0.002), (0.014, 0.005), (0.02, 0.01), (0.0285, 0.005)])
def test_fillets_of_a_link_fill_its_corners(width, fillet):
    exact = link_area(0.12, 0.015, 0.008, width) + filled_area(0.015, width, fillet)
    errors = [
        abs(link_with_eyes(0.12, 0.015, 0.008, width, size, fillet=fillet).area / exact - 1) for size in (0.006, 0.0015)
    ]
    assert errors[0] < 4e-5
    assert errors[1] < 2e-6


@pytest.mark.quick(2)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("width", [0.2, 0.6, 0.75, 0.95])
@pytest.mark.parametrize("size", [0.1, 0.5])
def test_links_with_fillets_have_sound_cells(kind, width, size):
    for fillet in (0.1, 0.3):
        mesh = link_with_eyes(4.0, 1.0, 0.5, 2 * width, size, kind, fillet)
        assert shape_of_worst_cell(mesh) > (0.05 if mesh.cell_kind.is_quadratic else 0.15)
        assert mesh.holes == ("start", "end")


def test_fillets_of_a_tapered_link_are_tangents_of_eye_and_shank():
    """The outline has no corner at the eye with fillets, and corners at the other one."""
    mesh = link_with_eyes(0.2, (0.03, 0.015), (0.02, 0.008), (0.04, 0.02), 0.002, fillet=(0.01, 0.0))
    outline = mesh.points[mesh.loops[0]]
    ahead = np.roll(outline, -1, axis=0) - outline
    turn = np.diff(np.unwrap(np.arctan2(ahead[:, 1], ahead[:, 0])))
    x = outline[1:, 0]
    assert np.abs(turn[x < 0.1]).max() < 0.16  # sharp it turns by 0.8 rad; along an arc of 0.01 m by 0.1 rad an edge
    assert np.abs(turn[x > 0.1]).max() > 0.6


def test_a_tapered_link_is_symmetrical_about_its_axis():
    mesh = link_with_eyes(0.2, (0.03, 0.015), (0.02, 0.008), (0.04, 0.02), 0.004)
    np.testing.assert_allclose(sorted(mesh.points[:, 1]), sorted(-mesh.points[:, 1]), atol=1e-15)
    assert mesh.points[:, 0].min() == pytest.approx(-0.03, rel=1e-6)
    assert mesh.points[:, 0].max() == pytest.approx(0.215, rel=1e-6)


def test_a_crank_web_has_the_area_of_two_circles_with_common_tangents():
    L, R, s = 0.06, 0.035, 0.02
    lean = math.asin((R - s) / L)
    trapezium = (R + s) * L * math.cos(lean)
    exact = trapezium + R * R * (0.5 * math.pi + lean) + s * s * (0.5 * math.pi - lean)
    exact -= math.pi * (0.02**2 + 0.01**2)
    areas = [crank_web(L, (R, s), (0.02, 0.01), size).area for size in (0.004, 0.002)]
    assert areas[1] == pytest.approx(exact, rel=2e-6)
    assert abs(areas[0] - exact) > 5 * abs(areas[1] - exact)
    assert shape_of_worst_cell(crank_web(L, (R, s), (0.02, 0.01), 0.004)) > 0.05


@pytest.mark.parametrize("kind", KINDS)
def test_ring_and_rectangle(kind):
    mesh = ring(0.05, 0.2, 0.01, kind)
    exact = math.pi * (0.2**2 - 0.05**2)
    assert mesh.area == pytest.approx(exact, rel=1e-7 if mesh.cell_kind.is_quadratic else 1e-3)
    for name, radius in (("inner", 0.05), ("outer", 0.2)):
        np.testing.assert_allclose(np.linalg.norm(mesh.points[mesh.sets[name]], axis=1), radius, rtol=1e-12)
    plate = rectangle(2.0, 1.0, 4, 3, kind)
    assert plate.area == pytest.approx(2.0, rel=1e-14)
    assert len(plate.cells) == (24 if kind.startswith("tri") else 12)
    nodes = 2 if mesh.cell_kind.is_quadratic else 1
    assert len(plate.sets["left"]) == 3 * nodes + 1
    assert len(plate.sets["top"]) == 4 * nodes + 1


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: link_with_eyes(0.12, 0.015, 0.016, 0.014, 0.003), "hole is 0.016 m at the start; it must be smaller"),
        (lambda: link_with_eyes(0.12, 0.015, 0.008, 0.04, 0.003), "width is 0.04 m at the start; at most"),
        (lambda: link_with_eyes(0.02, 0.015, 0.008, 0.014, 0.003), "the eyes of 0.015 and 0.015 m overlap"),
        (lambda: link_with_eyes(0.12, (0.015, 0.01, 1), 0.008, 0.014, 0.003), "one number in m, or a pair"),
        (lambda: link_with_eyes(0.12, 0.015, 0.008, 0.014, 0.0), "size is 0 m; it must be > 0"),
        (lambda: link_with_eyes(0.12, 0.015, 0.008, 0.014, 0.003, "tri"), "kind is 'tri'. Did you mean"),
        (lambda: ring(0.2, 0.05, 0.01), "inner is 0.2 m; it must be smaller than outer"),
        (lambda: rectangle(1.0, 1.0, 0, 1), "nx is 0"),
        (lambda: rectangle(1.0, -1.0, 1, 1), "height is -1 m"),
        (lambda: link_with_eyes(120.0, 15.0, 8.0, 14.0, 0.003), "a block would have .* Take larger cells"),
        (lambda: ring(0.05, 0.2, 1e-12), "Take larger cells"),
        (lambda: rectangle(1.0, 1.0, 10**9, 10**9), "Take larger cells"),
        (lambda: plate_with_holes([(0, 0), (1, 0), (0, 1)], {}, 1e-6), "Take larger cells"),
        (lambda: crank_web(0.03, (0.02, 0.02), 0.01, 0.01), "overlap"),
        (lambda: link_with_eyes(0.12, 0.015, 0.008, 0.01, 0.005, fillet=0.2), "0.2 and 0.2 m leave no shank"),
        (lambda: link_with_eyes(0.12, 0.015, 0.008, 0.01, 0.005, fillet=-1e-3), "fillet is -0.001 m"),
    ],
)
def test_bad_input_is_refused(call, words):
    with pytest.raises(InputError, match=words):
        call()
