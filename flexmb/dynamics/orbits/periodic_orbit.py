"""Periodic orbits by shooting: where the motion comes back to after a period."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from flexmb import checks
from flexmb.dynamics.orbits.floquet import Loss, multipliers_of, nearest_loss
from flexmb.dynamics.orbits.grazing import SAMPLES, closest_approaches, gap_signals, sampled
from flexmb.dynamics.orbits.newton import Found, correct
from flexmb.dynamics.orbits.shooting import Pass, Period, Shooting
from flexmb.dynamics.systems.dynamics import Dynamics
from flexmb.dynamics.systems.given import state_of
from flexmb.dynamics.systems.mechanism_flow import MechanismFlow
from flexmb.errors import InputError
from flexmb.model.mechanism import Mechanism
from flexmb.step.step_size import Adaptive

if TYPE_CHECKING:
    import xarray as xr

LABEL = "periodic_orbit"

TOLERANCE, TOLERANCE_OF_STEPS = 1e-10, 1e-6
"""Of what does not come back, as a part of the state; error-controlled steps of a mechanism change from pass to
pass, so that its map is smooth only up to their errors."""

AMPLIFIED = 1e4
"""A period in which differences grow more is divided into parts in which they do not."""

AT_REST = 1e-6
"""A free motion that moves less than this part of its state in a period is an equilibrium."""


@dataclass(frozen=True, eq=False)
class PeriodicOrbit:
    """A motion that comes back to its start, or what the search for one came to.

    Parameters
    ----------
    name : of the system.
    ok : whether it comes back within the tolerance; multipliers of an orbit that does not mean nothing.
    status : what the search came to, in a sentence.
    state : (size,) where it begins.
    time : when it begins [s, or iterations].
    period : after which it comes back, all `times` periods together [s, or iterations].
    times : periods of the drives, or iterations, that it lasts.
    unit : of period and time.
    residual : what does not come back, as a part of the state.
    residuals : the same of each pass; the squares of one another where Newton's method converges.
    multipliers : (d,) Floquet multipliers, eigenvalues of the derivative of the state after the period by that before,
        largest first; without the one that belongs to a shift in time.
    shift : that multiplier of an autonomous flow, which is 1 but for errors; None where a drive sets the clock.
    monodromy : (d, d) the derivative, in the basis.
    basis : (size, d) the directions in which states can differ, orthonormal in the weights of the system.
    parameters : parameters of the system that were changed, or all it has.
    grazing : of each gap its turning point nearest to 0 [m]: > 0 just misses, < 0 just touches; NaN: it has none.
    loss : which loss of stability is nearest.
    shooting : the passes it was found with.
    """

    _: KW_ONLY
    name: str
    ok: bool
    status: str
    state: np.ndarray
    time: float
    period: float
    times: int
    unit: str
    residual: float
    residuals: tuple[float, ...]
    multipliers: np.ndarray
    shift: complex | None
    monodromy: np.ndarray
    basis: np.ndarray
    parameters: Mapping[str, Any]
    grazing: Mapping[str, float]
    loss: Loss
    shooting: Shooting

    @property
    def iterations(self) -> int:
        """Corrections that Newton's method took."""
        return max(len(self.residuals) - 1, 0)

    @property
    def stable(self) -> bool:
        """Whether all multipliers lie inside the circle; False where there is no orbit."""
        return bool(self.ok and (np.abs(self.multipliers) < 1.0).all())

    def system(self) -> Dynamics:
        """A system of its own that stands at the start of the orbit."""
        system = self.shooting.system.copy()
        system.reset(self.state, time=self.time, parameters=self.parameters)
        return system

    def samples(self, count: int = SAMPLES) -> xr.Dataset:
        """The signals over the orbit.

        Parameters
        ----------
        count : into how many parts the period is divided; a map gives each iteration.

        Returns
        -------
        Dataset with one variable a signal over `time` [s], or `iteration`, both ends included.
        """
        import xarray as xr

        system = self.system()
        times, values, _ = sampled(system, self.period, checks.count("PeriodicOrbit", "count", count))
        axis = "time" if self.unit == "s" else "iteration"
        signals = zip(system.names, system.units, values.T, strict=True)
        return xr.Dataset(
            {name: (axis, column, {"units": units}) for name, units, column in signals},
            {axis: (axis, times, {"units": self.unit})},
            {"name": self.name, "period": self.period, "ok": int(self.ok), "status": self.status},
        )

    def __repr__(self) -> str:
        kind = "stable" if self.stable else "unstable"
        shown = ", ".join(f"{m:.6g}" for m in self.multipliers[:4])
        more = ", ..." if len(self.multipliers) > 4 else ""
        what = f"{kind}, multipliers {shown}{more}" if self.ok else self.status
        return f"PeriodicOrbit of {self.name!r}, period {self.period:.6g} {self.unit}: {what}"


def periodic_orbit(
    system: Dynamics | Mechanism,
    *,
    period: Period = None,
    times: int = 1,
    guess: PeriodicOrbit | Sequence[float] | np.ndarray | None = None,
    settle: int = 0,
    autonomous: bool = False,
    segments: int | None = None,
    tangent: str = "carried",
    angles: Sequence[str] = (),
    grazing: str | None = None,
    tolerance: float | None = None,
    iterations: int = 30,
) -> PeriodicOrbit:
    """The periodic orbit near a guess, stable or not, with its multipliers.

    Newton's method solves P(x) = x, P the motion over `times` periods, with the tangent of P that the system
    carries along; corrections that lead away are halved.

    Parameters
    ----------
    system : a flow, a map, or a mechanism, which is then moved by `MechanismFlow`; it stays as it is.
    period : of the drives [s], or a function of the parameters that gives it; None: that of the drives of a mechanism,
        one iteration of a map.  With `autonomous` a first guess.
    times : after how many of these periods the orbit closes.
    guess : where it begins: a state (size,), another orbit, or None: the present state.  Or one state for each part
        (segments, size), where the motion from a single one would lead astray.
    settle : periods to go on from the guess before the search, to come nearer to an orbit that attracts.
    autonomous : whether nothing outside sets a clock; the period is then sought as well, and the start moves across
        the motion only.
    segments : parts of the period that are shot one by one (multiple shooting); None: one, or as many as are needed
        for differences to grow by less than 1e4 in each.  It must divide `times` of a map.
    tangent : "carried" along by the system, or by "differences" of motions beside it.
    angles : names of numbers of the state that may come back whole turns further; those of a mechanism are known.
    grazing : name of a signal that tells a gap, > 0 where it is open; a mechanism's contacts are known.
    tolerance : of what does not come back, as a part of the state; None: 1e-10, or 1e-6 for a mechanism with
        error-controlled steps.
    iterations : largest number of corrections.

    Raises
    ------
    InputError : a flow without period, a map with one, a guess of another shape, numbers out of range, unknown names.
    FlexmbError : a mechanism that cannot start.

    Notes
    -----
    No convergence is a status, `ok` is then False.  Of a mechanism positions (up to whole turns of a body), velocities
    and histories of friction and elements must come back; histories of normal contacts follow.
    For an elastic element wound up by whole turns of a body the orbit would not be one.
    Source: R. Seydel, Practical Bifurcation and Stability Analysis, Springer 2010, chapter 7.

    Examples
    --------
    >>> import flexmb as fm
    >>> logistic = fm.Map(lambda x, r: r * x * (1.0 - x), [0.6], parameters={"r": 2.5})
    >>> orbit = fm.periodic_orbit(logistic)
    >>> orbit.state.round(6).tolist(), orbit.multipliers.real.round(6).tolist(), orbit.stable
    ([0.6], [-0.5], True)
    """
    moved = MechanismFlow(system) if isinstance(system, Mechanism) else system
    if not isinstance(moved, Dynamics):
        raise InputError(
            f"{LABEL}: system is {system!r}; it must be a flow or map (Map, MechanismFlow) or a Mechanism."
        )
    moved = moved.copy()
    if not isinstance(autonomous, bool):
        raise InputError(f"{LABEL}: autonomous is {autonomous!r}; it must be True or False.")
    checks.count(LABEL, "iterations", iterations, 0)
    parts = None if not _is_table(guess) else np.array([_guessed(one, moved) for one in guess])
    known = _guessed(guess, moved) if parts is None else parts[0]
    segments = len(parts) if parts is not None and segments is None else segments
    if parts is not None and segments != len(parts):
        raise InputError(f"{LABEL}: guess has {len(parts)} states; there must be one for each of {segments} segments.")
    if period is None and autonomous and isinstance(guess, PeriodicOrbit):
        period = guess.period / guess.times
    shooting = Shooting(
        LABEL,
        moved,
        period=period,
        times=times,
        autonomous=autonomous,
        segments=1 if segments is None else checks.count(LABEL, "segments", segments),
        tangent=tangent,
        angles=tuple(angles),
    )
    gaps = gap_signals(moved, grazing, LABEL)
    moved.reset(known, time=shooting.origin)
    for _ in range(checks.count(LABEL, "settle", settle, 0)):
        if not moved.advance(shooting.base if shooting.is_flow else 1):
            break
    tolerance = tolerance_of(moved, tolerance)
    if parts is None or settle:
        parts = moved.state()[None, :]
    found, shooting = _search(shooting, parts, tolerance, iterations, free=segments is None)
    return made(shooting, found, gaps)


def _is_table(guess: Any) -> bool:
    """Whether it is a list of states."""
    return isinstance(guess, (list, tuple, np.ndarray)) and len(guess) > 0 and np.ndim(guess[0]) == 1


def _guessed(guess: Any, system: Dynamics) -> np.ndarray:
    if guess is None:
        return system.state()
    if isinstance(guess, PeriodicOrbit):
        guess = guess.state
    return state_of(f"{LABEL}: guess for {system.name!r}", guess, system.size)


def tolerance_of(system: Dynamics, asked: float | None) -> float:
    """The tolerance asked for, or that which the steps of the system allow."""
    if asked is not None:
        return checks.positive(LABEL, "tolerance", asked)
    rough = isinstance(system, MechanismFlow) and isinstance(system.step, Adaptive)
    return TOLERANCE_OF_STEPS if rough else TOLERANCE


def _search(
    shooting: Shooting, given: np.ndarray, tolerance: float, iterations: int, *, free: bool
) -> tuple[Found, Shooting]:
    """Newton from a state (1, size), or from one a part; in parts where differences grow much in a first pass."""
    period = shooting.period
    if free:
        one = shooting.run(given, period)
        parts = parts_needed(shooting, one)
        if parts > 1:
            shooting = shooting.copy(shooting.times, parts)
    starts = given if len(given) == shooting.segments else shooting.spread(given[0], period)
    if starts is None:
        return Found(None, (), False, f"The motion from the guess fails: {shooting.status}"), shooting
    return correct(shooting, starts, period, np.nan, tolerance=tolerance, iterations=iterations), shooting


def parts_needed(shooting: Shooting, one: Pass | None) -> int:
    """Into how many parts the period has to be divided, so that differences grow by at most `AMPLIFIED` in each."""
    if one is None or one.gaps.size == 0:
        return 1
    growth = float(np.linalg.norm(one.monodromy, 2))
    parts = max(int(np.ceil(np.log(max(growth, 1.0)) / np.log(AMPLIFIED))), 1)
    if shooting.is_flow:
        return parts
    return next(k for k in range(1, shooting.times + 1) if shooting.times % k == 0 and k >= min(parts, shooting.times))


def made(shooting: Shooting, found: Found, gaps: dict[str, tuple[int, float]]) -> PeriodicOrbit:
    """The orbit of what Newton's method found."""
    one, system = found.last, shooting.system
    d = one.bases.shape[2] if one is not None else 0
    monodromy = one.monodromy if one is not None else np.zeros((0, 0))
    multipliers, shift = multipliers_of(monodromy, autonomous=shooting.autonomous)
    state = one.starts[0] if one is not None else system.state()
    period = one.period if one is not None else shooting.period
    ok, status = found.ok, found.status
    if ok and one is not None:
        ok, status = _judged(shooting, one, status)
    near: dict[str, tuple[float, float, int]] = {}
    if ok and gaps:
        system.reset(state, time=shooting.origin)
        near = closest_approaches(system, gaps, sampled(system, period, SAMPLES * shooting.times))
    parts = [least / travel for least, travel, _ in near.values() if travel > 0.0 and not np.isnan(least)]
    system.reset(state, time=shooting.origin)
    return PeriodicOrbit(
        name=system.name,
        ok=ok,
        status=status,
        state=state,
        time=shooting.origin,
        period=period,
        times=shooting.times,
        unit=system.unit,
        residual=found.misses[-1] if found.misses else np.nan,
        residuals=found.misses,
        multipliers=multipliers,
        shift=shift,
        monodromy=monodromy,
        basis=one.bases[0] if one is not None else np.zeros((system.size, d)),
        parameters=system.parameters,
        grazing={name: least for name, (least, _, _) in near.items()},
        loss=nearest_loss(multipliers, min(parts, key=abs, default=None)),
        shooting=shooting,
    )


def _judged(shooting: Shooting, one: Pass, status: str) -> tuple[bool, str]:
    """Whether a start that comes back is an orbit, and what is to be said of it."""
    system, space = shooting.system, shooting.space
    if shooting.autonomous:
        system.reset(one.starts[0], time=0.0)
        if space.length(system.velocity()) * one.period <= AT_REST * shooting.scale:
            text = "The search came to an equilibrium, which is no orbit of any period"
            return False, f"{text}. Give a guess further from it."
    for part in range(1, shooting.times):
        if shooting.times % part or shooting.autonomous:
            continue
        system.reset(one.starts[0], time=shooting.origin)
        if system.advance(part * shooting.base if shooting.is_flow else part):
            away = space.length(space.difference(system.state(), one.starts[0]))
            if away <= max(1e3 * one.miss, 1e-7 * shooting.scale):
                return True, f"{status} It comes back after {part} of the {shooting.times} periods already."
    return True, status
