"""Signals: names and units of the numbers that a run reports over time."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from flexmb import checks
from flexmb.errors import InputError
from flexmb.namespace import warn_of_former

# Former names of signals of bushings and markers, with the present ones; they go with version 0.3.
FORMER = {"rotation": "angle", "rotation_rate": "omega", "angle": "theta"}
MOST_COMPARED_NAMES = 2000  # number of names at most that are compared with an unknown one


@dataclass(frozen=True, slots=True)
class Signal:
    """One signal of a run."""

    name: str  # full name, "PART.SIGNAL" or "PART.NODE.SIGNAL"
    units: str = ""  # SI unit, e.g. "m/s2"; empty for a number without unit.


class Signals(Sequence[Signal]):
    """Names and SI units of many signals, and their places; equal to any sequence of the same signals."""

    def __init__(self, names: Iterable[str], units: Iterable[str]) -> None:
        self.names, self.units = tuple(names), tuple(units)

    @staticmethod
    def of(signals: Iterable[Signal]) -> Signals:
        """These signals."""
        if isinstance(signals, Signals):
            return signals
        known = tuple(signals)
        return Signals((s.name for s in known), (s.units for s in known))

    @cached_property
    def places(self) -> dict[str, int]:
        """Place of each name."""
        found = dict(zip(self.names, range(len(self.names)), strict=True))
        if len(found) != len(self.names):
            twice = next(name for name in self.names if self.names.count(name) > 1)
            raise InputError(f"Signals: {twice!r} appears more than once. Give every part its own name.")
        return found

    def chosen(self, places: Iterable[int]) -> Signals:
        """The signals at some places."""
        kept = list(places)
        return Signals((self.names[k] for k in kept), (self.units[k] for k in kept))

    def __len__(self) -> int:
        return len(self.names)

    def __getitem__(self, place: Any) -> Any:
        if isinstance(place, slice):
            return tuple(map(Signal, self.names[place], self.units[place]))
        return Signal(self.names[place], self.units[place])

    def __iter__(self) -> Iterator[Signal]:
        return map(Signal, self.names, self.units)

    def __eq__(self, other: object) -> bool:
        if isinstance(other, Signals):
            return self.names == other.names and self.units == other.units
        return isinstance(other, Sequence) and tuple(self) == tuple(other)

    def __hash__(self) -> int:
        return hash((self.names, self.units))

    def __repr__(self) -> str:
        return repr(tuple(self))

    def __reduce__(self) -> tuple[Any, ...]:
        return Signals, (self.names, self.units)


def resolved(name: str, signals: Signals, aliases: Mapping[str, str]) -> str:
    """`name` with its longest prefix that is an alias replaced; a signal's own name comes first."""
    if name in signals.places:
        return name
    prefix = name
    while "." in prefix:
        prefix = prefix.rpartition(".")[0]
        if prefix in aliases and not name.endswith("*"):
            return aliases[prefix] + name[len(prefix) :]
        if "." in prefix and prefix in aliases:  # "rod.end.*" is a node, "rod.*" all of the part
            return aliases[prefix] + name[len(prefix) :]
    owner, _, last = name.rpartition(".")
    now = f"{owner}.{FORMER.get(last)}"
    if now in signals.places:
        warn_of_former("Signals", name, now, "0.3")
        return now
    former = (f"{owner}.{k}" for k, v in FORMER.items() if v == last)
    return next((old for old in former if old in signals.places), name)


def hint(name: str, signals: Signals, aliases: Mapping[str, str]) -> str:
    """Hint on an unknown name: signals of its part, else similar ones of other parts, else all."""
    part, _, tail = name.partition(".")
    ends = {node: alias for alias, node in aliases.items()}
    stems = ((n, n.rpartition(".")) for n in signals.names)
    known = [f"{ends[stem]}.{axis}" if stem in ends else n for n, (stem, _, axis) in stems]
    own = [n for n in known if n.startswith(f"{part}.")]
    if own:
        return checks.did_you_mean(name, own[:MOST_COMPARED_NAMES], f"{part}.")
    near: Sequence[str] = [n for n in known if n.partition(".")[2] == tail] or known
    return checks.did_you_mean(name, near[:MOST_COMPARED_NAMES])
