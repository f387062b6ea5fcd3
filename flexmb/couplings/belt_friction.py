"""Friction of a belt on its wheels: Eytelwein's limit, approached smoothly with the speed of slip."""

from __future__ import annotations

import math

from flexmb.kernels import compiled, element_kernel, energy_kernel, signal_kernel
from flexmb.model.contributions import ConstraintContribution, Contribution, ElementContribution, signal_contributions

LARGEST, CREEP, PRETENSION, RADIUS1, RADIUS2, SECOND, FIRST_FACTOR = range(7)
"""Places in p: largest difference of both tensions [N], speed of creep [m/s], tension at rest [N], radii of the wheels
[m] with their signs, place of the second wheel among the velocities (-1: ground); then the factor of each velocity [m]."""

FORCE, FIRST_TORQUE, SECOND_TORQUE, POWER, SLIP, TIGHT, SLACK, RATIO = range(8)

SIGNALS = (
    ("force", "N"),
    ("first_torque", "N m"),
    ("second_torque", "N m"),
    ("power", "W"),
    ("slip", "m/s"),
    ("tight_tension", "N"),
    ("slack_tension", "N"),
    ("tension_ratio", "1"),
)
"""Signals with their units, in the order of their numbers."""


@compiled
def slip_of_belt(p, v):
    """Speed of the surface of the first wheel over that of the second one."""
    slip = 0.0
    for i in range(v.shape[0]):
        slip += p[FIRST_FACTOR + i] * v[i]
    return slip


@element_kernel
def belt_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    """Difference F tanh(slip/creep) of both tensions, on the angles of wheels and arm."""
    share = math.tanh(slip_of_belt(p, v) / p[CREEP])
    force, by_slip = p[LARGEST] * share, p[LARGEST] * (1.0 - share * share) / p[CREEP]
    for i in range(v.shape[0]):
        r[i] = p[FIRST_FACTOR + i] * force
        for j in range(v.shape[0]):
            C[i, j] = p[FIRST_FACTOR + i] * p[FIRST_FACTOR + j] * by_slip


@energy_kernel
def belt_energy(p, t, q, v):
    """Power that slip turns into heat."""
    slip = slip_of_belt(p, v)
    return 0.0, 0.0, p[LARGEST] * math.tanh(slip / p[CREEP]) * slip


@signal_kernel
def belt_signal(p, t, q, v, a):
    """Signals of a belt by their numbers."""
    which = int(p[p.shape[0] - 1])
    slip = slip_of_belt(p, v)
    force = -p[LARGEST] * math.tanh(slip / p[CREEP])
    if which == SLIP:
        return slip
    if which >= TIGHT:
        tight, slack = p[PRETENSION] + 0.5 * abs(force), p[PRETENSION] - 0.5 * abs(force)
        return tight if which == TIGHT else (slack if which == SLACK else tight / slack)
    if which == FORCE:
        return force
    if which == FIRST_TORQUE:
        return p[RADIUS1] * force
    speed = 1.0
    if which == POWER:
        speed = v[int(p[SECOND])] if p[SECOND] >= 0.0 else 0.0
    return p[RADIUS2] * force * speed


def belt_contributions(
    ideal: ConstraintContribution,
    radii: tuple[float, float],
    second: int,
    largest: float,
    pretension: float,
    creep: float,
) -> list[Contribution]:
    """Element and signals of a belt with friction.

    Parameters
    ----------
    ideal : equation of the belt without slip.
    radii : radii of both wheels [m], with their signs.
    second : place of the second wheel among the coordinates of the equation, -1: ground.
    largest : largest difference of both tensions [N].
    pretension : tension of both strands at rest [N].
    creep : speed of slip by which the difference is scaled [m/s].
    """
    p = (largest, creep, pretension, *radii, float(second), *ideal.p[:-1])
    return [
        ElementContribution(ideal.part, belt_kernel, ideal.coordinates, p, energy=belt_energy),
        *signal_contributions(ideal.part, belt_signal, SIGNALS, ideal.coordinates, p),
    ]
