"""The verdicts of tests/speed/duel.py and the page that docs/performance.py writes, on times that are made up."""

import json
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

ROOT = Path(__file__).resolve().parents[2]

NO_COLLECTION = SimpleNamespace(collect=lambda: 0)  # it takes long where a process has run many tests


@pytest.fixture(scope="module")
def modules():
    before = list(sys.path)
    sys.path[:0] = [str(ROOT / "docs"), str(ROOT / "tests" / "speed")]
    try:
        import duel
        import performance_page
    finally:
        sys.path[:] = before
    return duel, performance_page


def runners(duel):
    """Ours take 1 and 2 s with errors 4 and 1, the peer's 8 and 6 s with errors 2 and 0.5; one gives up."""

    def runner(code, label, seconds, error, torque=1.0):
        return duel.Runner(code, label, lambda: seconds, lambda: {"error": error, duel.TORQUE: torque})

    def gave_up():
        raise duel.GaveUp("stopped at t = 0.1 s")

    return [
        runner("flexmb", "coarse", 1.0, 4.0),
        runner("flexmb", "fine", 2.0, 1.0),
        runner("flexmb", "spiky", 1.0, 1.0, torque=9.0),
        runner("Exudyn", "rough", 8.0, 2.0),
        runner("Exudyn", "exact", 6.0, 0.5),
        duel.Runner("Exudyn", "broken", gave_up, gave_up),
    ]


def verdicts(duel, tmp_path, monkeypatch, *wishes, **options):
    monkeypatch.setattr(duel, "RECORDS", tmp_path)
    monkeypatch.setattr(duel, "SPENT", 0.0)
    monkeypatch.setattr(duel, "gc", NO_COLLECTION)
    row = duel.Row(
        "made-up", "a made-up row", "made up", lambda: runners(duel)[:2] + runners(duel)[3:], wishes, **options
    )
    record = duel.measured(row, pairs=3)
    assert json.loads((tmp_path / "made-up.json").read_text(encoding="utf-8"))["title"] == "a made-up row"
    return record, [duel.Verdict(**v) for v in record["verdicts"]]


def test_the_same_setting_is_compared_whatever_its_error(modules, tmp_path, monkeypatch):
    duel, _ = modules
    _, (good, bad) = verdicts(
        duel, tmp_path, monkeypatch, duel.Wish("rough", 8.0, "coarse"), duel.Wish("rough", 8.1, "coarse")
    )
    assert (good.ratio, good.low, good.high) == (8.0, 8.0, 8.0)
    assert good.holds
    assert not bad.holds
    assert "8.00 x is less than 8.1 x" in str(bad)


def test_at_equal_accuracy_the_fastest_that_is_as_accurate_counts(modules, tmp_path, monkeypatch):
    duel, _ = modules
    _, (found, none) = verdicts(duel, tmp_path, monkeypatch, duel.Wish("rough", 4.0), duel.Wish("exact", 1.0))
    assert (found.ours, found.ratio) == ("fine", 4.0)
    assert found.holds
    assert "none of our settings is as accurate" in none.complaint


def test_a_fast_run_with_a_large_error_fails(modules, tmp_path, monkeypatch):
    duel, _ = modules
    _, (found,) = verdicts(duel, tmp_path, monkeypatch, duel.Wish("rough", 4.0, "coarse"), ceiling=3.0)
    assert "our error of 4 is above 3" in found.complaint


def test_false_peaks_fail(modules, monkeypatch):
    duel, _ = modules
    monkeypatch.setattr(duel, "gc", NO_COLLECTION)
    timings, _ = duel.timed(runners(duel), 1)
    row = duel.Row("made-up", "a made-up row", "made up", list, (), spikes=8.0)
    assert "is a false peak" in duel.verdict(row, duel.Wish("rough", 4.0, "spiky"), timings).complaint
    assert duel.verdict(row, duel.Wish("rough", 4.0, "fine"), timings).holds


def test_a_peer_that_gives_up_is_no_victory(modules, tmp_path, monkeypatch):
    duel, _ = modules
    _, (found,) = verdicts(duel, tmp_path, monkeypatch, duel.Wish("broken", 4.0, "fine"))
    assert "the peer gave up: stopped at t = 0.1 s" in found.complaint


def test_the_page_shows_what_is_missed_and_what_was_before(modules, tmp_path, monkeypatch):
    duel, page = modules
    record, _ = verdicts(duel, tmp_path, monkeypatch, duel.Wish("rough", 4.0), duel.Wish("rough", 9.0, "coarse"))
    before = {"commit": "abc1234", "where": record["where"], "times": {"fine": 3.0}}
    data = {"rows": {"made-up": record}, "before": {"made-up": before}, "others": {}}
    page.write(tmp_path / "page.md", data, order=["made-up"])
    text = (tmp_path / "page.md").read_text(encoding="utf-8")
    assert "| [a made-up row](#made-up) | rough | fine | 2, 1 | 4 (4 to 4) | 4 |  |" in text
    assert "| rough | coarse | 2, 4 | 8 (8 to 8) | 9 | **missed**: 8.00 x is less than 9 x |" in text
    assert "| flexmb | fine | 2000 (3000) | 1 | 1 |" in text
    assert "| Exudyn | broken | gave up: stopped at t = 0.1 s |" in text
    assert "commit abc1234" in text
