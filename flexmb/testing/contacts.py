"""Checks of contacts: gap kernel, normal law, friction law."""

from collections.abc import Callable
from typing import Any

import numpy as np

from flexmb.kernels import GAP_SIZE
from flexmb.model.contributions import ContactContribution
from flexmb.model.law import FrictionLaw, Law, NormalLaw
from flexmb.places import (
    ARM1_X,
    ARM1_X_Q,
    ARM2_X,
    ARM2_X_Q,
    ECCENTRICITY_RATE_X,
    ECCENTRICITY_X,
    GAP,
    GAP_RATE,
    NORMAL_X,
    NORMAL_X_Q,
    SLIP,
)
from flexmb.testing.bench import Bench, State, TestedKernel

STEPS = (0.0, 1e-5, 1e-3)  # time steps h [s] of the states
ROUNDS = 12  # number of states for each time step
ROUND_OFF = 1e-12  # gap of the reference configuration over the size of the pair below which the surfaces touch


def check_contact(bench: Bench, contribution: ContactContribution) -> None:
    """Check gap kernel, normal law and friction law of a contact."""
    size = check_gap(bench, contribution)
    check_normal(bench, contribution.normal, size)
    check_friction(bench, contribution.friction)


def check_gap(bench: Bench, contribution: ContactContribution) -> float:
    """Check a gap kernel with open and closed gaps; returns the size of the gap in the reference configuration [m]."""
    tested = TestedKernel(bench.owner, contribution.gap, contribution.p, out=(GAP_SIZE,))
    q = bench.pose[bench.number.dofs(contribution.coordinates)]
    scale = bench.scales(contribution.coordinates)
    reference = tested.checked_call({"q": q, "v": np.zeros(6)})["out"]
    size = abs(float(reference[GAP]))
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
    where = "contact" if out[GAP] < 0.0 else "free flight"
    bench.note(f"{tested.kernel.name}: compiled = Python, finite, repeatable, in {where}")
    step = np.where(scale == 1.0, 1.0, size)  # lengths of the size of the gap, angles of 1 rad at most
    step[[2, 5]] = min(1.0, size / float(scale.max()))
    q, v = state["q"], state["v"]
    normal, tangent = rows(out)

    def entries(begin: int, end: int) -> Callable[[np.ndarray], np.ndarray]:
        return lambda x: tested({**state, "q": x})["out"][begin:end]

    units = {"columns": step}
    bench.derivative(tested, "J_n = d(gap)/dq", state, normal[None, :], entries(GAP, GAP_RATE), q, step, **units)
    blocks = (("normal", NORMAL_X, NORMAL_X_Q), ("first_arm", ARM1_X, ARM1_X_Q), ("second_arm", ARM2_X, ARM2_X_Q))
    for name, begin, begin_of_derivatives in blocks:
        derivatives = out[begin_of_derivatives : begin_of_derivatives + 12].reshape(2, 6)
        floor = 1e-6 * float(np.abs(out[begin : begin + 2]).max())
        bench.derivative(
            tested, f"{name} = its derivatives by q", state, derivatives, entries(begin, begin + 2), q, step,
            floor=floor, **units,
        )  # fmt: skip
    for name, value, row in (("gap rate and J_n v", out[GAP_RATE], normal), ("slip and J_t v", out[SLIP], tangent)):
        bench.balanced(tested, name, state, [value, *(-row * v)], "they must be equal")
    rule = "both arms must end in one point, or the forces have a moment"
    for axis in (0, 1):  # one contact point for both bodies, so that forces have the same moment
        terms = [q[axis], out[ARM1_X + axis], -q[3 + axis], -out[ARM2_X + axis]]
        bench.balanced(tested, f"contact points along {'xy'[axis]}", state, terms, rule)
    check_frame(bench, tested, state, out, scale, period)


def rows(out: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """J_n and J_t from normal and arms: gap rate and slip by the velocities of the nodes."""
    n = out[NORMAL_X:ARM1_X]
    t = np.array([-n[1], n[0]])

    def row(direction: np.ndarray) -> np.ndarray:
        moments = [direction[1] * out[k] - direction[0] * out[k + 1] for k in (ARM1_X, ARM2_X)]
        return np.array([*direction, moments[0], *-direction, -moments[1]])

    return row(n), -row(t)


def check_frame(
    bench: Bench, tested: TestedKernel, state: State, out: np.ndarray, scale: np.ndarray, period: float = 0.0
) -> None:
    """Check that gap, rate and slip are free of the frame, that normal and arms turn; gaps may jump by `period` [m]."""
    turn, shift = bench.rotation(float(scale.max()))
    moved = {"q": turn @ state["q"] + shift, "v": turn @ state["v"]}
    after = tested(moved)["out"]
    after[GAP] -= period * round((after[GAP] - out[GAP]) / period) if period else 0.0
    gap = max(abs(float(out[GAP])), float(np.hypot(*out[ECCENTRICITY_X:ECCENTRICITY_RATE_X])))
    length = float(np.abs(moved["q"][[0, 1, 3, 4]]).max() + np.abs(out[ARM1_X:ECCENTRICITY_X]).max())
    speed = float(np.abs(state["v"]).max()) * max(1.0, float(scale.max()))
    blur = length / max(gap, 1e-300)  # round-off of the normal over round-off of positions
    bench.turned(tested, "gap", state, after[GAP:GAP_RATE], out[GAP:GAP_RATE], length)
    rates, others = after[GAP_RATE:NORMAL_X], out[GAP_RATE:NORMAL_X]
    bench.turned(tested, "gap_rate and slip", state, rates, others, speed * max(blur, 1.0))
    bench.turned(tested, "normal", state, after[NORMAL_X:ARM1_X], turn[:2, :2] @ out[NORMAL_X:ARM1_X], max(blur, 1.0))
    for name, k in (("first arm", ARM1_X), ("second arm", ARM2_X)):
        bench.turned(tested, name, state, after[k : k + 2], turn[:2, :2] @ out[k : k + 2], length * max(blur, 1.0))


def check_normal(bench: Bench, law: NormalLaw, size: float) -> None:
    """Check a normal law in free flight, at the onset and in lasting contact, at gaps of `size` [m]."""
    tested = law_kernel(bench, law)
    for h in STEPS * ROUNDS:
        z = np.array(law.history(), dtype=float)
        open_gap, speed = size * log_uniform(bench, 1e-2, 1.0), -log_uniform(bench, 1e-3, 10.0)
        first = {"h": 1e-4, "gap": open_gap, "gap_rate": speed, "z": z}
        check_normal_at(bench, tested, first)
        z = tested(first)["z_new"]
        gap, span = -size * log_uniform(bench, 1e-3, 1.0), h
        if h > 0.0:  # a step that leads from the open gap to this depth
            span = (open_gap - gap) / -speed * bench.random.uniform(0.8, 1.2)
        for _ in range(3):
            rate = speed * bench.random.uniform(-0.5, 1.0)
            state = {"h": span, "gap": gap, "gap_rate": rate, "z": z}
            check_normal_at(bench, tested, state)
            z = tested(state)["z_new"]
            gap, span = gap * bench.random.uniform(0.5, 1.5), h


def check_normal_at(bench: Bench, tested: TestedKernel, state: State) -> None:
    """Check derivatives and sign of a normal law at one state."""
    out = tested.checked_call(state)
    N = float(out["N"])
    bench.note(f"{tested.kernel.name}: compiled = Python, finite, repeatable, {'open' if N == 0.0 else 'closed'}")
    if N < 0.0:
        raise tested.fault(f"N is {N:.9g}; a contact pushes, so it must be >= 0", state)
    for output, name in (("dN_dgap", "gap"), ("dN_drate", "gap_rate")):
        step, value = abs(state[name]), of(tested, state, "N", name)
        formula = f"{output} = dN/d({name})"
        floor = 1e-4 * N / step
        bench.derivative(tested, formula, state, out[output], value, state[name], step, floor=floor)


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
                floor = 1e-4 * abs(float(out["T"])) / step
                value = of(tested, state, "T", name)
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


def of(tested: TestedKernel, state: State, output: str, name: str) -> Callable[[float], float]:
    """Output of a kernel as a function of one input."""
    return lambda x: float(tested({**state, name: x})[output])


def log_uniform(bench: Bench, low: float, high: float) -> float:
    """A random number, log-uniform between `low` and `high`."""
    return float(np.exp(bench.random.uniform(np.log(low), np.log(high))))
