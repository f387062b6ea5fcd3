"""Radau's method of order 5 (Radau IIA, three stages) with error control, for smooth and for stiff motion."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from flexmb.engine.compiled.records import fitting
from flexmb.engine.newmark import error_control
from flexmb.engine.newmark.jacobian_reuse import discard_factors, remove_along, update_held_multipliers
from flexmb.engine.newmark.predictor import restart_predictor
from flexmb.engine.radau import step as stages
from flexmb.engine.radau.collocation import AT_END, AT_START, LAST, STAGES, C, Collocation, collocation
from flexmb.engine.state.record import DONE, NOT_EVALUATED, RUNNING, STEP_TOO_SMALL, Options
from flexmb.engine.step import acceptance
from flexmb.engine.step.contact_events import update_impacts
from flexmb.engine.step.method import Method, Stepper
from flexmb.engine.system.constraints import report_forces
from flexmb.engine.system.evaluate import evaluate_accepted
from flexmb.engine.system.outputs import write_outputs
from flexmb.kernels import compiled, copy
from flexmb.program.program import Program

if TYPE_CHECKING:
    from flexmb.model.mechanism import Mechanism
    from flexmb.run.run import Run

# Next step over the present one at most and at least.
LARGEST_GROWTH, LEAST_GROWTH = 4.0, 0.2
# Number of largest steps in a period or a run, without contacts and with contacts.
LEAST_STEPS, LEAST_STEPS_CONTACTS = 100.0, 100.0
RESTART_ARRAYS = ("past", "past_lam", "real", "re", "im", "inertia")  # arrays of `Collocation` for a restart


@compiled
def advance_radau(tables, address, lu, options, flow, trial, work, record, R: Collocation, steps):
    """Take at most `steps` steps; RUNNING, or the code of the ending."""
    discard_factors(flow.reuse)
    restart_predictor(flow.predictor)
    if steps == 0 and options.save_interval > 0.0:  # instants for which the buffer had no room
        return save_between(tables, address, lu, options, flow, trial, work, record, R)
    for _ in range(steps):
        if acceptance.finished(options, flow):
            return DONE
        h = acceptance.step_to_try(tables, address, options, flow, trial, work)
        if flow.clock.last_step == 0.0:
            R.step.last = R.step.factored_size = 0.0
        code = stages.radau_step(tables, address, lu, h, options, flow, trial, work, record, R)
        record.count.evaluated = NOT_EVALUATED
        growth, restarts = 1.0, False
        if options.adaptive:
            error, Q, V = -1.0, R.Q[:LAST], R.V[:LAST]
            if error_control.meets_events(tables, address, code, h, Q, V, C, options, flow, trial, work, record):
                error = stages.radau_error(tables, address, lu, h, options, flow, trial, work, record, R)
            growth = error_control.growth_factor(error, -0.25, LEAST_GROWTH, LARGEST_GROWTH)
            growth = error_control.accept_or_reject(h, error, growth, options, flow, trial, record)
            code = STEP_TOO_SMALL if code == RUNNING and growth == 0.0 else code
        if code != RUNNING:
            if h <= 1.001 * options.h_min:
                return code
            continue
        if record.count.held_code != 0 or flow.clock.held_steps > 0.0:
            update_held_multipliers(tables, lu, flow.clock.t + h, flow, trial, work, record)
            remove_free_components(trial, R)
        if options.adaptive:
            restarts = update_impacts(tables, address, h, options, flow, trial, work)
            restarts = restarts or error_control.crosses_jump(tables, address, h, options, flow, trial, work, record)
            error_control.update_step_sizes(h, growth, options, flow)
        code = accept_stages(tables, address, lu, h, options, flow, trial, work, record, R)
        R.step.last = flow.clock.last_step = 0.0 if restarts else h
        if code != RUNNING:
            return code
    return RUNNING


@compiled
def accept_stages(tables, address, lu, h, options, flow, trial, work, record, R):
    """Make the trial state the accepted one: `acceptance.accept`, with works and instants from the stages."""
    # The start of the step, and the stages for the prediction of the next step.
    R.step.start, R.step.size = flow.clock.t, h
    stages.keep_state(flow, R.old)
    copy(flow.a, R.past[0])
    copy(flow.lam, R.past_lam[AT_START])
    for stage in range(STAGES):
        copy(R.A[stage], R.past[stage + 1])
        copy(R.L[stage], R.past_lam[stage + 1])
    stages.add_works(tables, address, lu, h, options, flow, trial, work, record, R)
    stages.accept_works(tables, address, h, options, flow, trial, work, record, R)
    return acceptance.ending(save_between(tables, address, lu, options, flow, trial, work, record, R), flow, record)


@compiled
def remove_free_components(trial, R):
    """Removal of shares that the equations leave free, which extrapolation lets grow, from the stages' multipliers."""
    for row in range(trial.free_multipliers.shape[0]):
        for stage in range(STAGES):
            remove_along(trial.free_multipliers[row], R.L[stage])


@compiled
def save_between(tables, address, lu, options, flow, trial, work, record, R):
    """Save the end of the last step, or the instants of the save grid within it; BUFFER_FULL for a full buffer."""
    # The buffer must then be emptied, and `save_between` called again before the next step.
    s = acceptance.save_ends(options, flow, record)
    while s < 1.0:
        # All signals at fraction s of the last step.
        h, old, now, began = R.step.size, R.old, R.between, R.step.start
        copy(flow.z, now.z)
        copy(old.z, flow.z)
        t, q, v, a, lam = began + s * h, flow.q, flow.v, flow.a, flow.lam
        stages.find_between(tables, address, lu, began, s, h, q, v, a, lam, options, flow, trial, work, record, R)
        evaluate_accepted(tables, address, t, s * h, trial.q, trial.v, trial.a, trial.lam, flow.z, R.zero, R.zero, work)
        copy(now.z, flow.z)
        report_forces(tables, trial.lam, work)
        # Ledger: cubics through works and powers at both ends; energies of the state.
        ledger, rates = now.ledger, R.rates
        rise, begin, end = s * s * (3.0 - 2.0 * s), h * s * (1.0 - s) ** 2, h * s * s * (s - 1.0)
        for i in range(ledger.shape[0]):
            change = rise * (flow.ledger[i] - old.ledger[i])
            ledger[i] = old.ledger[i] + change + begin * rates[AT_START, i] + end * rates[AT_END, i]
        stages.complete_ledger(flow, work, ledger)
        write_outputs(tables, address, t, trial.q, trial.v, trial.a, work, ledger, record.peak, True, R.signals)
        acceptance.update_peaks(acceptance.next_due(options, flow, record), R.signals, record)
        s = acceptance.save_within(R.signals, options, flow, record)
    return acceptance.buffer_code(record)


@dataclass(frozen=True)
class RadauIIA(Method):
    """Radau's implicit method with three stages: order 5, for smooth motion to many digits, stiff or not.

    At the stages t + c_i h the positions Q_i and velocities V_i = v0 + h sum a_ij A_j satisfy the equations of motion
    and the joints in velocities,

        M A_i + G^T lam_i = f(Q_i, V_i),   G V_i + g_t = 0,   Q_i = q0 + h sum a_ij V_j;

    at the end of the step (c_3 = 1) positions and velocities are projected onto the joints, and accelerations and
    multipliers follow from the equations of motion.  Steps are chosen by an embedded formula of order 3.

    A step costs some five of `Newmark`.  It pays where the motion is smooth between impacts and more digits are wanted
    than rtol = 1e-4 gives: mechanisms with ideal joints, drives, springs, rigid contacts with few impacts, soft beams.
    Where beams ring with frequencies that no one asks for, or contacts never end, `Newmark` is faster.

    Notes
    -----
    Instants of the grid of saved signals within a step come from the quintic through positions, velocities and
    accelerations at its ends, and forces there satisfy the equations of motion; where these are stiff, both are
    interpolated through the stages.  Peaks are those of the steps and of the saved instants.  Works are integrated with
    fourth order, so what the method takes shows in `energy.residual`; `energy.dissipated_algorithm` is 0.  Histories of
    laws (bristles of LuGre's friction) are of the order that their law has; the error estimate sees those of friction,
    and their errors in a run fall with rtol^(1/2).

    Source: E. Hairer, G. Wanner, Solving Ordinary Differential Equations II (Springer, 1996), IV.8, VI.3, VII.4.

    Examples
    --------
    >>> import flexmb as fm
    >>> mech = fm.mechanisms.slider_crank()
    >>> sol = fm.simulate(mech, t_end=0.01, method=fm.RadauIIA(), step=fm.Adaptive(rtol=1e-8))
    >>> sol.ok
    True
    """

    estimates_error: ClassVar[bool] = True
    loops: ClassVar[tuple[Any, ...]] = (advance_radau,)

    def fewest_steps(self, *, contacts: bool) -> float:
        """Steps in a period or a run that error control takes at least, with `contacts` or without."""
        return LEAST_STEPS_CONTACTS if contacts else LEAST_STEPS

    def stepper(self, program: Program, mechanism: Mechanism | None = None) -> Stepper:  # noqa: ARG002 - methods of users may
        """Stepper of the compiled mechanism."""
        return RadauStepper(program, collocation(program))


class RadauStepper(Stepper):
    """Steps of Radau's method."""

    def save(self, run: Run, options: Options) -> None:
        """Save the remaining instants within the last step."""
        advance_radau(*run.arguments(options), self.stages, 0)

    def saved(self) -> dict[str, np.ndarray]:
        """Stages and factors for the next step, by name."""
        kept = {f"radau.{name}": getattr(self.stages, name).copy() for name in RESTART_ARRAYS}
        return {**kept, "radau.step": self.stages.step.numbers()}

    def restore(self, restart: Mapping[str, Any]) -> None:
        """Restore the arrays of `saved`; without all of them (another method or version) a starting step comes next."""
        step = self.stages.step
        if any(f"radau.{name}" not in restart for name in (*RESTART_ARRAYS, "step")):
            step.last = 0.0
            return
        for name in RESTART_ARRAYS:
            array = getattr(self.stages, name)
            array[:] = fitting(restart, f"radau.{name}", array)
        step.set_numbers(fitting(restart, "radau.step", step.numbers()))
