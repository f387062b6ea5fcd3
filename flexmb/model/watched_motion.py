"""Motion of a run as its parts are asked about it: peaks over all steps, and poses of some steps."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from flexmb.model.part import GROUND
from flexmb.model.signal import Signals


class WatchedMotion(NamedTuple):
    """Motion of a run, whatever of it was saved.

    Parameters
    ----------
    signals : names of all signals.
    times : (n,) instants of some accepted steps, the first and the most strained one among them [s].
    values : (n, n_y) all signals there.
    peaks : (n_y,) largest absolute values of all signals over all steps, and (n_y,) when [s].
    lows : least value and its instant [s] of the signals of `Part.pushes`, by name.
    """

    signals: Signals
    times: np.ndarray
    values: np.ndarray
    peaks: tuple[np.ndarray, np.ndarray]
    lows: Mapping[str, tuple[float, float]]

    def rows(self, *names: str) -> np.ndarray:
        """Values (n, k) of signals by their full names at the instants."""
        return self.values[:, [self.signals.places[name] for name in names]]

    def pose(self, body: str, node: str) -> np.ndarray:
        """x, y, theta (n, 3) of a node [m, rad]; zeros for the ground."""
        if body == GROUND.name:
            return np.zeros((len(self.times), 3))
        stem = f"{body}.{node}" if node else body
        return self.rows(*(f"{stem}.{axis}" for axis in ("x", "y", "theta")))

    def point(self, place: tuple[str, str, tuple[float, float]]) -> np.ndarray:
        """Positions (n, 2) of a point of a body [m]: body, node, offset in the frame of the node."""
        body, node, (a, b) = place
        x, y, theta = self.pose(body, node).T
        c, s = np.cos(theta), np.sin(theta)
        return np.column_stack([x + a * c - b * s, y + a * s + b * c])

    def peak(self, name: str) -> tuple[float, float]:
        """Largest absolute value of a signal over all steps, and when [s]."""
        place = self.signals.places[name]
        return float(self.peaks[0][place]), float(self.peaks[1][place])
