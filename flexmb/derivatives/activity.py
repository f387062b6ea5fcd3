"""Variables of a function that depend on its active parameters, with the directions of each."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from flexmb.derivatives import rules
from flexmb.derivatives.source import Source, own_nodes

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
        if isinstance(node, ast.Call) and rules.is_flat(self.source.value(node.func)):
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
