"""A map given by a function."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Self

import numpy as np

from flexmb import checks
from flexmb.analysis.dynamics import Dynamics
from flexmb.errors import InputError


class Map(Dynamics):
    """The map x -> function(x, **parameters).

    Parameters
    ----------
    function : f(x, **parameters) -> the next state (size,).
    start : state (size,) it starts with.
    jacobian : J(x, **parameters) -> (size, size), df/dx; None: central differences.
    parameters : names and values of the parameters.
    names : names of the numbers of a state; None: x0, x1, ...
    name : what messages call it.

    Raises
    ------
    InputError : a start that is no list of finite numbers, names of another number, a function that returns something
        else than a state.
    """

    unit = "iterations"

    def __init__(
        self,
        function: Callable[..., Any],
        start: Sequence[float],
        *,
        jacobian: Callable[..., Any] | None = None,
        parameters: Mapping[str, Any] | None = None,
        names: Sequence[str] | None = None,
        name: str = "map",
    ) -> None:
        self.name, self.function, self.jacobian = name, function, jacobian
        self.start = state_of(f"Map {name!r}", start)
        self._parameters = dict(parameters or {})
        self.names = tuple(names) if names is not None else tuple(f"x{i}" for i in range(len(self.start)))
        if len(self.names) != len(self.start):
            raise InputError(f"Map {name!r}: {len(self.names)} names for {len(self.start)} numbers of a state.")
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
        for key, value in (parameters or {}).items():
            self._parameters[checks.one_of(f"Map {self.name!r}", "parameter", key, self._parameters)] = value
        self._state = self.start.copy() if state is None else state_of(f"Map {self.name!r}", state, self.size)
        self._time, self.ok, self.status = float(time), True, "ready"

    def advance(self, duration: float, tangents: np.ndarray | None = None) -> bool:
        for _ in range(checks.count(f"Map {self.name!r}", "duration", duration, 0)):
            new = np.asarray(self._next(self._state), dtype=np.float64)
            if not np.isfinite(new).all():
                self.ok, self.status = False, f"The state is not finite after {self._time:g} iterations."
                return False
            if tangents is not None:
                tangents[:] = self._slope(self._state) @ tangents
            self._state, self._time = new, self._time + 1.0
        return True

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
            return np.asarray(self.jacobian(x, **self._parameters), dtype=np.float64)
        return central_differences(self._next, x)


def central_differences(function: Callable[[np.ndarray], Any], x: np.ndarray) -> np.ndarray:
    """Derivatives (m, n) of a function of x (n,) with values (m,), with an error of some 1e-10 of the values."""
    columns = []
    for i in range(len(x)):
        step = np.zeros_like(x)
        step[i] = 6e-6 * max(abs(x[i]), 1.0)
        up, down = np.asarray(function(x + step)), np.asarray(function(x - step))
        columns.append((up - down) / (2.0 * step[i]))
    return np.array(columns, dtype=np.float64).T


def state_of(owner: str, value: Any, size: int | None = None) -> np.ndarray:
    """`value` as a state (size,) of finite numbers, or `InputError`."""
    try:
        state = np.array(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(f"{owner}: a state is {value!r}; it must be a list of numbers.") from None
    wanted = "(n,)" if size is None else f"({size},)"
    if state.ndim != 1 or len(state) == 0 or (size is not None and len(state) != size):
        raise InputError(f"{owner}: a state has shape {state.shape}; it must have shape {wanted}.")
    if not np.isfinite(state).all():
        raise InputError(f"{owner}: a state is {value!r}; all its numbers must be finite.")
    return state
