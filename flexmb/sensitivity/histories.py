"""Histories in the tangent of a step: what they do to the forces, and what becomes of their own differences.

No kernel says how it depends on its history, so this is found by central differences of the law or element concerned,
alone, each number moved by a small part of itself: a gap of 1e-6 m is not lost in coordinates of 1 m.
"""

from flexmb.contact.onset import crossing, cubic
from flexmb.kernels import compiled, copy, friction_at, part_of
from flexmb.places import (
    ARM1_X,
    ARM1_X_Q,
    ARM1_Y,
    ARM1_Y_Q,
    ARM2_X,
    ARM2_X_Q,
    ARM2_Y,
    ARM2_Y_Q,
    GAP,
    GAP_RATE,
    LOAD,
    LOAD_BY_LAM,
    NORMAL,
    NORMAL_FORCE,
    NORMAL_X,
    NORMAL_X_Q,
    NORMAL_Y,
    NORMAL_Y_Q,
    SLIDING,
    SLIP,
    TANGENTIAL,
)
from flexmb.program.tables import (
    BEGIN,
    COMMON_Z,
    END,
    FRICTION_LAW,
    FRICTION_P,
    FRICTION_P_END,
    FRICTION_Z,
    LAST_FORCE,
    LAST_GAP,
    LAST_GAP_RATE,
    NORMAL_Z,
    ONSET_TIME,
    PHASE,
    SLIDING_LAW,
    SLIDING_P,
    SLIDING_P_END,
    Z_END,
)
from flexmb.system.contacts import call_friction, call_normal, jacobians
from flexmb.system.elements import call_element, call_force, gather_state
from flexmb.system.work import GRIP_SLIP, N_BY_GAP, N_BY_RATE, T_BY_N

FIRST, SECOND = range(2)
"""Rows of `Tangents.local`."""

OF_GAP, OF_RATE, OF_SLIP, OF_NORMAL = range(4)
"""Columns of `Tangents.own`: changes of gap, gap rate, slip and normal force."""

PART, LEAST = 1e-5, 1e-11
"""How far a number is moved: a part of itself, and at least so far where its size says nothing."""

MOTION, AWAY = 1e-3, 1e-9
"""How far the nodes of an element are moved: a part of their way in a step, and at least so far [m, rad]."""


@compiled
def changes(dz, i):
    """Whether any of the differences dz (k, n_z) has a part in history i."""
    for j in range(dz.shape[0]):  # noqa: SIM110 - compiled
        if dz[j, i] != 0.0:
            return True
    return False


@compiled
def nudge(x, other, least):
    """How far to move a number of value x, of which `other` is a second value."""
    size = PART * max(abs(x), abs(other))
    return size if size > least else LEAST


@compiled
def _spread(begin, end, eps, i, T, work):
    """Add the differences of work.z_between and work.z_new, made by moving history i by eps to both sides, to T.z1."""
    for j in range(T.z.shape[0]):
        part = T.z[j, i] / (2.0 * eps)
        for l in range(begin, end):
            T.z1[j, l] += (work.z_between[l] - work.z_new[l]) * part


@compiled
def _keep(begin, end, work):
    """work.z_between = work.z_new from begin to end."""
    copy(part_of(work.z_new, begin, end), part_of(work.z_between, begin, end))


@compiled
def _force_alone(tables, address, e, n, t, h, z, work):
    """Force of element e at the state that was gathered, into work.rl, and its history."""
    for i in range(n):
        work.rl[i] = 0.0
    if tables.elements.force[e] >= 0:
        call_force(tables, address, e, n, t, h, z, work)
    else:
        call_element(tables, address, e, n, t, h, z, work)


@compiled
def add_element_history(tables, address, e, n, t, h, s, z, T, work):
    """What the histories of element e do to T.F and T.z1; s : factor of the element."""
    E = tables.elements
    begin, end, force = E.z[e, BEGIN], E.z[e, END], T.local[SECOND]
    dofs = part_of(E.dofs, E.dof[e], E.dof[e + 1])
    for i in range(begin, end):
        if not changes(T.z, i):
            continue
        eps = nudge(z[i], work.z_new[i], LEAST)
        T.zs[i] = z[i] + eps
        _force_alone(tables, address, e, n, t, h, T.zs, work)
        _keep(begin, end, work)
        copy(part_of(work.rl, 0, n), part_of(force, 0, n))
        T.zs[i] = z[i] - eps
        _force_alone(tables, address, e, n, t, h, T.zs, work)
        T.zs[i] = z[i]
        _spread(begin, end, eps, i, T, work)
        for j in range(T.z.shape[0]):
            part = s * T.z[j, i] / (2.0 * eps)
            for l in range(n):
                T.F[j, dofs[l]] -= (force[l] - work.rl[l]) * part


@compiled
def add_contact_history(tables, address, c, h, z, T, work):
    """What the histories of contact c do to T.F and T.z1; changes of its forces are noted in T.N and T.T."""
    K, out = tables.contacts, work.contact[c]
    begin, middle, end = K.z[c, NORMAL_Z], K.z[c, FRICTION_Z], K.z[c, Z_END]
    for i in range(begin, middle):
        if not changes(T.z, i):
            continue
        eps = nudge(z[i], z[i], 0.0)
        T.zs[i] = z[i] + eps
        more, _, _ = call_normal(tables, address, c, h, out[GAP], out[GAP_RATE], T.zs, work.z_new)
        _keep(begin, middle, work)
        T.zs[i] = z[i] - eps
        less, _, _ = call_normal(tables, address, c, h, out[GAP], out[GAP_RATE], T.zs, work.z_new)
        T.zs[i] = z[i]
        _spread(begin, middle, eps, i, T, work)
        for j in range(T.z.shape[0]):
            T.N[j, c] += (more - less) * T.z[j, i] / (2.0 * eps)
    for i in range(middle, end):
        if not changes(T.z, i):
            continue
        eps = nudge(z[i], h * out[SLIP], LEAST)
        T.zs[i] = z[i] + eps
        more, _, _ = call_friction(tables, address, c, h, out[SLIP], out[NORMAL_FORCE], T.zs, work.z_new)
        _keep(middle, end, work)
        T.zs[i] = z[i] - eps
        less, _, _ = call_friction(tables, address, c, h, out[SLIP], out[NORMAL_FORCE], T.zs, work.z_new)
        T.zs[i] = z[i]
        _spread(middle, end, eps, i, T, work)
        for j in range(T.z.shape[0]):
            T.T[j, c] += (more - less) * T.z[j, i] / (2.0 * eps)
    S = work.contact_scratch
    jacobians(out, S)
    for j in range(T.z.shape[0]):
        N = T.N[j, c]
        friction = work.slopes[c, T_BY_N] * N + T.T[j, c]
        for i in range(6):
            T.F[j, K.dofs[6 * c + i]] += S[NORMAL, i] * N + S[TANGENTIAL, i] * friction


@compiled
def _joint_friction(tables, address, c, h, slip, N, z, z_new):
    """Friction force in joint c."""
    C = tables.constraints
    T, _, _ = friction_at(address.friction, C.grip[c, SLIDING_LAW])(
        part_of(tables.p, C.grip_p[c, SLIDING_P], C.grip_p[c, SLIDING_P_END]),
        h,
        slip,
        N,
        part_of(z, C.grip_z[c, BEGIN], C.grip_z[c, END]),
        part_of(z_new, C.grip_z[c, BEGIN], C.grip_z[c, END]),
    )
    return T


@compiled
def add_grip_history(tables, address, c, h, z, T, work):
    """The same for friction in joint c, whose grip is in work.grip_out."""
    C = tables.constraints
    begin, end, slip, N = C.grip_z[c, BEGIN], C.grip_z[c, END], work.grip[c, GRIP_SLIP], work.grip_out[LOAD]
    for i in range(begin, end):
        if not changes(T.z, i):
            continue
        eps = nudge(z[i], h * slip, LEAST)
        T.zs[i] = z[i] + eps
        more = _joint_friction(tables, address, c, h, slip, N, T.zs, work.z_new)
        _keep(begin, end, work)
        T.zs[i] = z[i] - eps
        less = _joint_friction(tables, address, c, h, slip, N, T.zs, work.z_new)
        T.zs[i] = z[i]
        _spread(begin, end, eps, i, T, work)
        for j in range(T.z.shape[0]):
            force = (more - less) * T.z[j, i] / (2.0 * eps)
            for l in range(6):
                T.F[j, C.dofs[C.dof[c] + l]] += T.grip[c, l] * force


@compiled
def follow_contact(tables, address, c, h, v, z, T, work):
    """The rest of T.z1 for contact c, from the differences T.q, T.v at the end of the step."""
    K, out = tables.contacts, work.contact[c]
    first, begin, middle, end = K.z[c, COMMON_Z], K.z[c, NORMAL_Z], K.z[c, FRICTION_Z], K.z[c, Z_END]
    _find_changes(K, c, v, T, work)
    if middle > begin:
        _follow_normal(tables, address, c, h, out[GAP], out[GAP_RATE], z, T, work)
    if end > middle:
        friction = friction_at(address.friction, K.kernel[c, FRICTION_LAW])
        p = part_of(tables.p, K.p[c, FRICTION_P], K.p[c, FRICTION_P_END])
        _follow_friction(friction, p, h, out[SLIP], out[NORMAL_FORCE], z, middle, end, T, work)
    closing = z[first + PHASE] == 0.0 and out[GAP] <= 0.0 < z[first + LAST_GAP] and h > 0.0
    for j in range(T.z.shape[0]):
        own = T.own[j]
        later = T.z[j, first + ONSET_TIME]
        if closing:
            later = _onset_later(h, first, out[GAP], out[GAP_RATE], z, T.z[j], own)
        T.z1[j, first + PHASE], T.z1[j, first + ONSET_TIME] = 0.0, later
        T.z1[j, first + LAST_GAP], T.z1[j, first + LAST_GAP_RATE] = own[OF_GAP], own[OF_RATE]
        T.z1[j, first + LAST_FORCE] = own[OF_NORMAL]


@compiled
def _find_changes(K, c, v, T, work):
    """T.own (k, 4) : changes of gap, gap rate, slip and normal force of contact c."""
    out, slopes, S, by = work.contact[c], work.slopes[c], work.contact_scratch, T.local
    dofs = part_of(K.dofs, 6 * c, 6 * c + 6)
    jacobians(out, S)
    for i in range(6):
        work.vl[i] = v[dofs[i]]
    _curve(out, work.vl, by)
    for j in range(T.q.shape[0]):
        gap, rate, slip = 0.0, 0.0, 0.0
        for i in range(6):
            dq, dv = T.q[j, dofs[i]], T.v[j, dofs[i]]
            gap += S[NORMAL, i] * dq
            rate += S[NORMAL, i] * dv + by[NORMAL, i] * dq
            slip += S[TANGENTIAL, i] * dv + by[TANGENTIAL, i] * dq
        T.own[j, OF_GAP], T.own[j, OF_RATE], T.own[j, OF_SLIP] = gap, rate, slip
        T.own[j, OF_NORMAL] = slopes[N_BY_GAP] * gap + slopes[N_BY_RATE] * rate + T.N[j, c]


@compiled
def _curve(out, v, by):
    """Rows NORMAL and TANGENTIAL of `by`: derivatives of gap rate J_n v and slip J_t v by the six coordinates."""
    nx, ny = out[NORMAL_X], out[NORMAL_Y]
    ax, ay, bx, by_ = out[ARM1_X], out[ARM1_Y], out[ARM2_X], out[ARM2_Y]
    for j in range(6):
        x, y = out[NORMAL_X_Q + j], out[NORMAL_Y_Q + j]
        axq, ayq, bxq, byq = out[ARM1_X_Q + j], out[ARM1_Y_Q + j], out[ARM2_X_Q + j], out[ARM2_Y_Q + j]
        arm1, arm2 = y * ax - x * ay + ny * axq - nx * ayq, y * bx - x * by_ + ny * bxq - nx * byq
        by[NORMAL, j] = x * (v[0] - v[3]) + y * (v[1] - v[4]) + arm1 * v[2] - arm2 * v[5]
        along1, along2 = x * ax + y * ay + nx * axq + ny * ayq, x * bx + y * by_ + nx * bxq + ny * byq
        by[TANGENTIAL, j] = y * (v[0] - v[3]) - x * (v[1] - v[4]) - along1 * v[2] + along2 * v[5]


@compiled
def _add(begin, end, which, eps, T, work):
    """Add what a change of gap, rate, slip or force (`which`), moved by eps to both sides, does to T.z1."""
    for j in range(T.z.shape[0]):
        part = T.own[j, which] / (2.0 * eps)
        for l in range(begin, end):
            T.z1[j, l] += (work.z_between[l] - work.z_new[l]) * part


@compiled
def _follow_normal(tables, address, c, h, gap, rate, z, T, work):
    """History of the normal law by gap and gap rate."""
    begin, end = tables.contacts.z[c, NORMAL_Z], tables.contacts.z[c, FRICTION_Z]
    of_gap, of_rate = nudge(gap, gap, 0.0), nudge(rate, z[tables.contacts.z[c, COMMON_Z] + LAST_GAP_RATE], 0.0)
    call_normal(tables, address, c, h, gap + of_gap, rate, z, work.z_new)
    _keep(begin, end, work)
    call_normal(tables, address, c, h, gap - of_gap, rate, z, work.z_new)
    _add(begin, end, OF_GAP, of_gap, T, work)
    call_normal(tables, address, c, h, gap, rate + of_rate, z, work.z_new)
    _keep(begin, end, work)
    call_normal(tables, address, c, h, gap, rate - of_rate, z, work.z_new)
    _add(begin, end, OF_RATE, of_rate, T, work)


@compiled
def _follow_friction(friction, p, h, slip, N, z, begin, end, T, work):
    """History z[begin:end] of a friction law with the numbers p, by slip and normal force."""
    of_slip, of_N = nudge(slip, slip, LEAST), PART * N
    old, new = part_of(z, begin, end), part_of(work.z_new, begin, end)
    friction(p, h, slip + of_slip, N, old, new)
    _keep(begin, end, work)
    friction(p, h, slip - of_slip, N, old, new)
    _add(begin, end, OF_SLIP, of_slip, T, work)
    if N > 0.0:
        friction(p, h, slip, N + of_N, old, new)
        _keep(begin, end, work)
        friction(p, h, slip, N - of_N, old, new)
        _add(begin, end, OF_NORMAL, of_N, T, work)


@compiled
def _onset_later(h, first, gap, rate, z, dz, own):
    """How much later a contact began whose gap fell through zero in this step: the root of the cubic of `crossing`."""
    gap0, rate0 = z[first + LAST_GAP], z[first + LAST_GAP_RATE]
    s = crossing(h, gap0, rate0, gap, rate)
    _, slope = cubic(s, h, gap0, rate0, gap, rate)
    if slope >= 0.0:
        return 0.0
    of_gap0, of_gap = (1.0 + 2.0 * s) * (1.0 - s) ** 2, s * s * (3.0 - 2.0 * s)
    of_rate0, of_rate = h * s * (1.0 - s) ** 2, h * s * s * (s - 1.0)
    of_last = of_gap0 * dz[first + LAST_GAP] + of_rate0 * dz[first + LAST_GAP_RATE]
    value = of_last + of_gap * own[OF_GAP] + of_rate * own[OF_RATE]
    return -h * value / slope


@compiled
def follow_grip(tables, address, c, h, v, z, T, work):
    """The rest of T.z1 for friction in joint c, from the differences T.q, T.v, T.u; its grip is in work.grip_curve."""
    C, out, H, n_q = tables.constraints, work.grip_out, work.grip_curve, tables.sizes.n_q
    begin, end, slip, N = C.grip_z[c, BEGIN], C.grip_z[c, END], work.grip[c, GRIP_SLIP], work.grip_out[LOAD]
    dofs, rows = part_of(C.dofs, C.dof[c], C.dof[c + 1]), C.row[c + 1] - C.row[c]
    for j in range(T.q.shape[0]):
        of_slip, of_N = 0.0, 0.0
        for i in range(6):
            of_slip += out[SLIDING + i] * T.v[j, dofs[i]]
            for l in range(6):
                of_slip += v[dofs[l]] * H[l, i] * T.q[j, dofs[i]]
        for i in range(rows):
            of_N += out[LOAD_BY_LAM + i] * T.u[j, n_q + C.row[c] + i]
        T.own[j, OF_SLIP], T.own[j, OF_NORMAL] = of_slip, of_N
    friction = friction_at(address.friction, C.grip[c, SLIDING_LAW])
    p = part_of(tables.p, C.grip_p[c, SLIDING_P], C.grip_p[c, SLIDING_P_END])
    _follow_friction(friction, p, h, slip, N, z, begin, end, T, work)


@compiled
def follow_element(tables, address, e, t, h, q, v, a, z, T, work):
    """The rest of T.z1 for element e, from the differences T.q, T.v, T.a: its nodes are moved along them."""
    E = tables.elements
    n, begin, end = E.dof[e + 1] - E.dof[e], E.z[e, BEGIN], E.z[e, END]
    gather_state(E, e, n, q, v, a, work)
    fast = 0.0
    for i in range(n):
        fast = max(fast, abs(work.vl[i]))
    reach = max(MOTION * h * fast, AWAY)
    for j in range(T.q.shape[0]):
        far, quick, strong = _sizes(E, e, n, j, T)
        most = max(far / reach, quick / max(MOTION * fast, AWAY), h * strong / max(MOTION * fast, AWAY))
        if most == 0.0:
            continue
        _move_element(E, e, n, 1.0 / most, j, q, v, a, T, work)
        _force_alone(tables, address, e, n, t, h, z, work)
        _keep(begin, end, work)
        _move_element(E, e, n, -1.0 / most, j, q, v, a, T, work)
        _force_alone(tables, address, e, n, t, h, z, work)
        for l in range(begin, end):
            T.z1[j, l] += (work.z_between[l] - work.z_new[l]) * 0.5 * most


@compiled
def _sizes(E, e, n, j, T):
    """Largest differences of positions, velocities and accelerations of element e."""
    far, quick, strong = 0.0, 0.0, 0.0
    for i in range(n):
        dof = E.dofs[E.dof[e] + i]
        far, quick, strong = max(far, abs(T.q[j, dof])), max(quick, abs(T.v[j, dof])), max(strong, abs(T.a[j, dof]))
    return far, quick, strong


@compiled
def _move_element(E, e, n, eps, j, q, v, a, T, work):
    """Gather the state of element e, moved by eps times difference j."""
    for i in range(n):
        dof = E.dofs[E.dof[e] + i]
        work.ql[i], work.vl[i] = q[dof] + eps * T.q[j, dof], v[dof] + eps * T.v[j, dof]
        work.al[i] = a[dof] + eps * T.a[j, dof]
