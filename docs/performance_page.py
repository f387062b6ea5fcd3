"""The page of docs/performance.py: its text, its tables, its pictures."""

import math
import re
import textwrap
from pathlib import Path

from duel import TORQUE, Timing, Verdict
from matplotlib.figure import Figure

HEAD = """\
# Performance

flexmb beside Exudyn on the same models, which `tests/speed/models.py` and `tests/speed/peer.py` build from the same
numbers. This page is written by `make speed`, or by `python docs/performance.py`; `--only NAME` measures one row
again.

What is timed: the motion, without building and compiling the model, finding start values, files and sensors.
flexmb's time contains its account of energies, the contact episodes, the largest values of all signals and the
making of the solution. Both codes run in turn in one process, one thread each; times are medians of CPU times of
that process, which on a quiet machine are those of the clock. A ratio is the peer's median over ours, in brackets
its range over the rounds. Accuracy comes from one more run, in which every step is looked at."""

PEER = """\
Settings of the peer. Generalised alpha with spectral radius 0.9, index 3, modified Newton, dense solver, unless a
row says otherwise. Its default settings stop at the first impact of a joint with play; "h = ..." there means steps
of that size that contacts may not change (`useRecommendedStepSize = False`), "located" a tolerance of the contact
iteration of 1e4 and a least step of 1e-13 s, with 480 steps nominally (nine-bar: 5000 a turn, flexible 10000).
Chains and the flexible nine-bar take tolerances of Newton's method of 1e-4 and 1e-2, because the default ones lie
below the round-off of stiff beams and make it cut its steps; "tighter" is 1e-6 and 1e-6. They, and rods marked so,
take the sparse solver. flexmb's default is error-controlled steps with the default tolerances."""

SUMMARY = "| row | peer's setting | ours | errors, peer and ours | ratio | wanted | |\n|---|---|---|---:|---:|---:|---|"
RUNNERS = "| code | setting | time [ms] | {} |\n|---|---|---:|{}|"
STATISTICS = """\
Ten turns after the first, mean and standard deviation of turns; forces in N, torque of crank 1 in N m, flight as a
share of time. The motion is chaotic: only such means can be compared."""
COMPILING = """\
Processes of their own, one after the other: on an empty cache, then with what is kept. Seconds are processor time, of
second processes the least of five. `python tests/speed/compile.py --keep` measures it."""
COLOURS = {
    "flexmb": ("#1b6ca8", "#00838f", "#6a3d9a", "#2e8b57"),
    "scipy": ("#d1495b", "#8d1f2d", "#e08e0b", "#8d5524"),
}


def write(path: Path, data: dict, order: list[str]) -> None:
    """The whole page."""
    rows = [data["rows"][name] for name in order if name in data["rows"]]
    parts = [HEAD.strip(), about(rows), PEER]
    parts.append("\n".join([SUMMARY, *(line for row in rows for line in summary(row))]))
    for row in rows:
        parts += details(row, data["before"].get(row["name"]))
    others = data["others"]
    parts += statistics(others)
    if "compile" in others:
        parts += compiling(others["compile"])
    if "work-precision" in others:
        parts += work_precision(others["work-precision"], path.parent / "pictures")
    if "smooth" in others:
        parts += smooth(others["smooth"])
    if "limits" in others:
        parts += limits(others["limits"])
    if "start" in others:
        parts += start(others["start"])
    if "statics" in others:
        parts += statics(others["statics"])
    if "bearings" in others:
        parts += bearings(others["bearings"], others["lives"])
    if "diagram" in others:
        parts += diagram(others["diagram"])
    if "valve" in others:
        parts += valve(others["valve"])
    path.write_text("\n\n".join(wrapped(p) for p in parts if p) + "\n", encoding="utf-8")


def wrapped(text: str) -> str:
    """Paragraphs as wide as the page; tables, headings and pictures as they are."""
    if text.startswith(("|", "#", "!", "<")):
        return text
    return "\n\n".join(textwrap.fill(" ".join(p.split()), 120) if p[0] != "#" else p for p in re.split(r"\n\n+", text))


def about(rows: list[dict]) -> str:
    """Machine, versions, dates."""
    kinds = {}
    for row in rows:
        where = row["where"]
        kinds.setdefault((where["date"], where["machine"], where["versions"]), []).append(row)
    texts = []
    for (date, machine, versions), found in kinds.items():
        which = "All rows" if len(kinds) == 1 else ", ".join(row["name"] for row in found)
        loads = sorted(float(row["where"]["load"]) for row in found if row["where"]["load"] != "-")
        busy = f"; load averages {loads[0]:g} to {loads[-1]:g}" if loads else ""
        texts.append(f"{which}: {date}, {machine}, {versions}{busy}.")
    return " ".join(texts)


def number(value: float, digits: int = 3) -> str:
    """A number for a cell."""
    return "-" if value is None or math.isnan(value) else f"{value:.{digits}g}"


def summary(row: dict) -> list[str]:
    """Lines of the first table."""
    found = []
    for k, v in enumerate(Verdict(**one) for one in row["verdicts"]):
        title = f"[{row['title']}](#{row['name']})" if k == 0 else ""
        errors = f"{number(v.their_error, 2)}, {number(v.our_error, 2)}"
        ratio = f"{number(v.ratio)} ({number(v.low)} to {number(v.high)})"
        state = "" if v.holds else f"**missed**: {v.complaint}"
        why = f" ({v.why})" if v.why else ""
        found.append(f"| {title} | {v.theirs} | {v.ours}{why} | {errors} | {ratio} | {v.factor:g} | {state} |")
    return found


def details(row: dict, before: dict | None) -> list[str]:
    """What is said of a row below the first table."""
    timings = [Timing(**one) for one in row["timings"]]
    names = list(dict.fromkeys(name for t in timings for name in t.values))
    parts = [f'<a id="{row["name"]}"></a>\n\n## {row["title"][0].upper()}{row["title"][1:]}']
    text = f"Error: {row['error']}. {row['rounds']} rounds."
    if row["reference"]:
        text += f" Reference: {row['reference']}."
    parts.append(f"{text} {row['note']}".strip())
    body = []
    for t in timings:
        if t.failure:
            body.append(f"| {t.code} | {t.label} | gave up: {t.failure} |" + " |" * len(names))
            continue
        cells = " | ".join(value_cell(name, t.values.get(name, math.nan), row.get("spikes")) for name in names)
        body.append(f"| {t.code} | {t.label} | {1e3 * t.middle:.4g}{earlier(t, before)} | {cells} |")
    parts.append("\n".join([RUNNERS.format(" | ".join(names), "---:|" * len(names)).replace("||", "|"), *body]))
    if before:
        parts.append(f"In brackets: the same at commit {before['commit']}, {before['where']['date']}.")
    return parts


def value_cell(name: str, value: float, spikes: float | None) -> str:
    """A value; a false peak of the torque is shown as one."""
    text = number(value, 2 if name == "error" else 6)
    return f"**{text}**" if name == TORQUE and spikes is not None and value > spikes else text


def earlier(timing: Timing, before: dict | None) -> str:
    """The time of an earlier commit, in brackets."""
    if not before or timing.code != "flexmb" or timing.label not in before["times"]:
        return ""
    return f" ({1e3 * before['times'][timing.label]:.4g})"


def statistics(others: dict) -> list[str]:
    """The nine-bar over ten turns."""
    parts = []
    for name, title in (("statistics-rigid", "rigid"), ("statistics-flexible", "flexible, 4 beams a link")):
        if name not in others:
            continue
        rows = others[name]["rows"]
        keys = list(rows[0]["values"])
        lines = [f"| {title} | time a turn [s] | {' | '.join(keys)} |", "|---|---:|" + "---:|" * len(keys)]
        for row in rows:
            cells = " | ".join(f"{mean:.4g} ± {spread:.2g}" for mean, spread in row["values"].values())
            lines.append(f"| {row['code']}, {row['label']} | {row['seconds a turn']:.3g} | {cells} |")
        parts.append("\n".join(lines))
        parts.append(f"Computed on {others[name]['where']['date']}; these times contain the saving of every step.")
    return ["## The nine-bar over ten turns", STATISTICS, *parts] if parts else []


def compiling(record: dict) -> list[str]:
    """What compiling costs."""
    tables = record["tables"]
    lines = ["| | " + " | ".join(tables) + " |", "|---" * (len(tables) + 1) + "|"]
    labels = next(iter(tables.values()))
    lines += [f"| {label} | " + " | ".join(table[label] for table in tables.values()) + " |" for label in labels]
    return ["## Compiling", f"{COMPILING} Measured on {record['where']['date']}.", "\n".join(lines)]


def work_precision(record: dict, pictures: Path) -> list[str]:
    """The diagram of error against time, and what it says."""
    pictures.mkdir(exist_ok=True)
    figure = Figure(figsize=(11.0, 4.8), layout="constrained")
    axes = figure.subplots(1, len(record["problems"]))
    for ax, problem in zip(axes, record["problems"], strict=True):
        counts = {"flexmb": 0, "scipy": 0}
        for curve in problem["curves"]:
            family = curve["label"].split(maxsplit=1)[0].rstrip(",")
            colour = COLOURS[family][counts[family]]
            counts[family] += 1
            times, errors = zip(*curve["points"], strict=True)
            style = {"marker": "o" if family == "flexmb" else "s", "markersize": 4, "linewidth": 1.2}
            ax.loglog([1e3 * t for t in times], errors, color=colour, label=curve["label"], **style)
        ax.set(xlabel="time [ms]", ylabel=problem["error"], title=problem["title"])
        ax.grid(visible=True, color="0.92", linewidth=0.5)
        ax.legend(fontsize="x-small")
    figure.savefig(pictures / "performance_work_precision.png", dpi=130)
    where = record["where"]
    text = f"""\
    The rigid slider-crank, ideal and turning freely (exact: a quadrature) and with play (reference: DOP853, rtol
    1e-13), against scipy's solve_ivp on equations written by hand for this one mechanism in one and two coordinates
    (`tests/speed/minimal.py`), each contact begun and ended by an event; right-hand sides in Python and through numba.
    flexmb solves for nine coordinates and their joint forces without knowing the mechanism. The least of seven times,
    in turns; {where["date"]}."""
    return [
        "## Error against time",
        text,
        "![Error against time](pictures/performance_work_precision.png)",
        *best(record),
    ]


def best(record: dict) -> list[str]:
    """A table: the least time to reach an error."""
    parts = []
    for problem in record["problems"]:
        errors = (1e-3, 1e-5, 1e-7) if "rad" in problem["error"] else (1e-5, 1e-6, 1e-7)
        lines = [f"| {problem['title']}: time [ms] to an error of | {' | '.join(f'{e:.0e}' for e in errors)} |"]
        lines.append("|---|" + "---:|" * len(errors))
        for curve in problem["curves"]:
            cells = []
            for limit in errors:
                reached = [t for t, e in curve["points"] if e <= limit]
                cells.append(number(1e3 * min(reached)) if reached else "-")
            lines.append(f"| {curve['label']} | {' | '.join(cells)} |")
        parts.append("\n".join(lines))
    return parts


def limits(record: dict) -> list[str]:
    """Costs and limits of tests/speed/test_speed.py."""
    lines = ["| what | found | limit | |", "|---|---:|---:|---|"]
    lines += [f"| {what} | {number(a)} | {number(b)} | {unit} |" for what, a, b, unit in record["rows"]]
    where = record["where"]
    text = f"""\
    Medians of seven; limits are for a quiet machine (`tests/speed/test_speed.py`). A step is timed by the CPU, new
    processes by the clock. {where["date"]},
    load average {where["load"]}."""
    return ["## Costs and their growth", text, "\n".join(lines)]


def smooth(record: dict) -> list[str]:
    """Smooth rigid motion at equal error, by tests/speed/smooth.py."""
    where = record["where"]
    text = f"""\
    Least processor times [ms] at no larger an error than the given one [m, rad], of all tolerances or steps that were
    tried (`python tests/speed/smooth.py`, then `python docs/performance.py --collect`). Chains of rigid links, 1 m in
    all, fall from the horizontal for 1 s, that of 1000 links for 0.25 s; the error is that of the place of the tip.
    Andrews' mechanism moves 0.03 s; the error is that of its angles. Hand-written equations are those of the one
    mechanism, through numba: the chain by recursion over its links. flexmb's times contain its account of energies,
    the making of the solution and, of RungeKutta4, its examination of vibrations; not start values.
    MuJoCo {record["mujoco"]}; {where["date"]}, load average
    {where["load"]}."""
    return ["## Smooth rigid motion", text, "\n".join(record["table"])]


def start(record: dict) -> list[str]:
    """From the declaration of a chain to its first step, by tests/speed/start.py."""
    heads = ("links of 4 beams", "declared [s]", "compiled [s]", "start values [s]", "to the first step [s]")
    heads += ("ms an element", "memory [MB]", "Exudyn, to the first step [s]", "ours over Exudyn's")
    lines = [f"| {' | '.join(heads)} |", "|" + "---:|" * len(heads)]
    for links, *values in record["rows"]:
        cells = ("-" if value is None else number(value) for value in values)
        lines.append(f"| {links:,.0f} | {' | '.join(cells)} |")
    where = record["where"]
    text = f"""\
    From the declaration of a falling chain to the end of its first step, each chain in a process of its own, compiled
    functions loaded, signals of the start alone saved (`python tests/speed/start.py`, then `python docs/performance.py
    --collect`); processor times. {where["date"]}, load average {where["load"]}."""
    return ["## Start of large models", text, "\n".join(lines)]


MODELS = {
    "bar": "plane body of 10,700 nodes, clamped",
    "frame": "lattice of beams",
    "chain": "chain of beams on springs",
    "masses": "lattice of point masses and springs",
}
"""Models of tests/speed/statics.py."""


def statics(record: dict) -> list[str]:
    """Statics, modes and buckling of large models, by tests/speed/statics.py."""
    heads = ("model", "coordinates", "compiled [s]", "equilibrium [s]", "10 modes [s]", "8 load factors [s]")
    heads += ("memory [MB]",)
    lines = [f"| {' | '.join(heads)} |", "|---|" + "---:|" * (len(heads) - 1)]
    for name, unknowns, *values in record["rows"]:
        lines.append(f"| {MODELS[name]} | {unknowns:,.0f} | {' | '.join(map(number, values))} |")
    where = record["where"]
    text = f"""\
    Each model in a process of its own, compiled functions loaded (`python tests/speed/statics.py`, then `python
    docs/performance.py --collect`); processor times. {where["date"]}, load average {where["load"]}."""
    parts = ["## Statics at size", text, "\n".join(lines)]
    if record["reduced"]:
        _, nodes, declared, reduced, memory = record["reduced"]
        parts.append(
            f"`fm.Reduced` of a plane body of {nodes:,} nodes to 6 modes: {number(declared)} s for its mesh, "
            f"{number(reduced)} s, {number(memory)} MB at the most."
        )
    return parts


def bearings(record: dict, many: dict) -> list[str]:
    """Oil films and worn contacts beside dry joints, and many turns, by tests/speed/bearings.py."""
    lines = ["| joint | a step [us] | over that with the dry joint |", "|---|---:|---:|"]
    lines += [f"| {name} | {number(step)} | {number(ratio)} |" for name, step, ratio in record["rows"]]
    lives = ["| tolerance | processor time [s] | runs | deepest [um] | volume [mm^3] |", "|---:|---:|---:|---:|---:|"]
    lives += [f"| {' | '.join(f'{value:.4g}' for value in row)} |" for row in many["rows"]]
    where, then = record["where"], many["where"]
    text = f"""\
    Steps of 10 us over two turns at 1000 rpm, in pairs with the dry joint, guide or slot (medians of seven;
    `python tests/speed/bearings.py`, then `python docs/performance.py --collect`). {where["date"]}, load average
    {where["load"]}. {record.get("note", "")} Then a million turns of wear of the joint B; {then["date"]}, load average
    {then["load"]}."""
    return ["## Oil and wear", text, "\n".join(lines), "\n".join(lives)]


def diagram(record: dict) -> list[str]:
    """A large bifurcation diagram in threads, by tests/speed/diagram.py."""
    where, turns = record["where"], record["points"] * record["turns"]
    a_turn, hours = 1e3 * record["processors"] / turns, 200 / record["turns"] * record["clock"] / 3600
    text = f"""\
    A bifurcation diagram of {record["points"]:,} speeds of the slider-crank with .1 mm of play, {record["turns"]} turns
    each, in {record["threads"]} threads of one process: {record["clock"] / 60:.0f} min on the clock, {a_turn:.2g} ms of
    the processors a turn, {record["memory"]:.0f} MiB more at the end than after the first points, {record["failed"]}
    points failed; {hours:.1f} h with 200 turns each at this rate (`python tests/speed/diagram.py`, then
    `python docs/performance.py --collect`). {where["date"]}, load average {where["load"]}."""
    return ["## A large diagram", text]


def valve(record: dict) -> list[str]:
    """A diagram of an own differential equation with impacts, by tests/speed/valve.py."""
    where, returns = record["where"], record["points"] * record["returns"]
    text = f"""\
    The same number of flows of a relief valve that hits its seat, an own equation of three states whose functions are
    compiled (`fm.chaos.ImpactODE`; C. Hos, A. Champneys, Physica D 241 (2012) 2068): {record["points"]:,} flows,
    {record["returns"]:,} tops each with rtol 1e-10, in {record["threads"]} threads: {record["clock"] / 60:.0f} min on
    the clock, {1e6 * record["processors"] / returns:.0f} us of the processors a top. {record["piled"]} points end in
    chatter, {record["failed"] - record["piled"]} otherwise. Small motions about the rest grow at q =
    {record["grows"]:.6f} and decay at {record["decays"]:.6f}, neighbours in the diagram; the Hopf bifurcation is at
    8.4911176. Without compilation a top takes {1e3 * record["python"]:.0f} ms (`python tests/speed/valve.py`, then
    `python docs/performance.py --collect`). {where["date"]}, load average {where["load"]}."""
    return [text]
