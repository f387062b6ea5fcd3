"""Expressions of a law as operations with value and derivatives."""

from __future__ import annotations

import ast
import builtins
import copy
import types
from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np

from flexmb.derivatives import rules
from flexmb.derivatives.activity import Activity, tangent_name
from flexmb.derivatives.source import Source, returned_numbers, source_of

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
        if kind not in rules.OPERATORS:
            raise self.source.error(node, f"the operation {ast.unparse(node)!r} has no derivative that is known")
        exponent = node.right.value if isinstance(node.right, ast.Constant) else None
        left, right = self.operand(node.left), self.operand(node.right)
        value = self.temporary(f"{left[0]} {rules.SYMBOLS[kind]} {right[0]}")
        if kind == "Pow" and exponent == 2:
            return self.chain(value, ("2.0 * x", ""), (left,))
        return self.chain(value, rules.OPERATORS[kind], (left, right))

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
        order = rules.selects(function)
        if order is not None and len(node.args) > 1:
            return self.selected(order, [self.operand(a) for a in node.args])
        rule = rules.rule_of(function)
        if rule is not None and len(rule) == len(node.args):
            operands = [self.operand(a) for a in node.args]
            value = self.temporary(f"{ast.unparse(node.func)}({', '.join(o[0] for o in operands)})")
            return self.chain(value, rule, operands)
        return self.called(node, 1)[0]

    def called(self, node: ast.Call, size: int) -> list[Dual]:
        """A call of another function of the user; that function is transformed, too."""
        helper = source_of(self.source.value(node.func))
        if helper is None or rules.rule_of(helper.function) is not None:
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
        if isinstance(function, types.FunctionType) and rules.rule_of(function) is None and not is_numpy(function):
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
