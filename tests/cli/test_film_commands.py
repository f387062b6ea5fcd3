"""`flexmb animate` and `flexmb plot`: files, options, messages."""

import runpy
from pathlib import Path

import matplotlib.image
import pytest
from PIL import Image

from flexmb.cli.command_line import main

solution = runpy.run_path(str(Path(__file__).parents[1] / "handmade.py"))["solution"]


@pytest.fixture(scope="module")
def saved(tmp_path_factory):
    return str(solution().to_netcdf(tmp_path_factory.mktemp("run") / "hand.nc"))


@pytest.mark.slow
def test_a_film(saved, tmp_path, capsys):
    out = tmp_path / "out" / "x.gif"
    options = "--seconds 0.4s --fps 10 --size 240x200 --from 0.25 --to 500ms --magnify 2 --colour none --traces crank"
    options += " --follow arm.end"
    assert main(["animate", saved, "--out", str(out), *options.split()]) == 0
    assert capsys.readouterr().out.strip() == str(out)
    with Image.open(out) as film:
        assert (film.n_frames, film.size) == (4, (240, 200))


@pytest.mark.parametrize("command", ["animate", "plot", "report", "vtk"])
def test_a_model_is_no_result(tmp_path, monkeypatch, capsys, command):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "press.py").write_text("")
    more = {"animate": ["--out", "x.gif"], "plot": ["crank.ax", "--out", "x.png"]}.get(command, [])
    assert main([command, "press.py", *more]) == 2
    assert "Run it first (flexmb run press.py), and give the file that this writes: out/press/press.nc" in (
        capsys.readouterr().err
    )


def test_a_plot(saved, tmp_path, capsys):
    out = tmp_path / "x.png"
    assert main(["plot", saved, "crank.ax", "arm.start.x,arm.end.x", "--out", str(out), "--title", "Two"]) == 0
    assert capsys.readouterr().out.strip() == str(out)
    assert matplotlib.image.imread(out).shape[1] == 1200


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["animate", "--out", "x.avi"], "it must end in one of .mp4, .gif, .html"),
        (["animate", "--out", "x.gif", "--seconds", "-1"], "seconds is -1"),
        (["animate", "--out", "x.gif", "--size", "big"], "--size: 'big' is no size"),
        (["animate", "--out", "x.gif", "--traces", "crnk"], "Did you mean 'crank'"),
        (["animate", "--out", "x.gif", "--to", "7s"], "times[1]"),
        (["plot", "crank.axx", "--out", "x.png"], "Did you mean 'crank.ax'"),
        (["plot", "crank.ax,crank.x", "--out", "x.png"], "different units"),
        (["plot", "crank.ax", "--out", "x.nothing"], "cannot be written"),
    ],
)
def test_what_is_refused(saved, tmp_path, monkeypatch, capsys, arguments, words):
    monkeypatch.chdir(tmp_path)
    assert main([arguments[0], saved, *arguments[1:]]) == 2
    text = capsys.readouterr().err
    assert words in text
    assert "Traceback" not in text
    assert not list(tmp_path.iterdir())
