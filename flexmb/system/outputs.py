"""Signals at an accepted state (see `flexmb.program.signals`)."""

import math

from flexmb.kernels import compiled, signal_at
from flexmb.places import (
    ECCENTRICITY_RATE_X,
    ECCENTRICITY_RATE_Y,
    ECCENTRICITY_X,
    ECCENTRICITY_Y,
    FRICTION_FORCE,
    GAP,
    GAP_RATE,
    NORMAL_FORCE,
    NORMAL_X,
    NORMAL_Y,
)
from flexmb.program.tables import BEGIN, COMMON_Z, END, LOAD_KERNEL
from flexmb.system.controls import write_control_signals
from flexmb.system.gather import gather
from flexmb.system.work import DRIVE_FORCE, FORCE_X, FORCE_Y, JOINT_FRICTION_FORCE, MOMENT, MOTION, MOTION_RATE

FX, FY, FORCE, JOINT_MOMENT = range(4)
"""Signals of a joint: force on its second body along X and Y, its size, the moment if one is reported."""

DRIVEN, SPEED, DRIVING, POWER, DRIVE_SIGNALS = range(5)
"""Signals of a driven row: coordinate, rate, force, power; their number."""

EX, EY, VEX, VEY, PENETRATION, PENETRATION_RATE = range(6)
NORMAL_SIGNAL, FRICTION_SIGNAL, CONTACT_FX, CONTACT_FY, CONTACT_FORCE, MODE = range(6, 12)
"""Signals of a contact."""


@compiled
def write_outputs(tables, address, t, q, v, a, work, ledger, y):
    """Write all signals y (n_y,) from the last accepted evaluation."""
    n = tables.sizes.n_q
    for i in range(n):
        y[i], y[n + i], y[2 * n + i] = q[i], v[i], a[i]
    _constraints(tables, v, work, y)
    _contacts(tables, work, y)
    S = tables.measured
    for k in range(S.kernel.shape[0]):
        m = S.dof[k + 1] - S.dof[k]
        gather(q, S.dofs, S.dof[k], m, work.ql)
        gather(v, S.dofs, S.dof[k], m, work.vl)
        gather(a, S.dofs, S.dof[k], m, work.al)
        y[S.out[k]] = signal_at(address.signal, S.kernel[k])(
            tables.p[S.p[k, BEGIN] : S.p[k, END]], t, work.ql[:m], work.vl[:m], work.al[:m]
        )
    if tables.controls.kernel.shape[0] > 0:
        write_control_signals(tables, work, work.z_new, y)
    for i in range(ledger.shape[0]):
        y[tables.sizes.energy + i] = ledger[i]


@compiled
def _constraints(tables, v, work, y):
    C = tables.constraints
    for c in range(C.kernel.shape[0]):
        k = C.out[c]
        if C.forces[c] > 0:
            fx, fy = work.joint[c, FORCE_X], work.joint[c, FORCE_Y]
            y[k + FX], y[k + FY], y[k + FORCE] = fx, fy, math.sqrt(fx * fx + fy * fy)
            if C.moment[c] >= 0:
                y[k + JOINT_MOMENT] = work.joint[c, MOMENT]
            if C.joint_friction[c, LOAD_KERNEL] >= 0:
                last = C.forces[c] - 1
                y[k + last] = C.joint_friction_arm[c] * work.joint_friction[c, JOINT_FRICTION_FORCE]
        k += C.forces[c]
        for row in range(C.row[c], C.row[c + 1]):
            if C.motion[row] >= 0:
                speed, force = work.drive[row, MOTION_RATE], work.drive[row, DRIVE_FORCE]
                y[k + DRIVEN], y[k + SPEED] = work.drive[row, MOTION], speed
                y[k + DRIVING], y[k + POWER] = force, force * speed
                k += DRIVE_SIGNALS
        for i in range(C.reaction[c], C.reaction[c + 1]):
            force = C.reaction_factor[i] * work.drive[C.reaction_row[i], DRIVE_FORCE]
            y[k] = force if C.reaction_dof[i] < 0 else force * v[C.reaction_dof[i]]
            k += 1


@compiled
def _contacts(tables, work, y):
    K = tables.contacts
    for c in range(K.kernel.shape[0]):
        k = K.out[c]
        N, T = work.contact[c, NORMAL_FORCE], work.contact[c, FRICTION_FORCE]
        nx, ny = work.contact[c, NORMAL_X], work.contact[c, NORMAL_Y]
        y[k + EX], y[k + EY] = work.contact[c, ECCENTRICITY_X], work.contact[c, ECCENTRICITY_Y]
        y[k + VEX], y[k + VEY] = work.contact[c, ECCENTRICITY_RATE_X], work.contact[c, ECCENTRICITY_RATE_Y]
        y[k + PENETRATION], y[k + PENETRATION_RATE] = -work.contact[c, GAP], -work.contact[c, GAP_RATE]
        y[k + NORMAL_SIGNAL], y[k + FRICTION_SIGNAL] = N, T
        fx, fy = -N * nx - T * ny, -N * ny + T * nx  # on the second body
        y[k + CONTACT_FX], y[k + CONTACT_FY], y[k + CONTACT_FORCE] = fx, fy, math.sqrt(fx * fx + fy * fy)
        phase = work.z_new[K.z[c, COMMON_Z]]
        y[k + MODE] = 0.0 if phase == 0.0 else (1.0 if phase < 3.0 else 2.0)
