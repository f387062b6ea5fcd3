"""Control laws of one's own that act at all times: closed forms, errors, refusals."""

import math
import re

import numpy as np
import pytest
from nine_bar_study.nine_bar.staggered.method import Staggered
from plants import ARM, ARM_INERTIA, WEIGHT, arm, different, last, rotor
from scipy.optimize import brentq

import flexmb as fm
from flexmb.engine.system.state_evaluation import StateEvaluation
from flexmb.errors import InputError, KernelError, ModelError, SolveError
from flexmb.program.compiler import compile as compile_mechanism
from flexmb.testing import check_part

TIGHT = {
    "newmark": {"step": fm.Adaptive(rtol=1e-8)},
    "radau": {"method": fm.RadauIIA(), "step": fm.Adaptive(rtol=1e-9)},
    "runge-kutta": {"method": fm.RungeKutta4(), "step": fm.FixedStep(2e-4)},
}


@fm.control_kernel
def dead_zone(p, t, u, x, dx, y):
    """A spring with play."""
    k, play = p
    beyond = max(abs(u[0]) - play, 0.0)
    y[0] = -k * beyond if u[0] > 0.0 else k * beyond


@fm.control_kernel
def copy(p, t, u, x, dx, y):
    y[0] = u[0]


@fm.control_kernel
def late_root(p, t, u, x, dx, y):
    y[0] = math.sqrt(p[0] - t)


@fm.control_kernel
def beyond(p, t, u, x, dx, y):
    if t > 0.1:
        y[1] = 1.0


@fm.control_kernel
def beyond_at_once(p, t, u, x, dx, y):
    y[1] = 1.0


@fm.control_kernel
def switch(p, t, u, x, dx, y):
    y[0] = 1.0 if u[0] < 0.5 else -1.0


@fm.control_kernel
def chain(p, t, u, x, dx, y):
    """Four first-order filters, one behind the other."""
    before = u[0]
    for i in range(4):
        dx[i] = p[0] * (before - x[i])
        before = x[i]
    y[0] = x[3]


def servo(law=copy, **changes):
    given = {"inputs": ["tip.theta"], "loads": ["actuator"], "law": law, **changes}
    return fm.Control("servo", **given)


@pytest.mark.parametrize("options", TIGHT.values(), ids=TIGHT)
def test_a_dead_zone_lengthens_the_period(options):
    """A rotor in a spring with play 2 d: half periods of the spring, and 2 d/omega between: exact after one period."""
    k, play, omega, inertia = 2.0, 0.05, 1.5, 0.02
    law = fm.Control("spring", ["rotor.theta"], ["shaft"], dead_zone, numbers=(k, play))
    period = 2.0 * math.pi * math.sqrt(inertia / k) + 4.0 * play / omega
    sol = fm.simulate(rotor(law, inertia=inertia, omega=omega), t_end=period, **options)
    assert last(sol, "rotor.theta", "rotor.omega") == pytest.approx([0.0, omega], abs=2e-6)
    largest = play + omega * math.sqrt(inertia / k)
    assert float(np.abs(sol["rotor.theta"]).max()) == pytest.approx(largest, rel=1e-5)


def test_four_states_are_filters_in_a_row():
    """Answer of four filters of one time constant to a step: 1 - exp(-s) (1 + s + s^2/2 + s^3/6)."""
    step = fm.drives.Pulse(1.0, start=0.0, end=9.0)
    law = fm.Control("filter", [step], [], chain, numbers=[50.0], states=4, outputs=["smooth"])
    sol = fm.simulate(rotor(law, omega=1.0), t_end=0.1, step=fm.Adaptive(rtol=1e-8))
    s = 50.0 * 0.1
    exact = 1.0 - math.exp(-s) * (1.0 + s + s * s / 2.0 + s**3 / 6.0)
    assert last(sol, "filter.smooth", "filter.state4") == pytest.approx([exact, exact], abs=1e-7)
    assert check_part(rotor(law), "filter").checks


def test_controllers_of_the_same_law_with_other_numbers_share_a_structure():
    """A sweep changes numbers of a controller; each run has its own."""
    model = arm(fm.PID("servo", "tip.theta", "actuator", target=1.0, kp=20.0, kd=3.0, rate="tip.omega"))
    for kp in (20.0, 40.0):
        sol = fm.simulate(model.with_({"servo.kp": kp, "gravity": (0.0, 0.0)}), t_end=4.0)
        assert float(sol["servo.output"][0]) == pytest.approx(kp, rel=1e-12)
        assert float(sol["tip.theta"][-1]) == pytest.approx(1.0, abs=1e-6)


def test_an_input_without_acceleration_reads_every_signal_of_the_state():
    """Markers, coordinates, velocities, aliases, states and outputs of others; all at the same instant."""
    probes = [fm.Control(f"p{k}", [name], [], copy, outputs=["out"]) for k, name in enumerate(
        ("tip.x", "tip.vy", "arm.x", "arm.vx", "arm.omega", "servo.integral", "servo.output", "p0.out")
    )]  # fmt: skip
    pid = fm.PID("servo", "tip.theta", "actuator", target=1.0, kp=20.0, ki=3.0, kd=3.0)
    sol = fm.simulate(arm(*probes, pid), t_end=0.3, save="steps")
    for probe in probes:
        read = np.asarray(sol[probe.inputs[0]])
        assert np.asarray(sol[f"{probe.name}.out"]) == pytest.approx(read, abs=1e-8 * np.abs(read).max())


@pytest.mark.parametrize(
    ("make", "error", "text"),
    [
        (lambda: servo(inputs=["tip.thetta"]), ModelError, "input 'tip.thetta' is no signal.*Did you mean 'tip.theta'"),
        (lambda: servo(inputs=["tip.ax"]), ModelError, "input 'tip.ax' depends on accelerations.*Give sample="),
        (lambda: servo(inputs=["arm.alpha"]), ModelError, "'arm.alpha' is no function of positions.*Give sample="),
        (lambda: servo(inputs=["hinge.fx"]), ModelError, "input 'hinge.fx' is no function of positions.*Give sample="),
        (lambda: servo(inputs=["energy.kinetic"]), ModelError, "'energy.kinetic' is no function of positions"),
        (lambda: servo(inputs=["servo.output1"]), ModelError, "'servo.output1' depend on one another.*algebraic loop"),
        (lambda: servo(inputs=["tip.nothing"], sample=0.1), ModelError, "input 'tip.nothing' is no signal"),
        (lambda: servo(loads=["actuatr"]), ModelError, "refers to 'actuatr'.*Did you mean 'actuator'"),
        (lambda: servo(loads=["arm"]), ModelError, "RigidLink 'arm' cannot be controlled; give a Force or a Torque"),
        (lambda: servo(loads=["hinge"]), ModelError, "Revolute 'hinge' cannot be controlled"),
        (lambda: servo(loads=["actuator", "actuator"]), InputError, "loads holds 'actuator' twice"),
        (lambda: servo(beyond_at_once), KernelError, "'beyond_at_once' failed.*1 outputs y: index 1 is out of"),
        (lambda: servo(law=math.sin), InputError, "law is .*control_kernel"),
        (lambda: servo(loads=[]), InputError, "has no output; give loads="),
        (lambda: servo(inputs="tip.theta"), InputError, "inputs is 'tip.theta'; it must be a list"),
        (lambda: servo(inputs=["angle"]), InputError, "inputs holds 'angle'"),
        (lambda: servo(states=-1), InputError, "states is -1"),
        (lambda: servo(states={"a.b": 0.0}), InputError, "states holds 'a.b'"),
        (lambda: servo(states={"output1": 0.0}), InputError, "'output1' names two"),
        (lambda: servo(states=[math.inf]), InputError, "start value of 'state1' is inf"),
        (lambda: servo(numbers=["k"]), InputError, r"numbers\[0\] is 'k'"),
        (lambda: servo(outputs=[]), InputError, "has no output"),
        (lambda: fm.PID("servo", "tip.theta", "actuator"), InputError, "has no gain"),
        (lambda: fm.PID("servo", "tip.theta", "actuator", kd=1.0), InputError, "filter_time is missing"),
        (lambda: fm.PID("servo", "tip.theta", "actuator", ki=1.0, limit=1.0), InputError, "tracking_time is missing"),
        (lambda: fm.PID("servo", "tip.theta", "actuator", kp=1.0, limit=(2.0, 1.0)), InputError, "in this order"),
        (lambda: fm.PID("servo", "tip.theta", "actuator", kp=1.0, limit=0.0), InputError, "limit is 0"),
        (lambda: fm.PID("servo", "angle", "actuator", kp=1.0), InputError, "measure is 'angle'"),
        (lambda: fm.PID("servo", "tip.theta", "actuator", kp=math.nan), InputError, "kp is nan"),
        (lambda: fm.PID("servo", "tip.theta", "actuator", kp=1.0, kd=1.0, rate="tip.omega", filter_time=1.0),
         InputError, "rate and filter_time are both given"),
        (lambda: fm.controllers.DCMotor("servo", "tip.omega", "actuator", voltage=1.0, resistance=0.0,
                                        torque_constant=1.0), InputError, "resistance is 0 ohm"),
        (lambda: fm.controllers.DCMotor("servo", "tip.omega", "actuator", voltage="v", resistance=1.0,
                                        torque_constant=1.0), InputError, "voltage is 'v'"),
        (lambda: fm.controllers.DCMotor("servo", "tip.omega", "actuator", voltage=1.0, resistance=1.0,
                                        torque_constant=1.0, current=1.0), InputError, "current is 1 A"),
    ],
)  # fmt: skip
def test_wrong_arguments_are_refused(make, error, text):
    with pytest.raises(error, match=text):
        fm.simulate(arm(make()), t_end=0.01)


def test_loads_with_a_history_or_two_controllers_are_refused():
    link = arm().find("arm")
    with pytest.raises(ModelError, match="Torque 'b' has a history, and would be multiplied twice"):
        arm(fm.Torque("b", link, 1.0, history=fm.drives.Pulse(1.0)), servo(loads=["b"]))
    with pytest.raises(ModelError, match="Control 'twin' and Control 'servo' both control 'actuator'"):
        arm(servo(), fm.Control("twin", ["tip.theta"], ["actuator"], copy))


def test_two_laws_in_a_circle_are_refused_unless_one_is_sampled():
    link = arm().find("arm")

    def pair(sample):
        other = fm.Control("other", ["servo.output1"], ["b"], copy, sample=sample)
        return arm(fm.Torque("b", link, 1.0), servo(inputs=["other.output1"]), other)

    with pytest.raises(ModelError, match=r"'other\.output1', 'servo\.output1' depend on one another"):
        fm.simulate(pair(None), t_end=0.01)
    assert fm.simulate(pair(0.01), t_end=0.1).ok


@pytest.mark.parametrize(("law", "text"), [
    (late_root, r"'late_root' of part 'servo' raised ValueError: .*, called with p = \(0.2\), t = 0.2"),
    (beyond, "'beyond' of part 'servo' raised IndexError: index 1 is out of bounds.*t = 0.10"),
])  # fmt: skip
def test_a_law_that_fails_is_named_with_time_and_inputs(law, text):
    sol = fm.simulate(arm(servo(law, numbers=[0.2])), t_end=0.5)
    assert not sol.ok
    assert re.search(text, sol.status), sol.status
    assert "u = (" in sol.status


def test_a_law_cannot_write_its_inputs():
    @fm.control_kernel
    def wrong(p, t, u, x, dx, y):
        u[0] = 1.0

    with pytest.raises(KernelError, match=r"'test_a_law_cannot.*wrong'"):
        fm.simulate(arm(servo(wrong)), t_end=0.1)


PD = fm.PID("servo", "tip.theta", "actuator", target=0.3, kp=20.0, kd=0.5, rate="tip.omega")


def test_a_law_without_states_is_a_spring_in_statics_and_modes():
    """kp (target - angle) = m g a cos(angle); frequency and damping of the arm about it, by hand."""
    mech = arm(PD)
    angle = brentq(lambda x: 20.0 * (0.3 - x) - WEIGHT * ARM * math.cos(x), -1.0, 1.0, xtol=1e-15)
    found = fm.static_equilibrium(mech)
    assert found["arm.theta"] == pytest.approx(angle, abs=1e-10)
    assert found.stable
    stiffness = 20.0 - WEIGHT * ARM * math.sin(angle)
    omega = math.sqrt(stiffness / ARM_INERTIA)
    assert fm.modes(mech, at=found).frequencies[0] == pytest.approx(omega / (2.0 * math.pi), rel=1e-7)
    (root,) = fm.modes(mech, count=1, at=found, damped=True).eigenvalues
    decay = 0.5 / (2.0 * ARM_INERTIA)
    assert (root.real, abs(root.imag)) == pytest.approx((-decay, math.sqrt(omega**2 - decay**2)), rel=1e-7)


@fm.control_kernel
def pull_back(p, t, u, x, dx, y):
    """Torques on two bodies by their relative angle."""
    y[0] = p[0] * u[0]
    y[1] = -p[0] * u[0]


def test_a_law_between_two_bodies_is_a_torsion_spring_in_modes():
    """Frequencies with the law, which is differenced, and with a spring; a law that measures elsewhere has none."""

    def chain_of(*parts):
        one, two = arm().find("arm"), fm.RigidLink("two", (0.5, 0.0), (0.9, 0.0), mass=0.6, inertia=0.01)
        return fm.Mechanism("chain", [
            one, two, fm.Revolute("hinge", fm.GROUND, one, at=(0.0, 0.0)), fm.Revolute("knee", one, two, at=(0.5, 0.0)),
            fm.TorsionSpring("hip", fm.GROUND, one, stiffness=30.0), *parts,
        ])  # fmt: skip

    one, two = chain_of().find("arm"), chain_of().find("two")
    loads = fm.Torque("a", one, 1.0), fm.Torque("b", two, 1.0)
    law = fm.Control("knee law", ["knee.angle"], ["a", "b"], pull_back, numbers=[12.0])
    found = fm.modes(chain_of(*loads, law)).frequencies
    spring = fm.modes(chain_of(fm.TorsionSpring("knee spring", one, two, stiffness=12.0))).frequencies
    assert found == pytest.approx(spring, rel=1e-7)
    elsewhere = fm.Control("elsewhere", ["arm.theta"], ["b"], copy)
    with pytest.raises(SolveError, match="or a controller that measures elsewhere than it acts"):
        fm.modes(chain_of(loads[1], elsewhere))


@pytest.mark.parametrize("controller", [
    fm.PID("servo", "tip.theta", "actuator", kp=1.0, ki=1.0),
    fm.PID("servo", "tip.theta", "actuator", kp=1.0, sample=0.1),
], ids=["states", "sampled"])  # fmt: skip
@pytest.mark.parametrize("analyse", [fm.static_equilibrium, fm.modes])
def test_statics_and_modes_refuse_laws_with_memory(analyse, controller):
    with pytest.raises(ModelError, match=r"states of its own, or a sampled one.*Remove it with without_part"):
        analyse(arm(controller))


@pytest.mark.parametrize("analyse", [
    fm.buckling, lambda m: fm.inverse_dynamics(m, [0.0, 1.0]), fm.lyapunov,
    lambda m: fm.simulate(m, t_end=1.0, step=1e-3, method=Staggered()),
], ids=["buckling", "inverse dynamics", "exponents", "staggered"])  # fmt: skip
@pytest.mark.quick(3)
def test_analyses_without_controllers_refuse_by_name(analyse):
    with pytest.raises(ModelError, match=r"Mechanism 'robot' has Control 'servo'\. Remove it with without_part"):
        analyse(arm(servo()))


def test_the_doctor_counts_bodies_alone():
    report = fm.check(arm(fm.PID("servo", "tip.theta", "actuator", target=1.0, kp=20.0, ki=3.0, kd=3.0)))
    assert report.ok
    assert (report.bodies, report.freedom, report.gruebler, report.mass) == (("arm",), 1, 1, 1.0)


def test_check_part_refuses_what_it_cannot_test():
    """A controller that is saturated at every state, or switches, has no tangent to be compared."""
    for part in (fm.PID("servo", "tip.theta", "actuator", target=100.0, kp=200.0, limit=1.0), servo(switch)):
        with pytest.raises(KernelError, match="depend on no input and no state at any state that was tried"):
            check_part(arm(part), "servo")


def test_tangents_of_two_controllers_are_differences_of_all_rates():
    """Each controller has its own places in the matrix of a step; a wrong one only costs iterations."""
    servo_ = fm.PID("servo", "tip.theta", "actuator", target=1.0, kp=20.0, ki=3.0, kd=3.0)
    smooth = fm.Control("filter", ["arm.omega"], [], chain, numbers=[50.0], states=4, outputs=["smooth"])
    program = compile_mechanism(arm(servo_, smooth))
    system, n = StateEvaluation(program), program.n_q
    q, v = np.array(program.reference.q), np.random.default_rng(0).uniform(-1.0, 1.0, n)
    tangent, found = system.at(q, v, weights=(0.0, 1.0, 0.0)).dense[:n, :n], np.zeros((n, n))
    for k in range(n):
        step = 1e-6 * (np.arange(n) == k)
        found[:, k] = (system.at(q, v + step).force - system.at(q, v - step).force) / 2e-6
    assert np.abs(found).max() > 10.0
    assert found == pytest.approx(tangent, abs=1e-6)


def test_models_without_a_controller_are_not_changed_by_one_without_loads():
    """A law that controls nothing leaves the motion of all bodies as it is, to the bit."""
    watcher = fm.Control("watcher", ["arm.omega"], [], copy, outputs=["out"])
    bare = fm.simulate(arm(), t_end=0.3).restart
    watched = fm.simulate(arm(watcher), t_end=0.3).restart
    assert different(bare, watched) == ["signals", "model"]


def test_files_hold_controllers(tmp_path):
    sol = fm.simulate(arm(fm.PID("servo", "tip.theta", "actuator", target=1.0, kp=20.0, ki=3.0)), t_end=0.1)
    sol.to_netcdf(tmp_path / "robot.nc")
    again = fm.load(tmp_path / "robot.nc")
    assert np.array_equal(again["servo.integral"], sol["servo.integral"])
    fm.write_vtk(sol, tmp_path / "frames")


@fm.control_kernel
def hertzian(p, t, u, x, dx, y):
    y[0] = -p[0] * math.copysign(abs(u[0]) ** 1.5, u[0])


@pytest.mark.parametrize(("stiffness", "accuracy"), [(1e7, 1e-8), (1e10, 1e-5), (1e12, 2e-3)])
def test_laws_of_micrometres_have_their_slopes(stiffness, accuracy):
    """A weight on -K u^1.5 sinks by 99, 1 and 0.05 um; its frequency is sqrt(1.5 K u^0.5/m)."""
    body = fm.RigidBody("b", (0.0, 0.0), 1.0, 1.0)
    guide = fm.Prismatic("guide", fm.GROUND, body, at=(0.0, 0.0), along=(0.0, 1.0))
    spring = fm.Control("spring", ["b.y"], ["push"], hertzian, numbers=(stiffness,))
    parts = [body, guide, fm.Force("push", body, (0.0, 0.0), (0.0, 1.0)), spring]
    mechanism = fm.Mechanism("weight", parts, gravity=(0.0, -9.81))
    rest, sunk = fm.static_equilibrium(mechanism), (9.81 / stiffness) ** (2.0 / 3.0)
    assert rest["b.y"] == pytest.approx(-sunk, rel=1e-6)
    found = fm.modes(mechanism, count=1, at=rest).frequencies[0]
    assert found == pytest.approx(math.sqrt(1.5 * stiffness * math.sqrt(sunk)) / (2.0 * math.pi), rel=accuracy)
