"""Compiled mechanism: arrays, kernels and names; can be pickled."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, lru_cache
from hashlib import blake2b
from heapq import merge
from typing import Any

import numpy as np

from flexmb.compiled.digest import digest
from flexmb.compiled.records import Record
from flexmb.display import html
from flexmb.display.text import counted
from flexmb.kernels import Kernel, address_table
from flexmb.linalg.symbolic import Symbolic
from flexmb.model.contributions import AXES, MotionInput
from flexmb.model.law import Motion, NormalLaw
from flexmb.model.shape import Shapes
from flexmb.model.signal import Signals
from flexmb.program.numbering import UNUSED
from flexmb.program.tables import Addresses, Tables


@dataclass(frozen=True)
class Sampler:
    """Control that acts at instants k sample, as a run needs it between its steps.

    Parameters
    ----------
    name : name of the controller.
    kernel, p : control law and its numbers.
    inputs : places of the inputs among the signals, or motions.
    sample : time between two instants [s].
    states, outputs : numbers of states and outputs.
    z : place of its history, states before outputs.
    settled : numbers of the states that begin where their rates are 0.
    """

    name: str
    kernel: Kernel
    p: tuple[float, ...]
    inputs: tuple[int | MotionInput, ...]
    sample: float
    states: int
    outputs: int
    z: int
    settled: tuple[int, ...] = ()

    def instants(self, t: float, t_end: float) -> Iterator[float]:
        """Instants in (t, t_end] [s]."""
        k = max(math.floor(t / self.sample) - 1, 0)
        while k * self.sample <= t_end:
            if k * self.sample > t:
                yield k * self.sample
            k += 1

    def acts_at(self, t: float) -> bool:
        """Whether t is one of its instants."""
        return round(t / self.sample) * self.sample == t


@dataclass(frozen=True)
class ReferenceConfiguration:
    """Reference configuration: coordinates with start displacements, declared velocities, histories, bodies."""

    q: np.ndarray  # (n_q,) [m, rad]
    v: np.ndarray  # (n_q,) [m/s, rad/s]
    z: np.ndarray  # (n_z,)
    body: np.ndarray  # (n_q,) number of the body of each coordinate
    turns: np.ndarray  # (n_q / 3,) 1 for nodes whose theta follows a rigid rotation of their body, else 0


@dataclass(frozen=True)
class Names:
    """Names of the parts of elements, of coordinates, constraint rows, contacts, bodies and signals."""

    elements: tuple[str, ...]
    coordinates: tuple[str, ...]
    rows: tuple[str, ...]
    contacts: tuple[str, ...]
    bodies: tuple[str, ...]
    signals: Signals
    aliases: dict[str, str]


@dataclass(frozen=True, eq=False)
class Program:
    """A compiled mechanism: read-only arrays, kernels, names, the pattern of its matrix.

    Made by `flexmb.compile`; it can be pickled and sent to other processes.
    """

    name: str
    tables: Tables
    kernels: tuple[tuple[Kernel, ...], ...]  # by contract, in the order of `Addresses`
    symbolic: Symbolic
    reference: ReferenceConfiguration
    names: Names
    shapes: Shapes
    periods: tuple[float | None, ...]  # of the drives
    drives: tuple[str, ...]  # of driven rows, in the order of the rows: part, or part.coordinate
    length: float  # size of the drawn mechanism [m]
    least_clearance: float | None
    motions: tuple[Motion, ...]  # of drives and loads
    normals: tuple[NormalLaw, ...] = ()  # of the contacts
    samplers: tuple[Sampler, ...] = ()  # controls that act at instants
    controls: tuple[str, ...] = ()  # names of the controls, in the order of the tables
    settled: tuple[int, ...] = ()  # coordinates of the states that begin where their rates are 0

    def __post_init__(self) -> None:
        reference = self.reference
        freeze((self.tables.p, reference.q, reference.v, reference.z, reference.body, reference.turns))

    def __repr__(self) -> str:
        bodies, contacts = counted(len(self.names.bodies), "body"), counted(len(self.names.contacts), "contact")
        sizes = f"{counted(self.n_q, 'coordinate')}, {counted(self.n_c, 'constraint row')}"
        signals = counted(len(self.names.signals), "signal")
        return f"Program of {self.name!r}: {bodies}, {sizes}, {contacts}, {signals}"

    def _repr_html_(self) -> str:
        head, _, sizes = repr(self).partition(": ")
        return html.page(head, sizes, html.folded("coordinates", html.texts(self.names.coordinates)))

    @cached_property
    def shown(self) -> np.ndarray | None:
        """Places of the signals that a run saves by default: not the integrals and rates of states; None: all."""
        n, n_b = self.n_q, self.tables.sizes.n_b
        states = self.names.coordinates[n_b:]
        hidden = {place for k in range(n_b, n) for place in (k, 2 * n + k)}
        hidden |= {n + n_b + k for k, name in enumerate(states) if name.rpartition(".")[2] in UNUSED}
        every = range(len(self.names.signals))
        return np.array([k for k in every if k not in hidden], dtype=np.int64) if hidden else None

    @cached_property
    def reported(self) -> Signals:
        """The signals that a run saves by default."""
        return self.names.signals if self.shown is None else self.names.signals.chosen(self.shown)

    def breaks(self, t_end: float) -> tuple[float, ...]:
        """Instants in (0, t_end] where a drive or a load jumps or has a kink, in order [s]."""
        found = {float(t) for motion in self.motions for t in motion.breaks(t_end)}
        return tuple(sorted(t for t in found if 0.0 < t <= t_end))

    def instants(self, t: float, t_end: float) -> Iterator[float]:
        """Instants in (t, t_end] at which a run restarts: jumps of drives and loads, and samples, in order [s]."""
        last = t
        for instant in merge((b for b in self.breaks(t_end) if b > t), *(s.instants(t, t_end) for s in self.samplers)):
            if instant > last:
                last = instant
                yield instant

    @cached_property
    def addresses(self) -> Addresses:
        """Addresses of the kernels in this process."""
        return _addresses(self.kernels)

    @cached_property
    def fingerprint(self) -> np.ndarray:
        """Digests (3, 8) of names and kernels, of all numbers, of wiring: restarts fit programs of equal fingerprints.

        Wiring is what acts on what, and when: all places in the tables, but for those in the matrix, and the sampled
        controls.  Kernels of users count by their source, too, and in the wiring by all values that they name.
        """
        kernels = [k for group in self.kernels for k in group]
        words = (*self.names.coordinates, *self.names.rows, *self.names.contacts, *(k.identity for k in kernels))
        numbers = b"".join(
            np.ascontiguousarray(a).tobytes() for a in (self.tables.p, self.reference.q, self.reference.z)
        )
        places = {
            name: {k: v for k, v in table.as_dict().items() if not k.startswith("pos")}
            for name, table in self.tables.as_dict().items()
            if isinstance(table, Record)
        }
        wiring = digest((places, self.samplers, [k.content for k in kernels])).encode()
        digests = [blake2b(data, digest_size=8).digest() for data in ("\n".join(words).encode(), numbers, wiring)]
        return np.frombuffer(b"".join(digests), dtype=np.uint8).reshape(3, 8)

    @property
    def n_q(self) -> int:
        """Number of coordinates."""
        return self.tables.sizes.n_q

    @property
    def n_c(self) -> int:
        """Number of constraint rows."""
        return self.tables.sizes.n_c

    def coordinate(self, name: str) -> int:
        """Number of the coordinate called `name`, e.g. "rod.node3.x"; aliases are followed."""
        return self.names.coordinates.index(resolve(name, self.names.aliases))

    def __getstate__(self) -> dict[str, Any]:
        return {k: v for k, v in self.__dict__.items() if k != "addresses"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        freeze(self.tables)
        self.__post_init__()


@lru_cache(maxsize=64)
def _addresses(kernels: tuple[tuple[Kernel, ...], ...]) -> Addresses:
    """Addresses of kernels in this process."""
    return Addresses(*(address_table(group) for group in kernels))


def resolve(name: str, aliases: dict[str, str]) -> str:
    """The name of a coordinate with the longest matching alias replaced."""
    prefix, _, axis = str(name).rpartition(".")
    return f"{aliases.get(prefix, prefix)}.{axis}" if axis in AXES else name


def freeze(value: Any) -> None:
    """Make every array in nested tuples and records read-only."""
    if isinstance(value, np.ndarray):
        value.flags.writeable = False
    elif isinstance(value, tuple):
        for item in value:
            freeze(item)
    elif isinstance(value, Record):
        freeze(tuple(value.as_dict().values()))
