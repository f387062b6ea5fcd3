"""A file imports only from lower floors or from its own folder (the floors of docs/design.md)."""

import ast
import re
from collections.abc import Iterator
from pathlib import PurePosixPath

import pytest
from trees import walk

FLOORS = {
    "errors": 0, "checks": 0, "arguments": 0, "engine.compiled": 0, "kernels": 0, "planar": 0, "places": 0,
    "engine.differences": 0, "fields": 0, "namespace": 0, "version": 0,
    "display": 0, "late": 0, "units": 0, "findings.finding": 0,
    "model": 1, "engine.linalg": 1, "dynamics.jobs": 1,
    "elastic.beams": 2, "elastic.meshes": 2, "elastic.planes": 2, "elastic.reduced": 2,
    "parts.bodies": 2, "parts.joints": 2, "parts.contact": 2, "parts.drives": 2, "parts.loads": 2, "parts.couplings": 2,
    "parts.sensors": 2, "parts.cams": 2, "parts.bearings": 2, "parts.controllers": 2,
    "parts.wear": 2,
    "program": 3,
    "engine.system": 4,
    "statics.start": 5, "engine.state": 5, "testing": 5,
    "statics": 6, "engine.energy": 6,
    "engine.step": 7, "engine.newmark": 7, "engine.radau": 7, "engine.dormand_prince": 7,
    "findings.mechanism": 7,
    "results": 8,
    "run": 9, "findings.run": 9,
    "engine.sensitivity": 10, "dynamics.series": 10,
    "dynamics": 11,
    "dynamics.sweeps": 12, "show.pictures": 12,
    "mechanisms": 13, "design": 13,
    "show.reports": 14,
    "show.live": 15,
    "cli": 16,
    "parts": 2, "elastic": 2, "engine": 7, "show": 12,  # their docstrings alone
    "__main__": 17, "chaos": 17, "plots": 17, "meshes": 17,
    "bodies": 17, "cams": 17, "contact": 17, "controllers": 17, "couplings": 17, "doctor": 17, "drives": 17,
    "equilibrium": 17, "friction": 17, "loads": 17, "sweeps": 17,
    "wear": 17,
}  # fmt: skip
"""Floor of each file and folder directly under flexmb/, or of the rooms of a folder."""

ROOMS = {name.partition(".")[0] for name in FLOORS if "." in name}
"""Folders whose rooms stand on floors of their own."""

OF_RUNS = {"watch"}
"""Files of findings/ on runs; the other ones examine mechanisms before they move."""

RECORD = ("finding",)
"""File of findings/ with the record itself, in which parts and laws speak."""

SIDEWAYS = {
    ("parts.bearings", "parts.joints"): "a journal bearing is a dry joint with clearance and a film",
    ("parts.joints", "parts.wear"): "a joint with clearance gives the same joint with a surface that wears",
    ("parts.bearings", "parts.wear"): "a journal bearing gives the same joint with a surface that wears",
    ("parts.wear", "parts.bearings"): "a worn journal bearing has the oil and signals of an unworn one",
    ("parts.wear", "parts.joints"): "a worn joint is a joint with clearance",
    ("parts.wear", "parts.contact"): "wear by the work of friction needs friction",
    ("parts.bodies", "elastic.beams"): "a flexible link is made of beam elements",
    ("parts.cams", "parts.contact"): "a pair of curves holds a friction law",
    ("parts.cams", "parts.joints"): "a pair of curves writes the output of gap kernels as joints with clearance do",
    ("parts.couplings", "parts.contact"): "a cable, and a gear pair with backlash, are contacts without friction",
    ("parts.couplings", "parts.joints"): "a rack is a guide whose travel is coupled with an angle",
    ("parts.joints", "parts.contact"): "a joint with clearance holds a normal and a friction law",
    ("parts.loads", "parts.joints"): "a spring has arms to its points as a joint has",
    ("parts.loads", "elastic.planes"): "loads act on the meshes of plane bodies",
    ("elastic.meshes", "elastic.beams"): "plane meshes are read from files as line meshes are",
    ("elastic.planes", "elastic.beams"): "a plane body has the mass-proportional damping of beams",
    ("elastic.planes", "elastic.meshes"): "a plane body has a mesh",
    (
        "elastic.planes",
        "parts.bodies",
    ): "a plane body is a body with the start fields and mass properties of other ones",
    ("elastic.reduced", "elastic.beams"): "the matrices of beams are reduced",
    ("elastic.reduced", "elastic.meshes"): "a reduced body is one of beams, or a plane one",
    ("elastic.reduced", "parts.bodies"): "a reduced body is one of beams, or a plane one",
    ("elastic.reduced", "elastic.planes"): "a reduced body is one of beams, or a plane one",
    ("elastic.reduced", "parts.loads"): "a reduced body keeps the static shapes of loads",
    ("engine.step", "engine.newmark"): "methods share step control and Newton's corrections",
    ("engine.newmark", "engine.step"): "methods share contact events and the acceptance of steps",
    ("engine.radau", "engine.step"): "methods share contact events and the acceptance of steps",
    ("engine.radau", "engine.newmark"): "methods share step control and Newton's corrections",
    ("engine.dormand_prince", "engine.step"): "methods share the acceptance of steps and the whole linear system",
    ("engine.dormand_prince", "engine.newmark"): "methods share step control",
    ("engine.dormand_prince", "engine.radau"): "methods of stages share works, ledgers and projections",
    ("findings.run", "run"): "remarks on a run read its peaks and rows",
    ("run", "findings.run"): "a run is watched while it lasts, and explained when it fails",
}
"""The only imports between two units of one floor, each with its reason. Those of floor 0 share one folder."""

TYPING_ONLY = {
    (f"engine.{room}", "run"): "a stepper is handed the run that it belongs to"
    for room in ("step", "newmark", "radau", "dormand_prince")
}
"""The only imports that go up, each with its reason; nothing is called through them."""

LATE = {
    ("model", "show.pictures"): "Mechanism.plot draws the mechanism",
    ("results", "show.reports"): "a notebook shows a solution as it moves",
}
"""The only imports that go up inside functions, each with its reason: methods for convenience."""

TOP = "flexmb/__init__.py"
"""The one file that may import everything: it only lists the public names."""


def unit_of(path: str) -> str:
    """The unit under flexmb/ to which a file belongs: 'parts.contact' for flexmb/parts/contact/hysteresis.py."""
    return unit(PurePosixPath(path).with_suffix("").parts[1:])


def unit(names: tuple[str, ...]) -> str:
    """The unit of the names of a module behind flexmb."""
    if names[0] == "findings":
        own = names[1:2] or ("",)
        return "findings.finding" if own == RECORD else "findings.run" if own[0] in OF_RUNS else "findings.mechanism"
    room = ".".join(names[:2])
    return room if names[0] in ROOMS and room in FLOORS else names[0]


def imported_modules(path: str, tree: ast.Module) -> Iterator[tuple[int, str, str]]:
    """(line, full name, "typing", "late" or "") of each module of flexmb that the file imports, anywhere in it."""
    package = PurePosixPath(path).parent.parts
    blocks = [node for node in walk(tree) if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"]
    kinds = {id(node): "typing" for block in blocks for line in block.body for node in walk(line)}
    functions = [node for node in walk(tree) if isinstance(node, ast.FunctionDef)]
    kinds |= {id(node): "late" for function in functions for node in walk(function)}
    for node in walk(tree):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = ".".join(package[: len(package) - node.level + 1]) if node.level else ""
            module = ".".join(part for part in (base, node.module) if part)
            names = [f"flexmb.{alias.name}" for alias in node.names] if module == "flexmb" else [module]
        else:
            continue
        ours = (name for name in names if name.split(".")[0] == "flexmb")
        yield from ((node.lineno, name, kinds.get(id(node), "")) for name in ours)


def is_allowed(source: str, target: str, kind: str) -> bool:
    """Whether a file of unit `source` may import from unit `target`; `kind`: "typing", "late" in a function, or ""."""
    lower = FLOORS[target] < FLOORS[source]
    ground_floor = FLOORS[target] == FLOORS[source] == 0
    up = {"typing": TYPING_ONLY, "late": LATE}.get(kind, {})
    return lower or ground_floor or source == target or (source, target) in SIDEWAYS or (source, target) in up


def violations(path: str, tree: ast.Module) -> list[str]:
    """One line for each import that the table forbids."""
    if path == TOP:
        return []
    source = unit_of(path)
    if source not in FLOORS:
        return [f"{path}:1: {source!r} stands on no floor; add it to FLOORS here and to docs/design.md"]
    found = []
    for line, module, kind in imported_modules(path, tree):
        names = tuple(module.split(".")[1:])
        target = unit(names) if names else ""
        if target not in FLOORS:
            found.append(f"{path}:{line}: floor {FLOORS[source]} ({source}) imports {module}, the top of the package")
        elif not is_allowed(source, target, kind):
            here, there = f"floor {FLOORS[source]} ({source})", f"floor {FLOORS[target]} ({target})"
            found.append(f"{path}:{line}: {here} imports {module} from {there}")
    return found


def test_every_import_goes_down(package_sources):
    found = [text for source in package_sources for text in violations(source.path, source.tree)]
    assert not found, "imports that do not go down:\n" + "\n".join(found)


def test_the_map_shows_the_floors(root):
    text = (root / "docs" / "design.md").read_text(encoding="utf-8")
    rows = re.findall(r"^    ([ \d]\d)  (.+)$", text, re.MULTILINE)
    assert {name: int(floor) for floor, names in rows for name in names.split(", ")} == FLOORS


@pytest.mark.parametrize(
    ("path", "code"),
    [
        ("flexmb/model/node.py", "from flexmb.errors import InputError"),
        ("flexmb/model/node.py", "from .part import Part"),
        ("flexmb/checks.py", "from flexmb.errors import InputError"),
        ("flexmb/parts/contact/hysteresis.py", "from flexmb.parts.contact.gap import gap"),
        ("flexmb/parts/contact/hysteresis.py", "from ...model.law import Law"),
        ("flexmb/parts/bodies/flexible.py", "from flexmb.elastic.beams.section import Section"),
        ("flexmb/engine/newmark/method.py", "from flexmb.statics.start import consistent"),
        ("flexmb/engine/step/method.py", "if TYPE_CHECKING:\n    from flexmb.run.run import Run"),
        ("flexmb/cli/command_line.py", "from flexmb.cli.run import run"),
        ("flexmb/cli/arguments/source.py", "from flexmb import mechanisms"),
        ("flexmb/__init__.py", "from flexmb.show.pictures.signals import plot"),
        ("flexmb/show/pictures/signals.py", "import matplotlib"),
        (
            "flexmb/model/mechanism.py",
            "def plot(self):\n    from flexmb.show.pictures import reference",
        ),
    ],
)
def test_allowed_imports(path, code):
    assert violations(path, ast.parse(code)) == []


@pytest.mark.parametrize(
    ("path", "code", "floors"),
    [
        ("flexmb/model/node.py", "from flexmb.statics.start.consistent import assemble", ("floor 1", "floor 5")),
        ("flexmb/errors.py", "from flexmb import checks, mechanisms", ("floor 0", "floor 13")),
        (
            "flexmb/model/mechanism.py",
            "from flexmb.show.pictures.scene import plot_mechanism",
            ("floor 1", "floor 12"),
        ),
        ("flexmb/elastic/beams/fem.py", "from flexmb.parts.bodies.link import Link", ("floor 2", "floor 2")),
        ("flexmb/elastic/beams/fem.py", "from ...engine.system import forces", ("floor 2", "floor 4")),
        ("flexmb/statics/start/consistent.py", "import flexmb.engine.newmark.method", ("floor 5", "floor 7")),
        ("flexmb/engine/step/method.py", "from flexmb.run.run import Run", ("floor 7", "floor 9")),
        ("flexmb/results/vtk.py", "def f():\n    from flexmb.show.pictures import plot", ("floor 8", "floor 12")),
        ("flexmb/testing.py", "from flexmb.results.vtk import write_vtk", ("floor 5", "floor 8")),
        ("flexmb/engine/system/forces.py", "import flexmb as fm", ("floor 4", "top")),
        ("flexmb/engine/system/forces.py", "from flexmb import Mechanism", ("floor 4", "top")),
        ("flexmb/helpers.py", "import math", ("no floor",)),
    ],
)
def test_forbidden_imports_are_found(path, code, floors):
    (message,) = violations(path, ast.parse(code))
    assert message.startswith(f"{path}:")
    assert all(floor in message for floor in floors)
