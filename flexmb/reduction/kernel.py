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

Elastic forces E come from V = 1/2 e K e with e = d + T c(d), where c is the shortening by bending: c_a = 1/2 d Q_a d.
T moves the nodes of vibrations as the pins move their frame, so that c changes no amplitude of a vibration.
Damping gives e' D e'.  Centrifugal stiffening subtracts 1/2 theta_f'^2 d Kc d from the kinetic energy.
Source: derived here; the terms are those of J. Zwoelfer, J. Gerstmayr, Multibody Syst. Dyn. 51 (2021) 477 in other
coordinates; the reference stresses of O. Wallrapp, R. Schwertassek, Int. J. Numer. Meth. Engng 32 (1991) 1833.
Equations (12.1) to (12.12) of docs/theory/reduced.md.
"""

import math

from flexmb.beams.chord import turned_back
from flexmb.compiled.stack import stack_matrix
from flexmb.compiled.views import block_of, part_of, row_of
from flexmb.kernels import fast

COUNT, SHORTENED, BY_PIN, MODAL, ZETA, GRAVITY_X, GRAVITY_Y, MASS, MOMENT_X, MOMENT_Y, HEAD = range(11)
"""Parameters p: n, number of matrices Q, whether the frame is that of the first node, whether there is modal damping,
stiffness-proportional damping time, g, m and int rho X.

Then, at HEAD: X (n) poses of the undeformed body, A (n) weights of the frame, E (2 n) int rho Psi, and the matrices
M, G, H, P + Kc, Kc, K, D and Q (n x n each); D is modal damping alone, Q_0 belongs to the coordinate 3.
"""

MOST = 96
"""Largest number of coordinates."""

D, DD, W, AL, U, S, E, EF, G, G1, G2, GD, KD, HD, HS, T1, T2, T3, QD = range(19)
"""Rows of the scratch matrix: d, d', w, alpha, u, s, forces on e, E, g and its rates, G d, Kc d, H d, H s, work, Q d.
"""

scratch = stack_matrix(QD + MOST, MOST)

FIRST = 3
"""First coordinate that bending shortens: those of the first node are none."""

MM, MG, MH, MP, MC, MK, MD, MQ = range(8)
"""Places of the matrices."""


@fast
def begin(p, place):
    """Index in p of the first entry of the matrix (n, n) at a place."""
    n = int(p[COUNT])
    return HEAD + 4 * n + place * n * n


@fast
def times(A, x, target):
    """Set target = A x, three rows at a time."""
    n = x.shape[0]
    for i in range(0, n, 3):
        t0, t1, t2 = 0.0, 0.0, 0.0
        for j in range(0, n, 3):
            x0, x1, x2 = x[j], x[j + 1], x[j + 2]
            t0 += A[i, j] * x0 + A[i, j + 1] * x1 + A[i, j + 2] * x2
            t1 += A[i + 1, j] * x0 + A[i + 1, j + 1] * x1 + A[i + 1, j + 2] * x2
            t2 += A[i + 2, j] * x0 + A[i + 2, j + 1] * x1 + A[i + 2, j + 2] * x2
        target[i], target[i + 1], target[i + 2] = t0, t1, t2


@fast
def times_two(A, x, y, of_x, of_y):
    """Set of_x = A x and of_y = A y."""
    n = x.shape[0]
    for i in range(0, n, 3):
        s0, s1, s2, t0, t1, t2 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for j in range(n):
            xj, yj, a0, a1, a2 = x[j], y[j], A[i, j], A[i + 1, j], A[i + 2, j]
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
    total = 0.0
    for i in range(x.shape[0]):
        total += x[i] * y[i]
    return total


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
    for i in range(0, n, 3):
        ax, ay = p[HEAD + n + i], p[HEAD + n + i + 1]
        real += ax * x[i] + ay * x[i + 1]
        imaginary += ax * x[i + 1] - ay * x[i]
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
def gradient(p, real, imaginary, target):
    """Set target = Im(conj(A) dx (real + i imaginary)) by the coordinates x."""
    n = int(p[COUNT])
    for i in range(0, n, 3):
        ax, ay = p[HEAD + n + i], p[HEAD + n + i + 1]
        target[i], target[i + 1], target[i + 2] = (
            ax * imaginary - ay * real,
            ax * real + ay * imaginary,
            0.0,
        )


@fast
def turning(p, size, x):
    """Fill g and its rates from w and alpha; return the frame's angular velocity and acceleration."""
    n = int(p[COUNT])
    if p[BY_PIN] != 0.0:
        for i in range(n):
            x[G, i] = x[G1, i] = x[G2, i] = 0.0
        x[G, 2] = 1.0
        return x[W, 2], x[AL, 2]
    i1 = 1.0 / size
    i2 = i1 * i1
    vr, vi = weighed(p, x[W])
    ar, ai = weighed(p, x[AL])  # gravity is the same at all nodes and drops out
    gradient(p, i1, 0.0, x[G])
    gradient(p, -vr * i2, -vi * i2, x[G1])
    gradient(p, 2.0 * (vr * vr - vi * vi) * i2 * i1 - ar * i2, 4.0 * vr * vi * i2 * i1 - ai * i2, x[G2])
    return vi * i1, ai * i1 - 2.0 * vr * vi * i2


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
    """Fill d, d', w, alpha, u, s, g and its rates; return cosine and sine of the frame, its rates, and its size."""
    c, s, angle, size = frame_of(p, q)
    n = deformation(p, q, c, s, angle, x)
    to_frame(c, s, v, x[W])
    to_frame(c, s, a, x[AL])
    spin, spin_rate = turning(p, size, x)
    gx, gy = c * p[GRAVITY_X] + s * p[GRAVITY_Y], c * p[GRAVITY_Y] - s * p[GRAVITY_X]
    for i in range(0, n, 3):
        x[AL, i], x[AL, i + 1] = x[AL, i] - gx, x[AL, i + 1] - gy
        # of d' any translation may be left out, as of d
        x[DD, i] = x[W, i] - x[W, 0] - spin * x[U, i]
        x[DD, i + 1] = x[W, i + 1] - x[W, 1] - spin * x[U, i + 1]
        x[DD, i + 2] = x[W, i + 2] - spin
    for i in range(n):
        x[S, i] = x[DD, i] + x[W, i]
    return c, s, spin, spin_rate, size


@fast
def following(p, k):
    """Displacement and rotation (3,) of the nodes of vibrations when coordinate FIRST + k alone changes by 1."""
    pins = 1 + int(p[SHORTENED]) // 3
    if p[BY_PIN] != 0.0 or k % 3 == 2:
        return 0.0, 0.0, 0.0
    weights, square = HEAD + int(p[COUNT]), 0.0
    for i in range(3 * pins):
        square += p[weights + i] * p[weights + i]
    at = weights + FIRST + k
    if k % 3 == 0:
        return 1.0 / pins, 0.0, -p[at + 1] / square
    return 0.0, 1.0 / pins, p[at - 1] / square


@fast
def along(p, k, x):
    """T_k x: entry FIRST + k of x and those of the nodes of vibrations, by how far these follow."""
    rx, ry, turn = following(p, k)
    total = x[FIRST + k]
    for i in range(FIRST + int(p[SHORTENED]), x.shape[0], 3):
        total += rx * x[i] + ry * x[i + 1] + turn * x[i + 2]
    return total


@fast
def add_along(p, k, value, x):
    """Add the vector T_k times a value to x."""
    rx, ry, turn = following(p, k)
    x[FIRST + k] += value
    for i in range(FIRST + int(p[SHORTENED]), x.shape[0], 3):
        x[i] += rx * value
        x[i + 1] += ry * value
        x[i + 2] += turn * value


@fast
def shortened(p, x, e, e_rate):
    """Fill Q d; set e = d + T c(d) and its rate."""
    n = int(p[COUNT])
    d, d_rate = row_of(x, D, n), row_of(x, DD, n)
    for i in range(n):
        e[i], e_rate[i] = d[i], d_rate[i]
    for k in range(int(p[SHORTENED])):
        y = row_of(x, QD + k, n)
        times(block_of(p, begin(p, MQ + k), n, n), d, y)
        add_along(p, k, 0.5 * dot(y, d), e)
        add_along(p, k, dot(y, d_rate), e_rate)


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
    for k in range(int(p[SHORTENED])):
        force, y = along(p, k, on_e), row_of(x, QD + k, n)
        for i in range(n):
            on_d[i] += force * y[i]
    return strain, power


@fast
def forces(p, spin, spin_rate, x, F):
    """Set F (n), forces on the nodes in the axes of the frame without g f; return f.  T1 and T3 are used."""
    n = int(p[COUNT])
    d, d_rate, s, al, u = row_of(x, D, n), row_of(x, DD, n), row_of(x, S, n), row_of(x, AL, n), row_of(x, U, n)
    gd, kd, hd, hs, on_d = row_of(x, GD, n), row_of(x, KD, n), row_of(x, HD, n), row_of(x, HS, n), row_of(x, EF, n)
    t1, t3 = row_of(x, T1, n), row_of(x, T3, n)
    times(block_of(p, begin(p, MM), n, n), al, F)
    times_two(block_of(p, begin(p, MG), n, n), d, s, gd, t1)
    times(block_of(p, begin(p, MP), n, n), d, t3)
    times_two(block_of(p, begin(p, MH), n, n), d, s, hd, hs)
    times(block_of(p, begin(p, MC), n, n), d, kd)
    f = 0.0
    for i in range(n):
        F[i] += spin_rate * gd[i] + spin * (t1[i] + spin * t3[i]) + on_d[i]
        f += gd[i] * al[i] + d[i] * (spin * hs[i] + spin_rate * (hd[i] - kd[i]))
        f -= 2.0 * spin * kd[i] * d_rate[i] + u[i] * (on_d[i] + spin * spin * kd[i])
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
