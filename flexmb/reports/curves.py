"""Signals of a page: chosen names, their panels, and curves whose peaks survive in long runs."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np

from flexmb.errors import InputError
from flexmb.reports.packing import floats, instants
from flexmb.results.drawing import nearest_instants
from flexmb.results.main_signals import main_signals, panels
from flexmb.results.signal_names import matching
from flexmb.results.solution import Solution

MOST_CURVES = 24
"""Number of signals on a page where none are chosen."""

MOST_CHOSEN = 200
"""Number of chosen signals at most: each takes some 10 kB of a page."""

MOST_IN_PANEL = 6
"""Number of signals in a panel at most."""

ROWS_PER_FRAME = 2
"""Number of rows of a curve for each frame; longer curves become envelopes."""

NODE_DOTS = 2
"""Number of dots in the name of a signal of a node of a flexible part, at least."""


def frame_instants(sol: Solution, frames: int) -> np.ndarray:
    """Numbers of the saved instants of the frames: all, or `frames` of them evenly over the time.

    Instants with numbers that are not finite are left out.
    """
    chosen = np.arange(len(sol.time))
    if len(sol.time) > frames:
        chosen = nearest_instants(sol, np.linspace(sol.time[0], sol.time[-1], frames))
    return chosen[np.isfinite(sol.values[chosen]).all(axis=1)] if len(chosen) else chosen


def chosen_names(sol: Solution, signals: Any) -> list[str]:
    """Names of the signals on the page, the main ones first.

    `signals` are names and patterns in which * stands for any text; None: the main signals, energies, signals of joints
    and loads, motions of bodies, `MOST_CURVES` of them.
    """
    if signals is None:
        plain = [name for name in sol.names if name.count(".") < NODE_DOTS]
        bodies = {name.rpartition(".")[0] for name in plain if name.endswith(".alpha")}
        energies = [name for name in plain if name.startswith("energy.")]
        of_parts = [name for name in plain if name.rpartition(".")[0] not in {*bodies, "energy"}]
        names = [*main_signals(sol), *energies, *_in_turn(of_parts), *plain]
        return list(dict.fromkeys(names))[:MOST_CURVES]
    if isinstance(signals, str):
        raise InputError(f"report: signals is {signals!r}; it must be a list of names, e.g. [{signals!r}].")
    found: dict[str, None] = {}
    for name in signals:
        fitting = matching(sol.names, name) if "*" in str(name) else []
        found |= dict.fromkeys(fitting or [str(sol[name].attrs["name"])])
    if len(found) > MOST_CHOSEN:
        raise InputError(f"report: signals are {len(found)} signals; a page holds {MOST_CHOSEN} at most. Choose fewer.")
    return list(found)


def _in_turn(names: list[str]) -> list[str]:
    """Names ordered so that the first signal of every part comes before the second one of any part."""
    parts: dict[str, list[str]] = {}
    for name in names:
        parts.setdefault(name.rpartition(".")[0], []).append(name)
    longest = max(map(len, parts.values()), default=0)
    return [own[k] for k in range(longest) for own in parts.values() if k < len(own)]


def curves(sol: Solution, names: list[str], frames: np.ndarray) -> dict[str, Any]:
    """Signals for the page: values at the frames, and curves over the time.

    A curve with more rows than `ROWS_PER_FRAME` for each frame becomes an envelope: for each of as many equal shares of
    the rows as there are frames, the smallest and the largest value, in the order in which they occur.
    """
    values = np.stack([sol.array(name) for name in names], axis=1) if names else np.zeros((len(sol.time), 0))
    first = panels(sol, None if set(main_signals(sol)) <= set(names) else names) or [names[:1]]
    found: dict[str, Any] = {
        "names": names,
        "units": [sol.units(name) for name in names],
        "panels": [panel[:MOST_IN_PANEL] for panel in first],
        "time": instants(sol.time[frames]),
    }
    if len(sol.time) <= ROWS_PER_FRAME * len(frames) + 1:
        return {**found, "rows": frames.tolist(), "abscissae": instants(sol.time), "curves": floats(values)}
    times, narrow = envelope(sol.time, values, len(frames))
    at_frames = floats(values[frames])
    return {**found, "at_frames": at_frames, "abscissae": instants(times), "curves": floats(narrow), "envelope": True}


def envelope(time: np.ndarray, values: np.ndarray, buckets: int) -> tuple[np.ndarray, np.ndarray]:
    """Smallest and largest values (2 b, m) of b shares of the rows, and times (2 b,) [s] within these shares.

    Times are (n,) [s], values (n, m); numbers that are not finite are left out.  b is n / 2 at most.
    """
    edges = np.linspace(0, len(time), buckets + 1).astype(int)
    times, narrow = np.empty(2 * buckets), np.empty((2 * buckets, values.shape[1]))
    columns = np.arange(values.shape[1])
    for k, (begin, end) in enumerate(pairwise(edges)):
        share = values[begin:end]
        low = np.argmin(np.where(np.isfinite(share), share, np.inf), axis=0)
        high = np.argmax(np.where(np.isfinite(share), share, -np.inf), axis=0)
        first, second = np.minimum(low, high), np.maximum(low, high)
        narrow[2 * k], narrow[2 * k + 1] = share[first, columns], share[second, columns]
        times[2 * k], times[2 * k + 1] = time[begin], time[(begin + end) // 2]
    return times, narrow
