"""Nodes of syntax trees, found once for all tests of the source."""

import ast
from functools import cache


@cache
def walk(top: ast.AST) -> tuple[ast.AST, ...]:
    """Nodes of `ast.walk` in its order, but for the contexts Load, Store and Del of names."""
    found = [top]
    for node in found:  # grows meanwhile
        for field in node._fields:
            value = None if field == "ctx" else getattr(node, field, None)
            if isinstance(value, ast.AST):
                found.append(value)
            elif isinstance(value, list):
                found += [child for child in value if isinstance(child, ast.AST)]
    return tuple(found)
