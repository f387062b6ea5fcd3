"""Poses that a run keeps for its watch: signals and histories of some accepted steps, whatever is saved."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from flexmb.compiled.records import Matrix, Record, Vector
from flexmb.program.program import Program

MOST_POSES, LEAST_POSES, POSE_NUMBERS = 256, 32, 1 << 18
"""Number of poses, at most and at least; numbers of all poses (2 MB) beyond which there are fewer."""


class Poses(Record):
    """Poses of accepted steps: every k-th one, with k doubled when the table is full, and the most strained one.

    count : number of the poses so far, without the most strained one, which is the last row
    stride, wait : steps between two poses, steps until the next one
    strain : strain energy of the most strained one [J]
    times, sizes : (rows,) instants of the poses [s], sizes of the steps that led there [s]
    values : (rows, n_y) all signals;  z : (rows, n_z) histories
    """

    count: int
    stride: int
    wait: int
    strain: float
    times: Vector
    sizes: Vector
    values: Matrix
    z: Matrix


def new_poses(program: Program, histories: int | None = None) -> Poses:
    """An empty table.

    Parameters
    ----------
    program : the model whose signals are kept.
    histories : number of histories; None: those of `program`.
    """
    n_y, n_z = program.tables.sizes.n_y, program.tables.sizes.n_z if histories is None else histories
    rows = max(LEAST_POSES, min(MOST_POSES, POSE_NUMBERS // (n_y + n_z))) // 2 * 2 + 1
    return Poses(0, 1, 0, 0.0, times=rows, sizes=rows, values=(rows, n_y), z=(rows, n_z))


def keep_first(poses: Poses, t: float, signals: np.ndarray, z: np.ndarray) -> None:
    """Keep the pose at which a run begins.

    Parameters
    ----------
    poses : the table.
    t : the instant [s].
    signals, z : all signals (n_y,), histories (n_z,).
    """
    poses.times[0], poses.sizes[0], poses.values[0], poses.z[0] = t, 0.0, signals, z
    poses.count, poses.stride, poses.wait, poses.strain = 1, 1, 1, 0.0


def saved_poses(poses: Poses) -> dict[str, np.ndarray]:
    """Copies of the numbers and arrays of a table by name."""
    arrays = {f"poses.{name}": getattr(poses, name).copy() for name in ("times", "sizes", "values", "z")}
    return {"poses": poses.numbers(), **arrays}


def restore_poses(poses: Poses, saved: Mapping[str, np.ndarray]) -> None:
    """Take a table back to the numbers and arrays of `saved_poses`."""
    poses.set_numbers(saved["poses"])
    for name in ("times", "sizes", "values", "z"):
        getattr(poses, name)[:] = saved[f"poses.{name}"]


def order_of_poses(poses: Poses) -> np.ndarray:
    """Numbers of the rows with poses, by their instants."""
    last = [len(poses.times) - 1] if poses.strain > 0.0 else []
    rows = np.array([*range(poses.count), *last])
    return rows[np.argsort(poses.times[rows], kind="stable")]
