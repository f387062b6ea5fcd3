"""Restart of a run: the state of one mechanism is refused by another one."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from flexmb.errors import InputError
from flexmb.program.program import Program

MODEL = "model"
"""Name of the fingerprint of the program in a restart."""

DIFFERENCES = (
    "names or kernels of its parts differ",
    "the same parts have other numbers (masses, lengths, clearances, gravity, ...)",
    "the same parts are wired otherwise (bodies that they act on, inputs and instants of controllers, ...), or "
    "numbers differ that their functions take from outside",
)
"""What differs, by the row of the fingerprint."""


def refuse_broken_clock(clock: np.ndarray, label: str) -> None:
    """Refuse a restart whose time, step sizes or counters are not finite: the run would never end.

    Parameters
    ----------
    clock : numbers of the clock.
    label : first words of the error.
    """
    if not np.isfinite(clock).all():
        raise InputError(f"{label}: restart is damaged: its clock holds {clock.tolist()}. Use an undamaged one.")


def refuse_other_model(program: Program, restart: Mapping[str, np.ndarray], label: str) -> None:
    """Refuse the restart of a mechanism of equal size with other parts or numbers.

    Parameters
    ----------
    program : the compiled mechanism.
    restart : arrays by name; one without a fingerprint is taken.
    label : first words of the error.
    """
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
