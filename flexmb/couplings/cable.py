"""Cable: two points that cannot move further apart than its length."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from typing import TYPE_CHECKING

from flexmb import checks, planar
from flexmb.contact.friction.frictionless import Frictionless
from flexmb.errors import InputError, ModelError
from flexmb.joints.contact_point import difference_column, put_column, put_eccentricity, put_point
from flexmb.joints.stop import NO_CLEARANCE, check_own_stiffness
from flexmb.kernels import gap_kernel, signal_kernel
from flexmb.model.contributions import Attachment, ContactContribution, Contribution, SignalContribution
from flexmb.model.law import NormalLaw
from flexmb.model.part import Part
from flexmb.model.shape import CABLE, LineShape, Shapes

if TYPE_CHECKING:
    from flexmb.model.mechanism import Mechanism


@gap_kernel
def cable_gap_kernel(p, q, v, out):
    """Slack of a cable: gap = length - |d|, n = d/|d| from the first point to the second."""
    _, length, s1x, s1y, s2x, s2y = p
    c1, d1, c2, d2 = math.cos(q[2]), math.sin(q[2]), math.cos(q[5]), math.sin(q[5])
    ax, ay, bx, by = c1 * s1x - d1 * s1y, d1 * s1x + c1 * s1y, c2 * s2x - d2 * s2y, d2 * s2x + c2 * s2y
    dx, dy = q[3] + bx - q[0] - ax, q[4] + by - q[1] - ay
    size = math.sqrt(dx * dx + dy * dy)
    nx, ny, inverse = 1.0, 0.0, 0.0
    if size > 0.0:
        nx, ny, inverse = dx / size, dy / size, 1.0 / size
    put_point(out, q, v, length - size, nx, ny, q[0] + ax, q[1] + ay)
    vx, vy = v[3] - v[5] * by - v[0] + v[2] * ay, v[4] + v[5] * bx - v[1] - v[2] * ax
    put_eccentricity(out, dx, dy, vx, vy)
    for j in range(6):
        gx, gy, Xq, Yq = difference_column(j, ax, ay, bx, by)  # of d and of the first point
        turn = (nx * gy - ny * gx) * inverse
        put_column(out, j, -ny * turn, nx * turn, Xq, Yq)


@signal_kernel
def cable_distance(p, t, q, v, a):
    """Distance of both points."""
    s1x, s1y, s2x, s2y = p
    c1, d1, c2, d2 = math.cos(q[2]), math.sin(q[2]), math.cos(q[5]), math.sin(q[5])
    dx = q[3] + c2 * s2x - d2 * s2y - q[0] - c1 * s1x + d1 * s1y
    dy = q[4] + d2 * s2x + c2 * s2y - q[1] - d1 * s1x - c1 * s1y
    return math.sqrt(dx * dx + dy * dy)


@dataclass(frozen=True)
class Cable(Part):
    """Cable, rope or chain without mass between two points: slack it does nothing, taut it pulls.

    A contact whose gap is the slack, length - distance, and whose penetration is the elongation.

    Signals: distance of the points [m], and those of a contact (see `RevoluteClearance`): penetration (elongation) [m],
    normal_force (tension) [N], fx, fy, force (on the second body) [N], mode (0 slack, 1 jerk, 2 taut); ex, ey from the
    first point to the second [m].

    Parameters
    ----------
    name : name of the cable.
    first, second : the bodies; `GROUND` is the frame.
    at : point of the first body in the reference configuration [m].
    to : point of the second body in the reference configuration [m].
    free_length : length without tension [m], > 0; with less than the distance of the points it starts under tension;
        None: the distance, so that it is just taut.
    normal : tension over elongation; of a linear cable K = E A / free_length [N/m], `KelvinVoigt(K, damping)`.

    Raises
    ------
    InputError : a length that is not > 0, an object that is no normal law, a law whose stiffness depends on the radii
        of a joint.
    ModelError : a cable from a body to itself.

    Notes
    -----
    Static equilibrium, modes of prestressed structures and runs take the tension of the start into account.  The ledger
    counts energy that a contact holds as dissipated until it is given back, so `energy.dissipated_contact` falls below
    zero where tension of the start is released.  No mass and no bending stiffness: not for sag and not for waves in
    long cables.
    """

    formerly = (("length", "free_length"), ("start", "at"), ("end", "to"))
    first: Part
    second: Part
    at: tuple[float, float]
    to: tuple[float, float]
    _: KW_ONLY
    free_length: float | None = None
    normal: NormalLaw

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("at", "to"):
            object.__setattr__(self, name, checks.point(self.label, name, getattr(self, name)))
        check_own_stiffness(self.label, self.normal)
        if self.free_length is not None:
            checks.positive(self.label, "free_length", self.free_length, "m")
        elif planar.distance(self.at, self.to) == 0.0:
            raise InputError(
                f"{self.label}: both points are {self.at}, so the cable needs a length. Give free_length= in m."
            )
        if self.first.name == self.second.name:
            raise ModelError(f"{self.label} ties {self.first.name!r} to itself; give two different bodies.")

    @property
    def slack_length(self) -> float:
        """Length without tension [m]."""
        return planar.distance(self.at, self.to) if self.free_length is None else self.free_length

    def ends(self, mechanism: Mechanism) -> tuple[Attachment, Attachment]:
        """Both points of the cable on the bodies of `mechanism`."""
        first = mechanism.body(self.first.name, self.label).attach(self.label, self.at)
        return first, mechanism.body(self.second.name, self.label).attach(self.label, self.to)

    def shapes(self, mechanism: Mechanism) -> Shapes:
        """A thin line between the points."""
        first, second = self.ends(mechanism)
        return (LineShape(self.name, CABLE, first.place, second.place),)

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        """One contact and the distance of the points."""
        first, second = self.ends(mechanism)
        coordinates, offsets = (*first.coordinates, *second.coordinates), (*first.offset, *second.offset)
        p = (NO_CLEARANCE, self.slack_length, *offsets)
        return [
            ContactContribution(self.name, cable_gap_kernel, coordinates, p, self.normal, Frictionless()),
            SignalContribution(self.name, "distance", "m", cable_distance, coordinates, offsets),
        ]
