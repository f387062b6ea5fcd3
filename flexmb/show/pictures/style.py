"""Figures and their style: colours, line styles, grid, labels of axes; characters that a font has; files."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

from flexmb.dynamics.jobs.files import whole_file
from flexmb.late import mpl

EMPTY = "Last Resort"  # beginning of the name of a font of matplotlib that has a box for each script, and no characters


def make_drawable(texts: Iterable[mpl.text.Text]) -> None:
    r"""Set the fonts of texts by their characters; characters without a font become escapes such as \u66f2."""
    for text in texts:
        words = text.get_text()
        if words.isascii():
            continue
        own = mpl.font_manager.findfont(text.get_fontproperties())
        fonts = {c: _family(own, c) for c in words}
        shown = (c.encode("ascii", "backslashreplace").decode() if fonts[c] is None else c for c in words)
        text.set_text("".join(shown))
        others = [name for name in dict.fromkeys(fonts.values()) if name and name not in text.get_fontfamily()]
        text.set_fontfamily([*text.get_fontfamily(), *others])


@cache
def _family(own: str, character: str) -> str | None:
    """Family of a font that has a character: "" for the file `own`, None where no font has it."""
    if character.isspace() or _has(own, character):
        return ""
    known = mpl.font_manager.fontManager.ttflist
    fonts = [font for font in known if font.style == "normal" and not font.name.startswith(EMPTY)]
    return next((font.name for font in fonts if _has(font.fname, character)), None)


def _has(file: str, character: str) -> bool:
    """Whether a file is a font that can be drawn and has a character."""
    try:
        return mpl.font_manager.get_font(file).get_char_index(ord(character)) > 0
    except (OSError, RuntimeError):  # fonts of coloured pictures, and damaged files
        return False


def new_figure(size: tuple[float, float]) -> mpl.figure.Figure:
    """Figure of a size [inch]; saving it makes the folder of the file, drawing it finds fonts for all characters."""
    return _picture()(figsize=size, layout="constrained")


@cache
def _picture() -> type[mpl.figure.Figure]:
    """Class of these figures; pages of reports read this file, and need no matplotlib."""

    class Picture(mpl.figure.Figure):
        def __reduce__(self) -> tuple[Any, ...]:
            return new_figure, (tuple(self.get_size_inches()),), self.__getstate__()

        def draw(self, renderer: Any) -> None:
            """Draw the figure."""
            make_drawable(texts_of(self))
            super().draw(renderer)

        def savefig(self, fname: Any, **options: Any) -> None:
            """Save the figure as a file, which is there as a whole or not at all, or into an open file."""
            # Options are those of `matplotlib.figure.Figure.savefig`. A path that cannot be written and an ending that
            # is no kind of picture raise `InputError`.
            if not isinstance(fname, (str, Path)):
                super().savefig(fname, **options)
                return
            path = Path(fname)
            if not path.suffix:
                path = path.with_name(f"{path.name}.{options.get('format') or mpl.rcParams['savefig.format']}")
            with whole_file(path) as part, settled(self):
                super().savefig(part, **options)

    return Picture


@contextmanager
def settled(figure: mpl.figure.Figure) -> Iterator[None]:
    """Figure whose panels keep the places that its layout gives them now; matplotlib would draw it once more for it."""
    engine = figure.get_layout_engine()
    if engine is not None:
        lay_out(figure)
        figure.set_layout_engine(None)
    try:
        yield
    finally:
        if engine is not None:
            figure.set_layout_engine(engine)


def texts_of(figure: mpl.figure.Figure) -> list[mpl.text.Text]:
    """All texts of a figure."""
    return [text for text in figure.findobj(mpl.text.Text) if isinstance(text, mpl.text.Text)]


def lay_out(figure: mpl.figure.Figure) -> None:
    """Give the panels their places."""
    engine = figure.get_layout_engine()
    if engine is not None:
        make_drawable(texts_of(figure))
        engine.execute(figure)
    for ax in figure.axes:
        ax.apply_aspect()


# Colours of curves, and of bodies and beams without a field, also on pages (`palette` of `show/reports/document.py`);
# the colour-blind can tell them apart.
# Sources: M. Okabe, K. Ito, Color universal design, 2008; P. Tol, Colour schemes, 2021.
COLOURS = (
    "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#882255", "#117733", "#332288", "#999933",
)  # fmt: skip

# Line styles of the curves of a panel, which differ in print without colours.
STYLES = ("-", (0, (5, 1.5)), (0, (6, 1.5, 1, 1.5)), (0, (1.2, 1.2)), (0, (6, 1.5, 1, 1.5, 1, 1.5)))
CLEARANCE = "#c00000"  # colour of joints with clearance
TRACED = "#7a3fb5"  # colour of markers and of their paths
DIVERGING = "RdYlBu_r"  # colours of fields of both signs; pages: --low to --high of reports/assets/page.css
SEQUENTIAL = "viridis"  # colour map of fields from 0 on
WIDTH = 1.1  # width of a curve [pt]


def curve(k: int) -> dict[str, Any]:
    """Colour and line style of the curve number k of a panel, from 0."""
    return {"color": COLOURS[k % len(COLOURS)], "linestyle": STYLES[k % len(STYLES)], "linewidth": WIDTH}


def grid(ax: mpl.axes.Axes) -> None:
    """Pale grid behind the curves."""
    ax.grid(visible=True, color="0.9", linewidth=0.6)
    ax.set_axisbelow(True)


def panels_of(
    size: tuple[float, float], title: str = "", *, rows: int = 1, columns: int = 1, **sharing: Any
) -> tuple[mpl.figure.Figure, list[mpl.axes.Axes]]:
    """Figure of a size [inch] with a title and panels on pale grids, row by row; `sharing` as of matplotlib."""
    figure = new_figure(size)
    axes = list(figure.subplots(rows, columns, squeeze=False, **sharing).flat)
    for ax in axes:
        grid(ax)
    if title:
        figure.suptitle(title)
    return figure, axes


def panel_of(size: tuple[float, float], title: str = "") -> tuple[mpl.figure.Figure, mpl.axes.Axes]:
    """Figure of one panel, as of `panels_of`."""
    figure, axes = panels_of(size, title)
    return figure, axes[0]


def legend_beside(ax: mpl.axes.Axes, **more: Any) -> None:
    """Legend beside a panel: inside it would hide some part of the curves."""
    ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, fontsize="small", **more)


PREFIXES = {-9: "n", -6: "µ", -3: "m", 3: "k", 6: "M", 9: "G"}  # prefixes of units by power of ten
RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
LEAST, MOST = 0.1, 1e4  # largest number of an axis, below and above which its unit gets a prefix
FLAT = 1e-4  # extent of an axis over its largest number, below which labels show the difference from a common number


def prefixed(units: str, largest: float) -> tuple[int, str]:
    """Power of ten and unit with a prefix in which `largest` has one to three digits before the point."""
    # Metres and seconds get no prefix above 1; the power is 0 for a unit that takes none, such as "rad" or "m2".
    takes = re.match(r"(m|s|N|Pa|J|W|Hz|A|V)(?![A-Za-z0-9^])", units)
    if takes is None or not 0.0 < largest < math.inf or LEAST <= largest < MOST:
        return 0, units
    power = 3 * math.floor(math.log10(largest) / 3.0)
    if power not in PREFIXES or (power > 0 and takes[1] in ("m", "s")):
        return 0, units
    return power, PREFIXES[power] + units


def label_axis(
    axis: mpl.axis.Axis, name: str, units: str, between: str = " ", equal: mpl.axis.Axis | None = None
) -> None:
    """Label and numbers of an axis on which everything is drawn: small and large numbers by a prefix of the unit."""
    # Where the unit takes no prefix, a common power of ten stands at the end of the axis. `equal` is another axis of
    # this unit that gets the same prefix.
    low, high = axis.get_view_interval()
    largest = max(abs(float(end)) for one in (axis, equal or axis) for end in one.get_view_interval())
    is_flat = abs(high - low) <= FLAT * largest
    power, shown = (0, units) if is_flat else prefixed(units, largest)
    if power:
        shorten = mpl.ticker.FuncFormatter(lambda value, _: f"{value * 10.0**-power:.6g}".replace("-", "−"))
        axis.set_major_formatter(shorten)
    else:
        numbers = _numbers()(useMathText=False)
        numbers.set_powerlimits((-3, 4))
        axis.set_major_formatter(numbers)
    axis.set_label_text(label_of(name, shown, between))


@cache
def _numbers() -> type[mpl.ticker.ScalarFormatter]:
    """Class of the numbers of axes."""

    class Numbers(mpl.ticker.ScalarFormatter):
        def get_offset(self) -> str:
            """Common power of ten and common number, by characters, since formulas take ten times as long."""
            text = super().get_offset().replace("\N{MINUS SIGN}", "-")
            return re.sub(r"(?:^1)?e\+?(-?\d+)", lambda found: f"×10{found[1].translate(RAISED)}", text)

    return Numbers


def unit_text(units: str) -> str:
    """`units` with raised exponents: "m/s2" becomes "m/s²", by characters, since formulas take long to set."""
    return re.sub(r"(?<=[A-Za-z])\^?(-?\d+)", lambda found: found[1].translate(RAISED), units)


def words_of(field: str) -> str:
    """Name of a field of beams or meshes in words, as of "bending_moment"."""
    return "von Mises stress" if field == "von_mises" else field.replace("_", " ")


def label_of(name: str, units: str, between: str = " ") -> str:
    """Label of an axis: name, and unit in brackets; "" for no unit."""
    return between.join(text for text in (name, f"[{unit_text(units)}]" if units else "") if text)
