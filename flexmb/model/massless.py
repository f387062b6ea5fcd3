"""Kernels of elements without mass and history, made of functions of a module: of its forces, and of its tangents.

The function `put_force(p, q, v, r)` fills r (n,), which is 0 before, and returns strain energy, potential of gravity
and the power that becomes heat.  A module without an element kernel of its own has `put_tangent(p, q, v, kq, kv, r,
A)`, too, which fills r and adds kq dr/dq + kv dr/dv to A.
"""

from typing import Any

from flexmb import kernels
from flexmb.engine.compiled.arrays import stack_vector
from flexmb.model.contributions import ElementKernels

MOST = 31  # coordinates of the largest of these elements, that of mass damping: two points, and nine nodes that turn
forces = stack_vector(MOST)


@kernels.compiled
def put_force(p, q, v, r):
    """Nothing, in place of the function of a module."""
    return 0.0, 0.0, 0.0


@kernels.compiled
def put_tangent(p, q, v, kq, kv, r, A):
    """Nothing, in place of the function of a module."""


@kernels.element_kernel
def element(p, t, h, q, v, a, z, r, K, C, M, z_new):
    """Forces and their tangents; no mass."""
    put_tangent(p, q, v, 1.0, 0.0, r, K)
    put_tangent(p, q, v, 0.0, 1.0, r, C)


@kernels.energy_kernel
def energy(p, t, q, v):
    """Strain energy, potential of gravity, power that becomes heat."""
    r = forces()
    for i in range(q.shape[0]):
        r[i] = 0.0
    return put_force(p, q, v, r)


@kernels.force_kernel
def force(p, t, h, q, v, a, z, r, z_new):
    """Forces alone."""
    put_force(p, q, v, r)


@kernels.tangent_kernel
def tangent(p, t, h, q, v, a, z, kq, kv, ka, r, A, z_new):
    """Forces, and A = kq K + kv C."""
    put_tangent(p, q, v, kq, kv, r, A)


@kernels.account_kernel
def account(p, t, h, q, v, a, y, z, r, Mv, My, z_new):
    """Forces; no mass; energies as `energy` gives them."""
    return put_force(p, q, v, r)


OWN = ElementKernels(element, energy, force, tangent, account)


def massless(name: str, functions: dict[str, Any], own: kernels.Kernel | None = None) -> ElementKernels:
    """Kernels of a module with the globals `functions`, which calls them `name`; `own`: its element kernel."""
    names, given = {**globals(), **functions}, OWN if own is None else OWN._replace(tangent=None)
    every = given._asdict().items()
    made: list[Any] = [kernel and kernels.rebound(kernel, f"{name}.{field}", names) for field, kernel in every]
    return ElementKernels(*made) if own is None else ElementKernels(*made)._replace(element=own)
