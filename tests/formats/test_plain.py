"""Files with the names of the `smplx` package, in every shape in which people store them."""

from __future__ import annotations

import json
import pickle
import warnings
from pathlib import Path

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.base.axes import axes_of
from halfphysics.errors import HalfPhysicsWarning
from halfphysics.formats import Source, identify
from support.files.dumps import torch_dict
from support.files.layouts import movement, quiet
from support.files.model_files import fields as model_fields
from support.files.model_files import write_npz
from support.files.wrong_files import (
    broken_bytes_are_refused,
    changed,
    hostile_is_refused,
    put,
    refused,
    uneven,
    usual,
    without,
)

#: Vertices [m] of numbers in double precision, by way of matrices.
ROUNDING = 1e-9
#: Of numbers in single precision.
SINGLE = 1e-5
FRAMES = 12
BODY, LEFT, RIGHT = slice(1, 22), slice(25, 40), slice(40, 55)


def moved() -> tuple[np.ndarray, np.ndarray]:
    """All joints bent, y up; knees the way that knees bend."""
    translation, rotations = movement(FRAMES, seed=4, up="y")
    rotations[:, [4, 5], 0] = 0.6 + 0.2 * np.abs(rotations[:, [4, 5], 0])
    return translation, rotations


def fields() -> dict:
    translation, r = moved()
    return {
        "global_orient": r[:, 0],
        "body_pose": r[:, BODY].reshape(FRAMES, 63),
        "left_hand_pose": r[:, LEFT].reshape(FRAMES, 45),
        "right_hand_pose": r[:, RIGHT].reshape(FRAMES, 45),
        "jaw_pose": r[:, 22],
        "leye_pose": r[:, 23],
        "reye_pose": r[:, 24],
        "expression": np.ones((FRAMES, 10)),
        "transl": translation,
        "betas": np.tile(np.linspace(0.5, -0.5, 10), (FRAMES, 1)),
    }


def truth(joints: int = 55) -> np.ndarray:
    translation, rotations = moved()
    rotations[:, joints:] = 0.0
    motion = hp.Motion(translation, rotations, 30.0)
    return hp.Body.default().vertices(motion) @ axes_of("y").T


def apart(motion: hp.Motion, joints: int = 55) -> float:
    return float(np.abs(hp.Body.default().vertices(motion) - truth(joints)).max())


def written(path: Path, content: dict) -> Path:
    if path.suffix == ".npz":
        np.savez(path, **content)
    elif path.suffix == ".json":
        path.write_text(json.dumps({k: np.asarray(v).tolist() for k, v in content.items()}))
    elif path.suffix == ".pt":
        torch_dict(path, {k: np.asarray(v, np.float32) for k, v in content.items()})
    else:
        path.write_bytes(pickle.dumps(content))
    return path


@pytest.mark.parametrize("suffix", [".npz", ".json", ".pt", ".pkl"])
def test_every_kind_of_file(tmp_path, suffix):
    """A further field: the pickle is no clip of TRUMANS."""
    path = written(tmp_path / f"a{suffix}", {**fields(), "pred_cam": np.ones((FRAMES, 3))})
    assert identify(Source(path)).name == "smplx-params"
    motion = quiet(path).motion
    assert apart(motion) < (SINGLE if suffix == ".pt" else ROUNDING)
    assert (motion.fps, motion.model, motion.gender) == (30.0, "smplx", "neutral")
    assert np.abs(motion.betas - np.linspace(0.5, -0.5, 10)).max() < 1e-6


def split(array: np.ndarray) -> np.ndarray:
    return array.reshape(FRAMES, -1, 3)


def matrices(array: np.ndarray) -> np.ndarray:
    return rot.rotvec_to_matrix(split(array))


def six(how: str):
    """6D as pytorch3d has it (rows), as SPIN (columns, interleaved), as HumanML3D (columns)."""

    def convert(array: np.ndarray) -> np.ndarray:
        m = matrices(array)
        if how == "rows":
            return m[..., :2, :].reshape(FRAMES, -1)
        if how == "interleaved":
            return m[..., :2].reshape(FRAMES, -1)
        return np.swapaxes(m[..., :2], -1, -2).reshape(FRAMES, -1)

    return convert


FORMS = {
    "flat": lambda a: a,
    "joints": split,
    "one": lambda a: a[None],
    "matrices": matrices,
    "flat matrices": lambda a: matrices(a).reshape(FRAMES, -1),
    "rows": six("rows"),
    "interleaved": six("interleaved"),
    "columns": six("columns"),
    "columns of joints": lambda a: six("columns")(a).reshape(FRAMES, -1, 6),
}


@pytest.mark.parametrize("name", FORMS)
def test_every_form_of_rotations(tmp_path, name):
    content = fields()
    for key, value in content.items():
        if key not in ("transl", "betas", "expression"):
            content[key] = FORMS[name](value)
    motion = quiet(written(tmp_path / "a.npz", content)).motion
    assert apart(motion) < ROUNDING


@pytest.mark.parametrize("shape", ["flat", "joints", "matrices"])
def test_23_joints_are_smpl(tmp_path, shape):
    content = fields()
    body = np.hstack([content["body_pose"], np.full((FRAMES, 6), 0.3)])
    content = {
        "global_orient": content["global_orient"],
        "body_pose": FORMS[shape](body),
        "transl": content["transl"],
    }
    motion = quiet(written(tmp_path / "a.npz", content)).motion
    assert motion.model == "smpl"
    assert apart(motion, 22) < ROUNDING
    assert "hands" in motion.origin.fields["invented"]


def test_one_frame_is_held(tmp_path):
    content = {key: value[0] for key, value in fields().items()}
    with pytest.warns(HalfPhysicsWarning, match="single frame, which is held for two"):
        motion = hp.load_sequence(written(tmp_path / "a.npz", content)).motion
    assert len(motion) == 2
    assert np.abs(hp.Body.default().vertices(motion) - truth()[0]).max() < ROUNDING


def test_what_is_said_beside_a_person(tmp_path):
    """As sign-language and video services write it: one rate for all, the parameters in a dict."""
    own = {key: np.asarray(value).tolist() for key, value in fields().items()}
    content = {"format": "smplx-v1", "fps": 25, "gender": "female", "smplx": own}
    (tmp_path / "a.json").write_text(json.dumps(content))
    motion = quiet(tmp_path / "a.json").motion
    assert (motion.fps, motion.gender) == (25.0, "female")
    content["smplx"] = {**own, "fps": 50}
    (tmp_path / "b.json").write_text(json.dumps(content))
    assert quiet(tmp_path / "b.json").motion.fps == 50.0  # the person's own counts


def test_a_list_of_frames_and_a_dict_of_people(tmp_path):
    rows = [{key: value[n] for key, value in fields().items()} for n in range(FRAMES)]
    (tmp_path / "a.pkl").write_bytes(pickle.dumps(rows))
    assert apart(quiet(tmp_path / "a.pkl").motion) < ROUNDING
    other = {**fields(), "transl": fields()["transl"] + [0.0, 0.0, 2.0]}
    (tmp_path / "b.pkl").write_bytes(pickle.dumps({"anne": fields(), 7: other, "fps": 25}))
    anne, seven = quiet(tmp_path / "b.pkl").motions
    assert apart(anne) < ROUNDING
    assert np.abs(seven.translation - anne.translation - [0.0, -2.0, 0.0]).max() < ROUNDING
    assert len(quiet(tmp_path / "b.pkl", clip="7").motions) == 1
    np.savez(tmp_path / "c.npz", person=np.array(fields(), dtype=object))
    assert apart(quiet(tmp_path / "c.npz").motion) < ROUNDING


@pytest.mark.parametrize("up", ["z", "-y"])
def test_the_axis_is_that_along_which_the_person_stands(tmp_path, up):
    """The same movement in a file with another axis up is the same in the world."""
    content, body = fields(), hp.Body.default()
    turn = axes_of(up).T @ axes_of("y")  # file from a file with y up
    motion = hp.Motion(*moved(), 30.0)
    pelvis = body.joints(motion)[:, 0]
    root = turn @ rot.rotvec_to_matrix(content["global_orient"])
    content["global_orient"] = rot.matrix_to_rotvec(root)
    content["transl"] = pelvis @ turn.T - body.rest_joints[0]
    path = written(tmp_path / "a.npz", content)
    told = {"z": "z up, as the person stands", "-y": "y down, as the person stands"}[up]
    with pytest.warns(HalfPhysicsWarning, match=told):
        sequence = hp.load_sequence(path)
    assert apart(sequence.motion) < ROUNDING


def test_what_the_file_says_is_not_invented(tmp_path):
    content = {**fields(), "fps": 50.0, "gender": "female", "model_type": "smplh"}
    motion = quiet(written(tmp_path / "a.npz", content)).motion
    assert (motion.fps, motion.gender, motion.model) == (50.0, "female", "smplh")
    assert set(motion.origin.fields["invented"]) == {"up", "floor", "hands"}


@pytest.mark.parametrize("count", [6, 12, 24])
def test_hands_of_principal_components(tmp_path, count):
    content = fields()
    rng = np.random.default_rng(count)
    for side in ("left", "right"):
        content[f"{side}_hand_pose"] = rng.normal(0, 0.1, (FRAMES, count))
    path = written(tmp_path / "a.npz", content)
    with pytest.warns(HalfPhysicsWarning, match=f"{count} principal components.*stay flat"):
        flat = hp.load_sequence(path).motion
    assert apart(flat, 25) < ROUNDING
    data = model_fields("smplx")
    model = write_npz(tmp_path / "SMPLX_NEUTRAL.npz", data)
    relaxed, on_flat = (quiet(path, model=model, hands=h).motion for h in (None, "flat"))
    for side, first in (("left", 25), ("right", 40)):
        asked = content[f"{side}_hand_pose"] @ data[f"hands_components{side[0]}"][:count]
        mean = data[f"hands_mean{side[0]}"]
        found = relaxed.rotations[:, first : first + 15].reshape(FRAMES, 45)
        assert np.abs(found - asked - mean).max() < ROUNDING
        found = on_flat.rotations[:, first : first + 15].reshape(FRAMES, 45)
        assert np.abs(found - asked).max() < ROUNDING


@pytest.mark.parametrize("hands", [None, "flat", "mean"])
@pytest.mark.parametrize("count", [12, 45])
def test_fingers_come_back_with_the_same_options(tmp_path, hands, count):
    """Principal components are written as rotations, which are read as on a flat hand."""
    content, rng = fields(), np.random.default_rng(count)
    for side in ("left", "right"):
        content[f"{side}_hand_pose"] = rng.normal(0, 0.1, (FRAMES, count))
    options = {"model": write_npz(tmp_path / "SMPLX_NEUTRAL.npz", model_fields("smplx"))}
    options["hands"] = hands
    first = quiet(written(tmp_path / "a.npz", content), **options).motion
    first.save(tmp_path / "b.pkl")
    second = quiet(tmp_path / "b.pkl", **options).motion
    assert np.abs(second.rotations - first.rotations).max() < ROUNDING


def test_a_clip_of_trumans_keeps_its_rules(tmp_path):
    content = fields()
    content["betas"] = np.zeros(0)
    path = written(tmp_path / "a.pkl", content)
    assert identify(Source(path)).name == "trumans-clip"
    assert identify(Source(written(tmp_path / "a.npz", content))).name == "smplx-params"


#: Hands may be missing; 44 numbers are principal components.
_NOT_WRONG = ("left_hand_pose", "narrow")
WRONG = [
    *[case for case in usual("transl") if "flat" not in case[0]],
    *usual("body_pose"),
    *[case for case in usual("left_hand_pose") if case[0].split()[-1] not in _NOT_WRONG],
    ("no root", without("global_orient"), "'global_orient' is missing"),
    ("matrices of nothing", put("global_orient", np.zeros((FRAMES, 3, 3))), "is no rotation"),
    ("mirrored", put("global_orient", np.tile(-np.eye(3), (FRAMES, 1, 1))), "is no rotation"),
    ("6D of nothing", put("global_orient", np.zeros((FRAMES, 6))), "zero or parallel"),
    ("transposed", changed("body_pose", lambda a: a.T), "'body_pose'.*expected"),
    ("betas of another length", put("betas", np.ones((5, 10))), "'betas'.*expected"),
    ("betas NaN", put("betas", np.full(10, np.nan)), "'betas'.*NaN"),
    ("gender unknown", put("gender", "robot"), "gender"),
    ("fps negative", put("fps", -30), "'fps'"),
    ("nobody", put("transl", np.zeros((0, 3))), "'transl'"),
]


@pytest.mark.parametrize(("spoil", "message"), [c[1:] for c in WRONG], ids=[c[0] for c in WRONG])
@pytest.mark.parametrize("suffix", [".npz", ".pkl"])
def test_wrong_files(tmp_path, spoil, message, suffix):
    content = {**fields(), "pred_cam": np.ones((FRAMES, 3))}
    spoil(content)
    refused(written(tmp_path / f"bad{suffix}", content), message)


UNEVEN = [
    *map(uneven, ("transl", "global_orient", "left_hand_pose", "betas")),
    ("rate uneven", put("fps", [[30], [30, 1]]), "'fps'.*expected"),
    ("gender uneven", put("gender", [["a"], []]), "'gender'.*expected"),
]


@pytest.mark.parametrize(("spoil", "message"), [c[1:] for c in UNEVEN], ids=[c[0] for c in UNEVEN])
def test_lists_of_different_lengths(tmp_path, spoil, message):
    content = {key: value.tolist() for key, value in fields().items()}
    spoil(content)
    (tmp_path / "bad.json").write_text(json.dumps(content))
    refused(tmp_path / "bad.json", message)


def test_hostile_and_broken_files(tmp_path):
    hostile_is_refused(tmp_path / "evil.pkl", {**fields(), "cam": 1}, "betas")
    for suffix in (".pkl", ".npz", ".pt"):
        content = {**fields(), "pred_cam": np.ones((FRAMES, 3))}
        broken_bytes_are_refused(written(tmp_path / f"a{suffix}", content))
    ragged = '{"global_orient": [[1, 2], [3]], "body_pose": 1, "transl": [[0, 0, 0], [0, 0, 0]]}'
    (tmp_path / "a.json").write_text(ragged)
    refused(tmp_path / "a.json", "'global_orient'")
    (tmp_path / "a.json").write_text(ragged.replace("[[0, 0, 0], [0, 0, 0]]", "2"))
    refused(tmp_path / "a.json", "'transl'")
    (tmp_path / "b.json").write_text("[1, 2, 3]")
    with warnings.catch_warnings(), pytest.raises(hp.HalfPhysicsError, match="no known motion"):
        hp.Motion.load(tmp_path / "b.json")


def test_a_list_of_frames_may_say_its_rate_in_each(tmp_path):
    frames = [
        {"global_orient": np.zeros(3), "body_pose": np.zeros(63), "transl": [0, 0, 0.01 * k],
         "fps": 25.0}
        for k in range(6)
    ]  # fmt: skip
    path = tmp_path / "a.pkl"
    path.write_bytes(pickle.dumps(frames))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", HalfPhysicsWarning)
        motion = hp.Motion.load(path)
    assert (len(motion), motion.fps) == (6, 25.0)
