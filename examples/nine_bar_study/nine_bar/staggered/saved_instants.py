"""Saved instants of the staggered scheme: signals of both models, interpolated within a step."""

from flexmb.engine.step.acceptance import buffer_code, save_ends, save_within
from flexmb.engine.system.outputs import MODE
from flexmb.kernels import compiled


@compiled
def save_interpolated(tables, options, flow, record):
    """Save the end of the last step, or the instants of the save grid within it; BUFFER_FULL when the buffer is full.

    `tables` : those of the flexible mechanism, to which the signals belong
    """
    s = save_ends(options, flow, record)
    while s < 1.0:
        interpolate(tables, s, record.report.size, record.last_signals, record.signals, record.within)
        s = save_within(record.within, options, flow, record)
    return buffer_code(record)


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
