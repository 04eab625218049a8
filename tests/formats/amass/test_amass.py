"""AMASS files in their SMPL-X, SMPL-H and SMPL layouts: what is read, written and refused."""

from __future__ import annotations

import contextlib
import io
import stat
import time
import zipfile
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from halfphysics.base import npz
from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.errors import FileError, HalfPhysicsError, HalfPhysicsWarning, InputError
from halfphysics.formats import FORMATS
from halfphysics.motion import skeleton
from halfphysics.motion.motion import Motion

WIDTHS = {"smplx": 165, "smplh": 156, "smpl": 72}
SPLIT = {"root_orient": 3, "pose_body": 63, "pose_hand": 90, "pose_jaw": 3, "pose_eye": 6}


def fields(model: str = "smplx", frames: int = 12, seed: int = 0, dtype=np.float64) -> dict:
    """A file of the model's layout with random content, no faster than people."""
    rng = np.random.default_rng(seed)
    steps = rng.normal(0, 0.01, (frames, WIDTHS[model]))
    poses = rng.normal(0, 0.5, WIDTHS[model]) + np.cumsum(steps, axis=0)
    out = {
        "trans": np.cumsum(rng.normal(0, 0.02, (frames, 3)), axis=0).astype(dtype),
        "poses": poses.astype(dtype),
        "betas": rng.normal(0, 1, 16),
        "gender": np.array("female"),
    }
    if model == "smplx":
        p = out["poses"]
        out |= {
            "num_betas": np.array(16),
            "surface_model_type": np.array("smplx"),
            "mocap_frame_rate": np.array(120.0),
            "mocap_time_length": np.array(frames / 120.0),
            "root_orient": p[:, :3],
            "pose_body": p[:, 3:66],
            "pose_jaw": p[:, 66:69],
            "pose_eye": p[:, 69:75],
            "pose_hand": p[:, 75:],
            "markers_latent": rng.normal(0, 1, (41, 3)),
        }
    else:
        out |= {"mocap_framerate": np.array(120.0), "dmpls": rng.normal(0, 1, (frames, 8))}
    return out


def write(path: Path, content: dict) -> Path:
    np.savez(path, **content)
    return path


def same(a: Path, b: Path) -> None:
    with np.load(a) as x, np.load(b) as y:
        assert list(x) == list(y)
        for key in x:
            assert x[key].dtype == y[key].dtype, key
            assert np.array_equal(x[key], y[key]), key


# -- reading and writing back ----------------------------------------------------------------


@pytest.mark.parametrize("model", WIDTHS)
@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_a_file_comes_back_bit_for_bit(tmp_path, model, dtype):
    source = write(tmp_path / "a.npz", fields(model, dtype=dtype))
    motion = Motion.load(source)
    assert motion.model == model
    assert motion.gender == "female"
    assert motion.fps == 120.0
    motion.save(tmp_path / "b.npz")
    same(source, tmp_path / "b.npz")
    again = Motion.load(tmp_path / "b.npz")
    assert np.array_equal(again.rotations, motion.rotations)


def test_columns_go_to_their_joints(tmp_path):
    poses = np.arange(2 * 165.0).reshape(2, 165) / 5e4
    x = Motion.load(write(tmp_path / "x.npz", fields(frames=2) | {"poses": poses}))
    assert np.array_equal(x.poses, poses)
    h = Motion.load(
        write(tmp_path / "h.npz", fields("smplh", frames=2) | {"poses": poses[:, :156]})
    )
    name = skeleton.JOINT_INDEX["left_index1"]
    assert np.array_equal(h.rotations[:, name], poses[:, 66:69])  # hands follow the body
    assert np.array_equal(h.rotations[:, 54], poses[:, 153:156])
    assert not h.rotations[:, 22:25].any()
    s = Motion.load(write(tmp_path / "s.npz", fields("smpl", frames=2) | {"poses": poses[:, :72]}))
    assert np.array_equal(s.poses[:, :66], poses[:, :66])
    assert not s.poses[:, 66:].any()


@pytest.mark.parametrize("model", ["smplx", "smplh"])
def test_split_fields_without_poses(tmp_path, model):
    content = fields("smplx")
    poses = content.pop("poses")
    if model == "smplh":
        del content["pose_jaw"], content["pose_eye"], content["surface_model_type"]
    source = write(tmp_path / "a.npz", content)
    motion = Motion.load(source)
    assert motion.model == model
    assert np.array_equal(motion.rotations[:, 25:].reshape(12, -1), poses[:, 75:])
    motion.save(tmp_path / "b.npz")
    same(source, tmp_path / "b.npz")


@pytest.mark.parametrize("value", [b"male", "male", "Male", np.array(["male"]), "b'male'"])
def test_gender_in_any_spelling(tmp_path, value):
    source = write(tmp_path / "a.npz", fields("smplh") | {"gender": np.array(value)})
    motion = Motion.load(source)
    assert motion.gender == "male"
    motion.save(tmp_path / "b.npz")
    same(source, tmp_path / "b.npz")


def test_either_spelling_of_the_frame_rate(tmp_path):
    for key in ("mocap_framerate", "mocap_frame_rate", "fps"):
        content = fields("smpl")
        rate = content.pop("mocap_framerate")
        source = write(tmp_path / f"{key}.npz", content | {key: rate.astype(np.int64)})
        motion = Motion.load(source)
        assert motion.fps == 120.0
        motion.resample(60.0).save(tmp_path / "out.npz")
        with np.load(tmp_path / "out.npz") as out:
            assert out[key] == 60


def test_extras_follow_the_frames(tmp_path):
    content = fields("smplh") | {"label": np.arange(12)}
    motion = Motion.load(write(tmp_path / "a.npz", content))
    motion[2:8].save(tmp_path / "cut.npz")
    with np.load(tmp_path / "cut.npz") as out:
        assert np.array_equal(out["dmpls"], content["dmpls"][2:8])
        assert np.array_equal(out["label"], content["label"][2:8])
    motion.resample(240.0).save(tmp_path / "up.npz")
    with np.load(tmp_path / "up.npz") as out:
        assert out["dmpls"].shape == (23, 8)
        assert np.allclose(out["dmpls"][1], content["dmpls"][:2].mean(axis=0))
        assert np.array_equal(out["label"][::2], content["label"])
    x = Motion.load(write(tmp_path / "x.npz", fields("smplx")))
    x[:6].save(tmp_path / "x6.npz")
    with np.load(tmp_path / "x6.npz") as out:
        assert out["mocap_time_length"] == 6 / 120.0
        assert out["markers_latent"].shape == (41, 3)


def test_bent_fingers_survive_a_layout_without_fingers(tmp_path):
    content = fields("smpl", dtype=np.float32)
    motion = Motion.load(write(tmp_path / "a.npz", content))
    bent = motion.rotations.copy()
    bent[:, 40:] = 0.25
    corrected = motion.with_frames(motion.translation + 1e-9, bent)
    corrected.save(tmp_path / "b.npz")
    again = Motion.load(tmp_path / "b.npz")
    assert np.array_equal(again.rotations, bent)
    assert np.array_equal(again.translation, corrected.translation)  # float32 would lose 1e-9
    with np.load(tmp_path / "b.npz") as out:
        assert np.array_equal(
            out["poses"], content["poses"]
        )  # SMPL readers see the same, hands too
        stale = dict(out) | {"poses": out["poses"] + 1.0}
    with pytest.warns(HalfPhysicsWarning, match="does not belong to the poses"):
        edited = Motion.load(write(tmp_path / "c.npz", stale))
    assert not edited.rotations[:, 25:].any()


def test_a_motion_from_arrays_is_written_as_its_model(tmp_path):
    rng = np.random.default_rng(0)
    for model, width in WIDTHS.items():
        motion = Motion(np.zeros((4, 3)), rng.normal(0, 0.03, (4, 55, 3)), 30, model=model)
        motion.save(tmp_path / "a.npz")
        with np.load(tmp_path / "a.npz") as out:
            assert out["poses"].shape == (4, width)
            assert out["betas"].ndim == 1  # as the Blender add-on wants it
            assert str(out["gender"]) == "neutral"
        again = Motion.load(tmp_path / "a.npz")
        assert again.betas is None
        assert again.model == model
        assert np.array_equal(again.rotations, motion.rotations)


def test_another_format_can_be_asked_for(tmp_path):
    motion = Motion.load(write(tmp_path / "a.npz", fields("smplh")))
    motion.save(tmp_path / "b.npz", format="amass-smplx")
    again = Motion.load(tmp_path / "b.npz")
    assert again.origin.format == "amass-smplx"
    assert np.array_equal(again.rotations, motion.rotations)
    assert again.model == "smplh"  # the betas are still SMPL-H's
    with pytest.raises(InputError, match="format: found 'fbx', expected one of amass-smplx"):
        motion.save(tmp_path / "c.npz", format="fbx")


def test_saving_is_deterministic_and_whole(tmp_path):
    motion = Motion.load(write(tmp_path / "a.npz", fields()))
    motion.save(tmp_path / "b.npz")
    first = (tmp_path / "b.npz").read_bytes()
    motion.save(tmp_path / "b.npz")
    assert (tmp_path / "b.npz").read_bytes() == first
    (tmp_path / "plain").write_text("")
    assert stat.S_IMODE((tmp_path / "b.npz").stat().st_mode) == stat.S_IMODE(
        (tmp_path / "plain").stat().st_mode
    )
    with pytest.raises(FileError, match="does not exist"):
        motion.save(tmp_path / "none" / "c.npz")
    with pytest.raises(ValueError):  # an object array fails half way: the old file stays
        npz.write_npz(tmp_path / "b.npz", {"a": np.zeros(3), "b": np.array([{}], dtype=object)})
    assert (tmp_path / "b.npz").read_bytes() == first
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.npz", "b.npz", "plain"]


def test_parts_of_result_files_and_pickles_are_passed_over(tmp_path):
    content = fields() | {
        "object/ball/position": np.zeros((12, 3)),
        "markers_latent_vids": np.array({"a": 1}, dtype=object),
    }
    Motion.load(write(tmp_path / "a.npz", content)).save(tmp_path / "b.npz")
    with np.load(tmp_path / "b.npz") as out:
        assert set(out) == set(fields())


# -- axes ---------------------------------------------------------------------------------------


@settings(
    max_examples=20, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(seed=st.integers(0, 10_000))
def test_a_file_with_y_up_puts_the_same_vertices_into_the_world(tmp_path, seed):
    """The same movement written in a y-up file: all its vertices turned by -90 degrees about x."""
    body = Body.default()
    content = fields("smplh", frames=3, seed=seed)
    z_up = Motion.load(write(tmp_path / "z.npz", content))
    turn = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])  # (x, y, z) -> (x, z, -y)
    # A turned body has its pelvis at turn @ (J0 + trans); its file says J0 + trans_y.
    pelvis = body.rest_joints[0]
    root = rot.matrix_to_rotvec(turn @ rot.rotvec_to_matrix(content["poses"][:, :3]))
    content["trans"] = (content["trans"] + pelvis) @ turn.T - pelvis
    content["poses"] = np.concatenate([root, content["poses"][:, 3:]], axis=1)
    path = write(tmp_path / "y.npz", content)
    y_up = Motion.load(path, up="y")
    assert np.abs(body.vertices(y_up) - body.vertices(z_up)).max() < 1e-9
    assert np.abs(body.joints(y_up[1]) - body.joints(z_up[1])).max() < 1e-9  # a pose as well
    y_up.save(tmp_path / "back.npz")  # writers turn back
    with np.load(path) as old, np.load(tmp_path / "back.npz") as new:
        assert np.abs(new["trans"] - old["trans"]).max() < 1e-12
        assert np.abs(new["poses"][:, 3:] - old["poses"][:, 3:]).max() == 0.0
        assert np.abs(rot.exp(new["poses"][:, :3]) - rot.exp(old["poses"][:, :3])).max() < 1e-9


# -- what the caller says ------------------------------------------------------------------------


def test_the_caller_says_what_a_file_cannot(tmp_path):
    content = fields("smpl")
    del content["mocap_framerate"], content["gender"]
    path = write(tmp_path / "a.npz", content)
    with pytest.raises(FileError, match=r"no frame rate, found trans.*Say it with fps="):
        Motion.load(path, gender="male")
    with pytest.warns(HalfPhysicsWarning, match="no field 'gender'"):
        assert Motion.load(path, fps=50).gender == "neutral"
    motion = Motion.load(path, fps=50, gender="male", model="smplh", frames=(2, 6))
    assert (motion.fps, motion.gender, motion.model, len(motion)) == (50.0, "male", "smplh", 4)
    motion.save(tmp_path / "b.npz")
    assert Motion.load(tmp_path / "b.npz").gender == "male"


def test_mean_hands_are_stored_flat_and_written_back(tmp_path, monkeypatch):
    mean = np.linspace(-0.5, 0.5, 90)
    asked = {}

    def load(path, **options):
        asked.update(path=str(path), **options)
        return SimpleNamespace(hands_mean=mean)

    monkeypatch.setattr(Body, "load", staticmethod(load), raising=False)
    content = fields("smplh")
    path = write(tmp_path / "a.npz", content)
    (tmp_path / "SMPLH_FEMALE.npz").write_bytes(b"model")
    motion = Motion.load(path, hands="mean", model=tmp_path / "SMPLH_FEMALE.npz")
    # A file is taken as it is named; of a folder, the one of the clip's gender.
    assert asked == {"path": str(tmp_path / "SMPLH_FEMALE.npz"), "gender": None}
    Motion.load(path, hands="mean", model=tmp_path)
    assert asked == {"path": str(tmp_path), "gender": "female"}
    assert np.array_equal(motion.poses[:, 75:], content["poses"][:, 66:] + mean)
    assert motion.model == "smplh"
    motion.save(tmp_path / "b.npz")
    with np.load(tmp_path / "b.npz") as out:
        assert np.abs(out["poses"] - content["poses"]).max() < 1e-14  # added, taken away
    smpl = write(tmp_path / "c.npz", fields("smpl"))
    with pytest.raises(InputError, match="has no fingers"):
        Motion.load(smpl, hands="mean", model=tmp_path / "SMPLH_FEMALE.npz")


def test_body_only_files_need_a_model(tmp_path):
    content = fields("smpl")
    content["poses"] = content["poses"][:, :66]
    path = write(tmp_path / "a.npz", content)
    with pytest.raises(FileError, match="Say it with model='smplx'"):
        Motion.load(path)
    motion = Motion.load(path, model="smplx")
    assert motion.model == "smplx"
    motion.save(tmp_path / "b.npz")
    same(path, tmp_path / "b.npz")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"up": "x"}, "up: found 'x'"),
        ({"hands": "pca"}, "hands: found 'pca'"),
        ({"fps": -1}, "fps: found -1"),
        ({"gender": "f"}, "gender: found 'f'"),
        ({"model": "nowhere.npz"}, "model: found 'nowhere.npz'"),
        ({"hands": "mean"}, "Name it with model="),
    ],
)
def test_impossible_options(tmp_path, options, message):
    path = write(tmp_path / "a.npz", fields())
    with pytest.raises(InputError, match=message):
        Motion.load(path, **options)


def test_betas_of_any_shape_but_one_per_person(tmp_path):
    base = fields("smplh")
    tiled = np.tile(base["betas"][:10], (12, 1))
    for betas in (base["betas"][:10], base["betas"][None, :10], tiled):
        path = write(tmp_path / "a.npz", base | {"betas": betas})
        motion = Motion.load(path)
        assert np.array_equal(motion.betas, base["betas"][:10])
        motion.save(tmp_path / "b.npz")
        same(path, tmp_path / "b.npz")
    assert Motion.load(write(tmp_path / "a.npz", base | {"betas": np.zeros(0)})).betas is None
    tiled[3, 2] += 0.1
    with pytest.raises(FileError, match="'betas: the shape changes over the frames"):
        Motion.load(write(tmp_path / "a.npz", base | {"betas": tiled}))


# -- what is refused ------------------------------------------------------------------------------


def _broken(key, value):
    content = fields("smplh")
    if value is None:
        del content[key]
    else:
        content[key] = value(content[key])
    return content


def _nan(array):
    array = array.copy()
    array[7, 1] = np.nan
    return array


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (_broken("trans", None), r"'trans' is missing, found poses .*expected trans \(T, 3\)"),
        (_broken("trans", lambda a: a[:, :2]), r"field 'trans': found shape \(12, 2\)"),
        (_broken("trans", lambda a: a[:5]), "'trans' has 5 frames and the poses 12"),
        (_broken("trans", lambda a: a * 1000), "root moves at .* m/s.*metres"),
        (_broken("poses", lambda a: a[:, :140]), r"'poses': found shape \(12, 140\), expected"),
        (_broken("poses", _nan), "'poses': 1 values are NaN or infinite, the first in frame 7"),
        (_broken("poses", lambda a: a.astype(str)), "field 'poses': found shape .* of <U"),
        (_broken("mocap_framerate", lambda a: a * 0), "'mocap_framerate': found 0.0"),
        (_broken("gender", lambda a: np.array("unknown")), "field 'gender': found 'unknown'"),
        (_broken("gender", lambda a: np.array({"a": 1})), "'gender' holds Python objects"),
        ({"poses": np.zeros((1, 72)), "trans": np.zeros((1, 3)), "fps": 30.0, "gender": "male"},
         r"found 1 frame\(s\), expected at least 2"),
        ({"v_template": np.zeros((5, 3)), "J_regressor": np.zeros(3)}, "this is a body model"),
        ({"something": np.zeros(3)}, r"no known motion format. Found an .npz with something"),
    ],
)  # fmt: skip
def test_broken_files_name_file_and_field(tmp_path, content, message):
    path = write(tmp_path / "clip.npz", content)
    with pytest.raises(FileError, match=message) as caught:
        Motion.load(path)
    assert "clip.npz" in str(caught.value)


def test_degrees_are_suspected(tmp_path):
    path = write(tmp_path / "a.npz", _broken("poses", lambda a: np.degrees(a)))
    with pytest.warns(HalfPhysicsWarning, match="Are these degrees") as caught:
        Motion.load(path)
    assert caught[0].filename == __file__


def test_missing_empty_and_foreign_files(tmp_path):
    write(tmp_path / "walk.npz", fields())
    with pytest.raises(FileError, match=r"no such file. In that folder: walk.npz"):
        Motion.load(tmp_path / "wlk.npz")
    with pytest.raises(FileError, match="this is a folder"):
        Motion.load(tmp_path)
    (tmp_path / "empty.npz").write_bytes(b"")
    with pytest.raises(FileError, match="the file is empty"):
        Motion.load(tmp_path / "empty.npz")
    (tmp_path / "text.npz").write_text("hello")
    with pytest.raises(
        FileError, match=r"no known motion format. Found a file that begins with b.hello"
    ):
        Motion.load(tmp_path / "text.npz")


def test_damaged_archives_are_refused_at_every_length(tmp_path):
    whole = write(tmp_path / "a.npz", fields("smplh")).read_bytes()
    path = tmp_path / "cut.npz"
    for length in range(1, len(whole), max(1, len(whole) // 40)):
        path.write_bytes(whole[:length])
        with pytest.raises(FileError):
            Motion.load(path)
    rng = np.random.default_rng(0)
    for _ in range(60):  # bytes flipped anywhere: an error of ours, or a value that was not used
        bad = bytearray(whole)
        bad[rng.integers(len(bad))] ^= 1 << rng.integers(8)
        path.write_bytes(bytes(bad))
        with contextlib.suppress(HalfPhysicsError, HalfPhysicsWarning):
            Motion.load(path)


def test_bombs_are_refused_before_they_unpack(tmp_path):
    path = tmp_path / "bomb.npz"
    header = io.BytesIO()
    np.lib.format.write_array_header_1_0(
        header, {"descr": "<f8", "fortran_order": False, "shape": (10**12, 165)}
    )
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("trans.npy", header.getvalue())
        archive.writestr("poses.npy", header.getvalue())
        archive.writestr("mocap_framerate.npy", header.getvalue())
    with pytest.raises(FileError, match=r"bomb\.npz"):  # a header that promises terabytes
        Motion.load(path)
    entry = zipfile.ZipInfo("poses.npy")
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr(entry, header.getvalue())
        entry.file_size = npz.MAX_BYTES + 1  # the directory says so
    with pytest.raises(FileError, match="unpacks to"):
        Motion.load(path)


def test_formats_have_what_a_registry_needs():
    for name, format in FORMATS.items():
        assert format.name == name
        assert format.expects


# -- the real thing --------------------------------------------------------------------------


def test_real_clips_come_back_bit_for_bit(shared_data, tmp_path):
    clips = sorted((shared_data / "motion").glob("*.npz"))
    assert clips
    body = Body.default()
    for clip in clips:
        motion = Motion.load(clip)
        assert motion.model == "smpl"
        motion.save(tmp_path / "b.npz")
        same(clip, tmp_path / "b.npz")
        some = range(0, len(motion), 40)
        before = body.vertices(motion, frames=some)
        after = body.vertices(Motion.load(tmp_path / "b.npz"), frames=some)
        assert np.abs(after - before).max() <= 1e-9
        sixty = motion.resample(60.0).resample(30.0)
        assert np.array_equal(sixty.rotations, motion.rotations)
        assert np.array_equal(sixty.translation, motion.translation)


def test_ten_thousand_frames_load_in_a_tenth_of_a_second(tmp_path):
    motion = Motion(np.zeros((10_000, 3)), np.tile(np.linspace(0, 1, 165), (10_000, 1)), 120.0)
    own = {"poses": motion.poses, "trans": motion.translation}
    path = write(tmp_path / "a.npz", fields(frames=10_000) | own)

    def seconds() -> float:
        start = time.process_time()
        Motion.load(path)
        return time.process_time() - start

    assert min(seconds() for _ in range(5)) < 0.1
