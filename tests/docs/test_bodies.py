"""The tables of docs/bodies.md are those of its numbers."""

import json
import runpy
import sys
from pathlib import Path

DOCS = Path(__file__).resolve().parents[2] / "docs"


def test_page_shows_the_kept_numbers(monkeypatch):
    monkeypatch.setattr(sys, "path", [*sys.path])
    table = runpy.run_path(str(DOCS / "bodies_table.py"))
    page = (DOCS / "bodies.md").read_text(encoding="utf-8")
    data = json.loads((DOCS / "bodies.json").read_text(encoding="utf-8"))
    assert table["page_text"](page, data) == page
    assert all(len(model["turns"]) == 20 for model in data["nine_bar"]["rows"])
