"""Controlled steps in worn mechanisms: the slider-crank of the literature by default, saving, restart, beams."""

import math

import numpy as np
import pytest

import flexmb as fm
from flexmb.mechanisms import nine_bar

OMEGA = 5000.0 * math.pi / 30.0
STEEL = fm.Material(young=207e9, density=7850.0, poisson=0.3)

CONVERGED = {"force": 45826.0, "torque": 985.5, "first": 2.2729e-4, "contacts": 24}
"""Two turns of the slider-crank below (play of 0.5 mm at the slider, friction 0.03) by an independent program: two
minimal coordinates, Runge-Kutta steps of 1e-8 s.  Largest contact force [N], largest torque [N m], first contact [s],
and how many contacts there are."""


def worn():
    """Data: crank 0.05 m, rod 0.12 m (0.21 kg, 2.5e-4 kg m^2), slider 0.14 kg, 5000 rpm, stretched at the start."""
    crank = fm.RigidLink("crank", (0.0, 0.0), (0.05, 0.0), 0.30, 1e-5)
    rod = fm.RigidLink("rod", (0.05, 0.0), (0.17, 0.0), 0.21, 2.5e-4)
    slider = fm.RigidBody("slider", (0.17, 0.0), 0.14, 1e-4)
    law = fm.LankaraniNikravesh.from_materials(STEEL, STEEL, restitution=0.9)
    play = {"clearance": 5e-4, "bearing_radius": 0.01, "normal": law, "friction": fm.ModifiedCoulomb(0.03, v1=1e-3)}
    joints = (
        fm.Revolute("A", fm.GROUND, crank, (0.0, 0.0)),
        fm.Revolute("B", crank, rod, (0.05, 0.0)),
        fm.RevoluteClearance("C", rod, slider, (0.17, 0.0), **play),
        fm.Prismatic("guide", fm.GROUND, slider),
        fm.Drive("motor", "A", fm.ConstantSpeed(OMEGA)),
    )
    return fm.Mechanism("worn", (crank, rod, slider, *joints))


@pytest.fixture(scope="module")
def two_turns():
    return fm.simulate(worn(), periods=2, save="steps")


def test_the_worn_slider_crank_by_default(two_turns):
    """Peak within 0.2 %, no spikes of the torque, first contact, and every impact resolved."""
    sol = two_turns
    assert sol.ok, sol.status
    assert sol.peak("C.normal_force").value == pytest.approx(CONVERGED["force"], rel=2e-3)
    assert sol.peak("motor.torque").value == pytest.approx(CONVERGED["torque"], rel=1e-2)
    found = sol.episodes("C")
    assert found.start[0] == pytest.approx(CONVERGED["first"], abs=5e-9)
    for impact in found:
        if impact.mode == "impact":
            assert np.count_nonzero((sol.time >= impact.start) & (sol.time <= impact.end)) >= 32


def test_a_smaller_rtol_finds_the_largest_force_of_two_turns():
    """The motion is chaotic: what is wrong in the first impacts grows a hundredfold over the twenty of a turn.

    So the count of the slow bounces at their end is off by a few even with a tenth of the default: 20 to 25 for largest
    steps of 1/250 to 1/2000 of a turn, while the largest force is the converged one.
    """
    sol = fm.simulate(worn(), periods=2, save=1, step=fm.Adaptive(rtol=1e-5))
    assert abs(len(sol.episodes("C")) - CONVERGED["contacts"]) <= 4
    assert sol.peak("C.normal_force").value == pytest.approx(CONVERGED["force"], rel=5e-4)


def test_what_is_saved_does_not_change_the_steps():
    runs = [fm.simulate(worn(), t_end=2e-3, save=save) for save in (10, 1000, "steps")]
    first = runs[0]
    for other in runs[1:]:
        assert other.stats.steps == first.stats.steps
        assert other.stats.rejected == first.stats.rejected
        for name, array in first.restart.items():
            same = other.restart[name].copy()
            if name == "clock":
                same[2:4] = array[2:4]  # the grid of saved instants
            assert array.tobytes() == same.tobytes(), name


def test_the_steps_go_on_bit_for_bit_anywhere():
    """Cut while flying, landing, in an impact and after it: what the step control remembers is part of the state."""
    whole = fm.simulate(worn(), t_end=8e-4, save="steps")
    for cut in range(whole.stats.steps // 8, whole.stats.steps, whole.stats.steps // 8):
        part = fm.simulate(worn(), t_end=8e-4, max_steps=cut)
        rest = fm.simulate(worn(), t_end=8e-4, restart=part.restart, save=3)
        assert part.stats.steps + rest.stats.steps == whole.stats.steps
        for name in ("q", "v", "a", "x", "z", "ledger", "impacts", "past"):
            assert rest.restart[name].tobytes() == whole.restart[name].tobytes(), (cut, name)


def test_the_flight_goes_on_with_its_step_right_after_an_impact(two_turns):
    """Between the first two impacts the steps are those of before, not doubled from those of the impact."""
    sol = two_turns
    first, second = list(sol.episodes("C"))[:2]
    before = np.diff(sol.time[sol.time < first.start])
    flight = np.diff(sol.time[(sol.time > first.end) & (sol.time < second.start)])
    assert np.sort(flight)[len(flight) // 2] > 0.5 * before.max()
    assert np.count_nonzero(flight < 0.5 * before.max()) <= 6


@pytest.mark.slow
def test_a_refused_trial_leaves_no_trace_in_the_tolerance():
    """The largest speed of the run scales the tolerance of velocities; a wild trial, refused, once raised it 263 times.

    With these coarse steps such a trial comes in the third turn.
    """
    flow = fm.chaos.MechanismFlow(nine_bar(2.5 * np.pi, clearance=0.5e-3), step=fm.Adaptive(rtol=1e-2))
    n, size, most, end = flow.program.n_q, flow.program.length, 0.0, 3.2 * flow.period
    refused = flow.run.record.count.rejected
    while flow.time < end * (1.0 - 1e-12):
        v = flow.run.flow.v[:n].reshape(-1, 3)
        most = max(most, np.hypot(v[:, 0], v[:, 1]).max(), size * np.abs(v[:, 2]).max())
        assert flow.take_step(end), flow.status
    assert flow.run.record.count.rejected > refused + 10, "this says something only if trials were refused"
    assert flow.run.flow.largest_speeds.max() <= most * (1.0 + 1e-12)


def test_each_rejected_step_has_its_reason(two_turns):
    """Impacts are approached by trials that reach beyond an onset; a mechanism without contacts has none of these."""
    stats = two_turns.stats
    by_error = stats.rejected - stats.rejected_at_contacts - stats.not_converged
    assert stats.rejected_at_contacts >= CONVERGED["contacts"]
    assert by_error >= 0
    assert f"{stats.rejected_at_contacts} at contacts" in str(stats)
    crank = fm.RigidLink("crank", (0.0, 0.0), (0.05, 0.0), 0.30, 1e-5)
    joint = fm.Revolute("A", fm.GROUND, crank, (0.0, 0.0))
    kick = fm.Torque("kick", crank, 1.0, history=fm.drives.Pulse(0.0101, 0.0102))
    smooth = fm.simulate(fm.Mechanism("m", (crank, joint, kick)), t_end=0.05).stats
    assert smooth.rejected_at_contacts == 0
