"""Structure of a program: packed tables, independent of all numbers, shared by mechanisms that differ in numbers alone.

Integer arrays, elimination order and pattern of the factors depend on kernels and coordinates, not on lengths and mass.
The latest structures are remembered, so that a sweep computes them once.  Their key contains everything that they
depend on, and they are read-only.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass
from functools import cache
from itertools import chain
from operator import attrgetter
from typing import Any

import numpy as np
from numba.core import config

from flexmb import checks
from flexmb.engine.compiled.code_cache import ours
from flexmb.engine.compiled.lanes import LANES
from flexmb.engine.linalg.ordering import elimination_order
from flexmb.engine.linalg.symbolic import Symbolic, symbolic
from flexmb.errors import KernelError
from flexmb.kernels import Kernel
from flexmb.model import contributions as model
from flexmb.model.contributions import ConstraintContribution, Contributions, ElementContribution, Reaction
from flexmb.model.law import Law, Motion
from flexmb.model.part import is_kind
from flexmb.places import GUIDE, PIN
from flexmb.program import program as at
from flexmb.program.numbering import Lists, Numbering, blocks_and_edges, force_signals, layout, state_coordinates
from flexmb.program.program import Constraints, Contacts, Controls, Elements, Measured, Names, Sizes, Tables, freeze

NumberLists = dict[str, list[Sequence[float]]]  # lists of numbers by what they belong to, one behind the other
Listed = tuple[NumberLists, NumberLists]  # numbers p and histories z


def numbers(contributions: Contributions) -> Listed:
    """Numbers p and start histories z of all parts, in the one order of the tables, of structures, and of p and z."""
    elements, constraints, contacts = contributions.elements, contributions.constraints, contributions.contacts
    rubbing, controls = [c.joint_friction for c in constraints], contributions.controls
    wired = [(c.p, *(one.motion.parameters() if one.motion else one.p for one in c.sources)) for c in controls]
    p: NumberLists = {
        "element": [e.p for e in elements],
        "factor": [e.factor.parameters() if e.factor else () for e in elements],
        "constraint": [c.p for c in constraints],
        "motion": [m.parameters() if m else () for c in constraints for m in motion_of_each_row(c)],
        "joint friction": [own for one in rubbing for own in ((one.p, one.friction.parameters()) if one else ((), ()))],
        "arm": [(one.arm,) if one else (1.0,) for one in rubbing],
        "reaction": [(reaction.factor,) for c in constraints for reaction in c.reactions],
        "contact": [own for c in contacts for own in (c.p, c.normal.parameters(), c.friction.parameters())],
        "signal": [signal.p for signal in contributions.signals],
        "angle": [angle.p for angle in contributions.angles],
        "control": [*chain.from_iterable(wired)],
    }
    z: NumberLists = {
        "element": [e.history for e in elements],
        "joint friction": [one.friction.history() if one else () for one in rubbing],
        "contact": [
            own for c in contacts for own in ((0.0,) * at.CONTACT_COMMON, c.normal.history(), c.friction.history())
        ],
        "control": [control.history for control in controls],
    }
    return p, z


def flat(listed: Listed) -> tuple[np.ndarray, np.ndarray]:
    """The arrays of all `numbers`."""
    p, z = (np.array([*chain.from_iterable(chain.from_iterable(lists.values()))], dtype=float) for lists in listed)
    return p, z


def motion_of_each_row(contribution: ConstraintContribution) -> list[Motion | None]:
    """The motions of a constraint, None for rows without."""
    given = {driven.row: driven.motion for driven in contribution.motions}
    return [given.get(row) for row in range(contribution.rows)]


def bounds_of(lists: NumberLists) -> dict[str, np.ndarray]:
    """Bounds of each list in the array of all numbers, (n, 2)."""
    found, last = {}, 0
    for name, group in lists.items():
        ends = last + ends_of(map(len, group))
        found[name], last = np.stack([ends[:-1], ends[1:]], axis=1), int(ends[-1])
    return found


def ends_of(lengths: Iterable[int]) -> np.ndarray:
    """0, and where each of several lists ends that lie one behind the other."""
    return np.cumsum([0, *lengths]).astype(np.int64)


# Packing: tables of numbered kernels, coordinates and places in the factored matrix
@dataclass(frozen=True, eq=False)
class Blocks:
    """Dense blocks of the matrix, row by row: where each begins, row and column numbers of all entries."""

    ptr: np.ndarray
    rows: np.ndarray
    columns: np.ndarray

    @staticmethod
    def of(rows: Lists, columns: Lists) -> Blocks:
        """One block for each two lists of unknowns."""
        width = np.diff(columns.ptr)
        size = np.diff(rows.ptr) * width
        ptr = np.concatenate([[0], np.cumsum(size)]).astype(np.int64)
        block = np.repeat(np.arange(len(size)), size)
        within = np.arange(ptr[-1]) - ptr[block]
        row = within // width[block]
        column = within - row * width[block]
        return Blocks(ptr, rows.values[rows.ptr[block] + row], columns.values[columns.ptr[block] + column])

    def without(self, zeros: np.ndarray) -> Blocks:
        """These blocks with entries that are always zero (True in `zeros`) outside the matrix."""
        return Blocks(self.ptr, np.where(zeros, -1, self.rows), np.where(zeros, -1, self.columns))


def zeros_of_elements(elements: Sequence[ElementContribution]) -> np.ndarray:
    """Whether each entry of the blocks of elements is always zero."""
    found = [np.zeros(0, dtype=bool)]
    for e in elements:
        n = len(e.coordinates)
        found.append(_zeros(n, n, tuple((k, k) for k in range(n)) if e.diagonal else None))
    return np.concatenate(found)


def zeros_of_constraints(constraints: Sequence[ConstraintContribution]) -> tuple[np.ndarray, np.ndarray]:
    """Whether each entry of G, and of H, of constraints is always zero; friction in a joint fills its blocks."""
    in_g, in_h = [np.zeros(0, dtype=bool)], [np.zeros(0, dtype=bool)]
    for c in constraints:
        n, rubs = len(c.coordinates), c.joint_friction is not None
        in_g.append(_zeros(c.rows, n, None if rubs or c.columns is None else _entries(c.columns)))
        in_h.append(_zeros(n, n, None if rubs else c.curved))
    return np.concatenate(in_g), np.concatenate(in_h)


@cache
def _entries(columns: tuple[tuple[int, ...], ...]) -> tuple[tuple[int, int], ...]:
    """Rows and columns of a list of columns for each row."""
    return tuple((row, column) for row, own in enumerate(columns) for column in own)


@cache
def _zeros(rows: int, columns: int, entries: tuple[tuple[int, int], ...] | None) -> np.ndarray:
    """Whether an entry of a block is not among `entries`, row by row; None: all are."""
    found = np.full((rows, columns), entries is not None)
    for row, column in entries or ():
        found[row, column] = False
    return found.ravel()


def ints(values: Sequence[int] | np.ndarray) -> np.ndarray:
    """A 1-D int64 array."""
    return np.array(values, dtype=np.int64).reshape(-1)


def places(values: Sequence[int] | np.ndarray) -> np.ndarray:
    """A 1-D uint64 array of indices: the compiled loop need not ask whether they count from the end."""
    return np.array(values, dtype=np.uint64).reshape(-1)


def table(rows: Sequence[Sequence[int]] | np.ndarray, columns: int) -> np.ndarray:
    """A 2-D int64 array, also without rows."""
    return np.array(rows, dtype=np.int64).reshape(-1, columns)


class Packer:
    """Numbers of kernels and matrix blocks of all pieces, in the order of declaration."""

    def __init__(self, contributions: Contributions, number: Numbering, listed: Listed) -> None:
        self.contributions, self.number = contributions, number
        self.p, self.z = map(bounds_of, listed)
        self.kernels: dict[str, dict[int, tuple[int, Kernel]]] = {name: {} for name in at.KINDS}
        groups = (contributions.elements, contributions.contacts, contributions.constraints)
        self.element_dofs, self.contact_dofs, self.constraint_dofs = (number.lists(group) for group in groups)
        self.element_blocks, self.contact_blocks = (self.square(d) for d in (self.element_dofs, self.contact_dofs))
        self.element_blocks = self.element_blocks.without(zeros_of_elements(contributions.elements))
        self.row = ends_of(contribution.rows for contribution in contributions.constraints)
        self.n_c = int(self.row[-1])
        rows = Lists(self.row, number.n_q + np.arange(self.n_c))
        in_g, in_h = zeros_of_constraints(contributions.constraints)
        self.g_blocks = Blocks.of(rows, self.unknowns(self.constraint_dofs)).without(in_g)
        whole, kept = self.square(self.constraint_dofs), np.flatnonzero(~in_h)
        ends = np.searchsorted(kept, whole.ptr)
        self.h_blocks = Blocks(ends, whole.rows[kept], whole.columns[kept])
        self.h_entries = kept - np.repeat(whole.ptr[:-1], np.diff(ends))
        self.control_dofs = number.lists(contributions.controls)
        states = Lists.of([number.dofs(state_coordinates(control)) for control in contributions.controls])
        self.state_blocks = Blocks.of(states, self.control_dofs)
        outputs = [(k, load) for k, c in enumerate(contributions.controls) for load in c.load_coordinates]
        self.owner = ints([k for k, _ in outputs])
        loads = Lists.of([number.dofs(load) for _, load in outputs])
        lists = [self.control_dofs.values[self.control_dofs.ptr[k] : self.control_dofs.ptr[k + 1]] for k in self.owner]
        self.load_blocks = Blocks.of(loads, Lists.of([values.tolist() for values in lists]))
        self.journals = ints([c.known if ours(c.gap.function) else 0 for c in contributions.contacts])
        self.outputs = ends_of(len(control.outputs) for control in contributions.controls)
        order = elimination_order(*blocks_and_edges(contributions, number))
        self.symbolic = symbolic(number.n_q + self.n_c, *self.pattern(), order)
        self.names = number.names()
        self.layout = layout(contributions, self.names, number.n_b)

    def unknowns(self, dofs: Lists) -> Lists:
        """Numbers of coordinates, -1 for the ground."""
        return Lists(dofs.ptr, np.where(dofs.values < self.number.n_q, dofs.values, -1))

    def square(self, dofs: Lists) -> Blocks:
        """Blocks on the coordinates of each piece."""
        unknowns = self.unknowns(dofs)
        return Blocks.of(unknowns, unknowns)

    def pattern(self) -> tuple[np.ndarray, np.ndarray]:
        """Rows and columns of all structural nonzeros, the ground excluded."""
        groups = [self.element_blocks, self.contact_blocks, self.g_blocks, self.h_blocks]
        groups += [self.state_blocks, self.load_blocks]
        rows = np.concatenate([g.rows for g in groups])
        columns = np.concatenate([g.columns for g in groups])
        inside = (rows >= 0) & (columns >= 0)
        return rows[inside], columns[inside]

    def positions(self, blocks: Blocks, *, transposed: bool = False) -> np.ndarray:
        """Places of the entries of blocks in the factored matrix."""
        both = (blocks.columns, blocks.rows) if transposed else (blocks.rows, blocks.columns)
        return places(self.symbolic.positions(*both))

    def numbered(self, kind: str, kernels: Iterable[Kernel | None]) -> np.ndarray:
        """Numbers of the kernels of a kind, -1 for None."""
        known = self.kernels[kind]
        return ints([-1 if k is None else known.setdefault(id(k), (len(known), k))[0] for k in kernels])

    def elements(self) -> Elements:
        """Arrays of the elements."""
        found, factors = self.contributions.elements, self.factors()
        # What is never called is not compiled.  Kernels of users are, whatever `is_mass` or `known` they inherit.
        element = self.numbered("element", [None if e.is_complete else e.kernel for e in found])
        energy = self.numbered("energy", [e.energy for e in found])
        own = [e.is_mass and not e.factor and all(k and ours(k.function) for k in (e.kernel, e.energy)) for e in found]
        ways, masses = ("force", "tangent", "account", "damping"), ints(own)
        return Elements(
            element, energy, factors, *(self.numbered(way, [getattr(e, way) for e in found]) for way in ways),
            masses, self.fours(factors), self.p["element"], self.p["factor"], self.z["element"], self.element_dofs.ptr,
            self.element_blocks.ptr, places(self.element_dofs.values), self.positions(self.element_blocks),
        )  # fmt: skip

    def fours(self, factors: np.ndarray) -> np.ndarray:
        """Kernels (n, 4) of elements that are evaluated with the next three, -1 for all others."""
        kinds = "force", "tangent", "account", "damping"
        own = [e.fours if len(e.coordinates) == at.FOUR_SIZE else () for e in self.contributions.elements]
        table = np.full((len(own), len(kinds)), -1)
        if not any(own) or config.DISABLE_JIT:
            return table
        heads: dict[int, list[int]] = {}
        e, sizes, plain = 0, (self.p["element"] @ (-1, 1)).tolist(), (factors == at.NO_FACTOR).tolist()
        while e + LANES <= len(own):
            several = slice(e, e + LANES)
            alike = own[several] == [own[e]] * LANES and sizes[several] == [sizes[e]] * LANES
            if own[e] and alike and all(plain[several]):
                heads.setdefault(id(own[e]), []).append(e)
                e += LANES
            else:
                e += 1
        for places in heads.values():
            pairs = zip(kinds, own[places[0]], strict=True)
            table[places] = np.concatenate([self.numbered(kind, [kernel]) for kind, kernel in pairs])
        return table

    def constraints(self) -> Constraints:
        """Arrays of the constraints."""
        found, dofs = self.contributions.constraints, self.constraint_dofs
        # The loops know pins without motions, whose entries of H are those of the angles; friction fills the block.
        plain = [not c.motions and k == 2 for c, k in zip(found, np.diff(self.h_blocks.ptr), strict=True)]
        own = zip(found, plain, strict=True)
        known = ints([c.known if ours(c.kernel.function) and (c.known != PIN or pin) else 0 for c, pin in own])
        turned = dofs.values[np.isin(np.repeat(known, np.diff(dofs.ptr)), (PIN, GUIDE))]
        motions = [motion for contribution in found for motion in motion_of_each_row(contribution)]
        rubbing = [contribution.joint_friction for contribution in found]
        load = self.numbered("joint_friction", [one.kernel if one else None for one in rubbing])
        law = self.numbered("friction", [one.friction.kernel if one else None for one in rubbing])
        return Constraints(
            self.numbered("constraint", [contribution.kernel for contribution in found]),
            known, places(np.unique([*turned[2::3], *self.contact_dofs.values[np.repeat(self.journals, 6) > 0][2::3]])),
            self.numbered("motion", [motion.kernel if motion else None for motion in motions]),
            self.p["constraint"], self.p["motion"], self.row, dofs.ptr, self.g_blocks.ptr,
            self.h_blocks.ptr, places(dofs.values), self.positions(self.g_blocks),
            self.positions(self.g_blocks, transposed=True), self.positions(self.h_blocks), places(self.h_entries),
            table([[c.coordinates.index(one) for one in c.second] if c.second else [-1] * 3 for c in found], 3),
            ints([contribution.moment_row for contribution in found]), ints(self.layout.constraints),
            ints([len(force_signals(contribution)) for contribution in found]), np.column_stack([load, law]),
            self.p["joint friction"].reshape(-1, 4), self.z["joint friction"], ints(self.p["arm"][:, at.BEGIN]),
            *self.reactions(),
        )  # fmt: skip

    def factors(self) -> np.ndarray:
        """Factor of each element: number of a motion, NO_FACTOR, or FIRST_OUTPUT less the number of an output."""
        elements = self.contributions.elements
        found = self.numbered("motion", [e.factor.kernel if e.factor else None for e in elements])
        first = [at.FIRST_OUTPUT - int(self.outputs[c]) for c in range(len(self.contributions.controls))]
        loads = [control.loads for control in self.contributions.controls]
        controlled = {load: begin - k for begin, own in zip(first, loads, strict=True) for k, load in enumerate(own)}
        for e, element in enumerate(elements if controlled else ()):
            found[e] = controlled.get(element.part, found[e])
        return found

    def reactions(self) -> tuple[np.ndarray, ...]:
        """Bounds, rows, coordinates, factors and rates of reported reactions; bounds, places and powers of forces."""
        constraints = self.contributions.constraints
        signals = zip(self.contributions.signals, self.layout.measured, strict=True)
        rates = {(signal.part, signal.name): place for signal, place in signals}
        found = [(c, piece, reaction) for c, piece in enumerate(constraints) for reaction in piece.reactions]
        velocities = [[piece.coordinates[r.place]] if r.place >= 0 else [] for _, piece, r in found]
        return (
            ends_of(len(piece.reactions) for piece in constraints),
            ints([self.row[c] + r.row for c, _, r in found]),
            ints([self.number.dofs(own)[0] if own else -1 for own in velocities]),
            ints(self.p["reaction"][:, at.BEGIN]),
            ints([rate_of(piece, r, rates) for _, piece, r in found]),
            ends_of(len(r.on) for *_, r in found),
            ints([k for *_, r in found for k in r.on]),
            ints([r.power for *_, r in found]),
        )

    def contacts(self) -> Contacts:
        """Arrays of the contacts."""
        found = self.contributions.contacts
        gaps = self.numbered("gap", [one.gap for one in found])
        normals = self.numbered("normal", [one.normal.kernel for one in found])
        kernels = (gaps, normals, self.numbered("friction", [one.friction.kernel for one in found]))
        z = np.ascontiguousarray(self.z["contact"].reshape(-1, 6)[:, [0, 2, 4, 5]])
        dofs, positions = places(self.contact_dofs.values), self.positions(self.contact_blocks)
        p, out = self.p["contact"].reshape(-1, 6), ints(self.layout.contacts)
        return Contacts(np.column_stack(kernels), p, z, dofs, positions, out, self.journals)

    def controls(self) -> Controls:
        """Arrays of the controls, and of the sources of their inputs."""
        controls, dofs = self.contributions.controls, self.control_dofs
        inputs = ends_of(len(control.sources) for control in controls)
        own = inputs[:-1] + np.arange(len(controls))  # the numbers of a control lie before those of its sources
        listed = Lists.of([self.number.dofs(one.coordinates) for control in controls for one in control.sources])
        source, reached = [], []
        for c, control in enumerate(controls):
            place = {dof: i for i, dof in enumerate(dofs.values[dofs.ptr[c] : dofs.ptr[c + 1]].tolist())}
            source += [(one.kind, self.source(one)) for one in control.sources]
            reached += [place.get(dof, -1) for one in control.sources for dof in self.number.dofs(one.coordinates)]
        width = np.diff(dofs.ptr)[self.owner]
        return Controls(
            self.numbered("control", [control.kernel for control in controls]), self.p["control"][own],
            self.z["control"], inputs, np.column_stack([table(source, 2), np.delete(self.p["control"], own, axis=0)]),
            listed.ptr, listed.values, ints(reached), ints([len(control.states) for control in controls]),
            self.outputs, self.owner, ends_of(width), dofs.ptr, places(dofs.values), self.state_blocks.ptr,
            self.positions(self.state_blocks), self.load_blocks.ptr, self.positions(self.load_blocks),
            ints(self.layout.controls),
        )  # fmt: skip

    def source(self, one: Any) -> int:
        """Number of the kernel, the output or the coordinate that an input of a control is read from."""
        if one.kind == at.OUTPUT:
            first = {control.part: int(self.outputs[c]) for c, control in enumerate(self.contributions.controls)}
            return first[one.control] + int(one.output)
        if one.kind == at.MEASURED:
            return int(self.numbered("signal", [one.kernel])[0])
        if one.motion:
            return int(self.numbered("motion", [one.motion.kernel])[0])
        return self.number.dofs(one.coordinates)[0]

    def measured(self) -> Measured:
        """Arrays of the signals computed by kernels, and of relative rotations."""
        found, angles = self.contributions.signals, self.contributions.angles
        own = [one.coordinates for one in found]
        dofs = self.number.lists(found)
        elements = [*enumerate(self.contributions.elements)]
        element = {contribution.part: e for e, contribution in reversed(elements)}
        element |= {contribution.part: e for e, contribution in reversed(elements) if contribution.factor is not None}
        placed = list(zip(found, self.layout.measured, strict=True))
        return Measured(
            self.numbered("signal", [None if one.place else one.kernel for one in found]),
            self.numbered("extremum", [one.kernel if one.place else None for one in found]),
            self.p["signal"], dofs.ptr, dofs.values, ints([a != b for a, b in zip(own, [None, *own], strict=False)]),
            ints([element[one.part] if one.use_of_factor else -1 for one in found]),
            ints([model.USES_OF_FACTOR.index(one.use_of_factor) if one.use_of_factor else -1 for one in found]),
            ints(self.layout.measured),
            ints([*(k for one, k in placed if one.is_mode), *(k + 1 for one, k in placed if one.place)]),
            table([(k + 1, k) for one, k in placed if one.place], 2),
            table(self.number.lists(angles).values.reshape(-1, 2), 2), self.p["angle"], ints(self.layout.angles),
        )  # fmt: skip


def rate_of(contribution: ConstraintContribution, reaction: Reaction, rates: Mapping[tuple[str, str], int]) -> int:
    """Number of the signal that multiplies a reaction, -1 for none; `rates` numbers the signals of kernels."""
    if not reaction.rate:
        return -1
    own = [name for part, name in rates if part == contribution.part]
    if reaction.rate not in own:
        text = f"Part {contribution.part!r}: reaction {reaction.name!r} has the rate {reaction.rate!r}, which is no"
        raise KernelError(f"{text} signal of a kernel of this part. {checks.did_you_mean(reaction.rate, own)}")
    return rates[contribution.part, reaction.rate]


REMEMBERED_STRUCTURES = 16  # number of remembered structures; a mechanism has two, one in motion and one for its start
REMEMBERED_UNKNOWNS = 50_000  # number of unknowns of all remembered structures but the latest: some hundred megabytes
FIELDWISE_FROM = 100  # number of contributions above which their keys are read field by field, which is faster
# Fields of contributions on whose length alone a structure depends, which `numbers` knows, if at all; not on floats.
NUMBERS = ("p", "history", "start", "sample")
# Fields of names and whole numbers, which are part of the key.
NAMES = frozenset(
    "part name coordinates second units drive_units signal holds rows row moment_row place columns curved".split()
)
_LATEST: OrderedDict[Hashable, tuple[Structure, tuple[Kernel, ...]]] = OrderedDict()


@dataclass(frozen=True, eq=False)
class Structure:
    """Structure of a program; tables with the parameters of the first mechanism, names without bodies and aliases."""

    tables: Tables
    kernels: tuple[tuple[Kernel, ...], ...]
    symbolic: Symbolic
    names: Names
    drives: tuple[str, ...]


def structure_of(contributions: Contributions, number: Numbering, listed: Listed) -> Structure:
    """Structure of contributions with the `numbers` of their parts, remembered or new."""
    kernels: list[Kernel] = []
    groups = tuple(getattr(contributions, group.name) for group in fields(contributions))
    nodes = tuple([(part, node.name) for part, node in number.nodes])
    lengths = tuple([tuple(map(len, group)) for lists in listed for group in lists.values()])
    key = (nodes, lengths, *(_read_all(group, number, kernels) for group in groups))
    try:
        known = _LATEST.get(key)
    except TypeError:  # a part of one's own put something into its pieces that cannot be compared
        return new_structure(contributions, number, listed)
    if known is None:
        # the kernels are kept beside it: the key holds their ids, which must not be given to others
        known = _LATEST[key] = new_structure(contributions, number, listed), tuple(kernels)
        unknowns = sum(structure.symbolic.n for structure, _ in _LATEST.values())
        while len(_LATEST) > REMEMBERED_STRUCTURES or (len(_LATEST) > 1 and unknowns > REMEMBERED_UNKNOWNS):
            unknowns -= _LATEST.popitem(last=False)[1][0].symbolic.n
    return known[0]


def _read_all(group: Sequence[Any], number: Numbering, kernels: list[Kernel]) -> tuple[Any, ...]:
    """Key of a group of contributions, field by field, shared values once, coordinates by number."""
    kinds = tuple(map(type, group))
    if len(group) < FIELDWISE_FROM or len(set(kinds)) != 1:
        return tuple([_read(contribution, kernels) for contribution in group])
    names, others = _fields(kinds[0])
    dofs = number.lists(group)
    found: list[tuple[Any, ...]] = [kinds, (dofs.ptr.tobytes(), dofs.values.tobytes())]
    found += [tuple(map(attrgetter(name), group)) for name in names if name != "coordinates"]
    for name in others:
        values = list(map(attrgetter(name), group))
        known = {place: _read(value, kernels) for place, value in {id(value): value for value in values}.items()}
        found.append(tuple([known[id(value)] for value in values]))
    return tuple(found)


def _read(value: Any, kernels: list[Kernel]) -> Any:
    """Hashable key of `value`; its kernels are collected in `kernels`."""
    if isinstance(value, (str, int, float)) or value is None:
        return value
    if isinstance(value, tuple):
        return tuple([_read(item, kernels) for item in value])
    if isinstance(value, Kernel):
        kernels.append(value)
        return id(value)
    if is_kind(value.__class__, Law):
        kernels.append(value.kernel)
        return id(value.kernel)
    kind = value.__class__
    names, others = _fields(kind)
    if not names and not others:
        return value
    found: list[Any] = [kind, *[getattr(value, name) for name in names]]
    for name in others:
        item = getattr(value, name)
        found.append(item if item is None else _read(item, kernels))
    return tuple(found)


@cache
def _fields(kind: type) -> tuple[tuple[str, ...], ...]:
    """Fields of a dataclass but for numbers: names, and others; empty for other objects."""
    known = [f.name for f in fields(kind) if f.name not in NUMBERS and f.type != "float"] if is_dataclass(kind) else []
    return tuple([name for name in known if name in NAMES]), tuple([name for name in known if name not in NAMES])


def new_structure(contributions: Contributions, number: Numbering, listed: Listed) -> Structure:
    """New structure of contributions."""
    packer = Packer(contributions, number, listed)
    places = packer.layout
    elements, constraints, contacts = packer.elements(), packer.constraints(), packer.contacts()
    measured, controls = packer.measured(), packer.controls()
    sources = [source for control in contributions.controls for source in control.sources]
    read = [*contributions.elements, *contributions.constraints, *contributions.signals, *sources]
    p, z = flat(listed)
    widest = max([len(contribution.coordinates) for contribution in read], default=1)
    rows = max([c.rows for c in contributions.constraints], default=1)
    rubs = any(c.joint_friction is not None for c in contributions.constraints)
    sizes = Sizes(number.n_q, number.n_b, packer.n_c, len(z), len(places.signals), places.energy, widest, rows, rubs)
    in_order = np.arange(number.n_q)
    kind = ((in_order % 3 == 2) & (in_order < number.n_b)).astype(np.int64)
    tables = Tables(sizes, p, elements, constraints, contacts, measured, controls, kind)
    freeze(tables)
    equations = tuple(f"{c.part}[{i}]" for c in contributions.constraints for i in range(c.rows))
    owners, labels = tuple([e.part for e in contributions.elements]), tuple(c.label for c in contributions.contacts)
    names = Names(owners, packer.names, equations, labels, (), places.signals, {})
    driven = [(c.part, row) for c in contributions.constraints for row in c.motions]
    kernels = tuple(tuple(kernel for _, kernel in packer.kernels[kind].values()) for kind in at.KINDS)
    drives = tuple(f"{part}.{row.name}" if row.name else part for part, row in driven)
    return Structure(tables, kernels, packer.symbolic, names, drives)
