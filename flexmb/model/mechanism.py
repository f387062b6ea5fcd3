"""Declaration of a mechanism: named parts and gravity; its text, its description in plain values."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import fields, is_dataclass, replace
from difflib import get_close_matches
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from flexmb import arguments, checks, display
from flexmb.display import counted, cut, listed, number_text, pretty
from flexmb.errors import FlexmbError, InputError, ModelError, UnknownNameError
from flexmb.fields import field, record_with, unit_of
from flexmb.model import contributions as pieces
from flexmb.model.contributions import Contribution, Contributions, Coordinate, Node
from flexmb.model.part import GROUND, Body, Controller, Joint, Part, declared_state, name_of
from flexmb.model.shape import Shapes

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LISTED_PARTS = 12  # number of parts at most in a line


def _numbers(mechanism: Mechanism) -> str:
    """Numbers of parts, and gravity."""
    joints, bodies = sum(isinstance(part, Joint) for part in mechanism.parts), len(mechanism.bodies)
    rest = len(mechanism.parts) - bodies - joints
    texts = [counted(bodies, "body"), counted(joints, "joint"), *([counted(rest, "other part")] if rest else [])]
    gx, gy = mechanism.gravity
    gravity = f"gravity ({number_text(gx)}, {number_text(gy)}) m/s^2" if gx or gy else "no gravity"
    return f"{', '.join(texts)}; {gravity}"


def _names(parts: Sequence[Part]) -> str:
    """Names with classes, parts of one class together."""
    kinds: dict[str, list[str]] = {}
    for part in parts[:LISTED_PARTS]:
        kinds.setdefault(type(part).__name__, []).append(part.name)
    shown = ", ".join(f"{listed(names, LISTED_PARTS)} ({kind})" for kind, names in kinds.items())
    return f"{shown} and {len(parts) - LISTED_PARTS} more" if len(parts) > LISTED_PARTS else shown


LISTED_VALUES = 8  # number of values of a sequence at most; a longer one is described by its length


def described(mechanism: Mechanism) -> dict[str, Any]:
    """Plain values that describe a mechanism, for JSON: "gravity" [m/s^2] and "parts"."""
    # Each part has its "name", its "class", the kind "body" or "part", its "mass" [kg] (bodies alone), and "fields":
    # [value, unit] by the name of the field, without fields that are None. Values are numbers, texts, lists of these,
    # or for laws, materials and sections such fields again, with "class".
    parts = []
    for part in mechanism.parts:
        kind = {"kind": "body", "mass": plain(part.total_mass())} if isinstance(part, Body) else {"kind": "part"}
        parts.append({"name": part.name, "class": type(part).__name__, **kind, "fields": _fields(part)})
    return {"gravity": list(mechanism.gravity), "parts": parts}


def _fields(owner: Any) -> dict[str, list[Any]]:
    """Values and units of the declared fields of a record, without its name and without fields that are None."""
    names = (field.name for field in fields(owner) if field.init and field.name != "name")
    values = {name: getattr(owner, name) for name in names}
    return {name: [plain(value), unit_of(type(owner), name)] for name, value in values.items() if value is not None}


def plain(value: Any) -> Any:
    """A value as numbers, texts and lists of these; records become dictionaries of their fields."""
    if isinstance(value, np.generic):
        value = value.item()
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, Part):
        return value.name
    if is_dataclass(value) and not isinstance(value, type):
        return {"class": type(value).__name__, "fields": _fields(value)}
    if isinstance(value, tuple | list | np.ndarray | Mapping):
        short = len(value) <= LISTED_VALUES and not isinstance(value, Mapping)
        return [plain(item) for item in value] if short else f"{len(value)} values"
    return str(getattr(value, "__name__", type(value).__name__))


LEFT_OUT = frozenset({"first", "second", "body", "mass", "outline", "class"})  # columns of their own, and drawings


def values_text(fields: Mapping[str, Any], between: str = "; ", units: Mapping[str, str] | None = None) -> str:
    """Values of a part or law in one line, from [value, unit] by field, without zeros; `units`: others by units."""
    found = []
    for name, (value, unit) in fields.items():
        if name in LEFT_OUT or value is None or value is False or value == 0:
            continue
        word = name.replace("_", " ")
        if isinstance(value, Mapping):
            inner = values_text(value["fields"], ", ", units)
            found.append(f"{word} {value['class']}" + (f" ({inner})" if inner else ""))
        else:
            shown = "" if isinstance(value, str) else pretty((units or {}).get(unit, unit))  # a word has none
            found.append(word if value is True else f"{word} {_value_text(value)} {shown}".rstrip())
    return between.join(found)


def _value_text(value: Any) -> str:
    if isinstance(value, list):
        return f"({', '.join(_value_text(item) for item in value)})"
    if isinstance(value, Mapping):
        return str(value.get("class", ""))
    return number_text(value) if isinstance(value, float) else str(value)


ACTING = pieces.ElementContribution | pieces.ConstraintContribution | pieces.ContactContribution  # on coordinates
# Names that no part may have, with their owners.
RESERVED = {GROUND.name: "the ground, which is there already: fm.GROUND", "energy": "the signals of the energies"}


class UnknownPartError(ModelError, UnknownNameError):
    """A name that is no part of a mechanism; also a `KeyError`, as of any mapping."""


@record_with(repr=False)
class Mechanism(metaclass=arguments.CheckedType):
    """A planar mechanism: parts with unique names, in a reference configuration.

    `mech["crank"]` is a part, `"crank" in mech` tells whether there is one; names are iterated over.

    Raises
    ------
    ModelError : duplicate names, a part connected to one that is not there, a joint driven twice; all told at once.
    InputError : a value that is not a part, a gravity that is not a pair of finite numbers.
    """

    name: str = field("name of the mechanism")
    parts: Sequence[Part] = field("bodies, joints, drives, loads and elements in any order")
    gravity: tuple[float, float] = field("acceleration of gravity (gx, gy)", "m/s^2", default=(0.0, 0.0))

    def __post_init__(self) -> None:
        checks.identifier("Mechanism", self.name)
        object.__setattr__(self, "parts", checks.sequence(self.label, "parts", self.parts, "parts"))
        object.__setattr__(self, "gravity", checks.point(self.label, "gravity", self.gravity, "m/s^2"))
        wrong: list[FlexmbError] = []
        seen: dict[str, Part] = {}
        for part in self.parts:
            if not isinstance(part, Part):
                raise InputError(f"{self.label}: {part!r} is not a part.")
            if part.name in seen or part.name in RESERVED:
                other = f"{seen[part.name].label}" if part.name in seen else RESERVED[part.name]
                text = f"{self.label} has two parts named {part.name!r}: {part.label} and {other}."
                wrong.append(ModelError(f"{text} Rename one."))
            seen[part.name] = part
        self._raise([*wrong, *self._missing_parts()])
        invalid: list[FlexmbError] = []
        for part in self.parts:
            try:
                part.validate(self)
            except FlexmbError as error:
                invalid.append(error)
        self._raise(invalid)

    def _raise(self, errors: list[FlexmbError]) -> None:
        """Raise the only error, or one with the texts of all."""
        if len(errors) == 1:
            raise errors[0]
        if errors:
            texts = "\n".join(f"{k}. {error}" for k, error in enumerate(errors, 1))
            raise ModelError(f"{self.label} has {len(errors)} errors:\n{texts}")

    def _missing_parts(self) -> Iterator[ModelError]:
        for part in self.parts:
            for name in part.references():
                if name != GROUND.name and name not in self._by_name:
                    text = f"{part.label} refers to {name!r}, which is not in mechanism {self.name!r}."
                    yield ModelError(f"{text} Add it to the parts. {checks.did_you_mean(name, self.names)}")

    @property
    def label(self) -> str:
        """Class and name, as messages show it."""
        return f"Mechanism {self.name!r}"

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the parts in order of declaration."""
        return tuple(self._by_name)

    @cached_property
    def bodies(self) -> tuple[Body, ...]:
        """The bodies in order of declaration, without the ground."""
        return tuple([part for part in self.parts if isinstance(part, Body)])

    @cached_property
    def controllers(self) -> tuple[Controller, ...]:
        """The controllers in order of declaration."""
        return tuple([part for part in self.parts if isinstance(part, Controller)])

    @cached_property
    def controllers_of(self) -> dict[str, list[Controller]]:
        """The controllers of each load by its name."""
        found: dict[str, list[Controller]] = {}
        for part in self.controllers:
            for load in part.control().loads:
                found.setdefault(load, []).append(part)
        return found

    @cached_property
    def _by_name(self) -> dict[str, Part]:
        return {part.name: part for part in self.parts}

    def acting_on(self, coordinate: Coordinate) -> Sequence[tuple[Part, Any, int]]:
        """Parts that are no bodies, with the element, constraint or contact that acts on a coordinate, and its place.

        A part that cannot say how it acts is left out: its error is found elsewhere.
        """
        return self._acting.get(coordinate, ())

    @cached_property
    def _acting(self) -> dict[Coordinate, list[tuple[Part, Any, int]]]:
        found: dict[Coordinate, list[tuple[Part, Any, int]]] = {}
        for part in self.parts:
            contributions: Sequence[Any] = ()
            if not isinstance(part, Body):
                with suppress(FlexmbError):
                    contributions = self.contributions_of(part)
            for one in contributions:
                if isinstance(one, ACTING):
                    for place, coordinate in enumerate(one.coordinates):
                        found.setdefault(coordinate, []).append((part, one, place))
        return found

    def __getstate__(self) -> dict[str, Any]:
        return declared_state(self)

    def __getitem__(self, name: Part | str) -> Part:
        """The part of that name, or `UnknownPartError` with the nearest name."""
        return self.find(name)

    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

    def __contains__(self, name: object) -> bool:
        return isinstance(name, str) and name in self._by_name

    def _ipython_key_completions_(self) -> list[str]:
        return list(self.names)

    def __repr__(self) -> str:
        """Name, numbers and names of parts, gravity, in three lines."""
        groups = ("bodies", self.bodies), ("others", [part for part in self.parts if not isinstance(part, Body)])
        lines = [cut(f"  {noun}  {_names(parts)}") for noun, parts in groups if parts]
        return "\n".join([f"{self.label}: {_numbers(self)}", *lines])

    def _repr_html_(self) -> str:
        head, rows = ("part", "class", "connects", "mass [kg]", "values"), []
        for part in self.parts:
            mass = number_text(part.total_mass()) if isinstance(part, Body) else ""
            own = part.name, type(part).__name__, ", ".join(part.references()), mass
            rows.append((*own, values_text(_fields(part))))
        return display.page(self.label, _numbers(self), display.table(rows, head))

    def find(self, name: Part | str) -> Part:
        """The part of that name, or `ModelError` with the nearest name; a part stands for its name."""
        name = name_of(name)
        if isinstance(name, str) and (name == GROUND.name or name in self._by_name):
            return GROUND if name == GROUND.name else self._by_name[name]
        raise UnknownPartError(f"{self.label} has no part {name!r}. {checks.did_you_mean(name, self.names)}")

    def body(self, name: str, owner: str = "") -> Body:
        """The body of that name, or `ModelError`; `owner` names who asks, for messages."""
        part = self.find(name)
        if not isinstance(part, Body):
            raise ModelError(f"{owner or self.label}: {part.label} is not a body; give a body or GROUND.")
        return part

    def with_part(self, part: Part) -> Mechanism:
        """The mechanism with `part` in the place of the one of the same name, or added when there is none."""
        if not isinstance(part, Part):
            raise InputError(f"{self.label}: {part!r} is not a part.")
        if part.name in self._by_name:
            parts = {**self._by_name, part.name: part}
            self._follow_markers(parts)
            return replace(self, parts=tuple(parts.values()))
        return replace(self, parts=(*self.parts, part))

    def without_part(self, name: Part | str) -> Mechanism:
        """The mechanism without the part of that name."""
        gone = self.find(name)
        return replace(self, parts=tuple(p for p in self.parts if p is not gone))

    def with_loads(self, parts: Iterable[Part], gravity: tuple[float, float]) -> Mechanism:
        """The mechanism with its `parts`, whose loads have changed, not validated again, and `gravity` [m/s^2]."""
        other = object.__new__(Mechanism)
        other.__dict__.update(name=self.name, parts=tuple(parts), gravity=gravity)
        other._raise([*other._missing_parts()])
        return other

    def with_(self, changes: Mapping[str, Any]) -> Mechanism:
        """The mechanism with fields changed.

        Parameters
        ----------
        changes : new values by "part.field": {"P1.clearance": 2e-4, "P1.normal.restitution": 0.8, "gravity": (0, 0)}.

        Raises
        ------
        ModelError, InputError : no such part or field (with the nearest name), or a value the part refuses.
        """
        if not isinstance(changes, Mapping):
            text = f"{self.label}: changes are {changes!r}; they must be a dictionary such as"
            raise InputError(f"{text} {{'crank.mass': 0.5}}.")
        parts, nested = dict(self._by_name), []
        top: dict[str, Any] = {}
        own: dict[str, dict[str, Any]] = {}  # fields of one part are changed together
        for key, value in changes.items():
            if not isinstance(key, str):
                raise InputError(f"{self.label}: changes hold the key {key!r}; it must be a name such as 'crank.mass'.")
            name, _, path = key.partition(".")
            if not path:
                top[checks.one_of(self.label, "field", name, ["gravity", "name"])] = value
                continue
            if self.find(name) is GROUND:
                raise ModelError(f"{self.label}: {key!r} cannot be changed; the ground has no values of its own.")
            if "." in path:
                nested.append((name, path, value, f"{self.label}: {key!r}"))
            else:
                own.setdefault(name, {})[require_field(f"{self.label}: {key!r}", path, parts[name])] = value
        parts |= {name: replace(parts[name], **values) for name, values in own.items()}
        for name, path, value, label in nested:
            parts[name] = _with_field(parts[name], path, value, label)
        self._follow_markers(parts)
        self._refuse_points_left_behind(parts)
        return replace(self, parts=tuple(parts.values()), **top)

    def _follow_markers(self, parts: dict[str, Part]) -> None:
        """Move points of markers that have changed, in new parts by their names."""
        changed = {name: part for name, part in parts.items() if part is not self._by_name[name]}
        for name, part in parts.items():
            points = {f: changed.get(p.marker) for f, p in vars(part).items() if isinstance(p, checks.MarkedPoint)}
            moved: dict[str, Any] = {field: marker for field, marker in points.items() if marker is not None}
            parts[name] = replace(part, **moved) if moved else part

    def _refuse_points_left_behind(self, parts: Mapping[str, Part]) -> None:
        """Refuse new parts, by name, that move a point of a body away from joints and loads that stay there."""
        for name, part in parts.items():
            old = self._by_name[name]
            if part is old or not isinstance(part, Body):
                continue
            for point in points_of(old) - points_of(part):
                stay = [p.name for p in parts.values() if name in p.references() and point in points_of(p)]
                if stay:
                    listed = ", ".join(repr(other) for other in stay)
                    text = f"{self.label}: {old.label} moves its point ({point[0]:g}, {point[1]:g}), but {listed} would"
                    raise ModelError(f"{text} stay there. Change it in the same call, for example {stay[0] + '.at'!r}.")

    def nodes(self) -> tuple[tuple[str, Node], ...]:
        """All nodes as (part name, node), in order of declaration."""
        return tuple([(body.name, node) for body in self.bodies for node in body.nodes()])

    def contributions(self) -> Contributions:
        """Contributions of all parts to the equations of motion."""
        kinds: dict[type[Part], list[Part]] = {}
        for part in self.parts:
            kinds.setdefault(type(part), []).append(part)
        for kind, parts in kinds.items():
            kind.prepare(parts)
        found: list[Contribution] = []
        for part in self.parts:
            found.extend(part.contributions(self) if isinstance(part, Body) else self.contributions_of(part))
        return Contributions.sort(found)

    def contributions_of(self, part: Part) -> Sequence[Contribution]:
        """Contributions of a part that is no body; remembered for the next analysis."""
        found = self._known.get(part.name)
        if found is None:
            found = self._known[part.name] = tuple(part.contributions(self))
        return found

    @cached_property
    def _known(self) -> dict[str, Sequence[Contribution]]:
        return {}

    def shapes(self) -> Shapes:
        """Shapes of all parts, for drawings."""
        return tuple(shape for part in self.parts for shape in part.shapes(self))

    def plot(
        self, path: str | Path | None = None, *, lengths: bool = False, size: tuple[float, float] | None = None
    ) -> Figure:
        """Picture of the reference configuration, with the names of the joints.

        Parameters
        ----------
        path : file of the picture, whose ending gives the format; None: no file.
        lengths : whether the length of each straight link is written beside it [m].
        size : width and height [inch]; None: from the size of the mechanism.

        Raises
        ------
        InputError : a mechanism without bodies, a path that cannot be written.
        """
        from flexmb.show.pictures.scene import plot_mechanism  # noqa: PLC0415 - matplotlib when a picture is asked for

        return plot_mechanism(self, path, lengths=lengths, size=size)


# Names of fields that hold points of the reference configuration, of bodies and of other parts.
BODY_POINTS, OTHER_POINTS = ("at", "start", "end"), ("at", "to")


def points_of(part: Part) -> set[tuple[float, float]]:
    """Points of the reference configuration among the fields of a part."""
    names = BODY_POINTS if isinstance(part, Body) else OTHER_POINTS
    values = [value for name, value in vars(part).items() if name in names and isinstance(value, tuple)]
    return {value for value in values if len(value) == 2 and all(isinstance(x, float) for x in value)}


def require_field(label: str, name: str, owner: Any) -> str:
    """`name` if it is a field of a part, or of a record in it, that may be changed, else `InputError` with a hint."""
    known = [f.name for f in fields(owner) if f.init and f.name != "name"]
    name = arguments.present_name(type(owner), name)
    if isinstance(owner, Joint) and "clearance" not in known and get_close_matches(name, ["clearance"]):
        text = f"{label}: {owner.label} has no clearance. Give the mechanism a joint with clearance of the same name,"
        text += " e.g. RevoluteClearance(...); a ready mechanism has one where its own clearance is given"
        raise InputError(f"{text} (clearance=..., on the command line --clearance).")
    return checks.one_of(label, "field", name, known)


def _with_field(owner: Any, path: str, value: Any, label: str) -> Any:
    """`owner` with the field at a dotted path replaced."""
    name, _, rest = path.partition(".")
    name = require_field(label, name, owner)
    if not rest:
        return replace(owner, **{name: value})
    inner = getattr(owner, name)
    if not is_dataclass(inner):
        raise InputError(f"{label}: {name!r} has no fields of its own.")
    return replace(owner, **{name: _with_field(inner, rest, value, label)})
