"""Works of a step of Radau's method, and the state between its ends."""

from flexmb.integrate.collocation import AT_END, AT_START, LAST
from flexmb.integrate.ledger import (
    CONTACT,
    DAMPING,
    DRIVE,
    FRICTION,
    GRAVITY,
    KINETIC,
    LOAD,
    STRAIN,
    TURNED,
    balance,
    keep_account,
    note_step,
)
from flexmb.integrate.runge_kutta import accelerate
from flexmb.kernels import compiled, copy
from flexmb.places import FRICTION_FORCE, GAP_RATE, NORMAL_FORCE, SLIP
from flexmb.program.tables import GRIP_LAW
from flexmb.system.constraints import report_forces
from flexmb.system.evaluate import evaluate_accepted
from flexmb.system.work import DRIVE_FORCE, GRIP_FORCE, GRIP_SLIP, LOSS_FRICTION, LOSS_NORMAL, MOTION_RATE


@compiled
def add_works(tables, address, lu, h, options, flow, trial, work, record, R):
    """R.works and R.losses by Simpson's rule; the state of the last evaluation is that of the trial.

    The multipliers of the stages are of third order.  So those of the middle are found from the quintic through both
    ends, as those of instants that are saved.
    """
    W, Q, V, A, L = R.works, R.Q[LAST], R.V[LAST], R.A[LAST], R.L[LAST]
    W.drives = W.loads = W.joints = W.damping = W.brought = W.joints_size = 0.0
    R.losses[:, :] = 0.0
    R.rates[:, :] = 0.0
    copy(trial.q, Q)
    copy(trial.v, V)
    copy(trial.a, A)
    copy(trial.lam, L)
    t = flow.clock.t
    if working(tables, flow):
        add_powers(tables, address, t, 0.0, h / 6.0, flow.q, flow.v, flow.a, flow.lam, flow, work, R, R.rates[AT_START])
        quintic(tables.sizes.n_q, 0.5, h, R.old, Q, V, A, trial)
        for i in range(tables.sizes.n_c):
            trial.lam[i] = 0.5 * (flow.lam[i] + L[i])
        accelerate(tables, address, lu, t + 0.5 * h, 0.5, h, R.zero, options, flow, trial, work, record, R)
        q, v, a, lam = trial.q, trial.v, trial.a, trial.lam
        add_powers(tables, address, t + 0.5 * h, 0.5 * h, h / 1.5, q, v, a, lam, flow, work, R, R.rates[AT_END])
        R.rates[AT_END, :] = 0.0
        copy(Q, trial.q)
        copy(V, trial.v)
        copy(A, trial.a)
        copy(L, trial.lam)
        record.count.evaluations += 2
    add_powers(tables, address, t + h, h, h / 6.0, Q, V, A, L, flow, work, R, R.rates[AT_END])
    record.count.evaluations += 1


@compiled
def add_powers(tables, address, t, part, share, q, v, a, lam, flow, work, R, rates):
    """Add the powers of a state at the time t times the part `share` of the step [s], and its powers to `rates`."""
    W = R.works
    evaluate_accepted(tables, address, t, part, q, v, a, lam, flow.z, R.zero, R.zero, work)
    report_forces(tables, lam, work)
    W.damping += share * work.power.damping
    rates[DAMPING] += work.power.damping
    for row in range(work.drive.shape[0]):
        if tables.constraints.motion[row] >= 0:
            power = work.drive[row, MOTION_RATE] * work.drive[row, DRIVE_FORCE]
            W.drives += share * power
            rates[DRIVE] += power
            W.brought += share * abs(power)
    for c in range(work.grip.shape[0]):
        if tables.constraints.grip[c, GRIP_LAW] >= 0:
            power = work.grip[c, GRIP_FORCE] * work.grip[c, GRIP_SLIP]
            W.joints -= share * power
            rates[FRICTION] -= power
            W.joints_size += share * abs(power)
    for c in range(R.losses.shape[0]):
        contact = work.contact[c]
        normal, friction = contact[NORMAL_FORCE] * contact[GAP_RATE], contact[FRICTION_FORCE] * contact[SLIP]
        R.losses[c, LOSS_NORMAL] -= share * normal
        R.losses[c, LOSS_FRICTION] -= share * friction
        rates[CONTACT] -= normal
        rates[FRICTION] -= friction
    add_loads(tables, share, v, work, W, rates)


@compiled
def working(tables, flow):
    """Whether anything does work: drives, contacts, friction in joints, dampers, elements that are loads."""
    C, E = tables.constraints, tables.elements
    if tables.contacts.kernel.shape[0] > 0 or tables.sizes.gripped or flow.account.damping_power != 0.0:
        return True
    for row in range(C.motion.shape[0]):
        if C.motion[row] >= 0:
            return True
    for e in range(E.p.shape[0]):  # noqa: SIM110 - compiled
        if E.energy[e] < 0 or E.factor[e] >= 0:
            return True
    return False


@compiled
def add_loads(tables, share, v, work, W, rates):
    """Power of elements without an account of their own, over the part `share` of the time [s]."""
    E, place, power = tables.elements, 0, 0.0
    for e in range(E.p.shape[0]):
        if E.energy[e] < 0:
            for i in range(E.dof[e], E.dof[e + 1]):
                power += work.load[place] * v[E.dofs[i]]
                place += 1
    W.loads += share * power
    rates[LOAD] += power
    W.brought += share * abs(power)


@compiled
def book_works(tables, address, t, turned, flow, trial, work, R):
    """Bring the ledger to the trial state."""
    ledger, account, W = flow.ledger, flow.account, R.works
    power = work.power
    turned += abs(power.kinetic - ledger[KINETIC]) + abs(power.strain - ledger[STRAIN])
    turned += abs(power.gravity - ledger[GRAVITY])
    ledger[DRIVE] += W.drives
    ledger[LOAD] += W.loads
    ledger[FRICTION] += W.joints
    ledger[DAMPING] += W.damping
    ledger[TURNED] += 0.5 * turned
    account.put_in += W.brought
    power.algorithm = 0.0
    note_step(tables, trial.q, account, work)
    keep_account(tables, address, t, 0.0, flow.q, flow.v, trial.q, trial.v, ledger, account, flow.memory, work)
    copy(work.momentum, flow.momentum)


@compiled
def ledger_at(s, h, old, rates, flow, work, ledger):
    """The ledger at the fraction s of a step: cubics through works and powers at its ends, energies of the state."""
    rise, begin, end = s * s * (3.0 - 2.0 * s), h * s * (1.0 - s) ** 2, h * s * s * (s - 1.0)
    for i in range(ledger.shape[0]):
        ledger[i] = old[i] + rise * (flow.ledger[i] - old[i]) + begin * rates[AT_START, i] + end * rates[AT_END, i]
    power = work.power
    ledger[KINETIC], ledger[STRAIN], ledger[GRAVITY] = power.kinetic, power.strain, power.gravity
    balance(ledger, flow.account)


@compiled
def quintic(n, s, h, old, q, v, a, trial):
    """Positions and velocities at the fraction s of the step from `old` to q, v, a, by Hermite's polynomial."""
    for i in range(n):
        rise = (q[i] - old.q[i]) / h
        v0, v1, a0, a1 = old.v[i], v[i], h * old.a[i], h * a[i]
        c3 = 10.0 * rise - 6.0 * v0 - 4.0 * v1 - 1.5 * a0 + 0.5 * a1
        c4 = -15.0 * rise + 8.0 * v0 + 7.0 * v1 + 1.5 * a0 - a1
        c5 = 6.0 * rise - 3.0 * (v0 + v1) + 0.5 * (a1 - a0)
        trial.q[i] = old.q[i] + h * s * (v0 + s * (0.5 * a0 + s * (c3 + s * (c4 + s * c5))))
        trial.v[i] = v0 + s * (a0 + s * (3.0 * c3 + s * (4.0 * c4 + s * 5.0 * c5)))
        trial.a[i] = (1.0 - s) * old.a[i] + s * a[i]
