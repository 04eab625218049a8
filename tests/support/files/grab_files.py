"""A GRAB clip, made up: body, hands, object and table, as the data set lies on a disk."""

from __future__ import annotations

import copy
from pathlib import Path

import numpy as np

from halfphysics.motion.skeleton import BODY_JOINTS, LEFT_HAND_JOINTS, RIGHT_HAND_JOINTS
from support.files.layouts import movement
from support.files.model_files import VERTICES
from support.files.model_files import fields as model_fields

FRAMES, COMPONENTS = 12, 24


def rotations() -> tuple[np.ndarray, np.ndarray]:
    """Translation and the 55 rotations that the file means, fingers on a flat hand."""
    translation, r = movement(FRAMES, up="z")
    for joints, fingers in zip((LEFT_HAND_JOINTS, RIGHT_HAND_JOINTS), unfolded(), strict=True):
        r[:, list(joints)] = fingers.reshape(FRAMES, 15, 3)
    return translation, r


def coefficients() -> list[np.ndarray]:
    return [np.random.default_rng(i).normal(0, 0.1, (FRAMES, COMPONENTS)) for i in (5, 6)]


def unfolded() -> list[np.ndarray]:
    """Mean hand and the first components of the synthetic model, by the smplx package's rule."""
    model = model_fields("smplx")
    return [
        model[f"hands_mean{side}"] + c @ model[f"hands_components{side}"][:COMPONENTS]
        for side, c in zip("lr", coefficients(), strict=True)
    ]


def trajectory(seed: int) -> dict[str, np.ndarray]:
    rng = np.random.default_rng(seed)
    t = np.linspace(0.0, 1.0, FRAMES)[:, None]
    return {
        "transl": rng.normal(size=3) + 0.3 * t * rng.normal(size=3),
        "global_orient": rng.normal(size=3) + t * rng.normal(size=3),
    }


def fields(full: bool = True) -> dict:
    """The layout of the data set's files."""
    translation, r = rotations()
    left, right = coefficients()
    params = {
        "transl": translation,
        "global_orient": r[:, 0],
        "body_pose": r[:, list(BODY_JOINTS)].reshape(FRAMES, 63),
        "jaw_pose": r[:, 22],
        "leye_pose": r[:, 23],
        "reye_pose": r[:, 24],
        "left_hand_pose": left,
        "right_hand_pose": right,
        "expression": np.ones((FRAMES, 10)),
    }
    if full:
        params["fullpose"] = r.reshape(FRAMES, 165)
    hand = {"params": {"hand_pose": left}, "vtemp": "tools/subject_meshes/male/s1_hand.ply"}
    still = trajectory(9)
    return {
        "gender": "male",
        "sbj_id": "s1",
        "obj_name": "cup",
        "motion_intent": "lift",
        "framerate": 120.0,
        "n_frames": FRAMES,
        "n_comps": COMPONENTS,
        "body": {"params": params, "vtemp": "tools/subject_meshes/male/s1.ply"},
        "lhand": copy.deepcopy(hand),
        "rhand": copy.deepcopy(hand),
        "object": {
            "params": trajectory(7),
            "object_mesh": "tools/object_meshes/contact_meshes/cup.ply",
        },
        "table": {
            "params": {key: np.repeat(v[:1], FRAMES, axis=0) for key, v in still.items()},
            "table_mesh": "tools/object_meshes/contact_meshes/table.ply",
        },
        "contact": {
            "body": np.zeros((FRAMES, 20), np.int8),
            "object": np.zeros((FRAMES, 30), np.int8),
        },
    }


def written(root: Path, content: dict) -> Path:
    """The clip at its place in the data set's folder."""
    path = root / "GRAB" / "grab" / "s1" / "cup_lift.npz"
    path.parent.mkdir(parents=True, exist_ok=True)
    np.savez(path, **content)
    return path


def template() -> np.ndarray:
    """A template other than the model's own."""
    own = np.random.default_rng(11).uniform(-0.7, 0.7, (VERTICES, 3))
    return own.astype(np.float32).astype(np.float64)
