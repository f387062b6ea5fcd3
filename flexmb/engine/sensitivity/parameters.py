"""Effect of parameters on the equations of a step: on forces, constraints, gaps and histories at a given state.

A parameter moves the packed numbers p along its direction dp.  The kernels of the pieces that it moves are called with
p plus and minus a small part of dp, and what they give is differenced.  A normal force is differenced through the gap
and by its law, so that no difference crosses the onset of a contact.

Equations (14.2) and (14.3) of docs/theory/design.md.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from flexmb.engine.compiled.records import Integers, IntegerTable, Matrix, Record, Vector
from flexmb.engine.sensitivity.controllers import add_control_change
from flexmb.engine.sensitivity.histories import OF_GAP, OF_RATE, OF_SLIP, element_force
from flexmb.engine.system.constraints import add_joint_friction, call_constraint
from flexmb.engine.system.contacts import call_friction, call_gap, call_normal, jacobians
from flexmb.engine.system.controls import evaluate_controls
from flexmb.engine.system.elements import gather_state, load_factor
from flexmb.engine.system.work import gather
from flexmb.kernels import compiled
from flexmb.places import FRICTION_FORCE, GAP, GAP_RATE, NORMAL, NORMAL_FORCE, SLIP, TANGENTIAL
from flexmb.program.program import BEGIN, END, LOAD_KERNEL, NORMAL_Z, SOURCE_P, SOURCE_P_END, Z_END, Program, Tables

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
        varied=tables.replaced(p=np.array(tables.p)),
        step=step,
        number=np.concatenate([*moved, np.zeros(0)]).astype(np.int64),
        rate=np.concatenate([*(row[own] for row, own in zip(directions, moved, strict=True)), np.zeros(0)]),
        first=np.cumsum([0, *map(len, moved)]).astype(np.int64),
        pieces=np.array(listed, dtype=np.int64).reshape(-1, 2),
        piece=np.cumsum([0, *map(len, pieces)]).astype(np.int64),
        g=(k, n_c),
        gv=(k, n_c),
        contact=(3 * k, len(tables.contacts.kernel)),
    )


def _pieces(tables: Tables, places: set[int]) -> Iterator[tuple[int, int]]:
    """Elements, constraints, contacts and controllers that read one of the numbers at `places`."""
    E, C, K, laws = tables.elements, tables.constraints, tables.contacts, tables.controls
    bounds: list[tuple[int, int, tuple[Any, ...]]] = [
        (ELEMENT, e, (own, factor)) for e, (own, factor) in enumerate(zip(E.p, E.factor_p, strict=True))
    ]
    for c, own in enumerate(C.p):
        rubbing = C.joint_friction_p[c]
        bounds.append((CONSTRAINT, c, (own, *C.motion_p[C.row[c] : C.row[c + 1]], rubbing[:2], rubbing[2:])))
    bounds += [(CONTACT, c, (own[:2], own[2:4], own[4:])) for c, own in enumerate(K.p)]
    bounds.append((CONTROLLERS, 0, (*laws.p, *laws.source[:, SOURCE_P : SOURCE_P_END + 1])))
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
    by.g[:, :] = 0.0
    by.gv[:, :] = 0.0
    by.contact[:, :] = 0.0
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
                    evaluate_controls(tables, address, t, q, v, a, z, 0.0, 0.0, 0.0, False, work)
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
    gather_state(E, e, n, q, v, a, work)
    element_force(varied, address, e, n, t, h, z, work)
    s = factor * load_factor(varied, address, e, t, work)
    for i in range(n):
        T.F[j, E.dofs[E.dof[e] + i]] -= s * work.rl[i]
    for l in range(E.z[e, BEGIN], E.z[e, END]):
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
    if C.joint_friction[c, LOAD_KERNEL] < 0:
        return
    for i in range(6):
        work.r[C.dofs[begin + i]] = 0.0
    add_joint_friction(varied, address, c, n, m, h, lam, z, 0.0, 0.0, False, work)
    for i in range(6):
        T.F[j, C.dofs[begin + i]] -= factor * work.r[C.dofs[begin + i]]
    for l in range(C.joint_friction_z[c, BEGIN], C.joint_friction_z[c, END]):
        T.z1[j, l] += factor * work.z_new[l]


@compiled
def _add_contact(varied, address, c, h, q, v, z, factor, j, T, work):
    """Add factor times the forces of contact c at its present gap, then of their present sizes along its axes."""
    K, out, here, S = varied.contacts, work.contact[c], work.gap, work.contact_scratch
    begin, end = K.z[c, NORMAL_Z], K.z[c, Z_END]
    N, _, _ = call_normal(varied, address, c, h, out[GAP], out[GAP_RATE], z, work.z_new)
    T.N[j, c] += factor * N
    friction, _, _ = call_friction(varied, address, c, h, out[SLIP], out[NORMAL_FORCE], z, work.z_new)
    T.T[j, c] += factor * friction
    for l in range(begin, end):
        T.z1[j, l] += factor * work.z_new[l]
    gather(q, K.dofs, 6 * c, 6, work.ql)
    gather(v, K.dofs, 6 * c, 6, work.vl)
    call_gap(varied, address, c, work.ql, work.vl, here)
    by = T.by.contact
    by[3 * j + OF_GAP, c] += factor * here[GAP]
    by[3 * j + OF_RATE, c] += factor * here[GAP_RATE]
    by[3 * j + OF_SLIP, c] += factor * here[SLIP]
    jacobians(here, S)
    for i in range(6):
        force = out[NORMAL_FORCE] * S[NORMAL, i] + out[FRICTION_FORCE] * S[TANGENTIAL, i]
        T.F[j, K.dofs[6 * c + i]] += factor * force
