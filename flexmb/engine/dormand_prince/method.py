"""Method of Dormand and Prince of order 8 with error control, for motion that is smooth between contact events."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from flexmb.engine.compiled.records import fitting
from flexmb.engine.dormand_prince import step as stages
from flexmb.engine.dormand_prince.step import Stages
from flexmb.engine.newmark import error_control
from flexmb.engine.newmark.jacobian_reuse import discard_factors, update_held_multipliers
from flexmb.engine.radau.step import accept_works, complete_ledger
from flexmb.engine.state.record import BUFFER_FULL, DONE, NOT_EVALUATED, RUNNING, STEP_TOO_SMALL, Options
from flexmb.engine.step import acceptance
from flexmb.engine.step.contact_events import update_impacts
from flexmb.engine.step.method import Method, Stepper
from flexmb.engine.system.constraints import report_forces
from flexmb.engine.system.evaluate import evaluate_accepted
from flexmb.engine.system.outputs import write_outputs
from flexmb.errors import InputError
from flexmb.kernels import compiled, copy
from flexmb.program.program import BEGIN, END, FRICTION_Z, Program

if TYPE_CHECKING:
    from flexmb.engine.step.step_size import Adaptive
    from flexmb.model.mechanism import Mechanism
    from flexmb.run.run import Run

# Next step over the present one at most and at least.
LARGEST_GROWTH, LEAST_GROWTH = 6.0, 1.0 / 3.0
FAILED_GROWTH = 0.25  # next trial over one whose stages could not be computed
# Number of largest steps in a period or a run, without contacts and with contacts; of steps of an impact at least.
LEAST_STEPS, LEAST_STEPS_CONTACTS, IMPACT_STEPS = 50.0, 100.0, 6.0
NEAR_RTOL = 1e-2  # rtol from which on steps end as far from an onset as those of other methods, else nearer by as much


@compiled
def advance_dormand_prince(tables, address, lu, options, flow, trial, work, record, D: Stages, steps):
    """Take at most `steps` steps; RUNNING, or the code of the ending."""
    discard_factors(flow.reuse)
    record.count.evaluated = NOT_EVALUATED
    if steps == 0 and options.save_interval > 0.0:  # instants for which the buffer had no room
        return save_between(tables, address, lu, options, flow, trial, work, record, D)
    if D.span.foreign == 1:
        code = adopt_state(tables, address, lu, options, flow, trial, work, record, D)
        if code != RUNNING:
            return code
    for _ in range(steps):
        if acceptance.finished(options, flow):
            return DONE
        h = acceptance.step_to_try(tables, address, options, flow, trial, work)
        code, error = stages.try_step(tables, address, lu, h, options, flow, trial, work, record, D)
        growth = 1.0
        if options.adaptive:
            if code != RUNNING:
                error = -1.0
                error_control.shorten_step(h, FAILED_GROWTH, flow, record)
            growth = error_control.growth_factor(error, -0.125, LEAST_GROWTH, LARGEST_GROWTH)
            growth = error_control.accept_or_reject(h, error, growth, options, flow, trial, record)
            code = STEP_TOO_SMALL if code == RUNNING and growth == 0.0 else code
        if code != RUNNING:
            if h <= 1.001 * options.h_min:
                return code
            continue
        if record.count.held_code != 0 or flow.clock.held_steps > 0.0:
            update_held_multipliers(tables, lu, flow.clock.t + h, flow, trial, work, record)
        restarts = False
        if options.adaptive:
            restarts = update_impacts(tables, address, h, options, flow, trial, work)
            restarts = restarts or error_control.crosses_jump(tables, address, h, options, flow, trial, work, record)
            error_control.update_step_sizes(h, growth, options, flow)
        code = accept_stages(tables, address, lu, h, options, flow, trial, work, record, D)
        flow.clock.last_step = 0.0 if restarts else h
        if code != RUNNING:
            return code
    return RUNNING


@compiled
def adopt_state(tables, address, lu, options, flow, trial, work, record, D):
    """Compute accelerations and multipliers of the state of another method."""
    copy(flow.q, trial.q)
    copy(flow.v, trial.v)
    copy(flow.lam, trial.lam)
    t, h = flow.clock.t, options.h_min
    code = stages.find_accelerations(tables, address, lu, t, 0.0, h, options, flow, trial, work, record, D)
    copy(trial.a, flow.a)
    copy(trial.lam, flow.lam)
    D.span.foreign = 0
    return code


@compiled
def accept_stages(tables, address, lu, h, options, flow, trial, work, record, D):
    """Make the trial state the accepted one: `acceptance.accept`, with works and instants from the stages."""
    stages.add_works(tables, address, h, flow, trial, work, record, D)
    accept_works(tables, address, h, options, flow, trial, work, record, D)
    for s in D.crests:
        if s > 0.0 and find_signals(tables, address, lu, s, options, flow, trial, work, record, D) == RUNNING:
            acceptance.update_peaks(D.span.start + s * h, D.signals, record)
    return acceptance.ending(save_between(tables, address, lu, options, flow, trial, work, record, D), flow, record)


@compiled
def save_between(tables, address, lu, options, flow, trial, work, record, D):
    """Save the end of the last step, or the instants of the save grid within it; a code."""
    # BUFFER_FULL: the buffer must be emptied, and `save_between` called again before the next step. Other codes but
    # RUNNING: the state at an instant cannot be computed.
    s, code = acceptance.save_ends(options, flow, record), RUNNING
    while s < 1.0 and code == RUNNING:
        code = find_signals(tables, address, lu, s, options, flow, trial, work, record, D)
        if code == RUNNING:
            acceptance.update_peaks(acceptance.next_due(options, flow, record), D.signals, record)
            s = acceptance.save_within(D.signals, options, flow, record)
    return acceptance.buffer_code(record) if code == RUNNING else code


@compiled
def find_signals(tables, address, lu, s, options, flow, trial, work, record, D):
    """Set D.signals to all signals at fraction s of the last step; a code."""
    h, ledger, code = D.span.size, D.between.ledger, RUNNING
    copy(flow.z, D.between.z)
    copy(D.old.z, flow.z)  # histories of contacts are those at the start of the step
    if D.span.dense == 0:
        code = stages.find_dense_output(tables, address, lu, options, flow, trial, work, record, D)
    if code == RUNNING:
        code = stages.find_between(tables, address, lu, s, options, flow, trial, work, record, D)
    t, q, v, a, lam = D.span.start + s * h, trial.q, trial.v, trial.a, trial.lam
    evaluate_accepted(tables, address, t, s * h, q, v, a, lam, flow.z, D.zero, D.zero, work)
    copy(D.between.z, flow.z)
    report_forces(tables, lam, work)
    complete_ledger(flow, work, ledger)
    write_outputs(tables, address, t, q, v, a, work, ledger, record.peak, True, D.signals)
    return code


@dataclass(frozen=True)
class DormandPrince(Method):
    """Explicit method of Dormand and Prince of order 8(5,3), for motion that is smooth but for impacts.

    Twelve stages compute accelerations from the equations of motion and the joints in accelerations,

        M a + G^T lam = f(q, v, t),   G a = gamma(q, v, t);

    at the end of the step positions and velocities are projected onto the joints.  Errors of a run are proportional to
    rtol.  Saved instants within a step come from the dense output of order 7, projected as well, with forces and
    accelerations of the equations of motion there; stop conditions are located as by all methods.  Works of drives,
    dampers and loads are integrated with the stages.

    It is the fastest method for rigid mechanisms with ideal joints, drives, springs and smooth loads, and at equal
    accuracy with impacts, which take five steps or more: steps end at onset and separation, and peaks of normal forces
    are found between them.  Beams are stable, too, but their fastest wave bounds the step (6 over its angular
    frequency), which the error control finds: use `Newmark` for them and where contacts or friction are stiff (strong
    dampers, sticking), and `RadauIIA` for stiff springs.

    Raises
    ------
    InputError : laws with a history (friction with bristles, clutches).

    Notes
    -----
    Signals but normal forces and depths have their peaks at steps, saved instants and crests of large normal forces.
    Redundant joints and singular positions are held as by `RungeKutta4`.  `energy.dissipated_algorithm` is 0; what the
    method takes shows in `energy.residual`.

    Source: E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I (Springer, 1993), II.5, II.6.

    Examples
    --------
    >>> import flexmb as fm
    >>> mech = fm.mechanisms.slider_crank()
    >>> sol = fm.simulate(mech, t_end=0.01, method=fm.DormandPrince(), step=fm.Adaptive(rtol=1e-9))
    >>> sol.ok
    True
    """

    estimates_error: ClassVar[bool] = True
    loops: ClassVar[tuple[Any, ...]] = (advance_dormand_prince,)

    def fewest_steps(self, *, contacts: bool) -> float:
        """Steps in a period or a run that error control takes at least, with `contacts` or without."""
        return LEAST_STEPS_CONTACTS if contacts else LEAST_STEPS

    def impacts(self, step: Adaptive) -> tuple[float, float]:
        """Least number of steps of an impact under the error control `step`; factor of `ONSET_TOLERANCE`."""
        # A step from before an onset takes its first stages without the force, which the error estimate hardly sees.
        near = min(step.rtol / NEAR_RTOL, 1.0)
        return float(step.impact_steps or IMPACT_STEPS), near

    def stepper(self, program: Program, mechanism: Mechanism | None = None) -> Stepper:  # noqa: ARG002 - methods of users may
        """Stepper of the compiled mechanism."""
        label = f"simulate {program.name!r}: DormandPrince is for smooth motion, but"
        E, C, names = program.tables.elements, program.tables.constraints, program.names
        laws = [(names.rows[C.row[c]], C.joint_friction_z[c]) for c in range(len(C.kernel))]
        laws += zip(names.contacts, program.tables.contacts.z[:, FRICTION_Z:], strict=True)
        for name, z in (*zip(names.elements, E.z, strict=True), *laws):
            if z[END] > z[BEGIN]:
                text = f"{name!r} has a law with a history, which is integrated with its own low order"
                raise InputError(f"{label} {text}. Use Newmark.generalised_alpha() (the default) or RadauIIA().")
        return DormandPrinceStepper(program, stages.new_stages(program))


class DormandPrinceStepper(Stepper):
    """Steps of the method of Dormand and Prince."""

    def save(self, run: Run, options: Options) -> None:
        """Save the remaining instants within the last step."""
        code = int(advance_dormand_prince(*run.arguments(options), self.stages, 0))
        if code not in (RUNNING, BUFFER_FULL):
            run.code = code

    def saved(self) -> dict[str, np.ndarray]:
        """Mark of accelerations of this method."""
        return {"dormand_prince.span": self.stages.span.numbers()}

    def restore(self, restart: Mapping[str, Any]) -> None:
        """Restore the mark; a restart of another method has none."""
        span = self.stages.span
        span.foreign = int("dormand_prince.span" not in restart)
        if not span.foreign:
            span.set_numbers(fitting(restart, "dormand_prince.span", span.numbers()))
