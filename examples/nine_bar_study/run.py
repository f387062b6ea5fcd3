"""Run of a study: one measurement of one case with a saved result."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from flexmb.engine.compiled.digest import digest
from flexmb.errors import FlexmbError
from flexmb.version import installed_version

if TYPE_CHECKING:
    import xarray as xr
    from nine_bar_study.case import Case


FORMAT = 2
"""Version of the content of results: results of another version are computed anew."""


class StudyError(FlexmbError):
    """Failure of a run of a study."""


@dataclass(frozen=True)
class StudyRun:
    """Measurement of one case with its settings.

    Parameters
    ----------
    name : stem of the file of the result, different for different runs.
    measure : function of a module, of the case and the settings; the returned dataset is the result.
    case : measured `Case`; None: a measurement without a case.
    settings : names and values of the other arguments of `measure`.
    work : approximate processor time [s].
    parts : number of values of a diagram, one job each; 1 for other runs.
    """

    name: str
    measure: Callable[..., xr.Dataset]
    case: Any
    settings: tuple[tuple[str, Any], ...] = ()
    work: float = 1.0
    parts: int = 1

    def __getitem__(self, setting: str) -> Any:
        return dict(self.settings)[setting]

    def fingerprint(self) -> str:
        """Digest of measurement, case, settings and versions of flexmb and of the content."""
        case = () if self.case is None else self._of_case(self.case)
        return digest((FORMAT, self.measure.__name__, *case, dict(self.settings), installed_version()))

    def compute(self, **where: Any) -> xr.Dataset:
        """Compute the result."""
        return self.measure(self.case, **dict(self.settings), **where)

    @staticmethod
    def _of_case(case: Case) -> tuple[Any, ...]:
        machine = case.machine
        solver = {name: repr(value) for name, value in case.solver.items()}
        return case.mechanism(), solver, case.period, machine.curves, machine.peaks, machine.places


Results = Mapping[StudyRun, "xr.Dataset"]
"""Results by run."""
