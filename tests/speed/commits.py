"""Two checkouts of flexmb on the same models, in turn: processor time of the time loop a step, and ratios of pairs.

    python tests/speed/commits.py OLD NEW [--models nine-bar worn ...] [--rounds 7]

OLD and NEW are folders of checkouts with their environments in `.venv`.  One process of each runs a model once for
compilation, and then once a round, so that other work slows both.  The loop is `NewmarkStepper.advance` of a checkout;
models are those of `tests/speed/models.py` of each.
"""

import argparse
import gc
import importlib
import json
import math
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterable
from pathlib import Path
from statistics import median
from typing import Any

HOMES = ("flexmb.engine.newmark.method", "flexmb.step.newmark.method")
"""Modules of `NewmarkStepper`, today and at earlier commits."""


def rigid_chain(links: int) -> Any:
    """A chain of rigid links of 0.4 m, let go from the horizontal."""
    import flexmb as fm

    parts, last = [], fm.GROUND
    for k in range(links):
        link = fm.RigidLink(f"L{k}", (0.4 * k, 0.0), (0.4 * k + 0.4, 0.0), 1.0, 0.013)
        parts += [link, fm.Revolute(f"J{k}", last, link, (0.4 * k, 0.0))]
        last = link
    return fm.Mechanism("chain", tuple(parts), gravity=(0.0, -9.81))


def nine_bar(**options: Any) -> Any:
    """The nine-bar mechanism with 0.5 mm of play at 2 pi rad/s."""
    from flexmb.mechanisms import nine_bar

    return nine_bar(2.0 * math.pi, clearance=0.5e-3, **options)


def cases() -> dict[str, Callable[[], tuple[Any, dict[str, Any]]]]:
    """Models and arguments of their runs."""
    import models

    return {
        "nine-bar": lambda: (nine_bar(), {"periods": 1}),
        "nine-bar-from-rest": lambda: (models.nine_bar(), {"t_end": 1.0}),
        "nine-bar-flexible": lambda: (nine_bar(flexible=True), {"t_end": 0.03}),
        "worn": lambda: (models.worn(), {"t_end": 2.0 * models.TURN}),
        "ideal": lambda: (models.ideal(), {"t_end": 2.0 * models.TURN, "step": 1e-5}),
        "beams-9x4": lambda: (models.chain(9, 4), {"t_end": 0.5, "step": 1e-4}),
        "links-10": lambda: (rigid_chain(10), {"t_end": 0.5, "step": 1e-3}),
        "links-100": lambda: (rigid_chain(100), {"t_end": 0.5, "step": 1e-3}),
    }


def answer(lines: Iterable[str]) -> None:
    """Run the model that each line names, and print microseconds a step of the loop and of `simulate`."""
    package = Path(importlib.import_module("flexmb").__file__).parents[1]
    home = next(name for name in HOMES if package.joinpath(*name.split(".")).with_suffix(".py").exists())
    sys.path[0] = str(package / "tests" / "speed")
    stepper = importlib.import_module(home).NewmarkStepper
    import flexmb as fm

    spent, plain, made = [0.0], stepper.advance, {}

    def advance(self: Any, *arguments: Any) -> Any:
        began = time.process_time()
        try:
            return plain(self, *arguments)
        finally:
            spent[0] += time.process_time() - began

    stepper.advance = advance
    for name in map(str.strip, lines):
        if name not in made:
            made[name] = cases()[name]()
            fm.simulate(made[name][0], save=8, **made[name][1])
        gc.collect()
        spent[0], began = 0.0, time.process_time()
        sol = fm.simulate(made[name][0], save=8, **made[name][1])
        whole = time.process_time() - began
        print(json.dumps([1e6 * seconds / sol.stats.steps for seconds in (spent[0], whole)]), flush=True)


def started(folder: Path) -> subprocess.Popen:
    """A process that answers with flexmb of a checkout."""
    own = {"PYTHONPATH": str(folder), "NUMBA_CACHE_DIR": str(folder / ".numba_cache"), "FLEXMB_MESSAGES": "0"}
    environment = {**os.environ, **own, "OPENBLAS_NUM_THREADS": "1"}
    return subprocess.Popen(
        [folder / ".venv" / "bin" / "python", Path(__file__).resolve(), "--answer"],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment,
    )  # fmt: skip


def compare(folders: list[Path], names: list[str], rounds: int) -> None:
    """Print medians of both checkouts, and of the ratios of pairs."""
    both = [started(folder.resolve()) for folder in folders]
    print(f"{'us a step':20}{'loop, old':>11}{'new':>8}{'ratio':>8}{'all, old':>11}{'new':>8}{'ratio':>8}")
    for name in names:
        found: list[list[list[float]]] = []
        for _ in range(rounds):
            found.append([])
            for one in both:
                one.stdin.write(f"{name}\n")
                one.stdin.flush()
                found[-1].append(json.loads(one.stdout.readline()))
        row = f"{name:20}"
        for k in (0, 1):
            old, new = ([pair[which][k] for pair in found] for which in (0, 1))
            ratio = median(b / a for a, b in zip(old, new, strict=True))
            row += f"{median(old):11.2f}{median(new):8.2f}{ratio:8.3f}"
        print(row, flush=True)
    for one in both:
        one.stdin.close()


def main() -> None:
    """Read the command line."""
    if sys.argv[1:] == ["--answer"]:
        answer(sys.stdin)
        return
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("old", type=Path)
    parser.add_argument("new", type=Path)
    parser.add_argument("--models", nargs="+", default=["nine-bar", "worn", "beams-9x4", "links-10", "links-100"])
    parser.add_argument("--rounds", type=int, default=7)
    given = parser.parse_args()
    compare([given.old, given.new], given.models, given.rounds)


if __name__ == "__main__":
    main()
