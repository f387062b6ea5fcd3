"""Joints with clearance on a page: path of the journal in its bearing, contact intervals."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmb.reports.markup import Markup, facts, quantity, section, table, tag
from flexmb.reports.packing import MIDDLE, floats, quantised
from flexmb.results.contact_intervals import MODES, Episodes
from flexmb.results.solution import Solution

ROUND = 1e-6
"""Relative spread of |e| + gap, below which the journal moves in a circle."""

MOST_POINTS = 4000
"""Number of points of a path."""

MOST_EPISODES = 300
"""Number of listed contact intervals of a joint."""


def clearance_of(sol: Solution, joint: str) -> float | None:
    """Radius of the circle in which the centre of a journal moves freely [m]; None for a joint of another form."""
    names = [f"{joint}.{signal}" for signal in ("ex", "ey", "penetration")]
    if not len(sol.time) or not all(name in sol for name in names):
        return None
    ex, ey, depth = (sol.array(name) for name in names)
    radius = np.hypot(ex, ey) - depth
    middle = float(np.median(radius))
    return middle if middle > 0.0 and np.ptp(radius) < ROUND * middle else None


def joints_with_contacts(sol: Solution) -> list[str]:
    """Names of all joints with contacts, journals in bearings first."""
    named = [name.partition(".")[0] for name in sol.contacts.names]
    named += [name.rpartition(".")[0] for name in sol.names if name.endswith(".ex") and name.count(".") == 1]
    joints = list(dict.fromkeys(named))
    return sorted(joints, key=lambda joint: clearance_of(sol, joint) is None)


def clearance_data(sol: Solution, frames: np.ndarray) -> list[dict[str, Any]]:
    """Journals for the scripts: clearance, values at the frames, and the path over all saved instants."""
    every = np.unique(np.linspace(0, len(sol.time) - 1, MOST_POINTS).round().astype(int))
    found = []
    for joint in joints_with_contacts(sol):
        clearance = clearance_of(sol, joint)
        if clearance is None:
            continue
        pair = np.stack([sol.array(f"{joint}.ex"), sol.array(f"{joint}.ey")], axis=1)
        depth, force = (_column(sol, f"{joint}.{name}") for name in ("penetration", "normal_force"))
        now = np.column_stack([pair[frames], depth[frames], force[frames]])
        touching = "".join("1" if x > 0.0 else "0" for x in depth[every])
        path = {"path": quantised(pair[every], MIDDLE), "touching": touching}
        found.append({"joint": joint, "clearance": clearance, "now": floats(now), **path})
    return found


def _column(sol: Solution, name: str) -> np.ndarray:
    return np.nan_to_num(sol.array(name)) if name in sol else np.zeros(len(sol.time))


def clearance_section(sol: Solution) -> Markup | None:
    """Section of all joints with contacts; None for a solution without them."""
    joints = joints_with_contacts(sol)
    if not joints:
        return None
    return section("Joints with clearance", *(_joint(sol, joint) for joint in joints), anchor="clearances")


def _joint(sol: Solution, joint: str) -> Markup:
    """Picture, facts and contact intervals of a joint."""
    clearance = clearance_of(sol, joint)
    episodes = sol.episodes(joint) if _has_contact(sol, joint) else None
    rows: list[tuple[str, str | None]] = []
    if clearance is not None:
        rows.append(("clearance", quantity(clearance, "m")))
    if f"{joint}.penetration" in sol and len(sol.time):
        depth = sol.array(f"{joint}.penetration")
        rows.append(("in contact", f"{100.0 * np.mean(depth > 0.0):.3g} % of the saved instants"))
        rows.append(("largest penetration", _peak(sol, f"{joint}.penetration")))
    if f"{joint}.normal_force" in sol:
        rows.append(("largest normal force", _peak(sol, f"{joint}.normal_force")))
    if episodes is not None:
        rows.append(("contact intervals", _counts(episodes)))
    label = f"Journal of joint {joint} in its bearing, with the path of its centre"
    picture = tag("canvas", class_="journal", role="img", aria_label=label, data_joint=joint)
    left = tag("div", picture if clearance is not None else None, facts(rows), class_="journal-side")
    listing = None if episodes is None else _intervals(episodes, joint)
    return tag("article", tag("h3", joint), tag("div", left, listing, class_="joint"), class_="card")


def _has_contact(sol: Solution, joint: str) -> bool:
    return any(name.partition(".")[0] == joint for name in sol.contacts.names)


def _peak(sol: Solution, name: str) -> str:
    peak = sol.peak(name)
    return f"{quantity(peak.value, sol.units(name))} at t = {peak.time:.6g} s"


def _counts(episodes: Episodes) -> str:
    counts = [(int((episodes.mode == mode).sum()), word) for mode, word in MODES.items()]
    words = {"impact": "impacts", "continuous": "continuous contacts"}
    return ", ".join(f"{count} {words[word]}" for count, word in counts if count) or "none"


def _intervals(episodes: Episodes, joint: str) -> Markup:
    """Table of contact intervals, each with a button that goes to its start."""
    if not len(episodes):
        return tag("p", "The surfaces did not touch.")
    caption, several = f"Contact intervals of {joint}", len(set(episodes.contact)) > 1
    if len(episodes) > MOST_EPISODES:
        strongest = np.sort(np.argsort(-episodes.peak_force, kind="stable")[:MOST_EPISODES])
        caption += f": the {MOST_EPISODES} with the largest forces of {len(episodes)}"
        episodes = episodes[strongest]
    rows = []
    for e in episodes:
        when = e.start if np.isfinite(e.start) else e.end
        shown = f"{e.start:.6g}" if np.isfinite(e.start) else "before"
        times = {"data_time": f"{when:.9g}", "data_end": f"{e.end:.9g}"} if np.isfinite(when) else {}
        go = tag("button", shown, type="button", class_="go", **times)
        numbers = (e.duration, e.approach_speed, e.peak_force, e.impulse, e.dissipated_contact)
        cells = ["-" if not np.isfinite(x) else f"{x:.4g}" for x in numbers]
        rows.append([go, *([e.contact] if several else []), MODES.get(e.mode, str(e.mode)), *cells])
    heads = ["onset [s]", *(["contact"] if several else []), "kind", "duration [s]", "approach [m/s]"]
    heads += ["largest force [N]", "impulse [N s]", "loss [J]"]
    return tag("div", table(caption, heads, rows, numbers=range(len(heads) - 5, len(heads))), class_="intervals")
