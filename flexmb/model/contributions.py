"""Contributions of parts to a program: nodes, elements, constraints, contacts, signals, controls.

A part describes itself to the compiler (room `program`) by these records alone.
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
    """Node of a body in the reference configuration: position [m], angle [rad]; `name` is "" for a single node."""

    name: str
    x: float
    y: float
    theta: float


@dataclass(frozen=True)
class Attachment:
    """Point of attachment on a body: node, and offset in the frame of the node [m]."""

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
class ElementContribution:
    """An element: force, inertia or both on some coordinates; `energy` is the kernel of its energies, or None.

    The kernels `force`, `tangent` and `account` give the same results at less cost (see `flexmb.kernels`); each may be
    None.  The work of an element without `energy` counts as that of a load; it has no `account`.

    The value of `factor` at the present time multiplies all results of the kernel: a load that changes in time.  Such a
    force has no potential, hence no `energy`; its work counts as that of a load.
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
        """Whether the element has all three kernels at less cost."""
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
    """Prescribed motion of one constraint equation, subtracted from it; `name` distinguishes the rows of a part.

    The only driven row of a part has the name "".  `units` : of the driven coordinate and of its force.
    """

    row: int
    motion: Motion
    name: str = ""
    units: tuple[str, str] = ("rad", "N m")


@dataclass(frozen=True)
class JointFriction:
    """Friction in an ideal joint of two nodes: kernel of normal load and direction of sliding, and friction law.

    signal : name and unit of the reported friction;  arm : reported friction over the force T of the law
    """

    kernel: Kernel
    p: tuple[float, ...]
    friction: FrictionLaw
    signal: tuple[str, str] = ("friction_force", "N")
    arm: float = 1.0


@dataclass(frozen=True)
class Reaction:
    """Reported force or moment of one constraint equation: minus factor times multiplier, or its power.

    Parameters
    ----------
    name, units : of the signal.
    row : number of the equation.
    factor : derivative of the equation with respect to the coordinate on which the force acts.
    place : place among the coordinates of the velocity that multiplies the force, for a power; -1: none.
    """

    name: str
    units: str
    row: int
    factor: float = 1.0
    place: int = -1


@dataclass(frozen=True)
class ConstraintContribution:
    """Constraint equations g(q, t) = 0 between some coordinates.

    second : coordinates of the body on which the reported force acts
    moment_row : row whose multiplier is a moment or a drive force; -1: no such row
    motions : prescribed motions, in the order of their rows, from which they are subtracted
    is_drive : whether the constraint reports motions and no force
    joint_friction : friction that depends on the multipliers
    reactions : reported forces in place of those on a second body
    holds : "always"; "closed" in place of a contact (at the start, for modes, for inverse dynamics); "start" in place
        of an elastic joint, while start values are computed
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
    joint_friction: JointFriction | None = None
    holds: str = "always"
    reactions: tuple[Reaction, ...] = ()


@dataclass(frozen=True)
class ContactContribution:
    """Unilateral contact of two nodes: gap kernel, normal law, friction law; p begins with the clearance [m].

    `name` distinguishes the contacts of a part; the only contact of a part has the name "".
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
        """Prefix of its signals."""
        return f"{self.part}.{self.name}" if self.name else self.part


@dataclass(frozen=True)
class SignalContribution:
    """Signal computed from coordinates at every step, reported as `part.name`.

    is_mode : whether the values number states, so that an instant within a step takes the value of the nearer end
    """

    part: str
    name: str
    units: str
    kernel: Kernel
    coordinates: tuple[Coordinate, ...]
    p: tuple[float, ...] = ()
    is_mode: bool = False


@dataclass(frozen=True)
class MotionInput:
    """Input of a control: the value of a motion at the present time, or its rate."""

    motion: Motion
    rate: bool = False


@dataclass(frozen=True)
class ControlContribution:
    """Control law: inputs, own states, and outputs, of which the first are the factors of loads.

    inputs : names of signals, and motions
    loads : names of parts with one element each, whose factors are the first outputs
    states, start : names and start values of the own states
    outputs : names of all outputs
    sample : time between two instants at which states and outputs change [s]; None: at all times
    state_units, output_units : units of both
    settled : numbers of the states that begin where their rates are 0, and not at `start`
    """

    part: str
    kernel: Kernel
    p: tuple[float, ...]
    inputs: tuple[str | MotionInput, ...]
    loads: tuple[str, ...]
    outputs: tuple[str, ...]
    states: tuple[str, ...] = ()
    start: tuple[float, ...] = ()
    sample: float | None = None
    state_units: tuple[str, ...] = ()
    output_units: tuple[str, ...] = ()
    settled: tuple[int, ...] = ()

    @property
    def label(self) -> str:
        """Part, as messages show it."""
        return f"Controller {self.part!r}"

    @property
    def is_sampled(self) -> bool:
        """Whether the outputs change at instants alone."""
        return self.sample is not None

    @property
    def state_names(self) -> tuple[str, ...]:
        """Names of the states."""
        return self.states


Contribution = (
    ElementContribution | ConstraintContribution | ContactContribution | SignalContribution | ControlContribution
)


@dataclass(frozen=True)
class Contributions:
    """All contributions to a mechanism, by kind and in the order of declaration."""

    elements: tuple[ElementContribution, ...] = ()
    constraints: tuple[ConstraintContribution, ...] = ()
    contacts: tuple[ContactContribution, ...] = ()
    signals: tuple[SignalContribution, ...] = field(default=())
    controls: tuple[ControlContribution, ...] = ()

    @staticmethod
    def sort(contributions: list[Contribution]) -> Contributions:
        """Sort contributions by kind."""
        return Contributions(
            tuple(p for p in contributions if isinstance(p, ElementContribution)),
            tuple(p for p in contributions if isinstance(p, ConstraintContribution)),
            tuple(p for p in contributions if isinstance(p, ContactContribution)),
            tuple(p for p in contributions if isinstance(p, SignalContribution)),
            tuple(p for p in contributions if isinstance(p, ControlContribution)),
        )
