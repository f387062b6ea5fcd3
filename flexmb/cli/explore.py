"""`flexmb explore`: a live page of a mechanism in the browser."""

import argparse
import inspect
from typing import Any

from flexmb.cli.arguments.parser import Option, keywords_of
from flexmb.cli.arguments.source import Source, field_option
from flexmb.errors import InputError
from flexmb.show.live.knobs import Knobs
from flexmb.show.live.page import Page, length_of, shown
from flexmb.units import quantity

RANGE = "LOW:HIGH, e.g. 10um:0.5mm"


def explore(source: Source, makers: list[Option], options: argparse.Namespace) -> int:
    """`flexmb explore`: serve a live page until Ctrl-C; returns 0.

    Arguments of the function vary; with --set or --vary, or without arguments, numbers of the parts do.  `makers` are
    the options of the function.
    """
    typed = {option: str(vars(options).get(f"maker.{option.name}", "")) for option in makers}
    ranges = {option.name: _range(text, option) for option, text in typed.items() if ":" in text}
    fixed = keywords_of(options, [option for option in makers if option.name not in ranges])
    wishes = options.vary or []
    words = [options.source, *(f"--set={text}" for text in options.set), *(f"--vary={text}" for text in wishes)]
    if options.set or wishes or not inspect.signature(source.make).parameters:
        if ranges:
            text = f"--{next(iter(ranges))}: a range of an argument goes neither with --set nor with --vary"
            raise InputError(f"{text}. Give its value, or a range of a number of a part.")
        mechanism = source.mechanism(fixed)
        vary: dict[str, tuple[Any, Any] | None] = {}  # None: a range about the value
        for path, equals, span in (text.partition("=") for text in wishes):
            option = field_option(mechanism, path, "vary")
            vary[path] = _range(span, option) if equals else None
        knobs = Knobs(mechanism, vary or None, {})
        words[1:1] = [f"{option.flag}={text}" for option, text in typed.items() if text and option.kind != "flag"]
        words[1:1] = [option.flag for option in makers if option.kind == "flag" and fixed.get(option.name)]
    else:
        knobs = Knobs(source.make, None, fixed, ranges)
    periods = None if options.periods is None else quantity(options.periods, "", "--periods")
    t_end = None if options.t_end is None else quantity(options.t_end, "s", "--t-end")
    page = Page(knobs, length_of(periods, t_end), words, options.store, options.port)
    shown(page, opened=not options.no_open, block=True)
    return 0


def _range(text: str, option: Option) -> tuple[Any, Any]:
    """Ends of a typed range, each with its unit."""
    parts = text.split(":")
    if len(parts) != 2:
        raise InputError(f"{option.flag}: {text!r} is no range; give {RANGE}.")
    return option.value(parts[0]), option.value(parts[1])
