"""Laws that return their force alone: derivatives exact to round-off, compiled, pickled, and errors that say where."""

import math
import os
import pickle
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import flexmb as fm
from flexmb.engine.derivatives import expressions as rules
from flexmb.engine.derivatives.forward import differentiated
from flexmb.engine.derivatives.source import source_of
from flexmb.errors import KernelError
from flexmb.parts.contact.friction import modified_coulomb_kernel
from flexmb.parts.contact.hysteresis import hysteresis_kernel

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))  # where a user's own module would lie
import laws_alone as user  # noqa: E402

sys.path.remove(str(HERE))


def both(kernel, p, *numbers, z=(0.0,), jit=False):
    """Value and derivatives of a law, from Python or from machine code."""
    function = kernel.dispatcher if jit else kernel.python
    return np.array(function(np.array(p), *numbers, np.array(z), np.array(z)))


@pytest.mark.parametrize("jit", [False, True], ids=["python", "compiled"])
@pytest.mark.parametrize("kernel", user.BY_HAND, ids=lambda k: k.name)
def test_exact(kernel, jit):
    """Against derivatives found by hand: round-off, where 1e-8 is asked for."""
    by_hand, p = user.BY_HAND[kernel]
    random = np.random.default_rng(1)
    for gap in (*random.uniform(-5e-3, 5e-3, 60), *-np.geomspace(1e-9, 1e-3, 20)):
        rate = float(random.uniform(-3.0, 3.0))
        expected = np.array(by_hand(p, float(gap), rate))
        found = both(kernel, p, 0.0, float(gap), rate, jit=jit)
        scale = np.abs(expected) + np.abs(expected[0]) / np.array([1.0, abs(gap), abs(rate)])
        assert np.all(np.abs(found - expected) <= 1e-13 * scale), (gap, rate)


gaps = st.floats(-1e-3, 1e-4).filter(lambda x: x == 0.0 or abs(x) > 1e-100)  # no forces that underflow


@given(
    gap=gaps, rate=st.floats(-2.0, 2.0), h=st.sampled_from([0.0, 1e-6, 1e-4, 3e-3]),
    z=st.sampled_from([(0.0, 1e-4, -0.3), (0.4, -1e-5, 0.1), (0.0, 1.0, 0.0), (0.0, 2e-4, -1.0)]),
)  # fmt: skip
def test_the_same_as_the_library_by_hand(gap, rate, h, z):
    """Through the search for the crossing: a loop with its own conditions; the library knows its derivative."""
    p = (1e9, 1.5, 0.8, 1e-3)
    law = fm.LankaraniNikravesh(stiffness=1e9, restitution=0.8, least_approach=1e-3)
    begin = (*z, z[0], *law.history()[len(z) + 1 :])  # the library's law also keeps what it has to remark
    reached = np.zeros(len(begin))
    law.kernel.python(np.array(law.parameters()), h, gap, rate, np.array(begin), reached)
    assume(gap > 0.0 or reached[3] >= 1e-3)  # slower contacts follow their largest speed
    expected = both(law.kernel, law.parameters(), h, gap, rate, z=begin)
    found = both(user.lankarani_nikravesh_alone, p, h, gap, rate, z=z)
    elastic = 1e9 * max(-gap, 0.0) ** 1.5 * (1.0 + abs(rate) / 1e-3)  # before the damping takes from it
    assert abs(found[0] - expected[0]) <= 1e-14 * elastic
    scale = np.abs(expected) + elastic / np.array([1.0, abs(gap) or 1.0, max(abs(rate), 1e-3)])
    assert np.all(np.abs(found - expected) <= 1e-10 * scale)


def test_friction_law():
    p = (0.2, 1e-4, 1e-3)
    for slip in (-2e-3, -5e-4, 5e-5, 4e-4, 0.3):
        expected = both(modified_coulomb_kernel, p, 1e-5, slip, 30.0)
        assert both(user.coulomb_alone, p, 1e-5, slip, 30.0, jit=True) == pytest.approx(expected, rel=1e-13)


POINTS = {"acosh": (1.7, 4.2), "log": (0.3, 5.0), "log2": (0.3, 5.0), "log10": (0.3, 5.0), "sqrt": (0.2, 3.0)}


@pytest.mark.parametrize("name", sorted(rules.UNARY))
def test_rule_of_every_elementary_function(name):
    """Against differences of sixth order."""
    function = getattr(math, name, None) or getattr(np, name)
    formula = rules.UNARY[name]
    for x in POINTS.get(name, (-0.7, 0.3, 0.8)):
        found = eval(formula, {"_math": math, "_np": np, "x": x, "f": function(x)})
        h = 2e-3 * abs(x)
        d = [(function(x + k * h) - function(x - k * h)) / (2.0 * k * h) for k in (1, 2, 3)]
        assert found == pytest.approx(1.5 * d[0] - 0.6 * d[1] + 0.1 * d[2], rel=1e-8)


@pytest.mark.parametrize("name", sorted(rules.BINARY))
def test_rule_of_every_function_of_two_numbers(name):
    function, h = getattr(math, name), 1e-4
    for x, y in ((0.7, 1.1), (-0.4, 2.3), (1.9, -0.6)):
        names = {"_math": math, "x": x, "y": y, "f": function(x, y)}
        by_x, by_y = (eval(formula, names) for formula in rules.BINARY[name])
        assert by_x == pytest.approx((function(x + h, y) - function(x - h, y)) / (2 * h), abs=1e-7)
        assert by_y == pytest.approx((function(x, y + h) - function(x, y - h)) / (2 * h), abs=1e-7)


def test_powers_at_nought():
    """x^n, n >= 1, closes without a division by zero; sqrt and x^0.5 give 0 where the slope has no bound."""

    def law(p, x, y):
        return x ** p[0] + math.sqrt(y)

    function, _ = differentiated(source_of(law), ["x", "y"])
    assert function((1.0,), 0.0, 0.0) == (0.0, 1.0, 0.0)
    assert function((1.5,), 0.0, 4.0) == (2.0, 0.0, 0.25)
    assert function((0.5,), 0.0, 4.0) == (2.0, 0.0, 0.25)


def made_with(stiffness):
    """A law that closes over a number of its surroundings."""

    @fm.normal_law
    def closed_over(p, h, gap, gap_rate, z, z_new):
        return stiffness * gap * gap

    return closed_over


def test_surroundings_are_kept_apart_and_pickled():
    """Two laws of one text: their machine code may not be exchanged, neither in memory nor on disk."""
    for stiffness in (3.0, 5.0):
        kernel = made_with(stiffness)
        for copy in (kernel, pickle.loads(pickle.dumps(kernel))):  # noqa: S301
            for jit in (False, True):
                assert both(copy, (1.0,), 0.0, -2.0, 0.0, jit=jit) == pytest.approx(
                    [4.0 * stiffness, -4.0 * stiffness, 0.0]
                )


def test_law_that_returns_three_numbers_is_left_alone():
    assert hysteresis_kernel.python is hysteresis_kernel.function


# -- in mechanisms ---------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Alone(fm.NormalLaw):
    """A user's law."""

    k: float = 1e8
    n: float = 1.5
    a: float = 0.5
    kernel = user.hunt_crossley


@dataclass(frozen=True)
class CoulombAlone(fm.FrictionLaw):
    """A user's friction."""

    mu: float = 0.2
    v0: float = 1e-4
    v1: float = 1e-3
    kernel = user.coulomb_alone


def pendulum(normal, friction):
    bob = fm.RigidLink("bob", (0.0, 0.0), (0.2, 0.0), mass=0.5, inertia=2e-3)
    pin = fm.RevoluteClearance(
        "pin", fm.GROUND, bob, (0.0, 0.0), clearance=1e-4, bearing_radius=5e-3, normal=normal, friction=friction
    )
    return fm.Mechanism("pendulum", [bob, pin], gravity=(0.0, -9.81))


def test_check_part_takes_them():
    report = fm.testing.check_part(pendulum(Alone(), CoulombAlone()), "pin")
    assert "dN_dgap" in str(report)


def test_motion_is_that_of_the_law_with_its_derivatives():
    """Newton finds the same step, so the same motion up to its tolerance."""
    sols = [
        fm.simulate(pendulum(Alone(), friction), t_end=0.02, step=1e-5, save="steps")
        for friction in (CoulombAlone(), fm.ModifiedCoulomb(0.2, v0=1e-4, v1=1e-3))
    ]
    assert all(sol.ok for sol in sols)
    np.testing.assert_allclose(sols[0].array("bob.y"), sols[1].array("bob.y"), rtol=0.0, atol=1e-14)


@pytest.mark.parametrize("jit", ["0", "1"])
def test_in_other_processes_and_without_compilation(jit):
    code = (
        "import numpy as np, laws_alone as u\n"
        "f = u.hunt_crossley.dispatcher if not {jit} else u.hunt_crossley.python\n"
        "print(*f(np.array([1e8, 1.3, 0.4]), 0.0, -1e-4, -0.5, np.zeros(1), np.zeros(1)))"
    ).replace("{jit}", jit)
    path = os.pathsep.join([str(HERE), *sys.path])
    environment = {**os.environ, "NUMBA_DISABLE_JIT": jit, "PYTHONPATH": path}
    found = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    expected = user.hunt_crossley_by_hand((1e8, 1.3, 0.4), -1e-4, -0.5)
    assert [float(x) for x in found.stdout.split()] == pytest.approx(expected, rel=1e-13)


def test_machine_code_lies_on_disk(tmp_path):
    """A second process compiles nothing."""
    code = (
        "import numpy as np, laws_alone as u\n"
        "d = u.hunt_crossley.dispatcher\n"
        "print(sum(d.stats.cache_hits.values()), sum(d.stats.cache_misses.values()))"
    )
    path = os.pathsep.join([str(HERE), *sys.path])
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path), "PYTHONPATH": path, "NUMBA_DISABLE_JIT": "0"}
    counts = [
        subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True).stdout
        for _ in range(2)
    ]
    assert [c.split() for c in counts] == [["0", "1"], ["1", "0"]]


# -- errors ----------------------------------------------------------------------------------------------------------


def reads_history(p, h, gap, gap_rate, z, z_new):
    z_new[0] = gap
    return p[0] * z_new[0]


def puts_into_an_array(p, h, gap, gap_rate, z, z_new):
    work = np.zeros(2)
    work[0] = gap
    return p[0] * work[0]


def unknown_function(p, h, gap, gap_rate, z, z_new):
    k = p[0]
    return k * np.sinc(gap)


def comprehension(p, h, gap, gap_rate, z, z_new):
    return sum([gap * x for x in p])


def two_kinds(p, h, gap, gap_rate, z, z_new):
    if gap > 0.0:
        return 0.0
    return -p[0] * gap, -p[0], 0.0


def endless(p, h, gap, gap_rate, z, z_new):
    return step_down(gap, 3)


def step_down(x, n):
    return x if n == 0 else step_down(x, n - 1)


def caught(p, h, gap, gap_rate, z, z_new):
    try:
        return p[0] / gap
    except ZeroDivisionError:
        return 0.0


@pytest.mark.parametrize(
    ("function", "line", "message"),
    [
        (reads_history, 2, r"'z_new\[0\]' is read after it was written; keep the number in a variable"),
        (puts_into_an_array, 2, r"a number that depends on the motion is put into work\[0\]"),
        (unknown_function, 2, r"the function 'np.sinc' is not known, or its text cannot be read"),
        (comprehension, 1, "the function 'sum' is not known"),
        (two_kinds, 3, "there are 1 number returned in line [0-9]+ and 3 in line"),
        (caught, 1, "a statement of the kind 'Try' is not known"),
    ],
)
def test_what_cannot_be_differentiated_is_named(function, line, message):
    place = function.__code__.co_firstlineno + line
    with pytest.raises(
        KernelError, match=rf"{function.__name__}', test_force_alone.py line {place}: {message}.*three n"
    ):
        fm.normal_law(function).python  # noqa: B018 - it is made when it is first used


def test_recursion_is_refused():
    with pytest.raises(KernelError, match=r"step_down', test_force_alone.py line .*: it calls itself"):
        fm.normal_law(endless).python  # noqa: B018


def test_force_alone_without_a_source():
    space = {}
    exec("def typed_in(p, h, gap, gap_rate, z, z_new):\n    return -gap if gap < 0.0 else 0.0", space)

    @dataclass(frozen=True)
    class TypedIn(fm.NormalLaw):
        kernel = fm.normal_law(space["typed_in"])

    with pytest.raises(
        KernelError, match=r"TypedIn returned .*must return 3 numbers. The derivatives of a force alone"
    ):
        fm.compile(pendulum(TypedIn(), fm.friction.Frictionless()))


def wrong_in_line_two(p, h, gap, gap_rate, z, z_new):
    k = p[0]
    return k * missing * gap  # noqa: F821 - the mistake under test


def test_tracebacks_point_at_the_users_text():
    with pytest.raises(NameError) as caught_error:
        fm.normal_law(wrong_in_line_two).python((1.0,), 0.0, -1.0, 0.0, (), ())
    last = caught_error.traceback[-1]
    assert (last.path.name, last.lineno + 1) == (Path(__file__).name, wrong_in_line_two.__code__.co_firstlineno + 2)
