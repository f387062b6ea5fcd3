"""The end of an accepted step: signals, peaks, saving, and the new state."""

from flexmb.energy.balance import SETTLED, keep_account, verdict, work_of_bow
from flexmb.energy.contact_work import contact_losses
from flexmb.kernels import compiled, copy
from flexmb.state.record import BUFFER_FULL, JOINTS_KNOWN, NOTHING_KNOWN, RUNNING
from flexmb.step.contact_log import follow_contacts, no_room
from flexmb.step.newmark.predictor import compare
from flexmb.system.constraints import report_forces
from flexmb.system.contacts import add_contacts
from flexmb.system.elements import account
from flexmb.system.evaluate import evaluate_accepted
from flexmb.system.outputs import write_outputs


@compiled
def accept(tables, address, h, options, flow, trial, work, record):
    """Make the trial state the accepted one.

    BUFFER_FULL when what was saved must be fetched, what the ledger says when energies do not add up, else RUNNING.
    """
    find_forces(tables, address, h, flow, trial, work, record)
    book(tables, address, h, options, flow, trial, work, record)
    take_over(h, flow, trial, work, record)
    write_outputs(tables, address, flow.clock.t, flow.q, flow.v, flow.a, work, flow.ledger, record.new)
    if publish(tables, options, flow, record) != RUNNING:
        return BUFFER_FULL
    return verdict(flow.ledger, flow.account) if flow.account.steps >= SETTLED else RUNNING


@compiled
def find_forces(tables, address, h, flow, trial, work, record):
    """Forces, histories and energies of the trial state, as far as they are not known yet."""
    t = flow.clock.t + h
    if record.count.known == NOTHING_KNOWN:
        compare(tables.sizes.n_q, h, flow, trial)
        evaluate_accepted(
            tables, address, t, h, trial.q, trial.v, trial.a, trial.lam, flow.z, trial.mean_v, trial.lag, work
        )
        record.count.evaluations += 1
    elif record.count.known == JOINTS_KNOWN:
        compare(tables.sizes.n_q, h, flow, trial)
        work.r[:] = 0.0
        account(tables, address, t, h, trial.q, trial.v, trial.a, trial.mean_v, trial.lag, flow.z, work)
        add_contacts(tables, address, t, h, trial.q, trial.v, flow.z, 0.0, 0.0, False, work)


@compiled
def book(tables, address, h, options, flow, trial, work, record):
    """Bring joint forces, episodes of contact and the ledger to the trial state."""
    t = flow.clock.t + h
    report_forces(tables, trial.lam, work)
    work_of_bow(tables.sizes.n_q, flow, trial, work)
    contact_losses(tables, address, h, flow, trial.q, trial.v, work)
    follow_contacts(tables, h, options, flow, work, record)
    keep_account(tables, address, t, h, flow.q, flow.v, trial.q, trial.v, flow.ledger, flow.account, flow.memory, work)


@compiled
def take_over(h, flow, trial, work, record):
    """Copy the trial state into the accepted one, and count the step."""
    t0 = flow.clock.t
    flow.clock.t = t0 + h
    copy(trial.q, flow.q)
    copy(trial.v, flow.v)
    copy(trial.a, flow.a)
    copy(trial.x, flow.x)
    copy(trial.lam, flow.lam)
    copy(work.z_new, flow.z)
    copy(record.new, record.old)
    record.count.steps += 1
    record.step.smallest, record.step.largest = min(record.step.smallest, h), max(record.step.largest, h)
    record.step.began, record.step.size = t0, h


@compiled
def publish(tables, options, flow, record):
    """Largest values of the new signals, and the instants that are due; BUFFER_FULL when these must be fetched."""
    note_peaks(flow.clock.t, record.new, record)
    code = save(tables, record.step.began, record.step.size, options, flow, record)
    return BUFFER_FULL if code != RUNNING or no_room(flow, record) else RUNNING


@compiled
def note_peaks(t, signals, record):
    """Largest values so far."""
    for i in range(signals.shape[0]):  # without branches: the compiler makes vectors of it
        size = signals[i] if record.one_sided[i] else abs(signals[i])
        larger = size > record.peak[i]
        record.peak[i] = size if larger else record.peak[i]
        record.peak_time[i] = t if larger else record.peak_time[i]


@compiled
def save(tables, t0, h, options, flow, record):
    """Write the instants of the save grid that the step from t0 passed.

    When the buffer is full before all are written, it must be emptied and `save` called again before the next step.
    """
    if options.save_interval == 0.0:
        row = record.count.rows
        record.times[row] = flow.clock.t
        keep(record.new, record, row)
        record.count.rows += 1
    else:
        while is_due(options, flow, record):
            due, row = next_due(options, flow), record.count.rows
            if record.between.shape[0] == 0:
                interpolate(tables, min((due - t0) / h, 1.0), h, record.old, record.new, record.values[row])
            else:
                interpolate(tables, min((due - t0) / h, 1.0), h, record.old, record.new, record.between)
                keep(record.between, record, row)
            count_row(due, flow, record)
    return BUFFER_FULL if record.count.rows >= record.times.shape[0] else RUNNING


@compiled
def next_due(options, flow):
    """The first instant [s] of the save grid that is not saved yet."""
    return flow.clock.saving_from + (flow.clock.saved + 1.0) * options.save_interval


@compiled
def is_due(options, flow, record):
    """Whether the step has passed an instant of the save grid, and the buffer has room for it."""
    passed = next_due(options, flow) <= flow.clock.t + 1e-9 * options.save_interval
    return passed and record.count.rows < record.times.shape[0]


@compiled
def count_row(due, flow, record):
    """Count the row of an instant `due` [s] of the save grid, which has been written."""
    record.times[record.count.rows] = due
    record.count.rows += 1
    flow.clock.saved += 1.0


@compiled
def keep(signals, record, row):
    """Write those of all signals that are saved into a row of the buffer."""
    if record.between.shape[0] == 0:
        copy(signals, record.values[row])
        return
    for k in range(record.kept.shape[0]):
        record.values[row, k] = signals[record.kept[k]]


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
    return options.t_end - flow.clock.t <= 1e-12 * max(abs(options.t_end), 1e-300)
