"""Base classes of systems: a present state that is advanced, alone or with tangents; flows with steps."""

from __future__ import annotations

import copy
import sys
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from functools import partial
from operator import attrgetter
from types import FunctionType
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from flexmb import checks
from flexmb.display import counted
from flexmb.errors import InputError

if TYPE_CHECKING:
    from flexmb.engine.newmark.method import Newmark
    from flexmb.run.simulate import Step

# Period [s], or a function of the parameters that returns it; None: that of the system.
Period = float | Callable[[Mapping[str, Any]], float] | None
State = np.ndarray | None  # a state (size,); None: the system's own start
Parameters = Mapping[str, Any] | None  # new values by name; None: no other ones
SMALL = 1e-6  # length of a difference, over that of the state, at which two trajectories part as tangent vectors grow


class Dynamics(ABC):
    """A dynamical system with a present state.

    A flow counts time in seconds, a map in iterations.  A section of a flow is a map.  All tools use only the members
    of this class, and so serve mechanisms, ordinary differential equations and maps alike.

    Attributes
    ----------
    name : name in messages and files.
    unit : unit of time: "s" for a flow, "iterations" for a map, "periods" or "crossings" for a section.
    names : names of the signals that `observe` returns.
    units : units of the signals.
    period : period of the drives [s]; None: no period.
    status : result of the last call, in a sentence.
    ok : whether the system can be advanced; after a failure `reset` makes it True again.
    """

    name: str
    unit: str
    period: float | None = None
    names: tuple[str, ...]
    units: tuple[str, ...]
    status: str
    ok: bool

    def __repr__(self) -> str:
        ending = "" if self.ok else f"; {self.status}"
        signals = counted(len(self.names), "signal")
        return f"{type(self).__name__} of {self.name!r}: {signals}, at {self.time:.6g} {self.unit}{ending}"

    @property
    def _label(self) -> str:
        return f"{type(self).__name__} of {self.name!r}"

    @property
    @abstractmethod
    def time(self) -> float:
        """Time of the present state [unit]."""

    @property
    def underlying(self) -> ContinuousFlow | None:
        """The flow in time whose motion this is: a flow itself, the flow of a section; None: a map."""
        return None

    @property
    def clock(self) -> float:
        """Time by which exponents count: seconds of a flow and of its sections, iterations of a map."""
        return self.time if self.underlying is None else self.underlying.time

    @property
    @abstractmethod
    def size(self) -> int:
        """Number of entries of a state, and of rows of tangent vectors."""

    @property
    def dimension(self) -> int:
        """Number of independent directions of a small difference; also the number of exponents."""
        return self.size

    @property
    def weights(self) -> np.ndarray:
        """Weights (size,) >= 0 of the squares of the entries in the length of a tangent vector.

        They make lengths and velocities comparable.  No exponent depends on them.  An entry with the weight 0 depends
        on the others.
        """
        return np.ones(self.size)

    @property
    def records(self) -> np.ndarray:
        """Rows (m,) of the state that are bookkeeping: the motion does not depend on them."""
        return np.zeros(0, dtype=np.int64)

    @property
    def state_names(self) -> Mapping[str, int]:
        """Rows of the state by name, as far as they have names."""
        return {name: k for k, name in enumerate(self.names)} if len(self.names) == self.size else {}

    @property
    def angles(self) -> np.ndarray:
        """Rows (m,) of the state that are angles, equal after whole turns."""
        return np.zeros(0, dtype=np.int64)

    @property
    def cycles(self) -> Mapping[int, float]:
        """Rows of the state that count modulo a length, with this length."""
        return dict.fromkeys(self.angles.tolist(), 2.0 * np.pi)

    @property
    def histories(self) -> tuple[np.ndarray, np.ndarray]:
        """Rows without weight that must return on a periodic orbit, and rows that need not."""
        return np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64)

    @property
    def gaps(self) -> Mapping[str, float]:
        """Signals that measure gaps of contacts, by name: 1.0 if open is > 0, -1.0 if open is < 0."""
        return {}

    @property
    def is_rough(self) -> bool:
        """Whether the end of a motion is smooth in its start only up to the errors of the steps."""
        return False

    @property
    def small(self) -> float:
        """Length of a difference, over that of the state, at which two trajectories part as tangent vectors grow."""
        return SMALL

    @property
    def telling(self) -> tuple[int, ...]:
        """Numbers in `names` of the signals on which a verdict rests by default."""
        return tuple(range(len(self.names)))

    @property
    def main_signals(self) -> tuple[str, ...]:
        """Names of the signals that a report analyses by default."""
        return self.names[:1]

    @property
    def resolution(self) -> np.ndarray | None:
        """Differences (len(names),) of the signals that integration errors can make; None: 1e-6 of their sizes."""
        return None

    @property
    @abstractmethod
    def parameters(self) -> Mapping[str, Any]:
        """Names and present values of the parameters that `reset` can change."""

    @abstractmethod
    def state(self) -> np.ndarray:
        """A copy of the present state (size,)."""

    @abstractmethod
    def observe(self) -> np.ndarray:
        """Present values (len(names),) of the signals."""

    @abstractmethod
    def reset(self, state: State = None, *, time: float = 0.0, parameters: Parameters = None) -> None:
        """Go to a state, with changed parameters if any are given.

        Parameters
        ----------
        state : the state (size,); None: the system's own start.
        time : time of that state [unit].
        parameters : new values by name; other parameters keep their values.

        Raises
        ------
        InputError : a state of another size, an unknown parameter, an inadmissible value.
        """

    @abstractmethod
    def advance(self, duration: float, tangents: np.ndarray | None = None) -> bool:
        """Advance by a duration [unit]; whether the end was reached. If not, `status` has the reason.

        Parameters
        ----------
        duration : duration, > 0; a whole number for maps and sections.
        tangents : tangent vectors (size, k), float64 in C order, advanced in place.
        """

    def remarks(self, since: float) -> list[str]:  # noqa: ARG002 - most systems have none
        """Remarks on exponents from a time `since` on [s], such as a tangent without the last onset of a contact."""
        return []

    def prepare(self) -> bool:
        """Compilation of a first step, for copies in other processes; returns whether it succeeded."""
        return self.ok

    def required_period(self, owner: str) -> float:
        """The period of the drives [s]; `InputError` without one, with the name of the caller `owner`."""
        if self.period is None:
            text = f"{owner}: {self.name!r} has no period"
            raise InputError(f"{text}. Give period= [s], a number or a function of the value.")
        return float(self.period)

    def makings(self) -> list[Any]:
        """Objects besides state and parameters on which the motion depends, such as functions and inner systems."""
        return [v for _, v in sorted(vars(self).items()) if isinstance(v, (FunctionType, partial, Dynamics))]

    def velocity(self) -> np.ndarray:
        """Rate (size,) of the present state of a flow: a tangent vector with the exponent 0 in bounded motion.

        Raises
        ------
        InputError : a map.
        """
        raise InputError(f"{self.name!r} is a map: it has no velocity. Take an exponent of its iterations.")

    def tangent_basis(self, count: int, seed: int = 0) -> np.ndarray:
        """Tangent vectors (size, `count`), orthonormal in the weights, from random directions of a `seed`.

        Raises
        ------
        InputError : more vectors than dimensions; a count or seed that is not whole.
        """
        count, seed = checks.count(f"{self.name!r}", "count", count), checks.count(f"{self.name!r}", "seed", seed, 0)
        if count > self.dimension:
            text = f"{self.name!r}: {count} tangent vectors are asked for"
            raise InputError(f"{text}; it has 1 to {self.dimension} independent ones.")
        W = self.on_manifold(np.random.default_rng(seed).standard_normal((self.size, count)))
        orthonormalise(W, self.weights)
        return W

    def on_manifold(self, tangents: np.ndarray) -> np.ndarray:
        """Projection of differences `tangents` (size, k) onto the differences that satisfy the constraints."""
        return np.ascontiguousarray(tangents, dtype=np.float64)

    def go_to_section(self) -> bool:
        """Advance a section's flow to its first point, if it is not at one; returns whether there is one."""
        return self.ok

    def on_section(self, tangents: np.ndarray) -> np.ndarray:
        """Differences `tangents` (size, k), of a section moved along the motion onto it."""
        return tangents

    @abstractmethod
    def copy(self) -> Self:
        """Independent copy of the system with an equal state."""

    @property
    def fineness(self) -> str:
        """Accuracy of the steps in words, such as "rtol 1e-05"; "" for a map."""
        return ""

    def finer(self) -> Self:
        """A copy with finer steps: a tenth of the tolerance, or half of a fixed step; of a map a plain copy."""
        return self.copy()

    def another_start(self, distance: float, seed: int) -> np.ndarray:
        """A state (size,) at a `distance` from the present one, over its length, in a random direction of a `seed`."""
        x, direction = self.state(), self.tangent_basis(1, seed)[:, 0]
        return x + distance * (float(np.sqrt(self.weights @ x**2)) or 1.0) * direction


def orthonormalise(tangents: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Make columns of `tangents` (size, k) orthonormal in weights (size,), in place; returns their lengths (k,)."""
    # The length of a column is that of its component orthogonal to the columns before it, so that the logarithms of the
    # lengths add up to Lyapunov exponents (G. Benettin et al., Meccanica 15 (1980)). Modified Gram-Schmidt, applied
    # twice. Entries without weight follow the others. Columns may be so long that their squares overflow.
    with np.errstate(over="ignore", invalid="ignore"):  # the lengths show columns that are not finite
        lengths = np.asarray(np.abs(np.where(weights[:, None] > 0.0, tangents, 0.0)).max(axis=0, initial=0.0))
        lengths[lengths == 0.0] = 1.0
        scaled = np.isfinite(lengths)
        tangents[:, scaled] /= lengths[scaled]
        for _ in range(2):
            for j in range(tangents.shape[1]):
                column = tangents[:, j]
                for i in range(j):
                    column -= (weights * tangents[:, i] @ column) * tangents[:, i]
                size = float(np.sqrt(weights * column @ column))
                lengths[j] *= size
                if size > 0.0:
                    column /= size
    return lengths


class ContinuousFlow(Dynamics):
    """A system in continuous time with step sizes chosen by its integrator."""

    unit = "s"
    driven: bool  # whether the rates depend on time; then a point of a section includes the time

    @property
    def underlying(self) -> ContinuousFlow:
        return self

    @property
    @abstractmethod
    def pace(self) -> float:
        """Typical size of a step [s]."""

    @property
    def shortest(self) -> float:
        """Shortest time [s] that `advance` covers reliably; 0: limited by round-off of the time alone."""
        return 0.0

    @abstractmethod
    def take_step(self, limit: float, tangents: np.ndarray | None = None) -> bool:
        """Advance by one step; returns whether it succeeded.

        Parameters
        ----------
        limit : a time after the present time [s], beyond which the step does not go; it changes a step only if near.
        tangents : tangent vectors (size, k), advanced in place.
        """

    def seek(self, signal: int, level: float, side: int, limit: float) -> bool | None:  # noqa: ARG002 - most cannot
        """Advance to the next crossing of a level in one call, where the flow can.

        Parameters
        ----------
        signal, level : number of the signal in `names`, and level [unit of the signal].
        side : side of the level before the crossing, 1 above, -1 below.
        limit : time [s] at which the search ends.

        Returns
        -------
        bool or None : whether there was a crossing; None: the flow has to be searched step by step.
        """
        return None

    @abstractmethod
    def snapshot(self) -> Any:
        """Complete present state, step control included, for `restore`."""

    @abstractmethod
    def restore(self, snapshot: Any) -> None:
        """Return to the state of a `snapshot`; the motion then continues with the same bits."""

    def before_jump(self) -> Any:
        """Snapshot just before the jump with which the last step ended; None: the state does not jump."""
        return None

    @abstractmethod
    def rate(self, signal: int) -> float:
        """Rate [units/s] of the signal number `signal` in `names` along the motion."""

    @abstractmethod
    def slopes(self, signal: int, tangents: np.ndarray) -> np.ndarray:
        """Changes (k,) of the signal of number `signal` by small differences `tangents` (size, k) of the state."""

    def number_of(self, owner: str, signal: str) -> int:
        """Number in `names` of a `signal`, or an `InputError` of the caller `owner`."""
        return self.names.index(checks.one_of(owner, "signal", signal, self.names))

    def has_cheap_rate(self, signal: int) -> bool:  # noqa: ARG002 - most flows know the rates of all signals
        """Whether the `rate` of a `signal` costs less than a step; then every step is searched for two crossings."""
        return True

    def no_period(self) -> str:
        """Reason why the flow has no period, as a sentence without its end."""
        return f"{self.name!r} has no period"


class OfFlow(Dynamics):
    """Base class of systems with the state, signals and parameters of an inner flow."""

    flow: ContinuousFlow
    size: Any = property(attrgetter("flow.size"))
    dimension: Any = property(attrgetter("flow.dimension"))
    weights: Any = property(attrgetter("flow.weights"))
    records: Any = property(attrgetter("flow.records"))
    telling: Any = property(attrgetter("flow.telling"))
    resolution: Any = property(attrgetter("flow.resolution"))
    parameters: Any = property(attrgetter("flow.parameters"))
    fineness: Any = property(attrgetter("flow.fineness"))
    state: Any = property(attrgetter("flow.state"))
    observe: Any = property(attrgetter("flow.observe"))

    def copy(self) -> Self:
        other = copy.copy(self)
        other.flow = self.flow.copy()
        return other

    def finer(self) -> Self:
        other = copy.copy(self)
        other.flow = self.flow.finer()
        return other


def is_mechanism(system: Any) -> bool:
    """Whether `system` is a `Mechanism`; without an import of mechanics there is none."""
    model = sys.modules.get("flexmb.model.mechanism")
    return model is not None and isinstance(system, model.Mechanism)


def as_dynamics(
    caller: str, system: Any, *, period: float | None = None, step: Step | None = None, method: Newmark | None = None,
    wanted: str = "a Mechanism, or a flow or map as ODE, Map, StroboscopicMap",
) -> Dynamics:  # fmt: skip
    """`system` itself, or the flow of a mechanism; a `Dynamics` with a step or a method (it has its own) is refused."""
    if is_mechanism(system):
        from flexmb.dynamics.systems.mechanism_flow import MechanismFlow

        return MechanismFlow(system, step=step, method=method, period=period)
    flow: Dynamics = checks.instance(caller, "system", system, Dynamics, wanted)
    if step is not None or method is not None:
        text = f"{caller} {flow.name!r}: step= and method= belong to a mechanism"
        raise InputError(f"{text}; this system has its own. Give them where the system is built.")
    return flow
