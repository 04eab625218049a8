"""SAM 3D Body: a made-up person on MHR's skeleton comes back, in every way in which it is saved."""

from __future__ import annotations

import json
import pickle
import warnings

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.formats import Source, identify
from halfphysics.formats.datasets.shape_from_joints import world_turns
from halfphysics.motion.skeleton import JOINT_INDEX
from support.files import sam3d_files as files
from support.files.dumps import npy_of
from support.files.layouts import quiet
from support.files.sam3d_files import BONES, known, video
from support.files.wrong_files import Boom, broken_bytes_are_refused, refused

#: Joints of arms and legs are met to this, mean over joints and frames [m].
MET, MET_POINTS, MET_FINGERS = 3e-3, 8e-3, 5e-3
#: World rotations differ by less, medians over the frames [degrees]: the forms of the two bodies'
#: heads, soles and hips differ by as much. A straight limb's turn about itself is not in places.
TURNED = {"pelvis": 5.0, "head": 2.0, "left_ankle": 6.0, "right_ankle": 6.0, "left_wrist": 3.0,
          "left_foot": 5.0, "left_elbow": 8.0, "left_hip": 15.0}  # fmt: skip
LIMBS = ("upleg", "lowleg", "foot", "ball", "uparm", "lowarm", "wrist")
#: From y up to z up.
UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
#: Two people 2 m apart.
LEFT, RIGHT = (-1.0, 0.4, 4.0), (1.0, 0.4, 4.5)


def saved(path, content):
    path.write_bytes(pickle.dumps(content))
    return path


def without(content, *keys):
    return [[{k: v for k, v in one.items() if k not in keys} for one in each] for each in content]


def limbs(sequence, who, person=0):
    """Distances of joints of arms and legs from where they were written [m]."""
    motion, body = sequence.motions[person], sequence.bodies[person]
    own = body.joints(motion)[who.frames - who.frames[0]]
    names = [f"{side}_{name}" for side in "lr" for name in LIMBS]
    smplx = [JOINT_INDEX[BONES[name][2]] for name in names]
    truth = np.stack([who.place(name) for name in names], axis=1)
    return np.linalg.norm(own[:, smplx] - truth, axis=2)


def turned(motion, who, joint):
    """By how much a joint's rotation in the world differs from what it was (n,) [degrees]."""
    truth = rot.from_matrix(UP @ who.turns[joint])
    own = world_turns(motion.rotations)[who.frames - who.frames[0], JOINT_INDEX[joint]]
    return np.degrees(np.linalg.norm(rot.log(rot.multiply(rot.conjugate(truth), own)), axis=1))


def test_a_person_comes_back(tmp_path):
    who = known()
    path = saved(tmp_path / "a.pkl", video(who))
    assert identify(Source(path)).name == "sam3d-body"
    with pytest.warns(hp.HalfPhysicsWarning) as told:
        sequence = hp.load_sequence(path)
    assert len(told) == 1
    invented = sequence.motion.origin.fields["invented"]
    assert set(invented) == {"fps", "world", "floor", "betas", "rotations"}
    assert all(text in str(told[0].message) for text in invented.values())
    assert len(sequence.motion) == len(who.frames)
    assert sequence.motion.fps == 30.0
    assert limbs(sequence, who).mean() < MET
    for joint, most in TURNED.items():
        off = turned(sequence.motion, who, joint)
        assert np.median(off) < most, joint
        assert off.max() < 40.0, joint
    fingers = [n for n in BONES if n[-1] in "123" and "spine" not in n]
    own = sequence.bodies[0].joints(sequence.motion)[:, [JOINT_INDEX[BONES[n][2]] for n in fingers]]
    off = own - np.stack([who.place(name) for name in fingers], axis=1)
    assert np.linalg.norm(off, axis=2).mean() < MET_FINGERS
    part = quiet(path, frames=(5, 15)).motion
    assert np.array_equal(part.rotations, sequence.motion.rotations[5:15])
    assert quiet(path, fps=25.0).motion.fps == 25.0


def test_the_default_body_has_the_same_rotations_and_longer_legs(tmp_path):
    """A person of the default body's legs in the same picture: all is scaled about the camera."""
    who = known()
    path = saved(tmp_path / "a.pkl", video(who))
    sequence = quiet(path)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        motion = hp.Motion.load(path)
    assert np.array_equal(motion.rotations, sequence.motion.rotations)
    legs = [hp.Body.default(), sequence.bodies[0]]
    long, short = (np.linalg.norm(np.diff(b.rest_joints[[1, 4, 7]], axis=0), axis=1) for b in legs)
    pelvis, own = legs[0].joints(motion)[:, 0], legs[1].joints(sequence.motion)[:, 0]
    assert np.abs(pelvis - own * long.sum() / short.sum()).max() < 1e-6


def test_joints_alone_and_keypoints_alone(tmp_path):
    who = known()
    path = saved(tmp_path / "a.pkl", without(video(who), "pred_keypoints_3d"))
    sequence = quiet(path)
    assert limbs(sequence, who).mean() < MET
    assert "head" in sequence.motion.origin.fields["invented"]
    path = saved(tmp_path / "b.pkl", without(video(who), "pred_joint_coords"))
    sequence = quiet(path)
    assert limbs(sequence, who).mean() < MET_POINTS
    assert np.median(turned(sequence.motion, who, "head")) < TURNED["head"]
    assert np.median(turned(sequence.motion, who, "pelvis")) < 10.0  # no point of the spine


def test_sizes_guessed_anew_in_every_frame_become_one(tmp_path):
    sizes = 1.0 + 0.08 * np.sin(np.arange(40) * 1.7)
    who, one = known(sizes=sizes), known()
    path = saved(tmp_path / "a.pkl", video(who))
    with pytest.warns(hp.HalfPhysicsWarning, match=r"one size of the person.*16%"):
        sequence = hp.load_sequence(path)
    middle = float(np.median(sizes))
    assert abs(sequence.bodies[0].stature / quiet(saved(path, video(one))).bodies[0].stature
               / middle - 1.0) < 0.01  # fmt: skip
    own = sequence.bodies[0].joints(sequence.motion)[:, JOINT_INDEX["left_wrist"]]
    assert np.abs(own - middle * one.place("l_wrist")).max() < 0.02


@pytest.mark.parametrize("tracked", [False, True])
def test_several_people_gaps_and_who_is_who(tmp_path, tracked):
    """Their order in the frames changes, and the first is not seen in two of the frames."""
    first = known([n for n in range(2, 30) if n not in (8, 9)], 1, LEFT)
    second = known(range(6, 30), 2, RIGHT)
    content = video(first, second)
    assert [len(content[number]) for number in (0, 9, 10)] == [0, 1, 2]
    names = ("0", "1")
    if tracked:
        names = ("7", "3")
        for frame in content:
            for one in frame:
                one["person_id"] = 7 if one["pred_cam_t"][0] < 0.0 else 3
    path = saved(tmp_path / "a.pkl", content)
    both = quiet(path)
    assert [len(motion) for motion in both.motions] == [24, 24]
    assert len({id(body) for body in both.bodies}) == 2
    for who, name, motion in zip((first, second), names, both.motions, strict=True):
        alone = quiet(path, clip=name)
        assert limbs(alone, who).mean() < MET
        begin = max(0, 6 - who.frames[0])
        assert np.array_equal(motion.translation, alone.motion.translation[begin:])
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        hp.load_sequence(path)
    assert ("followed from frame to frame" in str(told[0].message)) is not tracked


def _stacked(folder, who):
    one = who.outputs(0)
    keys = ("pred_joint_coords", "pred_keypoints_3d", "pred_cam_t")
    rows = {key: np.stack([who.outputs(k)[key] for k in range(len(who.frames))]) for key in keys}
    np.savez(folder / "a.npz", frame_idx=who.frames, **rows, focal_length=one["focal_length"])
    return folder / "a.npz"


def _listed(value):
    return value.tolist() if hasattr(value, "tolist") else value


def _json(folder, who):
    frames = [
        {"frame": f"frame_{n:06d}.jpg", "outputs": [{k: _listed(v) for k, v in one.items()}]}
        for n, (one,) in zip(who.frames, (f for f in video(who) if f), strict=True)
    ]
    content = {"video_info": {"fps": 25.0}, "frames": frames}
    (folder / "video_outputs.json").write_text(json.dumps(content))
    return folder / "video_outputs.json"


def _folder(suffix):
    def write(folder, who):
        inside = folder / "out"
        inside.mkdir()
        for row, number in enumerate(who.frames):
            path, one = inside / f"img_{number:05d}{suffix}", who.outputs(row)
            del one["mask"]
            if suffix == ".npz" or suffix == "_subj00.npz":
                np.savez(path, **one)
            elif suffix == ".npy":
                np.save(path, np.array([one], dtype=object), allow_pickle=True)
            else:
                path.write_bytes(pickle.dumps([one]))
        return inside

    return write


WAYS = {
    "list of lists": lambda f, w: saved(f / "a.pkl", video(w)),
    "dict of names": lambda f, w: saved(
        f / "a.pkl", {f"{n:06d}.jpg": people for n, people in enumerate(video(w))}
    ),
    "one person's frames": lambda f, w: saved(f / "a.pkl", [p for each in video(w) for p in each]),
    "npy": lambda f, w: npy_of(f / "a.npy", video(w)),
    "npz of objects": lambda f, w: _objects(f / "a.npz", video(w)),
    "arrays": _stacked,
    "json": _json,
    "folder of npz": _folder(".npz"),
    "folder of npz for each person": _folder("_subj00.npz"),
    "folder of npy": _folder(".npy"),
    "folder of pkl": _folder(".pkl"),
}


def _objects(path, content):
    array = np.empty(len(content), dtype=object)
    array[:] = content
    np.savez(path, outputs=array)
    return path


@pytest.mark.parametrize("way", WAYS)
def test_every_way_to_save_it(tmp_path, way):
    who = known(range(12))
    path = WAYS[way](tmp_path, who)
    assert identify(Source(path)).name == "sam3d-body"
    sequence = quiet(path)
    assert len(sequence.motions) == 1
    assert len(sequence.motion) == 12
    assert sequence.motion.fps == (25.0 if way == "json" else 30.0)
    assert limbs(sequence, who).mean() < MET


def test_an_image(tmp_path):
    """People of one image: a list, or a file for each; held for two frames."""
    people = [known(range(1), 1, LEFT), known(range(1), 2, RIGHT)]
    path = saved(tmp_path / "a.pkl", [who.outputs(0) for who in people])
    for k, who in enumerate(people):
        one = who.outputs(0)
        del one["mask"]
        (tmp_path / "out").mkdir(exist_ok=True)
        np.savez(tmp_path / "out" / f"img_subj{k:02d}.npz", **one)
    for source in (path, tmp_path / "out"):
        both = quiet(source)
        assert [len(motion) for motion in both.motions] == [2, 2]
        for k, who in enumerate(people):
            assert limbs(both, who, k).mean() < MET


def test_millimetres_and_a_mirror_image(tmp_path):
    content = video(known())
    for frame in content:
        for one in frame:
            for key in ("pred_joint_coords", "pred_keypoints_3d", "pred_cam_t"):
                one[key] = 1000.0 * one[key]
    path = saved(tmp_path / "a.pkl", content)
    with pytest.warns(hp.HalfPhysicsWarning, match="unit mm"):
        sequence = hp.load_sequence(path)
    assert limbs(sequence, known()).mean() < MET
    for frame in content:
        for one in frame:
            for key in ("pred_joint_coords", "pred_keypoints_3d", "pred_cam_t"):
                one[key] = 0.001 * one[key] * [-1.0, 1.0, 1.0]
    path = saved(tmp_path / "b.pkl", content)
    with pytest.warns(hp.HalfPhysicsWarning, match="mirror image"):
        sequence = hp.load_sequence(path)
    assert limbs(sequence, known()).mean() < MET


def _changed(key, how):
    def change(content):
        for frame in content:
            for one in frame:
                one[key] = how(one[key])

    return change


def _dropped(*keys):
    def change(content):
        for frame in content:
            for one in frame:
                for key in keys:
                    one.pop(key)

    return change


def _nan(content):
    content[3][0]["pred_joint_coords"][7, 1] = np.nan


def _stranger(content):
    content[2] = ["nobody"]


J, P, C = "pred_joint_coords", "pred_keypoints_3d", "pred_cam_t"
WRONG = {
    "no places": (_dropped(J, P), "pose of MHR.*convert_sam3d_output_to_smpl"),
    "no camera": (_dropped(C), "'pred_cam_t' is missing"),
    "70 joints": (_changed(J, lambda a: a[:70]), r"'pred_joint_coords'.*\(70, 3\).*\(127, 3\)"),
    "two columns": (_changed(P, lambda a: a[:, :2]), r"'pred_keypoints_3d'.*\(70, 2\)"),
    "text": (_changed(C, lambda a: ["a", "b", "c"]), "'pred_cam_t'.*expected numbers"),
    "nothing": (_changed(J, lambda a: None), "'pred_joint_coords'.*expected numbers"),
    "a frame of others": (_stranger, "found no people of SAM 3D Body"),
    "NaN": (_nan, "'pred_joint_coords'.*NaN.*frame 3"),
    "infinite": (_changed(C, lambda a: a + np.inf), "NaN, infinite or over"),
    "far": (
        _changed(P, lambda a: np.full(a.shape, 1e200)),
        "'pred_keypoints_3d': NaN, infinite or over",
    ),
    "ragged": (_changed(J, lambda a: [[1.0, 2.0], [3.0]]), "'pred_joint_coords'.*expected numbers"),
    "zeros": (_changed(J, lambda a: 0.0 * a), "no joint positions of a person"),
    "giants": (_changed(J, lambda a: 30.0 * a), "no joint positions of a person: found legs"),
    "shuffled": (
        _changed(J, lambda a: a[np.random.default_rng(0).permutation(127)]),
        "joint positions",
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_wrong_files(tmp_path, name):
    change, message = WRONG[name]
    content = video(known(range(8)))
    change(content)
    refused(saved(tmp_path / "a.pkl", content), message)


@pytest.mark.parametrize(
    "field",
    [
        {"pred_cam_t": None},
        {"pred_cam_t": 3.0},
        {"pred_keypoints_3d": [[1.0, 2.0], [3.0]]},
        {"frame_idx": [0, np.nan, 2, 3, 4, 5]},
        {"frame_idx": [0, np.inf, 2, 3, 4, 5]},
        {"frame_idx": [[0, 1], [2]]},
    ],
)
def test_damaged_fields_of_stacked_frames(tmp_path, field):
    people = [frame[0] for frame in video(known(range(6)))]
    stacked = {key: np.stack([one[key] for one in people]) for key in (J, P, C)}
    refused(saved(tmp_path / "a.pkl", {**stacked, **field}), "expected")


def test_wrong_arrays_and_nobody(tmp_path):
    who = known(range(6))
    with np.load(_stacked(tmp_path, who)) as data:
        fields = dict(data)
    fields["pred_cam_t"] = fields["pred_cam_t"][:4]
    np.savez(tmp_path / "b.npz", **fields)
    refused(tmp_path / "b.npz", "different length")
    refused(saved(tmp_path / "c.pkl", [[], []]), "no known motion format")
    broken_bytes_are_refused(saved(tmp_path / "d.pkl", video(known(range(2)))))


def test_nothing_hostile_is_run(tmp_path):
    mark = tmp_path / "was_run"
    content = video(known(range(3)))
    content[1][0]["mask"] = Boom(mark)
    refused(saved(tmp_path / "a.pkl", content), "unsafe or unknown content")
    np.savez(tmp_path / "b.npz", outputs=np.array([Boom(mark), 1], dtype=object))
    refused(tmp_path / "b.npz", "unsafe or unknown content")
    assert not mark.exists()


def test_the_writer_flips_as_mhr_does():
    """The camera's y is down: a head is above the feet, so its y is smaller."""
    one = known(range(1)).outputs(0)
    joints = one["pred_joint_coords"]
    assert joints[files.MHR["c_head"], 1] < joints[files.MHR["l_foot"], 1]
