"""Columns of section points, made ready for a verdict: angles on their circle, constant ones left out."""

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
"""Part of the largest signal of the same unit that a signal's size is taken for at least."""

SEPARATE = 10.0
"""A signal whose spread is below this multiple of the floor tells cycles from other motions no more."""


@dataclass(frozen=True)
class Columns:
    """Signals of a section that say something.

    Parameters
    ----------
    values : (n, m) in their units; an angle that goes all the way round has two columns, its cosine and sine.
    names : name of the signal of each column (m,).
    floor : (m,) differences that are round-off or integration error.
    spread : (m,) standard deviations over the second half of the record.
    left_out : names of the signals that say nothing.
    """

    values: np.ndarray
    names: tuple[str, ...]
    floor: np.ndarray
    spread: np.ndarray
    left_out: tuple[str, ...]


def points_of(points: Any, names: Sequence[str]) -> tuple[np.ndarray, tuple[str, ...]]:
    """Points as (n, m) float64 and their names, or `InputError`."""
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
    """Columns that say something.

    Parameters
    ----------
    values : points (n, m), finite.
    names : their names.
    units : their units; "rad" is an angle, taken modulo 2 pi.  None: a signal that grows by whole turns is one.
    driven : names of signals that drives prescribe.
    floor : part of a signal's size that is round-off or integration error.
    sizes : sizes of the signals (m,); None: the largest magnitude of each, and at least 1e-3 of that of the largest
        one of the same unit.
    """
    if sizes is None:
        sizes = _sizes(values, units)
    kept: list[tuple[str, np.ndarray, float]] = []
    left_out = []
    for k, name in enumerate(names):
        column = values[:, k]
        angle = units[k] == "rad" if units is not None else _turns(column)
        parts, size = _on_circle(column) if angle else ([column], float(sizes[k]))
        turned = angle and max(np.ptp(part) for part in parts) <= floor * size and np.ptp(column) >= TURN / 2
        if name in driven or turned:
            left_out.append(name)
        else:
            kept += [(name, part, floor * float(size)) for part in parts]
    half = len(values) // 2
    table = np.stack([part for _, part, _ in kept], axis=1) if kept else np.empty((len(values), 0))
    return Columns(
        table, tuple(name for name, _, _ in kept), np.array([f for _, _, f in kept]), table[half:].std(axis=0),
        tuple(left_out),
    )  # fmt: skip


def _sizes(values: np.ndarray, units: Sequence[str] | None) -> np.ndarray:
    """Sizes (m,) of signals from their points (n, m).

    A velocity that is always 0 at the section is not measured by its own round-off.
    """
    own = np.abs(values).max(axis=0)
    if units is None:
        return own
    group = [max(own[j] for j, other in enumerate(units) if other == unit) for unit in units]
    return np.maximum(own, GROUP * np.array(group))


def _turns(column: np.ndarray) -> bool:
    """Whether a signal grows by the same whole number of turns in every step: an angle that a drive turns."""
    steps = np.diff(column)
    turns = np.round(steps.mean() / TURN)
    return bool(turns != 0 and np.abs(steps - turns * TURN).max() < 1e-6)


def _on_circle(angle: np.ndarray) -> tuple[list[np.ndarray], float]:
    """An angle about its mean direction, or its cosine and sine if it goes round; and its size [rad or 1]."""
    centre = np.angle(np.exp(1j * angle).mean())
    near = np.angle(np.exp(1j * (angle - centre)))
    if np.abs(near).max() < 0.9 * np.pi:
        return [near], TURN / 2
    return [np.cos(angle), np.sin(angle)], 1.0
