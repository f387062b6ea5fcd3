"""Compute the numbers and pictures of docs/bodies.md anew: two mechanisms of beams, meshes and reduced meshes.

    python docs/bodies_table.py [--only rod nine_bar cost] [--turns 20] [--skip 5]
    python docs/bodies_table.py --page

Models are those of examples/rod_of_plates.py and examples/nine_bar_plates.py.  Numbers are kept in docs/bodies.json;
--page writes the page from them alone.  The nine-bar mechanism takes a quarter of an hour, the cost some minutes.
"""

import argparse
import json
import math
import os
import platform
import statistics
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

import flexmb as fm

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "examples")]

import bodies_cost as cost  # noqa: E402
import nine_bar_limits as limits  # noqa: E402
import nine_bar_plates as plates  # noqa: E402
import rod_of_plates as rod  # noqa: E402

PAGE, DATA, PICTURES = HERE / "bodies.md", HERE / "bodies.json", HERE / "pictures"

ROD_STEP = 1e-5  # s
ROD_REPEATS = 5
RODS = {
    "8 beams": ("beams", 0, 8),
    "32 beams": ("beams", 0, 32),
    "32 beams, 3 modes": ("beams", 3, 32),
    "32 beams, 6 modes": ("beams", 6, 32),
    "32 beams, 12 modes": ("beams", 12, 32),
    "mesh of 40 x 2 cells, all nodes": ("mesh", 0, 40),
    "mesh, 3 modes": ("mesh", 3, 40),
    "mesh, 6 modes": ("mesh", 6, 40),
    "mesh, 12 modes": ("mesh", 12, 40),
}
"""Rods: kind, modes, beams or cells along the rod."""

SPEED, PLAY = 2.0 * math.pi, 5e-4
MODELS: dict[str, Callable[[fm.Mechanism], fm.Mechanism]] = {
    "beams": plates.of_beams,
    "plates, 3 modes": plates.of_plates,
    "plates, 6 modes": lambda mechanism: plates.of_plates(mechanism, modes=6),
}
COUNTED = ("slider.ax", "motor1.torque", "motor4.torque", "P1.force")


def finished(mech: fm.Mechanism, **options: Any) -> fm.Solution:
    """The solution of a run that reached its end; any other stops here."""
    sol = fm.simulate(mech, **options)
    if not sol.ok:
        raise SystemExit(f"{mech.name}: {sol.status}")
    return sol


def rod_row(label: str) -> dict[str, Any]:
    """One rod: frequencies, deflection, stress, time of a turn."""
    kind, modes, along = RODS[label]
    mech = rod.mechanism(kind, modes, elements=along, cells=(along, 2))
    sol = finished(mech, t_end=rod.TURN, step=ROD_STEP, save=400)
    times = [finished(mech, t_end=rod.TURN, step=ROD_STEP, save=1).stats.wall_time for _ in range(ROD_REPEATS)]
    free = finished(mech, t_end=rod.TURN, save=1).stats
    peak = sol.peak("rod.von_mises")
    found = {
        "label": label,
        "coordinates": 3 * len(mech.find("rod").nodes()) if kind == "beams" or modes else coordinates(mech.find("rod")),
        "frequencies": [float(f) for f in fm.modes(mech).frequencies[:3]],
        "deflection": float(np.abs(rod.deflection(sol)).max()),
        "stress": peak.value,
        "stress_time": peak.time,
        "steps": sol.stats.steps,
        "wall": statistics.median(times),
        "adaptive_steps": free.steps,
        "adaptive_wall": free.wall_time,
    }
    print(found, flush=True)
    return found


def coordinates(body: fm.PlaneBody) -> int:
    """Number of coordinates of a body with all nodes of its mesh."""
    pins = len(body.pin_nodes)
    return 2 * (len(body.nodes()) - pins) + 3 * pins


def peaks_of(mech: fm.Mechanism, turns: int) -> Iterator[dict[str, Any]]:
    """Peaks, stresses and cost of each turn."""
    for sol in limits.measures.turns(mech, SPEED, turns, step=fm.Adaptive(max=1e-3 * 2.0 * math.pi / SPEED)):
        share, landings = limits.measures.share_of_flight(sol)
        turn: dict[str, Any] = {name: sol.peak(name).value for name in COUNTED}
        turn |= {"penetration": float(sol.array("P1.penetration").max()), "flight": float(share), "landings": landings}
        turn |= {"steps": sol.stats.steps, "wall": sol.stats.wall_time, "force_time": sol.peak("P1.force").time}
        stressed = [name for name in sol.names if name.endswith(".von_mises")]
        turn["stress"] = {}
        for name in stressed:
            peak = sol.peak(name)
            turn["stress"][name.partition(".")[0]] = (peak.value, peak.time, *peak.place)
        yield turn


def nine_bar_model(label: str, turns: int, skip: int) -> dict[str, Any]:
    """One model: frequencies at the start with an ideal joint, and the turns that count."""
    ideal = MODELS[label](fm.mechanisms.nine_bar(SPEED, flexible=True, data=limits.LIGHTLY_DAMPED))
    worn = MODELS[label](fm.mechanisms.nine_bar(SPEED, clearance=PLAY, flexible=True, data=limits.LIGHTLY_DAMPED))
    found = [*peaks_of(worn, skip + turns)][skip:]
    frequencies = [float(f) for f in fm.modes(ideal).frequencies[:5]]
    print(label, frequencies, found[-1], flush=True)
    return {"label": label, "frequencies": frequencies, "turns": found}


def impact_picture(hardest: float) -> None:
    """Stress of the plates at the hardest impact, from a run that saves finely about it."""
    worn = plates.of_plates(fm.mechanisms.nine_bar(SPEED, clearance=PLAY, flexible=True, data=limits.LIGHTLY_DAMPED))
    step = fm.Adaptive(max=1e-3 * 2.0 * math.pi / SPEED)
    state, turns = None, math.floor(hardest * SPEED / (2.0 * math.pi))
    for k in range(1, turns + 1):
        state = finished(worn, t_end=k * 2.0 * math.pi / SPEED, save=1, step=step, restart=state).restart
    before = finished(worn, t_end=hardest - 2e-3, save=1, step=step, restart=state).restart
    sol = finished(worn, t_end=hardest + 2e-3, save="steps", step=step, restart=before)
    figure = plates.stress_picture(sol, sol.peak("P1.force").time)
    figure.savefig(PICTURES / "bodies_impact.png", dpi=100)


def rod_passage(rows: list[dict[str, Any]]) -> str:
    """Table of the rods."""
    head = [
        *("rod", "coordinates", "frequencies [Hz]", "deflection [mm]", "von Mises [MPa]", "at [ms]"),
        *("us a step", "time a turn [ms]", "default steps", "their time [ms]"),
    ]
    lines = [
        [
            row["label"],
            str(row["coordinates"]),
            ", ".join(f"{f:.1f}" for f in row["frequencies"]),
            f"{1e3 * row['deflection']:.4f}",
            f"{row['stress'] / 1e6:.1f}",
            f"{1e3 * row['stress_time']:.2f}",
            f"{1e6 * row['wall'] / row['steps']:.3g}",
            f"{1e3 * row['wall']:.3g}",
            str(row["adaptive_steps"]),
            f"{1e3 * row['adaptive_wall']:.3g}",
        ]
        for row in rows
    ]
    return limits.table(head, lines)


def spread(values: list[float], factor: float = 1.0) -> str:
    """Mean and standard deviation of turns."""
    return f"{factor * statistics.mean(values):.4g} ± {factor * statistics.stdev(values):.2g}"


QUANTITIES = {
    "slider acceleration [m/s^2]": ("slider.ax", 1.0),
    "torque 1 [N m]": ("motor1.torque", 1.0),
    "torque 4 [N m]": ("motor4.torque", 1.0),
    "force at P1 [N]": ("P1.force", 1.0),
    "penetration [um]": ("penetration", 1e6),
    "free flight [%]": ("flight", 100.0),
    "landings a turn": ("landings", 1.0),
    "steps a turn": ("steps", 1.0),
    "time a turn [s]": ("wall", 1.0),
}


def nine_bar_passage(models: list[dict[str, Any]]) -> str:
    """Tables of the nine-bar mechanism: peaks, then stresses by bodies."""
    head = ["what", *(model["label"] for model in models)]
    rows = [["frequencies [Hz]", *(", ".join(f"{f:.1f}" for f in model["frequencies"]) for model in models)]]
    for name, (key, factor) in QUANTITIES.items():
        rows.append([name, *(spread([turn[key] for turn in model["turns"]], factor) for model in models)])
    stressed = []
    for body in models[0]["turns"][0]["stress"]:
        cells = []
        for model in models:
            values = [turn["stress"][body] for turn in model["turns"]]
            top = max(values, key=lambda value: value[0])
            safety = plates.YIELD / top[0]
            mean = spread([value[0] for value in values], 1e-6)
            cells.append(
                f"{mean}; {top[0] / 1e6:.1f} at {top[1]:.4f} s, ({top[2]:.3f}, {top[3]:.3f}), safety {safety:.1f}"
            )
        stressed.append([body, *cells])
    return limits.table(head, rows) + "\n\n" + limits.table(head, stressed)


PASSAGES = {"rod": rod_passage, "nine_bar": nine_bar_passage, "cost": cost.passage}


def page_text(text: str, data: dict[str, Any]) -> str:
    """The page with its tables from the numbers."""
    for name, passage in PASSAGES.items():
        begin, end = f"<!-- {name}: begin, written by bodies_table.py -->", f"<!-- {name}: end -->"
        before, rest = text.split(begin)
        found = data[name]
        text = f"{before}{begin}\n\n{found['where']}\n\n{passage(found['rows'])}\n\n{end}{rest.split(end)[1]}"
    return text


def where(more: str) -> str:
    """Date and machine."""
    return f"{time.strftime('%Y-%m-%d')}, {platform.machine()}, {os.cpu_count()} cores, one of them used. {more}"


def main() -> None:
    """Compute, keep, write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", nargs="+", choices=tuple(PASSAGES), default=tuple(PASSAGES), help="these alone")
    parser.add_argument("--turns", type=int, default=20, help="turns of the nine-bar mechanism that count (20)")
    parser.add_argument("--skip", type=int, default=5, help="turns before them (5)")
    parser.add_argument("--page", action="store_true", help="write the page from the numbers that are kept")
    options = parser.parse_args()
    data = json.loads(DATA.read_text(encoding="utf-8")) if DATA.is_file() else {}
    chosen = () if options.page else options.only
    if "rod" in chosen:
        finished(rod.mechanism("mesh", 3), t_end=1e-4)  # compiles
        text = f"Steps of {ROD_STEP:g} s, times are medians of {ROD_REPEATS} runs of one turn."
        data["rod"] = {"where": where(text), "rows": [rod_row(label) for label in RODS]}
    if "nine_bar" in chosen:
        text = f"Mean ± standard deviation of the peaks of {options.turns} turns after the first {options.skip}."
        models = [nine_bar_model(label, options.turns, options.skip) for label in MODELS]
        data["nine_bar"] = {"where": where(text), "rows": models}
        of_plates = next(model for model in models if model["label"] == "plates, 3 modes")
        impact_picture(max(of_plates["turns"], key=lambda turn: turn["P1.force"])["force_time"])
    if "cost" in chosen:
        text = f"Mean ± standard deviation of {options.turns} turns after the first {options.skip}; processor times."
        data["cost"] = {"where": where(text), "rows": cost.rows(options.turns, options.skip)}
    if chosen:
        DATA.write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")
    PAGE.write_text(page_text(PAGE.read_text(encoding="utf-8"), data), encoding="utf-8")


if __name__ == "__main__":
    main()
