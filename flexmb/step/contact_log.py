"""Episodes of contact in the compiled loop: followed at every accepted step, written down where they end.

An episode lasts from the instant where the gap falls through zero to that where it rises through zero again.  Both are
roots of the cubic through gap and gap rate at the ends of a step, as the onset is for the contact laws.
"""

from __future__ import annotations

import numpy as np

from flexmb.contact.onset import crossing, cubic
from flexmb.kernels import compiled
from flexmb.places import GAP, GAP_RATE, NORMAL_FORCE
from flexmb.program.program import Program
from flexmb.program.tables import (
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
    Tables,
)
from flexmb.state.flow import CONTACT_MEMORY, EPISODE, EPISODE_ROW, PRESSED, Flow
from flexmb.state.options import NEVER
from flexmb.state.record import RunRecord
from flexmb.system.work import LOSS_FRICTION, LOSS_NORMAL

START, APPROACH, IMPULSE, PEAK_FORCE, PEAK_DEPTH, CONTACT_LOSS, FRICTION_LOSS = range(7)
"""Columns of `Flow.episodes`: start [s], approach speed [m/s], impulse [N s], largest force [N] and depth [m], losses
[J]."""

CONTACT, MODE, END, SEPARATION, CARRIED = range(5)
"""Columns of a row that is written down: contact, mode, end [s], separation speed [m/s]; then those of `Flow.episodes`
from CARRIED on."""

IMPACT, LASTING = 1.0, 2.0
"""Modes, those of the signal `mode`."""

CLOSING_PHASE, LASTING_PHASE = 1.0, 3.0
"""Phases of a contact in its first approach, and of one that was pressed together again after its first rebound
(`system/contacts.py`)."""

TOUCHES = 2e-12
"""Gap at the start, relative to the size of the mechanism, that may be left over from closing the loops."""


@compiled
def follow_contacts(tables, h, options, flow, work, record):
    """Bring the running episodes to the state of the last evaluation, before ledger and histories are.

    Losses are those that the ledger books (`work.loss`), so those of all episodes add up to what it says; impulses
    are sums of trapezoids, as the momentum that the Newmark family moves.
    """
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
        m, depth = CONTACT_MEMORY * c, max(-gap, 0.0)
        flow.episodes[c, IMPULSE] += 0.5 * h * (flow.memory[m + PRESSED] + N)
        flow.episodes[c, CONTACT_LOSS] += work.loss[c, LOSS_NORMAL]
        flow.episodes[c, FRICTION_LOSS] += work.loss[c, LOSS_FRICTION]
        flow.episodes[c, PEAK_FORCE] = max(flow.episodes[c, PEAK_FORCE], N)
        flow.episodes[c, PEAK_DEPTH] = max(flow.episodes[c, PEAK_DEPTH], depth)
        if now == 0.0:
            if options.save_interval < NEVER:
                write_down(c, h, before, gap, rate, k, flow, record)
            for i in range(EPISODE):
                flow.episodes[c, i] = 0.0


@compiled
def speed_at_crossing(h, gap0, rate0, gap1, rate1):
    """Approach speed where the gap falls through zero; 0 for a grazing one."""
    if gap0 <= 0.0:
        return max(-rate1, 0.0)
    s = crossing(h, gap0, rate0, gap1, rate1)
    _, slope = cubic(s, h, gap0, rate0, gap1, rate1)
    return max(-slope / h, 0.0)


@compiled
def write_down(c, h, phase, gap, rate, k, flow, record):
    """One row of the buffer for the episode of contact c, which ended in this step; k : place of its history."""
    row = record.count.episodes
    gap0, rate0 = flow.z[k + LAST_GAP], flow.z[k + LAST_GAP_RATE]
    s = crossing(h, -gap0, -rate0, -gap, -rate)
    _, slope = cubic(s, h, gap0, rate0, gap, rate)
    record.episodes[row, CONTACT] = c
    record.episodes[row, MODE] = LASTING if phase == LASTING_PHASE else IMPACT
    record.episodes[row, END] = flow.clock.t + s * h
    record.episodes[row, SEPARATION] = max(slope / h, 0.0)
    for i in range(EPISODE):
        record.episodes[row, CARRIED + i] = flow.episodes[c, i]
    record.count.episodes += 1


@compiled
def no_room(flow, record):
    """Whether the next step could end more episodes than the buffer has room for."""
    return record.count.episodes + flow.episodes.shape[0] > record.episodes.shape[0]


def close_what_touches(program: Program, z: np.ndarray, flow: Flow) -> None:
    """Take contacts for closed whose gap in a start state is round-off, with the histories of a gap of 0.

    As an onset, it would have an approach speed of round-off.

    Parameters
    ----------
    program : the compiled mechanism.
    z : (n_z,) histories that the start state was evaluated with.
    flow : the start state; its histories are changed.
    """
    K, laws = program.tables.contacts, program.kernels[Addresses._fields.index("normal")]
    for kernel, p, (begin, normal, end, _) in zip(
        K.kernel[:, NORMAL_LAW], K.p[:, NORMAL_P : NORMAL_P_END + 1], K.z, strict=True
    ):
        gap, rate = flow.z[begin + LAST_GAP], flow.z[begin + LAST_GAP_RATE]
        if 0.0 < gap <= TOUCHES * program.length:
            N, _, _ = laws[kernel].dispatcher(
                program.tables.p[slice(*p)], 0.0, 0.0, rate, z[normal:end], flow.z[normal:end]
            )
            flow.z[begin : begin + CONTACT_COMMON] = CLOSING_PHASE, flow.clock.t, 0.0, N, rate


def touching_from_the_start(tables: Tables, flow: Flow) -> None:
    """Begin episodes of the contacts that are closed in a state whose past is not known: their start is NaN."""
    z, first = flow.z, tables.contacts.z[:, COMMON_Z]
    closed = z[first + PHASE] != 0.0
    flow.episodes[:] = 0.0
    flow.episodes[closed, START] = flow.episodes[closed, APPROACH] = np.nan
    flow.episodes[closed, PEAK_FORCE] = z[first[closed] + LAST_FORCE]
    flow.episodes[closed, PEAK_DEPTH] = np.maximum(-z[first[closed] + LAST_GAP], 0.0)


def taken_out(record: RunRecord) -> np.ndarray:
    """The rows of the buffer, which is empty afterwards."""
    rows = record.episodes[: record.count.episodes].copy()
    record.count.episodes = 0
    return rows


def still_running(tables: Tables, flow: Flow) -> np.ndarray:
    """Rows of the episodes that have not ended: end and separation speed are NaN, the rest is what it is so far."""
    phase = flow.z[tables.contacts.z[:, COMMON_Z] + PHASE]
    running = np.flatnonzero(phase != 0.0)
    rows = np.full((len(running), EPISODE_ROW), np.nan)
    rows[:, CONTACT] = running
    rows[:, MODE] = np.where(phase[running] == LASTING_PHASE, LASTING, IMPACT)
    rows[:, CARRIED:] = flow.episodes[running]
    return rows
