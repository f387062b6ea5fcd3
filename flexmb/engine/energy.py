"""Balance of energies over a run, and the work of contacts in a step.

Kinetic energy, strain energy and the potential of gravity are exact at every state.  A force f that is known at both
ends of a step does the work

    W = (f0 + f1)/2 . (q1 - q0),

which is exact for potentials of second degree.  With this rule for the forces of inertia, loads, drives and contacts
alike, all works add up to round-off if the equations of motion hold at both ends and the mass is constant, for any
relation between q, v and a.  The remaining terms are in docs/decisions/031-balance-of-energies.md.
Equations (7.1), (7.3) and (7.5) of docs/theory/energy.md.
"""

import math

import numpy as np

from flexmb.engine.compiled.arrays import part_of
from flexmb.engine.compiled.lanes import LANES
from flexmb.engine.state import flow as state
from flexmb.engine.state.record import ENERGY_LOST, ENERGY_MADE, ENERGY_MISSING, NOT_FINITE, RUNNING
from flexmb.engine.system import work as columns
from flexmb.engine.system.contacts import call_gap, call_normal, jacobians
from flexmb.kernels import GAP_SIZE, compiled, damping_at, energy_at
from flexmb.parts.contact.onset import crossing
from flexmb.places import FRICTION_FORCE, GAP, GAP_RATE, NORMAL, NORMAL_FORCE, TANGENTIAL
from flexmb.program.program import BEGIN, COMMON_Z, END, FOUR_DAMPINGS, LAST_GAP, LAST_GAP_RATE, LOAD_KERNEL

# Work of contact forces in a step: by the contact laws along the path, and by the mean forces of the step

# Distance of the two points of Gauss' rule from the middle of an interval of length 1; exact for cubics.
GAUSS_POINT = 0.5 / 3.0**0.5


@compiled
def contact_losses(tables, address, h, flow, q1, v1, work):
    """Fill work.loss: normal and tangential loss by the laws, dissipation of the method beyond them [J]; memory."""
    # The normal law is evaluated at two points of the cubic path between both states. The method moves with the mean of
    # the forces at both ends; the difference is its dissipation. Friction counts by the mean forces, since a sticking
    # contact is too steep to be evaluated between the states.
    # The memory of a contact is its normal force, and six generalised forces each of normal force and friction.
    K = tables.contacts
    for c in range(K.kernel.shape[0]):
        loss, contact, k = work.loss[c], work.contact[c], state.CONTACT_MEMORY_SIZE * c
        memory = part_of(flow.memory, k, k + state.CONTACT_MEMORY_SIZE)
        N, T = contact[NORMAL_FORCE], contact[FRICTION_FORCE]
        touched = N != 0.0 or T != 0.0
        for i in range(1, state.CONTACT_MEMORY_SIZE):
            touched = touched or memory[i] != 0.0
        for i in range(columns.LOSS_MEMORY + state.CONTACT_MEMORY_SIZE):
            loss[i] = 0.0
        if touched:
            jacobians(contact, work.contact_scratch)
            normal, friction, dofs = 0.0, 0.0, part_of(K.dofs, 6 * c, 6 * c + 6)
            now = part_of(loss, columns.LOSS_MEMORY, columns.LOSS_MEMORY + state.CONTACT_MEMORY_SIZE)
            now[state.MEMORY_NORMAL] = N
            loss[columns.LOSS_IMPULSE] = 0.5 * h * (memory[state.MEMORY_NORMAL] + N)
            for i in range(6):
                way = q1[dofs[i]] - flow.q[dofs[i]]
                now[state.MEMORY_BY_NORMAL + i] = N * work.contact_scratch[NORMAL, i]
                now[state.MEMORY_BY_FRICTION + i] = T * work.contact_scratch[TANGENTIAL, i]
                normal += 0.5 * (memory[state.MEMORY_BY_NORMAL + i] + now[state.MEMORY_BY_NORMAL + i]) * way
                friction += 0.5 * (memory[state.MEMORY_BY_FRICTION + i] + now[state.MEMORY_BY_FRICTION + i]) * way
            if h > 0.0:
                by_law = _loss_by_law(tables, address, c, h, flow, q1, v1, work)
                loss[columns.LOSS_NORMAL], loss[columns.LOSS_FRICTION] = by_law, -friction
                loss[columns.LOSS_BEYOND] = -normal - by_law


@compiled
def _loss_by_law(tables, address, c, h, flow, q1, v1, work):
    """Loss of contact c by its normal law, over the fraction of the step with closed contact [J]."""
    k, contact = tables.contacts.z[c, COMMON_Z], work.contact[c]
    gap0, rate0, gap1, rate1 = flow.z[k + LAST_GAP], flow.z[k + LAST_GAP_RATE], contact[GAP], contact[GAP_RATE]
    begin = crossing(h, gap0, rate0, gap1, rate1) if gap0 > 0.0 >= gap1 else 0.0
    end = crossing(h, -gap0, -rate0, -gap1, -rate1) if gap0 < 0.0 < gap1 else 1.0
    half, loss, gap = 0.5 * (end - begin), 0.0, work.gap
    for point in range(2):
        s = begin + half + (2 * point - 1) * GAUSS_POINT * (end - begin)
        gap_within(tables, address, c, s, h, flow, q1, v1, work)
        N, _, _ = call_normal(tables, address, c, s * h, gap[GAP], gap[GAP_RATE], flow.z, work.z_between)
        loss -= half * h * N * gap[GAP_RATE]
    return loss


@compiled
def gap_within(tables, address, c, s, h, flow, q1, v1, work, a1=None):
    """Set work.gap to that of contact c at fraction s of the cubic path between both states, or quintic with a1."""
    dofs, gap = part_of(tables.contacts.dofs, 6 * c, 6 * c + 6), work.gap
    for i in range(6):
        k = dofs[i]
        rise, d0, d1 = q1[k] - flow.q[k], h * flow.v[k], h * v1[k]
        c2, c3 = 3.0 * rise - 2.0 * d0 - d1, d0 + d1 - 2.0 * rise
        work.ql[i] = flow.q[k] + s * (d0 + s * (c2 + s * c3))
        work.vl[i] = (d0 + s * (2.0 * c2 + 3.0 * s * c3)) / h
        if a1 is not None:
            b0, b1, x = 0.5 * h * h * flow.a[k] - c2, 0.5 * h * h * a1[k] - c2 - 3.0 * c3, s * (1.0 - s)
            b = b0 + s * (b1 - b0)
            work.ql[i] += x * x * b
            work.vl[i] += x * (2.0 * (1.0 - 2.0 * s) * b + x * (b1 - b0)) / h
    for i in range(GAP_SIZE):
        gap[i] = 0.0
    call_gap(tables, address, c, work.ql, work.vl, False, None, gap)


# Balance of energies: stored energies, works of drives and loads, losses in laws and in the method, residual

# Places in the ledger [J], in the order of the energy signals.
# TURNED_OVER is half of the sum of the absolute changes of all other entries, over all steps, with each drive and each
# contact by itself. Half, because energy that goes from one entry to another changes both.
KINETIC, STRAIN, GRAVITY, DRIVE, LOAD, CONTACT, FRICTION, DAMPING, ALGORITHM, RESIDUAL, TURNED_OVER = range(11)
# Numbers of `Flow.memory` for a driven constraint equation: motion [m, rad] and force of the drive [N, N m].
MEMORY_MOTION, MEMORY_DRIVE_FORCE = range(2)
# Numbers of `Flow.memory` for a joint with friction: friction force [N], slip [m/s], energy that it took [J].
MEMORY_FRICTION, MEMORY_SLIP, MEMORY_TAKEN = range(3)
# Largest residual of a good run, relative to the scale of energies (`energy_scale`, `energy_supplied`).
# The balance is of second order, hence coarser than the motion by the method of Runge and Kutta.
RESIDUAL_LIMIT, RESIDUAL_LIMIT_RUNGE_KUTTA = 0.01, 0.05
# Largest energy that the method dissipates or produces in a good run, relative to the scale of energies.
# Produced energy is compared with the supplied energy, too: slow growth without a drive turns over much more.
ALGORITHM_LIMIT = 0.05
# Largest energy that the method dissipates or produces in contacts, relative to the energy through contacts.
CONTACT_LIMIT = 0.02
# Energy through contacts relative to the energy turned over, from which contacts are checked.
LEAST_CONTACT_FRACTION = 0.1
COORDINATE_ROUND_OFF = 1e-14  # round-off of a coordinate relative to its size, as in Newton's iteration
# Damping power of the rates beyond the mean velocity relative to that of the mean, below which it is left out.
LEAST_RATE_POWER = 1e-8
# Change of the kinetic energy of a group of bodies relative to it, up to which it had no part in the motion.
UNCHANGED = 1e-9
LEAST_ENERGY = 1e-290  # energy below which its smallest parts are no numbers of full precision [J]
STEPS_BEFORE_CHECK = 1000  # number of steps before the first check: at first, a soft start has turned over nothing


@compiled
def complete_algorithm_work(n, flow, trial, work):
    """Complete work.power.algorithm, the energy that the method dissipates in a step [J]."""
    # This is the work of inertia by the rule above less the change of kinetic energy:
    # M (a0 + a1)/2 . (q1 - q0) - M (v1 - v0) . (v0 + v1)/2 = mean_v M res + M (v1 - v0) . (mean_v - (v0 + v1)/2)
    # with the residual res of the Newmark relation (`find_newmark_residual`). The evaluation has the first term. The
    # second is small; M (v1 - v0) is taken as the change of M v.
    # Equation (7.2) of docs/theory/energy.md.
    total = work.power.algorithm
    for i in range(n):
        total += (trial.mean_v[i] - 0.5 * (flow.v[i] + trial.v[i])) * (work.momentum[i] - flow.momentum[i])
        flow.momentum[i] = work.momentum[i]
    work.power.algorithm = total


def start_balance(ledger: np.ndarray, balance: state.EnergyBalance) -> None:
    """Start the balance with the energies of the present state."""
    balance.stored_at_start, balance.gravity_at_start = ledger[:3].sum(), ledger[GRAVITY]
    balance.supplied, balance.gravity_change, ledger[RESIDUAL] = abs(ledger[KINETIC]) + abs(ledger[STRAIN]), 0.0, 0.0


@compiled
def update_balance(tables, address, t, h, q0, v0, q1, v1, ledger, balance, memory, work):
    """Update ledger and memory to the state of the last evaluation; with h = 0 the memory alone."""
    kinetic, strain, gravity = work.power.kinetic, work.power.strain, work.power.gravity
    turned = abs(kinetic - ledger[KINETIC]) + abs(strain - ledger[STRAIN]) + abs(gravity - ledger[GRAVITY])
    ledger[KINETIC], ledger[STRAIN], ledger[GRAVITY] = kinetic, strain, gravity
    damped, beyond = _damping_loss(tables, address, t, h, q0, v0, q1, v1, balance, work)
    ledger[DAMPING] += damped
    ledger[ALGORITHM] += work.power.algorithm + beyond
    turned += abs(damped) + _contact_losses(ledger, balance, memory, work)
    k = state.CONTACT_MEMORY_SIZE * work.contact.shape[0]
    brought = _drive_work(tables, h, k, ledger, memory, work)
    k += 2 * work.drive.shape[0]
    turned += _joint_friction_loss(tables, h, k, ledger, memory, work)
    k += 3 * work.joint_friction.shape[0]
    brought += _load_work(tables, h, k, q0, q1, ledger, memory, work)
    turned += brought
    balance.supplied += brought
    balance.gravity_change = max(balance.gravity_change, abs(gravity - balance.gravity_at_start))
    if h > 0.0:
        ledger[TURNED_OVER] += 0.5 * turned
        count_step(tables, q1, balance, work)
    update_residual(ledger, balance)


@compiled
def update_residual(ledger, balance):
    """Residual: change of the stored energy, plus losses, less the works of drives and loads [J]."""
    # Equation (7.4) of docs/theory/energy.md.
    stored = ledger[KINETIC] + ledger[STRAIN] + ledger[GRAVITY]
    lost = ledger[CONTACT] + ledger[FRICTION] + ledger[DAMPING] + ledger[ALGORITHM]
    ledger[RESIDUAL] = stored - balance.stored_at_start + lost - ledger[DRIVE] - ledger[LOAD]


@compiled
def count_step(tables, q, balance, work):
    """Count a step, and add the round-off of its works."""
    balance.steps += 1.0
    # Forces times the largest coordinate, moments times the largest angle [J].
    far_x, far_t, force, moment = 0.0, 1.0, 0.0, 0.0
    for i in range(0, tables.sizes.n_b, 3):  # x, y, theta of a node
        place, Gl = part_of(q, i, i + 3), part_of(work.Gl, i, i + 3)
        far_x, far_t = max(abs(place[0]), abs(place[1]), far_x), max(abs(place[2]), far_t)
        force, moment = force + (abs(Gl[0]) + abs(Gl[1])), moment + abs(Gl[2])
    for c in range(work.contact.shape[0]):
        force += abs(work.loss[c, columns.LOSS_MEMORY + state.MEMORY_NORMAL])
    for i in range(work.load.shape[0]):
        force += abs(work.load[i])
    balance.round_off += COORDINATE_ROUND_OFF * (force * far_x + moment * far_t)


@compiled
def _contact_losses(ledger, balance, memory, work):
    """Losses by the contact laws; the work of the mean forces beyond them counts as dissipation of the method."""
    turned = 0.0
    for c in range(work.contact.shape[0]):
        loss = work.loss[c]
        normal, friction, beyond = loss[columns.LOSS_NORMAL], loss[columns.LOSS_FRICTION], loss[columns.LOSS_BEYOND]
        ledger[CONTACT] += normal
        ledger[FRICTION] += friction
        ledger[ALGORITHM] += beyond
        turned += abs(normal) + abs(friction)
        balance.lost_in_contacts += beyond
        balance.supplied += max(-friction, 0.0)  # a belt
        k = state.CONTACT_MEMORY_SIZE * c
        for i in range(state.CONTACT_MEMORY_SIZE):
            memory[k + i] = loss[columns.LOSS_MEMORY + i]
    balance.through_contacts += turned
    return turned


@compiled
def _drive_work(tables, h, k, ledger, memory, work):
    """Work of the drives on their prescribed motions [J]."""
    turned = 0.0
    for row in range(work.drive.shape[0]):
        if tables.constraints.motion[row] >= 0:
            s, force = work.drive[row, columns.MOTION], work.drive[row, columns.DRIVE_FORCE]
            if h > 0.0:
                gain = 0.5 * (memory[k + MEMORY_DRIVE_FORCE] + force) * (s - memory[k + MEMORY_MOTION])
                ledger[DRIVE] += gain
                turned += abs(gain)
            memory[k + MEMORY_MOTION], memory[k + MEMORY_DRIVE_FORCE] = s, force
        k += 2
    return turned


@compiled
def _joint_friction_loss(tables, h, k, ledger, memory, work):
    """Loss by friction in joints: mean force times mean slip [J]."""
    # A law with a history, as of a clutch, gives back no more energy than it took; what exceeds that is the method's.
    turned, z = 0.0, tables.constraints.joint_friction_z
    for c in range(work.joint_friction.shape[0]):
        if tables.constraints.joint_friction[c, LOAD_KERNEL] >= 0:
            T1, slip = work.joint_friction[c, columns.JOINT_FRICTION_FORCE], work.joint_friction[c, columns.JOINT_SLIP]
            loss = -0.25 * h * (memory[k + MEMORY_FRICTION] + T1) * (memory[k + MEMORY_SLIP] + slip)
            taken = memory[k + MEMORY_TAKEN] + loss
            made = min(taken, 0.0) if z[c, END] > z[c, BEGIN] else 0.0
            memory[k + MEMORY_TAKEN] = taken - made
            ledger[FRICTION] += loss - made
            ledger[ALGORITHM] += made
            turned += abs(loss)
            memory[k + MEMORY_FRICTION], memory[k + MEMORY_SLIP] = T1, slip
        k += 3
    return turned


@compiled
def _load_work(tables, h, k, q0, q1, ledger, memory, work):
    """Work of elements without energies of their own, by the forces in work.load [J]."""
    E = tables.elements
    gain, place = 0.0, 0
    for e in range(E.p.shape[0]):
        if E.energy[e] < 0:
            for i in range(E.dof[e], E.dof[e + 1]):
                dof, force = E.dofs[i], work.load[place]
                if h > 0.0:
                    gain += 0.5 * (memory[k + place] + force) * (q1[dof] - q0[dof])
                memory[k + place] = force
                place += 1
    ledger[LOAD] += gain
    return abs(gain)


@compiled
def _damping_loss(tables, address, t, h, q0, v0, q1, v1, balance, work):
    """Energy that dampers dissipate in a step, and the excess of the rule above, a dissipation of the method [J]."""
    # With the damping D, the mean v of both velocities and w = (q1 - q0)/h, dampers dissipate h v.D v and the rule
    # gives h v.D w, where v.D w = (v.D v + w.D w - b.D b)/2 with b = w - v. Where damping is faster than the steps,
    # accelerations change their directions in each step, and b is all of the motion by the method. The mean of the
    # powers at both ends would count fast vibrations twice.
    before, now = balance.damping_power, work.power.damping
    balance.damping_power = now
    if h == 0.0 or (before == 0.0 and now == 0.0):
        return 0.0, 0.0
    E, took, beyond, rate, done = tables.elements, 0.0, 0.0, 1.0 / h, 0
    for e in range(E.p.shape[0]):
        if E.energy[e] < 0 or e < done or E.mass[e] > 0:
            continue
        four, own = E.fours[e, FOUR_DAMPINGS], E.dof[e + 1] - E.dof[e]
        lanes = LANES if four >= 0 else 1
        n, last, done = own * lanes, e + lanes - 1, e + lanes
        dofs = part_of(E.dofs, E.dof[e], E.dof[done])
        for lane in range(lanes):
            for i in range(own):
                k, place = dofs[lane * own + i], i * lanes + lane
                work.ql[place] = 0.5 * (q0[k] + q1[k]) + 0.125 * h * (v0[k] - v1[k])
                work.vl[place] = 0.5 * (v0[k] + v1[k])
                work.yl[place] = rate * (q1[k] - q0[k]) - work.vl[place]
        if E.damping[e] >= 0:
            p, q = part_of(tables.p, E.p[e, BEGIN], E.p[last, END]), part_of(work.ql, 0, n)
            v, b = part_of(work.vl, 0, n), part_of(work.yl, 0, n)
            along, across = damping_at(address.damping, four if four >= 0 else E.damping[e])(p, t - 0.5 * h, q, v, b)
        else:
            along, across = _powers_by_energies(tables, address, t - 0.5 * h, e, n, work)
        took += along
        beyond += across
    return h * took, h * beyond


@compiled
def _powers_by_energies(tables, address, t, e, n, work):
    """v.D v and v.D b of element e at work.ql, by three powers; v in work.vl, b in work.yl [W]."""
    across = _damping_power(tables, address, t, e, n, work.yl, work)
    for i in range(n):
        work.yl[i] += work.vl[i]
    along = _damping_power(tables, address, t, e, n, work.yl, work)
    own = _damping_power(tables, address, t, e, n, work.vl, work) if across > LEAST_RATE_POWER * along else along
    return own, 0.5 * (along - own - across)


@compiled
def _damping_power(tables, address, t, e, n, v, work):
    """Damping power of element e at work.ql with velocities v [W]."""
    E = tables.elements
    p = part_of(tables.p, E.p[e, BEGIN], E.p[e, END])
    _, _, power = energy_at(address.energy, E.energy[e])(p, t, part_of(work.ql, 0, n), part_of(v, 0, n))
    return power


@compiled
def energy_scale(ledger, balance):
    """Scale of energies [J], to which residuals are relative: energy turned over, kinetic and strain energy."""
    # The potential of gravity has an arbitrary level; it and forces at rest enter by their round-off alone.
    seen = ledger[TURNED_OVER] + abs(ledger[KINETIC]) + abs(ledger[STRAIN]) - (1.0 - UNCHANGED) * balance.idle
    return seen + 1e-6 * abs(ledger[GRAVITY]) + balance.round_off / RESIDUAL_LIMIT + LEAST_ENERGY


@compiled
def energy_supplied(ledger, balance):
    """Supplied energy [J]: kinetic and strain energy at the start, work of gravity, works of drives and loads."""
    given = balance.supplied - (1.0 - UNCHANGED) * balance.idle
    given += balance.gravity_change + 1e-6 * abs(ledger[GRAVITY])
    return given + balance.round_off / RESIDUAL_LIMIT + LEAST_ENERGY


@compiled
def check_balance(ledger, balance):
    """RUNNING if the energies balance, else the code of the violated limit."""
    if not math.isfinite(ledger[RESIDUAL]):
        return NOT_FINITE
    scale, taken = energy_scale(ledger, balance), ledger[ALGORITHM]
    level = min(scale, energy_supplied(ledger, balance))
    if abs(ledger[RESIDUAL]) > balance.residual_limit * level:
        return ENERGY_MISSING
    if taken < -ALGORITHM_LIMIT * level:
        return ENERGY_MADE
    return ENERGY_LOST if taken > ALGORITHM_LIMIT * scale else RUNNING


def idle_energy(bodies: np.ndarray, groups: np.ndarray, before: np.ndarray, after: np.ndarray) -> float:
    """Kinetic energy [J] of groups of connected bodies that keep it, beside a group that does not; 0 without such."""
    # (n,) of each coordinate: number of its body, number of its group, 1/2 v M v at the start and at the end.
    old, new = np.bincount(bodies, before), np.bincount(bodies, after)
    if old[np.abs(new - old) <= UNCHANGED * old].sum() <= LEAST_CONTACT_FRACTION * old.sum():
        return 0.0  # it hides nothing
    old, new = np.bincount(groups, before), np.bincount(groups, after)
    kept = (np.abs(new - old) <= UNCHANGED * old) & (old > 0.0)
    return 0.0 if kept.all() else float(old[kept].sum())


def check_balance_at_end(ledger: np.ndarray, balance: state.EnergyBalance) -> int:
    """Check of the balance at the end of a run, contacts included; within an impact its first step would dominate."""
    code = int(check_balance(ledger, balance))
    through = balance.through_contacts + LEAST_CONTACT_FRACTION * energy_scale(ledger, balance)
    if code != RUNNING or abs(balance.lost_in_contacts) <= CONTACT_LIMIT * through:
        return code
    return ENERGY_LOST if balance.lost_in_contacts > 0.0 else ENERGY_MADE
