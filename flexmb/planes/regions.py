"""Values of regions of a mesh: one value for all cells, or one for each region."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeAlias, TypeVar

import numpy as np
import numpy.typing as npt

from flexmb import checks
from flexmb.errors import InputError
from flexmb.model.material import Material
from flexmb.planes.mesh import PlaneMesh

Array = npt.NDArray[np.float64]
Value = TypeVar("Value")
ByRegion: TypeAlias = Value | Mapping[str, Value] | tuple[tuple[str, Value], ...]
"""One value for all cells, or values by the name of a region."""

STRESS, STRAIN = "stress", "strain"
"""Plane stress (thin plates, free to contract across) and plane strain (thick bodies, held across)."""


def by_region(owner: str, field: str, value: ByRegion[Value]) -> tuple[tuple[str, Value], ...]:
    """Pairs (region, value); the region "" stands for all cells."""
    if isinstance(value, Mapping):
        return tuple(value.items())
    if isinstance(value, (tuple, list)):
        pairs = checks.sequence(owner, field, value, "pairs (region, value)")
        if any(not isinstance(pair, tuple) or len(pair) != 2 for pair in pairs):
            raise InputError(f"{owner}: {field} is {value!r}; it must be one value, or a dictionary by region.")
        return pairs
    return (("", value),)


def cell_values(mesh: PlaneMesh, field: str, value: ByRegion[Value]) -> list[tuple[Value, npt.NDArray[np.int64]]]:
    """Values with the cells (m,) that have them; every cell has exactly one, else the regions are refused."""
    pairs = by_region(mesh.label, field, value)
    if [name for name, _ in pairs] == [""]:
        return [(pairs[0][1], np.arange(len(mesh.cells)))]
    found, counts = [], np.zeros(len(mesh.cells), dtype=np.int64)
    for name, item in pairs:
        if name not in mesh.regions:
            known = (
                checks.did_you_mean(name, mesh.regions) if mesh.regions else "The mesh has no regions: give one value."
            )
            raise InputError(f"{mesh.label} has no region {name!r} for {field}. {known}")
        found.append((item, mesh.regions[name]))
        counts[mesh.regions[name]] += 1
    for wrong, word in ((counts == 0, "no region"), (counts > 1, "several regions")):
        if wrong.any():
            cell = int(np.argmax(wrong))
            text = f"{mesh.label}: {int(wrong.sum())} cells are in {word} of {field}, one of them is cell {cell}"
            raise InputError(f"{text}. Give each cell one {field}: regions are {', '.join(mesh.regions)}.")
    return found


def numbers_of_cells(mesh: PlaneMesh, field: str, value: ByRegion[float], unit: str) -> Array:
    """(m,) number of each cell, > 0."""
    numbers = np.empty(len(mesh.cells))
    for item, cells in cell_values(mesh, field, value):
        numbers[cells] = checks.positive(mesh.label, field, item, unit)
    return numbers


def elasticity(mesh: PlaneMesh, material: ByRegion[Material], state: str) -> Array:
    """(m, 3) stiffnesses D11, D12, D33 [Pa] of each cell, of plane stress or plane strain.

    sx = D11 ex + D12 ey, sy = D12 ex + D11 ey, txy = D33 gxy.
    Equations (11.1) and (11.2) of docs/theory/plane_bodies.md.
    """
    checks.one_of(mesh.label, "state", state, (STRESS, STRAIN))
    values = np.empty((len(mesh.cells), 3))
    for item, cells in cell_values(mesh, "material", material):
        require_material(mesh.label, item)
        E, nu = item.young, item.poisson
        if state == STRAIN:
            E, nu = E / (1.0 - nu**2), nu / (1.0 - nu)
        values[cells] = E / (1.0 - nu**2), E * nu / (1.0 - nu**2), 0.5 * E / (1.0 + nu)
    return values


def densities(mesh: PlaneMesh, material: ByRegion[Material]) -> Array:
    """(m,) density of each cell [kg/m^3]."""
    values = np.empty(len(mesh.cells))
    for item, cells in cell_values(mesh, "material", material):
        require_material(mesh.label, item)
        values[cells] = item.density
    return values


def require_material(label: str, item: object) -> None:
    """Refuse a value that is no `Material`."""
    if not isinstance(item, Material):
        raise InputError(f"{label}: material is {item!r}; it must be a Material(...), or a dictionary by region.")
