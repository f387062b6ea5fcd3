"""A bifurcation diagram of the study: the section once a turn at each speed or at each clearance."""

from __future__ import annotations

import math
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from flexmb import checks
from flexmb.paper.case import LONGEST_STEP, Case
from flexmb.paper.effort import Effort
from flexmb.paper.motion import StudyError
from flexmb.run.run import installed_version
from flexmb.step.step_size import Adaptive
from flexmb.sweeps.bifurcation import bifurcation
from flexmb.sweeps.engine import PENDING
from flexmb.sweeps.fingerprint import digest

if TYPE_CHECKING:
    import xarray as xr

    from flexmb.model.mechanism import Mechanism

VALUES = {
    "speed": tuple(math.pi * n / 40 for n in (*range(20, 60, 2), *range(60, 81), *range(82, 101, 2))),
    "clearance": tuple(n * 1e-5 for n in range(1, 51)),
}
"""Speeds [rad/s], closer to each other about the paper's threshold of 1.6 pi; clearances [m]."""

FIXED = {"speed": {"clearance": 0.5e-3}, "clearance": {"speed": 2.0 * math.pi}}
"""What stays: 0.5 mm of play [m], or 2 pi rad/s."""

WORK = {False: 0.07, True: 0.75}
"""About the processor time of a turn of the rigid and of the flexible mechanism, the mean over a diagram [s]."""

TANGENT = 1.6
"""How many times as long a turn takes whose tangent is carried."""


COARSE = 1e-3
"""`rtol` of diagrams with exponents and beams: their runs are long, and take half the time that default steps would.

Their exponents do not depend on it: 50.5 +- 1.0 1/s at 0.05 mm with 1e-4, 50.5 +- 1.5 with 1e-5, 51.1 +- 1.7 in the
diagram.  Without beams they do where the play is small, 28.8 +- 0.7 against 12.9 +- 0.5 1/s, and no time is gained."""


@dataclass(frozen=True)
class Diagram:
    """The points of the section at each value of a parameter.

    Parameters
    ----------
    parameter : "speed" (at 0.5 mm of play) or "clearance" (at 2 pi rad/s).
    flexible : whether the links are beams.
    skip, keep : turns before the first point, and points, at each value.
    exponent : whether the largest exponent is found: True, over as many turns more; "points", over those of the points.
    values : about how many values there are; None: all of `VALUES`.
    rtol : accepted error of a step in velocities, relative; None: the default.
    """

    parameter: str
    flexible: bool
    skip: int = 20
    keep: int = 50
    exponent: bool | str = True
    values: int | None = None
    rtol: float | None = None

    def __post_init__(self) -> None:
        checks.one_of("Diagram", "parameter", self.parameter, VALUES)

    @classmethod
    def at(cls, parameter: str, effort: Effort, *, flexible: bool) -> Diagram:
        """The diagram over `parameter` at an effort, `flexible` or rigid."""
        lengths = (effort.diagram_settle, effort.diagram_points)
        exponent = "points" if effort.exponents else False
        rtol = COARSE if effort.exponents and flexible else None
        return cls(parameter, flexible, *lengths, exponent, effort.values, rtol)

    @property
    def name(self) -> str:
        """Stem of the file of results, and of the store."""
        return f"diagram-{self.parameter}-{'flexible' if self.flexible else 'rigid'}"

    @property
    def chosen(self) -> list[float]:
        """The values of the parameter, from the first to the last."""
        found = VALUES[self.parameter]
        if self.values is None or self.values >= len(found):
            return list(found)
        return [found[k] for k in np.linspace(0, len(found) - 1, max(self.values, 2)).round().astype(int)]

    @property
    def work(self) -> float:
        """About how much processor time it takes [s]."""
        each = {False: 1.0, True: 1.0 + TANGENT, "points": TANGENT}[self.exponent]
        steps = 1.0 if self.rtol is None else (self.rtol / 1e-4) ** (-1.0 / 3.0)
        return WORK[self.flexible] * steps * (self.skip + self.keep * each) * len(self.chosen)

    def fingerprint(self) -> str:
        """A text that changes with everything the result depends on."""
        fixed, values = self._fixed(), self.chosen
        models = [softly_started(**fixed, **{self.parameter: value}) for value in (values[0], values[-1])]
        lengths = (self.skip, self.keep, self.exponent, repr(self._step()))
        settings = (self.parameter, values, fixed, *lengths, installed_version())
        return digest(("diagram", softly_started, *models, *settings))

    def compute(self) -> xr.Dataset:
        """The diagram, in one process and kept nowhere; see `spread`."""
        return self.spread(None, None)

    def spread(self, executor: Executor | None, store: Path | None, pending: int = PENDING) -> xr.Dataset:
        """Compute it, point by point.

        Parameters
        ----------
        executor : where points are computed; None: in this process.
        store : folder in which finished points are kept, and found again.
        pending : most points that are with the executor at the same time.

        Returns
        -------
        xarray.Dataset : as `bifurcation` returns it.  Points that failed have a status that says so.

        Raises
        ------
        StudyError : no point went well.
        InputError : a store of another diagram.
        """
        found = bifurcation(
            softly_started,
            self.parameter,
            self.chosen,
            fixed=self._fixed(),
            skip=self.skip,
            keep=self.keep,
            exponent=self.exponent,
            period=turn_of if self.parameter == "speed" else turn_of(FIXED["clearance"]["speed"]),
            step=self._step(),
            executor=executor,
            pending=pending,
            store=store,
            resume=store is not None,
        )
        if not found["ok"].any():
            raise StudyError(f"{self.name}: no point went well; the first: {found['status'].values[0]}")
        return found

    def _step(self) -> Adaptive:
        return Adaptive(max=LONGEST_STEP) if self.rtol is None else Adaptive(rtol=self.rtol, max=LONGEST_STEP)

    def _fixed(self) -> dict[str, float | bool]:
        return {**FIXED[self.parameter], "flexible": self.flexible}


def softly_started(speed: float, clearance: float, *, flexible: bool) -> Mechanism:
    """The mechanism, its cranks brought to their speed within two turns.

    Parameters
    ----------
    speed : of the cranks [rad/s].
    clearance : at P1 [m].
    flexible : whether the links are beams.
    """
    model = "flexible" if flexible else "rigid"
    return Case(model=model, speed=speed / math.pi, clearance=clearance).mechanism()


def turn_of(speed: float) -> float:
    """The time of a turn [s]; drives with a ramp have no period of their own.

    Parameters
    ----------
    speed : of the cranks [rad/s].
    """
    return 2.0 * math.pi / speed
