"""Errors and steps of impacts by three methods: `python tests/speed/impacts.py` (half a minute, and compilation).

The rigid nine-bar with 0.5 mm of play over 0.05 s, beside `DormandPrince` with rtol 1e-8; random machines with contacts
of tests/fuzz/combinations.py over 0.3 s with rtol 1e-6, by the number of contact intervals and of steps.
"""

import math
import sys
import warnings
from pathlib import Path

import numpy as np

import flexmb as fm

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "fuzz"))
from combinations import built

METHODS = {"Newmark": None, "RadauIIA": fm.RadauIIA(), "DormandPrince": fm.DormandPrince()}
MACHINES = 40


def run(mech: fm.Mechanism, method: str, rtol: float, **options) -> fm.Solution:
    chosen = METHODS[method]
    return fm.simulate(mech, step=fm.Adaptive(rtol=rtol), **({"method": chosen} if chosen else {}), **options)


def nine_bar() -> None:
    """Largest difference of all places from the reference, and steps."""
    mech, options = fm.mechanisms.nine_bar(2.0 * math.pi, clearance=5e-4), {"t_end": 0.05, "save": 50}
    exact = run(mech, "DormandPrince", 1e-8, **options)
    places = [name for name in exact.names if name.endswith((".x", ".y"))]
    for method in METHODS:
        sol = run(mech, method, 1e-4, **options)
        error = max(np.abs(sol.array(name) - exact.array(name)).max() for name in places)
        print(f"nine-bar, {method}: {error:.1e} m, {sol.stats.steps} steps")


def machines() -> None:
    """Contact intervals and steps of both methods of high order."""
    for seed in range(MACHINES):
        mech = built(seed)[0]
        if not fm.compile(mech).names.contacts:
            continue
        found = []
        for method in ("DormandPrince", "RadauIIA"):
            try:
                sol = run(mech, method, 1e-6, t_end=0.3, save=1)
            except fm.errors.InputError as refused:
                found.append(str(refused).partition(", but ")[2])
                break
            found.append(f"{method} {'ok' if sol.ok else sol.status}: {len(sol.episodes())}, {sol.stats.steps} steps")
        print(f"machine {seed}:", "; ".join(found), flush=True)


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    nine_bar()
    machines()
