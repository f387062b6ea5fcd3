"""A machine of a study, and the cases of it: model, speed, clearance, friction, steps."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from flexmb import checks
from flexmb.model.mechanism import Mechanism
from flexmb.step.newmark.method import Newmark
from flexmb.step.step_size import Adaptive, FixedStep
from flexmb.study.drawing import Observable, Quantity

MODELS = ("ideal", "rigid", "flexible")
"""Rigid links without clearance; rigid links with clearance; beams with clearance."""

PLAY_MODELS = ("rigid", "flexible")

JOINT_CURVES = ("normal_force", "penetration", "ex", "ey", "vex", "vey")
"""Signals of the joint with clearance that are kept at every step."""

USUAL_RTOL = 1e-4
"""Accepted error of a step in velocities, relative, where a case gives none."""

FEWEST_STEPS = 1000
"""Steps of a turn at least, so that smooth peaks are met, too."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Machine:
    """The mechanism of a study: how its cases are made, and which of their signals are looked at.

    Parameters
    ----------
    make : returns the mechanism; called with the speed [rad/s] and with clearance, flexible, friction, elements, start,
        ramp and data.
    unit, short : unit of the speeds of cases, in texts ("pi rad/s") and in names ("pi").
    factor : that unit [rad/s].
    turn : time of a turn at the speed 1 [s].
    drives : the driven bodies in words, "cranks".
    joint : name of the joint with clearance.
    quantities : drawn signals, by name, in their order.
    peaks : signals whose largest absolute value of a turn is measured.
    observables : places and velocities of sections and phase diagrams.
    laws : friction laws by name, the usual one first.
    clearance : usual clearance [m].
    elements : usual number of beam elements of a link.
    ramp : turns in which the drives get from rest to their speed; 0: they start at full speed.
    longest : longest step [s].
    cost : about the processor time of a turn by model [s].
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
        """Signals that are kept at every step, those of the joint with clearance last."""
        joint = tuple(f"{self.joint}.{name}" for name in JOINT_CURVES)
        return (*(name for name in self.quantities if name not in joint), *joint)

    @property
    def places(self) -> tuple[str, ...]:
        """Signals through which exponents and verdicts are looked for."""
        return tuple(observable.place for observable in self.observables)


@dataclass(frozen=True, kw_only=True)
class Case:
    """One mechanism of a study.

    Parameters
    ----------
    machine : what all cases of the study have in common.
    model : "ideal", "rigid" or "flexible".
    speed : of the drives [unit of the machine].
    clearance : of the joint [m]; an ideal mechanism has none, whatever is given; None: the usual one.
    friction : name of a law of the machine; "": the usual one.
    elements : beam elements of each link; None: the usual number.
    start : position of the drives at the start, as the machine takes it [rad]; None: its default.
    data : numbers of the mechanism; None: its defaults.
    ramp : turns in which the drives get from rest to their speed; those of an ideal mechanism start at full speed;
        None: the usual ones.
    longest : longest step [s]; None: the usual one.
    impact_steps : steps that an impact gets at least; None: as the tolerance asks for.
    rtol : accepted error of a step in velocities, relative; None: 1e-4.
    method, step : another method with fixed steps [s] in place of generalised-alpha; None: that.
    label : unusual numbers in short, for the name: "J7=3.802e-3".

    Raises
    ------
    InputError : values out of range or of the wrong kind.
    """

    machine: Machine = field(repr=False)
    model: str
    speed: float
    clearance: float | None = None
    friction: str = ""
    elements: int | None = None
    start: Any = None
    data: Any = None
    ramp: float | None = None
    longest: float | None = None
    impact_steps: int | None = None
    rtol: float | None = None
    method: Any = None
    step: float | None = None
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
        """Name for files and legends: "flexible-2pi-0.5mm"; usual values are left out."""
        machine = self.machine
        play = "" if self.model == "ideal" else f"-{1e3 * self.clearance:.4g}mm"
        law = "" if self.friction == next(iter(machine.laws)) else f"-{self.friction}"
        unusual = self.model == "flexible" and self.elements != machine.elements
        mesh = f"-{self.elements}elements" if unusual else ""
        label = f"-{self.label}" if self.label else ""
        return f"{self.model}-{self.speed:.5g}{machine.short}{play}{law}{mesh}{label}"

    @property
    def accuracy(self) -> str:
        """End of the names of runs: unusual tolerance and method."""
        tolerance = "" if self.rtol is None else f"-rtol{self.rtol:g}"
        return tolerance + ("" if self.method is None else f"-{type(self.method).__name__.lower()}{self.step:g}")

    @property
    def cost(self) -> float:
        """About the processor time of a turn [s]."""
        finer = (self.elements / self.machine.elements) ** 1.5
        return self.machine.cost[self.model] * finer * ((self.rtol or USUAL_RTOL) / USUAL_RTOL) ** (-1.0 / 3.0)

    @property
    def solver(self) -> dict[str, Any]:
        """Step and method, as `simulate` takes them."""
        if self.method is not None:
            return {"step": FixedStep(self.step), "method": self.method}
        return {"step": self.steps, "method": Newmark.generalised_alpha()}

    @property
    def steps(self) -> Adaptive:
        """Adaptive steps."""
        tolerance = {} if self.rtol is None else {"rtol": self.rtol}
        longest = min(self.period / FEWEST_STEPS, self.longest)
        return Adaptive(max=longest, impact_steps=self.impact_steps, **tolerance)

    def mechanism(self) -> Mechanism:
        """The mechanism of this case."""
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
