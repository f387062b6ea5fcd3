"""Settings that must stand before numpy, numba and matplotlib are imported, and the source as house tests see it."""

import ast
import gc
import logging
import os
import shutil
import sys
from collections import Counter
from collections.abc import Generator
from pathlib import Path
from typing import NamedTuple

import hypothesis
import pytest

ROOT = Path(__file__).resolve().parents[1]

sys.path.insert(0, str(ROOT / "tests"))  # for public_names

gc.set_threshold(50_000, 20, 100)  # numba's millions of objects stay; to look through them often takes minutes

# What packages log is shown where a test fails.  With `log_level` pytest sets it anew twelve times a test, and Python
# goes through all loggers each time.
logging.getLogger().setLevel(logging.INFO)

os.environ.setdefault("NUMBA_CACHE_DIR", str(ROOT / ".numba_cache"))
os.environ.setdefault("FLEXMB_MESSAGES", "0")
os.environ.setdefault("MPLBACKEND", "Agg")
os.environ.setdefault("PYVISTA_OFF_SCREEN", "true")
for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS"):
    os.environ.setdefault(name, "1")  # threads of a hundred equations wait for one another on cores that others use

# The first example of a test may compile a kernel, so no deadline; the same examples in every run.
hypothesis.settings.register_profile("flexmb", deadline=None, derandomize=True)
hypothesis.settings.load_profile("flexmb")


class Source(NamedTuple):
    """One Python file: its path from the root of the repository, its text, its syntax tree."""

    path: str
    text: str
    tree: ast.Module


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Tests under tests/speed are speed tests; of a test with the mark `quick(n)` cases behind the n-th are slow."""
    cases = Counter[str]()
    for item in items:
        if (ROOT / "tests" / "speed") in item.path.parents:
            item.add_marker(pytest.mark.speed)
        if quick := item.get_closest_marker("quick"):
            name = item.nodeid.partition("[")[0]
            cases[name] += 1
            if cases[name] > quick.args[0]:
                item.add_marker(pytest.mark.slow)


def pytest_collection_finish() -> None:
    """Modules are not looked through for garbage any more."""
    gc.freeze()


def pytest_sessionfinish() -> None:
    """At the end of the process nothing is looked through, which pytest does five times, and Python once more."""
    gc.freeze()


@pytest.hookimpl(wrapper=True)
def pytest_collect_file() -> Generator[None, list[pytest.Collector], list[pytest.Collector]]:
    """Docstrings of tests hold no examples: to look for them takes as long as to import the tests."""
    found = yield
    return [one for one in found if type(one) is pytest.Module]


@pytest.fixture(scope="session")
def root() -> Path:
    """Root of the repository."""
    return ROOT


@pytest.fixture(scope="session")
def package_sources() -> list[Source]:
    """Every Python file of the package."""
    return _sources("flexmb")


@pytest.fixture(scope="session")
def cited_sources(package_sources) -> list[Source]:
    """Every Python file of the package and of the study of the nine-bar mechanism, which cite the theory."""
    return package_sources + _sources("examples/nine_bar_study")


def _sources(folder: str) -> list[Source]:
    files = sorted((ROOT / folder).rglob("*.py"))
    texts = [(file.relative_to(ROOT).as_posix(), file.read_text(encoding="utf-8")) for file in files]
    return [Source(path, text, ast.parse(text, path)) for path, text in texts]


@pytest.fixture(params=["fewer states", pytest.param("all states", marks=pytest.mark.slow)])
def states(request, monkeypatch):
    """`check_part` at half of the random states of pieces, at a sixth of those of laws and controls, of every size.

    All of them in slow tests, and where the states themselves are tested.
    """
    if request.param == "fewer states":
        monkeypatch.setattr("flexmb.testing.bench.MAGNITUDES", (1e-3, 0.3))
        monkeypatch.setattr("flexmb.testing.constraints.ROUNDS", 2)
        monkeypatch.setattr("flexmb.testing.bench.ROUNDS", 1)


@pytest.fixture(scope="session")
def browser():
    """A browser without a window; tests that need one are skipped where there is none."""
    playwright = pytest.importorskip(
        "playwright.sync_api", reason="playwright is not installed: pip install playwright"
    )
    from pages import BROWSERS

    found = next((path for name in BROWSERS if (path := shutil.which(name))), None)
    if found is None:
        pytest.skip(f"none of these browsers is on the PATH: {', '.join(BROWSERS)}")
    alone = ["--no-sandbox"] if os.geteuid() == 0 else []
    with playwright.sync_playwright() as running:
        started = running.chromium.launch(executable_path=found, args=alone)
        yield started
        started.close()


@pytest.fixture(scope="session")
def layout_faults():
    """Function that lists elements of an open page that cover one another, are cut, or make it scroll sideways."""
    from pages import CUT, OVERLAPS

    def faults(page):
        wide = page.evaluate("document.documentElement.scrollWidth - innerWidth")
        sideways = [f"the page scrolls sideways by {wide} px"] if wide else []
        return [*sideways, *page.evaluate(OVERLAPS), *page.evaluate(CUT)]

    return faults
