"""Moving mechanism of a page: frames that carry nodes, shapes on these nodes, section forces, joint forces."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from flexmb.model.mechanism import Mechanism
from flexmb.model.shape import ArrowShape, BeamShape, CircleShape, LineShape, Place, PointShape, RigidShape
from flexmb.reports.flexible_parts import FlexiblePart, flexible_parts
from flexmb.reports.meshes import MOST_POINTS, MeshPart, mesh_parts
from flexmb.reports.packing import COARSE, FINE, MIDDLE, quantised
from flexmb.reports.stresses import stresses
from flexmb.results import drawing
from flexmb.results.drawing import GROUND, pose
from flexmb.results.solution import Solution

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
