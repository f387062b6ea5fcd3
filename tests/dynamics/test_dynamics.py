"""What every kind of `Dynamics` must do, whatever it is: one set of questions for all of them."""

import mechanisms
import numpy as np
import pytest
import systems
from cases import slow_where

import flexmb as fm
from flexmb.errors import InputError


def section_of(flow, signal, direction="up", level=0.0):
    section = fm.chaos.SectionMap(flow, signal, direction=direction, level=level)
    section.advance(1)
    return section


def started(flow, duration=0.7):
    flow.advance(duration)
    return flow


def striking():
    return systems.ImpactOscillator(w=2.65).flow()


KINDS = {
    "map": systems.henon,
    "map without jacobian": lambda: fm.chaos.Map(lambda x: [np.sin(x[1]), x[0] - x[1] ** 2], [0.3, 0.1]),
    "ode": lambda: started(systems.lorenz()),
    "ode without jacobian": lambda: started(systems.van_der_pol()),
    "stiff ode": lambda: started(systems.van_der_pol(rtol=1e-8, method="Radau")),
    "driven ode": lambda: started(systems.pendulum()),
    "impacts": lambda: started(striking()),
    "stroboscopic": lambda: fm.chaos.StroboscopicMap(systems.pendulum()),
    "stroboscopic of impacts": lambda: fm.chaos.StroboscopicMap(striking()),
    "section": lambda: section_of(systems.lorenz(), "z", level=27.0),
    "section both ways": lambda: section_of(systems.van_der_pol(), "x", "both"),
    "section of a driven flow": lambda: section_of(systems.pendulum(), "v"),
    "mechanism": lambda: started(mechanisms.rod_flow()),
    "stroboscopic of a mechanism": lambda: fm.chaos.StroboscopicMap(mechanisms.rod_flow()),
    "section of a mechanism": lambda: section_of(started(mechanisms.rod_flow()), "rod.omega"),
}
"""Each stands somewhere it can be advanced from."""

EXACT = {"map", "map without jacobian"}


def held():
    """The rod with its positions alone held: of that form the tangents are those of the steps to the last digits."""
    method = fm.Newmark.generalised_alpha(constraints="position")
    return fm.chaos.MechanismFlow(mechanisms.rod(), period=systems.TURN, step=systems.TURN / 400, method=method)


HELD = {
    "mechanism": lambda: started(held()),
    "stroboscopic of a mechanism": lambda: fm.chaos.StroboscopicMap(held()),
    "section of a mechanism": lambda: section_of(started(held()), "rod.omega"),
}
MECHANISMS = {name for name in KINDS if "mechanism" in name}


@pytest.fixture(params=slow_where(lambda n: n == "section of a mechanism", KINDS))
def name(request):
    return request.param


@pytest.fixture
def system(name):
    return KINDS[name]()


def span(system):
    return 0.5 if system.unit == "s" else 1


def tolerance(name):
    """Of states after some advancing: rtol of the solvers times what the motion makes of it, or that of a step."""
    return 0.0 if name in EXACT else 1e-5 if name in MECHANISMS else 2e-7


def free(name):
    """Numbers of a state that the others do not determine; accelerations of a mechanism are those of its steps."""
    return slice(0, 6) if name in MECHANISMS else slice(None)


def size_of(x):
    return max(1.0, float(np.abs(x).max()))


def allowed(system, k, seed=3):
    """k differences of states that stay in a section."""
    W = system.on_manifold(np.random.default_rng(seed).standard_normal((system.size, k + 1)))
    if isinstance(system, fm.chaos.SectionMap):
        across = W[system.names.index(system.signal)]
        W -= np.outer(W[:, k], across / across[k])
    return np.ascontiguousarray(W[:, :k])


def carried(system, W, duration):
    """A copy of the system `duration` later, and W carried there."""
    other, T = system.copy(), W.copy()
    assert other.advance(duration, T), other.status
    return other, T


def test_it_describes_itself(system):
    assert isinstance(system, fm.chaos.Dynamics)
    assert system.ok
    assert len(system.names) == len(system.units) == len(system.observe())
    assert system.state().shape == (system.size,) == system.weights.shape
    assert (system.weights >= 0.0).all()
    assert 1 <= system.dimension <= system.size
    assert system.unit in {"s", "iterations", "periods", "crossings"}


def test_what_it_hands_out_is_a_copy(system):
    before = system.state()
    system.state()[:] = np.nan
    system.observe()[:] = np.nan
    assert np.array_equal(system.state(), before)
    assert np.isfinite(system.observe()).all()


@pytest.mark.quick(8)
def test_advance_in_two_parts_is_advance_at_once(name, system):
    one, two, step = system.copy(), system.copy(), span(system)
    began = system.time
    assert one.advance(2 * step)
    assert two.advance(step)
    assert two.advance(step)
    assert one.time == pytest.approx(began + 2 * step, rel=1e-12)
    assert two.time == pytest.approx(one.time, rel=1e-12)
    assert np.abs(one.state() - two.state())[free(name)].max() <= tolerance(name) * size_of(one.state())


def test_copies_go_their_own_way_and_the_same_one(system):
    before, other = system.state(), system.copy()
    assert other.advance(span(system))
    assert np.array_equal(system.state(), before)
    again = system.copy()
    assert again.advance(span(system))
    assert np.array_equal(again.state(), other.state())


@pytest.mark.quick(8)
def test_reset_to_a_state_goes_on_from_there(name, system):
    there, time = system.state(), system.time
    ahead = system.copy()
    assert ahead.advance(span(system))
    system.advance(2 * span(system))
    system.reset(there, time=time)
    assert system.ok
    assert system.time == time
    close = 1e-12 if name in MECHANISMS else 0.0
    assert np.abs(system.state() - there)[free(name)].max() <= close * size_of(there)
    assert system.advance(span(system))
    assert np.abs(system.state() - ahead.state())[free(name)].max() <= tolerance(name) * size_of(there)


def test_reset_goes_to_its_own_start(system):
    system.reset()
    start = system.state()
    system.advance(span(system))
    system.reset()
    assert np.array_equal(system.state(), start)


def test_states_that_are_none_are_refused(system):
    with pytest.raises(InputError, match="state"):
        system.reset(np.zeros(system.size + 1))
    with pytest.raises(InputError, match="state"):
        system.reset(np.full(system.size, np.nan))


def test_unknown_parameters_are_refused(system):
    with pytest.raises(fm.errors.FlexmbError):
        system.reset(parameters={"no such thing": 1.0})


@pytest.mark.quick(4)
def test_tangents_are_linear(system):
    W = allowed(system, 2)
    both = np.ascontiguousarray((W @ [0.3, -2.0])[:, None])
    _, one = carried(system, W, 2 * span(system))
    _, sums = carried(system, both, 2 * span(system))
    assert np.abs(one @ [0.3, -2.0] - sums[:, 0]).max() <= 1e-6 * np.abs(one).max()


@pytest.mark.quick(8)
def test_tangents_leave_the_motion_alone(name, system):
    with_them, _ = carried(system, allowed(system, 2), span(system))
    alone = system.copy()
    alone.advance(span(system))
    assert np.abs(with_them.state() - alone.state()).max() <= tolerance(name) * size_of(alone.state())


@pytest.mark.quick(4)
def test_tangents_are_small_differences(name, system):
    """Central differences of the motion itself: error of the order eps^2, and of the solver over eps.

    With positions and velocities held together the tangent leaves out what the shift onto the joints changes with the
    state, an error of h^2 over many steps.  Accelerations are those of the steps.  Neighbours cross a section with last
    steps of other sizes, which the tangent does not know of: 1.5e-3 with 400 steps a period, 5e-4 with 1600.
    """
    if name in MECHANISMS:
        system = HELD[name]()
    eps, W, step = 1e-6 if name in MECHANISMS else 1e-5, allowed(system, 2), 2 * span(system)
    _, T = carried(system, W, step)
    x, time = system.state(), system.time
    for j in range(2):
        ends = []
        for sign in (1.0, -1.0):
            other = system.copy()
            other.reset(x + sign * eps * W[:, j], time=time)
            assert other.advance(step), other.status
            ends.append(other.state())
        slope = (ends[0] - ends[1]) / (2.0 * eps)
        part = 3e-3 if name == "section of a mechanism" else 2e-5
        assert np.abs(slope - T[:, j])[free(name)].max() <= part * np.abs(T[free(name)]).max()


def test_velocity_is_the_rate_of_the_state(name, system):
    if system.unit != "s":
        with pytest.raises(InputError, match="map"):
            system.velocity()
        return
    h = 1e-4
    middle = system.copy()
    assert middle.advance(h)
    v = middle.velocity()
    end = middle.copy()
    assert end.advance(h)
    difference = (end.state() - system.state()) / (2.0 * h)
    assert np.abs(v - difference)[free(name)].max() <= (1e-3 if name in MECHANISMS else 1e-5) * size_of(v[free(name)])


def test_what_the_flow_goes_along_is_a_tangent(system):
    """A difference along the motion is carried to one along the motion, unless the flow is driven."""
    if system.unit != "s" or system.driven:
        return
    other, T = carried(system, system.velocity()[:, None].copy(), span(system))
    v = other.velocity()
    assert np.abs(T[:, 0] - v).max() <= 1e-6 * size_of(v)


def test_tangent_basis(system):
    k = system.dimension
    W = system.tangent_basis(k)
    assert np.allclose((system.weights[:, None] * W).T @ W, np.eye(k), atol=1e-12)
    with pytest.raises(InputError, match=f"1 to {k}"):
        system.tangent_basis(k + 1)


def test_a_time_below_the_spacing_of_the_clock_is_no_error():
    """An impact is sought in times that the clock cannot tell from the present one."""
    flow = systems.lorenz()
    flow.reset(time=1e6)
    here = flow.state()
    assert flow.advance(1e-12)
    assert flow.time == 1e6
    np.testing.assert_array_equal(flow.state(), here)
    assert flow.advance(0.1)


def test_a_mechanism_answers_for_its_state():
    """Rows by name, angles, and the gap of a journal that is open where its penetration is below zero."""
    flow = fm.chaos.MechanismFlow(fm.mechanisms.slider_crank(systems.TURN * 10.0, clearance=5e-4))
    names, x = flow.state_names, flow.state()
    assert {name for name in names if names[name] in flow.angles} == {n for n in names if n.endswith(".theta")}
    for name, row in names.items():
        assert flow.observe()[flow.number_of("test", name)] == x[row]
    returning, free = flow.histories
    assert not set(returning) & set(free)
    assert len(returning) + len(free) == flow.program.tables.sizes.n_z
    assert set(flow.gaps.values()) == {-1.0}
    assert flow.is_rough
    assert not fm.chaos.MechanismFlow(mechanisms.rod(), period=systems.TURN, step=0.1).is_rough
