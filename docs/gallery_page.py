"""Run every example and write docs/gallery.md: its question, its picture, and the lines that it prints.

`make gallery`, or `python docs/gallery_page.py [NAME ...]` for some of them. Pictures go to docs/pictures/gallery.
"""

import ast
import contextlib
import html
import io
import os
import re
import runpy
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

os.environ.setdefault("MPLBACKEND", "Agg")
os.environ.setdefault("FLEXMB_MESSAGES", "0")

from matplotlib.figure import Figure
from PIL import Image

import flexmb as fm

ROOT = Path(__file__).resolve().parents[1]
EXAMPLES, PICTURES, PAGE = ROOT / "examples", ROOT / "docs" / "pictures" / "gallery", ROOT / "docs" / "gallery.md"

WIDTH, LARGEST = 720, 60_000
"""Width of a picture [pixels], and its largest size [bytes]."""

THUMBNAIL, COLUMNS = 150, 4
"""Width of a picture in the index at the top [pixels], and number of pictures in a row."""

GROUPS = {
    "Linkages": (
        *("chebyshev", "watt", "peaucellier", "stephenson", "pantograph", "quick_return", "scotch_yoke"),
        *("toggle_press", "scissor_lift", "path_synthesis", "counterweight"),
    ),
    "Machines": ("planetary_gear", "cam_lift_off", "cam_law", "geneva", "ratchet", "pick_and_place", "andrews"),
    "Beams": ("cantilever", "flexible_four_bar", "gripper", "spin_up", "frame_from_mesh", "rod_of_plates"),
    "Clearance, impacts, chaos": (
        *("nine_bar", "nine_bar_plates", "worn_slider_crank", "worn_from_noise", "own_law", "restart", "chaos"),
    ),
    "Chains and pendulums": ("pendulum", "whip"),
}
"""Examples by their groups, in the order of the page."""


def bent(names: dict[str, Any]) -> Figure:
    """The cantilever under its load, from the equilibrium with most elements."""
    pose = names["equilibrium"]
    nodes = range(names["elements"] + 1)
    figure = Figure(figsize=(6.0, 3.0), layout="constrained")
    axes = figure.subplots()
    axes.plot([0.0, names["L"]], [0.0, 0.0], color="0.8", lw=3)
    axes.plot([pose[f"beam.node{k}.x"] for k in nodes], [pose[f"beam.node{k}.y"] for k in nodes], lw=3)
    axes.set(xlabel="x [m]", ylabel="y [m]", aspect="equal")
    return figure


DRAWN: dict[str, Callable[[dict[str, Any]], Figure]] = {
    "pendulum": lambda names: fm.plot(names["sol"], [name for name in names["sol"].names if name.endswith(".theta")]),
    "cantilever": bent,
    "cam_lift_off": lambda names: fm.render(names["slow"]),
    "geneva": lambda names: fm.render(names["contact"]),
    "ratchet": lambda names: fm.render(names["sol"], times=(0.0, 0.05, 0.1, 0.6)),
    "flexible_four_bar": lambda names: fm.render(names["sol"]),
    "frame_from_mesh": lambda names: fm.render(names["sol"], times=(0.0, 1.5)),
    "own_law": lambda names: fm.plot(names["sol"], ["play.ex", "play.normal_force"]),
    "restart": lambda names: fm.plot(names["whole"], ["B.normal_force", "motor.torque"]),
    "pick_and_place": lambda names: fm.render(names["sol"]),
}
"""Pictures of the examples that write none, from the names that they define."""


def shrunk(source: Path, target: Path) -> None:
    """Picture of `WIDTH` pixels with a palette, of fewer colours until it is small enough."""
    image = Image.open(source).convert("RGB")
    margin = image.point(lambda value: 255 - value).getbbox() or (0, 0, *image.size)
    left, top, right, bottom = margin
    image = image.crop((max(left - 8, 0), max(top - 8, 0), min(right + 8, image.width), min(bottom + 8, image.height)))
    width = min(WIDTH, image.width)
    image = image.resize((width, round(image.height * width / image.width)), Image.Resampling.LANCZOS)
    for colours in (256, 128, 64, 32, 16):
        image.quantize(colours, kmeans=2).save(target, optimize=True)
        if target.stat().st_size <= LARGEST:
            return
    raise SystemExit(f"{target.name} has {target.stat().st_size} bytes with {colours} colours; draw less.")


def ran(name: str) -> str:
    """Output of an example that is run in an empty folder; its picture is written."""
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        output = io.StringIO()
        with contextlib.redirect_stdout(output):
            names = runpy.run_path(str(EXAMPLES / f"{name}.py"), run_name="__main__")
        pictures = sorted(Path("out").glob("*.png"))
        if name in DRAWN:
            pictures = [Path("drawn.png")]
            DRAWN[name](names).savefig(pictures[0], dpi=150)
        shrunk(pictures[0], PICTURES / f"{name}.png")
    return re.sub(r"^written: .*\n|^frames: .*\n", "", output.getvalue(), flags=re.MULTILINE)


def first_picture() -> None:
    """Picture of docs/first_steps.md, from the first block of its code."""
    text = (ROOT / "docs" / "first_steps.md").read_text(encoding="utf-8")
    names: dict[str, Any] = {}
    exec(text.partition("```python\n")[2].partition("```")[0], names)
    figure = fm.plot(names["sol"], ["piston.ax", "motor.torque"])
    figure.set_size_inches(6.4, 4.2)
    figure.savefig(ROOT / "docs" / "pictures" / "first_steps.png", dpi=80)


def described(name: str) -> tuple[str, str, str, str]:
    """Heading, colon, question and further text of the docstring of an example."""
    doc = ast.get_docstring(ast.parse((EXAMPLES / f"{name}.py").read_text(encoding="utf-8"))) or ""
    title, _, rest = doc.partition("\n\n")
    return (*title.replace("\n", " ").rstrip(".").partition(": "), rest)


def thumbnail(name: str) -> str:
    """Small picture of an example, with a link to its section."""
    heading = described(name)[0]
    anchor = re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")
    image = f'<img src="pictures/gallery/{name}.png" alt="{html.escape(heading)}" width="{THUMBNAIL}">'
    return f"[{image}](#{anchor})<br>[{heading}](#{anchor})"


def index(names: list[str]) -> str:
    """Table of small pictures, `COLUMNS` in a row."""
    cells = [thumbnail(name) for name in names] + [""] * (-len(names) % COLUMNS)
    rows = [cells[k : k + COLUMNS] for k in range(0, len(cells), COLUMNS)]
    return "\n".join(f"| {' | '.join(row)} |" for row in [[""] * COLUMNS, ["---"] * COLUMNS, *rows])


def sections(name: str, printed: str) -> list[str]:
    """Title, question, picture and output of an example."""
    heading, colon, question, rest = described(name)
    text = f"{question[:1].upper()}{question[1:]}." if colon else ""
    picture = f"![{heading}](pictures/gallery/{name}.png)"
    body = [part for part in (text, rest) if part]
    return [
        f"### {heading}",
        *body,
        picture,
        f"```text\n{printed.rstrip()}\n```",
        f"[examples/{name}.py](../examples/{name}.py)",
    ]


def page(outputs: dict[str, str]) -> str:
    """Text of the page."""
    lines = [
        "# Gallery",
        "Each example prints its results beside exact or published values. Written by `make gallery` (`python "
        "docs/gallery_page.py`); an example is run by `python examples/NAME.py`, and all of them are tests "
        "(`pytest tests/cli/test_examples.py`).",
    ]
    lines += [index([name for names in GROUPS.values() for name in names])]
    for group, names in GROUPS.items():
        lines.append(f"## {group}")
        for name in names:
            lines += sections(name, outputs[name])
    return "\n\n".join(lines) + "\n"


def kept() -> dict[str, str]:
    """Outputs in the present page, by the names of the examples."""
    if not PAGE.exists():
        return {}
    pattern = r"```text\n(.*?)\n```\n\n\[examples/(\w+)\.py\]"
    return {name: text for text, name in re.findall(pattern, PAGE.read_text(encoding="utf-8"), re.DOTALL)}


def main(chosen: list[str]) -> None:
    """Run examples (all, or those named) and write the page."""
    PICTURES.mkdir(parents=True, exist_ok=True)
    outputs = kept()
    for name in chosen or [name for names in GROUPS.values() for name in names]:
        print(name, flush=True)
        outputs[name] = ran(name)
    PAGE.write_text(page(outputs), encoding="utf-8")
    first_picture()


if __name__ == "__main__":
    main(sys.argv[1:])
