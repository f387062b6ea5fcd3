"""Prescribed motions: rates that belong to their values, jumps that are announced, tables that do not overshoot."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from flexmb.doctor.finding import Finding, found
from flexmb.drives.table import Table
from flexmb.errors import USER_ERRORS
from flexmb.kernels import Kernel
from flexmb.model.law import Motion
from flexmb.model.mechanism import Mechanism

PLACES = 64
"""Number of instants at which rates are compared with differences, and of intervals that are searched for jumps."""

SPAN_WITHOUT_PERIOD = 1.0
"""Time that is looked at, of a motion without period or breaks [s]."""

DIFFERENCE = 1e-5
"""Step of the differences, relative to that time."""

MISMATCH = 1e-3
"""Difference relative to the largest rate, or to the range of the value, above which something is wrong."""

HALVINGS = 40
"""Number of halvings by which a jump is located."""

MOST_OVERSHOOT = 0.1
"""Overshoot of a table's spline between two points, relative to the range of its values, above which it is told."""


def motions_by_part(mechanism: Mechanism) -> Iterator[tuple[str, Motion]]:
    """Every prescribed motion and history, with the name of its part."""
    for part in mechanism.parts:
        for value in vars(part).values():
            if isinstance(value, Motion):
                yield part.name, value


def motion_findings(mechanism: Mechanism) -> list[Finding]:
    """Findings on all motions of a mechanism."""
    findings: list[Finding] = []
    for name, motion in motions_by_part(mechanism):
        if isinstance(motion, Table):
            findings += overshoot(name, motion)
        findings += wrong_rates(name, motion)
    return findings


def wrong_rates(name: str, motion: Motion) -> list[Finding]:
    """Findings on rates that are not the derivatives of their values, on jumps, and on values that are not finite."""
    breaks = tuple(motion.breaks(1e3))
    span = motion.period or max([SPAN_WITHOUT_PERIOD, *(1.2 * t for t in breaks)])
    p = np.array(motion.parameters(), dtype=float)

    def at(t: float) -> np.ndarray:
        return values_of(motion.kernel, p, float(t))

    times = span * (np.arange(PLACES) + 0.381966) / PLACES
    values = np.array([at(t) for t in times])
    if not np.isfinite(values).all():
        t = float(times[np.flatnonzero(~np.isfinite(values).all(axis=1))[0]])
        text = f"The motion of {name!r} {reason_of(motion.kernel, p, t)} at t = {t:.6g} s."
        remedy = "Let its kernel return three finite numbers at every t; after its end a motion stands still."
        return [found("broken-kernel", (name,), text, remedy, time=t)]
    findings = [*_wrong_rate(name, at, times, values, span, 0), *_wrong_rate(name, at, times, values, span, 1)]
    return findings or _jump(name, at, np.linspace(0.0, span, PLACES + 1), breaks)


def values_of(kernel: Kernel, *arguments: Any) -> np.ndarray:
    """Numbers that a kernel returns, in plain Python; NaN where it raises an exception."""
    try:
        with np.errstate(all="ignore"):
            return np.atleast_1d(np.array(kernel(*arguments), dtype=float))
    except USER_ERRORS:
        return np.full(3, np.nan)


def reason_of(kernel: Kernel, *arguments: Any) -> str:
    """Words on a kernel whose numbers are not finite: the error that it raises, or that it is not finite."""
    try:
        with np.errstate(all="ignore"):
            np.array(kernel(*arguments), dtype=float)
    except USER_ERRORS as error:
        return f"fails with {type(error).__name__} ({error})"
    return "is not finite"


def _wrong_rate(
    name: str, at: Callable[[float], np.ndarray], times: np.ndarray, values: np.ndarray, span: float, k: int
) -> list[Finding]:
    """Finding on derivative k + 1 of a motion that differs from differences of derivative k at most instants."""
    words = ("value", "rate", "second derivative")
    h = DIFFERENCE * span
    wide, narrow = (
        np.array([(at(t + step)[k] - at(t - step)[k]) / (2.0 * step) for t in times]) for step in (h, 0.5 * h)
    )
    round_off = 1e-15 * np.abs(values[:, k]).max() / h
    wrong = np.abs(narrow - values[:, k + 1])
    largest = max(np.abs(values[:, k + 1]).max(), np.abs(narrow).max())
    bad = wrong > MISMATCH * largest + 10.0 * np.abs(wide - narrow) + 100.0 * round_off
    if bad.mean() <= 0.5:
        return []
    worst = int(np.argmax(np.where(bad, wrong, 0.0)))
    text = f"The {words[k + 1]} of {name!r} is not the derivative of its {words[k]}: at t = {times[worst]:.6g} s the"
    text = f"{text} kernel returns {values[worst, k + 1]:.6g}, differences give {narrow[worst]:.6g}."
    remedy = "Let the kernel return s, ds/dt and d2s/dt2 of one function."
    return [found("wrong-rate", (name,), text, remedy, time=times[worst], difference=wrong[worst])]


def _jump(name: str, at: Callable[[float], np.ndarray], edges: np.ndarray, breaks: tuple[float, ...]) -> list[Finding]:
    """Finding on a value that jumps at an instant that is no break."""
    ends = np.array([at(t) for t in edges])
    size = max(float(np.ptp(ends[:, 0])), 1e-300)
    for k in np.argsort(-np.abs(np.diff(ends[:, 0]) - 0.5 * np.diff(edges) * (ends[1:, 1] + ends[:-1, 1])))[:8]:
        low, high = float(edges[k]), float(edges[k + 1])
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            first, last = (abs(at(b)[0] - at(a)[0]) for a, b in ((low, middle), (middle, high)))
            low, high = (low, middle) if first > last else (middle, high)
        jump = float(at(high)[0] - at(low)[0])
        announced = any(abs(t - high) <= 1e-6 * edges[-1] for t in breaks)
        if abs(jump) > MISMATCH * size and not announced:
            text = f"The value of {name!r} jumps by {jump:.4g} at t = {high:.6g} s."
            remedy = "Make it continuous, or let `breaks` return that instant; a joint needs a value without jumps."
            return [found("jumping-drive", (name,), text, remedy, time=high, jump=jump)]
    return []


def overshoot(name: str, table: Table) -> list[Finding]:
    """Finding on a spline that leaves the range of two neighbouring points by much."""
    times, values = np.array(table.times), np.array(table.values)
    p = np.array(table.parameters(), dtype=float)
    whole = float(np.ptp(values))
    worst, at = 0.0, 0
    for k in range(len(times) - 1):
        between = [table.kernel(p, float(t))[0] for t in np.linspace(times[k], times[k + 1], 12)[1:-1]]
        low, high = sorted((values[k], values[k + 1]))
        beyond = max(max(between) - high, low - min(between))
        if beyond > worst:
            worst, at = float(beyond), k
    if worst <= MOST_OVERSHOOT * whole or whole == 0.0:
        return []
    text = f"The table of {name!r} overshoots its points by {worst:.4g} between t = {times[at]:.6g} and"
    text = f"{text} {times[at + 1]:.6g} s, where they differ by {abs(values[at + 1] - values[at]):.4g}."
    remedy = "Give points of nearly even distance, or use PiecewiseLinear for loads and CycloidalRamp for drives."
    return [found("overshooting-table", (name,), text, remedy, time=times[at], overshoot=worst)]
