"""Restart of a run: the state of one mechanism is refused by another one."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from flexmb.errors import InputError
from flexmb.program.program import Program
from flexmb.state.flow import Clock

MODEL = "model"
"""Name of the fingerprint of the program in a restart."""

DIFFERENCES = (
    "names or kernels of its parts differ",
    "the same parts have other numbers (masses, lengths, clearances, gravity, ...)",
    "the same parts are wired otherwise (bodies that they act on, inputs and instants of controllers, ...), or "
    "numbers differ that their functions take from outside",
)
"""What differs, by the row of the fingerprint."""


def refuse_broken_clock(clock: Clock, label: str) -> None:
    """Refuse a restart with times, steps or counters that no run has, as one that saves later than it stands."""
    numbers, least = clock.numbers(), Clock.zeros()
    least.save_start = least.held_steps = -1.0
    if not np.isfinite(numbers).all() or (numbers < least.numbers()).any() or clock.save_start > clock.t:
        text = f"{label}: restart is damaged: its clock holds {numbers.tolist()}"
        raise InputError(
            f"{text}, negative or not finite, or with a begin of saving after the present. Use an undamaged one."
        )


def refuse_other_model(program: Program, restart: Mapping[str, np.ndarray], label: str) -> None:
    """Refuse the restart of a mechanism of equal size with other parts or numbers."""
    given, own = restart.get(MODEL), program.fingerprint
    if given is None:
        return
    here = own[: max(len(given), 2) if np.ndim(given) else 0]  # files of former versions have no wiring
    if np.array_equal(given, here):
        return
    same = np.shape(given) == here.shape
    other = next(text for k, text in enumerate(DIFFERENCES) if not (same and np.array_equal(given[k], here[k])))
    raise InputError(
        f"{label}: restart is of another mechanism: {other}. Use `restart` of a solution of this mechanism; "
        "its energies and contacts would not fit another one."
    )
