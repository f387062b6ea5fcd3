"""Cost and statistics of the worn nine-bar mechanism with rigid links, beams and reduced links, for docs/bodies.md."""

import math
import statistics
import time
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import nine_bar_limits as limits
import numpy as np

import flexmb as fm

SPEED, PLAY = 2.0 * math.pi, 5e-4
RATIO = 0.02
"""Damping ratio."""

DAMPING = 2.0 * RATIO / (2.0 * math.pi * 228.5)
"""Stiffness-proportional damping [s] that gives the lowest vibration of the mechanism, 228.5 Hz, this ratio."""

COARSE = 1e-3
"""Relative tolerance of the coarser steps, ten times the default."""

MODELS: dict[str, dict[str, Any]] = {
    "rigid": {},
    "4 beams": {"elements": 4},
    "0 modes": {"modes": 0},
    "3 modes": {"modes": 3},
    "6 modes": {"modes": 6},
    "4 beams, damped": {"elements": 4, "damping": DAMPING},
    "3 modes, damped": {"modes": 3, "damping": DAMPING},
    "3 modes, damped by 2 % each": {"modes": 3, "ratio": RATIO},
    "4 beams, rtol = 1e-3": {"elements": 4, "rtol": COARSE},
    "3 modes, rtol = 1e-3": {"modes": 3, "rtol": COARSE},
    "4 beams, damped, rtol = 1e-3": {"elements": 4, "damping": DAMPING, "rtol": COARSE},
    "3 modes, damped, rtol = 1e-3": {"modes": 3, "damping": DAMPING, "rtol": COARSE},
}


def model(
    modes: int | None = None, elements: int = 0, damping: float | None = None, ratio: float = 0.0
) -> fm.Mechanism:
    """The mechanism with a marker at corner C of the panel; rigid without modes and elements."""
    flexible = modes is not None or elements > 0
    mech = fm.mechanisms.nine_bar(
        SPEED, clearance=PLAY, flexible=flexible, elements=elements or 4, data=limits.LIGHTLY_DAMPED
    )
    for body in mech.bodies:
        if not isinstance(body, fm.FlexibleLink | fm.FlexibleFrame):
            continue
        if damping is not None:
            body = replace(body, damping=damping)  # noqa: PLW2901 - the damped one in its place
        if modes is not None:
            body = fm.Reduced(body, modes=modes, damping_ratios=ratio)  # noqa: PLW2901
        mech = mech.with_part(body)
    return mech.with_part(fm.Marker("corner", mech.find("panel7"), at=mech.find("C").at))


def turns(mech: fm.Mechanism, count: int, step: fm.Adaptive) -> Iterator[dict[str, float]]:
    """Statistics and cost of each turn; force by the time it lasts."""
    state = None
    for k in range(1, count + 1):
        began = time.process_time()
        sol = fm.simulate(mech, t_end=k * 2.0 * math.pi / SPEED, save="steps", step=step, restart=state)
        took = time.process_time() - began
        if not sol.ok:
            raise SystemExit(f"{mech.name}: {sol.status}")
        state = sol.restart
        force, lasts = sol.array("P1.normal_force"), np.diff(sol.time)
        after, whole = force[1:], lasts.sum()
        order = np.argsort(after)
        share = np.cumsum(lasts[order]) / whole
        yield {
            "mean": float(after @ lasts / whole),
            "rms": float(np.sqrt(after**2 @ lasts / whole)),
            "median": float(after[order][np.searchsorted(share, 0.5)]),
            "90 %": float(after[order][np.searchsorted(share, 0.9)]),
            "99 %": float(after[order][np.searchsorted(share, 0.99)]),
            "largest": float(force.max()),
            "flight": float(lasts[after == 0.0].sum() / whole),
            "contacts": int(((force[1:] > 0.0) & (force[:-1] == 0.0)).sum()),
            "panel": float(np.hypot(sol.array("corner.ax"), sol.array("corner.ay")).max()),
            "steps": sol.stats.steps,
            "iterations": sol.stats.newton_iterations / sol.stats.steps,
            "factorisations": sol.stats.factorisations / sol.stats.steps,
            "seconds": took,
        }


def rows(count: int, skip: int) -> list[dict[str, Any]]:
    """All models, in turns, so that other work on the machine slows them alike."""
    runs = {}
    for label, given in MODELS.items():
        options = dict(given)
        step = fm.Adaptive(rtol=options.pop("rtol", fm.Adaptive().rtol), max=1e-3 * 2.0 * math.pi / SPEED)
        mech = model(**options)
        fm.simulate(mech, t_end=1e-4, save="steps")  # compiles
        runs[label] = turns(mech, skip + count, step), fm.compile(mech)
    found: dict[str, list[dict[str, float]]] = {label: [] for label in runs}
    for turn in range(skip + count):
        for label, (run, _) in runs.items():
            one = next(run)
            if turn >= skip:
                found[label].append(one)
        print("turn", turn + 1, flush=True)
    return [
        {"label": label, "unknowns": program.n_q + program.n_c, **summary(found[label])}
        for label, (_, program) in runs.items()
    ]


def summary(found: list[dict[str, float]]) -> dict[str, dict[str, float]]:
    """Mean and standard deviation over the turns of all that was found for each."""
    columns = {key: [turn[key] for turn in found] for key in found[0]}
    return {
        "mean": {key: float(f"{statistics.mean(values):.6g}") for key, values in columns.items()},
        "spread": {key: float(f"{statistics.stdev(values):.6g}") for key, values in columns.items()},
    }


COLUMNS = {
    "mean force [N]": "mean",
    "rms": "rms",
    "median": "median",
    "90 %": "90 %",
    "99 %": "99 %",
    "largest": "largest",
    "flight": "flight",
    "contacts": "contacts",
    "acceleration of C [m/s^2]": "panel",
}


def passage(models: list[dict[str, Any]]) -> str:
    """Tables of statistics and of cost."""

    def mean(entry: dict[str, Any], key: str) -> float:
        return float(entry["mean"][key])

    def spread(entry: dict[str, Any], key: str) -> str:
        return f"{mean(entry, key):.4g} ± {entry['spread'][key]:.2g}"

    first = [[entry["label"], *(spread(entry, key) for key in COLUMNS.values())] for entry in models]
    whole = next(mean(entry, "seconds") for entry in models if entry["label"] == "4 beams")
    second = [
        [
            entry["label"],
            str(entry["unknowns"]),
            f"{mean(entry, 'steps'):.0f}",
            f"{mean(entry, 'iterations'):.2f}",
            f"{mean(entry, 'factorisations'):.2f}",
            f"{1e6 * mean(entry, 'seconds') / mean(entry, 'steps'):.1f}",
            f"{mean(entry, 'seconds'):.3f}",
            f"{whole / mean(entry, 'seconds'):.2f}",
        ]
        for entry in models
    ]
    titles = ["links", "unknowns", "steps a turn", "iterations a step", "factorisations", "us a step"]
    titles += ["time a turn [s]", "over 4 beams"]
    return limits.table(["links", *COLUMNS], first) + "\n\n" + limits.table(titles, second)
