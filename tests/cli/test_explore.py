"""`flexmb explore`: sliders from options, ranges and fields; the address is printed, and Ctrl-C ends the page."""

import signal
import subprocess
import sys
import time

import httpx
import pytest

from flexmb.cli import studies
from flexmb.cli.command_line import main


@pytest.fixture
def shown(monkeypatch):
    """Pages that the command shows, closed at once."""
    pages = []

    def closing(page, *, opened, block):
        pages.append((page, opened, block))
        page.close()
        return page

    monkeypatch.setattr(studies, "shown", closing)
    return pages


def knobs_of(shown):
    ((page, opened, block),) = shown
    assert not opened
    assert block
    return page._knobs.known


def test_options_are_starts_and_ranges(shown):
    line = "explore slider-crank --speed 50:500 --clearance 0.1mm --friction coulomb --periods 0.5 --no-open"
    assert main(line.split()) == 0
    knobs = knobs_of(shown)
    assert (knobs["speed"].low, knobs["speed"].high) == (50.0, 500.0)
    clearance = knobs["clearance"]
    assert (clearance.value, clearance.low, clearance.high, clearance.optional) == (1e-4, 2e-5, 5e-4, True)
    page = shown[0][0]
    assert page.view.ok
    assert page.view.mechanism.find("B").friction.coefficient == 0.03
    assert page.command().startswith("flexmb explore slider-crank --")
    assert "--friction=coulomb" in page.command()


def test_the_command_of_a_page_opens_the_same_page(shown):
    assert main("explore slider-crank --speed 300 --clearance 0.1mm --flexible --periods 0.1 --no-open".split()) == 0
    first = shown.pop()[0]
    assert main([*first.command().split()[1:], "--no-open"]) == 0
    again = shown[0][0]
    assert again._runner.request.values == first._runner.request.values
    assert again.view.mechanism == first.view.mechanism


def test_fields_of_parts_vary(shown):
    line = "explore slider-crank --clearance 0.1mm --set slider.mass=200g --vary slider.mass=0.1:0.5 --vary B.clearance"
    assert main([*line.split(), "--t-end", "1ms", "--no-open"]) == 0
    knobs = knobs_of(shown)
    assert list(knobs) == ["slider.mass", "B.clearance"]
    assert (knobs["slider.mass"].value, knobs["slider.mass"].high) == (0.2, 0.5)
    page = shown[0][0]
    assert page.view.solution.time[-1] == pytest.approx(1e-3)
    assert page.code() == "mech.with_({})"
    assert "--clearance=0.1mm --set=slider.mass=200g --vary=slider.mass=0.1:0.5" in page.command()


def test_a_model_file_is_explored(shown, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["new", "press"]) == 0
    assert main("explore press.py --speed 100:400 --periods 0.1 --no-open".split()) == 0
    knobs = knobs_of(shown)
    assert knobs["speed"].unit == "rad/s"
    assert knobs["mass"].meaning == "mass of the slider."
    (tmp_path / "alone.py").write_text("import flexmb as fm\nmech = fm.mechanisms.slider_crank(clearance=1e-4)\n")
    shown.clear()
    assert main("explore alone.py --periods 0.1 --no-open".split()) == 0
    assert "B.clearance" in knobs_of(shown)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("explore slider-crank --speed 1:2:3", "no range"),
        ("explore slider-crank --speed 1:abc", "no number"),
        ("explore slider-crank --speed 2:1", "lower end"),
        ("explore slider-crank --clearance 1um:1mm --vary slider.mass", "neither with --set nor with --vary"),
        ("explore slider-crank --vary slider.mas", "Did you mean 'mass'"),
        ("explore slider-crank --periods 0", "periods"),
        ("explore nothing", "no mechanism"),
    ],
)
def test_wrong_words_are_refused(line, words, shown, capsys):
    assert main([*line.split(), "--no-open"]) == 2
    assert words in capsys.readouterr().err
    assert not shown


@pytest.mark.slow
def test_the_address_is_printed_and_ctrl_c_ends_the_page():
    typed = [sys.executable, "-m", "flexmb", "explore", "slider-crank", "--periods", "0.1", "--no-open"]
    heard = lambda: signal.signal(signal.SIGINT, signal.default_int_handler)  # noqa: E731 - background jobs ignore it
    with subprocess.Popen(typed, stdout=subprocess.PIPE, text=True, preexec_fn=heard) as process:  # noqa: PLW1509
        line = process.stdout.readline()
        url = line.rpartition(" ")[2].strip()
        assert line.startswith("slider-crank: http://127.0.0.1:")
        assert httpx.get(url).status_code == 200
        time.sleep(0.2)
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=30) == 0
