"""The page of docs/validation.py: its text, its tables, its figures."""

import datetime
import importlib.metadata
import math
import os
import platform
import re
import textwrap
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure as Canvas

HEAD = """\
# Validation

flexmb beside published, exact and independently computed values. This page is written by `make validation` (`python
docs/validation.py`); each problem is a file of `tests/literature`, which states the model from the framework's parts,
computes it, and is a test as well: `tests/literature/test_NAME.py`."""

KEY = """\
An error is relative to its reference; marked "abs" it is a difference in the unit of the quantity, marked "of X" it is
over X. It holds when it is within its band; what is known to miss its band says why. "worst" is the largest error over
its band. Wall times are without compilation."""

VALUE_HEAD = "| case | quantity | reference | ours | error | band | wall time [s] |\n|---|---|---:|---:|---:|---:|---:|"
SUMMARY_HEAD = "| problem | source | values | worst error over band | wall time [s] |\n|---|---|---:|---:|---:|"
COLOURS = ("#1b6ca8", "#d1495b", "#2e8b57", "#e08e0b", "#6a4c93", "#00838f", "#8d5524", "#607d8b")
MARKERS = "osD^vPX*"
PASSAGE = re.compile(r"<!-- (\w+): begin -->\n(.*?)\n<!-- \1: end -->", re.DOTALL)
ROW = re.compile(r"^\| \[[^\n]*?\]\(#(\w+)\).*\|$", re.MULTILINE)


def write(path: Path, results: Sequence, *, keep_others: bool) -> None:
    """The whole page; with `keep_others`, what it says of problems that are not in `results` stays."""
    before = path.read_text(encoding="utf-8") if keep_others and path.is_file() else ""
    passages = dict(PASSAGE.findall(before))
    rows = {match[1]: match[0] for match in ROW.finditer(before)}
    about_machine = passages.pop("machine", machine())
    for result in results:
        passages[result.name], rows[result.name] = passage(result, alone=keep_others), row(result)
    parts = [HEAD, marked("machine", about_machine), KEY]
    parts.append("\n".join([SUMMARY_HEAD, *(rows[name] for name in sorted(rows))]))
    parts += [marked(name, passages[name]) for name in sorted(passages)]
    path.write_text("\n\n".join(parts) + "\n", encoding="utf-8")


def marked(name: str, text: str) -> str:
    """A passage between its marks."""
    return f"<!-- {name}: begin -->\n{text}\n<!-- {name}: end -->"


def machine() -> str:
    """The machine, the versions and the date."""
    packages = ("numpy", "scipy", "numba", "flexmb")
    versions = ", ".join(f"{name} {version(name)}" for name in packages)
    return wrapped(
        f"Computed on {datetime.datetime.now(datetime.UTC):%Y-%m-%d} on {processor()}, {os.cpu_count()} cores, "
        f"{platform.system()}, with Python {platform.python_version()}, {versions}."
    )


def version(package: str) -> str:
    """Version of an installed package, or of this one where it runs from its sources."""
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return "(from its sources)"


def processor() -> str:
    """Name of the CPU as the system gives it."""
    listed = Path("/proc/cpuinfo")
    lines = listed.read_text(encoding="utf-8").splitlines() if listed.is_file() else []
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return models[0] if models else platform.processor() or platform.machine()


def wrapped(text: str) -> str:
    """Paragraphs, as wide as the page."""
    paragraphs = re.split(r"\n\s*\n", text.strip())
    return "\n\n".join(textwrap.fill(" ".join(p.split()), 120, break_on_hyphens=False) for p in paragraphs)


def row(result) -> str:
    """The problem in the first table."""
    title, source = (result.problem.title, result.problem.source) if result.problem else (result.name, "-")
    count = len(result.values) or "-"
    return f"| [{cell(title)}](#{result.name}) | {cell(source)} | {count} | {worst(result)} | {seconds(result.wall)} |"


def worst(result) -> str:
    """Largest error over its band, and what must be known beside it."""
    regular = [ratio(v) for v in result.values if not v.missed]
    words = [f"{max(regular):.2g}"] if regular else []
    missed = sum(bool(v.missed) for v in result.values)
    outside = sum(not v.holds for v in result.values)
    flat = sum(not steep_enough(c) for f in result.figures for c in f.curves)
    failed = bool(result.failure) + sum(bool(part.failure) for part in (*result.cases, *result.figures))
    words += [f"{missed} known to miss"] if missed else []
    words += [f"**{outside} out of band**"] if outside else []
    words += [f"**{flat} below its order**"] if flat else []
    words += [f"**{failed} failed**"] if failed else []
    return ", ".join(words) or "-"


def ratio(value) -> float:
    """Error over band; infinite for what is not a number."""
    error = value.error
    if math.isnan(error):
        return math.inf
    return error / value.band if value.band else (math.inf if error else 0.0)


def steep_enough(curve) -> bool:
    """Whether a curve falls with its order (as the tests ask)."""
    return curve.slope >= curve.order - curve.slack


def verdict(value) -> str:
    """What is wrong with a value that does not hold."""
    text = f"{value.ours!r} against {value.reference!r}, error {value.error:.2e}, band {value.band:.0e}"
    if not value.missed:
        return text
    if value.error <= value.band:
        return f"{text}; within its band, though said to miss it: take `missed` away"
    return f"{text}; beyond the limit {value.limit or 0.0:.0e} of what is known to miss its band"


def passage(result, *, alone: bool) -> str:
    """All that is said of a problem."""
    parts = [f'<a id="{result.name}"></a>\n\n## {result.problem.title if result.problem else result.name}']
    if result.failure:
        parts.append(wrapped(f"**Failed:** {result.failure}"))
    if result.problem:
        problem = result.problem
        parts.append(wrapped(problem.about))
        about = f"Source: {problem.source} Kind: {problem.kind}. File: `tests/literature/test_{result.name}.py`."
        if alone:
            about += f" Computed on {datetime.datetime.now(datetime.UTC):%Y-%m-%d}, after the rest of the page."
        parts.append(wrapped(about))
    if result.left_out:
        count = f"{result.left_out} slow " + ("case or figure is" if result.left_out == 1 else "cases or figures are")
        parts.append(f"A fast run: {count} left out.")
    if result.cases:
        parts.append("\n".join([VALUE_HEAD, *(line for case in result.cases for line in case_rows(case))]))
    parts += reasons(result)
    parts += [figure_text(figure) for figure in result.figures]
    return "\n\n".join(parts)


def case_rows(case) -> list[str]:
    """Lines of the table of values; title and time stand in the first one."""
    if case.failure:
        return [f"| {cell(case.title)} | **failed:** {cell(case.failure)} | | | | | |"]
    rows = []
    for k, value in enumerate(case.values):
        title, wall = (cell(case.title), seconds(case.wall)) if k == 0 else ("", "")
        pair = f"{value.reference:.10g} | {value.ours:.10g}"
        rows.append(f"| {title} | {cell(value.quantity)} | {pair} | {error_of(value)} | {value.band:.2g} | {wall} |")
    return rows


def error_of(value) -> str:
    """The error, what it is measured in, and whether it holds."""
    text = f"{value.error:.1e}"
    if value.scale is not None:
        text += " abs" if value.scale == 1.0 else f" of {value.scale:.4g}"
    if not value.holds:
        return f"**{text}, out of band**"
    return f"{text}, misses" if value.missed else text


def reasons(result) -> list[str]:
    """Why values miss their bands; equal reasons are said once."""
    by_reason: dict[str, list] = {}
    for value in result.values:
        if value.missed:
            by_reason.setdefault(value.missed, []).append(value)
    return [
        wrapped(
            f"Misses its band: {'; '.join(dict.fromkeys(v.quantity for v in values))}. {reason} "
            f"Held to {max(v.limit or 0.0 for v in values):g} instead."
        )
        for reason, values in by_reason.items()
    ]


def figure_text(result) -> str:
    """A figure with its caption and the measured slopes."""
    caption = result.figure.caption
    if result.failure:
        return wrapped(f"**Failed:** figure {result.figure.name}: {result.failure}")
    text = f"![{' '.join(caption.split())}](pictures/{result.file})\n\n{wrapped(caption)}"
    if not result.curves:
        return text
    slopes = [
        f"{c.label} {c.slope:.2f} (at least {c.order - c.slack:g}" + (")" if steep_enough(c) else "; **too flat**)")
        for c in result.curves
    ]
    return f"{text}\n\n{wrapped('Measured slopes: ' + '; '.join(slopes) + '.')}"


def seconds(wall: float) -> str:
    """A wall time [s] to two digits or a tenth, without an exponent."""
    return f"{wall:.1f}" if wall >= 1.0 else f"{wall:.2g}"


def cell(text: str) -> str:
    """Text that may stand in a table."""
    return " ".join(str(text).split()).replace("|", "\\|")


def canvas() -> Canvas:
    """An empty figure of the page's size."""
    return Canvas(figsize=(7.2, 4.6), dpi=110, layout="constrained")


def draw_picture(figure, path: Path) -> None:
    """The drawing that a problem makes."""
    target = canvas()
    figure.draw(target)
    save(target, path)


def draw_curves(figure, curves: Sequence, path: Path) -> None:
    """Errors over sizes in logarithms, the measured slopes in the legend, dashed lines of the expected order."""
    target = canvas()
    ax = target.add_subplot()
    for k, curve in enumerate(curves):
        x, errors = np.asarray(curve.x, dtype=float), np.asarray(curve.errors, dtype=float)
        style = {"color": COLOURS[k % len(COLOURS)], "marker": MARKERS[k % len(MARKERS)], "markersize": 5}
        ax.loglog(x, errors, linewidth=1.4, label=f"{curve.label}: slope {curve.slope:.2f}", **style)
        finest = int(np.argmin(x))  # where the order shows best
        guide = errors[finest] * (x / x[finest]) ** curve.order
        ax.loglog(x, guide, color=style["color"], linestyle="--", linewidth=0.8, alpha=0.6)
    ax.plot([], [], color="0.4", linestyle="--", linewidth=0.8, label="expected order")
    ax.set_xlabel(figure.axes[0])
    ax.set_ylabel(figure.axes[1])
    ax.grid(visible=True, which="major", color="0.9", linewidth=0.6)
    ax.legend(fontsize=9)
    save(target, path)


def save(target: Canvas, path: Path) -> None:
    """A PNG file that says nothing of when and by what it was made, so that equal figures are equal files."""
    target.savefig(path, metadata={"Software": None})
