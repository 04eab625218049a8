"""Shapes of one hand at work: bent fingers, and the thumb in the plane of the palm."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfphysics.motion.motion import Motion
from halfphysics.motion.skeleton import JOINT_INDEX

if TYPE_CHECKING:
    from halfphysics.body.body import Body

Array = NDArray[np.float64]

_FINGERS = ("index", "middle", "pinky", "ring")


def thumb_aside(body: Body, side: str) -> Array:
    """Axis-angle (3,) of the thumb's first joint that puts the thumb into the palm's plane.

    At rest the thumb is in front of the palm, and makes first contact when a flat hand pushes.
    """
    joints = np.asarray(body.rest_joints)
    first, last = (joints[JOINT_INDEX[f"{side}_thumb{k}"]] for k in (1, 3))
    rest = (last - first) / np.linalg.norm(last - first)
    flat = rest * np.array([1.0, 0.0, 1.0])  # y is up from the palm at rest
    axis = np.cross(rest, flat)
    out: Array = axis * (np.arctan2(np.linalg.norm(axis), rest @ flat) / np.linalg.norm(axis))
    return out


def _chain(body: Body, side: str) -> tuple[Array, Array]:
    """Wrist and joints of the middle finger (4, 3); skin of its end, from the last joint."""
    joints = np.asarray(body.rest_joints)
    chain = joints[[JOINT_INDEX[f"{side}_{n}"] for n in ("wrist", "middle1", "middle2", "middle3")]]
    own = body.main_joint == JOINT_INDEX[f"{side}_middle3"]
    return chain, np.asarray(body.rest_vertices)[own] - chain[3]


def _on_bone(
    body: Body, side: str, curls: ArrayLike, bone: int, ahead: float, toward: float
) -> Array:
    """A point at a bone (0 to 2) of the middle finger, from the wrist, as `pad`.

    The point is `ahead` of the bone's joint, and `toward` its inner side [m].
    """
    chain, _ = _chain(body, side)
    turned = np.cumsum(np.radians(curls), axis=-1)
    out = np.zeros((len(turned), 2))
    out[:, 0] = np.linalg.norm(chain[1] - chain[0])
    lengths = (*np.linalg.norm(np.diff(chain[1:], axis=0), axis=1)[:bone], ahead)
    for length, angle in zip(lengths, turned.T[: bone + 1], strict=True):
        out += length * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    last = turned[:, bone]
    return out + toward * np.stack([-np.sin(last), np.cos(last)], axis=-1)


def pad(body: Body, side: str, curls: ArrayLike) -> Array:
    """The middle finger's pad from the wrist: along the flat hand, and along the palm's normal.

    Args:
        body: The person's body.
        side: "left" or "right".
        curls: Flexion of the finger's three joints [degrees], (T, 3).

    Returns:
        (T, 2) [m].
    """
    skin = _chain(body, side)[1]
    return _on_bone(body, side, curls, 2, 0.5 * np.abs(skin[:, 0]).max(), -float(skin[:, 1].min()))


def hook(body: Body, side: str, curls: ArrayLike) -> Array:
    """The inner side of the middle finger's second bone, near its end, (T, 2) as `pad`."""
    chain, skin = _chain(body, side)
    long = float(np.linalg.norm(chain[3] - chain[2]))
    return _on_bone(body, side, curls, 1, 0.8 * long, -float(skin[:, 1].min()))


def tip(body: Body, side: str, curls: ArrayLike) -> tuple[Array, float]:
    """A ball in the middle finger's tip: centre (T, 2) as `pad`, and radius [m]."""
    skin = _chain(body, side)[1]
    low, high = float(skin[:, 1].min()), float(skin[:, 1].max())
    radius = 0.5 * (high - low)
    ahead = float(np.abs(skin[:, 0]).max()) - radius
    return _on_bone(body, side, curls, 2, ahead, -0.5 * (low + high)), radius


def shaped(
    body: Body,
    motion: Motion,
    side: str,
    share: ArrayLike,
    *,
    curls: ArrayLike = (0.0, 0.0, 0.0),
    thumb: bool = True,
) -> Motion:
    """A motion with the fingers of one hand bent by `curls`.

    Args:
        body: The person's body.
        motion: T frames.
        side: "left" or "right".
        share: Weight of `curls` at each frame, 0 (as in `motion`) to 1, (T,) or a number.
        curls: Flexion of the three joints of every finger [degrees], (T, 3) or (3,).
        thumb: Whether to apply `thumb_aside`; else the thumb is unchanged.
    """
    sign = -1.0 if side == "left" else 1.0
    flexed = np.broadcast_to(np.radians(curls), (len(motion), 3))
    share = np.broadcast_to(share, (len(motion),))
    rotations = np.array(motion.rotations)
    for finger in _FINGERS:
        for k in range(3):
            joint = JOINT_INDEX[f"{side}_{finger}{k + 1}"]
            goal = np.zeros((len(motion), 3))
            goal[:, 2] = sign * flexed[:, k]
            rotations[:, joint] += share[:, None] * (goal - rotations[:, joint])
    if thumb:
        joint = JOINT_INDEX[f"{side}_thumb1"]
        way = thumb_aside(body, side) - rotations[:, joint]
        rotations[:, joint] += share[:, None] * way
    return motion.with_frames(motion.translation, rotations)
