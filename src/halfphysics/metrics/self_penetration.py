"""Self-penetration: skin of one segment of the body inside another one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base import validation
from halfphysics.base.short_repr import short_repr
from halfphysics.errors import InputError
from halfphysics.geometry.mesh_queries import MeshQuery
from halfphysics.metrics.argument_checks import Array, check_motion
from halfphysics.metrics.segments import NAMES, Segments, neighbours, segments
from halfphysics.metrics.skins import frames_of, skin
from halfphysics.motion.skeleton import JOINT_INDEX

#: Most frames that are looked at; of longer clips as many, evenly spread.
MOST_FRAMES = 20
#: The joint in whose frame a segment's bounding box is taken.
_JOINTS = tuple(
    JOINT_INDEX[name]
    for name in (
        "spine2",
        "head",
        *(
            f"{side}_{joint}"
            for side in ("left", "right")
            for joint in ("shoulder", "elbow", "wrist", "hip", "knee", "ankle")
        ),
    )
)


@dataclass(frozen=True, kw_only=True, eq=False)
class SelfPenetrationReport:
    """Self-penetration of n frames.

    Attributes:
        percent: Mean over frames of the share of all vertices that are inside another segment [%].
        depth_mm: Mean over frames of the deepest of them, 0 in a clear frame [mm].
        max_mm: The deepest of all [mm].
        frames: The frames that were looked at (n,).
    """

    percent: float
    depth_mm: float
    max_mm: float
    frames: NDArray[np.intp]

    __repr__ = short_repr


def self_penetration(
    motion: Any, body: Any, *, most: int | None = MOST_FRAMES
) -> SelfPenetrationReport:
    """How much of the skin is inside another segment of the same body.

    A vertex is inside where the generalised winding number of the other segment, closed at its
    rims, is over 0.5; its depth is the distance to that segment's surface. Segments that hang
    together at a joint are not compared (the skin between them bends), nor are both thighs.

    Source: the winding number test of TUCH (Mueller et al. 2021) by segments, so that folds of
    bent elbows and hips do not count.

    Args:
        motion: T frames, or a single pose.
        body: The person's body.
        most: Most frames to look at, evenly spread; None: all.

    Raises:
        InputError: No motion, no body, or no whole number of frames.
    """
    check_motion("motion", motion, pose=True)
    validation.body(body, "joint_frames")
    if most is not None and not validation.is_whole(most, least=1, plain=False):
        raise InputError(
            f"most: expected a whole number of at least 1, or None, found {validation.shown(most)}"
        )
    count = frames_of(motion)
    step = count if most is None else min(most, count)
    frames = np.unique(np.linspace(0, count - 1, step).round().astype(np.intp))
    whole, compared = segments(body), _compared()
    turns = rot.to_matrix(body.joint_frames(motion)[1].reshape(-1, 55, 4)[frames][:, _JOINTS])
    share, deepest = np.zeros(len(frames)), np.zeros(len(frames))
    for k, frame in enumerate(frames.tolist()):
        vertices = (
            skin(motion, body, slice(0, 1))[0]
            if np.ndim(motion.rotations) == 2
            else body.vertices(motion, frame)
        )
        depth = depths(vertices, whole, turns[k], compared)
        share[k], deepest[k] = 100.0 * (depth > 0.0).mean(), 1000.0 * depth.max()
    return SelfPenetrationReport(
        percent=float(share.mean()),
        depth_mm=float(deepest.mean()),
        max_mm=float(deepest.max()),
        frames=frames,
    )


def depths(vertices: Array, whole: Segments, turns: Array, compared: NDArray[np.bool_]) -> Array:
    """Depth (V,) [m] of every vertex in the segments that it is compared with, 0 where outside.

    Args:
        vertices: Skin in the world (V, 3) [m].
        whole: Its segments.
        turns: World from segment (G, 3, 3), for bounding boxes along the limbs.
        compared: Whether a segment's vertices are compared with another segment (G, G).
    """
    points, found = whole.closed(vertices), np.zeros(len(vertices))
    boxes = [_box(points[used]) for used, _ in whole.alone]
    for k, (used, faces) in enumerate(whole.alone):
        others = [j for j in np.flatnonzero(compared[:, k]).tolist() if _meet(boxes[j], boxes[k])]
        if not len(faces) or not others:
            continue
        some = np.concatenate([whole.vertices_of[j] for j in others])
        some = some[_within(vertices[some], boxes[k])]
        # The box along the limb is smaller.
        along = _box(points[used] @ turns[k])
        some = some[_within(vertices[some] @ turns[k], along)]
        if len(some):
            query = MeshQuery(points[used], faces, closed=True)
            found[some] = np.maximum(found[some], query.depth(vertices[some]))
    return found


def _box(points: Array) -> tuple[Array, Array]:
    """Corners of the box around points (n, 3), inside out where there is none."""
    if not len(points):
        return np.full(3, np.inf), np.full(3, -np.inf)
    return points.min(axis=0), points.max(axis=0)


def _meet(a: tuple[Array, Array], b: tuple[Array, Array]) -> bool:
    return bool((a[0] <= b[1]).all() and (b[0] <= a[1]).all())


def _within(points: Array, box: tuple[Array, Array]) -> NDArray[np.bool_]:
    inside: NDArray[np.bool_] = np.all((points >= box[0]) & (points <= box[1]), axis=1)
    return inside


def _compared() -> NDArray[np.bool_]:
    """Which segments (G, G) are compared: those at least two joints apart, thighs apart."""
    found = ~neighbours()
    thighs = [NAMES.index("left_thigh"), NAMES.index("right_thigh")]
    found[np.ix_(thighs, thighs)] = False
    return found
