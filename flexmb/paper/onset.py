"""The speed up to which contact at P1 is unbroken."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexmb import checks
from flexmb.paper.case import SOFT, Case
from flexmb.paper.motion import METHOD, WORK, StudyError
from flexmb.run.run import installed_version
from flexmb.run.simulate import simulate
from flexmb.sweeps.fingerprint import digest

if TYPE_CHECKING:
    import xarray as xr

COARSE, FINE = 0.05, 0.005
"""Steps over pi [rad/s] of the way up, and the width of the bracket that is left."""

STARTS = ("soft", "hard")


@dataclass(frozen=True)
class Onset:
    """The last speed without and the first one with free flight.

    Speeds rise by `COARSE` until a settled turn has free flight; then the bracket is halved until it is `FINE` wide.
    Each speed begins anew from rest: "soft" with the cranks brought to speed within two turns, "hard" at full speed
    with the journal in the middle.  So two motions beside one another would show as two thresholds.

    Parameters
    ----------
    case : a case with play; its speed is where the way up begins.
    highest : where it ends, over pi [rad/s].
    settle, keep : turns at full speed before those that count, and turns that count.
    start : "soft" or "hard".

    Raises
    ------
    InputError : an unknown start.
    """

    case: Case
    highest: float
    settle: int
    keep: int
    start: str = "soft"

    def __post_init__(self) -> None:
        checks.one_of("Onset", "start", self.start, STARTS)

    @property
    def name(self) -> str:
        """Stem of the file of results."""
        return f"onset-{self.start}-{self.case.name}"

    @property
    def work(self) -> float:
        """About how much processor time it takes [s]."""
        return 0.3 * WORK[self.case.model] * (self.settle + self.keep) * 12

    def fingerprint(self) -> str:
        """A text that changes with everything the result depends on."""
        numbers = (self.highest, self.settle, self.keep, self.start, COARSE, FINE, SOFT, installed_version())
        return digest(("onset", self.case.mechanism(), *numbers, repr(self.case.steps())))

    def compute(self) -> xr.Dataset:
        """Look for it.

        Returns
        -------
        xarray.Dataset : over "trial", by rising speed: `speed` over pi [rad/s], `flight`, the largest share of free
            flight in any of the turns that count, `landings`, most in a turn, and `least_force`, the smallest normal
            force of these turns [N].

        Raises
        ------
        StudyError : a run that did not end well; contact that breaks at the first speed, or at none.
        """
        import xarray

        speed, tried = self.case.speed, [self._try(self.case.speed)]
        if tried[0][1] > 0.0:
            raise StudyError(f"{self.name}: contact breaks at the first speed already. Begin at a lower one.")
        while tried[-1][1] == 0.0:
            speed = round(speed + COARSE, 6)
            if speed > self.highest:
                raise StudyError(f"{self.name}: contact is unbroken up to {self.highest:g} pi rad/s. Go higher.")
            tried.append(self._try(speed))
        low, high = tried[-2][0], tried[-1][0]
        while high - low > FINE * (1.0 + 1e-9):
            tried.append(self._try(0.5 * (low + high)))
            low, high = (tried[-1][0], high) if tried[-1][1] == 0.0 else (low, tried[-1][0])
        table = np.array(sorted(tried))
        names = (("speed", "pi rad/s"), ("flight", ""), ("landings", ""), ("least_force", "N"))
        columns = {name: ("trial", table[:, k], {"units": unit}) for k, (name, unit) in enumerate(names)}
        about = {"case": self.case.name, "last_unbroken": low, "first_broken": high}
        return xarray.Dataset(columns, attrs=about)

    def _try(self, speed: float) -> tuple[float, float, float, float]:
        """Speed, largest share of free flight, most landings in a turn, least normal force [N]."""
        case = dataclasses.replace(self.case, speed=speed, ramp=SOFT if self.start == "soft" else 0.0)
        before, mechanism = self.settle + case.ramp, case.mechanism()
        common = {"step": case.steps(), "method": METHOD}
        sol = simulate(mechanism, t_end=before * case.period, save=2, **common)
        worst, landings, least = 0.0, 0, np.inf
        for k in range(1, self.keep + 1):
            if sol.ok:
                sol = simulate(mechanism, t_end=(before + k) * case.period, save="steps", restart=sol.restart, **common)
            if not sol.ok:
                raise StudyError(f"{self.name}: the run at {speed:g} pi rad/s did not end: {sol.status}")
            # a run that goes on may save nothing at its begin
            depth, steps = sol.array("P1.penetration"), np.diff(sol.time, prepend=(before + k - 1) * case.period)
            worst = max(worst, float(steps[depth < 0.0].sum()) / case.period)
            landings = max(landings, int(np.count_nonzero((depth[1:] > 0.0) & (depth[:-1] <= 0.0))))
            least = min(least, float(sol.array("P1.normal_force").min()))
            if worst > 0.0:
                break  # what the other turns do cannot mend it
        return speed, worst, float(landings), least
