"""Compute the numbers and pictures of docs/bearings.md anew: joints with oil, and joints that wear.

    python docs/bearings_table.py [--only oil]

The tables stand between marks in the page; rows are kept in docs/bearings.json.
"""

import argparse
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

import flexmb as fm
from flexmb.mechanisms import nine_bar

HERE = Path(__file__).resolve().parent
PAGE, ROWS, PICTURES = HERE / "bearings.md", HERE / "bearings.json", HERE / "pictures"
SPEED, WIDTH, ROUGHNESS = 2.0 * math.pi, 0.02, 2e-6
CLEARANCES, VISCOSITIES = (5e-5, 5e-4), (0.0, 5e-3, 2e-2, 1e-1)
STEP = fm.Adaptive(max=2e-4)
HEADS = {
    "oil": (
        *("clearance [mm]", "oil [mPa s]", "largest exponent [1/s]", "verdict", "peak acceleration [m/s²]"),
        *("peak force of P1 [N]", "thinnest film [µm]", "heat [W]"),
    ),
}


def oiled(clearance: float, viscosity: float) -> fm.Mechanism:
    """Rigid nine-bar at 2 pi rad/s with its joint P1 dry (viscosity 0) or in a short film."""
    dry = nine_bar(SPEED, clearance=clearance, ramp=2.0)
    if viscosity == 0.0:
        return dry
    joint = dry["P1"]
    film = fm.ShortBearing(viscosity=viscosity, width=WIDTH)
    given = {name: getattr(joint, name) for name in ("at", "clearance", "bearing_radius", "normal", "friction")}
    wet = fm.JournalBearing("P1", dry["crank1"], dry["link2"], film=film, roughness=ROUGHNESS, **given)
    return dry.with_part(wet)


def oil_row(clearance: float, viscosity: float) -> dict[str, Any]:
    """Exponent over 100 periods after 40, and what ten further periods show."""
    mech = oiled(clearance, viscosity)
    found = fm.lyapunov(mech, skip=40, periods=100, step=STEP, period=1.0)
    sol = fm.simulate(mech, periods=20, save_from_period=10, save=20_000)
    if not sol.ok:
        raise SystemExit(sol.status)
    of_force = [[sol.array(f"P1.{name}{axis}") for name in ("f", "film_f")[: 1 + bool(viscosity)]] for axis in "xy"]
    told = {name: sol.array(f"P1.{name}") for name in ("film_thickness", "power") if viscosity}
    return {
        "clearance": clearance, "viscosity": viscosity, "exponent": found.value, "error": found.error,
        "verdict": str(found.verdict), "acceleration": sol.peak("slider.ax").value,
        "force": float(np.hypot(*(np.sum(parts, axis=0) for parts in of_force)).max()),
        "film": float(told["film_thickness"].min()) if told else None,
        "heat": float(told["power"].mean()) if told else None,
        "orbit": [(1e6 * sol.array(f"P1.{name}")[::20]).round(1).tolist() for name in ("ex", "ey")],
    }  # fmt: skip


def oil_line(row: dict[str, Any]) -> str:
    """A row of the table."""
    film = ("-", "-") if row["film"] is None else (f"{1e6 * row['film']:.1f}", f"{row['heat']:.3g}")
    oil = "dry" if row["viscosity"] == 0.0 else f"{1e3 * row['viscosity']:g}"
    cells = (
        *(f"{1e3 * row['clearance']:g}", oil, f"{row['exponent']:.3g} ± {row['error']:.1g}", row["verdict"]),
        *(f"{row['acceleration']:.3g}", f"{row['force']:.0f}", *film),
    )
    return "| " + " | ".join(cells) + " |"


def draw_oil(rows: list[dict[str, Any]]) -> None:
    """Orbits of the journal in its clearance circle."""
    figure = Figure(figsize=(2.7 * len(VISCOSITIES), 3.0 * len(CLEARANCES)), layout="constrained")
    axes, turn = figure.subplots(len(CLEARANCES), len(VISCOSITIES), squeeze=False), np.linspace(0.0, 2.0 * np.pi, 200)
    for row in rows:
        ax = axes[CLEARANCES.index(row["clearance"]), VISCOSITIES.index(row["viscosity"])]
        circle = 1e6 * row["clearance"]
        ax.plot(circle * np.cos(turn), circle * np.sin(turn), color="0.7", lw=1.0)
        ax.plot(*row["orbit"], lw=0.6)
        oil = "dry" if row["viscosity"] == 0.0 else f"{1e3 * row['viscosity']:g} mPa s"
        ax.set_title(f"{1e3 * row['clearance']:g} mm, {oil}\n{row['verdict']}", fontsize=10)
        ax.set(aspect="equal", xlabel="ex [µm]", ylabel="ey [µm]")
    figure.savefig(PICTURES / "bearings_oil.png", dpi=90)


def put_table(name: str, lines: list[str]) -> None:
    """Put a table between its marks in the page."""
    text = PAGE.read_text(encoding="utf-8")
    begin, end = f"<!-- table: {name} -->", f"<!-- end: {name} -->"
    before, _, rest = text.partition(begin)
    head = ["| " + " | ".join(HEADS[name]) + " |", "|" + "---|" * len(HEADS[name])]
    PAGE.write_text(
        before + begin + "\n" + "\n".join([*head, *lines]) + "\n" + end + rest.partition(end)[2], encoding="utf-8"
    )


def oil(rows: dict[str, Any]) -> None:
    """Nine-bar with oil in P1."""
    found = rows.setdefault("oil", [])
    done = {(row["clearance"], row["viscosity"]) for row in found}
    for clearance in CLEARANCES:
        for viscosity in VISCOSITIES:
            if (clearance, viscosity) not in done:
                found.append(oil_row(clearance, viscosity))
                print(oil_line(found[-1]), flush=True)
                ROWS.write_text(json.dumps(rows) + "\n", encoding="utf-8")
    draw_oil(found)
    put_table("oil", [oil_line(row) for row in found])


STUDIES = {"oil": oil}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", choices=STUDIES, default=list(STUDIES))
    parser.add_argument("--fresh", action="store_true", help="compute all rows again")
    chosen = parser.parse_args()
    rows = json.loads(ROWS.read_text(encoding="utf-8")) if ROWS.exists() and not chosen.fresh else {}
    for name in chosen.only:
        STUDIES[name](rows)


if __name__ == "__main__":
    main()
