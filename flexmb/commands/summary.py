"""Summary of a run: status, cost, stroke, peaks of the main signals, balance of energies."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from flexmb.model.mechanism import Mechanism
from flexmb.model.part import GROUND
from flexmb.results.contact_intervals import IMPACT, Episodes
from flexmb.results.main_signals import followed, main_signals, slides
from flexmb.results.solution import Solution


def table(mechanism: Mechanism, sol: Solution) -> str:
    """Text of the summary of a run."""
    rows = [*_run_rows(sol), *_path_rows(mechanism, sol), *_contact_rows(sol)]
    lines = [f"{name:<22s}{text}" for name, text in rows]
    peaks = [(name, sol.peak(name)) for name in main_signals(sol)]
    if peaks:
        lines += ["", f"{'largest absolute value':<34s}{'of all steps':>14s}          at t [s]"]
        lines += [f"  {name:<32s}{p.value:>14.6g} {sol.units(name):<8s}{p.time:>9.6g}" for name, p in peaks]
    return "\n".join(lines)


def _run_rows(sol: Solution) -> Iterator[tuple[str, str]]:
    stats = sol.stats
    yield "mechanism", sol.name
    yield "status", sol.status
    yield (
        "steps",
        (
            f"{stats.steps} of {stats.smallest_step:.3g} to {stats.largest_step:.3g} s, {stats.rejected} rejected, "
            f"{stats.newton_iterations} Newton iterations"
        ),
    )
    yield "wall time", f"{stats.wall_time:.3g} s"
    if len(sol.time):
        yield "saved", f"{len(sol.time)} instants from {sol.time[0]:.6g} to {sol.time[-1]:.6g} s"
    if "energy.residual" in sol and "energy.turned_over" in sol:
        residual, turned = sol.peak("energy.residual").value, sol.peak("energy.turned_over").value
        share = f" ({residual / turned:.2g} of the energy turned over)" if turned > 0.0 else ""
        yield "energy residual", f"{residual:.3g} J{share}"
    yield from (("note", text) for text in sol.notes)


def _path_rows(mechanism: Mechanism, sol: Solution) -> Iterator[tuple[str, str]]:
    """Stroke of a slider along its guide, or swing of the last body, over the saved instants."""
    body = followed(mechanism)
    if body is None or not len(sol.time):
        return
    guide = slides(mechanism, body)
    if guide is not None and guide.first.name == GROUND.name:
        along = np.array(guide.along) / np.hypot(*guide.along)
        travel = along[0] * sol.array(f"{body.name}.x") + along[1] * sol.array(f"{body.name}.y")
        yield f"stroke of {body.name}", f"{np.ptp(travel):.6g} m"
    else:
        yield f"swing of {body.name}", f"{np.ptp(sol.array(f'{body.name}.theta')):.6g} rad"


def _contact_rows(sol: Solution) -> Iterator[tuple[str, str]]:
    """Rows of each contact: share of saved instants in contact, largest penetration, impacts."""
    for name in (n.rpartition(".")[0] for n in sol.names if n.endswith(".penetration")):
        depth = sol.array(f"{name}.penetration")
        if len(depth):
            share, deepest = 100.0 * np.mean(depth > 0.0), sol.peak(f"{name}.penetration").value
            yield f"contact in {name}", f"{share:.3g} % of the saved instants; deepest {max(deepest, 0.0):.3g} m"
    for name in sol.contacts.names:
        yield f"impacts in {name}", impacts(sol.episodes(name))


def impacts(episodes: Episodes) -> str:
    """Number of impacts, longest free flight, largest impulse of an impact."""
    hits = episodes[episodes.mode == IMPACT]
    lasting = len(episodes) - len(hits)
    text = f"{len(hits)}"
    if lasting:
        text += f" and {lasting} continuous contact{'' if lasting == 1 else 's'}"
    if len(hits):
        text += f", largest impulse {hits.impulse.max():.3g} N s"
    flights = episodes.flight[np.isfinite(episodes.flight)]
    if len(flights):
        text += f", longest flight {flights.max():.3g} s"
    return text
