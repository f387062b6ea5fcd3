"""Poses that a run keeps for its watch: signals and histories of some accepted steps, whatever is saved."""

from __future__ import annotations

import numpy as np

from flexmb.compiled.records import LARGEST, Matrix, Record, Vector
from flexmb.program.program import Program

MOST_POSES, LEAST_POSES, POSE_NUMBERS = 256, 32, 1 << 18
"""Number of poses, at most and at least; numbers of all poses (2 MB) beyond which there are fewer."""


class PoseNumbers(Record, limits={"count": (0, MOST_POSES), "stride": (1, LARGEST), "wait": (0, LARGEST)}):
    """Numbers of a table of poses.

    count : number of the poses so far, without the most strained one, which is the last row
    stride, wait : steps between two poses, steps until the next one
    strain : strain energy of the most strained one [J]
    """

    count: int
    stride: int
    wait: int
    strain: float


class Poses(Record):
    """Poses of accepted steps: every k-th one, with k doubled when the table is full, and the most strained one.

    number : see `PoseNumbers`
    times, sizes : (rows,) instants of the poses [s], sizes of the steps that led there [s]
    values : (rows, n_y) all signals;  z : (rows, n_z) histories
    """

    number: PoseNumbers
    times: Vector
    sizes: Vector
    values: Matrix
    z: Matrix


def new_poses(program: Program, histories: int | None = None) -> Poses:
    """An empty table of poses with the signals of a model, and its histories or another number of them."""
    n_y, n_z = program.tables.sizes.n_y, program.tables.sizes.n_z if histories is None else histories
    rows = max(LEAST_POSES, min(MOST_POSES, POSE_NUMBERS // (n_y + n_z))) // 2 * 2 + 1
    return Poses(PoseNumbers(0, 1, 0, 0.0), times=rows, sizes=rows, values=(rows, n_y), z=(rows, n_z))


def keep_first(poses: Poses, t: float, signals: np.ndarray, z: np.ndarray) -> None:
    """Keep the pose at which a run begins, t [s], with all signals (n_y,) and histories (n_z,)."""
    poses.times[0], poses.sizes[0], poses.values[0], poses.z[0] = t, 0.0, signals, z
    poses.number.set_numbers(np.array([1, 1, 1, 0.0]))


def kept_poses(poses: Poses, t: float, signals: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, ...]:
    """Instants, signals, histories, sizes of steps of all poses in order, and which are even; the present one is last.

    The present instant t [s] has all signals (n_y,) and histories z (n_z,).
    """
    count, strained = poses.number.count, poses.number.strain > 0.0
    rows = np.array([*range(count), *([len(poses.times) - 1] if strained else [])])
    rows = rows[np.argsort(poses.times[rows], kind="stable")]
    times, values, histories = np.append(poses.times[rows], t), poses.values[rows], poses.z[rows]
    sizes, even = np.append(poses.sizes[rows], 0.0), np.append(rows < count, False)
    return times, np.concatenate([values, signals[None]]), np.concatenate([histories, z[None]]), sizes, even
