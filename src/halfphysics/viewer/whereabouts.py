"""Where people are in every frame, for the cameras of a page, which has no server to ask."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from halfphysics.motion.skeleton import JOINT_INDEX, LEFT_HAND_JOINTS, RIGHT_HAND_JOINTS
from halfphysics.render.result_meshes import Drawing

Array = NDArray[np.float64]

_HANDS = (
    np.array([JOINT_INDEX["left_wrist"], *LEFT_HAND_JOINTS]),
    np.array([JOINT_INDEX["right_wrist"], *RIGHT_HAND_JOINTS]),
)
#: The camera goes along where people go farther than this [m].
GOES = 1.0


def track(drawings: Sequence[Drawing], offsets: Array, frames: Sequence[int]) -> Array:
    """Boxes around the joints of all people in frames (T, 18) [m], in the world.

    Columns: lowest and highest corner of all joints, mean of the pelvises, unit vector to the left
    of the first person, lowest and highest corner of the hands in contact (of all if none is).

    Args:
        drawings: The results.
        offsets: Where each stands (N, 3) [m].
        frames: The frames; a result that has ended stays at its last one.
    """
    joints, touching = [], []
    for drawing, offset in zip(drawings, offsets, strict=True):
        own = np.minimum(np.asarray(frames), len(drawing) - 1)
        for k, person in enumerate(drawing.result.people):
            joints.append(person.body.joints(person.motion)[own] + offset)
            touching.append(_touching(drawing, k)[own])
    people = np.stack(joints, axis=1)  # (T, people, 55, 3)
    left = people[:, 0, JOINT_INDEX["left_hip"]] - people[:, 0, JOINT_INDEX["right_hip"]]
    left = left / np.maximum(np.linalg.norm(left, axis=1, keepdims=True), 1e-9)
    hands = np.stack([people[:, :, each] for each in _HANDS], axis=2)  # (T, people, 2, 16, 3)
    chosen = np.stack(touching, axis=1)  # (T, people, 2)
    chosen = chosen | ~chosen.any(axis=(1, 2), keepdims=True)
    some = np.broadcast_to(chosen[..., None, None], hands.shape)
    return np.concatenate(
        [
            people.min(axis=(1, 2)),
            people.max(axis=(1, 2)),
            people[:, :, 0].mean(axis=1),
            left,
            np.where(some, hands, np.inf).min(axis=(1, 2, 3)),
            np.where(some, hands, -np.inf).max(axis=(1, 2, 3)),
        ],
        axis=1,
    )


def starts(drawings: Sequence[Drawing], offsets: Array) -> Array:
    """Pelvises of all people in the first frame (people, 3) [m], in the world."""
    return np.concatenate(
        [
            [person.body.joints(person.motion)[0, 0] + offset for person in drawing.result.people]
            for drawing, offset in zip(drawings, offsets, strict=True)
        ]
    )


def goes_far(boxes: Array) -> bool:
    """Whether people of `track` go, part or meet so far that a camera should go along."""
    return bool(np.ptp(boxes[:, [0, 1, 3, 4]], axis=0).max() > GOES)


def _touching(drawing: Drawing, person: int) -> NDArray[np.bool_]:
    """Whether the left and the right hand of a person touch anything, by frame (T, 2)."""
    contacts = drawing.result.contacts
    touching = np.zeros((len(drawing), 2), dtype=bool)
    mine = np.asarray(contacts.person) == person
    frame, part = np.asarray(contacts.frame)[mine], np.asarray(contacts.part)[mine]
    for side, hand in enumerate(_HANDS):
        touching[frame[np.isin(part, hand)], side] = True
    return touching
