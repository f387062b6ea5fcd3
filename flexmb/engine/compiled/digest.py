"""Digests of values and functions: short texts that are equal if and only if the contents are equal.

Digests depend on values, not on addresses or on the order of a set, and are therefore the same in every process.  A
function counts with its text, code, defaults, closure and attributes, and all that it names, in turn with what that
names.  Installed packages count by version, functions of flexmb by text.  Files that are read do not count.
"""

import ast
import copyreg
import dis
import hashlib
import inspect
import sys
import textwrap
from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, fields, is_dataclass
from functools import cached_property, singledispatch
from importlib.util import find_spec, resolve_name
from pickle import PicklingError
from types import CodeType, FunctionType, MethodType, ModuleType
from typing import Any

import numpy as np

from flexmb.engine.compiled.code_cache import PACKAGE, is_of_user, is_users_file

DIGITS = 16  # number of hexadecimal digits of a digest
# Words of a digest before the kinds of objects whose content cannot be told (open files, locks, handles).
UNKNOWN = " but for "
# Errors of classes and modules of others, in place of their content.
FAILURES = (
    TypeError, ValueError, AttributeError, ImportError, LookupError, NameError, ArithmeticError, RuntimeError, OSError,
    SyntaxError, AssertionError, PicklingError,
)  # fmt: skip

Parts = bytes | tuple[str, Sequence[Any]]
SIMPLE = {type(None), bool, int, float, complex, str, bytes}  # classes of most values, which contain no others


def digest(value: Any) -> str:
    """Digest of a value; equal for equal values, with numbers compared bit by bit."""
    feed = _Feed()
    feed.add(value, ())
    for named in feed.shared:  # grows meanwhile
        feed.content(parts_of(named), (id(named),))
    found = feed.state.hexdigest()[:DIGITS]
    return f"{found}{UNKNOWN}{', '.join(sorted(feed.unknown))}" if feed.unknown else found


class _Feed:
    """State of a digest: functions and classes are written once, behind all others, and elsewhere by their number."""

    def __init__(self) -> None:
        self.state, self.unknown = hashlib.sha256(), set[str]()
        self.shared, self._numbers = list[Any](), dict[int, int]()

    def add(self, value: Any, above: tuple[int, ...]) -> None:
        """Add `value`; `above` are the ids of the objects that contain it."""
        if type(value) in SIMPLE:
            self.content(repr(value).encode(), ())
        elif isinstance(value, FunctionType | type) and is_of_user(_home(value)):
            number = self._numbers.setdefault(id(value), len(self.shared))
            if number == len(self.shared):
                self.shared.append(value)
            self.state.update(b"|shared %d" % number)
        elif id(value) in above:
            self.state.update(b"|again")
        else:
            if is_of_user(type(value).__module__):  # a tuple or number of a user's class has methods, too
                self.add(type(value), above)
            self.content(parts_of(value), (*above, id(value)))

    def content(self, content: Parts, above: tuple[int, ...]) -> None:
        """Add bytes, or the entries of a composed value."""
        if isinstance(content, bytes):
            self.state.update(b"|%d:" % len(content) + content)
            return
        name, entries = content
        if name.startswith(UNKNOWN):
            self.unknown.add(name.removeprefix(UNKNOWN))
        self.state.update(f"|{name}({len(entries)}".encode())
        for entry in entries:
            self.add(entry, above)
        self.state.update(b")")


def kind_of(value: Any) -> str:
    """Full name of the class of a value."""
    return f"{type(value).__module__}.{type(value).__qualname__}"


@singledispatch
def parts_of(value: Any) -> Parts:
    """Bytes of a simple value, or name and entries of a composed one."""
    unwrapped = inspect.unwrap(value) if callable(value) else value
    if unwrapped is not value:  # compiled by numba, for example
        return "wrapped", [unwrapped]
    if is_dataclass(value):
        return kind_of(value), [part for f in fields(value) for part in (f.name, getattr(value, f.name, None))]
    try:
        reduced = copyreg.dispatch_table.get(type(value), lambda one: one.__reduce_ex__(4))(value)
    except FAILURES:
        return f"{UNKNOWN}{kind_of(value)}", ()
    if isinstance(reduced, str):
        return f"{kind_of(value)} {getattr(value, '__module__', '')} {reduced}".encode()
    return kind_of(value), [list(part) if isinstance(part, Iterator) else part for part in reduced]


for _written in int, str, bytes, float, complex, type(None):
    parts_of.register(_written, lambda value: repr(value).encode())


@parts_of.register
def _numpy_number(value: np.generic) -> Parts:
    plain = value.item()
    return repr(value).encode() if isinstance(plain, np.generic) else parts_of(plain)


@parts_of.register
def _array(value: np.ndarray) -> Parts:
    if value.dtype == object:
        return "list", value.tolist()
    kind = value.dtype.descr if value.dtype.names else value.dtype.str
    plain = f"{kind}{value.shape}".encode() + np.ascontiguousarray(value).tobytes()
    if isinstance(value, np.ma.MaskedArray):
        return "masked", [plain, np.ma.getmaskarray(value)]
    return (kind_of(value), [plain, sorted(vars(value).items())]) if is_of_user(type(value).__module__) else plain


@parts_of.register(tuple)
@parts_of.register(list)
def _list(value: Any) -> Parts:
    return "tuple" if isinstance(value, tuple) else "list", value


@parts_of.register(Mapping)
def _map(value: Any) -> Parts:
    """Entries in their order, and additions of a class of dictionaries."""
    entries = [part for key in value for part in (key, value[key])]
    if not isinstance(value, dict) or type(value) is dict:
        return "map", entries
    own = sorted(getattr(value, "__dict__", {}).items())
    return kind_of(value), [*entries, getattr(value, "default_factory", None), own]


@parts_of.register(Set)
def _set(value: Any) -> Parts:
    return "set", sorted(digest(item) for item in value)


@parts_of.register
def _method(value: MethodType) -> Parts:
    return "method", [value.__func__, value.__self__]


@parts_of.register(classmethod)
@parts_of.register(staticmethod)
@parts_of.register(property)
@parts_of.register(cached_property)
def _descriptor(value: Any) -> Parts:
    return kind_of(value), [getattr(value, name, None) for name in ("__func__", "fget", "fset", "func")]


@parts_of.register
def _class(value: type) -> Parts:
    """Name of a class; of a user's class also bases, methods and attributes."""
    name = f"{value.__module__}.{value.__qualname__}"
    if not is_of_user(value.__module__):
        return f"{name}{_version(value.__module__)}".encode()
    kinds, items = FunctionType | classmethod | property, sorted(vars(value).items())
    own = {k: x for k, x in items if k != "_abc_impl" and (not k.startswith("__") or isinstance(x, kinds))}
    return "class", [name, type(value), value.__bases__, own]


@dataclass(frozen=True)
class _Used:
    """A module of which code uses attributes of these names."""

    module: ModuleType
    names: frozenset[str]


@parts_of.register
def _module(value: ModuleType) -> Parts:
    return parts_of(_Used(value, frozenset(vars(value))))


@parts_of.register
def _used(value: _Used) -> Parts:
    """Version of an installed module; of a user's module the attributes that are used, or all if none is named."""
    name, found = value.module.__name__, vars(value.module)
    if not is_of_user(name):
        return "module", [name, _version(name)]
    used = sorted(one for one in value.names & found.keys() or found if not one.startswith("__"))
    inner = ((one, found[one]) for one in used)
    parts = [(one, _Used(v, value.names - {one}) if isinstance(v, ModuleType) else v) for one, v in inner]
    return "module", [name, *parts]


@parts_of.register
def _code(value: CodeType) -> Parts:
    taken = value.co_flags, value.co_argcount, value.co_kwonlyargcount
    return "code", [value.co_code, value.co_exceptiontable, value.co_names, value.co_varnames, value.co_consts, taken]


@parts_of.register
def _function(value: FunctionType) -> Parts:
    """Name; of a user's function, and of a wrapper around it, all; code, since files change and lambdas share lines."""
    home = _home(value)
    if not is_of_user(home) and home.partition(".")[0] != PACKAGE:
        return f"{home}.{value.__qualname__}{_version(home)}".encode()
    cells = [_content_of(cell) for cell in value.__closure__ or ()]
    parts = [value.__name__, _text(value), value.__defaults__, value.__kwdefaults__, cells]
    if is_of_user(home):  # what a wrapper of flexmb or of a library names is theirs; what it wraps is in its closure
        kept = {name: item for name, item in sorted(vars(value).items()) if name != "__wrapped__"}
        parts += [value.__code__, kept, named_by(value) if is_of_user(value.__globals__.get("__name__", "")) else {}]
    return "function", parts


def _home(value: Any) -> str:
    """Module of a class or function; the module of the wrapped function for wrappers of the standard library."""
    home = value.__module__ if isinstance(value, type) else value.__globals__.get("__name__", "")
    return home if is_of_user(home) else value.__module__ or home


def _content_of(cell: Any) -> Any:
    """Content of a cell of a closure; None before its first assignment."""
    try:
        return cell.cell_contents
    except ValueError:
        return None


def _text(function: FunctionType) -> Any:
    """Source of a function without comments; its code if there is no source."""
    try:
        return ast.unparse(ast.parse(textwrap.dedent(inspect.getsource(function.__code__))))
    except (OSError, TypeError, SyntaxError):  # typed in, or a lambda in the middle of a statement
        return function.__code__


def named_by(function: FunctionType) -> dict[str, Any]:
    """Objects outside a function that its code names, by name: globals, and modules that it imports."""
    found, texts, attributes, space = set[str](), set[str](), set[str](), function.__globals__
    modules: dict[str, Any] = {}
    for code in _codes(function.__code__):
        texts |= {one for one in code.co_consts if isinstance(one, str) and one.isidentifier()}
        attributes |= set(code.co_names)
        listed = [one for one in dis.get_instructions(code) if one.opname != "EXTENDED_ARG"]
        for k, one in enumerate(listed):
            if one.opname in ("LOAD_GLOBAL", "LOAD_NAME"):
                found.add(one.argval)
            elif one.opname == "IMPORT_NAME":
                name, taken = "." * listed[k - 2].argval + one.argval, listed[k - 1].argval or ()
                also = [f"{name}{'' if name.endswith('.') else '.'}{inner}" for inner in taken]
                for each in (name, *also, *(() if taken else (name.partition(".")[0],))):
                    modules[each] = _imported(each, space.get("__package__") or "")
    found |= texts if "globals" in found else set()
    values = modules | {name: space[name] for name in sorted(found) if name in space and not name.startswith("__")}
    names = frozenset(attributes | texts)
    return {name: _Used(v, names) if isinstance(v, ModuleType) else v for name, v in values.items()}


def _codes(code: CodeType) -> Iterator[CodeType]:
    """A code and all codes within it."""
    yield code
    for one in code.co_consts:
        if isinstance(one, CodeType):
            yield from _codes(one)


def _imported(name: str, package: str) -> Any:
    """Module of a user that a function of a package imports when it is called; the name of any other module."""
    try:
        name = resolve_name(name, package)
        top = name.partition(".")[0]
        spec = None if name in sys.modules else find_spec(top)
        file = spec.origin if spec is not None and spec.has_location else None
        if top == PACKAGE or not (is_of_user(name) if spec is None else file and is_users_file(file)):
            return name
        __import__(name)
    except FAILURES:  # the function will fail, too, or has an answer
        return name
    return sys.modules[name]


def _version(module: str) -> str:
    """Version of an installed package; "" without one."""
    top = module.partition(".")[0]
    return "" if top == PACKAGE else str(getattr(sys.modules.get(top), "__version__", ""))
