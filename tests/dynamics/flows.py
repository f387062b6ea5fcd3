"""Flows for the tests of periodic orbits: smooth equations, and a linear oscillator that strikes a stop."""

import math

import numpy as np
from scipy.integrate import solve_ivp

from flexmb.dynamics.systems.dynamics import Dynamics


class Flow(Dynamics):
    """What both kinds share: a start, parameters, time."""

    unit = "s"

    def __init__(self, start, parameters, names, name):
        self.start, self._parameters = np.array(start, dtype=np.float64), dict(parameters)
        self.names, self.units, self.name = tuple(names), ("",) * len(names), name
        self.reset()

    @property
    def time(self):
        return self._time

    @property
    def size(self):
        return len(self.start)

    @property
    def parameters(self):
        return dict(self._parameters)

    def state(self):
        return self.x.copy()

    def observe(self):
        return self.x.copy()

    def reset(self, state=None, *, time=0.0, parameters=None):
        for key, value in (parameters or {}).items():
            assert key in self._parameters
            self._parameters[key] = value
        self.x = np.array(self.start if state is None else state, dtype=np.float64)
        self._time, self.ok, self.status = float(time), True, "ready"

    def _like(self, other):
        other.reset(self.x, time=self._time)
        other.ok, other.status = self.ok, self.status
        return other


class Smooth(Flow):
    """x' = f(t, x, **parameters) with df/dx."""

    def __init__(self, f, slope, start, parameters, names, name="smooth", rtol=1e-11, atol=1e-13):
        self.f, self.slope, self.tolerances = f, slope, {"rtol": rtol, "atol": atol}
        super().__init__(start, parameters, names, name)

    def advance(self, duration, tangents=None):
        n, p = self.size, self._parameters
        k = 0 if tangents is None else tangents.shape[1]

        def rate(t, y):
            x = y[:n]
            found = np.asarray(self.f(t, x, **p), dtype=np.float64)
            if k == 0:
                return found
            return np.concatenate([found, (np.asarray(self.slope(t, x, **p)) @ y[n:].reshape(n, k)).ravel()])

        y = self.x if k == 0 else np.concatenate([self.x, tangents.ravel()])
        done = solve_ivp(rate, (self._time, self._time + duration), y, method="DOP853", **self.tolerances)
        self.ok = bool(done.success) and bool(np.isfinite(done.y[:, -1]).all())
        if not self.ok:
            self.status = f"stopped at {done.t[-1]:g}"
            return False
        self.x, self._time = done.y[:n, -1].copy(), self._time + duration
        if k:
            tangents[:] = done.y[n:, -1].reshape(n, k)
        return True

    def velocity(self):
        return np.asarray(self.f(self._time, self.x, **self._parameters), dtype=np.float64)

    def copy(self):
        start, p = self.start, self._parameters
        return self._like(type(self)(self.f, self.slope, start, p, self.names, self.name, **self.tolerances))


class Impact(Flow):
    """x'' + x = F cos(W t) between impacts; at x = wall with x' > 0 the speed becomes -e x'.

    The flight is exact, impacts are located to round-off; the tangent of an impact (x, v) -> (x, -e v) at a fixed wall
    is [[-e, 0], [(1 + e) a / v, -e]], v the speed before it, a the acceleration (P. C. Muller, Chaos, Solitons &
    Fractals 5 (1995) 1671-1681).
    """

    def __init__(self, start, parameters, name="impact"):
        super().__init__(start, parameters, ("x", "v", "gap"), name)

    @property
    def size(self):
        return 2

    def observe(self):
        return np.array([*self.x, self._parameters["wall"] - self.x[0]])

    def forced(self, t):
        F, W = self._parameters["F"], self._parameters["W"]
        c = F / (1.0 - W * W)
        return np.array([c * math.cos(W * t), -c * W * math.sin(W * t)])

    def flight(self, t0, x0, t):
        c, s = math.cos(t - t0), math.sin(t - t0)
        return np.array([[c, s], [-s, c]]) @ (x0 - self.forced(t0)) + self.forced(t)

    def acceleration(self, t, x):
        return self._parameters["F"] * math.cos(self._parameters["W"] * t) - x

    def advance(self, duration, tangents=None):
        end, e, wall = self._time + duration, self._parameters["e"], self._parameters["wall"]
        for _ in range(200):
            t = self.next_impact(end)
            hit = min(t, end)
            new = self.flight(self._time, self.x, hit)
            if tangents is not None:
                c, s = math.cos(hit - self._time), math.sin(hit - self._time)
                tangents[:] = np.array([[c, s], [-s, c]]) @ tangents
            self.x, self._time = new, hit
            if t > end:
                return True
            v = self.x[1]
            a = self.acceleration(hit, wall)
            if tangents is not None:
                tangents[:] = np.array([[-e, 0.0], [(1.0 + e) * a / v, -e]]) @ tangents
            self.x = np.array([wall, -e * v])
        self.ok, self.status = False, "too many impacts"
        return False

    def next_impact(self, end):
        """First time at which the wall is reached from below, inf beyond the end."""
        wall, n = self._parameters["wall"], max(int((end - self._time) * 40), 4)
        times = self._time + (end - self._time) * np.arange(n + 1) / n
        states = [self.flight(self._time, self.x, t) for t in times]
        for k in range(n):
            low, high = times[k], times[k + 1]
            if states[k][1] > 0.0 >= states[k + 1][1]:  # it turns back in between
                high = self.bisected(low, high, lambda x: x[1] < 0.0)
            above = self.flight(self._time, self.x, high)[0] > wall
            if above and (k > 0 or states[0][0] < wall - 1e-12):
                return self.bisected(low, high, lambda x: x[0] > wall)
        return math.inf

    def bisected(self, low, high, beyond):
        for _ in range(60):
            middle = 0.5 * (low + high)
            if beyond(self.flight(self._time, self.x, middle)):
                high = middle
            else:
                low = middle
        return high

    def copy(self):
        return self._like(type(self)(self.start, self._parameters, self.name))


def linear(omega0=1.0, zeta=0.1, F=1.0, W=1.7):
    def f(t, x, zeta, W):
        return [x[1], F * math.cos(W * t) - 2.0 * zeta * omega0 * x[1] - omega0**2 * x[0]]

    def slope(t, x, zeta, W):
        return [[0.0, 1.0], [-(omega0**2), -2.0 * zeta * omega0]]

    return Smooth(f, slope, [0.3, -0.2], {"zeta": zeta, "W": W}, ("x", "v"), "linear oscillator")


def duffing(d=0.1, beta=1.0, F=0.5, W=0.6, k=1.0):
    """x'' + d x' + k x + beta x^3 = F cos(W t)."""

    def f(t, x, d, F, W):
        return [x[1], F * math.cos(W * t) - d * x[1] - k * x[0] - beta * x[0] ** 3]

    def slope(t, x, d, F, W):
        return [[0.0, 1.0], [-k - 3.0 * beta * x[0] ** 2, -d]]

    return Smooth(f, slope, [0.0, 0.0], {"d": d, "F": F, "W": W}, ("x", "v"), "Duffing")


def van_der_pol(mu=1.0):
    def f(t, x, mu):
        return [x[1], mu * (1.0 - x[0] ** 2) * x[1] - x[0]]

    def slope(t, x, mu):
        return [[0.0, 1.0], [-2.0 * mu * x[0] * x[1] - 1.0, mu * (1.0 - x[0] ** 2)]]

    return Smooth(f, slope, [2.0, 0.0], {"mu": mu}, ("x", "v"), "Van der Pol")


def pendulum(g=0.9, q=2.0, W=2.0 / 3.0):
    """theta'' + theta'/q + sin(theta) = g cos(W t) (Baker and Gollub)."""

    def f(t, x, g):
        return [x[1], g * math.cos(W * t) - x[1] / q - math.sin(x[0])]

    def slope(t, x, g):
        return [[0.0, 1.0], [-math.cos(x[0]), -1.0 / q]]

    return Smooth(f, slope, [0.2, 0.0], {"g": g}, ("theta", "omega"), "pendulum")
