"""What sections ask of a flow beside its state: steps of its own that can be taken back, and rates of its signals."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any

import numpy as np

from flexmb import checks
from flexmb.dynamics.systems.dynamics import Dynamics


class ContinuousFlow(Dynamics):
    """A system in continuous time that goes on in steps of its own.

    Attributes
    ----------
    period : time after which what drives it repeats [s], or None.
    driven : whether its rates depend on time; then the time belongs to a point of a section.
    """

    unit = "s"
    period: float | None
    driven: bool

    @property
    @abstractmethod
    def pace(self) -> float:
        """A time of the size of its steps [s]."""

    @property
    def shortest(self) -> float:
        """Time below which it cannot be trusted to go on [s]; 0: as short as its clock can tell."""
        return 0.0

    @abstractmethod
    def take_step(self, limit: float, tangents: np.ndarray | None = None) -> bool:
        """Go on by one step of its own choice, not beyond the time `limit` [s]; whether it could.

        Parameters
        ----------
        limit : later than the present time.  A limit that is some steps away has no influence on the step.
        tangents : (size, k) small differences of states; they are carried along, in place.
        """

    @abstractmethod
    def snapshot(self) -> Any:
        """All that the way on depends on, for `restore`."""

    @abstractmethod
    def restore(self, snapshot: Any) -> None:
        """Stand where `snapshot` was taken, and go on from there as if nothing had been since."""

    @abstractmethod
    def rate(self, signal: int) -> float:
        """Rate of a signal (its number in `names`) along the motion [units/s]."""

    @abstractmethod
    def slopes(self, signal: int, tangents: np.ndarray) -> np.ndarray:
        """What small differences `tangents` (size, k) of the present state do to a signal: (k,)."""

    def number_of(self, owner: str, signal: str) -> int:
        """Place of a signal in `names`, or `InputError`; `owner` is who asks.

        Parameters
        ----------
        owner : for the message.
        signal : its name.
        """
        return self.names.index(checks.one_of(owner, "signal", signal, self.names))

    def has_cheap_rate(self, signal: int) -> bool:  # noqa: ARG002 - most flows know the rates of all signals
        """Whether `rate` of a signal takes less than a step; then each step is searched for a touch of a level."""
        return True

    def no_period(self) -> str:
        """Why it has no period, in a sentence without its end."""
        return f"{self.name!r} has no period"
