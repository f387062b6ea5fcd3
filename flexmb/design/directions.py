"""Directions of parameters: derivatives of the packed numbers of a program, and of its start values."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from flexmb.design.parameters import ParameterModel
from flexmb.engine.sensitivity.controllers import Moved
from flexmb.engine.sensitivity.parameter_run import Directions
from flexmb.errors import FlexmbError, InputError
from flexmb.model.mechanism import Mechanism
from flexmb.program.compiler import compile_with_start
from flexmb.program.program import Program
from flexmb.statics.start.consistent import Start, consistent_start

CENTRAL = (-2.0, 1.0 / 12.0), (-1.0, -8.0 / 12.0), (1.0, 8.0 / 12.0), (2.0, -1.0 / 12.0)
FORWARD = (0.0, -25.0 / 12.0), (1.0, 4.0), (2.0, -3.0), (3.0, 4.0 / 3.0), (4.0, -0.25)
BACKWARD = tuple((-place, -weight) for place, weight in FORWARD)
"""Places and weights of derivatives of fourth order, by differences on both sides and on one."""

DISTANCES = (1e-3, 1e-5)  # distance of two neighbours relative to the parameter; the second where the first is refused
DIFFERENCE_OF_NUMBERS = 1e-5  # largest difference of a parameter for derivatives by kernels, relative to the parameter


class Neighbour(NamedTuple):
    """A mechanism with a changed parameter: its program and its start."""

    program: Program
    start: Start


def neighbour(mechanism: Mechanism) -> Neighbour:
    """Program and start of a mechanism."""
    program, closed = compile_with_start(mechanism)
    return Neighbour(program, consistent_start(mechanism, program, closed=closed))


def directions(model: ParameterModel, here: Neighbour, end: float) -> Directions:
    """Directions of the parameters of a model; `here`: its present program, `end`: end of the run [s].

    Raises
    ------
    InputError : a parameter that changes the structure of the program, or moves kinks of drives and loads in time.
    """
    rows = [_direction(model, k, here, end) for k in range(len(model.parameters))]
    *columns, samplers = zip(*rows, strict=True)
    numbers, q, v, z = map(np.stack, columns)
    sizes = np.array([DIFFERENCE_OF_NUMBERS * size_of(model, k) for k in range(len(rows))])
    return Directions(numbers, sizes, q, v, z, samplers)


def size_of(model: ParameterModel, k: int) -> float:
    """Size of parameter k, by which its differences are judged; 1 for a parameter that is 0 without a least size."""
    return max(abs(model.values[k]), model.least[k] if model.least else 0.0) or 1.0


def _direction(model: ParameterModel, k: int, here: Neighbour, end: float) -> tuple[Any, ...]:
    """Derivatives of numbers, start positions, velocities and histories by parameter k; its moved samplers."""
    refused: FlexmbError | None = None
    for distance in DISTANCES:
        for stencil in (CENTRAL, FORWARD, BACKWARD):
            h = distance * size_of(model, k)
            try:
                found = [_moved(model, k, place * h) for place, _ in stencil]
            except FlexmbError as error:
                refused = refused or error
                continue
            for one in found:
                _refuse_other_structure(model, k, here.program, one.program, end)
            weights = np.array([weight / h for _, weight in stencil])
            return *_sum(weights, found), _moved_samplers(weights, found)
    name, value = model.names[k], model.values[k]
    text = f"{model.label}: {name} = {value:.6g} has no neighbours on both sides or one ({refused})"
    raise InputError(f"{text} Take a value farther from the limit.")


def _sum(weights: np.ndarray, found: Sequence[Neighbour]) -> tuple[np.ndarray, ...]:
    """Weighted sums of numbers, start positions, velocities and histories; exact where these are equal."""
    starts = ([one.start.q for one in found], [one.start.v for one in found])
    columns = ([one.program.tables.p for one in found], *starts, [one.program.reference.z for one in found])
    middle = [np.array(column[0]) for column in columns]
    return tuple(
        sum(
            w * np.subtract(x, first, out=np.zeros(first.shape), where=x != first)
            for w, x in zip(weights, column, strict=True)
        )
        for column, first in zip(columns, middle, strict=True)
    )


def _moved_samplers(weights: np.ndarray, found: Sequence[Neighbour]) -> Moved:
    """Weights and samplers of the neighbours; none if the samplers are the same."""
    every = [one.program.samplers for one in found]
    numbers = [np.concatenate([np.zeros(0), *(x for one in samplers for x in one.numbers)]) for samplers in every]
    return () if all(map(np.array_equal, numbers, numbers[1:])) else tuple(zip(weights.tolist(), every, strict=True))


def _moved(model: ParameterModel, k: int, shift: float) -> Neighbour:
    values = list(model.values)
    values[k] += shift
    return neighbour(model.at(values))


def _refuse_other_structure(model: ParameterModel, k: int, here: Program, other: Program, end: float) -> None:
    name = model.names[k]
    same = here.names.coordinates == other.names.coordinates and here.kernels == other.kernels
    if not same or len(here.tables.p) != len(other.tables.p) or here.symbolic is not other.symbolic:
        text = f"{model.label}: {name} changes the structure of the equations"
        raise InputError(f"{text}, so there is no derivative by it. Compare runs with both values.")
    instants = [[one.sample for one in program.samplers] for program in (here, other)]
    if not np.array_equal(here.breaks(end), other.breaks(end)) or instants[0] != instants[1]:
        text = f"{model.label}: {name} moves instants of kinks and jumps of drives and loads, or of a controller"
        raise InputError(f"{text}; no derivative is known there. Vary it by a sweep.")
