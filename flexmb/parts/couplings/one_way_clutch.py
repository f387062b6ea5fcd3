"""One-way clutch: a pin that turns freely one way, and winds up the other way."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import KW_ONLY, dataclass, replace

from flexmb.fields import field, not_negative, one_of, positive, record
from flexmb.findings.finding import Finding, found
from flexmb.kernels import friction_law, joint_friction_kernel
from flexmb.model.contributions import Contribution, JointFriction
from flexmb.model.law import FrictionLaw
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import Joint, WatchedMotion
from flexmb.parts.joints.revolute import coincidence_piece
from flexmb.places import LOAD, LOAD_BY_Q, SLIDING

LARGE_WIND_UP = 0.5  # wind-up above which there is a remark [rad]
COARSE_STEP = 0.35  # fixed step over the time of an engagement above which there is a remark: speeds are off by 2 %
# Places in the history: wind-up [rad]; its rate [rad/s] and the angle [rad] at the last state; 1 from then on.
WIND_UP, LAST_RATE, LAST_ANGLE, BEGUN = range(4)
COUNTER_CLOCKWISE, CLOCKWISE = "counter-clockwise", "clockwise"


@joint_friction_kernel
def clutch_rotation(p, q, lam, out, H):
    """Sliding is the relative angular velocity; the relative angle stands in place of a load."""
    out[LOAD] = q[5] - q[2]
    for theta, arm in ((2, -1.0), (5, 1.0)):
        out[SLIDING + theta], out[LOAD_BY_Q + theta] = arm, arm


@friction_law
def clutch_kernel(p, h, slip, angle, z, z_new):
    """T = side max(0, k w + d w_dot), w_dot = -side slip while w > 0; w grows with the angle from w_dot > 0 on."""
    k, d, side = p
    rate, last, w, w_rate, w_angle = -side * slip, z[LAST_RATE], z[WIND_UP], 0.0, 0.0
    if z[BEGUN] == 0.0:
        w = 0.0
    elif w > 0.0 or last >= 0.0:
        w += side * (z[LAST_ANGLE] - angle)
        w_angle = -side
    elif rate > 0.0:  # within the step, rate grows from last < 0 to rate > 0
        span = rate - last
        w = 0.5 * h * rate * rate / span
        w_rate = 0.5 * h * rate * (rate - 2.0 * last) / (span * span)
    z_new[LAST_RATE], z_new[LAST_ANGLE], z_new[BEGUN] = rate, angle, 1.0
    if w <= 0.0:
        w, w_rate, w_angle = 0.0, 0.0, 0.0
    z_new[WIND_UP] = w
    torque = k * w + d * rate
    if torque <= 0.0:
        return 0.0, 0.0, 0.0
    return side * torque, -(k * w_rate + d), side * k * w_angle


@dataclass(frozen=True)
class WindUp(FrictionLaw):
    """Torque of a one-way clutch: a spring and damper that act against rotation one way."""

    stiffness: float  # k [N m/rad], > 0
    damping: float  # d [N m s/rad], >= 0
    side: float  # 1.0 if positive rotation is free, -1.0 if negative rotation is free

    kernel = clutch_kernel

    def history(self) -> tuple[float, ...]:
        """Wind-up [rad], its rate [rad/s], the angle [rad], and whether both are known."""
        return 0.0, 0.0, 0.0, 0.0


@record
class OneWayClutch(Joint):
    """Pin with a one-way clutch (freewheel, roller or sprag clutch, backstop): its second body turns freely one way.

    Against rotation the other way stands the torque stiffness w + damping dw/dt of its wind-up w >= 0, which begins
    where the relative rotation turns back and ends where w is 0 again; the torque never changes its sign.

    Signals: fx, fy, force (on the second body) [N], torque (on the second body) [N m].

    Raises
    ------
    InputError : stiffness not > 0, negative damping, an unknown direction.

    Notes
    -----
    The clutch engages at any angle, without backlash and without drag while it overruns; it does not slip under too
    large a torque.  It yields torque/stiffness and does not creep.  The ledger counts the energy of the wind-up as
    dissipated in friction, and gives it back as the clutch unwinds.  Statics and modes know no wind-up: it resists
    nothing there.  Where it holds, replace it by a `Revolute` and a `TorsionSpring` of its stiffness.
    Source of the model, an engaged clutch as a spring that cannot pull: F. Zhu, R. G. Parker, Non-linear dynamics of a
    one-way clutch in belt-pulley systems, Journal of Sound and Vibration 279 (2005) 285-308.
    """

    _: KW_ONLY
    stiffness: float = field("torsional stiffness of the engaged clutch", "N m/rad", positive)
    damping: float = field("damping of the engaged clutch", "N m s/rad", not_negative, default=0.0)
    free: str = field("free turn of the second", rule=one_of(COUNTER_CLOCKWISE, CLOCKWISE), default=COUNTER_CLOCKWISE)

    kind = "revolute"

    def findings_after(self, mechanism: Mechanism, motion: WatchedMotion) -> Iterator[Finding]:
        """Findings on a wind-up that no clutch bears, and on an engagement of a few fixed steps."""
        torque, when = motion.peak(f"{self.name}.torque")
        if torque > LARGE_WIND_UP * self.stiffness:
            angle = torque / self.stiffness
            text = f"At t = {when:.6g} s {self.label} is wound up by some {angle:.4g} rad."
            yield found("unreal-motion", (self.name,), text, "Its stiffness is in N m/rad.", time=when, angle=angle)
        # Time in which the largest torque changes the speed of the bodies: J/damping or sqrt(J/stiffness), whichever is
        # shorter. J is the torque over the largest acceleration, at least the moment of inertia of the rigid bodies,
        # since impacts accelerate them more.
        acceleration, inverse = 0.0, 0.0
        for end in self.ends(mechanism):
            name = f"{end.part}.{end.node}.alpha" if end.node else f"{end.part}.alpha"
            acceleration += motion.peak(name)[0] if name in motion.signals.places else 0.0
            inertia = getattr(self.first if end.part == self.first.name else self.second, "inertia", None)
            inverse += 1.0 / inertia if isinstance(inertia, float) else 0.0
        h, duration = motion.fixed_step, math.inf
        if torque != 0.0 and acceleration != 0.0:
            J = max(torque / acceleration, 1.0 / inverse if inverse > 0.0 else 0.0)
            duration = min(J / self.damping if self.damping > 0.0 else math.inf, math.sqrt(J / self.stiffness))
        if h is not None and h > COARSE_STEP * duration:
            text = f"{self.label} engages at t = {when:.6g} s within some {duration:.2g} s, in which a fixed step of"
            text = f"{text} {h:.3g} s is long: speeds behind it may be off by 2 % or more."
            remedy = f"Take steps of {0.1 * duration:.1g} s, or Adaptive()."
            yield found("coarse-step", (self.name,), text, remedy, step=h, duration=duration)

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        law = WindUp(self.stiffness, self.damping, 1.0 if self.free == COUNTER_CLOCKWISE else -1.0)
        clutch = JointFriction(clutch_rotation, (), law, ("torque", "N m"))
        return [replace(coincidence_piece(self.name, self.ends(mechanism)), joint_friction=clutch)]
