"""Damaged caches of compiled code, and folders without room: compiled anew, said once, never another result.

The expected values are those of the functions in plain Python.
"""

import errno
import importlib
import os
import shutil
import sys

import numpy as np
import pytest
from numba.core import config

from flexmb.engine.compiled import code_cache, notice
from flexmb.engine.compiled.pieces import whole
from flexmb.kernels import MOTION, Kernel

resource = pytest.importorskip("resource")  # not on every platform

TEXT = """
FACTOR = 3.0


def motion(p, t):
    return FACTOR * t + p[0], FACTOR, 0.0


def other(p, t):
    return 7.0 * t, 7.0, 0.0


def summed(a, b):
    return a + 2.0 * b
"""

MANNERS = ("bit", "bit", "bit", "cut", "empty", "lost", "other", "folder")


def results(module):
    """Results of the functions as they come from the cache, or are compiled; the number of functions compiled."""
    p, found, compiled = np.array([0.5]), [], 0
    for function in (module.motion, module.other):
        kernel = Kernel(function, MOTION)
        assert kernel.address
        found.append(kernel.dispatcher(p, 2.0)[0])
        compiled += sum(kernel.dispatcher.stats.cache_misses.values())
    outer = whole()(module.summed)
    found.append(outer(1.0, 2.0))
    compiled += sum(outer.stats.cache_misses.values())
    return found, compiled


EXPECTED = [6.5, 14.0, 5.0]


@pytest.fixture
def module(tmp_path, monkeypatch):
    """A module of a user, with a cache of its own, which is full."""
    monkeypatch.setattr(config, "CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setenv("FLEXMB_MESSAGES", "1")
    monkeypatch.syspath_prepend(str(tmp_path))
    (tmp_path / "zz_kernels.py").write_text(TEXT)
    importlib.invalidate_caches()
    found = importlib.import_module("zz_kernels")
    notice.say_once.cache_clear()
    assert results(found) == (EXPECTED, 3)
    assert results(found) == (EXPECTED, 0)
    yield found
    sys.modules.pop("zz_kernels")
    for name in ("motion", "other", "summed"):
        notice.caches.pop(f"zz_kernels.{name}", None)


def damaged(folder, rng):
    """Damage one file of a cache; the manner and the file."""
    files = sorted(file for file in folder.rglob("*.nb?") if file.is_file())
    file, manner = files[rng.integers(len(files))], MANNERS[rng.integers(len(MANNERS))]
    data = bytearray(file.read_bytes())
    if manner in ("lost", "folder"):
        file.unlink()
    if manner == "folder":
        file.mkdir()
    elif manner == "other":
        others = [one for one in files if one.suffix == file.suffix and one != file]
        file.write_bytes(others[rng.integers(len(others))].read_bytes())
    elif manner == "bit":
        place = rng.integers(8 * len(data))
        data[place // 8] ^= 1 << (place % 8)
        file.write_bytes(data)
    elif manner != "lost":
        file.write_bytes(data[: rng.integers(len(data)) if manner == "cut" else 0])
    return manner, file


@pytest.mark.parametrize("count", [12, pytest.param(200, marks=pytest.mark.slow)])
def test_damaged_files_are_compiled_anew(module, tmp_path, capsys, count):
    """5 of 6 gave raw errors at every later run before, or blamed a kernel of the package."""
    rng, folder, kept = np.random.default_rng(count), tmp_path / "cache", tmp_path / "kept"
    shutil.copytree(folder, kept)
    for _ in range(count):
        manner, file = damaged(folder, rng)
        capsys.readouterr()
        notice.say_once.cache_clear()
        found, compiled = results(module)
        assert found == EXPECTED, (manner, file)
        assert compiled == 1, (manner, file)
        said = capsys.readouterr().err
        assert ("is damaged. It is compiled anew." in said) == (manner in ("bit", "cut", "empty")), (manner, said)
        if manner == "folder":
            assert "cannot be read (Is a directory)" in said
            assert "cannot be kept" in said
            shutil.rmtree(folder)
            shutil.copytree(kept, folder)
        else:  # healed
            assert results(module) == (EXPECTED, 0), (manner, file)


@pytest.mark.slow
def test_a_full_disk_is_said_and_nothing_else(module, tmp_path, capsys, monkeypatch):
    shutil.rmtree(tmp_path / "cache")

    def full(*_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(code_cache.SealedFiles, "_open_for_write", full)
    capsys.readouterr()
    for _ in range(2):
        assert results(module) == (EXPECTED, 3)
    said = capsys.readouterr().err
    assert said.count("compiled code cannot be kept in") == 1
    assert "No space left on device" in said


@pytest.mark.slow
def test_files_that_are_cut_by_the_system(module, tmp_path, capsys):
    """No file may grow beyond 1000 bytes: the run goes on, and the next one, with room, keeps its code."""
    shutil.rmtree(tmp_path / "cache")
    capsys.readouterr()
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, before[1]))
    try:
        found = results(module)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert found == (EXPECTED, 3)
    assert "compiled code cannot be kept" in capsys.readouterr().err
    assert results(module) == (EXPECTED, 3)
    assert results(module) == (EXPECTED, 0)


@pytest.mark.slow
def test_an_index_never_leads_to_code_of_other_sources(module, tmp_path, monkeypatch):
    """A process that is killed between its two files leaves new code behind an old index."""
    first = results(module)

    def killed(*_):
        raise KeyboardInterrupt

    (tmp_path / "zz_kernels.py").write_text(TEXT.replace("FACTOR * t", "FACTOR * 2.0 * t"))
    importlib.invalidate_caches()
    changed = importlib.reload(module)
    with monkeypatch.context() as patch:
        patch.setattr(code_cache.SealedFiles, "_save_index", killed)
        with pytest.raises(KeyboardInterrupt):
            results(changed)
    assert results(changed) == ([12.5, *EXPECTED[1:]], 3)
    assert first == (EXPECTED, 0)


def test_a_constant_from_another_module_counts(tmp_path, monkeypatch):
    """numba looks at the file of the kernel alone: a number imported from elsewhere stayed as it was at first."""
    monkeypatch.setattr(config, "CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.syspath_prepend(str(tmp_path))
    (tmp_path / "zz_law.py").write_text("from zz_constants import K\ndef motion(p, t):\n    return K * t, K, 0.0\n")
    found = []
    for k in (2.0, 2.0, 3.0):
        (tmp_path / "zz_constants.py").write_text(f"K = {k}  #{'#' * int(k)}\n")
        importlib.invalidate_caches()
        for name in ("zz_law", "zz_constants"):
            sys.modules.pop(name, None)
        kernel = Kernel(importlib.import_module("zz_law").motion, MOTION)
        found.append((kernel.dispatcher(np.array([0.0]), 1.0)[0], sum(kernel.dispatcher.stats.cache_misses.values())))
    assert found == [(2.0, 1), (2.0, 0), (3.0, 1)]
    for name in ("zz_law", "zz_constants"):
        sys.modules.pop(name, None)
