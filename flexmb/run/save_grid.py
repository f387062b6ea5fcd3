"""Saved instants of a run: a number a period, an interval, given times, or every step."""

from __future__ import annotations

from collections.abc import Iterable
from numbers import Integral, Real
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from flexmb import checks
from flexmb.errors import InputError

if TYPE_CHECKING:
    from flexmb.run.run import Run

SAME_TIME = 1e-12
"""Difference of two instants relative to the end of a run, below which they are one."""


SAME_INSTANT = 1e-9
"""Difference of two saved instants relative to the time between them, below which they are one."""


class SaveGrid(NamedTuple):
    """Saved instants: interval, or shortest time between given times [s], 0 for every step; given times (n,) [s]."""

    interval: float
    times: np.ndarray


def save_grid(label: str, save: Any, period: float | None, begin: float, end: float, begun: float = 0.0) -> SaveGrid:
    """Saved instants from `begin` to `end` [s] for the argument `save` of `simulate`, of a run that starts at `begun`.

    A number of instants counts from `begin`, so that a run that is restarted goes on with the instants of the first.
    """
    none = np.zeros(0)
    if isinstance(save, str) and save == "steps":
        return SaveGrid(0.0, none)
    if isinstance(save, str):
        raise InputError(f"{label}: save is {save!r}; it must be a number of instants, an interval [s] or 'steps'.")
    if isinstance(save, Iterable) and np.ndim(save):  # type: ignore[arg-type] # arrays without dimensions are numbers
        return _given(label, checks.sequence(label, "save", save, "times [s]"), max(begin, begun), end)
    if isinstance(save, Real) and not isinstance(save, Integral):
        interval = checks.positive(label, "save", save, "s", "An interval of time; instants a period are an integer.")
        if interval > (span := end - max(begin, begun)):
            text = f"{label}: save is an interval of {interval:g} s, but {span:g} s are saved"
            raise InputError(f"{text}. Give a shorter one, or an integer: the number of saved instants a period.")
        return SaveGrid(interval, none)
    hint = "It is a number of instants a period of the drives (without one: of the run), an interval [s] (a float), "
    number = checks.count(label, "save", save, hint=f"{hint}times [s] (a list), or 'steps' for all.")
    return SaveGrid((end - begin if period is None or period > end - begin else period) / number, none)


def shown_save(save: Any) -> Any:
    """The argument `save` as a value that can be compared; lists and arrays by their numbers."""
    return save if isinstance(save, str | Real) else tuple(np.ravel(save).tolist())


def _given(label: str, given: tuple[Any, ...], begin: float, end: float) -> SaveGrid:
    """Grid of given times."""
    times = np.array([checks.number(label, f"save[{k}]", t, "s") for k, t in enumerate(given)])
    gaps, slack = np.diff(times), SAME_TIME * end
    if not len(times):
        raise InputError(f"{label}: save holds no times; give some, or save no signals: signals=[].")
    if (gaps <= 0.0).any():
        k = int(np.argmin(gaps)) + 1
        raise InputError(f"{label}: save[{k}] is {times[k]:g} s after {times[k - 1]:g} s; times must increase.")
    for wrong in times[(times < begin - slack) | (times > end + slack)]:
        raise InputError(f"{label}: save holds {wrong:g} s; its times must lie from {begin:g} to {end:g} s.")
    return SaveGrid(float(gaps.min(initial=end - begin)), np.clip(times, begin, end))


def start_saving(run: Run, saving: float, end: float) -> None:
    """Save the present instant, or continue the save grid of a resumed run until `end`; `saving`: its interval [s]."""
    clock, times, run.saving = run.flow.clock, run.record.save_times, True
    fresh = bool(clock.save_start < 0.0)
    clock.save_start = clock.t if fresh else clock.save_start
    if len(times):
        clock.saved_instants = float(np.searchsorted(times, clock.t + SAME_INSTANT * saving, "right"))
        fresh = run.saved.count == 0 and abs(times[0] - clock.t) <= SAME_INSTANT * saving
    elif saving > 0.0:  # counted anew, since the interval may be another one
        clock.saved_instants = np.floor((clock.t - clock.save_start) / saving + SAME_INSTANT)
    if saving > 0.0:
        run.saved.expect(len(times) or int(min((end - clock.t) / saving, 1e9)) + 2)
    if fresh:
        run.saved.add_one(clock.t, run.record.signals)


def saves_end(run: Run, end: float) -> bool:
    """Whether the last instant is saved: always with a grid, of given times if its time `end` [s] is the last."""
    times = run.record.save_times
    return len(times) == 0 or (not run.met and bool(times[-1] == end))
