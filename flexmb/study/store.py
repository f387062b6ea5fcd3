"""The results of runs on disk: each a file with the fingerprint of its run and its cost, found again by its run."""

from __future__ import annotations

import shutil
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from flexmb.jobs.files import write_netcdf
from flexmb.study.run import StudyRun

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True)
class Cost:
    """The times of a run.

    Parameters
    ----------
    cpu : processor time [s].
    wall : time by the clock [s]; of a diagram the sum over its values.
    measured, parts : values of a diagram whose time is known, and all of them; of other runs 1 and 1, or 0 and 1 where
        it is not known.
    """

    cpu: float
    wall: float
    measured: int = 1
    parts: int = 1


class Kept(Mapping):
    """Results of runs on disk, by their runs.

    Parameters
    ----------
    folder : folder of the files.
    """

    def __init__(self, folder: Path) -> None:
        self.folder, self.read = folder, dict[str, "xr.Dataset"]()

    def path(self, run: StudyRun) -> Path:
        """File of the result of a run."""
        return self.folder / f"{run.name}.nc"

    def store(self, run: StudyRun) -> Path:
        """Folder (zarr) of the finished values of a diagram while it is computed."""
        return self.folder / f"{run.name}.zarr"

    def log(self, run: StudyRun) -> Path:
        """File with a line of times for each finished value of a diagram."""
        return self.folder / f"{run.name}.times"

    def has(self, run: StudyRun) -> bool:
        """Whether there is a whole result of this very run: same fingerprint, readable to its end."""
        import xarray

        if run.name in self.read:
            return True
        if not self.path(run).is_file():
            return False
        try:
            found = xarray.load_dataset(self.path(run), engine="h5netcdf")
        except (OSError, ValueError, KeyError, TypeError, RuntimeError):  # damaged: computed anew
            return False
        if found.attrs.get("fingerprint") != run.fingerprint():
            return False
        self.read[run.name] = found
        return True

    def cost(self, run: StudyRun) -> Cost:
        """The times of a run whose result is there."""
        about = self[run].attrs
        if "cpu" not in about:  # computed elsewhere
            return Cost(0.0, 0.0, measured=0)
        parts = (int(about.get(name, 1)) for name in ("measured", "parts"))
        return Cost(float(about["cpu"]), float(about["wall"]), *parts)

    def forget(self, run: StudyRun) -> None:
        """Remove the result of a run."""
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
    """Write the result of a run, whole or not at all.

    Parameters
    ----------
    run, path : the run, and its file.
    dataset : its result.
    cost : its times.
    """
    write_netcdf(path, {"": dataset.assign_attrs({"fingerprint": run.fingerprint(), **asdict(cost)})})
