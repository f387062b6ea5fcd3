"""The list of docs/numbers.md is complete and true; the build that reads numbers at run time; the page."""

import ast
import subprocess
import sys
from numbers import Real
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
ROOMS = (
    *("dynamics/*.py", *(f"dynamics/{room}/*.py" for room in ("orbits", "series", "systems"))),
    *(
        "elastic/beams/*.py",
        "engine/*.py",
        "parts/bearings/*.py",
        "parts/contact/*.py",
        "parts/controllers/*.py",
        "parts/joints/*.py",
    ),
    *("program/*.py", "results/*.py", "run/*.py", "statics/*.py", "statics/start/*.py"),
    *(f"engine/{room}/*.py" for room in ("linalg", "newmark", "radau", "sensitivity", "state", "step", "system")),
)
"""Files of physics and analysis under flexmb/."""


@pytest.fixture(scope="module")
def modules():
    before = list(sys.path)
    sys.path.insert(0, str(ROOT / "docs"))
    try:
        import numbers_list
        import numbers_live
        import numbers_page
        import numbers_table
    finally:
        sys.path[:] = before
    return numbers_list, numbers_live, numbers_page, numbers_table


def is_number(value):
    """Whether a value is a number, or numbers alone."""
    if isinstance(value, tuple):
        return bool(value) and all(map(is_number, value))
    return isinstance(value, Real) and not isinstance(value, bool)


def constants_of(live, table, file):
    """Places of the numbers that a module holds, without those that a range enumerates."""
    path = ".".join(file.relative_to(ROOT / "flexmb").with_suffix("").parts)
    for name, value in live.constants(ast.parse(file.read_text(encoding="utf-8"))):
        counted = isinstance(value, ast.Call) and getattr(value.func, "id", "") == "range"
        if not counted and is_number(table.value_of(f"{path}.{name}")):
            yield f"{path}.{name}"


def test_every_constant_is_listed_or_left_out_with_a_reason(modules):
    listed, live, _, table = modules
    known = {n.place for n in (*listed.READ, *listed.ELSEWHERE)} | set(listed.LEFT_OUT)
    rooms = [sorted((ROOT / "flexmb").glob(room)) for room in ROOMS]
    assert all(rooms)
    files = [file for room in rooms for file in room]
    found = {place for file in files if file.stem != "__init__" for place in constants_of(live, table, file)}
    missing = sorted(found - known)
    assert not missing, f"neither in docs/numbers_list.py nor left out there with a reason: {missing}"
    assert all(listed.LEFT_OUT.values())


def test_every_listed_number_is_in_the_sources(modules):
    listed, live, _, table = modules
    for number in (*listed.READ, *listed.ELSEWHERE):
        assert is_number(table.value_of(number.place)), number.place
    for place in listed.LEFT_OUT:
        assert is_number(table.value_of(place)), place


def test_functions_use_every_number_that_is_read(modules):
    listed, live, _, _ = modules
    places, met = [live.Place(n.place, k) for k, n in enumerate(listed.READ)], set()
    for file in sorted((ROOT / "flexmb").rglob("*.py")):
        name = ".".join(file.relative_to(ROOT).with_suffix("").parts)
        met |= live.rewritten(name, file.read_text(encoding="utf-8"), places)[1]
    assert {n.place for n in listed.READ} == met


def test_no_number_is_listed_twice(modules):
    listed = modules[0]
    places = [n.place for n in (*listed.READ, *listed.ASKED, *listed.ELSEWHERE)] + list(listed.LEFT_OUT)
    assert len(places) == len(set(places))
    assert {n.place for n in (*listed.READ, *listed.ASKED)} >= listed.FLEXIBLE_TOO


def test_names_and_literals_in_functions_become_calls(modules):
    live = modules[1]
    places = [live.Place("engine.linalg.lu.HELD_PIVOT", 3), live.Place("engine.linalg.lu.weigh#0.5", 4)]
    source = (
        "HELD_PIVOT = 1e-8\nTWICE = 2.0 * HELD_PIVOT\ndef weigh(x, y=HELD_PIVOT):\n    return x * HELD_PIVOT + 0.5\n"
    )
    tree, met = live.rewritten("flexmb.engine.linalg.lu", source, places)
    assert met == {"engine.linalg.lu.HELD_PIVOT", "engine.linalg.lu.weigh#0.5"}
    text = ast.unparse(tree)
    assert "TWICE = 2.0 * HELD_PIVOT" in text
    assert "y=HELD_PIVOT" in text
    assert "return x * _live_read(3) + _live_read(4)" in text


def test_other_modules_read_the_same_number(modules):
    live = modules[1]
    source = "from flexmb.engine.linalg.lu import HELD_PIVOT as LEAST\ndef f(x):\n    return x > LEAST\n"
    tree, _ = live.rewritten("flexmb.engine.step.some", source, [live.Place("engine.linalg.lu.HELD_PIVOT", 7)])
    assert "x > _live_read(7)" in ast.unparse(tree)


def test_numbers_that_are_read_as_names_of_a_module(modules):
    live = modules[1]
    places = [live.Place("engine.linalg.lu.HELD_PIVOT", 7), live.Place("engine.linalg.lu.LOST_PIVOT", 8)]
    for imported in ("from flexmb.engine.linalg import lu as own", "import flexmb.engine.linalg.lu as own"):
        source = f"{imported}\ndef f(x):\n    return own.factor(x) > own.HELD_PIVOT\n"
        tree, met = live.rewritten("flexmb.engine.step.some", source, places)
        assert "own.factor(x) > _live_read(7)" in ast.unparse(tree)
        assert met == {"engine.linalg.lu.HELD_PIVOT"}


CHANGED = """
import sys
from pathlib import Path
sys.path.insert(0, sys.argv[1])
import numbers_live
from numbers_list import READ
build = numbers_live.Build([number.place for number in READ], Path(sys.argv[2]))
import flexmb as fm
from flexmb.mechanisms import slider_crank
steps = lambda: fm.simulate(slider_crank(clearance=5e-4), periods=0.5).stats.steps
first = steps()
build.set("engine.step.contact_events.ONSET_TOLERANCE", 0.1)
second = steps()
build.reset()
print(first, second, steps())
"""


@pytest.mark.slow  # the special build is compiled: a minute
def test_a_number_that_is_changed_changes_a_run(tmp_path):
    """A second process had compiled the sources as they stand: all numbers changed nothing, to the last bit."""
    words = [sys.executable, "-c", CHANGED, str(ROOT / "docs"), str(tmp_path)]
    done = subprocess.run(words, capture_output=True, text=True, timeout=600, check=True)
    first, second, third = map(int, done.stdout.split())
    assert first == third != second


def test_a_count_stays_a_count(modules):
    live = modules[1]
    source = "CONTACT_TRIALS = 8\ndef f():\n    return CONTACT_TRIALS\n"
    places = [live.Place("engine.newmark.error_control.CONTACT_TRIALS", 0)]
    tree, _ = live.rewritten("flexmb.engine.newmark.error_control", source, places)
    assert "_live_read_whole(0)" in ast.unparse(tree)


def test_sigmas_of_means(modules):
    page = modules[2]
    assert page.sigmas((1.0, 0.1, 1e9), (1.0, 0.1, 1e9)) == 0.0
    assert page.sigmas((1.3, 0.1, 1e9), (1.0, 0.0, 1e9)) == pytest.approx(3.0, rel=1e-3)
    assert page.sigmas((1.3, 0.1, 4.0), (1.0, 0.0, 1e9)) < 2.0  # few turns say less


def run(value, ok=True, steps=100.0):
    status = "Finished." if ok else "Stopped: x"
    return {"ok": ok, "status": status, "steps": steps, "values": {"peak": [value, 0.1, 30]}}


def test_the_page_ranks_what_moves(modules):
    listed, _, page, _ = modules
    first, second, third = listed.READ[0], listed.READ[1], listed.READ[2]
    rows = {"base 0": run(10.0), "base 1": run(10.1), f"{first.place} 10": run(10.05), f"{second.place} 10": run(20.0)}
    stopped = {**run(0.0, ok=False), "values": {}}
    rows |= {f"{third.place} 10": run(10.0), f"{third.place} 0.1": stopped}
    assert page.cell("a", rows, first) == "within the scatter"
    assert "peak +99" in page.cell("a", rows, second)
    assert page.cell("a", rows, third).startswith("×0.1 fails: Stopped")
    lines = list(page.ranking({"a": rows}))
    assert [line.split("`")[1] for line in lines] == [second.place, third.place]
    text = page.page({"a": rows}, {"a": "a run"}, {}, "2026-11-22")
    assert "began on 2026-11-22" in text
    assert text.count("\n| `") == len(lines) + len(listed.READ) + len(listed.ASKED) + len(listed.ELSEWHERE)


def test_the_page_holds_the_kept_runs_whatever_code_they_are_of(modules, monkeypatch):
    """A page written after a change of the code had lost all its runs."""
    table = modules[3]
    monkeypatch.setattr(table, "code_of_flexmb", lambda: "a later code")
    store = table.kept(of_any_code=True)
    written = table.PAGE.read_text(encoding="utf-8")
    assert f"began on {store['day']}" in " ".join(written.split())
    known = {n.place for n in (*modules[0].READ, *modules[0].ASKED)}
    for case, rows in store["runs"].items():
        assert f"\n| {case} | peak force [N] | " in written
        varied = {key.rpartition(" ")[0] for key in rows} - {"base"}
        assert len(varied - known) < 0.1 * len(varied)  # a number that moves takes its runs along
    assert table.kept()["runs"] == {}
