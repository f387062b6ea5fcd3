"""The checks of docs/nine_bar.md: ideal joints by hand, stiff links, onset of free flight.

Each function measures and returns a passage of the page; nine_bar_table.py puts it there.  What is measured stands in
tests/mechanisms/nine_bar_measures.py, where the tests hold it to limits.
"""

import runpy
import textwrap
from pathlib import Path
from types import SimpleNamespace

import numpy as np

from flexmb.mechanisms import NineBarData, nine_bar

measures = SimpleNamespace(**runpy.run_path(str(Path(__file__).parents[1] / "tests/mechanisms/nine_bar_measures.py")))

METHODS = {
    "generalised-alpha": "generalised-alpha, 0.1 ms",
    "trapezoidal": "trapezoidal rule, 0.1 ms",
    "adaptive": "generalised-alpha, error-controlled",
    "Runge-Kutta": "Runge-Kutta, 1 ms",
}
SIGNALS = {
    "slider.x": "position of the slider",
    "slider.ax": "its acceleration",
    "P1.force": "force at P1",
    "motor1.torque": "torque 1",
}
FACTORS = (1.0, 10.0, 100.0, 1000.0)
STEPS = (5e-4, 1e-4)  # s
PLAY = 0.5e-3  # m
LIGHTLY_DAMPED = NineBarData(damping=NineBarData.LIGHT_DAMPING)
ONSET = (1.50, 1.55, 1.60, 1.65, 1.70, 1.75, 1.80)  # over pi
FIRST, LAST = 11, 20  # turns that count


def wrapped(text: str) -> str:
    """One paragraph, as wide as the page."""
    return textwrap.fill(text, 120, break_on_hyphens=False)


def table(head: list[str], rows: list[list[str]], left: int = 1) -> str:
    """Rows below a head; the first `left` columns are flush left."""
    rule = "|" + "---|" * left + "---:|" * (len(head) - left)
    return "\n".join([f"| {' | '.join(head)} |", rule, *(f"| {' | '.join(r)} |" for r in rows)])


def checks() -> str:
    """Errors of the ideal mechanism for each method."""
    columns = {name: errors_of(name) for name in METHODS}
    labels = next(iter(columns.values()))
    rows = [[label, *(columns[name][label] for name in METHODS)] for label in labels]
    inverse = max(measures.inverse_dynamics_errors().values())
    text = (
        "Largest errors over all accepted steps of two turns at 2 pi rad/s; what is marked 'relative' is over the "
        f"largest value of the signal. Torques of `inverse_dynamics` at 41 instants of a turn: {inverse:.0e}, relative."
    )
    return wrapped(text) + "\n\n" + table(["what", *METHODS.values()], rows)


def errors_of(name: str) -> dict[str, str]:
    """One column of the table of checks."""
    sol = measures.ideal_run(name)
    kinetic, potential = measures.energy_errors(sol)
    force = measures.force_errors(sol)
    torque = max(force["motor1.torque"], force["motor4.torque"])
    column = {
        "gaps of all joints, slider off its line [m], tilt of the slider [rad]": max(measures.gaps(sol).values()),
        "positions and rates [m, rad, m/s, rad/s], relative where above 1": max(measures.motion_errors(sol).values()),
        "kinetic energy, eq. (12) with Ls2 in J22, relative": kinetic,
        "potential energy, eq. (13), relative": potential,
        "torques, by virtual power, relative": torque,
        "acceleration of the slider, relative": force["slider.ax"],
    }
    shown = {label: f"{error:.0e}" for label, error in column.items()}
    # Simpson's rule wants equal steps; the errors of Runge-Kutta are those of rounding and have no order in the step.
    equal, implicit = name != "adaptive", name in {"generalised-alpha", "trapezoidal"}
    shown["work of the drives less change of energy, over the energy turned over"] = (
        f"{measures.work_errors(sol)[0].max():.0e}" if equal else "-"
    )
    found = measures.orders(measures.METHODS[name][0])[-1] if implicit else ()
    shown["order in the step (from 0.5 to 0.25 ms) of torque 1 and the acceleration"] = (
        ", ".join(f"{order:.2f}" for order in found) or "-"
    )
    print(f"checks, {name}: {'; '.join(shown.values())}", flush=True)
    return shown


def stiff() -> str:
    """Differences of the flexible mechanism to the rigid one for ever stiffer links."""
    rows = []
    for step in STEPS:
        found = measures.differences(FACTORS, step, list(SIGNALS))
        rates = np.vstack([np.full(len(SIGNALS), np.nan), -np.log10(found[1:] / found[:-1])])
        for factor, values, orders in zip(FACTORS, found, rates, strict=True):
            cells = [f"{v:.1e}" + ("" if np.isnan(o) else f" ({o:.2f})") for v, o in zip(values, orders, strict=True)]
            rows.append([f"{1e3 * step:g}", f"{factor:g}", *cells])
            print(f"stiff: {', '.join(rows[-1])}", flush=True)
    text = (
        "Ideal joints, a start from rest within one second, damping 1e-4 s, third turn at 2 pi rad/s: largest "
        "differences to the rigid mechanism with the same steps, over the range of the signal. In brackets: the power "
        "of 1/E by which they fell from the row above."
    )
    return wrapped(text) + "\n\n" + table(["step [ms]", "E / 207 GPa", *SIGNALS.values()], rows, left=0)


def onset() -> str:
    """Free flight of the rigid mechanism around the speed where it begins."""
    rows = []
    for factor in ONSET:
        speed = factor * np.pi
        turns = measures.turns(nine_bar(speed, clearance=PLAY), speed, LAST)
        found = np.array([measures.share_of_flight(sol) for sol in turns])
        kept = found[FIRST - 1 :] * (100.0, 1.0)
        share = f"{kept[:, 0].mean():.1f} ± {kept[:, 0].std(ddof=1):.1f}" if kept[:, 0].any() else "0"
        rows.append([f"{factor:.2f} pi", share, f"{kept[:, 1].mean():.1f}", f"{found[0, 1]:.0f}"])
        print(f"onset: {', '.join(rows[-1])}", flush=True)
    text = (
        f"Rigid mechanism with {1e3 * PLAY:g} mm of play at P1: mean ± standard deviation of turns {FIRST} to {LAST}, "
        "and the first turn, which starts with the journal in the middle of its bearing."
    )
    head = ["speed [rad/s]", "free flight [%]", "landings a turn", "landings in turn 1"]
    return wrapped(text) + "\n\n" + table(head, rows)
