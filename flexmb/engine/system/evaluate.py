"""Evaluation of all elements, contacts and constraints at one state, and slopes along a motion.

An element that turns by s phi keeps its stiffness K in axes that turn along: R K R^T, with the slope

    phi (S K - K S),    S: (x, y, theta) -> (-y, x, 0) at each node

phi of an element is that by which this comes closest to the slope of its stiffness (least squares).
"""

from flexmb.engine.compiled.arrays import part_of
from flexmb.engine.system.constraints import add_constraints
from flexmb.engine.system.contacts import add_contacts
from flexmb.engine.system.elements import add_elements, call_element, call_tangent, evaluate_energies, gather_state
from flexmb.engine.system.work import turn_nodes
from flexmb.kernels import compiled


@compiled
def evaluate(tables, address, t, h, q, v, a, lam, z, kq, kv, ka, matrix, work):
    """Evaluate forces and constraint residuals; if `matrix`, also [[kq (K + H) + kv C + ka M, G^T], [G, 0]]."""
    # q, v, a : (n_q + 3,) with zeros for the ground; h : time since the history z was accepted [s]. Without the matrix
    # work.lu is unchanged, so that its factors can be reused.
    work.r[:] = work.Gl[:] = 0.0
    turn_nodes(tables, q, work)
    if matrix:
        work.lu[:] = 0.0
    add_elements(tables, address, t, h, q, v, a, z, kq, kv, ka, matrix, work)
    add_contacts(tables, address, t, h, q, v, z, kq, kv, matrix, work)
    add_constraints(tables, address, t, h, q, v, lam, z, kq, kv, matrix, work)


@compiled
def evaluate_accepted(tables, address, t, h, q, v, a, lam, z, x, y, work):
    """Evaluate forces, histories and energies at a state, without a matrix."""
    work.r[:] = work.Gl[:] = 0.0
    turn_nodes(tables, q, work)
    evaluate_energies(tables, address, t, h, q, v, a, x, y, z, work)
    add_contacts(tables, address, t, h, q, v, z, 0.0, 0.0, False, work)
    add_constraints(tables, address, t, h, q, v, lam, z, 0.0, 0.0, False, work)


COORDINATES = 3  # coordinates of a node: x, y, theta
ISOTROPIC = 1e-3  # change of a stiffness by a turn, over the stiffness, below which it has no direction


@compiled
def element_stiffness(tables, address, e, n, q, v, z, work):
    """K of element e at coordinates q, in work.Kl; v : zeros (n_q + 3,)."""
    gather_state(tables.elements, e, n, q, v, v, work)
    if tables.elements.tangent[e] < 0:
        call_element(tables, address, e, n, 0.0, 0.0, z, work)
    else:
        call_tangent(tables, address, e, n, 0.0, 0.0, z, 1.0, 0.0, 0.0, work)


@compiled
def turned_entry(dofs, n, K, i, j):
    """Entry (i, j) of S K - K S of an element with coordinates dofs (n,)."""
    value, row, column = 0.0, dofs[i] % COORDINATES, dofs[j] % COORDINATES
    if row == 0:
        value -= K[(i + 1) * n + j]
    elif row == 1:
        value += K[(i - 1) * n + j]
    if column == 0:
        value -= K[i * n + j + 1]
    elif column == 1:
        value += K[i * n + j - 1]
    return value


@compiled
def has_pairs(dofs, n):
    """Whether x and y of a node follow each other wherever one of them is a coordinate."""
    for i in range(n):
        axis, before, after = dofs[i] % COORDINATES, i - 1, i + 1
        if axis == 0 and (after == n or dofs[after] != dofs[i] + 1):
            return False
        if axis == 1 and (before < 0 or dofs[before] != dofs[i] - 1):
            return False
    return True


@compiled
def add_turns(tables, address, behind, q, ahead, v, stride, z, size, given, K, slope, work):
    """Set work.lu to the sum of phi (S K - K S) over all elements."""
    # behind, q, ahead : coordinates (n_q + 3,), a stride apart; v : zeros (n_q + 3,). given : (elements,) phi where it
    # is known, nan where it is not; size : (n_q + 3,) lengths by coordinates. K, slope : room for those of an element.
    E = tables.elements
    work.lu[:] = 0.0
    for e in range(E.p.shape[0]):
        n, dofs = E.dof[e + 1] - E.dof[e], part_of(E.dofs, E.dof[e], E.dof[e + 1])
        if n < 2 * (COORDINATES - 1) or not has_pairs(dofs, n):
            continue
        element_stiffness(tables, address, e, n, behind, v, z, work)
        for i in range(n * n):
            slope[i] = -work.Kl[i]
        element_stiffness(tables, address, e, n, ahead, v, z, work)
        for i in range(n * n):
            slope[i] = (slope[i] + work.Kl[i]) / (2.0 * stride)
        element_stiffness(tables, address, e, n, q, v, z, work)
        for i in range(n * n):
            K[i] = work.Kl[i]
        phi = given[e]
        if given[e] != given[e]:
            product, square, whole = 0.0, 0.0, 0.0
            for i in range(n):
                for j in range(n):
                    scale = size[dofs[i]] * size[dofs[j]]
                    turned = turned_entry(dofs, n, K, i, j) / scale
                    product += turned * slope[i * n + j] / scale
                    square += turned * turned
                    whole += (K[i * n + j] / scale) ** 2
            phi = product / square if square > ISOTROPIC * ISOTROPIC * whole else 0.0
        positions = part_of(E.positions, E.pos[e], E.pos[e + 1])
        for i in range(n):
            for j in range(n):
                work.lu[positions[i * n + j]] += phi * turned_entry(dofs, n, K, i, j)
