"""The end of an accepted step: ledger of energies, signals, peaks, saving, and the new state."""

from flexmb.integrate.arrays import BUFFER_FULL, MEMORY_HEAD, RUNNING
from flexmb.integrate.predict import compare
from flexmb.integrate.touch import follow_contacts, no_room
from flexmb.kernels import GAP_SIZE, compiled, copy
from flexmb.system.constraints import renew_forces
from flexmb.system.evaluate import evaluate_accepted
from flexmb.system.outputs import write_outputs

KINETIC, STRAIN, GRAVITY, DRIVE, LOAD, CONTACT, FRICTION, DAMPING, ALGORITHM, RESIDUAL = range(10)


@compiled
def accept(tables, address, h, ratio, options, flow, trial, work, record):
    """Make the trial state the accepted one; BUFFER_FULL when what was saved must be fetched, else RUNNING."""
    t = flow.clock[0] + h
    if record.count[9] == 0:
        compare(tables.sizes.n_q, h, flow, trial)
        evaluate_accepted(
            tables, address, t, h, trial.q, trial.v, trial.a, trial.lam, flow.z, trial.mean_v, trial.lag, work
        )
        record.count[3] += 1
    else:
        renew_forces(tables, trial.lam, work)
    follow_contacts(tables, h, options, flow, work, record)
    keep_account(tables, h, flow.ledger, flow.memory, work)
    copy(record.new, record.old)
    write_outputs(tables, address, t, trial.q, trial.v, trial.a, work, flow.ledger, record.new)
    for i in range(record.new.shape[0]):  # without branches: the compiler makes vectors of it
        size = record.new[i] if record.one_sided[i] else abs(record.new[i])
        larger = size > record.peak[i]
        record.peak[i] = size if larger else record.peak[i]
        record.peak_time[i] = t if larger else record.peak_time[i]
    t0 = flow.clock[0]
    flow.clock[0] = t
    copy(trial.q, flow.q)
    copy(trial.v, flow.v)
    copy(trial.a, flow.a)
    copy(trial.x, flow.x)
    copy(trial.lam, flow.lam)
    copy(work.z_new, flow.z)
    record.count[0] += 1
    record.extreme[0], record.extreme[1] = min(record.extreme[0], h), max(record.extreme[1], h)
    record.extreme[4], record.extreme[5] = t0, h
    code = save(tables, t0, h, options, flow, record)
    return BUFFER_FULL if no_room(flow, record) else code


@compiled
def keep_account(tables, h, ledger, memory, work):
    """Bring the ledger to the state of the last evaluation; works are integrated by the trapezoidal rule."""
    ledger[KINETIC], ledger[STRAIN], ledger[GRAVITY] = work.power[0], work.power[1], work.power[2]
    ledger[DAMPING] += 0.5 * h * (memory[1] + work.power[3])
    ledger[LOAD] += 0.5 * h * (memory[2] + work.power[4])
    ledger[ALGORITHM] += work.power[5]
    memory[1], memory[2] = work.power[3], work.power[4]
    k = MEMORY_HEAD
    for c in range(work.contact.shape[0]):
        N, depth = work.contact[c, GAP_SIZE], max(-work.contact[c, 0], 0.0)
        loss = -work.contact[c, GAP_SIZE + 1] * work.contact[c, 2]
        ledger[CONTACT] += 0.5 * (memory[k] + N) * (depth - memory[k + 1])
        ledger[FRICTION] += 0.5 * h * (memory[k + 2] + loss)
        memory[k], memory[k + 1], memory[k + 2] = N, depth, loss
        k += 3
    for row in range(work.drive.shape[0]):
        if tables.constraints.motion[row] >= 0:
            s, force = work.drive[row, 0], work.drive[row, 3]
            if h > 0.0:
                ledger[DRIVE] += 0.5 * (memory[k + 1] + force) * (s - memory[k])
            memory[k], memory[k + 1] = s, force
        k += 2
    for c in range(work.grip.shape[0]):
        if tables.constraints.grip[c, 0] >= 0:
            loss = -work.grip[c, 0] * work.grip[c, 1]
            ledger[FRICTION] += 0.5 * h * (memory[k] + loss)
            memory[k] = loss
        k += 1
    stored = ledger[KINETIC] + ledger[STRAIN] + ledger[GRAVITY]
    if h == 0.0:
        memory[0] = stored
    lost = ledger[CONTACT] + ledger[FRICTION] + ledger[DAMPING] + ledger[ALGORITHM]
    ledger[RESIDUAL] = stored - memory[0] + lost - ledger[DRIVE] - ledger[LOAD]


@compiled
def save(tables, t0, h, options, flow, record):
    """Write the instants of the save grid that the step from t0 passed.

    When the buffer is full before all are written, it must be emptied and `save` called again before the next step.
    """
    if options.save_interval == 0.0:
        row = record.count[5]
        record.times[row] = flow.clock[0]
        copy(record.new, record.values[row])
        record.count[5] += 1
    else:
        due = flow.clock[2] + (flow.clock[3] + 1.0) * options.save_interval
        while due <= flow.clock[0] + 1e-9 * options.save_interval and record.count[5] < record.times.shape[0]:
            row = record.count[5]
            interpolate(tables, min((due - t0) / h, 1.0), h, record.old, record.new, record.values[row])
            record.times[row] = due
            record.count[5] += 1
            flow.clock[3] += 1.0
            due = flow.clock[2] + (flow.clock[3] + 1.0) * options.save_interval
    return BUFFER_FULL if record.count[5] >= record.times.shape[0] else RUNNING


@compiled
def interpolate(tables, s, h, old, new, target):
    """Signals at fraction s of the step: cubic for q and v, linear for the rest, the nearer one for modes."""
    n = tables.sizes.n_q
    f0, f1 = (1.0 + 2.0 * s) * (1.0 - s) ** 2, s * s * (3.0 - 2.0 * s)
    d0, d1 = h * s * (1.0 - s) ** 2, h * s * s * (s - 1.0)
    for i in range(2 * n):
        target[i] = f0 * old[i] + f1 * new[i] + d0 * old[n + i] + d1 * new[n + i]
    for i in range(2 * n, target.shape[0]):
        target[i] = (1.0 - s) * old[i] + s * new[i]
    for c in range(tables.contacts.out.shape[0]):
        k = tables.contacts.out[c] + 11
        target[k] = new[k] if s >= 0.5 else old[k]
    for i in range(tables.measured.modes.shape[0]):
        k = tables.measured.modes[i]
        target[k] = new[k] if s >= 0.5 else old[k]


@compiled
def next_size(proposed, remaining):
    """The step to take: the proposed one, or what makes the last two steps end at the right time without a tiny one.

    Nothing is stretched by more than round-off, so an error-controlled step that was accepted stays acceptable.
    """
    if remaining <= (1.0 + 1e-6) * proposed:
        return remaining
    if remaining < 2.0 * proposed:
        return 0.5 * remaining
    return proposed


@compiled
def finished(options, flow):
    """Whether the end is reached but for round-off."""
    return options.t_end - flow.clock[0] <= 1e-12 * max(abs(options.t_end), 1e-300)
