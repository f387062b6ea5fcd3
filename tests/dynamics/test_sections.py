"""Sections: where the crossings are, and what they do not depend on."""

import mechanisms
import numpy as np
import pytest
import systems
from scipy.special import ellipk
from systems import TURN

import flexmb as fm
from flexmb.errors import InputError


def test_crossings_of_a_sine_are_at_the_roots_of_the_clock():
    """x = cos t crosses 1/2 downwards at pi/3 + 2 pi k, upwards at -pi/3 + 2 pi k."""
    flow = systems.oscillator(0.0, rtol=1e-12, atol=1e-14)
    down = fm.chaos.section(flow, "x", level=0.5, direction="down", keep=4)
    assert np.abs(down.time.values - (np.pi / 3.0 + TURN * np.arange(4))).max() < 1e-10
    assert np.abs(down.x.values - 0.5).max() < 1e-14
    flow.reset()
    up = fm.chaos.section(flow, "x", level=0.5, keep=4)
    assert np.abs(up.time.values - (-np.pi / 3.0 + TURN * np.arange(1, 5))).max() < 1e-10
    flow.reset()
    both = fm.chaos.section(flow, "x", level=0.5, direction="both", keep=8)
    assert np.array_equal(both.time.values, np.sort(np.concatenate([down.time, up.time])))


def test_a_crossing_is_not_met_again():
    """From the point of one crossing, given to a fresh section, the next one follows, not the same."""
    section = fm.chaos.SectionMap(systems.oscillator(0.0), "x", direction="both")
    section.advance(1)
    first, other = section.flow.time, section.copy()
    other.reset(section.state())
    assert section.advance(1)
    assert other.advance(1)
    assert section.flow.time == pytest.approx(first + np.pi, rel=1e-9)
    assert np.abs(other.state() - section.state()).max() < 1e-8


def test_two_crossings_within_a_step_are_seen():
    """x = cos t reaches over 0.9999 for 0.028 s; the steps of the solver are some 0.5 s long."""
    flow = systems.oscillator(0.0)
    found = fm.chaos.section(flow, "x", level=0.9999, direction="both", keep=6)
    half = np.arccos(0.9999)
    expected = [half, TURN - half, TURN + half, 2 * TURN - half, 2 * TURN + half, 3 * TURN - half]
    assert np.abs(found.time.values - expected).max() < 1e-6


@pytest.mark.parametrize(
    "make",
    [systems.lorenz, pytest.param(lambda: mechanisms.swinging(1e-4), marks=pytest.mark.slow)],
    ids=["ode", "mechanism"],
)
def test_points_do_not_depend_on_how_far_one_looks_ahead(make):
    found = []
    for limit in (30.0, 3000.0):
        flow = make()
        signal, level = ("z", 27.0) if "z" in flow.names else ("bar.omega", 0.5)
        found.append(fm.chaos.section(flow, signal, level=level, keep=6, limit=limit))
    assert np.array_equal(found[0].time, found[1].time)
    assert all(np.array_equal(found[0][name], found[1][name]) for name in flow.names)


@pytest.mark.slow
def test_a_pendulum_stands_still_every_period():
    """T = 4 sqrt(2 L / 3 g) K(1/2), at 90 degrees; omega crosses 0 upwards at T/2, 3 T/2 ..."""
    flow = mechanisms.swinging()
    period = 4.0 * np.sqrt(2.0 / (3.0 * 9.81)) * ellipk(0.5)
    found = fm.chaos.section(flow, "bar.omega", keep=3)
    assert np.abs(found.time.values / period - [0.5, 1.5, 2.5]).max() < 2e-6
    assert np.abs(found["bar.omega"].values).max() < 1e-11
    assert np.abs(found["bar.theta"].values + np.pi).max() < 2e-6


@pytest.mark.slow
def test_a_section_on_a_force():
    """The pin pushes the bar along X with m times the acceleration of its centre: 3 N where that is so.

    A bar let go at angle 0 has swung through a with w^2 = (3 g / L) sin a and alpha = (3 g / 2 L) cos a.
    """
    flow = mechanisms.swinging()
    found = fm.chaos.section(flow, "O.fx", level=3.0, direction="both", keep=2)
    m, g = 2.0, 9.81
    swung = -found["bar.theta"].values
    ax = -0.5 * (1.5 * g * np.cos(swung)) * np.sin(swung) - 0.5 * (3.0 * g * np.sin(swung)) * np.cos(swung)
    assert np.abs(np.abs(m * ax) - 3.0).max() < 1e-3
    assert np.abs(found["O.fx"].values - 3.0).max() < 1e-9


def test_rates_and_slopes_of_a_mechanism():
    """Jerk of x'' = 2.5 sin t - 0.1 x' - sin x, and a force's rate against the force a little before and after.

    x counts from hanging, the angle of the rod from +X.
    """
    flow = mechanisms.rod_flow(steps=4000)
    flow.advance(1.0)
    angle, speed, acceleration = (flow.observe()[flow.names.index(f"rod.{k}")] for k in ("theta", "omega", "alpha"))
    jerk = 2.5 * np.cos(flow.time) - 0.1 * acceleration - np.cos(angle + np.pi / 2.0) * speed
    assert flow.velocity()[-1] == pytest.approx(jerk, rel=1e-4)
    assert flow.rate(flow.names.index("rod.alpha")) == pytest.approx(jerk, rel=1e-4)
    k, before, h = flow.names.index("O.fx"), flow.observe(), TURN / 4000
    flow.advance(h)
    rate, slope = flow.rate(k), flow.slopes(k, flow.velocity()[:, None])[0]
    flow.advance(h)
    assert rate == pytest.approx((flow.observe()[k] - before[k]) / (2.0 * h), rel=1e-3)
    assert np.isfinite(slope)
    still = mechanisms.swinging()  # not driven: a force follows from the state alone
    still.advance(0.3)
    assert still.slopes(k, still.velocity()[:, None])[0] == pytest.approx(still.rate(k), rel=1e-6)


def worn():
    """A slider-crank at 5000 rpm whose slider pin has a play of 0.5 mm."""
    return fm.mechanisms.slider_crank(TURN * 5000.0 / 60.0, clearance=5e-4)


def test_a_section_on_a_contact():
    """Touches of a worn pin: as many, and where, as the accepted steps of a plain run change the sign."""
    found = fm.chaos.section(worn(), "B.penetration", direction="both", keep=8)
    plain = fm.simulate(worn(), t_end=1.1 * float(found.time[-1]), save="steps")
    depth = plain.array("B.penetration")
    changes = np.flatnonzero(depth[:-1] * depth[1:] < 0.0)
    assert len(changes) >= 8
    first, last = plain.time[changes[:8]], plain.time[changes[:8] + 1]
    off = np.maximum(first - found.time.values, found.time.values - last).max()
    assert off < 1e-3 * found.attrs["period"]
    assert np.abs(found["B.penetration"].values).max() < 1e-14


def test_the_rate_of_a_depth_is_its_signal():
    flow = fm.chaos.MechanismFlow(worn())
    flow.advance(1e-3)
    rate = flow.rate(flow.names.index("B.penetration"))
    assert rate == pytest.approx(flow.observe()[flow.names.index("B.penetration_rate")], rel=1e-7)


@pytest.mark.slow
def test_a_signal_that_rests_on_its_level_does_not_cross_it():
    """The slider stands still at its dead point until the pin has crossed its play."""
    found = fm.chaos.section(worn(), "slider.vx", keep=3)
    assert found.attrs["ok"]
    assert np.diff(found.time.values).min() > 0.1 * found.attrs["period"]


def test_aliases_of_nodes_are_followed():
    rod = fm.FlexibleLink("rod", (0.0, 0.0), (1.0, 0.0), section=fm.Circle(0.02), material=fm.STEEL, elements=1)
    mechanism = fm.Mechanism("rod", [rod, fm.Revolute("O", fm.GROUND, rod, at=(0.0, 0.0))], gravity=(0.0, -9.81))
    found = fm.chaos.section(mechanism, "rod.end.vy", level=-0.5, direction="down", keep=1, period=1.6)
    assert found.attrs["ok"], found.attrs["status"]
    assert float(found["rod.node1.vy"][0]) == pytest.approx(-0.5, abs=1e-9)


def test_the_stroboscope_follows_the_parameters():
    """w = 3 and damping 0.5: after the transient |x| = F / |k - w^2 + i c w|, the same point every period."""
    flow = systems.oscillator(0.5, force=1.0)
    strobe = fm.chaos.StroboscopicMap(flow)
    assert strobe.period == TURN
    strobe.reset(parameters={"w": 3.0})
    assert strobe.period == TURN / 3.0
    points = fm.stroboscopic(strobe, skip=150, keep=3)
    response = 1.0 / (1.0 - 9.0 + 1.5j)
    assert np.abs(points.x.values - response.real).max() < 1e-8
    assert np.abs(points.v.values - (3.0j * response).real).max() < 1e-8
    assert points.attrs["period"] == TURN / 3.0


def test_the_stroboscope_follows_the_drives():
    flow = fm.chaos.MechanismFlow(mechanisms.cranks(0.2, 0.3))
    strobe = fm.chaos.StroboscopicMap(flow)
    assert strobe.period == pytest.approx(0.6)
    strobe.reset(parameters={"motor0.motion": fm.ConstantSpeed(TURN / 0.25)})
    assert strobe.period == pytest.approx(1.5)


def test_the_table_of_points():
    points = fm.stroboscopic(mechanisms.rod(), period=TURN, step=TURN / 200, skip=2, keep=3)
    assert points.sizes == {"period": 3}
    assert points.period.values.tolist() == [2, 3, 4]
    assert np.allclose(points.time, TURN * np.array([2, 3, 4]), rtol=1e-12)
    assert points["rod.omega"].attrs["units"] == "rad/s"
    assert {k: points.attrs[k] for k in ("name", "kind", "skip", "ok")} == {
        "name": "rod",
        "kind": "stroboscopic",
        "skip": 2,
        "ok": 1,
    }
    whole = fm.simulate(mechanisms.rod(), t_end=4 * TURN, step=TURN / 200)
    assert points["rod.theta"].values[-1] == pytest.approx(whole.array("rod.theta")[-1], rel=1e-9)


def test_iterations_of_a_map_are_points():
    points = fm.stroboscopic(systems.henon(), skip=10, keep=5)
    x, y = 0.1, 0.1
    for _ in range(10):
        x, y = 1.0 - 1.4 * x * x + y, 0.3 * x
    assert points.x0.values[0] == pytest.approx(x, rel=1e-9)
    assert points.time.attrs["units"] == ""


def test_no_crossing_is_a_status():
    flow = systems.oscillator(0.2)
    found = fm.chaos.section(flow, "x", level=5.0, keep=3, limit=50.0)
    assert found.attrs["ok"] == 0
    assert found.sizes["crossing"] == 0
    assert "did not cross 5 within 50 s" in found.attrs["status"]


def test_a_flow_that_blows_up_is_a_status():
    """x' = x^2 from 1 is infinite at t = 1."""
    flow = fm.chaos.ODE(lambda t, x: x**2, [1.0], period=0.3)
    found = fm.stroboscopic(flow, keep=10)
    assert found.attrs["ok"] == 0
    assert found.sizes["period"] == 4
    assert "Stopped" in found.attrs["status"]
    assert not flow.advance(0.1)
    flow.reset()
    assert flow.advance(0.1)


@pytest.mark.parametrize("function", [lambda t, x: [np.nan], lambda t, x: [np.sqrt(0.5 - t)]])
def test_rates_that_are_not_finite_are_a_status(function):
    flow = fm.chaos.ODE(lambda t, x: [1.0] if t == 0.0 else function(t, x), [1.0])
    assert not flow.advance(1.0)
    assert "not finite" in flow.status


def test_drives_without_a_common_period_are_named():
    flow = fm.chaos.MechanismFlow(mechanisms.cranks(1.0, 2.0**0.5), step=1e-3)
    with pytest.raises(InputError, match=r"1 s and 1.41421 s.*Give period="):
        fm.chaos.StroboscopicMap(flow)
    assert fm.chaos.StroboscopicMap(flow, 1.0).period == 1.0


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: fm.chaos.StroboscopicMap(systems.lorenz()), "no period.*Give period="),
        (lambda: fm.chaos.StroboscopicMap(systems.henon()), "must be a flow in time"),
        (lambda: fm.chaos.SectionMap(systems.henon(), "x0"), "must be a flow in time"),
        (lambda: fm.chaos.section(systems.henon(), "x0", keep=1), "a map has no crossings"),
        (lambda: fm.chaos.SectionMap(systems.lorenz(), "w"), "signal is 'w'.*Known: x, y, z"),
        (lambda: fm.chaos.SectionMap(systems.lorenz(), "z", direction="sideways"), "direction is 'sideways'"),
        (lambda: fm.chaos.SectionMap(systems.lorenz(), "z", limit=0.0), "limit is 0"),
        (lambda: fm.stroboscopic(systems.henon(), keep=0), "keep is 0"),
        (lambda: fm.stroboscopic(systems.henon(), keep=1, skip=0.5), "skip is 0.5"),
        (lambda: fm.stroboscopic(systems.henon(), keep=1, period=1.0), "period= belongs to a flow"),
        (lambda: fm.stroboscopic(systems.lorenz(), keep=1, period=1.0, step=0.1), "step= and method= belong"),
        (lambda: fm.stroboscopic("lorenz", keep=1), "must be a Mechanism"),
        (lambda: fm.chaos.ODE(lambda t, x: [1.0], [1.0, 2.0]), "shape"),
        (lambda: fm.chaos.ODE(lambda t, x: x, [1.0], method="Euler"), "method is 'Euler'"),
        (lambda: fm.chaos.ODE(lambda t, x: x, [1.0], rtol=0.0), "rtol is 0"),
        (lambda: fm.chaos.ODE(lambda t, x: x, [1.0], names=["a", "b"]), "2 names for 1"),
        (lambda: fm.chaos.ODE(lambda t, x: x, [1.0], period=-1.0), "period is -1"),
        (lambda: fm.chaos.ImpactODE(systems.henon(), gap=None, jump=None), "must be an ODE"),
        (
            lambda: fm.chaos.ImpactODE(
                fm.chaos.ODE(lambda t, x: -x, [-1.0]), gap=lambda t, x: x[0], jump=lambda t, x: x
            ),
            "Start in flight",
        ),
    ],
)
def test_bad_input(call, message):
    with pytest.raises(InputError, match=message):
        call()
