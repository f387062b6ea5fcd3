"""The command line: `flexmb COMMAND`; flexmb/cli/arguments/index.py lists the commands."""

import atexit
import gc
import io
import os
import re
import sys
from collections.abc import Sequence
from importlib import import_module
from typing import Any

from flexmb.checks import did_you_mean
from flexmb.cli.arguments.index import COMMANDS, SOURCE
from flexmb.cli.arguments.parser import EXAMPLES, keywords_of, parser_of, source_of
from flexmb.errors import USER_ERRORS, FlexmbError

OK, NOT_FINISHED, REFUSED, FAULT, INTERRUPTED = 0, 1, 2, 3, 130  # exit statuses; `flexmb --help` tells their meaning


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line, of typed or given arguments."""
    # Exit status: 0 done, 1 the run did not end or `check` found errors, 2 refused, 3 a fault, 130 interrupted (key).
    if arguments is None:  # a process of its own looks seldom through numba's million objects, and at its end once
        gc.set_threshold(50_000, 20, 100)
        atexit.register(gc.freeze)  # called after `collect`
        atexit.register(gc.collect)
    given = with_negative_numbers(sys.argv[1:] if arguments is None else arguments)
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # names of parts that the terminal cannot show
    try:
        code = _dispatch(given)
        sys.stdout.flush()
        return code
    except BrokenPipeError:
        try:
            print(flush=True)  # what failed is no longer in the buffer
        except BrokenPipeError:  # the reader of the output has closed the pipe, as `head` does: all else goes nowhere
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            return OK
        raise
    except KeyboardInterrupt:
        print("flexmb: interrupted from the keyboard.", file=sys.stderr)
        return INTERRUPTED
    except USER_ERRORS as error:
        if "--debug" in given:
            raise
        code, text = explained(error)
        print(f"flexmb: {' '.join(text.split())}", file=sys.stderr)
        return code


def explained(error: Exception) -> tuple[int, str]:
    """Exit status and message of an error, without traceback."""
    if isinstance(error, FlexmbError):
        return REFUSED, str(error)
    if isinstance(error, ModuleNotFoundError) and error.name:
        package = error.name.partition(".")[0]
        return REFUSED, f"the package {package!r} is missing. Install it: pip install {package}"
    if isinstance(error, OSError):
        return REFUSED, ": ".join(str(said) for said in (error.filename, error.strerror or error) if said)
    if isinstance(error, MemoryError):
        return REFUSED, "there is not enough memory. Save fewer instants or signals, or run shorter."
    return FAULT, f"{type(error).__name__}: {error}. That should not happen; the same command with --debug shows where."


def with_negative_numbers(arguments: Sequence[str]) -> list[str]:
    """Arguments with negative numbers joined to their options: --speed -2pi becomes --speed=-2pi."""
    joined: list[str] = []
    for text in arguments:
        follows = joined and re.match(r"-[.\d]|-pi", text) and joined[-1].startswith("--") and "=" not in joined[-1]
        joined.append(f"{joined.pop()}={text}" if follows else text)
    return joined


def _dispatch(given: list[str]) -> int:
    source = source_of(given)
    parser, maker_options = parser_of(source, given[0] if given else "")
    commands = {command.name: command for command in COMMANDS}
    if not given:
        parser.error(f"say what to do.\n{EXAMPLES}\n`flexmb list` names mechanisms, `flexmb --help` all commands.")
    if given and not given[0].startswith("-") and given[0] not in commands:
        parser.error(f"there is no command {given[0]!r}. {did_you_mean(given[0], commands)}")
    options, unknown = parser.parse_known_args(given)
    if unknown:
        known = [name for name in vars(options.own_parser)["_option_string_actions"] if name.startswith("--")]
        wrong = [text.partition("=")[0] for text in unknown if text.startswith("-")]
        hints = [f"{name}: {did_you_mean(name, known, '--', 'Options')}" for name in wrong]
        options.own_parser.error(f"unrecognized arguments: {' '.join(unknown)}\n{' '.join(hints)}".strip())
    options.arguments = given
    if getattr(options, "quiet", False):
        os.environ["FLEXMB_MESSAGES"] = "0"  # no messages on compilation, also in worker processes
    command = commands[options.command]
    module, function = command.place
    call: Any = vars(import_module(module))[function]
    if not command.begins_with_mechanism:
        return int(call(options))
    if source is None:
        parser.error(f"the mechanism comes first: flexmb {options.command} NAME [options]")
    source = source.with_changes(options.set)
    if command.takes == SOURCE:
        return int(call(source, maker_options, options))
    return int(call(source.mechanism(keywords_of(options, maker_options)), source.name, options))
