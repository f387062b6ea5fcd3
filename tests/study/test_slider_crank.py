"""The second study: its tables make figures and runs, and its claims judge made-up results."""

import math

import pytest
import xarray as xr
from nine_bar_study.claims.evidence import Evidence, ideal
from nine_bar_study.claims.finding import AGREES, DISAGREES, NOT_JUDGED, UNDECIDED
from nine_bar_study.slider_crank.cases import case
from nine_bar_study.slider_crank.tables import CLAIMS, START, STUDY, TABLE
from nine_bar_study.study import runs_of

W, R, L = 5000.0 * math.pi / 30.0, 0.05, 0.12


def pure(acceleration):
    return Evidence({ideal(5000.0): xr.Dataset({"peak.slider.ax": ("turn", [acceleration])})})


def start(first=2.27286e-4, contacts=(22.0, 2.0), speed=30.61, force=45800.0):
    columns = {"contact.start": ("episode", [first, 1e-3]), "landings": ("turn", list(contacts))}
    columns |= {"peak.slider.vx": ("turn", [20.0, speed]), "peak.B.force": ("turn", [force, 100.0])}
    return Evidence(starts={START: xr.Dataset(columns)})


@pytest.mark.parametrize(
    ("number", "seen", "verdict"),
    [
        (1, pure(R * W**2 * (1.0 + R / L)), AGREES),
        (1, pure(1.01 * R * W**2 * (1.0 + R / L)), DISAGREES),
        (1, pure(1.002 * R * W**2 * (1.0 + R / L)), UNDECIDED),
        (2, start(), AGREES),
        (2, start(first=2.3e-4), DISAGREES),
        (3, start(), AGREES),
        (3, start(contacts=(22.0, 3.0)), DISAGREES),
        (3, start(force=46700.0), UNDECIDED),
        (3, start(speed=32.0), DISAGREES),
        (1, Evidence(), NOT_JUDGED),
        (2, Evidence(), NOT_JUDGED),
    ],
)
def test_claims(number, seen, verdict):
    (claim,) = [claim for claim in CLAIMS if claim.number == number]
    assert claim.judge(seen).verdict == verdict


@pytest.mark.parametrize("effort", STUDY.efforts)
def test_tables(effort):
    figures = STUDY.figures(effort)
    assert [one.number for one in figures] == [row[0] for row in TABLE]
    assert all(run.work > 0.0 for run in runs_of([*figures, *STUDY.pages(effort)]).values())


def test_case_is_the_published_mechanism():
    mechanism = case("rigid", 0.5e-3).mechanism()
    assert mechanism.find("B").clearance == 0.5e-3
    assert case("rigid").period == pytest.approx(0.012)
    assert case("rigid", 0.5e-3).name == "rigid-5000rpm-0.5mm"
