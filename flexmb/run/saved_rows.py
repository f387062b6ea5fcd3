"""Saved rows of a run in one growing array, filled from the buffer of the loop."""

from __future__ import annotations

import numpy as np

from flexmb.errors import InputError

MOST_RESERVED_BYTES = 1 << 30
"""Number of bytes at most that are reserved before the first row."""


class SavedRows:
    """Saved instants and their signals.

    Parameters
    ----------
    columns : signals of a row.
    kept : (columns,) places of these among all signals; None: all.
    """

    def __init__(self, columns: int, kept: np.ndarray | None = None) -> None:
        self.kept = kept
        self.count = 0
        self._times = np.empty(0)
        self._values = np.empty((0, columns))

    def require_room(self, label: str, rows: float) -> None:
        """Refuse a number of rows for which there is no memory; `label`: first words of the error."""
        columns = self._values.shape[1]
        try:
            np.empty((int(min(rows, 1e15)), columns + 1))
        except (MemoryError, ValueError) as error:  # ValueError: more than any array may have
            text = f"{label}: save asks for {rows:.3g} instants of {columns} signals, {8e-9 * rows * columns:.3g} GB"
            raise InputError(f"{text}. Save fewer instants, or fewer signals: signals=[...].") from error

    def expect(self, rows: int) -> None:
        """Reserve memory for a number of rows, at most MOST_RESERVED_BYTES."""
        if self.count == 0:
            rows = max(1, min(rows, MOST_RESERVED_BYTES // max(8 * self._values.shape[1], 1)))
            self._times, self._values = np.empty(rows), np.empty((rows, self._values.shape[1]))

    def add(self, times: np.ndarray, values: np.ndarray) -> None:
        """Append rows (n, columns) at times (n,)."""
        end = self.count + len(times)
        if end > len(self._times):
            self._resize(max(end, self.count + self.count // 2))
        self._times[self.count : end], self._values[self.count : end] = times, values
        self.count = end

    def add_one(self, time: float, signals: np.ndarray) -> None:
        """Append one row, of all signals (n_y,)."""
        self.add(np.array([time]), self._chosen(signals)[None, :])

    def add_end(self, time: float, signals: np.ndarray, tolerance: float) -> None:
        """Append the row of all signals (n_y,) at the end of a run [s], unless the last row is of that time."""
        if not self.is_at(time, tolerance):
            self.add_one(time, signals)

    def is_at(self, time: float, tolerance: float) -> bool:
        """Whether the last row is of that time [s]."""
        return self.count > 0 and abs(float(self._times[self.count - 1]) - time) <= tolerance

    def replace_last(self, signals: np.ndarray) -> None:
        """Replace the last row by other signals (n_y,)."""
        self._values[self.count - 1] = self._chosen(signals)

    def shorten(self, rows: int) -> None:
        """Keep the first `rows` rows alone."""
        self.count = min(self.count, rows)

    def finished(self) -> tuple[np.ndarray, np.ndarray]:
        """Times (n,) and values (n, columns), read-only."""
        self._resize(self.count)
        for array in (self._times, self._values):
            array.setflags(write=False)
        return self._times, self._values

    def _chosen(self, signals: np.ndarray) -> np.ndarray:
        return signals if self.kept is None else signals[self.kept]

    def _resize(self, rows: int) -> None:
        if rows == len(self._times):
            return
        if not self._times.flags.writeable:  # what was handed out stays as it is
            self._times, self._values = self._times.copy(), self._values.copy()
        for array, shape in ((self._times, (rows,)), (self._values, (rows, self._values.shape[1]))):
            array.resize(shape, refcheck=False)
