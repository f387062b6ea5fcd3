"""Methods of the Newmark family: implicit, of second order; their time loop, the same for every model."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar

from flexmb import checks
from flexmb.engine.newmark import error_control
from flexmb.engine.newmark.implicit_step import implicit_step
from flexmb.engine.newmark.jacobian_reuse import adopt_factors, update_held_multipliers
from flexmb.engine.newmark.predictor import update_predictor
from flexmb.engine.state.record import DONE, FORMS, NOT_EVALUATED, RUNNING, STEP_TOO_SMALL, Coefficients
from flexmb.engine.step.acceptance import accept, finished, step_to_try
from flexmb.engine.step.contact_events import update_impacts
from flexmb.engine.step.method import Method, Stepper
from flexmb.engine.step.step_size import SHORT_STEP
from flexmb.engine.system.outputs import write_extrema
from flexmb.fields import field, one_of, positive, record
from flexmb.kernels import compiled, copy
from flexmb.program.program import Program

if TYPE_CHECKING:
    from flexmb.model.mechanism import Mechanism

# Next step over the present one at most and at least.
LARGEST_GROWTH, LEAST_GROWTH = 2.0, 0.2


@compiled
def advance(tables, address, lu, options, flow, trial, work, record, steps):
    """Take at most `steps` implicit steps; RUNNING, or the code of the ending.  Diagram: `step/__init__.py`."""
    code = take_steps(tables, address, lu, options, flow, trial, work, record, steps)
    write_extrema(tables, address, flow.clock.t, flow.q, flow.v, flow.a, work, record.signals)
    return code


@compiled
def take_steps(tables, address, lu, options, flow, trial, work, record, steps):
    """Take the steps of `advance`; extrema of the last state may be left out."""
    # A trial that fails (Newton, singular, not finite) is tried again with h/4 (`meets_contacts`); with fixed steps, or
    # at the smallest step, its code ends the run; results/status.py has the sentence.
    for _ in range(steps):
        if finished(options, flow):
            return DONE
        h = step_to_try(tables, address, options, flow, trial, work)
        first = flow.clock.last_step == 0.0
        ratio = 1.0 if first else h / flow.clock.last_step
        scheme = options.first if first else options.regular
        code = implicit_step(tables, address, lu, h, ratio, scheme, options, flow, trial, work, record)
        growth, restarts = 1.0, False
        if options.adaptive:
            fits = error_control.meets_contacts(tables, address, code, h, options, flow, trial, work, record)
            error = error_control.error_ratio(tables, h, ratio, scheme, options, flow, trial) if fits else -1.0
            growth = error_control.growth_factor(error, -1.0 / 3.0, LEAST_GROWTH, LARGEST_GROWTH)
            growth = error_control.accept_or_reject(h, error, growth, options, flow, trial, record)
            code = STEP_TOO_SMALL if code == RUNNING and growth == 0.0 else code
        if code != RUNNING and h <= 1.001 * options.h_min:
            return code
        if code != RUNNING:
            continue
        for i in range(tables.sizes.n_q if first else 0):  # see `Newmark.starting`
            trial.x[i] = trial.a[i] + (options.regular.alpha_m - options.regular.alpha_f) * (trial.a[i] - flow.a[i])
        if record.count.held_code != 0 or flow.clock.held_steps > 0.0:
            update_held_multipliers(tables, lu, flow.clock.t + h, flow, trial, work, record)
            record.count.evaluated = NOT_EVALUATED  # multipliers may have changed
        adopt_factors(flow, trial, work)
        if options.adaptive:
            restarts = update_impacts(tables, address, h, options, flow, trial, work)
            restarts = restarts or error_control.crosses_jump(tables, address, h, options, flow, trial, work, record)
            error_control.update_step_sizes(h, growth, options, flow)
        else:
            restarts = h < SHORT_STEP * flow.clock.step_size
        update_predictor(tables, h, options.length, flow, trial, work)
        code = accept(tables, address, h, options, flow, trial, work, record, False)
        flow.clock.last_step = 0.0 if restarts else h
        if restarts:
            copy(flow.a, flow.x)
        if code != RUNNING:
            return code
    return RUNNING


# Methods of the Newmark family: implicit, of second order, for stiff and flexible mechanisms with contacts
@record
class Newmark(Method):
    """Newmark, HHT, WBZ and generalised-alpha as one implicit method.

        q1 = q0 + h v0 + h^2 ((1/2 - beta) x0 + beta x1),   v1 = v0 + h ((1 - gamma) x0 + gamma x1)
        (1 - alpha_m) x1 + alpha_m x0 = (1 - alpha_f) a1 + alpha_f a0

    where the true accelerations a and the multipliers satisfy the equations of motion at the ends of the steps, so
    both are of second order.  When the step changes, x is carried over as a + ratio (x - a), which keeps the order of
    the motion; joint forces fall to first order where the step changes all the time and nothing dissipates (radius 1).

    With `constraints` "gear-gupta-leimkuhler" positions and velocities hold together; "position": index 3; "velocity":
    index 2, positions drift.  Measured: docs/decisions/017-form-of-the-constraints.md.

    Equations (4.1), (4.2) and (4.6) of docs/theory/integrators.md.

    Raises
    ------
    InputError : numbers that are not finite, an unknown form of the constraints.

    Notes
    -----
    Sources: N. M. Newmark, J. Eng. Mech. Div. ASCE 85 (1959) 67-94; J. Chung, G. M. Hulbert, J. Appl. Mech. 60 (1993)
    371-375; M. Arnold, O. Bruls, Multibody Syst. Dyn. 18 (2007) 185-202 (the form with true accelerations).
    """

    estimates_error: ClassVar[bool] = True
    loops: ClassVar[tuple[Any, ...]] = (advance,)

    alpha_m: float = field("weight of the acceleration x0 beside x1", default=0.0)
    alpha_f: float = field("weight of the true acceleration a0 beside a1", default=0.0)
    beta: float = field("Newmark's number of the positions", rule=positive, default=0.25)
    gamma: float = field("Newmark's number of the velocities", default=0.5)
    constraints: str = field("form of the constraints, see above", rule=one_of(*FORMS), default="gear-gupta-leimkuhler")

    @property
    def has_tangent(self) -> bool:
        """Whether the steps can carry differences, which steps of a derived class can not."""
        return type(self).stepper is Newmark.stepper

    @cached_property
    def starting(self) -> Newmark:
        """Coefficients of a starting step.

        x stands for the acceleration at a time Delta h later, Delta = alpha_m - alpha_f.  With x0 = a0 the multipliers
        would begin with an error of first order.  x0 = a0 + Delta (a1 - a0) turns the method into a plain Newmark step
        with gamma = 1/2, beta = (1 + Delta^2)/4, whatever its own numbers; after it x = a1 + Delta (a1 - a0).

        Equations (4.4) and (4.5) of docs/theory/integrators.md.
        """
        delta = self.alpha_m - self.alpha_f
        return replace(self, alpha_m=0.0, alpha_f=0.0, beta=0.25 * (1.0 + delta * delta), gamma=0.5)

    @classmethod
    def trapezoidal(cls, constraints: str = "gear-gupta-leimkuhler") -> Newmark:
        """The trapezoidal rule: beta = 1/4, gamma = 1/2, no dissipation.

        Parameters
        ----------
        constraints : see the class.
        """
        return cls(constraints=constraints)

    @classmethod
    def hht(cls, alpha: float = 0.1, constraints: str = "gear-gupta-leimkuhler") -> Newmark:
        """Hilber, Hughes, Taylor with 0 <= alpha <= 1/3.

        Parameters
        ----------
        alpha : weight of the old forces.
        constraints : see the class.
        """
        checks.between("Newmark.hht", "alpha", alpha, 0.0, 1.0 / 3.0)
        return cls(0.0, alpha, (1.0 + alpha) ** 2 / 4.0, 0.5 + alpha, constraints)

    @classmethod
    def wbz(cls, alpha: float = 0.1, constraints: str = "gear-gupta-leimkuhler") -> Newmark:
        """Wood, Bossak, Zienkiewicz with 0 <= alpha <= 1/3.

        Parameters
        ----------
        alpha : weight of the old accelerations, taken negative.
        constraints : see the class.
        """
        checks.between("Newmark.wbz", "alpha", alpha, 0.0, 1.0 / 3.0)
        return cls(-alpha, 0.0, (1.0 + alpha) ** 2 / 4.0, 0.5 + alpha, constraints)

    @classmethod
    def generalised_alpha(cls, radius: float = 0.8, constraints: str = "gear-gupta-leimkuhler") -> Newmark:
        """Chung and Hulbert: least dissipation at low frequencies for a given spectral radius at infinity.

        Equation (4.3) of docs/theory/integrators.md.

        Parameters
        ----------
        radius : spectral radius at infinite frequency, 0 (annihilation) to 1 (no dissipation).
        constraints : see the class.
        """
        checks.between("Newmark.generalised_alpha", "radius", radius, 0.0, 1.0)
        alpha_m, alpha_f = (2.0 * radius - 1.0) / (radius + 1.0), radius / (radius + 1.0)
        return cls(alpha_m, alpha_f, (1.0 - alpha_m + alpha_f) ** 2 / 4.0, 0.5 - alpha_m + alpha_f, constraints)

    @cached_property
    def coefficients(self) -> Coefficients:
        """The numbers for the compiled loop."""
        return Coefficients(self.alpha_m, self.alpha_f, self.beta, self.gamma)

    def stepper(self, program: Program, mechanism: Mechanism | None = None) -> Stepper:  # noqa: ARG002 - methods of users may
        """Stepper of the compiled mechanism."""
        return NewmarkStepper(program, self)


class NewmarkStepper(Stepper):
    """Implicit steps of the Newmark family."""

    def __init__(self, program: Program, method: Newmark) -> None:
        super().__init__(program)
        self.form = FORMS[method.constraints]
        self.regular, self.first = method.coefficients, method.starting.coefficients
