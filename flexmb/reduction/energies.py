"""Energies of the element of a reduced body, without its forces; the account of a step needs them twice."""

from flexmb.compiled.views import block_of, row_of
from flexmb.kernels import fast
from flexmb.reduction.kernel import (
    BY_PIN,
    COUNT,
    DD,
    GRAVITY_X,
    GRAVITY_Y,
    HEAD,
    MASS,
    MD,
    MK,
    MODAL,
    MOMENT_X,
    MOMENT_Y,
    T1,
    T2,
    T3,
    ZETA,
    D,
    E,
    U,
    W,
    begin,
    deformation,
    dot,
    frame_of,
    shortened,
    times,
    times_two,
    to_frame,
    weighed,
)


@fast
def energies(p, q, v, x):
    """Strain energy, potential of gravity, power of damping."""
    n, zeta = int(p[COUNT]), p[ZETA]
    c, s, angle, size = frame_of(p, q)
    deformation(p, q, c, s, angle, x)
    rates(p, c, s, size, v, x)
    e, e_rate, force, work = row_of(x, T1, n), row_of(x, T2, n), row_of(x, E, n), row_of(x, T3, n)
    shortened(p, x, e, e_rate)
    times_two(block_of(p, begin(p, MK), n, n), e, e_rate, force, work)
    strain, power = 0.5 * dot(e, force), zeta * dot(e_rate, work)
    if p[MODAL] != 0.0:
        times(block_of(p, begin(p, MD), n, n), e_rate, work)
        power += dot(e_rate, work)
    return strain, gravity_energy(p, q, c, s, x), power


@fast
def rates(p, c, s, size, v, x):
    """Fill w and d' from velocities v."""
    n = int(p[COUNT])
    w, u, rate = row_of(x, W, n), row_of(x, U, n), row_of(x, DD, n)
    to_frame(c, s, v, x[W])
    _, spin = weighed(p, w)
    spin = w[2] if p[BY_PIN] != 0.0 else spin / size
    for i in range(0, n, 3):
        rate[i], rate[i + 1] = w[i] - w[0] - spin * u[i], w[i + 1] - w[1] - spin * u[i + 1]
        rate[i + 2] = w[i + 2] - spin


@fast
def gravity_energy(p, q, c, s, x):
    """Potential of gravity."""
    n = int(p[COUNT])
    ex, ey = p[MOMENT_X] - p[MASS] * p[HEAD], p[MOMENT_Y] - p[MASS] * p[HEAD + 1]
    for i in range(n):
        ex += p[HEAD + 2 * n + i] * x[D, i]
        ey += p[HEAD + 3 * n + i] * x[D, i]
    mx, my = p[MASS] * q[0] + c * ex - s * ey, p[MASS] * q[1] + s * ex + c * ey
    return -(p[GRAVITY_X] * mx + p[GRAVITY_Y] * my)
