"""Base of systems defined by a function of the user, and checks of the arguments and results of such functions."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, ClassVar

import numpy as np

from flexmb import checks
from flexmb.dynamics.systems.dynamics import Dynamics
from flexmb.errors import InputError


class GivenSystem(Dynamics):
    """Base of systems given by a function, its Jacobian, parameters and a start.

    `kind` is the word that messages begin with.
    """

    kind: ClassVar[str]

    _time: float
    _state: np.ndarray

    def _declare(
        self,
        name: str,
        function: Callable[..., Any],
        start: Sequence[float] | np.ndarray,
        jacobian: Callable[..., Any] | None,
        parameters: Mapping[str, Any] | None,
        names: Sequence[str] | None,
    ) -> None:
        """Check and keep the arguments that every such system takes."""
        self.name = name
        label = self._label
        self.function, self.jacobian = function_of(label, "function", function), jacobian
        if jacobian is not None:
            function_of(label, "jacobian", jacobian)
        self.start, self._parameters = state_of(label, start), checks.mapping(label, "parameters", parameters)
        self.names = names_of(label, "names", names, [f"x{i}" for i in range(len(self.start))])

    @property
    def _label(self) -> str:
        return f"{self.kind} {self.name!r}"

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

    def _begin(self, state: np.ndarray | None, parameters: Mapping[str, Any] | None) -> None:
        """Take other parameters, and stand at `state`, or at the start."""
        for key, value in checks.mapping(self._label, "parameters", parameters).items():
            self._parameters[checks.one_of(self._label, "parameter", key, self._parameters)] = value
        self._state = self.start.copy() if state is None else state_of(self._label, state, self.size)
        self.ok, self.status = True, "ready"


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
    except (TypeError, ValueError):  # complex numbers are TypeErrors, too
        raise InputError(f"{owner}: a state is {value!r}; it must be a list of numbers.") from None
    wanted = "(n,)" if size is None else f"({size},)"
    if state.ndim != 1 or len(state) == 0 or (size is not None and len(state) != size):
        raise InputError(f"{owner}: a state has shape {state.shape}; it must have shape {wanted}.")
    if not np.isfinite(state).all():
        raise InputError(f"{owner}: a state is {value!r}; all its numbers must be finite.")
    return state


def function_of(owner: str, what: str, value: Any) -> Callable[..., Any]:
    """`value` if it can be called, or `InputError`."""
    if not callable(value):
        raise InputError(f"{owner}: {what} is {value!r}; it must be a function.")
    return value  # type: ignore[no-any-return]


def names_of(owner: str, what: str, value: Any, default: Sequence[str]) -> tuple[str, ...]:
    """`value` as so many different names (units: of any kind) as `default` has, which stands for None."""
    found = tuple(default) if value is None else checks.sequence(owner, what, value, "texts")
    if len(found) != len(default):
        raise InputError(f"{owner}: {len(found)} {what} for {len(default)} numbers of a state.")
    wrong = [x for x in found if not isinstance(x, str)] or [x for x in found if what == "names" and found.count(x) > 1]
    if wrong:
        raise InputError(f"{owner}: {what} has {wrong[0]!r}; it must hold texts, and no name twice.")
    return found


def tangents_of(owner: str, value: Any, size: int) -> np.ndarray:
    """`value` if differences (size, k) can be carried in it, in place, or `InputError`."""
    if not isinstance(value, np.ndarray) or value.ndim != 2 or len(value) != size or value.dtype != np.float64:
        text = f"{owner}: tangents have shape {np.shape(value)}"
        raise InputError(f"{text}; they must be a float64 array ({size}, k), one difference a column.")
    if not np.isfinite(value).all():
        raise InputError(f"{owner}: tangents hold numbers that are not finite. Carry them for shorter times.")
    return value


def square_of(owner: str, value: Any, size: int) -> np.ndarray:
    """Value of a jacobian as a matrix (size, size), or `InputError`."""
    found = np.asarray(value, dtype=np.float64)
    if found.shape != (size, size):
        raise InputError(f"{owner}: jacobian has shape {found.shape}; it must have shape ({size}, {size}).")
    return found
