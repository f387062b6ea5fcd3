"""The page: styles, scripts and data in one file that forbids every access to a network.

A column becomes whole numbers between 0, its smallest value, and some thousands or millions, its largest value; or the
bits of its floats.
The differences from row to row, byte by byte, are compressed (zlib) and written as base64.  `decode.js` reads them.
"""

import base64
import html
import json
import zlib
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from hashlib import sha256
from importlib.resources import files
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np

from flexmb import checks
from flexmb.display import pretty
from flexmb.dynamics.jobs.files import write_text
from flexmb.show.pictures.style import COLOURS


class Markup(str):
    """Text that is HTML already; any other text is escaped where it enters."""

    __slots__ = ()


Content = str | None  # piece of a page: markup, plain text, or None for nothing
VOID = frozenset({"input", "meta", "br"})  # elements without content


def tag(name: str, *content: Content, **attributes: str | bool | None) -> Markup:
    """An element with pieces inside it, of which plain text is escaped, and attributes by name."""
    # "_" stands for "-", and a "_" at the end is left out. None and False: no such attribute, True: an attribute
    # without a value.
    written = ""
    for key, value in attributes.items():
        if value is None or value is False:
            continue
        word = key.rstrip("_").replace("_", "-")
        written += f" {word}" if value is True else f' {word}="{html.escape(value)}"'
    return Markup(f"<{name}{written}>" if name in VOID else f"<{name}{written}>{joined(content)}</{name}>")


def joined(content: Iterable[Content]) -> Markup:
    """Pieces one after the other; plain text is escaped."""
    return Markup("".join(x if isinstance(x, Markup) else html.escape(x) for x in content if x is not None))


def section(title: str, *content: Content, anchor: str) -> Markup:
    """A section with a heading and an anchor for links."""
    heading = tag("h2", title, id=f"{anchor}-title")
    return tag("section", heading, *content, id=anchor, aria_labelledby=f"{anchor}-title")


def table(
    caption: str, heads: Sequence[str], rows: Iterable[Sequence[Content]], *, numbers: Sequence[int] = ()
) -> Markup:
    """A table with a caption that scrolls sideways; first cells are heads, `numbers` the columns of numbers."""
    classes = ["number" if k in numbers else None for k in range(len(heads))]
    head = tag("tr", *(tag("th", text, scope="col", class_=c) for text, c in zip(heads, classes, strict=True)))
    body = []
    for row in rows:
        first, *rest = row
        cells = [tag("td", cell, class_=c) for cell, c in zip(rest, classes[1:], strict=True)]
        body.append(tag("tr", tag("th", first, scope="row"), *cells))
    made = tag("table", tag("caption", caption), tag("thead", head), tag("tbody", *body))
    return tag("div", made, class_="scroll", role="region", tabindex="0", aria_label=caption)


def facts(rows: Iterable[tuple[str, Content]]) -> Markup:
    """Names with their values."""
    return tag("dl", *(tag("div", tag("dt", name), tag("dd", value)) for name, value in rows), class_="facts")


def number(value: float, digits: int = 6) -> str:
    """A number with so many significant digits; "-" for one that is not finite."""
    return f"{value:.{digits}g}" if isfinite(value) else "-"


def quantity(value: float, unit: str = "", digits: int = 6) -> str:
    """A number with its unit."""
    return f"{number(value, digits)} {pretty(unit)}".rstrip()


# Arrays as compressed texts inside a page

# Steps between the smallest and the largest value: of colours, of lengths on a screen, of coordinates.
COARSE, MIDDLE, FINE = 2**10 - 1, 2**12 - 1, 2**24 - 1
FLOAT = 4  # bytes of a float of single precision, which keeps seven digits


def quantised(values: np.ndarray, steps: int, *, common: bool = False) -> dict[str, Any]:
    """Columns (n, m) of finite numbers as whole ones within half of `steps` of a range, `common` to all or not."""
    n, m = values.shape
    low, high = (values.min(axis=0), values.max(axis=0)) if n else (np.zeros(m), np.zeros(m))
    if common and m:
        low, high = np.full(m, low.min()), np.full(m, high.max())
    step = (high - low) / steps
    whole = np.rint((values - low) / np.where(step > 0.0, step, 1.0)).astype(np.uint32)
    kept = 1 if common and m else m
    size = 2 if steps < 2**16 else 3
    scale = {"low": _short(low[:kept]), "step": _short(step[:kept])}
    return {"n": n, "m": m, "size": size, **scale, "data": _compressed(whole, size)}


def floats(values: np.ndarray) -> dict[str, Any]:
    """Columns (n, m) as floats of single precision; numbers that are not finite remain so."""
    n, m = values.shape
    with np.errstate(over="ignore"):
        bits = np.ascontiguousarray(values, dtype=np.float32).view(np.uint32)
    return {"n": n, "m": m, "size": FLOAT, "data": _compressed(bits.reshape(n, m), FLOAT)}


def instants(times: np.ndarray) -> dict[str, Any]:
    """Times (n,) as floats of double precision."""
    raw = np.ascontiguousarray(times, dtype="<f8").view(np.uint8).reshape(-1, 8)
    return {"n": len(times), "size": 8, "data": _text(raw.T.tobytes())}


def _compressed(whole: np.ndarray, size: int) -> str:
    """Differences of whole numbers (n, m) along the rows, column by column, lowest bytes first."""
    first = np.zeros((1, whole.shape[1]), dtype=np.uint32)
    steps = np.diff(whole, axis=0, prepend=first)  # modulo 2^32
    columns = np.ascontiguousarray(steps.T.astype("<u4")).view(np.uint8).reshape(-1, 4)
    return _text(columns[:, :size].T.tobytes())


LEVEL = 6  # of zlib's compression: 9 takes four times as long for 1 % less


def _text(content: bytes) -> str:
    return base64.b64encode(zlib.compress(content, LEVEL)).decode("ascii")


def _short(numbers: np.ndarray) -> list[float]:
    """Numbers with nine digits, which is finer than a step."""
    return [float(f"{x:.9g}") for x in numbers]


# Pieces that all pages share
def state_of(fault: str, *content: Content, also: str = "") -> Markup:
    """State of a result, finished or a fault, and its first numbers, for the head of a page; `also`: another class."""
    badge = tag("span", fault or "finished", class_=f"badge {'error' if fault else 'good'}")
    return tag("p", badge, Markup(" "), *content, class_=f"key-numbers {also}".rstrip())


def chosen_signals(signals: Sequence[str], known: Sequence[str]) -> list[str]:
    """Names of the chosen signals of a diagram, checked."""
    given = checks.sequence("report", "signals", signals, "names")
    return [checks.one_of("report", "signal", name, known) for name in given]


STYLES = ("uPlot.min.css", "page.css", "player.css")
LIBRARY = "uPlot.iife.min.js"
COMMON = ("decode.js", "theme.js")  # scripts of all pages, in their order


@cache
def asset(name: str, room: str = "reports") -> str:
    """Text of a file of a room of `show/`."""
    return files(f"flexmb.show.{room}").joinpath("assets", name).read_text(encoding="utf-8")


PALE = 0.4  # share of white in the colours of curves and bodies on a dark page


def palette() -> str:
    """Style of curves and bodies in the colours of pictures, paler on a dark page."""
    pale = [[round((1.0 - PALE) * x + 255 * PALE) for x in bytes.fromhex(one[1:])] for one in COLOURS]
    dark = "".join(f"--series-{k}: #{bytes(one).hex()}; " for k, one in enumerate(pale))
    light = "".join(f"--series-{k}: {one}; " for k, one in enumerate(COLOURS))
    keys = "".join(f".key-{k} {{ background: var(--series-{k}); }}\n" for k in range(len(COLOURS)))
    on_dark = f':root:not([data-theme="light"]) {{ {dark}}}'
    return f""":root {{ --series-count: {len(COLOURS)}; {light}}}
@media (prefers-color-scheme: dark) {{ {on_dark} }}
:root[data-theme="dark"] {{ {dark}}}
{keys}"""


def document(
    title: str, body: Markup, scripts: tuple[str, ...], data: dict[str, Any], *, own: tuple[str, str] = ("", ""),
    network: str = "",
) -> str:  # fmt: skip
    """Text of a page, with scripts after the common ones, and plain values for them."""
    # `own` are the texts of a style and of a script of this page alone; `network` is the one address that scripts may
    # reach.
    style = "\n".join([*(asset(name) for name in STYLES), own[0], palette()])
    texts = [*(asset(name) for name in (*COMMON, *scripts)), own[1]]
    program = "\n".join(['"use strict";(function () {', *texts, "})();"])
    codes = [asset(LIBRARY), program] if "plots.js" in scripts else [program]
    told = {"viewport": "width=device-width, initial-scale=1", "color-scheme": "light dark"}
    metas = [tag("meta", charset="utf-8")]
    metas += [tag("meta", http_equiv="Content-Security-Policy", content=policy(style, codes, network))]
    metas += [tag("meta", name_=name, content=text) for name, text in told.items()]
    head = tag("head", *metas, tag("title", title), Markup(f"<style>{style}</style>"))
    values = Markup(f'<script type="application/json" id="data">{embedded(data)}</script>')
    whole = tag("body", body, values, *(Markup(f"<script>{code}</script>") for code in codes))
    return f"<!DOCTYPE html>\n{tag('html', head, whole, lang='en')}\n"


def policy(style: str, codes: list[str], network: str = "") -> str:
    """Content security policy: the styles and scripts of the page alone, one address or no network, no forms."""
    scripts = " ".join(map(_hash, codes))
    rules = ("default-src 'none'", f"style-src {_hash(style)}", f"script-src {scripts}", "img-src data:")
    reached = (f"connect-src {network}",) if network else ()
    return "; ".join((*rules, *reached, "base-uri 'none'", "form-action 'none'"))


def _hash(text: str) -> str:
    return f"'sha256-{base64.b64encode(sha256(text.encode()).digest()).decode('ascii')}'"


def embedded(data: dict[str, Any]) -> str:
    """Values as JSON that cannot end its element; numbers that are not finite are null."""
    text = json.dumps(_finite(data), allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _finite(value: Any) -> Any:
    if isinstance(value, float):
        return value if abs(value) < float("inf") else None
    if isinstance(value, dict):
        return {str(key): _finite(item) for key, item in value.items()}
    return [_finite(item) for item in value] if isinstance(value, list | tuple) else value


def write_page(
    path: Path, heading: str, key_numbers: Markup, links: Mapping[str, str], main: Markup, scripts: tuple[str, ...],
    data: dict[str, Any],
) -> Path:  # fmt: skip
    """Write a whole page or none: title, theme, numbers, links by anchor, main part; scripts as of `document`."""
    switch = tag("button", "Theme: system", type="button", id="theme", class_="quiet")
    anchors = [tag("a", text, href=f"#{anchor}") for anchor, text in links.items()]
    skip = tag("a", "Skip to the sections", href=f"#{next(iter(links))}", class_="skip")
    title = tag("div", tag("h1", heading), switch, class_="title")
    head = tag("header", skip, title, key_numbers, tag("nav", *anchors, aria_label="Sections"))
    return write_text(path, document(f"{heading} - flexmb", joined([head, main]), scripts, data), "report")
