"""Source of a user's function: syntax tree, names around it, number of results."""

from __future__ import annotations

import ast
import builtins
import inspect
import textwrap
import types
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import PurePath
from typing import Any

from flexmb.errors import KernelError

ABSENT = object()
SCOPES = (ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda, ast.ClassDef)


def text_of(function: Any) -> str | None:
    """Source text of a function as it stands in its file, or None where there is none (typed-in code)."""
    try:
        return inspect.getsource(function)
    except (OSError, TypeError):
        return None


@dataclass(frozen=True)
class Source:
    """A function with the text it was made from."""

    function: types.FunctionType
    text: str

    @cached_property
    def tree(self) -> ast.FunctionDef:
        """Definition of the function; line numbers count in its file."""
        tree = ast.parse(textwrap.dedent(self.text)).body[0]
        if not isinstance(tree, ast.FunctionDef):
            raise KernelError(
                f"{self.function.__qualname__!r} is not written with `def`; its derivatives cannot be found."
            )
        ast.increment_lineno(tree, self.function.__code__.co_firstlineno - 1)
        return tree

    @cached_property
    def parameters(self) -> list[str]:
        """Names of the parameters."""
        return [a.arg for a in self.tree.args.args]

    @cached_property
    def stored(self) -> set[str]:
        """Names to which the function assigns."""
        found = {n.id for n in ast.walk(self.tree) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}
        return found | set(self.parameters)

    def value(self, node: ast.expr) -> Any:
        """Object of a name or of module.name outside the function, or ABSENT."""
        if isinstance(node, ast.Attribute):
            owner = self.value(node.value)
            return getattr(owner, node.attr, ABSENT) if isinstance(owner, types.ModuleType) else ABSENT
        if not isinstance(node, ast.Name) or node.id in self.stored:
            return ABSENT
        cells = inspect.getclosurevars(self.function).nonlocals
        for scope in (cells, self.function.__globals__, vars(builtins)):
            if node.id in scope:
                return scope[node.id]
        return ABSENT

    def error(self, node: ast.AST, what: str) -> KernelError:
        """The error about a place that cannot be differentiated."""
        name, file = self.function.__qualname__, PurePath(self.function.__code__.co_filename).name
        return KernelError(
            f"Kernel {name!r}, {file} line {getattr(node, 'lineno', '?')}: {what}, so the derivatives of the force "
            "cannot be found. Write it another way, or return three numbers: the force and its two derivatives."
        )


def source_of(function: Any) -> Source | None:
    """The source of a plain function, or of the Python function that numba compiled; None for anything else."""
    python = getattr(function, "py_func", function)
    if not isinstance(python, types.FunctionType):
        return None
    text = text_of(python)
    return None if text is None else Source(python, text)


def own_nodes(tree: ast.AST) -> Iterator[ast.AST]:
    """The nodes of a function without the nodes of inner functions."""
    for child in ast.iter_child_nodes(tree):
        if not isinstance(child, SCOPES):
            yield child
            yield from own_nodes(child)


def returns(source: Source) -> list[ast.Return]:
    """The return statements with a value."""
    return [n for n in own_nodes(source.tree) if isinstance(n, ast.Return) and n.value is not None]


def returned_numbers(source: Source, _above: tuple[str, ...] = ()) -> int | None:
    """Number of results of a function: 1 for a number, the length of a tuple, None if unknown.

    Raises
    ------
    KernelError : return statements of different lengths.
    """
    found: dict[int, ast.Return] = {}
    for node in returns(source):
        for size in _sizes(source, node.value, (*_above, source.function.__qualname__)):
            found.setdefault(size, node)
    if len(found) > 1:
        (a, first), (b, second) = sorted(found.items())[:2]
        what = f"{a} number{'s' if a > 1 else ''} returned in line {first.lineno} and {b} in line {second.lineno}"
        raise source.error(second, f"there are {what}")
    return next(iter(found), None)


def _sizes(source: Source, node: ast.expr | None, above: tuple[str, ...]) -> Iterator[int]:
    """Number of results of an expression, for each of its branches."""
    if isinstance(node, ast.Tuple):
        yield len(node.elts)
    elif isinstance(node, ast.IfExp):
        yield from _sizes(source, node.body, above)
        yield from _sizes(source, node.orelse, above)
    elif isinstance(node, ast.Call):
        helper = source_of(source.value(node.func))
        if helper is None:
            yield 1
        elif helper.function.__qualname__ not in above:
            size = returned_numbers(helper, above)
            if size is not None:
                yield size
    elif isinstance(node, ast.Name):
        values = [n.value for n in own_nodes(source.tree) if isinstance(n, ast.Assign) and names(n, node.id)]
        for value in values or [ast.Constant(0.0)]:
            if not (isinstance(value, ast.Name) and value.id == node.id):
                yield from _sizes(source, value, above)
    elif node is not None:
        yield 1


def names(node: ast.Assign, name: str) -> bool:
    """Whether an assignment gives the whole of its value to `name`."""
    return any(isinstance(t, ast.Name) and t.id == name for t in node.targets)
