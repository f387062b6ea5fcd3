"""Columns of section points for a verdict: angles on their circle, without constant and driven signals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmb import checks
from flexmb.errors import InputError
from flexmb.series.samples import real_numbers

TURN = 2.0 * np.pi

GROUP = 1e-3
"""Smallest size of a signal, over the size of the largest signal of the same unit."""

SEPARATE = 10.0
"""Multiple of the floor below which the spread of a signal cannot distinguish a cycle from other motions."""


@dataclass(frozen=True)
class Columns:
    """Signals of section points that a verdict can use.

    Parameters
    ----------
    values : points (n, m) in their units; a rotating angle has two columns, cosine and sine.
    names : name of the signal of each column (m,).
    floor : differences (m,) that are round-off or integration error.
    spread : standard deviations (m,) over the second half of the record.
    left_out : names of the signals without information.
    """

    values: np.ndarray
    names: tuple[str, ...]
    floor: np.ndarray
    spread: np.ndarray
    left_out: tuple[str, ...]


def points_of(points: Any, names: Sequence[str]) -> tuple[np.ndarray, tuple[str, ...]]:
    """Points as (n, m) float64, and the names of their signals; see `judge`."""
    labels = checks.sequence("judge", "names", names, "names of signals")
    values = real_numbers(points)
    if values is None:
        raise InputError("judge: the points are no table of numbers (n, m): successive points, signals.")
    if values.ndim == 1 and len(labels) == 1:
        values = values[:, None]
    if values.ndim != 2 or values.shape[1] != len(labels):
        text = f"judge: the points have shape {values.shape} for {len(labels)} names; it must be (n, {len(labels)})"
        raise InputError(f"{text}: successive points, signals.")
    return values, tuple(str(label) for label in labels)


def columns_of(
    values: np.ndarray,
    names: tuple[str, ...],
    units: Sequence[str] | None,
    driven: Sequence[str],
    floor: float,
    sizes: np.ndarray | None,
) -> Columns:
    """Columns of the signals with information, of finite points (n, m) with names, units and sizes (m,).

    The unit "rad" is an angle, taken modulo 2 pi; without units a signal that grows by whole turns is an angle.
    `driven` are signals that drives prescribe; `floor` is the round-off or integration error of a signal over its size.
    Without sizes they are the largest magnitude of each signal, and at least 1e-3 of the largest magnitude of the same
    unit.
    """
    if sizes is None:
        sizes = _sizes(values, units)
    columns: list[tuple[str, np.ndarray, float]] = []
    left_out = []
    for k, name in enumerate(names):
        column = values[:, k]
        angle = units[k] == "rad" if units is not None else _turns(column)
        entries, size = _on_circle(column) if angle else ([column], float(sizes[k]))
        turned = angle and max(np.ptp(entry) for entry in entries) <= floor * size and np.ptp(column) >= TURN / 2
        if name in driven or turned:
            left_out.append(name)
        else:
            columns += [(name, entry, floor * float(size)) for entry in entries]
    half = len(values) // 2
    table = np.stack([column for _, column, _ in columns], axis=1) if columns else np.empty((len(values), 0))
    floors = np.array([column_floor for _, _, column_floor in columns])
    labels = tuple(name for name, _, _ in columns)
    return Columns(table, labels, floors, table[half:].std(axis=0), tuple(left_out))


def _sizes(values: np.ndarray, units: Sequence[str] | None) -> np.ndarray:
    """Sizes (m,) of signals from their points (n, m).

    A velocity that is always 0 at the section does not have its own round-off as its size.
    """
    own = np.asarray(np.abs(values).max(axis=0))
    if units is None:
        return own
    group = [max(own[j] for j, other in enumerate(units) if other == unit) for unit in units]
    return np.asarray(np.maximum(own, GROUP * np.array(group)))


def _turns(column: np.ndarray) -> bool:
    """Whether a signal grows by an equal integer number of turns in every step, as a driven angle."""
    steps = np.diff(column)
    turns = np.round(steps.mean() / TURN)
    return bool(turns != 0 and np.abs(steps - turns * TURN).max() < 1e-6)


def _on_circle(angle: np.ndarray) -> tuple[list[np.ndarray], float]:
    """Columns of an angle, and their size [rad or 1]: the angle about its mean direction, or cosine and sine."""
    centre = np.angle(np.exp(1j * angle).mean())
    near = np.angle(np.exp(1j * (angle - centre)))
    if np.abs(near).max() < 0.9 * np.pi:
        return [near], TURN / 2
    return [np.cos(angle), np.sin(angle)], 1.0
