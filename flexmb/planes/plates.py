"""Meshes of plates of any straight outline with round holes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.spatial import cKDTree

from flexmb import checks
from flexmb.errors import InputError
from flexmb.planes.boundary import area_inside
from flexmb.planes.fillets import checked_fillets, rounded
from flexmb.planes.mesh import PlaneMesh
from flexmb.planes.triangles import Shape, require_apart, triangles

Hole = tuple[tuple[float, float], float]
"""Centre and radius [m]."""


def plate_with_holes(
    outline: Sequence[tuple[float, float]],
    holes: Mapping[str, Hole],
    size: float,
    kind: str = "tri6",
    fillet: float | Sequence[float] = 0.0,
) -> PlaneMesh:
    """A plate with straight edges, sharp or rounded corners, and round holes, which are sets of their names.

    Parameters
    ----------
    outline : corners of the outline in order [m].
    holes : centre and radius of each hole by name [m], such as {"start": ((0.0, 0.0), 0.01)}.
    size : length of a triangle's edge [m].
    kind : "tri6", whose edges on holes and fillets are curved, or "tri3".
    fillet : radius of the arcs at all corners, or one radius for each corner; 0: sharp [m].

    Raises
    ------
    InputError : an outline with less than three corners or that crosses itself, holes that overlap or leave the
        outline, walls narrower than the triangles, fillets longer than an edge.

    Notes
    -----
    At a sharp corner that points inwards stresses grow without limit with finer meshes.  A fillet has three edges at
    least, so a small one makes small triangles.
    """
    label = "meshes.plate_with_holes"
    checks.one_of(label, "kind", kind, ("tri6", "tri3"))
    size = checks.positive(label, "size", size, "m")
    given = checks.sequence(label, "outline", outline, "corners (x, y)")
    corners = np.array([checks.point(label, f"outline[{i}]", p) for i, p in enumerate(given)], dtype=float)
    if len(corners) < 3:
        raise InputError(f"{label}: outline has {len(corners)} corners; it must have three at least.")
    radii = checked_fillets(label, fillet, len(corners))
    _require_simple(label, corners)
    if area_inside(corners) < 0.0:
        corners, radii = corners[::-1], radii[::-1]
    corners, arcs = rounded(label, corners, radii, size)
    found = {}
    for name, hole in checks.mapping(label, "holes", holes).items():
        if not isinstance(hole, tuple | list) or len(hole) != 2:
            raise InputError(f"{label}: hole {name!r} is {hole!r}; it must be ((x, y), radius).")
        x, y = checks.point(label, f"centre of {name!r}", hole[0])
        found[checks.identifier(label, name)] = (x, y, checks.positive(label, f"radius of {name!r}", hole[1], "m"))
    shape = Shape(label, corners, found)
    require_apart(label, shape, list(found))
    points, cells, sets = triangles(shape, size)
    mesh = PlaneMesh(points, cells, "tri3", sets, name="plate_with_holes")
    if kind == "tri3":
        return mesh
    where = cKDTree(points)
    bends = [where.query(corners[arc])[1] for arc in arcs]
    round_sets = {str(i): nodes for i, nodes in enumerate([*sets.values(), *bends])}
    curved = PlaneMesh(points, cells, "tri3", round_sets).to_quadratic(list(round_sets))
    own = dict(zip(sets, curved.sets.values(), strict=False))  # the fillets have no names
    return PlaneMesh(curved.points, curved.cells, curved.kind, own, name="plate_with_holes")


def _require_simple(label: str, corners: np.ndarray) -> None:
    """Refuse an outline whose edges cross."""
    ends = np.roll(corners, -1, axis=0)
    n = len(corners)
    for i in range(n):
        for j in range(i + 1, n):
            if (j - i) % n not in (1, n - 1) and _cross(corners[i], ends[i], corners[j], ends[j]):
                raise InputError(f"{label}: edges {i} and {j} of the outline cross. Give its corners in order.")


def _cross(a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray) -> bool:
    """Whether two segments a-b and c-d meet."""

    def side(p: np.ndarray, q: np.ndarray, r: np.ndarray) -> float:
        return float((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]))

    lowest = np.maximum(np.minimum(a, b), np.minimum(c, d))  # of the boxes, which edges on one line need not share
    boxes_meet = bool(np.all(lowest <= np.minimum(np.maximum(a, b), np.maximum(c, d))))
    return boxes_meet and side(a, b, c) * side(a, b, d) <= 0.0 and side(c, d, a) * side(c, d, b) <= 0.0
