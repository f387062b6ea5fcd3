"""Revolute joint with clearance: a journal of the second body in a bearing of the first."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass, field
from typing import TYPE_CHECKING

from flexmb import checks
from flexmb.contact.friction.frictionless import Frictionless
from flexmb.errors import InputError
from flexmb.joints.contact_point import put_column
from flexmb.joints.revolute import coincidence_piece
from flexmb.kernels import gap_kernel
from flexmb.model.law import FrictionLaw, NormalLaw
from flexmb.model.part import Joint
from flexmb.model.pieces import ContactPiece, Piece

if TYPE_CHECKING:
    from flexmb.model.mechanism import Mechanism


@gap_kernel
def journal_gap_kernel(p, q, v, out):
    """Journal in a bearing: e = journal centre - bearing centre, gap = c - |e|, normal n = e/|e|.

    The contact point lies at R1 + depth/2 from the bearing's centre, so both bodies are pushed at one point.
    """
    c, R1, s1x, s1y, s2x, s2y = p
    c1, d1, c2, d2 = math.cos(q[2]), math.sin(q[2]), math.cos(q[5]), math.sin(q[5])
    ax, ay = c1 * s1x - d1 * s1y, d1 * s1x + c1 * s1y
    bx, by = c2 * s2x - d2 * s2y, d2 * s2x + c2 * s2y
    ex, ey = q[3] + bx - q[0] - ax, q[4] + by - q[1] - ay
    vex, vey = v[3] - by * v[5] - v[0] + ay * v[2], v[4] + bx * v[5] - v[1] - ax * v[2]
    size = math.sqrt(ex * ex + ey * ey)
    if size > 0.0:
        nx, ny, inverse = ex / size, ey / size, 1.0 / size
    else:
        nx, ny, inverse = 1.0, 0.0, 0.0
    radius = R1 + 0.5 * (size - c)
    r1x, r1y = ax + radius * nx, ay + radius * ny  # from node 1 to the contact point
    r2x, r2y = r1x + q[0] - q[3], r1y + q[1] - q[4]
    out[0] = c - size
    out[1] = -(nx * vex + ny * vey)
    ux, uy = v[3] - v[5] * r2y - v[0] + v[2] * r1y, v[4] + v[5] * r2x - v[1] - v[2] * r1x
    out[2] = -ny * ux + nx * uy
    out[3], out[4], out[5], out[6], out[7], out[8] = nx, ny, r1x, r1y, r2x, r2y
    out[9], out[10], out[11], out[12] = ex, ey, vex, vey
    for j in range(6):
        # de/dq, column j
        gx, gy = 0.0, 0.0
        if j == 0:
            gx = -1.0
        elif j == 1:
            gy = -1.0
        elif j == 2:
            gx, gy = ay, -ax
        elif j == 3:
            gx = 1.0
        elif j == 4:
            gy = 1.0
        else:
            gx, gy = -by, bx
        along = nx * gx + ny * gy
        across = (nx * gy - ny * gx) * inverse
        nqx, nqy = -ny * across, nx * across
        px, py = radius * nqx + 0.5 * along * nx, radius * nqy + 0.5 * along * ny
        if j == 0:
            px += 1.0
        elif j == 1:
            py += 1.0
        elif j == 2:
            px, py = px - ay, py + ax
        put_column(out, j, nqx, nqy, px, py)


@dataclass(frozen=True)
class RevoluteClearance(Joint):
    """Revolute joint with play: the first body carries the bearing, the second one the journal.

    Signals: ex, ey (journal centre in the bearing) [m], vex, vey [m/s], penetration [m], penetration_rate [m/s],
    normal_force, friction_force, fx, fy, force (on the second body) [N], mode (0 free flight, 1 impact: from the
    closing of the gap to the end of the first rebound, 2 continuous contact).

    Parameters
    ----------
    name : the joint's name.
    first, second : the bodies with the bearing and with the journal.
    at : centre of the bearing in the drawn pose [m]; the journal is drawn in its middle.
    clearance : radius of the bearing less that of the journal [m], > 0 and < bearing_radius.
    bearing_radius : radius of the bearing [m], > 0.
    normal : law of the normal force.
    friction : law of friction; left out: frictionless.

    Raises
    ------
    InputError : clearance or radius out of range, a law of the wrong kind.
    """

    _: KW_ONLY
    clearance: float
    bearing_radius: float
    normal: NormalLaw
    friction: FrictionLaw = field(default_factory=Frictionless)

    kind = "clearance"

    def __post_init__(self) -> None:
        super().__post_init__()
        hint = "For a joint without play use Revolute(...)."
        checks.positive(self.label, "clearance", self.clearance, "m", hint)
        checks.positive(self.label, "bearing_radius", self.bearing_radius, "m")
        if self.clearance >= self.bearing_radius:
            raise InputError(
                f"{self.label}: clearance is {self.clearance:g} m; it must be smaller than the bearing radius "
                f"{self.bearing_radius:g} m. Did you mix up metres and millimetres?"
            )
        check_laws(self)

    @property
    def journal_radius(self) -> float:
        """Radius of the journal [m]."""
        return self.bearing_radius - self.clearance

    def pieces(self, mechanism: Mechanism) -> Sequence[Piece]:
        """One contact; at the start the journal is centred as in an ideal joint."""
        first, second = ends = self.ends(mechanism)
        coordinates = (*first.coordinates, *second.coordinates)
        p = (self.clearance, self.bearing_radius, *first.offset, *second.offset)
        normal = self.normal.for_radii(self.bearing_radius, self.journal_radius)
        return [
            ContactPiece(self.name, journal_gap_kernel, coordinates, p, normal, self.friction),
            coincidence_piece(self.name, ends, holds="closed"),
        ]


def check_laws(joint) -> None:
    """A normal law and a friction law in their places."""
    for name, kind, example in (
        ("normal", NormalLaw, "LankaraniNikravesh"),
        ("friction", FrictionLaw, "ModifiedCoulomb"),
    ):
        if not isinstance(getattr(joint, name), kind):
            raise InputError(
                f"{joint.label}: {name} is {getattr(joint, name)!r}; it must be a {name} law, e.g. {example}."
            )
