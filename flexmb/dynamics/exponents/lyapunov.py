"""Lyapunov exponents from tangent vectors, and from two trajectories side by side."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from flexmb import checks
from flexmb.dynamics.exponents.confirm import confirmed
from flexmb.dynamics.exponents.exponent_error import outgrown
from flexmb.dynamics.exponents.exponents import SETTLING, Exponents, Growth, check_enough
from flexmb.dynamics.exponents.schedule import MOST_LOOKS, TOO_MUCH, Schedule
from flexmb.dynamics.exponents.tangent_run import carried, counting, recorded
from flexmb.dynamics.sections.stroboscopic import StroboscopicMap
from flexmb.dynamics.systems.as_dynamics import clock, dynamics_of
from flexmb.dynamics.systems.continuous_flow import ContinuousFlow
from flexmb.dynamics.systems.dynamics import Dynamics
from flexmb.dynamics.systems.mechanism_flow import MechanismFlow
from flexmb.errors import InputError
from flexmb.jobs.progress import ProgressBar
from flexmb.model.mechanism import Mechanism
from flexmb.run.simulate import Step
from flexmb.step.newmark.method import Newmark

APART, APART_IN_CONTACT = 1e-6, 1e-9
"""Usual distance of two trajectories, as a part of the state; surfaces that touch are not linear beyond some 1e-8 m."""
INTERVALS = 1000
"""Points of a flow without period, if no interval is given."""
ERRORS = ("errors", "statistical")
"""Fields of a record that hold errors."""


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
    """Lyapunov exponents of a system, from tangent vectors that are carried along the motion.

    The vectors are made orthonormal once a period, or more often where they grow by more than 1e4; the means of the
    logarithms of their lengths are the exponents (G. Benettin et al., Meccanica 15 (1980) 9).  The first tenth lets the
    vectors turn to their directions and is not counted.

    Parameters
    ----------
    system : a mechanism, which starts from its drawn pose, or a flow or map, which goes on from where it stands.
    skip : periods (iterations, crossings) before that, for the transient; with `duration` seconds.
    periods : number of periods of a driven system, of iterations of a map, of crossings of a section; or
    duration : time [s], for a flow without period.  One of its exponents is then 0.
    count : number of exponents, from the largest one on.
    interval : with `duration`, time between two points of the history [s]; None: a thousandth of the duration.
    period : the period [s]; None: the common period of the drives.
    step, method : of a mechanism, see `simulate`.
    seed : of the random directions in which the vectors start.
    confirm : follow up with a second run of a fifth of the periods (20 at least): with a tenth of the tolerance, or
        half of a fixed step, and from another start: beside the state in which the first run ended, or, where a contact
        never opened, the mechanism's own and after the whole of `skip`.  What it changes goes into the errors, and
        "chaotic" is said only if both runs say so.  False: one run, its errors and verdict.
    progress : show a progress bar with an estimate of the time left.

    Returns
    -------
    Exponents : in 1/s for flows and their sections, in 1/iteration for maps; with errors (of the record, and of what
        the second run changes), the convergence history, the points on the way and the verdict they lead to.  A run
        that fails midway is not ok and holds what was found until then.

    Raises
    ------
    InputError : too few periods or intervals; neither or both of periods and duration; a duration of a map; more
        exponents than the system has directions.
    ModelError, AssemblyError, KernelError : a mechanism that cannot start.

    Notes
    -----
    The exponent is that of the steps.  Vibrations that they do not resolve are damped by the method, so that a negative
    exponent may be its dissipation, as in mechanisms with play that turn slowly: repeat it with shorter steps,
    `step=Adaptive(max=...)`, or without dissipation, `method=Newmark.trapezoidal()`.  Hard impacts want a finer
    tolerance than the motion itself: the second run tells, and `step=Adaptive(rtol=...)` mends it.

    The system is left where the first run ended.

    Examples
    --------
    >>> import flexmb as fm
    >>> tent = fm.Map(lambda x, a: a * np.minimum(x, 1.0 - x), [0.3], parameters={"a": 1.5})
    >>> found = fm.lyapunov(tent, skip=100, periods=1000)
    >>> round(found.value, 9)  # ln 1.5
    0.405465108
    """
    found = dynamics_of("lyapunov", system, period=period, step=step, method=method)
    _refuse_idle("lyapunov", system, found, duration, interval, period)
    plan = _schedule("lyapunov", found, skip, periods, duration, interval, period)
    seed = checks.count(f"lyapunov {found.name!r}", "seed", seed, 0)
    count = checks.count(f"lyapunov {found.name!r}", "count", count)
    first = carried(plan, count, seed, shown=progress)
    if confirm and first.ok:
        first = confirmed(first, plan, seed + 1, shown=progress)
    return _judged(plan, first)


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
    """The largest Lyapunov exponent from two trajectories side by side; it asks nothing of the system but to go on.

    Once a period the second one is put back to its distance from the first, along the line between them
    (G. Benettin, L. Galgani, J.-M. Strelcyn, Phys. Rev. A 14 (1976) 2338).  A mechanism is projected onto its joints
    then, and both trajectories begin anew so that they take alike steps.

    Parameters
    ----------
    system : a mechanism, which starts from its drawn pose, or a flow or map, which goes on from where it stands.
    skip, periods, duration, interval, period, step, method, seed, progress : see `lyapunov`.
    distance : distance of the two in the weights of the system (of a mechanism: metres); None: 1e-6 of the length of
        its state, of a mechanism with contacts 1e-9.

    Returns
    -------
    Exponents : as of `lyapunov`, with one exponent.

    Raises
    ------
    InputError : as of `lyapunov`; a distance that is not > 0.
    ModelError, AssemblyError, KernelError : a mechanism that cannot start.

    Notes
    -----
    The distance must be far above what one period's steps miss and far below what is no longer small: with
    error-controlled steps of a mechanism that is a narrow strait, and `FixedStep` is the better choice.  Where surfaces
    touch what is small ends far below their depth: with 2.6e-7 m the worn slider-crank at 5000 rpm gives 356 1/s, with
    1e-9 m and 1e-11 m 464 1/s, as `lyapunov` does (467 +/- 20).

    Examples
    --------
    >>> import flexmb as fm
    >>> tent = fm.Map(lambda x, a: a * np.minimum(x, 1.0 - x), [0.3], parameters={"a": 1.5})
    >>> found = fm.benettin(tent, skip=100, periods=1000)
    >>> round(found.value, 3)  # ln 1.5
    0.405
    """
    first = dynamics_of("benettin", system, period=period, step=step, method=method)
    _refuse_idle("benettin", system, first, duration, interval, period)
    plan = _schedule("benettin", first, skip, periods, duration, interval, period)
    seed = checks.count(f"benettin {first.name!r}", "seed", seed, 0)
    first, growth, points = plan.system, Growth(), [np.zeros((0, len(first.names)))]
    shown = ProgressBar(first.name, float(plan.skip + plan.count), shown=progress, of="periods")
    while plan.skip and first.ok and shown.n < plan.skip:
        plan.go(first, int(shown.n) + 1)
        shown.update(1)
    if not first.ok:
        return recorded(plan, growth, clock(first), 1, points[0])
    pair = Pair.beside(first, distance, seed)
    began = clock(first)
    for number in range(plan.skip + 1, plan.skip + plan.count + 1):
        began, before = counting(plan, number, began), clock(first)
        logs = pair.one_period(plan, number)
        if logs is None:
            break
        shown.update(1)
        points.append(first.observe()[None])
        if number > plan.skip + plan.count // SETTLING:
            growth.logs.append(np.array([logs]))
            growth.times.append(clock(first) - before)
    shown.close()
    return _judged(plan, recorded(plan, growth, began, 1, np.concatenate(points)))


@dataclass
class Pair:
    """Two trajectories side by side.

    Parameters
    ----------
    first, second : the systems.
    weights : (size,) of squares of differences.
    distance : wanted distance.
    size : present distance.
    """

    first: Dynamics
    second: Dynamics
    weights: np.ndarray
    distance: float
    size: float = 0.0

    @classmethod
    def beside(cls, first: Dynamics, distance: float | None, seed: int) -> Pair:
        """A copy of `first`, moved by `distance` in a random direction; see `benettin` for the arguments."""
        weights, x = first.weights, first.state()
        part = APART_IN_CONTACT if isinstance(first, MechanismFlow) and first.program.normals else APART
        usual = part * (float(np.sqrt(weights @ x**2)) or 1.0)
        wanted = usual if distance is None else checks.positive(f"benettin {first.name!r}", "distance", distance)
        pair = cls(first, first.copy(), weights, wanted)
        pair.put(first.tangent_basis(1, seed)[:, 0])
        return pair

    def apart(self) -> np.ndarray:
        """Difference (size,) of the states."""
        return self.second.state() - self.first.state()

    def length(self, difference: np.ndarray) -> float:
        """Length of a difference in the weights."""
        return float(np.sqrt(self.weights @ difference**2))

    def put(self, direction: np.ndarray) -> None:
        """Begin anew, the second at the wanted distance in a direction (size,) of any length."""
        x, time = self.first.state(), self.first.time
        if isinstance(self.first, ContinuousFlow):
            self.first.reset(x, time=time)
        self.second.reset(x + self.distance / self.length(direction) * direction, time=time)
        self.size = self.length(self.apart())

    def one_period(self, plan: Schedule, number: int) -> float | None:
        """Logarithm of the growth of the distance up to the next point; None if one of them could not go on."""
        total, looks = 0.0, plan.looks
        for look in range(1, looks + 1):
            ends = [plan.go(system, number, look / looks) for system in (self.first, self.second)]
            if not all(ends):
                plan.trouble = (self.first if not ends[0] else self.second).status
                return None
            difference = self.apart()
            length = self.length(difference)
            if length == 0.0 or self.size == 0.0:
                plan.trouble = f"The two trajectories met at {clock(self.first):.6g}; give a larger distance."
                return None
            total += np.log(length / self.size)
            if plan.is_flow and looks == plan.looks and length > TOO_MUCH * self.size:
                plan.looks = min(2 * plan.looks, MOST_LOOKS)
            self.put(difference)
        return total


def _schedule(
    caller: str,
    system: Dynamics,
    skip: float,
    periods: int | None,
    duration: float | None,
    interval: float | None,
    period: float | None,
) -> Schedule:
    """Which points are wanted of which system."""
    label = f"{caller} {system.name!r}"
    if (periods is None) == (duration is None):
        text = f"{label}: periods is {periods!r} and duration is {duration!r}"
        raise InputError(
            f"{text}; give either periods= (of a map iterations, of a section crossings) or duration= [s]."
        )
    is_flow = isinstance(system, (ContinuousFlow, StroboscopicMap))
    if duration is not None:
        if not isinstance(system, ContinuousFlow):
            raise InputError(f"{label}: a duration is given, but it is a map. Give periods=.")
        end = checks.positive(label, "duration", duration, "s")
        unit = end / INTERVALS if interval is None else checks.positive(label, "interval", interval, "s")
        points = round(end / unit)
        check_enough(label, points, "intervals")
        skipped = int(np.ceil(checks.not_negative(label, "skip", skip, "s") / unit - 1e-9))
        return Schedule(system, unit, skipped, points, is_flow=True, is_section=False)
    number, skipped = checks.count(label, "periods", periods), checks.count(label, "skip", skip, 0)
    check_enough(label, number, system.unit if not is_flow else "periods")
    if not is_flow:
        return Schedule(system, 1.0, skipped, number, is_flow=False, is_section=True)
    strobe = system if isinstance(system, StroboscopicMap) else StroboscopicMap(system, period)
    return Schedule(strobe.flow, strobe.period, skipped, number, is_flow=True, is_section=True)


def _refuse_idle(
    caller: str, given: Any, system: Dynamics, duration: float | None, interval: float | None, period: float | None
) -> None:
    """Refuse what would have no influence."""
    label = f"{caller} {system.name!r}"
    if interval is not None and duration is None:
        raise InputError(f"{label}: interval= goes with duration=; between points once a period there is the period.")
    if period is None or isinstance(given, Mechanism):
        return
    if not isinstance(system, ContinuousFlow):
        raise InputError(f"{label}: period= belongs to a flow; this is a map. Leave it out.")
    if duration is not None:
        raise InputError(
            f"{label}: period= goes with periods=; with duration= give interval=, the time between points."
        )


def _judged(plan: Schedule, found: Exponents) -> Exponents:
    """The exponents with a verdict, where points are those of a section; more error where the verdict is against them.

    A flow that stays on a cycle which its exponent calls unstable, for longer than round-off needs to be seen, has
    another exponent.
    """
    if not plan.is_section or not found.ok:
        return found
    verdict = found.seen_through()
    if verdict.kind == "inconclusive" and "since" in verdict.evidence and found.unit == "1/s":
        span = (len(found.points) - verdict.evidence["since"]) * found.period
        excess = outgrown(found.value, span)
        first = np.arange(len(found.errors)) == 0
        errors = {n: np.where(first, np.hypot(getattr(found, n), excess), getattr(found, n)) for n in ERRORS}
        return replace(found, **errors, verdict=verdict)
    return replace(found, verdict=verdict)
