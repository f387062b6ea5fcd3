"""Closing of loops: in the reference configuration, and along the motion of the drives."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import combinations
from typing import Any

import numpy as np

from flexmb.bodies.flexible_body import FlexibleBody
from flexmb.display.text import quoted
from flexmb.doctor.finding import WARNING, Finding, found
from flexmb.doctor.motions import values_of
from flexmb.errors import AssemblyError
from flexmb.linalg.dense_or_sparse import plain
from flexmb.linalg.rank import row_rank
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import GROUND, Joint
from flexmb.program.program import Program
from flexmb.start.assemble import close_loops, drive_rows, least_shift
from flexmb.start.redundant_joints import dependent_parts, shaken_pose
from flexmb.start.rigid_motion import RigidMotion
from flexmb.system.state_evaluation import StateEvaluation

POSES = 72
"""Number of instants of a motion at which its loops are closed, at least."""

LARGEST_STRIDE = 0.1
"""Largest movement of a drive between two of them [rad, or relative to the size of the mechanism]."""

MOST_POSES = 400
"""Number of instants at most: a drive that turns often is looked at for its first turns."""

MOST_TRAVEL = 30.0
"""Sum of the movements of all drives after which no further pose is computed [rad, or relative to the size]."""

OBSERVED_SPAN = 1.0
"""Time that is looked at where no drive has a period [s]."""

HALVINGS = 24
"""Number of halvings by which the last pose that closes is located."""

CREEPS = 200
"""Number of steps towards the nearest pose of a loop that cannot close, at most."""

COINCIDENT = 1e-6
"""Distance of two joints that counts as 0, relative to the size of the mechanism."""

ALIGNED = 0.02
"""Angle between two links that counts as 0 where a loop locks [rad]."""


def open_loops(closed: Program, error: AssemblyError) -> list[Finding]:
    """Findings on loops that cannot close in the reference configuration."""
    q, gaps = nearest_pose(closed)
    names = tuple(gaps)
    text = f"A loop cannot close: {', '.join(f'{name!r} stays open by {gap:.4g}' for name, gap in gaps.items())}"
    text = f"{text} (m or rad) in the nearest pose."
    shaken = shaken_pose(closed, q)
    G = StateEvaluation(closed).at(shaken).blocks[1] @ RigidMotion(closed).plain_basis(shaken)
    if row_rank(G).redundant:
        parts = dependent_parts(closed, G)
        return [found("contradicting-joints", parts, text, f"The joints {quoted(parts)} contradict one another.")]
    if not names:
        return [found("open-loop", (), str(error), "")]
    remedy = "Check lengths and points of the links of that loop, or choose positions of the drives that it can reach."
    return [found("open-loop", names, text, remedy, gap=max(gaps.values()))]


def nearest_pose(closed: Program) -> tuple[np.ndarray, dict[str, float]]:
    """The pose with the smallest gaps near the reference configuration, and the gaps of its open joints [m, rad]."""
    system, rigid = StateEvaluation(closed), RigidMotion(closed)
    q = np.array(closed.reference.q)
    for _ in range(CREEPS):
        g = system.at(q).residual
        w = least_shift(system.blocks[1] @ rigid.plain_basis(q), -g, rigid.sizes)
        size = float(np.abs(w / rigid.sizes).max(initial=0.0))
        if size < 1e-10:
            break
        part = min(1.0, 0.1 / size)
        while part > 1e-6 and np.linalg.norm(system.at(rigid.moved(q, part * w)).residual) >= np.linalg.norm(g):
            part *= 0.5
        if part <= 1e-6:
            break
        q = rigid.moved(q, part * w)
    gaps: dict[str, float] = {}
    for row, value in zip(closed.names.rows, system.at(q).residual, strict=True):
        part_name = row.partition("[")[0]
        gaps[part_name] = math.hypot(gaps.get(part_name, 0.0), float(value))
    largest = max(gaps.values(), default=0.0)
    return q, {name: gap for name, gap in gaps.items() if gap > 1e-3 * largest > 0.0}


def other_branch(closed: Program, q: np.ndarray) -> list[Finding]:
    """Findings on loops that are assembled on another branch than the one drawn, by the closed pose (n_q,) at t = 0."""
    if orientation(closed, np.array(closed.reference.q), 0.0) * orientation(closed, q, 0.0) >= 0.0:
        return []
    begin = ", ".join(
        f"{name!r} at {x:.6g}" for name, x in zip(closed.drives, *drive_positions(closed, np.zeros(1)), strict=True)
    )
    parts = weakest_parts(closed, StateEvaluation(closed).at(q).blocks[1] @ RigidMotion(closed).plain_basis(q))
    text = (
        f"Between the drawn pose and the start, {begin} (rad or m), the loops pass a singular pose: {quoted(parts)} are"
    )
    text += " assembled on another branch than the one drawn."
    remedy = "Draw the mechanism where its drives begin, on the branch that is meant."
    return [found("other-branch", parts, text, remedy)]


def locking_drives(mechanism: Mechanism, closed: Program, q: np.ndarray) -> list[Finding]:
    """Findings on loops that open, or whose branches cross, while drives move from the closed pose (n_q,) at t = 0."""
    if not closed.drives:
        return []
    bodies = [body.name for body in mechanism.bodies if isinstance(body, FlexibleBody)]
    with np.errstate(invalid="ignore"):
        times = instants(closed)
    if not np.isfinite(drive_positions(closed, times)).all():
        return []  # its motion is a finding of its own
    good, pose, side = 0.0, q, orientation(closed, q, 0.0)
    for t in times[1:]:
        try:
            pose = close_loops(closed, {}, start=pose, t=float(t))[0]
        except AssemblyError:
            finding = _locked(mechanism, closed, *last_closed(closed, pose, good, float(t)), float(times[-1]))
            return [_if_rigid(finding, bodies)] if bodies else [finding]
        if side * orientation(closed, pose, float(t)) < 0.0:
            return [_crossed(closed, pose, good, float(t))]
        good = float(t)
    return []


def orientation(closed: Program, pose: np.ndarray, t: float) -> float:
    """Sign of the determinant of the constraint equations; 0 where they are not as many as rigid motions.

    The sign changes where two branches of the motion cross.
    """
    G = StateEvaluation(closed).at(pose, t=t).blocks[1] @ RigidMotion(closed).plain_basis(pose)
    A = plain(G)
    return float(np.linalg.slogdet(A)[0]) if A.shape[0] == A.shape[1] else 0.0


def _crossed(closed: Program, pose: np.ndarray, before: float, after: float) -> Finding:
    """The finding on a singular pose that the drives pass between two instants [s]."""
    G = StateEvaluation(closed).at(pose, t=after).blocks[1] @ RigidMotion(closed).plain_basis(pose)
    parts = weakest_parts(closed, G)
    text = (
        f"Between t = {before:.6g} and {after:.6g} s the loops pass a singular pose, where two branches of the motion"
    )
    text += f" cross, and {quoted(parts)} no longer determine which one is followed."
    remedy = "Change lengths so that the links never lie on one line, or add what guides real links through that pose."
    return found("branch-point", parts, text, remedy, time=after)


def instants(closed: Program) -> np.ndarray:
    """Instants of the first period of the drives at which poses are computed [s]."""
    periods = [period for period in closed.periods if period is not None]
    span = max(periods) if periods else max([OBSERVED_SPAN, *closed.breaks(1e3)])
    grid = np.linspace(0.0, span, POSES + 1)
    for _ in range(3):
        stride = np.abs(np.diff(drive_positions(closed, grid), axis=0)).max(initial=0.0)
        limit = LARGEST_STRIDE * max(1.0, closed.length)
        if not stride > limit or len(grid) >= MOST_POSES:
            break
        grid = np.linspace(0.0, span, min(MOST_POSES, int(len(grid) * stride / limit) + 2))
    travel = np.abs(np.diff(drive_positions(closed, grid), axis=0)).sum(axis=1).cumsum()
    return grid[: 1 + int(np.searchsorted(travel, MOST_TRAVEL * max(1.0, closed.length)))]


def drive_positions(closed: Program, times: np.ndarray) -> np.ndarray:
    """Positions of the drives (times, drives) [rad, m]."""
    motions = closed.motions[: len(closed.drives)]
    ps = [np.array(motion.parameters(), dtype=float) for motion in motions]
    return np.array([[values_of(m.kernel, p, float(t))[0] for m, p in zip(motions, ps, strict=True)] for t in times])


def last_closed(closed: Program, pose: np.ndarray, good: float, bad: float) -> tuple[np.ndarray, float]:
    """Last pose and instant at which the loops close, between two instants [s]."""
    for _ in range(HALVINGS):
        middle = 0.5 * (good + bad)
        try:
            pose, good = close_loops(closed, {}, start=pose, t=middle)[0], middle
        except AssemblyError:
            bad = middle
    return pose, good


def _locked(mechanism: Mechanism, closed: Program, pose: np.ndarray, t: float, span: float) -> Finding:
    """The finding on a mechanism that locks at t [s], of a motion that lasts `span` [s]."""
    begin, here = drive_positions(closed, np.array([0.0, t]))
    drives = list(drive_rows(closed))
    G = StateEvaluation(closed).at(pose, t=t).blocks[1] @ RigidMotion(closed).plain_basis(pose)
    weak = weakest_parts(closed, G)
    aligned = aligned_joints(mechanism, closed, pose, weak)
    joints = aligned or tuple(name for name in weak if isinstance(mechanism.find(name), Joint)) or weak
    where = ", ".join(f"{name!r} at {x:.6g}" for name, x in zip(drives, here, strict=True))
    text = f"The loops close only up to t = {t:.6g} s of {span:.6g} s, with {where} (rad or m)"
    text += f"; there the joints {quoted(joints)} lie on one line." if aligned else f"; {quoted(joints)} lock."
    remedy = "Move the drives within their range, or change lengths (Grashof: shortest + longest <= the other two)."
    owners = tuple(dict.fromkeys(name.partition(".")[0] for name in drives))
    numbers = {f"{name} from": x for name, x in zip(drives, begin, strict=True)}
    numbers |= {f"{name} to": x for name, x in zip(drives, here, strict=True)}
    return found("locking-drive", (*owners, *joints), text, remedy, time=t, **numbers)


def _if_rigid(finding: Finding, bodies: list[str]) -> Finding:
    """The finding as a warning, where flexible bodies may bend as far as the drives demand."""
    text = f"With rigid bodies in place of {quoted(bodies)}: {finding.text}"
    return replace(finding, severity=WARNING, text=text, remedy=f"{finding.remedy} A flexible body has to bend.")


def weakest_parts(closed: Program, G: Any) -> tuple[str, ...]:
    """Names of the parts whose constraint equations are nearest to depending on one another, the strongest first."""
    dense = plain(G)
    lengths = np.sqrt((dense * dense).sum(axis=1))
    unit = dense / np.where(lengths > 0.0, lengths, 1.0)[:, None]
    vector = np.abs(np.linalg.svd(unit, full_matrices=False)[0][:, -1])
    shares: dict[str, float] = {}
    for row, share in zip(closed.names.rows, vector, strict=True):
        name = row.partition("[")[0]
        shares[name] = math.hypot(shares.get(name, 0.0), float(share))
    strong = {name: share for name, share in shares.items() if share > 0.05 * max(shares.values())}
    return tuple(sorted(strong, key=lambda name: -strong[name]))


def aligned_joints(mechanism: Mechanism, closed: Program, pose: np.ndarray, weak: tuple[str, ...]) -> tuple[str, ...]:
    """Three weak joints of two neighbouring links on one line in a locked pose (n_q,); () without such joints.

    `weak` are the parts whose equations nearly depend on one another.
    """
    joints = [part for part in mechanism.parts if isinstance(part, Joint) and part.name in weak]
    points = {joint.name: _point(mechanism, closed, pose, joint) for joint in joints}
    best: tuple[float, tuple[str, ...]] = (ALIGNED, ())
    for three in combinations(joints, 3):
        for middle in three:
            first, last = (joint for joint in three if joint is not middle)
            if not (_shared(first, middle) and _shared(middle, last)) or _shared(first, middle) == _shared(
                middle, last
            ):
                continue
            u, v = (points[x.name] - points[middle.name] for x in (first, last))
            lengths = np.linalg.norm(u), np.linalg.norm(v)
            if min(lengths) <= COINCIDENT * closed.length:
                continue
            sine = abs(u[0] * v[1] - u[1] * v[0]) / (lengths[0] * lengths[1])
            if sine < best[0]:
                best = (sine, (first.name, middle.name, last.name))
    return best[1]


def _shared(one: Joint, other: Joint) -> set[str]:
    """Names of the moving bodies that both joints belong to."""
    return ({one.first.name, one.second.name} & {other.first.name, other.second.name}) - {GROUND.name}


def _point(mechanism: Mechanism, closed: Program, pose: np.ndarray, joint: Joint) -> np.ndarray:
    """Place of a joint in a pose [m]."""
    end = next((e for e in joint.ends(mechanism) if e.part != GROUND.name), joint.ends(mechanism)[0])
    node = f"{end.part}.{end.node}" if end.node else end.part
    x, y, theta = (pose[closed.coordinate(f"{node}.{axis}")] for axis in ("x", "y", "theta"))
    c, s = math.cos(theta), math.sin(theta)
    return np.array([x + c * end.offset[0] - s * end.offset[1], y + s * end.offset[0] + c * end.offset[1]])
