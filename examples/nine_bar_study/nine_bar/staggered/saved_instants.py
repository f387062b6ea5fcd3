"""Saved instants of the staggered scheme: signals of both models, interpolated within a step."""

from flexmb.engine.state.record import BUFFER_FULL, RUNNING
from flexmb.engine.step.acceptance import count_row, is_due, next_due, save_step, store_signals
from flexmb.engine.system.outputs import MODE
from flexmb.kernels import compiled


@compiled
def save_interpolated(tables, options, flow, record):
    """Save the end of the last step, or the instants of the save grid within it; BUFFER_FULL when the buffer is full.

    `tables` : those of the flexible mechanism, to which the signals belong
    """
    step = record.report
    if options.save_interval == 0.0:
        save_step(flow, record)
    else:
        while is_due(options, flow, record):
            due, row = next_due(options, flow, record), record.count.rows
            s = min((due - step.start) / step.size, 1.0)
            interpolate(tables, s, step.size, record.last_signals, record.signals, record.within)
            store_signals(record.within, record, row)
            count_row(due, flow, record)
    return BUFFER_FULL if record.count.rows >= record.times.shape[0] else RUNNING


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
        k = tables.contacts.out[c] + MODE
        target[k] = new[k] if s >= 0.5 else old[k]
    for i in range(tables.measured.modes.shape[0]):
        k = tables.measured.modes[i]
        target[k] = new[k] if s >= 0.5 else old[k]
