"""Periodic orbits by multiple shooting, their Floquet multipliers, and branches of orbits along a parameter."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from flexmb import arguments, checks
from flexmb.dynamics.orbits.orbit_newton import ArclengthPlane, Direction, NewtonResult, correct
from flexmb.dynamics.orbits.shooting import SAMPLES, Shooting, ShootingRun, closest_approaches, gap_signals, sampled
from flexmb.dynamics.systems.dynamics import Dynamics, Period, as_dynamics
from flexmb.dynamics.systems.given import state_of
from flexmb.errors import InputError
from flexmb.fields import field, record_with
from flexmb.late import xr

if TYPE_CHECKING:
    from flexmb.model.mechanism import Mechanism

REAL = 1e-9  # imaginary part, over the size of the multiplier or 1, below which a multiplier counts as real
# Kinds of changes of stability; a branch point is a crossing of two branches.
FOLD, FLIP, NEIMARK_SACKER, GRAZING, BRANCH = "fold", "flip", "neimark-sacker", "grazing", "branch"
NEAR = 0.05  # distance of a turning point of a gap from 0, over the travel of the gap, below which grazing is near


@dataclass(frozen=True)
class StabilityLoss:
    """The nearest loss of stability of an orbit."""

    # "fold": a multiplier near +1; "flip": a multiplier near -1, where a doubled orbit begins; "neimark-sacker": a
    # pair near the unit circle, where a torus begins; "grazing": surfaces that just touch or just miss each other;
    # "none": an orbit without multipliers
    kind: str
    # 1 less the size of the multiplier, < 0 beyond the loss; for grazing the least gap over its travel, < 0 for
    # surfaces in contact
    margin: float
    multiplier: complex  # the multiplier; NaN for grazing


def multipliers_of(monodromy: np.ndarray, *, autonomous: bool) -> tuple[np.ndarray, complex | None]:
    """Floquet multipliers, largest first, and the multiplier of a shift in time (None for a driven flow)."""
    # The monodromy matrix (d, d) is the derivative of the state after the period by the state before.
    multipliers = np.linalg.eigvals(monodromy).astype(np.complex128)
    multipliers = multipliers[np.argsort(-np.abs(multipliers), kind="stable")]
    if not autonomous or len(multipliers) == 0:
        return multipliers, None
    k = int(np.abs(multipliers - 1.0).argmin())
    return np.delete(multipliers, k), complex(multipliers[k])


def is_real(multipliers: np.ndarray) -> np.ndarray:
    """Whether each of the `multipliers` (d,) is real."""
    return np.asarray(np.abs(multipliers.imag) <= REAL * np.maximum(np.abs(multipliers), 1.0))


def nearest_loss(multipliers: np.ndarray, graze: float | None) -> StabilityLoss:
    """Loss of stability by the multiplier (of d) nearest to the unit circle, or by grazing if that is nearer."""
    # `graze` is the least gap over its travel; None: no gap.
    if len(multipliers) == 0:
        return StabilityLoss("none" if graze is None else GRAZING, np.nan if graze is None else graze, complex(np.nan))
    k = int(np.abs(np.log(np.maximum(np.abs(multipliers), 1e-300))).argmin())
    critical = complex(multipliers[k])
    margin = 1.0 - abs(critical)
    if graze is not None and abs(graze) < min(abs(margin), NEAR):
        return StabilityLoss(GRAZING, graze, complex(np.nan))
    if not is_real(multipliers)[k]:
        return StabilityLoss(NEIMARK_SACKER, margin, critical)
    return StabilityLoss(FOLD if critical.real > 0.0 else FLIP, margin, critical)


def flip_test(multipliers: np.ndarray) -> float:
    """Test function of flips: its sign changes where a real multiplier passes -1; near that the distance to -1."""
    if len(multipliers) == 0:
        return 1.0
    below = int(np.sum(is_real(multipliers) & (multipliers.real < -1.0)))
    return float((-1.0) ** below * np.abs(multipliers + 1.0).min())


def torus_test(multipliers: np.ndarray) -> float:
    """Test function of tori: its sign changes where the product of two multipliers passes 1."""
    # Near a change its size is the distance of the product to 1. The product passes 1 if a pair crosses the unit
    # circle. It also passes 1 at two real multipliers that are each other's inverse, which is no change of stability
    # (Y. A. Kuznetsov, Elements of Applied Bifurcation Theory, 1995, section 10.2).
    if len(multipliers) < 2:
        return 1.0
    i, j = np.triu_indices(len(multipliers), 1)
    products = multipliers[i] * multipliers[j] - 1.0
    real = products.real[np.abs(products.imag) <= REAL * np.maximum(np.abs(products), 1.0)]
    # the others come in conjugate pairs, whose product is positive
    return float((-1.0) ** int(np.sum(real < 0.0)) * np.abs(products).min())


def crosses_circle(multipliers: np.ndarray) -> bool:
    """Whether the product nearest to 1 belongs to a complex pair of the `multipliers` (d,)."""
    turning = multipliers[~is_real(multipliers)]
    i, j = np.triu_indices(len(multipliers), 1)
    least = np.abs(multipliers[i] * multipliers[j] - 1.0).min(initial=np.inf)
    return bool(len(turning) and np.abs(np.abs(turning) ** 2 - 1.0).min() <= 1.01 * least + 1e-12)


LABEL = "periodic_orbit"
# Largest residual of an orbit over the size of the state: in general, and with error-controlled steps of a mechanism.
# Error-controlled steps change from run to run, so their map is smooth only up to the errors of the steps.
TOLERANCE, TOLERANCE_OF_STEPS = 1e-10, 1e-6
AMPLIFIED = 1e4  # largest growth of differences in one segment; a period with more growth is divided into segments
# Distance that an autonomous motion covers in a period, over its state, below which it is an equilibrium.
AT_REST = 1e-6
# Distance from the start after two periods that is another motion, over state and growth; with error-controlled steps.
AGAIN, AGAIN_OF_STEPS = 1e-6, 1e-3
# Size of differences for a second look at multipliers, over the usual one; change of a multiplier that is told.
ENLARGED, LARGEST_SPREAD = 5.0, 0.01


@record_with(eq=False, kw_only=True)
class PeriodicOrbit(arguments.Checked):
    """A motion that returns to its start, or the result of a failed search."""

    formerly = (("unit", "units", "0.3"),)
    name: str = field("name of the system")
    ok: bool = field("whether the motion returns within the tolerance; the multipliers are valid only then")
    status: str = field("result of the search, in a sentence")
    state: np.ndarray = field("start state (size,)")
    time: float = field("start time [s, or iterations]")
    period: float = field("length of the orbit, all `times` periods together [s, or iterations]")
    times: int = field("number of periods of the drives, or of iterations")
    units: str = field("unit of period and time")
    residual: float = field("gap between end and start, over the size of the state")
    residuals: tuple[float, ...] = field("residuals of all iterations; squared from one to the next at the end")
    multipliers: np.ndarray = field("Floquet multipliers (d,), largest first, without that of a shift in time")
    shift: complex | None = field("multiplier of a shift in time, 1 up to errors; None for a driven flow")
    monodromy: np.ndarray = field("derivative (d, d) of the state after the period by the state before, in the basis")
    basis: np.ndarray = field("basis (size, d) of the differences of states, orthonormal in the weights of the system")
    parameters: Mapping[str, Any] = field("parameters of the system with their values")
    grazing: Mapping[str, float] = field("turning point next to 0 of each gap [m]: > 0 misses, < 0 touches; NaN: none")
    loss: StabilityLoss = field("nearest loss of stability")
    shooting: Shooting = field("shooting that found the orbit")

    @property
    def iterations(self) -> int:
        """Number of corrections of Newton's method."""
        return max(len(self.residuals) - 1, 0)

    @property
    def stable(self) -> bool:
        """Whether all multipliers lie inside the unit circle; False after a failed search."""
        return bool(self.ok and (np.abs(self.multipliers) < 1.0).all())

    def system(self) -> Dynamics:
        """An independent system at the start of the orbit."""
        system = self.shooting.system.copy()
        system.reset(self.state, time=self.time, parameters=self.parameters)
        return system

    def samples(self, count: int = SAMPLES) -> xr.Dataset:
        """The signals over the orbit, at `count` intervals of the period; a map gives every iteration.

        Returns
        -------
        Dataset with a variable for each signal over `time` [s] or `iteration`, both ends included.
        """
        system = self.system()
        times, values, _ = sampled(system, self.period, checks.count("PeriodicOrbit", "count", count))
        axis = "time" if self.units == "s" else "iteration"
        signals = zip(system.names, system.units, values.T, strict=True)
        found = {name: (axis, column, {"units": units}) for name, units, column in signals}
        about = {"name": self.name, "period": self.period, "ok": int(self.ok), "status": self.status}
        return xr.Dataset(found, {axis: (axis, times, {"units": self.units})}, about)

    def __repr__(self) -> str:
        kind = "stable" if self.stable else "unstable"
        listed = ", ".join(f"{m:.6g}" for m in self.multipliers[:4])
        more = ", ..." if len(self.multipliers) > 4 else ""
        text = f"{kind}, multipliers {listed}{more}" if self.ok else self.status
        return f"PeriodicOrbit of {self.name!r}, period {self.period:.6g} {self.units}: {text}"


def periodic_orbit(
    system: Dynamics | Mechanism, *, period: Period = None, times: int = 1,
    guess: PeriodicOrbit | Sequence[float] | np.ndarray | None = None, settle: int = 0, autonomous: bool = False,
    segments: int | None = None, tangent: str = "carried", angles: Sequence[str] = (), grazing: str | None = None,
    tolerance: float | None = None, iterations: int = 30,
) -> PeriodicOrbit:  # fmt: skip
    """The periodic orbit near a guess, stable or unstable, with its Floquet multipliers.

    Newton's method solves P(x) = x for the state x, with the motion P over `times` periods and its tangent.
    Corrections that increase the residual are halved.

    Parameters
    ----------
    system : a flow, a map, or a mechanism, which becomes a `MechanismFlow`; it is not changed.
    period : period of the drives [s], or a function of the parameters; None: the period of the drives of a mechanism,
        one iteration of a map.  With `autonomous` a first guess.
    times : number of these periods after which the orbit closes.
    guess : start state (size,), another orbit, or None for the present state; or one state for each segment
        (segments, size).
    settle : number of periods before the search, to come nearer to an attracting orbit.
    autonomous : whether the system has no drive; then the period is unknown as well, and the start may move only
        across the motion.
    segments : number of segments (multiple shooting); None: as many as keep the growth of differences in each below
        1e4.  It must divide `times` of a map.
    tangent : "carried": tangent vectors of the system; "differences": differences of neighbouring motions.
    angles : names of state entries that count modulo 2 pi; the angles of a mechanism are known.
    grazing : name of a signal that measures a gap, > 0 if open; the contacts of a mechanism are known.
    tolerance : largest residual over the size of the state; None: 1e-10, or 1e-6 for a mechanism with error-controlled
        steps.
    iterations : largest number of corrections.

    Raises
    ------
    InputError : a flow without period, a map with one, a guess of another shape, numbers out of range, unknown names.
    FlexmbError : a mechanism that cannot start.

    Notes
    -----
    Without convergence `ok` is False, and `status` says why.  On an orbit of a mechanism, positions (up to whole turns
    of a body), velocities and histories of friction and elements return; histories of normal contacts follow from them.
    Whole turns that wind up an elastic element are not noticed.
    Source: R. Seydel, Practical Bifurcation and Stability Analysis, Springer 2010, chapter 7.

    Examples
    --------
    >>> import flexmb as fm
    >>> logistic = fm.chaos.Map(lambda x, r: r * x * (1.0 - x), [0.6], parameters={"r": 2.5})
    >>> orbit = fm.chaos.periodic_orbit(logistic)
    >>> orbit.state.round(6).tolist(), orbit.multipliers.real.round(6).tolist(), orbit.stable
    ([0.6], [-0.5], True)
    """
    flow = as_dynamics(LABEL, system, wanted="a flow or map (Map, MechanismFlow) or a Mechanism").copy()
    checks.flag(LABEL, "autonomous", autonomous)
    checks.count(LABEL, "iterations", iterations, 0)
    starts = None
    if isinstance(guess, (list, tuple, np.ndarray)) and len(guess) > 0 and np.ndim(guess[0]) == 1:
        starts = np.array([_guessed(one, flow) for one in guess])
    start = _guessed(guess, flow) if starts is None else starts[0]
    segments = len(starts) if starts is not None and segments is None else segments
    if starts is not None and segments != len(starts):
        raise InputError(f"{LABEL}: guess has {len(starts)} states; there must be one for each of {segments} segments.")
    if period is None and autonomous and isinstance(guess, PeriodicOrbit):
        period = guess.period / guess.times
    number = 1 if segments is None else checks.count(LABEL, "segments", segments)
    about: dict[str, Any] = {"autonomous": autonomous, "segments": number, "tangent": tangent, "angles": tuple(angles)}
    shooting = Shooting(LABEL, flow, period=period, times=times, **about)
    gaps = gap_signals(flow, grazing, LABEL)
    flow.reset(start, time=shooting.origin)
    if starts is None and flow.go_to_section():
        flow.reset(flow.state(), time=shooting.origin)
    for _ in range(checks.count(LABEL, "settle", settle, 0)):
        if not flow.advance(shooting.base if shooting.is_flow else 1):
            break
    tolerance = tolerance_of(flow, tolerance)
    if starts is None or settle:
        starts = flow.state()[None, :]
    result, shooting = _search(shooting, starts, tolerance, iterations, automatic=segments is None)
    return orbit_of(shooting, result, gaps)


def _guessed(guess: Any, system: Dynamics) -> np.ndarray:
    if guess is None:
        return system.state()
    if isinstance(guess, PeriodicOrbit):
        guess = guess.state
    return state_of(f"{LABEL}: guess for {system.name!r}", guess, system.size)


def tolerance_of(system: Dynamics, asked: float | None) -> float:
    """Tolerance as given, > 0, or the default for the steps of the system."""
    if asked is not None:
        return checks.positive(LABEL, "tolerance", asked)
    return TOLERANCE_OF_STEPS if system.is_rough else TOLERANCE


def _search(
    shooting: Shooting, states: np.ndarray, tolerance: float, iterations: int, *, automatic: bool
) -> tuple[NewtonResult, Shooting]:
    """Newton's method from one state (1, size) or one a segment; with automatic segments after a first run."""
    period = shooting.period
    if automatic:
        run = shooting.run(states, period)
        growth = 1.0 if run is None or run.gaps.size == 0 else float(np.linalg.norm(run.monodromy, 2))
        segments, times = max(int(np.ceil(np.log(max(growth, 1.0)) / np.log(AMPLIFIED))), 1), shooting.times
        if not shooting.is_flow:
            segments = next(k for k in range(1, times + 1) if times % k == 0 and k >= min(segments, times))
        if segments > 1:
            shooting = shooting.copy(times, segments)
    starts = states if len(states) == shooting.segments else shooting.spread(states[0], period)
    if starts is None:
        return NewtonResult(None, (), False, f"The motion from the guess fails: {shooting.status}"), shooting
    return correct(shooting, starts, period, np.nan, tolerance=tolerance, iterations=iterations), shooting


def orbit_of(shooting: Shooting, result: NewtonResult, gaps: dict[str, tuple[int, float]]) -> PeriodicOrbit:
    """Periodic orbit from the result of Newton's method."""
    run, system = result.last, shooting.system
    d = run.bases.shape[2] if run is not None else 0
    monodromy = run.monodromy if run is not None else np.zeros((0, 0))
    multipliers, shift = multipliers_of(monodromy, autonomous=shooting.autonomous)
    state = run.starts[0] if run is not None else system.state()
    period = run.period if run is not None else shooting.period
    ok, status = result.ok, result.status
    if ok and run is not None:
        ok, status = _checked_orbit(shooting, run, status)
    approaches: dict[str, tuple[float, float, int]] = {}
    if ok and gaps:
        system.reset(state, time=shooting.origin)
        approaches = closest_approaches(system, gaps, sampled(system, period, SAMPLES * shooting.times))
    fractions = [least / travel for least, travel, _ in approaches.values() if travel > 0.0 and not np.isnan(least)]
    system.reset(state, time=shooting.origin)
    return PeriodicOrbit(
        name=system.name, ok=ok, status=status, state=state, time=shooting.origin, period=period,
        times=shooting.times, units=system.unit, residual=result.residuals[-1] if result.residuals else np.nan,
        residuals=result.residuals, multipliers=multipliers, shift=shift, monodromy=monodromy,
        basis=run.bases[0] if run is not None else np.zeros((system.size, d)), parameters=system.parameters,
        grazing={name: least for name, (least, _, _) in approaches.items()},
        loss=nearest_loss(multipliers, min(fractions, key=abs, default=None)), shooting=shooting,
    )  # fmt: skip


def _checked_orbit(shooting: Shooting, run: ShootingRun, status: str) -> tuple[bool, str]:
    """Whether a converged run is an orbit, and its status, with notes on multipliers and on a shorter period."""
    system, space = shooting.system, shooting.space
    if shooting.tangent == "differences" and system.is_rough:
        # Error-controlled steps change from run to run, so a difference of two runs has a part of their errors.
        shooting.enlarged = ENLARGED
        other = shooting.run(run.starts, run.period, run.value)
        shooting.enlarged = 1.0
        if other is None:
            status += f" Motions with differences {ENLARGED:g} times as large fail: {shooting.status}"
        else:
            one, two = (np.linalg.eigvals(found.monodromy) for found in (run, other))
            spread = np.abs(one[:, None] - two).min(axis=1, initial=np.inf).max(initial=0.0)
            if spread > LARGEST_SPREAD * max(np.abs(one).max(initial=0.0), 1.0):
                status += f" Multipliers change by {spread:.2g} with differences {ENLARGED:g} times as large."
                status += " Take fixed steps, a smaller rtol, or tangent='carried'."
    if shooting.autonomous:
        system.reset(run.starts[0], time=0.0)
        if space.length(system.velocity()) * run.period <= AT_REST * shooting.scale:
            text = "The search came to an equilibrium, which is no orbit of any period"
            return False, f"{text}. Give a guess farther from the equilibrium."
    elif shooting.is_flow:
        most, m, state = shooting.scale * (AGAIN_OF_STEPS if system.is_rough else AGAIN), len(run.starts), run.starts[0]
        for k in range(2 * m):  # with steps that begin anew at each segment, as in the shooting
            system.reset(state, time=shooting.origin + k * run.period / m)
            most = most if system.advance(run.period / m) else np.inf  # a motion that fails is not judged
            state = system.state()
        if space.length(space.difference(state, run.starts[0])) > most * (1.0 + np.linalg.norm(run.monodromy)):
            text = f"The motion comes back after {run.period:.6g} s and not after twice that: a load has another period"
            return False, f"{text}. Give times= or period=, of drives and loads together."
    for periods in (k for k in range(1, shooting.times) if shooting.times % k == 0 and not shooting.autonomous):
        system.reset(run.starts[0], time=shooting.origin)
        if system.advance(periods * shooting.base if shooting.is_flow else periods):
            distance = space.length(space.difference(system.state(), run.starts[0]))
            if distance <= max(1e3 * run.miss, 1e-7 * shooting.scale):
                return True, f"{status} It comes back after {periods} of the {shooting.times} periods already."
    return True, status


@record_with(eq=False, kw_only=True)
class BranchPoint:
    """An orbit on a branch."""

    value: float = field("value of the parameter")
    kind: str = field('"" for an ordinary point; else the kind of the event')
    period: float = field("period of the orbit [s, or iterations]")
    state: np.ndarray = field("start state (size,)")
    signals: np.ndarray = field("signals (names,) at the start")
    multipliers: np.ndarray = field("Floquet multipliers (d,), largest first, without that of a shift in time")
    stable: bool = field("whether all multipliers lie inside the unit circle")
    residual: float = field("gap between end and start, over the size of the state")
    extremes: np.ndarray = field("smallest and largest values (names, 2) on the orbit; NaN if not requested")
    grazing: dict[str, float] = field("turning point nearest to 0 of each gap", "m")
    rising: float = field("change of the parameter along the branch over the whole change, -1 ... 1")
    shooting_run: ShootingRun = field("the motion over the period")
    impact_speeds: np.ndarray = field("closing speeds of impacts (`ImpactODE`)", default_factory=lambda: np.zeros(0))


@record_with(eq=False, kw_only=True)
class Branch(arguments.Checked):
    """Periodic orbits along a parameter."""

    formerly = (("unit", "period_units", "0.3"),)
    name: str = field("name of the system")
    parameter: str = field("name of the parameter")
    period_units: str = field("unit of the period")
    names: tuple[str, ...] = field("names of the signals")
    units: tuple[str, ...] = field("units of the signals")
    points: tuple[BranchPoint, ...] = field("orbits in the order of the branch")
    events: tuple[BranchPoint, ...] = field("orbits at which stability changes or surfaces graze, in order")
    ok: bool = field("whether the branch ended at the end of the range")
    status: str = field("end of the branch, in a sentence")
    shooting: Shooting = field("shooting that found the orbits")
    tolerance: float = field("largest residual of an orbit")
    span: tuple[float, float] = field("range of the parameter")
    gaps: dict[str, tuple[int, float]] = field("number and sign of the signals of gaps")

    def orbit(self, point: int | BranchPoint) -> PeriodicOrbit:
        """The periodic orbit at a `point`, a number of the point or an element of `points` or `events`, computed again.

        Raises
        ------
        InputError : a number beyond the branch.
        """
        if not isinstance(point, BranchPoint):
            if not -len(self.points) <= checks.count("Branch", "point", point, -len(self.points)) < len(self.points):
                raise InputError(f"Branch of {self.name!r}: point is {point}; there are {len(self.points)}.")
            point = self.points[point]
        run, shooting = point.shooting_run, self.shooting.copy(self.shooting.times, self.shooting.segments)
        result = correct(shooting, run.starts, run.period, run.value, tolerance=self.tolerance, iterations=10)
        return orbit_of(shooting, result, self.gaps)

    def switch(self, event: int | BranchPoint | None = None, *, step: float = 0.02) -> PeriodicOrbit:
        """The first orbit of the branch that begins at a flip (with twice the period) or at a branch point.

        Continue this orbit from its own parameter: `follow(orbit, parameter, (None, to))`.

        Parameters
        ----------
        event : element of `events`, or its number; None: the first flip, else the first branch point.
        step : distance from the event, over the size of the state.

        Raises
        ------
        InputError : no such event, or an event of another kind.

        Notes
        -----
        The step goes along the eigenvector of the multiplier -1 (+1 at a branch point).  Orbit and parameter are found
        on the plane across the step, so the other branch may begin on either side.  `ok` is False if no other orbit is
        found.
        """
        if event is None:
            event = next((e for kind in (FLIP, BRANCH) for e in self.events if e.kind == kind), None)
        event = self.event_of("switch", event, (FLIP, BRANCH), "a flip or a branch point of this branch")
        step = checks.positive("switch", "step", step)
        factor, run = 2 if event.kind == FLIP else 1, event.shooting_run
        shooting = self.shooting.copy(self.shooting.times * factor, self.shooting.segments * factor)
        values, vectors = np.linalg.eig(run.monodromy)
        usable = np.where(is_real(values), np.abs(values - (-1.0 if factor == 2 else 1.0)), np.inf)
        y = np.real(vectors[:, int(usable.argmin())])
        displacements, y_of_segment = [], y / np.linalg.norm(y)
        for _ in range(factor):
            for j in range(self.shooting.segments):
                displacements.append(run.bases[j] @ y_of_segment)
                y_of_segment = run.slopes[j] @ y_of_segment
        size, width = size_of(self.shooting, run), abs(self.span[1] - self.span[0])
        normal = Direction(np.array(displacements), 0.0, 0.0)
        starts = np.tile(run.starts, (factor, 1)) + step * size * normal.starts
        through = Direction(starts, factor * run.period, run.value)
        plane = ArclengthPlane(normal, through, (size, run.period, width), small_of(shooting, width))
        limits: dict[str, Any] = {"tolerance": self.tolerance, "iterations": 20}
        result = correct(shooting, starts, through.period, run.value, **limits, plane=plane)
        orbit = orbit_of(shooting, result, self.gaps)
        if orbit.ok and factor == 2 and "already" in orbit.status:
            text = "The step came back to the orbit without doubling; try another step="
            return orbit_of(shooting, NewtonResult(result.last, result.residuals, ok=False, status=text), self.gaps)
        return orbit

    def curve(
        self, event: int | BranchPoint, parameter: str, span: tuple[float, float], *, step: float = 0.02,
        points: int = 200,
    ) -> xr.Dataset:  # fmt: skip
        """The curve of an event over the plane of the branch's parameter and a second one.

        Parameters
        ----------
        event : element of `events`, or its number: grazing, a flip or a Neimark-Sacker point.
        parameter : name of the second parameter.
        span : range (from, to) of the second parameter, which holds its value; the curve ends outside.
        step : first step, as a fraction of both ranges.
        points : largest number of points on each side of the event.

        Returns
        -------
        Dataset with both parameters and the period over "point"; attributes "ok" and "status" tell how it ended.

        Raises
        ------
        InputError : no such event, an event of another kind, an unknown parameter, a range without its value.

        Notes
        -----
        Along the curve the test function of the event vanishes (see `follow`): for grazing the turning point of the gap
        that touches.  At each point orbits are found for given parameters, so a curve ends where its orbits fold.
        """
        from flexmb.dynamics.orbits.event_curve import curve

        return curve(self, event, parameter, span, step=step, points=points)

    def to_dataset(self) -> xr.Dataset:
        """The branch as a table over "point": signals at the start, period, stability, multipliers, events.

        Multipliers have two variables over "multiplier", real and imaginary part.  Events have variables over "event".
        """
        points, axis = self.points, "point"
        signals = np.array([p.signals for p in points]).reshape(len(points), len(self.names))
        extremes = np.array([p.extremes for p in points]).reshape(len(points), len(self.names), 2)
        data: dict[str, Any] = {}
        for k, (name, units) in enumerate(zip(self.names, self.units, strict=True)):
            data[name] = (axis, signals[:, k], {"units": units})
            if np.isfinite(extremes[:, k]).any():
                data[f"{name}.min"], data[f"{name}.max"] = ((axis, extremes[:, k, s], {"units": units}) for s in (0, 1))
        widest = max((len(p.multipliers) for p in points), default=0)
        table = np.full((len(points), widest), np.nan, dtype=np.complex128)
        for row, p in zip(table, points, strict=True):
            row[: len(p.multipliers)] = p.multipliers
        data["period"] = (axis, np.array([p.period for p in points]), {"units": self.period_units})
        data["stable"] = (axis, np.array([p.stable for p in points], dtype=bool))
        data["residual"] = (axis, np.array([p.residual for p in points]))
        data["multiplier.real"] = ((axis, "multiplier"), table.real.copy())
        data["multiplier.imag"] = ((axis, "multiplier"), table.imag.copy())
        for name in points[0].grazing if points else ():
            data[f"grazing.{name}"] = (axis, np.array([p.grazing.get(name, np.nan) for p in points]), {"units": "m"})
        data["event.kind"] = ("event", np.array([e.kind for e in self.events], dtype=str))
        data[f"event.{self.parameter}"] = ("event", np.array([e.value for e in self.events]))
        data["event.period"] = ("event", np.array([e.period for e in self.events]), {"units": self.period_units})
        signals = np.array([e.signals for e in self.events]).reshape(len(self.events), len(self.names))
        for k, name in enumerate(self.names):
            data[f"event.{name}"] = ("event", signals[:, k], {"units": self.units[k]})
        attrs = {"name": self.name, "parameter": self.parameter, "ok": int(self.ok), "status": self.status}
        return xr.Dataset(data, {self.parameter: (axis, np.array([p.value for p in points]))}, attrs)

    def event_of(self, label: str, event: Any, kinds: Sequence[str], wanted: str) -> BranchPoint:
        """The `event` of one of some `kinds`, an element of `events` or its number; `label`, `wanted`: for messages."""
        number = isinstance(event, (int, np.integer)) and not isinstance(event, bool)
        if number and -len(self.events) <= event < len(self.events):
            event = self.events[event]
        if not isinstance(event, BranchPoint) or event.kind not in kinds:
            listed = ", ".join(f"{k}: {e.kind} at {e.value:.6g}" for k, e in enumerate(self.events)) or "none"
            text = f"{label}: event is {event if not isinstance(event, BranchPoint) else event.kind!r}"
            raise InputError(f"{text}; it must be {wanted}. Events: {listed}.")
        return event

    def __repr__(self) -> str:
        values = [p.value for p in self.points]
        span = f"{min(values):.6g} to {max(values):.6g}" if values else "nowhere"
        events = ", ".join(f"{e.kind} at {e.value:.8g}" for e in self.events) or "no events"
        return f"Branch of {self.name!r}, {self.parameter} {span}, {len(self.points)} points: {events}. {self.status}"


def size_of(shooting: Shooting, run: ShootingRun) -> float:
    """Scale of the states of a run: their mean length, or 1 if all are 0."""
    return max(float(np.mean([shooting.space.length(x) for x in run.starts])), 1e-2 * shooting.scale) or 1.0


def small_of(shooting: Shooting, width: float) -> float:
    """Difference of the parameter for derivatives, by the width of its range."""
    return (1e-6 if not shooting.is_flow else 1e-5) * width
