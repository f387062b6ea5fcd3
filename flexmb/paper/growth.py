"""The exponent of a case, and where it is once a period."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from flexmb.dynamics.exponents.lyapunov import lyapunov
from flexmb.dynamics.systems.mechanism_flow import MechanismFlow
from flexmb.paper.case import Case
from flexmb.paper.motion import StudyError
from flexmb.run.run import installed_version
from flexmb.sweeps.fingerprint import digest

if TYPE_CHECKING:
    import xarray as xr

SIGNALS = ("P1.ex", "P1.ey", "slider.x")
WORK = {"rigid": (0.07, 0.25), "flexible": (0.8, 1.7)}
"""About the processor time of a period with impacts [s], without and with a tangent vector."""


@dataclass(frozen=True)
class Growth:
    """How fast neighbours of a case part: section points and the largest exponent.

    Parameters
    ----------
    case : the case, with play.
    settle : periods before the first point.
    points : points, one a period, over which the exponent is taken.
    rtol : accepted error of a step in velocities, relative; None: the default.
    """

    case: Case
    settle: int
    points: int
    rtol: float | None = None

    @property
    def name(self) -> str:
        """Stem of the file of results."""
        step = "" if self.rtol is None else f"-rtol{self.rtol:g}"
        return f"{self.case.name}-growth{self.settle}+{self.points}{step}"

    @property
    def work(self) -> float:
        """About how much processor time it takes [s]."""
        plain, tangent = WORK[self.case.model]
        return (plain * self.settle + tangent * self.points) * (self.case.elements / 4.0) ** 1.5

    def fingerprint(self) -> str:
        """A text that changes with everything the result depends on."""
        numbers = (self.settle, self.points, repr(self.case.steps(self.rtol)), installed_version())
        return digest(("growth", self.case.mechanism(), *numbers))

    def compute(self) -> xr.Dataset:
        """Follow the motion and a tangent vector.

        Returns
        -------
        xarray.Dataset : over "point": `section.SIGNAL` [m]; `exponent` and `exponent_error` [1/s].  Attributes: `case`,
            `period` [s], `verdict` and `reason` of the system, `verdict.SIGNAL` through each signal.

        Raises
        ------
        StudyError : a run that did not end well.
        """
        import xarray

        step = self.case.steps(self.rtol)
        flow = MechanismFlow(self.case.mechanism(), step=step, period=self.case.period)
        found = lyapunov(flow, skip=self.settle, periods=self.points, confirm=False)
        if not found.ok:
            raise StudyError(f"{self.name}: the run with tangents did not end: {found.status}")
        columns = {
            f"section.{name}": ("point", found.points[:, found.names.index(name)], {"units": "m"}) for name in SIGNALS
        }
        columns["exponent"] = ((), found.value, {"units": "1/s"})
        columns["exponent_error"] = ((), found.error, {"units": "1/s"})
        about = {"case": self.case.name, "period": self.case.period, "verdict": str(found.verdict)}
        about["reason"] = found.verdict.reason if found.verdict else ""
        about |= {f"verdict.{name}": str(found.seen_through(name)) for name in SIGNALS}
        return xarray.Dataset(columns, attrs=about)
