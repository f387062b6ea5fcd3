"""The thirteen claims."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from flexmb.paper.claims import chaos, coincidence, response
from flexmb.paper.claims.evidence import Evidence
from flexmb.paper.claims.finding import Finding


class Claim(NamedTuple):
    """A claim of the paper.

    Parameters
    ----------
    number : ours.
    text : what the paper says.
    figures : in which it is shown.
    judge : from the evidence to the finding; its docstring states the rule.
    """

    number: int
    text: str
    figures: str
    judge: Callable[[Evidence], Finding]

    @property
    def rule(self) -> str:
        """The rule by which it is decided, from the docstring."""
        _, _, rule = (self.judge.__doc__ or "").partition("\n\n")
        return " ".join(rule.split())


CLAIMS = (
    Claim(1, "Slider displacement and velocity hardly change with clearance.", "9, 10", response.path_of_slider),
    Claim(
        2,
        "Peaks of slider acceleration and of both torques are far above the ideal mechanism's, and grow from 0.05 to "
        "0.5 mm.",
        "11-13",
        response.far_above,
    ),
    Claim(
        3,
        "Peaks of acceleration and torque occur at the times of the peaks of the contact force.",
        "11-14",
        coincidence.peaks_coincide,
    ),
    Claim(4, "Peaks of the contact force grow with clearance and with speed.", "14, 32", response.force_grows),
    Claim(
        5,
        "Flexible links lower the peaks of contact force, slider acceleration and torques.",
        "11-14, 29-32",
        response.flexible_softens,
    ),
    Claim(
        6,
        "Flexible links shorten free flight and lower the penetration.",
        "15, 16, 33",
        response.flexible_holds_on,
    ),
    Claim(7, "At 2 pi the joint is chaotic at 0.05 and at 0.5 mm, more so at 0.5 mm.", "17-23", chaos.chaotic_joint),
    Claim(
        8,
        "At 0.5 pi and 0.5 mm contact is unbroken, the phase curve closes and the Poincare map is one point.",
        "33-37",
        chaos.slow_is_periodic,
    ),
    Claim(
        9,
        "Over the speed the joint is periodic up to 1.6 pi and chaotic from 1.65 pi on.",
        "40",
        chaos.threshold_of_chaos,
    ),
    Claim(
        10,
        "Over the clearance the joint goes from periodic to chaotic between 0.01 and 0.5 mm.",
        "23",
        chaos.chaos_by_clearance,
    ),
    Claim(11, "The slider's Poincare map stays one point in all runs.", "25, 27, 42, 44", chaos.slider_is_one_point),
    Claim(
        12,
        "Modified Coulomb and LuGre give the same impact times; the peaks with LuGre are higher.",
        "6-8",
        coincidence.friction_laws,
    ),
    Claim(
        13,
        "Torque peaks rise with the driving speed, with friction and flexibility or without.",
        "30, 31",
        response.torque_rises,
    ),
)
