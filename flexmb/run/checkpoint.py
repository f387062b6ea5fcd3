"""Checkpoints of a run: all that a run needs to go on as if it had never been interrupted, in one file."""

from __future__ import annotations

import time
from collections.abc import Mapping
from hashlib import blake2b
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from flexmb import checks
from flexmb.errors import FileFormatError, InputError
from flexmb.results.contact_intervals import COLUMNS
from flexmb.results.netcdf import load
from flexmb.results.peaks import Peaks
from flexmb.results.solution import Solution

if TYPE_CHECKING:
    from flexmb.run.run import Run

EVERY = 30.0
"""Time between two checkpoints [s on the clock]."""

COMMAND = "checkpoint"
"""Name of the arguments of the run in `Solution.model`."""

POSES = "poses."
"""Begin of the names of the poses that a run keeps."""

END_COLUMN = [name for name, _ in COLUMNS].index("end")


class Checkpoints:
    """The checkpoint file of a run, written again and again while the run goes on.

    Parameters
    ----------
    path : the file.
    every : time between two of them [s on the clock].
    command : arguments of the run as plain values; a checkpoint of other arguments is refused.
    model : name of the mechanism and other plain values for the record.
    """

    def __init__(self, path: Path, every: float, command: Mapping[str, Any], model: Mapping[str, Any]) -> None:
        self.path, self.every = path, checks.not_negative("checkpoint", "every", every, "s")
        self.command, self.model = dict(command), dict(model)
        self.last = time.monotonic()
        self.failure = ""

    def after_block(self, run: Run) -> None:
        """Write a checkpoint if it is time; a file that cannot be written is noted once, and the run goes on."""
        if time.monotonic() - self.last >= self.every:
            self.write(run)

    def write(self, run: Run) -> None:
        """Write a checkpoint now."""
        self.last = time.monotonic()
        if self.failure:
            return
        try:
            checkpoint_of(run, {**self.model, COMMAND: self.command}).to_netcdf(self.path)
        except InputError as error:
            self.failure = f"No checkpoint since t = {run.flow.clock.t:.6g} s: {error}"

    def resume(self, run: Run, label: str, *, redundant: bool) -> None:
        """Let a run go on from the file.

        Parameters
        ----------
        run : a run that has not begun.
        label : first words of errors.
        redundant : whether joints may be redundant.

        Raises
        ------
        FileFormatError : no such file, or a damaged one.
        InputError : a checkpoint of another run, or of another mechanism.
        """
        try:
            sol = load(self.path)
        except FileFormatError as error:
            text = str(error).partition(" Write it again")[0]
            raise FileFormatError(f"{label}: {text} Remove this checkpoint; the run then starts anew.") from error
        given = sol.model.get(COMMAND)
        if not isinstance(given, dict):
            raise FileFormatError(f"{label}: {str(self.path)!r} is no checkpoint; it is a finished result.")
        for name, value in self.command.items():
            if given.get(name) != value:
                text = f"{label}: the checkpoint {str(self.path)!r} belongs to a run with {name} = {given.get(name)!r}"
                raise InputError(f"{text}, not {value!r}. Resume with the same arguments, or remove the file.")
        run.resume(sol.restart, label, redundant=redundant)
        adopt(run, sol)

    def remove(self) -> None:
        """Remove the file of a run that has reached its end."""
        self.path.unlink(missing_ok=True)


def checkpoint_of(run: Run, model: Mapping[str, Any]) -> Solution:
    """A solution that holds the run so far, with all counters and peaks beside the usual restart."""
    sol = run.solution(dict(model), wall_time=0.0)
    record = run.record
    more = {
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
    return sol


def adopt(run: Run, sol: Solution) -> None:
    """Give a run the saved instants, contact intervals, peaks and counters of its checkpoint."""
    record, kept = run.record, sol.restart
    if len(sol.time):
        run.saved.add(sol.time, sol.values)
    ended = sol.contacts.rows[~np.isnan(sol.contacts.rows[:, END_COLUMN])]
    if len(ended):
        run.episodes.append(np.array(ended))
    record.peak[:], record.peak_time[:] = kept["peak"], kept["peak_time"]
    record.held_rows[:] = kept["held_rows"].astype(bool)
    record.count.set_numbers(kept["count"])
    record.report.set_numbers(kept["report"])
    record.lows[:], run.earlier = kept["lows"], Peaks(*kept["earlier"])
    own = {name.removeprefix(POSES): array for name, array in kept.items() if name.startswith(POSES)}
    record.poses.restore(own)
    run.saving = float(run.flow.clock.save_start) >= 0.0


def digest(restart: Mapping[str, Any] | None) -> str:
    """Digest of the arrays of a restart; "" without a restart.

    Parameters
    ----------
    restart : arrays by name.
    """
    if not isinstance(restart, Mapping):
        return ""
    data = b"".join(name.encode() + np.ascontiguousarray(restart[name]).tobytes() for name in sorted(restart))
    return blake2b(data, digest_size=8).hexdigest()


def plain_values(**arguments: Any) -> dict[str, Any]:
    """Arguments of a run as plain values, for the comparison with a checkpoint."""
    return {name: value if isinstance(value, int | float | str) else repr(value) for name, value in arguments.items()}
