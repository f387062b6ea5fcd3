"""Section forces and stresses of beams under their weight and inertia, within their elements, against closed forms."""

import math
from dataclasses import replace

import numpy as np
import pytest
from cases import slow_where

import flexmb as fm
from flexmb.elastic.beams import fem as hermite
from flexmb.parts.bodies import flexible
from flexmb.results import drawing
from flexmb.results.positions import with_values

G, LENGTH, WIDTH, HEIGHT = 9.81, 0.8, 0.02, 0.01
STEEL = fm.Material(2e11, 7800.0, 0.3, yield_stress=3e8)
SECTION = fm.Rectangle(width=WIDTH, height=HEIGHT)
MASS, MODULUS = STEEL.density * WIDTH * HEIGHT, WIDTH * HEIGHT**2 / 6.0  # per length [kg/m]; I/c [m^3]
COUNTS = (1, 2, 4, 8)


def beam(elements, *, at=(0.0, 0.0), length=LENGTH, **more):
    usual = {"section": SECTION, "material": STEEL, "elements": elements, "stress": True}
    return fm.FlexibleLink("beam", at, (at[0] + length, at[1]), **{**usual, **more})


def clamped(elements, gravity=(0.0, -G), **more):
    body = beam(elements, **more)
    return fm.Mechanism("clamped", [body, fm.Fixed("wall", fm.GROUND, body, at=body.start)], gravity=gravity)


def supported(elements, gravity=(0.0, -G), **more):
    body = beam(elements, **more)
    foot = fm.RigidBody("foot", at=body.end, mass=1e-3, inertia=1e-6)
    pins = [fm.Revolute("A", fm.GROUND, body, at=body.start), fm.Revolute("B", body, foot, at=body.end)]
    guide = fm.Prismatic("guide", fm.GROUND, foot, at=body.end, along=(1.0, 0.0))
    return fm.Mechanism("supported", [body, foot, *pins, guide], gravity=gravity)


def at_rest(mechanism):
    return fm.simulate(mechanism, t_end=1e-6, start="equilibrium", save=2)


def test_order_of_moments_and_forces_of_a_vibration():
    """A supported beam and a bar in their first modes at the largest amplitude, whose inertia is a sine along them."""
    k, xi, size, errors = math.pi / LENGTH, np.linspace(0.0, 1.0, 9), 1e-7, []
    EA, EI = STEEL.young * WIDTH * HEIGHT, STEEL.young * WIDTH * HEIGHT**3 / 12.0
    for n in (2, 4, 8, 16):
        mechanism, worst = clamped(n, gravity=(0.0, 0.0)), np.zeros(3)
        for j, shape in enumerate(mechanism.shapes()[:n]):
            x = (j + np.array([0.0, 1.0])) / n * LENGTH
            s, along = np.sin(k * x), (j + xi) / n * k * LENGTH
            zero, rest = np.zeros_like(x), np.stack([x, 0.0 * x, 0.0 * x], axis=1)
            for mode, square in (
                (np.stack([zero, size * s, size * k * np.cos(k * x)], axis=1), EI * k**4 / MASS),
                (np.stack([size * s, zero, zero], axis=1), EA * k**2 / MASS),
            ):
                motion = np.zeros((1, 6)), -square * mode.reshape(1, 6)
                N, M, V = (f[0] for f in hermite.section_forces(*(rest + mode), shape, xi, motion))
                if mode[:, 1].any():
                    found = M / (EI * k**2 * size) + np.sin(along), V / (EI * k**3 * size) - np.cos(along)
                    worst[:2] = np.maximum(worst[:2], np.abs(found).max(axis=1))
                else:
                    worst[2] = max(worst[2], np.abs(N / (EA * k * size) - np.cos(along)).max())
        errors.append(worst)
    orders = np.log2(np.array(errors)[:-1] / errors[1:])
    assert orders[:, 0].min() > 3.5, (orders, errors)
    assert orders[-1, 0] > 3.9, (orders, errors)
    assert orders[:, 1:].min() > 2.5, (orders, errors)
    assert errors[1][0] < 1e-3


@pytest.mark.parametrize("elements", [*COUNTS, (0.1, 0.35)])
def test_root_of_a_cantilever_under_its_weight(elements):
    """The stress was .833, .958 and .990 of the exact one with 1, 2 and 4 elements."""
    sol, exact = at_rest(clamped(elements)), MASS * G * LENGTH**2 / 2.0 / MODULUS
    peak, root = sol.peak("beam.von_mises"), sol.stress("beam", ["start"])
    assert peak.value == pytest.approx(exact, rel=2e-5)
    assert (peak.node, peak.place) == (0, (0.0, 0.0))
    # left is above: it is stretched
    np.testing.assert_allclose(root["von_mises"], peak.value, rtol=1e-6)
    assert root["bending"].min() > 0.0
    np.testing.assert_array_equal(root["bending_right"], -root["bending"])
    moment = sol.array("wall.moment")
    np.testing.assert_allclose(root["bending"][:, 0] * MODULUS, np.abs(moment), rtol=1e-9)


@pytest.mark.parametrize("elements", [*COUNTS, 3, (0.1, 0.4)])
def test_middle_of_a_simply_supported_beam(elements):
    """The peak was .667, 1.167, .963 and 1.042 of w L^2/8 with 1 to 4 elements, that of one element at the pins."""
    sol, exact = at_rest(supported(elements)), MASS * G * LENGTH**2 / 8.0 / MODULUS
    peak = sol.peak("beam.von_mises")
    assert peak.value == pytest.approx(exact, rel=1e-6)
    ends = sol.stress("beam", ["start", "end"])
    assert np.abs(ends["bending"]).max() < 1e-6 * exact
    seen = sol.stress("beam", [peak.node])
    assert float(seen["von_mises"].max()) > 0.95 * exact
    assert float(seen["x"][0]) == pytest.approx(peak.place[0])
    assert abs(peak.place[0] - 0.5 * LENGTH) < 0.101 * LENGTH
    if elements in (1, 3):
        assert peak.place == pytest.approx((0.5 * LENGTH, 0.0))
        assert f" at the middle of element {elements // 2}, (0.4, 0) m " in sol.notes[0]


def test_moments_and_shear_forces_along_a_supported_beam():
    """Parabola and line, in pictures and files of VTK alike."""
    sol = at_rest(supported(2))
    first, second = (line for line in drawing.lines(sol, np.array([1]), 9) if line.is_beam)
    x = np.linspace(0.0, 0.5 * LENGTH, 9)
    w = MASS * G
    for line, s in ((first, x), (second, x + 0.5 * LENGTH)):
        moment = 0.5 * w * s * (LENGTH - s)
        np.testing.assert_allclose(line.fields["bending_moment"][0], moment, atol=1e-6 * w * LENGTH**2)
        np.testing.assert_allclose(line.fields["shear_force"][0], w * (s - 0.5 * LENGTH), atol=1e-5 * w * LENGTH)


@pytest.mark.parametrize("lever", [0.0, 0.3])
def test_axial_stress_of_a_spinning_beam(lever):
    """A rod on a hub at a constant speed: rho Omega^2 (R^2 - r^2)/2; it was the mean of each element."""
    speed = 200.0
    for n in (1, 3):
        body = beam(n, at=(lever, 0.0))
        hub = fm.RigidBody("hub", at=(0.0, 0.0), mass=1.0, inertia=1.0)
        pin, weld = fm.Revolute("O", fm.GROUND, hub, at=(0.0, 0.0)), fm.Fixed("weld", hub, body, at=body.start)
        parts = [hub, body, pin, weld, fm.Drive("motor", joint="O", motion=fm.ConstantSpeed(speed))]
        mechanism = fm.Mechanism("spinning", parts, gravity=(0.0, 0.0))
        start = fm.static_equilibrium(mechanism, spin=speed)
        sol = fm.simulate(mechanism, t_end=1e-4, start=start, save=2)
        found = sol.stress("beam").isel(time=0)
        r = lever + found["station"].values
        exact = 0.5 * STEEL.density * speed**2 * ((lever + LENGTH) ** 2 - r**2)
        np.testing.assert_allclose(found["axial"], exact, atol=2e-3 * exact.max())
        assert sol.peak("beam.von_mises").value == pytest.approx(exact.max(), rel=2e-3)


def test_bending_of_a_falling_beam():
    """A stiff beam that falls from a pin: M = m g L cos(angle) x (1 - x)^2/4 without vibrations, x from the pin."""
    errors = []
    for n in COUNTS:
        body = beam(n, material=replace(STEEL, young=2e13), damping=1e-3)
        pin = fm.Revolute("A", fm.GROUND, body, at=body.start)
        sol = fm.simulate(fm.Mechanism("falling", [body, pin], gravity=(0.0, -G)), t_end=0.05, save=3)
        angle = math.atan2(*(float(sol[f"beam.end.{axis}"][-1]) for axis in "yx"))
        found = sol.stress("beam").isel(time=-1)
        x = found["station"].values / LENGTH
        exact = -0.25 * MASS * G * math.cos(angle) * LENGTH**2 * x * (1.0 - x) ** 2 / MODULUS
        errors.append(np.abs(found["bending"].values - exact).max() / np.abs(exact).max())
    assert max(errors) < 2e-3, errors


def slider_crank(elements):
    crank = fm.RigidLink("crank", (0.0, 0.0), (0.05, 0.0), mass=0.3, inertia=1e-4)
    rod = beam(elements, at=(0.05, 0.0), length=0.2, section=fm.Rectangle(0.01, 0.01), damping=2e-5)
    piston = fm.RigidBody("piston", at=rod.end, mass=1e-3, inertia=1e-6)
    pins = [fm.Revolute(*args) for args in (("O", fm.GROUND, crank, (0, 0)), ("A", crank, rod, rod.start))]
    pins += [fm.Revolute("B", rod, piston, rod.end), fm.Prismatic("guide", fm.GROUND, piston, rod.end, (1.0, 0.0))]
    motor = fm.Drive("motor", joint="O", motion=fm.drives.CycloidalRamp(150.0, time=0.1))
    return fm.Mechanism("slider-crank", [crank, rod, piston, *pins, motor], gravity=(0.0, 0.0))


@pytest.mark.parametrize("method", [None, fm.RadauIIA()])
def test_rod_of_a_slider_crank(method):
    """The peak of the rod was .77, 1.20 and 1.03 of that of a fine mesh with 1, 2 and 4 elements."""
    peaks, inner = {}, {}
    for n in (1, 2, 4, 16):
        sol = fm.simulate(slider_crank(n), t_end=0.15, save="steps", step=fm.Adaptive(rtol=1e-5), method=method)
        peaks[n] = sol.peak("beam.von_mises").value
        inner[n] = float(sol.stress("beam")["von_mises"].max())
    assert peaks[1] == pytest.approx(peaks[16], rel=5e-3)
    assert peaks[2] == pytest.approx(peaks[16], rel=2e-3)
    assert peaks[4] == pytest.approx(peaks[16], rel=2e-3)
    assert all(0.97 * peaks[n] < inner[n] <= peaks[n] * (1.0 + 1e-9) for n in peaks)


@pytest.mark.parametrize("section", [SECTION, fm.Tapered(fm.Rectangle(0.02, 0.02), fm.Rectangle(0.02, 0.01))])
@pytest.mark.parametrize("shear", [False, True])
def test_any_beam_is_in_balance_with_its_wall(section, shear):
    """Moment and forces at the root are those of the wall in any motion, tapered, with shear and rotary inertia."""
    body = beam(3, section=section, shear=shear, turn=0.8)
    parts = [body, fm.Fixed("wall", fm.GROUND, body, at=body.start)]
    push = fm.drives.Harmonic(1.0, frequency=30.0)
    parts.append(fm.Force("tip", body, body.end, (30.0, -40.0), history=push))
    sol = fm.simulate(fm.Mechanism("any", parts, gravity=(2.0, -G)), t_end=0.05, save="steps")
    line = next(line for line in drawing.lines(sol, np.arange(len(sol.time)), 3) if line.is_beam)
    N, V, M = (line.fields[name][:, 0] for name in ("axial_force", "shear_force", "bending_moment"))
    np.testing.assert_allclose(M, -sol.array("wall.moment"), atol=1e-6 * np.abs(M).max())
    np.testing.assert_allclose(np.hypot(N, V), np.hypot(sol.array("wall.fx"), sol.array("wall.fy")), rtol=1e-6)


def test_without_saved_accelerations():
    """Stresses are refused, and pictures show the forces of elasticity alone."""
    poses = [f"beam.{node}.{axis}" for node in ("node0", "node1") for axis in ("x", "y", "theta")]
    sol = fm.simulate(clamped(1), t_end=1e-6, start="equilibrium", save=2, signals=poses)
    with pytest.raises(fm.errors.InputError, match=r"need velocities and accelerations .*'beam\.\*'"):
        sol.stress("beam")
    (line,) = (line for line in drawing.lines(sol, np.array([0]), 2) if line.is_beam)
    whole = MASS * G * LENGTH**2
    assert line.fields["bending_moment"][0] == pytest.approx([-5.0 / 12.0 * whole, whole / 12.0], rel=1e-4)


def test_files_keep_what_section_forces_need(tmp_path):
    sol = at_rest(supported(1))
    again = fm.load(sol.to_netcdf(tmp_path / "run.nc"))
    for one in (again, with_values(sol, sol.time, sol.values)):
        (line,) = (line for line in drawing.lines(one, np.array([0]), 3) if line.is_beam)
        assert line.fields["bending_moment"][0, 1] == pytest.approx(MASS * G * LENGTH**2 / 8.0, rel=1e-6)


def test_fatigue_between_nodes():
    """Cycles are those of the middle of the only element, where the stress is largest."""
    sol = fm.simulate(supported(1), t_end=0.2, save=400)
    found = sol.fatigue("beam")
    assert found.node == 2
    assert found.captured > 0.99
    assert found.ranges.max() == pytest.approx(2.0 * MASS * G * LENGTH**2 / 8.0 / MODULUS, rel=0.25)


def test_yield_under_the_weight_at_rest():
    """A root that yields although the elastic end moment of one element is below the limit."""
    exact = MASS * G * LENGTH**2 / 2.0 / MODULUS
    soft = replace(STEEL, yield_stress=0.9 * exact)
    mechanism = clamped(1, material=soft)
    assert [f.code for f in fm.check(mechanism).findings] == ["overload"]


@pytest.mark.parametrize(
    "elements",
    [
        pytest.param(n, marks=pytest.mark.slow) if n in (2, 4, 5, 6) else n
        for n in [1, 2, 3, 4, 5, 6, (0.1, 0.4), (0.3, 0.5)]
    ],
)
@pytest.mark.parametrize("shear", [False, True])
def test_deflection_of_the_middle(elements, shear):
    """The sag was 0 with one element and .869 of 5 w L^4/(384 E I) with three, that of a node beside the middle."""
    sol = at_rest(supported(elements, shear=shear, rotary_inertia=False))
    EI = STEEL.young * WIDTH * HEIGHT**3 / 12.0
    sag = 5.0 * MASS * G * LENGTH**4 / (384.0 * EI)
    if shear:
        factor = float(SECTION.shear_factor_at(0.0, STEEL.poisson))
        sag += MASS * G * LENGTH**2 / (8.0 * factor * STEEL.shear_modulus * WIDTH * HEIGHT)
    places = np.linspace(0.0, 1.0, elements + 1) if isinstance(elements, int) else np.array([0.0, *elements, 1.0])
    k = int(np.searchsorted(places, 0.5)) - 1
    size, along = LENGTH * (places[k + 1] - places[k]), (0.5 - places[k]) / (places[k + 1] - places[k])
    cubic = MASS * G * size**4 / (24.0 * EI) * (along * (1.0 - along)) ** 2  # the element alone, clamped at both ends
    if shear:
        cubic += MASS * G * size**2 * along * (1.0 - along) / (2.0 * factor * STEEL.shear_modulus * WIDTH * HEIGHT)
    assert sol.array("beam.deflection")[0] == pytest.approx(-(sag - cubic), rel=2e-6)


def test_deflection_of_an_arc_is_its_rise():
    """The rise of an arc with an odd number of elements, of the cubic of the middle one; it was that of a node."""
    for n in (3, 5, 9):
        body = beam(n, turn=-1.2)
        sol = at_rest(fm.Mechanism("arc", [body, fm.Fixed("wall", fm.GROUND, body, at=body.start)], gravity=(0.0, 0.0)))
        rise = 0.5 * LENGTH * math.tan(0.3)
        error = abs(sol.array("beam.deflection")[0] / rise - 1.0)
        assert error == pytest.approx(1.2**2 / (48.0 * n**4), rel=0.05)


def hook(section, radius, *, turn=-math.pi, load=100.0, shear=5.0 / 6.0):
    """A half ring that is clamped at its top and pulled down at its end; the moment opens it, P R, with N = P."""
    top = radius if turn < 0.0 else -radius
    more = {"section": section, "material": STEEL, "elements": 32, "turn": turn, "stress": True, "shear": shear}
    body = fm.FlexibleLink("hook", (0, top), (0, -top), **more)
    pull = fm.Force("P", body, (0, -top), (0.0, math.copysign(load, -top)))
    parts = [body, fm.Fixed("wall", fm.GROUND, body, (0, top)), pull]
    return fm.Mechanism("hook", parts, gravity=(0.0, 0.0))


def round_bar(R, y, width):
    """A e, r_n of a section by quadrature of its outline: widths (n,) at distances y (n,) from the centroid."""
    area, over = np.trapezoid(width, y), np.trapezoid(width / (R - y), y)
    return area * (R - area / over), area / over


OUTLINES = {
    "rectangle": (fm.Rectangle(0.01, 0.02), lambda y: np.full_like(y, 0.01)),
    "circle": (fm.Circle(0.02), lambda y: 2.0 * np.sqrt(np.maximum(0.01**2 - y**2, 0.0))),
    "tube": (
        fm.Tube(0.02, 0.012),
        lambda y: 2.0 * (np.sqrt(np.maximum(0.01**2 - y**2, 0.0)) - np.sqrt(np.maximum(0.006**2 - y**2, 0.0))),
    ),
}


@pytest.mark.quick(5)
@pytest.mark.parametrize("name", OUTLINES)
@pytest.mark.parametrize("over", slow_where(lambda n: n == 2.0, [1.0, 2.0, 4.0]))
@pytest.mark.parametrize("turn", [-math.pi, math.pi])
def test_thick_arcs_have_the_stress_of_winkler(name, over, turn):
    """The inner fibre of a hook had .69, .84 and .91 of its stress at R/h = 1, 2 and 4, that of a straight bar."""
    section, width = OUTLINES[name]
    R, c = 0.02 * over, 0.01
    y = c * np.sin(np.linspace(-0.5 * math.pi, 0.5 * math.pi, 20001))
    Ae, neutral = round_bar(R, y, width(y))
    mechanism = hook(section, R, turn=turn)
    sol = at_rest(mechanism)
    found = sol.stress("hook", [(R, 0.0)]).isel(time=0, place=0)
    N, A = 100.0, float(section.area_at(0.0))
    inner, outer = (N * R * (neutral - r) / (Ae * r) for r in (R - c, R + c))
    sides = (outer, inner) if turn < 0.0 else (inner, outer)  # the centre is on the right of a turn to the right
    assert float(found["axial"]) == pytest.approx(N / A, rel=2e-3)
    for fibre, wanted in zip(("bending", "bending_right"), sides, strict=True):
        assert float(found[fibre]) == pytest.approx(wanted, rel=2e-3)
    assert float(found["von_mises"]) == pytest.approx(N / A + inner, rel=2e-3)
    assert sol.peak("hook.von_mises").value == pytest.approx(N / A + inner, rel=2e-3)
    assert float(sol.notes[0].rpartition(" ")[2][:-1]) == pytest.approx(3e8 / (N / A + inner), rel=6e-3)


@pytest.mark.parametrize(
    ("over", "sheared", "slender"), [(1, 1.216, 0.985), (2, 1.057, 0.995), (4, 1.014, 0.9986), (10, 1.002, 0.9996)]
)
def test_hooks_are_softer_than_those_of_winkler(over, sheared, slender):
    """The end of a half ring over its way by Winkler's energy: M^2/(2 A e E R) - M N/(A E R) + N^2/(2 A E) + shear."""
    b, h, load = 0.01, 0.02, 1.0
    R, A, E, nu = over * h, b * h, STEEL.young, STEEL.poisson
    e, shear = R - h / math.log((R + h / 2) / (R - h / 2)), 2.0 * (1.0 + nu) * (12.0 + 11.0 * nu) / (10.0 * (1.0 + nu))
    way = 0.5 * math.pi * load * R / (A * E) * (R / e - 1.0 + shear)
    for told, ratio in ((True, sheared), (False, slender)):
        found = fm.static_equilibrium(hook(fm.Rectangle(b, h), R, load=load, shear=told))
        assert -(found["hook.end.y"] + R) / way == pytest.approx(ratio, abs=6e-4)


def test_stress_of_thin_arcs_is_that_of_straight_beams():
    """By c/(3 R) of a rectangle, down to arcs so flat that round-off would show."""
    for over in (1e2, 1e4, 1e6, 1e9):
        section = fm.Rectangle(0.01, 1e-3)
        body = fm.FlexibleLink("a", (0, 0), (1, 0), section=section, material=STEEL, turn=1e-3 / over, stress=True)
        straight = replace(body, turn=0.0)
        empty = fm.Mechanism("m", [body])
        curved, plain = (flexible.section_factors(one.beams[0], np.array([0.0, 0.5])) for one in (body, straight))
        R = body.beams[0].length / body.turn
        np.testing.assert_allclose(curved[..., 1] / plain[..., 1], 1.0 + 1e-3 / 3.0 / R, rtol=1e-5)
        assert empty.parts


def test_arcs_without_an_outline_are_told():
    """Area and second moment say nothing of the inner fibre; a section of one's own may."""
    bare = fm.GeneralSection(area=2e-4, second_moment=0.01 * 0.02**3 / 12.0, outer_fibre=0.01)
    (finding,) = (f for f in fm.check(hook(bare, 0.04)).findings if f.code == "thick-arc")
    assert "the radius of an arc is 2 times the height of its section" in str(finding)
    assert not [f for f in fm.check(hook(bare, 0.4)).findings if f.code == "thick-arc"]
    assert not [f for f in fm.check(hook(fm.Rectangle(0.01, 0.02), 0.04)).findings if f.code == "thick-arc"]

    class Own(fm.Section):
        def area_at(self, s):
            return np.full(np.shape(s), 2e-4)

        def second_moment_at(self, s):
            return np.full(np.shape(s), 0.01 * 0.02**3 / 12.0)

        def outer_fibre_at(self, s):
            return np.full(np.shape(s), 0.01)

        def over_radius_at(self, s, radius):
            return fm.Rectangle(0.01, 0.02).over_radius_at(s, radius)

    own, known = (at_rest(hook(one, 0.04)).peak("hook.von_mises").value for one in (Own(), fm.Rectangle(0.01, 0.02)))
    assert own == pytest.approx(known, rel=1e-9)
