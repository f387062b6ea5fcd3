"""Acceptance of a step: forces, energies, signals, peaks and kept poses of the trial state; rows of saved instants.

Saved instants need not be ends of steps.  Within a step, positions and velocities are cubic in time, accelerations and
multipliers quadratic, or linear after a starting step.  All signals are those of this state: forces, contacts, joints,
stored energies and measured signals are evaluated there.  Works and losses since the start are linear in time.
"""

import math

import flexmb.engine.energy as balance
from flexmb.engine.newmark.predictor import find_newmark_residual
from flexmb.engine.state import record as codes
from flexmb.engine.step.contact_events import buffer_may_overflow, note_passed_contacts, planned_step, update_episodes
from flexmb.engine.system.constraints import report_forces
from flexmb.engine.system.contacts import add_contacts
from flexmb.engine.system.elements import evaluate_energies
from flexmb.engine.system.evaluate import evaluate_accepted
from flexmb.engine.system.outputs import write_outputs
from flexmb.engine.system.work import turn_nodes
from flexmb.kernels import compiled, copy

END_OF_STEP = 1.0 - 1e-9  # fraction of a step from which an instant is its end
PAST_OF_QUADRATIC = 2  # number of states before the accepted one that a quadratic takes


@compiled
def save_instants(tables, address, options, flow, trial, work, record):
    """Save the end of the last step, or the instants of the grid within it; BUFFER_FULL when the buffer is full."""
    # The buffer must then be emptied and this be called again before the next step. `trial` and `work` are overwritten.
    s = save_ends(options, flow, record)
    while s < 1.0:
        # All signals at fraction s of the last step, in `record.within`.
        h, old, new = record.report.size, record.last_signals, record.signals
        interpolate_state(tables.sizes.n_q, s, h, flow, trial, record)
        t, q, v, a, lam = record.report.start + s * h, trial.q, trial.v, trial.a, trial.lam
        mean_v, residual = trial.mean_v, trial.newmark_residual
        evaluate_accepted(tables, address, t, s * h, q, v, a, lam, record.last_z, mean_v, residual, work)
        report_forces(tables, lam, work)
        y, energy, power = record.within, tables.sizes.energy, work.power
        write_outputs(tables, address, t, q, v, a, work, flow.ledger, record.peak, True, y)
        y[energy + balance.KINETIC], y[energy + balance.STRAIN] = power.kinetic, power.strain
        y[energy + balance.GRAVITY] = power.gravity
        for k in range(energy + balance.DRIVE, energy + balance.TURNED_OVER + 1):
            y[k] = (1.0 - s) * old[k] + s * new[k]
        s = save_within(record.within, options, flow, record)
    return buffer_code(record)


@compiled
def save_ends(options, flow, record):
    """Save the due instants at the end of the last step; fraction of the step at the next one within it, 1: none."""
    if options.save_interval == 0.0:
        save_row(record.signals, flow.clock.t, record)
        return 1.0
    step = record.report
    while record.count.rows < record.times.shape[0]:
        due = next_due(options, flow, record)
        if due > flow.clock.t + 1e-9 * options.save_interval:
            return 1.0
        s = (due - step.start) / step.size
        if s < END_OF_STEP:
            return s
        save_row(record.signals, due, record)
        flow.clock.saved_instants += 1.0
    return 1.0


@compiled
def save_within(signals, options, flow, record):
    """Save the signals at the next due instant, within the last step; fraction at the one after it, as `save_ends`."""
    save_row(signals, next_due(options, flow, record), record)
    flow.clock.saved_instants += 1.0
    return save_ends(options, flow, record)


@compiled
def save_row(signals, instant, record):
    """Write the saved ones of all signals at an instant [s] into a row of the buffer."""
    row = record.count.rows
    record.times[row] = instant
    if record.saved_places.shape[0] == 0:
        copy(signals, record.values[row])
    for k in range(record.saved_places.shape[0]):
        record.values[row, k] = signals[record.saved_places[k]]
    record.count.rows += 1


@compiled
def buffer_code(record):
    """BUFFER_FULL if the buffer of saved instants is full, else RUNNING."""
    return codes.BUFFER_FULL if record.count.rows >= record.times.shape[0] else codes.RUNNING


@compiled
def interpolate_state(n, s, h, flow, trial, record):
    """State at fraction s of the last step, in `trial`."""
    # Accelerations and multipliers are quadratic through the state before the step, where the predictor knows it.
    old, new, past, predictor = record.last_signals, record.signals, flow.past, flow.predictor
    f0, f1 = (1.0 + 2.0 * s) * (1.0 - s) ** 2, s * s * (3.0 - 2.0 * s)
    d0, d1 = h * s * (1.0 - s) ** 2, h * s * s * (s - 1.0)
    ahead, behind = 0.0, 0.0
    if predictor.past_states >= PAST_OF_QUADRATIC:
        ahead = s * (s - 1.0) * h / (h + predictor.second_last_step)
        behind = ahead * h / predictor.second_last_step
    for i in range(n):
        a0, a1 = old[2 * n + i], new[2 * n + i]
        trial.q[i] = f0 * old[i] + f1 * new[i] + d0 * old[n + i] + d1 * new[n + i]
        trial.v[i] = f0 * old[n + i] + f1 * new[n + i] + d0 * a0 + d1 * a1
        trial.a[i] = (1.0 - s) * a0 + s * a1 + ahead * (a1 - a0) - behind * (a0 - past[1, i])
    for i in range(trial.lam.shape[0]):
        l0, l1 = record.last_lam[i], flow.lam[i]
        trial.lam[i] = (1.0 - s) * l0 + s * l1 + ahead * (l1 - l0) - behind * (l0 - past[1, n + i])


@compiled
def next_due(options, flow, record):
    """The first instant [s] of the save grid, or of the given times, that is not saved yet."""
    saved, times = flow.clock.saved_instants, record.save_times
    if times.shape[0] == 0 or options.save_interval >= codes.NEVER:
        return flow.clock.save_start + (saved + 1.0) * options.save_interval
    return times[int(saved)] if saved < times.shape[0] else codes.NEVER


@compiled
def end_is_saved(options, flow, record):
    """Whether the end of the last step is a saved instant."""
    if options.save_interval == 0.0:
        return True
    passed = math.floor((flow.clock.t - flow.clock.save_start) / options.save_interval + 1e-9)
    last = flow.clock.save_start + passed * options.save_interval
    step, times = record.report, record.save_times
    if times.shape[0] > 0 and options.save_interval < codes.NEVER:
        passed = int(flow.clock.saved_instants)
        while passed < times.shape[0] and times[passed] <= flow.clock.t + 1e-9 * options.save_interval:
            last = times[passed]
            passed += 1
    return passed > flow.clock.saved_instants and last - step.start >= END_OF_STEP * step.size


# Poses of accepted steps, which a run keeps for its watch (`flexmb.engine.state.record`)
@compiled
def watch_step(strain, flow, record):
    """Keep the pose of the last step in its turn, and lows of signals; `strain`: place of the strain energy."""
    t, signals = flow.clock.t, record.signals
    for k in range(record.low_places.shape[0]):
        value = signals[record.low_places[k]]
        if value < record.lows[k, codes.LEAST]:
            record.lows[k, codes.LEAST], record.lows[k, codes.INSTANT] = value, t
    last, number, poses = record.poses.times.shape[0] - 1, record.poses.number, record.poses
    if signals[strain] > number.strain:
        number.strain = signals[strain]
        _keep(last, t, flow, record)
    number.wait -= 1
    if number.wait > 0:
        return
    if number.count == last:
        # Every second pose, at twice the distance.
        number.count //= 2
        number.stride *= 2
        for k in range(1, number.count):
            poses.times[k], poses.sizes[k] = poses.times[2 * k], poses.sizes[2 * k]
            copy(poses.values[2 * k], poses.values[k])
            copy(poses.z[2 * k], poses.z[k])
    _keep(number.count, t, flow, record)
    number.count += 1
    number.wait = number.stride


@compiled
def _keep(row, t, flow, record):
    """Keep the present state in a row."""
    poses = record.poses
    poses.times[row], poses.sizes[row] = t, record.report.size
    copy(record.signals, poses.values[row])
    copy(flow.z, poses.z[row])


@compiled
def accept(tables, address, h, options, flow, trial, work, record, exact):
    """Make the trial state the accepted one."""
    # Unless they shall be `exact`, extrema below their peaks are left out where nobody looks at them. Returns RUNNING,
    # BUFFER_FULL when the buffers must be emptied, or a code of `check_balance`.
    complete_evaluation(tables, address, h, flow, trial, work, record)
    update_energies(tables, address, h, options, flow, trial, work, record)
    if not options.adaptive:
        note_passed_contacts(tables, address, h, options, flow, trial, work, record)
    adopt_trial(h, flow, trial, work, record)
    for k in range(record.places.shape[0]):  # a stop condition may watch a signal that has a place
        place, of = record.places[k, codes.PLACE], record.places[k, codes.OF_PEAK]
        for w in range(record.watched.shape[0]):
            exact = exact or record.watched[w] == of or record.watched[w] == place
    exact = exact or end_is_saved(options, flow, record)
    report_step(tables, address, exact, flow, work, record)
    return ending(save_instants(tables, address, options, flow, trial, work, record), flow, record)


@compiled
def report_step(tables, address, exact, flow, work, record):
    """Write the signals of the accepted state, update peaks, and keep the pose."""
    t, peak, signals = flow.clock.t, record.peak, record.signals
    write_outputs(tables, address, t, flow.q, flow.v, flow.a, work, flow.ledger, peak, exact, signals)
    update_peaks(t, signals, record)
    watch_step(tables.sizes.energy + balance.STRAIN, flow, record)


@compiled
def ending(saved, flow, record):
    """Code behind an accepted step, whose instants were saved with the code `saved`."""
    if condition_met(record):
        return codes.CONDITION_MET
    if saved != codes.RUNNING:
        return saved
    if buffer_may_overflow(flow, record):
        return codes.BUFFER_FULL
    is_checked = flow.balance.steps >= balance.STEPS_BEFORE_CHECK
    return balance.check_balance(flow.ledger, flow.balance) if is_checked else codes.RUNNING


@compiled
def complete_evaluation(tables, address, h, flow, trial, work, record):
    """Evaluate the forces, histories and energies of the trial state that the last iteration left out."""
    t, q, v, a, lam = flow.clock.t + h, trial.q, trial.v, trial.a, trial.lam
    if record.count.evaluated == codes.EVALUATED:
        return
    find_newmark_residual(tables.sizes.n_q, h, flow, trial)
    if record.count.evaluated == codes.NOT_EVALUATED:
        mean_v, residual = trial.mean_v, trial.newmark_residual
        evaluate_accepted(tables, address, t, h, q, v, a, lam, flow.z, mean_v, residual, work)
        record.count.evaluations += 1
    else:
        work.r[:] = 0.0
        evaluate_energies(tables, address, t, h, q, v, a, trial.mean_v, trial.newmark_residual, flow.z, work)
        turn_nodes(tables, q, work)
        add_contacts(tables, address, t, h, q, v, flow.z, 0.0, 0.0, False, work)


@compiled
def update_energies(tables, address, h, options, flow, trial, work, record):
    """Update joint forces, contact intervals and the balance of energies to the trial state."""
    t = flow.clock.t + h
    report_forces(tables, trial.lam, work)
    balance.complete_algorithm_work(tables.sizes.n_q, flow, trial, work)
    balance.contact_losses(tables, address, h, flow, trial.q, trial.v, work)
    update_episodes(tables, h, options, flow, work, record)
    balance.update_balance(
        tables, address, t, h, flow.q, flow.v, trial.q, trial.v, flow.ledger, flow.balance, flow.memory, work
    )


@compiled
def adopt_trial(h, flow, trial, work, record):
    """Copy the trial state into the accepted one, and count the step."""
    t0 = flow.clock.t
    flow.clock.t = t0 + h
    copy(trial.q, flow.q)
    copy(trial.v, flow.v)
    copy(trial.a, flow.a)
    copy(trial.x, flow.x)
    copy(flow.lam, record.last_lam)
    copy(trial.lam, flow.lam)
    copy(flow.z, record.last_z)
    copy(work.z_new, flow.z)
    first = flow.v.shape[0] - flow.largest_states.shape[0] - 3  # states of controls stand before the ground
    for i in range(flow.largest_states.shape[0]):
        flow.largest_states[i] = max(flow.largest_states[i], abs(trial.v[first + i]))
    copy(record.signals, record.last_signals)
    record.count.steps += 1
    record.report.smallest, record.report.largest = min(record.report.smallest, h), max(record.report.largest, h)
    record.report.start, record.report.size = t0, h


@compiled
def condition_met(record):
    """Whether a watched signal has crossed its level in the last step; its number goes to `Counters.condition`."""
    for k in range(record.watched.shape[0]):
        place, level, sign = record.watched[k], record.levels[k, codes.LEVEL], record.levels[k, codes.DIRECTION]
        if sign * (record.last_signals[place] - level) < 0.0 and sign * (record.signals[place] - level) >= 0.0:
            record.count.condition = k + 1
            return True
    return False


@compiled
def update_peaks(t, signals, record):
    """Update the largest values of all signals and their times; a place is that of the peak of its signal."""
    for k in range(record.places.shape[0]):
        place, of = record.places[k, codes.PLACE], record.places[k, codes.OF_PEAK]
        record.place_then[k] = signals[place] if abs(signals[of]) > record.peak[of] else record.peak[place]
    for i in range(signals.shape[0]):  # without branches: the compiler makes vectors of it
        size = signals[i] if record.one_sided[i] else abs(signals[i])
        larger = size > record.peak[i]
        record.peak[i] = size if larger else record.peak[i]
        record.peak_time[i] = t if larger else record.peak_time[i]
    for k in range(record.places.shape[0]):
        place, of = record.places[k, codes.PLACE], record.places[k, codes.OF_PEAK]
        record.peak[place], record.peak_time[place] = record.place_then[k], record.peak_time[of]


@compiled
def step_to_try(tables, address, options, flow, trial, work):
    """Size of the next trial [s]."""
    h = planned_step(tables, address, options, flow, trial, work) if options.adaptive else flow.clock.step_size
    return next_step_size(h, options.t_end - flow.clock.t)


@compiled
def next_step_size(proposed, remaining):
    """Next step [s]: the proposed one; near the end the remaining time, or half of it."""
    # No step is stretched by more than round-off, so that an acceptable step stays acceptable, and none is tiny.
    if remaining <= (1.0 + 1e-6) * proposed:
        return remaining
    return 0.5 * remaining if remaining < 2.0 * proposed else proposed


@compiled
def finished(options, flow):
    """Whether the end is reached, up to round-off."""
    return options.t_end - flow.clock.t <= 1e-12 * max(abs(options.t_end), 1e-300)
