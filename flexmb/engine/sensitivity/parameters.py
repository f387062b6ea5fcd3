"""Effect of parameters and of controllers on the equations of a step; sampled controllers at their instants.

A parameter moves the packed numbers p along its direction dp.  The kernels of the pieces that it moves are called with
p plus and minus a small part of dp, and what they give is differenced.  A normal force is differenced through the gap
and by its law, so that no difference crosses the onset of a contact.

A controller that acts at all times makes its outputs, the factors of loads, and the rates of its states functions of
coordinates and velocities; both are linearised once a step.  A sampled controller keeps its outputs between instants:
their differences are histories, which change at its instants alone.

Equations (14.2), (14.3), (14.10) and (14.11) of docs/theory/design.md.
"""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from flexmb.engine.compiled.arrays import part_of
from flexmb.engine.compiled.records import Integers, IntegerTable, Matrix, Record, Vector
from flexmb.engine.sensitivity.histories import OF_GAP, OF_RATE, OF_SLIP, element_force
from flexmb.engine.system import elements
from flexmb.engine.system.constraints import add_joint_friction, call_constraint
from flexmb.engine.system.contacts import call_friction, call_gap, call_normal, jacobians
from flexmb.engine.system.elements import LEAST_SIZE, RELATIVE_DIFFERENCE
from flexmb.engine.system.work import gather
from flexmb.kernels import compiled, copy
from flexmb.places import FRICTION_FORCE, GAP, GAP_RATE, NORMAL, NORMAL_FORCE, SLIP, TANGENTIAL
from flexmb.program import program as at
from flexmb.program.program import Program, Sampler, Tables
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
    for e in np.flatnonzero(factor < at.NO_FACTOR):
        element[at.FIRST_OUTPUT - factor[e]] = e
    pos, size = np.cumsum([0, *sizes]).astype(np.int64), (len(element), program.tables.sizes.most_dofs)
    total = int(pos[-1])
    return ControlSlopes(by_q=total, by_v=total, pos=pos, element=element.astype(np.int64), force=size, mass=0.0)


@compiled
def find_control_slopes(tables, address, t, q, v, a, z, ka, T, work):
    """Set work.output and the slopes of all controllers; keep the differences of sampled ones in T.z1."""
    C, S = tables.controls, T.control
    S.mass = ka
    elements.evaluate_controls(tables, address, t, q, v, a, z, 0.0, 0.0, 0.0, False, work)
    for by_velocity in range(2):
        found = S.by_q if by_velocity == 0 else S.by_v
        for c in range(C.kernel.shape[0]):
            if C.z[c, at.END] > C.z[c, at.BEGIN]:
                continue
            elements.read_inputs(tables, address, c, t, q, v, work)
            elements.differentiate_law(tables, address, c, t, q, v, 1.0 - by_velocity, 1.0 * by_velocity, work)
            for i in range(S.pos[c + 1] - S.pos[c]):
                found[S.pos[c] + i] = work.law_tangent[i]
    for c in range(C.kernel.shape[0]):
        for j in range(T.z.shape[0]):
            for i in range(C.z[c, at.BEGIN], C.z[c, at.END]):
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
            for i in range(C.z[c, at.BEGIN], C.z[c, at.END]):
                far = max(far, abs(T.z[j, i]) / max(abs(z[i]), LEAST_SIZE))
        for side in range(2 if far > 0.0 else 0):
            e = RELATIVE_DIFFERENCE / far if side == 0 else -RELATIVE_DIFFERENCE / far
            for c in range(C.kernel.shape[0]):
                for i in range(C.z[c, at.BEGIN], C.z[c, at.END]):
                    T.zs[i] = z[i] + e * T.z[j, i]
            add_control_change(tables, tables, address, t, q, v, a, T.zs, 0.5 / e, j, T, work)
    copy(z, T.zs)
    elements.evaluate_controls(tables, address, t, q, v, a, z, 0.0, 0.0, 0.0, False, work)


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
        for i in range(elements.threes(C.states[c]) if C.dof[c + 1] > C.dof[c] else 0):
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
        for i in range(elements.threes(n_x) if n > 0 else 0):
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
    elements.evaluate_controls(varied, address, t, q, v, a, z, 0.0, 0.0, 0.0, False, work)
    for c in range(C.kernel.shape[0]):
        for i in range(C.states[c] if C.dof[c + 1] > C.dof[c] else 0):
            dof = C.dofs[C.dof[c] + i]
            T.F[j, dof] -= factor * work.r[dof]
        for output in range(C.output[c], C.output[c + 1]):
            subtract_load(tables, output, factor * work.output[output], T.F[j], T)


# Weights and samplers of neighbouring mechanisms, whose weighted sum is a derivative by a parameter.
Moved = Sequence[tuple[float, tuple[Sampler, ...]]]


def act_differences(
    program: Program, instant: float, y: np.ndarray, z: np.ndarray, dy: np.ndarray, dz: np.ndarray, sizes: np.ndarray,
    moved: Sequence[Moved], *, every: bool,
) -> np.ndarray:  # fmt: skip
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


# Kinds of pieces in `ParameterRates.pieces`; all controllers are one piece.
ELEMENT, CONSTRAINT, CONTACT, CONTROLLERS = range(4)
KIND, NUMBER = range(2)  # columns of `ParameterRates.pieces`


class ParameterRates(Record):
    """Directions of k parameters in the packed numbers, and their effect on the equations at a given state."""

    varied: Tables  # tables whose numbers are moved
    step: Vector  # (k,) largest difference of each parameter
    # number, rate: numbers that a parameter moves, and their derivatives; first : (k + 1,) where those of each begin
    number: Integers
    rate: Vector
    first: Integers
    # (n, 2) KIND and NUMBER of the pieces that a parameter moves; piece : (k + 1,) where those of each begin
    pieces: IntegerTable
    piece: Integers
    g: Matrix  # g, gv: (k, n_c) derivatives of g and of G v + g_t
    gv: Matrix
    contact: Matrix  # (3 k, contacts) derivatives of gap, gap rate and slip; rows OF_GAP to OF_SLIP of each parameter


def parameter_rates(program: Program, directions: np.ndarray, step: np.ndarray) -> ParameterRates:
    """Rates for the derivatives of all numbers p by k parameters, `directions` (k, n_p); step : (k,) as there."""
    k, n_c, tables = len(directions), program.n_c, program.tables
    moved = [np.flatnonzero(row) for row in directions]
    pieces = [list(_pieces(tables, set(places.tolist()))) for places in moved]
    listed = [piece for own in pieces for piece in own]
    return ParameterRates(
        varied=tables.replaced(p=np.array(tables.p)), step=step,
        number=np.concatenate([*moved, np.zeros(0)]).astype(np.int64),
        rate=np.concatenate([*(row[own] for row, own in zip(directions, moved, strict=True)), np.zeros(0)]),
        first=np.cumsum([0, *map(len, moved)]).astype(np.int64), pieces=np.array(listed, dtype=np.int64).reshape(-1, 2),
        piece=np.cumsum([0, *map(len, pieces)]).astype(np.int64), g=(k, n_c), gv=(k, n_c),
        contact=(3 * k, len(tables.contacts.kernel)),
    )  # fmt: skip


def _pieces(tables: Tables, places: set[int]) -> Iterator[tuple[int, int]]:
    """Elements, constraints, contacts and controllers that read one of the numbers at `places`."""
    E, C, K, laws = tables.elements, tables.constraints, tables.contacts, tables.controls
    bounds: list[tuple[int, int, tuple[Any, ...]]] = []
    bounds += [(ELEMENT, e, pair) for e, pair in enumerate(zip(E.p, E.factor_p, strict=True))]
    for c, own in enumerate(C.p):
        rubbing = C.joint_friction_p[c]
        bounds.append((CONSTRAINT, c, (own, *C.motion_p[C.row[c] : C.row[c + 1]], rubbing[:2], rubbing[2:])))
    bounds += [(CONTACT, c, (own[:2], own[2:4], own[4:])) for c, own in enumerate(K.p)]
    bounds.append((CONTROLLERS, 0, (*laws.p, *laws.source[:, at.SOURCE_P : at.SOURCE_P_END + 1])))
    for kind, number, lists in bounds:
        if any(place in places for begin, end in lists for place in range(begin, end)):
            yield kind, number


@compiled
def move_numbers(tables, by, j, eps):
    """Move the numbers of by.varied by eps along parameter j."""
    for i in range(by.first[j], by.first[j + 1]):
        k = by.number[i]
        by.varied.p[k] = tables.p[k] + eps * by.rate[i]


@compiled
def add_parameters(tables, address, t, h, q, v, a, lam, z, T, work):
    """Add the effect of all parameters to T.F, T.z1, T.N and T.T; set g, gv and contact of T.by."""
    # `add_contacts` and `add_constraints` have been called at the same state.
    by = T.by
    by.g[:, :] = by.gv[:, :] = by.contact[:, :] = 0.0
    for j in range(by.step.shape[0]):
        if by.piece[j + 1] == by.piece[j]:
            continue
        for side in range(2):
            eps = by.step[j] if side == 0 else -by.step[j]
            move_numbers(tables, by, j, eps)
            for k in range(by.piece[j], by.piece[j + 1]):
                kind, number = by.pieces[k, KIND], by.pieces[k, NUMBER]
                if kind == ELEMENT:
                    _add_element(by.varied, address, number, t, h, q, v, a, z, 0.5 / eps, j, T, work)
                elif kind == CONSTRAINT:
                    _add_constraint(by.varied, address, number, t, h, q, v, lam, z, 0.5 / eps, j, T, work)
                elif kind == CONTROLLERS:
                    add_control_change(tables, by.varied, address, t, q, v, a, z, 0.5 / eps, j, T, work)
                    elements.evaluate_controls(tables, address, t, q, v, a, z, 0.0, 0.0, 0.0, False, work)
                else:
                    _add_contact(by.varied, address, number, h, q, v, z, 0.5 / eps, j, T, work)
        move_numbers(tables, by, j, 0.0)
        for k in range(by.piece[j], by.piece[j + 1]):  # what later functions read of the joint
            if by.pieces[k, KIND] == CONSTRAINT:
                _add_constraint(tables, address, by.pieces[k, NUMBER], t, h, q, v, lam, z, 0.0, j, T, work)


@compiled
def _add_element(varied, address, e, t, h, q, v, a, z, factor, j, T, work):
    """Add factor times force and history of element e."""
    E = varied.elements
    n = E.dof[e + 1] - E.dof[e]
    elements.gather_state(E, e, n, q, v, a, work)
    element_force(varied, address, e, n, t, h, z, work)
    s = factor * elements.load_factor(varied, address, e, t, work)
    for i in range(n):
        T.F[j, E.dofs[E.dof[e] + i]] -= s * work.rl[i]
    for l in range(E.z[e, at.BEGIN], E.z[e, at.END]):
        T.z1[j, l] += factor * work.z_new[l]


@compiled
def clear_constraint(C, c, n, work):
    """Zeros in the arrays to which the kernel of constraint c adds."""
    for i in range(n * n):
        work.Kl[i] = 0.0
    for i in range(C.pos_g[c], C.pos_g[c + 1]):
        work.G[i] = 0.0
    for row in range(C.row[c], C.row[c + 1]):
        work.g[row], work.gv[row], work.gamma[row] = 0.0, 0.0, 0.0


@compiled
def _add_constraint(varied, address, c, t, h, q, v, lam, z, factor, j, T, work):
    """Add factor times residual, its rate and force of constraint c, and friction in the joint."""
    C, by = varied.constraints, T.by
    n, m, begin = C.dof[c + 1] - C.dof[c], C.row[c + 1] - C.row[c], C.dof[c]
    gather(q, C.dofs, begin, n, work.ql)
    gather(v, C.dofs, begin, n, work.vl)
    clear_constraint(C, c, n, work)
    call_constraint(varied, address, c, n, m, t, lam, work)
    for i in range(m):
        row, place = C.row[c] + i, C.pos_g[c] + i * n
        rate = work.gv[row]
        for l in range(n):
            rate += work.G[place + l] * work.vl[l]
            T.F[j, C.dofs[begin + l]] -= factor * work.G[place + l] * lam[row]
        by.g[j, row] += factor * work.g[row]
        by.gv[j, row] += factor * rate
    if C.joint_friction[c, at.LOAD_KERNEL] < 0:
        return
    for i in range(6):
        work.r[C.dofs[begin + i]] = 0.0
    add_joint_friction(varied, address, c, n, m, h, lam, z, 0.0, 0.0, False, work)
    for i in range(6):
        T.F[j, C.dofs[begin + i]] -= factor * work.r[C.dofs[begin + i]]
    for l in range(C.joint_friction_z[c, at.BEGIN], C.joint_friction_z[c, at.END]):
        T.z1[j, l] += factor * work.z_new[l]


@compiled
def _add_contact(varied, address, c, h, q, v, z, factor, j, T, work):
    """Add factor times the forces of contact c at its present gap, then of their present sizes along its axes."""
    K, out, here, S = varied.contacts, work.contact[c], work.gap, work.contact_scratch
    begin, end = K.z[c, at.NORMAL_Z], K.z[c, at.Z_END]
    N, _, _ = call_normal(varied, address, c, h, out[GAP], out[GAP_RATE], z, work.z_new)
    T.N[j, c] += factor * N
    friction, _, _ = call_friction(varied, address, c, h, out[SLIP], out[NORMAL_FORCE], z, work.z_new)
    T.T[j, c] += factor * friction
    for l in range(begin, end):
        T.z1[j, l] += factor * work.z_new[l]
    gather(q, K.dofs, 6 * c, 6, work.ql)
    gather(v, K.dofs, 6 * c, 6, work.vl)
    call_gap(varied, address, c, work.ql, work.vl, False, None, here)
    by = T.by.contact
    by[3 * j + OF_GAP, c] += factor * here[GAP]
    by[3 * j + OF_RATE, c] += factor * here[GAP_RATE]
    by[3 * j + OF_SLIP, c] += factor * here[SLIP]
    jacobians(here, S)
    for i in range(6):
        force = out[NORMAL_FORCE] * S[NORMAL, i] + out[FRICTION_FORCE] * S[TANGENTIAL, i]
        T.F[j, K.dofs[6 * c + i]] += factor * force
