"""Packing of pieces into flat arrays."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain

import numpy as np

from flexmb import checks
from flexmb.errors import KernelError
from flexmb.kernels import Kernel
from flexmb.model.contributions import USES_OF_FACTOR, ConstraintContribution, Contributions, Coordinate, Reaction
from flexmb.model.law import Motion
from flexmb.program.numbering import Lists, Numbering
from flexmb.program.program import (
    CONTACT_COMMON,
    FIRST_OUTPUT,
    MEASURED,
    MOTION_SPEED,
    MOTION_VALUE,
    OUTPUT,
    Constraints,
    Contacts,
    Controls,
    Elements,
    Measured,
)
from flexmb.program.signals import force_signals

Bounds = tuple[int, int]


class KernelList:
    """Kernels of one contract, each once."""

    def __init__(self) -> None:
        self.kernels: list[Kernel] = []
        self._number: dict[int, int] = {}

    def number(self, kernel: Kernel | None) -> int:
        """Number of the kernel, -1 for None."""
        if kernel is None:
            return -1
        if id(kernel) not in self._number:
            self._number[id(kernel)] = len(self.kernels)
            self.kernels.append(kernel)
        return self._number[id(kernel)]

    def numbers(self, kernels: Iterable[Kernel | None]) -> list[int]:
        """Numbers of several kernels, -1 for None; most of a large model are alike."""
        listed = list(kernels)
        of = {id(kernel): self.number(kernel) for kernel in {id(kernel): kernel for kernel in listed}.values()}
        return [of[id(kernel)] for kernel in listed]


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


Positions = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""Places in the factored matrix of entries with these rows and columns."""


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
    """Collects numbers, histories, kernels and matrix blocks of all pieces, in the order of declaration."""

    def __init__(self, contributions: Contributions, number: Numbering) -> None:
        self.contributions = contributions
        self.number = number
        self.p: list[float] = []
        self.z: list[float] = []
        self.kernels = {name: KernelList() for name in KINDS}
        groups = (contributions.elements, contributions.contacts, contributions.constraints)
        self.element_dofs, self.contact_dofs, self.constraint_dofs = (number.lists(group) for group in groups)
        self.element_blocks, self.contact_blocks = (self.square(d) for d in (self.element_dofs, self.contact_dofs))
        row = np.cumsum([0, *(contribution.rows for contribution in contributions.constraints)])
        self.n_c = int(row[-1])
        rows = Lists(row, number.n_q + np.arange(self.n_c))
        self.g_blocks = Blocks.of(rows, self.unknowns(self.constraint_dofs))
        self.h_blocks = self.square(self.constraint_dofs)
        self.control_dofs = number.lists(contributions.controls)
        states = Lists.of([number.dofs(control.states) for control in contributions.controls])
        self.state_blocks = Blocks.of(states, self.control_dofs)
        outputs = [(k, load) for k, c in enumerate(contributions.controls) for load in c.load_coordinates]
        self.owner = ints([k for k, _ in outputs])
        loads = Lists.of([number.dofs(load) for _, load in outputs])
        lists = [self.control_dofs.values[self.control_dofs.ptr[k] : self.control_dofs.ptr[k + 1]] for k in self.owner]
        self.load_blocks = Blocks.of(loads, Lists.of([values.tolist() for values in lists]))
        self.outputs = np.cumsum([0, *(len(control.outputs) for control in contributions.controls)])

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

    def add(self, values: Iterable[float]) -> Bounds:
        """Append numbers of a part; where they begin and end."""
        begin = len(self.p)
        self.p.extend(values)
        return begin, len(self.p)

    def add_each(self, lists: Sequence[Sequence[float]]) -> np.ndarray:
        """Append the numbers of several parts; where they begin and end, (n, 2)."""
        ends = len(self.p) + np.cumsum([0, *map(len, lists)])
        self.p.extend(chain.from_iterable(lists))
        return np.stack([ends[:-1], ends[1:]], axis=1)

    def remember_each(self, lists: Sequence[Sequence[float]]) -> np.ndarray:
        """Append start values of several histories; where they begin and end, (n, 2)."""
        ends = len(self.z) + np.cumsum([0, *map(len, lists)])
        self.z.extend(chain.from_iterable(lists))
        return np.stack([ends[:-1], ends[1:]], axis=1)

    def numbers(self, kind: str, kernels: Iterable[Kernel | None]) -> np.ndarray:
        """Numbers of the kernels of a kind, -1 for None."""
        return ints(self.kernels[kind].numbers(kernels))

    def remember(self, values: Iterable[float]) -> Bounds:
        """Append start values of a history; where they begin and end."""
        begin = len(self.z)
        self.z.extend(values)
        return begin, len(self.z)

    def elements(self, positions: Positions) -> Elements:
        """Arrays of the elements; `positions` maps rows and columns to places in the factored matrix."""
        contributions = self.contributions.elements
        factors = [contribution.factor for contribution in contributions]
        # what is never called is not compiled
        slow = [None if contribution.is_complete else contribution for contribution in contributions]
        return Elements(
            self.numbers("element", [contribution.kernel if contribution else None for contribution in slow]),
            self.numbers("energy", [contribution.energy for contribution in contributions]),
            self.factors(factors),
            self.numbers("force", [contribution.force for contribution in contributions]),
            self.numbers("tangent", [contribution.tangent for contribution in contributions]),
            self.numbers("account", [contribution.account for contribution in contributions]),
            self.add_each([contribution.p for contribution in contributions]),
            self.add_each([law.parameters() if law else () for law in factors]),
            self.remember_each([contribution.history for contribution in contributions]),
            self.element_dofs.ptr,
            self.element_blocks.ptr,
            places(self.element_dofs.values),
            places(positions(self.element_blocks.rows, self.element_blocks.columns)),
        )

    def constraints(self, positions: Positions, out: Sequence[int], measured: Sequence[int]) -> Constraints:
        """Arrays of the constraints; `out` numbers the first signal of each, `measured` the signals of kernels."""
        contributions = self.contributions.constraints
        laws = [law for contribution in contributions for law in motion_of_each_row(contribution)]
        rows, columns = self.g_blocks.rows, self.g_blocks.columns
        return Constraints(
            self.numbers("constraint", [contribution.kernel for contribution in contributions]),
            self.numbers("motion", [law.kernel if law else None for law in laws]),
            self.add_each([contribution.p for contribution in contributions]),
            self.add_each([law.parameters() if law else () for law in laws]),
            ints(np.cumsum([0, *(contribution.rows for contribution in contributions)])),
            self.constraint_dofs.ptr,
            self.g_blocks.ptr,
            self.h_blocks.ptr,
            places(self.constraint_dofs.values),
            places(positions(rows, columns)),
            places(positions(columns, rows)),
            places(positions(self.h_blocks.rows, self.h_blocks.columns)),
            table([places_of_second(contribution) for contribution in contributions], 3),
            ints([contribution.moment_row for contribution in contributions]),
            ints(out),
            ints([len(force_signals(contribution)) for contribution in contributions]),
            *self.joint_frictions(contributions),
            *self.reactions(contributions, measured),
        )

    def factors(self, motions: Sequence[Motion | None]) -> np.ndarray:
        """Factor of each element: number of a motion, NO_FACTOR, or FIRST_OUTPUT less the number of an output."""
        found = self.numbers("motion", [law.kernel if law else None for law in motions])
        controlled = {
            load: FIRST_OUTPUT - int(self.outputs[c]) - k
            for c, control in enumerate(self.contributions.controls)
            for k, load in enumerate(control.loads)
        }
        for e, element in enumerate(self.contributions.elements if controlled else ()):
            found[e] = controlled.get(element.part, found[e])
        return found

    def reactions(
        self, contributions: Sequence[ConstraintContribution], measured: Sequence[int]
    ) -> tuple[np.ndarray, ...]:
        """Bounds, rows, coordinates, factors and rates of reported reactions."""
        first = np.cumsum([0, *(contribution.rows for contribution in contributions)])
        signals = zip(self.contributions.signals, measured, strict=True)
        rates = {(signal.part, signal.name): place for signal, place in signals}
        found = [
            (
                first[c] + r.row,
                self.number.dofs([piece.coordinates[r.place]])[0] if r.place >= 0 else -1,
                r.factor,
                rate_of(piece, r, rates),
            )
            for c, piece in enumerate(contributions)
            for r in piece.reactions
        ]
        rows, dofs, factors, own_rates = zip(*found, strict=True) if found else ((), (), (), ())
        bounds = np.cumsum([0, *(len(contribution.reactions) for contribution in contributions)])
        listed = [reaction for contribution in contributions for reaction in contribution.reactions]
        on = np.cumsum([0, *(len(reaction.on) for reaction in listed)])
        places, powers = [k for reaction in listed for k in reaction.on], [int(r.power) for r in listed]
        factor = np.array(factors, dtype=float)
        return ints(bounds), ints(rows), ints(dofs), factor, ints(own_rates), ints(on), ints(places), ints(powers)

    def joint_frictions(self, contributions: Sequence[ConstraintContribution]) -> tuple[np.ndarray, ...]:
        """Kernels, numbers, histories and arms of friction in ideal joints."""
        if not any(contribution.joint_friction for contribution in contributions):
            count, end = len(contributions), (len(self.p), len(self.z))
            return np.full((count, 2), -1), np.full((count, 4), end[0]), np.full((count, 2), end[1]), np.ones(count)
        kernel, p, z, arm = [], [], [], []
        for contribution in contributions:
            joint_friction = contribution.joint_friction
            law = joint_friction.friction if joint_friction else None
            parts = (
                ("joint_friction", joint_friction.kernel if joint_friction else None),
                ("friction", law.kernel if law else None),
            )
            kernel.append([self.kernels[kind].number(k) for kind, k in parts])
            p.append(
                [*self.add(joint_friction.p if joint_friction else ()), *self.add(law.parameters() if law else ())]
            )
            z.append(self.remember(law.history() if law else ()))
            arm.append(joint_friction.arm if joint_friction else 1.0)
        return table(kernel, 2), table(p, 4), table(z, 2), np.array(arm, dtype=float).reshape(-1)

    def contacts(self, positions: Positions, out: Sequence[int]) -> Contacts:
        """Arrays of the contacts; `out` numbers the first signal of each."""
        kernel, p, z = [], [], []
        for contribution in self.contributions.contacts:
            parts = (
                ("gap", contribution.gap),
                ("normal", contribution.normal.kernel),
                ("friction", contribution.friction.kernel),
            )
            kernel.append([self.kernels[kind].number(k) for kind, k in parts])
            values = (contribution.p, contribution.normal.parameters(), contribution.friction.parameters())
            p.append([b for v in values for b in self.add(v)])
            histories = ((0.0,) * CONTACT_COMMON, contribution.normal.history(), contribution.friction.history())
            bounds = [self.remember(h) for h in histories]
            z.append([*(b for b, _ in bounds), bounds[-1][1]])
        entries = places(positions(self.contact_blocks.rows, self.contact_blocks.columns))
        return Contacts(
            table(kernel, 3), table(p, 6), table(z, 4), places(self.contact_dofs.values), entries, ints(out)
        )

    def controls(self, positions: Positions, out: Sequence[int]) -> Controls:
        """Arrays of the controls; `positions` maps rows and columns to places in the factored matrix."""
        controls, dofs = self.contributions.controls, self.control_dofs
        kernel, p, z, source, source_dofs, source_places = [], [], [], [], [], []
        number = {control.part: int(self.outputs[c]) for c, control in enumerate(controls)}
        for c, control in enumerate(controls):
            kernel.append(self.kernels["control"].number(control.kernel))
            p.append(self.add(control.p))
            z.append(self.remember(control.history))
            place = {int(dof): i for i, dof in enumerate(dofs.values[dofs.ptr[c] : dofs.ptr[c + 1]])}
            for one in control.sources:
                own = self.number.dofs(one.coordinates)
                what = own[0] if own else -1
                if one.kind == MEASURED:
                    what = self.kernels["signal"].number(one.kernel)
                elif one.kind in (MOTION_VALUE, MOTION_SPEED) and one.motion:
                    what = self.kernels["motion"].number(one.motion.kernel)
                elif one.kind == OUTPUT:
                    what = number[one.control] + one.output
                source.append([one.kind, what, *self.add(one.motion.parameters() if one.motion else one.p)])
                source_dofs.append(own)
                source_places += [place.get(dof, -1) for dof in own]
        width = np.diff(dofs.ptr)[self.owner]
        listed = Lists.of(source_dofs)
        return Controls(
            ints(kernel),
            table(p, 2),
            table(z, 2),
            ints(np.cumsum([0, *(len(control.sources) for control in controls)])),
            table(source, 4),
            listed.ptr,
            listed.values,
            ints(source_places),
            ints([control.count for control in controls]),
            ints(self.outputs),
            self.owner,
            ints(np.cumsum([0, *width])),
            dofs.ptr,
            places(dofs.values),
            self.state_blocks.ptr,
            places(positions(self.state_blocks.rows, self.state_blocks.columns)),
            self.load_blocks.ptr,
            places(positions(self.load_blocks.rows, self.load_blocks.columns)),
            ints(out),
        )

    def measured(self, out: Sequence[int], angle_out: Sequence[int]) -> Measured:
        """Arrays of the signals computed by kernels, and of relative rotations."""
        contributions, angles = self.contributions.signals, self.contributions.angles
        dofs = self.number.lists(contributions)
        elements = [*enumerate(self.contributions.elements)]
        element = {contribution.part: e for e, contribution in reversed(elements)}
        element |= {contribution.part: e for e, contribution in reversed(elements) if contribution.factor is not None}
        placed = list(zip(contributions, out, strict=True))
        return Measured(
            self.numbers("signal", [None if one.place else one.kernel for one in contributions]),
            self.numbers("extremum", [one.kernel if one.place else None for one in contributions]),
            self.add_each([contribution.p for contribution in contributions]),
            dofs.ptr,
            dofs.values,
            ints([element[one.part] if one.use_of_factor else -1 for one in contributions]),
            ints([USES_OF_FACTOR.index(one.use_of_factor) if one.use_of_factor else -1 for one in contributions]),
            ints(out),
            ints([*(k for one, k in placed if one.is_mode), *(k + 1 for one, k in placed if one.place)]),
            table([(k + 1, k) for one, k in placed if one.place], 2),
            table(self.number.lists(angles).values.reshape(-1, 2), 2),
            self.add_each([contribution.p for contribution in angles]),
            ints(angle_out),
        )


KINDS = (
    *("element", "energy", "constraint", "motion", "gap", "normal", "friction", "joint_friction", "signal"),
    *("extremum", "force", "tangent", "account", "control"),
)
"""Kinds of kernels, in the order of `Addresses`."""


def rate_of(contribution: ConstraintContribution, reaction: Reaction, rates: Mapping[tuple[str, str], int]) -> int:
    """Number of the signal that multiplies a reaction, -1 for none; `rates` numbers the signals of kernels."""
    if not reaction.rate:
        return -1
    own = [name for part, name in rates if part == contribution.part]
    if reaction.rate not in own:
        text = (
            f"Part {contribution.part!r}: reaction {reaction.name!r} has the rate {reaction.rate!r}, which is no signal"
        )
        raise KernelError(f"{text} of a kernel of this part. {checks.did_you_mean(reaction.rate, own)}")
    return rates[contribution.part, reaction.rate]


def motion_of_each_row(contribution: ConstraintContribution) -> list[Motion | None]:
    """The motions of a constraint, None for rows without."""
    given = {driven.row: driven.motion for driven in contribution.motions}
    return [given.get(row) for row in range(contribution.rows)]


def places_of_second(contribution: ConstraintContribution) -> list[int]:
    """Places of x, y, theta of the second body among the coordinates of a constraint."""
    if contribution.second is None:
        return [-1, -1, -1]
    places: dict[Coordinate, int] = {c: i for i, c in enumerate(contribution.coordinates)}
    return [places[c] for c in contribution.second]
