"""Counted house rules: short files, short functions, no leftovers, nothing caught or shared by accident."""

import ast
import re
from collections.abc import Iterator

import pytest
from trees import walk

LONGEST_FILE = 700
LONG_FUNCTION = 35
SHARE_OF_LONG_FUNCTIONS = 0.10

LEFTOVER = re.compile(r"\b(TODO|FIXME|XXX|HACK)\b")

HASATTR_ALLOWED: dict[str, str] = {}
"""File -> why it must ask an object for an attribute by name."""

ASSERT_ALLOWED: dict[str, str] = {}

MUTABLE_LITERALS = (ast.List, ast.Dict, ast.Set, ast.ListComp, ast.DictComp, ast.SetComp)
MUTABLE_CALLS = {"list", "dict", "set", "bytearray", "defaultdict", "deque", "array", "zeros", "ones", "empty", "full"}

Function = ast.FunctionDef | ast.AsyncFunctionDef


def functions(tree: ast.Module) -> Iterator[Function]:
    """Every function and method, the nested ones included."""
    return (node for node in walk(tree) if isinstance(node, Function))


def body_length(function: Function) -> int:
    """Lines of the body, from its first statement after the docstring to its end."""
    body = function.body[1:] if ast.get_docstring(function, clean=False) is not None else function.body
    return body[-1].end_lineno - body[0].lineno + 1 if body else 0


COMPILED = re.compile(r"kernel|compiled|intrinsic|_law$|^(?:fast|summing|apart)$")
"""Decorators of functions that numba types."""


def is_untyped(function: Function) -> bool:
    """Whether a parameter or the result has no annotation."""
    arguments = (*function.args.args, *function.args.kwonlyargs)
    return function.returns is None or any(a.annotation is None for a in arguments if a.arg not in ("self", "cls"))


def untyped_functions(path: str, tree: ast.Module) -> Iterator[str]:
    """Functions without annotations that are not compiled and do not make code (`codegen` of an intrinsic)."""
    for function in functions(tree):
        compiled = any(COMPILED.search(ast.unparse(one).split("(")[0]) for one in function.decorator_list)
        if not compiled and function.name != "codegen" and is_untyped(function):
            yield f"{path}:{function.lineno}: {function.name} has parameters or a result without a type."


def called_name(node: ast.Call) -> str:
    """The last name of what is called: 'zeros' for np.zeros(3)."""
    return getattr(node.func, "attr", getattr(node.func, "id", ""))


def is_mutable(default: ast.expr) -> bool:
    """Whether a default argument is an object that a call could change."""
    return isinstance(default, MUTABLE_LITERALS) or (
        isinstance(default, ast.Call) and called_name(default) in MUTABLE_CALLS
    )


def catches_everything(node: ast.AST) -> bool:
    """Whether this is `except:`, `except Exception` or `except BaseException`, alone or in a tuple."""
    if not isinstance(node, ast.ExceptHandler):
        return False
    kinds = node.type.elts if isinstance(node.type, ast.Tuple) else [node.type]
    return any(kind is None or getattr(kind, "id", "") in {"Exception", "BaseException"} for kind in kinds)


def defects(path: str, tree: ast.Module) -> Iterator[str]:
    """One line for each construct that the house does not use."""
    for node in walk(tree):
        if catches_everything(node):
            yield f"{path}:{node.lineno}: catches everything; name the exceptions that can be dealt with"
        elif isinstance(node, ast.Call) and called_name(node) == "hasattr" and path not in HASATTR_ALLOWED:
            yield f"{path}:{node.lineno}: hasattr; check required names when the class is made"
        elif isinstance(node, ast.Assert) and path not in ASSERT_ALLOWED:
            yield f"{path}:{node.lineno}: assert vanishes under -O; raise a FlexmbError"
        elif isinstance(node, Function | ast.Lambda):
            defaults = [*node.args.defaults, *(d for d in node.args.kw_defaults if d is not None)]
            for default in filter(is_mutable, defaults):
                yield f"{path}:{default.lineno}: mutable default argument; use None or a tuple"


def test_no_file_is_too_long(package_sources):
    lengths = {source.path: len(source.text.splitlines()) for source in package_sources}
    too_long = {path: lines for path, lines in lengths.items() if lines > LONGEST_FILE}
    assert not too_long, f"files above {LONGEST_FILE} lines: {too_long}"


def test_nine_functions_in_ten_are_short(package_sources):
    sizes = [
        (body_length(function), f"{source.path}:{function.lineno} {function.name}")
        for source in package_sources
        for function in functions(source.tree)
    ]
    long = sorted((item for item in sizes if item[0] > LONG_FUNCTION), reverse=True)
    listed = "\n".join(f"{size:4d} {name}" for size, name in long)
    assert len(long) <= SHARE_OF_LONG_FUNCTIONS * len(sizes), (
        f"{len(long)} of {len(sizes)} functions have more than {LONG_FUNCTION} lines:\n{listed}"
    )


def test_functions_that_are_not_compiled_have_types(package_sources):
    found = [text for s in package_sources for text in untyped_functions(s.path, s.tree)]
    assert not found, "\n".join(found)


def test_a_function_without_types_is_found():
    code = "def f(x) -> int: ...\n@compiled\ndef g(x): ...\n@signal_kernel\ndef h(p): ...\ndef k(x: int) -> int: ..."
    assert [text.split()[1] for text in untyped_functions("a.py", ast.parse(code))] == ["f"]


def test_no_leftovers(package_sources):
    found = [
        f"{source.path}:{number}: {line.strip()}"
        for source in package_sources
        for number, line in enumerate(source.text.splitlines(), 1)
        if LEFTOVER.search(line)
    ]
    assert not found, "\n".join(found)


def test_no_defects(package_sources):
    found = [text for source in package_sources for text in defects(source.path, source.tree)]
    assert not found, "\n".join(found)


def test_allow_lists_name_files_that_are_there(package_sources):
    paths = {source.path for source in package_sources}
    stale = [path for path in HASATTR_ALLOWED if path not in paths]
    assert not stale, f"allow-listed, but gone: {stale}"


@pytest.mark.parametrize(
    "code",
    [
        "try:\n    f()\nexcept:\n    pass",
        "try:\n    f()\nexcept Exception as e:\n    pass",
        "try:\n    f()\nexcept (ValueError, BaseException):\n    pass",
        "if hasattr(part, 'mass'):\n    pass",
        "assert mass > 0",
        "def f(x=[]):\n    pass",
        "def f(*, x={}):\n    pass",
        "def f(x=np.zeros(3)):\n    pass",
        "g = lambda x=list(): x",
    ],
)
def test_each_defect_is_found(code):
    assert len(list(defects("flexmb/some.py", ast.parse(code)))) == 1


@pytest.mark.parametrize(
    "code",
    [
        "try:\n    f()\nexcept (ValueError, KeyError):\n    pass",
        "def f(x=(), y=None, z=Newton()):\n    pass",
    ],
)
def test_sound_code_passes(code):
    assert list(defects("flexmb/some.py", ast.parse(code))) == []


def test_length_of_a_body_leaves_the_docstring_out():
    code = 'def f(x):\n    """One.\n\n    Two.\n    """\n    y = (\n        x\n    )\n    return y'
    (function,) = functions(ast.parse(code))
    assert body_length(function) == 4


def test_leftovers_are_whole_words():
    assert LEFTOVER.search("# " + "TO" + "DO: sign")
    assert not LEFTOVER.search("MASTODON")
