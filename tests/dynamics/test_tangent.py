"""The tangent of a step against differences of the step itself, of whole runs, and against exact flows."""

import dataclasses
import math
import runpy
from pathlib import Path

import numpy as np
import pytest

import flexmb as fm
from flexmb.dynamics.systems.dynamics import orthonormalise
from flexmb.dynamics.systems.mechanism_flow import MechanismFlow
from flexmb.engine.system.state_evaluation import StateEvaluation
from flexmb.errors import InputError
from flexmb.mechanisms.nine_bar import nine_bar

models = runpy.run_path(str(Path(__file__).with_name("tangent_models.py")))
pendulum, thrown, fixed, started = (models[k] for k in ("pendulum", "thrown", "fixed", "started"))
tight, difference, missed = (models[k] for k in ("tight", "difference", "missed"))


@fm.element_kernel
def limb_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    """A stiffening spring behind a damper, between two angles: z' = w - z k/c, moment k z (1 + (z/s)^2)."""
    k, c, s = p
    new = (z[0] + h * (v[1] - v[0])) / (1.0 + h * k / c)
    new_v, moment_z = h / (1.0 + h * k / c), k * (1.0 + 3.0 * (new / s) ** 2)
    moment = k * new * (1.0 + (new / s) ** 2)
    r[0] -= moment
    r[1] += moment
    for i in range(2):
        for j in range(2):
            C[i, j] += (1.0 if i == j else -1.0) * moment_z * new_v
    z_new[0] = new


@dataclasses.dataclass(frozen=True)
class Limb(fm.Element):
    """The element of `limb_kernel`."""

    first: fm.Part
    second: fm.Part
    stiffness: float
    damping: float
    softness: float

    kernel = limb_kernel
    coords = ("first.theta", "second.theta")

    def history(self):
        return (0.05,)


def limb(upper, lower, knee, tip):
    """An element with history between the rods."""
    return Limb("L", upper, lower, 4.0, 1.5, 0.1)


SOFT = fm.contact.ExactRestitution(2e4, restitution=0.6)
LUGRE = fm.friction.LuGre(0.4, 0.3, stribeck_speed=0.2, stiffness=2e3, damping=0.5, viscous=0.05)


def one_step(flow, duration, eps=1e-4):
    """Carry a difference through one step and hold it against differences of the step."""
    W = started(flow)
    expected = difference(flow, duration, W[:, 0], eps)
    carried = models["displaced"](flow, np.zeros(flow.size))
    assert carried.advance(duration, W), carried.status
    off = missed(flow, W[:, 0], expected)
    assert max(off.values()) < 1e-6, off


SMOOTH = {
    "rods": pendulum,
    "spring": lambda: pendulum(extras=(models["spring"],)),
    "element with history": lambda: pendulum(extras=(limb,)),
    "beam": lambda: pendulum(lower=models["beam"]),
    "bushing": models["bushed"],
    "LuGre in a joint": lambda: pendulum(friction=LUGRE),
    "friction in a joint": lambda: pendulum(friction=models["LOSS"]),
    "one-way clutch": models["clutched"],
}


@pytest.mark.quick(2)
@pytest.mark.parametrize("name", SMOOTH)
@pytest.mark.parametrize("first", [True, False])
def test_one_step_without_contacts(name, first, monkeypatch):
    tight(monkeypatch)
    h = 2e-4 if name == "beam" else 1e-3
    flow = fixed(SMOOTH[name](), h)
    flow.advance(0.1)
    if first:
        flow.reset(flow.state(), time=flow.time)
    one_step(flow, h, eps={"beam": 1e-7, "one-way clutch": 1e-8}.get(name, 1e-4))


@pytest.mark.parametrize("lower", [None, models["beam"]], ids=["rigid", "beam"])
@pytest.mark.parametrize("form", ["position", "velocity"])
def test_one_step_with_other_forms_of_the_constraints(form, lower, monkeypatch):
    tight(monkeypatch)
    flow = fixed(pendulum(lower=lower), 1e-3, method=fm.Newmark.generalised_alpha(0.8, constraints=form))
    flow.advance(0.1)
    one_step(flow, 1e-3, eps=1e-7 if lower else 1e-4)


def gap_of(flow):
    """Gap of the first contact."""
    return flow.run.flow.z[flow.program.tables.contacts.z[0, 0] + 2]


def at_stage(flow, stage, h):
    """Advance to the step before the onset, into the contact, or to the step before its end."""
    while True:
        ahead = flow.copy()
        assert ahead.advance(h)
        now, then = gap_of(flow), gap_of(ahead)
        found = {
            "flight": 0.0 < now < 0.01,
            "onset": now > 0.0 > then,
            "contact": now < -4e-3,
            "release": now < 0.0 < then,
        }
        if found[stage]:
            return
        flow.advance(h)


@pytest.mark.quick(3)
@pytest.mark.parametrize(
    "friction", [models["LOSS"], pytest.param(LUGRE, marks=pytest.mark.slow)], ids=["smooth", "LuGre"]
)
@pytest.mark.parametrize("stage", ["flight", "onset", "contact", "release"])
def test_one_step_of_a_contact(stage, friction, monkeypatch):
    tight(monkeypatch)
    h = 1e-3
    flow = fixed(thrown(SOFT, friction), h)
    at_stage(flow, stage, h)
    one_step(flow, h, eps=1e-6)


@pytest.mark.parametrize("reference", ["onset", "largest"])
@pytest.mark.parametrize("stage", ["onset", "contact"])
def test_one_step_of_a_contact_that_is_pressed(stage, reference, monkeypatch):
    """The disc is pushed on the wall, so that it closes faster than it met; the damping follows or not."""
    tight(monkeypatch)
    h = 1e-3
    disc = thrown(dataclasses.replace(SOFT, reference_speed=reference), speed=0.3, clearance=0.002)
    push = fm.Force("F", disc.find("ball"), (0.0, 0.0), (60.0, 0.0))
    flow = fixed(fm.Mechanism("pushed", (*disc.parts, push)), h)
    at_stage(flow, stage, h)
    one_step(flow, h, eps=1e-6)
    if stage == "contact":
        onset, reached = flow.run.flow.z[flow.program.tables.contacts.z[0, 1] + np.array([3, 0])]
        assert (reached > 1.2 * onset) == (reference == "largest")


@pytest.mark.parametrize("flexible", [False, True], ids=["rigid", "flexible"])
def test_one_step_of_the_nine_bar(flexible, monkeypatch):
    tight(monkeypatch)
    flow = fixed(nine_bar(clearance=5e-4, flexible=flexible), 2e-5 if flexible else 2e-4)
    flow.advance(4e-3)
    one_step(flow, flow.step.size, eps=1e-9 if flexible else 1e-6)


def half_a_second(flow, h, W=None):
    """Advance step by step, each with factors of its own."""
    for _ in range(round(0.5 / h)):
        flow.run.flow.reuse.age = 0.0
        assert flow.advance(h, W) if W is not None else flow.advance(h), flow.status


def missed_by_runs(form, h, extras=()):
    """What tangent and differences of half a second differ by, relative."""
    flow = fixed(pendulum(extras=extras), h, method=fm.Newmark.generalised_alpha(0.8, constraints=form))
    W, ends = started(flow), []
    for part in (1e-4, -1e-4):
        other = models["displaced"](flow, part * W[:, 0])
        half_a_second(other, h)
        ends.append(other.state())
    half_a_second(flow, h, W)
    off = missed(flow, W[:, 0], (ends[0] - ends[1]) / 2e-4)
    return max(off["q"], off["v"], off.get("z0", 0.0))


def test_runs_of_many_steps_agree_with_differences_of_runs(monkeypatch):
    tight(monkeypatch)
    assert missed_by_runs("position", 5e-3, (limb,)) < 1e-6


def test_the_direction_of_shifts_is_held_which_is_an_error_of_second_order(monkeypatch):
    """The shifts that close the joints are S^-1 G^T mu; the tangent leaves out what S^-1 G^T itself changes by."""
    tight(monkeypatch)
    errors = [missed_by_runs("gear-gupta-leimkuhler", h) for h in (5e-3, 2.5e-3)]
    assert errors[1] < 1e-4
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.15)


@pytest.mark.parametrize("make", [lambda: pendulum(extras=(models["spring"],)), lambda: thrown(SOFT)])
def test_velocity_is_the_rate_of_the_state(make):
    flow = fixed(make(), 1e-4)
    flow.advance(0.03)
    n, found, states = flow.program.n_q, flow.velocity(), []
    for _ in range(3):
        states.append(flow.state())
        flow.advance(1e-4)
    rate = (-3.0 * states[0] + 4.0 * states[1] - states[2]) / 2e-4
    for part in (slice(0, n), slice(n, 2 * n), slice(-2 * n, -n)):
        np.testing.assert_allclose(found[part], rate[part], atol=1e-3 * np.abs(rate[part]).max())


def test_the_run_itself_does_not_feel_its_tangents():
    mechanism = thrown(SOFT)
    alone, together = MechanismFlow(mechanism, period=0.1), MechanismFlow(mechanism, period=0.1)
    alone.advance(0.15)
    together.advance(0.15, together.tangent_basis(3))
    np.testing.assert_array_equal(alone.state(), together.state())


def reached(mechanism, state, start, duration, step):
    """The state a duration after `state`."""
    flow = MechanismFlow(mechanism, step=step, period=1.0)
    flow.reset(state, time=start)
    assert flow.advance(duration), flow.status
    return flow.state()


@pytest.mark.parametrize("pushed", [False, True])
def test_impacts_in_located_steps_agree_with_differences_of_runs_of_small_steps(pushed):
    """Two impacts with friction; a load in time goes on while neighbours are compared at their own onsets."""
    disc = thrown(SOFT)
    if pushed:
        load = fm.Force("F", disc.find("ball"), (0.0, 0.0), (30.0, 0.0), history=fm.drives.Harmonic(1.0, 40.0))
        disc = fm.Mechanism("pushed", (*disc.parts, load))
    flow = fixed(disc, 1e-5, period=1.0)
    flow.advance(5e-3)
    state, start = flow.state(), flow.time
    W = started(flow)
    ends = [reached(disc, state + part * W[:, 0], start, 0.25, fm.FixedStep(1e-5)) for part in (1e-6, -1e-6)]
    wanted, errors = (ends[0] - ends[1]) / 2e-6, []
    for rtol in (1e-4, 1e-6):
        carrying, own = MechanismFlow(disc, step=fm.Adaptive(rtol=rtol), period=1.0), W.copy()
        carrying.reset(state, time=start)
        assert carrying.advance(0.25, own), carrying.status
        off = missed(carrying, own[:, 0], wanted)
        errors.append(max(off["q"], off["v"]))
    assert errors[0] < 6e-3, errors
    assert errors[1] < 5e-4, errors


def test_hard_impacts_of_the_nine_bar():
    """An impact multiplies what is wrong of its time by 1/duration: steps that did not follow its onset missed all."""
    mechanism = nine_bar(clearance=5e-4)
    flow = MechanismFlow(mechanism)
    flow.advance(0.0325)
    state, start, w = flow.state(), flow.time, flow.weights
    flow.reset(state, time=start)
    W = started(flow)
    ends = [reached(mechanism, state + part * W[:, 0], start, 4.5e-3, fm.Adaptive(rtol=1e-6)) for part in (1e-6, -1e-6)]
    wanted = (ends[0] - ends[1]) / 2e-6
    assert flow.advance(4.5e-3, W), flow.status
    assert np.sqrt(w @ (W[:, 0] - wanted) ** 2) < 0.03 * np.sqrt(w @ wanted**2)


def test_a_load_that_jumps_in_time(monkeypatch):
    """Runs start anew there, and so do the accelerations of neighbours; speeds and positions do not jump."""
    tight(monkeypatch)

    def pushed(upper, lower, knee, tip):
        return fm.Force("F", lower, tip, (0.0, 40.0), history=fm.drives.Pulse(start=0.0513, end=0.1), follower=True)

    flow = fixed(
        pendulum(extras=(pushed,)), 2e-3, method=fm.Newmark.generalised_alpha(0.8, constraints="position"), period=1.0
    )
    W = started(flow)
    expected = difference(flow, 0.15, W[:, 0], 1e-4)
    assert flow.advance(0.15, W)
    off = missed(flow, W[:, 0], expected)
    assert max(off["q"], off["v"]) < 1e-7, off
    assert off["a"] < 1e-5, off  # Newton's method leaves 1e-14 m of the positions open, and 1e-14 m/h^2 here


def turning_of(flow, dq):
    """d(G v + g_t)/dq dq by differences of the rates themselves."""
    n, system, t = flow.program.n_q, StateEvaluation(flow.program), flow.time
    q, v = flow.run.flow.q[:n], flow.run.flow.v[:n]
    eps = 1e-4
    rates = [system.at(q + part * eps * dq, v, t=t).velocity_residual for part in (1.0, -1.0, 2.0, -2.0)]
    return (8.0 * (rates[0] - rates[1]) - (rates[2] - rates[3])) / (12.0 * eps)


def test_tangents_stay_on_the_manifold():
    """A thousand steps of a driven mechanism with play, through impacts."""
    flow = MechanismFlow(nine_bar(clearance=5e-4))
    n = flow.program.n_q
    W, steps = flow.tangent_basis(2), flow.run.record.count.steps
    while flow.run.record.count.steps - steps < 1000:
        assert flow.advance(0.05, W), flow.status
        G = StateEvaluation(flow.program).at(flow.run.flow.q[:n], t=flow.time).jacobian
        for w in W.T:
            dq, dv = w[:n] / np.abs(w[:n]).max(), w[n : 2 * n] / np.abs(w[:n]).max()
            assert np.abs(G @ dq).max() < 1e-10  # neighbours that hit much later cancel some digits
            assert np.abs(G @ dv + turning_of(flow, dq)).max() < 1e-8 * max(np.abs(dv).max(), 1.0)  # round-off over h
        orthonormalise(W, flow.weights)  # which leaves few digits of a vector that has come close to another one


def bounced(x, v, *, mass, stiffness, damping, wall, t):
    """Position and velocity at t of a mass thrown at a wall with spring and damper that cannot pull, exactly."""
    arrival = (wall - x) / v
    w0, zeta = math.sqrt(stiffness / mass), damping / (2.0 * math.sqrt(stiffness * mass))
    w = w0 * math.sqrt(1.0 - zeta * zeta)
    end = 2.0 * math.acos(zeta) / w  # see KelvinVoigt.delivered_restitution
    decay = math.exp(-zeta * w0 * end)
    depth = v / w * decay * math.sin(w * end)
    back = v * decay * (math.cos(w * end) - zeta * w0 / w * math.sin(w * end))
    return wall + depth + back * (t - arrival - end), back


def test_a_force_that_is_there_at_once_jumps_the_tangent():
    """A damper in a contact: exact flow of a straight impact, all derivatives of it."""
    law = {"mass": 1.0, "stiffness": 1e4, "damping": 60.0, "wall": 0.02, "t": 0.06}
    ball = fm.RigidBody("ball", (0.0, 0.0), 1.0, 2e-3, velocity=(1.0, 0.0, 0.0))
    normal = fm.KelvinVoigt(law["stiffness"], law["damping"])
    hole = {"clearance": law["wall"], "bearing_radius": 0.08, "normal": normal}
    mechanism = fm.Mechanism("straight", (ball, fm.RevoluteClearance("J", fm.GROUND, ball, (0.0, 0.0), **hole)))
    errors = []
    for rtol in (1e-4, 1e-6):
        flow = MechanismFlow(mechanism, step=fm.Adaptive(rtol=rtol), period=0.06)
        flow.advance(1e-3)  # away from the middle, where the gap has a peak
        W = np.zeros((flow.size, 2))
        W[0, 0] = W[flow.program.n_q, 1] = 1.0
        W = flow.on_manifold(W)
        x, v = flow.state()[[0, flow.program.n_q]]
        assert flow.advance(law["t"], W), flow.status
        exact = np.empty((2, 2))
        for k, (dx, dv) in enumerate(((1.0, 0.0), (0.0, 1.0))):
            ends = [np.array(bounced(x + e * dx, v + e * dv, **law)) for e in (1e-6, -1e-6)]
            exact[:, k] = (ends[0] - ends[1]) / 2e-6
        found = W[[0, flow.program.n_q]]
        errors.append(np.abs(found - exact).max(axis=1) / np.abs(exact).max(axis=1))
    assert np.max(errors[1]) < 2e-3
    assert np.max(errors[1]) < 0.3 * np.max(errors[0])


def test_tangents_of_another_shape_are_refused():
    flow = fixed(pendulum(), 1e-3)
    for wrong in (np.zeros(flow.size), np.zeros((flow.size - 1, 1)), np.zeros((flow.size, 2), dtype=np.float32)):
        with pytest.raises(InputError, match="one difference a column"):
            flow.advance(0.1, wrong)
    with pytest.raises(InputError, match="not finite"):
        flow.advance(0.1, np.full((flow.size, 1), np.nan))


def test_differences_that_overflow_end_with_a_status():
    flow = fixed(pendulum(), 1e-3)
    W = 1e300 * flow.tangent_basis(1)
    assert not flow.advance(60.0, W)
    assert "grew beyond all numbers" in flow.status or "no finite solution" in flow.status
