"""Kernels of loads on the mesh of a reduced body.

In the axes of the frame the forces on the points of the body are c0 f + c1 J f, plus A d for a load that follows edges:

    dead       (c0, c1) = (cos, -sin) of theta_f less the angle of the axes in which f is given
    follower   (c0, c1) = (cos, sin) of the rotation of the first pin against the frame
    edges      (c0, c1) = (1, 0)

Virtual work with the displacements Psi dw + dtheta_f Phi d of the points (`flexmb.reduction.kernel`), and with the
geometric stiffness N0 of f and N1 of J f with all pins held, N = c0 N0 + c1 N1, gives

    F = c0 Psi' f + c1 Psi' J f + Psi' A d - N d
    m = d (c0 Phi' f + c1 Phi' J f + Phi' A d) + u N d;    r = -(F + g m)

Equations (12.22) to (12.24) of docs/theory/reduced.md.
"""

import math

from flexmb.compiled.stack import stack_matrix
from flexmb.compiled.views import block_of, item_of, part_of, row_of
from flexmb.kernels import element_kernel, fast, signal_kernel
from flexmb.planes.load_kernels import POWER
from flexmb.reduction.kernel import (
    BY_PIN,
    COUNT,
    HEAD,
    MOST,
    D,
    G,
    U,
    add,
    deformation,
    dot,
    frame_of,
    from_frame,
    scratch,
    times,
    turned,
)
from flexmb.reduction.tangent import to_world

KIND, ANGLE, STIFFENS = 3, 4, 5
"""Kind of a load, angle of its axes, whether it has a geometric stiffness, in place of other parameters of the body."""

DEAD, FOLLOWER, EDGES = 0.0, 1.0, 2.0
"""Kinds of loads."""

OF_F, OF_JF, TURN_F, TURN_JF, VECTORS = range(5)
"""Vectors (n) behind poses and weights of the frame: Psi' f, Psi' J f, Phi' f, Phi' J f; their number.

Matrices (n, n) follow: N0 and N1 if the load has a geometric stiffness, Psi' A and Phi' A with edges.
"""

FORCE, ON_TURN, D_FORCE, D_TURN, BY_D, ND, ND_CHANGE, WORK, ROWS = range(9)
"""Rows of the second scratch matrix: F and Phi' of the forces, their changes with the angle of (c0, c1), dm/dd,
N d and its change with that angle, work; their number."""

second_scratch = stack_matrix(ROWS, MOST)


@fast
def vector(p, k):
    """Index in p of the first entry of a vector of the load."""
    return HEAD + (2 + k) * int(p[COUNT])


@fast
def matrix(p, k):
    """Index in p of the first entry of a matrix (n, n): of N0 and N1, or of Psi' A and Phi' A behind them."""
    n = int(p[COUNT])
    return vector(p, VECTORS) + k * n * n


@fast
def edge_matrices(p):
    """Number of the matrix Psi' A."""
    return 2 if p[STIFFENS] != 0.0 else 0


@fast
def directions(p, q, angle):
    """c0 and c1."""
    if p[KIND] == EDGES:
        return 1.0, 0.0
    beta = p[ANGLE] - angle if p[KIND] == DEAD else q[2] - angle
    return math.cos(beta), math.sin(beta)


@fast
def combined(p, c0, c1, x, y):
    """Fill F, Phi' of the forces, N d and its change; return m."""
    n = int(p[COUNT])
    d, u, force, on_turn = row_of(x, D, n), row_of(x, U, n), row_of(y, FORCE, n), row_of(y, ON_TURN, n)
    nd, change, work = row_of(y, ND, n), row_of(y, ND_CHANGE, n), row_of(y, WORK, n)
    f, jf, turn_f, turn_jf = vector(p, OF_F), vector(p, OF_JF), vector(p, TURN_F), vector(p, TURN_JF)
    for i in range(n):
        force[i], on_turn[i] = c0 * p[f + i] + c1 * p[jf + i], c0 * p[turn_f + i] + c1 * p[turn_jf + i]
        nd[i], change[i] = 0.0, 0.0
    if p[KIND] == EDGES:
        at = edge_matrices(p)
        times(block_of(p, matrix(p, at), n, n), d, work)
        add(1.0, work, force)
        times(block_of(p, matrix(p, at + 1), n, n), d, work)
        add(1.0, work, on_turn)
    if p[STIFFENS] != 0.0:
        times(block_of(p, matrix(p, 0), n, n), d, nd)
        times(block_of(p, matrix(p, 1), n, n), d, work)
        for i in range(n):
            nd[i], change[i] = c0 * nd[i] + c1 * work[i], c0 * work[i] - c1 * nd[i]
        add(-1.0, nd, force)
    return dot(d, on_turn) + dot(u, nd)


@fast
def gradient(p, size, x):
    """Fill g, the derivative of theta_f."""
    n = int(p[COUNT])
    g = row_of(x, G, n)
    for i in range(n):
        g[i] = 0.0
    if p[BY_PIN] != 0.0:
        g[2] = 1.0
        return
    weights = part_of(p, HEAD + n, HEAD + 2 * n)
    for i in range(0, n, 3):
        g[i], g[i + 1] = -item_of(weights, i + 1) / size, item_of(weights, i) / size


@fast
def load_force(p, q, x, y, r):
    """Residual r (n,); F + g m is left in FORCE.  Cosine and sine of the frame, c0, c1 and m are returned."""
    c, s, angle, size = frame_of(p, q)
    n = deformation(p, q, c, s, angle, x)
    c0, c1 = directions(p, q, angle)
    m = combined(p, c0, c1, x, y)
    gradient(p, size, x)
    force = row_of(y, FORCE, n)
    add(m, row_of(x, G, n), force)
    from_frame(c, s, force, part_of(r, 0, n))
    for i in range(n):
        r[i] = -r[i]
    return c, s, c0, c1, m


@fast
def changes(p, c0, c1, x, y):
    """Fill changes of F and of Phi' of the forces with the angle of (c0, c1), and dm/dd."""
    n = int(p[COUNT])
    d, on_turn, by_d, change = row_of(x, D, n), row_of(y, ON_TURN, n), row_of(y, BY_D, n), row_of(y, ND_CHANGE, n)
    f, jf, turn_f, turn_jf = vector(p, OF_F), vector(p, OF_JF), vector(p, TURN_F), vector(p, TURN_JF)
    for i in range(n):
        y[D_FORCE, i] = c0 * p[jf + i] - c1 * p[f + i] - change[i]
        y[D_TURN, i] = c0 * p[turn_jf + i] - c1 * p[turn_f + i]
        by_d[i] = on_turn[i]
    if p[KIND] == EDGES:
        C = block_of(p, matrix(p, edge_matrices(p) + 1), n, n)
        for j in range(n):
            for i in range(n):
                by_d[j] += C[i, j] * d[i]
    if p[STIFFENS] != 0.0:
        nu, quarter = row_of(y, WORK, n), row_of(y, ON_TURN, n)
        of_stiffness(p, c0, c1, row_of(x, U, n), nu, quarter)
        turned(row_of(y, ND, n), quarter)
        for j in range(n):
            by_d[j] += nu[j] - quarter[j]


@fast
def of_stiffness(p, c0, c1, vector_in, target, work):
    """Set target = N x."""
    n = target.shape[0]
    times(block_of(p, matrix(p, 0), n, n), vector_in, target)
    times(block_of(p, matrix(p, 1), n, n), vector_in, work)
    for i in range(n):
        target[i] = c0 * target[i] + c1 * work[i]


@fast
def load_tangent(p, q, x, y, r, K):
    """Residual r (n,) and tangent K (n, n)."""
    c, s, c0, c1, m = load_force(p, q, x, y, r)
    changes(p, c0, c1, x, y)
    n, kind, stiffens, at = int(p[COUNT]), p[KIND], p[STIFFENS] != 0.0, edge_matrices(p)
    d, u, g = row_of(x, D, n), row_of(x, U, n), row_of(x, G, n)
    sf, by_d, bu, work = row_of(y, ON_TURN, n), row_of(y, BY_D, n), row_of(y, ND, n), row_of(y, WORK, n)
    turned(row_of(y, FORCE, n), sf)
    for i in range(n):
        bu[i] = 0.0
    if stiffens:
        of_stiffness(p, c0, c1, u, bu, work)
    for i in range(n):
        sf[i] += bu[i]
    if kind == EDGES:
        times(block_of(p, matrix(p, at), n, n), u, bu)
        add(-1.0, bu, sf)
    by_angle = dot(d, row_of(y, D_TURN, n)) + dot(u, row_of(y, ND_CHANGE, n))
    by_u, curved = dot(u, by_d), 0.0 if p[BY_PIN] != 0.0 else m
    for j in range(n):
        turn = 0.0 if kind == EDGES else -g[j]
        if kind == FOLLOWER and j == 2:
            turn += 1.0
        dm = turn * by_angle + by_d[j] - by_u * g[j] - curve(g, j, curved)
        for i in range(n):
            K[i, j] = -(turn * y[D_FORCE, i] + sf[i] * g[j] + g[i] * dm)
    add_matrices(p, c0, c1, K)
    to_world(c, s, K)


@fast
def add_matrices(p, c0, c1, K):
    """Add N - Psi' A to K."""
    n = K.shape[0]
    if p[KIND] == EDGES:
        B = block_of(p, matrix(p, edge_matrices(p)), n, n)
        for i in range(n):
            for j in range(n):
                K[i, j] -= B[i, j]
    if p[STIFFENS] != 0.0:
        N0, N1 = block_of(p, matrix(p, 0), n, n), block_of(p, matrix(p, 1), n, n)
        for i in range(n):
            for j in range(n):
                K[i, j] += c0 * N0[i, j] + c1 * N1[i, j]


@fast
def curve(g, i, m):
    """Entry i of -m S g, the derivative of the size of the sum behind theta_f, over that sum and times m."""
    if i % 3 == 0:
        return m * g[i + 1]
    return -m * g[i - 1] if i % 3 == 1 else 0.0


@element_kernel
def reduced_load_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    """Load on the mesh of a reduced body; q, r (n,), K (n, n)."""
    load_tangent(p, q, scratch(), second_scratch(), r, K)


@fast
def total(p, q, v, x, y):
    """Force along x or y, or power, by the last parameter."""
    n, last = int(p[COUNT]), p.shape[0] - 1
    number = int(p[last])
    r, found = row_of(y, D_FORCE, n), 0.0
    load_force(p, q, x, y, r)
    for i in range(0, n, 3):
        if number == POWER:
            found -= r[i] * v[i] + r[i + 1] * v[i + 1] + r[i + 2] * v[i + 2]
        else:
            found -= r[i + number]
    return found


@signal_kernel
def reduced_load_signal(p, t, q, v, a):
    """Force along x or y, or power; p: that of the element, then the number of the signal."""
    return total(p, q, v, scratch(), second_scratch())
