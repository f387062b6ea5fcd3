"""Signals at an accepted state (see `flexmb.program.numbering`)."""

import math

from flexmb import places
from flexmb.engine.compiled.arrays import part_of
from flexmb.engine.system import work as columns
from flexmb.engine.system.elements import load_factor, write_control_signals
from flexmb.engine.system.work import gather
from flexmb.kernels import compiled, extremum_at, signal_at
from flexmb.program.program import ADDED, BEGIN, COMMON_Z, END, FIRST, LOAD_KERNEL, MULTIPLIED, SECOND

# Signals of a joint: force on its second body along X and Y, its size, the moment if one is reported.
FX, FY, FORCE, JOINT_MOMENT = range(4)
FRICTION_ALONE = 1  # number of signals of the forces of a coupling with friction, whose other forces are reactions
# Signals of a driven row: coordinate, rate, force, power; their number.
DRIVEN, SPEED, DRIVING, POWER, DRIVE_SIGNALS = range(5)
EX, EY, VEX, VEY, PENETRATION, PENETRATION_RATE = range(6)
# Signals of a contact.
NORMAL_SIGNAL, FRICTION_SIGNAL, CONTACT_FX, CONTACT_FY, CONTACT_FORCE, MODE = range(6, 12)


@compiled
def write_outputs(tables, address, t, q, v, a, work, ledger, peak, exact, y):
    """Write all signals y (n_y,) from the last accepted evaluation."""
    # Unless they shall be `exact`, extrema that are not above their `peak` (n_y,) so far may have any such value.
    n = tables.sizes.n_q
    for i in range(n):
        y[i], y[n + i], y[2 * n + i] = q[i], v[i], a[i]
    _measured(tables, address, t, q, v, a, work, peak, exact, y)
    _constraints(tables, v, work, y)
    _contacts(tables, work, y)
    if tables.controls.kernel.shape[0] > 0:
        write_control_signals(tables, work, work.z_new, y)
    for i in range(ledger.shape[0]):
        y[tables.sizes.energy + i] = ledger[i]


@compiled
def write_extrema(tables, address, t, q, v, a, work, y):
    """Write the exact values of all extrema."""
    S = tables.measured
    for k in range(S.kernel.shape[0]):
        if S.kernel[k] < 0:
            _extremum(tables, address, t, k, _gathered(tables, k, q, v, a, work), -1.0, work, y)


@compiled
def _gathered(tables, k, q, v, a, work):
    """Gather the state that signal k reads into `work`; return its size."""
    S = tables.measured
    m = S.dof[k + 1] - S.dof[k]
    gather(q, S.dofs, S.dof[k], m, work.ql)
    gather(v, S.dofs, S.dof[k], m, work.vl)
    gather(a, S.dofs, S.dof[k], m, work.al)
    return m


@compiled
def _extremum(tables, address, t, k, m, least, work, y):
    """Value of the extremum k, and the number of its place."""
    S = tables.measured
    p, out = part_of(tables.p, S.p[k, BEGIN], S.p[k, END]), S.out[k]
    ql, vl, al = part_of(work.ql, 0, m), part_of(work.vl, 0, m), part_of(work.al, 0, m)
    y[out], y[out + 1] = extremum_at(address.extremum, S.extremum[k])(p, t, ql, vl, al, least)


@compiled
def _measured(tables, address, t, q, v, a, work, peak, exact, y):
    S = tables.measured
    for k in range(S.angle.shape[0]):
        first, second, out = S.angle[k, FIRST], S.angle[k, SECOND], S.angle_out[k]
        y[out], y[out + 1] = q[second] - q[first] - tables.p[S.angle_p[k, BEGIN]], v[second] - v[first]
    for k in range(S.kernel.shape[0]):
        m, out = S.dof[k + 1] - S.dof[k], S.out[k]
        if S.gathers[k] > 0:
            _gathered(tables, k, q, v, a, work)
        if S.kernel[k] < 0:
            _extremum(tables, address, t, k, m, -1.0 if exact else peak[out], work, y)
            continue
        ql, vl, al = part_of(work.ql, 0, m), part_of(work.vl, 0, m), part_of(work.al, 0, m)
        value = signal_at(address.signal, S.kernel[k])(part_of(tables.p, S.p[k, BEGIN], S.p[k, END]), t, ql, vl, al)
        if S.element[k] >= 0:
            s = load_factor(tables, address, S.element[k], t, work)
            own = tables.p[tables.elements.p[S.element[k], BEGIN]] * s
            value = value * s if S.use[k] == MULTIPLIED else (value + own if S.use[k] == ADDED else value - own)
        y[out] = value


@compiled
def _constraints(tables, v, work, y):
    C = tables.constraints
    for c in range(C.kernel.shape[0]):
        k = C.out[c]
        if C.forces[c] > FRICTION_ALONE:
            fx, fy = work.joint[c, columns.FORCE_X], work.joint[c, columns.FORCE_Y]
            y[k + FX], y[k + FY], y[k + FORCE] = fx, fy, math.sqrt(fx * fx + fy * fy)
            if C.moment[c] >= 0:
                y[k + JOINT_MOMENT] = work.joint[c, columns.MOMENT]
        if C.forces[c] > 0 and C.joint_friction[c, LOAD_KERNEL] >= 0:
            last = C.forces[c] - 1
            y[k + last] = tables.p[C.joint_friction_arm[c]] * work.joint_friction[c, columns.JOINT_FRICTION_FORCE]
        k += C.forces[c]
        for row in range(C.row[c], C.row[c + 1]):
            if C.motion[row] >= 0:
                speed, force = work.drive[row, columns.MOTION_RATE], work.drive[row, columns.DRIVE_FORCE]
                y[k + DRIVEN], y[k + SPEED] = work.drive[row, columns.MOTION], speed
                y[k + DRIVING], y[k + POWER] = force, force * speed
                k += DRIVE_SIGNALS
        for i in range(C.reaction[c], C.reaction[c + 1]):
            y[k] = _reaction(tables.p, C, c, i, v, work, y)
            k += 1


@compiled
def _reaction(p, C, c, i, v, work, y):
    """Reaction i of constraint c: of a row, or on coordinates; or its power."""
    if C.reaction_on[i] == C.reaction_on[i + 1]:
        force = p[C.reaction_factor[i]] * work.drive[C.reaction_row[i], columns.DRIVE_FORCE]
        if C.reaction_dof[i] >= 0:
            force *= v[C.reaction_dof[i]]
        if C.reaction_rate[i] >= 0:  # a signal of a kernel, written before
            force *= y[C.reaction_rate[i]]
        return force
    total, n = 0.0, C.dof[c + 1] - C.dof[c]
    for k in range(C.reaction_on[i], C.reaction_on[i + 1]):
        place, force = C.reaction_places[k], 0.0
        for row in range(C.row[c], C.row[c + 1]):
            force += work.G[C.pos_g[c] + (row - C.row[c]) * n + place] * work.drive[row, columns.DRIVE_FORCE]
        total += force * v[C.dofs[C.dof[c] + place]] if C.reaction_power[i] > 0 else force
    return total


@compiled
def _contacts(tables, work, y):
    K = tables.contacts
    for c in range(K.kernel.shape[0]):
        k, contact = K.out[c], work.contact[c]
        N, T = contact[places.NORMAL_FORCE], contact[places.FRICTION_FORCE]
        nx, ny = contact[places.NORMAL_X], contact[places.NORMAL_Y]
        y[k + EX], y[k + EY] = contact[places.ECCENTRICITY_X], contact[places.ECCENTRICITY_Y]
        y[k + VEX], y[k + VEY] = contact[places.ECCENTRICITY_RATE_X], contact[places.ECCENTRICITY_RATE_Y]
        y[k + PENETRATION], y[k + PENETRATION_RATE] = -contact[places.GAP], -contact[places.GAP_RATE]
        y[k + NORMAL_SIGNAL], y[k + FRICTION_SIGNAL] = N, T
        fx, fy = -N * nx - T * ny, -N * ny + T * nx  # on the second body
        y[k + CONTACT_FX], y[k + CONTACT_FY], y[k + CONTACT_FORCE] = fx, fy, math.sqrt(fx * fx + fy * fy)
        phase = work.z_new[K.z[c, COMMON_Z]]
        y[k + MODE] = 0.0 if phase == 0.0 else (1.0 if phase < 3.0 else 2.0)
