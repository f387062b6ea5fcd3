"""Points of a sweep: all combinations of values, or a list of designs; units of their parameters."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmb import checks
from flexmb.errors import InputError
from flexmb.sweeps.record import Index

DESIGN = "design"
RESERVED = ("ok", "status")
UNIT = re.compile(r"\[((?:1/)?[^\[\]\d,]+[^\[\],]*)\]")
"""Pattern of a unit in brackets, such as "[rad/s]" or "[m]", as opposed to a range of numbers."""


@dataclass(frozen=True)
class Points:
    """The points of a sweep.

    Parameters
    ----------
    dims : names of the dimensions: the parameters of a grid, or "design".
    shape : lengths of the dimensions.
    values : values of each parameter along its dimension.
    """

    dims: tuple[str, ...]
    shape: tuple[int, ...]
    values: Mapping[str, Sequence[Any]]

    @property
    def count(self) -> int:
        """Number of points."""
        return math.prod(self.shape)

    def index(self, number: int) -> Index:
        """Indices of point `number` along the dimensions, in the order of computation."""
        return tuple(int(k) for k in np.unravel_index(number, self.shape))

    def at(self, index: Index) -> dict[str, Any]:
        """Arguments of the function at an `index`."""
        if self.dims == (DESIGN,) and DESIGN not in self.values:
            return {name: column[index[0]] for name, column in self.values.items()}
        return {name: self.values[name][k] for name, k in zip(self.dims, index, strict=True)}

    def coordinate(self, name: str) -> tuple[tuple[str, ...], np.ndarray]:
        """Dimension and values of the parameter `name`; other values than numbers and texts become texts."""
        column = self.values[name]
        kinds = {np.asarray(value).dtype.kind if np.ndim(value) == 0 else "O" for value in column}
        numbers = kinds <= set("iuf") or kinds <= set("b")
        values = np.array(column) if numbers else np.array([str(value) for value in column], dtype=object)
        return ((name,) if name in self.dims else (DESIGN,)), values


def points_of(label: str, over: Any) -> Points:
    """Points of a grid {"a": values, "b": values}, all combinations, or of a list of designs {"a": value, "b": value}.

    All designs have the same parameters.
    """
    values: dict[str, Sequence[Any]]
    if isinstance(over, Mapping):
        values = {name: checks.sequence(label, f"grid[{name!r}]", column, "values") for name, column in over.items()}
        points = Points(tuple(values), tuple(len(column) for column in values.values()), values)
    else:
        designs = checks.sequence(label, "designs", over, "dictionaries, or a dictionary of lists for a grid")
        values = _columns(label, designs)
        points = Points((DESIGN,), (len(designs),), values)
    if points.count == 0 or not values:
        raise InputError(f"{label}: there is no point in it. Give values for at least one parameter.")
    for name in values:
        if not isinstance(name, str) or not name.isidentifier() or name in RESERVED:
            raise InputError(
                f"{label}: {name!r} cannot be a parameter; it must be a keyword, and not 'ok' or 'status'."
            )
        if name == DESIGN and points.dims == (DESIGN,) and not isinstance(over, Mapping):
            raise InputError(f"{label}: a parameter cannot be called 'design' in a list of designs. Rename it.")
    return points


def _columns(label: str, designs: Sequence[Any]) -> dict[str, Sequence[Any]]:
    for k, design in enumerate(designs):
        if not isinstance(design, Mapping):
            raise InputError(f"{label}: design {k} is {design!r}; it must be a dictionary such as {{'speed': 2.0}}.")
        if set(design) != set(designs[0]):
            names, others = ", ".join(map(str, design)), ", ".join(map(str, designs[0]))
            raise InputError(f"{label}: design {k} has {names}, the first one {others}. Give all of them the same.")
    return {name: [design[name] for design in designs] for name in (designs[0] if designs else ())}
