"""Fits: parameters of a mechanism from measured signals, with standard errors and correlations."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from flexmb import arguments, checks, display
from flexmb.design.derivatives import Span, columns, derivatives, signals_along
from flexmb.design.parameters import LEAST_SIZE, Model, ParameterModel, bounds_of, box_points
from flexmb.engine.newmark.method import Newmark
from flexmb.engine.step.method import Method
from flexmb.engine.step.step_size import Adaptive
from flexmb.errors import AssemblyError, FlexmbError, InputError, ModelError, SolveError
from flexmb.fields import field, record_with
from flexmb.late import pd, scipy, xr
from flexmb.run.saving import SAME_INSTANT
from flexmb.run.simulate import Step
from flexmb.version import installed_version

# Singular value of the scaled derivatives, over the largest, below which a combination of parameters is not seen.
HARDLY_SEEN = 1e-7
MEMBER = 0.1  # share of a parameter in such a combination from which it is named
# Parts of the data, from the begin on, that are fitted one after the other.
# The sum of squares has many minima where small differences grow; those of a shorter span are wider. In each span
# residuals are integrated over the time at first, since peaks of computed and measured impacts need not overlap.
SPANS = tuple(np.geomspace(0.01, 1.0, 14).tolist())
# Points within the bounds at which the first span is computed; median of their sums of squares over the least one from
# which a span tells where to search.
TRIALS, TELLING = 64, 5.0
# Points that are followed from span to span; sum of squares over the least one up to which one is followed.
KEPT, BEHIND = 5, 4.0
# Runs of a search in a span that is not the last; mean square over that of the span before from which more is tried,
# unless it is small beside that of the noise; spans between attempts to take all data at once.
TURNS, WORSE, ENOUGH, JUMPS = 12, 1.5, 1e-6, 4
ABOVE_NOISE = 1.5  # residuals over the given noise from which a fit says that something is left out
CLEARLY = 3.0  # correlation of residuals from one instant to the next, over its scatter in white noise, that is told
LAST_CHANGE = 1e-12  # relative change at which the last search ends
PROMISING = 0.1  # part of the sum of squares that derivatives promise to take away, from which a search was stopped
SAME_POINT = 1e-3  # distance of two points, relative to the bounds, within which they are one
# Errors of runs that fail; their residuals, over the noise, so that the search turns back.
FAILURES, REFUSED = (AssemblyError, ModelError, SolveError), 1e4


@record_with(repr=False)
class Fit(display.Inside):
    """Fitted parameters."""

    parameters: dict[str, float] = field("value of each parameter by name")
    errors: dict[str, float] = field("standard error of each parameter by name")
    bounds: dict[str, tuple[float, float]] = field("bounds of each parameter by name")
    correlation: np.ndarray = field("(n, n) correlations, in the order of the parameters")
    offsets: dict[str, float] = field("fitted constant offsets by signal")
    unseen: tuple[str, ...] = field("combinations of parameters that the data do not tell apart, as texts")
    residuals: xr.Dataset = field(
        "measured less computed signals, xarray; attributes: unit, `noise` (the given level, else that of the "
        "scatter), `correlation` from one instant to the next"
    )
    rms: float = field("root mean square of the residuals over the given noise, else over a tenth of the signal")
    runs: int = field("number of runs that were made")
    ok: bool = field("whether the search converged")
    message: str = field("end of the search, in a sentence")
    corrected: dict[str, float] = field("standard errors for correlated residuals; `errors` where it is not clear")
    computed: xr.Dataset = field("computed signals with their offsets, xarray")
    begins: tuple[float, ...] = field("times at which the pieces of the record begin", "s")
    units: dict[str, str] = field('unit of each parameter, "" where it is unknown or none')
    about: dict[str, str] = field("settings of the fit as texts")

    def table(self) -> tuple[list[str], list[list[str]]]:
        """Head and rows of texts: parameter, value, standard errors, bounds, correlations."""
        names, corrects = list(self.parameters), self.corrected != self.errors
        head = ["parameter", "value", "standard error", *(["corrected"] if corrects else []), "bounds"]
        rows = []
        for name, own in zip(names, self.correlation, strict=True):
            low, high = self.bounds[name]
            errors = [f"{each[name]:.2g}" for each in (self.errors, self.corrected)[: 2 if corrects else 1]]
            part = (self.parameters[name] - low) / (high - low)
            at = ", at the lower" if part < SAME_POINT else ", at the upper" if part > 1.0 - SAME_POINT else ""
            values = f"{self.parameters[name]:.6g}", *errors, f"{low:g} to {high:g}{at}", *(f"{x:.3f}" for x in own)
            rows.append([name, *values])
        return [*head, *(f"with {name}" for name in names)], rows

    def __repr__(self) -> str:
        head, rows = self.table()
        first = f"Fit: {self.message} {self.runs} runs, residuals {self.rms:.3g} of their levels."
        lines = [first, columns(head, rows)]
        lines += [f"Offset of {name}: {value:.6g}" for name, value in self.offsets.items()]
        return "\n".join([*lines, *(f"Not told apart by the data: {text}." for text in self.unseen)])


@arguments.checked
def fit(
    model: Model, parameters: Mapping[str, tuple[float, float]], data: xr.Dataset | str | Path, *,
    signals: Sequence[str], noise: float | Mapping[str, float] | None = None,
    offset: Sequence[str | Sequence[str]] = (), begin: float = 0.0, loss: str = "linear", step: Step | None = None,
    method: Method | None = None, most_runs: int = 100, start: Mapping[str, float | Sequence[float]] | None = None,
    pieces: Sequence[float] = (), free: Sequence[str] = (),
) -> Fit:  # fmt: skip
    """Parameters from measured signals, by least squares with the derivatives of the run.

    The run starts as the model says, at the time `begin` of the data.  Spans of the data that grow are fitted one after
    the other, from several points within the bounds, up to all data or to the horizon of derivatives.  Data need not
    be evenly spaced; instants at which a signal is not a number are left out for this signal.

    Parameters
    ----------
    model : a mechanism, or a function of numbers that returns one; start values may be arguments.
    parameters : bounds (low, high) of each parameter by name.
    data : measured signals along `time` [s], xarray, or a CSV file whose first line names the columns, `time` first.
    signals : names of the signals that are compared; the data have them under the same names.
    noise : standard deviation of the errors of each signal, by name or one for all; None: a tenth of the rms of the
        signal for its weight, and standard errors from the scatter of the residuals.
    offset : names of signals whose measured values have an unknown constant offset, the same in all pieces; a list of
        names among them, [["crank.theta", "rod.theta"]], is of signals with one offset in common.
    begin : time of the data at which the run starts [s].
    loss : "linear", or a robust one of `scipy.optimize.least_squares`: "soft_l1", "huber", "cauchy", "arctan".
    step, method : as in `simulate`.
    most_runs : number of runs of the last search at most.
    start : values from which the search begins, by name, with all data at once, of a free parameter also one for each
        piece; others begin in the middle of their bounds.  None: spans and points as above.
    pieces : times of the data at which the motion begins anew, each time as the model says [s]: several records one
        behind the other, or one that is cut since small differences grow too far in the whole of it.  With pieces
        the search begins at `start`.
    free : names of parameters with a value of their own in each piece, as angles and rates at its start;
        "angle[0]", "angle[1]" in the result.

    Raises
    ------
    InputError : unknown parameters or signals, bounds that are not low < high, data without these signals or with
        fewer numbers than parameters.
    SolveError : all runs of the first span fail, or small differences grow too far in it (see `sensitivity`).
    """
    label = "fit"
    bounds = bounds_of(label, parameters)
    checks.one_of(label, "loss", loss, ["linear", "soft_l1", "huber", "cauchy", "arctan"])
    measured = _Measured(label, data, signals, noise, checks.sequence(label, "offset", offset, "signals"), begin)
    measured.cut(checks.sequence(label, "pieces", pieces, "times"))
    free = checks.sequence(label, "free", free, "names")
    own = [checks.one_of(label, "free parameter", name, list(bounds)) for name in free]
    if own and len(measured.begins) == 1:
        text = f"{label}: free is {own!r}, but there is one piece alone;"
        raise InputError(f"{text} give pieces=[...], times of the data.")
    search = _Search(label, model, bounds, measured, own, step, method)
    if measured.count < search.unknowns:
        raise InputError(f"{label}: {measured.count} measured numbers for {search.unknowns} unknowns; give more data.")
    most = checks.count(label, "most_runs", most_runs)
    if start is None and len(measured.begins) == 1:
        found = search.through_spans(loss, most)
    else:
        found = search.from_point(start_of(label, start, search), loss, most)
    return _result(search, found, loss, known=noise is not None)


def start_of(label: str, start: Any, search: _Search) -> np.ndarray:
    """Start values (pieces, parameters), by default in the middle of the bounds, or `InputError`."""
    names, many = list(search.bounds), len(search.columns)
    found = np.array([[0.5 * (low + high) for low, high in search.bounds.values()]] * many)
    for name, given in checks.mapping(label, "start", start).items() if start is not None else ():
        k = names.index(checks.one_of(label, "start of a parameter", name, names))
        each = [given] if np.ndim(given) == 0 else checks.sequence(label, f"start[{name!r}]", given, "values")
        if len(each) != 1 and (len(each) != many or name in search.names):
            text = f"{label}: start of {name} has {len(each)} values"
            raise InputError(f"{text}; give one, or one for each of {many} pieces to a parameter that is free.")
        found[:, k] = [checks.number(label, f"start[{name!r}]", value) for value in each]
        low, high = search.bounds[name]
        if found[:, k].min() < low or found[:, k].max() > high:
            raise InputError(f"{label}: start of {name} is {given}; it must be within its bounds, {low:g} to {high:g}.")
    return found


class _Measured:
    """Measured signals over their noise levels, in pieces that begin at `begins`."""

    begins: tuple[float, ...] = (0.0,)

    def __init__(self, label: str, data: Any, signals: Any, noise: Any, offset: Any, begin: float) -> None:
        self.label, self.signals = label, checks.sequence(label, "signals", signals, "names of signals")
        self.begin = checks.number(label, "begin", begin, "s")
        if not self.signals or any(self.signals.count(name) > 1 for name in self.signals):
            raise InputError(f"{label}: signals is {signals!r}; give at least one name, each of them once.")
        if isinstance(data, (str, Path)):
            data = read_csv(label, checks.path(label, data))
        if not isinstance(data, xr.Dataset) or "time" not in data:
            text = f"{label}: data is {type(data).__name__};"
            raise InputError(f"{text} give xarray signals along 'time', or a CSV file.")
        for name in self.signals:
            checks.one_of(label, "signal of the data", name, [str(key) for key in data.data_vars])
        for name in ("time", *self.signals):
            if data[name].dims != ("time",) or data[name].dtype.kind not in "fiu":
                raise InputError(f"{label}: {name} of the data is no row of numbers along 'time'; give one [SI units].")
        late = np.asarray(data["time"].values, dtype=float) - self.begin
        kept = late >= 0.0
        self.every, self.passed = late[kept], int((~kept).sum())  # instants that are left out
        if len(self.every) < 2 or (np.diff(self.every) <= SAME_INSTANT * self.every[-1]).any():
            raise InputError(f"{label}: the data need increasing times from begin on; {len(self.every)} are not so.")
        self.all_values = np.stack([np.asarray(data[name].values, dtype=float)[kept] for name in self.signals], axis=1)
        given = noise if isinstance(noise, Mapping) else dict.fromkeys(self.signals, noise)
        if set(given) != set(self.signals):
            raise InputError(f"{label}: noise is of {', '.join(map(str, given))}; name all signals, and no other.")
        seen, levels = np.isfinite(self.all_values), [given[name] for name in self.signals]
        squares = (np.where(seen, self.all_values, 0.0) ** 2).sum(axis=0) / np.maximum(seen.sum(axis=0), 1)
        usual = [0.1 * x or 1.0 if own is None else own for x, own in zip(np.sqrt(squares), levels, strict=True)]
        self.noise = np.array([checks.positive(label, f"noise of {self.signals[k]}", x) for k, x in enumerate(usual)])
        groups = [[x] if isinstance(x, str) else checks.sequence(label, "offset", x, "signals") for x in offset]
        # Places of the signals of each offset
        self.offset = [[self.signals.index(checks.one_of(label, "offset", x, self.signals)) for x in g] for g in groups]
        every = [place for places in self.offset for place in places]
        if len(set(every)) < len(every) or [] in self.offset:
            text = f"{label}: offset is {list(offset)!r}; each signal has one offset"
            raise InputError(f"{text}: name it once, alone or in one list of signals that share theirs.")
        self.until(1.0)

    def cut(self, pieces: Sequence[Any]) -> None:
        """Begin a piece at the begin and at each of the times `pieces` of the data [s]."""
        cuts = [checks.number(self.label, "pieces", one, "s") - self.begin for one in pieces]
        self.begins = (0.0, *(cut for cut in cuts if cut != 0.0))
        counts = np.diff(np.searchsorted(self.every, [*self.begins, np.inf]))
        if list(self.begins) != sorted(set(self.begins)) or min(counts) < 2:
            text = f"{self.label}: pieces is {pieces!r};"
            raise InputError(f"{text} give increasing times of the data, two instants in each.")

    def piece(self, i: int) -> slice:
        """Rows of a piece in the present data."""
        return slice(*np.searchsorted(self.time, [*self.begins, np.inf])[i : i + 2].tolist())

    def until(self, part: float) -> None:
        """Take the first part of the data."""
        self.part, whole = part, float(self.every[-1])
        kept = max(int(np.searchsorted(self.every, part * whole * (1.0 + 1e-12), "right")), 2)
        self.time, self.values = self.every[:kept], self.all_values[:kept]
        self.seen = np.isfinite(self.values)

    @property
    def count(self) -> int:
        """Number of measured numbers."""
        return int(self.seen.sum())


def read_csv(label: str, path: Path) -> xr.Dataset:
    """Signals of a CSV file whose first line names the columns, "time" first."""
    try:
        table = pd.read_csv(path, skipinitialspace=True, encoding="utf-8-sig")
    except (OSError, ValueError) as error:
        raise InputError(f"{label}: {path} cannot be read as CSV: {error}") from error
    table.columns = [str(name).strip() for name in table]
    if table.columns[0] != "time" or not isinstance(table.index, pd.RangeIndex):
        raise InputError(f"{label}: {path}: give 'time' and names in line 1, as many numbers below, commas between.")
    for name, column in table.items():
        text = column[pd.to_numeric(column, errors="coerce").isna() & column.notna()]
        if len(text):
            where = f"{path}: {name} has {text.iloc[0]!r} in line {text.index[0] + 2}"
            raise InputError(f"{label}: {where}; give numbers, and nothing where one is missing.")
    return xr.Dataset({name: ("time", table[name].to_numpy()) for name in table.columns[1:]}, {"time": table["time"]})


class _Search:
    """Residuals and derivatives by unknowns: parameters from 0 to 1 within their bounds, offsets over the noise."""

    def __init__(
        self, label: str, model: Model, bounds: Mapping[str, Any], measured: _Measured, free: Sequence[str], *how: Any
    ) -> None:
        self.label, self.model, self.bounds, self.measured = label, model, dict(bounds), measured
        self.step, self.method = how
        shared = [name for name in bounds if name not in free]
        places = {name: k for k, name in enumerate(shared)}
        self.names, self.columns = shared, []  # columns of each piece, in the order of the bounds
        for i in range(len(measured.begins)):
            places |= {name: len(self.names) + k for k, name in enumerate(free)}
            self.names = [*self.names, *(f"{name}[{i}]" for name in free)]
            self.columns.append([places[name] for name in bounds])
        each = [bounds[name.partition("[")[0] if name not in bounds else name] for name in self.names]
        self.low, high = np.array(each).T
        self.width = high - self.low
        self.unknowns = len(self.names) + len(measured.offset)
        self.runs, self.failed, self.integrates = 0, 0, True
        self.units: tuple[str, ...] = ("",) * len(measured.signals)
        self.tried: tuple[np.ndarray, list[np.ndarray]] | None = None

    def values(self, x: np.ndarray) -> np.ndarray:
        """Values of all parameters for unknowns (n,)."""
        return np.asarray(self.low + x[: len(self.low)] * self.width)

    def at(self, x: np.ndarray, i: int) -> ParameterModel:
        """The model of a piece with unknowns (n,)."""
        values = self.values(x)[self.columns[i]].tolist()
        held = ParameterModel(self.label, self.model, dict(zip(self.bounds, values, strict=True)))
        held.least = (LEAST_SIZE * self.width[self.columns[i]]).tolist()
        return held

    def pieces(self) -> Iterator[tuple[int, slice, Span]]:
        """Number, rows and span of each piece of the present data."""
        for i, begin in enumerate(self.measured.begins):
            rows = self.measured.piece(i)
            times = self.measured.time[rows] - begin
            if len(times):
                yield i, rows, Span(float(times[-1]), None, times, self.step, self.method)

    def computed(self, x: np.ndarray) -> np.ndarray:
        """Computed signals (times, signals), offsets included."""
        own, found = self.measured, np.zeros(self.measured.values.shape)
        for i, rows, span in self.pieces():
            self.runs += 1
            values, self.units = signals_along(self.label, self.at(x, i), span, own.signals)
            found[rows] = values[rows.start - rows.stop :]
        for k, places in enumerate(own.offset):
            if len({self.units[place] for place in places}) > 1:
                told = " and ".join(f"{own.signals[place]} [{self.units[place] or 1}]" for place in places)
                raise InputError(f"{self.label}: {told} share an offset; only signals of one unit can.")
            found[:, places] += x[len(self.low) + k] * own.noise[places[0]]
        return found

    def residuals(self, x: np.ndarray) -> np.ndarray:
        """Computed less measured signals over the noise, one behind the other; large where the run fails."""
        return np.asarray(self._weighted(self._difference(x))[self.measured.seen])

    def _difference(self, x: np.ndarray) -> np.ndarray:
        """Computed less measured signals over the noise, (times, signals)."""
        own = self.measured
        try:
            found = (self.computed(x) - own.values) / own.noise
        except FAILURES:
            self.failed += 1
            return np.full(own.values.shape, REFUSED)
        return np.where(own.seen, found, 0.0)

    def jacobian(self, x: np.ndarray) -> np.ndarray:
        """Derivatives of the residuals by the unknowns."""
        own, p = self.measured, len(self.low)
        slopes = np.zeros((*own.values.shape, self.unknowns))
        for i, rows, span in self.pieces():
            self.runs += 1
            every = derivatives(self.label, self.at(x, i), span, own.signals, every=False).slopes
            kept, places = every[rows.start - rows.stop :].transpose(0, 2, 1), self.columns[i]
            slopes[rows, :, places] = kept * self.width[places] / own.noise[:, None]
        for k, places in enumerate(own.offset):
            slopes[:, places, p + k] = own.noise[places[0]] / own.noise[places]
        return np.asarray(self._weighted(np.where(own.seen[:, :, None], slopes, 0.0))[own.seen])

    def _weighted(self, rows: np.ndarray) -> np.ndarray:
        """Rows themselves, or their integrals over the part of the time."""
        if not self.integrates:
            return rows
        part = np.diff(self.measured.time, prepend=0.0) / self.measured.time[-1]
        return np.asarray(np.cumsum(part.reshape(-1, *(1,) * (rows.ndim - 1)) * rows, axis=0))

    def from_point(self, start: np.ndarray, loss: str, most: int) -> Any:
        """Result of scipy from values (pieces, parameters), with all data."""
        x = np.zeros(self.unknowns)
        for i, values in enumerate(start):
            x[self.columns[i]] = values
        x[: len(self.low)] = (x[: len(self.low)] - self.low) / self.width
        return self._searched(x, loss, most)

    def through_spans(self, loss: str, most: int) -> Any:
        """Result of the last search of scipy, from the best of the points that were followed through the spans."""
        points: list[np.ndarray] = []
        reached, level = 0.0, 0.0
        refused: FlexmbError = SolveError(f"{self.label}: no span of the data could be computed.")
        for k, part in enumerate(SPANS):
            self.measured.until(part)
            if self.measured.count < 2 * self.unknowns and part < 1.0:
                continue
            points = points or self._scan(last=part == SPANS[-1])
            if not points:
                continue
            found: list[Any] = []
            for x in points:
                try:
                    found.append(self._followed(x, loss, level))
                except FAILURES as error:
                    refused = error
                if len(found) == 2 and np.abs(found[0].x - found[1].x).max() < SAME_POINT:
                    break  # two points of the first span lead to the same one
            if not found:
                break
            reached, points = part, _distinct(found)
            level = max(WORSE * min(float(one.cost) for one in found) / self.measured.count, ENOUGH)
            if k % JUMPS == 0 and self._holds_everywhere(points, loss, level):
                reached = 1.0
                break
        if reached == 0.0:
            raise refused
        self.measured.until(reached)
        return min((self._searched(x, loss, most) for x in points[:2]), key=lambda one: float(one.cost))

    def _holds_everywhere(self, points: list[np.ndarray], loss: str, level: float) -> bool:
        """Whether the best point fits all data as well as the span before; it then takes the place of all points."""
        self.measured.until(1.0)
        try:
            one = self._searched(points[0], loss)
        except FAILURES:
            return False
        if one.cost > level * self.measured.count:
            return False
        points[:] = [one.x]
        return True

    def _scan(self, *, last: bool) -> list[np.ndarray]:
        """Best of some points within the bounds; none if this span does not tell them apart, and it is not the last."""
        own, part = self.measured, self.measured.part
        if self.tried is None:
            points = np.zeros((TRIALS, self.unknowns))
            points[:, : len(self.low)] = box_points(TRIALS, len(self.low))
            own.until(1.0)
            self.tried = points, [self._difference(x) for x in points]
            own.until(part)
        points, rows = self.tried
        self.integrates = True
        costs = np.array([float((self._weighted(each[: len(own.time)])[own.seen] ** 2).sum()) for each in rows])
        order = np.argsort(costs)
        if float(np.median(costs)) < TELLING * costs[order[0]] and not last:
            return []
        return [points[k] for k in order[: 2 * KEPT]]

    def _followed(self, x: np.ndarray, loss: str, level: float) -> Any:
        """Search from a point of the span before; by integrals first, if it leaves more than `level` a residual."""
        one = self._searched(x, loss) if level > 0.0 else None
        if one is not None and one.cost <= level * self.measured.count:
            return one
        other = self._searched(self._searched(x, loss, integrates=True).x, loss)
        return other if one is None else min(one, other, key=lambda each: float(each.cost))

    def _searched(self, x: np.ndarray, loss: str, most: int | None = None, *, integrates: bool = False) -> Any:
        """Result of scipy from a point; `most` runs of the last search, to its end."""
        self.integrates = integrates
        p, open_ends = len(self.low), len(self.measured.offset)
        limits = np.append(np.zeros(p), [-np.inf] * open_ends), np.append(np.ones(p), [np.inf] * open_ends)
        more = {} if most is None else dict.fromkeys(("ftol", "xtol", "gtol"), LAST_CHANGE)
        start = np.append(np.clip(x[:p], SAME_POINT, 1.0 - SAME_POINT), x[p:])
        how = {"jac": self.jacobian, "bounds": limits, "loss": loss, "max_nfev": most or TURNS, **more}
        return scipy.optimize.least_squares(self.residuals, start, **how)


def _distinct(found: Sequence[Any]) -> list[np.ndarray]:
    """Points of searches with sums of squares near the least one, each once, best first."""
    kept: list[np.ndarray] = []
    ranked = sorted(found, key=lambda one: float(one.cost))
    for one in ranked:
        if one.cost > BEHIND * ranked[0].cost or len(kept) == KEPT:
            break
        if all(np.abs(one.x - other).max() > SAME_POINT for other in kept):
            kept.append(one.x)
    return kept


def _variance(residuals: np.ndarray, loss: str) -> float:
    """Variance of residuals (n,) by their mean weight in a loss: that of their scatter without outliers."""
    # mean(psi^2)/mean(psi')^2 with psi(r) = r rho'(r^2) (P. J. Huber, Robust Statistics, Wiley 1981, section 7.6).
    z = residuals**2
    far = np.maximum(z, 1.0)
    slope, bend = {
        "linear": (np.ones_like(z), 0.0 * z),
        "soft_l1": ((1.0 + z) ** -0.5, -0.5 * (1.0 + z) ** -1.5),
        "huber": (far**-0.5, np.where(z > 1.0, -0.5 * far**-1.5, 0.0)),
        "cauchy": (1.0 / (1.0 + z), -1.0 / (1.0 + z) ** 2),
        "arctan": (1.0 / (1.0 + z**2), -2.0 * z / (1.0 + z**2) ** 2),
    }[loss]
    return float(np.mean(z * slope**2) / np.mean(slope + 2.0 * z * bend) ** 2)


def _result(search: _Search, found: Any, loss: str, *, known: bool) -> Fit:
    """Values, errors and correlations by the derivatives at the solution."""
    own, p, J = search.measured, len(search.low), search.jacobian(found.x)
    names = tuple(search.names)
    computed = search.computed(found.x)
    residuals = search.residuals(found.x)
    lengths = np.linalg.norm(J, axis=0)
    J[:, p:] *= (lengths[:p].max() or 1.0) / lengths[p:]  # offsets, which have no bounds, weigh as parameters do
    left, singular, right = np.linalg.svd(J, full_matrices=False)
    seen = singular > HARDLY_SEEN * singular[0]
    inverse = np.where(seen, 1.0 / np.where(seen, singular, 1.0), 0.0)
    more = own.count - len(found.x)
    stuck = search.failed > 0 and _promise(J, residuals, found.x[:p]) > PROMISING
    variance = 1.0 if known else _variance(residuals, loss) * own.count / more if more else math.inf
    blind = (np.abs(right[~seen]) > MEMBER).any(axis=0)
    with np.errstate(all="ignore"):
        covariance = (right.T * inverse**2) @ right * variance
        sizes = np.sqrt(np.diag(covariance))
        correlation = np.where(blind[:, None] | blind, np.nan, covariance / np.outer(sizes, sizes))
    left_over, factors = _left_over(search, computed, math.sqrt(variance), known=known)
    grown = np.broadcast_to(factors, own.values.shape)[own.seen] * ((right.T * inverse) @ left.T)
    larger = np.sqrt(variance * (grown**2).sum(axis=1)) if found.success and max(factors) > 1.0 else sizes
    values = [np.where(blind[:p], np.inf, one[:p] * search.width).tolist() for one in (sizes, larger)]
    errors, corrected = (dict(zip(names, one, strict=True)) for one in values)
    labels = [*names, *(f"the offset of {' and '.join(own.signals[k] for k in places)}" for places in own.offset)]
    rms = math.sqrt(float(residuals @ residuals) / own.count)
    told = [*_sentences(search, found, rms if known else 0.0, stuck=stuck), *_correlated(left_over, errors, corrected)]
    pairs = ([f"{x:+.2f} of {a}" for a, x in zip(labels, v, strict=True) if abs(x) > MEMBER] for v in right[~seen])
    lows, highs = search.low.tolist(), (search.low + search.width).tolist()
    shared = zip(found.x[p:], own.offset, strict=True)
    offsets = {own.signals[k]: float(x * own.noise[group[0]]) for x, group in shared for k in group}
    units, about = _settings(search, found.x, loss, known=known)
    return Fit(
        parameters=dict(zip(names, search.values(found.x).tolist(), strict=True)), errors=errors,
        bounds=dict(zip(names, zip(lows, highs, strict=True), strict=True)), correlation=correlation[:p, :p],
        offsets=offsets, unseen=tuple(" ".join(own) for own in pairs if own), residuals=left_over, rms=rms,
        runs=search.runs, ok=bool(found.success) and not stuck, message=" ".join(told), corrected=corrected,
        computed=left_over.copy(data=dict(zip(own.signals, computed.T, strict=True))), begins=own.begins,
        units=units, about=about,
    )  # fmt: skip


def lag_correlations(residuals: np.ndarray, begins: Sequence[int] = ()) -> tuple[np.ndarray, np.ndarray]:
    """Correlations (m,) of residuals (n, m) from one instant to the next, and factors of standard errors by them."""
    # Of n numbers with correlation r, n (1 - r)/(1 + r) count where derivatives vary slowly. The factor is 1 where r is
    # not clear. Missing residuals are NaN; rows at `begins` follow no others.
    apart = np.insert(residuals, [k for k in begins if k < len(residuals)], np.nan, axis=0)
    both = np.isfinite(apart[:-1]) & np.isfinite(apart[1:])
    a, b, count = np.where(both, apart[:-1], 0.0), np.where(both, apart[1:], 0.0), np.maximum(both.sum(axis=0), 1)
    size = np.sqrt((a**2).sum(axis=0) * (b**2).sum(axis=0))
    r = (a * b).sum(axis=0) / np.where(size > 0.0, size, 1.0)
    share = np.maximum((1.0 - r) / (1.0 + np.abs(r)), 1.0 / count)  # at least one number counts
    return r, np.where(r * np.sqrt(count) > CLEARLY, 1.0 / np.sqrt(share), 1.0)


def _left_over(search: _Search, computed: np.ndarray, scatter: float, *, known: bool) -> tuple[xr.Dataset, np.ndarray]:
    """Residuals by signal, and the factor of standard errors by the correlation of each."""
    own, noise = search.measured, scatter * search.measured.noise
    rows = np.where(own.seen, own.values - computed, np.nan)
    lag, factors = lag_correlations(rows, [own.piece(i).start for i in range(len(own.begins))])
    told = zip(search.units, noise.tolist(), lag.tolist(), strict=True)
    attributes = [dict(zip(("units", "noise", "correlation"), one, strict=True)) for one in told]
    found = {name: ("time", rows[:, k], attributes[k]) for k, name in enumerate(own.signals)}
    size = np.sqrt(np.nansum(rows**2, axis=0) / np.maximum(own.seen.sum(axis=0), 1))
    small = known & (size < noise / ABOVE_NOISE)  # then errors are those of the noise, which is not seen
    return xr.Dataset(found, {"time": ("time", own.time, {"units": "s"})}), np.where(small, 1.0, factors)


def _settings(search: _Search, x: np.ndarray, loss: str, *, known: bool) -> tuple[dict[str, str], dict[str, str]]:
    """Units of the parameters, and settings of a fit."""
    own, held = search.measured, search.at(x, 0)
    units = {search.names[k]: one.unit for each in search.columns for k, one in zip(each, held.parameters, strict=True)}
    return units, {
        "mechanism": held.at(held.values).name, "runs": f"{search.runs}, of which {search.failed} failed",
        "data": f"{own.count} numbers of {display.counted(len(own.signals), 'signal')}, from {own.begin:g} s on",
        "noise": "as given" if known else "from the scatter of the residuals", "loss": loss,
        "step": display.value_text(search.step or Adaptive()),
        "method": display.value_text(search.method or Newmark.generalised_alpha()), "flexmb": installed_version(),
    }  # fmt: skip


def _promise(J: np.ndarray, residuals: np.ndarray, x: np.ndarray) -> float:
    """Part of the sum of squares that derivatives promise to take away, without leaving bounds."""
    free = np.append(np.minimum(x, 1.0 - x) > SAME_POINT, np.ones(J.shape[1] - len(x), dtype=bool))
    Q = np.linalg.qr(J[:, free])[0]
    return float(((Q.T @ residuals) ** 2).sum() / max(float(residuals @ residuals), np.finfo(float).tiny))


def _sentences(search: _Search, found: Any, over_noise: float, *, stuck: bool) -> Iterator[str]:
    own = search.measured
    if stuck:
        yield "Not converged: the search stopped beside values for which runs fail, and better ones may lie there."
    else:
        yield "Converged." if found.success else f"Not converged ({found.message})."
    if over_noise > ABOVE_NOISE:
        yield f"The residuals are {over_noise:.3g} times the noise: another minimum, or something that the model lacks."
    if own.count == search.unknowns:
        yield "As many numbers as unknowns: they leave no scatter."
    missing = int(np.isnan(own.all_values).sum())
    if own.passed or missing:
        instants = f"{own.passed} of {own.passed + len(own.every)} instants"
        yield f"Left out: {instants} (before `begin` or without a time), {missing} values that are no numbers."
    if own.part < 1.0:
        yield f"Data later than {own.time[-1]:.4g} s are left out: small differences grow too far there."
    at = [name for name, x in zip(search.names, found.x, strict=False) if min(x, 1.0 - x) < SAME_POINT]
    if at:
        yield f"At a bound: {', '.join(at)}."


def _correlated(left: xr.Dataset, errors: Mapping[str, float], corrected: Mapping[str, float]) -> Iterator[str]:
    """Sentence on residuals that are correlated from instant to instant, with the standard errors that hold then."""
    if errors == corrected:
        return
    of = [f"{x.correlation:.2f} ({name})" for name, x in left.items()]
    grown = [f"{name} {x:.2g} ({x / errors[name]:.2g} times)" for name, x in corrected.items() if math.isfinite(x)]
    text = f"Residuals are correlated from one instant to the next by {', '.join(of)}: n (1 - r)/(1 + r)"
    yield (f"{text} of n numbers count, and standard errors are too small. Corrected: {display.listed(grown, 6)}.")
