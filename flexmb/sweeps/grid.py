"""Where a function is called: all combinations of values, or a list of designs."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmb import checks
from flexmb.errors import InputError
from flexmb.sweeps.record import Index

DESIGN = "design"
RESERVED = ("ok", "status")


@dataclass(frozen=True)
class Points:
    """The points of a sweep.

    Parameters
    ----------
    dims : names of their dimensions: the parameters of a grid, or "design".
    shape : their lengths.
    values : values by parameter, along its dimension.
    """

    dims: tuple[str, ...]
    shape: tuple[int, ...]
    values: Mapping[str, Sequence[Any]]

    @property
    def count(self) -> int:
        """How many points there are."""
        return math.prod(self.shape)

    def index(self, number: int) -> Index:
        """The place of point `number`, in the order in which they are computed."""
        return tuple(int(k) for k in np.unravel_index(number, self.shape))

    def at(self, index: Index) -> dict[str, Any]:
        """The arguments of the function at a place."""
        if self.dims == (DESIGN,) and DESIGN not in self.values:
            return {name: column[index[0]] for name, column in self.values.items()}
        return {name: self.values[name][k] for name, k in zip(self.dims, index, strict=True)}

    def coordinate(self, name: str) -> tuple[tuple[str, ...], np.ndarray]:
        """Dimension and values of a parameter; what is no number and no text as the text that shows it."""
        column = self.values[name]
        kinds = {np.asarray(value).dtype.kind if np.ndim(value) == 0 else "O" for value in column}
        numbers = kinds <= set("iuf") or kinds <= set("b")
        shown = np.array(column) if numbers else np.array([str(value) for value in column], dtype=object)
        return ((name,) if name in self.dims else (DESIGN,)), shown


def points_of(label: str, over: Any) -> Points:
    """The points that a user's grid or designs mean.

    Parameters
    ----------
    label : who asks, for messages.
    over : {"a": values, "b": values} for all combinations, or a list of {"a": value, "b": value}.

    Raises
    ------
    InputError : neither of them, nothing in it, designs with different parameters, a name that is taken.
    """
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


def _columns(label: str, designs: Sequence[Any]) -> dict[str, list[Any]]:
    for k, design in enumerate(designs):
        if not isinstance(design, Mapping):
            raise InputError(f"{label}: design {k} is {design!r}; it must be a dictionary such as {{'speed': 2.0}}.")
        if set(design) != set(designs[0]):
            names, others = ", ".join(map(str, design)), ", ".join(map(str, designs[0]))
            raise InputError(f"{label}: design {k} has {names}, the first one {others}. Give all of them the same.")
    return {name: [design[name] for design in designs] for name in (designs[0] if designs else ())}
