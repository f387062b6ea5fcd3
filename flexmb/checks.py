"""Checks of arguments; each error names the object, the wrong value and the remedy."""

import math
from collections.abc import Callable, Iterable, Mapping
from contextvars import ContextVar
from difflib import get_close_matches
from functools import wraps
from importlib import import_module
from numbers import Real
from os import PathLike
from pathlib import Path
from types import ModuleType
from typing import Any, TypeVar

from flexmb.errors import USER_ERRORS, FlexmbError, InputError, MissingPackageError

T = TypeVar("T")
# Errors of the object that is under construction; None: an error is raised at once.
_COLLECTED: ContextVar[list[str] | None] = ContextVar("collected", default=None)


def collecting(check: Callable[[Any], None]) -> Callable[[Any], None]:
    """A `__post_init__` that collects the errors of all its checks, and raises them as one."""

    @wraps(check)
    def checked(self: Any) -> None:
        if _COLLECTED.get() is not None:  # called by that of a subclass
            return check(self)
        errors: list[str] = []
        token = _COLLECTED.set(errors)
        try:
            check(self)
        except FlexmbError as error:
            if not errors:
                raise
            _collect(errors, str(error))
        except USER_ERRORS:
            if not errors:  # else a consequence of a wrong argument
                raise
        finally:
            _COLLECTED.reset(token)
        if errors:
            raise InputError(" ".join(errors))
        return None

    return checked


def _collect(errors: list[str], text: str) -> None:
    """Add an error, unless there is one on the same argument."""
    if not any(known.partition(" is ")[0] == text.partition(" is ")[0] for known in errors):
        errors.append(text)


def refuse(text: str) -> None:
    """Raise `InputError`; during the construction of a `Checked` object at its end, together with others."""
    errors = _COLLECTED.get()
    if errors is None:
        raise InputError(text)
    _collect(errors, text)


def number(owner: str, name: str, value: object, unit: str = "") -> float:
    """`value` as a finite float, or `InputError`."""
    if type(value) is float:  # most are: asking an abstract base class takes longer
        result = value
    elif isinstance(value, bool) or not isinstance(value, Real):
        refuse(f"{owner}: {name} is {value!r}; it must be a number{_in(unit)}.")
        return math.nan
    else:
        result = as_float(value)
    if not math.isfinite(result):
        refuse(f"{owner}: {name} is {result}; it must be finite{_in(unit)}.")
    return result


def as_float(value: Real) -> float:
    """`value` as a float; infinite where it is too large for one."""
    try:
        return float(value)
    except OverflowError:
        return math.inf if abs(value) == value else -math.inf


def positive(owner: str, name: str, value: object, unit: str = "", hint: str = "") -> float:
    """`value` as a float > 0, or `InputError`."""
    result = number(owner, name, value, unit)
    if result <= 0.0:
        refuse(f"{owner}: {name} is {_sized(result, unit)}; it must be > 0. {hint}".rstrip())
    return result


def not_negative(owner: str, name: str, value: object, unit: str = "", hint: str = "") -> float:
    """`value` as a float >= 0, or `InputError`."""
    result = number(owner, name, value, unit)
    if result < 0.0:
        refuse(f"{owner}: {name} is {_sized(result, unit)}; it must be >= 0. {hint}".rstrip())
    return result


def between(owner: str, name: str, value: object, low: float, high: float, unit: str = "", hint: str = "") -> float:
    """`value` as a float in [low, high], or `InputError`."""
    result = number(owner, name, value, unit)
    if not low <= result <= high and math.isfinite(result):
        text = f"{owner}: {name} is {_sized(result, unit)}; it must lie between {low:g} and {high:g}."
        refuse(f"{text} {hint}".rstrip())
    return result


def count(owner: str, name: str, value: object, least: int = 1, hint: str = "") -> int:
    """`value` as an int >= `least`, or `InputError`."""
    whole = as_float(value) if isinstance(value, Real) and not isinstance(value, bool) else math.nan
    if not whole.is_integer():
        shown = whole if math.isinf(whole) else value  # whose digits may fill pages
        raise InputError(f"{owner}: {name} is {shown!r}; it must be a whole number. {hint}".rstrip())
    if whole < least:
        raise InputError(f"{owner}: {name} is {whole:g}; it must be at least {least}. {hint}".rstrip())
    return int(whole)


class MarkedPoint(tuple[float, float]):
    """Point (x, y) of the marker whose name is `marker`; it follows the marker when a mechanism is changed."""

    marker = ""


def point(owner: str, name: str, value: object, unit: str = "m") -> tuple[float, float]:
    """`value` as a point (x, y) [m], or as a vector with another unit; else `InputError`."""
    try:
        x, y = value if isinstance(value, Iterable) else ()
    except (ValueError, TypeError):  # TypeError: an array without dimensions
        raise InputError(f"{owner}: {name} is {value!r}; it must be a pair (x, y){_in(unit)}.") from None
    found: Any = number(owner, f"{name}[0]", x, unit), number(owner, f"{name}[1]", y, unit)
    marker = getattr(value, "marker", None)
    if isinstance(marker, str):
        found = MarkedPoint(found)
        found.marker = marker
    return found  # type: ignore[no-any-return]


def direction(owner: str, name: str, value: object) -> tuple[float, float]:
    """`value` as a vector (x, y) with a length > 0, or `InputError`."""
    x, y = point(owner, name, value, "")
    if math.hypot(x, y) <= 0.0:
        raise InputError(f"{owner}: {name} is {value}; it must be a direction with a length > 0.")
    return x, y


def sequence(owner: str, name: str, value: object, of: str) -> tuple[Any, ...]:
    """`value` as a tuple, or `InputError`; `of`: kind of its items, for the message."""
    if isinstance(value, str) or not isinstance(value, Iterable):
        raise InputError(f"{owner}: {name} is {value!r}; it must be a list of {of}.")
    try:
        return tuple(value)
    except TypeError:  # an array without dimensions
        raise InputError(f"{owner}: {name} is {value!r}; it must be a list of {of}.") from None


def mapping(owner: str, name: str, value: object) -> dict[str, Any]:
    """`value` as a dictionary, empty if it is None, or `InputError`."""
    if value is not None and not isinstance(value, Mapping):
        raise InputError(f"{owner}: {name} is {value!r}; it must be a dictionary of names and values.")
    return dict(value or {})


def path(owner: str, value: object) -> Path:
    """`value` as a path, or `InputError`."""
    if not isinstance(value, (str, PathLike)):
        raise InputError(f"{owner}: the path is {value!r}; it must be a text or a Path.")
    if "\0" in str(value):
        raise InputError(f"{owner}: the path is {value!r}; it holds the character NUL, which no path has.")
    return Path(value)


def identifier(owner: str, value: object) -> str:
    """`value` as a name of a part: a non-empty string without dot, slash, NUL or white space at its ends."""
    if not isinstance(value, str) or not value or value != value.strip() or set(value) & {".", "/", "\0"}:
        raise InputError(f"{owner}: name is {value!r}; it must be a non-empty string without '.', '/' or outer blanks.")
    return value


def no_name_of_nodes(owner: str, names: Iterable[str], stem: str, nodes: str) -> None:
    """Refuse names of pins that a body gives to other nodes: `stem` and a number."""
    for name in names:
        if name.startswith(stem) and name[len(stem) :].isdecimal():
            raise InputError(f"{owner}: the pin {name!r} has a name of the {nodes}, {stem!r} and a number. Rename it.")


def flag(owner: str, name: str, value: object) -> bool:
    """`value` if it is True or False, or `InputError`."""
    if not isinstance(value, bool):
        refuse(f"{owner}: {name} is {value!r}; it must be True or False.")
    return bool(value)


def instance(owner: str, name: str, value: Any, kind: type[T] | tuple[type[T], ...], wanted: str) -> T:
    """`value` if it is an object of a class, or `InputError`; `wanted` ends the message: "a motion, e.g. Ramp(1.0)"."""
    if not isinstance(value, kind):
        raise InputError(f"{owner}: {name} is {value!r}; it must be {wanted}.")
    return value


def one_of(owner: str, name: str, value: object, allowed: Iterable[str]) -> str:
    """`value` if it is among `allowed`, else `InputError` with the nearest allowed one."""
    names = list(allowed)
    if isinstance(value, str) and value in names:
        return value
    raise InputError(f"{owner}: {name} is {value!r}. {did_you_mean(str(value), names)}")


def did_you_mean(word: object, names: Iterable[str], common: str = "", what: str = "Known") -> str:
    """Hint on an unknown name: the nearest name, then all names."""
    # common : beginning of all names, which is not compared; what : noun before the list of them.
    known = list(names)
    ends, likeness = [name.removeprefix(common) for name in known], 0.5 if common else 0.6
    near = get_close_matches(str(word).removeprefix(common), ends, n=1, cutoff=likeness)
    guess = f"Did you mean {common + near[0]!r}? " if near else ""
    listed = ", ".join(known[:40]) + (", ..." if len(known) > 40 else "")
    return f"{guess}{what}: {listed}."


def package(name: str, extra: str, purpose: str) -> ModuleType:
    """The imported optional package `name`, or an error with the package to install."""
    try:
        return import_module(name)
    except ImportError as error:
        text = f"{purpose} needs the package {name!r}. Install it with: pip install 'flexmb[{extra}]'."
        raise MissingPackageError(text) from error


def _in(unit: str) -> str:
    return f" in {unit}" if unit else ""


def _sized(value: float, unit: str) -> str:
    return f"{value:g} {unit}".rstrip()
