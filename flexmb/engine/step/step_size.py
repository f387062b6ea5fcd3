"""Step sizes: fixed steps, or steps by an estimate of the local error."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Self

from flexmb.errors import InputError
from flexmb.fields import Input, count, field, positive, record

RTOL = 1e-4  # accepted error of velocities in a step relative to the largest speed, by default
# Number of steps of an impact at the default rtol; the error of the peak of a half sine is then 0.12 % at most.
IMPACT_STEPS = 32
FEWEST_IMPACT_STEPS = 8  # number of steps of an impact at least, for any rtol
FLIGHT_WEIGHT = 10.0  # factor of the error of positions in free flight
# Number of largest steps in a period or a run, without and with clearance.
# Rigid mechanisms without contacts hardly take smaller steps. Their velocities would allow longer ones, with a residual
# of 2e-6 in the balance of energies.
SMOOTH_STEPS, LARGEST_STEPS = 1000.0, 250.0
FIRST_STEP = 1e-3  # first step of a run over the largest one; the error estimate lets it grow
# Step over the fixed one, below which the next one is a starting step: accelerations of so short a step are round-off.
SHORT_STEP = 1e-3


@record
class FixedStep(Input):
    """Fixed steps."""

    size: float = field("step; where t_end is no multiple of it, the last two are shorter", "s", positive)

    def finer(self) -> Self:
        """Steps of half the size."""
        return replace(self, size=0.5 * self.size)


@record
class Adaptive(Input):
    """Steps chosen by an estimate of the local error, which end at contact events.

    `rtol` is relative to the largest speed of the run so far, where angular speeds count by the size of the mechanism;
    the error of a run falls with rtol^(2/3).  `atol` is divided by the size of the mechanism for angles.  Left out:

    - atol: 2 rtol times the least clearance (at most 2e-2 rtol times the size of the mechanism), 4 rtol times with
      flexible bodies; 1e-3 rtol times the size without clearance.  With rigid bodies alone and no closed contact a
      tenth of it: errors in free flight add up, and decide the place of the next impact.
    - max: 1/250 of the period of the drives, or of the duration; 1/1000 without clearance.  In any case steps are at
      most 1/20 of a cycle of a drive or load.
    - min: 16 units of round-off of the time.
    - impact_steps: 32 for the default rtol, proportional to rtol^(-1/3); 6 with `DormandPrince`.

    Raises
    ------
    InputError : values that are not > 0, rtol that is not < 1, impact_steps that is no whole number, min above max.

    Notes
    -----
    Impacts slower than rtol of the largest speed are not resolved, and neither are lasting contacts, as of a journal
    that slides along the wall of its bearing.  Bodies that nothing connects have largest speeds of their own.
    Velocities of nodes of flexible bodies have no error estimate: fast waves may be
    unresolved.
    """

    rtol: float = field("accepted error of the velocities of bodies in a step, < 1", rule=positive, default=RTOL)
    atol: float | None = field("accepted error of the positions in a step", "m", positive, default=None)
    max: float | None = field("largest step", "s", positive, default=None)
    min: float | None = field("smallest step; a run that needs a smaller one ends", "s", positive, default=None)
    impact_steps: int | None = field("least number of steps from onset to end of an impact", rule=count(), default=None)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.rtol >= 1.0:
            raise InputError(f"Adaptive: rtol is {self.rtol:g}; it must be < 1, e.g. {RTOL:g}.")
        if self.max is not None and self.min is not None and self.min > self.max:
            raise InputError(f"Adaptive: min is {self.min:g} s; it must not be larger than max = {self.max:g} s.")

    @property
    def steps_of_an_impact(self) -> float:
        """Least number of steps of an impact."""
        if self.impact_steps is not None:
            return float(self.impact_steps)
        return float(max(IMPACT_STEPS * (RTOL / self.rtol) ** (1.0 / 3.0), FEWEST_IMPACT_STEPS))

    def finer(self) -> Self:
        """A copy with a tenth of the tolerances."""
        steps = None if self.impact_steps is None else math.ceil(10.0 ** (1.0 / 3.0) * self.impact_steps)
        atol = None if self.atol is None else self.atol / 10.0
        return replace(self, rtol=self.rtol / 10.0, atol=atol, impact_steps=steps)
