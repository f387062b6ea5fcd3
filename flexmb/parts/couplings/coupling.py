"""Linear relations of angles and travels, and equal rotation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from flexmb import checks
from flexmb.errors import InputError
from flexmb.fields import field, record
from flexmb.kernels import constraint_kernel, signal_kernel
from flexmb.model.contributions import ConstraintContribution, Contribution, Coordinate, Reaction, SignalContribution
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import GROUND, Part, name_of, refuse_one_body
from flexmb.parts.joints.contact_point import curvature_times, direction, dot
from flexmb.parts.joints.prismatic import Prismatic, joint_with_coordinate, speed_signal
from flexmb.parts.joints.revolute import Revolute, drawn_angle


@constraint_kernel
def angles_kernel(p, t, q, v, lam, g, G, g_t, gamma, H):
    """g = sum of p[i] q[i], less p[n]."""
    n = q.shape[0]
    total = -p[n]
    for i in range(n):
        total += p[i] * q[i]
        G[0, i] = p[i]
    g[0] = total


def angle_of(mechanism: Mechanism, part: str, owner: str) -> tuple[Coordinate, float]:
    """Angle of the main node of a body, and its value in the reference configuration [rad]."""
    body = mechanism.body(part, owner)
    return (body.name, body.main, 2), body.node(body.main).theta


def angles_contribution(
    mechanism: Mechanism, owner: Part, factors: Sequence[tuple[Part, float]], reactions: tuple[Reaction, ...]
) -> ConstraintContribution:
    """Equation sum of factor times angle = its value as drawn [rad]; factors in metres make the multiplier a force."""
    found = [
        (*angle_of(mechanism, part.name, owner.label), factor) for part, factor in factors if part.name != GROUND.name
    ]
    p = (*(factor for *_, factor in found), sum(factor * angle for _, angle, factor in found))
    coordinates = tuple(coordinate for coordinate, *_ in found)
    return ConstraintContribution(owner.name, angles_kernel, coordinates, p, 1, reactions=reactions)


@record
class SameRotation(Part):
    """Two bodies that keep their relative angle, as a parallel guide or a coupling of shafts does; they may be apart.

    Signals: torque (on the second body) [N m].

    Raises
    ------
    ModelError : a body with itself.
    """

    first: Part = field("first body; `GROUND` for a body that must not turn")
    second: Part = field("second body")

    def __post_init__(self) -> None:
        super().__post_init__()
        refuse_one_body(self, "couples {} with")

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        factors = (self.first, -1.0), (self.second, 1.0)
        return [angles_contribution(mechanism, self, factors, (Reaction("torque", "N m", 0, 1.0),))]


COUNT, VALUE, BEGIN = range(3)  # places in p: number of joints, value of the sum; where the joints begin

TURNS, FACTOR, X1, Y1, THETA1, X2, Y2, THETA2, DRAWN, AXIS_Y = range(10)
OFFSET1_X, OFFSET1_Y, OFFSET2_X, OFFSET2_Y, SIZE = range(10, 15)
# Numbers of a joint: whether its angle counts, factor, places of the six coordinates; then the angle as it is drawn, or
# direction of the guide and both points in the frames of their nodes. SIZE: their number.
AXIS_X = DRAWN


@constraint_kernel
def coupling_kernel(p, t, q, v, lam, g, G, g_t, gamma, H):
    """g = sum of factor times angle or travel of each joint, less a value."""
    g[0] = -p[VALUE]
    for joint in range(int(p[COUNT])):
        k = BEGIN + SIZE * joint
        theta1, theta2, factor = int(p[k + THETA1]), int(p[k + THETA2]), p[k + FACTOR]
        if p[k + TURNS] > 0.0:
            g[0] += factor * (q[theta2] - q[theta1] - p[k + DRAWN])
            G[0, theta1] -= factor
            G[0, theta2] += factor
            continue
        x1, y1, x2, y2 = int(p[k + X1]), int(p[k + Y1]), int(p[k + X2]), int(p[k + Y2])
        own_q = q[x1], q[y1], q[theta1], q[x2], q[y2], q[theta2]
        own_v = v[x1], v[y1], v[theta1], v[x2], v[y2], v[theta2]
        numbers = (p[k + AXIS_X], p[k + AXIS_Y], p[k + OFFSET1_X], p[k + OFFSET1_Y], p[k + OFFSET2_X], p[k + OFFSET2_Y])
        travel, J, nx, ny, far, near = direction(*numbers, own_q)
        places = (x1, y1, theta1, x2, y2, theta2)
        g[0] += factor * travel
        for i in range(6):
            G[0, places[i]] += factor * J[i]
        gamma[0] -= factor * dot(curvature_times(nx, ny, far, near, own_v), own_v)
        force = lam[0] * factor
        H[theta1, theta1] -= force * far
        H[theta2, theta2] -= force * near
        H[theta1, theta2] += force * near
        H[theta2, theta1] += force * near
        for place, x in ((x1, force * ny), (y1, -force * nx), (x2, -force * ny), (y2, force * nx)):
            H[place, theta1] += x
            H[theta1, place] += x


@signal_kernel
def angle_rate(p, t, q, v, a):
    """Angular velocity of the second node against the first."""
    return v[1] - v[0]


@record
class Coupling(Part):
    """Linear relation of joint coordinates: the sum of factor times angle or travel of named joints is constant.

    A screw is {"nut": -pitch / (2 pi), "slide": 1.0}; a differential {"left": 1.0, "right": 1.0, "cage": -2.0}.

    Signals of each joint J: J_torque (on its second body) [N m] or J_force (along its guide) [N], J_speed [rad/s or
    m/s], J_power [W]; the powers add up to 0.

    Raises
    ------
    InputError : no joints, factors that are no numbers or 0.
    ModelError : no such joint, or a joint without angle or travel.

    Notes
    -----
    The force on a joint's coordinate is minus factor times the multiplier, so torques and forces are to one another as
    the factors.  Ideal: no mass, no backlash, no losses.  Angles count on over whole turns.
    """

    factors: Any = field("factor of each joint by its name, not 0")
    value: float = field("value of the sum, in the units of factor times coordinate", default=0.0)

    def __post_init__(self) -> None:
        super().__post_init__()
        given = self.factors
        if not isinstance(given, Mapping) and not isinstance(given, tuple):
            raise InputError(f"{self.label}: factors is {given!r}; give a dictionary such as {{'O': 2.0, 'Q': -1.0}}.")
        pairs = tuple(given.items()) if isinstance(given, Mapping) else given
        if not pairs:
            raise InputError(f"{self.label}: factors is empty; give the factor of at least one joint.")
        checked = []
        for pair in pairs:
            if not isinstance(pair, tuple) or len(pair) != 2:
                raise InputError(f"{self.label}: factors holds {pair!r}; give pairs of a joint and its factor.")
            name = name_of(pair[0])
            if not isinstance(name, str):
                raise InputError(f"{self.label}: factors holds the joint {pair[0]!r}; give joints or their names.")
            checked.append((name, checks.number(self.label, f"factors[{name!r}]", pair[1])))
            if checked[-1][1] == 0.0:
                raise InputError(f"{self.label}: factors[{name!r}] is 0, so the joint does not count; leave it out.")
        names = [name for name, _ in checked]
        twice = next((name for name in names if names.count(name) > 1), None)
        if twice is not None:
            raise InputError(f"{self.label}: factors holds joint {twice!r} twice; add up its factors.")
        object.__setattr__(self, "factors", tuple(checked))

    def validate(self, mechanism: Mechanism) -> None:
        """Check that all joints exist and have an angle or a travel."""
        self._joints(mechanism)

    def _joints(self, mechanism: Mechanism) -> list[tuple[Revolute | Prismatic, float]]:
        """Joints of the coupling with their factors."""
        return [(joint_with_coordinate(mechanism, self.label, name), factor) for name, factor in self.factors]

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        joints = self._joints(mechanism)
        places: dict[Coordinate, int] = {}
        numbers: list[float] = [float(len(joints)), self.value]
        reactions: list[Reaction] = []
        signals: list[Contribution] = []
        for joint, factor in joints:
            ends = joint.ends(mechanism)
            coordinates, turns = ends.coordinates, not isinstance(joint, Prismatic)
            drawn = (drawn_angle(mechanism, ends), *(5 * (0.0,)))
            own = joint.line(mechanism) if isinstance(joint, Prismatic) else drawn
            for coordinate in coordinates[2::3] if turns else coordinates:
                places.setdefault(coordinate, len(places))
            numbers += [float(turns), factor, *(float(places.get(coordinate, -1)) for coordinate in coordinates), *own]
            kind, units = ("torque", "N m") if turns else ("force", "N")
            speed = f"{joint.name}_speed"
            reactions.append(Reaction(f"{joint.name}_{kind}", units, 0, factor))
            reactions.append(Reaction(f"{joint.name}_power", "W", 0, factor, rate=speed))
            rate = (angle_rate, coordinates[2::3], ()) if turns else (speed_signal, coordinates, own)
            signals.append(SignalContribution(self.name, speed, "rad/s" if turns else "m/s", *rate))
        p, second = (tuple(numbers), 1), None if turns else coordinates[3:]
        told = tuple(reactions)
        return [ConstraintContribution(self.name, coupling_kernel, tuple(places), *p, second, reactions=told), *signals]
