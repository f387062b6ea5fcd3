"""The flat arrays of a program, as the compiled loop reads them.

Lists of different lengths are stored one after the other: dof[k] : dof[k + 1] bounds what belongs to piece k.
Pairs (n, 2) hold begin and end in the long lists p (numbers of the parts) and z (histories).
Coordinates are numbered 0 .. n_q - 1; n_q, n_q + 1, n_q + 2 are those of the ground, which stay 0.
Positions are indices into the value array of the factored matrix (see `flexmb.program.symbolic`).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class Elements(NamedTuple):
    """Elements: numbers of their kernels (-1: none), where p, z, dofs, positions (row by row) are.

    An element with force, tangent and account is never called through `kernel` and `energy`, which then are -1.
    """

    kernel: np.ndarray  # (n,)
    energy: np.ndarray  # (n,)
    factor: np.ndarray  # (n,) a motion
    force: np.ndarray  # (n,)
    tangent: np.ndarray  # (n,)
    account: np.ndarray  # (n,)
    p: np.ndarray  # (n, 2)
    factor_p: np.ndarray  # (n, 2)
    z: np.ndarray  # (n, 2)
    dof: np.ndarray  # (n + 1,)
    pos: np.ndarray  # (n + 1,)
    dofs: np.ndarray
    positions: np.ndarray


class Constraints(NamedTuple):
    """Constraints: kernels, motions of their rows (-1: none), where numbers, rows, dofs and positions are, signals."""

    kernel: np.ndarray  # (n,)
    motion: np.ndarray  # (n_c,) of each row
    p: np.ndarray  # (n, 2)
    motion_p: np.ndarray  # (n_c, 2)
    row: np.ndarray  # (n + 1,)
    dof: np.ndarray  # (n + 1,)
    pos_g: np.ndarray  # (n + 1,)
    pos_h: np.ndarray  # (n + 1,)
    dofs: np.ndarray
    positions_g: np.ndarray
    positions_gt: np.ndarray
    positions_h: np.ndarray
    second: np.ndarray  # (n, 3) places of x, y, theta of the second body among the dofs, -1: none
    moment: np.ndarray  # (n,) row of the reported moment, -1: none
    out: np.ndarray  # (n,) first of its signals
    forces: np.ndarray  # (n,) how many signals its force has, before those of its motions; 0 for a drive
    grip: np.ndarray  # (n, 2) grip and friction kernel, -1: no friction
    grip_p: np.ndarray  # (n, 4) begin and end for grip and friction law
    grip_z: np.ndarray  # (n, 2)
    grip_arm: np.ndarray  # (n,)


class Contacts(NamedTuple):
    """Contacts: numbers of gap, normal and friction kernel, where their numbers, histories and positions are."""

    kernel: np.ndarray  # (n, 3)
    p: np.ndarray  # (n, 6) begin and end for gap, normal, friction
    z: np.ndarray  # (n, 4) begin of common, normal and friction history, end
    dofs: np.ndarray  # (6 n,)
    positions: np.ndarray  # (36 n,)
    out: np.ndarray  # (n,) first of its signals


class Measured(NamedTuple):
    """Signals computed by kernels."""

    kernel: np.ndarray  # (n,)
    p: np.ndarray  # (n, 2)
    dof: np.ndarray  # (n + 1,)
    dofs: np.ndarray
    out: np.ndarray  # (n,)
    modes: np.ndarray  # those of `out` that number states


class Sizes(NamedTuple):
    """Numbers of coordinates, multipliers, histories, signals; first energy signal; longest lists of a piece."""

    n_q: int
    n_c: int
    n_z: int
    n_y: int
    energy: int
    most_dofs: int
    most_rows: int
    gripped: bool  # whether an ideal joint has friction


class Tables(NamedTuple):
    """All arrays of a program."""

    sizes: Sizes
    p: np.ndarray
    elements: Elements
    constraints: Constraints
    contacts: Contacts
    measured: Measured
    kind: np.ndarray  # (n_q,) 0 for a length, 1 for an angle


class Addresses(NamedTuple):
    """Where the kernels are; made anew in every process."""

    element: object
    energy: object
    constraint: object
    motion: object
    gap: object
    normal: object
    friction: object
    grip: object
    signal: object
    force: object
    tangent: object
    account: object


CONTACT_COMMON = 5
"""History that every contact keeps: phase, time of its onset, gap, force and gap rate at the last state."""
