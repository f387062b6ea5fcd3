"""Systems of a user's functions: differential equations with their variational equations, maps."""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from importlib import import_module
from itertools import product
from operator import attrgetter
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from flexmb import checks
from flexmb.dynamics.systems.differences import Values, central_differences, entering, samples, values_at
from flexmb.dynamics.systems.dynamics import ContinuousFlow, Dynamics, Parameters, State
from flexmb.errors import InputError, SolveError
from flexmb.late import scipy

if TYPE_CHECKING:
    from flexmb.dynamics.systems.compiled_ode import CompiledMotion


class GivenSystem(Dynamics):
    """Base of systems given by a function, its Jacobian, parameters and a start."""

    # `kind` is the word that messages begin with.
    kind: ClassVar[str]

    _time: float
    _state: np.ndarray
    _entering: np.ndarray | None  # coordinates seen in the values of the function; None: not yet sought
    _motion: CompiledMotion | None = None  # in compiled code

    def _declare(
        self, name: str, function: Callable[..., Any], start: Sequence[float] | np.ndarray,
        jacobian: Callable[..., Any] | None, parameters: Mapping[str, Any] | None, names: Sequence[str] | None,
    ) -> None:  # fmt: skip
        """Check and keep the arguments that every such system takes."""
        self.name = name
        label = self._label
        for what, value in (("function", function), ("jacobian", jacobian)):
            if not callable(value) and (what == "function" or value is not None):
                raise InputError(f"{label}: {what} is {value!r}; it must be a function.")
        self.function, self.jacobian = function, jacobian
        self.start, self._parameters = state_of(label, start), checks.mapping(label, "parameters", parameters)
        self.names = names_of(label, "names", names, [f"x{i}" for i in range(len(self.start))])

    @property
    def _label(self) -> str:
        return f"{self.kind} {self.name!r}"

    time: Any = property(attrgetter("_time"))

    @property
    def size(self) -> int:
        return len(self.start)

    @property
    def parameters(self) -> Mapping[str, Any]:
        return dict(self._parameters)

    def state(self) -> np.ndarray:
        return self._state.copy()

    observe = state

    def copy(self) -> Self:
        other = copy.copy(self)
        other._parameters, other._state = dict(self._parameters), self._state.copy()
        other._motion = self._motion and self._motion.copy()
        return other

    def _begin(self, state: np.ndarray | None, parameters: Mapping[str, Any] | None) -> None:
        """Take other parameters, and stand at `state`, or at the start."""
        for key, value in checks.mapping(self._label, "parameters", parameters).items():
            self._parameters[checks.one_of(self._label, "parameter", key, self._parameters)] = value
        if parameters is not None:
            self._entering = None
        self._state = self.start.copy() if state is None else state_of(self._label, state, self.size)
        self.ok, self.status = True, "ready"

    def _seen(self, function: Values) -> np.ndarray:
        """Coordinates that are seen in the values of the function of the system."""
        if self._entering is None:
            self._entering = entering(function, self.start)
        return self._entering


def state_of(owner: str, value: Any, size: int | None = None) -> np.ndarray:
    """`value` as a state (size,) of finite numbers, or `InputError`."""
    try:
        state = np.array(value, dtype=np.float64)
    except (TypeError, ValueError):  # complex numbers are TypeErrors, too
        raise InputError(f"{owner}: a state is {value!r}; it must be a list of numbers.") from None
    wanted = "(n,)" if size is None else f"({size},)"
    if state.ndim != 1 or len(state) == 0 or (size is not None and len(state) != size):
        raise InputError(f"{owner}: a state has shape {state.shape}; it must have shape {wanted}.")
    if not np.isfinite(state).all():
        raise InputError(f"{owner}: a state is {value!r}; all its numbers must be finite.")
    return state


def names_of(owner: str, what: str, value: Any, default: Sequence[str]) -> tuple[str, ...]:
    """`value` as so many different names (units: of any kind) as `default` has, which stands for None."""
    found = tuple(default) if value is None else checks.sequence(owner, what, value, "texts")
    if len(found) != len(default):
        raise InputError(f"{owner}: {len(found)} {what} for {len(default)} numbers of a state.")
    wrong = [x for x in found if not isinstance(x, str)] or [x for x in found if what == "names" and found.count(x) > 1]
    if wrong:
        raise InputError(f"{owner}: {what} has {wrong[0]!r}; it must hold texts, and no name twice.")
    return found


def tangents_of(owner: str, value: Any, size: int, advice: str = "Carry them for shorter times") -> np.ndarray:
    """`value` if differences (size, k) can be carried in it, in place, or `InputError` with an advice."""
    if not isinstance(value, np.ndarray) or value.ndim != 2 or len(value) != size or value.dtype != np.float64:
        text = f"{owner}: tangents have shape {np.shape(value)}"
        raise InputError(f"{text}; they must be a float64 array ({size}, k), one difference a column.")
    if not np.isfinite(value).all():
        raise InputError(f"{owner}: tangents hold numbers that are not finite. {advice}.")
    return value


def square_of(owner: str, value: Any, size: int) -> np.ndarray:
    """Value of a jacobian as a matrix (size, size), or `InputError`."""
    found = np.asarray(value, dtype=np.float64)
    if found.shape != (size, size):
        raise InputError(f"{owner}: jacobian has shape {found.shape}; it must have shape ({size}, {size}).")
    return found


class Map(GivenSystem):
    """The map x -> function(x, **parameters).

    Parameters
    ----------
    function : f(x, **parameters) -> next state (size,).
    start : start state (size,).
    jacobian : J(x, **parameters) -> df/dx (size, size); None: central differences.
    parameters : names and values of the parameters.
    names : names of the entries of a state; None: x0, x1, ...
    name : name in messages.

    Raises
    ------
    InputError : a start that is no list of finite numbers, names of another number, a function that returns no state,
        a jacobian of another shape, an argument that is no function.
    """

    kind = "Map"
    unit = "iterations"

    def __init__(
        self, function: Callable[..., Any], start: Sequence[float] | np.ndarray, *,
        jacobian: Callable[..., Any] | None = None, parameters: Mapping[str, Any] | None = None,
        names: Sequence[str] | None = None, name: str = "map",
    ) -> None:  # fmt: skip
        self._declare(name, function, start, jacobian, parameters, names)
        self.units = ("",) * len(self.names)
        self.reset(parameters=self._parameters)
        state_of(f"{self._label}: function", self._next(self.start.copy()), len(self.start))

    def reset(self, state: State = None, *, time: float = 0.0, parameters: Parameters = None) -> None:
        self._begin(state, parameters)
        self._time = float(time)

    def advance(self, duration: float, tangents: np.ndarray | None = None) -> bool:
        T = None if tangents is None else tangents_of(self._label, tangents, self.size)
        for _ in range(checks.count(self._label, "duration", duration, 0) if self.ok else 0):
            try:
                new = np.array(self._next(self._state.copy()), dtype=np.float64)
            except (OverflowError, ZeroDivisionError, FloatingPointError):
                new = np.array([np.nan])
            if not np.isfinite(new).all():
                self.ok, self.status = False, f"The state is not finite after {self._time:g} iterations."
                return False
            if T is not None:
                T[:] = self._slope(self._state) @ T
            self._state, self._time = new, self._time + 1.0
        return self.ok

    def _next(self, x: np.ndarray) -> Any:
        return self.function(x, **self._parameters)

    def _slope(self, x: np.ndarray) -> np.ndarray:
        if self.jacobian is not None:
            return square_of(self._label, self.jacobian(x.copy(), **self._parameters), self.size)
        return central_differences(self._next, x, self._seen(self._next))


METHODS = ("DOP853", "RK45", "Radau", "BDF")  # solvers of `scipy.integrate` whose next step size can be read and set
FINEST = 3e-14  # smallest relative tolerance of a step
# Absolute tolerance of tangent vectors of length 1, over rtol; they may shrink by 1e4 between two renormalisations.
TANGENT_ATOL = 1e-3
# Times [s] at which rates are compared, as a test of explicit dependence on time.
INSTANTS = (0.0, 1.3247180e-6, 1.7320508e-3, 0.1234567, 0.3819660, 0.7548777, 1.3247180, 27.182818, 1.6180340e4)


def compiled_motion(method: str, start: np.ndarray, parameters: Any, *functions: Any) -> CompiledMotion | None:
    """Motion in compiled code of functions that numba has compiled, by the one method of that code; else None."""
    if method != METHODS[0] or not all(type(function).__module__.startswith("numba.") for function in functions):
        return None
    for function, (state, _) in product(functions, samples(start)):
        given = state[None].copy()
        values_at(partial(function, 0.0, **parameters), given, len(start))
        if (given != state).any():  # that code gives them no copies
            return None
    made: CompiledMotion = import_module(f"{__package__}.compiled_ode").CompiledMotion(*functions)
    return made


class NotFiniteError(SolveError):
    """The rate of a state is not finite."""


class ODE(GivenSystem, ContinuousFlow):
    """The flow dx/dt = function(t, x, **parameters).

    Tangent vectors W obey the variational equations dW/dt = J W, which are integrated with the state.

    Parameters
    ----------
    function : f(t, x, **parameters) -> rates (size,).
    start : start state (size,) at t = 0.
    jacobian : J(t, x, **parameters) -> (size, size), df/dx; None: central differences.
    parameters : names and values of the parameters.
    names : names of the entries of a state; None: x0, x1, ...
    units : units of the entries; None: no units.
    period : period of the drive [s], or a function period(**parameters); None: no period.
    driven : whether f depends on t; None: yes with a period, else f is tested at some times and states.
    name : name in messages.
    rtol, atol : tolerances of a step, whose error is below atol + rtol |x|.
    method : solver of `scipy.integrate`: "DOP853", "RK45", "Radau" or "BDF".

    Raises
    ------
    InputError : a start that is no list of finite numbers, names or units of another number, an unknown method,
        tolerances out of range, a period that is not > 0, a function that returns no rates of a state, a jacobian of
        another shape.

    Notes
    -----
    f must be smooth; for jumps see `ImpactODE`.  A state or rate that is not finite ends the run with a status.
    A function under `@numba.njit` that returns a tuple of floats, with parameters that are numbers, is integrated in
    compiled code by "DOP853", hundreds of times as fast, in threads side by side; tangent vectors are not.

    Examples
    --------
    >>> import flexmb as fm
    >>> decay = fm.chaos.ODE(lambda t, x, k: -k * x, [1.0], parameters={"k": 2.0})
    >>> decay.advance(1.0)
    True
    >>> round(float(decay.state()[0]), 9)
    0.135335283
    """

    kind = "ODE"
    _h: float | None

    def __init__(
        self, function: Callable[..., Any], start: Sequence[float] | np.ndarray, *,
        jacobian: Callable[..., Any] | None = None, parameters: Mapping[str, Any] | None = None,
        names: Sequence[str] | None = None, units: Sequence[str] | None = None,
        period: float | Callable[..., float] | None = None, driven: bool | None = None, name: str = "ODE",
        rtol: float = 1e-9, atol: float = 1e-12, method: str = "DOP853",
    ) -> None:  # fmt: skip
        self._declare(name, function, start, jacobian, parameters, names)
        label, size = self._label, self.size
        self._given_period, self._given_driven = period, driven
        self.units = names_of(label, "units", units, ("",) * size)
        self.rtol = checks.between(label, "rtol", rtol, FINEST, 0.1)
        self.atol = checks.positive(label, "atol", atol)
        self.method = checks.one_of(label, "method", method, METHODS)
        self._motion = compiled_motion(self.method, self.start, self._parameters, function)
        self.reset(parameters=self._parameters)
        state_of(f"{label}: function", function(0.0, self.start.copy(), **self._parameters), size)

    @property
    def pace(self) -> float:
        if self._h is not None:
            return self._h
        size, speed = float(np.linalg.norm(self._state)), float(np.linalg.norm(self.velocity()))
        return 0.01 * (max(size, 1e-6) / speed) if speed > 0.0 else 0.01 * (self.period or 1.0)

    def reset(self, state: State = None, *, time: float = 0.0, parameters: Parameters = None) -> None:
        self._begin(state, parameters)
        label = self._label
        self._time, self._h = checks.number(label, "time", time, "s"), None
        if parameters is None:
            return
        given = self._given_period
        period = given(**self._parameters) if callable(given) else given
        self.period = None if period is None else checks.positive(label, "period", period, "s")
        self.driven = self._depends_on_time() if self._given_driven is None else bool(self._given_driven)
        if self._motion is not None:
            self._motion.take(self._parameters)

    def advance(self, duration: float, tangents: np.ndarray | None = None) -> bool:
        return self._go(self._time + checks.positive(self._label, "duration", duration, "s"), tangents, single=False)

    def take_step(self, limit: float, tangents: np.ndarray | None = None) -> bool:
        return self._go(limit, tangents, single=True)

    def seek(self, signal: int, level: float, side: int, limit: float) -> bool | None:
        if self._motion is None or not self._motion.usable or not self.ok:
            return None
        return self._motion.run(self, limit, section=(signal, level, side))

    def velocity(self) -> np.ndarray:
        return self._rate(self._time, self._state)

    def rate(self, signal: int) -> float:
        return float(self.velocity()[signal])

    def slopes(self, signal: int, tangents: np.ndarray) -> np.ndarray:
        return np.array(tangents[signal])

    def snapshot(self) -> Any:
        return self._time, self._state.copy(), self._h, self.ok, self.status

    def restore(self, snapshot: Any) -> None:
        self._time, state, self._h, self.ok, self.status = snapshot
        self._state = state.copy()

    @property
    def fineness(self) -> str:
        return f"rtol {self.rtol:g}"

    def finer(self) -> Self:
        other = self.copy()
        other.rtol = max(self.rtol / 10.0, FINEST)
        other.atol = self.atol * other.rtol / self.rtol
        return other

    def _rate(self, t: float, x: np.ndarray) -> np.ndarray:
        try:
            with np.errstate(all="ignore"):
                rate = np.array(self.function(t, x.copy(), **self._parameters), dtype=np.float64)
        except (OverflowError, ZeroDivisionError, FloatingPointError) as error:
            raise NotFiniteError(f"{error}") from error
        if not np.isfinite(rate).all():
            raise NotFiniteError("a rate is not finite")
        return rate

    def _depends_on_time(self) -> bool:
        if self.period is not None:
            return True
        rates = [partial(self.function, t, **self._parameters) for t in INSTANTS]
        for state, _ in samples(self.start):  # a factor of the drive may vanish at the start
            values = np.vstack([values_at(rate, state[None].copy(), self.size) for rate in rates])
            values = values[np.isfinite(values).all(axis=1)]
            if (values != values[:1]).any():
                return True
        return False

    def _slope(self, t: float, x: np.ndarray, rate: np.ndarray) -> np.ndarray:
        if self.jacobian is not None:
            return square_of(self._label, self.jacobian(t, x.copy(), **self._parameters), self.size)
        f, p = self.function, self._parameters
        return central_differences(lambda y: f(t, y, **p), x, self._seen(lambda y: f(max(INSTANTS), y, **p)), rate)

    def _go(self, limit: float, tangents: np.ndarray | None, *, single: bool) -> bool:
        """Integrate up to `limit`, or by one step (`single`); state and tangents stay at the last successful step."""
        if not self.ok or limit <= self._time:  # a duration below the spacing of the clock
            return self.ok
        if tangents is None and self._motion is not None and self._motion.usable:
            self._motion.run(self, limit, single=single)
            return self.ok
        lengths = np.ones(0)
        if tangents is not None:
            tangents = tangents_of(self._label, tangents, self.size)
            lengths = np.abs(tangents).max(axis=0, initial=0.0)
            lengths[lengths == 0.0] = 1.0
            tangents /= lengths
        trouble: str | None = None
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            try:
                solver = self._solver(limit, tangents)
                while solver.status == "running" and trouble is None:
                    before = solver.h_abs
                    trouble = solver.step() if np.isfinite(solver.y).all() else "the state is not finite"
                    if trouble is None:
                        self._time, self._state = float(solver.t), solver.y[: self.size].copy()
                        self._h = float(max(before, solver.h_abs) if solver.t >= limit else solver.h_abs)
                        if tangents is not None:
                            tangents[:] = solver.y[self.size :].reshape(tangents.shape)
                    if single:
                        break
            except NotFiniteError as error:
                trouble = str(error)
        if tangents is not None:
            tangents *= lengths
        self.ok = trouble is None
        text = "Reached" if trouble is None else f"Stopped: {trouble.rstrip('.')},"
        self.status = f"{text} {'at ' if trouble else ''}t = {self._time:.6g} s."
        return self.ok

    def _solver(self, limit: float, tangents: np.ndarray | None) -> Any:
        """A solver from the present state, whose first step has the size that the last solver proposed."""
        kind = getattr(scipy.integrate, self.method)
        first = None if self._h is None else min(self._h, limit - self._time)
        if tangents is None:
            return kind(self._rate, self._time, self._state, limit, first_step=first, rtol=self.rtol, atol=self.atol)
        n, k = tangents.shape

        def both(t: float, y: np.ndarray) -> np.ndarray:
            rate = self._rate(t, y[:n])
            return np.concatenate([rate, (self._slope(t, y[:n], rate) @ y[n:].reshape(n, k)).ravel()])

        y = np.concatenate([self._state, tangents.ravel()])
        atol = np.concatenate([np.full(n, self.atol), np.full(n * k, TANGENT_ATOL * self.rtol)])
        return kind(both, self._time, y, limit, first_step=first, rtol=self.rtol, atol=atol)
