"""Signals of bodies with many nodes in a netCDF file: one variable a body and quantity, over time and nodes.

A variable for each of 15,000 signals would take minutes to write and to open.  `plate.node12.vx` is the column of the
node 12 in `plate.node.vx`, whose dimension is the coordinate `plate.node`, the numbers of the nodes.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from flexmb.model.signal import Signals
from flexmb.results.conventions import long_name, udunits

if TYPE_CHECKING:
    import xarray as xr

    from flexmb.results.netcdf_content import NetcdfContent
    from flexmb.results.solution import Solution

MOST_SINGLE = 100
"""Largest number of nodes of a body whose signals have a variable each."""

NUMBERED = re.compile(r"(?P<body>.+\.node)(?P<number>\d+)\.(?P<quantity>[^.]+)")
"""Name of a signal of a numbered node."""

PEAK, PEAK_TIME = "peak", "peak_time"
"""Last words of the names of variables, and names of attributes: largest absolute values, and their times."""


class Column(NamedTuple):
    """A signal: values (n,), largest absolute value, its time."""

    values: np.ndarray
    peak: float
    time: float


@dataclass(frozen=True)
class NodeTable:
    """One quantity at many nodes of a body.

    Parameters
    ----------
    dimension : name of the dimension of the nodes, "plate.node".
    quantity : last word of the names of the signals, "vx".
    units : SI unit.
    numbers : (m,) numbers of the nodes.
    places : (m,) places of the signals among all signals.
    """

    dimension: str
    quantity: str
    units: str
    numbers: tuple[int, ...]
    places: tuple[int, ...]

    @property
    def name(self) -> str:
        """Name of the variable."""
        return f"{self.dimension}.{self.quantity}"

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the signals (m,)."""
        return tuple(f"{self.dimension}{number}.{self.quantity}" for number in self.numbers)


def node_tables(signals: Signals) -> list[NodeTable]:
    """Tables of all bodies with more than `MOST_SINGLE` nodes.

    The tables of a body have the same nodes; a signal that is saved at other ones, as `signals=` may choose, is left
    out, and so has its own variable.
    """
    found: dict[tuple[str, str, str], list[tuple[int, int]]] = {}
    for place, (name, units) in enumerate(zip(signals.names, signals.units, strict=True)):
        if match := NUMBERED.fullmatch(name):
            key = match["body"], match["quantity"], units
            if str(int(match["number"])) == match["number"]:
                found.setdefault(key, []).append((int(match["number"]), place))
    nodes: dict[str, tuple[int, ...]] = {}
    tables: dict[str, NodeTable] = {}
    for (body, quantity, units), rows in found.items():
        numbers, places = tuple(n for n, _ in rows), tuple(k for _, k in rows)
        table = NodeTable(body, quantity, units, numbers, places)
        if len(numbers) > MOST_SINGLE and nodes.setdefault(body, numbers) == numbers:
            tables.setdefault(table.name, table)
    return [table for table in tables.values() if not {table.name, table.dimension} & signals.places.keys()]


def variables(sol: Solution, tables: Iterable[NodeTable]) -> dict[str, xr.Variable]:
    """Variables of tables: values over time and nodes, peaks and their times over nodes, numbers of the nodes."""
    import xarray as xr

    found = {}
    for table in tables:
        nodes, places, unit = table.dimension, list(table.places), udunits(table.units)
        text = {"long_name": f"numbers of the nodes of {nodes.rpartition('.')[0]}"}
        found[nodes] = xr.Variable(nodes, np.array(table.numbers, dtype=np.int64), text)
        name = long_name(table.name)
        values = np.stack([sol.array(signal) for signal in table.names], axis=1)
        found[table.name] = xr.Variable(("time", nodes), values, {"units": unit, "long_name": name})
        for word, peaks, units, meaning in (
            (PEAK, sol.peaks.values, unit, "largest absolute value"),
            (PEAK_TIME, sol.peaks.times, "s", "time of the largest absolute value"),
        ):
            attrs = {"units": units, "long_name": f"{meaning}, {name}"}
            found[f"{table.name}.{word}"] = xr.Variable(nodes, peaks[places], attrs)
    return found


def read(file: NetcdfContent, name: str, n: int) -> Iterator[tuple[str, Column]]:
    """Names and columns of the signals of a table; a variable that is no table of floats raises `ValueError`."""
    nodes, _, quantity = name.rpartition(".")
    values, numbers = file.array(name), file.array(nodes)
    if values.shape != (n, len(numbers)) or values.dtype != np.float64:
        text = f"{name!r} has shape {values.shape} and type {values.dtype}"
        raise ValueError(f"{text}; it must be {n} x {len(numbers)} floats")
    peaks, times = (file.array(f"{name}.{word}").tolist() for word in (PEAK, PEAK_TIME))
    for number, column, peak, time in zip(numbers.tolist(), values.T, peaks, times, strict=True):
        yield f"{nodes}{number}.{quantity}", Column(column, peak, time)
