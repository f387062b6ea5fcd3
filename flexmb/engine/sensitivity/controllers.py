"""Controllers in the tangent of a step, and sampled controllers at their instants.

A controller that acts at all times makes its outputs, the factors of loads, and the rates of its states functions of
coordinates and velocities; both are linearised once a step.  A sampled controller keeps its outputs between instants:
their differences are histories, which change at its instants alone.

Equations (14.10) and (14.11) of docs/theory/design.md.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flexmb.engine.compiled.arrays import part_of
from flexmb.engine.compiled.records import Integers, Matrix, Record, Vector
from flexmb.engine.system.controls import (
    LEAST_SIZE,
    RELATIVE_DIFFERENCE,
    differentiate_law,
    evaluate_controls,
    read_inputs,
    threes,
)
from flexmb.kernels import compiled, copy
from flexmb.program.program import BEGIN, END, FIRST_OUTPUT, NO_FACTOR, Program, Sampler
from flexmb.run.sampling import act

# Difference of an input of a sampled law relative to its size, and least size relative to its largest so far.
PART_OF_INPUT, LEAST_PART = 1e-6, 1e-3


class ControlSlopes(Record):
    """Slopes of the laws of all controllers at the last linearised state."""

    # by_q, by_v: derivatives of rates and outputs by the coordinates of their controller and by their velocities
    by_q: Vector
    by_v: Vector
    pos: Integers  # (controls + 1,) where those of each controller begin
    element: Integers  # (outputs,) element whose load an output multiplies, -1: none
    force: Matrix  # (outputs, ..) its force without it
    mass: float  # ka, weight of the rates of states in the matrix of the step


def control_slopes(program: Program) -> ControlSlopes:
    """Slopes for the controllers of a program."""
    C, factor = program.tables.controls, np.asarray(program.tables.elements.factor)
    sizes = [(C.states[c] + C.output[c + 1] - C.output[c]) * (C.dof[c + 1] - C.dof[c]) for c in range(len(C.kernel))]
    element = np.full(len(C.owner), -1)
    for e in np.flatnonzero(factor < NO_FACTOR):
        element[FIRST_OUTPUT - factor[e]] = e
    total = int(sum(sizes))
    pos, size = np.cumsum([0, *sizes]).astype(np.int64), (len(element), program.tables.sizes.most_dofs)
    return ControlSlopes(by_q=total, by_v=total, pos=pos, element=element.astype(np.int64), force=size, mass=0.0)


@compiled
def find_control_slopes(tables, address, t, q, v, a, z, ka, T, work):
    """Set work.output and the slopes of all controllers; keep the differences of sampled ones in T.z1."""
    C, S = tables.controls, T.control
    S.mass = ka
    evaluate_controls(tables, address, t, q, v, a, z, 0.0, 0.0, 0.0, False, work)
    for by_velocity in range(2):
        found = S.by_q if by_velocity == 0 else S.by_v
        for c in range(C.kernel.shape[0]):
            if C.z[c, END] > C.z[c, BEGIN]:
                continue
            read_inputs(tables, address, c, t, q, v, work)
            differentiate_law(tables, address, c, t, q, v, 1.0 - by_velocity, 1.0 * by_velocity, work)
            for i in range(S.pos[c + 1] - S.pos[c]):
                found[S.pos[c] + i] = work.law_tangent[i]
    for c in range(C.kernel.shape[0]):
        for j in range(T.z.shape[0]):
            for i in range(C.z[c, BEGIN], C.z[c, END]):
                T.z1[j, i] += T.z[j, i]


@compiled
def add_control_forces(tables, address, t, q, v, a, z, T, work):
    """Add the effect of U by the slopes, of Y on the states, and of held outputs, to T.F."""
    C = tables.controls
    for j in range(T.F.shape[0]):
        subtract_control_rates(tables, T.control.by_q, 1.0, T.U[j], T.F[j], T)
        subtract_state_rates(tables, 1.0, T.Y[j], T.F[j])
        far = 0.0
        for c in range(C.kernel.shape[0]):
            for i in range(C.z[c, BEGIN], C.z[c, END]):
                far = max(far, abs(T.z[j, i]) / max(abs(z[i]), LEAST_SIZE))
        for side in range(2 if far > 0.0 else 0):
            e = RELATIVE_DIFFERENCE / far if side == 0 else -RELATIVE_DIFFERENCE / far
            for c in range(C.kernel.shape[0]):
                for i in range(C.z[c, BEGIN], C.z[c, END]):
                    T.zs[i] = z[i] + e * T.z[j, i]
            add_control_change(tables, tables, address, t, q, v, a, T.zs, 0.5 / e, j, T, work)
    copy(z, T.zs)
    evaluate_controls(tables, address, t, q, v, a, z, 0.0, 0.0, 0.0, False, work)


@compiled
def subtract_control_rates(tables, slopes, factor, x, F, T):
    """F -= factor times the change of all residuals by `slopes` for the motion x of the coordinates."""
    C = tables.controls
    for c in range(C.kernel.shape[0]):
        n, n_x, place = C.dof[c + 1] - C.dof[c], C.states[c], T.control.pos[c]
        for i in range((T.control.pos[c + 1] - place) // max(n, 1)):
            change = 0.0
            for l in range(n):
                change += slopes[place + i * n + l] * x[C.dofs[C.dof[c] + l]]
            if i < n_x:
                F[C.dofs[C.dof[c] + i]] += factor * change
            else:
                subtract_load(tables, C.output[c] + i - n_x, factor * change, F, T)


@compiled
def subtract_state_rates(tables, factor, x, F):
    """F -= factor times the motion x of the states, whose residual is rate less law."""
    C = tables.controls
    for c in range(C.kernel.shape[0]):
        for i in range(threes(C.states[c]) if C.dof[c + 1] > C.dof[c] else 0):
            dof = C.dofs[C.dof[c] + i]
            F[dof] -= factor * x[dof]


@compiled
def subtract_load(tables, output, change, F, T):
    """F -= force of the load of an output, times the change of the output."""
    e, E = T.control.element[output], tables.elements
    if e >= 0:
        for i in range(E.dof[e + 1] - E.dof[e]):
            F[E.dofs[E.dof[e] + i]] -= change * T.control.force[output, i]


@compiled
def add_control_matrix(tables, kv, T, work):
    """Add the derivatives of loads and of residuals of states to work.lu."""
    C, S, E = tables.controls, T.control, tables.elements
    for c in range(C.kernel.shape[0]):
        n, n_x, place = C.dof[c + 1] - C.dof[c], C.states[c], S.pos[c]
        rows = part_of(C.positions_state, C.pos_state[c], C.pos_state[c + 1])
        for i in range(threes(n_x) if n > 0 else 0):
            work.lu[rows[i * n + i]] += S.mass
            for l in range(n if i < n_x else 0):
                work.lu[rows[i * n + l]] -= S.by_q[place + i * n + l] + kv * S.by_v[place + i * n + l]
        for output in range(C.output[c], C.output[c + 1] if n > 0 else C.output[c]):
            e, own = S.element[output], place + (n_x + output - C.output[c]) * n
            for i in range(E.dof[e + 1] - E.dof[e] if e >= 0 else 0):
                for l in range(n):
                    slope = S.by_q[own + l] + kv * S.by_v[own + l]
                    work.lu[C.positions_load[C.pos_load[output] + i * n + l]] += S.force[output, i] * slope


@compiled
def add_control_change(tables, varied, address, t, q, v, a, z, factor, j, T, work):
    """Add factor times outputs and rates of states with the numbers of `varied` and histories z to T.F."""
    C = tables.controls
    evaluate_controls(varied, address, t, q, v, a, z, 0.0, 0.0, 0.0, False, work)
    for c in range(C.kernel.shape[0]):
        for i in range(C.states[c] if C.dof[c + 1] > C.dof[c] else 0):
            dof = C.dofs[C.dof[c] + i]
            T.F[j, dof] -= factor * work.r[dof]
        for output in range(C.output[c], C.output[c + 1]):
            subtract_load(tables, output, factor * work.output[output], T.F[j], T)


# Weights and samplers of neighbouring mechanisms, whose weighted sum is a derivative by a parameter.
Moved = Sequence[tuple[float, tuple[Sampler, ...]]]


def sampled_inputs(program: Program) -> np.ndarray:
    """Places of the signals that sampled controllers read."""
    places = [place for sampler in program.samplers for place in sampler.inputs if isinstance(place, int)]
    return np.unique(np.array(places, dtype=np.int64))


def act_differences(
    program: Program,
    instant: float,
    y: np.ndarray,
    z: np.ndarray,
    dy: np.ndarray,
    dz: np.ndarray,
    sizes: np.ndarray,
    moved: Sequence[Moved],
    *,
    every: bool,
) -> np.ndarray:
    """Differences (k, n_z) of the histories after the sampled controllers have acted; equation (14.11)."""

    # y, z: signals and histories just before;  dy, dz: their differences (k, n_y) and (k, n_z);  sizes: (n_y,) largest
    # size of each signal so far;  moved: of each parameter
    def after(samplers: tuple[Sampler, ...], e: float, j: int) -> np.ndarray:
        there: np.ndarray = z + e * dz[j]
        act(samplers, instant, y + e * dy[j], there, every=every)
        return there

    found = np.array(dz)
    own = np.concatenate([np.arange(s.z, s.z + s.states) for s in program.samplers])
    scale = np.concatenate([np.maximum(np.abs(y), LEAST_PART * sizes), np.abs(z[own])])
    for j in range(len(dz)):
        change = np.abs(np.concatenate([dy[j], dz[j, own]]))
        felt = (change > 0.0) & (scale > 0.0)
        e = PART_OF_INPUT * (float(np.min(scale[felt] / change[felt])) if felt.any() else 1.0)
        found[j] = (after(program.samplers, e, j) - after(program.samplers, -e, j)) / (2.0 * e)
        for weight, samplers in moved[j] if j < len(moved) else ():
            found[j] += weight * (after(samplers, 0.0, j) - z)
    return found
