"""Derivatives of the elementary functions, as formulas in Python.

x, y: the arguments; f: the value.  A rule gives one formula an argument, the partial derivative by it; at a pole (sqrt
at 0) the formula gives 0, which keeps laws finite at the onset of a contact.  The formulas are read in a name space
with `_math` and `_np`.
"""

import builtins
import math
from collections.abc import Callable
from typing import Any

import numpy as np

UNARY = {
    "sin": "_math.cos(x)",
    "cos": "-_math.sin(x)",
    "tan": "(1.0 + f * f)",
    "asin": "1.0 / _math.sqrt(1.0 - x * x)",
    "acos": "-1.0 / _math.sqrt(1.0 - x * x)",
    "atan": "1.0 / (1.0 + x * x)",
    "sinh": "_math.cosh(x)",
    "cosh": "_math.sinh(x)",
    "tanh": "(1.0 - f * f)",
    "asinh": "1.0 / _math.sqrt(1.0 + x * x)",
    "acosh": "1.0 / _math.sqrt(x * x - 1.0)",
    "atanh": "1.0 / (1.0 - x * x)",
    "exp": "f",
    "expm1": "(f + 1.0)",
    "log": "1.0 / x",
    "log1p": "1.0 / (1.0 + x)",
    "log2": "1.4426950408889634 / x",
    "log10": "0.4342944819032518 / x",
    "sqrt": "(0.5 / f if f > 0.0 else 0.0)",
    "cbrt": "(1.0 / (3.0 * f * f) if f != 0.0 else 0.0)",
    "erf": "1.1283791670955126 * _math.exp(-x * x)",
    "erfc": "-1.1283791670955126 * _math.exp(-x * x)",
    "degrees": "57.29577951308232",
    "radians": "0.017453292519943295",
    "square": "2.0 * x",
    "fabs": "(1.0 if x > 0.0 else (-1.0 if x < 0.0 else 0.0))",
}
NUMPY_NAMES = {
    "arcsin": "asin", "arccos": "acos", "arctan": "atan", "arcsinh": "asinh", "arccosh": "acosh", "arctanh": "atanh",
    "abs": "fabs", "absolute": "fabs", "deg2rad": "radians", "rad2deg": "degrees",
}  # fmt: skip

BINARY = {
    "hypot": ("(x / f if f > 0.0 else 0.0)", "(y / f if f > 0.0 else 0.0)"),
    "atan2": ("y / (x * x + y * y)", "-x / (x * x + y * y)"),
    "copysign": ("(_math.copysign(1.0, x) * _math.copysign(1.0, y))", "0.0"),
    "fmod": ("1.0", "-float(_math.trunc(x / y))"),
}

POWER = ("(y * x ** (y - 1.0) if x != 0.0 or y >= 1.0 else 0.0)", "(f * _math.log(x) if x > 0.0 else 0.0)")

OPERATORS = {
    "Add": ("1", "1"),
    "Sub": ("1", "-1"),
    "Mult": ("y", "x"),
    "Div": ("1.0 / y", "-f / y"),
    "Pow": POWER,
    "Mod": ("1.0", "-_math.floor(x / y)"),
}
SYMBOLS = {"Add": "+", "Sub": "-", "Mult": "*", "Div": "/", "Pow": "**", "Mod": "%"}

Rule = tuple[str, ...]


def _table() -> dict[int, tuple[Any, Rule]]:
    """Function -> rule, by identity: names may be imported under any other."""
    found: dict[int, tuple[Any, Rule]] = {id(abs): (abs, (UNARY["fabs"],)), id(float): (float, ("1",))}
    for name, formula in UNARY.items():
        for function in (getattr(math, name, None), getattr(np, name, None)):
            if function is not None:
                found[id(function)] = (function, (formula,))
    for name, same in NUMPY_NAMES.items():
        found[id(getattr(np, name))] = (getattr(np, name), (UNARY[same],))
    for name, both in BINARY.items():
        for function in (getattr(math, name), getattr(np, {"atan2": "arctan2"}.get(name, name))):
            found[id(function)] = (function, both)
    for function in (math.pow, np.power):
        found[id(function)] = (function, POWER)
    found[id(np.float64)] = (np.float64, ("1",))
    return found


_RULES = _table()
SELECTED: dict[int, tuple[Callable[..., Any], str]] = {
    id(f): (f, sign)
    for sign, group in (
        ("<", (builtins.min, np.minimum, np.fmin)),
        (">", (builtins.max, np.maximum, np.fmax)),
    )
    for f in group
}
"""Functions that select one of their arguments, with the comparison by which the first one wins."""

FLAT = (int, bool, len, round, math.floor, math.ceil, math.trunc, np.floor, np.ceil, np.trunc, np.rint, np.sign,
        math.isfinite, math.isnan, math.isinf, np.isfinite, np.isnan, np.isinf, np.heaviside, range)  # fmt: skip
"""Functions whose derivative is 0 wherever it exists."""


def rule_of(function: Any) -> Rule | None:
    """Partial derivatives of an elementary function by its arguments, or None if it is none."""
    entry = _RULES.get(id(function))
    return entry[1] if entry is not None else None


def selects(function: Any) -> str | None:
    """'<' for minima, '>' for maxima, else None."""
    entry = SELECTED.get(id(function))
    return entry[1] if entry is not None else None


def is_flat(function: Any) -> bool:
    """Whether the derivative of a function is 0 wherever it exists."""
    return any(function is f for f in FLAT)
