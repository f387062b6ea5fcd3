"""Pages of the API, which `docs/conf.py` writes into docs/api: every public name on exactly one page, by namespaces.

A name that stands both at the top (`fm.Gear`) and in a namespace (`fm.couplings.Gear`) is on the page of the namespace.
The names come from the stubs that `flexmb/namespace.py` reads, so a new public name needs nothing here.
"""

import ast
import inspect
import itertools
import re
import types
from importlib import import_module
from pathlib import Path

from api_docstrings import converted, plain

import flexmb

HERE = Path(__file__).parent / "api"

ROOMS = {
    "Mechanisms and parts": ("model.", "elastic.planes.", "elastic.reduced."),
    "Sections of beams": ("elastic.beams.",),
    "Joints": ("parts.joints.", "parts.bearings.", "parts.wear."),
    "Loads and springs": ("parts.loads.",),
    "Sensors": ("parts.sensors",),
    "Statics, modes, inverse dynamics": ("statics.",),
    "Runs and their methods": ("run.", "engine.", "program.", "statics.start.", "findings."),
    "Results": ("results.", "show."),
}
"""Sections of the page of `fm`, with the rooms of their names; of two rooms that fit, the inner one counts."""


def namespaces() -> list[str]:
    """Names of the public namespaces."""
    return sorted(name for name in flexmb.__all__ if isinstance(getattr(flexmb, name), types.ModuleType))


def room_of(name: str) -> str:
    """Section of the page of `fm` for a public name, by the module that defines it."""
    thing = getattr(flexmb, name)
    home = (
        getattr(thing, "__module__", "")
        if not isinstance(thing, type(flexmb.GROUND) | flexmb.Material)
        else "flexmb.model."
    )
    path = home.removeprefix("flexmb.")
    fitting = {room: section for section, rooms in ROOMS.items() for room in rooms if path.startswith(room)}
    return fitting[max(fitting, key=len)] if fitting else "Others"


def pages() -> dict[str, dict[str, list[str]]]:
    """Names (behind `flexmb.`) by page and section; each public object occurs once."""
    spaces = namespaces()
    found: dict[str, dict[str, list[str]]] = {}
    seen: set[int] = set()
    for space in spaces:
        module = getattr(flexmb, space)
        found[space] = {"": [f"{space}.{name}" for name in module.__all__]}
        seen |= {id(getattr(module, name)) for name in module.__all__}
    top: dict[str, list[str]] = {section: [] for section in [*ROOMS, "Others"]}
    for name in flexmb.__all__:
        if name not in spaces and id(getattr(flexmb, name)) not in seen:
            top[room_of(name)].append(name)
    return {"fm": {section: names for section, names in top.items() if names}, **found}


def directive(name: str) -> str:
    """Directive of Sphinx that documents a public name."""
    thing = flexmb
    for part in name.split("."):
        thing = getattr(thing, part)
    if inspect.isclass(thing):
        more = "" if issubclass(thing, BaseException) else "   :members:\n"
        return f".. autoclass:: flexmb.{name}\n{more}"
    if callable(thing):
        return f".. autofunction:: flexmb.{name}\n"
    return f".. py:data:: flexmb.{name}\n\n   {documented(name)}\n"


def documented(name: str) -> str:
    """Text below the assignment of a public constant where there is one, else its value and the line of its class."""
    space, _, last = name.rpartition(".")
    folder = Path(flexmb.__file__).parent / Path(*space.split("."))
    stub = folder / "__init__.pyi" if folder.is_dir() else folder.with_suffix(".pyi")
    (home,) = re.findall(rf"^from (\S+) import {last} as", stub.read_text(encoding="utf-8"), re.MULTILINE)
    module = import_module(home)
    for statement, below in itertools.pairwise(ast.parse(inspect.getsource(module)).body):
        targets = statement.targets if isinstance(statement, ast.Assign) else [getattr(statement, "target", None)]
        text = below.value if isinstance(below, ast.Expr) else None
        if [getattr(target, "id", "") for target in targets] == [last] and isinstance(text, ast.Constant):
            return " ".join(converted(str(text.value).splitlines()))
    value = getattr(module, last)
    return f"``{value!r}``. {plain((inspect.getdoc(value) or '').splitlines()[0])}"


def first_paragraph(space: str) -> str:
    """First line of the docstring of a namespace."""
    return (inspect.getdoc(getattr(flexmb, space)) or "").splitlines()[0]


def text_of(page: str, sections: dict[str, list[str]]) -> str:
    """Source of a page."""
    title = "fm: what most scripts need" if page == "fm" else f"fm.{page}"
    about = (
        "Names of `import flexmb as fm` that stand in no namespace. Others are on the page of their namespace, "
        "also where they can be had from `fm` as well."
        if page == "fm"
        else first_paragraph(page)
    )
    lines = [f"# {title}", "", about, ""]
    for section, names in sections.items():
        lines += [f"## {section}", ""] if section else []
        for name in names:
            also = name.rpartition(".")[2]
            lines += [f"Also `fm.{also}`:", ""] if page != "fm" and also in flexmb.__all__ else []
            lines += ["```{eval-rst}", directive(name), "```", ""]
    return "\n".join(lines)


def write() -> None:
    """Pages and their table of contents, in docs/api."""
    HERE.mkdir(exist_ok=True)
    made = pages()
    for page, sections in made.items():
        put(HERE / f"{page}.md", text_of(page, sections))
    put(
        HERE / "index.md",
        "# API\n\nPublic names by namespaces.\n\n```{toctree}\n:maxdepth: 1\n\n" + "\n".join(made) + "\n```\n",
    )


def put(path: Path, text: str) -> None:
    """A file is written only where its text is new, so that a second build is short."""
    if not path.exists() or path.read_text(encoding="utf-8") != text:
        path.write_text(text, encoding="utf-8")
