"""What SAM 3D Body says of a known person: MHR's joints and keypoints of a made-up skeleton.

The skeleton has MHR's own spine (four joints) and hips, and joints of arms, legs, hands and head
of a person of 1.68 m. It is posed with matrices of scipy, shares nothing with the reader, and is
written as
`process_one_image` gives it: places from the person's origin in the frame of the camera, y down,
and `pred_cam_t` apart.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from halfphysics.motion.skeleton import JOINT_INDEX
from support.files.layouts import movement

#: Name in MHR -> parent, offset at rest [m] (left side; T-pose, y up), SMPL-X joint that turns it.
BONES: dict[str, tuple[str, tuple[float, float, float], str]] = {
    "root": ("", (0.0, 0.0, 0.0), "pelvis"),
    "c_spine0": ("root", (0.0, 0.021, -0.033), ""),
    "c_spine1": ("c_spine0", (0.0, 0.114, 0.011), "spine1"),
    "c_spine2": ("c_spine1", (0.0, 0.117, -0.026), "spine2"),
    "c_spine3": ("c_spine2", (0.0, 0.192, 0.010), "spine3"),
    "c_neck": ("c_spine3", (0.0, 0.074, 0.020), "neck"),
    "c_head": ("c_neck", (0.0, 0.095, 0.02), "head"),
    "l_upleg": ("root", (0.078, -0.018, 0.0), "left_hip"),
    "l_lowleg": ("l_upleg", (0.01, -0.386, 0.0), "left_knee"),
    "l_foot": ("l_lowleg", (0.0, -0.378, -0.02), "left_ankle"),
    "l_ball": ("l_foot", (0.01, -0.058, 0.125), "left_foot"),
    "l_clavicle": ("c_spine3", (0.028, 0.054, 0.03), "left_collar"),
    "l_uparm": ("l_clavicle", (0.145, 0.0, -0.045), "left_shoulder"),
    "l_lowarm": ("l_uparm", (0.265, 0.0, 0.0), "left_elbow"),
    "l_wrist": ("l_lowarm", (0.245, 0.0, 0.0), "left_wrist"),
}
_HANDS = {"thumb": 0.03, "index": 0.026, "middle": 0.001, "ring": -0.018, "pinky": -0.036}
for _f, _z in _HANDS.items():
    _ahead = (0.04, -0.004, _z) if _f == "thumb" else (0.095 + 0.3 * _z, 0.0, _z)
    _step = (0.02, -0.015, 0.025) if _f == "thumb" else (0.028, 0.0, 0.0)
    for _k in (1, 2, 3):
        _parent = "l_wrist" if _k == 1 else f"l_{_f}{_k - 1}"
        BONES[f"l_{_f}{_k}"] = (_parent, _ahead if _k == 1 else _step, f"left_{_f}{_k}")
    BONES[f"l_{_f}_null"] = (f"l_{_f}3", _step, "")
for _name, (_parent, (_x, _y, _z), _joint) in list(BONES.items()):
    if _name.startswith("l_"):
        _other = _parent.replace("l_", "r_", 1) if _parent.startswith("l_") else _parent
        BONES["r_" + _name[2:]] = (_other, (-_x, _y, _z), _joint.replace("left_", "right_"))

#: Names of MHR's joints by number, of those that are used.
MHR = {
    **{"root": 1, "c_spine0": 34, "c_spine1": 35, "c_spine2": 36, "c_spine3": 37},
    **{"c_neck": 110, "c_head": 113},
    **{"l_upleg": 2, "l_lowleg": 3, "l_foot": 4, "l_ball": 8},
    **{"r_upleg": 18, "r_lowleg": 19, "r_foot": 20, "r_ball": 24},
    **{"r_clavicle": 38, "r_uparm": 39, "r_lowarm": 40, "r_wrist": 42},
    **{"l_clavicle": 74, "l_uparm": 75, "l_lowarm": 76, "l_wrist": 78},
    **{
        f"r_{f}{k}": n + k
        for f, n in (("pinky", 43), ("ring", 47), ("middle", 51))
        for k in (1, 2, 3)
    },
    **{f"r_{f}{k}": n + k for f, n in (("index", 55), ("thumb", 60)) for k in (1, 2, 3)},
    **{"r_pinky_null": 47, "r_ring_null": 51, "r_middle_null": 55, "r_index_null": 59},
    **{
        f"l_{f}{k}": n + k
        for f, n in (("pinky", 79), ("ring", 83), ("middle", 87))
        for k in (1, 2, 3)
    },
    **{f"l_{f}{k}": n + k for f, n in (("index", 91), ("thumb", 96)) for k in (1, 2, 3)},
    **{"l_pinky_null": 83, "l_ring_null": 87, "l_middle_null": 91, "l_index_null": 95},
    **{"r_thumb_null": 64, "l_thumb_null": 100},
}
#: MHR70: number -> the joint that carries the point, and its offset at rest [m] (left side).
_SKIN: dict[int, tuple[str, tuple[float, float, float]]] = {
    0: ("c_head", (0.0, 0.004, 0.125)),
    1: ("c_head", (0.031, 0.043, 0.085)),
    3: ("c_head", (0.083, 0.036, -0.008)),
    15: ("l_ball", (-0.015, -0.012, 0.062)),
    16: ("l_ball", (0.025, -0.012, 0.036)),
    17: ("l_foot", (0.006, -0.055, -0.055)),
}
_RIGHT = {2: 1, 4: 3, 18: 15, 19: 16, 20: 17}
_SAME = {
    **{5: "l_uparm", 7: "l_lowarm", 9: "l_upleg", 11: "l_lowleg", 13: "l_foot", 62: "l_wrist"},
    **{6: "r_uparm", 8: "r_lowarm", 10: "r_upleg", 12: "r_lowleg", 14: "r_foot", 41: "r_wrist"},
    69: "c_neck",
}
for _first, _side in ((21, "r"), (42, "l")):
    for _f, _finger in enumerate(("thumb", "index", "middle", "ring", "pinky")):
        _SAME[_first + 4 * _f] = f"{_side}_{_finger}_null"
        for _k in (1, 2, 3):
            _SAME[_first + 4 * _f + _k] = f"{_side}_{_finger}{4 - _k}"
#: From y up to the camera's y down.
DOWN = np.diag([1.0, -1.0, -1.0])


@dataclass(frozen=True, eq=False)
class Known:
    """A person whose pose is known.

    Attributes:
        frames: Numbers (n,) of the frames in which they were seen.
        joints, points: MHR's (n, 127, 3) and MHR70's (n, 70, 3) [m], y up.
        turns: World rotation (n, 3, 3) of the SMPL-X joints by name, y up.
        camera: The place of the person's origin (n, 3) in the frame of the camera [m].
    """

    frames: np.ndarray
    joints: np.ndarray
    points: np.ndarray
    turns: dict[str, np.ndarray]
    camera: np.ndarray

    def place(self, name: str) -> np.ndarray:
        """One of MHR's joints (n, 3) in the world, z up, with the camera at the origin."""
        seen = self.joints[:, MHR[name]] @ DOWN.T + self.camera
        return seen @ np.array([[1.0, 0, 0], [0, 0, 1.0], [0, -1.0, 0]]).T

    def outputs(self, row: int) -> dict[str, object]:
        """The dict of this person in one of their frames, as `process_one_image` gives it."""
        single = np.float32
        x, y = 400.0 * self.camera[row, :2] / self.camera[row, 2] + [640.0, 360.0]
        return {
            "bbox": np.array([x - 100.0, y - 180.0, x + 100.0, y + 180.0], single),
            "focal_length": single(1200.0),
            "pred_keypoints_3d": (self.points[row] @ DOWN.T).astype(single),
            "pred_keypoints_2d": np.zeros((70, 2), single),
            "pred_vertices": np.zeros((6, 3), single),
            "pred_cam_t": self.camera[row].astype(single),
            "pred_pose_raw": np.zeros(266, single),
            "global_rot": np.zeros(3, single),
            "body_pose_params": np.zeros(133, single),
            "hand_pose_params": np.zeros(108, single),
            "scale_params": np.zeros(28, single),
            "shape_params": np.zeros(45, single),
            "expr_params": np.zeros(72, single),
            "mask": None,
            "pred_joint_coords": (self.joints[row] @ DOWN.T).astype(single),
            "pred_global_rots": np.tile(np.eye(3, dtype=single), (127, 1, 1)),
            "mhr_model_params": np.zeros(204, single),
            "lhand_bbox": np.zeros(4),
            "rhand_bbox": np.zeros(4),
        }


def known(frames=range(40), seed: int = 0, place=(0.0, 0.4, 4.0), sizes=None) -> Known:
    """A person who moves all joints through the frames; `sizes` are what the estimator guesses."""
    frames = np.asarray(frames)
    _, rotations = movement(int(frames.max()) + 1, seed=seed, up="y")
    rotations = np.array(rotations)[frames]
    for joint in ("left_foot", "right_foot", "jaw"):
        rotations[:, JOINT_INDEX[joint]] *= [1.0, 0.0, 0.0]
    local = {
        n: Rotation.from_rotvec(rotations[:, JOINT_INDEX[j]]) for n, (_, _, j) in BONES.items() if j
    }
    world: dict[str, np.ndarray] = {}
    places: dict[str, np.ndarray] = {}
    for name, (parent, offset, joint) in BONES.items():
        turn = local[name].as_matrix() if joint else np.tile(np.eye(3), (len(frames), 1, 1))
        world[name] = world[parent] @ turn if parent else turn
        places[name] = (
            (places[parent] + world[parent] @ np.array(offset))
            if parent
            else np.zeros((len(frames), 3))
        )
    size = np.ones(len(frames)) if sizes is None else np.asarray(sizes)
    joints, points = np.zeros((len(frames), 127, 3)), np.zeros((len(frames), 70, 3))
    for name, number in MHR.items():
        joints[:, number] = places[name]
    for number, name in _SAME.items():
        points[:, number] = places[name]
    for number in (*_SKIN, *_RIGHT):
        carrier, offset = _SKIN[_RIGHT.get(number, number)]
        mirrored = np.array(offset) * ([-1.0, 1, 1] if number in _RIGHT else [1.0, 1, 1])
        carrier = carrier.replace("l_", "r_") if number in _RIGHT else carrier
        points[:, number] = places[carrier] + world[carrier] @ mirrored
    camera = np.array(place) + 0.002 * np.arange(len(frames))[:, None] * [1.0, 0.0, 0.5]
    turns = {joint: world[name] for name, (_, _, joint) in BONES.items() if joint}
    scale = size[:, None, None]
    return Known(frames, joints * scale, points * scale, turns, camera * size[:, None])


def video(*people: Known) -> list[list[dict[str, object]]]:
    """The frames of a video: everybody who is seen in each, in an order that changes."""
    last = max(int(who.frames[-1]) for who in people)
    frames = []
    for number in range(last + 1):
        seen = [
            who.outputs(int(np.searchsorted(who.frames, number)))
            for who in people
            if number in who.frames
        ]
        frames.append(seen[::-1] if number % 3 == 1 else seen)
    return frames
