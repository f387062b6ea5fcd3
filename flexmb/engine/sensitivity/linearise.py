"""Linearised forces at a state, times small differences of the state, for the tangent of a step.

With dq = U + u, dv = X + kv u and da = Y + ka u for unknown u beside predicted differences, the forces change by
    A u + K U + C X + M Y + (dr/dz) dz,   A = K + kv C + ka M.
`linearise` evaluates all terms in one pass over elements, contacts and constraints.  Matrices come from the kernels, so
that stiff elements lose no digits; derivatives by histories are central differences of single laws or elements.
"""

import numpy as np

from flexmb.engine.compiled.arrays import matrix_view, part_of
from flexmb.engine.compiled.pieces import whole
from flexmb.engine.compiled.records import Integers, IntegerTable, Matrix, Record, Vector
from flexmb.engine.radau.collocation import StateVectors, state_vectors
from flexmb.engine.sensitivity import histories, parameters
from flexmb.engine.sensitivity.signal_rows import SignalRows, signal_rows
from flexmb.engine.system.constraints import add_constraints
from flexmb.engine.system.contacts import add_contacts, add_tangents, jacobians
from flexmb.engine.system.elements import add_elements, call_element, call_tangent, gather_state, load_factor
from flexmb.engine.system.work import JOINT_T_BY_SLIP, N_BY_GAP, N_BY_RATE, T_BY_N, T_BY_SLIP, gather, turn_nodes
from flexmb.kernels import compiled, constraint_at, copy
from flexmb.places import FRICTION_FORCE, NORMAL, NORMAL_FORCE, SLIDING, TANGENTIAL
from flexmb.program.program import BEGIN, END, FIRST_OUTPUT, LOAD_KERNEL, NO_FACTOR, Program

SPEED, ACCELERATION = range(2)  # rows of `Tangents.moving`: G v, and G a + W v
PLACE, ROW, COLUMN = range(3)  # columns of `Tangents.entries`
RESIDUAL, RATE, RIGHT_SIDE = range(3)  # rows of `Tangents.g`: g, g_t and gamma of constraint kernels
TIME_DIFFERENCE = 0.01  # time difference for the derivative of loads by time, over the step size
# Difference of the pose for dG/dt along the motion [rad, or relative to the size of the mechanism].
POSE_DIFFERENCE = 1e-5
# Decorator `compiled` without inlining, for long functions with several callers.
apart = whole(error_model="numpy", _nrt=False)


class CarriedStep(Record):
    """Times of the step that differences are carried through."""

    start: float  # start of the step [s]
    before: float  # size of the step before [s], 0: this was a starting step
    last: float  # size of this step [s], 0: a starting step follows


class Tangents(Record):
    """Differences of k neighbouring states, with the arrays that carry them through a step; one row per difference."""

    q: Matrix  # q, v, a, x, z: (k, n_q + 3), z (k, n_z) differences of the state
    v: Matrix
    a: Matrix
    x: Matrix
    z: Matrix
    z1: Matrix  # differences of the histories at the end of the step
    # U, X, Y, R: (k, n_q + 3) predicted differences of positions, velocities, accelerations, auxiliary accelerations
    U: Matrix
    X: Matrix
    Y: Matrix
    R: Matrix
    F: Matrix  # (k, n_q + 3) - (K U + C X + M Y + (dr/dz) dz)
    u: Matrix  # (k, n_q + n_c) differences of positions and multipliers
    moved: Matrix  # (k, n_q) differences of positions beside U
    gap: Vector  # (n_c,) G times `moved`
    entries: IntegerTable  # (n, 3) places in the matrix of contacts and of H, their rows and columns
    N: Matrix  # N, T: (k, contacts) differences of normal and friction force by histories alone
    T: Matrix
    D: Vector  # kv C + ka M of all elements, one after the other
    W: Vector  # dG/dt, as `Work.G`
    slip_direction: Matrix  # (joints, 6) direction of the slip in joints with friction
    b: Vector  # b, d, e, y, seen: (n_q + n_c,) vectors of the linear system
    d: Vector
    e: Vector
    y: Vector
    seen: Vector
    r: Vector  # r, f: (n_q + 3,) motions and forces
    f: Vector
    local: Matrix  # vectors of one element or contact
    own: Matrix  # (k, 4) differences of gap, gap rate, slip and normal force
    g: Matrix  # (3, n_c) outputs of constraint kernels beside G
    zs: Vector  # (n_z,) varied histories
    tau: Vector  # (k,) time shift of each neighbour [s]
    shift: Vector  # (k,) increment of tau [s]
    start: StateVectors  # state before the step
    ap: Vector  # ap, zp: state before the step before
    zp: Vector
    rt: Vector  # (n_q + 3,) rate of the forces in time at rest
    moving: Matrix  # (2, n_c) G v, and G a + W v
    step: CarriedStep
    control: parameters.ControlSlopes  # slopes of controllers
    by: parameters.ParameterRates  # directions of the parameters to which the first differences belong
    rows: SignalRows  # derivatives of signals
    closing: Integers  # (contacts,) 1 for a contact that begins at the very end of the step
    turn: Matrix  # (contacts + joints, 4) slopes of friction that turned in this step, see `find_turns`
    turned: Matrix  # (k, contacts + joints) forces of that friction beside those of the law


def new_tangents(
    program: Program, k: int, by: parameters.ParameterRates | None = None, signals: SignalRows | None = None
) -> Tangents:
    """Arrays for k differences of states of a compiled mechanism, with the directions and rows of k parameters."""
    tables, n, m = program.tables, program.n_q + 3, program.n_c
    n_z, n_k, n_g = tables.sizes.n_z, len(tables.contacts.kernel), len(tables.constraints.kernel)
    total, pattern = program.n_q + m, program.symbolic
    wanted = np.unique(np.concatenate([tables.contacts.positions, tables.constraints.positions_h]).astype(np.int64))
    every = np.stack([pattern.places, pattern.a_rows, pattern.a_cols], axis=1).astype(np.int64)
    entries = every[np.isin(every[:, PLACE], wanted) & (every[:, ROW:] < program.n_q).all(axis=1)]
    rows, mean = dict.fromkeys(("q", "v", "a", "x", "U", "X", "Y", "R", "F"), (k, n)), max(tables.sizes.most_dofs, 6)
    rows |= dict.fromkeys(("z", "z1"), (k, n_z)) | dict.fromkeys(("N", "T"), (k, n_k))
    vectors = dict.fromkeys(("b", "d", "e", "y", "seen"), total) | dict.fromkeys(("zs", "zp"), n_z)
    vectors |= dict.fromkeys(("r", "f", "ap", "rt"), n) | dict.fromkeys(("tau", "shift"), k)
    return Tangents(
        **rows, **vectors, step=CarriedStep(0.0, 0.0, 0.0), control=parameters.control_slopes(program),
        by=parameters.parameter_rates(program, np.zeros((0, len(tables.p))), np.zeros(0)) if by is None else by,
        rows=signal_rows(program, 0) if signals is None else signals, u=(k, total), moved=(k, program.n_q), gap=m,
        entries=entries, D=tables.elements.pos[-1], W=tables.constraints.pos_g[-1], slip_direction=(n_g, 6),
        local=(2, mean), own=(k, 4), g=(3, m), start=state_vectors(program), moving=(2, m),
        closing=np.zeros(n_k, dtype=np.int64), turn=(n_k + n_g, 4), turned=(k, n_k + n_g),
    )  # fmt: skip


@apart
def linearise(tables, address, t, h, q, v, a, lam, z, kv, ka, T, work):
    """Fill work.lu with [[A, G^T], [G, 0]], T.F with -(K U + C X + M Y + (dr/dz) dz), T.z1 with the effect of T.z."""
    # q, v, a : (n_q + 3,); z : history a time h before. Friction in joints is in A and beside G^T as in `evaluate`.
    work.r[:] = work.Gl[:] = work.lu[:] = 0.0
    T.F[:, :] = T.N[:, :] = T.T[:, :] = T.z1[:, :] = 0.0
    copy(z, T.zs)
    turn_nodes(tables, q, work)
    add_contacts(tables, address, t, h, q, v, z, 1.0, 0.0, True, work)
    for c in range(tables.contacts.kernel.shape[0]):
        if T.closing[c] != 0:
            _open_contact(tables, c, q, v, work)
    add_constraints(tables, address, t, h, q, v, lam, z, 1.0, 0.0, True, work)
    if kv > 0.0:
        histories.find_turns(tables, address, h, kv / (ka * h), q, v, lam, T, work)
    _subtract_stiffness(T, work)
    if tables.controls.kernel.shape[0] > 0:
        parameters.find_control_slopes(tables, address, t, q, v, a, z, ka, T, work)
    _add_elements(tables, address, t, h, q, v, a, z, kv, ka, T, work)
    if tables.controls.kernel.shape[0] > 0:
        parameters.add_control_forces(tables, address, t, q, v, a, z, T, work)
        parameters.add_control_matrix(tables, kv, T, work)
    if T.by.step.shape[0] > 0:
        parameters.add_parameters(tables, address, t, h, q, v, a, lam, z, T, work)
    for c in range(tables.contacts.kernel.shape[0]):
        histories.add_contact_history(tables, address, c, h, z, T, work)
    for c in range(tables.constraints.kernel.shape[0]):
        if tables.constraints.joint_friction[c, LOAD_KERNEL] >= 0:
            histories.find_joint_load(tables, address, c, q, lam, work)
            copy(part_of(work.joint_friction_out, SLIDING, SLIDING + 6), T.slip_direction[c])
            histories.add_joint_friction_history(tables, address, c, h, z, T, work)
    if kv > 0.0:
        histories.add_turns(tables, address, T, work)
    for j in range(T.q.shape[0]):
        subtract_damping(tables, 1.0, T.X[j], T.F[j], T, work)
    _add_damping(tables, kv, T, work)


@compiled
def _subtract_stiffness(T, work):
    """F -= K U with the stiffness of contacts and constraints in work.lu."""
    for k in range(T.entries.shape[0]):
        value, row, column = work.lu[T.entries[k, PLACE]], T.entries[k, ROW], T.entries[k, COLUMN]
        for j in range(T.U.shape[0]):
            T.F[j, row] -= value * T.U[j, column]


@compiled
def _add_damping(tables, kv, T, work):
    """Add kv C of contacts and of friction in joints to work.lu."""
    K, C, S = tables.contacts, tables.constraints, work.contact_scratch
    for c in range(K.kernel.shape[0]):
        slopes, positions = work.slopes[c], part_of(K.positions, 36 * c, 36 * c + 36)
        if slopes[N_BY_RATE] == 0.0 and slopes[T_BY_SLIP] == 0.0:
            continue
        jacobians(work.contact[c], S)
        for j in range(6):
            N = kv * slopes[N_BY_RATE] * S[NORMAL, j]
            friction = slopes[T_BY_N] * N + kv * slopes[T_BY_SLIP] * S[TANGENTIAL, j]
            for i in range(6):
                work.lu[positions[6 * i + j]] -= S[NORMAL, i] * N + S[TANGENTIAL, i] * friction
    for c in range(C.kernel.shape[0]):
        if C.joint_friction[c, LOAD_KERNEL] >= 0:
            n, slope = C.dof[c + 1] - C.dof[c], kv * work.slopes[K.kernel.shape[0] + c, JOINT_T_BY_SLIP]
            for i in range(6):
                for j in range(6):
                    entry = T.slip_direction[c, i] * slope * T.slip_direction[c, j]
                    work.lu[C.positions_h[C.pos_h[c] + n * i + j]] -= entry


@compiled
def _open_contact(tables, c, q, v, work):
    """Take the tangents of contact c out of work.lu."""
    K, out, slopes = tables.contacts, work.contact[c], work.slopes[c]
    gather(q, K.dofs, 6 * c, 6, work.ql)
    gather(v, K.dofs, 6 * c, 6, work.vl)
    jacobians(out, work.contact_scratch)
    positions, N, T = part_of(K.positions, 36 * c, 36 * c + 36), out[NORMAL_FORCE], out[FRICTION_FORCE]
    by_gap, by_rate, by_slip, by_N = slopes[N_BY_GAP], slopes[N_BY_RATE], slopes[T_BY_SLIP], slopes[T_BY_N]
    add_tangents(out, positions, -1.0, 0.0, N, T, by_gap, by_rate, by_slip, by_N, work)
    slopes[:] = 0.0


@compiled
def _add_elements(tables, address, t, h, q, v, a, z, kv, ka, T, work):
    """Add A of all elements to work.lu and their terms to T.F; store kv C + ka M in T.D."""
    E = tables.elements
    for e in range(E.p.shape[0]):
        n = E.dof[e + 1] - E.dof[e]
        gather_state(E, e, n, q, v, a, work)
        s = load_factor(tables, address, e, t, work)
        D, positions = part_of(T.D, E.pos[e], E.pos[e + 1]), part_of(E.positions, E.pos[e], E.pos[e + 1])
        if E.kernel[e] >= 0:
            call_element(tables, address, e, n, t, h, z, work)
            _subtract_product(E, e, n, s, work.Cl, T.X, T.F)
            _subtract_product(E, e, n, s, work.Ml, T.Y, T.F)
            _subtract_product(E, e, n, s, work.Kl, T.U, T.F)
            for i in range(n * n):
                D[i] = s * (kv * work.Cl[i] + ka * work.Ml[i])
                work.lu[positions[i]] += s * work.Kl[i] + D[i]
        else:
            call_tangent(tables, address, e, n, t, h, z, 0.0, 1.0, 0.0, work)
            _subtract_product(E, e, n, s, work.Kl, T.X, T.F)
            for i in range(n * n):
                D[i] = s * kv * work.Kl[i]
            call_tangent(tables, address, e, n, t, h, z, 0.0, 0.0, 1.0, work)
            _subtract_product(E, e, n, s, work.Kl, T.Y, T.F)
            for i in range(n * n):
                D[i] += s * ka * work.Kl[i]
            call_tangent(tables, address, e, n, t, h, z, 1.0, 0.0, 0.0, work)
            _subtract_product(E, e, n, s, work.Kl, T.U, T.F)
            for i in range(n * n):
                work.lu[positions[i]] += s * work.Kl[i] + D[i]
        if E.factor[e] < NO_FACTOR:
            histories.element_force(tables, address, e, n, t, h, z, work)
            for i in range(n):
                T.control.force[FIRST_OUTPUT - E.factor[e], i] = work.rl[i]
        if E.z[e, END] > E.z[e, BEGIN]:
            histories.add_element_history(tables, address, e, n, t, h, s, z, T, work)


@compiled
def _subtract_product(E, e, n, s, A, X, F):
    """F -= s A X for all differences; A : matrix of element e."""
    dofs = part_of(E.dofs, E.dof[e], E.dof[e + 1])
    for j in range(X.shape[0]):
        for i in range(n):
            total = 0.0
            for l in range(n):
                total += A[i * n + l] * X[j, dofs[l]]
            F[j, dofs[i]] -= s * total


@compiled
def subtract_damping(tables, factor, x, F, T, work):
    """F -= factor C x at the last linearised state, with C of contacts, of friction in joints, and of controllers."""
    K, C, S = tables.contacts, tables.constraints, work.contact_scratch
    for c in range(K.kernel.shape[0]):
        slopes = work.slopes[c]
        if slopes[N_BY_RATE] == 0.0 and slopes[T_BY_SLIP] == 0.0:
            continue
        jacobians(work.contact[c], S)
        dofs, rate, slip = part_of(K.dofs, 6 * c, 6 * c + 6), 0.0, 0.0
        for i in range(6):
            rate += S[NORMAL, i] * x[dofs[i]]
            slip += S[TANGENTIAL, i] * x[dofs[i]]
        N = factor * slopes[N_BY_RATE] * rate
        friction = slopes[T_BY_N] * N + factor * slopes[T_BY_SLIP] * slip
        for i in range(6):
            F[dofs[i]] += S[NORMAL, i] * N + S[TANGENTIAL, i] * friction
    for c in range(C.kernel.shape[0]):
        if C.joint_friction[c, LOAD_KERNEL] >= 0:
            begin, slip = C.dof[c], 0.0
            for i in range(6):
                slip += T.slip_direction[c, i] * x[C.dofs[begin + i]]
            friction = factor * work.slopes[K.kernel.shape[0] + c, JOINT_T_BY_SLIP] * slip
            for i in range(6):
                F[C.dofs[begin + i]] += T.slip_direction[c, i] * friction
    parameters.subtract_control_rates(tables, T.control.by_v, factor, x, F, T)


@compiled
def rate_forces(tables, kv, x, T, work):
    """T.f = (kv C + ka M) x with the matrices of the last `linearise`; x : (n_q + n_c,)."""
    E, F, n_q = tables.elements, T.f, tables.sizes.n_q
    F[:] = 0.0
    for i in range(n_q):
        T.r[i] = x[i]
    for e in range(E.p.shape[0]):
        n, dofs = E.dof[e + 1] - E.dof[e], part_of(E.dofs, E.dof[e], E.dof[e + 1])
        D, own = part_of(T.D, E.pos[e], E.pos[e + 1]), T.local[histories.FIRST]
        for i in range(n):
            own[i] = T.r[dofs[i]]
        for i in range(n):
            total = 0.0
            for l in range(n):
                total += D[i * n + l] * own[l]
            F[dofs[i]] += total
    subtract_damping(tables, -kv, T.r, F, T, work)
    parameters.subtract_state_rates(tables, -T.control.mass, T.r, F)


@apart
def advance_histories(tables, address, t, h, q, v, a, lam, z, T, work):
    """Set T.z to the differences of histories at the end of a step, from T.z1, T.q, T.v, T.a and T.u."""
    for e in range(tables.elements.p.shape[0]):
        if tables.elements.z[e, END] > tables.elements.z[e, BEGIN]:
            histories.advance_element_history(tables, address, e, t, h, q, v, a, z, T, work)
    for c in range(tables.contacts.kernel.shape[0]):
        histories.advance_contact_history(tables, address, c, h, v, z, T, work)
    for c in range(tables.constraints.kernel.shape[0]):
        C = tables.constraints
        if C.joint_friction[c, LOAD_KERNEL] >= 0 and C.joint_friction_z[c, END] > C.joint_friction_z[c, BEGIN]:
            histories.advance_joint_friction_history(tables, address, c, h, q, v, lam, z, T, work)
    for j in range(T.z.shape[0]):
        copy(T.z1[j], T.z[j])


@compiled
def find_rates(tables, address, t, h, q, v, a, z, T, work):
    """Set T.rt = dr/dt at constant q, v, a, and T.moving = (G v, G a + W v), the rates of prescribed motions."""
    eps, C = TIME_DIFFERENCE * h, tables.constraints
    copy(z, T.zs)
    for side in range(2):
        work.r[:] = 0.0
        later = t + eps if side == 0 else t - eps
        add_elements(tables, address, later, h, q, v, a, T.zs, 0.0, 0.0, 0.0, False, work)
        for i in range(T.rt.shape[0]):
            T.rt[i] = work.r[i] if side == 0 else (T.rt[i] - work.r[i]) / (2.0 * eps)
    for c in range(C.kernel.shape[0]):
        for i in range(C.row[c + 1] - C.row[c]):
            row = C.row[c] + i
            T.moving[SPEED, row] = rows_times(C, c, work.G, v, i)
            T.moving[ACCELERATION, row] = rows_times(C, c, work.G, a, i) + rows_times(C, c, T.W, v, i)


@compiled
def find_jacobian_rate(tables, address, t, most, length, q, v, lam, T, work):
    """Set T.W = dG/dt along the motion (q, v), by central differences; most : largest time difference [s]."""
    # W is also d(G v + g_t)/dq, since second derivatives commute. length : size of the mechanism [m].
    fast = 0.0
    for i in range(0, tables.sizes.n_b, 3):
        fast = max(fast, max(abs(v[i]), abs(v[i + 1])) / length, abs(v[i + 2]))
    eps = most if fast * most <= POSE_DIFFERENCE else POSE_DIFFERENCE / fast
    T.W[:] = 0.0
    if eps == 0.0:
        return
    for c in range(tables.constraints.kernel.shape[0]):
        _add_jacobian(tables, address, c, t + eps, eps, 0.5 / eps, q, v, lam, T, work)
        _add_jacobian(tables, address, c, t - eps, -eps, -0.5 / eps, q, v, lam, T, work)


@compiled
def _add_jacobian(tables, address, c, t, eps, factor, q, v, lam, T, work):
    """Add factor G(q + eps v) of constraint c to T.W."""
    C = tables.constraints
    n, m = C.dof[c + 1] - C.dof[c], C.row[c + 1] - C.row[c]
    begin, end, place = C.row[c], C.row[c + 1], C.pos_g[c]
    for i in range(n):
        dof = C.dofs[C.dof[c] + i]
        work.ql[i], work.vl[i] = q[dof] + eps * v[dof], v[dof]
    for i in range(m * n):
        work.Cl[i] = 0.0
    for i in range(n * n):
        work.Kl[i] = 0.0
    T.g[:, :] = 0.0
    constraint_at(address.constraint, C.kernel[c])(
        part_of(tables.p, C.p[c, BEGIN], C.p[c, END]), t, part_of(work.ql, 0, n), part_of(work.vl, 0, n),
        part_of(lam, begin, end), T.g[RESIDUAL, begin:end], matrix_view(work.Cl, m, n), T.g[RATE, begin:end],
        T.g[RIGHT_SIDE, begin:end], matrix_view(work.Kl, n, n),
    )  # fmt: skip
    for i in range(m * n):
        T.W[place + i] += factor * work.Cl[i]


@compiled
def rows_times(C, c, G, x, i):
    """Row i of constraint c times x; G : as `Work.G`."""
    n, begin, place, total = C.dof[c + 1] - C.dof[c], C.dof[c], C.pos_g[c], 0.0
    for j in range(n):
        total += G[place + i * n + j] * x[C.dofs[begin + j]]
    return total
