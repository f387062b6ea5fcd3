"""Contacts: gap x normal law x friction law, put together for any kind of each.

With n from the second surface into the first, t = (-n_y, n_x), arms a1, a2 from the nodes to the contact point:
    J_n = (n, n.(k x a1), -n, -n.(k x a2)),  gap_rate = J_n v
    J_t = (-t, -t.(k x a1), t, t.(k x a2)),  slip = J_t v
    r = -(N J_n + T J_t)
"""

from flexmb.contact.onset import crossing
from flexmb.kernels import GAP_SIZE, compiled, friction_at, gap_at, normal_at, part_of


@compiled
def add_contacts(tables, address, t, h, q, v, z, kq, kv, matrix, work):
    """Add contact forces to work.r and, if `matrix`, their tangents to work.lu; write histories and work.contact."""
    K = tables.contacts
    for k in range(K.kernel.shape[0]):
        dofs = part_of(K.dofs, 6 * k, 6 * k + 6)
        for i in range(6):
            dof = dofs[i]
            work.ql[i], work.vl[i] = q[dof], v[dof]
        out, slopes = work.contact[k, :GAP_SIZE], work.slopes[k]
        call_gap(tables, address, k, work.ql, work.vl, out)
        N, N_gap, N_rate = call_normal(tables, address, k, h, out[0], out[1], z, work.z_new)
        T, T_slip, T_N = call_friction(tables, address, k, h, out[2], N, z, work.z_new)
        work.contact[k, GAP_SIZE], work.contact[k, GAP_SIZE + 1] = N, T
        slopes[0], slopes[1], slopes[2], slopes[3] = N_gap, N_rate, T_slip, T_N
        if N == 0.0 and N_gap == 0.0 and N_rate == 0.0:  # open: what N would do to the friction does not matter
            slopes[3] = 0.0
        begin, end = K.z[k, 0], K.z[k, 1]
        _remember(t, h, out[0], out[1], N, part_of(z, begin, end), part_of(work.z_new, begin, end))
        if N == 0.0 and T == 0.0 and N_gap == 0.0 and N_rate == 0.0 and T_slip == 0.0:
            continue
        S = work.contact_scratch
        jacobians(out, S)
        for i in range(6):
            work.r[dofs[i]] -= N * S[0, i] + T * S[1, i]
        if matrix:
            _tangents(out, part_of(K.positions, 36 * k, 36 * k + 36), kq, kv, N, T, N_gap, N_rate, T_slip, T_N, work)


@compiled
def call_gap(tables, address, k, q, v, out):
    """Call the gap kernel of contact k with its own coordinates q and velocities v."""
    K = tables.contacts
    gap_at(address.gap, K.kernel[k, 0])(
        part_of(tables.p, K.p[k, 0], K.p[k, 1]), part_of(q, 0, 6), part_of(v, 0, 6), out
    )


@compiled
def call_normal(tables, address, k, h, gap, rate, z, z_new):
    """Normal force of contact k and its derivatives by gap and gap rate."""
    K = tables.contacts
    begin, end = K.z[k, 1], K.z[k, 2]
    return normal_at(address.normal, K.kernel[k, 1])(
        part_of(tables.p, K.p[k, 2], K.p[k, 3]), h, gap, rate, part_of(z, begin, end), part_of(z_new, begin, end)
    )


@compiled
def call_friction(tables, address, k, h, slip, N, z, z_new):
    """Friction force of contact k and its derivatives by slip and normal force."""
    K = tables.contacts
    begin, end = K.z[k, 2], K.z[k, 3]
    return friction_at(address.friction, K.kernel[k, 2])(
        part_of(tables.p, K.p[k, 4], K.p[k, 5]), h, slip, N, part_of(z, begin, end), part_of(z_new, begin, end)
    )


@compiled
def _remember(t, h, gap, gap_rate, N, z, z_new):
    """Phase (0 open, 1 closing, 2 rebounding, 3 lasting), time of the onset, gap, force, gap rate.

    The onset is where the cubic through gap and rate at both ends of its step falls through zero.
    """
    phase = z[0]
    z_new[1] = z[1]
    if gap > 0.0:
        phase = 0.0
    elif phase == 0.0:
        phase = 1.0
        z_new[1] = t
        if h > 0.0 and z[2] > 0.0:
            z_new[1] = t - h + h * crossing(h, z[2], z[4], gap, gap_rate)
    elif phase == 1.0 and gap_rate > 0.0:
        phase = 2.0
    elif phase == 2.0 and gap_rate < 0.0:
        phase = 3.0
    z_new[0], z_new[2], z_new[3], z_new[4] = phase, gap, N, gap_rate


@compiled
def jacobians(out, S):
    """Rows 0 and 1 of S: J_n and J_t."""
    nx, ny = out[3], out[4]
    S[0, 0], S[0, 1], S[0, 2] = nx, ny, ny * out[5] - nx * out[6]
    S[0, 3], S[0, 4], S[0, 5] = -nx, -ny, -ny * out[7] + nx * out[8]
    S[1, 0], S[1, 1], S[1, 2] = ny, -nx, -nx * out[5] - ny * out[6]
    S[1, 3], S[1, 4], S[1, 5] = -ny, nx, nx * out[7] + ny * out[8]


@compiled
def _tangents(out, positions, kq, kv, N, T, N_gap, N_rate, T_slip, T_N, work):
    """Add kq dr/dq + kv dr/dv of a contact to work.lu, column by column.

    g, s : derivatives of J_n and J_t by coordinate j (J_t has (n_y, -n_x) where J_n has n).
    """
    nx, ny, S, v = out[3], out[4], work.contact_scratch, work.vl
    for j in range(6):
        x, y = out[13 + j], out[19 + j]
        ax, ay, axq, ayq = out[5], out[6], out[25 + j], out[31 + j]
        bx, by, bxq, byq = out[7], out[8], out[37 + j], out[43 + j]
        g = (x, y, y * ax - x * ay + ny * axq - nx * ayq, -x, -y, -(y * bx - x * by + ny * bxq - nx * byq))
        s = (y, -x, -(x * ax + y * ay + nx * axq + ny * ayq), -y, x, x * bx + y * by + nx * bxq + ny * byq)
        rate_q, slip_q = 0.0, 0.0
        for i in range(6):
            rate_q += g[i] * v[i]
            slip_q += s[i] * v[i]
        N_q, N_v = N_gap * S[0, j] + N_rate * rate_q, N_rate * S[0, j]
        T_q, T_v = T_N * N_q + T_slip * slip_q, T_N * N_v + T_slip * S[1, j]
        along, across = kq * N_q + kv * N_v, kq * T_q + kv * T_v
        for i in range(6):
            entry = S[0, i] * along + S[1, i] * across + kq * (N * g[i] + T * s[i])
            work.lu[positions[6 * i + j]] -= entry
