"""No false alarm: sound mechanisms have notes at most, or the warning that is true of them."""

import math
from dataclasses import replace

import pytest
from andrews import andrews
from broken import (
    STEEL_BAR,
    O,
    beam,
    column,
    four_bar,
    link,
    pendulum,
    servo,
    slider_crank,
    tall_mast,
    truss,
    two_masses,
    upright,
    worn,
)
from published import free_rod, n_four_bar, simeon
from spin_up import spinning_beam

import flexmb as fm

M = fm.mechanisms


def chain(count):
    """Links hanging from a pin."""
    bars = [link(f"bar{k}", (0.1 * k, 0.0), (0.1 * (k + 1), 0.0)) for k in range(count)]
    owners = [fm.GROUND, *bars]
    pins = [fm.Revolute(f"pin{k}", owners[k], owners[k + 1], at=(0.1 * k, 0.0)) for k in range(count)]
    return fm.Mechanism("chain", [*bars, *pins], gravity=(0.0, -9.81))


def scotch_yoke():
    """A crank pin in a slot."""
    crank = link("crank", O, (0.0, 0.1))
    yoke = fm.RigidBody("yoke", (0.0, 0.1), 1.0, 0.1)
    guide = fm.Prismatic("guide", fm.GROUND, yoke, at=(0.0, 0.1), along=(1, 0))
    slot = fm.PinSlot("slot", yoke, crank, at=(0.0, 0.1), along=(0, 1))
    pin = fm.Revolute("O", fm.GROUND, crank, at=O)
    return fm.Mechanism("yoke", [crank, yoke, guide, slot, pin, fm.Drive("motor", "O", fm.ConstantSpeed(5.0))])


def oscillator(spring=True):
    """A mass on a spring, or a rotor on bushings."""
    mass = fm.RigidBody("mass", O, 1.0, 0.1)
    if spring:
        guide = fm.Prismatic("guide", fm.GROUND, mass, at=O, along=(1, 0))
        holder = fm.SpringDamper("spring", fm.GROUND, mass, (-0.2, 0.0), O, stiffness=100.0, damping=1.0)
        return fm.Mechanism("oscillator", [mass, guide, holder])
    return fm.Mechanism("rotor", [mass, fm.Bushing("bush", fm.GROUND, mass, at=O, stiffness=(1e4, 1e4), torsion=3.0)])


def satellite():
    """Two bodies on a hinge, free in space."""
    one, two = link("one", O, (0.5, 0.0)), link("two", (0.5, 0.0), (1.0, 0.0))
    return fm.Mechanism("satellite", [one, two, fm.Revolute("hinge", one, two, at=(0.5, 0.0))])


def laws(normal, friction=None):
    """A worn slider-crank with these laws."""
    more = {"friction": friction} if friction else {}
    return worn("B", normal=normal, **more)


STUBBY = {"stubby-beam"}
HYSTERESIS = [fm.HuntCrossley, fm.contact.LeeWang, fm.contact.Flores, fm.contact.HuGuo, fm.contact.CarvalhoMartins]
SOUND = {
    "nine-bar, ideal": (M.nine_bar, set()),
    "nine-bar, clearance": (lambda: M.nine_bar(2 * math.pi, clearance=5e-4), set()),
    "nine-bar, small clearance": (lambda: M.nine_bar(2.5 * math.pi, clearance=5e-5), set()),
    "nine-bar, flexible": (lambda: M.nine_bar(flexible=True), STUBBY),
    "nine-bar, flexible, clearance": (lambda: M.nine_bar(2 * math.pi, clearance=5e-4, flexible=True), STUBBY),
    "slider-crank": (M.slider_crank, set()),
    "slider-crank, clearance": (lambda: M.slider_crank(clearance=5e-4), set()),
    "slider-crank, flexible": (lambda: M.slider_crank(flexible=True), set()),
    "slider-crank, both": (lambda: M.slider_crank(clearance=1e-4, flexible=True), set()),
    "four-bar": (M.four_bar, set()),
    "four-bar, flexible": (lambda: M.four_bar(flexible=True), set()),
    "four-bar, clearance": (lambda: M.four_bar(clearance=1e-4), set()),
    "Andrews": (andrews, set()),
    "Simeon": (simeon, set()),
    "spinning beam": (spinning_beam, set()),
    "free rod": (free_rod, set()),
    "two four-bars": (lambda: n_four_bar(2), set()),
    "forty four-bars": (lambda: n_four_bar(40), set()),
    "own slider-crank": (slider_crank, set()),
    "own slider-crank, slow": (lambda: slider_crank(motion=fm.drives.CycloidalRamp(6.28, 1.0)), set()),
    "own slider-crank, swinging": (lambda: slider_crank(motion=fm.drives.Harmonic(0.5, 10.0)), set()),
    "own slider-crank, by a table": (
        lambda: slider_crank(
            motion=fm.drives.Table(
                tuple(0.1 * k for k in range(13)), tuple(math.sin(math.pi * k / 6.0) for k in range(13)), periodic=True
            )
        ),
        set(),
    ),
    "crank-rocker": (lambda: four_bar(motion=fm.ConstantSpeed(3.0)), set()),
    "double crank": (lambda: four_bar((0.3, 0.25, 0.3, 0.1), 1.0, fm.ConstantSpeed(3.0)), set()),
    "rocker that swings within its range": (
        lambda: four_bar((0.3, 0.1, 0.3, 0.32), 1.2, fm.drives.Harmonic(0.05, 2.0)), set(),
    ),
    "four-bar without a drive": (four_bar, set()),
    "pendulum": (pendulum, set()),
    "pendulum with a damper": (lambda: pendulum(fm.Torque("moment", link("arm", O, (0.3, -0.2)), 0.1)), set()),
    "flexible pendulum": (lambda: pendulum(body=beam("arm", O, (0.3, -0.2))), set()),
    "upright pendulum on a spring": (lambda: upright(1.05), set()),
    "mast under its weight": (lambda: tall_mast(0.75), set()),
    "masses on springs of 1e12 and 1e3 N/m": (lambda: two_masses(1e12, 1e3), set()),
    "servo": (lambda: servo(200.0, 20.0, 100.0), set()),
    "weak servo": (lambda: servo(0.1, 0.01), set()),
    "chain of 3": (lambda: chain(3), set()),
    "chain of 30": (lambda: chain(30), set()),
    "truss": (lambda: truss(O, (0.3, 0.4), (0.6, 0.0)), set()),
    "column with little load": (lambda: column(STEEL_BAR, 50.0), set()),
    "cantilever with little load": (lambda: column(STEEL_BAR, 10.0, direction=(1.0, 0.0)), set()),
    "Scotch yoke": (scotch_yoke, set()),
    "oscillator": (oscillator, set()),
    "rotor on bushings": (lambda: oscillator(spring=False), set()),
    "satellite": (satellite, set()),
    "worn, in zero gravity": (worn, set()),
    "worn, under its weight": (lambda: replace(worn("B"), gravity=(0.0, -9.81)), set()),
    "worn, Kelvin-Voigt": (lambda: laws(fm.KelvinVoigt(1e8, 1e3, ramp=1e-6)), set()),
    "worn, Hertz, LuGre": (lambda: laws(fm.contact.Hertz(1e9), fm.friction.LuGre(0.2, 0.1)), set()),
    "worn, Stribeck": (lambda: laws(fm.HuntCrossley(1e9, restitution=0.95), fm.friction.Stribeck(0.2, 0.1)), set()),
    **{kind.__name__: (lambda kind=kind: laws(kind(1e9, restitution=0.95)), set()) for kind in HYSTERESIS},
    **{kind.__name__: (lambda kind=kind: laws(fm.contact.Hertz(1e9), kind(0.2, 0.1)), set())
       for kind in (fm.friction.BengisuAkay, fm.friction.BrownMcPhee)},
}  # fmt: skip
"""Mechanisms, and the codes of warnings that are true of them."""


def test_there_are_forty_of_them():
    assert len(SOUND) >= 40


@pytest.mark.quick(1)
@pytest.mark.parametrize("case", SOUND)
def test_a_sound_mechanism_is_left_alone(case):
    build, wanted = SOUND[case]
    report = fm.check(build(), step=1e-6)
    assert report.ok, report
    assert {finding.code for finding in report.findings if finding.severity != "note"} == wanted, report
