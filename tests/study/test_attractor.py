"""A long motion of the study: what its dataset holds, and that its parts are parts of one motion."""

import numpy as np
import pytest
from nine_bar_study.effort import FULL, QUICK
from nine_bar_study.exponent import LOOKS, SHOWN, attractor, growth
from nine_bar_study.motion import motion
from nine_bar_study.nine_bar.cases import MACHINE, PLAYS, SPEEDS, case
from nine_bar_study.samples import by_period, cloud, growth_rates

from flexmb.errors import InputError

pytestmark = pytest.mark.slow

OBSERVED = MACHINE.places
SIGNALS = [name for seen in MACHINE.observables for name in (seen.place, seen.rate)]

CASE = case("rigid", 0.5, longest=1.0)
RUN = attractor(CASE, settle=12, points=50, series=60, samples=50)
"""In contact all the time, periodic, and cheap with steps of milliseconds, whose damping makes differences shrink."""


@pytest.fixture(scope="module")
def result():
    return RUN.compute()


def test_dataset_holds_what_figures_need(result):
    assert dict(result.sizes) == {
        **{"point": 50, "history": 45, "time": 3001, "pair": 12, "lag": LOOKS + 1},
        "step": result.sizes["step"],
    }
    for name in SIGNALS:
        assert {f"section.{name}", name, f"step.{name}"} <= set(result.data_vars)
        assert result[name].attrs["units"] in ("m", "m/s")
    for name in ("state", *OBSERVED):
        assert result[f"apart.{name}"].dims == result[f"growth.{name}"].dims == ("pair", "lag")
    assert all(np.isfinite(result[name].values).all() for name in result.data_vars)


def test_parts_follow_one_another(result):
    T = RUN.case.period
    assert result["history.time"].values[-1] == pytest.approx(62 * T)
    times, steps = result["time"].values, result["step.time"].values
    assert times[0] == pytest.approx(62 * T)
    np.testing.assert_allclose(np.diff(times), T / 50, rtol=1e-9)
    assert steps[0] == pytest.approx(times[-1])
    assert steps[-1] - steps[0] == pytest.approx(SHOWN * T)
    assert (np.diff(steps) > 0.0).all()


def test_series_and_section_show_one_periodic_motion(result):
    for name in SIGNALS:
        at_section, noise = result[f"section.{name}"].values[-10:], result[f"section.{name}"].attrs["resolution"]
        np.testing.assert_allclose(by_period(result, name, 50)[:, 0], at_section.mean(), atol=20.0 * noise, rtol=0)
    assert cloud(by_period(result, "slider.x", 50)) < 1e-6 * np.ptp(result["slider.x"].values)
    assert result.attrs["verdict"] == "periodic-1"
    assert {result.attrs[f"verdict.{name}"] for name in OBSERVED} == {"periodic-1"}


def test_a_small_difference_shrinks_at_one_rate_in_every_observable(result):
    """The rate itself depends on the steps, which damp the contact."""
    assert float(result["exponent"]) < 0.0
    rates = growth_rates(result)
    assert rates["state"][0] < 0.0
    for name in OBSERVED:
        assert rates[name][0] == pytest.approx(rates["state"][0], rel=0.05)


def test_two_runs_part_as_small_differences_do(result):
    apart, growth = result["apart.state"].values[0], result["growth.state"].values[0]
    assert apart[0] == pytest.approx(1e-9, rel=0.05)
    early = slice(1, 20)
    ahead = apart[0] * np.exp(growth[early] - growth[0])
    assert np.abs(np.log(apart[early] / ahead)).max() < np.log(3.0)


def test_fingerprint_and_name_tell_runs_apart():
    other = attractor(RUN.case, settle=12, points=50, series=60, samples=60)
    assert RUN.fingerprint() == attractor(CASE, 12, 50, 60, 50).fingerprint()
    assert len({RUN.fingerprint(), other.fingerprint()}) == 2
    names = {RUN.name, other.name, motion(RUN.case, 5, 20, 2).name, growth(RUN.case, 12, 50).name}
    assert len(names) == 4
    assert attractor(RUN.case, 12, 50, 60).work > RUN.work / 2.0 > 0.0


@pytest.mark.parametrize("wrong", [{"points": 49}, {"series": 4}, {"settle": -1}, {"samples": 10}, {"points": 60.5}])
def test_numbers_that_are_too_small_are_refused(wrong):
    given = {"settle": 12, "points": 50, "series": 5} | wrong
    with pytest.raises(InputError, match=next(iter(wrong))):
        attractor(RUN.case, **given)


def test_ideal_mechanism_is_refused():
    with pytest.raises(InputError, match="without clearance"):
        attractor(case("ideal", 2.0), 12, 50, 5)


@pytest.mark.parametrize("effort", [FULL, QUICK])
def test_runs_of_the_paper(effort):
    runs = (*PLAYS.attractors(effort), *SPEEDS.attractors(effort))
    assert [(run.case.speed, run.case.clearance) for run in runs] == [(2, 5e-5), (2, 5e-4), (0.5, 5e-4), (2.5, 5e-4)]
    assert len({run.name for run in runs}) == 4
    assert {run.case.model for run in runs} == {"flexible"}


@pytest.mark.slow
def test_chaotic_joint_and_slider_see_the_same_exponent():
    result = attractor(case("rigid", 2.0), settle=20, points=50, series=50, samples=50).compute()
    rates = growth_rates(result)
    for name in OBSERVED:  # one exponent, whatever is looked at
        assert rates[name][0] == pytest.approx(rates["state"][0], rel=0.05)
    exponent, error = float(result["exponent"]), float(result["exponent_error"])
    assert abs(rates["state"][0] - exponent) < 4.0 * np.hypot(error, rates["state"][1])
    assert exponent > 10.0
    last = np.log(result["apart.slider.x"].values[:, -20:]).mean()
    assert last > np.log(100.0 * result["apart.slider.x"].values[:, 0]).mean()
