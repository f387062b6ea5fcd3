"""Joint friction: normal load from the multipliers, and direction of sliding."""

from __future__ import annotations

import math
from typing import Any

from flexmb import checks
from flexmb.errors import InputError
from flexmb.joints.direction import add_curvature, direction
from flexmb.kernels import joint_friction_kernel
from flexmb.model.law import FrictionLaw
from flexmb.places import LOAD, LOAD_BY_LAM, SLIDING


@joint_friction_kernel
def journal_friction(p, q, lam, out, H):
    """Pin of radius R: N = |force| + preload, slip = R (omega2 - omega1).

    Equation (1.8) of docs/theory/equations_of_motion.md.
    """
    R, preload = p
    F = math.sqrt(lam[0] * lam[0] + lam[1] * lam[1])
    out[LOAD] = F + preload
    if F > 0.0:
        for i in range(2):
            out[LOAD_BY_LAM + i] = lam[i] / F
    for theta, arm in ((2, -R), (5, R)):
        out[SLIDING + theta] = arm


@joint_friction_kernel
def guide_friction(p, q, lam, out, H):
    """Slider of length l: N = |F/2 + M/l| + |F/2 - M/l| + preload, slip = rate of its travel.

    Equation (1.9) of docs/theory/equations_of_motion.md.
    """
    ux, uy, s1x, s1y, s2x, s2y, length, preload = p
    across, couple = abs(lam[0]), 2.0 * abs(lam[1]) / length
    if across >= couple:
        row, load, by_lam = 0, across, 1.0 if lam[0] > 0.0 else (-1.0 if lam[0] < 0.0 else 0.0)
    else:
        row, load, by_lam = 1, couple, math.copysign(2.0 / length, lam[1])
    out[LOAD] = load + preload
    out[LOAD_BY_LAM + row] = by_lam
    _, J, nx, ny, far, near = direction(ux, uy, s1x, s1y, s2x, s2y, q)
    for j in range(6):
        out[SLIDING + j] = J[j]
    add_curvature(1.0, nx, ny, far, near, H)


def check_friction(joint: Any, size: str) -> None:
    """Check friction law, `size` of the surfaces and preload: all given, or none."""
    if joint.friction is not None and not isinstance(joint.friction, FrictionLaw):
        raise InputError(
            f"{joint.label}: friction is {joint.friction!r}; it must be a friction law, e.g. ModifiedCoulomb, or None."
        )
    value = getattr(joint, size)
    if joint.friction is None:
        if value is not None or joint.preload:
            raise InputError(f"{joint.label}: {size} and preload belong to friction; give friction=..., or leave them.")
        return
    if value is None:
        raise InputError(f"{joint.label}: {size} is missing, which friction needs; give {size}=... in m.")
    checks.positive(joint.label, size, value, "m")
    checks.not_negative(joint.label, "preload", joint.preload, "N")
