"""Envelopes of signals that swing too fast for single lines to be seen."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from flexmb.pictures.style import curve

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COLUMNS = 400
"""Number of columns of an envelope."""

LEAST_SWING = 0.02
"""Least swing that counts, over the range of the signal; smaller ones are hidden in the width of a line."""

DENSE = 0.5
"""Reversals of a signal in a column, on average of the busiest fifth, from which on it is drawn as an envelope."""


def is_dense(time: np.ndarray, values: np.ndarray, columns: int = COLUMNS) -> bool:
    """Whether a curve of a signal (n,) at instants (n,) [s] is a solid block, at least in a fifth of the picture."""
    if len(time) < columns or not time[-1] > time[0]:
        return False
    change = np.diff(values)
    turns = np.flatnonzero(change[1:] * change[:-1] < 0.0) + 1
    swings = np.abs(np.diff(values[turns]))
    large = turns[1:][swings > LEAST_SWING * float(np.ptp(values))]
    counts = np.bincount(_column(time, columns)[large], minlength=columns)
    return bool(np.sort(counts)[-columns // 5 :].mean() > DENSE)


def envelope(time: np.ndarray, values: np.ndarray, columns: int = COLUMNS) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Middles of the columns, and the least and the largest value in each.

    Every value lies in the band: the last value of a column also counts in the next one, as its line does.  Columns
    without values are left out.  The signal (n,) belongs to increasing instants (n,) [s]; columns lie evenly over the
    time.
    """
    place = _column(time, columns)
    starts = np.flatnonzero(np.append(True, np.diff(place) > 0))
    low, high = np.fmin.reduceat(values, starts), np.fmax.reduceat(values, starts)
    before = values[starts[1:] - 1]
    low[1:], high[1:] = np.fmin(low[1:], before), np.fmax(high[1:], before)
    width = (time[-1] - time[0]) / columns
    return time[0] + (place[starts] + 0.5) * width, low, high


def _column(time: np.ndarray, columns: int) -> np.ndarray:
    """Number of the column of each instant."""
    place = np.floor((time - time[0]) / (time[-1] - time[0]) * columns).astype(int)
    return np.asarray(np.minimum(place, columns - 1))


def draw_signal(ax: Axes, time: np.ndarray, values: np.ndarray, k: int, label: str, **style: Any) -> None:
    """Draw a signal over time: a line, or the band of its envelope where single lines would be a solid block.

    The signal (n,) belongs to instants (n,) [s]; its number k in the panel gives colour and line style.  Further
    keywords are those of matplotlib for a line.
    """
    from matplotlib.colors import to_rgba

    look = curve(k)
    if not is_dense(time, values):
        ax.plot(time, values, label=label, **{**look, **style})
        return
    middle, low, high = envelope(time, values)
    rim = {"edgecolor": look["color"], "linestyle": look["linestyle"], "linewidth": 0.6}
    ax.fill_between(middle, low, high, facecolor=to_rgba(look["color"], 0.3), label=label, **rim)
