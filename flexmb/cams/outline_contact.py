"""Contact of an outline of one body with a circle of another: pin in a Geneva wheel, pawl and ratchet, roller."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar

from flexmb import checks
from flexmb.cams.curves.line import CircularCurve
from flexmb.cams.curves.outline import Outline
from flexmb.cams.outline_kernels import PART, PART_WITHOUT_START, WHOLE, outline_gap_kernel
from flexmb.cams.packing import TOLERANCE_LENGTH, carriers, in_frame, pair_shapes, signed_distance
from flexmb.contact.friction.frictionless import Frictionless
from flexmb.errors import InputError, ModelError
from flexmb.joints.revolute_clearance import check_laws
from flexmb.model.contributions import ContactContribution, Contribution, Node
from flexmb.model.law import FrictionLaw, NormalLaw
from flexmb.model.part import Part
from flexmb.model.shape import Shapes

if TYPE_CHECKING:
    from flexmb.model.mechanism import Mechanism


@dataclass(frozen=True)
class OutlineContact(Part):
    """Contact between an outline of the first body and a circle of the second, on the outside of both.

    Signals: as of a contact (see `RevoluteClearance`; ex, ey from the outline to the circle).  An outline with hollow
    corners has one contact between two such corners, `name.side1`, `name.side2`, ...; one without them a single one.

    Parameters
    ----------
    name : name of the contact.
    first : the body with the outline.
    outline : its outline, in the reference configuration.
    second : the body with the circle.
    circle : its circle, in the reference configuration.
    normal : law of the normal force; made from materials, it has the stiffness of the circle against a flat side.
    friction : law of friction; left out: frictionless.
    names : names of your own for contacts in place of side1, ..., e.g. names={"side1": "slot"}.

    Raises
    ------
    InputError : no outline, no circle, a name for a contact that is none, laws of the wrong kind, a circle that does
        not fit into a hollow arc.
    ModelError : a body with itself, a flexible body, a circle that overlaps the outline in the reference configuration.

    Notes
    -----
    The distance is exact for lines, arcs and corners.  Each contact has its own history and touches at its nearest
    point, so a circle in a hollow corner has two.  A pin in a slot touches one side at a time, which needs a slot wider
    than the pin.  With hollow corners the centre of the circle must stay outside: an overlap is less than its radius.
    Bodies start and move as declared.
    """

    first: Part
    outline: Outline
    second: Part
    circle: CircularCurve
    _: KW_ONLY
    normal: NormalLaw
    friction: FrictionLaw = field(default_factory=Frictionless)
    names: Mapping[str, str] = field(default_factory=dict)

    lost_beyond: ClassVar[float] = 0.9
    """Penetration over `pin_radius` beyond which the circle is lost: a side sees nothing behind it."""

    def __post_init__(self) -> None:
        super().__post_init__()
        check_outlines(self, outline=Outline, circle=CircularCurve)
        chains = self.outline.chains() if self.outline.hollow_corners() else []
        check_names(self, [f"side{number}" for number, _ in enumerate(chains, 1)])
        for k, (x, y) in enumerate(self.outline.points):
            radius = self.outline.radius(k)
            if -self.circle.radius <= radius < 0.0:
                raise InputError(
                    f"{self.label}: the circle of radius {self.circle.radius:g} m does not fit into the hollow arc "
                    f"from ({x:.6g}, {y:.6g}) m, whose radius is {-radius:g} m. Use a smaller circle, or a wider arc."
                )

    @property
    def pin_radius(self) -> float:
        """Radius of the circle [m], beside which penetrations are judged."""
        return self.circle.radius

    def validate(self, mechanism: Mechanism) -> None:
        """Refuse a circle inside the outline."""
        super().validate(mechanism)
        gap = signed_distance(self.outline.polygon, self.circle.centre) - self.circle.radius
        if gap < -TOLERANCE_LENGTH * self.outline.size:
            raise ModelError(
                f"{self.label}: circle and outline overlap by {-gap:.4g} m in the reference configuration. Move one of "
                "them apart; both are given in the reference configuration."
            )

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        """One contact for each chain of pieces between hollow corners."""
        nodes, coordinates = carriers(mechanism, self)
        centre, chains = in_frame(nodes[1], self.circle.centre), self.outline.chains()
        head = TOLERANCE_LENGTH * self.outline.size, *centre, self.circle.radius
        hollow, normal = self.outline.hollow_corners(), self.normal.for_radii(math.inf, self.circle.radius)
        found = []
        for number, chain in enumerate(chains, 1):
            extent = PART if chain[0] in hollow else (PART_WITHOUT_START if hollow else WHOLE)
            p = (
                *head,
                extent,
                float(len(chain)),
                *(x for k in chain for x in piece_numbers(self.outline, k, nodes[0])),
            )
            side = f"side{number}" if hollow else ""
            name = self.names.get(side, side)
            found.append(
                ContactContribution(self.name, outline_gap_kernel, coordinates, p, normal, self.friction, name)
            )
        return found

    def shapes(self, mechanism: Mechanism) -> Shapes:
        """Outline and circle."""
        return pair_shapes(mechanism, self, self.outline, self.circle)


def check_outlines(part: Any, **kinds: type) -> None:
    """Check bodies and laws of a contact, and the kinds of its outlines by the names of their fields."""
    if part.first.name == part.second.name:
        raise ModelError(f"{part.label} joins {part.first.name!r} to itself; give two different bodies.")
    check_laws(part)
    for name, kind in kinds.items():
        if not isinstance(getattr(part, name), kind):
            raise InputError(
                f"{part.label}: {name} is {getattr(part, name)!r}; it must be of the kind {kind.__name__}."
            )


def check_names(part: Any, contacts: Iterable[str]) -> None:
    """Check the user's names of contacts (`part.names`): each for one of `contacts`, and no name twice."""
    given = checks.mapping(part.label, "names", part.names)
    known = list(contacts)
    for contact, name in given.items():
        if contact not in known:
            text = f"{part.label}: names has {contact!r}, which is no contact of it."
            raise InputError(f"{text} Contacts: {', '.join(known) or 'a single one, which has the name of the part'}.")
        checks.identifier(f"{part.label}: names[{contact!r}]", name)
    final = [given.get(contact, contact) for contact in known]
    if twice := sorted({name for name in final if final.count(name) > 1}):
        raise InputError(f"{part.label}: two contacts have the name {twice[0]!r}. Give each a name of its own.")


def piece_numbers(outline: Outline, k: int, node: Node) -> tuple[float, ...]:
    """Numbers of a piece in the frame of a node, see `outline_kernels`."""
    n = len(outline.points)
    before, after = (k - 1) % n, (k + 1) % n
    ends = *in_frame(node, outline.points[k]), *in_frame(node, outline.points[after])
    begin = _mean_normal(outline.directions(before)[1], outline.directions(k)[0], node)
    end = _mean_normal(outline.directions(k)[1], outline.directions(after)[0], node)
    return (*ends, *in_frame(node, outline.centre(k)), outline.radius(k), *begin, *end)


def _mean_normal(a: tuple[float, float], b: tuple[float, float], node: Node) -> tuple[float, float]:
    """Unit outward normal between two directions of the outline, in the frame of a node."""
    angle = math.atan2(-a[0] - b[0], a[1] + b[1]) - node.theta
    return math.cos(angle), math.sin(angle)
