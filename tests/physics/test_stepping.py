"""Steps taken one at a time from Python."""

import itertools

import numpy as np
import pytest
from nine_bar_study.nine_bar.staggered.method import Staggered

import flexmb as fm
from flexmb.errors import InputError, SolveError


@pytest.mark.parametrize(
    ("mechanism", "options"),
    [
        (fm.mechanisms.slider_crank(clearance=5e-4), {}),
        (fm.mechanisms.slider_crank(), {"step": 1e-5, "method": fm.RungeKutta4()}),
        (fm.mechanisms.slider_crank(), {"method": fm.RadauIIA()}),
        (fm.mechanisms.slider_crank(clearance=5e-4, flexible=True), {"step": 2e-6, "method": Staggered()}),
    ],
    ids=["newmark", "runge-kutta", "radau", "staggered"],
)
@pytest.mark.quick(3)
def test_the_steps_are_those_of_simulate(mechanism, options):
    states = list(fm.steps(mechanism, t_end=2e-4, **options))
    sol = fm.simulate(mechanism, t_end=2e-4, save="steps", **options)
    assert [s.t for s in states] == sol.time.tolist()
    assert np.array_equal([s.values for s in states], sol.values)
    assert [s.h for s in states][1:] == pytest.approx(np.diff(sol.time), rel=1e-9)
    assert states[-1].stats.steps == sol.stats.steps


def test_steps_without_an_end_are_those_of_a_period():
    """Their smallest step was that of a time without end, and longer than a step to an onset."""
    mechanism = fm.mechanisms.slider_crank(300.0, clearance=2e-4)
    options = {"method": fm.DormandPrince(), "step": fm.Adaptive(rtol=1e-8)}
    times = [state.t for state in itertools.islice(fm.steps(mechanism, **options), 60)]
    assert times == fm.simulate(mechanism, periods=1, save="steps", **options).time[:60].tolist()


def test_signals_by_name():
    state = next(iter(fm.steps(fm.mechanisms.slider_crank(), t_end=1e-3)))
    assert state["slider.x"] == state.values[list(state).index("slider.x")]
    assert "slider.x" in state
    assert "slider.z" not in state
    assert len(state) == len(list(state))
    with pytest.raises(KeyError, match=r"has no signal .slider\.xx."):
        state["slider.xx"]


def test_a_loop_may_be_left_and_a_run_goes_on_from_there():
    mech = fm.mechanisms.slider_crank()
    for state in fm.steps(mech, step=1e-5):
        if state["slider.vx"] < -5.0:
            break
    whole = fm.simulate(mech, t_end=0.01, step=1e-5, save="steps")
    rest = fm.simulate(mech, t_end=0.01, step=1e-5, save="steps", restart=state.restart)
    assert 0.0 < state.t < 0.01
    assert rest.array("slider.x")[-1] == pytest.approx(whole.array("slider.x")[-1], abs=1e-12)


def test_states_stay_what_they_were():
    first, second = itertools.islice(fm.steps(fm.mechanisms.slider_crank(), t_end=1e-3), 2)
    assert first.t == 0.0
    assert second.t > 0.0
    assert not np.array_equal(first.values, second.values)
    with pytest.raises(ValueError, match="read-only"):
        first.values[0] = 1.0


def test_a_step_that_fails_raises():
    with pytest.raises(SolveError, match=r"Newton did not converge|energies|singular"):
        list(fm.steps(fm.mechanisms.slider_crank(), t_end=0.5, step=0.05, method=fm.RadauIIA()))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"t_end": -1.0}, "t_end is -1"),
        ({"method": 3}, "method is 3"),
        ({"step": "small"}, "step is 'small'"),
        ({"method": fm.RungeKutta4()}, "has no error estimate"),
    ],
)
def test_bad_input_is_refused_at_once(options, message):
    with pytest.raises(InputError, match=message):
        fm.steps(fm.mechanisms.slider_crank(), **options)


def test_no_end_and_no_period():
    pin = fm.RigidBody("pin", at=(0.0, 0.0), mass=1.0, inertia=1.0, velocity=(1.0, 0.0, 0.0))
    mech = fm.Mechanism("free", [pin])
    with pytest.raises(InputError, match=r"steps of 'free': there is no t_end.*Adaptive\(max=...\)"):
        fm.steps(mech)
    states = list(itertools.islice(fm.steps(mech, step=0.1), 5))
    assert [s["pin.x"] for s in states] == pytest.approx([0.0, 0.1, 0.2, 0.3, 0.4])


def test_a_restart_that_does_not_fit_is_refused_in_its_own_name():
    with pytest.raises(InputError, match=r"steps of 'slider-crank': restart is 5"):
        fm.steps(fm.mechanisms.slider_crank(), t_end=1.0, restart=5)
