"""Smooth rigid motion at equal error: flexmb beside MuJoCo, scipy's DOP853 and hand-written loops.

    python tests/speed/smooth.py          # the table of docs/performance.md, and out/speed/smooth.json
    python tests/speed/smooth.py --quick  # without the chains of 100 and 1000 links

Open chains of N rigid links, 1 m in all, fall from the horizontal; Andrews' mechanism is that of examples/andrews.py.
A peer gets the equations that somebody would write down for the one mechanism: the chain by recursion over its links
(articulated inertias at the pins, of order N), Andrews' mechanism in its seven angles (E. Hairer, G. Wanner, Solving
Ordinary Differential Equations II, VII.7), both through numba.  An entry is the least CPU time of the process, of three
runs each, over all tolerances or steps whose error is at most the given one.  A peer that is not installed is left out.
"""

import argparse
import math
import sys
import time
from collections.abc import Callable
from pathlib import Path
from unittest import mock

import numba
import numpy as np
from duel import keep
from scipy.integrate import solve_ivp

import flexmb as fm

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "examples"))
import andrews as A

try:
    import mujoco
except ImportError:
    mujoco = None

G, REPEATS = 9.81, 3
CELLS = (("chain of 10", 1e-5), ("chain of 10", 1e-7), ("chain of 100", 1e-3), ("chain of 1000", 1e-5))
CELLS += (("Andrews", 1e-5), ("Andrews", 1e-8))
SPANS = {"chain of 10": 1.0, "chain of 100": 1.0, "chain of 1000": 0.25, "Andrews": 0.03}  # s
RTOL = (3e-1, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10)
FEWEST = 20  # steps in a run at least
STEPS = (200, 400, 800, 1600, 3200, 6400, 12800)  # in a run

Timed = tuple[float, np.ndarray]


# Open chains


def links(name: str) -> int:
    """Number of links."""
    return int(name.rpartition(" ")[2])


def chain(count: int) -> fm.Mechanism:
    """The chain of flexmb."""
    length = 1.0 / count
    bodies = [
        fm.RigidLink(f"link{k}", (k * length, 0.0), ((k + 1) * length, 0.0), length, length**3 / 12.0)
        for k in range(count)
    ]
    pins = [
        fm.Revolute(f"pin{k}", bodies[k - 1] if k else fm.GROUND, bodies[k], (k * length, 0.0)) for k in range(count)
    ]
    return fm.Mechanism("chain", [*bodies, *pins], gravity=(0.0, -G))


@numba.njit
def chain_rates(t, y):
    """Rates of the angles and angular speeds (2 N,) of the chain.

    From the tip, a link needs the force A a + b at its pin, whose acceleration is a; its angular acceleration is
    -(w . a + k)/D, with w = m l/2 n + l A' n of the link beyond.
    """
    n = y.shape[0] // 2
    rates, m, length = np.empty(2 * n), 1.0 / n, 1.0 / n
    w = np.empty((n, 4))
    axx = axy = ayy = bx = by = 0.0
    for i in range(n - 1, -1, -1):
        c, s, speed = math.cos(y[i]), math.sin(y[i]), y[n + i]
        nx, ny, way = -s, c, speed * speed * length
        anx, any_ = axx * nx + axy * ny, axy * nx + ayy * ny
        px, py = bx - way * (axx * c + axy * s), by - way * (axy * c + ayy * s)
        wx, wy = length * (0.5 * m * nx + anx), length * (0.5 * m * ny + any_)
        D = m * length * length / 3.0 + length * length * (nx * anx + ny * any_)
        k = 0.5 * m * length * G * ny + length * (nx * px + ny * py)
        bx, by = px - 0.5 * m * way * c - wx * k / D, py + m * G - 0.5 * m * way * s - wy * k / D
        axx, axy, ayy = axx + m - wx * wx / D, axy - wx * wy / D, ayy + m - wy * wy / D
        w[i, 0], w[i, 1], w[i, 2], w[i, 3] = wx, wy, k, D
    ax = ay = 0.0
    for i in range(n):
        c, s, speed = math.cos(y[i]), math.sin(y[i]), y[n + i]
        turn = -(w[i, 0] * ax + w[i, 1] * ay + w[i, 2]) / w[i, 3]
        rates[i], rates[n + i] = speed, turn
        ax, ay = ax - length * (turn * s + speed * speed * c), ay + length * (turn * c - speed * speed * s)
    return rates


@numba.njit
def runge_kutta(y, t_end, steps):
    """The chain by Runge and Kutta."""
    h, t = t_end / steps, 0.0
    for _ in range(steps):
        k1 = chain_rates(t, y)
        k2 = chain_rates(t, y + 0.5 * h * k1)
        k3 = chain_rates(t, y + 0.5 * h * k2)
        k4 = chain_rates(t, y + h * k3)
        y = y + h / 6.0 * (k1 + 2.0 * (k2 + k3) + k4)
    return y


def tip(angles: np.ndarray) -> np.ndarray:
    """Place of the tip by the angles (N,)."""
    return np.array([np.cos(angles).sum(), np.sin(angles).sum()]) / len(angles)


def mujoco_chain(count: int) -> str:
    """The chain in the language of MuJoCo."""
    length = 1.0 / count
    inertia = length**3 / 12.0
    head = f'<mujoco><option gravity="0 {-G} 0" integrator="RK4"><flag contact="disable"/></option><worldbody>'
    text = "".join(
        f'<body pos="{length if k else 0.0} 0 0"><joint type="hinge" axis="0 0 1"/><inertial pos="{0.5 * length} 0 0" '
        f'mass="{length}" diaginertia="{inertia} {inertia} {inertia}"/>'
        for k in range(count)
    )
    return f"{head}{text}{'</body>' * count}</worldbody></mujoco>"


def by_mujoco(count: int, t_end: float, steps: int) -> Callable[[], Timed]:
    """The chain by MuJoCo's Runge-Kutta method."""
    model = mujoco.MjModel.from_xml_string(mujoco_chain(count))
    model.opt.timestep = t_end / steps

    def run() -> Timed:
        data = mujoco.MjData(model)
        began = time.process_time()
        mujoco.mj_step(model, data, steps)
        return time.process_time() - began, tip(np.cumsum(data.qpos))

    return run


# Andrews' mechanism in seven angles


@numba.njit
def andrews_rates(t, y):
    """Rates of (beta, Theta, gamma, Phi, delta, Omega, epsilon) and their speeds, with the joints in accelerations."""
    m, J = A.MASSES, A.INERTIAS
    d, da, e, ea, rr, ra, ss, sa, sb, sc, sd = A.d, A.da, A.e, A.ea, A.rr, A.ra, A.ss, A.sa, A.sb, A.sc, A.sd
    ta, tb, u, ua, ub, zf, zt, fa = A.ta, A.tb, A.u, A.ua, A.ub, A.zf, A.zt, A.fa
    be, th, ga, ph, de, om, ep = y[0], y[1], y[2], y[3], y[4], y[5], y[6]
    v = y[7:]
    K, right = np.zeros((13, 13)), np.zeros(13)
    K[0, 0] = m[0] * ra**2 + m[1] * (rr**2 - 2.0 * da * rr * math.cos(th) + da**2) + J[0] + J[1]
    K[0, 1] = K[1, 0] = m[1] * (da**2 - da * rr * math.cos(th)) + J[1]
    K[1, 1] = m[1] * da**2 + J[1]
    K[2, 2] = m[2] * (sa**2 + sb**2) + J[2]
    r = e - ea
    K[3, 3] = m[3] * r**2 + J[3]
    K[3, 4] = K[4, 3] = m[3] * (r**2 + zt * r * math.sin(ph)) + J[3]
    K[4, 4] = m[3] * (zt**2 + 2.0 * zt * r * math.sin(ph) + r**2) + m[4] * (ta**2 + tb**2) + J[3] + J[4]
    x = zf - fa
    K[5, 5] = m[5] * x**2 + J[5]
    K[5, 6] = K[6, 5] = m[5] * (x**2 - u * x * math.sin(om)) + J[5]
    K[6, 6] = m[5] * (x**2 - 2.0 * u * x * math.sin(om) + u**2) + m[6] * (ua**2 + ub**2) + J[5] + J[6]
    cg, sg = math.cos(ga), math.sin(ga)
    px, py = sd * cg + sc * sg + A.B[0] - A.C[0], sd * sg - sc * cg + A.B[1] - A.C[1]
    far = math.sqrt(px * px + py * py)
    force = -A.STIFFNESS * (far - A.FREE_LENGTH) / far
    right[0] = A.TORQUE - m[1] * da * rr * v[1] * (v[1] + 2.0 * v[0]) * math.sin(th)
    right[1] = m[1] * da * rr * v[0] ** 2 * math.sin(th)
    right[2] = force * (px * (sc * cg - sd * sg) + py * (sd * cg + sc * sg))
    right[3] = m[3] * zt * r * v[4] ** 2 * math.cos(ph)
    right[4] = -m[3] * zt * r * v[3] * (v[3] + 2.0 * v[4]) * math.cos(ph)
    right[5] = -m[5] * u * x * v[6] ** 2 * math.cos(om)
    right[6] = m[5] * u * x * v[5] * (v[5] + 2.0 * v[6]) * math.cos(om)
    # arms of the closing equations: crank and link in all of them, then the way back along each branch
    cb, sb_, ct, st = rr * math.cos(be), rr * math.sin(be), d * math.cos(be + th), d * math.sin(be + th)
    cp, sp, cd, sd_ = e * math.cos(ph + de), e * math.sin(ph + de), zt * math.cos(de), zt * math.sin(de)
    co, so, ce, se = zf * math.cos(om + ep), zf * math.sin(om + ep), u * math.cos(ep), u * math.sin(ep)
    both, w1, w2, w3 = (v[0] + v[1]) ** 2, v[0] ** 2, (v[3] + v[4]) ** 2, (v[5] + v[6]) ** 2
    for k in range(3):
        K[7 + 2 * k, 0], K[7 + 2 * k, 1] = -sb_ + st, st
        K[8 + 2 * k, 0], K[8 + 2 * k, 1] = cb - ct, -ct
        right[7 + 2 * k], right[8 + 2 * k] = cb * w1 - ct * both, sb_ * w1 - st * both
    K[7, 2], K[8, 2] = -ss * cg, -ss * sg
    right[7] += ss * sg * -(v[2] ** 2)
    right[8] += ss * cg * v[2] ** 2
    K[9, 3], K[9, 4], K[10, 3], K[10, 4] = -cp, -cp + sd_, -sp, -sp - cd
    right[9] += -sp * w2 - cd * v[4] ** 2
    right[10] += cp * w2 - sd_ * v[4] ** 2
    K[11, 5], K[11, 6], K[12, 5], K[12, 6] = so, so - ce, -co, -co - se
    right[11] += -co * w3 - se * v[6] ** 2
    right[12] += -so * w3 + ce * v[6] ** 2
    K[:7, 7:] = K[7:, :7].T
    found = np.linalg.solve(K, right)
    return np.concatenate((v, found[:7]))


# Runs and their errors


def by_flexmb(mechanism: fm.Mechanism, t_end: float, value: Callable[[fm.Solution], np.ndarray], **how) -> Callable:
    """Time and value of a run of flexmb; the value of a run that failed is not a number."""

    def run() -> Timed:
        with mock.patch("time.perf_counter", time.process_time):
            sol = fm.simulate(mechanism, t_end=t_end, save=1, **how)
        return sol.stats.wall_time, value(sol) if sol.ok else np.array([math.nan])

    return run


def by_scipy(rates, y0: np.ndarray, t_end: float, value, rtol: float) -> Callable[[], Timed]:
    """Time and value of scipy's DOP853."""

    def run() -> Timed:
        began = time.process_time()
        y = solve_ivp(rates, (0.0, t_end), y0, method="DOP853", rtol=rtol, atol=rtol).y[:, -1]
        return time.process_time() - began, value(y)

    return run


def by_hand(y0: np.ndarray, t_end: float, steps: int) -> Callable[[], Timed]:
    """Time and tip of the chain by the hand-written loop."""

    def run() -> Timed:
        began = time.process_time()
        y = runge_kutta(y0, t_end, steps)
        return time.process_time() - began, tip(y[: len(y) // 2])

    return run


def runs(name: str) -> tuple[np.ndarray, dict[str, list[Callable[[], Timed]]]]:
    """Reference and all runs of a model."""
    t_end = SPANS[name]
    if name == "Andrews":
        mechanism, y0 = A.andrews(), np.concatenate([A.START, np.zeros(7)])
        exact, rates, value = np.array(A.PUBLISHED), andrews_rates, lambda y: y[:7]
        signal = lambda sol: A.andrews_angles(sol)[:, -1]  # noqa: E731
    else:
        count = links(name)
        mechanism, y0, rates = chain(count), np.zeros(2 * count), chain_rates
        value = lambda y: tip(y[:count])  # noqa: E731
        exact = value(solve_ivp(rates, (0.0, t_end), y0, method="DOP853", rtol=1e-12, atol=1e-12).y[:, -1])
        signal = lambda sol: tip(np.array([sol.array(f"link{k}.theta")[-1] for k in range(count)]))  # noqa: E731
    found = {
        "flexmb, DormandPrince": [
            by_flexmb(mechanism, t_end, signal, method=fm.DormandPrince(), step=fm.Adaptive(rtol=r, max=t_end / FEWEST))
            for r in RTOL
        ],
        "flexmb, RungeKutta4": [
            by_flexmb(mechanism, t_end, signal, method=fm.RungeKutta4(), step=t_end / n) for n in STEPS
        ],
        "DOP853, hand-written": [by_scipy(rates, y0, t_end, value, r) for r in RTOL if r <= 1e-2],
    }
    if name != "Andrews":
        found["hand-written RK4"] = [by_hand(y0, t_end, n) for n in STEPS]
        if mujoco is not None and links(name) <= 100:
            found["MuJoCo, RK4"] = [by_mujoco(links(name), t_end, n) for n in STEPS]
    return exact, found


def measured(names: list[str]) -> dict:
    """Times and errors of all runs, in turns of one run of each; slow ones once."""
    curves = {}
    for name in names:
        exact, found = runs(name)
        curves[name] = {}
        for code, every in found.items():
            every[0]()  # compile
            points = []
            for run in every:
                times, value = [], None
                for _ in range(REPEATS):
                    took, value = run()
                    times.append(took)
                    if took > 1.0:
                        break
                points.append((min(times), float(np.abs(value - exact).max())))
                least = min(error for cell, error in CELLS if cell == name)
                if points[-1][1] <= 0.1 * least:
                    break
            curves[name][code] = points
            print(name, code, *(f"{1e3 * t:.3g} ms {e:.1e};" for t, e in points), flush=True)
    record = {"name": "smooth", "curves": curves, "mujoco": getattr(mujoco, "__version__", "not installed")}
    record["table"] = table(record)
    keep("smooth", record)
    return record


def table(record: dict) -> list[str]:
    """The table of docs/performance.md."""
    codes = list(dict.fromkeys(code for curves in record["curves"].values() for code in curves))
    lines = [f"| model | error | {' | '.join(codes)} |", f"|---|---|{'---:|' * len(codes)}"]
    for name, limit in CELLS:
        if name not in record["curves"]:
            continue
        cells = []
        for code in codes:
            times = [t for t, error in record["curves"][name].get(code, []) if error <= limit]
            cells.append(f"{1e3 * min(times):.3g}" if times else "-")
        lines.append(f"| {name} | {limit:g} | {' | '.join(cells)} |")
    return lines


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--quick", action="store_true")
    wanted = ["chain of 10", "Andrews"] if parser.parse_args().quick else list(SPANS)
    if mujoco is None:
        print("MuJoCo is not installed (pip install mujoco): its column is left out.")
    print("\n".join(table(measured(wanted))))
