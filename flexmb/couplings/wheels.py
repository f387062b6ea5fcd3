"""Two wheels that turn one another: base of gears and belts."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexmb.couplings.linear import angle_of, angles_contribution
from flexmb.errors import ModelError
from flexmb.model.contributions import ConstraintContribution, Coordinate, Reaction
from flexmb.model.part import GROUND, Part
from flexmb.model.shape import CircleShape, Shapes

if TYPE_CHECKING:
    from flexmb.model.mechanism import Mechanism
    from flexmb.model.watched_motion import WatchedMotion


@dataclass(frozen=True)
class Wheels(Part):
    """Base of pairs of wheels that turn one another.

    Parameters
    ----------
    name : name of the pair.
    first, second : the wheels.
    arm : body that carries the axes; `GROUND` for fixed axes.

    Raises
    ------
    ModelError : a wheel that turns itself.
    """

    first: Part
    second: Part
    _: KW_ONLY
    arm: Part = GROUND

    def __post_init__(self) -> None:
        super().__post_init__()
        names = (self.first.name, self.second.name)
        if names[0] == names[1] or (self.arm.name != GROUND.name and self.arm.name in names):
            raise ModelError(f"{self.label} couples a body with itself; give different bodies as wheels and arm.")

    def _distances(self, mechanism: Mechanism, motion: WatchedMotion) -> np.ndarray:
        """Distances (n,) of both wheels at the poses of a motion [m]; empty where one is the ground."""
        bodies = [mechanism.body(wheel.name, self.label) for wheel in (self.first, self.second)]
        if GROUND.name in [body.name for body in bodies]:
            return np.zeros(0)
        stems = [f"{body.name}.{body.main}" if body.main else body.name for body in bodies]
        x1, y1, x2, y2 = motion.rows(*(f"{stem}.{axis}" for stem in stems for axis in "xy")).T
        return np.asarray(np.hypot(x2 - x1, y2 - y1))

    def circles(self, mechanism: Mechanism, radii: tuple[float, float]) -> Shapes:
        """Pitch circles about the main nodes of the wheels that move.

        Parameters
        ----------
        mechanism : the mechanism.
        radii : pitch radii of both wheels [m].
        """
        found = []
        for wheel, radius in zip((self.first, self.second), radii, strict=True):
            body = mechanism.body(wheel.name, self.label)
            if body.name != GROUND.name:
                found.append(CircleShape(self.name, (body.name, body.main, (0.0, 0.0)), radius))
        return tuple(found)

    def rolling(self, mechanism: Mechanism, first_radius: float, second_radius: float) -> ConstraintContribution:
        """Equation r1 (theta1 - theta_arm) + r2 (theta2 - theta_arm) = constant.

        Parameters
        ----------
        mechanism : the mechanism.
        first_radius, second_radius : radii of the wheels [m]; negative for a wheel that turns with the first one.
        """
        factors: dict[Coordinate, float] = {}
        angles: dict[Coordinate, float] = {}
        radii = first_radius, second_radius, -first_radius - second_radius
        for part, radius in zip((self.first, self.second, self.arm), radii, strict=True):
            coordinate, angle = angle_of(mechanism, part.name, self.label)
            if part.name != GROUND.name:  # the angle of the ground is 0
                factors[coordinate], angles[coordinate] = radius, angle
        second = angle_of(mechanism, self.second.name, self.label)[0]
        moves = second in factors
        reactions = (
            Reaction("force", "N", 0, 1.0),
            Reaction("first_torque", "N m", 0, first_radius),
            Reaction("second_torque", "N m", 0, second_radius),
            Reaction("power", "W", 0, second_radius if moves else 0.0, list(factors).index(second) if moves else -1),
        )
        return angles_contribution(self.name, factors, angles, reactions)
