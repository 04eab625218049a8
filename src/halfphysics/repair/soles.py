"""Soles over time: where heels and toes are, how high over what is below, and when they rest.

Whether a foot rests is asked without a known floor: the clips that come here float, sink, drift and
tilt. A patch of a sole rests where it is slow, is not far above the lowest of the person, and the
person is not airborne, nor borne by furniture (bearing.py). Objects are where they start.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_closing, binary_opening, uniform_filter1d

from halfphysics.metrics.airborne import airborne
from halfphysics.metrics.stance import PATCHES, patch_centres, sole_patches
from halfphysics.metrics.surface_gaps import carrying_gaps
from halfphysics.motion.skeleton import JOINT_INDEX
from halfphysics.repair.bearing import borne_elsewhere
from halfphysics.results.object_track import ObjectTrack

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion
    from halfphysics.scene.scene import Scene

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

#: A patch rests below this speed [m/s]. Feet of estimators slide by 0.1 to 0.2; a foot that is
#: lifted or set down is faster.
SLOW = 0.3
#: A patch rests this low above the lowest patch, and above the lowest skin [m].
LOW, NEAR = 0.03, 0.06
#: Positions are averaged over this before speeds are taken [s]: noise of 5 mm at 30 fps moves by
#: 0.2 m/s.
AVERAGED = 0.17
#: A rest is at least so long, and gaps in it at most this [s].
LEAST, GAP = 0.1, 0.07
#: Surfaces farther below or above a sole than this are not those it stands on [m].
REACH = 1.5
#: The joints whose skin is the rear and the front of each foot, in the order of `PATCHES`.
HALVES = ("left_ankle", "left_foot", "right_ankle", "right_foot")
# Every so many vertices tell where the lowest skin is.
_SPARSE = 5


@dataclass(frozen=True, eq=False)
class Soles:
    """Heels and toes of a motion, in the order of `metrics.stance.PATCHES`.

    Attributes:
        centre: Middle of each patch (T, 4, 3) [m].
        lowest: Height of its lowest vertex (T, 4) [m].
        gap: Distance of the rear and of the front of its foot from the surface below (T, 4) [m]:
            negative inside; inf: nothing is below.
        rests: Whether it rests (T, 4).
        fps: Frames per second.
    """

    centre: Array
    lowest: Array
    gap: Array
    rests: Mask
    fps: float

    @classmethod
    def of(cls, motion: Motion, body: Body, scene: Scene) -> Soles:
        """The soles of a motion over a scene."""
        patch = sole_patches(body)
        centre, lowest = patch_centres(motion, body, patch)
        objects = _as_they_start(scene, len(motion))
        feet = _feet(body, patch)
        gap = carrying_gaps(motion, body, scene, feet, objects=objects, reach=REACH).gap
        skin = np.arange(0, len(body.rest_vertices), _SPARSE)
        deepest = body.vertices(motion, indices=skin)[..., 2].min(axis=1)
        width = _odd(AVERAGED * motion.fps)
        smooth = uniform_filter1d(centre, width, axis=0, mode="nearest")
        speed = np.linalg.norm(np.gradient(smooth, axis=0), axis=-1) * motion.fps
        rests = speed < SLOW
        rests &= lowest < lowest.min(axis=1, keepdims=True) + LOW
        rests &= lowest < deepest[:, None] + NEAR
        rests &= ~airborne(motion, body)[:, None]
        rests &= ~borne_elsewhere(motion, body, scene, objects, gap)[:, None]
        rests = _without_flicker(rests, motion.fps)
        return cls(centre, lowest, gap, rests, float(motion.fps))

    def phases(self) -> list[tuple[int, int, int]]:
        """Every rest of a patch: the patch, its first frame, and the frame after its last."""
        found = []
        for patch in range(len(PATCHES)):
            edges = np.diff(np.concatenate([[0], self.rests[:, patch], [0]]).astype(np.int8))
            begins, ends = np.flatnonzero(edges > 0), np.flatnonzero(edges < 0)
            found += [(patch, int(a), int(b)) for a, b in zip(begins, ends, strict=True)]
        return found


def _as_they_start(scene: Scene, frames: int) -> dict[str, ObjectTrack]:
    """Tracks of the objects of a scene, at rest where they start: no more is known of them."""
    return {
        name: ObjectTrack(
            position=np.tile(item.position, (frames, 1)),
            quaternion=np.tile(item.quaternion, (frames, 1)),
        )
        for name, item in scene.objects.items()
    }


def _feet(body: Body, patch: NDArray[np.intp]) -> NDArray[np.intp]:
    """Of every vertex (V,) the patch of its foot's half, or -1: the whole foot, with its edges."""
    part = np.argmax(body.weights, axis=1)
    group = np.full(len(patch), -1)
    for k, name in enumerate(HALVES):
        if (patch == k).any():
            group[part == JOINT_INDEX[name]] = k
    return group


def _odd(frames: float) -> int:
    """The nearest odd number of frames, at least 1."""
    return 2 * round((frames - 1) / 2) + 1 if frames > 1 else 1


def _without_flicker(rests: Mask, fps: float) -> Mask:
    """Rests (T, 4) whose short gaps are closed, and which are not shorter than a rest is."""
    close, least = max(1, round(GAP * fps)), max(1, round(LEAST * fps))
    pad = close + least
    wide = np.pad(rests, ((pad, pad), (0, 0)), mode="edge")
    wide = binary_closing(wide, np.ones((close + 1, 1)))
    wide = binary_opening(wide, np.ones((least, 1)))
    result: Mask = wide[pad:-pad]
    return result
