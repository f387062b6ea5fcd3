"""One case moving: measures of every turn from all steps, and the last turns in full."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from flexmb.errors import FlexmbError
from flexmb.paper.case import Case
from flexmb.paper.staggered.method import Staggered
from flexmb.results.solution import Solution
from flexmb.run.run import installed_version
from flexmb.run.simulate import simulate
from flexmb.step.newmark.method import Newmark
from flexmb.step.step_size import FixedStep
from flexmb.sweeps.fingerprint import digest

if TYPE_CHECKING:
    import xarray as xr

CURVES = ("slider.x", "slider.vx", "slider.ax", "motor1.torque", "motor4.torque", "P1.force")
PLAY_CURVES = ("P1.normal_force", "P1.penetration", "P1.ex", "P1.ey", "P1.vex", "P1.vey")
PEAKS = ("slider.ax", "motor1.torque", "motor4.torque", "P1.force")
WORK = {"ideal": 0.01, "rigid": 0.2, "flexible": 1.0}
"""About the processor time of a turn with impacts [s]."""

STAGGERED_STEP = 7e-5
"""About the processor time of a step of the paper's own scheme [s]."""


class StudyError(FlexmbError):
    """A run of the study that did not reach its end."""


@dataclass(frozen=True)
class Motion:
    """So many turns of a case.

    Parameters
    ----------
    case : the case.
    skip, keep : turns before the first that counts, and turns that count.
    shown : of these the last ones whose signals are kept at every step.
    rtol : accepted error of a step in velocities, relative; None: the default.
    staggered : step [s] of the paper's own scheme in place of the coupled equations; None: these.
    """

    case: Case
    skip: int
    keep: int
    shown: int
    rtol: float | None = None
    staggered: float | None = None

    @property
    def name(self) -> str:
        """Stem of the file of results."""
        scheme = "" if self.staggered is None else f"-staggered{self.staggered:g}"
        return self.case.name + ("" if self.rtol is None else f"-rtol{self.rtol:g}") + scheme

    @property
    def work(self) -> float:
        """About how much processor time it takes [s]."""
        turn = WORK[self.case.model] if self.staggered is None else STAGGERED_STEP * self.case.period / self.staggered
        return turn * (self.skip + self.keep) * (self.case.elements / 4.0) ** 1.5

    def fingerprint(self) -> str:
        """A text that changes with everything the result depends on."""
        numbers = (self.skip, self.keep, self.shown, repr(self.case.steps(self.rtol)), installed_version())
        scheme = () if self.staggered is None else (repr(self._solver),)
        return digest(("motion", self.case.mechanism(), *numbers, *scheme))

    @property
    def _solver(self) -> dict[str, Any]:
        """Step and method."""
        if self.staggered is None:
            return {"step": self.case.steps(self.rtol), "method": METHOD}
        return {"step": FixedStep(self.staggered), "method": Staggered()}

    def compute(self) -> xr.Dataset:
        """Simulate, turn by turn.

        Returns
        -------
        xarray.Dataset : over "turn", for each turn that counts: the largest absolute values `peak.SIGNAL`; with play
            also the largest penetration [m], the share of free flight and the number of landings; mean step [s].  Over
            "time" (every accepted step of the shown turns): the signals.  With play over "episode": start, end [s] and
            peak force [N] of contacts in the shown turns.

        Raises
        ------
        StudyError : a run that did not end well.
        """
        import xarray

        state, turns, last = None, [], []
        mechanism, solver = self.case.mechanism(), self._solver
        for k in range(1, self.skip + self.keep + 1):
            sol = simulate(mechanism, t_end=k * self.case.period, save="steps", restart=state, **solver)
            if not sol.ok:
                raise StudyError(f"{self.name}: turn {k} did not end: {sol.status}")
            state = sol.restart
            if k > self.skip:
                turns.append(_measures(sol))
            if k > self.skip + self.keep - self.shown:
                last.append(sol)
        columns = {name: ("turn", [turn[name] for turn in turns]) for name in turns[0]}
        about = {"case": self.name, "period": self.case.period, "first_turn": self.skip + 1}
        return xarray.Dataset(columns | _curves(last) | _contacts(last), attrs=about)


METHOD = Newmark.generalised_alpha()


def _measures(sol: Solution) -> dict[str, float]:
    """Of one turn."""
    found = {f"peak.{name}": float(sol.peak(name).value) for name in PEAKS}
    if "P1.penetration" in sol:
        depth, steps = sol.array("P1.penetration"), np.diff(sol.time)
        found["penetration"] = max(float(depth.max()), 0.0)
        found["flight"] = float(steps[depth[1:] < 0.0].sum() / (sol.time[-1] - sol.time[0]))
        found["landings"] = float(np.count_nonzero((depth[1:] > 0.0) & (depth[:-1] <= 0.0)))
    found["step"] = float(np.diff(sol.time).mean())
    return found


def _curves(last: list[Solution]) -> dict[str, tuple[str, np.ndarray, dict[str, str]]]:
    """The signals of the shown turns, one after the other."""
    names = [name for name in CURVES + PLAY_CURVES if name in last[0]]  # a restarted run begins after its first step
    found = {
        name: ("time", np.concatenate([sol.array(name) for sol in last]), {"units": last[0].units(name)})
        for name in names
    }
    return {"time": ("time", np.concatenate([sol.time for sol in last]), {"units": "s"}), **found}


def _contacts(last: list[Solution]) -> dict[str, tuple[str, np.ndarray, dict[str, str]]]:
    """The contacts at P1 in the shown turns."""
    if "P1.penetration" not in last[0]:
        return {}
    episodes = [sol.episodes("P1") for sol in last]
    units = {"start": "s", "end": "s", "peak_force": "N", "impulse": "N s"}
    return {
        f"contact.{name}": ("episode", np.concatenate([getattr(found, name) for found in episodes]), {"units": unit})
        for name, unit in units.items()
    }
