"""Lyapunov exponents against exact values first, then against published ones of chaotic motions.

Where the value is published the test asks for less than four standard deviations, as the run itself states them, plus
what the publication leaves open; and that these standard deviations are small.
"""

import mechanisms
import numpy as np
import pytest
import systems
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, fsolve
from systems import TURN

import flexmb as fm
from flexmb.errors import InputError


def agrees(found, published, *, last_digit, error, column=0):
    """Whether an exponent is the published one, and its own error is as small as the test claims."""
    assert found.ok, found.status
    assert found.errors[column] < error
    return abs(found.spectrum[column] - published) < 4.0 * found.errors[column] + last_digit


# Fixed points and limit cycles: exact values.


@pytest.mark.slow
def test_overdamped_oscillator():
    """x'' + 3 x' + 2 x = 0: -1 and -2."""
    found = fm.lyapunov(systems.oscillator(3.0, 2.0, rtol=1e-8), skip=0.0, duration=120.0, interval=2.4, count=2)
    assert np.abs(found.spectrum - [-1.0, -2.0]).max() < 1e-6
    assert found.units == "1/s"


@pytest.mark.slow
def test_driven_linear_oscillator():
    """Both -0.05 in the mean; turning of the vectors leaves half of the logarithm of an axis ratio over the time."""
    found = fm.lyapunov(systems.oscillator(0.1, 1.0, force=1.0), skip=5, periods=100, count=2)
    assert np.abs(found.spectrum + 0.05).max() < 2e-4
    assert found.sum == pytest.approx(-0.1, abs=1e-9)
    periods = found.per_period()
    assert periods.units == "1/period"
    assert periods.sum == pytest.approx(-0.1 * TURN, abs=1e-8)


@pytest.mark.slow
def test_van_der_pol():
    """0 and the mean divergence over the limit cycle (Liouville), integrated here by itself."""

    def with_divergence(t, y):
        return [y[1], (1.0 - y[0] ** 2) * y[1] - y[0], 1.0 - y[0] ** 2]

    def up(t, y):
        return y[1]

    up.direction = -1.0  # v falls through 0 where x is largest
    run = solve_ivp(with_divergence, (0.0, 80.0), [2.0, 0.0, 0.0], events=up, rtol=1e-12, atol=1e-13, method="DOP853")
    (t0, t1), (y0, y1) = run.t_events[0][-2:], run.y_events[0][-2:]
    assert t1 - t0 == pytest.approx(6.6632868593, abs=1e-8)  # published period for mu = 1
    second = (y1[2] - y0[2]) / (t1 - t0)
    flow = systems.van_der_pol()
    found = fm.lyapunov(flow, skip=40.0, duration=60 * (t1 - t0), interval=t1 - t0, count=2)
    assert abs(found.spectrum[0]) < 1e-8
    assert found.spectrum[1] == pytest.approx(second, abs=1e-7)
    assert found.verdict is None  # instants at will are no section
    section = fm.chaos.SectionMap(systems.van_der_pol(), "x", direction="down")
    across = fm.lyapunov(section, skip=10, periods=50)
    assert across.value == pytest.approx(second, abs=1e-6)
    assert across.period == pytest.approx(t1 - t0, abs=1e-7)
    assert across.per_period().value == pytest.approx(second * (t1 - t0), abs=1e-5)


# Maps.


@pytest.mark.slow
def test_henon():
    """0.41922 (J. C. Sprott, Chaos and Time-Series Analysis, 2003, appendix A); the sum is ln b, exactly."""
    found = fm.lyapunov(systems.henon(), skip=1000, periods=60000, count=2)
    assert agrees(found, 0.41922, last_digit=5e-6, error=0.003)
    assert found.sum == pytest.approx(np.log(0.3), abs=1e-12)
    assert found.units == "1/iteration"


@pytest.mark.slow
def test_standard_map():
    """Area is kept, so the exponents are a pair; for large K they are ln(K / 2) (B. V. Chirikov, 1979)."""
    found = fm.lyapunov(systems.standard_map(20.0), skip=100, periods=20000, count=2)
    assert abs(found.sum) < 1e-12
    assert agrees(found, np.log(10.0), last_digit=0.01, error=0.01)


def test_bouncing_ball_doubles_its_period():
    """gamma_1 = 2 sqrt(pi^2 (1 - alpha)^2 + (1 + alpha)^2) (P. J. Holmes, J. Sound Vib. 84 (1982) 173)."""
    alpha = 0.5
    flip = 2.0 * np.sqrt(np.pi**2 * (1.0 - alpha) ** 2 + (1.0 + alpha) ** 2)
    for gamma, kind in ((flip - 0.05, 1), (flip + 0.05, 2)):
        ball = systems.high_bounce(alpha, gamma)
        found = fm.lyapunov(ball, skip=2000, periods=400, count=2)
        assert len(np.unique(found.points[:, 1].round(6))) == kind
        assert found.sum == pytest.approx(np.log(alpha), abs=1e-12)
        assert found.value < -1e-3
        if kind == 1:
            sine = -np.sqrt(1.0 - (TURN * (1.0 - alpha) / gamma) ** 2)
            larger = np.abs(np.roots([1.0, -(1.0 + alpha + gamma * sine), alpha])).max()
            assert found.value == pytest.approx(np.log(larger), abs=1e-6)
    ball = systems.high_bounce(alpha, flip)
    assert abs(fm.lyapunov(ball, skip=2000, periods=1000).value) < 1e-3


def test_superstable_orbit():
    """x' = 2 x (1 - x) at its fixed point 1/2, where the slope is 0: minus infinity, not an error."""
    found = fm.lyapunov(
        fm.chaos.Map(lambda x: 2.0 * x * (1.0 - x), [0.5], jacobian=lambda x: 2.0 - 4.0 * x[None]), periods=50
    )
    assert found.ok
    assert found.value == -np.inf
    assert np.isnan(found.error)


# Impacts.


def exact_orbit(oscillator, near):
    """Fixed point of the exact stroboscopic map, and its derivative there by central differences."""

    def strobe(x):
        return np.array(oscillator.until(0.0, *x, TURN / oscillator.w)[:2])

    x = fsolve(lambda x: strobe(x) - x, near, xtol=1e-13)
    steps = 1e-6 * np.eye(2)
    return x, np.array([(strobe(x + s) - strobe(x - s)) / 2e-6 for s in steps]).T


def settled(oscillator, periods=150):
    strobe = fm.chaos.StroboscopicMap(oscillator.flow())
    assert strobe.advance(periods), strobe.status
    return strobe


def test_impacts_are_where_they_must_be():
    for w in (2.0, 2.8):
        oscillator = systems.ImpactOscillator(w=w)
        flow = oscillator.flow()
        u, v, impacts = oscillator.until(0.0, *flow.state(), 12 * TURN / w)
        assert impacts > 5
        assert flow.advance(12 * TURN / w)
        assert np.abs(flow.state() - [u, v]).max() < 1e-8


def test_impact_oscillator_against_its_exact_map():
    """Multipliers of the exact map; each impact shrinks areas by r^2, so the sum is 2 ln r an impact."""
    oscillator = systems.ImpactOscillator(w=2.6)
    strobe, T = settled(oscillator), TURN / 2.6
    x, J = exact_orbit(oscillator, strobe.state())
    assert np.abs(strobe.state() - x).max() < 1e-8
    tangents = np.eye(2)
    assert strobe.advance(1, tangents)
    assert np.abs(tangents - J).max() < 1e-6 * np.abs(J).max()
    found = fm.lyapunov(strobe, periods=60, count=2)
    multipliers = np.sort(np.log(np.abs(np.linalg.eigvals(J))))[::-1] / T
    assert np.abs(found.spectrum - multipliers).max() < 5e-3  # a complex pair turns the vectors
    assert found.sum == pytest.approx(2.0 * np.log(0.8) / T, rel=1e-8)


@pytest.mark.slow
def test_impact_oscillator_doubles_its_period():
    """Where the exact map has the multiplier -1, found here by Brent on its derivative."""

    def flip(w):
        oscillator = systems.ImpactOscillator(w=w)
        _, J = exact_orbit(oscillator, near)
        return 1.0 + np.trace(J) + np.linalg.det(J)

    near = settled(systems.ImpactOscillator(w=2.6)).state()
    w = brentq(flip, 2.6, 2.7, xtol=1e-10)
    assert w == pytest.approx(2.65335, abs=1e-5)
    for frequency, kind in ((w - 0.04, 1), (w + 0.04, 2)):
        points = fm.stroboscopic(settled(systems.ImpactOscillator(w=frequency)), skip=100, keep=8)
        assert len(np.unique(points.u.values.round(5))) == kind


def test_a_bouncing_ball_comes_to_rest_with_a_status():
    """Restitution 1/2: the flights last 2, 1, 1/2 ... times the first speed over g, in all 1 + 2 s."""
    fall = fm.chaos.ODE(lambda t, x: [x[1], -1.0], [0.5, 0.0], names=["height", "speed"])
    ball = fm.chaos.ImpactODE(fall, gap=lambda t, x: x[0], jump=lambda t, x: [x[0], -0.5 * x[1]])
    assert not ball.advance(10.0)
    assert "pile up" in ball.status
    assert ball.time == pytest.approx(3.0, abs=1e-5)


# Chaos, published.


@pytest.mark.slow
def test_lorenz():
    """0.9056, 0, -14.5723 (J. C. Sprott, Chaos and Time-Series Analysis, 2003, appendix A); the sum is exact."""
    found = fm.lyapunov(systems.lorenz(rtol=1e-8), skip=20.0, duration=400.0, interval=0.5, count=3)
    assert agrees(found, 0.9056, last_digit=5e-5, error=0.04)
    assert agrees(found, 0.0, last_digit=0.0, error=0.02, column=1)
    assert agrees(found, -14.5723, last_digit=5e-5, error=0.04, column=2)
    assert found.sum == pytest.approx(-(10.0 + 1.0 + 8.0 / 3.0), abs=1e-6)


@pytest.mark.slow
def test_lorenz_on_a_section():
    """The exponent 0 belongs to the direction that a section does not have."""
    section = fm.chaos.SectionMap(systems.lorenz(rtol=1e-8), "z", level=27.0)
    assert section.dimension == 2
    found = fm.lyapunov(section, skip=20, periods=300, count=2)
    assert agrees(found, 0.9056, last_digit=5e-5, error=0.05)
    assert agrees(found, -14.5723, last_digit=5e-5, error=0.05, column=1)


@pytest.mark.slow
def test_rossler():
    """0.0714, 0, -5.3943 (J. C. Sprott, Chaos and Time-Series Analysis, 2003, appendix A)."""
    found = fm.lyapunov(systems.rossler(rtol=1e-8), skip=100.0, duration=4000.0, interval=5.0, count=3)
    assert agrees(found, 0.0714, last_digit=5e-5, error=0.004)
    assert agrees(found, 0.0, last_digit=0.0, error=0.002, column=1)
    assert agrees(found, -5.3943, last_digit=5e-5, error=0.02, column=2)


@pytest.mark.slow
def test_driven_pendulum():
    """0.160, -0.262 for damping 0.1 and force 2.5 (arXiv physics/0303077); the sum is -0.1, exactly."""
    found = fm.lyapunov(systems.pendulum(rtol=1e-8), skip=50, periods=800, count=2)
    assert agrees(found, 0.160, last_digit=2e-3, error=0.01)
    assert found.sum == pytest.approx(-0.1, abs=1e-7)


@pytest.mark.slow
def test_duffing():
    """0.0999 and -0.1499 by Runge-Kutta steps of 1e-3 s, length of the run not said (a page of spectra of exponents,
    sites.google.com/view/lyapunov-spectrum); eight runs of 4500 periods gave 0.1036 +/- 0.0008.  The sum is exact.
    """
    found = fm.lyapunov(systems.duffing(rtol=1e-8), skip=100, periods=1500, count=2)
    assert agrees(found, 0.0999, last_digit=4e-3, error=0.006)
    assert found.sum == pytest.approx(-0.05, abs=1e-7)


@pytest.mark.slow
def test_conservative_exponents_come_in_pairs():
    """Henon-Heiles at E = 1/8: l, 0, 0, -l."""
    found = fm.lyapunov(systems.henon_heiles(), skip=50.0, duration=1000.0, interval=2.0, count=4)
    assert abs(found.sum) < 1e-8
    assert np.abs(found.spectrum + found.spectrum[::-1]).max() < 1e-4  # each vector's pair, but for ends of the run
    assert found.value > 0.02
    assert abs(found.spectrum[1]) < 0.1 * found.value


# Two trajectories.


@pytest.mark.slow
@pytest.mark.parametrize(
    ("make", "options"),
    [
        (systems.henon, {"skip": 500, "periods": 2000}),
        pytest.param(systems.henon, {"skip": 500, "periods": 20000}, marks=pytest.mark.slow),
        pytest.param(
            lambda: systems.lorenz(rtol=1e-10),
            {"skip": 10.0, "duration": 50.0, "interval": 0.5},
            marks=pytest.mark.slow,
        ),
        pytest.param(
            lambda: fm.chaos.StroboscopicMap(systems.pendulum()), {"skip": 50, "periods": 150}, marks=pytest.mark.slow
        ),
        pytest.param(
            lambda: fm.chaos.SectionMap(systems.lorenz(), "z", level=27.0),
            {"skip": 20, "periods": 100},
            marks=pytest.mark.slow,
        ),
    ],
    ids=["short map", "map", "ode", "stroboscopic", "section"],
)
def test_two_trajectories_and_tangents_agree(make, options):
    pair, tangent = fm.chaos.benettin(make(), **options), fm.lyapunov(make(), **options)
    assert pair.ok, pair.status
    assert pair.units == tangent.units
    assert pair.points.shape == tangent.points.shape
    assert abs(pair.value - tangent.value) < 4.0 * np.hypot(pair.error, tangent.error)


def test_a_mechanism_at_rest():
    """A damped rod that hangs: -c / 2 = -0.05."""
    still = mechanisms.rod(push=0.0)
    found = fm.chaos.benettin(still, period=TURN, step=TURN / 200, skip=5, periods=100)
    assert found.ok, found.status
    assert found.value == pytest.approx(-0.05, abs=2e-4)


@pytest.mark.slow
def test_a_mechanism_in_chaos():
    """The rod under a harmonic torque is the driven pendulum above: 0.160."""
    found = fm.chaos.benettin(mechanisms.rod(), period=TURN, step=TURN / 400, skip=20, periods=500)
    assert agrees(found, 0.160, last_digit=2e-3, error=0.015)


# What a record says.


@pytest.mark.slow
def test_the_error_covers_what_runs_differ_by():
    """Ten starts of Henon's map: their spread is what each of them claims, within what ten can tell."""
    values, errors = [], []
    for k in range(10):
        system = systems.henon()
        system.reset([0.05 * k - 0.2, 0.1])
        found = fm.lyapunov(system, skip=100, periods=3000)
        values.append(found.value)
        errors.append(found.error)
    assert 0.4 < np.std(values, ddof=1) / np.mean(errors) < 2.0


def test_the_history_ends_at_the_value():
    found = fm.lyapunov(systems.henon(), skip=10, periods=1000, count=2)
    assert np.array_equal(found.history[-1], found.spectrum)
    assert found.history.shape == (len(found.time), 2) == (900, 2)
    assert found.time[-1] == 1010.0
    assert found.points.shape == (1000, 2)
    assert found.value == found.spectrum[0] >= found.spectrum[1]
    assert "1/iteration" in str(found)


@pytest.mark.slow
def test_looks_are_taken_more_often_where_growth_is_fast():
    """Over one interval of 5 s Lorenz's third vector shrinks by e^73; the exponents are there all the same."""
    found = fm.lyapunov(systems.lorenz(rtol=1e-8), skip=20.0, duration=300.0, interval=5.0, count=3)
    assert agrees(found, -14.5723, last_digit=5e-5, error=0.05, column=2)
    assert found.sum == pytest.approx(-(10.0 + 1.0 + 8.0 / 3.0), abs=1e-5)


@pytest.mark.slow
def test_the_verdict_is_made_of_the_section(monkeypatch):
    """It gets the points, without the sums that a mechanism keeps, and the largest exponent with its error."""
    asked = []

    def judge(points, names, *, exponent, error, units, floor=1e-6, sizes=None):
        assert (floor, sizes) == (1e-6, None) or (floor == 1.0 and 0.0 < sizes.max() < 1e-4)
        asked.append((points.shape, list(names), exponent, error, list(units)))
        return fm.chaos.Verdict("transient", "Asked.")

    monkeypatch.setattr("flexmb.dynamics.sections.judge", judge)
    for confirm in (False, True):
        found = fm.lyapunov(systems.henon(), skip=10, periods=60, confirm=confirm)
        assert asked.pop() == ((60, 2), ["x0", "x1"], found.value, found.statistical[0], ["", ""])
        assert str(found.verdict) == "transient"
    fm.chaos.benettin(mechanisms.rod(), period=TURN, step=TURN / 50, periods=50)
    shape, names, _, _, units = asked.pop()
    assert shape == (50, len(names))
    assert units[names.index("rod.theta")] == "rad"
    assert "rod.omega" in names
    assert not any(name.startswith("energy.") for name in names)
    assert fm.lyapunov(systems.lorenz(rtol=1e-6), duration=50.0, interval=1.0).verdict is None


def test_tangent_vectors_that_are_not_finite_are_a_status():
    found = fm.lyapunov(fm.chaos.Map(lambda x: 0.5 * x, [1.0], jacobian=lambda x: [[np.nan]]), periods=50)
    assert not found.ok
    assert "tangent vectors are not finite" in found.status


@pytest.mark.parametrize("tool", [fm.lyapunov, fm.chaos.benettin])
def test_a_run_that_fails_midway_keeps_what_it_found(tool):
    """x' = x / 2 until x is below 1e-20, which is so after 67 iterations: the exponent of these is -ln 2."""
    halving = fm.chaos.Map(lambda x: [0.5 * x[0] if x[0] > 1e-20 else np.nan], [1.0], jacobian=lambda x: [[0.5]])
    found = tool(halving, periods=100)
    assert not found.ok
    assert "not finite" in found.status
    assert len(found.time) == 67 - 10
    assert found.value == pytest.approx(-np.log(2.0), abs=1e-9)
    assert found.verdict is None


@pytest.mark.parametrize("tool", [fm.lyapunov, fm.chaos.benettin])
@pytest.mark.parametrize(
    ("make", "options", "message"),
    [
        (systems.henon, {"periods": 49}, "49 iterations are too few.*at least 50 are needed"),
        (systems.lorenz, {"duration": 10.0, "interval": 1.0}, "10 intervals are too few"),
        (systems.pendulum, {"periods": 3}, "3 periods are too few"),
        (systems.henon, {}, "give either periods= .* or duration="),
        (systems.henon, {"periods": 100, "duration": 1.0}, "or duration="),
        (systems.henon, {"duration": 1.0}, "duration= belongs to a flow"),
        (systems.lorenz, {"periods": 100}, "no period.*Give period="),
        (systems.lorenz, {"duration": 100.0, "skip": -1.0}, "skip is -1"),
        (lambda: "henon", {"periods": 100}, "must be a Mechanism"),
    ],
)
def test_bad_input(tool, make, options, message):
    with pytest.raises(InputError, match=message):
        tool(make(), **options)


def test_more_exponents_than_directions_are_refused():
    with pytest.raises(InputError, match="1 to 2 independent"):
        fm.lyapunov(systems.henon(), periods=100, count=3)
    with pytest.raises(InputError, match="distance is 0"):
        fm.chaos.benettin(systems.henon(), periods=100, distance=0.0)
    with pytest.raises(InputError, match="no period"):
        fm.lyapunov(systems.henon(), periods=100).per_period()


@pytest.mark.slow
def test_a_diagram_and_an_exponent_agree_on_a_stable_cycle():
    """The points of a worn slider-crank alternate by 1.7 nm, less than the error that its steps may have (4 nm).

    With fixed steps they are equal to 1e-15 m.
    """
    settings = {"fixed": {"clearance": 2e-5}, "skip": 40, "keep": 50}
    alone, together = (
        fm.bifurcation(fm.mechanisms.slider_crank, "speed", [350.0], exponent=exponent, **settings)
        for exponent in (False, "points")
    )
    assert alone["verdict"].item() == together["verdict"].item() == "periodic-1"
    assert together["exponent"].item() < -10.0
    ey = alone["B.ey"].values.ravel()
    assert 1e-9 < np.ptp(ey) < 4e-9  # not by round-off
    mechanism = fm.mechanisms.slider_crank(350.0, clearance=2e-5)
    fixed = fm.stroboscopic(mechanism, skip=40, keep=4, step=TURN / 350.0 / 400)
    assert np.ptp(fixed["B.ey"].values) < 1e-12
