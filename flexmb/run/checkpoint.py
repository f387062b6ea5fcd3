"""Checkpoints of a run: a results file (results/netcdf.py) whose group `restart` also has counters, peaks and poses."""

from __future__ import annotations

import re
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from hashlib import blake2b
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from flexmb import checks
from flexmb.engine.compiled.records import fitting
from flexmb.engine.state.flow import Clock
from flexmb.errors import FileFormatError, InputError
from flexmb.program.program import Program
from flexmb.results.contact_intervals import COLUMNS
from flexmb.results.netcdf import load
from flexmb.results.solution import Peaks, Solution

if TYPE_CHECKING:
    from flexmb.run.run import Run

MODEL = "model"  # name of the fingerprint of the program in a restart
# What differs, by the row of the fingerprint.
DIFFERENCES = (
    "names or kernels of its parts differ",
    "the same parts have other numbers (masses, lengths, clearances, gravity, ...)",
    "the same parts are wired otherwise (bodies that they act on, inputs and instants of controllers, ...), or "
    "numbers differ that their functions take from outside",
)


def refuse_broken_clock(clock: Clock, label: str) -> None:
    """Refuse a restart with times, steps or counters that no run has, as one that saves later than it stands."""
    numbers, least = clock.numbers(), Clock.zeros()
    least.save_start = least.held_steps = -1.0
    if not np.isfinite(numbers).all() or (numbers < least.numbers()).any() or clock.save_start > clock.t:
        text = f"{label}: restart is damaged: its clock holds {numbers.tolist()}, negative or not finite,"
        raise InputError(f"{text} or with a begin of saving after the present. Use an undamaged one.")


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
    text = f"{label}: restart is of another mechanism: {other}. Use `restart` of a solution of this mechanism;"
    raise InputError(f"{text} its energies and contacts would not fit another one.")


# Checkpoints of a run: all that a run needs to go on as if it had never been interrupted, in one file

EVERY = 30.0  # time between two checkpoints [s on the clock]
COMMAND = "checkpoint"  # name of the arguments of the run in `Solution.model`
POSES = "poses."  # begin of the names of the poses that a run keeps
# Checkpoints of ended runs whose files are still there; None: their files are removed at once.
_LEFT: ContextVar[list[Checkpoints] | None] = ContextVar("left", default=None)
END_COLUMN = [name for name, _ in COLUMNS].index("end")


class Checkpoints:
    """The checkpoint file of a run, written every so many seconds on the clock while the run goes on."""

    # `command` holds the arguments of the run as plain values; a checkpoint of other arguments is refused.
    # `model`: name of the mechanism and other plain values for the record.

    def __init__(self, path: str | Path, every: float, command: Mapping[str, Any], model: Mapping[str, Any]) -> None:
        self.path, self.every = checks.path("checkpoint", path), checks.not_negative("checkpoint", "every", every, "s")
        if self.path.is_dir():  # "" is the present one
            text = f"checkpoint: the path is {str(path)!r}, {'a folder' if str(path) else 'empty'}"
            raise InputError(f"{text}. Give a file, such as run.checkpoint.nc.")
        self.command, self.model = dict(command), dict(model)
        self.last, self.failure = time.monotonic(), ""

    def after_block(self, run: Run) -> None:
        """Write a checkpoint if it is time; a file that cannot be written is noted, and the run goes on."""
        if time.monotonic() - self.last >= self.every:
            self.write(run)

    def write(self, run: Run) -> None:
        """Write a checkpoint now."""
        try:
            sol, record = run.solution({**self.model, COMMAND: self.command}), run.record
            more = {  # all counters and peaks beside the usual restart
                "peak": record.peak.copy(),
                "peak_time": record.peak_time.copy(),
                "held_rows": record.held_rows.astype(np.uint8),
                "count": record.count.numbers(),
                "report": record.report.numbers(),
                "lows": record.lows.copy(),
                "earlier": np.array([run.earlier.values, run.earlier.times]),
                **{f"{POSES}{name}": array for name, array in record.poses.saved().items()},
            }
            object.__setattr__(sol, "restart", {**sol.restart, **more})
            sol.to_netcdf(self.path)
        except InputError as error:
            self.failure = self.failure or f"No checkpoint since t = {run.flow.clock.t:.6g} s: {error}"
            self.last = time.monotonic() + EVERY  # the disk may have room again
        else:
            self.failure, self.last = "", time.monotonic()  # slow writes do not follow one another without a step

    def resume(self, run: Run, label: str, *, redundant: bool) -> None:
        """Let a run go on from the file."""
        # Refused: no such file, a damaged one, a checkpoint of another run or of another mechanism.
        try:
            sol = load(self.path)
        except FileFormatError as error:
            text = re.split(" (?:Write|Run) it again", str(error))[0]
            raise FileFormatError(f"{label}: {text} Remove this checkpoint; the run then starts anew.") from error
        given = sol.model.get(COMMAND)
        if not isinstance(given, dict):
            raise FileFormatError(f"{label}: {str(self.path)!r} is no checkpoint; it is a finished result.")
        for name, value in self.command.items():
            if given.get(name) != value:
                text = f"{label}: the checkpoint {str(self.path)!r} belongs to a run with {name} = {given.get(name)!r}"
                raise InputError(f"{text}, not {value!r}. Resume with the same arguments, or remove the file.")
        run.resume(sol.restart, label, redundant=redundant)
        try:
            adopt(run, sol)
        except (ValueError, LookupError) as error:
            text = f"{label}: the checkpoint {str(self.path)!r} is damaged ({error})"
            raise FileFormatError(f"{text}. Remove it; the run then starts anew.") from error

    def finish(self) -> str:
        """Remove the file of a run that has reached its end, or leave that to `removed_after`; a remark, or ""."""
        left = _LEFT.get()
        if left is None:
            return self.remove()
        left.append(self)
        return ""

    def remove(self) -> str:
        """Remove the file; a remark on one that cannot be removed, or ""."""
        try:
            if self.path.is_file():  # no device, as /dev/null
                self.path.unlink()
        except ValueError:
            return ""  # there was none
        except OSError as error:
            return f"The checkpoint {str(self.path)!r} cannot be removed ({error.strerror or error}). Remove it."
        return ""


@contextmanager
def removed_after() -> Iterator[list[Checkpoints]]:
    """A block that writes the results of its runs, whose checkpoints are removed at its end."""
    # After an error they stay. Where one cannot be removed, its `failure` says so.
    left: list[Checkpoints] = []
    token = _LEFT.set(left)
    try:
        yield left
    except InputError as error:
        kept = [str(one.path) for one in left if one.path.is_file()]
        if not kept:
            raise
        raise InputError(f"{error} The checkpoint {kept[0]!r} is kept: go on from it, --resume.") from error
    finally:
        _LEFT.reset(token)
    for one in left:
        one.failure = one.remove()


def adopt(run: Run, sol: Solution) -> None:
    """Give a run the saved instants, contact intervals, peaks and counters of its checkpoint."""
    record, kept = run.record, sol.restart
    if sol.values.shape[1] != len(run.saved.finished()[1].T):
        raise ValueError("its signals are others")
    if len(sol.time):
        run.saved.add(sol.time, sol.values)
    ended = sol.contacts.rows[~np.isnan(sol.contacts.rows[:, END_COLUMN])]
    if len(ended):
        run.episodes.append(np.array(ended))
    for name in ("peak", "peak_time", "held_rows", "lows"):
        target = getattr(record, name)
        target[:] = fitting(kept, name, target).astype(target.dtype)
    record.count.set_numbers(fitting(kept, "count", record.count.numbers()))
    record.report.set_numbers(fitting(kept, "report", record.report.numbers()))
    run.earlier = Peaks(*fitting(kept, "earlier", np.array([run.earlier.values, run.earlier.times])))
    record.poses.restore({name.removeprefix(POSES): array for name, array in kept.items() if name.startswith(POSES)})
    # counters that compiled code takes for indices must not be beyond the sizes of this run
    most = {"rows": 0, "episodes": 0, "lost_pivot": run.program.n_q + run.program.n_c - 1}
    most |= {"rejecting_contact": len(run.program.names.contacts), "poses": len(record.poses.times) - 1}
    given = {**record.count.as_dict(), "poses": record.poses.number.count}
    for name, limit in most.items():
        if not 0 <= given[name] <= limit:
            raise ValueError(f"its counter {name!r} is {given[name]}")
    run.saving = float(run.flow.clock.save_start) >= 0.0


def digest(restart: Mapping[str, Any] | None) -> str:
    """Digest of the arrays of a restart; "" without a restart."""
    if not isinstance(restart, Mapping):
        return ""
    data = b"".join(name.encode() + np.ascontiguousarray(restart[name]).tobytes() for name in sorted(restart))
    return blake2b(data, digest_size=8).hexdigest()


def plain_values(**arguments: Any) -> dict[str, Any]:
    """Arguments of a run as plain values, for the comparison with a checkpoint."""
    return {name: value if isinstance(value, int | float | str) else repr(value) for name, value in arguments.items()}
