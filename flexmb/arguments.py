"""Arguments of public classes and functions: messages on wrong ones, former names, and entries of docstrings."""

import inspect
import re
from abc import ABCMeta
from collections.abc import Callable, Iterable, Mapping
from dataclasses import FrozenInstanceError
from functools import cache, cached_property, wraps
from inspect import Parameter, Signature, signature
from typing import Any, ClassVar, ParamSpec, TypeVar

from flexmb.checks import collecting, did_you_mean
from flexmb.errors import ArgumentError, InputError
from flexmb.namespace import warn_of_former

TITLE = re.compile(r"(?:^|\n)(\w[\w ]*)\n-{3,}\n")  # title of a section with the line under it
ORDER = ("Parameters", "Attributes", "Raises", "Notes", "Examples")  # order of the titles of a joined docstring


def sections(doc: str) -> dict[str, str]:
    """Sections of a docstring by title; the text before the first section has the title ""."""
    first, *rest = TITLE.split(doc)
    return {"": first.strip(), **{title: text.strip("\n") for title, text in zip(rest[::2], rest[1::2], strict=True)}}


def joined(texts: Mapping[str, str]) -> str:
    """Docstring of sections by title; empty ones are left out."""
    titled = [f"{title}\n{'-' * len(title)}\n{texts[title]}" for title in ORDER if texts.get(title)]
    return "\n\n".join([texts[""], *titled])


def parameters(thing: Any) -> dict[str, str]:
    """Entries of the section "Parameters" of a function or class by name, each as text on one line."""
    found: dict[str, str] = {}
    listed = sections(inspect.getdoc(thing) or "").get("Parameters", "")
    for entry in filter(None, re.split(r"\n(?=\S)", listed)):
        names, _, text = entry.partition(":")
        found |= dict.fromkeys((name.strip() for name in names.split(",")), " ".join(text.split()))
    return found


# Names that other packages give to arguments of `Adaptive`.
OF_STEPS = {"rtol": "rtol", "atol": "atol", "max_step": "max", "min_step": "min"}
P = ParamSpec("P")
T = TypeVar("T")


class CheckedType(ABCMeta):
    """Type of the classes that tell wrong arguments, and take former names of arguments, when they are called."""

    def __call__(cls, *given: Any, **keywords: Any) -> Any:
        """An object of the class; unpickling and copying do not pass here."""
        former = former_names(cls)
        for old in former.keys() & keywords.keys():
            now, _ = former[old]
            if now in keywords:
                raise InputError(f"{cls.__name__}: {old} and {now} are the same; give {now} alone.")
            keywords[present_name(cls, old)] = keywords.pop(old)
        try:
            return super().__call__(*given, **keywords)
        except TypeError:
            name = keywords.get("name", given[0] if given else None)
            refuse_call(f"{cls.__name__} {name!r}" if isinstance(name, str) else cls.__name__, cls, given, keywords)
            raise

    def __setattr__(cls, name: str, value: Any) -> None:
        super().__setattr__(name, _refuse_assignment if name == "__setattr__" else value)

    @property
    def __signature__(cls) -> Signature:
        """Signature of the class, that of its constructor."""
        own = signature(cls.__init__)  # type: ignore[misc]
        return own.replace(parameters=list(own.parameters.values())[1:], return_annotation=Signature.empty)


def _refuse_assignment(owner: Any, name: str, value: Any) -> None:
    """Refuse an assignment to a field of a frozen object, in place of the method that `dataclass` writes."""
    label = getattr(owner, "label", None)
    path = name if label is None or "parts" in vars(owner) else f"{owner.name}.{name}"
    way = f"dataclasses.replace(..., {name}={value!r})" if label is None else f"mech.with_({{{path!r}: {value!r}}})"
    text = f"{label or type(owner).__name__}: {name} cannot be assigned, since nothing changes."
    raise FrozenInstanceError(f"{text} Make another: {way}.")


class _Former(cached_property[Any]):
    """Attribute of a former name; a field of that name in a subclass comes first."""

    def __init__(self, name: str) -> None:
        super().__init__(lambda _: None)
        self.name, self.__doc__ = name, "Former name of a field."

    def __get__(self, owner: Any, kind: Any = None) -> Any:  # type: ignore[override]
        if owner is None or self.name not in former_names(kind):
            raise AttributeError(f"{kind.__name__!r} object has no attribute {self.name!r}")
        return getattr(owner, present_name(kind, self.name))


class Checked(metaclass=CheckedType):
    """Base of classes whose objects tell all errors of their arguments at once, when they are constructed."""

    # `formerly` declares former names of fields and the version in which they go, (("mu", "coefficient", "0.3"),): as
    # arguments, as attributes and in `Mechanism.with_` they are taken with a `DeprecationWarning` until then.
    formerly: ClassVar[tuple[tuple[str, str, str], ...]] = ()

    def __init_subclass__(cls, **keywords: Any) -> None:
        super().__init_subclass__(**keywords)
        own = cls.__dict__.get("__post_init__")
        if own is not None:
            cls.__post_init__ = collecting(own)
        for old, _, _ in cls.__dict__.get("formerly", ()):
            setattr(cls, old, _Former(old))


@cache
def former_names(kind: Any) -> dict[str, tuple[str, str]]:
    """Former names of the fields of a class and of its bases: the present name, and the version without the former."""
    known = signature(kind.__init__).parameters
    declared = [names for base in reversed(kind.__mro__) for names in vars(base).get("formerly", ())]
    return {old: (now, goes) for old, now, goes in declared if now in known and old not in known}


def present_name(kind: Any, name: str) -> str:
    """`name`, or the present name of the field of a class that was called so, with a `DeprecationWarning`."""
    now, goes = former_names(kind).get(name, (name, ""))
    if goes:
        warn_of_former(kind.__name__, name, now, goes)
    return now


def checked(function: Callable[P, T]) -> Callable[P, T]:
    """Decorator: public function whose wrong arguments are refused with the nearest names."""

    @wraps(function)
    def called(*given: P.args, **keywords: P.kwargs) -> T:
        try:
            return function(*given, **keywords)
        except TypeError:
            refuse_call(function.__name__, function, given, keywords)
            raise

    return called


def require_arguments(label: str, function: Callable[..., Any], given: Iterable[str]) -> None:
    """Refuse a function that cannot be called with the `given` names alone; one whose arguments are unknown passes."""
    try:
        signature(function)
    except (TypeError, ValueError):
        return
    refuse_call(label, function, (), dict.fromkeys(given))


def refuse_call(label: str, function: Callable[..., Any], given: tuple[Any, ...], keywords: Mapping[str, Any]) -> None:
    """Refuse a call whose arguments do not fit: too many without names, unknown names, missing ones, in this order."""
    # The docstring of the function or class tells the meaning of missing arguments.
    found = signature(function).parameters.values()
    placed = [one.name for one in found if one.kind is Parameter.POSITIONAL_OR_KEYWORD]
    known = placed + [one.name for one in found if one.kind is Parameter.KEYWORD_ONLY]
    if len(known) < len(found):  # any others are taken
        return
    if len(given) > len(placed):
        listed = f" ({', '.join(placed)})" if placed else ""
        text = f"{label}: {len(given)} arguments were given without names, at most {len(placed)}{listed} may be."
        free = [f"{name}=..." for name in known[len(placed) :] if name not in keywords]
        raise ArgumentError(f"{text} Write the others with their names: {', '.join(free)}." if free else text) from None
    others = [name for name in known if name != "self"]
    hints: list[str] = []
    for name in [name for name in keywords if name not in known]:
        near = did_you_mean(name, others, what="Arguments")
        if name in OF_STEPS and "step" in known:
            near = f"It is one of steps: give step=Adaptive({OF_STEPS[name]}=...)."
        hints.append(f"There is no argument {name!r}. {near}")
    there = {*placed[: len(given)], *keywords}
    meanings = {name: text.partition(";")[0].rstrip(".") for name, text in parameters(function).items()}
    missing = [one.name for one in found if one.default is Parameter.empty and one.name not in there]
    words = {one: f" ({meanings[one]})" if meanings.get(one) else "" for one in missing}
    hints = hints or [f"{one} is missing; give {one}=...{words[one]}." for one in missing]
    if hints:
        raise ArgumentError(f"{label}: {' '.join(hints)}") from None
