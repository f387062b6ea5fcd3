"""Derivatives of signals and of measures by parameters, along one run; spread of measures where parameters scatter."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import Executor
from typing import Any, NamedTuple

import numpy as np

from flexmb import arguments, checks, display
from flexmb.design.measures import KINDS, Measure, Rows, measured
from flexmb.design.parameters import Model, Neighbour, ParameterModel, box_points, directions, neighbour, refuse_taken
from flexmb.dynamics.sweeps.parameter_sweep import RESERVED, sweep
from flexmb.engine.energy import GRAVITY
from flexmb.engine.newmark.method import Newmark
from flexmb.engine.sensitivity.linearise import Tangents
from flexmb.engine.sensitivity.parameter_run import Directions, ParameterRun
from flexmb.engine.state.record import DONE
from flexmb.engine.step.method import Method
from flexmb.engine.step.step_size import Adaptive
from flexmb.errors import InputError, SolveError
from flexmb.fields import Input, field, positive, record, record_with
from flexmb.late import scipy, xr
from flexmb.model.signal import hint, resolved
from flexmb.program.compiler import common_period
from flexmb.program.program import Program
from flexmb.results.netcdf import long_name
from flexmb.run.saving import save_grid
from flexmb.run.simulate import Step, check_end, period_or_none, prepared, simulate

RTOL_OF_FIXED_STEPS = 1e-6  # accuracy of runs with fixed steps, for the horizon of their derivatives


class Span(NamedTuple):
    """End of a run, t_end [s] or periods of the drives; saved instants, step and method as in `simulate`."""

    t_end: float | None
    periods: float | None
    save: Any
    step: Step | None
    method: Method | None


class Derivatives(NamedTuple):
    """Signals along a run and their derivatives by p parameters."""

    times: np.ndarray  # (n,) [s]
    values: np.ndarray  # (n, m)
    slopes: np.ndarray  # (n, p, m)
    rows: Sequence[Rows]  # of each signal, at all steps; empty if these were not wanted
    units: tuple[str, ...]
    growth: float  # of a small difference of the state
    status: str


class Started(NamedTuple):
    """A run of a parameter model at its start."""

    run: ParameterRun
    here: Neighbour
    end: float
    places: np.ndarray  # of the signals
    due: np.ndarray  # saved instants, with start and end

    def values(self, label: str) -> tuple[np.ndarray, np.ndarray]:
        """Saved instants and signals (n, m) of the run, which has ended."""
        if self.run.note or self.run.code != DONE:
            raise SolveError(f"{label}: the run failed: {self.run.status()}")
        times, values = self.run.saved.finished()
        return times, values[:, np.searchsorted(np.unique(self.places), self.places)]


def started(label: str, held: ParameterModel, span: Span, signals: Sequence[str]) -> Started:
    """Run of a parameter model that keeps `signals`, at its start, or `InputError`."""
    mechanism = held.at(held.values)
    method = Newmark.generalised_alpha() if span.method is None else span.method
    if not isinstance(method, Newmark) or not method.has_tangent:
        text = f"{label}: method is {method!r}; only the steps of Newmark(...) itself carry derivatives"
        raise InputError(f"{text}. Leave method out, or give Newmark.generalised_alpha() and a smaller rtol.")
    _, step, program, _ = prepared(label, mechanism, method, span.step, "refuse")
    if (span.t_end is None) == (span.periods is None):
        raise InputError(f"{label}: give either t_end= (seconds) or periods= (of the drives).")
    period = common_period(program) if span.periods is not None else period_or_none(program)
    wanted = checks.positive(label, "periods", span.periods) * (period or 0.0) if span.t_end is None else span.t_end
    end, places = check_end(label, wanted), places_of(label, program, signals)
    # Saved instants (n,) with start and end [s]
    grid = save_grid(label, span.save, period, 0.0, end)
    if grid.interval == 0.0:
        raise InputError(f"{label}: save is 'steps'; give a number of instants, an interval or times.")
    many = math.floor(end / grid.interval * (1.0 + 1e-9)) + 1
    times = grid.times if len(grid.times) else grid.interval * np.arange(many)
    due = np.concatenate([[0.0], times[(times > 0.0) & (times < end * (1.0 - 1e-9))], [end]])
    here = neighbour(mechanism)
    run = ParameterRun(program, method, step, end, period, mechanism=mechanism, kept=np.unique(places))
    run.begin(here.start)
    run.record = run.record.replaced(save_times=due)
    return Started(run, here, end, places, due)


@np.errstate(all="ignore")
def signals_along(label: str, held: ParameterModel, span: Span, signals: Sequence[str]) -> tuple[np.ndarray, Any]:
    """Signals (n, m) at the saved instants of a run without derivatives, and their units."""
    begun = started(label, held, span, signals)
    begun.run.run_to(begun.end, saving=float(np.diff(begun.due).min()))
    return begun.values(label)[1], tuple(begun.run.program.names.signals.units[k] for k in begun.places)


@np.errstate(all="ignore")
def derivatives(label: str, held: ParameterModel, span: Span, signals: Sequence[str], *, every: bool) -> Derivatives:
    """Derivatives of `signals` by the parameters of a model; with rows of `every` step."""
    begun = started(label, held, span, signals)
    return carried(label, begun, directions(held, begun.here, begun.end), every=every)[0]


def carried(label: str, begun: Started, found: Directions, *, every: bool) -> tuple[Derivatives, Tangents]:
    """Signals of a run with their derivatives in given directions, and the differences of the state at its end."""
    run, places = begun.run, begun.places
    first = run.record.signals[places]
    T = run.carry(begun.here.start, begun.end, found, places, begun.due, every=every)
    rtol = run.step.rtol if isinstance(run.step, Adaptive) else RTOL_OF_FIXED_STEPS
    if run.growth * rtol > 1.0 or not math.isfinite(run.growth):
        text = f"{label}: a small difference grew by {run.growth:.3g} until t = {float(run.flow.clock.t):.4g} s,"
        text += f" more than 1/rtol = {1.0 / rtol:.3g}"
        raise SolveError(f"{text}: derivatives say nothing there. End the run earlier.")
    times, chosen = begun.values(label)
    slopes = T.rows.slopes.reshape(len(times), len(T.q), -1)[:, : len(found.q), : len(places)]
    rows: list[Rows] = []
    if every:
        time, y, slope, shift = run.rows(first, slopes[0])
        rows = [Rows(time, y[:, k], slope[:, :, k], shift, slopes[-1, :, k]) for k in range(y.shape[1])]
    units = tuple(run.program.names.signals.units[k] for k in places)
    return Derivatives(times, chosen, slopes, rows, units, run.growth, run.status()), T


def places_of(label: str, program: Program, names: Sequence[str]) -> np.ndarray:
    """Places of signals among all signals; works and losses, and numbers of states or places, are refused."""
    modes, found = set(np.asarray(program.tables.measured.modes).tolist()), []
    signals, aliases = program.names.signals, program.names.aliases
    for name in names:
        place = signals.places.get(resolved(name, signals, aliases), -1)
        if place < 0:
            raise InputError(f"{label}: no signal is called {name!r}. {hint(name, program.reported, aliases)}")
        if place > program.tables.sizes.energy + GRAVITY:
            text = f"{label}: {name!r} is a sum over all steps, whose derivative is not carried"
            raise InputError(f"{text}. Ask for the mean of a power.")
        if place in modes:
            raise InputError(f"{label}: {name!r} numbers states or places, so it has no derivative.")
        found.append(place)
    return np.array(found, dtype=np.int64)


# Table of derivatives, elasticities
class Measures(display.Inside):
    """Base of results with a table of measures."""

    measures: xr.Dataset

    def table(self) -> list[tuple[str, ...]]:
        """Rows of texts: measure, parameter, derivative, its unit, relative derivative."""
        measures, rows = self.measures, list[tuple[str, ...]]()
        for i, name in enumerate(measures.measure.values.tolist()):
            for k, parameter in enumerate(measures.parameter.values.tolist()):
                other = str(measures.unit_of_parameter.values[k])
                below = f"({other})" if " " in other or "/" in other else other or "1"
                unit = f"{str(measures.unit.values[i]) or '1'}/{below}"
                derivative, relative = (float(measures[one].values[i, k]) for one in ("derivative", "relative"))
                rows.append((name, parameter, f"{derivative:.6g}", unit, f"{relative:.4g}"))
        return rows

    def _below(self, head: str) -> str:
        """The table below a `head`."""
        return f"{head}\n{columns(('measure', 'parameter', 'derivative', 'unit', 'relative'), self.table())}"


@record_with(repr=False)
class Sensitivity(Measures):
    """Derivatives of signals and of their measures by parameters.

    `s["slider.x"]` is the derivative of a signal, (parameter, time); `s.signals["slider.x"]` the signal itself.
    """

    dataset: xr.Dataset = field(
        "derivatives of the signals [unit of the signal / unit of the parameter], with the values and units of the "
        "parameters beside them"
    )
    signals: xr.Dataset = field("the signals themselves")
    measures: xr.Dataset = field("`amount`, `derivative`, `relative` derivative (no number of 0) by measure")
    growth: float = field("factor by which a small difference of the state grew during the run")
    status: str = field("sentence on the end of the run")

    def __getitem__(self, name: str) -> xr.DataArray:
        """Derivative of a signal, by its `name`, at the saved instants, (parameter, time)."""
        checks.one_of("Sensitivity", "signal", name, [str(key) for key in self.dataset.data_vars])
        return self.dataset[name]

    def __repr__(self) -> str:
        return self._below(f"Sensitivity: {self.status} A small difference grew by {self.growth:.3g}.")


def columns(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Lines of a table in columns."""
    widths = [max(len(row[k]) for row in [head, *rows]) for k in range(len(head))]
    return "\n".join("  ".join(map(str.ljust, row, widths)).rstrip() for row in [head, *rows])


@arguments.checked
def sensitivity(
    model: Model, parameters: Iterable[str] | Mapping[str, float], *, of: Sequence[str | Measure],
    t_end: float | None = None, periods: float | None = None, save: int | float | Sequence[float] | np.ndarray = 1000,
    step: Step | None = None, method: Method | None = None,
) -> Sensitivity:  # fmt: skip
    """Derivatives of signals by parameters, through impacts and friction, along one run.

    The steps of the run carry the derivatives of its state: start values, drives and the equations of motion change
    with the parameters.  Instants stay: `periods` are those of the present parameters.

    Parameters
    ----------
    model : a mechanism, or a function of numbers that returns one.
    parameters : names of numbers of the mechanism, "B.clearance" or "B.normal.restitution", or of arguments of the
        function; or their values by name.
    of : names of signals, and measures of signals: `mean`, `rms`, `peak`, `at_end`.  A signal by its name has its
        derivative at all saved instants, and all four measures.
    t_end : end [s]; or
    periods : number of common periods of the drives.
    save : instants of the derivatives, as in `simulate`.
    step, method : as in `simulate`; methods of the Newmark family alone, with the steps of flexmb.

    Raises
    ------
    InputError : unknown parameters and signals, with the nearest name; whole numbers and switches; parameters that
        change the structure of the equations or move kinks of drives in time; other methods; works and
        losses, which are sums over all steps.
    SolveError : a run that fails; a motion in which a small difference grew by more than 1/rtol, since derivatives
        beyond this horizon, ln(1/rtol) over the exponent, say nothing.

    Notes
    -----
    Equations (14.1) to (14.9) of docs/theory/design.md.
    """
    label = "sensitivity"
    held = ParameterModel(label, model, parameters)
    wanted = [measure_of(label, one) for one in checks.sequence(label, "of", of, "names of signals or measures")]
    if not wanted:
        raise InputError(f"{label}: of is empty; give names of signals, or measures such as rms('slider.ax').")
    names = [one if isinstance(one, str) else one.signal for one in wanted]
    found = derivatives(label, held, Span(t_end, periods, save, step, method), names, every=True)
    time = ("time", found.times, {"units": "s"})
    slopes, signals, measures = {}, {}, []
    for k, one in enumerate(wanted):
        unit, kinds = found.units[k], [one] if isinstance(one, Measure) else [Measure(kind, one) for kind in KINDS]
        measures += [(each.name, unit, *measured(each, found.rows[k])) for each in kinds]
        if isinstance(one, str):
            attributes = {"units": f"{unit or '1'} per unit of the parameter"}
            slopes[one] = (("parameter", "time"), found.slopes[:, :, k].T, attributes)
            signals[one] = ("time", found.values[:, k], {"units": unit, "long_name": long_name(one)})
    whole = xr.Dataset(slopes, {"time": time, **told(held)}), xr.Dataset(signals, {"time": time})
    return Sensitivity(*whole, measures_of(held, measures), found.growth, found.status)


def measure_of(label: str, one: Any) -> Measure | str:
    """A measure or the name of a signal, or `InputError`."""
    if isinstance(one, (str, Measure)):
        return one
    text = f"{label}: {one!r} is neither the name of a signal nor a measure"
    raise InputError(f"{text}; give 'slider.ax' or rms('slider.ax').")


def told(held: ParameterModel) -> dict[str, Any]:
    """Names, values and units of the parameters, as coordinates."""
    columns = {"value": list(held.values), "unit_of_parameter": [one.unit for one in held.parameters]}
    return {"parameter": list(held.names), **{name: ("parameter", column) for name, column in columns.items()}}


def measures_of(held: ParameterModel, rows: Sequence[tuple[str, str, float, np.ndarray]]) -> xr.Dataset:
    """Amounts, derivatives and relative derivatives of rows of name, unit, amount and derivatives (p,)."""
    labels, units, amounts, changes = zip(*rows, strict=True)
    derivative, amount = np.array(changes).reshape(len(amounts), -1), np.array(amounts)
    with np.errstate(all="ignore"):
        relative = derivative * np.array(held.values) / amount[:, None]
    both = ("measure", "parameter")
    found = {"amount": ("measure", amount), "derivative": (both, derivative), "relative": (both, relative)}
    return xr.Dataset(found, {"measure": list(labels), "unit": ("measure", list(units)), **told(held)})


TAILS = (0.05, 0.95)  # quantiles of the samples that are told


@record
class Normal(Input):
    """Normal distribution of a parameter.

    Raises
    ------
    InputError : a deviation that is not positive.
    """

    mean: float = field("mean value")
    deviation: float = field("standard deviation", rule=positive)

    def quantile(self, u: np.ndarray) -> np.ndarray:
        """Values below which parts u of all lie."""
        return np.asarray(scipy.stats.norm.ppf(u, self.mean, self.deviation))


@record
class Uniform(Input):
    """Uniform distribution of a parameter.

    Raises
    ------
    InputError : bounds that are not low < high.
    """

    low: float = field("lower bound")
    high: float = field("upper bound")

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.low < self.high:
            raise InputError(f"Uniform: low is {self.low:g}, high is {self.high:g}; low must be below high.")

    @property
    def mean(self) -> float:
        """Mean value."""
        return 0.5 * (self.low + self.high)

    @property
    def deviation(self) -> float:
        """Standard deviation."""
        return float((self.high - self.low) / 12.0**0.5)

    def quantile(self, u: np.ndarray) -> np.ndarray:
        """Values below which parts u of all lie."""
        return self.low + u * (self.high - self.low)


@record_with(repr=False)
class Spread(display.Inside):
    """Spread of measures."""

    first_order: xr.Dataset | None = field(
        "by measure: `amount` at the means of the parameters, `deviation`, and the `share` of each parameter in the "
        "variance; None if small differences grow so far that derivatives say nothing"
    )
    samples: xr.Dataset | None = field("each sampled machine: parameters, measures, status; None without samples")
    statistics: xr.Dataset | None = field("`mean`, `deviation`, quantiles `low` and `high` (5, 95 %) of each measure")
    indices: xr.Dataset | None = field("Sobol's indices `first`, `total` by measure and parameter; None: not asked")
    message: str = field("sentence on failed samples and on derivatives")

    def __repr__(self) -> str:
        head, rows = ["measure"], []
        tables = [one for one in (self.first_order, self.statistics) if one is not None]
        for name in tables[0].measure.values.tolist():
            row = [name]
            for table, words in ((self.first_order, ("amount", "deviation")), (self.statistics, tuple(STATISTICS))):
                row += [f"{float(table[word].sel(measure=name)):.6g}" for word in words] if table is not None else []
            rows.append(tuple(row))
        head += ["first order: value", "deviation"] if self.first_order is not None else []
        head += ["samples: mean", "deviation", "5 %", "95 %"] if self.statistics is not None else []
        return f"Spread: {self.message}\n{columns(tuple(head), rows)}"


STATISTICS = ("mean", "deviation", "low", "high")  # variables of `Spread.statistics`


@arguments.checked
def spread(
    model: Model, parameters: Mapping[str, Normal | Uniform], *, of: Sequence[Measure], t_end: float | None = None,
    periods: float | None = None, samples: int = 64, sobol: bool = False, executor: Executor | None = None,
    store: Any = None, resume: bool = False, step: Step | None = None, method: Method | None = None,
) -> Spread:  # fmt: skip
    """Spread of measures over machines whose numbers scatter independently.

    To first order, by the derivatives at the means; and by samples (Sobol's sequence).

    Parameters
    ----------
    model : a mechanism, or a function of numbers that returns one.
    parameters : `Normal(mean, deviation)` or `Uniform(low, high)` by name.
    of : measures such as `peak("B.normal_force", norm=16)`.
    t_end : end [s]; or
    periods : number of common periods of the drives.
    samples : number of sampled machines; 0: first order alone.
    sobol : whether Sobol's indices are estimated, by samples x (parameters + 2) machines; a power of 2 then.
    executor, store, resume : as in `sweep`, for the samples.
    step, method : as in `simulate`.

    Raises
    ------
    InputError : unknown parameters or signals, other distributions; for Sobol's indices samples that are no power of 2.
    SolveError : a run at the means that fails; fewer than two samples that succeed.
    """
    label = "spread"
    laws = checks.mapping(label, "parameters", parameters)
    for name, law in laws.items():
        if not isinstance(law, (Normal, Uniform)):
            raise InputError(f"{label}: {name} is {law!r}; give Normal(mean, deviation) or Uniform(low, high).")
    wanted = checks.sequence(label, "of", of, "measures")
    measures = [one for k, one in enumerate(wanted) if isinstance(one, Measure) and one not in wanted[:k]]
    if not measures or len(measures) < len(wanted):
        raise InputError(f"{label}: of is {wanted!r}; give measures such as peak('B.fx', norm=16), each of them once.")
    refuse_taken(label, laws, ("machine", *RESERVED))
    held = ParameterModel(label, model, {name: law.mean for name, law in laws.items()})
    text = []
    try:
        first = _first_order(held, list(laws.values()), measures, Span(t_end, periods, 1, step, method))
    except SolveError as error:
        if samples == 0:
            raise
        first = None
        text.append(f"No first order: {str(error).removeprefix(label + ': ')}")
    if checks.count(label, "samples", samples, 0) == 0:
        return Spread(first, None, None, None, " ".join(text) or "First order alone.")
    if samples == 1 or (sobol and samples & (samples - 1)):
        raise InputError(f"{label}: samples is {samples}; statistics need two or more, Sobol's indices a power of 2.")
    values = _points(list(laws.values()), samples, blocks=len(laws) + 2 if sobol else 1)
    how = {"t_end": t_end, "periods": periods, "step": step, "method": method}
    fixed = {"model": model, "measures": tuple(measures), "names": tuple(laws), "table": values, "how": how}
    machines = {"machine": list(range(len(values)))}
    found = sweep(sampled, machines, fixed=fixed, executor=executor, store=store, resume=resume)
    found = found.assign({name: ("machine", values[:, k]) for k, name in enumerate(laws)})
    names, good = [one.name for one in measures], np.asarray(found["ok"].values, dtype=bool)
    if good.sum() < 2:
        raise SolveError(f"{label}: {int(good.sum())} of {len(good)} samples succeeded: {found['status'].values[0]}")
    text.append(f"{int(good.sum())} of {len(good)} samples succeeded.")
    table = np.stack([found[name].values for name in names])
    usual = table[:, : 2 * samples] if sobol else table
    indices = _indices(table.reshape(len(names), -1, samples), names, list(laws)) if sobol and good.all() else None
    if sobol and indices is None:
        text.append("No Sobol's indices: they need all samples.")
    rows = np.nanmean(usual, axis=1), np.nanstd(usual, axis=1, ddof=1), *np.nanquantile(usual, TAILS, axis=1)
    named = {name: ("measure", row) for name, row in zip(STATISTICS, rows, strict=True)}
    statistics = xr.Dataset(named, {"measure": names})
    return Spread(first, found, statistics, indices, " ".join(text))


def sampled(
    model: Model, measures: Sequence[Measure], names: Sequence[str], table: np.ndarray, how: Mapping[str, Any],
    machine: int,
) -> dict[str, float]:  # fmt: skip
    """Measures of one machine by their names; table : parameters (machines, n), how : arguments of the run."""
    held = ParameterModel("spread", model, dict(zip(names, table[int(machine)].tolist(), strict=True)))
    given = {key: one for key, one in how.items() if one is not None}
    signals = list(dict.fromkeys(one.signal for one in measures))
    sol = simulate(held.at(held.values), **given, save="steps", signals=signals)
    sol.require()
    time, found = np.asarray(sol.time), {}
    for one in measures:
        y = np.asarray(sol[one.signal])
        found[one.name], _ = measured(one, Rows(time, y, np.zeros((len(y), 0)), np.zeros((len(y), 0)), np.zeros(0)))
    return found


def _first_order(held: ParameterModel, laws: Sequence[Any], measures: Sequence[Measure], span: Span) -> xr.Dataset:
    signals = list(dict.fromkeys(one.signal for one in measures))
    found = derivatives("spread", held, span, signals, every=True)
    amounts, slopes = zip(*(measured(one, found.rows[signals.index(one.signal)]) for one in measures), strict=True)
    parts = (np.array(slopes) * [law.deviation for law in laws]) ** 2
    variance = parts.sum(axis=1)
    with np.errstate(all="ignore"):
        share = parts / variance[:, None]
    data: dict[str, Any] = {"amount": ("measure", np.array(amounts)), "deviation": ("measure", np.sqrt(variance))}
    data["share"] = (("measure", "parameter"), share)
    return xr.Dataset(data, {"measure": [one.name for one in measures], "parameter": list(held.names)})


def _points(laws: Sequence[Any], samples: int, *, blocks: int) -> np.ndarray:
    """Sampled parameters (blocks x samples, n); blocks of Sobol's indices: A, B, and A with each column of B."""
    n = len(laws)
    u = box_points(samples, n if blocks == 1 else 2 * n)
    if blocks > 1:
        A, B = u[:, :n], u[:, n:]
        u = np.concatenate([A, B, *(np.where(np.arange(n) == k, B, A) for k in range(n))])
    u = np.clip(u, 1e-12, 1.0 - 1e-12)
    return np.stack([law.quantile(u[:, k]) for k, law in enumerate(laws)], axis=1)


def _indices(blocks: np.ndarray, names: Sequence[str], parameters: Sequence[str]) -> xr.Dataset:
    """Sobol's indices by scipy from the blocks (measures, parameters + 2, samples)."""
    blocks = np.concatenate([blocks, blocks[:1]])  # scipy fails with one measure of one parameter
    given = {"f_A": blocks[:, 0], "f_B": blocks[:, 1], "f_AB": blocks[:, 2:].transpose(1, 0, 2)}
    found = scipy.stats.sobol_indices(func=given, n=blocks.shape[2])
    both = ("measure", "parameter")
    first, total = (np.reshape(one, (len(blocks), -1))[:-1] for one in (found.first_order, found.total_order))
    return xr.Dataset({"first": (both, first), "total": (both, total)}, {"measure": names, "parameter": parameters})
