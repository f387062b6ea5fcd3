"""`flexmb new`: the model file runs, and so do the pieces that its comments offer."""

import re

import pytest

import flexmb as fm
from flexmb.cli.arguments.source import find
from flexmb.cli.command_line import main

RUN = ["--periods", "0.02", "--step", "0.1ms", "--save", "50", "--no-vtk", "--no-plots", "--quiet"]


@pytest.fixture
def model(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["new", "press"]) == 0
    assert "flexmb run press.py" in capsys.readouterr().out
    return tmp_path / "press.py"


def test_the_new_model_is_sound_and_runs(model, capsys):
    assert main(["check", "press.py"]) == 0
    assert "Mechanism 'press': nothing to remark" in capsys.readouterr().out
    assert main(["run", "press.py", "--speed", "600rpm", "--mass", "200g", *RUN]) == 0
    sol = fm.load("out/press/press.nc")
    assert sol.array("motor.speed")[0] == pytest.approx(62.831853, rel=1e-8)


def alternative(text, commented, replaced):
    """The text with commented lines in place of others."""
    for line in re.findall(rf"^ *# ({commented}.*)$", text, re.MULTILINE):
        text = text.replace(f"# {line}", line)
    return re.sub(replaced, "", text, flags=re.MULTILINE) if replaced else text


@pytest.mark.slow
@pytest.mark.parametrize(
    ("commented", "replaced", "part", "kind"),
    [
        (r"rod = fm\.FlexibleLink", r"^    rod = fm\.RigidLink.*$", "rod", fm.FlexibleLink),
        (
            r"(?:contact = |piston_pin = fm\.RevoluteClearance)",
            r"^    piston_pin = fm\.Revolute\(.*$",
            "B",
            fm.RevoluteClearance,
        ),
        (r"fm\.SpringDamper", "", "spring", fm.SpringDamper),
        (r"fm\.Force", "", "load", fm.Force),
    ],
)
def test_what_the_comments_offer_works(model, commented, replaced, part, kind):
    text = model.read_text(encoding="utf-8")
    changed = alternative(text, commented, replaced)
    assert changed != text
    model.write_text(changed, encoding="utf-8")
    mech = find("press.py").mechanism({})
    assert isinstance(mech[part], kind)
    assert fm.check(mech).ok
    assert fm.simulate(mech, periods=0.002, step=1e-4).ok


def test_an_existing_file_is_kept(model, capsys):
    model.write_text("mine", encoding="utf-8")
    assert main(["new", "press.py"]) == 2
    assert "is there already. Take another name, or replace it with --force" in capsys.readouterr().err
    assert model.read_text(encoding="utf-8") == "mine"
    assert main(["new", "press", "--force"]) == 0
    assert "def mechanism" in model.read_text(encoding="utf-8")


@pytest.mark.parametrize(("name", "offer"), [("my-press", "my_press"), ("4bar", "m4bar")])
def test_a_name_that_python_cannot_import(name, offer, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["new", name]) == 2
    assert f"such as {offer!r}" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
