"""Signed distance of points from a scene, non-collision and contact of PSI, POSA and COINS."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from halfphysics.base import rotations as rot
from halfphysics.geometry.mesh import Mesh
from halfphysics.geometry.shapes import Plane
from halfphysics.metrics.argument_checks import Array, numbers_of
from halfphysics.metrics.scene_solids import Solid, solids_of, tracks_of
from halfphysics.metrics.surface_gaps import signed_distance

if TYPE_CHECKING:
    from halfphysics.scene.scene import Scene


@dataclass(frozen=True, kw_only=True)
class SceneContactReport:
    """The measures of PSI, POSA and COINS over T frames.

    Attributes:
        non_collision_percent: Mean over frames of the share of vertices with a signed distance
            over 0 [%] (PSI, POSA).
        non_collision_coins_percent: The same with a signed distance of 0 or more [%] (COINS).
        contact_percent: Share of frames in which any vertex has a signed distance under 0 [%].
    """

    non_collision_percent: float
    non_collision_coins_percent: float
    contact_percent: float


def scene_contact(distance: ArrayLike) -> SceneContactReport:
    """Non-collision and contact scores of signed distances of the skin.

    Source: PSI (Zhang et al. 2020); POSA (Hassan et al. 2021), mohamedhassanmus/POSA
    src/misc_utils.py, `eval_physical_metric`; COINS (Zhao et al. 2022), zkf1997/COINS
    evaluation/eval_results.py.

    Args:
        distance: Of every vertex in every frame from the scene (T, V) [m], negative inside.
    """
    distance = numbers_of("distance", distance)
    return scores_of(*counts_of(distance))


def counts_of(distance: Array) -> tuple[Array, Array, Array]:
    """Of each frame the share of vertices over 0, of those at 0 or over, and whether any is under:
    (T,) each, from distances (T, V) [m]."""
    return (
        (distance > 0.0).mean(axis=1),
        (distance >= 0.0).mean(axis=1),
        np.any(distance < 0.0, axis=1).astype(np.float64),
    )


def scores_of(over: Array, not_under: Array, touches: Array) -> SceneContactReport:
    """The report of `counts_of` all frames."""
    return SceneContactReport(
        non_collision_percent=float(100.0 * over.mean()),
        non_collision_coins_percent=float(100.0 * not_under.mean()),
        contact_percent=float(100.0 * touches.mean()),
    )


class SceneDistance:
    """Signed distances from a scene's statics, and from objects that have a track.

    Args:
        scene: The scene.
        frames: Number of frames T.
        objects: Name -> track of T poses, as in ``result.objects``.
        planes: Whether planes count (for hands, a floor is no thing).
        what: Name of the argument `objects` in messages.
    """

    def __init__(
        self,
        scene: Scene,
        frames: int,
        objects: Mapping[str, Any] | None = None,
        *,
        planes: bool = True,
        what: str = "objects",
    ) -> None:
        found = solids_of(scene, tracks_of(scene, objects or {}, frames, what))
        self.solids: list[Solid] = [
            solid
            for its in found.values()
            for solid in its
            if planes or not isinstance(solid[0], Plane)
        ]

    def of(self, points: Array, part: slice) -> Array:
        """Distance (t, n) [m] of points (t, n, 3) of the frames `part` from the nearest surface.

        Negative inside anything; inf in an empty scene. Its sign is exact; beyond a mesh's bounding
        box by more than 10 cm it is the distance from the box.
        """
        nearest = np.full(points.shape[:2], np.inf)
        for shape, *pose in self.solids:
            position, turn = (x if len(x) == 1 else x[part] for x in pose)
            local = ((points - position[:, None]) @ rot.to_matrix(turn)).reshape(-1, 3)
            own = _beyond_box(shape, local) if isinstance(shape, Mesh) else None
            if own is None:
                own = signed_distance(shape, local)[0]
            np.minimum(nearest, own.reshape(nearest.shape), out=nearest)
        return nearest


#: Nearer to a mesh's box than this the distance is that from its triangles [m].
_NEAR = 0.1


def _beyond_box(mesh: Mesh, points: Array) -> Array:
    """Signed distances (n,) of points (n, 3) from a mesh, far ones from its box."""
    low, high = mesh.query.bounds
    distance: Array = np.linalg.norm(
        np.maximum(np.maximum(low - points, points - high), 0.0), axis=1
    )
    near = np.flatnonzero(distance < _NEAR)
    distance[near] = signed_distance(mesh, points[near])[0]
    return distance
