"""PID: controller with proportional, integral and derivative action."""

from __future__ import annotations

import math
from dataclasses import KW_ONLY
from typing import Any

import numpy as np

from flexmb import checks
from flexmb.errors import InputError
from flexmb.fields import Rule, either, field, number, one_of, positive, record
from flexmb.kernels import control_kernel
from flexmb.model.contributions import ControlContribution, MotionInput
from flexmb.model.law import Motion
from flexmb.model.part import Controller, Part, name_of
from flexmb.parts.controllers.control import checked_sample, signal

FILTER_RATIO = 10.0  # ratio kd / kp of derivative action over the time constant of its filter, where none is given [1]
(INTEGRAL,) = range(1)  # place of the integral among the states, before that of the filter
MEASUREMENT, ERROR = "measurement", "error"
# Time before an instant, relative to the instant, from which a change is a jump; time until which targets are examined
# [s].
JUST_BEFORE, LATEST_BREAK = 1e-9, 1e3
TARGETS = 256  # number of intervals of a run at whose ends a moving target is read for its range


@control_kernel
def pid_law(p, t, u, x, dx, y):
    """PID with set-point weight, filter, saturation and back-calculation; u: m, then r, r', m' if given."""
    kp, ki, kd, low, high, reset, cutoff, weight, of_error, r, moving, measured = p
    r_dot, place, derivative, integral = 0.0, 0, 0.0, 0.0
    if moving > 0.0:
        r, r_dot = u[1], u[2]
    if ki != 0.0:
        integral, place = x[INTEGRAL], 1
    if kd != 0.0 and measured > 0.0:
        derivative = of_error * r_dot - u[u.shape[0] - 1]
    elif kd != 0.0:
        derivative = cutoff * (of_error * r - u[0] - x[place])
        dx[place] = derivative
    wanted = kp * (weight * r - u[0]) + integral + kd * derivative
    y[0] = min(max(wanted, low), high)
    if ki != 0.0:
        dx[INTEGRAL] = ki * (r - u[0]) + reset * (y[0] - wanted)


@record
class PID(Controller):
    """PID controller: output = kp (b r - m) + ki integral of (r - m) + kd derivative, within limits.

    r is the target, m the measured signal.  Signals: output; integral (the integral term, where ki is not 0); filter
    (the filtered signal, where the derivative comes from a filter).  Without a load the output is a signal alone, which
    a motor may read.

    With `rate` the derivative is the value of that signal, without a filter; of "measurement": targets that jump make
    no peaks; of "error": moving targets are followed.  Left out, filter_time is kd / (10 kp); tracking_time sqrt(kd /
    ki), without derivative action kp / ki.

    Raises
    ------
    InputError : no gain; limits in the wrong order; times that are not > 0; a time that must be given; a target that
        jumps, whose derivative is not filtered.
    ModelError : see `Control`.

    Notes
    -----
    A positive output has to move the measured signal up: turn a load that moves it down, or give all gains the other
    sign.  The derivative is kd s / (1 + s filter_time) of b' r - m, with b' = 1 for `derivative_of="error"`, else 0;
    the filter starts settled.  While the output is limited, the integral gives way by back-calculation,
    d(integral)/dt = ki (r - m) + (output - unlimited output) / tracking_time.  A sampled controller steps the integral
    by forward and the derivative by backward differences as filter_time tends to 0; times shorter than `sample` do not
    make it unstable.  Source: K. J. Astrom, T. Hagglund, PID Controllers: Theory, Design, and Tuning (Instrument
    Society of America, 1995), chapter 3.

    Examples
    --------
    >>> import flexmb as fm
    >>> arm = fm.RigidLink("arm", (0.0, 0.0), (0.5, 0.0), mass=1.0, inertia=1.0 / 48.0)
    >>> robot = fm.Mechanism("robot", [
    ...     arm, fm.Revolute("hinge", fm.GROUND, arm, at=(0.0, 0.0)), fm.Torque("actuator", arm, 1.0),
    ...     fm.PID("servo", "arm.theta", "actuator", target=1.0, kp=200.0, ki=100.0, kd=20.0, limit=50.0),
    ... ], gravity=(0.0, -9.81))
    >>> sol = fm.simulate(robot, t_end=20.0)
    >>> round(float(sol["servo.output"][-1]), 3)  # 1 kg * 9.81 m/s^2 * 0.25 m * cos(1)
    1.325
    """

    measure: str = field("name of the measured signal m", rule=signal("arm.theta"))
    by_name = ("load",)
    load: Part | str | None = field("name of a force or torque that the output multiplies", default=None)
    _: KW_ONLY
    target: float | Motion = field("target r, in the unit of m", rule=either(Motion, number), default=0.0)
    kp: float = field("gain of proportional action", default=0.0)
    ki: float = field("gain of integral action", default=0.0)
    kd: float = field("gain of derivative action", default=0.0)
    limit: Any = field("largest absolute value of the output, or a pair (lowest, highest)", default=None)
    rate: str | None = field("name of the signal of the rate of m", rule=signal("arm.theta"), default=None)
    filter_time: float | None = field("time constant of the filter of the derivative", "s", positive, default=None)
    tracking_time: float | None = field("time constant of the limited integral", "s", positive, default=None)
    weight: float = field("weight b of the target in proportional action", default=1.0)
    derivative_of: str = field('"measurement" or "error"', rule=one_of(MEASUREMENT, ERROR), default=MEASUREMENT)
    sample: float | None = field("time between instants; None: at all times", "s", Rule(checked_sample), default=None)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.kp == self.ki == self.kd == 0.0:
            raise InputError(f"{self.label} has no gain; give kp=, ki= or kd=.")
        self.limits()
        if self.kd != 0.0 and self.rate is None and self.filter_time is None and self.kp == 0.0:
            text = f"{self.label}: filter_time is missing, and without kp it has no default"
            raise InputError(f"{text}. Give filter_time= in s, or rate=, the signal of the measured rate.")
        if self.rate is not None and self.filter_time is not None:
            raise InputError(f"{self.label}: rate and filter_time are both given; a measured rate is not filtered.")
        if self.ki != 0.0 and self.is_limited and self.tracking_time is None and self.kp == 0.0 and self.kd == 0.0:
            text = f"{self.label}: tracking_time is missing, and without kp and kd it has no default"
            raise InputError(f"{text}. Give it in s, some fraction of the time that the mechanism takes.")
        self._check_kick()

    def _check_kick(self) -> None:
        """Refuse the derivative without a filter of a target that jumps, which has no finite value."""
        if self.kd == 0.0 or self.rate is None or self.derivative_of != ERROR or not isinstance(self.target, Motion):
            return
        p = np.array(self.target.parameters(), dtype=float)
        for t in self.target.breaks(self.target.period or LATEST_BREAK):
            dt = JUST_BEFORE * t
            (r0, v0, _), (r1, v1, _) = (self.target.kernel(p, x) for x in (t - dt, t))
            if abs(r1 - r0) > 10.0 * max(abs(v0), abs(v1)) * dt + JUST_BEFORE * max(abs(r0), abs(r1)):
                text = f"{self.label}: the target jumps at t = {t:g} s; the derivative of its error is infinite there"
                remedy = f"Give filter_time= in place of rate=, or derivative_of={MEASUREMENT!r}, or a Ramp."
                raise InputError(f"{text}. {remedy}")

    @property
    def is_limited(self) -> bool:
        """Whether the output has a limit."""
        return self.limit is not None

    def limits(self) -> tuple[float, float]:
        """Lowest and highest output.

        Raises
        ------
        InputError : limits that are no numbers, or in the wrong order.
        """
        if self.limit is None:
            return -math.inf, math.inf
        if isinstance(self.limit, (tuple, list)):
            low, high = checks.point(self.label, "limit", self.limit, "")
        else:
            high = checks.positive(self.label, "limit", self.limit)
            low = -high
        if not low < high:
            raise InputError(f"{self.label}: limit is {self.limit!r}; it must be (lowest, highest), in this order.")
        return low, high

    def numbers(self) -> tuple[float, ...]:
        """Parameters p of the law."""
        low, high = self.limits()
        moving, measured = isinstance(self.target, Motion), self.rate is not None
        filtered = self.kd != 0.0 and not measured
        smoothing = abs(self.kd / self.kp) / FILTER_RATIO if filtered and self.filter_time is None else self.filter_time
        return (
            *(self.kp, self.ki, self.kd, low, high),
            self._frequency(self._tracking() if self.ki != 0.0 and self.is_limited else None),
            self._frequency(smoothing if filtered else None),
            self.weight,
            1.0 if self.derivative_of == ERROR else 0.0,
            0.0 if isinstance(self.target, Motion) else float(self.target),
            float(moving),
            float(measured),
        )

    def followed(self, end: float) -> tuple[str, float, float]:
        """The measured signal, and the range of the target until the time `end` [s]."""
        if not isinstance(self.target, Motion):
            return self.measure, float(self.target), float(self.target)
        p, times = np.array(self.target.parameters(), dtype=float), np.linspace(0.0, end, TARGETS + 1)
        values = [self.target.kernel(p, float(t))[0] for t in (*times, *self.target.breaks(end))]
        return self.measure, min(values), max(values)

    def _tracking(self) -> float:
        """Time constant of the back-calculation [s]."""
        if self.tracking_time is not None:
            return self.tracking_time
        return math.sqrt(abs(self.kd / self.ki)) if self.kd != 0.0 else abs(self.kp / self.ki)

    def _frequency(self, time: float | None) -> float:
        """Inverse of a time constant [1/s], 0 for None; of a sampled one so that it decays as the exact solution."""
        if time is None:
            return 0.0
        return 1.0 / time if self.sample is None else -math.expm1(-self.sample / time) / self.sample

    def control(self) -> ControlContribution:
        inputs: list[str | MotionInput] = [self.measure]
        if isinstance(self.target, Motion):
            inputs += [MotionInput(self.target), MotionInput(self.target, rate=True)]
        inputs += [] if self.rate is None else [self.rate]
        states = (*(("integral",) if self.ki != 0.0 else ()), *(("filter",) if self.is_filtered else ()))
        return ControlContribution(
            self.name,
            pid_law,
            self.numbers(),
            tuple(inputs),
            () if self.load is None else (name_of(self.load),),
            ("output",),
            states,
            (0.0,) * len(states),
            None if self.sample is None else float(self.sample),
            ("",) * len(states),
            ("",),
            tuple(k for k, name in enumerate(states) if name == "filter"),
        )

    @property
    def is_filtered(self) -> bool:
        """Whether the derivative comes from a filter."""
        return self.kd != 0.0 and self.rate is None
