"""Somebody who sits on a stool, and the stool."""

from __future__ import annotations

import numpy as np

import halfphysics as hp
from halfphysics.motion.skeleton import JOINT_INDEX as J

#: Skin of the seat is this high over what it sits on [m].
OVER = 0.002


def seated(height, frames=45):
    """Somebody who sits at a height [m], upright, arms out; and the place under the seat (2,)."""
    body, turns = hp.Body.default(), np.zeros((frames, 55, 3))
    turns[:, 0, 0] = np.pi / 2
    for side in ("left", "right"):
        turns[:, J[f"{side}_hip"], 0], turns[:, J[f"{side}_knee"], 0] = -1.5, 1.5
    turns[:, J["left_shoulder"], 2], turns[:, J["right_shoulder"], 2] = -1.2, 1.2
    turns[:, J["head"], 0] = 0.2 * np.sin(0.1 * np.arange(frames))
    motion = hp.Motion(np.zeros((frames, 3)), turns, 30.0)
    skin = body.vertices(motion, 0)
    seat = skin[np.isin(body.weights.argmax(axis=1), [0, 1, 2])]
    up = np.array([0.0, 0.0, height + OVER - seat[:, 2].min()])
    return motion.with_frames(motion.translation + up, motion.rotations), body.joints(motion)[0, 0]


def room(height, place, *, kind="static"):
    """A floor and a stool of a height [m] at a place."""
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    stool, at = hp.Box((0.4, 0.36, height)), (place[0], place[1], 0.5 * height)
    if kind == "static":
        scene.add_static("stool", stool, position=at)
    else:
        scene.add_object("stool", stool, mass=10.0, position=at)
    return scene
