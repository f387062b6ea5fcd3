"""`flexmb plot`: signals of a saved run as a picture."""

from __future__ import annotations

import argparse
import re
from pathlib import Path

from flexmb.errors import InputError
from flexmb.results.netcdf import load


def plot(options: argparse.Namespace) -> int:
    """`flexmb plot`: draw signals of a saved run, and print the path of the picture."""
    from flexmb.pictures.curves.plot import plot as picture_of  # noqa: PLC0415 - matplotlib when a picture is asked for

    panels = [names_of(text) for text in options.signals]
    figure = picture_of(load(options.file), panels, title=options.title, x=options.x)
    target = Path(options.out)
    figure.savefig(target, dpi=150)
    print(target)
    return 0


def names_of(text: str | None) -> list[str]:
    """Names in a text, separated by commas."""
    return [name.strip() for name in (text or "").split(",") if name.strip()]


def pixels(text: str | None) -> tuple[int, int] | None:
    """Width and height in a text such as 600x400; None without a text."""
    if text is None:
        return None
    found = re.fullmatch(r"(\d+)x(\d+)", text)
    if found is None:
        raise InputError(f"--size: {text!r} is no size; write width and height in pixels, e.g. 600x400.")
    return int(found[1]), int(found[2])
