"""What parts are made of, as the compiler sees them: nodes, elements, constraints, contacts, measured signals.

A part hands these records to the compiler (floor 3), which knows no other language.
Coordinates are named (part, node, axis) with axis 0, 1, 2 for x, y, theta.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from flexmb.errors import KernelError
from flexmb.kernels import Kernel

if TYPE_CHECKING:
    from flexmb.model.law import FrictionLaw, Motion, NormalLaw

Coordinate = tuple[str, str, int]
AXES = ("x", "y", "theta")


@dataclass(frozen=True)
class Node:
    """A planar node of a body in the drawn pose: position [m] and angle [rad]; `name` is "" for a lone node."""

    name: str
    x: float
    y: float
    theta: float


@dataclass(frozen=True)
class Attachment:
    """Where something holds a body: the node and the offset in the frame of the node [m]."""

    part: str
    node: str
    offset: tuple[float, float]

    @property
    def coordinates(self) -> tuple[Coordinate, Coordinate, Coordinate]:
        """The three coordinates of the node."""
        return node_coordinates(self.part, self.node)


def node_coordinates(part: str, node: str) -> tuple[Coordinate, Coordinate, Coordinate]:
    """x, y and theta of a node."""
    return (part, node, 0), (part, node, 1), (part, node, 2)


@dataclass(frozen=True)
class ElementPiece:
    """A force, inertia or both on some coordinates; `energy` is its kernel of energies, if it keeps account.

    `force`, `tangent` and `account` say parts of the same at less cost (see `flexmb.kernels`); each may be left out.
    An element without energies has no account: its work is that of a load.

    With a `factor` all that the kernel gives is multiplied by its value at the time: a load that changes in time.  Such
    a force has no potential, so it has no `energy`; its work is counted as that of a load.
    """

    part: str
    kernel: Kernel
    coordinates: tuple[Coordinate, ...]
    p: tuple[float, ...]
    history: tuple[float, ...] = ()
    energy: Kernel | None = None
    factor: Motion | None = None
    force: Kernel | None = None
    tangent: Kernel | None = None
    account: Kernel | None = None

    @property
    def is_complete(self) -> bool:
        """Whether the other kernels say all that element and energy kernel do."""
        return None not in (self.force, self.tangent, self.account)

    def __post_init__(self) -> None:
        if self.account is not None and self.energy is None:
            raise KernelError(
                f"Part {self.part!r}: kernel {self.kernel.name!r} has an account kernel and no energy kernel. Give it "
                "the energy kernel, too; or leave the account kernel out: the work is counted as that of a load."
            )
        if self.factor is not None and self.energy is not None:
            raise KernelError(
                f"Part {self.part!r}: kernel {self.kernel.name!r} has a factor in time and an energy kernel; what "
                "changes in time keeps no energy. Leave the energy kernel out: the work is counted as that of a load."
            )


@dataclass(frozen=True)
class RowMotion:
    """A motion that is subtracted from one row of a constraint; `name` tells the driven rows of a part apart.

    The part's only driven row has the name "".  `units` are those of the driven coordinate and of its force.
    """

    row: int
    motion: Motion
    name: str = ""
    units: tuple[str, str] = ("rad", "N m")


@dataclass(frozen=True)
class Grip:
    """Friction in an ideal joint of two nodes: what presses the surfaces together and which way they slide.

    `units` are those of the reported friction and of the slip; `arm` is what the force T of the law is multiplied by to
    become the reported friction.
    """

    kernel: Kernel
    p: tuple[float, ...]
    friction: FrictionLaw
    signal: tuple[str, str] = ("friction_force", "N")
    arm: float = 1.0


@dataclass(frozen=True)
class ConstraintPiece:
    """Rows g(q, t) = 0 between some coordinates.

    `second` is the body on which the reported force acts; `moment_row` the row whose multiplier is a moment or a
    drive force, or -1; `motions` are subtracted from their rows, which they name in increasing order; `grip` adds
    friction that depends on the multipliers.  A piece that `is_drive` reports motions and no force.  It `holds`
    "always"; or "closed", where it stands for a contact: at the start, for modes, for inverse dynamics; or at the
    "start" alone, where it stands for an elastic joint.
    """

    part: str
    kernel: Kernel
    coordinates: tuple[Coordinate, ...]
    p: tuple[float, ...]
    rows: int
    second: tuple[Coordinate, Coordinate, Coordinate] | None = None
    moment_row: int = -1
    motions: tuple[RowMotion, ...] = ()
    is_drive: bool = False
    drive_units: tuple[str, str] = ("rad", "N m")
    grip: Grip | None = None
    holds: str = "always"


@dataclass(frozen=True)
class ContactPiece:
    """A unilateral contact: gap x normal law x friction law between two nodes; p begins with the clearance.

    `name` tells the contacts of a part apart; a part's only one has the name "".
    """

    part: str
    gap: Kernel
    coordinates: tuple[Coordinate, ...]
    p: tuple[float, ...]
    normal: NormalLaw
    friction: FrictionLaw
    name: str = ""

    @property
    def label(self) -> str:
        """What its signals begin with."""
        return f"{self.part}.{self.name}" if self.name else self.part


@dataclass(frozen=True)
class SignalPiece:
    """A quantity computed from coordinates at every step, reported as `part.name`.

    is_mode : it numbers states, between which nothing lies: an instant inside a step has that of the nearer end.
    """

    part: str
    name: str
    units: str
    kernel: Kernel
    coordinates: tuple[Coordinate, ...]
    p: tuple[float, ...] = ()
    is_mode: bool = False


Piece = ElementPiece | ConstraintPiece | ContactPiece | SignalPiece


@dataclass(frozen=True)
class Pieces:
    """All pieces of a mechanism, by kind and in the order of declaration."""

    elements: tuple[ElementPiece, ...] = ()
    constraints: tuple[ConstraintPiece, ...] = ()
    contacts: tuple[ContactPiece, ...] = ()
    signals: tuple[SignalPiece, ...] = field(default=())

    @staticmethod
    def sort(pieces: list[Piece]) -> Pieces:
        """The pieces by kind."""
        return Pieces(
            tuple(p for p in pieces if isinstance(p, ElementPiece)),
            tuple(p for p in pieces if isinstance(p, ConstraintPiece)),
            tuple(p for p in pieces if isinstance(p, ContactPiece)),
            tuple(p for p in pieces if isinstance(p, SignalPiece)),
        )
