"""A run says when the highest modes of a reduced body hold much of its strain energy."""

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
