"""Fingerprints of sweeps: short texts that are equal if and only if the results are equal."""

from __future__ import annotations

import inspect
from collections.abc import Sequence
from dataclasses import fields
from functools import partial
from types import BuiltinFunctionType, FunctionType, MethodType
from typing import Any

from flexmb.compiled.digest import Parts, digest, kind_of, named_by, parts_of
from flexmb.dynamics.systems.dynamics import Dynamics
from flexmb.model.mechanism import Mechanism
from flexmb.program.program import Program
from flexmb.step.newmark.method import Newmark
from flexmb.step.step_size import Adaptive, FixedStep

DERIVED = ("symbolic", "shapes")
"""Fields of a program without influence on the digest; the other fields determine them."""

OF_SYSTEMS = (FunctionType, partial, Dynamics, Program, FixedStep, Adaptive, Newmark)
"""Classes of the attributes of a system that influence its motion, besides state and parameters."""


def label_of(function: Any) -> str:
    """Name of a function, a mechanism or a system, such as "flexmb.mechanisms.nine_bar.nine_bar"."""
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


def texts_of(name: str, function: Any) -> dict[str, str]:
    """Digests of a function, and of each object that it names, for messages and comparison."""
    plain = inspect.unwrap(function) if callable(function) else function
    named = named_by(plain) if isinstance(plain, FunctionType) else {}
    return {name: digest(function), **{f"global {key}": digest(named[key]) for key in sorted(named)}}


@parts_of.register
def _system(value: Dynamics) -> Parts:
    inner = [v for _, v in sorted(vars(value).items()) if isinstance(v, OF_SYSTEMS)]
    return type(value).__qualname__, [value.name, value.names, dict(value.parameters), value.state(), *inner]


@parts_of.register
def _program(value: Program) -> Parts:
    names = [f.name for f in fields(value) if f.name not in DERIVED]
    return kind_of(value), [part for name in names for part in (name, getattr(value, name))]
