"""The body in 14 segments of skin, each closed: their volumes in a pose, and which are neighbours.

A segment is a head, a trunk, an upper arm, a hand, ... : the faces whose vertices belong mostly to
its joints. Where it is cut from the next one, each rim is closed by a fan about the mean of its
vertices.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache, cached_property
from types import MappingProxyType
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from halfphysics.geometry.mesh_queries import boundary_edges, components
from halfphysics.metrics.argument_checks import Array
from halfphysics.motion.skeleton import JOINT_NAMES, PARENTS

Whole = NDArray[np.intp]

#: Segment -> beginnings of the names of its joints.
SEGMENTS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "trunk": ("pelvis", "spine", "left_collar", "right_collar"),
        "head": ("neck", "head", "jaw", "left_eye", "right_eye"),
        **{
            f"{side}_{name}": tuple(f"{side}_{joint}" for joint in joints)
            for side in ("left", "right")
            for name, joints in (
                ("upper_arm", ("shoulder",)),
                ("forearm", ("elbow",)),
                ("hand", ("wrist", "thumb", "index", "middle", "ring", "pinky")),
                ("thigh", ("hip",)),
                ("shank", ("knee",)),
                ("foot", ("ankle", "foot")),
            )
        },
    }
)
NAMES = tuple(SEGMENTS)
_CHUNK = 512  # triangles at a time: a cache full


@dataclass(frozen=True, eq=False)
class Segments:
    """The segments of a skin of V vertices, G = 14.

    Attributes:
        faces: Of each segment its closed triangles (n, 3): indices of the V vertices, and beyond
            them of the `rims`.
        rims: Vertices of each rim, whose mean is an additional vertex V, V + 1, ...
        of_vertex: Segment of every vertex (V,).
        of_face: Segment of every face of the skin (F,).
    """

    faces: tuple[Whole, ...]
    rims: tuple[Whole, ...]
    of_vertex: Whole
    of_face: Whole

    def closed(self, vertices: Array) -> Array:
        """Vertices (..., V + R, 3) [m] of the closed segments, of the skin's (..., V, 3)."""
        middles = [vertices[..., rim, :].mean(axis=-2, keepdims=True) for rim in self.rims]
        whole: Array = np.concatenate([vertices, *middles], axis=-2)
        return whole

    @cached_property
    def alone(self) -> tuple[tuple[Whole, NDArray[np.int32]], ...]:
        """Of each segment the vertices that it uses (m,), and its triangles among these (n, 3)."""
        found = []
        for faces in self.faces:
            used, local = np.unique(faces, return_inverse=True)
            found.append((used, local.reshape(-1, 3).astype(np.int32)))
        return tuple(found)

    @cached_property
    def vertices_of(self) -> tuple[Whole, ...]:
        """The vertices (n,) that belong to each segment."""
        return tuple(np.flatnonzero(self.of_vertex == k) for k in range(len(self.faces)))

    def rows(self, vertices: Array) -> Array:
        """The closed segments of skins (t, V, 3) [m] as rows (V + R, 3, t): frames come last, so
        that triangles are gathered in whole rows."""
        count = vertices.shape[1]
        rows = np.empty((count + len(self.rims), 3, len(vertices)))
        rows[:count] = vertices.transpose(1, 2, 0)
        for k, rim in enumerate(self.rims):
            rows[count + k] = rows[rim].mean(axis=0)
        return rows

    def volumes(self, rows: Array) -> Array:
        """Volume (G, t) [m^3] of every segment of `rows` (V + R, 3, t) [m].

        A sixth of the sum of a . (b x c) over its closed triangles. The origin should be near.
        """
        found = np.zeros((len(self.faces), rows.shape[2]))
        for k, faces in enumerate(self.faces):
            for first in range(0, len(faces), _CHUNK):
                some = faces[first : first + _CHUNK]
                a, b, c = (rows[some[:, j]] for j in range(3))
                normal = np.empty_like(b)
                for x in range(3):
                    y, z = (x + 1) % 3, (x + 2) % 3
                    np.multiply(b[:, y], c[:, z], out=normal[:, x])
                    normal[:, x] -= b[:, z] * c[:, y]
                normal *= a
                found[k] += normal.reshape(-1, rows.shape[2]).sum(axis=0)
        return found / 6.0


_known: WeakKeyDictionary[Any, Segments] = WeakKeyDictionary()


def segments(body: Any) -> Segments:
    """The segments of a body's skin, made once for each body."""
    found = _known.get(body)
    if found is None:
        found = _known[body] = _cut(np.asarray(body.faces), np.asarray(body.weights))
    return found


@cache
def segment_of_joint() -> Whole:
    """Segment of every joint (55,)."""
    return np.array(
        [
            next(k for k, starts in enumerate(SEGMENTS.values()) if name.startswith(starts))
            for name in JOINT_NAMES
        ],
        dtype=np.intp,
    )


@cache
def neighbours() -> NDArray[np.bool_]:
    """Whether two segments (G, G) hang together at a joint, or are the same."""
    of = segment_of_joint()
    found: NDArray[np.bool_] = np.eye(len(NAMES), dtype=bool)
    for joint, parent in enumerate(PARENTS):
        if parent >= 0:
            found[of[joint], of[parent]] = found[of[parent], of[joint]] = True
    return found


def _cut(faces: NDArray[Any], weights: Array) -> Segments:
    of_vertex = segment_of_joint()[weights.argmax(axis=1)]
    corners = of_vertex[faces]
    # Two corners of one segment decide; of three different ones the first.
    of_face = np.where(corners[:, 1] == corners[:, 2], corners[:, 1], corners[:, 0])
    count = len(weights)
    closed: list[Whole] = []
    rims: list[Whole] = []
    for k in range(len(NAMES)):
        own = faces[of_face == k].astype(np.int32)
        edges = boundary_edges(own, count) if len(own) else np.zeros((0, 2), dtype=np.int64)
        fans = [own.astype(np.intp)]
        if len(edges):
            label = components(count, edges)[edges[:, 0]]
            for rim in np.unique(label):
                its = edges[label == rim]
                apex = np.full(len(its), count + len(rims))
                fans.append(np.stack([its[:, 1], its[:, 0], apex], axis=1).astype(np.intp))
                rims.append(np.unique(its).astype(np.intp))
        closed.append(np.concatenate(fans))
    return Segments(tuple(closed), tuple(rims), of_vertex, of_face)
