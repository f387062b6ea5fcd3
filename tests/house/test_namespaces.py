"""The top of the package holds what most scripts need; every other public name lies in one namespace."""

import re
import subprocess
import sys
from pathlib import Path

import pytest
from public_names import NAMESPACES, PUBLIC

import flexmb as fm

MOST_NAMES_AT_THE_TOP = 96

PARTS = ("bodies", "cams", "contact", "controllers", "couplings", "drives", "loads", "wear")

FAR = {
    "": "flexmb",
    "chaos": "flexmb.dynamics",
    "doctor": "flexmb.findings",
    "equilibrium": "flexmb.statics",
    "friction": "flexmb.parts.contact",
    "meshes": "flexmb.elastic.meshes",
    "model": "flexmb",  # its records, and the fields of flexmb/fields.py
    "plots": "flexmb.show.pictures",
    "sweeps": "flexmb.dynamics.sweeps",
    **{space: f"flexmb.parts.{space}" for space in PARTS},
}
"""Room in which the names of a namespace are defined, where it is not the folder of the same name."""


def test_the_top_can_be_browsed():
    parts = [name for name in fm.__all__ if name not in NAMESPACES]
    assert len(parts) <= MOST_NAMES_AT_THE_TOP
    assert {name for name in dir(fm) if not name.startswith("_")} == set(fm.__all__)


@pytest.mark.parametrize("space", NAMESPACES)
def test_a_namespace_shows_its_names_alone(space):
    module = getattr(fm, space)
    assert module.__all__ == sorted(module.__all__)
    assert set(module.__all__) <= set(dir(module))
    assert re.match(r"[A-Z].*[.:]$", module.__doc__.splitlines()[0])


@pytest.mark.parametrize("name", sorted(PUBLIC))
def test_a_name_comes_from_its_namespace(name):
    space = name.rpartition(".")[0]
    home = FAR.get(space, f"flexmb.{space}")
    assert getattr(PUBLIC[name], "__module__", home).startswith(home)


def test_no_two_names_at_the_top_differ_in_case_alone():
    """`section` beside `Section` would be read as the same."""
    lower = [name.lower() for name in fm.__all__]
    assert len(set(lower)) == len(lower)


def test_no_function_or_class_has_the_name_of_a_module():
    """Importing `flexmb.report` would put the module in the place of the function `fm.report`."""
    folder = Path(fm.__file__).parent
    modules = {path.stem for path in folder.iterdir() if path.is_dir() or path.suffix == ".py"}
    assert not modules & {name for name in fm.__all__ if name not in NAMESPACES}


def test_unknown_names_are_refused():
    for module in (fm, fm.chaos, fm.contact):
        with pytest.raises(AttributeError, match=f"'{module.__name__}' has no attribute 'nothing'"):
            module.nothing  # noqa: B018


def test_nothing_is_imported_before_it_is_needed():
    code = (
        "import sys, flexmb; print(*sorted(m for m in sys.modules if m.startswith('flexmb')), 'numpy' in sys.modules)"
    )
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert said.split() == ["flexmb", "flexmb.namespace", "False"]
