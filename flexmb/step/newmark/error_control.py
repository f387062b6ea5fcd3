"""Step control of the implicit loop: an estimate of the local error, and what becomes of the step."""

import math

from flexmb.kernels import compiled
from flexmb.program.tables import COMMON_Z
from flexmb.state.record import RUNNING
from flexmb.step.contact_events import STEP, located

TURNS = 8
"""Trials of one step, at most, that look for a contact."""

SAME, GROWS = 0.95, 1.2
"""A step is kept where the error asks for a factor between these, so that factors of the matrix can be used again."""


SAFETY = 0.9
"""Part of what the error allows that a step becomes; and most that remains of a step that is refused."""


@compiled
def velocity_constant(scheme):
    """Factor of h^3 a'' in the local error of velocities.

    x stands for a at a time Delta h later up to e h^2 a'', by its recurrence; the sum (1 - gamma) x0 + gamma x1 is
    compared with the mean of a.
    """
    am, af = scheme.alpha_m, scheme.alpha_f
    delta = am - af
    e = 0.5 * ((1.0 - af) - (1.0 - am) * (1.0 + 2.0 * delta) - delta * delta)
    own = 0.5 * (delta * delta + scheme.gamma * (1.0 + 2.0 * delta)) - 1.0 / 6.0
    return max(abs(own + e), 0.02)


@compiled
def error_ratio(tables, h, ratio, scheme, options, flow, trial):
    """Estimated local error of positions and velocities over the accepted one.

    Positions: h^2 |beta - 1/6| |x1 - x0|.  Velocities of rigid bodies: c h^3 |a''| with a'' from the last three
    accelerations; h |a1 - a0| / 12 where there are two.  An acceleration that turns back every step is a wave that is
    not resolved: its difference says nothing of a''.  Velocities of the nodes of beams are not looked at.

    In free flight positions count more (`FLIGHT`): their errors add up, and decide where the next impact hits.
    """
    h0 = flow.clock.last
    of_q = h * h * max(abs(scheme.beta - 1.0 / 6.0), 0.05) / options.error
    if flying(tables, flow):
        of_q *= trial.bounds.flight
    of_v = h / (trial.bounds.rtol * fastest(tables.sizes.n_q, options, flow, trial))
    of_bend = 2.0 * velocity_constant(scheme) * h * h / (h + h0)
    worst = 0.0
    for k in range(0, tables.sizes.n_q, 3):
        worst = max(worst, missed(k, k + 2, h, ratio, of_q, of_v, of_bend, flow, trial))
        worst = max(worst, options.length * missed(k + 2, k + 3, h, ratio, of_q, of_v, of_bend, flow, trial))
    if not math.isfinite(worst):
        return math.inf
    return worst


@compiled
def missed(begin, end, h, ratio, of_q, of_v, of_bend, flow, trial):
    """Error of a node: of x and y together, so that no direction counts more, or of its angle."""
    first, h0 = flow.clock.last == 0.0, flow.clock.last
    of_x, of_a, along = 0.0, 0.0, 0.0
    for i in range(begin, end):
        x0 = flow.a[i] + ratio * (flow.x[i] - flow.a[i])
        of_x += (trial.x[i] - x0) ** 2
        rise, before = trial.a[i] - flow.a[i], flow.a[i] - flow.past[0, i]
        along += rise * before
        of_a += (rise / 12.0 if first else of_bend * (rise / h - before / h0)) ** 2
    e = of_q * math.sqrt(of_x)
    if trial.rigid[begin] and (first or along >= 0.0):
        e = max(e, of_v * math.sqrt(of_a))
    return e


@compiled
def flying(tables, flow):
    """Whether there are contacts and none is closed."""
    for c in range(tables.contacts.kernel.shape[0]):
        if flow.z[tables.contacts.z[c, COMMON_Z]] != 0.0:
            return False
    return tables.contacts.kernel.shape[0] > 0


@compiled
def fastest(n, options, flow, trial):
    """Largest speed of the run up to the trial state [m/s]; angles count by the size of the mechanism."""
    most, v = max(flow.clock.speed, trial.bounds.least_speed), trial.v
    for k in range(0, n, 3):
        most = max(most, math.sqrt(v[k] ** 2 + v[k + 1] ** 2), options.length * abs(v[k + 2]))
    return most


@compiled
def allowed(error):
    """What a step may become by its error over the accepted one, over its size."""
    return min(max(SAFETY * max(error, 1e-12) ** (-1.0 / 3.0), 0.2), 2.0)


@compiled
def judged(tables, h, error, growth, options, flow, trial, record):
    """Factor for the next step, 0 when the trial is refused; then the clock holds what to try.

    error : of the trial over the accepted one, negative where it did not converge or did not meet its contacts.
    growth : what the step may become by this error, over h.
    """
    if 0.0 <= error <= 1.0:
        flow.clock.speed = fastest(tables.sizes.n_q, options, flow, trial)
        return growth
    if error > 1.0:
        shorten(h, min(growth, SAFETY), flow, record)
    flow.clock.refused += 1.0
    record.count.rejected += 1
    record.step.refused = h
    return 0.0


@compiled
def met(tables, address, code, h, options, flow, trial, work, record):
    """Whether the trial converged and meets the contacts well, or nearly so where no smaller step is allowed."""
    if code != RUNNING:
        shorten(h, 0.25, flow, record)
        return False
    if flow.clock.refused >= TURNS:
        return True
    wanted = located(tables, address, h, options, flow, trial, work, record)
    if wanted >= 0.999 * h or (h <= 1.001 * options.h_min and fits(options, flow, record)):
        return True
    flow.clock.again = wanted
    return False


@compiled
def fits(options, flow, record):
    """Whether the contact that asks for less could have its impact with the smallest step: then it is only met late."""
    contact = record.count.contact - 1
    return flow.impacts[contact, STEP] >= options.h_min


@compiled
def shorten(h, factor, flow, record):
    """Try again with a part of h; the step of the flight stays what it is where a contact had asked for less."""
    flow.clock.again, record.count.contact = 0.0, 0
    if h < 0.99 * flow.clock.size:
        flow.clock.brake = h * factor
    else:
        flow.clock.size = h * factor


@compiled
def resize(h, growth, options, flow):
    """The sizes for the next step after an accepted one; nothing grows right after a refusal."""
    keep = (growth >= SAME and growth < GROWS) or (growth >= GROWS and flow.clock.refused > 0.0)
    if not keep and h >= 0.99 * flow.clock.size:
        flow.clock.size = min(h * growth, options.h_max)
    elif not keep and h >= 0.99 * flow.clock.brake > 0.0:
        flow.clock.brake = h * growth
    if flow.clock.brake >= flow.clock.size:
        flow.clock.brake = 0.0
    flow.clock.again, flow.clock.refused = 0.0, 0.0
