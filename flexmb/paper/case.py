"""A case of the study: the nine-bar mechanism, how it is modelled, driven and worn."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from flexmb import checks
from flexmb.mechanisms.nine_bar import nine_bar
from flexmb.mechanisms.nine_bar_data import NineBarData
from flexmb.model.mechanism import Mechanism
from flexmb.paper.lugre import LoadScaledLuGre
from flexmb.step.step_size import Adaptive

MODELS = ("ideal", "rigid", "flexible")
FRICTION = {
    "coulomb": "coulomb",
    "lugre": LoadScaledLuGre(static=0.015, kinetic=0.01, stribeck_speed=1e-3, stiffness=1e5, damping=300.0),
}
"""Laws of the study: the paper's modified Coulomb, and its LuGre with numbers of ours (its table 3 is missing)."""


LONGEST_STEP = 2e-4
"""[s], a hundredth of the period in which a journal that is pressed on its bearing swings along it.

Friction is constant while it slides, so these vibrations hardly die out.  Steps of milliseconds, which the default
tolerance allows where nothing else moves fast, would damp them: at 0.5 pi rad/s the exponent of the rigid mechanism is
-3 1/s with such steps, and -0.01 +- 0.05 1/s with these."""

SOFT = 2.0
"""Turns in which the cranks get to their speed; a start at full speed would set off vibrations that hardly die out."""

FEWEST_STEPS = 1000
"""A turn, so that smooth peaks are met, too."""


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
    ramp : turns in which the cranks get from rest to their speed; 0: they start at full speed, as those of an ideal
        mechanism always do.
    longest : longest step [s].
    impact_steps : steps that an impact gets at least; None: as the tolerance asks for.
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
    ramp: float = SOFT
    longest: float = LONGEST_STEP
    impact_steps: int | None = None
    label: str = ""

    def __post_init__(self) -> None:
        checks.one_of("Case", "model", self.model, MODELS)
        checks.one_of("Case", "friction", self.friction, list(FRICTION))
        checks.positive("Case", "speed", self.speed, "pi rad/s")
        checks.positive("Case", "clearance", self.clearance, "m")
        checks.not_negative("Case", "ramp", self.ramp, "turns")
        checks.positive("Case", "longest", self.longest, "s")

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

    def steps(self, rtol: float | None = None) -> Adaptive:
        """Steps of its runs.

        Parameters
        ----------
        rtol : accepted error in velocities, relative; None: the default.
        """
        longest, tolerance = min(self.period / FEWEST_STEPS, self.longest), {} if rtol is None else {"rtol": rtol}
        return Adaptive(max=longest, impact_steps=self.impact_steps, **tolerance)

    def mechanism(self) -> Mechanism:
        """The mechanism of this case."""
        return nine_bar(
            math.pi * self.speed,
            clearance=None if self.model == "ideal" else self.clearance,
            flexible=self.model == "flexible",
            friction=FRICTION[self.friction],
            elements=self.elements,
            start=self.start,
            ramp=self.ramp * self.period if self.ramp and self.model != "ideal" else None,
            data=self.data,
        )
