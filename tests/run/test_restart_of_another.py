"""A restart belongs to one mechanism, not to its steps: other wiring is refused, steps of another size are taken."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

import flexmb as fm
from flexmb.errors import InputError

END = {"t_end": 0.01, "step": 1e-3, "save": 3}
GAIN = 2.0


def two(*parts, turned=False):
    """Two equal bodies, free, on which parts act; `turned`: declared the other way about."""
    bodies = [fm.RigidBody(name, (x, 0.0), mass=1.0, inertia=1.0) for name, x in (("a", 0.0), ("b", 1.0))]
    built = [part(*bodies) for part in parts]
    return fm.Mechanism("two", [*(bodies[::-1] if turned else bodies), *built], gravity=(0.0, 0.0))


def controlled(measure="a.theta", load="on_a", **changes):
    """Two bodies with a moment of 1 N m each, one of which a controller turns on and off."""
    given = {"kp": 1.0, "ki": 0.5, "sample": 2e-3, "target": 0.3, **changes}
    servo = fm.PID("servo", measure, load, **given)
    return two(lambda a, b: fm.Torque("on_a", a, 1.0), lambda a, b: fm.Torque("on_b", b, 1.0), lambda a, b: servo)


def law(gain):
    @fm.control_kernel
    def proportional(p, t, u, x, dx, y):
        y[0] = gain * u[0]

    return proportional


@fm.control_kernel
def of_a_global(p, t, u, x, dx, y):
    y[0] = GAIN * u[0]


def by_law(kernel, inputs=("a.theta",), sample=None):
    """Two bodies, one of which has a moment by a control law."""
    servo = fm.Control("servo", list(inputs), ["on_a"], kernel, sample=sample)
    return two(lambda a, b: fm.Torque("on_a", a, 1.0), lambda a, b: servo)


def pushed(stiffness):
    """Two bodies, one of which is held by a spring whose kernel has its stiffness from around it."""

    @fm.element_kernel
    def spring(p, t, h, q, v, a, z, r, K, C, M, z_new):
        r[0] = stiffness * q[0]
        K[0, 0] = stiffness

    @dataclass(frozen=True)
    class Held(fm.Element):
        """A spring to the ground.

        Parameters
        ----------
        name : its name.
        body : what it holds.
        """

        body: fm.Part
        kernel = spring
        coords = ("body.x",)

    return two(lambda a, b: Held("held", a))


def force(on):
    at = (0.0, 0.0) if on == "a" else (1.0, 0.0)
    return two(lambda a, b: fm.Force("push", {"a": a, "b": b}[on], at=at, force=(1.0, 0.5)))


def torque(on):
    return two(lambda a, b: fm.Torque("turn", {"a": a, "b": b}[on], 1.0))


def pair(part, turned=False):
    return two((lambda a, b: part(b, a)) if turned else part)


def joined(kind, turned=False):
    return pair(lambda a, b: kind("j", a, b, at=(0.5, 0.0)), turned)


def held(on, kind=fm.Revolute):
    at = (0.0, 0.0) if on == "a" else (1.0, 0.0)
    return two(lambda a, b: kind("j", fm.GROUND, {"a": a, "b": b}[on], at=at))


def spring(on):
    return two(lambda a, b: fm.TorsionSpring("s", fm.GROUND, {"a": a, "b": b}[on], stiffness=1.0, damping=0.1))


def driven(on):
    return two(
        lambda a, b: fm.Revolute("ja", fm.GROUND, a, at=(0.0, 0.0)),
        lambda a, b: fm.Revolute("jb", fm.GROUND, b, at=(1.0, 0.0)),
        lambda a, b: fm.Drive("drive", on, fm.drives.Harmonic(0.1, 2.0)),
    )


PAIRS = {
    "force on the other body": (force("a"), force("b")),
    "torque on the other body": (torque("a"), torque("b")),
    "spring on the other body": (spring("a"), spring("b")),
    "hinge of the other body": (held("a"), held("b")),
    "clamp of the other body": (held("a", fm.Fixed), held("b", fm.Fixed)),
    "drive of the other joint": (driven("ja"), driven("jb")),
    "bodies of a hinge": (joined(fm.Revolute), joined(fm.Revolute, turned=True)),
    "bodies of a coupling": (
        pair(lambda a, b: fm.couplings.SameRotation("c", a, b)),
        pair(lambda a, b: fm.couplings.SameRotation("c", a, b), turned=True),
    ),
    "order of the bodies": (torque("a"), two(lambda a, b: fm.Torque("turn", a, 1.0), turned=True)),
    "input of a controller": (controlled("a.theta"), controlled("b.theta")),
    "speed for an angle": (controlled("a.theta"), controlled("a.omega")),
    "load of a controller": (controlled(), controlled(load="on_b")),
    "sampling time": (controlled(), controlled(sample=1e-3)),
    "sampled or not": (controlled(), controlled(sample=None)),
    "gain of a sampled controller": (controlled(), controlled(kp=1.5)),
    "target of a sampled controller": (controlled(), controlled(target=0.4)),
    "input at all times": (controlled("a.theta", sample=None), controlled("b.theta", sample=None)),
    "load at all times": (controlled(sample=None), controlled(load="on_b", sample=None)),
    "gain in a closure": (by_law(law(1.0)), by_law(law(2.0))),
    "gain in a closure, sampled": (by_law(law(1.0), sample=2e-3), by_law(law(2.0), sample=2e-3)),
    "inputs of a law": (by_law(law(1.0)), by_law(law(1.0), ["b.theta"])),
    "inputs of a sampled law": (by_law(law(1.0), sample=2e-3), by_law(law(1.0), ["b.theta"], sample=2e-3)),
    "motion as an input": (
        by_law(law(1.0), [fm.drives.Harmonic(1.0, 2.0)]),
        by_law(law(1.0), [fm.drives.Harmonic(1.0, 3.0)]),
    ),
    "motion as a sampled input": (
        by_law(law(1.0), [fm.drives.Harmonic(1.0, 2.0)], sample=2e-3),
        by_law(law(1.0), [fm.drives.Harmonic(1.0, 3.0)], sample=2e-3),
    ),
    "stiffness in a closure": (pushed(1.0), pushed(2.0)),
}


@pytest.mark.quick(11)
@pytest.mark.parametrize("kind", PAIRS)
def test_other_wiring_is_refused(kind):
    first, second = PAIRS[kind]
    for own, other in ((first, second), (second, first)):
        restart = fm.simulate(own, **END).restart
        with pytest.raises(InputError, match=r"restart (is of another mechanism|does not fit this model)"):
            fm.simulate(other, **{**END, "t_end": 0.02}, restart=restart)
        assert fm.simulate(own, **{**END, "t_end": 0.02}, restart=restart).ok


def test_the_message_names_wiring():
    restart = fm.simulate(force("a"), **END).restart
    with pytest.raises(InputError, match="the same parts are wired otherwise"):
        fm.simulate(force("b"), **{**END, "t_end": 0.02}, restart=restart)


def test_a_global_number_of_a_law_counts(monkeypatch):
    restart = fm.simulate(by_law(of_a_global), **END).restart
    monkeypatch.setitem(globals(), "GAIN", 3.0)
    other = fm.control_kernel(of_a_global.function)  # as in a process that starts with the other number
    with pytest.raises(InputError, match="numbers differ that their functions take from outside"):
        fm.simulate(by_law(other), **{**END, "t_end": 0.02}, restart=restart)


def test_a_restart_of_former_versions_is_taken():
    """Files of versions without the digest of the wiring have two rows; they are compared by these."""
    restart = fm.simulate(force("a"), **END).restart
    former = {**restart, "model": restart["model"][:2]}
    assert fm.simulate(force("a"), **{**END, "t_end": 0.02}, restart=former).ok
    for damaged in (restart["model"][:1], restart["model"][:0], np.zeros((2, 8), dtype=np.uint8), np.array(3)):
        with pytest.raises(InputError, match="another mechanism"):
            fm.simulate(force("a"), **{**END, "t_end": 0.02}, restart={**restart, "model": damaged})


def test_kernels_of_one_factory_are_told_apart():
    """x'' = -k x: two kernels with the same code and other closures were taken for one in a second mechanism."""
    times = []
    for stiffness in (1.0, 4.0, 9.0):
        mechanism = pushed(stiffness)
        start = replace(mechanism.parts[0], velocity=(1.0, 0.0, 0.0))
        sol = fm.simulate(mechanism.with_part(start), t_end=1.0, step=fm.Adaptive(rtol=1e-9), save=2)
        times.append(float(sol["a.x"][-1]))
    expected = [np.sin(np.sqrt(k)) / np.sqrt(k) for k in (1.0, 4.0, 9.0)]
    assert times == pytest.approx(expected, abs=1e-6)


def pendulum():
    """Link of 0.5 m that falls from the horizontal."""
    link = fm.RigidBody("link", (0.25, 0.0), mass=1.0, inertia=0.02)
    return fm.Mechanism("pendulum", [link, fm.Revolute("pin", fm.GROUND, link, at=(0.0, 0.0))], gravity=(0.0, -9.81))


@pytest.mark.parametrize("method", [None, fm.RungeKutta4(), fm.RadauIIA(), fm.DormandPrince()])
@pytest.mark.parametrize("before", [fm.FixedStep(5e-3), fm.Adaptive()])
def test_fixed_steps_behind_other_steps(method, before):
    """A run that goes on takes its own steps, not those of the run before, and is as exact as they are."""
    first = fm.simulate(pendulum(), t_end=0.5, method=None if method == fm.RungeKutta4() else method, step=before)
    go_on = {"t_end": 1.0, "restart": first.restart, "save": "steps"}
    second = fm.simulate(pendulum(), method=method, step=1e-3, **go_on)
    assert second.ok, second.status
    assert second.stats.largest_step == pytest.approx(1e-3)
    finer = fm.simulate(pendulum(), method=method, step=2.5e-4, **go_on)
    assert second.array("link.theta")[-1] == pytest.approx(finer.array("link.theta")[-1], abs=4e-5)


@pytest.mark.parametrize("tiny", [1e-9, 1e-11, 1e-12])
def test_fixed_steps_behind_a_tiny_step(tiny):
    """Accelerations of a step of a nanosecond are round-off over its square, and were carried over into a whole one."""
    whole = fm.simulate(pendulum(), t_end=1.0, step=1e-3)
    first = fm.simulate(pendulum(), t_end=0.3003, step=1e-3)
    second = fm.simulate(pendulum(), t_end=0.3003 + tiny, step=1e-3, restart=first.restart, save="steps")
    third = fm.simulate(pendulum(), t_end=1.0, step=1e-3, restart=second.restart)
    assert third.ok, third.status
    assert third.peak("pin.fy").value == pytest.approx(whole.peak("pin.fy").value, rel=1e-3)
    assert third.array("link.theta")[-1] == pytest.approx(whole.array("link.theta")[-1], abs=2e-5)


@pytest.mark.parametrize("later", [1e-9, 1e-10])
def test_saving_that_begins_a_moment_behind_a_sample(later):
    """A run without restart has such a step, too."""
    link = fm.RigidBody("link", (0.25, 0.0), mass=1.0, inertia=0.02)
    pin, torque = fm.Revolute("pin", fm.GROUND, link, at=(0.0, 0.0)), fm.Torque("torque", link, 1.0)
    servo = fm.PID("servo", "link.theta", "torque", kp=5.0, ki=1.0, kd=0.5, target=0.3, sample=0.01)
    mech = fm.Mechanism("arm", [link, pin, torque, servo])
    wanted, found = [
        fm.simulate(mech, t_end=0.4, step=1e-3, save_from=0.2 + x).peak("pin.fx").value for x in (0.0, later)
    ]
    assert found == pytest.approx(wanted, rel=1e-2)


def test_joints_that_repeat_one_another_behind_a_restart():
    """Their forces would be anything, as in a run that begins so."""
    crank, rod, rest = ((0.0, 0.0), (1.0, 0.0), (2.0, 0.0)), [], []
    bar = fm.RigidBody("bar", (1.0, 1.0), mass=1.0, inertia=0.1)
    for k, (x, y) in enumerate(crank):
        rod.append(fm.RigidBody(f"rod{k}", (x, y + 0.5), mass=1.0, inertia=0.1))
        rest += [fm.Revolute(f"O{k}", fm.GROUND, rod[k], at=(x, y)), fm.Revolute(f"A{k}", rod[k], bar, at=(x, y + 1.0))]
    mech = fm.Mechanism("parallel", [bar, *rod, *rest], gravity=(0.3, -9.81))
    first = fm.simulate(mech, t_end=0.01, step=1e-3, redundant="least-norm")
    assert fm.simulate(mech, t_end=0.02, step=1e-3, restart=first.restart, redundant="least-norm").ok
    with pytest.raises(InputError, match="redundant='least-norm'"):
        fm.simulate(mech, t_end=0.02, step=1e-3, restart=first.restart)


@pytest.mark.parametrize("saved", [{}, {"save_from": 0.2}])
def test_saving_that_begins_behind_a_restart(saved):
    """Instants are counted from `save_from`, as without a restart, not from where the run before began to save."""
    first = fm.simulate(pendulum(), t_end=0.3, **saved)
    second = fm.simulate(pendulum(), t_end=1.0, restart=first.restart, save_from=0.55, save=0.1)
    assert second.time == pytest.approx([0.55, 0.65, 0.75, 0.85, 0.95, 1.0], abs=1e-12)
