"""The compiled time loop of the Newmark family, the same for every model."""

from flexmb.kernels import compiled, copy
from flexmb.linalg.lu import LU
from flexmb.program.tables import Addresses, Tables
from flexmb.state.flow import Flow
from flexmb.state.options import Options
from flexmb.state.record import DONE, NOT_EVALUATED, RUNNING, STEP_TOO_SMALL, RunRecord
from flexmb.state.trial import Trial
from flexmb.step.acceptance import accept, finished, next_step_size
from flexmb.step.contact_events import planned_step, update_impacts
from flexmb.step.newmark.error_control import (
    accept_or_reject,
    error_ratio,
    growth_factor,
    meets_contacts,
    update_step_sizes,
)
from flexmb.step.newmark.implicit_step import implicit_step, start_auxiliary_acceleration
from flexmb.step.newmark.jacobian_reuse import adopt_factors
from flexmb.step.newmark.predictor import update_predictor
from flexmb.step.newmark.redundant_constraints import update_held_multipliers
from flexmb.system.outputs import write_extrema
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
    """Take at most `steps` implicit steps; RUNNING, or the code of the ending.  Diagram: `step/__init__.py`."""
    code = take_steps(tables, address, lu, options, flow, trial, work, record, steps)
    write_extrema(tables, address, flow.clock.t, flow.q, flow.v, flow.a, work, record.signals)
    return code


@compiled
def take_steps(tables, address, lu, options, flow, trial, work, record, steps):
    """Take the steps of `advance`; extrema of the last state may be left out."""
    for _ in range(steps):
        if finished(options, flow):
            return DONE
        h = planned_step(tables, address, options, flow, trial, work) if options.adaptive else flow.clock.step_size
        h = next_step_size(h, options.t_end - flow.clock.t)
        first = flow.clock.last_step == 0.0
        ratio = 1.0 if first else h / flow.clock.last_step
        scheme = options.first if first else options.regular
        code = implicit_step(tables, address, lu, h, ratio, scheme, options, flow, trial, work, record)
        growth, restarts = 1.0, False
        if options.adaptive:
            fits = meets_contacts(tables, address, code, h, options, flow, trial, work, record)
            error = error_ratio(tables, h, ratio, scheme, options, flow, trial) if fits else -1.0
            growth = accept_or_reject(h, error, growth_factor(error), options, flow, trial, record)
            code = STEP_TOO_SMALL if code == RUNNING and growth == 0.0 else code
        if code != RUNNING and h <= 1.001 * options.h_min:
            return code
        if code != RUNNING:
            continue
        if first:
            start_auxiliary_acceleration(tables.sizes.n_q, options, flow, trial)
        if record.count.held_code != 0 or flow.clock.held_steps > 0.0:
            update_held_multipliers(tables, lu, flow.clock.t + h, flow, trial, work, record)
            record.count.evaluated = NOT_EVALUATED  # multipliers may have changed
        adopt_factors(flow, trial, work)
        if options.adaptive:
            restarts = update_impacts(tables, address, h, options, flow, trial, work)
            update_step_sizes(h, growth, options, flow)
        update_predictor(tables, h, options.length, flow, trial, work)
        code = accept(tables, address, h, options, flow, trial, work, record, False)
        flow.clock.last_step = 0.0 if restarts else h
        if restarts:
            copy(flow.a, flow.x)
        if code != RUNNING:
            return code
    return RUNNING
