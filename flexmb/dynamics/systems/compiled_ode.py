"""Motion of an own differential equation in compiled code: steps of order eight, impacts, crossings of a level.

A function, a gap and a jump that numba has compiled are called from a loop without Python, so that threads run side by
side.  Steps, error norm and coefficients are those of `scipy.integrate.DOP853`; the loop is compiled once for all
functions.  Impacts and crossings are located to round-off, by steps from the start of the step in which they lie.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Mapping
from itertools import chain
from numbers import Real
from typing import TYPE_CHECKING, Any

import numpy as np
from numba.np.unsafe.ndarray import to_fixed_tuple

from flexmb.dynamics.sections import HALVINGS, ROUNDS, turning_point
from flexmb.dynamics.systems.impact_ode import PILE
from flexmb.engine.compiled.records import Matrix, Record, Vector
from flexmb.errors import KernelError
from flexmb.kernels import HEIGHT, RATES, Kernel, address_table, compiled, copy, height_at, rates_at
from flexmb.late import scipy

if TYPE_CHECKING:
    from flexmb.dynamics.systems.given import ODE

# Codes of the loop, and sentences about those that end a motion.
REACHED, CROSSED, NOT_FINITE, TOO_SMALL, PILED, BAD_JUMP = range(6)
ENDS = {
    NOT_FINITE: "Stopped: a rate is not finite, at t = {:.6g} s.",
    TOO_SMALL: "Stopped: the step size falls below the spacing of the clock, at t = {:.6g} s.",
    PILED: "Impacts pile up at t = {:.6g} s: the gap stays closed.",
    BAD_JUMP: "The jump at t = {:.6g} s gives a state that is not finite.",
}
RATE, JUMP = range(2)  # numbers of the kernels of rates
WALL, LEVEL = range(2)  # what is sought within a step
STAGES, ORDER = 12, 8
FIFTH, THIRD = range(2)  # rows of the error estimates
SAFETY, LEAST_FACTOR, LARGEST_FACTOR = 0.9, 0.2, 10.0  # factors of a step size, as in scipy
ROUND_OFF = 2.2e-16
LEAST_STEP = 10.0 * ROUND_OFF  # least step over the present time
THIRD_ORDER_SHARE = 0.01  # weight of the square of the error of order 3 beside that of order 5
DIFFERENCE = 6e-6  # difference of the state for the rate of the gap, over its size
dip_of = compiled(turning_point)
SHORT, SHORTEST = 1e-3, 1e-6  # largest and least time of that difference, over a step


class Motion(Record):
    """Present state of a motion, and workspace of a step."""

    t: float  # present time, size of the next step (0: to be chosen), instant of the last impact [s]
    h: float
    last: float
    size: float  # size of the step that is tried [s]
    rtol: float
    atol: float
    level: float  # level of a section, and side of it (1, -1) from which it is sought
    side: float
    signal: int  # number of the entry of the state that has the level; -1: no section
    has_wall: int
    p: Vector  # parameters of the functions
    x: Vector  # x, y, z: (n,) state, end of the step, another state
    y: Vector
    z: Vector
    before: Vector  # (n,) state before the last impact
    K: Matrix  # (13, n) rates at the stages, and at the end of the step
    weights: Matrix  # (13, 12) of the stages and the step, their instants (13,), (2, 13) of the error estimates
    instants: Vector
    errors: Matrix


@compiled
def try_size(rates, m, size):
    """Find stages and end y of a step of a size [s], whose first stage is known."""
    m.size = size
    for stage in range(1, STAGES + 1):
        for i in range(m.x.shape[0]):
            total = 0.0
            for k in range(stage):
                total += m.weights[stage, k] * m.K[k, i]
            m.y[i] = m.x[i] + size * total
        rates_at(rates, RATE)(m.p, m.t + m.instants[stage] * size, m.y, m.K[stage])


@compiled
def error_ratio(m):
    """Estimated error of the step over the accepted one; infinity where it is not finite."""
    n, fifth, third = m.x.shape[0], 0.0, 0.0
    for i in range(n):
        scale, e5, e3 = m.atol + m.rtol * max(abs(m.x[i]), abs(m.y[i])), 0.0, 0.0
        for k in range(STAGES + 1):
            e5 += m.errors[FIFTH, k] * m.K[k, i]
            e3 += m.errors[THIRD, k] * m.K[k, i]
        fifth += (e5 / scale) ** 2
        third += (e3 / scale) ** 2
    whole = fifth + THIRD_ORDER_SHARE * third
    error = abs(m.size) * fifth / math.sqrt(whole * n) if whole != 0.0 else 0.0
    return error if math.isfinite(error) else math.inf


@compiled
def first_size(rates, m, longest):
    """Size of a first step [s], from the change of the rates over a short time (Hairer, Norsett, Wanner, II.4)."""
    n, f = m.x.shape[0], m.K[0]
    d0, d1, d2 = 0.0, 0.0, 0.0
    for i in range(n):
        scale = m.atol + m.rtol * abs(m.x[i])
        d0 += (m.x[i] / scale) ** 2
        d1 += (f[i] / scale) ** 2
    d0, d1 = math.sqrt(d0 / n), math.sqrt(d1 / n)
    short = min(1e-6 if d0 < 1e-5 or d1 < 1e-5 else 0.01 * d0 / d1, longest)
    for i in range(n):
        m.y[i] = m.x[i] + short * f[i]
    rates_at(rates, RATE)(m.p, m.t + short, m.y, m.z)
    for i in range(n):
        d2 += ((m.z[i] - f[i]) / (m.atol + m.rtol * abs(m.x[i]))) ** 2
    d2 = math.sqrt(d2 / n) / short
    most = max(d1, d2)
    other = max(1e-6, 1e-3 * short) if most <= 1e-15 else (0.01 / most) ** (1.0 / ORDER)
    found = min(100.0 * short, other, longest)
    return found if found > 0.0 else short  # rates that are not finite


@compiled
def try_step(rates, m, limit):
    """Find the next accepted step up to a time [s], without taking it; a code."""
    rates_at(rates, RATE)(m.p, m.t, m.x, m.K[0])
    if m.h == 0.0:
        m.h = first_size(rates, m, limit - m.t)
    least, refused, finite = max(LEAST_STEP * abs(m.t), 1e-300), False, True
    h = max(m.h, least)
    while h >= least and math.isfinite(h):
        is_last = m.t + h >= limit
        try_size(rates, m, limit - m.t if is_last else h)
        error = error_ratio(m)
        finite = error < math.inf
        factor = LARGEST_FACTOR if error == 0.0 else SAFETY * error ** (-1.0 / ORDER)
        if error < 1.0:
            factor = min(factor, 1.0 if refused else LARGEST_FACTOR)
            m.h = max(h, m.size * factor) if is_last else h * factor
            return REACHED
        h, refused = m.size * max(LEAST_FACTOR, factor), True
    return TOO_SMALL if finite else NOT_FINITE


@compiled
def height(heights, what, m, t, x):
    """Height of a state over the wall, or over the level on the present side of it."""
    return height_at(heights, 0)(m.p, t, x) if what == WALL else m.side * (x[m.signal] - m.level)


@compiled
def height_rate(heights, what, m, t, x, f):
    """Rate of the height [1/s] along the motion with rates f."""
    if what == LEVEL:
        return m.side * f[m.signal]
    size, speed, n = 0.0, 1e-300, x.shape[0]
    for i in range(n):
        size, speed = max(size, abs(x[i])), max(speed, abs(f[i]))
    s = max(min(DIFFERENCE * size / speed, SHORT * m.h), SHORTEST * m.size)
    for i in range(n):
        m.z[i] = x[i] + s * f[i]
    ahead = height(heights, what, m, t + s, m.z)
    for i in range(n):
        m.z[i] = x[i] - s * f[i]
    return (ahead - height(heights, what, m, t - s, m.z)) / (2.0 * s)


@compiled
def height_after(rates, heights, what, m, time):
    """Height after a step of a size [s] from the present state, which is tried."""
    try_size(rates, m, time)
    return height(heights, what, m, m.t + time, m.y)


@compiled
def find_bracket(rates, heights, what, m):
    """Times within the tried step before and after a crossing [s], and the height before; (0, inf, 0) without one."""
    # A step whose ends lie on the same side is examined if the cubic through heights and rates at both ends comes near
    # the level; one that begins behind it, after an impact, for a point before the next crossing. Without such a point
    # it is about to leave, or stuck: (0, size, height < 0).
    size = m.size
    old, new = height(heights, what, m, m.t, m.x), height(heights, what, m, m.t + size, m.y)
    if new < 0.0:
        time, before, count = 0.0, old, 0
        while before < 0.0 and count < HALVINGS:
            time = 0.5 * (size if count == 0 else time)
            before, count = height_after(rates, heights, what, m, time), count + 1
        if before >= 0.0:
            return time, size, before
        end = height_after(rates, heights, what, m, size)
        leaves = end < 0.0 < height_rate(heights, what, m, m.t + size, m.y, m.K[STAGES])
        return 0.0, math.inf if leaves else size, old
    if old > 0.0:
        r0 = height_rate(heights, what, m, m.t, m.x, m.K[0])
        r1 = height_rate(heights, what, m, m.t + size, m.y, m.K[STAGES])
        dip = dip_of(old, r0, new, r1, size)
        if dip > 0.0:
            if height_after(rates, heights, what, m, dip) < 0.0:
                return 0.0, dip, old
            try_size(rates, m, size)
    return 0.0, math.inf, 0.0


@compiled
def find_crossing(rates, heights, what, m):
    """Time [s] within the tried step of the first instant behind a crossing, to which it is shortened; or infinity."""
    # Regula falsi with the Illinois modification, and bisection every fourth time.
    size = m.size
    a, b, fa = find_bracket(rates, heights, what, m)
    if b == math.inf or (a == 0.0 and fa < 0.0):  # none, or the state is stuck behind the wall
        return 0.0 if b < math.inf else b
    least = 4.0 * ROUND_OFF * (abs(m.t) + size)
    fb, moved_last = height_after(rates, heights, what, m, b), 0
    for count in range(ROUNDS):
        if b - a <= least:
            break
        x = 0.5 * (a + b) if count % 4 == 3 or fa == fb else b - fb * (b - a) / (fb - fa)
        x = min(max(x, a + 0.5 * least), b - 0.5 * least)
        value = height_after(rates, heights, what, m, x)
        if value < 0.0:
            b, fb, fa, moved_last = x, value, 0.5 * fa if moved_last == -1 else fa, -1
        else:
            a, fa, fb, moved_last = x, value, 0.5 * fb if moved_last == 1 else fb, 1
    try_size(rates, m, b)
    return b


@compiled
def hit(rates, heights, m):
    """Jump at the wall, unless the gap opens again; a code."""
    rates_at(rates, RATE)(m.p, m.t, m.x, m.K[0])
    if height_rate(heights, WALL, m, m.t, m.x, m.K[0]) >= 0.0:
        return REACHED
    was_before = m.signal < 0 or height(heights, LEVEL, m, m.t, m.x) >= 0.0
    rates_at(rates, JUMP)(m.p, m.t, m.x, m.y)
    for i in range(m.x.shape[0]):
        if not math.isfinite(m.y[i]):
            return BAD_JUMP
    copy(m.y, m.x)
    is_behind = m.signal >= 0 and height(heights, LEVEL, m, m.t, m.x) < 0.0
    return CROSSED if was_before and is_behind else REACHED


@compiled
def advance_ode(rates, heights, m, limit, single):
    """Advance up to a time [s], to the next crossing of the level, or by one step; a code."""
    while m.t < limit:
        code = try_step(rates, m, limit)
        if code != REACHED:
            return code
        met = find_crossing(rates, heights, WALL, m) if m.has_wall == 1 else math.inf
        hits = met < math.inf
        if hits and (met == 0.0 or m.t + met - m.last < PILE * max(abs(m.t), m.h)):
            return PILED
        crosses = m.signal >= 0 and find_crossing(rates, heights, LEVEL, m) < math.inf
        m.t = min(m.t + m.size, limit)
        copy(m.y, m.x)
        if crosses:
            return CROSSED
        if hits:
            m.last = m.t
            copy(m.x, m.before)
            code = hit(rates, heights, m)
            if code != REACHED:
                return code
        if single:
            break
    return REACHED


def kernel_of(function: Any, begin: int, end: int, *, is_height: bool = False) -> Kernel:
    """Kernel of a function f(t, x, ...) with the parameters p[begin:end], which returns a height, rates or a state."""
    count = end - begin

    def rates(p: Any, t: float, x: Any, out: Any) -> None:
        found = function(t, x, *to_fixed_tuple(p[begin:end], count))
        for i in range(out.shape[0]):
            out[i] = found[i]

    def distance(p: Any, t: float, x: Any) -> Any:
        return function(t, x, *to_fixed_tuple(p[begin:end], count))

    made: Any = distance if is_height else rates
    made.__qualname__ = function.py_func.__qualname__
    return Kernel(made, HEIGHT if is_height else RATES)


class CompiledMotion:
    """Motion of an `ODE` in compiled code, by its function, and by gap and jump at a wall."""

    def __init__(self, function: Any, gap: Any = None, jump: Any = None) -> None:
        self.functions = (function,) if gap is None else (function, gap, jump)
        self.last, self.before = -math.inf, np.zeros(0)  # instant of the last impact [s], and the state before it
        self.usable, self._compiles = False, True  # whether all parameters are numbers, and the functions kernels
        self._numbers, self._kernels = list[list[float]](), list[Kernel]()
        self._record: Motion | None = None

    def copy(self) -> CompiledMotion:
        """Copy with another workspace."""
        other = CompiledMotion(*self.functions)
        vars(other).update(vars(self), _record=None)  # kernels are shared
        return other

    def __getstate__(self) -> dict[str, Any]:
        return {**vars(self), "_kernels": [], "_record": None}

    def take(self, parameters: Mapping[str, Any]) -> None:
        """Take the parameters of the functions."""
        self._numbers, self.usable = [], self._compiles
        for function in self.functions:
            taken = list(inspect.signature(function.py_func).parameters.values())[2:]  # behind t and x
            values = [parameters.get(one.name, one.default) for one in taken]
            named = {one.name for one in taken if one.kind is one.POSITIONAL_OR_KEYWORD}
            self.usable &= set(parameters) <= named and all(isinstance(x, Real) for x in values)
            self._numbers.append([float(x) for x in values] if self.usable else [])
        self.usable = self.usable and self._has_kernels()

    def _has_kernels(self) -> bool:
        """Whether the functions are kernels, which are compiled by the first call: not if they return mixed tuples."""
        lengths = [len(numbers) for numbers in self._numbers]
        if not self._kernels:
            spans = zip(self.functions, np.cumsum([0, *lengths]).tolist(), lengths, strict=False)
            made = [kernel_of(f, begin, begin + n, is_height=k == 1) for k, (f, begin, n) in enumerate(spans)]
            try:
                self._tables = address_table(made[::2]), address_table(made[1:2])
            except KernelError:
                self._compiles = False
                return False
            self._kernels = made  # whose code lives as long as they do
        return True

    def run(
        self, ode: ODE, limit: float, *, single: bool = False, section: tuple[int, float, int] = (-1, 0.0, 1)
    ) -> bool:
        """Advance an ODE up to a time [s], or by one step; whether it met the section (signal, level, side) before."""
        if self._record is None:  # at the first use, also of a copy in another process
            self._has_kernels()
            method, n = scipy.integrate.DOP853, ode.size
            self._record = Motion(
                *(0.0,) * 8, signal=-1, has_wall=len(self.functions) > 1, p=sum(map(len, self._numbers)),
                **dict.fromkeys(("x", "y", "z", "before"), n), K=(STAGES + 1, n),
                weights=np.vstack([method.A, method.B]), instants=np.append(method.C, 1.0),
                errors=np.array([method.E5, method.E3]),
            )  # fmt: skip
        m = self._record
        m.p[:], m.x[:] = [*chain(*self._numbers)], ode._state
        m.t, m.h, m.last, m.rtol, m.atol = ode._time, ode._h or 0.0, self.last, ode.rtol, ode.atol
        m.signal, m.level, m.side = section
        rates, heights = self._tables
        code = int(advance_ode(rates, heights, m, limit, single))
        self.before = m.before.copy()
        ode._time, ode._state, ode._h, self.last = m.t, m.x.copy(), m.h or None, m.last
        ode.ok = code in (REACHED, CROSSED)
        ode.status = ENDS.get(code, "Reached t = {:.6g} s.").format(m.t)
        return code == CROSSED
