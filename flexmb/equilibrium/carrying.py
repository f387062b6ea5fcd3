"""Contacts of a mechanism at rest: the ones that carry and the ones left out, and their geometric stiffness."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from flexmb.display.text import listed
from flexmb.kernels import GAP_SIZE
from flexmb.model.mechanism import Mechanism
from flexmb.places import (
    ARM1_X,
    ARM1_X_Q,
    ARM1_Y,
    ARM1_Y_Q,
    ARM2_X,
    ARM2_X_Q,
    ARM2_Y,
    ARM2_Y_Q,
    NORMAL,
    NORMAL_FORCE,
    NORMAL_X,
    NORMAL_X_Q,
    NORMAL_Y,
    NORMAL_Y_Q,
)
from flexmb.system.contacts import jacobians
from flexmb.system.state_evaluation import StateEvaluation
from flexmb.system.work import N_BY_GAP


def carries(system: StateEvaluation) -> np.ndarray:
    """Whether each contact has a normal force at the last evaluation (contacts,)."""
    return np.asarray(system.work.contact[: len(system.program.names.contacts), NORMAL_FORCE] > 0.0)


def open_contacts(system: StateEvaluation) -> tuple[str, ...]:
    """Names of the contacts without a normal force at the last evaluation."""
    return tuple(name for name, held in zip(system.program.names.contacts, carries(system), strict=True) if not held)


def unpaired(mechanism: Mechanism) -> tuple[str, ...]:
    """Names of the parts of a mechanism with contacts that no ideal joint replaces."""
    found = mechanism.contributions()
    replaced = {c.part for c in found.constraints if c.holds == "closed"}
    return tuple(dict.fromkeys(c.part for c in found.contacts if c.part not in replaced))


def left_out_text(left_out: tuple[str, ...], remedy: str) -> str:
    """Sentence on contacts that a linearisation leaves out; "" without such contacts."""
    return f"Without stiffness here, since they do not carry: {listed(left_out)}. {remedy}" if left_out else ""


def contact_stiffness(system: StateEvaluation, u: np.ndarray) -> sp.csc_matrix:
    """Stiffness (n_q, n_q) by the normal forces that grow along displacements u (n_q,): -dN dJ_n/dq of each contact."""
    n, K = system.program.n_q, system.program.tables.contacts
    moved, rows = np.append(u, np.zeros(3)), np.zeros((2, 6))
    found = sp.lil_matrix((n + 3, n + 3))
    for k in np.flatnonzero(carries(system)):
        dofs, out = K.dofs[6 * k : 6 * k + 6], system.work.contact[k, :GAP_SIZE]
        jacobians(out, rows)
        growth = system.work.slopes[k, N_BY_GAP] * float(rows[NORMAL] @ moved[dofs])
        found[np.ix_(dofs, dofs)] -= growth * _normal_slopes(out)
    return found[:n, :n].tocsc()


def _normal_slopes(out: np.ndarray) -> np.ndarray:
    """Derivatives of J_n (6, 6) by the coordinates; rows are entries of J_n."""
    nx, ny, ax, ay, bx, by = out[[NORMAL_X, NORMAL_Y, ARM1_X, ARM1_Y, ARM2_X, ARM2_Y]]
    first = (NORMAL_X_Q, NORMAL_Y_Q, ARM1_X_Q, ARM1_Y_Q, ARM2_X_Q, ARM2_Y_Q)
    x, y, axq, ayq, bxq, byq = (out[place : place + 6] for place in first)
    turn1, turn2 = y * ax - x * ay + ny * axq - nx * ayq, y * bx - x * by + ny * bxq - nx * byq
    return np.stack([x, y, turn1, -x, -y, -turn2])
