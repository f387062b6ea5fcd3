"""Arguments of `flexmb run` in the file of a run."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from flexmb.errors import FileFormatError, InputError
from flexmb.results.netcdf import load

COMMAND = "command"
"""Name of the arguments of `flexmb run` in `Solution.model`."""


def arguments_of(path: Path, given: str | None) -> list[str]:
    """Arguments of `flexmb run` that repeat a saved run of the mechanism `given`, a name or FILE.py.

    None: the ready mechanism named in the file; a run of a user's file is refused without `given`.
    """
    command = load(path).model.get(COMMAND)
    if not isinstance(command, list) or len(command) < 2 or command[0] != "run":
        raise FileFormatError(f"{str(path)!r}: does not say how it was made; `flexmb run` writes such files.")
    if given is None and ".py" in command[1]:
        text = f"{str(path)!r} is a run of {command[1]}, a file that would be executed"
        raise InputError(f"{text}. Name it if you trust it: flexmb rerun {path} {command[1]}")
    return ["run", given or command[1], *map(str, command[2:])]


def without_output(arguments: Sequence[str]) -> list[str]:
    """Arguments of `flexmb run` without output options."""
    kept: list[str] = []
    skip = False
    for text in arguments:
        if skip:
            skip = False
        elif text in ("--out", "--frames", "--checkpoint"):
            skip = True
        elif not text.startswith(("--out=", "--frames=", "--checkpoint=", "--resume", "--quiet", "--no-", "--debug")):
            kept.append(text)
    return kept
