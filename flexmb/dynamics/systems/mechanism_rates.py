"""Rates and slopes of the state and the signals of a mechanism that stands somewhere in its motion."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexmb.start.consistent import accelerations

if TYPE_CHECKING:
    from flexmb.dynamics.systems.mechanism_flow import MechanismFlow

INSTANT = 1e-3
"""Time over which rates are taken that are not part of the state, in largest steps."""
NUDGE = 1e-6
"""Differences of states over which slopes of signals are taken, in lengths of the state."""


def velocity_of(flow: MechanismFlow) -> np.ndarray:
    """Rate (size,) of q, v, z, a, x: those of histories as a very short step leaves them, the others by the equations.

    The last two have the same rate: that of the true accelerations.
    """
    n, tau = flow.program.n_q, INSTANT * flow.run.h_max
    x = flow.state()
    q, v, z, a = x[:n], x[n : 2 * n], x[2 * n : -2 * n], x[-2 * n : -n]
    dz = np.zeros_like(z)
    if len(z):
        here = flow.snapshot()
        flow.advance(tau)
        dz = (flow.state()[2 * n : -2 * n] - z) / (flow.time - here.time)
        flow.restore(here)
    ahead, behind = (
        accelerations(flow.program, q + s * v + 0.5 * s * s * a, v + s * a, flow.time + s, z + s * dz)[0]
        for s in (tau, -tau)
    )
    jerk = (ahead - behind) / (2.0 * tau)
    return np.concatenate([v, a, dz, jerk, jerk])


def is_coordinate(flow: MechanismFlow, signal: int) -> bool:
    """Whether a signal is one of positions, velocities or accelerations, which come first."""
    return signal < 3 * flow.program.n_q


def row_of(flow: MechanismFlow, signal: int) -> int:
    """Place in a state of a signal that is a position, velocity or acceleration."""
    n = flow.program.n_q
    return signal if signal < 2 * n else signal + flow.program.tables.sizes.n_z


def rate_of(flow: MechanismFlow, signal: int) -> float:
    """Rate of a signal along the motion [units/s]."""
    n = flow.program.n_q
    if signal < 2 * n:
        return float(flow.state()[n + signal] if signal < n else flow.run.flow.a[signal - n])
    if is_coordinate(flow, signal):
        return float(velocity_of(flow)[row_of(flow, signal)])
    tau, rates = INSTANT * flow.run.h_max, velocity_of(flow)
    x = flow.state()
    ahead, behind = (value_at(flow, signal, x + s * rates, flow.time + s) for s in (tau, -tau))
    return (ahead - behind) / (2.0 * tau)


def slopes_of(flow: MechanismFlow, signal: int, tangents: np.ndarray) -> np.ndarray:
    """What differences (size, k) of the present state do to a signal: (k,)."""
    if is_coordinate(flow, signal):
        return tangents[row_of(flow, signal)].copy()
    x, weights, found = flow.state(), flow.weights, []
    scale = NUDGE * np.sqrt(float(weights @ x**2) or 1.0)
    for w in tangents.T:
        length = np.sqrt(float(weights @ w**2)) or float(np.abs(w).max()) or 1.0
        step = scale / length
        up, down = (value_at(flow, signal, x + s * w, flow.time) for s in (step, -step))
        found.append((up - down) / (2.0 * step))
    return np.array(found)


def value_at(flow: MechanismFlow, signal: int, state: np.ndarray, time: float) -> float:
    """A signal in another state, whose accelerations and forces follow from its positions, velocities and histories."""
    n, run, here = flow.program.n_q, flow.run, flow.snapshot()
    q, v, z = state[:n], state[n : 2 * n], state[2 * n : -2 * n]
    a, lam = accelerations(flow.program, q, v, time, z)
    arrays = run.flow
    arrays.q[:n], arrays.v[:n], arrays.a[:n], arrays.lam[:], arrays.z[:] = q, v, a, lam, z
    arrays.clock.t = time
    run.evaluate()
    value = float(run.record.signals[signal])
    flow.restore(here)
    return value
