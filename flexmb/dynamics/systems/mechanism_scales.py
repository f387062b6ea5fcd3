"""Scales of a mechanism's state and signals: weights, resolution, bookkeeping histories, signals of the motion."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flexmb.contact.onset import HISTORY
from flexmb.contact.validity import HISTORY_WITH_EXTREMES
from flexmb.program.program import Program
from flexmb.start.projection import metric_of

PLACES = (".ex", ".ey")
"""Endings of the signals that give the position of a journal in its bearing."""
ONSET = 1
"""Index of the instant of the onset among the histories that every contact has."""


def state_weights(program: Program, period: float | None) -> np.ndarray:
    """Weights (size,) of the squares of a state (q, v, z, a, x) in its length.

    Angles are multiplied by the length of the mechanism, velocities by period / (2 pi).  Histories and accelerations
    have the weight 0.  Without a period [s] it is 1 s.
    """
    metric, n_z = metric_of(program), program.tables.sizes.n_z
    n, time = program.n_q, (period or 1.0) / (2.0 * np.pi)
    return np.concatenate([metric, time**2 * metric, np.zeros(n_z + 2 * n)])


def bookkeeping_rows(program: Program) -> np.ndarray:
    """Rows (m,) of a state that no force depends on: instants and speeds of onsets, extremes noted by contact laws."""
    rows = list[int]()
    for (common, _, end, _), law in zip(program.tables.contacts.z, program.normals, strict=True):
        extremes = len(HISTORY_WITH_EXTREMES) - len(HISTORY) if law.history() is HISTORY_WITH_EXTREMES else 0
        rows += [int(common) + ONSET, *range(int(end) - extremes, int(end))]
    return 2 * program.n_q + np.array(rows, dtype=np.int64)


def motion_signals(names: Sequence[str], n_q: int) -> tuple[int, ...]:
    """Numbers of the signals on which a verdict rests: positions, velocities, and positions of journals.

    Forces and accelerations are functions of positions, velocities and histories, and their spikes spoil every mean.
    Sums of energies never return to their start.  Positions and velocities come first among all names.
    """
    return tuple(k for k, name in enumerate(names) if k < 2 * n_q or name.endswith(PLACES))


def signal_resolution(
    program: Program, names: Sequence[str], peak: np.ndarray, steps: tuple[float, float] | None, period: float | None
) -> np.ndarray:
    """Differences (m,) of the signals that errors of the integration can make [units of the signals].

    With error-controlled steps: a tenth of the error allowed in a step, because the steps fall differently in each
    period of a periodic motion.  With fixed steps: 1e-8 of the length of the mechanism and of its largest speed.  For
    signals other than positions, velocities and positions of journals: 1e-6 of their largest values.  Allowed errors
    `steps` are those of a position [m] and of a velocity as a fraction of the speed; None: fixed steps.  `peak` (m,)
    has the largest magnitudes of the signals.  Without a period [s] it is 1 s.
    """
    n, length = program.n_q, program.length
    angle = np.asarray(program.tables.kind) == 1
    scale = np.where(angle, 1.0 / length, 1.0)
    speed = max(float((peak[n : 2 * n] / scale).max(initial=0.0)), length / (period or 1.0))
    position, velocity = 1e-8 * length, 1e-8 * speed
    if steps is not None:
        position, velocity = 0.1 * steps[0], 0.1 * steps[1] * speed
    resolution = np.maximum(1e-6 * peak, 1e-300)
    resolution[:n], resolution[n : 2 * n] = position * scale, velocity * scale
    resolution[[k for k, name in enumerate(names) if name.endswith(PLACES)]] = position
    return resolution
