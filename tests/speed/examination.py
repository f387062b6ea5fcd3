"""Time of what is found on a run after its last step: `python tests/speed/examination.py`.

Vibrations are examined when somebody asks a solution for `findings` or `notes`.  The columns are the time of the
motion, and that of the examination; both are medians of five runs, in milliseconds of the processor.
"""

import time
from collections.abc import Iterator
from typing import Any

import numpy as np
import smooth

import flexmb as fm

REPEATS = 5
Case = tuple[str, fm.Mechanism, dict[str, Any]]


def cases() -> Iterator[Case]:
    """Names, mechanisms, and arguments of their runs."""
    for count in (10, 30, 100):
        yield f"chain of {count}", smooth.chain(count), {"t_end": 0.25}
    steps = {"t_end": 1.0, "step": 1.0 / 1600.0, "method": fm.RungeKutta4()}
    yield "chain of 10, Runge-Kutta", smooth.chain(10), steps
    yield "slider-crank, worn pin", fm.mechanisms.slider_crank(clearance=1e-4), {"periods": 2}
    yield "slider-crank, flexible", fm.mechanisms.slider_crank(flexible=True), {"periods": 2}
    yield "nine-bar, flexible", fm.mechanisms.nine_bar(flexible=True), {"periods": 1}


def measured(mechanism: fm.Mechanism, options: dict[str, Any]) -> tuple[float, float, fm.Solution]:
    """Seconds of a run and of the question for its notes, and the solution."""
    began = time.process_time()
    sol = fm.simulate(mechanism, **options)
    ran = time.process_time()
    _ = sol.notes
    return ran - began, time.process_time() - ran, sol


def main() -> None:
    """Print a row a mechanism."""
    print(f"{'':26}  coordinates  run [ms]  notes [ms]  notes")
    for name, mechanism, options in cases():
        measured(mechanism, options)
        *times, sols = zip(*(measured(mechanism, options) for _ in range(REPEATS)), strict=True)
        run, asked = 1e3 * np.median(times, axis=1)
        coordinates = len(sols[0].restart["q"]) - 3  # the last three are those of the ground
        print(f"{name:26}  {coordinates:11d}  {run:8.1f}  {asked:10.2f}  {len(sols[0].notes):5d}")


if __name__ == "__main__":
    main()
