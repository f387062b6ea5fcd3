"""Deformations of reduced bodies at the poses that a run keeps, and remarks on large ones."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from flexmb.model.mechanism import Mechanism

if TYPE_CHECKING:
    from flexmb.reduction.reduced import Reduced
    from flexmb.run.watch import Seen

LARGE_SHARE, IMPOSSIBLE_SHARE = 0.1, 0.5
"""Displacement in the frame of a reduced body over the size of the body [1], above which there is a remark, and above
which the run is not ok."""

MOST_POINTS = 100
"""Number of points of a body whose displacements are looked at."""


def deformations(mechanism: Mechanism, seen: Seen) -> Iterator[tuple[Reduced, np.ndarray, np.ndarray]]:
    """Each reduced body, instants (t,), and its deformations (t, n) in its frame, the first pin at 0.

    Instants are those of the poses that a run keeps.
    """
    module: Any = sys.modules.get("flexmb.reduction.reduced")  # no body is a reduced one before it is imported
    for body in mechanism.bodies if module is not None else ():
        if isinstance(body, module.Reduced):
            from flexmb.results.surfaces import deformed

            names = [f"{body.name}.{node.name}.{axis}" for node in body.basis.nodes for axis in ("x", "y", "theta")]
            poses, time = seen.motion.rows(*names), seen.motion.times
            with np.errstate(all="ignore"):  # a run that blows up ends with numbers that are none
                d = deformed(body.moved_by, poses.reshape(len(time), -1, 3))[0]
                d[..., :2] -= d[:, :1, :2]
            yield body, time, d.reshape(len(time), -1)


def large_deformations(mechanism: Mechanism, seen: Seen) -> Iterator[tuple[bool, str]]:
    """A sentence on each reduced body that deforms by much of its size, and whether the run cannot be right."""
    for body, time, d in deformations(mechanism, seen):
        shares = _shares(body, d)
        large = np.flatnonzero(np.append(shares, np.inf) > LARGE_SHARE)[0] if seen.failed else 0
        lost = next((k for k in range(int(large)) if _inertia_is_lost(body, d[k])), None)
        if lost is not None:
            yield True, _lost_inertia(body, float(time[lost]), float(shares[lost]))
        elif shares.max() > LARGE_SHARE:
            wrong = bool(shares.max() > IMPOSSIBLE_SHARE) or seen.failed
            when = int(np.argmax(shares > min(IMPOSSIBLE_SHARE, 0.99 * shares.max())))
            yield wrong, _too_large(body, float(time[when]), float(shares[when]), wrong=wrong)


def _shares(body: Reduced, d: np.ndarray) -> np.ndarray:
    """(t,) largest displacements in the frame of a body over its size."""
    model = body.model
    points = np.linspace(0, len(model.points) - 1, min(MOST_POINTS, len(model.points))).astype(int)
    with np.errstate(all="ignore"):
        x, y = (d @ np.asarray(model.shape[2 * points + axis] @ body.basis.shapes).T for axis in (0, 1))
        shares = np.hypot(x, y).max(axis=1) / np.ptp(model.points, axis=0).max()
    return np.asarray(np.nan_to_num(shares, nan=np.inf))


def _inertia_is_lost(body: Reduced, d: np.ndarray) -> bool:
    """Whether the mass matrix of a body is not positive, since stiffening by rotation lessens its inertia."""
    matrices, Kc = body.element.matrices, body.element.centrifugal
    turning = np.zeros(len(d))
    turning[2] = 1.0
    if not body.basis.by_pin:
        shape = body.moved_by
        weights, poses = np.array(shape.weights), np.array(shape.poses) + d.reshape(-1, 3)
        size = (weights * poses[:, :2]).sum()
        turning = np.column_stack([-weights[:, 1], weights[:, 0], np.zeros(len(weights))]).ravel() / size
    across = np.outer(matrices["G"] @ d, turning)
    mass = matrices["M"] + across + across.T + np.outer(turning, turning) * (d @ (matrices["H"] - Kc) @ d)
    return bool(np.linalg.eigvalsh(mass)[0] < 0.0)


def _too_large(body: Reduced, time: float, share: float, *, wrong: bool) -> str:
    """The sentence on a large deformation."""
    moved = f"by {100.0 * share:.3g} % of its size" if share < 1.0 else "by more than its size"
    beyond = "beyond" if wrong else "at the edge of"
    chord = 'frame="chord", ' if body.basis.by_pin and body.basis.model.count > 3 else ""
    return (
        f"{body.label}: at t = {time:.6g} s it is deformed {moved}, {beyond} the small deformations that a reduced "
        "body is for; its errors grow with the square of that share. "
        f"Take {chord}more pins, or the body with all its nodes."
    )


def _lost_inertia(body: Reduced, time: float, share: float) -> str:
    """The sentence on an indefinite mass matrix."""
    follows = ", and its frame follows the vibrations of one pin" if body.basis.by_pin else ""
    return (
        f"{body.label}: at t = {time:.6g} s it is deformed by {100.0 * share:.3g} % of its size{follows}; stiffening "
        "by rotation then takes away more inertia than it has. Take a second pin, such as its other end, with "
        'frame="chord", or stiffening=False, or the body with all its nodes.'
    )
