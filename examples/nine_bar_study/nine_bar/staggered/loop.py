"""Compiled loop of `Staggered`: Runge-Kutta step of the rigid counterpart, elastic step, acceptance of both.

Source of the order of the steps: X. Chen, S. Jiang, Y. Deng, Q. Wang, Nonlinear Dynamics (2018), 4.4.
"""

import math

from nine_bar_study.nine_bar.staggered.elastic_step import carry, elastic_step, hand_back
from nine_bar_study.nine_bar.staggered.saved_instants import save_interpolated

from flexmb.engine.energy import DAMPING, LOAD, RESIDUAL, STRAIN
from flexmb.engine.state.record import BUFFER_FULL, CONDITION_MET, DONE, NOT_EVALUATED, NOT_FINITE, RUNNING
from flexmb.engine.step.acceptance import (
    adopt_trial,
    complete_evaluation,
    condition_met,
    finished,
    next_step_size,
    update_energies,
    update_peaks,
    watch_step,
)
from flexmb.engine.step.contact_events import buffer_may_overflow
from flexmb.engine.step.runge_kutta import runge_kutta_step
from flexmb.engine.system.elements import evaluate_energies
from flexmb.engine.system.outputs import write_outputs
from flexmb.kernels import compiled, copy


@compiled
def both_steps(tables, address, lu, h, options, flow, trial, work, record, stages, el):
    """Step of the rigid counterpart and step of the elastic model, repeated `passes` times; returns a code."""
    copy(el.now.load, el.trial.load)
    code = RUNNING
    for _ in range(el.settings.passes if el.settings.flexible else 1):
        code = runge_kutta_step(tables, address, lu, h, el.trial.load, options, flow, trial, work, record, stages)
        if code == RUNNING and el.settings.flexible:
            el.trial.memory.tie = 0.0
            code = elastic_step(el, tables, work, flow.clock.t + h, h, trial.q, trial.v, trial.a)
        if code != RUNNING:
            break
        if el.settings.flexible:
            hand_back(el, trial.q, trial.v, trial.a)
    return code


@compiled
def adopt(el):
    """Copy the trial displacements to the accepted displacements."""
    now, new = el.now, el.trial
    copy(new.u, now.u)
    copy(new.u1, now.u1)
    copy(new.u2, now.u2)
    copy(new.load, now.load)
    copy(new.G, now.G)
    copy(new.drift, now.drift)
    for k in range(now.motions.shape[0]):
        copy(new.motions[k], now.motions[k])
    now.memory.tie = max(now.memory.tie, new.memory.tie)
    now.memory.load_power = new.memory.load_power


@compiled
def whole_motion(el, t, h, q, v, a, d, ledger, work):
    """Motion and energies of the flexible mechanism: rigid motion of the nodes plus displacements of d.

    The damping of the beams and the work of loads on U are added to the ledger.
    """
    S = el.scratch
    carry(el, q, v, a)
    for i in range(el.whole.sizes.n_q):
        S.q[i] += d.u[i]
        S.v[i] += d.u1[i]
        S.a[i] += d.u2[i]
    S.f[:] = 0.0
    evaluate_energies(el.whole, el.whole_address, t, h, S.q, S.v, S.a, S.f, S.f, S.z, el.whole_work)
    whole = el.whole_work.power
    work.power.kinetic, work.power.strain, work.power.gravity = whole.kinetic, whole.strain, whole.gravity
    power = whole.damping - work.power.damping
    ledger[DAMPING] += 0.5 * h * (el.now.memory.damping_power + power)
    ledger[LOAD] += 0.5 * h * (el.now.memory.load_power + d.memory.load_power)
    el.now.memory.damping_power = power


@compiled
def write_whole(tables, address, t, flow, work, record, el):
    """Write all signals: nodes of the flexible mechanism, joints and contacts of the rigid counterpart."""
    S, N = el.scratch, el.settings
    place, peak, signals = el.whole_address, record.peak, record.signals
    write_outputs(tables, address, t, flow.q, flow.v, flow.a, work, flow.ledger, peak, True, S.signals)
    write_outputs(el.whole, place, t, S.q, S.v, S.a, el.whole_work, flow.ledger, peak, True, signals)
    for k in range(N.last - N.first):
        record.signals[N.shown + k] = S.signals[N.first + k]


@compiled
def accept_both(tables, address, h, options, flow, trial, work, record, el):
    """Accept the trial states of both models; BUFFER_FULL if the buffer of saved signals is full."""
    record.count.evaluated = NOT_EVALUATED
    complete_evaluation(tables, address, h, flow, trial, work, record)
    whole_motion(el, flow.clock.t + h, h, trial.q, trial.v, trial.a, el.trial, flow.ledger, work)
    update_energies(tables, address, h, options, flow, trial, work, record)
    adopt(el)
    adopt_trial(h, flow, trial, work, record)
    write_whole(tables, address, flow.clock.t, flow, work, record, el)
    update_peaks(flow.clock.t, record.signals, record)
    watch_step(el.whole.sizes.energy + STRAIN, flow, record)
    full = save_interpolated(el.whole, options, flow, record) != RUNNING or buffer_may_overflow(flow, record)
    if not math.isfinite(flow.ledger[RESIDUAL]):
        return NOT_FINITE
    if condition_met(record):
        return CONDITION_MET
    return BUFFER_FULL if full else RUNNING


@compiled
def advance_staggered(tables, address, lu, options, flow, trial, work, record, stages, el, steps):
    """Take at most `steps` steps of fixed size of both models; returns the code of the ending."""
    for _ in range(steps):
        if finished(options, flow):
            return DONE
        h = next_step_size(flow.clock.step_size, options.t_end - flow.clock.t)
        code = both_steps(tables, address, lu, h, options, flow, trial, work, record, stages, el)
        if code == RUNNING:
            code = accept_both(tables, address, h, options, flow, trial, work, record, el)
        if code != RUNNING:
            return code
    return RUNNING


@compiled
def begin_elastic(tables, t, work, el, q, v, a):
    """U'' at the start, with U = U' = 0, from the accelerations and contact forces of the start; returns a code."""
    code = elastic_step(el, tables, work, t, 0.0, q, v, a)
    if code == RUNNING:
        hand_back(el, q, v, a)
        adopt(el)
    return code
