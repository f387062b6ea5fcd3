"""`flexmb completion`: scripts that complete commands, mechanisms and options in a shell."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from flexmb.cli.arguments.index import COMMANDS
from flexmb.cli.arguments.options import options_of
from flexmb.cli.arguments.parser import parser_of
from flexmb.cli.arguments.source import ready


@dataclass(frozen=True)
class Words:
    """Words that can follow a command.

    Parameters
    ----------
    command : name of the command.
    help : its help.
    options : options with their help, by name.
    values : words of its first argument, empty where that is a file.
    ending : ending of the files of its first argument; "" for none.
    takes_mechanism : whether the options of the named mechanism follow.
    """

    command: str
    help: str
    options: dict[str, str]
    values: tuple[str, ...]
    ending: str
    takes_mechanism: bool


def completion(options: argparse.Namespace) -> int:
    """`flexmb completion`: print the script."""
    print(SCRIPTS[options.shell](list(words()), of_mechanisms()), end="")
    return 0


def words() -> Iterator[Words]:
    """Words of all commands, from the parser."""
    parser, _ = parser_of(None, "")
    parsers = next(action.choices for action in parser._actions if isinstance(action, argparse._SubParsersAction))
    makers = tuple(ready())
    for command in COMMANDS:
        actions = parsers[command.name]._actions
        flags = {flag: a.help or "" for a in actions for flag in a.option_strings if flag.startswith("--")}
        plain = [action for action in actions if not action.option_strings]
        choices = tuple(map(str, plain[0].choices or ())) if plain else ()
        shown = str(plain[0].metavar) if plain else ""
        ending = ".py" if command.begins_with_mechanism else ".nc" if shown.endswith(".nc") else ""
        values = makers if command.begins_with_mechanism else choices
        yield Words(command.name, command.help, flags, values, ending, command.begins_with_mechanism)


def of_mechanisms() -> dict[str, dict[str, str]]:
    """Options with their help by ready mechanism; a truth value has two."""
    found: dict[str, dict[str, str]] = {}
    for name, make in ready().items():
        options = options_of(make)
        found[name] = {option.flag: option.help for option in options}
        found[name] |= {f"--no-{o.flag[2:]}": o.help for o in options if o.kind == "flag"}
    return found


def _cases(pairs: dict[str, str], indent: str) -> str:
    """Branches of a `case` of a shell."""
    return "".join(f"{indent}{name}) {text} ;;\n" for name, text in pairs.items())


def _bash(commands: list[Words], mechanisms: dict[str, dict[str, str]]) -> str:
    options = {w.command: f'words="{" ".join(w.options)}"' for w in commands}
    values = {w.command: f'words="{" ".join(w.values)}"; ending="{w.ending}"' for w in commands}
    own = {name: f'words="$words {" ".join(flags)}"' for name, flags in mechanisms.items()}
    takers = "|".join(w.command for w in commands if w.takes_mechanism)
    return f"""# completion of flexmb for bash; made by `flexmb completion bash`
_flexmb() {{
    local word="${{COMP_WORDS[COMP_CWORD]}}" words="" ending=""
    if [ "$COMP_CWORD" -eq 1 ]; then
        words="{" ".join(w.command for w in commands)} --help --version"
    elif [ "$COMP_CWORD" -eq 2 ] && [[ "$word" != -* ]]; then
        case "${{COMP_WORDS[1]}}" in
{_cases(values, " " * 12)}        esac
    elif [[ "$word" == -* ]]; then
        case "${{COMP_WORDS[1]}}" in
{_cases(options, " " * 12)}        esac
        case "${{COMP_WORDS[1]}}" in {takers})
            case "${{COMP_WORDS[2]}}" in
{_cases(own, " " * 16)}            esac ;;
        esac
    fi
    COMPREPLY=($(compgen -W "$words" -- "$word"))
    if [ -n "$ending" ]; then
        COMPREPLY+=($(compgen -f -X "!*$ending" -- "$word") $(compgen -d -S / -- "$word"))
    fi
}}
complete -o default -F _flexmb flexmb
"""


def _zsh(commands: list[Words], mechanisms: dict[str, dict[str, str]]) -> str:
    options = {w.command: f"options=({' '.join(w.options)})" for w in commands}
    values = {w.command: f'names=({" ".join(w.values)}); ending="{w.ending}"' for w in commands}
    own = {name: f"options+=({' '.join(flags)})" for name, flags in mechanisms.items()}
    takers = "|".join(w.command for w in commands if w.takes_mechanism)
    return f"""#compdef flexmb
# completion of flexmb for zsh; made by `flexmb completion zsh`
_flexmb() {{
    local ending=""
    local -a names options
    if (( CURRENT == 2 )); then
        compadd -- {" ".join(w.command for w in commands)} --help --version
    elif (( CURRENT == 3 )) && [[ "$PREFIX" != -* ]]; then
        case "${{words[2]}}" in
{_cases(values, " " * 12)}        esac
        (( $#names )) && compadd -- $names
        [[ -n "$ending" ]] && _files -g "*$ending"
    elif [[ "$PREFIX" == -* ]]; then
        case "${{words[2]}}" in
{_cases(options, " " * 12)}        esac
        case "${{words[2]}}" in {takers})
            case "${{words[3]}}" in
{_cases(own, " " * 16)}            esac ;;
        esac
        compadd -- $options
    else
        _files
    fi
}}
if [[ "${{funcstack[1]}}" == "_flexmb" ]]; then _flexmb "$@"; else compdef _flexmb flexmb; fi
"""


def _fish(commands: list[Words], mechanisms: dict[str, dict[str, str]]) -> str:
    lines = ["# completion of flexmb for fish; made by `flexmb completion fish`"]
    for w in commands:
        seen = f"__fish_seen_subcommand_from {w.command}"
        lines.append(f"complete -c flexmb -f -n __fish_use_subcommand -a {w.command} -d {_quoted(w.help)}")
        lines += [f"complete -c flexmb -n '{seen}' -l {f[2:]} -d {_quoted(text)}" for f, text in w.options.items()]
        third = f"{seen}; and test (count (commandline -opc)) -eq 2"
        files = "" if w.ending else "-f "
        lines += [f"complete -c flexmb {files}-n '{third}' -a '{' '.join(w.values)}'"] if w.values else []
    takers = " ".join(w.command for w in commands if w.takes_mechanism)
    for name, flags in mechanisms.items():
        seen = f"__fish_seen_subcommand_from {takers}; and __fish_seen_subcommand_from {name}"
        lines += [f"complete -c flexmb -n '{seen}' -l {f[2:]} -d {_quoted(text)}" for f, text in flags.items()]
    return "\n".join(lines) + "\n"


def _quoted(text: str) -> str:
    plain = text.replace("%%", "%").replace("\\", "\\\\").replace("'", "\\'")
    return f"'{plain}'"


SCRIPTS: dict[str, Callable[[list[Words], dict[str, dict[str, str]]], str]] = {
    "bash": _bash,
    "zsh": _zsh,
    "fish": _fish,
}
"""Makers of the scripts by shell."""
