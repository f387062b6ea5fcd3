"""Stiffnesses that floats cannot hold beside the loads or slow vibrations."""

from __future__ import annotations

import math

import numpy as np

from flexmb.doctor.finding import Finding, found
from flexmb.doctor.loads import typical_load
from flexmb.equilibrium.modes import Modes
from flexmb.model.mechanism import Mechanism
from flexmb.program.program import Program
from flexmb.system.state_evaluation import StateEvaluation

ROUND_OFF_OF_LOADS = 1e-3
"""Round-off of the stiffest part relative to the loads, above which there is a remark."""

ROUND_OFF = 1e-13
"""Round-off of a mode shape relative to its largest entry: what it strains may have no other reason."""

LARGEST_RATIO = 1e15
"""Ratio of stiffnesses over masses, of the fastest mode to the slowest, that floats can hold."""


def stiffness_findings(mechanism: Mechanism, program: Program, q: np.ndarray, bare: Modes | None) -> list[Finding]:
    """Findings on stiffnesses so large that their round-off is felt beside the loads or slow vibrations.

    The pose is q (n_q,); without loads there may be no modes `bare`.
    """
    n, kind = program.tables.sizes.n_b, np.asarray(program.tables.kind)
    stiffness = np.where(kind[:n] == 1, 0.0, _diagonal(program, q)[:n])
    worst = int(np.argmax(stiffness))
    body, largest = program.names.bodies[int(program.reference.body[worst])], float(stiffness[worst])
    lost = float(np.finfo(float).eps * largest * max(program.length, abs(q[worst])))
    load = typical_load(mechanism)
    remedy = "Make a stiff spring a joint, or a stiff beam a rigid body; stiffnesses are in N/m."
    if not math.isfinite(largest) or lost > ROUND_OFF_OF_LOADS * load > 0.0:
        text = f"At {body!r} a stiffness of {largest:.3g} N/m turns the round-off of its coordinates into {lost:.2g} N"
        text = f"{text}; all loads, weights and inertia together have some {load:.2g} N."
        return [found("stiffness-ratio", (body,), text, remedy, stiffness=largest, round_off=lost, load=load)]
    slow = resolved_modes(program, q, bare) if bare is not None else []
    if bare is None or not slow:
        return []
    slowest, fastest = float(np.abs(bare.eigenvalues[slow[0]])), math.sqrt(_fastest_square(program, q))
    if fastest**2 <= LARGEST_RATIO * slowest**2:
        return []
    text = f"The slowest vibration, mostly of {bare.moves[slow[0]]!r}, has {slowest / (2.0 * math.pi):.3g} Hz, and"
    text = f"{text} the stiffness at {body!r} some {fastest / (2.0 * math.pi):.3g} Hz: the ratio of their squares is"
    text = f"{text} beyond the 16 digits of floats."
    return [found("stiffness-ratio", (body,), text, remedy, slowest=slowest, fastest=fastest)]


def resolved_modes(program: Program, q: np.ndarray, bare: Modes) -> list[int]:
    """Numbers of the elastic modes at a pose (n_q,) with more energy than the round-off of their shapes."""
    sizes, stiffest = np.abs(bare.shapes).max(axis=0, initial=0.0), _diagonal(program, q).max()
    least = stiffest * (ROUND_OFF * sizes) ** 2
    energy = np.abs(bare.eigenvalues) ** 2
    return [k for k, kind in enumerate(bare.kinds) if kind == "elastic" and energy[k] > least[k]]


def _diagonal(program: Program, q: np.ndarray, *, mass: bool = False) -> np.ndarray:
    """Diagonal (n_q,) of the stiffness or the mass."""
    weights = (0.0, 0.0, 1.0) if mass else (1.0, 0.0, 0.0)
    diagonal: np.ndarray = np.abs(StateEvaluation(program).at(q, weights=weights).block().diagonal())
    return diagonal


def _fastest_square(program: Program, q: np.ndarray) -> float:
    """Largest ratio of a diagonal entry of the stiffness to that of the mass [1/s^2]."""
    n = program.tables.sizes.n_b
    K, M = _diagonal(program, q)[:n], _diagonal(program, q, mass=True)[:n]
    return float(np.max(K[M > 0.0] / M[M > 0.0], initial=0.0))
