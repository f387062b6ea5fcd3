"""Compiled mechanism: arrays, kernels and names, groups of connected bodies; can be pickled.

Lists of different lengths are stored one after the other: dof[k] : dof[k + 1] bounds the entries of element k.
Pairs (n, 2) hold BEGIN and END in the long lists p (numbers of the parts) and z (histories).
Coordinates are numbered 0 .. n_q - 1; n_q, n_q + 1, n_q + 2 are those of the ground, which stay 0.
Positions are indices into the value array of the factored matrix (see `flexmb.engine.linalg.symbolic`).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, lru_cache
from hashlib import blake2b
from heapq import merge
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from flexmb import display
from flexmb.display import counted
from flexmb.engine.compiled.digest import digest
from flexmb.engine.compiled.records import Integers, IntegerTable, Places, Record, Vector
from flexmb.engine.linalg.symbolic import Symbolic
from flexmb.kernels import Kernel, address_table
from flexmb.model.contributions import AXES, MotionInput
from flexmb.model.law import Motion, NormalLaw
from flexmb.model.shape import Shapes
from flexmb.model.signal import Signals
from flexmb.program.numbering import UNUSED

BEGIN, END = range(2)  # columns of pairs
FIRST, SECOND = range(2)  # columns of `Measured.angle`
MULTIPLIED, ADDED, SUBTRACTED = range(3)  # uses of a factor in a signal, as in `contributions.USES_OF_FACTOR`
LOAD_KERNEL, SLIDING_LAW = range(2)  # columns of `Constraints.joint_friction`: load's kernel, law of friction
FOUR_SIZE = 6  # coordinates of an element that is evaluated with the next three
FOUR_FORCES, FOUR_TANGENTS, FOUR_ACCOUNTS, FOUR_DAMPINGS = range(4)  # columns of `Elements.fours`
LOAD_P, LOAD_P_END, SLIDING_P, SLIDING_P_END = range(4)  # columns of `Constraints.joint_friction_p`
GAP_KERNEL, NORMAL_LAW, FRICTION_LAW = range(3)  # columns of `Contacts.kernel`
GAP_P, GAP_P_END, NORMAL_P, NORMAL_P_END, FRICTION_P, FRICTION_P_END = range(6)  # columns of `Contacts.p`
COMMON_Z, NORMAL_Z, FRICTION_Z, Z_END = range(4)  # columns of `Contacts.z`: starts of the three histories; end
PHASE, ONSET_TIME, LAST_GAP, LAST_FORCE, LAST_GAP_RATE = range(5)
CONTACT_COMMON = 5  # history of every contact: phase, time of its onset; gap, force, gap rate at the last state


class Elements(Record):
    """Elements: numbers of their kernels (-1: none), where p, z, dofs, positions (row by row) are."""

    # An element with force, tangent and account is never called through `kernel` and `energy`, which then are -1.
    kernel: Integers  # (n,)
    energy: Integers  # (n,)
    factor: Integers  # (n,) a motion
    force: Integers  # (n,)
    tangent: Integers  # (n,)
    account: Integers  # (n,)
    damping: Integers  # (n,)
    mass: Integers  # (n,) 1: a rigid mass at a node, else 0
    fours: IntegerTable  # (n, 4) force, tangent, account, damping of an element and the next three
    p: IntegerTable  # (n, 2)
    factor_p: IntegerTable  # (n, 2)
    z: IntegerTable  # (n, 2)
    dof: Integers  # (n + 1,)
    pos: Integers  # (n + 1,)
    dofs: Places
    positions: Places


class Constraints(Record):
    """Constraints: kernels, motions of their rows (-1: none), where numbers, rows, dofs and positions are, signals."""

    kernel: Integers  # (n,)
    known: Integers  # (n,) PIN (without friction and motions), ANGLE, GUIDE; 0: others
    turns: Places  # angles of the nodes of pins, guides and journals
    motion: Integers  # (n_c,) of each row
    p: IntegerTable  # (n, 2)
    motion_p: IntegerTable  # (n_c, 2)
    row: Integers  # (n + 1,)
    dof: Integers  # (n + 1,)
    pos_g: Integers  # (n + 1,)
    pos_h: Integers  # (n + 1,)
    dofs: Places
    positions_g: Places
    positions_gt: Places
    positions_h: Places  # of the entries of H that are not always zero
    entries_h: Places  # where these entries are in H, row by row
    second: IntegerTable  # (n, 3) places of x, y, theta of the second body among the dofs, -1: none
    moment: Integers  # (n,) row of the reported moment, -1: none
    out: Integers  # (n,) first of its signals
    forces: Integers  # (n,) how many signals its force has, before those of its motions; 0 for a drive
    joint_friction: IntegerTable  # (n, 2) LOAD_KERNEL and SLIDING_LAW, -1: no friction
    joint_friction_p: IntegerTable  # (n, 4) LOAD_P, LOAD_P_END, SLIDING_P, SLIDING_P_END
    joint_friction_z: IntegerTable  # (n, 2)
    joint_friction_arm: Integers  # (n,) where the arm is in p
    reaction: Integers  # (n + 1,) where its reported reactions are
    reaction_row: Integers  # row of each reaction
    reaction_dof: Integers  # coordinate whose velocity multiplies it, -1: none
    reaction_factor: Integers  # where the factor of each reaction is in p
    reaction_rate: Integers  # signal that multiplies it, -1: none
    reaction_on: Integers  # (reactions + 1,) where its places are; without places it is that of a row
    reaction_places: Integers  # places among the coordinates of its constraint
    reaction_power: Integers  # whether forces on places are multiplied by velocities


class Contacts(Record):
    """Contacts: numbers of gap, normal and friction kernel, where their numbers, histories and positions are."""

    kernel: IntegerTable  # (n, 3) GAP_KERNEL, NORMAL_LAW, FRICTION_LAW
    p: IntegerTable  # (n, 6) GAP_P, GAP_P_END, NORMAL_P, NORMAL_P_END, FRICTION_P, FRICTION_P_END
    z: IntegerTable  # (n, 4) COMMON_Z, NORMAL_Z, FRICTION_Z, Z_END
    dofs: Places  # (6 n,)
    positions: Places  # (36 n,)
    out: Integers  # (n,) first of its signals
    known: Integers  # (n,) JOURNAL; 0: others


class Measured(Record):
    """Signals computed by kernels, and relative rotations of joints with their rates."""

    kernel: Integers  # (n,) -1: the value has a place
    extremum: Integers  # (n,) kernel of a value with its place, -1: none
    p: IntegerTable  # (n, 2)
    dof: Integers  # (n + 1,)
    dofs: Integers
    gathers: Integers  # (n,) 0: its coordinates are those of the signal before
    element: Integers  # (n,) whose factor the value takes, -1: none
    use: Integers  # (n,) MULTIPLIED, ADDED or SUBTRACTED
    out: Integers  # (n,); a place follows its value
    modes: Integers  # signals that number states or places
    places: IntegerTable  # (k, 2) signals of places, and the signals at whose peaks they are wanted
    angle: IntegerTable  # (m, 2) rotations FIRST and SECOND
    angle_p: IntegerTable  # (m, 2)
    angle_out: Integers  # (m,) signal of the rotation, before that of its rate


# `Elements.factor` without a factor, and with the first output of a control as a factor; output k: FIRST_OUTPUT - k.
NO_FACTOR, FIRST_OUTPUT = -1, -2
# Columns of `Controls.source`: kind of the input; its coordinate, kernel or output; its numbers.
SOURCE, SOURCE_NUMBER, SOURCE_P, SOURCE_P_END = range(4)
COORDINATE, VELOCITY, MEASURED, MOTION_VALUE, MOTION_SPEED, OUTPUT = range(6)  # kinds of inputs of a control


class Controls(Record):
    """Controls: kernels, inputs, own states, outputs, and the coordinates that these depend on."""

    # The coordinates of a control are those of its states, in threes, then those of its inputs. A sampled control has
    # no coordinates; its history holds its states and its outputs.
    kernel: Integers  # (n,)
    p: IntegerTable  # (n, 2)
    z: IntegerTable  # (n, 2) empty for a control that acts at all times
    input: Integers  # (n + 1,)
    source: IntegerTable  # (inputs, 4) SOURCE, SOURCE_NUMBER, SOURCE_P, SOURCE_P_END
    source_dof: Integers  # (inputs + 1,)
    source_dofs: Integers
    source_places: Integers  # places of the coordinates of an input among those of its control, -1: fixed
    states: Integers  # (n,) number of states
    output: Integers  # (n + 1,)
    owner: Integers  # (outputs,) control of each output
    slope: Integers  # (outputs + 1,) where the derivatives of an output by the coordinates of its control are
    dof: Integers  # (n + 1,)
    dofs: Places
    pos_state: Integers  # (n + 1,)
    positions_state: Places  # rows of the states, columns of all coordinates of the control
    pos_load: Integers  # (outputs + 1,)
    positions_load: Places  # rows of the load, columns of all coordinates of the control
    out: Integers  # (n,) first of its signals


class Sizes(Record, frozen=True):
    """Numbers of coordinates, multipliers, histories, signals; first energy signal; longest lists of a piece."""

    n_q: int
    n_b: int  # number of the coordinates of bodies, before those of the states of controls
    n_c: int
    n_z: int
    n_y: int
    energy: int
    most_dofs: int
    most_rows: int
    has_joint_friction: bool  # whether an ideal joint has friction


class Tables(Record):
    """All arrays of a program."""

    sizes: Sizes
    p: Vector
    elements: Elements
    constraints: Constraints
    contacts: Contacts
    measured: Measured
    controls: Controls
    kind: Integers  # (n_q,) 0 for a length, 1 for an angle


class Addresses(Record):
    """Tables of kernel addresses, made in every process."""

    element: Integers
    energy: Integers
    constraint: Integers
    motion: Integers
    gap: Integers
    normal: Integers
    friction: Integers
    joint_friction: Integers
    signal: Integers
    extremum: Integers
    force: Integers
    tangent: Integers
    account: Integers
    damping: Integers
    control: Integers


KINDS = tuple(Addresses._fields)  # kinds of kernels


@dataclass(frozen=True)
class Sampler:
    """Control that acts at instants k sample, as a run needs it between its steps."""

    name: str
    kernel: Kernel
    p: tuple[float, ...]
    inputs: tuple[int | MotionInput, ...]  # places of the inputs among the signals, or motions
    sample: float  # time between two instants [s]
    states: int
    outputs: int
    z: int  # place of its history, states before outputs
    settled: tuple[int, ...] = ()  # numbers of the states that begin where their rates are 0

    @cached_property
    def numbers(self) -> tuple[np.ndarray, ...]:
        """Numbers of the law, and of each motion among the inputs."""
        inputs = (one.motion.parameters() if isinstance(one, MotionInput) else () for one in self.inputs)
        return tuple(np.array(own, dtype=float) for own in (self.p, *inputs))

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
    """A compiled mechanism: read-only arrays, kernels, names, the pattern of its matrix."""

    # Made by `flexmb.compile`; it can be pickled and sent to other processes.
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
    least_clearance: float | None  # of all contacts [m]; infinite where none has one
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
        return display.page(head, sizes, display.folded("coordinates", display.texts(self.names.coordinates)))

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
        """Digests (3, 8) of names and kernels, all numbers, wiring: restarts fit programs of equal fingerprints."""
        # Wiring is what acts on what, and when: all places in the tables, but for those in the matrix, and the sampled
        # controls. Kernels of users count by their source, too, and in the wiring by all values that they name.
        kernels = [k for group in self.kernels for k in group]
        words = (*self.names.coordinates, *self.names.rows, *self.names.contacts, *(k.identity for k in kernels))
        arrays = self.tables.p, self.reference.q, self.reference.z
        numbers = b"".join(np.ascontiguousarray(a).tobytes() for a in arrays)
        wiring = None if self.samplers else _WIRINGS.get(self.symbolic)
        if wiring is None:
            records = {name: own.as_dict() for name, own in self.tables.as_dict().items() if isinstance(own, Record)}
            places = {name: {k: v for k, v in own.items() if not k.startswith("pos")} for name, own in records.items()}
            wiring = _WIRINGS[self.symbolic] = digest((places, self.samplers, [k.content for k in kernels])).encode()
        digests = [blake2b(data, digest_size=8).digest() for data in ("\n".join(words).encode(), numbers, wiring)]
        return np.frombuffer(b"".join(digests), dtype=np.uint8).reshape(3, 8)

    @cached_property
    def sampled(self) -> np.ndarray:
        """Numbers of the sampled controls, one behind the other."""
        return np.concatenate([np.zeros(0), *(x for sampler in self.samplers for x in sampler.numbers)])

    def beyond_numbers(self, other: Program, t_end: float) -> str:
        """Change beyond moved numbers of parts to another program, until t_end [s], with a remedy; "" for none."""
        mine, its = (
            (one.names.coordinates, one.kernels, len(one.tables.p), [s.sample for s in one.samplers], one.breaks(t_end))
            for one in (self, other)
        )
        same = self.symbolic is other.symbolic or digest(self.tables) == digest(other.tables.replaced(p=self.tables.p))
        if mine[:3] != its[:3] or not same:
            text = "changes the structure of the equations, so there is no derivative by it."
            return f"{text} Compare runs with both values."
        text = "moves instants of kinks and jumps of drives and loads, or of a controller;"
        return "" if mine == its else f"{text} no derivative is known there. Vary it by a sweep."

    @property
    def n_q(self) -> int:
        """Number of coordinates."""
        return self.tables.sizes.n_q

    @property
    def n_c(self) -> int:
        """Number of constraint rows."""
        return self.tables.sizes.n_c

    @cached_property
    def shortest(self) -> float:
        """Least distance of neighbouring nodes of a deformable body, as drawn, or the size of the mechanism [m]."""
        E, n_b, q = self.tables.elements, self.tables.sizes.n_b, self.reference.q
        # part, node, axis; [] of rigid bodies
        owners = [name.split(".")[:-2] for name in self.names.coordinates[:n_b:3]]
        begin = E.dof[:-1][np.diff(E.dof) >= 6]
        first, second = E.dofs[begin].astype(int), E.dofs[begin + 3].astype(int)
        both = (first < n_b) & (second < n_b) & (first % 3 == 0) & (second % 3 == 0)
        pairs = zip(first[both].tolist(), second[both].tolist(), strict=True)
        within = [(i, k) for i, k in pairs if owners[i // 3] and owners[i // 3] == owners[k // 3]]
        first, second = np.array(within, dtype=int).reshape(-1, 2).T
        away = np.hypot(q[first] - q[second], q[first + 1] - q[second + 1])
        return float(away[away > 0.0].min(initial=self.length))

    @cached_property
    def sizes(self) -> np.ndarray:
        """Movements (n_q,) beside which others are judged: the size of the mechanism [m], and 1 rad of angles."""
        return np.where(np.asarray(self.tables.kind) == 1, 1.0, self.length)

    def closed_contacts(self, z: np.ndarray) -> np.ndarray:
        """Whether contacts are closed and joints that remember strained, (..., contacts + joints), of z (..., n_z)."""
        begin, end = self.tables.constraints.joint_friction_z.T
        return np.asarray(z[..., [*self.tables.contacts.z[:, COMMON_Z], *begin[end > begin]]] != 0.0)

    def coordinate(self, name: str) -> int:
        """Number of the coordinate called `name`, e.g. "rod.node3.x"; aliases are followed."""
        return self.names.coordinates.index(resolve(name, self.names.aliases))

    def __getstate__(self) -> dict[str, Any]:
        return {k: v for k, v in self.__dict__.items() if k != "addresses"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        freeze(self.tables)
        self.__post_init__()


# Digests of the wiring by the pattern, which programs of one structure share; those of sampled controls are not kept.
_WIRINGS: WeakKeyDictionary[Symbolic, bytes] = WeakKeyDictionary()


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


# Groups of bodies that are connected by joints, contacts or elements; the ground connects nothing
def body_groups(program: Program) -> np.ndarray:
    """Number of the group of each coordinate, (n_q + 3,); -1: the ground.  Each state of a control is of group 0."""
    # The motion of one group does not depend on that of another, unless a control reads it.
    T, n_b, label = program.tables, program.tables.sizes.n_b, np.arange((program.n_q + 3) // 3)
    pieces = [(T.elements.dof, T.elements.dofs), (T.constraints.dof, T.constraints.dofs)]
    pieces.append((np.arange(0, len(T.contacts.dofs) + 1, 6), T.contacts.dofs))
    ends = []  # nodes that follow one another in the coordinates of a piece, without ground and states of controls
    for begin, dofs in pieces:
        piece = np.repeat(np.arange(len(begin) - 1), np.diff(begin))[dofs < n_b]
        nodes, same = dofs[dofs < n_b].astype(np.int64) // 3, piece[1:] == piece[:-1]
        ends.append(np.stack([nodes[:-1][same], nodes[1:][same]]))
    first, second = np.concatenate(ends, axis=1)
    while (label[first] != label[second]).any():
        least = np.minimum(label[first], label[second])
        for end in (first, second):
            np.minimum.at(label, label[end], least)
        label = label[label]
    groups = np.zeros(len(label), dtype=np.int64)
    groups[: n_b // 3], groups[-1] = np.unique(label[: n_b // 3], return_inverse=True)[1], -1
    return np.repeat(groups, 3)
