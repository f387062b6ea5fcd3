"""The EMPS axis, a prismatic drive under sampled position control: tracking error, and its parameters by a fit.

Source: A. Janot, M. Gautier, M. Brunot, Data set and reference models of EMPS, Nonlinear System Identification
Benchmarks 2019.  Numbers of the loop, of the reference lap and of the measured friction are theirs.
"""

from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

import flexmb as fm
from flexmb.fields import field, record
from measured import table

RECORDS = False

SAMPLE, LAPS, SETTLED = 1e-3, 6, 2
"""Time between samples [s]; laps that are simulated, and that are left out at the start."""

FORCE = 35.15065188248547
"""Force of the motor [N] a volt."""

COUNT = 5e-8
"""Count of the encoder [m]."""

GAINS = (160.18, 243.45, 10.0)
"""Proportional gain [1/s], gain of velocity [V s/m], limit [V]."""

PUBLISHED = {"mass": 95.1089, "viscous": 203.5034, "coulomb": 20.3935, "offset": -3.1648}
"""Published least squares: mass [kg], viscous friction [N s/m], Coulomb friction and offset [N]."""

START = (1.078221e-4, 1.343255e-2)
"""Position [m] and speed [m/s] of the reference at the start."""

RUNS = [35, 351, 50, 1, 98, 687, 98, 1, 148, 1035, 148, 1, 50, 351, 101, 351, 50, 1, 98, 687, 98, 1, 148, 1035, 148, 1]
RUNS += [50, 351, 66]
"""Samples of runs of the reference with constant acceleration and with none, in turn."""

ACCELERATIONS = [0.819696, -0.826876, 0.834499, -0.834589, 0.837223, -0.83719, 0.827038, -0.834201, 0.827215]
ACCELERATIONS += [-0.834609, 0.834591, -0.837223, 0.837141, -0.826781, 0.827378]
"""Accelerations of the first, third, ... run [m/s^2]."""

FASTEST = 0.129
CURVE = """
-47.223 -50.535 -46.504 -48.993 -49.714 -47.69 -46.827 -45.364 -45.74 -45.297 -40.27 -40.241 -38.596 -38.308 -38.364
-39.029 -37.695 -35.484 -33.997 -32.867 -31.425 -28.341 -27.709 -26.87 -26.2 -25.085 -23.496 -22.582 -21.235 -18.707
-.862 17.31 18.966 20.409 21.779 22.694 23.779 24.855 25.264 25.571 27.756 29.967 30.85 30.955 30.624 31.025 32.144
33.029 32.981 34.273 33.188 35.546 37.757 38.579 39.09 39.609 38.23 38.249 38.361 40.669 36.959
"""
"""Measured friction [N] at 61 speeds from -FASTEST to FASTEST [m/s]."""


MEASURED = (0.5814, 0.8522)
"""Measured tracking error: root of the mean square and largest value [mm]."""

BOUNDS = {"mass": (50.0, 200.0), "viscous": (50.0, 600.0), "coulomb": (5.0, 60.0), "offset": (-10.0, 10.0)}
EVERY = 10
"""Bounds of the fit; of so many samples one is compared."""


def lap() -> np.ndarray:
    """Positions (6240,) of the reference at the samples of a lap [m]."""
    a = np.repeat([x for one in ACCELERATIONS for x in (one, 0.0)][: len(RUNS)], RUNS)
    q, v = START
    found = []
    for one in a:
        found.append(q)
        q, v = q + SAMPLE * v + 0.5 * SAMPLE**2 * one, v + SAMPLE * one
    return np.array(found)


@fm.control_kernel
def servo(p, t, u, x, dx, y):
    """Position control with the slope of a two-tap mean; u: position, reference; x: two positions before."""
    kp, kv, limit, sample, count = p
    q = count * round(u[0] / count) if count > 0.0 else u[0]
    rate = (q - x[1]) / (2.0 * sample)
    y[0] = min(max(kv * (kp * (u[1] - q) - rate), -limit), limit)
    dx[0], dx[1] = (q - x[0]) / sample, (x[0] - x[1]) / sample


@fm.friction_law
def curve_kernel(p, h, slip, N, z, z_new):
    """Straight lines between forces at equal distances of speed."""
    n, fastest = len(p) - 1, p[0]
    place = min(max((slip + fastest) / (2.0 * fastest) * (n - 1), 0.0), n - 1.000001)
    k = int(place)
    slope = (p[k + 2] - p[k + 1]) * (n - 1) / (2.0 * fastest)
    force = p[k + 1] + (place - k) * (p[k + 2] - p[k + 1])
    return -N * force, -N * slope, -force


@record
class MeasuredFriction(fm.FrictionLaw):
    """A measured friction force over a normal force of 1 N."""

    forces: tuple[float, ...] = field("forces at equal distances of speed", "N")
    fastest: float = field("speed of the last force", "m/s")

    kernel = curve_kernel

    def parameters(self) -> tuple[float, ...]:
        """Numbers of the kernel."""
        return (self.fastest, *self.forces)


def axis(
    mass: float = PUBLISHED["mass"],
    viscous: float = PUBLISHED["viscous"],
    coulomb: float = PUBLISHED["coulomb"],
    offset: float = PUBLISHED["offset"],
    *,
    measured: bool = False,
    count: float = COUNT,
    laps: int = LAPS,
    creep: float = 1e-3,
) -> fm.Mechanism:
    """The axis in its loop; with measured friction in place of the last three parameters."""
    reference = np.tile(lap(), laps)
    late = np.concatenate([reference[:1] - SAMPLE * START[1], reference])
    times = SAMPLE * np.arange(len(late))
    carriage = fm.RigidBody("carriage", (0.0, 0.0), mass, 1.0, velocity=(START[1], 0.0, 0.0))
    law = fm.friction.SmoothCoulomb(coulomb, v0=creep)
    if measured:
        law = MeasuredFriction(tuple(map(float, CURVE.split())), FASTEST)
    guide = fm.Prismatic(
        "guide", fm.GROUND, carriage, at=(0.0, 0.0), along=(1.0, 0.0), friction=law, length=1e3, preload=1.0
    )
    parts = [carriage, guide, fm.Force("motor", carriage, (0.0, 0.0), (FORCE, 0.0))]
    if not measured:
        drag = fm.loads.SpringDamper(
            "drag", fm.GROUND, carriage, at=(-1.0, 0.0), to=(0.0, 0.0), stiffness=0.0, damping=viscous
        )
        parts += [drag, fm.Force("offset", carriage, (0.0, 0.0), (-offset, 0.0))]
    inputs = ["carriage.x", fm.drives.PiecewiseLinear(times, late)]
    numbers = (*GAINS, SAMPLE, count)
    before = START[0] - SAMPLE * START[1] * np.array([1.0, 2.0])
    loop = fm.Control("servo", inputs, ["motor"], servo, numbers=numbers, states=before.tolist(), sample=SAMPLE)
    return fm.Mechanism("EMPS axis", [*parts, loop], gravity=(0.0, 0.0))


def axis_to_fit(mass: float, viscous: float, coulomb: float, offset: float) -> fm.Mechanism:
    """The axis over one lap, without the counts of the encoder, by which nothing has a derivative."""
    return axis(mass, viscous, coulomb, offset, count=0.0, laps=1)


def run(model: fm.Mechanism, laps: int) -> tuple[np.ndarray, np.ndarray]:
    """Times (n,) of the samples, and positions (n,) of the carriage [m]."""
    times = SAMPLE * np.arange(laps * len(lap()))
    sol = fm.simulate(model, t_end=float(times[-1]), save=times.tolist(), step=SAMPLE, signals=["carriage.x"])
    if not sol.ok:
        raise SystemExit(sol.status)
    return times, np.asarray(sol["carriage.x"])


def tracking(model: fm.Mechanism, laps: int = LAPS) -> tuple[float, float]:
    """Root of the mean square and largest value of the tracking error in the laps that count [m].

    The error is that which the controller sees, with the reference one sample late.
    """
    reference = np.tile(lap(), laps)
    error = np.concatenate([reference[:1], reference[:-1]]) - run(model, laps)[1]
    counted = error[SETTLED * len(lap()) :]
    return float(np.sqrt(np.mean(counted**2))), float(np.abs(counted).max())


def fitted(truth: fm.Mechanism) -> dict[str, Any]:
    """Parameters and standard errors that a fit finds from a lap of another axis, and what it leaves [m]."""
    times, x = run(truth, 1)
    kept = slice(None, None, EVERY)
    data = xr.Dataset({"carriage.x": ("time", x[kept])}, {"time": times[kept]})
    found = fm.design.fit(axis_to_fit, BOUNDS, data, signals=["carriage.x"], step=SAMPLE)
    values = {name: [found.parameters[name], found.errors[name]] for name in PUBLISHED}
    return {"values": values, "runs": found.runs, "left": float(abs(found.residuals["carriage.x"]).max())}


def numbers(_: Path | None) -> dict[str, Any]:
    """Tracking errors with both descriptions of friction, and parameters that fits find from both."""
    errors = {"curve": tracking(axis(measured=True)), "parameters": tracking(axis())}
    fits = {"parameters": fitted(axis(laps=1)), "curve": fitted(axis(measured=True, laps=1))}
    return {"errors": errors, "fits": fits}


def passage(found: dict[str, Any]) -> str:
    """Tables of tracking errors and of fitted parameters."""
    own, known = found["errors"], {"curve": (0.5764, 0.8517), "parameters": (0.5764, 0.8506)}
    words = {"curve": "measured curve, 61 points", "parameters": "published M, Fv, Fc, offset; tanh(v / 1 mm/s)"}
    rows = [
        [words[name], what, f"{MEASURED[k]:.4f}", f"{known[name][k]:.4f}", f"{1e3 * own[name][k]:.4f}",
         f"{100.0 * (1e3 * own[name][k] / MEASURED[k] - 1.0):+.2f} %"]
        for name in own
        for k, what in enumerate(("rms", "largest"))
    ]  # fmt: skip
    head = ["friction", "tracking error [mm]", "measured", "independent script", "ours", "ours beside measured"]
    first = table(head, rows, left=2)
    rows = [[name, f"{value:.6g}", *cells(found["fits"], name)] for name, value in PUBLISHED.items()]
    parts = [f"from {one}, {what}" for one in ("these numbers", "the curve") for what in ("error", "difference")]
    head = ["number", "published", *(word.replace(", error", "") for word in parts)]
    second = table(head, rows, left=1)
    each = (f"{one['runs']} runs leave at most {1e6 * one['left']:.2g} um" for one in found["fits"].values())
    return f"{first}\n\n{second}\n\nOf the position, {' and '.join(each)}."


def cells(fits: dict[str, Any], name: str) -> list[str]:
    """Value with standard error, and difference from the published value, of both fits."""
    found = []
    for fit in fits.values():
        value, error = fit["values"][name]
        found += [f"{value:.6g} ± {error:.1g}", f"{100.0 * (value / PUBLISHED[name] - 1.0):+.2f} %"]
    return found
