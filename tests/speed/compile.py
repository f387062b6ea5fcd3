"""What compiling costs: a table of the first run ever, the next process, imports, cache and memory.

    python tests/speed/compile.py                  # this checkout
    python tests/speed/compile.py --beside FOLDER  # another checkout beside it, in turns
    python tests/speed/compile.py --shipped FOLDER # an installation that carries compiled code (`make wheel`)
    python tests/speed/compile.py --costs          # flexmb/engine/compiled/notice.py anew, printed

With --keep it becomes a part of docs/performance.md.  Every row is a process of its own.
Seconds are processor time, since other work on the machine counts less there.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

COUNT = """
import resource, sys, time
began = time.perf_counter()
import flexmb as fm
imported = time.process_time()
"""
RUN = COUNT + "fm.simulate(fm.mechanisms.nine_bar(), t_end=0.01)\n"
FLEXIBLE = COUNT + "fm.simulate(fm.mechanisms.nine_bar(clearance=5e-4, flexible=True), t_end=1e-3)\n"
TANGENT = COUNT + (
    "flow = fm.chaos.MechanismFlow(fm.mechanisms.slider_crank(clearance=5e-4))\n"
    "flow.advance(1e-5, flow.tangent_basis(1, seed=0))\n"
)
SAY = """
rss = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
print("measured", imported, time.process_time(), time.perf_counter() - began, rss)
"""
COSTS = """
import os, time
if hasattr(os, "sched_setaffinity"):
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})  # no second process
from numba.core import event
class Clock(event.Listener):
    depth, began, found = 0, 0.0, []
    def on_start(self, e):
        self.began = time.process_time() if self.depth == 0 else self.began
        self.depth += 1
    def on_end(self, e):
        self.depth -= 1
        if self.depth == 0:
            f = e.data["dispatcher"].py_func
            self.found.append((f"{f.__module__}.{f.__qualname__}", time.process_time() - self.began))
clock = Clock()
event.register("numba:compile", clock)
from flexmb.engine.compiled import notice
import flexmb as fm
crank = fm.mechanisms.slider_crank(clearance=5e-4)
fm.mechanisms.nine_bar, fm.simulate
print(f"REFERENCE_PACE = {notice.REFERENCE_PACE * notice.pace.__wrapped__()[0]:.4f}")
fm.simulate(fm.mechanisms.nine_bar(), t_end=1e-3)
for method in (fm.RungeKutta4(), fm.DormandPrince(), fm.RadauIIA()):
    fixed = {"step": 1e-6} if isinstance(method, fm.RungeKutta4) else {}
    fm.simulate(fm.mechanisms.slider_crank(), t_end=1e-5, method=method, **fixed)
flow = fm.chaos.MechanismFlow(crank); flow.advance(1e-5, flow.tangent_basis(1, seed=0))
stage_of = {name: stage for stage, known in notice.STAGES.items() for name in known}
for name, cost in clock.found:
    print(f"{stage_of.get(name, '-'):30s} {name}: {cost:.2f}")
"""


def measured(code: str, checkout: Path, cache: Path, **variables: str) -> list[float]:
    """Processor time of the imports and of all, time by the clock [s], memory [MB]."""
    environment = {**os.environ, "PYTHONPATH": str(checkout), "NUMBA_CACHE_DIR": str(cache), "FLEXMB_MESSAGES": "0"}
    command = [sys.executable, "-c", code + SAY]
    said = subprocess.run(
        command, env=environment | variables, cwd=checkout, check=True, capture_output=True, text=True
    ).stdout
    return [float(x) for x in said.split("measured")[1].split()]


def size(folder: Path) -> float:
    """Size of a folder [MB]."""
    return sum(file.stat().st_size for file in folder.rglob("*") if file.is_file()) / 1e6


def rows(checkout: Path) -> dict[str, str]:
    """The rows of one checkout."""
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        cache = Path(folder)
        for label, code in (("nine-bar", RUN), ("nine-bar, flexible, then", FLEXIBLE), ("tangent loop, then", TANGENT)):
            _, total, wall, memory = measured(code, checkout, cache)
            found[f"first result ever, {label}"] = f"{total:.1f} s ({wall:.1f} s by the clock, {memory:.0f} MB)"
        found["size of the cache"] = f"{size(cache):.1f} MB in {len(list(cache.rglob('*.nbc')))} files"
        for label, code in (("nine-bar", RUN), ("nine-bar, flexible", FLEXIBLE), ("tangent loop", TANGENT)):
            least = min(measured(code, checkout, cache) for _ in range(5))
            found[f"second process, {label}"] = f"{least[1]:.2f} s ({least[3]:.0f} MB)"
        found["import flexmb"] = f"{min(measured(COUNT, checkout, cache)[0] for _ in range(5)):.2f} s"
    return found


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--beside", type=Path, help="another checkout")
    parser.add_argument("--shipped", type=Path, help="a folder with an installation that carries compiled code")
    parser.add_argument("--keep", action="store_true", help="write it to docs/performance.json and docs/performance.md")
    parser.add_argument("--costs", action="store_true", help="print what stands in flexmb/engine/compiled/notice.py")
    options = parser.parse_args()
    if options.costs:
        with tempfile.TemporaryDirectory() as cache:
            variables = {"PYTHONPATH": str(ROOT), "NUMBA_CACHE_DIR": cache, "FLEXMB_MESSAGES": "0"}
            subprocess.run([sys.executable, "-c", COSTS], env={**os.environ, **variables}, check=True)
        return
    named = {"compiled here": ROOT, "beside": options.beside, "shipped": options.shipped}
    tables = {name: rows(folder.resolve()) for name, folder in named.items() if folder is not None}
    print("| | " + " | ".join(tables) + " |")
    print("|---" * (len(tables) + 1) + "|")
    for label in next(iter(tables.values())):
        print(f"| {label} | " + " | ".join(table[label] for table in tables.values()) + " |")
    if options.keep:
        keep(tables)


def keep(tables: dict[str, dict[str, str]]) -> None:
    """Leave the record where docs/performance.py collects it, and let it write the page."""
    from duel import RECORDS, stamp

    RECORDS.mkdir(parents=True, exist_ok=True)
    record = {"tables": tables, "where": stamp()}
    (RECORDS / "compile.json").write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")
    subprocess.run([sys.executable, str(ROOT / "docs" / "performance.py"), "--collect"], check=False)


if __name__ == "__main__":
    main()
