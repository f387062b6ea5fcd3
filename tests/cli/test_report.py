"""`flexmb report`, and the page that `flexmb run` writes."""

import pytest
from pages import Page

from flexmb.cli.command_line import main

RUN = "run slider-crank --speed 2pi --t-end 10ms --save 20 --no-vtk --no-plots --quiet --out".split()
MODEL = """
import flexmb as fm
arm = fm.RigidLink("arm", (0.0, 0.0), (0.5, 0.0), mass=1.0, inertia=0.02)
mech = fm.Mechanism("arm", [arm, fm.Revolute("O", fm.GROUND, arm, at=(0.0, 0.0))], gravity=(0.0, -9.81))
open("executed", "a").close()
"""


@pytest.mark.slow
def test_the_page_of_a_run_can_be_written_again(tmp_path, capsys):
    assert main([*RUN, str(tmp_path)]) == 0
    capsys.readouterr()
    first = (tmp_path / "report.html").read_text()
    (tmp_path / "report.html").unlink()
    assert main(["report", str(tmp_path / "slider-crank.nc")]) == 0
    assert capsys.readouterr().out.strip() == str(tmp_path / "report.html")
    assert (tmp_path / "report.html").read_text() == first
    assert [path.suffix for path in sorted(tmp_path.iterdir())] == [".html", ".nc"]
    page = Page(tmp_path / "report.html")
    assert "flexmb run slider-crank --speed 2pi --t-end 10ms --save 20" in page.text
    assert "Not examined" not in page.text
    assert main([*RUN[:-1], "--no-report", "--out", str(tmp_path / "other")]) == 0
    assert [path.name for path in (tmp_path / "other").iterdir()] == ["slider-crank.nc"]


def test_a_users_file_is_executed_only_if_it_is_named(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "arm.py").write_text(MODEL)
    arguments = ["run", "arm.py", "--t-end", "0.1s", "--save", "20", "--no-vtk", "--no-plots", "--quiet", "--out", "o"]
    assert main(arguments) == 0
    (tmp_path / "executed").unlink()
    assert main(["report", "o/arm.nc", "--out", "plain.html", "--frames", "5"]) == 0
    assert not (tmp_path / "executed").exists()
    plain = Page(tmp_path / "plain.html")
    assert "Not examined" in plain.text
    assert plain.data["scene"]["frames"]["n"] == 5
    assert main(["report", "o/arm.nc", "arm.py", "--out", "whole.html"]) == 0
    assert (tmp_path / "executed").exists()
    assert "Not examined" not in Page(tmp_path / "whole.html").text


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["missing.nc"], "there is no such file"),
        (["text.nc"], "cannot be read as a solution"),
        (["text.nc", "no-bar"], "cannot be read as a solution"),
    ],
)
def test_bad_input(tmp_path, monkeypatch, capsys, arguments, words):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "text.nc").write_text("no netCDF")
    assert main(["report", *arguments]) == 2
    assert words in capsys.readouterr().err
