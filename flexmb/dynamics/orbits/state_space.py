"""State space of periodic orbits: differences of states, their lengths, and the entries that must return."""

from __future__ import annotations

import numpy as np

from flexmb import checks
from flexmb.dynamics.systems.dynamics import Dynamics, orthonormalise
from flexmb.dynamics.systems.mechanism_flow import MechanismFlow
from flexmb.errors import InputError

TURN = 2.0 * np.pi


class StateSpace:
    """Differences of states, their lengths, and the entries of a state that must return on a periodic orbit.

    Positions and velocities must return, angles of bodies up to whole turns; entries without weight follow from them.
    Histories of friction and of elements must return as well, in their own units (deflections of bristles).  Histories
    of normal contacts need not: they hold times of onsets, and values that positions and velocities determine.  They
    are passed on from the end of one run to the start of the next run (`free_rows`).

    Parameters
    ----------
    angles : names of state entries that count modulo 2 pi.
    """

    def __init__(self, label: str, system: Dynamics, angles: tuple[str, ...] = ()) -> None:
        self.weights, size = system.weights.copy(), system.size
        self.angle, self.free_rows = np.zeros(size, dtype=bool), np.zeros(size, dtype=bool)
        self.history_rows = np.zeros(0, dtype=np.int64)
        if isinstance(system, MechanismFlow):
            n, n_z = system.program.n_q, system.program.tables.sizes.n_z
            self.angle[:n] = np.asarray(system.program.tables.kind) == 1
            self.history_rows = 2 * n + history_rows_of(system)
            self.free_rows[2 * n : 2 * n + n_z] = True
            self.free_rows[self.history_rows] = False
            self.weights[self.history_rows] = 1.0
        for name in angles:
            if len(system.names) != size:
                raise InputError(f"{label}: angles are named, but {system.name!r} has no names for its state.")
            self.angle[system.names.index(checks.one_of(label, "angle", name, system.names))] = True

    def difference(self, one: np.ndarray, other: np.ndarray) -> np.ndarray:
        """Difference one - other (size,) of two states, without whole turns of angles."""
        d = one - other
        d[self.angle] -= TURN * np.round(d[self.angle] / TURN)
        return np.asarray(d)

    def length(self, d: np.ndarray) -> float:
        """Length of a difference `d` (size,) in the weights."""
        return float(np.sqrt(self.weights @ (d * d)))

    def basis(self, system: Dynamics) -> np.ndarray:
        """Basis (size, d) of the differences that the present state of a `system` allows, orthonormal."""
        d = system.dimension
        if d == 0:
            W = np.zeros((system.size, 0))
        elif d == system.size:
            W = system.on_manifold(np.eye(d))
            orthonormalise(W, self.weights)
        else:
            W = system.tangent_basis(d)
        if len(self.history_rows) == 0:
            return W
        Z = np.zeros((system.size, len(self.history_rows)))
        Z[self.history_rows, np.arange(len(self.history_rows))] = 1.0
        W = np.ascontiguousarray(np.hstack([W, system.on_manifold(Z)]))
        orthonormalise(W, self.weights)
        return W


def history_rows_of(system: MechanismFlow) -> np.ndarray:
    """Indices of the histories of friction and of elements among all histories of a `system`."""
    tables = system.program.tables
    pairs = [*np.asarray(tables.elements.z), *np.asarray(tables.constraints.joint_friction_z)]
    pairs += [row[2:4] for row in np.asarray(tables.contacts.z)]
    return np.array(sorted({i for begin, end in pairs for i in range(int(begin), int(end))}), dtype=np.int64)
