"""Pages of fits: numbers of the result, what went wrong at the top, a look in a browser."""

import re

import numpy as np
import pytest
import xarray as xr
from pages import Page, unpacked

import flexmb as fm
from flexmb.errors import InputError
from flexmb.version import installed_version

NOISE = 1e-3


def oscillator(rate: float, push: float, start: float) -> fm.Mechanism:
    body = fm.RigidBody("body", (start, 0.0), 1.0, 1.0)
    guide = fm.Prismatic("guide", fm.GROUND, body, at=(0.0, 0.0), along=(1.0, 0.0))
    ends = {"at": (-1.0, 0.0), "to": (start, 0.0), "free_length": 1.0}
    spring = fm.loads.SpringDamper("spring", fm.GROUND, body, **ends, stiffness=rate, damping=0.7)
    return fm.Mechanism("<oscillator>", [body, guide, spring, fm.Force("push", body, (start, 0.0), (push, 0.0))])


@pytest.fixture(scope="module")
def record():
    """Two records one behind the other, from starts of their own, a gap in the first one."""
    draws, t, found = np.random.default_rng(3), np.linspace(0.0, 1.0, 60), []
    for start in (0.1, -0.05):
        sol = fm.simulate(oscillator(90.0, 0.3, start), t_end=1.0, save=t.tolist(), signals=["body.x", "body.vx"])
        found.append(np.array([sol["body.x"], sol["body.vx"]]) + NOISE * draws.standard_normal((2, len(t))))
    x, v = np.concatenate(found, axis=1)
    x[20:25] = np.nan
    return xr.Dataset({"body.x": ("time", x), "body.vx": ("time", v)}, {"time": np.concatenate([t, t + 1.1])})


BOUNDS = {"rate": (60.0, 120.0), "push": (0.0, 1.0), "start": (-0.2, 0.2)}
HOW = {"signals": ["body.x", "body.vx"], "pieces": [1.1], "free": ["start"], "noise": NOISE, "start": {"rate": 80.0}}


@pytest.fixture(scope="module")
def found(record):
    return fm.design.fit(oscillator, BOUNDS, record, **HOW)


@pytest.mark.slow
def test_numbers_of_a_fit(found, tmp_path):
    page = Page(fm.report(found, tmp_path / "fit.html"))
    assert page.data["kind"] == "fit"
    assert page.data["begins"] == [1.1]
    for name, value in found.parameters.items():
        assert name in page.text
        assert f"{value:.6g}" in page.text
        assert f"{found.errors[name]:.2g}" in page.text
    for value in found.correlation[np.triu_indices(4, 1)]:
        assert f"{value:.3f}" in page.text
    for text in ("<oscillator>", "60 to 120", "rms over noise", f"{found.runs} runs", "Newmark(", installed_version()):
        assert text in page.text
    assert {one["name"] for one in page.data["signals"]} == {"body.x", "body.vx"}
    assert [one["unit"] for one in page.data["signals"]] == ["m", "m/s"]
    time, measured, computed, left = unpacked(page.data["signals"][0]["curves"]).T
    inside = np.isfinite(time)
    assert inside.sum() == 120
    assert np.flatnonzero(~inside).tolist() == [60]  # curves end with their piece
    assert time[inside] == pytest.approx(found.residuals["time"].values, rel=1e-6)
    assert np.isnan(measured[inside]).sum() == 5
    assert np.isfinite(computed[inside]).all()
    assert left[inside] * NOISE == pytest.approx(found.residuals["body.x"].values, rel=1e-4, abs=1e-9, nan_ok=True)
    assert not page.all("oscillator")
    assert not re.search(r"(src|href)=.?https?:", page.source)


def test_one_signal_and_a_title(found, tmp_path):
    page = Page(fm.report(found, tmp_path / "fit.html", signals=["body.vx"], title="A spring"))
    assert [one["name"] for one in page.data["signals"]] == ["body.vx"]
    assert "A spring" in page.text
    with pytest.raises(InputError, match="Known: body"):
        fm.report(found, tmp_path / "fit.html", signals=["body.y"])


@pytest.mark.slow
def test_what_went_wrong_is_told_at_the_top(record, tmp_path):
    """A search that was ended, bounds that are active, parameters that the data do not tell apart, units."""
    short = fm.design.fit(oscillator, BOUNDS, record, **HOW | {"most_runs": 2})
    page = Page(fm.report(short, tmp_path / "short.html"))
    top = page.text.partition("Parameters")[0]
    assert "not converged" in top
    assert "Not converged" in top
    narrow = fm.design.fit(oscillator, BOUNDS | {"rate": (60.0, 85.0)}, record, **HOW)
    page = Page(fm.report(narrow, tmp_path / "narrow.html"))
    assert "At a bound: rate." in page.text.partition("Parameters")[0]
    assert "60 to 85, at the upper" in page.text
    still = oscillator(90.0, 0.3, 0.1)
    twice = {"spring.stiffness": (60.0, 120.0), "body.inertia": (0.5, 2.0)}
    part = record.isel(time=slice(0, 60))
    blind = fm.design.fit(still, twice, part, signals=["body.x"], offset=["body.x"], start={})
    page = Page(fm.report(blind, tmp_path / "blind.html"))
    assert f"Not told apart by the data: {blind.unseen[0]}." in page.text.partition("Parameters")[0]
    assert "of body.inertia" in blind.unseen[0]
    assert "spring.stiffness [N/m]" in page.text
    assert "Offsets" in page.text
    assert "inf" in page.text


@pytest.mark.slow
@pytest.mark.parametrize("width", [1280, 390])
def test_a_fit_in_a_browser(opened, layout_faults, found, tmp_path, width):
    page = opened(fm.report(found, tmp_path / "fit.html"), width, 800, color_scheme="dark")
    assert layout_faults(page) == []
    drawn = page.evaluate("flexmbReport.diagrams.map((pair) => pair.map((one) => one.drawn > 0))")
    assert drawn == [[True, True], [True, True]]
    points = page.evaluate("[...flexmbReport.diagrams[1][1].groups[0].y]")
    left = found.residuals["body.vx"].values / NOISE
    assert [x for x in points if x is not None and x == x] == pytest.approx(left, rel=1e-4, abs=1e-6)
