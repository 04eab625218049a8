"""The release of TRUMANS, made up: a folder of arrays."""

from __future__ import annotations

import numpy as np

from halfphysics.base import rotations as rot
from halfphysics.motion.skeleton import BODY_JOINTS
from support.files.layouts import movement

CLIPS = {"walk@1": 12, "sit@2": 7, "walk@1 again": 30, "one": 2}


def release(folder, objects=True):
    """The folder with all clips, each the same movement moved by its index along x."""
    folder.mkdir()
    total = sum(CLIPS.values())
    arrays = {
        "human_pose": np.zeros((total, 63)),
        "human_orient": np.zeros((total, 3)),
        "human_transl": np.zeros((total, 3)),
        "seg_name": np.repeat(np.array(list(CLIPS)), list(CLIPS.values())),
        "scene_list": np.array(["kitchen.npy", "hall.npy"]),
        "scene_flag": np.ones(total, np.int64),
        "object_list": np.array(["chair.npy", "cup.npy"]),
        "object_flag": np.full((total, 2), -1),
        "object_mat": np.tile(np.eye(4), (total, 5, 1, 1)),
    }
    start = 0
    for index, frames in enumerate(CLIPS.values()):
        translation, r = movement(frames, up="y")
        rows = slice(start, start + frames)
        arrays["human_pose"][rows] = r[:, list(BODY_JOINTS)].reshape(frames, 63)
        arrays["human_orient"][rows] = r[:, 0]
        arrays["human_transl"][rows] = translation + np.array([index, 0, 0])
        start += frames
    arrays["object_flag"][:12, 1] = 3  # the cup, in the first clip, by the fourth matrix
    turn = rot.to_matrix(rot.exp(np.linspace(0, 1, 12)[:, None] * [0.3, 1.0, -0.2]))
    arrays["object_mat"][:12, 3, :3, :3] = np.swapaxes(turn, 1, 2)  # vertices are rows: v @ M
    arrays["object_mat"][:12, 3, :3, 3] = np.linspace(0, 1, 12)[:, None] * [1.0, 0.5, 0.2]
    arrays["object_mat"][:12, 3, 0, 3] += 3.0  # away from the person
    if not objects:
        for key in ("object_list", "object_flag", "object_mat", "scene_list", "scene_flag"):
            del arrays[key]
    for key, value in arrays.items():
        single = value.astype(np.float32) if value.dtype == np.float64 else value
        np.save(folder / f"{key}.npy", single)
    return folder
