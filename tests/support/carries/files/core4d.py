"""Recordings as files of CORE4D: y-up, 15 fps, joints of two people; the second stands aside."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np

from halfphysics.base.axes import AXES
from halfphysics.motion.skeleton import BODY_JOINTS, JOINT_INDEX, JOINT_NAMES, N_JOINTS
from support.carries.files.written import SINGLE, Written, in_axes, poses
from support.carries.recordings import Recording

#: Where the second person stands, from where the first one does at first [m].
ASIDE = np.array([-0.3, 2.6, 0.0])
JOINTS = 127
#: Fingers in the order of their tips in `joints`, from this row on; the left hand's first.
FINGERS, FIRST_TIP = ("thumb", "index", "middle", "ring", "pinky"), 66


def tips_of(body) -> dict[int, int]:
    """Row of `joints` -> the vertex that is the tip of a finger."""
    own = np.argmax(body.weights, axis=1)
    out = {}
    for k, (side, finger) in enumerate((s, f) for s in ("left", "right") for f in FINGERS):
        joint = JOINT_INDEX[f"{side}_{finger}3"]
        rows = np.flatnonzero(own == joint)
        bone = body.rest_joints[joint] - body.rest_joints[joint - 1]
        out[FIRST_TIP + k] = int(rows[np.argmax(body.rest_vertices[rows] @ bone)])
    return out


def person(made: Recording) -> dict:
    """The fields of one person; other landmarks of the skin than the tips are at the head."""
    translation, rotations = in_axes(made, AXES["y"])
    frames = len(translation)
    joints = np.empty((frames, JOINTS, 3))
    joints[:, :N_JOINTS] = made.body.joints(made.motion)
    joints[:, N_JOINTS:] = joints[:, JOINT_NAMES.index("head"), None]
    tips = tips_of(made.body)
    joints[:, list(tips)] = made.body.vertices(made.motion, indices=list(tips.values()))
    single = {
        "betas": np.zeros((frames, 10)),
        "expression": np.zeros((frames, 10)),
        "global_orient": rotations[:, 0],
        "transl": translation,
        "body_pose": rotations[:, list(BODY_JOINTS)],
        "left_hand_pose": np.zeros((frames, 12)),
        "right_hand_pose": np.zeros((frames, 12)),
        "joints": joints @ AXES["y"],
    }
    return {key: value.astype(np.float32) for key, value in single.items()}


def bystander(made: Recording) -> Recording:
    """Who stands aside all the time, as the carrier stands at first."""
    frames = len(made.motion)
    translation = np.repeat(made.motion.translation[:1] + ASIDE, frames, axis=0)
    rotations = np.repeat(made.motion.rotations[:1], frames, axis=0)
    return replace(made, motion=made.motion.with_frames(translation, rotations))


def write(made: Recording, folder: Path) -> Written:
    """`CORE4D_Real/human_object_motions/20231002/004/` and `object_models/` below `folder`."""
    name, root = made.case.thing, folder / "CORE4D_Real"
    path = root / "human_object_motions" / "20231002" / "004"
    meshes = root / "object_models" / name
    for each in (path, meshes):
        each.mkdir(parents=True, exist_ok=True)
    for number, each in enumerate((made, bystander(made)), start=1):
        np.savez(path / f"person{number}_poses.npz", np.array(person(each), dtype=object))
    made.thing.mesh.export(meshes / f"{name}_m.obj", digits=16)
    position, matrix = poses(made, np.zeros(3))
    pose = np.tile(np.eye(4), (len(position), 1, 1))
    pose[:, :3, :3], pose[:, :3, 3] = AXES["y"].T @ matrix, position @ AXES["y"]
    np.save(path / "smooth_objposes.npy", pose)
    (path / "object_metadata.json").write_text(json.dumps({"obj_name": name.capitalize()}))
    return Written(path, np.zeros(3), SINGLE)
