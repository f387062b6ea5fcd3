"""Parameters of a mechanism: numbers of parts or arguments of a function; directions in which they move a program."""

import inspect
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import fields, is_dataclass, replace
from numbers import Real
from typing import Any, NamedTuple

import numpy as np
from numpy.linalg import norm

from flexmb import checks
from flexmb.engine.sensitivity.parameter_run import Directions
from flexmb.engine.system.state_evaluation import StateEvaluation
from flexmb.errors import USER_ERRORS, FlexmbError, InputError, ModelError, RestitutionWarning
from flexmb.fields import unit_of
from flexmb.late import scipy
from flexmb.model.mechanism import Mechanism, require_field
from flexmb.program.compiler import compile_with_start
from flexmb.program.program import Program
from flexmb.statics.start.consistent import Start, consistent_start

LEAST_SIZE = 1e-3  # least size of a parameter, by which its differences are judged, over the width of its bounds
# Derivatives by differences on both sides and on one: places, weights of fourth order, of second order, twice as wide.
CENTRAL = (-2.0, 1.0 / 12.0, -0.25), (-1.0, -8.0 / 12.0, 0.0), (1.0, 8.0 / 12.0, 0.0), (2.0, -1.0 / 12.0, 0.25)
FORWARD = (0.0, -25.0 / 12.0, -0.75), (1.0, 4.0, 0.0), (2.0, -3.0, 1.0), (3.0, 4.0 / 3.0, 0.0), (4.0, -0.25, -0.25)
BACKWARD = tuple((-place, -weight, -coarse) for place, weight, coarse in FORWARD)
DISTANCE, TRIES = 1e-3, 5  # first distance of neighbours over the size of the parameter, most tried ones
SMALLER, LARGER = 1e-2, 1e2  # next distance over the last one; where round-off is felt
ORDERS_AGREE = 1e-4  # difference of both orders over the slope, to which a distance is good
LEAST_SLOPE = 1e-3  # least slope beside which the difference is judged, over the largest one of the neighbours
FELT = 1e-9  # least change of a number of a program that is judged, over it and over coordinates, if any is larger
FINER = 1e-3  # distance of neighbours for laws of sampled controllers, whose phases grow with time, over the others
DIFFERENCE_OF_NUMBERS = 1e-2  # largest difference of a parameter for derivatives by kernels over that of neighbours
STEPS_AGREE = 1e-6  # difference of derivatives by kernels with one step and two, over them, to which a step is good
LATE, SHAKEN = (0.618, 1.0), 1e-6  # where steps are judged: instants over the end, shift to a strained state over size
Model = Mechanism | Callable[..., Mechanism]  # a mechanism, or a function of numbers that returns one


class Parameter(NamedTuple):
    """A parameter: its name, its value, its SI unit ("" where it is unknown or none)."""

    name: str
    value: float
    unit: str

    def size(self, length: float, least: float = 0.0) -> float:
        """Size by which differences are judged; of a length at most that of the mechanism."""
        size = max(abs(self.value), least)
        return min(size or length, length) if self.unit == "m" and length else size or 1.0


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
        found, parameters = of_part if isinstance(model, Mechanism) else of_function, list[Parameter]()
        for name in listed:
            if not isinstance(name, str):
                raise InputError(f"{label}: parameters holds {name!r}; it must hold names such as 'B.clearance'.")
            present, unit, wanted = found(label, model, name)
            value = present if given.get(name) is None else given[name]
            number = isinstance(value, Real) and not isinstance(value, bool)
            if not number or "float" not in wanted.split(" | "):
                text = f"{label}: {name!r} is {wanted if number else repr(value)}"
                raise InputError(f"{text}; there are derivatives by real numbers alone. Compare runs with both values.")
            parameters.append(Parameter(name, checks.number(label, name, value, unit), unit))
        self.parameters = tuple(parameters)

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
    value, unit, kind = mechanism.find(part), "", ""
    for piece in path.split("."):
        if not is_dataclass(value):
            raise InputError(f"{label}: {name!r}: there are no fields before {piece!r}.")
        own = require_field(f"{label}: {name!r}", piece, value)
        declared = next(field for field in fields(value) if field.name == own)
        kind, unit, value = _kind(declared.type), unit_of(type(value), own), getattr(value, own)
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
    *columns, distances, samplers = zip(*rows, strict=True)
    numbers, q, v, z = map(np.stack, columns)
    sizes = [_step(here, *one, end) for one in zip(numbers, distances, strict=True)]
    return Directions(numbers, np.array(sizes), q, v, z, samplers)


def _direction(model: ParameterModel, k: int, here: Neighbour, end: float) -> tuple[Any, ...]:
    """Derivatives of numbers, start positions, velocities, histories by parameter k; distance; moved samplers."""
    name, value, error, best, refused = model.names[k], model.values[k], np.inf, tuple[Any, ...](), list[FlexmbError]()
    distances = [DISTANCE * model.parameters[k].size(here.program.length, model.least[k] if model.least else 0.0)]
    while error > ORDERS_AGREE and len(distances) <= TRIES:
        h, factor = distances[-1], SMALLER
        stencil, found = _neighbours(model, k, h, refused)
        other = [text for one in found if (text := here.program.beyond_numbers(one.program, end))]
        if other and not best:
            raise InputError(f"{model.label}: {name} {other[0]}")
        if found and not other:
            slopes, now, lost = _slopes(np.array(stencil).T, found, h)
            if now >= error and not lost:
                break
            error, best, factor = now, (slopes, h, found), LARGER if lost else SMALLER
        distances.append(h * factor)
    if not best:
        text = f"{model.label}: {name} = {value:.6g} has no neighbours on both sides or one ({refused[0]})"
        raise InputError(f"{text} Take a value farther from the limit.")
    slopes, h, found = best
    same = all(np.array_equal(found[0].program.sampled, one.program.sampled) for one in found)
    near = () if same else zip(*_neighbours(model, k, FINER * h, refused), strict=True)
    return *slopes, h, tuple((weight / (FINER * h), one.program.samplers) for (_, weight, _), one in near)


def _neighbours(model: ParameterModel, k: int, h: float, refused: list[FlexmbError]) -> tuple[Any, list[Neighbour]]:
    """Stencil and neighbours, by steps h of parameter k; none where these are refused, on both sides and on one."""
    along = h * (np.arange(len(model.values)) == k)
    for stencil in (CENTRAL, FORWARD, BACKWARD):
        try:
            return stencil, [neighbour(model.at(model.values + place * along)) for place, _, _ in stencil]
        except FlexmbError as error:
            refused.append(error)
    return (), []


def _slopes(stencil: np.ndarray, found: Sequence[Neighbour], h: float) -> tuple[list[np.ndarray], float, bool]:
    """Derivatives of numbers, start positions, velocities, histories; their error; whether no change is felt."""
    columns = [(one.program.tables.p, one.start.q, one.start.v, one.program.reference.z) for one in found]
    every = np.array([np.concatenate(column) for column in columns])
    change = np.subtract(every, every[0], out=np.zeros(every.shape), where=every != every[0])  # exact where equal
    fine, coarse = stencil[1:] @ change
    spread, far = np.abs(change).max(axis=0), np.abs(found[0].start.q).max(initial=0.0)
    felt = spread > FELT * np.maximum(np.abs(every[0]), far)
    judged = felt if felt.any() else spread > 0.0
    error = (np.abs(fine - coarse)[judged] / (np.abs(fine) + LEAST_SLOPE * spread)[judged]).max(initial=0.0)
    return np.split(fine / h, np.cumsum([len(x) for x in columns[0]])[:-1]), float(error), not felt.any()


def _step(here: Neighbour, rates: np.ndarray, distance: float, end: float) -> float:
    """Largest difference of a parameter with derivatives `rates` (n_p,) of the numbers, for derivatives by kernels."""
    program, start, random = here.program, here.start, np.random.default_rng(0)
    q, v, a = (SHAKEN * program.sizes * x for x in random.standard_normal((3, program.n_q)))
    lam, system = start.lam + random.standard_normal(program.n_c), StateEvaluation(program)

    def at(eps: float) -> Iterator[np.ndarray]:
        system.program = replace(program, tables=program.tables.replaced(p=program.tables.p + eps * rates))
        for t in LATE:
            one = system.at(start.q + q, start.v + v, a, lam, t=t * end)
            yield from (one.force, one.constraint_force, one.residual, one.velocity_residual)

    def apart(eps: float) -> float:
        once, twice = ([(x - y) / e for x, y in zip(at(e), at(-e), strict=True)] for e in (eps, 2.0 * eps))
        return max(float(norm(x - y) / (norm(x) or 1.0)) for x, y in zip(once, twice, strict=True))

    step = DIFFERENCE_OF_NUMBERS * distance
    with np.errstate(all="ignore"), suppress(FlexmbError):  # of a kernel in such a state
        found = apart(step)
        for factor in (0.1, 10.0):
            while found > STEPS_AGREE and (now := apart(factor * step)) < found:
                step, found = factor * step, now
    return step
