"""Tangents of the element of a reduced body, and its kernels.

With a shift of coordinates by e_j, of velocities by kv/kq e_j and of accelerations by ka/kq e_j, in the axes of the
frame, theta_f and its rates change by

    tau = kq g,   sigma = kv g + kq g',   psi = ka g + 2 kv g' + kq g''

and d by kq e_j - tau u, w by kv e_j - tau S w, alpha by ka e_j - tau S alpha, d' by kv e_j - tau S w - sigma u
- theta_f' S (kq e_j - tau u).  So the tangent is a combination of constant matrices and products of two vectors.
Equations (12.13) to (12.16) of docs/theory/reduced.md.
"""

from flexmb.compiled.stack import stack_matrix
from flexmb.compiled.views import block_of, row_of
from flexmb.kernels import account_kernel, element_kernel, energy_kernel, fast, force_kernel, tangent_kernel
from flexmb.reduction.kernel import (
    AL,
    BY_PIN,
    COUNT,
    DD,
    EF,
    G1,
    G2,
    GD,
    HD,
    HS,
    KD,
    MC,
    MD,
    MG,
    MK,
    MM,
    MODAL,
    MOST,
    MP,
    MQ,
    QD,
    SHORTENED,
    ZETA,
    D,
    E,
    G,
    S,
    U,
    W,
    along,
    begin,
    elastic,
    forces,
    frame_of,
    gravity_energy,
    mass_times,
    motion,
    residual,
    scratch,
    times,
    times_two,
    turned,
    write_forces,
)

(
    F,
    SU,
    SW,
    SA,
    KU,
    DU,
    DSU,
    DSW,
    GU,
    GSU,
    GSW,
    GA,
    MSA,
    GS,
    PD,
    CDD,
    CU,
    VT,
    VS,
    BD,
    BS,
    BR,
    TAU,
    SIGMA,
    PSI,
    DF,
    SF,
    X1,
    X2,
) = range(29)
"""Rows of the second scratch matrix: F; products; columns and rows of the tangent; work."""

ROWS = 29
second_scratch, third_scratch = stack_matrix(ROWS, MOST), stack_matrix(2 * MOST, MOST)


@fast
def transposed_times(A, x, target):
    """Set target = A' x, three entries at a time."""
    n = x.shape[0]
    for j in range(0, n, 3):
        t0, t1, t2 = 0.0, 0.0, 0.0
        for i in range(n):
            xi = x[i]
            t0 += A[i, j] * xi
            t1 += A[i, j + 1] * xi
            t2 += A[i, j + 2] * xi
        target[j], target[j + 1], target[j + 2] = t0, t1, t2


@fast
def seen_through(p, A, x, y, entries, B):
    """Set B = J' A J with a symmetric A, J = de/dd; y, entries: (n,) work."""
    n, count = y.shape[0], int(p[SHORTENED])
    for i in range(n):
        for j in range(n):
            B[i, j] = A[i, j]
    for a in range(count):
        q = row_of(x, QD + a, n)
        for i in range(n):
            y[i] = along(p, a, row_of(A, i, n))
        for b in range(count):
            entries[b] = along(p, b, y)
        for b in range(count):
            half, other = 0.5 * entries[b], row_of(x, QD + b, n)
            for i in range(n):
                y[i] += half * other[i]
        for i in range(n):
            yi, qi = y[i], q[i]
            for j in range(n):
                B[i, j] += yi * q[j] + qi * y[j]


@fast
def stiffness(p, x, K, Z, y, yy):
    """Set Z to the derivative of E by d at constant d', but for J' K J: of changing J.

    K: undamped (n, n), D: modal damping.  y, yy: (n,) work.
    """
    n, count, zeta = y.shape[0], int(p[SHORTENED]), p[ZETA]
    on_e, d_rate, modal = row_of(x, E, n), row_of(x, DD, n), block_of(p, begin(p, MD), n, n)
    for i in range(n):
        for j in range(n):
            Z[i, j] = 0.0
    for a in range(count):
        force, Q = along(p, a, on_e), block_of(p, begin(p, MQ + a), n, n)
        for i in range(n):
            y[i] = zeta * along(p, a, row_of(K, i, n)) + along(p, a, row_of(modal, i, n))
        for b in range(count):
            yy[b] = along(p, b, y)
        for b in range(count):
            entry, other = yy[b], row_of(x, QD + b, n)
            for i in range(n):
                y[i] += entry * other[i]
        times(Q, d_rate, yy)
        for i in range(n):
            yi = y[i]
            for j in range(n):
                Z[i, j] += force * Q[i, j] + yi * yy[j]


@fast
def products(p, x, y):
    """Fill the products of constant matrices with the vectors of the state."""
    n = int(p[COUNT])
    al, u = row_of(x, AL, n), row_of(x, U, n)
    turned(u, row_of(y, SU, n))
    turned(row_of(x, W, n), row_of(y, SW, n))
    turned(al, row_of(y, SA, n))
    transposed_times(block_of(p, begin(p, MG), n, n), al, row_of(y, GA, n))
    times(block_of(p, begin(p, MM), n, n), row_of(y, SA, n), row_of(y, MSA, n))
    of_phi = block_of(p, begin(p, MG), n, n)
    times_two(of_phi, row_of(x, S, n), u, row_of(y, GS, n), row_of(y, GU, n))
    times_two(of_phi, row_of(y, SU, n), row_of(y, SW, n), row_of(y, GSU, n), row_of(y, GSW, n))
    times(block_of(p, begin(p, MP), n, n), row_of(x, D, n), row_of(y, PD, n))
    times_two(block_of(p, begin(p, MC), n, n), row_of(x, DD, n), u, row_of(y, CDD, n), row_of(y, CU, n))


@fast
def elastic_matrices(p, x, y, A, B, Z):
    """Set B = J' D J and Z = dE/dd; fill their products with u, S u and S w.  A: (n, n) work."""
    n, zeta = int(p[COUNT]), p[ZETA]
    u, work, other = row_of(x, U, n), row_of(y, X1, n), row_of(y, X2, n)
    K = block_of(p, begin(p, MK), n, n)
    stiffness(p, x, K, Z, work, other)
    seen_through(p, K, x, work, other, B)
    for i in range(n):
        for j in range(n):
            Z[i, j] += B[i, j]
            B[i, j] *= zeta
    if p[MODAL] != 0.0:
        seen_through(p, block_of(p, begin(p, MD), n, n), x, work, other, A)
        for i in range(n):
            for j in range(n):
                B[i, j] += A[i, j]
    times(B, u, row_of(y, DU, n))
    times_two(B, row_of(y, SU, n), row_of(y, SW, n), row_of(y, DSU, n), row_of(y, DSW, n))
    transposed_times(Z, u, row_of(y, KU, n))
    times(Z, u, row_of(y, VT, n))


@fast
def moment_rows(p, spin, spin_rate, kq, kv, ka, x, y):
    """Fill the columns that tau and sigma multiply, tau, sigma, psi, and DF, the derivative of f."""
    n = int(p[COUNT])
    d, u, gd, kd, hd, hs = (
        row_of(x, D, n),
        row_of(x, U, n),
        row_of(x, GD, n),
        row_of(x, KD, n),
        row_of(x, HD, n),
        row_of(x, HS, n),
    )
    g, g1, g2, on_d = row_of(x, G, n), row_of(x, G1, n), row_of(x, G2, n), row_of(x, EF, n)
    su, sw, sa = row_of(y, SU, n), row_of(y, SW, n), row_of(y, SA, n)
    ga, gu, gsu, gsw, gs, pd = (
        row_of(y, GA, n),
        row_of(y, GU, n),
        row_of(y, GSU, n),
        row_of(y, GSW, n),
        row_of(y, GS, n),
        row_of(y, PD, n),
    )
    du, dsu, dsw, ku, cdd, cu = (
        row_of(y, DU, n),
        row_of(y, DSU, n),
        row_of(y, DSW, n),
        row_of(y, KU, n),
        row_of(y, CDD, n),
        row_of(y, CU, n),
    )
    vt, vs, msa, bd, bs, br = (
        row_of(y, VT, n),
        row_of(y, VS, n),
        row_of(y, MSA, n),
        row_of(y, BD, n),
        row_of(y, BS, n),
        row_of(y, BR, n),
    )
    tau, sigma, psi, df = row_of(y, TAU, n), row_of(y, SIGMA, n), row_of(y, PSI, n), row_of(y, DF, n)
    work, turn = row_of(y, X1, n), row_of(y, X2, n)
    for i in range(n):
        work[i] = on_d[i] + spin * spin * kd[i]
    turned(work, turn)
    times(block_of(p, begin(p, MP), n, n), u, work)
    by_tau = by_sigma = by_psi = 0.0
    for i in range(n):
        vt[i] += spin_rate * gu[i] + spin * spin * work[i] + msa[i] + 2.0 * spin * gsw[i] + dsw[i]
        vt[i] -= spin * (spin * gsu[i] + dsu[i])
        vs[i] = gs[i] + spin * (2.0 * pd[i] - gu[i]) - du[i]
        net = hd[i] - kd[i]
        bd[i] = ga[i] + spin * (hs[i] - 2.0 * cdd[i]) + 2.0 * spin_rate * net + turn[i] - ku[i] - spin * spin * cu[i]
        br[i] = -2.0 * spin * kd[i] - du[i]
        bs[i] = spin * hd[i]
        tau[i] = kq * g[i]
        sigma[i] = kv * g[i] + kq * g1[i]
        psi[i] = ka * g[i] + 2.0 * kv * g1[i] + kq * g2[i]
        both, double = bs[i] + br[i], 2.0 * bs[i] + br[i]
        by_tau += spin * both * su[i] - bd[i] * u[i] - double * sw[i] - gd[i] * sa[i]
        by_sigma += d[i] * (hs[i] - 2.0 * cdd[i]) - u[i] * (both + 2.0 * spin * kd[i])
        by_psi += d[i] * net
    for j in range(n):
        df[j] = kq * bd[j] + kv * (2.0 * bs[j] + br[j]) + ka * gd[j]
        df[j] += by_tau * tau[j] + by_sigma * sigma[j] + by_psi * psi[j]
    for j in range(0, n, 3):
        df[j] -= spin * kq * (bs[j + 1] + br[j + 1])
        df[j + 1] += spin * kq * (bs[j] + br[j])


@fast
def assemble(p, spin, spin_rate, kq, kv, ka, f, x, y, B, Z, A):
    """Set A, the tangent in the axes of the frame."""
    n = int(p[COUNT])
    M, G0, P0 = block_of(p, begin(p, MM), n, n), block_of(p, begin(p, MG), n, n), block_of(p, begin(p, MP), n, n)
    g, gd, sf, vt, vs = row_of(x, G, n), row_of(x, GD, n), row_of(y, SF, n), row_of(y, VT, n), row_of(y, VS, n)
    tau, sigma, psi, df, gr = (
        row_of(y, TAU, n),
        row_of(y, SIGMA, n),
        row_of(y, PSI, n),
        row_of(y, DF, n),
        row_of(y, X1, n),
    )
    curved = kq * f if p[BY_PIN] == 0.0 else 0.0  # the angle of a pin is a coordinate
    turned(row_of(y, F, n), sf)
    for i in range(0, n, 3):
        gr[i], gr[i + 1], gr[i + 2] = g[i + 1], -g[i], 0.0
    of_g = 2.0 * kv * spin + kq * spin_rate
    for i in range(n):
        of_tau, of_sigma, of_psi, of_f, of_gr = sf[i] - vt[i], vs[i], gd[i], g[i], curved * gr[i]
        of_curve = curved * g[i]
        for j in range(n):
            A[i, j] = ka * M[i, j] + of_g * G0[i, j] + kq * (Z[i, j] + spin * spin * P0[i, j]) + kv * B[i, j]
            A[i, j] += of_tau * tau[j] + of_sigma * sigma[j] + of_psi * psi[j] + of_f * df[j]
            A[i, j] -= of_gr * g[j] + of_curve * gr[j]
        for j in range(0, n, 3):
            A[i, j] -= kq * spin * (spin * G0[i, j + 1] + B[i, j + 1])
            A[i, j + 1] += kq * spin * (spin * G0[i, j] + B[i, j])


@fast
def to_world(c, s, A):
    """A in world axes."""
    n = A.shape[0]
    for i in range(0, n, 3):
        for j in range(n):
            ax, ay = A[i, j], A[i + 1, j]
            A[i, j], A[i + 1, j] = c * ax - s * ay, s * ax + c * ay
    for i in range(n):
        for j in range(0, n, 3):
            ax, ay = A[i, j], A[i, j + 1]
            A[i, j], A[i, j + 1] = c * ax - s * ay, s * ax + c * ay


@fast
def evaluate(p, q, v, a, kq, kv, ka, x, y, third, r, A):
    """r and A = kq dr/dq + kv dr/dv + ka dr/da; y, third: scratch matrices."""
    n = int(p[COUNT])
    B, Z = block_of(row_of(third, 0, n * n), 0, n, n), block_of(row_of(third, MOST, n * n), 0, n, n)
    c, s, spin, spin_rate, _ = motion(p, q, v, a, x)
    elastic(p, x)
    F_local = row_of(y, F, n)
    f = forces(p, spin, spin_rate, x, F_local)
    products(p, x, y)
    elastic_matrices(p, x, y, A, B, Z)
    moment_rows(p, spin, spin_rate, kq, kv, ka, x, y)
    assemble(p, spin, spin_rate, kq, kv, ka, f, x, y, B, Z, A)
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
    c, s, _, _, _ = motion(p, q, v, v, x)  # energies do not depend on accelerations
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
