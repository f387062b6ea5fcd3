"""Kernels of loads on the mesh of a reduced body.

In the axes of the frame the forces on the points of the body are c0 f + c1 J f, plus A d for a load that follows edges:

    dead       (c0, c1) = (cos, -sin) of theta_f less the angle of the axes in which f is given
    follower   (c0, c1) = (cos, sin) of the rotation of the first pin against the frame
    edges      (c0, c1) = (1, 0)

Virtual work with the displacements Psi dw + dtheta_f Phi d of the points (`flexmb.reduction.kernel`) gives

    F = c0 Psi' f + c1 Psi' J f + Psi' A d,   m = d (c0 Phi' f + c1 Phi' J f + Phi' A d);   r = -(F + g m)

Equations (12.22) to (12.24) of docs/theory/reduced.md.
"""

import math

from flexmb.compiled.stack import stack_matrix
from flexmb.compiled.views import block_of, part_of, row_of
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

KIND, ANGLE = 3, 4
"""Kind of a load and the angle of its axes, where the element of the body has other parameters."""

DEAD, FOLLOWER, EDGES = 0.0, 1.0, 2.0
"""Kinds of loads."""

OF_F, OF_JF, TURN_F, TURN_JF, VECTORS = range(5)
"""Vectors (n) behind poses and weights of the frame: Psi' f, Psi' J f, Phi' f, Phi' J f; their number.

With edges, the matrices Psi' A and Phi' A (n, n) follow.
"""

FORCE, ON_TURN, D_FORCE, D_TURN, BY_D, WORK = range(6)
"""Rows of the second scratch matrix: F and Phi' of the forces, their changes with c0 and c1, dm/dd, work."""

second_scratch = stack_matrix(6, MOST)


@fast
def vector(p, k):
    """Index in p of the first entry of a vector of the load."""
    return HEAD + (2 + k) * int(p[COUNT])


@fast
def directions(p, q, angle):
    """c0 and c1."""
    if p[KIND] == EDGES:
        return 1.0, 0.0
    beta = p[ANGLE] - angle if p[KIND] == DEAD else q[2] - angle
    return math.cos(beta), math.sin(beta)


@fast
def combined(p, c0, c1, d, x, y):
    """Fill F and Phi' of the forces; return m."""
    n = int(p[COUNT])
    force, on_turn, work = row_of(y, FORCE, n), row_of(y, ON_TURN, n), row_of(y, WORK, n)
    for i in range(n):
        force[i] = c0 * p[vector(p, OF_F) + i] + c1 * p[vector(p, OF_JF) + i]
        on_turn[i] = c0 * p[vector(p, TURN_F) + i] + c1 * p[vector(p, TURN_JF) + i]
    if p[KIND] == EDGES:
        at = vector(p, VECTORS)
        times(block_of(p, at, n, n), d, work)
        add(1.0, work, force)
        times(block_of(p, at + n * n, n, n), d, work)
        add(1.0, work, on_turn)
    return dot(d, on_turn)


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
    for i in range(0, n, 3):
        g[i], g[i + 1] = -p[HEAD + n + i + 1] / size, p[HEAD + n + i] / size


@fast
def load_force(p, q, x, y, r):
    """Residual r (n,); F + g m is left in FORCE.  Cosine and sine of the frame, c0, c1 and m are returned."""
    c, s, angle, size = frame_of(p, q)
    n = deformation(p, q, c, s, angle, x)
    c0, c1 = directions(p, q, angle)
    m = combined(p, c0, c1, row_of(x, D, n), x, y)
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
    d, on_turn, by_d = row_of(x, D, n), row_of(y, ON_TURN, n), row_of(y, BY_D, n)
    for i in range(n):
        y[D_FORCE, i] = c0 * p[vector(p, OF_JF) + i] - c1 * p[vector(p, OF_F) + i]
        y[D_TURN, i] = c0 * p[vector(p, TURN_JF) + i] - c1 * p[vector(p, TURN_F) + i]
        by_d[i] = on_turn[i]
    if p[KIND] == EDGES:
        C = block_of(p, vector(p, VECTORS) + n * n, n, n)
        for j in range(n):
            for i in range(n):
                by_d[j] += C[i, j] * d[i]


@fast
def load_tangent(p, q, x, y, r, K):
    """Residual r (n,) and tangent K (n, n)."""
    c, s, c0, c1, m = load_force(p, q, x, y, r)
    changes(p, c0, c1, x, y)
    n, kind = int(p[COUNT]), p[KIND]
    d, u, g = row_of(x, D, n), row_of(x, U, n), row_of(x, G, n)
    sf, bu, by_d = row_of(y, WORK, n), row_of(y, ON_TURN, n), row_of(y, BY_D, n)
    turned(row_of(y, FORCE, n), sf)
    for i in range(n):
        bu[i] = 0.0
    if kind == EDGES:
        times(block_of(p, vector(p, VECTORS), n, n), u, bu)
    by_angle, by_u, curved = dot(d, row_of(y, D_TURN, n)), dot(u, by_d), 0.0 if p[BY_PIN] != 0.0 else m
    for j in range(n):
        turn = 0.0 if kind == EDGES else -g[j]
        if kind == FOLLOWER and j == 2:
            turn += 1.0
        dm = turn * by_angle + by_d[j] - by_u * g[j] - curve(g, j, curved)
        for i in range(n):
            change = turn * y[D_FORCE, i] + (sf[i] - bu[i]) * g[j] + g[i] * dm
            K[i, j] = -change
    if kind == EDGES:
        B = block_of(p, vector(p, VECTORS), n, n)
        for i in range(n):
            for j in range(n):
                K[i, j] -= B[i, j]
    to_world(c, s, K)


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
    n, number = int(p[COUNT]), int(p[p.shape[0] - 1])
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
