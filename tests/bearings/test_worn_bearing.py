"""Worn bearings with oil: the film of a shifted circle, tangents, mixed friction, energies, bad input."""

import math
from dataclasses import replace

import numpy as np
import pytest
from cases import slow_where

import flexmb as fm
from flexmb.mechanisms import slider_crank
from flexmb.parts.bearings.kernels import JOURNAL_FILM, SIGNALS, film_signal
from flexmb.parts.wear.worn_bearing import WORN_FILM, worn_film_signal

C, R, WIDTH = 5e-5, 0.01, 0.012
DRY = slider_crank(speed=2.0 * math.pi * 1000 / 60, clearance=C, friction="coulomb")
OIL = fm.ShortBearing(viscosity=0.02, width=WIDTH)
WET = fm.JournalBearing(
    "B", DRY["rod"], DRY["slider"], at=(0.17, 0.0), clearance=C, bearing_radius=R, film=OIL, roughness=1e-6,
    normal=DRY["B"].normal, friction=DRY["B"].friction,
)  # fmt: skip
THIN = replace(WET, film=fm.ShortBearing(viscosity=3e-4, width=WIDTH))
ARCHARD = fm.Archard(bearing=1e-13)
ANGLE, RANDOM = 2.0 * math.pi * np.arange(360) / 360, np.random.default_rng(5)
PROFILES = {
    "groove": np.maximum(9e-5 * np.cos(ANGLE - 1.0) - C, 0.0),
    "three waves": 1e-5 * (1.0 + np.cos(3.0 * ANGLE)),
    "ridges": 1e-5 * RANDOM.random(360),
}
FIRST, SECOND = (0.1, 0.02), (-0.05, 0.03)


def states(n, most=0.95, shift=(0.0, 0.0), c=C, body=2):
    """Poses whose eccentricity from a point, shifted in the axes of a body, is up to `most` of the clearance; rates."""
    for _ in range(n):
        q, v = RANDOM.normal(size=6), RANDOM.normal(size=6) * (1e-2, 1e-2, 10.0, 1e-2, 1e-2, 10.0)
        size, angle = RANDOM.uniform(0.02, most) * c, RANDOM.uniform(-3.2, 3.2)
        turn = lambda s, a: np.array([math.cos(a) * s[0] - math.sin(a) * s[1], math.sin(a) * s[0] + math.cos(a) * s[1]])  # noqa: E731
        q[3:5] = q[:2] + turn(FIRST, q[2]) - turn(SECOND, q[5]) + turn(shift, q[body])
        q[3:5] += size * np.array([math.cos(angle), math.sin(angle)])
        yield q, v


def force(kernel, p, q, v):
    r = np.zeros(6)
    kernel(np.array(p), 0.0, 0.0, q, v, np.zeros(6), np.zeros(0), r, np.zeros(0))
    return r


def signals(kernel, p, at, q, v):
    p = np.array(p if at else (*p, 0.0))
    found = []
    for k in range(len(SIGNALS)):
        p[at or -1] = k
        found.append(kernel(p, 0.0, q, v, np.zeros(6)))
    return np.array(found)


# The film


@pytest.mark.parametrize("surface", [pytest.param("bearing", marks=pytest.mark.slow), "journal"])
def test_unworn_film_is_the_short_one(surface):
    errors = {}
    for bins in (180, 360, 720):
        worn = WET.worn_by(fm.Archard(**{surface: 1e-13}, bins=bins)).film_numbers(FIRST, SECOND)
        pairs = [
            (force(WORN_FILM.force, worn, q, v), force(JOURNAL_FILM.force, WET.numbers(FIRST, SECOND), q, v))
            for q, v in states(100)
        ]
        errors[bins] = np.median([abs(a - b).max() / abs(b).max() for a, b in pairs])
        if bins == 360:
            assert max(abs(a - b).max() / abs(b).max() for a, b in pairs) < 2e-3
    assert errors[720] < 0.5 * errors[180]
    assert errors[360] < 2e-4


@pytest.mark.slow
@pytest.mark.parametrize("surface", ["bearing", pytest.param("journal", marks=pytest.mark.slow)])
def test_an_eccentric_surface_is_a_round_one_about_its_own_centre(surface):
    """A depth d (1 + cos) makes the clearance c + d about a centre that is d aside, in the body that wears."""
    d, shift = 2e-5, 2e-5 * np.array([math.cos(0.7), math.sin(0.7)])
    joint = WET.worn_by(fm.Archard(**{surface: 1e-13}, bins=720))
    angle = joint.places
    p = joint.with_depths(d * (1.0 + np.cos(angle - 0.7))).film_numbers(FIRST, SECOND)
    round_one = replace(WET, clearance=C + d)
    moved = (np.add(FIRST, shift), SECOND) if surface == "bearing" else (FIRST, np.subtract(SECOND, shift))
    own = round_one.numbers(*map(tuple, moved))
    for q, v in states(40, 0.9, shift, C + d, 2 if surface == "bearing" else 5):
        expected = force(JOURNAL_FILM.force, own, q, v)
        assert force(WORN_FILM.force, p, q, v) == pytest.approx(expected, abs=2e-3 * abs(expected).max())
        a, b = signals(worn_film_signal, p, 0, q, v), signals(film_signal, own, 12, q, v)
        assert a[:4] == pytest.approx(b[:4], rel=1e-2)
        assert a[5:7] == pytest.approx(b[5:7], abs=2e-3 * abs(b[5:7]).max())


@pytest.mark.slow
@pytest.mark.parametrize("name", slow_where(lambda n: n != "ridges", PROFILES))
def test_power_of_the_film_is_the_work_that_its_forces_take(name):
    p = np.array(WET.worn_by(ARCHARD).with_depths(PROFILES[name]).film_numbers(FIRST, SECOND))
    for q, v in states(50):
        r = force(WORN_FILM.force, p, q, v)
        power = WORN_FILM.energy(p, 0.0, q, v)[2]
        assert power == pytest.approx(r @ v, rel=1e-9)
        assert power >= 0.0
        assert r[:2] == pytest.approx(-r[3:5])
        x, y = q[3:5] - q[:2]
        assert r[2] + r[5] + x * r[4] - y * r[3] == pytest.approx(0.0, abs=1e-9 * abs(r).max())
        assert signals(worn_film_signal, p, 0, q, v)[[5, 6]] == pytest.approx(-r[3:5])


@pytest.mark.usefixtures("states")
@pytest.mark.parametrize("name", slow_where(lambda n: n != "ridges", PROFILES))
@pytest.mark.parametrize("surface", [pytest.param("bearing", marks=pytest.mark.slow), "journal"])
def test_tangents_of_worn_films(name, surface):
    joint = WET.worn_by(fm.Archard(**{surface: 1e-13})).with_depths(PROFILES[name])
    fm.testing.check_part(DRY.with_part(joint), "B")


# Runs


def test_a_run_with_an_unworn_surface_is_that_of_the_journal_bearing():
    before, after = (fm.simulate(DRY.with_part(j), periods=1).require() for j in (WET, WET.worn_by(ARCHARD)))
    for name in ("B.film_thickness", "B.power", "slider.ax"):
        assert after.array(name) == pytest.approx(before.array(name), abs=2e-3 * abs(before.array(name)).max())


@pytest.mark.parametrize("name", PROFILES)
def test_energies_of_runs_with_worn_films(name):
    sol = fm.simulate(DRY.with_part(THIN.worn_by(ARCHARD).with_depths(PROFILES[name])), periods=1)
    assert sol.ok, sol.status
    assert abs(float(sol["energy.residual"][-1])) < 1e-4 * float(sol["energy.turned_over"][-1])


def test_contact_through_the_film_wears_and_the_film_alone_does_not():
    sol = fm.simulate(DRY.with_part(WET.worn_by(ARCHARD)), periods=1, save="steps").require()
    assert WET.worn_by(ARCHARD).worn_in(sol).volume == 0.0
    joint = THIN.worn_by(fm.EnergyWear(bearing=1e-12))
    sol = fm.simulate(DRY.with_part(joint), periods=1, save="steps", step=5e-6).require()
    wear = joint.worn_in(sol)
    assert wear.volume > 0.0
    assert wear.volume == pytest.approx(1e-12 * float(sol["energy.dissipated_friction"][-1]), rel=1e-5)
    assert joint.width == WIDTH


@pytest.mark.slow
def test_oil_wears_a_joint_less_than_a_dry_contact():
    lives = [fm.wear_out(DRY.with_part(j.worn_by(fm.Archard(bearing=1e-13, width=WIDTH))), turns=500.0, keep=1)
             for j in (DRY["B"], THIN)]  # fmt: skip
    dry, wet = (float(life["B.volume"][-1]) for life in lives)
    assert 0.0 < wet < 0.5 * dry
    assert float(lives[1]["B.clearance"][0]) == pytest.approx(C, rel=1e-12)


# Bad input


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: replace(WET, film=fm.LongBearing(viscosity=0.02, width=0.1)).worn_by(ARCHARD), "must be ShortBearing"),
        (lambda: replace(WET, film=replace(OIL, cavitation="half")).worn_by(ARCHARD), "must be ShortBearing"),
        (lambda: WET.worn_by(ARCHARD).with_depths(PROFILES["groove"]).equilibrium(100.0, 100.0), "since it is worn"),
        (lambda: WET.worn_by(0.1), "law of wear"),
        (lambda: WET.worn_by(ARCHARD).with_depths(np.full(360, 1.0)), "below the bearing radius"),
    ],
)
def test_bad_input_is_refused_with_what_to_do(make, words):
    with pytest.raises(fm.errors.InputError, match=words):
        make()


def test_an_unworn_bearing_keeps_its_equilibrium():
    own, dry = (joint.equilibrium(50.0, 100.0) for joint in (WET.worn_by(ARCHARD), WET))
    assert own.eccentricity == dry.eccentricity
    assert (own.stiffness == dry.stiffness).all()
