"""Better designs: least values of measures of signals by the numbers of a mechanism, within limits."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from flexmb import arguments, checks, display
from flexmb.design.derivatives import Span, columns, derivatives
from flexmb.design.measures import EXTREMES, Limit, Measure, measured
from flexmb.design.parameters import LEAST_SIZE, Model, ParameterModel, arguments_of, bounds_of, called, refuse_taken
from flexmb.dynamics.jobs.files import write_text
from flexmb.dynamics.sweeps.parameter_sweep import settings_of
from flexmb.engine.step.method import Method
from flexmb.errors import FlexmbError, InputError, SolveError
from flexmb.fields import field, record_with
from flexmb.late import scipy, xr
from flexmb.run.simulate import Step

OBJECTIVE = 0  # place of the objective in values and slopes of a design; limits follow
FAILED = 10.0  # objective of a design whose run fails, over the largest one so far, so that the search turns back
LARGE = 1e300  # objective of a design whose run fails, for differential evolution, which takes no infinite one
# Violation up to which a limit holds, over its size; difference of a parameter for functions, over its bounds.
HELD, FUNCTION_DISTANCE = 1e-6, 1e-6
CHECK_DISTANCE = 1e-4  # difference of a parameter by which derivatives are checked, relative to its bounds
# A limit of a measure, or a function of the parameters that must not be negative.
Condition = Limit | Callable[..., float]


class Design(NamedTuple):
    """An evaluated design: parameters from 0 to 1, objective and limits with derivatives, status ("" if good)."""

    x: list[float]
    values: list[float]  # objective, limits
    slopes: list[list[float]]
    status: str


@record_with(repr=False)
class Optimum(display.Inside):
    """Result of a search for a better design."""

    parameters: dict[str, float] = field("value of each parameter")
    objective: float = field("objective of the best design")
    first: float = field("objective at the start")
    limits: dict[str, float] = field("values of the limits by their texts; negative ones are violated")
    history: xr.Dataset = field("all designs in order: parameters, objective, limits, status")
    check: tuple[float, float] = field(
        "error of derivatives by central differences at start and end, over the largest derivative of all designs; "
        "NaN where no neighbour succeeds"
    )
    ok: bool = field("whether the search converged")
    message: str = field("end of the search, in a sentence")

    def __repr__(self) -> str:
        rows = [(name, f"{value:.6g}") for name, value in self.parameters.items()]
        rows += [(text, f"{value:.6g}") for text, value in self.limits.items()]
        head = f"Optimum: {self.message} Objective {self.objective:.6g}, at the start {self.first:.6g}."
        known = ["not known, since no neighbour succeeded," if np.isnan(x) else f"{x:.1e}" for x in self.check]
        checked = "Derivatives beside differences: {} at the start, {} at the end.".format(*known)
        return f"{head}\n{columns(('parameter or limit', 'value'), rows)}\n{checked}"


@arguments.checked
def optimise(
    model: Model, parameters: Mapping[str, tuple[float, float]], *, objective: Measure | Mapping[Measure, float],
    subject_to: Sequence[Condition] = (), t_end: float | None = None, periods: float | None = None,
    start: Mapping[str, float] | None = None, everywhere: bool = False, search: str = "SLSQP", most_designs: int = 200,
    store: str | Path | None = None, resume: bool = False, step: Step | None = None, method: Method | None = None,
) -> Optimum:  # fmt: skip
    """Least value of a measure by the numbers of a mechanism, with the derivatives of the run.

    A design whose run fails or that cannot be assembled stays in the history with its status; the search turns back.

    Parameters
    ----------
    model : a mechanism, or a function of numbers that returns one.
    parameters : bounds (low, high) of each parameter by name.
    objective : a measure such as `peak("O.force", norm=16)`, or weights of several by measure.
    subject_to : limits of measures, `peak("motor.torque", norm=16) <= 3.0`, and functions of parameters that must not
        be negative; a function is called with those parameters that it names.
    t_end : end [s]; or
    periods : number of common periods of the drives.
    start : first values; missing ones are those of the model, if they lie within the bounds, else the middles.
    everywhere : whether differential evolution looks for the start within all bounds.
    search : "SLSQP" or "trust-constr" of `scipy.optimize.minimize`.
    most_designs : number of designs at most that are evaluated.
    store : file that keeps every design (JSON); with `resume`, its designs are not computed again.
    resume : whether an existing store is continued.
    step, method : as in `simulate`.

    Raises
    ------
    InputError : unknown parameters or signals, bounds that are not low < high, a peak without norm, whose derivative
        jumps, a store of another search.
    SolveError : a first design that fails.
    """
    label = "optimise"
    bounds = bounds_of(label, parameters)
    checks.one_of(label, "search", search, ["SLSQP", "trust-constr"])
    given = {objective: 1.0} if isinstance(objective, Measure) else checks.mapping(label, "objective", objective)
    weights: dict[Any, float] = {one: checks.number(label, "a weight", x) for one, x in given.items()} or {None: 0.0}
    conditions = checks.sequence(label, "subject_to", subject_to, "limits of measures or functions")
    evaluation = _Evaluation(label, model, bounds, weights, conditions, Span(t_end, periods, 1, step, method))
    evaluation.most = checks.count(label, "most_designs", most_designs)
    evaluation.keep(store, resume=resume)
    chosen = checks.mapping(label, "start", start)
    for name in chosen:
        checks.one_of(label, "parameter of the start", name, list(bounds))
    own = middle = {name: 0.5 * (low + high) for name, (low, high) in bounds.items()}
    with suppress(InputError):  # an argument without a default; other faults come back with the values
        own = dict(zip(bounds, ParameterModel(label, model, list(bounds)).values, strict=True))
    held = {name: own[name] if bounds[name][0] <= own[name] <= bounds[name][1] else middle[name] for name in bounds}
    held |= {name: checks.between(label, name, value, *bounds[name]) for name, value in chosen.items()}
    x = _looked_for(evaluation) if everywhere else evaluation.scaled(held)
    first = evaluation.at(x)
    if first.status:
        raise SolveError(f"{label}: the first design failed: {first.status.rstrip('.')}. Give another start.")
    found = _minimum(evaluation, x, search)
    best = evaluation.best() or first
    checked = evaluation.check(first), evaluation.check(best)
    limits = dict(zip(evaluation.texts, best.values[1:], strict=True))
    numbers = evaluation.values(best.x), best.values[0], first.values[0], limits
    return Optimum(*numbers, evaluation.history(), checked, *found)


class _EnoughError(Exception):
    """Signal that all permitted designs are evaluated."""


class _Evaluation:
    """Objective and limits of designs, each computed once."""

    most = 0

    def __init__(
        self, label: str, model: Model, bounds: Mapping[str, tuple[float, float]], weights: Mapping[Measure, float],
        subject_to: Sequence[Condition], span: Span,
    ) -> None:  # fmt: skip
        self.label, self.model, self.bounds, self.span = label, model, dict(bounds), span
        self.low, high = np.array(list(bounds.values())).T
        self.width = high - self.low
        self.weights, self.limits = dict(weights), [one for one in subject_to if isinstance(one, Limit)]
        self.functions = [one for one in subject_to if not isinstance(one, Limit)]
        for one in [*self.weights, *(limit.measure for limit in self.limits)]:
            if not isinstance(one, Measure):
                raise InputError(f"{label}: {one!r} is no measure; give one such as rms('slider.ax').")
            if one.kind in EXTREMES and one.norm is None:
                text = f"{label}: the derivative of {one.name} jumps where another instant takes over"
                raise InputError(f"{text}; give peak({one.signal!r}, norm=16), which is smooth.")
        for condition in self.functions:
            if not callable(condition):
                raise InputError(f"{label}: subject_to holds {condition!r}; give limits of measures or functions.")
        texts = [one.text for one in self.limits] + [getattr(one, "__name__", "limit") for one in self.functions]
        self.texts = [one if texts.count(one) == 1 else f"{one} {k + 1}" for k, one in enumerate(texts)]
        refuse_taken(label, bounds, ("objective", "status", *self.texts))
        refuse_taken(label, self.texts, ("objective", "status"))
        self.sizes = [1.0] + [abs(one.value) or 1.0 for one in self.limits] + [1.0] * len(self.functions)
        self.designs: dict[tuple[float, ...], Design] = {}
        self.known: dict[tuple[float, ...], Design] = {}
        self.file: Path | None = None

    def scaled(self, values: Mapping[str, float]) -> np.ndarray:
        """Parameters from 0 to 1 within their bounds."""
        return np.asarray((np.array([values[name] for name in self.bounds]) - self.low) / self.width)

    def values(self, x: Sequence[float]) -> dict[str, float]:
        """Parameters by name."""
        return dict(zip(self.bounds, (self.low + np.asarray(x) * self.width).tolist(), strict=True))

    def at(self, x: np.ndarray) -> Design:
        """The design with parameters x from 0 to 1."""
        key = tuple(float(one) for one in np.clip(x, 0.0, 1.0))
        if key not in self.designs:
            if len(self.designs) >= self.most:
                raise _EnoughError
            self.designs[key] = self.known.get(key) or self._computed(key)
            if self.file is not None and key not in self.known:
                every = [one._asdict() for one in (self.known | self.designs).values()]
                write_text(self.file, json.dumps({"search": self.mark, "designs": every}), self.label)
        return self.designs[key]

    def _computed(self, key: tuple[float, ...]) -> Design:
        values, n = self.values(key), len(self.texts) + 1
        measures = [*self.weights, *(one.measure for one in self.limits)]
        signals = list(dict.fromkeys(one.signal for one in measures))
        held = ParameterModel(self.label, self.model, values)
        held.least = (LEAST_SIZE * self.width).tolist()
        try:
            held.at(held.values)
            found = derivatives(self.label, held, self.span, signals, every=True)
        except (FlexmbError, ValueError, ArithmeticError) as error:
            if not self.designs and isinstance(error, InputError):
                raise  # unknown signals and the like
            return Design(list(key), [0.0] * n, [[0.0] * len(key)] * n, f"{type(error).__name__}: {error}")
        amounts = [measured(one, found.rows[signals.index(one.signal)]) for one in measures]
        many, weighted = len(self.weights), list(zip(self.weights.values(), amounts, strict=False))
        slope = sum(w * change for w, (_, change) in weighted) * self.width
        rows = [(float(sum(w * amount for w, (amount, _) in weighted)), slope)]
        for one, (amount, change) in zip(self.limits, amounts[many:], strict=True):
            rows.append((one.room(amount), one.sign * change * self.width))
        rows += [self._function(one, values) for one in self.functions]
        return Design(list(key), [x for x, _ in rows], [np.asarray(dx).tolist() for _, dx in rows], "")

    def _function(self, function: Callable[..., float], values: Mapping[str, float]) -> tuple[float, np.ndarray]:
        """Value of a function of parameters, and its derivatives by differences."""
        wanted = [name for name in arguments_of(self.label, function) if name in values]
        here, slope = {name: values[name] for name in wanted}, np.zeros(len(values))
        value = checks.number(self.label, getattr(function, "__name__", "limit"), called(self.label, function, here))
        for k, name in enumerate(values):
            if name in here:
                h = FUNCTION_DISTANCE * self.width[k]
                more, less = (called(self.label, function, here | {name: here[name] + x}) for x in (h, -h))
                slope[k] = (more - less) / (2.0 * FUNCTION_DISTANCE)
        return value, slope

    def best(self) -> Design | None:
        """Best design whose limits hold, or the one that violates them least."""
        good = [one for one in self.designs.values() if not one.status]
        worst = {id(one): min([0.0, *(np.array(one.values) / self.sizes)[1:]]) for one in good}
        held = [one for one in good if worst[id(one)] > -HELD]
        if held:
            return min(held, key=lambda one: one.values[0])
        return max(good, key=lambda one: worst[id(one)], default=None)

    def check(self, design: Design) -> float:
        """Largest error of the derivatives of the objective by central differences, over the largest of all designs."""
        most, self.most = self.most, 10**9
        kept, worst = dict(self.designs), np.nan
        largest = max(abs(slope) for one in self.designs.values() for slope in one.slopes[OBJECTIVE])
        for k, slope in enumerate(design.slopes[OBJECTIVE]):
            here = np.array(design.x)
            here[k] = min(max(here[k], CHECK_DISTANCE), 1.0 - CHECK_DISTANCE)
            sides = [self.at(here + side * CHECK_DISTANCE * np.eye(len(here))[k]) for side in (1.0, -1.0)]
            if any(one.status for one in sides):
                continue
            difference = (sides[0].values[0] - sides[1].values[0]) / (2.0 * CHECK_DISTANCE)
            worst = float(np.fmax(worst, abs(difference - slope) / (largest or 1.0)))
        self.designs, self.most = kept, most
        return worst

    def history(self) -> xr.Dataset:
        """All designs in their order."""
        designs = list(self.designs.values())
        table = np.array([list(self.values(one.x).values()) for one in designs])
        values = np.array([one.values if not one.status else [np.nan] * len(one.values) for one in designs])
        found = {name: ("design", table[:, k]) for k, name in enumerate(self.bounds)}
        found["objective"] = ("design", values[:, 0])
        found |= {text: ("design", values[:, k + 1]) for k, text in enumerate(self.texts)}
        return xr.Dataset({**found, "status": ("design", [one.status or "done" for one in designs])})

    def keep(self, store: str | Path | None, *, resume: bool) -> None:
        """Set the file of the designs, with its designs as known ones."""
        if store is None:
            return
        self.file = checks.path(self.label, store)
        made_of = {"bounds": self.bounds, "objective": self.weights, "limits": self.limits, "functions": self.functions}
        self.mark = settings_of(made_of | {"span": self.span}, self.model)
        if not self.file.exists():
            return
        if not resume:
            raise InputError(f"{self.label}: {self.file} exists; continue it with resume=True, or name another file.")
        try:
            held = json.loads(self.file.read_text(encoding="utf-8"))
            designs = [Design(**one) for one in held["designs"]]
            mark, self.known = held["search"], {tuple(map(float, one.x)): one for one in designs}
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise InputError(f"{self.label}: {self.file} is no file of designs: {error}") from error
        if mark != self.mark:
            raise InputError(f"{self.label}: {self.file} belongs to another search; name another file.")


def _looked_for(evaluation: _Evaluation) -> np.ndarray:
    """Start by differential evolution within all bounds, with a third of the designs."""
    most, evaluation.most = evaluation.most, max(evaluation.most // 3, 1)

    def cost(x: np.ndarray) -> float:
        one = evaluation.at(x)
        return LARGE if one.status else one.values[0] + 1e3 * sum(-min(0.0, room) for room in one.values[1:])

    with suppress(_EnoughError):
        scipy.optimize.differential_evolution(cost, [(0.0, 1.0)] * len(evaluation.low), rng=1, polish=False, tol=1e-3)
    evaluation.most = most
    found = evaluation.best()
    return np.full(len(evaluation.low), 0.5) if found is None else np.array(found.x)


def _minimum(evaluation: _Evaluation, x: np.ndarray, search: str) -> tuple[bool, str]:
    """Whether the search of scipy converged, and a sentence on its end."""
    scale = abs(evaluation.at(x).values[0]) or 1.0

    def objective(z: np.ndarray) -> float:
        one = evaluation.at(z)
        if one.status:
            return FAILED * max(abs(other.values[0]) for other in evaluation.designs.values()) / scale
        return one.values[0] / scale

    def slope(z: np.ndarray) -> np.ndarray:
        return np.array(evaluation.at(z).slopes[OBJECTIVE]) / scale

    def part(k: int, *, slope: bool) -> Callable[[np.ndarray], Any]:
        def asked(z: np.ndarray) -> Any:
            one = evaluation.at(z)
            return (np.array(one.slopes[k]) if slope else one.values[k]) / evaluation.sizes[k]

        return asked

    pairs = [(part(k + 1, slope=False), part(k + 1, slope=True)) for k in range(len(evaluation.texts))]
    limits = [{"type": "ineq", "fun": value, "jac": slope} for value, slope in pairs]
    more = {"ftol": 1e-10, "maxiter": 200} if search == "SLSQP" else {"gtol": 1e-8, "xtol": 1e-10}
    try:
        how = {"bounds": [(0.0, 1.0)] * len(x), "constraints": limits, "method": search, "options": more}
        found = scipy.optimize.minimize(objective, x, jac=slope, **how)
    except _EnoughError:
        return False, f"Not converged after {evaluation.most} designs; give most_designs= more."
    text = str(found.message).rstrip(".")
    return bool(found.success), f"{'Converged' if found.success else 'Not converged'} ({text})."
