"""Control: a controller with a law of one's own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY
from typing import Any

from flexmb import checks
from flexmb.errors import InputError
from flexmb.fields import Rule, field, number, record, several
from flexmb.kernels import CONTROL, Kernel
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
    A law that acts at all times must be continuous, with kinks (saturation, dead zone) at most; it is a part of the
    implicit step, and its tangent is found by differences.  Its inputs are functions of time, positions and velocities.
    A sampled law may jump, and may read all signals: they are those of the last accepted state.  Loads do work, which
    is booked as theirs (`energy.load_work`).

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
        return ControlContribution(
            self.name,
            self.law,
            tuple(self.numbers),
            tuple(MotionInput(one) if isinstance(one, Motion) else one for one in self.inputs),
            tuple(map(name_of, self.loads)),
            self.output_names,
            tuple(name for name, _ in self.states),
            tuple(value or 0.0 for _, value in self.states),
            None if self.sample is None else float(self.sample),
            ("",) * len(self.states),
            ("",) * len(self.output_names),
            tuple(k for k, (_, value) in enumerate(self.states) if value is None),
        )
