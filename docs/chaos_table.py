"""Compute the numbers and the picture of docs/chaos.md anew.

    python docs/chaos_table.py [--speeds 0.5 1.5 2 2.5] [--models rigid flexible] [--skip 40] [--keep 200]

The table stands between two marks in the page.  A row that is computed again replaces the one that is there; the
numbers of all rows are kept in docs/chaos.json, the points of their sections in docs/pictures/chaos.npz.
"""

import argparse
import json
import time
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

import flexmb as fm
from flexmb.mechanisms import nine_bar

HERE = Path(__file__).resolve().parent
PAGE, ROWS = HERE / "chaos.md", HERE / "chaos.json"
PICTURE, POINTS = HERE / "pictures" / "chaos.png", HERE / "pictures" / "chaos.npz"
PLAY = 0.5e-3
RAMP = 2.0
"""Periods of the soft start."""

STEP = fm.Adaptive(max=2e-4)
"""Steps that do not damp the vibrations of a journal in contact, see the page."""

MODELS = {"rigid": False, "flexible": True}
SIGNALS = ("P1.ex", "P1.ey", "slider.x")
BEGIN, END = "<!-- table: nine-bar -->", "<!-- end: nine-bar -->"
HEAD = (
    *("speed", "model", "largest exponent [1/s]", "a period", "verdict", "through P1.ex", "P1.ey", "slider.x"),
    *("0-1 test of P1.ex", "P1.ey", "slider.x", "CPU time [s]", "of the plain run"),
)


def row(speed: float, model: str, skip: int, keep: int) -> tuple[dict[str, Any], np.ndarray]:
    """All numbers of one speed (in pi rad/s) and model, and where the journal is once a period (keep, 2) [m]."""
    period = 2.0 / speed
    mech = nine_bar(speed=speed * np.pi, clearance=PLAY, flexible=MODELS[model], ramp=RAMP * period)
    busy = time.process_time()
    found = fm.lyapunov(mech, skip=skip, periods=keep, step=STEP, period=period)
    took = time.process_time() - busy
    column = [found.names.index(name) for name in SIGNALS]
    spread, noise = np.std(found.points, axis=0), found.signals.resolution
    tests = [
        fm.chaos.zero_one_test(found.points[:, k]).value if spread[k] > 10.0 * noise[k] else np.nan for k in column
    ]
    numbers = {
        "speed": speed,
        "model": model,
        "exponent": found.value,
        "error": found.error,
        "period": found.period,
        "verdict": str(found.verdict),
        "reason": found.verdict.reason if found.verdict else found.status,
        "through": [str(found.seen_through(name)) for name in SIGNALS],
        "zero_one": tests,
        "spread": [float(spread[k]) for k in column],
        "points": keep,
        "cpu": took,
        "ratio": took / plain(mech, period, skip, keep),
    }
    return numbers, found.points[:, column[:2]]


def plain(mech: fm.Mechanism, period: float, skip: int, keep: int) -> float:
    """CPU time of the run without tangents that the exponent's is compared with [s]: that of a fifth, times five."""
    flow = fm.chaos.MechanismFlow(mech, step=STEP, period=period)
    some = max((skip + keep) // 5, 1)
    busy = time.process_time()
    for _ in range(some):
        flow.advance(period)
    return (time.process_time() - busy) * (skip + keep) / some


def line(found: dict[str, Any]) -> str:
    """A row of the table."""
    error = f"{found['exponent']:.3g} ± {found['error']:.1g}"
    tests = [f"{value:.2f}" if np.isfinite(value) else "-" for value in found["zero_one"]]
    cells = (
        *(f"{found['speed']:g} pi", found["model"], error, f"{found['exponent'] * found['period']:.3g}"),
        *(found["verdict"], *found["through"], *tests, f"{found['cpu']:.0f}", f"{found['ratio']:.1f} x"),
    )
    return "| " + " | ".join(cells) + " |"


def write_page(rows: dict[str, dict[str, Any]]) -> None:
    """Put the table into the page."""
    text = PAGE.read_text(encoding="utf-8")
    before, _, rest = text.partition(BEGIN)
    _, _, after = rest.partition(END)
    lines = ["| " + " | ".join(HEAD) + " |", "|" + "---|" * len(HEAD)]
    lines += [
        line(rows[key]) for key in sorted(rows, key=lambda key: (rows[key]["model"] != "rigid", rows[key]["speed"]))
    ]
    PAGE.write_text(before + BEGIN + "\n" + "\n".join(lines) + "\n" + END + after, encoding="utf-8")


def draw(points: dict[str, np.ndarray], rows: dict[str, dict[str, Any]]) -> None:
    """Where the journal is once a period, for each speed and model."""
    speeds = sorted({rows[key]["speed"] for key in rows})
    models = [model for model in MODELS if any(rows[key]["model"] == model for key in rows)]
    figure = Figure(figsize=(3.1 * len(speeds), 3.3 * len(models)), layout="constrained")
    axes = figure.subplots(len(models), len(speeds), squeeze=False)
    angle = np.linspace(0.0, 2.0 * np.pi, 200)
    for i, model in enumerate(models):
        for j, speed in enumerate(speeds):
            key, ax = f"{model} {speed:g}", axes[i, j]
            ax.plot(1e3 * PLAY * np.cos(angle), 1e3 * PLAY * np.sin(angle), color="0.7", lw=1.0)
            if key in points:
                ax.plot(*(1e3 * points[key].T), ".", ms=4.0)
                ax.set_title(f"{model}, {speed:g} pi rad/s\n{rows[key]['verdict']}", fontsize=10)
            ax.set(aspect="equal", xlabel="ex [mm]", ylabel="ey [mm]")
    figure.savefig(PICTURE, dpi=110)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--speeds", type=float, nargs="+", default=[0.5, 1.5, 2.0, 2.5], help="in pi rad/s")
    parser.add_argument("--models", nargs="+", choices=MODELS, default=list(MODELS))
    parser.add_argument("--skip", type=int, default=40, help="periods for the transient")
    parser.add_argument("--keep", type=int, default=100, help="periods that count")
    chosen = parser.parse_args()
    rows = json.loads(ROWS.read_text(encoding="utf-8")) if ROWS.exists() else {}
    points = dict(np.load(POINTS)) if POINTS.exists() else {}
    for model in chosen.models:
        for speed in chosen.speeds:
            key = f"{model} {speed:g}"
            rows[key], points[key] = row(speed, model, chosen.skip, chosen.keep)
            print(line(rows[key]), rows[key]["reason"], flush=True)
            ROWS.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
            np.savez_compressed(POINTS, **points)
            write_page(rows)
            draw(points, rows)


if __name__ == "__main__":
    main()
