"""The element of a reduced body: forces, tangents and energies by the poses of its nodes.

A node is a pin, or stands for three modes; all have a pose (x, y, theta).  n coordinates in all.  The frame of the body
has the angle theta_f, its axes are those of the reference configuration.  In these axes

    w, alpha            velocities and accelerations (less gravity) of the nodes
    d                   deformation: poses of the nodes against the frame, less those of the undeformed body
    e = d + c(d)        with the shortening by bending c, the sum of l_a (1/2 d Q_a d) over some directions l_a
    u = rho + S d       d d/d theta_f = -u;  rho = (-Y, X, 1) at each node,  S: (x, y, theta) -> (-y, x, 0)
    g                   theta_f by the coordinates:  theta_f' = g w
    F, f, E             forces on the nodes and on theta_f, r = F + g f; elastic forces of V = 1/2 e K e

The tangent is a combination of constant matrices and products of two vectors.  Elastic forces E change by Z d + B d',
with the damping matrix K_z = zeta K + D of e and J = de/dd:

    B = J' K_z J,   Z = J' K J + sum over l_a of (l_a (K e + K_z e')) Q_a + (J' K_z l_a) (Q_a d')'

Source: derived here; the terms are those of J. Zwoelfer, J. Gerstmayr, Multibody Syst. Dyn. 51 (2021) 477 in other
coordinates; the reference stresses of O. Wallrapp, R. Schwertassek, Int. J. Numer. Meth. Engng 32 (1991) 1833.
Equations (12.1) to (12.16) of docs/theory/reduced.md, whose names of matrices and changes these are.
"""

import math

from flexmb.elastic.beams.corotational import turned_back
from flexmb.engine.compiled.arrays import block_of, entry_of, item_of, part_of, row_of, stack_matrix
from flexmb.kernels import account_kernel, element_kernel, energy_kernel, fast, force_kernel, tangent_kernel
from flexmb.model.contributions import ElementKernels

# Parameters p: n, number of directions l, whether the frame is that of the first node, whether there is a D,
# stiffness-proportional damping time, g, m and int rho X.
# Then, at HEAD: X (n) poses of the undeformed body, A (n) weights of the frame, E (2 n) int rho Psi, the matrices M, G,
# H, P + Kc, Kc, K and D (n x n each), and of each direction l, K l, D l (n each) and Q (n x n); D has no part by zeta.
COUNT, DIRECTIONS, BY_PIN, MODAL, ZETA, GRAVITY_X, GRAVITY_Y, MASS, MOMENT_X, MOMENT_Y, HEAD = range(11)
MOST = 96  # largest number of coordinates
# Rows of the scratch matrix: d, d', w, alpha, u, s, forces on e, E, g and its rates, G d, Kc d, H d, work, Q d.
D, DD, W, AL, U, S, E, EF, G, G1, G2, GD, KD, HD, T1, T2, T3, QD = range(18)
scratch = stack_matrix(QD + MOST, MOST)
FIRST = 3  # first coordinate that bending shortens: those of the first node are none
MM, MG, MH, MP, MC, MK, MD, MATRICES = range(8)  # places of the matrices, and their number
L, KL, DL, ROWS_OF_DIRECTION = range(4)  # rows of a direction before its matrix Q, and their number


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
def gradient(p, i1, x):
    """Fill g by the inverse of the frame's size."""
    n = int(p[COUNT])
    g, weights = row_of(x, G, n), part_of(p, HEAD + n, HEAD + 2 * n)
    for i in range(0, n, 3):
        g[i], g[i + 1], g[i + 2] = -item_of(weights, i + 1) * i1, item_of(weights, i) * i1, 0.0
    if p[BY_PIN] != 0.0:  # all weights are 0
        g[2] = 1.0


@fast
def turning(p, size, x):
    """Fill g from w and alpha; return the frame's angular velocity and acceleration."""
    n = int(p[COUNT])
    w, al, i1 = row_of(x, W, n), row_of(x, AL, n), 1.0 / size
    gradient(p, i1, x)
    if p[BY_PIN] != 0.0:
        return w[2], al[2]
    vr, vi = weighed(p, w)
    _, ai = weighed(p, al)  # gravity is the same at all nodes and drops out
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
    write_forces(p, c, s, forces(p, spin, spin_rate, x, F), x, F, r)
    return strain, power


@fast
def mass_times(p, c, s, x, y, target):
    """target = M(q) y.  T1 and T2 are used."""
    n = int(p[COUNT])
    t1, t2, g, gd = row_of(x, T1, n), row_of(x, T2, n), row_of(x, G, n), row_of(x, GD, n)
    d, hd, kd = row_of(x, D, n), row_of(x, HD, n), row_of(x, KD, n)
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


# Tangents, and the kernels

# Rows of the second scratch matrix: F; S u, S w, S alpha; what tau and sigma multiply; df/dd; B u; K J u and K_z J w
# with products of them; the derivative of f; work.
# The third scratch matrix holds Q_a d'.
F, SU, SW, SA, VT, VS, BD, BU, KU, KW, DF, X1, X2, X3, X4, X5, X6, X7 = range(18)
ROWS = 18
second_scratch, third_scratch = stack_matrix(ROWS, MOST), stack_matrix(MOST, MOST)


@fast
def turning_rates(p, size, x):
    """Fill the rates of g from w and alpha."""
    n = int(p[COUNT])
    g1, g2 = row_of(x, G1, n), row_of(x, G2, n)
    if p[BY_PIN] != 0.0:
        for i in range(n):
            g1[i] = g2[i] = 0.0
        return
    weights, i1 = part_of(p, HEAD + n, HEAD + 2 * n), 1.0 / size
    vr, vi = weighed(p, row_of(x, W, n))
    ar, ai = weighed(p, row_of(x, AL, n))
    i2 = i1 * i1
    r1, s1 = -vr * i2, -vi * i2
    r2, s2 = 2.0 * (vr * vr - vi * vi) * i2 * i1 - ar * i2, 4.0 * vr * vi * i2 * i1 - ai * i2
    # Im(conj(A) dx z) by the coordinates x, for the rates r + i s of z = 1/size
    for i in range(0, n, 3):
        bx, by = item_of(weights, i), item_of(weights, i + 1)
        g1[i], g1[i + 1], g1[i + 2] = bx * s1 - by * r1, bx * r1 + by * s1, 0.0
        g2[i], g2[i + 1], g2[i + 2] = bx * s2 - by * r2, bx * r2 + by * s2, 0.0


@fast
def inertia(p, spin, spin_rate, x, y):
    """Fill VT, VS and BD without elastic forces."""
    n, squared = int(p[COUNT]), spin * spin
    d, d_rate, s, al, u = row_of(x, D, n), row_of(x, DD, n), row_of(x, S, n), row_of(x, AL, n), row_of(x, U, n)
    su, sw, sa = row_of(y, SU, n), row_of(y, SW, n), row_of(y, SA, n)
    vt, vs, bd = row_of(y, VT, n), row_of(y, VS, n), row_of(y, BD, n)
    for_vt, for_vs, for_h, for_c = row_of(y, X1, n), row_of(y, X2, n), row_of(y, X3, n), row_of(y, X4, n)
    M, G0, H = block_of(p, begin(p, MM), n, n), block_of(p, begin(p, MG), n, n), block_of(p, begin(p, MH), n, n)
    P0, C = block_of(p, begin(p, MP), n, n), block_of(p, begin(p, MC), n, n)
    turned(u, su)
    turned(row_of(x, W, n), sw)
    turned(al, sa)
    for i in range(n):
        for_vt[i] = spin_rate * u[i] + 2.0 * spin * sw[i] - squared * su[i]
        for_vs[i] = s[i] - spin * u[i]
        for_h[i] = spin * s[i] + 2.0 * spin_rate * d[i]
        for_c[i] = 2.0 * (spin * d_rate[i] + spin_rate * d[i]) + squared * u[i]
    for i in range(0, n, 3):
        t0, t1, t2, s0, s1, s2, d0, d1, d2 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for j in range(n):
            aj, tj, sj, hj = item_of(sa, j), item_of(for_vt, j), item_of(for_vs, j), item_of(for_h, j)
            cj, bj, uj, dj = item_of(for_c, j), item_of(al, j), squared * item_of(u, j), 2.0 * spin * item_of(d, j)
            g0, g1, g2 = entry_of(G0, i, j), entry_of(G0, i + 1, j), entry_of(G0, i + 2, j)
            q0, q1, q2 = entry_of(P0, i, j), entry_of(P0, i + 1, j), entry_of(P0, i + 2, j)
            t0 += entry_of(M, i, j) * aj + g0 * tj + q0 * uj
            t1 += entry_of(M, i + 1, j) * aj + g1 * tj + q1 * uj
            t2 += entry_of(M, i + 2, j) * aj + g2 * tj + q2 * uj
            s0 += g0 * sj + q0 * dj
            s1 += g1 * sj + q1 * dj
            s2 += g2 * sj + q2 * dj
            d0 += entry_of(G0, j, i) * bj + entry_of(H, i, j) * hj - entry_of(C, i, j) * cj
            d1 += entry_of(G0, j, i + 1) * bj + entry_of(H, i + 1, j) * hj - entry_of(C, i + 1, j) * cj
            d2 += entry_of(G0, j, i + 2) * bj + entry_of(H, i + 2, j) * hj - entry_of(C, i + 2, j) * cj
        vt[i], vt[i + 1], vt[i + 2] = t0, t1, t2
        vs[i], vs[i + 1], vs[i + 2] = s0, s1, s2
        bd[i], bd[i + 1], bd[i + 2] = d0, d1, d2


@fast
def elasticity(p, spin, x, y, rates):
    """Add elastic forces to VT, VS and BD; fill B u and Q_a d'."""
    n, count, zeta = int(p[COUNT]), int(p[DIRECTIONS]), p[ZETA]
    d_rate, u, on_e = row_of(x, DD, n), row_of(x, U, n), row_of(x, E, n)
    vt, vs, bd, bu = row_of(y, VT, n), row_of(y, VS, n), row_of(y, BD, n), row_of(y, BU, n)
    su, sw, ku, kw = row_of(y, SU, n), row_of(y, SW, n), row_of(y, KU, n), row_of(y, KW, n)
    w, ju, jw, work = row_of(y, X1, n), row_of(y, X2, n), row_of(y, X3, n), row_of(y, X4, n)
    for i in range(n):
        w[i] = sw[i] - spin * su[i]
        ju[i], jw[i] = u[i], w[i]
    for a in range(count):
        along, bent, rate = row_of(block_of(p, direction(p, a), 1, n), L, n), row_of(x, QD + a, n), row_of(rates, a, n)
        times_two(block_of(p, square(p, a), n, n), d_rate, u, rate, work)
        force = dot(along, on_e)
        add(force, work, vt)
        add(-force, work, bd)
        add(dot(bent, u), along, ju)
        add(dot(bent, w) + dot(rate, u), along, jw)
    times_two(block_of(p, begin(p, MK), n, n), ju, jw, ku, kw)
    for i in range(n):
        bu[i], kw[i] = zeta * ku[i], zeta * kw[i]
    if p[MODAL] != 0.0:
        modal = row_of(y, X5, n)
        times_two(block_of(p, begin(p, MD), n, n), ju, jw, modal, work)
        add(1.0, modal, bu)
        add(1.0, work, kw)
    for i in range(n):
        vt[i] += ku[i] + kw[i]
        vs[i] -= bu[i]
        bd[i] -= ku[i]
    for a in range(count):
        along, bent, rate = row_of(block_of(p, direction(p, a), 1, n), L, n), row_of(x, QD + a, n), row_of(rates, a, n)
        by_u, by_w, damped = dot(along, ku), dot(along, kw), dot(along, bu)
        work[a] = damped
        add(by_u + by_w, bent, vt)
        add(-damped, bent, vs)
        add(-by_u, bent, bd)
        add(-damped, rate, bd)
    for a in range(count):
        add(work[a], row_of(x, QD + a, n), bu)


@fast
def moment_row(p, spin, kq, kv, ka, x, y):
    """Complete df/dd; fill DF, the derivative of f."""
    n = int(p[COUNT])
    d, d_rate, s, u = row_of(x, D, n), row_of(x, DD, n), row_of(x, S, n), row_of(x, U, n)
    gd, kd, hd = row_of(x, GD, n), row_of(x, KD, n), row_of(x, HD, n)
    g, g1, g2, on_d = row_of(x, G, n), row_of(x, G1, n), row_of(x, G2, n), row_of(x, EF, n)
    su, sw, sa = row_of(y, SU, n), row_of(y, SW, n), row_of(y, SA, n)
    bd, bu, df, both = row_of(y, BD, n), row_of(y, BU, n), row_of(y, DF, n), row_of(y, X1, n)
    turn, on_u = row_of(y, X2, n), row_of(y, X3, n)
    for i in range(n):
        on_u[i] = on_d[i] + spin * spin * kd[i]
    turned(on_u, turn)
    by_tau = by_sigma = by_psi = 0.0
    for i in range(n):
        bd[i] += turn[i]
        by_spin = spin * hd[i]
        both[i] = by_spin - 2.0 * spin * kd[i] - bu[i]
        double = both[i] + by_spin
        by_tau += spin * both[i] * su[i] - bd[i] * u[i] - double * sw[i] - gd[i] * sa[i]
        by_sigma += s[i] * hd[i] - 2.0 * d_rate[i] * kd[i] - u[i] * (both[i] + 2.0 * spin * kd[i])
        by_psi += d[i] * (hd[i] - kd[i])
        df[i] = kq * bd[i] + kv * double + ka * gd[i]
    of_g, of_g1, of_g2 = kq * by_tau + kv * by_sigma + ka * by_psi, kq * by_sigma + 2.0 * kv * by_psi, kq * by_psi
    for j in range(0, n, 3):
        df[j] -= spin * kq * both[j + 1]
        df[j + 1] += spin * kq * both[j]
    for j in range(n):
        df[j] += of_g * g[j] + of_g1 * g1[j] + of_g2 * g2[j]


@fast
def constant_part(p, spin, spin_rate, kq, kv, ka, A):
    """Set A to the combination of the constant matrices M, G, P and K."""
    n = int(p[COUNT])
    M, G0 = block_of(p, begin(p, MM), n, n), block_of(p, begin(p, MG), n, n)
    P0, K = block_of(p, begin(p, MP), n, n), block_of(p, begin(p, MK), n, n)
    of_g, of_p, of_k = 2.0 * kv * spin + kq * spin_rate, kq * spin * spin, kq + kv * p[ZETA]
    turn_k = kq * spin * p[ZETA]
    for i in range(n):
        for j in range(0, n, 3):
            g0, g1, k0, k1 = entry_of(G0, i, j), entry_of(G0, i, j + 1), entry_of(K, i, j), entry_of(K, i, j + 1)
            a0 = ka * entry_of(M, i, j) + of_g * g0 + of_p * entry_of(P0, i, j) + of_k * k0
            a1 = ka * entry_of(M, i, j + 1) + of_g * g1 + of_p * entry_of(P0, i, j + 1) + of_k * k1
            a2 = ka * entry_of(M, i, j + 2) + of_g * entry_of(G0, i, j + 2) + of_p * entry_of(P0, i, j + 2)
            A[i, j] = a0 - of_p * g1 - turn_k * k1
            A[i, j + 1] = a1 + of_p * g0 + turn_k * k0
            A[i, j + 2] = a2 + of_k * entry_of(K, i, j + 2)
    if p[MODAL] != 0.0:
        modal, turn = block_of(p, begin(p, MD), n, n), kq * spin
        for i in range(n):
            for j in range(0, n, 3):
                A[i, j] += kv * modal[i, j] - turn * modal[i, j + 1]
                A[i, j + 1] += kv * modal[i, j + 1] + turn * modal[i, j]
                A[i, j + 2] += kv * modal[i, j + 2]


@fast
def shortened_row(p, row, a, x, target, half):
    """Set half = 1/2 the sum over b of (l_a A l_b) Q_b d, and target = A l_a + half; row: KL or DL, that of A l."""
    n = int(p[COUNT])
    rows = block_of(p, direction(p, a), ROWS_OF_DIRECTION, n)
    own, along = row_of(rows, row, n), row_of(rows, L, n)
    for i in range(n):
        half[i] = 0.0
    for b in range(int(p[DIRECTIONS])):
        other = row_of(block_of(p, direction(p, b), ROWS_OF_DIRECTION, n), row, n)
        add(0.5 * dot(along, other), row_of(x, QD + b, n), half)
    for i in range(n):
        target[i] = item_of(own, i) + half[i]


@fast
def shortened_part(p, spin, kq, kv, x, y, rates, A):
    """Add the shortening by bending to the elastic forces and damping in A."""
    n, turn = int(p[COUNT]), kq * spin
    stiff, damped, slope, of_damped = row_of(y, X1, n), row_of(y, X2, n), row_of(y, X3, n), row_of(y, X4, n)
    of_bent, quarter, half = row_of(y, X5, n), row_of(y, X6, n), row_of(y, X7, n)
    for a in range(int(p[DIRECTIONS])):
        bent, rate, Q = row_of(x, QD + a, n), row_of(rates, a, n), block_of(p, square(p, a), n, n)
        force = kq * dot(row_of(block_of(p, direction(p, a), 1, n), L, n), row_of(x, E, n))
        shortened_row(p, KL, a, x, stiff, half)
        for j in range(n):
            damped[j], slope[j] = p[ZETA] * stiff[j], p[ZETA] * (stiff[j] + half[j])
        if p[MODAL] != 0.0:
            shortened_row(p, DL, a, x, quarter, half)
            for j in range(n):
                damped[j] += quarter[j]
                slope[j] += quarter[j] + half[j]
        turned(bent, quarter)
        for j in range(n):
            of_damped[j] = kv * bent[j] + turn * quarter[j]
        turned(damped, quarter)
        for j in range(n):
            of_bent[j] = kq * stiff[j] + kv * damped[j] + turn * quarter[j]
        for i in range(n):
            bi, si, di, ri = bent[i], kq * stiff[i], damped[i], kq * slope[i]
            for j in range(n):
                added = bi * item_of(of_bent, j) + si * item_of(bent, j) + di * item_of(of_damped, j)
                A[i, j] += added + ri * item_of(rate, j) + force * entry_of(Q, i, j)


@fast
def frame_part(p, kq, kv, ka, f, x, y, A):
    """Add the turning of the frame, and the change of g f, to A."""
    n = int(p[COUNT])
    g, g1, g2, gd = row_of(x, G, n), row_of(x, G1, n), row_of(x, G2, n), row_of(x, GD, n)
    vt, vs, df = row_of(y, VT, n), row_of(y, VS, n), row_of(y, DF, n)
    sf, of_curve = row_of(y, X1, n), row_of(y, X2, n)
    curved = kq * f if p[BY_PIN] == 0.0 else 0.0  # the angle of a pin is a coordinate
    turned(row_of(y, F, n), sf)
    for i in range(0, n, 3):
        of_curve[i], of_curve[i + 1], of_curve[i + 2] = curved * g[i + 1], -curved * g[i], 0.0
    for j in range(n):
        df[j] -= of_curve[j]
    for i in range(n):
        of_g, of_f = kq * (sf[i] - vt[i]) + kv * vs[i] + ka * gd[i] - of_curve[i], g[i]
        of_g1, of_g2 = kq * vs[i] + 2.0 * kv * gd[i], kq * gd[i]
        for j in range(n):
            added = of_g * item_of(g, j) + of_g1 * item_of(g1, j) + of_g2 * item_of(g2, j)
            A[i, j] += added + of_f * item_of(df, j)


@fast
def to_world(c, s, A):
    """A in world axes."""
    n = A.shape[0]
    for i in range(0, n, 3):
        for j in range(0, n, 3):
            a00, a01, a10, a11 = A[i, j], A[i, j + 1], A[i + 1, j], A[i + 1, j + 1]
            b00, b01, b10, b11 = c * a00 - s * a10, c * a01 - s * a11, s * a00 + c * a10, s * a01 + c * a11
            A[i, j], A[i, j + 1] = c * b00 - s * b01, s * b00 + c * b01
            A[i + 1, j], A[i + 1, j + 1] = c * b10 - s * b11, s * b10 + c * b11
            ax, ay, bx, by = A[i, j + 2], A[i + 1, j + 2], A[i + 2, j], A[i + 2, j + 1]
            A[i, j + 2], A[i + 1, j + 2] = c * ax - s * ay, s * ax + c * ay
            A[i + 2, j], A[i + 2, j + 1] = c * bx - s * by, s * bx + c * by


@fast
def evaluate(p, q, v, a, kq, kv, ka, x, y, rates, r, A):
    """r and A = kq dr/dq + kv dr/dv + ka dr/da; y, rates: scratch matrices."""
    c, s, spin, spin_rate, size = motion(p, q, v, a, x)
    turning_rates(p, size, x)
    elastic(p, x)
    F_local = row_of(y, F, int(p[COUNT]))
    f = forces(p, spin, spin_rate, x, F_local)
    inertia(p, spin, spin_rate, x, y)
    elasticity(p, spin, x, y, rates)
    moment_row(p, spin, kq, kv, ka, x, y)
    constant_part(p, spin, spin_rate, kq, kv, ka, A)
    shortened_part(p, spin, kq, kv, x, y, rates, A)
    frame_part(p, kq, kv, ka, f, x, y, A)
    to_world(c, s, A)
    write_forces(p, c, s, f, x, F_local, r)


@element_kernel
def reduced_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    """Element of a reduced body; q, r (n,), K, C, M (n, n)."""
    x, y, B = scratch(), second_scratch(), third_scratch()
    for A, kq, kv, ka in ((K, 1.0, 0.0, 0.0), (C, 0.0, 1.0, 0.0), (M, 0.0, 0.0, 1.0)):
        evaluate(p, q, v, a, kq, kv, ka, x, y, B, r, A)


@tangent_kernel
def reduced_tangent(p, t, h, q, v, a, z, kq, kv, ka, r, A, z_new):
    """r (n,) and kq K + kv C + ka M (n, n)."""
    evaluate(p, q, v, a, kq, kv, ka, scratch(), second_scratch(), third_scratch(), r, A)


@force_kernel
def reduced_force(p, t, h, q, v, a, z, r, z_new):
    """Residual r (n,) alone."""
    residual(p, q, v, a, scratch(), r)


@energy_kernel
def reduced_energy(p, t, q, v):
    """Strain energy, potential of gravity, power dissipated by damping."""
    x = scratch()
    c, s, angle, size = frame_of(p, q)
    deformation(p, q, c, s, angle, x)
    rates(p, c, s, size, v, x)
    strain, power = elastic(p, x)
    return strain, gravity_energy(p, q, c, s, x), power


@account_kernel
def reduced_account(p, t, h, q, v, a, y, z, r, Mv, My, z_new):
    """r, M v, M y (n,); energies as `reduced_energy` gives them."""
    x = scratch()
    strain, power = residual(p, q, v, a, x, r)
    c, s, _, _ = frame_of(p, q)
    mass_times(p, c, s, x, v, Mv)
    mass_times(p, c, s, x, y, My)
    return strain, gravity_energy(p, q, c, s, x), power


REDUCED = ElementKernels(reduced_kernel, reduced_energy, reduced_force, reduced_tangent, reduced_account)
