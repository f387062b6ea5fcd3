"""Parser of the command line."""

from __future__ import annotations

import argparse
import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING

from flexmb.cli.arguments.index import COMMANDS, UNITS_HELP, add_rows
from flexmb.cli.arguments.options import Option, add_options
from flexmb.errors import FlexmbError
from flexmb.version import versions

if TYPE_CHECKING:
    from flexmb.cli.arguments.source import Source

SOURCE_HELP = "a ready mechanism (see `flexmb list`), or FILE.py[:NAME] with a Mechanism or a function that returns one"
SET_HELP = "a field of a part with another value, e.g. slider.mass=0.2 or B.clearance=50um; may be given several times"
STATUSES = """exit status:
  0    done; the run reached its end, the mechanism has no errors
  1    the run did not reach its end, points of a diagram failed, `check` found errors, `rerun` found differences
  2    refused: a wrong argument, model or file; nothing was computed
  3    a fault of flexmb or of a function in your file; --debug shows where
  130  interrupted from the keyboard"""
EXAMPLES = """examples:
  flexmb new press                                  # a model file to begin with: press.py
  flexmb run press.py --speed 300rpm                # simulate it; results in out/press
  flexmb run slider-crank --clearance 50um          # a ready mechanism"""


class Layout(argparse.HelpFormatter):
    """Help whose last part, the examples, keeps its lines."""

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        before, mark, after = text.partition("examples:")
        filled = super()._fill_text(before, width, indent) if before.strip() else ""
        return f"{filled}\n\n{mark}{after}".strip() if mark else filled


def parser_of(source: Source | None, wanted: str) -> tuple[argparse.ArgumentParser, list[Option]]:
    """Parser of all commands; the options of a mechanism, where there is a source, join the command `wanted`."""
    text = f"{EXAMPLES}\n\n{STATUSES}\n\n`flexmb COMMAND --help` shows the options of a command."
    about = "Planar flexible multibody dynamics with imperfect joints."
    parser = argparse.ArgumentParser("flexmb", None, about, text, formatter_class=Layout, allow_abbrev=False)
    parser.add_argument("--version", action="version", version=versions())
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND", title="commands")
    found: list[Option] = []
    for command in COMMANDS:
        examples = textwrap.indent("\n".join(command.examples), "  ")
        units = f"{UNITS_HELP} " if command.begins_with_mechanism else ""
        own = commands.add_parser(command.name, help=command.help, allow_abbrev=False, formatter_class=Layout)
        own.epilog = f"{units}{command.more}\nexamples:\n{examples}"
        add_rows(own, command.rows)
        own.add_argument("--debug", action="store_true", help="show the traceback of an error")
        own.set_defaults(own_parser=own)
        if command.begins_with_mechanism:
            own.add_argument("source", metavar="NAME", help=SOURCE_HELP)
            own.add_argument("--set", metavar="PART.FIELD=VALUE", action="append", default=[], help=SET_HELP)
            if source is not None and command.name == wanted:
                try:
                    found = add_options(own, source.make, f"options of {source.name}")
                except argparse.ArgumentError as error:
                    text = f"{source.name}: a parameter has the name of an option of this command ({error})."
                    raise FlexmbError(f"{text} Rename the parameter.") from error
    return parser, found


def source_of(given: Sequence[str]) -> Source | None:
    """Source of the mechanism among the arguments, which is needed first: its parameters become options."""
    named = {command.name for command in COMMANDS if command.begins_with_mechanism}
    if len(given) < 2 or given[0] not in named or given[1].startswith("-"):
        return None
    from flexmb.cli.arguments.source import find  # noqa: PLC0415 - imports numba: not for `flexmb --help`

    return find(given[1])
