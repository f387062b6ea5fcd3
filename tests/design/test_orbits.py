"""Derivatives of periodic orbits beside closed forms, a published expansion, and differences of tight orbits."""

import math

import numpy as np
import pytest
from scipy.optimize import fsolve

import flexmb as fm
from flexmb.chaos import ODE, ImpactODE, Map, MechanismFlow, periodic_orbit
from flexmb.design.orbits import _closing, orbit_sensitivity
from flexmb.errors import InputError, SolveError

TURN = 2.0 * math.pi
TIGHT = {"rtol": 1e-12, "atol": 1e-14}
CENTRAL = (-2.0, 1.0 / 12.0), (-1.0, -8.0 / 12.0), (1.0, 8.0 / 12.0), (2.0, -1.0 / 12.0)


def by(function, numbers, name, h=1e-3):
    """Derivative of a function of numbers, of fourth order."""
    return sum(w / h * np.asarray(function(**numbers | {name: numbers[name] + x * h})) for x, w in CENTRAL)


# Linear oscillator x'' + c x' + k x = A cos w t

LINEAR = {"c": 0.1, "k": 2.0, "A": 0.5, "w": 1.0}


def oscillator(numbers):
    return ODE(
        lambda t, x, c, k, A, w: [x[1], A * np.cos(w * t) - c * x[1] - k * x[0]],
        [0.0, 0.0],
        jacobian=lambda t, x, c, k, A, w: [[0.0, 1.0], [-k, -c]],
        parameters=numbers,
        names=["x", "v"],
        units=["m", "m/s"],
        period=lambda w, **_: TURN / w,
        **TIGHT,
    )


def answer(c, k, A, w):
    return A / (k - w * w + 1j * c * w)


def start(c, k, A, w):
    x = answer(c, k, A, w)
    return [x.real, (1j * w * x).real]


def multiplier(c, k, A, w):
    return np.exp((-c / 2.0 + 1j * np.sqrt(k - c * c / 4.0)) * TURN / w)


@pytest.mark.slow
def test_linear_oscillator_has_its_closed_form():
    found = orbit_sensitivity(periodic_orbit(oscillator(LINEAR)), list(LINEAR), of=["x"])
    upper = int(found.orbit.multipliers.imag.argmax())
    for k, name in enumerate(LINEAR):
        data, measures = found.dataset.isel(parameter=k), found.measures.sel(parameter=name)
        np.testing.assert_allclose(data["state"], by(start, LINEAR, name), atol=1e-8)
        own = complex(data["multiplier.real"][upper], data["multiplier.imag"][upper])
        assert own == pytest.approx(by(multiplier, LINEAR, name), abs=2e-8)
        size = by(lambda **p: abs(answer(**p)), LINEAR, name)
        change = measures.derivative
        np.testing.assert_allclose(change.sel(measure="rms of x"), size / math.sqrt(2.0), atol=1e-8)
        for kind, sign in (("peak", 1.0), ("largest", 1.0), ("smallest", -1.0)):
            np.testing.assert_allclose(change.sel(measure=f"{kind} of x"), sign * size, atol=2e-6)
        t = found.dataset.time.values
        exact = by(lambda t=t, **p: (answer(**p) * np.exp(1j * p["w"] * t)).real, LINEAR, name)
        np.testing.assert_allclose(data["x"], exact, atol=1e-8)
        exponent = {"c": -0.5}.get(name, 0.0)  # ln|multiplier| / period is -c/2
        np.testing.assert_allclose(change.sel(measure="exponent 1"), exponent, atol=1e-8)
    np.testing.assert_allclose(found.dataset["period"], [0.0, 0.0, 0.0, -TURN], atol=1e-9)


def test_a_start_that_stays_has_no_error_of_its_derivative():
    # x' + k x = cos t starts with k/(1 + k^2), which is largest at k = 1
    flow = ODE(lambda t, x, k: [np.cos(t) - k * x[0]], [0.5], parameters={"k": 1.0}, period=TURN)
    found = orbit_sensitivity(periodic_orbit(flow), ["k"])
    assert abs(float(found.dataset["state"][0, 0])) < 1e-7
    assert float(found.status.split("differ by ")[1].split(".\n")[0].rstrip(".")) < 0.1


def test_parameters_whose_names_are_no_identifiers_are_passed_by():
    numbers = {"r": 2.5, "lambda": 1.0}
    found = orbit_sensitivity(
        periodic_orbit(Map(lambda x, r, **_: r * x * (1.0 - x), [0.6], parameters=numbers)), ["r"]
    )
    assert float(found.dataset["state"][0, 0]) == pytest.approx(0.16, abs=1e-8)


def test_equal_multipliers_have_no_derivatives_but_their_product():
    numbers = LINEAR | {"c": 2.0, "k": 1.0}  # critical damping: exp(-2 pi) twice
    found = orbit_sensitivity(periodic_orbit(oscillator(numbers)), ["c"])
    assert np.isnan(found.dataset["multiplier.real"]).all()
    assert "Nearly equal" in found.status
    product = found.measures.derivative.sel(measure="product of multipliers", parameter="c")
    assert float(product) == pytest.approx(-TURN * math.exp(-2.0 * TURN), abs=1e-9)


# Autonomous flow


def van_der_pol(mu):
    return ODE(
        lambda t, x, mu: [x[1], mu * (1.0 - x[0] ** 2) * x[1] - x[0]],
        [2.0, 0.0],
        parameters={"mu": mu},
        names=["x", "v"],
        **TIGHT,
    )


@pytest.mark.slow
def test_period_of_van_der_pol_for_small_damping():
    """T = 2 pi (1 + mu^2/16 - 5 mu^4/3072 + ...); the amplitude is 2 up to mu^2/96."""
    mu = 0.1
    found = orbit_sensitivity(periodic_orbit(van_der_pol(mu), period=6.3, autonomous=True), ["mu"], of=["x"])
    assert float(found.dataset["period"][0]) == pytest.approx(TURN * (mu / 8.0 - 5.0 * mu**3 / 768.0), rel=1e-5)
    rate = np.array(found.orbit.system().velocity())
    assert abs(rate @ found.dataset["state"].values[0]) < 1e-8  # the phase condition

    def moved(mu):
        system = found.orbit.system()
        system.reset(found.orbit.state, parameters={"mu": mu})
        system.advance(found.orbit.period)
        return system.state()

    away, later = _closing(found.orbit, by(moved, {"mu": mu}, "mu"), rate)  # (I - M) dx = dP + f dT
    np.testing.assert_allclose(
        [*away, later], [*found.dataset["state"].values[0], found.dataset["period"][0]], atol=1e-7
    )
    largest = found.measures.derivative.sel(measure="largest of x", parameter="mu")
    assert float(largest) == pytest.approx(mu / 48.0, rel=0.02)


@pytest.mark.slow
def test_strong_van_der_pol_agrees_with_differences_of_orbits():
    def numbers(mu):
        orbit = periodic_orbit(van_der_pol(mu), period=found.orbit.period, guess=found.orbit.state, autonomous=True)
        x = orbit.samples(400)["x"].values[:-1]  # periodic: means of round-off accuracy
        return orbit.period, orbit.multipliers[0].real, np.sqrt(np.mean(x**2))

    found = orbit_sensitivity(periodic_orbit(van_der_pol(1.0), period=6.6, autonomous=True), ["mu"], of=["x"], save=200)
    expected = by(numbers, {"mu": 1.0}, "mu", h=4e-3)
    names = ["period", "product of multipliers", "rms of x"]  # the other multiplier is 1
    np.testing.assert_allclose(found.measures.derivative.sel(measure=names).values[:, 0], expected, atol=1e-7)
    t, slope = found.dataset.time.values, found.dataset["x"].values[0]
    rate = found.orbit.system().velocity()[0]
    assert slope[-1] == pytest.approx(slope[0] - float(found.dataset["period"][0]) * rate, abs=1e-7)
    assert t[-1] == pytest.approx(found.orbit.period)


# Oscillator with a hard stop: x'' + c x' + x = A cos t, speeds turn by -e at x = 1

STOP = {"A": 0.5, "e": 0.8, "c": 0.1}


def flight(t, begin, speed, A, c):
    """Place and speed at t of a flight that leaves the stop at an instant, with a speed."""
    x = A / (1j * c)  # of x'' + c x' + x = A e^(it)
    w, s = math.sqrt(1.0 - c * c / 4.0), t - begin
    a = 1.0 - (x * np.exp(1j * begin)).real
    b = (speed - (1j * x * np.exp(1j * begin)).real + 0.5 * c * a) / w
    free = np.exp(-0.5 * c * s) * np.array(
        [a * np.cos(w * s) + b * np.sin(w * s), b * np.cos(w * s) - a * np.sin(w * s)]
    )
    place = free[0] + (x * np.exp(1j * t)).real
    return np.array([place, -0.5 * c * free[0] + w * free[1] + (1j * x * np.exp(1j * t)).real])


def impact(A, e, c):
    """Phase and speed of the impact of an orbit with one impact a period."""

    def gap(both):
        begin, speed = both
        place, arrived = flight(begin + TURN, begin, -e * speed, A, c)
        return place - 1.0, arrived - speed

    return fsolve(gap, [0.177, 0.837], xtol=1e-12)


def at_zero(A, e, c):
    begin, speed = impact(A, e, c)
    return flight(TURN, begin, -e * speed, A, c)


def hard_stop():
    ode = ODE(
        lambda t, x, A, e, c: [x[1], A * np.cos(t) - c * x[1] - x[0]],
        at_zero(**STOP),
        jacobian=lambda t, x, A, e, c: [[0.0, 1.0], [-1.0, -c]],
        parameters=STOP,
        names=["x", "v"],
        period=TURN,
        name="stop",
        **TIGHT,
    )
    return ImpactODE(ode, gap=lambda t, x, **_: 1.0 - x[0], jump=lambda t, x, e, **_: [x[0], -e * x[1]])


def test_oscillator_with_a_hard_stop_has_its_closed_form():
    """Each flight shrinks areas by exp(-2 pi c), each impact by e^2: the product of the multipliers."""
    np.testing.assert_allclose(impact(**STOP), [0.17711236, 0.83701602], atol=1e-8)
    orbit = periodic_orbit(hard_stop())
    assert orbit.multipliers[0] == pytest.approx(-0.58116589 + 0.06065134j, abs=1e-7)
    found = orbit_sensitivity(orbit, list(STOP))
    for k, name in enumerate(STOP):
        np.testing.assert_allclose(found.dataset["state"][k], by(at_zero, STOP, name, h=2e-4), atol=1e-7)
    product, change = STOP["e"] ** 2 * math.exp(-TURN * STOP["c"]), found.measures.derivative
    exact = [0.0, 2.0 / STOP["e"] * product, -TURN * product]
    np.testing.assert_allclose(change.sel(measure="product of multipliers"), exact, atol=1e-6)
    size = np.array(exact) / (2.0 * math.sqrt(product))  # of each of the pair
    np.testing.assert_allclose(change.sel(measure="size of multiplier 1"), size, atol=1e-6)
    with pytest.raises(InputError, match="leave of= out"):
        orbit_sensitivity(orbit, ["A"], of=["x"])


# Maps


def test_unstable_orbit_of_henon():
    """x = (b - 1 + sqrt((1 - b)^2 + 4 a)) / 2a; multipliers -a x +- sqrt(a^2 x^2 + b)."""
    numbers = {"a": 1.4, "b": 0.3}
    henon = Map(
        lambda x, a, b: [1.0 - a * x[0] ** 2 + x[1], b * x[0]], [0.63, 0.19], parameters=numbers, names=["x", "y"]
    )

    def point(a, b):
        x = (b - 1.0 + math.sqrt((1.0 - b) ** 2 + 4.0 * a)) / (2.0 * a)
        root = math.sqrt(a * a * x * x + b)
        return x, b * x, -a * x - root, -a * x + root

    found = orbit_sensitivity(periodic_orbit(henon), ["a", "b"], of=["x"])
    assert not found.orbit.stable
    for k, name in enumerate(numbers):
        own = [*found.dataset["state"].values[k], *found.dataset["multiplier.real"].values[k]]
        np.testing.assert_allclose(own, by(point, numbers, name), atol=1e-8)
        assert float(found.measures.derivative.sel(measure="mean of x", parameter=name)) == pytest.approx(own[0])
    assert set(found.to_dataset().data_vars) >= {"state", "x", "derivative", "error"}
    assert "mean of x" in repr(found)
    with pytest.raises(InputError, match="no peak of x"):
        orbit_sensitivity(found.orbit, ["a"], of=[fm.design.peak("x")])


# A mechanism: a driven mass whose pin strikes its bearing

K, D, M, F, W = 100.0, 0.8, 1.0, 3.0, 8.0
MEASURES = ("mass.x", "largest", np.max), ("mass.x", "smallest", np.min), ("J.normal_force", "mean", np.mean)
CLEARANCE = 0.9 * abs(F / (K - M * W**2 + 1j * D * W))


def worn(clearance=CLEARANCE):
    mass = fm.RigidBody("mass", at=(1.0, 0.0), mass=M, inertia=0.1, velocity=(0.2, 0.0, 0.0))
    ends = {"at": (0.0, 0.0), "to": (1.0, 0.0)}
    force = fm.drives.Harmonic(1.0, frequency=W / TURN, phase=math.pi / 2)
    law = fm.KelvinVoigt(stiffness=2e3, damping=0.0)
    parts = [
        mass,
        fm.Prismatic("guide", fm.GROUND, mass, along=(1.0, 0.0)),
        fm.SpringDamper("spring", fm.GROUND, mass, **ends, stiffness=K, damping=D),
        fm.Force("shake", mass, at=(1.0, 0.0), force=(F, 0.0), history=force),
        fm.RevoluteClearance("J", fm.GROUND, mass, at=(1.0, 0.0), clearance=clearance, bearing_radius=0.5, normal=law),
    ]
    return fm.Mechanism("worn", parts)


@pytest.mark.slow
def test_worn_mechanism_agrees_with_differences_of_orbits():
    """Steps carry the derivatives, (I - M)^-1 dP/dp; the orbits beside are found one by one."""
    T = TURN / W

    def orbit(guess=None, **numbers):
        flow = MechanismFlow(worn().with_(numbers) if numbers else worn(), step=fm.Adaptive(rtol=1e-8), period=T)
        found = periodic_orbit(flow, period=T, guess=guess, settle=0 if guess is not None else 5, tolerance=1e-9)
        assert found.ok, found.status
        return found

    here = orbit()
    names = {"J.clearance": CLEARANCE, "spring.stiffness": K}
    found = orbit_sensitivity(here, list(names), of=["mass.x", "J.normal_force"], tolerance=1e-9)
    for k, (name, value) in enumerate(names.items()):
        sides = [orbit(here.state, **{name: value * (1.0 + s)}) for s in (1e-3, -1e-3)]
        state = (sides[0].state - sides[1].state) / (2e-3 * value)
        np.testing.assert_allclose(found.dataset["state"][k, [0, 3]], state[[0, 3]], rtol=2e-3)
        motions = [one.samples(2000) for one in sides]
        for signal, kind, measure in MEASURES:
            change = (measure(motions[0][signal].values[:-1]) - measure(motions[1][signal].values[:-1])) / (
                2e-3 * value
            )
            own = found.measures.derivative.sel(measure=f"{kind} of {signal}", parameter=name)
            assert float(own) == pytest.approx(change, rel=5e-3)


def test_forces_of_a_crank_grow_with_the_square_of_its_speed():
    """Without gravity a driven slider-crank has no other time than its period, which shrinks."""
    flow = MechanismFlow(fm.mechanisms.slider_crank(speed=100.0), step=1e-4)
    found = orbit_sensitivity(periodic_orbit(flow), ["motor.motion.speed"], of=["motor.torque", "O.force"], save=50)
    names = [f"{kind} of {signal}" for kind in ("rms", "peak", "smallest") for signal in ("motor.torque", "O.force")]
    powers = found.measures.relative.sel(measure=[*names, "mean of O.force", "period"]).values[:, 0]
    np.testing.assert_allclose(powers, [2.0] * 7 + [-1.0], atol=1e-3)
    assert "Doubtful" not in found.status
    with pytest.raises(InputError, match=r"no signal is called 'O\.forze'"):
        orbit_sensitivity(found.orbit, ["rod.mass"], of=["O.forze"])
    with pytest.raises(InputError, match=r"mas.*mass"):
        orbit_sensitivity(found.orbit, ["rod.mas"])


# Odd input


def test_what_has_no_derivative_is_refused():
    orbit = periodic_orbit(oscillator(LINEAR))
    with pytest.raises(InputError, match="Did you mean 'c'"):
        orbit_sensitivity(orbit, ["cc"])
    with pytest.raises(InputError, match="names alone"):
        orbit_sensitivity(orbit, {"c": 0.2})
    with pytest.raises(InputError, match="no end of x"):
        orbit_sensitivity(orbit, ["c"], of=[fm.design.at_end("x")])
    with pytest.raises(InputError, match="signal is 'y'"):
        orbit_sensitivity(orbit, ["c"], of=["y"])
    with pytest.raises(InputError, match="it must be a periodic orbit"):
        orbit_sensitivity(oscillator(LINEAR), ["c"])
    odd = Map(lambda x, a: a + 0.5 * x, [0.2], names=["state"], parameters={"a": 0.1})
    with pytest.raises(InputError, match="'state' is the name of a column"):
        orbit_sensitivity(periodic_orbit(odd), ["a"], of=["state"])
    lost = periodic_orbit(oscillator(LINEAR), iterations=0)
    with pytest.raises(InputError, match="not found: "):
        orbit_sensitivity(lost, ["c"])


def test_folds_and_families_are_refused():
    fold = Map(lambda x, r: [x[0] + r - x[0] ** 2], [0.0], parameters={"r": 0.0})
    with pytest.raises(InputError, match=r"multiplier 1.*at a fold"):
        orbit_sensitivity(periodic_orbit(fold), ["r"])
    near = Map(lambda x, r: [x[0] + r - 1.0 - x[0] ** 2], [0.02], parameters={"r": 1.0004})
    with pytest.raises(SolveError, match=r"no orbit at r = .*A fold"):
        orbit_sensitivity(periodic_orbit(near), ["r"])
    near.reset(np.array([0.046]), parameters={"r": 1.0021})
    assert "Doubtful" in orbit_sensitivity(periodic_orbit(near), ["r"]).status
    closer = orbit_sensitivity(periodic_orbit(near), ["r"], distance=1e-6)
    assert "Doubtful" not in closer.status
    np.testing.assert_allclose(closer.dataset["state"], 0.5 / math.sqrt(0.0021), rtol=1e-6)
    free = ODE(lambda t, x, g: [x[1], -g * x[0]], [1.0, 0.0], parameters={"g": 1.0}, period=TURN, **TIGHT)
    family = periodic_orbit(free, tolerance=1e-9)
    with pytest.raises(InputError, match="one of a family"):
        orbit_sensitivity(family, ["g"])
