"""Numbers and choices of a mechanism that may vary: their units, ranges and meanings; values checked against these."""

import inspect
import math
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, fields, is_dataclass, replace
from functools import reduce
from numbers import Real
from typing import Annotated, Any, Literal, get_args, get_origin

from flexmb import checks
from flexmb.arguments import parameters
from flexmb.design.parameters import Model, arguments_of, called, of_function, of_part
from flexmb.errors import FlexmbError, InputError, RestitutionWarning
from flexmb.fields import fields_of
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import Body, Part
from flexmb.units import known_units, quantity

LABEL = "explore"
# Factor by which a guessed range reaches below and above the value of its parameter.
WIDER = 5.0
LOGARITHMIC = 20.0  # ratio of the ends of a positive range from which its slider has a logarithmic scale
NEARER = (0.5, 0.25, 0.125, 0.06, 0.03, 0.01)  # shares of a guessed range that are tried where a part refuses it
# Largest number of numbers and choices of a page, and of guessed ones with a slider at the start; others are added.
MOST_KNOBS, MOST_SHOWN = 200, 8
DEPTH = 2  # records within one another, in a part, whose numbers are found: "B.normal.restitution"
MOST_TYPED = 60  # signs of a typed number at most
DIGITS = 3  # significant digits of a start value in the middle of a range
Value = float | int | bool | str | None


@dataclass(frozen=True)
class Knob:
    """A number or a choice that may vary."""

    name: str  # name of the argument, or path of the number of a part
    kind: str  # "number", "count" or "choice"
    value: Any  # value at the start; of a choice its label
    low: float = 0.0  # low, high: range of a number
    high: float = 0.0
    unit: str = ""  # SI unit; "" for none
    meaning: str = ""  # what it is
    optional: bool = False  # whether a number may be None
    choices: tuple[tuple[str, Any], ...] = ()  # labels and values of a choice

    def checked(self, value: Any) -> Value:
        """A value within the range, or the label of a choice, or `InputError`."""
        if self.kind == "choice":
            for label, one in self.choices:
                if (isinstance(value, str) and value == label) or value is one:
                    return label
            raise InputError(f"{LABEL}: {self.name} is {_short(value)}; choose {' or '.join(self.labels)}.")
        if value is None and self.optional:
            return None
        given = self.number(value)
        return checks.count(LABEL, self.name, given, 0) if self.kind == "count" else given

    def number(self, value: Any) -> float:
        """A number within the range, also of a text such as "0.5 mm", or `InputError`."""
        if isinstance(value, str):
            unit = known_units(self.unit)
            if len(value) > MOST_TYPED or (self.unit and not unit):
                raise InputError(f"{LABEL}: {self.name} is {_short(value)}; give a number in {self.unit or 1}.")
            value = quantity(value, unit, f"{LABEL}: {self.name}")
        return checks.between(LABEL, self.name, value, self.low, self.high, self.unit)

    def argument(self, value: Value) -> Any:
        """Argument of the function, or value of the field, for a checked value."""
        return dict(self.choices)[str(value)] if self.kind == "choice" else value

    @property
    def labels(self) -> tuple[str, ...]:
        """Labels of a choice."""
        return tuple(label for label, _ in self.choices)

    def described(self) -> dict[str, Any]:
        """Plain values for the page."""
        scale = "log" if self.kind == "number" and self.low > 0.0 and self.high > LOGARITHMIC * self.low else "linear"
        texts = {"name": self.name, "kind": self.kind, "unit": self.unit, "meaning": self.meaning, "scale": scale}
        return {**texts, "low": self.low, "high": self.high, "optional": self.optional, "choices": list(self.labels)}


def _short(value: Any) -> str:
    """A value of a stranger as a short text."""
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:60]}..."


class Knobs:
    """All numbers and choices of a model that may vary; `vary`, `fixed` as of `explore`, with ranges beside `vary`."""

    def __init__(
        self, model: Model, vary: Any, fixed: Mapping[str, Any], ranges: Mapping[str, Any] | None = None
    ) -> None:
        if not isinstance(model, Mechanism) and not callable(model):
            text = f"{LABEL}: model is {_short(model)}"
            raise InputError(f"{text}; it must be a Mechanism, or a function that returns one.")
        self.model, self.fixed = model, dict(fixed)
        if callable(model):
            taken = inspect.signature(model).parameters
            if not any(one.kind is inspect.Parameter.VAR_KEYWORD for one in taken.values()):
                for name in fixed:
                    checks.one_of(LABEL, "name in fixed", name, list(taken))
        self.known = {name: self._knob(name, given) for name, given in self._wanted(vary, ranges or {}).items()}
        self.hidden = () if vary is not None else tuple(self.known)[MOST_SHOWN:]
        self.fixed = {name: value for name, value in self.fixed.items() if name not in self.known}

    @property
    def start(self) -> dict[str, Value]:
        """Values at the start."""
        return {name: knob.value for name, knob in self.known.items()}

    def checked(self, values: Mapping[str, Any]) -> dict[str, Value]:
        """Values by name, checked; names that are no knobs are refused."""
        for name in values:
            checks.one_of(LABEL, "name", name, self.known)
        return {name: self.known[name].checked(value) for name, value in values.items()}

    def given(self, values: Mapping[str, Value]) -> dict[str, Any]:
        """Arguments for checked values; of a mechanism the fields that change."""
        every = not isinstance(self.model, Mechanism)
        return {n: self.known[n].argument(x) for n, x in values.items() if every or x != self.known[n].value}

    def mechanism(self, values: Mapping[str, Value]) -> Mechanism:
        """Mechanism of checked values."""
        if isinstance(self.model, Mechanism):
            return self.model.with_(self.given(values))
        made = called(LABEL, self.model, {**self.fixed, **self.given(values)})
        if not isinstance(made, Mechanism):
            raise InputError(f"{LABEL}: the function returned {type(made).__name__}; it must return a Mechanism.")
        return made

    def family(self, values: Mapping[str, Value], name: str) -> tuple[Model, dict[str, Any]]:
        """Model over the values of one number, and the fixed arguments of a function."""
        if isinstance(self.model, Mechanism):
            return self.mechanism({**values, name: self.known[name].value}), {}
        return self.model, {**self.fixed, **self.given({key: one for key, one in values.items() if key != name})}

    def code(self, values: Mapping[str, Value]) -> str:
        """Python text that makes the mechanism of checked values."""
        if isinstance(self.model, Mechanism):
            return f"mech.with_({self.given(values)!r})"
        pairs = ", ".join(f"{name}={value!r}" for name, value in {**self.fixed, **self.given(values)}.items())
        return f"{getattr(self.model, '__name__', 'mechanism')}({pairs})"

    def _wanted(self, vary: Any, ranges: Mapping[str, Any]) -> dict[str, Any]:
        if isinstance(vary, Mapping):
            wanted: dict[str, Any] = {str(name): given for name, given in vary.items()}
        elif vary is not None:
            wanted = {str(name): None for name in checks.sequence(LABEL, "vary", vary, "names such as 'speed'")}
        else:  # guessed ranges of the arguments of the function, or of the numbers of parts, bodies last
            names = list(arguments_of(LABEL, self.model)) if callable(self.model) else []
            if isinstance(self.model, Mechanism):
                parts = sorted(self.model.parts, key=lambda part: isinstance(part, Body))
                names = [f"{part.name}.{path}" for part in parts for path in _numbers_of(part, DEPTH)]
            guesses = {name: self._guessed(name) for name in names[:MOST_KNOBS]}
            wanted = {name: guess for name, guess in guesses.items() if guess is not None}
        wanted |= ranges
        if not wanted:
            raise InputError(f"{LABEL}: nothing can vary. Give names with ranges: vary={{'speed': (50.0, 500.0)}}.")
        if len(wanted) > MOST_KNOBS:
            raise InputError(f"{LABEL}: vary holds {len(wanted)} names; a page holds {MOST_KNOBS} at most.")
        return wanted

    def _found(self, name: str) -> tuple[Any, str, str, Any]:
        """Present value, unit, declared kind and annotation."""
        if isinstance(self.model, Mechanism):
            return *of_part(LABEL, self.model, name), None
        value, unit, kind = of_function(LABEL, self.model, name)
        annotation: Any = arguments_of(LABEL, self.model)[name].annotation
        if isinstance(annotation, str):  # of a module with lazy annotations
            try:
                annotation = eval(annotation, getattr(inspect.unwrap(self.model), "__globals__", {}))
            except (NameError, SyntaxError, TypeError, AttributeError):  # imported for type checking only
                annotation = None
        without_unit = get_args(annotation)[0] if get_origin(annotation) is Annotated else annotation
        return self.fixed.get(name, value), unit, kind, without_unit

    def _meaning(self, name: str) -> str:
        if not isinstance(self.model, Mechanism):
            return parameters(self.model).get(name, "")
        *path, last = name.split(".")
        kind: Any = type(reduce(getattr, path[1:], self.model.find(path[0])))
        return next((field.meaning for field in fields_of(kind) if field.name == last), "")

    def _guessed(self, name: str) -> Any:
        """Range or choices of a name, guessed from its value; None where there is no guess."""
        value, _, _, annotation = self._found(name)
        if get_origin(annotation) is Literal:
            return list(get_args(annotation))
        if isinstance(value, bool):
            return [False, True]
        if isinstance(value, str):
            return [value, None] if type(None) in get_args(annotation) else None
        if isinstance(value, int):
            return (1, max(4 * value, 2)) if value > 0 else None
        if isinstance(value, Real) and math.isfinite(value) and value != 0.0:
            ends = (self._allowed(name, float(value), wide) for wide in (1.0 / WIDER, WIDER))
            low, high = sorted(float(f"{end:.{DIGITS}g}") for end in ends)
            return (low, high) if low < high else None
        return None

    def _allowed(self, name: str, value: float, wide: float) -> float:
        """End of a guessed range: the value times a factor, or nearer to the value where the part refuses that."""
        if not isinstance(self.model, Mechanism):
            return value * wide
        for end in (value * wide, *(value * (1.0 + share * (wide - 1.0)) for share in NEARER)):
            with suppress(FlexmbError), warnings.catch_warnings():
                warnings.simplefilter("ignore", RestitutionWarning)
                self.model.with_({name: end})
                return end
        return value

    def _knob(self, name: str, given: Any) -> Knob:
        value, unit, kind, annotation = self._found(name)
        span = self._guessed(name) if given is None else given
        if span is None:
            text = f"{LABEL}: the range of {name!r} cannot be guessed from its value {_short(value)}"
            raise InputError(f"{text}. Give it: vary={{{name!r}: (low, high)}}, or a list of choices.")
        knob = Knob(name, "number", value, unit=unit, meaning=self._meaning(name))
        if isinstance(span, Mapping):
            return _choice(knob, [(str(label), one) for label, one in span.items()])
        both = checks.sequence(LABEL, f"vary[{name!r}]", span, "two ends of a range, or choices")
        if not (len(both) == 2 and all(isinstance(x, Real) and not isinstance(x, bool) for x in both)):
            return _choice(knob, [(_label(one), one) for one in both])
        low, high = (checks.number(LABEL, f"vary[{name!r}]", x, unit) for x in both)
        if not low < high:
            raise InputError(f"{LABEL}: the range of {name} is {low:g} to {high:g}; the first must be the lower end.")
        whole = kind == "int" or (type(value) is int and "float" not in kind.split(" | "))
        optional = "None" in kind.split(" | ") or type(None) in get_args(annotation)
        made = replace(knob, kind="count" if whole else "number", low=low, high=high, optional=optional)
        return replace(made, value=_within(value, low, high, whole=whole))


def _within(value: Any, low: float, high: float, *, whole: bool) -> float | int:
    """Start value in a range: the present one, its nearest end, or for no number the middle."""
    if isinstance(value, Real) and math.isfinite(value):
        near = min(max(float(value), low), high)
        return round(near) if whole else near
    middle = math.sqrt(low * high) if low > 0.0 else 0.5 * (low + high)
    return round(middle) if whole else min(max(float(f"{middle:.{DIGITS}g}"), low), high)


def _choice(knob: Knob, choices: Sequence[tuple[str, Any]]) -> Knob:
    """A choice of labelled values; it starts with the present value, else with the first one."""
    labels = [label for label, _ in choices]
    if len(choices) < 2 or len(set(labels)) < len(labels):
        raise InputError(f"{LABEL}: {knob.name} has the choices {labels}; give at least two that differ.")
    start = next((label for label, one in choices if one is knob.value or one == knob.value), labels[0])
    return replace(knob, kind="choice", value=start, choices=tuple(choices))


def _label(value: Any) -> str:
    return {True: "yes", False: "no"}[value] if isinstance(value, bool) else "none" if value is None else str(value)


def _numbers_of(owner: Part | Any, depth: int) -> Iterator[str]:
    """Paths of the numbers with a declared meaning in a part, and in its records."""
    kind: Any = type(owner)
    said = {field.name for field in fields_of(kind) if field.meaning}
    for field in fields(owner):
        value = getattr(owner, field.name)
        if not field.init or field.name == "name" or isinstance(value, Part):
            continue
        if is_dataclass(value) and depth > 1:
            yield from (f"{field.name}.{path}" for path in _numbers_of(value, depth - 1))
        elif field.name in said and isinstance(value, float):
            yield field.name
