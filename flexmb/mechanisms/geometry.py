"""Loop closure in closed form: the third corner of a triangle, the end of a rod on a line."""

import math

from flexmb.errors import AssemblyError

Point = tuple[float, float]
LEFT, RIGHT = 1.0, -1.0  # side of a corner, seen in the direction from the first point to the second


def at_angle(start: Point, length: float, angle: float) -> Point:
    """The point at a distance [m] and direction, from +X [rad], from another point."""
    return start[0] + length * math.cos(angle), start[1] + length * math.sin(angle)


def corner(loop: str, first: Point, r1: float, second: Point, r2: float, side: float) -> Point:
    """The point at distances r1 and r2 [m] from two points, on the side LEFT or RIGHT; `loop` is named in messages."""
    dx, dy = second[0] - first[0], second[1] - first[1]
    d = math.hypot(dx, dy)
    if d > r1 + r2:
        raise AssemblyError(
            f"{loop} cannot close: its ends are {d:.4g} m apart, the links between them reach {r1 + r2:.4g} m, "
            f"{d - r1 - r2:.4g} m too little. Start at other crank angles, or change the lengths."
        )
    if d < abs(r1 - r2) or d == 0.0:
        raise AssemblyError(
            f"{loop} cannot close: its ends are {d:.4g} m apart, the links between them, {r1:.4g} and {r2:.4g} m long, "
            f"keep them at least {abs(r1 - r2):.4g} m apart. Start at other crank angles, or change the lengths."
        )
    along = (d * d + r1 * r1 - r2 * r2) / (2.0 * d)
    across = side * math.sqrt(max(r1 * r1 - along * along, 0.0))
    ux, uy = dx / d, dy / d
    return first[0] + along * ux - across * uy, first[1] + along * uy + across * ux


def on_line(loop: str, start: Point, length: float, height: float, direction: float) -> Point:
    """The point of the line y = `height` [m] at a distance from a point, towards +X (direction 1) or -X (-1)."""
    away = abs(height - start[1])
    if away > length:
        raise AssemblyError(
            f"{loop} cannot close: the rod of {length:.4g} m starts {away:.4g} m beside the line of the slider, "
            f"{away - length:.4g} m too far. Start at other crank angles, or change the lengths."
        )
    return start[0] + direction * math.sqrt(length * length - away * away), height


def box(centre: Point, width: float, height: float) -> tuple[Point, ...]:
    """Outline of a rectangle, closed."""
    (x, y), a, b = centre, 0.5 * width, 0.5 * height
    return ((x - a, y - b), (x + a, y - b), (x + a, y + b), (x - a, y + b), (x - a, y - b))
