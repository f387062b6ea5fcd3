"""Fits: parameters of a mechanism from measured signals, with errors, correlations and what cannot be told apart."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from flexmb import arguments, checks, display
from flexmb.design.derivatives import Derivatives, HorizonError, Span, columns, derivatives
from flexmb.design.parameters import Model, ParameterModel
from flexmb.engine.step.method import Method
from flexmb.errors import FlexmbError, InputError
from flexmb.run.simulate import Step

if TYPE_CHECKING:
    import xarray as xr

HARDLY_SEEN = 1e-7
"""Singular value of the scaled derivatives, over the largest, below which a combination of parameters is not seen."""

MEMBER = 0.1
"""Share of a parameter in such a combination from which it is named."""

PARTS = (*np.geomspace(0.01, 1.0, 25).tolist(),)
"""Parts of the data, from the begin on, that are fitted one after the other.

The sum of squares has many minima where small differences grow much; those of a shorter span are wider.  Residuals are
integrated over the time at first, since peaks of computed and measured impacts need not overlap; their integrals do.
"""

REFUSED = 1e3
"""Residuals of a run that fails, over those of the first run, so that the search turns back."""


@dataclass(frozen=True, repr=False)
class Fit(display.Inside):
    """Fitted parameters.

    Attributes
    ----------
    parameters, errors, bounds : value, standard error and bounds of each parameter, by name.
    correlation : (n, n) correlations, in the order of the parameters.
    offsets : fitted constant offsets by signal.
    unseen : combinations of parameters that the data do not tell apart, as texts.
    residuals : measured less computed signals, xarray.
    rms : root of the mean square of the residuals over their noise levels.
    runs : number of runs that were made.
    ok, message : whether the search converged, and a sentence on its end.
    """

    parameters: dict[str, float]
    errors: dict[str, float]
    bounds: dict[str, tuple[float, float]]
    correlation: np.ndarray
    offsets: dict[str, float]
    unseen: tuple[str, ...]
    residuals: xr.Dataset
    rms: float
    runs: int
    ok: bool
    message: str

    def __repr__(self) -> str:
        names = tuple(self.parameters)
        head = ("parameter", "value", "standard error", "bounds", *(f"with {name}" for name in names))
        rows = [
            (
                name,
                f"{self.parameters[name]:.6g}",
                f"{self.errors[name]:.2g}",
                "{:g} to {:g}".format(*self.bounds[name]),
                *(f"{x:.3f}" for x in self.correlation[k]),
            )
            for k, name in enumerate(names)
        ]
        lines = [f"Fit: {self.message} {self.runs} runs, residuals {self.rms:.3g} of the noise.", columns(head, rows)]
        lines += [f"Offset of {name}: {value:.6g}" for name, value in self.offsets.items()]
        return "\n".join([*lines, *(f"Not told apart by the data: {text}." for text in self.unseen)])


@arguments.checked
def fit(
    model: Model,
    parameters: Mapping[str, tuple[float, float]],
    data: xr.Dataset | str | Path,
    *,
    signals: Sequence[str],
    noise: float | Mapping[str, float] | None = None,
    offset: Sequence[str] = (),
    begin: float = 0.0,
    loss: str = "linear",
    step: Step | None = None,
    method: Method | None = None,
    most_runs: int = 500,
) -> Fit:
    """Parameters from measured signals, by least squares with exact derivatives.

    The run starts as the model says, at the time `begin` of the data, and ends with them.  Data need not be evenly
    spaced; instants at which a signal is not a number are left out for this signal.

    Parameters
    ----------
    model : a mechanism, or a function of numbers that returns one.
    parameters : bounds (low, high) of each parameter by name; the search begins at the present value of a mechanism's
        number or at the default of an argument, if it lies inside, else in the middle.
    data : measured signals along `time` [s], xarray, or a CSV file whose first line names the columns, `time` first.
    signals : names of the signals that are compared; the data have them under the same names.
    noise : standard deviation of the errors of each signal, by name or one for all; None: a tenth of the rms of the
        signal for its weight, and standard errors from the scatter of the residuals.
    offset : names of signals whose measured values have an unknown constant offset.
    begin : time of the data at which the run starts [s].
    loss : "linear", or a robust one of `scipy.optimize.least_squares`: "soft_l1", "huber", "cauchy", "arctan".
    step, method : as in `simulate`.
    most_runs : number of runs at most.

    Raises
    ------
    InputError : unknown parameters or signals, bounds that are not low < high, data without these signals or with
        fewer numbers than parameters.
    SolveError : a first run that fails, or whose small differences grow too far (see `sensitivity`).
    """
    from scipy.optimize import least_squares  # noqa: PLC0415 - takes long to import

    label = "fit"
    bounds = {name: _bounds(label, name, pair) for name, pair in checks.mapping(label, "parameters", parameters).items()}
    checks.one_of(label, "loss", loss, ["linear", "soft_l1", "huber", "cauchy", "arctan"])
    measured = _Measured(label, data, signals, noise, offset, begin)
    start = _start(label, model, bounds)
    search = _Search(label, model, start, measured, step, method)
    found, reached, values = None, PARTS[0], np.array(list(start.values()))
    for part, search.integrates in [*((part, True) for part in PARTS), (1.0, False)]:
        measured.until(part if search.integrates else reached)
        if measured.count < len(values) + len(measured.offset):
            continue
        if not search.begin(values):
            continue
        reached = max(part, reached) if search.integrates else reached
        more = {} if search.integrates else {"ftol": 1e-12, "xtol": 1e-12, "gtol": 1e-12}
        most = max(most_runs - search.runs, 1)
        limits = search.limits(bounds)
        found = least_squares(
            search.residuals, search.first, jac=search.jacobian, bounds=limits, loss=loss, max_nfev=most, **more
        )
        values = (found.x * search.scale)[: len(values)]
    if found is None:
        raise InputError(f"{label}: {measured.count} measured numbers for {len(values)} parameters; give more data.")
    return _result(search, found, bounds, known=noise is not None)


def _bounds(label: str, name: str, pair: Any) -> tuple[float, float]:
    low, high = (checks.number(label, name, x) for x in checks.sequence(label, f"parameters[{name!r}]", pair, "two bounds"))
    if not low < high:
        raise InputError(f"{label}: the bounds of {name} are {low:g} and {high:g}; the first must be below the second.")
    return low, high


def _start(label: str, model: Model, bounds: Mapping[str, tuple[float, float]]) -> dict[str, float]:
    """First values of the parameters: those of the model if they lie within the bounds, else the middles."""
    middle = {name: 0.5 * (low + high) for name, (low, high) in bounds.items()}
    try:
        own = dict(zip(bounds, ParameterModel(label, model, list(bounds)).values, strict=True))
    except InputError:  # an argument without a default; other faults come back with the values
        own = middle
    held = {name: own[name] if bounds[name][0] < own[name] < bounds[name][1] else middle[name] for name in bounds}
    ParameterModel(label, model, held)
    return held


class _Measured:
    """Measured signals over their noise levels."""

    def __init__(self, label: str, data: Any, signals: Any, noise: Any, offset: Any, begin: float) -> None:
        import xarray as xr  # noqa: PLC0415 - takes long to import

        self.label, self.signals = label, checks.sequence(label, "signals", signals, "names of signals")
        if isinstance(data, (str, Path)):
            data = read_csv(label, checks.path(label, data))
        if not isinstance(data, xr.Dataset) or "time" not in data:
            raise InputError(f"{label}: data is {type(data).__name__}; give xarray signals along 'time', or a CSV file.")
        for name in self.signals:
            checks.one_of(label, "signal of the data", name, [str(key) for key in data.data_vars])
        late = np.asarray(data["time"].values, dtype=float) - checks.number(label, "begin", begin, "s")
        kept = late >= 0.0
        self.time = late[kept]
        if len(self.time) < 2 or (np.diff(self.time) <= 0.0).any():
            raise InputError(f"{label}: the data have {len(self.time)} increasing times from begin on; give more.")
        self.values = np.stack([np.asarray(data[name].values, dtype=float)[kept] for name in self.signals], axis=1)
        self.seen = np.isfinite(self.values)
        given = noise if isinstance(noise, Mapping) else dict.fromkeys(self.signals, noise)
        spread = np.sqrt(np.nanmean(np.where(self.seen, self.values, np.nan) ** 2, axis=0))
        self.noise = np.array([
            checks.positive(label, f"noise of {name}", given.get(name) or (0.1 * spread[k] or 1.0))
            for k, name in enumerate(self.signals)
        ])
        self._time, self._values, self.whole = self.time, self.values, float(self.time[-1])
        self.offset = [checks.one_of(label, "offset", name, self.signals) for name in offset]

    def until(self, part: float) -> None:
        """Take the first part of the data."""
        kept = max(int(np.searchsorted(self._time, part * self.whole * (1.0 + 1e-12), "right")), 2)
        self.time, self.values = self._time[:kept], self._values[:kept]
        self.seen = np.isfinite(self.values)

    @property
    def count(self) -> int:
        """Number of measured numbers."""
        return int(self.seen.sum())


def read_csv(label: str, path: Path) -> xr.Dataset:
    """Signals of a CSV file whose first line names the columns, "time" first."""
    import xarray as xr  # noqa: PLC0415 - takes long to import

    try:
        names = path.read_text(encoding="utf-8").partition("\n")[0].strip().split(",")
        table = np.genfromtxt(path, delimiter=",", skip_header=1, ndmin=2)
    except (OSError, ValueError) as error:
        raise InputError(f"{label}: {path} cannot be read as CSV: {error}") from error
    names = [name.strip().strip('"') for name in names]
    if names[0] != "time" or table.shape[1] != len(names):
        raise InputError(f"{label}: {path} begins with {','.join(names[:3])}; its first column must be called time.")
    return xr.Dataset({name: ("time", table[:, k]) for k, name in enumerate(names) if k}, {"time": table[:, 0]})


class _Search:
    """Residuals and their derivatives by scaled unknowns: parameters over their first values, offsets over the noise."""

    def __init__(
        self, label: str, model: Model, start: Mapping[str, float], measured: _Measured, step: Any, method: Any
    ) -> None:
        self.label, self.model, self.names, self.measured = label, model, tuple(start), measured
        self.step, self.method = step, method
        self.runs, self.integrates = 0, False
        self._known: tuple[Any, ...] = ()

    def begin(self, values: np.ndarray) -> bool:
        """Take first values and scales, and make the first run; whether it stays within the horizon of derivatives."""
        self._known = ()
        self.scale = np.append(np.where(values == 0.0, 1.0, np.abs(values)), np.ones(len(self.measured.offset)))
        self.first = np.append(values, np.zeros(len(self.measured.offset))) / self.scale
        try:
            self.largest = REFUSED * np.abs(self._at(self.first)[0]).max()
        except HorizonError:
            return False
        return True

    def limits(self, bounds: Mapping[str, tuple[float, float]]) -> tuple[np.ndarray, np.ndarray]:
        """Bounds of the unknowns."""
        open_ends = len(self.measured.offset)
        low, high = np.array(list(bounds.values())).T
        return np.append(low, [-np.inf] * open_ends) / self.scale, np.append(high, [np.inf] * open_ends) / self.scale

    def residuals(self, x: np.ndarray) -> np.ndarray:
        """Computed less measured signals over the noise, one behind the other; large where the run fails."""
        try:
            return self._at(x)[0]
        except FlexmbError:
            return np.full(self.measured.count, self.largest)

    def jacobian(self, x: np.ndarray) -> np.ndarray:
        """Derivatives of the residuals by the unknowns."""
        return self._at(x)[1]

    def _at(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Residuals, their derivatives, and computed signals (n, m)."""
        key = x.tobytes()
        if not self._known or self._known[0] != key:
            self._known = key, self._computed(x)
        found: tuple[np.ndarray, np.ndarray, np.ndarray] = self._known[1]
        return found

    def _computed(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        own, values, p = self.measured, x * self.scale, len(self.names)
        held = ParameterModel(self.label, self.model, dict(zip(self.names, values[:p].tolist(), strict=True)))
        span = Span(float(own.time[-1]), None, own.time, self.step, self.method)
        found: Derivatives = derivatives(self.label, held, span, own.signals, every=False)
        self.runs += 1
        rows = slice(len(found.times) - len(own.time), None)  # the run begins at 0
        computed, slopes = found.values[rows], found.slopes[rows] * self.scale[:p, None]
        columns_ = [slopes.transpose(0, 2, 1) / own.noise[:, None]]
        for k, name in enumerate(own.offset):
            place = own.signals.index(name)
            computed = computed + values[p + k] * own.noise[place] * (np.arange(len(own.signals)) == place)
            columns_.append(np.broadcast_to((np.arange(len(own.signals)) == place)[:, None], (*own.values.shape, 1)))
        residuals = np.where(own.seen, (computed - own.values) / own.noise, 0.0)
        slopes = np.where(own.seen[:, :, None], np.concatenate(columns_, axis=2), 0.0)
        if self.integrates:
            part = np.diff(own.time, prepend=0.0) / own.time[-1]
            residuals, slopes = np.cumsum(part[:, None] * residuals, axis=0), np.cumsum(part[:, None, None] * slopes, 0)
        return residuals[own.seen], slopes[own.seen], computed


def _result(search: _Search, found: Any, bounds: Mapping[str, tuple[float, float]], *, known: bool) -> Fit:
    """Values, errors and correlations by the derivatives at the solution."""
    import xarray as xr  # noqa: PLC0415 - takes long to import

    own, p, J = search.measured, len(search.names), search.jacobian(found.x)
    residuals, _, computed = search._at(found.x)
    _, singular, right = np.linalg.svd(J, full_matrices=False)
    seen = singular > HARDLY_SEEN * singular[0]
    inverse = np.where(seen, 1.0 / np.where(seen, singular, 1.0), 0.0)
    variance = 1.0 if known else float(residuals @ residuals) / max(own.count - len(found.x), 1)
    covariance = (right.T * inverse**2) @ right * variance
    blind = (np.abs(right[~seen]) > MEMBER).any(axis=0)
    sizes = np.sqrt(np.diag(covariance))
    with np.errstate(all="ignore"):
        correlation = np.where(blind[:, None] | blind, np.nan, covariance / np.outer(sizes, sizes))
    errors = np.where(blind, np.inf, sizes * search.scale)
    values, level = found.x * search.scale, math.sqrt(float(residuals @ residuals) / own.count)
    left = {
        name: ("time", own.values[:, k] - computed[:, k]) for k, name in enumerate(own.signals)
    }
    return Fit(
        dict(zip(search.names, values[:p].tolist(), strict=True)),
        dict(zip(search.names, errors[:p].tolist(), strict=True)),
        dict(bounds),
        correlation[:p, :p],
        {name: float(values[p + k] * own.noise[own.signals.index(name)]) for k, name in enumerate(own.offset)},
        tuple(_combinations(search.names, right[~seen])),
        xr.Dataset(left, {"time": ("time", own.time, {"units": "s"})}),
        level,
        search.runs,
        bool(found.success),
        " ".join(_sentences(own, found)),
    )


def _sentences(own: _Measured, found: Any) -> Iterator[str]:
    yield "Converged." if found.success else f"Not converged ({found.message})."
    if own.time[-1] < own.whole:
        yield f"Data later than {own.time[-1]:.4g} s are left out: until then small differences grow by 1/rtol."


def _combinations(names: Sequence[str], directions: np.ndarray) -> Iterator[str]:
    """Combinations of relative changes of parameters that the data do not show."""
    for row in directions:
        members = [(name, x) for name, x in zip(names, row, strict=False) if abs(x) > MEMBER]
        if members:
            yield " ".join(f"{x:+.2f} of {name}" for name, x in members)
