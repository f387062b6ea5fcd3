"""DC motor: torque by a current, which a voltage drives."""

from __future__ import annotations

from dataclasses import KW_ONLY
from typing import Any

from flexmb import checks
from flexmb.errors import InputError
from flexmb.fields import Rule, field, not_negative, positive, record
from flexmb.kernels import control_kernel
from flexmb.model.contributions import ControlContribution, MotionInput
from flexmb.model.law import Motion
from flexmb.model.part import Controller, Part, name_of
from flexmb.parts.controllers.control import is_signal_name, signal

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
        delayed = self.inductance > 0.0
        return ControlContribution(
            self.name,
            dc_motor_law,
            (self.resistance, self.inductance, self.torque_constant, self.gear_ratio, number),
            tuple(inputs),
            (name_of(self.load),),
            ("torque", "voltage") if delayed else ("torque", "voltage", "current"),
            ("current",) if delayed else (),
            (self.current,) if delayed else (),
            None,
            ("A",) if delayed else (),
            ("N m", "V") if delayed else ("N m", "V", "A"),
        )
