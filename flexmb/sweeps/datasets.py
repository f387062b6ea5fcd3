"""Datasets of sweeps, from the arrays of a record or a store."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from flexmb.sweeps.record import ARRAYS, Tables
from flexmb.sweeps.store import VERSION, existing

if TYPE_CHECKING:
    import xarray as xr

AXES, LAYOUT = "axes", "layout"
"""Attributes of a store: names of the coordinates; layout of the results of a function."""

POINTS, STATE = "points", "state"
"""Columns of a diagram that become other variables of the dataset: all signals, and final states."""


def load_sweep(path: str | Path) -> xr.Dataset:
    """Dataset of a store, equal to the result of `bifurcation` or `sweep`.

    Unfinished points of an interrupted run have an empty status.

    Parameters
    ----------
    path : folder of the store, the argument `store` of `bifurcation` or `sweep`.

    Raises
    ------
    InputError : an argument that is not a path.
    FileFormatError : no store, a damaged store, or a format of another version.
    MissingPackageError : zarr is not installed.
    """
    store = existing(path)
    attributes = {k: v for k, v in store.attributes.items() if k not in (VERSION, ARRAYS, "fingerprint")}
    return dataset_of(store.read(), attributes)


def dataset_of(tables: Tables, attributes: Mapping[str, Any]) -> xr.Dataset:
    """Dataset of the arrays and attributes of a record or store."""
    import xarray as xr

    entries = {name: (dims, _plain(values), dict(attrs)) for name, (dims, values, attrs) in tables.items()}
    if attributes["kind"] == "bifurcation":
        entries = _signals_apart(entries)
        entries.pop(STATE, None)
    coordinates = {name: entries.pop(name) for name in attributes[AXES]}
    described = {name: value for name, value in attributes.items() if name not in (AXES, LAYOUT)}
    dataset = xr.Dataset(entries, coords=coordinates, attrs=described)
    if dataset.attrs.get("direction") not in (None, "both"):
        dataset = dataset.isel(direction=0, drop=True)
    return dataset


def _signals_apart(entries: dict[str, Any]) -> dict[str, Any]:
    """Entries of a dataset with the array of section points split into one entry per signal."""
    dims, values, _ = entries.pop(POINTS)
    names, units = entries.pop("signal")[1], entries.pop("units")[1]
    signals = {}
    for k, (name, unit) in enumerate(zip(names, units, strict=True)):
        signals[str(name)] = (dims[:-1], np.ascontiguousarray(values[..., k]), {"units": str(unit)} if unit else {})
    return {**signals, **entries}


def _plain(values: np.ndarray) -> np.ndarray:
    """Values with texts as fixed-width texts of numpy, which all file formats support."""
    return values.astype(str) if values.dtype == object else values
