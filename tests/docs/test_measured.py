"""The page of measured machines shows its numbers; sections without records are computed again."""

import json
import runpy
import sys
from pathlib import Path

import pytest

DOCS = Path(__file__).resolve().parents[2] / "docs"


@pytest.fixture(scope="module")
def made():
    before = [*sys.path]
    yield runpy.run_path(str(DOCS / "measured_table.py"))
    sys.path[:] = before


@pytest.fixture(scope="module")
def kept():
    return json.loads((DOCS / "measured.json").read_text(encoding="utf-8"))


def test_page_shows_the_kept_numbers(made, kept):
    page = (DOCS / "measured.md").read_text(encoding="utf-8")
    assert made["page_text"](page, kept) == page


def test_spheres(made):
    found = made["SECTIONS"]["spheres"].numbers(None)
    glass, limestone = (found["head on"][name]["ours"] for name in ("glass", "limestone"))
    assert glass == pytest.approx([2.741127e-4, 10696.9, 40.339e-6], rel=2e-5)
    assert limestone == pytest.approx([3.683040e-4, 7108.2, 54.201e-6], rel=2e-5)
    for one in found["head on"].values():
        assert one["ours"] == pytest.approx(one["known"], rel=1e-6)
    for angle, e_t, spin in (("45", 0.81784, 502.346), ("60", 0.8948299, 355.212)):
        one = found["oblique"][angle]
        ours = [one["ours"]["e_t"], one["ours"]["spin"]]
        assert ours == pytest.approx([e_t, spin], rel=2e-6)
        assert ours == pytest.approx(one["known"], rel=1e-6)
        assert one["ours"]["e_n"] == pytest.approx(0.98, rel=1e-6)


@pytest.mark.slow
def test_rub(made):
    published = [1.0270488394, 0.2704883940, 1.0851944080, 0.8519440801, 1.0027081911]
    rows = made["SECTIONS"]["rub"].numbers(None)["rows"]
    ours = [x for row in rows for x in row["ours"]]
    assert ours[:5] == pytest.approx(published, rel=1e-9)
    assert ours == pytest.approx([x for row in rows for x in row["known"]], rel=1e-9)


def test_kept_pendulums(kept):
    """Residuals of the kept fits are those that the page promises [rad]."""
    found = kept["pendulums"]
    assert found["double"]["published"]["recorded"] == pytest.approx(0.0112, abs=5e-5)
    assert max(found["double"]["ours"]["estimated"], found["double"]["ours"]["recorded"]) < 0.0112
    assert max(found["single"]["ours"]["estimated"], found["single"]["ours"]["recorded"]) < 0.0133
