"""The vector of signals at an accepted state (see `flexmb.program.signals`)."""

import math

from flexmb.kernels import GAP_SIZE, compiled, signal_at
from flexmb.system.elements import gather


@compiled
def write_outputs(tables, address, t, q, v, a, work, ledger, y):
    """y : (n_y,) all signals, from the last accepted evaluation."""
    n = tables.sizes.n_q
    for i in range(n):
        y[i], y[n + i], y[2 * n + i] = q[i], v[i], a[i]
    _constraints(tables, work, y)
    _contacts(tables, work, y)
    S = tables.measured
    for k in range(S.kernel.shape[0]):
        m = S.dof[k + 1] - S.dof[k]
        gather(q, S.dofs, S.dof[k], m, work.ql)
        gather(v, S.dofs, S.dof[k], m, work.vl)
        gather(a, S.dofs, S.dof[k], m, work.al)
        y[S.out[k]] = signal_at(address.signal, S.kernel[k])(
            tables.p[S.p[k, 0] : S.p[k, 1]], t, work.ql[:m], work.vl[:m], work.al[:m]
        )
    for i in range(ledger.shape[0]):
        y[tables.sizes.energy + i] = ledger[i]


@compiled
def _constraints(tables, work, y):
    C = tables.constraints
    for c in range(C.kernel.shape[0]):
        k = C.out[c]
        if C.forces[c] > 0:
            fx, fy = work.joint[c, 0], work.joint[c, 1]
            y[k], y[k + 1], y[k + 2] = fx, fy, math.sqrt(fx * fx + fy * fy)
            if C.moment[c] >= 0:
                y[k + 3] = work.joint[c, 2]
            if C.grip[c, 0] >= 0:
                y[k + C.forces[c] - 1] = C.grip_arm[c] * work.grip[c, 0]
        k += C.forces[c]
        for row in range(C.row[c], C.row[c + 1]):
            if C.motion[row] >= 0:
                speed, force = work.drive[row, 1], work.drive[row, 3]
                y[k], y[k + 1], y[k + 2], y[k + 3] = work.drive[row, 0], speed, force, force * speed
                k += 4


@compiled
def _contacts(tables, work, y):
    K = tables.contacts
    for c in range(K.kernel.shape[0]):
        k = K.out[c]
        N, T = work.contact[c, GAP_SIZE], work.contact[c, GAP_SIZE + 1]
        nx, ny = work.contact[c, 3], work.contact[c, 4]
        for i in range(4):
            y[k + i] = work.contact[c, 9 + i]
        y[k + 4], y[k + 5] = -work.contact[c, 0], -work.contact[c, 1]
        y[k + 6], y[k + 7] = N, T
        fx, fy = -N * nx - T * ny, -N * ny + T * nx  # on the second body
        y[k + 8], y[k + 9], y[k + 10] = fx, fy, math.sqrt(fx * fx + fy * fy)
        phase = work.z_new[K.z[c, 0]]
        y[k + 11] = 0.0 if phase == 0.0 else (1.0 if phase < 3.0 else 2.0)
