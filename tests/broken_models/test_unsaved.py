"""The watch tells the same of a run whatever of it is saved, with contacts, controllers, gravity and meshes beside."""

import math

import numpy as np
import pytest
from broken import SOFT, YIELDING, O, beam, worn

import flexmb as fm
from flexmb.elastic.meshes.mesh import PlaneMesh

OMEGA, X = 192.0, 0.01
STEEL = fm.Material(2e11, 7800.0, 0.3)


@fm.control_kernel
def proportional(p, t, u, x, dx, y):
    """y = -k u, as of a spring."""
    y[0] = -p[0] * u[0]


@fm.control_kernel
def turning(p, t, u, x, dx, y):
    """States that turn with the angular frequency p."""
    dx[0], dx[1] = p[0] * x[1], -p[0] * x[0]
    y[0] = 0.0


def oscillator(*more, spring=True):
    """1 kg at 192 rad/s, x = X sin(OMEGA t), and further parts."""
    mass = fm.RigidBody("mass", O, 1.0, 0.1, velocity=(X * OMEGA, 0.0, 0.0))
    guide = fm.Prismatic("guide", fm.GROUND, mass, at=O, along=(1, 0))
    parts = [mass, guide, *(make(mass) for make in more)]
    if spring:
        parts.append(fm.SpringDamper("spring", fm.GROUND, mass, (-1.0, 0.0), O, stiffness=OMEGA**2))
    return fm.Mechanism("oscillator", parts)


def stop(name, **limits):
    """A stop of the guide, as stiff as the spring."""
    return lambda _: fm.Stop(name, "guide", normal=fm.contact.KelvinVoigt(OMEGA**2, 0.0), **limits)


def push(mass):
    return fm.Force("push", mass, at=O, force=(1.0, 0.0))


def law(_):
    return fm.Control("law", inputs=["mass.x"], loads=["push"], law=proportional, numbers=[OMEGA**2])


def lost(sol):
    """Phase that a run says its steps lose [rad]; None where it says nothing."""
    told = [note for note in sol.notes if "the steps lose some" in note]
    return float(told[0].split("lose some ")[1].split(" rad")[0]) if told else None


def lag(signal, omega):
    """Phase by which the end of a run lags behind sin(omega t), in half turns next to 0 [rad]."""
    late = signal.time > signal.time[-1] - 4.0 * math.pi / omega
    t, x = signal.time[late], signal.values[late]
    cosine, sine = np.linalg.lstsq(np.column_stack([np.cos(omega * t), np.sin(omega * t)]), x, rcond=None)[0]
    return math.atan2(-cosine, sine)


@pytest.mark.quick(2)
@pytest.mark.parametrize(
    "parts",
    [(), (stop("stop", above=1.0),), (push, law), (stop("right", above=1e-12), stop("left", below=-1e-12))],
    ids=["spring", "stop never touched", "law", "two stops"],
)
def test_the_phase_that_is_lost_is_told(parts):
    """20 s with default steps: the remark names the lag against sin(omega t), 0.8 to 1.9 rad."""
    mech = oscillator(*parts, spring=len(parts) < 2)
    sol = fm.simulate(mech, t_end=20.0, save="steps", signals=["mass.x"])
    assert lost(sol) == pytest.approx(lag(sol["mass.x"], OMEGA), rel=0.1)
    assert lost(sol) > 0.5


@pytest.mark.quick(1)
@pytest.mark.parametrize(
    "saved",
    [
        pytest.param({"signals": ["mass.x"]}, marks=pytest.mark.slow),
        {"signals": []},
        {"save": 3},
        pytest.param({"save_from": 19.0}, marks=pytest.mark.slow),
    ],
)
def test_the_same_is_told_whatever_is_saved(saved):
    whole, part = (fm.simulate(oscillator(), t_end=20.0, **options) for options in ({}, saved))
    assert lost(whole) == lost(part) > 0.5


def test_states_of_a_controller():
    """300 rad/s for 5 s."""
    states = {"sine": 0.0, "cosine": 1.0}
    control = fm.Control("clock", inputs=["mass.x"], loads=["push"], law=turning, numbers=[300.0], states=states)
    mech = oscillator(push, lambda _: control, spring=False)
    sol = fm.simulate(mech, t_end=5.0, save="steps", signals=["clock.sine"])
    (note,) = (note for note in sol.notes if "the steps lose some" in note)
    assert "vibration of a controller of 47.75 Hz (mostly clock.sine)" in note
    z = lag(sol["clock.sine"], 300.0)
    turns = round((lost(sol) - z) / (2.0 * math.pi))
    assert lost(sol) == pytest.approx(z + 2.0 * math.pi * turns, rel=0.1)


def swinging(angle):
    """A pendulum of 1 m."""
    body = fm.RigidBody("bob", (math.sin(angle), -math.cos(angle)), 1.0, 1e-6)
    pin = fm.Revolute("O", fm.GROUND, body, at=O)
    return fm.Mechanism("pendulum", [body, pin], gravity=(0.0, -9.81))


def test_a_pendulum_over_a_thousand_seconds():
    """x = sin(a) cos(omega t) with Lindstedt's omega = omega0 (1 - a^2/16): 0.14 rad are lost, and told."""
    angle, g = 0.1, 9.81
    sol = fm.simulate(swinging(angle), t_end=1000.0, save=4000)
    (note,) = (note for note in sol.notes if "the steps lose some" in note)
    assert "swing under its loads of 0.49" in note
    omega = math.sqrt(g) * (1.0 - angle**2 / 16.0 + 11.0 * angle**4 / 3072.0)
    late = sol.time > 990.0
    t, x = sol.time[late], sol["bob.x"].values[late]
    cosine, sine = np.linalg.lstsq(np.column_stack([np.cos(omega * t), np.sin(omega * t)]), x, rcond=None)[0]
    assert lost(sol) == pytest.approx(math.atan2(sine, cosine), rel=0.25)
    assert lost(fm.simulate(swinging(angle), t_end=10.0)) is None


@pytest.mark.quick(1)
@pytest.mark.parametrize("signals", [None, [], ["arm.node0.x"]])
def test_a_strain_is_told_whatever_is_saved(signals):
    """A block is bent to a loop."""
    block = beam("arm", O, (0.5, 0.0), fm.Rectangle(width=0.01, height=0.05), YIELDING, elements=4, stress=False)
    load = fm.Torque("load", block, 1e7 * 0.01 * 0.05**2 * 400.0)
    bent = fm.Mechanism("bent", [block, fm.Fixed("wall", fm.GROUND, block, at=O), load])
    sol = fm.simulate(bent, t_end=5e-3, signals=signals, save=1)
    assert not sol.ok
    assert "FlexibleLink 'arm' strains by" in sol.status


def test_a_penetration_before_saving_begins_is_told():
    """A journal that passes its centre: told by all steps, not by those that are saved."""
    fast = worn("A", normal=SOFT).with_({"motor.motion.speed": 60.0})
    whole = fm.simulate(fast, t_end=0.05)
    part = fm.simulate(fast, t_end=0.05, save_from=0.0499, signals=[])
    said = [[n for n in (*sol.notes, sol.status) if "is penetrated by" in n] for sol in (whole, part)]
    assert said[0]
    assert said[1]


def parting(couple):
    """Two wheels of 0.05 and 0.1 m, of which the second flies away at 1 m/s, and their coupling."""
    first, second = (
        fm.RigidBody("one", O, 1.0, 1e-3),
        fm.RigidBody("two", (0.15, 0.0), 1.0, 1e-3, velocity=(0.0, 1.0, 0.0)),
    )
    return fm.Mechanism("pair", [first, second, fm.Revolute("axis", fm.GROUND, first, at=O), couple(first, second)])


@pytest.mark.parametrize("signals", [None, [], ["one.theta"]])
@pytest.mark.parametrize(
    ("couple", "told"),
    [
        (lambda a, b: fm.couplings.Gear("mesh", a, b, teeth=(20, 40)), "the centres of the wheels of Gear 'mesh' are"),
        (lambda a, b: fm.couplings.Belt("belt", a, b, radii=(0.05, 0.1)), "the belt would stretch by"),
        (lambda _, b: fm.couplings.Rack("rack", b, fm.GROUND, at=(0.0, -0.1)), "is 1.1 m from the pitch line of Rack"),
    ],
    ids=["gear", "belt", "rack"],
)
def test_wheels_that_part_are_told_whatever_is_saved(couple, told, signals):
    notes = fm.simulate(parting(couple), t_end=1.0, signals=signals).notes
    assert [note for note in notes if told in note], notes


def test_length_of_a_belt():
    """Parallel strands of length d: the belt over equal wheels needs 2 d + 2 pi r, 20 % more at 1.63 m."""
    first, second = (
        fm.RigidBody("one", O, 1.0, 1e-3),
        fm.RigidBody("two", (1.0, 0.0), 1.0, 1e-3, velocity=(1.0, 0.0, 0.0)),
    )
    belt = fm.couplings.Belt("belt", first, second, radii=(0.1, 0.1))
    mech = fm.Mechanism("pair", [first, second, fm.Revolute("axis", fm.GROUND, first, at=O), belt])
    (note,) = (n for n in fm.simulate(mech, t_end=1.0, signals=[]).notes if "the belt would stretch by" in n)
    share = 100.0 * 2.0 / (2.0 + 0.2 * math.pi)
    assert f"are 2 m apart, drawn are 1 m: the belt would stretch by {share:.3g} % of its length" in note
    still = fm.simulate(mech.with_({"two.velocity": (0.0, 0.0, 0.0)}), t_end=1.0)
    assert not [n for n in still.notes if "the belt would" in n]


def grid(length, height, along, across, kind):
    """A rectangle of linear cells with the sets "left" and "right"."""
    x, y = (a.ravel() for a in np.meshgrid(np.linspace(0.0, length, along + 1), np.linspace(0.0, height, across + 1)))
    first = (np.arange(across)[:, None] * (along + 1) + np.arange(along)).ravel()
    cells = first[:, None] + np.array([0, 1, along + 2, along + 1])
    if kind == "tri3":
        cells = np.concatenate([cells[:, [0, 1, 2]], cells[:, [0, 2, 3]]])
    sets = {"left": np.flatnonzero(x == 0.0), "right": np.flatnonzero(x == length)}
    return PlaneMesh(np.column_stack([x, y]), cells, kind, sets=sets)


def cantilever(mesh, force=1.0):
    """A mesh of 1 m x 0.1 m x 0.01 m, clamped on the left, with a force on the right end."""
    plate = fm.PlaneBody("plate", mesh, at=O, thickness=0.01, material=STEEL, pins=("left", "right"))
    load = fm.Force("load", plate, at=(1.0, 0.05), force=(0.0, -force))
    return fm.Mechanism("cantilever", [plate, fm.Fixed("wall", fm.GROUND, plate, at=(0.0, 0.05)), load])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "along", "across"),
    [
        ("tri3", 20, 2),
        pytest.param("tri3", 40, 4, marks=pytest.mark.slow),
        pytest.param("quad4", 10, 1, marks=pytest.mark.slow),
        ("quad4", 10, 2),
    ],
)
def test_linear_cells_that_are_too_stiff(kind, along, across):
    """The deflection of beam theory with shear, F L^3/3EI + 1.2 F L/GA, over that of the mesh, by check and run."""
    mech = cantilever(grid(1.0, 0.1, along, across, kind))
    area, inertia, shear = 0.01 * 0.1, 0.01 * 0.1**3 / 12.0, STEEL.young / 2.0 / (1.0 + STEEL.poisson)
    exact = 1.0 / (3.0 * STEEL.young * inertia) + 1.2 / (shear * area)
    eq = fm.static_equilibrium(mech)
    stiffer = exact / (0.05 - eq.q[eq.names.index("plate.right.y")]) - 1.0
    (finding,) = (one for one in fm.check(mech).findings if one.code == "coarse-cells")
    assert finding.numbers["excess"] == pytest.approx(stiffer, rel=0.15)
    assert stiffer > 0.2
    sol = fm.simulate(mech, t_end=1e-5, signals=[])
    assert [note for note in sol.notes if "too stiff" in note and kind in note]


@pytest.mark.slow
def test_cells_that_bend():
    for mesh in (grid(1.0, 0.1, 80, 8, "tri3"), fm.meshes.rectangle(1.0, 0.1, 10, 1)):
        assert not [one for one in fm.check(cantilever(mesh)).findings if one.code == "coarse-cells"]


@pytest.mark.slow
@pytest.mark.parametrize("cells", [10, pytest.param(20, marks=pytest.mark.slow)])
def test_a_plate_of_many_coordinates(cells):
    """291 and 591 coordinates: the second mode of a cantilever beam, 22.03 sqrt(EI/rho A)/L^2 with shear, is told."""
    sol = fm.simulate(cantilever(fm.meshes.rectangle(1.0, 0.1, cells, 2), force=100.0), t_end=0.2, signals=[])
    (note,) = (note for note in sol.notes if "the steps lose some" in note)
    frequency = float(note.split("vibration of ")[1].split(" Hz")[0])
    euler = 22.034 * 0.1 / math.sqrt(12.0) * math.sqrt(STEEL.young / STEEL.density) / (2.0 * math.pi)
    assert 0.9 * euler < frequency < euler
