"""Tables of the slider-crank study: efforts, figures, claims, pages."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any

from nine_bar_study.claims.evidence import Evidence, Key, Plan, ideal
from nine_bar_study.claims.finding import Claim, Part
from nine_bar_study.claims.page import claims_page
from nine_bar_study.claims.response import equals
from nine_bar_study.drawing import Quantity
from nine_bar_study.effort import Effort
from nine_bar_study.figures.bifurcation import bifurcation
from nine_bar_study.figures.curves import comparison, laws
from nine_bar_study.figures.path import path
from nine_bar_study.figures.phase import phase
from nine_bar_study.figures.section import section
from nine_bar_study.item import StudyFigure, StudyPage
from nine_bar_study.motion import motion
from nine_bar_study.slider_crank.cases import DATA, MACHINE, OVER_CLEARANCE, PLAYS, SPEED, SPEEDS, case
from nine_bar_study.study import Study

FULL = Effort("full", 10, 40, 2, 40, 200, 100, None, 40, 50, exponents=True)
QUICK = Effort("quick", 4, 6, 2, 5, 50, 45, 5, 5, 9, exponents=False)

MODELS = ("ideal", "rigid")
JOURNAL = {"B.ex": Quantity("journal along X", "mm", 1e3), "B.ey": Quantity("journal along Y", "mm", 1e3)}
LAWS = {"none": "no friction", "coulomb": "modified Coulomb friction"}

curves = partial(comparison, models=MODELS)
two_laws = partial(laws, case=case("rigid"), names=LAWS, where="5000 rpm, clearance 0.5 mm")
orbit = partial(path, models=MODELS[1:])
diagram = partial(bifurcation, who="piston pin", signals=JOURNAL)

TABLE: tuple[tuple[Any, ...], ...] = (
    (1, curves, PLAYS, "slider.vx", Quantity("deviation", "m/s")),
    (2, curves, PLAYS, "slider.ax"),
    (3, curves, PLAYS, "motor.torque"),
    (4, curves, PLAYS, "B.force"),
    (5, orbit, PLAYS),
    (6, section, PLAYS, "B.ex"),
    (7, section, PLAYS, "slider.x"),
    (8, curves, SPEEDS, "slider.ax"),
    (9, orbit, SPEEDS),
    (10, phase, SPEEDS, "B.ex"),
    (11, two_laws, "slider.ax"),
    (12, two_laws, "motor.torque"),
    (13, diagram, OVER_CLEARANCE),
)
"""Rows (number, kind, cases or parameter of a diagram, signal, unit of deviations); the numbers are not published."""


def figures(effort: Effort) -> tuple[StudyFigure, ...]:
    """Figures of the slider-crank study at an effort."""
    return tuple(kind(number, effort, *row) for number, kind, *row in TABLE)


START = Key("rigid", SPEED, MACHINE.clearance, "coulomb")
"""Key of the first two turns with friction of the data."""

ACCELERATION = 19419.36
"""Largest acceleration of the ideal slider, r w^2 (1 + r/l) [m/s^2]."""

CONTACT = 2.27286e-4
"""Instant of the first contact [s], independent of the contact law."""

CONTACTS, SLIDER_SPEED, FORCE = 24, 30.6112, 45825.7
"""Number of contacts, largest speed of the slider [m/s] and largest normal force [N] of the first two turns.

The numbers are from Runge-Kutta steps of 1e-8 s in two coordinates (tests/literature/test_worn_pin.py).  With the
friction coefficient 0.03 the contact force is 0.05 % larger than the normal force."""


def ideal_slider(seen: Evidence) -> Iterator[Part]:
    """Part of claim 1: acceleration of the ideal slider."""
    if seen.has(ideal(SPEED)):
        found = float(seen.motions[ideal(SPEED)]["peak.slider.ax"].values.max())
        yield equals("largest slider acceleration", found, ACCELERATION, "m/s^2", 1e-3)


def first_contact(seen: Evidence) -> Iterator[Part]:
    """Part of claim 2: instant of the first contact."""
    if START in seen.starts:
        found = float(seen.starts[START]["contact.start"].values[0])
        yield equals("instant of the first contact", found, CONTACT, "s", 1e-3)


def two_turns(seen: Evidence) -> Iterator[Part]:
    """Parts of claim 3: contacts, speed and force of the first two turns."""
    if START in seen.starts:
        data = seen.starts[START]
        yield equals("contacts", float(data["landings"].sum()), CONTACTS, "", 0.0)
        yield equals("largest slider speed", float(data["peak.slider.vx"].max()), SLIDER_SPEED, "m/s", 1e-2)
        yield equals("largest force", float(data["peak.B.force"].max()), FORCE, "N", 1e-2)


CLAIMS = (
    Claim(
        1,
        "The ideal slider has the largest acceleration r w^2 (1 + r/l) = 19419.36 m/s^2.",
        "2",
        ideal_slider,
        "Rule, settled turns: within 0.1 % of the closed form; above three times that it disagrees.",
    ),
    Claim(
        2,
        "From a centred journal the first contact begins 0.227286 ms after the start.",
        "5",
        first_contact,
        "Rule, 0.5 mm: within 0.1 % of the free flight of the rod; above three times that it disagrees.",
    ),
    Claim(
        3,
        "The first two turns have 24 contacts, 30.6112 m/s at most of the slider, and 45825.7 N at most.",
        "2, 4, 5",
        two_turns,
        "Rule, 0.5 mm, friction 0.03: the same number of contacts; speed and force within 1 % of an independent "
        "computation; above three times that they disagree.",
    ),
)

INTRODUCTION = """
Mechanism and contact law are those of P. Flores, J. Ambrosio, J. C. P. Claro and H. M. Lankarani, Kinematics and
Dynamics of Multibody Systems with Imperfect Joints, Springer 2008. Their curves were not at hand, so the claims are
facts with a source of their own: a closed form, the free flight before the first contact, and an independent
computation of the first two turns.
"""


def pages(effort: Effort) -> tuple[StudyPage, ...]:
    """Pages of the slider-crank study at an effort."""
    start = motion(case("rigid", friction="coulomb", data=DATA, label="start"), 0, 2, 2)
    deciding = Plan({ideal(SPEED): effort.settled(case("ideal"))}, {START: start})
    return (claims_page("The slider-crank against exact and independent numbers", INTRODUCTION, CLAIMS, deciding, {}),)


STUDY = Study(
    "Flores, Ambrosio, Claro and Lankarani, Springer (2008): the slider-crank with a worn piston pin",
    figures,
    pages,
    (case("rigid"),),
    (FULL, QUICK),
)
