"""Runs of the study: kept and found again, gone on with after a kill, failing alone; what was asked for."""

import os
import signal
import subprocess
import sys
import time
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from nine_bar_study.command import main
from nine_bar_study.crew import work_off
from nine_bar_study.diagram import diagram
from nine_bar_study.effort import FULL, QUICK
from nine_bar_study.nine_bar.cases import OVER_CLEARANCE, OVER_SPEED, case
from nine_bar_study.nine_bar.tables import STUDY
from nine_bar_study.progress import WorkBar, append_line, lines_of
from nine_bar_study.store import Cost, Kept, keep
from nine_bar_study.study import Study, runs_of, shown_numbers, studies, study_of
from study_runs import figure, page, ramp

from flexmb.dynamics.jobs.progress import clock
from flexmb.engine.step.step_size import Adaptive
from flexmb.errors import InputError


@pytest.fixture
def journal(tmp_path):
    return str(tmp_path / "journal.txt")


@pytest.fixture
def kept(tmp_path):
    folder = tmp_path / "runs"
    folder.mkdir()
    return Kept(folder)


@pytest.fixture
def study(monkeypatch, journal):
    """A study of three figures and three pages."""
    a, b, c = (ramp(name, journal, value) for name, value in (("a", 1.0), ("b", 2.0), ("c", 3.0)))
    figures = figure(6, a), figure(7, a, b), figure(9, c)
    pages = page("sums", a, b, picture=True), page("long", c, slow=True)
    made = Study("of tests", lambda effort: figures, lambda effort: pages, ())

    def shows(*others):
        """Other figures in their place; a function of the effort, or figures."""
        given = others[0] if callable(others[0]) else lambda effort: others
        monkeypatch.setattr("nine_bar_study.nine_bar.tables.STUDY", replace(made, figures=given))

    shows(*figures)
    return SimpleNamespace(made=made, shows=shows)


def computed(journal):
    try:
        with Path(journal).open() as file:
            return sorted(file.read().split())
    except FileNotFoundError:
        return []


def paper(*arguments):
    return main([*map(str, arguments), "--workers", "1"])


# What is kept.


def test_a_result_is_found_again(kept, journal):
    run = ramp("a", journal, 2.0)
    assert work_off([run], kept, 1, shown=False) == {}
    again = Kept(kept.folder)
    np.testing.assert_array_equal(again[run]["y"], [0.0, 2.0, 4.0])
    cost = again.cost(run)
    assert (cost.measured, cost.parts) == (1, 1)
    assert 0.0 < cost.wall < 10.0
    assert not list(kept.folder.glob(".*"))


def test_the_result_of_another_run_is_not_taken(kept, journal):
    work_off([ramp("a", journal, 2.0)], kept, 1, shown=False)
    assert not Kept(kept.folder).has(ramp("a", journal, 3.0))


@pytest.mark.parametrize("damage", ["cut", "empty", "text", "foreign"])
def test_a_damaged_file_is_no_result(kept, journal, damage):
    run = ramp("a", journal)
    work_off([run], kept, 1, shown=False)
    path = kept.path(run)
    content = path.read_bytes()
    if damage == "foreign":
        xr.Dataset({"y": ("x", [1.0])}).to_netcdf(path, engine="h5netcdf")
    else:
        path.write_bytes({"cut": content[: len(content) // 2], "empty": b"", "text": b"no netCDF\n" * 99}[damage])
    again = Kept(kept.folder)
    assert not again.has(run)
    assert work_off([run], again, 1, shown=False) == {}
    assert again.has(run)


def test_one_that_fails_does_not_lose_the_others(kept, journal):
    runs = [ramp("a", journal), ramp("bad", journal, how="fails", work=9.0), ramp("b", journal)]
    failures = work_off(runs, kept, 1, shown=False)
    assert list(failures) == ["bad"]
    assert "Newton did not converge" in failures["bad"]
    assert [kept.has(run) for run in runs] == [True, False, True]


def test_the_longest_comes_first(kept, journal):
    work_off([ramp(str(work), journal, work=work) for work in (2.0, 5.0, 1.0)], kept, 1, shown=False)
    with Path(journal).open() as file:
        assert file.read().split() == ["5.0", "2.0", "1.0"]


@pytest.mark.parametrize("how", ["stopped", "Ctrl-C"])
def test_ctrl_c_stops_and_keeps_what_is_finished(kept, journal, how):
    runs = [ramp("a", journal, work=3.0), ramp("stop", journal, how=how, work=2.0), ramp("b", journal)]
    with pytest.raises(KeyboardInterrupt):
        work_off(runs, kept, 1, shown=False)
    assert computed(journal) == ["a", "stop"]
    assert kept.has(runs[0])


KILLED = """
import signal
import sys
from pathlib import Path
from study_runs import ramp
from nine_bar_study.crew import work_off
from nine_bar_study.store import Kept

if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.default_int_handler)  # what runs in the background may ignore it
    journal, folder = sys.argv[1:]
    runs = [ramp("slow", journal, how="slow", work=9.0), ramp("a", journal, work=2.0), ramp("b", journal)]
    work_off(runs, Kept(Path(folder)), 2, shown=False)
"""


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="signals")
@pytest.mark.parametrize("number", [signal.SIGKILL, pytest.param(signal.SIGINT, marks=pytest.mark.slow)])
def test_a_killed_command_goes_on_and_leaves_no_worker(kept, journal, tmp_path, number):
    script = tmp_path / "killed.py"
    script.write_text(KILLED)
    command = subprocess.Popen([sys.executable, script, journal, kept.folder], stderr=subprocess.DEVNULL)
    runs = [ramp(name, journal) for name in ("a", "b")]
    for _ in range(3000):
        if all(kept.path(run).is_file() for run in runs):
            break
        time.sleep(0.1)
    workers = children(command.pid)
    command.send_signal(number)
    command.wait(timeout=60)
    assert len(workers) >= 2
    for _ in range(300):
        left = [pid for pid in workers if is_running(pid)]
        if not left:
            break
        time.sleep(0.1)
    assert not left
    again = Kept(kept.folder)
    assert all(again.has(run) for run in runs)
    assert not again.has(ramp("slow", journal))


def children(pid):
    listed = subprocess.run(["ps", "-eo", "pid=,ppid="], capture_output=True, text=True, check=True).stdout
    return [int(own) for own, parent in (line.split() for line in listed.splitlines()) if int(parent) == pid]


def is_running(pid):
    found = subprocess.run(["ps", "-o", "stat=", "-p", str(pid)], capture_output=True, text=True, check=False).stdout
    return bool(found.strip()) and not found.strip().startswith("Z")


def test_the_time_left_follows_what_runs_took(journal):
    runs = [ramp(str(k), journal, work=10.0) for k in range(4)]
    with WorkBar("runs", [run.work for run in runs], 2, shown=False) as progress:
        assert progress.left == 20.0  # 40 s on two processes
        progress.more(10.0, 30.0, whole=True)
        assert progress.left == 45.0  # 30 s that take three times as long
        progress.more(10.0, None, whole=True)
        assert progress.left == 30.0


def test_progress_of_long_jobs_in_a_file_begins_at_once(capsys):
    """A quick look at the study was silent until its first job of a minute had ended."""
    with WorkBar("runs", [100.0, 20.0], 2, shown=True):
        told = capsys.readouterr().err
    assert told == "runs: 0 %, 0 of 120 s of work, 0 s, 0 of 2 runs, 60 s left\n"


@pytest.mark.parametrize(("seconds", "text"), [(7.4, "7 s"), (150.0, "2 min"), (7500.0, "2 h 5 min")])
def test_times_as_they_are_said(seconds, text):
    assert clock(seconds) == text


# A diagram, point by point.


def short_diagram(keep=2):
    return diagram(case("rigid", 2.5), "speed", (OVER_SPEED.values[0], OVER_SPEED.values[-1]), 1, keep)


@pytest.mark.slow
def test_a_diagram_goes_on_with_its_store(kept):
    run = short_diagram()
    assert work_off([run], kept, 1, shown=False) == {}
    cost, found = kept.cost(run), kept[run]
    assert (cost.measured, cost.parts) == (2, 2)
    assert cost.cpu > 0.0
    assert found["P1.ex"].shape == (2, 2)
    kept.path(run).unlink()
    again = Kept(kept.folder)
    assert work_off([run], again, 1, shown=False) == {}
    assert len(lines_of(again.log(run))) == 2  # nothing was computed anew
    assert again.cost(run) == cost
    xr.testing.assert_identical(again[run].drop_attrs(), found.drop_attrs())
    other = short_diagram(keep=3)
    (text,) = work_off([other], Kept(kept.folder), 1, shown=False).values()
    assert "--fresh" in text
    kept.forget(other)
    assert not kept.store(other).exists()


def test_full_diagrams_are_the_published_sweeps(monkeypatch):
    asked = {}

    def noted(make, parameter, values, **keywords):
        asked.update(keywords, make=make, parameter=parameter, values=values)
        return xr.Dataset({"ok": ("k", [True])})

    monkeypatch.setattr("nine_bar_study.diagram.bifurcation", noted)
    OVER_SPEED.run(FULL, "flexible").compute()
    assert (asked["skip"], asked["keep"], asked["exponent"]) == (20, 50, "points")
    assert asked["step"] == Adaptive(rtol=1e-3, max=2e-4)
    assert asked["period"](2.0 * np.pi) == pytest.approx(1.0)
    mechanism = asked["make"](speed=2.0 * np.pi, **asked["fixed"])
    assert mechanism.find("motor1").motion.time == pytest.approx(2.0)  # a soft start within two turns
    assert mechanism.find("P1").clearance == 0.5e-3
    assert mechanism == case("flexible", 2.0).mechanism()
    assert len(asked["values"]) == 51
    assert asked["values"][0] == pytest.approx(0.5 * np.pi)
    assert asked["values"][-1] == pytest.approx(2.5 * np.pi)
    OVER_CLEARANCE.run(FULL, "rigid").compute()
    mechanism = asked["make"](clearance=1e-4, **asked["fixed"])
    assert mechanism == case("rigid", 2.0, 1e-4).mechanism()
    assert asked["step"] == Adaptive(max=2e-4)
    assert asked["period"] == pytest.approx(1.0)
    np.testing.assert_allclose(asked["values"], 1e-5 * np.array([*range(1, 10), *range(10, 51, 2)]))


def test_a_quick_diagram_has_both_ends():
    values = OVER_SPEED.run(QUICK, "flexible")["values"]
    assert (len(values), values[0], values[-1]) == (QUICK.values, OVER_SPEED.values[0], OVER_SPEED.values[-1])
    assert set(values) <= set(OVER_SPEED.values)


# What is asked for.


@pytest.mark.parametrize(
    ("words", "numbers", "names"),
    [
        ([], [6, 7, 9], ["sums"]),
        (["7"], [7], []),
        (["6-7", "sums"], [6, 7], ["sums"]),
        (["9", "07"], [7, 9], []),
        (["figures"], [6, 7, 9], []),
        (["pages"], [], ["sums"]),
        (["long"], [], ["long"]),
        (["all"], [6, 7, 9], ["sums", "long"]),
    ],
)
def test_words(study, words, numbers, names):
    items = study.made.chosen(words, FULL)
    assert [item.label for item in items] == [*(f"figure {number}" for number in numbers), *names]


@pytest.mark.parametrize(
    ("word", "told"),
    [
        ("8", "no figure 8. There are 6-7, 9"),
        ("6-9", "no figure 8"),
        ("9-6", "must not be above the last"),
        ("sum", "Did you mean 'sums'?"),
        ("6-", "Known: sums, long, figures"),
        ("99999999999-999999999999", "no figure"),
    ],
)
def test_words_that_mean_nothing(study, word, told, tmp_path, capsys):
    assert paper(word, "--out", tmp_path / "out") == 2
    assert told in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_two_runs_of_one_name_are_refused(journal):
    with pytest.raises(InputError, match="two different runs are called 'a'"):
        runs_of([figure(6, ramp("a", journal)), figure(7, ramp("a", journal, 2.0))])


def test_numbers_are_shown_as_ranges():
    assert shown_numbers([figure(number) for number in (6, 7, 8, 23, 40, 41)]) == "6-8, 23, 40-41"


def test_a_study_is_a_folder_of_tables():
    assert {"nine-bar", "slider-crank"} <= set(studies())
    assert study_of("nine-bar") is STUDY
    with pytest.raises(InputError, match="Did you mean 'nine-bar'"):
        study_of("nine-bars")


def test_the_study_has_these_figures_and_each_once():
    numbers = [one.number for one in STUDY.figures(FULL)]
    assert len(set(numbers)) == len(numbers)
    assert numbers == list(range(6, 45))


@pytest.mark.slow
@pytest.mark.parametrize("effort", [pytest.param(FULL, marks=pytest.mark.slow), QUICK])
def test_little_is_computed_twice(effort):
    """Some variations change nothing in some models, so that runs of two names are the same; two runs of one name are
    refused by `runs_of`."""
    runs = runs_of([*STUDY.figures(effort), *STUDY.pages(effort)])
    assert all(run.work > 0.0 for run in runs.values())
    once = {run.fingerprint(): run.work for run in runs.values()}
    assert sum(once.values()) > 0.95 * sum(run.work for run in runs.values())


# The command.


def test_everything_is_written_and_nothing_computed_twice(study, tmp_path, journal, capsys):
    out = tmp_path / "out"
    assert paper("--out", out) == 0
    assert computed(journal) == ["a", "b", "c"]
    names = {f"figure-{n:02d}.{kind}" for n in (6, 7, 9) for kind in ("png", "nc")}
    names |= {"sums.md", "sums.nc", "sums.png", "times.md", "runs"}
    assert {file.name for file in out.iterdir()} == names
    assert (out / "sums.md").read_text() == "# Page sums\n\nThe sum is 9.\n"
    shown = xr.load_dataset(out / "figure-07.nc", engine="h5netcdf")
    np.testing.assert_array_equal(shown["y"], [[0.0, 1.0, 2.0], [0.0, 2.0, 4.0]])
    assert (shown.attrs["figure"], shown.attrs["runs"], shown.attrs["effort"]) == (7, "a, b", "full")
    assert xr.load_dataset(out / "sums.nc", group="picture", engine="h5netcdf")["y"].shape == (2, 3)
    first = (out / "times.md").read_text()
    assert paper("--out", out) == 0
    assert computed(journal) == ["a", "b", "c"]
    assert "0 runs computed, 3 found" in capsys.readouterr().out
    rows = [line for line in first.splitlines() if line.startswith("| a ")]
    assert rows == [
        "| a | " + rows[0].split(" | ")[1] + " | " + rows[0].split(" | ")[2] + " | figure 6, figure 7, sums |"
    ]
    assert rows[0] in (out / "times.md").read_text()  # times are kept with the results
    assert paper("6", "--out", out, "--fresh") == 0
    assert computed(journal) == ["a", "a", "b", "c"]


def test_what_can_be_drawn_is_drawn(study, monkeypatch, tmp_path, journal, capsys):
    good, bad = ramp("good", journal), ramp("bad", journal, how="fails")
    study.shows(figure(6, bad), figure(7, good))
    assert paper("figures", "--out", tmp_path) == 1
    err = capsys.readouterr().err
    assert "run 'bad' failed" in err
    assert "Newton did not converge" in err
    assert "figure 6 could not be made: bad missing" in err
    assert not (tmp_path / "figure-06.png").exists()
    assert (tmp_path / "figure-07.png").exists()
    assert "| figure 6 | 0 of 1 | 0.0 | missing |" in (tmp_path / "times.md").read_text()


def test_a_picture_that_fails_does_not_lose_the_others(study, tmp_path, journal, capsys):
    run = ramp("a", journal)
    study.shows(replace(figure(6, run), draw=lambda results: 1 / 0), figure(7, run))
    assert paper("figures", "--out", tmp_path) == 1
    assert "figure 6 could not be made: ZeroDivisionError" in capsys.readouterr().err
    assert (tmp_path / "figure-07.png").exists()


def test_a_folder_that_cannot_be_written(study, tmp_path, capsys, journal):
    (tmp_path / "file").write_text("")
    assert paper("--out", tmp_path / "file") == 2
    assert "cannot be written" in capsys.readouterr().err
    assert computed(journal) == []


def test_workers_must_be_a_number(study, tmp_path, capsys):
    assert main(["--out", str(tmp_path), "--workers", "0"]) == 2
    assert "--workers is 0; it must be at least 1" in capsys.readouterr().err


def test_the_list(study, capsys):
    assert main(["--list"]) == 0
    out = capsys.readouterr().out
    assert "9  Figure of 1 runs" in out
    assert "long  Page long (only if asked for)" in out


def test_times_that_are_not_known_are_called_so(study, tmp_path, journal):
    """A result that something else than this command wrote, or a diagram of which a part was computed elsewhere."""
    run = ramp("a", journal)
    (tmp_path / "runs").mkdir()
    kept = Kept(tmp_path / "runs")
    foreign = run.compute().assign_attrs(fingerprint=run.fingerprint())
    foreign.to_netcdf(kept.path(run), engine="h5netcdf")
    keep(ramp("c", journal, 3.0), kept.path(ramp("c", journal, 3.0)), foreign, Cost(4.0, 5.0, 3, 7))
    assert paper("6", "9", "--out", tmp_path) == 0
    text = (tmp_path / "times.md").read_text()
    assert "| a | unknown | unknown | figure 6 |" in text
    assert "| c | 4.0 (3 of 7 values known) | 5.0 | figure 9 |" in text
    assert "| figure 9 | 1 | at least 4.0 |" in text
    assert "All runs: at least 4 s of processor time" in text


def test_a_line_that_a_kill_cut_short_is_left_out(tmp_path):
    assert lines_of(tmp_path / "none.times") == []
    (tmp_path / "cut.times").write_text('{"wall": 1.0}\n{"wal')
    assert lines_of(tmp_path / "cut.times") == [{"wall": 1.0}]
    append_line(tmp_path / "cut.times", wall=2.0)
    append_line(tmp_path / "cut.times", wall=3.0)
    assert lines_of(tmp_path / "cut.times") == [{"wall": 1.0}, {"wall": 2.0}, {"wall": 3.0}]


@pytest.mark.slow
def test_a_quick_look_in_the_same_folder_leaves_the_whole_study_as_it_was(study, tmp_path, journal):
    study.shows(lambda effort: (figure(6, ramp("a", journal, {"full": 1.0, "quick": 2.0}[effort.name])),))
    for words in ((), ("--quick",), (), ("--quick",)):
        assert paper("6", "--out", tmp_path, *words) == 0
    assert computed(journal) == ["a", "a"]


@pytest.mark.slow
def test_values_that_failed_are_told_each_time(study, tmp_path, journal, capsys, monkeypatch):
    """A diagram that was kept with them is found again, but never called whole."""

    def half(make, parameter, values, **keywords):
        columns = {"ok": ("k", [True, False]), "status": ("k", ["", "the step became too small"])}
        return xr.Dataset(columns)

    monkeypatch.setattr("nine_bar_study.diagram.bifurcation", half)
    drawn = figure(7, ramp("a", journal))
    study.shows(replace(drawn, runs=(short_diagram(), *drawn.runs)))
    for _ in range(2):
        paper("7", "--out", tmp_path)
        assert "1 of 2 values failed; the first: the step became too small" in capsys.readouterr().err
    assert paper("7", "--out", tmp_path, "--quiet") == 1


@pytest.mark.slow
def test_times_of_points_that_were_deleted_are_forgotten(kept):
    run = short_diagram()
    kept.log(run).write_text('{"processor": 1e6, "wall": 1e6}\n')
    work_off([run], kept, 1, shown=False)
    assert kept.cost(run).cpu < 1e5


def test_there_are_no_more_workers_than_jobs(kept, journal, monkeypatch):
    asked = []

    def noted(workers, *begin):
        asked.append(workers)
        return nullcontext()

    monkeypatch.setattr("nine_bar_study.crew.worker_pool", noted)
    work_off([ramp("a", journal), ramp("b", journal)], kept, 5000, shown=False)
    assert asked == [2]
