"""A run of a study: one measurement of one case, whose result is kept."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from flexmb.errors import FlexmbError
from flexmb.sweeps.fingerprint import digest
from flexmb.version import installed_version

if TYPE_CHECKING:
    import xarray as xr

    from flexmb.study.case import Case


class StudyError(FlexmbError):
    """A run of a study that did not reach its end."""


@dataclass(frozen=True)
class StudyRun:
    """One measurement of one case.

    Parameters
    ----------
    name : stem of the file of the result; different runs have different names.
    measure : function at the top of a module; called with the case and the settings, it returns the dataset.
    case : the case; None: the measurement needs none.
    settings : names and values.
    work : about the processor time [s].
    parts : values of a diagram, which are computed apart; 1 of other runs.
    """

    name: str
    measure: Callable[..., xr.Dataset]
    case: Case | None
    settings: tuple[tuple[str, Any], ...] = ()
    work: float = 1.0
    parts: int = 1

    def __getitem__(self, setting: str) -> Any:
        return dict(self.settings)[setting]

    def fingerprint(self) -> str:
        """A short text that changes with everything that the result depends on."""
        case = () if self.case is None else self._of_case(self.case)
        return digest((self.measure.__name__, *case, dict(self.settings), installed_version()))

    def compute(self, **where: Any) -> xr.Dataset:
        """The whole result, in one process; a failure is an exception.

        Parameters
        ----------
        **where : executor, store and pending, for a run of several parts.
        """
        return self.measure(self.case, **dict(self.settings), **where)

    @staticmethod
    def _of_case(case: Case) -> tuple[Any, ...]:
        machine = case.machine
        solver = {name: repr(value) for name, value in case.solver.items()}
        return case.mechanism(), solver, case.period, machine.curves, machine.peaks, machine.places


Results = Mapping[StudyRun, "xr.Dataset"]
"""Results by their runs."""
