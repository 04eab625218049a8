"""glTF 2.0, binary (.glb) or as text (.gltf): skinned people and rigid props, animated.

One scene, y-up: the node "world" turns it from z-up. Its children are every person's 55 joints,
as nodes named as `JOINT_NAMES`, and the props; the skins are beside it, because glTF ignores the
poses of nodes with a skin. The nodes have the pose of the first frame, so constant channels are
left out, and programs without animation show the first frame.

The dents of soft props are morph targets, with their normals (`dent_shapes`).

The skinning of glTF is that of SMPL without pose blend shapes; if a body has them, they are
morph targets (`correctives`), which glTF applies before the skinning, as required.
"""

from __future__ import annotations

import base64
import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfphysics import __version__
from halfphysics.base import rotations as rot
from halfphysics.base.atomic import atomic_write
from halfphysics.body.body import Body
from halfphysics.motion.skeleton import JOINT_NAMES, N_JOINTS, PARENTS
from halfphysics.render.rasterizer import Color
from halfphysics.render.result_meshes import CREASE
from halfphysics.writers.colors import actors_coloured, linear, props_coloured
from halfphysics.writers.correctives import correctives
from halfphysics.writers.dent_shapes import MovingSurface, dent_shapes, moving_surface
from halfphysics.writers.gltf_buffer import INDICES, VERTICES, Buffer
from halfphysics.writers.normals import creased, vertex_normals
from halfphysics.writers.take import Actor, Prop, Take

Array = NDArray[np.float64]
Floats = NDArray[np.float32]

#: Largest number of joints per vertex in the file; the remaining weights are distributed over them.
MOST_INFLUENCES = 8

_Y_UP = [-float(np.sqrt(0.5)), 0.0, 0.0, float(np.sqrt(0.5))]  # -90 degrees about x, xyzw
_GLB, _JSON_CHUNK, _BIN_CHUNK = 0x46546C67, 0x4E4F534A, 0x004E4942


def write(take: Take, path: Path) -> None:
    """Write a take.

    Raises:
        FileError: The folder does not exist or cannot be written.
    """
    document, data = document_of(take)
    text = path.suffix.lower() == ".gltf"
    if text:
        document["buffers"][0]["uri"] = "data:application/octet-stream;base64," + base64.b64encode(
            data
        ).decode("ascii")
    encoded = json.dumps(document, separators=(",", ":"), allow_nan=False).encode("utf-8")
    with atomic_write(path) as handle:
        handle.write(encoded if text else _glb(encoded, data))


def _glb(text: bytes, data: bytes) -> bytes:
    """The binary container: a header and two chunks, each of whole words."""
    text += b" " * (-len(text) % 4)
    data += b"\0" * (-len(data) % 4)
    size = 12 + 8 + len(text) + 8 + len(data)
    return b"".join(
        [
            struct.pack("<III", _GLB, 2, size),
            struct.pack("<II", len(text), _JSON_CHUNK) + text,
            struct.pack("<II", len(data), _BIN_CHUNK) + data,
        ]
    )


def document_of(take: Take) -> tuple[dict[str, Any], bytes]:
    """The JSON of a take, and its buffer."""
    builder = _Builder(take)
    for actor, color in actors_coloured(take.actors):
        builder.add_actor(actor, color)
    for prop, color in props_coloured(take.props):
        builder.add_prop(prop, color)
    return builder.document()


class _Builder:
    """Collects nodes, meshes, materials and channels."""

    def __init__(self, take: Take) -> None:
        self.buffer = Buffer()
        self.nodes: list[dict[str, Any]] = [{"name": "world", "rotation": _Y_UP, "children": []}]
        self.roots = [0]
        self.meshes: list[dict[str, Any]] = []
        self.skins: list[dict[str, Any]] = []
        self.materials: list[dict[str, Any]] = []
        self.channels: list[dict[str, Any]] = []
        self._still: tuple[int, Floats] | None = None  # a node that does not move, and its places
        self.samplers: list[dict[str, Any]] = []
        self.fps = take.fps
        self.times = (np.arange(take.frames) / take.fps).astype(np.float32)
        self._time: int | None = None  # accessor of `times`; None without animation
        self._of_body: dict[int, tuple[dict[str, int], int, int]] = {}

    def document(self) -> tuple[dict[str, Any], bytes]:
        """The JSON of the file."""
        if not self.channels and self._still is not None:  # for how long everything stands still
            node, place = self._still
            self._add_channels([node], "translation", place[None])
        document: dict[str, Any] = {
            "asset": {"version": "2.0", "generator": f"halfphysics {__version__}"},
            "scene": 0,
            "scenes": [{"nodes": self.roots}],
            "nodes": self.nodes,
            "meshes": self.meshes,
            "skins": self.skins,
            "materials": self.materials,
        }
        if self.channels:
            document["animations"] = [
                {
                    "name": "take",
                    "channels": self.channels,
                    "samplers": self.samplers,
                    "extras": {"fps": self.fps},
                }
            ]
        document["accessors"] = self.buffer.accessors
        document["bufferViews"] = self.buffer.views
        document["buffers"] = [{"byteLength": len(self.buffer.data)}]
        return document, bytes(self.buffer.data)

    # -- people --------------------------------------------------------------------------------

    def add_actor(self, actor: Actor, color: Color) -> None:
        """Add a person: joints, a skinned mesh and their animation."""
        person, first = self._add_skeleton(actor)
        attributes, indices, bind = self._skin_of(actor.body)
        self.skins.append(
            {
                "inverseBindMatrices": bind,
                "joints": list(range(first, first + N_JOINTS)),
                "skeleton": person,
            }
        )
        primitive = {
            "attributes": attributes,
            "indices": indices,
            "material": self._material(actor.name, color),
        }
        mesh: dict[str, Any] = {"name": f"{actor.name}_skin", "primitives": [primitive]}
        weights = None
        if actor.body.posedirs is not None:
            shapes, weights = correctives(actor.body.posedirs, actor.motion.rotations)
            if len(shapes):
                primitive["targets"] = [
                    {"POSITION": self.buffer.add(s.astype(np.float32), VERTICES, bounds=True)}
                    for s in shapes
                ]
                mesh["weights"] = weights[0].astype(np.float32).tolist()
        self.meshes.append(mesh)
        skinned = self._node(
            {
                "name": f"{actor.name}_skin",
                "mesh": len(self.meshes) - 1,
                "skin": len(self.skins) - 1,
            }
        )
        self.roots.append(skinned)
        if "weights" in mesh and weights is not None:
            self._animate(skinned, "weights", weights)

    def _add_skeleton(self, actor: Actor) -> tuple[int, int]:
        """Add a person's node and animated joints; returns the node and the first joint's."""
        body, motion = actor.body, actor.motion
        root = body.joint_frames(motion)[0][:, 0]
        turns = rot.continuous(rot.exp(motion.rotations))
        first = len(self.nodes) + 1
        person = self._node({"name": actor.name, "children": [first]}, parent=0)
        arms = body.rest_joints - body.rest_joints[PARENTS]
        for j, name in enumerate(JOINT_NAMES):
            node: dict[str, Any] = {"name": name}
            children = [first + int(c) for c in np.flatnonzero(j == PARENTS)]
            if children:
                node["children"] = children
            node["translation"] = _numbers(root[0] if j == 0 else arms[j])
            node["rotation"] = _numbers(turns[0, j])
            self._node(node)
        self._animate(first, "translation", root)
        self._animate_all(range(first, first + N_JOINTS), "rotation", np.moveaxis(turns, 1, 0))
        return person, first

    def _skin_of(self, body: Body) -> tuple[dict[str, int], int, int]:
        """Accessors of a body's attributes, indices and bind matrices; once for each body."""
        if id(body) not in self._of_body:
            add = self.buffer.add
            normals = vertex_normals(body.rest_vertices, body.faces)
            attributes = {
                "POSITION": add(body.rest_vertices.astype(np.float32), VERTICES, bounds=True),
                "NORMAL": add(normals.astype(np.float32), VERTICES),
            }
            for k, (joints, weights) in enumerate(influences(body.weights)):
                attributes[f"JOINTS_{k}"] = add(joints, VERTICES)
                attributes[f"WEIGHTS_{k}"] = add(weights, VERTICES)
            bind = np.tile(np.eye(4), (N_JOINTS, 1, 1))
            bind[:, 3, :3] = -body.rest_joints  # stored by columns
            self._of_body[id(body)] = (
                attributes,
                self._indices(body.faces),
                add(bind.reshape(-1, 16).astype(np.float32)),
            )
        return self._of_body[id(body)]

    # -- props ---------------------------------------------------------------------------------

    def add_prop(self, prop: Prop, color: Color) -> None:
        """Add a prop: its mesh, with sharp edges, and its animation."""
        turns = rot.continuous(rot.normalize(prop.quaternion))
        node: dict[str, Any] = {"name": prop.name}
        node["translation"] = _numbers(prop.position[0])
        node["rotation"] = _numbers(turns[0])
        weights = None
        if len(prop.faces):
            moving = None if prop.dent is None else moving_surface(prop.dent)
            if moving is None:
                vertices, faces, normals = creased(prop.vertices, prop.faces, CREASE)
            else:
                vertices, faces = moving.vertices, moving.faces
                normals = vertex_normals(vertices, faces)
            primitive = {
                "attributes": {
                    "POSITION": self.buffer.add(vertices.astype(np.float32), VERTICES, bounds=True),
                    "NORMAL": self.buffer.add(normals.astype(np.float32), VERTICES),
                },
                "indices": self._indices(faces),
                "material": self._material(prop.name, color, both_sides=True),
            }
            mesh: dict[str, Any] = {"name": prop.name, "primitives": [primitive]}
            if moving is not None:
                weights = self._add_dents(moving, primitive, mesh)
            self.meshes.append(mesh)
            node["mesh"] = len(self.meshes) - 1
        index = self._node(node, parent=0)
        if weights is not None:
            self._animate(index, "weights", weights)
        if prop.moves:
            self._animate(index, "translation", prop.position)
            self._animate(index, "rotation", turns)

    def _add_dents(
        self, moving: MovingSurface, primitive: dict[str, Any], mesh: dict[str, Any]
    ) -> Array | None:
        """Add the shapes of a dent to a mesh; returns their weights (T, k), None: it has none."""
        offsets, normals, weights = dent_shapes(moving)
        if not len(offsets):
            return None
        primitive["targets"] = [
            {
                "POSITION": self.buffer.add(offset.astype(np.float32), VERTICES, bounds=True),
                "NORMAL": self.buffer.add(turned.astype(np.float32), VERTICES),
            }
            for offset, turned in zip(offsets, normals, strict=True)
        ]
        mesh["weights"] = weights[0].astype(np.float32).tolist()
        return weights

    # -- shared parts --------------------------------------------------------------------------

    def _node(self, node: dict[str, Any], parent: int | None = None) -> int:
        self.nodes.append(node)
        if parent is not None:
            self.nodes[parent]["children"].append(len(self.nodes) - 1)
        return len(self.nodes) - 1

    def _indices(self, faces: NDArray[np.integer]) -> int:
        # glTF reserves the largest index of a type.
        small = faces.max() < np.iinfo(np.uint16).max
        return self.buffer.add(faces.ravel().astype(np.uint16 if small else np.uint32), INDICES)

    def _material(self, name: str, color: Color, both_sides: bool = False) -> int:
        material: dict[str, Any] = {
            "name": name,
            "pbrMetallicRoughness": {
                "baseColorFactor": [*linear(color), 1.0],
                "metallicFactor": 0.0,
                "roughnessFactor": 0.8,
            },
        }
        if both_sides:
            material["doubleSided"] = True
        self.materials.append(material)
        return len(self.materials) - 1

    def _animate(self, node: int, path: str, values: Array) -> None:
        self._animate_all([node], path, values[None])

    def _animate_all(self, nodes: range | list[int], path: str, values: Array) -> None:
        """Add channels of nodes (n) with values (n, T, k); constant ones are left out."""
        if path == "rotation":
            values = values[..., [1, 2, 3, 0]]
        single = values.astype(np.float32)
        changing = [k for k in range(len(single)) if (single[k] != single[k, :1]).any()]
        if not changing:
            if path == "translation" and self._still is None:
                self._still = nodes[0], single[0]
            return
        self._add_channels([nodes[k] for k in changing], path, single[changing])

    def _add_channels(self, nodes: list[int], path: str, values: Floats) -> None:
        if self._time is None:
            self._time = self.buffer.add(self.times, bounds=True)
        arrays = [own.ravel() if path == "weights" else own for own in values]
        for node, accessor in zip(nodes, self.buffer.add_all(arrays), strict=True):
            self.channels.append(
                {"sampler": len(self.samplers), "target": {"node": node, "path": path}}
            )
            self.samplers.append({"input": self._time, "output": accessor})


def influences(weights: Array) -> list[tuple[NDArray[np.uint8], Floats]]:
    """Skinning joints (V, 4) of each vertex and their weights, in sets of four, largest first.

    Programs with only four joints per vertex (JOINTS_0) read the four largest.
    """
    used = int(np.count_nonzero(weights, axis=1).max())
    count = 4 if used <= 4 else MOST_INFLUENCES
    order = np.argsort(-weights, axis=1, kind="stable")[:, :count]
    values = np.take_along_axis(weights, order, axis=1)
    values /= values.sum(axis=1, keepdims=True)
    order = np.where(values > 0.0, order, 0)
    return [
        (order[:, k : k + 4].astype(np.uint8), values[:, k : k + 4].astype(np.float32))
        for k in range(0, count, 4)
    ]


def _numbers(values: Array) -> list[float]:
    """Numbers in single precision, as in the buffer; quaternions (4,) as x, y, z, w."""
    if values.shape == (4,):
        values = values[[1, 2, 3, 0]]
    return [float(v) for v in values.astype(np.float32)]
