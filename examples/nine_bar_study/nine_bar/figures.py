"""Table of the figures 6 to 44: number, kind, cases, signals."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from nine_bar_study.drawing import Quantity
from nine_bar_study.effort import Effort
from nine_bar_study.figures.bifurcation import bifurcation
from nine_bar_study.figures.curves import comparison, laws
from nine_bar_study.figures.exponent import exponent
from nine_bar_study.figures.path import path
from nine_bar_study.figures.phase import phase
from nine_bar_study.figures.section import section
from nine_bar_study.item import StudyFigure
from nine_bar_study.nine_bar.cases import OVER_CLEARANCE, OVER_SPEED, PLAYS, PRINTED, SPEEDS, case

UM, MM_S = Quantity("deviation", "µm", 1e6), Quantity("deviation", "mm/s", 1e3)
"""Units of deviations from the ideal mechanism in figures of the displacement and velocity of the slider."""

LAWS = {"coulomb": "modified Coulomb friction", "lugre": "LuGre friction"}
JOINT = {"P1.ex": Quantity("journal along X", "mm", 1e3), "P1.ey": Quantity("journal along Y", "mm", 1e3)}
SLIDER = {
    "slider.x": Quantity("place of the slider", "mm", 1e3),
    "slider.x.deviation": Quantity("slider less its mean", "µm", 1e6),
}
STROKE = case("ideal", 2.0)

two_laws = partial(laws, case=case("rigid", 2.5), names=LAWS, where="2.5π rad/s, clearance 0.5 mm")
running = partial(exponent, printed=PRINTED)
of_joint = partial(bifurcation, who="clearance joint", signals=JOINT)
of_slider = partial(bifurcation, who="slider", signals=SLIDER, ideal=STROKE)

TABLE: tuple[tuple[Any, ...], ...] = (
    (6, two_laws, "slider.ax"),
    (7, two_laws, "motor1.torque"),
    (8, two_laws, "motor4.torque"),
    (9, comparison, PLAYS, "slider.x", UM),
    (10, comparison, PLAYS, "slider.vx", MM_S),
    (11, comparison, PLAYS, "slider.ax"),
    (12, comparison, PLAYS, "motor1.torque"),
    (13, comparison, PLAYS, "motor4.torque"),
    (14, comparison, PLAYS, "P1.force"),
    (15, comparison, PLAYS, "P1.penetration"),
    (16, path, PLAYS),
    (17, phase, PLAYS, "P1.ex"),
    (18, phase, PLAYS, "P1.ey"),
    (19, section, PLAYS, "P1.ex"),
    (20, section, PLAYS, "P1.ey"),
    (21, running, PLAYS, "P1.ex"),
    (22, running, PLAYS, "P1.ey"),
    (23, of_joint, OVER_CLEARANCE),
    (24, phase, PLAYS, "slider.x"),
    (25, section, PLAYS, "slider.x"),
    (26, running, PLAYS, "slider.x"),
    (27, of_slider, OVER_CLEARANCE),
    (28, comparison, SPEEDS, "slider.vx", MM_S),
    (29, comparison, SPEEDS, "slider.ax"),
    (30, comparison, SPEEDS, "motor1.torque"),
    (31, comparison, SPEEDS, "motor4.torque"),
    (32, comparison, SPEEDS, "P1.force"),
    (33, path, SPEEDS),
    (34, phase, SPEEDS, "P1.ex"),
    (35, phase, SPEEDS, "P1.ey"),
    (36, section, SPEEDS, "P1.ex"),
    (37, section, SPEEDS, "P1.ey"),
    (38, running, SPEEDS, "P1.ex"),
    (39, running, SPEEDS, "P1.ey"),
    (40, of_joint, OVER_SPEED),
    (41, phase, SPEEDS, "slider.x"),
    (42, section, SPEEDS, "slider.x"),
    (43, running, SPEEDS, "slider.x"),
    (44, of_slider, OVER_SPEED),
)
"""Rows (number, kind, cases or parameter of a diagram, signal, unit of deviations)."""


def figures(effort: Effort) -> tuple[StudyFigure, ...]:
    """Figures of the nine-bar study at an effort."""
    return tuple(_made(number, effort, *row) for number, *row in TABLE)


def _made(number: int, effort: Effort, kind: Callable[..., StudyFigure], *row: object) -> StudyFigure:
    return kind(number, effort, *row)
