"""Limits of the steps of a run, from mechanism, method and span."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexmb.state.options import NEVER
from flexmb.state.trial import rigid_coordinates
from flexmb.step.step_size import FLIGHT_WEIGHT, FixedStep

if TYPE_CHECKING:
    from flexmb.run.run import Run


def step_limits(run: Run) -> tuple[float, float, float, tuple[float, ...]]:
    """Largest and smallest step [s], accepted error of a step [m], and the numbers of `StepControl`.

    The least speed crosses the mechanism in 100 runs or periods; with clearance, 100 clearances if these are less,
    so that the steps resolve a contact that comes to rest.
    """
    if isinstance(run.step, FixedStep):
        return run.step.size, run.step.size, NEVER, (1.0, 1.0, 1.0, 1.0)
    span = run.t_end if run.period is None else min(run.period, run.t_end)
    clearance, length, rtol = run.program.least_clearance, run.program.length, run.step.rtol
    steps = run.method.fewest_steps(contacts=clearance is not None)
    largest = run.step.max or span / steps
    flight, loose = (FLIGHT_WEIGHT, 2.0) if rigid_coordinates(run.program).all() else (1.0, 4.0)
    part = 1e-3 * length if clearance is None else loose * min(clearance, 1e-2 * length)
    way = length if clearance is None else min(length, 1e2 * clearance)
    bounds = (rtol, 1e-2 / steps * way / largest, run.step.steps_of_an_impact, flight)
    return largest, run.step.min or min(1e-9 * largest, 1e-12 * span), run.step.atol or rtol * part, bounds
