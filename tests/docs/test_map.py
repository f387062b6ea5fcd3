"""The map of the code and the decisions: sizes, form, and files that exist wherever a page or a docstring names one."""

import ast
import io
import re
import tokenize
from pathlib import Path

import pytest
from trees import walk

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
DECISIONS = sorted(page for page in (DOCS / "decisions").glob("*.md") if page.name != "index.md")
PARTS = ("Choice", "Numbers", "Why", "Date", "What would change our mind")

FILE = re.compile(r"(?<![\w./:*-])(?:\.\./)*((?:[\w.-]+/)*[\w-]+\.(?:pyi?|js|css|md|toml))(?![\w*/])")
FOLDER = re.compile(r"`((?:\w+/)+)`")
PLACEHOLDER = re.compile(r"[A-Z]{4,}\.py|out/|dist/")
OF_USERS = {"press.py"}
"""Files of users in the pages, which no folder of the repository holds."""


def places():
    """Files and folders of the repository, relative to its root."""
    found = {path for path in ROOT.iterdir() if path.is_file()}
    for folder in ("flexmb", "docs", "tests", "examples", "meshes", ".github"):
        found |= {ROOT / folder, *(ROOT / folder).rglob("*")}
    return {path.relative_to(ROOT).as_posix() for path in found}


@pytest.fixture(scope="module")
def endings():
    """All endings of the places: engine/step/method.py, step/method.py, method.py."""
    return {"/".join(parts[k:]) for parts in (p.split("/") for p in places()) for k in range(len(parts))}


def missing(text, endings):
    """Files and folders that a text names and the repository does not hold, as (line, name)."""
    for number, line in enumerate(text.splitlines(), 1):
        named = [
            *FILE.findall(line),
            *(name.rstrip("/") for name in FOLDER.findall(line) if not PLACEHOLDER.match(name)),
        ]
        for name in named:
            if name not in endings and name not in OF_USERS and not PLACEHOLDER.search(name):
                yield number, name


def docstrings(tree):
    """Texts that stand alone in a source: docstrings of modules, classes, functions and attributes."""
    for node in walk(tree):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
            yield node.lineno, node.value.value


def test_files_named_by_pages_exist(endings):
    pages = [
        ROOT / "README.md",
        ROOT / "CONTRIBUTING.md",
        *(page for page in sorted(DOCS.rglob("*.md")) if DOCS / "api" not in page.parents),
    ]
    found = [
        f"{page.relative_to(ROOT)}:{line}: {name}"
        for page in pages
        for line, name in missing(page.read_text(encoding="utf-8"), endings)
    ]
    assert not found, "files that do not exist:\n" + "\n".join(found)


def comments(text):
    """Comments of a source in which files may be named."""
    lines = (line.partition("#")[2] for line in text.splitlines())
    if not any(FILE.search(line) or FOLDER.search(line) for line in lines):
        return []
    tokens = tokenize.generate_tokens(io.StringIO(text).readline)
    return [(one.start[0], one.string) for one in tokens if one.type == tokenize.COMMENT]


def test_files_named_by_docstrings_and_comments_exist(package_sources, endings):
    found = [
        f"{source.path}:{begin + line - 1}: {name}"
        for source in package_sources
        for begin, text in (*docstrings(source.tree), *comments(source.text))
        for line, name in missing(text, endings)
    ]
    assert not found, "files that do not exist:\n" + "\n".join(found)


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("see `engine/step/no_such.py`", ["engine/step/no_such.py"]),
        ("see `no_such_room/` and step/method.py", ["no_such_room"]),
        (
            "docs/theory/no_such.md, and [a picture](../examples/no_such.py)",
            ["docs/theory/no_such.md", "examples/no_such.py"],
        ),
        ("`flexmb run press.py` or FILE.py:NAME; results in `out/demo/`", []),
        ("https://example.org/some/page.py", []),
    ],
)
def test_missing_files_are_found(text, names, endings):
    assert [name for _, name in missing(text, endings)] == names


def test_the_map_is_short():
    lines = (DOCS / "design.md").read_text(encoding="utf-8").splitlines()
    assert len(lines) <= 130
    assert max(map(len, lines)) <= 160


@pytest.mark.parametrize("page", DECISIONS, ids=lambda page: page.stem)
def test_a_decision_has_its_parts(page):
    text = page.read_text(encoding="utf-8")
    lines = text.splitlines()
    assert 10 <= len(lines) <= 25
    assert max(map(len, lines)) <= 160
    assert lines[0].startswith(f"# {page.stem[:3]}: ")
    places_of_parts = [text.find(f"**{part}.**") for part in PARTS]
    assert min(places_of_parts) > 0
    assert places_of_parts == sorted(places_of_parts)
    assert re.search(r"\*\*Date\.\*\*\s+20\d\d-\d\d-\d\d", text)


def test_decisions_are_numbered_and_listed():
    assert [page.stem[:3] for page in DECISIONS] == [f"{k:03d}" for k in range(1, len(DECISIONS) + 1)]
    index = (DOCS / "decisions" / "index.md").read_text(encoding="utf-8")
    listed = re.findall(r"^- \[(\d+)\]\(([\w.-]+)\): .+$", index, re.MULTILINE)
    assert listed == [(page.stem[:3], page.name) for page in DECISIONS]
