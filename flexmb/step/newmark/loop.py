"""The compiled time loop of the Newmark family, the same for every model."""

from flexmb.kernels import compiled, copy
from flexmb.linalg.lu import LU
from flexmb.program.tables import Addresses, Tables
from flexmb.state.flow import Flow
from flexmb.state.options import Options
from flexmb.state.record import DONE, NOTHING_KNOWN, RUNNING, STEP_TOO_SMALL, RunRecord
from flexmb.state.trial import Trial
from flexmb.step.acceptance import accept, finished, next_size
from flexmb.step.contact_events import planned, remember
from flexmb.step.newmark.error_control import allowed, error_ratio, judged, met, resize
from flexmb.step.newmark.implicit_step import implicit_step, lead
from flexmb.step.newmark.jacobian_reuse import keep_trial
from flexmb.step.newmark.predictor import look_back
from flexmb.step.newmark.redundant_constraints import settle
from flexmb.system.work import Work


@compiled
def advance(
    tables: Tables,
    address: Addresses,
    lu: LU,
    options: Options,
    flow: Flow,
    trial: Trial,
    work: Work,
    record: RunRecord,
    steps: int,
):
    """At most `steps` implicit steps; the code of the ending."""
    for _ in range(steps):
        if finished(options, flow):
            return DONE
        h = planned(tables, address, options, flow, trial, work) if options.adaptive else flow.clock.size
        h = next_size(h, options.t_end - flow.clock.t)
        first = flow.clock.last == 0.0
        ratio = 1.0 if first else h / flow.clock.last
        scheme = options.first if first else options.regular
        code = implicit_step(tables, address, lu, h, ratio, scheme, options, flow, trial, work, record)
        growth, anew = 1.0, False
        if options.adaptive:
            fits = met(tables, address, code, h, options, flow, trial, work, record)
            error = error_ratio(tables, h, ratio, scheme, options, flow, trial) if fits else -1.0
            growth = judged(tables, h, error, allowed(error), options, flow, trial, record)
            code = STEP_TOO_SMALL if code == RUNNING and growth == 0.0 else code
        if code != RUNNING and h <= 1.001 * options.h_min:
            return code
        if code != RUNNING:
            continue
        if first:
            lead(tables.sizes.n_q, options, flow, trial)
        if record.count.outcome != 0 or flow.clock.held_steps > 0.0:
            settle(tables, lu, flow.clock.t + h, flow, trial, work, record)
            record.count.known = NOTHING_KNOWN  # it may have changed the multipliers
        keep_trial(flow, trial, work)
        if options.adaptive:
            anew = remember(tables, address, h, options, flow, trial, work)
            resize(h, growth, options, flow)
        look_back(tables, h, options.length, flow, trial, work)
        code = accept(tables, address, h, options, flow, trial, work, record)
        flow.clock.last = 0.0 if anew else h
        if anew:
            copy(flow.a, flow.x)
        if code != RUNNING:
            return code
    return RUNNING
