"""Maps given by a function, and checks of the arguments that maps and differential equations share."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Self

import numpy as np

from flexmb import checks
from flexmb.dynamics.systems.given import GivenSystem, central_differences, square_of, state_of, tangents_of


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
        self,
        function: Callable[..., Any],
        start: Sequence[float] | np.ndarray,
        *,
        jacobian: Callable[..., Any] | None = None,
        parameters: Mapping[str, Any] | None = None,
        names: Sequence[str] | None = None,
        name: str = "map",
    ) -> None:
        self._declare(name, function, start, jacobian, parameters, names)
        self.units = ("",) * len(self.names)
        self.reset()
        state_of(f"{self._label}: function", self._next(self.start), len(self.start))

    def reset(
        self, state: np.ndarray | None = None, *, time: float = 0.0, parameters: Mapping[str, Any] | None = None
    ) -> None:
        self._begin(state, parameters)
        self._time = float(time)

    def advance(self, duration: float, tangents: np.ndarray | None = None) -> bool:
        T = None if tangents is None else tangents_of(self._label, tangents, self.size)
        for _ in range(checks.count(self._label, "duration", duration, 0) if self.ok else 0):
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
            return square_of(self._label, self.jacobian(x, **self._parameters), self.size)
        return central_differences(self._next, x)
