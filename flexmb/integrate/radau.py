"""Radau's method of order 5 (Radau IIA, three stages) with error control: for smooth and for stiff motion."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from flexmb.integrate.arrays import BUFFER_FULL, DONE, NOTHING_KNOWN, RUNNING, STEP_TOO_SMALL, Options
from flexmb.integrate.collocation import AT_END, AT_START, LAST, STAGES, collocation
from flexmb.integrate.contact_work import contact_losses
from flexmb.integrate.control import judged, met, resize
from flexmb.integrate.finish import finished, keep, next_size, note_peaks, publish, take_over
from flexmb.integrate.held import settle
from flexmb.integrate.landing import planned, remember
from flexmb.integrate.ledger import (
    CONTACT,
    DAMPING,
    DRIVE,
    FRICTION,
    GRAVITY,
    KINETIC,
    LOAD,
    SETTLED,
    STRAIN,
    TURNED,
    balance,
    keep_account,
    note_step,
    verdict,
)
from flexmb.integrate.method import Method
from flexmb.integrate.predict import forget_past
from flexmb.integrate.radau_step import radau_error, radau_step
from flexmb.integrate.reuse import forget_factors
from flexmb.integrate.runge_kutta import accelerate
from flexmb.integrate.stepper import Stepper
from flexmb.integrate.touch import follow_contacts, no_room
from flexmb.kernels import compiled, copy
from flexmb.places import FRICTION_FORCE, GAP_RATE, NORMAL_FORCE, SLIP
from flexmb.program.program import Program
from flexmb.program.tables import GRIP_LAW
from flexmb.system.constraints import report_forces
from flexmb.system.evaluate import evaluate_accepted
from flexmb.system.outputs import write_outputs
from flexmb.system.work import DRIVE_FORCE, GRIP_FORCE, GRIP_SLIP, LOSS_FRICTION, LOSS_NORMAL, MOTION_RATE

if TYPE_CHECKING:
    from flexmb.integrate.run import Run
    from flexmb.model.mechanism import Mechanism

GROWS, SHRINKS, SAFE = 4.0, 0.2, 0.9
"""A step becomes at most and at least these parts of the one before, and this part of what the estimate allows."""

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
    accelerations at its ends; forces there satisfy the equations of motion.  Works are integrated by Simpson's
    rule, so what the method takes shows in `energy.residual`; `energy.algorithm` is 0.
    Histories of laws (bristles of LuGre's friction) are of the order that their law has.

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
    longest: ClassVar[tuple[float, float]] = (25.0, 100.0)

    def stepper(self, program: Program, mechanism: Mechanism | None = None) -> Stepper:  # noqa: ARG002 - see `Staggered`
        """What steps the compiled mechanism."""
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
        """What predicts the next step."""
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
            if met(tables, address, code, h, options, flow, trial, work, record):
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
        note_peaks(flow.clock.t, record)
        full = save_between(tables, address, lu, options, flow, trial, work, record, R) != RUNNING
        if full or no_room(flow, record):
            return BUFFER_FULL
    return verdict(flow.ledger, flow.account) if flow.account.steps >= SETTLED else RUNNING


@compiled
def add_works(tables, address, lu, h, options, flow, trial, work, record, R):
    """R.works and R.losses by Simpson's rule; the state of the last evaluation is that of the trial.

    The multipliers of the stages are of third order.  So those of the middle are found from the quintic through both
    ends, as those of instants that are saved.
    """
    W, Q, V, A, L = R.works, R.Q[LAST], R.V[LAST], R.A[LAST], R.L[LAST]
    W.drives = W.loads = W.joints = W.damping = W.brought = W.joints_size = 0.0
    R.losses[:, :] = 0.0
    R.rates[:, :] = 0.0
    copy(trial.q, Q)
    copy(trial.v, V)
    copy(trial.a, A)
    copy(trial.lam, L)
    t = flow.clock.t
    if working(tables, flow):
        add_powers(tables, address, t, 0.0, h / 6.0, flow.q, flow.v, flow.a, flow.lam, flow, work, R, R.rates[AT_START])
        quintic(tables.sizes.n_q, 0.5, h, R.old, Q, V, A, trial)
        for i in range(tables.sizes.n_c):
            trial.lam[i] = 0.5 * (flow.lam[i] + L[i])
        accelerate(tables, address, lu, t + 0.5 * h, 0.5, h, R.zero, options, flow, trial, work, record, R)
        q, v, a, lam = trial.q, trial.v, trial.a, trial.lam
        add_powers(tables, address, t + 0.5 * h, 0.5 * h, h / 1.5, q, v, a, lam, flow, work, R, R.rates[AT_END])
        R.rates[AT_END, :] = 0.0
        copy(Q, trial.q)
        copy(V, trial.v)
        copy(A, trial.a)
        copy(L, trial.lam)
        record.count.evaluations += 2
    add_powers(tables, address, t + h, h, h / 6.0, Q, V, A, L, flow, work, R, R.rates[AT_END])
    record.count.evaluations += 1


@compiled
def add_powers(tables, address, t, part, share, q, v, a, lam, flow, work, R, rates):
    """Add the powers of a state at the time t times the part `share` of the step [s], and its powers to `rates`."""
    W = R.works
    evaluate_accepted(tables, address, t, part, q, v, a, lam, flow.z, R.zero, R.zero, work)
    report_forces(tables, lam, work)
    W.damping += share * work.power.damping
    rates[DAMPING] += work.power.damping
    for row in range(work.drive.shape[0]):
        if tables.constraints.motion[row] >= 0:
            power = work.drive[row, MOTION_RATE] * work.drive[row, DRIVE_FORCE]
            W.drives += share * power
            rates[DRIVE] += power
            W.brought += share * abs(power)
    for c in range(work.grip.shape[0]):
        if tables.constraints.grip[c, GRIP_LAW] >= 0:
            power = work.grip[c, GRIP_FORCE] * work.grip[c, GRIP_SLIP]
            W.joints -= share * power
            rates[FRICTION] -= power
            W.joints_size += share * abs(power)
    for c in range(R.losses.shape[0]):
        contact = work.contact[c]
        normal, friction = contact[NORMAL_FORCE] * contact[GAP_RATE], contact[FRICTION_FORCE] * contact[SLIP]
        R.losses[c, LOSS_NORMAL] -= share * normal
        R.losses[c, LOSS_FRICTION] -= share * friction
        rates[CONTACT] -= normal
        rates[FRICTION] -= friction
    add_loads(tables, share, v, work, W, rates)


@compiled
def working(tables, flow):
    """Whether anything does work: drives, contacts, friction in joints, dampers, elements that are loads."""
    C, E = tables.constraints, tables.elements
    if tables.contacts.kernel.shape[0] > 0 or tables.sizes.gripped or flow.account.damping_power != 0.0:
        return True
    for row in range(C.motion.shape[0]):
        if C.motion[row] >= 0:
            return True
    for e in range(E.p.shape[0]):  # noqa: SIM110 - compiled
        if E.energy[e] < 0 or E.factor[e] >= 0:
            return True
    return False


@compiled
def add_loads(tables, share, v, work, W, rates):
    """Power of elements without an account of their own, over the part `share` of the time [s]."""
    E, place, power = tables.elements, 0, 0.0
    for e in range(E.p.shape[0]):
        if E.energy[e] < 0:
            for i in range(E.dof[e], E.dof[e + 1]):
                power += work.load[place] * v[E.dofs[i]]
                place += 1
    W.loads += share * power
    rates[LOAD] += power
    W.brought += share * abs(power)


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
def book_works(tables, address, t, turned, flow, trial, work, R):
    """Bring the ledger to the trial state."""
    ledger, account, W = flow.ledger, flow.account, R.works
    power = work.power
    turned += abs(power.kinetic - ledger[KINETIC]) + abs(power.strain - ledger[STRAIN])
    turned += abs(power.gravity - ledger[GRAVITY])
    ledger[DRIVE] += W.drives
    ledger[LOAD] += W.loads
    ledger[FRICTION] += W.joints
    ledger[DAMPING] += W.damping
    ledger[TURNED] += 0.5 * turned
    account.put_in += W.brought
    power.algorithm = 0.0
    note_step(tables, trial.q, account, work)
    keep_account(tables, address, t, 0.0, flow.q, flow.v, trial.q, trial.v, ledger, account, flow.memory, work)
    copy(work.momentum, flow.momentum)


@compiled
def save_between(tables, address, lu, options, flow, trial, work, record, R):
    """Write the instants of the save grid that the last step passed; BUFFER_FULL when the buffer is to be emptied.

    Then it is called again before the next step.
    """
    due = flow.clock.saving_from + (flow.clock.saved + 1.0) * options.save_interval
    while due <= flow.clock.t + 1e-9 * options.save_interval and record.count.rows < record.times.shape[0]:
        row, s = record.count.rows, (due - R.step.began) / R.step.size
        if s < 1.0 - 1e-9 and signals_at(tables, address, lu, s, options, flow, trial, work, record, R, R.signals):
            keep(R.signals, record, row)
        else:
            keep(record.new, record, row)
        record.times[row] = due
        record.count.rows += 1
        flow.clock.saved += 1.0
        due = flow.clock.saving_from + (flow.clock.saved + 1.0) * options.save_interval
    return BUFFER_FULL if record.count.rows >= record.times.shape[0] else RUNNING


@compiled
def signals_at(tables, address, lu, s, options, flow, trial, work, record, R, target):
    """All signals at the fraction s of the last step; whether their forces could be found.

    The quintic through both ends; accelerations and multipliers solve the equations of motion.
    """
    h, old, now = R.step.size, R.old, R.between
    quintic(tables.sizes.n_q, s, h, old, flow.q, flow.v, flow.a, trial)
    for i in range(tables.sizes.n_c):
        trial.lam[i] = (1.0 - s) * old.lam[i] + s * flow.lam[i]
    copy(flow.z, now.z)
    copy(old.z, flow.z)
    t = R.step.began + s * h
    code = accelerate(tables, address, lu, t, s, h, R.zero, options, flow, trial, work, record, R)
    evaluate_accepted(tables, address, t, s * h, trial.q, trial.v, trial.a, trial.lam, flow.z, R.zero, R.zero, work)
    copy(now.z, flow.z)
    report_forces(tables, trial.lam, work)
    ledger_at(s, h, old.ledger, R.rates, flow, work, now.ledger)
    write_outputs(tables, address, t, trial.q, trial.v, trial.a, work, now.ledger, target)
    return code == RUNNING


@compiled
def ledger_at(s, h, old, rates, flow, work, ledger):
    """The ledger at the fraction s of a step: cubics through works and powers at its ends, energies of the state."""
    rise, begin, end = s * s * (3.0 - 2.0 * s), h * s * (1.0 - s) ** 2, h * s * s * (s - 1.0)
    for i in range(ledger.shape[0]):
        ledger[i] = old[i] + rise * (flow.ledger[i] - old[i]) + begin * rates[AT_START, i] + end * rates[AT_END, i]
    power = work.power
    ledger[KINETIC], ledger[STRAIN], ledger[GRAVITY] = power.kinetic, power.strain, power.gravity
    balance(ledger, flow.account)


@compiled
def quintic(n, s, h, old, q, v, a, trial):
    """Positions and velocities at the fraction s of the step from `old` to q, v, a, by Hermite's polynomial."""
    for i in range(n):
        rise = (q[i] - old.q[i]) / h
        v0, v1, a0, a1 = old.v[i], v[i], h * old.a[i], h * a[i]
        c3 = 10.0 * rise - 6.0 * v0 - 4.0 * v1 - 1.5 * a0 + 0.5 * a1
        c4 = -15.0 * rise + 8.0 * v0 + 7.0 * v1 + 1.5 * a0 - a1
        c5 = 6.0 * rise - 3.0 * (v0 + v1) + 0.5 * (a1 - a0)
        trial.q[i] = old.q[i] + h * s * (v0 + s * (0.5 * a0 + s * (c3 + s * (c4 + s * c5))))
        trial.v[i] = v0 + s * (a0 + s * (3.0 * c3 + s * (4.0 * c4 + s * 5.0 * c5)))
        trial.a[i] = (1.0 - s) * old.a[i] + s * a[i]
