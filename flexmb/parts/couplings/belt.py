"""Belts and chains over two wheels, ideal or with friction that limits their force.

D is the vector from the centre of the first wheel to that of the second, R = r1 + r2 (r2 < 0: an open belt) and psi the
direction of D.  Both strands are tangents of both wheels, with the tensions T0 +- F/2:
    slip s = r1 omega1 + r2 omega2 - R psi_dot,   F = largest tanh(s/creep)
    V = T0 (length of the belt) = 2 T0 (sqrt(D^2 - R^2) + R asin(R/D)) + constant,   r = dV/dq + F ds/dv
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import KW_ONLY, replace

import numpy as np

from flexmb import planar
from flexmb.errors import InputError, ModelError
from flexmb.fields import field, positive, record, two
from flexmb.findings.finding import Finding, found
from flexmb.kernels import compiled, element_kernel, energy_kernel, signal_kernel
from flexmb.model.contributions import Contribution, ElementContribution, node_coordinates, signal_contributions
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import GROUND, WatchedMotion
from flexmb.model.shape import BeltShape, Shapes
from flexmb.parts.couplings.wheels import Wheels, strand_pull

SIGNALS = (  # signals with their units, in the order of their numbers
    ("force", "N"), ("first_torque", "N m"), ("second_torque", "N m"), ("power", "W"), ("slip", "m/s"),
    ("tight_tension", "N"), ("slack_tension", "N"), ("tension_ratio", "1"),
)  # fmt: skip

FORCE, FIRST_TORQUE, SECOND_TORQUE, POWER, SLIP, TIGHT, SLACK, RATIO = range(len(SIGNALS))


@compiled
def belt_row(r1, r2, q):
    """Derivatives of the slip by the six velocities."""
    dx, dy = q[3] - q[0], q[4] - q[1]
    share = (r1 + r2) / (dx * dx + dy * dy)
    return -share * dy, share * dx, r1, share * dy, -share * dx, r2


@compiled
def slip_of_belt(r1, r2, q, v):
    """Speed of the surface of the first wheel over that of the second one, seen from the line of centres."""
    row, slip = belt_row(r1, r2, q), 0.0
    for i in range(6):
        slip += row[i] * v[i]
    return slip


@element_kernel
def belt_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    """Forces of both strands on both wheels; K: change of the strands' directions with the centres, and of the slip."""
    largest, creep, tension, r1, r2 = p
    dx, dy = q[3] - q[0], q[4] - q[1]
    vx, vy = v[3] - v[0], v[4] - v[1]
    R, square = r1 + r2, dx * dx + dy * dy
    share = math.tanh(slip_of_belt(r1, r2, q, v) / creep)
    force, by_slip = largest * share, largest * (1.0 - share * share) / creep
    w, row = math.sqrt(square - R * R), belt_row(r1, r2, q)
    pull = 2.0 * tension * w / square
    for i in range(6):
        r[i] = force * row[i]
        for j in range(6):
            C[i, j] = by_slip * row[i] * row[j]
    r[0] -= pull * dx
    r[1] -= pull * dy
    r[3] += pull * dx
    r[4] += pull * dy
    steeper = 2.0 * tension * (2.0 * R * R - square) / (w * square * square)
    xx, xy = 2.0 * dx * dy / (square * square), (dy * dy - dx * dx) / (square * square)  # of (-dy, dx)/D^2
    by_x, by_y = -R * (xx * vx + xy * vy), -R * (xy * vx - xx * vy)
    for i in range(2):
        for j in range(2):
            own = (dx if i == 0 else dy) * (dx if j == 0 else dy) * steeper + (pull if i == j else 0.0)
            turn = xy if i != j else (xx if i == 0 else -xx)
            own -= force * R * turn
            K[i, j] += own
            K[i + 3, j + 3] += own
            K[i, j + 3] -= own
            K[i + 3, j] -= own
    for i in range(6):
        K[i, 0] -= by_slip * row[i] * by_x
        K[i, 1] -= by_slip * row[i] * by_y
        K[i, 3] += by_slip * row[i] * by_x
        K[i, 4] += by_slip * row[i] * by_y


@energy_kernel
def belt_energy(p, t, q, v):
    """Tension times length of the belt without its arcs of constant length, and power that slip turns into heat."""
    largest, creep, tension, r1, r2 = p
    dx, dy = q[3] - q[0], q[4] - q[1]
    R, square = r1 + r2, dx * dx + dy * dy
    slip = slip_of_belt(r1, r2, q, v)
    length = 2.0 * (math.sqrt(square - R * R) + R * math.asin(R / math.sqrt(square)))
    return tension * length, 0.0, largest * math.tanh(slip / creep) * slip


@signal_kernel
def belt_signal(p, t, q, v, a):
    """Signals of a belt by their numbers."""
    largest, creep, tension, r1, r2, number = p
    which, slip = int(number), slip_of_belt(r1, r2, q, v)
    force = -largest * math.tanh(slip / creep)
    tight, slack = tension + 0.5 * abs(force), tension - 0.5 * abs(force)
    if which >= TIGHT:
        return tight if which == TIGHT else (slack if which == SLACK else tight / slack)
    if which == SLIP:
        return slip
    if which == POWER:
        return r2 * force * v[5]
    return force if which == FORCE else (r1 * force if which == FIRST_TORQUE else r2 * force)


LARGE_STRETCH = 0.02  # change of the length that a belt would need, over its length, above which there is a remark


@record
class Belt(Wheels):
    """Belt over two wheels without mass and stretch: ideal, as a chain or timing belt, or with friction that can slip.

    An open belt turns both wheels the same way, r1 omega1 = r2 omega2, a crossed one against each other; angles count
    from the arm.

    Signals: force (difference of the tensions of both strands) [N]; first_torque, second_torque (on the wheels) [N m];
    power (of second_torque) [W].  With friction also slip (speed of the surface of the first wheel over that of the
    second) [m/s]; tight_tension, slack_tension (of the strands) [N]; tension_ratio [1].

    Raises
    ------
    InputError : numbers out of range; friction without pretension and creep, or creep without friction.
    ModelError : a belt over one wheel; wheels that overlap, or the ground as a wheel, of a belt with friction.

    Notes
    -----
    Both strands pull along their tangents at both wheels, so they load the bearings.  Without slip only the difference
    F of the tensions does work, so an ideal belt needs no pretension: its strands have F and 0, as those of a chain, or
    T0 +- F/2 while F < 2 T0 if it is given.  Work of this pull on axes that move is booked with friction in joints.

    With friction the centres of mass are the centres of the wheels.  The tensions are T0 +- F/2 (Poncelet: the length
    of the belt stays).  The belt slips where their ratio reaches exp(mu wrap) (Euler, Eytelwein), at F = 2 T0 tanh(mu
    wrap/2), on the wheel with the smaller wrap.  The force follows the slip s as F tanh(s/creep), so a loaded belt
    always creeps a little, as real belts do, also at rest.
    Slip turns energy into heat, which counts as that of dampers; T0 times the length of the belt is its strain energy.
    Start and modes are those of the ideal belt.  Centrifugal forces are left out: fast belts carry less.
    Source: L. Euler, Remarques sur l'effet du frottement dans l'equilibre, 1762, for the limit; tanh is a smoothing.
    """

    formerly = (("mu", "coefficient", "0.3"),)
    _: KW_ONLY
    radii: tuple[float, float] = field(
        "radii of the belt's middle line on both wheels", "m", two(positive, "numbers", "two numbers, e.g. (0.05, 0.1)")
    )
    crossed: bool = field("whether the strands cross", default=False)
    coefficient: float | None = field("coefficient of friction mu; None: an ideal belt", rule=positive, default=None)
    pretension: float | None = field("tension T0 of both strands without torque", "N", positive, default=None)
    creep: float | None = field("slip that carries tanh(1) = 76 % of the largest force", "m/s", positive, default=None)

    def __post_init__(self) -> None:
        super().__post_init__()
        given = {"coefficient": self.coefficient, "pretension": self.pretension, "creep": self.creep}
        missing = [name for name, value in given.items() if value is None]
        if missing and not (self.coefficient is None and self.creep is None):
            text = f"{self.label}: {' and '.join(missing)} not given; a belt with friction needs coefficient,"
            raise InputError(f"{text} pretension and creep. For an ideal belt leave coefficient and creep out.")

    def least_wrap(self, mechanism: Mechanism) -> float:
        """Least angle that the belt of a `mechanism` wraps around a wheel in the reference configuration [rad].

        Raises
        ------
        ModelError : wheels that overlap or lie within one another, or a wheel that is the ground.
        """
        if GROUND.name in (self.first.name, self.second.name):
            text = f"{self.label}: one wheel is the ground, which has no centre; with friction both must be bodies."
            raise ModelError(f"{text} Hold a body by Fixed(...) for a wheel at rest.")
        bodies = [mechanism.body(wheel.name, self.label) for wheel in (self.first, self.second)]
        first, second = (body.node(body.main) for body in bodies)
        apart, (r1, r2) = planar.distance((first.x, first.y), (second.x, second.y)), self.radii
        reach = r1 + r2 if self.crossed else abs(r1 - r2)
        if apart <= reach:
            text = f"{self.label}: the centres of mass of its wheels are {apart:g} m apart,"
            text += f" too near for radii of {r1:g} and {r2:g} m. Move a wheel;"
            raise ModelError(f"{text} with friction the centres of mass are the centres of the wheels.")
        return math.pi + 2.0 * math.asin(reach / apart) * (1.0 if self.crossed else -1.0)

    def findings_after(self, mechanism: Mechanism, motion: WatchedMotion) -> Iterator[Finding]:
        """Findings on wheels that go round, or whose distance changes by more than a belt could stretch or take up."""
        apart = self._distances(mechanism, motion)
        reach = sum(self.radii) if self.crossed else self.radii[0] - self.radii[1]
        yield from self._rounds(mechanism, motion) if self.coefficient is None and reach else ()
        drawn = planar.distance(*self._axes(mechanism))
        d = np.maximum(np.append(apart, drawn), abs(reach))
        wrap = math.pi * sum(self.radii) + 2.0 * reach * np.arcsin(reach / d)
        length = 2.0 * np.sqrt(d**2 - reach**2) + wrap
        stretch = length[:-1] / length[-1] - 1.0
        k = int(np.argmax(np.abs(stretch)))
        if abs(stretch[k]) > LARGE_STRETCH:
            verb = "stretch by" if stretch[k] > 0.0 else "be too long by"
            text = f"At t = {motion.times[k]:.6g} s the centres of the wheels of {self.label} are {apart[k]:.4g} m"
            text += f" apart, drawn are {drawn:.4g} m:"
            text += f" the belt would {verb} {100.0 * abs(stretch[k]):.3g} % of its length."
            numbers = {"time": motion.times[k], "stretch": stretch[k], "limit": LARGE_STRETCH}
            yield found("unreal-motion", (self.name,), text, "Hold the axes by joints, or by an arm.", **numbers)

    def shapes(self, mechanism: Mechanism) -> Shapes:
        first, second = self._mounts(mechanism)
        belt = BeltShape(self.name, first.place, second.place, self.radii, self.crossed)
        return (*self._circles(mechanism, self.radii), belt)

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        r1, r2 = self.radii[0], self.radii[1] if self.crossed else -self.radii[1]
        if self.coefficient is None or self.pretension is None or self.creep is None:
            return [self._rolling(mechanism, (r1, r2), (strand_pull, (r1 + r2, self.pretension or 0.0)))]
        largest = 2.0 * self.pretension * math.tanh(0.5 * self.coefficient * self.least_wrap(mechanism))
        bodies = [mechanism.body(wheel.name, self.label) for wheel in (self.first, self.second)]
        coordinates = tuple(c for body in bodies for c in node_coordinates(body.name, body.main))
        p = (largest, self.creep, self.pretension, r1, r2)
        element = ElementContribution(self.name, belt_kernel, coordinates, p, energy=belt_energy)
        friction: list[Contribution] = [element, *signal_contributions(self.name, belt_signal, SIGNALS, coordinates, p)]
        ideal = self._rolling(mechanism, (r1, r2), None)  # the element pulls with the pretension
        return [*friction, replace(ideal, holds="closed")]
