"""A point of one body on a closed curve of another: knife edge, pin in a groove."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from typing import TYPE_CHECKING

from flexmb import checks
from flexmb.cams.curve_on_curve import check_distance, check_pair
from flexmb.cams.curves.closed_curve import ClosedCurve
from flexmb.cams.curves.line import CircularCurve
from flexmb.cams.packing import TOLERANCE_LENGTH, carrier, carriers, curve_numbers, in_frame, shape
from flexmb.cams.pair_kernels import ROLLER, TOUCHING
from flexmb.errors import InputError
from flexmb.model.contributions import Contribution
from flexmb.model.law import FrictionLaw, NormalLaw
from flexmb.model.part import Part
from flexmb.model.shape import Shapes

if TYPE_CHECKING:
    from flexmb.model.mechanism import Mechanism


POINT = 1e-9
"""Radius that stands for a point in checks of distances, over the size of the curve."""


@dataclass(frozen=True)
class PointOnCurve(Part):
    """A point of the second body that stays on a closed curve of the first: knife edge, pin in a groove.

    Signals, ideal: force (along the outward normal of the curve on the second body) [N], normal_speed (velocity
    of the point along it) [m/s], power (of the force, given to the second body) [W]; with `friction` also
    friction_force [N].  With `normal`: as of a contact (see `RevoluteClearance`).

    Parameters
    ----------
    name : name of the pair.
    first : the body with the curve.
    curve : its curve, in the reference configuration.
    second : the body with the point.
    at : the point in the reference configuration [m].
    normal : law of the normal force, for an edge that can lift off outwards; None: ideal, a pin in a groove.
    friction : law of friction; None: none.
    start : of a contact: "touching" or "open", see `CurveOnCurve`.

    Raises
    ------
    InputError : no closed curve, a law of the wrong kind.
    ModelError : a body with itself, a flexible body, a point far from the curve.

    Notes
    -----
    The groove has no clearance.  A pin with clearance in a straight slot is `PinSlotClearance`.
    """

    first: Part
    curve: ClosedCurve
    second: Part
    at: tuple[float, float]
    _: KW_ONLY
    normal: NormalLaw | None = None
    friction: FrictionLaw | None = None
    start: str = TOUCHING

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "at", checks.point(self.label, "at", self.at))
        check_pair(self)
        if not isinstance(self.curve, ClosedCurve):
            raise InputError(f"{self.label}: curve is {self.curve!r}; it must be a ClosedCurve.")

    @property
    def pin_radius(self) -> float:
        """Least radius of curvature of the curve [m], beside which penetrations are judged."""
        return 1.0 / self.curve.extreme_curvature()[1]

    def contact_law(self) -> NormalLaw | None:
        """Normal law; it needs a stiffness, since an edge has no radius."""
        return self.normal

    def validate(self, mechanism: Mechanism) -> None:
        """Refuse a point far from the curve."""
        super().validate(mechanism)
        check_distance(self, self.curve, CircularCurve(self.at, POINT * self.curve.size))

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        """One constraint equation or one contact."""
        nodes, coordinates = carriers(mechanism, self)
        p = (
            TOLERANCE_LENGTH * self.curve.size,
            *in_frame(nodes[1], self.at),
            0.0,
            *curve_numbers(self.curve, nodes[0]),
        )
        return ROLLER.contributions(self, coordinates, p)

    def shapes(self, mechanism: Mechanism) -> Shapes:
        """The curve."""
        return [shape(self.first.name, carrier(mechanism, self.first.name, self.label), self.curve.drawing())]
