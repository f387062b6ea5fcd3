"""Work of contacts in a step: by their laws along the path, and by the forces that the step took as linear."""

from flexmb.contact.onset import crossing
from flexmb.integrate.arrays import CONTACT_MEMORY
from flexmb.kernels import GAP_SIZE, compiled, part_of
from flexmb.system.contacts import call_gap, call_normal, jacobians

GAUSS = 0.5 / 3.0**0.5
"""The two points of Gauss' rule lie so far from the middle: exact for cubics, and ends of a contact need no value."""


@compiled
def contact_losses(tables, address, h, flow, q1, v1, work):
    """Fill work.loss: what laws took from the motion, normal and tangential; what the step took beyond; memory.

    The normal law is asked at two points of the cubic path between both states; the step moved with the mean force.
    Friction is booked as the step moved: where it sticks it is too steep to be asked between the states.

    The memory of a contact is its normal force and six generalised forces each of normal force and friction.
    """
    K = tables.contacts
    for c in range(K.kernel.shape[0]):
        loss, contact = work.loss[c], work.contact[c]
        k = CONTACT_MEMORY * c
        memory = part_of(flow.memory, k, k + CONTACT_MEMORY)
        N, T = contact[GAP_SIZE], contact[GAP_SIZE + 1]
        touched = N != 0.0 or T != 0.0
        for i in range(1, CONTACT_MEMORY):
            touched = touched or memory[i] != 0.0
        for i in range(3 + CONTACT_MEMORY):
            loss[i] = 0.0
        if touched:
            jacobians(contact, work.contact_scratch)
            normal, friction, dofs = 0.0, 0.0, part_of(K.dofs, 6 * c, 6 * c + 6)
            loss[3] = N
            for i in range(6):
                way = q1[dofs[i]] - flow.q[dofs[i]]
                loss[4 + i], loss[10 + i] = N * work.contact_scratch[0, i], T * work.contact_scratch[1, i]
                normal += 0.5 * (memory[1 + i] + loss[4 + i]) * way
                friction += 0.5 * (memory[7 + i] + loss[10 + i]) * way
            if h > 0.0:
                loss[0] = _by_law(tables, address, c, h, flow, q1, v1, work)
                loss[1] = -friction
                loss[2] = -normal - loss[0]


@compiled
def _by_law(tables, address, c, h, flow, q1, v1, work):
    """Loss of contact c by its normal law, in the part of the step in which its surfaces touch."""
    K = tables.contacts
    begin, end = _touching(h, flow.z[K.z[c, 0] + 2], flow.z[K.z[c, 0] + 4], work.contact[c, 0], work.contact[c, 1])
    half, dofs, loss = 0.5 * (end - begin), part_of(K.dofs, 6 * c, 6 * c + 6), 0.0
    for point in range(2):
        s = begin + half + (2 * point - 1) * GAUSS * (end - begin)
        for i in range(6):
            k = dofs[i]
            rise = q1[k] - flow.q[k]
            d0, d1 = h * flow.v[k], h * v1[k]
            c2, c3 = 3.0 * rise - 2.0 * d0 - d1, d0 + d1 - 2.0 * rise
            work.ql[i] = flow.q[k] + s * (d0 + s * (c2 + s * c3))
            work.vl[i] = (d0 + s * (2.0 * c2 + 3.0 * s * c3)) / h
        gap = work.gap
        for i in range(GAP_SIZE):
            gap[i] = 0.0
        call_gap(tables, address, c, work.ql, work.vl, gap)
        N, _, _ = call_normal(tables, address, c, s * h, gap[0], gap[1], flow.z, work.z_between)
        loss -= half * h * N * gap[1]
    return loss


@compiled
def _touching(h, gap0, rate0, gap1, rate1):
    """Begin and end of the part of a step in which a contact is closed; all of it where neither end says when."""
    if gap0 > 0.0 >= gap1:
        return crossing(h, gap0, rate0, gap1, rate1), 1.0
    if gap0 < 0.0 < gap1:
        return 0.0, crossing(h, -gap0, -rate0, -gap1, -rate1)
    return 0.0, 1.0
