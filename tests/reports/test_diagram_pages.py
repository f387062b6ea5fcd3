"""Pages of bifurcation diagrams and of studies of a motion: numbers of the datasets, links, a look in a browser."""

from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from pages import Page, unpacked

import flexmb as fm
from flexmb.cli.command_line import main
from flexmb.dynamics.jobs.files import write_netcdf
from flexmb.errors import InputError
from flexmb.show.reports.study_pages import point_file, write_chaos

RATES = [2.8, 3.2, 3.5, 3.9]


def logistic(rate):
    """The logistic map."""

    def step(x, r):
        with np.errstate(over="ignore", invalid="ignore"):  # above r = 4 it runs away
            return r * x * (1 - x)

    return fm.chaos.Map(step, [0.4], parameters={"r": rate}, name="logistic")


@pytest.fixture(scope="module")
def diagram():
    return fm.bifurcation(logistic, "rate", RATES, skip=200, keep=100, exponent=True)


@pytest.fixture(scope="module")
def study():
    """Datasets as `flexmb chaos` writes them, of a motion on a circle with a drifting exponent."""
    turn = np.linspace(0.0, 40.0, 80)
    fine = np.linspace(0.0, 6.3, 200)
    data = {
        "B.ex": ("period", np.cos(turn), {"units": "m"}),
        "B.ey": ("period", np.sin(turn), {"units": "m"}),
        "<i>": ("period", turn, {"units": ""}),
        "exponent": ("number", [3.25, -1.5], {"units": "1/s"}),
        "exponent_error": ("number", [0.5, 0.25]),
        "exponent_statistical": ("number", [0.125, 0.25]),
        "exponent_second": ("number", [3.75, -1.625]),
        "exponent_second_error": ("number", [0.75, 0.375]),
        "exponent_history": (("history_time", "number"), np.array([[1.0, -2.0], [3.0, -1.75], [3.25, -1.5]])),
    }
    coords = {"period": ("period", 21 + np.arange(80)), "history_time": ("history_time", [1.0, 2.0, 3.0])}
    attrs = {"name": "<b>circle", "kind": "chaos", "ok": 1, "status": "Mean of 80 points.", "period": 0.5, "skip": 20}
    attrs |= {"verdict": "chaotic", "reason": "Neighbours part.", "evidence_zero_one": 0.875, "evidence_bands": 1.0}
    attrs |= {"lyapunov_dimension": float("nan"), "second_run": "none", "flexmb": "0.1.0"}
    motion = xr.Dataset({"B.ex": ("time", np.cos(fine)), "B.ey": ("time", np.sin(fine))}, {"time": ("time", fine)})
    return {"": xr.Dataset(data, coords, attrs), "motion": motion}


def test_points_of_a_diagram(diagram, tmp_path):
    (tmp_path / "rate-3.2.html").write_text("")
    page = Page(fm.report(diagram, tmp_path / "diagram.html"))
    (signal,) = page.data["signals"]
    assert np.array_equal(unpacked(signal["points"]), diagram["x0"].values.T.astype(np.float32))
    assert np.array_equal(unpacked(page.data["values"]), RATES)
    rows = page.data["rows"]
    assert [row["verdict"] for row in rows] == diagram["verdict"].values.tolist()
    assert [row["exponent"] for row in rows] == pytest.approx(diagram["exponent"].values, rel=1e-12)
    assert [row["link"] for row in rows] == [None, "rate-3.2.html", None, None]
    for value in diagram["exponent"].values:
        assert f"{value:.4g}" in page.text
    assert {a["href"] for a in page.all("a") if not a["href"].startswith("#")} == {"rate-3.2.html"}


def test_both_directions_and_failed_points(diagram, tmp_path):
    both = fm.bifurcation(logistic, "rate", [3.2, 4.5, 3.5], skip=50, keep=20, direction="both")
    assert not both["ok"].values.all()
    page = Page(fm.report(both, tmp_path / "both.html"))
    rows, points = page.data["rows"], unpacked(page.data["signals"][0]["points"])
    assert {row["direction"] for row in rows} == {"up", "down"}
    for row, column in zip(rows, points.T, strict=True):
        wanted = both.sel(direction=row["direction"])["x0"].values[row["place"]]
        assert np.array_equal(column, wanted.astype(np.float32)) if row["ok"] else np.isnan(column).all()
    assert f"{sum(not row['ok'] for row in rows)} failed" in page.text


def test_names_of_the_reports_of_points():
    assert point_file("speed", 2 * np.pi) == "speed-6.28319.html"
    assert point_file("P1.clearance", 5e-4) == "P1.clearance-0.0005.html"


def test_numbers_of_a_study(study, tmp_path):
    page = Page(write_chaos(study, tmp_path / "report.html", None, None))
    data = page.data
    assert data["section"]["names"] == ["B.ex", "B.ey", "<i>"]
    wanted = np.column_stack([study[""][name].values for name in data["section"]["names"]])
    assert np.array_equal(unpacked(data["section"]["points"]), wanted.astype(np.float32))
    assert data["plane"] == ["B.ex", "B.ey"]
    assert data["first"] == 21
    history = np.column_stack([study[""]["history_time"], study[""]["exponent_history"]])
    assert np.array_equal(unpacked(data["history"]), history.astype(np.float32))
    for text in ("chaotic", "Neighbours part.", "3.25", "0.5", "3.75 \u00b1 0.75", "-1.5", "0.875", "<b>circle"):
        assert text in page.text
    assert not page.all("b")
    assert not page.all("i")
    alone = Page(fm.report(study[""], tmp_path / "alone.html", signals=["B.ey"]))
    assert "motion" not in alone.data
    assert alone.data["plane"] == ["number", "B.ey"]


def test_pages_of_files(study, diagram, tmp_path, capsys):
    write_netcdf(tmp_path / "chaos.nc", study)
    write_netcdf(tmp_path / "bifurcation.nc", {"": diagram})
    assert main(["report", str(tmp_path / "chaos.nc")]) == 0
    assert main(["report", str(tmp_path / "bifurcation.nc"), "--out", str(tmp_path / "d.html")]) == 0
    assert capsys.readouterr().out.split() == [str(tmp_path / "chaos.html"), str(tmp_path / "d.html")]
    whole = write_chaos(study, tmp_path / "whole.html", None, None)
    assert (tmp_path / "chaos.html").read_text() == whole.read_text()
    assert Page(tmp_path / "d.html").data["kind"] == "sweep"


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"signals": ["x1"]}, "Known: x0"),
        ({"signals": "x0"}, "signals"),
        ({"result": xr.Dataset()}, "it must be a Solution, or the dataset"),
        ({"result": SimpleNamespace(attrs={"kind": "bifurcation"})}, "it must be a Solution"),
    ],
)
def test_bad_input(diagram, tmp_path, change, words):
    arguments = {"result": diagram, "path": tmp_path / "page.html", **change}
    with pytest.raises(InputError, match=words):
        fm.report(**arguments)


def test_a_diagram_without_points(diagram, tmp_path):
    empty = diagram.copy(deep=True)
    empty["status"][:] = ""
    with pytest.raises(InputError, match="no finished point"):
        fm.report(empty, tmp_path / "page.html")


@pytest.mark.slow
@pytest.mark.parametrize("width", [1280, 390])
def test_a_diagram_in_a_browser(opened, layout_faults, diagram, tmp_path, width):
    (tmp_path / "rate-3.5.html").write_text("<!DOCTYPE html><title>run at 3.5</title>")
    page = opened(fm.report(diagram, tmp_path / "diagram.html"), width, 800)
    assert layout_faults(page) == []
    page.focus("#diagram")
    page.keyboard.press("End")
    assert "rate = 3.9" in page.locator("#chosen").inner_text()
    assert "chaotic" in page.locator("#chosen").inner_text()
    page.keyboard.press("ArrowLeft")
    assert page.locator("#chosen a").get_attribute("href") == "rate-3.5.html"
    tags = page.evaluate("flexmbReport.diagram.groups.map((group) => [...new Set(group.tags)])")
    assert sorted(k for group in tags for k in group) == [0, 1, 2, 3]
    point = float(diagram["x0"].values[2, 0])
    x, y = page.evaluate(f"flexmbReport.diagram.screen(3.5, {point})")
    page.locator("#diagram").scroll_into_view_if_needed()
    box = page.locator("#diagram").bounding_box()
    page.mouse.click(box["x"] + x, box["y"] + y)
    page.wait_for_url("**/rate-3.5.html")


@pytest.mark.slow
@pytest.mark.parametrize("width", [1280, 390])
def test_a_study_in_a_browser(opened, layout_faults, study, tmp_path, width):
    page = opened(write_chaos(study, tmp_path / "report.html", None, None), width, 800, color_scheme="dark")
    assert layout_faults(page) == []
    points = page.evaluate("[...flexmbReport.diagram.groups[0].x]")
    assert points == pytest.approx(study[""]["B.ex"].values, rel=1e-6)
    assert page.evaluate("flexmbReport.diagram.lines.length") == 1
    page.select_option("#across", "number")
    assert page.evaluate("flexmbReport.diagram.groups[0].x[0]") == 21
    assert page.locator("#verdict").inner_text() == "chaotic"
