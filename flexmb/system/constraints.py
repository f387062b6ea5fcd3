"""Constraints: gather, call, scatter; joint forces."""

from flexmb.kernels import compiled, constraint_at, matrix_view, motion_at
from flexmb.system.elements import gather


@compiled
def add_constraints(tables, address, t, q, v, lam, kq, matrix, work):
    """Fill work.g, gv, gamma and Gl; if `matrix`, put G, G^T and kq H into work.lu."""
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
        force = 0.0
        if place >= 0:
            for i in range(m):
                force -= work.Gflat[i * n + place] * lam[row + i]
        work.joint[c, k] = force
    if C.moment[c] >= 0:
        work.joint[c, 2] = -lam[row + C.moment[c]]
    else:
        work.joint[c, 2] = -lam[row + m - 1]
