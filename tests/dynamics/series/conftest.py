"""Signals of systems whose exponents and dimensions are published; each is embedded once."""

import math
from functools import cache

import numpy as np
import pytest

from flexmb.dynamics.series import embedding as states
from flexmb.dynamics.series import exponent
from flexmb.dynamics.series.embedding import embedding


@pytest.fixture(scope="session", autouse=True)
def embedded_once():
    """Methods share the embedding of a signal: the same bits give the same embedding."""

    @cache
    def found(samples, options):
        return embedding(np.frombuffer(samples), **dict(options))

    def remembered(signal, **options):
        return found(np.asarray(signal, dtype=float).tobytes(), tuple(options.items()))

    with pytest.MonkeyPatch.context() as patch:
        for module in (states, exponent):
            patch.setattr(module, "embedding", remembered)
        yield


def henon(count, a=1.4, b=0.3, *, start=(0.1, 0.1), skip=1000):
    (x, y), found = start, []
    for _ in range(count + skip):
        x, y = 1.0 - a * x * x + y, b * x
        found.append((x, y))
    return np.array(found[skip:])


def logistic(count, r, *, start=0.3123, skip=1000):
    x, found = start, []
    for _ in range(count + skip):
        x = r * x * (1.0 - x)
        found.append(x)
    return np.array(found[skip:])


def circle(count, rotation, coupling, *, start=0.1):
    """Angles [rad] of the sine circle map: quasi-periodic while the coupling is below 1."""
    angle, found = start, []
    for _ in range(count):
        found.append(angle)
        angle += 2.0 * math.pi * rotation - coupling * math.sin(angle)
    return np.array(found)


def orbit(rate, start, interval, count, *, parts, skip=1000):
    """States (count, 3) of an ordinary differential equation, Runge-Kutta steps of interval / parts."""
    h, x, found = interval / parts, start, []
    for _ in range(count + skip):
        for _ in range(parts):
            k1 = rate(*x)
            k2 = rate(*(a + 0.5 * h * b for a, b in zip(x, k1, strict=True)))
            k3 = rate(*(a + 0.5 * h * b for a, b in zip(x, k2, strict=True)))
            k4 = rate(*(a + h * b for a, b in zip(x, k3, strict=True)))
            x = tuple(a + h / 6 * (p + 2 * q + 2 * r + s) for a, p, q, r, s in zip(x, k1, k2, k3, k4, strict=True))
        found.append(x)
    return np.array(found[skip:])


def lorenz_rate(x, y, z):
    return 10.0 * (y - x), x * (28.0 - z) - y, x * y - 8.0 / 3.0 * z


def rossler_rate(x, y, z):
    return -y - z, x + 0.2 * y, 0.2 + z * (x - 5.7)


@pytest.fixture(scope="session")
def signals():
    """Name -> (samples, interval [s] or None)."""
    h, lorenz = henon(10000), orbit(lorenz_rate, (1.0, 1.0, 20.0), 0.03, 20000, parts=3)
    rossler, t = orbit(rossler_rate, (1.0, 1.0, 0.0), 0.2, 20000, parts=4), 0.1 * np.arange(5000)
    found = {"henon x": (h[:, 0], None), "henon y": (h[:, 1], None), "logistic": (logistic(5000, 4.0), None)}
    found |= {f"lorenz {name}": (lorenz[:, k], 0.03) for k, name in enumerate("xyz")}
    found |= {f"rossler {name}": (rossler[:, k], 0.2) for k, name in enumerate("xyz")}
    found["sine"] = (np.sin(t), 0.1)
    found["two sines"] = (np.sin(t) + np.sin(math.sqrt(2.0) * t), 0.1)
    found["decay"] = (np.exp(-t / 100.0) * np.sin(t), 0.1)
    found["noise"] = (np.random.default_rng(0).standard_normal(5000), None)
    found["constant"] = (np.full(2000, 0.1), 0.1)
    found["constant, rounded"] = (0.1 + 1e-17 * np.arange(2000), 0.1)
    found["ramp"] = (t, 0.1)
    for r, name in ((2.8, "period 1"), (3.2, "period 2"), (3.5, "period 4"), (3.83, "period 3")):
        found[name] = (logistic(2000, r), None)
    return found


@pytest.fixture(scope="session")
def maps():
    """The maps themselves: `logistic`, `henon`, `circle`."""
    return {"logistic": logistic, "henon": henon, "circle": circle}
