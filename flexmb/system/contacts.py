"""Contacts: gap x normal law x friction law, put together for any kind of each.

With n from the second surface into the first, t = (-n_y, n_x), arms a1, a2 from the nodes to the contact point:
    J_n = (n, n.(k x a1), -n, -n.(k x a2)),  gap_rate = J_n v
    J_t = (-t, -t.(k x a1), t, t.(k x a2)),  slip = J_t v
    r = -(N J_n + T J_t)
"""

from flexmb.contact.onset import crossing
from flexmb.kernels import GAP_SIZE, compiled, friction_at, gap_at, normal_at


@compiled
def add_contacts(tables, address, t, h, q, v, z, kq, kv, matrix, work):
    """Add contact forces to work.r and, if `matrix`, their tangents to work.lu; write histories and work.contact."""
    K = tables.contacts
    for k in range(K.kernel.shape[0]):
        for i in range(6):
            work.ql[i] = q[K.dofs[k, i]]
            work.vl[i] = v[K.dofs[k, i]]
        out = work.contact[k, :GAP_SIZE]
        gap_at(address.gap, K.kernel[k, 0])(tables.p[K.p[k, 0] : K.p[k, 1]], work.ql[:6], work.vl[:6], out)
        N, N_gap, N_rate = normal_at(address.normal, K.kernel[k, 1])(
            tables.p[K.p[k, 2] : K.p[k, 3]],
            h,
            out[0],
            out[1],
            z[K.z[k, 1] : K.z[k, 2]],
            work.z_new[K.z[k, 1] : K.z[k, 2]],
        )
        T, T_slip, T_N = friction_at(address.friction, K.kernel[k, 2])(
            tables.p[K.p[k, 4] : K.p[k, 5]],
            h,
            out[2],
            N,
            z[K.z[k, 2] : K.z[k, 3]],
            work.z_new[K.z[k, 2] : K.z[k, 3]],
        )
        work.contact[k, GAP_SIZE], work.contact[k, GAP_SIZE + 1] = N, T
        work.slopes[k, 0], work.slopes[k, 1], work.slopes[k, 2], work.slopes[k, 3] = N_gap, N_rate, T_slip, T_N
        if N == 0.0 and N_gap == 0.0 and N_rate == 0.0:  # open: what N would do to the friction does not matter
            work.slopes[k, 3] = 0.0
        _remember(t, h, out[0], out[1], N, z[K.z[k, 0] : K.z[k, 1]], work.z_new[K.z[k, 0] : K.z[k, 1]])
        if N == 0.0 and T == 0.0 and N_gap == 0.0 and N_rate == 0.0 and T_slip == 0.0:
            continue
        jacobians(out, work.contact_scratch)
        S = work.contact_scratch
        for i in range(6):
            work.r[K.dofs[k, i]] -= N * S[0, i] + T * S[1, i]
        if matrix:
            tangents(out, work.vl, N, T, N_gap, N_rate, T_slip, T_N, S)
            for i in range(6):
                for j in range(6):
                    by_q = (
                        -S[0, i] * S[2, j]
                        - S[1, i] * S[3, j]
                        - N * geometry(out, S, i, j, 0)
                        - T * geometry(out, S, i, j, 1)
                    )
                    by_v = -S[0, i] * S[4, j] - S[1, i] * S[5, j]
                    work.lu[K.positions[k, 6 * i + j]] += kq * by_q + kv * by_v


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
def geometry(out, S, i, j, which):
    """Derivative of entry i of J_n (which = 0) or J_t (1) by coordinate j."""
    nqx, nqy = out[13 + j], out[19 + j]
    if which == 0:
        cx, cy, dx, dy = out[3], out[4], nqx, nqy
    else:
        cx, cy, dx, dy = out[4], -out[3], nqy, -nqx  # J_t has -t = (n_y, -n_x) where J_n has n
    sign = 1.0 if i < 3 else -1.0
    axis = i % 3
    if axis == 0:
        return sign * dx
    if axis == 1:
        return sign * dy
    if i == 2:
        ax, ay, axq, ayq = out[5], out[6], out[25 + j], out[31 + j]
    else:
        ax, ay, axq, ayq = out[7], out[8], out[37 + j], out[43 + j]
    return sign * (dy * ax - dx * ay + cy * axq - cx * ayq)


@compiled
def tangents(out, v, N, T, N_gap, N_rate, T_slip, T_N, S):
    """Rows 2-5 of S: dN/dq, dT/dq, dN/dv, dT/dv."""
    for j in range(6):
        rate_q, slip_q = 0.0, 0.0
        for i in range(6):
            rate_q += geometry(out, S, i, j, 0) * v[i]
            slip_q += geometry(out, S, i, j, 1) * v[i]
        S[2, j] = N_gap * S[0, j] + N_rate * rate_q
        S[3, j] = T_N * S[2, j] + T_slip * slip_q
        S[4, j] = N_rate * S[0, j]
        S[5, j] = T_N * S[4, j] + T_slip * S[1, j]
