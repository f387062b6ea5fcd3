"""Removal of the rigid motions of the joints from elastic displacements (mean axes).

B maps velocities of the bodies to velocities of the nodes.  A rigid motion w (n_t,) satisfies the joints if A w = 0
with A = G B.  The projection w - A^T (A A^T)^-1 A w of the previous motion is the motion of the present pose.
The displacements lose their component along z = B w in the metric of the mass, z^T M U, and have no momentum in z.
"""

import math

from flexmb.kernels import compiled
from flexmb.program.program import BEGIN, END

COS, SIN = range(2)
"""Columns of `Scratch.cs`."""


@compiled
def take_out_motions(el):
    """Make U, U', U'' of `el.trial` orthogonal in the metric of the mass to all rigid motions of the joints."""
    N, S, new = el.settings, el.scratch, el.trial
    if N.free == 0:
        return
    body_rows(el)
    triangle(S.square)
    for k in range(N.free):
        follow(el, k)
    n = el.tables.sizes.n_q
    for k in range(N.free):
        spread_motion(el, k)
        for _ in range(2):  # the second pass removes the round-off of the first
            for i in range(k):
                remove(S.shapes[k], S.shapes[i], S.moved[i], n)
        mass_times(el, S.shapes[k], S.moved[k])
        size = 0.0
        for i in range(n):
            size += S.shapes[k, i] * S.moved[k, i]
        size = math.sqrt(size)
        for i in range(n):
            S.shapes[k, i] /= size
            S.moved[k, i] /= size
        remove(new.u, S.shapes[k], S.moved[k], n)
        remove(new.u1, S.shapes[k], S.moved[k], n)
        remove(new.u2, S.shapes[k], S.moved[k], n)


@compiled
def remove(x, shape, moved, n):
    """x -= shape (moved . x)."""
    part = 0.0
    for i in range(n):
        part += moved[i] * x[i]
    for i in range(n):
        x[i] -= part * shape[i]


@compiled
def body_rows(el):
    """A = G B (n_c, n_t) of the pose with rows of length 1, and A A^T."""
    C, S, M, G = el.tables.constraints, el.scratch, el.model, el.work.G
    n = el.tables.sizes.n_q
    S.rows[:, :] = 0.0
    for c in range(C.kernel.shape[0]):
        count = C.dof[c + 1] - C.dof[c]
        for row in range(C.row[c], C.row[c + 1]):
            at = C.pos_g[c] + (row - C.row[c]) * count
            for k in range(count):
                dof = int(C.dofs[C.dof[c] + k])
                if dof < n:
                    add_entry(M, S, row, dof, G[at + k])
    for i in range(S.rows.shape[0]):
        size = 0.0
        for j in range(S.rows.shape[1]):
            size += S.rows[i, j] ** 2
        size = math.sqrt(size)
        for j in range(S.rows.shape[1]):
            S.rows[i, j] /= size
        for k in range(i + 1):
            total = 0.0
            for j in range(S.rows.shape[1]):
                total += S.rows[i, j] * S.rows[k, j]
            S.square[i, k] = total


@compiled
def add_entry(M, S, row, dof, value):
    """Add the entries of A of one entry of G, a coordinate `dof` of a node."""
    i, axis = dof // 3, dof % 3
    b = 3 * M.body[i]
    S.rows[row, b + axis] += value
    x, y = turned_arm(M, S, i)
    if axis == 0:
        S.rows[row, b + 2] -= value * y
    elif axis == 1:
        S.rows[row, b + 2] += value * x


@compiled
def turned_arm(M, S, i):
    """Vector from the node of the rigid body to node i, in the axes of the plane [m]."""
    b = M.body[i]
    c0, s0 = math.cos(M.reference[b]), math.sin(M.reference[b])
    c, s = S.cs[b, COS] * c0 - S.cs[b, SIN] * s0, S.cs[b, SIN] * c0 + S.cs[b, COS] * s0
    return c * M.arm[i, 0] - s * M.arm[i, 1], s * M.arm[i, 0] + c * M.arm[i, 1]


@compiled
def triangle(A):
    """Cholesky factor of A in the lower triangle of A; dependent rows are omitted."""
    for i in range(A.shape[0]):
        for j in range(i + 1):
            total = A[i, j]
            for k in range(j):
                total -= A[i, k] * A[j, k]
            if i == j:
                A[i, i] = math.sqrt(total) if total > 1e-12 else math.inf
            else:
                A[i, j] = total / A[j, j]


@compiled
def follow(el, k):
    """Projection of rigid motion k onto the motions that satisfy the joints of the present pose."""
    S, w = el.scratch, el.trial.motions[k]
    m, n = S.rows.shape
    for j in range(n):
        w[j] = el.now.motions[k, j]
    for i in range(m):
        total = 0.0
        for j in range(n):
            total += S.rows[i, j] * w[j]
        for j in range(i):
            total -= S.square[i, j] * S.side[j]
        S.side[i] = total / S.square[i, i]
    for i in range(m - 1, -1, -1):
        total = S.side[i]
        for j in range(i + 1, m):
            total -= S.square[j, i] * S.side[j]
        S.side[i] = total / S.square[i, i]
    for j in range(n):
        for i in range(m):
            w[j] -= S.rows[i, j] * S.side[i]


@compiled
def spread_motion(el, k):
    """Rigid motion k of the nodes, z = B w."""
    M, S, w = el.model, el.scratch, el.trial.motions[k]
    for i in range(M.body.shape[0]):
        b, j = 3 * M.body[i], 3 * i
        x, y = turned_arm(M, S, i)
        S.shapes[k, j], S.shapes[k, j + 1] = w[b] - w[b + 2] * y, w[b + 1] + w[b + 2] * x
        S.shapes[k, j + 2] = w[b + 2]


@compiled
def mass_times(el, x, out):
    """out = M x with the mass matrix of the present pose."""
    M, S = el.model, el.scratch
    for i in range(out.shape[0]):
        out[i] = 0.0
    for e in range(M.nodes.shape[0]):
        i, j, b, m = 3 * M.nodes[e, BEGIN], 3 * M.nodes[e, END], M.body[M.nodes[e, BEGIN]], M.m[e]
        c, s = S.cs[b, COS], S.cs[b, SIN]
        p, q, r = c * x[j] + s * x[j + 1], c * x[j + 1] - s * x[j], x[j + 2]
        X, Y = m[0] * p + m[1] * q + m[2] * r, m[3] * p + m[4] * q + m[5] * r
        out[i] += c * X - s * Y
        out[i + 1] += s * X + c * Y
        out[i + 2] += m[6] * p + m[7] * q + m[8] * r
