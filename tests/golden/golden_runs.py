"""Runs whose final states are kept to the last bit, each short enough that chaos has not taken over.

    python tests/golden/golden_runs.py           # beside what is kept: bits, largest difference, time of a step
    python tests/golden/golden_runs.py --keep    # keep what they give now; a commit that does so says why

What is kept (golden.npz, golden.json) are the numbers of the final state, of the energies and of the counters.
"""

import argparse
import hashlib
import json
import math
import platform
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import llvmlite.binding
import numba
import numpy as np

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent / "speed"), str(HERE.parents[1] / "examples")]

import models  # noqa: E402 - found beside this folder
from nine_bar_study.nine_bar.staggered.method import Staggered  # noqa: E402

import flexmb as fm  # noqa: E402
from flexmb.mechanisms import NineBarData, four_bar, nine_bar, slider_crank  # noqa: E402

BY_SIGNAL, SIGNALS = ("last", "peaks"), "signals"
ARRAYS, TEXTS = HERE / "golden.npz", HERE / "golden.json"


@dataclass(frozen=True)
class Found:
    """What a run ended with.

    Parameters
    ----------
    arrays : final state by name.
    counters : steps, rejected steps, Newton iterations, evaluations, factorisations.
    seconds : processor time of the run.
    signals : names of the entries of the arrays `BY_SIGNAL`.
    """

    arrays: dict[str, np.ndarray]
    counters: dict[str, int]
    seconds: float
    signals: tuple[str, ...] = ()

    def of(self, signals: np.ndarray) -> "Found":
        """The same with these signals alone, in their order: a new signal moves no bit of the others."""
        places = [self.signals.index(name) for name in signals.tolist()]
        arrays = {key: array[places] if key in BY_SIGNAL else array for key, array in self.arrays.items()}
        return replace(self, arrays=arrays, signals=tuple(signals.tolist()))

    @property
    def digest(self) -> str:
        """Of all bits."""
        code = hashlib.sha256()
        for name in sorted(self.arrays):
            code.update(name.encode() + np.ascontiguousarray(self.arrays[name]).tobytes())
        return code.hexdigest()


def simulated(mechanism: fm.Mechanism, **options) -> Found:
    """A run of `simulate`."""
    began = time.process_time()
    sol = fm.simulate(mechanism, save=8, **options)
    seconds = time.process_time() - began
    arrays = {"t": sol.time, "last": sol.values[-1], "peaks": sol.peaks.values}
    stats = sol.stats
    names = ("steps", "rejected", "newton_iterations", "evaluations", "factorisations")
    return Found(arrays, {name: int(getattr(stats, name)) for name in names}, seconds, tuple(sol.names))


def n_four_bar(bays: int = 8) -> fm.Mechanism:
    """Parallel rods of 1 m between a base and a row of couplers; the flat pose is singular."""
    parts, last = [], None
    for k in range(bays + 1):
        rod = fm.RigidLink(
            f"rod{k}", (float(k), 0.0), (float(k), 1.0), mass=1.0, inertia=1.0 / 12.0, velocity=(-0.5, 0.0, 1.0)
        )
        parts += [rod, fm.Revolute(f"O{k}", fm.GROUND, rod, (float(k), 0.0))]
        if last is not None:
            coupler = fm.RigidLink(f"coupler{k}", (k - 1.0, 1.0), (float(k), 1.0), mass=1.0, inertia=1.0 / 12.0)
            parts += [coupler, fm.Revolute(f"A{k}", last, coupler, (k - 1.0, 1.0))]
            parts.append(fm.Revolute(f"B{k}", rod, coupler, (float(k), 1.0)))
        last = rod
    return fm.Mechanism("n-four-bar", parts, gravity=(0.0, -9.81))


def carried() -> Found:
    """A run that carries two differences along."""
    flow = fm.chaos.MechanismFlow(slider_crank(clearance=0.5e-3, friction="coulomb"))
    W = flow.tangent_basis(2, seed=3)
    began = time.process_time()
    flow.advance(0.002, W)
    seconds = time.process_time() - began
    return Found({"state": flow.state(), "carried": W}, {}, seconds)


def peak_of(clearance: float) -> float:
    """Largest force of a short run."""
    return fm.simulate(slider_crank(clearance=clearance), t_end=1e-3).peak("B.normal_force").value


def swept() -> Found:
    """A sweep over the clearance."""
    began = time.process_time()
    found = fm.sweep(peak_of, {"clearance": np.array([1e-4, 2e-4, 5e-4])})
    return Found({"peaks": np.asarray(found["value"].values)}, {}, time.process_time() - began)


def restarted() -> Found:
    """Half a run, and the other half from its end."""
    mechanism = slider_crank(clearance=0.5e-3)
    first = fm.simulate(mechanism, t_end=5e-4)
    return simulated(mechanism, t_end=1e-3, restart=first.restart)


def nine(**options) -> fm.Mechanism:
    """The nine-bar mechanism from a start at full speed."""
    return nine_bar(2.0 * math.pi, data=NineBarData(damping=NineBarData.LIGHT_DAMPING), **options)


RUNS: dict[str, Callable[[], Found]] = {
    "worn": lambda: simulated(models.worn(), t_end=2e-3),
    "worn, steps of one size": lambda: simulated(models.worn(), t_end=1e-3, step=1e-6),
    "user's law": lambda: simulated(models.user_law(), t_end=1e-3),
    "ideal slider-crank": lambda: simulated(models.ideal(), t_end=models.TURN),
    "nine-bar, ideal": lambda: simulated(nine(), periods=1),
    "nine-bar, rigid": lambda: simulated(nine(clearance=0.5e-3), t_end=0.03),
    "nine-bar, rigid, largest speed": lambda: simulated(
        nine(clearance=0.5e-3).with_({"P1.normal.reference_speed": "largest"}), t_end=0.03
    ),
    "nine-bar, flexible": lambda: simulated(nine(clearance=0.5e-3, flexible=True), t_end=0.01),
    "four-bar, LuGre": lambda: simulated(
        four_bar(clearance=2e-4, friction=fm.friction.LuGre(static=0.12, kinetic=0.1)), t_end=5e-3
    ),
    "N-four-bar": lambda: simulated(n_four_bar(), t_end=0.5),
    "chain": lambda: simulated(models.chain(9, 4), t_end=0.05, step=1e-4),
    "rod of beams, trapezoidal": lambda: simulated(
        models.flexible_rod(), t_end=2e-3, step=1e-5, method=fm.Newmark.trapezoidal()
    ),
    "index 3": lambda: simulated(models.ideal(), t_end=2e-3, step=1e-5, method=fm.Newmark.hht(constraints="position")),
    "Runge-Kutta": lambda: simulated(models.ideal(), t_end=models.TURN, step=2e-5, method=fm.RungeKutta4()),
    "staggered": lambda: simulated(nine(clearance=0.5e-3, flexible=True), t_end=2e-3, step=4e-5, method=Staggered()),
    "Radau": lambda: simulated(models.worn(), t_end=2e-3, method=fm.RadauIIA()),
    "Dormand-Prince": lambda: simulated(
        models.ideal(), t_end=models.TURN, step=fm.Adaptive(rtol=1e-8), method=fm.DormandPrince()
    ),
    "carried differences": carried,
    "sweep": swept,
    "restart": restarted,
}


STIFF = ("nine-bar, flexible", "chain", "rod of beams, trapezoidal", "staggered", "Radau")
"""Runs of beams, and of a method whose iterations end at the tolerance of the step."""


def machine() -> str:
    """What decides the last bits."""
    host = llvmlite.binding.get_host_cpu_name()
    return f"{host} {platform.machine()}, numba {numba.__version__}, numpy {np.__version__}"


def kept(name: str) -> dict[str, np.ndarray]:
    """The arrays that were kept of a run, and the names of its signals."""
    with np.load(ARRAYS) as file:
        return {key.split("|")[1]: file[key] for key in file.files if key.split("|")[0] == name}


def compared(found: Found, wanted: dict[str, np.ndarray]) -> tuple[Found, float]:
    """What was found, with the signals that were kept, and `difference`."""
    names = wanted.pop(SIGNALS, None)
    found = found if names is None else found.of(names)
    return found, difference(found.arrays, wanted)


def difference(found: dict[str, np.ndarray], wanted: dict[str, np.ndarray]) -> float:
    """Largest difference, relative to the largest entry of the array."""
    worst = 0.0
    for name, array in wanted.items():
        scale = float(np.nanmax(np.abs(array), initial=0.0)) or 1.0
        if found[name].shape != array.shape:
            return math.inf
        worst = max(worst, float(np.nanmax(np.abs(found[name] - array), initial=0.0)) / scale)
    return worst


def main() -> None:
    """Print the table, or keep what is found."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--keep", action="store_true", help="keep what the runs give now")
    parser.add_argument("--only", default="", help="runs whose name holds this text")
    chosen = parser.parse_args()
    texts = json.loads(TEXTS.read_text(encoding="utf-8")) if TEXTS.exists() else {"runs": {}}
    arrays = dict(np.load(ARRAYS)) if ARRAYS.exists() else {}
    for name, run in RUNS.items():
        if chosen.only not in name:
            continue
        run()
        found = run()
        before, all_signals = texts["runs"].get(name), found
        found, apart = compared(found, kept(name)) if before else (found, math.nan)
        same = "same bits" if before and before["digest"] == found.digest else f"differ by {apart:.1e}"
        steps = found.counters.get("steps", 0)
        pace = f"{1e6 * found.seconds / steps:8.2f} us a step" if steps else f"{1e3 * found.seconds:8.1f} ms      "
        moved = (
            "" if not before or before["counters"] == found.counters else f"  {before['counters']} -> {found.counters}"
        )
        print(f"{name:32s} {pace}  {same}{moved}", flush=True)
        if chosen.keep:
            arrays = {key: value for key, value in arrays.items() if key.split("|")[0] != name}
            found = all_signals
            arrays |= {f"{name}|{key}": value for key, value in found.arrays.items()}
            if found.signals:
                arrays[f"{name}|{SIGNALS}"] = np.array(found.signals)
            texts["runs"][name] = {"digest": found.digest, "counters": found.counters, "machine": machine()}
    if chosen.keep:
        np.savez_compressed(ARRAYS, **arrays)
        TEXTS.write_text(json.dumps(texts, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
