"""Parameters of a mechanism: numbers of parts or arguments of a function; directions in which they move a program."""

from __future__ import annotations

import inspect
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass
from numbers import Real
from typing import Any, NamedTuple

import numpy as np

from flexmb import checks
from flexmb.engine.sensitivity.parameter_run import Directions
from flexmb.engine.sensitivity.parameters import Moved
from flexmb.errors import USER_ERRORS, FlexmbError, InputError, ModelError, RestitutionWarning
from flexmb.fields import unit_of
from flexmb.late import scipy
from flexmb.model.mechanism import Mechanism, require_field
from flexmb.program.compiler import compile_with_start
from flexmb.program.program import Program
from flexmb.statics.start.consistent import Start, consistent_start

LEAST_SIZE = 1e-3  # least size of a parameter, by which its differences are judged, over the width of its bounds
CENTRAL = (-2.0, 1.0 / 12.0), (-1.0, -8.0 / 12.0), (1.0, 8.0 / 12.0), (2.0, -1.0 / 12.0)
FORWARD = (0.0, -25.0 / 12.0), (1.0, 4.0), (2.0, -3.0), (3.0, 4.0 / 3.0), (4.0, -0.25)
# Places and weights of derivatives of fourth order, by differences on both sides and on one.
BACKWARD = tuple((-place, -weight) for place, weight in FORWARD)
DISTANCES = (1e-3, 1e-5)  # distance of two neighbours relative to the parameter; the second where the first is refused
DIFFERENCE_OF_NUMBERS = 1e-5  # largest difference of a parameter for derivatives by kernels, relative to the parameter
Model = Mechanism | Callable[..., Mechanism]  # a mechanism, or a function of numbers that returns one


@dataclass(frozen=True)
class Parameter:
    """A parameter: its name, its value, its SI unit ("" where it is unknown or none)."""

    name: str
    value: float
    unit: str


class ParameterModel:
    """A mechanism as a function of parameters: of numbers of its parts by name, or of the arguments of a function."""

    # Refused: another kind of model; unknown parameters; whole numbers, switches and texts, by which nothing has a
    # derivative; arguments without a value.
    least: Sequence[float] = ()  # least sizes by which differences are judged, where they are known

    def __init__(self, label: str, model: Model, names: Iterable[str] | Mapping[str, float]) -> None:
        self.label, self.model = label, model
        if not isinstance(model, Mechanism) and not callable(model):
            text = f"{label}: model is {model!r}"
            raise InputError(f"{text}; it must be a Mechanism, or a function of numbers that returns one.")
        given: dict[str, Any] = dict(names) if isinstance(names, Mapping) else {}
        listed = checks.sequence(label, "parameters", names, "names such as 'B.clearance'")
        if not listed or any(listed.count(name) > 1 for name in listed):
            raise InputError(f"{label}: parameters is {listed!r}; give at least one name, each of them once.")
        self.parameters = tuple(self._parameter(name, given.get(str(name))) for name in listed)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the parameters."""
        return tuple(one.name for one in self.parameters)

    @property
    def values(self) -> tuple[float, ...]:
        """Values of the parameters."""
        return tuple(one.value for one in self.parameters)

    def at(self, values: Iterable[float]) -> Mechanism:
        """The mechanism with other values (n,) of the parameters."""
        changes = dict(zip(self.names, map(float, values), strict=True))
        if isinstance(self.model, Mechanism):
            return self.model.with_(changes)
        with warnings.catch_warnings():
            if tuple(changes.values()) != self.values:
                warnings.simplefilter("ignore", RestitutionWarning)  # told of the present values alone
            made = called(self.label, self.model, changes)
        if not isinstance(made, Mechanism):
            raise InputError(f"{self.label}: the function returned {type(made).__name__}; it must return a Mechanism.")
        return made

    def _parameter(self, name: Any, value: Any) -> Parameter:
        if not isinstance(name, str):
            raise InputError(f"{self.label}: parameters holds {name!r}; it must hold names such as 'B.clearance'.")
        found = of_part if isinstance(self.model, Mechanism) else of_function
        present, unit, wanted = found(self.label, self.model, name)
        value = present if value is None else value
        number = isinstance(value, Real) and not isinstance(value, bool)
        if not number or "float" not in wanted.split(" | "):
            kind = wanted if number else repr(value)
            text = f"{self.label}: {name!r} is {kind}"
            raise InputError(f"{text}; there are derivatives by real numbers alone. Compare runs with both values.")
        return Parameter(name, checks.number(self.label, name, value, unit), unit)


def bounds_of(label: str, parameters: Any) -> dict[str, tuple[float, float]]:
    """Bounds (low, high) by name, or `InputError`."""
    found = {}
    if not parameters:
        raise InputError(f"{label}: parameters is {parameters!r}; give the bounds of at least one by its name.")
    for name, pair in checks.mapping(label, "parameters", parameters).items():
        both = checks.sequence(label, f"parameters[{name!r}]", pair, "two bounds")
        if len(both) != 2:
            raise InputError(f"{label}: parameters[{name!r}] is {pair!r}; give two bounds (low, high).")
        low, high = (checks.number(label, str(name), x) for x in both)
        if not low < high:
            text = f"{label}: the bounds of {name} are {low:g} and {high:g};"
            raise InputError(f"{text} the first must be the lower one.")
        found[str(name)] = (low, high)
    return found


def refuse_taken(label: str, names: Iterable[str], taken: Iterable[str]) -> None:
    """Refusal of names that columns of the results have."""
    for name in sorted(set(names) & set(taken)):
        raise InputError(f"{label}: {name!r} is the name of a column of the results; take another name.")


def arguments_of(label: str, function: Callable[..., Any]) -> Mapping[str, inspect.Parameter]:
    """Arguments of a function by name, or `InputError`."""
    try:
        return inspect.signature(function).parameters
    except (TypeError, ValueError) as error:
        raise InputError(f"{label}: {function!r} has no known arguments ({error}); give a Python function.") from error


def called(label: str, function: Callable[..., Any], numbers: Mapping[str, float]) -> Any:
    """Result of a function of the user; an error of the call becomes `ModelError`."""
    try:
        return function(**numbers)
    except USER_ERRORS as error:
        if isinstance(error, FlexmbError):
            raise
        raise ModelError(f"{label}: {function} failed at {dict(numbers)}: {type(error).__name__}: {error}.") from error


def box_points(count: int, dimensions: int) -> np.ndarray:
    """Points (count, dimensions) of Sobol's sequence within 0 and 1, the same each time."""
    return np.asarray(scipy.stats.qmc.Sobol(dimensions, rng=np.random.default_rng(1)).random(count))


def of_part(label: str, mechanism: Any, name: str) -> tuple[Any, str, str]:
    """Value, unit and declared kind of a number of a part."""
    part, _, path = name.partition(".")
    if not path:
        raise InputError(f"{label}: {name!r} is no number of a part; give a name such as 'B.clearance'.")
    owner: Any = mechanism.find(part)
    value, unit, kind = owner, "", ""
    for piece in path.split("."):
        if not is_dataclass(value):
            raise InputError(f"{label}: {name!r}: there are no fields before {piece!r}.")
        own = require_field(f"{label}: {name!r}", piece, value)
        declared = next(field for field in fields(value) if field.name == own)
        kind, unit = _kind(declared.type), unit_of(type(value), own)
        value = getattr(value, own)
    return value, unit, kind


def of_function(label: str, function: Any, name: str) -> tuple[Any, str, str]:
    """Default, unit and declared kind of an argument of a function."""
    known = arguments_of(label, function)
    checks.one_of(label, "parameter", name, list(known))
    default, kind = known[name].default, _kind(known[name].annotation)
    value = None if default is inspect.Parameter.empty else default
    return value, unit_of(function, name), kind if set(kind.split(" | ")) <= {"int", "bool", "str", "None"} else "float"


def _kind(declared: Any) -> str:
    """Declared kind of a number: "float", "int", ...; the first argument of Annotated."""
    text = declared if isinstance(declared, str) else getattr(declared, "__name__", str(declared))
    if "Annotated" in text:
        text = str(getattr(declared, "__origin__", text)) if not isinstance(declared, str) else text
        text = text.partition("[")[2].partition(",")[0] or text
    return {"<class 'float'>": "float"}.get(text, text)


# Directions of parameters: derivatives of the packed numbers of a program, and of its start values
class Neighbour(NamedTuple):
    """A mechanism with a changed parameter: its program and its start."""

    program: Program
    start: Start


def neighbour(mechanism: Mechanism) -> Neighbour:
    """Program and start of a mechanism."""
    program, closed = compile_with_start(mechanism)
    return Neighbour(program, consistent_start(mechanism, program, closed=closed))


def directions(model: ParameterModel, here: Neighbour, end: float) -> Directions:
    """Directions of the parameters of a model; `here`: its present program, `end`: end of the run [s]."""
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

    def moved(column: Sequence[np.ndarray]) -> np.ndarray:
        first = np.array(column[0])
        changes = (np.subtract(x, first, out=np.zeros(first.shape), where=x != first) for x in column)
        return np.asarray(sum(w * change for w, change in zip(weights, changes, strict=True)))

    return tuple(map(moved, columns))


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
