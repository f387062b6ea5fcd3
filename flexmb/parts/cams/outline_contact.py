"""Contact of outlines with corners: with circles of other bodies, and with their outlines."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import KW_ONLY
from typing import Any, ClassVar

import numpy as np

from flexmb import checks
from flexmb.errors import InputError, ModelError
from flexmb.fields import field, instance, record
from flexmb.model.contributions import ContactContribution, Contribution, Node
from flexmb.model.law import FRICTION_LAW, NORMAL_LAW, FrictionLaw, NormalLaw
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import Part, refuse_one_body
from flexmb.model.shape import Shapes
from flexmb.parts.cams.curve_on_curve import TOLERANCE_LENGTH, carriers, in_frame, pair_shapes, signed_distance
from flexmb.parts.cams.curves import CircularCurve
from flexmb.parts.cams.outline import Outline, RoundArc, rounds
from flexmb.parts.cams.outline_kernels import PART, PART_WITHOUT_START, WHOLE, outline_gap_kernel, round_gap_kernel
from flexmb.parts.cams.spans import meeting
from flexmb.parts.contact.friction import Frictionless


# Contact of an outline of one body with a circle of another: pin in a Geneva wheel, pawl and ratchet, roller
@record
class OutlineContact(Part):
    """Contact between an outline of the first body and a circle of the second, on the outside of both.

    Signals: as of a contact (see `RevoluteClearance`; ex, ey from the outline to the circle).  An outline with hollow
    corners has one contact between two such corners, `name.side1`, `name.side2`, ...; one without them a single one.

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
    Bodies start and move as declared.  A law made from materials has the stiffness of the circle against a flat side.
    """

    first: Part = field("body with the outline")
    outline: Outline = field("its outline", rule=instance(Outline, "of the kind Outline"))
    second: Part = field("body with the circle")
    circle: CircularCurve = field("its circle", rule=instance(CircularCurve, "of the kind CircularCurve"))
    _: KW_ONLY
    normal: NormalLaw = field("law of the normal force", rule=NORMAL_LAW)
    friction: FrictionLaw = field("law of friction", rule=FRICTION_LAW, default_factory=Frictionless)
    names: Mapping[str, str] = field('of contacts, e.g. {"side1": "slot"}', default_factory=dict)

    lost_beyond: ClassVar[float] = 0.9
    """Penetration over `pin_radius` beyond which the circle is lost: a side sees nothing behind it."""

    def __post_init__(self) -> None:
        super().__post_init__()
        refuse_one_body(self)
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
            text = f"{self.label}: circle and outline overlap by {-gap:.4g} m in the reference configuration."
            raise ModelError(f"{text} Move one of them apart; both are given in the reference configuration.")

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        """One contact for each chain of pieces between hollow corners."""
        nodes, coordinates = carriers(mechanism, self)
        centre, chains = in_frame(nodes[1], self.circle.centre), self.outline.chains()
        head = TOLERANCE_LENGTH * self.outline.size, *centre, self.circle.radius
        hollow, normal = self.outline.hollow_corners(), self.normal.for_radii(math.inf, self.circle.radius)
        found = []
        for number, chain in enumerate(chains, 1):
            extent = PART if chain[0] in hollow else (PART_WITHOUT_START if hollow else WHOLE)
            pieces = [x for k in chain for x in piece_numbers(self.outline, k, nodes[0])]
            p = (*head, extent, float(len(chain)), *pieces)
            side = f"side{number}" if hollow else ""
            name = self.names.get(side, side)
            laws = normal, self.friction, name
            found.append(ContactContribution(self.name, outline_gap_kernel, coordinates, p, *laws))
        return found

    def shapes(self, mechanism: Mechanism) -> Shapes:
        return pair_shapes(mechanism, self, self.outline, self.circle)


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


# Contact of two outlines of two bodies: pawl and ratchet, blocks, wheels with slots, cams of lines and arcs

MOST_CONTACTS = 256  # largest number of contacts of a pair


@record
class OutlineOnOutline(Part):
    """Contact of two outlines of two bodies, on the outside of both, at as many places as touch.

    Each round of one outline has a contact with the other outline.  A round is a run of convex arcs and corners between
    straight or hollow pieces: a square has four, a circle one.  `places` tells their names and places: first1, first2,
    ... of the first outline, second1, ... of the second.  A round with arcs has a contact with each chain between two
    hollow corners of the other outline, `second1_side1`, ...

    Signals: as of a contact (see `RevoluteClearance`; ex, ey from the first outline to the second), of each contact, as
    `name.second1.normal_force`.

    Raises
    ------
    InputError : no outlines, a name for a contact that is none, laws of the wrong kind, a law whose stiffness depends
        on radii, more than 256 contacts.
    ModelError : a body with itself, a flexible body, outlines that overlap in the reference configuration.

    Notes
    -----
    The gap of a round is the least signed distance of its points from the other outline, exact for lines, arcs and
    corners.  Two rounds that touch are one contact, of the first outline if that is all arcs and of the second one
    otherwise.  Gap and normal are continuous along pieces that join without a corner.  Where a round of the other
    outline leaves a straight piece of this one for an arc, the contact goes on under another name, with a new history.
    Two corners that overlap touch the sides of one another.  A body may overlap by less than half its own thickness.
    Sides of many short lines have a contact at each corner; draw them as arcs (`bulges`, `Outline.from_curve`).
    Bodies start and move as declared.
    """

    first: Part = field("first body")
    first_outline: Outline = field("its outline", rule=instance(Outline, "of the kind Outline"))
    second: Part = field("second body")
    second_outline: Outline = field("its outline", rule=instance(Outline, "of the kind Outline"))
    _: KW_ONLY
    normal: NormalLaw = field("law of the normal force, with a stiffness of its own", rule=NORMAL_LAW)
    friction: FrictionLaw = field("law of friction", rule=FRICTION_LAW, default_factory=Frictionless)
    names: Mapping[str, str] = field('of contacts, e.g. {"side1": "slot"}', default_factory=dict)

    lost_beyond: ClassVar[float] = 0.45
    """Penetration over the size beyond which a body is lost: at half of its half height another side may be nearer."""

    def __post_init__(self) -> None:
        super().__post_init__()
        refuse_one_body(self)
        try:
            self.normal.parameters()
        except InputError as error:
            raise InputError(
                f"{self.label}: the stiffness of {type(self.normal).__name__} depends on radii, which corners have "
                "not. Give a law with a stiffness of its own, e.g. HuntCrossley or KelvinVoigt."
            ) from error
        rounds_of = [(name, chains) for name, _, _, chains in self._contacts()]
        labels = [_label(name, side, chains) for name, chains in rounds_of for side, _ in enumerate(chains, 1)]
        check_names(self, labels)
        if (count := len(labels)) > MOST_CONTACTS:
            raise InputError(
                f"{self.label}: the outlines have {count} contacts, more than {MOST_CONTACTS}. Draw curved sides as "
                "arcs (bulges, Outline.from_curve) in place of many short lines, or leave out what never touches."
            )

    @property
    def half_height(self) -> float:
        """Half of the least extent of both outlines [m], beside which penetrations are judged."""
        return 0.5 * min(float(np.ptp(o.polygon, axis=0).min()) for o in (self.first_outline, self.second_outline))

    def _contacts(self) -> Iterator[tuple[str, bool, list[RoundArc], list[list[int]]]]:
        """Name of each round, whether it is of the first outline, its arcs, and the chains that it may touch."""
        outlines = self.first_outline, self.second_outline
        for name, own, other in (("first", *outlines), ("second", *outlines[::-1])):
            for number, arcs in enumerate(rounds(own), 1):
                radius = max(arc.radius for arc in arcs)
                chains = other.chains(radius) if radius > 0.0 else [list(range(len(other.points)))]
                yield f"{name}{number}", name == "first", arcs, chains

    def places(self) -> dict[str, tuple[float, float]]:
        """Names of the rounds, and the middle of each in the reference configuration [m]."""
        found = {}
        for name, _, arcs, _ in self._contacts():
            arc = arcs[len(arcs) // 2]
            angle = arc.begin + 0.5 * ((arc.end - arc.begin) % (2.0 * math.pi))
            x, y = arc.at[0] + arc.radius * math.cos(angle), arc.at[1] + arc.radius * math.sin(angle)
            found[self.names.get(name, name)] = x, y
        return found

    def validate(self, mechanism: Mechanism) -> None:
        """Refuse outlines that overlap."""
        super().validate(mechanism)
        one, two = self.first_outline.polygon, self.second_outline.polygon
        size = min(self.first_outline.size, self.second_outline.size)
        depth, place = min(
            (signed_distance(polygon, point), tuple(point)) for polygon, points in ((one, two), (two, one))
            for point in points
        )  # fmt: skip
        if depth >= -TOLERANCE_LENGTH * size:
            found = meeting(one, two, TOLERANCE_LENGTH * size)
            if found is None:
                return
            place = found
        text = f" by {-depth:.4g} m" if depth < -TOLERANCE_LENGTH * size else ""
        raise ModelError(
            f"{self.label}: the outlines overlap{text} near ({place[0]:.6g}, {place[1]:.6g}) m in the reference "
            "configuration. Move one of the bodies; both outlines are given in the reference configuration."
        )

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        """One contact of each round with each chain."""
        nodes, coordinates = carriers(mechanism, self)
        owner_is_first = _is_round(self.first_outline) and not _is_round(self.second_outline)
        size = min(self.first_outline.size, self.second_outline.size)
        found = []
        for label, is_first, arcs, chains in self._contacts():
            own, seen = nodes if is_first else (nodes[1], nodes[0])
            outline = self.second_outline if is_first else self.first_outline
            turning = [number for arc in arcs for number in _arc_numbers(arc, own)]
            pieces = [piece_numbers(outline, k, seen) for k in range(len(outline.points))]
            for side, chain in enumerate(chains, 1):
                order = [*chain, *(k for k in range(len(pieces)) if k not in chain)]
                flags = float(is_first), float(is_first == owner_is_first)
                counts = float(len(arcs)), float(len(chain)), float(len(pieces))
                p = (TOLERANCE_LENGTH * size, *flags, *counts, *turning, *(x for k in order for x in pieces[k]))
                name = _label(label, side, chains)
                own_name, laws = self.names.get(name, name), (self.normal, self.friction)
                found.append(ContactContribution(self.name, round_gap_kernel, coordinates, p, *laws, own_name))
        return found

    def shapes(self, mechanism: Mechanism) -> Shapes:
        return pair_shapes(mechanism, self, self.first_outline, self.second_outline)


def _label(name: str, side: int, chains: list[list[int]]) -> str:
    """Name of the contact of a round with one of the chains."""
    return f"{name}_side{side}" if len(chains) > 1 else name


def _is_round(outline: Outline) -> bool:
    """Whether an outline consists of convex arcs alone."""
    return all(bulge > 0.0 for bulge in outline.bulges)


def _arc_numbers(arc: RoundArc, node: Node) -> tuple[float, ...]:
    """Numbers of an arc of a round in the frame of a node, see `outline_kernels`."""
    begin, end = arc.begin - node.theta, arc.end - node.theta
    normals = math.cos(begin), math.sin(begin), math.cos(end), math.sin(end)
    return (*in_frame(node, arc.at), arc.radius, *normals, arc.kind)
