"""Measures of signals over a run, with their derivatives: mean, root of the mean square, peak, value at the end."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from flexmb import checks
from flexmb.errors import InputError
from flexmb.fields import Input, between, field, instance, one_of, record
from flexmb.run.saving import SAME_INSTANT

KINDS = ("mean", "rms", "peak", "end")  # kinds of measures that a signal has by its name
EXTREMES = ("peak", "largest", "smallest")  # kinds whose derivatives jump where another instant takes over


@record
class Measure(Input):
    """A number of a signal over a whole run; `mean`, `rms`, `peak`, `largest`, `smallest` and `at_end` make it.

    Raises
    ------
    InputError : an unknown kind; a norm below 1.
    """

    kind: str = field('"mean", "rms", "peak", "largest", "smallest" or "end"', rule=one_of(*KINDS, *EXTREMES[1:]))
    signal: str = field("name of a signal", rule=instance(str, "the name of one, such as 'slider.ax'"))
    norm: float | None = field("order of a smooth peak, see `peak`", rule=between(1.0, 1e6), default=None)

    @property
    def name(self) -> str:
        """Name in tables: "peak of O.force"."""
        order = "" if self.norm is None else f" (p = {self.norm:g})"
        return f"{self.kind}{order} of {self.signal}"

    def __le__(self, value: float) -> Limit:
        """Limit: this measure at most a value."""
        return Limit(self, checks.number("Limit", self.name, value), -1.0)

    def __ge__(self, value: float) -> Limit:
        """Limit: this measure at least a value."""
        return Limit(self, checks.number("Limit", self.name, value), 1.0)


class Limit(NamedTuple):
    """A limit of a measure: at most a value (sign -1) or at least a value (sign 1)."""

    measure: Measure
    value: float
    sign: float

    def __bool__(self) -> bool:
        """Refusal of a chain, 1 <= measure <= 2, of which Python would keep one part without a word."""
        raise InputError(f"Limit {self.text}: a limit is neither true nor false; give two limits in place of a chain.")

    @property
    def text(self) -> str:
        """Words in tables."""
        return f"{self.measure.name} {'<=' if self.sign < 0.0 else '>='} {self.value:g}"

    def room(self, amount: float) -> float:
        """Distance of a measure from its limit; negative: violated."""
        return self.sign * (amount - self.value)


def mean(signal: str) -> Measure:
    """Mean of a `signal`, by its name, over the run."""
    return Measure("mean", signal)


def rms(signal: str) -> Measure:
    """Root of the mean square of a `signal`, by its name, over the run."""
    return Measure("rms", signal)


def at_end(signal: str) -> Measure:
    """Value of a `signal`, by its name, at the end of the run."""
    return Measure("end", signal)


def peak(signal: str, *, norm: float | None = None) -> Measure:
    """Largest absolute value over the run.

    Parameters
    ----------
    signal : name of a signal.
    norm : p of the smooth measure (mean of |s|^p)^(1/p), which lies below the peak, also as a limit, and nears it with
        growing p; None: the peak itself.  Its derivative is that of the signal at the instant of the peak, and jumps
        where another instant takes over.

    Raises
    ------
    InputError : a norm below 1.
    """
    return Measure("peak", signal, norm)


def largest(signal: str) -> Measure:
    """Largest value of a `signal`, by its name, over the run, with its sign."""
    return Measure("largest", signal)


def smallest(signal: str) -> Measure:
    """Smallest value of a `signal`, by its name, over the run, with its sign."""
    return Measure("smallest", signal)


class Rows(NamedTuple):
    """A signal at the ends of all steps, the start before them, and its derivatives."""

    # Derivatives belong to neighbours that arrive later by the time shifts: dy at t + dp shift.
    time: np.ndarray  # (n,) [s]
    y: np.ndarray  # (n,)
    slope: np.ndarray  # (n, k)
    shift: np.ndarray  # (n, k) [s] a unit of the parameter
    last: np.ndarray  # (k,) derivatives at the end of the run, at the same instant


def measured(measure: Measure, rows: Rows) -> tuple[float, np.ndarray]:
    """Value of a measure, and its derivatives (k,)."""
    # Equations (14.7) and (14.8) of docs/theory/design.md.
    y, slope = rows.y, rows.slope
    if measure.kind in ("end", "mean"):
        return _mean(rows) if measure.kind == "mean" else (float(y[-1]), rows.last)
    if measure.kind in EXTREMES and measure.norm is None:
        height = {"peak": np.abs(y), "largest": y, "smallest": -y}[measure.kind]
        value, change = _crest(rows, int(height.argmax()))
        return (-value, -change) if measure.kind == "peak" and value < 0.0 else (value, change)
    p = 2.0 if measure.norm is None else measure.norm
    largest = float(np.abs(y).max()) or 1.0
    part = np.abs(y) / largest
    inner = p * part ** (p - 1.0) * np.sign(y) / largest
    value, change = _mean(rows._replace(y=part**p, slope=inner[:, None] * slope))
    if value == 0.0:
        return 0.0, np.zeros(slope.shape[1])
    root = value ** (1.0 / p)
    return largest * root, largest * root / (p * value) * change


def _crest(rows: Rows, k: int) -> tuple[float, np.ndarray]:
    """Value of the extremum next to row k, on the parabola through it and its neighbours, and its derivatives."""
    # Equation (14.9) of docs/theory/design.md.
    time, y, slope, last = rows.time, rows.y, rows.slope, len(rows.y) - 1
    near, around = slice(k - 1, k + 2), slice(max(k - 2, 0), k + 3)
    h, change = np.diff(time[around]), np.diff(y[around])
    bends = change[1:] * h[:-1] - change[:-1] * h[1:]  # a jump beside the row bends the other way
    smooth = abs(np.sign(bends).sum()) == len(bends) and h.min() > SAME_INSTANT * h.max()
    if k in (0, last) or not smooth or np.ptp(rows.shift[near], axis=0).any():  # the end, a jump, an onset: no parabola
        onset = (rows.shift[min(k + 1, last)] - rows.shift[k]) * _rate(rows)[k]  # a neighbour goes on as it came
        return float(y[k]), rows.last if k == last else slope[k] + onset
    a, b = time[k] - time[k - 1], time[k + 1] - time[k]
    left, right = (y[k] - y[k - 1]) / a, (y[k + 1] - y[k]) / b
    bend = (right - left) / (a + b)
    x = -0.5 * (left + a * bend) / bend  # from time[k]
    weights = np.array([x * (x - b) / (a * (a + b)), (x + a) * (b - x) / (a * b), x * (x + a) / (b * (a + b))])
    return float(weights @ y[near]), weights @ slope[near]


def _rate(rows: Rows) -> np.ndarray:
    """Rate (n, 1) of the signal at the end of each step, from the step before."""
    h = np.diff(rows.time)
    return np.concatenate([[0.0], np.divide(np.diff(rows.y), h, out=np.zeros(len(h)), where=h > 0.0)])[:, None]


def _mean(rows: Rows) -> tuple[float, np.ndarray]:
    """Mean by the trapezoidal rule, and its derivatives."""
    # Where the time shift changes, at the onset of a contact, a neighbour goes on for that time as it came.
    h, span, y, slope = np.diff(rows.time)[:, None], rows.time[-1] - rows.time[0], rows.y[:, None], rows.slope
    later = np.diff(rows.shift, axis=0)
    before = slope[:-1] + later * _rate(rows)[:-1]
    change = (0.5 * h * (before + slope[1:]) + later * y[:-1]).sum(axis=0) - rows.shift[-1] * y[-1]
    return float((0.5 * h * (y[:-1] + y[1:])).sum() / span), change / span
