"""Tangent of the implicit step: small differences of a state, carried through the steps of a run.

Unknowns of a step are the differences dq of positions, beside predicted ones, and dlam of multipliers; dv and da follow
from dq by Newmark's relations (see `Newmark`).  At the end of the step
    K dq + C dv + M da + d(G^T lam)/dq dq + G^T dlam + (dr/dz) dz = 0,
    G dq = 0,   G dv + W dq = 0,   W = dG/dt along the motion.
Both constraint equations hold, since positions have the shift e = -S^-1 G^T mu with the matrix S of the step, beside
Newmark's relation.  The change of S^-1 G^T is neglected: an error of second order, as that of the method.

Step sizes are the same for all neighbouring states.  Error-controlled steps, however, end at the onset of a contact,
which every neighbour reaches at its own time.  So from the onset on, each neighbour has a time shift tau, by which its
gap closes later: dq + tau v does not change the gap.  Without time shifts, a hard impact would multiply errors of the
time by 1/duration (a neighbour would be evaluated at other phases of its impact), and jumps of forces would be missed.
Where the gap opens, or a damped force ends before, the stiffness falls at once: neighbours are shifted there, too.
At the end dq - tau v is taken with the velocities then.  Meanwhile the equations of drives and the loads that depend on
time have tau times their rates as additional terms.

Sources: C. W. Gear, B. Leimkuhler, G. K. Gupta, J. Comput. Appl. Math. 12-13 (1985) 77-90 (the form of the
constraints); P. Muller, Chaos, Solitons and Fractals 5 (1995) 1671-1681 (jumps of forces).
Equations (9.1) to (9.3) of docs/theory/exponents.md.
"""

import math
from typing import Any

import numba
import numpy as np
from numba import types
from numba.core import config
from numba.np import arrayobj

from flexmb.engine.compiled.arrays import compiled_as
from flexmb.engine.linalg.lu import LOST_PIVOT, factor, solve
from flexmb.engine.newmark.implicit_step import newmark_coefficients
from flexmb.engine.newmark.jacobian_reuse import initial_hold
from flexmb.engine.newmark.method import Newmark, NewmarkStepper, advance
from flexmb.engine.radau.step import keep_state
from flexmb.engine.sensitivity import linearise as linearised
from flexmb.engine.sensitivity.histories import EXCESS, add_turned, complete_turned
from flexmb.engine.sensitivity.linearise import Tangents, linearise, rows_times
from flexmb.engine.sensitivity.parameters import clear_constraint, move_numbers
from flexmb.engine.sensitivity.signal_rows import find_slopes_now, keep_differences, write_rows
from flexmb.engine.state.record import BUFFER_FULL, GEAR_GUPTA_LEIMKUHLER, POSITION, RUNNING, VELOCITY, Options
from flexmb.engine.step.contact_events import slow_approach_speed
from flexmb.engine.system.constraints import call_constraint
from flexmb.engine.system.state_evaluation import StateEvaluation
from flexmb.engine.system.work import Work, workspace
from flexmb.errors import SolveError
from flexmb.kernels import compiled, copy
from flexmb.parts.contact.onset import crossing, cubic
from flexmb.program.program import COMMON_Z, LAST_FORCE, LAST_GAP, LAST_GAP_RATE, PHASE, Program
from flexmb.run.run import Run
from flexmb.statics.start.consistent import metric_of, shortest_correction

# Number of rounds at most that solve for position shifts and positions in turn; two or three are usual.
MOST_ROUNDS = 10
# Relative change of the positions from round to round: converged below the first, refused above the second.
CONVERGED_CHANGE, DIVERGED_CHANGE = 1e-13, 1e-9
LEAST_PIVOT = 1e-300  # least stiffness of a coordinate by which a force is divided
VERY_END = 0.9  # fraction of a step from which a contact that begins in it begins at its end
LATEST_END = 2.0  # most time to the end of a force as its last change has it, over the step in which it ends
WEIGHT_OF_MASS = 1e6  # weight of the mass matrix for accelerations alone, over that of the step
TANGENT_LOST = 40  # code of a step with a singular tangent


@compiled
def carry_differences(tables, address, lu, h, options, flow, trial, record, T, work):
    """Carry the differences T through the step of size h that led to `flow`; RUNNING, or TANGENT_LOST."""
    # T.start is the state before the step.
    first = T.step.before == 0.0
    o = options.first if first else options.regular
    kv, kx, ka = newmark_coefficients(h, o)
    t, n, m = flow.clock.t, tables.sizes.n_q, tables.sizes.n_c
    if options.adaptive and meets_kink(tables, h, flow, trial, T):
        shift_times(tables, address, T, work)
    if T.rows.places.shape[0] > 0:
        keep_differences(n, T)
    for j in range(T.q.shape[0]):
        start_differences(n, h, 1.0 if first else h / T.step.before, o, j, T)
    linearise(tables, address, t, h, flow.q, flow.v, flow.a, flow.lam, T.start.z, kv, ka, T, work)
    if m > 0 and options.form != POSITION:
        linearised.find_jacobian_rate(tables, address, t, h, options.length, flow.q, flow.v, flow.lam, T, work)
    if factor(lu, work.lu, T.seen, LOST_PIVOT, n, initial_hold(flow)) >= 0:
        return TANGENT_LOST
    if T.tau.any():
        linearised.find_rates(tables, address, t, h, flow.q, flow.v, flow.a, T.start.z, T, work)
    delta = options.regular.alpha_m - options.regular.alpha_f
    for j in range(T.q.shape[0]):
        if not solve_differences(tables, lu, kv, options, j, T, work):
            return TANGENT_LOST
        finish_differences(n, kv, kx, ka, delta, first, flow.clock.last_step == 0.0, j, T)
    if T.turn[:, :EXCESS].any():
        lag = 1.0 if flow.clock.last_step == 0.0 else 1.0 + delta if first else kx / ka
        if not settle_accelerations(tables, address, lu, h, WEIGHT_OF_MASS * ka, lag, flow, T, work):
            return TANGENT_LOST
    linearised.advance_histories(tables, address, t, h, flow.q, flow.v, flow.a, flow.lam, T.start.z, T, work)
    if T.rows.places.shape[0] > 0:
        write_rows(tables, address, h, options, flow, trial, record, T)
    T.step.last = 0.0 if flow.clock.last_step == 0.0 else h
    copy(T.start.a, T.ap)
    copy(T.start.z, T.zp)
    return RUNNING


@compiled
def meets_kink(tables, h, flow, trial, T):
    """Whether a contact or its force began or ended in this step, not slowly; sets T.shift, which aligns these."""
    # Of a contact that began at the very end, as round-off of the time has it, the step sees nothing (T.closing), and
    # the shift follows in the next step.
    found = False
    for c in range(tables.contacts.kernel.shape[0]):
        k = tables.contacts.z[c, COMMON_Z]
        gap, rate, s, side = T.start.z[k + LAST_GAP], T.start.z[k + LAST_GAP_RATE], 0.0, 1.0
        late, was_open, place = T.closing[c] != 0, T.start.z[k + PHASE] == 0.0, LAST_GAP
        T.closing[c] = 0
        if not late and was_open == (flow.z[k + PHASE] == 0.0):
            force = T.start.z[k + LAST_FORCE]
            drop = h * (T.zp[k + LAST_FORCE] - force) / T.step.last if T.step.last > 0.0 else 0.0
            if flow.z[k + LAST_FORCE] != 0.0 or not 0.0 < force <= LATEST_END * drop:
                continue
            place, rate = LAST_FORCE, -drop / h
        elif not late:
            side = 1.0 if was_open else -1.0
            if -side * rate <= slow_approach_speed(c, flow, trial):
                continue
            s = crossing(h, side * gap, side * rate, side * flow.z[k + LAST_GAP], side * flow.z[k + LAST_GAP_RATE])
            _, slope = cubic(s, h, gap, rate, flow.z[k + LAST_GAP], flow.z[k + LAST_GAP_RATE])
            rate = slope / h
            if s > VERY_END and was_open:
                T.closing[c] = 1
                continue
        if found or side * rate >= 0.0:
            continue
        for j in range(T.shift.shape[0]):
            T.shift[j] = -(T.z[j, k + place] + s * h * T.z[j, k + LAST_GAP_RATE]) / rate
        found = True
    return found


@compiled
def shift_times(tables, address, T, work):
    """Shift each neighbour by the time T.shift, in the state before the step."""
    for j in range(T.q.shape[0]):
        later = T.shift[j]
        T.tau[j] += later
        for i in range(tables.sizes.n_q):
            T.q[j, i] += later * T.start.v[i]
            T.v[j, i] += later * T.start.a[i]
        if T.step.last > 0.0:
            part = later / T.step.last
            for i in range(tables.sizes.n_q):
                T.a[j, i] += part * (T.start.a[i] - T.ap[i])
                T.x[j, i] += part * (T.start.a[i] - T.ap[i])
            for i in range(tables.sizes.n_z):
                T.z[j, i] += part * (T.start.z[i] - T.zp[i])
    s, t = T.start, T.step.start
    linearise(tables, address, t, 0.0, s.q, s.v, s.a, s.lam, s.z, 0.0, 1.0, T, work)
    linearised.advance_histories(tables, address, t, 0.0, s.q, s.v, s.a, s.lam, s.z, T, work)


@compiled
def start_differences(n, h, ratio, o, j, T):
    """Predict all differences at the end of a step, in T.U, T.X, T.Y and T.R."""
    for i in range(n):
        a0 = T.a[j, i]
        x0 = a0 + ratio * (T.x[j, i] - a0)
        x1 = (a0 - o.alpha_m * x0) / (1.0 - o.alpha_m)
        T.U[j, i] = T.q[j, i] + h * T.v[j, i] + h * h * ((0.5 - o.beta) * x0 + o.beta * x1)
        T.X[j, i] = T.v[j, i] + h * ((1.0 - o.gamma) * x0 + o.gamma * x1)
        T.Y[j, i], T.R[j, i] = a0, x1
        T.u[j, i], T.moved[j, i] = T.U[j, i], 0.0


@compiled
def solve_differences(tables, lu, kv, options, j, T, work):
    """Solve for positions and multipliers in T.u and position shifts in T.e; whether the solution converged."""
    # The shifts depend on the positions by W alone, which is small beside kv G, so that alternate solutions converge.
    # Positions that joints hold are round-off beside those of the same forces on unheld coordinates.
    n, m, form = tables.sizes.n_q, tables.sizes.n_c, options.form
    change, size, unheld = 0.0, 0.0, 0.0
    for i in range(n):
        unheld = max(unheld, abs(T.F[j, i]) / max(abs(T.seen[i]), LEAST_PIVOT))
    T.e[:] = 0.0
    find_gaps(tables.constraints, j, T, work)
    for _ in range(MOST_ROUNDS):
        T.b[:] = 0.0
        if m > 0 and form == GEAR_GUPTA_LEIMKUHLER:
            find_shift(tables, lu, kv, j, T, work)
            linearised.rate_forces(tables, kv, T.e, T, work)
            for i in range(n):
                T.b[i] = T.f[i]
        elif m > 0 and form == VELOCITY:
            add_rates(tables.constraints, n, 0.0, -1.0 / kv, j, T, work)
        for i in range(n):
            T.b[i] += T.F[j, i] - T.tau[j] * T.rt[i]
        if form != VELOCITY:
            for i in range(m):
                T.b[n + i] = T.gap[i]
        solve(lu, work.lu, T.b, T.d, T.y)
        change, size = 0.0, unheld
        for i in range(n):
            change = max(change, abs(T.d[i] - T.moved[j, i]))
            T.moved[j, i], T.u[j, i] = T.d[i], T.U[j, i] + T.d[i]
            size = max(size, abs(T.u[j, i]))
        for i in range(n, n + m):
            T.u[j, i] = T.d[i]
        if form == POSITION or m == 0 or change <= CONVERGED_CHANGE * size:
            break
    if m > 0 and form == GEAR_GUPTA_LEIMKUHLER:
        find_shift(tables, lu, kv, j, T, work)
    return size < np.inf and (form == POSITION or m == 0 or change <= DIVERGED_CHANGE * size)


@compiled
def find_gaps(C, j, T, work):
    """Set T.gap, G times the displacement that the prediction leaves to be found: tau G v - dg - G U."""
    for c in range(C.kernel.shape[0]):
        for i in range(C.row[c + 1] - C.row[c]):
            row = C.row[c] + i
            T.gap[row] = T.tau[j] * T.moving[linearised.SPEED, row] - rows_times(C, c, work.G, T.U[j], i)
            if j < T.by.g.shape[0]:
                T.gap[row] -= T.by.g[j, row]


@compiled
def find_shift(tables, lu, kv, j, T, work):
    """Set T.e = -S^-1 G^T mu with G e = (G X + W dq) / kv + G u: then dv = X + kv (u - e) has G dv + W dq = 0."""
    # For a neighbour with a time shift, both equations include the rates of the drives.
    T.b[:] = 0.0
    add_rates(tables.constraints, tables.sizes.n_q, kv, 1.0 / kv, j, T, work)
    solve(lu, work.lu, T.b, T.e, T.y)
    T.b[:] = 0.0


@compiled
def add_rates(C, n, kv, factor, j, T, work):
    """Add factor (G X + W dq + kv gap - tau (G a + W v)), and the effect of a parameter, to the lower half of T.b."""
    tau = T.tau[j]
    for i in range(n):
        T.r[i] = T.u[j, i]
    for c in range(C.kernel.shape[0]):
        for i in range(C.row[c + 1] - C.row[c]):
            row = C.row[c] + i
            rate = rows_times(C, c, work.G, T.X[j], i) + rows_times(C, c, T.W, T.r, i)
            if j < T.by.g.shape[0]:
                rate += T.by.gv[j, row]
            T.b[n + row] += factor * (rate + kv * T.gap[row] - tau * T.moving[linearised.ACCELERATION, row])


@compiled
def finish_differences(n, kv, kx, ka, delta, first, restarts, j, T):
    """Set the differences at the end of the step; x = a before a starting step."""
    for i in range(n):
        moved, a0, T.q[j, i] = T.moved[j, i] - T.e[i], T.a[j, i], T.u[j, i]
        T.v[j, i] = T.X[j, i] + kv * moved
        T.a[j, i] = T.Y[j, i] + ka * moved
        T.x[j, i] = T.a[j, i] + delta * (T.a[j, i] - a0) if first else T.R[j, i] + kx * moved
        if restarts:
            T.x[j, i] = T.a[j, i]


@compiled
def settle_accelerations(tables, address, lu, h, ka, lag, flow, T, work):
    """Take the forces of friction that turned out of the accelerations at the end; whether this succeeded."""
    # ka : weight of the mass matrix, beside which stiffness does not matter;  lag : change of auxiliary accelerations
    n, m, t = tables.sizes.n_q, tables.sizes.n_c, flow.clock.t
    complete_turned(tables, address, flow.q, flow.v, flow.lam, T, work)
    linearise(tables, address, t, h, flow.q, flow.v, flow.a, flow.lam, T.start.z, 0.0, ka, T, work)
    if factor(lu, work.lu, T.seen, LOST_PIVOT, n, initial_hold(flow)) >= 0:
        return False
    for j in range(T.q.shape[0]):
        T.f[:] = 0.0
        add_turned(tables, j, T.f, T, work)
        T.b[:] = 0.0
        for i in range(n):
            T.b[i] = -T.f[i]
        solve(lu, work.lu, T.b, T.d, T.y)
        for i in range(n):
            T.a[j, i] += ka * T.d[i]
            T.x[j, i] += lag * ka * T.d[i]
        for i in range(n, n + m):
            T.u[j, i] += T.d[i]
    return True


@compiled_as(lambda table, *arguments: advance(*arguments))
def step_at(typingctx, table, tables, address, lu, options, flow, trial, work, record, steps):
    """Call `advance` through its address, table[0]: a second inlined copy would double the time of compilation."""

    def codegen(context, builder, signature, args):
        array = arrayobj.make_array(signature.args[0])(context, builder, args[0])
        kinds = signature.args[1:]
        kind = context.call_conv.get_function_type(types.int64, kinds)
        function = builder.inttoptr(builder.load(array.data), kind.as_pointer())
        _, code = context.call_conv.call_function(builder, function, types.int64, kinds, args[1:])
        return code

    return types.int64(table, tables, address, lu, options, flow, trial, work, record, types.intp), codegen


@compiled
def advance_with_tangents(table, tables, address, lu, options, flow, trial, work, record, own, T, steps):
    """Take at most `steps` steps of `advance` with tangents T, or set T.rows.now; `own` : a second `Work`."""
    if steps == 0:
        find_slopes_now(tables, address, options, flow, trial, record, T)
    for _ in range(steps):
        before = record.count.steps
        keep_state(flow, T.start)
        T.step.start, T.step.before = flow.clock.t, flow.clock.last_step
        code = step_at(table, tables, address, lu, options, flow, trial, work, record, 1)
        if record.count.steps > before:
            carried = carry_differences(tables, address, lu, record.report.size, options, flow, trial, record, T, own)
            code = carried if code == RUNNING else code
            if code == RUNNING and T.rows.every and T.rows.number.steps == T.rows.times.shape[0]:
                return BUFFER_FULL
        if code != RUNNING:
            return code
    return RUNNING


# Newmark's gamma up to which errors of accelerations along the constraints do not fade: factor 1 - 1/gamma a step.
LEAST_FADING_GAMMA = 0.51
# Difference of states for derivatives that no kernel gives [rad, or relative to the size of the mechanism].
STATE_DIFFERENCE = 1e-5


class CarryingStepper(NewmarkStepper):
    """Steps of the Newmark family, with small differences of the state if `tangents` is set."""

    tangents: Tangents | None = None
    _address: Any = None

    def __init__(self, program: Program, method: Newmark) -> None:
        super().__init__(program, method)
        self.second = workspace(program)
        self.keeps_errors = method.constraints == "velocity" or method.gamma < LEAST_FADING_GAMMA

    def advance(self, run: Run, options: Options, steps: int) -> int:
        """Take at most `steps` steps; RUNNING, or the code of the ending."""
        if self.tangents is None:
            return super().advance(run, options, steps)
        arguments = run.arguments(options)
        if self._address is None:
            # Table (1,) with the address of `advance`, compiled for such arguments; unused without JIT.
            self._address = np.zeros(1, dtype=np.int64)
            if not config.DISABLE_JIT:
                found = advance.get_compile_result(types.int64(*(numba.typeof(x) for x in (*arguments, 1))))
                self._address[0] = found.library.get_pointer_to_function(found.fndesc.llvm_func_name)
        return int(advance_with_tangents(self._address, *arguments, self.second, self.tangents, steps))

    def explain(self, code: int) -> str | None:
        """Sentence on a lost tangent."""
        if code != TANGENT_LOST:
            return super().explain(code)
        return "the tangent of a step has no finite solution; or the given differences are not finite"


class CarryingRun(Run):
    """Run of the Newmark family with differences of its state, a matrix (size, k)."""

    # Rows are positions, velocities, histories, accelerations and auxiliary accelerations, as in `MechanismFlow`.
    # Differences that violate the constraints, or of accelerations alone, fade in most methods. Where they do not
    # (`keeps_errors`), they are removed at the start, since they would outlive differences that shrink.
    stepper: CarryingStepper

    def __init__(self, program: Program, method: Newmark, *others: Any, **more: Any) -> None:
        super().__init__(program, method, *others, **more)
        self.stepper = CarryingStepper(program, method)

    def carry_to(self, end: float, W: np.ndarray) -> None:
        """Run until `end` [s], and carry the differences W (size, k) along, in place."""
        self.stepper.tangents = T = unpack_differences(self.program, W)
        if self.stepper.keeps_errors:
            kept = T.x - T.a
            project_differences(self.program, self.flow, float(self.flow.clock.step_size), T)
            complete_differences(self.program, self.flow, T, self.stepper.second, histories=False)
            T.x[:] = T.a + kept
        self.run_to(end, saving=None)
        self._synchronise()
        pack_differences(self.program, T, W)
        self.stepper.tangents = None

    def on_manifold(self, W: np.ndarray) -> np.ndarray:
        """Differences (size, k) near W that satisfy the constraints, with accelerations and histories that follow."""
        T, found = unpack_differences(self.program, W), np.zeros(W.shape)
        project_differences(self.program, self.flow, float(self.flow.clock.step_size), T)
        complete_differences(self.program, self.flow, T, workspace(self.program), histories=True)
        pack_differences(self.program, T, found)
        return found

    def _synchronise(self) -> None:
        """Remove the time shifts of all neighbours; a failure ends the run with a note."""
        T = self.stepper.tangents
        if T is None or self.note:
            return
        if not all(np.isfinite(x).all() for x in (T.q, T.v, T.z, T.a, T.x, T.tau)):
            self.note = "Stopped: the carried differences grew beyond all numbers; carry them for shorter times"
            return
        try:
            synchronise(self.program, self.flow, T, self.stepper.second)
        except SolveError as error:
            self.note = f"Stopped: {str(error).rstrip('.')}"

    def _cross_jump(self, instant: float, interval: float, *, first: bool = False) -> None:
        T = self.stepper.tangents
        self._synchronise()
        super()._cross_jump(instant, interval, first=first)
        if T is not None and not self.note:
            T.step.last = 0.0
            try:
                complete_differences(self.program, self.flow, T, self.stepper.second, histories=False)
            except SolveError as error:
                self.note = f"Stopped: {str(error).rstrip('.')}"


def unpack_differences(program: Program, W: np.ndarray) -> Tangents:
    """The differences W (size, k) as arrays of the compiled loop."""
    n, n_z, T = program.n_q, program.tables.sizes.n_z, linearised.new_tangents(program, W.shape[1])
    T.q[:, :n], T.v[:, :n], T.z[:] = W[:n].T, W[n : 2 * n].T, W[2 * n : 2 * n + n_z].T
    T.a[:, :n], T.x[:, :n] = W[2 * n + n_z : 3 * n + n_z].T, W[3 * n + n_z :].T
    return T


def pack_differences(program: Program, T: Tangents, W: np.ndarray) -> None:
    """Set W (size, k) from the arrays of the compiled loop."""
    n = program.n_q
    W[:] = np.concatenate([T.q[:, :n].T, T.v[:, :n].T, T.z.T, T.a[:, :n].T, T.x[:, :n].T])


def project_differences(program: Program, flow: Any, most: float, T: Tangents) -> None:
    """Project T.q and T.v onto G dq = 0, G dv + (dG/dt) dq = 0; `most` as in `find_jacobian_rate`."""
    # Parameters add their effect on both equations at the last linearised state.
    n, t, metric = program.n_q, float(flow.clock.t), metric_of(program)
    system, q, v = StateEvaluation(program), flow.q[:n], flow.v[:n]
    G = system.at(q, t=t).jacobian
    fastest = np.abs(v / np.where(metric == 1.0, program.length, 1.0)).max()
    eps = min(most, linearised.POSE_DIFFERENCE / max(fastest, 1e-300))
    turning = (system.at(q + eps * v, t=t + eps).jacobian - system.at(q - eps * v, t=t - eps).jacobian) / (2.0 * eps)
    explicit = np.zeros((2, len(T.q), program.n_c))
    explicit[:, : len(T.by.step)] = T.by.g, T.by.gv
    for j in range(len(T.q)):
        T.q[j, :n] += shortest_correction(metric, G, -(G @ T.q[j, :n]) - explicit[0, j])
        T.v[j, :n] += shortest_correction(metric, G, -(G @ T.v[j, :n] + turning @ T.q[j, :n]) - explicit[1, j])


def complete_differences(program: Program, flow: Any, T: Tangents, work: Work, *, histories: bool) -> None:
    """Set the accelerations, and `histories`, that follow from T.q, T.v, T.z in the present state, to start a step."""
    n, t, tables = program.n_q, float(flow.clock.t), program.tables
    T.U[:], T.X[:], T.Y[:] = T.q, T.v, 0.0
    T.turn[:] = 0.0  # accelerations are those by the slopes of the laws
    now = (flow.q, flow.v, flow.a, flow.lam, flow.z)
    linearise(tables, program.addresses, t, 0.0, *now, 0.0, 1.0, T, work)
    system, b = StateEvaluation(program), np.zeros((len(T.q), n + program.n_c))
    b[:, :n] = T.F[:, :n]
    length = np.where(metric_of(program) == 1.0, program.length, 1.0)
    fast = max(float(np.abs(flow.v[:n] / length).max()), 1.0)
    for j in range(len(T.q) if program.n_c > 0 else 0):
        # Part of difference j that moves positions, velocities and numbers by a small part; infinite: it moves none.
        most = max(float(np.abs(T.q[j, :n] / length).max()), float(np.abs(T.v[j, :n] / length).max()) / fast)
        least = float(T.by.step[j]) if j < len(T.by.step) else math.inf
        eps = min(STATE_DIFFERENCE / most if most > 0.0 else math.inf, least)
        if eps < math.inf:
            find_acceleration_gap(tables, program.addresses, t, eps, *now[:4], j, T, work)
            b[j, n:] = -T.gap
    system.at(flow.q[:n], flow.v[:n], lam=flow.lam, z=flow.z, t=t, weights=(0.0, 0.0, 1.0))
    T.u[:] = system.solve(b.T, f"Tangent of the accelerations of {program.name!r} at t = {t:.6g} s").T
    T.a[:, :n] = T.u[:, :n]
    T.x[:] = T.a
    if histories:
        linearised.advance_histories(tables, program.addresses, t, 0.0, *now, T, work)


@compiled
def find_acceleration_gap(tables, address, t, eps, q, v, a, lam, j, T, work):
    """Set T.gap to difference j of G a - gamma by differences of q, v and the numbers, at constant a."""
    C, moves, varied = tables.constraints, j < T.by.step.shape[0], T.by.varied
    for side in range(2):
        e = eps if side == 0 else -eps
        if moves:
            move_numbers(tables, T.by, j, e)
        for c in range(C.kernel.shape[0]):
            n, m = C.dof[c + 1] - C.dof[c], C.row[c + 1] - C.row[c]
            for i in range(n):
                dof = C.dofs[C.dof[c] + i]
                work.ql[i], work.vl[i] = q[dof] + e * T.q[j, dof], v[dof] + e * T.v[j, dof]
            clear_constraint(C, c, n, work)
            call_constraint(varied if moves else tables, address, c, n, m, t, lam, work)
            for i in range(m):
                row = C.row[c] + i
                found = rows_times(C, c, work.G, a, i) - work.gamma[row]
                T.gap[row] = found if side == 0 else (T.gap[row] - found) / (2.0 * eps)
    if moves:
        move_numbers(tables, T.by, j, 0.0)


def synchronise(program: Program, flow: Any, T: Tangents, work: Work) -> None:
    """Remove the time shifts T.tau, which neighbours have since the last impact."""
    if not T.tau.any():
        return
    n, later, kept = program.n_q, -T.tau[:, None], T.x - T.a
    T.q[:, :n] += later * flow.v[:n]
    T.v[:, :n] += later * flow.a[:n]
    if T.step.last > 0.0:
        T.z[:] += later / T.step.last * (flow.z - T.zp)
    T.tau[:] = 0.0
    complete_differences(program, flow, T, work, histories=True)
    T.x[:] = T.a + kept
