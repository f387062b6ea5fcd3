"""Tangent of the implicit step: small differences of a state, carried through the steps of a run.

Unknowns of a step are the differences dq of positions and dlam of multipliers; dv and da follow from dq by Newmark's
relations (see `Newmark`).  At the end of the step
    K dq + C dv + M da + d(G^T lam)/dq dq + G^T dlam + (dr/dz) dz = 0,
    G dq = 0,   G dv + W dq = 0,   W = dG/dt along the motion.
Both constraint equations hold, since positions have the shift e = -S^-1 G^T mu with the matrix S of the step, beside
Newmark's relation.  The change of S^-1 G^T is neglected: an error of second order, as that of the method.

Step sizes are the same for all neighbouring states.  Error-controlled steps, however, end at the onset of a contact,
which every neighbour reaches at its own time.  So from the onset on, each neighbour has a time shift tau, by which its
gap closes later: dq + tau v does not change the gap.  Without time shifts, a hard impact would multiply errors of the
time by 1/duration (a neighbour would be evaluated at other phases of its impact), and jumps of forces would be missed.
At the end dq - tau v is taken with the velocities then.  Meanwhile the equations of drives and the loads that depend on
time have tau times their rates as additional terms.

Sources: C. W. Gear, B. Leimkuhler, G. K. Gupta, J. Comput. Appl. Math. 12-13 (1985) 77-90 (the form of the
constraints); P. Muller, Chaos, Solitons and Fractals 5 (1995) 1671-1681 (jumps of forces).
Equations (9.1) to (9.3) of docs/theory/exponents.md.
"""

from typing import Any

import numba
import numpy as np
from numba import types
from numba.core import config
from numba.extending import intrinsic
from numba.np import arrayobj

from flexmb.kernels import compiled, copy
from flexmb.linalg.lu import HELD_PIVOT, LOST_PIVOT, factor
from flexmb.linalg.substitute import solve
from flexmb.program.tables import COMMON_Z, LAST_GAP, LAST_GAP_RATE, PHASE
from flexmb.sensitivity.linearise import (
    ACCELERATION,
    SPEED,
    advance_histories,
    find_jacobian_rate,
    find_rates,
    linearise,
    rate_forces,
    rows_times,
)
from flexmb.state.options import GEAR_GUPTA_LEIMKUHLER, POSITION, VELOCITY
from flexmb.state.record import RUNNING
from flexmb.step.contact_events import IMPACT_STEP, slow_approach_speed
from flexmb.step.newmark.loop import advance

MOST_ROUNDS = 10
"""Number of rounds at most that solve for position shifts and positions in turn; two or three are usual."""

CONVERGED_CHANGE, DIVERGED_CHANGE = 1e-13, 1e-9
"""Relative change of the positions from round to round: converged below the first, refused above the second."""

TANGENT_LOST = 40
"""Code of a step with a singular tangent."""


@compiled
def store_start(flow, T):
    """Store the state before a step."""
    copy(flow.q, T.q0)
    copy(flow.v, T.v0)
    copy(flow.a, T.a0)
    copy(flow.lam, T.lam0)
    copy(flow.z, T.z0)
    T.step.start, T.step.before = flow.clock.t, flow.clock.last_step
    for c in range(flow.impacts.shape[0]):
        copy(flow.impacts[c], T.impacts[c])


@compiled
def carry_differences(tables, address, lu, h, options, flow, trial, T, work):
    """Carry the differences T through the step of size h that led to `flow`; RUNNING, or TANGENT_LOST.

    `store_start` has stored the state before the step.
    """
    first = T.step.before == 0.0
    o = options.first if first else options.regular
    kv, kx = o.gamma / (o.beta * h), 1.0 / (o.beta * h * h)
    ka = (1.0 - o.alpha_m) / (1.0 - o.alpha_f) * kx
    t, n, m = flow.clock.t, tables.sizes.n_q, tables.sizes.n_c
    if options.adaptive and meets_onset(tables, flow, trial, T):
        shift_times(tables, address, T, work)
    for j in range(T.q.shape[0]):
        start_differences(n, h, 1.0 if first else h / T.step.before, kv, kx, ka, o, j, T)
    linearise(tables, address, t, h, flow.q, flow.v, flow.a, flow.lam, T.z0, kv, ka, T, work)
    if m > 0 and options.form != POSITION:
        find_jacobian_rate(tables, address, t, h, options.length, flow.q, flow.v, flow.lam, T, work)
    if factor(lu, work.lu, T.seen, LOST_PIVOT, n, HELD_PIVOT if flow.clock.held_steps >= 0.0 else LOST_PIVOT) >= 0:
        return TANGENT_LOST
    if has_time_shift(T):
        find_rates(tables, address, t, h, flow.q, flow.v, flow.a, T.z0, T, work)
    delta = options.regular.alpha_m - options.regular.alpha_f
    for j in range(T.q.shape[0]):
        if not solve_differences(tables, lu, kv, options, j, T, work):
            return TANGENT_LOST
        finish_differences(n, kv, kx, ka, delta, first, flow.clock.last_step == 0.0, j, T)
    advance_histories(tables, address, t, h, flow.q, flow.v, flow.a, flow.lam, T.z0, T, work)
    T.step.last = 0.0 if flow.clock.last_step == 0.0 else h
    copy(T.a0, T.ap)
    copy(T.z0, T.zp)
    return RUNNING


@compiled
def has_time_shift(T):
    """Whether a neighbour has a time shift."""
    for j in range(T.tau.shape[0]):  # noqa: SIM110 - compiled
        if T.tau[j] != 0.0:
            return True
    return False


@compiled
def meets_onset(tables, flow, trial, T):
    """Whether a contact began in this step at a located onset; sets T.shift, which aligns the onsets."""
    for c in range(tables.contacts.kernel.shape[0]):
        k = tables.contacts.z[c, COMMON_Z]
        rate = T.z0[k + LAST_GAP_RATE]
        if (
            T.z0[k + PHASE] == 0.0
            and flow.z[k + PHASE] != 0.0
            and T.impacts[c, IMPACT_STEP] > 0.0
            and -rate > slow_approach_speed(c, flow, trial)
        ):
            for j in range(T.shift.shape[0]):
                T.shift[j] = -T.z[j, k + LAST_GAP] / rate
            return True
    return False


@compiled
def shift_times(tables, address, T, work):
    """Shift each neighbour by the time T.shift, in the state before the step."""
    for j in range(T.q.shape[0]):
        later = T.shift[j]
        T.tau[j] += later
        for i in range(tables.sizes.n_q):
            T.q[j, i] += later * T.v0[i]
            T.v[j, i] += later * T.a0[i]
        if T.step.last > 0.0:
            part = later / T.step.last
            for i in range(tables.sizes.n_q):
                T.a[j, i] += part * (T.a0[i] - T.ap[i])
                T.x[j, i] += part * (T.a0[i] - T.ap[i])
            for i in range(tables.sizes.n_z):
                T.z[j, i] += part * (T.z0[i] - T.zp[i])
    linearise(tables, address, T.step.start, 0.0, T.q0, T.v0, T.a0, T.lam0, T.z0, 0.0, 1.0, T, work)
    advance_histories(tables, address, T.step.start, 0.0, T.q0, T.v0, T.a0, T.lam0, T.z0, T, work)


@compiled
def start_differences(n, h, ratio, kv, kx, ka, o, j, T):
    """Predict differences of positions in T.u; set T.X, T.Y and T.R, the other differences at unchanged positions."""
    am = o.alpha_m
    for i in range(n):
        a0 = T.a[j, i]
        x0 = a0 + ratio * (T.x[j, i] - a0)
        x1 = (a0 - am * x0) / (1.0 - am)
        guess = T.q[j, i] + h * T.v[j, i] + h * h * ((0.5 - o.beta) * x0 + o.beta * x1)
        T.u[j, i] = guess
        T.X[j, i] = T.v[j, i] + h * ((1.0 - o.gamma) * x0 + o.gamma * x1) - kv * guess
        T.Y[j, i], T.R[j, i] = a0 - ka * guess, x1 - kx * guess


@compiled
def solve_differences(tables, lu, kv, options, j, T, work):
    """Solve for positions and multipliers in T.u and position shifts in T.e; whether the solution converged.

    The shifts depend on the positions by W alone, which is small beside kv G, so that alternate solutions converge.
    """
    n, m, form = tables.sizes.n_q, tables.sizes.n_c, options.form
    u, change, size = T.u[j], 0.0, 0.0
    T.e[:] = 0.0
    for _ in range(MOST_ROUNDS):
        T.b[:] = 0.0
        if m > 0 and form == GEAR_GUPTA_LEIMKUHLER:
            find_shift(tables, lu, kv, j, T, work)
            rate_forces(tables, kv, T.e, T, work)
            for i in range(n):
                T.b[i] = T.f[i]
        elif m > 0 and form == VELOCITY:
            add_rates(tables.constraints, n, 0.0, -1.0 / kv, j, T, work)
        for i in range(n):
            T.b[i] += T.F[j, i] - T.tau[j] * T.rt[i]
        if form != VELOCITY:
            for i in range(m):
                T.b[n + i] = T.tau[j] * T.moving[SPEED, i]
        solve(lu, work.lu, T.b, T.d, T.y)
        change, size = 0.0, 0.0
        for i in range(n):
            change, size = max(change, abs(T.d[i] - u[i])), max(size, abs(T.d[i]))
        copy(T.d, u)
        if form == POSITION or m == 0 or change <= CONVERGED_CHANGE * size:
            break
    if m > 0 and form == GEAR_GUPTA_LEIMKUHLER:
        find_shift(tables, lu, kv, j, T, work)
    return size < np.inf and (form == POSITION or m == 0 or change <= DIVERGED_CHANGE * size)


@compiled
def find_shift(tables, lu, kv, j, T, work):
    """Set T.e = -S^-1 G^T mu with G e = (G X + W u) / kv, so that dv = X + kv (u - e) satisfies G dv + W u = 0.

    For a neighbour with a time shift, both equations include the rates of the drives.
    """
    T.b[:] = 0.0
    add_rates(tables.constraints, tables.sizes.n_q, kv, 1.0 / kv, j, T, work)
    solve(lu, work.lu, T.b, T.e, T.y)
    T.b[:] = 0.0


@compiled
def add_rates(C, n, kv, factor, j, T, work):
    """Add factor (G X + W u + tau (kv G v - G a - W v)) to the lower half of T.b."""
    tau = T.tau[j]
    for i in range(n):
        T.r[i] = T.u[j, i]
    for c in range(C.kernel.shape[0]):
        for i in range(C.row[c + 1] - C.row[c]):
            row = C.row[c] + i
            rate = rows_times(C, c, work.G, T.X[j], i) + rows_times(C, c, T.W, T.r, i)
            T.b[n + row] += factor * (rate + tau * (kv * T.moving[SPEED, row] - T.moving[ACCELERATION, row]))


@compiled
def finish_differences(n, kv, kx, ka, delta, first, restarts, j, T):
    """Set the differences at the end of the step; x = a before a first step."""
    for i in range(n):
        moved, a0 = T.u[j, i] - T.e[i], T.a[j, i]
        T.q[j, i] = T.u[j, i]
        T.v[j, i] = T.X[j, i] + kv * moved
        T.a[j, i] = T.Y[j, i] + ka * moved
        T.x[j, i] = T.a[j, i] + delta * (T.a[j, i] - a0) if first else T.R[j, i] + kx * moved
        if restarts:
            T.x[j, i] = T.a[j, i]


def _step_at() -> Any:
    """Make the compiled function (table, ...) that calls `advance` through its address, table[0].

    A second inlined copy of `advance` would double the time of compilation.
    """
    if config.DISABLE_JIT:
        return lambda table, *arguments: advance(*arguments)

    @intrinsic
    def step_at(typingctx, table, tables, address, lu, options, flow, trial, work, record, steps):
        def codegen(context, builder, signature, args):
            array = arrayobj.make_array(signature.args[0])(context, builder, args[0])
            kinds = signature.args[1:]
            kind = context.call_conv.get_function_type(types.int64, kinds)
            function = builder.inttoptr(builder.load(array.data), kind.as_pointer())
            _, code = context.call_conv.call_function(builder, function, types.int64, kinds, args[1:])
            return code

        given = (tables, address, lu, options, flow, trial, work, record, types.intp)
        return types.int64(table, *given), codegen

    return step_at


step_at = _step_at()


def address_of_advance(*arguments: Any) -> Any:
    """Table (1,) with the address of `advance`, compiled for such arguments; unused without JIT."""
    table = np.zeros(1, dtype=np.int64)
    if not config.DISABLE_JIT:
        found = advance.get_compile_result(types.int64(*(numba.typeof(x) for x in arguments)))
        table[0] = found.library.get_pointer_to_function(found.fndesc.llvm_func_name)
    return table


@compiled
def advance_with_tangents(table, tables, address, lu, options, flow, trial, work, record, own, T, steps):
    """Take at most `steps` steps of `advance` with tangents T; `own` : a second `Work`."""
    for _ in range(steps):
        before = record.count.steps
        store_start(flow, T)
        code = step_at(table, tables, address, lu, options, flow, trial, work, record, 1)
        if record.count.steps > before:
            carried = carry_differences(tables, address, lu, record.report.size, options, flow, trial, T, own)
            code = carried if code == RUNNING else code
        if code != RUNNING:
            return code
    return RUNNING
