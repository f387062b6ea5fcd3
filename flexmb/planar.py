"""Small helpers for vectors and angles in the plane."""

import math

import numpy as np


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


def carried(poses: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Points (..., 2) in moved frames, carried along by their poses x, y, theta (..., 3); shapes are broadcast."""
    x, y, angle = np.moveaxis(poses, -1, 0)
    c, s = np.cos(angle), np.sin(angle)
    a, b = points[..., 0], points[..., 1]
    return np.stack([x + c * a - s * b, y + s * a + c * b], axis=-1)


def seen_from(poses: np.ndarray, points: np.ndarray) -> np.ndarray:
    """World points (..., 2) in moved frames with poses x, y, theta (..., 3); shapes are broadcast."""
    x, y, angle = np.moveaxis(poses, -1, 0)
    c, s = np.cos(angle), np.sin(angle)
    dx, dy = points[..., 0] - x, points[..., 1] - y
    return np.stack([c * dx + s * dy, c * dy - s * dx], axis=-1)


def turned_by(points: np.ndarray, moved: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Cosines and sines (n,) of the turn of points (m, 2) into others (n, m, 2) by least squares.

    Both have a common factor: the sum of squares of the points, times the factor by which they grow.
    """
    across = (points[:, 0] * moved[..., 1] - points[:, 1] * moved[..., 0]).sum(axis=1)
    return (points * moved).sum(axis=(1, 2)), across


def whole_turns(angle: np.ndarray) -> np.ndarray:
    """The nearest multiples of a turn [rad]."""
    turns: np.ndarray = 2.0 * np.pi * np.round(angle / (2.0 * np.pi))
    return turns
