"""Laws that return their force alone: derivatives by differences, compiled, pickled, and errors with a remedy."""

import linecache
import math
import os
import pickle
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import numba
import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import flexmb as fm
from flexmb.errors import KernelError
from flexmb.parts.contact.hysteresis import hysteresis_kernel

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))  # where a user's own module would lie
import laws_alone as user  # noqa: E402

sys.path.remove(str(HERE))

SIZES = [0.0, *np.geomspace(1e-12, 1.0, 26)]


def both(kernel, p, *numbers, z=(0.0,), jit=False):
    """Value and derivatives of a law, from Python or from machine code."""
    function = kernel.dispatcher if jit else kernel.python
    return np.array(function(np.array(p), *numbers, np.array(z), np.array(z)))


@pytest.mark.quick(1)
@pytest.mark.parametrize("jit", [False, True], ids=["python", "compiled"])
@pytest.mark.parametrize("kernel", user.BY_HAND, ids=lambda k: k.name)
def test_normal_laws_over_all_orders_of_size(kernel, jit):
    """Against derivatives found by hand; to a rate below 1e-9 m/s belongs the round-off of N over 1e-9 m/s."""
    by_hand, p = user.BY_HAND[kernel]
    for depth in SIZES[1:]:
        for rate in (*SIZES, *np.negative(SIZES)):
            gap = -float(depth)
            expected = np.array(by_hand(p, gap, float(rate)))
            found = both(kernel, p, 0.0, gap, float(rate), jit=jit)
            force = abs(expected[0])
            scale = np.array([1e-13 * force, 2e-9 * (abs(expected[1]) + force / depth), 0.0])
            scale[2] = 2e-9 * abs(expected[2]) + 4e-16 * force / max(1e-9, 6e-6 * abs(rate))
            assert np.all(np.abs(found - expected) <= scale), (gap, rate, found, expected)


SMALL = 1e-12
"""Depth [m] below which differences of 1e-16 m are no longer small."""

gaps = st.floats(-1e-3, 1e-4).filter(lambda x: abs(x) > SMALL)


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
    # slower contacts follow their largest speed; of a grazing crossing the root is known to the root of round-off
    assume(gap > 0.0 or reached[3] > max(1.001e-3, 0.1 * abs(rate)))
    expected = both(law.kernel, law.parameters(), h, gap, rate, z=begin)
    found = both(user.lankarani_nikravesh_alone, p, h, gap, rate, z=z)
    elastic = 1e9 * max(-gap, 0.0) ** 1.5 * (1.0 + abs(rate) / 1e-3)  # before the damping takes from it
    assert abs(found[0] - expected[0]) <= 1e-14 * elastic
    scale = np.abs(expected) + elastic / np.array([1.0, abs(gap), max(abs(rate), 1e-3)])
    assert np.all(np.abs(found - expected) <= 1e-8 * scale)


def test_the_edge_of_a_contact_is_nearly_without_stiffness():
    """At gap 0 the slope is that of the first 1e-16 m: 5 N/m, where a load of 1 N finds 1.5e6 N/m."""
    assert both(user.hertz, (1e9, 1.5), 0.0, 0.0, 0.3) == pytest.approx([0.0, 0.0, 0.0], abs=6.0)


@pytest.mark.parametrize("v0", [1e-6, 1e-4, 1e-2])
@pytest.mark.parametrize("load", [0.0, 1e-6, 1.0, 1e5])
def test_smooth_friction_over_all_orders_of_size(v0, load):
    """Zones down to 1e-6 m/s; at rest as elsewhere."""
    for size in SIZES:
        for slip in (float(size), -float(size)):
            share, slope = math.tanh(slip / v0), 1.0 / math.cosh(min(abs(slip) / v0, 300.0)) ** 2 / v0
            found = both(user.smooth_alone, (0.3, v0), 1e-5, slip, load)
            assert found[0] == pytest.approx(-0.3 * load * share, rel=1e-14)
            assert found[1] == pytest.approx(-0.3 * load * slope, rel=1e-6, abs=1e-6 * load)
            assert found[2] == pytest.approx(-0.3 * share, rel=1e-6)


@pytest.mark.parametrize("slip", [-2e-3, -5e-4, 5e-5, 4e-4, 0.3])
def test_friction_with_corners_beside_them(slip):
    p = (0.2, 1e-4, 1e-3)
    expected = both(fm.ModifiedCoulomb(*p).kernel, p, 1e-5, slip, 30.0)
    assert both(user.coulomb_alone, p, 1e-5, slip, 30.0, jit=True) == pytest.approx(expected, rel=1e-9)


def rubs_by_the_root(p, h, slip, N, z, z_new):
    return -p[0] * slip * math.sqrt(N)


def kinked(p, h, slip, N, z, z_new):
    """Slopes -1 and -3 on both sides of rest."""
    return -N * (slip if slip > 0.0 else 3.0 * slip)


def remembers(p, h, gap, gap_rate, z, z_new):
    z_new[0] = gap
    return p[0] * z_new[0]


def uses_arrays(p, h, gap, gap_rate, z, z_new):
    work = np.zeros(2)
    work[0] = gap
    return p[0] * work[0] + sum([0.0 * x for x in p])


def test_normal_forces_stay_positive():
    assert both(fm.friction_law(rubs_by_the_root), (0.1,), 0.0, 1e-3, 0.0)[:2] == pytest.approx([0.0, 0.0])


def test_a_kink_has_the_mean_slope():
    assert both(fm.friction_law(kinked), (), 0.0, 0.0, 5.0)[1] == pytest.approx(-10.0, rel=1e-9)
    assert both(fm.friction_law(kinked), (), 0.0, 1e-8, 5.0)[1] == pytest.approx(-5.0, rel=1e-9)


@pytest.mark.parametrize("jit", [False, True], ids=["python", "compiled"])
def test_the_history_is_that_of_the_state_itself(jit):
    kernel, new = fm.normal_law(remembers), np.zeros(1)
    found = (kernel.dispatcher if jit else kernel.python)(np.array([-2.0]), 0.0, -0.3, 0.1, np.zeros(1), new)
    assert new[0] == -0.3
    assert found == pytest.approx((0.6, -2.0, 0.0), rel=1e-9)


@pytest.mark.slow
def test_all_that_numba_compiles_is_allowed():
    assert both(fm.normal_law(uses_arrays), (-3.0,), 0.0, -0.5, 0.2, jit=True) == pytest.approx([1.5, -3.0, 0.0])


def made_with(stiffness):
    """A law that closes over a number of its surroundings."""

    @fm.normal_law
    def closed_over(p, h, gap, gap_rate, z, z_new):
        return stiffness * gap * gap

    return closed_over


@pytest.mark.slow
def test_surroundings_are_kept_apart_and_pickled():
    """Two laws of one text: their machine code may not be exchanged, neither in memory nor on disk."""
    for stiffness in (3.0, 5.0):
        kernel = made_with(stiffness)
        for copy in (kernel, pickle.loads(pickle.dumps(kernel))):  # noqa: S301
            for jit in (False, True):
                assert both(copy, (1.0,), 0.0, -2.0, 0.0, jit=jit) == pytest.approx(
                    [4.0 * stiffness, -4.0 * stiffness, 0.0]
                )


def test_laws_of_the_library_are_left_alone():
    assert hysteresis_kernel.python.__code__ is hysteresis_kernel.function.__code__
    assert not hysteresis_kernel.is_alone


# -- in mechanisms ---------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Alone(fm.NormalLaw):
    """A user's law."""

    k: float = 1e8
    n: float = 1.5
    a: float = 0.5
    kernel = user.hunt_crossley


@dataclass(frozen=True)
class Given(Alone):
    """The same law with its derivatives."""

    kernel = user.hunt_crossley_given


@dataclass(frozen=True)
class CoulombAlone(fm.FrictionLaw):
    """A user's friction."""

    mu: float = 0.2
    v0: float = 1e-4
    v1: float = 1e-3
    kernel = user.coulomb_alone


@dataclass(frozen=True)
class SmoothAlone(fm.FrictionLaw):
    """Another user's friction."""

    mu: float = 0.3
    v0: float = 1e-4
    kernel = user.smooth_alone


def pendulum(normal, friction):
    bob = fm.RigidLink("bob", (0.0, 0.0), (0.2, 0.0), mass=0.5, inertia=2e-3)
    pin = fm.RevoluteClearance(
        "pin", fm.GROUND, bob, (0.0, 0.0), clearance=1e-4, bearing_radius=5e-3, normal=normal, friction=friction
    )
    return fm.Mechanism("pendulum", [bob, pin], gravity=(0.0, -9.81))


def sled(friction):
    """A block that slides on the floor of its guide until it rests."""
    block = fm.RigidBody("block", at=(0.0, 0.0), mass=1.0, inertia=1e-3, velocity=(0.02, 0.0, 0.0))
    law = fm.contact.ExactRestitution(stiffness=1e8, restitution=0.3)
    sizes = {"clearance": 1e-4, "half_length": 0.05, "half_height": 0.02}
    guide = fm.PrismaticClearance("G", fm.GROUND, block, normal=law, friction=friction, **sizes)
    return fm.Mechanism("sled", [block, guide], gravity=(0.0, -9.81))


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


@pytest.mark.parametrize("options", [{}, {"step": 1e-5}], ids=["adaptive", "fixed"])
def test_steps_and_iterations_are_those_of_the_law_with_its_derivatives(options):
    alone, given = (
        fm.simulate(pendulum(normal, friction), t_end=0.02, save="steps", **options)
        for normal, friction in (
            (Alone(), CoulombAlone()),
            (Given(), fm.ModifiedCoulomb(0.2, v0=1e-4, v1=1e-3)),
        )
    )
    assert len(alone.episodes("pin")) == len(given.episodes("pin")) > 1
    for name in ("steps", "rejected", "not_converged"):
        assert getattr(alone.stats, name) == getattr(given.stats, name)
    assert alone.stats.newton_iterations == pytest.approx(given.stats.newton_iterations, rel=0.01)
    for name in ("bob.y", "bob.vy", "bob.omega", "pin.normal_force"):
        wanted = given.array(name)
        np.testing.assert_allclose(alone.array(name), wanted, rtol=0.0, atol=1e-8 * np.abs(wanted).max())


@pytest.mark.parametrize("v0", [1e-6, 1e-4])
def test_newton_needs_no_more_iterations_down_to_rest(v0):
    sols = [
        fm.simulate(sled(law), t_end=0.04, step=1e-5, save="steps")
        for law in (SmoothAlone(0.3, v0), fm.friction.SmoothCoulomb(0.3, v0=v0))
    ]
    alone, given = (sol.stats.newton_iterations for sol in sols)
    assert abs(sols[0].array("block.vx")[-1]) < 1e-9  # from 0.02 m/s
    assert alone <= given + 1


def of_another_process(cache, jit):
    """Value and derivatives of a law, and what the compiler did, in a process with a cache of its own."""
    function = "u.hunt_crossley.python" if jit == "1" else "u.hunt_crossley.dispatcher"
    code = (
        "import numpy as np, laws_alone as u\n"
        f"f = {function}\n"
        "print(*f(np.array([1e8, 1.3, 0.4]), 0.0, -1e-4, -0.5, np.zeros(1), np.zeros(1)))\n"
        "s = getattr(f, 'stats', None)\n"
        "print(*(() if s is None else (sum(s.cache_hits.values()), sum(s.cache_misses.values()))))"
    )
    path = os.pathsep.join([str(HERE), *sys.path])
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(cache), "PYTHONPATH": path, "NUMBA_DISABLE_JIT": jit}
    call = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    values, counts = call.stdout.splitlines()
    expected = user.hunt_crossley_by_hand((1e8, 1.3, 0.4), -1e-4, -0.5)
    assert [float(x) for x in values.split()] == pytest.approx(expected, rel=1e-9)
    return counts.split()


@pytest.mark.slow
def test_in_other_processes_and_machine_code_lies_on_disk(tmp_path):
    """A second process compiles nothing."""
    assert of_another_process(tmp_path, "0") == ["0", "1"]
    assert of_another_process(tmp_path, "0") == ["1", "0"]


@pytest.mark.slow
def test_without_compilation(tmp_path):
    assert of_another_process(tmp_path, "1") == []


# -- errors ----------------------------------------------------------------------------------------------------------


def two_kinds(p, h, gap, gap_rate, z, z_new):
    if gap > 0.0:
        return 0.0
    return -p[0] * gap, -p[0], 0.0


def asks_the_machine(p, h, gap, gap_rate, z, z_new):
    return p[0] * gap * len(os.environ)


@pytest.mark.parametrize("function", [two_kinds, asks_the_machine])
def test_what_numba_cannot_compile_is_named_with_a_remedy(function):
    words = rf"(?s)'{function.__name__}' cannot be compiled as normal: .*Write it with what numba compiles"
    with pytest.raises(KernelError, match=words):
        _ = fm.normal_law(function).dispatcher


def doubled(x):
    return 2.0 * x


@numba.njit
def doubled_twice(x):
    return 2.0 * doubled(x)


def calls(helper, number):
    """A law that calls a function, and one that hands over derivatives beside."""

    def calling(p, h, gap, gap_rate, z, z_new):
        return helper(gap)

    def calling_for_three(p, h, gap, gap_rate, z, z_new):
        return helper(gap), 2.0, 0.0

    return calling if number == 1 else calling_for_three


@pytest.mark.parametrize("number", [1, 3])
@pytest.mark.parametrize(("helper", "named"), [(doubled, "helper"), (doubled_twice, "doubled")])
def test_a_helper_that_is_not_compiled_is_named(helper, named, number):
    function = calls(helper, number)
    words = rf"(?s)'{function.__qualname__}' cannot be compiled as normal: .*It calls '{named}', which .*`@numba.njit`"
    with pytest.raises(KernelError, match=words):
        _ = fm.normal_law(function).dispatcher


def test_a_compiled_helper_is_taken():
    assert both(fm.normal_law(calls(numba.njit(doubled), 1)), (), 0.0, -0.5, 0.2, jit=True) == pytest.approx(
        [-1.0, 2.0, 0.0]
    )


def returns_two(p, h, gap, gap_rate, z, z_new):
    return -gap, -1.0


def returns_nothing(p, h, gap, gap_rate, z, z_new):
    z_new[0] = gap


def returns_a_word(p, h, gap, gap_rate, z, z_new):
    return "force"


@pytest.mark.parametrize("function", [returns_two, returns_nothing, returns_a_word])
def test_other_numbers_of_results_are_refused(function):
    @dataclass(frozen=True)
    class Wrong(fm.NormalLaw):
        kernel = fm.normal_law(function)

        def history(self):
            return (0.0,)

    with pytest.raises(KernelError, match=r"Part 'pin': Wrong returned .*; it must return 3 numbers"):
        fm.compile(pendulum(Wrong(), fm.friction.Frictionless()))
    with pytest.raises(KernelError, match=rf"'{function.__name__}' cannot be compiled as normal"):
        _ = fm.normal_law(function).dispatcher


def test_typed_in_laws_need_no_file():
    space = {}
    exec("def typed_in(p, h, gap, gap_rate, z, z_new):\n    return -5.0 * gap if gap < 0.0 else 0.0", space)
    kernel = fm.normal_law(space["typed_in"])
    for jit in (False, True):
        assert both(kernel, (), 0.0, -0.2, 0.0, jit=jit) == pytest.approx([1.0, -5.0, 0.0], rel=1e-9)


def test_the_text_of_a_law_typed_into_a_notebook_counts_in_every_process():
    text = "def noted(p, h, gap, gap_rate, z, z_new):\n    return -5.0 * gap if gap < 0.0 else 0.0\n"
    space, name = {"__name__": "__main__"}, "<cell 1>"
    linecache.cache[name] = (len(text), None, text.splitlines(keepends=True), name)
    exec(compile(text, name, "exec"), space)
    kernel = fm.normal_law(space["noted"])
    data, identity = pickle.dumps(kernel), kernel.identity
    del linecache.cache[name]  # as in a process of a pool
    assert "5.0" in identity
    assert pickle.loads(data).identity == identity  # noqa: S301


def wrong_in_line_two(p, h, gap, gap_rate, z, z_new):
    k = p[0]
    return k * missing * gap  # noqa: F821 - the mistake under test


def test_tracebacks_point_at_the_users_text():
    with pytest.raises(NameError) as caught_error:
        fm.normal_law(wrong_in_line_two).python((1.0,), 0.0, -1.0, 0.0, (), ())
    last = caught_error.traceback[-1]
    assert (last.path.name, last.lineno + 1) == (Path(__file__).name, wrong_in_line_two.__code__.co_firstlineno + 2)
