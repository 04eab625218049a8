"""Files of the SOMA skeleton in their exact layouts: Kimodo's npz and BVH, GEM-X's torch file.

The skeleton as documented (nv-tlabs/kimodo kimodo/skeleton/definitions.py), written out here once
more: names in the order of the files, and parents by name.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

import halfphysics as hp
from halfphysics.motion.skeleton import JOINT_INDEX
from support.files.dumps import torch_dict

_NAMES = """
Hips Spine1 Spine2 Chest Neck1 Neck2 Head HeadEnd Jaw LeftEye RightEye
LeftShoulder LeftArm LeftForeArm LeftHand
LeftHandThumb1 LeftHandThumb2 LeftHandThumb3 LeftHandThumbEnd
LeftHandIndex1 LeftHandIndex2 LeftHandIndex3 LeftHandIndex4 LeftHandIndexEnd
LeftHandMiddle1 LeftHandMiddle2 LeftHandMiddle3 LeftHandMiddle4 LeftHandMiddleEnd
LeftHandRing1 LeftHandRing2 LeftHandRing3 LeftHandRing4 LeftHandRingEnd
LeftHandPinky1 LeftHandPinky2 LeftHandPinky3 LeftHandPinky4 LeftHandPinkyEnd
RightShoulder RightArm RightForeArm RightHand
RightHandThumb1 RightHandThumb2 RightHandThumb3 RightHandThumbEnd
RightHandIndex1 RightHandIndex2 RightHandIndex3 RightHandIndex4 RightHandIndexEnd
RightHandMiddle1 RightHandMiddle2 RightHandMiddle3 RightHandMiddle4 RightHandMiddleEnd
RightHandRing1 RightHandRing2 RightHandRing3 RightHandRing4 RightHandRingEnd
RightHandPinky1 RightHandPinky2 RightHandPinky3 RightHandPinky4 RightHandPinkyEnd
LeftLeg LeftShin LeftFoot LeftToeBase LeftToeEnd
RightLeg RightShin RightFoot RightToeBase RightToeEnd
"""
NAMES = _NAMES.split()
#: Index of each joint's parent.
PARENTS = [
    *(-1, 0, 1, 2, 3, 4, 5, 6, 6, 6, 6),
    *(3, 11, 12, 13, 14, 15, 16, 17, 14, 19, 20, 21, 22, 14, 24, 25, 26, 27),
    *(14, 29, 30, 31, 32, 14, 34, 35, 36, 37),
    *(3, 39, 40, 41, 42, 43, 44, 45, 42, 47, 48, 49, 50, 42, 52, 53, 54, 55),
    *(42, 57, 58, 59, 60, 42, 62, 63, 64, 65),
    *(0, 67, 68, 69, 70, 0, 72, 73, 74, 75),
]
#: The older skeleton of 30 joints: its joints among the 77, and their parents.
THIRTY = [*range(7), 8, 9, 10, *range(11, 15), 18, 28, *range(39, 43), 46, 56]
THIRTY += [67, 68, 69, 70, 72, 73, 74, 75]
THIRTY_PARENTS = [-1, 0, 1, 2, 3, 4, 5, 6, 6, 6, 3, 10, 11, 12, 13, 13]
THIRTY_PARENTS += [3, 16, 17, 18, 19, 19, 0, 22, 23, 24, 0, 26, 27, 28]

#: SOMA joint -> the SMPL-X joint in its place; others are rigid to their parents.
SAME = {"Hips": "pelvis", "Spine1": "spine1", "Spine2": "spine2", "Chest": "spine3"}
SAME |= {"Neck1": "neck", "Head": "head", "Jaw": "jaw"}
for _side in ("Left", "Right"):
    _ours = _side.lower()
    SAME |= {f"{_side}Shoulder": f"{_ours}_collar", f"{_side}Arm": f"{_ours}_shoulder"}
    SAME |= {f"{_side}ForeArm": f"{_ours}_elbow", f"{_side}Hand": f"{_ours}_wrist"}
    SAME |= {f"{_side}Leg": f"{_ours}_hip", f"{_side}Shin": f"{_ours}_knee"}
    SAME |= {f"{_side}Foot": f"{_ours}_ankle", f"{_side}ToeBase": f"{_ours}_foot"}
    SAME |= {f"{_side}HandThumb{k}": f"{_ours}_thumb{k}" for k in (1, 2, 3)}
    for _finger in ("Index", "Middle", "Ring", "Pinky"):
        for _k in (1, 2, 3):
            SAME[f"{_side}Hand{_finger}{_k + 1}"] = f"{_ours}_{_finger.lower()}{_k}"


@dataclass(frozen=True, eq=False)
class Clip:
    """A SOMA skeleton in motion, y up: bones (77, 3) [m], hips (T, 3), local rotations
    (T, 77, 3, 3)."""

    offsets: np.ndarray
    hips: np.ndarray
    local: np.ndarray

    def world(self) -> np.ndarray:
        world = self.local.copy()
        for joint, parent in enumerate(PARENTS):
            if parent >= 0:
                world[:, joint] = world[:, parent] @ world[:, joint]
        return world

    def places(self) -> np.ndarray:
        world, places = self.world(), np.zeros((len(self.hips), 77, 3))
        places[:, 0] = self.hips
        for joint, parent in enumerate(PARENTS[1:], 1):
            places[:, joint] = places[:, parent] + world[:, parent] @ self.offsets[joint]
        return places


def of_default_body(translation: np.ndarray, rotations: np.ndarray) -> Clip:
    """The default body's skeleton in the joints of SOMA, moved as SMPL-X parameters say (y up)."""
    rest = np.asarray(hp.Body.default().rest_joints)
    places = np.full((77, 3), np.nan)
    local = np.tile(np.eye(3), (len(rotations), 77, 1, 1))
    for joint, name in enumerate(NAMES):
        if name in SAME:
            own = JOINT_INDEX[SAME[name]]
            places[joint] = rest[own]
            turns = Rotation.from_rotvec(np.array(rotations[:, own])).as_matrix()
            local[:, joint] = turns
    for joint, name in enumerate(NAMES):
        if name in SAME:
            continue
        base, side = places[PARENTS[joint]], -1.0 if name.startswith("Right") else 1.0
        if name == "Neck2":
            step = 0.5 * (rest[JOINT_INDEX["head"]] - base)
        elif "Hand" in name and name.endswith("1"):
            step = 0.4 * (places[joint + 1] - base)
        elif "Hand" in name:  # the end goes on where the last bone came
            step = 0.8 * (base - places[PARENTS[PARENTS[joint]]])
        else:
            step = {"ToeEnd": [0.0, 0.0, 0.06], "HeadEnd": [0.0, 0.15, 0.0]}.get(
                name.removeprefix("Left").removeprefix("Right"), [0.03 * side, 0.05, 0.08]
            )
        places[joint] = base + step
    offsets = places - places[np.maximum(PARENTS, 0)]
    return Clip(offsets, translation + rest[0], local)


def kimodo(path: Path, clip: Clip, joints: list[int] | None = None) -> Path:
    np.savez(path, **kimodo_fields(clip, joints))
    return path


def kimodo_fields(clip: Clip, joints: list[int] | None = None) -> dict[str, np.ndarray]:
    """Kimodo's npz in single precision; of the 77 joints those that are kept."""
    kept = list(range(77)) if joints is None else joints
    world, count = clip.world()[:, kept], len(clip.hips)
    above = [kept.index(_first_kept(PARENTS[joint], kept)) if joint else -1 for joint in kept]
    local = world.copy()
    local[:, 1:] = np.swapaxes(world[:, above[1:]], -1, -2) @ world[:, 1:]
    fields = {
        "posed_joints": clip.places()[:, kept],
        "global_rot_mats": world,
        "local_rot_mats": local,
        "foot_contacts": np.ones((count, 6 if len(kept) == 77 else 4)),
        "smooth_root_pos": clip.hips,
        "root_positions": clip.hips,
        "global_root_heading": np.tile([1.0, 0.0], (count, 1)),
    }
    return {key: value.astype(np.float32) for key, value in fields.items()}


def _first_kept(joint: int, kept: list[int]) -> int:
    while joint not in kept:
        joint = PARENTS[joint]
    return joint


def kimodo_bvh(path: Path, clip: Clip, fps: float = 30.0) -> Path:
    """As Kimodo writes BVH with its standard T-pose: a Root above the hips, channels Z Y X,
    centimetres, no End Sites."""
    turns = Rotation.from_matrix(clip.local.reshape(-1, 3, 3)).as_euler("ZYX", degrees=True)
    turns = turns.reshape(len(clip.hips), 77, 3)
    lines, columns = ["HIERARCHY", "ROOT Root", "{", "  OFFSET 0 0 0"], [np.zeros((len(turns), 6))]
    moving = "Xposition Yposition Zposition Zrotation Yrotation Xrotation"
    lines.append(f"  CHANNELS 6 {moving}")

    def block(joint: int) -> None:
        offset = 100.0 * clip.offsets[joint] if joint else np.array([0.0, 100.0, 0.0])
        lines.extend([f"JOINT {NAMES[joint]}", "{"])
        lines.append("  OFFSET " + " ".join(f"{value:.6f}" for value in offset))
        if joint == 0:
            columns.append(100.0 * clip.hips)
        lines.append("  CHANNELS " + (f"6 {moving}" if joint == 0 else f"3 {moving[30:]}"))
        columns.append(turns[:, joint])
        for child, parent in enumerate(PARENTS):
            if parent == joint:
                block(child)
        lines.append("}")

    block(0)
    rows = np.concatenate(columns, axis=1)
    lines += ["}", "MOTION", f"Frames: {len(rows)}", f"Frame Time: {1.0 / fps}"]
    lines += [" ".join(f"{value:.6f}" for value in row) for row in rows]
    path.write_text("\n".join(lines) + "\n")
    return path


def gemx_data(clip: Clip) -> dict:
    """GEM-X's predictions: the clip in the world, and in a camera at the origin with y down."""
    count = len(clip.hips)
    pose = Rotation.from_matrix(clip.local.reshape(-1, 3, 3)).as_rotvec().reshape(count, 77, 3)
    down = Rotation.from_rotvec([np.pi, 0.0, 0.0])
    shared = {
        "body_pose": pose[:, 1:].reshape(count, 228),
        "identity_coeffs": np.zeros((count, 45)),
        "scale_params": np.zeros((count, 69)),
    }
    incam = (down * Rotation.from_rotvec(pose[:, 0])).as_rotvec()
    data = {
        "body_params_global": {**shared, "global_orient": pose[:, 0], "transl": clip.hips},
        "body_params_incam": {**shared, "global_orient": incam, "transl": down.apply(clip.hips)},
    }
    out = {
        key: {name: np.ascontiguousarray(value, np.float32) for name, value in fields.items()}
        for key, fields in data.items()
    }
    return {**out, "K_fullimg": np.tile(np.eye(3, dtype=np.float32), (count, 1, 1))}


def gemx(path: Path, clip: Clip) -> Path:
    return torch_dict(path, gemx_data(clip))
