"""Files of a study: pictures, datasets and pages."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from nine_bar_study.item import StudyFigure, StudyPage
from nine_bar_study.store import Kept

from flexmb.dynamics.jobs.executors import Attempt, failure
from flexmb.dynamics.jobs.files import whole_file, write_netcdf, write_text
from flexmb.dynamics.jobs.progress import ProgressBar
from flexmb.version import installed_version

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DPI = 160


@dataclass
class Output:
    """Written files, and reasons of the figures and pages without files.

    Parameters
    ----------
    written : paths of the files.
    drawn : processor time of drawing and writing [s], by label of the figure or page.
    unmade : reason of a missing figure or page, by label.
    """

    written: list[Path] = field(default_factory=list)
    drawn: dict[str, float] = field(default_factory=dict)
    unmade: dict[str, str] = field(default_factory=dict)


def make(
    items: Sequence[StudyFigure | StudyPage], kept: Kept, folder: Path, effort: str, *, shown: bool = False
) -> Output:
    """Draw figures and write pages; a failure does not stop the other figures and pages.

    Parameters
    ----------
    items : figures and pages of the study.
    kept : saved results of runs.
    folder : folder of the files.
    effort : name of the effort, an attribute of the datasets.
    shown : whether progress is shown on stderr.
    """
    made = Output()
    with ProgressBar("figures and pages", len(items), shown=shown, of="drawn") as bar:
        for item in items:
            bar.say(item.label)
            bar.update(1)
            absent = [run.name for run in item.runs if not kept.has(run)]
            if absent:
                made.unmade[item.label] = f"{', '.join(absent)} missing"
                continue
            began = time.process_time()
            about = {"title": item.title, "runs": ", ".join(run.name for run in item.runs)}
            about |= {"effort": effort, "flexmb": installed_version()}
            with Attempt() as attempt:
                if isinstance(item, StudyFigure):
                    made.written += _figure(item, kept, folder, about)
                else:
                    made.written += _page(item, kept, folder, about)
                made.drawn[item.label] = time.process_time() - began
            if attempt.error is not None:
                made.unmade[item.label] = failure(attempt.error).status
    return made


def _figure(item: StudyFigure, kept: Kept, folder: Path, about: dict[str, str]) -> list[Path]:
    picture, shown = item.draw(kept)
    stem = folder / f"figure-{item.number:02d}"
    data = shown.assign_attrs({"figure": item.number, **about})
    return [_save(stem.with_suffix(".png"), picture), write_netcdf(stem.with_suffix(".nc"), {"": data})]


def _page(item: StudyPage, kept: Kept, folder: Path, about: dict[str, str]) -> list[Path]:
    text, numbers = item.write(kept)
    written = [write_text(folder / f"{item.name}.md", f"# {item.title}\n\n{text.strip()}\n")]
    data = {"": numbers.assign_attrs(about)}
    if item.draw is not None:
        picture, shown = item.draw(kept)
        written.append(_save(folder / f"{item.name}.png", picture))
        data["picture"] = shown
    return [*written, write_netcdf(folder / f"{item.name}.nc", data)]


def _save(path: Path, figure: Figure) -> Path:
    from matplotlib import rc_context

    with rc_context({"agg.path.chunksize": 20000}), whole_file(path) as part:  # or long curves cannot be drawn
        figure.savefig(part, format="png", dpi=DPI)
    return path
