"""Checks of constraints and of the motions that drive them."""

from __future__ import annotations

import numpy as np

from flexmb.model.contributions import ConstraintContribution
from flexmb.model.law import Motion
from flexmb.testing.bench import Bench
from flexmb.testing.subject import State, Subject


def check_constraint(bench: Bench, contribution: ConstraintContribution) -> None:
    """G, g_t, H against differences; gamma against the rate of G v + g_t, on the manifold."""
    n, m = len(contribution.coordinates), contribution.rows
    shapes = {"g": (m,), "G": (m, n), "g_t": (m,), "gamma": (m,), "H": (n, n)}
    subject = Subject(bench.owner, contribution.kernel, contribution.p, **shapes)
    scale = bench.scales(contribution.coordinates)
    length = float(scale.max())
    for state in bench.states(contribution.coordinates, "t q v"):
        full = {**state, "lam": 100.0 * bench.random.uniform(-1.0, 1.0, m)}
        out = subject.watched(full)
        bench.note(f"{contribution.kernel.name}: compiled = Python, finite, repeatable")

        def value(x: np.ndarray, full: State = full) -> np.ndarray:
            return subject({**full, "q": x})["g"]

        def value_in_time(t: float, full: State = full) -> np.ndarray:
            return subject({**full, "t": t})["g"]

        def force(x: np.ndarray, full: State = full) -> np.ndarray:
            return subject({**full, "q": x})["G"].T @ full["lam"]

        floor = 1e-6 * length
        bench.derivative(subject, "G = dg/dq", full, out["G"], value, full["q"], scale, columns=scale, floor=floor)
        bench.derivative(subject, "g_t = dg/dt", full, out["g_t"], value_in_time, full["t"], 0.1, floor=length)
        floor = 1e-6 * float(np.abs(scale * (out["G"].T @ full["lam"])).max())
        sizes = {"rows": scale, "columns": scale, "floor": floor}
        bench.derivative(subject, "H = d(G^T lam)/dq", full, out["H"], force, full["q"], scale, **sizes)
        check_gamma(bench, subject, full if contribution.motions else on_manifold(subject, full), scale)


def check_gamma(bench: Bench, subject: Subject, state: State, scale: np.ndarray) -> None:
    """G a = gamma where d(G v + g_t)/dt = 0: gamma is the negative rate of G v + g_t at constant v."""
    v = state["v"]

    def rate(s: float) -> np.ndarray:
        out = subject({**state, "q": state["q"] + s * v, "t": state["t"] + s})
        return -(out["G"] @ v + out["g_t"])

    floor = 1e-4 * float(np.abs(v).max())
    gamma = subject(state)["gamma"]
    bench.derivative(subject, "gamma = -d(G v + g_t)/dt", state, gamma, rate, 0.0, 0.05, floor=floor)


def on_manifold(subject: Subject, state: State) -> State:
    """The state with q and v moved so that g = 0 and G v + g_t = 0, where gamma is defined."""
    state = dict(state)
    for _ in range(30):
        out = subject(state)
        state["q"] = state["q"] - np.linalg.lstsq(out["G"], out["g"], rcond=None)[0]
    out = subject(state)
    rest = out["G"] @ state["v"] + out["g_t"]
    state["v"] = state["v"] - np.linalg.lstsq(out["G"], rest, rcond=None)[0]
    return state


def check_motion(bench: Bench, motion: Motion) -> None:
    """s_dot and s_ddot against differences, up to where the motion jumps; at a jump s is that of just after."""
    subject = Subject(f"{bench.owner}, {type(motion).__name__}", motion.kernel, motion.parameters())
    span = motion.period or 2.0
    breaks = np.array(motion.breaks(2.0 * span))
    check_breaks(bench, motion, subject, breaks, 2.0 * span)
    for t in (0.0, *bench.random.uniform(0.0, 2.0 * span, 23)):
        state = {"t": float(t)}
        out = subject.watched(state)
        bench.note(f"{motion.kernel.name}: compiled = Python, finite, repeatable")
        step = min(0.1 * span, 0.9 * float(np.abs(breaks - t).min(initial=np.inf)))
        if t == 0.0 or step == 0.0:
            continue  # a start from rest may have a kink here
        for output, of in (("s_dot", "s"), ("s_ddot", "s_dot")):

            def value(x: float, of: str = of) -> float:
                return float(subject({"t": x})[of])

            floor = 1e-6 * abs(float(out[of])) / span
            bench.derivative(subject, f"{output} = d({of})/dt", state, out[output], value, t, step, floor=floor)


def check_breaks(bench: Bench, motion: Motion, subject: Subject, breaks: np.ndarray, t_end: float) -> None:
    """The declared instants lie in the time asked for; a motion for drives keeps its value and rate there."""
    for t in breaks:
        state = {"t": float(t)}
        if not 0.0 < t <= t_end:
            raise subject.fault(f"breaks({t_end:g}) gives {t:g}; its instants must lie after 0 and up to t_end", state)
        before, after = subject({"t": np.nextafter(t, 0.0)}), subject.watched(state)
        for name in ("s", "s_dot"):
            jump, size = abs(float(after[name] - before[name])), abs(float(after[name])) + 1.0
            if motion.is_smooth and jump > 1e-9 * size:
                text = f"{name} jumps by {jump:.3g}; such a motion must say is_smooth = False, and can drive no joint"
                raise subject.fault(text, state)
        bench.note(f"{motion.kernel.name}: breaks")
