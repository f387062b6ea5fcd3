"""Broken models with controllers, motors, couplings, stops and cams end in a named error, status or remark."""

import math

import numpy as np
import pytest
from broken import O

import flexmb as fm
from flexmb.errors import FlexmbError

SOFT = fm.KelvinVoigt(1.0, 0.0)
LIN = fm.KelvinVoigt(1e6, 1e2)
K = fm.couplings
GRAIN = fm.bodies.PointMass("m", O, 1.0)
TURN = np.linspace(0.0, 2.0 * math.pi, 61)[:-1]


@fm.control_kernel
def root_of_negative(p, t, u, x, dx, y):
    y[0] = math.sqrt(-1.0 - u[0])


@fm.control_kernel
def reciprocal(p, t, u, x, dx, y):
    y[0] = 1.0 / u[0]


@fm.control_kernel
def beyond_its_outputs(p, t, u, x, dx, y):
    y[3] = 1.0


@fm.control_kernel
def escape_in_finite_time(p, t, u, x, dx, y):
    dx[0] = 1.0 + x[0] * x[0]
    y[0] = x[0]


def arm(*parts):
    """A pendulum with an actuator of 1 N m."""
    body = fm.RigidLink("arm", O, (0.5, 0.0), mass=1.0, inertia=1.0 / 48.0)
    hinge = fm.Revolute("hinge", fm.GROUND, body, at=O)
    return fm.Mechanism("robot", [body, hinge, fm.Torque("actuator", body, 1.0), *parts], gravity=(0.0, -9.81))


def control(law, **more):
    return arm(fm.Control("brain", ["arm.theta"], ["actuator"], law, **more))


def servo(**more):
    return arm(fm.PID("servo", more.pop("measure", "arm.theta"), "actuator", target=1.0, **{"kp": 10.0, **more}))


def stop(law, *parts, **limits):
    return arm(fm.Stop("stop", "hinge", normal=law, radius=0.1, **limits), *parts)


def train(*meshes):
    """Two wheels on fixed axes, the first one driven."""
    one, two = fm.RigidBody("one", O, 0.5, 1e-4), fm.RigidBody("two", (0.09, 0.0), 0.5, 1e-3)
    axes = [fm.Revolute("O", fm.GROUND, one, at=O), fm.Revolute("Q", fm.GROUND, two, at=two.at)]
    drive = fm.Drive("motor", "O", fm.ConstantSpeed(4.0))
    return fm.Mechanism("train", [one, two, *axes, drive, *(mesh(one, two) for mesh in meshes)])


def gear(**more):
    return lambda one, two: fm.Gear(more.pop("name", "mesh"), one, two, **{"teeth": (20, 40), **more})


def eccentric(speed, **pair):
    """An eccentric disc under a flat follower on a spring."""
    curve = fm.ClosedCurve(np.column_stack([0.01 + 0.03 * np.cos(TURN), 0.03 * np.sin(TURN)]))
    cam, follower = fm.RigidBody("cam", O, 0.5, 1e-3), fm.RigidBody("follower", (0.0, 0.03), 0.3, 1e-4)
    return fm.Mechanism("valve", [
        cam, follower, fm.Revolute("axis", fm.GROUND, cam, at=O),
        fm.Prismatic("guide", fm.GROUND, follower, along=(0.0, 1.0)),
        fm.CurveOnCurve("tappet", cam, curve, follower, fm.Line((-0.05, 0.03), (0.05, 0.03)), **pair),
        fm.SpringDamper("spring", fm.GROUND, follower, (0.0, 0.2), (0.0, 0.03), stiffness=2e3, free_length=0.2),
        fm.Drive("motor", "axis", fm.ConstantSpeed(speed)),
    ])  # fmt: skip


def hoist(**cable):
    weight = fm.bodies.PointMass("weight", (0.0, -1.0), 1.0)
    rope = K.Cable("rope", fm.GROUND, weight, O, (0.0, -1.0), **{"normal": SOFT, **cable})
    return fm.Mechanism("hoist", [weight, rope], gravity=(0.0, -9.81))


def clutch(stiffness):
    rotor = fm.RigidBody("rotor", O, 1.0, 0.1)
    pawl = K.OneWayClutch("clutch", fm.GROUND, rotor, at=O, stiffness=stiffness)
    return fm.Mechanism("freewheel", [rotor, pawl, fm.Torque("load", rotor, -1.0)])


REFUSED = {
    "a law that fails": (lambda: control(root_of_negative), "'root_of_negative' of part 'brain' raised"),
    "a law that divides by 0": (lambda: control(reciprocal), "'reciprocal' of part 'brain' gave numbers that are not"),
    "a law beyond its outputs": (lambda: control(beyond_its_outputs), "'brain': control kernel 'beyond_its_outputs'"),
    "a measured signal that is none": (lambda: servo(measure="arm.thetta"), "Did you mean 'arm.theta'"),
    "a servo that reads its own torque": (lambda: servo(measure="actuator.torque"), "depend on the outputs"),
    "a motor that reads itself": (
        lambda: arm(fm.controllers.DCMotor(
            "motor", "arm.omega", "actuator", voltage="motor.voltage", resistance=1.0, torque_constant=0.1
        )), "an algebraic loop",
    ),
    "two gears at odds": (lambda: train(gear(), gear(name="other", teeth=(20, 41))), "'motor', 'mesh', 'other'"),
    "a gear on itself": (lambda: train(lambda one, _: fm.Gear("mesh", one, one, teeth=(2, 4))), "with itself"),
    "play beyond a tooth": (lambda: train(gear(backlash=0.5, normal=LIN)), "backlash is 0.5 m"),
    "belts, open and crossed": (
        lambda: train(*(
            lambda a, b, k=k: K.Belt(f"belt{k}", a, b, radii=(0.03, 0.06), crossed=k > 0) for k in range(2)
        )), "'motor', 'belt0', 'belt1' repeat one another",
    ),
    "a relation that holds a drive": (lambda: train(lambda *_: K.Coupling("hold", {"O": 1.0})), "'motor', 'hold'"),
    "a stop behind the start": (lambda: stop(LIN, above=-1.0), "above is -1, but the joint starts at 0"),
    "a particle that is turned": (
        lambda: fm.Mechanism("m", [GRAIN, fm.Torque("t", GRAIN, 1.0)]),
        "'t' needs the rotation of PointMass 'm'",
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_a_model_that_is_refused_by_name(case):
    build, words = REFUSED[case]
    with pytest.raises(FlexmbError, match=words.replace("(", r"\(")):
        fm.simulate(build(), t_end=0.1)


STOPPED = {
    "a state that runs to infinity": (lambda: control(escape_in_finite_time, states=1), "largest at 'brain.state1'"),
    "a gain beyond floats": (lambda: servo(kp=1e300), "no longer finite"),
    "a stop that yields": (lambda: stop(SOFT, below=-0.1), "Stopped: Stop 'stop': the parts pass through each other"),
    "a drive beyond a stop": (
        lambda: stop(LIN, fm.Drive("motor", "hinge", fm.ConstantSpeed(1.0)), above=0.1),
        "Stopped: Stop 'stop': the parts pass through each other",
    ),
    "teeth that slip through": (
        lambda: train(gear(backlash=1e-4, normal=SOFT), lambda _, two: fm.Torque("load", two, -300.0)),
        "Stopped: Gear 'mesh': the parts pass through each other",
    ),
    "a cam through its follower": (
        lambda: eccentric(40.0, normal=fm.KelvinVoigt(1e2, 0.0)), "CurveOnCurve 'tappet': the parts pass through",
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", STOPPED)
def test_a_run_that_is_not_ok(case):
    build, words = STOPPED[case]
    sol = fm.simulate(build(), t_end=2.0, save=50)
    assert not sol.ok
    assert words in sol.status


def parting(speed):
    """Ideal gears, the second of which is carried away."""
    one, two, sledge = (fm.RigidBody(n, (x, 0.0), 1.0, 0.1) for n, x in (("one", 0.0), ("two", 0.09), ("sledge", 0.09)))
    return fm.Mechanism("parting", [
        one, two, sledge, fm.Revolute("O", fm.GROUND, one, at=O), fm.Revolute("Q", sledge, two, at=two.at),
        fm.Prismatic("rail", fm.GROUND, sledge, at=two.at, along=(1, 0)), fm.Gear("mesh", one, two, teeth=(20, 40)),
        fm.Drive("motor", "O", fm.ConstantSpeed(10.0)), fm.Drive("pull", "rail", fm.ConstantSpeed(speed)),
    ])  # fmt: skip


NOTED = {
    "gears that part": (lambda: parting(0.1), "the centres of the wheels of Gear 'mesh' are 0.19 m apart"),
    "a follower that is pulled": (lambda: eccentric(400.0), "CurveOnCurve 'tappet' pulls with "),
    "a rope of rubber": (hoist, "Cable 'rope' is stretched by "),
    "a clutch that winds up": (lambda: clutch(1e-3), "OneWayClutch 'clutch' is wound up by some "),
}


@pytest.mark.parametrize("case", NOTED)
def test_a_run_with_a_remark(case):
    build, words = NOTED[case]
    sol = fm.simulate(build(), t_end=1.0 if case != "a follower that is pulled" else 0.03, save=50)
    assert any(words in note for note in sol.notes), sol.notes


def test_sound_ones_are_left_alone():
    """A follower below its lift-off at 163 rad/s, a stiff rope, clutch and stop, and teeth that carry."""
    sound = [
        (parting(1e-6), 0.5), (eccentric(100.0), 0.06), (hoist(normal=fm.KelvinVoigt(1e4, 10.0)), 0.5),
        (clutch(1e3), 0.5), (stop(fm.HuntCrossley(1e8, restitution=0.8), below=-0.1), 0.5),
        (train(gear(backlash=1e-4, normal=LIN), lambda _, two: fm.Torque("load", two, -3.0)), 0.2),
    ]  # fmt: skip
    for mech, span in sound:
        sol = fm.simulate(mech, t_end=span, save=50)
        assert sol.ok, sol.status
        assert not sol.notes, sol.notes
