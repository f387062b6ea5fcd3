"""A drive: the coordinate of a joint follows a prescribed motion."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

from flexmb import checks
from flexmb.errors import InputError, ModelError
from flexmb.fields import field, instance, record
from flexmb.findings.finding import Finding, found
from flexmb.model.contributions import ConstraintContribution, Contribution, RowMotion
from flexmb.model.law import Motion
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import GROUND, Joint, Part, WatchedMotion

FASTEST = 2e4  # angular speed of a drive above which there is a finding [rad/s]
# Centripetal acceleration of a joint on a driven body above which there is one [m/s^2]; pistons of racing engines reach
# 0.9e5.
LARGEST_ACCELERATION = 1e5
STANDARD_GRAVITY = 9.80665


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
            text = f"{self.label}: motion is {type(self.motion).__name__}(...), whose value or speed jumps;"
            text += " a joint would need an infinite force to follow. Drive it with Table, Ramp, CycloidalRamp"
            raise InputError(f"{text} or Harmonic; a motion that jumps can be the history of a Force or Torque.")

    def validate(self, mechanism: Mechanism) -> None:
        """Check that the joint exists, can be driven, and is driven once."""
        self._measure(mechanism)
        same = [part for part in mechanism.parts if isinstance(part, Drive) and part.joint == self.joint]
        if len(same) > 1 and same[0].name == self.name:  # told once
            labels, word = " and ".join(part.label for part in same), "both" if len(same) == 2 else "all"
            raise ModelError(f"{labels} {word} drive joint {self.joint!r}. Keep one of them.")

    def findings_before(self, mechanism: Mechanism) -> Iterator[Finding]:
        """Finding on a drive that turns too fast for the joints on its bodies."""
        joint, speed = mechanism.find(self.joint), vars(self.motion).get("speed")
        if not isinstance(speed, float | int) or not isinstance(joint, Joint):
            return
        driven = {joint.first.name, joint.second.name} - {GROUND.name}
        joints = [one for one in mechanism.parts if isinstance(one, Joint) and one.at is not None]
        near = [one for one in joints if joint.at is not None and {one.first.name, one.second.name} & driven]
        arm = max((math.dist(joint.at, one.at) for one in near), default=0.0)
        acceleration = speed * speed * arm
        if (abs(speed) > FASTEST or acceleration > LARGEST_ACCELERATION) and joint.can_be_turned(mechanism):
            text = f"{self.label} turns at {speed:.4g} rad/s, {speed * 30.0 / math.pi:.4g} rpm"
            text += f": at {arm:.3g} m from the joint that is {acceleration / STANDARD_GRAVITY:.3g} g" if arm else ""
            right = speed * math.pi / 30.0
            remedy = f"Speeds are in rad/s: 2 pi/60 times those in rpm; {speed:.4g} rpm are {right:.4g}."
            yield found("odd-units", (self.name,), f"{text}.", remedy, speed=speed, acceleration=acceleration)

    def findings_after(self, mechanism: Mechanism, motion: WatchedMotion) -> Iterator[Finding]:  # noqa: ARG002 - the same
        """The findings of `findings_before`: a run may begin without an examination."""
        return self.findings_before(mechanism)

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        measure = self._measure(mechanism)
        motion = RowMotion(measure.rows - 1, self.motion, units=measure.drive_units)
        return [replace(measure, part=self.name, motions=(motion,))]

    def _measure(self, mechanism: Mechanism) -> ConstraintContribution:
        if self.joint not in (*mechanism.names, GROUND.name):
            text = f"{self.label} drives joint {self.joint!r}, but mechanism {mechanism.name!r} has no such part."
            raise ModelError(f"{text} {self._drivable(mechanism)}")
        part = mechanism.find(self.joint)
        contribution = part.drive_contribution(mechanism) if isinstance(part, Joint) else None
        if contribution is None:
            text = f"{self.label}: {part.label} cannot be driven. Drive the angle of a"
            raise ModelError(f"{text} Revolute or the travel of a Prismatic. {self._drivable(mechanism)}")
        return contribution

    def _drivable(self, mechanism: Mechanism) -> str:
        """Hint with the joints that a drive can prescribe."""
        joints = [part for part in mechanism.parts if isinstance(part, Joint)]
        names = [part.name for part in joints if type(part).drive_contribution is not Joint.drive_contribution]
        return checks.did_you_mean(self.joint, names, what="Joints that can be driven") if names else ""
