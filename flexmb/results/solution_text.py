"""Text and HTML of a solution: end of the run, saved instants, main peaks, notes, cost."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexmb.display import html
from flexmb.display.text import counted, cut, listed

if TYPE_CHECKING:
    from flexmb.results.solution import Solution

MAIN_ENDINGS = ("torque", "normal_force", "deflection", "von_mises")
"""Endings of the main signals: of drives, of contacts, of flexible links, of all bodies that deform."""

OTHER_ENDINGS = ("force", "ax", "ay", "alpha")
"""Endings of the signals that stand for the main ones where there are none."""

MOST_OF_A_KIND = 6
"""Largest number of main signals with one ending."""

ROUND_OFF = 1e-10
"""Peak over the largest one of its unit, up to which it is round-off."""

IN_TEXT, IN_TABLE = 3, 16
"""Number of peaks at most in a text and in a table."""


def largest_signals(sol: Solution) -> list[str]:
    """Names of the signals with the largest peaks.

    These are torques, contact forces, deflections and stresses; without any of them forces and accelerations.  Of each
    kind the `MOST_OF_A_KIND` largest ones are told.  Signals whose peaks are round-off beside those of other signals
    are left out, such as the forces of contacts that never close.
    """
    scales = _scales(sol)
    for endings in (MAIN_ENDINGS, OTHER_ENDINGS):
        told: list[str] = []
        for ending in endings:
            peaks = {name: sol.peak(name).value for name in sol.names if name.endswith(f".{ending}")}
            seen = [name for name, peak in peaks.items() if not peak <= ROUND_OFF * scales[sol.units(name)]]  # NaN is
            kept = sorted(seen, key=lambda name: -peaks[name])[:MOST_OF_A_KIND]
            told += [name for name in seen if name in kept]
        if told:
            return told
    return []


def _scales(sol: Solution) -> dict[str, float]:
    """Largest peak by unit; for moments at least the largest energy, for forces this energy over the largest length."""
    found: dict[str, float] = {}
    for unit, value in zip(sol.signals.units, sol.peaks.values, strict=True):
        found[unit] = max(found.get(unit, 0.0), float(value))  # a NaN is passed over
    energy, length = found.get("J", 0.0), found.get("m", 0.0)
    return found | {
        "N m": max(found.get("N m", 0.0), energy),
        "N": max(found.get("N", 0.0), energy / length if length > 0.0 else 0.0),
    }


def solution_text(sol: Solution) -> str:
    """Name and status; saved instants, signals, cost; main peaks and number of notes: three lines, five at most."""
    parts = f"{counted(len(sol.names), 'signal')} of {counted(len(_by_part(sol)), 'part')}"
    lines = [cut(f"Solution of {sol.name!r}: {sol.status}", 3), f"  {_saved(sol)}; {parts}; {_cost(sol)}"]
    peaks = [f"{name} {_peak(sol, name)}" for name in _largest(sol)[:IN_TEXT]]
    last = ["largest " + ", ".join(peaks)] if peaks else []
    last += [counted(len(sol.notes), "note") + " in sol.notes"] if sol.notes else []
    return "\n".join([*lines, *([cut(f"  {'; '.join(last)}")] if last else [])])


def solution_html(sol: Solution) -> str:
    """Table of the end of the run, the main peaks, notes, and the names of all signals on a click."""
    rows = [("saved", _saved(sol)), ("cost", str(sol.stats))]
    rows += [("contacts", listed(sol.contacts.names))] if sol.contacts.names else []
    peaks = [(name, *_peak_cells(sol, name)) for name in largest_signals(sol)[:IN_TABLE]]
    signals = html.table([(owner, ", ".join(names)) for owner, names in _by_part(sol).items()])
    return html.page(
        f"Solution of {sol.name!r}",
        sol.status,
        html.table(rows),
        html.table(peaks, ("signal", "largest absolute value", "unit", "at t [s]")),
        html.folded(counted(len(sol.notes), "note"), html.texts(sol.notes)) if sol.notes else "",
        html.folded(_signals(sol), signals),
    )


def _largest(sol: Solution) -> list[str]:
    """The main signals, one of each kind before others."""
    kinds: dict[str, int] = {}
    order = []
    for name in largest_signals(sol):
        ending = name.rpartition(".")[2]
        kinds[ending] = kinds.get(ending, 0) + 1
        order.append((kinds[ending], name))
    return [name for _, name in sorted(order, key=lambda entry: entry[0])]


def _peak(sol: Solution, name: str) -> str:
    return f"{sol.peak(name).value:.4g} {sol.units(name)}".rstrip()


def _peak_cells(sol: Solution, name: str) -> tuple[str, str, str]:
    value, time = sol.peak(name)
    return f"{value:.6g}", sol.units(name), f"{time:.6g}"


def _saved(sol: Solution) -> str:
    span = f", {sol.time[0]:.6g} to {sol.time[-1]:.6g} s" if len(sol.time) else ""
    return f"{counted(len(sol.time), 'instant')}{span}"


def _signals(sol: Solution) -> str:
    return f"{counted(len(sol.names), 'signal')} of {listed(_by_part(sol), 5) or 'no part'}"


def _by_part(sol: Solution) -> dict[str, list[str]]:
    """Names of signals within their part, by the name of the part."""
    found: dict[str, list[str]] = {}
    for name in sol.names:
        part, _, own = name.partition(".")
        found.setdefault(part, []).append(own)
    return found


def _cost(sol: Solution) -> str:
    return f"{counted(sol.stats.steps, 'step')} in {sol.stats.wall_time:.3g} s on the clock"
