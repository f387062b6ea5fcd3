"""Saved signals: places of names and patterns, and messages about unknown names."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from flexmb import checks
from flexmb.errors import InputError
from flexmb.model.signal import hint, resolved

if TYPE_CHECKING:
    from flexmb.program.program import Program

SAVED_KEY = "signals"
"""Key of `Solution.model` for the chosen signals, where not all were saved."""


def chosen_places(owner: str, program: Program, wanted: object) -> np.ndarray | None:
    """Places (n,) of the chosen signals, ascending, each once; None where that is all.

    Integrals and rates of states of controls are chosen by their whole names alone.  `wanted` is None for the signals
    of `Program.reported`, or a list of names of signals, and patterns in which * stands for any text: "slider.x",
    "coupler.*", "*.force".  A name that is no signal, and a pattern that fits none, are refused.
    """
    if wanted is None:
        return program.shown
    signals, aliases = program.names.signals, program.names.aliases
    found: set[int] = set()
    for name in checks.sequence(owner, "signals", wanted, "names such as 'slider.x' or 'slider.*'"):
        if not isinstance(name, str):
            raise InputError(f"{owner}: signals holds {name!r}; it must hold names such as 'slider.x' or 'slider.*'.")
        own = resolved(name, signals, aliases)
        if own in signals.places:
            found.add(signals.places[own])
            continue
        fitting = matching(program.reported.names, own) if "*" in own else []
        if not fitting:
            what = "signal fits" if "*" in own else "signal is called"
            raise InputError(f"{owner}: no {what} {name!r}. {hint(name, program.reported, aliases)}")
        found.update(signals.places[one] for one in fitting)
    return np.array(sorted(found), dtype=np.int64)


def matching(names: Sequence[str], pattern: str) -> list[str]:
    """The names that a pattern fits; its only sign is *, any text."""
    fits = re.compile(".*".join(map(re.escape, pattern.split("*")))).fullmatch
    return [name for name in names if fits(name)]
