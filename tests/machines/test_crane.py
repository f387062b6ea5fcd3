"""Crane: a trolley under a PD controller carries a load on a rod; the equations by hand, integrated by scipy.

(M + m) x'' + m l (a'' cos a - a'^2 sin a) = F,  l a'' + x'' cos a + g sin a = 0,  F = kp (r - x) - kd x', limited.
Source: S. H. Strogatz, Nonlinear Dynamics and Chaos; K. J. Astrom, R. M. Murray, Feedback Systems, example 2.1.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import flexmb as fm

M, LOAD, LENGTH, G = 40.0, 120.0, 3.0, 9.81
TARGET, KP, KD, LIMIT = 2.0, 60.0, 160.0, 1e6


def crane(limit, **gains):
    trolley = fm.RigidBody("trolley", at=(0.0, 0.0), mass=M, inertia=1.0)
    load = fm.bodies.PointMass("load", at=(0.0, -LENGTH), mass=LOAD)
    rod = fm.couplings.Distance("rod", trolley, load, at=(0.0, 0.0), to=(0.0, -LENGTH))
    push = fm.Force("push", trolley, at=(0.0, 0.0), force=(1.0, 0.0))
    values = {"kp": KP, "kd": KD, "target": TARGET, "rate": "trolley.vx"} | gains
    servo = fm.PID("servo", "trolley.x", push, limit=limit, **values)
    rail = fm.Prismatic("rail", fm.GROUND, trolley, along=(1.0, 0.0))
    return fm.Mechanism("crane", [trolley, load, rod, rail, push, servo], gravity=(0.0, -G))


def by_hand(times, limit, ki=0.0):
    def rates(_, y):
        x, v, a, w, integral = y
        force = np.clip(KP * (TARGET - x) - KD * v + ki * integral, -limit, limit)
        matrix = np.array([[M + LOAD, LOAD * LENGTH * np.cos(a)], [np.cos(a), LENGTH]])
        right = np.array([force + LOAD * LENGTH * w**2 * np.sin(a), -G * np.sin(a)])
        return [v, *np.linalg.solve(matrix, right)[:1], w, np.linalg.solve(matrix, right)[1], TARGET - x]

    return solve_ivp(rates, (0.0, times[-1]), np.zeros(5), t_eval=times, rtol=1e-10, atol=1e-12).y


@pytest.mark.quick(1)
@pytest.mark.parametrize(("limit", "ki"), [(1e6, 0.0), (1e6, 6.0), (60.0, 0.0)])
def test_trolley_and_load_move_as_the_equations_by_hand(limit, ki):
    times = np.linspace(0.0, 12.0, 121)
    gains = {"ki": ki} if ki else {}
    sol = fm.simulate(crane(limit, **gains), t_end=12.0, save=times, step=fm.Adaptive(rtol=1e-7)).require()
    x, v, a, _, _ = by_hand(times, limit, ki)
    assert sol["trolley.x"].values == pytest.approx(x, abs=2e-5)
    assert sol["trolley.vx"].values == pytest.approx(v, abs=2e-5)
    assert sol["load.x"].values == pytest.approx(x + LENGTH * np.sin(a), abs=2e-5)
    assert np.abs(sol["servo.output"].values).max() <= limit


def test_the_crane_ends_at_its_target():
    sol = fm.simulate(crane(1e6), t_end=120.0, signals=["trolley.x", "load.x"]).require()
    assert float(sol["trolley.x"][-1]) == pytest.approx(TARGET, abs=1e-2)
    assert float(sol["load.x"][-1]) == pytest.approx(TARGET, abs=1e-2)
