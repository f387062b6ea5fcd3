"""Checks of constraints, of joint friction, and of the motions that drive constraints."""

from dataclasses import replace

import numpy as np

from flexmb.kernels import JOINT_FRICTION_SIZE
from flexmb.model.contributions import ConstraintContribution, JointFriction
from flexmb.model.law import Motion
from flexmb.program.structure import zeros_of_constraints
from flexmb.testing.bench import Bench, State, TestedKernel
from flexmb.testing.contacts import check_friction
from flexmb.testing.elements import check_zeros


def check_constraint(bench: Bench, contribution: ConstraintContribution) -> None:
    """Compare G, g_t and H with differences, and gamma with the rate of G v + g_t on the constraint manifold."""
    n, m = len(contribution.coordinates), contribution.rows
    shapes = {"g": (m,), "G": (m, n), "g_t": (m,), "gamma": (m,), "H": (n, n)}
    tested = TestedKernel(bench.owner, contribution.kernel, contribution.p, **shapes)
    scale = bench.scales(contribution.coordinates)
    length = float(scale.max())
    for state in bench.states(contribution.coordinates, "t q v"):
        full = {**state, "lam": 100.0 * bench.random.uniform(-1.0, 1.0, m)}
        out = tested.checked_call(full)
        bench.note(f"{contribution.kernel.name}: compiled = Python, finite, repeatable")
        for name, zeros in zip("GH", zeros_of_constraints([replace(contribution, joint_friction=None)]), strict=True):
            check_zeros(bench, tested, name, zeros, full, out)

        def value(x: np.ndarray, full: State = full) -> np.ndarray:
            return tested({**full, "q": x})["g"]

        def value_in_time(t: float, full: State = full) -> np.ndarray:
            return tested({**full, "t": t})["g"]

        def force(x: np.ndarray, full: State = full) -> np.ndarray:
            return np.asarray(tested({**full, "q": x})["G"].T @ full["lam"])

        floor = 1e-6 * length
        bench.derivative(tested, "G = dg/dq", full, out["G"], value, full["q"], scale, columns=scale, floor=floor)
        bench.derivative(tested, "g_t = dg/dt", full, out["g_t"], value_in_time, full["t"], 0.1, floor=length)
        floor = 1e-6 * float(np.abs(scale * (out["G"].T @ full["lam"])).max())
        sizes = {"rows": scale, "columns": scale, "floor": floor}
        bench.derivative(tested, "H = d(G^T lam)/dq", full, out["H"], force, full["q"], scale, **sizes)
        check_gamma(bench, tested, full if contribution.motions else on_manifold(tested, full), scale)


def check_gamma(bench: Bench, tested: TestedKernel, state: State, scale: np.ndarray) -> None:
    """Compare gamma with the negative rate of G v + g_t at constant v: G a = gamma holds if d(G v + g_t)/dt = 0."""
    v = state["v"]

    def rate(s: float) -> np.ndarray:
        out = tested({**state, "q": state["q"] + s * v, "t": state["t"] + s})
        return np.asarray(-(out["G"] @ v + out["g_t"]))

    floor = 1e-4 * float(np.abs(v).max())
    gamma = tested(state)["gamma"]
    bench.derivative(tested, "gamma = -d(G v + g_t)/dt", state, gamma, rate, 0.0, 0.05, floor=floor)


def on_manifold(tested: TestedKernel, state: State) -> State:
    """The state projected onto g = 0 and G v + g_t = 0, for which gamma is defined."""
    state = dict(state)
    for _ in range(30):
        out = tested(state)
        state["q"] = state["q"] - np.linalg.lstsq(out["G"], out["g"], rcond=None)[0]
    out = tested(state)
    rest = out["G"] @ state["v"] + out["g_t"]
    state["v"] = state["v"] - np.linalg.lstsq(out["G"], rest, rcond=None)[0]
    return state


def check_motion(bench: Bench, motion: Motion) -> None:
    """Compare s_dot and s_ddot with differences that end at the breaks of the motion."""
    tested = TestedKernel(f"{bench.owner}, {type(motion).__name__}", motion.kernel, motion.parameters())
    span = motion.period or 2.0
    breaks = np.array(motion.breaks(2.0 * span))
    check_breaks(bench, motion, tested, breaks, 2.0 * span)
    for t in (0.0, *bench.random.uniform(0.0, 2.0 * span, 23)):
        state = {"t": float(t)}
        out = tested.checked_call(state)
        bench.note(f"{motion.kernel.name}: compiled = Python, finite, repeatable")
        step = min(0.1 * span, 0.9 * float(np.abs(breaks - t).min(initial=np.inf)))
        if t == 0.0 or step == 0.0:
            continue  # a start from rest may have a kink here
        for output, of in (("s_dot", "s"), ("s_ddot", "s_dot")):

            def value(x: float, of: str = of) -> float:
                return float(tested({"t": x})[of])

            floor = 1e-6 * abs(float(out[of])) / span
            bench.derivative(tested, f"{output} = d({of})/dt", state, out[output], value, t, step, floor=floor)


def check_breaks(bench: Bench, motion: Motion, tested: TestedKernel, breaks: np.ndarray, t_end: float) -> None:
    """Check the declared breaks [s]: instants up to `t_end` [s], and no jump of value and rate in a smooth motion."""
    for t in breaks:
        state = {"t": float(t)}
        if not 0.0 < t <= t_end:
            raise tested.fault(f"breaks({t_end:g}) gives {t:g}; its instants must lie after 0 and up to t_end", state)
        before, after = tested({"t": np.nextafter(t, 0.0)}), tested.checked_call(state)
        for name in ("s", "s_dot"):
            jump, size = abs(float(after[name] - before[name])), abs(float(after[name])) + 1.0
            if motion.is_smooth and jump > 1e-9 * size:
                text = f"{name} jumps by {jump:.3g}; such a motion must say is_smooth = False, and can drive no joint"
                raise tested.fault(text, state)
        bench.note(f"{motion.kernel.name}: breaks")


def check_joint_friction(bench: Bench, contribution: ConstraintContribution, joint_friction: JointFriction) -> None:
    """Check the normal load, its derivatives by the multipliers, the direction of sliding J, and the friction law."""
    tested = TestedKernel(bench.owner, joint_friction.kernel, joint_friction.p, out=(JOINT_FRICTION_SIZE,), H=(6, 6))
    nodes, m = contribution.coordinates[:6], contribution.rows
    scale = bench.scales(nodes)
    for state in bench.states(nodes, "q"):
        lam = 100.0 * bench.random.uniform(-1.0, 1.0, m)
        full = {**state, "lam": lam}
        out = tested.checked_call(full)
        bench.note(f"{joint_friction.kernel.name}: compiled = Python, finite, repeatable")
        if out["out"][0] < 0.0 and out["out"][1 : 1 + m].any():
            raise tested.fault(f"the normal load is {out['out'][0]:.9g}; it must be >= 0", full)

        def load(x: np.ndarray, full: State = full) -> np.ndarray:
            return tested({**full, "lam": x})["out"][:1]

        def direction(x: np.ndarray, full: State = full) -> np.ndarray:
            return tested({**full, "q": x})["out"][4:10]

        def load_there(x: np.ndarray, full: State = full) -> np.ndarray:
            return tested({**full, "q": x})["out"][:1]

        J, q = out["out"][4:10], full["q"]
        size = np.abs(lam)
        bench.derivative(tested, "dN/dlam", full, out["out"][1 : 1 + m][None, :], load, lam, size, columns=size)
        bench.derivative(tested, "dN/dq", full, out["out"][None, 10:], load_there, q, scale, columns=scale)
        floor = 1e-6 * float(np.abs(scale * J).max())
        bench.derivative(
            tested, "H = dJ/dq", full, out["H"], direction, q, scale, rows=scale, columns=scale, floor=floor
        )
        rule = "what slides on one body must slide back on the other"
        for axis in (0, 1):
            bench.balanced(tested, f"forces along {'xy'[axis]}", full, [J[axis], J[3 + axis]], rule)
        moments = [J[2], J[5], q[0] * J[1], -q[1] * J[0], q[3] * J[4], -q[4] * J[3]]
        bench.balanced(tested, "moments about the origin", full, moments, rule)
    check_friction(bench, joint_friction.friction)
