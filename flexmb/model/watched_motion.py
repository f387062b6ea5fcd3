"""Motion of a run as its parts are asked about it: peaks over all steps, and poses of some steps."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

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

    def peak(self, name: str) -> tuple[float, float]:
        """Largest absolute value of a signal over all steps, and when [s]."""
        place = self.signals.places[name]
        return float(self.peaks[0][place]), float(self.peaks[1][place])
