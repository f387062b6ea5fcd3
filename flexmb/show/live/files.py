"""Files of the newest run of a live page, report, film and netCDF, and folders in which a page writes."""

from __future__ import annotations

import threading
from collections.abc import Callable
from importlib.util import find_spec
from itertools import count
from pathlib import Path
from tempfile import TemporaryDirectory

from flexmb import checks
from flexmb.errors import InputError
from flexmb.show.live.knobs import LABEL
from flexmb.show.live.runs import View
from flexmb.show.pictures.films import animate
from flexmb.show.reports.report import report

NAMES = ("report.html", "film", "run.nc")  # names by which a page asks for a file
STORE_ENTRY = "zarr.json"  # file in each folder that is itself a store


def folder_of(name: str, given: str | Path) -> Path:
    """A folder in which files can be written, made where it does not exist; else `InputError`."""
    folder = checks.path(LABEL, given).absolute()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with TemporaryDirectory(prefix=".flexmb-", dir=folder):
            pass
    except OSError as error:
        what = "is a file, and no folder" if folder.is_file() else f"takes no files ({error.strerror})"
        raise InputError(f"{LABEL}: {name} {str(given)!r} {what}. Give a folder in which you may write.") from error
    if (folder / STORE_ENTRY).exists():
        text = f"{LABEL}: {name} {str(given)!r} is itself the store of a sweep"
        raise InputError(f"{text}. Give the folder above it, or a new one.")
    return folder


class Files:
    """Files of the newest run, `view()`, of a page with a title; `folder`: where a notebook saves them."""

    def __init__(self, view: Callable[[], View], title: Callable[[], str], folder: Path) -> None:
        self.view, self.title, self.folder = view, title, folder
        self.filming = threading.Lock()

    def written(self, name: str, folder: Path) -> Path:
        """A file of the newest run, written into a folder."""
        view = self.view()
        if view.solution is None:
            raise InputError(f"{LABEL}: there is no run to save: {view.status}")
        sol = view.solution
        stem = "".join(sign if sign.isalnum() or sign in "-_" else "-" for sign in self.title())[:80] or "run"
        if name == "report.html":
            return report(sol, folder / f"{stem}.html", mechanism=view.mechanism)
        if name == "run.nc":
            return Path(sol.to_netcdf(folder / f"{stem}.nc"))
        kind = "gif" if find_spec("imageio_ffmpeg") is None else "mp4"
        with self.filming:  # one at a time: each takes a processor for seconds
            return animate(sol, folder / f"{stem}.{kind}")

    def saved(self, name: str) -> Path:
        """A file of the newest run in the folder of the page; a name that is taken gets a number."""
        with TemporaryDirectory(prefix=".flexmb-", dir=folder_of("folder", self.folder)) as place:
            made = self.written(name, Path(place))
            names = (f"{made.stem}{f'-{k}' if k > 1 else ''}{made.suffix}" for k in count(1))
            free = next(self.folder / one for one in names if not (self.folder / one).exists())
            return made.rename(free)
