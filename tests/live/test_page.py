"""A live page driven by a script: results are those of `simulate`; failures stay on the page; stale runs end."""

import json
import math
import os
import threading
import time
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import urlsplit

import numpy as np
import pytest

import flexmb as fm
from flexmb.mechanisms import slider_crank
from flexmb.show.live import runs


def test_the_walk_through_of_a_script():
    vary = {"speed": (50.0, 500.0), "clearance": (1e-5, 5e-4)}
    page = fm.explore(slider_crank, vary=vary, open=False, block=False)
    address = urlsplit(page.url)
    assert (address.scheme, address.hostname, address.path) == ("http", "127.0.0.1", "/")
    assert len(address.query.removeprefix("token=")) >= 32
    view = page.set(speed=300.0, clearance=2e-4)
    sol = fm.simulate(slider_crank(speed=300.0, clearance=2e-4), periods=2)
    assert view.ok
    assert view.status == sol.status
    assert view.largest["B.normal_force"] == sol.peak("B.normal_force").value
    assert page.code() == "slider_crank(speed=300.0, clearance=0.0002)"
    assert page.command() == "flexmb explore slider-crank --speed=300.0 --clearance=0.0002 --periods=2"
    page.close()
    with pytest.raises(fm.errors.InputError, match="closed"):
        page.set(speed=200.0)


def test_a_value_that_the_page_refuses_changes_nothing(crank_page):
    before = crank_page.code()
    with pytest.raises(fm.errors.InputError, match="speed is 1000"):
        crank_page.set(speed=1000.0)
    assert crank_page.code() == before


def test_values_may_be_texts_with_a_unit(crank_page):
    crank_page.set(speed="1200 rpm", clearance="0.3 mm")
    assert crank_page.view.values == {"speed": 40.0 * math.pi, "clearance": 3e-4}
    for wrong in ("3 kg", "rpm", "__import__('os')", "9" * 100, "2 pi mm"):
        with pytest.raises(fm.errors.InputError, match=r"clearance.*\bm\b"):
            crank_page.set(clearance=wrong)
    with pytest.raises(fm.errors.InputError, match="clearance: '1e300 um' is too large"):
        crank_page.set(clearance="1e300 um")


def test_an_older_run_is_never_told_after_a_newer_one(crank_page, monkeypatch):
    crank_page.set(speed=300.0)
    older, told = crank_page.view.number, []
    writing, newer, tell = threading.Event(), threading.Event(), crank_page._told

    def slowly(view):
        if view.number == older:
            writing.set()
            newer.wait(1.0)  # a message that is still written when the next run ends
        text = tell(view)
        if view.number > older:
            newer.set()
        return text

    monkeypatch.setattr(crank_page, "_told", slowly)
    monkeypatch.setattr(crank_page._server, "tell", lambda kind, text: told.append((kind, json.loads(text)["number"])))
    asking = threading.Thread(target=crank_page._hear, args=({"type": "want", "signals": []},))
    asking.start()
    assert writing.wait(10.0)
    crank_page.set(speed=200.0)
    asking.join()
    assert [number for kind, number in told if kind == "run"] == [older, older + 1]


@pytest.mark.parametrize("name", ["store", "folder"])
def test_a_folder_that_takes_no_files_is_refused_at_the_start(tmp_path, name):
    (tmp_path / "file").write_text("")
    (tmp_path / "sweep.zarr").mkdir()
    (tmp_path / "sweep.zarr" / "zarr.json").write_text("{}")
    places = {tmp_path / "file": "is a file", tmp_path / "file" / "below": "Not a directory"}
    places |= {
        tmp_path / "sweep.zarr": "is itself the store of a sweep",
        Path("/proc/none"): "takes no files",
        3: "path",
    }
    for place, words in places.items():
        with pytest.raises(fm.errors.InputError, match=words):
            fm.explore(slider_crank, **{name: place}, open=False, block=False)


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_a_folder_without_permission_is_refused_at_the_start(tmp_path):
    tmp_path.chmod(0o500)
    with pytest.raises(fm.errors.InputError, match=r"Permission denied.*in which you may write"):
        fm.explore(slider_crank, store=tmp_path / "diagrams", open=False, block=False)


def broken(speed: float = 1.0) -> fm.Mechanism:
    """A model that raises above 2."""
    if speed > 2.0:
        raise ZeroDivisionError("<b>division</b>")
    return slider_crank(speed=100.0 * speed)


def test_a_model_that_fails_leaves_the_page_usable():
    with fm.explore(broken, vary={"speed": (1.0, 5.0)}, open=False, block=False) as page:
        view = page.set(speed=2.5)
        assert not view.ok
        assert "ZeroDivisionError" in view.status
        assert view.solution is None
        assert view.largest == {}
        assert page.set(speed=1.5).ok


def test_a_model_that_ends_its_program_leaves_the_page_usable():
    def leaving(speed: float = 1.0):
        if speed > 2.0:
            raise SystemExit(3)
        return slider_crank(speed=speed)

    with fm.explore(leaving, vary={"speed": (0.5, 4.0)}, open=False, block=False) as page:
        assert "SystemExit" in page.set(speed=3.0).status
        assert page.set(speed=1.0).ok


def test_a_model_that_fails_at_once_opens_its_page():
    def never(speed: float = 1.0) -> fm.Mechanism:
        raise RuntimeError("no model today")

    with fm.explore(never, vary={"speed": (1.0, 5.0)}, open=False, block=False) as page:
        assert "no model today" in page.view.status
        assert "no model today" in page.set(speed=2.0).status


@dataclass(frozen=True)
class Ending(fm.Motion):
    """A motion that is no number from an instant on."""

    end: float

    @fm.drive_kernel
    def kernel(p, t):
        return (t if t < p[0] else math.nan), 1.0, 0.0


def ending(end: float = 10.0) -> fm.Mechanism:
    """A slider-crank whose drive is no number from `end` [s] on."""
    return slider_crank().with_({"motor.motion": Ending(end)})


def test_a_run_of_nan_is_a_status_and_no_success():
    with fm.explore(ending, vary={"end": (0.01, 10.0)}, t_end=0.5, open=False, block=False) as page:
        view = page.set(end=0.3)
        assert not view.ok
        assert "not finite" in view.status
        assert view.solution.time[-1] < 0.31
        assert page.set(end=1.0).ok


def test_newer_values_end_a_run_that_is_out_of_date():
    def make(speed: float = 100.0) -> fm.Mechanism:
        return slider_crank(speed=speed, clearance=1e-4)

    with fm.explore(make, vary={"speed": (50.0, 500.0)}, periods=2, open=False, block=False) as page:
        runner = page._runner
        long = runner.submit({"speed": 400.0}, 400.0)  # several seconds
        time.sleep(0.3)
        began = time.perf_counter()
        newest = runner.submit({"speed": 101.0}, 1.0)
        view = runner.wait(newest)
        assert time.perf_counter() - began < 3.0
        assert view.values == {"speed": 101.0}
        assert runner.finished == newest.number > long.number
        assert view.solution.time[-1] == pytest.approx(2.0 * np.pi / 101.0)


def test_long_runs_show_their_rows_so_far(monkeypatch):
    monkeypatch.setattr(runs, "EVERY", 0.0)
    seen = []
    page = fm.explore(slider_crank, vary={"clearance": (1e-4, 5e-4)}, periods=1, open=False, block=False)
    with page:
        publish = page._runner.published
        page._runner.published = lambda view: (seen.append(view), publish(view))
        page._runner.wait(page._runner.submit({"clearance": 2e-4}, 20.0))
    assert [view.done for view in seen].count(True) == 1
    ends = [view.solution.time[-1] for view in seen]
    assert len(ends) > 2
    assert ends == sorted(ends)


def test_a_first_run_that_lasts_opens_its_page(monkeypatch):
    """There is no browser yet to which its rows so far could be told."""
    monkeypatch.setattr(runs, "EVERY", 0.0)
    with fm.explore(slider_crank, vary=["speed"], periods=100, open=False, block=False) as page:
        assert page.view.ok, page.view.status


def test_runs_that_go_on_are_those_of_one_long_run():
    with fm.explore(slider_crank, vary={"speed": (100.0, 500.0)}, periods=1, open=False, block=False) as page:
        page.set(speed=300.0)
        page._runner.go_on(True)
        while len(page.view.section) < 4:
            time.sleep(0.02)
        page._runner.go_on(False)
        time.sleep(0.5)
        view = page.view
    period, count = 2.0 * np.pi / 300.0, len(view.section)
    whole = fm.simulate(slider_crank(speed=300.0), periods=count, save=400)
    assert view.solution.time[0] == pytest.approx((count - 1 + 1 / 400) * period)  # one row after the earlier run
    assert view.solution.time[-1] == pytest.approx(count * period)
    names = ["crank.theta", "slider.x", "slider.vx", "motor.torque"]  # after whole turns of an ideal mechanism
    rows = [np.argmin(np.abs(whole.time - k * period)) for k in range(1, count + 1)]
    for name in names:
        k, scale = whole.names.index(name), whole.peak(name).value
        np.testing.assert_allclose(view.section[:, k], whole.array(name)[rows], atol=1e-5 * scale)


def test_points_of_a_run_in_seconds_are_a_period_apart():
    """A slider on its way through the middle, up to the straight lines between 16 rows of a period."""
    body = fm.RigidBody("slider", at=(0.0, 0.0), mass=1.0, inertia=1.0)
    guide = fm.Prismatic("guide", fm.GROUND, body, at=(0.0, 0.0))
    drive = fm.Drive("drive", guide, fm.drives.Harmonic(0.01, frequency=49.7))
    mech = fm.Mechanism("slider", [body, guide, drive])
    with fm.explore(mech, vary=["slider.mass"], t_end=1.0, open=False, block=False) as page:
        names, section = page.view.solution.names, page.view.section
    assert len(section) == 49
    assert np.abs(section[:, names.index("slider.x")]).max() < 1e-5
    assert section[:, names.index("slider.vx")] == pytest.approx(0.01 * 2.0 * math.pi * 49.7, rel=0.03)


def test_a_run_without_period_has_a_length_in_seconds():
    arm = fm.RigidLink("arm", (0.0, 0.0), (0.5, 0.0), mass=1.0, inertia=0.02)
    mech = fm.Mechanism("arm", [arm, fm.Revolute("O", fm.GROUND, arm, at=(0.0, 0.0))], gravity=(0.0, -9.81))
    with fm.explore(mech, vary=["arm.mass"], open=False, block=False) as page:
        view = page.set(**{"arm.mass": 2.0})
        assert view.solution.time[-1] == pytest.approx(1.0)
        assert page.code() == "mech.with_({'arm.mass': 2.0})"
        assert page.command() == ""


def test_many_random_changes_leave_one_thread_and_one_run():
    before = threading.active_count()
    with fm.explore(slider_crank, vary={"speed": (300.0, 500.0)}, periods=0.1, open=False, block=False) as page:
        draw = np.random.default_rng(1).uniform(300.0, 500.0, 200)
        for speed in draw:
            page._runner.submit({"speed": float(speed)})
        last = page.set(speed=float(draw[-1]))
        assert last.values["speed"] == draw[-1]
        assert threading.active_count() <= before + 3
    assert threading.active_count() <= before + 1


def test_periods_and_seconds_exclude_each_other():
    with pytest.raises(fm.errors.InputError, match="give one of them"):
        fm.explore(slider_crank, periods=1, t_end=1.0, open=False, block=False)


def test_a_missing_package_is_named_with_its_extra(monkeypatch):
    import sys

    monkeypatch.setitem(sys.modules, "uvicorn", None)
    with pytest.raises(fm.errors.MissingPackageError, match=r"flexmb\[live\]"):
        fm.explore(slider_crank, vary={"speed": (50.0, 500.0)}, open=False, block=False)
