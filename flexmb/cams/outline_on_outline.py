"""Contact of two outlines of two bodies: pawl and ratchet, blocks, wheels with slots, cams of lines and arcs."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flexmb.cams.curves.geometry import meeting
from flexmb.cams.curves.outline import Outline
from flexmb.cams.curves.rounds import RoundArc, rounds
from flexmb.cams.outline_contact import check_names, check_outlines, piece_numbers
from flexmb.cams.packing import TOLERANCE_LENGTH, carriers, in_frame, pair_shapes, signed_distance
from flexmb.cams.round_kernels import round_gap_kernel
from flexmb.contact.friction.frictionless import Frictionless
from flexmb.errors import InputError, ModelError
from flexmb.model.contributions import ContactContribution, Contribution, Node
from flexmb.model.law import FrictionLaw, NormalLaw
from flexmb.model.part import Part
from flexmb.model.shape import Shapes

if TYPE_CHECKING:
    from flexmb.model.mechanism import Mechanism

MOST_CONTACTS = 256
"""Largest number of contacts of a pair."""


@dataclass(frozen=True)
class OutlineOnOutline(Part):
    """Contact of two outlines of two bodies, on the outside of both, at as many places as touch.

    Each round of one outline has a contact with the other outline.  A round is a run of convex arcs and corners between
    straight or hollow pieces: a square has four, a circle one.  `places` tells their names and places: first1, first2,
    ... of the first outline, second1, ... of the second.  A round with arcs has a contact with each chain between two
    hollow corners of the other outline, `second1_side1`, ...

    Signals: as of a contact (see `RevoluteClearance`; ex, ey from the first outline to the second), of each contact, as
    `name.second1.normal_force`.

    Parameters
    ----------
    name : name of the pair.
    first : the first body.
    first_outline : its outline, in the reference configuration.
    second : the second body.
    second_outline : its outline, in the reference configuration.
    normal : law of the normal force at each contact, with a stiffness of its own.
    friction : law of friction; left out: frictionless.
    names : names of your own for contacts, e.g. names={"second2": "tip", "first1_side1": "slot"}.

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

    first: Part
    first_outline: Outline
    second: Part
    second_outline: Outline
    _: KW_ONLY
    normal: NormalLaw
    friction: FrictionLaw = field(default_factory=Frictionless)
    names: Mapping[str, str] = field(default_factory=dict)

    lost_beyond: ClassVar[float] = 0.45
    """Penetration over the size beyond which a body is lost: at half of its half height another side may be nearer."""

    def __post_init__(self) -> None:
        super().__post_init__()
        check_outlines(self, first_outline=Outline, second_outline=Outline)
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
        """Both outlines."""
        return pair_shapes(mechanism, self, self.first_outline, self.second_outline)


def _label(name: str, side: int, chains: list[list[int]]) -> str:
    """Name of the contact of a round with one of the chains."""
    return f"{name}_side{side}" if len(chains) > 1 else name


def _is_round(outline: Outline) -> bool:
    """Whether an outline consists of convex arcs alone."""
    return all(bulge > 0.0 for bulge in outline.bulges)


def _arc_numbers(arc: RoundArc, node: Node) -> tuple[float, ...]:
    """Numbers of an arc of a round in the frame of a node, see `round_kernels`."""
    begin, end = arc.begin - node.theta, arc.end - node.theta
    normals = math.cos(begin), math.sin(begin), math.cos(end), math.sin(end)
    return (*in_frame(node, arc.at), arc.radius, *normals, arc.kind)
