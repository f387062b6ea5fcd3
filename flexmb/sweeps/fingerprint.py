"""What results depend on, as short texts: two sweeps whose fingerprints are equal compute the same.

Digests are of values, never of addresses or of the order of a set, so that they are the same in every process.
"""

from __future__ import annotations

import ast
import hashlib
import inspect
import pickle
import textwrap
from collections.abc import Callable, Mapping, Sequence, Set
from dataclasses import fields, is_dataclass
from functools import partial, singledispatch
from types import BuiltinFunctionType, FunctionType, MethodType
from typing import Any

import numpy as np

from flexmb.dynamics.systems.dynamics import Dynamics
from flexmb.kernels import Kernel
from flexmb.model.mechanism import Mechanism
from flexmb.program.program import Program
from flexmb.step.newmark.method import Newmark
from flexmb.step.step_size import Adaptive, FixedStep

DIGITS = 16
DERIVED = ("symbolic", "shapes")
"""Of a program: how its matrix is factored and how it is drawn follow from the rest, or do not count."""

Parts = bytes | tuple[str, Sequence[Any]]

OF_SYSTEMS = (FunctionType, partial, Dynamics, Program, FixedStep, Adaptive, Newmark)
"""What a system holds that its motion depends on, beside its state and its parameters."""


def digest(value: Any) -> str:
    """A short text that is equal for equal values, numbers compared bit by bit."""
    state = hashlib.sha256()
    _feed(state, value, ())
    return state.hexdigest()[:DIGITS]


def label_of(function: Any) -> str:
    """What a function, a mechanism or a system is called: "flexmb.mechanisms.nine_bar.nine_bar"."""
    if isinstance(function, partial):
        return f"partial of {label_of(function.func)}"
    if isinstance(function, (Mechanism, Dynamics)):
        return f"{type(function).__name__} {function.name!r}"
    named = function if isinstance(function, (FunctionType, BuiltinFunctionType, MethodType, type)) else type(function)
    module, name = named.__module__, named.__qualname__
    return name if module in ("__main__", None) else f"{module}.{name}"


def shown_values(values: Sequence[Any]) -> str:
    """A list of values for messages and comparison: how many, from where to where, and their digest."""
    ends = f" from {values[0]!s:.24s} to {values[-1]!s:.24s}" if len(values) else ""
    return f"{len(values)}{ends} ({digest(list(values))})"


def _feed(state: Any, value: Any, above: tuple[int, ...]) -> None:
    """Add `value` to the digest; `above` are the objects that hold it."""
    if id(value) in above:
        state.update(b"|again")
        return
    above = (*above, id(value))
    found = _parts(value)
    if isinstance(found, bytes):
        state.update(b"|%d:" % len(found) + found)
        return
    name, parts = found
    state.update(f"|{name}({len(parts)}".encode())
    for part in parts:
        _feed(state, part, above)
    state.update(b")")


@singledispatch
def _parts(value: Any) -> Parts:
    """The bytes of a simple value, or the name and the parts of another one."""
    unwrapped = inspect.unwrap(value) if callable(value) else value
    if isinstance(unwrapped, FunctionType):  # compiled by numba, for example
        return "function", _function_parts(unwrapped)
    kind = f"{type(value).__module__}.{type(value).__qualname__}"
    if is_dataclass(value):
        names = [f.name for f in fields(value) if not (isinstance(value, Program) and f.name in DERIVED)]
        return kind, [part for name in names for part in (name, getattr(value, name))]
    return kind, [_bytes_of(value)]


@_parts.register(type(None))
@_parts.register(int)
@_parts.register(str)
@_parts.register(bytes)
@_parts.register(float)
@_parts.register(complex)
def _simple(value: Any) -> Parts:
    return repr(value).encode()


@_parts.register(type)
@_parts.register(BuiltinFunctionType)
def _named(value: Any) -> Parts:
    return f"{value.__module__}.{value.__qualname__}".encode()


@_parts.register
def _numpy_number(value: np.generic) -> Parts:
    return _parts(value.item())


@_parts.register
def _array(value: np.ndarray) -> Parts:
    if value.dtype == object:
        return "list", value.tolist()
    return f"{value.dtype.str}{value.shape}".encode() + np.ascontiguousarray(value).tobytes()


@_parts.register(tuple)
@_parts.register(list)
def _list(value: Any) -> Parts:
    return "list", value


@_parts.register(Mapping)
def _map(value: Any) -> Parts:
    return "map", [part for key in sorted(value, key=digest) for part in (key, value[key])]


@_parts.register(Set)
def _set(value: Any) -> Parts:
    return "set", sorted(digest(item) for item in value)


@_parts.register
def _kernel(value: Kernel) -> Parts:
    return "kernel", [value.contract.name, value.function]


@_parts.register
def _partial(value: partial) -> Parts:
    return "partial", [value.func, value.args, value.keywords]


@_parts.register
def _method(value: MethodType) -> Parts:
    return "method", [value.__func__, value.__self__]


@_parts.register
def _system(value: Dynamics) -> Parts:
    inner = [v for _, v in sorted(vars(value).items()) if isinstance(v, OF_SYSTEMS)]
    return type(value).__qualname__, [value.name, value.names, dict(value.parameters), value.state(), *inner]


def _function_parts(function: FunctionType) -> list[Any]:
    """Name, text without comments and layout, defaults, and what a nested function has from those around it."""
    inner = [cell.cell_contents for cell in function.__closure__ or ()]
    return [function.__name__, source_of(function), function.__defaults__, function.__kwdefaults__, inner]


def source_of(function: Callable[..., Any]) -> str:
    """The text of a function without its comments, or its code where there is no text."""
    try:
        return ast.unparse(ast.parse(textwrap.dedent(inspect.getsource(function))))
    except (OSError, TypeError, SyntaxError):  # typed in, or a lambda in the middle of a statement
        code = function.__code__
        return repr((code.co_code, [c for c in code.co_consts if not inspect.iscode(c)], code.co_names))


def _bytes_of(value: Any) -> Any:
    try:
        return pickle.dumps(value, protocol=4)
    except (pickle.PicklingError, AttributeError, TypeError):
        return type(value).__qualname__
