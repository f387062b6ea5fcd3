"""Checks of contacts and of constraints: gap kernel, normal and friction law, joint friction, motions that drive."""

from dataclasses import replace
from typing import Any

import numpy as np

from flexmb import places as at
from flexmb.kernels import GAP_SIZE, JOINT_FRICTION_SIZE
from flexmb.model.contributions import ConstraintContribution, ContactContribution, JointFriction
from flexmb.model.law import FrictionLaw, Law, Motion
from flexmb.program.structure import zeros_of_constraints
from flexmb.testing.bench import Bench, State, TestedKernel, check_zeros, gradient

STEPS = (0.0, 1e-5, 1e-3)  # time steps h [s] of the states
ROUNDS = 12  # number of states for each time step
ROUND_OFF = 1e-12  # gap of the reference configuration over the size of the pair below which the surfaces touch


def check_contact(bench: Bench, contribution: ContactContribution) -> None:
    """Check gap kernel, normal law and friction law of a contact."""
    size = check_gap(bench, contribution)
    # Check a normal law in free flight, at the onset and in lasting contact, at gaps of `size` [m]
    tested = law_kernel(bench, contribution.normal)
    for h in STEPS * ROUNDS:
        z = np.array(contribution.normal.history(), dtype=float)
        open_gap, speed = size * log_uniform(bench, 1e-2, 1.0), -log_uniform(bench, 1e-3, 10.0)
        first = {"h": 1e-4, "gap": open_gap, "gap_rate": speed, "z": z}
        check_normal_at(bench, tested, first)
        z = tested(first)["z_new"]
        gap, span = -size * log_uniform(bench, 1e-3, 1.0), h
        if h > 0.0:  # a step that leads from the open gap to this depth
            span = (open_gap - gap) / -speed * bench.random.uniform(0.8, 1.2)
        for _ in range(3):
            state = {"h": span, "gap": gap, "gap_rate": speed * bench.random.uniform(-0.5, 1.0), "z": z}
            check_normal_at(bench, tested, state)
            z = tested(state)["z_new"]
            gap, span = gap * bench.random.uniform(0.5, 1.5), h
    check_friction(bench, contribution.friction)


def check_gap(bench: Bench, contribution: ContactContribution) -> float:
    """Check a gap kernel with open and closed gaps; returns the size of the gap in the reference configuration [m]."""
    tested = TestedKernel(bench.owner, contribution.gap, contribution.p, out=(GAP_SIZE,))
    q = bench.pose[bench.number.dofs(contribution.coordinates)]
    scale = bench.scales(contribution.coordinates)
    size = abs(float(tested.checked_call({"q": q, "v": np.zeros(6)})["out"][at.GAP]))
    if size <= ROUND_OFF * float(scale.max()):  # surfaces that touch
        size = 1e-3 * float(scale.max())
    # gaps near the reference configuration, then larger motions as for other pieces
    distances = np.array([*(size * f for f in (0.1, 0.5, 0.9, 1.1, 1.5, 3.0)), 1e-3 * scale[0], 0.1 * scale[0]])
    for distance in np.repeat(distances, 3).tolist():
        angle = bench.random.uniform(-np.pi, np.pi)
        moved = q + 1e-4 * min(1.0, size / scale[0]) * scale * bench.random.uniform(-1.0, 1.0, 6)
        moved[3:5] += distance * np.array([np.cos(angle), np.sin(angle)])
        turn, shift = bench.rotation(0.0)  # the pair in any orientation
        state = {"q": turn @ moved + shift, "v": scale * bench.random.uniform(-10.0, 10.0, 6)}
        check_gap_at(bench, tested, state, scale, min(size, float(distance)), contribution.period)
    return size


def check_gap_at(
    bench: Bench, tested: TestedKernel, state: State, scale: np.ndarray, size: float, period: float = 0.0
) -> None:
    """Check derivatives, point and frame at a state; `size` of the gap [m], which may jump by `period` [m]."""
    out = tested.checked_call(state)["out"]
    where = "contact" if out[at.GAP] < 0.0 else "free flight"
    bench.note(f"{tested.kernel.name}: compiled = Python, finite, repeatable, in {where}")
    step = np.where(scale == 1.0, 1.0, size)  # lengths of the size of the gap, angles of 1 rad at most
    step[[2, 5]] = min(1.0, size / float(scale.max()))
    q, v, (normal, tangent) = state["q"], state["v"], rows(out)
    places = [at.GAP, at.NORMAL_X, at.NORMAL_X + 1, at.ARM1_X, at.ARM1_X + 1, at.ARM2_X, at.ARM2_X + 1]
    slopes, doubts = gradient(tested.of(state, "out", "q", places), q, step)
    gap, found = tested.of(state, "out", "q", slice(at.GAP, at.GAP_RATE)), (slopes[:1], doubts[:1])
    bench.derivative(tested, "J_n = d(gap)/dq", state, normal[None, :], gap, q, step, found=found, columns=step)
    arms = ("first_arm", at.ARM1_X, at.ARM1_X_Q), ("second_arm", at.ARM2_X, at.ARM2_X_Q)
    for k, (name, begin, begin_of_derivatives) in enumerate((("normal", at.NORMAL_X, at.NORMAL_X_Q), *arms)):
        found = slopes[[2 * k + 1, 2 * k + 2]], doubts[[2 * k + 1, 2 * k + 2]]
        derivatives = out[begin_of_derivatives : begin_of_derivatives + 12].reshape(2, 6)
        floor = 1e-6 * float(np.abs(out[begin : begin + 2]).max())
        entries, formula = tested.of(state, "out", "q", slice(begin, begin + 2)), f"{name} = its derivatives by q"
        bench.derivative(tested, formula, state, derivatives, entries, q, step, floor=floor, found=found, columns=step)
    pairs = ("gap rate and J_n v", out[at.GAP_RATE], normal), ("slip and J_t v", out[at.SLIP], tangent)
    for name, value, row in pairs:
        bench.balanced(tested, name, state, [value, *(-row * v)], "they must be equal")
    rule = "both arms must end in one point, or the forces have a moment"
    for axis in (0, 1):  # one contact point for both bodies, so that forces have the same moment
        terms = [q[axis], out[at.ARM1_X + axis], -q[3 + axis], -out[at.ARM2_X + axis]]
        bench.balanced(tested, f"contact points along {'xy'[axis]}", state, terms, rule)
    check_frame(bench, tested, state, out, scale, period)


def rows(out: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """J_n and J_t from normal and arms: gap rate and slip by the velocities of the nodes."""
    n = out[at.NORMAL_X : at.ARM1_X]
    t = np.array([-n[1], n[0]])

    def row(direction: np.ndarray) -> np.ndarray:
        moments = [direction[1] * out[k] - direction[0] * out[k + 1] for k in (at.ARM1_X, at.ARM2_X)]
        return np.array([*direction, moments[0], *-direction, -moments[1]])

    return row(n), -row(t)


def check_frame(
    bench: Bench, tested: TestedKernel, state: State, out: np.ndarray, scale: np.ndarray, period: float = 0.0
) -> None:
    """Check that gap, rate and slip are free of the frame, that normal and arms turn; gaps may jump by `period` [m]."""
    turn, shift = bench.rotation(float(scale.max()))
    moved = {"q": turn @ state["q"] + shift, "v": turn @ state["v"]}
    after = tested(moved)["out"]
    after[at.GAP] -= period * round((after[at.GAP] - out[at.GAP]) / period) if period else 0.0
    gap = max(abs(float(out[at.GAP])), float(np.hypot(*out[at.ECCENTRICITY_X : at.ECCENTRICITY_RATE_X])))
    length = float(np.abs(moved["q"][[0, 1, 3, 4]]).max() + np.abs(out[at.ARM1_X : at.ECCENTRICITY_X]).max())
    speed = float(np.abs(state["v"]).max()) * max(1.0, float(scale.max()))
    blur = length / max(gap, 1e-300)  # round-off of the normal over round-off of positions
    bench.turned(tested, "gap", state, after[at.GAP : at.GAP_RATE], out[at.GAP : at.GAP_RATE], length)
    rates, others = after[at.GAP_RATE : at.NORMAL_X], out[at.GAP_RATE : at.NORMAL_X]
    bench.turned(tested, "gap_rate and slip", state, rates, others, speed * max(blur, 1.0))
    normal, before = after[at.NORMAL_X : at.ARM1_X], turn[:2, :2] @ out[at.NORMAL_X : at.ARM1_X]
    bench.turned(tested, "normal", state, normal, before, max(blur, 1.0))
    for name, k in (("first arm", at.ARM1_X), ("second arm", at.ARM2_X)):
        bench.turned(tested, name, state, after[k : k + 2], turn[:2, :2] @ out[k : k + 2], length * max(blur, 1.0))


def check_normal_at(bench: Bench, tested: TestedKernel, state: State) -> None:
    """Check derivatives and sign of a normal law at one state."""
    out = tested.checked_call(state)
    N = float(out["N"])
    bench.note(f"{tested.kernel.name}: compiled = Python, finite, repeatable, {'open' if N == 0.0 else 'closed'}")
    if N < 0.0:
        raise tested.fault(f"N is {N:.9g}; a contact pushes, so it must be >= 0", state)
    for output, name in (("dN_dgap", "gap"), ("dN_drate", "gap_rate")):
        step, value = abs(state[name]), tested.of(state, "N", name)
        floor = 1e-4 * N / step
        bench.derivative(tested, f"{output} = dN/d({name})", state, out[output], value, state[name], step, floor=floor)


def check_friction(bench: Bench, law: FrictionLaw) -> None:
    """Check a friction law at slow and fast slip, with histories of earlier slip."""
    tested = law_kernel(bench, law)
    for h in STEPS * ROUNDS:
        z = np.array(law.history(), dtype=float)
        slip = log_uniform(bench, 1e-6, 1.0) * bench.random.choice([-1.0, 1.0])
        for _ in range(2):
            state: dict[str, Any] = {"h": h, "slip": slip, "N": log_uniform(bench, 1e-2, 1e4), "z": z}
            out = tested.checked_call(state)
            bench.note(f"{tested.kernel.name}: compiled = Python, finite, repeatable")
            for output, name in (("dT_dslip", "slip"), ("dT_dN", "N")):
                step = abs(state[name])
                floor, value = 1e-4 * abs(float(out["T"])) / step, tested.of(state, "T", name)
                formula = f"{output} = dT/d({name})"
                bench.derivative(tested, formula, state, out[output], value, state[name], step, floor=floor)
            tested.checked_call({**state, "N": 0.0})
            tested.checked_call({**state, "slip": 0.0})
            z = out["z_new"]
            slip *= bench.random.uniform(-2.0, 2.0)


def law_kernel(bench: Bench, law: Law) -> TestedKernel:
    """Kernel of a law, to be tested."""
    owner = f"{bench.owner}, {type(law).__name__}"
    return TestedKernel(owner, law.kernel, law.parameters(), z_new=(len(law.history()),))


def log_uniform(bench: Bench, low: float, high: float) -> float:
    """A random number, log-uniform between `low` and `high`."""
    return float(np.exp(bench.random.uniform(np.log(low), np.log(high))))


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

        def force(x: np.ndarray, full: State = full) -> np.ndarray:
            return np.asarray(tested({**full, "q": x})["G"].T @ full["lam"])

        floor, value, in_time = 1e-6 * length, tested.of(full, "g", "q"), tested.of(full, "g", "t")
        bench.derivative(tested, "G = dg/dq", full, out["G"], value, full["q"], scale, columns=scale, floor=floor)
        bench.derivative(tested, "g_t = dg/dt", full, out["g_t"], in_time, full["t"], 0.1, floor=length)
        floor = 1e-6 * float(np.abs(scale * (out["G"].T @ full["lam"])).max())
        sizes = {"rows": scale, "columns": scale, "floor": floor}
        bench.derivative(tested, "H = d(G^T lam)/dq", full, out["H"], force, full["q"], scale, **sizes)
        # G a = gamma holds if d(G v + g_t)/dt = 0: gamma is the negative rate of G v + g_t at constant v.
        moving = full if contribution.motions else on_manifold(tested, full)

        def rate(s: float, at: State = moving) -> np.ndarray:
            out = tested({**at, "q": at["q"] + s * at["v"], "t": at["t"] + s})
            return np.asarray(-(out["G"] @ at["v"] + out["g_t"]))

        gamma, floor = tested(moving)["gamma"], 1e-4 * float(np.abs(moving["v"]).max())
        bench.derivative(tested, "gamma = -d(G v + g_t)/dt", moving, gamma, rate, 0.0, 0.05, floor=floor)


def on_manifold(tested: TestedKernel, state: State) -> State:
    """The state projected onto g = 0 and G v + g_t = 0, for which gamma is defined."""
    state = dict(state)
    for _ in range(30):
        out = tested(state)
        state["q"] = state["q"] - np.linalg.lstsq(out["G"], out["g"], rcond=None)[0]
    out = tested(state)
    state["v"] = state["v"] - np.linalg.lstsq(out["G"], out["G"] @ state["v"] + out["g_t"], rcond=None)[0]
    return state


def check_motion(bench: Bench, motion: Motion) -> None:
    """Compare s_dot and s_ddot with differences that end at the breaks of the motion."""
    tested = TestedKernel(f"{bench.owner}, {type(motion).__name__}", motion.kernel, motion.parameters())
    span = motion.period or 2.0
    breaks = np.array(motion.breaks(2.0 * span))
    # Check the declared breaks [s]: instants up to `t_end` [s], and no jump of value and rate in a smooth motion
    t_end = 2.0 * span
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
    for t in (0.0, *bench.random.uniform(0.0, 2.0 * span, 23)):
        state = {"t": float(t)}
        out = tested.checked_call(state)
        bench.note(f"{motion.kernel.name}: compiled = Python, finite, repeatable")
        step = min(0.1 * span, 0.9 * float(np.abs(breaks - t).min(initial=np.inf)))
        if t == 0.0 or step == 0.0:
            continue  # a start from rest may have a kink here
        for output, of in (("s_dot", "s"), ("s_ddot", "s_dot")):
            floor, value = 1e-6 * abs(float(out[of])) / span, tested.of(state, of, "t")
            bench.derivative(tested, f"{output} = d({of})/dt", state, out[output], value, t, step, floor=floor)


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
        J, q, size = out["out"][4:10], full["q"], np.abs(lam)
        load, load_there = (tested.of(full, "out", name, slice(1)) for name in ("lam", "q"))
        bench.derivative(tested, "dN/dlam", full, out["out"][1 : 1 + m][None, :], load, lam, size, columns=size)
        bench.derivative(tested, "dN/dq", full, out["out"][None, 10:], load_there, q, scale, columns=scale)
        sizes = {"rows": scale, "columns": scale, "floor": 1e-6 * float(np.abs(scale * J).max())}
        slide = tested.of(full, "out", "q", slice(4, 10))
        bench.derivative(tested, "H = dJ/dq", full, out["H"], slide, q, scale, **sizes)
        rule = "what slides on one body must slide back on the other"
        for axis in (0, 1):
            bench.balanced(tested, f"forces along {'xy'[axis]}", full, [J[axis], J[3 + axis]], rule)
        moments = [J[2], J[5], q[0] * J[1], -q[1] * J[0], q[3] * J[4], -q[4] * J[3]]
        bench.balanced(tested, "moments about the origin", full, moments, rule)
    check_friction(bench, joint_friction.friction)
