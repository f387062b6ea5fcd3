"""glTF files: structure, accessors, places of the parts at all instants, bad input."""

import json
import runpy
import struct
from pathlib import Path

import numpy as np
import pytest

import flexmb as fm
from flexmb.errors import InputError

solution = runpy.run_path(str(Path(__file__).parents[1] / "handmade.py"))["solution"]
TYPES = {5126: np.float32, 5125: np.uint32}
WIDE = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}


class File:
    """A binary glTF file as the specification lays it out."""

    def __init__(self, path):
        raw = path.read_bytes()
        magic, version, length = struct.unpack_from("<4sII", raw)
        assert (magic, version, length) == (b"glTF", 2, len(raw))
        size, kind = struct.unpack_from("<I4s", raw, 12)
        assert (kind, size % 4) == (b"JSON", 0)
        self.document = json.loads(raw[20 : 20 + size])
        more, kind = struct.unpack_from("<I4s", raw, 20 + size)
        assert (kind, more % 4) == (b"BIN\0", 0)
        self.data = raw[28 + size :]
        assert len(self.data) == more

    def array(self, number):
        accessor = self.document["accessors"][number]
        view = self.document["bufferViews"][accessor["bufferView"]]
        count = accessor["count"] * WIDE[accessor["type"]]
        kind = TYPES[accessor["componentType"]]
        assert view["byteOffset"] % 4 == 0
        assert view["byteLength"] == 4 * count
        return np.frombuffer(self.data, kind, count, view["byteOffset"]).reshape(accessor["count"], -1)

    def motion(self, name):
        """Input and outputs of the channels of a node."""
        node = next(k for k, node in enumerate(self.document["nodes"]) if node["name"] == name)
        animation = self.document["animations"][0]
        found = {}
        for channel in animation["channels"]:
            if channel["target"]["node"] == node:
                sampler = animation["samplers"][channel["sampler"]]
                found[channel["target"]["path"]] = self.array(sampler["output"])
                found["time"] = self.array(sampler["input"])[:, 0]
        return found


@pytest.fixture(scope="module")
def sol():
    return solution()


@pytest.fixture(scope="module")
def file(sol, tmp_path_factory):
    return File(fm.plots.export_gltf(sol, tmp_path_factory.mktemp("gltf") / "new" / "x.glb", frames=21))


def test_accessors_hold_what_they_say(file):
    for k, accessor in enumerate(file.document["accessors"]):
        values = file.array(k)
        assert np.isfinite(values).all()
        if "min" in accessor:
            np.testing.assert_array_equal(values.min(axis=0), np.array(accessor["min"], dtype=values.dtype))
            np.testing.assert_array_equal(values.max(axis=0), np.array(accessor["max"], dtype=values.dtype))
    (buffer,) = file.document["buffers"]
    assert buffer["byteLength"] <= len(file.data) < buffer["byteLength"] + 4


def test_meshes_are_closed_and_their_normals_point_outwards(file):
    for mesh in file.document["meshes"]:
        (piece,) = mesh["primitives"]
        points, normals = (file.array(piece["attributes"][name]).astype(float) for name in ("POSITION", "NORMAL"))
        faces = file.array(piece["indices"]).reshape(-1, 3)
        assert faces.max() == len(points) - 1
        np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, atol=1e-6)
        a, b, c = (points[faces[:, k]] for k in range(3))
        outward = np.cross(b - a, c - a)
        assert np.all(np.sum(outward * normals[faces[:, 0]], axis=1) > 0.0)  # counter-clockwise from outside
        np.testing.assert_allclose(outward.sum(axis=0), 0.0, atol=1e-6 * np.abs(outward).sum())  # closed
        assert "min" in file.document["accessors"][piece["attributes"]["POSITION"]]


def test_nodes_move_as_their_parts(sol, file):
    rows = np.arange(0, 101, 5)
    crank = file.motion("crank")
    np.testing.assert_allclose(crank["time"], sol.time[rows], atol=1e-7)
    np.testing.assert_allclose(crank["translation"][:, 0], sol.array("crank.x")[rows], atol=1e-7)
    angle = 2.0 * np.unwrap(np.arctan2(crank["rotation"][:, 2], crank["rotation"][:, 3]), period=np.pi)
    np.testing.assert_allclose(angle, sol.array("crank.theta")[rows], atol=1e-6)
    assert np.all(np.sum(crank["rotation"][1:] * crank["rotation"][:-1], axis=1) > 0.0)  # the short way round
    first, last = file.motion("arm 0.0"), file.motion("arm 1.6")
    np.testing.assert_allclose(first["translation"][:, 1], sol.array("arm.start.y")[rows], atol=1e-7)
    turned = 2.0 * np.arctan2(last["rotation"][:, 2], last["rotation"][:, 3])
    tip = last["translation"][:, :2] + last["scale"][:, :1] * np.stack([np.cos(turned), np.sin(turned)], axis=-1)
    np.testing.assert_allclose(tip[:, 1], sol.array("arm.end.y")[rows], atol=1e-6)


@pytest.mark.parametrize("save", [20, [0.0, 0.001, 0.002, 0.1, 0.2]])
def test_springs_change_their_length_at_all_saved_instants(tmp_path, save):
    bead = fm.bodies.PointMass("bead", at=(0.2, 0.0), mass=0.1)
    spring = fm.SpringDamper("spring", fm.GROUND, bead, at=(0.0, 0.0), to=bead.at, stiffness=30.0, free_length=0.1)
    sol = fm.simulate(fm.Mechanism("bead", [bead, spring]), t_end=0.2, save=save)
    found = File(fm.plots.export_gltf(sol, tmp_path / "x.glb")).motion("spring")
    np.testing.assert_allclose(found["scale"][:, 0], sol.array("bead.x"), atol=1e-7)


@pytest.mark.parametrize(
    ("path", "keywords", "words"),
    [
        ("x.gltf", {}, "must end in .glb"),
        ("x.glb", {"frames": 1}, "frames is 1"),
        ("x.glb", {"magnify": -1.0}, "magnify is -1"),
    ],
)
def test_what_is_refused(sol, tmp_path, path, keywords, words):
    with pytest.raises(InputError, match=words):
        fm.plots.export_gltf(sol, tmp_path / path, **keywords)
