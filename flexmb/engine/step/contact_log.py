"""Contact intervals ("episodes") in the compiled loop: updated at every accepted step, recorded at the separation.

A contact interval lasts from the onset to the separation.  Both are roots of the cubic through gap and gap rate at the
ends of a step, as the onset is for the contact laws.
"""

from __future__ import annotations

import numpy as np

from flexmb.engine.state.flow import CONTACT_MEMORY_SIZE, EPISODE_ROW_SIZE, EPISODE_SIZE, MEMORY_NORMAL, Flow
from flexmb.engine.state.record import NEVER, RunRecord
from flexmb.engine.system.work import LOSS_FRICTION, LOSS_NORMAL
from flexmb.kernels import compiled
from flexmb.parts.contact.onset import crossing, cubic
from flexmb.places import GAP, GAP_RATE, NORMAL_FORCE
from flexmb.program.program import (
    COMMON_Z,
    CONTACT_COMMON,
    LAST_FORCE,
    LAST_GAP,
    LAST_GAP_RATE,
    NORMAL_LAW,
    NORMAL_P,
    NORMAL_P_END,
    ONSET_TIME,
    PHASE,
    Addresses,
    Program,
    Tables,
)

# Columns of `Flow.episodes`: start [s], approach speed [m/s], impulse [N s], largest force [N] and depth [m], losses
# [J].
START, APPROACH, IMPULSE, PEAK_FORCE, PEAK_DEPTH, CONTACT_LOSS, FRICTION_LOSS = range(7)
# Columns of `RunRecord.episodes`: contact, mode, end [s], separation speed [m/s]; from CARRIED on the columns of
# `Flow.episodes`.
CONTACT, MODE, END, SEPARATION, CARRIED = range(5)
IMPACT, LASTING = 1.0, 2.0  # modes of a contact interval, as in the signal `mode`
# Phases of a contact (`system/contacts.py`): in its first compression; compressed again after its first rebound.
CLOSING_PHASE, LASTING_PHASE = 1.0, 3.0
# Gap at the start relative to the size of the mechanism, up to which it is round-off of closing the loops.
ROUND_OFF_GAP = 2e-12


@compiled
def update_episodes(tables, h, options, flow, work, record):
    """Update the running contact intervals to the state of the last evaluation."""
    # Called before the ledger and the histories are updated. Losses are those of the ledger (`work.loss`), so that the
    # losses of all intervals add up to its entries. Impulses are sums of trapezoids, as in the Newmark family.
    K = tables.contacts
    for c in range(K.kernel.shape[0]):
        k = K.z[c, COMMON_Z]
        before, now = flow.z[k + PHASE], work.z_new[k + PHASE]
        if before == 0.0 and now == 0.0:
            continue
        gap, rate, N = work.contact[c, GAP], work.contact[c, GAP_RATE], work.contact[c, NORMAL_FORCE]
        if before == 0.0:
            flow.episodes[c, START] = work.z_new[k + ONSET_TIME]
            flow.episodes[c, APPROACH] = speed_at_crossing(
                h, flow.z[k + LAST_GAP], flow.z[k + LAST_GAP_RATE], gap, rate
            )
        m, depth = CONTACT_MEMORY_SIZE * c, max(-gap, 0.0)
        flow.episodes[c, IMPULSE] += 0.5 * h * (flow.memory[m + MEMORY_NORMAL] + N)
        flow.episodes[c, CONTACT_LOSS] += work.loss[c, LOSS_NORMAL]
        flow.episodes[c, FRICTION_LOSS] += work.loss[c, LOSS_FRICTION]
        flow.episodes[c, PEAK_FORCE] = max(flow.episodes[c, PEAK_FORCE], N)
        flow.episodes[c, PEAK_DEPTH] = max(flow.episodes[c, PEAK_DEPTH], depth)
        if now == 0.0:
            if options.save_interval < NEVER:
                write_episode(c, h, before, gap, rate, k, flow, record)
            for i in range(EPISODE_SIZE):
                flow.episodes[c, i] = 0.0


@compiled
def speed_at_crossing(h, gap0, rate0, gap1, rate1):
    """Approach speed at the onset [m/s]; 0 for a grazing contact."""
    if gap0 <= 0.0:
        return max(-rate1, 0.0)
    s = crossing(h, gap0, rate0, gap1, rate1)
    _, slope = cubic(s, h, gap0, rate0, gap1, rate1)
    return max(-slope / h, 0.0)


@compiled
def write_episode(c, h, phase, gap, rate, k, flow, record):
    """Record the interval of contact c, which ended in this step, in a row of the buffer; k : place of its history."""
    row = record.count.episodes
    gap0, rate0 = flow.z[k + LAST_GAP], flow.z[k + LAST_GAP_RATE]
    s = crossing(h, -gap0, -rate0, -gap, -rate)
    _, slope = cubic(s, h, gap0, rate0, gap, rate)
    record.episodes[row, CONTACT] = c
    record.episodes[row, MODE] = LASTING if phase == LASTING_PHASE else IMPACT
    record.episodes[row, END] = flow.clock.t + s * h
    record.episodes[row, SEPARATION] = max(slope / h, 0.0)
    for i in range(EPISODE_SIZE):
        record.episodes[row, CARRIED + i] = flow.episodes[c, i]
    record.count.episodes += 1


@compiled
def buffer_may_overflow(flow, record):
    """Whether the next step could end more contact intervals than the buffer has room for."""
    return record.count.episodes + flow.episodes.shape[0] > record.episodes.shape[0]


def close_round_off_gaps(program: Program, z: np.ndarray, flow: Flow) -> None:
    """Close the contacts whose gap at the start is round-off, with the histories of a gap of 0."""
    # An onset in the first step would have an approach speed of round-off. Histories z (n_z,) are those with which the
    # start state was evaluated; the histories of `flow` change.
    K, laws = program.tables.contacts, program.kernels[Addresses._fields.index("normal")]
    for kernel, p, (begin, normal, end, _) in zip(
        K.kernel[:, NORMAL_LAW], K.p[:, NORMAL_P : NORMAL_P_END + 1], K.z, strict=True
    ):
        gap, rate = flow.z[begin + LAST_GAP], flow.z[begin + LAST_GAP_RATE]
        if 0.0 < gap <= ROUND_OFF_GAP * program.length:
            N, _, _ = laws[kernel].dispatcher(
                program.tables.p[slice(*p)], 0.0, 0.0, rate, z[normal:end], flow.z[normal:end]
            )
            flow.z[begin : begin + CONTACT_COMMON] = CLOSING_PHASE, flow.clock.t, 0.0, N, rate


def start_episodes(tables: Tables, flow: Flow) -> None:
    """Begin intervals for the contacts that are closed at the start; their onset is not known, hence NaN."""
    z, first = flow.z, tables.contacts.z[:, COMMON_Z]
    closed = z[first + PHASE] != 0.0
    flow.episodes[:] = 0.0
    flow.episodes[closed, START] = flow.episodes[closed, APPROACH] = np.nan
    flow.episodes[closed, PEAK_FORCE] = z[first[closed] + LAST_FORCE]
    flow.episodes[closed, PEAK_DEPTH] = np.maximum(-z[first[closed] + LAST_GAP], 0.0)


def take_episodes(record: RunRecord) -> np.ndarray:
    """Take the recorded rows out of the buffer."""
    rows = record.episodes[: record.count.episodes].copy()
    record.count.episodes = 0
    return rows


def running_episodes(tables: Tables, flow: Flow) -> np.ndarray:
    """Rows of the running contact intervals, with NaN for end and separation speed."""
    phase = flow.z[tables.contacts.z[:, COMMON_Z] + PHASE]
    running = np.flatnonzero(phase != 0.0)
    rows = np.full((len(running), EPISODE_ROW_SIZE), np.nan)
    rows[:, CONTACT] = running
    rows[:, MODE] = np.where(phase[running] == LASTING_PHASE, LASTING, IMPACT)
    rows[:, CARRIED:] = flow.episodes[running]
    return rows
