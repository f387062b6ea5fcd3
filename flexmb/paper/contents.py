"""All figures and pages of the study, and which of them are meant by what was typed."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from types import ModuleType

from flexmb import checks
from flexmb.errors import InputError
from flexmb.paper.effort import Effort
from flexmb.paper.figures import bifurcation, exponent, friction, motion, path, phase, section
from flexmb.paper.pages import claims, convergence, exponents, sensitivity, threshold
from flexmb.paper.plate import Page, Plate, Run

FIGURES: tuple[ModuleType, ...] = (
    friction,
    motion,
    path,
    bifurcation,
    phase,
    section,
    exponent,
)
"""Modules of figures, one a line."""

PAGES: tuple[ModuleType, ...] = (
    claims,
    convergence,
    threshold,
    exponents,
    sensitivity,
)
"""Modules of pages, one a line."""

GROUPS = ("figures", "pages", "all")
RANGE = re.compile(r"([0-9]+)(?:-([0-9]+))?")


def plates(effort: Effort) -> tuple[Plate, ...]:
    """The figures, by rising number, at an effort."""
    return tuple(sorted((plate for module in FIGURES for plate in module.plates(effort)), key=lambda p: p.number))


def pages(effort: Effort) -> tuple[Page, ...]:
    """The pages at an effort."""
    return tuple(page for module in PAGES for page in module.pages(effort))


def chosen(words: Sequence[str], effort: Effort) -> tuple[tuple[Plate, ...], tuple[Page, ...]]:
    """The figures and pages that words mean.

    Parameters
    ----------
    words : numbers of figures ("9"), ranges of them ("9-16"), names of pages, "figures", "pages" (those that are not
        slow), "all"; none: figures and pages that are not slow.
    effort : at which they are made.

    Raises
    ------
    InputError : a word that means nothing, a figure that the study does not have.
    """
    figures, tables = plates(effort), pages(effort)
    numbers, names = set[int](), set[str]()
    for word in words or ("figures", "pages"):
        if word in ("figures", "all"):
            numbers.update(plate.number for plate in figures)
        if word in ("pages", "all"):
            names.update(page.name for page in tables if word == "all" or not page.slow)
        if word in GROUPS:
            continue
        if match := RANGE.fullmatch(word):
            numbers.update(_numbers(word, int(match[1]), int(match[2] or match[1]), figures))
        else:
            names.add(checks.one_of("flexmb paper", "WHAT", word, [page.name for page in tables] + _others(figures)))
    return tuple(p for p in figures if p.number in numbers), tuple(p for p in tables if p.name in names)


def runs_of(items: Iterable[Plate | Page]) -> dict[str, Run]:
    """The runs that figures and pages need, by name; each once.

    Raises
    ------
    InputError : two different runs of one name.
    """
    found: dict[str, Run] = {}
    for item in items:
        for run in item.runs:
            known = found.setdefault(run.name, run)
            if known != run and known.fingerprint() != run.fingerprint():
                text = f"flexmb paper: {item.title!r}: two different runs are called {run.name!r}"
                raise InputError(f"{text}, so one result would overwrite the other. Give one of them another name.")
    return found


def _numbers(word: str, first: int, last: int, figures: Sequence[Plate]) -> list[int]:
    """The numbers of a range, all of which must be there."""
    if first > last:
        raise InputError(f"flexmb paper: WHAT is {word!r}; the first number of a range must not be above the last.")
    known = {plate.number for plate in figures}
    unknown = [number for number in range(first, last + 1) if number not in known] if last < 1000 else [last]
    if unknown:
        text = f"flexmb paper: WHAT is {word!r}; the study has no figure {unknown[0]}"
        raise InputError(f"{text}. There are {shown_numbers(sorted(known))}.")
    return list(range(first, last + 1))


def shown_numbers(numbers: Sequence[int]) -> str:
    """Rising numbers with ranges: "6-16, 23"."""
    pieces: list[list[int]] = []
    for number in numbers:
        if pieces and pieces[-1][1] == number - 1:
            pieces[-1][1] = number
        else:
            pieces.append([number, number])
    return ", ".join(f"{first}" if first == last else f"{first}-{last}" for first, last in pieces)


def _others(figures: Sequence[Plate]) -> list[str]:
    """What may be typed beside the names of pages, for messages."""
    return [*GROUPS, *shown_numbers([plate.number for plate in figures]).split(", ")]
