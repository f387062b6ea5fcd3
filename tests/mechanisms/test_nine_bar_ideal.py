"""The ideal rigid nine-bar mechanism against loop equations, energies and torques worked out by hand."""

import runpy
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import simpson

import flexmb as fm
from flexmb.mechanisms import nine_bar

by_hand = SimpleNamespace(**runpy.run_path(str(Path(__file__).with_name("closed_form.py"))))

SPEED = 2.0 * np.pi
METHODS = {
    "generalised-alpha": (fm.Newmark.generalised_alpha(), 1e-4),
    "trapezoidal": (fm.Newmark.trapezoidal(), 1e-4),
    "adaptive": (fm.Newmark.generalised_alpha(), None),
    "Runge-Kutta": (fm.RungeKutta4(), 1e-3),
}


def exact(time):
    """Angles, rates, accelerations by hand at these instants."""
    q = by_hand.positions(-SPEED * time, SPEED * time)
    w = by_hand.rates(q, -SPEED + 0.0 * time, SPEED + 0.0 * time)
    return q, w, by_hand.accelerations(q, w)


@pytest.fixture(scope="module")
def runs():
    found = {}
    for name, (method, step) in METHODS.items():
        sol = fm.simulate(nine_bar(SPEED), periods=2, save="steps", step=step, method=method)
        assert sol.ok, sol.status
        found[name] = sol
    return found


def pin_of(mech, sol, joint, side):
    """(n,) complex: where the body on that side of the joint holds its pin, from its node's signals."""
    part = mech.find(joint)
    body = getattr(part, side)
    at = complex(*part.at)
    if body.name == "ground":
        return at + 0.0 * sol.time
    node = body.nodes()[0]
    arm = (at - complex(node.x, node.y)) * np.exp(-1j * node.theta)
    x, y, theta = (sol.array(f"{body.name}.{axis}") for axis in ("x", "y", "theta"))
    return x + 1j * y + arm * np.exp(1j * theta)


@pytest.mark.parametrize("method", METHODS)
def test_all_loops_stay_closed_at_every_step(runs, method):
    sol, mech = runs[method], nine_bar(SPEED)
    assert len(sol.time) == sol.stats.steps + 1
    for joint in ("O1", "O4", "O6", "P1", "P4", "B2", "B3", "A", "C", "S"):
        gap = np.abs(pin_of(mech, sol, joint, "second") - pin_of(mech, sol, joint, "first"))
        assert gap.max() <= 1e-10, joint
    assert np.abs(sol.array("slider.y") - 0.090).max() <= 1e-10
    assert np.abs(sol.array("slider.theta")).max() <= 1e-10


@pytest.mark.parametrize("method", METHODS)
def test_motion_is_that_of_the_loop_equations(runs, method):
    sol = runs[method]
    q, w, _ = exact(sol.time)
    pairs = {"slider.x": q.s9, "slider.vx": w.s9, "rocker6.theta": q.t6, "link8.omega": w.t8, "link2.omega": w.t2}
    for name, value in pairs.items():
        assert np.abs(sol.array(name) - value).max() <= 1e-10 * max(1.0, np.abs(value).max()), name


@pytest.mark.parametrize("method", METHODS)
def test_kinetic_energy_is_eq_12_and_potential_energy_eq_13(runs, method):
    sol = runs[method]
    q, w, _ = exact(sol.time)
    T, U = by_hand.kinetic_energy(q, w), by_hand.potential_energy(q)
    assert np.abs(sol.array("energy.kinetic") - T).max() <= 1e-10 * T.max()
    assert np.abs(sol.array("energy.gravity") - U).max() <= 1e-10 * np.abs(U).max()


def test_eq_12_as_printed_is_wrong(runs):
    """With L3^2 in J22, as the paper prints it, the energy is far off: the check above can fail."""
    sol = runs["generalised-alpha"]
    q, w, _ = exact(sol.time)
    printed = by_hand.kinetic_energy(q, w) + 0.5 * by_hand.M2 * (by_hand.L3**2 - (by_hand.L2 / 2) ** 2) * w.t2**2
    assert np.abs(sol.array("energy.kinetic") - printed).max() > 0.05 * printed.max()


@pytest.mark.parametrize("method", ["generalised-alpha", "trapezoidal", "Runge-Kutta"])
def test_work_of_the_drives_is_the_change_of_energy(runs, method):
    sol = runs[method]
    power = sum(sol.array(f"motor{k}.power") for k in (1, 4))
    stored = sol.array("energy.kinetic") + sol.array("energy.gravity")
    half = len(sol.time) * 3 // 8 // 2 * 2 + 1  # an even number of equal steps, to an instant where energy is stored
    turned_over = simpson(np.abs(power), x=sol.time)
    for n in (half, len(sol.time)):
        work = simpson(power[:n], x=sol.time[:n])
        assert abs(work - (stored[n - 1] - stored[0])) <= 1e-6 * turned_over
    assert abs(stored[half - 1] - stored[0]) > 0.01 * turned_over  # something was stored: the check can fail


@pytest.mark.parametrize("method", ["generalised-alpha", "trapezoidal"])
def test_ledger_of_energy_closes(runs, method):
    sol = runs[method]
    power = np.abs(sum(sol.array(f"motor{k}.power") for k in (1, 4)))
    assert sol.peak("energy.residual").value <= 1e-6 * simpson(power, x=sol.time)


@pytest.mark.parametrize("method", ["generalised-alpha", "trapezoidal", "Runge-Kutta"])
def test_torques_and_acceleration_are_those_of_virtual_power(runs, method):
    """From the first step on: no transient of the start."""
    sol = runs[method]
    q, w, a = exact(sol.time)
    limit = 1e-10 if method == "Runge-Kutta" else 1e-6
    for drive, torque in zip(("motor1", "motor4"), by_hand.torques(q, w, a), strict=True):
        error = np.abs(sol.array(f"{drive}.torque") - torque)
        assert error.max() <= limit * np.abs(torque).max()
    error = np.abs(sol.array("slider.ax") - a.s9)
    assert error.max() <= limit * np.abs(a.s9).max()


@pytest.mark.parametrize("method", [fm.Newmark.trapezoidal(), fm.Newmark.generalised_alpha()], ids=["tr", "ga"])
def test_errors_of_torque_and_acceleration_are_of_second_order_in_the_step(method):
    errors = []
    for step in (1e-3, 5e-4, 2.5e-4):
        sol = fm.simulate(nine_bar(SPEED), periods=1, save="steps", step=step, method=method)
        q, w, a = exact(sol.time)
        torque = by_hand.torques(q, w, a)[0]
        pairs = ((sol.array("motor1.torque"), torque), (sol.array("slider.ax"), a.s9))
        errors.append([np.abs(found - right).max() for found, right in pairs])
    orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert np.abs(orders - 2.0).max() <= 0.05


def test_inverse_dynamics_agrees_with_virtual_power():
    times = np.linspace(0.0, 1.0, 41)
    found = fm.inverse_dynamics(nine_bar(SPEED), times)
    q, w, a = exact(times)
    for drive, torque in zip(("motor1", "motor4"), by_hand.torques(q, w, a), strict=True):
        assert np.abs(found.torque(drive) - torque).max() <= 1e-10 * np.abs(torque).max()


def test_start_at_other_angles_is_the_same_mechanism():
    """Started a quarter turn later, the slider does what it does a quarter turn later."""
    later = fm.simulate(nine_bar(SPEED, start=(-np.pi / 2, np.pi / 2)), periods=1, save="steps")
    q, w, _ = exact(later.time + 0.25)
    assert np.abs(later.array("slider.x") - q.s9).max() <= 1e-10
    assert np.abs(later.array("slider.vx") - w.s9).max() <= 1e-10
