"""First lines of docstrings are plain English: a noun says what a thing is, and no clause stands in place of a noun."""

import ast
import re
from collections.abc import Iterator

import pytest
from trees import walk

RIDDLES = (
    (re.compile(r"\b(?:what|those|that which|of its own)\b", re.IGNORECASE), "a clause in place of a noun"),
    (re.compile(r"^(?:The same|Where|How|Which|It|Its|They|Of|So|Not|That|Such)\b"), "begins without its noun"),
    (re.compile(r"\b(?:asks? for|asked for|wants?|wanted|says?|said|told|looked at)\b"), "code does not speak"),
    (re.compile(r"\b(?:one another's|none of them|nothing else|anew)\b"), "a word of everyday language"),
    (re.compile(r"\b(?:drawn pose|twin|smoke|grip|habits?|honey|landing)\b"), "a home-made term, see docs/glossary.md"),
)
"""Patterns that no first line of a docstring matches, with the reason."""

Documented = ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef


def first_lines(tree: ast.Module) -> Iterator[tuple[int, str]]:
    """Line number and first docstring line of a module, its classes and functions, private ones included."""
    for node in walk(tree):
        if isinstance(node, Documented):
            text = ast.get_docstring(node)
            if text:
                yield node.body[0].lineno, text.splitlines()[0]


def riddles(path: str, tree: ast.Module) -> Iterator[str]:
    """One text for each first line that matches a pattern."""
    for line, text in first_lines(tree):
        plain = re.sub(r"`[^`]*`|\"[^\"]*\"", "", text)
        for pattern, reason in RIDDLES:
            if pattern.search(plain):
                yield f"{path}:{line}: {reason}: {text}"
                break


def test_first_lines_are_plain(package_sources):
    found = [text for s in package_sources for text in riddles(s.path, s.tree)]
    assert not found, f"{len(found)} first lines:\n" + "\n".join(found)


@pytest.mark.parametrize(
    "line",
    [
        "What a step begins to hold rows with.",
        "Velocities where nothing is asked for.",
        "The same for two columns.",
        "The nodes in the drawn pose.",
        "Largest of those that are held.",
    ],
)
def test_a_riddle_is_found(line):
    assert len(list(riddles("flexmb/some.py", ast.parse(f'def f():\n    """{line}"""')))) == 1


@pytest.mark.parametrize(
    "line", ["Whether a contact is closed.", "Iteration matrix of a step.", 'Text of "what" in quotes.']
)
def test_plain_lines_pass(line):
    assert not list(riddles("flexmb/some.py", ast.parse(f"def f():\n    '''{line}'''")))
