"""Journals in their bearings: orbit in the clearance circle, contact force over the direction of the contact."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexmb import checks
from flexmb.errors import InputError
from flexmb.model.part import Part, name_of
from flexmb.model.shape import PointShape
from flexmb.pictures.style import CLEARANCE, COLOURS, grid, label_axis

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from flexmb.results.solution import Solution

SIZE = (5.6, 5.4)  # of a figure [inch]


def plot_journal(
    sol: Solution,
    joint: Part | str,
    *,
    clearance: float | None = None,
    since: float | None = None,
    title: str | None = None,
) -> Figure:
    """Orbit of a journal: its centre relative to that of the bearing, and the circle of the clearance.

    Rows with contact are dots: beyond the circle by the penetration.

    Parameters
    ----------
    sol : the solution.
    joint : a revolute joint with clearance, or its name.
    clearance : radius of the circle [m]; None: from the rows with contact, eccentricity less penetration.
    since : begin of the orbit [s]; None: the begin of the run.
    title : title of the figure; None: the name of the joint.

    Raises
    ------
    InputError : no such joint; no saved row with contact from which the clearance is known; a time after the end.
    """
    from flexmb.pictures.figure import Picture

    joint = name_of(joint)
    rows = _rows("plot_journal", sol, joint, since)
    ex, ey = (sol.array(f"{joint}.{axis}")[rows] for axis in ("ex", "ey"))
    depth = sol.array(f"{joint}.penetration")[rows]
    touching = depth > 0.0
    if clearance is None:
        if not touching.any():
            text = f"plot_journal: no saved row of {joint!r} has contact, so its clearance is unknown here."
            raise InputError(f"{text} Give clearance=..., in m.")
        radius = float(np.median(np.hypot(ex, ey)[touching] - depth[touching]))
    else:
        radius = checks.positive("plot_journal", "clearance", clearance, "m")
    figure = Picture(figsize=SIZE, layout="constrained")
    ax = figure.subplots()
    grid(ax)
    turn = np.linspace(0.0, 2.0 * np.pi, 361)
    label = f"clearance {radius:.3g} m"
    ax.plot(radius * np.cos(turn), radius * np.sin(turn), color=CLEARANCE, linewidth=1.4, linestyle="--", label=label)
    ax.plot(ex, ey, color=COLOURS[0], linewidth=0.7, label="orbit")
    ax.plot(ex[touching], ey[touching], ".", color="black", markersize=2.5, linestyle="none", label="contact")
    ax.set_aspect("equal", adjustable="datalim")
    label_axis(ax.xaxis, f"{joint}.ex", "m", equal=ax.yaxis)
    label_axis(ax.yaxis, f"{joint}.ey", "m", equal=ax.xaxis)
    figure.legend(loc="outside lower center", ncols=3, frameon=False, fontsize="small")
    figure.suptitle(f"{sol.name}, journal of {joint}" if title is None else title)
    return figure


def plot_contact_force(
    sol: Solution, joint: Part | str, *, since: float | None = None, title: str | None = None
) -> Figure:
    """Normal force of a joint with clearance over the direction of the contact, in polar coordinates.

    The direction is that from the centre of the bearing to the journal, in world axes; 0 is to the right.  Dots are
    saved rows with contact.

    Parameters
    ----------
    sol : the solution.
    joint : a revolute joint with clearance, or its name.
    since : begin [s]; None: the begin of the run.
    title : title of the figure; None: the name of the joint.

    Raises
    ------
    InputError : no such joint, no saved row with contact, a time after the end.
    """
    from flexmb.pictures.figure import Picture

    joint = name_of(joint)
    rows = _rows("plot_contact_force", sol, joint, since)
    ex, ey, force = (sol.array(f"{joint}.{name}")[rows] for name in ("ex", "ey", "normal_force"))
    touching = force > 0.0
    if not touching.any():
        raise InputError(f"plot_contact_force: no saved row of {joint!r} has contact. Run longer, or save more rows.")
    figure = Picture(figsize=SIZE, layout="constrained")
    ax = figure.add_subplot(projection="polar")
    angle = np.arctan2(ey, ex)[touching]
    ax.vlines(angle, 0.0, force[touching], color=COLOURS[0], linewidth=0.5, alpha=0.35)
    ax.plot(angle, force[touching], ".", color=COLOURS[0], markersize=3.0, linestyle="none")
    ax.set_ylim(0.0, 1.05 * float(force.max()))
    ax.set_rlabel_position(_emptiest(angle))  # type: ignore[attr-defined]
    ax.grid(visible=True, color="0.9", linewidth=0.6)
    name = f"{sol.name}, normal force of {joint} [N] over the direction of the contact"
    figure.suptitle(name if title is None else title, fontsize="medium")
    return figure


def _rows(label: str, sol: Solution, joint: str, since: float | None) -> np.ndarray:
    """Rows from `since` on; a joint without journal is refused."""
    journals = [s.part for s in sol.shapes if isinstance(s, PointShape) and s.along is None and f"{s.part}.ex" in sol]
    checks.one_of(label, "joint", joint, journals)
    begin = -np.inf if since is None else checks.number(label, "since", since, "s")
    rows = np.flatnonzero(sol.time >= begin)
    if not len(rows):
        raise InputError(f"{label}: since is {begin:g} s, after the end of the motion. Give an earlier time.")
    return rows


def _emptiest(angles: np.ndarray) -> float:
    """Direction [deg] in the middle of the widest gap of some angles [rad], for numbers that hide nothing."""
    ordered = np.sort(angles)
    gaps = np.diff(np.append(ordered, ordered[0] + 2.0 * np.pi))
    k = int(gaps.argmax())
    return float(np.degrees(ordered[k] + 0.5 * gaps[k]))
