"""Forward differentiation of Python functions: from the text of a law to one that carries its derivatives along.

Every variable x that depends on an active parameter gets companions x__d0, x__d1: its derivatives by the first and the
second one.  Each operation of an expression gets a temporary variable.  Conditions and loops stay as they are, so the
derivative is that of the branch taken.  Statements that write the history stay as they are.
The new function keeps file and lines of the old one: tracebacks and numba's messages point at the user's text, and
numba's cache lies beside the user's file.
"""

from __future__ import annotations

import ast
import copy
import math
import types
from collections.abc import Sequence
from typing import Any

import numba
import numpy as np

from flexmb.engine.derivatives.expressions import Dual, Expressions, Seeds, tangent_name
from flexmb.engine.derivatives.source import Source, returned_numbers

STATEMENTS = (ast.Pass, ast.Break, ast.Continue)


class Family:
    """The functions made for one law: itself, and a version of each function it calls for each pattern of activity."""

    def __init__(self, directions: int) -> None:
        self.directions = directions
        self.space: dict[str, Any] = {"_math": math, "_np": np}
        self.made: dict[tuple[int, Seeds], str] = {}
        self.open: list[int] = []
        self.cacheable = True

    def helper(self, source: Source, seeds: Seeds) -> str:
        """Name of the version of a called function for the active parameters in `seeds`."""
        key = (id(source.function), seeds)
        if id(source.function) in self.open:
            raise source.error(source.tree, "it calls itself")
        if key not in self.made:
            self.open.append(id(source.function))
            name = f"_{source.function.__name__}_{len(self.made)}"
            self.made[key] = name
            function = build(source, seeds, self, name)
            self.cacheable &= not source.function.__closure__
            self.space[name] = numba.njit(function, error_model="numpy", forceinline=True, _nrt=False)
            self.open.pop()
        return self.made[key]


def differentiated(source: Source, active: Sequence[str]) -> tuple[types.FunctionType, bool]:
    """The function that returns force and derivatives by `active`, and whether its machine code may lie on disk.

    Parameters
    ----------
    source : a function that returns one number.
    active : names of the contract's parameters by which it is differentiated, as the function calls them.

    Raises
    ------
    KernelError : a part of the function without a known derivative; the message names function and line.
    """
    family = Family(len(active))
    seeds = tuple(frozenset(k for k, name in enumerate(active) if name == p) for p in source.parameters)
    family.open.append(id(source.function))
    return build(source, seeds, family, source.function.__name__, top=True), family.cacheable


def build(source: Source, seeds: Seeds, family: Family, name: str, *, top: bool = False) -> types.FunctionType:
    """The compiled (by Python) version of one function; `top` is the law itself, whose seeds are 1."""
    tree = Transformer(source, seeds, family, top=top).function(name)
    free = source.function.__code__.co_freevars
    outer = ast.parse(f"def _outer({', '.join(free)}):\n    pass\n    return {name}")
    outer.body[0].body[0] = tree  # type: ignore[attr-defined]
    space = {**source.function.__globals__, **family.space}
    exec(compile(ast.fix_missing_locations(outer), source.function.__code__.co_filename, "exec"), space)
    cells = [c.cell_contents for c in source.function.__closure__ or ()]
    function: types.FunctionType = space["_outer"](*cells)
    function.__qualname__ = f"{source.function.__qualname__}.derivatives" if top else name
    function.__module__ = source.function.__module__
    function.__doc__ = source.function.__doc__
    return function


class Transformer(Expressions):
    """One function on its way from the value alone to value and derivatives."""

    def __init__(self, source: Source, seeds: Seeds, family: Family, *, top: bool) -> None:
        super().__init__(source, seeds, family)
        self.top = top

    def function(self, name: str) -> ast.FunctionDef:
        """The new definition."""
        old = self.source.tree
        if old.args.vararg or old.args.kwarg or old.args.kwonlyargs or old.args.defaults or old.args.posonlyargs:
            raise self.source.error(old, "it has parameters with defaults, stars or keywords")
        parameters = []
        for parameter, active in zip(self.source.parameters, self.seeds, strict=True):
            parameters.append(parameter)
            if not self.top:
                parameters += [tangent_name(parameter, k) for k in sorted(active)]
        new = ast.parse(f"def {name}({', '.join(parameters)}):\n    pass").body[0]
        new.body = self.begin() + self.statements(old.body)  # type: ignore[attr-defined]
        for node in ast.walk(new):
            if "lineno" in getattr(node, "_attributes", ()) and getattr(node, "lineno", 0) < old.lineno:
                node.lineno = node.end_lineno = old.lineno  # type: ignore[attr-defined]
        return new  # type: ignore[return-value]

    def begin(self) -> list[ast.stmt]:
        """Start values of the derivatives: 1 for the seeds of the law, 0 for parameters that become active later."""
        self.block = []
        for name, given in zip(self.source.parameters, self.seeds, strict=True):
            for k in sorted(self.activity.of(name)):
                if self.top or k not in given:
                    self.emit(f"{tangent_name(name, k)} = {1.0 if k in given else 0.0}")
        return self.block

    def statements(self, body: Sequence[ast.stmt]) -> list[ast.stmt]:
        """A block of statements, transformed."""
        outer, self.block = self.block, []
        for statement in body:
            self.here = statement
            self.statement(statement)
        self.block, done = outer, self.block
        return done or [ast.Pass()]

    def statement(self, node: ast.stmt) -> None:
        """One statement."""
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            return  # the docstring
        if isinstance(node, STATEMENTS):
            self.block.append(node)
        elif isinstance(node, ast.Expr):
            self.emit(self.primal(node.value))
        elif isinstance(node, ast.Assign):
            self.assign(node.targets, node.value)
        elif isinstance(node, ast.AnnAssign) and node.value is not None:
            self.assign([node.target], node.value)
        elif isinstance(node, ast.AugAssign):
            self.activity.refuse_reading(node.target)
            read = ast.parse(ast.unparse(node.target), mode="eval").body
            self.assign([node.target], self.at(ast.BinOp(read, node.op, node.value), node))
        elif isinstance(node, ast.Return):
            self.emit(f"return {self.returned(node)}")
        elif isinstance(node, ast.If | ast.While | ast.For):
            self.compound(node)
        else:
            raise self.source.error(node, f"a statement of the kind {type(node).__name__!r} is not known")

    def compound(self, node: ast.If | ast.While | ast.For) -> None:
        """A condition or a loop: its head as it is, its blocks transformed."""
        head = copy.deepcopy(node)
        if isinstance(node, ast.For):
            if self.activity.directions(node.iter):
                raise self.source.error(node, "a loop runs over numbers that depend on the motion")
            head.iter = ast.parse(self.primal(node.iter), mode="eval").body  # type: ignore[union-attr]
        else:
            head.test = ast.parse(self.primal(node.test), mode="eval").body  # type: ignore[union-attr]
        head.body = self.statements(node.body)
        head.orelse = self.statements(node.orelse) if node.orelse else []
        self.here = node
        self.block.append(self.at(head, node))

    def assign(self, targets: Sequence[ast.expr], value: ast.expr) -> None:
        """target = value, for each target."""
        parts = self.parts(value, targets[0])
        for target in targets:
            places = target.elts if isinstance(target, ast.Tuple | ast.List) else [target]
            if isinstance(target, ast.Tuple | ast.List) and parts is None:
                self.forget(places)
                self.emit(f"{ast.unparse(target)} = {self.primal(value)}")
                continue
            for place, dual in zip(places, parts or [self.dual(value)], strict=True):
                self.store(place, dual)

    def parts(self, value: ast.expr, target: ast.expr) -> list[Dual] | None:
        """Values for the elements of a tuple; None if the target is no tuple or the value is inactive."""
        if not isinstance(target, ast.Tuple | ast.List):
            return None
        if not self.activity.directions(value):
            return None
        if isinstance(value, ast.Tuple | ast.List) and len(value.elts) == len(target.elts):
            return [self.kept(self.dual(element)) for element in value.elts]
        if isinstance(value, ast.Call):
            return self.called(value, len(target.elts))
        raise self.source.error(value, "a tuple that depends on the motion is unpacked from something else than a call")

    def forget(self, places: Sequence[ast.expr]) -> None:
        """Set the derivatives of variables to 0 that get numbers without derivatives."""
        for place in places:
            if isinstance(place, ast.Name):
                for k in sorted(self.activity.of(place.id)):
                    self.emit(f"{tangent_name(place.id, k)} = 0.0")

    def kept(self, dual: Dual) -> Dual:
        """A copy in temporaries, so that a, b = b, a exchanges."""
        return self.temporary(dual[0]), tuple(t and self.temporary(t) for t in dual[1])

    def store(self, target: ast.expr, dual: Dual) -> None:
        """target = dual."""
        value, tangents = dual
        if isinstance(target, ast.Name):
            active = sorted(self.activity.of(target.id))
            for k in active:
                self.emit(f"{tangent_name(target.id, k)} = {tangents[k] or '0.0'}")
            self.emit(f"{target.id} = {value}")
        elif isinstance(target, ast.Subscript):
            if any(tangents) and ast.unparse(target.value) not in self.activity.outputs:
                raise self.source.error(
                    target, f"a number that depends on the motion is put into {ast.unparse(target)}"
                )
            self.emit(f"{self.primal(target.value)}[{self.primal(target.slice)}] = {value}")
        else:
            raise self.source.error(target, f"an assignment to {ast.unparse(target)} is not known")

    def returned(self, node: ast.Return) -> str:
        """Text of a return statement: value and tangents of each number."""
        if node.value is None:
            raise self.source.error(node, "nothing is returned here")
        elements = node.value.elts if isinstance(node.value, ast.Tuple) else [node.value]
        if not isinstance(node.value, ast.Tuple) and (returned_numbers(self.source) or 1) > 1:
            if not isinstance(node.value, ast.Call):
                raise self.source.error(node, "a tuple is returned by its name; return its elements")
            duals = self.called(node.value, returned_numbers(self.source) or 1)
        else:
            duals = [self.dual(element) for element in elements]
        plain = not self.top and not any(self.seeds)
        flat = [
            part
            for value, tangents in duals
            for part in ((value,) if plain else (value, *(t or "0.0" for t in tangents)))
        ]
        return ", ".join(f"1.0 * ({part})" if self.top else part for part in flat)
