"""Settings that must stand before numpy, numba and matplotlib are imported, and the source as house tests see it."""

import ast
import gc
import os
import sys
from pathlib import Path
from typing import NamedTuple

import hypothesis
import pytest

ROOT = Path(__file__).resolve().parents[1]

sys.path.insert(0, str(ROOT / "tests"))  # for public_names

gc.set_threshold(50_000, 20, 100)  # numba's millions of objects stay; to look through them often takes minutes

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
    """Every test under tests/speed is a speed test: one that forgot its mark would slow down `make test`."""
    for item in items:
        if (ROOT / "tests" / "speed") in item.path.parents:
            item.add_marker(pytest.mark.speed)


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
