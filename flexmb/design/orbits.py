"""Derivatives of equilibria, of natural frequencies about them, and of periodic orbits by parameters."""

from __future__ import annotations

import inspect
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from keyword import iskeyword
from typing import Any, NamedTuple

import numpy as np

from flexmb import arguments, checks, display
from flexmb.design.derivatives import Derivatives, Measures, Started, carried, measure_of, measures_of, places_of, told
from flexmb.design.measures import EXTREMES, Measure, Rows, measured
from flexmb.design.parameters import Model, Neighbour, Parameter, ParameterModel, directions, neighbour, refuse_taken
from flexmb.dynamics.orbits.orbit_newton import correct, extended, solved
from flexmb.dynamics.orbits.periodic_orbit import PeriodicOrbit, tolerance_of
from flexmb.dynamics.orbits.shooting import SAMPLES, sampled
from flexmb.dynamics.systems.dynamics import Dynamics
from flexmb.dynamics.systems.impact_ode import ImpactODE
from flexmb.dynamics.systems.mechanism_flow import MechanismFlow
from flexmb.engine.newmark.method import Newmark
from flexmb.engine.sensitivity.linearise import Tangents, linearise, new_tangents
from flexmb.engine.sensitivity.parameter_run import ParameterRun
from flexmb.engine.sensitivity.parameters import parameter_rates
from flexmb.engine.sensitivity.signal_rows import signal_rows
from flexmb.engine.sensitivity.tangent_step import pack_differences, synchronise
from flexmb.engine.step.step_size import Adaptive
from flexmb.engine.system.state_evaluation import StateEvaluation
from flexmb.errors import InputError, SolveError
from flexmb.fields import field, record_with
from flexmb.late import scipy, xr
from flexmb.program.program import Program
from flexmb.statics.equilibrium import Equilibrium, static_equilibrium
from flexmb.statics.modes import Modes, modes
from flexmb.statics.start.consistent import Start

EQUAL_SQUARES = 1e-6  # relative difference of the squares of two frequencies below which these are one, repeated
WIDER = 30.0  # step of differences of stiffness, whose digits cancel in low modes, over that of forces [1]
SECOND = 1.0  # length of the run that evaluates signals at rest, which takes no step [s]


@record_with(repr=False)
class StaticSensitivity(Measures):
    """Derivatives of signals in an equilibrium, and of natural frequencies about it."""

    measures: xr.Dataset = field(
        "`amount`, `derivative` and `relative` derivative (NaN or infinite of an amount of 0) of each signal and of "
        'each frequency, "frequency 1" [Hz] the lowest'
    )
    equilibrium: Equilibrium = field("the equilibrium")

    def __repr__(self) -> str:
        return self._below("StaticSensitivity about an equilibrium")


@arguments.checked
def static_sensitivity(
    model: Model, parameters: Iterable[str] | Mapping[str, float], *, of: Sequence[str] = (), frequencies: int = 0
) -> StaticSensitivity:
    """Derivatives of an equilibrium, and of natural frequencies about it, by parameters.

    The equilibrium moves with the parameters: coordinates and joint forces follow from one more solution with the
    stiffness at rest, frequencies from the change of stiffness, mass and constraints along this motion.

    Parameters
    ----------
    model, parameters : as in `sensitivity`.
    of : names of signals at rest, "rod.end.y" or "O.force".
    frequencies : number of natural frequencies without damping, from the lowest.

    Raises
    ------
    InputError : unknown parameters and signals; neither signals nor frequencies; a frequency of 0, as of a rigid
        motion, whose derivative is not finite; see also `sensitivity`.
    SolveError : no equilibrium; see `static_equilibrium` and `modes`.

    Notes
    -----
    Frequencies that are equal split along a parameter: each has the derivative of one of the branches, in ascending
    order.  Equations (14.12) and (14.13) of docs/theory/design.md.

    Examples
    --------
    The tip of a cantilever of the length l sinks by F l^3/(3 E I), so by 3/l more for each unit of l:

    >>> import flexmb as fm
    >>> def cantilever(length: float, force: float) -> fm.Mechanism:
    ...     beam = fm.FlexibleLink("beam", (0.0, 0.0), (length, 0.0), section=fm.Rectangle(0.01, 0.01),
    ...                            material=fm.Material(2e11, 7800.0, 0.3), elements=4)
    ...     parts = [beam, fm.Fixed("wall", fm.GROUND, beam, at=(0.0, 0.0))]
    ...     return fm.Mechanism("cantilever", [*parts, fm.Force("F", beam, (length, 0.0), (0.0, -force))])
    >>> s = fm.design.static_sensitivity(cantilever, {"length": 0.5, "force": 0.1}, of=["beam.end.y"])
    >>> [round(float(x), 3) for x in s.measures.relative.values[0]]
    [3.0, 1.0]
    """
    label = "static_sensitivity"
    held = ParameterModel(label, model, parameters)
    names = list(checks.sequence(label, "of", of, "names of signals"))
    if any(not isinstance(name, str) for name in names):
        raise InputError(f"{label}: of is {names!r}; what stands still has no mean or peak; give names of signals.")
    count = checks.count(label, "frequencies", frequencies, 0)
    if not names and not count:
        raise InputError(f"{label}: give names of signals, of=[...], or a number of frequencies.")
    mechanism = held.at(held.values)
    rest, here = static_equilibrium(mechanism), neighbour(mechanism)
    run = ParameterRun(here.program, Newmark.generalised_alpha(), Adaptive(), SECOND, None)
    none = np.zeros(here.program.n_q)
    run.begin(Start(rest.q, none, none, rest.lam))
    places, found = places_of(label, here.program, names), directions(held, here, 0.0)
    by = parameter_rates(here.program, found.numbers, found.steps)
    rows_by = signal_rows(here.program, len(by.step), places)
    run.stepper.tangents = T = new_tangents(here.program, len(found.q), by, rows_by)
    # Set T.q, T.z and the multipliers in T.u to the motion of the equilibrium; equation (14.12)
    program, flow = run.program, run.flow
    n, now = program.n_q, (flow.q, flow.v, flow.a, flow.lam, flow.z)
    tables, address, work = program.tables, program.addresses, run.stepper.second
    T.U[:], T.X[:], T.Y[:] = 0.0, 0.0, 0.0
    linearise(tables, address, 0.0, 0.0, *now, 0.0, 0.0, T, work)
    b = np.hstack([T.F[:, :n], -T.by.g])
    system = StateEvaluation(program).at(flow.q[:n], lam=flow.lam, z=flow.z, weights=(1.0, 0.0, 0.0))
    T.u[:] = system.solve(b.T, f"Motion of the equilibrium of {program.name!r}").T
    T.q[:, :n] = T.u[:, :n]
    run.find_slopes()
    units, signals = here.program.names.signals.units, run.record.signals[places]
    rows = [(name, units[k], y, slope) for name, k, y, slope in zip(names, places, signals, T.rows.now.T, strict=True)]
    if count:
        rows += _frequencies(label, here.program, rest, modes(mechanism, count, at=rest), T)
    return StaticSensitivity(measures_of(held, rows), rest)


def _frequencies(
    label: str, program: Program, rest: Equilibrium, found: Modes, T: Tangents
) -> list[tuple[str, str, float, np.ndarray]]:
    """Rows of the natural frequencies; equation (14.13)."""
    n, squares = program.n_q, (2.0 * np.pi * found.frequencies) ** 2 * np.sign(found.frequencies)
    if found.rigid or not squares.all():
        text = f"{label}: {program.name!r} has a frequency of 0 at rest"
        raise InputError(f"{text}, whose derivative is not finite. Hold its rigid motions fast.")
    system = StateEvaluation(program)
    K, M = _pencil(system, rest.q, rest.lam)
    x = found.shapes.real
    left = np.vstack([(K[:n, :n] @ x - (M[:n, :n] @ x) * squares), np.zeros((program.n_c, len(squares)))])
    system.at(rest.q, lam=rest.lam, weights=(0.0, 0.0, 1.0))
    both = np.vstack([x, -system.solve(left, f"Joint forces of the modes of {program.name!r}")[n:]])
    slopes = np.zeros((len(T.q), len(squares)))
    cuts = np.flatnonzero(np.diff(squares) > EQUAL_SQUARES * np.abs(squares[1:])) + 1  # between groups of equal squares
    for j, eps in enumerate(WIDER * T.by.step):
        sides = []
        for e in (eps, -eps, 2.0 * eps, -2.0 * eps):
            own, p = slice(*T.by.first[j : j + 2]), np.array(program.tables.p)
            p[T.by.number[own]] += e * T.by.rate[own]
            moved = StateEvaluation(replace(program, tables=program.tables.replaced(p=p)))
            sides.append(_pencil(moved, rest.q + e * T.q[j, :n], rest.lam + e * T.u[j, n:]))
        dK, dM = ((8.0 * (a - b) - (c - d)) / (12.0 * eps) for a, b, c, d in zip(*sides, strict=True))
        for group in np.split(np.arange(len(squares)), cuts):
            X = both[:, group]
            S = X.T @ (dK @ X) - squares[group[0]] * (X.T @ (dM @ X))
            slopes[j, group] = np.linalg.eigvalsh(0.5 * (S + S.T))
    slopes /= 8.0 * np.pi**2 * np.abs(found.frequencies)
    return [(f"frequency {k + 1}", "Hz", float(f), slopes[:, k]) for k, f in enumerate(found.frequencies)]


def _pencil(system: StateEvaluation, q: np.ndarray, lam: np.ndarray) -> tuple[Any, Any]:
    """[[K, G^T], [G, 0]] and [[M, 0], [0, 0]]."""
    whole = system.at(q, lam=lam, weights=(1.0, 0.0, 0.0)).matrix
    return whole, system.at(q, lam=lam, weights=(0.0, 0.0, 1.0)).matrix - system.at(q, lam=lam).matrix


LABEL = "orbit_sensitivity"
DISTANCE = 1e-3  # distance of neighbouring orbits, relative to the parameter
CORRECTIONS = 20  # largest number of corrections of a neighbouring orbit
AT_FOLD = 1e-4  # distance of a multiplier from 1 below which the orbit has no derivative
EQUAL = 1e-3  # distance of two multipliers, over their size, below which they have no derivatives of their own
DOUBTFUL = 1e-2  # error of a derivative, over its size, from which it is named
NOTHING = 1e-4  # error of a relative derivative that is never named


@record_with(repr=False)
class OrbitSensitivity(Measures):
    """Derivatives of a periodic orbit by parameters."""

    dataset: xr.Dataset = field(
        "derivatives of the start `state`, the `period`, the multipliers (`multiplier.real`, `multiplier.imag`) and "
        "of signals at instants [unit / unit of the parameter]"
    )
    measures: xr.Dataset = field(
        "`amount`, `derivative`, `relative` derivative and `error` of the derivative (NaN: not known) of period, "
        "sizes and product of the multipliers, exponents ln|multiplier| / period, and measures of signals"
    )
    orbit: PeriodicOrbit = field("the orbit")
    status: str = field("sentences on errors of the derivatives, and on missing or doubtful ones")

    def to_dataset(self) -> xr.Dataset:
        """All derivatives in one dataset."""
        return self.dataset.merge(self.measures, compat="no_conflicts")

    def __repr__(self) -> str:
        return self._below(f"OrbitSensitivity: {self.status}\n{self.orbit!r}")


@arguments.checked
def orbit_sensitivity(
    orbit: PeriodicOrbit, parameters: Sequence[str], *, of: Sequence[str | Measure] = (), save: int = SAMPLES,
    distance: float = DISTANCE, tolerance: float | None = None,
) -> OrbitSensitivity:  # fmt: skip
    """Derivatives of a periodic orbit, stable or unstable, by parameters.

    Neighbouring orbits, at four values of each parameter, give the derivatives of start, period and multipliers.  Of a
    mechanism the steps carry the derivatives of start and signals over the period, through impacts and friction.

    Parameters
    ----------
    orbit : orbit that was found.
    parameters : names of numbers of the mechanism, "B.clearance", or of parameters of the system.
    of : names of signals, and measures of signals: `mean`, `rms`, `peak`, `largest`, `smallest`; of a map the first
        two.  A signal by its name has its derivative at the saved instants, and all measures.
    save : number of intervals between the saved instants, which stay and count from the start; of a map each iteration.
    distance : distance of neighbouring orbits, relative to the parameter, or to a mechanism that is less than a length.
    tolerance : largest residual of neighbouring orbits, see `periodic_orbit`.

    Raises
    ------
    InputError : an orbit that was not found; unknown parameters and signals, with the nearest name; an orbit at a fold
        or within a family, which has a multiplier of 1; a value with refused neighbours; signals of an `ImpactODE`.
    SolveError : a neighbouring orbit that is not found; see also `sensitivity`.

    Notes
    -----
    The start keeps its phase of the drives; without drives its derivative is normal to the motion.  Multipliers that
    are nearly equal have no derivatives of their own (NaN); their product has one.  Exponents of a chaotic motion are
    no differentiable numbers.  Equations (14.14) and (14.15) of docs/theory/design.md.

    Examples
    --------
    The fixed point 1 - 1/r of the logistic map and its multiplier 2 - r:

    >>> import flexmb as fm
    >>> logistic = fm.chaos.Map(lambda x, r: r * x * (1.0 - x), [0.6], parameters={"r": 2.5})
    >>> s = fm.design.orbit_sensitivity(fm.chaos.periodic_orbit(logistic), ["r"])
    >>> round(float(s.dataset["state"][0, 0]), 8), round(float(s.dataset["multiplier.real"][0, 0]), 8)
    (0.16, -1.0)
    """
    system, held = _described(orbit, parameters)
    wanted = [measure_of(LABEL, one) for one in checks.sequence(LABEL, "of", of, "names of signals or measures")]
    is_flow = system.unit == "s"
    kinds = ["mean", "rms", *(EXTREMES if is_flow else ())]
    several = [[one] if isinstance(one, Measure) else [Measure(kind, one) for kind in kinds] for one in wanted]
    measures = [each for some in several for each in some]
    if wrong := [one.name for one in measures if one.kind not in kinds]:
        raise InputError(f"{LABEL}: an orbit of {system.name!r} has no {wrong[0]}; there are {', '.join(kinds)}.")
    if measures and isinstance(system, ImpactODE):
        text = f"{LABEL}: signals of {system.name!r} jump at impacts, which move"
        raise InputError(f"{text}; leave of= out. Orbits that start at other instants give the state there.")
    count = checks.count(LABEL, "save", save, 4) if is_flow else orbit.times
    names = list(dict.fromkeys(one.signal for one in measures))
    refuse_taken(LABEL, names, ("state", "period", "entry", "time", "value"))
    limits = tolerance_of(system, tolerance), checks.between(LABEL, "distance", distance, 1e-8, 0.1), 0.0
    if isinstance(system, MechanismFlow):
        limits = *limits[:2], system.program.length
        places_of(LABEL, system.program, names)  # refuses unknown ones
        places = []
    else:
        places = [system.names.index(checks.one_of(LABEL, "signal", one, system.names)) for one in names]
    found = [_slopes(orbit, one, limits, places, count) for one in held.parameters]
    slopes = _Numbers(*map(np.array, zip(*found, strict=True)))
    if isinstance(system, MechanismFlow):
        signals = _carried(orbit, system, held, slopes, (names or [system.names[0]], count))
    else:
        signals = _sampled(orbit, system, slopes, (places, count))
    return _tables(orbit, held, slopes, (wanted, measures, names), signals)


def _described(orbit: Any, parameters: Any) -> tuple[Dynamics, ParameterModel]:
    """System at the start of an orbit, and its parameters, or `InputError`."""
    if not isinstance(orbit, PeriodicOrbit) or not orbit.ok:
        given = f"not found: {orbit.status}" if isinstance(orbit, PeriodicOrbit) else repr(orbit)
        raise InputError(f"{LABEL}: orbit is {given}; it must be a periodic orbit that was found (`periodic_orbit`).")
    if isinstance(parameters, Mapping):
        raise InputError(f"{LABEL}: parameters is {parameters!r}; give names alone, since the orbit has its values.")
    for one in orbit.multipliers[np.abs(orbit.multipliers - 1.0) < AT_FOLD]:
        text = f"{LABEL}: the orbit has the multiplier {one:.8g}, so it is at a fold or branch point"
        raise InputError(f"{text}, or one of a family, and has no derivative. `follow` goes through folds.")
    system = orbit.system()
    if isinstance(system.underlying, MechanismFlow):
        return system, ParameterModel(LABEL, system.underlying.mechanism, parameters)

    def numbers(**_: float) -> Any:
        """A function with the parameters of the system as its arguments."""

    named = {name: value for name, value in system.parameters.items() if name.isidentifier() and not iskeyword(name)}
    own = [inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=value) for name, value in named.items()]
    numbers.__signature__ = inspect.Signature(own)  # type: ignore[attr-defined]
    return system, ParameterModel(LABEL, numbers, parameters)


class _Numbers(NamedTuple):
    """Numbers of an orbit, or their derivatives by a parameter and signed errors of these, (2, ...)."""

    state: Any  # (size,) beside that of the given orbit
    period: Any
    monodromy: Any  # (d, d)
    product: Any  # of all multipliers
    signals: Any  # (2, n, m) at the same instants, and at the same phases


def _slopes(orbit: PeriodicOrbit, one: Parameter, limits: tuple[float, ...], places: list[int], count: int) -> Any:
    """Derivatives by a parameter, and their errors, by differences of fourth order."""
    # The limits are the largest residual, the relative distance of the neighbours, the length of a mechanism or 0.
    h, slopes = limits[1] * one.size(limits[2]), []
    found = [_neighbour(orbit, (one.name, one.value + k * h), limits[0], places, count) for k in (-2.0, -1.0, 1.0, 2.0)]
    for least, less, more, most in zip(*found, strict=True):
        near, far = np.subtract(more, less) / (2.0 * h), np.subtract(most, least) / (4.0 * h)
        slopes.append(np.stack([near + (near - far) / 3.0, (near - far) / 3.0]))
    return slopes


def _neighbour(orbit: PeriodicOrbit, new: tuple[str, float], limit: float, places: list[int], count: int) -> _Numbers:
    """Numbers of the orbit with a changed parameter, after a last correction without a run."""
    shooting = orbit.shooting.copy(orbit.times, orbit.shooting.segments)
    starts, (shooting.parameter, value) = shooting.spread(orbit.state, orbit.period), new
    if starts is None or not shooting.set_value(value):
        raise InputError(f"{LABEL}: {shooting.status.rstrip('.')}. Take a value farther from the limit.")
    period = orbit.period if shooting.autonomous else shooting.period
    result = correct(shooting, starts, period, value, tolerance=limit, iterations=CORRECTIONS)
    run = result.last
    J = extended(shooting, run, None) if run is not None else None
    if not result.ok or run is None or J is None:
        text = f"{LABEL}: no orbit at {new[0]} = {value:.8g}: {result.status.rstrip('.')}"
        raise SolveError(f"{text}. A fold or the begin of an impact may lie between; give a smaller distance=.")
    step = solved(J, np.append(-run.gaps.ravel(), np.zeros(len(J) - run.gaps.size)))
    starts = shooting.moved(run, step[: run.gaps.size].reshape(run.gaps.shape))
    period, system = run.period + (float(step[-1]) if shooting.autonomous else 0.0), shooting.system
    signals = np.zeros((2, 1, 0))
    if places:
        runs = []
        for span in (orbit.period, period):
            system.reset(starts[0], time=shooting.origin)
            runs.append(sampled(system, span, count)[1][:, places])
        signals = np.array(runs)
    away = shooting.space.difference(starts[0], orbit.state)
    return _Numbers(away, period, run.monodromy, np.linalg.det(run.monodromy), signals)


class _Signals(NamedTuple):
    """Derivatives of the start (p, size) and the period (p,), of signals, and errors of the latter (m, n, p)."""

    # The rows are those of neighbours at the same phases; at the same instants, if their ends have derivatives (p,).
    state: np.ndarray
    period: np.ndarray
    found: Derivatives
    errors: np.ndarray
    ends: np.ndarray


def _sampled(orbit: PeriodicOrbit, system: Dynamics, slopes: _Numbers, asked: tuple[list[int], int]) -> _Signals:
    """Signals of maps and equations, from neighbouring orbits at the same instants."""
    places, count = asked
    state, period = slopes.state[:, 0], slopes.period[:, 0]
    time, values, _ = sampled(system, orbit.period, count)
    (still, by), (_, error) = slopes.signals.transpose(1, 2, 3, 0, 4)  # each (n, p, m)
    none = np.zeros(by.shape[:2])
    rows = [Rows(time, values[:, k], by[:, :, i], none, by[-1, :, i]) for i, k in enumerate(places)]
    found = Derivatives(time, values[:, places], still, rows, tuple(system.units[k] for k in places), 0.0, "")
    return _Signals(state, period, found, np.moveaxis(error, 2, 0), none[0])


def _carried(
    orbit: PeriodicOrbit, flow: MechanismFlow, held: ParameterModel, slopes: _Numbers, asked: tuple[list[str], int]
) -> _Signals:
    """Signals of a mechanism with derivatives that its steps carry, and the start that closes them (14.14)."""
    (names, count), program, span, p = asked, flow.program, flow.period or 1.0, len(held.parameters)
    state, period = np.array(slopes.state[:, 0]), np.array(slopes.period[:, 0])
    if orbit.time and period.any():
        raise InputError(f"{LABEL}: a parameter changes the period; find the orbit from t = 0.")
    x, rate, n = flow.state(), flow.velocity(), program.n_q
    here = Neighbour(program, Start(x[:n], x[n : 2 * n], x[-2 * n : -n], np.array(flow.run.flow.lam)))
    places, end = places_of(LABEL, program, names), orbit.time + orbit.period
    due, found = np.linspace(orbit.time, end, count + 1), directions(held, here, end)
    for _ in range(2):
        run = ParameterRun(program, flow.method, flow.step, span, span, kept=np.unique(places))
        run.begin(here.start, x[2 * n : -2 * n], time=orbit.time)
        run.record = run.record.replaced(save_times=due)
        given = found._replace(q=state[:, :n], v=state[:, n : 2 * n], z=state[:, 2 * n : -2 * n])
        result, T = carried(LABEL, Started(run, here, end, places, due), given, every=True)
        synchronise(program, run.flow, T, run.stepper.second)
        ends = np.zeros((len(x), len(T.q)))
        pack_differences(program, T, ends)
        for k in range(p):
            away, later = _closing(orbit, ends[:, k] + period[k] * rate - state[k], rate)
            state[k], period[k] = state[k] + away, period[k] + later
    result.rows[0].time[0] = orbit.time  # of all signals
    return _Signals(state, period, result, np.full((len(names), len(result.rows[0].time), p), np.nan), period)


def _closing(orbit: PeriodicOrbit, gap: np.ndarray, rate: np.ndarray) -> tuple[np.ndarray, float]:
    """Changes (size,) of a start and of a free period that close a gap (size,) of derivatives."""
    into = orbit.basis.T * orbit.shooting.space.weights
    J, right, f = orbit.monodromy - np.eye(len(into)), -into @ gap, into @ rate
    if orbit.shooting.autonomous:
        J, right = np.block([[J, f[:, None]], [f[None] / np.linalg.norm(f), np.zeros((1, 1))]]), np.append(right, 0.0)
    y = solved(J, right)
    return orbit.basis @ y[: len(into)], float(y[-1]) if orbit.shooting.autonomous else 0.0


def _tables(
    orbit: PeriodicOrbit, held: ParameterModel, slopes: _Numbers, asked: tuple[Any, ...], signals: _Signals
) -> OrbitSensitivity:
    (wanted, measures, names), own, T, unit = asked, orbit.multipliers, orbit.period, orbit.units
    by, later = _multipliers(orbit, slopes.monodromy), np.stack([signals.period, slopes.period[:, 1]], axis=1)
    rows = [("period", unit, T, later), ("product of multipliers", "", np.linalg.det(orbit.monodromy), slopes.product)]
    for k, one in enumerate(own):
        if one.imag < 0.0:
            continue  # the other one of a pair
        size, grown = abs(one), (by[..., k] / one).real
        rows.append((f"size of multiplier {k + 1}", "", size, size * grown))
        rows.append((f"exponent {k + 1}", f"1/{unit}", np.log(size) / T, (grown - np.log(size) * later / T) / T))
    for one in measures:
        k = names.index(one.signal)
        row, change = signals.found.rows[k], []
        for slope, last in ((row.slope, row.last), (signals.errors[k], signals.errors[k][-1])):
            amount, part = measured(one, row._replace(slope=slope, last=last))
            change.append(part)
        change[0] = change[0] + _of_the_end(one, amount, float(row.y[-1])) * signals.ends / T
        rows.append((one.name, signals.found.units[k], amount, np.stack(change, axis=1)))
    table = measures_of(held, [(*one[:3], one[3][:, 0]) for one in rows])
    table["error"] = ("measure", "parameter"), np.abs([one[3][:, 1] for one in rows])
    entries, both = orbit.system().state_names or {f"x{k}": k for k in range(len(orbit.state))}, "parameter"
    data: dict[str, Any] = {"state": ((both, "entry"), signals.state[:, list(entries.values())])}
    data |= {"period": (both, signals.period), "multiplier.real": ((both, "multiplier"), by[:, 0].real)}
    data["multiplier.imag"] = (both, "multiplier"), by[:, 0].imag
    for one in wanted:
        if isinstance(one, str):
            k = names.index(one)
            units = f"{signals.found.units[k] or '1'} per unit of the parameter"
            data[one] = (both, "time"), signals.found.slopes[:, :, k].T, {"units": units}
    coordinates = {"entry": list(entries), "time": ("time", signals.found.times, {"units": unit}), **told(held)}
    return OrbitSensitivity(xr.Dataset(data, coordinates), table, orbit, _status(orbit, slopes, signals, table))


def _multipliers(orbit: PeriodicOrbit, change: np.ndarray) -> np.ndarray:
    """Derivatives (..., k) of the multipliers by changes (..., d, d) of the monodromy matrix; equation (14.15)."""
    found = np.full((*change.shape[:-2], len(orbit.multipliers)), np.nan, dtype=np.complex128)
    values, left, right = scipy.linalg.eig(orbit.monodromy, left=True) if found.size else (np.zeros(0),) * 3
    for k, own in enumerate(orbit.multipliers):
        i = int(np.abs(values - own).argmin())
        if (np.abs(np.delete(values, i) - own) > EQUAL * abs(own)).all():
            row = left[:, i].conj()
            found[..., k] = (row @ change @ right[:, i]) / (row @ right[:, i])
    return found


def _of_the_end(measure: Measure, amount: float, last: float) -> float:
    """Derivative of a measure by the logarithm of the period, with a signal that stays."""
    if measure.kind == "mean":
        return last - amount
    if (measure.norm is None and measure.kind != "rms") or amount == 0.0:
        return 0.0
    p = measure.norm or 2.0
    return float(amount * (abs(last / amount) ** p - 1.0) / p)


def _status(orbit: PeriodicOrbit, slopes: _Numbers, signals: _Signals, table: xr.Dataset) -> str:
    """Sentences on the error of the derivatives of the start, and on missing or doubtful derivatives."""
    errors, length = signals.state - slopes.state[:, 0] + slopes.state[:, 1], orbit.shooting.space.length
    slope, wrong, amount, value = (table[one].values for one in ("derivative", "error", "amount", "value"))
    least = NOTHING / np.where(value == 0.0, 1.0, np.abs(value))
    each = zip(errors, signals.state, length(orbit.state) * least, strict=True)
    worst = max(length(error) / (max(length(x), floor) or 1.0) for error, x, floor in each)
    text = f"Two estimates of the derivatives of the start differ by {worst:.1e}."
    sizes = [np.abs(amount[table.unit.values == unit]).max() for unit in table.unit.values]
    doubtful = wrong > np.maximum(DOUBTFUL * np.abs(slope), np.array(sizes)[:, None] * least)
    names = table.measure.values
    found = [f"{names[k]} by {table.parameter.values[j]}" for k, j in np.argwhere(doubtful)]
    text += f" Doubtful, since neighbours at two distances differ: {display.listed(found)}." if found else ""
    missing = [str(names[k]) for k in np.flatnonzero(np.isnan(slope).any(axis=1)) if names[k].startswith("size")]
    return text + (f" Nearly equal, without derivatives of their own: {display.listed(missing)}." if missing else "")
