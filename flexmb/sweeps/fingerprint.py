"""Fingerprints of sweeps: short texts that are equal if and only if the results are equal.

Digests depend on values, not on addresses or on the order of a set, and are therefore the same in every process.
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
"""Number of hexadecimal digits of a digest."""
DERIVED = ("symbolic", "shapes")
"""Fields of a program without influence on the digest; the other fields determine them."""

Parts = bytes | tuple[str, Sequence[Any]]

OF_SYSTEMS = (FunctionType, partial, Dynamics, Program, FixedStep, Adaptive, Newmark)
"""Classes of the attributes of a system that influence its motion, besides state and parameters."""


def digest(value: Any) -> str:
    """Digest of a value; equal for equal values, with numbers compared bit by bit.

    Parameters
    ----------
    value : any value.
    """
    state = hashlib.sha256()
    _feed(state, value, ())
    return state.hexdigest()[:DIGITS]


def label_of(function: Any) -> str:
    """Name of a function, a mechanism or a system, such as "flexmb.mechanisms.nine_bar.nine_bar".

    Parameters
    ----------
    function : the object.
    """
    if isinstance(function, partial):
        return f"partial of {label_of(function.func)}"
    if isinstance(function, (Mechanism, Dynamics)):
        return f"{type(function).__name__} {function.name!r}"
    named = function if isinstance(function, (FunctionType, BuiltinFunctionType, MethodType, type)) else type(function)
    module, name = named.__module__, named.__qualname__
    return name if module in ("__main__", None) else f"{module}.{name}"


def shown_values(values: Sequence[Any]) -> str:
    """Number, first and last value and digest of a list of `values`, for messages and comparison."""
    ends = f" from {values[0]!s:.24s} to {values[-1]!s:.24s}" if len(values) else ""
    return f"{len(values)}{ends} ({digest(list(values))})"


def _feed(state: Any, value: Any, above: tuple[int, ...]) -> None:
    """Add `value` to the digest; `above` are the ids of the objects that contain it."""
    if id(value) in above:
        state.update(b"|again")
        return
    above = (*above, id(value))
    content = _parts(value)
    if isinstance(content, bytes):
        state.update(b"|%d:" % len(content) + content)
        return
    name, entries = content
    state.update(f"|{name}({len(entries)}".encode())
    for entry in entries:
        _feed(state, entry, above)
    state.update(b")")


@singledispatch
def _parts(value: Any) -> Parts:
    """Bytes of a simple value, or name and entries of a composed one."""
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
def _partial(value: partial) -> Parts:  # type: ignore[type-arg] # singledispatch takes no subscripted class
    return "partial", [value.func, value.args, value.keywords]


@_parts.register
def _method(value: MethodType) -> Parts:
    return "method", [value.__func__, value.__self__]


@_parts.register
def _system(value: Dynamics) -> Parts:
    inner = [v for _, v in sorted(vars(value).items()) if isinstance(v, OF_SYSTEMS)]
    return type(value).__qualname__, [value.name, value.names, dict(value.parameters), value.state(), *inner]


def _function_parts(function: FunctionType) -> list[Any]:
    """Name, source without comments and layout, defaults and closure of a function."""
    inner = [cell.cell_contents for cell in function.__closure__ or ()]
    return [function.__name__, source_of(function), function.__defaults__, function.__kwdefaults__, inner]


def source_of(function: Callable[..., Any]) -> str:
    """Source of a `function` without comments; its code if there is no source."""
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
