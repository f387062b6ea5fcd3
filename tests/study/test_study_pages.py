"""Pages claims, threshold, convergence, damping, sensitivity: their runs, and their texts from made-up results."""

import dataclasses
import math

import numpy as np
import pytest
import xarray as xr
from nine_bar_study.case import JOINT_CURVES
from nine_bar_study.claims.page import written
from nine_bar_study.diagram import measure_diagram
from nine_bar_study.effort import FULL, QUICK
from nine_bar_study.exponent import growth, measure_attractor, measure_growth
from nine_bar_study.motion import measure_motion
from nine_bar_study.nine_bar import plan as plans
from nine_bar_study.nine_bar.cases import MACHINE, case
from nine_bar_study.nine_bar.claims import CLAIMS
from nine_bar_study.nine_bar.measures import LARGE, MEASURES, MIDDLE, SMALL, case_of, key
from nine_bar_study.nine_bar.pages import convergence, damping, sensitivity
from nine_bar_study.nine_bar.pages.threshold import FINE
from nine_bar_study.nine_bar.reaction import measure_reaction
from nine_bar_study.nine_bar.tables import STUDY
from nine_bar_study.nine_bar.variations import DAMPED, DATA, USUAL, VARIATIONS, ZETAS
from nine_bar_study.onset import measure_onset, onset
from nine_bar_study.run import StudyError
from study_runs import check_data

import flexmb as fm

NAMES = ("claims", "threshold", "convergence", "damping", "sensitivity")
CURVES = [name for name in MACHINE.curves if name.rpartition(".")[2] not in JOINT_CURVES]


def page_of(name, effort):
    return next(page for page in STUDY.pages(effort) if page.name == name)


def made_up(run):
    """A result of the right form; peaks of flexible links are half of those of rigid ones."""
    if run.measure is measure_motion:
        low = {"ideal": 0.1, "rigid": 1.0, "flexible": 0.5}[run.case.model] * (1.0 if run.case.rtol is None else 1.001)
        jitter = 1.0 + 0.01 * np.tile([1.0, -1.0], run["keep"])[: run["keep"]]
        t = np.linspace(0.0, run["shown"] * run.case.period, 301)
        columns = dict.fromkeys(
            (*(measure.name for measure in MEASURES), "step"), ("turn", low * run.case.speed * jitter)
        )
        columns |= {name: ("time", np.sin(math.pi * run.case.speed * t)) for name in CURVES}
        columns |= {f"large.{name}": (f"instant.{name}", t[::100]) for name in MACHINE.peaks}
        columns |= {"time": ("time", t), "contact.start": ("episode", t[::50])}
        return xr.Dataset(columns, attrs={"period": run.case.period, "first_turn": run["skip"] + 1})
    if run.measure in (measure_growth, measure_attractor):
        names = ("P1.ex", "P1.ey", "slider.x")
        about = {"verdict": "chaotic", "reason": "", **{f"verdict.{name}": "chaotic" for name in names}}
        columns = {f"section.{name}": ("point", np.linspace(0.0, 1e-5, 50)) for name in names}
        return xr.Dataset(columns | {"exponent": 20.0, "exponent_error": 0.5}, attrs=about)
    if run.measure is measure_diagram:
        values = np.array(run["values"])
        exponent = np.linspace(-3.0, 30.0, len(values))
        kinds = np.where(exponent > 0.0, "chaotic", "periodic-1").astype(object)
        columns = {"verdict": kinds, "exponent": exponent, "exponent_error": 0.1 + 0.0 * values, "ok": values > 0.0}
        columns = {name: (run["parameter"], column) for name, column in columns.items()}
        columns["slider.x"] = ((run["parameter"], "period"), 1e-6 * values[:, None] * np.array([0.0, 1.0, 0.5]))
        return xr.Dataset(columns, coords={run["parameter"]: values})
    if run.measure is measure_reaction:
        angle = np.arange(run["points"]) * 2.0 * math.pi / run["points"]
        static = np.tile([-50.0, 0.1], (run["points"], 1))
        dynamic = np.stack([2.0 + np.cos(angle), 0.3 * np.sin(angle)], axis=1)
        axes = {"angle": angle, "axis": ["x", "y"]}
        return xr.Dataset({"static": (("angle", "axis"), static), "dynamic": (("angle", "axis"), dynamic)}, coords=axes)
    if run.measure is measure_onset:
        columns = {"speed": [1.6, 1.605], "flight": [0.0, 0.01], "landings": [0.0, 3.0], "least_force": [2.0, 0.0]}
        about = {"last_unbroken": 1.6, "first_broken": 1.605}
        return xr.Dataset({name: ("trial", values) for name, values in columns.items()}, attrs=about)
    raise TypeError(run)


@pytest.fixture(params=[FULL, QUICK], ids=["full", "quick"])
def effort(request):
    return request.param


@pytest.mark.quick(1)
@pytest.mark.parametrize("name", NAMES)
def test_runs_of_one_name_are_one_run(name, effort):
    page = page_of(name, effort)
    assert page.name == name
    assert len({run.name.lower() for run in page.runs}) == len(page.runs) == len(set(page.runs))  # as file names
    assert all(run.work > 0.0 for run in page.runs)


def test_runs_of_one_name_are_one_run_across_the_pages(effort):
    known = {}
    for page in STUDY.pages(effort):
        for run in page.runs:
            assert known.setdefault(run.name, run) == run


@pytest.mark.quick(1)
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("effort", [pytest.param(FULL, marks=pytest.mark.slow), QUICK], ids=["full", "quick"])
def test_a_page_is_written_from_its_results(name, effort, tmp_path):
    page = page_of(name, effort)
    text, data = page.write({run: made_up(run) for run in page.runs})
    assert text.endswith("\n")
    assert "nan" not in text
    check_data(data, tmp_path / "page.nc")
    widths = {line.count(" | ") for line in text.split("\n\n")[-1].splitlines() if line.startswith("| ")}
    assert len(widths) <= 1  # every row of a table has as many cells


def test_page_of_claims_has_all_with_verdict_rule_and_attack():
    page = page_of("claims", FULL)
    text, data = page.write({run: made_up(run) for run in page.runs})
    assert list(data["claim"].values) == list(range(1, 18))
    for number in range(1, 18):
        assert f"## Claim {number}: " in text
    disagreeing = int((data["verdict"] == "disagrees").sum() + (data["verdict"] == "cannot be decided").sum())
    assert disagreeing > 0
    assert text.count("Attacked with:") == disagreeing
    assert "rtol 1e-05" in text


def test_a_quick_look_can_decide_claims_on_chaos():
    """Diagrams of few points without exponents cannot: with means of 3 turns they left 9 of 13 claims open."""
    page = page_of("claims", QUICK)
    _, data = page.write({run: made_up(run) for run in page.runs})
    verdicts = dict(zip(data["claim"].values.tolist(), data["verdict"].values.tolist(), strict=True))
    assert {verdicts[number] for number in (9, 10)} == {"disagrees"}  # all is chaotic here
    assert "not judged" not in verdicts.values()
    assert not any(run.measure is measure_diagram for run in page.runs)
    assert QUICK.keep >= 10


def judged(results, deciding, others):
    return written(results, introduction="", claims=CLAIMS, deciding=deciding, attacks=others)


def made_worse(*chosen):
    """Results in which the flexible links make peaks larger in some plans."""
    results = {run: made_up(run) for run in page_of("claims", FULL).runs}
    for one, run in (item for plan in chosen for item in plan.motions.items()):
        if one.model == "flexible":
            results[run] = made_up(run) * 4.0
            results[run].attrs = made_up(run).attrs
    return results


def test_what_disagrees_in_the_first_runs_only_is_not_decided():
    deciding, others = plans.plan(FULL), plans.attacks(FULL)
    text, _ = judged(made_worse(deciding), deciding, others)
    passage = text.split("## Claim 5: ")[1].split("## Claim 6")[0]
    assert passage.startswith("cannot be decided")
    assert "this disagrees, but not with rtol 1e-05" in passage
    row = next(line for line in passage.splitlines() if "| rtol 1e-05 |" in line and "2 pi rad/s, 0.5 mm" in line)
    assert [cell.strip() for cell in row.split("|")][2:5] == ["cannot be decided", "rtol 1e-05", "agrees"]


def test_what_disagrees_in_finer_runs_too_disagrees():
    deciding, others = plans.plan(FULL), plans.attacks(FULL)
    text, _ = judged(made_worse(deciding, *others.values()), deciding, others)
    assert text.split("## Claim 5: ")[1].startswith("disagrees")


def test_convergence_tells_lower_from_no_difference():
    levels = convergence.levels(FULL)
    found = {((2.0, 5e-4), level): made_up(level.run(2.0, 5e-4, FULL)) for level in levels}
    text, data = convergence.written(found)
    row = next(line for line in text.splitlines() if line.startswith("| contact force | 0.5"))
    assert row.count("lower") == 4
    assert float(data["mean"].sel(level="rigid, rtol 1e-4", quantity="flight")[0]) == pytest.approx(2.0)
    assert "within the error" not in text  # refinement changes nothing here, and the spread is small: equal
    assert "equal" in text


@pytest.mark.slow
def test_sensitivity_marks_a_verdict_that_changes():
    rows = sensitivity.rows_of(FULL)
    results = {run: made_up(run) for run in sensitivity.sensitivity(FULL).runs}
    without_friction = next(row for row in rows if row.variation.what.startswith("no friction"))
    for one, run in without_friction.plan.motions.items():
        if one.model == "flexible":
            results[run] = made_up(dataclasses.replace(run, case=dataclasses.replace(run.case, model="rigid")))
            results[run]["peak.P1.force"] *= 3.0
    text, data = sensitivity.written(results, rows, FULL, sensitivity.INTRODUCTION)
    assert data["verdict"].sel(variation=without_friction.variation.what, claim=5) == "disagrees"
    line = next(line for line in text.splitlines() if f"| {without_friction.variation.what} |" in line)
    assert "**D**" in line
    assert f"({without_friction.variation.letter}) {without_friction.variation.what}: claim 5 disagrees" in text
    assert "claim 9" not in text.split("## What changed")[1].split("## What cannot")[0]


def test_sensitivity_rests_on_flexible_exponents_where_beams_change():
    for row in sensitivity.rows_of(FULL):
        models = {one.model for one in row.plan.growths}
        assert models == ({"rigid"} if row.lacking or row.variation.staggered else {"flexible"})


def test_damping_tells_what_disagrees_from_what_depends_on_it():
    verdicts = np.full((len(ZETAS), len(CLAIMS)), "agrees", dtype=object)
    verdicts[:, 4] = "disagrees"
    verdicts[:3, 6], verdicts[5:, 8] = "disagrees", "cannot be decided"
    verdicts[3:, 1] = "disagrees"
    lines = {line.split(" | ")[0]: line for line in damping.standing(verdicts).splitlines() if line.startswith("| ")}
    assert "disagrees, whatever the damping" in lines["| 5"]
    assert "depends on what was not published: agrees at 1e-05, 2e-05, 3e-05, 5e-05, 0.0001, 0.001 s; " in lines["| 7"]
    assert "agrees where it can be decided" in lines["| 9"]
    assert "agrees, whatever the damping" in lines["| 1"]
    assert "Most claims agree at zeta2 = 1e-07, 5e-06, 1e-06 s" not in damping.standing(verdicts)
    assert "16 at 1e-05 s" not in damping.standing(verdicts)
    assert f"{len(CLAIMS) - 2} at 1e-07 s" in damping.standing(verdicts)


@pytest.mark.slow
def test_damping_judges_all_claims_at_each_value():
    page = page_of("damping", FULL)
    _, data = page.write({run: made_up(run) for run in page.runs})
    assert data.sizes == {"variation": len(DAMPED), "claim": len(CLAIMS)}
    assert not (data["verdict"].values[: len(ZETAS)] == "not judged").any()
    zetas = [one.of(case_of(key("flexible", MIDDLE))).data.damping for one in DAMPED[: len(ZETAS)]]
    assert tuple(zetas) == ZETAS == tuple(sorted(ZETAS))
    assert (ZETAS[0], ZETAS[-1]) == (1e-7, 1e-3)


def test_what_cannot_be_built_from_beams_is_said():
    lacking = {row.variation.letter for row in sensitivity.rows_of(FULL) if row.lacking}
    assert lacking == {"b", "c"}  # a frame of three beams has more inertia than these


def test_every_variation_changes_what_it_says():
    assert len({variation.letter for variation in VARIATIONS}) == len(VARIATIONS)
    usual = case_of(key("flexible", MIDDLE))
    for variation in VARIATIONS:
        found = variation.of(usual)
        assert found != dataclasses.replace(USUAL.of(usual), label=found.label)
        rigid = variation.of(case_of(key("rigid", MIDDLE)))
        assert rigid.data in (None, DATA) or not variation.beams_only


def test_printed_stiffness_is_that_of_convex_surfaces():
    (variation,) = (v for v in VARIATIONS if v.convex)
    for clearance in (SMALL, LARGE):
        R1 = DATA.bearing_radius
        R2 = R1 - clearance
        ratio = variation.numbers(clearance).contact_young / DATA.contact_young
        assert ratio**2 == pytest.approx((R1 * R2 / (R1 + R2)) / (R1 * R2 / (R1 - R2)), rel=1e-12)


@pytest.fixture
def known(monkeypatch):
    """A mechanism that is known to fly from a speed on."""

    def tried(case, speed, settle, keep, start):
        return speed, float(speed > 1.634) * 0.02, 0.0, 1.0

    monkeypatch.setattr("nine_bar_study.onset.tried_at", tried)
    return lambda begin, highest: onset(case("rigid", begin), highest, 1, 1, coarse=0.05, fine=FINE).compute()


@pytest.mark.parametrize("begin", [1.4, 1.6, 1.63])
def test_onset_brackets_the_threshold(known, begin):
    found = known(begin, 2.0)
    low, high = found.attrs["last_unbroken"], found.attrs["first_broken"]
    assert low <= 1.634 < high
    assert high - low <= FINE * (1.0 + 1e-9)
    assert np.all(np.diff(found["speed"]) > 0.0)
    assert found["flight"].values.tolist() == [0.02 * (v > 1.634) for v in found["speed"].values]


@pytest.mark.parametrize(("begin", "highest", "message"), [(1.7, 2.0, "first speed"), (1.4, 1.6, "Go higher")])
def test_onset_outside_of_the_search_is_an_error(known, begin, highest, message):
    with pytest.raises(StudyError, match=message):
        known(begin, highest)


def test_onset_refuses_an_unknown_start():
    with pytest.raises(fm.errors.InputError, match="soft"):
        onset(case("rigid", 1.4), 2.0, 1, 1, "softly", coarse=0.05, fine=FINE)


@pytest.mark.slow
def test_contact_of_the_rigid_mechanism_breaks_between_16_and_165_pi():
    found = onset(case("rigid", 1.6), 1.7, 25, 10, coarse=0.05, fine=FINE).compute()
    assert 1.6 <= found.attrs["last_unbroken"] < found.attrs["first_broken"] <= 1.65
    assert found["least_force"].values[0] > 0.0


@pytest.mark.slow
def test_a_slow_mechanism_returns_and_the_steps_damp_none_of_it():
    found = growth(case("rigid", 0.5), 20, 50).compute()
    assert found.attrs["verdict"] == "periodic-1"
    assert abs(float(found["exponent"])) < 0.15  # -3 1/s with steps of milliseconds
    assert found.sizes["point"] == 50
    assert max(np.ptp(found[f"section.{name}"].values) for name in ("P1.ex", "P1.ey")) < 1e-3 * 0.5e-3
