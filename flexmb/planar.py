"""Small helpers for vectors and angles in the plane; types of arrays."""

import math

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]


def to_frame(origin: tuple[float, float], angle: float, point: tuple[float, float]) -> tuple[float, float]:
    """Coordinates of a world `point` in the frame at `origin` turned by `angle`."""
    dx, dy = point[0] - origin[0], point[1] - origin[1]
    c, s = math.cos(angle), math.sin(angle)
    return c * dx + s * dy, -s * dx + c * dy


def from_frame(origin: tuple[float, float], angle: float, point: tuple[float, float]) -> tuple[float, float]:
    """World coordinates of a `point` given in the frame at `origin` turned by `angle`."""
    c, s = math.cos(angle), math.sin(angle)
    return origin[0] + c * point[0] - s * point[1], origin[1] + s * point[0] + c * point[1]


def distance(a: tuple[float, float], b: tuple[float, float]) -> float:
    """Distance of two points."""
    return math.hypot(b[0] - a[0], b[1] - a[1])


def direction(a: tuple[float, float], b: tuple[float, float]) -> float:
    """Direction from the point `a` to the point `b` [rad]."""
    return math.atan2(b[1] - a[1], b[0] - a[0])


def area(points: Array) -> float:
    """Signed area of a polygon with corners (n, 2); > 0 for a counter-clockwise one."""
    x, y = (points - points[0]).T
    return float(0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1)))


def surrounds(points: Array) -> bool:
    """Whether a closed polygon with corners (n, 2) goes round the origin."""
    z = points[:, 0] + 1j * points[:, 1]
    return abs(float(np.angle(np.roll(z, -1) * z.conj()).sum())) > math.pi
