"""Every public name says what it takes, and refuses what it does not know."""

import dataclasses
import functools
import inspect
import re
import types
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from public_names import PUBLIC

from flexmb.arguments import Checked
from flexmb.errors import FlexmbError

NONSENSE = "nonsense_keyword"
REFUSALS = (NONSENSE, "no keyword arguments", "no arguments")
"""What the message of a refusal holds: the keyword itself, or that there are none."""

VARIADIC = (inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD)
SELF_NAMES = {"self", "cls"}


def public_names() -> list[str]:
    """Names of the package and of its namespaces."""
    return sorted(PUBLIC)


def public_callables() -> list[str]:
    """Names of the public functions and classes."""
    return [name for name in public_names() if inspect.isclass(_get(name)) or callable(_get(name))]


def documented_parameters(doc: str) -> list[str] | None:
    """Names in the section "Parameters" of a numpydoc text (stars taken off), or None if it has no such section."""
    match = re.search(r"^Parameters\n-{3,}\n(.*?)(?=\n\S[^\n]*\n-{3,}\n|\Z)", doc, re.DOTALL | re.MULTILINE)
    if match is None:
        return None
    entries = [line for line in match.group(1).splitlines() if line and not line[0].isspace()]
    names = [name for entry in entries for name in re.split(r"\s*:(?:\s|$)", entry, maxsplit=1)[0].split(",")]
    return [name.strip().lstrip("*") for name in names]


def taken_parameters(thing: Any) -> list[str]:
    """Names of the parameters with which `thing` is called; none where Python cannot tell."""
    try:
        signature = inspect.signature(thing)
    except ValueError:  # built-in classes, exceptions among them
        return []
    # `Checked` looks at all arguments before the own __init__ of a class takes them
    generic = issubclass(thing, BaseException | Checked) if inspect.isclass(thing) else False
    names = [p.name for p in signature.parameters.values() if not (generic and p.kind in VARIADIC)]
    return [name for name in names if name not in SELF_NAMES]


def complaints(owner: str, thing: Any) -> Iterator[str]:
    """What the docstring of a function or class lacks. One parameter alone may be named in the running text."""
    doc, taken = inspect.getdoc(thing) or "", taken_parameters(thing)
    if inspect.isclass(thing) and "__doc__" not in {k for k, v in vars(thing).items() if v}:
        doc = ""  # inherited from the base: it does not speak about this class
    if not doc.strip() or _is_made_by_dataclass(thing, doc):
        yield f"{owner} has no docstring"
        return
    named = documented_parameters(doc)
    if named is None and (inspect.isclass(thing) or len(taken) > 1) and taken:
        yield f"{owner} has no section Parameters; it takes {', '.join(taken)}"
    elif named is None:
        yield from (f"{owner} does not mention {name}" for name in taken if not re.search(rf"\b{name}\b", doc))
    elif set(named) != set(taken):
        missing, unknown = sorted(set(taken) - set(named)), sorted(set(named) - set(taken))
        yield f"{owner}: Parameters lacks {missing} and has {unknown}, which it does not take"


def method_complaints(owner: str, cls: type) -> Iterator[str]:
    """What the docstrings of public methods and properties lack; an overriding method may inherit its docstring."""
    for name, member in inspect.getmembers(cls):
        if name.startswith("_") or not _is_ours(cls, name):
            continue
        static = inspect.getattr_static(cls, name)
        if isinstance(static, property | functools.cached_property):
            if not inspect.getdoc(static):
                yield f"{owner}.{name} has no docstring"
        elif inspect.isroutine(member):
            doc = inspect.getdoc(member) or ""
            # what an overriding method takes is documented once, where the method is declared
            told = " ".join([doc, *(str(vars(base)[name].__doc__) for base in cls.__mro__ if name in vars(base))])
            named = documented_parameters(doc) or []
            if not doc.strip():
                yield f"{owner}.{name} has no docstring"
            for parameter in taken_parameters(member):
                if parameter not in named and not re.search(rf"\b{parameter}\b", told):
                    yield f"{owner}.{name} does not mention {parameter}"


def refuses_nonsense(call: Callable[..., Any]) -> str:
    """Empty if an unknown keyword is refused with a message about it, else what happened instead."""
    try:
        call(**{NONSENSE: 1})
    except (TypeError, FlexmbError) as error:
        return "" if any(word in str(error) for word in REFUSALS) else f"failed for another reason: {error}"
    return "was accepted"


def _get(name: str) -> Any:
    return PUBLIC[name]


def _is_made_by_dataclass(thing: Any, doc: str) -> bool:
    return inspect.isclass(thing) and dataclasses.is_dataclass(thing) and doc.startswith(f"{thing.__name__}(")


def _is_ours(cls: type, name: str) -> bool:
    """Whether the class of the method resolution order that holds `name` is one of flexmb's."""
    holder = next(base for base in cls.__mro__ if name in vars(base))
    return holder.__module__.split(".")[0] == "flexmb"


def _can_be_called(name: str) -> bool:
    thing = _get(name)
    if inspect.isclass(thing):
        return not inspect.isabstract(thing)
    return isinstance(thing, types.FunctionType)


@pytest.mark.parametrize("name", public_callables())
def test_docstring_names_every_parameter(name):
    thing = _get(name)
    found = []
    if inspect.isclass(thing):
        found = [*complaints(name, thing), *method_complaints(name, thing)]
    elif isinstance(thing, types.FunctionType):
        found = list(complaints(name, thing))
    assert not found, "\n".join(found)


@pytest.mark.parametrize("name", [name for name in public_callables() if _can_be_called(name)])
def test_unknown_keyword_is_refused(name):
    assert not refuses_nonsense(_get(name)), f"{name}({NONSENSE}=1) {refuses_nonsense(_get(name))}"


@pytest.mark.parametrize("name", [name for name in public_callables() if inspect.isclass(_get(name))])
def test_unknown_keyword_is_refused_by_other_constructors(name):
    cls = _get(name)
    made = [k for k in dir(cls) if not k.startswith("_") and _is_ours(cls, k)]
    others = [k for k in made if isinstance(inspect.getattr_static(cls, k), classmethod)]
    found = {k: refuses_nonsense(getattr(cls, k)) for k in others}
    assert not any(found.values()), {f"{name}.{k}": text for k, text in found.items() if text}


# The guard itself: small specimens, sound and unsound.


def sound(a, *, b=1, **options):
    """Sum of two numbers.

    Parameters
    ----------
    a, b : float
        The numbers [m].
    **options
        Not looked at.

    Returns
    -------
    float
        The sum.
    """


def undocumented_keyword(a, b):
    """Sum.

    Parameters
    ----------
    a : the first number.
    c : not a parameter.
    """


def sectionless(a, b):
    """Sum of a and b."""


def one_parameter(function):
    """Make a function a kernel."""


def one_unmentioned(function):
    """Make a kernel."""


def bare(a):
    return a


@dataclasses.dataclass(frozen=True)
class Sound:
    """A spring.

    Parameters
    ----------
    k : stiffness [N/m].
    """

    k: float
    force: float = dataclasses.field(init=False, default=0.0)


@dataclasses.dataclass(frozen=True)
class Bare:
    k: float


@dataclasses.dataclass(frozen=True)
class Heir(Sound):
    """A spring with a damper.

    Parameters
    ----------
    d : damping [N s/m].
    """

    d: float = 0.0


@dataclasses.dataclass(frozen=True)
class Silent(Sound):
    d: float = 0.0


@pytest.mark.parametrize("thing", [sound, one_parameter, Sound])
def test_sound_specimens_pass(thing):
    assert list(complaints("specimen", thing)) == []


@pytest.mark.parametrize("thing", [undocumented_keyword, sectionless, one_unmentioned, bare, Bare, Heir, Silent])
def test_unsound_specimens_are_found(thing):
    assert len(list(complaints("specimen", thing))) == 1


def test_names_are_read_from_the_section():
    assert documented_parameters(inspect.getdoc(sound)) == ["a", "b", "options"]


def test_swallowed_keywords_are_found():
    assert refuses_nonsense(lambda **options: None) == "was accepted"


def test_a_missing_argument_is_no_refusal():
    assert refuses_nonsense(lambda a, **options: None).startswith("failed for another reason")


def test_a_plain_signature_refuses():
    assert refuses_nonsense(lambda a: None) == ""
