"""Contact events: steps that end at the onset of a contact, resolve its impact, and end at the separation.

A step across an onset has the contact force for too long or not at all.  So a step that would close a gap is shortened
to end just before the onset, and the contact begins with a step that resolves its impact.  After the separation the
steps are those of the free flight before.  Impacts slower than the tolerance of velocities are not resolved.
"""

import math

import numpy as np

from flexmb.engine.energy import gap_within
from flexmb.engine.state.flow import EPISODE_ROW_SIZE, EPISODE_SIZE, Flow
from flexmb.engine.state.record import EVALUATED, NEVER
from flexmb.engine.system.contacts import call_normal, find_gap
from flexmb.engine.system.work import LOSS_FRICTION, LOSS_IMPULSE, LOSS_NORMAL
from flexmb.kernels import compiled
from flexmb.parts.contact.onset import crossing, cubic
from flexmb.places import GAP, GAP_RATE, NORMAL_FORCE
from flexmb.program import program as at
from flexmb.program.program import Addresses, Program, Tables

# Columns of `Flow.episodes`: start [s], approach speed [m/s], impulse [N s], largest force [N], depth [m], losses [J].
START, APPROACH, IMPULSE, PEAK_FORCE, PEAK_DEPTH, CONTACT_LOSS, FRICTION_LOSS = range(7)
# Columns of `RunRecord.episodes`: contact, mode, end [s], separation speed [m/s]; from CARRIED on as `Flow.episodes`.
CONTACT, MODE, END, SEPARATION, CARRIED = range(5)
IMPACT, LASTING = 1.0, 2.0  # modes of a contact interval, as in the signal `mode`
# Phases of a contact (`system/contacts.py`): in its first compression; compressed again after its first rebound.
CLOSING_PHASE, LASTING_PHASE = 1.0, 3.0
# Gap at the start relative to the size of the mechanism, up to which it is round-off of closing the loops.
ROUND_OFF_GAP = 2e-12
SHORT_WAY = 1e-9  # change of a gap within a step, over the size of the mechanism, whose rate may be round-off


@compiled
def update_episodes(tables, h, options, flow, work, record):
    """Update the running contact intervals to the state of the last evaluation."""
    # Called before the ledger and the histories are updated. Losses are those of the ledger (`work.loss`), so that the
    # losses of all intervals add up to its entries. Impulses are sums of trapezoids in the Newmark family.
    K = tables.contacts
    for c in range(K.kernel.shape[0]):
        k = K.z[c, at.COMMON_Z]
        before, now = flow.z[k + at.PHASE], work.z_new[k + at.PHASE]
        if before == 0.0 and now == 0.0:
            continue
        gap, rate, N = work.contact[c, GAP], work.contact[c, GAP_RATE], work.contact[c, NORMAL_FORCE]
        if before == 0.0:
            flow.episodes[c, START] = work.z_new[k + at.ONSET_TIME]
            gap0, rate0, approach = flow.z[k + at.LAST_GAP], flow.z[k + at.LAST_GAP_RATE], -rate
            if gap0 > 0.0:
                approach = -rate_within(crossing(h, gap0, rate0, gap, rate), h, gap0, rate0, gap, rate, options)
            flow.episodes[c, APPROACH] = max(approach, 0.0)  # 0 for a grazing contact
        depth = max(-gap, 0.0)
        flow.episodes[c, IMPULSE] += work.loss[c, LOSS_IMPULSE]
        flow.episodes[c, CONTACT_LOSS] += work.loss[c, LOSS_NORMAL]
        flow.episodes[c, FRICTION_LOSS] += work.loss[c, LOSS_FRICTION]
        flow.episodes[c, PEAK_FORCE] = max(flow.episodes[c, PEAK_FORCE], N)
        flow.episodes[c, PEAK_DEPTH] = max(flow.episodes[c, PEAK_DEPTH], depth)
        if now == 0.0:
            if options.save_interval < NEVER:
                write_episode(c, h, before, gap, rate, k, options, flow, record)
            for i in range(EPISODE_SIZE):
                flow.episodes[c, i] = 0.0


@compiled
def rate_within(s, h, gap0, rate0, gap, rate, options):
    """Gap rate at fraction s of a step: of the cubic, unless gaps change too little to tell it."""
    _, slope = cubic(s, h, gap0, rate0, gap, rate)
    return slope / h if abs(gap - gap0) > SHORT_WAY * options.length else rate0 + s * (rate - rate0)


@compiled
def write_episode(c, h, phase, gap, rate, k, options, flow, record):
    """Record the interval of contact c, which ended in this step, in a row of the buffer; k : place of its history."""
    row, gap0, rate0 = record.count.episodes, flow.z[k + at.LAST_GAP], flow.z[k + at.LAST_GAP_RATE]
    s = crossing(h, -gap0, -rate0, -gap, -rate)
    record.episodes[row, CONTACT] = c
    record.episodes[row, MODE] = LASTING if phase == LASTING_PHASE else IMPACT
    record.episodes[row, END] = flow.clock.t + s * h
    record.episodes[row, SEPARATION] = max(rate_within(s, h, gap0, rate0, gap, rate, options), 0.0)
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
    numbers = K.p[:, at.NORMAL_P : at.NORMAL_P_END + 1]
    for kernel, p, (begin, normal, end, _) in zip(K.kernel[:, at.NORMAL_LAW], numbers, K.z, strict=True):
        gap, rate = flow.z[begin + at.LAST_GAP], flow.z[begin + at.LAST_GAP_RATE]
        if 0.0 < gap <= ROUND_OFF_GAP * program.length:
            own = program.tables.p[slice(*p)]
            N, _, _ = laws[kernel].dispatcher(own, 0.0, 0.0, rate, z[normal:end], flow.z[normal:end])
            flow.z[begin : begin + at.CONTACT_COMMON] = CLOSING_PHASE, flow.clock.t, 0.0, N, rate


def start_episodes(tables: Tables, flow: Flow) -> None:
    """Begin intervals for the contacts that are closed at the start; their onset is not known, hence NaN."""
    z, first = flow.z, tables.contacts.z[:, at.COMMON_Z]
    closed = z[first + at.PHASE] != 0.0
    flow.episodes[:] = 0.0
    flow.episodes[closed, START] = flow.episodes[closed, APPROACH] = np.nan
    flow.episodes[closed, PEAK_FORCE] = z[first[closed] + at.LAST_FORCE]
    flow.episodes[closed, PEAK_DEPTH] = np.maximum(-z[first[closed] + at.LAST_GAP], 0.0)


def running_episodes(tables: Tables, flow: Flow) -> np.ndarray:
    """Rows of the running contact intervals, with NaN for end and separation speed."""
    phase = flow.z[tables.contacts.z[:, at.COMMON_Z] + at.PHASE]
    running = np.flatnonzero(phase != 0.0)
    rows = np.full((len(running), EPISODE_ROW_SIZE), np.nan)
    rows[:, CONTACT] = running
    rows[:, MODE] = np.where(phase[running] == LASTING_PHASE, LASTING, IMPACT)
    rows[:, CARRIED:] = flow.episodes[running]
    return rows


# Columns of `Flow.impacts`: step that resolves the impact [s] (0: not known), acceleration of the gap in free flight
# [m/s^2], 1 if the normal force jumps at the onset.
IMPACT_STEP, GAP_ACCELERATION, FORCE_JUMPS = range(3)
# Time between the end of a step and an onset or separation, over the step that resolves the impact.
ONSET_TOLERANCE = 0.04
# First trial of an impact over its duration: long enough to measure how the contact brakes, and then rejected.
# A step that changed within an elastic impact would leave the errors of compression and of restitution different.
PROBE_FRACTION = 0.125
JUMP_STEP_FRACTION = 1e-3  # step across an onset with a jump of the force, over the step that resolves the impact
# Duration of an impact over depth / approach speed: pi for a linear spring, 2.94 for exponent 3/2, 2.6 for 3.
DURATION_FACTOR, LEAST_DURATION_FACTOR = 3.0, 2.6
# Largest acceleration of an impact times duration / approach speed: pi for a linear spring, 3.7 for exponent 3/2.
PEAK_ACCELERATION_FACTOR = 3.7
# Required step within an impact over the present one, below and above which the step is changed.
SHORTEN_BELOW, LENGTHEN_ABOVE = 0.8, 1.6
# Time in contact over the estimated duration, above which the error estimate alone chooses the steps.
LONGEST_IMPACT = 3.0
LEAST_DEPTH = 1e-13  # penetration relative to the size of the mechanism, below which it may be round-off
# Part of the time to an onset that a step leaves, where no impact of the contact has been resolved so far.
LEFT_BEFORE_ONSET = 0.05
# Gap relative to the size of the mechanism up to which a step may cross such an onset, to as deep behind it.
NEAR_GAP = 1e-4
# Number of points of a step at which its gaps are computed; difference of a gap from the cubic through both ends, over
# the gap at an end, above which the cubic is not believed.
LOOKS, UNEXPECTED_GAP = 8, 0.25


@compiled
def slow_approach_speed(c, flow, trial):
    """Approach speed of contact c below which its impact is not resolved [m/s]."""
    return trial.control.rtol * flow.largest_speeds[trial.contact_groups[c]]


@compiled
def planned_step(tables, address, options, flow, trial, work):
    """Step to try [s]: the step of the error estimate, that of an impact, or the time to the next predicted onset."""
    h = min(flow.clock.step_size, options.h_max)
    if flow.clock.contact_step > 0.0:
        h = min(h, flow.clock.contact_step)
    if flow.clock.retry_step > 0.0:
        return max(min(h, flow.clock.retry_step), options.h_min)
    for c in range(tables.contacts.kernel.shape[0]):
        k, step = tables.contacts.z[c, at.COMMON_Z], flow.impacts[c, IMPACT_STEP]
        if flow.z[k] != 0.0:
            if step > 0.0 and in_impact(tables, c, flow, trial):
                h = min(h, step)
            continue
        gap, rate, reach = flow.z[k + at.LAST_GAP], flow.z[k + at.LAST_GAP_RATE], h + step
        if gap > reach * (0.5 * reach * abs(flow.impacts[c, GAP_ACCELERATION]) - rate):
            continue  # nothing that is known of the motion closes it within the step
        arrival, speed = predicted_onset(tables, c, flow)
        slow = speed <= slow_approach_speed(c, flow, trial)
        if step == 0.0 or slow:
            if step == 0.0 and rate < 0.0:
                arrival = min(arrival, -gap / rate)
            if gap > NEAR_GAP * options.length:
                h = min(h, (1.0 - LEFT_BEFORE_ONSET) * arrival)
            elif not slow:  # the impact is resolved, but not known from one before
                h = min(h, 2.0 * arrival)
        elif arrival > event_time(step, speed, options, trial):
            h = min(h, max(arrival - 0.5 * event_time(step, speed, options, trial), 0.5 * arrival))
        else:
            find_force_jump(tables, address, c, speed, flow, work)
            probe = max(PROBE_FRACTION * trial.control.impact_steps, 1.0) * step
            h = min(h, step_across_jump(arrival, step) if flow.impacts[c, FORCE_JUMPS] != 0.0 else probe)
    return max(h, options.h_min)


@compiled
def event_time(step, speed, options, trial):
    """Time between the end of a step and an onset or separation at a speed [s], in which gaps change."""
    return max(ONSET_TOLERANCE * trial.control.onset * step, LEAST_DEPTH * options.length / speed)


@compiled
def step_across_jump(arrival, step):
    """Step for an open contact whose force will jump [s]: to just before the onset, then to just after it."""
    little = JUMP_STEP_FRACTION * step
    return arrival - little if arrival > 2.0 * little else arrival + little


@compiled
def predicted_onset(tables, c, flow):
    """Time until the open contact c closes [s], and its approach speed [m/s]; (inf, 0) if it does not close."""
    # Equation (6.3) of docs/theory/events.md.
    k = tables.contacts.z[c, at.COMMON_Z]
    gap, rate = flow.z[k + at.LAST_GAP], flow.z[k + at.LAST_GAP_RATE]
    square = rate * rate - 2.0 * flow.impacts[c, GAP_ACCELERATION] * gap
    if square <= 0.0:
        return math.inf, 0.0
    speed = math.sqrt(square)
    return (math.inf, 0.0) if speed <= rate else (2.0 * gap / (speed - rate), speed)


@compiled
def in_impact(tables, c, flow, trial):
    """Whether the closed contact c is in an impact that the steps resolve."""
    lasted = flow.clock.t - flow.episodes[c, START]
    phase, speed = flow.z[tables.contacts.z[c, at.COMMON_Z]], flow.episodes[c, APPROACH]
    impact = phase != LASTING_PHASE and speed > slow_approach_speed(c, flow, trial)
    return impact and lasted < LONGEST_IMPACT * trial.control.impact_steps * flow.impacts[c, IMPACT_STEP]


@compiled
def normal_force(tables, address, c, gap, rate, flow, work):
    """Normal force of contact c at a gap and a gap rate [N]."""
    N, _, _ = call_normal(tables, address, c, 0.0, gap, rate, flow.z, work.z_between)
    return N


@compiled
def find_force_jump(tables, address, c, speed, flow, work):
    """Find out whether the normal force of contact c jumps at its onset, as that of a damper does."""
    depth = speed * flow.impacts[c, IMPACT_STEP]
    inside = normal_force(tables, address, c, -1e-3 * depth, -speed, flow, work)
    deep = normal_force(tables, address, c, -depth, -speed, flow, work)
    flow.impacts[c, FORCE_JUMPS] = 1.0 if inside > 0.1 * deep else 0.0


@compiled
def step_to_events(tables, address, h, options, flow, trial, work, record):
    """Step that ends at the first contact event within the trial [s]; h if the trial meets all events."""
    wanted = h
    for c in range(tables.contacts.kernel.shape[0]):
        k = tables.contacts.z[c, at.COMMON_Z]
        gap0, rate0 = flow.z[k + at.LAST_GAP], flow.z[k + at.LAST_GAP_RATE]
        gap, rate = work.contact[c, GAP], work.contact[c, GAP_RATE]
        if record.count.evaluated != EVALUATED:
            gap, rate = find_gap(tables, address, c, trial.q, trial.v, False, None, work)
        own = h
        if gap0 > 2.0 * LEAST_DEPTH * options.length > 2.0 * gap > 0.0 and rate < 0.0:
            own = 0.99 * h  # on the onset to round-off, where the force of a law that jumps is any between
        elif gap0 > 0.0 >= gap:
            own = step_to_onset(tables, address, c, h, gap0, rate0, gap, rate, options, flow, trial, work)
        elif gap0 > 0.0:
            if rate0 < 0.0 < rate:
                own = step_to_grazing(c, h, gap0, rate0, gap, rate, options, flow, trial)
            if own >= h:
                own = h * place_unseen(tables, address, c, h, gap0, rate0, gap, rate, options, flow, trial, work)
        elif gap0 <= 0.0 < gap:
            own = step_to_separation(c, h, gap0, rate0, gap, rate, options, flow, trial)
        elif gap0 <= 0.0 and in_impact(tables, c, flow, trial):
            most = 1.3 * PEAK_ACCELERATION_FACTOR * flow.episodes[c, APPROACH] / trial.control.impact_steps
            change = abs(rate - rate0)
            if change > most:
                own = h * max(0.9 * most / change, 0.2)
                flow.impacts[c, IMPACT_STEP] = own
        if own < wanted and (own < 0.999 * h or gap0 > 0.0 >= gap):  # an onset within a trial is never let pass
            wanted = own
            record.count.rejecting_contact = c + 1
    return wanted


@compiled
def step_to_onset(tables, address, c, h, gap0, rate0, gap, rate, options, flow, trial, work):
    """Step for a trial that closes contact c [s]: to just before the onset, or from there into the impact."""
    s = crossing(h, gap0, rate0, gap, rate)
    _, slope = cubic(s, h, gap0, rate0, gap, rate)
    speed, arrival = -slope / h, s * h
    if speed <= slow_approach_speed(c, flow, trial):
        return h
    step = flow.impacts[c, IMPACT_STEP]
    is_known, long = step > 0.0, h > max(0.5 * PROBE_FRACTION * trial.control.impact_steps, 1.5) * step
    if not is_known or (arrival <= event_time(step, speed, options, trial) and long):
        own = rate - flow.impacts[c, GAP_ACCELERATION] * (h - arrival)
        braking = 0.0 if is_known else own - rate0 - flow.impacts[c, GAP_ACCELERATION] * arrival
        step = impact_step(tables, address, c, h, speed, gap, own, braking, options, flow, trial, work)
    flow.impacts[c, IMPACT_STEP] = step
    find_force_jump(tables, address, c, speed, flow, work)
    tolerance = event_time(step, speed, options, trial)
    if arrival <= 1.001 * tolerance:
        if flow.impacts[c, FORCE_JUMPS] != 0.0:  # half of the jump acts all over the step that crosses it
            return h if h <= 4.0 * JUMP_STEP_FRACTION * step else step_across_jump(arrival, step)
        return min(h, step) if is_known or h > 0.5 * step else 0.5 * arrival
    # the contact force delayed the onset of the trial: each rejection goes back further, not beyond that of free flight
    ahead, _ = predicted_onset(tables, c, flow)
    margin = 0.5 * tolerance * 4.0**flow.clock.rejected_trials
    return min(h, max(min(arrival, ahead) - margin, 0.5 * arrival))


@compiled
def step_to_grazing(c, h, gap0, rate0, gap, rate, options, flow, trial):
    """Step for a trial with an open gap of contact c at both ends that may have closed in between [s]."""
    low, high = 0.0, 1.0
    for _ in range(50):
        s = 0.5 * (low + high)
        _, slope = cubic(s, h, gap0, rate0, gap, rate)
        if slope < 0.0:
            low = s
        else:
            high = s
    least, _ = cubic(low, h, gap0, rate0, gap, rate)
    if least > -LEAST_DEPTH * options.length:
        return h
    minimum = low * h
    s = crossing(minimum, gap0, rate0, least, 0.0)
    _, slope = cubic(s, minimum, gap0, rate0, least, 0.0)
    if -slope / minimum <= slow_approach_speed(c, flow, trial):
        return minimum
    arrival = s * minimum
    step = 2.0 * (minimum - arrival) / trial.control.impact_steps
    if flow.impacts[c, IMPACT_STEP] > 0.0:
        step = min(step, flow.impacts[c, IMPACT_STEP])
    flow.impacts[c, IMPACT_STEP] = step
    tolerance = ONSET_TOLERANCE * trial.control.onset * step
    return arrival + step if arrival <= tolerance else max(arrival - 0.5 * tolerance, 0.5 * arrival)


@compiled
def place_unseen(tables, address, c, h, gap0, rate0, gap, rate, options, flow, trial, work):
    """Fraction of a step at which contact c, open at both ends, is closed or far from their cubic; 1: nowhere."""
    larger = max(gap0, gap)
    if (gap0 > -h * rate0 and gap > h * rate) or larger < NEAR_GAP * options.length:
        return 1.0
    for k in range(1, LOOKS):
        s = k / LOOKS
        gap_within(tables, address, c, s, h, flow, trial.q, trial.v, work)
        expected, _ = cubic(s, h, gap0, rate0, gap, rate)
        if abs(work.gap[GAP] - expected) > UNEXPECTED_GAP * larger or work.gap[GAP] < -LEAST_DEPTH * options.length:
            return s
    return 1.0


@compiled
def note_passed_contacts(tables, address, h, options, flow, trial, work, record):
    """Instants at which a fixed step first passed a contact unseen."""
    for c in range(tables.contacts.kernel.shape[0]):
        k = tables.contacts.z[c, at.COMMON_Z]
        gap0, rate0 = flow.z[k + at.LAST_GAP], flow.z[k + at.LAST_GAP_RATE]
        gap, rate = work.contact[c, GAP], work.contact[c, GAP_RATE]
        if gap0 > 0.0 and gap > 0.0 and record.passed[c] == 0.0:
            s = place_unseen(tables, address, c, h, gap0, rate0, gap, rate, options, flow, trial, work)
            record.passed[c] = flow.clock.t + s * h if s < 1.0 else 0.0


@compiled
def step_to_separation(c, h, gap0, rate0, gap, rate, options, flow, trial):
    """Step for a trial that opens contact c [s]: to just after the separation."""
    step, s = flow.impacts[c, IMPACT_STEP], crossing(h, -gap0, -rate0, -gap, -rate)
    _, slope = cubic(s, h, gap0, rate0, gap, rate)
    if step == 0.0 or slope / h <= slow_approach_speed(c, flow, trial):
        return h
    after = event_time(step, slope / h, options, trial)
    return h if (1.0 - s) * h <= 0.5 * after else s * h + 0.25 * after


@compiled
def impact_step(tables, address, c, h, speed, gap, rate, braking, options, flow, trial, work):
    """Step that resolves the impact which began in a trial of size h [s], from the work of the normal force so far."""
    # The force is taken as a power of the depth. A trial whose gap rate has changed its sign is too long; the mass then
    # follows from force and change of rate, as it does from `braking`, the change in the short trial of a first impact.
    # Equation (6.5) of docs/theory/events.md.
    depth = -gap
    N = normal_force(tables, address, c, -depth, -speed, flow, work)
    if not (N > 0.0 and depth > 0.0):
        return h
    n, factor = force_exponent(tables, address, c, depth, speed, N, flow, work), DURATION_FACTOR
    if braking > 0.0 and rate < -0.5 * speed:
        energy = 0.5 * (0.5 * h * N / braking) * speed * speed
        depth, share = depth_of_impact(tables, address, c, depth, speed, energy, flow, work), 1.0
        factor = LEAST_DURATION_FACTOR
    elif rate < -0.5 * speed:
        share = speed * speed / max(speed * speed - rate * rate, 1e-3 * speed * speed)
    else:
        mass = options.regular.gamma * h * N / (rate + speed)
        share = (n + 1.0) * mass * speed * speed / (2.0 * N * depth)
    T = factor * depth * share ** (1.0 / (n + 1.0)) / speed
    return impact_duration(T, speed, flow.impacts[c, GAP_ACCELERATION]) / trial.control.impact_steps


@compiled
def depth_of_impact(tables, address, c, depth, speed, energy, flow, work):
    """Depth, above a first one, at which the normal force at the approach speed has taken an energy [J] [m]."""
    N, taken = normal_force(tables, address, c, -depth, -speed, flow, work), 0.0
    while True:
        further = normal_force(tables, address, c, -2.0 * depth, -speed, flow, work)
        part = 0.5 * (N + further) * depth
        if not taken + part < energy:
            return depth * (1.0 + (energy - taken) / part)
        taken, N, depth = taken + part, further, 2.0 * depth


@compiled
def impact_duration(alone, speed, gap_acceleration):
    """Duration of an impact [s] under other forces, `alone` without them."""
    # The limit without contact stiffness is 2 speed / gap_acceleration. Between both limits, for a linear spring with
    # gap_acceleration = omega speed, the exact duration is (pi/2)/omega; this interpolation gives 1.52/omega.
    # Equation (6.6) of docs/theory/events.md.
    if gap_acceleration <= 0.0:
        return alone
    return (alone**-1.5 + (0.5 * gap_acceleration / speed) ** 1.5) ** (-2.0 / 3.0)


@compiled
def force_exponent(tables, address, c, depth, speed, N, flow, work):
    """Exponent of the normal force of contact c near a depth, limited to 1 ... 3."""
    # Equation (6.4) of docs/theory/events.md.
    double = normal_force(tables, address, c, -2.0 * depth, -speed, flow, work)
    return min(max(math.log(max(double / N, 1.0)) / math.log(2.0), 1.0), 3.0)


@compiled
def update_impacts(tables, address, h, options, flow, trial, work):
    """Update the steps of impacts after an accepted step; whether the next step is a starting step, as after a jump."""
    # Called after `step_to_events`, while `flow` still is the state before the step.
    restarts = False
    for c in range(tables.contacts.kernel.shape[0]):
        k = tables.contacts.z[c, at.COMMON_Z]
        gap0, rate0 = flow.z[k + at.LAST_GAP], flow.z[k + at.LAST_GAP_RATE]
        gap, rate = work.contact[c, GAP], work.contact[c, GAP_RATE]
        if gap > 0.0:
            flow.impacts[c, GAP_ACCELERATION] = (rate - rate0) / h if gap0 > 0.0 else 0.0
            if gap0 <= 0.0 and rate > slow_approach_speed(c, flow, trial):
                restarts, flow.clock.contact_step = True, 0.0
        elif gap0 > 0.0:
            restarts = restarts or flow.impacts[c, FORCE_JUMPS] != 0.0
            flow.impacts[c, FORCE_JUMPS] = 0.0
        elif flow.z[k] == 1.0 and in_impact(tables, c, flow, trial):
            speed = flow.episodes[c, APPROACH]
            own = rate - flow.impacts[c, GAP_ACCELERATION] * (flow.clock.t + h - flow.episodes[c, START])
            left = own * own / (speed * speed)
            if own < 0.0 and 0.4 < left < 0.9:
                N = normal_force(tables, address, c, gap, -speed, flow, work)
                n = force_exponent(tables, address, c, -gap, speed, N, flow, work) if N > 0.0 else 1.0
                T = DURATION_FACTOR * -gap * (1.0 - left) ** (-1.0 / (n + 1.0)) / speed
                step = impact_duration(T, speed, flow.impacts[c, GAP_ACCELERATION]) / trial.control.impact_steps
                present = flow.impacts[c, IMPACT_STEP]
                if not SHORTEN_BELOW * present < step < LENGTHEN_ABOVE * present:
                    flow.impacts[c, IMPACT_STEP] = step
    return restarts
