"""Saved instants: rows of signals at the instants of the save grid, which need not be ends of steps.

Within a step, positions and velocities are cubic in time, accelerations and multipliers quadratic, or linear after a
starting step.  All signals are those of this state: forces, contacts, joints, stored energies and measured signals are
evaluated there.  Works and losses since the start are linear in time within a step.
"""

import math

from flexmb.engine.energy import DRIVE, GRAVITY, KINETIC, STRAIN, TURNED_OVER
from flexmb.engine.state.record import BUFFER_FULL, NEVER, RUNNING
from flexmb.engine.system.constraints import report_forces
from flexmb.engine.system.evaluate import evaluate_accepted
from flexmb.engine.system.outputs import write_outputs
from flexmb.kernels import compiled, copy

END_OF_STEP = 1.0 - 1e-9  # fraction of a step from which an instant is its end
PAST_OF_QUADRATIC = 2  # number of states before the accepted one that a quadratic takes


@compiled
def save_instants(tables, address, options, flow, trial, work, record):
    """Save the end of the last step, or the instants of the save grid within it; BUFFER_FULL when the buffer is full.

    The buffer must then be emptied, and `save_instants` called again before the next step.  `trial` and `work` are
    overwritten.
    """
    if options.save_interval == 0.0:
        save_step(flow, record)
    else:
        step = record.report
        while is_due(options, flow, record):
            due, row = next_due(options, flow, record), record.count.rows
            s = (due - step.start) / step.size
            if s >= END_OF_STEP:
                store_signals(record.signals, record, row)
            else:
                signals_within(tables, address, s, flow, trial, work, record)
                store_signals(record.within, record, row)
            count_row(due, flow, record)
    return BUFFER_FULL if record.count.rows >= record.times.shape[0] else RUNNING


@compiled
def save_step(flow, record):
    """Save the end of the last step."""
    row = record.count.rows
    record.times[row] = flow.clock.t
    store_signals(record.signals, record, row)
    record.count.rows += 1


@compiled
def signals_within(tables, address, s, flow, trial, work, record):
    """All signals at fraction s of the last step, in `record.within`."""
    h, old, new = record.report.size, record.last_signals, record.signals
    interpolate_state(tables.sizes.n_q, s, h, flow, trial, record)
    t = record.report.start + s * h
    evaluate_accepted(
        tables,
        address,
        t,
        s * h,
        trial.q,
        trial.v,
        trial.a,
        trial.lam,
        record.last_z,
        trial.mean_v,
        trial.newmark_residual,
        work,
    )
    report_forces(tables, trial.lam, work)
    write_outputs(tables, address, t, trial.q, trial.v, trial.a, work, flow.ledger, record.peak, True, record.within)
    y, energy, power = record.within, tables.sizes.energy, work.power
    y[energy + KINETIC], y[energy + STRAIN], y[energy + GRAVITY] = power.kinetic, power.strain, power.gravity
    for k in range(energy + DRIVE, energy + TURNED_OVER + 1):
        y[k] = (1.0 - s) * old[k] + s * new[k]


@compiled
def interpolate_state(n, s, h, flow, trial, record):
    """State at fraction s of the last step, in `trial`."""
    # Accelerations and multipliers are quadratic through the state before the step, where the predictor knows it.
    old, new, past, predictor = record.last_signals, record.signals, flow.past, flow.predictor
    f0, f1 = (1.0 + 2.0 * s) * (1.0 - s) ** 2, s * s * (3.0 - 2.0 * s)
    d0, d1 = h * s * (1.0 - s) ** 2, h * s * s * (s - 1.0)
    before, bow = 1.0, 0.0
    if predictor.past_states >= PAST_OF_QUADRATIC:
        before = predictor.second_last_step
        bow = s * (s - 1.0) * h * h / (h + before)
    for i in range(n):
        a0, a1 = old[2 * n + i], new[2 * n + i]
        trial.q[i] = f0 * old[i] + f1 * new[i] + d0 * old[n + i] + d1 * new[n + i]
        trial.v[i] = f0 * old[n + i] + f1 * new[n + i] + d0 * a0 + d1 * a1
        trial.a[i] = (1.0 - s) * a0 + s * a1 + bow * ((a1 - a0) / h - (a0 - past[1, i]) / before)
    for i in range(trial.lam.shape[0]):
        l0, l1 = record.last_lam[i], flow.lam[i]
        trial.lam[i] = (1.0 - s) * l0 + s * l1 + bow * ((l1 - l0) / h - (l0 - past[1, n + i]) / before)


@compiled
def next_due(options, flow, record):
    """The first instant [s] of the save grid, or of the given times, that is not saved yet."""
    saved, times = flow.clock.saved_instants, record.save_times
    if times.shape[0] == 0 or options.save_interval >= NEVER:
        return flow.clock.save_start + (saved + 1.0) * options.save_interval
    return times[int(saved)] if saved < times.shape[0] else NEVER


@compiled
def end_is_saved(options, flow, record):
    """Whether the end of the last step is a saved instant."""
    if options.save_interval == 0.0:
        return True
    passed = math.floor((flow.clock.t - flow.clock.save_start) / options.save_interval + 1e-9)
    last = flow.clock.save_start + passed * options.save_interval
    step, times = record.report, record.save_times
    if times.shape[0] > 0 and options.save_interval < NEVER:
        passed = int(flow.clock.saved_instants)
        while passed < times.shape[0] and times[passed] <= flow.clock.t + 1e-9 * options.save_interval:
            last = times[passed]
            passed += 1
    return passed > flow.clock.saved_instants and last - step.start >= END_OF_STEP * step.size


@compiled
def is_due(options, flow, record):
    """Whether the step has passed an instant of the save grid, and the buffer has room for it."""
    passed = next_due(options, flow, record) <= flow.clock.t + 1e-9 * options.save_interval
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
    if record.saved_places.shape[0] == 0:
        copy(signals, record.values[row])
        return
    for k in range(record.saved_places.shape[0]):
        record.values[row, k] = signals[record.saved_places[k]]
