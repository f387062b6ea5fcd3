"""Contributions of parts to a program: nodes, elements, constraints, contacts, signals, controls.

A part describes itself to the compiler (room `program`) by these records alone.
Coordinates are named (part, node, axis) with axis 0, 1, 2 for x, y, theta.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple, get_args

from flexmb.errors import KernelError
from flexmb.fields import field, record
from flexmb.kernels import Kernel

if TYPE_CHECKING:
    from flexmb.model.law import FrictionLaw, Motion, NormalLaw

Coordinate = tuple[str, str, int]
AXES = ("x", "y", "theta")
# Uses of the factor of a part's element in a signal of the part.
USES_OF_FACTOR = MULTIPLIES, ADDS, SUBTRACTS = "multiplies", "adds", "subtracts"


@dataclass(frozen=True)
class Node:
    """Node in the reference configuration; a single one has the name "".  `turns`: theta turns with the body."""

    name: str
    x: float
    y: float
    theta: float
    turns: bool = True


@record
class Attachment:
    """Point of attachment on a body."""

    part: str = field("name of the body")
    node: str = field("its node")
    offset: tuple[float, float] = field("the point in the frame of the node", "m")

    @property
    def place(self) -> tuple[str, str, tuple[float, float]]:
        """Body, node and offset, as shapes hold them."""
        return self.part, self.node, self.offset

    @property
    def coordinates(self) -> tuple[Coordinate, Coordinate, Coordinate]:
        """The three coordinates of the node."""
        return node_coordinates(self.part, self.node)


class Ends(NamedTuple):
    """Points of attachment of a part on its first and on its second body."""

    first: Attachment
    second: Attachment

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """The six coordinates of both nodes."""
        first, second = self
        return (*node_coordinates(first.part, first.node), *node_coordinates(second.part, second.node))

    @property
    def offsets(self) -> tuple[float, float, float, float]:
        """Both points in the frames of their nodes [m]."""
        return (*self.first.offset, *self.second.offset)


def node_coordinates(part: str, node: str) -> tuple[Coordinate, Coordinate, Coordinate]:
    """x, y and theta of a node."""
    return (part, node, 0), (part, node, 1), (part, node, 2)


@dataclass(frozen=True)
class ElementContribution:
    """An element: force, inertia or both on some coordinates; `energy` is the kernel of its energies, or None."""

    # The kernels `force`, `tangent`, `account` and `damping` give the same results at less cost (see `flexmb.kernels`);
    # each may be None. The work of an element without `energy` counts as that of a load; it has none of the last two.
    # The value of `factor` at the present time multiplies all results of the kernel: a load that changes in time. Such
    # a force has no potential, hence no `energy`; its work counts as that of a load.
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
    damping: Kernel | None = None
    diagonal: bool = False  # whether K, C and M have a diagonal alone
    # whether it is a rigid mass at a node, p = (mass, inertia, gravity x, y): the loops know it by the kernel of flexmb
    is_mass: bool = False
    # `force`, `tangent`, `account`, `damping` of this element and the next three, see `flexmb.engine.compiled.lanes`
    fours: tuple[Kernel, ...] = ()

    @property
    def short_ways(self) -> tuple[Kernel | None, ...]:
        """The kernels at less cost."""
        return self.force, self.tangent, self.account, self.damping

    @property
    def is_complete(self) -> bool:
        """Whether the element has all three kernels at less cost."""
        return self.force is not None and self.tangent is not None and self.account is not None

    def __post_init__(self) -> None:
        if (self.account or self.damping) is not None and self.energy is None:
            kind = "an account" if self.account else "a damping"
            text = f"Part {self.part!r}: kernel {self.kernel.name!r} has {kind} kernel and no energy kernel."
            text += " Give it the energy kernel, too;"
            raise KernelError(f"{text} or leave this kernel out: the work is counted as that of a load.")
        if self.factor is not None and self.energy is not None:
            text = f"Part {self.part!r}: kernel {self.kernel.name!r} has a factor in time and an energy kernel;"
            text += " what changes in time keeps no energy."
            raise KernelError(f"{text} Leave the energy kernel out: the work is counted as that of a load.")


class ElementKernels(NamedTuple):
    """Kernels of an element by their contracts, see `flexmb.kernels`."""

    element: Kernel
    energy: Kernel
    force: Kernel
    tangent: Kernel | None
    account: Kernel
    damping: Kernel | None = None
    fours: tuple[Kernel, ...] = ()

    def by_name(self) -> dict[str, Any]:
        """The kernels beside that of the element, as keywords of a contribution."""
        return {name: kernel for name, kernel in self._asdict().items() if name != "element"}

    def contribution(
        self, part: str, coordinates: tuple[Coordinate, ...], p: tuple[float, ...], *, diagonal: bool = False
    ) -> ElementContribution:
        """The element of a part."""
        return ElementContribution(part, self.element, coordinates, p, diagonal=diagonal, **self.by_name())


@dataclass(frozen=True)
class RowMotion:
    """Prescribed motion of one constraint equation, subtracted from it; `name` distinguishes the rows of a part."""

    # The only driven row of a part has the name "". `units` : of the driven coordinate and of its force.
    row: int
    motion: Motion
    name: str = ""
    units: tuple[str, str] = ("rad", "N m")


@dataclass(frozen=True)
class JointFriction:
    """Friction in an ideal joint of two nodes: kernel of normal load and direction of sliding, and friction law."""

    kernel: Kernel
    p: tuple[float, ...]
    friction: FrictionLaw
    # name and unit of the reported friction; "": none;  arm : reported friction over the force T of the law
    signal: tuple[str, str] = ("friction_force", "N")
    arm: float = 1.0


@record
class Reaction:
    """Reported force, moment or power of a constraint.

    The force of one equation is minus factor times its multiplier.  The force on coordinates, given by `on`, is minus
    the sum of G^T lam over these, with G at the state; so it needs no factor and holds for any equations.
    """

    name: str = field("of the signal")
    units: str = field("of the signal")
    row: int = field("number of the equation", default=0)
    factor: float = field("derivative of the equation by the coordinate on which the force acts", default=1.0)
    place: int = field("among the coordinates, of a velocity that multiplies the force, a power; -1: none", default=-1)
    rate: str = field('signal of the part, of a signal kernel, that multiplies the force; "": none', default="")
    on: tuple[int, ...] = field("coordinates whose forces are added up; empty: the force of the equation", default=())
    power: bool = field("whether each of these forces is multiplied by its velocity [W]", default=False)


@record
class ConstraintContribution:
    """Constraint equations g(q, t) = 0 between some coordinates.

    A constraint without `second`, `reactions` and `is_drive` reports its forces on each body: BODY_fx, BODY_fy [N],
    BODY_moment (about the node) [N m] and BODY_power [W], as far as it has the coordinates.
    """

    part: str = field("name of the part")
    kernel: Kernel = field("constraint kernel")
    coordinates: tuple[Coordinate, ...] = field("coordinates (part, node, axis: 0, 1, 2 for x, y, theta), each once")
    p: tuple[float, ...] = field("parameters of the kernel")
    rows: int = field("number of equations")
    second: tuple[Coordinate, ...] | None = field("coordinates of the body with the reported force", default=None)
    moment_row: int = field("row whose multiplier is a moment or a drive force; -1: no such row", default=-1)
    motions: tuple[RowMotion, ...] = field("prescribed motions, subtracted from rows in order", default=())
    is_drive: bool = field("whether the constraint reports motions and no force", default=False)
    drive_units: tuple[str, str] = field("units of the coordinate and of the force of a drive", default=("rad", "N m"))
    joint_friction: JointFriction | None = field("friction that depends on the multipliers", default=None)
    holds: str = field(
        '"always"; "closed": in place of a contact (start, modes, inverse dynamics); "start": of an elastic joint',
        default="always",
    )
    reactions: tuple[Reaction, ...] = field("reported forces in place of those on a second body", default=())
    columns: tuple[tuple[int, ...], ...] | None = field("places of coordinates of each row; None: all", default=None)
    curved: tuple[tuple[int, int], ...] | None = field("rows and columns of the entries of H; None: all", default=None)
    known: int = field("PIN, ANGLE or GUIDE of places.py: formulas that the loops know; 0: other ones", default=0)

    def __post_init__(self) -> None:
        if self.second is not None or self.reactions or self.is_drive or self.joint_friction:
            return
        found: list[Reaction] = []  # force, moment and power on each body
        for body in dict.fromkeys(part for part, _, _ in self.coordinates):
            own = [place for place, (part, _, _) in enumerate(self.coordinates) if part == body]
            for axis, (name, units) in enumerate((("fx", "N"), ("fy", "N"), ("moment", "N m"))):
                if on := tuple(place for place in own if self.coordinates[place][2] == axis):
                    found.append(Reaction(f"{body}_{name}", units, on=on))
            found.append(Reaction(f"{body}_power", "W", on=tuple(own), power=True))
        object.__setattr__(self, "reactions", tuple(found))

    @property
    def rubs_closed(self) -> bool:
        """Whether this ideal joint has the friction of the contact that it replaces; losses of teeth have none."""
        return self.holds == "closed" and self.joint_friction is not None and self.joint_friction.signal[0] != ""


@record
class ContactContribution:
    """Unilateral contact of two nodes: gap kernel, normal law, friction law."""

    part: str = field("name of the part")
    gap: Kernel = field("gap kernel")
    coordinates: tuple[Coordinate, ...] = field("x, y, theta of both nodes")
    p: tuple[float, ...] = field(
        "parameters of the gap kernel; the first one is the clearance [m], a length that errors of steps are held "
        "against, and 0 where a contact has none"
    )
    normal: NormalLaw = field("law of the normal force")
    friction: FrictionLaw = field("law of the friction force")
    name: str = field('name among the contacts of a part; "" for the only one', default="")
    period: float = field("jump of the gap where its direction has made half a turn; 0: none", "m", default=0.0)
    known: int = field("JOURNAL of places.py: a formula that the loops know; 0: other ones", default=0)

    @property
    def label(self) -> str:
        """Prefix of its signals."""
        return f"{self.part}.{self.name}" if self.name else self.part


@record
class SignalContribution:
    """Signal computed from coordinates at every step, reported as `part.name`."""

    part: str = field("name of the part")
    name: str = field("name of the signal")
    units: str = field("its unit")
    kernel: Kernel = field("signal kernel; with `place` an extremum kernel")
    coordinates: tuple[Coordinate, ...] = field("coordinates of the kernel")
    p: tuple[float, ...] = field("parameters of the kernel", default=())
    is_mode: bool = field("whether the values number states, which are not interpolated", default=False)
    use_of_factor: str = field(
        "`MULTIPLIES`: the factor of the part's element multiplies the value; `ADDS`, `SUBTRACTS`: its first "
        'parameter times its factor is added or subtracted; "": nothing',
        default="",
    )
    place: str = field('signal of the number of the place, told at the peak of this one; "": none', default="")


def signal_contributions(
    part: str, kernel: Kernel, signals: Sequence[tuple[str, str]], coordinates: tuple[Coordinate, ...],
    p: tuple[float, ...], *, behind: tuple[float, ...] = (), use_of_factor: str = "",
) -> list[SignalContribution]:  # fmt: skip
    """Signals, names with units, of one kernel, whose parameters are p, the number of the signal, and `behind`."""
    return [
        SignalContribution(part, name, unit, kernel, coordinates, (*p, float(k), *behind), use_of_factor=use_of_factor)
        for k, (name, unit) in enumerate(signals)
    ]


@dataclass(frozen=True)
class AngleContribution:
    """Relative rotation of two nodes and its rate, `part.angle` and `part.omega` of a revolute joint; no kernel."""

    part: str
    coordinates: tuple[Coordinate, Coordinate]  # rotations of the first and of the second node
    p: tuple[float]  # relative rotation in the reference configuration [rad]


@dataclass(frozen=True)
class MotionInput:
    """Input of a control: the value of a motion at the present time, or its rate."""

    motion: Motion
    rate: bool = False


@dataclass(frozen=True)
class ControlContribution:
    """Control law: inputs, own states, and outputs, of which the first are the factors of loads."""

    part: str
    kernel: Kernel
    p: tuple[float, ...]
    inputs: tuple[str | MotionInput, ...]  # names of signals, and motions
    loads: tuple[str, ...]  # names of parts with one element each, whose factors are the first outputs
    outputs: tuple[str, ...]  # names of all outputs
    states: tuple[str, ...] = ()  # names of the own states
    start: tuple[float, ...] = ()  # and their start values
    sample: float | None = None  # time between two instants at which states and outputs change [s]; None: at all times
    state_units: tuple[str, ...] = ()  # units of the states
    output_units: tuple[str, ...] = ()  # and of the outputs
    settled: tuple[int, ...] = ()  # numbers of the states that begin where their rates are 0, and not at `start`

    @property
    def label(self) -> str:
        """Part in messages."""
        return f"Controller {self.part!r}"

    @property
    def is_sampled(self) -> bool:
        """Whether the outputs change at instants alone."""
        return self.sample is not None


Contribution = (
    ElementContribution | ConstraintContribution | ContactContribution
    | SignalContribution | AngleContribution | ControlContribution
)  # fmt: skip


@dataclass(frozen=True)
class Contributions:
    """All contributions by kind and in the order of declaration; `controls` wired (`WiredControl`) in a program."""

    elements: tuple[ElementContribution, ...] = ()
    constraints: tuple[ConstraintContribution, ...] = ()
    contacts: tuple[ContactContribution, ...] = ()
    signals: tuple[SignalContribution, ...] = ()
    angles: tuple[AngleContribution, ...] = ()
    controls: tuple[Any, ...] = ()

    @staticmethod
    def sort(contributions: list[Contribution]) -> Contributions:
        """Sort contributions by kind."""
        kinds = get_args(Contribution)
        return Contributions(*[tuple([p for p in contributions if isinstance(p, kind)]) for kind in kinds])
