"""Forearms kept clear of what the hands hold: an arm swivels about the line from shoulder to wrist.

A palm on a large box is where it should be with its forearm inside the box's edge, which then
bears the load instead of the palm. The elbow goes outwards, the hand stays as it is.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.motion.skeleton import PARENTS

if TYPE_CHECKING:
    from halfphysics.adaptation.hands import Hand
    from halfphysics.adaptation.recorded_holds import RecordedHold
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion

Array = NDArray[np.float64]

#: A forearm is so far from what its hand presses on [m], if a swivel can do that.
_CLEAR = 0.008
#: Less than the best that a swivel can do by this [m] is as good.
_NEARLY = 0.001
#: Swivels tried, nearest first [rad], in so many frames of the hold, with every so manieth vertex.
_SWIVELS = np.radians([0.0, 5.0, -5.0, 10.0, -10.0, 15.0, -15.0, 20.0, -20.0, 30.0, -30.0])
_FRAMES, _EVERY = 6, 3


def cleared(motion: Motion, body: Body, hand: Hand, hold: RecordedHold, share: Array) -> Motion:
    """The motion with an arm swivelled by the least that keeps its forearm clear.

    Args:
        motion: The motion whose hand is at its place, T frames.
        body: The person's body.
        hand: Which hand.
        hold: What is held, and when.
        share: How much of the swivel each frame has (T,).
    """
    some = np.unique(np.linspace(hold.first, hold.last, _FRAMES).astype(np.int64))
    part = np.argmax(np.asarray(body.weights), axis=1)
    skin = np.flatnonzero(part == hand.arm[1])[::_EVERY]
    if not len(skin):
        return motion
    gaps: list[float] = []
    for angle in _SWIVELS:
        tried = _swivelled(motion, body, hand, some, np.full(len(some), angle))
        forearm = body.vertices(tried, frames=some, indices=skin)
        local = (forearm - hold.thing.position[some, None]) @ hold.thing.turn[some]
        gaps.append(float(hold.thing.gaps(local).min()))
        if gaps[-1] >= _CLEAR:
            break
    enough = min(_CLEAR, max(gaps) - _NEARLY)
    angle = _SWIVELS[next(k for k, gap in enumerate(gaps) if gap >= enough)]
    if angle == 0.0:
        return motion
    frames = np.flatnonzero(share > 0.0)
    return _swivelled(motion, body, hand, frames, angle * share[frames])


def _swivelled(
    motion: Motion, body: Body, hand: Hand, frames: NDArray[np.int64], angles: Array
) -> Motion:
    """The motion with an arm turned about the line from shoulder to wrist, its hand as it is.

    Args:
        motion, body, hand: Whose arm.
        frames: In which frames (n,).
        angles: By how much there (n,) [rad].
    """
    positions, quaternions = (x[frames] for x in body.joint_frames(motion))
    shoulder, _, wrist = hand.arm
    line = positions[:, wrist] - positions[:, shoulder]
    line /= np.maximum(np.linalg.norm(line, axis=1, keepdims=True), 1e-9)
    swivel = rot.rotvec_to_matrix(angles[:, None] * line)
    collar, upper, lower, end = (
        rot.to_matrix(quaternions[:, j]) for j in (int(PARENTS[shoulder]), *hand.arm)
    )
    rotations = np.array(motion.rotations)
    back = np.swapaxes(collar, 1, 2) @ swivel @ upper
    rotations[frames, shoulder] = rot.matrix_to_rotvec(back)
    back = np.swapaxes(swivel @ lower, 1, 2) @ end
    rotations[frames, wrist] = rot.matrix_to_rotvec(back)
    return motion.with_frames(motion.translation, rotations)
