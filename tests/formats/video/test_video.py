"""Estimators of people in video: every layout is read as it was written, or ends in one message."""

from __future__ import annotations

import json
import pickle
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.base.axes import axes_of
from halfphysics.errors import HalfPhysicsWarning
from halfphysics.formats import Source, identify
from support.files import video_files as files
from support.files.dumps import Inline, npy_of, pickled, torch_dict
from support.files.layouts import quiet
from support.files.model_files import fields as model_fields
from support.files.model_files import write_npz
from support.files.video_files import Person, person, two
from support.files.wrong_files import Boom, broken_bytes_are_refused, refused

#: Files are in single precision, people within some metres [m].
SINGLE = 1e-5


@dataclass(frozen=True)
class Layout:
    """A layout: how people are written, and what is known of them then."""

    write: Callable[[Path, list[Person]], Path]
    format: str
    joints: int = 55
    rate: float = 30.0
    #: Gaps in the frames of a track are in the file.
    gaps: bool = True
    #: People's names in the file, if not their own.
    names: tuple[str, str] = ("3", "8")
    betas: int = 10


def _bedlam(joints: int) -> Callable[[Path, list[Person]], Path]:
    def write(folder: Path, people: list[Person]) -> Path:
        np.savez(folder / "images.npz", **files.bedlam_data(people, joints))
        return folder / "images.npz"

    return write


def _slahmr(folder: Path, people: list[Person]) -> Path:
    """Everyone has all frames; those without a person are invented, and said to be."""
    whole = [person(who.name, np.arange(14), seed, 22) for seed, who in enumerate(people, 1)]
    np.savez(folder / "clip_000300_world_results.npz", **files.slahmr_data(whole))
    tracks = {
        who.name: {
            "index": row,
            "vis_mask": np.isin(np.arange(14), who.frames).astype(int).tolist(),
        }
        for row, who in enumerate(people)
    }
    meta = {"seq_interval": [0, 14], "data_interval": [0, 14]}
    (folder / "track_info.json").write_text(json.dumps({"tracks": tracks, "meta": meta}))
    return folder / "clip_000300_world_results.npz"


LAYOUTS = {
    "gvhmr": Layout(
        lambda f, p: files.gvhmr(f / "hmr4d_results.pt", p[0]), "gvhmr", joints=22, gaps=False
    ),
    "wham": Layout(
        lambda f, p: files.joblib_file(f / "wham_output.pkl", files.wham_data(p)), "wham", 22
    ),
    "prompthmr": Layout(
        lambda f, p: files.joblib_file(f / "results.pkl", files.prompthmr_data(p)), "prompthmr"
    ),
    "mcs": Layout(
        lambda f, p: files.mcs(f / "world4d.mcs", p), "mcs", 22, 25.0, gaps=False, names=("1", "2")
    ),
    "tram": Layout(lambda f, p: files.tram(f / "clip", p), "tram", 22, names=("0", "1")),
    "phalp": Layout(
        lambda f, p: files.joblib_file(f / "demo_clip.pkl", files.phalp_data(p)), "phalp", 22
    ),
    "comotion": Layout(
        lambda f, p: torch_dict(f / "clip.pt", files.comotion_data(p)), "comotion", 22
    ),
    "slahmr": Layout(_slahmr, "slahmr", 22, betas=16),
    "romp": Layout(
        lambda f, p: files.objects(f / "video_results.npz", files.romp_video(p)), "romp", 22
    ),
    "trace": Layout(
        lambda f, p: files.objects(f / "clip.npz", {"outputs": files.trace_data(p)}), "romp", 22
    ),
    "smplerx": Layout(lambda f, p: files.smplerx(f / "clip", p), "smplerx", names=("0", "1")),
    "bedlam": Layout(
        _bedlam(55), "bedlam-images", names=("seq_000001/rp_3", "seq_000001/rp_8")
    ),
    "bedlam-smpl": Layout(
        _bedlam(22), "bedlam-images", 22, names=("seq_000001/rp_3", "seq_000001/rp_8")
    ),
}  # fmt: skip


def people_of(layout: Layout) -> list[Person]:
    people = two(layout.joints)
    if layout.gaps:
        return people
    return [person(who.name, np.arange(who.frames[0], 14), seed, layout.joints)
            for seed, who in enumerate(people, 1)]  # fmt: skip


def apart(found: hp.Motion, who: Person, name: str) -> float:
    """Largest distance of the skin from the truth in the frames that were written [m]."""
    own = hp.Body.default().vertices(found)[who.frames - who.frames[0]]
    truth = who.vertices() @ axes_of("y").T
    if name == "slahmr":
        # The heading is anybody's guess: the best turn about the vertical, and a move along it.
        turn, move = heading(truth.reshape(-1, 3), own.reshape(-1, 3))
        truth = truth @ turn.T + move
    return float(np.abs(own - truth).max())


def heading(points: np.ndarray, others: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The turn about z and the move along the ground that bring points onto others."""
    a, b = points - points.mean(axis=0), others - others.mean(axis=0)
    angle = np.arctan2((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum(), (a[:, :2] * b[:, :2]).sum())
    turn = rot.rotvec_to_matrix([0.0, 0.0, angle])
    move = others.mean(axis=0) - turn @ points.mean(axis=0)
    move[2] = 0.7  # the floor of the writer is at y = -0.7
    return turn, move


@pytest.mark.parametrize("name", LAYOUTS)
def test_people_are_read_as_they_were_written(tmp_path, name):
    layout = LAYOUTS[name]
    people = people_of(layout)
    path = layout.write(tmp_path, people)
    # Camera formats are moved by the writer's camera; the world has y up in all of them.
    move = np.zeros(3)
    if name in ("phalp", "comotion", "romp", "trace", "smplerx"):
        depth = 30.0 if name in ("phalp", "smplerx") else 3.0
        move = axes_of("-y") @ [0.1, 0.2, depth]
    assert identify(Source(path)).name == layout.format
    several = people if name != "gvhmr" else people[:1]
    for who, called in zip(several, layout.names, strict=False):
        clip = called if len(several) > 1 else None
        motion = quiet(path, clip=clip).motion
        assert motion.fps == layout.rate
        assert len(motion) == who.frames[-1] - who.frames[0] + 1
        shifted = motion.with_frames(motion.translation - move, motion.rotations)
        assert apart(shifted, who, name) < SINGLE
        assert np.abs(motion.betas - np.pad(who.betas, (0, layout.betas - 10))).max() < 1e-6
        part = quiet(path, clip=clip, frames=(2, 6)).motion
        assert np.array_equal(part.rotations, motion.rotations[2:6])


@pytest.mark.parametrize("name", [name for name in LAYOUTS if name != "gvhmr"])
def test_those_who_are_there_together_are_read_together(tmp_path, name):
    layout = LAYOUTS[name]
    people = people_of(layout)
    path = layout.write(tmp_path, people)
    both = quiet(path).motions
    first = max(who.frames[0] for who in people)
    assert [len(motion) for motion in both] == [14 - first, 14 - first]
    for who, called, motion in zip(people, layout.names, both, strict=True):
        alone = quiet(path, clip=called).motion
        assert np.array_equal(motion.translation, alone.translation[first - who.frames[0] :])


@pytest.mark.parametrize("name", LAYOUTS)
def test_what_is_invented_is_said_once_and_kept(tmp_path, name):
    path = LAYOUTS[name].write(tmp_path, people_of(LAYOUTS[name]))
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        sequence = hp.load_sequence(path)
    assert len(said) == 1
    text = str(said[0].message)
    assert text.startswith(str(path))
    if name == "mcs":
        return  # a file of the codec says all
    invented = sequence.motions[0].origin.fields["invented"]
    assert all(told in text for told in invented.values())
    stated = ("bedlam", "bedlam-smpl", "slahmr")
    assert ("fps" in invented) == (name not in stated)
    assert ("world" in invented) == (name in ("phalp", "comotion", "romp", "trace", "smplerx"))
    again = quiet(path, fps=50.0)
    assert "fps" not in again.motions[0].origin.fields["invented"]
    assert again.motions[0].fps == 50.0


def test_gvhmr_of_a_camera_alone(tmp_path):
    who = person("3", np.arange(9), 1, 22)
    data = files.gvhmr_data(who)
    del data["smpl_params_global"]
    with pytest.warns(HalfPhysicsWarning, match="frame of the camera.*turned upright"):
        motion = hp.load_sequence(torch_dict(tmp_path / "a.pt", data)).motion
    move = axes_of("-y") @ [0.1, 0.2, 3.0]
    assert apart(motion.with_frames(motion.translation - move, motion.rotations), who, "") < SINGLE


def test_the_users_model_has_the_pelvis_and_the_hands(tmp_path):
    """WHAM's hips and GVHMR's relaxed hands are in the model file."""
    content = model_fields("smpl")
    model = write_npz(tmp_path / "SMPL_NEUTRAL.npz", content)
    who = person("3", np.arange(9), 1, 22)
    data = files.wham_data([who])
    path = files.joblib_file(tmp_path / "wham_output.pkl", data)
    motion = quiet(path, model=model).motion
    rest = content["J_regressor"] @ (
        content["v_template"] + content["shapedirs"][:, :, :10] @ motion.betas
    )
    between = rest[0] + rot.rotate(rot.exp(who.rotations[:, 0]), rest[1:3].mean(axis=0) - rest[0])
    found = between + motion.translation @ axes_of("y")  # in the axes of the file
    assert np.abs(found - data[3]["trans_world"]).max() < SINGLE
    content = model_fields("smplx")
    model = write_npz(tmp_path / "SMPLX_NEUTRAL.npz", content)
    motion = quiet(files.gvhmr(tmp_path / "a.pt", who), model=model).motion
    assert np.abs(motion.rotations[:, 25:40].reshape(-1, 45) - content["hands_meanl"]).max() < 1e-9
    flat = quiet(tmp_path / "a.pt", model=model, hands="flat").motion
    assert not flat.rotations[:, 25:].any()


def test_betas_that_vary_a_lot_are_told(tmp_path):
    data = files.wham_data([person("3", np.arange(9), 1, 22)])
    data[3]["betas"] = files.single(np.linspace(-2, 2, 9)[:, None] * np.ones(10))
    path = files.joblib_file(tmp_path / "wham_output.pkl", data)
    with pytest.warns(HalfPhysicsWarning, match=r"shape changes over the frames, by up to 2"):
        motion = hp.load_sequence(path).motion
    assert np.abs(motion.betas).max() < 1e-6


def test_a_track_of_tram_alone_and_without_a_camera(tmp_path):
    people = two(22)
    folder = files.tram(tmp_path / "clip", people)
    track = folder / "hps" / "hps_track_1.npy"
    assert apart(quiet(track).motion, people[1], "") < SINGLE
    assert len(quiet(folder / "hps").motions) == 2
    (folder / "camera.npy").unlink()
    with pytest.warns(HalfPhysicsWarning, match="frame of the camera"):
        hp.load_sequence(track)


def test_prompthmr_of_a_camera_alone(tmp_path):
    who = person("3", np.arange(9), 1)
    data = files.prompthmr_data([who])
    del data["people"][3]["smplx_world"]
    motion = quiet(files.joblib_file(tmp_path / "a.pkl", data)).motion
    move = axes_of("-y") @ [0.1, 0.2, 3.0]
    assert apart(motion.with_frames(motion.translation - move, motion.rotations), who, "") < SINGLE


@pytest.mark.parametrize("down", [True, False])
@pytest.mark.parametrize("floor", [-0.7, 5.0])
def test_the_floor_of_slahmr_is_the_ground(tmp_path, floor, down):
    """Below the camera or above it, in a world with y down or, by how people stand, with y up."""
    who = person("0", np.arange(14), 1, 22)
    turn = rot.rotvec_to_matrix([0.25, 0.1, -0.2]) @ (files.DOWN if down else np.eye(3))
    data = files.slahmr_data([who], floor, (turn, np.array([0.2, 0.4, 3.0])))
    path = tmp_path / "a_world_results.npz"
    np.savez(path, **data)
    heights = hp.Body.default().vertices(quiet(path).motion)[..., 2]
    assert np.abs(heights - (who.vertices()[..., 1] - floor)).max() < SINGLE
    del data["floor_plane"]
    np.savez(path, **data)
    with pytest.warns(HalfPhysicsWarning, match="frame of the camera"):
        hp.load_sequence(path)


def test_romp_without_tracks_and_of_one_image(tmp_path):
    people = [person("0", np.arange(2, 14), 1, 22), person("1", np.arange(2, 14), 2, 22)]
    video = files.romp_video(people)
    path = files.objects(tmp_path / "video_results.npz", {"results": video["results"]})
    with pytest.warns(HalfPhysicsWarning, match="numbered by their order in each frame"):
        both = hp.load_sequence(path).motions
    move = axes_of("-y") @ [0.1, 0.2, 3.0]
    for who, motion in zip(people, both, strict=True):
        shifted = motion.with_frames(motion.translation - move, motion.rotations)
        assert np.abs(shifted.rotations - quiet(path, clip=who.name).motion.rotations).max() == 0.0
        assert apart(shifted, who, "") < SINGLE
    image = video["results"]["00000005.png"]
    path = files.objects(tmp_path / "image.npz", {"results": image})
    with pytest.warns(HalfPhysicsWarning, match="single frame"):
        held = hp.load_sequence(path).motions
    assert [len(motion) for motion in held] == [2, 2]
    assert np.array_equal(held[0].rotations[0], held[0].rotations[1])


def test_a_folder_of_a_person_and_frames_missing(tmp_path):
    folder = files.smplerx(tmp_path / "clip", two())
    assert len(quiet(folder / "smplx").motions) == 2


# -- wrong files -------------------------------------------------------------------------------


def _spoilt(make: Callable[[], dict], where: tuple, value) -> dict:
    data = make()
    inner = data
    for key in where[:-1]:
        inner = inner[key]
    if value is None:
        del inner[where[-1]]
    else:
        inner[where[-1]] = value(inner[where[-1]]) if callable(value) else value
    return data


def _nan(array):
    array = np.array(array)
    array.reshape(-1)[1] = np.nan
    return array


def _short(array):
    return array[:-2]


def _wide(array):
    return np.concatenate([array, array], axis=-1)


def _one() -> list[Person]:
    return [person("3", np.arange(9), 1, 22)]


GVHMR = ("a.pt", lambda: files.gvhmr_data(_one()[0]), torch_dict)
WHAM = ("a.pkl", lambda: files.wham_data(_one()), files.joblib_file)
PROMPT = ("a.pkl", lambda: files.prompthmr_data(_one()), files.joblib_file)
PHALP = ("a.pkl", lambda: files.phalp_data(_one()), files.joblib_file)
COMOTION = ("a.pt", lambda: files.comotion_data(_one()), torch_dict)
TRAM = ("a.npy", lambda: files.tram_data(_one()[0]), files.tram_track)
TRACE = ("a.npz", lambda: {"outputs": files.trace_data(_one())}, files.objects)
ROMP = ("a.npz", lambda: files.romp_video(_one()), files.objects)


def _savez(path: Path, data: dict) -> Path:
    np.savez(path, **data)
    return path


SLAHMR = ("a.npz", lambda: files.slahmr_data(_one()), _savez)
BEDLAM = ("a.npz", lambda: files.bedlam_data(_one()), _savez)
_GLOBAL = "smpl_params_global"
_IMAGE = "outputs/_DEMO/clip/img/000003.jpg"

WRONG = {
    "gvhmr: no translation": (GVHMR, (_GLOBAL, "transl"), None, "'transl' is missing"),
    "gvhmr: no dict": (GVHMR, (_GLOBAL,), 3.0, "expected a dict of tensors"),
    "gvhmr: wide body": (GVHMR, (_GLOBAL, "body_pose"), _wide, "'body_pose'.*expected"),
    "gvhmr: NaN": (GVHMR, (_GLOBAL, "transl"), _nan, "'transl'.*NaN"),
    "gvhmr: short": (GVHMR, (_GLOBAL, "body_pose"), _short, "different length"),
    "gvhmr: betas": (GVHMR, (_GLOBAL, "betas"), _short, "'betas'.*expected"),
    "wham: no place": (WHAM, (3, "trans_world"), None, "'trans_world' is missing"),
    "wham: NaN": (WHAM, (3, "pose_world"), _nan, "'pose_world'.*NaN"),
    "wham: wide": (WHAM, (3, "pose_world"), _wide, "'pose_world'.*expected"),
    "wham: short": (WHAM, (3, "trans_world"), _short, "different length"),
    "wham: frames twice": (WHAM, (3, "frame_ids"), np.full(9, 4), "do not increase"),
    "wham: frames of text": (WHAM, (3, "frame_ids"), np.array(["a"] * 9), "frame numbers"),
    "wham: frames apart": (WHAM, (3, "frame_ids"), np.arange(9) * 10**8, "numbers of one video"),
    "wham: fewer numbers": (WHAM, (3, "frame_ids"), _short, "different length"),
    "prompt: nobody": (PROMPT, ("people",), {}, "found nobody"),
    "prompt: no frames": (PROMPT, ("people", 3, "frames"), None, "'frames' is missing"),
    "prompt: no pose": (
        PROMPT, ("people", 3, "smplx_world", "pose"), None, "'pose' is missing"),
    "prompt: narrow": (
        PROMPT, ("people", 3, "smplx_world", "pose"), lambda a: a[:, :72], "'pose'.*expected"),
    "phalp: fewer cameras": (PHALP, (_IMAGE, "camera"), [], "expected the same number"),
    "phalp: no pose": (
        PHALP, (_IMAGE, "smpl", 0, "body_pose"), None, "'smpl'.*body_pose.*expected"),
    "phalp: vectors": (
        PHALP, (_IMAGE, "smpl", 0, "body_pose"), np.zeros(69), "'smpl'.*expected"),
    "phalp: no rotation": (
        PHALP, (_IMAGE, "smpl", 0, "body_pose"), lambda a: 2 * a, "is no rotation"),
    "phalp: a frame of nothing": (PHALP, (_IMAGE,), 3, "expected fields tid"),
    "comotion: no pose": (COMOTION, ("pose",), None, "'pose' is missing"),
    "comotion: short": (COMOTION, ("trans",), _short, "different length"),
    "comotion: NaN": (COMOTION, ("pose",), _nan, "'pose'.*NaN"),
    "tram: no frames": (TRAM, ("frame",), None, "'frame' is missing"),
    "tram: vectors": (TRAM, ("pred_rotmat",), lambda a: a[..., 0], "'pred_rotmat'.*expected"),
    "tram: no rotation": (TRAM, ("pred_rotmat",), lambda a: a * 0, "is no rotation"),
    "tram: wide": (TRAM, ("pred_trans",), _wide, "'pred_trans'.*expected"),
    "slahmr: nobody": (SLAHMR, ("trans",), lambda a: a[:0], "'trans'.*of people and frames"),
    "slahmr: NaN": (SLAHMR, ("trans",), _nan, "'trans'.*NaN"),
    "slahmr: short": (SLAHMR, ("pose_body",), lambda a: a[:, :-2], "'pose_body'.*expected"),
    "slahmr: no floor": (SLAHMR, ("floor_plane",), np.zeros((1, 3)), "'floor_plane'"),
    "trace: short": (TRACE, ("outputs", "track_ids"), _short, "different length"),
    "trace: no place": (TRACE, ("outputs", "world_global_rots"), _wide, "world_global_rots"),
    "romp: ragged": (
        ROMP, ("sequence_results", 3, "smpl_thetas", 2), np.zeros(3), "'smpl_thetas'.*same shape"),
    "romp: no numbers": (ROMP, ("sequence_results", 3, "frame_id"), None, "'frame_id' is missing"),
    "bedlam: narrow": (BEDLAM, ("pose_world",), lambda a: a[:, :66], "'pose_world'.*expected"),
    "bedlam: no number": (BEDLAM, ("imgname",), np.array(["a.png"] * 9), "'imgname'"),
    "bedlam: short": (BEDLAM, ("trans_world",), _short, "different length"),
}  # fmt: skip


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_file_ends_in_one_message(tmp_path, name):
    (file, make, write), where, value, message = WRONG[name]
    path = write(tmp_path / file, _spoilt(make, where, value))
    refused(path, message)


MCS = {
    "no base64": (("buffers", 0, "uri"), "data:x;base64,&&&", "no base64"),
    "another file": (("buffers", 0, "uri"), "../secret.bin", "in another file"),
    "no buffer": (("bufferViews", 0, "buffer"), 7, "bytes are not found"),
    "no view": (("bufferViews",), None, "bytes are not found"),
    "at infinity": (("bufferViews", 0, "byteOffset"), float("inf"), "bytes are not found"),
    "too long": (("bufferViews", 0, "byteLength"), 10**9, "expected 1000000000"),
    "cut": (("bufferViews", 0, "byteLength"), 300, "damaged or truncated"),
    "no presence": (
        ("scenes", 0, "extensions", "MC_scene_description", "smpl_bodies", 0, "frame_presence"),
        "all", "frame_presence"),
    "no bodies": (
        ("scenes", 0, "extensions", "MC_scene_description", "smpl_bodies"), None, "smpl_bodies"),
    "nobody": (
        ("scenes", 0, "extensions", "MC_scene_description", "smpl_bodies"), [], "found nobody"),
}  # fmt: skip


@pytest.mark.parametrize("name", MCS)
def test_a_wrong_mcs_ends_in_one_message(tmp_path, name):
    where, value, message = MCS[name]
    data = _spoilt(lambda: files.mcs_data(tmp_path, _one()), where, value)
    path = tmp_path / "a.mcs"
    path.write_text(json.dumps(data))
    refused(path, message)


def test_json_that_is_cut_nested_or_huge(tmp_path, monkeypatch):
    path = files.mcs(tmp_path / "a.mcs", _one())
    text = path.read_text()
    path.write_text(text[: len(text) // 2])
    refused(path, "not readable as JSON")
    path.write_text("[" * 100_000)
    refused(path, "not readable as JSON")
    with path.open("wb") as handle:
        handle.write(b"{")
        handle.truncate(2**30)
    refused(path, "1024 MiB, expected at most 64 MiB")


def test_a_camera_that_does_not_fit(tmp_path):
    folder = files.tram(tmp_path / "clip", _one())
    camera = {"world_cam_R": np.tile(np.eye(3), (4, 1, 1)), "world_cam_T": np.zeros((4, 3))}
    np.save(folder / "camera.npy", np.array(camera, dtype=object), allow_pickle=True)
    refused(folder / "hps" / "hps_track_0.npy", "within the 4 frames of camera")
    np.save(folder / "camera.npy", np.array({"a": 1}, dtype=object), allow_pickle=True)
    with pytest.raises(hp.HalfPhysicsError, match=r"camera\.npy: expected fields world_cam_R"):
        hp.Motion.load(folder)


def test_tracks_that_do_not_fit(tmp_path):
    path = _savez(tmp_path / "a.npz", files.slahmr_data(_one()))
    (tmp_path / "track_info.json").write_text('{"tracks": {"1": {"index": 0}}}')
    with pytest.raises(hp.HalfPhysicsError, match=r"track_info\.json: expected tracks"):
        hp.Motion.load(path)


@pytest.mark.parametrize("kind", [GVHMR, WHAM, PHALP, COMOTION, TRAM, ROMP, SLAHMR])
def test_broken_bytes_end_in_messages(tmp_path, kind):
    file, make, write = kind
    broken_bytes_are_refused(write(tmp_path / file, make()))


def test_nothing_hostile_is_run(tmp_path):
    mark = tmp_path / "was_run"
    data = {"id": np.arange(3), "frame_idx": np.arange(3), "pose": Boom(mark)}
    (tmp_path / "a.pkl").write_bytes(pickle.dumps(data))
    refused(tmp_path / "a.pkl", "unsafe or unknown content")
    npy_of(tmp_path / "b.npy", {"pred_rotmat": Boom(mark), "frame": Inline(np.arange(3))})
    refused(tmp_path / "b.npy", "unsafe or unknown content")
    np.savez(tmp_path / "c.npz", results=np.array({"smpl_thetas": Boom(mark)}, dtype=object))
    refused(tmp_path / "c.npz", "unsafe or unknown content")
    path = tmp_path / "d.pkl"
    path.write_bytes(pickled({"people": {1: {"smplx_world": Boom(mark)}}}))
    refused(path, "unsafe or unknown content")
    assert not mark.exists()


def test_frames_are_in_the_order_of_their_numbers(tmp_path):
    """As ffmpeg names them: frame10 comes after frame2."""
    rows = [row for row in files.romp_rows([person("3", np.arange(14), 1, 22)]) if row]
    for number, row in enumerate(rows):
        row["cam_trans"] = np.array([[0.01 * number, 0.2, 3.0]])
        row.pop("track_ids")
    named = {f"frame{number}.png": row for number, row in enumerate(rows)}
    path = files.objects(tmp_path / "video_results.npz", {"results": named})
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", HalfPhysicsWarning)
        motion = hp.Motion.load(path)
    along = motion.translation - motion.translation[0]
    assert len(motion) > 10
    np.testing.assert_allclose(np.abs(along).max(axis=1), 0.01 * np.arange(len(motion)), atol=1e-3)
