"""Ordinary differential equations with their variational equations."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Self

import numpy as np

from flexmb import checks
from flexmb.dynamics.systems.continuous_flow import ContinuousFlow
from flexmb.dynamics.systems.given import (
    GivenSystem,
    central_differences,
    names_of,
    square_of,
    state_of,
    tangents_of,
)
from flexmb.errors import SolveError

METHODS = ("DOP853", "RK45", "Radau", "BDF")
"""Solvers of `scipy.integrate` whose next step size can be read and set."""

FINEST = 3e-14
"""Smallest relative tolerance of a step."""

TANGENT_ATOL = 1e-3
"""Absolute tolerance of tangent vectors of length 1, over rtol; they may shrink by 1e4 between two renormalisations."""

INSTANTS = (0.1234567, 0.3819660, 0.7548777, 1.3247180)
"""Times [s] at which the rates are compared with the rates at t = 0, as a test of explicit dependence on time."""


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
    driven : whether f depends on t; None: yes with a period, else f is tested at some times.
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
        self,
        function: Callable[..., Any],
        start: Sequence[float] | np.ndarray,
        *,
        jacobian: Callable[..., Any] | None = None,
        parameters: Mapping[str, Any] | None = None,
        names: Sequence[str] | None = None,
        units: Sequence[str] | None = None,
        period: float | Callable[..., float] | None = None,
        driven: bool | None = None,
        name: str = "ODE",
        rtol: float = 1e-9,
        atol: float = 1e-12,
        method: str = "DOP853",
    ) -> None:
        self._declare(name, function, start, jacobian, parameters, names)
        label, size = self._label, self.size
        self._given_period, self._given_driven = period, driven
        self.units = names_of(label, "units", units, ("",) * size)
        self.rtol = checks.between(label, "rtol", rtol, FINEST, 0.1)
        self.atol = checks.positive(label, "atol", atol)
        self.method = checks.one_of(label, "method", method, METHODS)
        self.reset()
        state_of(f"{label}: function", function(0.0, self.start.copy(), **self._parameters), size)

    @property
    def pace(self) -> float:
        if self._h is not None:
            return self._h
        size, speed = float(np.linalg.norm(self._state)), float(np.linalg.norm(self.velocity()))
        return 0.01 * (max(size, 1e-6) / speed) if speed > 0.0 else 0.01 * (self.period or 1.0)

    def reset(
        self, state: np.ndarray | None = None, *, time: float = 0.0, parameters: Mapping[str, Any] | None = None
    ) -> None:
        self._begin(state, parameters)
        label = self._label
        self._time, self._h = checks.number(label, "time", time, "s"), None
        given = self._given_period
        period = given(**self._parameters) if callable(given) else given
        self.period = None if period is None else checks.positive(label, "period", period, "s")
        self.driven = self._depends_on_time() if self._given_driven is None else bool(self._given_driven)

    def advance(self, duration: float, tangents: np.ndarray | None = None) -> bool:
        limit = self._time + checks.positive(self._label, "duration", duration, "s")
        return self._go(limit, tangents, single=False)

    def take_step(self, limit: float, tangents: np.ndarray | None = None) -> bool:
        return self._go(limit, tangents, single=True)

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

    def copy(self) -> Self:
        return self._with(self.rtol, self.atol)

    @property
    def fineness(self) -> str:
        return f"rtol {self.rtol:g}"

    def finer(self) -> Self:
        rtol = max(self.rtol / 10.0, FINEST)
        return self._with(rtol, self.atol * rtol / self.rtol)

    def _with(self, rtol: float, atol: float) -> Self:
        """A copy with other tolerances."""
        other = type(self)(
            self.function,
            self.start,
            jacobian=self.jacobian,
            parameters=self._parameters,
            names=self.names,
            units=self.units,
            period=self._given_period,
            driven=self._given_driven,
            name=self.name,
            rtol=rtol,
            atol=atol,
            method=self.method,
        )
        other.restore(self.snapshot())
        return other

    def _rate(self, t: float, x: np.ndarray) -> np.ndarray:
        try:
            with np.errstate(all="ignore"):
                rate = np.asarray(self.function(t, x, **self._parameters), dtype=np.float64)
        except (OverflowError, ZeroDivisionError, FloatingPointError) as error:
            raise NotFiniteError(f"{error}") from error
        if not np.isfinite(rate).all():
            raise NotFiniteError("a rate is not finite")
        return rate

    def _depends_on_time(self) -> bool:
        if self.period is not None:
            return True
        try:
            rates = [self._rate(t, self._state) for t in (0.0, *INSTANTS)]
        except NotFiniteError:
            return True
        return any(not np.array_equal(rate, rates[0]) for rate in rates[1:])

    def _slope(self, t: float, x: np.ndarray) -> np.ndarray:
        if self.jacobian is not None:
            return square_of(self._label, self.jacobian(t, x, **self._parameters), self.size)
        return central_differences(lambda y: self._rate(t, y), x)

    def _go(self, limit: float, tangents: np.ndarray | None, *, single: bool) -> bool:
        """Integrate up to `limit`, or by one step (`single`); state and tangents stay at the last successful step."""
        if not self.ok:
            return False
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
                        self._accept(solver, before, limit, tangents)
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

    def _accept(self, solver: Any, before: float, limit: float, tangents: np.ndarray | None) -> None:
        n = self.size
        self._time, self._state = float(solver.t), solver.y[:n].copy()
        self._h = float(max(before, solver.h_abs)) if solver.t >= limit else float(solver.h_abs)
        if tangents is not None:
            tangents[:] = solver.y[n:].reshape(tangents.shape)

    def _solver(self, limit: float, tangents: np.ndarray | None) -> Any:
        """A solver from the present state, whose first step has the size that the last solver proposed."""
        import scipy.integrate

        kind = getattr(scipy.integrate, self.method)
        first = None if self._h is None else min(self._h, limit - self._time)
        if tangents is None:
            return kind(self._rate, self._time, self._state, limit, first_step=first, rtol=self.rtol, atol=self.atol)
        n, k = tangents.shape

        def both(t: float, y: np.ndarray) -> np.ndarray:
            rate = self._rate(t, y[:n])
            return np.concatenate([rate, (self._slope(t, y[:n]) @ y[n:].reshape(n, k)).ravel()])

        y = np.concatenate([self._state, tangents.ravel()])
        atol = np.concatenate([np.full(n, self.atol), np.full(n * k, TANGENT_ATOL * self.rtol)])
        return kind(both, self._time, y, limit, first_step=first, rtol=self.rtol, atol=atol)
