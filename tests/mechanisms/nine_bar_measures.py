"""What is measured on the nine-bar mechanism: the tests hold it to limits, docs/nine_bar_table.py writes it down.

Errors of the ideal mechanism refer to the sums of closed_form.py; differences of the flexible mechanism to the rigid
one; free flight of the joint with play to the sign of its penetration.
"""

import runpy
from pathlib import Path
from types import SimpleNamespace

import numpy as np
from scipy.integrate import simpson

import flexmb as fm
from flexmb.mechanisms import NineBarData, nine_bar

by_hand = SimpleNamespace(**runpy.run_path(str(Path(__file__).with_name("closed_form.py"))))

SPEED = 2.0 * np.pi
PINS = ("O1", "O4", "O6", "P1", "P4", "B2", "B3", "A", "C", "S")
METHODS = {
    "generalised-alpha": (fm.Newmark.generalised_alpha(), 1e-4),
    "trapezoidal": (fm.Newmark.trapezoidal(), 1e-4),
    "adaptive": (fm.Newmark.generalised_alpha(), None),
    "Runge-Kutta": (fm.RungeKutta4(), 1e-3),
}


def finished(mech, **options):
    """The solution of a run that reached its end; any other stops here."""
    sol = fm.simulate(mech, **options)
    if not sol.ok:
        raise RuntimeError(f"{mech.name}: {sol.status}")
    return sol


# The ideal mechanism, by hand.


def ideal_run(method):
    """Two turns, every step."""
    method, step = METHODS[method]
    return finished(nine_bar(SPEED), periods=2, save="steps", step=step, method=method)


def exact(time):
    """Angles, rates, accelerations by hand at these instants."""
    q = by_hand.positions(-SPEED * time, SPEED * time)
    w = by_hand.rates(q, -SPEED + 0.0 * time, SPEED + 0.0 * time)
    return q, w, by_hand.accelerations(q, w)


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


def gaps(sol):
    """Largest distance of the two pins of each joint [m]; of the slider from its line [m], and its tilt [rad]."""
    mech = nine_bar(SPEED)
    found = {j: np.abs(pin_of(mech, sol, j, "second") - pin_of(mech, sol, j, "first")).max() for j in PINS}
    line = np.abs(sol.array("slider.y") - by_hand.LINE).max()
    return {**found, "line": line, "tilt": np.abs(sol.array("slider.theta")).max()}


def motion_errors(sol):
    """Largest error of positions and rates [m, rad, m/s, rad/s], each over the largest value where that is above 1."""
    q, w, _ = exact(sol.time)
    pairs = {"slider.x": q.s9, "slider.vx": w.s9, "rocker6.theta": q.t6, "link8.omega": w.t8, "link2.omega": w.t2}
    return {n: np.abs(sol.array(n) - v).max() / max(1.0, np.abs(v).max()) for n, v in pairs.items()}


def energy_errors(sol):
    """Largest errors of kinetic and potential energy over the largest value of each."""
    q, w, _ = exact(sol.time)
    T, U = by_hand.kinetic_energy(q, w), by_hand.potential_energy(q)
    kinetic = np.abs(sol.array("energy.kinetic") - T).max() / T.max()
    return kinetic, np.abs(sol.array("energy.gravity") - U).max() / np.abs(U).max()


def force_errors(sol):
    """Largest errors of both torques and of the slider's acceleration over the largest value of each."""
    q, w, a = exact(sol.time)
    names = ("motor1.torque", "motor4.torque", "slider.ax")
    pairs = zip(names, (*by_hand.torques(q, w, a), a.s9), strict=True)
    return {name: np.abs(sol.array(name) - right).max() / np.abs(right).max() for name, right in pairs}


def work_errors(sol):
    """Work of the drives less change of energy at 3/8 of the run and at its end, and the energy stored by then.

    All over the energy turned over, the integral of |power|.  Simpson's rule wants equal steps.
    """
    power = sum(sol.array(f"motor{k}.power") for k in (1, 4))
    stored = sol.array("energy.kinetic") + sol.array("energy.gravity")
    half = len(sol.time) * 3 // 8 // 2 * 2 + 1  # an even number of equal steps, to an instant where energy is stored
    turned_over = simpson(np.abs(power), x=sol.time)
    ends = (half, len(sol.time))
    work = [simpson(power[:n], x=sol.time[:n]) - (stored[n - 1] - stored[0]) for n in ends]
    return np.abs(work) / turned_over, abs(stored[half - 1] - stored[0]) / turned_over


def orders(method):
    """(2, 2): order in the step of motor1.torque and slider.ax, between 1 and 1/2 ms and between 1/2 and 1/4 ms."""
    errors = []
    for step in (1e-3, 5e-4, 2.5e-4):
        found = force_errors(finished(nine_bar(SPEED), periods=1, save="steps", step=step, method=method))
        errors.append([found["motor1.torque"], found["slider.ax"]])
    return np.log2(np.array(errors[:-1]) / np.array(errors[1:]))


def inverse_dynamics_errors():
    """Largest errors of both torques of `inverse_dynamics` over the largest value of each, at 41 instants of a turn."""
    times = np.linspace(0.0, 1.0, 41)
    found = fm.inverse_dynamics(nine_bar(SPEED), times)
    pairs = zip(("motor1", "motor4"), by_hand.torques(*exact(times)), strict=True)
    return {drive: np.abs(found.torque(drive) - right).max() / np.abs(right).max() for drive, right in pairs}


# The flexible mechanism against the rigid one.


def third_turn(mech, step):
    return finished(mech, periods=3, save_from_period=2, save=1000, step=step)


def differences(factors, step, names):
    """(factors, names): largest difference to the rigid mechanism over the range of each signal.

    The cranks start softly (one second), and the damping is raised to 1e-4 s so that the shaking of the start is gone
    in the third turn.  Both mechanisms take the same steps.
    """
    rigid = third_turn(nine_bar(SPEED, ramp=1.0), step)
    rows = []
    for factor in factors:
        data = NineBarData(young=factor * 207e9, damping=1e-4)
        soft = third_turn(nine_bar(SPEED, ramp=1.0, flexible=True, data=data), step)
        rows.append([np.abs(soft.array(n) - rigid.array(n)).max() / np.ptp(rigid.array(n)) for n in names])
    return np.array(rows)


# The joint with play.


def turns(mech, speed, count, step=None):
    """One solution a turn, with every step, each going on from the last."""
    state = None
    for k in range(1, count + 1):
        sol = finished(mech, t_end=k * 2.0 * np.pi / speed, save="steps", step=step, restart=state)
        state = sol.restart
        yield sol


def share_of_flight(sol):
    """Part of the time in which the surfaces do not touch, and the number of landings."""
    depth = sol.array("P1.penetration")
    flying = depth[1:] < 0.0
    share = np.diff(sol.time)[flying].sum() / (sol.time[-1] - sol.time[0])
    return share, int(np.count_nonzero((depth[1:] > 0.0) & (depth[:-1] <= 0.0)))
