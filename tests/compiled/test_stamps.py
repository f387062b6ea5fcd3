"""Stamps of compiled code: any source that counts changes them, no other does."""

import importlib
import sys
from types import ModuleType

import pytest
from numba.core import config

from flexmb.engine.compiled import code_cache as stamps


@pytest.fixture
def modules(tmp_path, monkeypatch):
    """A function (name, text) that writes a module and registers it as imported."""

    def write(name, text, package=""):
        file = tmp_path / f"{name}.py"
        file.write_text(text)
        module = ModuleType(name)
        module.__file__, module.__package__ = str(file), package
        monkeypatch.setitem(sys.modules, name, module)
        stamps._source.cache_clear()

    yield write
    stamps._source.cache_clear()


@pytest.mark.parametrize(
    "line",
    [
        "from zz_law import force",
        "from zz_law import (\n    force,\n    other,\n)",
        "import zz_law",
        "import zz_law as law  # why",
        "import math, zz_law",
        "from .zz_law import force",
        "from . import zz_law",
    ],
)
def test_a_source_that_is_imported_counts(modules, line):
    package = "zz" if "." in line else ""
    inner = "zz.zz_law" if package else "zz_law"
    modules("zz_kernel", f"{line}\n", package)
    modules("zz_middle", "import zz_kernel\n")
    modules(inner, "HOLD = 1.0\n")
    before = stamps.stamp("zz_middle")
    modules(inner, "HOLD = 2.0\n")
    assert stamps.stamp("zz_middle") != before
    modules(inner, "HOLD = 1.0\n")
    assert stamps.stamp("zz_middle") == before


@pytest.mark.parametrize("text", ["x = 1\n", "def f():\n    import zz_law\n", "if TYPE_CHECKING:\n    import zz_law\n"])
def test_others_do_not(modules, text):
    modules("zz_kernel", text)
    modules("zz_law", "HOLD = 1.0\n")
    before = stamps.stamp("zz_kernel")
    modules("zz_law", "HOLD = 2.0\n")
    assert stamps.stamp("zz_kernel") == before


def test_circles_end(modules):
    modules("zz_a", "import zz_b\n")
    modules("zz_b", "import zz_a\n")
    assert stamps.stamp("zz_a") == stamps.stamp("zz_b")


def test_installed_packages_are_left_out():
    assert stamps._source("numpy") == ("", frozenset())
    assert stamps._source("flexmb.engine.compiled.code_cache")[0]


def test_the_loop_depends_on_laws_of_its_arithmetic_not_on_pictures():

    found, todo = set(), ["flexmb.engine.newmark.method"]
    while todo:
        name = todo.pop()
        if name not in found:
            found.add(name)
            todo += stamps._source(name)[1]
    assert {
        "flexmb.engine.linalg.lu",
        "flexmb.engine.energy",
        "flexmb.engine.system.contacts",
        "flexmb.engine.state.flow",
    } <= found
    assert (
        not {"flexmb.show.pictures.signals", "flexmb.results.netcdf", "flexmb.dynamics.sweeps.parameter_sweep"} & found
    )


def test_a_callee_in_another_file_is_compiled_anew(tmp_path, monkeypatch):
    number = "from flexmb.kernels import compiled\n@compiled\ndef number():\n    return 1.0\n"
    user = "from flexmb.kernels import compiled\nfrom zz_number import number\n@compiled\ndef twice():\n"
    (tmp_path / "zz_number.py").write_text(number)
    (tmp_path / "zz_user.py").write_text(f"{user}    return 2.0 * number()\n")
    monkeypatch.setattr(config, "CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.syspath_prepend(str(tmp_path))

    def run():
        """As a new process finds it: value, and number of functions that are compiled for it."""
        stamps._source.cache_clear()
        importlib.invalidate_caches()
        for name in ("zz_user", "zz_number"):
            sys.modules.pop(name, None)
        twice = importlib.import_module("zz_user").twice
        return twice(), sum(twice.stats.cache_misses.values())

    try:
        assert (run(), run()) == ((2.0, 1), (2.0, 0))
        (tmp_path / "zz_number.py").write_text(number.replace("1.0", "14.0"))
        assert run() == (28.0, 1)
    finally:
        for name in ("zz_user", "zz_number"):
            sys.modules.pop(name, None)
        stamps._source.cache_clear()
