"""MHR, the body of SAM 3D Body: its joints and keypoints, and where they are in SMPL-X.

- `pred_joint_coords` (127, 3): MHR's joints, "body_world" first (facebookresearch/sam-3d-body,
  issue 34: the names of `get_joint_names()`). A foot has several joints in the ankle, a limb has
  joints that only twist; of the tongue, the teeth and the metacarpals nothing is used. The last
  joint of a finger is its tip.
- `pred_keypoints_3d` (70, 3): MHR70 (sam_3d_body/metadata/mhr70.py), of the skin and of joints.
  Each finger has its tip, then its joints from the tip to the knuckle; the right hand comes first.

MHR's spine has four joints: on it SMPL-X's three are placed, at the parts of the way from pelvis to
neck at which they are at rest. What MHR's spine is like at rest is from its published skeleton: by
it the pelvis is known from hips and spine.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from halfphysics.body.body import Body
from halfphysics.formats.positions.landmarks import SIDES, landmarks
from halfphysics.formats.positions.similarity import carried
from halfphysics.motion.skeleton import JOINT_INDEX

Array = NDArray[np.float64]

N_MHR, N_POINTS = 127, 70
#: Numbers of fingers' tips in an array of joints, as in the `joints` of the smplx package.
_FINGERS = ("thumb", "index", "middle", "ring", "pinky")
_FIRST_TIP = 66
N_PLACES = _FIRST_TIP + 2 * len(_FINGERS)
#: MHR's joints of the left and of the right side: hip, knee, ankle, ball; collar, shoulder, elbow,
#: wrist.
_LIMBS = ("hip", "knee", "ankle", "foot", "collar", "shoulder", "elbow", "wrist")
_LIMB_JOINTS = {"left": (2, 3, 4, 8, 74, 75, 76, 78), "right": (18, 19, 20, 24, 38, 39, 40, 42)}
#: The first used joint of each finger, in the order of `_FINGERS`; two more and the tip follow.
_FINGER_JOINTS = {"left": (97, 92, 88, 84, 80), "right": (61, 56, 52, 48, 44)}
_ROOT, _SPINE, _NECK, _HEAD = 1, (34, 35, 36, 37), 110, 113
#: The way of the spine at rest, from the root to the neck: up and ahead [m].
_CURVE = np.array(
    [
        *([0.0, 0.0, 0.0], [0.0, 0.021, -0.033], [0.0, 0.135, -0.022], [0.0, 0.252, -0.047]),
        *([0.0, 0.444, -0.037], [0.0, 0.518, -0.005]),
    ]
)
#: MHR70's of the left and of the right side.
_POINTS = {
    "left": {"ear": 3, "eye": 1, "heel": 17, "big_toe": 15, "small_toe": 16},
    "right": {"ear": 4, "eye": 2, "heel": 20, "big_toe": 18, "small_toe": 19},
}
_POINT_LIMBS = ("hip", "knee", "ankle", "shoulder", "elbow", "wrist")
_POINT_JOINTS = {"left": (9, 11, 13, 5, 7, 62), "right": (10, 12, 14, 6, 8, 41)}
_POINT_HANDS = {"left": 42, "right": 21}
_NOSE, _POINT_NECK = 0, 69
_SPINES = tuple(JOINT_INDEX[f"spine{k}"] for k in (1, 2, 3))
_TRUNK = (
    JOINT_INDEX["neck"],
    *(JOINT_INDEX[f"{s}_{j}"] for s in SIDES for j in ("hip", "shoulder")),
)


def seen_landmarks(points: Array) -> dict[str, Array]:
    """Those of `landmarks` in MHR70's points (T, 70, 3): (T, 3) each."""
    found = {"nose": points[:, _NOSE]}
    for side in SIDES:
        found |= {f"{side}_{name}": points[:, k] for name, k in _POINTS[side].items()}
    return found


def places_of_joints(joints: Array) -> Array:
    """SMPL-X's joints and tips of fingers (T, 76, 3) in MHR's (T, 127, 3); NaN: it has none."""
    places = np.full((len(joints), N_PLACES, 3), np.nan)
    places[:, 0] = joints[:, _ROOT]
    places[:, JOINT_INDEX["neck"]] = joints[:, _NECK]
    places[:, JOINT_INDEX["head"]] = joints[:, _HEAD]
    way = np.concatenate([joints[:, [_ROOT, *_SPINE]], joints[:, [_NECK]]], axis=1)
    places[:, list(_SPINES)] = _along(way)
    for s, side in enumerate(SIDES):
        for name, joint in zip(_LIMBS, _LIMB_JOINTS[side], strict=True):
            places[:, JOINT_INDEX[f"{side}_{name}"]] = joints[:, joint]
        for f, first in enumerate(_FINGER_JOINTS[side]):
            for k in range(3):
                places[:, JOINT_INDEX[f"{side}_{_FINGERS[f]}{k + 1}"]] = joints[:, first + k]
            places[:, _FIRST_TIP + s * len(_FINGERS) + f] = joints[:, first + 3]
    return places


def places_of_points(points: Array) -> Array:
    """The same of MHR70's points (T, 70, 3): what it lacks is carried along by what is near.

    The trunk by hips, shoulders and neck; the head by the face; the balls of the feet by heels and
    toes.
    """
    places = np.full((len(points), N_PLACES, 3), np.nan)
    places[:, JOINT_INDEX["neck"]] = points[:, _POINT_NECK]
    for s, side in enumerate(SIDES):
        for name, k in zip(_POINT_LIMBS, _POINT_JOINTS[side], strict=True):
            places[:, JOINT_INDEX[f"{side}_{name}"]] = points[:, k]
        for f, finger in enumerate(_FINGERS):
            tip = _POINT_HANDS[side] + 4 * f
            for k in (1, 2, 3):
                places[:, JOINT_INDEX[f"{side}_{finger}{k}"]] = points[:, tip + 4 - k]
            places[:, _FIRST_TIP + s * len(_FINGERS) + f] = points[:, tip]
    rest, seen = np.asarray(Body.default().rest_joints), seen_landmarks(points)
    face = ["nose", *(f"{side}_{name}" for side in SIDES for name in ("ear", "eye"))]
    places[:, JOINT_INDEX["head"]] = _carried(seen, face, rest[JOINT_INDEX["head"]])
    for side in SIDES:
        sole = [f"{side}_{name}" for name in ("heel", "big_toe", "small_toe")]
        ball = JOINT_INDEX[f"{side}_foot"]
        places[:, ball] = _carried(seen, sole, rest[ball])
    _fill_trunk(places, rest)
    return places


def _carried(seen: dict[str, Array], names: list[str], point: Array) -> Array:
    ours = landmarks()
    theirs = np.stack([seen[name] for name in names], axis=1)
    return carried(np.stack([ours[name] for name in names]), theirs, point[None])[:, 0]


def _fill_trunk(places: Array, rest: Array) -> None:
    """Pelvis, spine and collars; a spine that bends has its ends at hips and neck."""
    anchors = list(_TRUNK)
    collars = [JOINT_INDEX[f"{side}_collar"] for side in SIDES]
    missing = [0, *_SPINES, *collars]
    ours = np.concatenate([rest[anchors], rest[missing]])
    all = carried(rest[anchors], places[:, anchors], ours)
    hips = [anchors.index(JOINT_INDEX[f"{side}_hip"]) for side in SIDES]
    off = places[:, anchors] - all[:, : len(anchors)]
    low, high = off[:, hips].mean(axis=1), off[:, 0]  # the first is the neck
    height = (rest[missing, 1] - rest[0, 1]) / (rest[JOINT_INDEX["neck"], 1] - rest[0, 1])
    share = np.clip(height, 0.0, 1.0)[:, None]
    places[:, missing] = (
        all[:, len(anchors) :] + (1.0 - share) * low[:, None] + share * high[:, None]
    )


def _along(way: Array) -> Array:
    """SMPL-X's spine (T, 3, 3) on a line (T, n, 3) from the pelvis to the neck."""
    rest = np.asarray(Body.default().rest_joints)
    own = rest[[0, *_SPINES, JOINT_INDEX["neck"]]]
    steps = np.linalg.norm(np.diff(own, axis=0), axis=1)
    parts = (np.cumsum(steps) / steps.sum())[:-1]
    # At rest, the same parts of MHR's way: between the same two joints in every frame.
    ends = np.cumsum(np.r_[0.0, np.linalg.norm(np.diff(_CURVE, axis=0), axis=1)])
    at = parts * ends[-1]
    after = np.searchsorted(ends, at)
    share = ((at - ends[after - 1]) / (ends[after] - ends[after - 1]))[:, None]
    return np.asarray((1.0 - share) * way[:, after - 1] + share * way[:, after])


def rest_of_mhr() -> Array:
    """Joints (55, 3) [m] like the default body's, but for the spine, which is as MHR's at rest."""
    rest = np.array(Body.default().rest_joints)
    chest, neck = _SPINES[-1], JOINT_INDEX["neck"]
    size = (rest[neck, 1] - rest[0, 1]) / _CURVE[-1, 1]
    moved = rest[0] + size * _along(_CURVE[None])[0]
    rest[neck:] += moved[-1] - rest[chest]  # in SMPL-X's order all from the neck on is above
    rest[list(_SPINES)] = moved
    return rest
