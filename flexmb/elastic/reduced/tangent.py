"""Tangents of the element of a reduced body, and its kernels.

With a shift of coordinates by e_j, of velocities by kv/kq e_j and of accelerations by ka/kq e_j, in the axes of the
frame, theta_f and its rates change by

    tau = kq g,   sigma = kv g + kq g',   psi = ka g + 2 kv g' + kq g''

and d by kq e_j - tau u, w by kv e_j - tau S w, alpha by ka e_j - tau S alpha, d' by kv e_j - tau S w - sigma u
- theta_f' S (kq e_j - tau u).  So the tangent is a combination of constant matrices and products of two vectors.
Elastic forces E change by Z d + B d', with the damping matrix K_z = zeta K + D of e and J = de/dd:

    B = J' K_z J,   Z = J' K J + sum over l_a of (l_a (K e + K_z e')) Q_a + (J' K_z l_a) (Q_a d')'

Equations (12.13) to (12.16) of docs/theory/reduced.md.
"""

from flexmb.elastic.reduced.kernel import (
    AL,
    BY_PIN,
    COUNT,
    DD,
    DIRECTIONS,
    DL,
    EF,
    G1,
    G2,
    GD,
    HD,
    HEAD,
    KD,
    KL,
    MC,
    MD,
    MG,
    MH,
    MK,
    MM,
    MODAL,
    MOST,
    MP,
    QD,
    ZETA,
    D,
    E,
    G,
    L,
    S,
    U,
    W,
    add,
    begin,
    direction,
    dot,
    elastic,
    energies,
    forces,
    frame_of,
    gravity_energy,
    mass_times,
    motion,
    residual,
    scratch,
    square,
    times_two,
    turned,
    weighed,
    write_forces,
)
from flexmb.engine.compiled.arrays import block_of, entry_of, item_of, part_of, row_of, stack_matrix
from flexmb.kernels import account_kernel, element_kernel, energy_kernel, fast, force_kernel, tangent_kernel

F, SU, SW, SA, VT, VS, BD, BU, KU, KW, DF, X1, X2, X3, X4, X5, X6, X7 = range(18)
"""Rows of the second scratch matrix: F; S u, S w, S alpha; what tau and sigma multiply; df/dd; B u; K J u and K_z J w
with products of them; the derivative of f; work.

The third scratch matrix holds Q_a d'.
"""

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
    d, d_rate, s, u, gd, kd, hd = (
        row_of(x, D, n),
        row_of(x, DD, n),
        row_of(x, S, n),
        row_of(x, U, n),
        row_of(x, GD, n),
        row_of(x, KD, n),
        row_of(x, HD, n),
    )
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
    own, along = row_of(block_of(p, direction(p, a), 1, n), row, n), row_of(block_of(p, direction(p, a), 1, n), L, n)
    for i in range(n):
        half[i] = 0.0
    for b in range(int(p[DIRECTIONS])):
        add(0.5 * dot(along, row_of(block_of(p, direction(p, b), 1, n), row, n)), row_of(x, QD + b, n), half)
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
    return energies(p, q, v, scratch())


@account_kernel
def reduced_account(p, t, h, q, v, a, y, z, r, Mv, My, z_new):
    """r, M v, M y (n,); energies as `reduced_energy` gives them."""
    x = scratch()
    strain, power = residual(p, q, v, a, x, r)
    c, s, _, _ = frame_of(p, q)
    mass_times(p, c, s, x, v, Mv)
    mass_times(p, c, s, x, y, My)
    return strain, gravity_energy(p, q, c, s, x), power
