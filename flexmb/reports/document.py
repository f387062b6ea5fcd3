"""The page: styles, scripts and data in one file that forbids every access to a network."""

from __future__ import annotations

import base64
import json
from collections.abc import Mapping
from functools import cache
from hashlib import sha256
from importlib.resources import files
from pathlib import Path
from typing import Any

from flexmb.jobs.files import write_text
from flexmb.reports.head import plain_head
from flexmb.reports.markup import Markup, joined, tag

STYLES = ("uPlot.min.css", "page.css", "player.css")
LIBRARY = "uPlot.iife.min.js"
COMMON = ("decode.js", "theme.js")
"""Scripts of all pages, in their order."""


@cache
def asset(name: str) -> str:
    """Text of a file beside this module."""
    return files("flexmb.reports").joinpath("assets", name).read_text(encoding="utf-8")


def document(title: str, body: Markup, scripts: tuple[str, ...], data: dict[str, Any]) -> str:
    """Text of a page, with scripts after the common ones, and plain values for them."""
    style = "\n".join(asset(name) for name in STYLES)
    program = "\n".join(['"use strict";(function () {', *(asset(name) for name in (*COMMON, *scripts)), "})();"])
    codes = [asset(LIBRARY), program] if "plots.js" in scripts else [program]
    content = tag(
        "html",
        tag(
            "head",
            tag("meta", charset="utf-8"),
            tag("meta", http_equiv="Content-Security-Policy", content=policy(style, codes)),
            tag("meta", name_="viewport", content="width=device-width, initial-scale=1"),
            tag("meta", name_="color-scheme", content="light dark"),
            tag("title", title),
            Markup(f"<style>{style}</style>"),
        ),
        tag(
            "body",
            body,
            Markup(f'<script type="application/json" id="data">{embedded(data)}</script>'),
            *(Markup(f"<script>{code}</script>") for code in codes),
        ),
        lang="en",
    )
    return f"<!DOCTYPE html>\n{content}\n"


def policy(style: str, codes: list[str]) -> str:
    """Content security policy: the styles and scripts of the page alone, no network, no forms."""
    scripts = " ".join(map(_hash, codes))
    rules = ("default-src 'none'", f"style-src {_hash(style)}", f"script-src {scripts}", "img-src data:")
    return "; ".join((*rules, "base-uri 'none'", "form-action 'none'"))


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
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    return value


def write_page(
    path: Path,
    heading: str,
    key_numbers: Markup,
    links: Mapping[str, str],
    main: Markup,
    scripts: tuple[str, ...],
    data: dict[str, Any],
) -> Path:
    """Write a page, whole or not at all; its parts as of `plain_head` and `document`."""
    body = joined([plain_head(heading, key_numbers, links), main])
    return write_text(path, document(f"{heading} - flexmb", body, scripts, data), "report")
