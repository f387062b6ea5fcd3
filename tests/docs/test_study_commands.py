"""The command that computes all numbers of the study anew: its steps are there, it goes on, the film is the page's."""

import json
import runpy
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SCRIPT = runpy.run_path(str(ROOT / "docs" / "study_pages.py"))


def test_scripts_of_all_steps_are_there():
    for step, command in SCRIPT["STEPS"].items():
        assert command[0] == "-m" or (ROOT / command[0]).is_file(), step


def test_the_film_is_that_of_the_page():
    page = (ROOT / "docs" / "howto" / "files.md").read_text(encoding="utf-8")
    shown = " ".join(page.replace("\\\n", " ").split())
    assert all(f"flexmb {command}" in shown for command in SCRIPT["FILM"])


def test_a_stopped_call_goes_on_and_changed_code_begins_anew(tmp_path, monkeypatch):
    main = SCRIPT["main"]
    made, codes = tmp_path / "made", iter(["a", "a", "b"])
    steps = {"one": ("-c", f"open({str(made)!r}, 'a').write('1')"), "two": ("-c", "raise SystemExit(3)")}
    changed = {"STEPS": steps, "DONE": tmp_path / "done.json", "code_of": lambda: next(codes)}
    for name, value in changed.items():
        monkeypatch.setitem(main.__globals__, name, value)
    monkeypatch.setattr(sys, "argv", ["study_pages.py"])
    assert main() == 1
    assert json.loads((tmp_path / "done.json").read_text()) == {"one": "a"}
    assert main() == 1
    assert made.read_text() == "1"
    assert main() == 1
    assert made.read_text() == "11"


@pytest.mark.parametrize("option", ["--list"])
def test_the_list_computes_nothing(option, monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["study_pages.py", option])
    assert SCRIPT["main"]() == 0
    assert capsys.readouterr().out.count(" min") >= len(SCRIPT["STEPS"])
