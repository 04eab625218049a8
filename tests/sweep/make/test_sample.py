"""Samples: the contents of the files, their order, and equal bytes each time."""

from __future__ import annotations

import json
import time
from types import SimpleNamespace

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.motion.skeleton import JOINT_INDEX, SMPLH_JOINTS
from halfphysics.sweep.make.sample import files_of
from support.sweeps.sweep_shards import arrays_of


def labels(frames, vertices):
    body = np.zeros((frames, vertices), np.int8)
    body[2:, 40:90] = 21
    return SimpleNamespace(arrays=lambda: {"body": body, "threshold_m": np.array(0.002)})


@pytest.fixture(scope="module")
def result():
    """A short push against a door, by a person with moving jaw and eyes."""
    sequence = hp.scenarios.load("push_door")
    motion = sequence.motions[0][:12]
    rotations = np.array(motion.rotations)
    rotations[:, 22:25, 0] = np.linspace(0.1, 0.3, 12)[:, None]
    motion = hp.Motion(motion.translation, rotations, motion.fps)
    return hp.simulate(motion, sequence.scene, body=sequence.body, settings=sequence.settings)


@pytest.fixture(scope="module")
def files(result):
    return files_of(result, labels(12, 100), {"number": 7, "factors": {"mass": 2.5}})


def test_a_person_is_as_in_interact(result, files):
    """Its readers take body, left and right hand from these columns (and jaw, eyes are extra)."""
    human, motion = arrays_of(files["human.npz"]), result.motion
    poses = human["poses"]
    assert poses.shape == (12, 156)
    for name, joint in (("pelvis", 0), ("left_hand", 22), ("right_hand", 37)):
        columns = slice(3 * joint, 3 * joint + 3)
        first = {"pelvis": "pelvis", "left_hand": "left_index1", "right_hand": "right_index1"}
        expected = motion.rotations[:, JOINT_INDEX[first[name]]]
        np.testing.assert_array_equal(poses[:, columns], expected)
    np.testing.assert_array_equal(human["trans"], motion.translation)
    np.testing.assert_array_equal(human["betas"], result.people[0].body.betas)
    assert str(human["gender"]) == "neutral"
    assert human["gender"].dtype.kind == "U"  # no pickle


def test_a_person_can_be_read_as_a_motion(result, files, tmp_path):
    (tmp_path / "human.npz").write_bytes(files["human.npz"])
    motion = hp.Motion.load(tmp_path / "human.npz")
    np.testing.assert_array_equal(motion.translation, result.motion.translation)
    np.testing.assert_array_equal(motion.rotations, result.motion.rotations)
    assert (motion.fps, motion.model) == (result.motion.fps, "smplx")
    # Written and read again it is the same, with jaw and eyes.
    motion.save(tmp_path / "again.npz")
    again = hp.Motion.load(tmp_path / "again.npz")
    np.testing.assert_array_equal(again.rotations, motion.rotations)
    assert np.abs(again.rotations[:, 22:25]).max() > 0.05
    changed = motion.with_frames(motion.translation, motion.rotations * 0.5)
    changed.save(tmp_path / "changed.npz")
    half = hp.Motion.load(tmp_path / "changed.npz")
    np.testing.assert_array_equal(half.rotations, changed.rotations)


def test_axes_of_the_file_it_came_from_do_not_matter(result):
    """A motion from a y-up file: the pelvis keeps its place, in the z-up world."""
    from halfphysics.base.axes import axes_of
    from halfphysics.sweep.make.sample import human

    person = result.people[0]
    motion = person.motion.rebased(person.body, up="y")
    turned = SimpleNamespace(motion=motion, body=person.body)
    fields = human(turned)
    np.testing.assert_allclose(fields["trans"], result.motion.translation, atol=1e-14)
    assert not np.array_equal(motion.axes, axes_of("z"))
    plain = hp.Motion(fields["trans"], motion.rotations, motion.fps)
    np.testing.assert_allclose(
        person.body.joints(plain), person.body.joints(result.motion), atol=1e-13
    )


def test_objects(result, files):
    names = list(result.objects)
    made = sorted(name for name in files if name.startswith("object"))
    assert len(made) == len(names)
    for index, name in enumerate(names):
        thing = arrays_of(files["object.npz" if index == 0 else f"object.{index}.npz"])
        assert str(thing["name"]) == name
        track = result.objects[name]
        np.testing.assert_array_equal(thing["trans"], track.position)
        # Rotations to 1e-15: axis-angle and back.
        there = rot.to_matrix(rot.exp(thing["angles"]))
        np.testing.assert_allclose(there, rot.to_matrix(track.quaternion), atol=4e-15)
        joints = [key for key in result.joints if key.split("/")[0] == name.split("/")[0]]
        assert list(thing["joints"]) == joints
        columns = thing["arti"].reshape(12, -1)
        for column, key in zip(columns.T, joints, strict=True):
            np.testing.assert_array_equal(column, result.joints[key])


def test_names_and_order(files):
    objects = [f"object.{k}.npz" if k else "object.npz" for k in range(len(files) - 3)]
    assert list(files) == ["card.json", "human.npz", *objects, "contact.npz"]
    assert json.loads(files["card.json"]) == {"number": 7, "factors": {"mass": 2.5}}


def test_whole_result(result, tmp_path):
    files = files_of(result, labels(12, 100), {}, whole=True)
    (tmp_path / "result.npz").write_bytes(files["result.npz"])
    loaded = hp.Result.load(tmp_path / "result.npz")
    np.testing.assert_array_equal(loaded.motion.rotations, result.motion.rotations)
    np.testing.assert_array_equal(loaded.contacts.impulse, result.contacts.impulse)


def test_the_same_bytes_at_any_time(result, files, monkeypatch):
    monkeypatch.setattr(time, "time", lambda: 2e9)
    monkeypatch.setattr(time, "localtime", lambda *_: time.gmtime(2e9))
    assert files_of(result, labels(12, 100), {"factors": {"mass": 2.5}, "number": 7}) == files


def test_no_number_that_json_has_not(result):
    with pytest.raises(ValueError, match="JSON"):
        files_of(result, labels(12, 100), {"clearance_min": float("inf")})


def test_columns_of_smplh():
    assert len(SMPLH_JOINTS) == 52
    assert SMPLH_JOINTS[22] == JOINT_INDEX["left_index1"]
    assert SMPLH_JOINTS[37] == JOINT_INDEX["right_index1"]


def test_support_is_written_if_wanted(result, files):
    from halfphysics.labels import support_labels

    assert "support.npz" not in files
    one, two = (
        files_of(result, labels(12, 100), {}, support=True)["support.npz"] for _ in range(2)
    )
    assert one == two
    found = arrays_of(one)
    for key, value in support_labels(result).items():
        np.testing.assert_array_equal(found[key], value)
