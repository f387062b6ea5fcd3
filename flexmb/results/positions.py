"""Positions of points of flexible bodies at the saved instants: nodes of beams and of meshes, reduced ones too."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from flexmb.bodies.beam_stress import number_of
from flexmb.bodies.flexible_body import FlexibleBody
from flexmb.errors import InputError
from flexmb.model.shape import MeshShape
from flexmb.results.drawing import nearest_to_each, pose, surface
from flexmb.results.reference_points import STRESSED, reference_points
from flexmb.results.stress import Places, Wanted, chosen_places, moved_mechanism

if TYPE_CHECKING:
    import xarray as xr

    from flexmb.model.mechanism import Mechanism
    from flexmb.results.solution import Solution


def positions(
    sol: Solution,
    body: str,
    points: Wanted | None = None,
    *,
    times: Sequence[float] | None = None,
    mechanism: Mechanism | None = None,
) -> xr.Dataset:
    """Positions of points of a flexible body over time; see `Solution.positions`."""
    part = moved_mechanism(sol, body, mechanism).find(body)
    if not isinstance(part, STRESSED):
        raise InputError(f"{part.label} is no flexible body; its signals {body}.x, .y, .theta tell where it is.")
    instants = np.arange(len(sol.time)) if times is None else nearest_to_each(sol, np.asarray(times, dtype=float))
    if isinstance(part, FlexibleBody):
        known = {node.name: number_of(node.name) for node in part.nodes()}
        moved = np.stack([pose(sol, part.name, name, instants)[:, :2] for name in known], axis=1)
        known |= {alias: known[name] for alias, name in part.aliases.items()}
    else:
        known = {}
        shape = next((s for s in sol.shapes if isinstance(s, MeshShape) and s.part == part.name), None)
        if shape is None:
            pins = ", ".join(node.name for node in part.nodes())
            raise InputError(f"{part.label} has no drawn points, only its nodes: {pins}.")
        moved = surface(sol, shape, instants).points
    places = Places(np.arange(moved.shape[1]), reference_points(part), known, {})
    chosen = places.nodes if points is None else chosen_places(part.label, places, points)
    return _dataset(sol, part.name, instants, places, chosen, moved)


def _dataset(
    sol: Solution, part: str, instants: np.ndarray, places: Places, chosen: np.ndarray, moved: np.ndarray
) -> xr.Dataset:
    """Positions with their coordinates and units."""
    import xarray as xr

    time = xr.Variable("time", sol.time[instants], {"units": "s", "long_name": "time"})
    reference = {"node": (places.nodes, ""), "x0": (places.points[:, 0], "m"), "y0": (places.points[:, 1], "m")}
    coords: dict[str, Any] = {name: ("place", v[chosen], {"units": unit}) for name, (v, unit) in reference.items()}
    own = {axis: (("time", "place"), moved[:, chosen, k], {"units": "m"}) for k, axis in enumerate("xy")}
    return xr.Dataset(own, coords={"time": time, **coords}, attrs={"mechanism": sol.name, "part": part})
