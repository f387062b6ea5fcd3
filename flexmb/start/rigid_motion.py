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

    Parameters
    ----------
    program : the compiled mechanism.
    """

    def __init__(self, program: Program) -> None:
        self.program = program
        self.body = np.asarray(program.reference.body[::3])  # of each node; those of controls move by themselves
        self.turns = np.asarray(program.reference.turns)
        self.count = max(len(program.names.bodies), int(self.body.max(initial=-1)) + 1)
        self.first = np.full(self.count, -1)
        self.first[self.body[::-1]] = np.arange(len(self.body))[::-1]  # of several the last one stays

    def basis(self, q: np.ndarray) -> sp.csr_matrix:
        """B (n_q, 3 bodies): velocities of the coordinates by velocities of the bodies about their first nodes."""
        import scipy.sparse as sp

        return sp.csr_matrix(self._entries(q), shape=(len(q), 3 * self.count))

    def plain_basis(self, q: np.ndarray) -> np.ndarray | sp.csr_matrix:
        """`basis` as a plain array, for at most DENSE_UNKNOWNS unknowns (see `dense_or_sparse.py`)."""
        if self.program.symbolic.n > DENSE_UNKNOWNS:
            return self.basis(q)
        values, places = self._entries(q)
        B = np.zeros((len(q), 3 * self.count))
        B[places] = values
        return B

    def _entries(self, q: np.ndarray) -> tuple[np.ndarray, tuple[np.ndarray, np.ndarray]]:
        """Values of B, with their rows and columns."""
        nodes = np.arange(len(self.body))
        arms = q.reshape(-1, 3) - q.reshape(-1, 3)[self.first[self.body]]
        column = 3 * self.body
        rows = np.concatenate([3 * nodes, 3 * nodes + 1, 3 * nodes + 2, 3 * nodes, 3 * nodes + 1])
        columns = np.concatenate([column, column + 1, column + 2, column + 2, column + 2])
        ones = np.ones(len(nodes))
        return np.concatenate([ones, ones, self.turns, -arms[:, 1], arms[:, 0]]), (rows, columns)

    def moved(self, q: np.ndarray, w: np.ndarray) -> np.ndarray:
        """Coordinates after the bodies have moved by w (finite rotations)."""
        pose, shift = q.reshape(-1, 3), w.reshape(-1, 3)[self.body]
        centre = pose[self.first[self.body]]
        c, s = np.cos(shift[:, 2]), np.sin(shift[:, 2])
        dx, dy = (pose - centre)[:, 0], (pose - centre)[:, 1]
        x = centre[:, 0] + shift[:, 0] + c * dx - s * dy
        y = centre[:, 1] + shift[:, 1] + s * dx + c * dy
        return np.column_stack([x, y, pose[:, 2] + self.turns * shift[:, 2]]).ravel()
