"""Lyapunov exponents from tangent vectors."""

from __future__ import annotations

from typing import Any

from flexmb import arguments, checks
from flexmb.dynamics.exponents.exponents import Exponents, with_verdict
from flexmb.dynamics.exponents.renormalisation import tangent_exponents
from flexmb.dynamics.exponents.schedule import refuse_idle_arguments, schedule_of
from flexmb.dynamics.exponents.second_run import confirmed
from flexmb.dynamics.systems.as_dynamics import dynamics_of
from flexmb.jobs.attempt import tell_stopped
from flexmb.run.simulate import Step
from flexmb.step.newmark.method import Newmark


@arguments.checked
def lyapunov(
    system: Any,
    *,
    skip: float = 0,
    periods: int | None = None,
    duration: float | None = None,
    count: int = 1,
    interval: float | None = None,
    period: float | None = None,
    step: Step | None = None,
    method: Newmark | None = None,
    seed: int = 0,
    confirm: bool = True,
    progress: bool = False,
) -> Exponents:
    """Lyapunov exponents of a system, from tangent vectors that are advanced with the motion.

    The vectors are made orthonormal once a period, and more often if they grow by more than 1e4.  The exponents are the
    means of the logarithms of their lengths (G. Benettin et al., Meccanica 15 (1980) 9).  The first tenth of the run is
    not counted: the vectors turn to their directions.

    Parameters
    ----------
    system : a mechanism, which starts from its reference configuration; or a flow or map, which continues from its
        present state.
    skip : number of periods (iterations, crossings) before the run, for the transient; with `duration` seconds.
    periods : number of periods of a driven system, of iterations of a map, or of crossings of a section.
    duration : duration [s], for a flow without a period, in place of `periods`.  One of its exponents is 0.
    count : number of exponents, the largest first.
    interval : with `duration`, time between two points of the history [s]; None: a thousandth of the duration.
    period : the period [s]; None: the common period of the drives.
    step, method : for a mechanism only, see `simulate`.
    seed : seed of the random directions in which the vectors start.
    confirm : whether a second run confirms the first one.  It has a fifth of the periods (20 at least), a tenth of the
        tolerance or half of a fixed step, and another start: beside the final state of the first run or, if a contact
        never opened, the mechanism's own start and the whole of `skip`.  Its difference goes into the errors, and the
        verdict is "chaotic" only if both runs agree.  False: errors and verdict of one run.
    progress : whether a progress bar with the remaining time is shown.

    Returns
    -------
    Exponents : in 1/s for flows and their sections, in 1/iteration for maps; with errors, convergence history, section
        points and verdict.  After a failure midway ok is False, and the record holds the results before the failure.

    Raises
    ------
    InputError : too few periods or intervals; neither or both of periods and duration; a duration of a map; more
        exponents than the system has directions.
    ModelError, AssemblyError, KernelError : a mechanism that cannot start.

    Notes
    -----
    The exponent belongs to the numerical motion.  The method damps vibrations that the steps do not resolve, so a
    negative exponent may be numerical dissipation, as in slow mechanisms with clearance: repeat the run with shorter
    steps, `step=Adaptive(max=...)`, or without dissipation, `method=Newmark.trapezoidal()`.  Hard impacts need a finer
    tolerance than the motion itself; the second run shows whether, and `step=Adaptive(rtol=...)` sets it.

    The system stays at the end of the first run.

    Examples
    --------
    >>> import flexmb as fm
    >>> import numpy as np
    >>> tent = fm.chaos.Map(lambda x, a: a * np.minimum(x, 1.0 - x), [0.3], parameters={"a": 1.5})
    >>> found = fm.lyapunov(tent, skip=100, periods=1000)
    >>> round(found.value, 9)  # ln 1.5
    0.405465108
    """
    flow = dynamics_of("lyapunov", system, period=period, step=step, method=method)
    refuse_idle_arguments("lyapunov", system, flow, duration, interval, period)
    schedule = schedule_of("lyapunov", flow, skip, periods, duration, interval, period)
    seed = checks.count(f"lyapunov {flow.name!r}", "seed", seed, 0)
    count = checks.count(f"lyapunov {flow.name!r}", "count", count)
    exponents = tangent_exponents(schedule, count, seed, shown=progress)
    if confirm and exponents.ok:
        exponents = confirmed(exponents, schedule, seed + 1, shown=progress)
    if not exponents.ok:
        tell_stopped(f"lyapunov {flow.name!r}", exponents.status)
    return with_verdict(exponents) if schedule.is_section else exponents
