"""Arguments of public classes and functions: unknown, missing and nameless ones are told, former names are taken."""

import warnings
from abc import ABCMeta
from collections.abc import Callable, Mapping
from dataclasses import FrozenInstanceError
from functools import cache, wraps
from inspect import Parameter, Signature, signature
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, ParamSpec, TypeVar

from flexmb.checks import collecting, did_you_mean
from flexmb.docstrings import parameters
from flexmb.errors import ArgumentError, InputError

P = ParamSpec("P")
T = TypeVar("T")


class Names(NamedTuple):
    """Names of the arguments of a function; of a method without the object itself.

    Parameters
    ----------
    placed : arguments that may be given without their names, in order.
    named : arguments that need their names.
    required : arguments without a default.
    is_open : whether any other arguments are taken.
    """

    placed: tuple[str, ...]
    named: tuple[str, ...]
    required: frozenset[str]
    is_open: bool


@cache
def names_of(function: Callable[..., Any], skipped: int) -> Names:
    """Names of the arguments of a function without the first `skipped` ones."""
    found = list(signature(function).parameters.values())[skipped:]
    placed = tuple(one.name for one in found if one.kind is Parameter.POSITIONAL_OR_KEYWORD)
    named = tuple(one.name for one in found if one.kind is Parameter.KEYWORD_ONLY)
    needed = frozenset(one.name for one in found if one.name in placed + named and one.default is Parameter.empty)
    return Names(placed, named, needed, is_open=len(found) > len(placed) + len(named))


class CheckedType(ABCMeta):
    """Type of the classes that tell wrong arguments, and take former names of arguments, when they are called."""

    def __call__(cls, *given: Any, **keywords: Any) -> Any:
        """An object of the class; unpickling and copying do not pass here."""
        names, former = names_of(cls.__init__, 1), former_names(cls)  # type: ignore[misc]
        if former and not former.keys().isdisjoint(keywords):
            keywords = renamed(cls.__name__, former, keywords)
        missing = names.required.difference(keywords, names.placed[: len(given)])
        if missing or len(given) > len(names.placed) or not keywords.keys() <= {*names.placed, *names.named}:
            refuse_call(owner_of(cls, given, keywords), cls, names, given, keywords)
        return super().__call__(*given, **keywords)

    def __setattr__(cls, name: str, value: Any) -> None:
        super().__setattr__(name, _refuse_assignment if name == "__setattr__" else value)

    @property
    def __signature__(cls) -> Signature:
        """Signature of the class, that of its constructor."""
        own = signature(cls.__init__)  # type: ignore[misc]
        return own.replace(parameters=list(own.parameters.values())[1:], return_annotation=Signature.empty)


def _refuse_assignment(owner: Any, name: str, value: Any) -> None:
    """Refuse an assignment to a field of a frozen object, in place of the method that `dataclass` writes."""
    label = getattr(owner, "label", type(owner).__name__)
    path = f"{owner.name}.{name}" if hasattr(owner, "references") else name if hasattr(owner, "parts") else None
    way = f"dataclasses.replace(..., {name}={value!r})" if path is None else f"mech.with_({{{path!r}: {value!r}}})"
    raise FrozenInstanceError(f"{label}: {name} cannot be assigned, since nothing changes. Make another: {way}.")


class Checked(metaclass=CheckedType):
    """Base of classes whose objects tell all errors of their arguments at once, when they are constructed.

    `formerly` declares former names of fields, {"mu": "coefficient"}: as arguments, as attributes and in
    `Mechanism.with_` they are taken with a `DeprecationWarning`, for one version.
    """

    formerly: ClassVar[Mapping[str, str]] = {}

    def __init_subclass__(cls, **keywords: Any) -> None:
        super().__init_subclass__(**keywords)
        own = cls.__dict__.get("__post_init__")
        if own is not None:
            cls.__post_init__ = collecting(own)  # type: ignore[attr-defined]

    if not TYPE_CHECKING:  # which would take any name for an attribute

        def __getattr__(self, name: str) -> Any:
            """The field that was called `name`; asked for attributes that are missing alone."""
            now = former_names(type(self)).get(name)
            if now is None:
                raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
            _warn(type(self).__name__, name, now)
            return getattr(self, now)


@cache
def former_names(kind: type) -> dict[str, str]:
    """Former names of the fields of a class and of its bases, with the present ones, for fields that it has."""
    names = names_of(kind.__init__, 1)  # type: ignore[misc]
    known = {*names.placed, *names.named}
    declared = [vars(base).get("formerly", {}) for base in reversed(kind.__mro__)]
    return {old: now for one in declared for old, now in one.items() if now in known and old not in known}


def renamed(label: str, former: Mapping[str, str], given: Mapping[str, Any]) -> dict[str, Any]:
    """`given` values with former names replaced by present ones, each with a `DeprecationWarning`.

    Parameters
    ----------
    label : owner of the names, for messages.
    former : former names with the present ones.
    given : values by names.

    Raises
    ------
    InputError : a value under both names.
    """
    found = dict(given)
    for old in former.keys() & given.keys():
        now = former[old]
        if now in given:
            raise InputError(f"{label}: {old} and {now} are the same; give {now} alone.")
        _warn(label, old, now)
        found[now] = found.pop(old)
    return found


def _warn(label: str, old: str, now: str) -> None:
    text = f"{label}: {old} is called {now} now; the former name goes with the next version."
    warnings.warn(text, DeprecationWarning, stacklevel=4)


def checked(function: Callable[P, T]) -> Callable[P, T]:
    """Decorator: public function whose wrong arguments are told with the nearest names."""

    @wraps(function)
    def called(*given: P.args, **keywords: P.kwargs) -> T:
        names = names_of(function, 0)
        missing = names.required.difference(keywords, names.placed[: len(given)])
        if missing or len(given) > len(names.placed) or not keywords.keys() <= {*names.placed, *names.named}:
            refuse_call(function.__name__, function, names, given, keywords)
        return function(*given, **keywords)

    return called


def owner_of(kind: type, given: tuple[Any, ...], keywords: Mapping[str, Any]) -> str:
    """Class and name of an object that is to be made, as messages show it."""
    name = keywords.get("name", given[0] if given else None)
    return f"{kind.__name__} {name!r}" if isinstance(name, str) else kind.__name__


def refuse_call(
    owner: str, function: Callable[..., Any], names: Names, given: tuple[Any, ...], keywords: Mapping[str, Any]
) -> None:
    """Refuse a call whose arguments do not fit: too many without names, unknown names, missing ones, in this order.

    Parameters
    ----------
    owner : who is called, for messages.
    function : function or class, whose docstring tells the meaning of missing arguments.
    names : names of its arguments.
    given : arguments without names.
    keywords : arguments with names.

    Raises
    ------
    ArgumentError : arguments that do not fit.
    """
    if names.is_open:
        return
    known = [*names.placed, *names.named]
    if len(given) > len(names.placed):
        listed = f" ({', '.join(names.placed)})" if names.placed else ""
        text = f"{owner}: {len(given)} arguments were given without names, at most {len(names.placed)}{listed} may be."
        free = [f"{name}=..." for name in names.named if name not in keywords]
        raise ArgumentError(f"{text} Write the others with their names: {', '.join(free)}." if free else text)
    unknown = [name for name in keywords if name not in known]
    if unknown:
        hints = [f"There is no argument {name!r}. {did_you_mean(name, known, what='Arguments')}" for name in unknown]
        raise ArgumentError(f"{owner}: {' '.join(hints)}")
    missing = [name for name in known if name in names.required.difference(keywords, names.placed[: len(given)])]
    texts = parameters(function)
    meant = " ".join(f"{one} is missing; give {one}=...{_meaning(texts.get(one))}." for one in missing)
    raise ArgumentError(f"{owner}: {meant}")


def _meaning(text: str | None) -> str:
    """Meaning of an argument in brackets, by its entry in a docstring."""
    first = (text or "").partition(";")[0].rstrip(".")
    return f" ({first})" if first else ""
