"""The page of `make validation`, made from small problems: in band, out of band, known to miss, raising."""

import importlib
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def validation():
    """docs/validation.py and the folders that it puts on the path."""
    before = list(sys.path)
    sys.path.insert(0, str(ROOT / "docs"))
    yield importlib.import_module("validation")
    sys.path[:] = before


@pytest.fixture
def problem(validation):
    return validation.Problem(title="A pole | two", source="A book.", kind="exact", about="About it.")


def result_of(validation, problem, folder, fast=False):
    return validation.of_problem(validation.ProblemResult("pole"), problem, fast=fast, pictures=folder)


def page_of(validation, folder, results, keep_others=False):
    path = folder / "validation.md"
    validation.page.write(path, results, keep_others=keep_others)
    return path.read_text(encoding="utf-8")


def test_a_value_within_its_band(validation, problem, tmp_path):
    @problem.case("3 elements")
    def _():
        yield validation.Value("height [m]", 2.0, 2.001, band=1e-3)
        yield validation.Value("lean [m]", 0.0, 1e-5, band=1e-4, scale=1.0)

    result = result_of(validation, problem, tmp_path)
    assert validation.complaints(result) == []
    text = page_of(validation, tmp_path, [result])
    assert "| 3 elements | height [m] | 2 | 2.001 | 5.0e-04 | 0.001 |" in text
    assert "|  | lean [m] | 0 | 1e-05 | 1.0e-05 abs | 0.0001 |  |" in text
    assert "| [A pole \\| two](#pole) | A book. | 2 | 0.5 |" in text
    assert "numpy" in text
    assert "make validation" in text


def test_a_value_out_of_its_band(validation, problem, tmp_path):
    @problem.case("3 elements")
    def _():
        yield validation.Value("height [m]", 2.0, 2.5, band=0.1)
        yield validation.Value("width [m]", 2.0, float("nan"), band=0.1)

    result = result_of(validation, problem, tmp_path)
    first, second = validation.complaints(result)
    assert first == "pole, 3 elements: height [m]: 2.5 against 2.0, error 2.50e-01, band 1e-01"
    assert "nan" in second
    text = page_of(validation, tmp_path, [result])
    assert "**2.5e-01, out of band**" in text
    assert "**2 out of band**" in text
    assert "| inf, " in text


@pytest.mark.parametrize(("ours", "holds"), [(1.02, True), (1.06, False), (1.001, False)])
def test_a_value_known_to_miss(validation, problem, tmp_path, ours, holds):
    """Shown with its reason; wrong when it leaves the limit, too, and when it no longer misses."""

    @problem.case("3 elements")
    def _():
        yield validation.Value("height [m]", 1.0, ours, band=0.01, missed="The pole is soft.", limit=0.05)

    result = result_of(validation, problem, tmp_path)
    assert (validation.complaints(result) == []) is holds
    text = page_of(validation, tmp_path, [result])
    assert "Misses its band: height [m]. The pole is soft. Held to 0.05 instead." in text
    assert ("misses |" in text) is holds


def test_a_case_that_raises_leaves_the_others(validation, problem, tmp_path):
    @problem.case("breaks")
    def _():
        raise RuntimeError("no | root")

    @problem.case("works")
    def _():
        return [validation.Value("height [m]", 1.0, 1.0, band=0.1)]

    @problem.case("is empty")
    def _():
        return []

    result = result_of(validation, problem, tmp_path)
    raising, empty = validation.complaints(result)
    assert raising.startswith("pole, breaks: RuntimeError: no | root (test_validation.py:")
    assert empty == "pole, is empty: no values: the case checks nothing"
    text = page_of(validation, tmp_path, [result])
    assert "| breaks | **failed:** RuntimeError: no \\| root" in text
    assert "| works | height [m] | 1 | 1 | 0.0e+00 |" in text
    assert "**2 failed**" in text


def test_curves_and_pictures(validation, problem, tmp_path):
    x = (0.1, 0.2, 0.4)

    @problem.convergence("pole", "Errors fall.", "size", "error")
    def _():
        return [
            validation.Curve("good", x, [v**2 for v in x], order=2.0),
            validation.Curve("bad", x, x, order=2.0),
        ]

    @problem.picture("drawing", "A drawing.")
    def _(figure):
        figure.add_subplot().plot([0, 1])

    @problem.picture("broken", "No drawing.")
    def _(figure):
        raise ValueError("no ink")

    @problem.case("one")
    def _():
        return [validation.Value("height [m]", 1.0, 1.0, band=0.1)]

    result = result_of(validation, problem, tmp_path)
    flat, broken = validation.complaints(result)
    assert flat == "pole, figure pole: bad: slope 1.00, wanted 2 - 0.1"
    assert "ValueError: no ink" in broken
    text = page_of(validation, tmp_path, [result])
    assert "Measured slopes: good 2.00 (at least 1.9); bad 1.00 (at least 1.9; **too flat**)." in text
    assert "![A drawing.](pictures/validation_drawing.png)" in text
    for name in ("pole", "drawing"):
        assert (tmp_path / f"validation_{name}.png").read_bytes().startswith(b"\x89PNG")
    assert not (tmp_path / "validation_broken.png").exists()


def test_a_fast_run_says_what_it_leaves_out(validation, problem, tmp_path):
    @problem.case("long", slow=True)
    def _():
        raise AssertionError("was run")

    @problem.case("short")
    def _():
        return [validation.Value("height [m]", 1.0, 1.0, band=0.1)]

    result = result_of(validation, problem, tmp_path, fast=True)
    assert validation.complaints(result) == []
    assert "1 slow case or figure is left out" in page_of(validation, tmp_path, [result])


def test_other_problems_keep_their_passages(validation, problem, tmp_path):
    """With --only: the rest of the page stays as it is, also the machine, and nothing stands there twice."""

    @problem.case("one")
    def _():
        return [validation.Value("height [m]", 1.0, 1.0, band=0.1)]

    first, second = result_of(validation, problem, tmp_path), result_of(validation, problem, tmp_path)
    second.name = "mast"
    whole = page_of(validation, tmp_path, [first, second])
    second.cases[0].values[0] = validation.Value("depth [m]", 1.0, 1.05, band=0.1)
    partly = page_of(validation, tmp_path, [second], keep_others=True)
    assert "after the rest of the page" in partly
    for name in ("pole", "mast", "machine"):
        assert partly.count(f"<!-- {name}: begin -->") == 1
    before, after = (text.split("<!-- pole: begin -->")[1] for text in (whole, partly))
    assert before == after
    assert "depth" in partly
    assert partly.count("height [m]") == 1
    assert page_of(validation, tmp_path, [first]).count("](#") == 1


def test_a_file_that_cannot_be_read_is_reported(validation, tmp_path, monkeypatch):
    """And the exit code says so, while the other problem is written."""
    (tmp_path / "test_broken_problem.py").write_text("from record import Nothing\n")
    (tmp_path / "test_sound_problem.py").write_text(
        "from record import Problem, Value\n"
        "PROBLEM = Problem(title='Sound', source='A book.', kind='exact', about='About.')\n"
        "@PROBLEM.case('one')\n"
        "def one():\n"
        "    return [Value('height [m]', 1.0, 1.0, band=0.1)]\n"
    )
    monkeypatch.setattr(validation, "LITERATURE", tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(validation, "warm_up", lambda: None)
    assert validation.names() == ["broken_problem", "sound_problem"]
    assert validation.main(["--out", str(tmp_path)]) == 1
    text = (tmp_path / "validation.md").read_text(encoding="utf-8")
    assert "**Failed:** ImportError: cannot import name 'Nothing' from 'record'" in text
    assert "| one | height [m] | 1 | 1 |" in text
    assert validation.main(["--only", "sound_problem", "--out", str(tmp_path)]) == 0


def test_a_run_that_compiles_is_repeated(validation):
    """Wall times are those of runs in which numba compiled nothing."""
    from numba import njit

    runs = []
    fresh = njit(lambda x: x + 1.0)

    def compute():
        runs.append(fresh(1.0))
        return runs

    assert validation.timed(compute)[0] == [2.0, 2.0]
    assert len(validation.timed(compute)[0]) == 3
