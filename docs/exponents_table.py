"""Compute anew the table of docs/chaos.md that holds exponents against tolerances and starts.

    python docs/exponents_table.py [--only rigid] [--fresh]

Each row: the largest exponent of one mechanism with the default tolerance from three starts of the journal, and from
the first of them with a tenth and a hundredth of the tolerance.  Runs that were made are kept in docs/exponents.json.
"""

import argparse
import json
import math
from collections.abc import Callable
from itertools import combinations
from pathlib import Path
from typing import Any, NamedTuple

import flexmb as fm
from flexmb.mechanisms import NineBarData, nine_bar, slider_crank

HERE = Path(__file__).resolve().parent
PAGE, RUNS = HERE / "chaos.md", HERE / "exponents.json"
BEGIN, END = "<!-- table: agreement -->", "<!-- end: agreement -->"
STARTS = ("centred", (0.8, 0.0), (0.0, -0.8))
"""Where the journal is at first, in clearances."""

COLUMNS = ((1e-4, 0), (1e-4, 1), (1e-4, 2), (1e-5, 0), (1e-6, 0))
"""Tolerance and start of each run."""

WITHIN = 3.0
"""Combined errors within which two runs agree."""


class Row(NamedTuple):
    """One mechanism.

    Parameters
    ----------
    name : for the table.
    joint : the one with clearance [m].
    clearance : of it.
    make : the mechanism.
    period : [s].
    skip, keep : periods before the first that counts, and periods that count.
    longest : largest step [s]; None: the default.
    """

    name: str
    joint: str
    clearance: float
    make: Callable[[], fm.Mechanism]
    period: float
    skip: int
    keep: int
    longest: float | None


def of_nine_bar(model: str, speed: float, clearance: float, keep: int) -> Row:
    """A row of the nine-bar mechanism; `speed` over pi [rad/s]."""
    T = 2.0 / speed

    def make() -> fm.Mechanism:
        data = NineBarData(damping=NineBarData.LIGHT_DAMPING)
        return nine_bar(speed * math.pi, clearance=clearance, flexible=model == "flexible", ramp=2.0 * T, data=data)

    name = f"nine-bar, {model}, {speed:g} pi, {1e3 * clearance:g} mm"
    return Row(name, "P1", clearance, make, T, 30, keep, 2e-4)


def of_slider_crank(clearance: float) -> Row:
    """A row of the ready slider-crank, 5000 rpm."""
    omega = 5000.0 * math.pi / 30.0
    name = f"slider-crank, 5000 rpm, {1e3 * clearance:g} mm"
    return Row(
        name, "B", clearance, lambda: slider_crank(omega, clearance=clearance), 2.0 * math.pi / omega, 40, 200, None
    )


ROWS = (
    of_slider_crank(0.1e-3),
    of_slider_crank(0.5e-3),
    of_nine_bar("rigid", 2.0, 0.05e-3, 100),
    *(of_nine_bar("rigid", speed, 0.5e-3, 100) for speed in (0.5, 1.5, 2.0, 2.5)),
    *(of_nine_bar("flexible", speed, 0.5e-3, 50) for speed in (0.5, 1.5, 2.0, 2.5)),
)


def run(row: Row, rtol: float, start: int) -> dict[str, Any]:
    """Exponent, error and remark of one run."""
    place = STARTS[start]
    place = place if isinstance(place, str) else (place[0] * row.clearance, place[1] * row.clearance)
    mech = row.make().with_({f"{row.joint}.start": place})
    flow = fm.chaos.MechanismFlow(mech, step=fm.Adaptive(rtol=rtol, max=row.longest), period=row.period)
    found = fm.lyapunov(flow, skip=row.skip, periods=row.keep, confirm=False)
    return {"value": found.value, "error": found.error, "verdict": str(found.verdict), "status": found.status}


def why(found: list[dict[str, Any]]) -> str:
    """Whether all runs agree, and else what the runs themselves say of it."""
    apart = max(abs(a["value"] - b["value"]) / math.hypot(a["error"], b["error"]) for a, b in combinations(found, 2))
    if apart <= WITHIN:
        return f"agree ({apart:.1f} errors at most)"
    if any("without a break" in one["status"] for one in found):
        return (
            f"no ({apart:.0f} errors): the journal never leaves its bearing, each run has the damping of its last onset"
        )
    return f"no ({apart:.1f} errors): the tolerance or the start changes more than the errors say"


def line(row: Row, found: list[dict[str, Any]]) -> str:
    """A row of the table."""
    cells = [f"{one['value']:.3g} ± {one['error']:.2g}" for one in found]
    return "| " + " | ".join([row.name, *cells, why(found)]) + " |"


def write_page(lines: list[str]) -> None:
    """Put the table into the page."""
    head = ["mechanism", *(f"rtol {rtol:g}, start {start + 1}" for rtol, start in COLUMNS), "within 3 errors"]
    text = PAGE.read_text(encoding="utf-8")
    before, _, rest = text.partition(BEGIN)
    _, _, after = rest.partition(END)
    rows = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head), *lines]
    PAGE.write_text(before + BEGIN + "\n" + "\n".join(rows) + "\n" + END + after, encoding="utf-8")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default="", help="rows whose name holds this text")
    parser.add_argument("--fresh", action="store_true", help="throw away what was computed")
    chosen = parser.parse_args()
    runs = json.loads(RUNS.read_text(encoding="utf-8")) if RUNS.exists() and not chosen.fresh else {}
    for row in ROWS:
        for rtol, start in COLUMNS:
            key = f"{row.name}; rtol {rtol:g}; start {start + 1}"
            if chosen.only in row.name and key not in runs:
                runs[key] = run(row, rtol, start)
                RUNS.write_text(json.dumps(runs, indent=1) + "\n", encoding="utf-8")
                print(key, f"{runs[key]['value']:.4g} +- {runs[key]['error']:.2g}", runs[key]["verdict"], flush=True)
    tables = [[runs.get(f"{row.name}; rtol {rtol:g}; start {k + 1}") for rtol, k in COLUMNS] for row in ROWS]
    write_page([line(row, found) for row, found in zip(ROWS, tables, strict=True) if all(found)])


if __name__ == "__main__":
    main()
