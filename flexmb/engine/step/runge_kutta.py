"""Classical Runge-Kutta method for rigid mechanisms, with projection onto the constraints."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from flexmb.engine.compiled.records import Matrix, Record, Vector
from flexmb.engine.energy import RESIDUAL_LIMIT_RUNGE_KUTTA
from flexmb.engine.linalg.lu import LOST_PIVOT, ROWS_HELD, first_held_row, held_residual, solve
from flexmb.engine.newmark import jacobian_reuse
from flexmb.engine.state.record import DONE, NOT_EVALUATED, NOT_FINITE, RUNNING, SINGULAR
from flexmb.engine.step.acceptance import accept, finished, next_step_size
from flexmb.engine.step.method import Method, Stepper
from flexmb.engine.system.evaluate import evaluate
from flexmb.kernels import compiled, copy
from flexmb.program.program import Program

if TYPE_CHECKING:
    from flexmb.model.mechanism import Mechanism

PROJECTIONS = 3  # number of projections after a step: two of positions, one of velocities
MOST_REPETITIONS = 8  # number of solutions for multipliers that friction depends on, at most


class Stages(Record):
    """Velocities v and accelerations a of the four stages, (4, n_q + 3)."""

    v: Matrix
    a: Matrix
    zero: Vector


def new_stages(program: Program) -> Stages:
    """Work arrays of the Runge-Kutta loop."""
    n = program.n_q + 3
    return Stages(v=(4, n), a=(4, n), zero=n)


@compiled
def accelerate(tables, address, lu, t, fraction, h, load, options, flow, trial, work, record, stages):
    """Solve for accelerations and multipliers; repeatedly, where friction depends on the multipliers."""
    n, m, last = tables.sizes.n_q, tables.sizes.n_c, math.inf
    for _ in range(MOST_REPETITIONS if tables.sizes.has_joint_friction else 1):
        code = accelerate_once(tables, address, lu, t, fraction, h, load, options, flow, trial, work, record, stages)
        change, size = 0.0, 0.0
        for i in range(m):
            change, size = max(change, abs(trial.solution[n + i])), max(size, abs(trial.lam[i]))
        if code != RUNNING or change <= 1e-14 * size or not change < last:
            return code
        last = change
    return code


@compiled
def accelerate_once(tables, address, lu, t, fraction, h, load, options, flow, trial, work, record, stages):
    """Solve M a + G^T lam = load - r, G a = gamma at the trial positions and velocities."""
    # Unknowns are a and the change of the multipliers, so that held multipliers keep their last values. fraction : time
    # since the start of the step over h;  load : (n_q + 3,) forces beside those of the model [N, N m]
    # Equations (1.3) and (1.11) of docs/theory/equations_of_motion.md.
    n, m, hold, lost = tables.sizes.n_q, tables.sizes.n_c, jacobian_reuse.initial_hold(flow), ROWS_HELD
    while lost == ROWS_HELD:
        q, v, still = trial.q, trial.v, stages.zero
        evaluate(tables, address, t, fraction * h, q, v, still, trial.lam, flow.z, 0.0, 0.0, 1.0, True, work)
        record.count.evaluations += 1
        for i in range(n):
            trial.rhs[i] = load[i] - (work.r[i] + work.Gl[i])
        for i in range(m):
            trial.rhs[n + i] = work.gamma[i]
        lost = jacobian_reuse.factor_without_redundant(lu, work.lu, hold, n, trial)
        record.count.factorisations += 1
        if lost >= 0:
            record.count.lost_pivot = lost
            return SINGULAR if math.isfinite(trial.rhs.sum()) else NOT_FINITE
        if lost == ROWS_HELD:
            left = h * h * held_residual(lu, work.lu, trial.pivot_scale, trial.rhs, trial.scratch)
            if hold == LOST_PIVOT or left <= jacobian_reuse.allowed_gap(tables, h, options, flow, flow.a, False):
                break
            hold = LOST_PIVOT  # the rows are not redundant
    solve(lu, work.lu, trial.rhs, trial.solution, trial.scratch)
    for i in range(n):
        trial.a[i] = trial.solution[i]
    for i in range(m):
        trial.lam[i] += trial.solution[n + i]
    record.count.held_code = jacobian_reuse.held_code(lost == ROWS_HELD, hold == LOST_PIVOT, flow)
    return RUNNING if math.isfinite(trial.solution.sum()) else NOT_FINITE


@compiled
def project_state(tables, address, lu, t, h, options, flow, trial, work, record, stages):
    """Project positions, then velocities, onto the constraints, with least kinetic energy."""
    n, m, level, hold = tables.sizes.n_q, tables.sizes.n_c, 0, jacobian_reuse.initial_hold(flow)
    while level < PROJECTIONS:
        evaluate(tables, address, t, h, trial.q, trial.v, stages.zero, trial.lam, flow.z, 0.0, 0.0, 1.0, True, work)
        record.count.evaluations += 1
        trial.rhs[:] = 0.0
        velocities = level == PROJECTIONS - 1
        for i in range(m):
            trial.rhs[n + i] = -work.gv[i] if velocities else -work.g[i]
        lost = jacobian_reuse.factor_without_redundant(lu, work.lu, hold, n, trial)
        record.count.factorisations += 1
        if lost >= 0:
            record.count.lost_pivot = lost
            return SINGULAR
        if lost == ROWS_HELD:
            left = held_residual(lu, work.lu, trial.pivot_scale, trial.rhs, trial.scratch) * (h if velocities else 1.0)
            redundant = hold == LOST_PIVOT and trial.left_out.shape[0] > 0
            if left > jacobian_reuse.allowed_gap(tables, h, options, flow, flow.a, redundant):
                if hold == LOST_PIVOT:  # the rows contradict the others
                    record.count.lost_pivot = first_held_row(lu, trial.pivot_scale)
                    return SINGULAR
                hold = LOST_PIVOT  # the rows are not redundant
                continue
        solve(lu, work.lu, trial.rhs, trial.shift, trial.scratch)
        for i in range(n):
            if velocities:
                trial.v[i] += trial.shift[i]
            else:
                trial.q[i] += trial.shift[i]
        level += 1
    return RUNNING


@compiled
def runge_kutta_step(tables, address, lu, h, load, options, flow, trial, work, record, stages):
    """Try a step under a constant load; RUNNING, or the code of the failure."""
    n, m, t = tables.sizes.n_q, tables.sizes.n_c, flow.clock.t
    copy(flow.q, trial.q)
    copy(flow.v, trial.v)
    copy(flow.lam, trial.lam)
    for stage in range(4):
        c = 0.0 if stage == 0 else (1.0 if stage == 3 else 0.5)
        for i in range(n):
            if stage > 0:
                trial.q[i] = flow.q[i] + c * h * stages.v[stage - 1, i]
                trial.v[i] = flow.v[i] + c * h * stages.a[stage - 1, i]
        code = accelerate(tables, address, lu, t + c * h, c, h, load, options, flow, trial, work, record, stages)
        if code != RUNNING:
            return code
        for i in range(n):
            stages.v[stage, i], stages.a[stage, i] = trial.v[i], trial.a[i]
    for i in range(n):
        v = stages.v[0, i] + 2.0 * (stages.v[1, i] + stages.v[2, i]) + stages.v[3, i]
        a = stages.a[0, i] + 2.0 * (stages.a[1, i] + stages.a[2, i]) + stages.a[3, i]
        trial.q[i] = flow.q[i] + h / 6.0 * v
        trial.v[i] = flow.v[i] + h / 6.0 * a
    if m > 0:
        code = project_state(tables, address, lu, t + h, h, options, flow, trial, work, record, stages)
        if code != RUNNING:
            return code
    code = accelerate(tables, address, lu, t + h, 1.0, h, load, options, flow, trial, work, record, stages)
    copy(trial.a, trial.x)
    return code


@compiled
def advance_explicit(tables, address, lu, options, flow, trial, work, record, stages: Stages, steps):
    """Take at most `steps` steps of fixed size; RUNNING, or the code of the ending."""
    jacobian_reuse.discard_factors(flow.reuse)
    record.count.evaluated = NOT_EVALUATED
    for _ in range(steps):
        if finished(options, flow):
            return DONE
        h = next_step_size(flow.clock.step_size, options.t_end - flow.clock.t)
        code = runge_kutta_step(tables, address, lu, h, stages.zero, options, flow, trial, work, record, stages)
        if code != RUNNING:
            return code
        if record.count.held_code != 0 or flow.clock.held_steps > 0.0:
            jacobian_reuse.update_held_multipliers(tables, lu, flow.clock.t + h, flow, trial, work, record)
        code = accept(tables, address, h, options, flow, trial, work, record, True)
        if code != RUNNING:
            return code
    return RUNNING


@dataclass(frozen=True)
class RungeKutta4(Method):
    """Classical explicit Runge-Kutta of order 4; positions and velocities are projected after every step.

    For rigid mechanisms.  Beams are stiff: their fastest wave sets the step, so use `Newmark` for them.
    """

    loops: ClassVar[tuple[Any, ...]] = (advance_explicit,)

    def stepper(self, program: Program, mechanism: Mechanism | None = None) -> Stepper:  # noqa: ARG002 - methods of users may
        """Stepper of the compiled mechanism."""
        return RungeKuttaStepper(program, new_stages(program))


class RungeKuttaStepper(Stepper):
    """Steps of the Runge-Kutta method; the balance of energies is of second order, hence coarser than the motion."""

    residual_limit = RESIDUAL_LIMIT_RUNGE_KUTTA
