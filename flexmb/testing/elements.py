"""Checks of elements and of controls: tangents, energies, balance, frame, laws."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from flexmb.engine.system.state_evaluation import StateEvaluation
from flexmb.errors import KernelError
from flexmb.kernels import Kernel
from flexmb.model.contributions import ControlContribution, Coordinate, ElementContribution
from flexmb.model.part import GROUND
from flexmb.program.program import Program
from flexmb.program.structure import zeros_of_elements
from flexmb.testing.bench import ROUND_OFF, TOLERANCE, Bench, State, TestedKernel, Values

REACTION = "action must equal reaction; a load from outside on two bodies is one part for each of them"


def check_element(bench: Bench, contribution: ElementContribution, weightless: ElementContribution) -> None:
    """Check an element (`weightless`: without gravity): tangents, energies, balance, frame, other kernels."""
    n, m = len(contribution.coordinates), len(contribution.history)
    shapes = {"r": (n,), "K": (n, n), "C": (n, n), "M": (n, n), "z_new": (m,)}
    tested = TestedKernel(bench.owner, contribution.kernel, contribution.p, **shapes)
    bare = TestedKernel(bench.owner, weightless.kernel, weightless.p, **shapes)
    scale, z = bench.scales(contribution.coordinates), np.array(contribution.history, dtype=float)
    for state in bench.states(contribution.coordinates, "t h q v a"):
        full = {**state, "z": z}
        out = tested.checked_call(full)
        bench.note(f"{contribution.kernel.name}: compiled = Python, finite, repeatable")
        for name in "KCM":
            check_zeros(bench, tested, name, zeros_of_elements([contribution]), full, out)
        if contribution.is_mass:
            mass, inertia, *g = contribution.p
            expected = np.array([mass, mass, inertia]) * (full["a"] - np.array([*g, 0.0]))
            if np.abs(out["r"] - expected).max() > TOLERANCE * np.abs(expected).max():
                raise tested.fault("r is not that of a mass at a node with p = (m, J, gx, gy); leave is_mass out", full)
        # Compare K, C and M with differences of r
        size = float(np.abs(out["r"] * scale).max())
        sizes = {"rows": scale, "columns": scale, "floor": TOLERANCE * size}
        for output, name in (("K", "q"), ("C", "v"), ("M", "a")):
            step, noise = scale, 0.0
            if name == "q":  # a force is a difference of terms as large as K q
                noise = ROUND_OFF * np.abs(out["K"]) @ np.abs(full["q"])
            else:  # rates at which C v or M a is as large as the other forces, so that round-off does not hide them
                strongest = float(np.abs(out[output] * np.outer(scale, scale)).max())
                step = scale * np.clip(size / strongest if strongest else 1.0, 1.0, 1e6)
            formula, force = f"{output} = dr/d{name}", tested.of(full, "r", name)
            bench.derivative(tested, formula, full, out[output], force, full[name], step, noise=noise, **sizes)
        check_other_kernels(bench, contribution, tested, full, out)
        if contribution.energy is not None and not m:
            check_energy(bench, contribution.energy, tested, full, out, scale)
        check_reaction(bench, contribution.coordinates, bare, full)
        check_frame(bench, contribution.coordinates, bare, full, scale)
        z = out["z_new"]


def check_zeros(bench: Bench, tested: TestedKernel, name: str, zeros: np.ndarray, state: State, out: Values) -> None:
    """Refuse entries that are not zero though a contribution declares them as zero."""
    if not zeros.any():
        return
    where = (out[name].ravel() != 0.0) & zeros
    if where.any():
        row, column = divmod(int(np.argmax(where)), out[name].shape[1])
        text = f"{name}[{row}, {column}] is {out[name][row, column]:.3g}, and the contribution says that it is always 0"
        raise tested.fault(f"{text}; name it in columns or curved, or leave diagonal out", state)
    bench.note(f"{tested.kernel.name}: {name} is 0 where that is declared")


def check_other_kernels(
    bench: Bench, contribution: ElementContribution, tested: TestedKernel, state: State, out: Values
) -> None:
    """Compare force, tangent, energy-evaluation and damping kernel with the element and energy kernels."""
    n, history = tested.shapes["r"], {"z_new": tested.shapes["z_new"]}
    weights = dict(zip(("kq", "kv", "ka"), bench.random.uniform(0.5, 2.0, 3).tolist(), strict=True))
    y = bench.random.uniform(-1.0, 1.0, n)
    matrix = sum(weight * out[name] for weight, name in zip(weights.values(), "KCM", strict=True))
    expected: dict[str, Any] = {"r": out["r"], "z_new": out["z_new"]}
    account = {**expected, "Mv": out["M"] @ state["v"], "My": out["M"] @ y}
    powers: dict[str, Any] = {}
    if contribution.energy is not None:
        energy = TestedKernel(bench.owner, contribution.energy, contribution.p)
        given = {name: state[name] for name in ("t", "q")}
        account |= energy({**given, "v": state["v"]})
        more, less = (energy({**given, "v": state["v"] + w})["damping"] for w in (y, -y))
        powers = {"power": account["damping"], "mixed_power": 0.25 * (more - less)}
    sizes = round_off_sizes(tested, state, out)
    sizes |= dict.fromkeys(powers, float(np.abs(out["C"]).sum()) * (1.0 + float(np.abs(state["v"]).max())) ** 2)
    sizes |= {"Mv": float((np.abs(out["M"]) @ np.abs(state["v"])).max()), "My": float(np.abs(out["M"]).sum())}
    tangent = (contribution.tangent, weights, {"A": (*n, *n)}, {**expected, "A": matrix})
    account_of = (contribution.account, {"y": y}, {"Mv": n, "My": n}, account)
    damping: Any = (contribution.damping, {"w": y}, {}, powers)
    kernels: Any = ((contribution.force, {}, {}, expected), tangent, account_of, damping)
    for kernel, inputs, results, values in kernels:
        if kernel is not None:
            other = TestedKernel(bench.owner, kernel, contribution.p, r=n, **results, **history)
            other.same({**state, **inputs}, values, sizes, contribution.kernel.name)
            bench.note(f"{kernel.name}: as {contribution.kernel.name}")


def round_off_sizes(tested: TestedKernel, state: State, out: Values) -> dict[str, float]:
    """Magnitudes of forces and energies to which round-off is related: coordinates have a round-off of their own."""
    q, v = (float(np.abs(state[name]).max(initial=1.0)) for name in "qv")
    stiffness, still = float(np.abs(out["K"]).max()), np.zeros_like(state["v"])
    rest = float(np.abs(tested({**state, "v": still, "a": still})["r"]).max())
    stored, moved = (rest + 1e-16 * stiffness * q) * q, float(np.abs(out["r"]).max()) + stiffness * q
    return {"r": moved, "strain": stored, "gravity": stored, "damping": float(np.abs(out["C"]).sum()) * v * v}


def check_energy(
    bench: Bench, kernel: Kernel, tested: TestedKernel, state: State, out: Values, scale: np.ndarray
) -> None:
    """Compare the force at rest with the potential, and the power of the forces with the rate of all energies."""
    energy = TestedKernel(bench.owner, kernel, tested.p)
    short = {name: state[name] for name in ("t", "q", "v")}
    damping = float(energy.checked_call(short, round_off_sizes(tested, state, out))["damping"])
    v, still = state["v"], np.zeros_like(state["v"])

    def potential(q: np.ndarray) -> float:
        energies = energy({**short, "q": q})
        return float(energies["strain"] + energies["gravity"])

    def stored(s: float) -> float:
        q = state["q"] + s * v
        return potential(q) + 0.5 * float(v @ tested({**state, "q": q})["M"] @ v)

    # both potentials, and the stiffness times the round-off of coordinates, limit what differences can find
    terms = energy(short)
    floor = 1e-3 * float(abs(terms["strain"]) + abs(terms["gravity"]))
    floor = max(floor, 1e-8 * float(np.abs(out["K"] * np.outer(scale, scale)).max(initial=0.0)))
    force = tested({**state, "v": still, "a": still})["r"]
    sizes = {"columns": scale, "floor": floor}
    bench.derivative(energy, "force = dV/dq", state, force[None, :], potential, state["q"], scale, **sizes)
    if np.any(v):
        r = tested({**state, "a": still})["r"]
        floor = max(floor, float(np.abs(v * r).sum()))
        rate = float(v @ r) - damping
        bench.derivative(energy, "power = d(T + V)/dt + damping", state, rate, stored, 0.0, 0.1, floor=floor)


def check_reaction(bench: Bench, coordinates: Sequence[Coordinate], tested: TestedKernel, state: State) -> None:
    """Check that forces and moments between two moving bodies balance, by an element without gravity and inertia."""
    parts = {part for part, _, _ in coordinates}
    if len(parts) != 2 or GROUND.name in parts:
        return
    state = {**state, "a": np.zeros_like(state["a"])}
    if np.any(tested(state)["M"]):
        state["v"] = np.zeros_like(state["v"])
    nodes: dict[tuple[str, str], dict[int, int]] = {}
    for i, (part, node, axis) in enumerate(coordinates):
        nodes.setdefault((part, node), {})[axis] = i
    r, q = tested(state)["r"], state["q"]
    for axis in (0, 1):
        terms = [r[axes[axis]] for axes in nodes.values() if axis in axes]
        bench.balanced(tested, f"forces along {'xy'[axis]}", state, terms, REACTION)
    if any((0 in axes) != (1 in axes) for axes in nodes.values()):
        return  # the place of a force must be known for its moment
    terms = [r[axes[2]] for axes in nodes.values() if 2 in axes]
    for axes in nodes.values():
        if 0 in axes:
            terms += [q[axes[0]] * r[axes[1]], -q[axes[1]] * r[axes[0]]]
    bench.balanced(tested, "moments about the origin", state, terms, REACTION)


def check_frame(
    bench: Bench, coordinates: Sequence[Coordinate], tested: TestedKernel, state: State, scale: np.ndarray
) -> None:
    """Check that the forces of an element with two nodes turn with the frame, without gravity."""
    if [axis for _, _, axis in coordinates] != [0, 1, 2, 0, 1, 2]:
        return
    turn, shift = bench.rotation(scale[0])
    moved = {**state, "q": turn @ state["q"] + shift, "v": turn @ state["v"], "a": turn @ state["a"]}
    before, after = tested(state), tested(moved)
    # a force is a difference of terms as large as K q
    stiffness = float(np.abs(before["K"] * np.outer(scale, scale)).max())
    size = stiffness * float(np.abs(moved["q"] / scale).max()) + float(np.abs(before["r"] * scale).max())
    bench.turned(tested, "r", state, after["r"] * scale, (turn @ before["r"]) * scale, size)


INPUT_SIZES = (0.0, 1e-3, 1.0, 30.0)  # sizes of random inputs and states of a law
# Sizes of random displacements, over the size of the mechanism and in rad, and of velocities per second.
POSE_SIZES, SPEED_SIZES = (0.01, 0.3, 1.0, 2.0), (0.0, 0.1, 3.0)
ROUNDS = 6  # number of states of each size of displacement and velocity
SETTLING = 5  # number of iterations that bring states of a control near rest, where the control is not saturated
SMALL = 1e-9  # slopes relative to the largest one, below which they are round-off
# Derivative relative to the forces, below which round-off of the differences of a law exceeds the tolerance: the
# program finds tangents of laws by differences of its own, of at least 6e-7.
LAW_NOISE = 4e-3


def check_control(bench: Bench, contribution: ControlContribution) -> None:
    """Check calls of a control law with random inputs: compiled = Python, repeatable, inputs unchanged."""
    # Inputs at which the law is not finite are left out, since the mechanism may never have them.
    tested = tested_law(bench, contribution)
    name, finite = f"{contribution.kernel.name}: compiled = Python, repeatable, inputs unchanged", 0
    for size in INPUT_SIZES * ROUNDS:
        u = size * bench.random.uniform(-1.0, 1.0, len(contribution.inputs))
        x = np.array(contribution.start) + size * bench.random.uniform(-1.0, 1.0, len(contribution.states))
        state: dict[str, Any] = {"t": float(bench.random.uniform(0.0, 2.0)), "u": u, "x": x}
        with np.errstate(all="ignore"):
            values = tested(state)
        if all(np.isfinite(value).all() for value in values.values()):
            finite += 1
            tested.checked_call(state)
            bench.note(name)
    if not finite:
        raise tested.fault("its rates dx or outputs y are finite for none of the inputs that were tried", state)


def tested_law(bench: Bench, contribution: ControlContribution) -> TestedKernel:
    """The law of a control under test."""
    sizes = {"dx": (len(contribution.states),), "y": (len(contribution.outputs),)}
    return TestedKernel(bench.owner, contribution.kernel, contribution.p, **sizes)


def check_control_tangents(bench: Bench, program: Program, contribution: ControlContribution) -> None:
    """Compare the tangents of loads and states of a control with differences of the forces of the mechanism."""
    # A state of the mechanism at which the outputs depend on nothing (a saturated controller) tells nothing of
    # tangents; so there must be others. A sampled control has no tangents.
    c, C = program.controls.index(contribution.part), program.tables.controls
    columns = np.asarray(C.dofs[C.dof[c] : C.dof[c + 1]]).astype(np.int64)
    if contribution.sample is not None or len(columns) == 0:
        return
    E = program.tables.elements
    loads = [program.names.elements.index(load) for load in contribution.loads]
    loaded = [int(dof) for e in loads for dof in E.dofs[E.dof[e] : E.dof[e + 1]] if dof < program.n_q]
    rows = np.array([*columns[: len(contribution.states)], *loaded], dtype=np.int64)
    tested, acting = tested_law(bench, contribution), 0
    for state in _states(bench, program, contribution, columns):
        system = StateEvaluation(program).at(state["q"], state["v"], state["a"], t=state["t"], weights=(0.7, 0.4, 0.0))
        if not np.any(system.work.slope[C.slope[C.output[c]] : C.slope[C.output[c + 1]]]):
            continue
        acting += 1
        _compare(bench, tested, program, state, rows, columns)
    if not acting:
        text = "its outputs depend on no input and no state at any state that was tried (a saturated controller, or a"
        text += " law that switches), so that its tangents are not tested"
        raise KernelError(f"{tested.label}: {text}; check it with wider limits, or give a switching law sample=.")


def _states(bench: Bench, program: Program, contribution: ControlContribution, columns: np.ndarray) -> Any:
    """Random states of the mechanism, with states of the control near rest."""
    n_b, n = program.tables.sizes.n_b, program.n_q
    scale = np.where(np.asarray(program.tables.kind[:n_b]) == 1, 1.0, program.length)
    own = columns[: len(contribution.states)]
    for pose in POSE_SIZES:
        for speed in SPEED_SIZES:
            for _ in range(ROUNDS):
                q, v, a = np.array(program.reference.q), np.zeros(n), np.zeros(n)
                q[:n_b] += pose * scale * bench.random.uniform(-1.0, 1.0, n_b)
                v[:n_b] = speed * scale * bench.random.uniform(-1.0, 1.0, n_b)
                t, system = float(bench.random.uniform(0.0, 2.0)), StateEvaluation(program)
                for _ in range(SETTLING if len(own) else 0):
                    rates = system.at(q, v, t=t, weights=(0.0, 1.0, 0.0)).force[own]
                    v[own] -= np.linalg.lstsq(system.dense[np.ix_(own, own)], rates, rcond=SMALL)[0]
                v[own] += 1e-3 * np.abs(v[own]) * bench.random.uniform(-1.0, 1.0, len(own))
                yield {"t": t, "q": q, "v": v, "a": a}


def _compare(
    bench: Bench, tested: TestedKernel, program: Program, state: dict[str, Any], rows: np.ndarray, columns: np.ndarray
) -> None:
    """Compare the rows of the matrix, by the coordinates of a control and their velocities, with differences."""
    system = StateEvaluation(program)
    scale = np.where(np.asarray(program.tables.kind)[columns] == 1, 1.0, program.length)
    force = np.abs(system.at(state["q"], state["v"], state["a"], t=state["t"]).force[rows])
    for name, weights, formula in (("q", (1.0, 0.0, 0.0), "K = dr/dq"), ("v", (0.0, 1.0, 0.0), "C = dr/dv")):
        matrix = system.at(state["q"], state["v"], state["a"], t=state["t"], weights=weights).dense
        value = matrix[np.ix_(rows, columns)]

        def forces(x: np.ndarray, name: str = name) -> np.ndarray:
            moved = {**state, name: state[name].copy()}
            moved[name][columns] = x
            return np.asarray(system.at(moved["q"], moved["v"], moved["a"], t=state["t"]).force[rows])

        floor = LAW_NOISE * float(force.max(initial=0.0) / scale.min())
        bench.derivative(tested, formula, state, value, forces, state[name][columns], scale, floor=floor)
