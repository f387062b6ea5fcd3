"""Single, double, triple pendulum of Kaheman et al. (2022): records, fits, what the fits leave."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from measured.chains import Numbers, arm, chains, with_arguments

import flexmb as fm

NOISE = 1e-3
"""Level of the residuals to which standard errors refer [rad]."""

STEP = fm.Adaptive(rtol=1e-3)
"""Steps of fits; residuals are of default steps."""

ANGLE, RATE = 0.03, 0.3
"""Bounds of starts about the recorded ones [rad, rad/s]."""


class Record(NamedTuple):
    """Pieces of equal length of a record."""

    time: np.ndarray  # (n,) [s], from the begin of each piece on
    angles: np.ndarray  # (pieces, n, arms) [rad], from hanging
    starts: np.ndarray  # (pieces, 2 arms), recorded angles and rates

    def at(self, chosen: Sequence[int]) -> "Record":
        """Some of the pieces."""
        return Record(self.time, self.angles[chosen], self.starts[chosen])


def record(folder: Path, name: str, pieces: Sequence[int] | None = None) -> Record:
    """Record of a pendulum from `folder`."""
    with np.load(folder / f"pendulum_{name}_identification.npz") as file:
        count = sum(key.startswith("time") for key in file.files)
        angles = np.stack([file[f"angle{k}"] for k in range(count)]) - math.pi
        rates = np.stack([file[f"rate{k}"][0] for k in range(count)])
        time = file["time0"] - file["time0"][0]
    return Record(time, angles, np.concatenate([angles[:, 0], rates], axis=1))


def signal_names(arms: int, pieces: int) -> list[str]:
    """Names of the angles, piece by piece."""
    return [f"{arm(k, piece)}.theta" for piece in range(pieces) for k in range(1, arms + 1)]


def residuals(own: Record, numbers: Numbers, starts: np.ndarray) -> np.ndarray:
    """Computed less measured angles (pieces, n, arms)."""
    pieces, n, arms = own.angles.shape
    names = signal_names(arms, pieces)
    sol = fm.simulate(chains(arms, numbers, starts), t_end=own.time[-1], save=own.time, signals=names)
    if not sol.ok:
        raise SystemExit(sol.status)
    found = np.stack([sol.array(name) for name in names], axis=1)
    return found.reshape(n, pieces, arms).transpose(1, 0, 2) - own.angles


def rms(rows: np.ndarray) -> float:
    """Root of the mean square."""
    return float(np.sqrt(np.mean(np.square(rows))))


def fitted(own: Record, fixed: Numbers, bounds: Mapping[str, tuple[float, float]], **how: Any) -> tuple[fm.design.Fit, np.ndarray]:
    """Fit of numbers within `bounds` and of the start of each piece; starts (pieces, 2 arms)."""
    pieces, _, arms = own.angles.shape
    widths = [ANGLE] * arms + [RATE] * arms
    names = [f"start{k}_{piece}" for piece in range(pieces) for k in range(2 * arms)]
    spread = np.tile(widths, pieces)
    known = own.starts.ravel()
    limits = {name: (x - w, x + w) for name, x, w in zip(names, known, spread, strict=True)}

    def model(numbers: Numbers) -> fm.Mechanism:
        starts = np.array([numbers[name] for name in names]).reshape(pieces, -1)
        return chains(arms, {**fixed, **{name: numbers[name] for name in bounds}}, starts)

    signals = signal_names(arms, pieces)
    rows = own.angles.transpose(1, 0, 2).reshape(len(own.time), -1)
    data = xr.Dataset({name: ("time", rows[:, k]) for k, name in enumerate(signals)}, {"time": own.time})
    result = fm.design.fit(
        with_arguments(model, [*bounds, *names]), {**bounds, **limits}, data, signals=signals, noise=NOISE, step=STEP, **how
    )
    return result, np.array([result.parameters[name] for name in names]).reshape(pieces, -1)
