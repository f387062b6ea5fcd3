"""A diagram of a relief valve with impacts, as an own equation in compiled code: `python tests/speed/valve.py`.

The tops of the opening over 30,720 flows q from .2 to 10 (C. Hos, A. Champneys, Physica D 241 (2012) 2068), and the two
neighbouring flows between which small motions about the rest cease to grow.  Picture and row lie in out/speed.
"""

import argparse
import math
import os
import time

import numba
import numpy as np
from duel import RECORDS, keep

import flexmb as fm

FLOWS, START = (0.2, 10.0), (0.2, 0.0, 0.0)
SKIP, KEEP, SMALL = 1024, 32, 1e-4


@numba.njit
def rates(t, x, q):
    """Rates of opening, speed and pressure."""
    return x[1], -1.25 * x[1] - (x[0] + 10.0) + x[2], 20.0 * (q - x[0] * math.sqrt(x[2]))


@numba.njit
def opening(t, x, q):
    """Distance of the valve from its seat."""
    return x[0]


@numba.njit
def rebound(t, x, q):
    """State after an impact."""
    return x[0], -0.8 * x[1], x[2]


def tops(start=START, *, compiled=True, rtol=1e-10):
    """The section of the valve at its tops."""
    functions = rates, opening, rebound
    function, gap, jump = functions if compiled else (one.py_func for one in functions)
    ode = fm.chaos.ODE(function, start, parameters={"q": 5.0}, names=["y", "v", "p"], rtol=rtol, atol=1e-10)
    return fm.chaos.SectionMap(fm.chaos.ImpactODE(ode, gap=gap, jump=jump), "v", direction="down", limit=200.0)


def grows(q):
    """Whether a small motion about the rest grows over the tops of a point of the diagram."""
    y = float(max(np.roots([1.0, 10.0, 0.0, -q * q]).real))
    section = tops((y + SMALL, 0.0, y + 10.0), rtol=1e-12)
    section.flow.reset((y + SMALL, 0.0, y + 10.0), parameters={"q": q})
    section.reset(section.state())
    section.advance(KEEP)
    before = section.state()[0] - y
    section.advance(SKIP)
    return section.state()[0] - y > before


def neighbours(flows):
    """Two neighbouring flows: small motions grow at the first and decay at the second."""
    low, high = np.searchsorted(flows, (8.0, 9.0))
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if grows(flows[middle]) else (low, middle)
    return flows[low], flows[high]


def by_python():
    """Time of a top [s] without compilation."""
    section = tops(compiled=False)
    section.advance(5)
    began = time.process_time()
    section.advance(20)
    return (time.process_time() - began) / 20


def main():
    """Measure, draw, keep."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--points", type=int, default=30720)
    parser.add_argument("--threads", type=int, default=len(os.sched_getaffinity(0)))
    options = parser.parse_args()
    flows = np.linspace(*FLOWS, options.points)
    tops().advance(3)  # compiled now
    began, spent = time.perf_counter(), time.process_time()
    found = fm.bifurcation(tops(), "q", flows, skip=SKIP, keep=KEEP, signals=["y"], executor=options.threads)
    record = vars(options) | {"clock": time.perf_counter() - began, "processors": time.process_time() - spent}
    record["piled"] = int(found.status.str.contains("pile up").sum())
    record |= {"returns": SKIP + KEEP, "failed": int((~found.ok.values).sum()), "python": by_python()}
    record["grows"], record["decays"] = neighbours(flows)
    keep("valve", record)
    fm.plot_bifurcation(found, "y").savefig(RECORDS / "valve.png", dpi=150)
    print(record)
    print(found.status.values[~found.ok.values & ~found.status.str.contains("pile up").values][:5])


if __name__ == "__main__":
    main()
