"""Plane meshes: faults that are refused with numbers and remedy, equality, boundaries, order of cells."""

import pickle

import numpy as np
import pytest

import flexmb as fm
from flexmb.elastic.meshes.mesh import PlaneMesh
from flexmb.elastic.meshes.outlines import link_with_eyes, rectangle, ring
from flexmb.errors import InputError

SQUARE = [(0, 0), (1, 0), (1, 1), (0, 1)]
TWO = [*SQUARE, (2, 0), (2, 1)]
RIGHT = (1, 4, 5, 2)


@pytest.mark.parametrize(
    ("points", "cells", "kind", "words"),
    [
        (SQUARE, [(0, 1, 2, 3)], "quad5", "kind is 'quad5'"),
        ([(0, 0, 0)] * 4, [(0, 1, 2, 3)], "quad4", r"points have shape \(4, 3\)"),
        ("many", [(0, 1, 2, 3)], "quad4", "points are 'many'; they must be"),
        ([*SQUARE[:3], (0, np.nan)], [(0, 1, 2, 3)], "quad4", r"node 3 is at \[0.0, nan\]; coordinates must be finite"),
        (SQUARE, [(0, 1, 2)], "quad4", r"cells have shape \(1, 3\); those of kind 'quad4' must be \(m, 4\)"),
        (SQUARE, [], "quad4", "m >= 1"),
        (SQUARE, [(0, 1, 2), (0, 1, 2, 3)], "quad4", "rows of equal length"),
        (SQUARE, [(0.5, 1, 2, 3)], "quad4", "they must be whole numbers"),
        (SQUARE, [(1, 2, 3, 4)], "quad4", r"cell 0 names the nodes \[1, 2, 3, 4\], but the nodes are 0 ... 3"),
        (SQUARE, [(0, 1, 2, 2)], "quad4", "cell 0 names a node twice"),
        (SQUARE, [(0, 1, 2)], "tri3", r"1 nodes belong to no cell, the first is node 3 at \(0, 1\) m"),
        ([*TWO, (1, 1e-12)], [(0, 1, 2, 3), (6, 4, 5, 2)], "quad4", "nodes 1 and 6 lie at the same place"),
        (TWO, [(0, 1, 2, 3), RIGHT, (4, 5, 2, 1)], "quad4", "cells 1 and 2 have the same corners"),
        (
            TWO,
            [(0, 1, 2, 3), (1, 2, 5, 4)],
            "quad4",
            "1 of 2 cells are flat or inverted; the worst is cell 1, inverted",
        ),
        (SQUARE, [(0, 1, 3, 2)], "quad4", "Its edges cross: name its corners in the order"),
        ([(0, 0), (1, 0), (0.2, 0.2), (0, 1)], [(0, 1, 2, 3)], "quad4", "points inwards: halve it into two triangles"),
        (
            [(0, 0), (1, 0), (0, 1), (0.5, 0.9), (0.5, 0.5), (0, 0.5)],
            [(0, 1, 2, 3, 4, 5)],
            "tri6",
            "Nodes behind its corners are the middles of its edges",
        ),
        (SQUARE, [(0, 3, 2, 1)], "quad4", "Order the nodes of the cells counter-clockwise"),
        ([(0, 0), (1, 0), (2, 0), (1, 1)], [(0, 1, 3), (1, 2, 3), (0, 1, 2)], "tri3", "cell 2, flat"),
        ([(0, 0), (2, 0), (2, 2), (1.5, 0.4)], [(0, 1, 2, 3)], "quad4", "cell 0, inverted"),
        ([*SQUARE, (3, 0), (4, 0), (4, 1), (3, 1)], [(0, 1, 2, 3), (4, 5, 6, 7)], "quad4", "the cells form 2 pieces"),
        ([*SQUARE, (2, 1), (2, 2), (1, 2)], [(0, 1, 2, 3), (2, 4, 5, 6)], "quad4", "2 pieces that share no edge"),
        (
            [(0, 0), (1, 0), (0.5, 1), (0.5, 0.5)],
            [(0, 1, 2), (0, 1, 3)],
            "tri3",
            "cells 0 and 1 lie on the same side of the edge between nodes 0 and 1",
        ),
        (
            [(0, 0), (1, 0), (0.5, 1), (0.5, 0.5), (0.5, -1)],
            [(0, 1, 2), (0, 1, 3), (1, 0, 4)],
            "tri3",
            "3 cells share the edge between nodes",
        ),
    ],
)
def test_faults_are_refused(points, cells, kind, words):
    with pytest.raises(InputError, match=words):
        PlaneMesh(points, cells, kind)


def test_a_hanging_node_is_refused():
    """Cells around a hole; the upper right cell has not the corner of the cell below its edge."""
    points = [(0, 0), (1, 0), (2, 0), (3, 0), (3, 1), (3, 2), (3, 3), (0, 3), (0, 2), (0, 1), (1, 1), (2, 1), (2, 2)]
    points += [(1, 2), (1, 3)]
    cells = [
        (0, 1, 10, 9),
        (1, 2, 11, 10),
        (2, 3, 4, 11),
        (11, 4, 5, 12),
        (9, 10, 13, 8),
        (8, 13, 14, 7),
        (13, 5, 6, 14),
    ]
    with pytest.raises(InputError, match=r"node 12 at \(2, 2\) m lies on the edge between nodes 13 and 5"):
        PlaneMesh(points, cells, "quad4")


def test_a_body_that_touches_itself_in_a_node_is_refused():
    """A frame of eight cells with a corner cell twice removed: two cells meet in one node alone."""
    x, y = np.meshgrid(np.arange(4), np.arange(4))
    number = lambda i, j: 4 * j + i  # noqa: E731
    cells = [
        (number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)) for i in range(3) for j in range(3)
    ]
    whole = np.stack([x.ravel(), y.ravel()], axis=1)
    chosen = [c for k, c in enumerate(cells) if k not in (4, 8)]
    used = np.unique(chosen)
    renumbered = np.searchsorted(used, chosen)
    with pytest.raises(InputError, match="touches itself at node"):
        PlaneMesh(whole[used], renumbered, "quad4")


@pytest.mark.parametrize(
    ("sets", "words"),
    [
        ({"left": []}, "set 'left' has no nodes"),
        ({"left": [0, 9]}, "set 'left' names the node 9, but the nodes are 0 ... 3"),
        ({"left": [0, 0]}, "set 'left' names a node twice"),
        ({"a.b": [0]}, "name is 'a.b'"),
        ({"left": [0.5]}, "whole numbers"),
        ([1, 2], "sets is"),
    ],
)
def test_wrong_sets_are_refused(sets, words):
    with pytest.raises(InputError, match=words):
        PlaneMesh(SQUARE, [(0, 1, 2, 3)], "quad4", sets)


def test_curved_cells_that_fold_over_are_refused():
    """A quadratic edge whose middle lies far beyond the cell."""
    good = rectangle(1.0, 1.0, 1, 1)
    points = good.points.copy()
    points[np.argmin(np.hypot(*(points - [0.5, 0.0]).T))] = (0.5, 0.9)
    with pytest.raises(InputError, match="1 of 1 cells are flat or inverted"):
        PlaneMesh(points, good.cells, "quad9")


def test_equal_meshes_are_equal_and_hash_alike_also_after_pickling():
    a, b = (link_with_eyes(0.12, 0.02, 0.01, 0.02, 0.01) for _ in range(2))
    assert a == b
    assert hash(a) == hash(b)
    assert pickle.loads(pickle.dumps(a)) == a  # noqa: S301 - written here
    assert a != a.placed(shift=(1e-9, 0.0))
    assert a != PlaneMesh(a.points, a.cells, a.kind, {"start": a.sets["start"]}, name=a.name)
    assert a != "mesh"


def test_arrays_cannot_be_changed():
    mesh = rectangle(1.0, 1.0, 1, 1)
    for array in (mesh.points, mesh.cells, mesh.sets["left"]):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0
    with pytest.raises(TypeError):
        mesh.sets["new"] = np.array([0])


def test_boundary_loops_turn_left_around_the_body():
    mesh = ring(0.05, 0.2, 0.05)
    outline, hole = mesh.loops
    angle = [np.unwrap(np.arctan2(*mesh.points[loop].T[::-1])) for loop in (outline, hole)]
    assert (np.diff(angle[0]) > 0).all()
    assert (np.diff(angle[1]) < 0).all()
    assert set(outline.tolist()) == set(mesh.sets["outer"].tolist())
    assert mesh.holes == ("inner",)
    assert rectangle(1.0, 1.0, 2, 2).holes == ()


@pytest.mark.parametrize("kind", ["tri3", "quad4"])
def test_to_quadratic_bends_chosen_edges_alone(kind):
    mesh = ring(0.05, 0.2, 0.05, kind)
    bent, straight = mesh.to_quadratic(["inner", "outer"]), mesh.to_quadratic()
    assert straight.area == pytest.approx(mesh.area, rel=1e-13)
    exact = np.pi * (0.2**2 - 0.05**2)
    assert abs(bent.area / exact - 1) < 1e-4 < abs(mesh.area / exact - 1)
    assert bent.kind == {"tri3": "tri6", "quad4": "quad9"}[kind]
    for name, radius in (("inner", 0.05), ("outer", 0.2)):
        np.testing.assert_allclose(np.linalg.norm(bent.points[bent.sets[name]], axis=1), radius, rtol=1e-12)
        assert len(bent.sets[name]) == 2 * len(mesh.sets[name])
    assert bent.holes == mesh.holes
    assert bent.to_quadratic() is bent
    with pytest.raises(InputError, match="lie on no circle"):
        rectangle(1.0, 0.5, 3, 2, kind).to_quadratic(["left"])
    with pytest.raises(InputError, match="no set 'hole'"):
        mesh.to_quadratic(["hole"])


def test_placed_and_scaled_move_all_nodes():
    mesh = rectangle(2.0, 1.0, 2, 1)
    moved = mesh.placed(0.5 * np.pi, (3.0, 1.0)).scaled(1e-3)
    corner = moved.points[np.argmin(np.hypot(*(mesh.points - [2.0, 1.0]).T))]
    np.testing.assert_allclose(corner, [2e-3, 3e-3], atol=1e-15)
    assert moved.area == pytest.approx(2e-6, rel=1e-12)
    assert moved.sets.keys() == mesh.sets.keys()
    with pytest.raises(InputError, match="factor is -1"):
        mesh.scaled(-1.0)


def test_holes_are_named_by_a_point_inside():
    link = link_with_eyes(0.12, 0.02, 0.01, 0.02, 0.01)
    bare = PlaneMesh(link.points, link.cells, link.kind)
    named = bare.with_holes({"a": (0.002, -0.003), "b": (0.12, 0.005)})
    assert {n: named.centre_of(n) for n in named.holes} == {"a": (0.0, 0.0), "b": (0.12, 0.0)}
    with pytest.raises(InputError, match=r"no hole at \(0.06, 0\) m for the name 'c'"):
        bare.with_holes({"c": (0.06, 0.0)})
    with pytest.raises(InputError, match="it has none"):
        rectangle(1.0, 1.0, 1, 1).with_holes({"c": (0.06, 0.0)})


def test_the_centre_of_a_hole_does_not_depend_on_the_spacing_of_its_nodes():
    angle = np.sort(np.random.default_rng(2).uniform(0.0, 2 * np.pi, 40))
    inner, outer = (r * np.stack([np.cos(angle), np.sin(angle)], 1) + [0.3, 0.7] for r in (0.01, 0.03))
    k = np.arange(40)
    cells = np.stack([k, 40 + k, 40 + (k + 1) % 40, (k + 1) % 40], axis=1)
    mesh = PlaneMesh(np.concatenate([inner, outer]), cells, "quad4", {"hole": k})
    assert mesh.centre_of("hole") == (0.3, 0.7)
    assert np.linalg.norm(inner.mean(axis=0) - [0.3, 0.7]) > 1e-4


def test_the_text_of_a_mesh_is_short():
    mesh = fm.meshes.link_with_eyes(length=0.12, eye=0.015, hole=0.008, width=0.014, size=0.003)
    assert repr(mesh) == f"PlaneMesh({len(mesh.points)} nodes, {len(mesh.cells)} quad9, sets start, end)"
