"""Kernels of a plane cell on absolute coordinates: elasticity, damping, consistent mass, gravity.

The coordinates are (x, y) of its nodes in the world, or those of `pinned` where nodes lie on pins.  The mass matrix is
constant: accelerations of the nodes are absolute, so no centrifugal or Coriolis force is left out.
"""

from flexmb.compiled.views import matrix_view
from flexmb.kernels import account_kernel, element_kernel, energy_kernel, fast, force_kernel, tangent_kernel
from flexmb.planes.cell_numbers import (
    COROTATED,
    FORMULATION,
    GRAVITY_X,
    GRAVITY_Y,
    NODES,
    ZETA,
    mass_at,
    nodal,
    on_every_coordinate,
    square,
)
from flexmb.planes.corotated import corotated_damping, corotated_energy, corotated_force, corotated_tangent
from flexmb.planes.pinned import (
    arms_of_pin,
    matrix_on_coordinates,
    node_accelerations,
    node_places,
    node_rates,
    on_coordinates,
    pins_of,
    turned_arms,
)
from flexmb.planes.total_lagrange import lagrange_damping, lagrange_energy, lagrange_force, lagrange_tangent


@fast
def add_mass_times(p, a, gx, gy, r):
    """r += M (a - g), (2 m,)."""
    m, at = int(p[NODES]), mass_at(p)
    for k in range(m):
        x, y = 0.0, 0.0
        for l in range(m):
            mass = p[at + k * m + l]
            x += mass * (a[2 * l] - gx)
            y += mass * (a[2 * l + 1] - gy)
        r[2 * k] += x
        r[2 * k + 1] += y


@fast
def node_forces(p, x, v, a, r):
    """Forces r (2 m,) on the nodes."""
    if p[FORMULATION] == COROTATED:
        corotated_force(p, x, v, r)
    else:
        lagrange_force(p, x, v, r)
    add_mass_times(p, a, p[GRAVITY_X], p[GRAVITY_Y], r)


@fast
def node_tangent(p, x, v, a, kq, kv, ka, r, A):
    """Forces r (2 m,) on the nodes and A = kq K + kv C + ka M (2 m, 2 m)."""
    if p[FORMULATION] == COROTATED:
        corotated_tangent(p, x, v, kq, kv, r, A)
    else:
        lagrange_tangent(p, x, v, kq, kv, r, A)
    add_mass_times(p, a, p[GRAVITY_X], p[GRAVITY_Y], r)
    m, at = int(p[NODES]), mass_at(p)
    for k in range(m):
        for l in range(m):
            mass = ka * p[at + k * m + l]
            A[2 * k, 2 * l] += mass
            A[2 * k + 1, 2 * l + 1] += mass


@fast
def cell_forces(p, q, v, a, r):
    """Forces r (n,) on the coordinates."""
    if pins_of(p) == 0:
        node_forces(p, q, v, a, r)
        return
    arms, x, u, w, f = nodal(), nodal(), nodal(), nodal(), nodal()
    turned_arms(p, q, arms)
    node_places(p, q, arms, x)
    node_rates(p, v, arms, u)
    node_accelerations(p, v, a, arms, w)
    node_forces(p, x, u, w, f)
    r[:] = 0.0
    on_coordinates(p, arms, f, r)


@fast
def cell_tangents(p, q, v, a, kq, kv, ka, r, A):
    """Forces r (n,) and A = kq K + kv C + ka M (n, n)."""
    if pins_of(p) == 0:
        node_tangent(p, q, v, a, kq, kv, ka, r, A)
        return
    n = 2 * int(p[NODES])
    arms, x, u, w, f = nodal(), nodal(), nodal(), nodal(), nodal()
    B = matrix_view(square(), n, n)
    turned_arms(p, q, arms)
    node_places(p, q, arms, x)
    node_rates(p, v, arms, u)
    node_accelerations(p, v, a, arms, w)
    node_tangent(p, x, u, w, kq, kv, ka, f, B)
    r[:] = 0.0
    A[:, :] = 0.0
    on_coordinates(p, arms, f, r)
    matrix_on_coordinates(p, arms, B, A)
    for pin in range(pins_of(p)):
        add_turning(p, pin, x, v, a, kq, kv, arms, f, A)


@fast
def add_turning(p, pin, x, v, a, kq, kv, arms, f, A):
    """Add the tangent of the arms of a turning pin, by forces f (2 m,), damping and inertia."""
    n, theta = 2 * int(p[NODES]), 3 * pin + 2
    own, change, s = nodal(), nodal(), nodal()
    arms_of_pin(p, pin, arms, own)
    spin, gain = v[theta], a[theta]
    moved = 0.0
    for i in range(n):
        moved += own[i] * f[i]
        change[i], s[i] = -kq * spin * own[i], 0.0
    A[theta, theta] -= kq * moved
    if p[ZETA] > 0.0:
        if p[FORMULATION] == COROTATED:
            corotated_damping(p, x, change, s)
        else:
            lagrange_damping(p, x, change, s)
    for i in range(0, n, 2):
        along, across = -kq * gain - 2.0 * kv * spin, -kq * spin * spin
        change[i] = along * own[i] - across * own[i + 1]
        change[i + 1] = along * own[i + 1] + across * own[i]
    add_mass_times(p, change, 0.0, 0.0, s)
    column, size = on_every_coordinate(), A.shape[0]
    for i in range(size):
        column[i] = 0.0
    on_coordinates(p, arms, s, column)
    for i in range(size):
        A[i, theta] += column[i]


@fast
def node_energies(p, x, v):
    """Strain energy, potential of gravity [J], power of damping [W]."""
    strain, power = corotated_energy(p, x, v) if p[FORMULATION] == COROTATED else lagrange_energy(p, x, v)
    m, at = int(p[NODES]), mass_at(p)
    gravity = 0.0
    for k in range(m):
        mass = 0.0
        for l in range(m):
            mass += p[at + k * m + l]
        gravity -= mass * (p[GRAVITY_X] * x[2 * k] + p[GRAVITY_Y] * x[2 * k + 1])
    return strain, gravity, power


@fast
def cell_energies(p, q, v):
    """`node_energies` from the coordinates."""
    if pins_of(p) == 0:
        return node_energies(p, q, v)
    arms, x, u = nodal(), nodal(), nodal()
    turned_arms(p, q, arms)
    node_places(p, q, arms, x)
    node_rates(p, v, arms, u)
    return node_energies(p, x, u)


@fast
def cell_mass_times(p, q, v, Mv):
    """Mv = M v (n,)."""
    Mv[:] = 0.0
    if pins_of(p) == 0:
        add_mass_times(p, v, 0.0, 0.0, Mv)
        return
    arms, u, f = nodal(), nodal(), nodal()
    f[:] = 0.0
    turned_arms(p, q, arms)
    node_rates(p, v, arms, u)
    add_mass_times(p, u, 0.0, 0.0, f)
    on_coordinates(p, arms, f, Mv)


@element_kernel
def cell_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    """Plane cell of tri3, tri6, quad4 or quad9; q, r (n,), K, C, M (n, n)."""
    for X, kq, kv, ka in ((K, 1.0, 0.0, 0.0), (C, 0.0, 1.0, 0.0), (M, 0.0, 0.0, 1.0)):
        cell_tangents(p, q, v, a, kq, kv, ka, r, X)


@tangent_kernel
def cell_tangent(p, t, h, q, v, a, z, kq, kv, ka, r, A, z_new):
    """r (n,) and kq K + kv C + ka M (n, n)."""
    cell_tangents(p, q, v, a, kq, kv, ka, r, A)


@force_kernel
def cell_force(p, t, h, q, v, a, z, r, z_new):
    """Residual r (n,) alone."""
    cell_forces(p, q, v, a, r)


@energy_kernel
def cell_energy(p, t, q, v):
    """Strain energy, potential of gravity, power dissipated by damping."""
    return cell_energies(p, q, v)


@account_kernel
def cell_account(p, t, h, q, v, a, y, z, r, Mv, My, z_new):
    """r, M v, M y (n,); energies as `cell_energy` gives them."""
    cell_forces(p, q, v, a, r)
    cell_mass_times(p, q, v, Mv)
    cell_mass_times(p, q, y, My)
    return cell_energies(p, q, v)
