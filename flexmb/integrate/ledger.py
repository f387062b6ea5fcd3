"""The ledger of energies: what is stored, what drives and loads bring, what laws and algorithm take, what is missing.

A step is looked at along the cubic path p through positions and velocities at its ends.  Kinetic energy, strain and
gravity are exact at every state.  A force f that is known at both ends and taken as linear in between does along p

    int f . p' dt = (f0 + f1)/2 . dq + h/12 (f1 - f0) . dv,      dq = q1 - q0,   dv = v1 - v0.

With this rule for inertia forces, loads and contacts alike, whatever satisfies the equations of motion at both ends
and has a constant mass adds up to round-off, for any relation between q, v and a.  See docs/design.md for what is left.
"""

import math

from flexmb.integrate.arrays import (
    CONTACT_MEMORY,
    ENERGY_LOST,
    ENERGY_MADE,
    ENERGY_MISSING,
    MEMORY_HEAD,
    NOT_FINITE,
    RUNNING,
)
from flexmb.kernels import compiled, energy_at

KINETIC, STRAIN, GRAVITY, DRIVE, LOAD, CONTACT, FRICTION, DAMPING, ALGORITHM, RESIDUAL, TURNED = range(11)
"""Places in the ledger, in the order of the signals.  TURNED is half of the sum of all changes of all other accounts
(each drive and contact for itself), steps taken one by one and without signs: what goes from one to another is counted
in both."""

START, DAMPING_POWER, STEPS, THROUGH_CONTACTS, LOST_IN_CONTACTS = range(5)
"""Places in the memory of the ledger: stored energy at the start [J], power of damping [W], steps so far, energy that
went through contacts [J], the part of ALGORITHM that is due to contacts [J]."""

MISSING = 0.01
"""Largest residual, as part of the energy turned over or in motion, of a run that is ok."""

TAKEN = 0.05
"""Largest energy that the algorithm takes or makes, as part of the same, of a run that is ok."""

IN_CONTACTS = 0.05
"""Largest energy that it takes or makes in contacts, as part of what went through them, of a run that is ok."""

SETTLED = 100
"""Steps before the first verdict in the loop: in the first ones of a soft start nothing has been turned over yet."""


@compiled
def lag_of_step(n, h, flow, trial, work):
    """Vectors x1, y1, x2, y2 with which x1 M y1 + x2 M y2 is the work of inertia that the algorithm makes up.

    That is the work of the linear M a along the path, less the kinetic energy that it stands for:
    M (a0 + a1)/2 . dq + h/12 M (a1 - a0) . dv - M dv . (v0 + v1)/2.
    """
    for i in range(n):
        dv = trial.v[i] - flow.v[i]
        trial.mean_v[i] = (trial.q[i] - flow.q[i]) / h
        trial.lag[i] = 0.5 * h * (flow.a[i] + trial.a[i]) - dv
        work.change[i] = dv
        work.bow[i] = trial.mean_v[i] - 0.5 * (flow.v[i] + trial.v[i]) + h / 12.0 * (trial.a[i] - flow.a[i])


@compiled
def keep_account(tables, address, t, h, q0, v0, q1, v1, ledger, memory, work):
    """Bring the ledger to the state of the last evaluation; with h = 0 only remember the powers and forces there."""
    kinetic, strain, gravity = work.power[0], work.power[1], work.power[2]
    turned = abs(kinetic - ledger[KINETIC]) + abs(strain - ledger[STRAIN]) + abs(gravity - ledger[GRAVITY])
    ledger[KINETIC], ledger[STRAIN], ledger[GRAVITY] = kinetic, strain, gravity
    damped = _damped(tables, address, t, h, q0, v0, q1, v1, memory, work)
    ledger[DAMPING] += damped
    ledger[ALGORITHM] += work.power[5]
    turned += abs(damped) + _contacts(h, ledger, memory, work)
    k = MEMORY_HEAD + CONTACT_MEMORY * work.contact.shape[0]
    turned += _drives(tables, h, k, ledger, memory, work)
    k += 3 * work.drive.shape[0]
    turned += _joint_friction(tables, h, k, ledger, memory, work)
    k += 2 * work.grip.shape[0]
    turned += _loads(tables, h, k, q0, v0, q1, v1, ledger, memory, work)
    stored = kinetic + strain + gravity
    if h > 0.0:
        ledger[TURNED] += 0.5 * turned
        memory[STEPS] += 1.0
    lost = ledger[CONTACT] + ledger[FRICTION] + ledger[DAMPING] + ledger[ALGORITHM]
    ledger[RESIDUAL] = stored - memory[START] + lost - ledger[DRIVE] - ledger[LOAD]


@compiled
def _contacts(h, ledger, memory, work):
    """Losses by the laws along the path; what the linear forces took beyond them goes to the algorithm."""
    turned = 0.0
    for c in range(work.contact.shape[0]):
        normal, friction, beyond = work.loss[c, 0], work.loss[c, 1], work.loss[c, 2]
        ledger[CONTACT] += normal
        ledger[FRICTION] += friction
        ledger[ALGORITHM] += beyond
        turned += abs(normal) + abs(friction)
        memory[LOST_IN_CONTACTS] += beyond
        k = MEMORY_HEAD + CONTACT_MEMORY * c
        for i in range(CONTACT_MEMORY):
            memory[k + i] = work.loss[c, 3 + i]
    memory[THROUGH_CONTACTS] += turned
    return turned


@compiled
def _drives(tables, h, k, ledger, memory, work):
    """Work of the drives, each on its own motion."""
    turned = 0.0
    for row in range(work.drive.shape[0]):
        if tables.constraints.motion[row] >= 0:
            s, rate, force = work.drive[row, 0], work.drive[row, 1], work.drive[row, 3]
            if h > 0.0:
                gain = 0.5 * (memory[k + 2] + force) * (s - memory[k])
                gain += h / 12.0 * (force - memory[k + 2]) * (rate - memory[k + 1])
                ledger[DRIVE] += gain
                turned += abs(gain)
            memory[k], memory[k + 1], memory[k + 2] = s, rate, force
        k += 3
    return turned


@compiled
def _joint_friction(tables, h, k, ledger, memory, work):
    """Friction in joints, force and slip linear in the step."""
    turned = 0.0
    for c in range(work.grip.shape[0]):
        if tables.constraints.grip[c, 0] >= 0:
            T0, s0, T1, s1 = memory[k], memory[k + 1], work.grip[c, 0], work.grip[c, 1]
            loss = -h / 6.0 * (2.0 * (T0 * s0 + T1 * s1) + T0 * s1 + T1 * s0)
            ledger[FRICTION] += loss
            turned += abs(loss)
            memory[k], memory[k + 1] = T1, s1
        k += 2
    return turned


@compiled
def _loads(tables, h, k, q0, v0, q1, v1, ledger, memory, work):
    """Work of elements without an account of their own: of the forces in work.load."""
    E = tables.elements
    gain, place = 0.0, 0
    for e in range(E.kernel.shape[0]):
        if E.energy[e] < 0:
            for i in range(E.dof[e], E.dof[e + 1]):
                dof, force = E.dofs[i], work.load[place]
                if h > 0.0:
                    gain += 0.5 * (memory[k + place] + force) * (q1[dof] - q0[dof])
                    gain += h / 12.0 * (force - memory[k + place]) * (v1[dof] - v0[dof])
                memory[k + place] = force
                place += 1
    ledger[LOAD] += gain
    return abs(gain)


@compiled
def _damped(tables, address, t, h, q0, v0, q1, v1, memory, work):
    """Energy that damping took, by Simpson's rule: for a linear damper that of the linear forces, exactly."""
    before, now = memory[DAMPING_POWER], work.power[3]
    memory[DAMPING_POWER] = now
    if h == 0.0 or (before == 0.0 and now == 0.0):
        return 0.0
    E, middle = tables.elements, 0.0
    for e in range(E.kernel.shape[0]):
        if E.energy[e] < 0:
            continue
        n = E.dof[e + 1] - E.dof[e]
        for i in range(n):
            k = E.dofs[E.dof[e] + i]
            work.ql[i] = 0.5 * (q0[k] + q1[k]) + 0.125 * h * (v0[k] - v1[k])
            work.vl[i] = 1.5 * (q1[k] - q0[k]) / h - 0.25 * (v0[k] + v1[k])
        _, _, power = energy_at(address.energy, E.energy[e])(
            tables.p[E.p[e, 0] : E.p[e, 1]], t - 0.5 * h, work.ql[:n], work.vl[:n]
        )
        middle += power
    return h / 6.0 * (before + 4.0 * middle + now)


@compiled
def turned_over(ledger):
    """What residuals are measured against [J]: energy turned over and in motion; of heights only their round-off."""
    return ledger[TURNED] + abs(ledger[KINETIC]) + abs(ledger[STRAIN]) + 1e-6 * abs(ledger[GRAVITY])


@compiled
def verdict(ledger, memory):
    """RUNNING when the energies add up, else the code of what they say."""
    if not math.isfinite(ledger[RESIDUAL]):
        return NOT_FINITE
    scale, taken = turned_over(ledger), ledger[ALGORITHM]
    in_contacts, through = memory[LOST_IN_CONTACTS], memory[THROUGH_CONTACTS]
    if abs(ledger[RESIDUAL]) > MISSING * scale:
        return ENERGY_MISSING
    if taken < -TAKEN * scale or in_contacts < -IN_CONTACTS * through:
        return ENERGY_MADE
    if taken > TAKEN * scale or in_contacts > IN_CONTACTS * through:
        return ENERGY_LOST
    return RUNNING
