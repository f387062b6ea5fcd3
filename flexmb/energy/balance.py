"""The ledger of energies: what is stored, what drives and loads bring, what laws and algorithm take, what is missing.

Kinetic energy, strain and gravity are exact at every state.  A force f that is known at both ends of a step does

    W = (f0 + f1)/2 . (q1 - q0),

which is exact for potentials of second degree.  With this rule for inertia forces, loads, drives and contacts alike,
whatever satisfies the equations of motion at both ends and has a constant mass adds up to round-off, for any relation
between q, v and a.  See docs/design.md for what is left.
"""

import math

from flexmb.kernels import compiled, energy_at, part_of
from flexmb.program.tables import BEGIN, END, GRIP_LAW
from flexmb.state.flow import CONTACT_MEMORY, PRESSED
from flexmb.state.record import ENERGY_LOST, ENERGY_MADE, ENERGY_MISSING, NOT_FINITE, RUNNING
from flexmb.system.work import (
    DRIVE_FORCE,
    GRIP_FORCE,
    GRIP_SLIP,
    LOSS_BEYOND,
    LOSS_FRICTION,
    LOSS_MEMORY,
    LOSS_NORMAL,
    MOTION,
)

KINETIC, STRAIN, GRAVITY, DRIVE, LOAD, CONTACT, FRICTION, DAMPING, ALGORITHM, RESIDUAL, TURNED = range(11)
"""Places in the ledger, in the order of the signals.  TURNED is half of the sum of all changes of all other accounts
(each drive and contact for itself), steps taken one by one and without signs: what goes from one to another is counted
in both."""

MOVED, PUSHED = range(2)
"""What the memory holds of a driven row: its motion and the force that drives it."""

RUBBED, SLID = range(2)
"""What it holds of a joint: friction force and slip."""

MISSING, MISSING_IN_RUNGE_KUTTA = 0.01, 0.05
"""Largest residual, as part of the energy turned over or in motion or of all that was put in, of a run that is ok.
The account is of second order, so it is coarser than the motion that Runge and Kutta's method finds."""

TAKEN = 0.05
"""Largest energy that the algorithm takes or makes, as part of the same, of a run that is ok; and largest energy that
it makes as part of all that was put in: slow growth of what nothing drives turns over much more than it makes."""

IN_CONTACTS = 0.02
"""Largest energy that it takes or makes in contacts, as part of what went through them, of a run that is ok."""

FEW = 0.1
"""Contacts are judged from this part of what was turned over on: the first step of an impact says little."""

PART = 1e-14
"""Round-off of a coordinate as part of its size, that to which Newton's iterations go."""

SMALL = 1e-8
"""Part of the power of dampers below which the rates by which a step differs from its mean velocity do not count."""

SETTLED = 1000
"""Steps before the first verdict in the loop: in the first ones of a soft start nothing has been turned over yet."""


@compiled
def work_of_bow(n, flow, trial, work):
    """Complete the work of inertia that the algorithm makes up.

    That is the work of M a by the rule above, less the kinetic energy that it stands for:

    M (a0 + a1)/2 . (q1 - q0) - M (v1 - v0) . (v0 + v1)/2 = mean_v M lag + M (v1 - v0) . (mean_v - (v0 + v1)/2).

    The first term is there (`predict.compare`).  The second is small; M (v1 - v0) is taken as the change of M v.
    """
    for i in range(n):
        bow = trial.mean_v[i] - 0.5 * (flow.v[i] + trial.v[i])
        work.power.algorithm += bow * (work.momentum[i] - flow.momentum[i])
        flow.momentum[i] = work.momentum[i]


def open_account(ledger, account):
    """Begin the account with the energies of the present state."""
    account.start, account.level = ledger[:3].sum(), ledger[GRAVITY]
    account.put_in, account.fallen, ledger[RESIDUAL] = abs(ledger[KINETIC]) + abs(ledger[STRAIN]), 0.0, 0.0


@compiled
def keep_account(tables, address, t, h, q0, v0, q1, v1, ledger, account, memory, work):
    """Bring the ledger to the state of the last evaluation; with h = 0 only remember the powers and forces there."""
    kinetic, strain, gravity = work.power.kinetic, work.power.strain, work.power.gravity
    turned = abs(kinetic - ledger[KINETIC]) + abs(strain - ledger[STRAIN]) + abs(gravity - ledger[GRAVITY])
    ledger[KINETIC], ledger[STRAIN], ledger[GRAVITY] = kinetic, strain, gravity
    damped, beyond = _damped(tables, address, t, h, q0, v0, q1, v1, account, work)
    ledger[DAMPING] += damped
    ledger[ALGORITHM] += work.power.algorithm + beyond
    turned += abs(damped) + _contacts(ledger, account, memory, work)
    k = CONTACT_MEMORY * work.contact.shape[0]
    brought = _drives(tables, h, k, ledger, memory, work)
    k += 2 * work.drive.shape[0]
    turned += _joint_friction(tables, h, k, ledger, memory, work)
    k += 2 * work.grip.shape[0]
    brought += _loads(tables, h, k, q0, q1, ledger, memory, work)
    turned += brought
    account.put_in += brought
    account.fallen = max(account.fallen, abs(gravity - account.level))
    if h > 0.0:
        ledger[TURNED] += 0.5 * turned
        note_step(tables, q1, account, work)
    balance(ledger, account)


@compiled
def balance(ledger, account):
    """What is missing: energy that is stored now and was at the start, losses, and what was brought."""
    stored = ledger[KINETIC] + ledger[STRAIN] + ledger[GRAVITY]
    lost = ledger[CONTACT] + ledger[FRICTION] + ledger[DAMPING] + ledger[ALGORITHM]
    ledger[RESIDUAL] = stored - account.start + lost - ledger[DRIVE] - ledger[LOAD]


@compiled
def note_step(tables, q, account, work):
    """Count a step, and the round-off of its works."""
    account.steps += 1.0
    account.round_off += PART * _forces_times_size(tables, q, work)


@compiled
def _contacts(ledger, account, memory, work):
    """Losses by the laws along the path; what the linear forces took beyond them goes to the algorithm."""
    turned = 0.0
    for c in range(work.contact.shape[0]):
        loss = work.loss[c]
        normal, friction, beyond = loss[LOSS_NORMAL], loss[LOSS_FRICTION], loss[LOSS_BEYOND]
        ledger[CONTACT] += normal
        ledger[FRICTION] += friction
        ledger[ALGORITHM] += beyond
        turned += abs(normal) + abs(friction)
        account.lost_in_contacts += beyond
        account.put_in += max(-friction, 0.0)  # a belt
        k = CONTACT_MEMORY * c
        for i in range(CONTACT_MEMORY):
            memory[k + i] = loss[LOSS_MEMORY + i]
    account.through_contacts += turned
    return turned


@compiled
def _drives(tables, h, k, ledger, memory, work):
    """Work of the drives, each on its own motion."""
    turned = 0.0
    for row in range(work.drive.shape[0]):
        if tables.constraints.motion[row] >= 0:
            s, force = work.drive[row, MOTION], work.drive[row, DRIVE_FORCE]
            if h > 0.0:
                gain = 0.5 * (memory[k + PUSHED] + force) * (s - memory[k + MOVED])
                ledger[DRIVE] += gain
                turned += abs(gain)
            memory[k + MOVED], memory[k + PUSHED] = s, force
        k += 2
    return turned


@compiled
def _joint_friction(tables, h, k, ledger, memory, work):
    """Friction in joints: mean force times mean slip."""
    turned = 0.0
    for c in range(work.grip.shape[0]):
        if tables.constraints.grip[c, GRIP_LAW] >= 0:
            T1, slip = work.grip[c, GRIP_FORCE], work.grip[c, GRIP_SLIP]
            loss = -0.25 * h * (memory[k + RUBBED] + T1) * (memory[k + SLID] + slip)
            ledger[FRICTION] += loss
            turned += abs(loss)
            memory[k + RUBBED], memory[k + SLID] = T1, slip
        k += 2
    return turned


@compiled
def _loads(tables, h, k, q0, q1, ledger, memory, work):
    """Work of elements without an account of their own: of the forces in work.load."""
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
def _damped(tables, address, t, h, q0, v0, q1, v1, account, work):
    """Energy that damping took, and what the rule above takes beyond that, which goes to the algorithm.

    With D the damping, v the mean of both velocities and w the mean rate, dampers take h v.D v and the rule h v.D w,
    where v.D w = (v.D v + w.D w - b.D b)/2 with b = w - v.  Where damping is faster than the steps, accelerations turn
    back each time, and b is all that the algorithm moves.  The mean of the powers at both ends would count fast
    vibrations twice.
    """
    before, now = account.damping_power, work.power.damping
    account.damping_power = now
    if h == 0.0 or (before == 0.0 and now == 0.0):
        return 0.0, 0.0
    E, took, beyond = tables.elements, 0.0, 0.0
    for e in range(E.p.shape[0]):
        if E.energy[e] < 0:
            continue
        n = E.dof[e + 1] - E.dof[e]
        for i in range(n):
            k = E.dofs[E.dof[e] + i]
            work.ql[i] = 0.5 * (q0[k] + q1[k]) + 0.125 * h * (v0[k] - v1[k])
        along = _power(tables, address, t - 0.5 * h, e, 1.0 / h, 0.0, q0, v0, q1, v1, work)
        across = _power(tables, address, t - 0.5 * h, e, 1.0 / h, 0.5, q0, v0, q1, v1, work)
        own = along
        if across > SMALL * along:
            own = _power(tables, address, t - 0.5 * h, e, 0.0, -0.5, q0, v0, q1, v1, work)
        took += own
        beyond += 0.5 * (along - own - across)
    return h * took, h * beyond


@compiled
def _power(tables, address, t, e, way, less, q0, v0, q1, v1, work):
    """Power of the damping of element e at rates way (q1 - q0) - less (v0 + v1), where `work.ql` says."""
    E = tables.elements
    n = E.dof[e + 1] - E.dof[e]
    for i in range(n):
        k = E.dofs[E.dof[e] + i]
        work.vl[i] = way * (q1[k] - q0[k]) - less * (v0[k] + v1[k])
    _, _, power = energy_at(address.energy, E.energy[e])(
        tables.p[E.p[e, BEGIN] : E.p[e, END]], t, work.ql[:n], work.vl[:n]
    )
    return power


@compiled
def _forces_times_size(tables, q, work):
    """Forces of joints, contacts and loads times the largest coordinate, moments times the largest angle [J]."""
    far_x, far_t, force, moment = 0.0, 1.0, 0.0, 0.0
    for i in range(0, tables.sizes.n_q, 3):  # x, y, theta of a node
        place, Gl = part_of(q, i, i + 3), part_of(work.Gl, i, i + 3)
        far_x, far_t = max(abs(place[0]), abs(place[1]), far_x), max(abs(place[2]), far_t)
        force, moment = force + (abs(Gl[0]) + abs(Gl[1])), moment + abs(Gl[2])
    for c in range(work.contact.shape[0]):
        force += abs(work.loss[c, LOSS_MEMORY + PRESSED])
    for i in range(work.load.shape[0]):
        force += abs(work.load[i])
    return force * far_x + moment * far_t


@compiled
def turned_over(ledger, account):
    """What residuals are measured against [J]: energy turned over, in motion and in strain.

    Of heights, which count from an arbitrary level, and of forces at rest only what round-off makes of them.
    """
    seen = ledger[TURNED] + abs(ledger[KINETIC]) + abs(ledger[STRAIN])
    return seen + 1e-6 * abs(ledger[GRAVITY]) + account.round_off / MISSING


@compiled
def put_in(ledger, account):
    """All energy that there was [J]: at the start in motion and strain, from heights, by drives and loads."""
    return account.put_in + account.fallen + 1e-6 * abs(ledger[GRAVITY]) + account.round_off / MISSING


@compiled
def verdict(ledger, account):
    """RUNNING when the energies add up, else the code of what they say."""
    if not math.isfinite(ledger[RESIDUAL]):
        return NOT_FINITE
    scale, taken = turned_over(ledger, account), ledger[ALGORITHM]
    level = min(scale, put_in(ledger, account))
    if abs(ledger[RESIDUAL]) > account.limit * level:
        return ENERGY_MISSING
    if taken < -TAKEN * level:
        return ENERGY_MADE
    if taken > TAKEN * scale:
        return ENERGY_LOST
    return RUNNING


def final_verdict(ledger, account):
    """The verdict at the end, on contacts too: within an impact its first step would weigh too much."""
    code = verdict(ledger, account)
    through = account.through_contacts + FEW * turned_over(ledger, account)
    if code != RUNNING or abs(account.lost_in_contacts) <= IN_CONTACTS * through:
        return code
    return ENERGY_LOST if account.lost_in_contacts > 0.0 else ENERGY_MADE
