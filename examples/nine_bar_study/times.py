"""Page "times": processor time and wall-clock time of each run, each figure and the study."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from nine_bar_study.item import StudyFigure, StudyPage
from nine_bar_study.markdown import table
from nine_bar_study.progress import append_line, lines_of
from nine_bar_study.store import Cost, Kept

from flexmb.dynamics.jobs.progress import clock

EXPLANATION = """\
Times in seconds. The time by the clock of a run is that in its own process; of a diagram it is the sum over its values,
which are spread over all processes. A run is computed once, whatever number of figures shows it."""

RUN_HEAD = ("run", "processor", "clock", "shown by")
ITEM_HEAD = ("figure or page", "runs", "processor", "drawing", "runs that others show, too")
CALL_HEAD = ("call", "processes", "runs computed", "processor", "clock")

CALLS = "calls.times"
"""File name of the log of the calls of the command."""


def note_call(folder: Path, workers: int, runs: int, processor: float, wall: float) -> None:
    """Append a call of the command to the log.

    Parameters
    ----------
    folder : folder of the results of runs.
    workers : number of worker processes.
    runs : number of computed runs.
    processor, wall : processor time and wall-clock time of the call, including drawing [s].
    """
    append_line(folder / CALLS, workers=workers, runs=runs, processor=processor, wall=wall)


def times(items: Sequence[StudyFigure | StudyPage], kept: Kept, drawn: Mapping[str, float], workers: int) -> str:
    """Text of the page "times" in Markdown.

    Parameters
    ----------
    items : figures and pages of the call.
    kept : saved results of runs.
    drawn : processor time of drawing and writing [s], by label of the figure or page.
    workers : number of worker processes of the call.
    """
    runs = {run.name: run for item in items for run in item.runs if kept.has(run)}
    users = {name: [one.label for one in items if name in {run.name for run in one.runs}] for name in runs}
    costs = {name: kept.cost(run) for name, run in runs.items()}
    longest = sorted(runs, key=lambda name: -costs[name].cpu)
    pieces = [
        "# What the study took",
        EXPLANATION,
        table(RUN_HEAD, [_row(n, costs[n], users[n]) for n in longest], left=len(RUN_HEAD)),
        table(ITEM_HEAD, [_item(item, costs, users, drawn) for item in items], left=len(ITEM_HEAD)),
        _whole(costs, drawn, kept.folder / CALLS, workers),
    ]
    return "\n\n".join(pieces) + "\n"


def _least(costs: Iterable[Cost]) -> str:
    """Text "at least " if the times of some values are unknown; "" otherwise."""
    return "" if all(cost.measured == cost.parts for cost in costs) else "at least "


def _row(name: str, cost: Cost, users: Sequence[str]) -> list[str]:
    if cost.measured == 0:
        return [name, "unknown", "unknown", ", ".join(users)]
    part = "" if cost.measured == cost.parts else f" ({cost.measured} of {cost.parts} values known)"
    return [name, f"{cost.cpu:.1f}{part}", f"{cost.wall:.1f}", ", ".join(users)]


def _item(
    item: StudyFigure | StudyPage,
    costs: Mapping[str, Cost],
    users: Mapping[str, Sequence[str]],
    drawn: Mapping[str, float],
) -> list[str]:
    """Row of a figure or page: number and total time of its runs, time of drawing, runs shared with other items."""
    names = [run.name for run in item.runs if run.name in costs]
    took = [costs[name] for name in names]
    there = str(len(names)) if len(names) == len(item.runs) else f"{len(names)} of {len(item.runs)}"
    made = f"{drawn[item.label]:.1f}" if item.label in drawn else "missing"
    shared = ", ".join(name for name in names if len(users[name]) > 1)
    return [item.label, there, f"{_least(took)}{sum(cost.cpu for cost in took):.1f}", made, shared]


def _whole(costs: Mapping[str, Cost], drawn: Mapping[str, float], log: Path, workers: int) -> str:
    """Text of the processor time of the study, and table of the calls of the command."""
    processor, calls = sum(cost.cpu for cost in costs.values()), lines_of(log)
    text = f"All runs: {_least(costs.values())}{clock(processor)} of processor time; "
    text += f"drawing and writing {clock(sum(drawn.values()))}.\n"
    text += f"On {workers} processes the runs alone need {clock(processor / workers)} by the clock or more.\n\n"
    rows = [
        [str(k), str(c["workers"]), str(c["runs"]), f"{c['processor']:.1f}", f"{c['wall']:.1f}"]
        for k, c in enumerate(calls, 1)
    ]
    sums = (f"{sum(c[name] for c in calls):.1f}" for name in ("processor", "wall"))
    rows.append(["all", "", str(sum(c["runs"] for c in calls)), *sums])
    return text + table(CALL_HEAD, rows, left=len(CALL_HEAD))
