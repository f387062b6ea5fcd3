"""Equal rotation of two bodies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from flexmb.couplings.linear import angle_of, angles_contribution
from flexmb.errors import ModelError
from flexmb.model.contributions import Contribution, Reaction
from flexmb.model.part import GROUND, Part

if TYPE_CHECKING:
    from flexmb.model.mechanism import Mechanism


@dataclass(frozen=True)
class SameRotation(Part):
    """Two bodies that keep their relative angle, as a parallel guide or a coupling of shafts does; they may be apart.

    Signals: torque (on the second body) [N m].

    Parameters
    ----------
    name : name of the coupling.
    first, second : the bodies; `GROUND` for a body that must not turn.

    Raises
    ------
    ModelError : a body with itself.
    """

    first: Part
    second: Part

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.first.name == self.second.name:
            raise ModelError(f"{self.label} couples {self.first.name!r} with itself; give two different bodies.")

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        """One constraint equation between two angles."""
        factors, angles = {}, {}
        for part, factor in ((self.first, -1.0), (self.second, 1.0)):
            coordinate, angle = angle_of(mechanism, part.name, self.label)
            if part.name != GROUND.name:
                factors[coordinate], angles[coordinate] = factor, angle
        return [angles_contribution(self.name, factors, angles, (Reaction("torque", "N m", 0, 1.0),))]
