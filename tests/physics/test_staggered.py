"""The staggered scheme: a rigid and an elastic model in turn, against exact values and the coupled equations.

Every number here is a formula of beam theory, a law of conservation, or what the coupled solver gives.
"""

import math

import numpy as np
import pytest
from nine_bar_study.nine_bar.staggered.method import Staggered

import flexmb as fm
from flexmb.errors import AssemblyError, InputError, ModelError
from flexmb.mechanisms import SliderCrankData, slider_crank

pytestmark = pytest.mark.slow  # its loop takes half a minute to compile

LENGTH, SIDE, YOUNG, DENSITY = 1.0, 0.01, 70e9, 2700.0
SECTION = fm.Rectangle(width=SIDE, height=SIDE)
LINE = DENSITY * SIDE**2  # kg/m
EI = YOUNG * SIDE**4 / 12.0
AT_REST = 1.875104068711961**2 * math.sqrt(EI / LINE) / LENGTH**2  # first bending frequency of a cantilever [rad/s]


def beam(damping=0.0, elements=4, young=YOUNG, **changes):
    material = fm.Material(young, DENSITY)
    return fm.FlexibleLink(
        "beam",
        (0.0, 0.0),
        (LENGTH, 0.0),
        section=SECTION,
        material=material,
        elements=elements,
        damping=damping,
        **changes,
    )


def driven(motion, *loads, gravity=(0.0, 0.0), **changes):
    """A beam clamped to a shaft at the origin."""
    arm = beam(**changes)
    parts = (arm, fm.Revolute("O", fm.GROUND, arm, (0.0, 0.0)), fm.Drive("motor", "O", motion), *loads)
    return fm.Mechanism("arm", parts, gravity=gravity)


def pendulum(**changes):
    rod = beam(**changes)
    return fm.Mechanism("pendulum", (rod, fm.Revolute("O", fm.GROUND, rod, (0.0, 0.0))), gravity=(0.0, -9.81))


def run(mech, **options):
    """A run that must reach its end."""
    options = {"method": Staggered(), "save": "steps", **options}
    sol = fm.simulate(mech, **options)
    assert sol.ok, sol.status
    return sol


def tip_across(sol):
    """Displacement of the tip across the direction of the clamped end [m]."""
    dx, dy = (sol.array(f"beam.end.{k}") - sol.array(f"beam.start.{k}") for k in "xy")
    angle = sol.array("beam.start.theta")
    return dy * np.cos(angle) - dx * np.sin(angle)


@pytest.mark.parametrize("clearance", [None, 5e-4])
def test_a_rigid_mechanism_moves_as_with_runge_kutta(clearance):
    """Without a flexible body nothing is handed back, so every signal is that of `RungeKutta4`, to the last bit."""
    mech = slider_crank(200.0, clearance=clearance, friction="coulomb")
    options = {"t_end": 0.03, "step": 1e-5}
    both = [run(mech, method=method, **options) for method in (Staggered(), fm.RungeKutta4())]
    np.testing.assert_array_equal(both[0].values, both[1].values)
    assert both[0].names == both[1].names
    assert len(both[0].episodes()) == len(both[1].episodes())


@pytest.mark.slow
def test_a_beam_that_turns_slowly_hangs_as_in_statics():
    """Tip of a cantilever under its weight, q L^4 / (8 EI) across its axis, while a drive turns it by 60 degrees.

    The turn takes 200 periods of its first mode.  The shock of the start has died out before the last tenth; the
    printed damping lags by 2 xi w/f = 3e-4 rad there.
    """
    time = 200.0 * 2.0 * math.pi / AT_REST
    damping = 0.2 / AT_REST  # a tenth of critical in the first mode
    mech = driven(fm.drives.CycloidalRamp(2.0 * math.pi / 3.0 / time, time), gravity=(0.0, -9.81), damping=damping)
    sol = fm.simulate(mech, t_end=time, step=2e-4, method=Staggered(), save=400)
    assert sol.ok, sol.status
    late = sol.time > 0.9 * time
    wanted = -LINE * 9.81 * np.cos(sol.array("beam.start.theta")) * LENGTH**4 / (8.0 * EI)
    np.testing.assert_allclose(tip_across(sol)[late], wanted[late], rtol=2e-3)


def slow_crank(speed):
    """A soft rod on a crank that starts softly, within half a turn."""
    data = SliderCrankData(young=2e9, damping=1e-4)
    return slider_crank(speed, flexible=True, ramp=math.pi / speed, elements=2, data=data)


def differences(sols, others):
    """Largest differences of deflection and torque, over the range of each, pair by pair."""
    pairs = zip(sols, others, strict=True)
    names = ("rod.deflection", "motor.torque")
    return np.array([[np.abs(a.array(n) - b.array(n)).max() / np.ptp(b.array(n)) for n in names] for a, b in pairs])


def test_deflections_are_of_second_order_and_torques_of_first():
    """Between steps h and h/2: the load, and with it the torque, is one step late."""
    mech, options = slow_crank(20.0), {"t_end": 0.1, "save": 50}
    sols = [run(mech, step=4e-4 / 2**k, **options) for k in range(4)]
    found = differences(sols[:-1], sols[1:])
    rates = np.log2(found[:-1] / found[1:])
    assert rates[:, 0] == pytest.approx([2.0, 2.0], abs=0.25), rates
    assert (rates[:, 1] > 0.9).all(), rates


def test_the_coupled_solution_is_approached_as_the_crank_turns_slower():
    """What the equations leave out is of the second order in speed over frequency; 3e-4 at 20 rad/s."""
    found = []
    for speed in (20.0, 10.0):
        mech, options = slow_crank(speed), {"t_end": 2.0 / speed, "save": 50}
        exact = run(mech, method=fm.Newmark.trapezoidal(), step=2e-5, **options)
        found.append(differences([run(mech, step=5e-5, **options)], [exact])[0])
    assert np.max(found[0]) < 5e-4, found
    assert (found[1] < found[0] / 2.5).all(), found


def frequency(mech, t_end, step, method):
    """Angular frequency of the tip across the axis, from its zero crossings in the last half [rad/s]."""
    sol = run(mech, t_end=t_end, step=step, method=method)
    late = sol.time > 0.5 * t_end
    t, w = sol.time[late], tip_across(sol)[late]
    k = np.flatnonzero(w[1:] * w[:-1] < 0.0)
    zeros = t[k] - w[k] * (t[k + 1] - t[k]) / (w[k + 1] - w[k])
    return math.pi * (len(zeros) - 1) / (zeros[-1] - zeros[0])


def test_the_frequency_of_a_rotating_cantilever_shows_what_is_left_out():
    """In the plane: f as printed, sqrt(f^2 - w^2) in fixed axes; truly sqrt(f^2 + (1.193 - 1) w^2).

    1.193 is the factor of centrifugal stiffening of the first mode (R. V. Southwell, B. S. Gough, ARC R&M 766, 1921).
    At half of its frequency as speed the printed equations are 2.4 % too low, those in fixed axes 15 %.
    """
    speed = 0.5 * AT_REST
    blow = fm.drives.Pulse(1.0, 0.0, 0.2 / AT_REST)
    arm = beam(damping=1e-5)
    push = fm.Force("push", arm, (LENGTH, 0.0), (0.0, 0.05), history=blow)
    mech = driven(fm.ConstantSpeed(speed), push, damping=1e-5)
    t_end, step = 40.0 * 2.0 * math.pi / AT_REST, 5e-4
    found = {name: frequency(mech, t_end, step, Staggered(rotation=name)) for name in ("printed", "inertial")}
    found["coupled"] = frequency(mech, t_end, step, fm.Newmark.trapezoidal())
    assert found["printed"] / AT_REST == pytest.approx(1.0, rel=3e-3)
    assert found["inertial"] / AT_REST == pytest.approx(math.sqrt(0.75), rel=3e-3)
    assert found["coupled"] / AT_REST == pytest.approx(math.sqrt(1.0 + 0.193 * 0.25), rel=3e-3)


def test_a_free_beam_keeps_the_momentum_that_a_blow_gave_it():
    """Linear momentum is the impulse; angular momentum about the origin that of the impulse at the tip.

    The momentum is that of the bent beam, so it is kept to second order in the deflection: 5e-4 of the impulse.
    """
    rod = beam()
    push = fm.Force("push", rod, (LENGTH, 0.0), (0.0, 2.0), history=fm.drives.Pulse(1.0, 0.0, 0.004))
    mech = fm.Mechanism("free", (rod, push))
    sol = run(mech, t_end=0.05, step=1e-4)
    after = sol.time > 0.0041
    found = fm.momentum(mech, sol)
    np.testing.assert_allclose(found.linear[after], [[0.0, 0.008]] * int(after.sum()), atol=8e-6)
    spin = found.angular[after]
    assert np.ptp(spin) < 2e-3 * abs(spin.mean())
    assert spin.mean() == pytest.approx(0.008 * LENGTH, rel=2e-3)


def test_a_flexible_pendulum_swings_as_the_coupled_one():
    """Angle after half a swing, against the coupled solver; its error falls with the step."""
    mech, t_end = pendulum(damping=1e-4), 0.4
    exact = run(mech, method=fm.Newmark.trapezoidal(), t_end=t_end, step=2e-4, save=20)
    sol = run(mech, t_end=t_end, step=2e-4, save=20)
    assert np.ptp(exact.array("beam.end.y")) > 0.5
    np.testing.assert_allclose(sol.array("beam.end.y"), exact.array("beam.end.y"), atol=1e-4)


def test_stiff_bodies_move_as_rigid_ones():
    """The difference to the rigid mechanism falls as 1/E, as that of the coupled solver does."""
    rigid = run(slider_crank(20.0, ramp=0.15, data=SliderCrankData(rod_inertia=None)), t_end=0.1, step=1e-4, save=20)
    differences = []
    for factor in (1.0, 10.0, 100.0):
        data = SliderCrankData(young=factor * 207e9)
        mech = slider_crank(20.0, flexible=True, ramp=0.15, elements=2, data=data)
        sol = run(mech, t_end=0.1, step=1e-4, save=20)
        differences.append(np.abs(sol.array("rod.deflection")).max())
    assert np.abs(sol.array("slider.x") - rigid.array("slider.x")).max() < 1e-9
    np.testing.assert_allclose(np.array(differences[:-1]) / np.array(differences[1:]), 10.0, rtol=0.1)


def worn(**options):
    """A flexible rod with play at the piston pin; the rigid one has the inertia of the uniform bar."""
    data = SliderCrankData(rod_inertia=None)
    return slider_crank(200.0, clearance=5e-5, elements=2, data=data, **options)


def first_impact(sol):
    return sol.episodes("B")[0]


def test_contacts_see_the_rigid_motion_alone():
    """Without shared displacements the first impact is that of the rigid mechanism; the coupled one is much softer.

    What little differs comes from the load's component along free motions, zero in the pose before.
    """
    options = {"t_end": 1e-3, "step": 2e-6, "save": 10}
    rigid = first_impact(run(worn(), method=fm.RungeKutta4(), **options))
    soft = first_impact(run(worn(flexible=True), **options))
    coupled = first_impact(run(worn(flexible=True), method=fm.Newmark.generalised_alpha(), t_end=1e-3, save=10))
    assert soft.peak_force == pytest.approx(rigid.peak_force, rel=1e-3)
    assert soft.start == pytest.approx(rigid.start, rel=1e-5)
    assert coupled.peak_force < 0.6 * rigid.peak_force


def test_shared_displacements_blow_up_in_contact_and_are_no_success():
    """The load that is one step late gives energy to every contact; the run stops with a sentence."""
    method = Staggered(play="shared")
    sol = fm.simulate(worn(flexible=True), t_end=1e-3, step=5e-6, method=method, save=10)
    assert not sol.ok
    assert "displaced" in sol.status or "finite" in sol.status or "energ" in sol.status, sol.status


@pytest.mark.slow
def test_repeated_passes_with_shared_displacements_give_the_impact_of_the_coupled_equations():
    """Peak force and start of the first impact; what is left falls with the first order of the step."""
    options = {"t_end": 2.6e-4, "save": 5}
    exact = first_impact(run(worn(flexible=True), method=fm.Newmark.trapezoidal(), step=2e-7, **options))
    method = Staggered(play="shared", rotation="inertial", passes=200)
    found = [first_impact(run(worn(flexible=True), method=method, step=step, **options)) for step in (2e-6, 1e-6)]
    errors = np.array([[exact.peak_force - e.peak_force, exact.start - e.start] for e in found])
    assert np.abs(errors[1] / [exact.peak_force, exact.start]).max() < 0.015
    np.testing.assert_allclose(errors[0] / errors[1], 2.0, rtol=0.1)


def test_a_run_goes_on_bit_for_bit():
    """Steps and ends are powers of two, so that no end changes a step by round-off."""
    step = 2.0**-19
    whole = run(worn(flexible=True), t_end=512 * step, step=step, save=4)
    half = run(worn(flexible=True), t_end=256 * step, step=step, save=4)
    rest = run(worn(flexible=True), t_end=512 * step, step=step, save=4, restart=half.restart)
    np.testing.assert_array_equal(rest.values[-1], whole.values[-1])
    with pytest.raises(InputError, match="does not fit"):
        fm.simulate(worn(flexible=True), t_end=1e-3, step=step, method=fm.RungeKutta4(), restart=half.restart)


@pytest.mark.slow
def test_a_solution_can_be_saved_and_written_as_any_other(tmp_path):
    mech = worn(flexible=True)
    sol = run(mech, t_end=1e-4, step=5e-6, save=4)
    sol.to_netcdf(tmp_path / "run.nc")
    back = fm.load(tmp_path / "run.nc")
    np.testing.assert_array_equal(back.values, sol.values)
    for name, array in sol.restart.items():
        np.testing.assert_array_equal(back.restart[name], array)
    coupled = fm.simulate(mech, t_end=1e-4, step=5e-6, save=4)
    assert sol.names == coupled.names
    assert sol.aliases == coupled.aliases
    assert fm.write_vtk(sol, tmp_path / "run.pvd").exists()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"method": Staggered(), "step": fm.Adaptive()}, "Staggered has no error estimate"),
        ({"method": Staggered(), "step": 1e-4, "redundant": "least-norm"}, "independent joints"),
    ],
)
def test_what_it_cannot_do_is_refused(change, words):
    with pytest.raises(InputError, match=words):
        fm.simulate(slow_crank(20.0), t_end=0.01, **change)


def test_parts_it_cannot_do_are_named():
    arm = beam(displacement=[(0.0, 0.0, 0.0)] * 5)
    held = fm.Mechanism("held", (arm, fm.Revolute("O", fm.GROUND, arm, (0.0, 0.0))))
    with pytest.raises(InputError, match=r"FlexibleLink 'beam' has a field of displacement"):
        fm.simulate(held, t_end=0.1, step=1e-3, method=Staggered())
    arm = beam()
    rough = fm.Revolute("O", fm.GROUND, arm, (0.0, 0.0), friction=fm.friction.SmoothCoulomb(0.1, 1e-3), radius=0.01)
    with pytest.raises(InputError, match=r"Revolute 'O' has friction"):
        fm.simulate(fm.Mechanism("rough", (arm, rough)), t_end=0.1, step=1e-3, method=Staggered())


@pytest.mark.parametrize(
    "part",
    [
        lambda arm: fm.SpringDamper("k", fm.GROUND, arm, (LENGTH, -1.0), (LENGTH, 0.0), stiffness=1e3),
        lambda arm: fm.TorsionSpring("k", fm.GROUND, arm, stiffness=100.0),
        lambda arm: fm.Bushing("k", fm.GROUND, arm, (LENGTH, 0.0), stiffness=(1e3, 1e3)),
    ],
)
def test_springs_on_flexible_bodies_are_refused(part):
    """They would act on the rigid motion and keep the energy of the whole one."""
    arm = beam()
    mech = fm.Mechanism("sprung", (arm, fm.Revolute("O", fm.GROUND, arm, (0.0, 0.0)), part(arm)))
    with pytest.raises(InputError, match=r"'k' acts on the flexible body 'beam'"):
        fm.simulate(mech, t_end=0.01, step=1e-3, method=Staggered())


@pytest.mark.parametrize(("driven", "error"), [(True, ModelError), (False, AssemblyError)])
def test_joints_that_only_flexible_bodies_allow_are_refused(driven, error):
    """A third parallel crank: the beams give way, their rigid twins repeat one another."""
    material = fm.Material(YOUNG, DENSITY)
    points = [((x, 0.0), (x, 0.5)) for x in (0.0, 0.5, 1.0)] + [((0.0, 0.5), (1.0, 0.5))]
    *cranks, top = [
        fm.FlexibleLink(f"b{k}", *ends, section=SECTION, material=material, elements=2) for k, ends in enumerate(points)
    ]
    joints = [fm.Revolute(f"O{k}", fm.GROUND, c, (0.5 * k, 0.0)) for k, c in enumerate(cranks)]
    joints += [fm.Revolute(f"P{k}", c, top, (0.5 * k, 0.5)) for k, c in enumerate(cranks)]
    motor = [fm.Drive("motor", "O0", fm.ConstantSpeed(3.0))] if driven else []
    mech = fm.Mechanism("cranks", (*cranks, top, *joints, *motor))
    with pytest.raises(error, match="with rigid bodies in place of flexible ones, Mechanism 'cranks'") as found:
        fm.simulate(mech, t_end=0.01, step=1e-3, method=Staggered())
    assert "make a link flexible" not in str(found.value)


@pytest.mark.parametrize("bad", [{"rotation": "none"}, {"play": "loose"}, {"mean_axes": 1}, {"passes": 0}])
def test_options_out_of_range_are_refused(bad):
    with pytest.raises(InputError, match=next(iter(bad))):
        Staggered(**bad)
