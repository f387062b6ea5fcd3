"""Compute the numbers and the picture of the last part of docs/nine_bar.md anew: the paper's own scheme.

    python docs/staggered_table.py [--cases 0.5/0.5 2/0.5 2.5/0.5 2/0.05]
        [--ways rigid coupled half 4e-5 "shared 1e-5" ...] [--turns 10] [--skip 5] [--picture] [--write]

A case is a speed over pi and a clearance in mm.  A way is the rigid mechanism, the coupled solver with default steps or
with half of their tolerance, or the staggered scheme with a step in seconds.  In a "shared" one the joint with play
shares its displacements.  Every row that is computed replaces the
one that is there; all are kept in docs/staggered.json, and the page is written from them.  Peaks come from all accepted
steps, free flight from the instants at which contacts begin and end.
"""

import argparse
import json
import sys
import time
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "examples"))

import nine_bar_limits as limits
import numpy as np
from matplotlib.figure import Figure
from nine_bar_study.nine_bar.staggered.method import Staggered
from nine_bar_table import plain, shown

import flexmb as fm
from flexmb.mechanisms import nine_bar

HERE = Path(__file__).resolve().parent
PAGE, ROWS = HERE / "nine_bar.md", HERE / "staggered.json"
PICTURE = HERE / "pictures" / "nine_bar_staggered.png"
CASES = ("0.5/0.5", "2/0.5", "2.5/0.5", "2/0.05")
STEPS = ("4e-5", "2e-5", "1e-5", "5e-6")
SHARED = "shared "
WAYS = ("rigid", "coupled", "half", *STEPS, *(SHARED + step for step in ("4e-5", "1e-5", "1e-6")))
NAMES = {"rigid": "rigid", "coupled": "coupled", "half": "coupled, tolerance halved"}
BEGIN, END = "<!-- staggered: begin, written by staggered_table.py -->", "<!-- staggered: end -->"
PEAKS = ("slider.ax", "motor1.torque", "motor4.torque", "P1.force", "P1.penetration")
HEAD = [
    *("case", "model and step", "slider acceleration [m/s^2]", "torque 1 [N m]", "torque 4 [N m]", "force at P1 [N]"),
    *("penetration [um]", "free flight [%]", "impacts a turn", "turns", "steps a turn", "CPU time of a turn [s]"),
]


def options_of(way: str) -> dict[str, Any]:
    """Keywords of `simulate`."""
    if way in NAMES:
        return {"step": fm.Adaptive(rtol=5e-5)} if way == "half" else {}
    play = "shared" if way.startswith(SHARED) else "independent"
    return {"method": Staggered(play=play), "step": fm.FixedStep(float(way.removeprefix(SHARED)))}


def mechanism_of(case: str, way: str) -> tuple[fm.Mechanism, float]:
    """The nine-bar of a case, and its period [s]."""
    speed, play = (float(x) for x in case.split("/"))
    flexible = way != "rigid"
    mech = nine_bar(speed * np.pi, clearance=1e-3 * play, flexible=flexible, data=limits.LIGHTLY_DAMPED)
    return mech, 2.0 / speed


def share_of_flight(sol: fm.Solution, begin: float, end: float) -> tuple[float, int]:
    """Part of the time in which the surfaces do not touch, and how many contacts began."""
    found = sol.episodes("P1")
    first = np.nan_to_num(found.start, nan=begin)
    last = np.nan_to_num(found.end, nan=end)
    touching = np.clip(last, begin, end) - np.clip(first, begin, end)
    return 1.0 - touching.sum() / (end - begin), int((first > begin).sum())


def row(case: str, way: str, turns: int, skip: int) -> dict[str, Any]:
    """Mean and spread over turns of one case and way."""
    mech, period = mechanism_of(case, way)
    state, rows, status, steps, end, busy = None, [], "", 0, 0.0, time.process_time()
    for k in range(skip + turns):
        sol = fm.simulate(mech, t_end=(k + 1) * period, save=10, restart=state, **options_of(way))
        status, state = sol.status, sol.restart
        if not sol.ok:
            print(case, way, status, flush=True)
        end = float(state["clock"][0])
        if abs(end - (k + 1) * period) > 1e-6 * period:
            break
        share, landings = share_of_flight(sol, k * period, (k + 1) * period)
        rows.append([*(sol.peak(name).value for name in PEAKS), 100.0 * share, float(landings)])
        steps = sol.stats.steps
    kept = np.array(rows[skip:])
    numbers: dict[str, Any] = {"case": case, "way": way, "turns": len(kept), "status": status, "end": end}
    numbers["cpu"], numbers["steps"] = (time.process_time() - busy) / (skip + turns), steps
    if len(kept) > 1:
        numbers["mean"], numbers["spread"] = kept.mean(axis=0).tolist(), kept.std(axis=0, ddof=1).tolist()
    print(case, way, numbers, flush=True)
    return numbers


def line(numbers: dict[str, Any]) -> list[str]:
    """One line of the table."""
    speed, play = numbers["case"].split("/")
    way = numbers["way"]
    kind = "staggered, shared" if way.startswith(SHARED) else "staggered"
    name = NAMES.get(way, f"{kind}, {way.removeprefix(SHARED)} s")
    head = [f"{speed} pi, {play} mm", name]
    if "mean" not in numbers:
        return [*head, f"blows up at {numbers['end']:.3g} s", *["-"] * 6, "0", "-", "-"]
    scale = np.array([1.0, 1.0, 1.0, 1.0, 1e6, 1.0, 1.0])
    mean, spread = (np.array(numbers[name]) * scale for name in ("mean", "spread"))
    places = [shown(m, s) for m, s in zip(mean, spread, strict=True)]
    return [*head, *places, str(numbers["turns"]), str(numbers["steps"]), plain(numbers["cpu"], 2)]


def read() -> dict[str, dict[str, Any]]:
    """All rows so far."""
    return json.loads(ROWS.read_text(encoding="utf-8")) if ROWS.exists() else {}


def keep(numbers: dict[str, Any]) -> None:
    """Put a row among the others."""
    rows = {**read(), f"{numbers['case']} {numbers['way']}": numbers}
    ordered = {key: rows[key] for case in CASES for way in WAYS if (key := f"{case} {way}") in rows}
    ROWS.write_text(json.dumps(ordered, indent=1) + "\n", encoding="utf-8")


def write() -> None:
    """Put the table between its marks."""
    page = PAGE.read_text(encoding="utf-8")
    if page.count(BEGIN) != 1 or page.count(END) != 1:
        raise SystemExit(f"{PAGE.name} needs the marks {BEGIN!r} and {END!r}, once each")
    rows = [line(numbers) for numbers in read().values()]
    text = limits.table(HEAD, rows, left=2)
    PAGE.write_text(f"{page.split(BEGIN)[0]}{BEGIN}\n\n{text}\n\n{END}{page.split(END)[1]}", encoding="utf-8")


def picture(case: str = "2/0.5", way: str = "2e-5", turn: int = 6) -> None:
    """Slider acceleration and force at P1 of one turn: rigid, staggered, coupled."""
    figure = Figure(figsize=(9.0, 7.0), layout="constrained")
    left, right = figure.subplots(3, 2, sharex=True).T
    titles = {"rigid": "rigid", way: f"flexible, staggered with {way} s", "coupled": "flexible, coupled equations"}
    for (kind, title), *axes in zip(titles.items(), left, right, strict=True):
        mech, period = mechanism_of(case, kind)
        sol = fm.simulate(mech, periods=turn, save_from_period=turn - 1, save=20_000, **options_of(kind))
        angle = 360.0 * (sol.time / period - turn + 1)
        for ax, name, label in zip(axes, ("slider.ax", "P1.force"), LABELS, strict=True):
            ax.plot(angle, sol.array(name), color="#1b6ca8", linewidth=0.6)
            ax.set_title(title, fontsize="small", loc="left")
            ax.set_ylabel(label, fontsize="small")
            ax.grid(visible=True, color="0.93", linewidth=0.5)
            ax.tick_params(labelsize="small")
    for ax in (left[-1], right[-1]):
        ax.set(xticks=range(0, 361, 60), xlim=(0, 360))
        ax.set_xlabel("turn of crank 4 [degrees]", fontsize="small")
    figure.suptitle(f"nine-bar at 2π rad/s with 0.5 mm of play, turn {turn}", fontsize="medium")
    figure.savefig(PICTURE, dpi=110)


LABELS = ("slider acceleration [m/s$^2$]", "force at P1 [N]")


def main() -> None:
    """Rows, page and picture."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cases", nargs="*", choices=CASES, default=[], help="cases to compute")
    parser.add_argument("--ways", nargs="+", choices=WAYS, default=list(WAYS), help="models and steps (all)")
    parser.add_argument("--turns", type=int, default=10, help="turns that count (10)")
    parser.add_argument("--skip", type=int, default=5, help="turns before them (5)")
    parser.add_argument("--picture", action="store_true", help="draw the picture")
    parser.add_argument("--write", action="store_true", help="write the page")
    options = parser.parse_args()
    for case in options.cases:
        for way in options.ways:
            keep(row(case, way, options.turns, options.skip))
    if options.picture:
        picture()
    if options.write:
        write()


if __name__ == "__main__":
    main()
