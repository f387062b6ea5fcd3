"""Constraints: gather, call, scatter; joint forces; friction that depends on them.

With J of the sliding direction (slip = J v), N(lam) and T from the friction law: r = -T J.
"""

from flexmb.kernels import compiled, constraint_at, friction_at, grip_at, matrix_view, motion_at
from flexmb.system.elements import gather


@compiled
def add_constraints(tables, address, t, h, q, v, lam, z, kq, kv, matrix, work):
    """Fill work.g, gv, gamma and Gl; if `matrix`, put G, G^T and kq H into work.lu.  Add friction to work.r."""
    C = tables.constraints
    for c in range(C.kernel.shape[0]):
        n, row = C.dof[c + 1] - C.dof[c], C.row[c]
        m = C.row[c + 1] - row
        gather(q, C.dofs, C.dof[c], n, work.ql)
        gather(v, C.dofs, C.dof[c], n, work.vl)
        _call(tables, address, c, n, m, t, lam, work)
        for i in range(m):
            rate = work.gtl[i]
            for j in range(n):
                k = i * n + j
                slope = work.Gflat[k]
                if slope == 0.0:
                    continue
                rate += slope * work.vl[j]
                work.Gl[C.dofs[C.dof[c] + j]] += slope * lam[row + i]
                if matrix:
                    work.lu[C.positions_g[C.pos_g[c] + k]] += slope
                    work.lu[C.positions_gt[C.pos_g[c] + k]] += slope
            work.g[row + i] = work.gl[i]
            work.gv[row + i] = rate
            work.gamma[row + i] = work.gammal[i]
        if matrix and kq != 0.0:
            for k in range(n * n):
                curvature = work.Kl[k]
                if curvature != 0.0:
                    work.lu[C.positions_h[C.pos_h[c] + k]] += kq * curvature
        _force_on_second(C, c, n, m, lam, work)
        if C.grip[c, 0] >= 0:
            _add_grip(tables, address, c, m, h, z, kq, kv, matrix, work)


@compiled
def _add_grip(tables, address, c, m, h, z, kq, kv, matrix, work):
    """Friction in joint c between two nodes, and its tangents by coordinates, velocities and multipliers."""
    C = tables.constraints
    out, H = work.grip_out, work.grip_curve
    out[:] = 0.0
    H[:, :] = 0.0
    grip_at(address.grip, C.grip[c, 0])(tables.p[C.grip_p[c, 0] : C.grip_p[c, 1]], work.ql[:6], work.laml[:m], out, H)
    slip = 0.0
    for j in range(6):
        slip += out[4 + j] * work.vl[j]
    T, T_slip, T_N = friction_at(address.friction, C.grip[c, 1])(
        tables.p[C.grip_p[c, 2] : C.grip_p[c, 3]],
        h,
        slip,
        out[0],
        z[C.grip_z[c, 0] : C.grip_z[c, 1]],
        work.z_new[C.grip_z[c, 0] : C.grip_z[c, 1]],
    )
    work.grip[c, 0], work.grip[c, 1] = T, slip
    slopes = work.slopes[tables.contacts.kernel.shape[0] + c]
    slopes[0], slopes[1], slopes[2], slopes[3] = T_slip, T_N * out[1], T_N * out[2], T_N * out[3]
    begin = C.dof[c]
    for i in range(6):
        work.r[C.dofs[begin + i]] -= T * out[4 + i]
    if not matrix:
        return
    for j in range(6):
        slip_q = 0.0
        for k in range(6):
            slip_q += H[k, j] * work.vl[k]
        for i in range(6):
            by_q = out[4 + i] * T_slip * slip_q + T * H[i, j]
            by_v = out[4 + i] * T_slip * out[4 + j]
            work.lu[C.positions_h[C.pos_h[c] + 6 * i + j]] -= kq * by_q + kv * by_v
    for k in range(m):
        for i in range(6):
            work.lu[C.positions_gt[C.pos_g[c] + 6 * k + i]] -= out[4 + i] * T_N * out[1 + k]


@compiled
def _call(tables, address, c, n, m, t, lam, work):
    """Call the kernel of constraint c and subtract the motions from their rows."""
    C = tables.constraints
    row = C.row[c]
    for i in range(m):
        work.gl[i], work.gtl[i], work.gammal[i], work.laml[i] = 0.0, 0.0, 0.0, lam[row + i]
    for i in range(m * n):
        work.Gflat[i] = 0.0
    for i in range(n * n):
        work.Kl[i] = 0.0
    constraint_at(address.constraint, C.kernel[c])(
        tables.p[C.p[c, 0] : C.p[c, 1]],
        t,
        work.ql[:n],
        work.vl[:n],
        work.laml[:m],
        work.gl[:m],
        matrix_view(work.Gflat, m, n),
        work.gtl[:m],
        work.gammal[:m],
        matrix_view(work.Kl, n, n),
    )
    for i in range(m):
        k = row + i
        if C.motion[k] < 0:
            continue
        s, s_dot, s_ddot = motion_at(address.motion, C.motion[k])(tables.p[C.motion_p[k, 0] : C.motion_p[k, 1]], t)
        work.gl[i] -= s
        work.gtl[i] -= s_dot
        work.gammal[i] += s_ddot
        work.drive[k, 0], work.drive[k, 1], work.drive[k, 2], work.drive[k, 3] = s, s_dot, s_ddot, -lam[k]


@compiled
def _force_on_second(C, c, n, m, lam, work):
    """Force that the constraint exerts on its second body, and its reported moment or drive force."""
    row = C.row[c]
    for k in range(2):
        place = C.second[c, k]
        for i in range(m):
            work.levers[row + i, k] = work.Gflat[i * n + place] if place >= 0 else 0.0
    _report(C, c, m, lam, work)


@compiled
def renew_forces(tables, lam, work):
    """Forces of joints and drives of multipliers that were corrected after the last evaluation."""
    C = tables.constraints
    for c in range(C.kernel.shape[0]):
        _report(C, c, C.row[c + 1] - C.row[c], lam, work)
    for k in range(lam.shape[0]):
        work.drive[k, 3] = -lam[k]


@compiled
def _report(C, c, m, lam, work):
    """Force on the second body and reported moment of constraint c."""
    row = C.row[c]
    for k in range(2):
        force = 0.0
        for i in range(m):
            force -= work.levers[row + i, k] * lam[row + i]
        work.joint[c, k] = force
    if C.moment[c] >= 0:
        work.joint[c, 2] = -lam[row + C.moment[c]]
    else:
        work.joint[c, 2] = -lam[row + m - 1]
