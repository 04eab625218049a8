"""Meshes that are read as if nothing were beside them: pipes, devices, bombs."""

from __future__ import annotations

import base64
import os
import struct
import zlib
from pathlib import Path

import numpy as np

from support.files.hostile.attacks import harmless, written
from support.files.hostile.meshes import TRIANGLE, gltf_file


@harmless
def obj_whose_material_is_a_pipe(folder: Path) -> Path:
    os.mkfifo(folder / "a.mtl")
    return written(folder / "a.obj", "mtllib a.mtl\nusemtl a\n" + TRIANGLE)


@harmless
def obj_whose_material_is_a_device(folder: Path) -> Path:
    return written(folder / "a.obj", "mtllib /dev/zero\nusemtl a\n" + TRIANGLE)


@harmless
def obj_whose_texture_is_a_pipe(folder: Path) -> Path:
    os.mkfifo(folder / "t.png")
    written(folder / "a.mtl", "newmtl a\nmap_Kd t.png\n")
    return written(folder / "a.obj", "mtllib a.mtl\nusemtl a\n" + TRIANGLE)


@harmless
def obj_whose_texture_is_a_device(folder: Path) -> Path:
    written(folder / "a.mtl", "newmtl a\nmap_Kd /dev/zero\n")
    return written(folder / "a.obj", "mtllib a.mtl\nusemtl a\n" + TRIANGLE)


@harmless
def obj_whose_texture_unpacks_to_gigabytes(folder: Path) -> Path:
    side = 40_000
    head = struct.pack(">IIBBBBB", side, side, 8, 6, 0, 0, 0)

    def chunk(kind: bytes, data: bytes) -> bytes:
        crc = struct.pack(">I", zlib.crc32(kind + data))
        return struct.pack(">I", len(data)) + kind + data + crc

    written(
        folder / "t.png",
        b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(bytes(2**20)))
        + chunk(b"IEND", b""),
    )  # fmt: skip
    written(folder / "a.mtl", "newmtl a\nmap_Kd t.png\n")
    return written(folder / "a.obj", "mtllib a.mtl\nusemtl a\nvt 0 0\n" + TRIANGLE)


@harmless
def ply_whose_texture_is_a_pipe(folder: Path) -> Path:
    os.mkfifo(folder / "t.png")
    head = (
        "ply\nformat ascii 1.0\ncomment TextureFile t.png\nelement vertex 4\nproperty float x\n"
        "property float y\nproperty float z\nelement face 4\n"
        "property list uchar int vertex_indices\nend_header\n"
        "0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 2\n3 0 1 3\n3 0 2 3\n3 1 2 3\n"
    )
    return written(folder / "a.ply", head)


@harmless
def gltf_whose_image_is_a_pipe(folder: Path) -> Path:
    os.mkfifo(folder / "t.png")
    raw = base64.b64encode(np.eye(3, dtype="f4").tobytes()).decode()
    return gltf_file(
        folder,
        {
            "buffers": [{"byteLength": 36, "uri": f"data:;base64,{raw}"}],
            "images": [{"uri": "t.png"}, {"uri": "/dev/zero"}],
            "textures": [{"source": 0}],
            "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        },
    )
