"""A run says when the highest modes of a reduced body hold much of its strain energy."""

import dataclasses

import pytest

import flexmb as fm

STEEL = fm.Material(young=2.1e11, density=7850.0)


def run(modes, at, weight=9.81):
    """A rod that is struck in its middle or at its end."""
    section = fm.Rectangle(width=0.01, height=0.02)
    rod = fm.FlexibleLink("rod", (0.0, 0.0), (1.0, 0.0), section=section, material=STEEL, elements=12)
    small = fm.Reduced(rod, modes=modes, pins=("start", "node6", "end"))
    parts = [small, fm.Revolute("A", fm.GROUND, small, (0.0, 0.0))]
    if at == "middle of the halves":
        small = fm.Reduced(rod, modes=modes)
        parts = [small, *(fm.Revolute(n, fm.GROUND, small, (x, 0.0)) for n, x in (("A", 0.0), ("B", 1.0)))]
        return fm.simulate(fm.Mechanism("struck", parts, gravity=(0.0, -weight)), t_end=0.05, step=1e-5, save=50)
    force = fm.Force("blow", small, at=(1.0, 0.0), force=(0.0, 10.0))
    return fm.simulate(fm.Mechanism("struck", [*parts, force]), t_end=0.02, step=1e-5, save=50)


def told(sol):
    return [note for note in sol.notes if "modes are missing" in note]


def test_weight_between_two_pins_is_told():
    """Gravity bends a rod on two supports as its first vibrations do: its energy lies in the only three."""
    (note,) = told(run(3, "middle of the halves"))
    assert "modes=6" in note
    assert "Hz with held pins" in note


def test_forces_at_pins_are_not():
    assert not told(run(6, "end"))


def test_shortening_by_bending_is_no_energy_of_modes():
    """A rod of many modes that bends by a fiftieth of its length."""
    assert not told(run(12, "middle of the halves", weight=600.0))


def test_round_off_of_a_falling_body_is_no_energy():
    section = fm.Rectangle(width=0.01, height=0.02)
    rod = fm.FlexibleLink("rod", (0.0, 0.0), (1.0, 0.0), section=section, material=STEEL, elements=6)
    falling = fm.Mechanism("falling", [fm.Reduced(rod, modes=3)], gravity=(0.0, -9.81))
    assert not fm.simulate(falling, t_end=0.1, save=50).notes


def test_errors_of_steps_in_a_stiff_body_are_none():
    """2e17 Pa: the modes hold less than the errors of default steps, 3e-9 of the length."""
    mech = fm.mechanisms.slider_crank(100.0, flexible=True)
    rod = dataclasses.replace(mech.find("rod"), material=fm.Material(young=2e17, density=7850.0))
    sol = fm.simulate(mech.with_part(fm.Reduced(rod, modes=6)), t_end=0.02, save=100)
    assert not told(sol)


@pytest.mark.parametrize("kind", [fm.Reduced, fm.PlaneBody])
def test_lost_vibrations_are_told(kind):
    """A cantilever of one body, which is neither of beams nor a spring, with steps of a seventh of its period."""
    mesh = fm.meshes.rectangle(1.0, 0.05, 6, 1)
    bar = fm.PlaneBody("bar", mesh, thickness=0.01, material=STEEL, pins=("left", "right"), stress=False)
    body = bar if kind is fm.PlaneBody else fm.Reduced(bar)
    foot, tip = ((pin.x, pin.y) for pin in bar.pin_nodes)
    parts = [body, fm.Fixed("foot", fm.GROUND, body, at=foot), fm.Force("F", body, tip, (0.0, -50.0))]
    sol = fm.simulate(fm.Mechanism("bar", parts, gravity=(0.0, 0.0)), t_end=0.5, step=3e-3, save=150)
    (note,) = [note for note in sol.notes if "of its phase" in note]
    assert note.startswith("The vibration of 4")
