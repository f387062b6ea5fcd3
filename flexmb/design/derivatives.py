"""Derivatives of signals and of measures of signals by parameters, along one run."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from flexmb import arguments, checks, display
from flexmb.design.directions import directions, neighbour
from flexmb.design.measures import KINDS, Measure, Rows, measured
from flexmb.design.parameters import Model, ParameterModel
from flexmb.engine.energy import GRAVITY
from flexmb.engine.newmark.method import Newmark
from flexmb.engine.sensitivity.linearise import Tangents
from flexmb.engine.sensitivity.parameter_run import ParameterRun
from flexmb.engine.state.record import DONE
from flexmb.engine.step.method import Method
from flexmb.engine.step.step_size import Adaptive
from flexmb.errors import InputError, SolveError
from flexmb.model.part import refuse_controllers
from flexmb.program.compiler import common_period
from flexmb.program.program import Program
from flexmb.results.naming import chosen_places, long_name
from flexmb.run.saving import save_grid
from flexmb.run.simulate import Step, check_end, period_or_none, prepared

if TYPE_CHECKING:
    import xarray as xr

LABEL = "sensitivity"

RTOL_OF_FIXED_STEPS = 1e-6
"""Accuracy of runs with fixed steps, for the horizon of their derivatives."""


@dataclass(frozen=True)
class Sensitivity(display.Inside):
    """Derivatives of signals and of their measures by parameters.

    `s["slider.x"]` is the derivative of a signal, `(parameter, time)`; `s.value["slider.x"]` the signal itself.

    Attributes
    ----------
    parameters : names, values and units of the parameters are `s.dataset.parameter`, `value` and `unit` beside it.
    dataset : derivatives of the signals [unit of the signal / unit of the parameter], xarray.
    signals : the signals themselves, xarray.
    measures : value, derivatives and relative derivatives of each measure, xarray along `measure` and `parameter`.
    growth : factor by which a small difference of the state grew during the run.
    status : sentence on the end of the run.
    """

    dataset: xr.Dataset
    signals: xr.Dataset
    measures: xr.Dataset
    growth: float
    status: str

    def __getitem__(self, name: str) -> xr.DataArray:
        """Derivative of a signal at the saved instants, (parameter, time).

        Parameters
        ----------
        name : name of a signal that was asked for.
        """
        checks.one_of("Sensitivity", "signal", name, [str(key) for key in self.dataset.data_vars])
        return self.dataset[name]

    def table(self) -> list[tuple[str, ...]]:
        """Rows of texts: measure, its value, then for each parameter derivative, unit and relative derivative."""
        rows, own = [], self.measures
        for name in own.measure.values.tolist():
            one = own.sel(measure=name)
            for parameter in own.parameter.values.tolist():
                at = one.sel(parameter=parameter)
                unit = _per(str(at.unit.item()), str(at.unit_of_parameter.item()))
                rows.append((name, parameter, f"{float(at.derivative):.6g}", unit, f"{float(at.relative):.4g}"))
        return rows

    def __repr__(self) -> str:
        head = ("measure", "parameter", "derivative", "unit", "relative")
        rows = [head, *self.table()]
        widths = [max(len(row[k]) for row in rows) for k in range(len(head))]
        lines = ["  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True)).rstrip() for row in rows]
        return "\n".join([f"Sensitivity: {self.status} A small difference grew by {self.growth:.3g}.", *lines])


def _per(unit: str, other: str) -> str:
    return f"{unit or '1'}/{f'({other})' if ' ' in other or '/' in other else other or '1'}"


@arguments.checked
@np.errstate(all="ignore")
def sensitivity(
    model: Model,
    parameters: Iterable[str] | Mapping[str, float],
    *,
    of: Sequence[str | Measure],
    t_end: float | None = None,
    periods: float | None = None,
    save: int | float | Sequence[float] | np.ndarray = 1000,
    step: Step | None = None,
    method: Method | None = None,
) -> Sensitivity:
    """Derivatives of signals by parameters, through impacts and friction, along one run.

    The steps of a run carry the derivatives of its state; start values, drives and the equations of motion contribute
    their derivatives by the parameters.  Instants stay: `periods` are those of the present parameters.

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
    step, method : as in `simulate`; methods of the Newmark family alone.

    Returns
    -------
    Sensitivity : derivatives with units, elasticities, and the growth of small differences.

    Raises
    ------
    InputError : unknown parameters and signals, with the nearest name; whole numbers and switches; parameters that
        change the structure of the equations or move kinks of drives in time; other methods; controllers; works and
        losses, which are sums over all steps (measure the power).
    SolveError : a run that fails, or a motion in which a small difference grew by more than 1 / rtol: derivatives
        beyond this horizon, ln(1 / rtol) over the exponent, say nothing.

    Notes
    -----
    Equations (10.1) to (10.7) of docs/theory/design.md.
    """
    held = ParameterModel(LABEL, model, parameters)
    mechanism = held.at(held.values)
    refuse_controllers(mechanism, LABEL, "derivatives by parameters do not pass through controllers")
    method, chosen, program, _ = prepared(LABEL, mechanism, method, step, "refuse")
    if not isinstance(method, Newmark):
        raise InputError(f"{LABEL}: method is {method!r}; it must be Newmark(...), whose steps carry derivatives.")
    period = common_period(program) if periods is not None else period_or_none(program)
    if (t_end is None) == (periods is None):
        raise InputError(f"{LABEL}: give either t_end= (seconds) or periods= (of the drives).")
    end = check_end(LABEL, t_end) if t_end is not None else checks.positive(LABEL, "periods", periods) * period  # type: ignore[operator]
    wanted = [_measure(one) for one in checks.sequence(LABEL, "of", of, "names of signals or measures")]
    places = _places(program, [_signal(one) for one in wanted])
    grid = save_grid(LABEL, save, period, 0.0, end)
    due = _instants(grid.interval, grid.times, end)
    here = neighbour(mechanism)
    found = directions(held, here, end)
    run = ParameterRun(program, method, chosen, end, period, mechanism=mechanism, kept=np.unique(places))
    run.begin(here.start)
    run.record = run.record.replaced(save_times=due)
    first = run.record.signals[places]
    T = run.carry(end, found, _probe(program), places, due)
    growth = run.growth
    _refuse_failed(run, growth, chosen)
    return _result(held, program, wanted, places, first, run, T)


def _measure(one: Any) -> Measure | str:
    if isinstance(one, (str, Measure)):
        return one
    raise InputError(f"{LABEL}: of holds {one!r}; it must hold names of signals, and measures such as rms('slider.ax').")


def _signal(one: Measure | str) -> str:
    return one if isinstance(one, str) else one.signal


def _places(program: Program, names: Sequence[str]) -> np.ndarray:
    """Places of signals among all signals; works and losses, and numbers of states or places, are refused."""
    energy = program.tables.sizes.energy
    modes, found = set(np.asarray(program.tables.measured.modes).tolist()), []
    for name in names:
        place = int(chosen_places(LABEL, program, [name])[0])  # type: ignore[index]
        if place > energy + GRAVITY:
            text = f"{LABEL}: {name!r} is a sum over all steps, whose derivative is not carried"
            raise InputError(f"{text}. Ask for the mean of a power.")
        if place in modes:
            raise InputError(f"{LABEL}: {name!r} numbers states or places, so it has no derivative.")
        found.append(place)
    return np.array(found, dtype=np.int64)


def _instants(interval: float, times: np.ndarray, end: float) -> np.ndarray:
    """Saved instants (n,) with start and end [s]."""
    if interval == 0.0:
        raise InputError(f"{LABEL}: save is 'steps'; give a number of instants, an interval or times.")
    grid = times if len(times) else interval * np.arange(math.floor(end / interval * (1.0 + 1e-9)) + 1)
    inner = grid[(grid > 0.0) & (grid < end * (1.0 - 1e-9))]
    return np.concatenate([[0.0], inner, [end]])


def _probe(program: Program) -> tuple[np.ndarray, np.ndarray]:
    """A difference of positions and velocities (n_q,) in all directions, whose growth is that of all small ones."""
    away = np.random.default_rng(0).standard_normal((2, program.n_q)) * program.sizes
    return away[0], away[1]


def _refuse_failed(run: ParameterRun, growth: float, step: Any) -> None:
    rtol = step.rtol if isinstance(step, Adaptive) else RTOL_OF_FIXED_STEPS
    if growth * rtol > 1.0 or not math.isfinite(growth):
        raise SolveError(
            f"{LABEL}: a small difference grew by {growth:.3g} until t = {float(run.flow.clock.t):.4g} s, more than "
            f"1/rtol = {1.0 / rtol:.3g}: derivatives say nothing there. End the run earlier."
        )
    if run.note or run.code != DONE:
        raise SolveError(f"{LABEL}: the run failed: {run.status()}")


def _result(
    held: ParameterModel,
    program: Program,
    wanted: Sequence[Measure | str],
    places: np.ndarray,
    first: np.ndarray,
    run: ParameterRun,
    T: Tangents,
) -> Sensitivity:
    """Data sets of a run that has ended."""
    import xarray as xr

    m, p, units = len(places), len(held.parameters), program.names.signals.units
    times, values = run.saved.finished()
    column = {int(place): k for k, place in enumerate(np.unique(places))}
    slopes = T.rows.slopes.reshape(len(times), -1, m)[:, :p]
    along = {"parameter": list(held.names), "time": ("time", times, {"units": "s"})}
    told = {"value": ("parameter", list(held.values)), "unit_of_parameter": ("parameter", _units(held))}
    found, signals = {}, {}
    for k, one in enumerate(wanted):
        if isinstance(one, Measure):
            continue
        unit = units[places[k]]
        found[one] = (("parameter", "time"), slopes[:, :, k].T, {"units": f"{unit or '1'} per unit of the parameter"})
        signals[one] = ("time", values[:, column[int(places[k])]], {"units": unit, "long_name": long_name(one)})
    rows = run.rows(first, slopes)
    measures = []
    for k, one in enumerate(wanted):
        every = [one] if isinstance(one, Measure) else [Measure(kind, one) for kind in KINDS]
        measures += [(each, units[places[k]], *measured(each, rows(k))) for each in every]
    derivative = np.array([row[3][:p] for row in measures]).reshape(len(measures), p)
    value = np.array([row[2] for row in measures])
    relative = derivative * np.array(held.values) / value[:, None]
    own = xr.Dataset(
        {
            "amount": ("measure", value),
            "derivative": (("measure", "parameter"), derivative),
            "relative": (("measure", "parameter"), relative),
        },
        {
            "measure": [row[0].name for row in measures],
            "parameter": list(held.names),
            "unit": ("measure", [row[1] for row in measures]),
            **told,
        },
    )
    return Sensitivity(xr.Dataset(found, along | told), xr.Dataset(signals, {"time": along["time"]}), own, run.growth, run.status())


def _units(held: ParameterModel) -> list[str]:
    return [one.unit for one in held.parameters]
