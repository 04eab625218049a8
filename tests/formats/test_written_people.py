"""What is written into files of estimators, field by field, against what their programs write."""

from __future__ import annotations

import base64
import io
import json
import pickle
import warnings

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base import torch_file
from halfphysics.base.axes import axes_of
from halfphysics.formats import FORMATS, Source, losses, save_people
from halfphysics.formats.written_people import written as people_written
from halfphysics.motion import skeleton
from halfphysics.motion.file_metadata import FileMetadata
from support.files import video_files as files
from support.files.dumps import torch_dict
from support.files.layouts import movement
from support.files.video_files import two

pytestmark = pytest.mark.filterwarnings("ignore::halfphysics.errors.HalfPhysicsWarning")

#: Numbers of files in single precision, and rotation vectors of two conversions.
SINGLE = 1e-6


def content(path):
    if path.suffix == ".pt":
        return torch_file.read(path)
    with path.open("rb") as handle:
        return pickle.load(handle)  # the test's own file


def written(source, tmp_path, clips):
    """The people of a file, each read alone with all of their frames, written into one."""
    motions = [hp.Motion.load(source, clip=clip) for clip in clips]
    (path,) = save_people(motions, tmp_path / f"out{source.suffix}", [None] * len(motions))
    return content(path)


def same(found, asked, rows=slice(None)):
    assert np.abs(np.asarray(found)[rows] - asked).max() < SINGLE


def seen_rows(who):
    """Rows of the frames in which somebody was seen, in a file without gaps."""
    return who.frames - who.frames[0]


def test_wham(tmp_path):
    people = two(22)
    source = files.joblib_file(tmp_path / "wham_output.pkl", files.wham_data(people))
    found, asked = written(source, tmp_path, ["3", "8"]), files.wham_data(people)
    assert list(found) == [3, 8]
    for who in people:
        own, rows = found[int(who.name)], seen_rows(who)
        assert own["frame_ids"].tolist() == list(range(who.frames[0], who.frames[-1] + 1))
        for key in ("pose_world", "trans_world"):
            same(own[key], asked[int(who.name)][key], rows)
        same(own["betas"], np.tile(who.betas, (len(own["betas"]), 1)))


def test_prompthmr(tmp_path):
    people = two()
    source = files.joblib_file(tmp_path / "results.pkl", files.prompthmr_data(people))
    found = written(source, tmp_path, ["3", "8"])["people"]
    asked = files.prompthmr_data(people)["people"]
    assert list(found) == [3, 8]
    for who, truth in zip(people, asked.values(), strict=True):
        own, rows = found[int(who.name)], seen_rows(who)
        assert own["track_id"] == int(who.name)
        assert own["frames"][rows].tolist() == who.frames.tolist()
        for key in ("pose", "trans"):
            same(own["smplx_world"][key], truth["smplx_world"][key], rows)


def test_comotion(tmp_path):
    people = two(22)
    source = torch_dict(tmp_path / "clip.pt", files.comotion_data(people))
    found, asked = written(source, tmp_path, ["3", "8"]), files.comotion_data(people)
    assert found["id"].dtype == np.int64
    for who in people:
        own, theirs = found["id"] == int(who.name), asked["id"] == int(who.name)
        rows = seen_rows(who)
        assert found["frame_idx"][own][rows].tolist() == who.frames.tolist()
        for key in ("pose", "trans"):
            same(found[key][own], asked[key][theirs], rows)


def test_gvhmr_in_the_world_and_before_a_camera(tmp_path):
    (who, _) = two(22)
    for key in ("smpl_params_global", "smpl_params_incam"):
        asked = {key: files.gvhmr_data(who)[key]}
        source = torch_dict(tmp_path / "hmr4d_results.pt", asked)
        found = written(source, tmp_path, [None])
        assert list(found) == [key]
        for name, values in asked[key].items():
            if name != "betas":
                same(found[key][name], values)


def test_phalp(tmp_path):
    people = two(22)
    source = files.joblib_file(tmp_path / "demo.pkl", files.phalp_data(people))
    found, asked = written(source, tmp_path, ["3", "8"]), files.phalp_data(people)
    assert [frame["time"] for frame in found.values()] == list(range(2, 14))  # with people in them
    for own, theirs in zip(found.values(), list(asked.values())[2:], strict=True):
        for k, number in enumerate(theirs["tid"]):  # people in gaps are in the file, too
            row = own["tid"].index(number)
            same(own["camera"][row], theirs["camera"][k])
            for key in ("global_orient", "body_pose"):
                assert own["smpl"][row][key].shape == theirs["smpl"][k][key].shape
                same(own["smpl"][row][key], theirs["smpl"][k][key])


def test_romp(tmp_path):
    people = two(22)
    asked = files.romp_video(people)
    source = files.objects(tmp_path / "video_results.npz", asked)
    motions = [hp.Motion.load(source, clip=clip) for clip in ("3", "8")]
    (path,) = save_people(motions, tmp_path / "out.npz", [None, None])
    with np.load(path, allow_pickle=True) as stored:  # the test's own file
        found = {key: stored[key][()] for key in stored.files}
    for number, theirs in asked["sequence_results"].items():
        own = found["sequence_results"][number]
        rows = [own["frame_id"].index(frame) for frame in theirs["frame_id"]]
        for key in ("smpl_thetas", "cam_trans"):
            same(np.stack(own[key]), np.stack(theirs[key]), rows)
    names = sorted(found["results"])
    assert names[0] == "00000002.png"
    assert found["results"]["00000007.png"]["smpl_thetas"].shape == (2, 72)
    again = save_people(motions, tmp_path / "again.npz", [None, None])[0]
    assert again.read_bytes() == path.read_bytes()


def test_slahmr(tmp_path):
    """Places are over another origin, as the plane says: the people and their floor agree."""
    people = [files.person(name, np.arange(14), seed, 22) for seed, name in enumerate("12", 1)]
    asked = files.slahmr_data(people)
    np.savez(tmp_path / "a_world_results.npz", **asked)
    motions = [hp.Motion.load(tmp_path / "a_world_results.npz", clip=clip) for clip in ("0", "1")]
    (path,) = save_people(motions, tmp_path / "out.npz", [None, None])
    with np.load(path) as stored:
        found = dict(stored)
    for key in ("root_orient", "pose_body", "betas"):
        same(found[key], asked[key])
    given, made = asked["floor_plane"][0], found["floor_plane"][0]
    normal = given / np.linalg.norm(given) * np.sign(-given[1])
    same(made / np.linalg.norm(made), normal)
    over = [
        np.einsum("btj,j->bt", fields["trans"], normal) - plane @ normal
        for fields, plane in ((found, made), (asked, given))
    ]
    same(over[0], over[1])
    short = motions[1][:5]
    with pytest.raises(hp.errors.InputError, match="as many frames for everybody"):
        save_people([motions[0], short], tmp_path / "b.npz", [None, None])
    assert not (tmp_path / "b.npz").exists()


def test_mcs(tmp_path):
    people = [files.person(name, np.arange(14)[k:], k + 1, 22) for k, name in enumerate("12")]
    source = files.mcs(tmp_path / "world4d.mcs", people)
    motions = [hp.Motion.load(source, clip=clip) for clip in ("1", "2")]
    (path,) = save_people(motions, tmp_path / "out.mcs", [None, None])
    document = json.loads(path.read_text())
    scene = document["scenes"][0]["extensions"]["MC_scene_description"]
    assert scene["num_frames"] == 14
    assert [own["frame_presence"] for own in scene["smpl_bodies"]] == [[0, 14], [1, 14]]
    for who, own in zip(people, scene["smpl_bodies"], strict=True):
        view = document["bufferViews"][own["bufferView"]]
        data = base64.b64decode(document["buffers"][view["buffer"]]["uri"].partition("base64,")[2])
        assert len(data) == view["byteLength"]
        with np.load(io.BytesIO(data)) as stored:
            same(stored["bodyTranslation"], who.translation)
            same(stored["bodyPose"], who.rotations[:, :22])
            assert stored["frameRate"] == 25.0


@pytest.mark.parametrize("format", ["wham", "prompthmr", "phalp", "comotion", "romp"])
@pytest.mark.parametrize("names", [("1", "x"), ("007", "7"), ("x", "1"), ("1000000", "1234567")])
def test_nobody_is_lost_for_a_name(tmp_path, format, names):
    """Names that are no numbers get one that nobody has; numbers stay."""
    people = []
    for name, who in zip(names, two(22), strict=True):
        own = FileMetadata(format=format, fields={"track": name})
        motion = hp.Motion(who.translation, who.rotations, 30.0, axes=axes_of("-y"), origin=own)
        people.append(motion)
    suffix = FORMATS[format].suffixes[0]
    (path,) = save_people(people, tmp_path / f"a{suffix}", [None, None], format=format)
    found = [track.name for track in FORMATS[format].people(Source(path))]
    assert len(found) == 2
    kept = [str(int(name)) for name in names if name.isdecimal()]
    assert set(kept) <= set(found)


def test_a_slahmr_file_beside_the_original_is_read_whole(tmp_path):
    """The tracks of the original are of other frames."""
    people = [files.person(name, np.arange(14), seed, 22) for seed, name in enumerate("12", 1)]
    np.savez(tmp_path / "a_world_results.npz", **files.slahmr_data(people))
    seen = {"vis_mask": [0] * 4 + [1] * 10}
    tracks = {"007": {"index": 0, **seen}, "8": {"index": 1, **seen}}
    info = {"tracks": tracks, "meta": {"data_interval": [0, 14]}}
    (tmp_path / "track_info.json").write_text(json.dumps(info))
    motion = hp.Motion.load(tmp_path / "a_world_results.npz", clip="007", frames=(2, 9))
    motion.save(tmp_path / "out.npz")
    back, body = hp.Motion.load(tmp_path / "out.npz"), hp.Body.default()
    assert np.abs(body.vertices(back) - body.vertices(motion)).max() < 1e-5


def test_a_slahmr_file_without_its_floor_comes_back_where_it_was(tmp_path):
    who = files.person("1", np.arange(14), 1, 22)
    np.savez(tmp_path / "a_world_results.npz", **files.slahmr_data([who]))
    motion = hp.Motion.load(tmp_path / "a_world_results.npz", up="-y")
    motion.save(tmp_path / "out.npz")
    with np.load(tmp_path / "out.npz") as stored:
        assert "floor_plane" not in stored
    back, body = hp.Motion.load(tmp_path / "out.npz", up="-y"), hp.Body.default()
    assert np.abs(body.vertices(back) - body.vertices(motion)).max() < 1e-5


def test_hips_are_those_with_which_the_file_is_read(tmp_path):
    """Whatever body moved so."""
    source = files.joblib_file(tmp_path / "wham_output.pkl", files.wham_data(two(22)))
    motion = hp.Motion.load(source, clip="8")
    motion.save(tmp_path / "out.pkl", body=hp.Body.default(stature=1.9))
    back = hp.Motion.load(tmp_path / "out.pkl")
    assert np.abs(back.translation - motion.translation).max() < SINGLE


def test_centimetres_are_written_as_metres(tmp_path):
    """Raised, they would be no centimetres any more to whoever reads them."""
    (who, _) = two(22)
    own = FileMetadata(format="prompthmr", fields={"unit": 0.01})
    motion = hp.Motion(who.translation, who.rotations, 30.0, axes=axes_of("y"), origin=own)
    motion.save(tmp_path / "a.pkl")
    (person,) = content(tmp_path / "a.pkl")["people"].values()
    same(person["smplx_world"]["trans"], motion.in_file_axes()[0])


def test_frames_that_were_cut_keep_their_numbers(tmp_path):
    source = files.joblib_file(tmp_path / "wham_output.pkl", files.wham_data(two(22)))
    motion = hp.Motion.load(source, clip="8", frames=(3, None))
    motion.save(tmp_path / "out.pkl")
    (own,) = content(tmp_path / "out.pkl").values()
    assert own["frame_ids"].tolist() == list(range(9, 14))


def test_what_such_a_file_cannot_hold_is_said(tmp_path):
    rotations = np.zeros((3, 55, 3))
    rotations[:, skeleton.LEFT_HAND_JOINTS[0]] = 0.3
    motion = hp.Motion(np.zeros((3, 3)), rotations, 60.0, betas=np.ones(16), gender="female")
    assert losses(motion, tmp_path / "a.pt", "gvhmr") == [
        "the fingers",
        "the gender 'female'",
        "betas beyond the first 10",
        "the frame rate 60: readers take 30; say motion.resample(30)",
    ]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert losses(motion, tmp_path / "a.pkl", "prompthmr")[0] == "the gender 'female'"


def test_a_slice_knows_where_in_its_video_it_begins():
    origin = FileMetadata(format="wham", fields={"first": 100})
    motion = hp.Motion(*movement(20), 30.0, origin=origin)
    frames = people_written([motion[5:15]], "wham")["0"].frames
    np.testing.assert_array_equal(frames, np.arange(105, 115))
    assert motion.origin.fields["first"] == 100


@pytest.mark.parametrize(
    ("change", "first", "length"),
    [
        (lambda motion: motion[4::2], 52, 8),
        (lambda motion: motion[::-1], 100, 20),
        (lambda motion: motion[15:5:-2], 54, 5),
        (lambda motion: motion.resample(60.0), 200, 39),
        (lambda motion: motion.resample(60.0).resample(30.0), 100, 20),
        (lambda motion: motion.resample(24.0), 80, 16),
    ],
)
def test_numbers_of_frames_are_those_of_a_video_at_the_new_rate(change, first, length):
    """People who were seen at different times stay so: their numbers are divided alike."""
    origin = FileMetadata(format="wham", fields={"first": 100})
    motion = change(hp.Motion(*movement(20), 30.0, origin=origin))
    frames = people_written([motion], "wham")["0"].frames
    np.testing.assert_array_equal(frames, np.arange(first, first + length))


@pytest.mark.parametrize("first", range(90, 100))
def test_half_numbers_of_frames_keep_people_apart(first):
    """Two frames apart are one at half the rate, wherever they begin."""
    found = []
    for number in (first, first + 2):
        origin = FileMetadata(format="wham", fields={"first": number})
        found.append(hp.Motion(*movement(20), 30.0, origin=origin)[::2].origin.fields["first"])
    assert found[1] - found[0] == 1
