"""Gear pair: two toothed wheels, external or internal, on fixed axes or on an arm."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from typing import TYPE_CHECKING

from flexmb import checks, planar
from flexmb.couplings.wheels import Wheels
from flexmb.errors import InputError, ModelError
from flexmb.model.contributions import Contribution
from flexmb.model.part import GROUND
from flexmb.model.shape import Shapes

if TYPE_CHECKING:
    from flexmb.model.mechanism import Mechanism

FITS = 1e-3
"""Difference of the distance of the axes from the sum of the pitch radii, relative to it, that still fits."""


@dataclass(frozen=True)
class Gear(Wheels):
    """Ideal gear pair of two wheels, without backlash; the wheels need joints of their own.

    The pitch circles roll on one another: r1 (theta1 - theta_arm) + r2 (theta2 - theta_arm) is constant, with - r2 for
    an internal pair.

    Signals: force (tangential, at the pitch point) [N]; first_torque, second_torque (on the wheels) [N m]; power (of
    second_torque) [W].

    Parameters
    ----------
    name : name of the pair.
    first, second : the wheels; `GROUND` for a ring that stands still.
    teeth : numbers of teeth of both wheels, > 0.
    internal : whether the wheel with more teeth is a ring with inner teeth.
    arm : body that carries the axes; `GROUND` for fixed axes.
    distance : distance of the axes [m], > 0; None: of the centres of mass in the reference configuration.
    module : module of the teeth, pitch diameter over number of teeth [m]; None: as the distance has it.

    Raises
    ------
    InputError : numbers of teeth that are not whole or not > 0; an internal pair of equal wheels.
    ModelError : a wheel that meshes with itself; a distance of the axes that is 0, or does not fit the module.

    Notes
    -----
    The ratio depends on the teeth alone; the distance sets the force at the pitch point, which is the multiplier.
    Radial forces of the pressure angle are not counted: they load the bearings and do no work.
    """

    _: KW_ONLY
    teeth: tuple[int, int]
    internal: bool = False
    distance: float | None = None
    module: float | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        given = checks.sequence(self.label, "teeth", self.teeth, "two whole numbers")
        if len(given) != 2:
            raise InputError(f"{self.label}: teeth is {self.teeth!r}; give two whole numbers, e.g. (20, 40).")
        object.__setattr__(
            self, "teeth", tuple(checks.count(self.label, f"teeth[{k}]", z) for k, z in enumerate(given))
        )
        for name in ("distance", "module"):
            if getattr(self, name) is not None:
                checks.positive(self.label, name, getattr(self, name), "m")
        if self.internal and self.teeth[0] == self.teeth[1]:
            raise InputError(f"{self.label}: both wheels have {self.teeth[0]} teeth; a ring needs more than its wheel.")

    def radii(self, mechanism: Mechanism) -> tuple[float, float]:
        """Pitch radii of both wheels [m].

        Parameters
        ----------
        mechanism : the mechanism.

        Raises
        ------
        ModelError : a distance of the axes that is 0, unknown, or does not fit the module.
        """
        (z1, z2), distance = self.teeth, self._distance(mechanism)
        sum_of_teeth = abs(z2 - z1) if self.internal else z1 + z2
        if self.module is not None and abs(0.5 * self.module * sum_of_teeth - distance) > FITS * distance:
            raise ModelError(
                f"{self.label}: the axes are {distance:g} m apart, but wheels of {z1} and {z2} teeth with module "
                f"{self.module:g} m need {0.5 * self.module * sum_of_teeth:g} m. Move an axis, or change the wheels."
            )
        return distance * z1 / sum_of_teeth, distance * z2 / sum_of_teeth

    def _distance(self, mechanism: Mechanism) -> float:
        if self.distance is not None:
            return self.distance
        if GROUND.name in (self.first.name, self.second.name):
            raise ModelError(f"{self.label}: one wheel is the ground, which has no centre. Give distance= of the axes.")
        bodies = [mechanism.body(wheel.name, self.label) for wheel in (self.first, self.second)]
        first, second = (body.node(body.main) for body in bodies)
        apart = planar.distance((first.x, first.y), (second.x, second.y))
        if apart == 0.0:
            raise ModelError(f"{self.label}: the centres of both wheels coincide. Give distance= of the axes.")
        return apart

    def shapes(self, mechanism: Mechanism) -> Shapes:
        """The pitch circles."""
        return self.circles(mechanism, self.radii(mechanism))

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        """One constraint equation between two or three angles."""
        r1, r2 = self.radii(mechanism)
        return [self.rolling(mechanism, r1, -r2 if self.internal else r2)]
