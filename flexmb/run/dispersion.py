"""Phase and amplitude that the steps of a method lose in an undamped vibration."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from flexmb.step.method import Method
from flexmb.step.newmark.method import Newmark
from flexmb.step.radau.method import RadauIIA
from flexmb.step.runge_kutta import RungeKutta4


class Loss(NamedTuple):
    """Loss of a vibration in a number of steps.

    Parameters
    ----------
    phase : lag behind the exact vibration at the end [rad].
    amplitude : lost share of the amplitude; below 0 where it grows.
    """

    phase: float
    amplitude: float


def loss_of(method: Method, omega: float, h: float, steps: float, *, first_order: bool = False) -> Loss | None:
    """Loss of an undamped vibration in a number of equal steps; None for a method whose factor is not known."""
    factor = amplification(method, omega * h, first_order=first_order)
    if factor is None:
        return None
    with np.errstate(over="ignore"):
        kept = float(np.abs(factor) ** steps)
    return Loss(steps * (omega * h - float(np.angle(factor))), 1.0 - kept)


def amplification(method: Method, angle: float, *, first_order: bool = False) -> complex | None:
    """Factor by which a step multiplies a vibration exp(i omega t); exact is exp(i omega h).

    Of Newmark's family the principal eigenvalue of the amplification matrix, of Runge-Kutta methods R(i omega h).

    Notes
    -----
    Sources: J. Chung, G. M. Hulbert, A time integration algorithm for structural dynamics with improved numerical
    dissipation: the generalized-alpha method, Journal of Applied Mechanics 60 (1993) 371-375; E. Hairer, G. Wanner,
    Solving Ordinary Differential Equations II, 2nd ed., Springer 1996, IV.3.
    """
    z = 1j * angle
    if isinstance(method, RungeKutta4):
        return 1.0 + z * (1.0 + z / 2.0 * (1.0 + z / 3.0 * (1.0 + z / 4.0)))
    if isinstance(method, RadauIIA):
        return (1.0 + 0.4 * z + z**2 / 20.0) / (1.0 - 0.6 * z + 0.15 * z**2 - z**3 / 60.0)
    if not isinstance(method, Newmark):
        return None
    am, af, beta, gamma = method.alpha_m, method.alpha_f, method.beta, method.gamma
    if first_order:  # x1 = x + (1 - gamma) x' + gamma x1', in the unknowns x, h x'
        after = np.array([[1.0, -gamma], [-(1.0 - af) * z, 1.0 - am]])
        before = np.array([[1.0, 1.0 - gamma], [af * z, -am]])
        values = np.linalg.eigvals(np.linalg.solve(after, before))
        return complex(values[np.argmin(np.abs(values - np.exp(z)))])
    k = angle**2  # with a = -k q / h^2, in the unknowns q, h v, h^2 x at both ends of a step
    after = np.array([[1.0, 0.0, -beta], [0.0, 1.0, -gamma], [(1.0 - af) * k, 0.0, 1.0 - am]])
    before = np.array([[1.0, 1.0, 0.5 - beta], [0.0, 1.0, 1.0 - gamma], [-af * k, 0.0, -am]])
    values = np.linalg.eigvals(np.linalg.solve(after, before))
    return complex(values[np.argmin(np.abs(values - np.exp(z)))])
