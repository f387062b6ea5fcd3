"""Belt or chain over two wheels, open or crossed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from typing import TYPE_CHECKING

from flexmb import checks
from flexmb.couplings.wheels import Wheels
from flexmb.errors import InputError
from flexmb.model.contributions import Contribution
from flexmb.model.shape import BeltShape, Shapes

if TYPE_CHECKING:
    from flexmb.model.mechanism import Mechanism


@dataclass(frozen=True)
class Belt(Wheels):
    """Ideal belt over two wheels: no mass, no stretch, no slip; chains and timing belts are the same.

    An open belt turns both wheels the same way, r1 omega1 = r2 omega2, a crossed one against each other; angles count
    from the arm.

    Signals: force (difference of the tensions of both strands) [N]; first_torque, second_torque (on the wheels) [N m];
    power (of second_torque) [W].

    Parameters
    ----------
    name : name of the belt.
    first, second : the wheels, which need joints of their own.
    radii : radii of the belt's middle line on both wheels [m], > 0.
    crossed : whether the strands cross.
    arm : body that carries the axes; `GROUND` for fixed axes.

    Raises
    ------
    InputError : radii that are not > 0.
    ModelError : a belt over one wheel.

    Notes
    -----
    The tension that presses the belt onto its wheels does not enter: without slip only the difference of the strands
    does work.  A belt does not slip while the ratio of its tensions stays below exp(mu phi) (Euler, Eytelwein), with
    friction mu and angle of wrap phi.
    """

    _: KW_ONLY
    radii: tuple[float, float]
    crossed: bool = False

    def __post_init__(self) -> None:
        super().__post_init__()
        given = checks.sequence(self.label, "radii", self.radii, "two numbers")
        if len(given) != 2:
            raise InputError(f"{self.label}: radii is {self.radii!r}; give two numbers, e.g. (0.05, 0.1).")
        radii = tuple(checks.positive(self.label, f"radii[{k}]", r, "m") for k, r in enumerate(given))
        object.__setattr__(self, "radii", radii)

    def shapes(self, mechanism: Mechanism) -> Shapes:
        """The belt, and circles of its middle line on both wheels."""
        first, second = (mechanism.body(wheel.name, self.label) for wheel in (self.first, self.second))
        centres = (first.name, first.main, (0.0, 0.0)), (second.name, second.main, (0.0, 0.0))
        return (*self.circles(mechanism, self.radii), BeltShape(self.name, *centres, self.radii, self.crossed))

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        """One constraint equation between two or three angles."""
        r1, r2 = self.radii
        return [self.rolling(mechanism, r1, r2 if self.crossed else -r2)]
