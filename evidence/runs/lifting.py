"""Measures of a suitcase lifted between two flat palms: rise, slip, bent fingers."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from evidence.runs import playing
from halfphysics.base import rotations as rot
from halfphysics.motion.skeleton import JOINT_INDEX, LEFT_HAND_JOINTS, RIGHT_HAND_JOINTS
from halfphysics.scenarios.stories.lift_suitcase import UP

if TYPE_CHECKING:
    from halfphysics.results.result import Result

#: Centre of the palm, from the wrist joint along the hand at rest [m].
PALM = 0.054
_SIDES = (("left", 1.0), ("right", -1.0))


def palms(result: Result) -> NDArray[np.float64]:
    """Both palms (T, 2, 3) in the suitcase's own frame [m]."""
    positions, quaternions = result.people[0].body.joint_frames(result.motion)
    track = result.objects["suitcase"]
    found = []
    for side, left in _SIDES:
        wrist = JOINT_INDEX[f"{side}_wrist"]
        palm = positions[:, wrist] + rot.rotate(quaternions[:, wrist], [left * PALM, 0.0, 0.0])
        found.append(rot.rotate(rot.conjugate(track.quaternion), palm - track.position))
    return np.stack(found, axis=1)


def slip(result: Result) -> float:
    """Slip of the palms over the sides of the suitcase, from the lift to the end [m]."""
    at = palms(result)[round(UP * result.fps) : -1]
    # Tangential to the sides; in the normal direction, pressure moves a palm.
    return float(np.linalg.norm((at - at[0])[..., [0, 2]], axis=-1).max())


def judged(result: Result, *, quick: bool) -> dict[str, float | None]:
    """Measures of the suitcase, in mm, degrees and seconds.

    `rise` and `hands`: of the suitcase and of the wrists by the end of the lift; `kept`: the
    lowest it is afterwards; `held_until`: the last touch of the person, None without any;
    `fingers`: the most that a joint of a hand is turned; `rate`, `deepest`: of the skin in it.
    """
    track, body = result.objects["suitcase"], result.people[0].body
    up = round(UP * result.fps)
    height = 1e3 * (track.position[:, 2] - track.position[0, 2])
    wrists = 1e3 * body.joints(result.motion)[:, [20, 21], 2].mean(axis=1)
    contacts = result.contacts
    touched = contacts.frame[
        (contacts.other == result.names.index("suitcase")) & (contacts.person == 0)
    ]
    turned = playing.joint_angles(result.reference, result.motion)
    inside = playing.penetration(result, quick=quick)
    return {
        "rise": float(height[up]),
        "hands": float(wrists[up] - wrists[0]),
        "highest": float(height.max()),
        "kept": float(height[up:-1].min()),
        "slip": 1e3 * slip(result),
        "moved": float(1e3 * np.abs(track.position - track.position[0]).max()),
        "held_until": float(touched.max() / result.fps) if len(touched) else None,
        "fingers": float(turned[:, [*LEFT_HAND_JOINTS, *RIGHT_HAND_JOINTS]].max()),
        "rate": inside.rate_percent,
        "deepest": inside.depth_max_mm,
        "into_suitcase": float(inside.by_name["suitcase"].max()),
    }
