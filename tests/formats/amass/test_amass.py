"""AMASS files in their SMPL-X, SMPL-H and SMPL layouts: fields read and written."""

from __future__ import annotations

import stat

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from halfphysics.base import npz
from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.errors import FileError, HalfPhysicsWarning, InputError
from halfphysics.formats import FORMATS
from halfphysics.motion import skeleton
from halfphysics.motion.motion import Motion
from support.calls import calls
from support.files.amass_files import WIDTHS, fields, same, write
from support.files.layouts import UPRIGHT


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
    poses[:, 0] += np.pi / 2  # upright
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
        stale = dict(out) | {"poses": out["poses"] + 0.01}
    with pytest.warns(HalfPhysicsWarning, match="does not belong to the poses"):
        edited = Motion.load(write(tmp_path / "c.npz", stale))
    assert not edited.rotations[:, 25:].any()


def test_a_motion_from_arrays_is_written_as_its_model(tmp_path):
    rng = np.random.default_rng(0)
    for model, width in WIDTHS.items():
        rotations = rng.normal(0, 0.03, (4, 55, 3))
        rotations[:, 0] += UPRIGHT["z"]
        motion = Motion(np.zeros((4, 3)), rotations, 30, model=model)
        motion.save(tmp_path / "a.npz")
        with np.load(tmp_path / "a.npz") as out:
            assert out["poses"].shape == (4, width)
            assert out["betas"].ndim == 1  # as the Blender add-on requires it
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
    with pytest.raises(InputError, match=r"format: found 'fbx', expected one of .*amass-smplx"):
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
    with pytest.raises(ValueError):  # an object array fails half way: the old file is kept
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


@settings(
    max_examples=20, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(seed=st.integers(0, 10_000))
def test_a_file_with_y_up_puts_the_same_vertices_into_the_world(tmp_path, seed):
    """The same movement written in a y-up file: all its vertices turned by -90 degrees about x."""
    body = Body.default()
    content = fields("smplh", frames=3, seed=seed)
    z_up = Motion.load(write(tmp_path / "z.npz", content), up="z")
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
    y_up.save(tmp_path / "back.npz")  # the directory says so
    with np.load(path) as old, np.load(tmp_path / "back.npz") as new:
        assert np.abs(new["trans"] - old["trans"]).max() < 1e-12
        assert np.abs(new["poses"][:, 3:] - old["poses"][:, 3:]).max() == 0.0
        assert np.abs(rot.exp(new["poses"][:, :3]) - rot.exp(old["poses"][:, :3])).max() < 1e-9


def test_formats_have_what_a_registry_needs():
    for name, format in FORMATS.items():
        assert format.name == name
        assert format.expects


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


def test_ten_thousand_frames_load_at_once(tmp_path):
    """No loop runs over the frames: ten times as many take hardly more calls."""

    def steps(frames: int) -> int:
        rotations = np.tile(np.linspace(0, 0.2, 165), (frames, 1))
        rotations[:, :3] += UPRIGHT["z"]
        motion = Motion(np.tile([0.0, 0.0, 1.0], (frames, 1)), rotations, 120.0)
        own = {"poses": motion.poses, "trans": motion.translation}
        path = write(tmp_path / f"{frames}.npz", fields(frames=frames) | own)
        Motion.load(path)  # what is imported late
        return calls(lambda: Motion.load(path))

    # Large arrays come off the disk in parts.
    assert steps(10_000) < steps(1000) + 1000
