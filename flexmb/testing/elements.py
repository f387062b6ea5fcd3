"""Checks of elements: tangents, energies, balance, frame."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from flexmb.kernels import Kernel
from flexmb.model.contributions import Coordinate, ElementContribution
from flexmb.model.part import GROUND
from flexmb.testing.bench import TOLERANCE, Bench
from flexmb.testing.differences import ROUND_OFF
from flexmb.testing.tested_kernel import State, TestedKernel, Values

REACTION = "action must equal reaction; a load from outside on two bodies is one part for each of them"


def check_element(bench: Bench, contribution: ElementContribution, weightless: ElementContribution) -> None:
    """Check an element: tangents, energies, balance, dependence on the frame, other kernels.

    `weightless` is the same element without gravity.
    """
    n, m = len(contribution.coordinates), len(contribution.history)
    shapes = {"r": (n,), "K": (n, n), "C": (n, n), "M": (n, n), "z_new": (m,)}
    tested = TestedKernel(bench.owner, contribution.kernel, contribution.p, **shapes)
    bare = TestedKernel(bench.owner, weightless.kernel, weightless.p, **shapes)
    scale = bench.scales(contribution.coordinates)
    z = np.array(contribution.history, dtype=float)
    for state in bench.states(contribution.coordinates, "t h q v a"):
        full = {**state, "z": z}
        out = tested.checked_call(full)
        bench.note(f"{contribution.kernel.name}: compiled = Python, finite, repeatable")
        check_tangents(bench, tested, full, out, scale)
        check_other_kernels(bench, contribution, tested, full, out)
        if contribution.energy is not None and not m:
            check_energy(bench, contribution.energy, tested, full, out, scale)
        check_reaction(bench, contribution.coordinates, bare, full)
        check_frame(bench, contribution.coordinates, bare, full, scale)
        z = out["z_new"]


def check_other_kernels(
    bench: Bench, contribution: ElementContribution, tested: TestedKernel, state: State, out: Values
) -> None:
    """Compare force, tangent and energy-evaluation kernel with the element and energy kernels."""
    n, history = tested.shapes["r"], {"z_new": tested.shapes["z_new"]}
    weights = dict(zip(("kq", "kv", "ka"), bench.random.uniform(0.5, 2.0, 3).tolist(), strict=True))
    y = bench.random.uniform(-1.0, 1.0, n)
    matrix = sum(weight * out[name] for weight, name in zip(weights.values(), "KCM", strict=True))
    expected: dict[str, Any] = {"r": out["r"], "z_new": out["z_new"]}
    account = {**expected, "Mv": out["M"] @ state["v"], "My": out["M"] @ y}
    if contribution.account is not None and contribution.energy is not None:
        energy = TestedKernel(bench.owner, contribution.energy, contribution.p)
        account |= energy({name: state[name] for name in ("t", "q", "v")})
    sizes = round_off_sizes(tested, state, out)
    sizes |= {"Mv": float((np.abs(out["M"]) @ np.abs(state["v"])).max()), "My": float(np.abs(out["M"]).sum())}
    kernels: tuple[tuple[Kernel | None, dict[str, Any], dict[str, tuple[int, ...]], dict[str, Any]], ...] = (
        (contribution.force, {}, {}, expected),
        (contribution.tangent, weights, {"A": (*n, *n)}, {**expected, "A": matrix}),
        (contribution.account, {"y": y}, {"Mv": n, "My": n}, account),
    )
    for kernel, inputs, results, values in kernels:
        if kernel is not None:
            other = TestedKernel(bench.owner, kernel, contribution.p, r=n, **results, **history)
            other.same({**state, **inputs}, values, sizes, contribution.kernel.name)
            bench.note(f"{kernel.name}: as {contribution.kernel.name}")


def round_off_sizes(tested: TestedKernel, state: State, out: Values) -> dict[str, float]:
    """Magnitudes of forces and energies to which round-off is related: coordinates have a round-off of their own."""
    q, v = (float(np.abs(state[name]).max(initial=1.0)) for name in "qv")
    stiffness = float(np.abs(out["K"]).max())
    still = np.zeros_like(state["v"])
    rest = float(np.abs(tested({**state, "v": still, "a": still})["r"]).max())
    stored = (rest + 1e-16 * stiffness * q) * q
    moved = float(np.abs(out["r"]).max()) + stiffness * q
    return {"r": moved, "strain": stored, "gravity": stored, "damping": float(np.abs(out["C"]).sum()) * v * v}


def check_tangents(bench: Bench, tested: TestedKernel, state: State, out: Values, scale: np.ndarray) -> None:
    """Compare K, C and M with differences of r."""
    size = float(np.abs(out["r"] * scale).max())
    sizes = {"rows": scale, "columns": scale, "floor": TOLERANCE * size}
    for output, name in (("K", "q"), ("C", "v"), ("M", "a")):

        def force(x: np.ndarray, name: str = name) -> np.ndarray:
            return tested({**state, name: x})["r"]

        step, noise = scale, 0.0
        if name == "q":  # a force is a difference of terms as large as K q
            noise = ROUND_OFF * np.abs(out["K"]) @ np.abs(state["q"])
        else:  # rates at which C v or M a is as large as the other forces, so that round-off does not hide them
            strongest = float(np.abs(out[output] * np.outer(scale, scale)).max())
            step = scale * np.clip(size / strongest if strongest else 1.0, 1.0, 1e6)
        formula = f"{output} = dr/d{name}"
        bench.derivative(tested, formula, state, out[output], force, state[name], step, noise=noise, **sizes)


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
