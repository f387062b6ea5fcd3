"""Pieces that all pages share."""

from __future__ import annotations

from collections.abc import Mapping

from flexmb.reports.markup import Markup, tag


def plain_head(heading: str, key_numbers: Markup, links: Mapping[str, str]) -> Markup:
    """Head of a page: title, switch of the theme, first numbers, links to the sections by anchor."""
    switch = tag("button", "Theme: system", type="button", id="theme", class_="quiet")
    anchors = [tag("a", text, href=f"#{anchor}") for anchor, text in links.items()]
    return tag(
        "header",
        tag("a", "Skip to the sections", href=f"#{next(iter(links))}", class_="skip"),
        tag("div", tag("h1", heading), switch, class_="title"),
        key_numbers,
        tag("nav", *anchors, aria_label="Sections"),
    )
