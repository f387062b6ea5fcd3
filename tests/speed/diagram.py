"""A bifurcation diagram of 30,720 speeds in threads: `python tests/speed/diagram.py [--points 30720] [--turns 20]`.

The slider-crank with .1 mm of play in the joint of the slider, from 150 to 450 rad/s.  The picture and the row for
docs/performance.py lie in out/speed.  It wants a quiet machine.
"""

import argparse
import os
import resource
import time

import numpy as np
from duel import RECORDS, keep

import flexmb as fm
from flexmb.mechanisms import slider_crank

SPEEDS, CLEARANCE, SIGNAL = (150.0, 450.0), 1e-4, "slider.vx"  # [rad/s], [m]
MEBI = 1024.0  # kibibytes of `ru_maxrss` in a mebibyte


def memory():
    """Largest memory of the process so far [MiB]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / MEBI


def diagram(points, turns, threads):
    """The diagram, its time on the clock and of the processors [s]."""
    given = {"fixed": {"clearance": CLEARANCE}, "signals": ["slider.x", SIGNAL, "B.normal_force"]}
    began, spent = time.perf_counter(), time.process_time()
    kept = max(turns // 4, 1)
    found = fm.bifurcation(slider_crank, "speed", np.linspace(*SPEEDS, points), skip=turns - kept, keep=kept,
                           executor=threads, **given)  # fmt: skip
    return found, time.perf_counter() - began, time.process_time() - spent


def main():
    """Measure, draw, keep."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--points", type=int, default=30720)
    parser.add_argument("--turns", type=int, default=20)
    parser.add_argument("--threads", type=int, default=len(os.sched_getaffinity(0)))
    options = parser.parse_args()
    diagram(2 * options.threads, options.turns, options.threads)  # compiled code and workspaces are there now
    before = memory()
    found, clock, processors = diagram(options.points, options.turns, options.threads)
    failed = int((~found["ok"].values).sum())
    record = vars(options) | {"clock": clock, "processors": processors, "memory": memory() - before, "failed": failed}
    keep("diagram", record)
    fm.plot_bifurcation(found, SIGNAL).savefig(RECORDS / "diagram.png", dpi=150)
    a_turn = 1e3 * processors / options.points / options.turns
    print(f"{options.points} points of {options.turns} turns with {options.threads} threads: {clock:.0f} s")
    print(f"{a_turn:.2f} ms of the processor a turn, {record['memory']:.0f} MiB more, {failed} points failed")


if __name__ == "__main__":
    main()
