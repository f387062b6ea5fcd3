"""Mass and moment of inertia of a node, and of a point between nodes: kernels and pieces."""

from flexmb.kernels import element_kernel, energy_kernel
from flexmb.model.pieces import ElementPiece, node_coordinates


@element_kernel
def node_mass_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    """Rigid body at its centre of mass (x, y, theta): r = m (a - g), J alpha."""
    m, J, gx, gy = p
    r[0] = m * (a[0] - gx)
    r[1] = m * (a[1] - gy)
    r[2] = J * a[2]
    M[0, 0] = m
    M[1, 1] = m
    M[2, 2] = J


@energy_kernel
def node_mass_energy(p, t, q, v):
    """Potential energy of gravity of a rigid body."""
    m, J, gx, gy = p
    return 0.0, -m * (gx * q[0] + gy * q[1]), 0.0


def node_mass(part, node, mass, inertia, gravity):
    """Piece of a rigid mass `mass` [kg] with moment of inertia `inertia` [kg m^2] at a node."""
    p = (mass, inertia, *gravity)
    return ElementPiece(part, node_mass_kernel, node_coordinates(part, node), p, energy=node_mass_energy)


@element_kernel
def mean_mass_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    """Mass at the mean of n points, q = (x1, y1, x2, y2, ...): T = m/2 |mean velocity|^2."""
    m, gx, gy = p
    n = q.shape[0] // 2
    ax = 0.0
    ay = 0.0
    for i in range(n):
        ax += a[2 * i] / n
        ay += a[2 * i + 1] / n
    for i in range(n):
        r[2 * i] = m / n * (ax - gx)
        r[2 * i + 1] = m / n * (ay - gy)
        for j in range(n):
            M[2 * i, 2 * j] = m / (n * n)
            M[2 * i + 1, 2 * j + 1] = m / (n * n)


@energy_kernel
def mean_mass_energy(p, t, q, v):
    """Potential energy of gravity of a mass at the mean of n points."""
    m, gx, gy = p
    n = q.shape[0] // 2
    height = 0.0
    for i in range(n):
        height += (gx * q[2 * i] + gy * q[2 * i + 1]) / n
    return 0.0, -m * height, 0.0


def mean_mass(part, nodes, mass, gravity):
    """Piece of a point mass [kg] held at the mean position of several nodes."""
    coordinates = tuple(c for node in nodes for c in node_coordinates(part, node)[:2])
    return ElementPiece(part, mean_mass_kernel, coordinates, (mass, *gravity), energy=mean_mass_energy)
