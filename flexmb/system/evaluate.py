"""Evaluation of all elements, contacts and constraints at one state."""

from flexmb.kernels import compiled
from flexmb.system.constraints import add_constraints
from flexmb.system.contacts import add_contacts
from flexmb.system.elements import add_elements, evaluate_energies


@compiled
def evaluate(tables, address, t, h, q, v, a, lam, z, kq, kv, ka, matrix, work):
    """Evaluate forces and constraint residuals; if `matrix`, also [[kq (K + H) + kv C + ka M, G^T], [G, 0]].

    q, v, a : (n_q + 3,) with zeros for the ground; h : time since the history z was accepted [s].  Without the matrix
    work.lu is unchanged, so that its factors can be reused.
    """
    work.r[:] = 0.0
    work.Gl[:] = 0.0
    if matrix:
        work.lu[:] = 0.0
    add_elements(tables, address, t, h, q, v, a, z, kq, kv, ka, matrix, work)
    add_contacts(tables, address, t, h, q, v, z, kq, kv, matrix, work)
    add_constraints(tables, address, t, h, q, v, lam, z, kq, kv, matrix, work)


@compiled
def evaluate_accepted(tables, address, t, h, q, v, a, lam, z, x, y, work):
    """Evaluate forces, histories and energies at a state, without a matrix."""
    work.r[:] = 0.0
    work.Gl[:] = 0.0
    evaluate_energies(tables, address, t, h, q, v, a, x, y, z, work)
    add_contacts(tables, address, t, h, q, v, z, 0.0, 0.0, False, work)
    add_constraints(tables, address, t, h, q, v, lam, z, 0.0, 0.0, False, work)
