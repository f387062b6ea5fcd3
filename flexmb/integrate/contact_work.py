"""Work of contacts in a step: by their laws along the path, and by the forces that the step took as linear."""

from flexmb.contact.onset import crossing
from flexmb.integrate.arrays import CONTACT_MEMORY, MEMORY_HEAD
from flexmb.kernels import GAP_SIZE, compiled, friction_at, gap_at, normal_at
from flexmb.system.contacts import jacobians

GAUSS = 0.5 / 3.0**0.5
"""The two points of Gauss' rule lie so far from the middle: exact for cubics, and ends of a contact need no value."""


@compiled
def contact_losses(tables, address, h, flow, q1, v1, work):
    """Fill work.loss: what laws took from the motion, normal and tangential; what the step took beyond; memory.

    A law is asked at two points of the cubic path between both states; the step moved with the mean force.

    The memory of a contact is its normal force and the six generalised forces on its two nodes.
    """
    K = tables.contacts
    for c in range(K.kernel.shape[0]):
        jacobians(work.contact[c], work.contact_scratch)
        N, T = work.contact[c, GAP_SIZE], work.contact[c, GAP_SIZE + 1]
        work.loss[c, 0], work.loss[c, 1], work.loss[c, 2], work.loss[c, 3] = 0.0, 0.0, 0.0, N
        k, linear, touched = MEMORY_HEAD + CONTACT_MEMORY * c, 0.0, N != 0.0 or T != 0.0
        for i in range(6):
            dof, before = K.dofs[c, i], flow.memory[k + 1 + i]
            force = N * work.contact_scratch[0, i] + T * work.contact_scratch[1, i]
            work.loss[c, 4 + i] = force
            touched = touched or before != 0.0
            linear += 0.5 * (before + force) * (q1[dof] - flow.q[dof])
        if h > 0.0 and touched:
            _by_laws(tables, address, c, h, flow, q1, v1, work)
            work.loss[c, 2] = -linear - work.loss[c, 0] - work.loss[c, 1]


@compiled
def _by_laws(tables, address, c, h, flow, q1, v1, work):
    """Losses of contact c by its laws, in the part of the step in which its surfaces touch."""
    K = tables.contacts
    begin, end = _touching(h, flow.z[K.z[c, 0] + 2], flow.z[K.z[c, 0] + 4], work.contact[c, 0], work.contact[c, 1])
    half = 0.5 * (end - begin)
    for point in range(2):
        s = begin + half + (2 * point - 1) * GAUSS * (end - begin)
        for i in range(6):
            k = K.dofs[c, i]
            rise = q1[k] - flow.q[k]
            d0, d1 = h * flow.v[k], h * v1[k]
            c2, c3 = 3.0 * rise - 2.0 * d0 - d1, d0 + d1 - 2.0 * rise
            work.ql[i] = flow.q[k] + s * (d0 + s * (c2 + s * c3))
            work.vl[i] = (d0 + s * (2.0 * c2 + 3.0 * s * c3)) / h
        gap = work.gap
        for i in range(GAP_SIZE):
            gap[i] = 0.0
        gap_at(address.gap, K.kernel[c, 0])(tables.p[K.p[c, 0] : K.p[c, 1]], work.ql[:6], work.vl[:6], gap)
        N, _, _ = normal_at(address.normal, K.kernel[c, 1])(
            tables.p[K.p[c, 2] : K.p[c, 3]],
            s * h,
            gap[0],
            gap[1],
            flow.z[K.z[c, 1] : K.z[c, 2]],
            work.z_between[K.z[c, 1] : K.z[c, 2]],
        )
        T, _, _ = friction_at(address.friction, K.kernel[c, 2])(
            tables.p[K.p[c, 4] : K.p[c, 5]],
            s * h,
            gap[2],
            N,
            flow.z[K.z[c, 2] : K.z[c, 3]],
            work.z_between[K.z[c, 2] : K.z[c, 3]],
        )
        work.loss[c, 0] -= half * h * N * gap[1]
        work.loss[c, 1] -= half * h * T * gap[2]


@compiled
def _touching(h, gap0, rate0, gap1, rate1):
    """Begin and end of the part of a step in which a contact is closed; all of it where neither end says when."""
    if gap0 > 0.0 >= gap1:
        return crossing(h, gap0, rate0, gap1, rate1), 1.0
    if gap0 < 0.0 < gap1:
        return 0.0, crossing(h, -gap0, -rate0, -gap1, -rate1)
    return 0.0, 1.0
