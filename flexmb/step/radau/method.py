"""Radau's method of order 5 (Radau IIA, three stages) with error control: for smooth and for stiff motion."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from flexmb.energy.balance import SETTLED, verdict
from flexmb.energy.contact_work import contact_losses
from flexmb.kernels import compiled, copy
from flexmb.program.program import Program
from flexmb.program.tables import COMMON_Z
from flexmb.state.options import Options
from flexmb.state.record import BUFFER_FULL, DONE, NOTHING_KNOWN, RUNNING, STEP_TOO_SMALL
from flexmb.step.acceptance import (
    count_row,
    finished,
    is_due,
    keep,
    next_due,
    next_size,
    note_peaks,
    publish,
    take_over,
)
from flexmb.step.contact_events import planned, remember
from flexmb.step.contact_log import follow_contacts, no_room
from flexmb.step.method import Method
from flexmb.step.newmark.error_control import TURNS, judged, met, resize
from flexmb.step.newmark.jacobian_reuse import forget_factors
from flexmb.step.newmark.predictor import forget_past
from flexmb.step.newmark.redundant_constraints import settle
from flexmb.step.radau.collocation import AT_START, LAST, STAGES, C, collocation
from flexmb.step.radau.step import radau_error, radau_step
from flexmb.step.radau.works import add_works, book_works, find_between, ledger_at
from flexmb.step.stepper import Stepper
from flexmb.system.constraints import report_forces
from flexmb.system.contacts import find_gap
from flexmb.system.evaluate import evaluate_accepted
from flexmb.system.outputs import write_outputs
from flexmb.system.work import LOSS_FRICTION, LOSS_NORMAL

if TYPE_CHECKING:
    from flexmb.model.mechanism import Mechanism
    from flexmb.run.run import Run

GROWS, SHRINKS, SAFE = 4.0, 0.2, 0.9
"""A step becomes at most and at least these parts of the one before, and this part of what the estimate allows."""

SMOOTH, WITH_CONTACTS = 100.0, 100.0
"""Largest steps in a period or a run, without clearance and with it."""

KEPT = ("past", "past_lam", "real", "re", "im")
"""Arrays that a restart needs."""


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
    accelerations at its ends; forces there satisfy the equations of motion, or are interpolated where they are
    stiff.  Peaks are those of the steps and of the saved instants.  Works are integrated with fourth order, so what the
    method takes shows in `energy.residual`; `energy.dissipated_algorithm` is 0.  Histories of laws (bristles of LuGre's
    friction) are of the order that their law has.

    Source: E. Hairer, G. Wanner, Solving Ordinary Differential Equations II (Springer, 1996), IV.8, VI.3, VII.4.

    Examples
    --------
    >>> import flexmb as fm
    >>> mech = fm.slider_crank()
    >>> sol = fm.simulate(mech, t_end=0.01, method=fm.RadauIIA(), step=fm.Adaptive(rtol=1e-8))
    >>> sol.ok
    True
    """

    estimates_error: ClassVar[bool] = True

    def fewest_steps(self, *, contacts: bool) -> float:
        """Steps in a period or a run that error control takes at least, with `contacts` or without."""
        return WITH_CONTACTS if contacts else SMOOTH

    def stepper(self, program: Program, mechanism: Mechanism | None = None) -> Stepper:  # noqa: ARG002 - see `Staggered`
        """Stepper of the compiled mechanism."""
        return RadauStepper(program)


class RadauStepper(Stepper):
    """Steps of Radau's method.

    Parameters
    ----------
    program : the compiled mechanism.
    """

    def __init__(self, program: Program) -> None:
        super().__init__(program)
        self.stages = collocation(program)

    def advance(self, run: Run, options: Options, steps: int) -> int:
        """Take at most `steps` steps: the code of the ending."""
        return advance_radau(*run.arguments(options), self.stages, steps)

    def save(self, run: Run, options: Options) -> None:
        """Go on with the instants that the last step passed."""
        save_between(*run.arguments(options), self.stages)

    def saved(self) -> dict[str, np.ndarray]:
        """Stages and factors that the next step is predicted from."""
        kept = {f"radau.{name}": getattr(self.stages, name).copy() for name in KEPT}
        return {**kept, "radau.step": self.stages.step.numbers()}

    def restore(self, restart: Mapping[str, Any]) -> None:
        """Take what `saved` gave; without it, as from another method, the next step is a first one."""
        if "radau.step" not in restart:
            self.stages.step.last = 0.0
            return
        for name in KEPT:
            array = getattr(self.stages, name)
            if np.shape(restart.get(f"radau.{name}")) != array.shape:
                raise ValueError(f"radau.{name}")
            array[:] = restart[f"radau.{name}"]
        self.stages.step.set_numbers(np.asarray(restart["radau.step"]))


@compiled
def advance_radau(tables, address, lu, options, flow, trial, work, record, R, steps):
    """At most `steps` steps; the code of the ending."""
    forget_factors(flow.reuse)
    forget_past(flow.prediction)
    for _ in range(steps):
        if finished(options, flow):
            return DONE
        h = planned(tables, address, options, flow, trial, work) if options.adaptive else flow.clock.size
        h = next_size(h, options.t_end - flow.clock.t)
        if flow.clock.last == 0.0:
            R.step.last = R.step.factored = 0.0
        code = radau_step(tables, address, lu, h, options, flow, trial, work, record, R)
        record.count.known = NOTHING_KNOWN
        growth, anew = 1.0, False
        if options.adaptive:
            error = -1.0
            part = felt_within(tables, address, flow, trial, work, R) if code == RUNNING else 0.0
            if part > 0.0 and flow.clock.refused < TURNS:
                flow.clock.again, record.count.contact = 0.5 * part * h, 0
            elif met(tables, address, code, h, options, flow, trial, work, record):
                error = radau_error(tables, address, lu, h, options, flow, trial, work, R)
            growth = min(max(SAFE * max(error, 1e-12) ** -0.25, SHRINKS), GROWS)
            growth = judged(tables, h, error, growth, options, flow, trial, record)
            code = STEP_TOO_SMALL if code == RUNNING and growth == 0.0 else code
        if code != RUNNING:
            if h <= 1.001 * options.h_min:
                return code
            continue
        if record.count.outcome != 0 or flow.clock.held_steps > 0.0:
            settle(tables, lu, flow.clock.t + h, flow, trial, work, record)
        if options.adaptive:
            anew = remember(tables, address, h, options, flow, trial, work)
            resize(h, growth, options, flow)
        code = accept_stages(tables, address, lu, h, options, flow, trial, work, record, R)
        R.step.last = flow.clock.last = 0.0 if anew else h
        if code != RUNNING:
            return code
    return RUNNING


@compiled
def felt_within(tables, address, flow, trial, work, R):
    """Part of the step at which a stage is in a contact that is open at both of its ends; 0 if there is none.

    Its force has then turned the motion back, or slowed it down, as if the contact had been met.
    """
    K = tables.contacts
    for c in range(K.kernel.shape[0]):
        if flow.z[K.z[c, COMMON_Z]] != 0.0:
            continue
        gap, _ = find_gap(tables, address, c, trial.q, trial.v, work)
        if gap <= 0.0:
            continue
        for stage in range(LAST):
            gap, _ = find_gap(tables, address, c, R.Q[stage], R.V[stage], work)
            if gap <= 0.0:
                return C[stage]
    return 0.0


@compiled
def accept_stages(tables, address, lu, h, options, flow, trial, work, record, R):
    """Make the trial state the accepted one: `finish.accept` with works from the stages and instants between them."""
    t0 = flow.clock.t
    keep_start(h, flow, R)
    add_works(tables, address, lu, h, options, flow, trial, work, record, R)
    contact_losses(tables, address, 0.0, flow, trial.q, trial.v, work)
    turned = abs(R.works.damping) + R.works.joints_size + R.works.brought
    for c in range(R.losses.shape[0]):
        normal, friction = R.losses[c, LOSS_NORMAL], R.losses[c, LOSS_FRICTION]
        work.loss[c, LOSS_NORMAL], work.loss[c, LOSS_FRICTION] = normal, friction
        turned += abs(normal) + abs(friction)
    follow_contacts(tables, h, options, flow, work, record)
    book_works(tables, address, t0 + h, turned, flow, trial, work, R)
    take_over(h, flow, trial, work, record)
    write_outputs(tables, address, flow.clock.t, flow.q, flow.v, flow.a, work, flow.ledger, record.new)
    if options.save_interval == 0.0:
        if publish(tables, options, flow, record) != RUNNING:
            return BUFFER_FULL
    else:
        note_peaks(flow.clock.t, record.new, record)
        full = save_between(tables, address, lu, options, flow, trial, work, record, R) != RUNNING
        if full or no_room(flow, record):
            return BUFFER_FULL
    return verdict(flow.ledger, flow.account) if flow.account.steps >= SETTLED else RUNNING


@compiled
def keep_start(h, flow, R):
    """Note the start of the step, and the stages that the next one is predicted from."""
    old = R.old
    R.step.began, R.step.size = flow.clock.t, h
    copy(flow.q, old.q)
    copy(flow.v, old.v)
    copy(flow.a, old.a)
    copy(flow.z, old.z)
    copy(flow.lam, old.lam)
    copy(flow.ledger, old.ledger)
    copy(flow.a, R.past[0])
    copy(flow.lam, R.past_lam[AT_START])
    for stage in range(STAGES):
        copy(R.A[stage], R.past[stage + 1])
        copy(R.L[stage], R.past_lam[stage + 1])


@compiled
def save_between(tables, address, lu, options, flow, trial, work, record, R):
    """Write the instants of the save grid that the last step passed; BUFFER_FULL when the buffer is to be emptied.

    Then it is called again before the next step.
    """
    while is_due(options, flow, record):
        due, row = next_due(options, flow), record.count.rows
        s = (due - R.step.began) / R.step.size
        if s < 1.0 - 1e-9:
            signals_at(tables, address, lu, s, options, flow, trial, work, record, R, R.signals)
            note_peaks(due, R.signals, record)
            keep(R.signals, record, row)
        else:
            keep(record.new, record, row)
        count_row(due, flow, record)
    return BUFFER_FULL if record.count.rows >= record.times.shape[0] else RUNNING


@compiled
def signals_at(tables, address, lu, s, options, flow, trial, work, record, R, target):
    """All signals at the fraction s of the last step."""
    h, old, now, began = R.step.size, R.old, R.between, R.step.began
    copy(flow.z, now.z)
    copy(old.z, flow.z)
    t, q, v, a, lam = began + s * h, flow.q, flow.v, flow.a, flow.lam
    find_between(tables, address, lu, began, s, h, q, v, a, lam, options, flow, trial, work, record, R)
    evaluate_accepted(tables, address, t, s * h, trial.q, trial.v, trial.a, trial.lam, flow.z, R.zero, R.zero, work)
    copy(now.z, flow.z)
    report_forces(tables, trial.lam, work)
    ledger_at(s, h, old.ledger, R.rates, flow, work, now.ledger)
    write_outputs(tables, address, t, trial.q, trial.v, trial.a, work, now.ledger, target)
