"""Acceptance of a step: forces, energies, signals, peaks and saved instants of the trial state."""

from flexmb.energy.balance import STEPS_BEFORE_CHECK, check_balance, complete_algorithm_work, update_balance
from flexmb.energy.contact_work import contact_losses
from flexmb.kernels import compiled, copy
from flexmb.state.record import BUFFER_FULL, JOINTS_EVALUATED, NOT_EVALUATED, RUNNING
from flexmb.step.contact_log import buffer_may_overflow, update_episodes
from flexmb.step.newmark.predictor import find_newmark_residual
from flexmb.system.constraints import report_forces
from flexmb.system.contacts import add_contacts
from flexmb.system.elements import evaluate_energies
from flexmb.system.evaluate import evaluate_accepted
from flexmb.system.outputs import write_outputs


@compiled
def accept(tables, address, h, options, flow, trial, work, record):
    """Make the trial state the accepted one.

    Returns RUNNING, BUFFER_FULL when the buffers must be emptied, or a code of `check_balance`.
    """
    complete_evaluation(tables, address, h, flow, trial, work, record)
    update_energies(tables, address, h, options, flow, trial, work, record)
    adopt_trial(h, flow, trial, work, record)
    write_outputs(tables, address, flow.clock.t, flow.q, flow.v, flow.a, work, flow.ledger, record.signals)
    if report_signals(tables, options, flow, record) != RUNNING:
        return BUFFER_FULL
    return check_balance(flow.ledger, flow.balance) if flow.balance.steps >= STEPS_BEFORE_CHECK else RUNNING


@compiled
def complete_evaluation(tables, address, h, flow, trial, work, record):
    """Evaluate the forces, histories and energies of the trial state that the last iteration left out."""
    t = flow.clock.t + h
    if record.count.evaluated == NOT_EVALUATED:
        find_newmark_residual(tables.sizes.n_q, h, flow, trial)
        evaluate_accepted(
            tables,
            address,
            t,
            h,
            trial.q,
            trial.v,
            trial.a,
            trial.lam,
            flow.z,
            trial.mean_v,
            trial.newmark_residual,
            work,
        )
        record.count.evaluations += 1
    elif record.count.evaluated == JOINTS_EVALUATED:
        find_newmark_residual(tables.sizes.n_q, h, flow, trial)
        work.r[:] = 0.0
        evaluate_energies(
            tables, address, t, h, trial.q, trial.v, trial.a, trial.mean_v, trial.newmark_residual, flow.z, work
        )
        add_contacts(tables, address, t, h, trial.q, trial.v, flow.z, 0.0, 0.0, False, work)


@compiled
def update_energies(tables, address, h, options, flow, trial, work, record):
    """Update joint forces, contact intervals and the balance of energies to the trial state."""
    t = flow.clock.t + h
    report_forces(tables, trial.lam, work)
    complete_algorithm_work(tables.sizes.n_q, flow, trial, work)
    contact_losses(tables, address, h, flow, trial.q, trial.v, work)
    update_episodes(tables, h, options, flow, work, record)
    update_balance(
        tables, address, t, h, flow.q, flow.v, trial.q, trial.v, flow.ledger, flow.balance, flow.memory, work
    )


@compiled
def update_largest_states(flow, trial):
    """Update the largest absolute values of the states of controls, which stand before the ground."""
    n = flow.largest_states.shape[0]
    first = flow.v.shape[0] - n - 3
    for i in range(n):
        flow.largest_states[i] = max(flow.largest_states[i], abs(trial.v[first + i]))


@compiled
def adopt_trial(h, flow, trial, work, record):
    """Copy the trial state into the accepted one, and count the step."""
    t0 = flow.clock.t
    flow.clock.t = t0 + h
    copy(trial.q, flow.q)
    copy(trial.v, flow.v)
    copy(trial.a, flow.a)
    copy(trial.x, flow.x)
    copy(trial.lam, flow.lam)
    copy(work.z_new, flow.z)
    if flow.largest_states.shape[0] > 0:
        update_largest_states(flow, trial)
    copy(record.signals, record.last_signals)
    record.count.steps += 1
    record.report.smallest, record.report.largest = min(record.report.smallest, h), max(record.report.largest, h)
    record.report.start, record.report.size = t0, h


@compiled
def report_signals(tables, options, flow, record):
    """Update the peaks, and save the instants within the step; BUFFER_FULL when the buffers must be emptied."""
    update_peaks(flow.clock.t, record.signals, record)
    code = save(tables, record.report.start, record.report.size, options, flow, record)
    return BUFFER_FULL if code != RUNNING or buffer_may_overflow(flow, record) else RUNNING


@compiled
def update_peaks(t, signals, record):
    """Update the largest values of all signals, and their times."""
    for i in range(signals.shape[0]):  # without branches: the compiler makes vectors of it
        size = signals[i] if record.one_sided[i] else abs(signals[i])
        larger = size > record.peak[i]
        record.peak[i] = size if larger else record.peak[i]
        record.peak_time[i] = t if larger else record.peak_time[i]


@compiled
def save(tables, t0, h, options, flow, record):
    """Save the instants of the save grid within the step from t0; BUFFER_FULL when the buffer is full.

    The buffer must then be emptied, and `save` called again before the next step.
    """
    if options.save_interval == 0.0:
        row = record.count.rows
        record.times[row] = flow.clock.t
        store_signals(record.signals, record, row)
        record.count.rows += 1
    else:
        while is_due(options, flow, record):
            due, row = next_due(options, flow), record.count.rows
            if record.interpolated.shape[0] == 0:
                interpolate(
                    tables, min((due - t0) / h, 1.0), h, record.last_signals, record.signals, record.values[row]
                )
            else:
                interpolate(
                    tables, min((due - t0) / h, 1.0), h, record.last_signals, record.signals, record.interpolated
                )
                store_signals(record.interpolated, record, row)
            count_row(due, flow, record)
    return BUFFER_FULL if record.count.rows >= record.times.shape[0] else RUNNING


@compiled
def next_due(options, flow):
    """The first instant [s] of the save grid that is not saved yet."""
    return flow.clock.save_start + (flow.clock.saved_instants + 1.0) * options.save_interval


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
    flow.clock.saved_instants += 1.0


@compiled
def store_signals(signals, record, row):
    """Copy the saved signals into a row of the buffer."""
    if record.interpolated.shape[0] == 0:
        copy(signals, record.values[row])
        return
    for k in range(record.saved_places.shape[0]):
        record.values[row, k] = signals[record.saved_places[k]]


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
def next_step_size(proposed, remaining):
    """Next step [s]: the proposed one; near the end the remaining time, or half of it.

    No step is stretched by more than round-off, so that an acceptable step stays acceptable, and none is tiny.
    """
    if remaining <= (1.0 + 1e-6) * proposed:
        return remaining
    if remaining < 2.0 * proposed:
        return 0.5 * remaining
    return proposed


@compiled
def finished(options, flow):
    """Whether the end is reached, up to round-off."""
    return options.t_end - flow.clock.t <= 1e-12 * max(abs(options.t_end), 1e-300)
