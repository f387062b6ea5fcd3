"""Acceptance of a step: forces, energies, signals, peaks and kept poses of the trial state."""

from flexmb.engine.energy import (
    STEPS_BEFORE_CHECK,
    STRAIN,
    check_balance,
    complete_algorithm_work,
    contact_losses,
    update_balance,
)
from flexmb.engine.newmark.predictor import find_newmark_residual
from flexmb.engine.state.record import (
    BUFFER_FULL,
    CONDITION_MET,
    DIRECTION,
    INSTANT,
    JOINTS_EVALUATED,
    LEAST,
    LEVEL,
    NOT_EVALUATED,
    OF_PEAK,
    PLACE,
    RUNNING,
)
from flexmb.engine.step.contact_events import note_passed_contacts
from flexmb.engine.step.contact_log import buffer_may_overflow, update_episodes
from flexmb.engine.step.saved_instants import end_is_saved, save_instants
from flexmb.engine.system.constraints import report_forces
from flexmb.engine.system.contacts import add_contacts
from flexmb.engine.system.elements import evaluate_energies
from flexmb.engine.system.evaluate import evaluate_accepted
from flexmb.engine.system.outputs import write_outputs
from flexmb.kernels import compiled, copy


# Poses of accepted steps, which a run keeps for its watch (`flexmb.engine.state.record`)
@compiled
def watch_step(strain, flow, record):
    """Keep the pose of the last step in its turn, and lows of signals; `strain`: place of the strain energy."""
    t, signals = flow.clock.t, record.signals
    for k in range(record.low_places.shape[0]):
        value = signals[record.low_places[k]]
        if value < record.lows[k, LEAST]:
            record.lows[k, LEAST], record.lows[k, INSTANT] = value, t
    poses = record.poses
    last = poses.times.shape[0] - 1
    number = poses.number
    if signals[strain] > number.strain:
        number.strain = signals[strain]
        _keep(last, t, flow, record)
    number.wait -= 1
    if number.wait > 0:
        return
    if number.count == last:
        _thin(poses)
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
def _thin(poses):
    """Every second pose, at twice the distance."""
    poses.number.count //= 2
    poses.number.stride *= 2
    for k in range(1, poses.number.count):
        poses.times[k], poses.sizes[k] = poses.times[2 * k], poses.sizes[2 * k]
        copy(poses.values[2 * k], poses.values[k])
        copy(poses.z[2 * k], poses.z[k])


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
    exact = exact or extremum_is_watched(record) or end_is_saved(options, flow, record)
    t, peak, signals = flow.clock.t, record.peak, record.signals
    write_outputs(tables, address, t, flow.q, flow.v, flow.a, work, flow.ledger, peak, exact, signals)
    update_peaks(flow.clock.t, record.signals, record)
    watch_step(tables.sizes.energy + STRAIN, flow, record)
    full = save_instants(tables, address, options, flow, trial, work, record) != RUNNING
    if condition_met(record):
        return CONDITION_MET
    if full or buffer_may_overflow(flow, record):
        return BUFFER_FULL
    return check_balance(flow.ledger, flow.balance) if flow.balance.steps >= STEPS_BEFORE_CHECK else RUNNING


@compiled
def complete_evaluation(tables, address, h, flow, trial, work, record):
    """Evaluate the forces, histories and energies of the trial state that the last iteration left out."""
    t = flow.clock.t + h
    if record.count.evaluated == NOT_EVALUATED:
        find_newmark_residual(tables.sizes.n_q, h, flow, trial)
        evaluate_accepted(
            tables,
            address,
            t,
            h,
            trial.q,
            trial.v,
            trial.a,
            trial.lam,
            flow.z,
            trial.mean_v,
            trial.newmark_residual,
            work,
        )
        record.count.evaluations += 1
    elif record.count.evaluated == JOINTS_EVALUATED:
        find_newmark_residual(tables.sizes.n_q, h, flow, trial)
        work.r[:] = 0.0
        evaluate_energies(
            tables, address, t, h, trial.q, trial.v, trial.a, trial.mean_v, trial.newmark_residual, flow.z, work
        )
        add_contacts(tables, address, t, h, trial.q, trial.v, flow.z, 0.0, 0.0, False, work)


@compiled
def update_energies(tables, address, h, options, flow, trial, work, record):
    """Update joint forces, contact intervals and the balance of energies to the trial state."""
    t = flow.clock.t + h
    report_forces(tables, trial.lam, work)
    complete_algorithm_work(tables.sizes.n_q, flow, trial, work)
    contact_losses(tables, address, h, flow, trial.q, trial.v, work)
    update_episodes(tables, h, options, flow, work, record)
    update_balance(
        tables, address, t, h, flow.q, flow.v, trial.q, trial.v, flow.ledger, flow.balance, flow.memory, work
    )


@compiled
def update_largest_states(flow, trial):
    """Update the largest absolute values of the states of controls, which stand before the ground."""
    n = flow.largest_states.shape[0]
    first = flow.v.shape[0] - n - 3
    for i in range(n):
        flow.largest_states[i] = max(flow.largest_states[i], abs(trial.v[first + i]))


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
    if flow.largest_states.shape[0] > 0:
        update_largest_states(flow, trial)
    copy(record.signals, record.last_signals)
    record.count.steps += 1
    record.report.smallest, record.report.largest = min(record.report.smallest, h), max(record.report.largest, h)
    record.report.start, record.report.size = t0, h


@compiled
def condition_met(record):
    """Whether a watched signal has crossed its level in the last step; its number goes to `Counters.condition`."""
    for k in range(record.watched.shape[0]):
        place, level, sign = record.watched[k], record.levels[k, LEVEL], record.levels[k, DIRECTION]
        if sign * (record.last_signals[place] - level) < 0.0 and sign * (record.signals[place] - level) >= 0.0:
            record.count.condition = k + 1
            return True
    return False


@compiled
def extremum_is_watched(record):
    """Whether a stop condition watches a signal that has a place."""
    for k in range(record.places.shape[0]):
        for w in range(record.watched.shape[0]):
            if record.watched[w] == record.places[k, OF_PEAK] or record.watched[w] == record.places[k, PLACE]:
                return True
    return False


@compiled
def update_peaks(t, signals, record):
    """Update the largest values of all signals and their times; a place is that of the peak of its signal."""
    for k in range(record.places.shape[0]):
        place, of = record.places[k, PLACE], record.places[k, OF_PEAK]
        record.place_then[k] = signals[place] if abs(signals[of]) > record.peak[of] else record.peak[place]
    for i in range(signals.shape[0]):  # without branches: the compiler makes vectors of it
        size = signals[i] if record.one_sided[i] else abs(signals[i])
        larger = size > record.peak[i]
        record.peak[i] = size if larger else record.peak[i]
        record.peak_time[i] = t if larger else record.peak_time[i]
    for k in range(record.places.shape[0]):
        place, of = record.places[k, PLACE], record.places[k, OF_PEAK]
        record.peak[place], record.peak_time[place] = record.place_then[k], record.peak_time[of]


@compiled
def next_step_size(proposed, remaining):
    """Next step [s]: the proposed one; near the end the remaining time, or half of it."""
    # No step is stretched by more than round-off, so that an acceptable step stays acceptable, and none is tiny.
    if remaining <= (1.0 + 1e-6) * proposed:
        return remaining
    if remaining < 2.0 * proposed:
        return 0.5 * remaining
    return proposed


@compiled
def finished(options, flow):
    """Whether the end is reached, up to round-off."""
    return options.t_end - flow.clock.t <= 1e-12 * max(abs(options.t_end), 1e-300)
