"""Mass-proportional damping of a plane cell, on the velocity of deformation: kernels and their numbers.

The frame of the body has its origin in the point A and its x axis towards the point B, two nodes of the body.  With
a, b, x_k the places of A, B and the nodes, c = b - a, n = J c/|c|^2, J = [[0, -1], [1, 0]]:

Rate of the frame   omega = n . (b_dot - a_dot)
Deformation rate    u_k = x_k_dot - a_dot - omega J (x_k - a)
Forces              f = zeta m u on the nodes;  T = sum J (x_k - a) . f_k,  -sum f + T n on A,  -T n on B
Power               zeta u . m u >= 0

with m the consistent mass of the cell.  No rigid motion is damped, and the forces are in balance, moments included.
It is the damping of beams (`flexmb.elastic.beams.mass_damping`).  Equation (11.11) of docs/theory/plane_bodies.md.
"""

from collections.abc import Mapping

import numpy as np

from flexmb.elastic.planes.cells import Cells, Pin, ties_of
from flexmb.elastic.planes.elements import (
    FIRST,
    NODES,
    ON_PIN,
    nodal,
    node_places,
    node_rates,
    on_coordinates,
    product,
    tie_at,
    turned_arms,
)
from flexmb.kernels import account_kernel, element_kernel, energy_kernel, fast, force_kernel
from flexmb.model.contributions import ElementContribution, node_coordinates

ZETA, MASSES = 2, 3
"""Numbers p behind the numbers of nodes and pins: damping rate [1/s], mass matrix (m, m) [kg]; then the ties."""

POINTS = 4
"""Number of the coordinates of A and B, the first ones."""


@fast
def frame_rates(p, q, v, arms, e, u):
    """Arms from the pins, e = x - a and u (2 m,); c, |c|^2, omega and b_dot - a_dot."""
    turned_arms(p, q[POINTS:], arms)
    node_places(p, q[POINTS:], arms, e)
    node_rates(p, v[POINTS:], arms, u)
    cx, cy, wx, wy = q[2] - q[0], q[3] - q[1], v[2] - v[0], v[3] - v[1]
    square = cx * cx + cy * cy
    omega = (cx * wy - cy * wx) / square
    for k in range(int(p[NODES])):
        ex, ey = e[2 * k] - q[0], e[2 * k + 1] - q[1]
        e[2 * k], e[2 * k + 1] = ex, ey
        u[2 * k] += omega * ey - v[0]
        u[2 * k + 1] -= omega * ex + v[1]
    return cx, cy, square, omega, wx, wy


@fast
def damped_mass_times(p, u, f):
    """f = zeta m u (2 m,)."""
    m = int(p[NODES])
    for k in range(m):
        x, y = 0.0, 0.0
        for l in range(m):
            mass = p[MASSES + k * m + l]
            x += mass * u[2 * l]
            y += mass * u[2 * l + 1]
        f[2 * k], f[2 * k + 1] = p[ZETA] * x, p[ZETA] * y


@fast
def sums(p, e, f):
    """Sum of f (2 m,) along x and y, and of J e . f."""
    x, y, moment = 0.0, 0.0, 0.0
    for k in range(int(p[NODES])):
        x += f[2 * k]
        y += f[2 * k + 1]
        moment += e[2 * k] * f[2 * k + 1] - e[2 * k + 1] * f[2 * k]
    return x, y, moment


@fast
def add_on_points(x, y, tx, ty, r):
    """Forces on A and B: minus (x, y) and plus (tx, ty) on A, minus (tx, ty) on B."""
    r[0] += tx - x
    r[1] += ty - y
    r[2] -= tx
    r[3] -= ty


@fast
def put_force(p, q, v, r):
    """r (n,), and the power of damping."""
    arms, e, u, f = nodal(), nodal(), nodal(), nodal()
    cx, cy, square, _, _, _ = frame_rates(p, q, v, arms, e, u)
    damped_mass_times(p, u, f)
    r[:] = 0.0
    on_coordinates(p, arms, f, r[POINTS:])
    x, y, moment = sums(p, e, f)
    add_on_points(x, y, -moment * cy / square, moment * cx / square, r)
    return product(2 * int(p[NODES]), u, f)


@fast
def damping_power(p, q, v):
    """Power of damping [W]."""
    arms, e, u, f = nodal(), nodal(), nodal(), nodal()
    frame_rates(p, q, v, arms, e, u)
    damped_mass_times(p, u, f)
    return product(2 * int(p[NODES]), u, f)


@fast
def moved_nodes(p, v, arms, j, dx, dv):
    """Changes dx of the places and dv of the velocities (2 m,) by the coordinate j of the cell."""
    for k in range(int(p[NODES])):
        tie = tie_at(p, k)
        first = int(p[tie + FIRST])
        dx[2 * k], dx[2 * k + 1], dv[2 * k], dv[2 * k + 1] = 0.0, 0.0, 0.0, 0.0
        if j == first:
            dx[2 * k] = 1.0
        elif j == first + 1:
            dx[2 * k + 1] = 1.0
        elif j == first + 2 and p[tie + ON_PIN] > 0.0:
            dx[2 * k], dx[2 * k + 1] = -arms[2 * k + 1], arms[2 * k]
            dv[2 * k], dv[2 * k + 1] = -v[j] * arms[2 * k], -v[j] * arms[2 * k + 1]


@fast
def put_tangents(p, q, v, r, K, C):
    """r (n,), K and C (n, n), column by column."""
    arms, e, u, f, dx, du, df = nodal(), nodal(), nodal(), nodal(), nodal(), nodal(), nodal()
    cx, cy, square, omega, wx, wy = frame_rates(p, q, v, arms, e, u)
    damped_mass_times(p, u, f)
    _, _, moment = sums(p, e, f)
    put_force(p, q, v, r)
    nx, ny = -cy / square, cx / square
    hx, hy = (wy - 2.0 * omega * cx) / square, (-wx - 2.0 * omega * cy) / square  # omega by c
    K[:, :] = 0.0
    C[:, :] = 0.0
    n, m = r.shape[0], int(p[NODES])
    for j in range(n):
        ax, ay, bx, by = 1.0 * (j == 0), 1.0 * (j == 1), 1.0 * (j == 2), 1.0 * (j == 3)
        gx, gy = bx - ax, by - ay
        moved_nodes(p, v[POINTS:], arms, j - POINTS, dx, du)
        # velocity: u changes with dx in place of the velocity
        turn = nx * gx + ny * gy
        for k in range(m):
            df[2 * k] = dx[2 * k] - ax + turn * e[2 * k + 1]
            df[2 * k + 1] = dx[2 * k + 1] - ay - turn * e[2 * k]
        add_column(p, arms, e, df, nx, ny, 0.0, 0.0, 0.0, C[:, j])
        # place
        turn, torque = hx * gx + hy * gy, 0.0
        for k in range(m):
            x, y = dx[2 * k] - ax, dx[2 * k + 1] - ay
            du[2 * k] += turn * e[2 * k + 1] + omega * y
            du[2 * k + 1] -= turn * e[2 * k] + omega * x
            torque += x * f[2 * k + 1] - y * f[2 * k]
        along = 2.0 * (cx * gx + cy * gy) / square
        tx, ty = moment * (-gy / square - along * nx), moment * (gx / square - along * ny)
        add_column(p, arms, e, du, nx, ny, torque, tx, ty, K[:, j])
    for k in range(m):
        tie = tie_at(p, k)
        if p[tie + ON_PIN] > 0.0:
            theta = POINTS + int(p[tie + FIRST]) + 2
            K[theta, theta] -= arms[2 * k] * f[2 * k] + arms[2 * k + 1] * f[2 * k + 1]


@fast
def add_column(p, arms, e, change, nx, ny, torque, tx, ty, column):
    """Add the forces of a change of u (2 m,), with a change of T by `torque` and of T n by (tx, ty) beside it."""
    df = nodal()
    damped_mass_times(p, change, df)
    on_coordinates(p, arms, df, column[POINTS:])
    x, y, moment = sums(p, e, df)
    add_on_points(x, y, (moment + torque) * nx + tx, (moment + torque) * ny + ty, column)


@element_kernel
def cell_damping_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    """Damping of the rate of deformation; q = A, B (x, y), then the coordinates of the cell; r (n,), K, C (n, n)."""
    put_tangents(p, q, v, r, K, C)


@force_kernel
def cell_damping_force(p, t, h, q, v, a, z, r, z_new):
    """Residual r (n,) alone."""
    put_force(p, q, v, r)


@energy_kernel
def cell_damping_energy(p, t, q, v):
    """Energies: nothing stored, and the power of damping."""
    return 0.0, 0.0, damping_power(p, q, v)


@account_kernel
def cell_damping_account(p, t, h, q, v, a, y, z, r, Mv, My, z_new):
    """r (n,), no mass, the power of damping."""
    return 0.0, 0.0, put_force(p, q, v, r)


def damping_contributions(
    part: str, cells: Cells, nodes: Mapping[int, str], pins: Mapping[int, Pin], zeta: float, axis: tuple[str, str]
) -> list[ElementContribution]:
    """Contributions of all cells at a damping rate `zeta` [1/s]; `axis` are the names of the nodes A and B.

    `nodes` and `pins` as of `cells.cell_contributions`.
    """
    width, found = float(cells.cells.shape[1]), []
    ends = tuple(c for name in axis for c in node_coordinates(part, name)[:2])
    for numbers, mass in zip(cells.cells.tolist(), cells.masses.reshape(len(cells.cells), -1), strict=True):
        coordinates, ties, held = ties_of(part, numbers, cells.points, nodes, pins)
        p = (width, float(held), zeta, *mass.tolist(), *ties)
        found.append(
            ElementContribution(
                part,
                cell_damping_kernel,
                (*ends, *coordinates),
                p,
                energy=cell_damping_energy,
                force=cell_damping_force,
                account=cell_damping_account,
            )
        )
    return found


def far_node(points: np.ndarray, place: tuple[float, float]) -> int:
    """Number of the node (n, 2) that lies farthest from a place."""
    return int(np.linalg.norm(points - np.array(place), axis=1).argmax())
