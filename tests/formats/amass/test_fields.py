"""Fields of AMASS files: options of the caller, and refused fields."""

from __future__ import annotations

import contextlib
import io
import pickle
import zipfile
from types import SimpleNamespace

import numpy as np
import pytest

from halfphysics.base import npz
from halfphysics.body.body import Body
from halfphysics.errors import FileError, HalfPhysicsError, HalfPhysicsWarning, InputError
from halfphysics.motion.motion import Motion
from support.files.amass_files import fields, same, write


def test_the_caller_says_what_a_file_cannot(tmp_path):
    content = fields("smpl")
    del content["mocap_framerate"], content["gender"]
    path = write(tmp_path / "a.npz", content)
    with pytest.warns(HalfPhysicsWarning, match=r"frame rate: taken as 30\. Say it with fps="):
        assert Motion.load(path, gender="male").fps == 30.0
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
    # A file is taken as named; from a folder, the file of the clip's gender.
    assert asked == {"path": str(tmp_path / "SMPLH_FEMALE.npz"), "gender": None}
    Motion.load(path, hands="mean", model=tmp_path)
    assert asked == {"path": str(tmp_path), "gender": "female"}
    assert np.array_equal(motion.poses[:, 75:], content["poses"][:, 66:] + mean)
    assert motion.model == "smplh"
    motion.save(tmp_path / "b.npz")
    with np.load(tmp_path / "b.npz") as out:
        assert np.abs(out["poses"] - content["poses"]).max() < 1e-14  # added, then subtracted
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
        ({"up": "w"}, "up: found 'w', expected one of 'z', 'y', '-y'"),
        ({"floor": "soles"}, "floor: expected a number.*'soles', or 'lowest'"),
        ({"floor": float("nan")}, "floor: expected a number.*or 'lowest'"),
        ({"hands": "pca"}, "hands: found 'pca'"),
        ({"fps": -1}, "fps: found -1"),
        ({"gender": "f"}, "gender: found 'f'"),
        ({"up": np.zeros(2)}, r"up: found array\(.*expected one of 'z'"),
        ({"floor": np.zeros(2)}, r"floor: expected a number.*found array\(.*or 'lowest'"),
        ({"hands": np.zeros(2)}, r"hands: found array\(.*expected 'flat' or 'mean'"),
        ({"gender": np.array(["male"] * 2)}, r"gender: found array\(.*expected one of neutral"),
        ({"model": np.zeros(2)}, r"path: expected the path of a file.*found array\("),
        ({"clip": np.zeros(2)}, r"clip: found array\("),
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
    with pytest.raises(FileError, match="field 'betas': the shape changes over the frames"):
        Motion.load(write(tmp_path / "a.npz", base | {"betas": tiled}))


@pytest.mark.parametrize("name", ["poses", "fullpose", "pose"])
def test_amass_in_a_pickle_or_by_another_name_says_how_to_save_it(tmp_path, name):
    content = fields("smplh")
    poses = content.pop("poses")
    (tmp_path / "a.pkl").write_bytes(pickle.dumps(content | {name: poses}, 2))
    (tmp_path / "b.pkl").write_bytes(pickle.dumps(content | {name: [*poses[:-1], poses[-1][:9]]}))
    with pytest.raises(FileError, match="no known motion format"):
        Motion.load(tmp_path / "b.pkl")
    said = r"numpy\.savez\(path, \*\*fields\)\)" + (
        "" if name == "poses" else f" with '{name}' named"
    )
    with pytest.raises(FileError, match=rf"These are AMASS's fields: save .* \({said}"):
        Motion.load(tmp_path / "a.pkl")
    if name != "poses":
        with pytest.raises(
            FileError, match=rf"but for '{name}': name it 'poses'\. Expected one of"
        ):
            Motion.load(write(tmp_path / "a.npz", content | {name: poses}))


def test_words_and_numbers_in_python_objects_are_read(tmp_path):
    content = fields("smplh")
    plain = Motion.load(write(tmp_path / "a.npz", content))
    keys = ("gender", "mocap_framerate", "betas")
    objects = {key: np.array(content[key].tolist(), dtype=object) for key in keys}
    motion = Motion.load(write(tmp_path / "b.npz", content | objects))
    assert (motion.gender, motion.fps) == (plain.gender, plain.fps)
    assert np.array_equal(motion.betas, plain.betas)
    nothing = {key: np.array(None) for key in keys}
    with pytest.warns(
        HalfPhysicsWarning, match=r"no gender in field 'gender'|frame rate: taken as 30"
    ):
        motion = Motion.load(write(tmp_path / "c.npz", content | nothing))
    assert (motion.gender, motion.fps, motion.betas) == ("neutral", 30.0, None)
    ragged = np.array([[0.0], [1.0, 2.0]], dtype=object)
    with pytest.raises(FileError, match=r"'betas' holds Python objects.*Save it as a plain"):
        Motion.load(write(tmp_path / "d.npz", content | {"betas": ragged}))


@pytest.mark.parametrize("model", ["smplx", "smplh", "smpl"])
def test_joints_may_have_an_axis_of_their_own(tmp_path, model):
    content = fields(model)
    plain = Motion.load(write(tmp_path / "a.npz", content))
    keys = [key for key in ("poses", "pose_body", "pose_hand", "pose_eye") if key in content]
    apart = {key: content[key].reshape(len(plain), -1, 3) for key in keys}
    motion = Motion.load(write(tmp_path / "b.npz", content | apart))
    assert np.array_equal(motion.rotations, plain.rotations)
    motion.save(tmp_path / "c.npz")
    same(tmp_path / "b.npz", tmp_path / "c.npz")
    if model == "smplx":  # the parts alone
        del content["poses"], apart["poses"]
        motion = Motion.load(write(tmp_path / "d.npz", content | apart))
        assert np.array_equal(motion.rotations, plain.rotations)


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


def test_degrees_are_read_as_such_or_suspected(tmp_path):
    path = write(tmp_path / "a.npz", _broken("poses", lambda a: np.degrees(a)))
    with pytest.warns(HalfPhysicsWarning, match="rotations are in degrees, and read as") as caught:
        found = Motion.load(path)
    assert caught[0].filename == __file__
    radians = Motion.load(write(tmp_path / "b.npz", fields("smplh")))
    assert np.abs(found.rotations - radians.rotations).max() < 1e-14
    one = fields("smplh")
    one["poses"][5:, 3 * 18] = 90.0  # a fault of the record, perhaps
    with pytest.warns(HalfPhysicsWarning, match="Are these degrees"):
        Motion.load(write(tmp_path / "c.npz", one))


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
    for _ in range(60):  # flipped bytes: an error of ours, or an unused value
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


def test_joints_that_a_file_had_no_field_for_are_written_whole(tmp_path):
    """Split fields without `poses` and without hands: a bent finger is not lost without a word."""
    content = fields()
    content = {k: v for k, v in content.items() if k not in ("poses", "pose_hand", "pose_eye")}
    motion = Motion.load(write(tmp_path / "a.npz", content))
    rotations = np.array(motion.rotations)
    rotations[:, 30, 2] = 0.4
    motion.with_frames(motion.translation, rotations).save(tmp_path / "b.npz")
    again = Motion.load(tmp_path / "b.npz")
    np.testing.assert_allclose(again.rotations, rotations, atol=1e-12)


def test_a_part_of_a_file_says_how_long_it_is(tmp_path):
    whole = write(tmp_path / "a.npz", fields(frames=60))
    Motion.load(whole, frames=(0, 30)).save(tmp_path / "part.npz")
    Motion.load(whole).save(tmp_path / "whole.npz")
    with np.load(tmp_path / "part.npz") as part, np.load(tmp_path / "whole.npz") as all_of_it:
        assert part["mocap_time_length"] == pytest.approx(30 / 120.0)
        assert all_of_it["mocap_time_length"] == 60 / 120.0
