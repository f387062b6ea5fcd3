"""A run says when a reduced body is deformed by more than a reduced body can be."""

import flexmb as fm


def drop(young, t_end=0.2, joint="clamp", signals=None, **options):
    """A rod of 1 m that falls about its start."""
    soft = fm.Material(young=young, density=1000.0)
    section = fm.Rectangle(width=0.01, height=0.02)
    rod = fm.FlexibleLink("rod", (0.0, 0.0), (1.0, 0.0), section=section, material=soft, elements=12)
    small = fm.Reduced(rod, modes=3, **options)
    held = fm.Fixed("clamp", fm.GROUND, small, at=(0.0, 0.0))
    if joint == "hinge":
        held = fm.Revolute("hinge", fm.GROUND, small, at=(0.0, 0.0))
    return fm.simulate(
        fm.Mechanism("drop", [small, held], gravity=(0.0, -9.81)), t_end=t_end, step=1e-4, save=200, signals=signals
    )


def told(texts):
    return [text for text in texts if "deformed by" in text]


def test_small_deformations_are_not_told():
    sol = drop(1e9)
    assert sol.ok, sol.status
    assert not told(sol.notes)


def test_a_tenth_of_the_size_is_told_and_what_to_do():
    sol = drop(2e8, t_end=0.3, frame="pin")
    assert sol.ok, sol.status
    (note,) = told(sol.notes)
    deflection = -sol.array("rod.end.y").min()
    assert f"deformed by {100.0 * deflection:.2g}" in note
    assert 'Take frame="chord"' in note


def test_half_of_the_size_is_not_ok():
    sol = drop(1e7, t_end=0.4, frame="pin", stiffening=False)
    assert not sol.ok
    assert "beyond the small deformations that a reduced body is for" in sol.status


def test_a_run_that_fails_names_the_body():
    sol = drop(2e7, t_end=1.0, joint="hinge", frame="pin")
    assert not sol.ok
    assert "Reduced 'rod'" in sol.status
    assert "beyond the small deformations" in sol.status


def test_a_frame_on_a_hinged_pin_is_named():
    """Its angle follows the vibrations of the hinged end, whose mass matrix stiffening makes indefinite."""
    sol = drop(2e7, joint="hinge", pins=("start",))
    assert not sol.ok
    assert "its frame follows the vibrations of one pin" in sol.status
    assert "Take a second pin" in sol.status
    second = drop(2e7, joint="hinge")
    assert second.ok, second.status


def test_results_without_poses_are_judged_alike():
    whole, part = (drop(1e7, 0.4, frame="pin", stiffening=False, signals=one) for one in (None, ["rod.end.y"]))
    assert told([part.status])
    assert part.status == whole.status
