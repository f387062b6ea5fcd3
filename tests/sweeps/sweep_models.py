"""Functions and models that worker processes import."""

import os
import time
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np

import flexmb as fm
from flexmb.dynamics.systems.given import Map

OMEGA, DAMPING = 1.2, 0.1


def logistic(x, r):
    return [r * x[0] * (1.0 - x[0])]


def logistic_map(r: Annotated[float, "1/s"], start=0.3):
    """A map.

    Parameters
    ----------
    r : growth a year.
    start : where it starts.
    """
    if 3.3 < r < 3.32:
        raise fm.errors.InputError(f"r is {r:.4f}; it must not be.")
    return Map(logistic, [start], parameters={"r": r})


def slow_map(r, pause=0.05):
    time.sleep(pause)
    return logistic_map(r)


def mortal_map(r, flag):
    """Kills its worker at r = 3 as long as the file is there."""
    if r == 3.0 and Path(flag).exists():
        os._exit(1)
    return logistic_map(r)


def results(a, b):
    if a == 2 and b == 5.0:
        raise ZeroDivisionError(f"no result of {object()!r}")
    return {"sum": a + b, "powers": a ** np.arange(3.0), "root": complex(0.0, b), "word": f"{a}"}


def uneven(a):
    return {"x": np.zeros(2 if a < 2 else 3)}


def slow_results(a, b):
    time.sleep(0.05)
    return results(a, b)


def leaves(a):
    raise SystemExit(3)


@fm.element_kernel
def well_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    amplitude, omega, damping = p
    r[0] = damping * v[0] - q[0] + q[0] ** 3 - amplitude * np.cos(omega * t)
    K[0, 0] = 3.0 * q[0] ** 2 - 1.0
    C[0, 0] = damping


@dataclass(frozen=True)
class Well(fm.Element):
    """Two valleys, x^4 / 4 - x^2 / 2, with a damper and a force that turns to and fro.

    Parameters
    ----------
    name : its name.
    body : what moves in it.
    amplitude : of the force [N].
    omega : its angular frequency [rad/s].
    damping : of the damper [N s/m].
    """

    body: fm.Part
    amplitude: float
    omega: float = OMEGA
    damping: float = DAMPING
    kernel = well_kernel
    coords = ("body.x",)


def bistable(amplitude=0.1):
    """A mass that starts in the right one of two valleys: x'' + 0.1 x' - x + x^3 = amplitude cos 1.2 t."""
    mass = fm.RigidBody("mass", (1.0, 0.0), 1.0, 1.0)
    return fm.Mechanism("bistable", [mass, Well("well", mass, amplitude)])


def content(folder):
    """All files of a folder, by their place in it."""
    return {str(file.relative_to(folder)): file.read_bytes() for file in Path(folder).rglob("*") if file.is_file()}


CARELESS = [100_000, 40, 90_000, 30]


def careless(most):
    """The last place of a slider after at most so many steps, as if the run had reached its end."""
    sol = fm.simulate(fm.mechanisms.slider_crank(200.0), t_end=5e-3, save=10, max_steps=most)
    return {"x": float(sol["slider.x"][-1])}


def named_by_itself(say):
    found = {"x": careless(40)["x"]}
    return [found, {**found, "ok": True, "status": "with 40 steps"}, {"ok": False}, {**found, "ok": 0.5}][say]


def started_by_a_run(r):
    """A map whose maker runs a mechanism first, which stops early for r > 3."""
    fm.simulate(fm.mechanisms.slider_crank(), t_end=1e-3, max_steps=3 if r > 3.0 else None)
    return logistic_map(r)


def long_run(k):
    return float(fm.simulate(fm.mechanisms.slider_crank(200.0 + k), t_end=0.05, step=1e-6, signals=[]).stats.steps)


@contextmanager
def interrupted_once(flag, calls):
    """Ctrl-C in a block of steps, the given number of blocks from now, if the file is there; which is removed."""
    from flexmb.run.run import Run

    block, count = Run.advance, [0]

    def advance(self, options, steps):
        count[0] += 1
        if count[0] >= calls and flag.exists():
            flag.unlink()
            raise KeyboardInterrupt
        return block(self, options, steps)

    Run.advance = advance
    try:
        yield
    finally:
        Run.advance = block
