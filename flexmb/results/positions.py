"""Positions of points of bodies, masses and momenta over a run, and solutions at other instants."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from flexmb import arguments, checks
from flexmb.display import counted
from flexmb.engine.system.state_evaluation import StateEvaluation
from flexmb.errors import InputError
from flexmb.fields import field, record
from flexmb.late import xr
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import ElasticBody
from flexmb.model.shape import BeamShape, MeshShape, PointShape
from flexmb.parts.bodies.flexible import number_of
from flexmb.program.compiler import compile as compile_mechanism
from flexmb.program.program import Program
from flexmb.results import drawing
from flexmb.results.solution import SAVED_KEY, Peaks, Solution
from flexmb.results.stress import Places, Times, Wanted, at_places, chosen_places, moved_mechanism


def positions(sol: Solution, body: str, points: Wanted | None, times: Times, mechanism: Mechanism | None) -> xr.Dataset:
    """Positions of points of a flexible body over time; see `Solution.positions`."""
    part = moved_mechanism(sol, body, mechanism).find(body)
    if not isinstance(part, ElasticBody):
        raise InputError(f"{part.label} is no flexible body; its signals {body}.x, .y, .theta tell where it is.")
    every = np.arange(len(sol.time))
    instants = every if times is None else drawing.nearest_to_each(sol, np.asarray(times, dtype=float))
    if part.theory == "beams":
        known = {node.name: number_of(node.name) for node in part.nodes()}
        moved = drawing.poses(sol, part.name, known, instants)[..., :2]
        known |= {alias: known[name] for alias, name in part.aliases.items()}
    else:
        known = {}
        shape = next((s for s in sol.shapes if isinstance(s, MeshShape) and s.part == part.name), None)
        if shape is None:
            pins = ", ".join(node.name for node in part.nodes())
            raise InputError(f"{part.label} has no drawn points, only its nodes: {pins}.")
        moved = drawing.surface(sol, shape, instants).points
    places = Places(np.arange(moved.shape[1]), part.reference_points()[: moved.shape[1]], known, {})
    chosen = places.nodes if points is None else chosen_places(part.label, places, points)
    own = {"node": (places.nodes, ""), "x0": (places.points[:, 0], "m"), "y0": (places.points[:, 1], "m")}
    columns = {axis: (moved[..., k], {"units": "m"}) for k, axis in enumerate("xy")}
    return at_places(sol, part.name, instants, chosen, own, columns)


@record
class Momentum:
    """Mass and momenta at n instants."""

    time: np.ndarray = field("(n,) instants", "s")
    mass: float = field("the mass", "kg")
    centre: np.ndarray = field("(n, 2) centre of mass", "m")
    linear: np.ndarray = field("(n, 2) linear momentum [kg m/s]")
    angular: np.ndarray = field("(n,) angular momentum about the origin [kg m^2/s]")

    def __repr__(self) -> str:
        span = f", {self.time[0]:.6g} to {self.time[-1]:.6g} s" if len(self.time) else ""
        return f"Momentum of {self.mass:.6g} kg at {counted(len(self.time), 'instant')}{span}"


@arguments.checked
def momentum(mechanism: Mechanism, solution: Solution, bodies: Sequence[str] | None = None) -> Momentum:
    """Centre of mass, linear and angular momentum of bodies at the saved instants of a solution.

    Parameters
    ----------
    mechanism : the mechanism that was simulated.
    solution : its solution.
    bodies : names of the bodies that are counted together; None: all.

    Raises
    ------
    InputError : the name of no body, no body at all, a solution of another mechanism.

    Notes
    -----
    With the mass matrix M(q) and rigid motions e_x, e_y, e_theta (about the origin) of the bodies, the momenta are
    e^T M v, the mass is e_x^T M e_x, and m (-y, x) of the centre of mass are e_x^T M e_theta and e_y^T M e_theta: the
    consistent mass of beams and their bosses are counted, not masses on the nodes.
    Mass that couples bodies (elements of one's own) is counted where velocities of the chosen bodies feel it.
    """
    program, label = compile_mechanism(mechanism), f"momentum {mechanism.name!r}"
    checks.instance(label, "solution", solution, Solution, "what simulate(...) or load(...) returns")
    names = program.names.bodies if bodies is None else checks.sequence(label, "bodies", bodies, "names")
    for name in names:
        checks.one_of(label, "body", name, program.names.bodies)
    if not names:
        raise InputError(f"{label}: bodies is empty; name at least one, or leave it out for all.")
    n_b, places = program.tables.sizes.n_b, _places_of_motion(label, solution, program)
    owners = np.asarray([*program.names.bodies, *[""] * (program.n_q - n_b)])
    q, v = np.zeros((2, program.n_q))  # states of controls have no momentum
    chosen = np.isin(owners[np.asarray(program.reference.body[::3])], names)
    system, rows = StateEvaluation(program), []
    for values in solution.values:
        q[:n_b], v[:n_b] = values[places[:n_b]], values[places[n_b:]]
        rigid, on = np.zeros((len(q), 3)), chosen.astype(float)
        rigid[0::3, 0], rigid[1::3, 1], rigid[2::3, 2] = on, on, on
        rigid[0::3, 2], rigid[1::3, 2] = -on * q[1::3], on * q[0::3]
        M = system.mass(q)
        rows.append(np.concatenate([rigid.T @ (M @ v), (rigid.T @ (M @ rigid))[:2].ravel()]))
    found = np.array(rows).reshape(-1, 9)
    mass = float(found[0, 3]) if len(found) else 0.0
    centre = np.stack([found[:, 8], -found[:, 5]], axis=1) / (mass or 1.0)
    return Momentum(np.asarray(solution.time), mass, centre, found[:, :2], found[:, 2])


def _places_of_motion(label: str, solution: Solution, program: Program) -> np.ndarray:
    """Places of positions and velocities of bodies (2 n_b,) among the signals of the solution."""
    known, places = program.names.signals, solution.signals.places
    complete = SAVED_KEY in solution.model or len(places) >= len(program.reported)
    if not set(solution.names) <= known.places.keys() or not complete:
        raise InputError(f"{label}: the solution of {solution.name!r} has other signals. Give that of this mechanism.")
    given, own = solution.restart.get("model", np.zeros(0)), program.fingerprint  # methods may have own kernels
    if given.ndim == 2 and np.array_equal(given[0], own[0]) and not np.array_equal(given[1], own[1]):
        raise InputError(f"{label}: the solution is of parts with other numbers. Give the mechanism that moved.")
    n, n_b = program.n_q, program.tables.sizes.n_b
    needed = (*known.names[:n_b], *known.names[n : n + n_b])
    missing = [name for name in needed if name not in places]
    if missing:
        text = f"{label}: {len(missing)} positions and velocities were not saved, the first is {missing[0]!r}"
        raise InputError(f"{text}. Add them to simulate(..., signals=[...]), or leave it out to save all.")
    return np.array([places[name] for name in needed])


# Solutions at other instants than the saved ones, and with a magnified deformation, for pictures and films

COORDINATES = (".x", ".y", ".theta")  # endings of the names of coordinates


def at_times(sol: Solution, times: np.ndarray) -> Solution:
    """Solution whose rows belong to any instants between the first and the last saved row."""
    # Coordinates follow cubic polynomials through both neighbouring rows, with the slopes there of the parabolas
    # through three rows (Catmull and Rom). Other signals are interpolated linearly; modes keep the value of the row
    # before. `times` (n,) increase [s].
    rows = np.flatnonzero(np.append(np.diff(sol.time) > 0.0, True))  # the last of rows of one time
    time = sol.time[rows]
    left = np.clip(np.searchsorted(time, times, side="right") - 1, 0, max(len(rows) - 2, 0))
    right = np.minimum(left + 1, len(rows) - 1)
    h = time[right] - time[left]
    w = np.clip(np.divide(times - time[left], h, out=np.zeros(len(times)), where=h > 0.0), 0.0, 1.0)[:, None]
    before, after = sol.values[rows[left]], sol.values[rows[right]]
    values = np.where(w < 1.0, before + w * (after - before), after)
    held = [k for name, k in sol.signals.places.items() if name.endswith(".mode")]
    values[:, held] = np.where(w < 1.0, before[:, held], after[:, held])
    if len(rows) > 2:
        smooth = [k for name, k in sol.signals.places.items() if name.endswith(COORDINATES)]
        change = (after - before)[:, smooth]
        first, second = (h[:, None] * _slopes(sol.values, time, rows, k, smooth) - change for k in (left, right))
        values[:, smooth] += w * (1.0 - w) * ((1.0 - w) * first - w * second)
    return with_values(sol, np.asarray(times, dtype=float), values)


def _slopes(values: np.ndarray, time: np.ndarray, rows: np.ndarray, k: np.ndarray, places: list[int]) -> np.ndarray:
    """Slopes at rows k of the parabolas through three rows each."""
    begin = np.clip(k - 1, 0, len(rows) - 3)
    t0, t1, t2 = (time[begin + j][:, None] for j in range(3))
    x0, x1, x2 = (values[rows[begin + j]][:, places] for j in range(3))
    t, d01, d12 = time[k][:, None], (x1 - x0) / (t1 - t0), (x2 - x1) / (t2 - t1)
    return np.asarray(d01 + (2.0 * t - t0 - t1) * (d12 - d01) / (t2 - t0))


def with_values(sol: Solution, time: np.ndarray, values: np.ndarray) -> Solution:
    """Solution with other rows: instants (n,) [s] and signals (n, n_s)."""
    peaks = Peaks(np.abs(values).max(axis=0, initial=0.0), np.zeros(values.shape[1]))
    return replace(sol, time=time, values=values, peaks=peaks)


# Error of sums of shapes over the largest displacement, and over the size of a body; no magnification shows more.
SEEN, ROUND_OFF = 2.5e-4, 1e-9


@dataclass(frozen=True)
class FlexibleMotion:
    """A flexible body at n instants, and its unstressed shape, which is laid through its joints by least squares."""

    # Through its clamped end, if it has no other joint; through all its nodes, if it has none; with one joint that lets
    # it turn, it turns with all of them.
    part: str
    nodes: tuple[str, ...]  # (m) their names
    reference: np.ndarray  # (m, 3) x, y, theta of the nodes of the unstressed body in a frame of its own [m, rad]
    poses: np.ndarray  # (n, m, 3) those of the body
    motion: np.ndarray  # (n, 3) x, y, theta of this frame [m, rad]
    middle: np.ndarray  # (2,) middle of the joints in the frame [m]
    stretch: np.ndarray  # (n,) by which the unstressed body must grow about the middle to reach its joints [1]

    @cached_property
    def displacements(self) -> np.ndarray:
        """(n, m, 3) poses of the nodes in the frame, less the reference [m, rad]."""
        turned = self.poses[..., 2] - self.motion[:, 2, None] - self.reference[:, 2]
        moved = self.seen(self.poses[..., :2]) - self.reference[:, :2]
        return np.concatenate([moved, (turned - drawing.whole_turns(turned))[..., None]], axis=-1)

    def seen(self, points: np.ndarray) -> np.ndarray:
        """Places (n, k, 2) [m] in the frame."""
        x, y, angle = np.moveaxis(self.motion[:, None], -1, 0)
        c, s = np.cos(angle), np.sin(angle)
        dx, dy = points[..., 0] - x, points[..., 1] - y
        return np.stack([c * dx + s * dy, c * dy - s * dx], axis=-1)

    def laid(self) -> np.ndarray:
        """(n, m, 3) poses of the nodes of the unstressed body, stretched to its joints, with the turns of the body."""
        stretched = self.middle + self.stretch[:, None, None] * (self.reference[:, :2] - self.middle)
        turned, at = self.reference[:, 2] + self.motion[:, 2, None], drawing.carried(self.motion[:, None], stretched)
        return np.concatenate([at, (turned + drawing.whole_turns(self.poses[..., 2] - turned))[..., None]], axis=-1)

    def deformation(self, points: np.ndarray, reference: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Factors (n, k) of few shapes (k, j, 2) whose sums are the displacements of points (n, j, 2) [m] in the frame.

        They begin at a reference (j, 2) [m].
        """
        moved = (self.seen(points) - reference).reshape(len(points), -1)
        error = max(SEEN * np.abs(moved).max(initial=0.0), ROUND_OFF * np.ptp(reference, axis=0).max(initial=0.0))
        factors, shapes = drawing.few_shapes(moved, float(error))
        return factors, shapes.reshape(len(shapes), -1, 2)


def flexible_motions(sol: Solution, instants: np.ndarray) -> list[FlexibleMotion]:
    """All flexible bodies at saved instants with numbers (n,), bodies of beams first."""
    beams: dict[str, list[BeamShape]] = {}
    for element in sol.shapes:
        if isinstance(element, BeamShape):
            beams.setdefault(element.part, []).append(element)
    bodies: dict[str, tuple[dict[str, Any], Any]] = {part: (unstressed(own), None) for part, own in beams.items()}
    bodies |= {s.part: (dict(zip(s.nodes, s.poses, strict=False)), s) for s in sol.shapes if isinstance(s, MeshShape)}
    found = []
    for part, (shape, mesh) in bodies.items():
        nodes = tuple(shape) if mesh is None else mesh.nodes
        now = drawing.poses(sol, part, nodes, instants)
        reference = np.array(list(shape.values())) if shape else now[0]  # files of before have none of meshes
        turning = list(range(len(nodes)))
        if mesh is not None and mesh.basis:  # of a reduced body its pins alone
            turning = [k for k, weight in enumerate(mesh.weights) if any(weight)] or [0]
        # Rigid motion from the reference to the poses, by the nodes that joints hold, or by the turning ones. Nodes
        # of modes go with the middle of the pins, from which their amplitudes count.
        joints = body_joints(sol, part, nodes)
        held = list(joints) if joints else turning
        middle, centre = reference[held, :2].mean(axis=0), now[:, held, :2].mean(axis=1)
        stretch = np.ones(len(now))
        seen = held if len(held) > 1 or joints.get(held[0]) else turning  # a cantilever has one node
        if len(seen) == 1:
            angle = now[:, seen[0], 2] - reference[seen[0], 2]
        else:
            around = reference[seen, :2] - middle
            along, across = drawing.turned_by(around, now[:, seen, :2] - centre[:, None])
            angle = np.unwrap(np.arctan2(across, along))
            if len(held) > 1 and joints:
                stretch = np.hypot(across, along) / float(np.sum(around**2))
        fit = np.column_stack([drawing.carried(np.column_stack([centre, angle]), -middle), angle]), middle, stretch
        found.append(FlexibleMotion(part, nodes, reference, now, *fit))
    return found


def magnified(sol: Solution, factor: float) -> Solution:
    """Solution with a magnified deformation of the flexible bodies, for pictures alone."""
    # The deformation is the difference from the unstressed shape (`FlexibleMotion`), stretched as much as two joints
    # are apart. So bodies stay together at their joints. The factor 1 gives the solution itself.
    if factor == 1.0:
        return sol
    values, rows = sol.values.copy(), np.arange(len(sol.time))
    for body in flexible_motions(sol, rows):
        rigid = body.laid()
        places = [sol.signals.places[f"{body.part}.{node}{axis}"] for node in body.nodes for axis in COORDINATES]
        values[:, places] = (rigid + factor * (body.poses - rigid)).reshape(len(rows), -1)
    return with_values(sol, sol.time, values)


def unstressed(beams: Sequence[BeamShape]) -> dict[str, tuple[float, float, float]]:
    """Poses x, y, theta of the nodes of an unstressed, connected body by name, in the frame of its first node."""
    found, left = {beams[0].start: (0.0, 0.0, 0.0)}, list(beams)
    while left:
        near = next((beam for beam in left if beam.start in found or beam.end in found), None)
        if near is None:  # a body in two pieces: the next one begins a frame of its own
            found[left[0].start] = (0.0, 0.0, 0.0)
            continue
        left.remove(near)
        ahead = near.start in found
        x, y, theta = found[near.start if ahead else near.end]
        _, first, last = near.free  # rotations of the unstressed element against its chord
        direction = theta + (near.start_angle - first if ahead else near.end_angle - last)
        length = near.chord if ahead else -near.chord
        other = direction + (last - near.end_angle if ahead else first - near.start_angle)
        place = (x + length * np.cos(direction), y + length * np.sin(direction), other)
        found.setdefault(near.end if ahead else near.start, place)
    return found


def body_joints(sol: Solution, part: str, nodes: tuple[str, ...]) -> dict[int, bool]:
    """Numbers of the nodes of a body that carry joints, and whether one of them holds the angle."""
    found: dict[int, bool] = {}
    for shape in sol.shapes:
        if isinstance(shape, PointShape) and shape.other is not None:
            for body, node in ((shape.body, shape.node), shape.other[:2]):
                if body == part and node in nodes:
                    k = nodes.index(node)
                    found[k] = found.get(k, False) or shape.kind in ("fixed", "prismatic")
    return found
