"""Code that an installation brings along: used where everything fits, else left alone, and why is said once."""

import json

import numba
import numpy as np
import pytest
from numba.core import event

from flexmb.engine.compiled import code_cache, notice
from flexmb.engine.compiled.code_cache import CODE, INDEX, CodeCache, Shipment, Shipped
from flexmb.kernels import Kernel, drive_kernel
from flexmb.parts.drives.motions import constant_speed_kernel

SPEED = constant_speed_kernel.function


class Counter(event.Listener):
    """Counts what is compiled."""

    def __init__(self):
        self.count = 0

    def on_start(self, event):
        self.count += 1

    def on_end(self, event):
        pass


@pytest.fixture
def compilations():
    counter = Counter()
    with event.install_listener("numba:compile", counter):
        yield counter


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A shipment of one kernel, made for this processor, in the place of the installation's."""
    signature = constant_speed_kernel.contract.signature
    result = numba.njit(signature, error_model="numpy", _nrt=False)(SPEED).get_compile_result(signature)
    shipment = Shipment("x86-64-v3")
    shipment.add(SPEED, tuple(signature.args), result)
    shipment.write(tmp_path)
    change(tmp_path, needs=[])
    monkeypatch.setattr(code_cache, "FOLDER", tmp_path)
    monkeypatch.setenv("FLEXMB_SHIPPED", "1")
    monkeypatch.setenv("FLEXMB_MESSAGES", "1")
    forget()
    yield tmp_path
    forget()


def forget():
    for once in (code_cache.shipped, code_cache._refuse, notice.say_once):
        once.cache_clear()


def fresh_kernel():
    """The kernel as a process has it that has not called it yet; numba's cache is left out."""
    kernel = Kernel(SPEED, constant_speed_kernel.contract)
    kernel.python = SPEED
    return kernel


def change(folder, **values):
    index = json.loads((folder / INDEX).read_text())
    (folder / INDEX).write_text(json.dumps(index | values))


@pytest.fixture
def no_cache(monkeypatch):
    """No folder can be written."""

    def refuse(function):
        raise RuntimeError("no locator available")

    monkeypatch.setattr(code_cache, "SealedCache", type("SealedCache", (), {"__new__": lambda cls, f: refuse(f)}))


def result_of(kernel):
    return kernel.dispatcher(frozen(3.0), 2.0)


def frozen(*numbers):
    array = np.array(numbers)
    array.flags.writeable = False
    return array


def test_code_that_fits_is_used(folder, no_cache, compilations, capsys):
    assert result_of(fresh_kernel()) == (6.0, 3.0, 0.0)
    assert compilations.count == 0
    assert capsys.readouterr().err == ""


def test_a_folder_that_cannot_be_written_is_said_once(folder, no_cache, compilations, capsys, monkeypatch):
    monkeypatch.setenv("FLEXMB_SHIPPED", "0")
    assert [result_of(fresh_kernel()) for _ in range(2)] == [(6.0, 3.0, 0.0)] * 2
    assert compilations.count == 2
    said = capsys.readouterr().err
    assert said.count("cannot be kept") == 1
    assert "NUMBA_CACHE_DIR" in said


def made_with(name, value):
    return lambda folder: change(folder, made_with={**code_cache.made_with(), name: value})


def cut(folder):
    data = (folder / CODE).read_bytes()
    (folder / CODE).write_bytes(data[: len(data) // 2])


def spoil(folder):
    data = bytearray((folder / CODE).read_bytes())
    data[len(data) // 2] ^= 1
    (folder / CODE).write_bytes(bytes(data))


FAULTS = {
    "numba 0.1, here is": made_with("numba", "0.1"),
    "llvmlite 0.1, here is": made_with("llvmlite", "0.1"),
    "Python cpython 3.0, here is": made_with("Python", "cpython 3.0"),
    "platform s390x-unknown, here is": made_with("platform", "s390x-unknown"),
    "lacks avx1024": lambda folder: change(folder, needs=["avx1024"]),
    "other sources": lambda folder: change(folder, sources="0"),
    "is not whole": cut,
    "is damaged": spoil,
    "cannot be read": lambda folder: (folder / INDEX).write_text("{"),
    "not there": lambda folder: (folder / CODE).unlink(),
    "index.json is not there": lambda folder: (folder / INDEX).unlink(),
    "has no 'size'": lambda folder: (folder / INDEX).write_text("{}"),
}


@pytest.mark.quick(1)
@pytest.mark.parametrize(
    "why",
    [
        pytest.param(n, marks=pytest.mark.slow)
        if n.startswith(("llvmlite", "Python", "platform", "is not whole", "cannot be read", "not there"))
        else n
        for n in FAULTS
    ],
)
def test_what_does_not_fit_is_compiled_and_said_once(folder, no_cache, compilations, capsys, why):
    FAULTS[why](folder)
    forget()
    assert [result_of(fresh_kernel()) for _ in range(2)] == [(6.0, 3.0, 0.0)] * 2
    assert compilations.count == 2
    said = capsys.readouterr().err
    assert why in said
    assert said.count("is not used") == 1


@pytest.mark.slow
@pytest.mark.parametrize("count", [8, pytest.param(200, marks=pytest.mark.slow)])
def test_flipped_bits_of_the_index_give_no_raw_error(folder, no_cache, count):
    """Words that Python reads and nobody knows were KeyErrors at every later run."""
    whole, rng = (folder / INDEX).read_bytes(), np.random.default_rng(count)
    for _ in range(count):
        data, place = bytearray(whole), rng.integers(8 * len(whole))
        data[place // 8] ^= 1 << (place % 8)
        (folder / INDEX).write_bytes(data)
        forget()
        assert result_of(fresh_kernel()) == (6.0, 3.0, 0.0)
    for name in ("made_with", "needs", "sources", "code"):
        (folder / INDEX).write_bytes(whole.replace(name.encode(), b"x"))
        forget()
        assert result_of(fresh_kernel()) == (6.0, 3.0, 0.0)


def test_another_processor_of_numba_leaves_it_alone(folder, monkeypatch):
    monkeypatch.setattr(code_cache.config, "CPU_NAME", "generic")
    assert code_cache.shipped() is None


def test_nothing_is_said_where_nothing_is_shipped(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(code_cache, "FOLDER", tmp_path / "none")
    forget()
    assert code_cache.shipped() is None
    assert capsys.readouterr().err == ""
    forget()


def test_a_users_kernel_is_compiled_here(folder, tmp_path, compilations, monkeypatch):
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path / "cache"))

    @drive_kernel
    def crawl(p, t):
        return p[0] * t, p[0], 0.0

    assert not code_cache.ours(crawl.function)
    assert crawl.dispatcher(frozen(3.0), 2.0) == (6.0, 3.0, 0.0)
    assert compilations.count == 1


def test_the_index_says_what_is_there(folder):
    store = Shipped(folder)
    assert store.has(SPEED)
    assert not store.has(drive_kernel)
    assert CodeCache(SPEED).there()


def test_any_change_of_a_source_counts(tmp_path):
    (tmp_path / "a.py").write_text("x = 1\n")
    before = code_cache.sources(tmp_path)
    (tmp_path / "b.py").write_text("")
    between = code_cache.sources(tmp_path)
    (tmp_path / "a.py").write_text("x = 2\n")
    assert len({before, between, code_cache.sources(tmp_path)}) == 3
