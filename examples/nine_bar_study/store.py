"""Saved results of runs: one file per run, with the fingerprint of the run and its times."""

from __future__ import annotations

import shutil
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from nine_bar_study.run import StudyRun

from flexmb.dynamics.jobs.files import load_netcdf, write_netcdf
from flexmb.errors import FileFormatError

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True)
class Cost:
    """Processor time and wall-clock time of a run.

    Parameters
    ----------
    cpu : processor time [s].
    wall : wall-clock time [s]; the sum over the values for a diagram.
    measured, parts : number of values with known times, and number of all values; a run that is not a diagram has one
        value.
    """

    cpu: float
    wall: float
    measured: int = 1
    parts: int = 1


class Kept(Mapping[StudyRun, "xr.Dataset"]):
    """Saved results by run.

    Parameters
    ----------
    folder : folder of the files.
    """

    def __init__(self, folder: Path) -> None:
        self.folder, self.read = folder, dict[str, "xr.Dataset"]()

    def path(self, run: StudyRun) -> Path:
        """Path of the result of a run."""
        return self.folder / f"{run.name}.nc"

    def store(self, run: StudyRun) -> Path:
        """Path of the folder (zarr) of finished values of an unfinished diagram."""
        return self.folder / f"{run.name}.zarr"

    def log(self, run: StudyRun) -> Path:
        """Path of the log of a diagram, with one line of times per finished value."""
        return self.folder / f"{run.name}.times"

    def has(self, run: StudyRun) -> bool:
        """Whether a readable result with the fingerprint of the run is saved."""
        if run.name in self.read:
            return True
        if not self.path(run).is_file():
            return False
        try:
            found = load_netcdf(self.path(run))[""]
        except FileFormatError:  # damaged file
            return False
        if found.attrs.get("fingerprint") != run.fingerprint():
            return False
        self.read[run.name] = found
        return True

    def cost(self, run: StudyRun) -> Cost:
        """Times of a run with a saved result."""
        about = self[run].attrs
        if "cpu" not in about:  # a result without times
            return Cost(0.0, 0.0, measured=0)
        parts = (int(about.get(name, 1)) for name in ("measured", "parts"))
        return Cost(float(about["cpu"]), float(about["wall"]), *parts)

    def forget(self, run: StudyRun) -> None:
        """Delete the result, the finished values and the log of a run."""
        self.read.pop(run.name, None)
        for file in (self.path(run), self.log(run)):
            file.unlink(missing_ok=True)
        shutil.rmtree(self.store(run), ignore_errors=True)

    def __getitem__(self, run: StudyRun) -> xr.Dataset:
        if not self.has(run):
            raise KeyError(run.name)
        return self.read[run.name]

    def __iter__(self) -> Iterator[StudyRun]:
        raise TypeError("results are asked for by their runs, not listed")

    def __len__(self) -> int:
        return len(self.read)


def keep(run: StudyRun, path: Path, dataset: xr.Dataset, cost: Cost) -> None:
    """Write the result of a run; an interrupted call leaves no file."""
    write_netcdf(path, {"": dataset.assign_attrs({"fingerprint": run.fingerprint(), **asdict(cost)})})
