"""Newmark step (beta = 1/4, gamma = 1/2) of linear elasticity about the pose of the rigid counterpart.

A body has the angle phi, the angular velocity w and the angular acceleration alpha.  T rotates displacements into the
axes of the body, u = T U.  S is a quarter turn of the translations, T' = -w S T.  P keeps the translations and sets the
rotations to 0.  The forces of the body in its axes are m X + d Y + k Z with

    X = T U'' - 2 w S T U' - (alpha S + w^2 P) T U    (printed)    or    X = T U''    (inertial)
    Y = T U'                                          (printed)    or    Y = T U' - w S T U  (inertial)
    Z = T U

Source: X. Chen, S. Jiang, Y. Deng, Q. Wang, Nonlinear Dynamics (2018), eqs (26)-(30).
"""

import math

from nine_bar_study.nine_bar.staggered.rigid_motions import COS, SIN, take_out_motions

from flexmb.engine.compiled.arrays import part_of
from flexmb.engine.linalg.lu import LOST_PIVOT, factor, solve, solve_two
from flexmb.engine.state.record import NOT_FINITE, RUNNING
from flexmb.engine.system.constraints import add_constraints
from flexmb.engine.system.contacts import jacobians
from flexmb.engine.system.elements import call_element, call_force, gather_state, load_factor
from flexmb.engine.system.work import turn_nodes
from flexmb.kernels import compiled
from flexmb.places import FRICTION_FORCE, NORMAL, NORMAL_FORCE, TANGENTIAL
from flexmb.program.program import BEGIN, END

ELASTIC_SINGULAR, TOO_FAR = 30, 31
"""Codes of endings: a lost pivot of the elastic equations; displacements above `Settings.far`."""

(WHERE,) = range(1)
"""Index in `Scratch.b` of the unknown of such a code."""


@compiled
def carry(el, q, v, a):
    """Rigid motion of the nodes from q, v, a (n_t + 3,) of the rigid counterpart."""
    M, S = el.model, el.scratch
    for b in range(M.reference.shape[0]):
        phi = q[3 * b + 2] - M.reference[b]
        S.cs[b, COS], S.cs[b, SIN] = math.cos(phi), math.sin(phi)
    for i in range(M.body.shape[0]):
        b, j = 3 * M.body[i], 3 * i
        c, s = math.cos(q[b + 2]), math.sin(q[b + 2])
        x, y = c * M.arm[i, 0] - s * M.arm[i, 1], s * M.arm[i, 0] + c * M.arm[i, 1]
        w, alpha = v[b + 2], a[b + 2]
        S.q[j], S.q[j + 1], S.q[j + 2] = q[b] + x, q[b + 1] + y, q[b + 2] + M.turn[i]
        S.v[j], S.v[j + 1], S.v[j + 2] = v[b] - w * y, v[b + 1] + w * x, w
        S.a[j] = a[b] - alpha * y - w * w * x
        S.a[j + 1] = a[b + 1] + alpha * x - w * w * y
        S.a[j + 2] = alpha


@compiled
def to_bodies(el, v, a, u, u1, u2, with_rigid):
    """X, Y, Z of displacements u and rates u1, u2; `with_rigid` adds rigid accelerations less gravity to X."""
    M, S, N = el.model, el.scratch, el.settings
    for i in range(M.body.shape[0]):
        b, j = M.body[i], 3 * i
        c, s = S.cs[b, COS], S.cs[b, SIN]
        w, alpha, seen = v[3 * b + 2] * N.printed, a[3 * b + 2] * N.printed, v[3 * b + 2] * (1.0 - N.printed)
        ax, ay, turn = u2[j], u2[j + 1], u2[j + 2]
        if with_rigid:
            ax, ay, turn = ax + S.a[j] - N.gx, ay + S.a[j + 1] - N.gy, turn + S.a[j + 2]
        x, y = c * u[j] + s * u[j + 1], c * u[j + 1] - s * u[j]
        vx, vy = c * u1[j] + s * u1[j + 1], c * u1[j + 1] - s * u1[j]
        S.X[j] = c * ax + s * ay + 2.0 * w * vy + alpha * y - w * w * x
        S.X[j + 1] = c * ay - s * ax - 2.0 * w * vx - alpha * x - w * w * y
        S.X[j + 2] = turn
        S.Y[j], S.Y[j + 1], S.Y[j + 2] = vx + seen * y, vy - seen * x, u1[j + 2]
        S.Z[j], S.Z[j + 1], S.Z[j + 2] = x, y, u[j + 2]


@compiled
def subtract_forces(el, elastic, f):
    """f -= m X, or f -= m X + d Y + k Z with `elastic`, in the axes of the plane."""
    M, S = el.model, el.scratch
    for e in range(M.nodes.shape[0]):
        i, j, b = 3 * M.nodes[e, BEGIN], 3 * M.nodes[e, END], M.body[M.nodes[e, BEGIN]]
        x, y, turn = _row_sums(M.m[e], S.X, j)
        if elastic:
            dx, dy, dt = _row_sums(M.d[e], S.Y, j)
            kx, ky, kt = _row_sums(M.k[e], S.Z, j)
            x, y, turn = x + dx + kx, y + dy + ky, turn + dt + kt
        c, s = S.cs[b, COS], S.cs[b, SIN]
        f[i] -= c * x - s * y
        f[i + 1] -= s * x + c * y
        f[i + 2] -= turn


@compiled
def _row_sums(A, x, j):
    """Product of a block A (9,) and the entries j, j + 1, j + 2 of x."""
    return (
        A[0] * x[j] + A[1] * x[j + 1] + A[2] * x[j + 2],
        A[3] * x[j] + A[4] * x[j + 1] + A[5] * x[j + 2],
        A[6] * x[j] + A[7] * x[j + 1] + A[8] * x[j + 2],
    )


@compiled
def add_blocks(el, h, v, a):
    """Add M + h/2 C + h^2/4 K with the terms of rotation to the matrix."""
    M, S, N, values = el.model, el.scratch, el.settings, el.work.lu
    g, b4 = 0.5 * h, 0.25 * h * h
    for e in range(M.nodes.shape[0]):
        b = M.body[M.nodes[e, BEGIN]]
        c, s = S.cs[b, COS], S.cs[b, SIN]
        w, alpha, seen = v[3 * b + 2] * N.printed, a[3 * b + 2] * N.printed, v[3 * b + 2] * (1.0 - N.printed)
        p, r, o = 1.0 - b4 * w * w, -2.0 * w * g - alpha * b4, -b4 * seen
        x = _turned_row(M, e, 0, p, r, g, o, b4, c, s)
        y = _turned_row(M, e, 3, p, r, g, o, b4, c, s)
        z = _turned_row(M, e, 6, p, r, g, o, b4, c, s)
        at = part_of(M.places, 9 * e, 9 * e + 9)
        for k in range(3):
            values[at[k]] += c * x[k] - s * y[k]
            values[at[k + 3]] += s * x[k] + c * y[k]
            values[at[k + 6]] += z[k]


@compiled
def _turned_row(M, e, row, p, r, g, o, b4, c, s):
    """Row of (m (p + r S) + d (g + o S) + b4 k) T of block e."""
    m, d, k = M.m[e], M.d[e], M.k[e]
    x = p * m[row] + r * m[row + 1] + g * d[row] + o * d[row + 1] + b4 * k[row]
    y = p * m[row + 1] - r * m[row] + g * d[row + 1] - o * d[row] + b4 * k[row + 1]
    return c * x - s * y, s * x + c * y, m[row + 2] + g * d[row + 2] + b4 * k[row + 2]


@compiled
def add_contact_forces(el, tables, work, q):
    """Add contact forces of the rigid counterpart with coordinates q (n_t + 3,) to the forces of the nodes."""
    S, J = el.scratch, work.contact_scratch
    for k in range(tables.contacts.kernel.shape[0]):
        N, T = work.contact[k, NORMAL_FORCE], work.contact[k, FRICTION_FORCE]
        if N == 0.0 and T == 0.0:
            continue
        jacobians(work.contact[k], J)
        for end in range(2):
            there, here = tables.contacts.dofs[6 * k + 3 * end], el.whole.contacts.dofs[6 * k + 3 * end]
            fx = N * J[NORMAL, 3 * end] + T * J[TANGENTIAL, 3 * end]
            fy = N * J[NORMAL, 3 * end + 1] + T * J[TANGENTIAL, 3 * end + 1]
            moment = N * J[NORMAL, 3 * end + 2] + T * J[TANGENTIAL, 3 * end + 2]
            S.f[here] += fx
            S.f[here + 1] += fy
            S.f[here + 2] += moment + (q[there] - S.q[here]) * fy - (q[there + 1] - S.q[here + 1]) * fx


@compiled
def add_loads(el, t, h):
    """Add forces of loads, springs and dampers at the rigid motion to the forces of the nodes."""
    E, S, work = el.tables.elements, el.scratch, el.work
    S.given[:] = 0.0
    for k in range(el.model.loads.shape[0]):
        e = el.model.loads[k]
        n = E.dof[e + 1] - E.dof[e]
        gather_state(E, e, n, S.q, S.v, S.a, work)
        if E.force[e] < 0:
            call_element(el.tables, el.address, e, n, t, h, S.z, work)
        else:
            call_force(el.tables, el.address, e, n, t, h, S.z, work)
        factor_e = load_factor(el.tables, el.address, e, t, work)
        for i in range(n):
            dof = E.dofs[E.dof[e] + i]
            S.f[dof] -= factor_e * work.rl[i]
            if E.energy[e] < 0:
                S.given[dof] -= factor_e * work.rl[i]


@compiled
def times_joints(el, G, x, out, sign):
    """out += sign G x;  G : constraint Jacobian, row by row, out : (n_c,)."""
    C = el.tables.constraints
    for c in range(C.kernel.shape[0]):
        n = C.dof[c + 1] - C.dof[c]
        for row in range(C.row[c], C.row[c + 1]):
            at, total = C.pos_g[c] + (row - C.row[c]) * n, 0.0
            for k in range(n):
                total += G[at + k] * x[C.dofs[C.dof[c] + k]]
            out[row] += sign * total


@compiled
def elastic_step(el, tables, work, t, h, q, v, a):
    """Newmark step of U, U', U'' from `el.now` to `el.trial`; q, v, a : rigid motion at the end; returns a code."""
    S, now, new = el.scratch, el.now, el.trial
    n = el.tables.sizes.n_q
    carry(el, q, v, a)
    for i in range(n):
        new.u[i] = now.u[i] + h * now.u1[i] + 0.25 * h * h * now.u2[i]
        new.u1[i] = now.u1[i] + 0.5 * h * now.u2[i]
        new.u2[i] = 0.0
    S.f[:] = 0.0
    add_contact_forces(el, tables, work, q)
    add_loads(el, t, h)
    to_bodies(el, v, a, new.u, new.u1, new.u2, True)
    subtract_forces(el, True, S.f)
    el.work.lu[:] = 0.0
    add_blocks(el, h, v, a)
    turn_nodes(el.tables, S.q, el.work)
    add_constraints(el.tables, el.address, t, h, S.q, S.v, S.lam, S.z, 0.0, 0.0, True, el.work)
    lost = factor(el.lu, el.work.lu, S.seen, LOST_PIVOT)
    if lost >= 0:
        S.b[WHERE] = lost
        return ELASTIC_SINGULAR
    S.b[:] = 0.0
    if h > 0.0:
        times_joints(el, el.work.G, new.u, part_of(S.b, n, S.b.shape[0]), -4.0 / (h * h))
    for i in range(n):
        S.b[i] = S.f[i]
    solve(el.lu, el.work.lu, S.b, S.x, S.y)
    for i in range(n):
        new.u2[i] = S.x[i]
        new.u1[i] += 0.5 * h * S.x[i]
        new.u[i] += 0.25 * h * h * S.x[i]
    for k in range(el.model.ties.shape[0]):
        new.memory.tie = max(new.memory.tie, abs(S.x[n + el.model.ties[k]]))
    keep_joints(el, n, h)
    take_out_motions(el)
    new.memory.load_power = 0.0
    for i in range(n):
        new.memory.load_power += S.given[i] * new.u1[i]
    return checked(el, n)


@compiled
def keep_joints(el, n, h):
    """Correct U', U'' by the constraints on rates, G U' = -G' U and its derivative, with differences of G for G'.

    The Newmark step satisfies G U = 0.  Without the correction a variable G excites undamped accelerations.
    """
    S, now, new, G = el.scratch, el.now, el.trial, el.work.G
    for i in range(new.G.shape[0]):
        new.G[i] = G[i]
    new.drift[:] = 0.0
    if h == 0.0:
        return
    times_joints(el, now.G, new.u, new.drift, 1.0 / h)
    S.b[:] = 0.0
    S.c[:] = 0.0
    first, second = part_of(S.b, n, S.b.shape[0]), part_of(S.c, n, S.c.shape[0])
    times_joints(el, G, new.u1, first, -1.0)
    times_joints(el, now.G, new.u1, second, 1.0 / h)
    times_joints(el, G, new.u2, second, -1.0)
    for i in range(new.drift.shape[0]):
        first[i] += new.drift[i]
        second[i] -= now.drift[i] / h
    solve_two(el.lu, el.work.lu, S.b, S.c, S.x, S.work, S.pair)
    for i in range(n):
        new.u1[i] += S.x[i]
        new.u2[i] += S.work[i]


@compiled
def checked(el, n):
    """Code of the displacements: RUNNING, NOT_FINITE or TOO_FAR."""
    total = 0.0
    for i in range(n):
        total += el.trial.u2[i]
    if not math.isfinite(total):
        return NOT_FINITE
    for i in range(0, n, 3):
        if max(abs(el.trial.u[i]), abs(el.trial.u[i + 1])) > el.settings.far or abs(el.trial.u[i + 2]) > 1.0:
            el.scratch.b[WHERE] = i
            return TOO_FAR
    return RUNNING


@compiled
def hand_back(el, q, v, a):
    """Inertia forces (n_t,) of the elastic motion on each rigid body, with moments about the node of the body."""
    M, S, new = el.model, el.scratch, el.trial
    to_bodies(el, v, a, new.u, new.u1, new.u2, False)
    S.f[:] = 0.0
    subtract_forces(el, False, S.f)
    new.load[:] = 0.0
    for i in range(M.body.shape[0]):
        b, j = 3 * M.body[i], 3 * i
        new.load[b] += S.f[j]
        new.load[b + 1] += S.f[j + 1]
        new.load[b + 2] += S.f[j + 2] + (S.q[j] - q[b]) * S.f[j + 1] - (S.q[j + 1] - q[b + 1]) * S.f[j]
