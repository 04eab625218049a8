"""The default body's rest pose: how the 163 bones turn from the source's A-pose to a T-pose.

Part of `bake_body.py`. All directions are of the left side in the rest frame (y up, z forward, x to
the body's left); the right side is the mirror image.
"""

from __future__ import annotations

import numpy as np

MIRROR = np.array([-1.0, 1.0, 1.0])
ARM = np.array([1.0, 0.0, 0.0])
LEG = np.array([0.0, -1.0, 0.0])
CLAVICLE_RAISE = 10.0  # degrees: the shoulder girdle's share in raising an arm by 45
TWIST_BONES = ("upperarm02", "lowerarm02", "upperleg02", "lowerleg02")
#: Left hand, degrees: yaw of straight fingers from the arm's axis towards the thumb side (+z) ...
FINGER_YAW = {"index": 5.0, "middle": 0.0, "ring": -5.0, "pinky": -10.0}
#: ... and (yaw, pitch; down is negative) of the three thumb bones.
THUMB = ((60.0, -30.0), (45.0, -20.0), (40.0, -20.0))
#: MakeHuman numbers its fingers.
FINGERS = {"thumb": 1, "index": 2, "middle": 3, "ring": 4, "pinky": 5}


def unit(v: np.ndarray) -> np.ndarray:
    return v / np.linalg.norm(v)


def rotation(axis: np.ndarray, angle: float) -> np.ndarray:
    """Rotation matrix (3, 3) about `axis` by `angle` [rad]."""
    x, y, z = unit(axis)
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


def swing(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The smallest rotation that takes direction a to direction b."""
    axis = np.cross(a, b)
    s = np.linalg.norm(axis)
    return np.eye(3) if s < 1e-12 else rotation(axis, np.arctan2(s, a @ b))


def frame(along: np.ndarray, side: np.ndarray) -> np.ndarray:
    """Orthonormal columns: `along`, the part of `side` across it, their cross product."""
    x = unit(along)
    y = unit(side - (side @ x) * x)
    return np.stack([x, y, np.cross(x, y)], axis=1)


def twist(R: np.ndarray, axis: np.ndarray) -> float:
    """Angle [rad] that R turns about `axis`, of the swing-twist decomposition."""
    return 2 * np.arctan2(
        axis @ np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]),
        1 + np.trace(R),
    )


def direction(yaw: float, pitch: float) -> np.ndarray:
    """Unit vector of the left hand from degrees towards +z and degrees up."""
    y, p = np.radians([yaw, pitch])
    return np.array([np.cos(y) * np.cos(p), np.sin(p), np.sin(y) * np.cos(p)])


def left_rotations(at: dict[str, np.ndarray], tip: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """World rotations of the left side's bones that take the A-pose to the T-pose.

    `at`, `tip`: heads and tails of the left bones, names without ".L". Bones not in the answer
    turn with their parent.
    """
    R: dict[str, np.ndarray] = {}
    # Arm: the elbow's hinge (upper arm x forearm) becomes vertical, so that it bends forwards.
    upper, fore = at["lowerarm01"] - at["upperarm01"], at["wrist"] - at["lowerarm01"]
    hinge = np.cross(upper, fore)
    R["clavicle"] = rotation(np.array([0.0, 0.0, 1.0]), np.radians(CLAVICLE_RAISE))
    R["upperarm02"] = frame(ARM, -np.array([0.0, 1.0, 0.0])) @ frame(upper, hinge).T
    R["lowerarm01"] = frame(ARM, -np.array([0.0, 1.0, 0.0])) @ frame(fore, hinge).T
    plain = swing(upper, ARM)
    R["upperarm01"] = rotation(ARM, 0.5 * twist(R["upperarm02"] @ plain.T, ARM)) @ plain
    # Hand: knuckle of the middle finger straight ahead of the wrist, knuckles level, palm down.
    ahead, across = at["finger3-1"] - at["wrist"], at["finger2-1"] - at["finger5-1"]
    R["wrist"] = frame(ARM, np.array([0.0, 0.0, 1.0])) @ frame(ahead, across).T
    R["lowerarm02"] = (
        rotation(ARM, 0.5 * twist(R["wrist"] @ R["lowerarm01"].T, ARM)) @ R["lowerarm01"]
    )
    for finger, n in FINGERS.items():
        previous = R["wrist"]
        for k in (1, 2, 3):
            bone = f"finger{n}-{k}"
            target = direction(*(THUMB[k - 1] if finger == "thumb" else (FINGER_YAW[finger], 0.0)))
            previous = R[bone] = swing(previous @ (tip[bone] - at[bone]), target) @ previous
    # Leg: the knee's hinge (thigh x shank) becomes the x axis, so that it bends backwards.
    thigh, shank = at["lowerleg01"] - at["upperleg01"], at["foot"] - at["lowerleg01"]
    hinge = np.cross(thigh, shank)
    R["upperleg02"] = frame(LEG, np.array([1.0, 0.0, 0.0])) @ frame(thigh, hinge).T
    R["lowerleg01"] = frame(LEG, np.array([1.0, 0.0, 0.0])) @ frame(shank, hinge).T
    plain = swing(thigh, LEG)
    R["upperleg01"] = rotation(LEG, 0.5 * twist(R["upperleg02"] @ plain.T, LEG)) @ plain
    # Foot: stays flat on the ground, and is turned about the vertical to point forwards.
    toes = np.mean([at[f"toe{t}-1"] for t in range(1, 6)], axis=0) - at["foot"]
    R["foot"] = rotation(np.array([0.0, 1.0, 0.0]), -np.arctan2(toes[0], toes[2]))
    R["lowerleg02"] = (
        rotation(LEG, 0.5 * twist(R["foot"] @ R["lowerleg01"].T, LEG)) @ R["lowerleg01"]
    )
    return R


def pose(
    labels: list[str],
    parents: np.ndarray,
    weights: np.ndarray,
    skin: np.ndarray,
    heads: np.ndarray,
    tails: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Skin (V, 3) and bone heads (B, 3) in T-pose, by linear blend skinning; parents come first."""
    left = {name[:-2]: b for b, name in enumerate(labels) if name.endswith(".L")}
    turned = left_rotations(
        {n: heads[b] for n, b in left.items()}, {n: tails[b] for n, b in left.items()}
    )
    R = np.repeat(np.eye(3)[None], len(heads), axis=0)
    moved = heads.copy()
    for b, (name, parent) in enumerate(zip(labels, parents, strict=True)):
        if parent < 0:
            continue
        R[b] = turned.get(name[:-2], R[parent])
        if name.endswith(".R") and name[:-2] in turned:
            R[b] = MIRROR[:, None] * R[b] * MIRROR
        # A limb's second bone twists about the limb's axis, not about its own head beside it.
        carrier = b if name[:-2] in TWIST_BONES else parent
        moved[b] = moved[parent] + R[carrier] @ (heads[b] - heads[parent])
    turned_skin = np.zeros_like(skin)
    for b in range(len(heads)):
        rows = np.flatnonzero(weights[:, b])
        turned_skin[rows] += weights[rows, b, None] * ((skin[rows] - heads[b]) @ R[b].T + moved[b])
    return turned_skin, moved
