"""BVH files made from first principles, and an independent reader of them, used as references.

The layout: joints as nested blocks with OFFSET and CHANNELS, then `MOTION`, `Frames: T`, `Frame
Time: s` and a row of numbers per frame. A joint turns by the product of its channels' rotations in
the order they are listed; position channels replace the offset.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.base.axes import AXES
from halfphysics.motion.skeleton import JOINT_INDEX, JOINT_NAMES, PARENTS

_MIXAMO = {
    "pelvis": "Hips",
    "spine1": "Spine",
    "spine2": "Spine1",
    "spine3": "Spine2",
    "neck": "Neck",
    "head": "Head",
    **{
        f"{side}_{ours}": f"{side.capitalize()}{theirs}"
        for side in ("left", "right")
        for ours, theirs in (
            ("hip", "UpLeg"),
            ("knee", "Leg"),
            ("ankle", "Foot"),
            ("foot", "ToeBase"),
            ("collar", "Shoulder"),
            ("shoulder", "Arm"),
            ("elbow", "ForeArm"),
            ("wrist", "Hand"),
            *(
                (f"{finger}{k}", f"Hand{finger.capitalize()}{k}")
                for finger in ("thumb", "index", "middle", "ring", "pinky")
                for k in (1, 2, 3)
            ),
        )
    },
}
#: SMPL-X joint -> its name in Mixamo files; they have no jaw and no eyes.
MIXAMO = {JOINT_INDEX[ours]: theirs for ours, theirs in _MIXAMO.items()}


def text_of(
    names: Sequence[str],
    parents: Sequence[int],
    offsets: np.ndarray,
    local: np.ndarray,
    root: np.ndarray,
    *,
    order: str | Sequence[str] = "ZXY",
    frame_time: str = "0.0333333",
    places: bool = False,
    tips: np.ndarray | None = None,
) -> str:
    """A file of joints with local quaternions (T, J, 4) and root places (T, 3).

    `order` may differ from joint to joint; `places`: position channels on every joint; `tips`
    (J, 3): the End Sites of leaf joints.
    """
    tips = 0.5 * offsets if tips is None else tips
    orders = [order] * len(names) if isinstance(order, str) else list(order)
    lines, columns = ["HIERARCHY"], []

    def block(joint: int, depth: int) -> None:
        pad = "\t" * depth
        lines.append(f"{pad}{'ROOT' if depth == 0 else 'JOINT'} {names[joint]}")
        lines.append(f"{pad}{{")
        lines.append(f"{pad}\tOFFSET " + " ".join(f"{v:.12f}" for v in offsets[joint]))
        channels = [f"{axis}rotation" for axis in orders[joint]]
        turns = Rotation.from_quat(local[:, joint, [1, 2, 3, 0]])
        angles = turns.as_euler(orders[joint].upper(), degrees=True)
        if depth == 0 or places:
            channels = ["Xposition", "Yposition", "Zposition", *channels]
            place = root if depth == 0 else np.tile(offsets[joint], (len(local), 1))
            columns.append(place)
        columns.append(angles)
        lines.append(f"{pad}\tCHANNELS {len(channels)} {' '.join(channels)}")
        children = [c for c, parent in enumerate(parents) if parent == joint]
        for child in children:
            block(child, depth + 1)
        if not children:
            lines.append(f"{pad}\tEnd Site\n{pad}\t{{")
            lines.append(
                f"{pad}\t\tOFFSET " + " ".join(f"{v:.12f}" for v in tips[joint]) + f"\n{pad}\t}}"
            )
        lines.append(f"{pad}}}")

    block(0, 0)
    rows = np.concatenate(columns, axis=1)
    lines += ["MOTION", f"Frames: {len(rows)}", f"Frame Time: {frame_time}"]
    lines += [" ".join(f"{v:.12f}" for v in row) for row in rows]
    return "\n".join(lines) + "\n"


def retold(
    motion: hp.Motion,
    body: hp.Body,
    *,
    names: dict[int, str] = MIXAMO,
    own: np.ndarray | None = None,
    unit: float = 100.0,
    up: str = "y",
    **options,
) -> str:
    """The motion of `body` as another program would write it: other names, frames and units.

    Args:
        motion: In the z-up world.
        body: The body that gives the joints.
        names: SMPL-X joint -> name, of the joints that are in the file.
        own: SMPL-X joint from the file's joint, quaternions (55, 4): frames that are turned
            against SMPL-X's. At the file's zero pose the body is in the pose with world rotations
            `conjugate(own)`.
        unit: Of the file, per metre.
        up: Of the file.
        options: Of `text_of`.
    """
    own = np.tile([1.0, 0.0, 0.0, 0.0], (55, 1)) if own is None else own
    positions, world = body.joint_frames(motion)
    if up == "y":
        turn = rot.from_matrix(AXES["y"].T)
        positions, world = rot.rotate(turn, positions), rot.multiply(turn, world)
    kept = sorted(names)
    theirs = rot.multiply(world, own)
    local, offsets, parents = theirs[:, kept].copy(), np.zeros((len(kept), 3)), [-1] * len(kept)
    for i, joint in enumerate(kept):
        parent = int(PARENTS[joint])
        if parent < 0:
            continue
        parents[i] = kept.index(parent)
        local[:, i] = rot.multiply(rot.conjugate(theirs[:, parent]), theirs[:, joint])
        way = body.rest_joints[joint] - body.rest_joints[parent]
        offsets[i] = unit * rot.rotate(rot.conjugate(own[parent]), way)
    tips = unit * np.array(
        [rot.rotate(rot.conjugate(own[joint]), 0.03 * pointing(joint, body)) for joint in kept]
    )
    return text_of(
        [names[j] for j in kept],
        parents,
        offsets,
        local,
        unit * positions[:, 0],
        tips=tips,
        **options,
    )


def pointing(joint: int, body: hp.Body) -> np.ndarray:
    """The direction of the bone of an SMPL-X joint at rest."""
    name, rest = JOINT_NAMES[joint], body.rest_joints
    if name == "head":
        return np.array([0.0, 1.0, 0.0])
    if name.endswith("foot"):
        return np.array([0.0, 0.0, 1.0])
    children = [c for c in range(55) if PARENTS[c] == joint]
    if name.endswith("wrist"):
        children = [JOINT_INDEX[name.replace("wrist", "middle1")]]
    way = rest[children[0]] - rest[joint] if children else rest[joint] - rest[PARENTS[joint]]
    return way / max(np.linalg.norm(way), 1e-12)


def read_places(path: Path) -> tuple[dict[str, np.ndarray], float]:
    """An independent reader: joint name -> world places (T, 3) in the file's unit, frame time."""
    head, _, tail = path.read_text().partition("MOTION")
    words = head.split()
    count, time, rows = tail.strip().split("\n", 2)
    values = np.array([[float(w) for w in line.split()] for line in rows.strip().split("\n")])
    assert len(values) == int(count.split(":")[1])
    places: dict[str, np.ndarray] = {}
    stack: list[tuple[np.ndarray, Rotation] | None] = []
    name, column, at = "", 0, 0
    place, turn = np.zeros((len(values), 3)), Rotation.identity(len(values))
    while at < len(words):
        word = words[at]
        if word in ("ROOT", "JOINT", "End"):
            name, at = words[at + 1], at + 2
        elif word == "{":
            stack.append((place, turn))
            at += 1
        elif word == "}":
            place, turn = stack.pop()
            at += 1
        elif word == "OFFSET":
            move = np.tile([float(w) for w in words[at + 1 : at + 4]], (len(values), 1))
            at += 4
            if name == "Site":
                place = place + turn.apply(move)
        elif word == "CHANNELS":
            own, channels = turn, words[at + 2 : at + 2 + int(words[at + 1])]
            at += 2 + len(channels)
            for channel in channels:
                if channel.endswith("position"):
                    move[:, "XYZ".index(channel[0])] = values[:, column]
                else:
                    own = own * Rotation.from_euler(
                        channel[0], values[:, column, None], degrees=True
                    )
                column += 1
            place, turn = place + turn.apply(move), own
            places[name] = place
        else:
            at += 1
    assert column == values.shape[1]
    return places, float(time.split(":")[1])


def smplx(places: dict[str, np.ndarray], names: Callable[[str], str] = str) -> np.ndarray:
    """Places of the 55 joints (T, 55, 3)."""
    return np.stack([places[names(name)] for name in JOINT_NAMES], axis=1)
