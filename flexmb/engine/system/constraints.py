"""Evaluation of constraints: residuals, Jacobian G, constraint forces, friction in joints.

With the direction J of sliding (slip = J v), N(lam) and T of the friction law: r = -T J.
Equations (1.1), (1.2) and (1.7) of docs/theory/equations_of_motion.md.
"""

from flexmb.engine.compiled.arrays import matrix_view, part_of
from flexmb.engine.system import work as columns
from flexmb.engine.system.work import turns_at
from flexmb.kernels import compiled, constraint_at, friction_at, joint_friction_at, motion_at
from flexmb.parts.joints.contact_point import difference, slide
from flexmb.places import ANGLE, GUIDE, LOAD, LOAD_BY_LAM, LOAD_BY_Q, PIN, SLIDING
from flexmb.program.program import BEGIN, END, LOAD_KERNEL, LOAD_P, LOAD_P_END, SLIDING_LAW, SLIDING_P, SLIDING_P_END


@compiled
def add_constraints(tables, address, t, h, q, v, lam, z, kq, kv, matrix, work):
    """Fill work.g, gv, gamma, Gl and G; if `matrix`, put G, G^T and kq H into work.lu.  Add friction to work.r."""
    # `turn_nodes` has been called at q. Entries of G that the loops know to be 0 are so from the beginning.
    C = tables.constraints
    for c in range(C.kernel.shape[0]):
        if C.known[c] == PIN:
            add_pin(tables, c, q, v, lam, kq, matrix, work)
            continue
        n, m = C.dof[c + 1] - C.dof[c], C.row[c + 1] - C.row[c]
        dofs = part_of(C.dofs, C.dof[c], C.dof[c + 1])
        for i in range(n):
            dof = dofs[i]
            work.ql[i], work.vl[i] = q[dof], v[dof]
        entries = part_of(C.entries_h, C.pos_h[c], C.pos_h[c + 1])
        if matrix:
            for k in range(entries.shape[0]):
                work.Kl[entries[k]] = 0.0
        call_constraint(tables, address, c, n, m, t, lam, work)
        if n == 6 and m == 2:  # a joint of two nodes: numbers that are known let the compiler unroll
            _scatter(C, c, 6, 2, lam, kq, matrix, work)
        elif n == 2 and m == 1:
            _scatter(C, c, 2, 1, lam, kq, matrix, work)
        else:
            _scatter(C, c, n, m, lam, kq, matrix, work)
        if C.joint_friction[c, LOAD_KERNEL] >= 0:
            add_joint_friction(tables, address, c, n, m, h, lam, z, kq, kv, matrix, work)


@compiled
def add_pin(tables, c, q, v, lam, kq, matrix, work):
    """`add_constraints` of a joint that holds two points of two nodes together."""
    # Equations (1.4) and (1.5) of docs/theory/equations_of_motion.md.
    C, Gl = tables.constraints, work.Gl
    x1, y1, turn1, x2, y2, turn2 = part_of(C.dofs, C.dof[c], C.dof[c + 1])
    s1x, s1y, s2x, s2y = part_of(tables.p, C.p[c, BEGIN], C.p[c, END])
    c1, d1, c2, d2 = turns_at(part_of(C.dofs, C.dof[c], C.dof[c + 1]), work)
    ax, ay, bx, by = c1 * s1x - d1 * s1y, d1 * s1x + c1 * s1y, c2 * s2x - d2 * s2y, d2 * s2x + c2 * s2y
    w1, w2, row, begin = v[turn1], v[turn2], C.row[c], C.pos_g[c]
    fx, fy = lam[row], lam[row + 1]
    work.g[row], work.g[row + 1] = q[x2] + bx - q[x1] - ax, q[y2] + by - q[y1] - ay
    work.gv[row], work.gv[row + 1] = -v[x1] + ay * w1 + v[x2] - by * w2, -v[y1] - ax * w1 + v[y2] + bx * w2
    work.gamma[row], work.gamma[row + 1] = bx * (w2 * w2) - ax * (w1 * w1), by * (w2 * w2) - ay * (w1 * w1)
    Gl[x1], Gl[y1], Gl[turn1] = Gl[x1] - fx, Gl[y1] - fy, Gl[turn1] + (ay * fx - ax * fy)
    Gl[x2], Gl[y2], Gl[turn2] = Gl[x2] + fx, Gl[y2] + fy, Gl[turn2] + (bx * fy - by * fx)
    here, there = part_of(C.positions_g, begin, begin + 12), part_of(C.positions_gt, begin, begin + 12)
    G = part_of(work.G, begin, begin + 12)
    entries_x, entries_y = ((0, -1.0), (2, ay), (3, 1.0), (5, -by)), ((7, -1.0), (8, -ax), (10, 1.0), (11, bx))
    for place, entry in entries_x + entries_y:
        G[place] = entry
        if matrix:
            work.lu[here[place]] = entry
            work.lu[there[place]] = entry
    if matrix and kq != 0.0:
        curved = part_of(C.positions_h, C.pos_h[c], C.pos_h[c + 1])
        for place, curve in enumerate((fx * ax + fy * ay, -fx * bx - fy * by)):
            work.lu[curved[place]] += kq * curve


@compiled
def _scatter(C, c, n, m, lam, kq, matrix, work):
    """Add G v to work.gv and G^T lam to work.Gl; if `matrix`, put G, G^T and kq H into work.lu."""
    dofs = part_of(C.dofs, C.dof[c], C.dof[c + 1])
    G = part_of(work.G, C.pos_g[c], C.pos_g[c + 1])
    gv, own = part_of(work.gv, C.row[c], C.row[c + 1]), part_of(lam, C.row[c], C.row[c + 1])
    for i in range(m):
        rate = gv[i]
        for j in range(n):
            rate += G[i * n + j] * work.vl[j]
        gv[i] = rate
    for j in range(n):
        force = 0.0
        for i in range(m):
            force += G[i * n + j] * own[i]
        work.Gl[dofs[j]] += force
    if matrix:
        here = part_of(C.positions_g, C.pos_g[c], C.pos_g[c + 1])
        there = part_of(C.positions_gt, C.pos_g[c], C.pos_g[c + 1])
        for k in range(m * n):
            work.lu[here[k]] = G[k]
            work.lu[there[k]] = G[k]
    if matrix and kq != 0.0:
        positions = part_of(C.positions_h, C.pos_h[c], C.pos_h[c + 1])
        entries = part_of(C.entries_h, C.pos_h[c], C.pos_h[c + 1])
        for k in range(entries.shape[0]):
            curve = work.Kl[entries[k]]
            if curve != 0.0:
                work.lu[positions[k]] += kq * curve


@compiled
def add_joint_friction(tables, address, c, n, m, h, lam, z, kq, kv, matrix, work):
    """Add friction in joint c, and its tangents by coordinates, velocities and multipliers."""
    C, out, H = tables.constraints, work.joint_friction_out, work.joint_friction_curve
    call_joint_load(tables, address, c, n, lam, work)
    slip = 0.0
    for j in range(6):
        slip += out[SLIDING + j] * work.vl[j]
    T, T_slip, T_N = call_joint_friction(tables, address, c, h, slip, out[LOAD], z, work.z_new)
    work.joint_friction[c, columns.JOINT_FRICTION_FORCE], work.joint_friction[c, columns.JOINT_SLIP] = T, slip
    slopes = work.slopes[tables.contacts.kernel.shape[0] + c]
    slopes[columns.JOINT_T_BY_SLIP] = T_slip
    for k in range(3):
        slopes[columns.JOINT_T_BY_LAM + k] = T_N * out[LOAD_BY_LAM + k]
    begin = C.dof[c]
    for i in range(6):
        work.r[C.dofs[begin + i]] -= T * out[SLIDING + i]
    if not matrix:
        return
    for j in range(6):
        slip_q = 0.0
        for k in range(6):
            slip_q += H[k, j] * work.vl[k]
        for i in range(6):
            by_q = out[SLIDING + i] * (T_slip * slip_q + T_N * out[LOAD_BY_Q + j]) + T * H[i, j]
            by_v = out[SLIDING + i] * T_slip * out[SLIDING + j]
            work.lu[C.positions_h[C.pos_h[c] + n * i + j]] -= kq * by_q + kv * by_v
    for k in range(m):
        for i in range(6):
            work.lu[C.positions_gt[C.pos_g[c] + n * k + i]] -= out[SLIDING + i] * T_N * out[LOAD_BY_LAM + k]


@compiled
def call_joint_load(tables, address, c, n, lam, work):
    """Call the load kernel of friction in joint c at the gathered coordinates."""
    C, out, H = tables.constraints, work.joint_friction_out, work.joint_friction_curve
    out[:] = H[:, :] = 0.0
    p = part_of(tables.p, C.joint_friction_p[c, LOAD_P], C.joint_friction_p[c, LOAD_P_END])
    load = joint_friction_at(address.joint_friction, C.joint_friction[c, LOAD_KERNEL])
    load(p, part_of(work.ql, 0, n), part_of(lam, C.row[c], C.row[c + 1]), out, H)


@compiled
def call_joint_friction(tables, address, c, h, slip, N, z, z_new):
    """Friction force in joint c and its derivatives by slip and normal force."""
    C = tables.constraints
    p = part_of(tables.p, C.joint_friction_p[c, SLIDING_P], C.joint_friction_p[c, SLIDING_P_END])
    begin, end = C.joint_friction_z[c, BEGIN], C.joint_friction_z[c, END]
    law = friction_at(address.friction, C.joint_friction[c, SLIDING_LAW])
    return law(p, h, slip, N, part_of(z, begin, end), part_of(z_new, begin, end))


@compiled
def call_constraint(tables, address, c, n, m, t, lam, work):
    """Call the kernel of constraint c, and subtract the prescribed motions from their rows."""
    C = tables.constraints
    begin, end = C.row[c], C.row[c + 1]
    p, q, v, own = (
        part_of(tables.p, C.p[c, BEGIN], C.p[c, END]), part_of(work.ql, 0, n), part_of(work.vl, 0, n),
        part_of(lam, begin, end),
    )  # fmt: skip
    g, gv, gamma = part_of(work.g, begin, end), part_of(work.gv, begin, end), part_of(work.gamma, begin, end)
    for k in range(m):
        g[k] = gv[k] = gamma[k] = 0.0
    G, H = matrix_view(part_of(work.G, C.pos_g[c], C.pos_g[c + 1]), m, n), matrix_view(work.Kl, n, n)
    if C.known[c] == ANGLE:
        difference(p, q, g, G)
    elif C.known[c] == GUIDE:
        slide(p, q, v, own, g, G, gamma, H, turns_at(part_of(C.dofs, C.dof[c], C.dof[c + 1]), work))
    else:
        for k in range(C.pos_g[c], C.pos_g[c + 1]):
            work.G[k] = 0.0
        constraint_at(address.constraint, C.kernel[c])(p, t, q, v, own, g, G, gv, gamma, H)
    for k in range(begin, end):
        if C.motion[k] < 0:
            continue
        p = part_of(tables.p, C.motion_p[k, BEGIN], C.motion_p[k, END])
        s, s_dot, s_ddot = motion_at(address.motion, C.motion[k])(p, t)
        work.g[k] -= s
        work.gv[k] -= s_dot
        work.gamma[k] += s_ddot
        work.drive[k, columns.MOTION], work.drive[k, columns.MOTION_RATE] = s, s_dot
        work.drive[k, columns.MOTION_ACCELERATION] = s_ddot


@compiled
def report_forces(tables, lam, work):
    """Compute the reported forces of joints (on their second bodies), moments, and drive forces, with the last G."""
    # Called for accepted states alone, after the last correction of the multipliers.
    C = tables.constraints
    for c in range(C.kernel.shape[0]):
        row, m, n = C.row[c], C.row[c + 1] - C.row[c], C.dof[c + 1] - C.dof[c]
        for k in range(2):
            place, force = C.second[c, k], 0.0
            if place >= 0:
                for i in range(m):
                    force -= work.G[C.pos_g[c] + i * n + place] * lam[row + i]
            work.joint[c, k] = force
        work.joint[c, columns.MOMENT] = -lam[row + (C.moment[c] if C.moment[c] >= 0 else m - 1)]
    for k in range(lam.shape[0]):
        work.drive[k, columns.DRIVE_FORCE] = -lam[k]
