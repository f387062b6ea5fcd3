"""Moving clamp: a rigid connection whose relative angle and position are prescribed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from typing import TYPE_CHECKING

from flexmb.errors import InputError
from flexmb.joints.prismatic import direction_row
from flexmb.joints.revolute import drawn_angle
from flexmb.kernels import constraint_kernel
from flexmb.model.contributions import ConstraintContribution, Contribution, RowMotion
from flexmb.model.law import Motion
from flexmb.model.part import Joint

if TYPE_CHECKING:
    from flexmb.model.mechanism import Mechanism

ROWS = (("x", "m", "N"), ("y", "m", "N"), ("angle", "rad", "N m"))
"""Coordinates of the second body in the frame of the first, with units of coordinate and force."""


@constraint_kernel
def clamp_kernel(p, t, q, v, lam, g, G, g_t, gamma, H):
    """Point of the second node against that of the first, along the axes of the first; relative rotation."""
    s1x, s1y, s2x, s2y, angle = p
    direction_row(1.0, 0.0, s1x, s1y, s2x, s2y, q, v, lam, 0, g, G, gamma, H)
    direction_row(0.0, 1.0, s1x, s1y, s2x, s2y, q, v, lam, 1, g, G, gamma, H)
    g[2] = q[5] - q[2] - angle
    G[2, 2] = -1.0
    G[2, 5] = 1.0


@dataclass(frozen=True)
class Clamp(Joint):
    """Rigid connection of two bodies at a point, moved: angle and position of the second follow motions.

    R1^T (x2 + R2 s2 - x1) - s1 = (x, y)(t) and theta2 - theta1 = reference value + angle(t), with the motions counted
    from the reference configuration.

    Signals: fx, fy, force (on the second body, world axes) [N], moment (on the second body, about its point) [N m]; for
    each motion x, x_rate, x_force, x_power [m, m/s, N, W], the same of y, and angle, angle_rate, angle_torque,
    angle_power [rad, rad/s, N m, W]; the forces act on the second body along the axes of the first.

    Parameters
    ----------
    name : the joint's name.
    first, second : the bodies; `GROUND` is the frame.
    at : the point in the reference configuration [m].
    angle : motion of the relative angle [rad]; None: constant.
    x, y : motions of the second body's point along the axes of the first body [m]; None: constant.

    Raises
    ------
    InputError : an object that is no motion, a motion that jumps, or no motion at all.

    Notes
    -----
    The axes of the first body are the axes of the node that is held: along and across a link, X and Y for the ground.
    """

    _: KW_ONLY
    angle: Motion | None = None
    x: Motion | None = None
    y: Motion | None = None

    kind = "fixed"

    def __post_init__(self) -> None:
        super().__post_init__()
        given = {name: getattr(self, name) for name, *_ in ROWS}
        for name, motion in given.items():
            if motion is not None and not isinstance(motion, Motion):
                raise InputError(f"{self.label}: {name} is {motion!r}; it must be a motion, e.g. Ramp(6.28, 0.5).")
            if motion is not None and not motion.is_smooth:
                raise InputError(
                    f"{self.label}: {name} is {type(motion).__name__}(...), whose value or speed jumps; a clamp would "
                    "need an infinite force to follow. Move it with Table, Ramp or CycloidalRamp."
                )
        if all(motion is None for motion in given.values()):
            raise InputError(f"{self.label}: angle, x and y are None; give a motion, or use Fixed(...) for a weld.")

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        """Three constraint equations."""
        first, second = ends = self.ends(mechanism)
        coordinates = (*first.coordinates, *second.coordinates)
        p = (*first.offset, *second.offset, drawn_angle(mechanism, ends))
        driven = ((row, getattr(self, name), name, units) for row, (name, *units) in enumerate(ROWS))
        motions = tuple(RowMotion(row, law, name, (u, f)) for row, law, name, (u, f) in driven if law is not None)
        return [
            ConstraintContribution(
                self.name, clamp_kernel, coordinates, p, 3, second=second.coordinates, moment_row=2, motions=motions
            )
        ]
