"""Fuzzing: random linkages are examined, run, and compared with themselves in other views.

    python tests/fuzz/fuzz.py --count 10000 --compare 100

Every linkage must end in one of: a run that is ok and agrees with itself turned, mirrored, shifted and renumbered; an
error or status that names its cause.  What else happens is printed, and the exit code is 1.  With `--compare`, random
combinations of parts follow, each compared between methods, tolerances, units and more (`comparisons.py`).
"""

import argparse
import math
import sys
import time
import traceback
import warnings
from collections import Counter
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))

import comparisons
from linkages import Linkage, View, built, damaged, drawn

import flexmb as fm

AGREEMENT = 1e-5
"""Difference of positions of two views, relative to the size of the linkage; of smooth motions."""

VIEWS = (View(turn=0.7, shift=complex(0.3, -0.2)), View(mirror=True), View(turn=-2.1, order=5))
STEPS = 400


class Wrong(Exception):
    """A silent wrong answer, or an error that names nothing."""


def tried(seed: int) -> str:
    """How one linkage ends: a word for the table; raises what is wrong."""
    linkage = drawn(seed)
    try:
        mechanism = built(linkage)
    except fm.errors.FlexmbError as error:
        return _named(error, "refused as declared")
    report = fm.check(mechanism)
    for finding in report.findings:
        if not finding.text or "nan" in finding.text.lower():
            raise Wrong(f"empty finding: {finding}")
    span = 0.2 * 2.0 * math.pi / abs(linkage.speed) if linkage.speed else 0.3 * math.sqrt(abs(linkage.points["A"]))
    try:
        sol = fm.simulate(mechanism, t_end=span, save=20)
    except fm.errors.FlexmbError as error:
        if report.ok and "singular" not in str(error):
            raise Wrong(f"check found nothing, simulate refused: {error}") from error
        return _named(error, "refused at the start")
    if not np.isfinite(sol.values).all() and sol.ok:
        raise Wrong("ok with values that are not finite")
    if not sol.ok:
        return _stopped(sol)
    locked = [finding for finding in report.of("locking-drive") if finding.numbers["time"] < 0.99 * span]
    if locked and not any(pin.clearance for pin in linkage.pins) and not any(link.flexible for link in linkage.links):
        raise Wrong(f"ok, though it locks: {locked[0]}")
    if not locked:
        _compare(linkage, span)
    return "ok"


def tried_damaged(seed: int) -> str:
    """How one damaged linkage ends; raises what is no error of flexmb's."""
    try:
        mechanism = damaged(lambda: built(drawn(seed)), seed)
    except fm.errors.FlexmbError as error:
        return _named(error, "damage refused as declared")
    report = fm.check(mechanism)
    try:
        sol = fm.simulate(mechanism, t_end=0.01, save=5, max_steps=2000)
    except fm.errors.FlexmbError as error:
        return _named(error, "damage refused at the start")
    if sol.ok and not np.isfinite(sol.values).all():
        raise Wrong("ok with values that are not finite")
    if sol.ok and not report.ok and not report.of("redundant-joints", "locking-drive"):
        raise Wrong(f"ok, though check found {report.findings[0]}")
    return "damage did no harm" if sol.ok else "damage stopped the run"


def _named(error: Exception, word: str) -> str:
    if "'" not in str(error):
        raise Wrong(f"an error without a name: {error}")
    return word


def _stopped(sol: fm.Solution) -> str:
    if len(sol.status) < 30:
        raise Wrong(f"a status without a cause: {sol.status}")
    return "stopped with a cause"


def _compare(linkage: Linkage, span: float) -> None:
    """Compare smooth motions with those of other views, at fixed steps.

    Views differ by what Newton's method leaves, which free links magnify; with coarse steps one view may stop, with a
    cause.  Where a difference is more than AGREEMENT, it must fall to a half with steps of a quarter.
    """
    if any(pin.clearance for pin in linkage.pins):
        return  # impacts magnify round-off
    flexible = any(link.flexible for link in linkage.links)
    for view in VIEWS:
        error = _difference(linkage, view, span, STEPS)
        if error > (100.0 if flexible else 1.0) * AGREEMENT:
            finer = _difference(linkage, view, span, 4 * STEPS)
            if finer > 0.5 * error:
                raise Wrong(f"{view}: differs by {error:.3g} of the size, with a quarter of the steps by {finer:.3g}")


def _difference(linkage: Linkage, view: View, span: float, steps: int) -> float:
    """Largest difference of the positions of links in a view, relative to the size; infinite if one run is not ok."""
    options = {"t_end": span, "save": 10, "step": span / steps, "max_steps": steps + 10}
    plain, other = fm.simulate(built(linkage), **options), fm.simulate(built(linkage, view), **options)
    if not (plain.ok and other.ok):
        return math.inf if plain.ok or other.ok else 0.0
    size = max(abs(z) for z in linkage.points.values()) + 1e-3
    errors = [0.0]
    for link in linkage.links:
        names = [f"{link.name}.{axis}" for axis in ("x", "y")]
        mine, theirs = (s[names[0]].values + 1j * s[names[1]].values for s in (plain, other))
        seen = np.array([complex(*view.point(z)) for z in mine])
        errors.append(float(np.abs(seen - theirs).max()) / size)
    return max(errors)


def main() -> int:
    """Try linkages, and print a table of their ends."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--compare", type=int, default=0, help="number of combinations of parts that are compared")
    given = parser.parse_args()
    ends, wrong, began = Counter(), [], time.perf_counter()
    for seed in range(given.seed, given.seed + given.count):
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error", RuntimeWarning)
                ends[tried(seed)] += 1
                ends[tried_damaged(seed)] += 1
        except Exception as error:
            wrong.append(seed)
            place = "" if isinstance(error, Wrong) else traceback.format_exc(limit=-3)
            print(f"seed {seed}: {type(error).__name__}: {error}\n{place}", flush=True)
    took = time.perf_counter() - began
    print(f"{given.count} linkages in {took:.0f} s: {dict(ends)}; wrong: {len(wrong)} {wrong[:20]}")
    differing = comparisons.compare(range(given.seed, given.seed + given.compare))
    return 1 if wrong or differing else 0


if __name__ == "__main__":
    sys.exit(main())
