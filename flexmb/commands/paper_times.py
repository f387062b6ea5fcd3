"""What the study took: processor time and time by the clock, of every run and every figure, and of all."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from flexmb.commands.paper_files import Cost, Kept, append_line, lines_of
from flexmb.commands.paper_progress import clock
from flexmb.paper.plate import Page, Plate, Run

EXPLANATION = """\
Times in seconds. The time by the clock of a run is that in its own process; of a diagram it is the sum over its values,
which are spread over all processes. A run is computed once, whatever number of figures shows it."""

CALLS = "calls.times"
"""Log of the calls of the command, beside the results of runs."""


def note_call(folder: Path, workers: int, runs: int, processor: float, wall: float) -> None:
    """Add a call of the command to the log.

    Parameters
    ----------
    folder : of the results of runs.
    workers : processes that shared the runs.
    runs : how many were computed.
    processor, wall : what they took, drawing included [s].
    """
    append_line(folder / CALLS, workers=workers, runs=runs, processor=processor, wall=wall)


def times(items: Sequence[Plate | Page], kept: Kept, drawn: Mapping[str, float], workers: int) -> str:
    """The tables as Markdown.

    Parameters
    ----------
    items : figures and pages of this call.
    kept : results of runs.
    drawn : processor time of drawing or writing, by label of figure or page [s].
    workers : processes of this call.
    """
    runs = {run.name: run for item in items for run in item.runs if kept.has(run)}
    users = {name: [label(item) for item in items if name in {r.name for r in item.runs}] for name in runs}
    costs = {name: kept.cost(run) for name, run in runs.items()}
    longest = sorted(runs, key=lambda name: -costs[name].processor)
    pieces = [
        "# What the study took",
        EXPLANATION,
        _table(["run", "processor", "clock", "shown by"], [_row(n, costs[n], users[n]) for n in longest]),
        _table(
            ["figure or page", "runs", "processor", "drawing", "runs that others show, too"],
            _items(items, costs, users, drawn),
        ),
        _whole(costs, drawn, kept.folder / CALLS, workers),
    ]
    return "\n\n".join(pieces) + "\n"


def label(item: Plate | Page) -> str:
    """What a figure or page is called."""
    return f"figure {item.number}" if isinstance(item, Plate) else item.name


def _row(name: str, cost: Cost, users: Sequence[str]) -> list[str]:
    if cost.measured == 0:
        return [name, "unknown", "unknown", ", ".join(users)]
    part = "" if cost.measured == cost.parts else f" ({cost.measured} of {cost.parts} values known)"
    return [name, f"{cost.processor:.1f}{part}", f"{cost.wall:.1f}", ", ".join(users)]


def _items(
    items: Sequence[Plate | Page],
    costs: Mapping[str, Cost],
    users: Mapping[str, Sequence[str]],
    drawn: Mapping[str, float],
) -> list[list[str]]:
    """Rows of figures and pages: the sum over their runs, and which of these others need, too."""
    rows = []
    for item in items:
        names: list[Run] = [run for run in item.runs if run.name in costs]
        shared = [run.name for run in names if len(users[run.name]) > 1]
        took = sum(costs[run.name].processor for run in names)
        there = str(len(names)) if len(names) == len(item.runs) else f"{len(names)} of {len(item.runs)}"
        made = f"{drawn[label(item)]:.1f}" if label(item) in drawn else "missing"
        least = "" if all(costs[run.name].measured == costs[run.name].parts for run in names) else "at least "
        rows.append([label(item), there, f"{least}{took:.1f}", made, ", ".join(shared)])
    return rows


def _whole(costs: Mapping[str, Cost], drawn: Mapping[str, float], log: Path, workers: int) -> str:
    """The whole study: its processor time, and by the clock what its calls took."""
    processor, calls = sum(cost.processor for cost in costs.values()), lines_of(log)
    drawing = sum(drawn.values())
    least = "" if all(cost.measured == cost.parts for cost in costs.values()) else "at least "
    text = f"All runs: {least}{clock(processor)} of processor time; drawing and writing {clock(drawing)}.\n"
    text += f"On {workers} processes the runs alone need {clock(processor / workers)} by the clock or more.\n\n"
    rows = [
        [str(k), str(c["workers"]), str(c["runs"]), f"{c['processor']:.1f}", f"{c['wall']:.1f}"]
        for k, c in enumerate(calls, 1)
    ]
    rows.append(
        [
            "all",
            "",
            str(sum(c["runs"] for c in calls)),
            *(f"{sum(c[n] for c in calls):.1f}" for n in ("processor", "wall")),
        ]
    )
    return text + _table(["call", "processes", "runs computed", "processor", "clock"], rows)


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)
