"""Findings on connections, loops and the rank of the constraints."""

import math
from dataclasses import replace
from itertools import combinations
from typing import Any

import numpy as np

from flexmb.display import counted, listed, quoted
from flexmb.engine.linalg.dense import plain
from flexmb.engine.linalg.rank import RANK_TOLERANCE, surplus_rows
from flexmb.engine.system.state_evaluation import StateEvaluation
from flexmb.errors import AssemblyError
from flexmb.findings.finding import NOTE, WARNING, Finding, found
from flexmb.late import scipy, sp
from flexmb.model.law import values_of
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import GROUND, Body, Joint
from flexmb.planar import from_frame
from flexmb.program.program import Program
from flexmb.statics.start import consistent

# Connections of the bodies: groups of connected bodies, and groups without connection to the ground

SAME_POINT = 1e-6  # distance of two points over the length of the longest link, below which they are one


def free_bodies(mechanism: Mechanism) -> list[Finding]:
    """Groups of bodies that nothing connects to the ground; a mechanism that floats as a whole is only noted."""
    # Groups that joints, springs, contacts or elements connect; the ground is a body, too.
    places = {name: k for k, name in enumerate((GROUND.name, *(body.name for body in mechanism.bodies)))}
    others = [part.references() for part in mechanism.parts if not isinstance(part, Body)]
    ends = [[places[name] for name in named if name in places] for named in others]
    links = np.array([(own[0], k) for own in ends for k in own], dtype=int).reshape(-1, 2)
    matrix = sp.coo_array((np.ones(len(links)), links.T), shape=(len(places), len(places)))
    count, group = sp.csgraph.connected_components(matrix, directed=False)
    groups = [tuple(name for name, k in places.items() if group[k] == number) for number in range(count)]
    loose = [group for group in groups if GROUND.name not in group]
    floats = len(loose) == 1 and (GROUND.name,) in groups
    findings = []
    for group in loose:
        verb = "are" if len(group) > 1 else "is"
        text = f"{quoted(group)} {verb} connected to nothing else: free in x, y and rotation."
        remedy = "Connect it by a joint, a spring or a contact, or leave it out, unless it shall fly."
        item = found("free-body", group, text, remedy)
        findings.append(replace(item, remedy="", severity=NOTE) if floats else item)
    return findings


def left_out_links(mechanism: Mechanism) -> list[Finding]:
    """Links that end at a joint of two other bodies and are joined to nothing there: the joint has the wrong body."""
    joints = [part for part in mechanism.parts if isinstance(part, Joint) and part.at is not None]
    others = [part for part in mechanism.parts if not isinstance(part, Body) and part not in joints]
    held = {name for part in others if len(part.references()) > 1 for name in part.references()}
    bars = [body for body in mechanism.bodies if body.bar_ends]
    near, findings = SAME_POINT * max((math.dist(*bar.bar_ends) for bar in bars), default=0.0), []
    for bar, end in [(body, point) for body in bars if body.name not in held for point in body.bar_ends]:
        here = [joint for joint in joints if math.dist(joint.at, end) <= near]
        if not here or any(bar.name in joint.references() for joint in here):
            continue
        two = [body for body in (here[0].first, here[0].second) if isinstance(body, Body)]
        points = {body.name: (*body.bar_ends, *((node.x, node.y) for node in body.nodes())) for body in two}
        apart = [name for name, own in points.items() if all(math.dist(one, end) > near for one in own)]
        wrong = [repr(name) for name in apart] or ["one of them"]
        text = f"{here[0].label} joins {quoted([b.name for b in two])} at ({end[0]:.4g}, {end[1]:.4g}) m, where"
        remedy = f"Was {bar.name!r} meant in place of {' or '.join(wrong)}?"
        text = f"{text} {bar.label} ends, joined to nothing."
        findings.append(found("left-out-link", (here[0].name, bar.name), text, remedy))
    return findings


# Rank of the constraints: redundant, contradicting and driven rows, singular poses, free motions

PREFERENCE = 0.1  # weight by which angles are preferred to lengths as free coordinates
LISTED_MOTIONS = 6  # number of free motions that are named at most


def redundancies(program: Program, closed: Program, q: np.ndarray) -> list[Finding]:
    """Redundant joints, drives too many, and singular poses, at a closed pose (n_q,)."""
    repeated = consistent.redundancy(program, q)
    if repeated is None:
        return _hidden(program, closed, q)
    is_singular, findings = consistent.redundant_rows(program, closed, q, 0.0) == 0, []
    if (count := repeated.rows) > 0:
        names, rows = repeated.joints, f"{count} of their equations {'is' if count == 1 else 'are'} redundant"
        if is_singular:
            text = f"In the reference configuration the joints {quoted(names)} repeat one another ({rows}): a singular"
            remedy = "Start a little beside it, for example at another crank angle; see also redundant='least-norm'."
            findings.append(found("singular-pose", names, f"{text} pose.", remedy, redundant=count))
        else:
            text = f"The joints {quoted(names)} repeat one another in every pose near this one: {rows}."
            remedy = "Remove one of them, replace a Prismatic or Fixed by a Revolute, make a link flexible,"
            remedy += " or simulate(..., redundant='least-norm')."
            findings.append(found("redundant-joints", names, text, remedy, redundant=count))
    if (extra := repeated.excess) > 0:
        owners = [drive.partition(".")[0] for drive in program.drives]
        drives = [name for name in repeated.driven if name in owners] or owners
        others = [name for name in repeated.driven if name not in owners]
        joints = f" (with the joints {quoted(others)})" if others else ""
        if is_singular and not repeated.structural:
            text = f"{quoted(drives)} cannot move the mechanism from this pose{joints}: a dead centre."
            remedy = "Start at another position of the drives."
            findings.append(found("singular-pose", drives, text, remedy, redundant=extra))
        else:
            verb = "prescribes" if len(drives) == 1 else "prescribe"
            text = f"{quoted(drives)} {verb} {counted(extra, 'motion')} more than the joints leave free{joints}."
            findings.append(found("over-driven", drives, text, "Remove drives, or joints.", excess=extra))
    return findings


def _hidden(program: Program, closed: Program, q: np.ndarray) -> list[Finding]:
    """More drives than the ideal mechanism has freedom, where only clearances give way."""
    if closed is program or not program.names.contacts:
        return []
    joints = np.flatnonzero(np.asarray(closed.tables.constraints.motion) < 0)
    matrices = [consistent.body_rows(closed, x) for x in (consistent.shaken_pose(closed, q), q)]
    extra = min(len(surplus_rows(A)) - len(surplus_rows(A[joints])) for A in matrices)
    if extra <= 0:
        return []
    drives = [drive.partition(".")[0] for drive in program.drives]
    names = [name for name in consistent.dependent_parts(closed, matrices[0]) if name in drives] or drives
    text = f"With ideal joints {quoted(names)} prescribe {counted(extra, 'motion')} too many; only clearances yield."
    return [found("hidden-over-drive", names, text, "Remove a drive, unless they shall work against each other.")]


def free_motions(closed: Program, q: np.ndarray) -> list[Finding]:
    """Motions that neither joints nor drives prescribe, named by coordinates that can be chosen freely."""
    # In `closed` clearance joints are ideal ones, and flexible bodies count as rigid; the pose (n_q,) is closed.
    rigid, A = consistent.RigidMotion(closed), plain(consistent.body_rows(closed, q))
    scale = np.tile([1.0, 1.0, PREFERENCE / max(closed.length, 1e-300)], rigid.count)
    ways = scipy.linalg.null_space(A * scale, rcond=RANK_TOLERANCE) if len(A) else np.eye(3 * rigid.count)
    if ways.shape[1] == 0:
        return []
    # Coordinates whose rates can be chosen freely and then fix all others.
    order = scipy.linalg.qr(ways.T, mode="r", pivoting=True)[1][: ways.shape[1]]
    axes = ("x", "y", "theta")
    names = tuple(f"{closed.names.bodies[k // 3]}.{axes[k % 3]}" for k in sorted(order.tolist()))
    verb = "is" if len(names) == 1 else "are"
    text = f"{counted(len(names), 'motion')} {verb} not driven; free coordinates, one choice: "
    text += listed(names, LISTED_MOTIONS)
    parts = tuple(dict.fromkeys(name.partition(".")[0] for name in names))
    return [found("free-motion", parts, f"{text}. Loads alone decide how they move.", free=len(names))]


# Closing of loops: in the reference configuration, and along the motion of the drives

POSES = 72  # number of instants of a motion at which its loops are closed, at least
LARGEST_STRIDE = 0.1  # largest movement of a drive between two of them [rad, or relative to the size of the mechanism]
MOST_POSES = 400  # number of instants at most: a drive that turns often is looked at for its first turns
MOST_TRAVEL = 30.0  # sum of the movements of all drives after which poses end [rad, or relative to the size]
OBSERVED_SPAN = 1.0  # time that is looked at where no drive has a period [s]
HALVINGS = 24  # number of halvings by which the last pose that closes is located
CREEPS = 200  # number of steps towards the nearest pose of a loop that cannot close, at most
COINCIDENT = 1e-6  # distance of two joints that counts as 0, relative to the size of the mechanism
ALIGNED = 0.02  # angle between two links that counts as 0 where a loop locks [rad]


def open_loops(closed: Program, error: AssemblyError) -> list[Finding]:
    """Findings on loops that cannot close in the reference configuration."""
    # The pose with the smallest gaps near the reference configuration, and the gaps of its open joints [m, rad].
    system, rigid, q = StateEvaluation(closed), consistent.RigidMotion(closed), np.array(closed.reference.q)
    for _ in range(CREEPS):
        g = system.at(q).residual
        w = consistent.least_shift(system.blocks[1] @ rigid.plain_basis(q), -g, rigid.sizes)
        size = float(np.abs(w / rigid.sizes).max(initial=0.0))
        if size < 1e-10:
            break
        part = min(1.0, 0.1 / size)
        while part > 1e-6 and np.linalg.norm(system.at(rigid.moved(q, part * w)).residual) >= np.linalg.norm(g):
            part *= 0.5
        if part <= 1e-6:
            break
        q = rigid.moved(q, part * w)
    gaps = consistent.by_part(closed, system.at(q).residual)
    largest = max(gaps.values(), default=0.0)
    gaps = {name: gap for name, gap in gaps.items() if gap > 1e-3 * largest > 0.0}
    names = tuple(gaps)
    text = f"A loop cannot close: {', '.join(f'{name!r} stays open by {gap:.4g}' for name, gap in gaps.items())}"
    text = f"{text} (m or rad) in the nearest pose."
    G = consistent.body_rows(closed, consistent.shaken_pose(closed, q))
    if surplus_rows(G):
        parts = consistent.dependent_parts(closed, G)
        return [found("contradicting-joints", parts, text, f"The joints {quoted(parts)} contradict one another.")]
    if not names:
        return [found("open-loop", (), str(error), "")]
    remedy = "Check lengths and points of the links of that loop, or choose positions of the drives that it can reach."
    return [found("open-loop", names, text, remedy, gap=max(gaps.values()))]


def other_branch(closed: Program, q: np.ndarray) -> list[Finding]:
    """Findings on loops that are assembled on another branch than the one drawn, by the closed pose (n_q,) at t = 0."""
    if orientation(closed, np.array(closed.reference.q), 0.0) * orientation(closed, q, 0.0) >= 0.0:
        return []
    positions = drive_positions(closed, np.zeros(1))
    begin = ", ".join(f"{name!r} at {x:.6g}" for name, x in zip(closed.drives, *positions, strict=True))
    parts = weakest_parts(closed, consistent.body_rows(closed, q))
    text = f"Between the drawn pose and the start, {begin} (rad or m), the loops pass a singular pose: {quoted(parts)}"
    text += " are assembled on another branch than the one drawn."
    remedy = "Draw the mechanism where its drives begin, on the branch that is meant."
    return [found("other-branch", parts, text, remedy)]


def locking_drives(mechanism: Mechanism, closed: Program, q: np.ndarray) -> list[Finding]:
    """Findings on loops that open, or whose branches cross, while drives move from the closed pose (n_q,) at t = 0."""
    if not closed.drives:
        return []
    bodies = [body.name for body in mechanism.bodies if body.is_elastic]
    with np.errstate(invalid="ignore"):
        times = instants(closed)
    if not np.isfinite(drive_positions(closed, times)).all():
        return []  # its motion is a finding of its own
    good, pose, side = 0.0, q, orientation(closed, q, 0.0)
    for t in times[1:]:
        try:
            pose = consistent.close_loops(closed, {}, start=pose, t=float(t))[0]
        except AssemblyError:
            finding = _locked(mechanism, closed, pose, (good, float(t), float(times[-1])))
            if not bodies:
                return [finding]
            text = f"With rigid bodies in place of {quoted(bodies)}: {finding.text}"
            remedy = f"{finding.remedy} A flexible body has to bend."
            return [replace(finding, severity=WARNING, text=text, remedy=remedy)]
        if side * orientation(closed, pose, float(t)) < 0.0:
            parts = weakest_parts(closed, consistent.body_rows(closed, pose, float(t)))
            text = f"Between t = {good:.6g} and {t:.6g} s the loops pass a singular pose, where two branches of the"
            text += f" motion cross, and {quoted(parts)} no longer determine which one is followed."
            remedy = "Change lengths so that the links never lie on one line, or add what guides real links"
            remedy += " through that pose."
            return [found("branch-point", parts, text, remedy, time=float(t))]
        good = float(t)
    return []


def orientation(closed: Program, pose: np.ndarray, t: float) -> float:
    """Sign of the determinant of the constraints, which changes between branches; 0 where they are not square."""
    A = plain(consistent.body_rows(closed, pose, t))
    return float(np.linalg.slogdet(A)[0]) if A.shape[0] == A.shape[1] else 0.0


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


def _locked(mechanism: Mechanism, closed: Program, pose: np.ndarray, times: tuple[float, float, float]) -> Finding:
    """Finding on a mechanism that locks; times [s]: of the closed `pose`, of one that does not close, of the end."""
    t, bad, span = times
    for _ in range(HALVINGS):
        middle = 0.5 * (t + bad)
        try:
            pose, t = consistent.close_loops(closed, {}, start=pose, t=middle)[0], middle
        except AssemblyError:
            bad = middle
    begin, here = drive_positions(closed, np.array([0.0, t]))
    drives, weak = list(consistent.drive_rows(closed)), weakest_parts(closed, consistent.body_rows(closed, pose, t))
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


def weakest_parts(closed: Program, G: Any) -> tuple[str, ...]:
    """Names of the parts whose constraint equations are nearest to depending on one another, the strongest first."""
    dense = plain(G)
    lengths = np.sqrt((dense * dense).sum(axis=1))
    unit = dense / np.where(lengths > 0.0, lengths, 1.0)[:, None]
    shares = consistent.by_part(closed, np.abs(np.linalg.svd(unit, full_matrices=False)[0][:, -1]))
    strong = {name: share for name, share in shares.items() if share > 0.05 * max(shares.values())}
    return tuple(sorted(strong, key=lambda name: -strong[name]))


def aligned_joints(mechanism: Mechanism, closed: Program, pose: np.ndarray, weak: tuple[str, ...]) -> tuple[str, ...]:
    """Three weak joints of two neighbouring links on one line in a locked pose (n_q,), of the parts `weak`; or ()."""
    joints = [part for part in mechanism.parts if isinstance(part, Joint) and part.name in weak]
    points = {}
    for joint in joints:
        own = next((e for e in joint.ends(mechanism) if e.part != GROUND.name), joint.ends(mechanism)[0])
        node = f"{own.part}.{own.node}" if own.node else own.part
        x, y, theta = (pose[closed.coordinate(f"{node}.{axis}")] for axis in ("x", "y", "theta"))
        points[joint.name] = np.array(from_frame((x, y), theta, own.offset))
    best: tuple[float, tuple[str, ...]] = (ALIGNED, ())
    for three in combinations(joints, 3):
        for middle in three:
            first, last = (joint for joint in three if joint is not middle)
            at, end = _shared(first, middle), _shared(middle, last)
            if not (at and end) or at == end:
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
