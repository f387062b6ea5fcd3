"""The motion of a run as a glTF file, for viewers of 3-D models and web pages.

Source: Khronos Group, glTF 2.0 Specification, 2021 (ISO/IEC 12113).
"""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from flexmb import checks
from flexmb.dynamics.jobs.files import whole_file
from flexmb.errors import InputError
from flexmb.late import mpl
from flexmb.model.shape import CircleShape, LineShape, PointShape, RigidShape
from flexmb.results import drawing
from flexmb.results.positions import FlexibleMotion, flexible_motions, magnified
from flexmb.results.solution import Solution, require_rows
from flexmb.show.pictures.films import stress_limit
from flexmb.show.pictures.pose import THINNEST, body_colours
from flexmb.show.pictures.scene import Scene, scene_of
from flexmb.show.pictures.style import CLEARANCE, SEQUENTIAL
from flexmb.version import installed_version

MAGIC, VERSION, JSON_CHUNK, BIN_CHUNK = 0x46546C67, 2, 0x4E4F534A, 0x004E4942
FLOAT, UINT = 5126, 5125  # component types of accessors
WEIGHTS = "weights"  # path of the motion of a mesh between its shapes
KINDS = {1: "SCALAR", 3: "VEC3", 4: "VEC4"}
ARRAY_BUFFER, ELEMENT_BUFFER = 34962, 34963


class Glb:
    """A glTF document that grows by meshes, nodes and motions."""

    def __init__(self, generator: str) -> None:
        self._data = bytearray()
        self._inputs: dict[bytes, int] = {}
        lists: dict[str, Any] = {name: [] for name in ("nodes", "meshes", "materials", "accessors", "bufferViews")}
        head: Any = {"asset": {"version": "2.0", "generator": generator}, "scene": 0, "scenes": [{"nodes": []}]}
        self.document = head | lists | {"animations": [{"name": "motion", "channels": [], "samplers": []}]}

    def material(self, name: str, rgb: tuple[float, float, float]) -> int:
        """Number of a new material, seen from both sides; `rgb`: linear colour, 0 to 1."""
        surface = {"baseColorFactor": [*rgb, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.8}
        return self._append("materials", {"name": name, "pbrMetallicRoughness": surface, "doubleSided": True})

    def mesh(
        self, name: str, positions: np.ndarray, normals: np.ndarray, faces: np.ndarray, material: int, *,
        colours: np.ndarray | None = None, shapes: Sequence[np.ndarray] = (),
    ) -> int:  # fmt: skip
        """Number of a new mesh of triangles `faces` (m, 3) on positions (n, 3) [m] with unit normals (n, 3)."""
        # Linear colours (n, 3) of the points multiply that of the material; None: that of the material. `shapes` are
        # displacements (n, 3) [m] that `deform` adds up (morph targets).
        place = self._accessor(positions, ARRAY_BUFFER, limits=True)
        attributes = {"POSITION": place, "NORMAL": self._accessor(normals, ARRAY_BUFFER)}
        if colours is not None:
            attributes["COLOR_0"] = self._accessor(colours, ARRAY_BUFFER)
        indices = self._accessor(faces.reshape(-1, 1), ELEMENT_BUFFER)
        piece: dict[str, Any] = {"attributes": attributes, "indices": indices, "material": material, "mode": 4}
        mesh: dict[str, Any] = {"name": name, "primitives": [piece]}
        if len(shapes):
            piece["targets"] = [{"POSITION": self._accessor(one, ARRAY_BUFFER, limits=True)} for one in shapes]
            mesh[WEIGHTS] = [0.0] * len(shapes)
        return self._append("meshes", mesh)

    def node(self, name: str, meshes: list[int]) -> int:
        """Number of a new node of the scene with some meshes."""
        mine: dict[str, Any] = {"name": name}
        if len(meshes) == 1:
            mine["mesh"] = meshes[0]
        elif meshes:
            mine["children"] = [self._append("nodes", {"name": f"{name} {k}", "mesh": m}) for k, m in enumerate(meshes)]
        number = self._append("nodes", mine)
        self.document["scenes"][0]["nodes"].append(number)
        return number

    def move(
        self, node: int, time: np.ndarray, places: np.ndarray, angles: np.ndarray, scales: np.ndarray | None
    ) -> None:
        """Move a node: instants (n,) [s], places (n, 2) [m], angles (n,) [rad], factors `scales` (n, 3) or None."""
        zero = np.zeros(len(time))
        turns = np.stack([zero, zero, np.sin(0.5 * angles), np.cos(0.5 * angles)], axis=-1)
        motions = {"translation": np.column_stack([places, zero]), "rotation": turns}
        if scales is not None:
            motions["scale"] = scales
        mine = self.document["nodes"][node]
        for path, values in motions.items():
            mine[path] = np.asarray(values[0], dtype=np.float32).tolist()
            if len(time) > 1:
                self._channel(node, path, time, values)

    def deform(self, node: int, time: np.ndarray, weights: np.ndarray) -> None:
        """Deform the mesh of a node by factors (n, k) of its shapes at instants (n,) [s]."""
        self.document["nodes"][node][WEIGHTS] = np.asarray(weights[0], dtype=np.float32).tolist()
        if len(time) > 1:
            self._channel(node, WEIGHTS, time, weights.reshape(-1, 1))

    def _channel(self, node: int, path: str, time: np.ndarray, values: np.ndarray) -> None:
        motion, key = self.document["animations"][0], time.tobytes()
        if key not in self._inputs:
            self._inputs[key] = self._accessor(time.reshape(-1, 1), None, limits=True)
        output = self._accessor(values, None)
        motion["samplers"].append({"input": self._inputs[key], "output": output, "interpolation": "LINEAR"})
        motion["channels"].append({"sampler": len(motion["samplers"]) - 1, "target": {"node": node, "path": path}})

    def bytes(self) -> bytes:
        """The document as a binary glTF file."""
        done = {key: value for key, value in self.document.items() if value != []}
        done["animations"] = [motion for motion in self.document["animations"] if motion["channels"]]
        if not done["animations"]:
            del done["animations"]
        done["buffers"] = [{"byteLength": len(self._data)}]
        text = json.dumps(done, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        data = bytes(self._data) + b"\0" * (-len(self._data) % 4)
        head = struct.pack("<3I", MAGIC, VERSION, 12 + 8 + len(text) + 8 + len(data))
        return head + struct.pack("<2I", len(text), JSON_CHUNK) + text + struct.pack("<2I", len(data), BIN_CHUNK) + data

    def _append(self, kind: str, item: dict[str, Any]) -> int:
        self.document[kind].append(item)
        return len(self.document[kind]) - 1

    def _accessor(self, values: np.ndarray, target: int | None, *, limits: bool = False) -> int:
        """Number of a new accessor of an array (n, k): whole numbers as unsigned, others as floats of 32 bits."""
        whole = np.issubdtype(values.dtype, np.integer)
        array = np.ascontiguousarray(values, dtype=np.uint32 if whole else np.float32)
        view: dict[str, Any] = {"buffer": 0, "byteOffset": len(self._data), "byteLength": array.nbytes}
        if target is not None:
            view["target"] = target
        self._data += array.tobytes()
        mine: dict[str, Any] = {"bufferView": self._append("bufferViews", view), "count": len(array)}
        mine |= {"componentType": UINT if whole else FLOAT, "type": KINDS[array.shape[1]]}
        if limits:
            mine |= {"min": array.min(axis=0).tolist(), "max": array.max(axis=0).tolist()}
        return self._append("accessors", mine)


MOST_FRAMES = 200  # default number of instants, at most
BAR = 0.006  # half width of the bars of rigid bodies, over the width of the mechanism
STRIDE = 2  # points of a drawn beam element for each straight piece: 4 pieces of 9 points
PIN_SIDES = 16  # number of sides of a pin


def export_gltf(sol: Solution, path: str | Path, *, frames: int | None = None, magnify: float = 1.0) -> Path:
    """Motion of a run as a binary glTF file, one unit a metre, the plane of motion as x and y.

    Rigid bodies, wheels and pins are nodes that move and turn; beams are chains of straight pieces, four an element;
    springs, dampers, rods and cables are nodes that also change their length.  Meshes move, deform by a few shapes, and
    have the colours of the largest von Mises stress that each point has at these instants.  Forces, belts, guides and
    paths are left out.  Viewers interpolate linearly between the instants.

    Parameters
    ----------
    sol : the solution.
    path : the .glb file; its folder is made.
    frames : number of instants, >= 2, evenly over the time, replaced by the nearest rows; None: all, at most 200.
    magnify : factor of the deformation of flexible bodies; 0: undeformed.

    Raises
    ------
    InputError : another ending, a solution without rows or shapes, a path that cannot be written.
    """
    target = checks.path("export_gltf", path)
    if target.suffix.lower() != ".glb":
        raise InputError(f"export_gltf: path is {str(path)!r}; it must end in .glb.")
    require_rows("export_gltf", sol)
    rows = drawing.spread_instants(sol, MOST_FRAMES)
    if frames is not None:
        along = np.linspace(sol.time[0], sol.time[-1], checks.count("export_gltf", "frames", frames, 2))
        rows = drawing.nearest_instants(sol, along)
    content = Export(magnified(sol, checks.not_negative("export_gltf", "magnify", magnify)), rows, sol).bytes()
    with whole_file(target, "export_gltf") as part:
        part.write_bytes(content)
    return target


class Export(Glb):
    """A glTF document of some rows of a solution, with the stresses of one whose deformation is true."""

    def __init__(self, sol: Solution, rows: np.ndarray, true: Solution) -> None:
        super().__init__(f"flexmb {installed_version()}")
        self._sol, self._rows, self._time = sol, rows, sol.time[rows] - sol.time[rows[0]]
        self._scene: Scene = scene_of(sol, rows, true=true if true is not sol else None)
        self._half, colours = BAR * self._scene.size, body_colours(self._scene)
        self._materials = {part: self.material(part, _linear_of(colour)) for part, colour in colours.items()}
        self._grey = self.material("couplings", _linear_of("#606060"))
        self._rigid()
        for number, line in enumerate(line for line in self._scene.lines if line.is_beam):
            self._beam(number, line)
        bodies = {body.part: body for body in flexible_motions(sol, rows)}
        for surface in self._scene.surfaces:
            self._mesh(surface, bodies[surface.part])
        self._lines()
        self._pins()

    def _rigid(self) -> None:
        """One node for each node of a rigid body, with its outlines and wheels."""
        lines: dict[tuple[str, str], list[np.ndarray]] = {}
        for shape in self._sol.shapes:
            if isinstance(shape, RigidShape):
                mine = lines.setdefault((shape.part, shape.node), [])
                mine += [np.array(line, dtype=float) for line in shape.lines]
            elif isinstance(shape, CircleShape):
                lines.setdefault(shape.at[:2], []).append(drawing.circle_line(shape, 4 * PIN_SIDES + 1))
        for (part, node), mine in lines.items():
            name = f"{part}.{node}" if node else part
            solid = _joined([_bars(line, self._half) for line in mine])
            mesh = self.mesh(name, *solid, self._materials.get(part, self._grey))
            pose = drawing.pose(self._sol, part, node, self._rows)
            self.move(self.node(name, [mesh]), self._time, pose[:, :2], pose[:, 2], None)

    def _beam(self, number: int, line: drawing.Line) -> None:
        """Straight pieces of an element."""
        depth = np.zeros(line.points.shape[1]) if line.depth is None else line.depth
        for k in range(0, line.points.shape[1] - 1, STRIDE):
            half = max(0.25 * float(depth[k] + depth[k + STRIDE]), THINNEST * self._scene.size)
            solid = _bars(np.array([[0.0, 0.0], [1.0, 0.0]]), half)
            mesh = self.mesh(f"{line.part} {number}.{k}", *solid, self._materials[line.part])
            self._stretch(self.node(f"{line.part} {number}.{k}", [mesh]), line.points[:, k], line.points[:, k + STRIDE])

    def _mesh(self, surface: drawing.Surface, body: FlexibleMotion) -> None:
        """A mesh that moves as a rigid body, with the shapes of its deformation."""
        first = np.array(surface.shape.points)
        weights, shapes = body.deformation(surface.points, first)
        zeros, colours, material = np.zeros((len(first), 1)), None, self._materials[surface.part]
        if surface.has_stress:
            top = stress_limit(self._scene)
            colours = _linear(mpl.colormaps[SEQUENTIAL](surface.von_mises.max(axis=0) / top)[:, :3])
            name = f"{surface.part}: largest von Mises stress, 0 to {top:.4g} Pa"
            material = self.material(name, (1.0, 1.0, 1.0))
        up, morphs = np.tile([0.0, 0.0, 1.0], (len(first), 1)), [np.hstack([one, zeros]) for one in shapes]
        plane = np.hstack([first, zeros])
        mesh = self.mesh(surface.part, plane, up, surface.triangles, material, colours=colours, shapes=morphs)
        node = self.node(surface.part, [mesh])
        self.move(node, self._time, body.motion[:, :2], body.motion[:, 2], None)
        if len(shapes):
            self.deform(node, self._time, weights)

    def _stretch(self, node: int, first: np.ndarray, second: np.ndarray) -> None:
        """Move a node of unit length so that it joins two points (n, 2)."""
        way = second - first
        length = np.maximum(np.hypot(*way.T), 1e-9)
        scales = np.stack([length, np.ones(len(length)), np.ones(len(length))], axis=-1)
        self.move(node, self._time, first, np.unwrap(np.arctan2(way[:, 1], way[:, 0])), scales)

    def _lines(self) -> None:
        """Springs, dampers, rods and cables."""
        kinds = {shape.part: shape.kind for shape in self._sol.shapes if isinstance(shape, LineShape)}
        for sign in drawing.symbols(self._sol, self._rows, self._scene.size):
            if sign.part not in kinds or sign.kind != kinds[sign.part]:
                continue
            first, second = sign.points[:, 0], sign.points[:, -1]
            length, u, n = drawing.directions(second[0] - first[0])
            away = sign.points[0] - first[0]
            solid = _bars(np.stack([away @ u / max(float(length[0]), 1e-9), away @ n], axis=-1), 0.3 * self._half)
            self._stretch(self.node(sign.part, [self.mesh(sign.part, *solid, self._grey)]), first, second)

    def _pins(self) -> None:
        """Joints as short prisms."""
        dark = self.material("joints", _linear_of("#101010"))
        red = self.material("clearance", _linear_of(CLEARANCE))
        names = {shape.part for shape in self._sol.shapes if isinstance(shape, PointShape)}
        turn = 2.0 * np.pi * np.arange(PIN_SIDES) / PIN_SIDES
        rim = np.column_stack([np.cos(turn), np.sin(turn)])
        meshes = {
            material: self.mesh("pin", *_prism(1.6 * self._half * rim, 1.3 * self._half), material)
            for material in {red if m.kind == "clearance" else dark for m in self._scene.marks if m.kind != "journal"}
        }
        for mark in self._scene.marks:
            if mark.kind != "journal" and mark.part in names:
                node = self.node(mark.part, [meshes[red if mark.kind == "clearance" else dark]])
                self.move(node, self._time, mark.points, np.zeros(len(self._time)), None)


Solid = tuple[np.ndarray, np.ndarray, np.ndarray]  # points, normals and triangles


def _bars(line: np.ndarray, half: float) -> Solid:
    """Bars of square section along a polyline (m, 2); a cube for a line without length."""
    pieces = []
    for a, b in pairwise(line):
        _, (ux, uy), _ = drawing.directions(b - a)
        if ux == uy == 0.0:
            ux, half_x, half_y = 1.0, 2.0 * half, 2.0 * half
        else:
            half_x, half_y = 0.5 * math.dist(a, b), half
        u, n = half_x * np.array([ux, uy]), half_y * np.array([-uy, ux])
        pieces.append(_prism(0.5 * (a + b) + np.array([-u - n, u - n, u + n, n - u]), half))
    return _joined(pieces)


def _prism(outline: np.ndarray, half: float) -> Solid:
    """Prism of a convex outline (m, 2), counter-clockwise, with half a height along z; each of its faces is flat."""
    n = len(outline)
    low, high = (np.column_stack([outline, np.full(n, z)]) for z in (-half, half))
    _, _, left = drawing.directions(np.roll(outline, -1, axis=0) - outline)
    walls = np.stack([low, np.roll(low, -1, axis=0), np.roll(high, -1, axis=0), high], axis=1).reshape(-1, 3)
    outward = np.repeat(np.column_stack([-left, np.zeros(n)]), 4, axis=0)
    quads = (4 * np.arange(n)[:, None, None] + np.array([[0, 1, 2], [0, 2, 3]])).reshape(-1, 3)
    fan = np.stack([np.zeros(n - 2, dtype=int), np.arange(1, n - 1), np.arange(2, n)], axis=1)
    up = np.tile([0.0, 0.0, 1.0], (n, 1))
    return _joined([(walls, outward, quads), (high, up, fan), (low, -up, fan[:, ::-1])])


def _joined(solids: list[Solid]) -> Solid:
    """One solid of several."""
    starts = np.cumsum([0, *(len(points) for points, _, _ in solids[:-1])])
    faces = [faces + start for (_, _, faces), start in zip(solids, starts, strict=True)]
    return np.concatenate([s[0] for s in solids]), np.concatenate([s[1] for s in solids]), np.concatenate(faces)


def _linear_of(colour: str) -> tuple[float, float, float]:
    """Linear red, green, blue of a colour of the screen, such as "#606060"."""
    r, g, b = _linear(np.array([int(colour[k : k + 2], 16) / 255.0 for k in (1, 3, 5)])).tolist()
    return r, g, b


def _linear(values: np.ndarray) -> np.ndarray:
    """Linear red, green, blue of colours of the screen, 0 to 1 (IEC 61966-2-1)."""
    return np.asarray(np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4))
