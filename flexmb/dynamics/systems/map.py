"""Maps given by a function, and checks of the arguments that maps and differential equations share."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Self

import numpy as np

from flexmb import checks
from flexmb.dynamics.systems.dynamics import Dynamics
from flexmb.errors import InputError


class Map(Dynamics):
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

    unit = "iterations"

    def __init__(
        self,
        function: Callable[..., Any],
        start: Sequence[float] | np.ndarray,
        *,
        jacobian: Callable[..., Any] | None = None,
        parameters: Mapping[str, Any] | None = None,
        names: Sequence[str] | None = None,
        name: str = "map",
    ) -> None:
        label = f"Map {name!r}"
        self.name, self.function, self.jacobian = name, function_of(label, "function", function), jacobian
        if jacobian is not None:
            function_of(label, "jacobian", jacobian)
        self.start, self._parameters = state_of(label, start), checks.mapping(label, "parameters", parameters)
        self.names = names_of(label, "names", names, [f"x{i}" for i in range(len(self.start))])
        self.units = ("",) * len(self.names)
        self.reset()
        state_of(f"Map {name!r}: function", self._next(self.start), len(self.start))

    @property
    def time(self) -> float:
        return self._time

    @property
    def size(self) -> int:
        return len(self.start)

    @property
    def parameters(self) -> Mapping[str, Any]:
        return dict(self._parameters)

    def state(self) -> np.ndarray:
        return self._state.copy()

    def observe(self) -> np.ndarray:
        return self._state.copy()

    def reset(
        self, state: np.ndarray | None = None, *, time: float = 0.0, parameters: Mapping[str, Any] | None = None
    ) -> None:
        label = f"Map {self.name!r}"
        for key, value in checks.mapping(label, "parameters", parameters).items():
            self._parameters[checks.one_of(label, "parameter", key, self._parameters)] = value
        self._state = self.start.copy() if state is None else state_of(f"Map {self.name!r}", state, self.size)
        self._time, self.ok, self.status = float(time), True, "ready"

    def advance(self, duration: float, tangents: np.ndarray | None = None) -> bool:
        label = f"Map {self.name!r}"
        T = None if tangents is None else tangents_of(label, tangents, self.size)
        for _ in range(checks.count(label, "duration", duration, 0) if self.ok else 0):
            try:
                new = np.asarray(self._next(self._state), dtype=np.float64)
            except (OverflowError, ZeroDivisionError, FloatingPointError):
                new = np.array([np.nan])
            if not np.isfinite(new).all():
                self.ok, self.status = False, f"The state is not finite after {self._time:g} iterations."
                return False
            if T is not None:
                T[:] = self._slope(self._state) @ T
            self._state, self._time = new, self._time + 1.0
        return self.ok

    def copy(self) -> Self:
        other = type(self)(
            self.function,
            self.start,
            jacobian=self.jacobian,
            parameters=self._parameters,
            names=self.names,
            name=self.name,
        )
        other.reset(self._state, time=self._time)
        other.ok, other.status = self.ok, self.status
        return other

    def _next(self, x: np.ndarray) -> Any:
        return self.function(x, **self._parameters)

    def _slope(self, x: np.ndarray) -> np.ndarray:
        if self.jacobian is not None:
            return square_of(f"Map {self.name!r}", self.jacobian(x, **self._parameters), self.size)
        return central_differences(self._next, x)


def central_differences(function: Callable[[np.ndarray], Any], x: np.ndarray) -> np.ndarray:
    """Derivatives (m, n) of a function of x (n,) with values (m,); the error is some 1e-10 of the values.

    Parameters
    ----------
    function : the function.
    x : point (n,) of differentiation.
    """
    columns = []
    for i in range(len(x)):
        step = np.zeros_like(x)
        step[i] = 6e-6 * max(abs(x[i]), 1.0)
        up, down = np.asarray(function(x + step)), np.asarray(function(x - step))
        columns.append((up - down) / (2.0 * step[i]))
    return np.array(columns, dtype=np.float64).T


def state_of(owner: str, value: Any, size: int | None = None) -> np.ndarray:
    """`value` as a state (size,) of finite numbers.

    Parameters
    ----------
    owner : name of the caller, for messages.
    value : the argument of a user.
    size : required size; None: any.

    Raises
    ------
    InputError : another shape, entries that are no finite numbers.
    """
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


def function_of(owner: str, what: str, value: Any) -> Callable[..., Any]:
    """`value` if it can be called.

    Parameters
    ----------
    owner, what : names of the caller and of the argument, for messages.
    value : the argument of a user.

    Raises
    ------
    InputError : an argument that cannot be called.
    """
    if not callable(value):
        raise InputError(f"{owner}: {what} is {value!r}; it must be a function.")
    return value  # type: ignore[no-any-return]


def names_of(owner: str, what: str, value: Any, default: Sequence[str]) -> tuple[str, ...]:
    """`value` as a tuple of texts, as many as in `default`.

    Parameters
    ----------
    owner, what : names of the caller and of the argument, for messages; with "names" no text may stand twice.
    value : the argument of a user; None: `default`.
    default : texts that replace None.

    Raises
    ------
    InputError : another number of texts, other objects, a name given twice.
    """
    names = tuple(default) if value is None else checks.sequence(owner, what, value, "texts")
    if len(names) != len(default):
        raise InputError(f"{owner}: {len(names)} {what} for {len(default)} numbers of a state.")
    wrong = [x for x in names if not isinstance(x, str)] or [x for x in names if what == "names" and names.count(x) > 1]
    if wrong:
        raise InputError(f"{owner}: {what} has {wrong[0]!r}; it must hold texts, and no name twice.")
    return names


def tangents_of(owner: str, value: Any, size: int) -> np.ndarray:
    """`value` if tangent vectors can be advanced in it in place.

    Parameters
    ----------
    owner : name of the caller, for messages.
    value : the argument of a user.
    size : size of a state.

    Raises
    ------
    InputError : another shape or type than float64 (size, k), entries that are not finite.
    """
    if not isinstance(value, np.ndarray) or value.ndim != 2 or len(value) != size or value.dtype != np.float64:
        text = f"{owner}: tangents have shape {np.shape(value)}"
        raise InputError(f"{text}; they must be a float64 array ({size}, k), one difference a column.")
    if not np.isfinite(value).all():
        raise InputError(f"{owner}: tangents hold numbers that are not finite. Carry them for shorter times.")
    return value


def square_of(owner: str, value: Any, size: int) -> np.ndarray:
    """Value of a jacobian as (size, size).

    Parameters
    ----------
    owner : name of the caller, for messages.
    value : value that the function returned.
    size : size of a state.

    Raises
    ------
    InputError : another shape.
    """
    matrix = np.asarray(value, dtype=np.float64)
    if matrix.shape != (size, size):
        raise InputError(f"{owner}: jacobian has shape {matrix.shape}; it must have shape ({size}, {size}).")
    return matrix
