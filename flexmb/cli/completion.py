"""`flexmb completion`: scripts that complete commands, mechanisms and options in a shell."""

import argparse
from collections.abc import Iterator
from importlib.resources import files
from typing import NamedTuple

from flexmb.cli.arguments.index import COMMANDS
from flexmb.cli.arguments.parser import options_of, parser_of
from flexmb.cli.arguments.source import ready


class Words(NamedTuple):
    """Words that follow a command: its options with their help, values of its first argument, ending of its files."""

    command: str
    help: str
    options: dict[str, str]
    values: tuple[str, ...]
    ending: str
    takes_mechanism: bool


# Typed command and its first argument, by shell.
PLACES = {"bash": ("${COMP_WORDS[1]}", "${COMP_WORDS[2]}"), "zsh": ("${words[2]}", "${words[3]}")}


def completion(options: argparse.Namespace) -> int:
    """`flexmb completion`: print the script."""
    commands, mechanisms = list(words()), dict[str, dict[str, str]]()
    for name, make in ready().items():
        own = options_of(make)
        mechanisms[name] = {option.flag: option.help for option in own}
        mechanisms[name] |= {f"--no-{o.flag[2:]}": o.help for o in own if o.kind == "flag"}
    if options.shell == "fish":
        print("\n".join(_fish(commands, mechanisms)))
        return 0
    text = files("flexmb.cli").joinpath("assets", f"completion.{options.shell}").read_text(encoding="utf-8")
    names = " ".join(w.command for w in commands)
    # Names and ending of the first argument, and options, of a typed command
    first, second = PLACES[options.shell]
    cases = [f'    local names="" ending="" options=""\n    case "{first}" in']
    for w in commands:
        given = f'names="{" ".join(w.values)}" ending="{w.ending}" options="{" ".join(w.options)}"'
        cases.append(f"        {w.command}) {given} ;;")
    cases.append(f'    esac\n    case "{first}:{second}" in')
    for name, flags in mechanisms.items():
        typed = "|".join(f"{w.command}:{name}" for w in commands if w.takes_mechanism)
        cases.append(f'        {typed}) options="$options {" ".join(flags)}" ;;')
    whole = text.replace("@CASES@", "\n".join([*cases, "    esac"]))
    print(whole.replace("@COMMANDS@", f"{names} --help --version"), end="")
    return 0


def words() -> Iterator[Words]:
    """Words of all commands, from the parser."""
    parser, _ = parser_of(None, "")
    parsers = next(action.choices for action in parser._actions if isinstance(action, argparse._SubParsersAction))
    for command in COMMANDS:
        actions, takes = parsers[command.name]._actions, command.begins_with_mechanism
        flags = {flag: a.help or "" for a in actions for flag in a.option_strings if flag.startswith("--")}
        plain = [action for action in actions if not action.option_strings]
        ending = ".py" if takes else ".nc" if any(action.metavar == "RUN.nc" for action in plain) else ""
        values = tuple(ready()) if takes else tuple(str(v) for action in plain[:1] for v in action.choices or ())
        yield Words(command.name, command.help, flags, values, ending, takes)


def _fish(commands: list[Words], mechanisms: dict[str, dict[str, str]]) -> Iterator[str]:
    yield "# completion of flexmb for fish; made by `flexmb completion fish`"
    for w in commands:
        seen = f"__fish_seen_subcommand_from {w.command}"
        yield f"complete -c flexmb -f -n __fish_use_subcommand -a {w.command} -d {_quoted(w.help)}"
        yield from _flags(seen, w.options)
        if w.values:
            third = f"{seen}; and test (count (commandline -opc)) -eq 2"
            yield f"complete -c flexmb {'' if w.ending else '-f '}-n '{third}' -a '{' '.join(w.values)}'"
    takers = " ".join(w.command for w in commands if w.takes_mechanism)
    for name, flags in mechanisms.items():
        yield from _flags(f"__fish_seen_subcommand_from {takers}; and __fish_seen_subcommand_from {name}", flags)


def _flags(seen: str, flags: dict[str, str]) -> Iterator[str]:
    return (f"complete -c flexmb -n '{seen}' -l {flag[2:]} -d {_quoted(text)}" for flag, text in flags.items())


def _quoted(text: str) -> str:
    plain = text.replace("%%", "%").replace("\\", "\\\\").replace("'", "\\'")
    return f"'{plain}'"
