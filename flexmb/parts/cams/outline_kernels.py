"""Gap kernels of outlines, chains of straight lines and arcs: with a circle, with a round of another outline.

A round is a run of convex arcs and corners; a corner is an arc of radius 0.  Each arc has the sector of its outward
normals.  The gap of a round is the least signed distance of its points from the other outline.
"""

import math

from flexmb.kernels import compiled, gap_kernel
from flexmb.parts.cams.outline import POINTED, ROUNDED
from flexmb.parts.cams.pair_kernels import put_gap, with_arms

# A circle of the second body at a chain of straight lines and arcs of the first

# Places in p: length for tolerances [m], centre of the circle in the frame of the second node [m], its radius [m],
# extent of the chain, number of pieces, first piece.
SCALE, CENTRE_X, CENTRE_Y, RADIUS, EXTENT, COUNT, FIRST_PIECE = range(7)
# Extents: the whole outline; a part of the outline; a part whose first point belongs to the part before.
WHOLE, PART, PART_WITHOUT_START = 0.0, 1.0, 2.0
# Places in a piece: ends [m], centre [m], radius [m] (0: straight, < 0: hollow), mean outward normals at both ends.
X0, Y0, X1, Y1, ORIGIN_X, ORIGIN_Y, BEND, START_NX, START_NY, END_NX, END_NY, PIECE_SIZE = range(12)
STRAIGHT, ARC, CORNER = range(3)  # kinds of nearest places


@compiled
def foot_on_piece(p, k, X, Y):
    """Square of the distance of (X, Y) from the inside of a piece; infinite beyond its ends."""
    ax, ay = X - p[k + X0], Y - p[k + Y0]
    dx, dy = p[k + X1] - p[k + X0], p[k + Y1] - p[k + Y0]
    if p[k + BEND] == 0.0:
        along, square = ax * dx + ay * dy, dx * dx + dy * dy
        if along < 0.0 or along > square:
            return math.inf
        across = dx * ay - dy * ax
        return across * across / square
    wx, wy = X - p[k + ORIGIN_X], Y - p[k + ORIGIN_Y]
    sx, sy = p[k + X0] - p[k + ORIGIN_X], p[k + Y0] - p[k + ORIGIN_Y]
    ex, ey = p[k + X1] - p[k + ORIGIN_X], p[k + Y1] - p[k + ORIGIN_Y]
    turn = 1.0 if p[k + BEND] > 0.0 else -1.0
    if turn * (sx * wy - sy * wx) < 0.0 or turn * (wx * ey - wy * ex) < 0.0:
        return math.inf
    away = math.sqrt(wx * wx + wy * wy) - abs(p[k + BEND])
    return away * away


@compiled
def nearest_place(p, first, count, X, Y):
    """Nearest piece or end of a piece: its place in p, kind, and whether it is the end (of a corner)."""
    best, found, kind, at_end = math.inf, first, CORNER, False
    for i in range(count):
        k = first + PIECE_SIZE * i
        square = foot_on_piece(p, k, X, Y)
        if square < best:
            best, found, kind = square, k, STRAIGHT if p[k + BEND] == 0.0 else ARC
    for i in range(count):
        k = first + PIECE_SIZE * i
        start = (X - p[k + X0]) ** 2 + (Y - p[k + Y0]) ** 2
        end = (X - p[k + X1]) ** 2 + (Y - p[k + Y1]) ** 2
        if min(start, end) < best:
            best, found, kind, at_end = min(start, end), k, CORNER, end < start
    return found, kind, at_end


@compiled
def straight_place(p, k, X, Y):
    """Nearest point of the line of a straight piece, see `outline_place`."""
    dx, dy = p[k + X1] - p[k + X0], p[k + Y1] - p[k + Y0]
    length = math.sqrt(dx * dx + dy * dy)
    nx, ny = dy / length, -dx / length
    away = nx * (X - p[k + X0]) + ny * (Y - p[k + Y0])
    return X - away * nx, Y - away * ny, nx, ny, away, 1.0, 0.0


@compiled
def arc_place(p, k, X, Y):
    """Nearest point of the circle of an arc, see `outline_place`."""
    wx, wy, R = X - p[k + ORIGIN_X], Y - p[k + ORIGIN_Y], p[k + BEND]
    size, turn = math.sqrt(wx * wx + wy * wy), (1.0 if R > 0.0 else -1.0)
    away = turn * size - R
    if size == 0.0:  # in the centre of the arc any of its points is nearest
        return p[k + X0], p[k + Y0], p[k + START_NX], p[k + START_NY], away, abs(R), turn
    nx, ny = turn * wx / size, turn * wy / size
    return X - away * nx, Y - away * ny, nx, ny, away, abs(R), turn


@compiled
def outline_place(p, first, count, X, Y):
    """Nearest point, outward normal, signed distance and curvature b/a of some pieces for a point (X, Y)."""
    k, kind, at_end = nearest_place(p, first, count, X, Y)
    if kind == STRAIGHT:
        return straight_place(p, k, X, Y)
    if kind == ARC:
        return arc_place(p, k, X, Y)
    x, y, mx, my = p[k + X0], p[k + Y0], p[k + START_NX], p[k + START_NY]
    if at_end:
        x, y, mx, my = p[k + X1], p[k + Y1], p[k + END_NX], p[k + END_NY]
    ex, ey = X - x, Y - y
    size = math.sqrt(ex * ex + ey * ey)
    away = size if mx * ex + my * ey >= 0.0 else -size
    if size > 0.0:
        mx, my = ex / away, ey / away
    return x, y, mx, my, away, 0.0, 1.0


@gap_kernel
def outline_gap_kernel(p, q, v, out):
    """Distance of a circle from a chain of straight lines and arcs."""
    c, s = math.cos(q[5]), math.sin(q[5])
    X, Y = q[3] + c * p[CENTRE_X] - s * p[CENTRE_Y], q[4] + s * p[CENTRE_X] + c * p[CENTRE_Y]
    c, s = math.cos(q[2]), math.sin(q[2])
    ex, ey = X - q[0], Y - q[1]
    x, y, mx, my, away, a, b = outline_place(p, FIRST_PIECE, int(p[COUNT]), c * ex + s * ey, -s * ex + c * ey)
    radius = p[RADIUS]
    if p[EXTENT] > WHOLE and away < 0.0:  # the chain is seen from behind, through the body
        mx, my, away, b, radius = -mx, -my, -away, -b, 0.0
    elif p[EXTENT] == PART_WITHOUT_START and a == 0.0 and x == p[FIRST_PIECE + X0] and y == p[FIRST_PIECE + Y0]:
        radius = 0.0
    nx, ny = c * mx - s * my, s * mx + c * my
    X, Y = q[0] + c * x - s * y, q[1] + s * x + c * y
    put_gap(with_arms(q, X, Y, nx, ny, away - radius, a, b, radius, 1.0), q, v, out)


# Places in p behind SCALE: whether the round belongs to the first body, and whether it counts contacts with convex arcs
# and corners; numbers of arcs of the round, of pieces of the chain, of all pieces; first arc. Pieces follow the arcs,
# those of the chain first.
ROUND_IS_FIRST, MEETS_ROUNDS, ROUNDS, CHAIN, PIECES, FIRST_ROUND = range(1, 7)

# Places in an arc of a round: centre and radius [m], outward normals at both ends, kind.
ARC_X, ARC_Y, ARC_RADIUS, FROM_X, FROM_Y, TO_X, TO_Y, KIND, ARC_SIZE = range(9)
GAP = 4  # place of the distance in the numbers of a place
ROUNDING = 1e-12  # sine of an angle [1] by which sectors overlap
SAME = 1e-6  # difference of distances, over the length for tolerances, up to which they are the same


@compiled
def within(nx, ny, ax, ay, bx, by):
    """Whether a direction lies between two others, counter-clockwise from the first one, less than half a turn."""
    return ax * ny - ay * nx >= -ROUNDING and nx * by - ny * bx >= -ROUNDING and nx * (ax + bx) + ny * (ay + by) > 0.0


@compiled
def corner_place(p, k, X, Y):
    """Convex corner at the start of a piece, see `outline_place`; infinite distance outside its sector of normals."""
    ex, ey = X - p[k + X0], Y - p[k + Y0]
    size = math.sqrt(ex * ex + ey * ey)
    if p[k + BEND] == 0.0:
        tx, ty = p[k + Y1] - p[k + Y0], p[k + X0] - p[k + X1]
    else:
        turn = 1.0 if p[k + BEND] > 0.0 else -1.0
        tx, ty = turn * (p[k + X0] - p[k + ORIGIN_X]), turn * (p[k + Y0] - p[k + ORIGIN_Y])
    mx, my, length = p[k + START_NX], p[k + START_NY], math.sqrt(tx * tx + ty * ty)
    if mx * ty - my * tx <= ROUNDING * length or (mx * ex + my * ey) * length < (mx * tx + my * ty) * size:
        return 0.0, 0.0, 0.0, 0.0, math.inf, 0.0, 1.0
    if size == 0.0:
        return p[k + X0], p[k + Y0], mx, my, 0.0, 0.0, 1.0
    return p[k + X0], p[k + Y0], ex / size, ey / size, size, 0.0, 1.0


@compiled
def side_place(p, k, X, Y, radius):
    """Inside of a piece, see `outline_place`; infinite distance beyond its ends, or where the radius does not fit."""
    if foot_on_piece(p, k, X, Y) == math.inf or -radius <= p[k + BEND] < 0.0:
        return 0.0, 0.0, 0.0, 0.0, math.inf, 0.0, 1.0
    return straight_place(p, k, X, Y) if p[k + BEND] == 0.0 else arc_place(p, k, X, Y)


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
    return depth < 0.0 and (a == 0.0 or radius - away <= SAME * p[SCALE] - depth)


@compiled
def point_of_round(p, k, first, X, Y, ax, ay, bx, by, best):
    """The better one of a place and that of a corner, or of an end of an arc, with the sector (ax, ay) to (bx, by)."""
    chain, pieces = int(p[CHAIN]), int(p[PIECES])
    place = outline_place(p, first, chain, X, Y)
    _, _, nx, ny, away, a, b = place
    keep = True
    if away < 0.0:
        if a > 0.0 and b > 0.0:
            keep = p[MEETS_ROUNDS] > 0.0 and p[k + KIND] == POINTED and within(-nx, -ny, ax, ay, bx, by)
        if chain < pieces:
            _, _, _, _, depth, _, _ = outline_place(p, first, pieces, X, Y)
            keep = keep and depth < 0.0 and -away <= SAME * p[SCALE] - depth
    return better(best, place, 0.0, keep)


@compiled
def arc_of_round(p, first, X, Y, radius, ax, ay, bx, by, best):
    """The better one of a place and that of an arc around (X, Y) with the sector (ax, ay) to (bx, by)."""
    for i in range(int(p[CHAIN])):
        k = first + PIECE_SIZE * i
        for at_corner in range(2):
            place = corner_place(p, k, X, Y) if at_corner else side_place(p, k, X, Y, radius)
            _, _, nx, ny, away, _, _ = place
            if abs(away - radius) < best[GAP] and within(-nx, -ny, ax, ay, bx, by):
                keep = away >= radius or counts(p, first, place, radius, X, Y)
                best = better(best, place, radius, keep)
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
            best = point_of_round(p, k, first, x, y, ax, ay, bx, by, best)
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
        put_gap(with_arms(q, X + gap * nx, Y + gap * ny, -nx, -ny, gap, radius, sign, a, b), q, v, out)
    else:
        put_gap(with_arms(q, X, Y, nx, ny, gap, a, b, radius, sign), q, v, out)
