"""Meshes of counts that lie, and glTF that reaches out of its folder."""

from __future__ import annotations

import base64
import json
import os
import struct
import zipfile
from pathlib import Path

import numpy as np

from support.files.hostile.attacks import ATTACKS, Builder, attack, written

TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n"


@attack("mesh")
def ply_of_many_vertices(folder: Path) -> Path:
    head = (
        "ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty float x\n"
        "property float y\nproperty float z\nelement face 1\n"
        "property list uchar int vertex_indices\nend_header\n"
    )
    return written(folder / "a.ply", head.encode() + bytes(100))


@attack("mesh")
def ply_of_lists(folder: Path) -> Path:
    head = (
        "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\n"
        "property float y\nproperty float z\nelement face 1000000000\n"
        "property list uint int vertex_indices\nend_header\n"
    )
    return written(folder / "a.ply", head.encode() + bytes(36) + b"\xff\xff\xff\x7f" + bytes(99))


@attack("mesh")
def stl_of_many_triangles(folder: Path) -> Path:
    return written(folder / "a.stl", bytes(80) + b"\xff\xff\xff\xff" + bytes(100))


@attack("mesh")
def off_of_many_vertices(folder: Path) -> Path:
    return written(folder / "a.off", "OFF\n4000000000 4000000000 0\n0 0 0\n")


def gltf_file(folder: Path, more: dict[str, object], name: str = "a.gltf") -> Path:
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": [{"byteLength": 36, "uri": "data:;base64," + "A" * 48}],
        **more,
    }
    return written(folder / name, json.dumps(document))


def _outside(uri: str) -> Builder:
    def build(folder: Path) -> Path:
        inner = folder / "inner"
        inner.mkdir()
        (folder / "secret.bin").write_bytes(np.eye(3, dtype="f4").tobytes())
        os.mkfifo(inner / "pipe.bin")
        os.symlink("/dev/zero", inner / "link.bin")
        here = uri.replace("HERE", str(folder))
        return gltf_file(inner, {"buffers": [{"byteLength": 36, "uri": here}]})

    return build


for _name, _uri in {
    "above": "../secret.bin",
    "absolute": "HERE/secret.bin",
    "as_url": "file://HERE/secret.bin",
    "quoted": "%2e%2e/secret.bin",
    "from_the_net": "http://127.0.0.1:9/secret.bin",
    "of_a_pipe": "pipe.bin",
    "of_a_link_to_a_device": "link.bin",
    "of_a_device": "/dev/zero",
}.items():
    ATTACKS["mesh"][f"gltf_buffer_{_name}"] = _outside(_uri)


@attack("mesh")
def gltf_accessor_of_terabytes(folder: Path) -> Path:
    accessor = {"componentType": 5126, "count": 2**40, "type": "VEC3"}
    return gltf_file(folder, {"accessors": [accessor]})


@attack("mesh")
def gltf_accessor_of_gigabytes(folder: Path) -> Path:
    accessor = {"componentType": 5126, "count": 2**28, "type": "VEC3"}
    return gltf_file(folder, {"accessors": [accessor]})


@attack("mesh")
def gltf_nodes_in_a_ring(folder: Path) -> Path:
    return gltf_file(
        folder, {"nodes": [{"mesh": 0, "children": [1]}, {"mesh": 0, "children": [0]}]}
    )


@attack("mesh")
def gltf_nodes_that_unfold(folder: Path) -> Path:
    nodes = [{"mesh": 0, "children": [k + 1, k + 1]} for k in range(40)] + [{"mesh": 0}]
    return gltf_file(folder, {"nodes": nodes})


@attack("mesh")
def gltf_buffers_that_repeat(folder: Path) -> Path:
    """One accessor in 10,000 primitives: each is a copy."""
    count = 100_000
    raw = np.zeros((count, 3), "f4")
    primitive = {"attributes": {"POSITION": 0}}
    more = {
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": count, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": raw.nbytes}],
        "buffers": [
            {
                "byteLength": raw.nbytes,
                "uri": "data:;base64," + base64.b64encode(raw.tobytes()).decode(),
            }
        ],
        "meshes": [{"primitives": [primitive] * 10_000}],
    }
    return gltf_file(folder, more)


@attack("mesh")
def glb_that_lies(folder: Path) -> Path:
    return written(
        folder / "a.glb",
        b"glTF" + struct.pack("<III4s", 2, 0xFFFFFFFF, 0xFFFFFFF0, b"JSON") + b"{}",
    )


@attack("mesh")
def glb_of_json_nested(folder: Path) -> Path:
    text = b'{"asset": ' + b"[" * 200_000
    head = struct.pack("<II", 2, 20 + len(text)) + struct.pack("<I4s", len(text), b"JSON")
    return written(folder / "a.glb", b"glTF" + head + text)


@attack("mesh")
def zip_of_a_mesh(folder: Path) -> Path:
    path = folder / "a.zip"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("a.obj", b"# " + bytes(2**24))
    return path
