"""The datasets of sweeps, from the arrays of a record or of a store."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from flexmb.sweeps.record import Tables
from flexmb.sweeps.store import VERSION, existing

if TYPE_CHECKING:
    import xarray as xr

AXES, LAYOUT = "axes", "layout"
"""Attributes that say how to read the others: names of the coordinates; results of a function, which are written when
the arrays for them are there."""

POINTS, STATE = "points", "state"
"""Columns of a diagram that the dataset does not have under these names: all signals, and states to go on from."""


def load_sweep(path: str | Path) -> xr.Dataset:
    """The dataset of a store, as `bifurcation` or `sweep` returns it; of an unfinished one what there is so far.

    Points that are not finished have an empty status.

    Parameters
    ----------
    path : the folder that was given as `store`.

    Raises
    ------
    InputError : what is no path.
    FileFormatError : no store there, not one of flexmb, damaged, or in a format of another version.
    MissingPackageError : zarr is not installed.
    """
    store = existing(path)
    attributes = {k: v for k, v in store.attributes.items() if k not in (VERSION, "fingerprint")}
    return dataset_of(store.read(), attributes)


def dataset_of(tables: Tables, attributes: Mapping[str, Any]) -> xr.Dataset:
    """The dataset of a record or store, whose attribute `kind` says which one it is."""
    import xarray as xr

    entries = {name: (dims, _plain(values), dict(attrs)) for name, (dims, values, attrs) in tables.items()}
    if attributes["kind"] == "bifurcation":
        entries = _signals_apart(entries)
        entries.pop(STATE, None)
    coordinates = {name: entries.pop(name) for name in attributes[AXES]}
    shown = {name: value for name, value in attributes.items() if name not in (AXES, LAYOUT)}
    found = xr.Dataset(entries, coords=coordinates, attrs=shown)
    if found.attrs.get("direction") not in (None, "both"):
        found = found.isel(direction=0, drop=True)
    return found


def _signals_apart(entries: dict[str, Any]) -> dict[str, Any]:
    """The entries with each signal for itself, in front of the others."""
    dims, values, _ = entries.pop(POINTS)
    names, units = entries.pop("signal")[1], entries.pop("units")[1]
    found = {}
    for k, (name, unit) in enumerate(zip(names, units, strict=True)):
        found[str(name)] = (dims[:-1], np.ascontiguousarray(values[..., k]), {"units": str(unit)} if unit else {})
    return {**found, **entries}


def _plain(values: np.ndarray) -> np.ndarray:
    """Texts as numpy's, which every file format knows."""
    return values.astype(str) if values.dtype == object else values
