"""Stresses of beams, plane bodies and reduced bodies against closed forms, and against one another."""

from dataclasses import replace

import meshio
import numpy as np
import pytest

import flexmb as fm
from flexmb.errors import InputError

LENGTH, HEIGHT, WIDTH = 0.2, 0.02, 0.01
AREA, SECOND = WIDTH * HEIGHT, WIDTH * HEIGHT**3 / 12.0
STEEL = fm.Material(2.1e11, 7850.0, 0.3, yield_stress=3.5e8)
SECTION = fm.Rectangle(width=WIDTH, height=HEIGHT)
RAMP = 0.02
SLOW = fm.drives.Harmonic(-0.5, frequency=0.5 / RAMP, phase=np.pi / 2, mean=0.5)  # from 0 to 1 within RAMP
FORCE = (2000.0, -300.0)


def beam(**more):
    usual = {"section": SECTION, "material": STEEL, "damping": 2e-4}
    return fm.FlexibleLink("rod", (0, 0), (LENGTH, 0), **{**usual, **more})


def plate(cells=(10, 2), **more):
    mesh = fm.meshes.rectangle(LENGTH, HEIGHT, *cells)
    pins = {"pins": ("left", "right"), "at": (0, -0.5 * HEIGHT)}
    return fm.PlaneBody("rod", mesh, thickness=WIDTH, material=STEEL, damping=2e-4, **pins, **more)


def pulled(body, force=FORCE):
    """A cantilever, bent and pulled so slowly that it stands still at the end."""
    wall, load = fm.Fixed("wall", fm.GROUND, body, (0, 0)), fm.Force("F", body, (LENGTH, 0), force, history=SLOW)
    return fm.simulate(fm.Mechanism("cantilever", [body, wall, load]), t_end=RAMP, save=20, step=RAMP / 400)


def closed_form(x):
    """Axial stress, and bending stress of the fibre on the left (above), of a beam that is bent and pulled."""
    k = np.sqrt(FORCE[0] / (STEEL.young * SECOND))
    moment = FORCE[1] * np.sinh(k * (LENGTH - x)) / (k * np.cosh(k * LENGTH))
    return FORCE[0] / AREA, -moment * 0.5 * HEIGHT / SECOND


def test_cantilever_of_beams():
    sol = pulled(beam(elements=8))
    last = sol.stress("rod").isel(time=-1)
    axial, bending = closed_form(last["station"].values)
    np.testing.assert_allclose(last["axial"], axial, rtol=2e-3)
    np.testing.assert_allclose(last["bending"], bending, atol=3e-3 * bending.max())
    assert sol.array("rod.von_mises")[-1] == pytest.approx(float(last["von_mises"].max()), rel=1e-9)
    assert float(last["von_mises"].max()) == pytest.approx(axial + bending.max(), rel=3e-3)
    peak = sol.peak("rod.von_mises")
    assert (peak.node, peak.place) == (0, (0.0, 0.0))


def test_tapered_cantilever():
    """The moment over I at both ends of an element, not E times the curvature of its cubic."""
    root, tip = fm.Rectangle(width=WIDTH, height=2 * HEIGHT), fm.Rectangle(width=WIDTH, height=HEIGHT)
    sol = pulled(beam(section=fm.Tapered(root, tip), elements=2), force=(0.0, -300.0))
    last = sol.stress("rod", ["start", "node1"]).isel(time=-1)
    for x, found in zip((0.0, 0.5 * LENGTH), last["bending"].values[[0, 1]], strict=True):
        height = 2 * HEIGHT - HEIGHT * x / LENGTH
        assert found == pytest.approx(300.0 * (LENGTH - x) * 6.0 / (WIDTH * height**2), rel=2e-3)


class Wedge(fm.Section):
    """A plate of constant width that runs out to an edge."""

    def area_at(self, s):
        return WIDTH * HEIGHT * (1.0 - s)

    def second_moment_at(self, s):
        return SECOND * (1.0 - s) ** 3

    def outer_fibre_at(self, s):
        return 0.5 * HEIGHT * (1.0 - s)


def test_a_wedge_has_no_stress_at_its_tip():
    """Under its weight rho g L^2/h at the root; its tip was refused as a faulty kernel."""
    wedge = beam(section=Wedge())
    parts = [wedge, fm.Fixed("wall", fm.GROUND, wedge, at=(0.0, 0.0))]
    sol = fm.simulate(fm.Mechanism("wedge", parts, gravity=(0.0, -9.81)), t_end=1e-5, step=1e-5, start="equilibrium")
    assert sol.peak("rod.von_mises").value == pytest.approx(7850.0 * 9.81 * LENGTH**2 / HEIGHT, rel=1e-3)
    assert sol.stress("rod", ["end"])["von_mises"].values == pytest.approx(0.0)


def test_plate_and_its_reduction_bend_as_a_beam():
    """Far from the ends, where rigid pins disturb the stress."""
    full, small = pulled(plate()), pulled(fm.Reduced(plate(), modes=3))
    axial, bending = closed_form(0.5 * LENGTH)
    middle = [(0.5 * LENGTH, 0.5 * HEIGHT), (0.5 * LENGTH, -0.5 * HEIGHT)]
    for sol in (full, small):
        last = sol.stress("rod", middle).isel(time=-1)
        np.testing.assert_allclose(last["sx"], [axial + bending, axial - bending], rtol=5e-3)
        np.testing.assert_allclose(last["signed"], [axial + bending, axial - bending], rtol=5e-3)
        assert np.abs(last["sy"]).max() < 5e-3 * bending
        # the line through the Gauss points of half a parabola ends at 1/6 of its height
        np.testing.assert_allclose(last["txy"], 0.0, atol=0.17 * 1.5 * abs(FORCE[1]) / AREA)
    ends = [sol.stress("rod").isel(time=-1)["von_mises"].values for sol in (full, small)]
    np.testing.assert_allclose(ends[1], ends[0], atol=5e-3 * ends[0].max())
    assert full.peak("rod.von_mises").node == small.peak("rod.von_mises").node


def test_stresses_of_a_reduced_frame_lie_along_its_beams(tmp_path):
    """A column under a force at the end of an arm is stressed along y, also in files for ParaView."""
    corners, edges = ((0.0, 0.0), (0.0, 0.4), (0.3, 0.4)), ((0, 1), (1, 2))
    frame = fm.FlexibleFrame("L", corners, edges, section=fm.Rectangle(WIDTH, HEIGHT), material=STEEL)
    body = fm.Reduced(frame)
    parts = [body, fm.Fixed("foot", fm.GROUND, body, corners[0]), fm.Force("F", body, corners[2], (0.0, -1.0))]
    sol = fm.simulate(fm.Mechanism("L", parts, gravity=(0.0, 0.0)), t_end=1e-5, step=1e-5, start="equilibrium")
    left, axial = (-0.5 * HEIGHT, 0.2), -1.0 / AREA
    found = sol.stress("L", [left]).isel(time=-1, place=0)
    bending = 6.0 * 0.3 / (WIDTH * HEIGHT**2)
    assert [float(found[s]) for s in ("sx", "sy", "txy")] == pytest.approx(
        [0.0, axial + bending, 0.0], rel=1e-3, abs=1.0
    )
    frames = fm.write_vtk(sol, tmp_path / "L.pvd", frames=2).with_suffix("").glob("L_*.vtu")
    file = meshio.read(max(frames))
    k = np.hypot(*(file.points[:, :2] - left).T).argmin()
    assert [file.point_data[s][k] for s in ("stress_x", "stress_y")] == pytest.approx(
        [0.0, axial + bending], rel=1e-2, abs=10.0
    )


@pytest.mark.parametrize("reduced", [pytest.param(False, marks=pytest.mark.slow), True])
def test_axes_and_places_of_a_turned_body(reduced, tmp_path):
    """Stresses are those in the axes of the mesh, points those of the reference configuration."""
    angle, origin = 0.7, (0.3, -0.2)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    mesh = fm.meshes.rectangle(LENGTH, HEIGHT, 6, 1)
    more = {"thickness": WIDTH, "material": STEEL, "damping": 2e-4, "pins": ("left", "right")}
    body = fm.PlaneBody("rod", mesh, at=origin, angle=angle, **more)
    body = fm.Reduced(body, modes=3) if reduced else body
    start, end, probe = (origin + turn @ (x, y) for x, y in ((0, 0.01), (LENGTH, 0.01), (0.5 * LENGTH, HEIGHT)))
    load = fm.Force("F", body, tuple(end), tuple(turn @ FORCE), history=SLOW)
    parts = [body, fm.Fixed("wall", fm.GROUND, body, tuple(start)), load]
    sol = fm.simulate(fm.Mechanism("turned", parts), t_end=RAMP, save=20, step=RAMP / 400)
    last = sol.stress("rod", [tuple(probe)]).isel(time=-1, place=0)
    assert (float(last["x"]), float(last["y"])) == pytest.approx(tuple(probe))
    axial, bending = closed_form(0.5 * LENGTH)
    assert float(last["sx"]) == pytest.approx(axial + bending, rel=1e-2)
    peak = sol.peak("rod.von_mises")
    assert peak.place == pytest.approx(tuple(origin + turn @ mesh.points[peak.node]))
    again = fm.load(sol.to_netcdf(tmp_path / "run.nc")).peak("rod.von_mises")
    assert (again.node, again.place) == (peak.node, None if reduced else pytest.approx(peak.place))


def test_stress_is_that_of_the_signal():
    for body in (beam(), plate((6, 1)), fm.Reduced(beam(), modes=3), fm.Reduced(plate((6, 1)), modes=3)):
        sol = pulled(body)
        largest = sol.stress("rod")["von_mises"].values.max(axis=1)
        np.testing.assert_allclose(largest, sol.array("rod.von_mises"), rtol=1e-9, atol=1.0)


def test_no_stress_in_free_fall():
    for body in (beam(velocity=(1.0, 2.0, 0.0)), plate((4, 1), velocity=(1.0, 2.0, 0.0))):
        sol = fm.simulate(fm.Mechanism("fall", [body], gravity=(0.0, -9.81)), t_end=0.1, step=1e-3)
        assert sol.peak("rod.von_mises").value < 1e-12 * STEEL.young


def spun(body):
    """A rod that turns at a constant speed about a hub, after its vibrations have died out."""
    speed = 300.0
    hub = fm.Revolute("hub", fm.GROUND, body, (0, 0))
    drive = fm.Drive("motor", hub, fm.drives.ConstantSpeed(speed))
    sol = fm.simulate(fm.Mechanism("spun", [body, hub, drive]), t_end=4e-3, save=4, step=2e-6)
    return sol, STEEL.density * speed**2 * LENGTH**2 / 2.0


def test_centrifugal_stress_of_beams():
    """It was less by 1/(3 n^2) with n elements, the mean of the first one."""
    for elements in (1, 4, 8):
        sol, exact = spun(beam(elements=elements, damping=2e-5, velocity=None))
        found = float(sol.stress("rod", ["start"])["axial"][-1, 0])
        assert found == pytest.approx(exact, rel=3e-4)


@pytest.mark.slow
def test_centrifugal_stress_of_a_plate_and_its_reduction():
    full = plate((10, 1), interface="averaged")
    for body, error in ((full, 2.5e-3), (fm.Reduced(full, modes=24), 2.5e-3), (fm.Reduced(full, modes=12), 0.02)):
        sol, exact = spun(body)
        x = 0.2 * LENGTH
        found = float(sol.stress("rod", [(x, 0.0)])["sx"][-1, 0])
        assert found == pytest.approx(exact * (1.0 - (x / LENGTH) ** 2), rel=error)


def test_stress_is_sought_where_it_is_wanted():
    plain = replace(STEEL, yield_stress=None)
    unknown = fm.GeneralSection(area=AREA, second_moment=SECOND)
    assert beam().seeks_stress
    assert beam(material=plain, stress=True).seeks_stress
    assert not beam(stress=False).seeks_stress
    assert not beam(material=plain).seeks_stress
    assert not beam(section=unknown).seeks_stress
    with pytest.raises(InputError, match=r"a section does not know its outer fibre\. Give outer_fibre"):
        beam(section=unknown, stress=True)
    with pytest.raises(InputError, match="stress is 1; it must be True, False or None"):
        beam(stress=1)


@pytest.mark.parametrize("body", [beam, lambda **k: plate((6, 1), **k), lambda **k: fm.Reduced(plate((6, 1)), 3, **k)])
def test_run_is_the_same_with_and_without(body):
    sought, not_sought = pulled(body()), pulled(body(stress=False))
    for name in not_sought.names:
        assert np.array_equal(sought.array(name), not_sought.array(name))
    assert set(sought.names) - set(not_sought.names) == {"rod.von_mises", "rod.von_mises_node"}


def test_one_evaluation_gives_stress_and_node():
    """A body has one kernel of stresses and holds its numbers once; the node is that of the stress at all times."""
    for body in (beam(elements=3), plate((6, 1)), fm.Reduced(beam(), modes=3), fm.Reduced(plate((6, 1)), modes=3)):
        sol = pulled(body)
        signals = sol.mechanism.contributions().signals
        (k,) = [k for k, one in enumerate(signals) if one.name.startswith("von_mises")]
        held = fm.compile(sol.mechanism).tables.measured
        assert len(held.p) == len(signals)
        assert np.diff(held.p, axis=1)[k, 0] == len(signals[k].p)
        stress = sol.stress("rod")["von_mises"]
        nodes = stress["node"].values[stress.values.argmax(axis=1)]
        apart = np.sort(stress.values, axis=1)[:, -2:] @ [-1.0, 1.0] > 1e-9 * stress.values.max()
        assert np.array_equal(nodes[apart], sol.array("rod.von_mises_node")[apart])
        assert apart.sum() > 5


def test_the_largest_stress_may_be_sought_or_not():
    assert not plate(stress=False).seeks_stress
    assert not fm.Reduced(plate(stress=False)).seeks_stress
    assert fm.Reduced(plate(stress=False), stress=True).seeks_stress
    assert not fm.Reduced(beam(), stress=False).seeks_stress
    unknown = fm.GeneralSection(area=AREA, second_moment=SECOND)
    with pytest.raises(InputError, match="does not know its outer fibre"):
        fm.Reduced(beam(section=unknown), stress=True)
    with pytest.raises(InputError, match="stress is 1; it must be True or False"):
        plate(stress=1)


def test_a_controller_reads_a_largest_stress_at_instants_alone():
    body = plate((6, 1))
    parts = [fm.Fixed("wall", fm.GROUND, body, (0, 0)), fm.Force("F", body, (LENGTH, 0), FORCE)]
    mechanism = fm.Mechanism("m", [body, *parts, fm.controllers.PID("servo", "rod.von_mises", "F", kp=-1e-9)])
    with pytest.raises(fm.errors.ModelError, match=r"'rod\.von_mises' is the largest of many values.*Give sample="):
        fm.simulate(mechanism, t_end=1e-4)


def test_bad_questions(tmp_path):
    sol = pulled(beam())
    with pytest.raises(InputError, match=r"'tip' is no known point\. Give .* or names: .*end"):
        sol.stress("rod", ["tip"])
    with pytest.raises(InputError, match="has no stresses"):
        sol.stress("wall")
    loaded = fm.load(sol.to_netcdf(tmp_path / "run.nc"))
    with pytest.raises(InputError, match="Give mechanism="):
        loaded.stress("rod")
    again = loaded.stress("rod", ["end"], mechanism=sol.mechanism, times=[RAMP])
    other = beam(section=fm.Rectangle(width=0.02, height=0.03))
    with pytest.raises(InputError, match=r"is not the one that moved: its numbers differ. Give the mechanism"):
        loaded.stress("rod", mechanism=sol.mechanism.with_part(other))
    assert again["von_mises"].equals(sol.stress("rod", ["end"]).isel(time=[-1])["von_mises"])
    assert (loaded.peak("rod.von_mises").node, loaded.peak("rod.von_mises").place) == (0, None)
    assert fm.simulate(sol.mechanism, t_end=1e-3, signals=[]).names == ()


FOUR_MODELS = {
    "beams": lambda: beam(elements=8),
    "reduced beams": lambda: fm.Reduced(beam(elements=8), modes=3),
    "mesh": lambda: plate((10, 2)),
    "reduced mesh": lambda: fm.Reduced(plate((20, 2)), modes=3),
}


ALUMINIUM = fm.Material(7e10, 2700.0, 0.33)
OTHERS = {  # with other numbers than the one that moved
    "reduced beams": [
        lambda: fm.Reduced(beam(elements=8, material=ALUMINIUM), modes=3), lambda: fm.Reduced(beam(elements=8), 6),
        lambda: fm.Reduced(beam(elements=10), modes=3), lambda: beam(elements=8),
    ],
    "mesh": [
        lambda: replace(plate((10, 2)), material=ALUMINIUM), lambda: plate((12, 2)),
        lambda: replace(plate((10, 2)), state="strain"), lambda: fm.Reduced(plate((10, 2)), modes=3),
    ],
    "reduced mesh": [
        lambda: fm.Reduced(replace(plate((20, 2)), material=ALUMINIUM), modes=3),
        lambda: fm.Reduced(plate((10, 2)), modes=3), lambda: fm.Reduced(plate((20, 2)), modes=6),
        lambda: plate((20, 2)),
    ],
}  # fmt: skip


@pytest.mark.quick(1)
@pytest.mark.parametrize("kind", OTHERS)
def test_stresses_of_a_file_need_the_body_that_moved(kind, tmp_path):
    """Once a reduced bar of aluminium for one of steel had a third of its stress; other loads change nothing."""
    body = FOUR_MODELS[kind]()
    sol = pulled(body, force=(0.0, -300.0))
    loaded = fm.load(sol.to_netcdf(tmp_path / "run.nc"))
    same = fm.Mechanism("again", [FOUR_MODELS[kind](), fm.Fixed("wall", fm.GROUND, body, (0, 0))])
    found = loaded.stress("rod", mechanism=same)
    assert found["von_mises"].values == pytest.approx(sol.stress("rod")["von_mises"].values, rel=1e-6, abs=1.0)
    for other in OTHERS[kind]:
        with pytest.raises(
            InputError, match=r"'rod' is not the one that moved: its numbers differ\. Give the mechanism"
        ):
            loaded.stress("rod", mechanism=sol.mechanism.with_part(other()))


@pytest.mark.parametrize("kind", FOUR_MODELS)
def test_middle_of_a_cantilever(kind):
    """P x^2 (3 L - x) / (6 E I) and a share of 3 E / (5/6 G) (h/L)^2 / 4 = 2 % by shear; start at the wall stays."""
    sol = pulled(FOUR_MODELS[kind](), force=(0.0, -300.0))
    x = 0.5 * LENGTH
    fibres = [(x, 0.5 * HEIGHT), (x, -0.5 * HEIGHT)] if kind != "beams" else [(x, 0.0)]
    found = sol.positions("rod", [*fibres, (0.0, 0.0)])
    exact = -300.0 * x**2 * (3.0 * LENGTH - x) / (6.0 * STEEL.young * SECOND)
    middle = found.isel(place=slice(0, -1)).mean("place")
    assert float(middle["y"][-1]) == pytest.approx(exact, rel=0.03)
    assert float(middle["x"][0]) == pytest.approx(x, abs=1e-9)
    assert found["x0"].values[0] == pytest.approx(x)
    np.testing.assert_allclose(found["y"][:, -1], found["y0"][-1], atol=0.02 * abs(exact))
    (last,) = sol.positions("rod", fibres[:1], times=[RAMP])["time"].values
    assert last == RAMP


def test_bad_questions_of_positions(tmp_path):
    sol = pulled(beam())
    with pytest.raises(InputError, match="is no flexible body; its signals wall"):
        sol.positions("wall")
    with pytest.raises(InputError, match="is no known point"):
        sol.positions("rod", ["tip"])
    loaded = fm.load(sol.to_netcdf(tmp_path / "run.nc"))
    with pytest.raises(InputError, match="Give mechanism="):
        loaded.positions("rod")
    again = loaded.positions("rod", ["end"], mechanism=sol.mechanism)
    np.testing.assert_array_equal(again["y"][:, 0], sol.array("rod.end.y"))
