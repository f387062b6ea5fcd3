"""No door behind the parts names a class of a part or of a law: parts answer for themselves."""

import ast
from collections.abc import Iterator

import pytest
from trees import walk

HOMES = ("flexmb/parts/", "flexmb/elastic/", "flexmb/mechanisms/")
"""Folders that define parts, and may name them."""

DOORS = ("findings", "results", "run", "statics", "show", "engine", "program")
"""Folders that know parts by the bases of `flexmb.model` alone."""

BASES = {
    *("Part", "Body", "ElasticBody", "Joint", "Element", "Controller"),
    *("Law", "NormalLaw", "FrictionLaw", "Motion"),
}
"""Bases of `flexmb.model`, which every door may name."""

EXCEPTIONS = {
    "flexmb/statics/buckling.py": {
        "FlexibleBody": "the stiffness of half of the load is that of the elements of beams",
        "Reduced": "loads of reduced bodies stiffen through their own matrices",
    },
}
"""Classes that a file of these doors names, each with its reason."""


def known_parts(sources) -> set[str]:
    """Names of all classes in the homes that derive, over any number of classes, from one of the bases."""
    classes = [
        (node.name, {ast.unparse(base).split("[")[0] for base in node.bases})
        for source in sources
        if source.path.startswith(HOMES)
        for node in walk(source.tree)
        if isinstance(node, ast.ClassDef)
    ]
    found: set[str] = set()
    while True:
        more = {name for name, bases in classes if bases & (BASES | found)} - found
        if not more:
            return found
        found |= more


def named(tree: ast.Module, parts: set[str]) -> Iterator[tuple[int, str]]:
    """Line and class of each import of a part, each `isinstance` of one, and each question for a loaded module."""
    for node in walk(tree):
        if isinstance(node, ast.ImportFrom) and f"{(node.module or '').replace('.', '/')}/".startswith(HOMES):
            yield from ((node.lineno, alias.name) for alias in node.names if alias.name in parts)
        elif isinstance(node, ast.Call) and ast.unparse(node.func) in ("isinstance", "issubclass"):
            words = {child.attr if isinstance(child, ast.Attribute) else getattr(child, "id", "")
                     for child in walk(node.args[1])}  # fmt: skip
            yield from ((node.lineno, word) for word in sorted(words & parts))
        elif isinstance(node, ast.Attribute) and ast.unparse(node) == "sys.modules":
            yield node.lineno, "sys.modules"


def in_doors(path: str) -> bool:
    return path.split("/")[1] in DOORS


def test_no_door_names_a_part(package_sources):
    parts = known_parts(package_sources)
    assert {"FlexibleLink", "Stop", "Gear", "Drive", "Reduced", "Table", "HysteresisLaw"} <= parts
    found = [
        f"{source.path}:{line}: names {name}; let the part answer (`findings_before`, `findings_after`, ...)"
        for source in package_sources
        if in_doors(source.path)
        for line, name in named(source.tree, parts)
        if name not in EXCEPTIONS.get(source.path, {}) and not is_cache(source.path, name)
    ]
    assert not found, "\n".join(found)


def is_cache(path: str, name: str) -> bool:
    """Whether a file of the compiler of functions looks up modules, of which parts are none."""
    return path.startswith("flexmb/engine/compiled/") and name == "sys.modules"


def test_exceptions_are_needed(package_sources):
    parts = known_parts(package_sources)
    for source in package_sources:
        if source.path in EXCEPTIONS:
            assert EXCEPTIONS[source.path].keys() == {name for _, name in named(source.tree, parts)}


@pytest.mark.parametrize(
    ("code", "names"),
    [
        ("from flexmb.parts.joints.stop import Stop", ["Stop"]),
        ("def f():\n    from flexmb.elastic.reduced.reduced import Reduced", ["Reduced"]),
        ("isinstance(part, Body | flexmb.Stop)", ["Stop"]),
        ("module = sys.modules.get('flexmb.elastic.reduced.reduced')", ["sys.modules"]),
        ("from flexmb.model.part import Joint\nisinstance(part, Joint)", []),
        ("from flexmb.parts.bodies.flexible import number_of", []),
    ],
)
def test_what_is_found(code, names):
    assert [name for _, name in named(ast.parse(code), {"Stop", "Reduced"})] == names
