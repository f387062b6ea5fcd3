"""Functions as pieces of whole modules: same results as ordinary compilation, and far fewer modules."""

import os
import runpy
import subprocess
import sys
from pathlib import Path
from types import FunctionType

import numba
import numpy as np
import pytest
from numba.core.dispatcher import Dispatcher

from flexmb import version
from flexmb.engine.compiled.pieces import PlainModule

ROOT = Path(__file__).resolve().parents[2]

LAYERS = """
import numpy as np
from flexmb.engine.compiled.pieces import whole

make = whole(error_model="numpy", _nrt=False)

@make
def deep(x):
    return np.sqrt(x) + 1.0 / 3.0

@make
def middle(x, n):
    total = 0.0
    for i in range(n):
        total += deep(x + i)
    return total

@make
def other(x):
    return deep(x) - middle(x, 2)

@make
def top(values, n):
    for i in range(values.shape[0]):
        values[i] = middle(values[i], n) + other(values[i])
    return values.sum()
"""


@pytest.fixture
def layers(tmp_path, monkeypatch):
    """A module of four functions that call one another."""
    (tmp_path / "layers_of_pieces.py").write_text(LAYERS, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    sys.modules.pop("layers_of_pieces", None)
    import layers_of_pieces

    return layers_of_pieces


def by_hand(values, n):
    deep = lambda x: np.sqrt(x) + 1.0 / 3.0  # noqa: E731
    middle = lambda x: sum(deep(x + i) for i in range(n))  # noqa: E731
    return [middle(x) + deep(x) - (deep(x) + deep(x + 1)) for x in values]


def test_the_same_numbers(layers):
    values = np.array([1.0, 2.5, 7.0])
    expected = by_hand(values, 3)
    assert layers.top(values, 3) == pytest.approx(sum(expected), rel=1e-14)
    assert values == pytest.approx(expected, rel=1e-14)


def test_called_from_python_a_piece_is_whole_too(layers):
    assert layers.deep(4.0) == 2.0 + 1.0 / 3.0
    assert layers.middle(4.0, 1) == 2.0 + 1.0 / 3.0


def test_ordinary_compiled_functions_may_call_pieces(layers):
    deep, middle = layers.deep, layers.middle

    @numba.njit
    def ordinary(x):
        return deep(x) + middle(x, 1)

    assert ordinary(4.0) == 2.0 * (2.0 + 1.0 / 3.0)


def test_an_error_of_typing_names_the_function(layers):
    with pytest.raises(numba.TypingError, match="deep"):
        layers.top(np.array(["a"]), 1)


@pytest.mark.slow
def test_one_module_is_kept_for_what_python_calls(layers, tmp_path):
    """A second process finds it; pieces leave nothing behind."""
    code = "import numpy as np, layers_of_pieces as m; found = m.top(np.array([1.0, 2.0]), 2)"
    code = f"{code}; print(found, sum(m.top.stats.cache_hits.values()))"
    cache = tmp_path / "cache"
    path = os.pathsep.join([str(tmp_path), str(ROOT)])
    environment = {**os.environ, "PYTHONPATH": path, "NUMBA_CACHE_DIR": str(cache)}
    said = [
        subprocess.run([sys.executable, "-c", code], env=environment, check=True, capture_output=True, text=True).stdout
        for _ in range(2)
    ]
    assert said[0].split()[0] == said[1].split()[0]
    assert [text.split()[1] for text in said] == ["0", "1"]
    assert len(list(cache.rglob("*.nbc"))) == 1


def test_versions_of_numba(monkeypatch):
    assert [version.compiles_fast(one) for one in ("0.60.0", "0.67.1", "0.68.0", "0.68.3rc1", "0.69.0", "1.0")] == [
        *(False, False, True, True, False, False)
    ]
    monkeypatch.setattr(version, "version", lambda _: "0.69.0")
    assert version.versions().endswith("numba 0.69.0 (compiles slowly; fast is 0.68)")


OTHER = """
import numba
numba.__version__ = {!r}
import flexmb as fm
from flexmb import version
from flexmb.engine.compiled import pieces
from flexmb.engine.newmark.method import advance
assert isinstance(advance, pieces.Whole) == ({!r} == "0.68.1"), type(advance)
sol = fm.simulate(fm.mechanisms.slider_crank(clearance=5e-4), t_end=2e-3)
assert sol.ok, sol.status
print(*(f"{{v:.9e}}" for v in sol.values[-1]))
"""


@pytest.mark.slow
@pytest.mark.parametrize("other", ["0.67.0", "0.69.0"])
def test_another_numba_finds_the_same(tmp_path, other):
    """The next older and the next newer version: nothing private of numba is used, and the motion is the same."""
    found = []
    for number in ("0.68.1", other):
        environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / number), "FLEXMB_MESSAGES": "0"}
        command = [sys.executable, "-c", OTHER.format(number, number)]
        done = subprocess.run(command, env=environment, check=True, capture_output=True, text=True)
        found.append([float(word) for word in done.stdout.split()])
    assert found[1] == pytest.approx(found[0], rel=1e-5, abs=1e-8)


def named_by(function):
    """All of the package that a function names: globals, and what it may take from modules among them."""
    names = function.__code__.co_names
    found = [function.__globals__.get(name) for name in names]
    modules = [m for m in found if isinstance(m, PlainModule) or getattr(m, "__name__", "").startswith("flexmb.")]
    return [*found, *(getattr(module, name, None) for module in modules for name in names)]


def test_kernels_in_plain_python_call_nothing_compiled():
    """A check of an installed package waits for no compiler; some kernels name helpers by their module."""
    kernels = runpy.run_path(str(ROOT / "tests" / "ship.py"))["kernels"]()
    waiting, seen, compiled = [kernel.python for kernel in kernels], set(), []
    while waiting:
        function = waiting.pop()
        if function.__code__ not in seen:
            seen.add(function.__code__)
            named = named_by(function)
            waiting += [one for one in named if isinstance(one, FunctionType)]
            compiled += [(function.__qualname__, one) for one in named if isinstance(one, Dispatcher)]
    assert len(seen) > 150
    assert not compiled
