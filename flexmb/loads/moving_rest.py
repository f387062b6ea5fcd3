"""Springs whose rest length or rest angle moves: the force by which the moving end differs from a fixed one."""

from __future__ import annotations

from numbers import Real
from typing import Any

import numpy as np

from flexmb.errors import InputError
from flexmb.kernels import element_kernel
from flexmb.loads.line import arms_of, put_line_force
from flexmb.model.contributions import Coordinate, ElementContribution
from flexmb.model.law import Motion


@element_kernel
def line_pull_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    """Tension F of constant size along the line of two points; q (6,)."""
    F, s1x, s1y, s2x, s2y = p
    ax, ay, bx, by, dx, dy = arms_of(s1x, s1y, s2x, s2y, q)
    l = (dx * dx + dy * dy) ** 0.5
    if l == 0.0:
        return  # no direction: no force
    nx, ny = dx / l, dy / l
    put_line_force(F, nx, ny, ax, ay, bx, by, r)
    across = (ny, -nx, -nx * ax - ny * ay, -ny, nx, nx * bx + ny * by)  # derivatives of the direction, times l
    for i in range(6):
        for j in range(6):
            K[i, j] += F / l * across[i] * across[j]
    K[2, 2] += F * (nx * ax + ny * ay)
    K[5, 5] -= F * (nx * bx + ny * by)


@element_kernel
def couple_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    """Constant moment M between two rotations, with the sign of a spring that is turned by M/k; q (2,)."""
    (moment,) = p
    r[0] = -moment
    r[1] = moment


def rest_at_start(label: str, name: str, rest: Any) -> float:
    """Rest length [m] or rest angle [rad] at t = 0 of a number or a motion.

    A motion without a finite value at t = 0 is refused.
    """
    if not isinstance(rest, Motion):
        return float(rest)
    value = float(rest.kernel(np.array(rest.parameters(), dtype=float), 0.0)[0])
    if not np.isfinite(value):
        raise InputError(f"{label}: {name} is {value} at t = 0; its motion must be finite there.")
    return value


def check_rest(label: str, name: str, rest: object, unit: str) -> None:
    """Refuse a rest length or rest angle that is neither a number nor a motion."""
    if isinstance(rest, Motion) or (isinstance(rest, Real) and not isinstance(rest, bool)):
        return
    raise InputError(
        f"{label}: {name} is {rest!r}; it must be a number in {unit}, or a motion whose value it is, e.g. "
        "Harmonic(0.01, frequency=2.0, mean=0.2)."
    )


def moving_end(
    part: str,
    kernel: Any,
    coordinates: tuple[Coordinate, ...],
    stiffness: float,
    rest: Any,
    start: float,
    more: tuple[float, ...],
) -> list[ElementContribution]:
    """Loads -k rest(t) and k rest(0), which make a spring with the rest length rest(0) one whose rest length moves.

    k is `stiffness`; `kernel` is that of a force of constant size, which is its first parameter, followed by `more`.
    With a number for `rest` nothing moves; `start` is its value at t = 0.
    """
    if not isinstance(rest, Motion) or stiffness == 0.0:
        return []
    found = [ElementContribution(part, kernel, coordinates, (-stiffness, *more), factor=rest)]
    if start != 0.0:
        found.append(ElementContribution(part, kernel, coordinates, (stiffness * start, *more)))
    return found
