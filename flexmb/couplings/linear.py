"""Linear relation of angles: kernel and contribution."""

from __future__ import annotations

from collections.abc import Mapping

from flexmb.kernels import constraint_kernel
from flexmb.model.contributions import ConstraintContribution, Coordinate, Reaction
from flexmb.model.mechanism import Mechanism


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
    name: str, factors: Mapping[Coordinate, float], angles: Mapping[Coordinate, float], reactions: tuple[Reaction, ...]
) -> ConstraintContribution:
    """The equation sum of factor times angle = its value in the reference configuration [rad].

    Factors are in metres where the multiplier is to be a force.
    """
    value = sum(factor * angles[coordinate] for coordinate, factor in factors.items())
    p = (*factors.values(), value)
    return ConstraintContribution(name, angles_kernel, tuple(factors), p, 1, reactions=reactions)
