"""A solution written down by hand: a crank that turns evenly, a beam bent into a circular arc, a joint with clearance.

crank  rigid, 0.2 m long, pinned at the origin, theta = SPEED t
arm    flexible, two elements, start at (1, 0) with theta = 0, of the constant curvature BEND sin(SPEED t)
P      joint with clearance at the tip of the crank; its journal circles in the bearing and is pressed with 100 sin^2 N
"""

import numpy as np

from flexmb.model.shape import BeamShape, PointShape, RigidShape
from flexmb.model.signal import Signal
from flexmb.results.solution import Peaks, Solution, Stats

RADIUS, SPEED, BEND, LENGTH = 0.1, 2.0 * np.pi, 0.5, 1.0
EI, EA = 1.7, 4.0e3
ELEMENT = LENGTH / 2.0
UNITS = ("m", "m", "rad")


def arc(kappa, s):
    """Pose x, y, theta at the arc length s of a circular arc of curvature kappa that starts at (1, 0) along +X."""
    kappa = np.asarray(kappa)
    flat = np.abs(kappa) < 1e-12
    safe = np.where(flat, 1.0, kappa)
    x = np.where(flat, s, np.sin(safe * s) / safe)
    y = np.where(flat, 0.0, 2.0 * np.sin(0.5 * safe * s) ** 2 / safe)
    return np.stack([1.0 + x, y, kappa * s], axis=-1)


def columns(t):
    """Signals by name, each (values, units)."""
    phi, kappa = SPEED * t, BEND * np.sin(SPEED * t)
    found = {}
    crank = np.stack([RADIUS * np.cos(phi), RADIUS * np.sin(phi), phi], axis=-1)
    nodes = {"crank": crank, **{f"arm.node{i}": arc(kappa, i * ELEMENT) for i in range(3)}}
    for stem, pose in nodes.items():
        for k, axis in enumerate(("x", "y", "theta")):
            found[f"{stem}.{axis}"] = (pose[:, k], UNITS[k])
    found["crank.ax"] = (-RADIUS * SPEED**2 * np.cos(phi), "m/s2")
    found["P.ex"] = (1e-3 * np.cos(3.0 * phi), "m")
    found["P.ey"] = (1e-3 * np.sin(3.0 * phi), "m")
    found["P.normal_force"] = (100.0 * np.sin(phi) ** 2, "N")
    found["P.mode"] = (np.round(np.sin(phi) ** 2), "")
    return found


def shapes():
    """Drawing records of the parts."""
    stiffness = (4.0 * EI / ELEMENT, 2.0 * EI / ELEMENT, 4.0 * EI / ELEMENT)
    beam = (ELEMENT, 0.0, 0.0, EA / ELEMENT, stiffness, (EI, EI))
    return (
        RigidShape("crank", "", (((-RADIUS, 0.0), (RADIUS, 0.0)),)),
        BeamShape("arm", "node0", "node1", *beam),
        BeamShape("arm", "node1", "node2", *beam),
        PointShape("O", "revolute", "ground", "", (0.0, 0.0)),
        PointShape("P", "clearance", "crank", "", (RADIUS, 0.0)),
    )


def solution(n=101, t_end=1.0, **changes):
    """The solution with n saved instants; keywords replace what it is built from."""
    time = np.linspace(0.0, t_end, n)
    found = columns(time)
    values = np.stack([v for v, _ in found.values()], axis=-1)
    peaks = Peaks(np.abs(values).max(axis=0), time[np.abs(values).argmax(axis=0)]) if n else Peaks(values, values)
    arguments = {
        "time": time,
        "values": values,
        "signals": tuple(Signal(name, units) for name, (_, units) in found.items()),
        "peaks": peaks,
        "status": f"Reached t = {t_end:g} s.",
        "ok": True,
        "stats": Stats(2000, 3, 4100, 4200, 410, 1e-7, 1e-3, 0.25),
        "aliases": {"arm": "arm.node1", "arm.start": "arm.node0", "arm.end": "arm.node2"},
        "shapes": shapes(),
        "restart": {"q": np.array([0.1, -0.0, np.nextafter(1.0, 2.0)]), "mode": np.array([1, 2]), "lam": np.zeros(0)},
        "model": {"name": "handmade", "version": "0.1.0"},
    }
    return Solution(**{**arguments, **changes})
