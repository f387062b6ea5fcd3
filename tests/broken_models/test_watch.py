"""Runs that cannot be right are not ok, and say when, where and what to do; sound runs stay untouched."""

import math
from dataclasses import dataclass

import pytest
from broken import (
    SOFT,
    STEEL_BAR,
    WAVE,
    YIELDING,
    Driving,
    NotFinite,
    O,
    Pulling,
    Sticky,
    WrongRate,
    beam,
    four_bar,
    link,
    pendulum,
    slider_crank,
    worn,
)

import flexmb as fm
from flexmb.errors import InputError, ModelError

SHORT = {"t_end": 0.02, "save": 50}


def test_friction_that_drives_is_no_success():
    sol = fm.simulate(worn("A", friction=Driving(0.3)), **SHORT)
    assert not sol.ok
    assert "Not ok: The friction law of 'A' gives T" in sol.status
    assert "it drives. Friction brakes" in sol.status


def test_friction_of_a_belt_may_drive():
    """The bearing's surface moves at 2 m/s: slower slip is driven, faster slip is braked."""
    sol = fm.simulate(worn("A", friction=Belt(0.1, 2.0)), **SHORT)
    assert sol.ok, sol.status


class Belt(fm.FrictionLaw):
    """Smooth friction against a surface that moves at a speed of its own."""

    def __init__(self, coefficient, speed):
        object.__setattr__(self, "coefficient", coefficient)
        object.__setattr__(self, "speed", speed)

    def parameters(self):
        return (self.coefficient, self.speed)

    @fm.friction_law
    def kernel(p, h, slip, N, z, z_new):
        return -p[0] * N * math.tanh((slip - p[1]) / 1e-2)


def test_a_rate_that_is_no_derivative_is_no_success():
    sol = fm.simulate(slider_crank(motion=WrongRate(10.0)), **SHORT)
    assert not sol.ok
    assert "The rate of 'motor' is not the derivative of its value" in sol.status


def test_a_journal_that_passes_through_its_bearing():
    """Stiffness in N/mm^1.5."""
    fast = worn("A", normal=SOFT).with_({"motor.motion.speed": 200.0})
    sol = fm.simulate(fast, t_end=0.1)
    assert not sol.ok
    assert "RevoluteClearance 'A' is penetrated by" in sol.status
    assert "passes through its bearing. A stiffness in N/mm^1.5 is to be multiplied by 3.16e4" in sol.status
    right = fm.simulate(worn("A").with_({"motor.motion.speed": 200.0}), t_end=0.1)
    assert right.ok, right.status


@pytest.mark.parametrize("law", [Pulling(1e6), Sticky(1e6, 1e4)])
def test_a_law_that_pulls_is_no_success(law):
    sol = fm.simulate(worn("A", normal=law), **SHORT)
    assert not sol.ok
    assert "The normal law of 'A' gives N = " in sol.status


def test_a_table_that_overshoots_is_noted():
    sol = fm.simulate(slider_crank(motion=WAVE), t_end=0.05)
    assert any("The table of 'motor' overshoots its points by" in note for note in sol.notes)


def test_strain_beyond_yield_is_noted_and_impossible_strain_is_no_success():
    """A clamped strip falls: 2 q L^2/2 c/I = 7e8 Pa is twice what it bears; a block is bent to a loop."""
    strip = fm.Rectangle(width=0.01, height=1e-3)
    arm = beam("arm", O, (0.5, 0.0), strip, YIELDING, elements=6)
    wall = fm.Fixed("wall", fm.GROUND, arm, at=O)
    sol = fm.simulate(fm.Mechanism("strip", [arm, wall], gravity=(0.0, -60.0)), t_end=0.3, save=300)
    (note,) = (note for note in sol.notes if "FlexibleLink 'arm': largest normal stress" in note)
    assert "it yields at 2.5e+08 Pa" in note
    assert sol.ok
    block = beam("arm", O, (0.5, 0.0), fm.Rectangle(width=0.01, height=0.05), YIELDING, elements=4)
    load = fm.Torque("load", block, 1e7 * 0.01 * 0.05**2 * 400.0)
    held = fm.Fixed("wall", fm.GROUND, block, at=O)
    bent = fm.simulate(fm.Mechanism("bent", [block, held, load]), t_end=5e-3)
    assert not bent.ok
    assert "FlexibleLink 'arm' strains by" in bent.status


def test_strain_of_one_body_among_many():
    """Seventy posts, the last of which bends far."""
    posts = [beam(f"post{k}", (k, 0.0), (k, 0.5), STEEL_BAR, YIELDING, elements=1, stress=False) for k in range(70)]
    feet = [fm.Fixed(f"foot{k}", fm.GROUND, post, at=post.start) for k, post in enumerate(posts)]
    push = fm.Force("push", posts[-1], at=posts[-1].end, force=(600.0, 0.0))
    sol = fm.simulate(fm.Mechanism("posts", [*posts, *feet, push]), t_end=0.02, save=50)
    (note,) = (note for note in sol.notes if "strains by" in note)
    assert "FlexibleLink 'post69' strains by" in note
    assert "it yields at 2.5e+08 Pa" in note


@pytest.mark.parametrize("change", [{"rod.mass": 0.5}, {"A.clearance": 2e-4}, {"gravity": (0.0, -9.81)}])
def test_a_restart_of_another_mechanism_is_refused(change):
    first = fm.simulate(worn("A"), t_end=4e-3, max_steps=20)
    with pytest.raises(InputError, match="restart is of another mechanism: the same parts have other numbers"):
        fm.simulate(worn("A").with_(change), t_end=4e-3, restart=first.restart)
    whole, again = fm.simulate(worn("A"), t_end=4e-3), fm.simulate(worn("A"), t_end=4e-3, restart=first.restart)
    assert (again.values[-1] == whole.values[-1]).all()


def test_a_restart_of_other_names_is_refused():
    first = fm.simulate(pendulum(), t_end=0.01)
    arm = link("leg", O, (0.3, -0.2))
    renamed = fm.Mechanism("pendulum", [arm, fm.Revolute("O", fm.GROUND, arm, at=O)], gravity=(0.0, -9.81))
    with pytest.raises(InputError, match="names or kernels of its parts differ"):
        fm.simulate(renamed, t_end=0.02, restart=first.restart)


@pytest.mark.parametrize("step", [5e-4, 2e-3])
def test_an_impact_of_one_step_is_no_success(step):
    """An elastic pin at 10 m/s against the ends of its slot: the steps decide how fast it returns."""
    block = fm.RigidBody("block", O, 1.0, 1.0, velocity=(10.0, 0.0, 0.0))
    slot = fm.PinSlotClearance(
        "slot", fm.GROUND, block, at=O, along=(1.0, 0.0), clearance=1e-3, pin_radius=0.02, length=1.898,
        normal=fm.contact.Hertz(1e9),
    )  # fmt: skip
    mech = fm.Mechanism("pin", [block, slot])
    coarse = fm.simulate(mech, t_end=1.0, step=step)
    assert not coarse.ok, coarse.status
    fine = fm.simulate(mech, t_end=1.0)
    assert fine.ok, fine.status


def test_a_sound_run_has_neither_faults_nor_new_notes():
    for mech in (worn("A"), slider_crank(), pendulum(body=beam("arm", O, (0.3, -0.2), STEEL_BAR))):
        sol = fm.simulate(mech, t_end=0.05)
        assert sol.ok, sol.status
        assert "Not ok" not in sol.status


def test_a_linkage_that_locks_says_so():
    """Not a smaller step, but another range of the drive is the remedy; the joints that align are named."""
    sol = fm.simulate(four_bar((0.3, 0.1, 0.3, 0.32), 1.2, fm.ConstantSpeed(1.0)), t_end=1.0)
    assert not sol.ok
    assert "The loops close only up to t = 0.2012" in sol.status
    assert "the joints 'A', 'B', 'D' lie on one line" in sol.status


def test_a_drive_that_ends_in_nan_is_named():
    sol = fm.simulate(slider_crank(motion=NotFinite(1.0)), t_end=1.0)
    assert not sol.ok
    assert "The motion of 'motor' is not finite at t = 0.5" in sol.status


def test_drives_that_contradict_one_another_are_named():
    two = slider_crank(fm.Drive("push", "guide", fm.drives.Harmonic(0.01, 3.0)))
    with pytest.raises(ModelError, match=r"'motor', 'push'.*Remove a drive \('motor', 'push'\)"):
        fm.simulate(two, t_end=0.1)


@pytest.mark.parametrize(
    ("place", "value"),
    [
        (0, math.nan),
        (0, -1.0),
        (1, -1e-5),
        (2, 0.02),
        (2, -3.0),
        (3, -1.0),
        (4, -1e-6),
        (5, -2.0),
        (6, -1.0),
        (8, -1.0),
    ],
)
def test_a_restart_with_a_broken_clock_is_refused(place, value):
    """Time, step, begin of saving, saved instants, last step, held steps, step within an impact, rejected trials."""
    first = fm.simulate(pendulum(), t_end=0.01).restart
    clock = first["clock"].copy()
    clock[place] = value
    with pytest.raises(InputError, match="restart is damaged: its clock holds"):
        fm.simulate(pendulum(), t_end=0.02, restart={**first, "clock": clock})


def test_run_ends_when_a_journal_has_passed_through_its_bearing():
    mech = worn("A", normal=SOFT).with_({"motor.motion.speed": 200.0})
    whole = 0.2
    sol = fm.simulate(mech, t_end=whole, save=50)
    assert not sol.ok
    assert "Stopped: RevoluteClearance 'A': the journal passes through its bearing" in sol.status
    radius = mech.find("A").bearing_radius
    assert radius < sol.peak("A.penetration").value < 1.5 * radius
    assert sol.time[-1] < 0.5 * whole


def twice(factor):
    """The same name, file and parameters; another formula."""
    if factor == 2.0:

        @fm.element_kernel
        def pull(p, t, h, q, v, a, z, r, K, C, M, z_new):
            r[0] = 2.0 * p[0]
    else:

        @fm.element_kernel
        def pull(p, t, h, q, v, a, z, r, K, C, M, z_new):
            r[0] = 3.0 * p[0]

    return type("Pull", (fm.Element,), {"kernel": pull, "coords": ("body.x",), "__annotations__": {"body": fm.Part}})


def test_a_restart_of_another_formula_is_refused():
    @dataclass(frozen=True)
    class Two(twice(2.0)):
        body: fm.Part
        force: float

    @dataclass(frozen=True)
    class Three(twice(3.0)):
        body: fm.Part
        force: float

    ball = fm.RigidBody("ball", O, 1.0, 1.0)
    first = fm.simulate(fm.Mechanism("pulled", [ball, Two("pull", ball, 0.1)]), t_end=0.1)
    with pytest.raises(InputError, match="names or kernels of its parts differ"):
        fm.simulate(fm.Mechanism("pulled", [ball, Three("pull", ball, 0.1)]), t_end=0.2, restart=first.restart)


def test_a_run_holds_its_findings_as_records_and_so_does_its_file(tmp_path):
    sol = fm.simulate(worn("A", friction=Driving(0.3)), **SHORT)
    (fault,) = (finding for finding in sol.findings if finding.is_error)
    assert (fault.code, fault.parts) == ("driving-friction", ("A",))
    assert f"Not ok: {fault.sentence}" in sol.status
    assert sol.notes == tuple(finding.sentence for finding in sol.findings if not finding.is_error)
    assert fm.load(sol.to_netcdf(tmp_path / "run.nc")).findings == sol.findings


class Fragile(fm.RigidBody):
    """A body of a user that has its own opinion on its mass."""

    def findings_before(self, mechanism):
        yield fm.doctor.Finding("odd-units", (self.name,), "It is heavy.", "Take another.", "warning")


def test_a_part_of_a_user_answers_in_the_examination():
    stone = Fragile("stone", at=(0.0, 0.0), mass=1.0, inertia=1.0)
    assert "It is heavy. Take another." in [f.sentence for f in fm.check(fm.Mechanism("thrown", [stone])).findings]
