"""The compiled time loops: one for the Newmark family, one for Runge-Kutta; compiled once for every model."""

from flexmb.integrate.arrays import DONE, NOTHING_KNOWN, RUNNING, STEP_TOO_SMALL
from flexmb.integrate.control import judged, resize
from flexmb.integrate.explicit import runge_kutta_step
from flexmb.integrate.finish import accept, finished, next_size
from flexmb.integrate.held import settle
from flexmb.integrate.landing import planned, remember
from flexmb.integrate.newton import implicit_step, lead, starting
from flexmb.integrate.predict import look_back
from flexmb.integrate.reuse import forget_factors, keep_habits
from flexmb.kernels import compiled, copy


@compiled
def advance(tables, address, lu, options, flow, trial, work, record, steps):
    """At most `steps` implicit steps; the code of the ending."""
    for _ in range(steps):
        if finished(options, flow):
            return DONE
        h = planned(tables, address, options, flow, trial, work) if options.adaptive else flow.clock[1]
        h = next_size(h, options.t_end - flow.clock[0])
        first = flow.clock[4] == 0.0
        ratio = 1.0 if first else h / flow.clock[4]
        numbers = starting(options) if first else options
        code = implicit_step(tables, address, lu, h, ratio, numbers, flow, trial, work, record)
        growth, anew = 1.0, False
        if options.adaptive:
            growth = judged(tables, address, code, h, ratio, numbers, options, flow, trial, work, record)
            code = STEP_TOO_SMALL if code == RUNNING and growth == 0.0 else code
        if code != RUNNING and h <= 1.001 * options.h_min:
            return code
        if code != RUNNING:
            continue
        if first:
            lead(tables.sizes.n_q, options, flow, trial)
        if record.count[8] != 0 or flow.clock[5] > 0.0:
            settle(tables, lu, flow.clock[0] + h, flow, trial, work, record)
            record.count[9] = NOTHING_KNOWN  # it may have changed the multipliers
        keep_habits(flow, trial, work)
        if options.adaptive:
            anew = remember(tables, address, h, options, flow, trial, work)
            resize(h, growth, options, flow)
        look_back(tables, h, options.length, flow, trial, work)
        code = accept(tables, address, h, ratio, options, flow, trial, work, record)
        flow.clock[4] = 0.0 if anew else h
        if anew:
            copy(flow.a, flow.x)
        if code != RUNNING:
            return code
    return RUNNING


@compiled
def advance_explicit(tables, address, lu, options, flow, trial, work, record, stages, steps):
    """At most `steps` Runge-Kutta steps of fixed size; the code of the ending."""
    forget_factors(flow.habits)
    record.count[9] = NOTHING_KNOWN
    for _ in range(steps):
        if finished(options, flow):
            return DONE
        h = next_size(flow.clock[1], options.t_end - flow.clock[0])
        code = runge_kutta_step(tables, address, lu, h, options, flow, trial, work, record, stages)
        if code != RUNNING:
            return code
        if record.count[8] != 0 or flow.clock[5] > 0.0:
            settle(tables, lu, flow.clock[0] + h, flow, trial, work, record)
        code = accept(tables, address, h, 1.0, options, flow, trial, work, record)
        if code != RUNNING:
            return code
    return RUNNING
