"""Friction that changes within a step beyond its slopes: the change of its force takes their place.

A law without history turns round within a small slip, which steps leap over or into.  The slopes at both ends then
tell nothing of the change, by which a neighbour, whose slip s turns at another time, gains or loses speed.  With the
secant slope S = (T1 - T0) / (s1 - s0) at both ends, the slips of a neighbour are ds1/ds0 = (ds/dt)_1 / (ds/dt)_0, as
behind a jump of the force.  The accelerations at the end are those of the force there.

Equation (14.5) of docs/theory/design.md.
"""

from flexmb.engine.compiled.arrays import part_of
from flexmb.engine.sensitivity.histories import (
    OF_SLIP,
    contact_differences,
    find_joint_load,
    joint_differences,
    joint_friction_force,
)
from flexmb.engine.system.contacts import add_tangents, call_friction, call_gap, jacobians
from flexmb.engine.system.work import JOINT_FRICTION_FORCE, JOINT_SLIP, JOINT_T_BY_SLIP, T_BY_SLIP, gather
from flexmb.kernels import compiled
from flexmb.places import FRICTION_FORCE, LOAD, NORMAL_FORCE, SLIDING, SLIP, TANGENTIAL
from flexmb.program.program import BEGIN, END, FRICTION_Z, LOAD_KERNEL, Z_END

# Columns of `Tangents.turn` [N s/m]: forces at the end of the step by the slip at its start, and by that at its end
# beside the slope of the law; what of the latter is no part of the accelerations at the end; the slope that is, for the
# next step.
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
        if K.z[c, Z_END] > K.z[c, FRICTION_Z] or out[FRICTION_FORCE] == 0.0:
            T.turn[c, :] = 0.0
            continue
        slip = _slip_before(tables, address, c, T, work)
        before, slope, _ = call_friction(tables, address, c, h, slip, out[NORMAL_FORCE], T.z0, work.z_new)
        if not _turns(slip, before, slope, out[SLIP], out[FRICTION_FORCE], slopes[T_BY_SLIP], share, T.turn[c]):
            continue
        slopes[T_BY_SLIP] += T.turn[c, ENDING]
        gather(v, K.dofs, 6 * c, 6, work.vl)
        jacobians(out, work.contact_scratch)
        add_tangents(
            out, part_of(K.positions, 36 * c, 36 * c + 36), 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, T.turn[c, ENDING], 0.0, work
        )
    for c in range(C.kernel.shape[0]):
        k = K.kernel.shape[0] + c
        force, after = work.joint_friction[c, JOINT_FRICTION_FORCE], work.joint_friction[c, JOINT_SLIP]
        if C.joint_friction[c, LOAD_KERNEL] < 0 or C.joint_friction_z[c, END] > C.joint_friction_z[c, BEGIN]:
            continue
        slip = _joint_slip_before(tables, address, c, T, work)
        find_joint_load(tables, address, c, q, lam, work)
        out = work.joint_friction_out
        before, slope = joint_friction_force(tables, address, c, h, slip, out[LOAD], T.z0, work.z_new)
        if _turns(slip, before, slope, after, force, work.slopes[k, JOINT_T_BY_SLIP], share, T.turn[k]):
            _add_joint_turn(C, c, v, T.turn[k, ENDING], work)


@compiled
def _slip_before(tables, address, c, T, work):
    """Slip of contact c at the start of the step; its gap data are in work.gap."""
    gather(T.q0, tables.contacts.dofs, 6 * c, 6, work.ql)
    gather(T.v0, tables.contacts.dofs, 6 * c, 6, work.vl)
    call_gap(tables, address, c, work.ql, work.vl, work.gap)
    return work.gap[SLIP]


@compiled
def _joint_slip_before(tables, address, c, T, work):
    """Slip of joint c at the start of the step, for which its load kernel is called."""
    find_joint_load(tables, address, c, T.q0, T.lam0, work)
    slip, begin = 0.0, tables.constraints.dof[c]
    for i in range(6):
        slip += work.joint_friction_out[SLIDING + i] * T.v0[tables.constraints.dofs[begin + i]]
    return slip


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
    n, begin = C.dof[c + 1] - C.dof[c], C.dof[c]
    for j in range(6):
        slip_q = 0.0
        for k in range(6):
            slip_q += work.joint_friction_curve[k, j] * v[C.dofs[begin + k]]
        for i in range(6):
            work.lu[C.positions_h[C.pos_h[c] + n * i + j]] -= work.joint_friction_out[SLIDING + i] * slope * slip_q


@compiled
def add_turns(tables, address, T, work):
    """Add the forces by the slips at the start to T.F and T.turned, and secant slopes of joints to work.slopes."""
    # T.q, T.v are of the start.
    K, C = tables.contacts, tables.constraints
    for c in range(K.kernel.shape[0]):
        if T.turn[c, STARTING] == 0.0 and T.turn[c, ENDING] == 0.0:
            continue
        _slip_before(tables, address, c, T, work)
        contact_differences(K, c, work.gap, T.v0, T, work)
        jacobians(work.contact[c], work.contact_scratch)
        for j in range(T.q.shape[0]):
            T.turned[j, c] = T.turn[c, STARTING] * T.own[j, OF_SLIP]
            for i in range(6):
                T.F[j, K.dofs[6 * c + i]] += work.contact_scratch[TANGENTIAL, i] * T.turned[j, c]
    for c in range(C.kernel.shape[0]):
        k, begin = K.kernel.shape[0] + c, C.dof[c]
        if T.turn[k, STARTING] == 0.0 and T.turn[k, ENDING] == 0.0:
            continue
        find_joint_load(tables, address, c, T.q0, T.lam0, work)
        joint_differences(tables, c, T.v0, T, work)
        work.slopes[k, JOINT_T_BY_SLIP] += T.turn[k, ENDING]
        for j in range(T.q.shape[0]):
            T.turned[j, k] = T.turn[k, STARTING] * T.own[j, OF_SLIP]
            for i in range(6):
                T.F[j, C.dofs[begin + i]] += T.slip_direction[c, i] * T.turned[j, k]


@compiled
def has_turn(T):
    """Whether friction turned round in the step."""
    for k in range(T.turn.shape[0]):  # noqa: SIM110 - compiled
        if T.turn[k, STARTING] != 0.0 or T.turn[k, ENDING] != 0.0:
            return True
    return False


@compiled
def complete_turned(tables, address, q, v, lam, T, work):
    """Add the forces by the slips at the end to T.turned; T.q, T.v are of the end."""
    K, C = tables.contacts, tables.constraints
    for c in range(K.kernel.shape[0]):
        if T.turn[c, EXCESS] != 0.0:
            contact_differences(K, c, work.contact[c], v, T, work)
            for j in range(T.q.shape[0]):
                T.turned[j, c] += T.turn[c, EXCESS] * T.own[j, OF_SLIP]
    for c in range(C.kernel.shape[0]):
        k = K.kernel.shape[0] + c
        if T.turn[k, EXCESS] != 0.0:
            find_joint_load(tables, address, c, q, lam, work)
            joint_differences(tables, c, v, T, work)
            for j in range(T.q.shape[0]):
                T.turned[j, k] += T.turn[k, EXCESS] * T.own[j, OF_SLIP]


@compiled
def gather_turned(tables, j, T, work):
    """Set T.f to the forces in T.turned of neighbour j; contacts and joints are evaluated at the same state."""
    K, C = tables.contacts, tables.constraints
    T.f[:] = 0.0
    for c in range(K.kernel.shape[0]):
        if T.turn[c, STARTING] != 0.0 or T.turn[c, ENDING] != 0.0:
            jacobians(work.contact[c], work.contact_scratch)
            for i in range(6):
                T.f[K.dofs[6 * c + i]] += work.contact_scratch[TANGENTIAL, i] * T.turned[j, c]
    for c in range(C.kernel.shape[0]):
        k = K.kernel.shape[0] + c
        if T.turn[k, STARTING] != 0.0 or T.turn[k, ENDING] != 0.0:
            for i in range(6):
                T.f[C.dofs[C.dof[c] + i]] += T.slip_direction[c, i] * T.turned[j, k]
