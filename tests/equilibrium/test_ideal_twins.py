"""Inverse dynamics beside a run of the same motion, for each part that it takes as an ideal one or leaves as it is."""

import math

import numpy as np
import pytest

import flexmb as fm
from flexmb.cams import CircularCurve

LAW = fm.KelvinVoigt(stiffness=1e8, damping=3e5, ramp=1e-6)
RUB = fm.friction.SmoothCoulomb(0.2, 1e-3)
SPEED = 3.0
DISC = fm.ClosedCurve([(0.01 + 0.03 * math.cos(a), 0.03 * math.sin(a)) for a in np.linspace(0.0, 2 * math.pi, 61)[:-1]])


def slider_crank(at_pin=None, at_guide=None, *further):
    """A crank driven at a constant speed, against 200 N on its slider; joints are changed by name."""
    crank, rod = fm.RigidLink("crank", (0, 0), (0.1, 0), 0.5, 0.01), fm.RigidLink("rod", (0.1, 0), (0.4, 0), 0.5, 0.01)
    slider = fm.RigidBody("slider", (0.4, 0.0), mass=2.0, inertia=0.1)
    pin, guide = at_pin or fm.Revolute, at_guide or fm.Prismatic
    return fm.Mechanism("slider-crank", [
        crank, rod, slider,
        fm.Revolute("O", fm.GROUND, crank, at=(0, 0)), pin("B", crank, rod, at=(0.1, 0)),
        fm.Revolute("C", rod, slider, at=(0.4, 0)), guide("S", fm.GROUND, slider, along=(1, 0)),
        fm.Drive("motor", "O", fm.ConstantSpeed(SPEED)), fm.Force("F", slider, (0.4, 0), (-200.0, 0.0)),
        *(make(slider) for make in further),
    ], gravity=(0.0, -9.81))  # fmt: skip


def play(**given):
    def pin(name, first, second, at):
        return fm.RevoluteClearance(
            name, first, second, at, clearance=1e-6, bearing_radius=0.02, normal=LAW, start=(1e-6, 0.0), **given
        )

    return pin


def guided(**given):
    def guide(name, first, second, along):
        sizes = {"clearance": 1e-6, "half_length": 0.05, "half_height": 1e-3}
        return fm.PrismaticClearance(name, first, second, along=along, normal=LAW, **sizes, **given)

    return guide


def soft(name, first, second, at):
    return fm.Bushing(name, first, second, at, stiffness=1e8, damping=3e5)


def yoke(**given):
    """Scotch yoke: the pin of the crank in a slot of the slider."""
    at = (0.1 * math.cos(0.3), 0.1 * math.sin(0.3))
    crank, slider = fm.RigidLink("crank", (0, 0), at, 0.5, 0.01), fm.RigidBody("yoke", (0.3, 0), mass=2.0, inertia=0.1)
    slot = fm.PinSlotClearance(
        "B", slider, crank, at, along=(0, 1), clearance=1e-6, pin_radius=0.01, normal=LAW, **given
    )
    return fm.Mechanism("yoke", [
        crank, slider, slot, fm.Revolute("O", fm.GROUND, crank, at=(0, 0)), fm.Prismatic("S", fm.GROUND, slider),
        fm.Drive("motor", "O", fm.ConstantSpeed(SPEED)), fm.Force("F", slider, (0.3, 0), (-200.0, 0.0)),
    ], gravity=(0.0, -9.81))  # fmt: skip


def cam(pair, **given):
    """Eccentric disc under a follower with a spring."""
    disc = fm.RigidBody("disc", (0, 0), mass=0.5, inertia=1e-3)
    follower = fm.RigidBody("follower", (0.0, 0.03), mass=0.3, inertia=1e-4)
    return fm.Mechanism("cam", [
        disc, follower, pair(disc, follower, normal=LAW, **given), fm.Revolute("O", fm.GROUND, disc, at=(0, 0)),
        fm.Prismatic("S", fm.GROUND, follower, along=(0, 1)),
        fm.SpringDamper("spring", fm.GROUND, follower, at=(0, 0.2), to=(0, 0.03), stiffness=2e3, free_length=0.2),
        fm.Drive("motor", "O", fm.ConstantSpeed(SPEED)),
    ])  # fmt: skip


def flat(disc, follower, **given):
    return fm.CurveOnCurve("B", disc, DISC, follower, fm.Line((-0.05, 0.03), (0.05, 0.03)), **given)


def roller(disc, follower, **given):
    return fm.CurveOnCurve("B", disc, DISC, follower, CircularCurve((0.0, math.sqrt(0.0015)), 0.01), **given)


def edge(disc, follower, **given):
    return fm.cams.PointOnCurve("B", disc, DISC, follower, (0.0, math.sqrt(8e-4)), **given)


def wheels(pair, apart):
    """Two wheels, 5 N m on the second one, the first one driven."""
    one, two = (fm.RigidBody(name, (x, 0.0), mass=1.0, inertia=1e-3) for name, x in (("one", 0.0), ("two", apart)))
    return fm.Mechanism("wheels", [
        one, two, pair(one, two), fm.Revolute("O", fm.GROUND, one, at=(0, 0)),
        fm.Revolute("S", fm.GROUND, two, at=(apart, 0)), fm.Drive("motor", "O", fm.ConstantSpeed(SPEED)),
        fm.Torque("load", two, 5.0),
    ])  # fmt: skip


def teeth(**given):
    return lambda one, two: fm.Gear("B", one, two, backlash=1e-6, normal=LAW, **given)


def belt(crossed):
    grip = {"coefficient": 0.4, "pretension": 400.0, "creep": 1e-4}
    return lambda one, two: fm.couplings.Belt("B", one, two, radii=(0.02, 0.04), crossed=crossed, **grip)


def stop(law):
    """Pressed by 1 mm at the start, and deeper as the slider moves."""
    return lambda slider: fm.Stop("stop", "S", below=-1e-4, normal=law)


def edge_of_wall(slider):
    wall = fm.cams.Outline([(0.1, 0.5), (0.1, -0.5), (0.297, -0.5), (0.297, 0.5)])
    ball = CircularCurve((0.4, 0.0), 0.1)
    return fm.cams.OutlineContact("stop", fm.GROUND, wall, slider, ball, normal=fm.contact.Hertz(1e7))


SPRING = fm.KelvinVoigt(2e5, 0.0)
MODELS = {
    "journal": (slider_crank(play()), 2e-3),
    "journal with friction": (slider_crank(play(friction=RUB)), 0.02),
    "guide": (slider_crank(None, guided()), 1e-4),
    "guide with friction": (slider_crank(None, guided(friction=RUB)), 1e-3),
    "bushing": (slider_crank(soft), 1e-4),
    "slot": (yoke(), 1e-5),
    "slot with friction": (yoke(friction=RUB), 1e-4),
    "flat follower": (cam(flat), 1e-3),
    "flat follower with friction": (cam(flat, friction=RUB), 1e-3),
    "roller with friction": (cam(roller, friction=RUB), 1e-3),
    "edge with friction": (cam(edge, friction=RUB), 1e-3),
    "gear": (wheels(teeth(teeth=(20, 40)), 0.06), 1e-3),
    "ring": (wheels(teeth(teeth=(20, 60), internal=True), 0.04), 1e-3),
    "open belt": (wheels(belt(False), 0.2), 1e-6),
    "crossed belt": (wheels(belt(True), 0.2), 1e-6),
    "spring as a stop": (slider_crank(None, None, stop(SPRING)), 1e-6),
    "damped stop": (slider_crank(None, None, stop(fm.KelvinVoigt(2e5, 3e3))), 1e-6),
    "wall": (slider_crank(None, None, edge_of_wall), 1e-6),
}


@pytest.mark.quick(1)
@pytest.mark.parametrize(
    "case",
    [
        pytest.param(n, marks=pytest.mark.slow)
        if n
        in (
            "journal with friction",
            "guide",
            "slot with friction",
            "flat follower with friction",
            "roller with friction",
            "bushing",
            "wall",
            "ring",
            "damped stop",
            "spring as a stop",
        )
        else n
        for n in MODELS
    ],
)
def test_forces_are_those_of_a_run(case):
    """The same motion, mean of 0.2 to 0.3 s: torque of the drive, forces of the pins at its ends.

    A journal circles in its clearance, which nothing damps; its friction is mu N, that of an ideal pin mu |force|.
    """
    mech, rel = MODELS[case]
    times = np.linspace(0.2, 0.3, 201)
    sol, found = fm.simulate(mech, t_end=0.3, save=np.append(0.0, times)), fm.inverse_dynamics(mech, times)
    assert sol.ok, sol.status
    kept = slice(1, None)
    torque = sol["motor.torque"].values[kept].mean()
    assert found.torque("motor").mean() == pytest.approx(torque, rel=rel)
    pin = [float(sol[f"O.{axis}"].values[kept].mean()) for axis in ("fx", "fy")]
    assert np.hypot(*(found.forces["O"][:, :2].mean(axis=0) - pin)) < rel * np.hypot(*pin)
    replaced = any(c.holds != "always" for c in mech.contributions().constraints)
    assert bool(found.notes) == replaced


def test_a_law_with_a_history_is_named():
    """Bristles that have not moved hold nothing: a run slides with mu N."""
    bristles = fm.friction.LuGre(0.3, 0.3, 0.01, 1e5, 100.0)

    def rubbing(name, first, second, at):
        return fm.Revolute(name, first, second, at, friction=bristles, radius=0.02)

    found = fm.inverse_dynamics(slider_crank(rubbing), [0.1])
    assert len(found.notes) == 1
    assert found.notes[0].startswith("Friction of B follows from a history, of which single instants know nothing")
    assert found.notes[0] in repr(found)
    assert found.notes[0] in found._repr_html_()
    wheel, hand = (fm.RigidBody(name, (x, 0.0), mass=1.0, inertia=1.0) for name, x in (("wheel", 0.0), ("hand", 1.0)))
    driven = fm.Mechanism("backstop", [
        wheel, fm.couplings.OneWayClutch("lock", fm.GROUND, wheel, at=(0, 0), stiffness=1e3),
        hand, fm.Revolute("O", fm.GROUND, hand, at=(1, 0)), fm.Drive("motor", "O", fm.ConstantSpeed(-1.0)),
        fm.couplings.SameRotation("belt", hand, wheel),
    ])  # fmt: skip
    assert "Friction of lock" in fm.inverse_dynamics(driven, [0.0]).notes[0]
