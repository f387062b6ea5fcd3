"""A drive: the coordinate of a joint follows a prescribed motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from flexmb import checks
from flexmb.errors import InputError, ModelError
from flexmb.fields import field, instance, record
from flexmb.model.contributions import ConstraintContribution, Contribution, RowMotion
from flexmb.model.law import Motion
from flexmb.model.part import GROUND, Joint, Part

if TYPE_CHECKING:
    from flexmb.model.mechanism import Mechanism


@record
class Drive(Part):
    """Prescribed angle of a revolute joint, or travel of a prismatic one, counted from the reference configuration.

    Signals: angle [rad], speed [rad/s], torque (on the second body) [N m], power [W]; of a prismatic joint travel [m],
    speed [m/s], force (on the second body) [N], power [W].

    Equation (1.6) of docs/theory/equations_of_motion.md.

    Raises
    ------
    ModelError : no such joint, a joint that cannot be driven, or one that is driven already.
    InputError : an object that is no motion, or a motion that jumps.
    """

    by_name = ("joint",)
    joint: Part | str = field("the joint, or its name")
    motion: Motion = field("the motion", rule=instance(Motion, "a motion, e.g. ConstantSpeed(6.28)"))

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.motion.is_smooth:
            raise InputError(
                f"{self.label}: motion is {type(self.motion).__name__}(...), whose value or speed jumps; a joint would "
                "need an infinite force to follow. Drive it with Table, Ramp, CycloidalRamp or Harmonic; "
                "a motion that jumps can be the history of a Force or Torque."
            )

    def validate(self, mechanism: Mechanism) -> None:
        """Check that the joint exists, can be driven, and is driven once."""
        self._measure(mechanism)
        same = [part for part in mechanism.parts if isinstance(part, Drive) and part.joint == self.joint]
        if len(same) > 1 and same[0].name == self.name:  # told once
            labels = " and ".join(part.label for part in same)
            word = "both" if len(same) == 2 else "all"
            raise ModelError(f"{labels} {word} drive joint {self.joint!r}. Keep one of them.")

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        """One constraint equation."""
        measure = self._measure(mechanism)
        motion = RowMotion(measure.rows - 1, self.motion, units=measure.drive_units)
        return [replace(measure, part=self.name, motions=(motion,))]

    def _measure(self, mechanism: Mechanism) -> ConstraintContribution:
        if self.joint not in (*mechanism.names, GROUND.name):
            raise ModelError(
                f"{self.label} drives joint {self.joint!r}, but mechanism {mechanism.name!r} has no such part. "
                f"{self._drivable(mechanism)}"
            )
        part = mechanism.find(self.joint)
        contribution = part.drive_contribution(mechanism) if isinstance(part, Joint) else None
        if contribution is None:
            raise ModelError(
                f"{self.label}: {part.label} cannot be driven. "
                f"Drive the angle of a Revolute or the travel of a Prismatic. {self._drivable(mechanism)}"
            )
        return contribution

    def _drivable(self, mechanism: Mechanism) -> str:
        """Hint with the joints that a drive can prescribe."""
        joints = [part for part in mechanism.parts if isinstance(part, Joint)]
        names = [part.name for part in joints if type(part).drive_contribution is not Joint.drive_contribution]
        return checks.did_you_mean(self.joint, names, what="Joints that can be driven") if names else ""
