"""Points of sections as labelled tables, and their signals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from flexmb import arguments, checks
from flexmb.dynamics.jobs.executors import tell_stopped
from flexmb.dynamics.jobs.progress import ProgressBar
from flexmb.dynamics.sections.maps import SectionMap, strobe_of
from flexmb.dynamics.systems.dynamics import Dynamics, as_dynamics
from flexmb.dynamics.verdict import Verdict, judge
from flexmb.errors import InputError
from flexmb.late import xr

if TYPE_CHECKING:
    from flexmb.engine.newmark.method import Newmark
    from flexmb.run.simulate import Step


# Signals of section points: names, units and resolution, and the verdict that rests on them
@dataclass(frozen=True, eq=False)
class SectionSignals:
    """Names, units and resolution of the signals of section points."""

    name: str
    names: tuple[str, ...]  # names and units (m,) of the signals
    units: tuple[str, ...]
    telling: tuple[int, ...]  # numbers of the signals on which a verdict rests
    # differences (m,) of the signals that errors of the integration can make; None: 1e-6 of their sizes
    resolution: np.ndarray | None
    dimension: int = 0  # number of exponents of the system; 0: unknown

    @classmethod
    def of(cls, system: Dynamics) -> Self:
        """Names, units and resolution of the signals that `system` observes."""
        return cls(system.name, system.names, system.units, system.telling, system.resolution, system.dimension)

    def verdict(
        self, points: np.ndarray, signals: Sequence[str] = (), exponent: float | None = None, error: float | None = None
    ) -> Verdict:
        """Verdict on points (n, m) of all signals, by the given signals or, without any, by the signals `telling`."""
        # The largest exponent and its error are None or not finite where they are unknown.
        value, band = (x if x is not None and np.isfinite(x) else None for x in (exponent, error))
        known = [checks.one_of(f"verdict on {self.name!r}", "signal", name, self.names) for name in signals]
        columns = [self.names.index(name) for name in known] or list(self.telling)
        precision: dict[str, Any] = {"units": [self.units[k] for k in columns]}
        if self.resolution is not None:
            precision |= {"floor": 1.0, "sizes": self.resolution[columns]}
        names = [self.names[k] for k in columns]
        return judge(points[:, columns], names, exponent=value, error=band, **precision)


@arguments.checked
def stroboscopic(
    system: Any,
    *,
    keep: int,
    skip: int = 0,
    period: float | None = None,
    step: Step | None = None,
    method: Newmark | None = None,
    progress: bool = False,
) -> xr.Dataset:
    """States of a driven system once a period.

    Parameters
    ----------
    system : a mechanism, which starts from its reference configuration; or a flow or map, which continues from its
        present state and stays at the last point.  The points of a map are its iterations.
    keep : number of points.
    skip : periods before the first point.
    period : the period [s]; None: the common period of the drives.
    step, method : for a mechanism only, see `simulate`.
    progress : whether a progress bar with the remaining time is shown.

    Returns
    -------
    xarray.Dataset : dimension "period"; coordinates `period` (number, from `skip` on) and `time` [s]; a variable for
        each signal.  Attributes: name, kind "stroboscopic", period [s] (NaN for a map), skip, ok, status.  After a
        failure ok is 0, and the dataset holds the points before the failure.

    Raises
    ------
    InputError : numbers that are not whole, no point to keep, a system without a period (see `StroboscopicMap`).
    ModelError, AssemblyError, KernelError : a mechanism that cannot start.

    Examples
    --------
    >>> import flexmb as fm
    >>> logistic = fm.chaos.Map(lambda x, r: r * x * (1.0 - x), [0.3], parameters={"r": 3.2})
    >>> points = fm.stroboscopic(logistic, skip=1000, keep=4)
    >>> points.x0.values.round(4)
    array([0.7995, 0.513 , 0.7995, 0.513 ])
    """
    flow = as_dynamics("stroboscopic", system, period=period, step=step, method=method)
    strobe = strobe_of("stroboscopic", flow, period)
    return _collected(strobe, {"kind": "stroboscopic", "period": _length(strobe)}, skip, keep, progress)


def section(
    system: Any,
    signal: str,
    *,
    keep: int,
    skip: int = 0,
    level: float = 0.0,
    direction: str = "up",
    limit: float | None = None,
    period: float | None = None,
    step: Step | None = None,
    method: Newmark | None = None,
    progress: bool = False,
) -> xr.Dataset:
    """States of a system at which a signal crosses a level (Poincare section), located on the steps of the solver.

    Parameters
    ----------
    system : a mechanism, which starts from its reference configuration; or a flow, which continues from its present
        state and stays on the last crossing.
    signal : name of the signal, one of `names` of the flow; of a mechanism as in `sol[...]`.
    keep : number of crossings.
    skip : crossings before the first one that is kept.
    level : level of the section [unit of the signal].
    direction : "up", "down" or "both".
    limit : time without a crossing after which the search ends with a status [s]; None: see `SectionMap`.
    period : for a mechanism without periodic drives: approximate period of its motion [s].
    step, method : for a mechanism only, see `simulate`.
    progress : whether a progress bar with the remaining time is shown.

    Returns
    -------
    xarray.Dataset : as of `stroboscopic`, with the dimension "crossing", the kind "section", and the further attributes
        signal, level and direction.

    Raises
    ------
    InputError : a map; an unknown signal or direction; numbers that are not whole, no point to keep.
    ModelError, AssemblyError, KernelError : a mechanism that cannot start.

    Examples
    --------
    >>> import flexmb as fm
    >>> oscillator = fm.chaos.ODE(lambda t, x: [x[1], -x[0]], [1.0, 0.0], names=["x", "v"])
    >>> points = fm.chaos.section(oscillator, "v", keep=2)
    >>> points.time.values.round(6)
    array([3.141593, 9.424778])
    """
    flow = as_dynamics("section", system, period=period, step=step, method=method)
    if flow.underlying is not flow:
        raise InputError(f"section {flow.name!r}: a map has no crossings. Use stroboscopic(...).")
    crossings = SectionMap(flow.underlying, signal, level=level, direction=direction, limit=limit)
    about = {"kind": "section", "period": _length(flow), "signal": signal, "level": crossings.level}
    return _collected(crossings, {**about, "direction": direction}, skip, keep, progress)


def _length(system: Dynamics) -> float:
    return np.nan if system.period is None else float(system.period)


def _collected(system: Dynamics, about: dict[str, Any], skip: int, keep: int, progress: bool) -> xr.Dataset:
    """Table of `keep` points after `skip` points; the present state is the first stroboscopic point if skip is 0."""
    strobe, label = about["kind"] == "stroboscopic", f"{about['kind']} {system.name!r}"
    dimension = "period" if strobe else "crossing"
    skip, keep = checks.count(label, "skip", skip, 0), checks.count(label, "keep", keep)
    progress_bar = ProgressBar(system.name, float(skip + keep), shown=progress, of=f"{dimension}s")
    times, values = [], []
    for k in range(skip + keep):
        if (k > 0 or not strobe) and not system.advance(1):
            break
        progress_bar.update(1)
        if k >= skip:
            times.append(system.clock)
            values.append(system.observe())
    progress_bar.close()
    rows = np.array(values).reshape(len(times), len(system.names))
    units = "" if system.underlying is None else "s"
    status = system.status if len(times) < keep else f"{keep} {dimension}s, after {skip} that were skipped."
    if len(times) < keep:
        tell_stopped(label, status)
    about = {"name": system.name, **about, "skip": skip, "ok": int(len(times) == keep), "status": status}
    signals = enumerate(zip(system.names, system.units, strict=True))
    data = {name: (dimension, rows[:, k], {"units": unit}) for k, (name, unit) in signals}
    numbers: Any = (dimension, np.arange(skip, skip + len(times)), {})
    coords = {dimension: numbers, "time": (dimension, np.array(times), {"units": units})}
    return xr.Dataset(data, coords, about)
