"""Penetration: how much of a skin is inside a scene, and how deep."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from halfphysics.base import progress as bars
from halfphysics.base import rotations, validation
from halfphysics.base.short_repr import short_repr
from halfphysics.base.validation import number, shown
from halfphysics.errors import InputError
from halfphysics.geometry.mesh_queries import MeshQuery, is_closed
from halfphysics.metrics.argument_checks import Array, check_motion
from halfphysics.metrics.scene_solids import Solid, links_of, solids_of, tracks_of
from halfphysics.metrics.skins import batches, frames_of, skin
from halfphysics.metrics.solid_boxes import distance_bound
from halfphysics.scene.scene import Scene

#: Solids as near as this to a box of points are looked at [m]: more than what rounding makes.
ROUNDING = 1e-6


@dataclass(frozen=True, kw_only=True, eq=False)
class PenetrationReport:
    """Penetration of a motion's skin into a scene.

    A vertex is inside if the winding number of a mesh is over 0.5 (see
    `halfphysics.geometry.mesh_queries`) or if it is inside a primitive. Its depth is the distance
    to that shape's surface, the larger one inside several shapes.

    Attributes:
        rate_percent: Mean over frames of the share of vertices inside [%].
        depth_mean_mm: Mean over frames of the deepest vertex (0 in a clear frame) [mm].
        depth_max_mm: Deepest vertex of the sequence [mm].
        depth_penetrating_mm: Mean depth over all vertices that are inside, 0 if none [mm].
        share: Share of vertices inside in every frame (T,) [%].
        deepest: Deepest vertex of every frame (T,) [mm].
        by_name: Deepest vertex of every frame in each item, name -> (T,) [mm].
        vertices_inside: Number of vertices inside, summed over the frames.
    """

    rate_percent: float
    depth_mean_mm: float
    depth_max_mm: float
    depth_penetrating_mm: float
    share: Array
    deepest: Array
    by_name: Mapping[str, Array]
    vertices_inside: int = 0

    __repr__ = short_repr


def penetration(
    motion: Any,
    body: Any,
    scene: Scene,
    *,
    objects: Mapping[str, Any] | None = None,
    people: Mapping[str, tuple[Any, Any]] | None = None,
    threads: int = 1,
    progress: bool = False,
) -> PenetrationReport:
    """Penetration of the skin into the scene's statics, and into objects and people that are given.

    Args:
        motion: T frames, or a single pose.
        body: The body whose skin is measured; every vertex counts.
        scene: Its statics, except those of `scene.ignore(name, "person")`. An object that collides
            by convex pieces is measured by the mesh that they replace.
        objects: Tracks of objects (name -> `.position (T, 3)`, `.quaternion (T, 4)`), as in
            `result.objects`; objects without a track are left out.
        people: Other people at the same frames, name -> (motion, body): their skins count as
            items of these names.
        threads: Threads to use; the numbers do not depend on it.
        progress: Show a progress bar.

    Raises:
        InputError: An argument of a wrong type; tracks of unknown objects or of another length;
            people with names of items or with another number of frames.
    """
    check_motion("motion", motion, pose=True)
    validation.body(body, "vertices")
    if not isinstance(scene, Scene):
        raise InputError(f"scene: expected a halfphysics.Scene, found {shown(scene)}")
    if int(number(threads, "threads", least=1)) != threads:
        raise InputError(f"threads: expected a whole number, found {threads:g}")
    frames = frames_of(motion)
    solids = solids_of(scene, tracks_of(scene, objects or {}, frames))
    others = _others(scene, people or {}, frames)
    share, deepest = np.zeros(frames), np.zeros(frames)
    by_name = {n: np.zeros(frames) for n in (*solids, *others)}
    total, count = 0.0, 0
    with bars.asked(progress):
        parts = batches(frames, "penetration")
    for part in parts:
        vertices = skin(motion, body, part)
        columns = [vertices[..., k] for k in range(3)]  # short rows take three times as long
        box = tuple(np.stack([f(c, axis=1) for c in columns], axis=1) for f in (np.min, np.max))
        depth = np.zeros(vertices.shape[:2])
        for name, its in solids.items():
            own = _depth(its, vertices, box, part, int(threads))
            by_name[name][part] = 1000.0 * own.max(axis=1)
            np.maximum(depth, own, out=depth)
        for name, (their, shaped) in others.items():
            own = _skin_depth(vertices, skin(their, shaped, part), shaped.faces, int(threads))
            by_name[name][part] = 1000.0 * own.max(axis=1)
            np.maximum(depth, own, out=depth)
        inside = depth > 0.0
        share[part] = 100.0 * inside.mean(axis=1)
        deepest[part] = 1000.0 * depth.max(axis=1)
        total += float(depth.sum())
        count += int(inside.sum())
    for array in (share, deepest, *by_name.values()):
        array.setflags(write=False)
    return PenetrationReport(
        rate_percent=float(share.mean()),
        depth_mean_mm=float(deepest.mean()),
        depth_max_mm=float(deepest.max()),
        depth_penetrating_mm=1000.0 * total / count if count else 0.0,
        share=share,
        deepest=deepest,
        by_name=by_name,
        vertices_inside=count,
    )


def _skin_depth(points: Array, skin: Array, faces: Any, threads: int) -> Array:
    """Depths (T, V) of points (T, V, 3) in a skin (T, W, 3) that differs from frame to frame."""
    depth = np.zeros(points.shape[:2])
    closed = is_closed(np.asarray(faces), skin.shape[1])
    for own, mine, its in zip(depth, points, skin, strict=True):
        # Points beyond the skin's box are outside: no tree is built for frames without others.
        near = ((mine >= its.min(axis=0)) & (mine <= its.max(axis=0))).all(axis=1)
        if near.any():
            own[near] = MeshQuery(its, faces, closed=closed).depth(mine[near], threads=threads)
    return depth


def _others(scene: Scene, people: Any, frames: int) -> dict[str, tuple[Any, Any]]:
    """Other people, checked."""
    if not isinstance(people, Mapping):
        raise InputError(f"people: expected names and pairs (motion, body), found {shown(people)}")
    for name, pair in people.items():
        what = f"people[{name!r}]"
        if name in (*scene.statics, *scene.objects, *links_of(scene)):
            raise InputError(f"{what}: the scene has a thing of this name; expected another")
        if not isinstance(pair, tuple | list) or len(pair) != 2:
            raise InputError(f"{what}: expected a pair (motion, body), found {shown(pair)}")
        check_motion(what, pair[0], pose=True)
        validation.body(pair[1], "vertices")
        found = frames_of(pair[0])
        if found != frames:
            raise InputError(f"{what}: expected {frames} frames as of motion, found {found}")
    return dict(people)


def _depth(
    solids: list[Solid], points: Array, box: tuple[Array, ...], part: slice, threads: int
) -> Array:
    """Depths (t, V) of points (t, V, 3) of the frames `part`, in the deepest of some solids.

    `box`: lowest and highest corners (t, 3) of the points of a frame. Where that is beside a solid
    nothing is inside.
    """
    deepest = np.zeros(points.shape[:2])
    middle, half = 0.5 * (box[0] + box[1])[:, None], 0.5 * (box[1] - box[0])[:, None]
    for shape, *pose in solids:
        position, quaternion = (x if len(x) == 1 else x[part] for x in pose)
        turn = rotations.to_matrix(quaternion)
        near = distance_bound(shape, position, turn, middle, half)[:, 0] < ROUNDING
        if not near.any():
            continue
        if len(position) > 1:
            position, turn = position[near], turn[near]
        # Row vectors: the transpose turns back.
        local = (points[near] - position[:, None]) @ turn
        own = shape.depth(local.reshape(-1, 3), threads=threads).reshape(local.shape[:2])
        deepest[near] = np.maximum(deepest[near], own)
    return deepest
