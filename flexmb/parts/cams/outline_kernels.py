"""A circle of the second body at a chain of straight lines and arcs of the first: gap kernel."""

import math

from flexmb.kernels import compiled, gap_kernel
from flexmb.parts.cams.pair_kernels import put_gap, with_arms

SCALE, CENTRE_X, CENTRE_Y, RADIUS, EXTENT, COUNT, FIRST_PIECE = range(7)
"""Places in p: length for tolerances [m], centre of the circle in the frame of the second node [m], its radius [m],
extent of the chain, number of pieces, first piece."""

WHOLE, PART, PART_WITHOUT_START = 0.0, 1.0, 2.0
"""Extents: the whole outline; a part of the outline; a part whose first point belongs to the part before."""

X0, Y0, X1, Y1, ORIGIN_X, ORIGIN_Y, BEND, START_NX, START_NY, END_NX, END_NY, PIECE_SIZE = range(12)
"""Places in a piece: ends [m], centre [m], radius [m] (0: straight, < 0: hollow), mean outward normals at both ends."""

STRAIGHT, ARC, CORNER = range(3)
"""Kinds of nearest places."""


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
