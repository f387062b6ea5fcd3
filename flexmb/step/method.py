"""Base of the integration methods: a frozen record of numbers that makes the `Stepper` of a model."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from flexmb import arguments
from flexmb.errors import InputError
from flexmb.program.program import Program
from flexmb.step.step_size import LARGEST_STEPS, SMOOTH_STEPS, Adaptive, FixedStep

if TYPE_CHECKING:
    from flexmb.model.mechanism import Mechanism
    from flexmb.step.stepper import Stepper


@dataclass(frozen=True)
class Method(metaclass=arguments.CheckedType):
    """Base of `Newmark`, `RungeKutta4`, `RadauIIA`, and of methods of users as in examples/nine_bar_study.

    A further method derives from this class and returns its `Stepper` in `stepper`.  Class variables:
    `estimates_error`, whether the method estimates the error of a step; `has_tangent`, whether its steps can be
    linearised for tangent vectors; `independent`, whether the method needs independent constraint equations.
    """

    estimates_error: ClassVar[bool] = False
    has_tangent: ClassVar[bool] = False
    independent: ClassVar[bool] = False

    @property
    def loops(self) -> tuple[Any, ...]:
        """Compiled loops with annotated arguments; a second process may compile them (`flexmb/compiled/ahead.py`)."""
        return ()

    def stepper(self, program: Program, mechanism: Mechanism | None = None) -> Stepper:
        """Stepper of a compiled mechanism; most methods need `program` only."""
        raise NotImplementedError

    def fewest_steps(self, *, contacts: bool) -> float:
        """Least number of steps in a period or a run under error control, with `contacts` or without."""
        return LARGEST_STEPS if contacts else SMOOTH_STEPS

    def check(self, label: str, step: FixedStep | Adaptive, redundant: str) -> None:
        """Refuse steps and constraints that the method does not support.

        Parameters
        ----------
        label : first words of the messages.
        step : kind of steps.
        redundant : "refuse" or "least-norm", see `simulate`.

        Raises
        ------
        InputError : error-controlled steps without an error estimate; `redundant` "least-norm" with `independent`.
        """
        name = type(self).__name__
        if not self.estimates_error and not isinstance(step, FixedStep):
            raise InputError(f"{label}: {name} has no error estimate; give step=FixedStep(size).")
        if self.independent and redundant != "refuse":
            text = f"{label}: redundant is {redundant!r}"
            raise InputError(f"{text}; {name} needs independent joints. Use a Newmark method.")
