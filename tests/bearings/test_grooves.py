"""Finite film between axial grooves: published coefficients, its table, frames, bad input."""

import math

import numpy as np
import pytest

import flexmb as fm
from flexmb.errors import InputError
from flexmb.parts.bearings import kernels
from flexmb.parts.bearings.film import TABLE_BEGIN, pads_force, pads_table, solve_film
from flexmb.testing.bench import gradient

R, C, MU, SPIN = 0.01, 5e-5, 0.02, 100.0
WIDTH = math.radians(20.0)
LUND = {
    0.5: ((1.656, 0.244, 65.85, 1.69, 5.06, -2.20, 1.95, 9.93, 2.15, 4.80),
          (0.917, 0.372, 57.45, 2.12, 4.01, -1.30, 1.85, 7.70, 2.06, 3.23),
          (0.580, 0.477, 51.01, 2.67, 3.70, -0.78, 1.75, 6.96, 1.94, 2.40),
          (0.379, 0.570, 45.43, 3.33, 3.64, -0.43, 1.68, 6.76, 1.87, 1.89),
          (0.244, 0.655, 40.25, 4.21, 3.74, -0.13, 1.64, 6.87, 1.82, 1.54)),
    1.0: ((0.991, 0.150, 70.58, 1.56, 7.29, -2.16, 1.52, 14.66, 1.58, 4.49),
          (0.635, 0.224, 63.54, 1.62, 5.33, -1.57, 1.56, 10.80, 1.70, 3.41),
          (0.235, 0.460, 49.27, 2.19, 3.57, -0.80, 1.55, 7.36, 1.89, 2.19),
          (0.159, 0.559, 44.33, 2.73, 3.36, -0.48, 1.48, 6.94, 1.78, 1.74),
          (0.108, 0.650, 39.72, 3.45, 3.34, -0.23, 1.44, 6.89, 1.72, 1.43)),
}  # fmt: skip
"""Sommerfeld number, eccentricity, attitude [deg], K c/W (xx, xy, yx, yy), B c w/W (xx, xy, yy) of a bearing with two
axial grooves of 20 degrees, by width over diameter; x along the load, between the grooves (J. W. Lund and K. K.
Thomsen 1978)."""


def bearing(ratio=0.5, grooves=(0.0, math.pi), first=fm.GROUND, second=None, **more):
    film = fm.FiniteBearing(viscosity=MU, width=2.0 * R * ratio, grooves=grooves, groove_width=WIDTH)
    second = second or fm.RigidBody("journal", (0.0, 0.0), 1.0, 1.0)
    given = {"at": (0.0, 0.0), "clearance": C, "bearing_radius": R, "normal": fm.contact.Hertz(1e9), **more}
    return fm.JournalBearing("B", first, second, film=film, **given)


@pytest.mark.slow
@pytest.mark.parametrize("ratio", [0.5, pytest.param(1.0, marks=pytest.mark.slow)])
def test_published_coefficients(ratio):
    """Eccentricity to .001, attitude to .1 degrees, stiffness to 1 % and damping to 2 % of the largest."""
    for number, eps, attitude, *coefficients in LUND[ratio]:
        load = MU * SPIN / (2.0 * math.pi) * 4.0 * R**2 * ratio / number * (R / C) ** 2
        found = bearing(ratio).equilibrium(load, SPIN)
        assert found.eccentricity == pytest.approx(eps, abs=1e-3)
        assert math.degrees(found.attitude) == pytest.approx(attitude, abs=0.1)
        K, B = found.stiffness * C / load, found.damping * C * SPIN / load
        assert K.ravel() == pytest.approx(coefficients[:4], abs=0.01 * np.abs(K).max())
        assert B[[0, 0, 1], [0, 1, 1]] == pytest.approx(coefficients[4:], abs=0.02 * B.max())
        assert B[0, 1] == pytest.approx(B[1, 0], abs=0.005 * B.max())


@pytest.mark.parametrize("second", [math.pi, pytest.param(1.6, marks=pytest.mark.slow)])
def test_mirrored_spin_and_turned_bearing(second):
    """The grooves and the load turned together, and everything mirrored, change nothing."""
    load, grooves = 60.0, (0.4, 0.4 + second)
    base = bearing(grooves=grooves).equilibrium(load, SPIN, direction=-0.7)
    turned = bearing(grooves=(1.4, 1.4 + second)).equilibrium(load, SPIN, direction=0.3)
    mirrored = bearing(grooves=(-0.4, -0.4 - second)).equilibrium(load, -SPIN, direction=0.7)
    for other in (turned, mirrored):
        assert other.eccentricity == pytest.approx(base.eccentricity, rel=1e-9)
        assert other.attitude == pytest.approx(base.attitude, rel=1e-9)
        assert other.flow == pytest.approx(base.flow, rel=1e-9)
    assert turned.stiffness == pytest.approx(base.stiffness, rel=1e-7)
    assert mirrored.stiffness == pytest.approx(base.stiffness, rel=1e-7)
    with pytest.raises(InputError, match="carries up to"):
        bearing(grooves=grooves).equilibrium(1e6, SPIN, direction=-0.7)


def test_the_table_holds_the_forces():
    """The film is the sum of those of its pads; errors by interpolation are below 1 % of the closing film's force."""
    grooves = (0.0, math.pi, 2.0 * math.pi)
    p = np.array([0.0] * TABLE_BEGIN + list(pads_table(0.5, grooves, WIDTH)))
    rng, errors = np.random.default_rng(4), []
    for _ in range(40):
        eps, alpha, widest = 1.0 - math.exp(-rng.uniform(0.0, 3.5)), *rng.uniform(-math.pi, math.pi, 2)
        a, b = math.sin(alpha), math.cos(alpha)
        exact, closing = np.zeros(2), np.zeros(2)
        for groove in grooves[:2]:
            pad = groove + 0.5 * WIDTH - widest, math.pi - WIDTH
            exact += solve_film(eps, a, b, 0.5, pad=pad, cells=96)[:2]
            closing += solve_film(eps, abs(a), b, 0.5, pad=pad, cells=96)[:2]
        errors.append(math.hypot(*(np.array(pads_force(p, eps, a, b, widest))[:2] - exact)) / math.hypot(*closing))
    assert max(errors) < 1e-2
    assert np.median(errors) < 2e-3


def test_tangents_and_power_in_any_frame():
    """Bodies that turn: exact tangents, forces that turn with both, and power that the film takes."""
    p, none, rng = np.array(bearing().numbers((0.1, 0.02), (-0.05, 0.03))), np.zeros(0), np.random.default_rng(1)

    def force(q, v):
        r = np.zeros(6)
        kernels.JOURNAL_FILM.force.dispatcher(p, 0.0, 0.0, q, v, np.zeros(6), none, r, none)
        return r

    for _ in range(12):
        q, v = rng.uniform(-1.0, 1.0, 6), rng.uniform(-1.0, 1.0, 6)
        arms = kernels.relative.py_func(p, q, v)
        angle, e = rng.uniform(-math.pi, math.pi), C * rng.uniform(0.02, 0.95)
        q[3:5] += [e * math.cos(angle) - arms[4], e * math.sin(angle) - arms[5]]
        v[[2, 5]] *= 20.0
        v[3:5] += C * rng.uniform(-50.0, 50.0, 2) - kernels.relative.py_func(p, q, v)[6:8]
        r, K, D, M = np.zeros(6), np.zeros((6, 6)), np.zeros((6, 6)), np.zeros((6, 6))
        kernels.JOURNAL_FILM.element.dispatcher(p, 0.0, 0.0, q, v, np.zeros(6), none, r, K, D, M, none)
        assert r == pytest.approx(force(q, v), rel=1e-12)
        small = {"K": 0.01 * np.array([C, C, C / 0.1, C, C, C / 0.1]), "D": C * np.array([1e1, 1e1, 1e2] * 2)}
        for found, function, x, step in (
            (K, lambda q, v=v: force(q, v), q, small["K"]),
            (D, lambda v, q=q: force(q, v), v, small["D"]),
        ):
            expected, doubt = gradient(function, x, step)
            size = np.abs(expected).max(axis=1, keepdims=True)
            assert (np.abs(found - expected) <= 1e-6 * size + doubt).all()
            assert (doubt <= 2e-3 * size).all()
        _, _, power = kernels.JOURNAL_FILM.energy.dispatcher(p, 0.0, q, v)
        assert power == pytest.approx(r @ v, rel=1e-9)
        assert power > 0.0
        c, s = math.cos(0.8), math.sin(0.8)
        turn = np.kron(np.eye(2), np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]))
        assert force(turn @ q + [0, 0, 0.8, 0, 0, 0.8], turn @ v) == pytest.approx(turn @ r, rel=1e-9, abs=1e-9)


def test_a_journal_settles_at_the_equilibrium():
    load = 40.0
    part = bearing()
    found = part.equilibrium(load, SPIN)
    journal = fm.RigidBody("journal", (0.0, 0.0), 0.02, 1e6, velocity=(0.0, 0.0, SPIN))
    push = fm.Force("push", journal, (0.0, 0.0), (0.0, -load))
    mech = fm.Mechanism("rotor", (journal, bearing(second=journal), push))
    sol = fm.simulate(mech, t_end=0.5, save=20)
    assert sol.ok, sol.status
    last = sol.array("B.ex")[-1], sol.array("B.ey")[-1]
    assert math.hypot(*last) == pytest.approx(found.eccentricity * C, rel=1e-4)
    assert math.atan2(last[1], last[0]) == pytest.approx(found.attitude - 0.5 * math.pi, abs=1e-4)
    assert sol.array("B.pressure")[-1] == pytest.approx(found.pressure, rel=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("spin", "count", "least"), [pytest.param(SPIN, 25, 80, marks=pytest.mark.slow), (-SPIN, 7, 19)]
)
def test_the_film_carries_the_load_in_every_direction(spin, count, least):
    """Where the attitude has a fold over the eccentricity, about the grooves, as well; a load above them is refused."""
    part = bearing()
    numbers, r = np.array(part.numbers((0.0, 0.0), (0.0, 0.0))), np.zeros(6)
    carried = 0
    for load in (10.0, 100.0, 200.0, 400.0):
        for direction in np.linspace(-3.0, 3.0, count):
            try:
                found = part.equilibrium(load, spin, direction)
            except InputError as error:
                most = float(str(error).split("up to ")[1].split(" N")[0])
                assert part.equilibrium(0.999 * most, spin, direction).film_thickness < 1.1e-6
                continue
            angle = direction + math.copysign(found.attitude, spin)
            e = found.eccentricity * C
            q = np.array([0.0, 0.0, 0.0, e * math.cos(angle), e * math.sin(angle), 0.0])
            v, a, none = np.array([0.0, 0.0, 0.0, 0.0, 0.0, spin]), np.zeros(6), np.zeros(0)
            kernels.JOURNAL_FILM.force.dispatcher(numbers, 0.0, 0.0, q, v, a, none, r, none)
            assert r[3:5] == pytest.approx([load * math.cos(direction), load * math.sin(direction)], abs=1e-7 * load)
            carried += 1
    assert carried > least


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"grooves": (0.0, 0.4)}, "grooves leave"),
        ({"grooves": (0.0, 2.0 * math.pi)}, "grooves leave"),
        ({"grooves": (0.0,), "groove_width": 3.2}, "between 0 and 3.14"),
        ({"grooves": (0.0,), "supply": "everywhere"}, "leave one of them out"),
        ({"grooves": (math.nan,)}, r"grooves\[0\]"),
        ({"grooves": 3.0}, "grooves"),
    ],
)
def test_bad_input(given, message):
    with pytest.raises(InputError, match=message):
        fm.FiniteBearing(viscosity=MU, width=R, **given)
