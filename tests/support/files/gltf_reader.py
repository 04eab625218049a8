"""glTF 2.0 files as the specification has them: read, checked, and posed in plain numpy."""

from __future__ import annotations

import base64
import json
import struct
from pathlib import Path

import numpy as np

_TYPES = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}


class Gltf:
    """A file; `json` is its text."""

    def __init__(self, path: Path) -> None:
        raw = path.read_bytes()
        if raw[:4] == b"glTF":
            version, size = struct.unpack_from("<II", raw, 4)
            assert (version, size) == (2, len(raw))
            length, kind = struct.unpack_from("<II", raw, 12)
            assert kind == 0x4E4F534A
            assert length % 4 == 0
            self.json = json.loads(raw[20 : 20 + length])
            at = 20 + length
            length, kind = struct.unpack_from("<II", raw, at)
            assert kind == 0x004E4942
            assert at + 8 + length == len(raw)
            self.data = raw[at + 8 :]
            assert 0 <= len(self.data) - self.json["buffers"][0]["byteLength"] < 4
        else:
            self.json = json.loads(raw)
            head, text = self.json["buffers"][0]["uri"].split(",")
            assert head == "data:application/octet-stream;base64"
            self.data = base64.b64decode(text)
            assert len(self.data) == self.json["buffers"][0]["byteLength"]

    def array(self, index: int) -> np.ndarray:
        """The numbers of an accessor, (n,) or (n, k), as they are stored."""
        accessor = self.json["accessors"][index]
        view = self.json["bufferViews"][accessor["bufferView"]]
        width = _WIDTHS[accessor["type"]]
        dtype = np.dtype(_TYPES[accessor["componentType"]])
        offset, size = accessor.get("byteOffset", 0), accessor["count"] * width * dtype.itemsize
        start = view.get("byteOffset", 0) + offset
        assert start % 4 == 0  # stricter than "a multiple of the component's size"
        assert "byteStride" not in view
        assert offset + size <= view["byteLength"]
        assert view.get("byteOffset", 0) + view["byteLength"] <= len(self.data)
        out = np.frombuffer(self.data, dtype, accessor["count"] * width, start)
        return out if width == 1 else out.reshape(-1, width)

    def node(self, name: str) -> int:
        """The node with a unique name."""
        (found,) = (i for i, n in enumerate(self.json["nodes"]) if n.get("name") == name)
        return found

    @property
    def times(self) -> np.ndarray:
        """The times of the keys [s]."""
        (animation,) = self.json["animations"]
        (accessor,) = {s["input"] for s in animation["samplers"]}  # one for all
        return self.array(accessor)

    def values(self, time: float) -> dict[tuple[int, str], np.ndarray]:
        """(node, path) -> value at a time, between keys linear or spherical."""
        out = {}
        for animation in self.json.get("animations", []):
            for channel in animation["channels"]:
                sampler = animation["samplers"][channel["sampler"]]
                assert sampler.get("interpolation", "LINEAR") == "LINEAR"
                keys = self.array(sampler["input"]).astype(float)
                rows = self.array(sampler["output"]).astype(float).reshape(len(keys), -1)
                k = int(np.clip(np.searchsorted(keys, time, "right") - 1, 0, len(keys) - 2))
                w = float(np.clip((time - keys[k]) / (keys[k + 1] - keys[k]), 0.0, 1.0))
                a, b = rows[k], rows[k + 1]
                path = channel["target"]["path"]
                value = (1.0 - w) * a + w * b
                if path == "rotation" and 0.0 < w < 1.0:
                    cosine = abs(a @ b)
                    angle = np.arccos(min(cosine, 1.0))
                    if angle > 1e-6:
                        b = b if a @ b > 0.0 else -b
                        value = np.sin((1 - w) * angle) * a + np.sin(w * angle) * b
                        value /= np.sin(angle)
                out[channel["target"]["node"], path] = value
        return out

    def globals(self, time: float) -> np.ndarray:
        """World matrices of all nodes (n, 4, 4)."""
        values, nodes = self.values(time), self.json["nodes"]
        out = np.full((len(nodes), 4, 4), np.nan)

        def visit(index: int, above: np.ndarray) -> None:
            node = nodes[index]
            assert "matrix" not in node
            local = np.eye(4)
            q = values.get((index, "rotation"), node.get("rotation", [0, 0, 0, 1]))
            local[:3, :3] = _matrix(np.asarray(q, dtype=float))
            local[:3, 3] = values.get((index, "translation"), node.get("translation", [0, 0, 0]))
            assert "scale" not in node
            assert np.isnan(out[index]).all(), "a node with two parents"
            out[index] = above @ local
            for child in node.get("children", []):
                visit(child, out[index])

        for root in self.json["scenes"][self.json["scene"]]["nodes"]:
            visit(root, np.eye(4))
        assert not np.isnan(out).any(), "a node that is not in the scene"
        return out

    def vertices(self, name: str, time: float) -> np.ndarray:
        """World positions (V, 3) of a node's mesh at a time: morphed, then skinned."""
        index = self.node(name)
        node = self.json["nodes"][index]
        mesh = self.json["meshes"][node["mesh"]]
        (primitive,) = mesh["primitives"]
        attributes = primitive["attributes"]
        points = self.array(attributes["POSITION"]).astype(float)
        if "targets" in primitive:
            weights = self.values(time).get((index, "weights"), mesh["weights"])
            for weight, target in zip(weights, primitive["targets"], strict=True):
                points = points + weight * self.array(target["POSITION"])
        points = np.concatenate([points, np.ones((len(points), 1))], axis=1)
        world = self.globals(time)
        if "skin" not in node:
            return (points @ world[index].T)[:, :3]
        skin = self.json["skins"][node["skin"]]
        bind = self.array(skin["inverseBindMatrices"]).astype(float)
        bind = bind.reshape(-1, 4, 4).transpose(0, 2, 1)  # columns one after the other
        moves = world[skin["joints"]] @ bind
        out = np.zeros((len(points), 4))
        sets = sum(key.startswith("JOINTS_") for key in attributes)
        for k in range(sets):
            joints = self.array(attributes[f"JOINTS_{k}"])
            weights = self.array(attributes[f"WEIGHTS_{k}"]).astype(float)
            for c in range(4):
                moved = np.einsum("vab,vb->va", moves[joints[:, c]], points)
                out += weights[:, c : c + 1] * moved
        return out[:, :3]

    def check(self) -> None:
        """Check rules of the specification (sections 3.6 to 3.11) that such files can break."""
        text = self.json
        assert text["asset"]["version"] == "2.0"
        views = text["bufferViews"]
        users: dict[int, list[int]] = {}
        for index, accessor in enumerate(text["accessors"]):
            array = self.array(index)  # checks range and alignment
            if array.dtype.kind == "f":
                assert np.isfinite(array).all()
            for key, of in (("min", np.min), ("max", np.max)):
                if key in accessor:
                    rows = array.reshape(len(array), -1)
                    np.testing.assert_array_equal(accessor[key], of(rows, axis=0).astype(float))
            users.setdefault(accessor["bufferView"], []).append(index)
        for index, view in enumerate(views):
            assert index in users
            if view.get("target") == 34962:  # several need a byteStride
                assert len(users[index]) == 1
        for mesh in text["meshes"]:
            (primitive,) = mesh["primitives"]
            self._check_primitive(primitive)
            if "targets" in primitive:
                assert len(mesh["weights"]) == len(primitive["targets"])
        for skin in text["skins"]:
            assert len(set(skin["joints"])) == len(skin["joints"])
            assert len(self.array(skin["inverseBindMatrices"])) == len(skin["joints"])
        for animation in text.get("animations", []):
            targets = [(c["target"]["node"], c["target"]["path"]) for c in animation["channels"]]
            assert len(set(targets)) == len(targets) > 0
            for channel in animation["channels"]:
                self._check_channel(channel, animation["samplers"][channel["sampler"]])

    def _check_primitive(self, primitive: dict) -> None:
        attributes = primitive["attributes"]
        position = text = self.json["accessors"][attributes["POSITION"]]
        assert {"min", "max"} <= set(text)
        for name, index in attributes.items():
            accessor = self.json["accessors"][index]
            assert accessor["count"] == position["count"], name
            assert self.json["bufferViews"][accessor["bufferView"]]["target"] == 34962
        for target in primitive.get("targets", []):
            accessor = self.json["accessors"][target["POSITION"]]
            assert accessor["count"] == position["count"]
            assert {"min", "max"} <= set(accessor)
        indices = self.json["accessors"][primitive["indices"]]
        assert self.json["bufferViews"][indices["bufferView"]]["target"] == 34963
        corners = self.array(primitive["indices"])
        assert len(corners) % 3 == 0
        assert corners.max() < position["count"]
        assert corners.max() < np.iinfo(corners.dtype).max  # that one restarts a strip
        normals = self.array(attributes["NORMAL"]).astype(float)
        np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, atol=1e-6)
        sets = [k for k in range(9) if f"JOINTS_{k}" in attributes]
        if sets:
            assert sets == list(range(len(sets)))
            joints = np.concatenate([self.array(attributes[f"JOINTS_{k}"]) for k in sets], axis=1)
            weights = np.concatenate([self.array(attributes[f"WEIGHTS_{k}"]) for k in sets], axis=1)
            assert (weights >= 0.0).all()
            assert (np.diff(weights, axis=1) <= 0.0).all()  # a reader of four gets the largest
            np.testing.assert_allclose(weights.astype(float).sum(axis=1), 1.0, atol=5e-7)
            assert joints.max() < 55
            assert (joints[weights == 0.0] == 0).all()

    def _check_channel(self, channel: dict, sampler: dict) -> None:
        times = self.array(sampler["input"])
        assert {"min", "max"} <= set(self.json["accessors"][sampler["input"]])
        assert times[0] >= 0.0
        assert (np.diff(times) > 0.0).all()
        rows = self.array(sampler["output"])
        path = channel["target"]["path"]
        if path == "weights":
            node = self.json["nodes"][channel["target"]["node"]]
            assert len(rows) == len(times) * len(self.json["meshes"][node["mesh"]]["weights"])
            rows = rows.reshape(len(times), -1)
        assert len(rows) == len(times)
        # The only one of a file in which nothing moves says how long that is.
        alone = len(self.json["animations"][0]["channels"]) == 1
        assert (rows != rows[0]).any() or alone, "a channel that says nothing"
        if path == "rotation":
            np.testing.assert_allclose(np.linalg.norm(rows.astype(float), axis=1), 1.0, atol=1e-6)
            assert (np.einsum("ti,ti->t", rows[1:], rows[:-1]) >= -1e-6).all(), "a sign jumps"


def _matrix(q: np.ndarray) -> np.ndarray:
    x, y, z, w = q / np.linalg.norm(q)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
