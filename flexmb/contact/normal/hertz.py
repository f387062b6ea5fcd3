"""Elastic normal law of Hertz."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Self

from flexmb.contact.normal.hysteresis import HysteresisLaw
from flexmb.contact.onset import ONSET
from flexmb.model.material import Material


@dataclass(frozen=True)
class Hertz(HysteresisLaw):
    """Elastic contact, N = K depth^n, without losses: the coefficient of restitution is 1.

    Parameters
    ----------
    stiffness : K [N/m^n], > 0; None with `materials`: Hertz, from the radii of the joint.
    exponent : n, > 0.
    materials : materials of bearing and journal, when `stiffness` is None.

    Raises
    ------
    InputError : values out of range; neither stiffness nor materials.

    Notes
    -----
    For contacts much smaller than the radii, and impacts slow enough to leave neither marks nor waves.
    Source: K. L. Johnson, Contact Mechanics, Cambridge University Press 1985, eq. (4.23), for n = 3/2.
    """

    restitution: float = field(default=1.0, init=False, repr=False)
    least_approach: float = field(default=0.0, init=False, repr=False)
    reference_speed: str = field(default=ONSET, init=False, repr=False)

    @classmethod
    def from_materials(cls, bearing: Material, journal: Material) -> Self:  # type: ignore[override]
        """The law with Hertz's stiffness for n = 3/2, from two materials and the radii of the joint.

        Parameters
        ----------
        bearing, journal : materials.
        """
        return cls(materials=(bearing, journal))

    @staticmethod
    def chi(restitution: float) -> float:
        """Damping factor 0 for any `restitution`."""
        return 0.0
