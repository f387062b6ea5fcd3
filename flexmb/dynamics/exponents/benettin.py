"""The largest Lyapunov exponent from two trajectories."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmb import checks
from flexmb.dynamics.exponents.exponents import Exponents, with_verdict
from flexmb.dynamics.exponents.renormalisation import TOO_MUCH, exponents_of
from flexmb.dynamics.exponents.schedule import RenormalisationSchedule, refuse_idle_arguments, schedule_of
from flexmb.dynamics.systems.as_dynamics import clock, dynamics_of
from flexmb.dynamics.systems.continuous_flow import ContinuousFlow
from flexmb.dynamics.systems.dynamics import Dynamics
from flexmb.dynamics.systems.mechanism_flow import MechanismFlow
from flexmb.jobs.attempt import tell_stopped
from flexmb.run.simulate import Step
from flexmb.step.newmark.method import Newmark

APART, APART_IN_CONTACT = 1e-6, 1e-9
"""Default distance of two trajectories over the length of the state: without contacts, with contacts.

Contacts are nonlinear beyond a distance of some 1e-8 m."""


def benettin(
    system: Any,
    *,
    skip: float = 0,
    periods: int | None = None,
    duration: float | None = None,
    distance: float | None = None,
    interval: float | None = None,
    period: float | None = None,
    step: Step | None = None,
    method: Newmark | None = None,
    seed: int = 0,
    progress: bool = False,
) -> Exponents:
    """The largest Lyapunov exponent from two neighbouring trajectories; no tangent of the system is needed.

    Once a period the distance of the second trajectory from the first one is restored, along the line between them
    (G. Benettin, L. Galgani, J.-M. Strelcyn, Phys. Rev. A 14 (1976) 2338).  A mechanism is then projected onto its
    constraints, and both trajectories restart so that they take equal steps.

    Parameters
    ----------
    system : a mechanism, which starts from its reference configuration; or a flow or map, which continues from its
        present state.
    skip, periods, duration, interval, period, step, method, seed, progress : see `lyapunov`.
    distance : distance of the trajectories in the weights of the system (for a mechanism [m]); None: 1e-6 of the length
        of the state, 1e-9 for a mechanism with contacts.

    Returns
    -------
    Exponents : see `lyapunov`; one exponent.

    Raises
    ------
    InputError : see `lyapunov`; a distance that is not > 0.
    ModelError, AssemblyError, KernelError : a mechanism that cannot start.

    Notes
    -----
    The distance must be far above the errors of the steps in one period, and small enough for linear growth.  The range
    between is narrow for error-controlled steps of a mechanism, so `FixedStep` is the better choice.  In contact the
    distance must be far below the penetration: with 2.6e-7 m the worn slider-crank at 5000 rpm gives 356 1/s, with
    1e-9 m and 1e-11 m 464 1/s, as `lyapunov` does (467 +/- 20).

    Examples
    --------
    >>> import flexmb as fm
    >>> import numpy as np
    >>> tent = fm.chaos.Map(lambda x, a: a * np.minimum(x, 1.0 - x), [0.3], parameters={"a": 1.5})
    >>> found = fm.chaos.benettin(tent, skip=100, periods=1000)
    >>> round(found.value, 3)  # ln 1.5
    0.405
    """
    flow = dynamics_of("benettin", system, period=period, step=step, method=method)
    refuse_idle_arguments("benettin", system, flow, duration, interval, period)
    schedule = schedule_of("benettin", flow, skip, periods, duration, interval, period)
    seed = checks.count(f"benettin {flow.name!r}", "seed", seed, 0)
    exponents = exponents_of(
        schedule, lambda: TrajectoryPair.beside(schedule.system, distance, seed), 1, shown=progress
    )
    if not exponents.ok:
        tell_stopped(f"benettin {flow.name!r}", exponents.status)
    return with_verdict(exponents) if schedule.is_section else exponents


@dataclass
class TrajectoryPair:
    """Two trajectories at a small distance.

    Parameters
    ----------
    first, second : the systems.
    weights : weights (size,) of the squares of differences.
    distance : distance that a renormalisation restores.
    size : distance after the last renormalisation.
    """

    first: Dynamics
    second: Dynamics
    weights: np.ndarray
    distance: float
    size: float = 0.0

    strained_fraction = 0.0

    @classmethod
    def beside(cls, first: Dynamics, distance: float | None, seed: int) -> TrajectoryPair:
        """`first` and a copy at a distance in a random direction, see `benettin`."""
        weights, x = first.weights, first.state()
        fraction = APART_IN_CONTACT if isinstance(first, MechanismFlow) and first.program.normals else APART
        usual = fraction * (float(np.sqrt(weights @ x**2)) or 1.0)
        wanted = usual if distance is None else checks.positive(f"benettin {first.name!r}", "distance", distance)
        pair = cls(first, first.copy(), weights, wanted)
        pair.renormalise(first.tangent_basis(1, seed)[:, 0])
        return pair

    def difference(self) -> np.ndarray:
        """Difference (size,) of the states, second less first."""
        return np.asarray(self.second.state() - self.first.state())

    def length(self, difference: np.ndarray) -> float:
        """Length of a `difference` (size,) in the weights."""
        return float(np.sqrt(self.weights @ difference**2))

    def renormalise(self, direction: np.ndarray) -> None:
        """Restart both systems, the second at `distance` in a `direction` (size,) of any length."""
        x, time = self.first.state(), self.first.time
        if isinstance(self.first, ContinuousFlow):
            self.first.reset(x, time=time)
        self.second.reset(x + self.distance / self.length(direction) * direction, time=time)
        self.size = self.length(self.difference())

    def is_strained(self, logs: np.ndarray) -> bool:
        """Whether the distance grew by more than `TOO_MUCH` (`logs`: logarithm (1,) of the growth)."""
        return bool(logs[0] > np.log(TOO_MUCH))

    def growth(self, schedule: RenormalisationSchedule, number: int, begin: float, end: float) -> np.ndarray | None:  # noqa: ARG002
        """Logarithm (1,) of the growth of the distance; None if a system fails or the trajectories meet."""
        reached = [schedule.advance(system, number, end) for system in (self.first, self.second)]
        if not all(reached):
            schedule.trouble = (self.first if not reached[0] else self.second).status
            return None
        difference = self.difference()
        difference[schedule.records] = 0.0  # bookkeeping would grow without bound if the distance shrinks
        length = self.length(difference)
        if length == 0.0 or self.size == 0.0:
            schedule.trouble = f"The two trajectories met at {clock(self.first):.6g}; give a larger distance."
            return None
        growth = length / self.size
        self.renormalise(difference)
        return np.array([np.log(growth)])
