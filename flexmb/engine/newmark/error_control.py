"""Step control of the Newmark family: estimate of the local error, acceptance of a trial, next step size."""

import math

from flexmb.engine.newmark.jacobian_reuse import discard_factors
from flexmb.engine.state.record import RUNNING
from flexmb.engine.step.contact_events import IMPACT_STEP, step_to_events
from flexmb.engine.system.contacts import find_gap
from flexmb.engine.system.elements import evaluate_controls
from flexmb.kernels import compiled, copy
from flexmb.program import program as at
from flexmb.program.program import COMMON_Z

CONTACT_TRIALS = 8  # number of trials of one step at most that locate a contact event
# Growth factors of a step between which its size is kept, so that the factors of the matrix can be reused.
UNCHANGED_FROM, UNCHANGED_TO = 0.95, 1.2
LEAST_STATE = 1e-300  # least scale of a state of a control, so that a state which stays 0 has no error
SAFETY = 0.9  # safety factor of the next step; also the largest factor of a rejected step
# Error of velocities in a step across a jump of a control law over the accepted one; number of bisections of a step
# down to which a change must last to be a jump; share of the change, and of the largest value so far, that must last.
ERROR_ACROSS_JUMP, BISECTIONS, LASTING_SHARE, LEAST_JUMP = 0.02, 24, 0.05, 1e-6
# A law slides along its jump when more than so many jumps lie within this part of the step of the error estimate.
MOST_JUMPS, SLIDING_TIME = 4.0, 0.1


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
    h0, of_q = flow.clock.last_step, h * h * max(abs(scheme.beta - 1.0 / 6.0), 0.05) / options.error
    if in_free_flight(tables, flow):
        of_q *= trial.control.flight_weight
    find_speeds(tables.sizes.n_b, options, flow, trial)
    of_bend, worst = 2.0 * velocity_constant(scheme) * h * h / (h + h0), 0.0
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
    return worst if math.isfinite(worst) else math.inf


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
        worst = max(worst, abs(y[i]) / (rtol * state_scale(tables, i, trial.v[i], a[i], options, flow)))
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
    # Reasons of a rejection, and their counters: an event of a contact or a jump (`rejected_at_contacts`); no
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
    if wanted >= h:
        wanted = step_to_jump(tables, address, h, options, flow, trial, work, record)
    smallest, contact = h <= 1.001 * options.h_min, record.count.rejecting_contact - 1
    if wanted >= h or (smallest and flow.impacts[contact, IMPACT_STEP] >= options.h_min):
        return True  # the smallest step resolves an impact whose onset is then only met late
    flow.clock.retry_step = wanted
    return False


@compiled
def meets_events(tables, address, code, h, Q, V, C, options, flow, trial, work, record):
    """Whether a trial with stages Q, V at fractions C > 0 of the step meets all events."""
    # A stage in a contact that is open at both ends has felt its force, although the onset was not located.
    K = tables.contacts
    for c in range(K.kernel.shape[0] if code == RUNNING else 0):
        if flow.z[K.z[c, COMMON_Z]] != 0.0 or flow.clock.rejected_trials >= CONTACT_TRIALS:
            continue
        gap, _ = find_gap(tables, address, c, trial.q, trial.v, False, None, work)
        for stage in range(Q.shape[0] if gap > 0.0 else 0):
            gap, _ = find_gap(tables, address, c, Q[stage], V[stage], False, None, work)
            if gap <= 0.0:
                flow.clock.retry_step, record.count.rejecting_contact = 0.5 * C[stage] * h, 0
                return False
    return meets_contacts(tables, address, code, h, options, flow, trial, work, record)


@compiled
def step_to_jump(tables, address, h, options, flow, trial, work, record):
    """Step to just before a jump of a control law in the trial, or from there to just behind it [s]; h: none is due."""
    # The estimate of the error takes accelerations as smooth. Half of the jump acts all over a step that crosses it.
    if not looks_for_jumps(tables, flow) or h <= 1.001 * options.h_min:
        return h
    find_speeds(tables.sizes.n_b, options, flow, trial)
    for i in range(tables.sizes.n_q):
        trial.v_within[i] = 0.5 * h * (trial.a[i] - flow.a[i])
    rtol, q, v = trial.control.rtol, trial.q_within, trial.v_within
    error = largest_error(tables, 0.0, rtol, q, v, trial.a, True, options, flow, trial)
    if not error > ERROR_ACROSS_JUMP:
        return h
    most = h * ERROR_ACROSS_JUMP / error
    s = place_of_jump(tables, address, 1.0 + 0.1 * most / h, h, options, flow, trial, work, record)
    if s == math.inf:
        return h
    record.count.rejecting_contact = 0
    # Newton's method ends on a jump, where the force is any between, when no step of about this size has a solution.
    if abs(s - 1.0) * h <= 0.1 * most:
        return 0.9 * h
    if s * h > 0.5 * most:
        return s * h - 0.25 * most
    if flow.clock.t >= flow.clock.jump + SLIDING_TIME * flow.clock.step_size:
        flow.clock.jump, flow.clock.jumps = flow.clock.t, 0.0
    flow.clock.jumps += 1.0
    discard_factors(flow.reuse)  # those of another step leave an error of accelerations that no displacement shows
    return s * h + 0.4 * most


@compiled
def looks_for_jumps(tables, flow):
    """Whether jumps of control laws are located in the next step: not in a starting step, nor while a law slides."""
    # A law that slides along its jump has ever new jumps, which short steps would cross one after the other.
    slides = flow.clock.jumps > MOST_JUMPS and flow.clock.t < flow.clock.jump + SLIDING_TIME * flow.clock.step_size
    return tables.controls.kernel.shape[0] > 0 and flow.clock.last_step != 0.0 and not slides


@compiled
def place_of_jump(tables, address, end, h, options, flow, trial, work, record):
    """Fraction of a step, up to `end`, at which an output or the rate of a state of a control jumps first, else inf."""
    C, found = tables.controls, math.inf
    for c in range(C.kernel.shape[0]):
        if C.z[c, at.END] > C.z[c, at.BEGIN]:
            continue  # a sampled one changes nothing within a step
        n_x = C.states[c]
        for k in range(n_x + C.output[c + 1] - C.output[c]):
            y0 = law_within(tables, address, c, k, n_x, 0.0, h, flow, trial, work)
            y1 = law_within(tables, address, c, k, n_x, end, h, flow, trial, work)
            low, high, least = 0.0, end, LASTING_SHARE * abs(y1 - y0)
            if k < n_x:
                i = C.dofs[C.dof[c] + k]
                least = max(least, trial.control.rtol * state_scale(tables, i, trial.v[i], 0.0, options, flow) / h)
            else:
                least = max(least, LEAST_JUMP * record.peak[C.out[c] + k - n_x])
            for _ in range(BISECTIONS):
                if not abs(y1 - y0) > least:
                    break
                middle = 0.5 * (low + high)
                y = law_within(tables, address, c, k, n_x, middle, h, flow, trial, work)
                if abs(y - y0) >= abs(y1 - y):
                    high, y1 = middle, y
                else:
                    low, y0 = middle, y
            if abs(y1 - y0) > least:
                found = min(found, high)
    evaluate_controls(tables, address, flow.clock.t + h, trial.q, trial.v, trial.a, flow.z, 0.0, 0.0, 0.0, False, work)
    return found


@compiled
def crosses_jump(tables, address, h, options, flow, trial, work, record):
    """Whether an accepted step is a short one across a jump of a control law; the next is then a starting step."""
    if not looks_for_jumps(tables, flow) or h > 0.5 * flow.clock.step_size:
        return False
    return place_of_jump(tables, address, 1.0, h, options, flow, trial, work, record) < math.inf


@compiled
def law_within(tables, address, c, k, n_x, s, h, flow, trial, work):
    """Rate of state k of control c, or from n_x on an output, at fraction s of the cubic path of a trial."""
    q, v = trial.q_within, trial.v_within
    for i in range(q.shape[0]):
        rise, d0, d1 = trial.q[i] - flow.q[i], h * flow.v[i], h * trial.v[i]
        c2, c3 = 3.0 * rise - 2.0 * d0 - d1, d0 + d1 - 2.0 * rise
        q[i] = flow.q[i] + s * (d0 + s * (c2 + s * c3))
        v[i] = (d0 + s * (2.0 * c2 + 3.0 * s * c3)) / h
    evaluate_controls(tables, address, flow.clock.t + s * h, q, v, trial.a, flow.z, 0.0, 0.0, 0.0, False, work)
    C = tables.controls
    return -work.r[C.dofs[C.dof[c] + k]] if k < n_x else work.output[C.output[c] + k - n_x]


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
