"""Expressions of a law as operations with value and derivatives.

x, y: the arguments; f: the value.  A rule gives one formula an argument, the partial derivative by it; at a pole (sqrt
at 0) the formula gives 0, which keeps laws finite at the onset of a contact.  The formulas are read in a name space
with `_math` and `_np`.
"""

from __future__ import annotations

import ast
import builtins
import copy
import math
import types
from collections.abc import Callable, Iterator, Sequence
from typing import Any, Protocol

import numpy as np

from flexmb.engine.derivatives.source import Source, own_nodes, returned_numbers, source_of

# Derivatives of the elementary functions, as formulas in Python

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


# Variables of a function that depend on its active parameters, with the directions of each

NOTHING: frozenset[int] = frozenset()
HISTORY = "z_new"


def tangent_name(name: str, direction: int) -> str:
    """The variable that carries the derivative of `name` by active parameter number `direction`."""
    return f"{name}__d{direction}"


class Activity:
    """Variables of a function that depend on active parameters, regardless of the order of its statements.

    Parameters
    ----------
    source : the function.
    seeds : directions in which each of its parameters is active.
    """

    def __init__(self, source: Source, seeds: tuple[frozenset[int], ...]) -> None:
        self.source = source
        if len(seeds) != len(source.parameters):
            raise source.error(
                source.tree, f"it is called with {len(seeds)} arguments and has {len(source.parameters)}"
            )
        self.known: dict[str, frozenset[int]] = dict(zip(source.parameters, seeds, strict=True))
        self.outputs = written_parameters(source)
        while self._grow():
            pass

    def of(self, name: str) -> frozenset[int]:
        """Directions of a variable."""
        return self.known.get(name, NOTHING)

    def directions(self, node: ast.AST) -> frozenset[int]:
        """Directions of an expression; conditions and step functions have none, `x and y` has both."""
        if isinstance(node, ast.Compare | ast.Constant) or (
            isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not)
        ):
            return NOTHING
        if isinstance(node, ast.Name):
            return self.of(node.id)
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.FloorDiv):
            return NOTHING
        if isinstance(node, ast.IfExp):
            return self.directions(node.body) | self.directions(node.orelse)
        if isinstance(node, ast.Call) and is_flat(self.source.value(node.func)):
            return NOTHING
        children = list(ast.iter_child_nodes(node))
        if isinstance(node, ast.Call):
            children = [*node.args, *node.keywords]
        return NOTHING.union(*(self.directions(child) for child in children))

    def refuse_reading(self, node: ast.AST) -> None:
        """Refuse an expression that reads an entry of the history which the function has written.

        The derivative of such an entry is not kept.  A variable that `:=` sets inside an expression is refused, too.
        """
        for child in ast.walk(node):
            if isinstance(child, ast.NamedExpr) and self.directions(child.value):
                what = f"{ast.unparse(child)!r} stands inside an expression; give the variable a line of its own"
                raise self.source.error(child, what)
            reads = isinstance(child, ast.Subscript) and ast.unparse(child.value) in self.outputs
            if reads:
                what = f"{ast.unparse(child)!r} is read after it was written; keep the number in a variable"
                raise self.source.error(child, what)

    def check_arguments(self, node: ast.Call, helper: Source) -> None:
        """Refuse a call with another number of arguments than the function takes."""
        if len(node.args) != len(helper.parameters) or node.keywords:
            name = helper.function.__qualname__
            raise self.source.error(node, f"{name!r} is called with other arguments than its {len(helper.parameters)}")

    def _grow(self) -> bool:
        """One pass over the assignments: whether a further variable became active."""
        before = dict(self.known)
        for targets, value in assignments(self.source):
            found = [self.directions(value)] * len(targets)
            if isinstance(value, ast.Tuple | ast.List) and len(value.elts) == len(targets) > 1:
                found = [self.directions(element) for element in value.elts]
            for name, more in zip(targets, found, strict=True):
                if name is not None and more:
                    self.known[name] = self.of(name) | more
        return before != self.known


def assignments(source: Source) -> Iterator[tuple[list[str | None], ast.expr]]:
    """(names, value) of every assignment; None for a target that is no name."""
    for node in own_nodes(source.tree):
        if isinstance(node, ast.Assign):
            for target in node.targets:
                places = target.elts if isinstance(target, ast.Tuple | ast.List) else [target]
                yield [p.id if isinstance(p, ast.Name) else None for p in places], node.value
        elif isinstance(node, ast.AnnAssign | ast.AugAssign) and node.value is not None:
            yield [node.target.id if isinstance(node.target, ast.Name) else None], node.value


def written_parameters(source: Source) -> set[str]:
    """Parameters into which the function writes, and always the history."""
    found = {HISTORY} & set(source.parameters)
    for node in own_nodes(source.tree):
        if isinstance(node, ast.Subscript) and isinstance(node.ctx, ast.Store) and isinstance(node.value, ast.Name):
            found.add(node.value.id)
    return found & set(source.parameters)


# Expressions of a law as operations with value and derivatives

Tangents = tuple[str | None, ...]
Dual = tuple[str, Tangents]
Seeds = tuple[frozenset[int], ...]


class Helpers(Protocol):
    """Maker of versions of the functions that a law calls."""

    directions: int

    def helper(self, source: Source, seeds: Seeds) -> str:
        """Name of the version of a function for the active parameters in `seeds`."""


class Expressions:
    """Value and derivatives of expressions, as text; their operations are emitted to `block`.

    Parameters
    ----------
    source : the function of the expressions.
    seeds : directions in which each of its parameters is active.
    family : maker of versions of the functions that `source` calls.
    """

    def __init__(self, source: Source, seeds: Seeds, family: Helpers) -> None:
        self.source, self.seeds, self.family = source, seeds, family
        self.activity = Activity(source, seeds)
        self.block: list[ast.stmt] = []
        self.count = 0
        self.here: ast.AST = source.tree

    def dual(self, node: ast.expr) -> Dual:
        """Value and derivatives of an expression, whose operations are emitted."""
        active = self.activity.directions(node)
        if not active:
            return self.primal(node), (None,) * self.family.directions
        if isinstance(node, ast.Name):
            mine = self.activity.of(node.id)
            return node.id, tuple(tangent_name(node.id, k) if k in mine else None for k in self.range())
        if isinstance(node, ast.UnaryOp):
            value, tangents = self.dual(node.operand)
            sign = "-" if isinstance(node.op, ast.USub) else "+"
            return self.temporary(f"{sign}{value}"), tuple(t and f"({sign}{t})" for t in tangents)
        if isinstance(node, ast.BinOp):
            return self.operation(node)
        if isinstance(node, ast.IfExp):
            return self.choice(node, active)
        if isinstance(node, ast.Call):
            return self.call(node)
        raise self.source.error(node, f"{ast.unparse(node)!r} has no derivative that is known")

    def operation(self, node: ast.BinOp) -> Dual:
        """left op right."""
        kind = type(node.op).__name__
        if kind not in OPERATORS:
            raise self.source.error(node, f"the operation {ast.unparse(node)!r} has no derivative that is known")
        exponent = node.right.value if isinstance(node.right, ast.Constant) else None
        left, right = self.operand(node.left), self.operand(node.right)
        value = self.temporary(f"{left[0]} {SYMBOLS[kind]} {right[0]}")
        if kind == "Pow" and exponent == 2:
            return self.chain(value, ("2.0 * x", ""), (left,))
        return self.chain(value, OPERATORS[kind], (left, right))

    def call(self, node: ast.Call) -> Dual:
        """A call whose value is a number."""
        function = self.source.value(node.func)
        if node.keywords or any(isinstance(a, ast.Starred) for a in node.args):
            raise self.source.error(node, f"{ast.unparse(node.func)} is called with keywords or stars")
        if function is np.where and len(node.args) == 3:
            test, *both = node.args
            return self.choice(self.at(ast.IfExp(test, *both), node), self.activity.directions(node))
        if function is np.clip and len(node.args) == 3:
            x, low, high = (self.operand(a) for a in node.args)
            return self.selected("<", [self.selected(">", [x, low]), high])
        order = selects(function)
        if order is not None and len(node.args) > 1:
            return self.selected(order, [self.operand(a) for a in node.args])
        rule = rule_of(function)
        if rule is not None and len(rule) == len(node.args):
            operands = [self.operand(a) for a in node.args]
            value = self.temporary(f"{ast.unparse(node.func)}({', '.join(o[0] for o in operands)})")
            return self.chain(value, rule, operands)
        return self.called(node, 1)[0]

    def called(self, node: ast.Call, size: int) -> list[Dual]:
        """A call of another function of the user; that function is transformed, too."""
        helper = source_of(self.source.value(node.func))
        if helper is None or rule_of(helper.function) is not None:
            raise self.source.error(
                node, f"the function {ast.unparse(node.func)!r} is not known, or its text cannot be read"
            )
        found = returned_numbers(helper) or 1
        if found != size:
            what = f"{ast.unparse(node.func)!r} returns {found} number{'s' if found > 1 else ''}, not {size}"
            raise self.source.error(node, what)
        self.activity.check_arguments(node, helper)
        operands = [self.dual(a) for a in node.args]
        seeds = tuple(frozenset(k for k in self.range() if tangents[k]) for _, tangents in operands)
        given = [part for value, tangents in operands for part in (value, *(t for t in tangents if t))]
        name = self.family.helper(helper, seeds)
        width = 1 + self.family.directions
        targets = [f"t__{self.count + k}" for k in range(size * width)]
        self.count += len(targets)
        self.emit(f"{', '.join(targets)} = {name}({', '.join(given)})")
        depends = frozenset().union(*seeds)  # a result depends on nothing else
        return [
            (targets[i], tuple(targets[i + 1 + k] if k in depends else None for k in self.range()))
            for i in range(0, len(targets), width)
        ]

    def choice(self, node: ast.IfExp, active: frozenset[int]) -> Dual:
        """body if test else orelse; only the branch taken is computed."""
        target, self.count = f"t__{self.count}", self.count + 1
        tangents = tuple(f"{target}_{k}" if k in active else None for k in self.range())
        outer, branches = self.block, []
        for branch in (node.body, node.orelse):
            self.block = []
            value, found = self.dual(branch)
            self.emit(f"{target} = {value}")
            for name, tangent in zip(tangents, found, strict=True):
                if name:
                    self.emit(f"{name} = {tangent or '0.0'}")
            branches.append(self.block)
        self.block = outer
        test = ast.parse(self.primal(node.test), mode="eval").body
        self.block.append(self.at(ast.If(test, *branches), self.here))
        return target, tangents

    def selected(self, order: str, operands: Sequence[Dual]) -> Dual:
        """The smallest or largest of some numbers."""
        best = operands[0]
        for other in operands[1:]:
            test = f"{best[0]} {order}= {other[0]}"
            value = self.temporary(f"{best[0]} if {test} else {other[0]}")
            pairs = zip(best[1], other[1], strict=True)
            tangents = tuple(
                self.temporary(f"{a or '0.0'} if {test} else {b or '0.0'}") if a or b else None for a, b in pairs
            )
            best = value, tangents
        return best

    def chain(self, value: str, rule: Sequence[str], operands: Sequence[Dual]) -> Dual:
        """The chain rule: sums of partial derivative times derivative of the operand."""
        names = {"f": value, **{name: o[0] for name, o in zip("xy", operands, strict=False)}}
        terms: list[list[str]] = [[] for _ in self.range()]
        for formula, (_, tangents) in zip(rule, operands, strict=False):
            if not any(tangents) or formula == "0.0":
                continue
            partial = formula if formula in ("1", "-1") else self.temporary(renamed(formula, names))
            for k, t in enumerate(tangents):
                if t:
                    terms[k].append({"1": t, "-1": f"(-{t})"}.get(partial, f"{partial} * {t}"))
        return value, tuple(self.temporary(" + ".join(t)) if t else None for t in terms)

    def operand(self, node: ast.expr) -> Dual:
        """An expression whose value is used more than once: a name or a constant."""
        value, tangents = self.dual(node)
        return value if value.isidentifier() or isinstance(node, ast.Constant) else self.temporary(value), tangents

    def primal(self, node: ast.expr) -> str:
        """The expression without derivatives; other functions of the user are called in a version of this law."""
        self.activity.refuse_reading(node)
        return ast.unparse(Calls(self).visit(copy.deepcopy(node)))

    # -- text --------------------------------------------------------------------------------------------------------

    def range(self) -> range:
        """The directions."""
        return builtins.range(self.family.directions)

    def temporary(self, text: str) -> str:
        """A new variable with the value of `text`."""
        name = f"t__{self.count}"
        self.count += 1
        self.emit(f"{name} = {text}")
        return name

    def emit(self, text: str) -> None:
        """Append a statement; it stands in the line that is being transformed."""
        self.block.append(self.at(ast.parse(text).body[0], self.here))

    @staticmethod
    def at(node: Any, place: ast.AST) -> Any:
        """`node` with the position of `place`, its new parts included."""
        line, column = getattr(place, "lineno", 1), getattr(place, "col_offset", 0)
        stack = [node]
        while stack:
            one = stack.pop()
            if "lineno" in one._attributes:
                one.lineno = one.end_lineno = line
                one.col_offset = one.end_col_offset = column
            stack += [c for c in ast.iter_child_nodes(one) if not (isinstance(c, ast.stmt) and c is not node)]
        return node


class Calls(ast.NodeTransformer):
    """Calls of plain Python functions become calls of compiled versions without derivatives."""

    def __init__(self, owner: Expressions) -> None:
        self.owner = owner

    def visit_Call(self, node: ast.Call) -> ast.AST:
        """One call."""
        self.generic_visit(node)
        function = self.owner.source.value(node.func)
        if isinstance(function, types.FunctionType) and rule_of(function) is None and not is_numpy(function):
            helper = source_of(function)
            if helper is None:
                raise self.owner.source.error(node, f"the text of {ast.unparse(node.func)!r} cannot be read")
            name = self.owner.family.helper(helper, (frozenset(),) * len(helper.parameters))
            node.func = ast.Name(name, ast.Load())
        return node


def is_numpy(function: Any) -> bool:
    """Whether a function is numpy's, which numba knows."""
    return str(getattr(function, "__module__", "")).split(".")[0] == "numpy"


def renamed(formula: str, names: dict[str, str]) -> str:
    """A formula with its letters replaced."""
    tree = ast.parse(formula, mode="eval")
    for node in ast.walk(tree):
        if isinstance(node, ast.Name) and node.id in names:
            node.id = names[node.id]
    return ast.unparse(tree)
