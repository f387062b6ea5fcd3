"""Kernels of pairs of curves, by kind of the second curve, and contributions made of them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from flexmb.cams import curve_kernels, line_kernels, point_kernels
from flexmb.contact.friction.frictionless import Frictionless
from flexmb.kernels import Kernel
from flexmb.model.contributions import (
    ConstraintContribution,
    ContactContribution,
    Contribution,
    Coordinate,
    JointFriction,
    Reaction,
    SignalContribution,
)

TOUCHING, OPEN = "touching", "open"
"""Starts of a contact: the second body is put onto the curve, or stands where it is drawn."""


@dataclass(frozen=True)
class PairKernels:
    """Kernels of one kind of pair.

    Parameters
    ----------
    equation : constraint kernel of the distance.
    gap : gap kernel.
    sliding : joint-friction kernel.
    speed : signal kernel of the normal speed of the second body.
    """

    equation: Kernel
    gap: Kernel
    sliding: Kernel
    speed: Kernel

    def contributions(self, part: Any, coordinates: tuple[Coordinate, ...], p: tuple[float, ...]) -> list[Contribution]:
        """Constraint equation of an ideal pair; contact and its ideal form at the start."""
        rubbing = None if part.friction is None else JointFriction(self.sliding, p, part.friction)
        ideal = ConstraintContribution(
            part.name, self.equation, coordinates, p, 1, coordinates[3:], joint_friction=rubbing, holds="closed"
        )
        if part.normal is not None:
            friction = part.friction or Frictionless()
            contact = ContactContribution(part.name, self.gap, coordinates, p, part.contact_law(), friction)
            return [contact] if part.start == OPEN else [contact, ideal]
        reactions = Reaction("force", "N", 0), Reaction("power", "W", 0, rate="normal_speed")
        return [
            replace(ideal, holds="always", reactions=reactions),
            SignalContribution(part.name, "normal_speed", "m/s", self.speed, coordinates, p),
        ]


FACE = PairKernels(
    line_kernels.face_kernel, line_kernels.face_gap_kernel, line_kernels.face_friction, line_kernels.face_speed
)
"""Pair of a closed curve with a line."""

ROLLER = PairKernels(
    point_kernels.roller_kernel,
    point_kernels.roller_gap_kernel,
    point_kernels.roller_friction,
    point_kernels.roller_speed,
)
"""Pair of a closed curve with a circle or point."""

CURVES = PairKernels(
    curve_kernels.curves_kernel,
    curve_kernels.curves_gap_kernel,
    curve_kernels.curves_friction,
    curve_kernels.curves_speed,
)
"""Pair of two closed curves."""
