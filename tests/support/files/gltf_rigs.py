"""glTF files as Mixamo, Blender and others write them, made from a known motion.

Joint frames at the bind pose are turned in any way, the skeleton is in any unit below an armature
that is turned and scaled, and nodes stand at another pose than the bind pose.
"""

from __future__ import annotations

import json
import struct
import warnings
from pathlib import Path
from typing import Any

import numpy as np

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.errors import HalfPhysicsWarning
from halfphysics.motion.skeleton import FACE_JOINTS, PARENTS
from support.files.bvh_files import MIXAMO
from support.files.layouts import movement

#: File, y up, from the world.
_TURN = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])


class Builder:
    """The JSON of a file, `json`, and its buffer, `data`."""

    def __init__(self) -> None:
        self.data = bytearray()
        self.json: dict[str, Any] = {
            "asset": {"version": "2.0", "generator": "a test"},
            "scene": 0,
            "scenes": [{"nodes": []}],
            "nodes": [],
            "skins": [],
            "animations": [],
            "accessors": [],
            "bufferViews": [],
            "buffers": [{"byteLength": 0}],
        }

    def accessor(self, array: np.ndarray, type: str, component: int = 5126) -> int:
        """Floats, or whole numbers (5121, 5123, 5125), in a view of their own."""
        kinds = {5126: "<f4", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4"}
        raw = np.ascontiguousarray(array, dtype=kinds[component]).tobytes()
        self.data += b"\0" * (-len(self.data) % 4)
        view = {"buffer": 0, "byteOffset": len(self.data), "byteLength": len(raw)}
        self.data += raw
        self.json["bufferViews"].append(view)
        self.json["accessors"].append(
            {
                "bufferView": len(self.json["bufferViews"]) - 1,
                "componentType": component,
                "count": len(array),
                "type": type,
            }
        )
        return len(self.json["accessors"]) - 1

    def node(self, parent: int | None = None, **fields: Any) -> int:
        nodes = self.json["nodes"]
        nodes.append(dict(fields))
        index = len(nodes) - 1
        if parent is None:
            self.json["scenes"][0]["nodes"].append(index)
        else:
            nodes[parent].setdefault("children", []).append(index)
        return index

    def animation(self, name: str) -> dict[str, Any]:
        self.json["animations"].append({"name": name, "channels": [], "samplers": []})
        return self.json["animations"][-1]

    def animate(
        self, animation: dict[str, Any], node: int, path: str, times: np.ndarray,
        values: np.ndarray, kind: str = "LINEAR",
    ) -> None:  # fmt: skip
        """Values (T, n); quaternions w, x, y, z. Cubic ones get tangents of differences."""
        if path == "rotation":
            values = rot.continuous(values[:, None])[:, 0][:, [1, 2, 3, 0]]
        if kind == "CUBICSPLINE":
            slope = np.gradient(values, times, axis=0)
            values = np.stack([slope, values, slope], axis=1).reshape(-1, values.shape[1])
        type = "VEC4" if path == "rotation" else "VEC3"
        sampler = {
            "input": self.accessor(times[:, None], "SCALAR"),
            "output": self.accessor(values, type),
        }
        if kind != "LINEAR":
            sampler["interpolation"] = kind
        animation["channels"].append(
            {"sampler": len(animation["samplers"]), "target": {"node": node, "path": path}}
        )
        animation["samplers"].append(sampler)

    def glb(self, path: Path) -> Path:
        self.json["buffers"][0] = {"byteLength": len(self.data)}
        text = json.dumps({k: v for k, v in self.json.items() if v != []}).encode()
        text += b" " * (-len(text) % 4)
        data = bytes(self.data) + b"\0" * (-len(self.data) % 4)
        size = 12 + 8 + len(text) + 8 + len(data)
        path.write_bytes(
            struct.pack("<4sII", b"glTF", 2, size)
            + struct.pack("<I4s", len(text), b"JSON") + text
            + struct.pack("<I4s", len(data), b"BIN\0") + data
        )  # fmt: skip
        return path

    def gltf(self, path: Path, uri: str) -> Path:
        """Text, and the buffer beside it under `uri`, if that is a plain name."""
        self.json["buffers"][0] = {"byteLength": len(self.data), "uri": uri}
        path.write_text(json.dumps(self.json))
        if not {"/", ":"} & set(uri):
            (path.parent / uri).write_bytes(bytes(self.data))
        return path


def add_person(
    builder: Builder,
    animation: dict[str, Any],
    motion: hp.Motion,
    body: hp.Body,
    *,
    names: dict[int, str] = MIXAMO,
    prefix: str = "",
    own: np.ndarray | None = None,
    unit: float = 1.0,
    tilt: Any = (0.0, 0.0, 0.0),
    seed: int | None = None,
    kind: str = "LINEAR",
    skinned: bool = True,
    start: float = 0.0,
    turned: np.ndarray | None = None,
) -> list[int]:
    """A person's nodes, skin and animation; returns the joints' nodes.

    Args:
        builder, animation: Where to add them.
        motion, body: In the z-up world.
        names: SMPL-X joint -> name, of the joints that are in the file.
        prefix: Of all names.
        own: SMPL-X joint from the file's joint at the bind pose (55, 4), as in `retold`.
        unit: Of the skeleton, per metre; the armature is scaled to metres.
        tilt: Rotation of the armature, axis-angle.
        seed: Joint frames are turned at random; None: parallel at the bind pose.
        kind: Of interpolation.
        skinned: With a skin; else nodes are at the bind pose without animation.
        start: Time of the first key [s].
        turned: Rotation (3, 3) of the space of the bind pose, which the nodes do not show.
    """
    own = np.tile([1.0, 0.0, 0.0, 0.0], (55, 1)) if own is None else own
    random = np.random.default_rng(seed).normal(0, 1, (55, 4))
    frames = own * 0 + [1, 0, 0, 0] if seed is None else rot.normalize(random)
    places, world = body.joint_frames(motion)
    turn = rot.from_matrix(_TURN)
    armature = rot.exp(np.asarray(tilt, dtype=float))
    back = rot.conjugate(armature)
    places = unit * rot.rotate(back, rot.rotate(turn, places))
    world = rot.multiply(rot.multiply(rot.multiply(back, rot.multiply(turn, world)), own), frames)
    kept = sorted(names)
    rest = {0: body.rest_joints[0]}
    for joint in range(1, 55):
        parent = int(PARENTS[joint])
        way = body.rest_joints[joint] - body.rest_joints[parent]
        rest[joint] = rest[parent] + rot.rotate(rot.conjugate(own[parent]), way)
    holder = builder.node(
        name=f"{prefix}Armature", rotation=_xyzw(armature), scale=[1.0 / unit] * 3
    )
    times = start + np.arange(len(motion)) / motion.fps
    nodes: dict[int, int] = {}
    for joint in kept:
        parent = int(PARENTS[joint])
        local, place = world[:, joint], places[:, joint]
        if parent in nodes:
            into = rot.conjugate(world[:, parent])
            local = rot.multiply(into, world[:, joint])
            place = rot.rotate(into, places[:, joint] - places[:, parent])
        still = rot.multiply(
            rot.conjugate(frames[parent]) if parent in nodes else back, frames[joint]
        )
        bind = unit * rot.rotate(back, rest[joint])
        if parent in nodes:
            bind = unit * rot.rotate(rot.conjugate(frames[parent]), rest[joint] - rest[parent])
        fields = {"rotation": _xyzw(local[0]), "translation": place[0].tolist()}
        if not skinned:
            fields = {"rotation": _xyzw(still), "translation": bind.tolist()}
        nodes[joint] = builder.node(nodes.get(parent, holder), name=prefix + names[joint], **fields)
        builder.animate(animation, nodes[joint], "rotation", times, local, kind)
        if parent not in nodes:
            builder.animate(animation, nodes[joint], "translation", times, place, kind)
    if skinned:
        inverse = np.tile(np.eye(4), (len(kept), 1, 1))
        inverse[:, :3, :3] = np.swapaxes(rot.to_matrix(rot.multiply(back, frames[kept])), 1, 2)
        at = unit * rot.rotate(back, np.array([rest[joint] for joint in kept]))
        inverse[:, :3, 3] = -np.einsum("jab,jb->ja", inverse[:, :3, :3], at)
        if turned is not None:
            inverse[:, :3, :3] = inverse[:, :3, :3] @ turned.T
        columns = np.swapaxes(inverse, 1, 2).reshape(-1, 16)
        builder.json["skins"].append(
            {
                "joints": [nodes[joint] for joint in kept],
                "inverseBindMatrices": builder.accessor(columns, "MAT4"),
            }
        )
    return [nodes[joint] for joint in kept]


def person(motion: hp.Motion, body: hp.Body, name: str = "take", **options: Any) -> Builder:
    """A file of one person."""
    builder = Builder()
    add_person(builder, builder.animation(name), motion, body, **options)
    return builder


def _xyzw(quaternion: np.ndarray) -> list[float]:
    return [float(v) for v in np.asarray(quaternion)[[1, 2, 3, 0]]]


def motion_of(frames: int = 16, seed: int = 0, fps: float = 30.0) -> hp.Motion:
    """A person who moves, with the face at rest."""
    translation, rotations = movement(frames, seed=seed)
    rotations[:, list(FACE_JOINTS)] = 0.0
    return hp.Motion(translation, rotations, fps)


def read(path, **options) -> hp.Motion:
    """The motion of a file, without a warning."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", HalfPhysicsWarning)
        return hp.Motion.load(path, **options)
