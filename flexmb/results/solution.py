"""The record of a run: named signals over time, status, statistics, final state; its text and HTML."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, overload

import numpy as np

from flexmb import display
from flexmb.display import counted, cut, listed, number_text
from flexmb.errors import InputError, SolveError, UnknownNameError
from flexmb.fields import field, record_with
from flexmb.findings.finding import Finding, sentences
from flexmb.late import pd, xr
from flexmb.model.shape import LateShapes, Shapes
from flexmb.model.signal import Signals, hint, resolved
from flexmb.results.contact_intervals import ContactLog, Episodes, impacts, select

if TYPE_CHECKING:
    from flexmb.model.mechanism import Mechanism
    from flexmb.model.part import Part
    from flexmb.results.stress import Fatigue, WoehlerLine


@dataclass(frozen=True, slots=True)
class Stats:
    """Statistics of a run."""

    steps: int = 0  # accepted steps
    # steps tried again with a smaller size; all others than those of the last two numbers exceeded the error
    rejected: int = 0
    newton_iterations: int = 0  # iterations of all steps, the rejected ones included
    evaluations: int = 0  # evaluations of the equations of motion
    factorisations: int = 0  # factorisations of the iteration matrix
    smallest_step: float = 0.0  # smallest_step, largest_step: among the accepted steps [s]
    largest_step: float = 0.0
    wall_time: float = 0.0  # time that passed on the clock, without that of compilations [s]
    rejected_at_contacts: int = 0  # rejected steps that reached beyond an end of a contact, or a jump of a law
    not_converged: int = 0  # rejected steps whose Newton iteration did not converge

    @property
    def rejections(self) -> str:
        """Number of rejected steps, with the reasons that occurred."""
        at_contacts, not_converged = self.rejected_at_contacts, self.not_converged
        counts = (self.rejected - at_contacts - not_converged, at_contacts, not_converged)
        reasons = ("for the error", "at contacts or jumps", "without convergence")
        told = ", ".join(f"{count} {reason}" for count, reason in zip(counts, reasons, strict=True) if count)
        return f"{self.rejected} rejected" + (f": {told}" if told else "")

    def __str__(self) -> str:
        """One line."""
        text = f"{self.steps} steps of {self.smallest_step:.3g} to {self.largest_step:.3g} s ({self.rejections}),"
        text += f" {self.newton_iterations} Newton iterations, {self.evaluations} evaluations,"
        return f"{text} {self.factorisations} factorisations, {self.wall_time:.3g} s on the clock"


class _Peak(NamedTuple):
    """Value and time."""

    value: float
    time: float


class Peak(_Peak):
    """The largest absolute value of a signal over all accepted steps, and its time [s]; `value, time = peak`."""

    node: int | None = None  # where a stress was largest, of a mesh that in the mesh; None of other signals
    # Place of this node in the reference configuration [m]; None also of beams and reduced bodies of a file.
    place: tuple[float, float] | None = None

    def __repr__(self) -> str:
        return f"Peak(value={number_text(self.value)}, time={number_text(self.time)})"


class Peaks(NamedTuple):
    """Largest absolute values of all signals over all accepted steps."""

    values: np.ndarray  # (n_s,) largest absolute values, each in the unit of its signal
    times: np.ndarray  # (n_s,) when they were reached [s]


# Facts of a run: one list for the command line, notebooks and pages
class Fact(NamedTuple):
    """A fact with its value as a text, unit and note."""

    label: str
    value: str
    unit: str = ""
    note: str = ""

    @property
    def text(self) -> str:
        """Value, unit and note."""
        return ", ".join(filter(None, (f"{self.value} {self.unit}".rstrip(), self.note)))


def facts(sol: Solution) -> list[Fact]:
    """Saved instants and signals, cost, error of the balance of energies, contacts."""
    stats = sol.stats
    size = f"of {stats.smallest_step:.3g} to {stats.largest_step:.3g} s"
    more = f"{stats.evaluations} evaluations, {stats.factorisations} factorisations"
    span = f"{sol.time[0]:.6g} to {sol.time[-1]:.6g} s" if len(sol.time) else ""
    found = [
        Fact("saved", counted(len(sol.time), "instant"), note=span),
        Fact("signals", f"{counted(len(sol.names), 'signal')} of {counted(len(_by_part(sol)), 'part')}"),
        Fact("steps", counted(stats.steps, "step"), size, stats.rejections),
        Fact("iterations", counted(stats.newton_iterations, "Newton iteration"), note=more),
        Fact("wall time", f"{stats.wall_time:.3g}", "s"),
    ]
    if "energy.residual" in sol and "energy.turned_over" in sol:
        residual, turned = sol.peak("energy.residual").value, sol.peak("energy.turned_over").value
        share = f"{residual / turned:.2g} of the energy turned over" if turned > 0.0 else ""
        found.append(Fact("energy residual", f"{residual:.3g}", "J", share))
    names = [name.rpartition(".")[0] for name in sol.names if name.endswith(".penetration")]
    for name in dict.fromkeys([*names, *sol.contacts.names]):
        found += [fact._replace(label=f"{fact.label} in {name}") for fact in contact_facts(sol, name)]
    return found


def contact_facts(sol: Solution, name: str) -> list[Fact]:
    """Facts of a joint, or of one of its contacts: share of the saved instants, impacts."""
    found = []
    if f"{name}.penetration" in sol and len(sol.time):
        share, deepest = 100.0 * np.mean(sol.array(f"{name}.penetration") > 0.0), sol.peak(f"{name}.penetration")
        text = f"deepest {max(deepest.value, 0.0):.3g} m at t = {deepest.time:.6g} s"
        found.append(Fact("contact", f"{share:.3g}", "% of the saved instants", text))
    if any(name in (contact, contact.partition(".")[0]) for contact in sol.contacts.names):
        found.append(Fact("impacts", impacts(sol.episodes(name))))
    return found


# Text and HTML of a solution: end of the run, main peaks, notes, facts

# Endings of the main signals: of drives, of contacts, of flexible links, of all bodies that deform.
MAIN_ENDINGS = ("torque", "normal_force", "deflection", "von_mises")
OTHER_ENDINGS = ("force", "ax", "ay", "alpha")  # endings of the signals that stand for the main ones if there are none
MOST_OF_A_KIND = 6  # largest number of main signals with one ending
ROUND_OFF = 1e-10  # peak over the largest one of its unit, up to which it is round-off
IN_TEXT, IN_TABLE = 3, 16  # number of peaks at most in a text and in a table


def largest_signals(sol: Solution) -> list[str]:
    """Names of the signals with the largest peaks."""
    # These are torques, contact forces, deflections and stresses; without any of them forces and accelerations. Of each
    # kind the `MOST_OF_A_KIND` largest ones are told. Signals whose peaks are round-off beside those of other signals
    # are left out, such as the forces of contacts that never close.
    found: dict[str, float] = {}
    for unit, value in zip(sol.signals.units, sol.peaks.values, strict=True):
        found[unit] = max(found.get(unit, 0.0), float(value))  # a NaN is passed over
    energy, length = found.get("J", 0.0), found.get("m", 0.0)
    force = energy / length if length > 0.0 else 0.0
    scales = found | {"N m": max(found.get("N m", 0.0), energy), "N": max(found.get("N", 0.0), force)}
    for endings in (MAIN_ENDINGS, OTHER_ENDINGS):
        told: list[str] = []
        for ending in endings:
            peaks = {name: sol.peak(name).value for name in sol.names if name.endswith(f".{ending}")}
            seen = [name for name, peak in peaks.items() if not peak <= ROUND_OFF * scales[sol.units(name)]]  # NaN is
            kept = sorted(seen, key=lambda name: -peaks[name])[:MOST_OF_A_KIND]
            told += [name for name in seen if name in kept]
        if told:
            return told
    return []


def _by_part(sol: Solution) -> dict[str, list[str]]:
    """Names of signals within their part, by the name of the part."""
    found: dict[str, list[str]] = {}
    for name in sol.names:
        part, _, own = name.partition(".")
        found.setdefault(part, []).append(own)
    return found


SAVED_KEY = "signals"  # key of `Solution.model` for the chosen signals, where not all were saved
STEPS_KEY = "every_step"  # key of `Solution.model`: whether every accepted step was saved


def matching(names: Sequence[str], pattern: str) -> list[str]:
    """The names that a pattern fits; its only sign is *, any text."""
    fits = re.compile(".*".join(map(re.escape, pattern.split("*")))).fullmatch
    return [name for name in names if fits(name)]


LateFindings = Callable[[], Iterable[Finding]]


class UnknownSignalError(InputError, UnknownNameError):
    """A name that is no signal of a solution; also a `KeyError`, as of any mapping."""


@record_with(eq=False, kw_only=True, repr=False)
class Solution:
    """Result of a run; immutable.

    `sol["PART.SIGNAL"]` is an `xarray.DataArray` over `time`, `sol[["A.x", "B.y"]]` and `sol["slider.*"]` are datasets
    of several signals; nodes of flexible parts go by their number or by another name: "rod.node8.x" and "rod.end.x" are
    the same signal.

    Raises
    ------
    InputError : arrays whose lengths do not fit together, two signals of one name.
    """

    time: np.ndarray = field("(n,) saved instants, increasing", "s")
    values: np.ndarray = field("(n, n_s) the signals at these instants, each in its unit")
    signals: Signals = field("(n_s,) names and units")
    peaks: Peaks = field("largest absolute values over all accepted steps, and their times")
    status: str = field("how the run ended, a sentence")
    ok: bool = field("whether it reached the end that was asked for")
    stats: Stats = field("what it cost")
    contacts: ContactLog = field("names of the contacts and their episodes, see `episodes`", default_factory=ContactLog)
    aliases: Mapping[str, str] = field('other names of nodes, e.g. {"rod.end": "rod.node8"}', default_factory=dict)
    shapes: Shapes = field("how the parts are drawn", default=())
    restart: Mapping[str, np.ndarray] = field(
        "the final state, by name: what the time loop needs to go on bit for bit", default_factory=dict
    )
    notes: tuple[str, ...] = field(
        "remarks on the run, e.g. of contact laws that left their validity, in sentences; left out: those of the "
        "findings that are no errors", default_factory=tuple
    )  # fmt: skip
    model: Mapping[str, Any] = field(
        "name of the mechanism, version of flexmb, and what else belongs to the record and can be written as JSON",
        default_factory=dict,
    )
    mechanism: Mechanism | None = field("the mechanism that moved; None: read from a file, or sent", default=None)
    description: Mapping[str, Any] = field(
        "parts of the mechanism in plain values, where `mechanism` is None", default_factory=dict
    )
    findings: tuple[Finding, ...] = field(
        "findings on the run, each with code, parts, text, remedy, severity and numbers, as those of `check`",
        default_factory=tuple,
    )
    late: LateFindings | None = field(
        "function that looks for more of them, none of which is an error; called when `findings` or `notes` are first "
        "asked for, printed or saved", default=None
    )  # fmt: skip

    def __post_init__(self) -> None:
        self._set("signals", Signals.of(self.signals))
        _ = self.signals.places  # two of one name are refused
        n_s, time = len(self.signals), _frozen("time", self.time, (None,))
        self._set("time", time)
        self._set("values", _frozen("values", self.values, (len(time), n_s)))
        largest, when = self.peaks
        self._set("peaks", Peaks(_frozen("peaks.values", largest, (n_s,)), _frozen("peaks.times", when, (n_s,))))
        self._set("contacts", self.contacts.checked())
        self._set("shapes", self.shapes if isinstance(self.shapes, LateShapes) else tuple(self.shapes))
        self._set("restart", {name: _read_only(array) for name, array in self.restart.items()})
        self._set("aliases", dict(self.aliases))
        self._set("findings", tuple(self.findings))
        self._set("notes", tuple(self.notes) or sentences(self.findings))
        if self.late is not None:  # `__getattr__` finds both: neither has a default in the class
            self._set("_prompt", self.__dict__.pop("findings"))
            del self.__dict__["notes"]
        self._set("model", dict(self.model))
        if np.any(np.diff(time) < 0.0):
            raise InputError("Solution: time decreases; it must increase from one saved instant to the next.")

    @property
    def has_every_step(self) -> bool:
        """Whether all accepted steps are among the saved instants, `save="steps"`."""
        return bool(self.model.get(STEPS_KEY, False))

    @overload
    def __getitem__(self, name: str) -> xr.DataArray: ...  # type: ignore[overload-overlap] # a text is a sequence

    @overload
    def __getitem__(self, name: Sequence[str]) -> xr.Dataset: ...

    def __getitem__(self, name: Any) -> xr.DataArray | xr.Dataset:
        """The signal of that name over `time`; a dataset for several names or patterns; or `UnknownSignalError`."""
        from flexmb.results.netcdf import long_name

        if isinstance(name, list | tuple) or (isinstance(name, str) and "*" in name):
            found = list[Any]()  # names that a name or a pattern fits; the name alone if there is none
            for one in [name] if isinstance(name, str) else name:
                pattern = resolved(one, self.signals, self.aliases) if isinstance(one, str) else ""
                found += (matching(self.names, pattern) if "*" in pattern else []) or [one]
            return self._dataset(found)
        units = self.signals.units[self._place(name)]
        time = xr.Variable("time", self.time, {"units": "s"})
        attrs = {"units": units, "long_name": long_name(name), "name": name}
        return xr.DataArray(self.array(name), coords={"time": time}, dims="time", name=name, attrs=attrs)

    def __contains__(self, name: object) -> bool:
        return isinstance(name, str) and resolved(name, self.signals, self.aliases) in self.signals.places

    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all signals, without their aliases."""
        return self.signals.names

    @property
    def dataset(self) -> xr.Dataset:
        """All signals, with the status as attribute."""
        return self._dataset(self.names)

    def to_dataframe(self) -> pd.DataFrame:
        """Table of pandas: a row per saved instant, indexed by `time` [s], and a column per signal in SI units."""
        return self.dataset.to_dataframe()

    def _dataset(self, names: Sequence[str]) -> xr.Dataset:
        """Signals of these names."""
        from flexmb.results.netcdf import long_name

        time = xr.Variable("time", self.time, {"units": "s", "long_name": "time"})
        units = {name: {"units": self.units(name), "long_name": long_name(name)} for name in names}
        columns = {name: xr.Variable("time", self.array(name), units[name]) for name in names}
        attrs = {"mechanism": self.name, "status": self.status, "ok": int(self.ok)}
        return xr.Dataset(columns, coords={"time": time}, attrs=attrs)

    @property
    def name(self) -> str:
        """Name of the mechanism."""
        return str(self.model.get("name", ""))

    def array(self, name: str) -> np.ndarray:
        """The signal `name` as a read-only array (n,): `sol[name].values` without the cost of labels."""
        return np.asarray(self.values[:, self._place(name)])

    def units(self, name: str) -> str:
        """SI unit of the signal `name`."""
        return self.signals.units[self._place(name)]

    def peak(self, name: str) -> Peak:
        """Largest absolute value of the signal `name` and its time, over all accepted steps and not the saved ones.

        That of the largest stress of a flexible body, "rod.von_mises", has its place, too: `peak.node`, `peak.place`.
        """
        k = self._place(name)
        peak = Peak(float(self.peaks.values[k]), float(self.peaks.times[k]))
        at = self.signals.places.get(f"{self.signals.names[k]}_node")
        if at is not None:
            from flexmb.results.stress import place_of_stress

            peak.node = round(float(self.peaks.values[at]))
            peak.place = place_of_stress(self, self.signals.names[k].partition(".")[0], peak.node)
        return peak

    def stress(
        self, body: str, points: Sequence[tuple[float, float] | int | str] | None = None, *,
        times: Sequence[float] | None = None, mechanism: Mechanism | None = None,
    ) -> xr.Dataset:  # fmt: skip
        """Stresses [Pa] of a flexible body at the saved instants, over `time` and `place`.

        Of beams `axial`, `bending` (in the outer fibre on the left), `bending_right`, at both ends and in the middle of
        all elements, and of meshes `sx`, `sy`, `txy` in the axes of the mesh, which turn with the body, `principal_1`,
        `principal_2`, at all nodes; of both `signed`, the normal stress that is largest by its absolute value, and
        `von_mises`.  Coordinates: `node`, `x`, `y` in the reference configuration [m]; of beams `beam`, `element`, and
        `station` along the beam [m].

        Parameters
        ----------
        body : name of the body.
        points : points (x, y) in the reference configuration [m], whose nearest places are taken, or numbers of nodes,
            or of beams names of nodes such as "end"; None: all.  Middles of elements are numbered behind the nodes.
        times : instants [s], of which the nearest saved ones are taken; None: all saved ones.
        mechanism : the mechanism that moved, for a solution that was read from a file.

        Raises
        ------
        InputError : a body without stresses, an unknown point, a solution that does not know its mechanism, or without
            velocities and accelerations of a body of beams.

        Notes
        -----
        Elastic stresses, without damping; `peak` finds the largest one over all accepted steps.
        """
        from flexmb.results.stress import stress

        return stress(self, body, points, times, mechanism)

    def positions(
        self, body: str, points: Sequence[tuple[float, float] | int | str] | None = None, *,
        times: Sequence[float] | None = None, mechanism: Mechanism | None = None,
    ) -> xr.Dataset:  # fmt: skip
        """Positions `x`, `y` [m] of points of a flexible body at the saved instants, over `time` and `place`.

        Points are nodes of beams and of meshes; those of a reduced body are the nodes of its mesh, or of reduced beams
        the outer fibres at stations along them.  Coordinates: `node`, and `x0`, `y0` in the reference configuration.

        Parameters
        ----------
        body : name of the body.
        points : as for `stress`.
        times : instants [s], of which the nearest saved ones are taken; None: all saved ones.
        mechanism : as for `stress`.

        Raises
        ------
        InputError : a body that is not flexible, an unknown point, a solution that does not know its mechanism.
        """
        from flexmb.results.positions import positions

        return positions(self, body, points, times, mechanism)

    def fatigue(
        self, body: str, woehler: WoehlerLine | None = None, *, point: tuple[float, float] | int | str | None = None,
        mechanism: Mechanism | None = None,
    ) -> Fatigue:  # fmt: skip
        """Rainflow count of the stress at a point, and its damage by Palmgren and Miner; see `results.Fatigue`.

        Parameters
        ----------
        body : name of the body.
        woehler : the Woehler line; None: cycles are counted alone.
        point : point or node as for `stress`; None: the node of the largest stress over all accepted steps.
        mechanism : as for `stress`.

        Raises
        ------
        InputError : as for `stress`; without a point, a body that does not look for its largest stress.
        MissingPackageError : the package that counts is missing.
        """
        from flexmb.results.stress import fatigue

        return fatigue(self, body, woehler, point, mechanism)

    def require(self) -> Solution:
        """The solution itself, or the error of a run that did not reach its end.

        Raises
        ------
        SolveError : `ok` is False; the message holds the status.
        """
        if not self.ok:
            raise SolveError(f"Run of {self.name!r}: {self.status}")
        return self

    def episodes(self, name: Part | str | None = None) -> Episodes:
        """The episodes of contact of a joint, of one of its contacts, or (None) of all, in the order of their starts.

        All that ended since saving began, whatever was saved, and those that were running when the run ended.

        Parameters
        ----------
        name : a joint or its name, e.g. "P1" or "G", or one of several contacts of a joint, e.g. "G.upper_front".

        Raises
        ------
        UnknownContactError : a name that is no contact.
        """
        wanted: Any = getattr(name, "name", None) or name
        return select(self.contacts, self.name, wanted)

    def to_netcdf(self, path: str | Path) -> Path:
        """Write everything to the file `path`, whose folder is made; `flexmb.load` reads it back bit for bit."""
        from flexmb.results.netcdf import save

        return save(self, path)

    def __repr__(self) -> str:  # three lines, five at most
        saved, signals, steps, _, clock, *_ = facts(self)
        lines = [cut(f"Solution of {self.name!r}: {self.status}", 3)]
        lines += [f"  {saved.text}; {signals.text}; {steps.value} in {clock.text} on the clock"]
        # The main signals, one of each kind before others
        names = largest_signals(self)
        endings = [name.rpartition(".")[2] for name in names]
        order = sorted(range(len(names)), key=lambda k: endings[:k].count(endings[k]))
        main = [names[k] for k in order[:IN_TEXT]]
        peaks = [f"{name} {self.peak(name).value:.4g} {self.units(name)}".rstrip() for name in main]
        last = ["largest " + ", ".join(peaks)] if peaks else []
        last += [counted(len(self.notes), "note") + " in sol.notes"] if self.notes else []
        return "\n".join([*lines, *([cut(f"  {'; '.join(last)}")] if last else [])])

    def _repr_html_(self) -> str:  # a small player, below it the table
        from flexmb.show.reports.scene import cell

        peaks = [(name, *self.peak(name)) for name in largest_signals(self)[:IN_TABLE]]
        rows = [(name, f"{value:.6g}", self.units(name), f"{time:.6g}") for name, value, time in peaks]
        parts = _by_part(self)
        signals = display.table([(owner, ", ".join(names)) for owner, names in parts.items()])
        return cell(self) + display.page(
            f"Solution of {self.name!r}",
            self.status,
            display.table((fact.label, fact.text) for fact in facts(self)),
            display.table(rows, ("signal", "largest absolute value", "unit", "at t [s]")),
            display.folded(counted(len(self.notes), "note"), display.texts(self.notes)),
            display.folded(f"{counted(len(self.names), 'signal')} of {listed(parts, 5) or 'no part'}", signals),
        )

    def _ipython_key_completions_(self) -> list[str]:
        return [*self.names, *(self._alias(name) for name in self.names if self._alias(name) != name)]

    def _alias(self, name: str) -> str:
        """Name of a signal by the alias of its node: "rod.end.x" for "rod.node8.x"; without alias as it is."""
        node, _, own = name.rpartition(".")
        return next((f"{alias}.{own}" for alias, target in self.aliases.items() if target == node), name)

    def described(self) -> dict[str, Any]:
        """Parts of the mechanism in plain values; empty for a solution that knows none."""
        if self.mechanism is None:
            return dict(self.description)
        from flexmb.model.mechanism import described

        return described(self.mechanism)

    def __getstate__(self) -> dict[str, Any]:
        """State for pickling: the mechanism as its description, since functions of users cannot all be pickled."""
        _ = self.findings
        return {**self.__dict__, "mechanism": None, "description": self.described()}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self.__post_init__()  # arrays come back writeable

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            """Findings and notes, at their first use."""
            late = self.__dict__.get("late") if name in ("findings", "notes") else None
            if late is not None:
                with np.errstate(all="ignore"):
                    found = (*self._prompt, *late())
                self._set("findings", found)
                self._set("notes", sentences(found))
                self._set("late", None)
            if name not in self.__dict__:
                raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
            return self.__dict__[name]

    def _set(self, name: str, value: object) -> None:
        object.__setattr__(self, name, value)

    def _place(self, name: Any) -> int:
        place = self.signals.places.get(resolved(name, self.signals, self.aliases)) if isinstance(name, str) else None
        if place is None:
            text = f"Solution of {self.name!r} has no signal {name!r}. {hint(str(name), self.signals, self.aliases)}"
            if str(name) in ("time", "t"):
                text = f"{text.partition(' Known:')[0]} The instants of all rows are sol.time."
            if SAVED_KEY in self.model:
                text += f" Saved were only those of simulate(..., signals={self.model[SAVED_KEY]!r}); add it there."
            raise UnknownSignalError(text)
        return place


def require_solution(label: str, sol: object) -> None:
    """Refuse anything but a solution; `label`: name of the caller."""
    if not isinstance(sol, Solution):
        raise InputError(f"{label}: sol is {type(sol).__name__}; it must be a solution, as simulate(...) returns it.")


def require_rows(label: str, sol: Solution, *, drawn: bool = True) -> None:
    """Refuse a solution without saved instants, or, to be drawn, without shapes; `label`: name of the caller."""
    require_solution(label, sol)
    if not len(sol.time):
        raise InputError(f"{label}: the solution has no saved instants. Save some, e.g. by simulate(..., save=...).")
    if drawn and not sol.shapes:
        raise InputError(f"{label}: the solution has no shapes to draw. Build it from a mechanism with bodies.")


def _frozen(name: str, values: Any, shape: tuple[int | None, ...]) -> Any:
    """`values` as a read-only float array of a shape (None: any length), itself if it is one: copies take long."""
    is_own = type(values) is np.ndarray and values.dtype == np.float64 and values.flags.owndata
    is_fixed = is_own and values.flags.c_contiguous and not values.flags.writeable
    array: Any = values if is_fixed else np.array(values, dtype=np.float64, order="C")
    if array.ndim != len(shape) or any(want not in (None, n) for n, want in zip(array.shape, shape, strict=True)):
        wanted = ", ".join("n" if n is None else str(n) for n in shape)
        raise InputError(f"Solution: {name} has shape {array.shape}; it must have shape ({wanted}).")
    array.flags.writeable = False
    return array


def _read_only(values: object) -> np.ndarray:
    array = np.array(values)
    array.flags.writeable = False
    return array
