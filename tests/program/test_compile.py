"""Programs: the same every time, read-only, the same in another process."""

import multiprocessing
import os
import pickle
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import flexmb as fm
from flexmb.engine.compiled.records import Record

HERE = Path(__file__).parent


@pytest.fixture(scope="module")
def user():
    """The user's module, imported by its name as a user would."""
    sys.path.insert(0, str(HERE))
    import kernels_of_a_user

    yield kernels_of_a_user
    sys.path.remove(str(HERE))


def arrays(value, name="program"):
    """All arrays in nested tuples and records, by place."""
    if isinstance(value, Record):
        value = tuple(value.as_dict().values())
    if isinstance(value, np.ndarray):
        yield name, value
    elif isinstance(value, tuple):
        for k, item in enumerate(value):
            yield from arrays(item, f"{name}.{k}")


def all_arrays(program):
    drawn, pattern = vars(program.reference), vars(program.symbolic)
    groups = [("tables", program.tables), ("drawn", tuple(drawn.values())), ("pattern", tuple(pattern.values()))]
    return dict(pair for name, value in groups for pair in arrays(value, name))


def environment(**more):
    """Variables of a child process that finds flexmb and the user's module, with the cache of this one."""
    path = os.pathsep.join([str(HERE), str(HERE.parents[1])])
    return {**os.environ, "PYTHONPATH": path, **more}


def test_same_arrays_every_time(user):
    first, second = (all_arrays(fm.compile(user.pendulum())) for _ in range(2))
    assert first.keys() == second.keys()
    assert len(first) > 20
    for name, value in first.items():
        assert value.dtype == second[name].dtype, name
        np.testing.assert_array_equal(value, second[name], err_msg=name)


def test_arrays_cannot_be_written_to(user):
    program = fm.compile(user.pendulum())
    found = dict(arrays(program.tables, "tables"))
    assert not [name for name, value in found.items() if value.flags.writeable]
    with pytest.raises(ValueError, match="read-only"):
        program.tables.p[0] = 1.0


def test_each_parameter_reaches_its_place(user):
    """Changing one number changes the parameters at exactly one place."""
    mechanism = user.pendulum()
    p = fm.compile(mechanism).tables.p
    # of the law its stiffness: what stands in p for the restitution is the factor 3 (1 - e^2)/4
    for key, value in {"coil.k": 0.7, "shoulder.normal.stiffness": 2e8, "upper.inertia": 3e-3}.items():
        changed = fm.compile(mechanism.with_({key: value})).tables.p
        (places,) = np.nonzero(changed != p)
        assert places.size == 1, key
        assert changed[places[0]] == value


def test_coordinates_follow_the_order_of_declaration(user):
    program = fm.compile(user.pendulum())
    assert program.names.coordinates == (
        "upper.x", "upper.y", "upper.theta", "lower.x", "lower.y", "lower.theta",
    )  # fmt: skip
    np.testing.assert_allclose(program.reference.q[:3], [0.1, 0.0, 0.0], atol=1e-15)
    np.testing.assert_allclose(program.reference.q[3:], [0.35, 0.05, np.arctan2(0.1, 0.3)], rtol=1e-15)


def test_pickled_program_gives_the_same_motion(user):
    program = fm.compile(user.pendulum())
    copy = pickle.loads(pickle.dumps(program))  # noqa: S301 - written on this line
    np.testing.assert_array_equal(user.motion(copy), user.motion(program))


@pytest.mark.slow
def test_program_in_a_spawned_process(user, monkeypatch):
    for name, value in environment().items():
        monkeypatch.setenv(name, value)
    program = fm.compile(user.pendulum())
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
        there = pool.submit(user.motion, program).result(timeout=300)
    here = user.motion(program)
    assert here.shape[0] > 90
    np.testing.assert_array_equal(there, here)


SCRIPT = '''
"""A user's script with a kernel of its own: it belongs to __main__, here and in the child."""
import multiprocessing
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
import numpy as np
import flexmb as fm
from flexmb.engine.compiled.records import Record
import kernels_of_a_user as user

@fm.element_kernel
def cubic_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    k, d = p
    x = q[0] - q[1]
    r[0] = k * x**3
    r[1] = -r[0]
    K[0, 0] = K[1, 1] = 3.0 * k * x * x
    K[0, 1] = K[1, 0] = -K[0, 0]

@dataclass(frozen=True)
class Cubic(user.Coil):
    kernel = cubic_kernel

if __name__ == "__main__":
    program = fm.compile(user.pendulum(Cubic))
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
        there = pool.submit(user.motion, program).result(timeout=300)
    assert np.array_equal(there, user.motion(program))
    assert not np.array_equal(there, user.motion(fm.compile(user.pendulum())))
    print("same bits")
'''


def child(arguments, **more):
    """Output of a child process."""
    done = subprocess.run(
        [sys.executable, *arguments], env=environment(**more), capture_output=True, text=True, timeout=500, check=False
    )
    assert done.returncode == 0, done.stderr[-3000:]
    return done.stdout


@pytest.mark.slow
def test_kernel_of_a_script_in_a_spawned_process(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(SCRIPT)
    assert child([str(script)]) == "same bits\n"


SAVE = """
import sys, numpy as np, flexmb as fm, kernels_of_a_user as u
np.save(sys.argv[1], u.motion(fm.compile(u.pendulum())))
"""


@pytest.mark.slow
def test_without_the_compiler_the_motion_is_the_same(user, tmp_path):
    """NUMBA_DISABLE_JIT=1 runs the same code in Python; only the last bits may differ.

    The run takes 100 steps of free fall and contact; differences grow by the stiffness of the contact.
    """
    child(["-c", SAVE, str(tmp_path / "plain.npy")], NUMBA_DISABLE_JIT="1")
    plain, compiled = np.load(tmp_path / "plain.npy"), user.motion(fm.compile(user.pendulum()))
    assert plain.shape == compiled.shape
    size = np.abs(compiled).max(axis=0)
    error = np.abs(plain - compiled).max(axis=0)[size > 0.0] / size[size > 0.0]
    assert error.max() < 1e-7


def cache_files(folder):
    return {path: path.stat().st_mtime_ns for path in Path(folder).rglob("*.nb[ic]")}


@pytest.mark.slow
def test_second_process_compiles_nothing(tmp_path):
    """Two processes in turn with the same cache: the second one writes no file, and so compiled nothing."""
    folder = os.environ["NUMBA_CACHE_DIR"]
    child(["-c", SAVE, str(tmp_path / "first.npy")])
    before = cache_files(folder)
    child(["-c", SAVE, str(tmp_path / "second.npy")])
    assert len(before) > 30
    assert cache_files(folder) == before
    np.testing.assert_array_equal(np.load(tmp_path / "first.npy"), np.load(tmp_path / "second.npy"))


COUNT = """
import flexmb as fm, kernels_of_a_user as u
from flexmb.engine.newmark.method import advance
u.motion(fm.compile(u.pendulum()))
link = fm.RigidLink("a", (0.0, 0.0), (0.2, 0.0), mass=0.5, inertia=2e-3)
u.motion(fm.compile(fm.Mechanism("b", [link, fm.Revolute("O", fm.GROUND, link, at=(0.0, 0.0))])))
print(len(advance.signatures), sum(advance.stats.cache_misses.values()), sum(advance.stats.cache_hits.values()))
"""


@pytest.mark.slow
def test_loop_is_compiled_once_for_all_models(tmp_path, user):
    """Two models in a later process: one signature of the loop, taken from the cache."""
    user.motion(fm.compile(user.pendulum()))
    assert child(["-c", COUNT]).split() == ["1", "0", "1"]
