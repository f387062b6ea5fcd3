"""Lyapunov exponents from tangent vectors, or from two trajectories; a second run beside them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from flexmb import arguments, checks
from flexmb.dynamics.exponents.exponents import Confirmed, Exponents, combined
from flexmb.dynamics.exponents.renormalisation import TOO_MUCH, Schedule, Span, exponents_of, tangent_exponents
from flexmb.dynamics.systems.dynamics import Dynamics
from flexmb.errors import AssemblyError, InputError, SolveError

if TYPE_CHECKING:
    from flexmb.engine.newmark.method import Newmark
    from flexmb.run.simulate import Step

# A second, shorter run with finer steps from another start, and the errors of exponents that it adds

PART = 5  # points of the first run per point of the second run, for counted and for skipped points
# Points of the first run per skipped point of the second run, at most; finer steps may change the attractor.
SETTLES = 10
LEAST = 20  # smallest number of points of the second run
# Distances of the second run's start, over the length of the state; the second one is tried if the first one fails.
SECOND_RUN_APART = (1e-3, 1e-9)


def confirmed(first: Exponents, schedule: Schedule, seed: int, *, shown: bool) -> Exponents:
    """Exponents of a first run, completed by a second run; the errors cover the difference of both runs."""
    # The second run uses a copy of the system. Its start is near the final state of the first run, after the transient.
    # If a contact was closed during the whole first run, the second run starts at the start state of the system and
    # skips the whole transient. Otherwise both runs would have the approach speed of the same onset.
    reason, skip, settles = "", schedule.skip, schedule.count // SETTLES
    lasting = bool(schedule.system.remarks(float(first.time[0])))
    for distance in (0.0,) if lasting else SECOND_RUN_APART:
        system = schedule.system.finer()
        if lasting:
            system.reset(time=schedule.origin)
        else:
            try:
                system.reset(system.another_start(distance, seed), time=schedule.system.time)
            except (InputError, AssemblyError, SolveError):
                continue
        skipped, count = max(skip if lasting else -(-skip // PART), settles), max(schedule.count // PART, LEAST)
        other = replace(schedule, system=system, skip=skipped, count=count, trouble="")
        run = tangent_exponents(other, len(first.spectrum), seed, shown=shown)
        if run.ok and not np.isnan(run.spectrum).any():
            second = Confirmed(run.spectrum, run.errors, other.count, other.system.fineness)
            errors = combined(first.spectrum, first.statistical, second.spectrum, second.errors)
            return replace(first, errors=errors, confirmed=second)
        reason = run.status
    reason = reason or "no state beside the end of the first run can be started from."
    return replace(first, unconfirmed=reason, status=f"{first.status} The second run failed: {reason}")


@arguments.checked
def lyapunov(
    system: Any,
    *,
    skip: float = 0,
    periods: int | None = None,
    duration: float | None = None,
    count: int = 1,
    interval: float | None = None,
    period: float | None = None,
    step: Step | None = None,
    method: Newmark | None = None,
    seed: int = 0,
    confirm: bool = True,
    progress: bool = False,
) -> Exponents:
    """Lyapunov exponents of a system, from tangent vectors that are advanced with the motion.

    The vectors are made orthonormal once a period, and more often if they grow by more than 1e4.  The exponents are the
    means of the logarithms of their lengths (G. Benettin et al., Meccanica 15 (1980) 9).  The first tenth of the run is
    not counted: the vectors turn to their directions.

    Parameters
    ----------
    system : a mechanism, which starts from its reference configuration; or a flow or map, which continues from its
        present state.
    skip : number of periods (iterations, crossings) before the run, for the transient; with `duration` seconds.
    periods : number of periods of a driven system, of iterations of a map, or of crossings of a section.
    duration : duration [s], for a flow without a period, in place of `periods`.  One of its exponents is 0.
    count : number of exponents, the largest first.
    interval : with `duration`, time between two points of the history [s]; None: a thousandth of the duration.
    period : the period [s]; None: the common period of the drives.
    step, method : for a mechanism only, see `simulate`.
    seed : seed of the random directions in which the vectors start.
    confirm : whether a second run confirms the first one.  It has a fifth of the periods (20 at least), a tenth of the
        tolerance or half of a fixed step, and another start: beside the final state of the first run or, if a contact
        never opened, the mechanism's own start and the whole of `skip`.  Its difference goes into the errors, and the
        verdict is "chaotic" only if both runs agree.  False: errors and verdict of one run.
    progress : whether a progress bar with the remaining time is shown.

    Returns
    -------
    Exponents : in 1/s for flows and their sections, in 1/iteration for maps; with errors, convergence history, section
        points and verdict.  After a failure midway ok is False, and the record holds the results before the failure.

    Raises
    ------
    InputError : too few periods or intervals; neither or both of periods and duration; a duration of a map; more
        exponents than the system has directions.
    ModelError, AssemblyError, KernelError : a mechanism that cannot start.

    Notes
    -----
    The exponent belongs to the numerical motion.  The method damps vibrations that the steps do not resolve, so a
    negative exponent may be numerical dissipation, as in slow mechanisms with clearance: repeat the run with shorter
    steps, `step=Adaptive(max=...)`, or without dissipation, `method=Newmark.trapezoidal()`.  Hard impacts need a finer
    tolerance than the motion itself; the second run shows whether, and `step=Adaptive(rtol=...)` sets it.

    The system stays at the end of the first run.

    Examples
    --------
    >>> import flexmb as fm
    >>> import numpy as np
    >>> tent = fm.chaos.Map(lambda x, a: a * np.minimum(x, 1.0 - x), [0.3], parameters={"a": 1.5})
    >>> found = fm.lyapunov(tent, skip=100, periods=1000)
    >>> round(found.value, 9)  # ln 1.5
    0.405465108
    """
    span = Span("lyapunov", skip, periods, duration, interval, period)
    schedule = span.schedule(system, step, method)
    label = f"lyapunov {schedule.system.name!r}"
    seed, count = checks.count(label, "seed", seed, 0), checks.count(label, "count", count)
    exponents = tangent_exponents(schedule, count, seed, shown=progress)
    if confirm and exponents.ok:
        exponents = confirmed(exponents, schedule, seed + 1, shown=progress)
    return span.finished(exponents, schedule)


def benettin(
    system: Any,
    *,
    skip: float = 0,
    periods: int | None = None,
    duration: float | None = None,
    distance: float | None = None,
    interval: float | None = None,
    period: float | None = None,
    step: Step | None = None,
    method: Newmark | None = None,
    seed: int = 0,
    progress: bool = False,
) -> Exponents:
    """The largest Lyapunov exponent from two neighbouring trajectories; no tangent of the system is needed.

    Once a period the distance of the second trajectory from the first one is restored, along the line between them
    (G. Benettin, L. Galgani, J.-M. Strelcyn, Phys. Rev. A 14 (1976) 2338).  A mechanism is then projected onto its
    constraints, and both trajectories restart so that they take equal steps.

    Parameters
    ----------
    system : a mechanism, which starts from its reference configuration; or a flow or map, which continues from its
        present state.
    skip, periods, duration, interval, period, step, method, seed, progress : see `lyapunov`.
    distance : distance of the trajectories in the weights of the system (for a mechanism [m]); None: 1e-6 of the length
        of the state, 1e-9 for a mechanism with contacts.

    Raises
    ------
    InputError : see `lyapunov`; a distance that is not > 0.
    ModelError, AssemblyError, KernelError : a mechanism that cannot start.

    Notes
    -----
    The distance must be far above the errors of the steps in one period, and small enough for linear growth.  The range
    between is narrow for error-controlled steps of a mechanism, so `FixedStep` is the better choice.  In contact the
    distance must be far below the penetration: with 2.6e-7 m the worn slider-crank at 5000 rpm gives 356 1/s, with
    1e-9 m and 1e-11 m 464 1/s, as `lyapunov` does (467 +/- 20).

    Examples
    --------
    >>> import flexmb as fm
    >>> import numpy as np
    >>> tent = fm.chaos.Map(lambda x, a: a * np.minimum(x, 1.0 - x), [0.3], parameters={"a": 1.5})
    >>> found = fm.chaos.benettin(tent, skip=100, periods=1000)
    >>> round(found.value, 3)  # ln 1.5
    0.405
    """
    span = Span("benettin", skip, periods, duration, interval, period)
    schedule = span.schedule(system, step, method)
    first = schedule.system
    seed = checks.count(f"benettin {first.name!r}", "seed", seed, 0)
    exponents = exponents_of(schedule, lambda: TrajectoryPair.beside(first, distance, seed), 1, shown=progress)
    return span.finished(exponents, schedule)


@dataclass
class TrajectoryPair:
    """Two trajectories at a small distance."""

    first: Dynamics  # the systems
    second: Dynamics
    weights: np.ndarray  # weights (size,) of the squares of differences
    distance: float  # distance that a renormalisation restores
    size: float = 0.0  # distance after the last renormalisation

    strained_fraction = 0.0

    @classmethod
    def beside(cls, first: Dynamics, distance: float | None, seed: int) -> TrajectoryPair:
        """`first` and a copy at a distance in a random direction, see `benettin`."""
        weights, x = first.weights, first.state()
        usual = first.small * (float(np.sqrt(weights @ x**2)) or 1.0)
        wanted = usual if distance is None else checks.positive(f"benettin {first.name!r}", "distance", distance)
        pair = cls(first, first.copy(), weights, wanted)
        pair.renormalise(first.tangent_basis(1, seed)[:, 0])
        return pair

    def length(self, difference: np.ndarray) -> float:
        """Length of a `difference` (size,) in the weights."""
        return float(np.sqrt(self.weights @ difference**2))

    def renormalise(self, direction: np.ndarray) -> None:
        """Restart both systems, the second at `distance` in a `direction` (size,) of any length."""
        x, time = self.first.state(), self.first.time
        if self.first.underlying is self.first:
            self.first.reset(x, time=time)
        self.second.reset(x + self.distance / self.length(direction) * direction, time=time)
        self.size = self.length(self.second.state() - self.first.state())

    def is_strained(self, logs: np.ndarray) -> bool:
        """Whether the distance grew by more than `TOO_MUCH` (`logs`: logarithm (1,) of the growth)."""
        return bool(logs[0] > np.log(TOO_MUCH))

    def growth(self, schedule: Schedule, number: int, begin: float, end: float) -> np.ndarray | None:  # noqa: ARG002
        """Logarithm (1,) of the growth of the distance; None if a system fails or the trajectories meet."""
        reached = [schedule.advance(system, number, end) for system in (self.first, self.second)]
        if not all(reached):
            schedule.trouble = (self.first if not reached[0] else self.second).status
            return None
        difference = self.second.state() - self.first.state()
        difference[schedule.records] = 0.0  # bookkeeping would grow without bound if the distance shrinks
        length = self.length(difference)
        if length == 0.0 or self.size == 0.0:
            schedule.trouble = f"The two trajectories met at {self.first.clock:.6g}; give a larger distance."
            return None
        growth = length / self.size
        self.renormalise(difference)
        return np.array([np.log(growth)])
