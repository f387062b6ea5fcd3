"""Derivatives along runs beside central differences of the same runs, and beside closed forms."""

import numpy as np
import pytest
from cases import slow_where
from designs import CENTRAL, SMOOTH, WITH_IMPACTS, Case, ball
from scipy.optimize import brentq

import flexmb as fm
from flexmb.design.parameters import ParameterModel
from flexmb.errors import SolveError
from flexmb.parts.joints.stop import Stop


def differences(case: Case, name: str, times: np.ndarray, part: float) -> np.ndarray:
    """Derivatives (signals, times) by fourth-order differences of the parameter, relative to it by `part`."""
    held = ParameterModel("test", case.model, case.parameters)
    h, found = part * case.parameters[name], 0.0
    for place, weight in CENTRAL:
        mechanism = held.at((case.parameters | {name: case.parameters[name] + place * h}).values())
        sol = fm.simulate(mechanism, t_end=case.end, save=times.tolist(), step=case.step, signals=list(case.of))
        assert sol.ok, sol.status
        found = found + weight / h * np.array([np.asarray(sol[s]) for s in case.of])
    return found


def errors(case: Case, part: float) -> list[float]:
    """Error of each derivative over its largest value, or over a thousandth of the signal over the parameter."""
    found = fm.design.sensitivity(
        case.model, case.parameters, of=case.of, t_end=case.end, save=np.linspace(0.0, case.end, 21), step=case.step
    )
    worst = []
    for k, name in enumerate(case.parameters):
        expected = differences(case, name, found.dataset.time.values, part)
        for row, signal in zip(expected, case.of, strict=True):
            size = np.abs(found.signals[signal].values).max() / case.parameters[name]
            worst.append(np.abs(found[signal].values[k] - row).max() / max(np.abs(row).max(), 1e-2 * size))
    return worst


@pytest.mark.quick(1)
@pytest.mark.parametrize("name", slow_where(lambda n: n in ("plate", "pendulum"), SMOOTH))
def test_smooth_motions_agree_with_differences(name):
    assert max(errors(SMOOTH[name], 1e-3)) < 3e-5


@pytest.mark.quick(1)
@pytest.mark.parametrize(
    "name",
    slow_where(lambda n: n in ("worn, friction", "worn, flexible"), WITH_IMPACTS),
)
def test_motions_through_impacts_agree_with_differences(name):
    # differences see the error of the steps over the difference of the parameter
    assert max(errors(WITH_IMPACTS[name], 3e-4)) < 5e-4


def stopped(mu: float, rate: float, t: np.ndarray) -> np.ndarray:
    """Position of a mass of 1 kg on a rough plane (g = 10), released from 0.3 m; friction turns round at rest."""
    w, c = np.sqrt(rate), mu * 10.0 / rate
    turns = np.floor(w * t / np.pi)
    sign = (-1.0) ** turns
    return sign * c + sign * (0.3 - 2.0 * c * turns - c) * np.cos(w * t - turns * np.pi)


@pytest.mark.parametrize("creep", [1e-4, pytest.param(1e-8, marks=pytest.mark.slow)])
def test_friction_that_turns_round_within_a_step(creep):
    """The law changes its sign within a slip that steps leap over; the error falls with the step, or with rtol."""

    def block(mu: float, rate: float) -> fm.Mechanism:
        body = fm.RigidBody("block", (0.3, 0.0), 1.0, 1.0)
        law = fm.friction.SmoothCoulomb(mu, v0=creep)
        guide = fm.Prismatic("guide", fm.GROUND, body, at=(0.0, 0.0), along=(1.0, 0.0), friction=law, length=1e3)
        ends = {"at": (-1.0, 0.0), "to": (0.3, 0.0), "free_length": 1.0}
        spring = fm.loads.SpringDamper("spring", fm.GROUND, body, **ends, stiffness=rate)
        return fm.Mechanism("block", [body, guide, spring], (0.0, -10.0))

    given, t = {"mu": 0.2, "rate": 100.0}, np.array([0.2, 0.5, 0.8, 1.0])
    by_mu = (stopped(0.2 + 1e-6, 100.0, t) - stopped(0.2 - 1e-6, 100.0, t)) / 2e-6
    by_rate = (stopped(0.2, 100.0 + 1e-4, t) - stopped(0.2, 100.0 - 1e-4, t)) / 2e-4
    worst = []
    for step in (1e-3, 1e-4, fm.Adaptive(rtol=1e-6)):
        found = fm.design.sensitivity(block, given, of=["block.x"], t_end=1.0, save=t, step=step)
        own = found["block.x"].values[:, 1:]
        worst.append(np.abs(own / [by_mu, by_rate] - 1.0).max())
    assert worst[0] < 0.04
    assert worst[1] < 0.004
    assert worst[2] < 3e-3  # slopes may miss a thousandth of the force


EXACT = {  # of a ball that returns with e times its speed, by T. 50 m, 9.8 m/s^2, e = .8
    "h0": (0.21744565164973, 0.56348913032995),
    "g": (1.87472271249865, -2.12505545749727),
    "e": (56.5247584249853, 31.3049516849971),
}


def bounced(stiffness: float) -> np.ndarray:
    """Derivatives of height and speed of a ball after T = 5 s by h0, g and e, (2, 3); h0 = 50 m, g = 9.8, e = .8."""
    of = [fm.design.at_end("ball.y"), fm.design.at_end("ball.vy")]
    given = {"h0": 50.0, "g": 9.8, "e": 0.8}
    step = fm.Adaptive(rtol=1e-9, max=0.05)
    found = fm.design.sensitivity(lambda h0, g, e: ball(h0, g, e, stiffness), given, of=of, t_end=5.0, step=step)
    return found.measures.derivative.values + np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])  # y counts from the start


def test_a_ball_on_a_table_nears_its_closed_form_with_the_stiffness():
    """The duration of an impact falls with k^-0.4, and with it the error; the limit is extrapolated to 1e-5."""
    exact = np.array(list(EXACT.values())).T
    soft, hard = bounced(1e8), bounced(1e10)
    order = np.log(np.abs(soft - exact) / np.abs(hard - exact))[[0, 0, 1, 1], [0, 2, 1, 2]] / np.log(1e2)
    assert order == pytest.approx(0.4, abs=0.02)
    factor = 1e2**0.4
    limit = (factor * hard - soft) / (factor - 1.0)
    assert np.abs(limit / exact - 1.0).max() < 1e-5


def test_derivatives_by_closed_forms_before_an_impact():
    """A ball that falls for 2 s: y = -g t^2/2."""
    found = fm.design.sensitivity(ball, {"h0": 50.0, "g": 9.8, "e": 0.8}, of=["ball.y"], t_end=2.0, save=4)
    t = found.dataset.time.values
    expected = np.array([0.0 * t, -0.5 * t**2, 0.0 * t])
    assert found["ball.y"].values == pytest.approx(expected, abs=1e-9)


def test_a_chaotic_motion_is_refused_beyond_its_horizon():
    with pytest.raises(SolveError, match=r"grew by .* derivatives say nothing there"):
        fm.design.sensitivity(WITH_IMPACTS["worn"].model, ["rod.mass"], of=["slider.x"], periods=5)


def test_peak_at_an_onset_grows_with_the_way_to_it():
    """A ball that falls on a table: its largest speed is sqrt(2 g h), of the derivative sqrt(g/(2 h)) by the height."""
    case = WITH_IMPACTS["ball"]
    found = fm.design.sensitivity(
        case.model, {"h0": 5.0, "g": 9.8, "e": 0.8}, of=[fm.design.peak("ball.vy")], t_end=1.2, step=case.step
    )
    speed, by_height, by_gravity = 98.0**0.5, (9.8 / 10.0) ** 0.5, (5.0 / 19.6) ** 0.5
    assert found.measures.amount.item() == pytest.approx(speed, rel=1e-5)
    assert found.measures.derivative.values[0] == pytest.approx([by_height, by_gravity, 0.0], rel=1e-4, abs=1e-4)


def test_mean_of_a_force_that_jumps_at_the_onset_keeps_the_balance_of_momentum():
    """Mean force of a stop with damping: m (v(T) - v(0))/T + m g, whatever is varied."""

    def dropped(height: float, stiffness: float) -> fm.Mechanism:
        body = fm.RigidBody("ball", (0.0, 0.0), 1.0, 1.0)
        guide = fm.Prismatic("guide", fm.GROUND, body, at=(0.0, 0.0), along=(0.0, 1.0))
        table = Stop("table", guide, below=-height, normal=fm.KelvinVoigt(stiffness, 20.0))
        return fm.Mechanism("ball", [body, guide, table], (0.0, -9.81))

    of = [fm.design.mean("table.normal_force"), fm.design.at_end("ball.vy")]
    numbers, end = {"height": 0.02, "stiffness": 1e4}, 0.12
    found = fm.design.sensitivity(dropped, numbers, of=of, t_end=end, step=fm.Adaptive(rtol=1e-6))
    force, speed = found.measures.derivative.values
    assert force == pytest.approx(speed / end, rel=1e-3)


@pytest.mark.parametrize("step", [0.05, fm.Adaptive(rtol=1e-4)])
def test_mean_of_a_signal_that_jumps_with_a_load(step):
    """A force from 0.5 s on: no step counts the jump as a slope."""

    def pushed(force: float) -> fm.Mechanism:
        body = fm.RigidBody("body", (0.0, 0.0), 2.0, 1.0)
        load = fm.Force("push", body, (0.0, 0.0), (force, 0.0), history=fm.drives.Pulse(start=0.5))
        return fm.Mechanism("pushed", [body, load])

    found = fm.design.sensitivity(pushed, {"force": 3.0}, of=[fm.design.mean("body.ax")], t_end=1.0, step=step)
    assert float(found.measures.amount[0]) == pytest.approx(0.75, rel=1e-9)
    assert float(found.measures.derivative[0, 0]) == pytest.approx(0.25, rel=1e-9)


@pytest.mark.parametrize("step", [0.01, None])
def test_peaks_beside_jumps_of_a_load(step):
    """A force on a mass with a damper, on from 0.5 to 1 s: F/m exp(-d t/m), then the damper alone, -d v/m."""

    def pushed(force: float) -> fm.Mechanism:
        body = fm.RigidBody("body", (0.0, 0.0), 2.0, 1.0)
        damper = fm.SpringDamper("d", fm.GROUND, body, at=(-1.0, 0.0), to=(0.0, 0.0), stiffness=0.0, damping=3.0)
        load = fm.Force("push", body, (0.0, 0.0), (force, 0.0), history=fm.drives.Pulse(start=0.5, end=1.0))
        return fm.Mechanism("pushed", [body, damper, load])

    of = [fm.design.largest("body.ax"), fm.design.smallest("body.ax"), fm.design.peak("body.ax")]
    found = fm.design.sensitivity(pushed, {"force": 6.0}, of=of, t_end=1.5, step=step).measures
    exact = np.array([0.5, -0.5 * (1.0 - np.exp(-0.75)), 0.5])
    assert found.amount.values == pytest.approx(6.0 * exact, rel=1e-4)
    assert found.derivative.values[:, 0] == pytest.approx(exact, rel=1e-4)


def test_peak_of_a_force_that_jumps_at_the_onset():
    """A damper that is met with the speed v pushes most at once, with d v; its onset stays where it is."""

    def dropped(damping: float) -> fm.Mechanism:
        body = fm.RigidBody("ball", (0.0, 0.1), 1.0, 1.0)
        guide = fm.Prismatic("guide", fm.GROUND, body, at=(0.0, 0.1), along=(0.0, 1.0))
        table = Stop("table", guide, below=-0.1, normal=fm.KelvinVoigt(1e4, damping))
        return fm.Mechanism("ball", [body, guide, table], (0.0, -9.81))

    found = fm.design.sensitivity(dropped, {"damping": 150.0}, of=[fm.design.peak("table.normal_force")], t_end=0.25)
    speed = (2.0 * 9.81 * 0.1) ** 0.5
    assert found.measures.amount.item() == pytest.approx(150.0 * speed, rel=1e-3)
    assert found.measures.derivative.item() == pytest.approx(speed, rel=1e-3)


def after_a_stop(stiffness: float, damping: float, t: float) -> tuple[float, float]:
    """Height and speed of 1 kg, thrown up from 20 mm above a stop with 1 m/s, at an instant after its first bounce."""
    g, drop = 9.81, 0.02
    onset = (1.0 + np.sqrt(1.0 + 2.0 * g * drop)) / g
    speed, decay = g * onset - 1.0, 0.5 * damping
    w, rest = np.sqrt(stiffness - decay**2), g / stiffness  # the depth oscillates about `rest`

    def depth(s: float) -> np.ndarray:
        """Depth and its rate at the time s after the onset."""
        a, b = -rest, (speed - decay * rest) / w
        c, d = np.cos(w * s), np.sin(w * s)
        wave = np.exp(-decay * s)
        return np.array([rest + wave * (a * c + b * d), wave * ((b * w - decay * a) * c - (a * w + decay * b) * d)])

    def force(s: float) -> float:
        return float(depth(s) @ [stiffness, damping])

    ends = brentq(force, 0.75 * np.pi / w, 1.25 * np.pi / w, xtol=1e-15)
    (deep, rate), later = depth(ends), t - onset - ends
    assert later > 0.0
    return -drop - deep - rate * later - 0.5 * g * later**2, -rate - g * later


@pytest.mark.quick(1)
@pytest.mark.parametrize("damping", [0.0, 10.0])
@pytest.mark.parametrize(("rtol", "limit"), [(1e-4, 1.6e-2), (1e-6, 6e-4)])
def test_a_force_that_ends_with_a_kink(damping, rtol, limit):
    """The stiffness of a stop falls at once: where the gap opens, and with a damper before, where the force is zero."""

    def model(stiffness):
        body = fm.RigidBody("b", (0.0, 0.0), 1.0, 0.1, velocity=(0.0, 1.0, 0.0))
        guide = fm.Prismatic("guide", fm.GROUND, body, at=(0.0, 0.0), along=(0.0, 1.0))
        stop = fm.Stop("stop", joint="guide", below=-0.02, normal=fm.KelvinVoigt(stiffness, damping))
        return fm.Mechanism("bounce", [body, guide, stop], gravity=(0.0, -9.81))

    k, h = 2e3, 1.0
    for end in (0.31, 0.35, 0.4):
        of, step = [fm.design.at_end("b.y"), fm.design.at_end("b.vy")], fm.Adaptive(rtol=rtol)
        found = fm.design.sensitivity(model, {"stiffness": k}, of=of, t_end=end, step=step)
        expected = sum(weight / h * np.array(after_a_stop(k + place * h, damping, end)) for place, weight in CENTRAL)
        missed = np.abs(found.measures.derivative.values[:, 0] - expected)
        assert missed[0] < limit * 2.6e-5  # largest in the contact; y' passes zero
        assert missed[1] < limit * abs(expected[1])


def test_reduced_plates_by_their_thickness():
    """Shapes keep their signs beside neighbours; the largest stress, sought in groups of other nodes, has no slope."""

    def plate(thickness):
        mesh = fm.meshes.rectangle(0.6, 0.02, 12, 1)
        kind = {"material": fm.STEEL, "pins": ("left", "right"), "thickness": thickness}
        body = fm.Reduced(fm.PlaneBody("plate", mesh, at=(0.0, 0.0), **kind), modes=3)
        push = fm.Force("F", body, at=(0.6, 0.01), force=(3.0, -20.0))
        return fm.Mechanism("m", [body, fm.Fixed("wall", fm.GROUND, body, at=(0.0, 0.01)), push])

    span = {"t_end": 5e-3, "save": 2, "step": 2e-4}
    found = fm.design.sensitivity(plate, {"thickness": 0.01}, of=["plate.right.y", "plate.von_mises"], **span)
    right = [float(fm.simulate(plate(h), **span)["plate.right.y"][-1]) for h in (0.00999, 0.01001)]
    assert float(found["plate.right.y"][0, -1]) == pytest.approx((right[1] - right[0]) / 2e-5, rel=1e-3)
    assert np.isnan(found["plate.von_mises"][0, -1])
