"""Evaluation of contacts, composed of a gap kernel, a normal law and a friction law of any kind.

With n from the second surface into the first, t = (-n_y, n_x), arms a1, a2 from the nodes to the contact point:
    J_n = (n, n.(k x a1), -n, -n.(k x a2)),  gap_rate = J_n v
    J_t = (-t, -t.(k x a1), t, t.(k x a2)),  slip = J_t v
    r = -(N J_n + T J_t)
Equations (5.3) and (5.4) of docs/theory/contact.md.
"""

from flexmb import places
from flexmb.engine.compiled.arrays import part_of
from flexmb.engine.system.work import N_BY_GAP, N_BY_RATE, T_BY_N, T_BY_SLIP, turns_at
from flexmb.kernels import GAP_SIZE, compiled, friction_at, gap_at, normal_at
from flexmb.parts.contact.onset import crossing
from flexmb.parts.joints.contact_point import journal_gap
from flexmb.program import program as at


@compiled
def add_contacts(tables, address, t, h, q, v, z, kq, kv, matrix, work):
    """Add contact forces to work.r and, if `matrix`, their tangents to work.lu; write histories and work.contact."""
    # `turn_nodes` has been called at q.
    K = tables.contacts
    for k in range(K.kernel.shape[0]):
        dofs, slopes = part_of(K.dofs, 6 * k, 6 * k + 6), work.slopes[k]
        find_gap(tables, address, k, q, v, matrix, turns_at(dofs, work), work)
        out = work.contact[k, :GAP_SIZE]
        N, N_gap, N_rate = call_normal(tables, address, k, h, out[places.GAP], out[places.GAP_RATE], z, work.z_new)
        T, T_slip, T_N = call_friction(tables, address, k, h, out[places.SLIP], N, z, work.z_new)
        work.contact[k, places.NORMAL_FORCE], work.contact[k, places.FRICTION_FORCE] = N, T
        slopes[N_BY_GAP], slopes[N_BY_RATE] = N_gap, N_rate
        slopes[T_BY_SLIP], slopes[T_BY_N] = T_slip, T_N
        if N == 0.0 and N_gap == 0.0 and N_rate == 0.0:  # open: what N would do to the friction does not matter
            slopes[T_BY_N] = 0.0
        begin, end = K.z[k, at.COMMON_Z], K.z[k, at.NORMAL_Z]
        old, new = part_of(z, begin, end), part_of(work.z_new, begin, end)
        _update_phase(t, h, out[places.GAP], out[places.GAP_RATE], N, old, new)
        if N == 0.0 and T == 0.0 and N_gap == 0.0 and N_rate == 0.0 and T_slip == 0.0:
            continue
        S = work.contact_scratch
        jacobians(out, S)
        for i in range(6):
            work.r[dofs[i]] -= N * S[places.NORMAL, i] + T * S[places.TANGENTIAL, i]
        if matrix:
            add_tangents(out, part_of(K.positions, 36 * k, 36 * k + 36), kq, kv, N, T, N_gap, N_rate, T_slip, T_N, work)


@compiled
def find_gap(tables, address, k, q, v, derivatives, turns, work):
    """Gap and gap rate of contact k at q and v; all that its gap kernel gives is written to work.contact."""
    dofs = part_of(tables.contacts.dofs, 6 * k, 6 * k + 6)
    for i in range(6):
        dof = dofs[i]
        work.ql[i], work.vl[i] = q[dof], v[dof]
    out = work.contact[k, :GAP_SIZE]
    call_gap(tables, address, k, work.ql, work.vl, derivatives, turns, out)
    return out[places.GAP], out[places.GAP_RATE]


@compiled
def call_gap(tables, address, k, q, v, derivatives, turns, out):
    """Call the gap kernel of contact k with its own coordinates q and velocities v."""
    # turns : cosine and sine of both angles, or None. What the loops know has no `derivatives` unless they are wanted.
    K = tables.contacts
    p, ql, vl = part_of(tables.p, K.p[k, at.GAP_P], K.p[k, at.GAP_P_END]), part_of(q, 0, 6), part_of(v, 0, 6)
    if K.known[k] == places.JOURNAL:
        journal_gap(p, ql, vl, derivatives, out, turns)
    else:
        gap_at(address.gap, K.kernel[k, at.GAP_KERNEL])(p, ql, vl, out)


@compiled
def call_normal(tables, address, k, h, gap, rate, z, z_new):
    """Normal force of contact k and its derivatives by gap and gap rate."""
    K = tables.contacts
    begin, end = K.z[k, at.NORMAL_Z], K.z[k, at.FRICTION_Z]
    p = part_of(tables.p, K.p[k, at.NORMAL_P], K.p[k, at.NORMAL_P_END])
    law = normal_at(address.normal, K.kernel[k, at.NORMAL_LAW])
    return law(p, h, gap, rate, part_of(z, begin, end), part_of(z_new, begin, end))


@compiled
def call_friction(tables, address, k, h, slip, N, z, z_new):
    """Friction force of contact k and its derivatives by slip and normal force."""
    K = tables.contacts
    begin, end = K.z[k, at.FRICTION_Z], K.z[k, at.Z_END]
    p = part_of(tables.p, K.p[k, at.FRICTION_P], K.p[k, at.FRICTION_P_END])
    law = friction_at(address.friction, K.kernel[k, at.FRICTION_LAW])
    return law(p, h, slip, N, part_of(z, begin, end), part_of(z_new, begin, end))


@compiled
def _update_phase(t, h, gap, gap_rate, N, z, z_new):
    """Phase (0 open, 1 closing, 2 rebounding, 3 lasting), time of the onset, gap, force, gap rate."""
    # The onset is where the cubic through gap and rate at both ends of its step falls through zero.
    phase = z[at.PHASE]
    z_new[at.ONSET_TIME] = z[at.ONSET_TIME]
    if gap > 0.0:
        phase = 0.0
    elif phase == 0.0:
        phase = 1.0
        z_new[at.ONSET_TIME] = t
        if h > 0.0 and z[at.LAST_GAP] > 0.0:
            z_new[at.ONSET_TIME] = t - h + h * crossing(h, z[at.LAST_GAP], z[at.LAST_GAP_RATE], gap, gap_rate)
    elif phase == 1.0 and gap_rate > 0.0:
        phase = 2.0
    elif phase == 2.0 and gap_rate < 0.0:
        phase = 3.0
    z_new[at.PHASE] = phase
    z_new[at.LAST_GAP], z_new[at.LAST_FORCE], z_new[at.LAST_GAP_RATE] = gap, N, gap_rate


@compiled
def jacobians(out, S):
    """Rows NORMAL and TANGENTIAL of S: J_n and J_t."""
    nx, ny = out[places.NORMAL_X], out[places.NORMAL_Y]
    ax, ay, bx, by = out[places.ARM1_X], out[places.ARM1_Y], out[places.ARM2_X], out[places.ARM2_Y]
    S[places.NORMAL, 0], S[places.NORMAL, 1], S[places.NORMAL, 2] = nx, ny, ny * ax - nx * ay
    S[places.NORMAL, 3], S[places.NORMAL, 4], S[places.NORMAL, 5] = -nx, -ny, -ny * bx + nx * by
    S[places.TANGENTIAL, 0], S[places.TANGENTIAL, 1], S[places.TANGENTIAL, 2] = ny, -nx, -nx * ax - ny * ay
    S[places.TANGENTIAL, 3], S[places.TANGENTIAL, 4], S[places.TANGENTIAL, 5] = -ny, nx, nx * bx + ny * by


@compiled
def add_tangents(out, positions, kq, kv, N, T, N_gap, N_rate, T_slip, T_N, work):
    """Add kq dr/dq + kv dr/dv of a contact to work.lu, column by column."""
    # g, s : derivatives of J_n and J_t by coordinate j (J_t has (n_y, -n_x) where J_n has n).
    nx, ny, S, v = out[places.NORMAL_X], out[places.NORMAL_Y], work.contact_scratch, work.vl
    ax, ay, bx, by = out[places.ARM1_X], out[places.ARM1_Y], out[places.ARM2_X], out[places.ARM2_Y]
    for j in range(6):
        x, y = out[places.NORMAL_X_Q + j], out[places.NORMAL_Y_Q + j]
        axq, ayq, bxq, byq = (
            out[places.ARM1_X_Q + j], out[places.ARM1_Y_Q + j], out[places.ARM2_X_Q + j], out[places.ARM2_Y_Q + j],
        )  # fmt: skip
        g = (x, y, y * ax - x * ay + ny * axq - nx * ayq, -x, -y, -(y * bx - x * by + ny * bxq - nx * byq))
        s = (y, -x, -(x * ax + y * ay + nx * axq + ny * ayq), -y, x, x * bx + y * by + nx * bxq + ny * byq)
        rate_q, slip_q = 0.0, 0.0
        for i in range(6):
            rate_q += g[i] * v[i]
            slip_q += s[i] * v[i]
        N_q, N_v = N_gap * S[places.NORMAL, j] + N_rate * rate_q, N_rate * S[places.NORMAL, j]
        T_q, T_v = T_N * N_q + T_slip * slip_q, T_N * N_v + T_slip * S[places.TANGENTIAL, j]
        along, across = kq * N_q + kv * N_v, kq * T_q + kv * T_v
        for i in range(6):
            entry = S[places.NORMAL, i] * along + S[places.TANGENTIAL, i] * across + kq * (N * g[i] + T * s[i])
            work.lu[positions[6 * i + j]] -= entry
