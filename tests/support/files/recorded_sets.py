"""Files of recorded data sets in their exact layouts, from a known motion in the z-up world.

The people are upright, with every joint bent that the layout has. All placing in the files' axes is
by the definition: the pelvis of the free body is at its place at rest plus the file's translation.
"""

from __future__ import annotations

import io
import json
import pickle
import struct
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import trimesh

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.motion.skeleton import SMPL_JOINTS, SMPLH_JOINTS
from support.files.layouts import movement, quiet

FRAMES = 12
BODY = hp.Body.default()
#: World from the axes of files.
Z_UP = np.eye(3)
Y_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
Y_DOWN = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
#: A file in single precision, and one in double [m].
SINGLE, DOUBLE = 1e-5, 1e-9
LEFT, RIGHT = list(range(25, 40)), list(range(40, 55))
BETAS = np.linspace(0.8, -0.8, 10)


def person(seed: int = 0, joints: tuple[int, ...] = tuple(range(55))) -> tuple[Any, Any]:
    """Translation and rotations in the world, of the joints that a layout has."""
    translation, rotations = movement(FRAMES, seed=seed, up="z")
    rotations[:, [j for j in range(55) if j not in joints]] = 0.0
    return translation, rotations


def in_axes(
    someone: tuple[Any, Any], axes: np.ndarray, place: np.ndarray | float = 0.0
) -> tuple[np.ndarray, np.ndarray]:
    """Translation and rotations in a file whose frame stands at `axes`, `place` in the world."""
    translation, rotations = someone
    pelvis, turned = BODY.rest_joints[0], rotations.copy()
    turned[:, 0] = rot.log(rot.multiply(rot.from_matrix(axes.T), rot.exp(rotations[:, 0])))
    return (translation + pelvis - place) @ axes - pelvis, turned


def off(motion: hp.Motion, someone: tuple[Any, Any]) -> float:
    """The largest distance of the skin from where it should be [m]."""
    asked = hp.Motion(*someone, motion.fps)
    return float(np.abs(BODY.vertices(motion) - BODY.vertices(asked)).max())


def flat(rotations: np.ndarray, joints: Any) -> np.ndarray:
    return rotations[:, list(joints)].reshape(len(rotations), -1)


def thing(axes: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """An object's places and axis-angles in a file, and its places and matrices in the world."""
    t = np.linspace(0.0, 1.0, FRAMES)[:, None]
    places = np.array([0.5, 0.3, 0.9]) + t * np.array([0.2, 0.1, 0.1])
    turns = np.array([0.3, -0.5, 1.0]) + t * np.array([0.2, 0.4, -0.1])
    matrices = rot.rotvec_to_matrix(turns)
    return places @ axes, rot.log(rot.from_matrix(axes.T @ matrices)), places, matrices


def mesh(path: Path, at: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> trimesh.Trimesh:
    """A wedge-like mesh, written to `path`: no two of its axes are alike."""
    made = trimesh.creation.box((0.3, 0.2, 0.1))
    made.vertices[:, 0] += 0.4 * made.vertices[:, 2]
    made.apply_translation(at)
    path.parent.mkdir(parents=True, exist_ok=True)
    made.export(path)
    return made


def placed(vertices: np.ndarray, position: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    return vertices @ matrix.T + position


def mesh_off(sequence: Any, name: str, asked: np.ndarray, frame: int) -> float:
    """Distance of an object's recorded vertices from `asked` (V, 3) at a frame [m]."""
    item, track = sequence.scene.objects[name], sequence.recorded[name]
    found = rot.rotate(track.quaternion[frame], item.visual.vertices) + track.position[frame]
    away = np.linalg.norm(found[:, None] - asked[None], axis=-1)
    return float(max(away.min(axis=0).max(), away.min(axis=1).max()))


def load(path: Path, **options: Any) -> Any:
    """The sequence of a data set as recorded."""
    return quiet(path, ground=False, adapt=False, **options)


def dump(path: Path, content: Any) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(pickle.dumps(content))
    return path


def stored(path: Path) -> Any:
    """The content of a pickle that these tests wrote."""
    return pickle.loads(path.read_bytes())


# -- the layouts ---------------------------------------------------------------------------------


def interx(root: Path, people: Any) -> Path:
    """Inter-X: a folder of two files."""
    folder = root / "motions" / "G001T000A000R000"
    folder.mkdir(parents=True, exist_ok=True)
    for name, someone in zip(("P1", "P2"), people, strict=True):
        np.savez(folder / f"{name}.npz", **interx_fields(someone))
    return folder


def interx_fields(someone: Any) -> dict[str, Any]:
    trans, r = in_axes(someone, Y_UP)
    return {
        "root_orient": r[:, 0].astype(np.float32),
        "pose_body": r[:, 1:22].astype(np.float32),
        "pose_lhand": r[:, LEFT].astype(np.float32),
        "pose_rhand": r[:, RIGHT].astype(np.float32),
        "trans": trans.astype(np.float32),
        "betas": BETAS[None].astype(np.float32),
        "gender": np.array("female"),
    }


def interhuman_fields(people: Any) -> dict[str, Any]:
    out: dict[str, Any] = {"mocap_framerate": 59.94, "frames": FRAMES}
    for name, someone in zip(("person1", "person2"), people, strict=True):
        trans, r = in_axes(someone, Z_UP)
        out[name] = {
            "trans": trans.astype(np.float32),
            "root_orient": r[:, 0].astype(np.float32),
            "pose_body": flat(r, range(1, 22)).astype(np.float32),
            "betas": BETAS[None],
            "gender": "male",
        }
    return out


def interact_fields(someone: Any, width: int = 156) -> dict[str, Any]:
    """165: with jaw and eyes after the hands, unlike AMASS."""
    trans, r = in_axes(someone, Y_UP)
    columns = [*SMPLH_JOINTS, 22, 23, 24][: width // 3]
    return {
        "poses": flat(r, columns),
        "betas": BETAS,
        "trans": trans,
        "gender": np.array("male"),
    }


def interact(root: Path, someone: Any, width: int = 156) -> Path:
    folder = root / "chairs" / "sequences" / "subject01_chair_0"
    folder.mkdir(parents=True, exist_ok=True)
    np.savez(folder / "human.npz", **interact_fields(someone, width))
    places, turns, *_ = thing(Y_UP)
    np.savez(folder / "object.npz", angles=turns, trans=places, name=np.array("chair"))
    mesh(root / "chairs" / "objects" / "chair" / "chair.obj")
    return folder


def emdb_fields(someone: Any, axes: np.ndarray = Y_UP) -> dict[str, Any]:
    trans, r = in_axes(someone, axes)
    body = np.concatenate([flat(r, range(1, 22)), np.full((FRAMES, 6), 0.1)], axis=1)
    return {
        "gender": "female",
        "name": "P0_09_outdoor_walk",
        "emdb1": True,
        "emdb2": False,
        "n_frames": FRAMES,
        "good_frames_mask": np.arange(FRAMES) != 3,
        "camera": {
            "intrinsics": np.eye(3),
            "extrinsics": np.tile(np.eye(4), (FRAMES, 1, 1)),
            "width": 1440,
            "height": 1920,
        },
        "smpl": {"poses_root": r[:, 0], "poses_body": body, "trans": trans, "betas": BETAS},
        "kp2d": np.zeros((FRAMES, 24, 2)),
        "bboxes": {"bboxes": np.zeros((FRAMES, 4)), "invalid_idxs": np.array([3])},
    }


def threedpw_fields(people: Any, axes: np.ndarray = Y_UP) -> dict[str, Any]:
    """3DPW: images at half the rate of the bodies."""
    filed = [in_axes(someone, axes) for someone in people]
    poses = [np.concatenate([flat(r, SMPL_JOINTS), np.full((FRAMES, 6), 0.1)], 1) for _, r in filed]
    images = FRAMES // 2
    return {
        "sequence": "downtown_walking_00",
        "poses": [p[::2] for p in poses],
        "trans": [trans[::2] for trans, _ in filed],
        "poses_60Hz": poses,
        "trans_60Hz": [trans for trans, _ in filed],
        "betas": [BETAS for _ in people],
        "genders": ["m", "f"][: len(people)],
        "cam_poses": np.tile(np.eye(4), (images, 1, 1)),
        "cam_intrinsics": np.eye(3),
        "campose_valid": [np.ones(images, dtype=np.int8) for _ in people],
        "img_frame_ids": np.arange(images),
        "jointPositions": [np.zeros((images, 72)) for _ in people],
    }


def humanclaw_fields(someone: Any, width: int = 75) -> dict[str, Any]:
    trans, r = in_axes(someone, Y_UP)
    last = (
        [flat(r, range(1, 22)), np.full((FRAMES, 6), 0.1)]
        if width == 75
        else [flat(r, range(1, 55))]
    )
    return {
        "xb_world_75": np.concatenate([trans, r[:, 0], *last], axis=1).astype(np.float32),
        "fps": np.asarray(30.0, dtype=np.float32),
        "step_starts": np.array([0], dtype=np.int32),
        "meta_json": np.array(json.dumps({"schema": "humanclaw_trajectory_before_v2"})),
    }


def intercap_fields(someone: Any, hands: np.ndarray) -> dict[str, Any]:
    """`hands`: components (T, 24)."""
    trans, r = in_axes(someone, Y_DOWN)
    places, turns, *_ = thing(Y_DOWN)
    return {
        "global_orient": r[:, 0],
        "body_pose": flat(r, range(1, 22)),
        "left_hand_pose": hands[:, :12],
        "right_hand_pose": hands[:, 12:],
        "betas": np.tile(BETAS, (FRAMES, 1)),
        "transl": trans,
        "ob_pose": turns,
        "ob_trans": places,
    }


def parahome(root: Path, someone: Any, axes: np.ndarray = Z_UP) -> Path:
    """ParaHome: a free pan, a desk that stands, a laptop whose lid moves on its base."""
    trans, r = in_axes(someone, axes)
    pose = {
        "global_orient": r[:, 0],
        "body_pose": r[:, 1:22],
        "transl": trans,
        "hand_pose": r[:, LEFT + RIGHT],
    }
    folder = root / "smplx_seq" / "s7"
    dump(folder / "smplx_pose.pkl", pose)
    dump(folder / "smplx_params.pkl", {"beta": np.linspace(1, -1, 20), "gender": "female"})
    places, turns, *_ = thing(axes)
    moving = np.tile(np.eye(4), (FRAMES, 1, 1))
    moving[:, :3, :3], moving[:, :3, 3] = rot.rotvec_to_matrix(turns), places
    still = np.tile(moving[0], (FRAMES, 1, 1))
    parts = {"pan_base": moving, "desk_base": still, "laptop_base": still, "laptop_part1": moving}
    table = {k: {name: poses[k] for name, poses in parts.items()} for k in range(FRAMES)}
    del table[0]["pan_base"]
    dump(root / "seq" / "s7" / "object_transformations.pkl", table)
    for name in parts:
        whole, part = name.split("_")
        mesh(root / "scan" / whole / "simplified" / f"{part}.obj")
    return folder


def frame_fields(
    someone: Any, axes: np.ndarray, place: np.ndarray, hands: np.ndarray
) -> list[dict]:
    """`smplx` parameters frame by frame, in a camera's frame."""
    trans, r = in_axes(someone, axes, place)
    face = {"jaw_pose": 22, "leye_pose": 23, "reye_pose": 24}
    return [
        {
            "transl": trans[k : k + 1].astype(np.float32),
            "global_orient": r[k : k + 1, 0].astype(np.float32),
            "body_pose": r[k, 1:22].reshape(1, 63).astype(np.float32),
            "left_hand_pose": hands[k : k + 1, :12].astype(np.float32),
            "right_hand_pose": hands[k : k + 1, 12:].astype(np.float32),
            "betas": BETAS[None].astype(np.float32),
            "expression": np.zeros((1, 10), dtype=np.float32),
            **{key: r[k : k + 1, joint].astype(np.float32) for key, joint in face.items()},
        }
        for k in range(FRAMES)
    ]


# -- pickles of Python 2 -------------------------------------------------------------------------

_Pickler: Any = pickle._Pickler


class _OfPython2(_Pickler):
    """Writes text and bytes alike, as strings of Python 2, which say no encoding."""

    dispatch: ClassVar[dict[Any, Any]] = dict(_Pickler.dispatch)

    def _string(self, value: Any) -> None:
        raw = value.encode("latin1") if isinstance(value, str) else bytes(value)
        self.write(pickle.BINSTRING + struct.pack("<i", len(raw)) + raw)
        self.memoize(value)

    dispatch[str] = _string
    dispatch[bytes] = _string


def python2_pickle(content: Any) -> bytes:
    """A pickle as Python 2 and numpy 1.11 wrote it: protocol 2, strings without encoding."""
    stream = io.BytesIO()
    _OfPython2(stream, protocol=2).dump(content)
    return stream.getvalue().replace(b"numpy._core.multiarray", b"numpy.core.multiarray")
