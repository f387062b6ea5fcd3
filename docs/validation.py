"""Compute docs/validation.md anew: every problem of tests/literature beside its references.

    python docs/validation.py [--only elastica roll_up ...] [--fast] [--out docs]

A problem is a file tests/literature/test_NAME.py with a `PROBLEM` (see record.py there); the tests run the same cases.
With --only, the other problems keep what the page says of them.  --fast leaves slow cases and figures out, and says so.
The exit code is 1, with a list on stderr, when an error leaves its band, a convergence is slower than its order, or a
problem could not be computed; the page is written all the same.
"""

import argparse
import importlib
import sys
import time
import traceback
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numba.core.event as numba_events
import pytest

ROOT = Path(__file__).resolve().parents[1]
LITERATURE = ROOT / "tests" / "literature"
sys.path[:0] = [str(Path(__file__).resolve().parent), str(LITERATURE), str(ROOT / "tests"), str(ROOT / "examples")]

import validation_page as page  # noqa: E402
from record import Case, Curve, Figure, Problem, Value  # noqa: E402

import flexmb as fm  # noqa: E402


@dataclass
class CaseResult:
    """What a case gave: its values and the wall time [s], or why there are none."""

    title: str
    values: list[Value] = field(default_factory=list)
    wall: float = 0.0
    failure: str = ""


@dataclass
class FigureResult:
    """A figure that was drawn: its file, its curves, or why there is none."""

    figure: Figure
    file: str = ""
    curves: list[Curve] = field(default_factory=list)
    wall: float = 0.0
    failure: str = ""


@dataclass
class ProblemResult:
    """A problem with all that was found; `left_out` counts the slow cases and figures of a fast run."""

    name: str
    problem: Problem | None = None
    cases: list[CaseResult] = field(default_factory=list)
    figures: list[FigureResult] = field(default_factory=list)
    left_out: int = 0
    failure: str = ""

    @property
    def values(self) -> list[Value]:
        """Values of all cases."""
        return [v for case in self.cases for v in case.values]

    @property
    def wall(self) -> float:
        """Wall time of all cases and figures [s]."""
        return sum(part.wall for part in (*self.cases, *self.figures))


def names() -> list[str]:
    """Problems that there are, by the names of their files."""
    return sorted(file.stem.removeprefix("test_") for file in LITERATURE.glob("test_*.py"))


def computed(name: str, *, fast: bool, pictures: Path) -> ProblemResult:
    """One problem: all of its cases and figures."""
    result = ProblemResult(name)
    try:
        problem = importlib.import_module(f"test_{name}").PROBLEM
    except Exception as error:  # any fault of one file must leave the other problems their results
        return ProblemResult(name, failure=told(error))
    return of_problem(result, problem, fast=fast, pictures=pictures)


def of_problem(result: ProblemResult, problem: Problem, *, fast: bool, pictures: Path) -> ProblemResult:
    """Fill in the cases and figures of a problem that could be read."""
    result.problem = problem
    cases, figures = wanted(problem.cases, fast), wanted(problem.figures, fast)
    result.left_out = len(problem.cases) + len(problem.figures) - len(cases) - len(figures)
    result.cases = [of_case(case) for case in cases]
    result.figures = [of_figure(figure, pictures) for figure in figures]
    if not problem.cases:
        result.failure = "no case: nothing is checked"
    return result


def wanted(parts: Sequence[Any], fast: bool) -> list[Any]:
    """What is to be computed."""
    return [part for part in parts if not (fast and part.slow)]


def of_case(case: Case) -> CaseResult:
    """The values of a case, with the time of a run that compiled nothing."""
    values, wall, failure = timed(case.compute)
    if not values and not failure:
        failure = "no values: the case checks nothing"
    return CaseResult(case.title, values, wall, failure)


def of_figure(figure: Figure, pictures: Path) -> FigureResult:
    """The drawn figure, its curves measured."""
    file = f"validation_{figure.name}.png"
    if figure.curves is None:
        _, wall, failure = timed(lambda: page.draw_picture(figure, pictures / file) or ())
        return FigureResult(figure, "" if failure else file, wall=wall, failure=failure)
    curves, wall, failure = timed(figure.curves)
    if not failure and not curves:
        failure = "no curves: the figure shows nothing"
    if not failure:
        page.draw_curves(figure, curves, pictures / file)
    return FigureResult(figure, "" if failure else file, curves, wall, failure)


def timed(compute: Callable[[], Iterable[Any]]) -> tuple[list[Any], float, str]:
    """What `compute` gives, the wall time [s], and why it failed, if it did.

    numba compiles what it does not find in its cache.  A run in which it did is repeated, so that the time is that of
    the computation.
    """
    try:
        with numba_events.install_recorder("numba:run_pass") as compilations:
            found, wall = once(compute)
        if compilations.buffer:
            found, wall = once(compute)
    except (Exception, pytest.skip.Exception) as error:  # what one case raises must not lose the others
        return [], 0.0, told(error)
    return found, wall, ""


def once(compute: Callable[[], Iterable[Any]]) -> tuple[list[Any], float]:
    """What `compute` gives and the wall time [s]."""
    began = time.perf_counter()
    return list(compute()), time.perf_counter() - began


def told(error: BaseException) -> str:
    """One line about an exception, with the place in our files where it came from."""
    places = [f for f in traceback.extract_tb(error.__traceback__) if Path(f.filename).is_relative_to(ROOT / "tests")]
    where = f" ({Path(places[-1].filename).name}:{places[-1].lineno})" if places else ""
    return f"{type(error).__name__}: {' '.join(str(error).split())}{where}"


def complaints(result: ProblemResult) -> list[str]:
    """What is wrong, a line each."""
    found = [f"{result.name}: {result.failure}"] if result.failure else []
    for case in result.cases:
        where = f"{result.name}, {case.title}"
        found += [f"{where}: {case.failure}"] if case.failure else []
        found += [f"{where}: {v.quantity}: {page.verdict(v)}" for v in case.values if not v.holds]
    for figure in result.figures:
        where = f"{result.name}, figure {figure.figure.name}"
        found += [f"{where}: {figure.failure}"] if figure.failure else []
        found += [
            f"{where}: {c.label}: slope {c.slope:.2f}, wanted {c.order:g} - {c.slack:g}"
            for c in figure.curves
            if not page.steep_enough(c)
        ]
    return found


def warm_up() -> None:
    """Load or compile the time loop and statics, so that the first problem does not pay for them."""
    beam = fm.FlexibleLink(
        "beam", (0.0, 0.0), (1.0, 0.0), section=fm.Circle(0.01), material=fm.Material(2e11, 7850.0), elements=1
    )
    mech = fm.Mechanism("warm-up", (beam, fm.Fixed("clamp", fm.GROUND, beam, (0.0, 0.0))), gravity=(0.0, -9.81))
    fm.static_equilibrium(mech)
    fm.simulate(mech, t_end=1e-4, step=1e-5)
    fm.simulate(mech, t_end=1e-4, step=fm.Adaptive(max=1e-5))


def main(arguments: Sequence[str] | None = None) -> int:
    """Compute, write, and say what is wrong."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", nargs="+", choices=names(), metavar="NAME", help=f"of {', '.join(names())}")
    parser.add_argument("--fast", action="store_true", help="without what is slow")
    parser.add_argument("--out", type=Path, default=ROOT / "docs", help="folder of validation.md and pictures (docs)")
    options = parser.parse_args(arguments)
    pictures = options.out / "pictures"
    pictures.mkdir(parents=True, exist_ok=True)
    warm_up()
    results = []
    for name in options.only or names():
        results.append(computed(name, fast=options.fast, pictures=pictures))
        print(f"{name}: {page.worst(results[-1])}, {results[-1].wall:.1f} s", flush=True)
    page.write(options.out / "validation.md", results, keep_others=options.only is not None)
    wrong = [text for result in results for text in complaints(result)]
    print("\n".join(wrong), file=sys.stderr, end="\n" if wrong else "")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
