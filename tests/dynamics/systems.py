"""Systems with known answers: equations, exact solutions, published exponents."""

import numpy as np
from scipy.optimize import brentq

import flexmb as fm

TURN = 2.0 * np.pi


def henon():
    """x' = 1 - a x^2 + y, y' = b x at a = 1.4, b = 0.3."""
    return fm.chaos.Map(
        lambda x, a, b: [1.0 - a * x[0] ** 2 + x[1], b * x[0]],
        [0.1, 0.1],
        jacobian=lambda x, a, b: [[-2.0 * a * x[0], 1.0], [b, 0.0]],
        parameters={"a": 1.4, "b": 0.3},
        name="henon",
    )


def standard_map(K):
    return fm.chaos.Map(
        lambda x, K: [x[0] + x[1] + K * np.sin(x[0]), x[1] + K * np.sin(x[0])],
        [0.1, 0.2],
        jacobian=lambda x, K: [[1.0 + K * np.cos(x[0]), 1.0], [K * np.cos(x[0]), 1.0]],
        parameters={"K": K},
        name="standard map",
    )


def high_bounce(alpha, gamma):
    """A ball on a vibrating table that bounces high: phase and speed after each impact (P. J. Holmes, 1982).

    It starts beside the point that repeats once a turn: speed 2 pi, gamma cos(phase) = -2 pi (1 - alpha), on the
    branch that is stable for small gamma.
    """
    phase = TURN - np.arccos(-TURN * (1.0 - alpha) / gamma)
    return fm.chaos.Map(
        lambda x, a, g: [x[0] + x[1], a * x[1] - g * np.cos(x[0] + x[1])],
        [phase + 1e-3, TURN],
        jacobian=lambda x, a, g: [[1.0, 1.0], [g * np.sin(x[0] + x[1]), a + g * np.sin(x[0] + x[1])]],
        parameters={"a": alpha, "g": gamma},
        names=["phase", "speed"],
        name="bouncing ball",
    )


def lorenz(**options):
    return fm.chaos.ODE(
        lambda t, x, s, r, b: np.array([s * (x[1] - x[0]), x[0] * (r - x[2]) - x[1], x[0] * x[1] - b * x[2]]),
        [1.0, 1.0, 20.0],
        jacobian=lambda t, x, s, r, b: np.array([[-s, s, 0.0], [r - x[2], -1.0, -x[0]], [x[1], x[0], -b]]),
        parameters={"s": 10.0, "r": 28.0, "b": 8.0 / 3.0},
        names=["x", "y", "z"],
        name="lorenz",
        **options,
    )


def rossler(**options):
    return fm.chaos.ODE(
        lambda t, x: np.array([-x[1] - x[2], x[0] + 0.2 * x[1], 0.2 + x[2] * (x[0] - 5.7)]),
        [1.0, 0.0, 0.0],
        jacobian=lambda t, x: np.array([[0.0, -1.0, -1.0], [1.0, 0.2, 0.0], [x[2], 0.0, x[0] - 5.7]]),
        name="rossler",
        **options,
    )


def van_der_pol(mu=1.0, **options):
    return fm.chaos.ODE(
        lambda t, x, mu: np.array([x[1], mu * (1.0 - x[0] ** 2) * x[1] - x[0]]),
        [2.0, 0.0],
        parameters={"mu": mu},
        names=["x", "v"],
        name="van der pol",
        **options,
    )


def pendulum(**options):
    """x'' + 0.1 x' + sin x = 2.5 sin t."""
    return fm.chaos.ODE(
        lambda t, x: np.array([x[1], 2.5 * np.sin(t) - 0.1 * x[1] - np.sin(x[0])]),
        [0.0, 0.0],
        jacobian=lambda t, x: np.array([[0.0, 1.0], [-np.cos(x[0]), -0.1]]),
        names=["x", "v"],
        period=TURN,
        name="pendulum",
        **options,
    )


def duffing(**options):
    """x'' + 0.05 x' + x^3 = 7.5 cos t, the case of Ueda."""
    return fm.chaos.ODE(
        lambda t, x: np.array([x[1], 7.5 * np.cos(t) - 0.05 * x[1] - x[0] ** 3]),
        [1.0, 0.0],
        jacobian=lambda t, x: np.array([[0.0, 1.0], [-3.0 * x[0] ** 2, -0.05]]),
        names=["x", "v"],
        period=TURN,
        name="duffing",
        **options,
    )


def oscillator(damping, stiffness=1.0, force=0.0, frequency=1.0, **options):
    """x'' + damping x' + stiffness x = force cos(frequency t)."""
    return fm.chaos.ODE(
        lambda t, x, c, k, F, w: [x[1], F * np.cos(w * t) - c * x[1] - k * x[0]],
        [1.0, 0.0],
        parameters={"c": damping, "k": stiffness, "F": force, "w": frequency},
        names=["x", "v"],
        period=lambda w, **_: TURN / w,
        name="oscillator",
        **options,
    )


def henon_heiles(energy=0.125):
    y = -0.15
    vx = np.sqrt(2.0 * (energy - y**2 / 2.0 + y**3 / 3.0))
    return fm.chaos.ODE(
        lambda t, x: np.array([x[2], x[3], -x[0] - 2.0 * x[0] * x[1], -x[1] - x[0] ** 2 + x[1] ** 2]),
        [0.0, y, vx, 0.0],
        jacobian=lambda t, x: np.array(
            [
                [0.0, 0.0, 1.0, 0.0],
                [0.0, 0.0, 0.0, 1.0],
                [-1.0 - 2.0 * x[1], -2.0 * x[0], 0.0, 0.0],
                [-2.0 * x[0], -1.0 + 2.0 * x[1], 0.0, 0.0],
            ]
        ),
        names=["x", "y", "vx", "vy"],
        name="henon-heiles",
    )


class ImpactOscillator:
    """u'' + u = cos(w t) with a wall at u = s, speeds turned by -r: exact between impacts.

    Between impacts u = A cos t + B sin t + cos(w t) / (1 - w^2) (S. W. Shaw, P. J. Holmes, J. Sound Vib. 90 (1983)).
    """

    def __init__(self, w=2.8, s=0.0, r=0.8):
        self.w, self.s, self.r = w, s, r

    def flow(self):
        ode = fm.chaos.ODE(
            lambda t, x, w: [x[1], np.cos(w * t) - x[0]],
            [self.s - 1.0, 0.0],
            jacobian=lambda t, x, w: [[0.0, 1.0], [-1.0, 0.0]],
            parameters={"w": self.w},
            names=["u", "v"],
            period=lambda w: TURN / w,
            name="impact oscillator",
            rtol=1e-11,
            atol=1e-13,
        )
        return fm.chaos.ImpactODE(ode, gap=lambda t, x, w: self.s - x[0], jump=lambda t, x, w: [x[0], -self.r * x[1]])

    def between(self, t0, u0, v0, t):
        """u and v at t of a flight that begins at t0."""
        g = 1.0 / (1.0 - self.w**2)
        a, b = u0 - g * np.cos(self.w * t0), v0 + g * self.w * np.sin(self.w * t0)
        c, d = np.cos(t - t0), np.sin(t - t0)
        u = a * c + b * d + g * np.cos(self.w * t)
        return u, -a * d + b * c - g * self.w * np.sin(self.w * t)

    def until(self, t, u, v, end, fine=4e-3):
        """u and v at `end`, and the number of impacts on the way; impacts are found on a fine grid, then by Brent."""
        impacts = 0
        while True:
            grid = np.linspace(t, end, max(int((end - t) / fine), 8))[1:]
            hit = np.flatnonzero(self.between(t, u, v, grid)[0] > self.s)
            if not len(hit):
                return (*self.between(t, u, v, end), impacts)
            low = grid[hit[0] - 1] if hit[0] else t + 1e-9
            when = self.impact((t, u, v), low, grid[hit[0]])
            v, u, t, impacts = -self.r * self.between(t, u, v, when)[1], self.s, when, impacts + 1

    def impact(self, start, low, high):
        """When a flight from `start` meets the wall between two instants."""
        return brentq(lambda t: self.between(*start, t)[0] - self.s, low, high, xtol=1e-15, rtol=1e-15)
