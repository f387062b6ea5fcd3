"""Bushing: a linear spring and damper in both directions and in rotation between two bodies."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import KW_ONLY
from typing import Any

from flexmb import checks
from flexmb.errors import InputError
from flexmb.fields import Rule, directed, field, not_negative, record
from flexmb.kernels import compiled, element_kernel, signal_kernel
from flexmb.model.contributions import ConstraintContribution, Contribution, signal_contributions
from flexmb.model.massless import massless
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import Joint
from flexmb.parts.joints.contact_point import add_curvature, curvature_times, direction, dot
from flexmb.parts.joints.prismatic import slot_kernel
from flexmb.parts.joints.revolute import coincidence_piece, drawn_angle, drawn_direction
from flexmb.places import packed

Pair = float | tuple[float, float]
STIFFNESS_X, STIFFNESS_Y, TORSION, DAMPING_X, DAMPING_Y, TORSION_DAMPING = range(6)
# Parameters p: stiffness and damping of both axes and of the rotation; direction of the first axis, points in the
# frames of their nodes, rotation without moment; number of the signal.
AXIS_X, AXIS_Y, OFFSET1_X, OFFSET1_Y, OFFSET2_X, OFFSET2_Y, ANGLE, CHOSEN = range(6, 14)


@compiled
def along_axis(p, q, first):
    """`direction` for the first axis of the bushing, or for the second."""
    mx, my = (p[AXIS_X], p[AXIS_Y]) if first else (-p[AXIS_Y], p[AXIS_X])
    return direction(mx, my, p[OFFSET1_X], p[OFFSET1_Y], p[OFFSET2_X], p[OFFSET2_Y], q)


@compiled
def put_force(p, q, v, r):
    """r (6,) of zeros; strain energy, no weight, power of damping."""
    twice, power = 0.0, 0.0
    for first in (True, False):
        i = 0 if first else 1
        d, J, _, _, _, _ = along_axis(p, q, first)
        k, c, rate = p[STIFFNESS_X + i], p[DAMPING_X + i], dot(J, v)
        twice, power = twice + k * d * d, power + c * rate * rate
        for m in range(6):
            r[m] += (k * d + c * rate) * J[m]
    turn, rate = q[5] - q[2] - p[ANGLE], v[5] - v[2]
    moment = p[TORSION] * turn + p[TORSION_DAMPING] * rate
    r[2] -= moment
    r[5] += moment
    return 0.5 * (twice + p[TORSION] * turn * turn), 0.0, power + p[TORSION_DAMPING] * rate * rate


@element_kernel
def bushing_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    """Forces k d + c d_dot along both axes, moment about the point; q (6,)."""
    put_force(p, q, v, r)
    for first in (True, False):
        i = 0 if first else 1
        d, J, nx, ny, far, near = along_axis(p, q, first)
        Jv = curvature_times(nx, ny, far, near, v)
        f = p[STIFFNESS_X + i] * d + p[DAMPING_X + i] * dot(J, v)
        for m in range(6):
            for n in range(6):
                K[m, n] += J[m] * (p[STIFFNESS_X + i] * J[n] + p[DAMPING_X + i] * Jv[n])
                C[m, n] += J[m] * p[DAMPING_X + i] * J[n]
        add_curvature(f, nx, ny, far, near, K)
    for m, n, sign in ((2, 2, 1.0), (5, 5, 1.0), (2, 5, -1.0), (5, 2, -1.0)):
        K[m, n] += sign * p[TORSION]
        C[m, n] += sign * p[TORSION_DAMPING]


BUSHING = massless("BUSHING", globals(), bushing_kernel)


@signal_kernel
def bushing_signal(p, t, q, v, a):
    """`CHOSEN`: place in `SIGNALS`; forces act on the second body."""
    which = int(p[CHOSEN])
    x, Jx, _, _, _, _ = along_axis(p, q, True)
    y, Jy, _, _, _, _ = along_axis(p, q, False)
    turn = q[5] - q[2] - p[ANGLE]
    if which < 3:
        return x if which == 0 else (y if which == 1 else turn)
    if which == 6:
        return -p[TORSION] * turn - p[TORSION_DAMPING] * (v[5] - v[2])
    if which > 9:
        return 0.5 * (p[STIFFNESS_X] * x * x + p[STIFFNESS_Y] * y * y + p[TORSION] * turn * turn)
    if which > 6:
        return dot(Jx, v) if which == 7 else (dot(Jy, v) if which == 8 else v[5] - v[2])
    f, g = p[STIFFNESS_X] * x + p[DAMPING_X] * dot(Jx, v), p[STIFFNESS_Y] * y + p[DAMPING_Y] * dot(Jy, v)
    fx, fy = -f * Jx[3] - g * Jy[3], -f * Jx[4] - g * Jy[4]
    return fx if which == 3 else (fy if which == 4 else math.sqrt(fx * fx + fy * fy))


SIGNALS = (  # signals with their units, in the order of `bushing_signal`
    ("dx", "m"), ("dy", "m"), ("angle", "rad"), ("fx", "N"), ("fy", "N"), ("force", "N"), ("moment", "N m"),
    ("dx_rate", "m/s"), ("dy_rate", "m/s"), ("omega", "rad/s"), ("energy", "J"),
)  # fmt: skip


def pair(owner: str, name: str, given: Any, unit: str, _: str) -> tuple[float, ...]:
    """A number for both axes or a pair of them, each >= 0."""
    both = given if isinstance(given, (tuple, list)) else (given, given)
    if len(both) != 2:
        raise InputError(f"{owner}: {name} is {given!r}; it must be a number or a pair along both axes.")
    return tuple(checks.not_negative(owner, name, x, unit) for x in both)


@record
class Bushing(Joint):
    """Elastic joint: linear springs and dampers along two axes of the first body and in rotation.

    The deflection is 0 in the reference configuration.

    Signals: dx, dy (deflection of the second body's point along the axes) [m], angle [rad], fx, fy, force (on the
    second body) [N], moment (on the second body, about its point) [N m], dx_rate, dy_rate [m/s], omega [rad/s],
    energy (of the springs) [J].

    Raises
    ------
    InputError : negative numbers, no stiffness at all, a direction without length.

    Notes
    -----
    Start values are the values of an ideal `Revolute`, of a pin in a slot where one axis has no stiffness; declared
    velocities take precedence, so the deflection may begin with any rate.
    Forces follow from a potential and from a power of dissipation in the deflections, so action and reaction are in
    balance, moments included, at any deflection.
    Linear in the deflection: not for stops and not for rubber beyond a few tenths of its thickness.
    """

    _: KW_ONLY
    stiffness: Pair = field("radial stiffness, or a pair along both axes, one of them > 0", "N/m", Rule(pair, ">= 0"))
    damping: Pair = field("radial damping, or a pair along both axes", "N s/m", Rule(pair, ">= 0"), default=0.0)
    torsion: float = field("stiffness of the rotation", "N m/rad", not_negative, default=0.0)
    torsion_damping: float = field("damping of the rotation", "N m s/rad", not_negative, default=0.0)
    along: tuple[float, float] = field("direction of the first axis", rule=directed, default=(1.0, 0.0))

    kind = "bushing"

    def __post_init__(self) -> None:
        super().__post_init__()
        if max(self.stiffness) <= 0.0:  # type: ignore[arg-type]
            raise InputError(f"{self.label}: stiffness is {self.stiffness}; one of both must be > 0 N/m.")

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        ends = self.ends(mechanism)
        ux, uy = drawn_direction(mechanism, ends.first, self.along)
        (kx, ky), (cx, cy) = self.stiffness, self.damping  # type: ignore[misc]
        numbers = {STIFFNESS_X: kx, STIFFNESS_Y: ky, TORSION: self.torsion}
        numbers |= {DAMPING_X: cx, DAMPING_Y: cy, TORSION_DAMPING: self.torsion_damping}
        numbers |= {AXIS_X: ux, AXIS_Y: uy, ANGLE: drawn_angle(mechanism, ends)}
        p = packed(numbers | dict(enumerate(ends.offsets, OFFSET1_X)))
        # the points coincide while start values are computed, along the axes that have stiffness
        held = coincidence_piece(self.name, ends, holds="start")
        if min(kx, ky) == 0.0:
            free = (ux, uy) if kx == 0.0 else (-uy, ux)
            own = self.name, slot_kernel, ends.coordinates, (*free, *ends.offsets), 1, ends.second.coordinates
            held = ConstraintContribution(*own, holds="start")
        signals = signal_contributions(self.name, bushing_signal, SIGNALS, ends.coordinates, p)
        return [BUSHING.contribution(self.name, ends.coordinates, p), *signals, held]
