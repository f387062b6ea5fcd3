"""Stresses of flexible bodies at the saved instants: at the ends of beam elements, at the nodes of meshes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from flexmb.beams.hermite import section_forces
from flexmb.bodies.beam_stress import knows_stress, number_of, section_factors
from flexmb.bodies.flexible_body import FlexibleBody
from flexmb.errors import InputError
from flexmb.model.shape import BeamShape, MeshShape
from flexmb.planes.plane_body import PlaneBody
from flexmb.planes.recovery import von_mises
from flexmb.planes.stress import principal
from flexmb.reduction.reduced import Reduced
from flexmb.results.drawing import nearest_to_each, pose, surface
from flexmb.results.reference_points import STRESSED, reference_points
from flexmb.results.surfaces import deformed, shortened, turned

if TYPE_CHECKING:
    import xarray as xr

    from flexmb.model.mechanism import Mechanism
    from flexmb.results.solution import Solution

Wanted = Sequence[tuple[float, float] | int | str]

ENDS = np.array([0.0, 1.0])
"""Both ends of an element."""

MEANINGS = {
    "sx": "normal stress along x of the body",
    "sy": "normal stress along y of the body",
    "txy": "shear stress in the axes of the body",
    "principal_1": "larger principal stress in the plane",
    "principal_2": "smaller principal stress in the plane",
    "axial": "stress of the axial force",
    "bending": "stress of the bending moment in the outer fibre on the left",
    "signed": "normal stress that is largest by its absolute value",
    "von_mises": "von Mises stress",
}
"""Names and meanings of the stresses."""


class Places(NamedTuple):
    """Places of known stresses.

    Parameters
    ----------
    nodes : (m,) numbers of the nodes.
    points : (m, 2) their places in the reference configuration [m].
    names : numbers of the nodes by the names of nodes.
    more : further coordinates (m,), with their units.
    """

    nodes: np.ndarray
    points: np.ndarray
    names: Mapping[str, int]
    more: Mapping[str, tuple[np.ndarray, str]]


def stress(
    sol: Solution,
    body: str,
    points: Wanted | None = None,
    *,
    times: Sequence[float] | None = None,
    mechanism: Mechanism | None = None,
) -> xr.Dataset:
    """Stresses of a flexible body over time; see `Solution.stress`."""
    part = _body(sol, body, mechanism)
    instants = np.arange(len(sol.time)) if times is None else nearest_to_each(sol, np.asarray(times, dtype=float))
    if isinstance(part, FlexibleBody):
        places, fields = _of_beams(sol, part, instants)
    else:
        shape = next(s for s in sol.shapes if isinstance(s, MeshShape) and s.part == part.name)
        places = Places(np.arange(len(shape.points)), reference_points(part), {}, {})
        of = _of_plane if isinstance(part, PlaneBody) else _of_reduced
        fields = _with_principal(of(sol, part, shape, instants))  # type: ignore[arg-type]
    chosen = np.arange(len(places.nodes)) if points is None else chosen_places(part.label, places, points)
    return _dataset(sol, part.name, instants, places, chosen, fields)


def moved_mechanism(sol: Solution, name: str, mechanism: Mechanism | None) -> Mechanism:
    """The mechanism that moved, or the given one for a solution that was read from a file."""
    known = sol.mechanism if mechanism is None else mechanism
    if known is None:
        text = f"Solution of {sol.name!r}: it was read from a file and does not know the body {name!r}"
        raise InputError(f"{text}. Give mechanism=..., the mechanism that moved.")
    return known


def _body(sol: Solution, name: str, mechanism: Mechanism | None) -> STRESSED:
    """The body of this name, in the mechanism that moved or the given one."""
    known = moved_mechanism(sol, name, mechanism)
    part = known.find(name)
    if not isinstance(part, STRESSED):
        raise InputError(f"{part.label} has no stresses. Name a flexible body of {known.name!r}.")
    source = part.body if isinstance(part, Reduced) else part
    if isinstance(source, FlexibleBody) and not all(knows_stress(beam.section) for beam in source.beams):
        text = f"{part.label}: a section does not know its outer fibre, so there are no stresses"
        raise InputError(f"{text}. Give outer_fibre=... [m] to the section.")
    return part


def _of_beams(sol: Solution, body: FlexibleBody, instants: np.ndarray) -> tuple[Places, dict[str, np.ndarray]]:
    """Stresses (n, 2 elements) at both ends of all elements."""
    shapes = [shape for shape in sol.shapes if isinstance(shape, BeamShape) and shape.part == body.name]
    poses = {name: pose(sol, body.name, name, instants) for shape in shapes for name in (shape.start, shape.end)}
    factors = np.concatenate([np.stack(list(pairwise(section_factors(beam).T))) for beam in body.beams])
    axial, bending = [], []
    for shape, factor in zip(shapes, factors, strict=True):
        forces = section_forces(poses[shape.start], poses[shape.end], shape, ENDS)
        axial.append(forces.N * factor[:, 0])
        bending.append(-forces.M * factor[:, 1])
    numbers = np.array([number_of(name) for shape in shapes for name in (shape.start, shape.end)])
    stations = [np.repeat(beam.stations, 2)[1:-1] for beam in body.beams]
    more = {
        "beam": (np.repeat(np.arange(len(stations)), [len(s) for s in stations]), ""),
        "element": (np.repeat(np.arange(len(shapes)), 2), ""),
        "station": (np.concatenate(stations), "m"),
    }
    known = {node.name: number_of(node.name) for node in body.nodes()}
    known |= {alias: known[name] for alias, name in body.aliases.items()}
    places = Places(numbers, reference_points(body)[numbers], known, more)
    N, M = np.concatenate(axial, axis=1), np.concatenate(bending, axis=1)
    signed = N + np.copysign(np.abs(M), N)
    return places, {"axial": N, "bending": M, "signed": signed, "von_mises": np.abs(signed)}


def _of_plane(sol: Solution, body: PlaneBody, shape: MeshShape, instants: np.ndarray) -> np.ndarray:
    """Stresses (n, nodes, 4) sx, sy, txy, sz of a body with all nodes of its mesh, in axes that turn with it."""
    moved = surface(sol, shape, instants)
    X, x = body.mesh.points, moved.points
    X, x = X - X.mean(axis=0), x - x.mean(axis=1, keepdims=True)
    along, across = (X * x).sum(axis=(1, 2)), (X[:, 0] * x[..., 1] - X[:, 1] * x[..., 0]).sum(axis=1)
    return turned(moved.stress, -np.arctan2(across, along))


def _of_reduced(sol: Solution, body: Reduced, shape: MeshShape, instants: np.ndarray) -> np.ndarray:
    """Stresses (n, nodes, 4) sx, sy, txy, sz of a reduced body in its axes: sums of the stresses of its shapes."""
    stresses = body.model.stresses
    if stresses is None:
        raise InputError(f"{body.label} has no stresses.")
    poses = np.stack([pose(sol, shape.part, node, instants) for node in shape.nodes], axis=1)
    e = shortened(deformed(shape, poses)[0], body.element.directions)
    found: np.ndarray = np.einsum("msi,ti->tms", stresses(body.basis.shapes), e, optimize=True)
    return found


def _with_principal(whole: np.ndarray) -> dict[str, np.ndarray]:
    """Stresses by name."""
    sx, sy, txy, _ = np.moveaxis(whole, -1, 0)
    larger, smaller, _ = principal(whole[..., :3])
    signed = np.where(larger + smaller >= 0.0, larger, smaller)
    found = {"sx": sx, "sy": sy, "txy": txy, "principal_1": larger, "principal_2": smaller, "signed": signed}
    return {**found, "von_mises": von_mises(whole)}


def chosen_places(label: str, places: Places, points: Wanted) -> np.ndarray:
    """Numbers of the places at given nodes (numbers or names), or nearest to given points (x, y) [m]."""
    found: list[int] = []
    for point in points:
        if isinstance(point, str) and point in places.names:
            number = places.names[point]
        elif isinstance(point, int | np.integer):
            number = int(point)
        elif np.shape(point) == (2,) and not isinstance(point, str):
            gap = np.hypot(*(places.points - np.asarray(point, dtype=float)).T)
            number = int(places.nodes[np.argmin(gap)])
        else:
            number = -1
        own = np.flatnonzero(places.nodes == number)
        if not len(own):
            last = int(places.nodes.max())
            known = f"(x, y) [m] in the reference configuration, or numbers of nodes from 0 to {last}"
            names = f", or names: {', '.join(list(places.names)[-3:])}" if places.names else ""
            raise InputError(f"{label}: {point!r} is no known point. Give {known}{names}.")
        found += own.tolist()
    return np.array(found, dtype=np.int64)


def _dataset(
    sol: Solution,
    part: str,
    instants: np.ndarray,
    places: Places,
    chosen: np.ndarray,
    fields: Mapping[str, np.ndarray],
) -> xr.Dataset:
    """The stresses with their coordinates and units."""
    import xarray as xr

    time = xr.Variable("time", sol.time[instants], {"units": "s", "long_name": "time"})
    own = {"node": (places.nodes, ""), "x": (places.points[:, 0], "m"), "y": (places.points[:, 1], "m"), **places.more}
    coords: dict[str, Any] = {name: ("place", values[chosen], {"units": unit}) for name, (values, unit) in own.items()}
    columns = {
        name: (("time", "place"), values[:, chosen], {"units": "Pa", "long_name": MEANINGS[name]})
        for name, values in fields.items()
    }
    return xr.Dataset(columns, coords={"time": time, **coords}, attrs={"mechanism": sol.name, "part": part})
