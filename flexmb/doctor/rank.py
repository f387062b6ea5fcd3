"""Rank of the constraints: redundant, contradicting and driven rows, singular poses, free motions."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flexmb.display.text import counted, quoted
from flexmb.doctor.finding import Finding, found
from flexmb.linalg.dense_or_sparse import plain
from flexmb.linalg.rank import RANK_TOLERANCE, row_rank
from flexmb.program.program import Program
from flexmb.start.redundant_joints import dependent_parts, redundancy, redundant_rows, shaken_pose
from flexmb.start.rigid_motion import RigidMotion
from flexmb.system.state_evaluation import StateEvaluation

PREFERENCE = 0.1
"""Weight by which angles are preferred to lengths as free coordinates."""

LISTED_MOTIONS = 6
"""Number of free motions that are named at most."""


def redundancies(program: Program, closed: Program, q: np.ndarray) -> list[Finding]:
    """Redundant joints, drives too many, and singular poses, at a closed pose (n_q,)."""
    found = redundancy(program, q)
    if found is None:
        return _hidden(program, closed, q)
    always, findings = redundant_rows(program, closed, q, 0.0), []
    if found.rows > 0:
        findings.append(_of_joints(found.joints, found.rows, singular=always == 0))
    if found.excess > 0:
        singular = always == 0 and not found.structural
        findings.append(_of_drives(program, found.driven, found.excess, singular=singular))
    return findings


def _of_joints(names: tuple[str, ...], count: int, *, singular: bool) -> Finding:
    rows = f"{count} of their equations {'is' if count == 1 else 'are'} redundant"
    if singular:
        text = (
            f"in the reference configuration the joints {quoted(names)} repeat one another ({rows}): a singular pose."
        )
        remedy = "Start a little beside it, for example at another crank angle; see also redundant='least-norm'."
        return found("singular-pose", names, text[0].upper() + text[1:], remedy, redundant=count)
    text = f"The joints {quoted(names)} repeat one another in every pose near this one: {rows}."
    remedy = (
        "Remove one of them, replace a Prismatic or Fixed by a Revolute, make a link flexible, "
        "or simulate(..., redundant='least-norm')."
    )
    return found("redundant-joints", names, text, remedy, redundant=count)


def _of_drives(program: Program, names: Sequence[str], extra: int, *, singular: bool) -> Finding:
    owners = [drive.partition(".")[0] for drive in program.drives]
    drives = [name for name in names if name in owners] or owners
    others = [name for name in names if name not in owners]
    joints = f" (with the joints {quoted(others)})" if others else ""
    if singular:
        text = f"{quoted(drives)} cannot move the mechanism from this pose{joints}: a dead centre."
        return found("singular-pose", drives, text, "Start at another position of the drives.", redundant=extra)
    verb = "prescribes" if len(drives) == 1 else "prescribe"
    text = f"{quoted(drives)} {verb} {counted(extra, 'motion')} more than the joints leave free{joints}."
    return found("over-driven", drives, text, "Remove drives, or joints.", excess=extra)


def _hidden(program: Program, closed: Program, q: np.ndarray) -> list[Finding]:
    """More drives than the ideal mechanism has freedom, where only clearances give way."""
    if closed is program or not program.names.contacts:
        return []
    driven = np.asarray(closed.tables.constraints.motion) >= 0
    joints = np.flatnonzero(~driven)
    poses = (shaken_pose(closed, q), q)
    matrices = [StateEvaluation(closed).at(x).blocks[1] @ RigidMotion(closed).plain_basis(x) for x in poses]
    extra = min(len(row_rank(A).redundant) - len(row_rank(A[joints]).redundant) for A in matrices)
    if extra <= 0:
        return []
    A = matrices[0]
    drives = [drive.partition(".")[0] for drive in program.drives]
    names = [name for name in dependent_parts(closed, A) if name in drives] or drives
    text = f"With ideal joints {quoted(names)} prescribe {counted(extra, 'motion')} too many; only clearances yield."
    return [found("hidden-over-drive", names, text, "Remove a drive, unless they shall work against each other.")]


def free_motions(closed: Program, q: np.ndarray) -> list[Finding]:
    """Motions that neither joints nor drives prescribe, named by coordinates that can be chosen freely.

    In `closed` clearance joints are ideal ones, and flexible bodies count as rigid; the pose (n_q,) is closed.
    """
    names = free_coordinates(closed, q)
    if not names:
        return []
    verb = "is" if len(names) == 1 else "are"
    text = f"{counted(len(names), 'motion')} {verb} not driven; free coordinates, one choice: "
    text += ", ".join(names[:LISTED_MOTIONS])
    text += ", ..." if len(names) > LISTED_MOTIONS else ""
    parts = tuple(dict.fromkeys(name.partition(".")[0] for name in names))
    return [found("free-motion", parts, f"{text}. Loads alone decide how they move.", free=len(names))]


def free_coordinates(closed: Program, q: np.ndarray) -> tuple[str, ...]:
    """Coordinates of bodies whose rates can be chosen freely and then fix all others."""
    from scipy.linalg import null_space, qr

    rigid = RigidMotion(closed)
    A = plain(StateEvaluation(closed).at(q).blocks[1] @ rigid.plain_basis(q))
    scale = np.tile([1.0, 1.0, PREFERENCE / max(closed.length, 1e-300)], rigid.count)
    ways = null_space(A * scale, rcond=RANK_TOLERANCE) if len(A) else np.eye(3 * rigid.count)
    if ways.shape[1] == 0:
        return ()
    order = qr(ways.T, mode="r", pivoting=True)[1][: ways.shape[1]]
    axes = ("x", "y", "theta")
    return tuple(f"{closed.names.bodies[k // 3]}.{axes[k % 3]}" for k in sorted(order.tolist()))
