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

from flexmb.engine.linalg.symbolic import Symbolic
from flexmb.kernels import Kernel
from flexmb.model.contributions import Contributions
from flexmb.model.law import Law
from flexmb.model.part import is_kind
from flexmb.program.numbering import Numbering
from flexmb.program.packing import KINDS, NumberLists, Packer, flat
from flexmb.program.program import Names, Sizes, Tables, freeze

REMEMBERED_STRUCTURES = 16
"""Number of remembered structures; a mechanism has two, one in motion and one for its start."""

REMEMBERED_UNKNOWNS = 50_000
"""Number of unknowns of all remembered structures but the latest: some hundred megabytes."""

FIELDWISE_FROM = 100
"""Number of contributions above which their keys are read field by field, which is faster."""

NUMBERS = ("p", "history", "start", "sample")
"""Fields of contributions of which a structure depends on the length alone, which `numbers` knows, if at all."""

NAMES = frozenset("part name coordinates second units drive_units signal holds rows row moment_row place".split())
"""Fields of names and whole numbers, which are part of the key."""

_LATEST: OrderedDict[Hashable, tuple[Structure, tuple[Kernel, ...]]] = OrderedDict()


@dataclass(frozen=True, eq=False)
class Structure:
    """Structure of a program; tables with the parameters of the first mechanism, names without bodies and aliases."""

    tables: Tables
    kernels: tuple[tuple[Kernel, ...], ...]
    symbolic: Symbolic
    names: Names
    drives: tuple[str, ...]


def structure_of(contributions: Contributions, number: Numbering, listed: tuple[NumberLists, NumberLists]) -> Structure:
    """Structure of contributions with the `numbers` of their parts, remembered or new."""
    kernels: list[Kernel] = []
    groups = tuple(getattr(contributions, group.name) for group in fields(contributions))
    key = (
        tuple([(part, node.name) for part, node in number.nodes]),
        tuple([tuple(map(len, group)) for lists in listed for group in lists.values()]),
        *(_read_all(group, number, kernels) for group in groups),
    )
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
    """Key of a group of contributions, field by field; a shared value is read once.

    Numbers of the coordinates say the same as their names, beside the names of all nodes.
    """
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
    known = [f.name for f in fields(kind) if f.name not in NUMBERS] if is_dataclass(kind) else []
    return tuple([name for name in known if name in NAMES]), tuple([name for name in known if name not in NAMES])


def new_structure(
    contributions: Contributions, number: Numbering, listed: tuple[NumberLists, NumberLists]
) -> Structure:
    """New structure of contributions."""
    packer = Packer(contributions, number, listed)
    places = packer.layout
    elements, constraints, contacts = packer.elements(), packer.constraints(), packer.contacts()
    measured, controls = packer.measured(), packer.controls()
    sources = [source for control in contributions.controls for source in control.sources]
    read = [*contributions.elements, *contributions.constraints, *contributions.signals, *sources]
    p, z = flat(listed)
    sizes = Sizes(
        number.n_q,
        number.n_b,
        packer.n_c,
        len(z),
        len(places.signals),
        places.energy,
        max([len(contribution.coordinates) for contribution in read], default=1),
        max([c.rows for c in contributions.constraints], default=1),
        any(c.joint_friction is not None for c in contributions.constraints),
    )
    in_order = np.arange(number.n_q)
    kind = ((in_order % 3 == 2) & (in_order < number.n_b)).astype(np.int64)
    tables = Tables(sizes, p, elements, constraints, contacts, measured, controls, kind)
    freeze(tables)
    names = Names(
        tuple(map(attrgetter("part"), contributions.elements)),
        packer.names,
        tuple(f"{c.part}[{i}]" for c in contributions.constraints for i in range(c.rows)),
        tuple(c.label for c in contributions.contacts),
        (),
        places.signals,
        {},
    )
    driven = [(c.part, row) for c in contributions.constraints for row in c.motions]
    return Structure(
        tables,
        tuple(tuple(kernel for _, kernel in packer.kernels[kind].values()) for kind in KINDS),
        packer.symbolic,
        names,
        tuple(f"{part}.{row.name}" if row.name else part for part, row in driven),
    )
