"""Evaluation of elements: forces, matrices, energies; and of controls: outputs, which are factors of loads, tangents.

The velocities v of the coordinates of a control are its states x, their accelerations a the rates of x.  The residual
of a state is r = a - f(t, u, x) with the law f.  Outputs and rates are differentiated by differences of the law alone;
the derivatives of the inputs by coordinates and velocities are exact, or differences of the signal's kernel.
"""

from flexmb import kernels
from flexmb.engine.compiled.arrays import matrix_view, part_of
from flexmb.engine.compiled.lanes import LANES
from flexmb.engine.system.work import gather
from flexmb.kernels import compiled
from flexmb.places import GRAVITY_X, GRAVITY_Y, INERTIA, MASS
from flexmb.program import program as at

# Difference of an input or a state relative to its size, and least size, in central differences of a control law.
# The cube root of round-off. The least size is that of micrometres in laws that are no straight lines there.
RELATIVE_DIFFERENCE, LEAST_SIZE = 6e-6, 1e-3
# Difference of coordinates and velocities in central differences of measured inputs [m, rad, m/s, rad/s].
COORDINATE_DIFFERENCE = 1e-6


@compiled
def evaluate_controls(tables, address, t, q, v, a, z, kq, kv, ka, matrix, work):
    """Outputs of all controls in work.output; residuals of their states in work.r, tangents in work.lu if `matrix`."""
    C = tables.controls
    for c in range(C.kernel.shape[0]):
        n_x, n_y = C.states[c], C.output[c + 1] - C.output[c]
        if C.z[c, at.END] > C.z[c, at.BEGIN]:  # a sampled control keeps its states and outputs
            for i in range(C.z[c, at.BEGIN], C.z[c, at.END]):
                work.z_new[i] = z[i]
            for k in range(n_y):
                work.output[C.output[c] + k] = z[C.z[c, at.END] - n_y + k]
            continue
        read_inputs(tables, address, c, t, q, v, work)
        call_law(tables, address, c, t, work)
        for k in range(n_y):
            work.output[C.output[c] + k] = work.law[n_x + k]
        dofs = part_of(C.dofs, C.dof[c], C.dof[c + 1])
        for i in range(threes(n_x)):
            work.r[dofs[i]] = a[dofs[i]] - (work.law[i] if i < n_x else 0.0)
        if matrix:
            differentiate_law(tables, address, c, t, q, v, kq, kv, work)
            # Derivatives of the residuals of the states.
            n = C.dof[c + 1] - C.dof[c]
            positions = part_of(C.positions_state, C.pos_state[c], C.pos_state[c + 1])
            for i in range(threes(n_x)):
                work.lu[positions[i * n + i]] += ka
                for j in range(n if i < n_x else 0):
                    work.lu[positions[i * n + j]] -= work.law_tangent[i * n + j]


@compiled
def threes(n):
    """The next multiple of three from n on: states stand in nodes of three coordinates."""
    return (n + 2) // 3 * 3


@compiled
def read_inputs(tables, address, c, t, q, v, work):
    """Inputs of control c in work.u, and its states in work.x."""
    C = tables.controls
    for j in range(C.input[c], C.input[c + 1]):
        kind, what = C.source[j, at.SOURCE], C.source[j, at.SOURCE_NUMBER]
        if kind == at.COORDINATE:
            value = q[what]
        elif kind == at.VELOCITY:
            value = v[what]
        elif kind == at.MEASURED:
            value = measured(tables, address, j, t, q, v, -1, 0.0, 0.0, work)
        elif kind == at.OUTPUT:
            value = work.output[what]
        else:
            p = part_of(tables.p, C.source[j, at.SOURCE_P], C.source[j, at.SOURCE_P_END])
            s, speed, _ = kernels.motion_at(address.motion, what)(p, t)
            value = s if kind == at.MOTION_VALUE else speed
        work.u[j - C.input[c]] = value
    for i in range(C.states[c]):
        work.x[i] = v[C.dofs[C.dof[c] + i]]


@compiled
def measured(tables, address, j, t, q, v, i, dq, dv, work):
    """Value of a measured input with its i-th coordinate and velocity shifted by dq and dv; i = -1: no shift."""
    C = tables.controls
    begin, n = C.source_dof[j], C.source_dof[j + 1] - C.source_dof[j]
    gather(q, C.source_dofs, begin, n, work.ql)
    gather(v, C.source_dofs, begin, n, work.vl)
    for k in range(n):
        work.al[k] = 0.0
    if i >= 0:
        work.ql[i] += dq
        work.vl[i] += dv
    p = part_of(tables.p, C.source[j, at.SOURCE_P], C.source[j, at.SOURCE_P_END])
    ql, vl, al = part_of(work.ql, 0, n), part_of(work.vl, 0, n), part_of(work.al, 0, n)
    return kernels.signal_at(address.signal, C.source[j, at.SOURCE_NUMBER])(p, t, ql, vl, al)


@compiled
def call_law(tables, address, c, t, work):
    """Rates of the states and outputs of control c, one after the other in work.law, from work.u and work.x."""
    C = tables.controls
    n_x, n_y = C.states[c], C.output[c + 1] - C.output[c]
    for i in range(n_x + n_y):
        work.law[i] = 0.0
    kernels.control_at(address.control, C.kernel[c])(
        part_of(tables.p, C.p[c, at.BEGIN], C.p[c, at.END]), t, part_of(work.u, 0, C.input[c + 1] - C.input[c]),
        part_of(work.x, 0, n_x), part_of(work.law, 0, n_x), part_of(work.law, n_x, n_x + n_y),
    )  # fmt: skip


@compiled
def differentiate_law(tables, address, c, t, q, v, kq, kv, work):
    """Derivatives kq d/dq + kv d/dv of rates and outputs in work.law_tangent; of outputs in work.slope, too."""
    C = tables.controls
    n_u, n_x, n_y = C.input[c + 1] - C.input[c], C.states[c], C.output[c + 1] - C.output[c]
    n, rows = C.dof[c + 1] - C.dof[c], n_x + n_y
    for i in range(rows * n):
        work.law_tangent[i] = 0.0
    for j in range(n_u):
        law_column(tables, address, c, t, work.u, j, work)
        source = C.input[c] + j
        for i in range(C.source_dof[source], C.source_dof[source + 1]):
            if C.source_places[i] >= 0:
                rate = input_slope(tables, address, source, i - C.source_dof[source], t, q, v, kq, kv, work)
                add_column(rows, n, C.source_places[i], rate, work)
    for i in range(n_x):
        law_column(tables, address, c, t, work.x, i, work)
        add_column(rows, n, i, kv, work)
    begin = C.slope[C.output[c]]
    for i in range(n_y * n):
        work.slope[begin + i] = work.law_tangent[n_x * n + i]


@compiled
def law_column(tables, address, c, t, values, j, work):
    """Derivatives of rates and outputs by entry j of `values`, the inputs or the states, in work.law_column."""
    C = tables.controls
    n, kept = C.states[c] + C.output[c + 1] - C.output[c], values[j]
    shift = RELATIVE_DIFFERENCE * max(abs(kept), LEAST_SIZE)
    upper, lower = kept + shift, kept - shift
    values[j] = upper
    call_law(tables, address, c, t, work)
    for i in range(n):
        work.law_column[i] = work.law[i]
    values[j] = lower
    call_law(tables, address, c, t, work)
    for i in range(n):
        work.law_column[i] = (work.law_column[i] - work.law[i]) / (upper - lower)
    values[j] = kept


@compiled
def input_slope(tables, address, j, i, t, q, v, kq, kv, work):
    """Derivative kq du/dq + kv du/dv of input j by its i-th coordinate."""
    C = tables.controls
    kind = C.source[j, at.SOURCE]
    if kind == at.COORDINATE:
        return kq
    if kind == at.VELOCITY:
        return kv
    if kind == at.OUTPUT:
        return work.slope[C.slope[C.source[j, at.SOURCE_NUMBER]] + i]
    total, e = 0.0, COORDINATE_DIFFERENCE
    if kq != 0.0:
        upper = measured(tables, address, j, t, q, v, i, e, 0.0, work)
        total += kq * (upper - measured(tables, address, j, t, q, v, i, -e, 0.0, work)) / (2.0 * e)
    if kv != 0.0:
        upper = measured(tables, address, j, t, q, v, i, 0.0, e, work)
        total += kv * (upper - measured(tables, address, j, t, q, v, i, 0.0, -e, work)) / (2.0 * e)
    return total


@compiled
def add_column(rows, n, place, factor, work):
    """Add factor times work.law_column to a column of work.law_tangent (rows, n)."""
    for i in range(rows):
        work.law_tangent[i * n + place] += factor * work.law_column[i]


@compiled
def add_load_tangent(tables, e, n, work):
    """Add force times derivative of the factor of element e, if an output; work.rl is the force without the factor."""
    C, output = tables.controls, at.FIRST_OUTPUT - tables.elements.factor[e]
    if tables.elements.factor[e] >= at.NO_FACTOR:
        return
    c = C.owner[output]
    m, slope = C.dof[c + 1] - C.dof[c], C.slope[output]
    positions = part_of(C.positions_load, C.pos_load[output], C.pos_load[output + 1])
    for i in range(n):
        for j in range(m):
            work.lu[positions[i * m + j]] += work.rl[i] * work.slope[slope + j]


@compiled
def write_control_signals(tables, work, z, y):
    """Write outputs of all controls, and the states of sampled ones, into the signals y."""
    C = tables.controls
    for c in range(C.kernel.shape[0]):
        k, n_y = C.out[c], C.output[c + 1] - C.output[c]
        for i in range(C.z[c, at.BEGIN], C.z[c, at.END] - n_y):
            y[k] = z[i]
            k += 1
        for i in range(n_y):
            y[k] = work.output[C.output[c] + i]
            k += 1


@compiled
def gather_state(E, e, n, q, v, a, work):
    """Coordinates, velocities and accelerations of element e, and zeros for its forces."""
    dofs = part_of(E.dofs, E.dof[e], E.dof[e + 1])
    for i in range(n):
        dof = dofs[i]
        work.ql[i], work.vl[i], work.al[i], work.rl[i] = q[dof], v[dof], a[dof], 0.0


@compiled
def add_elements(tables, address, t, h, q, v, a, z, kq, kv, ka, matrix, work):
    """Add forces to work.r and, if `matrix`, kq K + kv C + ka M to work.lu; write histories."""
    E, done = tables.elements, 0
    if tables.controls.kernel.shape[0] > 0:
        evaluate_controls(tables, address, t, q, v, a, z, kq, kv, ka, matrix, work)
    for e in range(E.p.shape[0]):
        if E.fours[e, at.FOUR_FORCES] >= 0:
            add_four(tables, address, e, t, h, q, v, a, z, kq, kv, ka, matrix, work)
            done = e + LANES
        if e < done:
            continue
        if E.mass[e] > 0:
            add_mass(tables, e, a, ka, matrix, work)
        else:
            add_element(tables, address, e, t, h, q, v, a, z, kq, kv, ka, matrix, work)


@compiled
def add_element(tables, address, e, t, h, q, v, a, z, kq, kv, ka, matrix, work):
    """`add_elements` of element e alone."""
    E = tables.elements
    n, dofs = E.dof[e + 1] - E.dof[e], part_of(E.dofs, E.dof[e], E.dof[e + 1])
    gather_state(E, e, n, q, v, a, work)
    if (E.tangent[e] if matrix else E.force[e]) < 0:
        call_element(tables, address, e, n, t, h, z, work)
        for i in range(n * n if matrix else 0):
            work.Kl[i] = kq * work.Kl[i] + kv * work.Cl[i] + ka * work.Ml[i]
    elif matrix:
        call_tangent(tables, address, e, n, t, h, z, kq, kv, ka, work)
    else:
        call_force(tables, address, e, n, t, h, z, work)
    s = load_factor(tables, address, e, t, work)
    if matrix:
        positions = part_of(E.positions, E.pos[e], E.pos[e + 1])
        for i in range(n * n):
            if work.Kl[i] != 0.0:  # a chain of sums at the place that nothing reads would take its time
                work.lu[positions[i]] += s * work.Kl[i]
        add_load_tangent(tables, e, n, work)
    for i in range(n):
        work.r[dofs[i]] += s * work.rl[i]


@compiled
def add_mass(tables, e, a, ka, matrix, work):
    """`add_elements` of a rigid mass at a node."""
    E = tables.elements
    x, y, turn = part_of(E.dofs, E.dof[e], E.dof[e + 1])
    p, r = part_of(tables.p, E.p[e, at.BEGIN], E.p[e, at.END]), work.r
    m, J = p[MASS], p[INERTIA]
    r[x], r[y], r[turn] = r[x] + m * (a[x] - p[GRAVITY_X]), r[y] + m * (a[y] - p[GRAVITY_Y]), r[turn] + J * a[turn]
    if matrix:
        positions = part_of(E.positions, E.pos[e], E.pos[e + 1])
        for k, own in enumerate((m, m, J)):
            work.lu[positions[4 * k]] += ka * own


@compiled
def account_for_mass(tables, e, q, v, a, x, y, work):
    """`evaluate_energies` of a rigid mass at a node."""
    E, power = tables.elements, work.power
    add_mass(tables, e, a, 0.0, False, work)
    p, kinetic, product, weight = part_of(tables.p, E.p[e, at.BEGIN], E.p[e, at.END]), 0.0, 0.0, 0.0
    dofs = part_of(E.dofs, E.dof[e], E.dof[e + 1])
    for k, own in enumerate((p[MASS], p[MASS], p[INERTIA])):
        dof = dofs[k]
        work.momentum[dof] += own * v[dof]
        kinetic += v[dof] * (own * v[dof])
        product += x[dof] * (own * y[dof])
    for k, gravity in enumerate((p[GRAVITY_X], p[GRAVITY_Y])):
        weight += gravity * q[dofs[k]]
    power.kinetic += 0.5 * kinetic
    power.gravity -= p[MASS] * weight
    power.algorithm += product


@compiled
def gather_lanes(values, dofs, n, target):
    """Coordinates (n, LANES) in `target` of LANES elements of n coordinates, which follow each other in dofs."""
    for i in range(n):
        for lane in range(LANES):
            target[i * LANES + lane] = values[dofs[lane * n + i]]


@compiled
def add_four(tables, address, e, t, h, q, v, a, z, kq, kv, ka, matrix, work):
    """`add_elements` of element e and the next three."""
    E, n, size = tables.elements, at.FOUR_SIZE, at.FOUR_SIZE * LANES
    dofs = part_of(E.dofs, E.dof[e], E.dof[e] + size)
    gather_lanes(q, dofs, n, work.ql)
    gather_lanes(v, dofs, n, work.vl)
    gather_lanes(a, dofs, n, work.al)
    p, ql, vl, al, own, r, z_new = element_data(tables, e, e + LANES - 1, size, z, work)
    if matrix:
        kernel = kernels.tangent_at(address.tangent, E.fours[e, at.FOUR_TANGENTS])
        kernel(p, t, h, ql, vl, al, own, kq, kv, ka, r, matrix_view(work.Kl, n * n, LANES), z_new)
        positions = part_of(E.positions, E.pos[e], E.pos[e] + n * n * LANES)
        for lane in range(LANES):
            for i in range(n):
                for j in range(n):
                    value = work.Kl[(j * n + i) * LANES + lane]  # columns one after the other
                    work.lu[positions[(lane * n + i) * n + j]] += value
    else:
        kernels.force_at(address.force, E.fours[e, at.FOUR_FORCES])(p, t, h, ql, vl, al, own, r, z_new)
    for lane in range(LANES):
        for i in range(n):
            work.r[dofs[lane * n + i]] += work.rl[i * LANES + lane]


@compiled
def element_data(tables, e, last, n, z, work):
    """Numbers, coordinates, velocities, accelerations, histories, forces of elements e to last, for their kernels."""
    E = tables.elements
    p, (begin, end) = part_of(tables.p, E.p[e, at.BEGIN], E.p[last, at.END]), (E.z[e, at.BEGIN], E.z[last, at.END])
    q, v, a, r = (part_of(work.ql, 0, n), part_of(work.vl, 0, n), part_of(work.al, 0, n), part_of(work.rl, 0, n))
    return p, q, v, a, part_of(z, begin, end), r, part_of(work.z_new, begin, end)


@compiled
def call_force(tables, address, e, n, t, h, z, work):
    """Call the force kernel of element e, without its factor; results in rl, z_new."""
    p, q, v, a, own, r, z_new = element_data(tables, e, e, n, z, work)
    kernels.force_at(address.force, tables.elements.force[e])(p, t, h, q, v, a, own, r, z_new)


@compiled
def call_tangent(tables, address, e, n, t, h, z, kq, kv, ka, work):
    """Call the tangent kernel of element e, without its factor; results in rl, Kl, z_new."""
    for i in range(n * n):
        work.Kl[i] = 0.0
    p, q, v, a, own, r, z_new = element_data(tables, e, e, n, z, work)
    A = matrix_view(work.Kl, n, n)
    kernels.tangent_at(address.tangent, tables.elements.tangent[e])(p, t, h, q, v, a, own, kq, kv, ka, r, A, z_new)


@compiled
def call_element(tables, address, e, n, t, h, z, work):
    """Call the element kernel of element e, without its factor; results in rl, Kl, Cl, Ml, z_new."""
    for i in range(n * n):
        work.Kl[i], work.Cl[i], work.Ml[i] = 0.0, 0.0, 0.0
    p, q, v, a, own, r, z_new = element_data(tables, e, e, n, z, work)
    K, C, M = matrix_view(work.Kl, n, n), matrix_view(work.Cl, n, n), matrix_view(work.Ml, n, n)
    kernels.element_at(address.element, tables.elements.kernel[e])(p, t, h, q, v, a, own, r, K, C, M, z_new)


@compiled
def load_factor(tables, address, e, t, work):
    """Load factor of element e, which multiplies all results of its kernel."""
    E = tables.elements
    if E.factor[e] < 0:
        return 1.0 if E.factor[e] == at.NO_FACTOR else work.output[at.FIRST_OUTPUT - E.factor[e]]
    p = part_of(tables.p, E.factor_p[e, at.BEGIN], E.factor_p[e, at.END])
    s, _, _ = kernels.motion_at(address.motion, E.factor[e])(p, t)
    return s


@compiled
def evaluate_energies(tables, address, t, h, q, v, a, x, y, z, work):
    """Evaluate the energies of all elements at a state, into work.power."""
    # Kinetic energy 1/2 v M v, strain, gravity, power of damping; x M y, for the energy that the method dissipates.
    # work.load: forces of elements without energies of their own;  work.momentum: M v.
    E, power = tables.elements, work.power
    power.kinetic = power.strain = power.gravity = power.damping = power.algorithm = 0.0
    work.momentum[:] = 0.0
    place, done = 0, 0
    if tables.controls.kernel.shape[0] > 0:
        evaluate_controls(tables, address, t, q, v, a, z, 0.0, 0.0, 0.0, False, work)
    for e in range(E.p.shape[0]):
        if E.fours[e, at.FOUR_ACCOUNTS] >= 0:
            account_for_four(tables, address, e, t, h, q, v, a, x, y, z, work)
            done = e + LANES
        if e < done:
            continue
        if E.mass[e] > 0:
            account_for_mass(tables, e, q, v, a, x, y, work)
            continue
        n, dofs = E.dof[e + 1] - E.dof[e], part_of(E.dofs, E.dof[e], E.dof[e + 1])
        gather_state(E, e, n, q, v, a, work)
        gather(y, E.dofs, E.dof[e], n, work.yl)
        if E.account[e] >= 0:
            strain, gravity, damping = call_account_kernel(tables, address, e, n, t, h, z, work)
        else:
            strain, gravity, damping = energies_by_matrix(tables, address, e, n, t, h, z, place, work)
        if E.energy[e] < 0:
            place += n
        kinetic, product = 0.0, 0.0
        for i in range(n):
            dof = dofs[i]
            work.r[dof] += work.rl[i]
            work.momentum[dof] += work.Mvl[i]
            kinetic += work.vl[i] * work.Mvl[i]
            product += x[dof] * work.Myl[i]
        power.kinetic += 0.5 * kinetic
        power.strain += strain
        power.gravity += gravity
        power.damping += damping
        power.algorithm += product


@compiled
def account_for_four(tables, address, e, t, h, q, v, a, x, y, z, work):
    """`evaluate_energies` of element e and the next three."""
    E, n, size, power = tables.elements, at.FOUR_SIZE, at.FOUR_SIZE * LANES, work.power
    dofs = part_of(E.dofs, E.dof[e], E.dof[e] + size)
    gather_lanes(q, dofs, n, work.ql)
    gather_lanes(v, dofs, n, work.vl)
    gather_lanes(a, dofs, n, work.al)
    gather_lanes(y, dofs, n, work.yl)
    p, ql, vl, al, own, r, z_new = element_data(tables, e, e + LANES - 1, size, z, work)
    yl, Mv, My = part_of(work.yl, 0, size), part_of(work.Mvl, 0, size), part_of(work.Myl, 0, size)
    kernel = kernels.account_at(address.account, E.fours[e, at.FOUR_ACCOUNTS])
    strain, gravity, damping = kernel(p, t, h, ql, vl, al, yl, own, r, Mv, My, z_new)
    kinetic, product = 0.0, 0.0
    for lane in range(LANES):
        for i in range(n):
            dof, k = dofs[lane * n + i], i * LANES + lane
            work.r[dof] += work.rl[k]
            work.momentum[dof] += work.Mvl[k]
            kinetic += work.vl[k] * work.Mvl[k]
            product += x[dof] * work.Myl[k]
    power.kinetic += 0.5 * kinetic
    power.strain += strain
    power.gravity += gravity
    power.damping += damping
    power.algorithm += product


@compiled
def call_account_kernel(tables, address, e, n, t, h, z, work):
    """Evaluate M v and M y of element e in Mvl, Myl, forces in rl; return strain, gravity, power of damping."""
    for i in range(n):
        work.Mvl[i], work.Myl[i] = 0.0, 0.0
    p, q, v, a, own, r, z_new = element_data(tables, e, e, n, z, work)
    y, Mv, My = part_of(work.yl, 0, n), part_of(work.Mvl, 0, n), part_of(work.Myl, 0, n)
    return kernels.account_at(address.account, tables.elements.account[e])(p, t, h, q, v, a, y, own, r, Mv, My, z_new)


@compiled
def energies_by_matrix(tables, address, e, n, t, h, z, place, work):
    """M v, M y and energies of element e by the mass matrix of its kernel; the force of a load goes to work.load."""
    E = tables.elements
    call_element(tables, address, e, n, t, h, z, work)
    s = load_factor(tables, address, e, t, work)
    for i in range(n):
        Mv, My, Ma = 0.0, 0.0, 0.0
        for j in range(n):
            m = s * work.Ml[i * n + j]
            Mv += m * work.vl[j]
            My += m * work.yl[j]
            Ma += m * work.al[j]
        work.rl[i] *= s
        work.Mvl[i], work.Myl[i] = Mv, My
        if E.energy[e] < 0:
            work.load[place + i] = Ma - work.rl[i]
    if E.energy[e] < 0:
        return 0.0, 0.0, 0.0
    p = part_of(tables.p, E.p[e, at.BEGIN], E.p[e, at.END])
    return kernels.energy_at(address.energy, E.energy[e])(p, t, part_of(work.ql, 0, n), part_of(work.vl, 0, n))
