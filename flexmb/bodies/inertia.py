"""Mass and moment of inertia of a node, and of a point between nodes: kernels and pieces."""

from collections.abc import Sequence

from flexmb.kernels import account_kernel, compiled, element_kernel, energy_kernel, force_kernel, tangent_kernel
from flexmb.model.contributions import ElementContribution, node_coordinates
from flexmb.model.shape import Point
from flexmb.places import packed

MASS, INERTIA, GRAVITY_X, GRAVITY_Y = range(4)
"""Parameters p of the mass of a node."""


@element_kernel
def node_mass_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    """Rigid body at its centre of mass (x, y, theta): r = m (a - g), J alpha."""
    node_force(p, a, r)
    M[0, 0] = p[MASS]
    M[1, 1] = p[MASS]
    M[2, 2] = p[INERTIA]


@compiled
def node_force(p, a, r):
    """r (3,) of a rigid body."""
    m, J, gx, gy = p
    r[0] = m * (a[0] - gx)
    r[1] = m * (a[1] - gy)
    r[2] = J * a[2]


@force_kernel
def node_mass_force(p, t, h, q, v, a, z, r, z_new):
    """Residual r (3,) alone."""
    node_force(p, a, r)


@tangent_kernel
def node_mass_tangent(p, t, h, q, v, a, z, kq, kv, ka, r, A, z_new):
    """r (3,) and ka M, a diagonal."""
    node_force(p, a, r)
    A[0, 0] = ka * p[MASS]
    A[1, 1] = ka * p[MASS]
    A[2, 2] = ka * p[INERTIA]


@compiled
def node_weight(p, q):
    """Potential energy of gravity of a rigid body."""
    return -p[MASS] * (p[GRAVITY_X] * q[0] + p[GRAVITY_Y] * q[1])


@energy_kernel
def node_mass_energy(p, t, q, v):
    """Potential energy of gravity alone."""
    return 0.0, node_weight(p, q), 0.0


@account_kernel
def node_mass_account(p, t, h, q, v, a, y, z, r, Mv, My, z_new):
    """r, M v, M y (3,); energies as `node_mass_energy` gives them."""
    node_force(p, a, r)
    for x, Mx in ((v, Mv), (y, My)):
        Mx[0] = p[MASS] * x[0]
        Mx[1] = p[MASS] * x[1]
        Mx[2] = p[INERTIA] * x[2]
    return 0.0, node_weight(p, q), 0.0


def node_mass(part: str, node: str, mass: float, inertia: float, gravity: Point) -> ElementContribution:
    """Contribution of a rigid mass `mass` [kg] with moment of inertia `inertia` [kg m^2] at a node."""
    gx, gy = gravity
    p = packed({MASS: mass, INERTIA: inertia, GRAVITY_X: gx, GRAVITY_Y: gy})
    return ElementContribution(
        part,
        node_mass_kernel,
        node_coordinates(part, node),
        p,
        energy=node_mass_energy,
        force=node_mass_force,
        tangent=node_mass_tangent,
        account=node_mass_account,
    )


@element_kernel
def mean_mass_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    """Mass at the mean of n points, q = (x1, y1, x2, y2, ...): T = m/2 |mean velocity|^2."""
    m, gx, gy = p
    share_out(m, -gx, -gy, a, r)
    n = q.shape[0] // 2
    for i in range(n):
        for j in range(n):
            M[2 * i, 2 * j] = m / (n * n)
            M[2 * i + 1, 2 * j + 1] = m / (n * n)


@compiled
def mean(x):
    """Mean of n points."""
    n = x.shape[0] // 2
    a, b = 0.0, 0.0
    for i in range(n):
        a += x[2 * i] / n
        b += x[2 * i + 1] / n
    return a, b


@compiled
def share_out(m, bx, by, x, r):
    """m (mean of x + b), shared equally by n points."""
    n = x.shape[0] // 2
    cx, cy = mean(x)
    for i in range(n):
        r[2 * i] = m / n * (cx + bx)
        r[2 * i + 1] = m / n * (cy + by)


@force_kernel
def mean_mass_force(p, t, h, q, v, a, z, r, z_new):
    """Residual r (2 n,) alone."""
    m, gx, gy = p
    share_out(m, -gx, -gy, a, r)


@compiled
def mean_weight(p, q):
    """Potential energy of gravity of a mass at the mean of n points."""
    x, y = mean(q)
    m, gx, gy = p
    return -m * (gx * x + gy * y)


@energy_kernel
def mean_mass_energy(p, t, q, v):
    """Potential energy of gravity alone."""
    return 0.0, mean_weight(p, q), 0.0


@account_kernel
def mean_mass_account(p, t, h, q, v, a, y, z, r, Mv, My, z_new):
    """r, M v, M y (2 n,); energies as `mean_mass_energy` gives them."""
    m, gx, gy = p
    share_out(m, -gx, -gy, a, r)
    share_out(m, 0.0, 0.0, v, Mv)
    share_out(m, 0.0, 0.0, y, My)
    return 0.0, mean_weight(p, q), 0.0


def mean_mass(part: str, nodes: Sequence[str], mass: float, gravity: Point) -> ElementContribution:
    """Contribution of a point mass [kg] held at the mean position of several nodes."""
    coordinates = tuple(c for node in nodes for c in node_coordinates(part, node)[:2])
    return ElementContribution(
        part,
        mean_mass_kernel,
        coordinates,
        (mass, *gravity),
        energy=mean_mass_energy,
        force=mean_mass_force,
        account=mean_mass_account,
    )
