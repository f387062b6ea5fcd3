"""The element of a reduced body: forces, tangents and energies by the poses of its nodes.

A node is a pin, or stands for three modes; all have a pose (x, y, theta).  n coordinates in all.  The frame of the body
has the angle theta_f, its axes are those of the reference configuration.  In these axes

    w, alpha            velocities and accelerations (less gravity) of the nodes
    d                   deformation: poses of the nodes against the frame, less those of the undeformed body
    u = rho + S d       d d/d theta_f = -u;  rho = (-Y, X, 1) at each node,  S: (x, y, theta) -> (-y, x, 0)
    g                   theta_f by the coordinates:  theta_f' = g w

The displacements of the body are Psi d, its velocities Psi w + theta_f' (J Psi - Psi S) d =: Psi w + theta_f' Phi d,
which is exact for any rigid motion, since Psi holds all rigid motions.  With the products

    M = Psi' m Psi,  G = Psi' m Phi,  H = Phi' m Phi,  P = Psi' m J Phi

virtual work of inertia gives, with s = d' + w,

    F = M alpha + theta_f'' G d + theta_f' G s + theta_f'^2 P d + E          on the nodes
    f = d (G' alpha + theta_f'' H d + theta_f' H s) - u E                      on theta_f;    r = F + g f

Elastic forces E come from V = 1/2 e K e with e = d + c(d), where c is the shortening by bending: the sum of
l_a (1/2 d Q_a d) over some directions l_a.
Damping gives e' D e'.  Centrifugal stiffening subtracts 1/2 theta_f'^2 d Kc d from the kinetic energy.
Source: derived here; the terms are those of J. Zwoelfer, J. Gerstmayr, Multibody Syst. Dyn. 51 (2021) 477 in other
coordinates; the reference stresses of O. Wallrapp, R. Schwertassek, Int. J. Numer. Meth. Engng 32 (1991) 1833.
Equations (12.1) to (12.12) of docs/theory/reduced.md.
"""

import math

from flexmb.elastic.beams.corotational import turned_back
from flexmb.engine.compiled.arrays import block_of, entry_of, item_of, part_of, row_of, stack_matrix
from flexmb.kernels import fast

# The element of a reduced body: forces, tangents and energies by the poses of its nodes

COUNT, DIRECTIONS, BY_PIN, MODAL, ZETA, GRAVITY_X, GRAVITY_Y, MASS, MOMENT_X, MOMENT_Y, HEAD = range(11)
"""Parameters p: n, number of directions l, whether the frame is that of the first node, whether there is a D,
stiffness-proportional damping time, g, m and int rho X.

Then, at HEAD: X (n) poses of the undeformed body, A (n) weights of the frame, E (2 n) int rho Psi, the matrices M, G,
H, P + Kc, Kc, K and D (n x n each), and of each direction l, K l, D l (n each) and Q (n x n); D has no part by zeta.
"""

MOST = 96
"""Largest number of coordinates."""

D, DD, W, AL, U, S, E, EF, G, G1, G2, GD, KD, HD, T1, T2, T3, QD = range(18)
"""Rows of the scratch matrix: d, d', w, alpha, u, s, forces on e, E, g and its rates, G d, Kc d, H d, work, Q d."""

scratch = stack_matrix(QD + MOST, MOST)

FIRST = 3
"""First coordinate that bending shortens: those of the first node are none."""

MM, MG, MH, MP, MC, MK, MD, MATRICES = range(8)
"""Places of the matrices, and their number."""

L, KL, DL, ROWS_OF_DIRECTION = range(4)
"""Rows of a direction before its matrix Q, and their number."""


@fast
def begin(p, place):
    """Index in p of the first entry of the matrix (n, n) at a place."""
    n = int(p[COUNT])
    return HEAD + 4 * n + place * n * n


@fast
def direction(p, k):
    """Index in p of the first entry of a direction."""
    n = int(p[COUNT])
    return begin(p, MATRICES) + k * n * (ROWS_OF_DIRECTION + n)


@fast
def end_of(p):
    """Number of the parameters of the element."""
    return direction(p, int(p[DIRECTIONS]))


@fast
def square(p, k):
    """Index in p of the first entry of the matrix Q of a direction."""
    return direction(p, k) + ROWS_OF_DIRECTION * int(p[COUNT])


@fast
def times(A, x, target):
    """Set target = A x, three rows at a time."""
    n = x.shape[0]
    for i in range(0, n, 3):
        t0, t1, t2 = 0.0, 0.0, 0.0
        for j in range(n):
            xj = item_of(x, j)
            t0 += entry_of(A, i, j) * xj
            t1 += entry_of(A, i + 1, j) * xj
            t2 += entry_of(A, i + 2, j) * xj
        target[i], target[i + 1], target[i + 2] = t0, t1, t2


@fast
def times_two(A, x, y, of_x, of_y):
    """Set of_x = A x and of_y = A y."""
    n = x.shape[0]
    for i in range(0, n, 3):
        s0, s1, s2, t0, t1, t2 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for j in range(n):
            xj, yj = item_of(x, j), item_of(y, j)
            a0, a1, a2 = entry_of(A, i, j), entry_of(A, i + 1, j), entry_of(A, i + 2, j)
            s0 += a0 * xj
            s1 += a1 * xj
            s2 += a2 * xj
            t0 += a0 * yj
            t1 += a1 * yj
            t2 += a2 * yj
        of_x[i], of_x[i + 1], of_x[i + 2] = s0, s1, s2
        of_y[i], of_y[i + 1], of_y[i + 2] = t0, t1, t2


@fast
def dot(x, y):
    """Scalar product."""
    s0, s1, s2 = 0.0, 0.0, 0.0
    for i in range(0, x.shape[0], 3):
        s0 += item_of(x, i) * item_of(y, i)
        s1 += item_of(x, i + 1) * item_of(y, i + 1)
        s2 += item_of(x, i + 2) * item_of(y, i + 2)
    return s0 + s1 + s2


@fast
def add(factor, x, target):
    """Add factor x to target."""
    for i in range(0, target.shape[0], 3):
        t0, t1, t2 = item_of(target, i), item_of(target, i + 1), item_of(target, i + 2)
        x0, x1, x2 = item_of(x, i), item_of(x, i + 1), item_of(x, i + 2)
        target[i], target[i + 1], target[i + 2] = t0 + factor * x0, t1 + factor * x1, t2 + factor * x2


@fast
def turned(x, target):
    """Set target = S x: (-y, x, 0) of each node."""
    for i in range(0, x.shape[0], 3):
        target[i], target[i + 1], target[i + 2] = -x[i + 1], x[i], 0.0


@fast
def to_frame(c, s, x, target):
    """Set target = the vector x of the nodes in the axes of the frame."""
    for i in range(0, x.shape[0], 3):
        target[i], target[i + 1], target[i + 2] = c * x[i] + s * x[i + 1], c * x[i + 1] - s * x[i], x[i + 2]


@fast
def from_frame(c, s, x, target):
    """Set target = the vector x, given in the axes of the frame, in world axes."""
    for i in range(0, x.shape[0], 3):
        target[i], target[i + 1], target[i + 2] = c * x[i] - s * x[i + 1], s * x[i] + c * x[i + 1], x[i + 2]


@fast
def weighed(p, x):
    """Complex sum of conj(A) x over the nodes: its real and imaginary part."""
    n, real, imaginary = int(p[COUNT]), 0.0, 0.0
    weights = part_of(p, HEAD + n, HEAD + 2 * n)
    for i in range(0, n, 3):
        ax, ay, bx, by = item_of(weights, i), item_of(weights, i + 1), item_of(x, i), item_of(x, i + 1)
        real += ax * bx + ay * by
        imaginary += ax * by - ay * bx
    return real, imaginary


@fast
def frame_of(p, q):
    """Cosine, sine and angle of the frame, and |sum conj(A) x|."""
    if p[BY_PIN] != 0.0:
        return math.cos(q[2]), math.sin(q[2]), q[2], 1.0
    real, imaginary = weighed(p, q)
    size = math.sqrt(real * real + imaginary * imaginary)
    return real / size, imaginary / size, math.atan2(imaginary, real), size


@fast
def turning(p, size, x):
    """Fill g from w and alpha; return the frame's angular velocity and acceleration."""
    n = int(p[COUNT])
    w, al, g = row_of(x, W, n), row_of(x, AL, n), row_of(x, G, n)
    if p[BY_PIN] != 0.0:
        for i in range(n):
            g[i] = 0.0
        g[2] = 1.0
        return w[2], al[2]
    weights, i1 = part_of(p, HEAD + n, HEAD + 2 * n), 1.0 / size
    vr, vi = weighed(p, w)
    _, ai = weighed(p, al)  # gravity is the same at all nodes and drops out
    for i in range(0, n, 3):
        g[i], g[i + 1], g[i + 2] = -item_of(weights, i + 1) * i1, item_of(weights, i) * i1, 0.0
    return vi * i1, ai * i1 - 2.0 * vr * vi * (i1 * i1)


@fast
def deformation(p, q, c, s, angle, x):
    """Fill d and u."""
    n = int(p[COUNT])
    x0, y0 = p[HEAD], p[HEAD + 1]
    for i in range(0, n, 3):
        dx, dy = q[i] - q[0], q[i + 1] - q[1]
        ax, ay = c * dx + s * dy, c * dy - s * dx
        bx, by = p[HEAD + i] - x0, p[HEAD + i + 1] - y0
        x[D, i], x[D, i + 1] = ax - bx, ay - by
        x[D, i + 2] = turned_back(q[i + 2], angle + p[HEAD + i + 2])
        x[U, i], x[U, i + 1], x[U, i + 2] = -ay, ax, 1.0
    return n


@fast
def motion(p, q, v, a, x):
    """Fill d, d', w, alpha, u, s and g; return cosine and sine of the frame, its rates, and its size."""
    c, s, angle, size = frame_of(p, q)
    n = deformation(p, q, c, s, angle, x)
    to_frame(c, s, v, x[W])
    to_frame(c, s, a, x[AL])
    spin, spin_rate = turning(p, size, x)
    gx, gy = c * p[GRAVITY_X] + s * p[GRAVITY_Y], c * p[GRAVITY_Y] - s * p[GRAVITY_X]
    w, al, u, rate, total = row_of(x, W, n), row_of(x, AL, n), row_of(x, U, n), row_of(x, DD, n), row_of(x, S, n)
    wx, wy = w[0], w[1]
    for i in range(0, n, 3):
        al[i], al[i + 1] = item_of(al, i) - gx, item_of(al, i + 1) - gy
        # of d' any translation may be left out, as of d
        vx, vy, turn = item_of(w, i), item_of(w, i + 1), item_of(w, i + 2)
        dx, dy, dt = vx - wx - spin * item_of(u, i), vy - wy - spin * item_of(u, i + 1), turn - spin
        rate[i], rate[i + 1], rate[i + 2] = dx, dy, dt
        total[i], total[i + 1], total[i + 2] = dx + vx, dy + vy, dt + turn
    return c, s, spin, spin_rate, size


@fast
def shortened(p, x, e, e_rate):
    """Fill Q d; set e = d + c(d) and its rate."""
    n = int(p[COUNT])
    d, d_rate = row_of(x, D, n), row_of(x, DD, n)
    for i in range(n):
        e[i], e_rate[i] = d[i], d_rate[i]
    for k in range(int(p[DIRECTIONS])):
        y, along = row_of(x, QD + k, n), row_of(block_of(p, direction(p, k), 1, n), L, n)
        times(block_of(p, square(p, k), n, n), d, y)
        add(0.5 * dot(y, d), along, e)
        add(dot(y, d_rate), along, e_rate)


@fast
def elastic(p, x):
    """Fill the forces on e and on d (E); return strain energy and power of damping.  T1, T2, T3 are used."""
    n, zeta = int(p[COUNT]), p[ZETA]
    e, e_rate, work = row_of(x, T1, n), row_of(x, T2, n), row_of(x, T3, n)
    on_e, on_d = row_of(x, E, n), row_of(x, EF, n)
    shortened(p, x, e, e_rate)
    times_two(block_of(p, begin(p, MK), n, n), e, e_rate, on_e, work)
    strain, power = 0.5 * dot(e, on_e), 0.0
    if zeta != 0.0:
        power += zeta * dot(e_rate, work)
        for i in range(n):
            on_e[i] += zeta * work[i]
    if p[MODAL] != 0.0:
        times(block_of(p, begin(p, MD), n, n), e_rate, work)
        power += dot(e_rate, work)
        for i in range(n):
            on_e[i] += work[i]
    for i in range(n):
        on_d[i] = on_e[i]
    for k in range(int(p[DIRECTIONS])):
        add(dot(row_of(block_of(p, direction(p, k), 1, n), L, n), on_e), row_of(x, QD + k, n), on_d)
    return strain, power


@fast
def forces(p, spin, spin_rate, x, F):
    """Set F (n), forces on the nodes in the axes of the frame without g f; return f.  T1 and T3 are used."""
    n = int(p[COUNT])
    d, d_rate, s, al, u = row_of(x, D, n), row_of(x, DD, n), row_of(x, S, n), row_of(x, AL, n), row_of(x, U, n)
    gd, kd, hd, on_d = row_of(x, GD, n), row_of(x, KD, n), row_of(x, HD, n), row_of(x, EF, n)
    M, G0, H = block_of(p, begin(p, MM), n, n), block_of(p, begin(p, MG), n, n), block_of(p, begin(p, MH), n, n)
    P0, C = block_of(p, begin(p, MP), n, n), block_of(p, begin(p, MC), n, n)
    moved, squared = row_of(x, T1, n), spin * spin
    for i in range(n):
        moved[i] = spin_rate * d[i] + spin * s[i]
    f = 0.0
    for i in range(n):
        force, by_g, by_h, by_c = 0.0, 0.0, 0.0, 0.0
        for j in range(n):
            dj, g = item_of(d, j), entry_of(G0, i, j)
            force += entry_of(M, i, j) * item_of(al, j) + g * item_of(moved, j) + entry_of(P0, i, j) * (squared * dj)
            by_g += g * dj
            by_h += entry_of(H, i, j) * dj
            by_c += entry_of(C, i, j) * dj
        gd[i], hd[i], kd[i] = by_g, by_h, by_c
        F[i] = force + on_d[i]
        f += by_g * al[i] + moved[i] * by_h - u[i] * (on_d[i] + squared * by_c)
        f -= (spin_rate * d[i] + 2.0 * spin * d_rate[i]) * by_c
    return f


@fast
def write_forces(p, c, s, f, x, F, r):
    """r = F + g f in world axes."""
    n = int(p[COUNT])
    for i in range(n):
        F[i] += x[G, i] * f
    from_frame(c, s, F, part_of(r, 0, n))


@fast
def residual(p, q, v, a, x, r):
    """r; strain energy and power of damping are returned."""
    c, s, spin, spin_rate, _ = motion(p, q, v, a, x)
    strain, power = elastic(p, x)
    F = part_of(x[T2], 0, int(p[COUNT]))
    f = forces(p, spin, spin_rate, x, F)
    write_forces(p, c, s, f, x, F, r)
    return strain, power


@fast
def mass_times(p, c, s, x, y, target):
    """target = M(q) y.  T1 and T2 are used."""
    n = int(p[COUNT])
    t1, t2, g, gd, d, hd, kd = (
        row_of(x, T1, n),
        row_of(x, T2, n),
        row_of(x, G, n),
        row_of(x, GD, n),
        row_of(x, D, n),
        row_of(x, HD, n),
        row_of(x, KD, n),
    )
    to_frame(c, s, y, t1)
    spin = dot(g, t1)
    times(block_of(p, begin(p, MM), n, n), t1, t2)
    on_turn = 0.0
    for i in range(n):
        t2[i] += spin * gd[i]
        on_turn += gd[i] * t1[i] + spin * d[i] * (hd[i] - kd[i])
    for i in range(n):
        t2[i] += g[i] * on_turn
    from_frame(c, s, t2, target)


# Energies of the element of a reduced body, without its forces; the account of a step needs them twice


@fast
def energies(p, q, v, x):
    """Strain energy, potential of gravity, power of damping."""
    n, zeta = int(p[COUNT]), p[ZETA]
    c, s, angle, size = frame_of(p, q)
    deformation(p, q, c, s, angle, x)
    rates(p, c, s, size, v, x)
    e, e_rate, force, work = row_of(x, T1, n), row_of(x, T2, n), row_of(x, E, n), row_of(x, T3, n)
    shortened(p, x, e, e_rate)
    times_two(block_of(p, begin(p, MK), n, n), e, e_rate, force, work)
    strain, power = 0.5 * dot(e, force), zeta * dot(e_rate, work)
    if p[MODAL] != 0.0:
        times(block_of(p, begin(p, MD), n, n), e_rate, work)
        power += dot(e_rate, work)
    return strain, gravity_energy(p, q, c, s, x), power


@fast
def rates(p, c, s, size, v, x):
    """Fill w and d' from velocities v."""
    n = int(p[COUNT])
    w, u, rate = row_of(x, W, n), row_of(x, U, n), row_of(x, DD, n)
    to_frame(c, s, v, x[W])
    _, spin = weighed(p, w)
    spin = w[2] if p[BY_PIN] != 0.0 else spin / size
    for i in range(0, n, 3):
        rate[i], rate[i + 1] = w[i] - w[0] - spin * u[i], w[i + 1] - w[1] - spin * u[i + 1]
        rate[i + 2] = w[i + 2] - spin


@fast
def gravity_energy(p, q, c, s, x):
    """Potential of gravity."""
    n = int(p[COUNT])
    ex, ey = p[MOMENT_X] - p[MASS] * p[HEAD], p[MOMENT_Y] - p[MASS] * p[HEAD + 1]
    for i in range(n):
        ex += p[HEAD + 2 * n + i] * x[D, i]
        ey += p[HEAD + 3 * n + i] * x[D, i]
    mx, my = p[MASS] * q[0] + c * ex - s * ey, p[MASS] * q[1] + s * ex + c * ey
    return -(p[GRAVITY_X] * mx + p[GRAVITY_Y] * my)
