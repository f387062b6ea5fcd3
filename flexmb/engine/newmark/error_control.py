"""Step control of the Newmark family: estimate of the local error, acceptance of a trial, next step size."""

import math

from flexmb.engine.state.record import RUNNING
from flexmb.engine.step.contact_events import IMPACT_STEP, step_to_events
from flexmb.kernels import compiled, copy
from flexmb.program.program import COMMON_Z

CONTACT_TRIALS = 8  # number of trials of one step at most that locate a contact event
# Growth factors of a step between which its size is kept, so that the factors of the matrix can be reused.
UNCHANGED_FROM, UNCHANGED_TO = 0.95, 1.2
LEAST_STATE = 1e-300  # least scale of a state of a control, so that a state which stays 0 has no error
SAFETY = 0.9  # safety factor of the next step; also the largest factor of a rejected step


@compiled
def velocity_constant(scheme):
    """Error constant c of the velocities, whose local error is c h^3 a''."""
    # By the recurrence of x, x is the acceleration a at a time (alpha_m - alpha_f) h later, up to e h^2 a''. The error
    # is the difference between (1 - gamma) x0 + gamma x1 and the mean of a over the step.
    # Equations (4.12) and (4.13) of docs/theory/integrators.md.
    am, af = scheme.alpha_m, scheme.alpha_f
    delta = am - af
    e = 0.5 * ((1.0 - af) - (1.0 - am) * (1.0 + 2.0 * delta) - delta * delta)
    own = 0.5 * (delta * delta + scheme.gamma * (1.0 + 2.0 * delta)) - 1.0 / 6.0
    return max(abs(own + e), 0.02)


@compiled
def error_ratio(tables, h, ratio, scheme, options, flow, trial):
    """Estimated local error of positions and velocities over the accepted error."""
    # Positions: h^2 |beta - 1/6| |x1 - x0|. Velocities of rigid bodies: c h^3 |a''| with a'' from the last three
    # accelerations; h |a1 - a0| / 12 in a starting step. An acceleration that changes its direction in every step is an
    # unresolved wave, whose differences say nothing of a''. Velocities of the nodes of beams are left out.
    # In free flight positions count more (`StepControl.flight_weight`): their errors add up, and decide the place of
    # the next impact.
    # Equations (4.11) and (4.12) of docs/theory/integrators.md.
    h0 = flow.clock.last_step
    of_q = h * h * max(abs(scheme.beta - 1.0 / 6.0), 0.05) / options.error
    if in_free_flight(tables, flow):
        of_q *= trial.control.flight_weight
    find_speeds(tables.sizes.n_b, options, flow, trial)
    of_bend = 2.0 * velocity_constant(scheme) * h * h / (h + h0)
    worst = 0.0
    for k in range(0, tables.sizes.n_b, 3):
        of_v = h / (trial.control.rtol * trial.speeds[trial.groups[k]])
        worst = max(worst, node_error(k, k + 2, h, ratio, of_q, of_v, of_bend, flow, trial))
        worst = max(worst, options.length * node_error(k + 2, k + 3, h, ratio, of_q, of_v, of_bend, flow, trial))
    if tables.sizes.n_q > tables.sizes.n_b:
        # States of controls, over `rtol` times their largest value so far. The formulas of velocities hold: the rate
        # of a state is its acceleration.
        for i in range(tables.sizes.n_b, tables.sizes.n_q):
            rise, before = trial.a[i] - flow.a[i], flow.a[i] - flow.past[0, i]
            if h0 == 0.0 or rise * before >= 0.0:
                error = h * abs(rise / 12.0 if h0 == 0.0 else of_bend * (rise / h - before / h0))
                scale = state_scale(tables, i, trial.v[i], trial.a[i], options, flow)
                worst = max(worst, error / (trial.control.rtol * scale))
    if not math.isfinite(worst):
        return math.inf
    return worst


@compiled
def state_scale(tables, i, value, rate, options, flow):
    """Scale of a state of a control: its largest value so far, or its change in a largest step; > 0."""
    return max(flow.largest_states[i - tables.sizes.n_b], abs(value), options.h_max * abs(rate), LEAST_STATE)


@compiled
def node_error(begin, end, h, ratio, of_q, of_v, of_bend, flow, trial):
    """Error of a node: of x and y together, so that all directions count alike, or of its angle."""
    first, h0 = flow.clock.last_step == 0.0, flow.clock.last_step
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
def largest_error(tables, of_q, rtol, x, y, a, flexible, options, flow, trial):
    """Largest of the errors x of positions, times of_q, and y of velocities over `rtol` times the largest speeds."""
    # a : rates of the states of controls; flexible : whether velocities of nodes of flexible bodies count.
    worst, length = 0.0, options.length
    for k in range(0, tables.sizes.n_b, 3):
        worst = max(worst, of_q * math.sqrt(x[k] ** 2 + x[k + 1] ** 2), length * of_q * abs(x[k + 2]))
        if flexible or trial.rigid[k]:
            of_v = 1.0 / (rtol * trial.speeds[trial.groups[k]])
            worst = max(worst, of_v * math.sqrt(y[k] ** 2 + y[k + 1] ** 2), length * of_v * abs(y[k + 2]))
    for i in range(tables.sizes.n_b, tables.sizes.n_q):
        scale = state_scale(tables, i, trial.v[i], a[i], options, flow)
        worst = max(worst, abs(y[i]) / (rtol * scale))
    return worst


@compiled
def in_free_flight(tables, flow):
    """Whether there are contacts and none is closed."""
    for c in range(tables.contacts.kernel.shape[0]):
        if flow.z[tables.contacts.z[c, COMMON_Z]] != 0.0:
            return False
    return tables.contacts.kernel.shape[0] > 0


@compiled
def find_speeds(n, options, flow, trial):
    """Set trial.speeds: largest speed of the run up to the trial state, of each group of connected bodies [m/s]."""
    # Angular speeds count by the size of the mechanism.
    v, speeds = trial.v, trial.speeds
    for g in range(speeds.shape[0]):
        speeds[g] = max(flow.largest_speeds[g], trial.control.least_speed)
    for k in range(0, n, 3):
        g = trial.groups[k]
        speeds[g] = max(speeds[g], math.sqrt(v[k] ** 2 + v[k + 1] ** 2), options.length * abs(v[k + 2]))


@compiled
def growth_factor(error, power, least, most):
    """Allowed step over the present one, by a power of the error over the accepted error, from `least` to `most`."""
    # Equation (4.14) of docs/theory/integrators.md.
    return min(max(SAFETY * max(error, 1e-12) ** power, least), most)


@compiled
def accept_or_reject(h, error, growth, options, flow, trial, record):
    """Factor for the next step; 0 for a rejected trial, with the next step to try in the clock."""
    # error: error over the accepted error; negative for a trial that did not converge or missed a contact event
    # growth: allowed step over h by this error
    # Reasons of a rejection, and their counters: an event of a contact (`step_to_events`; `rejected_at_contacts`); no
    # convergence, a singular matrix, numbers that are not finite (codes of `implicit_step`; `not_converged`); else the
    # error. `Stats.rejections` (`results/solution.py`) says them in words.
    if 0.0 <= error <= 1.0:
        copy(trial.speeds, flow.largest_speeds)
        return growth
    if error > 1.0:
        shorten_step(h, min(growth, SAFETY), flow, record)
    elif flow.clock.retry_step > 0.0:
        record.count.rejected_at_contacts += 1
    else:
        record.count.not_converged += 1
    flow.clock.rejected_trials += 1.0
    record.count.rejected += 1
    record.report.rejected_size = h
    return 0.0


@compiled
def meets_contacts(tables, address, code, h, options, flow, trial, work, record):
    """Whether the trial converged and meets all contact events, as far as the smallest step allows."""
    if code != RUNNING:
        shorten_step(h, 0.25, flow, record)
        return False
    if flow.clock.rejected_trials >= CONTACT_TRIALS:
        return True
    wanted = step_to_events(tables, address, h, options, flow, trial, work, record)
    smallest, contact = h <= 1.001 * options.h_min, record.count.rejecting_contact - 1
    if wanted >= h or (smallest and flow.impacts[contact, IMPACT_STEP] >= options.h_min):
        return True  # the smallest step resolves an impact whose onset is then only met late
    flow.clock.retry_step = wanted
    return False


@compiled
def shorten_step(h, factor, flow, record):
    """Set the next trial to a fraction of h; a step below that of the error estimate belongs to a contact."""
    flow.clock.retry_step, record.count.rejecting_contact = 0.0, 0
    if h < 0.99 * flow.clock.step_size:
        flow.clock.contact_step = h * factor
    else:
        flow.clock.step_size = h * factor


@compiled
def update_step_sizes(h, growth, options, flow):
    """Set the step sizes after an accepted step; no size grows directly after a rejected trial."""
    keep = UNCHANGED_FROM <= growth < UNCHANGED_TO or (growth >= UNCHANGED_TO and flow.clock.rejected_trials > 0.0)
    if not keep and h >= 0.99 * flow.clock.step_size:
        flow.clock.step_size = min(h * growth, options.h_max)
    elif not keep and h >= 0.99 * flow.clock.contact_step > 0.0:
        flow.clock.contact_step = h * growth
    if flow.clock.contact_step >= flow.clock.step_size:
        flow.clock.contact_step = 0.0
    flow.clock.retry_step, flow.clock.rejected_trials = 0.0, 0.0
