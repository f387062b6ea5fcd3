"""Workspace of an evaluation: allocated once, used by every step."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from flexmb.kernels import GAP_SIZE, GRIP_SIZE
from flexmb.program.program import Program


class Work(NamedTuple):
    """Results of an evaluation, and scratch space of one piece.

    r : (n_q + 3,) forces the structure exerts, inertia included, without those of constraints
    Gl : (n_q + 3,) G^T lambda;  g, gv, gamma : (n_c,) residual, residual of velocities G v + g_t, right side of G a
    lu : values of the matrix;  z_new : history if the state is accepted
    contact : (n, GAP_SIZE + 2) gap data, normal force, friction force;  drive : (n_c, 4) motion and force
    joint : (n, 4) force on the second body (x, y), moment row, spare
    grip : (n, 2) friction force and slip of each joint
    slopes : (contacts + joints, 4) dN/dgap, dN/drate, dT/dslip, dT/dN of contacts; dT/dslip, dT/dlam of joints
    G : rows of all constraints, one after the other, on the dofs of their own
    power : kinetic energy, strain, gravity, power of damping, work of the algorithm
    load : forces on the dofs of all elements without an account of their own, one after the other
    momentum : (n_q + 3,) M v
    loss : (n, 16) of every contact: losses normal, tangential, beyond its laws [J]; normal force, generalised forces
    gap, z_between : gap data and histories of what is only tried
    """

    r: np.ndarray
    Gl: np.ndarray
    g: np.ndarray
    gv: np.ndarray
    gamma: np.ndarray
    lu: np.ndarray
    z_new: np.ndarray
    contact: np.ndarray
    drive: np.ndarray
    joint: np.ndarray
    power: np.ndarray
    ql: np.ndarray
    vl: np.ndarray
    al: np.ndarray
    rl: np.ndarray
    Kl: np.ndarray
    Cl: np.ndarray
    Ml: np.ndarray
    G: np.ndarray
    contact_scratch: np.ndarray  # (2, 6)
    grip: np.ndarray
    grip_out: np.ndarray
    grip_curve: np.ndarray
    yl: np.ndarray
    Mvl: np.ndarray
    Myl: np.ndarray
    slopes: np.ndarray
    load: np.ndarray
    momentum: np.ndarray
    loss: np.ndarray
    gap: np.ndarray
    z_between: np.ndarray


def workspace(program: Program) -> Work:
    """Workspace for a program."""
    sizes = program.tables.sizes
    n = max(sizes.most_dofs, 6)
    n_k, n_g = len(program.tables.contacts.kernel), len(program.tables.constraints.kernel)
    return Work(
        np.zeros(sizes.n_q + 3),
        np.zeros(sizes.n_q + 3),
        np.zeros(sizes.n_c),
        np.zeros(sizes.n_c),
        np.zeros(sizes.n_c),
        np.zeros(program.symbolic.size),
        np.zeros(sizes.n_z),
        np.zeros((n_k, GAP_SIZE + 2)),
        np.zeros((sizes.n_c, 4)),
        np.zeros((n_g, 4)),
        np.zeros(5),
        np.zeros(n),
        np.zeros(n),
        np.zeros(n),
        np.zeros(n),
        np.zeros(n * n),
        np.zeros(n * n),
        np.zeros(n * n),
        np.zeros(program.tables.constraints.pos_g[-1]),
        np.zeros((2, 6)),
        np.zeros((n_g, 2)),
        np.zeros(GRIP_SIZE),
        np.zeros((6, 6)),
        np.zeros(n),
        np.zeros(n),
        np.zeros(n),
        np.zeros((n_k + n_g, 4)),
        np.zeros(load_forces(program)),
        np.zeros(sizes.n_q + 3),
        np.zeros((n_k, 16)),
        np.zeros(GAP_SIZE),
        np.zeros(sizes.n_z),
    )


def load_forces(program: Program) -> int:
    """Number of dofs of all elements without an account of their own."""
    E = program.tables.elements
    return int((E.dof[1:] - E.dof[:-1])[E.energy < 0].sum())
