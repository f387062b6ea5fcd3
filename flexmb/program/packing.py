"""Packing of pieces into flat arrays."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from flexmb.kernels import Kernel
from flexmb.model.law import Motion
from flexmb.model.pieces import ConstraintPiece, Coordinate, Pieces
from flexmb.program.numbering import Numbering
from flexmb.program.signals import force_signals
from flexmb.program.tables import CONTACT_COMMON, Constraints, Contacts, Elements, Measured

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


class Ragged:
    """Lists of different lengths stored one after the other, with offsets."""

    def __init__(self) -> None:
        self.offset = [0]
        self.values: list[int] = []

    def add(self, values: Iterable[int]) -> None:
        """Append one list."""
        self.values.extend(values)
        self.offset.append(len(self.values))


class Blocks:
    """Dense blocks of the matrix, row by row, with offsets."""

    def __init__(self) -> None:
        self.offset = [0]
        self.rows: list[int] = []
        self.columns: list[int] = []

    def add(self, rows: Sequence[int], columns: Sequence[int]) -> None:
        """Append one block."""
        self.rows.extend(i for i in rows for _ in columns)
        self.columns.extend(j for _ in rows for j in columns)
        self.offset.append(len(self.rows))

    @property
    def arrays(self) -> tuple[np.ndarray, np.ndarray]:
        """Row and column numbers."""
        return ints(self.rows), ints(self.columns)


def ints(values: Sequence[int]) -> np.ndarray:
    """A 1-D int64 array."""
    return np.array(values, dtype=np.int64).reshape(-1)


def places(values: Sequence[int]) -> np.ndarray:
    """A 1-D uint64 array of indices: the compiled loop need not ask whether they count from the end."""
    return np.array(values, dtype=np.uint64).reshape(-1)


def table(rows: Sequence[Sequence[int]], columns: int) -> np.ndarray:
    """A 2-D int64 array, also without rows."""
    return np.array(rows, dtype=np.int64).reshape(-1, columns)


class Packer:
    """Collects numbers, histories, kernels and matrix blocks of all pieces, in the order of declaration."""

    def __init__(self, pieces: Pieces, number: Numbering) -> None:
        self.pieces = pieces
        self.number = number
        self.p: list[float] = []
        self.z: list[float] = []
        self.kernels = {name: KernelList() for name in KINDS}
        self.element_blocks, self.contact_blocks = Blocks(), Blocks()
        self.g_blocks, self.h_blocks = Blocks(), Blocks()
        for target, group in ((self.element_blocks, pieces.elements), (self.contact_blocks, pieces.contacts)):
            for piece in group:
                unknowns = number.unknowns(piece.coordinates)
                target.add(unknowns, unknowns)
        row = number.n_q
        for constraint in pieces.constraints:
            unknowns = number.unknowns(constraint.coordinates)
            self.g_blocks.add(range(row, row + constraint.rows), unknowns)
            self.h_blocks.add(unknowns, unknowns)
            row += constraint.rows
        self.n_c = row - number.n_q

    def pattern(self) -> tuple[np.ndarray, np.ndarray]:
        """Rows and columns of all structural nonzeros, without those of the ground."""
        groups = (self.element_blocks, self.contact_blocks, self.g_blocks, self.h_blocks)
        rows = np.concatenate([g.arrays[0] for g in groups])
        columns = np.concatenate([g.arrays[1] for g in groups])
        inside = (rows >= 0) & (columns >= 0)
        return rows[inside], columns[inside]

    def add(self, values: Iterable[float]) -> Bounds:
        """Append numbers of a part; where they begin and end."""
        begin = len(self.p)
        self.p.extend(values)
        return begin, len(self.p)

    def remember(self, values: Iterable[float]) -> Bounds:
        """Append start values of a history; where they begin and end."""
        begin = len(self.z)
        self.z.extend(values)
        return begin, len(self.z)

    def elements(self, positions) -> Elements:
        """Arrays of the elements; `positions` maps rows and columns to places in the factored matrix."""
        pieces = self.pieces.elements
        dofs = Ragged()
        for piece in pieces:
            dofs.add(self.number.dofs(piece.coordinates))
        factors = [piece.factor for piece in pieces]
        # what is never called is not compiled
        slow = [None if piece.is_complete else piece for piece in pieces]
        return Elements(
            ints([self.kernels["element"].number(piece.kernel if piece else None) for piece in slow]),
            ints([self.kernels["energy"].number(piece.energy) for piece in pieces]),
            ints([self.kernels["motion"].number(law.kernel if law else None) for law in factors]),
            ints([self.kernels["force"].number(piece.force) for piece in pieces]),
            ints([self.kernels["tangent"].number(piece.tangent) for piece in pieces]),
            ints([self.kernels["account"].number(piece.account) for piece in pieces]),
            table([self.add(piece.p) for piece in pieces], 2),
            table([self.add(law.parameters() if law else ()) for law in factors], 2),
            table([self.remember(piece.history) for piece in pieces], 2),
            ints(dofs.offset),
            ints(self.element_blocks.offset),
            places(dofs.values),
            places(positions(*self.element_blocks.arrays)),
        )

    def constraints(self, positions, out: Sequence[int]) -> Constraints:
        """Arrays of the constraints; `out` numbers the first signal of each."""
        pieces = self.pieces.constraints
        dofs = Ragged()
        for piece in pieces:
            dofs.add(self.number.dofs(piece.coordinates))
        laws = [law for piece in pieces for law in motion_of_each_row(piece)]
        rows, columns = self.g_blocks.arrays
        return Constraints(
            ints([self.kernels["constraint"].number(piece.kernel) for piece in pieces]),
            ints([self.kernels["motion"].number(law.kernel if law else None) for law in laws]),
            table([self.add(piece.p) for piece in pieces], 2),
            table([self.add(law.parameters() if law else ()) for law in laws], 2),
            ints(np.cumsum([0, *(piece.rows for piece in pieces)])),
            ints(dofs.offset),
            ints(self.g_blocks.offset),
            ints(self.h_blocks.offset),
            places(dofs.values),
            places(positions(rows, columns)),
            places(positions(columns, rows)),
            places(positions(*self.h_blocks.arrays)),
            table([places_of_second(piece) for piece in pieces], 3),
            ints([piece.moment_row for piece in pieces]),
            ints(out),
            ints([len(force_signals(piece)) for piece in pieces]),
            *self.grips(pieces),
        )

    def grips(self, pieces: Sequence[ConstraintPiece]) -> tuple[np.ndarray, ...]:
        """Kernels, numbers, histories and arms of friction in ideal joints."""
        kernel, p, z, arm = [], [], [], []
        for piece in pieces:
            grip = piece.grip
            law = grip.friction if grip else None
            parts = (("grip", grip.kernel if grip else None), ("friction", law.kernel if law else None))
            kernel.append([self.kernels[kind].number(k) for kind, k in parts])
            p.append([*self.add(grip.p if grip else ()), *self.add(law.parameters() if law else ())])
            z.append(self.remember(law.history() if law else ()))
            arm.append(grip.arm if grip else 1.0)
        return table(kernel, 2), table(p, 4), table(z, 2), np.array(arm, dtype=float).reshape(-1)

    def contacts(self, positions, out: Sequence[int]) -> Contacts:
        """Arrays of the contacts; `out` numbers the first signal of each."""
        kernel, p, z, dofs = [], [], [], []
        for piece in self.pieces.contacts:
            parts = (("gap", piece.gap), ("normal", piece.normal.kernel), ("friction", piece.friction.kernel))
            kernel.append([self.kernels[kind].number(k) for kind, k in parts])
            values = (piece.p, piece.normal.parameters(), piece.friction.parameters())
            p.append([b for v in values for b in self.add(v)])
            histories = ((0.0,) * CONTACT_COMMON, piece.normal.history(), piece.friction.history())
            bounds = [self.remember(h) for h in histories]
            z.append([*(b for b, _ in bounds), bounds[-1][1]])
            dofs.extend(self.number.dofs(piece.coordinates))
        positions = places(positions(*self.contact_blocks.arrays))
        return Contacts(table(kernel, 3), table(p, 6), table(z, 4), places(dofs), positions, ints(out))

    def measured(self, out: Sequence[int]) -> Measured:
        """Arrays of the signals computed by kernels."""
        pieces = self.pieces.signals
        dofs = Ragged()
        for piece in pieces:
            dofs.add(self.number.dofs(piece.coordinates))
        return Measured(
            ints([self.kernels["signal"].number(piece.kernel) for piece in pieces]),
            table([self.add(piece.p) for piece in pieces], 2),
            ints(dofs.offset),
            ints(dofs.values),
            ints(out),
            ints([place for piece, place in zip(pieces, out, strict=True) if piece.is_mode]),
        )


KINDS = (
    *("element", "energy", "constraint", "motion", "gap", "normal", "friction", "grip", "signal"),
    *("force", "tangent", "account"),
)
"""Kinds of kernels, in the order of `Addresses`."""


def motion_of_each_row(piece: ConstraintPiece) -> list[Motion | None]:
    """The motions of a constraint, None for rows without."""
    given = {driven.row: driven.motion for driven in piece.motions}
    return [given.get(row) for row in range(piece.rows)]


def places_of_second(piece: ConstraintPiece) -> list[int]:
    """Where x, y, theta of the second body stand among the piece's coordinates."""
    if piece.second is None:
        return [-1, -1, -1]
    places: dict[Coordinate, int] = {c: i for i, c in enumerate(piece.coordinates)}
    return [places[c] for c in piece.second]
