"""Evaluation of elements: forces, matrices, energies."""

from flexmb.engine.compiled.arrays import matrix_view, part_of
from flexmb.engine.system.controls import add_load_tangent, evaluate_controls
from flexmb.engine.system.work import gather
from flexmb.kernels import account_at, compiled, element_at, energy_at, force_at, motion_at, tangent_at
from flexmb.program.program import BEGIN, END, FIRST_OUTPUT, NO_FACTOR


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
    E = tables.elements
    if tables.controls.kernel.shape[0] > 0:
        evaluate_controls(tables, address, t, q, v, a, z, kq, kv, ka, matrix, work)
    for e in range(E.p.shape[0]):
        n = E.dof[e + 1] - E.dof[e]
        gather_state(E, e, n, q, v, a, work)
        if (E.tangent[e] if matrix else E.force[e]) < 0:
            call_element(tables, address, e, n, t, h, z, work)
            if matrix:
                for i in range(n * n):
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
            if E.factor[e] < NO_FACTOR:
                add_load_tangent(tables, e, n, work)
        dofs = part_of(E.dofs, E.dof[e], E.dof[e + 1])
        for i in range(n):
            work.r[dofs[i]] += s * work.rl[i]


@compiled
def call_force(tables, address, e, n, t, h, z, work):
    """Call the force kernel of element e, without its factor; results in rl, z_new."""
    E = tables.elements
    force_at(address.force, E.force[e])(
        part_of(tables.p, E.p[e, BEGIN], E.p[e, END]),
        t,
        h,
        part_of(work.ql, 0, n),
        part_of(work.vl, 0, n),
        part_of(work.al, 0, n),
        part_of(z, E.z[e, BEGIN], E.z[e, END]),
        part_of(work.rl, 0, n),
        part_of(work.z_new, E.z[e, BEGIN], E.z[e, END]),
    )


@compiled
def call_tangent(tables, address, e, n, t, h, z, kq, kv, ka, work):
    """Call the tangent kernel of element e, without its factor; results in rl, Kl, z_new."""
    E = tables.elements
    for i in range(n * n):
        work.Kl[i] = 0.0
    tangent_at(address.tangent, E.tangent[e])(
        part_of(tables.p, E.p[e, BEGIN], E.p[e, END]),
        t,
        h,
        part_of(work.ql, 0, n),
        part_of(work.vl, 0, n),
        part_of(work.al, 0, n),
        part_of(z, E.z[e, BEGIN], E.z[e, END]),
        kq,
        kv,
        ka,
        part_of(work.rl, 0, n),
        matrix_view(work.Kl, n, n),
        part_of(work.z_new, E.z[e, BEGIN], E.z[e, END]),
    )


@compiled
def call_element(tables, address, e, n, t, h, z, work):
    """Call the element kernel of element e, without its factor; results in rl, Kl, Cl, Ml, z_new."""
    E = tables.elements
    for i in range(n * n):
        work.Kl[i], work.Cl[i], work.Ml[i] = 0.0, 0.0, 0.0
    element_at(address.element, E.kernel[e])(
        part_of(tables.p, E.p[e, BEGIN], E.p[e, END]),
        t,
        h,
        part_of(work.ql, 0, n),
        part_of(work.vl, 0, n),
        part_of(work.al, 0, n),
        part_of(z, E.z[e, BEGIN], E.z[e, END]),
        part_of(work.rl, 0, n),
        matrix_view(work.Kl, n, n),
        matrix_view(work.Cl, n, n),
        matrix_view(work.Ml, n, n),
        part_of(work.z_new, E.z[e, BEGIN], E.z[e, END]),
    )


@compiled
def load_factor(tables, address, e, t, work):
    """Load factor of element e, which multiplies all results of its kernel."""
    E = tables.elements
    if E.factor[e] < 0:
        return 1.0 if E.factor[e] == NO_FACTOR else work.output[FIRST_OUTPUT - E.factor[e]]
    s, _, _ = motion_at(address.motion, E.factor[e])(part_of(tables.p, E.factor_p[e, BEGIN], E.factor_p[e, END]), t)
    return s


@compiled
def evaluate_energies(tables, address, t, h, q, v, a, x, y, z, work):
    """Evaluate the energies of all elements at a state, into work.power."""
    # Kinetic energy 1/2 v M v, strain, gravity, power of damping; x M y, for the energy that the method dissipates.
    # work.load: forces of elements without energies of their own;  work.momentum: M v.
    E = tables.elements
    power = work.power
    power.kinetic = power.strain = power.gravity = power.damping = power.algorithm = 0.0
    work.momentum[:] = 0.0
    place = 0
    if tables.controls.kernel.shape[0] > 0:
        evaluate_controls(tables, address, t, q, v, a, z, 0.0, 0.0, 0.0, False, work)
    for e in range(E.p.shape[0]):
        n = E.dof[e + 1] - E.dof[e]
        dofs = part_of(E.dofs, E.dof[e], E.dof[e + 1])
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
def call_account_kernel(tables, address, e, n, t, h, z, work):
    """Evaluate M v and M y of element e in Mvl, Myl, forces in rl; return strain, gravity, power of damping."""
    E = tables.elements
    for i in range(n):
        work.Mvl[i], work.Myl[i] = 0.0, 0.0
    return account_at(address.account, E.account[e])(
        part_of(tables.p, E.p[e, BEGIN], E.p[e, END]),
        t,
        h,
        part_of(work.ql, 0, n),
        part_of(work.vl, 0, n),
        part_of(work.al, 0, n),
        part_of(work.yl, 0, n),
        part_of(z, E.z[e, BEGIN], E.z[e, END]),
        part_of(work.rl, 0, n),
        part_of(work.Mvl, 0, n),
        part_of(work.Myl, 0, n),
        part_of(work.z_new, E.z[e, BEGIN], E.z[e, END]),
    )


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
    return energy_at(address.energy, E.energy[e])(
        part_of(tables.p, E.p[e, BEGIN], E.p[e, END]), t, part_of(work.ql, 0, n), part_of(work.vl, 0, n)
    )
