"""Study: figures and pages at an effort, and their selection by the words of the command."""

from __future__ import annotations

import pkgutil
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from importlib import import_module

import nine_bar_study
from nine_bar_study.case import Case
from nine_bar_study.effort import FULL, QUICK, Effort
from nine_bar_study.item import StudyFigure, StudyPage
from nine_bar_study.run import StudyRun

from flexmb import checks
from flexmb.errors import InputError

GROUPS = ("figures", "pages", "all")
RANGE = re.compile(r"([0-9]+)(?:-([0-9]+))?")
OWNER = "nine_bar_paper.py"


@dataclass(frozen=True)
class Study:
    """Tables of a study: figures, pages, efforts.

    Parameters
    ----------
    title : published source.
    figures, pages : functions of an effort that return the figures, by ascending number, and the pages.
    first : one case of each model; its code is compiled before worker processes start.
    efforts : full and quick lengths of the runs.
    """

    title: str
    figures: Callable[[Effort], tuple[StudyFigure, ...]]
    pages: Callable[[Effort], tuple[StudyPage, ...]]
    first: tuple[Case, ...]
    efforts: tuple[Effort, Effort] = (FULL, QUICK)

    def effort(self, *, quick: bool) -> Effort:
        """Full or quick lengths of the runs."""
        return self.efforts[quick]

    def chosen(self, words: Sequence[str], effort: Effort) -> list[StudyFigure | StudyPage]:
        """Figures and pages selected by words.

        Parameters
        ----------
        words : numbers of figures ("9"), ranges of numbers ("9-16"), names of pages, "figures", "pages" (all pages that
            are not slow), "all"; no words: "figures" and "pages".
        effort : lengths of the runs.

        Raises
        ------
        InputError : an unknown word or number of a figure.
        """
        figures, tables = self.figures(effort), self.pages(effort)
        numbers, names = set[int](), set[str]()
        for word in words or ("figures", "pages"):
            if word in ("figures", "all"):
                numbers.update(figure.number for figure in figures)
            if word in ("pages", "all"):
                names.update(page.name for page in tables if word == "all" or not page.slow)
            if word in GROUPS:
                continue
            if match := RANGE.fullmatch(word):
                numbers.update(_numbers(word, int(match[1]), int(match[2] or match[1]), figures))
            else:
                known = [*(page.name for page in tables), *GROUPS, *shown_numbers(figures).split(", ")]
                names.add(checks.one_of(OWNER, "WHAT", word, known))
        return [*(one for one in figures if one.number in numbers), *(one for one in tables if one.name in names)]


def studies() -> dict[str, str]:
    """Modules of the studies by name: each package of `nine_bar_study` with a module `tables`."""
    folders = [found.name for found in pkgutil.iter_modules(nine_bar_study.__path__) if found.ispkg]
    paths = {name: f"{nine_bar_study.__name__}.{name}" for name in folders}
    return {
        name.replace("_", "-"): f"{path}.tables"
        for name, path in paths.items()
        if any(found.name == "tables" for found in pkgutil.iter_modules(import_module(path).__path__))
    }


def study_of(name: str) -> Study:
    """Study of a name.

    Raises
    ------
    InputError : an unknown name of a study.
    """
    known = studies()
    study: Study = import_module(known[checks.one_of(OWNER, "--study", name, known)]).STUDY
    return study


def runs_of(items: Iterable[StudyFigure | StudyPage]) -> dict[str, StudyRun]:
    """Runs of figures and pages by name.

    Raises
    ------
    InputError : two different runs have the same name.
    """
    found: dict[str, StudyRun] = {}
    for item in items:
        for run in item.runs:
            known = found.setdefault(run.name, run)
            if known != run and known.fingerprint() != run.fingerprint():
                text = f"{OWNER}: {item.title!r}: two different runs are called {run.name!r}"
                raise InputError(f"{text}, so one result would overwrite the other. Give one of them another name.")
    return found


def _numbers(word: str, first: int, last: int, figures: Sequence[StudyFigure]) -> list[int]:
    """Numbers of the figures of a range; an unknown number is an error."""
    if first > last:
        raise InputError(f"{OWNER}: WHAT is {word!r}; the first number of a range must not be above the last.")
    known = {figure.number for figure in figures}
    unknown = [number for number in range(first, last + 1) if number not in known] if last < 1000 else [last]
    if unknown:
        text = f"{OWNER}: WHAT is {word!r}; the study has no figure {unknown[0]}"
        raise InputError(f"{text}. There are {shown_numbers(figures)}.")
    return list(range(first, last + 1))


def shown_numbers(figures: Iterable[StudyFigure]) -> str:
    """Text of the numbers of figures, with ranges: "6-16, 23"."""
    pieces: list[list[int]] = []
    for number in sorted(figure.number for figure in figures):
        if pieces and pieces[-1][1] == number - 1:
            pieces[-1][1] = number
        else:
            pieces.append([number, number])
    return ", ".join(f"{first}" if first == last else f"{first}-{last}" for first, last in pieces)
