"""`flexmb animate`: film of a saved run."""

from __future__ import annotations

import argparse

from flexmb.commands.arguments.units import quantity
from flexmb.commands.plot import names_of, pixels
from flexmb.results.netcdf import load

ALL = "all"
"""Text that stands for all markers or joints."""


def animate(options: argparse.Namespace) -> int:
    """`flexmb animate`: write the film of a saved run, and print its path."""
    from flexmb.pictures.films.film import animate as film  # noqa: PLC0415 - matplotlib when a picture is asked for

    seconds, fps = quantity(options.seconds, "s", "--seconds"), quantity(options.fps, "", "--fps")
    magnify = quantity(options.magnify, "", "--magnify")
    size = pixels(options.size)
    sol = load(options.file)
    times = None
    if (options.begin is not None or options.end is not None) and len(sol.time):
        begin = float(sol.time[0]) if options.begin is None else quantity(options.begin, "s", "--from")
        end = float(sol.time[-1]) if options.end is None else quantity(options.end, "s", "--to")
        times = (begin, end)
    print(
        film(
            sol,
            options.out,
            seconds=seconds,
            fps=fps,
            times=times,
            magnify=magnify,
            colour=None if options.colour == "none" else options.colour,
            traces=True if options.traces == ALL else names_of(options.traces) or None,
            forces=True if options.forces == ALL else names_of(options.forces),
            size=size,
            follow=options.follow,
        )
    )
    return 0
