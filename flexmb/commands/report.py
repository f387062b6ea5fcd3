"""`flexmb report`: HTML page of a saved run."""

from __future__ import annotations

from flexmb.commands.rerun import COMMAND
from flexmb.results.solution import Solution


def repeated_command(sol: Solution, given: str | None) -> list[str]:
    """Arguments of `flexmb run` with which the mechanism of a saved run can be built; [] for an unknown mechanism.

    Parameters
    ----------
    sol : the saved run.
    given : name of the mechanism, or FILE.py; None: the ready mechanism named in the file.  A FILE.py that the file
        names is not executed unless it is given.
    """
    command = sol.model.get(COMMAND)
    if not isinstance(command, list) or len(command) < 2 or command[0] != "run":
        return [] if given is None else ["run", given]
    if given is None and ".py" in command[1]:
        return []
    return ["run", given or command[1], *map(str, command[2:])]
