"""Machine and cases of a study: model, speed, clearance, friction, steps."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from nine_bar_study.drawing import Observable, Quantity

from flexmb import checks
from flexmb.engine.newmark.method import Newmark
from flexmb.engine.step.step_size import RTOL, Adaptive, FixedStep
from flexmb.model.mechanism import Mechanism

MODELS = ("ideal", "rigid", "flexible")
"""Models of a case: rigid links without clearance, rigid links with clearance, beams with clearance."""

PLAY_MODELS = ("rigid", "flexible")

JOINT_CURVES = ("normal_force", "penetration", "ex", "ey", "vex", "vey")
"""Signals of the joint with clearance that are saved at every step."""

USUAL: Any = None
"""Default of a field of `Case` whose value comes from the machine."""

FEWEST_STEPS = 1000
"""Least number of steps per turn, so that smooth peaks are resolved."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Machine:
    """Mechanism of a study: maker, unit of speed, joint with clearance, signals, defaults of its cases.

    Parameters
    ----------
    make : function that returns the mechanism; its arguments are the speed [rad/s], clearance, flexible, friction,
        elements, start, ramp and data.
    unit, short : unit of speeds in texts ("pi rad/s") and in names ("pi").
    factor : unit of speeds [rad/s].
    turn : period of the drives at speed 1 [s].
    drives : text of the driven bodies, "cranks".
    joint : name of the joint with clearance.
    quantities : quantities of the figures by signal, in order.
    peaks : signals whose largest absolute value in each turn is measured.
    observables : coordinates and velocities of sections and phase diagrams.
    laws : friction laws by name, the default first.
    clearance : default clearance [m].
    elements : default number of beam elements per link.
    ramp : turns in which the drives accelerate from rest to full speed; 0: start at full speed.
    longest : longest step [s].
    cost : approximate processor time of a turn by model [s].
    """

    make: Callable[..., Mechanism]
    unit: str
    short: str
    factor: float
    turn: float
    drives: str
    joint: str
    quantities: Mapping[str, Quantity]
    peaks: tuple[str, ...]
    observables: tuple[Observable, ...]
    laws: Mapping[str, Any]
    clearance: float
    elements: int
    ramp: float
    longest: float
    cost: Mapping[str, float]

    @property
    def curves(self) -> tuple[str, ...]:
        """Signals saved at every step, the signals of the joint with clearance last."""
        joint = tuple(f"{self.joint}.{name}" for name in JOINT_CURVES)
        return (*(name for name in self.quantities if name not in joint), *joint)

    @property
    def places(self) -> tuple[str, ...]:
        """Coordinates from which exponents and verdicts are computed."""
        return tuple(observable.place for observable in self.observables)


@dataclass(frozen=True, kw_only=True)
class Case:
    """One mechanism of a study with its speed, clearance, friction and steps.

    Parameters
    ----------
    machine : machine of the study.
    model : "ideal", "rigid" or "flexible".
    speed : speed of the drives [unit of the machine].
    clearance : clearance of the joint [m], unused by the model "ideal"; None: default of the machine.
    friction : name of a friction law of the machine; "": default of the machine.
    elements : beam elements per link; None: default of the machine.
    start : angles of the drives at the start, an argument of `Machine.make` [rad]; None: default of the mechanism.
    data : data of the mechanism; None: default of the mechanism.
    ramp : turns in which the drives accelerate from rest to full speed, unused by the model "ideal"; None: default of
        the machine.
    longest : longest step [s]; None: default of the machine.
    impact_steps : least number of steps in an impact; None: chosen by the step control.
    rtol : accepted relative error of a step in velocities; None: 1e-4.
    method, step : integration method and its fixed step [s]; None: generalised-alpha with adaptive steps.
    label : label of changed numbers in the name of the case: "J7=3.802e-3".

    Raises
    ------
    InputError : a value out of range or of a wrong type.
    """

    machine: Machine = field(repr=False)
    model: str
    speed: float
    clearance: float = USUAL
    friction: str = ""
    elements: int = USUAL
    start: Any = None
    data: Any = None
    ramp: float = USUAL
    longest: float = USUAL
    impact_steps: int | None = None
    rtol: float | None = None
    method: Any = None
    step: float = USUAL
    label: str = ""

    def __post_init__(self) -> None:
        usual = {"clearance": self.machine.clearance, "friction": next(iter(self.machine.laws))}
        usual |= {name: getattr(self.machine, name) for name in ("elements", "ramp", "longest")}
        for name, value in usual.items():
            if getattr(self, name) in (None, "") or (self.model == "ideal" and name == "clearance"):
                object.__setattr__(self, name, value)
        checks.one_of("Case", "model", self.model, MODELS)
        checks.one_of("Case", "friction", self.friction, list(self.machine.laws))
        checks.positive("Case", "speed", self.speed, self.machine.unit)
        checks.positive("Case", "clearance", self.clearance, "m")
        checks.not_negative("Case", "ramp", self.ramp, "turns")
        checks.positive("Case", "longest", self.longest, "s")

    @property
    def period(self) -> float:
        """Period of the drives [s]."""
        return self.machine.turn / self.speed

    @property
    def name(self) -> str:
        """Name in files and legends: "flexible-2pi-0.5mm"; defaults are omitted."""
        machine = self.machine
        play = "" if self.model == "ideal" else f"-{1e3 * self.clearance:.4g}mm"
        law = "" if self.friction == next(iter(machine.laws)) else f"-{self.friction}"
        unusual = self.model == "flexible" and self.elements != machine.elements
        mesh = f"-{self.elements}elements" if unusual else ""
        label = f"-{self.label}" if self.label else ""
        return f"{self.model}-{self.speed:.5g}{machine.short}{play}{law}{mesh}{label}"

    @property
    def accuracy(self) -> str:
        """Suffix of the names of runs: tolerance and method; empty for the defaults."""
        tolerance = "" if self.rtol is None else f"-rtol{self.rtol:g}"
        return tolerance + ("" if self.method is None else f"-{type(self.method).__name__.lower()}{self.step:g}")

    @property
    def cost(self) -> float:
        """Approximate processor time of a turn [s]."""
        mesh: float = (self.elements / self.machine.elements) ** 1.5
        tolerance: float = ((self.rtol or RTOL) / RTOL) ** (-1.0 / 3.0)
        return self.machine.cost[self.model] * mesh * tolerance

    @property
    def solver(self) -> dict[str, Any]:
        """Arguments `step` and `method` of `simulate`."""
        if self.method is not None:
            return {"step": FixedStep(self.step), "method": self.method}
        return {"step": self.steps, "method": Newmark.generalised_alpha()}

    @property
    def steps(self) -> Adaptive:
        """Adaptive steps of the case: longest step, tolerance, steps in an impact."""
        tolerance = {} if self.rtol is None else {"rtol": self.rtol}
        longest = min(self.period / FEWEST_STEPS, self.longest)
        return Adaptive(max=longest, impact_steps=self.impact_steps, **tolerance)

    def mechanism(self) -> Mechanism:
        """Mechanism of the case."""
        given = {name: value for name, value in (("start", self.start), ("data", self.data)) if value is not None}
        soft = self.ramp and self.model != "ideal"
        return self.machine.make(
            self.machine.factor * self.speed,
            clearance=None if self.model == "ideal" else self.clearance,
            flexible=self.model == "flexible",
            friction=self.machine.laws[self.friction],
            elements=self.elements,
            ramp=self.ramp * self.period if soft else None,
            **given,
        )
