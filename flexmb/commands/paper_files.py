"""Files of `flexmb paper`: results of runs that are found again, pictures, data and tables."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from flexmb.commands.files import write_netcdf
from flexmb.paper.plate import Page, Plate, Results, Run
from flexmb.run.run import installed_version

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

DPI = 160
RUNS = {"full": "runs", "quick": "runs-quick"}
"""Folders of the results of runs, by effort: a quick look must not replace what a whole study took hours for."""


@dataclass(frozen=True)
class Cost:
    """What a run took.

    Parameters
    ----------
    processor : processor time [s].
    wall : time by the clock [s]; of a diagram the sum over its points.
    measured, parts : points of a diagram whose time is known, and all of them; of other runs 1 and 1, or 0 and 1 where
        it is not known.
    """

    processor: float
    wall: float
    measured: int = 1
    parts: int = 1


class Kept(Mapping):
    """Results of runs on disk, by their runs: each a file with the fingerprint of its run and what it took.

    Parameters
    ----------
    folder : where they are.
    """

    def __init__(self, folder: Path) -> None:
        self.folder, self.read = folder, dict[str, "xr.Dataset"]()

    def path(self, run: Run) -> Path:
        """File of the result of `run`."""
        return self.folder / f"{run.name}.nc"

    def store(self, run: Run) -> Path:
        """Folder in which the points of `run`, a diagram, are kept while it is computed."""
        return self.folder / f"{run.name}.zarr"

    def log(self, run: Run) -> Path:
        """File with a line for each finished point of `run`: what it took."""
        return self.folder / f"{run.name}.times"

    def has(self, run: Run) -> bool:
        """Whether there is a whole result of this very `run`: same fingerprint, readable to its end."""
        import xarray  # noqa: PLC0415 - `flexmb --help` must not wait for it

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

    def cost(self, run: Run) -> Cost:
        """What `run`, whose result is there, took."""
        about = self[run].attrs
        if "cpu" not in about:  # computed elsewhere
            return Cost(0.0, 0.0, measured=0)
        return Cost(
            float(about["cpu"]), float(about["wall"]), int(about.get("measured", 1)), int(about.get("parts", 1))
        )

    def forget(self, run: Run) -> None:
        """Remove the result of `run`."""
        self.read.pop(run.name, None)
        for file in (self.path(run), self.log(run)):
            file.unlink(missing_ok=True)
        shutil.rmtree(self.store(run), ignore_errors=True)

    def __getitem__(self, run: Run) -> xr.Dataset:
        if run.name not in self.read and not self.has(run):
            raise KeyError(run.name)
        return self.read[run.name]

    def __iter__(self) -> Iterator[Run]:
        raise TypeError("results are asked for by their runs, not listed")

    def __len__(self) -> int:
        return len(self.read)


def keep(run: Run, path: Path, dataset: xr.Dataset, cost: Cost) -> None:
    """Write the result of a run, whole or not at all.

    Parameters
    ----------
    run : the run.
    path : its file.
    dataset : its result.
    cost : what it took.
    """
    about = {"fingerprint": run.fingerprint(), "cpu": cost.processor, "wall": cost.wall}
    about |= {"measured": cost.measured, "parts": cost.parts}
    write_netcdf(path, {"": dataset.assign_attrs(about)})


def make_plate(plate: Plate, results: Results, folder: Path, effort: str) -> list[Path]:
    """Draw a figure.

    Parameters
    ----------
    plate : the figure.
    results : of the runs it shows.
    folder : where picture and data are written.
    effort : name of the effort, for the data.

    Returns
    -------
    list of Path : what was written.
    """
    figure, shown = plate.draw(results)
    about = {"figure": plate.number, "title": plate.title, **_about(plate, effort)}
    return _picture(folder / f"figure-{plate.number:02d}", figure, shown.assign_attrs(about))


def make_page(page: Page, results: Results, folder: Path, effort: str) -> list[Path]:
    """Write a page and its picture, if it has one.

    Parameters
    ----------
    page : the page.
    results : of the runs it needs.
    folder : where text and data are written.
    effort : name of the effort, for the data.

    Returns
    -------
    list of Path : what was written.
    """
    text, numbers = page.write(results)
    about = {"title": page.title, **_about(page, effort)}
    path = folder / f"{page.name}.md"
    written = [write_text(path, f"# {page.title}\n\n{text.strip()}\n")]
    data = {"": numbers.assign_attrs(about)}
    if page.draw is not None:
        figure, shown = page.draw(results)
        written.append(_save(folder / f"{page.name}.png", figure))
        data["picture"] = shown
    return [*written, write_netcdf(folder / f"{page.name}.nc", data)]


def write_text(path: Path, text: str) -> Path:
    """Write a text file; an interrupted write leaves the old file or the new one.

    Parameters
    ----------
    path : the file.
    text : its content.
    """
    part = path.with_name(f".{path.name}.part")
    part.write_text(text, encoding="utf-8")
    part.replace(path)
    return path


def append_line(path: Path, **values: Any) -> None:
    """Add a line of named numbers to a log; a line is written at once.

    Parameters
    ----------
    path : the log.
    **values : the numbers.
    """
    line = json.dumps(values) + "\n"
    with path.open("a+b") as log:
        if log.seek(0, os.SEEK_END):
            log.seek(-1, os.SEEK_END)
            line = line if log.read() == b"\n" else "\n" + line  # what a kill cut short must not swallow this one
        log.write(line.encode())


def lines_of(path: Path) -> list[dict[str, Any]]:
    """The lines of a log, none where there is no log; lines that a kill cut short are left out."""
    found = []
    for line in path.read_text(encoding="utf-8", errors="replace").splitlines() if path.is_file() else []:
        try:
            entry = json.loads(line)
        except json.JSONDecodeError:
            continue
        if isinstance(entry, dict):
            found.append(entry)
    return found


def _about(item: Plate | Page, effort: str) -> dict[str, Any]:
    """Attributes of the data of a figure or page."""
    return {"runs": ", ".join(run.name for run in item.runs), "effort": effort, "flexmb": installed_version()}


def _picture(stem: Path, figure: Figure, shown: xr.Dataset) -> list[Path]:
    return [_save(stem.with_suffix(".png"), figure), write_netcdf(stem.with_suffix(".nc"), {"": shown})]


def _save(path: Path, figure: Figure) -> Path:
    from matplotlib import rc_context  # noqa: PLC0415 - only when something is drawn

    part = path.with_name(f".{path.name}.part")
    with rc_context({"agg.path.chunksize": 20000}):  # curves of many peaks are too much for it at once
        figure.savefig(part, format="png", dpi=DPI)
    part.replace(path)
    return path
