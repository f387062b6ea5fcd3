"""Works of a step of Radau's method, and states within the step."""

from flexmb.energy.balance import (
    CONTACT,
    DAMPING,
    DRIVE,
    FRICTION,
    GRAVITY,
    KINETIC,
    LOAD,
    STRAIN,
    TURNED_OVER,
    count_step,
    update_balance,
    update_residual,
)
from flexmb.kernels import compiled, copy
from flexmb.places import FRICTION_FORCE, GAP_RATE, NORMAL_FORCE, SLIP
from flexmb.program.tables import LOAD_KERNEL
from flexmb.state.record import RUNNING
from flexmb.step.radau.collocation import AT_END, AT_START, ELSEWHERE, LAST, WEIGHTS, C
from flexmb.step.radau.step import cubic_weights
from flexmb.step.runge_kutta import accelerate
from flexmb.system.constraints import report_forces
from flexmb.system.evaluate import evaluate_accepted
from flexmb.system.work import DRIVE_FORCE, JOINT_FRICTION_FORCE, JOINT_SLIP, LOSS_FRICTION, LOSS_NORMAL, MOTION_RATE

ACCELERATION_MISMATCH = 0.01
"""Difference between computed and interpolated accelerations within a step relative to the largest, up to which the
computed ones are used: with stiff forces, they are the error of the interpolated positions times the stiffness."""

INSENSITIVE = 0.1
"""Change of the computed accelerations by other interpolated positions, relative to the difference above, up to which
they are used nevertheless: a drive, cam or load has a kink within the step, which no interpolation follows."""


@compiled
def add_works(tables, address, lu, h, options, flow, trial, work, record, R):
    """Fill R.works and R.losses; the last evaluation is that of the trial state.

    Works of dampers, contacts and loads by Radau's quadrature over the stages.  Works of drives and of friction in
    joints by Simpson's rule with the middle of the step, since multipliers at the stages are of third order.
    """
    W, Q, V, A, L = R.works, R.Q[LAST], R.V[LAST], R.A[LAST], R.L[LAST]
    W.drives = W.loads = W.joints = W.damping = W.supplied = W.joints_size = 0.0
    R.losses[:, :] = 0.0
    R.rates[:, :] = 0.0
    copy(trial.q, Q)
    copy(trial.v, V)
    copy(trial.a, A)
    copy(trial.lam, L)
    t = flow.clock.t
    start, end, other = R.rates[AT_START], R.rates[AT_END], R.rates[ELSEWHERE]
    if has_work(tables, flow):
        add_powers(tables, address, t, 0.0, 0.0, h / 6.0, flow.q, flow.v, flow.a, flow.lam, flow, work, R, start)
        for stage in range(LAST):
            q, v, a, lam, elapsed = R.Q[stage], R.V[stage], R.A[stage], R.L[stage], C[stage] * h
            add_powers(
                tables, address, t + elapsed, elapsed, WEIGHTS[stage] * h, 0.0, q, v, a, lam, flow, work, R, other
            )
        find_between(tables, address, lu, t, 0.5, h, Q, V, A, L, options, flow, trial, work, record, R)
        q, v, a, lam, elapsed = trial.q, trial.v, trial.a, trial.lam, 0.5 * h
        add_powers(tables, address, t + elapsed, elapsed, 0.0, h / 1.5, q, v, a, lam, flow, work, R, other)
        copy(Q, trial.q)
        copy(V, trial.v)
        copy(A, trial.a)
        copy(L, trial.lam)
        record.count.evaluations += 4
    add_powers(tables, address, t + h, h, WEIGHTS[LAST] * h, h / 6.0, Q, V, A, L, flow, work, R, end)
    record.count.evaluations += 1


@compiled
def find_between(tables, address, lu, t, s, h, q1, v1, a1, lam1, options, flow, trial, work, record, R):
    """Set the trial state to the state at fraction s of the step from R.old to q1, ..., which began at t.

    Accelerations and multipliers satisfy the equations of motion.  Interpolated ones (through both ends and the
    stages) are used where these differ much, and depend much on how positions are interpolated.
    """
    n, m, n_b, old = tables.sizes.n_q, tables.sizes.n_c, tables.sizes.n_b, R.old
    quintic(n, s, h, old, q1, v1, trial, a1)
    w0, w1, w2, w3 = cubic_weights(s)
    for i in range(m):
        R.lam[i] = w0 * old.lam[i] + w1 * R.past_lam[1, i] + w2 * R.past_lam[2, i] + w3 * lam1[i]
        trial.lam[i] = R.lam[i]
    code = accelerate(tables, address, lu, t + s * h, s, h, R.zero, options, flow, trial, work, record, R)
    apart, largest = 0.0, 0.0
    for i in range(n):
        a = w0 * old.a[i] + w1 * R.past[1, i] + w2 * R.past[2, i] + w3 * a1[i]
        size = (options.length if tables.kind[i] == 1 else 1.0) if i < n_b else 0.0
        apart, largest = max(apart, size * abs(trial.a[i] - a)), max(largest, size * max(abs(old.a[i]), abs(a1[i])))
        R.of_q[i], R.of_v[i] = a, trial.a[i]
    if code == RUNNING and apart <= ACCELERATION_MISMATCH * largest:
        return
    changed = 0.0
    for end in range(2):
        quintic(n, s, h, old, q1, v1, trial, a1)
        leave_out_acceleration(n, s, h, end, old, q1, v1, a1, trial)
        if code == RUNNING:
            code = accelerate(tables, address, lu, t + s * h, s, h, R.zero, options, flow, trial, work, record, R)
        for i in range(n_b):
            changed = max(changed, (options.length if tables.kind[i] == 1 else 1.0) * abs(trial.a[i] - R.of_v[i]))
    quintic(n, s, h, old, q1, v1, trial, a1)
    copy(R.lam, trial.lam)
    if code == RUNNING and changed <= INSENSITIVE * apart:
        accelerate(tables, address, lu, t + s * h, s, h, R.zero, options, flow, trial, work, record, R)
    else:
        copy(R.of_q, trial.a)


@compiled
def leave_out_acceleration(n, s, h, end, old, q, v, a, trial):
    """Take from the quintic its part by the acceleration at the start (end = 0) or at the end of the step (1)."""
    for i in range(n):
        rise, v0, v1 = (q[i] - old.q[i]) / h, old.v[i], v[i]
        if end == 0:
            part = 0.5 * h * old.a[i] - (3.0 * rise - 2.0 * v0 - v1)
            trial.q[i] -= h * part * s * s * (1.0 - s) ** 3
            trial.v[i] -= part * s * (1.0 - s) ** 2 * (2.0 - 5.0 * s)
        else:
            part = 0.5 * h * a[i] - (v0 + 2.0 * v1 - 3.0 * rise)
            trial.q[i] -= h * part * s**3 * (1.0 - s) ** 2
            trial.v[i] -= part * s * s * (1.0 - s) * (3.0 - 5.0 * s)


@compiled
def add_powers(tables, address, t, elapsed, forces, joints, q, v, a, lam, flow, work, R, rates):
    """Add the powers of a state at time t to `rates` [W], and, times weights [s], to the works.

    forces : weight of dampers, contacts and loads [s];  joints : weight of drives and friction in joints [s]
    """
    W = R.works
    evaluate_accepted(tables, address, t, elapsed, q, v, a, lam, flow.z, R.zero, R.zero, work)
    report_forces(tables, lam, work)
    W.damping += forces * work.power.damping
    rates[DAMPING] += work.power.damping
    for row in range(work.drive.shape[0]):
        if tables.constraints.motion[row] >= 0:
            power = work.drive[row, MOTION_RATE] * work.drive[row, DRIVE_FORCE]
            W.drives += joints * power
            rates[DRIVE] += power
            W.supplied += joints * abs(power)
    for c in range(work.joint_friction.shape[0]):
        if tables.constraints.joint_friction[c, LOAD_KERNEL] >= 0:
            power = work.joint_friction[c, JOINT_FRICTION_FORCE] * work.joint_friction[c, JOINT_SLIP]
            W.joints -= joints * power
            rates[FRICTION] -= power
            W.joints_size += joints * abs(power)
    for c in range(R.losses.shape[0]):
        contact = work.contact[c]
        normal, friction = contact[NORMAL_FORCE] * contact[GAP_RATE], contact[FRICTION_FORCE] * contact[SLIP]
        R.losses[c, LOSS_NORMAL] -= forces * normal
        R.losses[c, LOSS_FRICTION] -= forces * friction
        rates[CONTACT] -= normal
        rates[FRICTION] -= friction
    add_loads(tables, forces, v, work, W, rates)


@compiled
def has_work(tables, flow):
    """Whether the mechanism has drives, contacts, friction in joints, dampers or loads."""
    C, E = tables.constraints, tables.elements
    if tables.contacts.kernel.shape[0] > 0 or tables.sizes.has_joint_friction or flow.balance.damping_power != 0.0:
        return True
    for row in range(C.motion.shape[0]):
        if C.motion[row] >= 0:
            return True
    for e in range(E.p.shape[0]):  # noqa: SIM110 - compiled
        if E.energy[e] < 0 or E.factor[e] >= 0:
            return True
    return False


@compiled
def add_loads(tables, weight, v, work, W, rates):
    """Add the power of elements without energies of their own, and its work over the time `weight` [s]."""
    E, place, power = tables.elements, 0, 0.0
    for e in range(E.p.shape[0]):
        if E.energy[e] < 0:
            for i in range(E.dof[e], E.dof[e + 1]):
                power += work.load[place] * v[E.dofs[i]]
                place += 1
    W.loads += weight * power
    rates[LOAD] += power
    W.supplied += weight * abs(power)


@compiled
def update_ledger(tables, address, t, turned, flow, trial, work, R):
    """Update the ledger to the trial state; `turned`: absolute works of the step [J]."""
    ledger, balance, W = flow.ledger, flow.balance, R.works
    power = work.power
    turned += abs(power.kinetic - ledger[KINETIC]) + abs(power.strain - ledger[STRAIN])
    turned += abs(power.gravity - ledger[GRAVITY])
    ledger[DRIVE] += W.drives
    ledger[LOAD] += W.loads
    ledger[FRICTION] += W.joints
    ledger[DAMPING] += W.damping
    ledger[TURNED_OVER] += 0.5 * turned
    balance.supplied += W.supplied
    power.algorithm = 0.0
    count_step(tables, trial.q, balance, work)
    update_balance(tables, address, t, 0.0, flow.q, flow.v, trial.q, trial.v, ledger, balance, flow.memory, work)
    copy(work.momentum, flow.momentum)


@compiled
def ledger_at(s, h, old, rates, flow, work, ledger):
    """Ledger at fraction s of a step: cubics through works and powers at both ends; energies of the state."""
    rise, begin, end = s * s * (3.0 - 2.0 * s), h * s * (1.0 - s) ** 2, h * s * s * (s - 1.0)
    for i in range(ledger.shape[0]):
        ledger[i] = old[i] + rise * (flow.ledger[i] - old[i]) + begin * rates[AT_START, i] + end * rates[AT_END, i]
    power = work.power
    ledger[KINETIC], ledger[STRAIN], ledger[GRAVITY] = power.kinetic, power.strain, power.gravity
    update_residual(ledger, flow.balance)


@compiled
def quintic(n, s, h, old, q, v, trial, a):
    """Set trial positions and velocities at fraction s of the step from `old` to q, v, a: Hermite's polynomial."""
    for i in range(n):
        rise = (q[i] - old.q[i]) / h
        v0, v1, a0, a1 = old.v[i], v[i], h * old.a[i], h * a[i]
        c3 = 10.0 * rise - 6.0 * v0 - 4.0 * v1 - 1.5 * a0 + 0.5 * a1
        c4 = -15.0 * rise + 8.0 * v0 + 7.0 * v1 + 1.5 * a0 - a1
        c5 = 6.0 * rise - 3.0 * (v0 + v1) + 0.5 * (a1 - a0)
        trial.q[i] = old.q[i] + h * s * (v0 + s * (0.5 * a0 + s * (c3 + s * (c4 + s * c5))))
        trial.v[i] = v0 + s * (a0 + s * (3.0 * c3 + s * (4.0 * c4 + s * 5.0 * c5)))
        trial.a[i] = (1.0 - s) * old.a[i] + s * a[i]
