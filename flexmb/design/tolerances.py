"""Spread of measures over a batch of machines whose numbers scatter: to first order, and by samples."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from typing import Any

import numpy as np

from flexmb import arguments, checks, display
from flexmb.design.derivatives import Span, columns, derivatives
from flexmb.design.measures import Measure, Rows, measured
from flexmb.design.parameters import Model, ParameterModel, box_points, refuse_taken
from flexmb.dynamics.sweeps.parameter_sweep import RESERVED, sweep
from flexmb.engine.step.method import Method
from flexmb.errors import InputError, SolveError
from flexmb.fields import Input, field, positive, record, record_with
from flexmb.late import scipy, xr
from flexmb.run.simulate import Step, simulate

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
    return Spread(first, found, _statistics(usual, names), indices, " ".join(text))


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


def _statistics(table: np.ndarray, names: Sequence[str]) -> xr.Dataset:
    rows = np.nanmean(table, axis=1), np.nanstd(table, axis=1, ddof=1), *np.nanquantile(table, TAILS, axis=1)
    named = {name: ("measure", row) for name, row in zip(STATISTICS, rows, strict=True)}
    return xr.Dataset(named, {"measure": list(names)})


def _indices(blocks: np.ndarray, names: Sequence[str], parameters: Sequence[str]) -> xr.Dataset:
    """Sobol's indices by scipy from the blocks (measures, parameters + 2, samples)."""
    blocks = np.concatenate([blocks, blocks[:1]])  # scipy fails with one measure of one parameter
    given = {"f_A": blocks[:, 0], "f_B": blocks[:, 1], "f_AB": blocks[:, 2:].transpose(1, 0, 2)}
    found = scipy.stats.sobol_indices(func=given, n=blocks.shape[2])
    both = ("measure", "parameter")
    first, total = (np.reshape(one, (len(blocks), -1))[:-1] for one in (found.first_order, found.total_order))
    return xr.Dataset({"first": (both, first), "total": (both, total)}, {"measure": names, "parameter": parameters})
