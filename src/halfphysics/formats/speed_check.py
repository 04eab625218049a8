"""Checks for impossible speeds: wrong units or frame rates, cuts, swapped markers."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.reader_warnings import warn
from halfphysics.motion.motion import Motion
from halfphysics.motion.skeleton import JOINT_NAMES, PARENTS

Array = NDArray[np.float64]

#: Highest speed of a person [m/s]: a sprinter.
ROOT_SPEED = 12.0
#: Highest speed of a joint [m/s]: a sprinter's foot in its forward swing, most throws and kicks.
JOINT_SPEED = 20.0

#: The number of joints checked: fingers, jaw and eyes follow hand and head.
_JOINTS = 22
# Largest distance of each joint from the farthest of these joints, for any person [m].
_REACH = np.zeros(_JOINTS)
_REACH[[0, 1, 2, 3, 4, 5, 6, 7, 8, 9]] = 1.3, 1.2, 1.2, 1.3, 0.7, 0.7, 1.2, 0.3, 0.3, 1.1
_REACH[[12, 13, 14, 16, 17, 18, 19]] = 0.3, 0.9, 0.9, 0.8, 0.8, 0.4, 0.4
#: Joints that are straight in any rest pose: knees, spine, neck, head, elbows. Turns below this
#: count as none [rad].
_STIFF = [3, 4, 5, 6, 9, 12, 15, 18, 19]
_REST = 0.3
#: Joints that are as one another's mirror image: arms at any height, and legs that are apart, as in
#: CMU's skeleton, by at most this [rad].
_ARMS, _LEGS = ((16, 17),), ((1, 2), (7, 8))
_APART = 0.6
# Number of frames computed at once: bounds the memory.
_CHUNK = 8192


def warn_of_speed(where: str, motion: Motion, start: int = 0) -> None:
    """Warn of a root or a joint that moves faster than a person can.

    Args:
        where: Name of the file or clip in messages.
        motion: What was read.
        start: The number in the file of its first frame.
    """
    step = np.linalg.norm(np.diff(motion.translation, axis=0), axis=1) * motion.fps
    fastest = int(np.argmax(step))
    if step[fastest] > ROOT_SPEED:
        _warn(where, "the root", step[fastest], fastest, motion, ROOT_SPEED, start)
        return
    suspects = np.flatnonzero(_bounds(motion, step) > JOINT_SPEED)
    speed, frame, joint = max(
        (_fastest(motion, suspects[i : i + _CHUNK]) for i in range(0, len(suspects), _CHUNK)),
        default=(0.0, 0, 0),
    )
    if speed > JOINT_SPEED:
        _warn(where, JOINT_NAMES[joint], speed, frame, motion, JOINT_SPEED, start)


def is_rest_pose(rotations: Array) -> bool:
    """Whether a person (55, 3) is at rest, as in a T-pose: exporters put it before the clip."""
    # The mirror image of a turn (x, y, z) is (x, -y, -z).
    even = all(
        np.abs(rotations[left] - rotations[right] * [1.0, -1.0, -1.0]).max() < _REST
        for left, right in _ARMS + _LEGS
    )
    turns = np.linalg.norm(rotations, axis=1)
    legs = turns[[joint for pair in _LEGS for joint in pair]]
    return even and bool(turns[_STIFF].max() < _REST and legs.max() < _APART)


def rest_pose_first(start: int) -> str:
    """What to say of a clip that jumps from `is_rest_pose`, its frame `start` in the file."""
    return (
        f"Frame {start} is a rest pose (a T-pose) that was put before the clip: leave it out with "
        f"frames=({start + 1}, None)"
    )


def _warn(
    where: str, what: str, speed: float, frame: int, motion: Motion, limit: float, start: int
) -> None:
    said = (
        f"{where}: {what} moves at {speed:.3g} m/s between frames {frame} and {frame + 1}, "
        f"expected under {limit:g}. "
    )
    if frame == 0 and is_rest_pose(motion.rotations[0]):
        warn(said + rest_pose_first(start))
        return
    warn(
        f"{said}Is the frame rate right ({motion.fps:g}; fps= says another)? Where the clip is cut "
        "or damaged there, read what is before or after it with frames="
    )


def _bounds(motion: Motion, root: Array) -> Array:
    """An upper bound (T - 1,) [m/s] on the speed of all joints between consecutive frames.

    The angle of a rotation is at most the difference of its axis-angle vectors, and moves no joint
    faster than its rate times the reach; the bounds add up along the tree.
    """
    turns = np.diff(motion.rotations[:, :_JOINTS], axis=0)
    rates = np.sqrt(np.einsum("tji,tji->tj", turns, turns)) * motion.fps
    chains = np.eye(_JOINTS)
    for joint in range(1, _JOINTS):
        chains[joint] += chains[PARENTS[joint]]
    result: Array = root + ((rates * _REACH) @ chains.T).max(axis=1)
    return result


def _fastest(motion: Motion, frames: NDArray[np.intp]) -> tuple[float, int, int]:
    """The fastest joint from one of these frames to the next: speed [m/s], frame, joint."""
    from halfphysics.body.body import Body
    from halfphysics.body.skinning import kinematics

    rest = Body.default().rest_joints
    both = np.concatenate([frames, frames + 1])
    # The rest position of the pelvis is constant, so it cancels in the differences.
    places, _ = kinematics(motion.rotations[both], motion.translation[both], rest)
    before, after = places[: len(frames), :_JOINTS], places[len(frames) :, :_JOINTS]
    speeds = np.linalg.norm(after - before, axis=2) * motion.fps
    row, joint = np.unravel_index(int(np.argmax(speeds)), speeds.shape)
    return float(speeds[row, joint]), int(frames[row]), int(joint)
