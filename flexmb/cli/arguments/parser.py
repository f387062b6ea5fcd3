"""Parser of the command line, and options from the signature and docstring of a function that returns a mechanism."""

from __future__ import annotations

import argparse
import ast
import inspect
import math
import re
import textwrap
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from flexmb.arguments import parameters
from flexmb.cli.arguments.index import COMMANDS, UNITS_HELP, add_rows
from flexmb.errors import FlexmbError, InputError
from flexmb.fields import unit_of, with_unit
from flexmb.units import known_units, quantity
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


Maker = Callable[..., Any]
KINDS = {"bool": "flag", "float": "number", "int": "count", "str": "text"}
SHOWN = {"number": "X", "count": "N", "numbers": "X,Y", "text": "TEXT"}  # kind by type, and value in the help by kind


@dataclass(frozen=True)
class Option:
    """A parameter of a function, as an option."""

    name: str  # name of the parameter
    kind: str  # "number", "count", "numbers" (a tuple), "flag" or "text"
    default: Any  # default value, or `inspect.Parameter.empty`
    unit: str  # SI unit, "" for none; "rad or m" where it depends on another field
    help: str  # description in the docstring, with the unit

    @property
    def flag(self) -> str:
        """Name of the option on the command line."""
        return "--" + self.name.replace("_", "-")

    @property
    def is_required(self) -> bool:
        """Whether the parameter has no default."""
        return self.default is inspect.Parameter.empty

    def value(self, text: str) -> Any:
        """Argument of the function for a typed `text`."""
        if text.lower() == "none" and (self.kind == "text" or self.default is None):
            return None
        if self.kind == "text":
            return text
        if self.kind == "numbers":
            return tuple(quantity(part, self.unit, self.flag) for part in text.split(","))
        number = quantity(text, self.unit, self.flag)
        if self.kind == "count" and number != int(number):
            raise InputError(f"{self.flag}: {text!r} is no whole number.")
        return int(number) if self.kind == "count" else number


def options_of(maker: Maker) -> list[Option]:
    """Options for the parameters of a function that are numbers, tuples of numbers, flags or texts."""
    # A parameter has its unit in its annotation, length: Annotated[float, "m"], and its help in the numpydoc docstring,
    # "length : length of the rod"; a class has both in its fields. Others, such as laws or materials, have no option.
    described, options = parameters(maker), []
    try:
        signature = inspect.signature(maker, eval_str=True)  # aliases are then resolved
    except NameError:  # imported for type checking only
        signature = inspect.signature(maker)
    for parameter in signature.parameters.values():
        if kind := _kind(parameter):
            told, text = unit_of(maker, parameter.name), described.get(parameter.name, "")
            text = text if inspect.isclass(maker) or not text else with_unit(text, told)
            options.append(Option(parameter.name, kind, parameter.default, known_units(told), text))
    return options


def add_options(parser: argparse.ArgumentParser, maker: Maker, title: str) -> list[Option]:
    """Add the options of a function to a parser, in a group with a title; returns them."""
    options, group = options_of(maker), parser.add_argument_group(title)
    for option in options:
        help_text = (option.help + shown_default(option)).replace("%", "%%")
        common: dict[str, Any] = {"dest": f"maker.{option.name}", "default": argparse.SUPPRESS, "help": help_text}
        if option.kind == "flag":
            group.add_argument(option.flag, action=argparse.BooleanOptionalAction, **common)
        else:
            group.add_argument(option.flag, metavar=SHOWN[option.kind], required=option.is_required, **common)
    return options


def keywords_of(arguments: argparse.Namespace, options: list[Option]) -> dict[str, Any]:
    """Keywords of the function from the typed options."""
    typed = {o: vars(arguments)[f"maker.{o.name}"] for o in options if f"maker.{o.name}" in vars(arguments)}
    return {o.name: value if o.kind == "flag" else o.value(value) for o, value in typed.items()}


def shown_default(option: Option) -> str:
    """Default of an option, as a text for its help."""
    if option.is_required:
        return " (must be given)"
    if option.kind == "flag" or option.default is None:
        return ""
    values = option.default if isinstance(option.default, tuple) else (option.default,)
    shown = ",".join(f"{value:.6g}" if isinstance(value, float) else str(value) for value in values)
    return f" (default {shown}{' ' + option.unit if option.unit else ''})"


def _kind(parameter: inspect.Parameter) -> str:
    """Kind of the option for a parameter, "" for none; from the annotation, else from the default."""
    if parameter.kind in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD, parameter.POSITIONAL_ONLY):
        return ""
    bare = parameter.annotation is parameter.empty
    words = set(re.findall(r"\w+", "" if bare else inspect.formatannotation(parameter.annotation)))
    if "tuple" in words:
        return "numbers" if "float" in words else ""
    usual = KINDS.get(type(parameter.default).__name__, "")
    return next((kind for word, kind in KINDS.items() if word in words), usual)


# Ready mechanisms, listed without import of numba

FOLDER = Path(__file__).parents[2] / "mechanisms"


def declared() -> dict[str, Maker]:
    """Functions of the ready mechanisms by the name on the command line: signatures and docstrings, without bodies."""
    found: dict[str, Maker] = {}
    for line in (one for one in _statements("__init__") if isinstance(one, ast.ImportFrom)):
        for node in _statements((line.module or "").rpartition(".")[2]):
            if isinstance(node, ast.FunctionDef) and node.name in (alias.name for alias in line.names):
                node.decorator_list, node.body = [], node.body[:1]
                names: dict[str, Any] = {"__name__": __name__, "math": math, "Annotated": Annotated}
                exec(compile(ast.Module([node], []), FOLDER, "exec"), names)  # annotations stay texts, as in this file
                found[node.name.replace("_", "-")] = names[node.name]
    return found


def _statements(module: str) -> list[ast.stmt]:
    """Statements of a module of ready mechanisms; none of others."""
    path = FOLDER / f"{module}.py"
    return ast.parse(path.read_text(encoding="utf-8")).body if path.is_file() else []


def list_mechanisms(options: argparse.Namespace) -> int:
    """`flexmb list`: print every ready mechanism with its `options`."""
    for name, make in declared().items():
        print(f"{name}: {(inspect.getdoc(make) or '').splitlines()[0]}")
        for option in options_of(make):
            print(f"    {option.flag:<18s}{option.help}{shown_default(option)}")
        print()
    print("Run one of them:      flexmb run NAME [options]")
    print("or a mechanism of your own:  flexmb new NAME, flexmb run NAME.py")
    return 0
