"""Compute the numbers and the pictures of docs/nine_bar.md anew.

    python docs/nine_bar_table.py [--only checks|stiff|onset|table|pictures]
        [--turns 20] [--speeds 0.5 2 2.5] [--skip 5] [--elements 4]

Each passage stands between its own marks in the page, and is written as soon as it is known.  The passages of checks
come from nine_bar_limits.py.  In the table every run goes on turn by turn; peaks and shares of free flight come from
ALL accepted steps, because a contact lasts some 0.1 ms and a grid of saved instants would miss its peak.  The turns
after the first --skip count.
"""

import argparse
import itertools
import time
from pathlib import Path
from typing import NamedTuple

import nine_bar_limits as limits
import numpy as np
from matplotlib.figure import Figure

import flexmb as fm
from flexmb.mechanisms import nine_bar

HERE = Path(__file__).resolve().parent
PAGE, PICTURES = HERE / "nine_bar.md", HERE / "pictures"
PLAY = limits.PLAY
MODELS = {"ideal": {}, "rigid": {"clearance": PLAY}, "flexible": {"clearance": PLAY, "flexible": True}}
PASSAGES = ("checks", "stiff", "onset", "table", "pictures")
HEAD = [
    *("speed", "model", "slider acceleration [m/s^2]", "torque 1 [N m]", "torque 4 [N m]", "force at P1 [N]"),
    *("penetration [um]", "free flight [%]", "landings a turn", "turns", "mean step [us]", "wall (CPU) time [s]"),
]


class Turn(NamedTuple):
    """Largest absolute values of one turn, and what it cost."""

    slider: float  # m/s^2
    torque1: float  # N m
    torque4: float  # N m
    force: float  # N
    penetration: float  # um
    flight: float  # per cent
    landings: float
    step: float  # us
    wall: float  # s
    cpu: float  # s


def peaks_of(mech: fm.Mechanism, speed: float, count: int) -> list[Turn]:
    """So many turns, with at least 1000 steps each so that smooth peaks are met, too."""
    found = []
    began, busy = time.perf_counter(), time.process_time()
    for sol in limits.measures.turns(mech, speed, count, step=fm.Adaptive(max=1e-3 * 2.0 * np.pi / speed)):
        depth, share, landings = 0.0, 0.0, 0
        if "P1.penetration" in sol:
            depth = max(float(sol.array("P1.penetration").max()), 0.0)
            share, landings = limits.measures.share_of_flight(sol)
        peaks = (sol.peak(name).value for name in ("slider.ax", "motor1.torque", "motor4.torque", "P1.force"))
        step = float(np.diff(sol.time).mean())
        cost = time.perf_counter() - began, time.process_time() - busy
        found.append(Turn(*peaks, 1e6 * depth, 100.0 * share, float(landings), 1e6 * step, *cost))
        began, busy = time.perf_counter(), time.process_time()
    return found


def row(speed: float, model: str, turns: int, skip: int, elements: int) -> list[str]:
    """One line of the table."""
    found = peaks_of(nine_bar(speed * np.pi, elements=elements, **MODELS[model]), speed * np.pi, skip + turns)
    kept = np.array(found[skip:])
    mean, spread = kept.mean(axis=0), kept.std(axis=0, ddof=1) if turns > 1 else np.zeros(kept.shape[1])
    places = [shown(m, s) for m, s in zip(mean[:7], spread[:7], strict=True)]
    if model == "ideal":
        places[4:7] = ["-"] * 3
    seconds = f"{sum(t.wall for t in found):.1f} ({sum(t.cpu for t in found):.1f})"
    print(f"{speed:g} pi {model}: {', '.join(places)}; {seconds} s", flush=True)
    return [f"{speed:g} pi", model, *places, str(turns), plain(mean[7], 3), seconds]


def shown(mean: float, spread: float) -> str:
    """Mean and spread, and the mean alone where all turns are alike."""
    return f"{plain(mean, 4)} ± {plain(spread, 2)}" if spread > 1e-4 * abs(mean) else plain(mean, 4)


def plain(value: float, digits: int) -> str:
    """`value` to so many digits, without an exponent."""
    return f"{float(f'{value:.{digits}g}'):g}"


def write(name: str, text: str) -> None:
    """Put a passage between its marks in the page."""
    begin, end = f"<!-- {name}: begin, written by nine_bar_table.py -->", f"<!-- {name}: end -->"
    page = PAGE.read_text(encoding="utf-8")
    if page.count(begin) != 1 or page.count(end) != 1 or page.index(end) < page.index(begin):
        raise SystemExit(f"{PAGE.name}: the passage {name!r} needs the marks {begin!r} and {end!r}, once each")
    before, after = page.split(begin)[0], page.split(end)[1]
    PAGE.write_text(f"{before}{begin}\n\n{text}\n\n{end}{after}", encoding="utf-8")


def table(options: argparse.Namespace) -> str:
    """The table of peaks, with what stands above it."""
    began = time.perf_counter()
    cases = itertools.product(options.speeds, MODELS)
    rows = [row(speed, model, options.turns, options.skip, options.elements) for speed, model in cases]
    text = explanation(options.turns, options.skip, options.elements, time.perf_counter() - began)
    return limits.wrapped(text) + "\n\n" + limits.table(HEAD, rows, left=2)


def pictures() -> None:
    """The mechanism at four instants; one turn of the three models."""
    PICTURES.mkdir(exist_ok=True)
    mech = nine_bar(2.0 * np.pi, clearance=PLAY, flexible=True)
    sol = fm.simulate(mech, periods=1, save=200)
    fm.render(sol, [0.125, 0.375, 0.625, 0.875], path=PICTURES / "nine_bar_poses.png", size=(11.0, 8.2))
    compare(2.0 * np.pi, 6).savefig(PICTURES / "nine_bar_models.png", dpi=130)


def compare(speed: float, turn: int) -> Figure:
    """Slider acceleration and joint force of one turn, the three models one below the other."""
    figure = Figure(figsize=(9.0, 7.0), layout="constrained")
    left, right = figure.subplots(3, 2, sharex=True).T
    colours = {"ideal": "0.35", "rigid": "#1b6ca8", "flexible": "#d1495b"}
    for (model, options), a, f in zip(MODELS.items(), left, right, strict=True):
        mech = nine_bar(speed, **options)
        *_, sol = limits.measures.turns(mech, speed, turn)
        angle = np.degrees(speed * sol.time) - 360.0 * (turn - 1)
        for ax, name, label in ((a, "slider.ax", "slider acceleration [m/s$^2$]"), (f, "P1.force", "force at P1 [N]")):
            ax.plot(angle, sol.array(name), color=colours[model], linewidth=0.7)
            ax.set_ylabel(label, fontsize="small")
            ax.set_title(model if model == "ideal" else f"{model}, 0.5 mm of play", fontsize="small", loc="left")
            ax.grid(visible=True, color="0.93", linewidth=0.5)
            ax.tick_params(labelsize="small")
    for ax in (left[-1], right[-1]):
        ax.set(xticks=range(0, 361, 60), xlim=(0, 360))
        ax.set_xlabel("turn of crank 4 [degrees]", fontsize="small")
    figure.suptitle(f"nine-bar at {speed / np.pi:g}π rad/s, turn {turn}", fontsize="medium")
    return figure


def main() -> None:
    """Passages and pictures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", choices=PASSAGES, help="this passage alone (all)")
    parser.add_argument("--turns", type=int, default=20, help="turns of the table that count (20)")
    parser.add_argument("--skip", type=int, default=5, help="turns before them (5)")
    parser.add_argument("--speeds", type=float, nargs="+", default=[0.5, 2.0, 2.5], help="speeds over pi (0.5 2 2.5)")
    parser.add_argument("--elements", type=int, default=4, help="beam elements of a link (4)")
    options = parser.parse_args()
    fm.simulate(nine_bar(np.pi, **MODELS["flexible"]), t_end=1e-3)  # compile, so that no row pays for it
    texts = {
        "checks": limits.checks,
        "stiff": limits.stiff,
        "onset": limits.onset,
        "table": lambda: table(options),
    }
    for name in [options.only] if options.only else PASSAGES:
        if name == "pictures":
            pictures()
        else:
            write(name, texts[name]())


def explanation(turns: int, skip: int, elements: int, seconds: float) -> str:
    """What stands above the table."""
    return (
        f"Clearance 0.5 mm. Mean ± standard deviation of the largest absolute values of each of {turns} turns, after "
        f"the first {skip}; generalised-alpha with spectral radius 0.8, error-controlled steps, at least 1000 a turn, "
        f"{elements} elements a link. Times are those of all {turns + skip} turns; {seconds:.0f} s for the whole table "
        "on one core, which other work may have shared: compare CPU times."
    )


if __name__ == "__main__":
    main()
