"""Random combinations of parts, each compared with itself: what is saved, mirror, units, tolerance, method.

    python tests/fuzz/comparisons.py --count 100

What is saved must not change a bit, nor what is told.  In the mirror and in other units only round-off differs.  Other
tolerances and methods differ by their errors: a run's falls with rtol^(2/3).  A motion that magnifies differences of
masses magnifies these errors too, so it is measured how much, and few impacts are compared.  A difference is no fault
where a run is not ok or a note tells it.
"""

import argparse
import contextlib
import sys
import time
import traceback
import warnings
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))

from combinations import built
from scene import Units

import flexmb as fm

IMPACTS, LONGEST, SHORTEST = 3, 0.6, 0.02
"""Impacts that are compared, and the bounds of the time [s]."""

ERROR, FINE = 1e-6, 1e-6
"""Relative error of masses by which it is measured how a motion magnifies differences; rtol of fine runs."""

SIZE = 0.3
"""Size of the groups [m], by which differences of positions are measured."""

MAGNIFIED = 1e3
"""Factor above which a motion is not compared between tolerances and methods."""

INSTANTS = 7
"""Saved instants [1]."""

ROUND_OFF = 1e-7
"""Relative differences in other views, before they are magnified."""

FACTOR = 3.0
"""Error of a run over rtol^(2/3)."""

MILLIMETRES = Units(length=1000.0)
TONNES = Units(length=1000.0, mass=1e-3)

TELLS = ("The steps", "loses", "lose", "not resolved", "unresolved", "coarse", "smaller", "finer", "rtol")
"""Words of notes and statuses that tell a difference of tolerances or methods."""


@dataclass(frozen=True)
class Difference:
    """A difference between two runs of one combination: of what, how large it is and may be, whether it was told."""

    kind: str
    text: str
    told: bool


def runs_of(seed: int, units: Units, end: float, **options) -> fm.Solution:
    """A run of a combination."""
    mechanism, _, _ = built(seed, units)
    return fm.simulate(mechanism, t_end=end, save=INSTANTS, **options)


def horizon(sol: fm.Solution) -> float:
    """Time [s] until which few impacts happen."""
    begins = np.unique(sol.contacts.rows[:, _begin(sol)]) if len(sol.contacts.rows) else np.zeros(0)
    begins = begins[begins > 0.0]
    if len(begins) <= IMPACTS:
        return LONGEST
    return float(np.clip(0.5 * (begins[IMPACTS - 1] + begins[IMPACTS]), SHORTEST, LONGEST))


def _begin(sol: fm.Solution) -> int:
    from flexmb.results.contact_intervals import COLUMNS

    return [name for name, *_ in COLUMNS].index("start")


def compared(seed: int) -> tuple[str, list[Difference]]:
    """How a combination ends, and all its differences."""
    mechanism, bodies, words = built(seed)
    found: list[Difference] = []
    first = fm.simulate(mechanism, t_end=LONGEST, save=INSTANTS)
    end = horizon(first)
    plain = fm.simulate(mechanism, t_end=end, save=INSTANTS)
    if not plain.ok:
        return f"stopped: {plain.status[:80]}", found
    found += _saved(mechanism, plain, end, f"{bodies[0].part.name}.x")
    names = [b.part.name for b in bodies]
    motion = _positions(plain, names)
    error = _apart(motion, _positions(runs_of(seed, Units(error=ERROR), end), names))
    magnified = 1.0 + error / ERROR
    for word, units in (("mirror", Units(mirror=True)), ("mm", MILLIMETRES), ("mm and t", TONNES)):
        found += _seen(word, units, plain, runs_of(seed, units, end), names, magnified)
    if magnified > MAGNIFIED:
        return f"magnifies {magnified:.0f} times", found
    found += _methods(seed, plain, end, names)
    return "compared", found


def _saved(mechanism, plain, end, one) -> list[Difference]:
    """Differences by what is saved: none at all."""
    found = []
    ways = {
        "save=[times]": {"save": np.array(plain.time)}, "save=\"steps\"": {"save": "steps"}, "save=100": {"save": 100},
        "signals": {"save": INSTANTS, "signals": [one]},
    }  # fmt: skip
    for word, options in ways.items():
        sol = fm.simulate(mechanism, t_end=end, **options)
        if (sol.ok, sol.status) != (plain.ok, plain.status):
            found.append(Difference("saved", f"{word}: status {sol.status!r}, was {plain.status!r}", False))
        if sol.notes != plain.notes:
            found.append(Difference("saved", f"{word}: notes {sol.notes}, were {plain.notes}", False))
        if _cost(sol) != _cost(plain):
            found.append(Difference("saved", f"{word}: {_cost(sol)}, was {_cost(plain)}", False))
        for name in ("q", "v", "a", "lam", "z", "x", "ledger"):
            value = sol.restart[name]
            if not np.array_equal(np.asarray(value), np.asarray(plain.restart[name]), equal_nan=True):
                found.append(Difference("saved", f"{word}: final {name} differs", False))
        pairs = [(sol.peaks.values, plain.peaks.values), (sol.values[0], plain.values[0])]
        if word == "save=[times]":
            pairs.append((sol.values, plain.values))
        if word == "signals":
            k = [name for name, _ in units_of(plain)].index(one)
            pairs = [(sol[one].values, plain[one].values), (sol.peaks.values, plain.peaks.values[k : k + 1])]
        for mine, theirs in pairs:
            if not np.array_equal(mine, theirs, equal_nan=True):
                far = np.argmax(np.abs(mine - theirs).max(axis=0) if mine.ndim > 1 else np.abs(mine - theirs))
                name = one if word == "signals" else units_of(plain)[int(far)][0]
                found.append(Difference("saved", f"{word}: rows or peaks differ, of {name}", False))
    return found


def _cost(sol: fm.Solution) -> tuple[int, int, int]:
    return sol.stats.steps, sol.stats.rejected, sol.stats.newton_iterations


def _positions(sol: fm.Solution, names: list[str], units: Units = Units()) -> np.ndarray:
    """Positions and angles [m, rad m] of bodies, before the view."""
    sign = -1.0 if units.mirror else 1.0
    rows = [
        (sign / units.length * sol[f"{n}.x"].values, sol[f"{n}.y"].values / units.length,
         sign * SIZE * (sol[f"{n}.theta"].values - sol[f"{n}.theta"].values[0])) for n in names
    ]  # fmt: skip
    return np.array(rows)


def units_of(sol: fm.Solution) -> list[tuple[str, str]]:
    """Names and units of the signals."""
    return [(one.name, one.units) for one in sol.signals]


def _apart(one: np.ndarray, two: np.ndarray) -> float:
    """Largest difference of positions relative to the size."""
    return float(np.abs(one - two).max()) / SIZE


def factor_of(unit: str, units: Units) -> float:
    """Factor of a number with a unit of SI in other units of length and mass."""
    dimensions = {"N": (1, 1), "J": (1, 2), "W": (1, 2), "Pa": (1, -1), "kg": (1, 0), "m": (0, 1)}
    mass = length = 0
    side = 1
    for word in unit.replace("/", " / ").split():
        if word == "/":
            side = -1
            continue
        base, _, power = word.partition("^")
        m, l = dimensions.get(base.rstrip("23"), (0, 0)) if base not in dimensions else dimensions[base]
        power = float(power) if power else float(base[-1]) if base[-1:] in "23" else 1.0
        mass, length = mass + side * power * m, length + side * power * l
    return units.mass**mass * units.length**length


def _seen(word, units, plain, sol, names, magnified) -> list[Difference]:
    """Differences in another view: round-off, magnified."""
    found = []
    if sol.ok != plain.ok:
        return [Difference(word, f"ok {plain.ok}, {sol.ok}: {sol.status}", False)]
    same = sol.stats.steps == plain.stats.steps and sol.stats.rejected == plain.stats.rejected
    apart = _apart(_positions(plain, names), _positions(sol, names, units))
    bound = ROUND_OFF * magnified * 10.0 if same else FACTOR * 1e-4 ** (2 / 3) * magnified
    cost = f"steps {plain.stats.steps}+{plain.stats.rejected}, {sol.stats.steps}+{sol.stats.rejected}"
    if not apart <= bound:
        found.append(Difference(word, f"positions {apart:.2g} > {bound:.2g}, {cost}, magnified {magnified:.3g}", False))
    if len(sol.notes) != len(plain.notes):
        found.append(Difference(word, f"notes {sol.notes}, were {plain.notes}; {cost}", False))
    if same:
        found += _signals(word, units, plain, sol, bound)
    elif abs(sol.stats.steps - plain.stats.steps) > 3 + 0.02 * plain.stats.steps:
        found.append(Difference(word, cost, True))  # the results agree; only the work differs
    return found


def comparable(name: str, unit: str) -> bool:
    """Whether a signal is the same in other views.

    Not so: modes, free in sign and scale; outputs without units; places on curves, which count along them; nodes of
    meshes, which the mirror exchanges; accelerations of bodies that deform, which round-off shakes.
    """
    bends = name.startswith(("flexible", "reduced", "plane"))
    inner = name.startswith("plane") and ".node" in name
    return not (".modes" in name or not unit or name.endswith(".place") or inner or (bends and unit.endswith("s2")))


def mirrored(name: str) -> str:
    """Name of a signal in the mirror: limits of angles, not of travel, and flanks of teeth change places."""
    if name.startswith("bump"):
        return name
    for one, two in ((".above", ".below"), (".forward", ".backward")):
        if one in name:
            return name.replace(one, two)
        if two in name:
            return name.replace(two, one)
    return name


def _signals(word, units, plain, sol, bound) -> list[Difference]:
    """Signals that differ, up to a sign in the mirror, by more than round-off of the largest signal of its unit."""
    found = []
    largest: dict[str, float] = {}
    for name, unit in units_of(plain):
        largest[unit] = max(largest.get(unit, 0.0), float(np.abs(plain[name].values).max()))
    for name, unit in units_of(plain):
        if not comparable(name, unit):
            continue
        other = mirrored(name) if units.mirror else name
        mine, theirs = plain[name].values, sol[other].values / factor_of(unit, units)
        if unit == "rad":
            mine, theirs = mine - mine[0], theirs - theirs[0]  # of links: between chord and x axis
        gaps = [np.abs(mine - theirs).max()] + ([np.abs(mine + theirs).max()] if units.mirror else [])
        if not min(gaps) <= max(1e3 * bound, 1e-5) * largest[unit] + 1e-9:
            found.append(Difference(word, f"{name} [{unit}] {mine.tolist()} became {theirs.tolist()}", False))
    return found[:4]


def _methods(seed, plain, end, names) -> list[Difference]:
    """Differences between tolerances and methods."""
    found, runs = [], {}
    runs["default"] = plain
    runs["rtol=1e-6"] = fine = runs_of(seed, Units(), end, step=fm.Adaptive(rtol=FINE))
    runs["RadauIIA"] = runs_of(seed, Units(), end, method=fm.RadauIIA())
    runs["RadauIIA 1e-6"] = runs_of(seed, Units(), end, method=fm.RadauIIA(), step=fm.Adaptive(rtol=FINE))
    with contextlib.suppress(fm.errors.FlexmbError):
        runs["RungeKutta4"] = runs_of(seed, Units(), end, method=fm.RungeKutta4(), step=max(end / 20000.0, 2e-6))
    disturbed = runs_of(seed, Units(error=ERROR), end, step=fm.Adaptive(rtol=FINE))
    magnified = 1.0 + _apart(_positions(fine, names), _positions(disturbed, names)) / ERROR
    good = "RadauIIA 1e-6" if runs["RadauIIA 1e-6"].ok else "rtol=1e-6"
    for word, sol in runs.items():
        if not sol.ok:
            found.append(Difference("method", f"{word} stopped: {sol.status}", True))
            continue
        rtol = 1e-4 if word in ("default", "RadauIIA", "RungeKutta4") else FINE
        bound = FACTOR * rtol ** (2 / 3) * min(magnified, MAGNIFIED)
        apart = _apart(_positions(runs[good], names), _positions(sol, names))
        if not apart <= bound and runs[good].ok:
            told = [note for note in (*sol.notes, sol.status) if any(tell in note for tell in TELLS)]
            text = (
                f"{word} is {apart:.2g} > {bound:.2g} from {good}, magnified {magnified:.3g}; {sol.stats.steps} steps"
            )
            found.append(Difference("method", f"{text}; notes {told or sol.notes}", bool(told)))
    return found


def compare(seeds: range) -> list[int]:
    """Compare combinations, print their ends and differences; return those with a difference that was not told."""
    ends, wrong, began = Counter(), [], time.perf_counter()
    for seed in seeds:
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                end, found = compared(seed)
        except Exception as error:
            place = "" if isinstance(error, fm.errors.FlexmbError) else traceback.format_exc(limit=-3)
            end, found = "raised", [Difference("raised", f"{type(error).__name__}: {error} {place}", False)]
        words = f" ({' '.join(built(seed)[2])})" if end != "raised" else ""
        ends[end.split()[0]] += 1
        untold = [one for one in found if not one.told]
        if untold:
            wrong.append(seed)
            print(f"combination {seed}{words}: {end}", flush=True)
            print(*(f"    {one.kind}: {one.text[:900]}" for one in untold), sep="\n", flush=True)
        elif found:
            ends["told"] += 1
    took = time.perf_counter() - began
    if seeds:
        print(
            f"{len(seeds)} combinations in {took:.0f} s: {dict(ends)}; differences not told: {len(wrong)} {wrong[:20]}"
        )
    return wrong


def main() -> int:
    """Compare combinations, and print a table of their ends."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    return 1 if compare(range(given.seed, given.seed + given.count)) else 0


if __name__ == "__main__":
    sys.exit(main())
