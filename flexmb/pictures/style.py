"""Style of all figures: colours, line styles, grid, labels of axes."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COLOURS = (
    "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#882255", "#117733", "#332288", "#999933",
)  # fmt: skip
"""Colours of curves and bodies; readers with colour blindness can distinguish them.

Sources: M. Okabe, K. Ito, Color universal design, 2008; P. Tol, Colour schemes, 2021.
"""

STYLES = ("-", (0, (5, 1.5)), (0, (6, 1.5, 1, 1.5)), (0, (1.2, 1.2)), (0, (6, 1.5, 1, 1.5, 1, 1.5)))
"""Line styles of the curves of a panel, which differ in print without colours."""

CLEARANCE = "#c00000"
"""Colour of joints with clearance."""

TRACED = "#7a3fb5"
"""Colour of markers and of their paths."""

DIVERGING = "RdYlBu_r"
"""Colour map of fields with both signs."""

SEQUENTIAL = "viridis"
"""Colour map of fields from 0 on."""

WIDTH = 1.1
"""Width of a curve [pt]."""


def curve(k: int) -> dict[str, Any]:
    """Colour and line style of the curve number k of a panel.

    Parameters
    ----------
    k : number of the curve, from 0.
    """
    return {"color": COLOURS[k % len(COLOURS)], "linestyle": STYLES[k % len(STYLES)], "linewidth": WIDTH}


def grid(ax: Axes) -> None:
    """Pale grid behind the curves.

    Parameters
    ----------
    ax : the axes.
    """
    ax.grid(visible=True, color="0.9", linewidth=0.6)
    ax.set_axisbelow(True)


def powers(ax: Axes) -> None:
    """Common power of ten at the end of an axis, where the numbers are small or large.

    Parameters
    ----------
    ax : the axes.
    """
    ax.ticklabel_format(axis="both", style="sci", scilimits=(-3, 4), useMathText=True)


def unit_text(units: str) -> str:
    """`units` with raised exponents: "m/s2" becomes "m/s$^{2}$"."""
    return re.sub(r"(?<=[A-Za-z])\^?(-?\d+)", r"$^{\1}$", units)


def words_of(field: str) -> str:
    """Name of a field of beams or meshes in words.

    Parameters
    ----------
    field : its name, such as "bending_moment".
    """
    return "von Mises stress" if field == "von_mises" else field.replace("_", " ")


def label_of(name: str, units: str, between: str = " ") -> str:
    """Label of an axis: name, and unit in brackets.

    Parameters
    ----------
    name : name of the signal.
    units : unit; "" for none.
    between : text between name and unit.
    """
    return between.join(text for text in (name, f"[{unit_text(units)}]" if units else "") if text)
