"""Checks of controls: the law by itself, and the tangents of its loads and states in the mechanism."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmb.errors import KernelError
from flexmb.model.contributions import ControlContribution
from flexmb.program.program import Program
from flexmb.system.state_evaluation import StateEvaluation
from flexmb.testing.bench import Bench
from flexmb.testing.tested_kernel import TestedKernel

INPUT_SIZES = (0.0, 1e-3, 1.0, 30.0)
"""Sizes of random inputs and states of a law."""

POSE_SIZES, SPEED_SIZES = (0.01, 0.3, 1.0, 2.0), (0.0, 0.1, 3.0)
"""Sizes of random displacements, over the size of the mechanism and in rad, and of velocities per second."""

ROUNDS = 6
"""Number of states of each size of displacement and velocity."""

SETTLING = 5
"""Number of iterations that bring states of a control near rest, where the control is not saturated."""

SMALL = 1e-9
"""Slopes relative to the largest one, below which they are round-off."""

LAW_NOISE = 4e-3
"""Derivative relative to the forces, below which round-off of the differences of a law exceeds the tolerance: the
program finds tangents of laws by differences of its own, of at least 6e-7."""


def check_control(bench: Bench, contribution: ControlContribution) -> None:
    """Check calls of a control law with random inputs: compiled = Python, repeatable, inputs unchanged.

    Inputs at which the law is not finite are left out, since the mechanism may never have them.
    """
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
    """Compare the tangents of loads and states of a control with differences of the forces of the mechanism.

    A state of the mechanism at which the outputs depend on nothing (a saturated controller) tells nothing of tangents;
    so there must be others.  A sampled control has no tangents.
    """
    c, C = program.controls.index(contribution.part), program.tables.controls
    columns = np.asarray(C.dofs[C.dof[c] : C.dof[c + 1]]).astype(np.int64)
    if contribution.sample is not None or len(columns) == 0:
        return
    rows = np.array([*columns[: len(contribution.states)], *_loaded(program, contribution)], dtype=np.int64)
    tested, acting = tested_law(bench, contribution), 0
    for state in _states(bench, program, contribution, columns):
        system = StateEvaluation(program).at(state["q"], state["v"], state["a"], t=state["t"], weights=(0.7, 0.4, 0.0))
        slopes = system.work.slope[C.slope[C.output[c]] : C.slope[C.output[c + 1]]]
        if not np.any(slopes):
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
                t = float(bench.random.uniform(0.0, 2.0))
                _settle(StateEvaluation(program), q, v, t, own)
                v[own] += 1e-3 * np.abs(v[own]) * bench.random.uniform(-1.0, 1.0, len(own))
                yield {"t": t, "q": q, "v": v, "a": a}


def _settle(system: StateEvaluation, q: np.ndarray, v: np.ndarray, t: float, own: np.ndarray) -> None:
    """Bring the states of a control, the velocities `own`, near values at which their rates are 0, in place."""
    for _ in range(SETTLING if len(own) else 0):
        rates = system.at(q, v, t=t, weights=(0.0, 1.0, 0.0)).force[own]
        slope = system.dense[np.ix_(own, own)]
        v[own] -= np.linalg.lstsq(slope, rates, rcond=SMALL)[0]


def _loaded(program: Program, contribution: ControlContribution) -> list[int]:
    """Coordinates on which the loads of a control act."""
    E = program.tables.elements
    places = [program.names.elements.index(load) for load in contribution.loads]
    return [int(dof) for e in places for dof in E.dofs[E.dof[e] : E.dof[e + 1]] if dof < program.n_q]


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
            found: np.ndarray = system.at(moved["q"], moved["v"], moved["a"], t=state["t"]).force[rows]
            return found

        floor = LAW_NOISE * float(force.max(initial=0.0) / scale.min())
        bench.derivative(tested, formula, state, value, forces, state[name][columns], scale, floor=floor)
