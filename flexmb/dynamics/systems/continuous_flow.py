"""Base class of flows, with the steps, snapshots and rates of signals on which sections rest."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any

import numpy as np

from flexmb import checks
from flexmb.dynamics.systems.dynamics import Dynamics


class ContinuousFlow(Dynamics):
    """A system in continuous time with step sizes chosen by its integrator.

    Attributes
    ----------
    period : period of the drives [s]; None: no period.
    driven : whether the rates depend on time; then a point of a section includes the time.
    """

    unit = "s"
    period: float | None
    driven: bool

    @property
    @abstractmethod
    def pace(self) -> float:
        """Typical size of a step [s]."""

    @property
    def shortest(self) -> float:
        """Shortest time [s] that `advance` covers reliably; 0: limited by round-off of the time alone."""
        return 0.0

    @abstractmethod
    def take_step(self, limit: float, tangents: np.ndarray | None = None) -> bool:
        """Advance by one step, not beyond the time `limit` [s].

        Parameters
        ----------
        limit : a time after the present time [s].  It changes a step only if it is near.
        tangents : tangent vectors (size, k), advanced in place.

        Returns
        -------
        bool : whether the step succeeded.
        """

    @abstractmethod
    def snapshot(self) -> Any:
        """Complete present state, step control included, for `restore`."""

    @abstractmethod
    def restore(self, snapshot: Any) -> None:
        """Return to the state of a `snapshot`; the motion then continues with the same bits."""

    @abstractmethod
    def rate(self, signal: int) -> float:
        """Rate [units/s] of the signal number `signal` in `names` along the motion."""

    @abstractmethod
    def slopes(self, signal: int, tangents: np.ndarray) -> np.ndarray:
        """Changes (k,) of a signal by small differences of the present state.

        Parameters
        ----------
        signal : number of the signal in `names`.
        tangents : differences (size, k) of the state.
        """

    def number_of(self, owner: str, signal: str) -> int:
        """Number of a signal in `names`.

        Parameters
        ----------
        owner : name of the caller, for messages.
        signal : name of the signal.

        Raises
        ------
        InputError : an unknown signal.
        """
        return self.names.index(checks.one_of(owner, "signal", signal, self.names))

    def has_cheap_rate(self, signal: int) -> bool:  # noqa: ARG002 - most flows know the rates of all signals
        """Whether the `rate` of a `signal` costs less than a step; then every step is searched for two crossings."""
        return True

    def no_period(self) -> str:
        """Reason why the flow has no period, as a sentence without its end."""
        return f"{self.name!r} has no period"
