"""Steps that respect contacts: where the next one may end, and whether a trial met the contacts well.

A step across the onset of a contact sees its force for too long or not at all.  So a step that would close a gap is
shortened to end just outside, and the contact begins with a step that fits its impact; where the contact ends the
flight goes on with the step that was good before it.  Impacts slower than the accepted error of velocities change
nothing that is asked for, and are met as they come.
"""

import math

from flexmb.contact.onset import crossing, cubic
from flexmb.kernels import compiled
from flexmb.places import GAP, GAP_RATE
from flexmb.program.tables import COMMON_Z, LAST_GAP, LAST_GAP_RATE
from flexmb.state.record import ALL_KNOWN
from flexmb.step.contact_log import APPROACH, LASTING_PHASE, START
from flexmb.system.contacts import call_normal, find_gap

STEP, GAP_ACCELERATION, JUMPS = range(3)
"""Columns of `Flow.impacts`: step for the impact [s] (0: not known), acceleration of the gap in flight [m/s^2], whether
the force jumps where the contact begins."""

REACH = 0.04
"""A contact begins, or has ended, within this part of an impact's step."""

PROBE = 0.125
"""First trial of an impact over its duration: long enough to see how the contact brakes, and then refused.

Else the step would be changed within the impact, and what is wrong on the way in would not be made good on the way out.
"""

CROSSING = 1e-3
"""Step just into a contact whose force jumps, as a part of an impact's step."""

DURATION = 3.0
"""Duration of an impact over depth / approach speed: pi for a linear spring, 2.94 for the power 3/2, 2.6 for 3."""

STEEPEST = 3.7
"""Largest acceleration of an impact times its duration over its approach speed: pi for a linear spring, 3.7 for 3/2."""

LESS, MORE = 0.8, 1.6
"""The step is changed within an impact where it should be less or more than these parts of it."""

LASTS = 3.0
"""An impact that takes longer than this many times its estimated duration is a slow process, left to the error."""

LEAST_DIP = 1e-13
"""A gap that falls below zero by less than this part of the size of the mechanism may be round-off."""


@compiled
def slow(flow, trial):
    """Approach speed below which a contact needs no resolution [m/s]."""
    return trial.bounds.rtol * flow.clock.speed


@compiled
def planned(tables, address, options, flow, trial, work):
    """The step to try: what the error allows, not beyond the next onset that is foreseen, short in an impact."""
    h = flow.clock.size
    if flow.clock.brake > 0.0:
        h = min(h, flow.clock.brake)
    if flow.clock.again > 0.0:
        return max(min(h, flow.clock.again), options.h_min)
    for c in range(tables.contacts.kernel.shape[0]):
        step = flow.impacts[c, STEP]
        if step == 0.0:
            continue
        if flow.z[tables.contacts.z[c, COMMON_Z]] != 0.0:
            if struck(tables, c, flow, trial):
                h = min(h, step)
            continue
        arrival, speed = foreseen(tables, c, flow)
        if speed <= slow(flow, trial):
            continue
        if arrival > REACH * step:
            h = min(h, max(arrival - 0.5 * REACH * step, 0.5 * arrival))
        else:
            find_jump(tables, address, c, speed, flow, work)
            probe = max(PROBE * trial.bounds.impact_steps, 1.0) * step
            h = min(h, across(arrival, step) if flow.impacts[c, JUMPS] != 0.0 else probe)
    return max(h, options.h_min)


@compiled
def across(arrival, step):
    """The step for an open contact whose force will jump: to right before the onset, and then right behind it."""
    little = CROSSING * step
    return arrival - little if arrival > 2.0 * little else arrival + little


@compiled
def foreseen(tables, c, flow):
    """Time until the open contact c closes and its approach speed then, (inf, 0) when it does not."""
    k = tables.contacts.z[c, COMMON_Z]
    gap, rate, bend = flow.z[k + LAST_GAP], flow.z[k + LAST_GAP_RATE], flow.impacts[c, GAP_ACCELERATION]
    square = rate * rate - 2.0 * bend * gap
    if square <= 0.0:
        return math.inf, 0.0
    speed = math.sqrt(square)
    if speed <= rate:
        return math.inf, 0.0
    return 2.0 * gap / (speed - rate), speed


@compiled
def struck(tables, c, flow, trial):
    """Whether the closed contact c is in an impact that needs its own steps."""
    lasted = flow.clock.t - flow.episodes[c, START]
    impact = flow.z[tables.contacts.z[c, COMMON_Z]] != LASTING_PHASE and flow.episodes[c, APPROACH] > slow(flow, trial)
    return impact and lasted < LASTS * trial.bounds.impact_steps * flow.impacts[c, STEP]


@compiled
def force(tables, address, c, gap, rate, flow, work):
    """Normal force of contact c at another gap and rate."""
    N, _, _ = call_normal(tables, address, c, 0.0, gap, rate, flow.z, work.z_between)
    return N


@compiled
def find_jump(tables, address, c, speed, flow, work):
    """Note whether the force is there at once when contact c begins, as that of a damper is."""
    depth = speed * flow.impacts[c, STEP]
    inside, deep = (
        force(tables, address, c, -1e-3 * depth, -speed, flow, work),
        force(tables, address, c, -depth, -speed, flow, work),
    )
    flow.impacts[c, JUMPS] = 1.0 if inside > 0.1 * deep else 0.0


@compiled
def measure(tables, address, c, trial, work, record):
    """Gap and gap rate of contact c in the trial state."""
    if record.count.known == ALL_KNOWN:
        return work.contact[c, GAP], work.contact[c, GAP_RATE]
    return find_gap(tables, address, c, trial.q, trial.v, work)


@compiled
def located(tables, address, h, options, flow, trial, work, record):
    """The step to try instead of h so that contacts are met; h itself when it is good."""
    wanted = h
    for c in range(tables.contacts.kernel.shape[0]):
        k = tables.contacts.z[c, COMMON_Z]
        gap0, rate0 = flow.z[k + LAST_GAP], flow.z[k + LAST_GAP_RATE]
        gap, rate = measure(tables, address, c, trial, work, record)
        own = h
        if gap0 > 0.0 >= gap:
            own = onset(tables, address, c, h, gap0, rate0, gap, rate, options, flow, trial, work)
        elif gap0 > 0.0 and rate0 < 0.0 < rate:
            own = graze(c, h, gap0, rate0, gap, rate, options, flow, trial)
        elif gap0 <= 0.0 < gap:
            own = release(c, h, gap0, rate0, gap, rate, flow, trial)
        elif gap0 <= 0.0 and struck(tables, c, flow, trial):
            most = 1.3 * STEEPEST * flow.episodes[c, APPROACH] / trial.bounds.impact_steps
            change = abs(rate - rate0)
            if change > most:
                own = h * max(0.9 * most / change, 0.2)
                flow.impacts[c, STEP] = own
        if own < wanted:
            wanted = own
            record.count.contact = c + 1
    return wanted


@compiled
def onset(tables, address, c, h, gap0, rate0, gap, rate, options, flow, trial, work):
    """The step for a trial that closes contact c: to just before the onset, or from there into the impact."""
    s = crossing(h, gap0, rate0, gap, rate)
    _, slope = cubic(s, h, gap0, rate0, gap, rate)
    speed, arrival = -slope / h, s * h
    if speed <= slow(flow, trial):
        return h
    step = flow.impacts[c, STEP]
    if step == 0.0 or (arrival <= REACH * step and h > max(0.5 * PROBE * trial.bounds.impact_steps, 1.5) * step):
        own = rate - flow.impacts[c, GAP_ACCELERATION] * (h - arrival)
        step = impact_step(tables, address, c, h, speed, gap, own, options, flow, trial, work)
    flow.impacts[c, STEP] = step
    if arrival <= 1.001 * REACH * step:
        return min(h, step)
    # the trial felt the contact, so its gap came through zero later: each refusal goes back further, and no further on
    # than flight alone would
    ahead, _ = foreseen(tables, c, flow)
    margin = 0.5 * REACH * step * 4.0**flow.clock.refused
    return min(h, max(min(arrival, ahead) - margin, 0.5 * arrival))


@compiled
def graze(c, h, gap0, rate0, gap, rate, options, flow, trial):
    """The step for a trial whose gap of contact c is open at both ends, falls and rises: perhaps it closed between."""
    low, high = 0.0, 1.0
    for _ in range(50):
        s = 0.5 * (low + high)
        _, slope = cubic(s, h, gap0, rate0, gap, rate)
        if slope < 0.0:
            low = s
        else:
            high = s
    least, _ = cubic(low, h, gap0, rate0, gap, rate)
    if least > -LEAST_DIP * options.length:
        return h
    part = low * h
    s = crossing(part, gap0, rate0, least, 0.0)
    _, slope = cubic(s, part, gap0, rate0, least, 0.0)
    if -slope / part <= slow(flow, trial):
        return part
    arrival = s * part
    step = 2.0 * (part - arrival) / trial.bounds.impact_steps
    if flow.impacts[c, STEP] > 0.0:
        step = min(step, flow.impacts[c, STEP])
    flow.impacts[c, STEP] = step
    return arrival + step if arrival <= REACH * step else max(arrival - 0.5 * REACH * step, 0.5 * arrival)


@compiled
def release(c, h, gap0, rate0, gap, rate, flow, trial):
    """The step for a trial that opens contact c: to just after its end."""
    step = flow.impacts[c, STEP]
    s = crossing(h, -gap0, -rate0, -gap, -rate)
    _, slope = cubic(s, h, gap0, rate0, gap, rate)
    if step == 0.0 or slope / h <= slow(flow, trial) or (1.0 - s) * h <= 0.5 * REACH * step:
        return h
    return s * h + 0.25 * REACH * step


@compiled
def impact_step(tables, address, c, h, speed, gap, rate, options, flow, trial, work):
    """Step for the impact that began in a trial of size h, from the energy that its force has taken until `gap`.

    The force is taken as a power of the depth.  Where the gap rate has turned, the step is far too long and the depth
    says nothing: then the mass that meets the contact is found from force and change of rate.  `rate` is without what
    the other forces changed since the onset, which is taken for what they did in the flight before.
    """
    depth = -gap
    N = force(tables, address, c, -depth, -speed, flow, work)
    if not (N > 0.0 and depth > 0.0):
        return h
    n = power(tables, address, c, depth, speed, N, flow, work)
    if rate < -0.5 * speed:
        share = speed * speed / max(speed * speed - rate * rate, 1e-3 * speed * speed)
    else:
        mass = options.regular.gamma * h * N / (rate + speed)
        share = (n + 1.0) * mass * speed * speed / (2.0 * N * depth)
    T = DURATION * depth * share ** (1.0 / (n + 1.0)) / speed
    return lasting(T, speed, flow.impacts[c, GAP_ACCELERATION]) / trial.bounds.impact_steps


@compiled
def lasting(alone, speed, bend):
    """Duration of an impact of duration `alone` when other forces draw the surfaces apart: 2 speed / bend without it.

    Between the two: for a linear spring and bend = omega speed, (pi/2)/omega, this gives 1.52/omega.
    """
    if bend <= 0.0:
        return alone
    return (alone**-1.5 + (0.5 * bend / speed) ** 1.5) ** (-2.0 / 3.0)


@compiled
def power(tables, address, c, depth, speed, N, flow, work):
    """Exponent of the force of contact c near this depth, 1 to 3."""
    double = force(tables, address, c, -2.0 * depth, -speed, flow, work)
    return min(max(math.log(max(double / N, 1.0)) / math.log(2.0), 1.0), 3.0)


@compiled
def remember(tables, address, h, options, flow, trial, work):
    """What the accepted step says of the contacts; whether the next one is a first step, since a force jumped or ended.

    Called while `flow` still holds the state before the step, after `located`.
    """
    anew = False
    for c in range(tables.contacts.kernel.shape[0]):
        k = tables.contacts.z[c, COMMON_Z]
        gap0, rate0 = flow.z[k + LAST_GAP], flow.z[k + LAST_GAP_RATE]
        gap, rate = work.contact[c, GAP], work.contact[c, GAP_RATE]
        if gap > 0.0:
            flow.impacts[c, GAP_ACCELERATION] = (rate - rate0) / h if gap0 > 0.0 else 0.0
            if gap0 <= 0.0 and rate > slow(flow, trial):
                anew = True
                flow.clock.brake = 0.0
        elif gap0 > 0.0:
            anew = anew or flow.impacts[c, JUMPS] != 0.0
            flow.impacts[c, JUMPS] = 0.0
        elif flow.z[k] == 1.0 and struck(tables, c, flow, trial):
            speed = flow.episodes[c, APPROACH]
            own = rate - flow.impacts[c, GAP_ACCELERATION] * (flow.clock.t + h - flow.episodes[c, START])
            left = own * own / (speed * speed)
            if own < 0.0 and 0.4 < left < 0.9:
                n = power_of(tables, address, c, gap, speed, flow, work)
                T = DURATION * -gap * (1.0 - left) ** (-1.0 / (n + 1.0)) / speed
                step = lasting(T, speed, flow.impacts[c, GAP_ACCELERATION]) / trial.bounds.impact_steps
                if not LESS * flow.impacts[c, STEP] < step < MORE * flow.impacts[c, STEP]:
                    flow.impacts[c, STEP] = step
    return anew


@compiled
def power_of(tables, address, c, gap, speed, flow, work):
    """`power` at a gap whose force is not known yet."""
    N = force(tables, address, c, gap, -speed, flow, work)
    return power(tables, address, c, -gap, speed, N, flow, work) if N > 0.0 else 1.0
