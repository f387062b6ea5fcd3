"""Campbell diagram: natural frequencies of a turning mechanism over its speed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from flexmb import checks
from flexmb.equilibrium.modes import modes
from flexmb.equilibrium.statics import static_equilibrium
from flexmb.errors import InputError
from flexmb.pictures.style import curve, grid, label_axis

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from flexmb.model.mechanism import Mechanism

SIZE = (7.5, 5.0)  # of a figure [inch]


def plot_campbell(
    mechanism: Mechanism,
    speeds: Sequence[float] | np.ndarray,
    *,
    count: int = 4,
    orders: Sequence[float] = (1.0, 2.0, 3.0, 4.0),
    about: tuple[float, float] = (0.0, 0.0),
    title: str | None = None,
) -> Figure:
    """Campbell diagram: natural frequencies over the speed of rotation, and the multiples of the speed.

    At each speed the mechanism is at rest in a frame that turns (`static_equilibrium(spin=...)`), and its modes are
    seen from that frame.  A resonance is possible where a frequency crosses a multiple of the speed.  Frequencies of
    unstable and overdamped motions are left out; curves join frequencies of equal rank.

    Parameters
    ----------
    mechanism : the mechanism, whose drives turn at the speed or are clamps.
    speeds : speeds of rotation [rad/s], increasing, two at least.
    count : number of frequencies.
    orders : multiples of the speed that are drawn.
    about : centre of the rotation [m].
    title : title of the figure; None: the name of the mechanism.

    Raises
    ------
    InputError : fewer than two speeds, speeds that do not increase; see `static_equilibrium` and `modes`.
    SolveError : see `static_equilibrium` and `modes`.
    """
    from flexmb.pictures.figure import Picture

    given = [checks.number("plot_campbell", f"speeds[{k}]", float(w), "rad/s") for k, w in enumerate(speeds)]
    if len(given) < 2 or np.any(np.diff(given) <= 0.0):
        raise InputError(f"plot_campbell: speeds are {given}; they must be two or more, increasing.")
    number = checks.count("plot_campbell", "count", count)
    found = np.array([_frequencies(mechanism, w, number, about) for w in given])
    figure = Picture(figsize=SIZE, layout="constrained")
    ax = figure.subplots()
    grid(ax)
    for order in orders:
        line = order * np.array(given) / (2.0 * np.pi)
        ax.plot(given, line, color="0.6", linewidth=0.9, linestyle=(0, (4, 3)), zorder=1.5)
        text = f"{order:g}x"
        ax.annotate(
            text, (given[-1], line[-1]), xytext=(4, 0), textcoords="offset points", va="center", fontsize="small"
        )
    for k, frequency in enumerate(found.T):
        ax.plot(given, frequency, marker="o", markersize=3.0, label=f"mode {k + 1}", **curve(k))
    label_axis(ax.xaxis, "speed", "rad/s")
    label_axis(ax.yaxis, "natural frequency", "Hz")
    ax.set_xlim(given[0], given[-1])
    ax.set_ylim(0.0, 1.08 * float(np.nanmax(found)) if np.isfinite(found).any() else 1.0)
    figure.legend(loc="outside right upper", frameon=False, fontsize="small")
    figure.suptitle(mechanism.name if title is None else title)
    return figure


def _frequencies(mechanism: Mechanism, speed: float, count: int, about: tuple[float, float]) -> np.ndarray:
    """Lowest frequencies of elastic motions [Hz]; NaN where there are fewer."""
    state = static_equilibrium(mechanism, spin=speed, about=about)
    found = modes(mechanism, count=2 * count, at=state)
    elastic = [f for f, kind in zip(found.frequencies, found.kinds, strict=True) if kind == "elastic"][:count]
    return np.array([*elastic, *[np.nan] * (count - len(elastic))])
