"""Rigid motions of all bodies of a program, for closing loops and for start velocities."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexmb.linalg.dense_or_sparse import DENSE_UNKNOWNS
from flexmb.program.program import Program

if TYPE_CHECKING:
    import scipy.sparse as sp


class RigidMotion:
    """Motions of all bodies as rigid ones, flexible bodies included: w = (x, y, angle) for each body.

    States of controls, which stand behind the coordinates of the bodies, have no part in these motions.  Poses may hold
    them or not.
    """

    def __init__(self, program: Program) -> None:
        self.program = program
        n_b = program.tables.sizes.n_b
        self.body = np.asarray(program.reference.body[:n_b:3])  # of each node
        self.turns = np.asarray(program.reference.turns)[: len(self.body)]
        self.count = len(program.names.bodies)
        self.sizes = np.tile([program.length, program.length, 1.0], self.count)  # of w
        self.first = np.full(self.count, -1)
        self.first[self.body[::-1]] = np.arange(len(self.body))[::-1]  # of several the last one stays

    def basis(self, q: np.ndarray) -> sp.csr_matrix:
        """B (n_q, 3 bodies): velocities of the coordinates by velocities of the bodies about their first nodes."""
        import scipy.sparse as sp

        return sp.csr_matrix(self._entries(q), shape=(self.program.n_q, 3 * self.count))

    def plain_basis(self, q: np.ndarray) -> np.ndarray | sp.csr_matrix:
        """`basis` as a plain array, for at most DENSE_UNKNOWNS unknowns (see `dense_or_sparse.py`)."""
        if self.program.symbolic.n > DENSE_UNKNOWNS:
            return self.basis(q)
        values, places = self._entries(q)
        B = np.zeros((self.program.n_q, 3 * self.count))
        B[places] = values
        return B

    def _entries(self, q: np.ndarray) -> tuple[np.ndarray, tuple[np.ndarray, np.ndarray]]:
        """Values of B, with their rows and columns."""
        nodes = np.arange(len(self.body))
        pose = q.reshape(-1, 3)[: len(nodes)]
        arms = pose - pose[self.first[self.body]]
        column = 3 * self.body
        rows = np.concatenate([3 * nodes, 3 * nodes + 1, 3 * nodes + 2, 3 * nodes, 3 * nodes + 1])
        columns = np.concatenate([column, column + 1, column + 2, column + 2, column + 2])
        ones = np.ones(len(nodes))
        return np.concatenate([ones, ones, self.turns, -arms[:, 1], arms[:, 0]]), (rows, columns)

    def moved(self, q: np.ndarray, w: np.ndarray) -> np.ndarray:
        """Coordinates after the bodies have moved by w (finite rotations)."""
        n, shift = 3 * len(self.body), w.reshape(-1, 3)[self.body]
        pose = q[:n].reshape(-1, 3)
        centre = pose[self.first[self.body]]
        c, s = np.cos(shift[:, 2]), np.sin(shift[:, 2])
        dx, dy = (pose - centre)[:, 0], (pose - centre)[:, 1]
        x = centre[:, 0] + shift[:, 0] + c * dx - s * dy
        y = centre[:, 1] + shift[:, 1] + s * dx + c * dy
        return np.append(np.column_stack([x, y, pose[:, 2] + self.turns * shift[:, 2]]).ravel(), q[n:])
