"""Structure of a program, independent of all numbers; shared by mechanisms that differ in numbers alone.

Integer arrays, elimination order and pattern of the factors depend on kernels and coordinates, not on lengths and mass.
The latest structures are remembered, so that a sweep computes them once.  Their key contains everything that they
depend on, and they are read-only.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Hashable, Sequence
from dataclasses import dataclass, fields, is_dataclass
from functools import cache
from operator import attrgetter
from typing import Any

import numpy as np

from flexmb.engine.linalg.ordering import elimination_order
from flexmb.engine.linalg.symbolic import Symbolic, symbolic
from flexmb.kernels import Kernel
from flexmb.model.contributions import Contributions
from flexmb.model.law import Law
from flexmb.model.signal import Signals
from flexmb.program.numbering import Numbering, blocks_and_edges
from flexmb.program.packing import KINDS, Packer, motion_of_each_row
from flexmb.program.program import CONTACT_COMMON, Sizes, Tables, freeze
from flexmb.program.signals import layout

REMEMBERED_STRUCTURES = 16
"""Number of remembered structures; a mechanism has two, one in motion and one for its start."""

REMEMBERED_UNKNOWNS = 50_000
"""Number of unknowns of all remembered structures but the latest: some hundred megabytes."""

FIELDWISE_FROM = 100
"""Number of contributions above which their keys are read field by field, which is faster."""

NUMBERS = ("p", "history")
"""Fields of contributions of which a structure depends on the length alone."""

NAMES = frozenset("part name coordinates second units drive_units signal holds rows row moment_row place".split())
"""Fields of names and whole numbers, which are part of the key."""

_LATEST: OrderedDict[Hashable, tuple[Structure, tuple[Kernel, ...]]] = OrderedDict()


@dataclass(frozen=True, eq=False)
class Structure:
    """Structure of a program; its tables have the parameters of the first mechanism with this structure."""

    tables: Tables
    kernels: tuple[tuple[Kernel, ...], ...]
    symbolic: Symbolic
    elements: tuple[str, ...]
    coordinates: tuple[str, ...]
    rows: tuple[str, ...]
    contacts: tuple[str, ...]
    drives: tuple[str, ...]
    signals: Signals

    def filled(self, p: np.ndarray) -> Tables:
        """The tables with the numbers (n_p,) of one mechanism."""
        return self.tables.replaced(p=p)


def structure_of(contributions: Contributions, number: Numbering) -> Structure:
    """Structure of contributions, remembered or new."""
    kernels: list[Kernel] = []
    groups = tuple(getattr(contributions, group.name) for group in fields(contributions))
    key = (
        tuple([(part, node.name) for part, node in number.nodes]),
        *(_read_all(group, number, kernels) for group in groups),
    )
    try:
        known = _LATEST.get(key)
    except TypeError:  # a part of one's own put something into its pieces that cannot be compared
        return new_structure(contributions, number)
    if known is None:
        # the kernels are kept beside it: the key holds their ids, which must not be given to others
        known = _LATEST[key] = new_structure(contributions, number), tuple(kernels)
        while len(_LATEST) > REMEMBERED_STRUCTURES or (len(_LATEST) > 1 and _unknowns() > REMEMBERED_UNKNOWNS):
            _LATEST.popitem(last=False)
    return known[0]


def _unknowns() -> int:
    return sum(structure.symbolic.n for structure, _ in _LATEST.values())


def _read_all(group: Sequence[Any], number: Numbering, kernels: list[Kernel]) -> tuple[Any, ...]:
    """Key of a group of contributions, field by field; a shared value is read once.

    Numbers of the coordinates say the same as their names, beside the names of all nodes.
    """
    kinds = tuple(map(type, group))
    if len(group) < FIELDWISE_FROM or len(set(kinds)) != 1:
        return tuple([_read(contribution, kernels) for contribution in group])
    lengths, names, others = _fields(kinds[0])
    dofs = number.lists(group)
    found: list[tuple[Any, ...]] = [kinds, (dofs.ptr.tobytes(), dofs.values.tobytes())]
    found += [tuple([len(getattr(contribution, name)) for contribution in group]) for name in lengths]
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
    if _is_law(value.__class__):
        kernels.append(value.kernel)
        return id(value.kernel), len(value.parameters()), len(value.history())
    kind = value.__class__
    lengths, names, others = _fields(kind)
    if not lengths and not names and not others:
        return value
    found: list[Any] = [kind, *[len(getattr(value, name)) for name in lengths]]
    found += [getattr(value, name) for name in names]
    for name in others:
        item = getattr(value, name)
        found.append(item if item is None else _read(item, kernels))
    return tuple(found)


@cache
def _is_law(kind: type) -> bool:
    """Whether a class is one of laws; remembered, since abstract base classes are slow."""
    return issubclass(kind, Law)


@cache
def _fields(kind: type) -> tuple[tuple[str, ...], ...]:
    """Fields of a dataclass by their role: number lists, names, others; empty for other objects."""
    known = [f.name for f in fields(kind)] if is_dataclass(kind) else []
    lengths, names = ([name for name in known if name in group] for group in (NUMBERS, NAMES))
    return tuple(lengths), tuple(names), tuple([name for name in known if name not in (*lengths, *names)])


def most_coordinates(contributions: Contributions) -> int:
    """Largest number of coordinates that one kernel reads; 1 without kernels."""
    sources = [source for control in contributions.controls for source in control.sources]
    read = [*contributions.elements, *contributions.constraints, *contributions.signals, *sources]
    return max([len(contribution.coordinates) for contribution in read], default=1)


def new_structure(contributions: Contributions, number: Numbering) -> Structure:
    """New structure of contributions."""
    packer = Packer(contributions, number)
    order = elimination_order(*blocks_and_edges(contributions, number))
    pattern = symbolic(number.n_q + packer.n_c, *packer.pattern(), order)
    names = number.names()
    places = layout(contributions, names, number.n_b)
    elements = packer.elements(pattern.positions)
    constraints = packer.constraints(pattern.positions, places.constraints, places.measured)
    contacts = packer.contacts(pattern.positions, places.contacts)
    measured = packer.measured(places.measured, places.angles)
    controls = packer.controls(pattern.positions, places.controls)
    sizes = Sizes(
        number.n_q,
        number.n_b,
        packer.n_c,
        len(packer.z),
        len(places.signals),
        places.energy,
        most_coordinates(contributions),
        max([p.rows for p in contributions.constraints], default=1),
        any(p.joint_friction is not None for p in contributions.constraints),
    )
    places_in_order = np.arange(number.n_q)
    kind = ((places_in_order % 3 == 2) & (places_in_order < number.n_b)).astype(np.int64)
    tables = Tables(sizes, np.array(packer.p, dtype=float), elements, constraints, contacts, measured, controls, kind)
    freeze(tables)
    driven = [(c.part, row) for c in contributions.constraints for row in c.motions]
    return Structure(
        tables,
        tuple(tuple(packer.kernels[kind].kernels) for kind in KINDS),
        pattern,
        tuple(map(attrgetter("part"), contributions.elements)),
        names,
        tuple(f"{c.part}[{i}]" for c in contributions.constraints for i in range(c.rows)),
        tuple(c.label for c in contributions.contacts),
        tuple(f"{part}.{row.name}" if row.name else part for part, row in driven),
        places.signals,
    )


def numbers_of(contributions: Contributions) -> tuple[np.ndarray, np.ndarray]:
    """Parameters p and start histories z of all contributions, in the order of `Packer`."""
    p: list[float] = []
    z: list[float] = []
    for element in contributions.elements:
        p.extend(element.p)
        z.extend(element.history)
    for element in contributions.elements:
        p.extend(element.factor.parameters() if element.factor else ())
    for constraint in contributions.constraints:
        p.extend(constraint.p)
    for constraint in contributions.constraints:
        for motion in motion_of_each_row(constraint) if constraint.motions else ():
            p.extend(motion.parameters() if motion else ())
    for constraint in contributions.constraints:
        if constraint.joint_friction is not None:
            p.extend((*constraint.joint_friction.p, *constraint.joint_friction.friction.parameters()))
            z.extend(constraint.joint_friction.friction.history())
    for contact in contributions.contacts:
        p.extend((*contact.p, *contact.normal.parameters(), *contact.friction.parameters()))
        z.extend((0.0,) * CONTACT_COMMON + (*contact.normal.history(), *contact.friction.history()))
    for signal in contributions.signals:
        p.extend(signal.p)
    for angle in contributions.angles:
        p.extend(angle.p)
    for control in contributions.controls:
        p.extend(control.p)
        z.extend(control.history)
        for source in control.sources:
            p.extend(source.motion.parameters() if source.motion else source.p)
    return np.array(p, dtype=float), np.array(z, dtype=float)
