"""Page "exponents": published and computed Lyapunov exponents, and the reason for published values of both signs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from nine_bar_study.drawing import length_text, named, noted
from nine_bar_study.effort import Effort
from nine_bar_study.exponent import LOOKS
from nine_bar_study.figures.exponent import estimate_of, printed_value
from nine_bar_study.item import StudyPage
from nine_bar_study.markdown import table
from nine_bar_study.nine_bar import signs_picture
from nine_bar_study.nine_bar.cases import MACHINE, PLAYS, PRINTED, SPEEDS
from nine_bar_study.nine_bar.readings import comparable, ratios
from nine_bar_study.nine_bar.signs import EDGES, FAR, FOLLOWED, SETTINGS, ByDistance, by_distance, wolf_by_settings
from nine_bar_study.run import Results, StudyRun
from nine_bar_study.samples import SAMPLES, by_period, cloud, growth_rates

from flexmb.dynamics.series.exponent import SeriesExponent, kantz, rosenstein
from flexmb.dynamics.series.samples import zero_one_test
from flexmb.dynamics.verdict import SEPARATE

if TYPE_CHECKING:
    import xarray as xr

METHODS = ("wolf", "rosenstein", "kantz")

APART = 3.0
"""Largest difference of two equal exponents, in standard deviations."""


def exponents(effort: Effort) -> StudyPage:
    """Page "exponents" at an effort."""
    runs = (*PLAYS.attractors(effort), *SPEEDS.attractors(effort))
    about = runs[1]
    title = "The largest Lyapunov exponent: the paper's values, ours, and why the signs differ"
    return StudyPage("exponents", title, runs, partial(write, runs, about), partial(signs_picture.draw, about))


def printed(run: StudyRun, name: str) -> float:
    """Published exponent of the case of a run for an observable; NaN without a published value."""
    return printed_value(PRINTED, run, name)


def write(runs: tuple[StudyRun, ...], about: StudyRun, results: Results) -> tuple[str, xr.Dataset]:
    """Text and numbers of the page.

    Parameters
    ----------
    runs : long runs of the cases.
    about : run of the experiments on signs.
    results : results of the runs.
    """
    import xarray

    cases = [_of_case(run, results[run]) for run in runs]
    tables, settings = by_distance(results[about]), wolf_by_settings(results[about])
    text = "\n\n".join(
        (
            _systems(cases),
            _observables(cases),
            _explanation(about, results[about], tables),
            _distances(tables),
            _settings(settings),
            _readings(cases),
        )
    )
    return text, xarray.Dataset(_numbers(cases) | _of_experiments(tables, settings))


@dataclass(frozen=True, eq=False)
class Of:
    """Exponents and estimates of one case.

    Parameters
    ----------
    run : long run of the case.
    exponent, error : largest exponent of the system and its standard deviation [1/s].
    verdict : verdict on the system.
    rates : growth rate of the tangent vector and its standard error [1/s], by "state" and by observable.
    estimates : estimates from one observable, by observable and method.
    zero_one : result of the 0-1 test of the section points by observable; NaN for too few points or points that differ
        by round-off only.
    through : verdicts by observable.
    clouds : root mean square of the deviation from the periodic part [m], by observable.
    """

    run: StudyRun
    exponent: float
    error: float
    verdict: str
    rates: dict[str, tuple[float, float]]
    estimates: dict[str, dict[str, SeriesExponent]]
    zero_one: dict[str, float]
    through: dict[str, str]
    clouds: dict[str, float]

    @property
    def agrees(self) -> bool:
        """Whether the exponent and the later growth rate of the tangent vector agree within their errors."""
        rate, error = self.rates["state"]
        return abs(rate - self.exponent) <= APART * float(np.hypot(error, self.error))


def _of_case(run: StudyRun, result: xr.Dataset) -> Of:
    estimates, walks = {}, {}
    for name in MACHINE.places:
        signal, interval = by_period(result, name).ravel(), run.case.period / SAMPLES
        others = {method.__name__: method(signal, interval) for method in (rosenstein, kantz)}
        estimates[name] = {"wolf": estimate_of(result, name)} | others
        points = result[f"section.{name}"]
        clear = float(points.std()) > SEPARATE * float(points.attrs.get("resolution", 0.0))
        walks[name] = zero_one_test(points.values, thin=1).value if clear else float("nan")
    return Of(
        run=run,
        exponent=float(result["exponent"]),
        error=float(result["exponent_error"]),
        verdict=str(result.attrs["verdict"]),
        rates=growth_rates(result),
        estimates=estimates,
        zero_one=walks,
        through={name: str(result.attrs[f"verdict.{name}"]) for name in MACHINE.places},
        clouds={name: cloud(by_period(result, name)) for name in MACHINE.places},
    )


def _systems(cases: list[Of]) -> str:
    """Passage and table on the exponent of the system from two parts of each run."""
    head = (
        "case",
        "exponent of the system [1/s]",
        "a period",
        "verdict",
        "a small difference later [1/s]",
        "as seen in",
    )
    rows = []
    for case in cases:
        seen = ", ".join(f"{name} {case.rates[name][0]:.4g}" for name in MACHINE.places)
        later = f"{case.rates['state'][0]:.4g} ± {case.rates['state'][1]:.1g}" + ("" if case.agrees else " (!)")
        each = f"{case.exponent * case.run.case.period:.3g}"
        rows.append((case.run.case.name, f"{case.exponent:.4g} ± {case.error:.1g}", each, case.verdict, later, seen))
    told = (
        "A coupled system has one largest exponent. Twice it was found from the tangent of the time stepper's own "
        "steps: as a mean over the section's periods, and from a small difference in some periods after the series. "
        "What that difference does to each observable grows at one and the same rate, the slider's included."
    )
    if not all(case.agrees for case in cases):
        told += (
            f" (!): the two differ by more than {APART:g} standard deviations: the exponent is not settled, or "
            f"depends on the steps, which {LOOKS} stops a period make shorter in the second."
        )
    return "## The system\n\n" + told + "\n\n" + table(head, rows, left=len(head))


def _observables(cases: list[Of]) -> str:
    """Passage and table of published and estimated exponents by observable."""
    head = ("case", "observable", "the paper", "Wolf", "Rosenstein", "Kantz", "0-1 test", "verdict through it", "cloud")
    rows = []
    for case in cases:
        for name in MACHINE.places:
            value, walk = printed(case.run, name), case.zero_one[name]
            told = (
                f"{value:+.4f}" if np.isfinite(value) else "-",
                *(_estimate(case.estimates[name][method]) for method in METHODS),
                f"{walk:.2f}" if np.isfinite(walk) else "-",
            )
            rows.append((case.run.case.name, name, *told, case.through[name], length_text(case.clouds[name])))
    reasons = dict.fromkeys(
        f"{method}: {found.status}"
        for case in cases
        for name in MACHINE.places
        for method, found in case.estimates[name].items()
        if not found.ok
    )
    text = (
        "Estimates in 1/s, from 100 samples a period of one observable alone, with delay, dimension and time of "
        "following as the estimators choose them. In brackets: what Wolf's method prints although its own checks "
        "refuse it. A minus: no value, because the curve of divergence has no straight part. 0-1 test: of the section "
        "points; a minus where they differ by round-off only or are too few. Cloud: how far the observable is from its "
        "periodic part, root mean square."
    )
    why = "\n".join(f"- {reason}" for reason in reasons)
    refused = f"\n\nWhy estimators give no value here:\n\n{why}" if why else ""
    return "## Observable by observable\n\n" + text + "\n\n" + table(head, rows, left=len(head)) + refused


def _estimate(found: SeriesExponent) -> str:
    if found.ok:
        return f"{found.value:.3g} ± {found.error:.1g}"
    if found.method == "wolf" and len(found.curve):
        return f"({found.curve[-1]:.3g})"
    return "-"


def _explanation(about: StudyRun, result: xr.Dataset, tables: list[ByDistance]) -> str:
    """Passage on the reason for estimates of both signs, with numbers of the experiments."""
    raw, left = tables[0], tables[1]
    far, within = raw.pooled(FAR * raw.cloud, 1.0, 1), raw.pooled(raw.cloud, FAR * raw.cloud, 1)
    lines = (
        f"- The slider moves by {length_text(raw.spread)} (standard deviation); its cloud about the periodic part is "
        f"{length_text(raw.cloud)}. All that is chaotic in it happens below {raw.cloud / raw.spread:.1g} of its size.",
        f"- Neighbours of the raw signal farther apart than {FAR:g} clouds differ in the phase of the cranks, not in "
        "where they are on the attractor. After one period they are as far apart as before: they part at "
        f"{_rate(far)}, while the exponent is {float(result['exponent']):.3g} 1/s.",
        f"- Neighbours between one and {FAR:g} clouds apart are farther apart than usual, and come nearer: "
        f"{_rate(within)}.",
        f"- Only neighbours well within the cloud part: the nearest of the record at {_rate(raw.nearest)} over "
        f"{FOLLOWED[0]:g} periods, without the periodic part at {_rate(left.nearest)}; those of P1.ex at "
        f"{_rate(tables[2].nearest)}.",
        "- So the sign of an estimate from the slider is that of the distance at which its neighbours were taken. A "
        "smallest distance of a percent of the signal, as is usual against noise, lies far above the cloud.",
        "- Two runs 1e-9 m apart part in slider.x and in P1.ex side by side, until each reaches its own cloud.",
    )
    begin = f"Experiments on our own run {about.case.name}; exponents.png shows them."
    return "\n\n".join(("## Why the signs differ", begin, "\n".join(lines)))


def _rate(value: float) -> str:
    return f"{value:+.3g} 1/s" if np.isfinite(value) else "no rate (too few neighbours)"


def _distances(tables: list[ByDistance]) -> str:
    """Table of growth rates over the distance of neighbours."""
    head = ("distance of neighbours", *(f"{t.signal}, {part:g} T" for t in tables for part in FOLLOWED))
    rows = []
    for k, (low, high) in enumerate(pairwise(EDGES)):
        rates = [t.rates[row, k] for t in tables for row in range(len(FOLLOWED))]
        if np.isfinite(rates).any():
            cells = [f"{rate:+.2f}" if np.isfinite(rate) else "" for rate in rates]
            rows.append((f"{length_text(low)} to {length_text(high)}", *cells))
    return "Rates [1/s] at which neighbours part, followed for 0.1 and for 1 period T:\n\n" + table(
        head, rows, left=len(head)
    )


def _settings(found: dict[str, dict[str, tuple[float, bool]]]) -> str:
    """Passage and table of Wolf's estimate over the settings of the method."""
    head = ("Wolf's estimate [1/s]", *SETTINGS)
    rows = []
    for name, estimates in found.items():
        cells = (
            "" if np.isnan(value) else f"{value:.3g}" if ok else f"({value:.3g})" for value, ok in estimates.values()
        )
        rows.append((name, *cells))
    text = (
        "How much of an estimate is the estimator's. Pairs of a record this short are so far apart at first that they "
        "reach the size of the cloud at once; the number is the logarithm of that over the time for which they are "
        "followed, and noise with the same spectrum gives numbers like it. What the exponent is, the tangents and two "
        "runs tell, not this. In brackets: refused by the estimator's own checks. The last five columns: followed for "
        "0.1 periods; unless said otherwise 5 dimensions, 100 samples a period."
    )
    return text + "\n\n" + table(head, rows, left=len(head))


def _readings(cases: list[Of]) -> str:
    """Passage and table of published over computed exponents for each unit."""
    found = ratios([_compared(case) for case in cases])
    head = ("if the paper's values are", "over the system's exponent", "over Wolf's estimate from the same observable")
    rows = [
        (reading, *(f"{min(row):.2g} to {max(row):.2g}" if row else "-" for row in (of_system, of_estimate)))
        for reading, (of_system, of_estimate) in found.items()
    ]
    agreed = comparable(found)
    told = (
        f"Read as {' or '.join(agreed)} they are within a factor 2 of ours."
        if agreed
        else "No reading brings them within a factor 2 of ours, so which unit they have cannot be decided."
    )
    text = (
        "The paper gives no unit, sampling interval or base of the logarithm; programs for Wolf's method often take no "
        "interval and count by samples. A unit is one factor for all values of a case, yet the paper's X and Y of one "
        "motion, whose exponent is the same, differ by factors of 4 to 6: as exponents of the system they fit in no "
        "unit. Ratios of its positive values to ours, smallest to largest:"
    )
    return "## Which unit?\n\n" + text + "\n\n" + table(head, rows, left=len(head)) + "\n\n" + told


def _compared(case: Of) -> list[tuple[float, float, float, float]]:
    """Rows (printed, period, exponent of the system, Wolf's estimate) of the positive published exponents of a case."""
    found = []
    for name in MACHINE.places:
        value, curve = printed(case.run, name), case.estimates[name]["wolf"].curve
        estimate = float(curve[-1]) if len(curve) else float("nan")
        if value > 0.0:
            found.append((value, case.run.case.period, case.exponent, estimate))
    return found


def _numbers(cases: list[Of]) -> dict[str, object]:
    """Variables of the dataset: exponents and estimates of all cases."""
    both = ("case", "observable")

    def of_each(value: Callable[[Of, str], object]) -> list[list[object]]:
        return [[value(case, name) for name in MACHINE.places] for case in cases]

    found: dict[str, object] = {
        "case": named([case.run.case.name for case in cases], "case", "case"),
        "observable": named(list(MACHINE.places), "observable", "observable"),
        "exponent": noted([case.exponent for case in cases], "case", "1/s", "exponent of the system"),
        "exponent_error": noted([case.error for case in cases], "case", "1/s", "its standard deviation"),
        "verdict": named([case.verdict for case in cases], "case", "verdict on the system"),
        "later": noted([case.rates["state"][0] for case in cases], "case", "1/s", "exponent in the periods after"),
        "later_error": noted([case.rates["state"][1] for case in cases], "case", "1/s", "its standard deviation"),
        "growth": noted(of_each(lambda c, n: c.rates[n][0]), both, "1/s", "growth of a small difference"),
        "printed": noted(of_each(lambda c, n: printed(c.run, n)), both, "unknown", "value printed in the paper"),
        "zero_one": noted(of_each(lambda c, n: c.zero_one[n]), both, "1", "0-1 test of the points"),
        "verdict_through": named(of_each(lambda c, n: c.through[n]), both, "verdict through the observable"),
        "cloud": noted(
            of_each(lambda c, n: c.clouds[n]), both, "m", "how far it is from its periodic part, root mean square"
        ),
    }
    for method in METHODS:
        made = [[case.estimates[name][method] for name in MACHINE.places] for case in cases]
        found[method] = noted([[e.value for e in row] for row in made], both, "1/s", f"estimate, {method}")
        found[f"{method}_error"] = noted([[e.error for e in row] for row in made], both, "1/s", f"its error, {method}")
    last = [[case.estimates[name]["wolf"].curve for name in MACHINE.places] for case in cases]
    ends = [[c[-1] if len(c) else np.nan for c in row] for row in last]
    found["wolf_unchecked"] = noted(ends, both, "1/s", "estimate, wolf, passed by its own checks or not")
    return found


def _of_experiments(tables: list[ByDistance], settings: dict[str, dict[str, tuple[float, bool]]]) -> dict[str, object]:
    """Variables of the dataset: results of the experiments."""
    both = ("series", "setting")
    rates, over = np.array([table.rates for table in tables]), ("signal", "followed", "distance")
    wolf, good = ([[entry[k] for entry in row.values()] for row in settings.values()] for k in (0, 1))
    return {
        "signal": named([table.signal for table in tables], "signal", "signal"),
        "followed": noted(list(FOLLOWED), "followed", "1", "time of following, in periods"),
        "distance": noted(np.sqrt(EDGES[1:] * EDGES[:-1]), "distance", "m", "distance of neighbours"),
        "rate": noted(rates, over, "1/s", "rate at which neighbours part"),
        "setting": named(list(SETTINGS), "setting", "what is changed in Wolf's method"),
        "series": named(list(settings), "series", "signal"),
        "wolf_by_setting": noted(wolf, both, "1/s", "Wolf's estimate"),
        "wolf_by_setting_ok": named(good, both, "whether it passes its own checks"),
    }
