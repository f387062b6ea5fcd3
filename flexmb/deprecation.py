"""Former names: taken until a version that the warning tells (docs/stability.md)."""

import sys
import warnings

INNER = ("flexmb", "numpy")  # packages between a former name and the line of its user


def warn_of_former(label: str, old: str, now: str, goes: str) -> None:
    """Warn at the line of the user that `old` is called `now`, and `goes` with a version."""
    frame, level = sys._getframe(), 1
    while frame.f_back is not None and frame.f_globals.get("__name__", "").partition(".")[0] in INNER:
        frame, level = frame.f_back, level + 1
    text = f"{label}: {old} is called {now} now; the former name goes with version {goes}."
    warnings.warn(text, DeprecationWarning, stacklevel=level)
