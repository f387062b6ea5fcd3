"""Compiled functions name fields that their records have: numba would say so only when the function is compiled."""

import ast
import typing
from collections.abc import Iterator
from functools import cache

import pytest
from nine_bar_study.nine_bar.staggered.elastic import Elastic
from trees import walk

from flexmb.engine.compiled.records import Record
from flexmb.engine.dormand_prince.step import Stages as DormandPrinceStages
from flexmb.engine.radau.collocation import Collocation
from flexmb.engine.sensitivity.linearise import Tangents
from flexmb.engine.state.flow import Flow, Trial
from flexmb.engine.state.record import Options, RunRecord
from flexmb.engine.step.runge_kutta import Stages
from flexmb.engine.system.work import Work
from flexmb.program.program import Addresses, Tables

ARGUMENTS = {
    "tables": Tables, "address": Addresses, "options": Options, "flow": Flow, "trial": Trial, "work": Work,
    "record": RunRecord, "R": Collocation, "D": DormandPrinceStages,
    "T": Tangents, "stages": Stages, "el": Elastic,
}  # fmt: skip
"""Records that compiled functions take, by the names of their arguments."""

COMPILERS = ("compiled", "fast", "summing", "apart")

Known = dict[str, type | None]

hints_of = cache(typing.get_type_hints)


def is_compiled(node: ast.AST) -> bool:
    return isinstance(node, ast.FunctionDef) and any(
        name in ast.unparse(decorator) for decorator in node.decorator_list for name in COMPILERS
    )


def kind_of(node: ast.expr, known: Known, unknown: list[str]) -> type | None:
    """Record that an expression stands for; what names a field that is not there is added to `unknown`."""
    if isinstance(node, ast.Name):
        return known.get(node.id)
    base = kind_of(node.value, known, unknown) if isinstance(node, ast.Attribute) else None
    if base is None:
        return None
    if node.attr not in base._fields:
        unknown.append(f"{node.lineno}: {ast.unparse(node)}: {base.__name__} has no field {node.attr!r}")
        return None
    hint = hints_of(base)[node.attr]
    return hint if isinstance(hint, type) and issubclass(hint, Record) else None


def assigned(function: ast.FunctionDef) -> Iterator[tuple[ast.expr, ast.expr]]:
    """Targets and values of assignments, those of tuples one by one."""
    for node in walk(function):
        for target in node.targets if isinstance(node, ast.Assign) else ():
            if isinstance(target, ast.Tuple) and isinstance(node.value, ast.Tuple):
                yield from zip(target.elts, node.value.elts, strict=True)
            else:
                yield target, node.value


def unknown_fields(tree: ast.AST) -> list[str]:
    found: list[str] = []
    for function in filter(is_compiled, walk(tree)):
        known: Known = {a.arg: ARGUMENTS[a.arg] for a in function.args.args if a.arg in ARGUMENTS}
        for target, value in assigned(function):
            if isinstance(target, ast.Name):
                known[target.id] = kind_of(value, known, [])
        for node in walk(function):
            if isinstance(node, ast.Attribute):
                kind_of(node, known, found)
    return sorted(set(found))


def test_every_field_is_there(package_sources):
    found = [f"{source.path}:{text}" for source in package_sources for text in unknown_fields(source.tree)]
    assert not found, "\n".join(found)


@pytest.mark.parametrize(
    ("code", "field"),
    [
        ("flow.clock.hour = 1.0", "hour"),
        ("x = trial.rhs[0] + trial.speed", "speed"),
        ("step = record.report\n    step.wanted = 1.0", "wanted"),
        ("W, Q = R.works, R.Q\n    W.brought += 1.0", "brought"),
    ],
)
def test_others_are_found(code, field):
    tree = ast.parse(f"@compiled\ndef f(flow, trial, record, R):\n    {code}\n")
    (text,) = unknown_fields(tree)
    assert f"has no field {field!r}" in text


def test_python_functions_are_left_alone():
    assert unknown_fields(ast.parse("def f(flow):\n    return flow.hour\n")) == []
