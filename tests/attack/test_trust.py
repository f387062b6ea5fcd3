"""A run is right, or it says that it is not; a restart goes on bit for bit; peaks are those of the steps."""

import math

import numpy as np
import pytest

import flexmb as fm

STEEL = fm.Material(young=207e9, density=7850.0, poisson=0.3)


def thrown_journal(restitution: float, stiffness: float = 1e9) -> fm.Mechanism:
    """A body of 1 kg at 0.5 m/s that bounces to and fro in its bearing: 0.125 J."""
    pin = fm.RigidBody("pin", at=(0.0, 0.0), mass=1.0, inertia=1e-3, velocity=(0.5, 0.0, 0.0))
    law = fm.LankaraniNikravesh(stiffness=stiffness, restitution=restitution)
    joint = fm.RevoluteClearance("J", fm.GROUND, pin, at=(0.0, 0.0), clearance=1e-3, bearing_radius=0.01, normal=law)
    return fm.Mechanism("thrown", [pin, joint])


def worn_slider_crank() -> fm.Mechanism:
    """Two joints with play and friction at a rod that bends."""
    o, a, b = (0.0, 0.0), (0.05, 0.0), (0.17, 0.0)
    crank = fm.RigidLink("crank", o, a, mass=0.3, inertia=1e-4)
    section = fm.Rectangle(width=0.01, height=0.01)
    rod = fm.FlexibleLink("rod", a, b, section=section, material=STEEL, elements=2)
    piston = fm.RigidBody("piston", at=b, mass=0.14, inertia=1e-4)
    worn = {
        "clearance": 1e-4,
        "bearing_radius": 0.01,
        "normal": fm.LankaraniNikravesh.from_materials(STEEL, STEEL),
        "friction": fm.ModifiedCoulomb(0.05),
    }
    joints = [
        fm.Revolute("O", fm.GROUND, crank, at=o),
        fm.RevoluteClearance("A", crank, rod, at=a, **worn),
        fm.RevoluteClearance("B", rod, piston, at=b, **worn),
        fm.Prismatic("guide", fm.GROUND, piston),
    ]
    motor = fm.Drive("motor", joint="O", motion=fm.ConstantSpeed(100.0))
    return fm.Mechanism("worn", [crank, rod, piston, *joints, motor], gravity=(0.0, -9.81))


def test_impacts_without_loss_keep_the_energy():
    sol = fm.simulate(thrown_journal(1.0), t_end=0.05, step=1e-6)
    assert sol.ok
    assert sol.peak("J.normal_force").value > 1e3, "it must have hit the bearing"
    assert sol.array("energy.kinetic")[-1] == pytest.approx(0.125, rel=1e-6)
    assert "balance" not in sol.status


def test_a_run_too_coarse_for_its_impacts_says_so():
    sol = fm.simulate(thrown_journal(1.0, stiffness=1e12), t_end=0.1, step=3e-4)
    lost = abs(sol.array("energy.kinetic")[-1] - 0.125)
    assert lost > 0.05 * 0.125, "the run is good after all: make it coarser"
    assert not sol.ok or "But the steps took" in sol.status


def test_controlled_steps_resolve_impacts_however_coarse_the_rest_is():
    sol = fm.simulate(thrown_journal(1.0, stiffness=1e12), t_end=0.1, step=fm.Adaptive(atol=1e-4, max=3e-4))
    assert sol.ok, sol.status
    assert sol.peak("J.normal_force").value > 1e3, "it must have hit the bearing"
    assert sol.array("energy.kinetic")[-1] == pytest.approx(0.125, rel=2e-4 * len(sol.episodes("J")))
    assert "balance" not in sol.status


def test_a_step_larger_than_the_period_says_so():
    sol = fm.simulate(fm.mechanisms.slider_crank(), periods=1, step=1.0)
    assert sol.stats.steps == 1
    assert not sol.ok
    assert "energies do not add up" in sol.status
    assert "smaller step" in sol.status


def test_the_balance_of_a_body_at_rest_is_no_alarm():
    body = fm.RigidBody("body", at=(1.0, 5.0), mass=2.0, inertia=3.0)
    weld = fm.Fixed("weld", fm.GROUND, body, at=(0.0, 0.0))
    sol = fm.simulate(fm.Mechanism("rest", [body, weld], gravity=(0.0, -9.81)), t_end=1.0)
    assert sol.status == "Finished at t = 1 s."


def test_restart_through_a_file_goes_on_bit_for_bit(tmp_path):
    mech, end = worn_slider_crank(), 2e-3
    whole = fm.simulate(mech, t_end=end)
    assert whole.ok
    half = fm.simulate(mech, t_end=end, max_steps=whole.stats.steps // 2)
    state = fm.load(half.to_netcdf(tmp_path / "half.nc")).restart
    rest = fm.simulate(mech, t_end=end, restart=state)
    np.testing.assert_array_equal(np.concatenate([half.time, rest.time]), whole.time)
    np.testing.assert_array_equal(np.concatenate([half.values, rest.values]), whole.values)
    np.testing.assert_array_equal(np.maximum(half.peaks.values, rest.peaks.values), whole.peaks.values)


def test_peaks_are_those_of_all_steps():
    mech = worn_slider_crank()
    steps = fm.simulate(mech, t_end=2e-3, save="steps")
    few = fm.simulate(mech, t_end=2e-3, save=3)
    assert len(steps.time) == steps.stats.steps + 1
    for name in ("B.normal_force", "motor.torque", "piston.ax", "rod.deflection", "energy.kinetic"):
        values = np.abs(steps.array(name))
        assert few.peak(name) == (values.max(), steps.time[values.argmax()]), name
    depth = steps.array("B.penetration")
    assert few.peak("B.penetration").value == depth.max() > 0.0


def test_a_restart_beyond_the_end_is_refused():
    mech = fm.mechanisms.slider_crank()
    late = fm.simulate(mech, t_end=0.01)
    with pytest.raises(
        fm.errors.InputError, match=r"restart stands at t = 0.01 s, beyond the end at 0.005 s.*larger t_end"
    ):
        fm.simulate(mech, t_end=0.005, restart=late.restart)


def test_changes_under_a_key_that_is_no_name_are_refused():
    with pytest.raises(fm.errors.InputError, match=r"key 3; it must be a name"):
        fm.mechanisms.slider_crank().with_({3: 2.0})


@pytest.mark.parametrize("elements", [1, 200, 400])
def test_a_fine_mesh_is_no_singular_matrix(elements):
    """Sag of a cantilever under its own weight, w L^4 / (8 E I), and its clamping moment w L^2 / 2."""
    length, side = 0.5, 0.01
    section = fm.Rectangle(width=side, height=side)
    beam = fm.FlexibleLink("beam", (0.0, 0.0), (length, 0.0), section=section, material=STEEL, elements=elements)
    clamp = fm.Fixed("clamp", fm.GROUND, beam, at=(0.0, 0.0))
    found = fm.static_equilibrium(fm.Mechanism("cantilever", [beam, clamp], gravity=(0.0, -9.81)))
    weight = STEEL.density * side**2 * 9.81  # N/m
    sag = weight * length**4 / (8.0 * STEEL.young * side**4 / 12.0)
    assert found["beam.end.y"] == pytest.approx(-sag, rel=1e-5)  # the arm shortens by (sag/L)^2, 3e-7
    assert found.force("clamp")[1:] == pytest.approx((weight * length, weight * length**2 / 2.0), rel=1e-5)


def test_similar_mechanisms_move_alike_from_a_micron_to_a_thousand_kilometres():
    """Lengths times f, times times sqrt(f): the angles of a double pendulum are the same."""
    ends = [double_pendulum(f) for f in (2.0**-20, 1.0, 2.0**20)]
    assert ends == pytest.approx([ends[1]] * 3, abs=1e-9)


def test_gravity_has_no_preferred_direction():
    turned = [double_pendulum(1.0, angle) - angle for angle in (0.0, 0.7, -2.0, 3.1)]
    assert turned == pytest.approx([turned[0]] * 4, abs=1e-9)


def double_pendulum(length: float, turn: float = 0.0) -> float:
    """Last angle of the lower link, let go across gravity; everything turned by `turn`."""
    c, s = math.cos(turn), math.sin(turn)
    a, b = (length * c, length * s), (2.0 * length * c, 2.0 * length * s)
    first = fm.RigidLink("first", (0.0, 0.0), a, mass=1.0, inertia=length**2 / 12.0)
    second = fm.RigidLink("second", a, b, mass=1.0, inertia=length**2 / 12.0)
    pins = [fm.Revolute("O", fm.GROUND, first, at=(0.0, 0.0)), fm.Revolute("A", first, second, at=a)]
    sol = fm.simulate(fm.Mechanism("double", [first, second, *pins], gravity=(9.81 * s, -9.81 * c)), t_end=length**0.5)
    assert sol.ok
    return float(sol.array("second.theta")[-1])
