"""Moving mechanism of a page: frames that carry nodes, shapes, flexible parts, stresses; the player."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from flexmb.errors import InputError
from flexmb.model.elastic_body import ElasticBody
from flexmb.model.mechanism import Mechanism
from flexmb.model.shape import (
    MARKER,
    TRACE,
    ArrowShape,
    BeamShape,
    CircleShape,
    LineShape,
    MeshShape,
    Place,
    PointShape,
    RigidShape,
)
from flexmb.parts.bodies.flexible import beam_elements
from flexmb.results import drawing
from flexmb.results.drawing import GROUND, Surface, carried, few_shapes, parts, pose
from flexmb.results.positions import body_joints, turning_nodes, unstressed
from flexmb.results.solution import Solution
from flexmb.show.reports.document import COARSE, FINE, MIDDLE, Content, Markup, quantised, tag

# Stresses of flexible parts at chosen instants


def stresses(sol: Solution, mechanism: Mechanism | None, instants: np.ndarray) -> np.ndarray | None:
    """Largest stress (n, m) of the outer fibres of each beam element, axial and bending stress added, >= 0 [Pa].

    None where the mechanism is unknown, or a section does not know its outer fibre.  The stress is Young's modulus
    times the strain of `flexmb.elastic.beams.stress`, without damping; elements stand in the order of the shapes,
    instants by the numbers (n,) of saved ones.
    """
    shapes = [shape for shape in sol.shapes if isinstance(shape, BeamShape)]
    found: dict[tuple[str, str, str], np.ndarray] = {}
    for body in mechanism.bodies if mechanism is not None and shapes else ():
        if isinstance(body, ElasticBody) and body.theory == "beams":
            own = _of_body(sol, body, instants)
            if own is None:
                return None
            found |= own
    columns = [found.get((shape.part, shape.start, shape.end)) for shape in shapes]
    known = [column for column in columns if column is not None]
    return np.stack(known, axis=1) if known and len(known) == len(columns) else None


def _of_body(sol: Solution, body: Any, instants: np.ndarray) -> dict[tuple[str, str, str], np.ndarray] | None:
    """Stresses (n,) of the elements of a body by part and nodes [Pa]; None for a section without an outer fibre."""
    nodes, found = {node.name: node for node in body.nodes()}, {}
    for beam in body.beams:
        try:
            beam.section.outer_fibre_at(0.0)
        except InputError:
            return None
        poses = np.stack([pose(sol, body.name, node, instants) for node in beam.nodes], axis=1)
        strains = beam_elements(beam, nodes).strains(*poses.transpose(2, 0, 1))
        for k, column in enumerate(strains.T):
            found[body.name, beam.nodes[k], beam.nodes[k + 1]] = beam.material.young * column
    return found


# Motion of flexible parts, split into a rigid motion and displacements of the nodes against it

NEAR = 0.02
"""Distance of a joint from a node, over the size of the part, below which the joint is taken to hold the node."""


@dataclass(frozen=True)
class FlexiblePart:
    """A flexible part at n instants.

    The rigid motion takes the unstressed part to where the nodes at its joints are, by least squares: with two joints
    along the chord between them, with one along the tangent there, without joints through all nodes.

    Parameters
    ----------
    nodes : names of its nodes.
    reference : (m, 3) x, y, theta of the nodes of the unstressed part, in the frame of the rigid motion [m, rad].
    motion : (n, 3) x, y, theta of the rigid motion [m, rad].
    displacements : (n, m, 3) poses of the nodes in this frame, less the reference [m, rad].
    """

    part: str
    nodes: tuple[str, ...]
    reference: np.ndarray
    motion: np.ndarray
    displacements: np.ndarray


def flexible_parts(sol: Solution, instants: np.ndarray) -> list[FlexiblePart]:
    """All flexible parts of a solution, with the poses of all its nodes, at saved instants with numbers (n,)."""
    beams: dict[str, list[BeamShape]] = {}
    for shape in sol.shapes:
        if isinstance(shape, BeamShape):
            beams.setdefault(shape.part, []).append(shape)
    joints = _joint_points(sol, instants[:1])
    return [_flexible_part(sol, part, elements, joints, instants) for part, elements in beams.items()]


def _joint_points(sol: Solution, first: np.ndarray) -> np.ndarray:
    """Places (k, 2) of all joints at the first instant [m]."""
    places = [np.zeros((0, 2))]
    for shape in sol.shapes:
        if isinstance(shape, PointShape) and shape.kind not in (MARKER, TRACE):
            at = pose(sol, shape.body, shape.node, first) if shape.body != GROUND else np.zeros((1, 3))
            places.append(carried(at, np.array([shape.offset], dtype=float))[0])
    return np.concatenate(places)


def _flexible_part(
    sol: Solution, part: str, elements: Sequence[BeamShape], joints: np.ndarray, instants: np.ndarray
) -> FlexiblePart:
    found = unstressed(elements)
    nodes, reference = tuple(found), np.array(list(found.values()))
    poses = np.stack([pose(sol, part, node, instants) for node in nodes], axis=1)
    size = float(np.ptp(reference[:, :2], axis=0).max())
    apart = np.hypot(*(poses[0, :, None, :2] - joints[None]).transpose(2, 0, 1))
    held = np.flatnonzero((apart < NEAR * size).any(axis=1))
    chosen = held if len(held) else np.arange(len(nodes))
    motion = rigid_motion(reference[chosen], poses[:, chosen])
    c, s = np.cos(motion[:, 2, None]), np.sin(motion[:, 2, None])
    dx, dy = (poses[:, :, k] - motion[:, k, None] for k in (0, 1))
    turned = poses[:, :, 2] - motion[:, 2, None] - reference[:, 2]
    turned -= 2.0 * np.pi * np.round(turned / (2.0 * np.pi))
    local = np.stack([c * dx + s * dy - reference[:, 0], c * dy - s * dx - reference[:, 1], turned], axis=-1)
    return FlexiblePart(part, nodes, reference, motion, local)


def rigid_motion(reference: np.ndarray, poses: np.ndarray) -> np.ndarray:
    """Rigid motion (n, 3) that takes nodes to their poses by least squares; the angle of one node is its theta.

    `reference` (m, 3) are x, y, theta of the nodes in the moved frame, `poses` (n, m, 3) those of the nodes [m, rad].
    """
    centre, middle = reference[:, :2].mean(axis=0), poses[:, :, :2].mean(axis=1)
    if len(reference) == 1:
        angle = poses[:, 0, 2] - reference[0, 2]
    else:
        a, b = reference[:, :2] - centre, poses[:, :, :2] - middle[:, None]
        along = (a[None] * b).sum(axis=(1, 2))
        across = (a[None, :, 0] * b[:, :, 1] - a[None, :, 1] * b[:, :, 0]).sum(axis=1)
        angle = np.unwrap(np.arctan2(across, along))
    c, s = np.cos(angle), np.sin(angle)
    x = middle[:, 0] - c * centre[0] + s * centre[1]
    y = middle[:, 1] - s * centre[0] - c * centre[1]
    return np.stack([x, y, angle], axis=-1)


# Meshes of flexible bodies for a page: rigid motion, deformation as a sum of few shapes, stress at few points

MOST_POINTS = 1500
"""Number of points of all meshes of a page, about, whose stress is shown; of a finer mesh some points stand for all."""

LOOP_POINTS = 160
"""Largest number of points of an outline or of a hole, about."""

WIDER = 1.1
"""Factor by which the squares grow, in each of which one point is kept, until there are few enough."""

SEEN = 2.5e-4
"""Error of the deformation over the largest displacement, at most; no magnification shows more."""


@dataclass(frozen=True)
class MeshPart:
    """A flexible body with a mesh at n instants.

    Parameters
    ----------
    shape : its mesh; its `poses` and `points` are those without deformation.
    surface : its places and stresses.
    motion : (n, 3) x, y, theta of the rigid motion that takes the undeformed body to its joints [m, rad].
    """

    shape: MeshShape
    surface: Surface
    motion: np.ndarray

    def in_frame(self, points: np.ndarray) -> np.ndarray:
        """Places (n, m, 2) [m] in the frame of the rigid motion."""
        c, s = np.cos(self.motion[:, 2, None]), np.sin(self.motion[:, 2, None])
        dx, dy = (points[..., k] - self.motion[:, k, None] for k in (0, 1))
        return np.stack([c * dx + s * dy, c * dy - s * dx], axis=-1)

    def node(self, name: str) -> tuple[np.ndarray, np.ndarray]:
        """Undeformed pose (3,) of a node, and its displacements (n, 3), in the frame [m, rad]."""
        k = self.shape.nodes.index(name)
        pose, reference = self.surface.poses[:, k], np.array(self.shape.poses[k])
        turned = pose[:, 2] - self.motion[:, 2] - reference[2]
        turned -= 2.0 * np.pi * np.round(turned / (2.0 * np.pi))
        moved = self.in_frame(pose[:, None, :2])[:, 0] - reference[:2]
        return reference, np.column_stack([moved, turned])

    def packed(self, frame: int, most: int) -> dict[str, Any]:
        """Data of the page, with about `most` points with a stress; `frame` is the number of the motion's frame."""
        kept, triangles, loops = coarse(self.surface, most)
        own, reference = self.in_frame(self.surface.points[:, kept]), np.array(self.shape.points)[kept]
        moved = (own - reference).transpose(0, 2, 1).reshape(len(own), -1)
        largest = float(np.abs(moved).max(initial=0.0))
        weights, shapes = few_shapes(moved, SEEN * largest)
        found: dict[str, Any] = {
            "part": self.shape.part,
            "frame": frame,
            "points": quantised(reference, FINE),
            "triangles": triangles.ravel().tolist(),
            "loops": [loop.tolist() for loop in loops],
            "largest": largest,
            "weights": quantised(weights, FINE),
            "shapes": quantised(shapes.T, FINE),
        }
        if self.surface.has_stress:
            found["stress"] = quantised(self.surface.von_mises[:, kept], COARSE, common=True)
        return found


def mesh_parts(sol: Solution, instants: np.ndarray) -> list[MeshPart]:
    """All bodies with meshes at saved instants with numbers (n,); the solution has the poses of all their nodes."""
    return [_mesh_part(sol, shape, instants) for shape in sol.shapes if isinstance(shape, MeshShape)]


def _mesh_part(sol: Solution, shape: MeshShape, instants: np.ndarray) -> MeshPart:
    surface = drawing.surface(sol, shape, instants)
    if not shape.poses:  # a file of before: undeformed as at the first instant
        shape = replace(shape, poses=tuple(map(tuple, surface.poses[0].tolist())))
    joints = body_joints(sol, shape.part, list(shape.nodes))
    chosen = list(joints) if len(joints) > 1 or any(joints.values()) else turning_nodes(shape)
    motion = rigid_motion(np.array(shape.poses)[chosen], surface.poses[:, chosen])
    if len(joints) == 1 and not any(joints.values()):  # it turns with all, and stays at its joint
        (joint,) = joints
        motion = _held(motion, np.array(shape.poses)[joint], surface.poses[:, joint])
    return MeshPart(shape, surface, motion)


def _held(motion: np.ndarray, reference: np.ndarray, pose: np.ndarray) -> np.ndarray:
    """The rigid motion (n, 3), moved so that it takes a reference pose (3,) to the place of the poses (n, 3)."""
    c, s = np.cos(motion[:, 2]), np.sin(motion[:, 2])
    x, y = reference[:2]
    return np.column_stack([pose[:, 0] - c * x + s * y, pose[:, 1] - s * x - c * y, motion[:, 2]])


def coarse(surface: Surface, most: int) -> tuple[np.ndarray, np.ndarray, list[np.ndarray]]:
    """Numbers of representative points of a mesh, and the triangles and loops between these.

    Squares of one size lie over the mesh; one point of each stands for the others, one of the outline where there is
    one.  Triangles whose corners fall together are left out.
    """
    points, triangles = np.array(surface.shape.points), surface.triangles
    loops = [np.array(loop)[:: -(-len(loop) // LOOP_POINTS)] for loop in surface.shape.loops]
    if len(points) > most:
        rim = np.zeros(len(points), dtype=bool)
        rim[np.concatenate([np.array(loop) for loop in surface.shape.loops])] = True
        triangles = _stood_for(points, rim, most)[triangles]
        whole = [triangles[:, k] != triangles[:, j] for k, j in ((0, 1), (1, 2), (2, 0))]
        triangles = triangles[np.logical_and.reduce(whole)]
        triangles = triangles[np.unique(np.sort(triangles, axis=1), axis=0, return_index=True)[1]]
    kept = np.unique(np.concatenate([triangles.ravel(), *loops]))
    number = np.zeros(len(points), dtype=np.int64)
    number[kept] = np.arange(len(kept))
    return kept, number[triangles], [number[loop] for loop in loops]


def _stood_for(points: np.ndarray, rim: np.ndarray, most: int) -> np.ndarray:
    """Number (n,) of the point that stands for each point."""
    low, high = points.min(axis=0), points.max(axis=0)
    side = float(np.sqrt(np.prod(high - low) / most))
    while True:
        squares, of = np.unique(np.floor((points - low) / side).astype(np.int64), axis=0, return_inverse=True)
        if len(squares) <= most:
            break
        side *= WIDER
    of = of.ravel()
    counts = np.bincount(of)
    middle = np.stack([np.bincount(of, points[:, k]) / counts for k in (0, 1)], axis=1)
    away = np.hypot(*(points - middle[of]).T) + np.where(rim, 0.0, 10.0 * side)
    order = np.lexsort((away, of))
    first = order[np.searchsorted(of[order], np.arange(len(squares)))]
    return np.asarray(first[of])


# Moving mechanism of a page: frames that carry nodes, shapes on these nodes, section forces, joint forces

STANDING = -1
"""Number of the frame of the ground."""


class Nodes:
    """Nodes of all shapes with the frames that carry them, at n saved instants, given by their numbers."""

    def __init__(self, sol: Solution, instants: np.ndarray) -> None:
        self.sol, self.instants = sol, instants
        self.places: dict[tuple[str, str], int] = {(GROUND, ""): 0}
        self.rows: list[list[float]] = [[STANDING, 0.0, 0.0, 0.0, STANDING]]
        self.frames: list[np.ndarray] = []
        self.displacements: list[np.ndarray] = []
        for part in flexible_parts(sol, instants):
            self._add_flexible(part)
        self.meshes: dict[str, tuple[int, MeshPart]] = {}
        for mesh in mesh_parts(sol, instants):
            self.meshes[mesh.shape.part] = len(self.frames), mesh
            self.frames.append(mesh.motion)

    def _add_flexible(self, part: FlexiblePart) -> None:
        for node, reference in zip(part.nodes, part.reference, strict=True):
            self.places[part.part, node] = len(self.rows)
            self.rows.append([len(self.frames), *map(float, reference), len(self.displacements)])
            self.displacements.append(part.displacements[:, part.nodes.index(node)])
        self.frames.append(part.motion)

    def of(self, part: str, node: str) -> int:
        """Number of a node; a node of a rigid body is its frame itself."""
        if part == GROUND:
            return 0
        if (part, node) not in self.places:
            self.places[part, node] = len(self.rows)
            if part in self.meshes:
                frame, mesh = self.meshes[part]
                reference, displacements = mesh.node(node)
                self.rows.append([frame, *reference.tolist(), len(self.displacements)])
                self.displacements.append(displacements)
                return self.places[part, node]
            self.rows.append([len(self.frames), 0.0, 0.0, 0.0, STANDING])
            self.frames.append(pose(self.sol, part, node, self.instants))
        return self.places[part, node]

    def at(self, place: Place) -> list[float]:
        """Number of the node of a place, and the point in its frame [m]."""
        part, node, (x, y) = place
        return [self.of(part, node), x, y]

    def packed(self) -> dict[str, Any]:
        """Nodes and motions for the page."""
        none = np.zeros((len(self.instants), 0))
        return {
            "nodes": self.rows,
            "frames": quantised(np.concatenate([none, *self.frames], axis=1), FINE),
            "displacements": quantised(np.concatenate([none, *self.displacements], axis=1), MIDDLE),
        }


def scene(sol: Solution, mechanism: Mechanism | None, instants: np.ndarray) -> dict[str, Any]:
    """Mechanism at saved instants with numbers (n,), for the page; stresses need the mechanism that moved.

    A solution without the poses of its nodes is refused.
    """
    drawing.require_nodes(sol)
    nodes = Nodes(sol, instants)
    beams = [shape for shape in sol.shapes if isinstance(shape, BeamShape)]
    drawn = {
        "rigid": [_rigid(nodes, shape) for shape in sol.shapes if isinstance(shape, RigidShape)],
        "meshes": _meshes(nodes),
        "beams": [_beam(nodes, beam) for beam in beams],
        "points": [_point(nodes, shape) for shape in sol.shapes if isinstance(shape, PointShape)],
        "symbols": [s for s in (_symbol(nodes, shape) for shape in sol.shapes) if s is not None],
    }
    stress = stresses(sol, mechanism, instants)
    fields = _section_forces(sol, instants)
    if stress is not None:
        fields["stress"] = quantised(stress, COARSE, common=True)
    return {**drawn, **nodes.packed(), **fields, **_joint_forces(sol, instants)}


def fields_of(drawn: Mapping[str, Any]) -> list[str]:
    """Fields by which the bodies of a result of `scene` can be coloured: "moment", "axial", "stress"."""
    found = [field for field in ("moment", "axial", "stress") if field in drawn]
    of_meshes = any("stress" in mesh for mesh in drawn["meshes"])
    return [*found, "stress"] if of_meshes and "stress" not in found else found


def _rigid(nodes: Nodes, shape: RigidShape) -> dict[str, Any]:
    return {"part": shape.part, "node": nodes.of(shape.part, shape.node), "lines": shape.lines}


def _meshes(nodes: Nodes) -> list[dict[str, Any]]:
    """Meshes of the flexible bodies; each has its share of the points of a page."""
    total = sum(len(mesh.shape.points) for _, mesh in nodes.meshes.values())
    shares = ((frame, mesh, len(mesh.shape.points) / total) for frame, mesh in nodes.meshes.values())
    return [mesh.packed(frame, int(MOST_POINTS * share)) for frame, mesh, share in shares]


def _beam(nodes: Nodes, beam: BeamShape) -> list[Any]:
    a, b = nodes.of(beam.part, beam.start), nodes.of(beam.part, beam.end)
    return [beam.part, a, b, beam.length, beam.start_angle, beam.end_angle, *(beam.shear if any(beam.shear) else ())]


def _point(nodes: Nodes, shape: PointShape) -> dict[str, Any]:
    at = nodes.at((shape.body, shape.node, shape.offset))
    return {"part": shape.part, "kind": shape.kind, "at": at, "ground": shape.body == GROUND}


def _symbol(nodes: Nodes, shape: object) -> dict[str, Any] | None:
    """A spring, damper, rod, cable, force or pitch circle; None for another shape."""
    if isinstance(shape, LineShape):
        first, second = nodes.at(shape.first), nodes.at(shape.second)
        return {"part": shape.part, "kind": shape.kind, "first": first, "second": second}
    if isinstance(shape, ArrowShape):
        extra = {"direction": shape.direction, "turns": shape.turns}
        return {"part": shape.part, "kind": "force", "at": nodes.at(shape.at), **extra}
    if isinstance(shape, CircleShape):
        return {"part": shape.part, "kind": "circle", "at": nodes.at(shape.at), "radius": shape.radius}
    return None


def _section_forces(sol: Solution, instants: np.ndarray) -> dict[str, Any]:
    """Bending moments [N m] and axial forces [N] at both ends of all beam elements, in the order of the shapes."""
    if not any(isinstance(shape, BeamShape) for shape in sol.shapes):
        return {}
    beams = [line for line in drawing.lines(sol, instants, 2) if line.is_beam]
    fields = {"moment": "bending_moment", "axial": "axial_force"}
    stacked = {key: np.concatenate([b.fields[name] for b in beams], axis=1) for key, name in fields.items()}
    return {key: quantised(values, COARSE, common=True) for key, values in stacked.items()}


def _joint_forces(sol: Solution, instants: np.ndarray) -> dict[str, Any]:
    """Forces on the second bodies of joints [N]: names, and two columns for each of them."""
    points = dict.fromkeys(s.part for s in sol.shapes if isinstance(s, PointShape))
    names = [name for name in points if f"{name}.fx" in sol and f"{name}.fy" in sol]
    if not names:
        return {}
    columns = [sol.array(f"{name}.{axis}")[instants] for name in names for axis in ("fx", "fy")]
    return {"forced": names, "forces": quantised(np.nan_to_num(np.stack(columns, axis=1)), MIDDLE)}


# Moving picture of a mechanism with its controls, as HTML

DURATIONS = {"5": "5 s", "10": "10 s", "20": "20 s", "60": "60 s", "300": "5 min", "real": "real time"}
"""Times in which a run is played."""

MAGNIFICATIONS = ("1", "3", "10", "30", "100", "300", "1000", "3000", "10000")
"""Factors of the displacements of flexible parts."""

COLOURED = {"moment": "bending moment", "axial": "axial force", "stress": "stress"}
"""Names of the fields by which bodies are coloured."""

KEYS = "Keys: Space plays, arrows step (Shift: ten frames), Home and End, + and - zoom, 0 fits, drag pans."


def player(sol: Solution, heading: str, *, fields: Sequence[str]) -> Markup:
    """Picture, time slider and controls; fields as of `reports.scene.fields_of`."""
    names = parts(sol)
    listed = ", ".join(names[:30]) + (", ..." if len(names) > 30 else "")
    text = f"Moving picture of {heading}: {listed}. Plots and tables hold the same in numbers."
    canvas = tag("canvas", text, id="picture", tabindex="0", role="img", aria_label=text, aria_describedby="keys")
    bar = tag("div", id="legend-ticks", class_="ticks"), tag("p", id="legend-text")
    legend = tag("div", *bar, id="legend", class_="legend", aria_hidden="true")
    flexible = any(isinstance(shape, BeamShape | MeshShape) for shape in sol.shapes)
    return tag(
        "div",
        tag("h2", "Motion", class_="visually-hidden"),
        tag("div", canvas, legend, class_="picture"),
        _time_row(),
        _look_row(flexible, fields),
        tag("p", KEYS, id="keys", class_="hint"),
        class_="player",
    )


def _time_row() -> Markup:
    """Controls of the time."""
    return tag(
        "div",
        _button("play", "Play", "Play or pause"),
        _button("back", "\u2039", "One frame back"),
        _button("forward", "\u203a", "One frame forward"),
        tag("input", type="range", id="time", min="0", max="1", step="1", value="0", aria_label="Time"),
        tag("output", id="now", for_="time"),
        tag("span", id="said", class_="visually-hidden", aria_live="polite"),
        class_="row time",
    )


def _look_row(flexible: bool, fields: Sequence[str]) -> Markup:
    """Controls of the look."""
    colours = {"part": "parts", **{field: COLOURED[field] for field in fields}}
    return tag(
        "div",
        _choice("duration", "Played in", DURATIONS, "10"),
        _choice("magnification", "Deformation", {"auto": "auto", **{x: f"{x} \u00d7" for x in MAGNIFICATIONS}}, "1")
        if flexible
        else None,
        _choice("colour", "Colour", colours, list(colours)[min(1, len(fields))]) if flexible else None,
        _box("forces", "Joint forces", checked=True),
        _box("names", "Names", checked=True),
        _button("fit", "Fit", "Fit the picture"),
        _button("clear", "Clear traces", "Remove the traces of clicked points"),
        class_="row look",
    )


def _button(name: str, text: str, label: str) -> Markup:
    return tag("button", text, type="button", id=name, aria_label=label, title=label)


def _choice(name: str, label: str, options: dict[str, str], chosen: str) -> Markup:
    made = [tag("option", text, value=value, selected=value == chosen) for value, text in options.items()]
    return tag("label", label, Markup(" "), tag("select", *made, id=name))


def _box(name: str, label: str, *, checked: bool) -> Markup:
    content: list[Content] = [tag("input", type="checkbox", id=name, checked=checked), label]
    return tag("label", *content)
