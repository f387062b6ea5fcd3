"""Chains of rigid arms on ball bearings, several side by side, each from a start of its own."""

import inspect
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import flexmb as fm

RADIUS, PRELOAD, CREEP = 5e-3, 100.0, 1e-3
"""Radius [m] and preload [N] of the bearings, to which coefficients of dry friction refer; slip speed of 76 % of it
[m/s].  The preload is far above the weights, so the torque of a bearing hardly depends on its load.
"""

APART = 1.0
"""Distance of the chains [m]."""

Numbers = Mapping[str, float]
Bounds = Mapping[str, tuple[float, float]]


@fm.element_kernel
def drag_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    """Torque b omega |omega| against the rotation."""
    (b,) = p
    r[0] = b * v[0] * abs(v[0])
    C[0, 0] = 2.0 * b * abs(v[0])


@fm.kernels.energy_kernel
def drag_energy(p, t, q, v):
    """Power of the drag."""
    (b,) = p
    return 0.0, 0.0, b * abs(v[0]) ** 3


@dataclass(frozen=True)
class AirDrag(fm.Element):
    """Drag of the air on an arm that turns."""

    body: fm.Part
    b: float  # [N m s^2]
    kernel = drag_kernel
    energy = drag_energy
    coords = ("body.theta",)


def arm(k: int, chain: int) -> str:
    """Name of an arm, from 1 on, of a chain."""
    return f"arm{k}_{chain}"


def chains(arms: int, numbers: Numbers, starts: Iterable[Iterable[float]]) -> fm.Mechanism:
    """Chains with the numbers m1, a1, I1, L1 (to the next bearing), k1, mu1, b1, m2, ..., g, one for each start.

    k, mu and b, of viscous and dry friction of a bearing and of drag, may be left out.  A start is the angles from
    hanging [rad], then the rates [rad/s].
    """
    parts = [part for k, start in enumerate(starts) for part in _chain(arms, numbers, k, list(start))]
    return fm.Mechanism("pendulums", parts, gravity=(0.0, -numbers["g"]))


def _chain(arms: int, numbers: Numbers, chain: int, start: list[float]) -> list[fm.Part]:
    x, y, vx, vy = APART * chain, 0.0, 0.0, 0.0
    parts: list[fm.Part] = []
    before: fm.Part = fm.GROUND
    for k in range(1, arms + 1):
        angle, rate = start[k - 1], start[arms + k - 1]
        c, s = math.cos(angle), math.sin(angle)
        m, a, inertia = (numbers[f"{name}{k}"] for name in ("m", "a", "I"))
        at, velocity = (x + a * s, y - a * c), (vx + a * rate * c, vy + a * rate * s, rate)
        body = fm.RigidBody(arm(k, chain), at, m, inertia, theta=angle, velocity=velocity)
        friction: dict[str, Any] = {}
        if f"mu{k}" in numbers:
            friction = {
                "friction": fm.friction.SmoothCoulomb(numbers[f"mu{k}"], CREEP),
                "radius": RADIUS,
                "preload": PRELOAD,
            }
        parts += [body, fm.Revolute(f"bearing{k}_{chain}", before, body, at=(x, y), **friction)]
        if f"k{k}" in numbers:
            viscous = {"stiffness": 0.0, "damping": numbers[f"k{k}"]}
            parts.append(fm.loads.TorsionSpring(f"viscous{k}_{chain}", before, body, **viscous))
        if f"b{k}" in numbers:
            parts.append(AirDrag(f"drag{k}_{chain}", body, numbers[f"b{k}"]))
        before, length = body, numbers.get(f"L{k}", 0.0)
        x, y, vx, vy = x + length * s, y - length * c, vx + length * rate * c, vy + length * rate * s
    return parts


def with_arguments(function: Callable[[Numbers], fm.Mechanism], names: Iterable[str]) -> Callable[..., fm.Mechanism]:
    """A function of named numbers, as `fm.design` takes it, from one of their mapping."""

    def model(**numbers: float) -> fm.Mechanism:
        return function(numbers)

    listed = [inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY) for name in names]
    model.__signature__ = inspect.Signature(listed)  # type: ignore[attr-defined]
    return model
