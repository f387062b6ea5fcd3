"""A case of the study: the nine-bar mechanism, how it is modelled, driven and worn."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from flexmb import checks
from flexmb.mechanisms.nine_bar import nine_bar
from flexmb.mechanisms.nine_bar_data import NineBarData
from flexmb.model.mechanism import Mechanism
from flexmb.paper.lugre import LoadScaledLuGre

MODELS = ("ideal", "rigid", "flexible")
FRICTION = {
    "coulomb": "coulomb",
    "lugre": LoadScaledLuGre(static=0.015, kinetic=0.01, stribeck_speed=1e-3, stiffness=1e5, damping=300.0),
}
"""Laws of the study: the paper's modified Coulomb, and its LuGre with numbers of ours (its table 3 is missing)."""


@dataclass(frozen=True, kw_only=True)
class Case:
    """One mechanism of the study.

    Parameters
    ----------
    model : "ideal" (rigid links, no play), "rigid" (rigid links, play at P1) or "flexible" (beams, play at P1).
    speed : w over pi [rad/s]; crank 1 turns with -w, crank 4 with +w.
    clearance : c at P1 [m]; an ideal mechanism has none, whatever is said here.
    friction : "coulomb" or "lugre".
    elements : beam elements of each link, and of each side of the panel.
    start : angles of both cranks at the start [rad].
    data : the numbers of the mechanism.
    label : what is unusual about the numbers, for the name: "J7=3.802e-3".

    Raises
    ------
    InputError : values out of range or of the wrong kind.
    """

    model: str
    speed: float
    clearance: float = 0.5e-3
    friction: str = "coulomb"
    elements: int = 4
    start: tuple[float, float] = (0.0, 0.0)
    data: NineBarData = field(default_factory=NineBarData)
    label: str = ""

    def __post_init__(self) -> None:
        checks.one_of("Case", "model", self.model, MODELS)
        checks.one_of("Case", "friction", self.friction, list(FRICTION))
        checks.positive("Case", "speed", self.speed, "pi rad/s")
        checks.positive("Case", "clearance", self.clearance, "m")

    @property
    def period(self) -> float:
        """Of both cranks [s]."""
        return 2.0 / self.speed

    @property
    def name(self) -> str:
        """A name for files and legends: "flexible-2pi-0.5mm"; of what is usual nothing is said."""
        play = "" if self.model == "ideal" else f"-{1e3 * self.clearance:.4g}mm"
        law = "" if self.friction == "coulomb" else f"-{self.friction}"
        mesh = f"-{self.elements}elements" if self.model == "flexible" and self.elements != 4 else ""
        label = f"-{self.label}" if self.label else ""
        return f"{self.model}-{self.speed:.5g}pi{play}{law}{mesh}{label}"

    def mechanism(self) -> Mechanism:
        """The mechanism of this case."""
        return nine_bar(
            math.pi * self.speed,
            clearance=None if self.model == "ideal" else self.clearance,
            flexible=self.model == "flexible",
            friction=FRICTION[self.friction],
            elements=self.elements,
            start=self.start,
            data=self.data,
        )
