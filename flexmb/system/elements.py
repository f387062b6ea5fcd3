"""Elements: gather, call, scatter; and their energies."""

from flexmb.kernels import compiled, element_at, energy_at, matrix_view, motion_at


@compiled
def gather(values, dofs, begin, n, target):
    """target[:n] = values at the dofs begin .. begin + n."""
    for i in range(n):
        target[i] = values[dofs[begin + i]]


@compiled
def add_elements(tables, address, t, h, q, v, a, z, kq, kv, ka, matrix, work):
    """Add forces to work.r and, if `matrix`, kq K + kv C + ka M to work.lu; write histories."""
    E = tables.elements
    for e in range(E.kernel.shape[0]):
        n = E.dof[e + 1] - E.dof[e]
        gather(q, E.dofs, E.dof[e], n, work.ql)
        gather(v, E.dofs, E.dof[e], n, work.vl)
        gather(a, E.dofs, E.dof[e], n, work.al)
        call_element(tables, address, e, n, t, h, z, work)
        for i in range(n):
            work.r[E.dofs[E.dof[e] + i]] += work.rl[i]
        if matrix:
            begin = E.pos[e]
            for i in range(n * n):
                work.lu[E.positions[begin + i]] += kq * work.Kl[i] + kv * work.Cl[i] + ka * work.Ml[i]


@compiled
def call_element(tables, address, e, n, t, h, z, work):
    """Call the kernel of element e on the gathered ql, vl, al; results in rl, Kl, Cl, Ml, z_new."""
    E = tables.elements
    for i in range(n):
        work.rl[i] = 0.0
    for i in range(n * n):
        work.Kl[i], work.Cl[i], work.Ml[i] = 0.0, 0.0, 0.0
    element_at(address.element, E.kernel[e])(
        tables.p[E.p[e, 0] : E.p[e, 1]],
        t,
        h,
        work.ql[:n],
        work.vl[:n],
        work.al[:n],
        z[E.z[e, 0] : E.z[e, 1]],
        work.rl[:n],
        matrix_view(work.Kl, n, n),
        matrix_view(work.Cl, n, n),
        matrix_view(work.Ml, n, n),
        work.z_new[E.z[e, 0] : E.z[e, 1]],
    )
    if E.factor[e] >= 0:
        s, _, _ = motion_at(address.motion, E.factor[e])(tables.p[E.factor_p[e, 0] : E.factor_p[e, 1]], t)
        for i in range(n):
            work.rl[i] *= s
        for i in range(n * n):
            work.Kl[i] *= s
            work.Cl[i] *= s
            work.Ml[i] *= s


@compiled
def account(tables, address, t, h, q, v, a, x, y, z, work):
    """Energies and powers of all elements at a state: work.power.

    Kinetic energy 1/2 v M v, strain, gravity, power of damping; power that elements without an account of their own
    give to the motion, -(r - M a) v, and their forces in work.load; and x M y + change M bow, with which the loop
    measures what the algorithm dissipates.
    """
    E = tables.elements
    work.power[:] = 0.0
    place = 0
    for e in range(E.kernel.shape[0]):
        n = E.dof[e + 1] - E.dof[e]
        gather(q, E.dofs, E.dof[e], n, work.ql)
        gather(v, E.dofs, E.dof[e], n, work.vl)
        gather(a, E.dofs, E.dof[e], n, work.al)
        call_element(tables, address, e, n, t, h, z, work)
        for i in range(n):
            dof = E.dofs[E.dof[e] + i]
            work.r[dof] += work.rl[i]
            Mv, My, Mb = 0.0, 0.0, 0.0
            for j in range(n):
                m = work.Ml[i * n + j]
                if m != 0.0:
                    Mv += m * work.vl[j]
                    My += m * y[E.dofs[E.dof[e] + j]]
                    Mb += m * work.bow[E.dofs[E.dof[e] + j]]
            work.power[0] += 0.5 * work.vl[i] * Mv
            work.power[5] += x[dof] * My + work.change[dof] * Mb
        if E.energy[e] >= 0:
            strain, gravity, damping = energy_at(address.energy, E.energy[e])(
                tables.p[E.p[e, 0] : E.p[e, 1]], t, work.ql[:n], work.vl[:n]
            )
            work.power[1] += strain
            work.power[2] += gravity
            work.power[3] += damping
        else:
            for i in range(n):
                force = work.rl[i]
                for j in range(n):
                    force -= work.Ml[i * n + j] * work.al[j]
                work.power[4] -= work.vl[i] * force
                work.load[place] = -force
                place += 1
