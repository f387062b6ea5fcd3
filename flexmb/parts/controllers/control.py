"""Controllers: a law of one's own, DC motor, PID."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY
from typing import Any

import numpy as np

from flexmb import checks
from flexmb.errors import InputError
from flexmb.fields import Rule, either, field, not_negative, number, one_of, positive, record, several
from flexmb.kernels import CONTROL, Kernel, control_kernel
from flexmb.model.contributions import ControlContribution, MotionInput
from flexmb.model.law import Motion
from flexmb.model.part import Controller, Part, name_of

LEAST_SAMPLE = 1e-9  # shortest time between two instants of a controller [s]; each costs some 0.3 ms of computing


def checked_sample(label: str, name: str, sample: Any, unit: str, _: str) -> float:
    """A time between two instants that is not so short that a run would not get on."""
    hint = "For a controller that acts at all times leave it out."
    if (value := checks.positive(label, name, sample, unit, hint)) < LEAST_SAMPLE:
        checks.refuse(f"{label}: {name} is {value:g} s; it must be at least {LEAST_SAMPLE:g} s. {hint}")
    return value


def checked_law(label: str, name: str, law: Any, *_: str) -> Kernel:
    """A control kernel, or `InputError`."""
    if not isinstance(law, Kernel) or law.contract is not CONTROL:
        text = f"{label}: {name} is {law!r}; it must be a function (p, t, u, x, dx, y)"
        raise InputError(f"{text} with the decorator @flexmb.control_kernel.")
    return law


def checked_inputs(label: str, field: str, given: object, *_: str) -> tuple[str | Motion, ...]:
    """Names of signals and motions, or `InputError`."""
    found = checks.sequence(label, field, given, "names of signals")
    for wanted in found:
        if not isinstance(wanted, Motion) and not is_signal_name(wanted):
            text = f"{label}: {field} holds {wanted!r}; it must hold names of signals such as 'arm.omega', or motions"
            raise InputError(f"{text} such as Ramp(...).")
    return found


def is_signal_name(value: object) -> bool:
    """Whether a value can be the name of a signal."""
    return isinstance(value, str) and "." in value.strip(".")


def signal(example: str) -> Rule:
    """The name of a signal."""

    def check(label: str, name: str, value: Any, *_: str) -> str:
        if not is_signal_name(value):
            raise InputError(f"{label}: {name} is {value!r}; it must be the name of a signal, as {example!r}.")
        return str(value)

    return Rule(check)


def names(label: str, field: str, given: object, *_: str) -> tuple[str, ...]:
    """Names without repetition, or `InputError`."""
    found = checks.sequence(label, field, given, "names")
    for name in found:
        if not isinstance(name, str) or not name or "." in name or name != name.strip():
            raise InputError(f"{label}: {field} holds {name!r}; it must hold names without '.'.")
        if found.count(name) > 1:
            raise InputError(f"{label}: {field} holds {name!r} twice; name each once.")
    return found


def checked_states(label: str, field: str, given: Any, *_: str) -> tuple[tuple[str, float | None], ...]:
    """Names and start values of states, from their number, their start values, or start values by name."""
    if isinstance(given, Mapping):
        pairs = tuple(given.items())
    elif isinstance(given, (str, bytes)) or given is None:
        raise InputError(f"{label}: {field} is {given!r}; it must be a number of states, or their start values.")
    elif isinstance(given, int):
        pairs = tuple((f"state{k}", 0.0) for k in range(1, checks.count(label, field, given, 0) + 1))
    else:
        values = checks.sequence(label, field, given, "start values")
        named = all(isinstance(value, tuple) and len(value) == 2 for value in values)
        pairs = values if named else tuple((f"state{k}", value) for k, value in enumerate(values, 1))
    names(label, field, tuple(name for name, _ in pairs))
    return tuple(
        (name, None if value is None else checks.number(label, f"start value of {name!r}", value))
        for name, value in pairs
    )


@record
class Control(Controller):
    """A controller with a law of one's own: loads that depend on signals, at all times or sampled.

    The law reads the numbers p, the time t [s], the inputs u (values of signals and motions, in their order) and its
    own states x; it writes the rates dx of its states [1/s] and the outputs y.  Values of the loads are multiplied by
    the outputs, in their order; further outputs are signals alone, which other controllers may read.

    States start at 0, or at the values given, also by name; None stands for the value at which the rate of the state is
    0 at the start.  With `sample` the law reads the signals at these instants, its outputs hold until the next one, and
    a state x becomes x + sample dx; without, it acts at all times.

    Signals: every state and every output by its name (state1, ..., output1, ... without names of one's own).

    Raises
    ------
    InputError : no law, no output, names that are no names, a sampling time that is not > 0.
    ModelError : an input that does not exist or that a law without `sample` cannot read; a load that does not exist,
        has a history, or has another controller; controllers that read one another's outputs in a circle.
    KernelError : a law that reads or writes beyond its arrays.

    Notes
    -----
    A law that acts at all times is a part of the implicit step, and its tangent is found by differences.  Its inputs
    are functions of time, positions and velocities.  Where it jumps, as that of a relay, error-controlled steps end;
    fixed steps pass the jump, with an error of the velocities of half of it over a step.  A sampled law may jump, and
    may read all signals: they are those of the last accepted state, outputs of other sampled laws those of before the
    instant (0 at the start).  Loads do work, which is booked as theirs (`energy.load_work`).

    Examples
    --------
    >>> import flexmb as fm
    >>> @fm.control_kernel
    ... def damper(p, t, u, x, dx, y):
    ...     y[0] = -p[0] * u[0]
    >>> rotor = fm.RigidBody("rotor", at=(0.0, 0.0), mass=1.0, inertia=0.5, velocity=(0.0, 0.0, 2.0))
    >>> axis = fm.Revolute("axis", fm.GROUND, rotor, at=(0.0, 0.0))
    >>> brake = fm.Control("brake", inputs=["rotor.omega"], loads=["torque"], law=damper, numbers=[0.5])
    >>> model = fm.Mechanism("rotor", [rotor, axis, fm.Torque("torque", rotor, 1.0), brake])
    >>> sol = fm.simulate(model, t_end=1.0, step=fm.Adaptive(rtol=1e-8))
    >>> round(float(sol["rotor.omega"][-1]), 5)  # 2 exp(-t)
    0.73576
    """

    inputs: Sequence[str | Motion] = field('names of signals, as "tip.x", and motions', rule=Rule(checked_inputs))
    by_name = ("loads",)
    loads: Sequence[Part | str] = field("names of forces and torques, multiplied by the outputs", rule=Rule(names))
    law: Kernel = field("function (p, t, u, x, dx, y) with the decorator `control_kernel`", rule=Rule(checked_law))
    _: KW_ONLY
    numbers: Sequence[float] = field("parameters p of the law", rule=several(number, "numbers"), default=())
    states: Any = field("number of own states, or their start values", rule=Rule(checked_states), default=())
    outputs: Sequence[str] | None = field("names of the outputs; None: output1, ...", rule=Rule(names), default=None)
    sample: float | None = field("time between the actions of the law", "s", Rule(checked_sample), default=None)

    def __post_init__(self) -> None:
        super().__post_init__()
        known = self.output_names
        if not known:
            raise InputError(f"{self.label} has no output; give loads=[...], the names of forces or torques.")
        if len(known) < len(self.loads):
            text = f"{self.label}: outputs has {len(known)} names, but there are {len(self.loads)} loads"
            raise InputError(f"{text}; name at least one output for each load.")
        every = [*known, *(name for name, _ in self.states)]
        twice = sorted({name for name in every if every.count(name) > 1})
        if twice:
            raise InputError(f"{self.label}: {twice[0]!r} names two of its states and outputs. Rename one.")

    @property
    def output_names(self) -> tuple[str, ...]:
        """Names of the outputs."""
        if self.outputs is None:
            return tuple(f"output{k}" for k in range(1, len(self.loads) + 1))
        return tuple(self.outputs)

    def control(self) -> ControlContribution:
        inputs = tuple(MotionInput(one) if isinstance(one, Motion) else one for one in self.inputs)
        given = self.name, self.law, tuple(self.numbers), inputs, tuple(map(name_of, self.loads)), self.output_names
        states, start = tuple(name for name, _ in self.states), tuple(value or 0.0 for _, value in self.states)
        units = ("",) * len(states), ("",) * len(self.output_names)
        settled = tuple(k for k, (_, value) in enumerate(self.states) if value is None)
        return ControlContribution(*given, states, start, self.sample, *units, settled)


(CURRENT,) = range(1)  # place of the current among the states


@control_kernel
def dc_motor_law(p, t, u, x, dx, y):
    """L di/dt = V - R i - k n omega, torque = k n i; u: speed, then the voltage unless it is a number."""
    R, L, k, n, V = p
    if u.shape[0] > 1:
        V = u[1]
    free = V - k * n * u[0]
    current = x[CURRENT] if L > 0.0 else free / R
    if L > 0.0:
        dx[CURRENT] = (free - R * current) / L
    y[0], y[1] = k * n * current, V
    if L == 0.0:
        y[2] = current


def checked_voltage(label: str, name: str, value: Any, unit: str, _: str) -> Any:
    """A number, a motion or the name of a signal."""
    if isinstance(value, str) and not is_signal_name(value):
        raise InputError(f"{label}: {name} is {value!r}; a signal is called as 'servo.output'.")
    return value if isinstance(value, str | Motion) else checks.number(label, name, value, unit)


@record
class DCMotor(Controller):
    """Direct-current motor with constant field, and an ideal gear: the current is a state.

    L di/dt = V - R i - k n omega, torque = k n i, with the speed omega behind the gear.  Without inductance the current
    is an output instead of a state.  A linear motor has a speed [m/s], a force of 1 N as its load, and k [N/A].

    Signals: current [A], torque (behind the gear) [N m], voltage [V].

    Raises
    ------
    InputError : numbers out of range; a start current without inductance.
    ModelError : see `Control`.

    Notes
    -----
    The inertia of the rotor counts with the square of gear_ratio; add it to the driven body.  Source: G. F.
    Franklin, J. D. Powell, A. Emami-Naeini, Feedback Control of Dynamic Systems (Pearson, 6th ed. 2010), section 2.3.

    Examples
    --------
    >>> import flexmb as fm
    >>> rotor = fm.RigidBody("rotor", at=(0.0, 0.0), mass=1.0, inertia=2e-3)
    >>> model = fm.Mechanism("fan", [
    ...     rotor, fm.Revolute("axis", fm.GROUND, rotor, at=(0.0, 0.0)), fm.Torque("shaft", rotor, 1.0),
    ...     fm.controllers.DCMotor("motor", "rotor.omega", "shaft", voltage=12.0, resistance=2.0, inductance=1e-3,
    ...                torque_constant=0.05),
    ... ])
    >>> sol = fm.simulate(model, t_end=20.0)
    >>> round(float(sol["rotor.omega"][-1]), 2)  # no load: V / k
    240.0
    """

    speed: str = field("name of the signal of the speed behind the gear", "rad/s or m/s", signal("arm.omega"))
    by_name = ("load",)
    load: Part | str = field("name of a torque of 1 N m that the motor multiplies (-1: reversed)")
    _: KW_ONLY
    voltage: float | Motion | str = field("V, also a motion, or the name of a signal", "V", Rule(checked_voltage))
    resistance: float = field("R", "ohm", positive)
    torque_constant: float = field("k, which is the voltage constant [V s/rad], too", "N m/A")
    inductance: float = field("L; 0: the current follows without delay", "H", not_negative, default=0.0)
    gear_ratio: float = field("n, speed of the motor over that of the driven body", default=1.0)
    current: float = field("current at the start", "A", default=0.0)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.torque_constant == 0.0 or self.gear_ratio == 0.0:
            raise InputError(f"{self.label}: torque_constant and gear_ratio must not be 0; the motor has no torque.")
        if self.current != 0.0 and self.inductance == 0.0:
            text = f"{self.label}: current is {self.current:g} A, but without inductance the voltage gives it"
            raise InputError(f"{text}. Leave it out, or give inductance= in H.")

    def control(self) -> ControlContribution:
        number = 0.0 if isinstance(self.voltage, (str, Motion)) else float(self.voltage)
        inputs: list[str | MotionInput] = [self.speed]
        if isinstance(self.voltage, (str, Motion)):
            inputs.append(self.voltage if isinstance(self.voltage, str) else MotionInput(self.voltage))
        p = (self.resistance, self.inductance, self.torque_constant, self.gear_ratio, number)
        given = self.name, dc_motor_law, p, tuple(inputs), (name_of(self.load),)
        outputs, units = ("torque", "voltage"), ("N m", "V")
        if self.inductance == 0.0:
            return ControlContribution(*given, (*outputs, "current"), output_units=(*units, "A"))
        return ControlContribution(*given, outputs, ("current",), (self.current,), None, ("A",), units)


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
    d(integral)/dt = ki (r - m) + (output - unlimited output) / tracking_time.  A sampled one holds the output and
    steps the integral by forward differences of dt = sample, with g(T) = (1 - exp(-dt/T))/dt in place of 1/T of both
    time constants, whose decay is exact, so that none is too short: the derivative is kd g(filter_time) (v - f) with
    v = b' r - m, and then f grows by dt g (v - f), a backward difference as filter_time tends to 0.
    Source: K. J. Astrom, T. Hagglund, PID Controllers: Theory, Design, and Tuning (Instrument Society of America,
    1995), chapter 3.

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
        if self.ki != 0.0 and self.limit is not None and self.tracking_time is None and self.kp == self.kd == 0.0:
            text = f"{self.label}: tracking_time is missing, and without kp and kd it has no default"
            raise InputError(f"{text}. Give it in s, some fraction of the time that the mechanism takes.")
        if self.kd == 0.0 or self.rate is None or self.derivative_of != ERROR or not isinstance(self.target, Motion):
            return
        # the derivative of a target that jumps has no finite value without a filter
        p = np.array(self.target.parameters(), dtype=float)
        for t in self.target.breaks(self.target.period or LATEST_BREAK):
            dt = JUST_BEFORE * t
            (r0, v0, _), (r1, v1, _) = (self.target.kernel(p, x) for x in (t - dt, t))
            if abs(r1 - r0) > 10.0 * max(abs(v0), abs(v1)) * dt + JUST_BEFORE * max(abs(r0), abs(r1)):
                text = f"{self.label}: the target jumps at t = {t:g} s; the derivative of its error is infinite there"
                remedy = f"Give filter_time= in place of rate=, or derivative_of={MEASUREMENT!r}, or a Ramp."
                raise InputError(f"{text}. {remedy}")

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
        tracking = self.tracking_time if self.ki != 0.0 and self.limit is not None else None  # of the back-calculation
        if self.ki != 0.0 and self.limit is not None and tracking is None:
            tracking = math.sqrt(abs(self.kd / self.ki)) if self.kd != 0.0 else abs(self.kp / self.ki)
        rates = self._frequency(tracking), self._frequency(smoothing if filtered else None)
        still = 0.0 if isinstance(self.target, Motion) else float(self.target)
        of_error, flags = float(self.derivative_of == ERROR), (float(moving), float(measured))
        return self.kp, self.ki, self.kd, low, high, *rates, self.weight, of_error, still, *flags

    def followed(self, end: float) -> tuple[str, float, float]:
        """The measured signal, and the range of the target until the time `end` [s]."""
        if not isinstance(self.target, Motion):
            return self.measure, float(self.target), float(self.target)
        p, times = np.array(self.target.parameters(), dtype=float), np.linspace(0.0, end, TARGETS + 1)
        values = [self.target.kernel(p, float(t))[0] for t in (*times, *self.target.breaks(end))]
        return self.measure, min(values), max(values)

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
        filtered = self.kd != 0.0 and self.rate is None
        states = (*(("integral",) if self.ki != 0.0 else ()), *(("filter",) if filtered else ()))
        loads, n = () if self.load is None else (name_of(self.load),), len(states)
        given = self.name, pid_law, self.numbers(), tuple(inputs), loads, ("output",), states, (0.0,) * n
        return ControlContribution(*given, self.sample, ("",) * n, ("",), (n - 1,) if filtered else ())
