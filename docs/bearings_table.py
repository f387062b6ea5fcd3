"""Compute the numbers and pictures of docs/bearings.md anew: joints with oil, and joints that wear.

    python docs/bearings_table.py [--only oil worn guide three] [--fresh]

The tables stand between marks in the page; rows are kept in docs/bearings.json, surfaces in out/bearings, so that a
stopped call goes on.  All of it takes half an hour of one core.
"""

import argparse
import json
import math
import shutil
import time
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

import flexmb as fm
from flexmb.mechanisms import nine_bar, slider_crank

HERE = Path(__file__).resolve().parent
PAGE, ROWS, PICTURES = HERE / "bearings.md", HERE / "bearings.json", HERE / "pictures"
SPEED, WIDTH, ROUGHNESS = 2.0 * math.pi, 0.02, 2e-6
CLEARANCES, VISCOSITIES = (5e-5, 5e-4), (0.0, 5e-3, 2e-2, 1e-1)
STEP = fm.Adaptive(max=2e-4)
SPIN, TURNS, LEVELS = 2.0 * math.pi * 1000 / 60, 1e6, (0, 1, 2, 5, 10)
WORN, LIFE = ("P1", "P4", "A"), 2e5
LAW = fm.Archard(bearing=1e-13, bins=360)
STORES = HERE.parent / "out" / "bearings"
HEADS = {
    "oil": (
        *("clearance [mm]", "oil [mPa s]", "largest exponent [1/s]", "verdict", "peak acceleration [m/s²]"),
        *("peak force of P1 [N]", "thinnest film [µm]", "heat [W]"),
    ),
    "worn": (
        *("turns", "deepest [µm]", "half of the play [µm]", "volume [mm³]", "peak force [N]", "largest exponent [1/s]"),
        *("a turn", "verdict"),
    ),
    "guide": (
        *("turns", "upper side, deepest [µm]", "lower side, deepest [µm]", "half of the play [µm]", "volume [mm³]"),
        "peak force [N]",
    ),
    "three": (
        "turns",
        *(f"{name}: deepest [µm], peak force [N]" for name in WORN),
        "largest exponent [1/s]",
        "verdict",
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


def worn_crank() -> fm.Mechanism:
    """Slider-crank at 1000 rpm with 0.05 mm of play in the joint of its slider, whose bearing wears."""
    dry = slider_crank(speed=SPIN, clearance=5e-5)
    return dry.with_part(dry["B"].worn_by(LAW))


def worn_guide() -> fm.Mechanism:
    """Slider-crank at 1000 rpm with 0.05 mm of play in its guide, whose sides wear at places of 0.42 mm."""
    mech = slider_crank(speed=SPIN)
    guide = fm.PrismaticClearance(
        "guide", fm.GROUND, mech["slider"], clearance=5e-5, half_length=0.02, half_height=0.01,
        normal=fm.KelvinVoigt(3e8, 3e4), friction=fm.ModifiedCoulomb(0.1, v0=1e-3, v1=1e-2),
    )  # fmt: skip
    return mech.with_part(guide.worn_by(fm.Archard(bearing=1e-14, width=0.02, bins=720), length=0.3))


def worn_bars() -> fm.Mechanism:
    """Rigid nine-bar at 2 pi rad/s with 0.05 mm of play at three joints, whose bearings wear."""
    mech = nine_bar(SPEED, clearance=5e-5, ramp=2.0)
    given = {name: getattr(mech["P1"], name) for name in ("clearance", "bearing_radius", "normal", "friction")}
    for name, first, second in (("P1", "crank1", "link2"), ("P4", "crank4", "link3"), ("A", "rocker6", "panel7")):
        joint = fm.RevoluteClearance(name, mech[first], mech[second], at=mech[name].at, **given)
        mech = mech.with_part(joint.worn_by(LAW))
    return mech


def at_turn(mech: fm.Mechanism, life: Any, row: int) -> fm.Mechanism:
    """The mechanism with the surfaces of a row of its wear."""
    for name in life.attrs["joints"]:
        mech = mech.with_part(mech[name].with_depths(life[f"{name}.bearing_profile"].values[row]))
    return mech


def judged(mech: fm.Mechanism, period: float, skip: int) -> dict[str, Any]:
    """Exponent and verdict over 100 periods."""
    found = fm.lyapunov(mech, skip=skip, periods=100, step=STEP, period=period)
    return {"exponent": found.value, "error": found.error, "verdict": str(found.verdict), "period": period}


def lives(mech: fm.Mechanism, name: str, **options: Any) -> tuple[Any, Any]:
    """A million turns with the tolerance 0.02, and with half of it; processor time of those that are not stored."""
    found = []
    for part in (1.0, 0.5):
        begin, store = time.process_time(), STORES / f"{name}_{part:g}"
        found.append(
            fm.wear_out(mech, turns=TURNS, keep=10, tolerance=0.02 * part, store=store, resume=True, **options)
        )
        spent = time.process_time() - begin
        print(f"{name}, tolerance {0.02 * part:g}: {found[-1]['runs'][-1]:.0f} runs, {spent:.0f} s", flush=True)
    return found[0], found[1]


def guide(rows: dict[str, Any]) -> None:
    """Guide of a slider-crank from new to worn, and how much half of the tolerance changes."""
    whole, half = lives(worn_guide(), "guide", sample=4)
    sides = [whole[f"guide.{side}_profile"].values for side in ("upper", "lower")]
    rows["guide"] = [
        [float(whole["turns"][k]), *(float(side[k].max()) for side in sides)]
        + [float(whole[f"guide.{name}"][k]) for name in ("clearance", "volume", "peak_force")]
        for k in LEVELS
    ]
    ROWS.write_text(json.dumps(rows) + "\n", encoding="utf-8")
    lines = [
        f"| {turns:,.0f} | {1e6 * upper:.1f} | {1e6 * lower:.1f} | {1e6 * play:.1f} "
        f"| {1e9 * volume:.3g} | {force:.0f} |"
        for turns, upper, lower, play, volume, force in rows["guide"]
    ]
    put_table("guide", lines)
    change = max(
        float(np.abs(half[f"guide.{side}_profile"].values[-1] - depth[-1]).max())
        for side, depth in zip(("upper", "lower"), sides, strict=True)
    )
    volume = abs(half["guide.volume"][-1] / whole["guide.volume"][-1] - 1.0)
    print(
        "\n".join(lines),
        f"\nhalf of the tolerance changes the profiles by up to {1e6 * change:.3f} um and the volume by "
        f"{100.0 * volume:.2g} %; stated {1e6 * whole['guide.error'][-1]:.3f} um",
    )
    fm.plots.plot_wear(whole, "guide").savefig(PICTURES / "bearings_guide.png", dpi=90)


def worn(rows: dict[str, Any]) -> None:
    """Slider-crank from new to worn, and how much half of the tolerance changes."""
    mech = worn_crank()
    whole, half = lives(mech, "crank")
    depth = whole["B.bearing_profile"].values
    rows["worn"] = [
        {
            "turns": float(whole["turns"][k]),
            "deepest": float(depth[k].max()),
            "clearance": float(whole["B.clearance"][k]),
            "volume": float(whole["B.volume"][k]),
            "force": float(whole["B.peak_force"][k]),
            **judged(at_turn(mech, whole, k), 2.0 * math.pi / SPIN, 100),
        }
        for k in LEVELS
    ]
    ROWS.write_text(json.dumps(rows) + "\n", encoding="utf-8")
    lines = [
        f"| {row['turns']:,.0f} | {1e6 * row['deepest']:.2f} | {1e6 * row['clearance']:.2f} "
        f"| {1e9 * row['volume']:.3g} | {row['force']:.0f} | {row['exponent']:.3g} ± {row['error']:.1g} "
        f"| {row['exponent'] * row['period']:.3g} "
        f"| {row['verdict']} |"
        for row in rows["worn"]
    ]
    put_table("worn", lines)
    change = np.abs(half["B.bearing_profile"].values - depth)[-1].max()
    volume = abs(half["B.volume"][-1] / whole["B.volume"][-1] - 1.0)
    print(
        "\n".join(lines),
        f"\n{whole['runs'][-1]:.0f} and {half['runs'][-1]:.0f} runs; half of the tolerance changes the profile by up "
        f"to {1e6 * change:.3f} um and the volume by {100.0 * volume:.2g} %; "
        f"stated {1e6 * whole['B.error'][-1]:.3f} um",
    )
    fm.plots.plot_wear(whole, "B").savefig(PICTURES / "bearings_worn.png", dpi=90)


def three(rows: dict[str, Any]) -> None:
    """Nine-bar whose joints wear at three places."""
    mech = worn_bars()
    life = fm.wear_out(mech, turns=LIFE, keep=4, settle=3, sample=4, tolerance=0.05, store=STORES / "bars", resume=True)
    rows["three"] = [
        {
            "turns": float(life["turns"][k]),
            "joints": [
                [float(life[f"{name}.bearing_profile"][k].max()), float(life[f"{name}.peak_force"][k])] for name in WORN
            ],
            **judged(at_turn(mech, life, k), 1.0, 40),
        }
        for k in (0, 4)
    ]
    ROWS.write_text(json.dumps(rows) + "\n", encoding="utf-8")
    lines = []
    for row in rows["three"]:
        joints = " | ".join(f"{1e6 * depth:.2f}, {force:.0f}" for depth, force in row["joints"])
        lines.append(
            f"| {row['turns']:,.0f} | {joints} | {row['exponent']:.3g} ± {row['error']:.1g} | {row['verdict']} |"
        )
    put_table("three", lines)
    print("\n".join(lines))


STUDIES = {"oil": oil, "worn": worn, "guide": guide, "three": three}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", choices=STUDIES, default=list(STUDIES))
    parser.add_argument("--fresh", action="store_true", help="forget what was computed")
    chosen = parser.parse_args()
    if chosen.fresh:
        shutil.rmtree(STORES, ignore_errors=True)
    rows = json.loads(ROWS.read_text(encoding="utf-8")) if ROWS.exists() and not chosen.fresh else {}
    for name in chosen.only:
        STUDIES[name](rows)


if __name__ == "__main__":
    main()
