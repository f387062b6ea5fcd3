"""Binary glTF 2.0 files: meshes, nodes, materials, and motions of nodes.

Source: Khronos Group, glTF 2.0 Specification, 2021 (ISO/IEC 12113).
"""

from __future__ import annotations

import json
import struct
from collections.abc import Sequence
from typing import Any

import numpy as np

MAGIC, VERSION, JSON_CHUNK, BIN_CHUNK = 0x46546C67, 2, 0x4E4F534A, 0x004E4942
FLOAT, UINT = 5126, 5125
"""Component types of accessors."""

WEIGHTS = "weights"
"""Path of the motion of a mesh between its shapes."""

KINDS = {1: "SCALAR", 3: "VEC3", 4: "VEC4"}
ARRAY_BUFFER, ELEMENT_BUFFER = 34962, 34963


class Glb:
    """A glTF document that grows by meshes, nodes and motions."""

    def __init__(self, generator: str) -> None:
        self._data = bytearray()
        self._inputs: dict[bytes, int] = {}
        self.document: dict[str, Any] = {
            "asset": {"version": "2.0", "generator": generator},
            "scene": 0,
            "scenes": [{"nodes": []}],
            "nodes": [],
            "meshes": [],
            "materials": [],
            "accessors": [],
            "bufferViews": [],
            "animations": [{"name": "motion", "channels": [], "samplers": []}],
        }

    def material(self, name: str, rgb: tuple[float, float, float]) -> int:
        """Number of a new material, seen from both sides; `rgb`: linear colour, 0 to 1."""
        surface = {"baseColorFactor": [*rgb, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.8}
        return self._append("materials", {"name": name, "pbrMetallicRoughness": surface, "doubleSided": True})

    def mesh(
        self,
        name: str,
        positions: np.ndarray,
        normals: np.ndarray,
        faces: np.ndarray,
        material: int,
        *,
        colours: np.ndarray | None = None,
        shapes: Sequence[np.ndarray] = (),
    ) -> int:
        """Number of a new mesh of triangles `faces` (m, 3) on positions (n, 3) [m] with unit normals (n, 3).

        Linear colours (n, 3) of the points multiply that of the material; None: that of the material.  `shapes` are
        displacements (n, 3) [m] that `deform` adds up (morph targets).
        """
        attributes = {
            "POSITION": self._accessor(positions, ARRAY_BUFFER, limits=True),
            "NORMAL": self._accessor(normals, ARRAY_BUFFER),
        }
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
        """Move a node in the plane: instants (n,) [s], places (n, 2) [m], angles (n,) about z [rad].

        `scales` (n, 3) are factors of the size; None: the size stays.
        """
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
        motion = self.document["animations"][0]
        key = time.tobytes()
        if key not in self._inputs:
            self._inputs[key] = self._accessor(time.reshape(-1, 1), None, limits=True)
        motion["samplers"].append(
            {"input": self._inputs[key], "output": self._accessor(values, None), "interpolation": "LINEAR"}
        )
        target = {"node": node, "path": path}
        motion["channels"].append({"sampler": len(motion["samplers"]) - 1, "target": target})

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
        size = 12 + 8 + len(text) + 8 + len(data)
        head = struct.pack("<3I", MAGIC, VERSION, size)
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
