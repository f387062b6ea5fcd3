"""The compiled loop of `Staggered`: Runge and Kutta's step of the rigid twin, the elastic step, the end of both.

Source of the order of the two: X. Chen, S. Jiang, Y. Deng, Q. Wang, Nonlinear Dynamics (2018), 4.4.
"""

import math

from flexmb.integrate.arrays import BUFFER_FULL, DONE, NOT_FINITE, RUNNING, SINGULAR
from flexmb.integrate.contact_work import contact_losses
from flexmb.integrate.elastic_step import carry, elastic_step, hand_back
from flexmb.integrate.explicit import project_state
from flexmb.integrate.finish import finished, next_size, save
from flexmb.integrate.ledger import DAMPING, LOAD, RESIDUAL, keep_account, work_of_bow
from flexmb.integrate.predict import compare
from flexmb.integrate.touch import follow_contacts, no_room
from flexmb.kernels import compiled, copy
from flexmb.solve.lu import THRESHOLD, factor, solve
from flexmb.system.constraints import report_forces
from flexmb.system.elements import account
from flexmb.system.evaluate import evaluate, evaluate_accepted
from flexmb.system.outputs import write_outputs


@compiled
def accelerate_loaded(tables, address, lu, t, part, h, load, flow, trial, work, record, stages):
    """Accelerations and multipliers of the trial state under a load (n_t,): M a + G^T lam = load - r, G a = gamma."""
    n, m = tables.sizes.n_q, tables.sizes.n_c
    evaluate(tables, address, t, part * h, trial.q, trial.v, stages.zero, trial.lam, flow.z, 0.0, 0.0, 1.0, True, work)
    record.count.evaluations += 1
    for i in range(n):
        trial.b[i] = load[i] - (work.r[i] + work.Gl[i])
    for i in range(m):
        trial.b[n + i] = work.gamma[i]
    lost = factor(lu, work.lu, trial.seen, THRESHOLD)
    record.count.factorisations += 1
    if lost >= 0:
        record.count.lost = lost
        return SINGULAR if math.isfinite(trial.b.sum()) else NOT_FINITE
    solve(lu, work.lu, trial.b, trial.d, trial.y)
    for i in range(n):
        trial.a[i] = trial.d[i]
    for i in range(m):
        trial.lam[i] += trial.d[n + i]
    return RUNNING if math.isfinite(trial.d.sum()) else NOT_FINITE


@compiled
def rigid_step(tables, address, lu, h, load, options, flow, trial, work, record, stages):
    """`runge_kutta_step` under a load that stays the same in the step."""
    n, m, t = tables.sizes.n_q, tables.sizes.n_c, flow.clock.t
    copy(flow.q, trial.q)
    copy(flow.v, trial.v)
    copy(flow.lam, trial.lam)
    for stage in range(5):
        c = 0.0 if stage == 0 else (1.0 if stage >= 3 else 0.5)
        if stage == 4:
            end_of_stages(n, h, flow, trial, stages)
            code = RUNNING
            if m > 0:
                code = project_state(tables, address, lu, t + h, h, options, flow, trial, work, record, stages)
            if code != RUNNING:
                return code
        elif stage > 0:
            for i in range(n):
                trial.q[i] = flow.q[i] + c * h * stages.v[stage - 1, i]
                trial.v[i] = flow.v[i] + c * h * stages.a[stage - 1, i]
        code = accelerate_loaded(tables, address, lu, t + c * h, c, h, load, flow, trial, work, record, stages)
        if code != RUNNING:
            return code
        if stage < 4:
            for i in range(n):
                stages.v[stage, i], stages.a[stage, i] = trial.v[i], trial.a[i]
    copy(trial.a, trial.x)
    return RUNNING


@compiled
def end_of_stages(n, h, flow, trial, stages):
    """Positions and velocities at the end of the step."""
    for i in range(n):
        v = stages.v[0, i] + 2.0 * (stages.v[1, i] + stages.v[2, i]) + stages.v[3, i]
        a = stages.a[0, i] + 2.0 * (stages.a[1, i] + stages.a[2, i]) + stages.a[3, i]
        trial.q[i] = flow.q[i] + h / 6.0 * v
        trial.v[i] = flow.v[i] + h / 6.0 * a


@compiled
def both_steps(tables, address, lu, h, options, flow, trial, work, record, stages, el):
    """One step of the twin, one of the elastic model; again with the new load where passes are left; a code."""
    copy(el.now.load, el.trial.load)
    code = RUNNING
    for _ in range(el.settings.passes if el.settings.flexible else 1):
        code = rigid_step(tables, address, lu, h, el.trial.load, options, flow, trial, work, record, stages)
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
    """Make the trial displacements the accepted ones."""
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
    """Add the displacements of d to the motion of the nodes with the twin; energies of the sum, as the twin's.

    Its damping beyond that of the twin's dampers is that of the beams: it is booked here, as is the work of loads on U.
    """
    S = el.scratch
    carry(el, q, v, a)
    for i in range(el.whole.sizes.n_q):
        S.q[i] += d.u[i]
        S.v[i] += d.u1[i]
        S.a[i] += d.u2[i]
    S.f[:] = 0.0
    account(el.whole, el.whole_address, t, h, S.q, S.v, S.a, S.f, S.f, S.z, el.whole_work)
    whole = el.whole_work.power
    work.power.kinetic, work.power.strain, work.power.gravity = whole.kinetic, whole.strain, whole.gravity
    power = whole.damping - work.power.damping
    ledger[DAMPING] += 0.5 * h * (el.now.memory.damping_power + power)
    ledger[LOAD] += 0.5 * h * (el.now.memory.load_power + d.memory.load_power)
    el.now.memory.damping_power = power


@compiled
def write_whole(tables, address, t, flow, work, record, el):
    """All signals: nodes of the whole motion, joints and contacts of the twin."""
    S, N = el.scratch, el.settings
    write_outputs(tables, address, t, flow.q, flow.v, flow.a, work, flow.ledger, S.signals)
    write_outputs(el.whole, el.whole_address, t, S.q, S.v, S.a, el.whole_work, flow.ledger, record.new)
    for k in range(N.last - N.first):
        record.new[N.shown + k] = S.signals[N.first + k]


@compiled
def accept_both(tables, address, h, options, flow, trial, work, record, el):
    """Make both trial states the accepted ones; BUFFER_FULL when what was saved must be fetched."""
    t0 = flow.clock.t
    t = t0 + h
    compare(tables.sizes.n_q, h, flow, trial)
    evaluate_accepted(
        tables, address, t, h, trial.q, trial.v, trial.a, trial.lam, flow.z, trial.mean_v, trial.lag, work
    )
    record.count.evaluations += 1
    report_forces(tables, trial.lam, work)
    work_of_bow(tables.sizes.n_q, flow, trial, work)
    contact_losses(tables, address, h, flow, trial.q, trial.v, work)
    follow_contacts(tables, h, options, flow, work, record)
    whole_motion(el, t, h, trial.q, trial.v, trial.a, el.trial, flow.ledger, work)
    keep_account(tables, address, t, h, flow.q, flow.v, trial.q, trial.v, flow.ledger, flow.account, flow.memory, work)
    adopt(el)
    flow.clock.t = t
    copy(trial.q, flow.q)
    copy(trial.v, flow.v)
    copy(trial.a, flow.a)
    copy(trial.x, flow.x)
    copy(trial.lam, flow.lam)
    copy(work.z_new, flow.z)
    copy(record.new, record.old)
    write_whole(tables, address, t, flow, work, record, el)
    note_peaks(t, record)
    record.count.steps += 1
    record.step.smallest, record.step.largest = min(record.step.smallest, h), max(record.step.largest, h)
    record.step.began, record.step.size = t0, h
    code = save(el.whole, t0, h, options, flow, record)
    if not math.isfinite(flow.ledger[RESIDUAL]):
        return NOT_FINITE
    return BUFFER_FULL if code != RUNNING or no_room(flow, record) else RUNNING


@compiled
def note_peaks(t, record):
    """Largest values so far."""
    for i in range(record.new.shape[0]):
        size = record.new[i] if record.one_sided[i] else abs(record.new[i])
        larger = size > record.peak[i]
        record.peak[i] = size if larger else record.peak[i]
        record.peak_time[i] = t if larger else record.peak_time[i]


@compiled
def advance_staggered(tables, address, lu, options, flow, trial, work, record, stages, el, steps):
    """At most `steps` steps of fixed size of both models; the code of the ending."""
    for _ in range(steps):
        if finished(options, flow):
            return DONE
        h = next_size(flow.clock.size, options.t_end - flow.clock.t)
        code = both_steps(tables, address, lu, h, options, flow, trial, work, record, stages, el)
        if code == RUNNING:
            code = accept_both(tables, address, h, options, flow, trial, work, record, el)
        if code != RUNNING:
            return code
    return RUNNING


@compiled
def begin_elastic(tables, t, work, el, q, v, a):
    """U'' at rest and without displacement, under the accelerations and contacts of the start; a code."""
    code = elastic_step(el, tables, work, t, 0.0, q, v, a)
    if code == RUNNING:
        hand_back(el, q, v, a)
        adopt(el)
    return code
