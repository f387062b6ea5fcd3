"""Histories in the tangent of a step, their own differences at its end, and friction that turns within it.

Kernels give no derivatives by their histories.  These are central differences of the single law or element, with
differences relative to each number: a gap of 1e-6 m is not lost in coordinates of 1 m.

A law without history turns round within a small slip, which steps leap over or into.  The slopes at both ends then
tell nothing of the change, by which a neighbour, whose slip s turns at another time, gains or loses speed.  With the
secant slope S = (T1 - T0) / (s1 - s0) at both ends, the slips of a neighbour are ds1/ds0 = (ds/dt)_1 / (ds/dt)_0, as
behind a jump of the force.  Accelerations at the end are of the force there.  Equation (14.5) of docs/theory/design.md.
"""

from flexmb import places
from flexmb.engine.compiled.arrays import part_of
from flexmb.engine.system import work as columns
from flexmb.engine.system.constraints import call_joint_friction, call_joint_load
from flexmb.engine.system.contacts import add_tangents, call_friction, call_gap, call_normal, jacobians
from flexmb.engine.system.elements import call_element, call_force, gather_state
from flexmb.kernels import compiled, copy, friction_at
from flexmb.parts.contact.onset import crossing, cubic
from flexmb.program import program as at

FIRST, SECOND = range(2)  # rows of `Tangents.local`
# Columns of `Tangents.own`: differences of gap, gap rate, slip and normal force.
OF_GAP, OF_RATE, OF_SLIP, OF_NORMAL = range(4)
# Difference of a number: relative to the number, and least difference for numbers near 0.
RELATIVE_DIFFERENCE, LEAST_DIFFERENCE = 1e-5, 1e-11
# Differences for friction with histories: of the history in a joint over the slip of a step; of a load over itself.
PART_OF_SLIP, PART_OF_LOAD = 0.1, 1e-8
# Difference of the nodes of an element: relative to their motion in a step, and least difference [m, rad].
NODE_DIFFERENCE, LEAST_NODE_DIFFERENCE = 1e-3, 1e-9


@compiled
def difference_step(x, other, least):
    """Difference for a number with the values x and `other`."""
    size = RELATIVE_DIFFERENCE * max(abs(x), abs(other))
    return size if size > least else LEAST_DIFFERENCE


@compiled
def _add_difference(begin, end, changes, eps, T, work):
    """Add the effect of `changes` (k,) of a number to T.z1, by work.z_between and work.z_new at plus and minus eps."""
    for j in range(T.z.shape[0]):
        part = changes[j] / (2.0 * eps)
        for l in range(begin, end):
            T.z1[j, l] += (work.z_between[l] - work.z_new[l]) * part


@compiled
def _store_upper_side(begin, end, work):
    """Copy work.z_new to work.z_between, from begin to end."""
    copy(part_of(work.z_new, begin, end), part_of(work.z_between, begin, end))


@compiled
def element_force(tables, address, e, n, t, h, z, work):
    """Evaluate force and history of element e at the gathered state, in work.rl and work.z_new."""
    for i in range(n):
        work.rl[i] = 0.0
    if tables.elements.force[e] >= 0:
        call_force(tables, address, e, n, t, h, z, work)
    else:
        call_element(tables, address, e, n, t, h, z, work)


@compiled
def add_element_history(tables, address, e, n, t, h, s, z, T, work):
    """Add the effect of the histories of element e to T.F and T.z1; s : load factor."""
    E = tables.elements
    begin, end, force = E.z[e, at.BEGIN], E.z[e, at.END], T.local[SECOND]
    dofs = part_of(E.dofs, E.dof[e], E.dof[e + 1])
    for i in range(begin, end):
        if not T.z[:, i].any():
            continue
        eps = difference_step(z[i], work.z_new[i], LEAST_DIFFERENCE)
        T.zs[i] = z[i] + eps
        element_force(tables, address, e, n, t, h, T.zs, work)
        _store_upper_side(begin, end, work)
        copy(part_of(work.rl, 0, n), part_of(force, 0, n))
        T.zs[i] = z[i] - eps
        element_force(tables, address, e, n, t, h, T.zs, work)
        T.zs[i] = z[i]
        _add_difference(begin, end, T.z[:, i], eps, T, work)
        for j in range(T.z.shape[0]):
            part = s * T.z[j, i] / (2.0 * eps)
            for l in range(n):
                T.F[j, dofs[l]] -= (force[l] - work.rl[l]) * part


@compiled
def add_contact_history(tables, address, c, h, z, T, work):
    """Add the effect of the histories of contact c to T.F and T.z1; store the differences of its forces in T.N, T.T."""
    K, out = tables.contacts, work.contact[c]
    begin, middle, end = K.z[c, at.NORMAL_Z], K.z[c, at.FRICTION_Z], K.z[c, at.Z_END]
    gap, rate, slip, load = out[places.GAP], out[places.GAP_RATE], out[places.SLIP], out[places.NORMAL_FORCE]
    for i in range(begin, end):
        if not T.z[:, i].any():
            continue
        normal, first, last = i < middle, begin if i < middle else middle, middle if i < middle else end
        eps = difference_step(z[i], z[i], 0.0) if normal else difference_step(z[i], h * slip, LEAST_DIFFERENCE)
        change = 0.0
        for side in range(2):
            T.zs[i] = z[i] + eps if side == 0 else z[i] - eps
            if normal:
                force, _, _ = call_normal(tables, address, c, h, gap, rate, T.zs, work.z_new)
            else:
                force, _, _ = call_friction(tables, address, c, h, slip, load, T.zs, work.z_new)
            change = force if side == 0 else change - force
            if side == 0:
                _store_upper_side(first, last, work)
        T.zs[i] = z[i]
        _add_difference(first, last, T.z[:, i], eps, T, work)
        for j in range(T.z.shape[0]):
            target = T.N if normal else T.T
            target[j, c] += change * T.z[j, i] / (2.0 * eps)
    S = work.contact_scratch
    jacobians(out, S)
    slopes, by = work.slopes[c], T.by.contact
    for j in range(T.z.shape[0]):
        N, friction = T.N[j, c], T.T[j, c]
        if 3 * j < by.shape[0]:  # parameters
            N += slopes[columns.N_BY_GAP] * by[3 * j + OF_GAP, c] + slopes[columns.N_BY_RATE] * by[3 * j + OF_RATE, c]
            friction += slopes[columns.T_BY_SLIP] * by[3 * j + OF_SLIP, c]
        friction += slopes[columns.T_BY_N] * N
        for i in range(6):
            T.F[j, K.dofs[6 * c + i]] += S[places.NORMAL, i] * N + S[places.TANGENTIAL, i] * friction


@compiled
def add_joint_friction_history(tables, address, c, h, z, T, work):
    """Add the effect of the histories of friction in joint c to T.F and T.z1."""
    C = tables.constraints
    begin, end = C.joint_friction_z[c, at.BEGIN], C.joint_friction_z[c, at.END]
    slip, N = work.joint_friction[c, columns.JOINT_SLIP], work.joint_friction_out[places.LOAD]
    for i in range(begin, end):
        if not T.z[:, i].any():
            continue
        eps = max(min(RELATIVE_DIFFERENCE * abs(z[i]), PART_OF_SLIP * abs(h * slip)), LEAST_DIFFERENCE)
        T.zs[i] = z[i] + eps
        more, _, _ = call_joint_friction(tables, address, c, h, slip, N, T.zs, work.z_new)
        _store_upper_side(begin, end, work)
        T.zs[i] = z[i] - eps
        less, _, _ = call_joint_friction(tables, address, c, h, slip, N, T.zs, work.z_new)
        T.zs[i] = z[i]
        _add_difference(begin, end, T.z[:, i], eps, T, work)
        for j in range(T.z.shape[0]):
            force = (more - less) * T.z[j, i] / (2.0 * eps)
            for l in range(6):
                T.F[j, C.dofs[C.dof[c] + l]] += T.slip_direction[c, l] * force


@compiled
def advance_contact_history(tables, address, c, h, v, z, T, work):
    """Complete T.z1 for contact c by the differences T.q, T.v at the end of the step."""
    K, out = tables.contacts, work.contact[c]
    first, begin, middle, end = K.z[c, at.COMMON_Z], K.z[c, at.NORMAL_Z], K.z[c, at.FRICTION_Z], K.z[c, at.Z_END]
    contact_differences(K, c, out, v, T, work)
    if middle > begin:
        # Effect of gap and gap rate on the history of the normal law.
        gap, rate = out[places.GAP], out[places.GAP_RATE]
        of_gap, of_rate = difference_step(gap, gap, 0.0), difference_step(rate, z[first + at.LAST_GAP_RATE], 0.0)
        call_normal(tables, address, c, h, gap + of_gap, rate, z, work.z_new)
        _store_upper_side(begin, middle, work)
        call_normal(tables, address, c, h, gap - of_gap, rate, z, work.z_new)
        _add_difference(begin, middle, T.own[:, OF_GAP], of_gap, T, work)
        call_normal(tables, address, c, h, gap, rate + of_rate, z, work.z_new)
        _store_upper_side(begin, middle, work)
        call_normal(tables, address, c, h, gap, rate - of_rate, z, work.z_new)
        _add_difference(begin, middle, T.own[:, OF_RATE], of_rate, T, work)
    if end > middle:
        friction = friction_at(address.friction, K.kernel[c, at.FRICTION_LAW])
        p = part_of(tables.p, K.p[c, at.FRICTION_P], K.p[c, at.FRICTION_P_END])
        _advance_friction(friction, p, h, out[places.SLIP], out[places.NORMAL_FORCE], z, middle, end, T, work)
    closing = z[first + at.PHASE] == 0.0 and out[places.GAP] <= 0.0 < z[first + at.LAST_GAP] and h > 0.0
    for j in range(T.z.shape[0]):
        own, later = T.own[j], T.z[j, first + at.ONSET_TIME]
        if closing:
            later = _onset_delay(h, first, out[places.GAP], out[places.GAP_RATE], z, T.z[j], own)
        T.z1[j, first + at.PHASE], T.z1[j, first + at.ONSET_TIME] = 0.0, later
        T.z1[j, first + at.LAST_GAP], T.z1[j, first + at.LAST_GAP_RATE] = own[OF_GAP], own[OF_RATE]
        T.z1[j, first + at.LAST_FORCE] = own[OF_NORMAL]


@compiled
def contact_differences(K, c, out, v, T, work):
    """Set T.own (k, 4): differences of gap, gap rate, slip and normal force of contact c, whose gap data are `out`."""
    slopes, S, by = work.slopes[c], work.contact_scratch, T.local
    explicit, dofs = T.by.contact, part_of(K.dofs, 6 * c, 6 * c + 6)
    jacobians(out, S)
    for i in range(6):
        work.vl[i] = v[dofs[i]]
    _rate_derivatives(out, work.vl, by)
    for j in range(T.q.shape[0]):
        gap, rate, slip = 0.0, 0.0, 0.0
        if 3 * j < explicit.shape[0]:  # parameters
            gap, rate = explicit[3 * j + OF_GAP, c], explicit[3 * j + OF_RATE, c]
            slip = explicit[3 * j + OF_SLIP, c]
        for i in range(6):
            dq, dv = T.q[j, dofs[i]], T.v[j, dofs[i]]
            gap += S[places.NORMAL, i] * dq
            rate += S[places.NORMAL, i] * dv + by[places.NORMAL, i] * dq
            slip += S[places.TANGENTIAL, i] * dv + by[places.TANGENTIAL, i] * dq
        T.own[j, OF_GAP], T.own[j, OF_RATE], T.own[j, OF_SLIP] = gap, rate, slip
        T.own[j, OF_NORMAL] = slopes[columns.N_BY_GAP] * gap + slopes[columns.N_BY_RATE] * rate + T.N[j, c]


@compiled
def _rate_derivatives(out, v, by):
    """Set rows NORMAL and TANGENTIAL of `by`: derivatives of J_n v and J_t v by the six coordinates."""
    nx, ny = out[places.NORMAL_X], out[places.NORMAL_Y]
    ax, ay, bx, by_ = out[places.ARM1_X], out[places.ARM1_Y], out[places.ARM2_X], out[places.ARM2_Y]
    for j in range(6):
        x, y = out[places.NORMAL_X_Q + j], out[places.NORMAL_Y_Q + j]
        axq, ayq = out[places.ARM1_X_Q + j], out[places.ARM1_Y_Q + j]
        bxq, byq = out[places.ARM2_X_Q + j], out[places.ARM2_Y_Q + j]
        arm1, arm2 = y * ax - x * ay + ny * axq - nx * ayq, y * bx - x * by_ + ny * bxq - nx * byq
        by[places.NORMAL, j] = x * (v[0] - v[3]) + y * (v[1] - v[4]) + arm1 * v[2] - arm2 * v[5]
        along1, along2 = x * ax + y * ay + nx * axq + ny * ayq, x * bx + y * by_ + nx * bxq + ny * byq
        by[places.TANGENTIAL, j] = y * (v[0] - v[3]) - x * (v[1] - v[4]) - along1 * v[2] + along2 * v[5]


@compiled
def _advance_friction(friction, p, h, slip, N, z, begin, end, T, work):
    """History z[begin:end] of a friction law with the numbers p, by slip and normal force."""
    of_slip, of_N = difference_step(slip, slip, LEAST_DIFFERENCE), PART_OF_LOAD * abs(N)
    old, new = part_of(z, begin, end), part_of(work.z_new, begin, end)
    friction(p, h, slip + of_slip, N, old, new)
    _store_upper_side(begin, end, work)
    friction(p, h, slip - of_slip, N, old, new)
    _add_difference(begin, end, T.own[:, OF_SLIP], of_slip, T, work)
    if of_N > 0.0:
        friction(p, h, slip, N + of_N, old, new)
        _store_upper_side(begin, end, work)
        friction(p, h, slip, N - of_N, old, new)
        _add_difference(begin, end, T.own[:, OF_NORMAL], of_N, T, work)


@compiled
def _onset_delay(h, first, gap, rate, z, dz, own):
    """Difference of the onset time of a contact in this step [s], by the root of the cubic of `crossing`."""
    gap0, rate0 = z[first + at.LAST_GAP], z[first + at.LAST_GAP_RATE]
    s = crossing(h, gap0, rate0, gap, rate)
    _, slope = cubic(s, h, gap0, rate0, gap, rate)
    if slope >= 0.0:
        return 0.0
    of_gap0, of_gap = (1.0 + 2.0 * s) * (1.0 - s) ** 2, s * s * (3.0 - 2.0 * s)
    of_rate0, of_rate = h * s * (1.0 - s) ** 2, h * s * s * (s - 1.0)
    of_last = of_gap0 * dz[first + at.LAST_GAP] + of_rate0 * dz[first + at.LAST_GAP_RATE]
    return -h * (of_last + of_gap * own[OF_GAP] + of_rate * own[OF_RATE]) / slope


@compiled
def find_joint_load(tables, address, c, q, lam, work):
    """Call the load kernel of friction in joint c."""
    C = tables.constraints
    n = C.dof[c + 1] - C.dof[c]
    columns.gather(q, C.dofs, C.dof[c], n, work.ql)
    call_joint_load(tables, address, c, n, lam, work)


@compiled
def joint_differences(tables, c, v, T, work):
    """Set slip and normal force in T.own for joint c, whose load kernel has been called, by T.q, T.v, T.u."""
    C, out, H, n_q = tables.constraints, work.joint_friction_out, work.joint_friction_curve, tables.sizes.n_q
    dofs, rows = part_of(C.dofs, C.dof[c], C.dof[c + 1]), C.row[c + 1] - C.row[c]
    for j in range(T.q.shape[0]):
        of_slip, of_N = 0.0, 0.0
        for i in range(6):
            of_slip += out[places.SLIDING + i] * T.v[j, dofs[i]]
            of_N += out[places.LOAD_BY_Q + i] * T.q[j, dofs[i]]
            for l in range(6):
                of_slip += v[dofs[l]] * H[l, i] * T.q[j, dofs[i]]
        for i in range(rows):
            of_N += out[places.LOAD_BY_LAM + i] * T.u[j, n_q + C.row[c] + i]
        T.own[j, OF_SLIP], T.own[j, OF_NORMAL] = of_slip, of_N


@compiled
def advance_joint_friction_history(tables, address, c, h, q, v, lam, z, T, work):
    """Complete T.z1 for friction in joint c by the differences T.q, T.v, T.u at the end of the step."""
    C = tables.constraints
    find_joint_load(tables, address, c, q, lam, work)
    joint_differences(tables, c, v, T, work)
    friction = friction_at(address.friction, C.joint_friction[c, at.SLIDING_LAW])
    p = part_of(tables.p, C.joint_friction_p[c, at.SLIDING_P], C.joint_friction_p[c, at.SLIDING_P_END])
    slip, N = work.joint_friction[c, columns.JOINT_SLIP], work.joint_friction_out[places.LOAD]
    begin, end = C.joint_friction_z[c, at.BEGIN], C.joint_friction_z[c, at.END]
    _advance_friction(friction, p, h, slip, N, z, begin, end, T, work)


@compiled
def advance_element_history(tables, address, e, t, h, q, v, a, z, T, work):
    """Complete T.z1 for element e by differences of its state along T.q, T.v, T.a."""
    E = tables.elements
    n, begin, end = E.dof[e + 1] - E.dof[e], E.z[e, at.BEGIN], E.z[e, at.END]
    gather_state(E, e, n, q, v, a, work)
    fast = 0.0
    for i in range(n):
        fast = max(fast, abs(work.vl[i]))
    reach = max(NODE_DIFFERENCE * h * fast, LEAST_NODE_DIFFERENCE)
    rate = max(NODE_DIFFERENCE * fast, LEAST_NODE_DIFFERENCE)
    for j in range(T.q.shape[0]):
        far, quick, strong = 0.0, 0.0, 0.0
        for dof in part_of(E.dofs, E.dof[e], E.dof[e + 1]):
            far, quick, strong = max(far, abs(T.q[j, dof])), max(quick, abs(T.v[j, dof])), max(strong, abs(T.a[j, dof]))
        most = max(far / reach, quick / rate, h * strong / rate)
        if most == 0.0:
            continue
        _move_element(E, e, n, 1.0 / most, j, q, v, a, T, work)
        element_force(tables, address, e, n, t, h, z, work)
        _store_upper_side(begin, end, work)
        _move_element(E, e, n, -1.0 / most, j, q, v, a, T, work)
        element_force(tables, address, e, n, t, h, z, work)
        for l in range(begin, end):
            T.z1[j, l] += (work.z_between[l] - work.z_new[l]) * 0.5 * most


@compiled
def _move_element(E, e, n, eps, j, q, v, a, T, work):
    """Gather the state of element e plus eps times difference j."""
    for i in range(n):
        dof = E.dofs[E.dof[e] + i]
        work.ql[i], work.vl[i] = q[dof] + eps * T.q[j, dof], v[dof] + eps * T.v[j, dof]
        work.al[i] = a[dof] + eps * T.a[j, dof]


# Columns of `Tangents.turn` [N s/m]: forces at the end of the step by the slip at its start, and by that at its end
# beside the slope of the law; what of that the accelerations at the end leave out; the slope that they have, kept.
STARTING, ENDING, EXCESS, CARRIED = range(4)
# Change of a friction force within a step that its slopes at both ends do not tell, relative to the force; largest
# slope in accelerations, relative to the secant: beyond it, differences leave the slip within which the law turns.
PART_OF_FRICTION, STEEPEST = 1e-3, 10.0


@compiled
def find_turns(tables, address, h, share, q, v, lam, T, work):
    """Find the friction without history that turns in a step of size h; put its secant slopes into work.lu."""
    # share : part of the step for which a force at its end acts. Contacts and constraints are evaluated at q, v, lam.
    K, C = tables.contacts, tables.constraints
    for c in range(K.kernel.shape[0]):
        out, slopes = work.contact[c], work.slopes[c]
        if K.z[c, at.Z_END] > K.z[c, at.FRICTION_Z] or out[places.FRICTION_FORCE] == 0.0:
            T.turn[c, :] = 0.0
            continue
        slip = _slip_before(tables, address, c, T, work)
        before, slope, _ = call_friction(tables, address, c, h, slip, out[places.NORMAL_FORCE], T.start.z, work.z_new)
        force, after, turn = out[places.FRICTION_FORCE], out[places.SLIP], T.turn[c]
        if not _turns(slip, before, slope, after, force, slopes[columns.T_BY_SLIP], share, turn):
            continue
        slopes[columns.T_BY_SLIP] += turn[ENDING]
        columns.gather(v, K.dofs, 6 * c, 6, work.vl)
        jacobians(out, work.contact_scratch)
        positions = part_of(K.positions, 36 * c, 36 * c + 36)
        add_tangents(out, positions, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, turn[ENDING], 0.0, work)
    for c in range(C.kernel.shape[0]):
        k = K.kernel.shape[0] + c
        force, after = work.joint_friction[c, columns.JOINT_FRICTION_FORCE], work.joint_friction[c, columns.JOINT_SLIP]
        if C.joint_friction[c, at.LOAD_KERNEL] < 0 or C.joint_friction_z[c, at.END] > C.joint_friction_z[c, at.BEGIN]:
            continue
        # Slip at the start of the step, for which the load kernel is called.
        find_joint_load(tables, address, c, T.start.q, T.start.lam, work)
        slip, out = 0.0, work.joint_friction_out
        for i in range(6):
            slip += out[places.SLIDING + i] * T.start.v[C.dofs[C.dof[c] + i]]
        find_joint_load(tables, address, c, q, lam, work)
        before, slope, _ = call_joint_friction(tables, address, c, h, slip, out[places.LOAD], T.start.z, work.z_new)
        if _turns(slip, before, slope, after, force, work.slopes[k, columns.JOINT_T_BY_SLIP], share, T.turn[k]):
            _add_joint_turn(C, c, v, T.turn[k, ENDING], work)


@compiled
def _slip_before(tables, address, c, T, work):
    """Slip of contact c at the start of the step; its gap data are in work.gap."""
    columns.gather(T.start.q, tables.contacts.dofs, 6 * c, 6, work.ql)
    columns.gather(T.start.v, tables.contacts.dofs, 6 * c, 6, work.vl)
    call_gap(tables, address, c, work.ql, work.vl, True, None, work.gap)
    return work.gap[places.SLIP]


@compiled
def _turns(slip0, T0, slope0, slip1, T1, slope1, share, turn):
    """Whether the slopes at start and end miss a part of the change from T0 to T1; sets `turn`."""
    if turn[CARRIED] != 0.0:
        slope0 = turn[CARRIED]
    turn[:] = 0.0
    change, far = T1 - T0, slip1 - slip0
    missed = change - ((1.0 - share) * slope0 + share * slope1) * far
    if abs(missed) <= PART_OF_FRICTION * max(abs(T0), abs(T1)) or far == 0.0:
        return False
    secant = change / far
    steepest = STEEPEST * abs(secant)
    turn[STARTING], turn[ENDING] = (1.0 - share) / share * (secant - slope0), secant - slope1
    turn[CARRIED] = min(max(slope1, -steepest), steepest)
    turn[EXCESS] = secant - turn[CARRIED]
    return True


@compiled
def _add_joint_turn(C, c, v, slope, work):
    """Add the effect of a further slope of friction in joint c, by its coordinates, to work.lu."""
    n, begin, out = C.dof[c + 1] - C.dof[c], C.dof[c], work.joint_friction_out
    for j in range(6):
        slip_q = 0.0
        for k in range(6):
            slip_q += work.joint_friction_curve[k, j] * v[C.dofs[begin + k]]
        for i in range(6):
            work.lu[C.positions_h[C.pos_h[c] + n * i + j]] -= out[places.SLIDING + i] * slope * slip_q


@compiled
def add_turns(tables, address, T, work):
    """Add the forces by the slips at the start to T.F and T.turned, and secant slopes of joints to work.slopes."""
    # T.q, T.v are of the start.
    n_k = tables.contacts.kernel.shape[0]
    for k in range(T.turn.shape[0]):
        if T.turn[k, STARTING] == 0.0 and T.turn[k, ENDING] == 0.0:
            continue
        if k < n_k:
            _slip_before(tables, address, k, T, work)
            contact_differences(tables.contacts, k, work.gap, T.start.v, T, work)
        else:
            find_joint_load(tables, address, k - n_k, T.start.q, T.start.lam, work)
            joint_differences(tables, k - n_k, T.start.v, T, work)
            work.slopes[k, columns.JOINT_T_BY_SLIP] += T.turn[k, ENDING]
        for j in range(T.q.shape[0]):
            T.turned[j, k] = T.turn[k, STARTING] * T.own[j, OF_SLIP]
    for j in range(T.q.shape[0]):
        add_turned(tables, j, T.F[j], T, work)


@compiled
def complete_turned(tables, address, q, v, lam, T, work):
    """Add the forces by the slips at the end to T.turned; T.q, T.v are of the end."""
    n_k = tables.contacts.kernel.shape[0]
    for k in range(T.turn.shape[0]):
        if T.turn[k, EXCESS] == 0.0:
            continue
        if k < n_k:
            contact_differences(tables.contacts, k, work.contact[k], v, T, work)
        else:
            find_joint_load(tables, address, k - n_k, q, lam, work)
            joint_differences(tables, k - n_k, v, T, work)
        for j in range(T.q.shape[0]):
            T.turned[j, k] += T.turn[k, EXCESS] * T.own[j, OF_SLIP]


@compiled
def add_turned(tables, j, F, T, work):
    """Add the forces in T.turned of neighbour j to F (n_q + 3,); contacts and joints are evaluated there."""
    K, C = tables.contacts, tables.constraints
    n_k = K.kernel.shape[0]
    for k in range(T.turn.shape[0]):
        if T.turn[k, STARTING] == 0.0 and T.turn[k, ENDING] == 0.0:
            continue
        if k < n_k:
            jacobians(work.contact[k], work.contact_scratch)
        for i in range(6):
            if k < n_k:
                F[K.dofs[6 * k + i]] += work.contact_scratch[places.TANGENTIAL, i] * T.turned[j, k]
            else:
                F[C.dofs[C.dof[k - n_k] + i]] += T.slip_direction[k - n_k, i] * T.turned[j, k]
