"""Time from the declaration of a chain to its first step, part by part: `python tests/speed/start.py [LINKS ...]`.

The rows are kept in out/speed for `python docs/performance.py --collect`.

A chain of LINKS hinged links of 4 beams hangs on the ground and falls (`models.chain`).  With the peer installed the
same chain is built and assembled there, and takes one step.  Times are of the processor; each chain has a process of
its own, so that nothing is remembered from another and the memory is its own.
"""

import math
import multiprocessing
import resource
import sys
import time

import models
from duel import keep

import flexmb as fm
from flexmb.program.compiler import compile_with_start
from flexmb.statics.start.consistent import consistent_start

ELEMENTS = 4
STEP = 1e-4  # s
CHAINS = (100, 900, 2500, 10_000, 25_000)
MOST_LINKS_OF_THE_PEER = 2500  # its time grows with the square: 74 s for 10,000
HEADS = ("links", "declared", "compiled", "start", "in all", "ms/element", "MB", "peer", "ours/peer")


def ours(links: int) -> tuple[float, float, float, float, float]:
    """Seconds of declaration, compiling, start values, and of all to the first step; megabytes of memory."""
    fm.simulate(models.chain(2, ELEMENTS), t_end=2.0 * STEP, step=STEP, save=1)  # what is compiled is loaded
    began = time.process_time()
    mechanism = models.chain(links, ELEMENTS)
    declared = time.process_time()
    fm.simulate(mechanism, t_end=1.0, step=STEP, save=1, max_steps=1)
    stepped = time.process_time()
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    return declared - began, *parts(links), stepped - began, memory


def parts(links: int) -> tuple[float, float]:
    """Seconds of compiling and of start values; the structure is worked out anew."""
    mechanism = models.chain(links + 1, ELEMENTS)
    began = time.process_time()
    program, closed = compile_with_start(mechanism)
    compiled = time.process_time()
    consistent_start(mechanism, program, closed=closed)
    return compiled - began, time.process_time() - compiled


def theirs(links: int) -> float:
    """Seconds of the peer, with its first step; NaN where it is not installed."""
    try:
        import peer
    except ImportError:
        return float("nan")
    if links > MOST_LINKS_OF_THE_PEER:
        return float("nan")
    stepping = peer.Stepping(1, solver=peer.TRAPEZOIDAL, sparse=True, tolerances=peer.BEAM_TOLERANCES)
    peer.chain(2, ELEMENTS).solve(STEP, stepping)
    began = time.process_time()
    peer.chain(links, ELEMENTS).solve(STEP, stepping)
    return time.process_time() - began


def apart(function, links):
    """What `function` finds in a new process."""
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        return pool.apply(function, (links,))


def row(links: int) -> list[float]:
    """A row of the table."""
    declared, compiled, start, total, memory = apart(ours, links)
    other = apart(theirs, links)
    return [links, declared, compiled, start, total, 1e3 * total / (links * ELEMENTS), memory, other, total / other]


if __name__ == "__main__":
    print("".join(f"{head:>11}" for head in HEADS))
    found = []
    for count in [int(word) for word in sys.argv[1:]] or CHAINS:
        found.append(row(count))
        print("".join(f"{value:11.4g}" for value in found[-1]), flush=True)
    keep("start", {"rows": [[None if math.isnan(value) else value for value in one] for one in found]})
