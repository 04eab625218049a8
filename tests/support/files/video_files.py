"""The files of estimators of people in video, in their exact layouts, from known movements.

Every writer takes people as `Person`, in a world with y up, and writes what the program would: in
the frame, of the joints and with the points that it uses. What they mean is computed with a posed
body here, never with the formulas of the readers.
"""

from __future__ import annotations

import base64
import json
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

import halfphysics as hp
from halfphysics.base import rotations as rot
from support.files.dumps import Inline, joblib_dump, npy_of, torch_dict, wrapped
from support.files.layouts import movement

#: From y up to y down, as in cameras.
DOWN = np.diag([1.0, -1.0, -1.0])
_BODY, _HANDS, _SMPL = list(range(1, 22)), (range(25, 40), range(40, 55)), 22


@dataclass(frozen=True, eq=False)
class Person:
    """Frames in which somebody was seen, and their movement there, y up."""

    name: str
    frames: np.ndarray
    translation: np.ndarray
    rotations: np.ndarray
    betas: np.ndarray = field(default_factory=lambda: np.linspace(0.4, -0.3, 10))

    def motion(self) -> hp.Motion:
        return hp.Motion(self.translation, self.rotations, 30.0)

    def vertices(self) -> np.ndarray:
        """Skin of the default body in the world of the writers, y up."""
        return hp.Body.default().vertices(self.motion())

    def pelvis(self) -> np.ndarray:
        return hp.Body.default().joints(self.motion())[:, 0]

    def hips(self) -> np.ndarray:
        """The point midway between the hip joints."""
        return hp.Body.default().joints(self.motion())[:, 1:3].mean(axis=1)

    def rows(self) -> np.ndarray:
        """Betas for every frame, which differ a little."""
        wave = 0.01 * np.sin(np.arange(len(self.frames)))
        return self.betas + (wave - wave.mean())[:, None]


def person(name: str, frames, seed: int, joints: int = 55) -> Person:
    """Somebody who moves the first `joints` joints smoothly through all frames, seen in some."""
    frames = np.asarray(frames)
    translation, rotations = movement(int(frames.max()) + 1, seed=seed, up="y")
    rotations[:, joints:] = 0.0
    return Person(name, frames, translation[frames] + [seed, 0.0, 0.0], rotations[frames])


def two(joints: int = 55) -> list[Person]:
    """The first is seen in frames 2 to 13 but for two; the second later and shorter."""
    first = [number for number in range(2, 14) if number not in (5, 9)]
    return [person("3", first, 1, joints), person("8", np.arange(6, 14), 2, joints)]


def placed(who: Person, turn: np.ndarray, move=(0.0, 0.0, 0.0)) -> tuple[np.ndarray, np.ndarray]:
    """Translation and rotations in another frame, x' = turn x + move; one turn, or one per frame.

    The body is posed there: its pelvis must be where the world's pelvis goes.
    """
    turn = np.broadcast_to(turn, (len(who.frames), 3, 3))
    root = turn @ rot.rotvec_to_matrix(who.rotations[:, 0])
    rotations = who.rotations.copy()
    rotations[:, 0] = rot.matrix_to_rotvec(root)
    pelvis = np.einsum("tij,tj->ti", turn, who.pelvis()) + move
    return pelvis - hp.Body.default().rest_joints[0], rotations


def single(array) -> np.ndarray:
    return np.ascontiguousarray(array, dtype=np.float32)


def smpl(rotations: np.ndarray) -> np.ndarray:
    """SMPL's 24 joints (T, 72), the last two zero."""
    out = np.zeros((len(rotations), 24, 3))
    out[:, :_SMPL] = rotations[:, :_SMPL]
    return single(out.reshape(len(out), 72))


def matrices(rotations: np.ndarray) -> np.ndarray:
    return single(rot.rotvec_to_matrix(smpl(rotations).reshape(-1, 24, 3).astype(float)))


def params(translation, rotations) -> dict[str, np.ndarray]:
    """Body and root under the names of the `smplx` package."""
    frames = len(rotations)
    return {
        "body_pose": single(rotations[:, _BODY].reshape(frames, 63)),
        "global_orient": single(rotations[:, 0]),
        "transl": single(translation),
    }


def gvhmr_data(who: Person) -> dict:
    down, turned = placed(who, DOWN, (0.1, 0.2, 3.0))
    world = {**params(who.translation, who.rotations), "betas": single(who.rows())}
    count = len(who.frames)
    return {
        "smpl_params_global": world,
        "smpl_params_incam": {**params(down, turned), "betas": single(who.rows())},
        "K_fullimg": np.tile(np.eye(3, dtype=np.float32), (count, 1, 1)),
        "net_outputs": {"model_output": {"pred_cam": np.ones((1, count, 3), np.float32)}},
    }


def gvhmr(path: Path, who: Person) -> Path:
    return torch_dict(path, gvhmr_data(who))


def wham_data(people: list[Person]) -> dict:
    out = {}
    for who in people:
        down, turned = placed(who, DOWN, (0.1, 0.2, 3.0))
        out[int(who.name)] = {
            "pose": smpl(turned),
            "trans": single(down),
            "pose_world": smpl(who.rotations),
            "trans_world": single(who.hips()),
            "betas": single(who.rows()),
            "verts": np.zeros((len(who.frames), 4, 3), np.float32),
            "frame_ids": who.frames.astype(np.int64),
        }
    return out


def joblib_file(path: Path, data) -> Path:
    path.write_bytes(joblib_dump(wrapped(data)))
    return path


def prompthmr_data(people: list[Person]) -> dict:
    out = {}
    for who in people:
        down, turned = placed(who, DOWN, (0.1, 0.2, 3.0))
        out[int(who.name)] = {
            "frames": who.frames.astype(np.int64),
            "track_id": int(who.name),
            "smplx_cam": {
                "rotmat": single(rot.rotvec_to_matrix(turned)),
                "shape": single(who.rows()),
                "trans": single(down),
            },
            "smplx_world": {
                "pose": single(who.rotations.reshape(-1, 165)),
                "shape": single(np.tile(who.betas, (len(who.frames), 1))),
                "trans": single(who.translation),
            },
        }
    frames = 1 + max(int(who.frames.max()) for who in people) if people else 1
    camera = {"Rwc": np.tile(np.eye(3), (frames, 1, 1)), "Twc": np.zeros((frames, 3))}
    return {"people": out, "camera_world": camera, "has_hps_world": True}


def codec(path: Path, who: Person, rate: float = 25.0) -> bytes:
    np.savez(
        path,
        codecVersion=np.int32(1),
        smplVersion=np.int32(2),
        gender=np.int32(0),
        frameCount=np.int32(len(who.frames)),
        frameRate=np.float32(rate),
        shapeParameters=single(who.betas),
        bodyTranslation=single(who.translation),
        bodyPose=single(who.rotations[:, :_SMPL]),
    )
    return path.read_bytes()


def mcs_data(folder: Path, people: list[Person]) -> dict:
    """The document; people without gaps, as the program writes them."""
    scene: dict = {"num_frames": 14, "smpl_bodies": []}
    document: dict = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0], "extensions": {"MC_scene_description": scene}}],
        "nodes": [{"name": "RootNode", "children": [1]}, {"name": "AnimatedCamera", "camera": 0}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.9, "znear": 0.01}}],
        "buffers": [],
        "bufferViews": [],
        "extensionsUsed": ["MC_scene_description"],
    }
    for number, who in enumerate(people):
        data = codec(folder / "body.npz", who)
        text = base64.b64encode(data).decode()
        uri = f"data:application/octet-stream;base64,{text}"
        document["buffers"].append({"byteLength": len(data), "uri": uri})
        view = {"buffer": number, "byteOffset": 0, "byteLength": len(data)}
        document["bufferViews"].append(view)
        presence = [int(who.frames[0]), int(who.frames[-1]) + 1]
        scene["smpl_bodies"].append({"frame_presence": presence, "bufferView": number})
    return document


def mcs(path: Path, people: list[Person]) -> Path:
    path.write_text(json.dumps(mcs_data(path.parent, people), indent=2))
    return path


def camera_path(frames: int) -> tuple[np.ndarray, np.ndarray]:
    """World (y up) from a camera (y down) that turns and moves: (F, 3, 3) and (F, 3)."""
    t = np.linspace(0.0, 1.0, frames)[:, None]
    turn = rot.rotvec_to_matrix([0.2, -0.3, 0.1] + t * np.array([0.1, 0.5, -0.1])) @ DOWN
    return single(turn).astype(float), single([0.3, 1.4, 2.0] + t * [0.5, 0.1, 0.2]).astype(float)


def tram_data(who: Person) -> dict:
    turns, places = camera_path(14)
    turn, place = turns[who.frames], places[who.frames]
    back = np.swapaxes(turn, 1, 2)
    down, turned = placed(who, back, -np.einsum("tij,tj->ti", back, place))
    count = len(who.frames)
    return {
        "pred_cam": np.ones((count, 3), np.float32),
        "pred_pose": np.zeros((count, 144), np.float32),
        "pred_shape": single(who.rows()),
        "pred_rotmat": matrices(turned),
        "pred_trans": single(down)[:, None],
        "frame": who.frames.astype(np.int64),
    }


def tram_track(path: Path, data: dict) -> Path:
    return npy_of(path, {key: Inline(value) for key, value in data.items()})


def tram(folder: Path, people: list[Person]) -> Path:
    (folder / "hps").mkdir(parents=True)
    for number, who in enumerate(people):
        tram_track(folder / "hps" / f"hps_track_{number}.npy", tram_data(who))
    turns, places = camera_path(14)
    camera = {"world_cam_R": single(turns), "world_cam_T": single(places), "img_focal": 800.0}
    np.save(folder / "camera.npy", np.array(camera, dtype=object), allow_pickle=True)
    return folder


def phalp_data(people: list[Person]) -> dict:
    out = {}
    for number in range(14):
        frame: dict = {"time": number, "tid": [], "smpl": [], "camera": [], "size": [[720, 1280]]}
        for who in people:
            at = np.flatnonzero(who.frames == number)
            if not len(at):
                continue
            down, turned = placed(who, DOWN, (0.1, 0.2, 30.0))
            turns, row = matrices(turned), int(at[0])
            frame["tid"].append(int(who.name))
            frame["camera"].append(single(down[row]))
            frame["smpl"].append(
                {
                    "global_orient": turns[row, :1],
                    "body_pose": turns[row, 1:],
                    "betas": single(who.rows()[row]),
                }
            )
        out[f"outputs/_DEMO/clip/img/{number:06d}.jpg"] = frame
    return out


def comotion_data(people: list[Person]) -> dict:
    """Rows in the order of the frames, as the program goes through the video."""
    rows = []
    for who in people:
        down, turned = placed(who, DOWN, (0.1, 0.2, 3.0))
        for row, number in enumerate(who.frames):
            parts = (smpl(turned)[row], single(down)[row], single(who.rows())[row])
            rows.append((int(number), int(who.name), *parts))
    rows.sort(key=lambda row: row[:2])
    frames, ids, pose, trans, betas = zip(*rows, strict=True)
    return {
        "id": np.array(ids, np.int64),
        "pose": np.stack(pose),
        "trans": np.stack(trans),
        "betas": np.stack(betas),
        "frame_idx": np.array(frames, np.int64),
    }


def slahmr_world() -> tuple[np.ndarray, np.ndarray]:
    """The program's world from ours: a tilted camera, y down; x' = R x + t."""
    return rot.rotvec_to_matrix([0.25, 0.1, -0.2]) @ DOWN, np.array([0.2, 0.4, 3.0])


def slahmr_data(people: list[Person], floor: float = -0.7, world=None) -> dict:
    """With the floor at y = `floor` of our world; `world`: the program's, as of `slahmr_world`."""
    turn, move = slahmr_world() if world is None else world
    both = [placed(who, turn, move) for who in people]
    normal = turn @ [0.0, 1.0, 0.0]
    offset = normal @ (turn @ [0.0, floor, 0.0] + move)
    rotations = np.stack([rotations for _, rotations in both])
    people_, frames = rotations.shape[:2]
    return {
        "trans": single(np.stack([translation for translation, _ in both])),
        "root_orient": single(rotations[:, :, 0]),
        "pose_body": single(rotations[:, :, _BODY].reshape(people_, frames, 63)),
        "latent_pose": np.zeros((people_, frames, 32), np.float32),
        "betas": single(np.stack([np.pad(who.betas, (0, 6)) for who in people])),
        "cam_R": np.tile(np.eye(3, dtype=np.float32), (people_, frames, 1, 1)),
        "cam_t": np.zeros((people_, frames, 3), np.float32),
        "intrins": np.array([800.0, 800, 320, 240]),
        "floor_plane": single((normal * offset)[None]),
        "world_scale": np.ones((1, 1)),
    }


def romp_rows(people: list[Person]) -> list[dict]:
    """What the program has for each of 14 frames: a row for each person who is seen."""
    out = []
    for number in range(14):
        poses, places, betas, ids = [], [], [], []
        for who in people:
            at = np.flatnonzero(who.frames == number)
            if len(at):
                _, turned = placed(who, DOWN)
                poses.append(smpl(turned)[at[0]])
                places.append(single(DOWN @ who.hips()[at[0]] + [0.1, 0.2, 3.0]))
                betas.append(single(np.append(who.rows()[at[0]], 0.1)))
                ids.append(int(who.name))
        if ids:
            out.append(
                {
                    "smpl_thetas": np.stack(poses),
                    "smpl_betas": np.stack(betas),
                    "cam_trans": np.stack(places),
                    "cam": np.ones((len(ids), 3), np.float32),
                    "track_ids": np.array(ids, np.int32),
                }
            )
        else:
            out.append({})
    return out


def romp_video(people: list[Person]) -> dict:
    """`video_results.npz`."""
    rows = romp_rows(people)
    sequences: dict = {}
    for number, row in enumerate(rows):
        for index, who in enumerate(row.get("track_ids", ())):
            own = sequences.setdefault(int(who), {"frame_id": []})
            own["frame_id"].append(number)
            for key, value in row.items():
                own.setdefault(key, []).append(value[index])
    results = {f"{number:08d}.png": row for number, row in enumerate(rows) if row}
    return {"results": results, "sequence_results": sequences}


def trace_data(people: list[Person]) -> dict:
    rows = romp_rows(people)
    keys = ("smpl_thetas", "smpl_betas", "cam_trans", "track_ids")
    out = {key: np.concatenate([row[key] for row in rows if row]) for key in keys}
    numbers = [np.full(len(row["track_ids"]), n) for n, row in enumerate(rows) if row]
    out["reorganize_idx"] = np.concatenate(numbers)
    out["world_trans"], out["world_global_rots"] = out["cam_trans"], out["smpl_thetas"][:, :3]
    # In the frame of the moving camera all is elsewhere.
    out["cam_trans"] = out["cam_trans"] + 1.0
    out["smpl_thetas"] = np.hstack([out["smpl_thetas"][:, :3] * 0.5, out["smpl_thetas"][:, 3:]])
    return out


def objects(path: Path, fields: dict) -> Path:
    """`numpy.savez` of dicts."""
    np.savez(path, **{key: np.array(value, dtype=object) for key, value in fields.items()})
    return path


def smplerx_data(people: list[Person]) -> dict[str, dict[str, np.ndarray]]:
    """Name of each file -> its fields."""
    out = {}
    for index, who in enumerate(people):
        down, turned = placed(who, DOWN, (0.1, 0.2, 30.0))
        for row, number in enumerate(who.frames):
            out[f"{number:05d}_{index}.npz"] = {
                "global_orient": single(turned[row, :1]),
                "body_pose": single(turned[row, _BODY]),
                "left_hand_pose": single(turned[row, list(_HANDS[0])]),
                "right_hand_pose": single(turned[row, list(_HANDS[1])]),
                "jaw_pose": single(turned[row, 22:23]),
                "leye_pose": single(turned[row, 23:24]),
                "reye_pose": single(turned[row, 24:25]),
                "betas": single(who.rows()[row][None]),
                "expression": np.zeros((1, 10), np.float32),
                "transl": single(down[row][None]),
            }
    return out


def smplerx(folder: Path, people: list[Person]) -> Path:
    (folder / "smplx").mkdir(parents=True)
    (folder / "meta").mkdir()
    for name, fields in smplerx_data(people).items():
        np.savez(folder / "smplx" / name, **fields)
    return folder


def bedlam_data(people: list[Person], joints: int = 55) -> dict[str, np.ndarray]:
    rows = []
    for who in people:
        down, turned = placed(who, DOWN)
        poses = turned.reshape(-1, 165) if joints == 55 else smpl(turned)
        for row, number in enumerate(who.frames):
            image = f"seq_000001/seq_000001_{number:04d}.png"
            rows.append((number, who.name, image, poses[row], down[row], who.betas))
    rows.sort(key=lambda row: row[0])
    _, subs, images, poses, places, betas = zip(*rows, strict=True)
    return {
        "imgname": np.array(images),
        "sub": np.array([f"rp_{sub}" for sub in subs]),
        "gender": np.array(["female"] * len(rows)),
        "pose_cam": np.stack(poses),
        "pose_world": np.stack(poses),
        "trans_cam": np.stack(places),
        "trans_world": np.stack(places),
        "shape": np.stack(betas),
        "cam_ext": np.tile(np.eye(4), (len(rows), 1, 1)),
    }
