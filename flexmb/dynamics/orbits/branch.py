"""A branch of periodic orbits along a parameter, and the changes of stability on it."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from flexmb import checks
from flexmb.dynamics.orbits.floquet import BRANCH, FLIP, is_real
from flexmb.dynamics.orbits.newton import Direction, Found, Plane, correct
from flexmb.dynamics.orbits.periodic_orbit import PeriodicOrbit, made
from flexmb.dynamics.orbits.shooting import Pass, Shooting
from flexmb.errors import InputError

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True, eq=False)
class BranchPoint:
    """An orbit on a branch.

    Parameters
    ----------
    value : of the parameter.
    kind : "" for a point between events; else which change of stability it is.
    period : after which the orbit comes back [s, or iterations].
    state : (size,) where it begins.
    signals : (names,) there.
    multipliers : (d,) largest first, without that of a shift in time.
    stable : whether all lie inside the circle.
    residual : what does not come back, as a part of the state.
    extremes : (names, 2) smallest and largest values on the orbit; NaN where not asked for.
    grazing : of each gap its turning point nearest to 0 [m].
    rising : how the parameter changes along the branch, as a part of the whole change, in -1 ... 1.
    made_of : the pass.
    """

    _: KW_ONLY
    value: float
    kind: str
    period: float
    state: np.ndarray
    signals: np.ndarray
    multipliers: np.ndarray
    stable: bool
    residual: float
    extremes: np.ndarray
    grazing: dict[str, float]
    rising: float
    made_of: Pass


@dataclass(frozen=True, eq=False)
class Branch:
    """Periodic orbits along a parameter.

    Parameters
    ----------
    name : of the system.
    parameter : name of what is changed.
    unit : of the period.
    names, units : of the signals.
    points : the orbits in the order of the branch.
    events : orbits at which stability changes or surfaces graze, located; the same order.
    ok : False where the branch ended before it left the range.
    status : how it ended, in a sentence.
    shooting : the passes it was found with.
    tolerance : of what does not come back.
    span : range of the parameter.
    gaps : place and sign of the signals that tell gaps.
    """

    _: KW_ONLY
    name: str
    parameter: str
    unit: str
    names: tuple[str, ...]
    units: tuple[str, ...]
    points: tuple[BranchPoint, ...]
    events: tuple[BranchPoint, ...]
    ok: bool
    status: str
    shooting: Shooting
    tolerance: float
    span: tuple[float, float]
    gaps: dict[str, tuple[int, float]]

    def orbit(self, point: int | BranchPoint) -> PeriodicOrbit:
        """The orbit of a point, found once more.

        Parameters
        ----------
        point : its number, or one of `points` or `events`.

        Raises
        ------
        InputError : a number beyond the branch.
        """
        one = self._point(point).made_of
        shooting = self.shooting.copy(self.shooting.times, self.shooting.segments)
        found = correct(shooting, one.starts, one.period, one.value, tolerance=self.tolerance, iterations=10)
        return made(shooting, found, self.gaps)

    def switch(self, event: int | BranchPoint | None = None, *, step: float = 0.02) -> PeriodicOrbit:
        """The first orbit of the branch that begins at a flip, with twice the period, or at a branch point.

        Follow it from the parameter that it has: `follow(orbit, parameter, (None, to))`.

        Parameters
        ----------
        event : one of `events`, or its number among them; None: the first flip, else the first branch point.
        step : how far from the event, as a part of the state there.

        Raises
        ------
        InputError : no such event, or one of another kind.

        Notes
        -----
        From the event a step is taken along the eigenvector of the multiplier -1 (of a branch point +1), and parameter
        and orbit are found on the plane across it: so it does not matter on which side the other branch begins.
        `ok` is False if that leads to no other orbit.
        """
        found = self._event(event)
        return switched(self, found, checks.positive("switch", "step", step))

    def to_dataset(self) -> xr.Dataset:
        """Everything over "point": signals at the start of the orbit, period, stability, multipliers, events.

        Multipliers are in two variables, real and imaginary part, over "multiplier"; events in variables of their own
        over "event".
        """
        import xarray as xr

        points, axis = self.points, "point"
        signals = np.array([p.signals for p in points]).reshape(len(points), len(self.names))
        ends = np.array([p.extremes for p in points]).reshape(len(points), len(self.names), 2)
        data: dict[str, Any] = {}
        for k, (name, units) in enumerate(zip(self.names, self.units, strict=True)):
            data[name] = (axis, signals[:, k], {"units": units})
            if np.isfinite(ends[:, k]).any():
                data[f"{name}.min"], data[f"{name}.max"] = ((axis, ends[:, k, s], {"units": units}) for s in (0, 1))
        widest = max((len(p.multipliers) for p in points), default=0)
        table = np.full((len(points), widest), np.nan, dtype=np.complex128)
        for row, p in zip(table, points, strict=True):
            row[: len(p.multipliers)] = p.multipliers
        data["period"] = (axis, np.array([p.period for p in points]), {"units": self.unit})
        data["stable"] = (axis, np.array([p.stable for p in points], dtype=bool))
        data["residual"] = (axis, np.array([p.residual for p in points]))
        data["multiplier.real"] = ((axis, "multiplier"), table.real.copy())
        data["multiplier.imag"] = ((axis, "multiplier"), table.imag.copy())
        for name in self.gaps:
            data[f"grazing.{name}"] = (axis, np.array([p.grazing.get(name, np.nan) for p in points]), {"units": "m"})
        data["event.kind"] = ("event", np.array([e.kind for e in self.events], dtype=str))
        data[f"event.{self.parameter}"] = ("event", np.array([e.value for e in self.events]))
        data["event.period"] = ("event", np.array([e.period for e in self.events]), {"units": self.unit})
        signals = np.array([e.signals for e in self.events]).reshape(len(self.events), len(self.names))
        for k, name in enumerate(self.names):
            data[f"event.{name}"] = ("event", signals[:, k], {"units": self.units[k]})
        coordinate = (axis, np.array([p.value for p in points]))
        attrs = {"name": self.name, "parameter": self.parameter, "ok": int(self.ok), "status": self.status}
        return xr.Dataset(data, {self.parameter: coordinate}, attrs)

    def _point(self, point: int | BranchPoint) -> BranchPoint:
        if isinstance(point, BranchPoint):
            return point
        if not -len(self.points) <= checks.count("Branch", "point", point, -len(self.points)) < len(self.points):
            raise InputError(f"Branch of {self.name!r}: point is {point}; there are {len(self.points)}.")
        return self.points[point]

    def _event(self, event: int | BranchPoint | None) -> BranchPoint:
        if event is None:
            for kind in (FLIP, BRANCH):
                for found in self.events:
                    if found.kind == kind:
                        return found
        listed = ", ".join(f"{k}: {e.kind} at {e.value:.6g}" for k, e in enumerate(self.events)) or "none"
        if isinstance(event, int) and -len(self.events) <= event < len(self.events):
            event = self.events[event]
        if not isinstance(event, BranchPoint) or event.kind not in (FLIP, BRANCH):
            text = f"switch: event is {event if not isinstance(event, BranchPoint) else event.kind!r}"
            raise InputError(f"{text}; it must be a flip or a branch point of this branch. Events: {listed}.")
        return event

    def __repr__(self) -> str:
        values = [p.value for p in self.points]
        span = f"{min(values):.6g} to {max(values):.6g}" if values else "nowhere"
        events = ", ".join(f"{e.kind} at {e.value:.8g}" for e in self.events) or "no events"
        return f"Branch of {self.name!r}, {self.parameter} {span}, {len(self.points)} points: {events}. {self.status}"


def switched(branch: Branch, event: BranchPoint, step: float) -> PeriodicOrbit:
    """The orbit a step away from an event along the eigenvector of the multiplier that is -1 or +1."""
    twice, one = 2 if event.kind == FLIP else 1, event.made_of
    old = branch.shooting
    shooting = old.copy(old.times * twice, old.segments * twice)
    values, vectors = np.linalg.eig(one.monodromy)
    target = -1.0 if twice == 2 else 1.0
    usable = np.where(is_real(values), np.abs(values - target), np.inf)
    y = np.real(vectors[:, int(usable.argmin())])
    parts, pushed = [], y / np.linalg.norm(y)
    for _ in range(twice):
        for j in range(old.segments):
            parts.append(one.bases[j] @ pushed)
            pushed = one.slopes[j] @ pushed
    starts = np.tile(one.starts, (twice, 1))
    size = size_of(old, one)
    normal = Direction(np.array(parts), 0.0, 0.0)
    through = Direction(starts + step * size * normal.starts, twice * one.period, one.value)
    width = abs(branch.span[1] - branch.span[0])
    plane = Plane(normal, through, (size, one.period, width), small_of(shooting, width))
    found = correct(
        shooting, through.starts, through.period, one.value, tolerance=branch.tolerance, iterations=20, plane=plane
    )
    orbit = made(shooting, found, branch.gaps)
    if orbit.ok and twice == 2 and "already" in orbit.status:
        text = "The step came back to the orbit without doubling; try another step="
        return made(shooting, Found(found.last, found.misses, ok=False, status=text), branch.gaps)
    return orbit


def size_of(shooting: Shooting, one: Pass) -> float:
    """What counts as 1 of states: their length, or 1 where they are all 0."""
    length = float(np.mean([shooting.space.length(x) for x in one.starts]))
    return max(length, 1e-2 * shooting.scale) or 1.0


def small_of(shooting: Shooting, width: float) -> float:
    """Difference of the parameter from which derivatives are taken."""
    return (1e-6 if not shooting.is_flow else 1e-5) * width
