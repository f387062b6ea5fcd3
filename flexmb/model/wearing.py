"""What a part with worn surfaces answers to studies of wear and to pictures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Protocol

import numpy as np

if TYPE_CHECKING:
    from flexmb.model.part import Part


@dataclass(frozen=True)
class Worn:
    """Wear of a joint in a run, see `worn_in` of the joint.

    Parameters
    ----------
    depths : depth that the surfaces lost (n,), in the order of `depths` of the joint [m].
    volume : material that they lost [m^3].
    time : length of the run [s].
    work : work of the friction of the joint [J].

    Notes
    -----
    This work is a part of `energy.dissipated_friction`, the same integral by the trapezoidal rule over the steps.  The
    material that is lost takes neither energy nor mass out of the balance.
    """

    depths: np.ndarray
    volume: float
    time: float
    work: float


class Wearing(Protocol):
    """A part whose surfaces wear.

    A profile is the depth of one surface at a number of places; `depths` holds those of all surfaces that wear, one
    behind the other.
    """

    PLACES: ClassVar[str]
    """Name of the coordinate of the profiles: "angle" round a bearing, "place" along a guide."""

    PLACE_UNIT: ClassVar[str]
    """Its unit."""

    FACES: ClassVar[tuple[str, ...]]
    """Names of all its surfaces."""

    @property
    def name(self) -> str:
        """Name of the part."""

    @property
    def clearance(self) -> float:
        """Clearance of the unworn joint [m]."""

    @property
    def wearing_faces(self) -> tuple[str, ...]:
        """Those surfaces that wear."""

    @property
    def bins(self) -> int:
        """Number of places of a profile."""

    @property
    def places(self) -> np.ndarray:
        """Coordinate of the profiles (bins,)."""

    @property
    def wear_signals(self) -> tuple[str, ...]:
        """Names of the signals that `worn_in` reads, without that of the part."""

    @property
    def depths(self) -> np.ndarray:
        """Depths (surfaces that wear * bins,) [m]."""

    @property
    def volume(self) -> float:
        """Material that is lost [m^3]."""

    @property
    def half_play(self) -> float:
        """Half of the widest way across [m]; the clearance where nothing is worn."""

    @property
    def sizes(self) -> dict[str, float]:
        """Lengths that pictures show the profiles beside, by name [m]."""

    def with_depths(self, depths: Sequence[float] | np.ndarray) -> Part:
        """The part with other depths."""

    def worn_in(self, sol: Any) -> Worn:
        """Wear in a run that saved all steps."""

    def smoothed(self, depths: np.ndarray) -> np.ndarray:
        """Depths without ridges between neighbours; their sum stays."""
