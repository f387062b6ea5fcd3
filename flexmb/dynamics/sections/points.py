"""Points of sections as labelled tables: once a period, or at every crossing of a level."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from flexmb import arguments, checks
from flexmb.dynamics.sections.section_map import SectionMap
from flexmb.dynamics.sections.stroboscopic import StroboscopicMap
from flexmb.dynamics.systems.as_dynamics import clock, dynamics_of, strobe_of
from flexmb.dynamics.systems.continuous_flow import ContinuousFlow
from flexmb.dynamics.systems.dynamics import Dynamics
from flexmb.errors import InputError
from flexmb.jobs.attempt import tell_stopped
from flexmb.jobs.progress import ProgressBar
from flexmb.run.simulate import Step
from flexmb.step.newmark.method import Newmark

if TYPE_CHECKING:
    import xarray as xr


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
    flow = dynamics_of("stroboscopic", system, period=period, step=step, method=method)
    strobe = strobe_of("stroboscopic", flow, period)
    length = strobe.period if isinstance(strobe, StroboscopicMap) else np.nan
    return _collected(strobe, "stroboscopic", "period", skip, keep, progress, {"period": float(length)})


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
    flow = dynamics_of("section", system, period=period, step=step, method=method)
    if not isinstance(flow, ContinuousFlow):
        raise InputError(f"section {flow.name!r}: a map has no crossings. Use stroboscopic(...).")
    crossings = SectionMap(flow, signal, level=level, direction=direction, limit=limit)
    length = np.nan if flow.period is None else flow.period
    attrs = {"period": float(length), "signal": signal, "level": crossings.level, "direction": direction}
    return _collected(crossings, "section", "crossing", skip, keep, progress, attrs)


def _collected(
    system: Dynamics, kind: str, dimension: str, skip: int, keep: int, progress: bool, attrs: dict[str, Any]
) -> xr.Dataset:
    """Table of `keep` points after `skip` points; the present state is the first stroboscopic point if skip is 0."""
    import xarray as xr

    label = f"{kind} {system.name!r}"
    skip, keep = checks.count(label, "skip", skip, 0), checks.count(label, "keep", keep)
    strobe = dimension == "period"
    progress_bar = ProgressBar(system.name, float(skip + keep), shown=progress, of=f"{dimension}s")
    times, values = [], []
    for k in range(skip + keep):
        if (k > 0 or not strobe) and not system.advance(1):
            break
        progress_bar.update(1)
        if k >= skip:
            times.append(clock(system))
            values.append(system.observe())
    progress_bar.close()
    rows = np.array(values).reshape(len(times), len(system.names))
    units = "s" if isinstance(system, (StroboscopicMap, SectionMap)) else ""
    status = system.status if len(times) < keep else f"{keep} {dimension}s, after {skip} that were skipped."
    if len(times) < keep:
        tell_stopped(label, status)
    about = {"name": system.name, "kind": kind, **attrs, "skip": skip, "ok": int(len(times) == keep), "status": status}
    data = {
        n: (dimension, rows[:, k], {"units": u})
        for k, (n, u) in enumerate(zip(system.names, system.units, strict=True))
    }
    coords = {
        dimension: (dimension, np.arange(skip, skip + len(times)), {}),
        "time": (dimension, np.array(times), {"units": units}),
    }
    return xr.Dataset(data, coords, about)
