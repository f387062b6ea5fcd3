"""The record of a run: named signals over time, status, statistics, final state."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, overload

import numpy as np

from flexmb.errors import InputError, SolveError
from flexmb.model.shape import LateShapes, Shapes
from flexmb.model.signal import Signals, hint, resolved
from flexmb.results.contact_intervals import ContactLog, Episodes, select
from flexmb.results.conventions import long_name
from flexmb.results.late_values import LateField, LateValues
from flexmb.results.peaks import Peak, PeakOfStress, Peaks
from flexmb.results.signal_names import SAVED_KEY, matching
from flexmb.results.solution_text import solution_html, solution_text
from flexmb.results.stats import Stats

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

    from flexmb.model.mechanism import Mechanism
    from flexmb.model.part import Part
    from flexmb.results.fatigue import Fatigue, WoehlerLine


class UnknownSignalError(InputError, KeyError):
    """A name that is no signal of a solution; also a `KeyError`, as of any mapping."""

    def __str__(self) -> str:
        """The message as it is; `KeyError` alone would show it in quotes."""
        return str(self.args[0])


@dataclass(frozen=True, eq=False, repr=False)
class Solution:
    """Result of a run; immutable.

    `sol["PART.SIGNAL"]` is an `xarray.DataArray` over `time`, `sol[["A.x", "B.y"]]` and `sol["slider.*"]` are datasets
    of several signals; nodes of flexible parts go by their number or by another name: "rod.node8.x" and "rod.end.x" are
    the same signal.

    Parameters
    ----------
    time : (n,) saved instants [s], increasing.
    values : (n, n_s) the signals at these instants, each in its unit.
    signals : (n_s,) names and units.
    peaks : largest absolute values over all accepted steps, and their times.
    status : how the run ended, a sentence.
    ok : whether it reached the end that was asked for.
    stats : what it cost.
    contacts : names of the contacts and their episodes; see `episodes`.
    aliases : other names of nodes, e.g. {"rod.end": "rod.node8", "rod": "rod.node4"}.
    shapes : how the parts are drawn.
    restart : the final state, by name; what the time loop needs to go on bit for bit.
    notes : remarks on the run, e.g. of contact laws that left their validity, in sentences.
    model : name of the mechanism, version of flexmb, and what else belongs to the record and can be written as JSON.
    mechanism : the mechanism that moved; None in a solution that was read from a file or came from another process.
    description : parts of the mechanism in plain values (`flexmb.model.description`), where `mechanism` is None.

    Raises
    ------
    InputError : arrays whose lengths do not fit together, two signals of one name.
    """

    _: KW_ONLY
    time: np.ndarray
    values: np.ndarray = LateField()  # type: ignore[assignment] # noqa: RUF009 - a descriptor is no default
    signals: Signals
    peaks: Peaks
    status: str
    ok: bool
    stats: Stats
    contacts: ContactLog = field(default_factory=ContactLog)
    aliases: Mapping[str, str] = field(default_factory=dict)
    shapes: Shapes = ()
    restart: Mapping[str, np.ndarray] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    model: Mapping[str, Any] = field(default_factory=dict)
    mechanism: Mechanism | None = None
    description: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self._set("signals", Signals.of(self.signals))
        _ = self.signals.places  # two of one name are refused
        n_s = len(self.signals)
        time = _frozen("time", self.time, (None,))
        self._set("time", time)
        self._set("values", _frozen("values", vars(self)["values"], (len(time), n_s)))
        largest, when = self.peaks
        self._set("peaks", Peaks(_frozen("peaks.values", largest, (n_s,)), _frozen("peaks.times", when, (n_s,))))
        self._set("contacts", self.contacts.checked())
        self._set("shapes", self.shapes if isinstance(self.shapes, LateShapes) else tuple(self.shapes))
        self._set("restart", {name: _read_only(array) for name, array in self.restart.items()})
        self._set("aliases", dict(self.aliases))
        self._set("notes", tuple(self.notes))
        self._set("model", dict(self.model))
        if np.any(np.diff(time) < 0.0):
            raise InputError("Solution: time decreases; it must increase from one saved instant to the next.")

    @overload
    def __getitem__(self, name: str) -> xr.DataArray: ...  # type: ignore[overload-overlap] # a text is a sequence

    @overload
    def __getitem__(self, name: Sequence[str]) -> xr.Dataset: ...

    def __getitem__(self, name: Any) -> xr.DataArray | xr.Dataset:
        """The signal of that name over `time`; a dataset for several names or patterns; or `UnknownSignalError`."""
        import xarray as xr

        if isinstance(name, list | tuple) or (isinstance(name, str) and "*" in name):
            asked = [name] if isinstance(name, str) else name
            return self._dataset([fitting for one in asked for fitting in self._fitting(one)])
        k = self._place(name)
        units = self.signals.units[k]
        time = xr.Variable("time", self.time, {"units": "s"})
        attrs = {"units": units, "long_name": long_name(name), "name": name}
        return xr.DataArray(self.array(name), coords={"time": time}, dims="time", name=name, attrs=attrs)

    def __contains__(self, name: object) -> bool:
        return isinstance(name, str) and resolved(name, self.signals, self.aliases) in self._places

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
        import xarray as xr

        time = xr.Variable("time", self.time, {"units": "s", "long_name": "time"})
        columns = {
            name: xr.Variable("time", self.array(name), {"units": self.units(name), "long_name": long_name(name)})
            for name in names
        }
        attrs = {"mechanism": self.name, "status": self.status, "ok": int(self.ok)}
        return xr.Dataset(columns, coords={"time": time}, attrs=attrs)

    @property
    def name(self) -> str:
        """Name of the mechanism."""
        return str(self.model.get("name", ""))

    def array(self, name: str) -> np.ndarray:
        """The signal `name` as a read-only array (n,): `sol[name].values` without the cost of labels."""
        place, held = self._place(name), vars(self)["values"]
        column: np.ndarray = held.column(place) if isinstance(held, LateValues) else held[:, place]
        return column

    def units(self, name: str) -> str:
        """SI unit of the signal `name`."""
        return self.signals.units[self._place(name)]

    def peak(self, name: str) -> Peak:
        """Largest absolute value of the signal `name` and its time, over all accepted steps and not the saved ones.

        That of the largest stress of a flexible body, "rod.von_mises", has its place, too: `peak.node`, `peak.place`.
        """
        k = self._place(name)
        peak = Peak(float(self.peaks.values[k]), float(self.peaks.times[k]))
        at = self._places.get(f"{self.signals.names[k]}_node")
        if at is None:
            return peak
        part, node = self.signals.names[k].partition(".")[0], round(float(self.peaks.values[at]))
        from flexmb.results.reference_points import place_of_stress

        return PeakOfStress(peak, node, place_of_stress(self, part, node))

    def stress(
        self,
        body: str,
        points: Sequence[tuple[float, float] | int | str] | None = None,
        *,
        times: Sequence[float] | None = None,
        mechanism: Mechanism | None = None,
    ) -> xr.Dataset:
        """Stresses [Pa] of a flexible body at the saved instants, over `time` and `place`.

        Of beams `axial`, `bending` (in the outer fibre on the left), at both ends of all elements, and of meshes `sx`,
        `sy`, `txy` in the axes of the mesh, which turn with the body, `principal_1`, `principal_2`, at all nodes; of
        both `signed`, the normal stress that is largest by its absolute value, and `von_mises`.  Coordinates: `node`,
        `x`, `y` in the reference configuration [m]; of beams `beam`, `element`, and `station` along the beam [m].

        Parameters
        ----------
        body : name of the body.
        points : points (x, y) in the reference configuration [m], whose nearest nodes are taken, or numbers of nodes,
            or of beams names of nodes such as "end"; None: all nodes.
        times : instants [s], of which the nearest saved ones are taken; None: all saved ones.
        mechanism : the mechanism that moved, for a solution that was read from a file.

        Raises
        ------
        InputError : a body without stresses, an unknown point, a solution that does not know its mechanism.

        Notes
        -----
        Elastic stresses, without damping; `peak` finds the largest one over all accepted steps.  In beams with a force
        along the element, such as that of inertia, the axial stress is the mean of its element.
        """
        from flexmb.results.stress import stress

        return stress(self, body, points, times=times, mechanism=mechanism)

    def positions(
        self,
        body: str,
        points: Sequence[tuple[float, float] | int | str] | None = None,
        *,
        times: Sequence[float] | None = None,
        mechanism: Mechanism | None = None,
    ) -> xr.Dataset:
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

        return positions(self, body, points, times=times, mechanism=mechanism)

    def fatigue(
        self,
        body: str,
        woehler: WoehlerLine | None = None,
        *,
        point: tuple[float, float] | int | str | None = None,
        mechanism: Mechanism | None = None,
    ) -> Fatigue:
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
        from flexmb.results.fatigue import fatigue

        return fatigue(self, body, woehler, point=point, mechanism=mechanism)

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

    def __repr__(self) -> str:
        return solution_text(self)

    def _repr_html_(self) -> str:
        return solution_html(self)

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
        from flexmb.model.description import described

        return described(self.mechanism)

    def __getstate__(self) -> dict[str, Any]:
        """State for pickling: the mechanism as its description, since functions of users cannot all be pickled."""
        return {**self.__dict__, "mechanism": None, "description": self.described()}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self.__post_init__()  # arrays come back writeable

    def _set(self, name: str, value: object) -> None:
        object.__setattr__(self, name, value)

    @property
    def _places(self) -> dict[str, int]:
        return self.signals.places

    def _fitting(self, name: str) -> Sequence[str]:
        """Names of the signals that a name or a pattern fits; the name alone if there is none."""
        pattern = resolved(name, self.signals, self.aliases) if isinstance(name, str) else ""
        return (matching(self.names, pattern) if "*" in pattern else []) or [name]

    def _place(self, name: Any) -> int:
        place = self._places.get(resolved(name, self.signals, self.aliases)) if isinstance(name, str) else None
        if place is None:
            text = f"Solution of {self.name!r} has no signal {name!r}. {hint(str(name), self.signals, self.aliases)}"
            if name in ("time", "t"):
                text = f"{text.partition(' Known:')[0]} The instants of all rows are sol.time."
            if SAVED_KEY in self.model:
                text += f" Saved were only those of simulate(..., signals={self.model[SAVED_KEY]!r}); add it there."
            raise UnknownSignalError(text)
        return place


def _frozen(name: str, values: Any, shape: tuple[int | None, ...]) -> Any:
    """`values` as a read-only float array of that shape (None: any length), late values as they are.

    An array that is read-only already is taken as it is: copying what a run saved would take as long as saving it.
    """
    late = isinstance(values, LateValues)
    array: Any = values if late or _is_fixed(values) else np.array(values, dtype=np.float64, order="C")
    fits = len(array.shape) == len(shape) and all(want in (None, n) for n, want in zip(array.shape, shape, strict=True))
    if not fits:
        wanted = ", ".join("n" if n is None else str(n) for n in shape)
        raise InputError(f"Solution: {name} has shape {array.shape}; it must have shape ({wanted}).")
    if not late:
        array.flags.writeable = False
    return array


def _is_fixed(values: object) -> bool:
    """Whether `values` are floats of an array's own, in C order, that nobody can write to."""
    if type(values) is not np.ndarray or values.dtype != np.float64:
        return False
    return values.flags.owndata and values.flags.c_contiguous and not values.flags.writeable


def _read_only(values: object) -> np.ndarray:
    array = np.array(values)
    array.flags.writeable = False
    return array
