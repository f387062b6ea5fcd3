"""Largest absolute values of signals over all accepted steps."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from flexmb.display.text import number_text


class Peak(NamedTuple):
    """The largest absolute value of a signal over all accepted steps.

    Parameters
    ----------
    value : the largest absolute value, in the unit of the signal.
    time : when it was reached [s].
    """

    value: float
    time: float

    def __repr__(self) -> str:
        return f"Peak(value={number_text(self.value)}, time={number_text(self.time)})"

    @property
    def node(self) -> int | None:
        """Number of the node where a stress was largest, of a mesh that in the mesh; None of other signals."""
        return None

    @property
    def place(self) -> tuple[float, float] | None:
        """Place of this node in the reference configuration [m]; None of other signals."""
        return None


class PeakOfStress(Peak):
    """The peak of a stress, with its place.

    Parameters
    ----------
    peak : value and time.
    node : number of the node.
    place : its place in the reference configuration [m]; None of beams and reduced bodies of a file.
    """

    def __new__(cls, peak: Peak, node: int, place: tuple[float, float] | None) -> PeakOfStress:
        """The peak with its place."""
        own = super().__new__(cls, *peak)
        own.__dict__["at"] = (node, place)
        return own

    @property
    def node(self) -> int:
        """Number of the node where the stress was largest."""
        return int(self.__dict__["at"][0])

    @property
    def place(self) -> tuple[float, float] | None:
        """Place of this node in the reference configuration [m]; None of beams and reduced bodies of a file."""
        found: tuple[float, float] | None = self.__dict__["at"][1]
        return found


class Peaks(NamedTuple):
    """Largest absolute values of all signals over all accepted steps.

    Parameters
    ----------
    values : (n_s,) largest absolute values, each in the unit of its signal.
    times : (n_s,) when they were reached [s].
    """

    values: np.ndarray
    times: np.ndarray
