"""Contact of outlines with corners: with circles of other bodies, and with their outlines.

A round is a run of convex arcs and corners; a corner is an arc of radius 0.  Each arc has the sector of its outward
normals.  The gap of a round is the least signed distance of its points from the other outline.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import KW_ONLY
from typing import Any, ClassVar

import numpy as np

from flexmb import checks
from flexmb import places as at
from flexmb.errors import InputError, ModelError
from flexmb.fields import field, instance, record
from flexmb.kernels import GAP_SIZE, compiled, gap_kernel
from flexmb.model.contributions import ContactContribution, Contribution, Node
from flexmb.model.law import FRICTION_LAW, NORMAL_LAW, FrictionLaw, NormalLaw
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import Part, refuse_one_body
from flexmb.model.shape import Shapes
from flexmb.parts.cams import curve_on_curve as pairs
from flexmb.parts.cams.curves import CircularCurve, meeting
from flexmb.parts.cams.outline import POINTED, ROUNDED, SMOOTH, Outline, RoundArc, rounds
from flexmb.parts.contact.friction import Frictionless

# Places in p: length for tolerances [m], centre of the circle in the frame of the second node [m], its radius [m],
# extent of the chain, number of pieces, first piece.
SCALE, CENTRE_X, CENTRE_Y, RADIUS, EXTENT, COUNT, FIRST_PIECE = range(7)
# Extents: the whole outline; a part between hollow corners; two parts that meet elsewhere, the first with that point.
WHOLE, PART, PART_WITHOUT_START, PART_WITH_END = 0.0, 1.0, 2.0, 3.0
# Places in a piece: ends [m], centre [m], radius [m] (0: straight, < 0: hollow), mean outward normals at both ends.
X0, Y0, X1, Y1, ORIGIN_X, ORIGIN_Y, BEND, START_NX, START_NY, END_NX, END_NY, PIECE_SIZE = range(12)
ROUNDING = 1e-12  # way beyond the end of a piece, over its length or radius, and sine of an angle [1] that are none


@compiled
def foot_on_piece(p, k, X, Y):
    """Square of the distance of (X, Y) from the inside of a piece; infinite beyond its ends."""
    ax, ay = X - p[k + X0], Y - p[k + Y0]
    dx, dy = p[k + X1] - p[k + X0], p[k + Y1] - p[k + Y0]
    if p[k + BEND] == 0.0:
        along, square = ax * dx + ay * dy, dx * dx + dy * dy
        if along < -ROUNDING * square or along > square + ROUNDING * square:
            return math.inf
        across = dx * ay - dy * ax
        return across * across / square
    wx, wy = X - p[k + ORIGIN_X], Y - p[k + ORIGIN_Y]
    sx, sy = p[k + X0] - p[k + ORIGIN_X], p[k + Y0] - p[k + ORIGIN_Y]
    ex, ey = p[k + X1] - p[k + ORIGIN_X], p[k + Y1] - p[k + ORIGIN_Y]
    turn, least = (1.0 if p[k + BEND] > 0.0 else -1.0), -ROUNDING * p[k + BEND] * p[k + BEND]
    if turn * (sx * wy - sy * wx) < least or turn * (wx * ey - wy * ex) < least:
        return math.inf
    away = math.sqrt(wx * wx + wy * wy) - abs(p[k + BEND])
    return away * away


@compiled
def inner_place(p, k, X, Y):
    """Nearest point of the line or circle of a piece, see `outline_place`."""
    R = p[k + BEND]
    if R == 0.0:
        dx, dy = p[k + X1] - p[k + X0], p[k + Y1] - p[k + Y0]
        length = math.sqrt(dx * dx + dy * dy)
        nx, ny = dy / length, -dx / length
        away = nx * (X - p[k + X0]) + ny * (Y - p[k + Y0])
        return X - away * nx, Y - away * ny, nx, ny, away, 1.0, 0.0
    wx, wy = X - p[k + ORIGIN_X], Y - p[k + ORIGIN_Y]
    size, turn = math.sqrt(wx * wx + wy * wy), (1.0 if R > 0.0 else -1.0)
    away = turn * size - R
    if size == 0.0:  # in the centre of the arc any of its points is nearest
        return p[k + X0], p[k + Y0], p[k + START_NX], p[k + START_NY], away, abs(R), turn
    nx, ny = turn * wx / size, turn * wy / size
    return X - away * nx, Y - away * ny, nx, ny, away, abs(R), turn


@compiled
def start_normal(p, k):
    """Outward normal of a piece at its start, and sine of half the angle by which the outline bends outwards there."""
    _, _, nx, ny, _, _, _ = inner_place(p, k, p[k + X0], p[k + Y0])
    return nx, ny, p[k + START_NX] * ny - p[k + START_NY] * nx


@compiled
def outline_place(p, first, count, X, Y):
    """Nearest point, outward normal, signed distance and curvature b/a of some pieces for a point (X, Y)."""
    # k is the nearest piece, or that of the nearest end. To round-off an end is as near as feet beside it: it counts
    # beyond both pieces, without a corner as their place.
    best, k, is_end, at_end = math.inf, first, True, False
    last = first + PIECE_SIZE * (count - 1)
    before = foot_on_piece(p, last, X, Y)
    for i in range(count):
        now = first + PIECE_SIZE * i
        square = foot_on_piece(p, now, X, Y)
        if square < best:
            best, k, is_end = square, now, False
        joined = p[last + X1] == p[now + X0] and p[last + Y1] == p[now + Y0]
        start, end = (X - p[now + X0]) ** 2 + (Y - p[now + Y0]) ** 2, (X - p[last + X1]) ** 2 + (Y - p[last + Y1]) ** 2
        if start < best and square == math.inf and not (joined and before < math.inf):
            _, _, sine = start_normal(p, now)
            best, k, is_end, at_end = start, now, not joined or abs(sine) > 0.5 * SMOOTH, False
        if end < best and before == math.inf and not joined:
            best, k, is_end, at_end = end, last, True, True
        last, before = now, square
    if not is_end:
        return inner_place(p, k, X, Y)
    x, y, mx, my = p[k + X0], p[k + Y0], p[k + START_NX], p[k + START_NY]
    if at_end:
        x, y, mx, my = p[k + X1], p[k + Y1], p[k + END_NX], p[k + END_NY]
    ex, ey = X - x, Y - y
    size = math.sqrt(ex * ex + ey * ey)
    away = size if mx * ex + my * ey >= 0.0 else -size
    if size > 0.0:
        mx, my = ex / away, ey / away
    return x, y, mx, my, away, 0.0, 1.0


@compiled
def is_of_other(p, count, x, y, X, Y):
    """Whether (x, y) is the point where two chains meet without a hollow corner, and the other one meets (X, Y)."""
    if p[EXTENT] == PART_WITHOUT_START:
        return x == p[FIRST_PIECE + X0] and y == p[FIRST_PIECE + Y0]
    k = FIRST_PIECE + PIECE_SIZE * (count - 1)
    _, _, nx, ny, _, _, _ = inner_place(p, k, p[k + X1], p[k + Y1])
    mx, my = p[k + END_NX], p[k + END_NY]
    twice = 2.0 * (mx * nx + my * ny)  # the normals of both pieces lie on either side of their mean
    beyond = (twice * mx - nx) * (Y - y) - (twice * my - ny) * (X - x) >= -ROUNDING * p[RADIUS]
    return p[EXTENT] == PART_WITH_END and beyond and x == p[k + X1] and y == p[k + Y1]


@gap_kernel
def outline_gap_kernel(p, q, v, out):
    """Distance of a circle from a chain of straight lines and arcs."""
    c, s = math.cos(q[5]), math.sin(q[5])
    X, Y = q[3] + c * p[CENTRE_X] - s * p[CENTRE_Y], q[4] + s * p[CENTRE_X] + c * p[CENTRE_Y]
    c, s = math.cos(q[2]), math.sin(q[2])
    ex, ey = X - q[0], Y - q[1]
    own_x, own_y, radius, count = c * ex + s * ey, -s * ex + c * ey, p[RADIUS], int(p[COUNT])
    x, y, mx, my, away, a, b = outline_place(p, FIRST_PIECE, count, own_x, own_y)
    if p[EXTENT] > WHOLE and away < 0.0:  # the chain is seen from behind, through the body
        mx, my, away, b, radius = -mx, -my, -away, -b, 0.0
    elif a == 0.0 and is_of_other(p, count, x, y, own_x, own_y):
        radius = 0.0
    nx, ny = c * mx - s * my, s * mx + c * my
    X, Y = q[0] + c * x - s * y, q[1] + s * x + c * y
    pairs.put_gap(pairs.with_arms(q, X, Y, nx, ny, away - radius, a, b, radius, 1.0), q, v, out)


# Places in p behind SCALE: whether the round belongs to the first body, and whether it counts contacts with convex arcs
# and corners; numbers of arcs of the round, of pieces of the chain, of all pieces; first arc. Pieces follow the arcs,
# those of the chain first.
ROUND_IS_FIRST, MEETS_ROUNDS, ROUNDS, CHAIN, PIECES, FIRST_ROUND = range(1, 7)

# Places in an arc of a round: centre and radius [m], outward normals at both ends, kind.
ARC_X, ARC_Y, ARC_RADIUS, FROM_X, FROM_Y, TO_X, TO_Y, KIND, ARC_SIZE = range(9)
GAP = 4  # place of the distance in the numbers of a place
SAME = 1e-6  # difference of distances, over the length for tolerances, up to which they are the same


@compiled
def within(nx, ny, ax, ay, bx, by):
    """Whether a direction lies between two others, counter-clockwise from the first one, less than half a turn."""
    return ax * ny - ay * nx >= -ROUNDING and nx * by - ny * bx >= -ROUNDING and nx * (ax + bx) + ny * (ay + by) > 0.0


@compiled
def corner_place(p, k, X, Y):
    """Convex corner at the start of a piece, see `outline_place`; infinite distance outside its sector of normals."""
    ex, ey = X - p[k + X0], Y - p[k + Y0]
    size, mx, my = math.sqrt(ex * ex + ey * ey), p[k + START_NX], p[k + START_NY]
    tx, ty, sine = start_normal(p, k)
    if sine <= ROUNDING or abs(mx * ey - my * ex) * (mx * tx + my * ty) > sine * (mx * ex + my * ey):
        return 0.0, 0.0, 0.0, 0.0, math.inf, 0.0, 1.0
    if sine <= 0.5 * SMOOTH:
        return inner_place(p, k, X, Y)
    if size == 0.0:
        return p[k + X0], p[k + Y0], mx, my, 0.0, 0.0, 1.0
    return p[k + X0], p[k + Y0], ex / size, ey / size, size, 0.0, 1.0


@compiled
def side_place(p, k, X, Y, radius):
    """Inside of a piece, see `outline_place`; infinite distance beyond its ends, or where the radius does not fit."""
    if foot_on_piece(p, k, X, Y) == math.inf or -radius <= p[k + BEND] < 0.0:
        return 0.0, 0.0, 0.0, 0.0, math.inf, 0.0, 1.0
    return inner_place(p, k, X, Y)


@compiled
def turned(place, radius, keep):
    """Place, radius and its sign; seen from the other side, with a positive gap, where it does not count."""
    x, y, nx, ny, away, a, b = place
    if keep:
        return x, y, nx, ny, away - radius, a, b, radius, 1.0
    return x, y, -nx, -ny, radius - away, a, -b, radius, -1.0


@compiled
def better(best, place, radius, keep):
    """The one of two places with the smaller gap."""
    found = turned(place, radius, keep)
    return found if found[GAP] < best[GAP] else best


@compiled
def counts(p, first, place, radius, X, Y):
    """Whether an arc around (X, Y) that overlaps the outline at this place touches it there."""
    _, _, nx, ny, away, a, b = place
    if b > 0.0 and p[MEETS_ROUNDS] == 0.0:
        return False
    _, _, _, _, depth, _, _ = outline_place(p, first, int(p[PIECES]), X - radius * nx, Y - radius * ny)
    if depth < 0.0 and (a == 0.0 or radius - away <= SAME * p[SCALE] - depth):
        return True
    # beside a corner the point is nearer to the next side, but the centre outside knows where it touches
    _, _, _, _, near, _, _ = outline_place(p, first, int(p[PIECES]), X, Y)
    return near > 0.0 and abs(away - near) <= SAME * p[SCALE]


@compiled
def arc_of_round(p, first, X, Y, radius, ax, ay, bx, by, best):
    """The better one of a place and that of an arc around (X, Y) with the sector (ax, ay) to (bx, by)."""
    for i in range(int(p[CHAIN])):
        k = first + PIECE_SIZE * i
        for at_corner in range(2):
            place = corner_place(p, k, X, Y) if at_corner else side_place(p, k, X, Y, radius)
            _, _, nx, ny, away, _, _ = place
            if abs(away - radius) < best[GAP] and within(-nx, -ny, ax, ay, bx, by):
                best = better(best, place, radius, away >= radius or counts(p, first, place, radius, X, Y))
    return best


@compiled
def round_place(p, X, Y, c, s):
    """Place of the contact on the outline, normal, gap, curvature, radius of the round and its sign."""
    # (X, Y), c, s : node of the round, cosine and sine of its angle, in the frame of the outline.
    count = int(p[ROUNDS])
    first = FIRST_ROUND + ARC_SIZE * count
    best = (0.0, 0.0, 0.0, 0.0, math.inf, 0.0, 1.0, 0.0, 1.0)
    for i in range(count):
        k = FIRST_ROUND + ARC_SIZE * i
        x, y = X + c * p[k + ARC_X] - s * p[k + ARC_Y], Y + s * p[k + ARC_X] + c * p[k + ARC_Y]
        ax, ay = c * p[k + FROM_X] - s * p[k + FROM_Y], s * p[k + FROM_X] + c * p[k + FROM_Y]
        bx, by = c * p[k + TO_X] - s * p[k + TO_Y], s * p[k + TO_X] + c * p[k + TO_Y]
        if p[k + KIND] == ROUNDED:
            best = arc_of_round(p, first, x, y, p[k + ARC_RADIUS], ax, ay, bx, by, best)
        else:
            chain, pieces = int(p[CHAIN]), int(p[PIECES])
            place = outline_place(p, first, chain, x, y)
            _, _, nx, ny, away, a, b = place
            keep = True
            if away < 0.0:
                if a > 0.0 and b > 0.0:
                    keep = p[MEETS_ROUNDS] > 0.0 and p[k + KIND] == POINTED and within(-nx, -ny, ax, ay, bx, by)
                if chain < pieces:
                    _, _, _, _, depth, _, _ = outline_place(p, first, pieces, x, y)
                    end = first + PIECE_SIZE * (chain - 1)  # behind it, in a hollow corner, the next chain carries
                    ex, ey, reach = x - p[end + X1], y - p[end + Y1], SAME * p[SCALE] - depth
                    keep = keep and depth < 0.0 and -away <= reach < math.sqrt(ex * ex + ey * ey)
            best = better(best, place, 0.0, keep)
    if best[GAP] == math.inf:  # the chain is seen by none of the arcs: the distance of a centre, which lies inside
        k = FIRST_ROUND
        x, y = X + c * p[k + ARC_X] - s * p[k + ARC_Y], Y + s * p[k + ARC_X] + c * p[k + ARC_Y]
        place = outline_place(p, first, int(p[CHAIN]), x, y)
        best = turned(place, 0.0, place[GAP] >= 0.0)
    return best


@gap_kernel
def round_gap_kernel(p, q, v, out):
    """Distance of a round of one outline from a chain of pieces of another one."""
    own, other = (3, 0) if p[ROUND_IS_FIRST] else (0, 3)  # the body of the chain, and that of the round
    c, s = math.cos(q[own + 2]), math.sin(q[own + 2])
    ex, ey, turn = q[other] - q[own], q[other + 1] - q[own + 1], q[other + 2] - q[own + 2]
    place = round_place(p, c * ex + s * ey, -s * ex + c * ey, math.cos(turn), math.sin(turn))
    x, y, mx, my, gap, a, b, radius, sign = place
    nx, ny = c * mx - s * my, s * mx + c * my
    X, Y = q[own] + c * x - s * y, q[own + 1] + s * x + c * y
    if p[ROUND_IS_FIRST]:
        pairs.put_gap(pairs.with_arms(q, X + gap * nx, Y + gap * ny, -nx, -ny, gap, radius, sign, a, b), q, v, out)
    else:
        pairs.put_gap(pairs.with_arms(q, X, Y, nx, ny, gap, a, b, radius, sign), q, v, out)


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
                text = f"{self.label}: the circle of radius {self.circle.radius:g} m does not fit into"
                text += f" the hollow arc from ({x:.6g}, {y:.6g}) m, whose radius is {-radius:g} m."
                raise InputError(f"{text} Use a smaller circle, or a wider arc.")

    @property
    def pin_radius(self) -> float:
        """Radius of the circle [m], beside which penetrations are judged."""
        return self.circle.radius

    def validate(self, mechanism: Mechanism) -> None:
        """Refuse a circle inside the outline."""
        super().validate(mechanism)
        gap = pairs.signed_distance(self.outline.polygon, self.circle.centre) - self.circle.radius
        if gap < -pairs.TOLERANCE_LENGTH * self.outline.size:
            text = f"{self.label}: circle and outline overlap by {-gap:.4g} m in the reference configuration."
            raise ModelError(f"{text} Move one of them apart; both are given in the reference configuration.")

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        """One contact for each chain of pieces between hollow corners."""
        nodes, coordinates = pairs.carriers(mechanism, self.label, self.first, self.second)
        centre, chains = pairs.in_frame(nodes[1], self.circle.centre), self.outline.chains()
        head = pairs.TOLERANCE_LENGTH * self.outline.size, *centre, self.circle.radius
        hollow, normal = self.outline.hollow_corners(), self.normal.for_radii(math.inf, self.circle.radius)
        found = []
        for number, chain in enumerate(chains, 1):
            start, end = chain[0] in hollow, (chain[-1] + 1) % len(self.outline.points) in hollow
            extent = WHOLE if not hollow else PART_WITHOUT_START if not start else PART if end else PART_WITH_END
            pieces = [x for k in chain for x in piece_numbers(self.outline, k, nodes[0])]
            p = (*head, extent, float(len(chain)), *pieces)
            side = f"side{number}" if hollow else ""
            laws = normal, self.friction, self.names.get(side, side)
            found.append(ContactContribution(self.name, outline_gap_kernel, coordinates, p, *laws))
        return found

    def shapes(self, mechanism: Mechanism) -> Shapes:
        return pairs.pair_shapes(mechanism, self, self.outline, self.circle)


def check_names(part: Any, contacts: Iterable[str]) -> None:
    """Check the user's names of contacts (`part.names`): each for one of `contacts`, and no name twice."""
    given, known = checks.mapping(part.label, "names", part.names), list(contacts)
    for contact, name in given.items():
        if contact not in known:
            text = f"{part.label}: names has {contact!r}, which is no contact of it."
            raise InputError(f"{text} Contacts: {', '.join(known) or 'a single one, which has the name of the part'}.")
        checks.identifier(f"{part.label}: names[{contact!r}]", name)
    final = [given.get(contact, contact) for contact in known]
    if twice := sorted({name for name in final if final.count(name) > 1}):
        raise InputError(f"{part.label}: two contacts have the name {twice[0]!r}. Give each a name of its own.")


def piece_numbers(outline: Outline, k: int, node: Node) -> tuple[float, ...]:
    """Numbers of a piece in the frame of a node, as the kernels above read them."""
    after = (k + 1) % len(outline.points)
    ends = *pairs.in_frame(node, outline.points[k]), *pairs.in_frame(node, outline.points[after])
    begin, end = _mean_normal(outline, k, node), _mean_normal(outline, after, node)
    return (*ends, *pairs.in_frame(node, outline.centre(k)), outline.radius(k), *begin, *end)


def _mean_normal(outline: Outline, k: int, node: Node) -> tuple[float, float]:
    """Unit outward normal between both pieces at point k of the outline, in the frame of a node."""
    x, y = outline.directions(k)[0]
    angle = math.atan2(-x, y) - 0.5 * outline.bend(k) - node.theta
    return math.cos(angle), math.sin(angle)


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
            text = f"{self.label}: the stiffness of {type(self.normal).__name__} depends on radii, which corners have"
            raise InputError(f"{text} not. Give one with a stiffness, e.g. HuntCrossley or KelvinVoigt.") from error
        rounds_of = [(name, chains) for name, _, _, chains in self._contacts()]
        labels = [_label(name, side, chains) for name, chains in rounds_of for side, _ in enumerate(chains, 1)]
        check_names(self, labels)
        if (count := len(labels)) > MOST_CONTACTS:
            text = f"{self.label}: the outlines have {count} contacts, more than {MOST_CONTACTS}. Draw curved sides as"
            raise InputError(f"{text} arcs (bulges, Outline.from_curve), not lines, or leave out what never touches.")

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
        least = -pairs.TOLERANCE_LENGTH * min(self.first_outline.size, self.second_outline.size)
        others = ((polygon, point) for polygon, points in ((one, two), (two, one)) for point in points)
        depth, place = min((pairs.signed_distance(polygon, point), tuple(point)) for polygon, point in others)
        crossed = meeting(one, two, -least)
        if depth >= least and crossed is None:
            return
        if least - self.first_outline.flatness - self.second_outline.flatness <= depth < 0.0:  # of chords; of the arcs:
            depth, out = math.inf, np.empty(GAP_SIZE)
            nodes = pairs.carriers(mechanism, self.label, self.first, self.second)[0]
            q = np.array([z for node in nodes for z in (node.x, node.y, node.theta)])
            for piece in self.contributions(mechanism):
                piece.gap(np.array(piece.p), q, np.zeros(6), out)
                depth = min(depth, float(out[at.GAP]))
            if depth >= least:
                return
        deep, (x, y) = (f" by {-depth:.4g} m", place) if depth < least else ("", crossed or place)
        text = f"{self.label}: the outlines overlap{deep} near ({x:.6g}, {y:.6g}) m in the reference configuration."
        raise ModelError(f"{text} Move one of the bodies; both outlines are given in the reference configuration.")

    def contributions(self, mechanism: Mechanism) -> Sequence[ContactContribution]:
        """One contact of each round with each chain."""
        nodes, coordinates = pairs.carriers(mechanism, self.label, self.first, self.second)
        owner_is_first = _is_round(self.first_outline) and not _is_round(self.second_outline)
        size, found = min(self.first_outline.size, self.second_outline.size), []
        for label, is_first, arcs, chains in self._contacts():
            own, seen = nodes if is_first else (nodes[1], nodes[0])
            outline = self.second_outline if is_first else self.first_outline
            turning: list[float] = []  # numbers of the arcs in the frame of their node, as the kernels above read them
            for arc in arcs:
                begin, end = arc.begin - own.theta, arc.end - own.theta
                normals = math.cos(begin), math.sin(begin), math.cos(end), math.sin(end)
                turning += [*pairs.in_frame(own, arc.at), arc.radius, *normals, arc.kind]
            pieces = [piece_numbers(outline, k, seen) for k in range(len(outline.points))]
            for side, chain in enumerate(chains, 1):
                order = [(chain[0] + k) % len(pieces) for k in range(len(pieces))]
                flags = float(is_first), float(is_first == owner_is_first)
                counts = float(len(arcs)), float(len(chain)), float(len(pieces))
                p = (pairs.TOLERANCE_LENGTH * size, *flags, *counts, *turning, *(x for k in order for x in pieces[k]))
                name = _label(label, side, chains)
                own_name, laws = self.names.get(name, name), (self.normal, self.friction)
                found.append(ContactContribution(self.name, round_gap_kernel, coordinates, p, *laws, own_name))
        return found

    def shapes(self, mechanism: Mechanism) -> Shapes:
        return pairs.pair_shapes(mechanism, self, self.first_outline, self.second_outline)


def _label(name: str, side: int, chains: list[list[int]]) -> str:
    """Name of the contact of a round with one of the chains."""
    return f"{name}_side{side}" if len(chains) > 1 else name


def _is_round(outline: Outline) -> bool:
    """Whether an outline consists of convex arcs alone."""
    return all(bulge > 0.0 for bulge in outline.bulges)
