"""Work of contact forces in a step: by the contact laws along the path, and by the mean forces of the step."""

from flexmb.compiled.views import part_of
from flexmb.contact.gap_crossing import crossing
from flexmb.kernels import GAP_SIZE, compiled
from flexmb.places import FRICTION_FORCE, GAP, GAP_RATE, NORMAL, NORMAL_FORCE, TANGENTIAL
from flexmb.program.tables import COMMON_Z, LAST_GAP, LAST_GAP_RATE
from flexmb.state.flow import CONTACT_MEMORY_SIZE, MEMORY_BY_FRICTION, MEMORY_BY_NORMAL, MEMORY_NORMAL
from flexmb.system.contacts import call_gap, call_normal, jacobians
from flexmb.system.work import LOSS_BEYOND, LOSS_FRICTION, LOSS_MEMORY, LOSS_NORMAL

GAUSS_POINT = 0.5 / 3.0**0.5
"""Distance of the two points of Gauss' rule from the middle of an interval of length 1; exact for cubics."""


@compiled
def contact_losses(tables, address, h, flow, q1, v1, work):
    """Fill work.loss: normal and tangential loss by the laws, dissipation of the method beyond them [J]; memory.

    The normal law is evaluated at two points of the cubic path between both states.  The method moves with the mean of
    the forces at both ends; the difference is its dissipation.  Friction counts by the mean forces, since a sticking
    contact is too steep to be evaluated between the states.

    The memory of a contact is its normal force, and six generalised forces each of normal force and friction.
    """
    K = tables.contacts
    for c in range(K.kernel.shape[0]):
        loss, contact = work.loss[c], work.contact[c]
        k = CONTACT_MEMORY_SIZE * c
        memory = part_of(flow.memory, k, k + CONTACT_MEMORY_SIZE)
        N, T = contact[NORMAL_FORCE], contact[FRICTION_FORCE]
        touched = N != 0.0 or T != 0.0
        for i in range(1, CONTACT_MEMORY_SIZE):
            touched = touched or memory[i] != 0.0
        for i in range(LOSS_MEMORY + CONTACT_MEMORY_SIZE):
            loss[i] = 0.0
        if touched:
            jacobians(contact, work.contact_scratch)
            normal, friction, dofs = 0.0, 0.0, part_of(K.dofs, 6 * c, 6 * c + 6)
            now = part_of(loss, LOSS_MEMORY, LOSS_MEMORY + CONTACT_MEMORY_SIZE)
            now[MEMORY_NORMAL] = N
            for i in range(6):
                way = q1[dofs[i]] - flow.q[dofs[i]]
                now[MEMORY_BY_NORMAL + i] = N * work.contact_scratch[NORMAL, i]
                now[MEMORY_BY_FRICTION + i] = T * work.contact_scratch[TANGENTIAL, i]
                normal += 0.5 * (memory[MEMORY_BY_NORMAL + i] + now[MEMORY_BY_NORMAL + i]) * way
                friction += 0.5 * (memory[MEMORY_BY_FRICTION + i] + now[MEMORY_BY_FRICTION + i]) * way
            if h > 0.0:
                by_law = _loss_by_law(tables, address, c, h, flow, q1, v1, work)
                loss[LOSS_NORMAL], loss[LOSS_FRICTION], loss[LOSS_BEYOND] = by_law, -friction, -normal - by_law


@compiled
def _loss_by_law(tables, address, c, h, flow, q1, v1, work):
    """Loss of contact c by its normal law, over the fraction of the step with closed contact [J]."""
    K = tables.contacts
    k, contact = K.z[c, COMMON_Z], work.contact[c]
    begin, end = _contact_part(h, flow.z[k + LAST_GAP], flow.z[k + LAST_GAP_RATE], contact[GAP], contact[GAP_RATE])
    half, loss, gap = 0.5 * (end - begin), 0.0, work.gap
    for point in range(2):
        s = begin + half + (2 * point - 1) * GAUSS_POINT * (end - begin)
        gap_within(tables, address, c, s, h, flow, q1, v1, work)
        N, _, _ = call_normal(tables, address, c, s * h, gap[GAP], gap[GAP_RATE], flow.z, work.z_between)
        loss -= half * h * N * gap[GAP_RATE]
    return loss


@compiled
def gap_within(tables, address, c, s, h, flow, q1, v1, work):
    """Set work.gap to that of contact c at fraction s of the cubic path between both states."""
    dofs, gap = part_of(tables.contacts.dofs, 6 * c, 6 * c + 6), work.gap
    for i in range(6):
        k = dofs[i]
        rise = q1[k] - flow.q[k]
        d0, d1 = h * flow.v[k], h * v1[k]
        c2, c3 = 3.0 * rise - 2.0 * d0 - d1, d0 + d1 - 2.0 * rise
        work.ql[i] = flow.q[k] + s * (d0 + s * (c2 + s * c3))
        work.vl[i] = (d0 + s * (2.0 * c2 + 3.0 * s * c3)) / h
    for i in range(GAP_SIZE):
        gap[i] = 0.0
    call_gap(tables, address, c, work.ql, work.vl, gap)


@compiled
def _contact_part(h, gap0, rate0, gap1, rate1):
    """Begin and end of closed contact within a step, as fractions of it; (0, 1) without onset and separation."""
    if gap0 > 0.0 >= gap1:
        return crossing(h, gap0, rate0, gap1, rate1), 1.0
    if gap0 < 0.0 < gap1:
        return 0.0, crossing(h, -gap0, -rate0, -gap1, -rate1)
    return 0.0, 1.0
